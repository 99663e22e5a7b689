"""Outline of a contact: closed curves round the area that carries pressure, located within the facets.

The zero line of `results.recovery` is followed through triangles between the nodes of the facets. A quadrilateral
without a node in its middle gets one, with the level by its shape functions, so that no diagonal is chosen and the
numbers of nodes do not matter. Where the contact reaches the end of its surface, a plane of symmetry or the rim of the
other body, the curves follow these, which are not smoothed. The rest is: the scatter of its points has the length of
facets, so that waves shorter than a few of them are removed.

A smooth outline, for pressures with a root at the edge, is the zero set of a polynomial in two coordinates along the
faces:

    phi(x, y) = 1 - sum_k a_k h_k(x, y),   h_0 = x^2 + y^2,   h_m = Re (x + i y)^m and Im (x + i y)^m

x and y are relative to the semi-axes of an ellipse with the same centre and second moments. The first term changes the
size of the outline, degree 1 its place, degree 2 its axes, higher ones its shape: circles and ellipses are exact with
degree 2. Near the outline phi is twice the distance to it, relative to its size.

Smooth curves through scattered points in order: waves shorter than a length are removed, longer ones are kept.

Points at equal steps along the curve are replaced by those that minimise the sum of squared offsets and of squared
third differences (Whittaker 1923, *On a new method of graduation*; Eilers 2003, *A perfect smoother*). Of a wave of
length L the share 1 / (1 + (L0 / L)^6) is left, nearly all or nothing: with L0 half the circumference a circle keeps
98.5 % of its radius, with a fifth 99.994 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.contact.coupling.choose import line_share
from fecontact.contact.coupling.nodal import covered_shares
from fecontact.mesh.facets import components, facet_integrals, facet_shapes, places_among, sides_of, triangular
from fecontact.mesh.surface_mesh import averaged_normals
from fecontact.results.facet_samples import facet_samples, past_rim
from fecontact.results.recovery import facet_sizes
from fecontact.surfaces.facet_surface import FacetSurface

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields


#: Distance from the centre, relative to the outline's size, beyond which nothing is inside; terms of high
#: degree return there.
FARTHEST = 1.6
#: Largest change of a term by a reflection, relative to its size, that counts as rounding.
EVEN = 1e-9
#: Directions in which an outline is looked at, and steps of Newton's method to it.
RING, NEWTON = 96, 8
#: Distance from the centre, relative to the size, within which directions fade out.
NEAR_CENTRE = 1e-3


@dataclass(frozen=True, eq=False)
class Mirror:
    """A plane of symmetry: a point (3,) on it and its unit normal (3,)."""

    point: Array
    normal: Array

    def image(self, points: Array) -> Array:
        """Mirror images (..., 3) of points."""
        return np.asarray(points - 2 * ((points - self.point) @ self.normal)[..., None] * self.normal)


@dataclass(frozen=True, eq=False)
class Outline:
    """Outline of one connected contact area.

    Attributes
    ----------
    centre : (3,) array
    axes : (2, 3) array
        Unit vectors along the faces, divided by the semi-axes of the first ellipse.
    modes : (k, 2) int array
        Degree of each term, and 0 for its real or 1 for its imaginary part; degree 0 is x^2 + y^2.
    coefficients : (k,) array

    Examples
    --------
    >>> circle = Outline(np.zeros(3), np.eye(3)[:2] / 2.0, np.array([[0, 0]]), np.ones(1))
    >>> circle.level(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0]])).tolist()
    [1.0, 0.0, 0.75]
    """

    centre: Array
    axes: Array
    modes: IntArray
    coefficients: Array

    @property
    def semi_axes(self) -> tuple[float, float]:
        """Semi-axes of the ellipse by the terms of degree 0 and 2, the longer first; those of other degrees apart."""
        quadratic = {(0, 0): np.eye(2), (2, 0): np.diag([1.0, -1.0]), (2, 1): np.array([[0.0, 1.0], [1.0, 0.0]])}
        form = np.zeros((2, 2))
        for mode, a in zip(self.modes.tolist(), self.coefficients, strict=True):
            form += a * quadratic.get(tuple(mode), np.zeros((2, 2)))
        over = np.linalg.norm(self.axes, axis=1)
        long, short = np.linalg.eigvalsh(form * np.outer(over, over)) ** -0.5
        return float(long), float(short)

    def terms(self, points: Array) -> Array:
        """Values (..., k) of the terms h at points (..., 3)."""
        x, y = np.moveaxis((points - self.centre) @ self.axes.T, -1, 0)
        z, square = x + 1j * y, x**2 + y**2
        found = [square if m == 0 else (z**m).imag if part else (z**m).real for m, part in self.modes]
        return np.stack(found, axis=-1)

    def level(self, points: Array) -> Array:
        """Level phi (...,) at points (..., 3): positive inside, zero on the outline."""
        square = (((points - self.centre) @ self.axes.T) ** 2).sum(axis=-1)
        inside = 1 - self.terms(points) @ self.coefficients
        return np.where(square < FARTHEST**2, inside, np.minimum(inside, 1 - square))

    def ring(self) -> Array:
        """Points (n, 3) round the centre, on the first ellipse."""
        angle = np.linspace(0.0, 2 * np.pi, RING, endpoint=False)
        return self.centre + np.stack([np.cos(angle), np.sin(angle)], 1) @ np.linalg.pinv(self.axes).T

    def angular_terms(self, points: Array) -> Array:
        """Terms (..., k) at points (..., 3) over powers of the distance from the centre."""
        radius = np.linalg.norm((points - self.centre) @ self.axes.T, axis=-1)
        power = np.where(self.modes[:, 0] == 0, 2, self.modes[:, 0])
        return np.asarray(self.terms(points) / np.maximum(radius, NEAR_CENTRE)[..., None] ** power)

    @property
    def area(self) -> float:
        """Area inside, along the faces: half the mean square of the radius over all directions, times 2 pi."""
        shapes, radius = self.angular_terms(self.ring()), np.ones(RING)
        power = np.where(self.modes[:, 0] == 0, 2, self.modes[:, 0])
        for _ in range(NEWTON):
            terms = shapes * self.coefficients * radius[:, None] ** power
            radius = radius + (1 - terms.sum(axis=1)) * radius / (terms * power).sum(axis=1)
        over = np.linalg.norm(self.axes, axis=1)
        return float(np.pi * (radius**2).mean() / over.prod())

    def moved(self, change: Array) -> Outline:
        """The outline with its coefficients changed (k,)."""
        return replace(self, coefficients=self.coefficients + change)

    def to_degree(self, degree: int, mirrors: Sequence[Mirror]) -> Outline:
        """The same outline with all terms up to a degree that planes of symmetry leave unchanged."""
        every = [(0, 0), *((m, part) for m in range(1, degree + 1) for part in (0, 1))]
        full = replace(self, modes=np.array(every))
        ring = self.ring()
        kept = np.ones(len(every), bool)
        for mirror in mirrors:
            kept &= np.abs(full.terms(mirror.image(ring)) - full.terms(ring)).max(axis=0) < EVEN
        own = {tuple(mode): a for mode, a in zip(self.modes.tolist(), self.coefficients, strict=True)}
        modes = full.modes[kept]
        return replace(self, modes=modes, coefficients=np.array([own.get(tuple(m), 0.0) for m in modes.tolist()]))


def ellipse_of_moments(points: Array, forces: Array, normal: Array, mirrors: Sequence[Mirror]) -> Outline:
    """Ellipse with the centre and second moments of forces, taken for those of half an ellipsoid of pressure.

    For p = p0 sqrt(1 - x^2/a^2 - y^2/b^2) the mean of x^2, weighted by force, is a^2/5 (Johnson 1985, section 4.2, by
    integration).

    Parameters
    ----------
    points : (n, 3) array
    forces : (n,) array
    normal : (3,) array
        Mean normal of the faces; its part across planes of symmetry does not count.
    mirrors : sequence of Mirror
        Planes of symmetry at which the points end.
    """
    points, forces = with_images(points, forces, mirrors)
    for mirror in mirrors:
        normal = normal - (normal @ mirror.normal) * mirror.normal
    normal = normal / np.linalg.norm(normal)
    centre = forces @ points / forces.sum()
    offset = points - centre
    moments = (offset * forces[:, None]).T @ offset / forces.sum()
    along = np.linalg.svd(normal[None])[2][1:] if not mirrors else _across(normal, mirrors[0].normal)
    if not mirrors:
        along = np.linalg.eigh(along @ moments @ along.T)[1].T @ along
    spread = np.einsum("di,ij,dj->d", along, moments, along)
    return Outline(centre, along / np.sqrt(5 * spread)[:, None], np.array([[0, 0]]), np.ones(1))


def planes_of_symmetry(surface: FacetSurface, pose: Pose, numbers: IntArray) -> tuple[Mirror, ...]:
    """Planes of symmetry, in world axes, of a body's surface on which some of the numbered nodes lie."""
    if surface.planes is None:
        return ()
    nodes, normals = surface.planes
    on = np.isin(nodes, numbers)
    nodes, normals = nodes[on], normals[on]
    first = np.sort(np.unique(normals.round(6), axis=0, return_index=True)[1])
    points = pose.to_world(surface.points[nodes[first]])
    return tuple(Mirror(x, n) for x, n in zip(points, normals[first] @ pose.rotation.T, strict=True))


def with_images(points: Array, values: Array, mirrors: Sequence[Mirror]) -> tuple[Array, Array]:
    """Points (n, 3) and values (n,) with their mirror images."""
    for mirror in mirrors:
        points = np.concatenate([points, mirror.image(points)])
        values = np.concatenate([values, values])
    return points, values


def _across(normal: Array, plane: Array) -> Array:
    """Two unit vectors (2, 3) normal to a normal: the first along that of a plane of symmetry."""
    first = plane - (plane @ normal) * normal
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


#: Length of a wave of which half is left, in steps of scatter, and at most as a share of a closed curve.
WAVE, MAX_SHARE = 3.0, 0.25
#: Points for each step of scatter, and on a curve at least.
DENSITY, MIN_POINTS = 6, 24
#: Length beyond the ends of a stretch, in waves, by which it is continued.
CONTINUED = 3
#: Distance from a plane of symmetry, in steps, that is on it.
ON_PLANE = 1e-3
#: Order of the differences.
ORDER = 3


def smoothed(points: Array, smooth: Mask, step: Array, mirrors: Sequence[Mirror] = ()) -> tuple[Array, Mask]:
    """A closed curve with some stretches smoothed, and which of its segments these are.

    Parameters
    ----------
    points : (n, d) array
        In order; the first follows the last.
    smooth : (n,) bool array
        Whether the segment from a point to the next is to be smoothed. Ends of a stretch stay where they are.
    step : (n,) array
        Length of the scatter at each point, such as the size of a facet.
    mirrors : sequence of Mirror
        Planes of symmetry: a stretch that ends on one is smooth with its mirror image.

    Examples
    --------
    A circle of 24 facets, its points off by a tenth of a facet to either side in turn:

    >>> angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    >>> radius = 1 + 0.026 * (-1.0) ** np.arange(48)
    >>> circle = np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)
    >>> found, _ = smoothed(circle, np.ones(48, bool), np.full(48, 0.26))
    >>> bool(np.ptp(np.linalg.norm(found, axis=1)) < 2e-3)
    True
    """
    if smooth.all():
        found = _graduated(np.concatenate([points, points[:1]]), np.append(step, step[0]), closed=True)
        return found, np.ones(len(found), bool)
    if not smooth.any():
        return points, smooth
    start = int(np.flatnonzero(~smooth)[0])
    points, smooth, step = np.roll(points, -start, axis=0), np.roll(smooth, -start), np.roll(step, -start)
    breaks = np.flatnonzero(np.diff(smooth.astype(int))) + 1
    parts, kinds = [], []
    for chosen in np.split(np.arange(len(points)), breaks):
        piece = points[chosen]
        if smooth[chosen[0]]:
            ends = np.append(chosen, (chosen[-1] + 1) % len(points))
            piece = _graduated(points[ends], step[ends], mirrors=mirrors)[:-1]
        parts.append(piece)
        kinds.append(np.full(len(piece), smooth[chosen[0]]))
    return np.concatenate(parts), np.concatenate(kinds)


def _graduated(points: Array, step: Array, *, closed: bool = False, mirrors: Sequence[Mirror] = ()) -> Array:
    """Smoothed points (k, d) at equal steps along a polyline (n, d); of a closed one without the last."""
    place = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1) * 2 / (step[1:] + step[:-1])))
    n = max(MIN_POINTS, int(np.ceil(DENSITY * place[-1])))
    even = np.linspace(0.0, place[-1], n + 1)
    x = np.stack([np.interp(even, place, column) for column in points.T], axis=1)
    # a stretch is half of a curve or less
    wave = n / place[-1] * min(WAVE, (1 if closed else 2) * MAX_SHARE * place[-1])
    beyond = min(n, int(np.ceil(CONTINUED * wave)))
    if closed:
        x = x[:-1]
        long = np.concatenate([x[-beyond:], x, x[:beyond]])
    else:
        first = _reflected(x[1 : beyond + 1], x[0], ON_PLANE * step[0], mirrors)[::-1]
        last = _reflected(x[-beyond - 1 : -1][::-1], x[-1], ON_PLANE * step[-1], mirrors)
        long = np.concatenate([first, x, last])
    rough = sp.eye_array(len(long), format="csc")
    for k in range(ORDER):
        rough = sp.diags_array([-1.0, 1.0], offsets=[0, 1], shape=(len(long) - k - 1, len(long) - k)) @ rough
    penalty = (2 * np.sin(np.pi / wave)) ** (-2 * ORDER)
    found = spsolve(sp.csc_array(sp.eye_array(len(long)) + penalty * rough.T @ rough), long)
    return np.asarray(found[beyond : beyond + len(x)])


def _reflected(points: Array, end: Array, near: float, mirrors: Sequence[Mirror]) -> Array:
    """Points (n, d) beyond an end: mirror images if it lies on a plane of symmetry, else images in the end itself."""
    for mirror in mirrors:
        if abs((end - mirror.point) @ mirror.normal) < near:
            return mirror.image(points)
    return np.asarray(2 * end - points)


#: By number of columns of a quadrilateral and of a triangle: triangles between its nodes, the last one in its middle.
QUADRILATERALS = {
    4: ((0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    8: ((0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 8), (5, 6, 8), (6, 7, 8), (7, 4, 8)),
    9: ((0, 4, 8), (4, 1, 8), (1, 5, 8), (5, 2, 8), (2, 6, 8), (6, 3, 8), (3, 7, 8), (7, 0, 8)),
}
TRIANGLES = {
    4: ((0, 1, 2),),
    8: ((0, 4, 7), (4, 1, 5), (5, 2, 7), (4, 5, 7)),
    9: ((0, 4, 8), (4, 1, 8), (1, 5, 8), (5, 2, 8), (2, 7, 8), (7, 0, 8)),
}
#: Least level, relative to the largest: the edge runs between nodes, not through them.
OFF_NODE = 1e-6
#: Passes over hanging nodes that lie between hanging nodes.
CHAINS = 3
#: Samples of the side of a section, an even number.
SAMPLES = 8
#: Halvings by which the rim of the other body is found between two nodes.
HALVINGS = 20


@compact_repr
@dataclass(frozen=True, eq=False)
class OutlineCurve:
    """A closed curve round a contact area, or round a hole in it.

    Attributes
    ----------
    points : (n, 3) array
        Points in order, in world axes; the first follows the last. The contact is on the left seen from outside the
        slave.
    is_edge : (n,) bool array
        Whether the contact ends by itself between a point and the next; else a plane of symmetry, the end of a surface
        or the rim of the other body bounds it.
    area : float
        Area inside, seen along its mean normal; negative for a hole.
    """

    points: Array
    is_edge: Mask
    area: float


@compact_repr
@dataclass(frozen=True, eq=False)
class ContactOutline:
    """Outline of a contact.

    Attributes
    ----------
    areas : (n_facets,) array
        Area of each facet within the outline.
    contact : ContactFields
    cut : _Cut, optional
        Triangles of its facets, cut by the outline; None for sections.
    """

    areas: Array
    contact: ContactFields = field(repr=False)
    cut: _Cut | None = field(default=None, repr=False)

    @cached_property
    def curves(self) -> tuple[OutlineCurve, ...]:
        """Closed curves, the longest area first; none for sections."""
        return () if self.cut is None else _curves(self.contact, self.cut, _hanging(self.contact))

    @property
    def area(self) -> float:
        """Area within the outline, along the facets."""
        return float(self.areas.sum())


class _Cut(NamedTuple):
    """Triangles between nodes, cut by the outline.

    Attributes
    ----------
    points : (m, 3) array
        Nodes of the contact's facets, then middles of quadrilaterals that have no node there.
    around : (k, 4) int array
        Nodes round each such middle.
    corners : (n, 3) int array
        Nodes, counter-clockwise seen from outside.
    facet : (n,) int array
    inside, beyond : (m,) bool arrays
        Nodes inside the outline, and nodes beyond the rim of the other body.
    crossed : (k, 2) int array
        Pairs of nodes between which the outline runs, the inner one first.
    share : (k,) array
        Its place between them, from 0 at the inner one to 1.
    """

    points: Array
    around: IntArray
    corners: IntArray
    facet: IntArray
    inside: Mask
    beyond: Mask
    crossed: IntArray
    share: Array

    def with_middles(self, values: Array) -> Array:
        """Values at the nodes, and their means at the middles."""
        return np.concatenate([values, values[self.around].mean(axis=1)])

    @property
    def sides(self) -> IntArray:
        """Directed sides (3 n, 2) of the triangles."""
        return sides_of(self.corners).reshape(-1, 2)

    def crossing(self, sides: IntArray) -> IntArray:
        """Number (n,) of the crossing of each side (n, 2) with one node inside."""
        m = len(self.inside)
        turned = np.where(self.inside[sides[:, :1]], sides, sides[:, ::-1])
        return np.searchsorted(self.crossed @ [m, 1], turned @ [m, 1])


def contact_outline(contact: ContactFields) -> ContactOutline:
    """Outline of a contact; of sections the areas only.

    Parameters
    ----------
    contact : ContactFields
    """
    level, hanging = contact._edge_level.copy(), _hanging(contact)
    for _ in range(CHAINS):
        level[hanging[:, 2]] = level[hanging[:, :2]].mean(axis=1)
    beyond = _beyond(contact, level)
    if contact.facets.shape[1] == 3:
        return ContactOutline(_to_covered(contact, level, beyond, *_section_areas(contact, level)), contact)
    cut = _cut(contact, level, beyond)
    return ContactOutline(_to_covered(contact, level, beyond, *_areas(contact, cut)), contact, cut)


def _beyond(contact: ContactFields, level: Array) -> Mask:
    """Nodes (m,) that face nothing or, of facets with a node inside, lie past the rim of the other body.

    With nodal coupling all nodes past the rim face nothing.
    """
    beyond = np.diff(contact._at_nodes.indptr) == 0
    if contact.coupling != "mortar":
        return beyond
    beside = np.zeros(len(level), bool)
    beside[contact.facets[(level > 0)[contact.facets].any(axis=1)]] = True
    shown = np.flatnonzero(beside & ~beyond)
    beyond[shown] = past_rim(contact, contact.nodes[shown])
    return beyond


def _to_covered(contact: ContactFields, level: Array, beyond: Mask, areas: Array, whole: Array) -> Array:
    """Areas (n_facets,) of which no facet at the rim has more than is covered, and all of it if only the rim ends it.

    Chords would cut off the corners of the other body, and halvings find its sides to 1e-6 of a face; the covered share
    is exact.
    """
    slave, master, inside = contact.slave, contact.master, level > 0
    rim = np.flatnonzero(beyond[contact.facets].any(axis=1) & inside[contact.facets].any(axis=1))
    if not len(rim):
        return areas
    pose, surface, numbers = (
        slave.pose.relative_to(master.pose),
        master.surface(contact.surfaces[1]),
        contact._facet_numbers[rim],
    )
    shares = covered_shares(
        contact._surface, surface, pose.rotation, pose.translation, numbers, line_share(slave, master)
    )
    covered = whole[rim] * shares
    only_rim = (inside | beyond)[contact.facets[rim]].all(axis=1)
    areas[rim] = np.where(only_rim, covered, np.minimum(areas[rim], covered))
    return areas


def _cut(contact: ContactFields, level: Array, beyond: Mask) -> _Cut:
    """Triangles between the nodes of the contact's facets, cut where its level is zero."""
    corners, facet, bare = _triangles(contact.facets, len(level))
    quads = contact.facets[bare]
    N = facet_shapes(quads.shape[1], np.zeros(1, bool), np.full((1, 2), 0.5))[0][0]
    around = quads[:, -4:]
    facing = ~beyond[around]
    mean = (level[around] * facing).sum(axis=1) / np.maximum(facing.sum(axis=1), 1)
    points = np.concatenate([contact.nodes, np.einsum("a,fai->fi", N, contact.nodes[quads])])
    level = np.append(level, np.where(facing.all(axis=1), level[quads] @ N, mean))
    beyond = np.append(beyond, ~facing.any(axis=1))
    some = len(contact.nodes) + np.flatnonzero(facing.any(axis=1) & ~facing.all(axis=1))
    beyond[some] = past_rim(contact, points[some])
    least = OFF_NODE * np.abs(level).max()
    level = np.where(np.abs(level) < least, least, level)
    inside = (level > 0) & ~beyond
    sides = sides_of(corners).reshape(-1, 2)
    sides = np.concatenate([sides, sides[:, ::-1]])
    crossed = np.unique(sides[inside[sides[:, 0]] & ~inside[sides[:, 1]]], axis=0)
    inner, outer = level[crossed].T
    rim = beyond[crossed[:, 1]]
    share = inner / (inner - np.where(rim, -inner, outer))
    share[rim] = _to_rim(contact, *points[crossed[rim]].transpose(1, 0, 2))
    return _Cut(points, around, corners, facet, inside, beyond, crossed, share)


def _triangles(facets: IntArray, n: int) -> tuple[IntArray, IntArray, IntArray]:
    """Triangles (k, 3) of facets, the facet (k,) of each, and quadrilaterals whose middles are the nodes from n on."""
    kind, columns = triangular(facets), facets.shape[1]
    bare = np.flatnonzero(~kind & (columns < 9))
    numbered = np.column_stack([facets, np.zeros(len(facets), np.int64)])
    numbered[bare, -1] = n + np.arange(len(bare))
    corners, owner = [], []
    for chosen, table in ((~kind, QUADRILATERALS), (kind, TRIANGLES)):
        places = np.array(table[columns])
        corners.append(numbered[chosen][:, places].reshape(-1, 3))
        owner.append(np.repeat(np.flatnonzero(chosen), len(places)))
    return np.concatenate(corners), np.concatenate(owner), bare


def _hanging(contact: ContactFields) -> IntArray:
    """Sides (n, 3) between nodes of coarse facets, divided on the other side: both ends and the middle."""
    ties = contact._surface.hanging
    if ties is None or not len(ties.edges):
        return np.zeros((0, 3), np.int64)
    linear = ties.edges[:, 3] < 0
    ends = [ties.edges[linear][:, [0, 2, 1]], *(ties.edges[~linear][:, k] for k in ([0, 1, 3], [1, 2, 4]))]
    place = places_among(contact._node_numbers, len(contact._surface.points))
    here = place[np.concatenate(ends)]
    return np.asarray(here[(here >= 0).all(axis=1)])


def _to_rim(contact: ContactFields, start: Array, end: Array) -> Array:
    """Place (n,) of the rim of the other body on ways from points (n, 3) to others, by halving."""
    way, low, high = end - start, np.zeros(len(start)), np.ones(len(start))
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        past = past_rim(contact, start + middle[:, None] * way)
        low, high = np.where(past, low, middle), np.where(past, middle, high)
    return (low + high) / 2


def _areas(contact: ContactFields, cut: _Cut) -> tuple[Array, Array]:
    """Area (n_facets,) of each facet inside the outline, and its whole area."""
    x, inside = cut.points[cut.corners], cut.inside[cut.corners]
    flat = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
    count = inside.sum(axis=1)
    # a corner alone on its side cuts off the product of the shares, from it, of the two sides at it
    alone = np.argmax(inside == (count == 1)[:, None], axis=1)
    each = np.arange(len(x))
    sides = sides_of(cut.corners)
    part = (count == 3).astype(float)
    some = (count == 1) | (count == 2)
    pairs = (sides[each, k][some] for k in (alone, (alone + 2) % 3))
    shares = [cut.share[cut.crossing(pair)] for pair in pairs]
    one = count[some] == 1
    off = np.prod([np.where(one, s, 1 - s) for s in shares], axis=0)
    part[some] = np.where(one, off, 1 - off)
    n = len(contact.facets)
    whole = np.linalg.norm(facet_integrals(contact.nodes, contact.facets)[2], axis=2).sum(axis=1)
    return np.asarray(whole * np.bincount(cut.facet, part * flat, n) / np.bincount(cut.facet, flat, n)), whole


def _section_areas(contact: ContactFields, levels: Array) -> tuple[Array, Array]:
    """Area (n,) inside the edge of each side of a section by the levels at both ends and the middle, and whole area."""
    level = levels[contact.facets]
    samples = facet_samples(contact.nodes, contact.facets, False, contact._extent, SAMPLES)
    place, which = samples.local[:, 0], (samples.local[:, 0] > 0.5).astype(int)
    first, last = level[:, [0, 2]][:, which], level[:, [2, 1]][:, which]
    share = (2 * place - which)[None]
    # each sample counts by the part of it that is inside
    at = first + share * (last - first)
    change = np.abs(last - first) * 2 / SAMPLES
    part = np.divide(at, change, out=np.sign(at), where=np.abs(at) < change)
    return (samples.areas * np.clip(part + 0.5, 0, 1)).sum(axis=1), samples.areas.sum(axis=1)


def _curves(contact: ContactFields, cut: _Cut, hanging: IntArray) -> tuple[OutlineCurve, ...]:
    """Smooth closed curves, the longest area first."""
    start, end, is_edge = _segments(cut, hanging)
    inner, outer = cut.points[cut.crossed].transpose(1, 0, 2)
    vertices = np.concatenate([cut.points, inner + cut.share[:, None] * (outer - inner)])
    of_node = cut.with_middles(facet_sizes(contact.nodes, contact.facets))
    sizes = np.concatenate([of_node, of_node[cut.crossed].mean(axis=1)])
    normals = cut.with_middles(averaged_normals(contact.nodes, contact.facets)[0])
    normals = np.concatenate([normals, normals[cut.crossed].sum(axis=1)])
    mirrors = planes_of_symmetry(contact._surface, contact.slave.pose, contact._node_numbers)
    out = []
    for chosen in _loops(start, end):
        own = start[chosen]
        points, smooth = smoothed(vertices[own], is_edge[chosen], sizes[own], mirrors)
        offset = points - points.mean(axis=0)
        area = np.cross(offset, np.roll(offset, -1, axis=0)).sum(axis=0) / 2
        sign = 1.0 if area @ normals[own].sum(axis=0) > 0 else -1.0
        out.append(OutlineCurve(points, smooth, float(sign * np.linalg.norm(area))))
    return tuple(sorted(out, key=lambda curve: -curve.area))


def _segments(cut: _Cut, hanging: IntArray) -> tuple[IntArray, IntArray, Mask]:
    """Segments of the outline: vertices at start and end (n,), nodes or after them crossings, and what is an edge."""
    m, inside = len(cut.inside), cut.inside
    same = _merged(cut, hanging)
    sides = cut.sides
    leaving = inside[sides[:, 0]] & ~inside[sides[:, 1]]
    entering = ~inside[sides[:, 0]] & inside[sides[:, 1]]
    here = leaving.reshape(-1, 3).any(axis=1)
    # a triangle is left by one side and entered by another, with the contact on the left of the line between
    one, two = (same[cut.crossing(sides[part])] for part in (leaving, entering))
    rim = cut.beyond[cut.crossed[:, 1]]
    assert here.sum() == len(one)
    ends = _end_sides(cut, hanging)
    ends = ends[inside[ends].any(axis=1)]
    whole = inside[ends]
    cuts = np.full(len(ends), -1)
    some = ~whole.all(axis=1)
    cuts[some] = m + same[cut.crossing(ends[some])]
    start, end = (np.where(whole[:, k], ends[:, k], cuts) for k in (0, 1))
    return (
        np.concatenate([m + one, start]),
        np.concatenate([m + two, end]),
        np.concatenate([~(rim[one] & rim[two]), np.zeros(len(ends), bool)]),
    )


def _merged(cut: _Cut, hanging: IntArray) -> IntArray:
    """For each crossing the one that stands for it: on a side that is divided beyond, the one on its half."""
    same = np.arange(len(cut.crossed))
    low, high, middle = hanging.T
    split = cut.inside[low] != cut.inside[high]
    low, high, middle = low[split], high[split], middle[split]
    other = np.where(cut.inside[middle] == cut.inside[low], high, low)
    key = cut.crossed @ [len(cut.inside), 1]

    def number(one: IntArray, two: IntArray) -> IntArray:
        pair = np.stack([one, two], axis=1)
        pair = np.where(cut.inside[pair[:, :1]], pair, pair[:, ::-1]) @ [len(cut.inside), 1]
        at = np.minimum(np.searchsorted(key, pair), len(key) - 1)
        return np.where(key[at] == pair, at, -1)

    coarse, fine = number(low, high), number(middle, other)
    both = (coarse >= 0) & (fine >= 0)
    same[coarse[both]] = fine[both]
    return same


def _end_sides(cut: _Cut, hanging: IntArray) -> IntArray:
    """Directed sides (n, 2) of triangles that have no neighbour, where the facets end."""
    m = len(cut.inside)
    sides = cut.sides
    key = sides @ [m, 1]
    alone = ~np.isin(sides[:, ::-1] @ [m, 1], key)
    free, met = key[alone], np.zeros(0, np.int64)
    low, high, middle = hanging.T
    for one, two in ((low, high), (high, low)):
        # a coarse side, and its halves the other way
        three = np.stack([one * m + two, two * m + middle, middle * m + one])
        met = np.append(met, three[:, np.isin(three, free).all(axis=0)])
    return sides[alone][~np.isin(free, met)]


def _loops(start: IntArray, end: IntArray) -> list[IntArray]:
    """Segments of each closed curve in order; each vertex ends as many segments as it starts."""
    n = len(start)
    after = np.empty(n, np.int64)
    after[np.argsort(end, kind="stable")] = np.argsort(start, kind="stable")
    label = components(n, np.stack([np.arange(n), after], axis=1))
    first = np.unique(label, return_index=True)[1]
    # number of steps to the first segment of the curve, by doubling
    last = after == first[label]
    steps, way = np.where(last, 0, 1), np.where(last, np.arange(n), after)
    for _ in range(int(np.ceil(np.log2(max(n, 2))))):
        steps, way = steps + steps[way], way[way]
    order = np.lexsort((-steps, label))
    return np.split(order, np.flatnonzero(np.diff(label[order])) + 1) if n else []
