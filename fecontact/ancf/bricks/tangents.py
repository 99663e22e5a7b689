"""Tangents of elements, and the sparsity pattern into which they are summed, found once.

Sums of matrices in the pattern of one of them: places found once, no bookkeeping of sparse sums.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.bricks.space import BATCH, GradientBatch
from fecontact.common.arrays import Array, IntArray
from fecontact.fem.laws import Response

#: Pairs (i, j) of components, i <= j, that tell a symmetric tangent, and the place of every (i, j) among them.
PAIRS = np.array([0, 0, 0, 1, 1, 2]), np.array([0, 1, 2, 1, 2, 2])
PAIR_OF = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
#: Place of every (i, j) in the order of `common.material.VOIGT`.
VOIGT_OF = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])


@dataclass(frozen=True, eq=False)
class _Sum:
    """Summation of the entries of a batch of cells: its matrix, and the places of the sums in the pattern.

    The only batch has all places, and a slice costs a tenth of a list of them.
    """

    matrix: sp.csr_matrix
    place: IntArray | slice


@dataclass(frozen=True, eq=False)
class Pattern:
    """Pairs of functions that meet in a cell.

    Parameters
    ----------
    functions : (n_cells, 32) int array
        Numbers of the cells' functions.
    joining : (n_cell_functions, n_functions) csr_matrix or None
        See `AncfSpace.joining`.
    """

    functions: IntArray
    joining: sp.csr_matrix | None

    @cached_property
    def pairs(self) -> tuple[IntArray, IntArray, list[_Sum]]:
        """Cached sparsity pattern of pairs of functions, and the summation of each batch into it."""
        n = int(self.functions.max()) + 1
        orders, firsts, keys = [], [], []
        for start in range(0, len(self.functions), BATCH):
            f = self.functions[start : start + BATCH]
            k = (f[:, :, None] * n + f[:, None, :]).ravel()
            orders.append(np.argsort(k, kind="stable"))
            ordered = k[orders[-1]]
            firsts.append(np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]])))
            keys.append(ordered[firsts[-1]])
        distinct = np.sort(np.concatenate(keys))
        distinct = distinct[np.concatenate([[True], distinct[1:] != distinct[:-1]])]
        rows, columns = np.divmod(distinct, n)
        ones, sums = np.ones(max(map(len, orders))), []  # the same for all batches
        for order, first, k in zip(orders, firsts, keys, strict=True):
            pointer = np.append(first, len(order)).astype(np.int32)
            entries = ones[: len(order)], order.astype(np.int32), pointer
            S = sp.csr_matrix(entries, shape=(len(first), len(order)), copy=False)
            sums.append(_Sum(S, np.searchsorted(distinct, k) if len(orders) > 1 else slice(None)))
        return np.searchsorted(rows, np.arange(n + 1)), columns, sums

    @cached_property
    def _rows(self) -> tuple[IntArray, IntArray, IntArray]:
        """Row pointers and columns of the pattern in single coordinates, and the order of the blocks' entries there."""
        pointer, columns, _ = self.pairs
        n = len(pointer) - 1
        number = sp.csr_matrix((np.arange(len(columns)), columns, pointer), shape=(n, n))
        other = number.T.tocsr()
        other.sort_indices()
        i, j = np.indices((3, 3))
        upper, lower = np.arange(len(columns)), other.data
        blocks = 6 * np.where(i <= j, upper[:, None, None], lower[:, None, None]) + PAIR_OF
        K = sp.bsr_matrix((blocks.astype(float), columns, pointer), shape=(3 * n, 3 * n)).tocsr()
        return K.indptr, K.indices, K.data.astype(np.int64)

    def zeros(self, *width: int) -> Array:
        """No entries yet, of the given width for each pair."""
        return np.zeros((len(self.pairs[1]), *width))

    def add(self, data: Array, batch: int, blocks: Array) -> None:
        """Add the entries (n_cells, 32, 32, ...) of a batch, by number."""
        how = self.pairs[2][batch]
        data[how.place] += how.matrix @ blocks.reshape(-1, *data.shape[1:])

    def scalar(self, data: Array) -> sp.csr_matrix:
        """Matrix (n_functions, n_functions) of one entry per pair."""
        pointer, columns, _ = self.pairs
        M = sp.csr_matrix((data, columns, pointer), shape=(len(pointer) - 1,) * 2)
        return M if self.joining is None else (self.joining.T @ M @ self.joining).tocsr()

    def matrix(self, blocks: Array) -> sp.csr_matrix:
        """Symmetric matrix (n_dofs, n_dofs) of the blocks (k, 6) of the pattern, see `PAIRS`."""
        pointer, columns, order = self._rows
        K = sp.csr_matrix((blocks.ravel()[order], columns, pointer), shape=(len(pointer) - 1,) * 2, copy=False)
        if self.joining is None:
            return K
        T = sp.kron(self.joining, sp.eye_array(3), format="csr")
        return (T.T @ K @ T).tocsr()


def element_tangents(F: Array, response: Response, batch: GradientBatch) -> Array:
    """Tangents (n_cells, 32 a, 32 b, 6) of cells, for the pairs (i, j) of `PAIRS`: K_ab^ji = K_ba^ij."""
    n, n_q, n_functions, _ = batch.gradients.shape
    A = _isotropic(F, response, batch.dV)
    if response.moduli is not None:
        A += _by_moduli(F, response.moduli, batch.dV)
    stress = _points_last(response.stress, batch.dV) * batch.dV.ravel()
    for k in (0, 3, 5):
        A[:, k] += stress
    G = np.swapaxes(batch.gradients, 2, 3)
    Y = np.ascontiguousarray(A.reshape(54, -1).T).reshape(n, n_q, 18, 3) @ G  # (J, ij), b
    K = np.swapaxes(G.reshape(n, 3 * n_q, n_functions), 1, 2) @ Y.reshape(n, 3 * n_q, 6 * n_functions)
    return np.ascontiguousarray(K.reshape(n, n_functions, 6, n_functions).swapaxes(2, 3))


def _points_last(tensors: Array, dV: Array) -> Array:
    """Tensors (3, 3, n_cells n_q) at all points, from those that broadcast over dV (n_cells, n_q)."""
    every = np.broadcast_to(tensors, (*dV.shape, 3, 3))
    return np.ascontiguousarray(every.reshape(-1, 9).T).reshape(3, 3, -1)


def _isotropic(F: Array, response: Response, dV: Array) -> Array:
    """The weighted F_iM D_MJNL F_jN (3 J, 6 ij, 3 L, n_cells n_q); with the points last, all products are of long rows.

    a (FX)_iJ (FX)_jL + b ((F X F^T)_ij X_JL + (FX)_iL (FX)_jJ) of lame a, shear b and metric X
    """
    X = response.metric
    assert X is not None
    a, b = ((c * dV).ravel() for c in (response.lame, response.shear))
    plain = _points_last(F, dV)
    unit = not any(X.strides[:-2]) and np.array_equal(X[0, 0], np.eye(3))
    Y = plain if unit else _points_last(F @ X, dV)
    one, other = Y[PAIRS[0]], Y[PAIRS[1]]
    # J first, then L; the pair between them
    A = (a * one.swapaxes(0, 1))[:, :, None] * other
    A += (b * other.swapaxes(0, 1))[:, :, None] * one
    across = b * (one * plain[PAIRS[1]]).sum(axis=1)
    if Y is not plain:
        A += across[:, None] * _points_last(X, dV)[:, None]
        return A
    for k in range(3):
        A[k, :, k] += across
    return A


def _by_moduli(F: Array, moduli: Array, dV: Array) -> Array:
    """The same from moduli (n_cells, n_q, 6, 6), in the order of `VOIGT`."""
    D = moduli[..., VOIGT_OF[:, :, None, None], VOIGT_OF]
    A = np.einsum("eqiM,eqMJNL,eqjN->JijLeq", F, D, F, optimize=True) * dV
    return np.asarray(A[:, PAIRS[0], PAIRS[1]].reshape(3, 6, 3, -1))


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
