"""Faults of triangulated surfaces mended: sliver facets and holes.

A **needle**, with one short side, is collapsed; a **cap**, flat across its longest side, is removed by swapping that
side for the other diagonal of the two facets at it (after Botsch and Kobbelt (2001), *A robust procedure to eliminate
degenerate faces from triangle meshes*). Many are mended at once, none of which share a facet.

Smoothing of triangulated surfaces without shrinking.

Taubin (1995), *Curve and surface smoothing without shrinkage*, ICCV 852-857: a step towards the mean of a node's
neighbours, and a slightly longer one back. Together they damp what is shorter than the pass band and keep the rest.

Triangulation of polygons, and of large triangles.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import MeshError
from fecontact.mesh.facets import numbered_between, sides_of, unit_vectors
from fecontact.mesh.orient import rims

#: Steps towards and from the mean of the neighbours: pass band 1 / TOWARDS + 1 / BACK = 0.1, as in the paper.
TOWARDS, BACK = 0.6307, -0.6732


def smoothed(points: Array, triangles: IntArray, steps: int) -> Array:
    """Points (n_points, 3) after so many pairs of steps; those on the rim of an open surface stay.

    Examples
    --------
    >>> x = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 0.3]])
    >>> smoothed(x, np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]), 2)[4].round(3).tolist()
    [0.0, 0.0, 0.115]
    """
    n = len(points)
    ends = sides_of(triangles).reshape(-1, 2)
    beside = sp.csr_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n, n))
    beside = ((beside + beside.T) > 0).astype(float)
    mean = sp.diags_array(1 / np.maximum(np.asarray(beside.sum(axis=1)).ravel(), 1)) @ beside
    moves = np.ones((n, 1))
    moves[rims(triangles[:, [0, 1, 2, 2]])[0]] = 0.0
    x = points
    for _ in range(steps):
        for share in (TOWARDS, BACK):
            x = x + share * moves * (mean @ x - x)
    return x


#: Sine of the angle at a corner below which it counts as straight.
STRAIGHT = 1e-6


def cut(points: Array, polygons: IntArray) -> IntArray:
    """Facets (n_facets, 4) of polygons (n, k): convex quadrilaterals as they are, others as triangles.

    Convex polygons are divided from their first corner; those with straight or reflex corners by ear clipping (G. H.
    Meisters, Amer. Math. Monthly 82, 1975, 648), the best-shaped ear first. Straight corners stay corners, since a
    neighbour may have one there. Non-planar polygons are projected along their vector area.

    Examples
    --------
    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> cut(square, np.array([[0, 1, 2, 3]])).tolist()
    [[0, 1, 2, 3]]
    """
    k = polygons.shape[1]
    if k == 3:
        return polygons[:, [0, 1, 2, 2]]
    plane = _projected(points[polygons])
    sine, _, turn = _corners(plane)
    convex = (sine > STRAIGHT).all(axis=1) & (turn.sum(axis=1) < 3 * np.pi)
    if k == 4:
        whole = polygons[convex]
    else:
        fan = np.stack([np.zeros(k - 2, int), np.arange(1, k - 1), np.arange(2, k), np.arange(2, k)], axis=1)
        whole = polygons[convex][:, fan].reshape(-1, 4)
    clipped = [polygons[i][_ears(plane[i])] for i in np.flatnonzero(~convex)]
    return np.concatenate([whole, *(c[:, [0, 1, 2, 2]] for c in clipped)])


def _projected(x: Array) -> Array:
    """Coordinates (n, k, 2) of polygons (n, k, 3) projected along their vector area."""
    rest = x - x.mean(axis=1, keepdims=True)
    normal = np.cross(rest, np.roll(rest, -1, axis=1)).sum(axis=1)
    normal = unit_vectors(normal)
    smallest = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    u = np.cross(smallest, normal)
    u /= np.maximum(np.linalg.norm(u, axis=1, keepdims=True), np.finfo(float).tiny)
    return np.stack([np.einsum("nki,ni->nk", rest, v) for v in (u, np.cross(normal, u))], axis=2)


def _corners(x: Array) -> tuple[Array, Array, Array]:
    """Sine of the turn at each corner (..., k) of polygons (..., k, 2), twice the corner's area, and the turn."""
    before, after = x - np.roll(x, 1, axis=-2), np.roll(x, -1, axis=-2) - x
    twice = before[..., 0] * after[..., 1] - before[..., 1] * after[..., 0]
    size = np.linalg.norm(before, axis=-1) * np.linalg.norm(after, axis=-1)
    sine = np.divide(twice, size, out=np.zeros_like(twice), where=size > 0)
    return sine, twice, np.arctan2(twice, (before * after).sum(axis=-1))


def _ears(x: Array) -> IntArray:
    """Triangles (k - 2, 3) of one polygon (k, 2), counter-clockwise."""
    left = np.arange(len(x))
    out = []
    while len(left) > 3:
        sine, twice, _ = _corners(x[left])
        a, c = np.roll(left, 1), np.roll(left, -1)
        longest = np.max([((x[p] - x[q]) ** 2).sum(axis=1) for p, q in ((a, left), (left, c), (c, a))], axis=0)
        # an ear equal to the whole polygon would leave collinear corners
        whole = (x[left, 0] * np.roll(x[left, 1], -1) - x[left, 1] * np.roll(x[left, 0], -1)).sum()
        ear = (sine > STRAIGHT) & (twice < (1 - STRAIGHT) * whole)
        quality = np.where(ear, twice / np.where(longest > 0, longest, 1.0), -1.0)
        for k in np.argsort(-quality):
            if quality[k] <= 0:
                raise MeshError(f"A polygon of {len(x)} corners crosses itself and cannot be cut into triangles.")
            if not _holds_any(x[[a[k], left[k], c[k]]], x[np.setdiff1d(left, [a[k], left[k], c[k]])]):
                break
        else:
            raise MeshError(f"A polygon of {len(x)} corners crosses itself and cannot be cut into triangles.")
        out.append((a[k], left[k], c[k]))
        left = np.delete(left, k)
    return np.array([*out, tuple(left)], dtype=np.int64)


def _holds_any(triangle: Array, points: Array) -> bool:
    """Whether one of points (n, 2) lies in a triangle (3, 2) or, to rounding, on its edge."""
    sides = np.roll(triangle, -1, axis=0) - triangle
    rest = points[:, None] - triangle
    beyond = sides[:, 0] * rest[..., 1] - sides[:, 1] * rest[..., 0]
    return bool((beyond >= -STRAIGHT * (sides**2).sum(axis=1)).all(axis=1).any())


#: Height of a triangle over its longest side, relative to that, below which it is a sliver, and length of its shortest
#: side below which the sliver is a needle.
SLIVER, NEEDLE = 0.01, 0.02
#: Rounds of mending: chains of slivers take one each.
ROUNDS = 50


def without_slivers(points: Array, triangles: IntArray) -> tuple[Array, IntArray, int]:
    """Points (n_points, 3), triangles (n, 3) without slivers where that is possible, and how many were mended.

    Examples
    --------
    >>> x = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 1e-5, 0]])
    >>> without_slivers(x, np.array([[0, 1, 4], [4, 1, 2], [0, 4, 3], [4, 2, 3]]))[1].tolist()
    [[4, 1, 2], [0, 4, 3], [4, 2, 3]]
    """
    mended = 0
    for _ in range(ROUNDS):
        sides, height = _measured(points, triangles)
        bad = np.flatnonzero(height < SLIVER)
        if len(bad) == 0:
            break
        bad = bad[np.argsort(height[bad], kind="stable")]
        needle = sides[bad].min(axis=1) < NEEDLE * sides[bad].max(axis=1)
        points, triangles, n_collapsed = _collapsed(points, triangles, bad[needle], sides)
        n_swapped = 0
        if n_collapsed == 0:
            triangles, n_swapped = _swapped(points, triangles, bad[~needle], sides)
        mended += n_collapsed + n_swapped
        if n_collapsed + n_swapped == 0:
            break
    return points, triangles, mended


def _measured(points: Array, triangles: IntArray) -> tuple[Array, Array]:
    """Lengths (n, 3) of sides, each from the corner of its column, and heights (n,) relative to the longest."""
    x = points[triangles]
    sides = np.linalg.norm(np.roll(x, -1, axis=1) - x, axis=2)
    longest = np.maximum(sides.max(axis=1), np.finfo(float).tiny)
    return sides, np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1) / longest**2


def _apart(n_facets: int, job: IntArray, facet: IntArray, n_jobs: int) -> Mask:
    """Which jobs (n_jobs,) are first at all of their facets, given as pairs (n,) of job and facet."""
    first = np.full(n_facets, n_jobs)
    np.minimum.at(first, facet, job)
    out = np.ones(n_jobs, bool)
    out[job[first[facet] != job]] = False
    return out


def _collapsed(points: Array, triangles: IntArray, needles: IntArray, sides: Array) -> tuple[Array, IntArray, int]:
    """Collapse the shortest sides of needles to their middles, or to their ends on the rim."""
    if len(needles) == 0:
        return points, triangles, 0
    n = len(points)
    column = np.argmin(sides[needles], axis=1)
    ends = np.stack([triangles[needles, column], triangles[needles, (column + 1) % 3]], axis=1)
    ends = ends[np.unique(np.sort(ends, axis=1), axis=0, return_index=True)[1]]
    at = sp.csr_matrix(
        (np.ones(triangles.size), (triangles.ravel(), np.arange(triangles.size) // 3)), shape=(n, len(triangles))
    )
    beside = ((at @ at.T) > 0).astype(float).tocsr()
    # the ends may have no neighbours in common but the third corners of their facets: otherwise a fin would be left
    common = np.asarray(beside[ends[:, 0]].multiply(beside[ends[:, 1]]).sum(axis=1)).ravel() - 2
    shared = np.asarray(at[ends[:, 0]].multiply(at[ends[:, 1]]).sum(axis=1)).ravel()
    on_rim = np.zeros(n, bool)
    on_rim[rims(triangles[:, [0, 1, 2, 2]])[0]] = True
    rim = on_rim[ends]
    ends = ends[(common == shared) & ~(rim.all(axis=1) & (shared == 2))]
    touched = (at[ends[:, 0]] + at[ends[:, 1]]).tocoo()
    ends = ends[_apart(len(triangles), touched.row, touched.col, len(ends))]
    rim = on_rim[ends]
    share = np.where(rim[:, :1] == rim[:, 1:], 0.5, rim[:, 1:].astype(float))
    points = points.copy()
    points[ends[:, 0]] += share * (points[ends[:, 1]] - points[ends[:, 0]])
    number = np.arange(n)
    number[ends[:, 1]] = ends[:, 0]
    triangles = number[triangles]
    kept = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return points, triangles[kept], len(ends)


def _swapped(points: Array, triangles: IntArray, caps: IntArray, sides: Array) -> tuple[IntArray, int]:
    """Swap the longest sides of caps; leave caps on the rim out."""
    if len(caps) == 0:
        return triangles, 0
    n, m = len(triangles), int(triangles.max()) + 1
    starts, ends = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    order = np.argsort(starts * m + ends)
    key = (starts * m + ends)[order]
    column = np.argmax(sides[caps], axis=1)
    c, a, b = (triangles[caps, (column + k) % 3] for k in range(3))
    place = np.minimum(np.searchsorted(key, a * m + c), len(key) - 1)
    has = key[place] == a * m + c
    other, side = np.divmod(order[place], 3)
    d = triangles[other, (side + 2) % 3]
    new = np.stack([np.stack([a, b, d], axis=1), np.stack([b, c, d], axis=1)], axis=1)
    least = np.minimum(*(_measured(points, new[:, k])[1] for k in (0, 1)))
    before = _measured(points, triangles[caps])[1]
    there = np.isin(b * m + d, key) | np.isin(d * m + b, key)
    swap = has & ~there & (least > before) & (other != caps)
    job = np.flatnonzero(swap)
    good = job[_apart(n, np.tile(np.arange(len(job)), 2), np.concatenate([caps[job], other[job]]), len(job))]
    out = triangles.copy()
    out[caps[good]], out[other[good]] = new[good, 0], new[good, 1]
    kept = np.ones(n, bool)
    kept[caps[~has]] = False
    return out[kept], len(good) + int((~has).sum())


def bisected(points: Array, triangles: IntArray, size: float) -> tuple[Array, IntArray, IntArray]:
    """Triangles (n, 3) halved across their longest sides until none is longer than a size.

    As points, facets (n_new, 4), and the triangle (n_new,) that each is of. Neighbours may have a node in the middle of
    a side that is theirs too.

    Examples
    --------
    >>> x = np.array([[0.0, 0, 0], [4, 0, 0], [0, 1, 0]])
    >>> len(bisected(x, np.array([[0, 1, 2]]), 2.0)[1])
    7
    """
    whole = np.arange(len(triangles))
    while True:
        sides = np.linalg.norm(points[np.roll(triangles, -1, axis=1)] - points[triangles], axis=2)
        long = np.flatnonzero(sides.max(axis=1) > size)
        if len(long) == 0:
            return points, triangles[:, [0, 1, 2, 2]], whole
        column = np.argmax(sides[long], axis=1)
        a, b, c = (triangles[long, (column + k) % 3] for k in range(3))
        middle, ends = numbered_between(np.stack([a, b], axis=1), len(points))
        points = np.concatenate([points, points[ends].mean(axis=1)])
        halves = np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)
        triangles = np.concatenate([np.delete(triangles, long, axis=0), *halves])
        whole = np.concatenate([np.delete(whole, long), whole[long], whole[long]])


def without_holes(points: Array, triangles: IntArray, most: int) -> tuple[IntArray, int]:
    """Triangles (n, 3) with holes of up to so many sides filled by flat ones, and the number of these holes.

    A rim that meets itself, or is too crooked to be filled, stays open.
    """
    sides, rim = rims(triangles[:, [0, 1, 2, 2]])
    filled, count = [triangles], 0
    for k in np.flatnonzero(np.bincount(rim) <= most) if len(sides) else []:
        own = sides[rim == k]
        after = dict(own[:, ::-1].tolist())
        loop = [int(own[0, 0])]
        while len(loop) < len(own) and after[loop[-1]] != loop[0]:
            loop.append(after[loop[-1]])
        if len(loop) != len(own) or len(after) != len(own):
            continue
        try:
            facets = cut(points, np.array([loop]))
        except MeshError:
            continue
        both = np.concatenate([facets[:, [0, 1, 2]], facets[:, [0, 2, 3]]])
        filled.append(both[(both != np.roll(both, 1, axis=1)).all(axis=1)])
        count += 1
    return np.concatenate(filled), count
