"""Triangles that cross each other: surfaces that run through themselves."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fecontact.common.arrays import Array, IntArray

#: Pairs of boxes that are compared together.
PAIRS = 4_000_000
#: Angle (sine) between a side and a triangle, relative, below which they are parallel.
PARALLEL = 1e-9


def crossing_triangles(points: Array, triangles: IntArray) -> IntArray:
    """Pairs (n, 2) of triangles without a common corner such that a side of the first crosses the second.

    Moeller & Trumbore (1997), Fast, minimum storage ray-triangle intersection. Memory is bounded whatever the sizes.

    Examples
    --------
    >>> x = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [0.5, 0.5, -1], [0.5, 0.5, 1], [3, 3, 0]])
    >>> crossing_triangles(x, np.array([[0, 1, 2], [3, 4, 5]])).tolist()
    [[0, 1], [1, 0]]
    """
    x = points[triangles]
    found = [np.zeros((0, 2), np.int64)]
    for one, other in _overlapping_boxes(x.min(axis=1), x.max(axis=1)):
        apart = ~(triangles[one][:, :, None] == triangles[other][:, None, :]).any(axis=(1, 2))
        pairs = np.stack([one[apart], other[apart]], axis=1)
        pairs = np.concatenate([pairs, pairs[:, ::-1]])
        found.append(pairs[_cross(x[pairs[:, 0]], x[pairs[:, 1]])])
    return np.concatenate(found)


def _overlapping_boxes(low: Array, high: Array) -> Iterator[tuple[IntArray, IntArray]]:
    """Pairs of boxes with corners (n, 3) that meet: sorted along the axis along which the fewest do."""
    orders = np.argsort(low, axis=0, kind="stable")
    last = np.stack([np.searchsorted(low[orders[:, k], k], high[orders[:, k], k], side="right") for k in range(3)])
    axis = int(np.argmin(last.sum(axis=1)))
    order, rank = orders[:, axis], np.arange(len(low))
    # of the box of each rank, those of later ranks up to the last one that begins within it
    ends = np.cumsum(last[axis] - rank - 1)
    start = 0
    while start < len(low):
        before = ends[start - 1] if start else 0
        stop = max(start + 1, int(np.searchsorted(ends, before + PAIRS, side="right")))
        count = np.diff(ends[start:stop], prepend=before)
        one = np.repeat(rank[start:stop], count)
        other = one + 1 + np.arange(len(one)) - np.repeat(np.cumsum(count) - count, count)
        one, other = order[one], order[other]
        meet = np.ones(len(one), bool)
        for k in range(3):
            meet &= (low[one, k] <= high[other, k]) & (low[other, k] <= high[one, k])
        yield one[meet], other[meet]
        start = stop


def _cross(x: Array, y: Array) -> Array:
    """Whether (n,) a side of triangles (n, 3, 3) crosses the others (n, 3, 3)."""
    hit = np.zeros(len(x), bool)
    a, b, c = np.moveaxis(y, 1, 0)
    for k in range(3):
        start = x[:, k]
        direction = x[:, (k + 1) % 3] - start
        p = np.cross(direction, c - a)
        det = np.einsum("ni,ni->n", b - a, p)
        scale = np.linalg.norm(direction, axis=1) * np.linalg.norm(b - a, axis=1) * np.linalg.norm(c - a, axis=1)
        crosses = np.abs(det) > PARALLEL * scale
        inverse = np.divide(1.0, det, out=np.zeros_like(det), where=crosses)
        s = start - a
        u = np.einsum("ni,ni->n", s, p) * inverse
        q = np.cross(s, b - a)
        v = np.einsum("ni,ni->n", direction, q) * inverse
        t = np.einsum("ni,ni->n", c - a, q) * inverse
        hit |= crosses & (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= 1)
    return hit
