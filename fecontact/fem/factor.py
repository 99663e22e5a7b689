"""Factorisation and static condensation of a sparse stiffness, by any available back-end.

Partition the stiffness into retained (c) and other (i) degrees of freedom. The condensed stiffness is the Schur
complement (Elangovan 1978, eq. 3-4)

    K_hat = K_cc - K_ci K_ii^-1 K_ic,     f_hat = f_c - K_ci K_ii^-1 f_i,     u_i = K_ii^-1 (f_i - K_ic u_c).

PARDISO computes K_hat during the factorisation, at no further cost, and keeps the factor of K_ii: the forward step
gives f_hat, the backward step with given u_c gives u_i. rslab and SuperLU do the same with blocks of right-hand sides.
K must be positive definite: fix the null space of a floating body first (`fecontact.fem.support`).

LDL^T factorisation by rslab, a small library with wheels for every platform; used when PARDISO is not installed.

SciPy's SuperLU, with METIS's nested dissection when pymetis is installed; used when no other library is.

Static condensation by columns, for factorisations that have no Schur complement of their own.
"""

from __future__ import annotations

import importlib.util
import os
from abc import abstractmethod
from functools import cache
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import FecontactError, MissingPackageError, SolverNotFoundError
from fecontact.fem.pardiso import SINGULAR, PardisoBordered, PardisoFactor, PardisoSchur


class WholeFactor:
    """Factor of a whole stiffness, given as a full symmetric matrix (an empty one is allowed)."""

    @property
    @abstractmethod
    def memory(self) -> int:
        """Bytes of the factor."""

    @abstractmethod
    def solve_columns(self, b: Array) -> Array:
        """Solutions (n, k) for right-hand sides in the columns of b (n, k)."""

    def solve(self, b: Array) -> Array:
        """Solutions (k, n) for right-hand sides in the rows of b (k, n)."""
        return self.solve_columns(b.T).T


class LdltFactor(WholeFactor):
    """By rslab.

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
            raise FecontactError(f"{SINGULAR} ({error})", code="singular") from error
        if self._factor.inertia[0] < K.shape[0] or self._factor.n_perturbed:
            raise FecontactError(SINGULAR, code="singular")

    @property
    def memory(self) -> int:
        """Bytes of the factor's values; the indices of its supernodes are few."""
        return 0 if self._factor is None else 8 * int(self._factor.factor_nnz)

    def solve_columns(self, b: Array) -> Array:
        """Solutions (n, k) for right-hand sides in the columns of b (n, k)."""
        if b.size == 0:
            return b
        return np.asarray(self._factor.solve_many(np.ascontiguousarray(b)))


class SuperLUFactor(WholeFactor):
    """By SuperLU."""

    def __init__(self, K: sp.csc_matrix) -> None:
        self._order, self._lu = _superlu(K)

    @property
    def memory(self) -> int:
        """Bytes of the two factors, values and indices."""
        return 0 if self._lu is None else 12 * int(self._lu.L.nnz + self._lu.U.nnz)

    @property
    def is_positive(self) -> bool:
        """Whether all pivots are positive, which stay on the diagonal of a definite matrix."""
        lu = self._lu
        return lu is None or bool((lu.perm_r == lu.perm_c).all() and (lu.U.diagonal() > 0).all())

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
        raise FecontactError(SINGULAR, code="singular") from error
    return order, lu


class ColumnSchur:
    """Schur complement by blocks of right-hand sides, with any factor of the inner part."""

    #: Right-hand sides solved at once; bounds the dense block at about n * 64 doubles.
    block = 64

    def __init__(self, K: sp.csr_matrix, retained: IntArray, factor: type[LdltFactor | SuperLUFactor]) -> None:
        self._c, self._i = retained, np.setdiff1d(np.arange(K.shape[0]), retained)
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


DIRECT = ("pardiso", "rslab", "superlu")
#: Package of each back-end that needs one.
PACKAGES = {"pardiso": "pypardiso", "rslab": "rslab"}


class Factor(Protocol):
    """Factor of a stiffness."""

    @property
    def memory(self) -> int:
        """Bytes of the factor."""

    def solve(self, b: Array) -> Array:
        """Solutions (k, n) for right-hand sides in the rows of b (k, n)."""


#: A stiffness condensed to its retained degrees of freedom.
Condensed = PardisoSchur | ColumnSchur
#: Factors of full symmetric matrices.
_WHOLE: dict[str, type[LdltFactor | SuperLUFactor]] = {"rslab": LdltFactor, "superlu": SuperLUFactor}
#: Below this size, or for diagonal matrices, PARDISO's nested dissection may crash; SuperLU is used instead.
SMALLEST = 64


@cache
def available_backends() -> tuple[str, ...]:
    """Available direct back-ends, the fastest first."""
    return tuple(b for b in DIRECT if b not in PACKAGES or importlib.util.find_spec(PACKAGES[b]) is not None)


def _chosen(backend: str, K: sp.csr_matrix) -> str:
    if backend not in ("auto", *DIRECT):
        raise SolverNotFoundError(
            f"Unknown factorisation back-end {backend!r}; available here: auto, "
            f"{', '.join(available_backends())}; and amg for elastic bodies."
        )
    if backend == "auto":
        backend = available_backends()[0]
    if backend not in available_backends():
        raise MissingPackageError(
            f"The back-end {backend!r} needs the package {PACKAGES[backend]}: pip install {PACKAGES[backend]}"
            f"{' (x86-64 only)' if backend == 'pardiso' else ''}; or use backend='superlu'."
        )
    return "superlu" if K.shape[0] < SMALLEST or K.nnz <= K.shape[0] else backend


def condense(K: sp.csr_matrix, retained: IntArray, backend: str = "auto") -> Condensed:
    """Factorise the inner part of a stiffness and condense it onto `retained`.

    Parameters
    ----------
    K : (n, n) csr_matrix
        Upper triangle of a symmetric positive semi-definite matrix.
    retained : (n_c,) int array
        Distinct degrees of freedom to keep; at least one.
    backend : {'auto', 'pardiso', 'rslab', 'superlu'}

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
    # PARDISO can crash where nothing is left to eliminate
    chosen = _chosen(backend, K) if len(retained) < K.shape[0] else "superlu"
    return PardisoSchur(K, retained) if chosen == "pardiso" else ColumnSchur(K, retained, _WHOLE[chosen])


def factorise(K: sp.csr_matrix, backend: str = "auto") -> Factor:
    """Factorise a whole stiffness.

    Parameters
    ----------
    K : (n, n) csr_matrix
        Upper triangle of a symmetric positive definite matrix.
    backend : {'auto', 'pardiso', 'rslab', 'superlu'}

    Raises
    ------
    SolverNotFoundError, MissingPackageError, FecontactError
        As `condense`.

    Examples
    --------
    >>> import numpy as np, scipy.sparse as sp
    >>> K = sp.csr_matrix(np.triu([[2.0, -1], [-1, 2]]))
    >>> factorise(K, "superlu").solve(np.array([[1.0, 1.0]])).round(12).tolist()
    [[1.0, 1.0]]
    """
    chosen = _chosen(backend, K)
    return PardisoFactor(K) if chosen == "pardiso" else _WHOLE[chosen](symmetric(K))


def is_definite(K: sp.csr_matrix) -> bool:
    """Whether a matrix, given by its upper triangle, is positive definite.

    Examples
    --------
    >>> K = sp.csr_matrix(np.triu([[2.0, -1], [-1, 2]]))
    >>> is_definite(K), is_definite(K - 1.5 * sp.eye(2))
    (True, False)
    """
    try:
        factor = factorise(K)
    except FecontactError as error:
        if error.code != "singular":
            raise
        return False
    return not isinstance(factor, SuperLUFactor) or factor.is_positive


def has_bordered(backend: str = "auto") -> bool:
    """Whether a back-end has `bordered`."""
    return backend in ("auto", "pardiso") and "pardiso" in available_backends()


def bordered(K: sp.csr_matrix, C: sp.csr_matrix) -> PardisoBordered | None:
    """Factorise a whole stiffness together with the compliance of given rows, by PARDISO; None for tiny matrices.

    Parameters
    ----------
    K : (n, n) csr_matrix
        Upper triangle of a symmetric positive definite matrix.
    C : (n_rows, n) csr_matrix

    Raises
    ------
    FecontactError
        If the stiffness is singular.

    Examples
    --------
    >>> import numpy as np
    >>> K, C = sp.diags([2.0 * np.ones(80), -np.ones(79)], [0, 1]).tocsr(), sp.eye(1, 80).tocsr()
    >>> found = bordered(K, C) if has_bordered() else None
    >>> found is None or bool(abs(found.compliance[0, 0] - 80 / 81) < 1e-12)
    True
    """
    return PardisoBordered(K, C) if _chosen("auto", K) == "pardiso" and C.count_nonzero() else None
