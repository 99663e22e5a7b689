"""Static condensation by columns, for factorisations that have no Schur complement of their own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray


class WholeFactor(Protocol):
    """Factor of a full symmetric matrix that solves for rows and for columns of right-hand sides."""

    @property
    def memory(self) -> int:
        """Bytes of the factor."""

    def solve(self, b: Array) -> Array:
        """Solutions (k, n) for right-hand sides in the rows of b (k, n)."""

    def solve_columns(self, b: Array) -> Array:
        """Solutions (n, k) for right-hand sides in the columns of b (n, k)."""


class ColumnSchur:
    """Schur complement by blocks of right-hand sides, with any factor of the inner part."""

    #: Right-hand sides solved at once; bounds the dense block at about n * 64 doubles.
    block = 64

    def __init__(self, K: sp.csr_matrix, retained: IntArray, factor: Callable[[sp.csc_matrix], WholeFactor]) -> None:
        n = K.shape[0]
        inner = np.ones(n, bool)
        inner[retained] = False
        self._c, self._i = retained, np.flatnonzero(inner)
        full = symmetric(K)
        columns = full[:, retained]
        self._ic = columns[self._i].tocsc()
        k_cc = columns[retained].toarray()
        self._factor = factor(full[:, self._i].tocsr()[self._i].tocsc())
        for start in range(0, len(retained), self.block):
            part = slice(start, start + self.block)
            k_cc[:, part] -= self._ic.T @ self._factor.solve_columns(self._ic[:, part].toarray())
        self.stiffness = (k_cc + k_cc.T) / 2

    @property
    def memory(self) -> int:
        """Bytes of the factorisation."""
        return self._factor.memory

    def reduce(self, f: Array) -> Array:
        """Condensed loads (n_c, k) of loads f (n, k)."""
        return f[self._c] - self._ic.T @ self._factor.solve_columns(f[self._i])

    def expand(self, u_c: Array, f: Array) -> Array:
        """All displacements (n, k) from the retained ones and the loads."""
        u = np.empty_like(f)
        u[self._c] = u_c
        u[self._i] = self._factor.solve_columns(f[self._i] - self._ic @ u_c)
        return u


def symmetric(K: sp.csr_matrix) -> sp.csc_matrix:
    """Full symmetric matrix from its upper triangle."""
    return (K + sp.triu(K, 1).T).tocsc()
