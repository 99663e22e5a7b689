"""Two bones with cartilage along a path of poses: a table, and maps of the pressure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.app.joint.cartilage import cartilage_body
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import instance, items, texts
from fecontact.common.arrays import Array
from fecontact.common.checks import array_of, number_array, vector
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, shown
from fecontact.common.files import make_folder
from fecontact.common.material import Material
from fecontact.common.units import Units
from fecontact.contact.contact import Contact
from fecontact.fem.laws import Law
from fecontact.mesh.layer import Thickness
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.results.case_table import CaseTable
from fecontact.results.resultants import DividingPlane
from fecontact.scene.scene import Scene


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

    def __post_init__(self) -> None:
        for name in ("moving", "fixed"):
            instance(f"the {name} bone", getattr(self, name), SurfaceMesh)
        for material in _both(self.material):
            instance("the material", material, (Material, Law))
        if len(texts("the names of the bones", self.names)) != 2:
            raise InputError(f"The names are those of the moving and the fixed bone; found {self.names!r}.")
        object.__setattr__(self, "units", Units.of(self.units))

    @cached_property
    def bodies(self) -> tuple[ElasticBody, ElasticBody]:
        """The moving and the fixed layer."""
        thick, soft = _both(self.thickness), _both(self.material)
        return (
            cartilage_body(self.moving, thick[0], soft[0], self.layers, self.names[0]),
            cartilage_body(self.fixed, thick[1], soft[1], self.layers, self.names[1]),
        )

    @cached_property
    def scene(self) -> Scene:
        """The scene, with the moving bone in the fixed one's axes."""
        return Scene(list(self.bodies), [Contact(*self.bodies)], units=self.units, axes=self.axes)

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
        keep: str | Sequence[str] = (),
        split: DividingPlane | tuple[ArrayLike, ArrayLike] | None = None,
        save: str | Path | Sequence[str | Path] | None = None,
    ) -> CaseTable:
        """Solve for the contact in every pose of a path.

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
            Further components in which it may move, such as ``"x ry"``.
        at : (3,), optional
            Point of application of the forces in the moving bone's axes; the bone then moves in the components of
            `free` alone, such as ``"z ry"``. By default forces act on the bone as a whole, whose rotation they leave.
        times : (n,) array, optional
            For the table; numbers from 0 otherwise.
        path : str or Path, optional
            File of rows; an interrupted path is resumed from it, see `Scene.sweep`.
        maps : str or Path, optional
            Folder for each pose's pressures, as a table of points (.csv) and as a picture (.png).
        processes : int
            Number of poses solved at the same time.
        progress, keep, split, save
            As for `Scene.sweep`; the bodies are those of `bodies`, poses are named 0000, 0001, ...

        Raises
        ------
        InputError
            If a pose is no pose, or there are other numbers of poses, forces, moments or times.
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
        folder = None if maps is None else make_folder(maps)
        cases: list[dict[str, Any]] = []
        for k, pose in enumerate(path_poses):
            case: dict[str, Any] = {"name": f"{k:04d}", "poses": {moving: pose}, "parameters": {"time": when[k]}}
            case |= {what: {key.get(what, moving): rows[k]} for what, rows in loads.items() if rows is not None}
            if free:
                case["free"] = {moving: free}
            if folder is not None:
                case["save"] = [folder / f"{k:04d}.csv", folder / f"{k:04d}.png"]
            cases.append(case)
        return self.scene.sweep(cases, path, processes=processes, progress=progress, keep=keep, split=split, save=save)


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
