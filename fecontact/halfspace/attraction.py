"""Attraction of surfaces by Dugdale's law: a constant traction up to a range of the gap, and what is within the range.

Gaps are linear between the cells' centres: a cell carries the share of the traction that its part within the range
gives it.

References
----------
D. S. Dugdale, J. Mech. Phys. Solids 8 (1960) 100; D. Maugis, J. Colloid Interface Sci. 150 (1992) 243.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import positive
from fecontact.halfspace.grid import Even


@dataclass(frozen=True)
class Dugdale:
    """Adhesion by a constant traction up to a range of the gap, none beyond.

    Parameters
    ----------
    work : float
        Work of adhesion, per area of both surfaces.
    range : float
        Gap up to which they attract each other.

    Examples
    --------
    >>> Dugdale(work=0.05, range=1e-3).traction
    50.0
    """

    work: float
    range: float

    def __post_init__(self) -> None:
        positive("the work of adhesion", self.work)
        positive("the range of adhesion", self.range)

    @property
    def traction(self) -> float:
        """Work over range."""
        return self.work / self.range

    def zone_width(self, modulus: float) -> float:
        """Width of the zone at the edge of a contact that is large beside it, pi E* w/(4 s0^2).

        Dugdale's pi K^2/(8 s0^2) with K^2 = 2 E* w.
        """
        return math.pi * modulus * self.work / (4 * self.traction**2)


class Zone(NamedTuple):
    """What is within the range.

    Attributes
    ----------
    share : (nx, ny) array
        Of each cell.
    depth : float
        Sum over the cells of the range less the gap.
    points : (n, nx ny) csr_matrix
        Interpolation at points of the outline.
    weights : (n,) array
        Cells that come within the range there by a unit of the gap.
    """

    share: Array
    depth: float
    points: sp.csr_matrix
    weights: Array


@dataclass(frozen=True, eq=False)
class Centres:
    """Quadrilaterals between the centres of modelled cells; those at planes of symmetry and borders are halves.

    Attributes
    ----------
    shape : (int, int)
    closed : (bool, bool)
        Axes along which the last cell is beside the first.
    """

    shape: tuple[int, int]
    closed: Even

    @cached_property
    def corners(self) -> tuple[IntArray, Array]:
        """Cells (4, n) round the quadrilaterals, and their areas (n,) over that of a cell."""
        ends, weights = [], []
        for n, closed in zip(self.shape, self.closed, strict=True):
            first = np.arange(0 if closed else -1, n)
            pair = np.stack([first, first + 1])
            ends.append(pair % n if closed else np.clip(pair, 0, n - 1))
            weights.append(np.where(closed | (first >= 0) & (first < n - 1), 1.0, 0.5))
        (x, y), around = ends, ((0, 0), (1, 0), (1, 1), (0, 1))
        cells = np.stack([x[i][:, None] * self.shape[1] + y[j] for i, j in around])
        return cells.reshape(4, -1), np.outer(*weights).ravel()

    def zone(self, gap: Array, reach: float) -> Zone:
        """What is within a range of gaps (nx, ny); infinite ones are taken as those beside them, and carry nothing."""
        cells, weight = self.corners
        f = (reach - gap.ravel())[cells]
        known = np.isfinite(f)
        if not known.all():
            mean = np.where(known, f, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
            f = np.where(known, f, np.where(known.any(axis=0), mean, -reach))
        inside = (f > 0).sum(axis=0)
        whole, cut = inside == 4, np.flatnonzero((inside > 0) & (inside < 4))
        # both diagonals divide a quadrilateral, by halves, so that mirror images are the same
        three = np.array([(0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3)])
        corners, values = (v[:, cut][three].transpose(0, 2, 1).reshape(-1, 3) for v in (cells, f))
        areas = np.tile(weight[cut] / 4, 4)
        moments, depth, lone, rows, lengths = cut_triangles(values)
        share = np.asarray(np.bincount(cells[:, whole].ravel(), np.tile(weight[whole] / 4, 4), gap.size), dtype=float)
        share += np.bincount(corners.ravel(), (areas[:, None] * moments).ravel(), gap.size)
        there = np.isfinite(gap).ravel()
        share[~there] = 0.0
        at, place = np.repeat(corners[lone], 2, axis=0), np.repeat(np.arange(2 * len(lone)), 3)
        points = sp.csr_matrix((rows.ravel() * there[at.ravel()], (place, at.ravel())), (len(at), gap.size))
        total = float(weight[whole] @ f[:, whole].mean(axis=0) + areas @ depth)
        return Zone(share.reshape(gap.shape), total, points, np.repeat(areas[lone] * lengths, 2))


def cut_triangles(values: Array) -> tuple[Array, Array, IntArray, Array, Array]:
    """Where functions that are linear over triangles are positive, from values (n, 3) at their corners.

    Returns
    -------
    moments : (n, 3) array
        Mean of each corner's shape function there, zero elsewhere.
    mean : (n,) array
        Mean of the positive part.
    crossed : (m,) int array
        Triangles that a line of zeros crosses.
    rows : (2 m, 3) array
        Interpolation at two Gauss points of each line.
    lengths : (m,) array
        Growth of the positive share of the area with the function, of each point.

    Examples
    --------
    A line through the middles of two sides:

    >>> moments, mean, *_ = cut_triangles(np.array([[1.0, -1.0, -1.0]]))
    >>> float(moments.sum()), bool(np.isclose(mean[0], 0.25 / 3))
    (0.25, True)
    """
    count = (values > 0).sum(axis=1)
    moments = np.tile(np.where(count == 3, 1 / 3, 0.0)[:, None], 3)
    mean = np.where(count == 3, values.mean(axis=1), 0.0)
    crossed = np.flatnonzero((count == 1) | (count == 2))
    one = count[crossed] == 1
    lone = np.argmax((values[crossed] > 0) == one[:, None], axis=1)  # the corner that is alone on its side
    order = (lone[:, None] + np.arange(3)) % 3
    f = np.take_along_axis(values[crossed], order, axis=1)
    size = np.abs(f)
    a, b = (size[:, 0] / (size[:, 0] + size[:, k]) for k in (1, 2))  # where the line cuts the sides, from that corner
    corner = np.stack([1 - (a + b) / 3, a / 3, b / 3], axis=1) * (a * b)[:, None]
    kept = np.empty_like(corner)
    np.put_along_axis(kept, order, np.where(one[:, None], corner, 1 / 3 - corner), axis=1)
    moments[crossed] = kept
    mean[crossed] = size[:, 0] * a * b / 3 + np.where(one, 0.0, f.mean(axis=1))
    none = np.zeros(len(a))
    start, end = np.stack([1 - a, a, none], axis=1), np.stack([1 - b, none, b], axis=1)
    places = np.stack([(1 - s) * start + s * end for s in 0.5 + np.array([-0.5, 0.5]) / math.sqrt(3)], axis=1)
    rows = np.empty_like(places)
    np.put_along_axis(rows, np.repeat(order[:, None], 2, axis=1), places, axis=2)
    lengths = size[:, 0] / ((size[:, 0] + size[:, 1]) * (size[:, 0] + size[:, 2]))
    return moments, mean, crossed, rows.reshape(-1, 3), lengths
