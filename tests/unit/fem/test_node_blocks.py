"""Sums of blocks of pairs of nodes against dense sums, and what is stored of them."""

import numpy as np
import scipy.sparse as sp

from fecontact.fem.stiffness import sum_of_blocks, whole_blocks


def test_sums_of_blocks_are_those_of_a_dense_matrix():
    rng, n = np.random.default_rng(1), 6
    first, second = rng.integers(0, n - 1, (2, 60))  # the last node is in no pair
    blocks = rng.normal(size=(60, 3, 3))
    blocks[first == second] += blocks[first == second].swapaxes(1, 2)
    dense = np.zeros((n, 3, n, 3))
    for a, b, block in zip(first, second, blocks, strict=True):
        a, b, block = (a, b, block) if a <= b else (b, a, block.T)
        dense[a, :, b] += block
    found = sum_of_blocks(first, second, blocks.reshape(-1, 9), n)
    assert found.has_sorted_indices
    assert np.abs(found.toarray() - np.triu(dense.reshape(3 * n, 3 * n))).max() < 1e-14


def test_blocks_are_stored_whole():
    # nodes 0 and 1 share one entry, node 2 has none
    K = sp.csr_matrix(([2.0, 1.0, 3.0], ([0, 0, 4], [0, 5, 4])), shape=(9, 9))
    found = whole_blocks(K)
    assert np.array_equal(found.toarray(), K.toarray())
    assert np.diff(found.indptr).tolist() == [6, 5, 4, 3, 2, 1, 0, 0, 0]
