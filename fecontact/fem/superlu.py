"""SciPy's SuperLU, with METIS's nested dissection when pymetis is installed; used when no other library is."""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import FecontactError
from fecontact.fem.pardiso import SINGULAR


class SuperLUFactor:
    """Factor of a whole stiffness, given as a full symmetric matrix (an empty one is allowed)."""

    def __init__(self, K: sp.csc_matrix) -> None:
        self._order, self._lu = _superlu(K)

    @property
    def memory(self) -> int:
        """Bytes of the two factors, values and indices."""
        return 0 if self._lu is None else 12 * int(self._lu.L.nnz + self._lu.U.nnz)

    def solve(self, b: Array) -> Array:
        """Solutions (k, n) for right-hand sides in the rows of b (k, n)."""
        return self.solve_columns(b.T).T

    def solve_columns(self, b: Array) -> Array:
        """Solutions (n, k) for right-hand sides in the columns of b (n, k)."""
        if self._lu is None:
            return b
        x = np.empty_like(b)
        x[self._order] = self._lu.solve(np.ascontiguousarray(b[self._order]))
        return x


def _superlu(K: sp.csc_matrix) -> tuple[IntArray, Any]:
    """Fill-reducing order and SuperLU factor of a symmetric matrix (None where it is empty)."""
    if K.shape[0] == 0:
        return np.zeros(0, dtype=np.int64), None
    order = np.arange(K.shape[0])
    permc = "MMD_AT_PLUS_A"
    if importlib.util.find_spec("pymetis") is not None and K.shape[0] > 1000:
        import pymetis

        graph = K - sp.diags(K.diagonal())
        graph.eliminate_zeros()
        graph = graph.tocsr()
        order = np.asarray(pymetis.nested_dissection(pymetis.CSRAdjacency(graph.indptr, graph.indices))[0])
        K = K[order][:, order].tocsc()
        permc = "NATURAL"
    try:
        lu = spla.splu(K, permc_spec=permc, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:
        raise FecontactError(SINGULAR) from error
    return order, lu
