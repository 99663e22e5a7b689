"""Factorisation and static condensation of a sparse stiffness, by any available back-end.

Partition the stiffness into retained (c) and other (i) degrees of freedom. The condensed stiffness is the Schur
complement (Elangovan 1978, eq. 3-4)

    K_hat = K_cc - K_ci K_ii^-1 K_ic,     f_hat = f_c - K_ci K_ii^-1 f_i,     u_i = K_ii^-1 (f_i - K_ic u_c).

PARDISO computes K_hat during the factorisation, at no further cost, and keeps the factor of K_ii: the forward step
gives f_hat, the backward step with given u_c gives u_i. rslab and SuperLU do the same with blocks of right-hand sides.
K must be positive definite: fix the null space of a floating body first (`fecontact.fem.support`).
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import Protocol

import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MissingPackageError, SolverNotFoundError
from fecontact.fem.column_schur import ColumnSchur, WholeFactor, symmetric
from fecontact.fem.ldlt import LdltFactor
from fecontact.fem.pardiso import PardisoBordered, PardisoFactor, PardisoSchur
from fecontact.fem.superlu import SuperLUFactor

DIRECT = ("pardiso", "rslab", "superlu")
#: Package of each back-end that needs one.
PACKAGES = {"pardiso": "pypardiso", "rslab": "rslab"}


class Condensed(Protocol):
    """A stiffness condensed to its retained degrees of freedom."""

    @property
    def stiffness(self) -> Array:
        """K_hat (n_c, n_c), symmetric."""

    @property
    def memory(self) -> int:
        """Bytes of the factorisation."""

    def reduce(self, f: Array) -> Array:
        """Condensed loads f_hat (n_c, k) of loads f (n, k)."""

    def expand(self, u_c: Array, f: Array) -> Array:
        """All displacements u (n, k) from the retained ones u_c (n_c, k) and the loads f (n, k)."""


class Factor(Protocol):
    """Factor of a stiffness."""

    @property
    def memory(self) -> int:
        """Bytes of the factor."""

    def solve(self, b: Array) -> Array:
        """Solutions (k, n) for right-hand sides in the rows of b (k, n)."""


class BorderedFactor(Factor, Protocol):
    """Factor of a stiffness K with a border of rows C."""

    @property
    def compliance(self) -> Array:
        """C K^-1 C^T (n_rows, n_rows), symmetric."""


#: Factors of full symmetric matrices.
_WHOLE: dict[str, Callable[[sp.csc_matrix], WholeFactor]] = {"rslab": LdltFactor, "superlu": SuperLUFactor}
#: Below this size, or for diagonal matrices, PARDISO's nested dissection may crash; SuperLU is used instead.
SMALLEST = 64


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


def has_bordered(backend: str = "auto") -> bool:
    """Whether a back-end has `bordered`."""
    return backend in ("auto", "pardiso") and "pardiso" in available_backends()


def bordered(K: sp.csr_matrix, C: sp.csr_matrix) -> BorderedFactor | None:
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
