"""Dimension of a scene (space, plane or axis) and its admissible poses and loads."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fecontact.bodies.body import Body
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import ROUNDING, Array
from fecontact.common.errors import InputError
from fecontact.contact.contact import Contact
from fecontact.contact.rigid_motion import RigidMotionConstraints
from fecontact.contact.springs import Spring
from fecontact.fem.rigid import COMPONENTS
from fecontact.mesh.section_mesh import Extent
from fecontact.surfaces.facet_surface import Projection, Surface

#: Angle (radians) and shift (relative to the spread of the points) by which the symmetry of a rigid surface is tested.
TRY_TURN, TRY_SHIFT = 0.7, 0.5


@dataclass(frozen=True)
class Dimension:
    """Dimension of a scene: space, plane or axis.

    Attributes
    ----------
    name : str
        'space', 'plane', 'axis', or 'twist': axis with torsion.
    kind, article : str
        The kind of its bodies in words, and with its article.
    motions : tuple of int
        Rigid components that a body has there.
    revolved : bool
        Whether bodies are of revolution.
    turning : tuple of int
        Axes about which a force at a point turns a body; none of revolution, whose forces are on the axis.
    where, ways, turns : str
        The plane or axis in words, and how a body can be translated and turned there.
    """

    name: str
    kind: str
    article: str
    motions: tuple[int, ...]
    revolved: bool = True
    turning: tuple[int, ...] = ()
    where: str = "axis"
    ways: str = "along z"
    turns: str = "half round about x"

    def check_pose(self, body: Body) -> None:
        """Refuse a section off the plane or the axis; rigid bodies are checked by their surfaces."""
        if body._out_of_plane is None:
            return
        Q, shift = body.pose.rotation, body.pose.translation / body.size
        axis, held = (2, [0, 1]) if self.revolved else (1, [1])
        if np.abs(shift[held]).max() > ROUNDING:
            raise InputError(
                f"{body.name!r} has been moved off the {self.where}; it can move {self.ways}.", code="off-plane"
            )
        mirrored = self.revolved and Q[0, 0] < 1 - ROUNDING
        if abs(Q[axis, axis]) < 1 - ROUNDING or mirrored:
            raise InputError(f"{body.name!r} has been turned out of the {self.where}; it can turn {self.turns}.")

    def check_frame(self, frame: RigidMotionConstraints) -> None:
        """Refuse loads and motions that do not exist in this dimension.

        Raises
        ------
        InputError
        """
        columns = np.concatenate([frame.free, frame.prescribed[:, None], frame.load[:, None]], axis=1)
        others = np.ones(6, bool)
        others[list(self.motions)] = False
        wrong = (np.abs(columns) > ROUNDING * np.abs(columns).max(axis=0)).any(axis=1) & others
        if wrong.any():
            advice = " To twist bodies of revolution make them with torsion=True." if self.name == "axis" else ""
            raise InputError(
                f"{frame.body.name!r} is loaded, moved or free in {_named(np.flatnonzero(wrong))}; in {self.article} "
                f"scene there are only {_named(self.motions)}.{advice if wrong[5] else ''}",
                code="motion-not-in-plane",
            )

    def check_spring(self, spring: Spring) -> None:
        """Refuse springs in an axisymmetric scene, and those out of the plane.

        Raises
        ------
        InputError
        """
        if self.revolved:
            raise InputError(f"An axisymmetric scene has no springs; {spring.name!r} would have to be a whole ring.")
        if self.name == "plane" and spring.around is not None:
            raise InputError(
                f"{spring.name!r} wraps round a cylinder in space; its scene is plane.", code="spring-off-plane"
            )
        places = np.array([point for _, point in (spring.start, *spring.via, spring.end)], dtype=float)
        if self.name == "plane" and np.abs(places[:, 1]).max() > ROUNDING * np.abs(places).max(initial=0.0):
            raise InputError(f"{spring.name!r} leaves the plane y = 0 of its scene.", code="spring-off-plane")

    def check_force(self, force: Array, what: str) -> None:
        """Refuse a force (3,) in world axes that does not exist in this dimension.

        Raises
        ------
        InputError
        """
        self._check_along(force, what, "forces", [k for k in range(3) if k in self.motions])

    def check_traction(self, traction: Array, what: str) -> None:
        """Refuse a traction (3,) in world axes that does not exist in this dimension; on rings x is radial.

        Raises
        ------
        InputError
        """
        self._check_along(traction, what, "tractions", [0, 1, 2] if self.name in ("space", "twist") else [0, 2])

    def _check_along(self, force: Array, what: str, kind: str, known: list[int]) -> None:
        others = [k for k in range(3) if k not in known]
        if others and np.abs(force[others]).max() > ROUNDING * np.abs(force).max():
            raise InputError(
                f"{what} acts along {_named(np.flatnonzero(force))}; in {self.article} scene {kind} act along "
                f"{_named(known)} only.",
                code="load-not-in-plane",
            )


def _named(components: Iterable[int]) -> str:
    return ", ".join(COMPONENTS[c] for c in components)


SPACE = Dimension("space", "spatial", "a spatial", (0, 1, 2, 3, 4, 5), False, (0, 1, 2))
PLANE = Dimension(
    "plane", "plane", "a plane", (0, 2, 4), False, (1,), "plane y = 0", "along x and z",
    "about y, or half round about an axis in the plane",
)  # fmt: skip
AXIS = Dimension("axis", "axisymmetric", "an axisymmetric", (2,))
TWIST = Dimension("twist", "axisymmetric with torsion", "an axisymmetric", (2, 5))
SETTINGS = {s.name: s for s in (SPACE, PLANE, AXIS, TWIST)}


def setting_of(bodies: Sequence[Body]) -> Dimension:
    """Dimension of a scene with these bodies.

    Raises
    ------
    InputError
        If they are incompatible, or one is outside the plane or off the axis.
    """
    kinds: dict[Dimension, Body] = {}
    for body in bodies:
        if body._dimension is not None:
            kinds.setdefault(SETTINGS[body._dimension], body)
    if len(kinds) > 1:
        names = "; ".join(f"{b.name!r} is {s.kind}" for s, b in kinds.items())
        raise InputError(
            f"Spatial, plane and axisymmetric bodies cannot share a scene, with torsion or without: {names}. Model "
            "all bodies in one way; rigid bodies go with any.",
            code="mixed-dimensions",
        )
    setting = next(iter(kinds), SPACE)
    for body in bodies:
        setting.check_pose(body)
    wide = {b._out_of_plane.thickness for b in bodies if b._out_of_plane is not None}
    if len(wide) > 1:
        raise InputError(
            f"Plane bodies of one scene need one thickness; found {sorted(map(float, filter(None, wide)))}.",
            code="thickness-differs",
        )
    return setting


def check_contacts(contacts: Sequence[Contact]) -> None:
    """Refuse the same faces in two contacts of the same two bodies: their forces would not be unique.

    Raises
    ------
    InputError
    """
    for k, one in enumerate(contacts):
        for other in contacts[:k]:
            sides, others = (
                {id(b): (b, s) for b, s in zip(c.bodies, c.surfaces or (), strict=True)} for c in (one, other)
            )
            if sides.keys() != others.keys():
                continue
            count = [body._shared_faces(name, others[key][1]) for key, (body, name) in sides.items()]
            if all(count):
                raise InputError(
                    f"Two contacts between {one.slave.name!r} and {one.master.name!r}, {one.surfaces} and "
                    f"{other.surfaces}, share faces on both bodies ({max(count)} on one): forces there would be shared "
                    "in any proportion. Take the faces out of one boundary, or make one contact of the two.",
                    code="shared-faces",
                )


def check_rigid_surface(body: Body, surface: Surface, points: Array, along: Extent) -> None:
    """Refuse a rigid surface that does not share the symmetry of the sections it meets.

    Parameters
    ----------
    body : Body
        The rigid body.
    surface : Surface
    points : (n, 3) array
        Points of the section's surface, in the world.
    along : Extent

    Raises
    ------
    InputError
        If the distance from the surface changes over the thickness or the circumference.
    """
    spread = float(np.ptp(points, axis=0).max())
    if along.revolved:
        c, s = np.cos(TRY_TURN), np.sin(TRY_TURN)
        tried = points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    else:
        tried = points + np.array([0.0, TRY_SHIFT * spread, 0.0])
    here, there = surface.project(body.pose.to_body(points)), surface.project(body.pose.to_body(tried))
    seen = ~here.outside
    if np.abs(here.gap - there.gap)[seen].max(initial=0.0) > ROUNDING * spread or (here.outside != there.outside).any():
        what = "is not a surface of revolution about the z axis" if along.revolved else "is not constant along y"
        raise InputError(
            f"The surface of {body.name!r} {what}, as that of a rigid body in such a scene has to be: a plane, "
            + ("a sphere, a cone on the axis." if along.revolved else "fecontact.surfaces.Cylinder."),
            code="not-along-the-axis",
        )


def opposite(projection: Projection, pose: Pose) -> Projection:
    """Projection on a rigid body, turned half round about z: of a ring, the mean of both is that of the whole ring.

    Resultants of a ring are sums of a constant and of waves once round, which cancel between opposite points.
    """
    half = np.array([-1.0, -1.0, 1.0])
    points = pose.to_body(half * pose.to_world(projection.points))
    return replace(projection, points=points, normals=(projection.normals @ pose.rotation.T * half) @ pose.rotation)
