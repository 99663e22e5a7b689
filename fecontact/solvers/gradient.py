"""Derivatives of functionals of a solution by its adjoint: one back substitution with the solved active set.

Where no point is about to open, close, stick or slip, a solution obeys equations R(x, y) = 0 of forces x and gaps and
slips y = S x + g + B^T q, with B x = F. For a functional of which a = dJ/dx and b = dJ/dq,

    [R_x + R_y S   R_y B^T]^T [v]   [a]
    [      B          0   ]   [u] = [b],    dJ/dg = -R_y^T v =: -h,    dJ/dF = u,    dJ/dS = -h x^T

Without friction R_y is one at closed points, which alone remain, and the matrix is symmetric: h are the forces of a
linear contact with the same closed points and a for its gaps. With friction R is the natural map of
`solvers.friction_newton`, whose tangent is Newton's. At points that are weakly active the solution has one-sided
derivatives only, and the gradient is that of the state found: F. Mignot, J. Funct. Anal. 22 (1976) 130.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import cho_factor, cho_solve, lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, cg

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import SolverError
from fecontact.solvers.coulomb import sizes, sticks
from fecontact.solvers.problem import ContactProblem, FrictionOperator

#: Force over the mean of those that carry, and gap over the mean opening, below which a point is weakly active.
WEAK = 1e-6
#: Relative difference of pressures that are the same.
SHARED = 1e-9
#: Relative residual of the adjoint of an operator, and most products.
RESIDUAL, MOST_PRODUCTS = 1e-13, 5000


@dataclass(frozen=True, eq=False)
class Adjoint:
    """Adjoint of a functional.

    Attributes
    ----------
    response : (n,) array
        h: less the derivatives by the gaps g.
    load : (m,) array
        u: the derivatives by the loads F.
    """

    response: Array
    load: Array


def adjoint(
    problem: ContactProblem, forces: Array, q: Array, by_forces: Array, by_motions: Array | None = None
) -> Adjoint:
    """Adjoint of a functional of a solution.

    Parameters
    ----------
    problem : ContactProblem
    forces, q : (n,) and (m,) arrays
        Its solution.
    by_forces, by_motions : (n,) and (m,) arrays
        Derivatives of the functional by them; none by motions unless given.

    Raises
    ------
    SolverError
        If an operator's products do not converge.

    Examples
    --------
    Of two springs of compliance 2 pushed by 3 together, one gap wider by 1 takes 1/4 from its force:

    >>> problem = ContactProblem(2 * np.eye(2), np.zeros(2), np.ones((1, 2)), np.array([3.0]))
    >>> found = adjoint(problem, np.array([1.5, 1.5]), np.array([-3.0]), np.array([1.0, 0.0]))
    >>> (-found.response).round(12).tolist(), found.load.round(12).tolist()
    ([-0.25, 0.25], [0.5])
    """
    closed = forces != 0
    closed[problem.tangents[forces[problem.points] > 0]] = True
    A = np.flatnonzero(closed)
    B, a = problem.B[:, A], by_forces[A]
    if problem.points.size:
        S = problem.matrix if problem.is_dense else _array(problem.S)
        solve = _tangent(problem, S, forces, q, A)
    elif problem.is_dense:
        factor = cho_factor(problem.matrix[np.ix_(A, A)])
        solve = partial(cho_solve, factor)
    else:
        solve = partial(by_products, partial(_among, problem, A))
    response = np.zeros(problem.n)
    response[A], load = saddle(solve, B, a, np.zeros(problem.m) if by_motions is None else by_motions)
    return Adjoint(response, load)


def _array(S: object) -> Array:
    assert isinstance(S, FrictionOperator)  # the only ones with friction
    return S.array()


def _among(problem: ContactProblem, A: IntArray, x: Array) -> Array:
    """Gaps (n,) of closed points by forces on them."""
    full = np.zeros(problem.n)
    full[A] = x
    return np.asarray(problem.S @ full)[A]


def _tangent(problem: ContactProblem, S: Array, x: Array, q: Array, A: IntArray) -> Callable[[Array], Array]:
    """Solution h of the transposed tangent without motions, of closed rows; points that slide by their natural map."""
    by_x, by_y = np.zeros(S.shape), np.eye(len(S))
    at, limit, stiffness = problem.points, problem.limit(x), 1 / S.diagonal().mean()
    slides = (x[at] > 0) & ~sticks(x[problem.tangents].T, limit) & np.isfinite(problem.mu)
    rows, mu = problem.tangents[slides], problem.mu[slides, None]
    t, slip = x[rows], problem.gap(x, q)[rows]
    size = sizes(t.T)[:, None]
    d = np.divide(t, size, out=np.zeros_like(t), where=size > 0)
    trial = size + stiffness * sizes(slip.T)[:, None]
    share = np.divide(limit[slides, None], trial, out=np.zeros_like(trial), where=size > 0)[:, :, None]
    turn = share * (np.eye(rows.shape[1]) - d[:, :, None] * d[:, None, :])
    own = (rows[:, :, None], rows[:, None, :])
    by_x[own], by_y[own] = np.eye(rows.shape[1]) - turn, stiffness * turn
    by_x[rows, at[slides, None]] = -mu * d
    kept = np.ix_(A, A)
    factor, by_gaps = lu_factor(by_x[kept] + by_y[kept] @ S[kept]), by_y[kept].T
    return lambda right: np.asarray(by_gaps @ lu_solve(factor, right, trans=1))


def by_products(product: Callable[[Array], Array], right: Array) -> Array:
    """Solution of a symmetric positive definite system of which there are products only.

    Raises
    ------
    SolverError
        If they do not converge.
    """
    S = LinearOperator((len(right), len(right)), matvec=product, dtype=float)
    found, failed = cg(S, right, rtol=RESIDUAL, atol=0.0, maxiter=MOST_PRODUCTS)
    if failed and np.linalg.norm(product(found) - right) > 1e3 * RESIDUAL * np.linalg.norm(right):
        raise SolverError(f"The adjoint did not converge in {MOST_PRODUCTS} products.", code="no-gradient")
    return np.asarray(found)


def saddle(solve: Callable[[Array], Array], B: Array, a: Array, b: Array) -> tuple[Array, Array]:
    """Response h (n,) and load u (m,) of S h + B^T u = a, B h = b, where S alone is solved; rows may be dependent."""
    alone, along = solve(a), np.array([solve(row) for row in B]).reshape(len(B), len(a))
    u = np.linalg.pinv(B @ along.T) @ (B @ alone - b) if len(B) else np.zeros(0)
    return alone - along.T @ u, u


def of_largest(pressure: Array) -> Array:
    """Derivatives of the largest pressure: one at its point, or in equal parts at those that share it.

    Of mirror images this is the mean of both one-sided derivatives, a subgradient.
    """
    largest = pressure >= (1 - SHARED) * pressure.max()
    return largest / largest.sum()


def weakly_active(problem: ContactProblem, forces: Array, q: Array) -> IntArray:
    """Rows of points about to open or to close, and of points with friction about to stick or to slide."""
    gap, n = problem.gap(forces, q), problem.normals
    carried = np.abs(forces[n])[forces[n] != 0].mean() if forces[n].any() else 1.0
    opened = np.abs(gap[n])[forces[n] == 0].mean() if (forces[n] == 0).any() else np.inf
    weak = set(n[(np.abs(forces[n]) < WEAK * carried) & (np.abs(gap[n]) < WEAK * opened)].tolist())
    if problem.points.size:
        pressed, slip = forces[problem.points] > 0, sizes(gap[problem.tangents].T)
        rim = ~sticks(forces[problem.tangents].T, problem.limit(forces)) & (problem.mu > 0)
        weak |= set(problem.points[pressed & rim & (slip <= WEAK * slip.max(initial=0.0))].tolist())
    return np.array(sorted(weak), dtype=np.int64)
