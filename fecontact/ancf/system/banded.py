"""Cholesky factor of a narrow band: slender and small bodies in the order of Cuthill & McKee.

A chain of bricks or beams has a bandwidth of two sections, so that LAPACK's band factor (pbtrf) costs n w^2 operations
and none of the bookkeeping of a sparse one. Order and places depend on the pattern only and are found once. Source: E.
Cuthill & J. McKee, Reducing the bandwidth of sparse symmetric matrices, Proc. 24th ACM National Conference (1969).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from scipy.sparse.csgraph import reverse_cuthill_mckee

from fecontact.ancf.bricks.tangents import with_data
from fecontact.common.arrays import Array, IntArray

#: Operations of a factor above which a sparse one is faster.
MOST_OPERATIONS = 2e8
#: Products per entry of a matrix above which it is reduced by matrix products.
MOST_ENTRIES = 16


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
        if n * (width + 1.0) ** 2 > MOST_OPERATIONS:
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
        >>> Reduction.of(K, Z)(K).toarray().round(12).tolist()
        [[1.68]]
        """
        n, free = Z.shape
        counts = np.diff(Z.indptr)
        row = np.repeat(np.arange(n), np.diff(K.indptr))
        # every entry K_ab meets all entries Z_ai and Z_bj
        many = counts[row] * counts[K.indices]
        if many.sum() > MOST_ENTRIES * K.nnz:
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

    def __call__(self, K: sp.csr_matrix) -> sp.csr_matrix:
        """Z^T K Z, with explicit zeros where the pattern has entries."""
        return with_data(self.pattern, self.entries @ K.data)
