"""Two bones with cartilage along a path of poses: a table, and maps of the pressure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from fecontact.app.joint.cartilage import cartilage_body
from fecontact.app.joint.knee_angles import OPENSIM, SIDES, GroodSuntay
from fecontact.app.joint.ligament import Ligament
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.layer import ElasticLayer
from fecontact.bodies.pose import Pose, turned
from fecontact.common.arguments import flag, instance, items, mapping, spelled, texts
from fecontact.common.arrays import Array
from fecontact.common.checks import among, array_of, number_array, vector
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, shown
from fecontact.common.files import make_folder
from fecontact.common.material import Material
from fecontact.common.progress import progress_line
from fecontact.common.units import Units
from fecontact.contact.contact import Contact
from fecontact.fem.laws import Law
from fecontact.fem.rigid import COMPONENTS
from fecontact.mesh.layer import Thickness
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.results.case_table import CaseTable
from fecontact.results.resultants import DividingPlane
from fecontact.scene.load_path import LoadPath
from fecontact.scene.scene import Scene
from fecontact.scene.sweep_case import parameters_of

#: Angles (degrees) and translations of a knee in tables.
ANGLES = tuple(f.name for f in fields(GroodSuntay) if f.name != "side")


@spelled
@compact_repr
@dataclass(frozen=True, eq=False)
class Joint:
    """Cartilage on two bones, of which one moves.

    Bones are rigid; each layer is extruded from its bone's surface and tied to it. Strains of a `Material` are small,
    see docs/how-to/joint.md for what that means in cartilage.

    Parameters
    ----------
    moving, fixed : SurfaceMesh
        Surfaces of the bones under the cartilage, each in its own axes; those of the fixed bone are the world's.
    thickness : float, array, callable, SurfaceMesh, or a pair of them
        Of both layers, or a pair for the moving and the fixed bone: a number; values at the bone's points (n_points,);
        a function of points (n, 3); or the free surface of the cartilage, in the bone's axes.
    material : Material or a pair of them
        Or a law of finite strain, such as `NeoHookean`, see docs/how-to/soft-bodies.md.
    layers : int
        Elements through the thickness.
    surfaces : {'bone', 'cartilage'} or a pair of them
        What the surfaces are: those of the bones, or the free ones of the cartilage, from which layers grow inwards.
        Then a surface as `thickness` is that of the bone, facing as the free one does.
    foundation : bool
        Whether layers are elastic foundations instead of solids: each point gives by its own pressure only, with the
        modulus of a layer that cannot strain across, as in OpenSim-JAM (Smith et al., J. Biomech. 73 (2018), 108;
        `ElasticLayer`). Stiffer than a solid layer unless the contact is many times as wide as the layer is thick.
    least : float or a pair of them, optional
        Thickness where surfaces given as `thickness` are nearer, or one of both is missing, see `thickness_between`.
    springs : sequence of Ligament
        Between both bones, see `read_ligaments` and `OpenSimModel.ligaments`.
    friction : float
        Coefficient of friction, see `follow`.
    anatomy : (Pose, Pose) or 'opensim', optional
        Poses of the clinical axes (x to the right of the subject, y forwards, z upwards) in those of the moving bone,
        the femur, and of the fixed one, the tibia; 'opensim' for bones whose x is forwards, y upwards and z to the
        right. With it the table has the angles and translations of `GroodSuntay` after each solution.
    side : {'right', 'left'}
        Of the knee, for these.
    units : (length, force) or (length, force, stress), optional
        Names of the units, for tables and pictures.
    axes : mapping of str to (3,) array, optional
        Names of directions of the fixed bone, for maps, see `Scene`.
    names : (str, str)
        Names of the moving and the fixed bone, for tables and pictures.

    Raises
    ------
    InputError, MeshError
        If a layer cannot be made.

    Examples
    --------
    >>> import fecontact as fc
    >>> flat = fc.SurfaceMesh.of(fc.shapes.block((4.0, 4.0, 1.0), (4, 4, 1)), "top")
    >>> joint = fc.Joint(flat.flipped(), flat, thickness=0.5, material=fc.Material(E=10.0, nu=0.45))
    >>> table = joint.follow([fc.Pose(translation=(0, 0, z)) for z in (1.0, 1.1)], forces=(0, 0, -16.0))
    >>> table.column("mean_pressure").round(9).tolist()
    [1.0, 1.0]
    """

    moving: SurfaceMesh
    fixed: SurfaceMesh
    thickness: Thickness | SurfaceMesh | tuple[Thickness | SurfaceMesh, Thickness | SurfaceMesh]
    material: Material | Law | tuple[Material | Law, Material | Law]
    layers: int = 1
    units: Units | Sequence[str] = ()
    axes: Mapping[str, ArrayLike] | None = None
    names: tuple[str, str] = ("moving", "fixed")
    surfaces: str | tuple[str, str] = "bone"
    foundation: bool = False
    springs: Sequence[Ligament] = ()
    friction: float = 0.0
    anatomy: tuple[Pose, Pose] | str | None = None
    side: str = "right"
    least: float | tuple[float | None, float | None] | None = None

    def __post_init__(self) -> None:
        for kind in _both(self.surfaces):
            among("surfaces of a joint:", kind, ("bone", "cartilage"))
        for ligament in items("the springs of a joint", self.springs, "ligaments"):
            instance("each spring of a joint", ligament, Ligament)
        if flag("foundation", self.foundation):
            for material in _both(self.material):
                instance("the material of an elastic foundation", material, Material)
            if self.springs or self.layers != 1:
                raise InputError(
                    "An elastic foundation has no elements to which ligaments could be fastened, or layers: leave out "
                    "springs= and layers=, or foundation=True.",
                    code="foundation",
                )
        among("side", self.side, SIDES)
        for name in ("moving", "fixed"):
            instance(f"the {name} bone", getattr(self, name), SurfaceMesh)
        for material in _both(self.material):
            instance("the material", material, (Material, Law))
        if len(texts("the names of the bones", self.names)) != 2:
            raise InputError(f"The names are those of the moving and the fixed bone; found {self.names!r}.")
        object.__setattr__(self, "units", Units.of(self.units))

    @cached_property
    def bodies(self) -> tuple[ElasticBody | ElasticLayer, ElasticBody | ElasticLayer]:
        """The moving and the fixed layer."""
        thick, soft, kinds, least = (_both(v) for v in (self.thickness, self.material, self.surfaces, self.least))
        with progress_line("cartilage", None):
            moving, fixed = (
                cartilage_body(
                    surface,
                    thick[k],
                    soft[k],
                    self.layers,
                    self.names[k],
                    free=kinds[k] == "cartilage",
                    foundation=self.foundation,
                    least=least[k],
                )
                for k, surface in enumerate((self.moving, self.fixed))
            )
        return moving, fixed

    @cached_property
    def scene(self) -> Scene:
        """The scene, with the moving bone in the fixed one's axes."""
        contact = Contact(*self.bodies, friction=self.friction)
        springs = [ligament.spring(self.bodies[0]) for ligament in self.springs]
        return Scene(list(self.bodies), [contact], springs, units=self.units, axes=self.axes)

    @cached_property
    def _anatomy(self) -> tuple[Pose, Pose] | None:
        """Poses of the clinical axes in those of the bones."""
        if self.anatomy is None or isinstance(self.anatomy, tuple):
            return self.anatomy
        among("anatomy", self.anatomy, ("opensim",))
        return OPENSIM, OPENSIM

    def follow(
        self,
        poses: Sequence[Pose | ArrayLike],
        forces: ArrayLike | None = None,
        moments: ArrayLike | None = None,
        free: str = "",
        at: ArrayLike | None = None,
        times: ArrayLike | None = None,
        path: str | Path | None = None,
        maps: str | Path | None = None,
        processes: int = 1,
        progress: bool | None = None,
        *,
        parameters: Mapping[str, ArrayLike] | None = None,
        keep: str | Sequence[str] = (),
        split: DividingPlane | tuple[ArrayLike, ArrayLike] | None = None,
        save: str | Path | Sequence[str | Path] | None = None,
    ) -> CaseTable:
        """Solve for the contact in every pose of a path.

        With friction the poses are one path: slip counts from one pose to the next, the first from where it begins.

        Parameters
        ----------
        poses : sequence of Pose or (4, 4) arrays
            Of the moving bone in the fixed one's axes, such as `GroodSuntay.femur`.
        forces : (3,) or (n, 3) array, optional
            On the moving bone, in the fixed one's axes. It moves along each force until the contact carries it;
            without forces it stays in its pose.
        moments : (3,) or (n, 3) array, optional
            On it, about its cartilage's centre of mass.
        free : str, optional
            Further components in which it may move, such as ``"x ry"``. With friction and forces all of them are named.
        at : (3,), optional
            Point of application of the forces in the moving bone's axes; the bone then moves in the components of
            `free` alone, such as ``"z ry"``. By default forces act on the bone as a whole, whose rotation they leave.
        times : (n,) array, optional
            For the table; numbers from 0 otherwise.
        path : str or Path, optional
            File of rows; an interrupted path is resumed from it, see `Scene.sweep` and `Scene.solve_path`.
        maps : str or Path, optional
            Folder for each pose's pressures, as a table of points (.csv) and as a picture (.png).
        processes : int
            Number of poses solved at the same time; 1 with friction.
        parameters : mapping of str to (n,) array, optional
            Further columns of the table, such as the flexion that was given.
        progress, keep, split, save
            As for `Scene.sweep`; the bodies are those of `bodies`, poses are named 0000, 0001, ...

        Raises
        ------
        InputError
            If a pose is no pose, or there are other numbers of poses, forces, moments, times or parameters.
        """
        moving = self.bodies[0]
        path_poses = [_pose(k, pose) for k, pose in enumerate(items("the poses of a joint", poses, "poses"))]
        n = len(path_poses)
        if n == 0:
            raise InputError("A path has at least one pose.", code="no-steps")
        when = np.arange(n) if times is None else number_array("the times of the poses", times)
        if when.shape != (n,):
            raise InputError(f"There are {n} poses and {when.size} times.", code="times-differ")
        loads = {"forces": _for_each("forces", forces, n), "moments": _for_each("moments", moments, n)}
        key = {"forces": moving if at is None else (moving, tuple(vector("the point of application", at).tolist()))}
        cases: list[dict[str, Any]] = []
        for k in range(n):
            case: dict[str, Any] = {what: {key.get(what, moving): r[k]} for what, r in loads.items() if r is not None}
            cases.append(case | ({"free": {moving: free}} if free else {}))
        given = self._columns({"time": np.asarray(when, dtype=float)}, parameters, n)
        if self.friction:
            if ((forces is not None or moments is not None) and not free) or maps or save or processes != 1:
                raise InputError(
                    "With friction poses are followed one after the other: name the components in which loads may move "
                    "the bone, free='z', and leave out maps=, save= and processes= (keep='pressure' keeps maps).",
                    code="path-with-friction",
                )
            found = self._along(path_poses, cases, path=path, progress=progress).table(keep=keep, split=split)
            rows = [{**row, "parameters": p} for row, p in zip(found.rows, given, strict=True)]
            return self._with_angles(replace(found, rows=tuple(rows)), path_poses[:1] * n)
        folder = None if maps is None else make_folder(maps)
        for k, (case, pose) in enumerate(zip(cases, path_poses, strict=True)):
            case |= {"name": f"{k:04d}", "poses": {moving: pose}, "parameters": given[k]}
            if folder is not None:
                case["save"] = [folder / f"{k:04d}.csv", folder / f"{k:04d}.png"]
        table = self.scene.sweep(cases, path, processes=processes, progress=progress, keep=keep, split=split, save=save)
        return self._with_angles(table, path_poses)

    def _columns(
        self, columns: dict[str, Array], more: Mapping[str, ArrayLike] | None, n: int
    ) -> list[dict[str, float]]:
        """Numbers of each pose by the names of their columns."""
        for name, values in mapping("parameters", more).items():
            if name == "time" or (self.anatomy and name in ANGLES) or np.shape(values) != (n,):
                raise InputError(
                    f"The parameter {name!r} is one number for each of {n} poses, and no time or angle of the table.",
                    code="parameters",
                )
            columns[name] = number_array(f"the parameter {name!r}", values)
        return [parameters_of({"parameters": {c: v[k] for c, v in columns.items()}}) for k in range(n)]

    def _along(self, poses: Sequence[Pose], steps: Sequence[dict[str, Any]], **options: Any) -> LoadPath:
        """The poses as load steps with friction, from the first pose on."""
        moving = self.bodies[0]
        start = self.scene.bodies[0].placed(poses[0].translation, rotation=poses[0].rotation)
        scene = Scene(
            [start, self.bodies[1]],
            [Contact(start, self.bodies[1], friction=self.friction)],
            [ligament.spring(start) for ligament in self.springs],
            units=self.units,
            axes=self.axes,
        )
        for step, pose in zip(steps, poses, strict=True):
            free = step["free"][moving].split() if "free" in step else ()
            turn = Rotation.from_matrix(pose.rotation @ poses[0].rotation.T).as_rotvec()
            point = moving.reference_point[None]
            motion = np.append(pose.to_world(point) - poses[0].to_world(point), turn)
            step["motions"] = {start: {c: float(x) for c, x in zip(COMPONENTS, motion, strict=True) if c not in free}}
            for what in ("forces", "moments", "free"):
                step |= {what: {_moved(key, start): v for key, v in step[what].items()}} if what in step else {}
        return scene.solve_path(steps, finite_motion=True, **options)

    def _with_angles(self, table: CaseTable, starts: Sequence[Pose]) -> CaseTable:
        """The table with the clinical angles and translations of the solved poses, if the bones have clinical axes."""
        if self._anatomy is None:
            return table
        femoral, tibial = self._anatomy
        rows = []
        for row, pose in zip(table.rows, starts, strict=True):
            motion = next(b["motion"] for b in row["bodies"] if b["name"] == self.names[0])
            solved = turned(pose, np.array(motion), pose.to_world(self.bodies[0].reference_point[None])[0])
            femur = femoral.then(solved.rotation, solved.translation)
            angles = GroodSuntay.of(tibial.relative_to(femur), self.side)
            figures = {name: getattr(angles, name) for name in ANGLES}
            rows.append({**row, "parameters": {**row["parameters"], **figures}})
        return replace(table, rows=tuple(rows))


def _moved(key: Any, body: Any) -> Any:
    """The key of a load, a body or a body with a point, for the body in another pose."""
    return (body, key[1]) if isinstance(key, tuple) else body


def _both(given: Any) -> tuple[Any, Any]:
    """Values for the moving and the fixed bone."""
    if not isinstance(given, tuple):
        return given, given
    if len(given) != 2:
        raise InputError(f"Expected one value for both bones, or two; found {len(given)}.", code="one-or-two-values")
    return given


def _pose(k: int, given: Pose | ArrayLike) -> Pose:
    """A pose, or a matrix (4, 4) as one."""
    matrix = array_of(given)
    if matrix is None:
        return instance(f"pose {k}, where it is no matrix (4, 4),", cast(Pose, given), Pose)
    if matrix.shape != (4, 4) or not np.array_equal(matrix[3], (0.0, 0.0, 0.0, 1.0)):
        raise InputError(
            f"Pose {k} must be a fecontact.Pose or a matrix (4, 4) whose last row is 0 0 0 1; found {shown(given)}.",
            code="no-pose",
        )
    return Pose(matrix[:3, :3], matrix[:3, 3])


def _for_each(name: str, given: ArrayLike | None, n: int) -> Array | None:
    """Vectors (n, 3), one for each pose, from as many or from one."""
    if given is None:
        return None
    vectors = number_array(f"the {name}", given)
    if vectors.shape not in ((3,), (n, 3)):
        raise InputError(f"The {name} must be one vector (3,) or one for each of {n} poses; found {vectors.shape}.")
    return np.broadcast_to(vectors, (n, 3))
