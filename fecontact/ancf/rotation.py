"""The rotation of a matrix that is linear in coordinates, and what does work on it.

R is that of the polar decomposition A = R S. From dA follow the axial vector w of R^T dR and the forces P by A of a
vector t that does the work t . w:

    T w = a(R^T dA),    T = tr S - S,    a_k(M) = - eps_kij M_ij,    P = R [g]x,    T g = t

(differential of the polar decomposition: Bonet & Wood 2008, section 3.5, for F = R U).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError

EPS = np.zeros((3, 3, 3))
EPS[[0, 1, 2], [1, 2, 0], [2, 0, 1]], EPS[[0, 2, 1], [2, 1, 0], [1, 0, 2]] = 1.0, -1.0
#: Sum of the smaller stretches over the largest below which a matrix has no rotation.
FLAT = 1e-9
#: Unit changes (9, 3, 3) of a matrix.
UNIT = np.eye(9).reshape(9, 3, 3)


def skew(g: Array) -> Array:
    """[g]x (.., 3, 3) with [g]x v = g x v."""
    return -np.einsum("ijk,...k->...ij", EPS, g)


def axial(M: Array) -> Array:
    """a(M) (.., 3), with which M : [w]x = a . w."""
    return -np.einsum("kij,...ij->...k", EPS, M)


@dataclass(frozen=True, eq=False)
class Rotation:
    """Of a matrix A (3, 3).

    Examples
    --------
    >>> turn = Rotation(2.0 * np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    >>> turn.R.round(12).tolist()
    [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    """

    A: Array

    @cached_property
    def _parts(self) -> tuple[Array, Array]:
        U, stretch, V = np.linalg.svd(self.A)
        turn = np.linalg.det(U) * np.linalg.det(V)
        stretch[2] *= turn
        U[:, 2] *= turn
        if not stretch[1] + stretch[2] > FLAT * stretch[0]:
            raise InputError("What is flattened to a line has no rotation about itself.")
        return U @ V, (V.T * (stretch.sum() - stretch)) @ V

    @property
    def R(self) -> Array:
        """The rotation, det R = 1.

        Raises
        ------
        InputError
            If it is not defined: A is flattened to a line.
        """
        return self._parts[0]

    @property
    def T(self) -> Array:
        """T = tr S - S."""
        return self._parts[1]

    @cached_property
    def spin(self) -> Array:
        """R^T dR (9, 3, 3) of unit changes of A, row by row."""
        return skew(self._by_T(axial(self.R.T @ UNIT)))

    def _by_T(self, t: Array) -> Array:
        """Solutions g of T g = t, of vectors (.., 3)."""
        return np.asarray(np.linalg.solve(self.T, t.T).T, dtype=float)

    def forces(self, t: Array) -> Array:
        """P (3, 3)."""
        return np.asarray(self.R @ skew(self._by_T(t)))

    def tangent(self, t: Array, dt: Array) -> Array:
        """Derivatives (9, 3, 3) of P, where t changes by dt (9, 3)."""
        g = self._by_T(t)
        dS = np.asarray(self.R.T @ UNIT - self.spin @ (self.R.T @ self.A))
        dT = np.trace(dS, axis1=1, axis2=2)[:, None, None] * np.eye(3) - dS
        dg = self._by_T(dt - np.einsum("nij,j->ni", dT, g))
        return np.asarray(self.R @ (self.spin @ skew(g) + skew(dg)))
