"""The route of the source report: elastic displacements and rigid motions separated by Gram-Schmidt.

Total displacements are u = S (S^T K S)^-1 S^T F + R a, where the orthonormal columns of S span what is orthogonal to
the free rigid motions R of the body. Nothing is held artificially. The compliance of a contact's rows C is C S (S^T K
S)^-1 S^T C^T; that of a body held at some nodes differs by rigid motions only, so that contact forces are the same.
Source: P. T. Elangovan (1978), appendix A, equations A-2 and A-9 to A-13.

S and S^T K S are dense: the route serves for comparison, on models of up to some thousand degrees of freedom.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import FecontactError, InputError
from fecontact.fem.pardiso import SINGULAR
from fecontact.fem.rigid import complement, gram_schmidt

#: Name of the route among those of `fem.condensation`.
SEPARATED = "gram-schmidt"
#: Dense matrices of (n, n): K, its product with S, and S.
N_DENSE = 3


@dataclass(frozen=True, eq=False)
class Separated:
    """Stiffness with its rigid motions separated; a `Condensation`.

    Attributes
    ----------
    K : (n, n) csr_matrix
        The whole stiffness.
    S : (n, m) array
        Orthonormal basis of the elastic displacements.
    cholesky : (m, m) array
        Lower factor of S^T K S.
    """

    K: sp.csr_matrix
    S: Array
    cholesky: Array
    route: str = SEPARATED
    why: str = "as asked"

    @classmethod
    def of(cls, upper: sp.csr_matrix, rigid: Array, budget: float) -> Separated:
        """From the upper triangle of K (n, n), the free rigid motions (n, k), and the bytes for dense matrices.

        Raises
        ------
        InputError
            If the dense matrices exceed the budget.
        """
        n = upper.shape[0]
        needed = N_DENSE * 8.0 * n**2
        if needed > budget:
            raise InputError(
                f"condensation={SEPARATED!r} takes {needed / 1e9:.2g} GB for dense matrices of {n} degrees of freedom, "
                f"and {budget / 1e9:.2g} GB are at hand. Take a coarser mesh, or condensation='auto', which gives the "
                "same forces."
            )
        S, K = complement(gram_schmidt(rigid)), (upper + sp.triu(upper, 1).T).tocsr()
        reduced = S.T @ (K @ S)
        cholesky, info = scipy.linalg.lapack.dpotrf(reduced.T, lower=1, clean=0, overwrite_a=1)
        if info != 0:
            raise FecontactError(SINGULAR)
        return cls(K, S, cholesky)

    @property
    def memory(self) -> int:
        """Bytes of S and of the factor."""
        return int(self.S.nbytes + self.cholesky.nbytes)

    @property
    def n_retained(self) -> int:
        """All elastic degrees of freedom."""
        return len(self.cholesky)

    def invert(self) -> None:
        """Nothing else is needed for other rows."""

    def covers(self, dofs: IntArray) -> bool:
        """Always."""
        return True

    def compliance(self, C: sp.csr_matrix) -> Array:
        """C S (S^T K S)^-1 S^T C^T, equation A-12."""
        half = C @ self.solve(C.T.toarray())
        return np.asarray(half + half.T) / 2

    def response(self, C: sp.csr_matrix, f: Array) -> Array:
        """Elastic displacements along rows C under f."""
        return np.asarray(C @ self.solve(f))

    def solve(self, f: Array) -> Array:
        """S (S^T K S)^-1 S^T f, equation A-9, for forces (n,) or (n, m).

        S mixes large entries of K with small ones, hence a step of iterative refinement.
        """
        u = self._elastic(f)
        return u + self._elastic(f - self.K @ u)

    def _elastic(self, f: Array) -> Array:
        return np.asarray(self.S @ scipy.linalg.cho_solve((self.cholesky, True), self.S.T @ f, check_finite=False))
