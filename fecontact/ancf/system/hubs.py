"""Rigid hubs: solids that move affinely, r = A X + b, by six conditions rigidly.

The Green-Lagrange strains of a hub vanish,

    c_ij(q) = (F_i . F_j - delta_ij) / 2 = 0,    F_i = dr/dX_i at its first node,

so that A is a rotation. They are quadratic in q, with the constant second derivative B_ij, and their multipliers l_ij
are the stresses of the hub times its volume (ANCF reference node: A. A. Shabana, Proc. IMechE K 229, 2015; constraints
of a rigid body in natural coordinates: J. Garcia de Jalon & E. Bayo, Kinematic and Dynamic Simulation of Multibody
Systems, 1994, chapter 2). Forces C(q)^T l are internal: without resultant, and without moment as l_ij is symmetric.
Between two states c(q1) - c(q0) = C((q0 + q1)/2) (q1 - q0), so that by the derivative in the middle they do no work.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.system.newton import Ties
from fecontact.common.arrays import Array, IntArray

#: The strains i <= j, and the factor of their work.
_I, _J = np.array([0, 1, 2, 0, 1, 0]), np.array([0, 1, 2, 1, 2, 2])


@dataclass(frozen=True, eq=False)
class Hubs:
    """Conditions of several rigid hubs.

    Parameters
    ----------
    gradients : (n_hubs, 3, 3) int array
        Coordinates of the three gradients at the first node of each: gradient, component.
    n_dofs : int
        Coordinates of all solids.

    Examples
    --------
    >>> hub = Hubs(np.arange(9).reshape(1, 3, 3), 9)
    >>> hub.strains(np.diag([1.1, 1.0, 1.0]).ravel()).round(12).tolist()
    [0.105, 0.0, 0.0, 0.0, 0.0, 0.0]
    """

    gradients: IntArray
    n_dofs: int

    def strains(self, q: Array) -> Array:
        """The conditions c (6 n_hubs,) at coordinates q (n_dofs,)."""
        F = q[self.gradients]
        return np.asarray((((F[:, _I] * F[:, _J]).sum(axis=2) - (_I == _J)) / 2).ravel())

    def derivative(self, q: Array) -> sp.csr_matrix:
        """C (6 n_hubs, n_dofs)."""
        places, F = self.gradients, q[self.gradients]
        data = np.concatenate([F[:, _J], F[:, _I]], axis=2) / 2
        columns = np.concatenate([places[:, _I], places[:, _J]], axis=2)
        rows = np.broadcast_to(np.arange(6 * len(F)).reshape(-1, 6, 1), data.shape)
        return sp.csr_matrix((data.ravel(), (rows.ravel(), columns.ravel())), shape=(6 * len(F), self.n_dofs))

    def curvature(self, multipliers: Array) -> sp.csr_matrix:
        """Second derivative (n_dofs, n_dofs) of multipliers . c."""
        one, other = self.gradients[:, _I], self.gradients[:, _J]
        data = np.repeat(multipliers / 2, 3)
        rows, columns = one.ravel(), other.ravel()
        both = np.concatenate([rows, columns]), np.concatenate([columns, rows])
        return sp.csr_matrix((np.tile(data, 2), both), shape=(self.n_dofs, self.n_dofs))

    def quadratic_velocity(self, v: Array) -> Array:
        """C'' of velocities v (n_dofs,): what C a lacks of the second derivative of c by time."""
        V = v[self.gradients]
        return np.asarray((V[:, _I] * V[:, _J]).sum(axis=2).ravel())

    def subtracted(
        self, K: sp.csr_matrix, q: Array, multipliers: Array, share: float = 1.0
    ) -> tuple[sp.csr_matrix, float]:
        """What is subtracted from a tangent K, and the weight w of the equations in it.

        A share of the second derivative of multipliers . c, and -w C^T C, which makes the tangent positive definite
        where its rigid motions are resisted (augmented Lagrangian): under equations it shifts the multipliers only,
        those of K are w c more.
        """
        C = self.derivative(q)
        weight = float(K.diagonal()[self.gradients].max() + 10 * np.abs(multipliers).max())
        return sp.csr_matrix(share * self.curvature(multipliers) - weight * (C.T @ C)), weight

    def ties(self, q: Array, middle: Array | None = None) -> Ties:
        """What a Newton step needs at coordinates q; forces act along the derivative in the middle of a step."""
        C = self.derivative(q)
        return Ties(C, C if middle is None else self.derivative(middle), self.strains(q))
