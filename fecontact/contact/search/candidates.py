"""Candidate pairs: those that may touch, estimated from the gap before a solve.

The cost grows with the candidates, so there should be few. A missing pair that penetrates is found by the certificate
and added, so the choice affects the time but not the solution.
"""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask

#: Share of the estimated rigid overlap within which pairs are candidates; one half for a Hertz contact.
MARGIN = 0.72
#: The same of a thin layer whose overlap is prescribed: it touches wherever it overlaps.
LAYER_MARGIN = 1.0
#: Least number of candidates of a contact.
FEWEST = 12


def approach_for_load(gap: Array, area: Array, modulus: float, force: float, thickness: float | None = None) -> float:
    """Estimate of the rigid approach at which the overlap of the undeformed surfaces carries a force.

    An overlap of volume V and area A is taken to carry about E* V / sqrt(A). For a paraboloid, where V = pi R d^2 and
    A = 2 pi R d at approach d, that is 0.94 of the elastic force; for other shapes it is an order of magnitude. In a
    plane the width A / t of the overlap replaces sqrt(A).

    Parameters
    ----------
    gap : (n,) array
        Gaps; the smallest is zero.
    area : (n,) array
    modulus : float
        Contact modulus E*.
    force : float
    thickness : float, optional
        Thickness Thickness t of a plane problem.

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


def choose(gap: Array, approach: float, layer: bool = False) -> IntArray:
    """Pairs whose gap above the smallest is within `MARGIN` (`LAYER_MARGIN`) times an approach, at least `FEWEST`.

    Examples
    --------
    >>> gap = np.linspace(-1.0, 1.0, 200)
    >>> len(choose(gap, 1.0)), len(choose(gap, 1.0, layer=True))
    (72, 100)
    """
    order = np.argsort(gap, kind="stable")
    above = gap[order] - gap[order[0]]
    n = int(np.searchsorted(above, (LAYER_MARGIN if layer else MARGIN) * approach, side="right"))
    return np.sort(order[: max(n, FEWEST)])


def grow(chosen: IntArray, gap: Array, penetrating: Mask) -> IntArray:
    """Candidates plus the penetrating pairs and all others up to 1.5 times their initial gap."""
    limit = gap[penetrating].max() - gap.min()
    return np.union1d(chosen, np.flatnonzero(gap - gap.min() <= 1.5 * limit))


def widen(chosen: IntArray, gap: Array) -> IntArray:
    """Candidates plus pairs up to twice the gap above the smallest, at least twice as many in all.

    Examples
    --------
    >>> widen(np.array([0, 1]), np.array([0.0, 0.1, 0.15, 0.3, 0.4])).tolist()
    [0, 1, 2, 3]
    """
    above = gap - gap.min()
    search_radius = max(2 * float(above[chosen].max()), float(np.sort(above)[min(2 * len(chosen), len(gap)) - 1]))
    return np.union1d(chosen, np.flatnonzero(above <= search_radius))
