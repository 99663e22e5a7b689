"""Contact area with its edge located within the cells.

Counting cells gives the area to first order only. Where the surface is smooth the pressure falls to zero as the square
root of the distance from the edge and its square linearly: a straight line through the last two cells of each row and
column locates the edge. Rows and columns each give an area, as the divergence theorem needs one direction only; each
edge is weighted by the squared cosine between its normal and that direction. Where the counter-surface itself ends, as
under a flat punch, the edge is known and not corrected.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import Array, Mask

FARTHEST = 1.0
"""Largest correction of an edge, in cells."""


def edge_area(pressure: Array, allowed: Mask, periodic: bool) -> float:
    """Contact area in cells.

    Parameters
    ----------
    pressure : (nx, ny) array
    allowed : (nx, ny) bool array
        Cells that have a counter-surface.
    periodic : bool

    Examples
    --------
    >>> import numpy as np
    >>> x = np.arange(-9.5, 10.0)[:, None]  # a strip of half-width 6.8
    >>> strip = np.sqrt(np.maximum(6.8**2 - x**2, 0.0)) * np.ones(20)
    >>> bool(abs(edge_area(strip, np.ones((20, 20), bool), True) / 20 - 2 * 6.8) < 0.1)
    True
    """
    square = pressure**2
    slope = [(np.roll(square, -1, axis) - np.roll(square, 1, axis)) ** 2 for axis in (0, 1)]
    total = slope[0] + slope[1]
    out = float((pressure > 0).sum())
    for axis in (0, 1):
        share = np.divide(slope[axis], total, out=np.full(total.shape, 0.5), where=total > 0)
        out += sum(_moved(square, allowed, share, axis, step, periodic) for step in (-1, 1))
    return out


def _moved(square: Array, allowed: Mask, share: Array, axis: int, step: int, periodic: bool) -> float:
    """Weighted sum of the distances, in cells, from the outer side of the last cell to edges facing one way.

    Parameters
    ----------
    square : (nx, ny) array
        Squared pressures.
    share : (nx, ny) array
        Squared cosine between the edge's normal and the axis, taken one cell inside.
    step : int
        -1: the contact ends at the upper side, 1: at the lower side.
    """

    def beside(values: NDArray, by: int) -> NDArray:
        rolled = np.roll(values, by, axis)
        if not periodic:
            lines = np.moveaxis(rolled, axis, 0)
            lines[slice(0, by) if by > 0 else slice(by, None)] = 0
        return rolled

    last = (square > 0) & (beside(square, step) == 0) & beside(allowed, step) & (beside(square, -step) > 0)
    here, before, counted = square[last], beside(square, -step)[last], beside(share, -step)[last]
    falls = before > here
    reach = np.where(falls, here / np.where(falls, before - here, 1.0), 0.5)  # from the middle of the last cell
    return float(counted @ (np.minimum(reach, 0.5 + FARTHEST) - 0.5))
