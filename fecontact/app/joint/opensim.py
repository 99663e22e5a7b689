"""Models of OpenSim (.osim): poses of bodies by the coordinates of their joints, and ligaments.

A joint carries its child's frame along three translations in the axes of its parent's frame, and turns it about three
axes, each carried by the turns before it. Each of the six is a function of coordinates. Angles are in radians, lengths
in metres. Sources: Seth et al., Minimal formulation of joint motion for biomechanisms, Nonlinear Dyn. 62 (2010), 291;
OpenSim's files of versions 2 to 4.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from fecontact.app.joint.joint import Joint
from fecontact.app.joint.ligament import TOE, Ligament
from fecontact.app.joint.motion_file import Motion
from fecontact.app.joint.opensim_functions import Function, Line, function_of
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import file_path, instance
from fecontact.common.arrays import Array
from fecontact.common.checks import among, positive
from fecontact.common.errors import InputError, not_done
from fecontact.common.material import Material
from fecontact.contact.strands import WrapCylinder
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.surfaces.repair import repair_surface

Element = ElementTree.Element


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of a joint: its value at rest, and whether it is an angle; None where a file does not tell."""

    rest: float
    is_angle: bool | None


@dataclass(frozen=True, eq=False)
class TransformAxis:
    """One of the six parts of a joint: a function of a coordinate, or a constant, along or about an axis."""

    axis: Array
    coordinate: str | None
    function: Function


@dataclass(frozen=True, eq=False)
class ModelJoint:
    """A joint: poses of its frames in the bodies that it ties, and the three turns and three translations."""

    parent: str
    in_parent: Pose
    in_child: Pose
    axes: Sequence[TransformAxis]

    def poses(self, values: Mapping[str, Array], n: int) -> tuple[Array, Array]:
        """Rotations (n, 3, 3) and translations (n, 3) of the child in the parent's axes."""
        amounts = [
            np.broadcast_to(a.function(values[a.coordinate] if a.coordinate else np.zeros(1)), n) for a in self.axes
        ]
        turn = Rotation.identity(n)
        for part, amount in zip(self.axes[:3], amounts[:3], strict=True):
            turn = turn * Rotation.from_rotvec(amount[:, None] * part.axis)
        shift = sum(amount[:, None] * part.axis for part, amount in zip(self.axes[3:], amounts[3:], strict=True))
        back = Pose().relative_to(self.in_child)
        first = self.in_parent.rotation @ turn.as_matrix()
        place = np.asarray(shift) @ self.in_parent.rotation.T + self.in_parent.translation
        return first @ back.rotation, first @ back.translation + place


@dataclass(frozen=True, eq=False)
class LigamentPath:
    """A ligament of Blankevoort & Huiskes (1991): points (body, (3,)), surfaces that it wraps round, and its law.

    `others` are kinds of points and of wraps that are not offered.
    """

    points: Sequence[tuple[str, Array]]
    wraps: Sequence[str]
    others: Sequence[str]
    stiffness: float
    slack_length: float
    toe: float


@dataclass(frozen=True)
class CartilageMesh:
    """A contact mesh of OpenSim-JAM (Smith2018ContactMesh): its body, files, thickness, and elastic constants.

    `back` is the file of the bone under it, empty where the thickness is the same everywhere.
    """

    body: str
    file: str
    back: str
    thickness: float
    least: float
    E: float
    nu: float


@dataclass(frozen=True, eq=False)
class OpenSimModel:
    """Bodies of a model of OpenSim, tied by joints.

    Attributes
    ----------
    coordinates : mapping of str to Coordinate
    joints : mapping of str to ModelJoint
        By the body that is each one's child.
    paths : mapping of str to LigamentPath
        Ligaments by name.
    cylinders : mapping of str to (str, WrapCylinder)
        Wrapping cylinders by name, with the bodies that carry them.
    meshes : mapping of str to CartilageMesh
        Contact meshes of OpenSim-JAM by name.
    """

    coordinates: Mapping[str, Coordinate]
    joints: Mapping[str, ModelJoint]
    paths: Mapping[str, LigamentPath] = field(repr=False)
    cylinders: Mapping[str, tuple[str, WrapCylinder]] = field(default_factory=dict, repr=False)
    meshes: Mapping[str, CartilageMesh] = field(default_factory=dict, repr=False)

    def poses(self, moving: str, fixed: str, motion: Motion | None, *, scale: float) -> list[Pose]:
        """Poses of a body in the axes of another, such as of the femur in those of the tibia.

        Parameters
        ----------
        moving, fixed : str
            Names of bodies.
        motion : Motion or None
            With a column for each coordinate between both, by its name or as in ``/jointset/knee_r/flexion/value``;
            others are not used. None for the one pose of all values at rest.
        scale : float
            Lengths of the poses per metre: 1000 for millimetres.

        Raises
        ------
        InputError
            For bodies that are not in the model, coordinates that are not in the motion, and columns in degrees of a
            coordinate of which the model does not tell whether it is an angle.
        """
        positive("the scale of a model", scale)
        known = {*self.joints, *(j.parent for j in self.joints.values())}
        for name in (moving, fixed):
            among("body of the model", name, known)
        chains = [self._chain(name) for name in (moving, fixed)]
        shared = set(chains[0]) & set(chains[1])
        used = [body for chain in chains for body in chain if body not in shared]
        values = self._values(used, motion)
        n = 1 if motion is None else len(motion.times)
        (R, p), (Q, q) = (self._from_root(c, shared, values, n) for c in chains)
        turned = np.swapaxes(Q, 1, 2)
        shift = np.einsum("nij,nj->ni", turned, p - q)
        return [Pose(turn, scale * move) for turn, move in zip(turned @ R, shift, strict=True)]

    def joint(
        self,
        moving: str,
        fixed: str,
        folder: str | Path,
        *,
        scale: float,
        size: float | None = None,
        turned: ArrayLike | None = None,
        foundation: bool = True,
        **options: Any,
    ) -> Joint:
        """Joint of two contact meshes of OpenSim-JAM, with their thickness, modulus and Poisson's ratio.

        The largest thickness of a mesh is not read: where there is more, it is taken as it is.

        Parameters
        ----------
        moving, fixed : str
            Names of the meshes, such as "femur_cartilage", which are the names of the bodies too.
        folder : str or Path
            With the files that the meshes name.
        scale : float
            Lengths per metre; the moduli, pascals in the file, are in newtons per square of this length.
        size : float, optional
            Edge length of the facets of free surfaces; as in the files unless given.
        turned : (3, 3) array, optional
            Rotation from the axes of the files to those of the bodies.
        foundation : bool
            As JAM has it, see `Joint`.
        **options
            Others of `Joint`, such as ``units`` and ``axes``.

        Raises
        ------
        InputError
            If there is no such mesh, or a file cannot be read.
        """
        positive("the scale of a model", scale)
        for name in (moving, fixed):
            among("contact mesh of the model", name, self.meshes)
        found = [self.meshes[name] for name in (moving, fixed)]
        pose = Pose() if turned is None else Pose(np.asarray(turned, dtype=float))

        def surface(file: str, size: float | None = None) -> SurfaceMesh:
            read = repair_surface(Path(folder) / file, size=size, scale=scale)
            return read.mapped(pose.to_world)

        one, other = (surface(m.file, size) for m in found)
        thick = [surface(m.back) if m.back else scale * m.thickness for m in found]
        given: dict[str, Any] = {
            "thickness": tuple(thick),
            "least": tuple(scale * m.least if m.back else None for m in found),
            "material": tuple(Material(E=m.E / scale**2, nu=m.nu) for m in found),
            "surfaces": "cartilage", "foundation": foundation, "names": (moving, fixed), "anatomy": "opensim",
        }  # fmt: skip
        return Joint(one, other, **{**given, **options})

    def ligaments(self, moving: str, fixed: str, *, scale: float, straight: bool | None = None) -> list[Ligament]:
        """Ligaments between two bodies, for `Joint(springs=...)`.

        They are led through points on both bodies, or wrap round a cylinder on one of them, see `contact.strands`.

        Parameters
        ----------
        moving, fixed : str
        scale : float
            Lengths per metre.
        straight : bool, optional
            Whether ligaments that wrap round other surfaces (ellipsoids, several, parts of cylinders), or are led by
            other bodies, are taken along the straight line between their ends, or left out. It is asked for where there
            are any.

        Raises
        ------
        InputError
            If there are such ligaments and `straight` is not given.
        """
        positive("the scale of a model", scale)
        out: list[Ligament] = []
        between = {
            name: path
            for name, path in self.paths.items()
            if {path.points[0][0], path.points[-1][0]} == {moving, fixed}
        }
        led = {name: self._led(path, {moving: "moving", fixed: "fixed"}, scale) for name, path in between.items()}
        bent = [name for name, way in led.items() if way is None]
        if bent and straight is None:
            raise InputError(
                f"Ligaments between {moving!r} and {fixed!r} wrap round surfaces other than one whole cylinder, or are "
                f"led by other bodies, which is not offered: {', '.join(bent)}. Take them along straight lines, with "
                "straight=True, which shortens them where they would bend, or leave them out, with straight=False.",
                code="wraps",
            )
        for name, path in between.items():
            ends = dict((path.points[0], path.points[-1]))
            if straight or name not in bent:
                start, end = scale * ends[moving], scale * ends[fixed]
                slack = scale * path.slack_length
                out.append(
                    Ligament(
                        name, tuple(start.tolist()), tuple(end.tolist()), path.stiffness, slack, path.toe,
                        **(led[name] or {}),
                    )
                )  # fmt: skip
        return out

    def _led(self, path: LigamentPath, bones: Mapping[str, str], scale: float) -> dict[str, Any] | None:
        """`via` or `around` of a ligament between two bodies; None where it is led by what is not offered."""
        inner, wraps = list(path.points[1:-1]), [self.cylinders.get(name) for name in path.wraps]
        carriers = {*(body for body, _ in inner), *(each[0] for each in wraps if each is not None)}
        if path.others or None in wraps or len(wraps) > 1 or (wraps and inner) or not carriers <= set(bones):
            return None
        if bones[path.points[0][0]] == "fixed":
            inner.reverse()
        led: dict[str, Any] = (
            {"via": [(bones[body], tuple((scale * p).tolist())) for body, p in inner]} if inner else {}
        )
        for body, c in filter(None, wraps):
            scaled = WrapCylinder(scale * np.asarray(c.centre), c.axis, scale * c.radius, scale * c.length)
            led["around"] = bones[body], scaled
        return led

    def _chain(self, body: str) -> list[str]:
        """The body and those that carry it, outwards in."""
        chain = [body]
        while chain[-1] in self.joints:
            if self.joints[chain[-1]].parent in chain:
                raise InputError(f"The joints of the model carry {body!r} by itself.", code="joint-loop")
            chain.append(self.joints[chain[-1]].parent)
        return chain

    def _values(self, bodies: Sequence[str], motion: Motion | None) -> dict[str, Array]:
        """Values (n,) of the coordinates of these bodies' joints, in radians and metres."""
        names = {a.coordinate for body in bodies if body in self.joints for a in self.joints[body].axes if a.coordinate}
        if motion is None:
            return {name: np.array([self.coordinates[name].rest]) for name in names}
        columns = {_bare(column): column for column in instance("the motion", motion, Motion).names}
        if missing := sorted(names - set(columns)):
            raise InputError(
                f"The motion has no columns of the coordinates {', '.join(missing)}, on which the poses depend.",
                code="missing-coordinate",
            )
        out = {name: motion.column(columns[name]) for name in names}
        if motion.in_degrees:
            for name in sorted(names):
                if (angle := self.coordinates[name].is_angle) is None:
                    raise InputError(
                        f"The motion is in degrees, and the model does not tell whether {name!r} is an angle: give it "
                        "in radians.",
                        code="unknown-unit",
                    )
                out[name] = np.radians(out[name]) if angle else out[name]
        return out

    def _from_root(
        self, chain: list[str], shared: set[str], values: Mapping[str, Array], n: int
    ) -> tuple[Array, Array]:
        """Rotations (n, 3, 3) and translations (n, 3) of a body in the axes of the first one that carries both."""
        turn, shift = np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3))
        for body in (b for b in chain if b not in shared):
            if body not in self.joints:
                raise InputError(f"No joint ties {body!r} to the rest of the model.", code="not-joined")
            R, p = self.joints[body].poses(values, n)
            turn, shift = R @ turn, np.einsum("nij,nj->ni", R, shift) + p
        return turn, shift


def read_osim(path: str | Path) -> OpenSimModel:
    """Read the joints and ligaments of a model of OpenSim.

    Joints are CustomJoint, PinJoint and WeldJoint; others, and functions that are not known, are refused. What else is
    in a model, such as muscles, is not used.

    Parameters
    ----------
    path : str or Path
        A ``.osim`` file of any version from 2.

    Raises
    ------
    InputError
        If the file cannot be read, or has what is refused; the message names the joint.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> pin = "<parent_body>thigh</parent_body><CoordinateSet><Coordinate name='flexion'/></CoordinateSet>"
    >>> text = f"<Model><Body name='shank'><Joint><PinJoint name='knee'>{pin}</PinJoint></Joint></Body></Model>"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "leg.osim"
    ...     _ = path.write_text(text)
    ...     model = read_osim(path)
    >>> motion = Motion(np.array([0.0]), ("flexion",), np.array([[90.0]]), in_degrees=True)
    >>> (model.poses("shank", "thigh", motion, scale=1.0)[0].rotation @ [1, 0, 0]).round(12).tolist()
    [0.0, 1.0, 0.0]
    """
    path = file_path("the file of a model", path)
    try:
        root = ElementTree.parse(path).getroot()
    except OSError as error:
        raise InputError(f"The model {path} cannot be read: {error.strerror or error}.", code="unreadable") from error
    except ElementTree.ParseError as error:
        raise InputError(f"{path} is no file of OpenSim: {error}.", code="no-osim") from error
    coordinates: dict[str, Coordinate] = {}
    joints: dict[str, ModelJoint] = {}
    found = [(None, j) for s in root.iter("JointSet") for o in s.findall("objects") for j in o]
    for child, joint in [*found, *((b.get("name"), j) for b in root.iter("Body") for j in b.findall("Joint/*"))]:
        try:
            name, made = _joint(joint, child, coordinates)
        except (ValueError, AttributeError) as error:
            if isinstance(error, InputError):
                raise
            what = f"The joint {joint.get('name')!r} of {path.name} cannot be read: {error}."
            raise InputError(what, code="bad-value") from error
        joints[name] = made
    if not joints:
        raise InputError(f"{path} has no joints: it is no model of OpenSim, or a part of one.", code="no-osim")
    cylinders = {
        wrap.get("name", ""): (body.get("name", ""), round_it)
        for body in root.iter("Body")
        for wrap in body.findall("WrapObjectSet/objects/WrapCylinder")
        if (round_it := _cylinder(wrap)) is not None
    }
    paths = {x.get("name", ""): _path(x) for x in root.iter("Blankevoort1991Ligament")}
    meshes = {x.get("name", ""): _mesh(x) for x in root.iter("Smith2018ContactMesh")}
    return OpenSimModel(coordinates, joints, paths, cylinders, meshes)


def _bare(column: str) -> str:
    """Name of the coordinate of a column of a motion or of states."""
    parts = column.strip("/").split("/")
    return parts[-2] if len(parts) > 1 and parts[-1] == "value" else parts[-1]


def _numbers(text: str | None, count: int) -> Array:
    """So many numbers; zeros where there is no text."""
    found = np.array((text or "0 " * count).split(), dtype=float)
    if found.shape != (count,) or not np.isfinite(found).all():
        raise ValueError(f"expected {count} numbers, found {text!r}")
    return found


def _frame(translation: str | None, orientation: str | None) -> Pose:
    """Pose of a frame in its body: turns about x, y and z, each carried by the one before."""
    return Pose(Rotation.from_euler("XYZ", _numbers(orientation, 3)).as_matrix(), _numbers(translation, 3))


def _joint(joint: Element, child: str | None, coordinates: dict[str, Coordinate]) -> tuple[str, ModelJoint]:
    """Name of a joint's child and the joint; its coordinates are added. A joint of version 3 stands in its child."""
    place, kind = f"The joint {joint.get('name')!r}", joint.tag
    if kind not in ("CustomJoint", "PinJoint", "WeldJoint"):
        raise not_done(f"{place} is a {kind}; expected CustomJoint, PinJoint or WeldJoint.")
    if (joint.findtext("reverse") or "false").strip() == "true":
        raise not_done(f"{place} is reversed, which is not done here.")
    if child is None:
        frames = {f.get("name"): f for f in joint.iter("PhysicalOffsetFrame")}
        ends = []
        for which in ("parent", "child"):
            name = joint.findtext(f"socket_{which}_frame").strip().split("/")[-1]  # type: ignore[union-attr]
            offset = Pose()
            if (frame := frames.get(name)) is not None:
                offset = _frame(frame.findtext("translation"), frame.findtext("orientation"))
                name = frame.findtext("socket_parent").strip().split("/")[-1]  # type: ignore[union-attr]
            ends.append((name, offset))
    else:
        parent = joint.findtext("parent_body").strip()  # type: ignore[union-attr]
        ends = [(parent, _frame(joint.findtext("location_in_parent"), joint.findtext("orientation_in_parent")))]
        ends += [(child, _frame(joint.findtext("location"), joint.findtext("orientation")))]
    own = list(joint.iter("Coordinate"))
    if kind == "CustomJoint":
        axes = _axes(joint, place)
    else:
        pinned = [own[0].get("name") if kind == "PinJoint" and k == 2 else None for k in range(6)]
        axes = [TransformAxis(np.eye(3)[k % 3], name, Line(1.0 if name else 0.0, 0.0)) for k, name in enumerate(pinned)]
    for c in own:
        said = {"rotational": True, "translational": False}.get((c.findtext("motion_type") or "").strip().lower())
        name = c.get("name", "")
        # an angle is what turns about an axis by itself, forwards or backwards, as in OpenSim
        mine = [(k < 3, a.function) for k, a in enumerate(axes) if a.coordinate == name]
        plain = {turns for turns, f in mine if abs(getattr(f, "slope", 0.0)) == 1}
        is_angle = said if said is not None else True in plain if plain else None
        coordinates[name] = Coordinate(float(_numbers(c.findtext("default_value"), 1)[0]), is_angle)
    (parent, in_parent), (body, in_child) = ends
    return body, ModelJoint(parent, in_parent, in_child, axes)


def _axes(joint: Element, place: str) -> list[TransformAxis]:
    """The six parts of a CustomJoint in their order."""
    found = {a.get("name"): a for a in joint.iter("TransformAxis")}
    out = []
    for name in (f"{what}{k}" for what in ("rotation", "translation") for k in (1, 2, 3)):
        if name not in found:
            raise InputError(f"{place} has no axis {name!r}.", code="missing-element")
        part = found[name]
        axis, names = _numbers(part.findtext("axis"), 3), (part.findtext("coordinates") or "").split()
        if not axis.any() or len(names) > 1:
            raise not_done(
                f"{place}, {name}: expected an axis that is not zero and one coordinate at most; found "
                f"{axis.tolist()} and {names}."
            )
        inner = [e for e in part if e.tag not in ("axis", "coordinates")]
        if not inner:
            raise InputError(f"{place}, {name}: there is no function.", code="missing-element")
        function = function_of(inner[0], f"{place}, {name}")
        out.append(TransformAxis(axis / np.linalg.norm(axis), names[0] if names else None, function))
    return out


def _path(ligament: Element) -> LigamentPath:
    """Points, wraps and law of a ligament."""
    inner = ligament.findall("GeometryPath/PathPointSet/objects/*")
    points = [
        (p.findtext("socket_parent_frame", "").strip().split("/")[-1], _numbers(p.findtext("location"), 3))
        for p in inner
    ]
    wraps = [w.findtext("wrap_object", "").strip() for w in ligament.iter("PathWrap")]
    parts = (w.findtext("range") or "-1 -1" for w in ligament.iter("PathWrap"))
    others = [p.tag for p in inner if p.tag != "PathPoint"] + [part for part in parts if part.split() != ["-1", "-1"]]
    stiffness, slack = (float(ligament.findtext(tag) or "nan") for tag in ("linear_stiffness", "slack_length"))
    return LigamentPath(points, wraps, others, stiffness, slack, float(ligament.findtext("transition_strain") or TOE))


def _cylinder(wrap: Element) -> WrapCylinder | None:
    """A wrapping cylinder, about the z axis of its frame; None of one that is not active or used on one side only."""
    if (wrap.findtext("active") or "true").strip() != "true" or (wrap.findtext("quadrant") or "all").strip() != "all":
        return None
    frame = _frame(wrap.findtext("translation"), wrap.findtext("xyz_body_rotation"))
    radius, length = (float(wrap.findtext(tag) or "nan") for tag in ("radius", "length"))
    return WrapCylinder(frame.translation, frame.rotation[:, 2], radius, length)


def _mesh(mesh: Element) -> CartilageMesh:
    """A contact mesh, in the axes of its body.

    Raises
    ------
    InputError
        If it is moved or scaled in its body, or numbers are missing.
    """
    name = f"The contact mesh {mesh.get('name')!r}"
    moved = [tag for tag in ("location", "orientation") if _numbers(mesh.findtext(tag), 3).any()]
    if moved or (mesh.findtext("scale_factors") or "1 1 1").split() != ["1", "1", "1"]:
        raise not_done(f"{name} is moved or scaled in its body, which is not offered.")
    tags = ("thickness", "min_thickness", "elastic_modulus", "poissons_ratio")
    numbers = [float(mesh.findtext(tag) or "nan") for tag in tags]
    back = (mesh.findtext("mesh_back_file") or "").strip()
    variable = (mesh.findtext("use_variable_thickness") or "false").strip() == "true"
    body = mesh.findtext("socket_frame", "").strip().split("/")[-1]
    return CartilageMesh(body, mesh.findtext("mesh_file", "").strip(), back if variable else "", *numbers)
