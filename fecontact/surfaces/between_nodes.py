"""Smallest gaps over faces, between their nodes too."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask

#: Samples (16, 2) of a face, as coordinates of the square. They are irregular, so that no regular shape hides there.
SAMPLES = np.stack(np.meshgrid([0.09, 0.36, 0.61, 0.92], [0.13, 0.38, 0.67, 0.89], indexing="ij"), -1).reshape(-1, 2)
#: Directions of a pattern search, its first step, the factor of later ones and the last step, in coordinates of a face.
PATTERN = np.array([(s, t) for s in (-1.0, 0.0, 1.0) for t in (-1.0, 0.0, 1.0) if s or t])
FIRST, FACTOR, LAST = 0.25, 0.6, 1e-10
#: Largest further fall of the gap over its spread in a pattern: a constant slope over all steps to come, and a margin;
#: and over the step, where the pattern leaves the other surface: twice the slope of a gap at most, and all steps.
FALL, STEEP = 2.0, 4.0
#: Directions in which the extent of an overlap is measured, and halvings of its length.
AROUND, HALVINGS = 16, 40

#: Gaps (n,) at coordinates (n, 2) of given facets (n,); infinite where nothing is opposite.
GapAt = Callable[[IntArray, Array], Array]


def samples_of(facets: IntArray, triangle: Mask) -> tuple[IntArray, Array]:
    """Samples of given facets (n,), of which some are triangles: their facets (16 n,) and coordinates (16 n, 2)."""
    local = np.tile(SAMPLES, (len(facets), 1))
    within = np.repeat(triangle, len(SAMPLES))
    local[within, 0] *= 1 - local[within, 1]
    return np.repeat(facets, len(SAMPLES)), local


def smallest_gaps(gap_at: GapAt, facets: IntArray, triangle: Mask, size: Array) -> tuple[Array, Array]:
    """Smallest gap (n,) over each of n facets of given size (n,), and its coordinates (n, 2); exact where negative.

    From the lowest of some samples a pattern search descends: the gap of a shape with corners has no derivative
    (R. M. Lewis, V. Torczon and M. W. Trosset, J. Comput. Appl. Math. 124, 2000). Facets on which no slope that was
    seen leads below zero are left at once.

    Examples
    --------
    A ball of radius 10 that reaches 0.001 below the middle of a unit square, seen from its corner:

    >>> def ball(facet, local):
    ...     return np.hypot(10 * np.ones(len(local)), np.linalg.norm(local - 0.7, axis=1)) - 10.001
    >>> gap, local = smallest_gaps(ball, np.array([0]), np.array([False]), np.ones(1))
    >>> gap.round(9).tolist(), local.round(3).tolist()
    ([-0.001], [[0.7, 0.7]])
    """
    n, each = len(facets), np.arange(len(facets))
    which, where = samples_of(facets, triangle)
    g = gap_at(which, where).reshape(n, -1)
    best = g.argmin(axis=1)
    least, local = g[each, best], where.reshape(n, -1, 2)[each, best]
    step, left = FIRST, each
    while step > LAST:
        fall, known = STEEP * step * size[left], np.isfinite(g).all(axis=1)
        fall[known] = FALL * (g[known].max(axis=1) - least[left[known]])
        left = left[least[left] < fall]
        if len(left) == 0:
            break
        tried = np.clip(local[left, None] + step * PATTERN, 0.0, 1.0)
        tried /= np.where(triangle[left, None], np.maximum(tried.sum(axis=2), 1.0), 1.0)[..., None]
        g = gap_at(np.repeat(facets[left], len(PATTERN)), tried.reshape(-1, 2)).reshape(len(left), -1)
        best = g.argmin(axis=1)
        lower = g[np.arange(len(left)), best]
        better = lower < least[left]
        local[left[better]] = tried[better, best[better]]
        least[left] = np.minimum(least[left], lower)
        step *= FACTOR
    return least, local


def overlap_outline(gap_at: GapAt, facet: int, local: Array, triangle: bool) -> Array:
    """Coordinates (16, 2) on a facet of the ends of an overlap round a point (2,), in directions 22.5 degrees apart."""
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    along, many = np.stack([np.cos(turn), np.sin(turn)], axis=1), np.full(AROUND, facet)
    low, high = np.zeros(AROUND), np.full(AROUND, 2.0)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        tried = local + middle[:, None] * along
        within = (tried >= 0).all(axis=1) & (tried <= 1).all(axis=1) & ((tried.sum(axis=1) <= 1) | (not triangle))
        within &= gap_at(many, np.clip(tried, 0.0, 1.0)) < 0
        low, high = np.where(within, middle, low), np.where(within, high, middle)
    return np.asarray(local + low[:, None] * along)


def star_area(centre: Array, outline: Array) -> float:
    """Area of the triangles between a point (3,) and consecutive points (n, 3) round it."""
    sides = outline - centre
    return float(np.linalg.norm(np.cross(sides, np.roll(sides, -1, axis=0)), axis=1).sum()) / 2
