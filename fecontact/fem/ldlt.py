"""LDL^T factorisation by rslab, a small library with wheels for every platform; used when PARDISO is not installed."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array
from fecontact.common.errors import FecontactError
from fecontact.fem.pardiso import SINGULAR


class LdltFactor:
    """Factor of a whole stiffness, given as a full symmetric matrix (an empty one is allowed).

    Pivots of a definite matrix are positive: one that is not tells a loose part.
    """

    def __init__(self, K: sp.csc_matrix) -> None:
        self._factor: Any = None
        if K.shape[0] == 0:
            return
        import rslab

        threads = int(os.environ.get("OMP_NUM_THREADS", "0")) or None
        try:
            self._factor = rslab.ldlt(K, threads=threads, ordering="metis" if K.shape[0] > 1000 else None)
        except (RuntimeError, ValueError, ArithmeticError) as error:
            raise FecontactError(f"{SINGULAR} ({error})") from error
        if self._factor.inertia[0] < K.shape[0] or self._factor.n_perturbed:
            raise FecontactError(SINGULAR)

    @property
    def memory(self) -> int:
        """Bytes of the factor's values; the indices of its supernodes are few."""
        return 0 if self._factor is None else 8 * int(self._factor.factor_nnz)

    def solve(self, b: Array) -> Array:
        """Solutions (k, n) for right-hand sides in the rows of b (k, n)."""
        return self.solve_columns(b.T).T

    def solve_columns(self, b: Array) -> Array:
        """Solutions (n, k) for right-hand sides in the columns of b (n, k)."""
        if b.size == 0:
            return b
        return np.asarray(self._factor.solve_many(np.ascontiguousarray(b)))
