"""Which pairs are worth condensing: those that may touch, judged from the gap before anything is solved.

Only candidates cost anything, so there should be few; a pair that is left out and would penetrate is found by the
certificate afterwards and taken in, so the choice decides the time and never the answer.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import Array

#: Share of the estimated rigid overlap within which pairs are candidates. A Hertz contact ends at one half.
MARGIN = 0.72
#: A contact has at least this many candidates, enough to stand on.
FEWEST = 12


def approach_for_load(gap: Array, area: Array, modulus: float, force: float, thickness: float | None = None) -> float:
    """Rigid approach at which the overlap of the undeformed surfaces would carry a force, by a scale estimate.

    The overlap of volume V and area A at approach d is taken to carry about E* V / sqrt(A). For a paraboloid, where
    V = pi R d^2 and A = 2 pi R d, that is 0.94 of the elastic answer; for other shapes it is a scale. In a plane the
    width A / t of the overlap takes the place of sqrt(A).

    Parameters
    ----------
    gap : (n,) array
        Gaps, the smallest of which is zero.
    area : (n,) array
    modulus : float
        Contact modulus E*.
    force : float
    thickness : float, optional
        t of a plane problem.

    Returns
    -------
    float
        Approach measured from first touch.
    """
    order = np.argsort(gap)
    g, a = gap[order], area[order]
    covered = np.cumsum(a)
    volume = g * covered - np.cumsum(a * g)
    width = np.sqrt(covered) if thickness is None else covered / thickness
    carried = modulus * volume / width
    k = int(np.searchsorted(np.maximum.accumulate(carried), force))
    if k >= len(g):
        # everything overlaps and the rest of the approach is uniform
        return float(g[-1] + (force - carried[-1]) / (modulus * covered[-1] / width[-1]))
    if k == 0:
        return float(g[0])
    # between two nodes the area is that of the lower: modulus * (volume + A (d - g)) / width = force
    extra = (force - carried[k - 1]) / (modulus * covered[k - 1] / width[k - 1])
    return float(g[k - 1] + extra)


def choose(gap: Array, approach: float) -> NDArray[np.int64]:
    """Numbers of the pairs whose gap above the smallest is within `MARGIN` of an approach, at least `FEWEST`."""
    order = np.argsort(gap, kind="stable")
    above = gap[order] - gap[order[0]]
    n = int(np.searchsorted(above, MARGIN * approach, side="right"))
    return np.sort(order[: max(n, FEWEST)])


def grow(chosen: NDArray[np.int64], gap: Array, penetrating: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Take in the penetrating pairs and all others with no larger initial gap than half as much again."""
    limit = gap[penetrating].max() - gap.min()
    return np.union1d(chosen, np.flatnonzero(gap - gap.min() <= 1.5 * limit))


def widen(chosen: NDArray[np.int64], gap: Array) -> NDArray[np.int64]:
    """Take in pairs up to twice the gap above the smallest, and at least as many again.

    Examples
    --------
    >>> widen(np.array([0, 1]), np.array([0.0, 0.1, 0.15, 0.3, 0.4])).tolist()
    [0, 1, 2, 3]
    """
    above = gap - gap.min()
    search_radius = max(2 * float(above[chosen].max()), float(np.sort(above)[min(2 * len(chosen), len(gap)) - 1]))
    return np.union1d(chosen, np.flatnonzero(above <= search_radius))
