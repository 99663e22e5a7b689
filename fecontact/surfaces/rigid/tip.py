"""The sharpest place of a surface of heights near a point, and the power of the distance with which it rises there."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fecontact.common.arrays import Array

#: Samples along each side of a square, halves of whose sides the search divides, how often, and by how much.
SAMPLES, TIMES, CLOSER = 33, 6, 4
#: Distances, as parts of the first square's half, between which the power is read.
FAR, NEAR = 1 / 8, 1 / 512
#: Rounding of heights, relative to the largest, below which a rise is none.
ROUNDING = 1e-12


class Tip(NamedTuple):
    """Place (2,) of the largest second difference, power of the distance there, and mean slope beside it."""

    place: Array
    power: float
    slope: float


def sharpest(heights: Callable[[Array, Array], Array], centre: Array, reach: float) -> Tip:
    """The sharpest convex place of a surface within a square round a point.

    The power is 1 at the tip of a cone and the ridge of a wedge, 2 where the surface is smooth or has no rise.

    Parameters
    ----------
    heights : function of x, y
    centre : (2,) array
    reach : float
        Half of the square's side.

    Examples
    --------
    >>> cone = lambda x, y: 0.1 * np.hypot(x - 0.1, y)
    >>> tip = sharpest(cone, np.zeros(2), 0.3)
    >>> tip.place.round(4).tolist(), round(tip.power, 2), round(tip.slope, 2)
    ([0.1, 0.0], 1.0, 0.1)
    >>> round(sharpest(lambda x, y: x**2 + y**2, np.zeros(2), 0.3).power, 6)
    2.0
    """
    offsets, half = np.linspace(-1, 1, SAMPLES), reach
    for _ in range(TIMES):
        x, y = centre[:, None] + half * offsets
        z = np.asarray(heights(x[:, None], y[None, :]), dtype=float)
        z = np.where(np.isfinite(z), z, np.nan)
        middle = 2 * z[1:-1, 1:-1]
        bend = np.fmax(z[2:, 1:-1] + z[:-2, 1:-1] - middle, z[1:-1, 2:] + z[1:-1, :-2] - middle)
        if not (bend > ROUNDING * np.nanmax(np.abs(z), initial=0.0)).any():
            break
        i, j = np.unravel_index(int(np.nanargmax(bend)), bend.shape)
        centre, half = np.array([x[i + 1], y[j + 1]]), half / CLOSER
    far, near = (_rise(heights, centre, part * reach) for part in (FAR, NEAR))
    level = ROUNDING * max(abs(float(heights(centre[:1], centre[1:])[0])), reach)
    if not (far > near > level):
        return Tip(centre, 2.0, 0.0)
    return Tip(centre, float(np.log(far / near) / np.log(FAR / NEAR)), far / (FAR * reach))


def _rise(heights: Callable[[Array, Array], Array], centre: Array, distance: float) -> float:
    """Mean height at four points around a point over that at it."""
    around = centre + distance * np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [0, 0]])
    z = heights(around[:, 0], around[:, 1])
    return float(np.mean(z[:4]) - z[4])
