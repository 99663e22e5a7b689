"""Rows that hold bodies together: the lift of their gaps, the projection on displacements that keep them.

Used by conjugate gradients on rows, see `fem.constrained_cg`. Only G W G^T is factorised.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from fecontact.common.arrays import Array
from fecontact.fem.constrained_cg import Product

#: Smallest pivot of G W G^T, relative to its largest entry, at which rows count as dependent.
DEPENDENT = 1e-12
#: Entries of (G W G^T)^-1, relative to its diagonal, that are dropped from a preconditioner.
DROPPED = 1e-2
#: Rows with common displacements up to which their dense inverse is taken.
MOST_INVERTED = 3000


class DependentRowsError(ValueError):
    """Rows of an active set that are not independent on the solved displacements."""


class SparseRows:
    """Rows G (a, n) with weights W (n,): the lift L = W G^T (G W G^T)^-1 and the projection P = I - L G.

    Raises
    ------
    DependentRowsError
        For dependent rows.

    Examples
    --------
    >>> rows = SparseRows(sp.csr_matrix([[0.0, 2.0, 0.0]]), np.ones(3))
    >>> rows.lift(np.array([1.0])).tolist(), rows.project(np.array([3.0, 4.0, 5.0])).tolist()
    ([0.0, 0.5, 0.0], [3.0, 0.0, 5.0])
    """

    def __init__(self, G: sp.csr_matrix, W: Array) -> None:
        self.G = G
        weighted = sp.csr_matrix(G.multiply(W))
        self._weighted_transpose, self._transpose = weighted.T.tocsr(), G.T.tocsr()
        self.gram = gram = (G @ weighted.T).tocsc()
        diagonal = gram.diagonal()
        if diagonal.min(initial=np.inf) <= DEPENDENT * diagonal.max(initial=0.0):
            raise DependentRowsError("a row does not act on any solved displacement")
        #: Whether no two rows act on one displacement.
        self.apart = gram.nnz == len(diagonal)
        if self.apart:
            self._solve: Product = lambda b: b / diagonal
            return
        try:
            factor = spla.splu(gram, options={"SymmetricMode": True}, diag_pivot_thresh=0.0, permc_spec="MMD_AT_PLUS_A")
        except RuntimeError as error:
            raise DependentRowsError("dependent rows") from error
        pivots = np.abs(factor.U.diagonal())
        if pivots.min() <= DEPENDENT * pivots.max():
            raise DependentRowsError("dependent rows")
        self._solve = factor.solve

    def gap(self, u: Array) -> Array:
        """G u."""
        return np.asarray(self.G @ u)

    def lift(self, d: Array) -> Array:
        """L d."""
        return np.asarray(self._weighted_transpose @ self._solve(d))

    def forces(self, r: Array) -> Array:
        """L^T r: the forces along the rows in nodal forces r (n,)."""
        return self._solve(self._weighted_transpose.T @ r)

    def nodal(self, forces: Array) -> Array:
        """G^T l."""
        return np.asarray(self._transpose @ forces)

    def project(self, v: Array) -> Array:
        """P v."""
        return v - self.lift(self.gap(v))

    @property
    def invertible(self) -> bool:
        """Whether `removed` is affordable."""
        return self.apart or self.G.shape[0] <= MOST_INVERTED

    def removed(self) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """L G, which projects on what P removes, and G^T (G W G^T)^-1 G, a stiffness on it alone.

        Small entries of the inverse are dropped: away from the diagonal they decay exponentially.
        """
        if self.apart:
            few = sp.diags_array(1.0 / self.gram.diagonal(), format="csr")
        else:
            inverse = np.linalg.inv(self.gram.toarray())
            size = np.sqrt(inverse.diagonal())
            inverse[np.abs(inverse) < DROPPED * size * size[:, None]] = 0.0
            few = sp.csr_matrix(inverse)
        scaled = few @ self.G
        return sp.csr_matrix(self._weighted_transpose @ scaled), sp.csr_matrix(self._transpose @ scaled)
