"""Polish an answer on its active set, so that all solvers agree to rounding.

The equality problem is solved on the active set. Where its points depend on each other the forces are not unique; then
the smallest change of the forces that closes the gaps and balances the load is made, which keeps them positive.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lstsq

from fecontact.solvers.active_set import active_set
from fecontact.solvers.outcome import Outcome
from fecontact.solvers.problem import Status
from fecontact.solvers.scaling import ROUNDING, ScaledProblem

NEGLIGIBLE = 1e-12
"""Relative singular value ignored by the least-norm correction."""


def polish(problem: ScaledProblem, x: np.ndarray, p: np.ndarray, *, solves: int) -> list[Outcome]:
    """Improved candidates for an answer, unverified.

    Parameters
    ----------
    problem : ScaledProblem
    x : ndarray, shape (n,)
    p : ndarray, shape (r,)
    solves : int
        Equality solves allowed: one for an exact method, a few for one whose set may be inexact.

    Returns
    -------
    list of Outcome
        With status ``solved``; may be empty.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> problem = scale(np.eye(2), np.array([-1.0, 1.0]), np.empty((0, 2)), np.empty(0))
    >>> polish(problem, np.array([0.999, 1e-5]), np.empty(0), solves=1)[0].x.tolist()
    [1.0, 0.0]
    """
    # a force of rounding size must not resist a free motion
    touching = x > np.maximum(problem.gap(x, p), ROUNDING * x.max())
    solved = active_set(problem, touching, max_iterations=solves)
    if solved.status is Status.SOLVED:
        return [solved]
    changed = _smallest_change(problem, x, p, touching)
    return [Outcome(np.maximum(changed[0], 0.0), changed[1], Status.SOLVED, "solved", 0)]


def _smallest_change(
    problem: ScaledProblem, x: np.ndarray, p: np.ndarray, touching: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return forces on the active points and the multiplier after two least-norm corrections."""
    points = np.flatnonzero(touching)
    rows = problem.B[:, points]
    K = np.block([[problem.matrix[np.ix_(points, points)], rows.T], [rows, np.zeros((problem.r, problem.r))]])
    x, p = np.where(touching, x, 0.0), p.copy()
    for _ in range(2):
        missing = np.concatenate([-problem.gap(x, p)[points], problem.F - problem.B @ x])
        change = lstsq(K, missing, cond=NEGLIGIBLE, lapack_driver="gelsy")[0] if len(missing) else missing
        x[points] += change[: len(points)]
        p += change[len(points) :]
    return x, p
