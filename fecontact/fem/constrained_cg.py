"""Bodies held together along some rows: conjugate gradients in the displacements that keep them.

Of displacements u and rigid motions q with G u + d + B^T q = 0, find those with

    K u = G^T l,    B l = F.

With weights W and L = W G^T (G W G^T)^-1, every such u is u_0 + P v - L B^T q, where P = I - L G projects on G v = 0.
Conjugate gradients run on T^T K T, T = [P, -L B^T], with the preconditioner P V P^T for an approximation V of K^-1: a
projected preconditioned method (N. I. M. Gould, M. E. Hribar, J. Nocedal, SIAM J. Sci. Comput. 23 (2001) 1376). Only
G W G^T is factorised. The forces are l = L^T K u, and the residual K u - G^T l = P^T K u.

A node on a rigid surface is the simplest case: its row has one entry along the normal, P removes that component, and
the conditions are those of Dirichlet on one turned degree of freedom per node.

Where several processes share the displacements, each has its part of u and all of l and q. The module needs NumPy
only, so that they can import it; rows in one process are `fem.multigrid.SparseRows`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fecontact.common.arrays import Array

#: Largest number of steps, and of passes on the true residual.
MAX_ITERATIONS, PASSES = 2000, 5

Product = Callable[[Array], Array]


class Rows(Protocol):
    """Rows G (a, n), their lift L and the projection P, see `fem.constrained_cg`."""

    def gap(self, u: Array) -> Array:
        """G u."""

    def lift(self, d: Array) -> Array:
        """L d."""

    def project(self, v: Array) -> Array:
        """P v."""

    def forces(self, r: Array) -> Array:
        """L^T r."""

    def nodal(self, forces: Array) -> Array:
        """G^T l."""


@dataclass(frozen=True, eq=False)
class Held:
    """Bodies on rows.

    Attributes
    ----------
    K : callable
        Product with the stiffness (n, n).
    V : callable
        Product with an approximation of its inverse, symmetric and positive definite.
    rows : Rows
    d : (a,) array
    B : (m, a) array
    F : (m,) array
    Q : (m, m) array
        Approximation of the inverse of B (G K^-1 G^T)^-1 B^T.
    total : callable
        Sum of an array over the processes that share u; by default there is one.
    """

    K: Product
    V: Product
    rows: Rows
    d: Array
    B: Array
    F: Array
    Q: Array
    total: Product = np.asarray


def constrained_cg(
    held: Held, u: Array, q: Array, rtol: float, count: Callable[[], None]
) -> tuple[Array, Array, Array]:
    """Displacements, forces and motions.

    Parameters
    ----------
    held : Held
    u, q : (n,) and (m,) arrays
        To start from.
    rtol : float
        Largest norm of the residual K u - G^T l over that of G^T l, and of each entry of B l - F over |B| |l|.
    count : callable
        Called at each step.

    Returns
    -------
    u, forces, q : (n,), (a,) and (m,) arrays
        Without convergence the last ones.

    Examples
    --------
    Two springs of stiffness 1 and 3 in a row, whose end, under a rigid plate, carries a load of 2:

    >>> import scipy.sparse as sp
    >>> from fecontact.fem.multigrid import SparseRows
    >>> K = np.array([[4.0, -3.0], [-3.0, 3.0]])
    >>> rows = SparseRows(sp.csr_matrix([[0.0, -1.0]]), np.ones(2))
    >>> held = Held(K.dot, lambda r: r, rows, np.zeros(1), np.ones((1, 1)), np.array([2.0]), np.eye(1))
    >>> u, forces, q = constrained_cg(held, np.zeros(2), np.zeros(1), 1e-12, lambda: None)
    >>> u.round(9).tolist(), forces.round(9).tolist(), q.round(9).tolist()
    ([-2.0, -2.666666667], [2.0], [-2.666666667])
    """
    rows, B = held.rows, held.B
    size = np.abs(B)
    forces = np.zeros(len(held.d))
    for _ in range(PASSES):
        # the recurrence drifts from the rows and from the true residual
        u = u - rows.lift(rows.gap(u) + held.d + B.T @ q)
        Ku = held.K(u)
        s, p, last = np.zeros_like(u), np.zeros_like(q), 1.0
        for step in range(MAX_ITERATIONS):
            forces = rows.forces(Ku)
            nodal = rows.nodal(forces)
            r, unbalanced = nodal - Ku, B @ forces - held.F
            residual, whole = np.sqrt(held.total(np.array([r @ r, nodal @ nodal])))
            if residual <= rtol * whole and (np.abs(unbalanced) <= rtol * (size @ np.abs(forces))).all():
                if step == 0:
                    return u, forces, q
                break
            z, w = rows.project(held.V(r)), held.Q @ unbalanced
            now = float(held.total(np.array([r @ z]))[0] + unbalanced @ w)
            if not now > 0.0:  # nor a number
                break
            p = w + now / last * p
            s = z - rows.lift(B.T @ w) + now / last * s
            Ks = held.K(s)
            length = now / float(held.total(np.array([s @ Ks]))[0])
            u, q, Ku, last = u + length * s, q + length * p, Ku + length * Ks, now
            count()
    return u, forces, q
