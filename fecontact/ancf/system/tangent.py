"""Tangent of the free coordinates and its factor: a Cholesky factor, or an LU factor of one that is not symmetric.

**Band**: a chain of bricks or beams has a bandwidth of two sections in the order of Cuthill & McKee, so that LAPACK's
band factor (pbtrf) costs n w^2 operations and none of the bookkeeping of a sparse one. Order and places depend on the
pattern only and are found once. Source: E. Cuthill & J. McKee, Reducing the bandwidth of sparse symmetric matrices,
Proc. 24th ACM National Conference (1969). **Condensed** onto the coordinates in the conditions, where the band is wide;
**dense** where there are few coordinates. **LU** for loads without a potential: their stability has no energy to be
judged by. A real eigenvalue that becomes negative, a buckling, changes the sign of the determinant; flutter is not
noticed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.sparse.csgraph import connected_components, reverse_cuthill_mckee

from fecontact.ancf.bricks.tangents import with_data
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import FecontactError
from fecontact.fem.factor import condense

#: Operations of a factor above which a sparse one is faster.
MAX_OPERATIONS = 2e8
#: Products per entry of a matrix above which it is reduced by matrix products.
MAX_ENTRIES = 16
#: Coordinates up to which a dense factor is faster than a sparse one.
SMALL = 300
#: Largest difference from the transpose, relative to the largest entry, that is rounding.
SYMMETRIC = 1e-12


class UnstableError(FecontactError):
    """The tangent is not positive definite: the state is not a stable one, or the step was too long."""

    code = "unstable"


class Responses(NamedTuple):
    """Displacements by loads.

    Attributes
    ----------
    touched : (t,) int array
        Coordinates at which they are known.
    u : (t,) array
        By the residual forces.
    X : (t, k) array
        By unit forces along k rows.
    every : callable
        All displacements (n,) by the residual forces and forces (k,) along the rows.
    """

    touched: IntArray
    u: Array
    X: Array
    every: Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Tangent:
    """Tangent of the free coordinates.

    Parameters
    ----------
    K : (n, n) csr_matrix
    order : BandOrder, optional
        Of its pattern, where its band is narrow.
    symmetric : bool

    Examples
    --------
    >>> K = Tangent(sp.csr_matrix([[2.0, 1.0], [0.0, 1.0]]), symmetric=False)
    >>> K.solve(np.array([4.0, 2.0])).tolist()
    [1.0, 2.0]
    """

    K: sp.csr_matrix
    order: BandOrder | None = None
    symmetric: bool = True

    def plus(self, more: sp.csr_matrix) -> Tangent:
        """The sum of it and another matrix."""
        return Tangent(sp.csr_matrix(self.K + more))

    @cached_property
    def solve(self) -> Callable[[Array], Array]:
        """K^-1 b for right-hand sides b (n, k).

        Raises
        ------
        UnstableError
            If K is not positive definite; one that is not symmetric, if det K <= 0.
        """
        if not self.symmetric:
            return _lu(self.K).solve
        try:
            if self.order is not None:
                return self.order.factor(self.K.data).solve
            factor = scipy.linalg.cho_factor(self.K.toarray(), lower=True, check_finite=False)
        except np.linalg.LinAlgError as error:
            raise UnstableError("The tangent stiffness is not positive definite.") from error
        return lambda b: np.asarray(scipy.linalg.cho_solve(factor, b, check_finite=False))

    def responses(self, r: Array, rows: sp.csr_matrix) -> Responses:
        """Displacements by residual forces r (n,) and by unit forces along rows (k, n).

        Raises
        ------
        UnstableError
            As `solve`.
        """
        if self.order is None and self.symmetric and len(r) > SMALL:
            return self._condensed(r, rows)
        both = self.solve(np.column_stack([r, rows.T.toarray()]))
        u, X = both[:, 0], both[:, 1:]
        return Responses(np.arange(len(r)), u, X, lambda forces: u + X @ forces)

    def _condensed(self, r: Array, rows: sp.csr_matrix) -> Responses:
        if not (self.K.diagonal() > 0).all():
            raise UnstableError("The tangent stiffness has a diagonal entry that is not positive.")
        touched = np.unique(rows.indices).astype(np.int64) if rows.nnz else np.zeros(1, dtype=np.int64)
        try:
            condensed = condense(sp.csr_matrix(sp.triu(self.K)), touched)
            factor = scipy.linalg.cho_factor(condensed.stiffness, lower=True)
        except (FecontactError, np.linalg.LinAlgError) as error:
            raise UnstableError("The tangent stiffness is not positive definite.") from error
        u = scipy.linalg.cho_solve(factor, condensed.reduce(r[:, None]))
        X = scipy.linalg.cho_solve(factor, rows[:, touched].toarray().T)
        return Responses(
            touched, u[:, 0], X, lambda forces: condensed.expand(u + X @ forces[:, None], r[:, None])[:, 0]
        )


def is_symmetric(K: sp.csr_matrix) -> bool:
    """Whether K is symmetric but for rounding."""
    return bool(abs(K - K.T).max() <= SYMMETRIC * abs(K).max())


def _lu(K: sp.csr_matrix) -> spla.SuperLU:
    """Factor of a matrix with a positive determinant."""
    try:
        factor = spla.splu(sp.csc_matrix(K))
    except RuntimeError as error:
        raise UnstableError("The tangent stiffness is singular.") from error
    negative = np.count_nonzero(factor.U.diagonal() < 0) + _swaps(factor.perm_r) + _swaps(factor.perm_c)
    if negative % 2:
        raise UnstableError("The tangent stiffness has a negative determinant.")
    return factor


def _swaps(order: IntArray) -> int:
    """Number of exchanges that make up a permutation: its length less the number of its cycles."""
    n = len(order)
    cycles = sp.csr_matrix((np.ones(n), (np.arange(n), order)), shape=(n, n))
    return int(n - connected_components(cycles, directed=False)[0])


@dataclass(frozen=True, eq=False)
class BandOrder:
    """Places of a symmetric pattern's lower triangle in a band.

    Attributes
    ----------
    order : (n,) int array
        Old numbers by new ones.
    width : int
        Diagonals below the main one.
    source : (k,) int array
        Entries of the pattern that lie in the lower triangle of the new order.
    place : (k,) int array
        Their places in the band (width + 1, n), flattened.
    """

    order: IntArray
    width: int
    source: IntArray
    place: IntArray

    @classmethod
    def of(cls, K: sp.csr_matrix) -> BandOrder | None:
        """Order of a pattern; None where the band is too wide.

        Examples
        --------
        >>> K = sp.csr_matrix([[2.0, 0.0, 1.0], [0.0, 2.0, 1.0], [1.0, 1.0, 2.0]])
        >>> BandOrder.of(K).width
        1
        """
        n = K.shape[0]
        if n == 0:
            return None
        order = reverse_cuthill_mckee(K, symmetric_mode=True)
        new = np.empty(n, dtype=np.int64)
        new[order] = np.arange(n)
        row, column = new[np.repeat(np.arange(n), np.diff(K.indptr))], new[K.indices]
        width = int((row - column).max())
        if n * (width + 1.0) ** 2 > MAX_OPERATIONS:
            return None
        source = np.flatnonzero(row >= column)
        return cls(order, width, source, (row - column)[source] * n + column[source])

    def factor(self, data: Array) -> BandFactor:
        """Factor of the matrix with entries `data` in the pattern's order.

        Raises
        ------
        numpy.linalg.LinAlgError
            If it is not positive definite.
        """
        band = np.zeros((self.width + 1, len(self.order)))
        band.ravel()[self.place] = data[self.source]
        return BandFactor(self.order, scipy.linalg.cholesky_banded(band, True, True, check_finite=False))


@dataclass(frozen=True, eq=False)
class BandFactor:
    """Cholesky factor of a band.

    Examples
    --------
    >>> K = sp.csr_matrix([[2.0, 0.0, 1.0], [0.0, 2.0, 1.0], [1.0, 1.0, 2.0]])
    >>> BandOrder.of(K).factor(K.data).solve(np.array([[3.0], [3.0], [4.0]])).ravel().round(12).tolist()
    [1.0, 1.0, 1.0]
    """

    order: IntArray
    band: Array

    def solve(self, b: Array) -> Array:
        """K^-1 b for right-hand sides in the columns of b (n, k)."""
        x = np.empty_like(b)
        x[self.order] = scipy.linalg.cho_solve_banded((self.band, True), b[self.order], check_finite=False)
        return x


@dataclass(frozen=True, eq=False)
class Reduction:
    """Z^T K Z for all K of one pattern, as one product with their entries.

    Attributes
    ----------
    entries : (k, nnz) csr_matrix
        Entries of Z^T K Z from those of K.
    pattern : (n_free, n_free) csr_matrix
        Pattern of Z^T K Z, all ones.
    order : BandOrder or None
    """

    entries: sp.csr_matrix
    pattern: sp.csr_matrix
    order: BandOrder | None

    @classmethod
    def of(cls, K: sp.csr_matrix, Z: sp.csr_matrix) -> Reduction | None:
        """Reduction of a pattern; None where too many coordinates are tied to the same ones.

        Examples
        --------
        >>> K, Z = sp.csr_matrix([[2.0, -1.0], [-1.0, 3.0]]), sp.csr_matrix([[0.6], [0.8]])
        >>> Reduction.of(K, Z)(K).K.toarray().round(12).tolist()
        [[1.68]]
        """
        n, free = Z.shape
        counts = np.diff(Z.indptr)
        row = np.repeat(np.arange(n), np.diff(K.indptr))
        # every entry K_ab meets all entries Z_ai and Z_bj
        many = counts[row] * counts[K.indices]
        if many.sum() > MAX_ENTRIES * K.nnz:
            return None
        entry = np.repeat(np.arange(K.nnz), many)
        each = np.arange(len(entry)) - np.repeat(np.cumsum(many) - many, many)
        left, right = np.divmod(each, counts[K.indices[entry]])
        left, right = Z.indptr[row[entry]] + left, Z.indptr[K.indices[entry]] + right
        keys = Z.indices[left].astype(np.int64) * free + Z.indices[right]
        found, place = np.unique(keys, return_inverse=True)
        entries = sp.csr_matrix((Z.data[left] * Z.data[right], (place.ravel(), entry)), shape=(len(found), K.nnz))
        rows, columns = np.divmod(found, max(free, 1))
        pointer = np.searchsorted(rows, np.arange(free + 1))
        pattern = sp.csr_matrix((np.ones(len(found)), columns, pointer), shape=(free, free))
        return cls(entries, pattern, BandOrder.of(pattern))

    def __call__(self, K: sp.csr_matrix) -> Tangent:
        """Z^T K Z, with explicit zeros where the pattern has entries."""
        return Tangent(with_data(self.pattern, self.entries @ K.data), self.order)
