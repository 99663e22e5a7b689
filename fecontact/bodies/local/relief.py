"""Relief of a curved surface over its tangent plane: a polynomial, for slopes and curvatures without kinks.

Chebyshev nodes on an interval, or on half of it for even functions, and the polynomials through values at them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev as series

from fecontact.common.arrays import Array, Mask
from fecontact.halfspace.grid import Even


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


REACH = 1.5
"""Extent of the polynomial, relative to the window."""

DEGREE = 8
"""Degree of the polynomial along either direction."""

SAMPLES = 25
"""Points along either side at which the surface is sampled."""

Depths = Callable[[Array, Array], Array]


@dataclass(frozen=True, eq=False)
class Relief:
    """Depth of a surface below its tangent plane, as a polynomial over a window and its surroundings.

    Attributes
    ----------
    reach : (2,) array
        Half the sides of the rectangle.
    terms : (n, n) array
        Coefficients of products of Chebyshev polynomials of x / reach and y / reach.
    misfit : float
        Largest distance of the samples from it.

    Examples
    --------
    >>> ball = fit(lambda x, y: 10 - np.sqrt(100 - x**2 - y**2), np.array([1.0, 1.0]), (True, True))
    >>> ball.slopes(np.array([0.6]), np.array([0.0])).round(6).tolist()
    [[0.060108, 0.0]]
    """

    reach: Array
    terms: Array
    misfit: float

    def _derivative(self, x: Array, y: Array, along_x: int, along_y: int) -> Array:
        terms = series.chebder(series.chebder(self.terms, along_x, axis=0), along_y, axis=1)
        values = series.chebval2d(x / self.reach[0], y / self.reach[1], terms)
        return np.asarray(values / self.reach[0] ** along_x / self.reach[1] ** along_y)

    def covers(self, x: Array, y: Array) -> Mask:
        """Whether places lie within its extent."""
        return np.asarray((np.abs(x) <= self.reach[0]) & (np.abs(y) <= self.reach[1]))

    def depth(self, x: Array, y: Array) -> Array:
        """Depths (n,)."""
        return self._derivative(x, y, 0, 0)

    def slopes(self, x: Array, y: Array) -> Array:
        """Slopes (n, 2) of the depth."""
        return np.stack([self._derivative(x, y, 1, 0), self._derivative(x, y, 0, 1)], axis=-1)

    def hessian(self, x: Array, y: Array) -> Array:
        """Second derivatives (n, 2, 2) of the depth, positive where the body is convex."""
        xx, xy, yy = (self._derivative(x, y, *k) for k in ((2, 0), (1, 1), (0, 2)))
        return np.stack([np.stack([xx, xy], axis=-1), np.stack([xy, yy], axis=-1)], axis=-2)

    def curvature(self, x: Array, y: Array) -> Array:
        """Curvature tensors (n, 3, 3) of the surface, along the plane's directions and its outward normal."""
        slopes, bend = self.slopes(x, y), self.hessian(x, y)
        up = np.concatenate([slopes, np.ones((*slopes.shape[:-1], 1))], axis=-1)
        length = np.linalg.norm(up, axis=-1)
        n = up / length[..., None]
        P = np.eye(3) - n[..., :, None] * n[..., None, :]
        tensor = np.zeros((*x.shape, 3, 3))
        tensor[..., :2, :2] = bend / length[..., None, None]
        return np.asarray(P @ tensor @ P)


def fit(depths: Depths, half: Array, mirrored: Even) -> Relief:
    """The relief that fits a surface best, given its depths at places x (n,) and y (n,); NaN where there is none.

    Near the middle the samples are dense, in least squares of all that lie on the surface.
    """
    reach = REACH * half
    along = [nodes(r, 2 * SAMPLES if even else SAMPLES, even) for r, even in zip(reach, mirrored, strict=True)]
    x, y = (c.ravel() for c in np.meshgrid(*along, indexing="ij"))
    z = depths(x, y)
    there = np.isfinite(z)
    steps = [2 if even else 1 for even in mirrored]
    basis = series.chebvander2d(x / reach[0], y / reach[1], [DEGREE, DEGREE]).reshape(-1, DEGREE + 1, DEGREE + 1)
    chosen = basis[there, :: steps[0], :: steps[1]]
    count = chosen.shape[1:]
    found = np.linalg.lstsq(chosen.reshape(len(chosen), -1), z[there], rcond=1e-12)[0]
    terms = np.zeros((DEGREE + 1, DEGREE + 1))
    terms[:: steps[0], :: steps[1]] = found.reshape(count)
    return Relief(reach, terms, float(np.abs(chosen.reshape(len(chosen), -1) @ found - z[there]).max(initial=0.0)))
