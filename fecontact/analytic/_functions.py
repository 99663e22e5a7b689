"""Elementary functions in forms without cancellation.

Quadrature rules on the unit interval.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array

# 1 - atan(t)/t = t^2/3 - t^4/5 + ...; below 0.5 the terms left out are smaller than 0.25^27 = 6e-17 of the first.
_SERIES = np.array([(-1) ** n / (2 * n + 3) for n in range(27)])[::-1]


def arctan_defect(t: ArrayLike) -> Array:
    """Return 1 - atan(t)/t for t >= 0 (infinity allowed), to full relative accuracy down to t = 0.

    Examples
    --------
    >>> round(float(arctan_defect(1e-6)) * 3e12, 15)
    0.9999999999994
    >>> float(arctan_defect(np.inf))
    1.0
    """
    t = np.asarray(t, dtype=float)
    small = t < 0.5
    square = np.where(small, t, 0.0) ** 2
    large = np.where(small, 1.0, t)
    return np.where(small, square * np.polyval(_SERIES, square), 1 - np.arctan(large) / large)


def sinh_excess(y: Array) -> Array:
    """Return sinh(y) - y for 0 <= y <= 1 by its series, to full relative accuracy.

    Examples
    --------
    >>> round(float(sinh_excess(np.array(1e-8))) * 6e24, 12)
    1.0
    """
    square = y**2
    series = np.ones_like(square)
    # y^3/6 (1 + y^2/20 (1 + y^2/42 (1 + ...))); for y <= 1 the first term left out is 3e-17 of the sum.
    for n in range(8, 1, -1):
        series = 1 + square / (2 * n * (2 * n + 1)) * series
    return np.asarray(y * square / 6 * series)


def trough_gap(ratio: ArrayLike) -> Array:
    """Return x sqrt(x^2 - 1) - arccosh(x) for x >= 1, the opening of a plane contact beyond its edge, and 0 below.

    With cosh t = x it is (sinh(2t) - 2t)/2, taken by its series near the edge, where it grows as (x - 1)^(3/2).

    Examples
    --------
    >>> trough_gap([0.5, 1.0, 2.0]).round(6)
    array([0.      , 0.      , 2.147144])
    """
    x = np.maximum(np.asarray(ratio, dtype=float), 1.0)
    root = np.sqrt((x - 1) * (x + 1))
    twice = 2 * np.arcsinh(root)
    return np.asarray(np.where(twice < 1, sinh_excess(np.minimum(twice, 1.0)) / 2, x * root - twice / 2))


@cache
def double_exponential(level: int) -> tuple[Array, Array]:
    """Return nodes and weights on (0, 1) for integrands with end singularities of unknown strength.

    With x = 1/(1 + exp(-pi sinh t)) the integrand decays double-exponentially in t, and the trapezoidal rule with step
    2^-level converges exponentially for any integrable power or logarithmic singularity at the ends.

    References
    ----------
    H. Takahasi & M. Mori, Publ. RIMS Kyoto 9 (1974) 721.

    Examples
    --------
    >>> x, w = double_exponential(4)
    >>> round(float(w @ x**-0.5), 12)
    2.0
    """
    step = 2.0**-level
    # At t = 4.5 the node lies 1e-61 from the end: x^(-1/2) is cut off at 1e-30 of the integral.
    t = step * np.arange(-round(4.5 / step), round(4.5 / step) + 1)
    exponent = np.pi * np.sinh(t)
    x = 1 / (1 + np.exp(-exponent))
    return x, step * np.pi * np.cosh(t) * x / (1 + np.exp(exponent))


@cache
def gauss(order: int) -> tuple[Array, Array]:
    """Return nodes and weights of Gauss-Legendre quadrature on (0, 1).

    Examples
    --------
    >>> x, w = gauss(4)
    >>> round(float(w @ x**7), 12)
    0.125
    """
    nodes, weights = np.polynomial.legendre.leggauss(order)
    return (1 + nodes) / 2, weights / 2


def composite_gauss(panels: int, order: int) -> tuple[Array, Array]:
    """Return nodes and weights of Gauss-Legendre quadrature on equal panels of (0, 1).

    Examples
    --------
    >>> x, w = composite_gauss(3, 4)
    >>> len(x), round(float(w.sum()), 12)
    (12, 1.0)
    """
    nodes, weights = gauss(order)
    return ((np.arange(panels)[:, None] + nodes) / panels).ravel(), np.tile(weights / panels, panels)
