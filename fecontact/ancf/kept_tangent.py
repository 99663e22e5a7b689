"""Tangent of a step in time, whose factor is kept over its iterations while it serves."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.assembly import Assembly
from fecontact.ancf.banded import BandFactor, BandOrder
from fecontact.ancf.newton import Ties, UnstableError, contact_step, tied_step
from fecontact.ancf.slip import Slips
from fecontact.common.arrays import Array, IntArray

#: Contraction of the iterations below which the tangent is kept, and the smaller tolerance of changes by a kept one.
CONTRACTION, OLD = 0.1, 1e-3


@dataclass
class KeptTangent:
    """Tangent of the free coordinates; without contact its factor serves as long as the iterations contract.

    Attributes
    ----------
    K : (n_free, n_free) csr_matrix or None
    order : BandOrder or None
    factor : BandFactor or None
        None where the next iteration takes a new tangent.
    last : float
        Largest change of the last iteration.
    again : bool
        Whether the factor has served before.
    stresses : (6 n_hubs,) array
        Multipliers of rigid hubs.
    weight : float
        Of their equations in K.
    """

    K: sp.csr_matrix | None = None
    order: BandOrder | None = None
    factor: BandFactor | None = None
    last: float = np.inf
    again: bool = False
    stresses: Array = field(default_factory=lambda: np.zeros(0))
    weight: float = 0.0

    def serves(self, near: IntArray) -> bool:
        """Whether no new tangent is needed."""
        self.again = self.factor is not None and not len(near)
        return self.again

    def renew(
        self, a: Assembly, K: sp.csr_matrix, less: sp.csr_matrix | None, near: IntArray, q: Array, share: float
    ) -> None:
        """Take the tangent K (n_dofs, n_dofs) less another matrix, with a share of the second derivative of hubs."""
        if less is not None:
            K = a.constants.lessened(K, less)
        if a.hubs is not None:
            stresses = self.stresses if len(self.stresses) else np.zeros(len(a.hub_strains(q)))
            of_hubs, self.weight = a.hubs.less(K, q, stresses, share)
            K = a.constants.lessened(K, of_hubs)
        self.K, self.order = a.constants.reduced(K)
        self.factor = None
        if self.order is not None and not len(near):
            try:
                self.factor = self.order.factor(self.K.data)
            except np.linalg.LinAlgError as error:
                raise UnstableError("The tangent stiffness is not positive definite.") from error

    def solved(
        self,
        a: Assembly,
        rest: Array,
        G: sp.csr_matrix,
        gap: Array,
        near: IntArray,
        slip: Slips,
        guess: tuple[Array, Array],
        ties: Ties | None,
    ) -> tuple[Array, Array, Array]:
        """Change of all coordinates, the forces of all conditions and those along the rows of slip."""
        Z, forces = a.free, np.zeros(len(gap))
        r = Z.T @ rest
        if ties is not None:
            assert self.K is not None
            still = np.zeros(a.n_dofs)
            rows = slip.rows(near, Z, still, *guess)
            change, forces[near], dragging, stresses = tied_step(
                self.K, r, sp.csr_matrix(G[near] @ Z), gap[near], ties.along(Z, still), rows, self.order, self.factor
            )
            self.stresses = stresses + self.weight * ties.value
            return Z @ change, forces, slip.spread(near, dragging)
        if self.factor is not None and not len(near):
            return Z @ self.factor.solve(r[:, None])[:, 0], forces, np.zeros(len(slip.slip))
        assert self.K is not None
        rows = slip.rows(near, Z, np.zeros(a.n_dofs), *guess)
        change, forces[near], dragging = contact_step(
            self.K, r, sp.csr_matrix(G[near] @ Z), gap[near], friction=rows, order=self.order
        )
        return Z @ change, forces, slip.spread(near, dragging)

    def by_hubs(self, ties: Ties | None) -> Array | float:
        """Generalised forces (n_dofs,) of rigid hubs."""
        return 0.0 if ties is None else np.asarray(ties.columns.T @ self.stresses)

    def judged(self, a: Assembly, change: Array, tolerance: float) -> float:
        """Tolerance of this change, smaller where an old tangent makes the error one of the first order."""
        size = float(np.abs(a.lengths * change).max(initial=0.0))
        if size > CONTRACTION * self.last:
            self.factor = None
        self.last = size
        return tolerance * (OLD if self.again else 1.0)
