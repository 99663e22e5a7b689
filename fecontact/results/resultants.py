"""Resultants of a solution: forces and moments of parts of a contact, and reactions of bodies."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import connected_components

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import text, texts
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import vector
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, shown
from fecontact.common.region import Region
from fecontact.contact.condensed_problem import BodyBlock
from fecontact.contact.loads import Loading
from fecontact.fem.stiffness import symmetric_product

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields


#: Distance from a dividing plane, relative to the slave's size, within which a point is on both sides.
ON_PLANE = 1e-9


def resultant(contact: ContactFields, share: Array | None = None) -> tuple[Array, Array]:
    """Force (3,) and moment (3,), friction included, on the first body of a contact; of shares (n,) of its points."""
    share = np.ones(len(contact.forces)) if share is None else share
    forces, friction = contact.forces * share, contact.friction
    force, moment = forces @ contact.normals, forces @ contact._couples
    if friction is not None:
        force = force + share @ friction.resultants
        moment = moment + share @ friction.moments(contact._centres - contact.reference_point)
    return contact._sign * force, contact._sign * moment


def part_of(contact: ContactFields, share: Array, of_facets: Array) -> Region:
    """Resultants of a part of a contact, friction included, by the shares (n,) and (n_facets,) of points and facets."""
    forces, (force, moment) = contact.forces * share, resultant(contact, share)
    total, area = float(forces.sum()), float(contact._areas[0] @ of_facets + contact._areas[1] @ share)
    return Region(
        area=area,
        force=force,
        moment=moment,
        max_pressure=float(contact.pressure[share > 0].max(initial=0.0)),
        mean_pressure=total / area if area > 0 else 0.0,
        centre_of_pressure=forces @ contact._centres / total if total > 0 else np.full(3, np.nan),
        point_area=float((contact.weights * share)[contact.active].sum()),
    )


def region_numbers(contact: ContactFields) -> IntArray:
    """Connected region (n,) of each point, 1 for the most loaded, 0 for points that carry no force.

    Points are connected by the facets they share.
    """
    active = contact.active
    member = contact._sharing.multiply(active[:, None]).tocsr()
    _, label = connected_components(member @ member.T, directed=False)
    load = np.bincount(label, contact.forces)
    kinds = np.unique(label[active])
    number = np.zeros(len(load), dtype=np.int64)
    number[kinds[np.argsort(-load[kinds], kind="stable")]] = 1 + np.arange(len(kinds))
    return np.where(active, number[label], 0)


def sides_of_plane(contact: ContactFields, point: ArrayLike, normal: ArrayLike) -> tuple[Region, Region]:
    """Resultants on the side a plane's normal points to, and on the other; see `ContactFields.split_by_plane`."""
    n = vector("The normal of the dividing plane", normal)
    length = np.linalg.norm(n)
    if length == 0:
        raise InputError("The normal of the dividing plane must not be zero.", code="normal-zero")
    p = vector("The point of the dividing plane", point)
    distance = (contact._centres - p) @ (n / length)
    near = np.abs(distance) <= ON_PLANE * contact.slave.size
    share, of_facets = contact._shares(p, n / length)
    front, back = part_of(contact, share, of_facets), part_of(contact, 1 - share, 1 - of_facets)
    peaks = (float(contact.pressure[near | side].max(initial=0.0)) for side in (distance > 0, distance < 0))
    return replace(front, max_pressure=next(peaks)), replace(back, max_pressure=next(peaks))


def hold_of_body(part: BodyBlock, loading: Loading, k: int, forces: Array) -> Array:
    """Reaction (6,) on body k: force and moment about the reference point that keep it in equilibrium."""
    pressing = part.frame.modes(np.eye(6)).T @ (part.rows.T @ forces[part.index])
    return np.asarray(-(loading.resultant(k) + pressing))


def hold_of_boundary(body: ElasticBody, part: BodyBlock, name: str, displacement: Array, forces: Array) -> Array:
    """Reaction (6,) on a supported boundary: force and moment from the body's frame, about the reference point.

    From the nodal forces K u - f along the directions held there; where several boundaries hold one, each takes an
    equal share.
    """
    if text("the name of a boundary", name) not in body.supports:
        known = ", ".join(map(repr, body.supports)) or "none"
        raise InputError(f"{body.name!r} has no support on {name!r}; its supports are on: {known}.", code="no-support")
    load = np.asarray(part.rows.T @ forces[part.index]) + (0.0 if part.loads is None else part.loads)
    if part.hold is not None:
        load = part.hold.balanced(load)
    # the loads have the forces of imposed displacements
    u = displacement if part.frame.imposed is None else displacement - part.frame.imposed
    rest = symmetric_product(body.model.stiffness, u) - load
    nodal = body.model.support_forces(name, rest)
    return np.asarray(part.frame.modes(np.eye(6)).T @ nodal)


@compact_repr
@dataclass(frozen=True, eq=False)
class DividingPlane:
    """A plane that divides contacts into two sides.

    Parameters
    ----------
    point, normal : (3,)
        A point of the plane and its normal, which need not have unit length.
    body : Body, optional
        Body in whose axes they are given, with which the plane moves; the world's unless given.
    sides : (str, str)
        Names of the side to which the normal points, and of the other.

    Raises
    ------
    InputError
        If the normal is zero, or the names are not two.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> scene = fc.Scene([block, floor := fc.RigidBody(fc.Plane())], [fc.Contact(block, floor)])
    >>> plane = fc.DividingPlane((0.25, 0, 0), (1, 0, 0), block, sides=("medial", "lateral"))
    >>> table = scene.sweep([{"motions": {block: {"z": -0.01}}}], split=plane)
    >>> table.column("medial: area").round(9).tolist(), table.column("lateral: force_z").round(9).tolist()
    ([0.75], [0.0025])
    """

    point: ArrayLike
    normal: ArrayLike
    body: Body | None = None
    sides: tuple[str, str] = ("front", "back")

    def __post_init__(self) -> None:
        vector("the point of the dividing plane", self.point)
        if not vector("the normal of the dividing plane", self.normal).any():
            raise InputError("The normal of the dividing plane must not be zero.", code="normal-zero")
        names = texts("the sides of the dividing plane", self.sides)
        if len(names) != 2 or names[0] == names[1]:
            raise InputError(f"A plane has two sides with two names; found {shown(self.sides)}.", code="side-names")

    def in_world(self, pose: Pose) -> tuple[Array, Array]:
        """Point and normal in world axes, with the pose of its body."""
        point, normal = np.asarray(self.point, float), np.asarray(self.normal, float)
        return pose.to_world(point), pose.rotation @ normal


def sides_of_contact(contact: ContactFields, plane: DividingPlane, pose: Pose) -> dict[str, dict[str, Any]]:
    """Figures of both sides of a contact by their names, ready for JSON; see `ContactFields.split_by_plane`."""
    parts = contact.split_by_plane(*plane.in_world(pose))
    return {name: part.summary() for name, part in zip(plane.sides, parts, strict=True)}
