"""Strain measures of slender elements, with their first and second derivatives.

A measure is a function of derivatives g (n_g vectors) of the position, which are linear in the coordinates: stretch of
an axis, products of gradients (Green-Lagrange strains, elastic line, middle surface), curvature of a line, curvature of
a surface. With strains e(g) and stresses s = D e the energy is (1/2) e D e, its gradient s de/dg, its second derivative
(de/dg) D (de/dg) + s d2e/dg2; both are exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Protocol

import numpy as np

from fecontact.common.arrays import Array


class Measure(Protocol):
    """A strain measure; leading axes of all arrays are those of elements and quadrature points."""

    def strain(self, g: Array) -> Array:
        """Strains (..., m) of derivatives (..., n_g, 3)."""

    def first(self, g: Array) -> Array:
        """de/dg (..., m, n_g, 3)."""

    def second(self, g: Array, s: Array) -> Array:
        """Sum of s_m d2e_m/dg2 (..., n_g, 3, n_g, 3)."""


@dataclass(frozen=True)
class Stretch:
    """|r'| - 1."""

    def strain(self, g: Array) -> Array:
        """(..., 1)."""
        return np.linalg.norm(g[..., 0, :], axis=-1)[..., None] - 1

    def first(self, g: Array) -> Array:
        """The unit tangent."""
        a = g[..., 0, :]
        return (a / np.linalg.norm(a, axis=-1, keepdims=True))[..., None, None, :]

    def second(self, g: Array, s: Array) -> Array:
        """With the unit tangent t: s (1 - t t) / |r'|."""
        a = g[..., 0, :]
        size = np.linalg.norm(a, axis=-1)[..., None, None]
        t = a / size[..., 0]
        projector = np.eye(3) - t[..., :, None] * t[..., None, :]
        return np.asarray(s[..., None] * projector / size)[..., None, :, None, :]


@dataclass(frozen=True)
class Products:
    """Sums of products of derivatives, e_m = sum_k c_mk g_i . g_j - constant: quadratic in the coordinates.

    Attributes
    ----------
    terms : tuple of tuples of (float, int, int)
        For each strain, its terms (c, i, j).
    constants : tuple of float
    """

    terms: tuple[tuple[tuple[float, int, int], ...], ...]
    constants: tuple[float, ...]

    def strain(self, g: Array) -> Array:
        """(..., m)."""
        return np.asarray((self.first(g) * g[..., None, :, :]).sum(axis=(-2, -1)) / 2 - np.array(self.constants))

    def first(self, g: Array) -> Array:
        """A_m g."""
        return np.asarray(_forms(self.terms, g.shape[-2]) @ g[..., None, :, :])

    def second(self, g: Array, s: Array) -> Array:
        """Sum of s_m A_m, for each component."""
        A = np.tensordot(s, _forms(self.terms, g.shape[-2]), axes=1)
        return np.asarray(A[..., :, None, :, None] * np.eye(3)[:, None, :])


@cache
def _forms(terms: tuple[tuple[tuple[float, int, int], ...], ...], n_g: int) -> Array:
    """Symmetric matrices (m, n_g, n_g) with e_m = (1/2) g A_m g - constant."""
    A = np.zeros((len(terms), n_g, n_g))
    for m, products in enumerate(terms):
        for c, i, j in products:
            A[m, i, j] += c
            A[m, j, i] += c
    return A


@dataclass(frozen=True)
class ChordFrame:
    """Linear strains in the frame of an element's chord c, in the plane x, y: r_x . i - 1 and r_xx . j.

    Of derivatives r_x, r_xx and c = (r_B - r_A) / L, with i = c / |c| and j at right angles to it. Displacements from
    the chord must be small within an element, which converges to the rod as elements are divided.
    Source: M. Campanelli, M. Berzeri & A. A. Shabana, report MBS99-2-UIC, 1999, section 3; J. L. Escalona, H. A.
    Hussien & A. A. Shabana, J. Sound Vib. 214 (1998), 833-851.
    """

    def strain(self, g: Array) -> Array:
        """(..., 2)."""
        i, _, _ = _along(g)
        turned = _right(g[..., 1, :])
        return np.stack([(g[..., 0, :] * i).sum(-1) - 1, (turned * i).sum(-1)], axis=-1)

    def first(self, g: Array) -> Array:
        """The chord's directions along r_x and r_xx, and its turn."""
        i, projector, size = _along(g)
        out = np.zeros((*g.shape[:-2], 2, 3, 3))
        out[..., 0, 0, :] = i
        out[..., 1, 1, :] = -_right(i)
        for m, u in enumerate((g[..., 0, :], _right(g[..., 1, :]))):
            out[..., m, 2, :] = np.einsum("...xy,...y->...x", projector, u) / size
        return out

    def second(self, g: Array, s: Array) -> Array:
        """Of u . i, u = s_1 r_x + s_2 (r_xx turned by a right angle)."""
        i, P, size = _along(g)
        s1, s2 = s[..., :1], s[..., 1:]
        u = s1 * g[..., 0, :] + s2 * _right(g[..., 1, :])
        Pu = np.einsum("...xy,...y->...x", P, u)
        out = np.zeros((*g.shape[:-2], 3, 3, 3, 3))
        along = (u * i).sum(-1)[..., None, None] * P
        out[..., 2, :, 2, :] = -(_outer(i, Pu) + _outer(Pu, i) + along) / size[..., None] ** 2
        turn = _right(np.eye(3)).T  # of column vectors
        for m, block in enumerate((s1[..., None] * P, s2[..., None] * (turn.T @ P))):
            out[..., m, :, 2, :] = block / size[..., None]
            out[..., 2, :, m, :] = np.swapaxes(out[..., m, :, 2, :], -1, -2)
        return out


def _right(v: Array) -> Array:
    """Vectors (..., 3) turned by a right angle about z, clockwise: v x e_z."""
    return np.stack([v[..., 1], -v[..., 0], 0 * v[..., 0]], axis=-1)


def _along(g: Array) -> tuple[Array, Array, Array]:
    """Unit chord (..., 3), the projector across it (..., 3, 3) and its length (..., 1)."""
    size = np.linalg.norm(g[..., 2, :], axis=-1, keepdims=True)
    i = g[..., 2, :] / size
    return i, np.eye(3) - _outer(i, i), size


def green_lagrange(axes: Sequence[int]) -> Products:
    """Green-Lagrange strains of derivatives along these axes: normal ones, then twice those of shear."""
    pairs = [(i, j) for i in axes for j in axes if i < j]
    terms = [((0.5, i, i),) for i in axes] + [((1.0, i, j),) for i, j in pairs]
    return Products(tuple(terms), tuple([0.5] * len(axes) + [0.0] * len(pairs)))


@dataclass(frozen=True)
class LineCurvature:
    """(r' x r'') / |r'|^p: with p = 2 the turn per unit of initial length, with p = 3 the geometric curvature.

    Three components; a line has no twist, and bends alike in all directions.
    """

    p: int

    def strain(self, g: Array) -> Array:
        """(..., 3)."""
        a, b = g[..., 0, :], g[..., 1, :]
        return _cross(a, b) / np.linalg.norm(a, axis=-1, keepdims=True) ** self.p

    def first(self, g: Array) -> Array:
        """With n = r' x r'' and s = r' . r': dn s^(-p/2) - p n s^(-p/2 - 1) r'."""
        a, b = g[..., 0, :], g[..., 1, :]
        s = (a * a).sum(-1)[..., None, None]
        n = _cross(a, b)
        # rows of d(a x b) along changes of a and of b
        by_a = -_cross_matrix(b) - self.p * n[..., :, None] * a[..., None, :] / s
        return np.stack([by_a, _cross_matrix(a)], axis=-2) * (s ** (-self.p / 2))[..., None]

    def second(self, g: Array, s: Array) -> Array:
        """Second derivatives of f s^(-p/2), f = m . (r' x r''), for a constant m."""
        a, b, m, p = g[..., 0, :], g[..., 1, :], s, self.p
        size = (a * a).sum(-1)[..., None, None]
        f = (m * _cross(a, b)).sum(-1)[..., None, None]
        by_a, by_b = _cross(b, m), _cross(m, a)
        aa = _outer(by_a, a) + _outer(a, by_a)
        out = np.zeros((*a.shape[:-1], 2, 3, 2, 3))
        out[..., 0, :, 0, :] = -p * aa / size + f * (p * (p + 2) * _outer(a, a) / size**2 - p * np.eye(3) / size)
        # d/db of (b x m) is -[m]x; rows by a, columns by b
        out[..., 0, :, 1, :] = -_cross_matrix(m) - p * _outer(a, by_b) / size
        out[..., 1, :, 0, :] = np.swapaxes(out[..., 0, :, 1, :], -1, -2)
        return out * (size ** (-p / 2))[..., None, None]


@dataclass(frozen=True)
class SurfaceCurvature:
    """Second derivatives along the normal: r_xx . n, r_yy . n, 2 r_xy . n, n the unit vector of r_x x r_y.

    Derivatives in the order r_x, r_y, r_xx, r_yy, r_xy.
    """

    def strain(self, g: Array) -> Array:
        """(..., 3)."""
        _, n, _ = _normal(g)
        values = np.einsum("...ix,...x->...i", g[..., 2:, :], n)
        return np.asarray(values * [1.0, 1.0, 2.0])

    def first(self, g: Array) -> Array:
        """The normal along the second derivatives, and its turn along the first ones."""
        size, n, projector = _normal(g)
        out = np.zeros((*g.shape[:-2], 3, 5, 3))
        for m, c in enumerate((1.0, 1.0, 2.0)):
            out[..., m, 2 + m, :] = c * n
            along = c * np.einsum("...xy,...y->...x", projector, g[..., 2 + m, :]) / size
            out[..., m, 0, :] = _cross(g[..., 1, :], along)
            out[..., m, 1, :] = _cross(along, g[..., 0, :])
        return out

    def second(self, g: Array, s: Array) -> Array:
        """Of u . n with u the second derivatives weighted by s."""
        size, n, P = _normal(g)
        weights = s * [1.0, 1.0, 2.0]
        u = np.einsum("...m,...mx->...x", weights, g[..., 2:, :])
        a, b = _cross_matrix(g[..., 0, :]), _cross_matrix(g[..., 1, :])
        Pu = np.einsum("...xy,...y->...x", P, u)
        by_d = Pu / size
        dd = -(_outer(n, Pu) + _outer(Pu, n) + (u * n).sum(-1)[..., None, None] * P) / size[..., None] ** 2
        # d = r_x x r_y: changes -[r_y]x v of r_x and [r_x]x w of r_y
        turns = (-b, a)
        out = np.zeros((*g.shape[:-2], 5, 3, 5, 3))
        for i, left in enumerate(turns):
            for j, right in enumerate(turns):
                out[..., i, :, j, :] = np.swapaxes(left, -1, -2) @ dd @ right
            for m in range(3):
                block = weights[..., m, None, None] * (P / size[..., None]) @ left
                out[..., 2 + m, :, i, :] = block
                out[..., i, :, 2 + m, :] = np.swapaxes(block, -1, -2)
        # by_d . (v x w) with v a change of r_x, w of r_y
        mixed = _cross_matrix(by_d)
        out[..., 0, :, 1, :] -= mixed
        out[..., 1, :, 0, :] += mixed
        return out


@dataclass(frozen=True)
class Together:
    """Strains of a measure of the first derivatives, then those of another one of all, for sections that couple them.

    Attributes
    ----------
    one : Measure
    n : int
        Derivatives that it takes.
    other : Measure
    """

    one: Measure
    n: int
    other: Measure

    def strain(self, g: Array) -> Array:
        """(..., m)."""
        return np.concatenate([self.one.strain(g[..., : self.n, :]), self.other.strain(g)], axis=-1)

    def first(self, g: Array) -> Array:
        """(..., m, n_g, 3)."""
        all_of, some = self.other.first(g), self.one.first(g[..., : self.n, :])
        padded = np.zeros((*some.shape[:-2], *all_of.shape[-2:]))
        padded[..., : self.n, :] = some
        return np.concatenate([padded, all_of], axis=-3)

    def second(self, g: Array, s: Array) -> Array:
        """Of both, weighted by s (..., m)."""
        m = s.shape[-1] - self.other.strain(g).shape[-1]
        out = self.other.second(g, s[..., m:])
        out[..., : self.n, :, : self.n, :] += self.one.second(g[..., : self.n, :], s[..., :m])
        return out


def _normal(g: Array) -> tuple[Array, Array, Array]:
    """Size (..., 1) of r_x x r_y, its unit vector, and the projector on the tangent plane."""
    d = _cross(g[..., 0, :], g[..., 1, :])
    size = np.linalg.norm(d, axis=-1, keepdims=True)
    n = d / size
    return size, n, np.eye(3) - _outer(n, n)


def _outer(a: Array, b: Array) -> Array:
    return np.asarray(a[..., :, None] * b[..., None, :])


def _cross(a: Array, b: Array) -> Array:
    """Product a x b; for few points in a fraction of the time of NumPy's own."""
    return np.asarray(a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]])


def _cross_matrix(a: Array) -> Array:
    """[a]x with [a]x v = a x v."""
    out = np.zeros((*a.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., i, j], out[..., j, i] = -a[..., k], a[..., k]
    return out
