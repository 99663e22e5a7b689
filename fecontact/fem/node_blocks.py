"""Sparse matrices of 3x3 blocks of pairs of nodes: their sums, and their upper triangles.

The blocks stay whole: the degrees of freedom of a node have the same pattern then, and orderings take them together.
Where zeros were dropped, as sums of sparse matrices do, PARDISO's analysis took twice the time.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray


def sum_of_blocks(first: IntArray, second: IntArray, blocks: Array, n: int) -> sp.csr_matrix:
    """Add up blocks of pairs of nodes into the upper triangle of a symmetric matrix.

    Parameters
    ----------
    first, second : (n_pairs,) int arrays
        Nodes in any order; the block of a pair the other way round is the transpose.
    blocks : (n_pairs, 9) array
        Rows of the blocks one after the other; diagonal ones are whole.
    n : int
        Number of nodes.

    Returns
    -------
    (3 n, 3 n) csr_matrix
        Sorted indices.

    Examples
    --------
    >>> found = sum_of_blocks(np.array([1, 0]), np.array([0, 0]), np.arange(18.0).reshape(2, 9), 2)
    >>> found.toarray()[:3].astype(int).tolist()
    [[9, 10, 11, 0, 3, 6], [0, 13, 14, 1, 4, 7], [0, 0, 17, 2, 5, 8]]
    """
    keys = np.minimum(first, second) * n + np.maximum(first, second)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    begins = np.ones(len(keys), bool)
    np.not_equal(keys[1:], keys[:-1], out=begins[1:])
    place = np.cumsum(begins) - 1
    # the sums as products with a matrix of ones: those of the blocks as they are, and below them those to transpose
    turned = (first > second)[order]
    count = int(begins.sum())
    pointer = np.concatenate([[0], np.cumsum(np.bincount(place + count * turned, minlength=2 * count))])
    taken = np.concatenate([order[~turned], order[turned]])
    sums = sp.csr_matrix((np.ones(len(keys)), taken, pointer), shape=(2 * count, len(keys))) @ blocks
    straight, other = sums.reshape(2, count, 3, 3)
    straight += other.swapaxes(1, 2)
    rows, columns = np.divmod(keys[begins], n)
    pointer = np.searchsorted(rows, np.arange(n + 1))
    return _upper(sp.bsr_matrix((straight, columns, pointer), shape=(3 * n, 3 * n)).tocsr())


def whole_blocks(K: sp.sparray | sp.spmatrix) -> sp.csr_matrix:
    """An upper triangle (3 n, 3 n) with all entries of its blocks stored, zeros too; sorted indices."""
    K = sp.bsr_matrix(K, blocksize=(3, 3)).tocsr()
    K.sort_indices()
    return _upper(K)


def _upper(K: sp.csr_matrix) -> sp.csr_matrix:
    """Upper triangle of a matrix with entries below the diagonal in the first block of each row of blocks only."""
    # scipy's triu would sort all again
    kept = np.ones(K.nnz, bool)
    begin = K.indptr[:-1].reshape(-1, 3)
    node = np.flatnonzero(np.diff(K.indptr[::3]))
    for row, k in ((1, 0), (2, 0), (2, 1)):
        place = begin[node, row] + k
        kept[place] = K.indices[place] >= 3 * node + row
    pointer = np.concatenate([[0], np.cumsum(np.add.reduceat(kept, begin[node].ravel(), dtype=np.int64))])
    rows = np.zeros(K.shape[0] + 1, np.int64)
    rows[1:].reshape(-1, 3)[node] = np.diff(pointer).reshape(-1, 3)
    return sp.csr_matrix((K.data[kept], K.indices[kept], np.cumsum(rows)), shape=K.shape)
