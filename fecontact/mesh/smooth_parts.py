"""Smooth parts of a surface: facets that continue each other, divided at sharp edges, with flat parts on their own.

An edge is sharp if the facets turn by more than 40 degrees there, or by much more than anywhere near (a crease): on a
round shape, however coarse, neighbouring edges turn alike. A part is flat if its facets are coplanar and end at sharp
edges all round, or have a corner in their interior; the sides of a polygon that stands for a round shape have none. A
strip along a sharp edge, one facet wide, has none either: it is flat unless it turns to the facet beside it as that
facet turns to the next, which the last side of a cut cylinder does.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask, cross
from fecontact.mesh.facets import components, sides_of, triangular
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.mesh.pick import shared_sides, side_normals

#: Cosine of the angle between neighbouring facets above which they continue each other: 40 degrees, up to rounding.
#: Facets of round bodies, even coarse ones, differ by less, chamfers and planes of symmetry by more.
SMOOTH = float(np.cos(np.radians(40.0))) - 1e-9
#: Angle (radians, 5 degrees) from which an edge may be a crease, and by how much the turn per length has to exceed all
#: turns the same way near by.
MIN_CREASE, EXCESS = float(np.radians(5.0)), 3.0
#: Part of a facet's width by which edges lie apart, so that they are not pieces of one crease.
APART = 0.3
#: Sums of the angles of coplanar facets at a corner (radians, 150 and 300 degrees) above which it is on a straight
#: edge, and in their interior.
MIN_ON_EDGE, MIN_INSIDE = float(np.radians(150.0)), float(np.radians(300.0))
#: Turn per length from a strip to the facets beside it, relative to theirs to the next, above which it is a side of a
#: polygon: there it is 1, from a flat strip to the first chord of an arc of the same width 1/2.
POLYGON = 0.75
#: Sides that are looked at together.
BLOCK = 2**14
#: Angle between coplanar facets, and distance of a node from its facet's plane relative to its size, due to rounding.
FLAT = 1e-7


@dataclass(frozen=True, eq=False)
class SmoothParts:
    """Smooth parts of a surface.

    Attributes
    ----------
    part : (n_facets,) int array
        Number of each facet's part.
    is_plane : (n_parts,) bool array
    """

    part: IntArray
    is_plane: Mask

    @property
    def flat(self) -> Mask:
        """Which facets (n_facets,) belong to a plane."""
        return self.is_plane[self.part]

    def planes(self, points: Array, facets: IntArray) -> Array:
        """Planes (n_facets, 4) of the flat facets as n and n . x, each plane's from its largest facet; others zero."""
        normal, size = _corner_normals(points, facets)
        out = np.zeros((len(facets), 4))
        order = np.lexsort((-size, self.part))
        largest = order[np.searchsorted(self.part[order], self.part)]
        out[:, :3] = normal[largest]
        out[:, 3] = np.einsum("ni,ni->n", normal[largest], points[facets[largest, 0]])
        out[~self.flat] = 0.0
        return out


def smooth_parts(points: Array, facets: IntArray, hanging: HangingNodes | None = None) -> SmoothParts:
    """Divide a surface into smooth parts.

    Parameters
    ----------
    points : (n_points, 3) array
    facets : (n_facets, 4 | 8) int array
    hanging : HangingNodes, optional
        Of the mesh, if it has any.

    Examples
    --------
    >>> from fecontact import shapes
    >>> block = shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> smooth_parts(block.points, block.face_nodes(block.outer)).is_plane.tolist()
    [True, True, True, True, True, True]
    """
    first, second, cosine = shared_sides(points, facets, hanging)
    pairs = np.stack([first // 4, second // 4], axis=1)
    smooth = (cosine >= SMOOTH) & ~_creases(points, facets, first, second, cosine)
    whole = components(len(facets), pairs[smooth])
    normal, size = _corner_normals(points, facets)
    off = np.einsum("nai,ni->na", points[facets] - points[facets[:, :1]], normal)
    even = np.abs(off).max(axis=1) <= FLAT * size
    level = even[pairs].all(axis=1) & (cosine >= 1 - FLAT**2)
    plate = components(len(facets), pairs[level])
    planes, doubtful = _plane_plates(points, facets, whole, plate)
    bent = smooth & ~level & (cosine < 1 - FLAT**2)
    turning = _bends(points, facets, first[bent], second[bent], cosine[bent])
    planes = np.setdiff1d(planes, _of_polygons(plate, pairs[bent], turning, planes, doubtful))
    flat = even & np.isin(plate, planes)
    # a plane is one of its plates; what is round around it continues without it
    together = smooth & ~flat[pairs].any(axis=1) | level & flat[pairs].all(axis=1)
    part = components(len(facets), pairs[together])
    is_plane = np.zeros(part.max(initial=-1) + 1, bool)
    is_plane[part[flat]] = True
    return SmoothParts(part, is_plane)


def _corner_normals(points: Array, facets: IntArray) -> tuple[Array, Array]:
    """Unit normals (n, 3) across the diagonals of facets, and the longer diagonals (n,)."""
    x = points[facets[:, :4]]
    one, other = x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]
    normal = cross(one, other)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    size = np.maximum(np.linalg.norm(one, axis=1), np.linalg.norm(other, axis=1))
    return np.divide(normal, length, out=np.zeros_like(normal), where=length > 0), size


def _plane_plates(points: Array, facets: IntArray, whole: IntArray, plate: IntArray) -> tuple[IntArray, IntArray]:
    """Plates of coplanar facets that are planes, and those of them that may be sides of polygons.

    Planes have a corner in their interior or on a straight edge, or no neighbours but across sharp edges. Those that
    have it on an edge only are in doubt.
    """
    corners = facets[:, :4].ravel()
    site = np.unique(np.stack([corners, np.repeat(whole, 4)]), axis=1, return_inverse=True)[1].ravel()
    angle = np.bincount(site, _corner_angles(points, facets).ravel())
    only = _one_value(site, np.repeat(plate, 4))
    sure = np.union1d(only[angle > MIN_INSIDE], _one_value(whole, plate))
    along = only[(angle > MIN_ON_EDGE) & (only >= 0)]
    return np.union1d(sure, along), np.setdiff1d(along, sure)


def _of_polygons(plate: IntArray, pairs: IntArray, bend: Array, planes: IntArray, doubtful: IntArray) -> IntArray:
    """Doubtful plates that turn (n,) to the plates beside them, in pairs (n, 2), nearly as these turn to others.

    Planes that are not in doubt are no sides of a polygon. Triangulated sides are plates of several facets.
    """
    both, turn = plate[np.concatenate([pairs, pairs[:, ::-1]])], np.tile(bend, 2)
    of, beside = both.T
    ours = np.isin(of, doubtful) & ~np.isin(beside, np.setdiff1d(planes, doubtful))
    n = plate.max(initial=-1) + 1
    step = np.unique(both[ours], axis=0)
    next_to = sp.csr_matrix((np.ones(len(step)), (step[:, 0], step[:, 1])), shape=(n, n))
    sides = sp.csr_matrix((np.ones(len(of)), (of, np.arange(len(of)))), shape=(n, len(of)))
    beyond = (next_to @ sides).tocoo()
    other = beside[beyond.col] != beyond.row
    row, col = beyond.row[other], beyond.col[other]
    own = np.bincount(of, turn, n) / np.maximum(np.bincount(of, minlength=n), 1)
    theirs = np.bincount(row, turn[col], n) / np.maximum(np.bincount(row, minlength=n), 1)
    return doubtful[(theirs[doubtful] > 0) & (own[doubtful] > POLYGON * theirs[doubtful])]


def _corner_angles(points: Array, facets: IntArray) -> Array:
    """Angles (n, 4) of facets at their corners; of the last two of a triangle, one node, only one counts."""
    x = points[facets[:, :4]]
    forth = np.roll(x, -1, axis=1) - x
    back = -np.roll(forth, 1, axis=1)
    three = triangular(facets)
    forth[three, 2] = forth[three, 3]
    out = np.arctan2(np.linalg.norm(cross(forth, back), axis=2), np.einsum("nai,nai->na", forth, back))
    out[three, 3] = 0.0
    return out


def _one_value(group: IntArray, value: IntArray) -> IntArray:
    """The value that all members (n,) of each group have, -1 where they differ."""
    n = group.max(initial=-1) + 1
    low, high = np.full(n, np.iinfo(np.int64).max), np.full(n, -1)
    np.minimum.at(low, group, value)
    np.maximum.at(high, group, value)
    return np.where(low == high, high, -1)


def _bends(points: Array, facets: IntArray, first: IntArray, second: IntArray, cosine: Array) -> Array:
    """Angles per length (n,) across shared sides, given as 4 facet + side of either facet."""
    return np.arccos(np.clip(cosine, -1.0, 1.0)) / _side_lines(points, facets, first, second)[2]


def _side_lines(points: Array, facets: IntArray, first: IntArray, second: IntArray) -> tuple[Array, Array, Array]:
    """Directions (n, 3) and middles (n, 3) of shared sides, distances (n,) across them between facets' middles."""
    ends = sides_of(facets).reshape(-1, 2)[first]
    along = points[ends[:, 1]] - points[ends[:, 0]]
    along /= np.linalg.norm(along, axis=1)[:, None]
    centre = points[facets[:, :4]].mean(axis=1)
    step = centre[second // 4] - centre[first // 4]
    width = np.linalg.norm(step - np.einsum("ni,ni->n", step, along)[:, None] * along, axis=1)
    return along, points[ends].mean(axis=1), width


def _creases(points: Array, facets: IntArray, first: IntArray, second: IntArray, cosine: Array) -> Mask:
    """Which shared sides (n,), given as 4 facet + side of either facet, turn far more than those near by."""
    turn = np.arccos(np.clip(cosine, -1.0, 1.0))
    tested = np.flatnonzero((turn >= MIN_CREASE) & (cosine >= SMOOTH))
    out = np.zeros(len(first), bool)
    if len(tested) == 0:
        return out
    along, middle, width = _side_lines(points, facets, first, second)
    most = np.zeros(len(first))
    for one, other in _near_sides(len(points), facets, np.stack([first, second], axis=1) // 4, tested):
        line, offset = along[one], middle[other] - middle[one]
        away = np.linalg.norm(offset - np.einsum("ni,ni->n", offset, line)[:, None] * line, axis=1)
        same_way = np.abs(np.einsum("ni,ni->n", line, along[other]))
        bend = np.where(away > APART * width[one], same_way * turn[other] / width[other], 0.0)
        np.maximum.at(most, one, bend)
    normals = side_normals(points, facets, triangular(facets))
    for side in (first, second):
        own = normals[side // 4] - normals[side // 4, side % 4][:, None]
        across = cross(normals[side // 4, side % 4], along)
        most = np.maximum(most, np.abs(np.einsum("nai,ni->na", own, across)).max(axis=1) / width)
    out[tested] = (turn > EXCESS * most * width)[tested]
    return out


def _near_sides(n: int, facets: IntArray, pairs: IntArray, tested: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Pairs of a tested side and another shared side of a facet with a corner in common with its two; in blocks."""
    side = np.repeat(np.arange(len(pairs)), 2)
    sides = sp.csr_matrix((np.ones(len(side)), (side, pairs.ravel())), shape=(len(pairs), len(facets)))
    facet = np.repeat(np.arange(len(facets)), 4)
    corners = sp.csr_matrix((np.ones(len(facet)), (facet, facets[:, :4].ravel())), shape=(len(facets), n))
    around, beside = corners.T.tocsr(), sides.T.tocsr()
    for start in range(0, len(tested), BLOCK):
        block = tested[start : start + BLOCK]
        near = (((sides[block] @ corners) @ around) @ beside).tocoo()
        yield block[near.row], near.col
