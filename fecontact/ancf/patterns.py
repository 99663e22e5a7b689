"""Sums of matrices in the pattern of one of them: places found once, no bookkeeping of sparse sums."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray


def has_pattern(K: sp.csr_matrix, indices: IntArray, indptr: IntArray) -> bool:
    """Whether a matrix has a pattern."""
    return K.indices is indices or (np.array_equal(K.indptr, indptr) and np.array_equal(K.indices, indices))


def with_data(K: sp.csr_matrix, data: Array) -> sp.csr_matrix:
    """A matrix with the pattern of K and other entries."""
    return sp.csr_matrix((data, K.indices, K.indptr), shape=K.shape, copy=False)


@dataclass(frozen=True, eq=False)
class Places:
    """Where the entries of other matrices lie in a pattern.

    Attributes
    ----------
    indices, indptr : int arrays
        The pattern.
    keys : (nnz,) int array
        Row n + column of its entries, increasing.
    order : (nnz,) int array
        Their places in the pattern.

    Examples
    --------
    >>> K = sp.csr_matrix([[2.0, 1.0], [0.0, 3.0]])
    >>> places = Places.of(K)
    >>> places.entries(sp.csr_matrix([[0.0, 5.0], [0.0, 6.0]])).tolist()
    [0.0, 5.0, 6.0]
    >>> places.entries(sp.csr_matrix([[0.0, 0.0], [7.0, 0.0]])) is None
    True
    """

    indices: IntArray
    indptr: IntArray
    keys: IntArray
    order: IntArray

    @classmethod
    def of(cls, K: sp.csr_matrix) -> Places:
        """Places in the pattern of a matrix."""
        keys = np.repeat(np.arange(K.shape[0]), np.diff(K.indptr)) * K.shape[1] + K.indices
        order = np.argsort(keys, kind="stable")
        return cls(K.indices, K.indptr, keys[order], order)

    def entries(self, matrix: sp.csr_matrix) -> Array | None:
        """Entries (nnz,) of a matrix at those of the pattern; None where it has others."""
        coo = matrix.tocoo()
        own = coo.row.astype(np.int64) * matrix.shape[1] + coo.col
        found = np.minimum(np.searchsorted(self.keys, own), len(self.keys) - 1)
        if not (self.keys[found] == own).all():
            return None
        return np.asarray(np.bincount(self.order[found], coo.data, len(self.keys)), dtype=float)
