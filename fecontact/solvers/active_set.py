"""Primal-dual active set: the fastest solver; a few Cholesky solves, nearly independent of the number of points.

The step is Newton's on min(x, w) = 0 (Hintermueller, Ito & Kunisch 2002): solve on the active set, then remove the
points in tension and add those that penetrate. It can cycle, so it is safeguarded by block principal pivoting (Judice &
Pires 1994): where full exchanges have not lowered the number of wrong points for a while, only the last of them is
exchanged (Murty's rule) until the number falls. This terminates for a positive definite S.
"""

from __future__ import annotations

import numpy as np

from fecontact.solvers.equality import PointSet, first_touch, solve_on
from fecontact.solvers.problem import Outcome, Status
from fecontact.solvers.projected_cg import projected_cg
from fecontact.solvers.scaling import ScaledProblem

GUESSES = 10
"""Steps of projected conjugate gradients that give the first set; each costs a product instead of a factorisation."""

LOW_RANK = 3
"""Solves with mostly dependent points after which to give up: a method for singular compliances is faster."""

PATIENCE = 8
"""Full exchanges without progress before single exchanges."""

DEPENDENT_GAP = 1e-11
"""Gap below which a point that depends on the active ones counts as closed."""


def active_set(problem: ScaledProblem, start: np.ndarray | None = None, *, max_iterations: int = 100) -> Outcome:
    """Solve by the primal-dual active-set method.

    Parameters
    ----------
    problem : ScaledProblem
    start : ndarray of bool, shape (n,), optional
        Initial active set; by default from ten steps of projected conjugate gradients.
    max_iterations : int
        Largest number of solves.

    Returns
    -------
    Outcome
        ``solved``, or ``cycling``, ``singular`` or ``iteration-limit`` with the last iterate. The history is the
        largest tension or penetration.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> problem = scale(np.eye(3), np.array([0.0, 0.0, 9.0]), np.ones((1, 3)), np.array([1.0]))
    >>> outcome = active_set(problem)
    >>> outcome.status.value, problem.forces(outcome.x).round(12).tolist()
    ('solved', [0.5, 0.5, 0.0])
    """
    active = projected_cg(problem, max_iterations=GUESSES).x > 0 if start is None else start.copy()
    fewest, patience = problem.n + 1, PATIENCE
    low_rank = 0
    singles: set[bytes] = set()
    history: list[float] = []
    for nit in range(1, max_iterations + 1):
        point = solve_on(problem, np.flatnonzero(active))
        low_rank += 2 * len(point.dropped) > int(active.sum())
        active[point.dropped] = False
        if point.unbalanced.any():
            touched = first_touch(problem, point.unbalanced, np.where(active, np.inf, problem.gap(point.x, point.p)))
            if touched < 0:
                message = "the active points cannot balance the load and no other point comes into contact"
                return Outcome(point.x, point.p, Status.SINGULAR, message, nit, history)
            active[touched] = True
            continue
        wrong, worst = _wrong(problem, point, active)
        history.append(worst)
        count = int(wrong.sum())
        if count == 0:
            return Outcome(np.maximum(point.x, 0.0), point.p, Status.SOLVED, "solved", nit, history)
        if low_rank > LOW_RANK or (patience == 0 and len(point.dropped)):
            message = f"{len(point.dropped)} of {int(active.sum()) + len(point.dropped)} points depend on the others"
            return Outcome(point.x, point.p, Status.SINGULAR, message, nit, history)
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
    """Mask (n,) of points in tension or penetrating, and the largest violation."""
    gap, rounding = problem.gap_and_rounding(point.x, point.p)
    limit = np.full(problem.n, rounding)
    limit[point.dropped] = max(rounding, DEPENDENT_GAP * float(np.abs(gap).max()))
    pull = np.where(active, -point.x, 0.0)
    sink = np.where(active, 0.0, -gap)
    wrong = (pull > problem.rounding_of(point.x)) | (sink > limit)
    return wrong, float(max(pull.max(), sink.max()))
