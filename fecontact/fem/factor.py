"""Static condensation behind one function: a sparse stiffness reduced to chosen degrees of freedom.

Partition the stiffness into retained (c) and other (i) degrees of freedom. The condensed stiffness is the Schur
complement (Elangovan 1978, eq. 3-4)

    K_hat = K_cc - K_ci K_ii^-1 K_ic,     f_hat = f_c - K_ci K_ii^-1 f_i,     u_i = K_ii^-1 (f_i - K_ic u_c).

PARDISO computes K_hat while it factorises, at no further cost, and keeps the factor of K_ii: the forward step alone
gives f_hat and the backward step alone, with u_c put in, gives u_i. SuperLU does the same with blocks of right-hand
sides. K must be positive definite: ground a floating body first (`fecontact.fem.support`).
"""

from __future__ import annotations

import ctypes
import importlib.util
import sys
from functools import cache
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from numpy.typing import NDArray

from fecontact.errors import FecontactError, MissingPackageError, SolverNotFoundError

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


class Condensed(Protocol):
    """A stiffness condensed to its retained degrees of freedom."""

    @property
    def stiffness(self) -> Array:
        """K_hat (n_c, n_c), symmetric."""

    def reduce(self, f: Array) -> Array:
        """Condensed loads f_hat (n_c, k) of loads f (n, k)."""

    def expand(self, u_c: Array, f: Array) -> Array:
        """All displacements u (n, k) from the retained ones u_c (n_c, k) and the loads f (n, k)."""


def available_backends() -> tuple[str, ...]:
    """Back-ends that can be used here, the fastest first."""
    return ("pardiso", "superlu") if importlib.util.find_spec("pypardiso") is not None else ("superlu",)


def condense(K: sp.csr_matrix, retained: IntArray, backend: str = "auto") -> Condensed:
    """Factorise the inner part of a stiffness and condense it onto `retained`.

    Parameters
    ----------
    K : (n, n) csr_matrix
        Upper triangle of a symmetric positive semi-definite matrix.
    retained : (n_c,) int array
        Distinct degrees of freedom to keep; at least one.
    backend : {'auto', 'pardiso', 'superlu'}

    Raises
    ------
    SolverNotFoundError
        If the back-end is unknown.
    MissingPackageError
        If it is not installed.
    FecontactError
        If the stiffness is singular: the body has a mechanism.

    Examples
    --------
    >>> import numpy as np, scipy.sparse as sp
    >>> K = sp.csr_matrix(np.triu([[2.0, -1, 0], [-1, 2, -1], [0, -1, 1]]))
    >>> condense(K, np.array([2]), "superlu").stiffness.round(12).tolist()
    [[0.333333333333]]
    """
    if backend not in ("auto", "pardiso", "superlu"):
        raise SolverNotFoundError(
            f"Unknown factorisation back-end {backend!r}; available here: auto, {', '.join(available_backends())}."
        )
    if backend == "auto":
        # PARDISO's nested dissection does not stand a matrix without any coupling: it may crash
        backend = available_backends()[0] if K.nnz > K.shape[0] else "superlu"
    if backend == "superlu":
        return _SuperLU(K, retained)
    if "pardiso" not in available_backends():
        raise MissingPackageError(
            "The back-end 'pardiso' needs the package pypardiso (x86-64 only): pip install pypardiso; "
            "or use backend='superlu'."
        )
    return _Pardiso(K, retained)


class _SuperLU:
    """SciPy's SuperLU, with METIS's nested dissection when pymetis is installed."""

    #: Right-hand sides solved at once; bounds the dense block at about n * 64 doubles.
    block = 64

    def __init__(self, K: sp.csr_matrix, retained: IntArray) -> None:
        n = K.shape[0]
        inner = np.ones(n, bool)
        inner[retained] = False
        self._c, self._i = retained, np.flatnonzero(inner)
        full = (K + sp.triu(K, 1).T).tocsc()
        columns = full[:, retained]
        self._ic = columns[self._i].tocsc()
        k_cc = columns[retained].toarray()
        self._order, self._lu = _superlu(full[:, self._i].tocsr()[self._i].tocsc())
        for start in range(0, len(retained), self.block):
            part = slice(start, start + self.block)
            k_cc[:, part] -= self._ic.T @ self._solve(self._ic[:, part].toarray())
        self.stiffness = (k_cc + k_cc.T) / 2

    def _solve(self, b: Array) -> Array:
        if self._lu is None:
            return b
        x = np.empty_like(b)
        x[self._order] = self._lu.solve(np.ascontiguousarray(b[self._order]))
        return x

    def reduce(self, f: Array) -> Array:
        return f[self._c] - self._ic.T @ self._solve(f[self._i])

    def expand(self, u_c: Array, f: Array) -> Array:
        u = np.empty_like(f)
        u[self._c] = u_c
        u[self._i] = self._solve(f[self._i] - self._ic @ u_c)
        return u


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


SINGULAR = (
    "The stiffness is singular: some part of the body hangs on nothing. Check that the mesh is connected and that no "
    "node is left unused."
)


@cache
def _mkl() -> Any:
    """MKL's runtime library, found by pypardiso."""
    from pypardiso import PyPardisoSolver

    # a handle of our own: pypardiso ties the argument types of its handle to its own calls
    return ctypes.CDLL(PyPardisoSolver().libmkl._name)


class _Pardiso:
    """MKL PARDISO: Cholesky factorisation with a Schur complement (iparm[35] = 2: return it and keep the factor)."""

    _mtype = 2

    def __init__(self, K: sp.csr_matrix, retained: IntArray) -> None:
        K.sort_indices()
        self._n, self._c = K.shape[0], retained
        self._pt = np.zeros(64, dtype=np.int64)
        self._iparm = np.zeros(64, dtype=np.int32)
        for position, value in {0: 1, 1: 2, 9: 8, 34: 1, 35: 2}.items():
            self._iparm[position] = value
        self._a = np.ascontiguousarray(K.data)
        self._ia = K.indptr.astype(np.int32)
        self._ja = K.indices.astype(np.int32)
        marks = np.zeros(self._n, dtype=np.int32)
        marks[retained] = 1
        self._perm = marks
        # PARDISO returns K_hat with rows in increasing order of their degree of freedom
        rank = np.empty(len(retained), dtype=np.int64)
        rank[np.argsort(retained)] = np.arange(len(retained))
        schur = np.zeros((len(retained), len(retained)))
        self._call(12, np.zeros(self._n), schur)
        self.stiffness = np.ascontiguousarray(schur[np.ix_(rank, rank)])

    def _call(self, phase: int, b: Array, x: Array, n_rhs: int = 1) -> None:
        def pointer(array: NDArray[Any]) -> Any:
            return array.ctypes.data_as(ctypes.c_void_p)

        def integer(value: int) -> Any:
            return ctypes.byref(ctypes.c_int32(value))

        error = ctypes.c_int32(0)
        _mkl().pardiso(
            pointer(self._pt), integer(1), integer(1), integer(self._mtype), integer(phase), integer(self._n),
            pointer(self._a), pointer(self._ia), pointer(self._ja), pointer(self._perm), integer(n_rhs),
            pointer(self._iparm), integer(0), pointer(b), pointer(x), ctypes.byref(error),
        )  # fmt: skip
        if error.value == -2:
            raise FecontactError(
                f"PARDISO ran out of memory for {self._n} degrees of freedom; use a coarser mesh away from the "
                "contact or model less of the scene."
            )
        if error.value != 0:
            raise FecontactError(f"PARDISO failed in phase {phase} with error {error.value}. {SINGULAR}")

    def reduce(self, f: Array) -> Array:
        return self._forward(f)[self._c]

    def expand(self, u_c: Array, f: Array) -> Array:
        y = np.ascontiguousarray(self._forward(f).T)
        y[:, self._c] = u_c.T
        self._call(333, y, x := np.zeros_like(y), len(y))
        return np.ascontiguousarray(x.T)

    def _forward(self, f: Array) -> Array:
        if not np.delete(f, self._c, axis=0).any():
            return f  # elimination of the inner unknowns has nothing to carry over
        b = np.ascontiguousarray(f.T, dtype=float)
        self._call(331, b, x := np.zeros_like(b), b.shape[0])
        return x.T

    def _release(self) -> None:
        self._call(-1, np.zeros(self._n), np.zeros(self._n))

    def __del__(self) -> None:
        if not sys.is_finalizing() and getattr(self, "_pt", None) is not None and self._pt.any():
            self._release()
            self._pt[:] = 0
