"""Block Gauss-Seidel sweeps for contact with Coulomb friction: slow and safe, the fall-back of Newton's method.

One point after the other takes the forces that close its own gap and stop its own slip, projected on its cone (Jean,
Comput. Methods Appl. Mech. Eng. 177 (1999) 235). Equilibrium is an augmented Lagrangian: V^T V of the orthonormal
rows V is added to the compliance, and the multiplier follows after every few sweeps (Hestenes 1969).
"""

from __future__ import annotations

import numpy as np

from fecontact.solvers.friction_newton import FrictionRows, bound
from fecontact.solvers.outcome import Outcome
from fecontact.solvers.problem import Status
from fecontact.solvers.scaling import ScaledProblem

SWEEPS = 5
"""Sweeps between two updates of the rigid motion."""


def friction_sweeps(
    problem: ScaledProblem,
    rows: FrictionRows,
    x: np.ndarray,
    p: np.ndarray,
    *,
    tolerance: float = 1e-4,
    max_iterations: int = 400,
) -> Outcome:
    """Sweep until forces change by less than a tolerance.

    Parameters
    ----------
    problem : ScaledProblem
    rows : FrictionRows
    x, p : ndarrays, shapes (N,) and (r,)
    tolerance : float
        Of the change in a sweep and of equilibrium, relative to the forces. Newton's method sharpens the answer.
    max_iterations : int
        Largest number of sweeps.

    Returns
    -------
    Outcome
        ``solved`` within the tolerance, else ``iteration-limit``; where the sweeps diverged, with the iterate that
        changed least. Not certified.
    """
    V, weight = problem.B, float(problem.n)
    S = problem.matrix + weight * V.T @ V
    x, p = x.copy(), p.copy()
    history: list[float] = []
    best = (np.inf, x.copy(), p.copy())
    largest = bound(problem, x, p)
    frictional = {int(n): k for k, n in enumerate(rows.points)}
    for nit in range(1, max_iterations + 1):
        before = x.copy()
        y = S @ x + problem.g + V.T @ (p - weight * problem.F)
        for n in rows.normals:
            _sweep_point(S, y, x, int(n), rows, frictional.get(int(n)))
        if (size := float(np.abs(x).max())) > largest:
            return Outcome(best[1], best[2], Status.ITERATION_LIMIT, f"sweep {nit} diverged", nit, history)
        miss = V @ x - problem.F
        if nit % SWEEPS == 0:
            p += weight * miss
        history.append(max(float(np.abs(x - before).max()), float(np.abs(miss).max(initial=0.0))) / max(size, 1e-300))
        if history[-1] < best[0]:
            best = (history[-1], x.copy(), p.copy())
        if history[-1] < tolerance and nit % SWEEPS == 0:
            return Outcome(x, p, Status.SOLVED, "solved", nit, history)
    return Outcome(x, p, Status.ITERATION_LIMIT, f"{nit} sweeps were not enough", nit, history)


def _sweep_point(S: np.ndarray, y: np.ndarray, x: np.ndarray, n: int, rows: FrictionRows, k: int | None) -> None:
    """Forces of one point from its own gap and slip; x and y are changed in place."""
    force = max(0.0, x[n] - y[n] / S[n, n])
    _set(S, y, x, np.array([n]), np.array([force]))
    if k is None:
        return
    t = rows.tangents[k]
    trial = x[t] - y[t] / np.linalg.norm(S[np.ix_(t, t)], 2)
    size, limit = float(np.linalg.norm(trial)), float(rows.mu[k] * force) if force > 0 else 0.0
    _set(S, y, x, t, trial if size <= limit else trial * (limit / size))


def _set(S: np.ndarray, y: np.ndarray, x: np.ndarray, rows: np.ndarray, forces: np.ndarray) -> None:
    y += S[rows].T @ (forces - x[rows])
    x[rows] = forces
