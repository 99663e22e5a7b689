"""Outline of a contact: closed curves round the area that carries pressure, located within the facets.

The zero line of `results.edge_level` is followed through triangles between the nodes of the facets. A quadrilateral
without a node in its middle gets one, with the level by its shape functions, so that no diagonal is chosen and the
numbers of nodes do not matter. Where the contact reaches the end of its surface, a plane of symmetry or the rim of the
other body, the curves follow these, which are not smoothed. The rest is: the scatter of its points has the length of
facets, so that waves shorter than a few of them are removed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.one_line import one_line
from fecontact.contact.coupling.choose import line_share
from fecontact.contact.coupling.covered_area import covered_shares
from fecontact.mesh.facets import facet_integrals, facet_shapes, sides_of, triangular
from fecontact.mesh.surface_mesh import averaged_normals
from fecontact.results.edge_level import edge_level, facet_sizes
from fecontact.results.facet_samples import facet_samples
from fecontact.results.outline import planes_of_symmetry, smoothed

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields

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


@one_line
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


@one_line
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
    level, hanging = edge_level(contact), _hanging(contact)
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
    beyond = np.diff(contact.at_nodes.indptr) == 0
    if contact.coupling != "mortar":
        return beyond
    beside = np.zeros(len(level), bool)
    beside[contact.facets[(level > 0)[contact.facets].any(axis=1)]] = True
    shown = np.flatnonzero(beside & ~beyond)
    beyond[shown] = _past_rim(contact, contact.nodes[shown])
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
        contact.facet_numbers[rim],
    )
    shares = covered_shares(
        contact.surface, surface, pose.rotation, pose.translation, numbers, line_share(slave, master)
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
    beyond[some] = _past_rim(contact, points[some])
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
    ties = contact.surface.hanging
    if ties is None or not len(ties.edges):
        return np.zeros((0, 3), np.int64)
    linear = ties.edges[:, 3] < 0
    ends = [ties.edges[linear][:, [0, 2, 1]], *(ties.edges[~linear][:, k] for k in ([0, 1, 3], [1, 2, 4]))]
    place = np.full(len(contact.surface.points), -1)
    place[contact.node_numbers] = np.arange(len(contact.node_numbers))
    here = place[np.concatenate(ends)]
    return np.asarray(here[(here >= 0).all(axis=1)])


def _past_rim(contact: ContactFields, points: Array) -> Mask:
    """Whether points (n, 3) of the slave lie beyond the rim of the master."""
    if not len(points):
        return np.zeros(0, bool)
    return contact.master.surface(contact.surfaces[1]).project(contact.master.pose.to_body(points)).outside


def _to_rim(contact: ContactFields, start: Array, end: Array) -> Array:
    """Place (n,) of the rim of the other body on ways from points (n, 3) to others, by halving."""
    way, low, high = end - start, np.zeros(len(start)), np.ones(len(start))
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        past = _past_rim(contact, start + middle[:, None] * way)
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
    samples = facet_samples(contact.nodes, contact.facets, False, contact.extent, SAMPLES)
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
    mirrors = planes_of_symmetry(contact.surface, contact.slave.pose, contact.node_numbers)
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
    _, label = connected_components(sp.csr_array((np.ones(n), (np.arange(n), after)), shape=(n, n)), directed=False)
    first = np.unique(label, return_index=True)[1]
    # number of steps to the first segment of the curve, by doubling
    last = after == first[label]
    steps, way = np.where(last, 0, 1), np.where(last, np.arange(n), after)
    for _ in range(int(np.ceil(np.log2(max(n, 2))))):
        steps, way = steps + steps[way], way[way]
    order = np.lexsort((-steps, label))
    return np.split(order, np.flatnonzero(np.diff(label[order])) + 1) if n else []
