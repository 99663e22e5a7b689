"""A contact between two surfaces.

Orthotropic friction: the direction of a surface's lay, along which its coefficient differs from that across.

With coefficients mu_1 along the lay and mu_2 across, tangential forces lie in an ellipse, and slip does the most work
on the force among all of them (maximum dissipation: slip is opposite to the normal of the ellipse):

    (t_1 / mu_1)^2 + (t_2 / mu_2)^2 <= l^2,    t . s = min

With mu the larger coefficient, forces t'_k = t_k mu / mu_k lie in the disc |t'| <= mu l, and slips s'_k = s_k mu_k / mu
do the same work, t' . s' = t . s: in these variables friction is isotropic. Only the rows of slip change, by mu_k / mu.

Sources: Michalowski & Mroz, Arch. Mech. 30 (1978) 259; Zmitrowicz, Int. J. Solids Struct. 43 (2006) 4407.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, fields
from typing import TypeGuard, cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.body import Body, check_body
from fecontact.common.arguments import instance, spelled, texts
from fecontact.common.arrays import Array, Mask
from fecontact.common.checks import among, array_of, friction, unlike_friction, vector
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, shown
from fecontact.contact.overclosure import SoftContact
from fecontact.mesh.facets import facet_centres
from fecontact.surfaces.facet_surface import facets_of
from fecontact.surfaces.normals import FACING

#: Sine of the angle between the lay and a point's normal below which the lay has no direction in its tangent plane.
NEARLY_NORMAL = 0.1


@compact_repr
@dataclass(frozen=True, eq=False)
class Lay:
    """Direction of a surface's lay, with the coefficients of friction along and across it.

    Parameters
    ----------
    mu : (2,) array
        Coefficients of slip along the lay and across.
    axis : (3,) array
        Unit vector in world axes.
    body : str
        Name of the body that it turns with.

    Examples
    --------
    >>> lay = Lay(np.array([0.1, 0.2]), np.array([1.0, 0.0, 0.0]), "floor")
    >>> lay.tangents(np.array([[0.0, 0.0, 1.0]]))[:, 0].tolist()
    [[0.5, 0.0, 0.0], [0.0, 1.0, 0.0]]
    """

    mu: Array
    axis: Array
    body: str

    def tangents(self, normals: Array) -> Array:
        """Tangents (2, n, 3) along the lay and across, of lengths mu_k / mu, at points with unit normals (n, 3).

        Where the lay is normal to the surface, any.
        """
        along = self.axis - (normals @ self.axis)[:, None] * normals
        any_across = np.cross(normals, np.eye(3)[np.argmin(np.abs(normals), axis=1)])
        along = np.where(self._normal_to(normals)[:, None], any_across, along)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        return np.stack([along, np.cross(normals, along)]) * (self.mu / self.mu.max())[:, None, None]

    def check(self, normals: Array, points: Array, touching: Mask) -> None:
        """Refuse points (n, 3) that touch (n,) where the lay is normal to the surface.

        Raises
        ------
        InputError
        """
        lost = np.flatnonzero(self._normal_to(normals) & touching)
        if len(lost):
            at = np.array2string(points[lost[0]], precision=4, separator=", ")
            raise InputError(
                f"friction_axis is normal to the surface at {len(lost)} points that touch, such as {at}: the lay of "
                f"{self.body!r} has no direction there. Give an axis that lies in the surface, or one coefficient.",
                code="friction-axis-normal",
            )

    def _normal_to(self, normals: Array) -> Mask:
        return np.asarray(np.linalg.norm(np.cross(normals, self.axis), axis=1) < NEARLY_NORMAL)


class Side:
    """What of a deformable member may touch: a boundary of bricks, the skin of a slender member; see `ancf`.

    Attributes
    ----------
    member : object
        Its member, which an assembly finds by identity.
    name : str
    """

    member: object
    name: str
    is_rigid = False


def is_side(given: object) -> TypeGuard[Side]:
    """Whether it is a side of a member."""
    return isinstance(given, Side)


#: Distance of two surfaces that face each other, over the size of the smaller body, up to which they are near.
NEAR = 0.05


def facing_surfaces(slave: Body, master: Body) -> tuple[str, str]:
    """The one pair of surfaces of two bodies, in their poses, that face each other and are near.

    Raises
    ------
    InputError
        If there are several, or none; not for bodies with one surface each, which may be apart.
    """
    pairs = list(itertools.product(slave.contact, master.contact))
    if len(pairs) > 1 and not (slave.is_rigid and master.is_rigid):
        distance = NEAR * min(body.size for body in (slave, master) if not body.is_rigid)
        pairs = [pair for pair in pairs if _face(slave, master, pair, distance)]
    if len(pairs) == 1:
        return pairs[0]
    found = " and ".join(
        f"those of {b.name!r} are {', '.join(map(repr, b.contact)) or 'none'}" for b in (slave, master)
    )
    near = f"; {len(pairs)} of their pairs face each other and are near" if slave.contact and master.contact else ""
    raise InputError(
        f"Which surfaces touch? Say it by Contact(..., surfaces=(slave, master)): {found}{near}.",
        code="several-surfaces",
    )


def _face(slave: Body, master: Body, names: tuple[str, str], distance: float) -> bool:
    """Whether facets of one of two surfaces face the other within a distance."""
    one, other = slave, master
    if (facets := facets_of(slave.surface(names[0]))) is None:
        one, other, facets, names = master, slave, facets_of(master.surface(names[1])), names[::-1]
    assert facets is not None  # as one of the bodies is not rigid
    pose, surface = one.pose.relative_to(other.pose), other.surface(names[1])
    every, middle = np.arange(len(facets.facets)), facet_centres(facets.triangle)
    # normals in the middle of facets, distances at their nodes: those of a coarse ball begin where it touches
    found = surface.project(pose.to_world(facets.evaluate(every, middle)[0]))
    opposed = ((facets.normals(every, middle) @ pose.rotation.T) * found.normals).sum(axis=1) < -FACING
    if not opposed.any():
        return False
    nodes = np.unique(facets.facets[opposed])
    at_nodes = surface.project(pose.to_world(facets.points[nodes[nodes >= 0]]))
    return bool(((np.abs(at_nodes.gap) <= distance) & ~at_nodes.outside).any())


@spelled
@compact_repr
@dataclass(frozen=True, eq=False)
class Contact:
    """Two surfaces that may touch, the slave first.

    Contact pressures are defined on the slave. Where its faces lie inside the master's faces (equal or nested meshes)
    forces on its nodes are exact; elsewhere mortar coupling is used, with either side as the slave.

    Parameters
    ----------
    slave, master : Body, or Side
        In an assembly of `ancf` the slave is a side of a member, the master one of another member or a rigid body.
    surfaces : (str, str), optional
        Names of their surfaces; optional for bodies with one contact surface each, or of which one pair alone faces
        each other and is near (`facing_surfaces`).
    swap : {'auto', 'never', 'always'}
        Whether sides may be swapped where faces do not match: the slave should be the coarser side for mortar coupling,
        the finer one for nodal forces. 'always' swaps them if both have faces. Resultants are on the body named first
        all the same.
    coupling : {'auto', 'nodal', 'mortar'}
        'nodal': forces on slave nodes; 'mortar': non-negative multipliers and weighted gaps over the exact overlap;
        'auto': nodal where faces match or nest and on rigid surfaces, mortar elsewhere.
    friction : float or (float, float)
        Coulomb's coefficient of friction, from 0 (the default, frictionless) to inf (rough: what touches sticks); or
        two, along `friction_axis` and across (orthotropic, see `contact.contact`). Friction depends on the order of
        loads, see `Scene.solve_path`; `Scene.solve` is one step from the unloaded state.
    friction_axis : (3,) array, optional
        Direction of the first of two coefficients, such as that of grooves, in the axes of a body, with which it turns.
        Points take its projection on their tangent planes.
    axis_of : {'slave', 'master'}
        That body.
    overclosure : SoftContact, optional
        Law by which the surfaces overlap under a pressure; without it contact is hard. Small strains, no half-spaces.

    Raises
    ------
    InputError

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="bottom", supports={"top": "xyz"})
    >>> fc.Contact(body, fc.RigidBody(fc.Plane())).surfaces
    ('bottom', 'surface')
    """

    slave: Body | Side
    master: Body | Side
    surfaces: tuple[str, str] | None = None
    swap: str = "auto"
    coupling: str = "auto"
    friction: float | tuple[float, float] = 0.0
    friction_axis: ArrayLike | None = None
    axis_of: str = "slave"
    overclosure: SoftContact | None = None

    def __post_init__(self) -> None:
        among("axis_of", self.axis_of, ("slave", "master"))
        among("coupling", self.coupling, ("auto", "nodal", "mortar"))
        among("swap", self.swap, ("auto", "never", "always"))
        if is_side(self.slave) or is_side(self.master):
            self._check_sides()
            return
        slave, master = self.bodies
        for body in (slave, master):
            check_body(body)
        if slave is master:
            raise InputError(f"{slave.name!r} cannot be in contact with itself; give two bodies.", code="one-body")
        if self.surfaces is None:
            object.__setattr__(self, "surfaces", facing_surfaces(slave, master))
        elif len(pair := texts("surfaces", self.surfaces)) != 2:
            raise InputError(f"surfaces must be a pair of names, the slave's first; found {self.surfaces!r}.")
        else:
            object.__setattr__(self, "surfaces", pair)
        assert self.surfaces is not None
        slave.surface(self.surfaces[0])
        master.surface(self.surfaces[1])
        self._check_friction()
        if self.overclosure is not None:
            for body in self.bodies:
                instance("overclosure", self.overclosure, SoftContact).check(body)

    def _check_sides(self) -> None:
        """Refuse sides of one member, a slave without multipliers, and options that are for bodies of scenes."""
        slave, master = self.slave, self.master
        if not is_side(slave) or not (is_side(master) or getattr(master, "is_rigid", False)):
            raise InputError(
                "In a contact of members the slave is a side of one, and the master a side of another or a rigid body; "
                f"found {shown(slave)} and {shown(master)}.",
                code="contact-sides",
            )
        if is_side(master) and slave.member is master.member:
            raise InputError(
                f"The member of {slave.name!r} and {master.name!r} cannot touch itself: give what touches as members "
                "of their own.",
                code="contact-with-itself",
            )
        plain = {f.name: f.default for f in fields(self) if f.name not in ("slave", "master", "friction")}
        if given := [name for name, default in plain.items() if np.any(getattr(self, name) != default)]:
            raise InputError(f"{', '.join(given)}: for bodies of scenes; sides of members have friction only.")
        friction(self.friction, infinite=True)  # type: ignore[arg-type]

    @property
    def bodies(self) -> tuple[Body, Body]:
        """Slave and master of a scene.

        Raises
        ------
        InputError
            If it is of sides of members.
        """
        if is_side(self.slave):
            raise InputError(
                f"{self.slave.name!r} is a side of a member with coordinates of its own: its contact is one of an "
                "`ancf.Assembly`. A scene takes an AncfBody.",
                code="contact-of-members",
            )
        return cast(tuple[Body, Body], (self.slave, self.master))

    def _check_friction(self) -> None:
        """Refuse senseless coefficients, an axis without a pair of them, and a pair in a section."""
        given = array_of(self.friction)
        if given is None or given.ndim == 0:
            friction(self.friction, infinite=True)  # type: ignore[arg-type]
            if self.friction_axis is not None or self.axis_of != "slave":
                raise InputError(
                    "friction_axis and axis_of are of two coefficients of friction; found one. Give friction=(along, "
                    "across), or leave them out.",
                    code="friction-axis",
                )
            return
        pair = unlike_friction(self.friction)
        if self.friction_axis is None:
            raise InputError("Two coefficients of friction need friction_axis, the direction of the first.")
        if not vector("friction_axis", self.friction_axis).any():
            raise InputError("friction_axis is zero; give the direction of the first coefficient of friction.")
        for body in self.bodies:
            if body._out_of_plane is not None and not body._out_of_plane.torsion:
                raise InputError(
                    f"{body.name!r} is a section without torsion, whose points slip along one line: give one "
                    f"coefficient of friction instead of {pair}.",
                    code="friction-of-section",
                )
        object.__setattr__(self, "friction", pair)

    @property
    def mu(self) -> float:
        """The coefficient of friction; of two the larger one."""
        return float(np.max(self.friction))

    @property
    def lay(self) -> Lay | None:
        """Direction of two coefficients of friction in world axes, by the present pose; None with one."""
        if self.friction_axis is None:
            return None
        body = self.bodies[self.axis_of == "master"]
        axis: Array = body.pose.rotation @ vector("friction_axis", self.friction_axis)
        return Lay(np.array(self.friction), axis / np.linalg.norm(axis), body.name)
