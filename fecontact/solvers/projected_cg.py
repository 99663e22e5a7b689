"""Projected conjugate gradients: matrix products only, for many points and for compliances that are operators.

Polonsky & Keer (1999): conjugate gradients on the active set; tensile forces are set to zero, penetrating points are
added, and the direction is restarted when the set changes. Two extensions are made. Any number of load rows: gradient
and direction are orthogonal to the rows on the active set, with the least-squares multiplier, and after a change of the
set the forces are projected exactly on {x >= 0, B x = F}, by Newton's method in r unknowns (for a single row of ones
Polonsky & Keer rescale instead). A safeguard: a step that does not lower the energy is replaced by a projected gradient
step of safe length, which does.

Convergence is that of conjugate gradients once the set is found: slow where S is nearly singular; use the direct
solvers there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.solvers.problem import Outcome, Status
from fecontact.solvers.scaling import SMALLEST, ScaledProblem

CLOSED = 1e-12
"""Tolerance: gap at active points and penetration elsewhere, relative to the largest deflection."""

ROW_RANK = 1e-12
"""Relative eigenvalue of the rows' Gram matrix at which the active points do not resist a motion."""

CARRIED = 4e-15
"""Unbalanced load, relative to the forces, that counts as rounding."""

DAMPING = 1e-3
"""Least damping of the projection's Newton steps, per unit of the unbalanced load."""

STANDSTILL = 200
"""Steps without a smaller residual after which the iteration stops."""


@dataclass(eq=False)
class _Iterate:
    """Forces and derived quantities."""

    x: np.ndarray
    Sx: np.ndarray
    energy: float


def projected_cg(
    problem: ScaledProblem, start: np.ndarray | None = None, *, max_iterations: int | None = None
) -> Outcome:
    """Solve by projected conjugate gradients.

    Parameters
    ----------
    problem : ScaledProblem
        Problem; S may be an operator.
    start : ndarray of bool, shape (n,), optional
        Initial active set.
    max_iterations : int, optional
        Largest number of steps, 1000 + 2 n by default.

    Returns
    -------
    Outcome
        ``solved`` or ``iteration-limit``. The history is the largest gap on the active set or penetration.

    References
    ----------
    I. A. Polonsky, L. M. Keer, A numerical method for solving rough contact problems based on the multi-level
    multi-summation and conjugate gradient techniques, Wear 231 (1999) 206-219.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> problem = scale(np.eye(3), np.array([0.0, 0.0, 9.0]), np.ones((1, 3)), np.array([1.0]))
    >>> outcome = projected_cg(problem)
    >>> outcome.status.value, problem.forces(outcome.x).round(12).tolist()
    ('solved', [0.5, 0.5, 0.0])
    """
    limit = 1000 + 2 * problem.n if max_iterations is None else max_iterations
    guess = np.zeros(problem.n) if start is None else start.astype(float)
    at = _iterate(problem, project(problem.B, problem.F, guess)[0])
    safe_length = 0.0
    direction, weight, previous = np.zeros(problem.n), 0.0, 1.0
    history: list[float] = []
    p, best, best_nit = np.zeros(problem.r), np.inf, 0
    for nit in range(limit):
        gradient = at.Sx + problem.g
        touching = at.x > 0
        p = _multiplier(problem, at.x, gradient, touching)
        gap = gradient + problem.B.T @ p
        # the gap is small compared with the gradient: rounding along the rows would accumulate in the forces
        rest = _multiplier(problem, at.x, gap, touching)
        p, gap = p + rest, gap + problem.B.T @ rest
        scale = max(float(np.abs(at.Sx).max()), SMALLEST / CLOSED)
        entering = ~touching & (gap < -CLOSED * scale)
        left = np.where(touching, np.abs(gap), np.maximum(-gap, 0.0))
        history.append(float(left.max()))
        if history[-1] <= CLOSED * scale:
            return Outcome(at.x, p, Status.SOLVED, "solved", nit, history)
        if history[-1] < best:
            best, best_nit = history[-1], nit
        elif nit - best_nit > STANDSTILL:
            message = f"no progress in the last {STANDSTILL} steps"
            return Outcome(at.x, p, Status.ITERATION_LIMIT, message, nit, history)
        residual = np.where(touching, gap, 0.0)
        square = float(residual @ residual)
        direction = residual + weight * square / previous * direction
        direction[~touching] = 0.0
        previous = square if square > 0 else 1.0
        following = _step(problem, at, direction, gap, entering)
        weight = 1.0 if following is not None and not entering.any() and (following.x > 0)[touching].all() else 0.0
        if following is None:
            safe_length = safe_length or 1.0 / _largest_eigenvalue(problem)
            following = _iterate(problem, project(problem.B, problem.F, at.x - safe_length * gap)[0])
        at = following
    return Outcome(at.x, p, Status.ITERATION_LIMIT, f"{limit} steps were not enough", limit, history)


def project(B: np.ndarray, F: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nearest point to y with x >= 0 and B x = F.

    Parameters
    ----------
    B : ndarray, shape (r, n)
        Orthonormal rows.
    F : ndarray, shape (r,)
        A load that non-negative forces can balance.
    y : ndarray, shape (n,)

    Returns
    -------
    x : ndarray, shape (n,)
        The point.
    t : ndarray, shape (r,)
        Its multiplier.

    Notes
    -----
    x = max(y + B^T t, 0), where t minimises the convex, piecewise quadratic 1/2 |x|^2 - F . t in r unknowns:
    Newton's method, damped in proportion to the slope and more where a step fails.

    Examples
    --------
    >>> import numpy as np
    >>> project(np.full((1, 4), 0.5), np.array([1.0]), np.array([3.0, 2.0, 0.0, -1.0]))[0].round(12).tolist()
    [1.5, 0.5, 0.0, 0.0]
    """
    if len(F) == 0:
        return np.maximum(y, 0.0), F
    t, damping = F - B @ y, DAMPING
    x = np.maximum(y + B.T @ t, 0.0)
    value = 0.5 * (x @ x) - F @ t
    for _ in range(60):
        slope = B @ x - F
        size = float(np.linalg.norm(slope))
        if size <= CARRIED * (float(np.linalg.norm(F)) + float(np.linalg.norm(x)) + float(np.linalg.norm(y))):
            break
        rows = B[:, x > 0]
        step = np.linalg.lstsq(rows @ rows.T + damping * size * np.eye(len(F)), slope, rcond=None)[0]
        trial = np.maximum(y + B.T @ (t - step), 0.0)
        trial_value = 0.5 * (trial @ trial) - F @ (t - step)
        # near the end the value changes less than its rounding
        if trial_value <= value + SMALLEST * abs(value):
            t, x, value, damping = t - step, trial, trial_value, max(damping / 10, DAMPING)
        else:
            damping *= 10
    return x, t


def _iterate(problem: ScaledProblem, x: np.ndarray) -> _Iterate:
    Sx = np.asarray(problem.S @ x)
    return _Iterate(x, Sx, float(0.5 * (x @ Sx) + problem.g @ x))


def _multiplier(problem: ScaledProblem, x: np.ndarray, gradient: np.ndarray, touching: np.ndarray) -> np.ndarray:
    """Multiplier (r,) of least gap on the active points.

    Where these points leave a motion free, it is determined by the projection of a gradient step, whose multiplier is
    right once the step vanishes.
    """
    rows = problem.B[:, touching]
    p, _, rank, _ = np.linalg.lstsq(rows @ rows.T, -rows @ gradient[touching], rcond=ROW_RANK)
    return np.asarray(p if rank == problem.r else -project(problem.B, problem.F, x - gradient)[1])


def _step(
    problem: ScaledProblem, at: _Iterate, direction: np.ndarray, gap: np.ndarray, entering: np.ndarray
) -> _Iterate | None:
    """Step along -direction, with the entering points added; None if it does not lower the energy."""
    if not direction.any():
        direction = np.where(entering, gap, 0.0)
    S_direction = np.asarray(problem.S @ direction)
    curvature = float(direction @ S_direction)
    if curvature <= 0.0:
        return None
    length = float(gap @ direction) / curvature
    x = at.x - length * direction
    if x.min() >= 0.0 and not entering.any():
        Sx = at.Sx - length * S_direction
        return _Iterate(x, Sx, float(0.5 * (x @ Sx) + problem.g @ x))
    x = np.maximum(x, 0.0)
    x[entering] = -length * gap[entering]
    following = _iterate(problem, project(problem.B, problem.F, x)[0])
    # near the end the energy changes less than its rounding
    return following if following.energy <= at.energy + SMALLEST * abs(at.energy) else None


def _largest_eigenvalue(problem: ScaledProblem) -> float:
    """Return an upper estimate of the largest eigenvalue of S: twenty power iterations and a margin."""
    v = np.random.default_rng(0).uniform(0.5, 1.5, problem.n)
    size = 1.0
    for _ in range(20):
        v = np.asarray(problem.S @ (v / np.linalg.norm(v)))
        size = float(np.linalg.norm(v))
        if size == 0.0:
            return 1.0
    return 1.2 * size
