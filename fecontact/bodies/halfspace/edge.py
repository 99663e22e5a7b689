"""Cells at the edge of a contact, and the contact area with its edge located within them.

Counting cells gives the area to first order only. Where the surface is smooth the pressure falls to zero as the square
root of the distance d from the edge and the gap beyond it grows as d^(3/2) (Johnson 1985, *Contact Mechanics*, section
4.2(c)). So a straight line through the squared pressures of the last two cells of each row and column locates the edge,
and so does one through the gaps^(2/3) of the first two cells beyond it. Gaps are the more accurate, as displacements
are; pressures count where the gap does not grow, as between near patches of rough surfaces. Rows and columns each give
an area, as the divergence theorem needs one direction only; each edge is weighted by the squared cosine between its
normal and that direction. Where the counter-surface itself ends, as under a flat punch, the edge is known and not
corrected.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray, Mask

FARTHEST = 1.0
"""Largest correction of an edge, in cells."""

FALLS = 0.3
"""Mean pressure at an end over that of the contact, below which the pressure falls to zero there."""


class EdgeCells(NamedTuple):
    """Last cells of rows and columns of a contact, beside cells without pressure under the counter-surface.

    Attributes
    ----------
    last, before : (n,) arrays
        Pressure of the last cell and of the one before.
    gap, beyond : (n,) arrays
        Gap of the first cell outside and of the one beyond it; zero where it is in contact or has no counter-surface.
    share : (n,) array
        Squared cosine between the edge's normal and the row or column, taken at the cell before.
    place : (2, n) int array
        Indices of the last cell.
    """

    last: Array
    before: Array
    gap: Array
    beyond: Array
    share: Array
    place: IntArray

    @property
    def excess(self) -> tuple[Array, Array]:
        """Areas (n,) in cells beyond the last cells, negative where the contact ends within; by gaps, by pressures."""
        square, falls = self.last**2, self.before > self.last
        # from the middle of the last cell
        reach = np.where(falls, square / np.where(falls, self.before**2 - square, 1.0), 0.5)
        near, far = np.cbrt(self.gap**2), np.cbrt(self.beyond**2)
        grows = far > near
        by_gap = np.where(grows, 1.0 - near / np.where(grows, far - near, 1.0), reach)
        one, other = (self.share * (np.clip(v, 0.5 - FARTHEST, 0.5 + FARTHEST) - 0.5) for v in (by_gap, reach))
        return one, other


def pressed_ends(pressure: Array, allowed: Mask) -> Mask:
    """Cells (nx, ny) in contact beside cells without counter-surface, where the pressure does not fall to zero.

    All of them, or none: that is where their mean pressure is above a part of that of the contact.

    Examples
    --------
    >>> import numpy as np
    >>> flat, round_edge = np.array([[0.0, 2.0, 1.0, 2.0, 0.0]]), np.array([[0.0, 0.1, 1.0, 0.1, 0.0]])
    >>> pressed_ends(flat, flat > 0).tolist(), bool(pressed_ends(round_edge, flat > 0).any())
    ([[False, True, False, True, False]], False)
    """
    active = pressure > 0
    open_beside = [~np.roll(allowed, step, axis) for axis in (0, 1) for step in (-1, 1)]
    ends = active & np.any(open_beside, axis=0)
    if ends.any() and pressure[ends].mean() > FALLS * pressure[active].mean():
        return np.asarray(ends)
    return np.zeros(pressure.shape, bool)


def edge_cells(pressure: Array, gap: Array, periodic: bool) -> EdgeCells:
    """Edge cells of all rows and columns; those of contacts one cell wide are left out.

    Parameters
    ----------
    pressure : (nx, ny) array
    gap : (nx, ny) array
        After deformation; infinite where there is no counter-surface.
    periodic : bool
    """
    parts = [_one_way(pressure, gap, axis, step, periodic) for axis in (0, 1) for step in (-1, 1)]
    return EdgeCells(*(np.concatenate(part, axis=-1) for part in zip(*parts, strict=True)))


def _one_way(pressure: Array, gap: Array, axis: int, step: int, periodic: bool) -> EdgeCells:
    """Edge cells facing one way; step -1: the contact ends at the upper side, 1: at the lower side."""
    active, allowed = pressure > 0, np.isfinite(gap)
    outside = np.where(active | ~allowed, 0.0, np.maximum(gap, 0.0))

    def beside(values: NDArray, by: int) -> NDArray:
        rolled = np.roll(values, by, axis)
        if not periodic:
            lines = np.moveaxis(rolled, axis, 0)
            lines[slice(0, by) if by > 0 else slice(by, None)] = 0
        return rolled

    at = np.array(np.nonzero(active & ~beside(active, step) & beside(allowed, step) & beside(active, -step)))
    before = at.copy()
    before[axis] = (before[axis] + step) % pressure.shape[axis]
    slope = [_slope(pressure, before, k) for k in (0, 1)]
    total = slope[0] + slope[1]
    share = np.divide(slope[axis], total, out=np.full(total.shape, 0.5), where=total > 0)
    beyond = (beside(outside, step)[tuple(at)], beside(outside, 2 * step)[tuple(at)])
    return EdgeCells(pressure[tuple(at)], pressure[tuple(before)], *beyond, share, at)


def _slope(pressure: Array, at: NDArray, axis: int) -> Array:
    """Squared differences (n,) of squared pressures beside cells (2, n), along an axis."""
    low, high = at.copy(), at.copy()
    low[axis] -= 1
    high[axis] = (high[axis] + 1) % pressure.shape[axis]
    return np.asarray((pressure[tuple(high)] ** 2 - pressure[tuple(low)] ** 2) ** 2)


def edge_area(edge: EdgeCells, count: int) -> tuple[float, float]:
    """Contact area in cells, from their number and those at its edge, by gaps; and by pressures alone.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.arange(-9.5, 10.0)[:, None]  # a strip of half-width 6.8
    >>> strip = np.sqrt(np.maximum(6.8**2 - x**2, 0.0)) * np.ones(20)
    >>> gap = np.maximum(np.abs(x) - 6.8, 0.0) ** 1.5 * np.ones(20)
    >>> by_gaps, by_pressures = edge_area(edge_cells(strip, gap, True), 14 * 20)
    >>> bool(abs(by_gaps / 20 - 2 * 6.8) < 1e-9), bool(abs(by_pressures / 20 - 2 * 6.8) < 0.1)
    (True, True)
    """
    by_gaps, by_pressures = (count + float(excess.sum()) for excess in edge.excess)
    return by_gaps, by_pressures
