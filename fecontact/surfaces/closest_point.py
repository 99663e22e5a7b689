"""Facets as polynomials, and what Newton's search for a nearest point needs of them, for many points at once.

A facet is x(s, t) = origin + sum c_ij s^i t^j. Arrays run over the points in their last axis, in blocks that stay in
the cache: with a few dozen operations on a few numbers each, the way to memory is what takes time.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.facets import facet_shapes

#: Points worked on at once: some dozens of numbers each should stay in a core's cache.
BLOCK = 4096


@cache
def _coefficients(n_columns: int, triangle: bool, degree: int) -> Array:
    """Coefficients ((degree + 1)^2, n_columns) of a facet's shape functions over the monomials s^i t^j.

    scikit-fem gives values and first derivatives only; as polynomials they can be derived as often as Newton needs.
    """
    t = np.linspace(0.0, 1.0, degree + 1)
    grid = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    values = facet_shapes(n_columns, np.full(len(grid), triangle), grid)[0]
    power = np.vander(t, degree + 1, increasing=True)
    return np.linalg.solve(np.kron(power, power), values)


@dataclass(frozen=True, eq=False)
class Patches:
    """Facets as polynomials.

    Attributes
    ----------
    origin : (3, n_facets) array
        Each facet's first node, so that the polynomials know nothing of how far away the body stands.
    coefficients : (degree + 1, degree + 1, 3, n_facets) array
        c_ij.
    triangle : (n_facets,) bool array
    n_columns : int
        Nodes of a facet.
    """

    origin: Array
    coefficients: Array
    triangle: Mask
    n_columns: int

    @property
    def degree(self) -> int:
        """Largest power of one coordinate."""
        return len(self.coefficients) - 1

    def evaluate(self, facet: IntArray, local: Array) -> tuple[Array, Array]:
        """Positions (n, 3) and tangents (n, 3, 2) at coordinates (n, 2) of facets (n,)."""
        n = len(facet)
        x, tangents = np.empty((n, 3)), np.empty((n, 3, 2))
        for start in range(0, n, BLOCK):
            part = slice(start, start + BLOCK)
            c = self.coefficients[..., facet[part]]
            s, t = local[part].T
            value, along_s, along_t = first_derivatives(c, s, t)
            x[part] = (value + self.origin[:, facet[part]]).T
            tangents[part, :, 0], tangents[part, :, 1] = along_s.T, along_t.T
        return x, tangents

    def shapes(self, facet: IntArray, local: Array) -> Array:
        """Shape functions (n, n_columns) at coordinates (n, 2) of facets (n,)."""
        s, t = local.T
        rank = range(self.degree + 1)
        powers = np.stack([s**i * t**j for i in rank for j in rank], axis=1)
        kinds = [_coefficients(self.n_columns, kind, self.degree) for kind in (False, True)]
        N = powers @ kinds[0]
        if self.triangle.any():
            rows = np.flatnonzero(self.triangle[facet])
            N[rows] = powers[rows] @ kinds[1]
        return N

    def relative_to(self, facet: IntArray, points: Array) -> Array:
        """Coefficients (degree + 1, degree + 1, 3, n) of facets (n,) seen from points (n, 3)."""
        c = self.coefficients[..., facet]
        c[0, 0] += self.origin[:, facet] - points.T
        return c


def patches(points: Array, facets: IntArray, triangle: Mask) -> Patches:
    """Facets (n_facets, 4 | 8 | 9) on points (n_points, 3) as polynomials."""
    degree = 1 if facets.shape[1] == 4 else 3 if triangle.any() else 2
    origin = points[facets[:, 0]]
    offsets = points[facets] - origin[:, None]
    c = np.empty(((degree + 1) ** 2, 3, len(facets)))
    for kind in (False, True):
        rows = np.flatnonzero(triangle == kind)
        if len(rows):
            c[..., rows] = np.einsum("pa,nai->pin", _coefficients(facets.shape[1], kind, degree), offsets[rows])
    shape = (degree + 1, degree + 1, 3, len(facets))
    return Patches(np.ascontiguousarray(origin.T), c.reshape(shape), triangle, facets.shape[1])


def first_derivatives(c: Array, s: Array, t: Array) -> tuple[Array, Array, Array]:
    """Value and first derivatives (3, n) of polynomials (m, m, 3, n), by Horner's scheme."""
    in_t = c[:, -1]
    slope_t = np.zeros_like(in_t)
    for j in range(c.shape[1] - 2, -1, -1):
        slope_t = slope_t * t + in_t
        in_t = in_t * t + c[:, j]
    value, along_t = in_t[-1], slope_t[-1]
    along_s = np.zeros_like(value)
    for i in range(len(c) - 2, -1, -1):
        along_s = along_s * s + value
        value = value * s + in_t[i]
        along_t = along_t * s + slope_t[i]
    return value, along_s, along_t


def _dot(u: Array, v: Array) -> Array:
    """Scalar products (n,) of vectors (3, n)."""
    return np.asarray(u[0] * v[0] + u[1] * v[1] + u[2] * v[2])


def derivatives(c: Array, local: Array) -> tuple[Array, Array]:
    """Newton's equations for half the squared distance of polynomials from the origin.

    Gauss-Newton's matrix replaces the Hessian where that is not positive definite.

    Parameters
    ----------
    c : (m, m, 3, n) array
    local : (2, n) array

    Returns
    -------
    gradient : (2, n) array
    matrix : (3, n) array
        The components ss, st and tt of a positive definite matrix.
    """
    s, t = local
    in_t, slope_t = c[:, -1], np.zeros_like(c[:, -1])
    bend_t = slope_t
    for j in range(c.shape[1] - 2, -1, -1):
        bend_t = bend_t * t + slope_t
        slope_t = slope_t * t + in_t
        in_t = in_t * t + c[:, j]
    r, x_t, half_tt = in_t[-1], slope_t[-1], bend_t[-1]
    x_s = np.zeros_like(r)
    half_ss, x_st = x_s, x_s
    for i in range(len(c) - 2, -1, -1):
        half_ss = half_ss * s + x_s
        x_s = x_s * s + r
        r = r * s + in_t[i]
        x_st = x_st * s + x_t
        x_t = x_t * s + slope_t[i]
        half_tt = half_tt * s + bend_t[i]
    gradient = np.stack([_dot(r, x_s), _dot(r, x_t)])
    a, b, d = _dot(x_s, x_s), _dot(x_s, x_t), _dot(x_t, x_t)
    ha, hb, hd = a + 2 * _dot(r, half_ss), b + _dot(r, x_st), d + 2 * _dot(r, half_tt)
    definite = (ha * hd - hb**2 > 0.01 * a * d) & (ha > 0)
    return gradient, np.stack([np.where(definite, h, g) for h, g in ((ha, a), (hb, b), (hd, d))])
