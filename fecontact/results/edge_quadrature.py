"""Quadrature on facets of functions that end at an outline like the square root of the distance, or its inverse.

On every line across a facet the outline phi = 0 is found, inside the facet or beyond it. With x = e -+ v^2, e the place
of the outline, sqrt(phi) and dx / sqrt(phi) are smooth in v, and Gauss points in v integrate them. (The substitution is
that for end singularities of algebraic order, Davis & Rabinowitz 1984, *Methods of Numerical Integration*, section
2.12.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.mesh.facets import facet_shapes, triangular

#: Panels across a facet with Gauss points in each, and Gauss points of each half of a line.
PANELS, ACROSS, ALONG = 3, 4, 6
#: Distance of an outline beyond a facet, in facets, from which on it counts as this far.
BEYOND = 8.0
#: Steps by which the outline is found on a line from its parabola.
STEPS = 3


@dataclass(frozen=True, eq=False)
class EdgePoints:
    """Quadrature points of n facets, n_q on each.

    Attributes
    ----------
    points : (n, n_q, 3) array
    areas : (n, n_q) array
        Weights, with the facet's area element; zero where the outline leaves nothing.
    shapes : (n, n_q, k) array
        Shape functions of the facets' nodes.
    corners : (n, n_q, 4) array
        Bilinear functions of the corners of the unit square.
    """

    points: Array
    areas: Array
    shapes: Array
    corners: Array


def edge_points(nodes: Array, facets: IntArray, level: Callable[[Array], Array]) -> EdgePoints:
    """Quadrature points inside an outline.

    Parameters
    ----------
    nodes : (m, 3) array
    facets : (n, 4 | 8 | 9) int array
    level : function
        phi (...,) at points (..., 3), positive inside; its square root is to be integrated.

    Examples
    --------
    Half an ellipsoid over the unit square, a quarter of the disc: pi/6.

    >>> square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    >>> disc = lambda x: 1 - (x**2).sum(axis=-1)
    >>> found = edge_points(square, np.array([[0, 1, 2, 3]]), disc)
    >>> value = (found.areas * np.sqrt(disc(found.points))).sum()
    >>> bool(abs(value / (np.pi / 6) - 1) < 2e-4)
    True
    """
    across, weight = _panels()
    steep = _along_second(nodes, facets, level)
    n, q = len(facets), len(across)

    def at(x: Array) -> Array:
        """Level (n, q) at coordinates x (n, q) of the lines."""
        local = _local(x, across, steep)
        return level(_shapes(facets, local)[0] @ nodes[facets])

    low, high, before, after = _interval(at, n, q)
    middle = (low + high) / 2
    v, w = np.polynomial.legendre.leggauss(ALONG)
    v, w = (v + 1) / 2, w / 2
    parts = []
    for end, near, sign in ((before, low, 1.0), (after, high, -1.0)):
        inner, outer = np.sqrt(np.abs(middle - end))[..., None], np.sqrt(np.abs(near - end))[..., None]
        root = outer + (inner - outer) * v
        parts.append((end[..., None] + sign * root**2, 2 * root * (inner - outer) * w))
    x, dx = (np.concatenate(p, axis=2).reshape(n, -1) for p in zip(*parts, strict=True))
    lines = np.repeat(np.arange(q), 2 * ALONG)
    local = _local(x, across[lines], steep)
    shapes, tangents = _shapes(facets, local)
    tangent = np.einsum("fqaj,fai->fqij", tangents, nodes[facets], optimize=True)
    area = np.linalg.norm(np.cross(tangent[..., 0], tangent[..., 1]), axis=-1) * dx * weight[lines]
    s, t = np.moveaxis(local, -1, 0)
    corners = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=-1)
    return EdgePoints(shapes @ nodes[facets], area, shapes, corners)


def _panels() -> tuple[Array, Array]:
    """Coordinates (q,) of lines across the unit square, and their weights."""
    x, w = np.polynomial.legendre.leggauss(ACROSS)
    start = np.arange(PANELS)[:, None]
    return ((start + (x + 1) / 2) / PANELS).ravel(), np.tile(w / (2 * PANELS), PANELS)


def _local(x: Array, across: Array, steep: Array) -> Array:
    """Coordinates (n, q, 2) of the square from those along x (n, q) and across (q,) the lines of each facet."""
    y = np.broadcast_to(across, x.shape)
    return np.where(steep[:, None, None], np.stack([y, x], -1), np.stack([x, y], -1))


def _along_second(nodes: Array, facets: IntArray, level: Callable[[Array], Array]) -> Array:
    """Whether (n,) phi changes more along the second coordinate of each facet."""
    a, b, c, d = level(nodes[facets[:, :4]]).T
    return np.abs(c + d - a - b) > np.abs(b + c - a - d)


def _shapes(facets: IntArray, local: Array) -> tuple[Array, Array]:
    """Shape functions (n, q, k) and derivatives (n, q, k, 2) at points (n, q, 2) of the square."""
    n, q, k = len(facets), local.shape[1], facets.shape[1]
    triangle = np.repeat(triangular(facets), q)
    s, t = local.reshape(-1, 2).T
    own = np.where(triangle[:, None], np.stack([s * (1 - t), t], axis=1), local.reshape(-1, 2))
    N, dN = facet_shapes(k, triangle, own)
    collapsed = np.stack([dN[..., 0] * (1 - t)[:, None], dN[..., 1] - dN[..., 0] * s[:, None]], axis=-1)
    dN = np.where(triangle[:, None, None], collapsed, dN)
    return N.reshape(n, q, k), dN.reshape(n, q, k, 2)


def _interval(at: Callable[[Array], Array], n: int, q: int) -> tuple[Array, Array, Array, Array]:
    """Part of each line (n, q) of the unit square inside the outline, and the places of the outline on either side."""
    x = np.broadcast_to(np.array([0.0, 0.5, 1.0])[:, None, None], (3, n, q))
    start, middle, end = (at(part) for part in x)
    slope, bend = 4 * middle - 3 * start - end, 2 * (start + end - 2 * middle)
    least = np.finfo(float).eps * (np.abs(start) + np.abs(middle) + np.abs(end))
    bend = np.where(np.abs(bend) < least, -least, bend)
    root = np.sqrt(np.maximum(slope**2 - 4 * bend * start, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.where(slope > 0, -slope - root, -slope + root) / 2
        one, two = far / bend, np.where(far == 0, np.inf, start / far)
    before, after = np.fmin(one, two), np.fmax(one, two)
    # a parabola that opens upwards is followed on the side that is inside
    up, over = bend > 0, (bend > 0) & (slope**2 < 4 * bend * start)
    before, after = (
        np.where(up, np.where(end > start, after, -BEYOND), before),
        np.where(up, np.where(end > start, 1 + BEYOND, before), after),
    )
    before, after = np.where(over, -BEYOND, before), np.where(over, 1 + BEYOND, after)
    outside = (slope**2 <= 4 * bend * start) & ~up
    before, after = np.clip(before, -BEYOND, 1 + BEYOND), np.clip(after, -BEYOND, 1 + BEYOND)
    before, after = (_corrected(at, place) for place in (before, after))
    low, high = np.clip(before, 0.0, 1.0), np.clip(after, 0.0, 1.0)
    high = np.where(outside, low, np.maximum(high, low))
    return low, high, np.minimum(before, low), np.maximum(after, high)


def _corrected(at: Callable[[Array], Array], place: Array) -> Array:
    """Places (n, q) of the outline inside the facets, by Newton's method with a difference for the slope."""
    inside = (place > 0) & (place < 1)
    if not inside.any():
        return place
    step = 1e-4
    for _ in range(STEPS):
        value = at(place)
        slope = (at(place + step) - value) / step
        change = np.divide(value, slope, out=np.zeros_like(value), where=inside & (slope != 0))
        place = place - np.clip(change, -0.1, 0.1)
    return place
