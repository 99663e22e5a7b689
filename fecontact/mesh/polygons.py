"""Triangulation of polygons."""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError

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
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
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
