"""Chebyshev nodes on an interval, or on half of it for even functions, and the polynomials through values at them."""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array


def nodes(half: float, order: int, mirrored: bool) -> Array:
    """Chebyshev nodes on (-half, half), increasing; of an even number, the positive ones where it is mirrored.

    Examples
    --------
    >>> nodes(1.0, 2, True).round(4).tolist()
    [0.7071]
    """
    x = -half * np.cos(np.pi * (np.arange(order) + 0.5) / order)
    return np.asarray(x[order // 2 :] if mirrored else x)


def polynomials(x: Array, half: float, order: int, mirrored: bool) -> Array:
    """Chebyshev polynomials (n, k) of x / half below an order; where it is mirrored, the even ones.

    Examples
    --------
    >>> polynomials(np.array([0.5]), 1.0, 4, True).round(12).tolist()
    [[1.0, -0.5]]
    """
    degree = np.arange(0, order, 2 if mirrored else 1)
    return np.asarray(np.cos(degree * np.arccos(np.clip(x / half, -1.0, 1.0))[:, None]))


def coefficients(half: float, order: int, mirrored: bool) -> Array:
    """Matrix (k, k) from values at `nodes` to the coefficients of `polynomials`.

    Source: discrete orthogonality at the zeros of T_order (J. C. Mason, D. C. Handscomb, Chebyshev Polynomials, 2003,
    section 4.6).

    Examples
    --------
    >>> values = nodes(2.0, 4, False) ** 2
    >>> bool(np.allclose(coefficients(2.0, 4, False) @ values, [2.0, 0.0, 2.0, 0.0]))
    True
    """
    T = polynomials(nodes(half, order, mirrored), half, order, mirrored)
    scale = np.full(T.shape[1], 2.0 / len(T))
    scale[0] /= 2
    return np.asarray(scale[:, None] * T.T)


def interpolation(x: Array, half: float, order: int, mirrored: bool) -> Array:
    """Matrix (n, k) from values at `nodes` to the interpolating polynomial at x (n,).

    Examples
    --------
    >>> x = np.array([0.3, 1.5])
    >>> (interpolation(x, 2.0, 3, False) @ nodes(2.0, 3, False) ** 2).round(12).tolist()
    [0.09, 2.25]
    """
    return np.asarray(polynomials(x, half, order, mirrored) @ coefficients(half, order, mirrored))
