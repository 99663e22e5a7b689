"""MKL PARDISO for symmetric matrices: plain factor, factor with a Schur complement, factor of a bordered matrix.

pypardiso's solver is for unsymmetric matrices only. Here the library that it finds is called with the symmetric type, a
triangle of the matrix, and the phases of a condensation.
"""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import FecontactError
from fecontact.fem.stiffness import symmetric_product

ZERO_PIVOT = -4
SINGULAR = (
    "The stiffness is singular: some part of the body is loose. Check that the mesh is connected and that no "
    "node is left unused."
)

#: Matrix types, one triangle given: symmetric positive definite, and indefinite.
_DEFINITE, _INDEFINITE = 2, -2
#: Largest residual, relative to the load, of a solution with a factor some of whose pivots were replaced, see
#: `PardisoBordered`: beside the rounding of products with K, which a steeply graded mesh that floats makes large. Where
#: they belong to the border, 1e-9 and this rounding (up to 1e-3) are found; where the stiffness is singular, 1.
RESIDUAL, ROUNDING, SURELY_SINGULAR = 1e-6, 30 * float(np.finfo(float).eps), 0.1


#: Degrees of freedom below which minimum degree orders a plain factor sooner than nested dissection: 1,659 of 20-node
#: hexahedra in 9 ms of 20, 3,027 in 22 of 24, 5,700 in 73 of 65.
SMALL = 4000


@cache
def _mkl() -> Any:
    """MKL's runtime library."""
    if "PYPARDISO_MKL_RT" not in os.environ:
        # where pip and conda install it; pypardiso searches the whole environment, which takes most of a second
        for folder in (Path(sys.prefix) / "lib", Path(sys.prefix) / "Library" / "bin"):
            for path in [*folder.glob("libmkl_rt.so*"), *folder.glob("libmkl_rt*.dylib"), *folder.glob("mkl_rt*.dll")]:
                return ctypes.CDLL(str(path))
    from pypardiso import PyPardisoSolver

    # a separate handle: pypardiso sets the argument types of its own one
    return ctypes.CDLL(PyPardisoSolver().libmkl._name)


class _Handle:
    """PARDISO's memory for one matrix, released with the object."""

    def __init__(
        self, K: sp.csr_matrix, settings: dict[int, int], perm: NDArray[np.int32], kind: int = _DEFINITE
    ) -> None:
        K.sort_indices()
        self.n, self._kind = K.shape[0], kind
        self._pt = np.zeros(64, dtype=np.int64)
        self._iparm = np.zeros(64, dtype=np.int32)
        for position, value in {0: 1, 1: 2, 9: 8, 34: 1, **settings}.items():
            self._iparm[position] = value
        self._a = np.ascontiguousarray(K.data)
        self._ia = K.indptr.astype(np.int32, copy=False)
        self._ja = K.indices.astype(np.int32, copy=False)
        self._perm = perm

    @property
    def n_replaced(self) -> int:
        """Pivots of an indefinite matrix that were too small and replaced."""
        return int(self._iparm[13])

    @property
    def memory(self) -> int:
        """Peak bytes of PARDISO: the larger of the analysis' peak and the factor with its permanent data."""
        peak, permanent, factor = (int(k) for k in self._iparm[14:17])
        return 1024 * max(peak, permanent + factor)

    def call(self, phase: int, b: Array, x: Array, n_rhs: int = 1) -> None:
        """Call PARDISO with right-hand sides in the rows of b (n_rhs, n)."""

        def pointer(array: NDArray[Any]) -> Any:
            return array.ctypes.data_as(ctypes.c_void_p)

        def integer(value: int) -> Any:
            return ctypes.byref(ctypes.c_int32(value))

        error = ctypes.c_int32(0)
        _mkl().pardiso(
            pointer(self._pt), integer(1), integer(1), integer(self._kind), integer(phase), integer(self.n),
            pointer(self._a), pointer(self._ia), pointer(self._ja), pointer(self._perm), integer(n_rhs),
            pointer(self._iparm), integer(0), pointer(b), pointer(x), ctypes.byref(error),
        )  # fmt: skip
        if error.value == -2:
            raise FecontactError(
                f"PARDISO ran out of memory for {self.n} degrees of freedom; use backend='amg', a coarser mesh away "
                "from the contact, or model less of the scene."
            )
        if error.value != 0:
            message = f"PARDISO failed in phase {phase} with error {error.value}. {SINGULAR}"
            raise FecontactError(message, code="singular" if error.value == ZERO_PIVOT else None)

    def __reduce__(self) -> NoReturn:
        raise TypeError("A factor of PARDISO cannot be copied or sent: it is memory of the library.")

    def __del__(self) -> None:
        if not sys.is_finalizing() and getattr(self, "_pt", None) is not None and self._pt.any():
            self.call(-1, np.zeros(self.n), np.zeros(self.n))
            self._pt[:] = 0


class _Pardiso:
    """What PARDISO keeps."""

    _handle: _Handle

    @property
    def memory(self) -> int:
        """Bytes of the factorisation."""
        return self._handle.memory


class PardisoFactor(_Pardiso):
    """Cholesky factor of a whole stiffness."""

    def __init__(self, K: sp.csr_matrix) -> None:
        order = {1: 0} if K.shape[0] < SMALL else {}
        self._handle = _Handle(K, order, np.zeros(K.shape[0], dtype=np.int32))
        self._handle.call(12, np.zeros(K.shape[0]), np.zeros(K.shape[0]))

    def solve(self, b: Array) -> Array:
        """Solutions (k, n) for right-hand sides in the rows of b (k, n)."""
        b = np.ascontiguousarray(b, dtype=float)
        self._handle.call(33, b, x := np.empty_like(b), len(b))
        return x


class PardisoSchur(_Pardiso):
    """Cholesky factorisation with a Schur complement (iparm[35] = 2: return it and keep the factor)."""

    def __init__(self, K: sp.csr_matrix, retained: IntArray) -> None:
        marks = np.zeros(K.shape[0], dtype=np.int32)
        marks[retained] = 1
        self._c = retained
        self._handle = _Handle(K, {35: 2}, marks)
        schur = np.zeros((len(retained), len(retained)))
        self._handle.call(12, np.zeros(K.shape[0]), schur)
        if (np.diff(retained) > 0).all():
            self.stiffness = schur
        else:
            # PARDISO returns the rows of K_hat in increasing order of the degree of freedom
            rank = np.empty(len(retained), dtype=np.int64)
            rank[np.argsort(retained)] = np.arange(len(retained))
            self.stiffness = np.ascontiguousarray(schur[np.ix_(rank, rank)])

    def reduce(self, f: Array) -> Array:
        """Condensed loads (n_c, k) of loads f (n, k)."""
        return self._forward(f)[self._c]

    def expand(self, u_c: Array, f: Array) -> Array:
        """All displacements (n, k) from the retained ones and the loads."""
        y = np.ascontiguousarray(self._forward(f).T)
        y[:, self._c] = u_c.T
        self._handle.call(333, y, x := np.zeros_like(y), len(y))
        return np.ascontiguousarray(x.T)

    def _forward(self, f: Array) -> Array:
        if not np.delete(f, self._c, axis=0).any():
            return f  # no inner unknowns to eliminate
        b = np.ascontiguousarray(f.T, dtype=float)
        self._handle.call(331, b, x := np.zeros_like(b), b.shape[0])
        return x.T


class PardisoBordered(_Pardiso):
    """Factor of a stiffness K with a border of rows C, and the compliance S = C K^-1 C^T.

    The Schur complement of [[K, C^T], [C, 0]] on the border is -S. PARDISO computes it with the factor of K, by dense
    block operations on the few unknowns that each row reaches; it takes a fraction of the time of solving for the
    columns one by one. The bordered matrix is indefinite, its part K positive definite: pivots stay on the diagonal.

    Parameters
    ----------
    K : (n, n) csr_matrix
        Upper triangle of a symmetric positive definite matrix.
    C : (n_rows, n) csr_matrix
        Not zero.

    Raises
    ------
    FecontactError
        If K is singular.
    """

    def __init__(self, K: sp.csr_matrix, C: sp.csr_matrix) -> None:
        n, m = K.shape[0], C.shape[0]
        # pivots are compared with the largest entry: rows as large as K, in any units
        scale = float(np.abs(K.data).max() / np.abs(C.data).max())
        stiff, rows, border = K.tocoo(), C.tocoo(), np.arange(n, n + m)
        ends = (np.concatenate([stiff.row, rows.col, border]), np.concatenate([stiff.col, n + rows.row, border]))
        data = np.concatenate([stiff.data, scale * rows.data, np.zeros(m)])
        marks = np.zeros(n + m, dtype=np.int32)
        marks[n:] = 1
        self._n = n
        self._handle = _Handle(sp.csr_matrix((data, ends), shape=(n + m, n + m)), {9: 13, 35: 2}, marks, _INDEFINITE)
        self.compliance = np.zeros((m, m))
        self._handle.call(12, np.zeros(n + m), self.compliance)
        self.compliance /= -(scale**2)
        # dependent rows leave small pivots in the border, which is not solved for; a singular K leaves them in K
        if self._handle.n_replaced and not self._solves(K):
            raise FecontactError(SINGULAR, code="singular")

    def _solves(self, K: sp.csr_matrix) -> bool:
        """Whether the solution under random loads of size one fulfils K x = f, up to rounding."""
        f = np.random.default_rng(0).uniform(0.5, 1.5, self._n)
        x = self.solve(f[None])[0]
        residual = np.abs(symmetric_product(K, x) - f).max()
        allowed = RESIDUAL + ROUNDING * np.abs(K.data).max() * np.abs(x).max()
        return bool(residual <= min(allowed, SURELY_SINGULAR))

    def solve(self, b: Array) -> Array:
        """Solutions (k, n) of K x = b for right-hand sides in the rows of b (k, n)."""
        x = np.zeros((len(b), self._handle.n))
        x[:, : self._n] = b
        for phase in (331, 332, 333):
            x[:, self._n :] = 0.0
            given, x = x, np.zeros_like(x)
            self._handle.call(phase, given, x, len(b))
        return np.ascontiguousarray(x[:, : self._n])
