"""Primal-dual active set: the fast solver, five or six Cholesky solves whatever the number of points.

The step is Newton's on min(x, w) = 0 (Hintermueller, Ito & Kunisch 2002): solve with the points thought to touch,
then let go of those that pull and take in those that penetrate. It is finite in practice but can cycle, so it
carries the safeguard of block principal pivoting (Judice & Pires 1994): where a full exchange has not lowered the
number of wrong points for a while, only the last of them is exchanged (Murty's rule) until it has. That is finite
for a positive definite S.
"""

from __future__ import annotations

import numpy as np

from fecontact.solvers.equality import PointSet, first_touch, solve_on
from fecontact.solvers.outcome import Outcome
from fecontact.solvers.problem import Status
from fecontact.solvers.scaling import ScaledProblem

PATIENCE = 8
"""Full exchanges without progress before single ones."""

ROUNDING = 1e-13
"""A force or a gap of this size, relative to the largest in its solve, has no sign."""

DEPENDENT_GAP = 1e-11
"""The same for the gap of a point that depends on others in touch: it closes only as exactly as it depends."""


def active_set(problem: ScaledProblem, start: np.ndarray | None = None, *, max_iterations: int = 200) -> Outcome:
    """Solve by the primal-dual active-set method.

    Parameters
    ----------
    problem : ScaledProblem
    start : ndarray of bool, shape (n,), optional
        Points thought to touch.
    max_iterations : int
        Largest number of solves.

    Returns
    -------
    Outcome
        ``solved``, or ``cycling`` / ``iteration-limit`` / ``unbounded`` with the last iterate.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> problem = scale(np.eye(3), np.array([0.0, 0.0, 9.0]), np.ones((1, 3)), np.array([1.0]))
    >>> outcome = active_set(problem)
    >>> outcome.status.value, problem.forces(outcome.x).round(12).tolist()
    ('solved', [0.5, 0.5, 0.0])
    """
    active = problem.g < 0 if start is None else start.copy()
    if start is None and problem.r:
        active[:] = False
    fewest, patience = problem.n + 1, PATIENCE
    singles: set[bytes] = set()
    history: list[float] = []
    for nit in range(1, max_iterations + 1):
        point = solve_on(problem, np.flatnonzero(active))
        active[point.dropped] = False
        if point.unbalanced.any():
            touched = first_touch(problem, point.unbalanced, np.where(active, np.inf, problem.gap(point.x, point.p)))
            if touched < 0:
                message = "the points thought to touch cannot carry the load and no other point comes into touch"
                return Outcome(point.x, point.p, Status.SINGULAR, message, nit, history)
            active[touched] = True
            continue
        wrong, worst = _wrong(problem, point, active)
        history.append(worst)
        count = int(wrong.sum())
        if count == 0:
            return Outcome(np.maximum(point.x, 0.0), point.p, Status.SOLVED, "solved", nit, history)
        if count < fewest:
            fewest, patience = count, PATIENCE
            singles.clear()
        elif patience > 0:
            patience -= 1
        else:
            key = np.packbits(active).tobytes()
            if key in singles:
                message = f"the active sets came back after {nit} solves with {count} wrong points"
                return Outcome(point.x, point.p, Status.CYCLING, message, nit, history)
            singles.add(key)
            wrong[: np.flatnonzero(wrong)[-1]] = False
        active = active ^ wrong
    message = f"{max_iterations} solves were not enough"
    return Outcome(point.x, point.p, Status.ITERATION_LIMIT, message, max_iterations, history)


def _wrong(problem: ScaledProblem, point: PointSet, active: np.ndarray) -> tuple[np.ndarray, float]:
    """Points that pull or penetrate, shape (n,), and the largest violation."""
    deflection = problem.S @ point.x
    rigid = problem.g + problem.B.T @ point.p
    gap = deflection + rigid
    scale = max(float(np.abs(deflection).max()), float(np.abs(rigid).max()))
    limit = np.full(problem.n, ROUNDING)
    limit[point.dropped] = DEPENDENT_GAP
    pull = np.where(active, -point.x, 0.0)
    sink = np.where(active, 0.0, -gap)
    wrong = (pull > ROUNDING * np.abs(point.x).max()) | (sink > limit * scale)
    return wrong, float(max(pull.max(), sink.max()))
