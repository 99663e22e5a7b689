"""Sharpen an answer on the points it says are in touch, so that all solvers agree to the last digits.

A claim is not improved by more of the same iteration but by solving the equality problem on its set. Where the
points of the set depend on each other the forces are not unique; then the smallest change of the forces that closes
the gaps and carries the load is made instead, which keeps them positive.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lstsq

from fecontact.solvers.active_set import active_set
from fecontact.solvers.outcome import Outcome
from fecontact.solvers.problem import Status
from fecontact.solvers.scaling import ROUNDING, ScaledProblem

NEGLIGIBLE = 1e-12
"""Relative singular value that the smallest change ignores."""


def polish(problem: ScaledProblem, x: np.ndarray, p: np.ndarray, *, solves: int) -> list[Outcome]:
    """Better candidates for an answer, none of them checked.

    Parameters
    ----------
    problem : ScaledProblem
    x : ndarray, shape (n,)
    p : ndarray, shape (r,)
    solves : int
        Equality solves allowed: one for an exact method, a few for one that stops short of the set.

    Returns
    -------
    list of Outcome
        With status ``solved``; empty if there is nothing to offer.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> problem = scale(np.eye(2), np.array([-1.0, 1.0]), np.empty((0, 2)), np.empty(0))
    >>> polish(problem, np.array([0.999, 1e-5]), np.empty(0), solves=1)[0].x.tolist()
    [1.0, 0.0]
    """
    # a force that is rounding must not hold a motion that is open
    touching = x > np.maximum(problem.gap(x, p), ROUNDING * x.max())
    solved = active_set(problem, touching, max_iterations=solves)
    if solved.status is Status.SOLVED:
        return [solved]
    changed = _smallest_change(problem, x, p, touching)
    return [Outcome(np.maximum(changed[0], 0.0), changed[1], Status.SOLVED, "solved", 0)]


def _smallest_change(
    problem: ScaledProblem, x: np.ndarray, p: np.ndarray, touching: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return forces on the touching points and multiplier after two least-norm corrections."""
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
