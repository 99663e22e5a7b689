"""Pressures without bound: where a sharp edge of one body presses on another that goes on and gives.

Beside the end of a wedge of angle phi the pressure grows as r^(lambda - 1). Without shear the normal displacement of a
wedge under that pressure is proportional to

    c(phi) = (sin(2 lambda phi) + lambda sin(2 phi)) / (sin(lambda phi)^2 - lambda^2 sin(phi)^2) / E*

and those of both bodies add up to none: c1(phi) + c2(pi) = 0 with the smallest root from 1/2 on (Williams 1952, *Stress
singularities resulting from various boundary conditions in angular corners of plates in extension*; Dundurs & Lee 1972,
*Stress concentration at a sharp edge in contact problems*). For a right-angled end lambda is 1/2 if it is rigid, 0.774
on a body of its own material, 1 on a rigid one. Ends are taken as right-angled. With friction it is that of
`results.singular`, by what most of the force at the edge does: stick or slide.

Order of the pressure at the edge of a body pressed on another with friction, a wedge on a half-plane.

Beside the end of a wedge the stresses grow as r^(lambda - 1) also where friction holds it: a block that spreads under
pressure is held by a rough plate, and its corner carries a pressure without bound, which no mesh resolves. Williams's
stress function r^(lambda + 1) F of each body has four terms (Williams 1952, *Stress singularities resulting from
various boundary conditions in angular corners of plates in extension*). On their free sides both stresses vanish; where
they touch, stresses and displacements are continuous where they stick (Bogy 1971, *Two edge-bonded elastic wedges*),
and where they slide the shear is mu times the pressure (Comninou 1976, *Stress singularity at a sharp edge in contact
problems with friction*). lambda is the smallest root of the determinant.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import elastic_among
from fecontact.bodies.rims import Rim, ends_near, rim_of_surface
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.error_estimate import UnboundedPeak
from fecontact.halfspace.grid_error import FALLS
from fecontact.mesh.facets import unit_vectors
from fecontact.results.friction_fields import FrictionFields
from fecontact.surfaces.facet_surface import FacetSurface, facets_of
from fecontact.surfaces.rigid.shapes import heights_of, sharpest

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields

#: Values of lambda between which roots are looked for.
TRIED = np.linspace(0.02, 0.98, 193)
#: Angles of the wedge and of the half-plane.
WEDGE, HALF_PLANE = np.pi / 2, -np.pi


@lru_cache(maxsize=64)
def rough_eigenvalue(wedge: tuple[float, float], below: tuple[float, float] | None, shear: float | None) -> float:
    """Smallest lambda below one of a right-angled wedge on a half-plane; one where the stresses are bounded.

    Parameters
    ----------
    wedge, below : (float, float)
        Kolosov's constant and shear modulus of wedge and half-plane; None where that is rigid.
    shear : float or None
        Shear on the wedge over the pressure where it slides, positive towards its inside; None where it sticks.

    Examples
    --------
    On a rough rigid plane, sin(lambda pi / 2)^2 = ((kappa + 1)^2 - 4 lambda^2) / (4 kappa) (Williams 1952); bonded to a
    half-plane of its material it is the notch of 270 degrees:

    >>> round(rough_eigenvalue((1.8, 1.0), None, None), 3), round(rough_eigenvalue((1.8, 1.0), (1.8, 1.0), None), 4)
    (0.711, 0.5445)
    """
    values = np.array([_determinant(float(root), wedge, below, shear) for root in TRIED])
    first = np.flatnonzero(values[1:] * values[:-1] < 0)
    if not len(first):
        return 1.0
    ends = TRIED[first[0]], TRIED[first[0] + 1]
    return float(brentq(_determinant, *ends, args=(wedge, below, shear)))


def _determinant(
    root: float, wedge: tuple[float, float], below: tuple[float, float] | None, shear: float | None
) -> float:
    end, side = _fields(root, WEDGE, *wedge), _fields(root, 0.0, *wedge)
    if below is None:
        held = side[2] if shear is None else side[1] - shear * side[0]
        return float(np.linalg.det(np.stack([end[0], end[1], side[3], held])))
    free, beside = _fields(root, HALF_PLANE, *below), _fields(root, 0.0, *below)
    none = np.zeros((2, 4))
    jumps = np.concatenate([side, -beside], axis=1)
    if shear is not None:
        jumps[2] = np.concatenate([side[1] - shear * side[0], none[0]])
    rows = [np.concatenate([end[:2], none], axis=1), np.concatenate([none, free[:2]], axis=1), jumps]
    return float(np.linalg.det(np.concatenate(rows)))


def _fields(root: float, angle: float, kappa: float, shear_modulus: float) -> Array:
    """Stresses across and along a ray, displacements along and across it (4, 4) by the terms of F, over r^lambda."""
    a, b = root + 1, root - 1
    one, two = np.array([np.cos(a * angle), np.sin(a * angle)]), np.array([np.cos(b * angle), np.sin(b * angle)])
    turned_one, turned_two = np.array([-one[1], one[0]]), np.array([-two[1], two[0]])
    return np.stack(
        [
            np.concatenate([a * one, a * two]),
            -np.concatenate([a * turned_one, b * turned_two]),
            np.concatenate([-a * one, (kappa - root) * two]) / (2 * shear_modulus),
            -np.concatenate([a * turned_one, (kappa + root) * turned_two]) / (2 * shear_modulus),
        ]
    )


#: Exponent 1 - lambda below which a pressure counts as bounded.
BOUNDED = 0.05
#: The same of a single point with friction, above which it grows there.
GROWS = 1.01
#: Power of the distance up to which a rise is a kink, and its least slope times E*, over the highest pressure.
KINK, MIN_KINK = 1.1, 0.1
#: Distance from its own rim, relative to a face, at which a node counts as on it.
ON_RIM = 1e-3
#: Distance between the edges of two elastic bodies, relative to a face, up to which they end together.
FLUSH = 0.02
#: Cosine between a side and a plane's normal up to which it lies in the plane.
IN_PLANE = 1e-5


@dataclass(frozen=True, eq=False)
class SingularEdge:
    """Where a pressure has no bound.

    Attributes
    ----------
    peak : UnboundedPeak
    points : (n,) bool array
        Contact points at the edge.
    """

    peak: UnboundedPeak
    points: Mask


def singular_edge(contact: ContactFields) -> SingularEdge | None:
    """The edge with the worst singularity of a contact's pressure; None where there is none."""
    active = np.flatnonzero(contact.active)
    bodies = (contact.slave, contact.master)
    pairs = (bodies, bodies[::-1])
    exponents = [edge_exponent(body, other) for body, other in pairs]
    rough = contact.friction is not None
    if not len(active):
        return None
    if not (rough or max(exponents) >= BOUNDED):
        return _sharp_tip(contact)
    mean = contact.forces[active].sum() / contact.weights[active].sum()
    found = []
    for pair, exponent, here in zip(pairs, exponents, _at_edges(contact, active), strict=True):
        at, body = active[here], pair[0]
        if rough:  # only where it grows towards the edge: not behind a dragged block, nor in a uniform state
            at = at[contact.forces[at] > GROWS * mean * contact.weights[at]]
        if not len(at) or contact.forces[at].sum() < FALLS * mean * contact.weights[at].sum():
            continue
        if contact.friction is not None:
            exponent = _rough_exponent(contact, contact.friction, at, pair, exponent)
        if exponent < BOUNDED:
            continue
        highest = at[np.argmax(contact.forces[at] / contact.weights[at])]
        x, y, z = (float(v) for v in contact.points[highest])
        points = np.zeros(len(contact.forces), bool)
        points[at] = True
        found.append(SingularEdge(UnboundedPeak(body.name, (x, y, z), exponent), points))
    return max(found, key=lambda edge: edge.peak.exponent, default=_sharp_tip(contact))


def _sharp_tip(contact: ContactFields) -> SingularEdge | None:
    """The tip of a rigid shape within a face of the highest pressure, which grows towards it; None where there is none.

    Below a kink of angle t the pressure is E* t / pi log(1/r), below a cone half as much again (Johnson 1985, sections
    5.2 and 5.3), below a tip r^n with n < 1 it is r^(n - 1).
    """
    master, heights = contact.master, heights_of(contact.master.surface(contact.surfaces[1]))
    if heights is None or contact.slave._is_foundation:
        return None
    pressure = contact.forces / contact.weights
    highest = int(np.argmax(pressure))
    surface = facets_of(contact.slave.surface(contact.surfaces[0]))
    assert surface is not None
    size = float(surface.mean_facet_size[contact._sharing[highest].indices].mean())
    tip = sharpest(heights, master.pose.to_body(contact.points[[highest]])[0, :2], size)
    if tip.power > KINK or contact.slave.contact_modulus * tip.slope < MIN_KINK * pressure[highest]:
        return None
    x, y, z = (float(v) for v in contact.points[highest])
    exponent = 1 - tip.power if 1 - tip.power > BOUNDED else 0.0
    return SingularEdge(UnboundedPeak(master.name, (x, y, z), exponent), np.zeros(len(pressure), bool))


def edge_exponent(body: Body, other: Body) -> float:
    """Exponent of the inverse distance with which the pressure grows towards an edge of a body on another.

    Zero where the other is rigid, or a foundation of springs, which gives under its own pressure only.
    """
    if np.isinf(other.contact_modulus) or other._is_foundation or body._is_foundation:
        return 0.0
    stiffness = body.contact_modulus / other.contact_modulus
    return 0.5 if np.isinf(stiffness) else 1.0 - wedge_eigenvalue(np.pi / 2, stiffness)


def _rough_exponent(
    contact: ContactFields, friction: FrictionFields, at: IntArray, pair: tuple[Body, Body], smooth: float
) -> float:
    """Exponent at points `at` of the edge of a body on another with friction; that without it where shear is unknown.

    Whether the edge sticks is judged by its facets, as its last nodes slide in any case. Where it slides the shear is
    towards the inside of the body or out of it, as of most of them.
    """
    body, other = pair
    own, below = _shear_stiffness(body), _shear_stiffness(other)
    if own is None or (below is None and np.isfinite(other.contact_modulus)):
        return smooth
    shear = None
    facets = np.asarray(contact._sharing[at].sum(axis=0)).ravel() > 0
    beside = np.flatnonzero(contact.active & (contact._sharing @ facets > 0))
    if friction.sticking[beside].mean() < 0.5:
        on_body = friction.forces[at] if body is contact.slave else -friction.forces[at]
        inwards = contact.points[contact.active].mean(axis=0) - contact.points[at]
        shear = float(np.sign((on_body * inwards).sum()) * np.linalg.norm(on_body, axis=1).sum())
        shear /= contact.forces[at].sum()
    return max(1.0 - rough_eigenvalue(own, below, shear), smooth)


def _shear_stiffness(body: Body) -> tuple[float, float] | None:
    """Kolosov's constant and shear modulus of an elastic body's softest material; None for others."""
    for elastic in elastic_among([body]):
        modulus = elastic.contact_modulus
        if elastic.model.is_directed:
            return None
        softest = min(elastic.model.materials, key=lambda m: m.plane_strain_modulus)
        return 8 * softest.shear_modulus / modulus - 1, softest.shear_modulus
    return None


def wedge_eigenvalue(angle: float, stiffness: float) -> float:
    """Smallest lambda from 1/2 to 1 for a wedge of an angle up to pi on a half-plane, by the ratio of their moduli.

    Examples
    --------
    >>> [round(wedge_eigenvalue(np.pi / 2, ratio), 3) for ratio in (1e9, 1.0, 1e-9)]
    [0.5, 0.774, 1.0]
    >>> round(wedge_eigenvalue(np.pi, 1.0), 3)
    0.5
    """

    def equation(root: float) -> float:
        wedge = np.sin(2 * root * angle) + root * np.sin(2 * angle)
        below = np.sin(root * angle) ** 2 - root**2 * np.sin(angle) ** 2
        return float(wedge * np.sin(np.pi * root) + 2 * stiffness * below * np.cos(np.pi * root))

    low, high = 0.5 + 1e-9, 1 - 1e-9
    if equation(low) <= 0:
        return 0.5
    return float(brentq(equation, low, high)) if equation(high) < 0 else 1.0


def _at_edges(contact: ContactFields, active: IntArray) -> tuple[Mask, Mask]:
    """Whether active points lie at an edge of the slave inside the master's surface, and the converse.

    Two elastic bodies whose edges lie beside each other end together where they are flush only: else the pressure grows
    towards the inner one, though faces larger than the step between them do not show it.
    """
    slave, master, names = contact.slave, contact.master, contact.surfaces
    surface = facets_of(slave.surface(names[0]))
    assert surface is not None
    shared = contact._sharing[active]
    size = (shared @ surface.mean_facet_size) / np.maximum(np.asarray(shared.sum(axis=1)).ravel(), 1)
    spacing = size if surface.facets.shape[1] == 4 else size / 2
    place, none = contact.points[active], np.zeros(len(active), bool)
    theirs, beyond = master.pose.to_body(place), none
    lines = contact.normals[active] @ master.pose.rotation
    lines = unit_vectors(lines)
    if not master.is_rigid:
        offset = theirs - master.surface(names[1]).project(theirs).points
        theirs = theirs - offset
        along = (offset * lines).sum(axis=1, keepdims=True)
        at, near = _near_sharp_rim(master, names[1], theirs, spacing, FLUSH * size)
        beyond = near & (np.linalg.norm(offset - along * lines, axis=1) > FLUSH * size)
    else:
        near = ends_near(master, names[1], theirs, lines, size)
        if contact.friction is None and not near.any():  # its own edges are bounded on a rigid body
            return none, none
        at = ends_near(master, names[1], theirs, lines, spacing)
    ours, near_ours = _near_sharp_rim(slave, names[0], slave.pose.to_body(place), ON_RIM * size, size)
    return ours & ~near, at & (beyond | ~near_ours)


def _near_sharp_rim(body: Body, name: str, points: Array, reach: Array, size: Array) -> tuple[Mask, Mask]:
    """Whether points (n, 3) lie within distances (n,) of a sharp edge of a body, planes of symmetry excluded."""
    rim, surface = rim_of_surface(body, name), facets_of(body.surface(name))
    none = np.zeros(len(points), bool)
    if rim is None or surface is None:
        return none, none
    chosen = ~_in_planes(surface, rim)
    if not rim.within(points, np.maximum(reach, size), chosen).any():
        return none, none
    chosen &= ~rim.smooth
    return rim.within(points, reach, chosen), rim.within(points, size, chosen)


def _in_planes(surface: FacetSurface, rim: Rim) -> Mask:
    """Whether sides (n,) of a rim lie in a plane of symmetry of the surface."""
    out = np.zeros(len(rim.size), bool)
    if surface.planes is None:
        return out
    nodes, normals = surface.planes
    along = rim.ends[:, 1] - rim.ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    for normal in np.unique(np.abs(normals.round(6)), axis=0):  # two or three
        mine = nodes[np.abs(np.abs(normals @ normal) - 1) < IN_PLANE]
        out |= np.isin(rim.nodes, mine).all(axis=1) & (np.abs(along @ normal) <= IN_PLANE * length)
    return out
