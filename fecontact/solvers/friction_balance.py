"""Whether forces inside the cones of friction can balance a load: a necessary condition, and the friction it takes.

Forces on a cone are non-negative combinations of its edges n + mu (cos a t_1 + sin a t_2). The edges that matter are
found one by one: the residual of the non-negative least-squares problem of those known is a motion, and each point
adds the edge that resists it most (column generation; Gilmore & Gomory 1961). If none resists, the motion is free by
Farkas' lemma. Coulomb's law is not associated: forces that balance may exist and the body slide nevertheless.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from fecontact.solvers.friction_newton import FrictionRows
from fecontact.solvers.scaling import UNBALANCED, ScaledProblem

ROUNDS = 60
"""Largest number of edges tried at each point."""

MU_STEPS = 40
"""Bisections for the least coefficient of friction."""

MOST_FRICTION = 1e3
"""Coefficient from which more friction is taken not to help."""


def unbalanced_motion(problem: ScaledProblem, rows: FrictionRows) -> np.ndarray | None:
    """Motion (m,) along which the load does work and no cone resists, of unit norm; None if the load can be balanced.

    Parameters
    ----------
    problem : ScaledProblem
    rows : FrictionRows
    """
    if problem.inconsistency.any():
        return problem.inconsistency
    size = float(np.linalg.norm(problem.F))
    if size == 0:
        return None
    B, normals = problem.B, rows.normals
    edges = B[:, normals]
    rough = np.isinf(rows.mu)
    sides = B[:, rows.tangents[rough].ravel()]
    # a rough point bears any tangential force once it is pressed: of both signs
    edges = np.concatenate([edges, sides, -sides], axis=1)
    finite = np.flatnonzero(~rough & (rows.mu > 0))
    points, tangents, mu = rows.points[finite], rows.tangents[finite], rows.mu[finite]
    for _ in range(ROUNDS):
        x, distance = nnls(edges, problem.F, maxiter=30 * edges.shape[1] + 100)
        if distance <= UNBALANCED * size:
            return None
        residual = problem.F - edges @ x
        pull = np.einsum("r,rfk->fk", residual, B[:, tangents])
        length = np.linalg.norm(pull, axis=1)
        direction = np.divide(pull, length[:, None], out=np.zeros_like(pull), where=length[:, None] > 0)
        gain = residual @ B[:, points] + mu * length
        useful = gain > UNBALANCED * distance
        if not useful.any():
            break
        best = np.argsort(gain[useful])[-8 * problem.r :]
        chosen = np.flatnonzero(useful)[best]
        side = np.einsum("fk,rfk->rf", direction[chosen], B[:, tangents[chosen]])
        edges = np.concatenate([edges[:, np.r_[: len(normals)]], edges[:, len(normals) :][:, x[len(normals) :] > 0],
                                B[:, points[chosen]] + mu[chosen] * side], axis=1)  # fmt: skip
    else:
        return None  # at the limit: the solver decides
    motion = problem.motion(-residual)
    return motion / float(np.linalg.norm(motion))


def least_friction(problem: ScaledProblem, rows: FrictionRows) -> float:
    """Least coefficient of friction, the same at all frictional points, with which the load can be balanced.

    Returns
    -------
    float
        Infinite if no friction balances it.
    """

    def balanced(mu: float) -> bool:
        every = np.where(rows.mu > 0, mu, 0.0)
        return unbalanced_motion(problem, FrictionRows(rows.points, rows.tangents, rows.normals, every)) is None

    low, high = 0.0, 1.0
    while not balanced(high):
        low, high = high, 4 * high
        if high > MOST_FRICTION:
            return np.inf
    for _ in range(MU_STEPS):
        middle = (low + high) / 2
        low, high = (low, middle) if balanced(middle) else (middle, high)
        if high - low < 1e-6 * high:
            break
    return high
