"""Quadrature rules on the unit interval."""

from __future__ import annotations

from functools import cache

import numpy as np

from fecontact.common.arrays import Array


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
