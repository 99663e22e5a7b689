"""Non-negative least squares with equality rows: Lawson and Hanson's active set for any semidefinite compliance.

In the energy norm of S the problem is a non-negative least-squares problem, and Lawson & Hanson (1974, chapter 23)
solve it with feasible iterates: forces stay non-negative, the point with the most negative gap enters, and a step is
cut where a force would change its sign. Three things are added. The equality rows hold at every step, by elimination. A
point that depends on the active ones (singular S, duplicate points) is exchanged along the direction without energy
instead of entering (Gill, Murray, Saunders & Wright 1991), so the active set stays independent. After many steps of
length zero the smallest index decides (Bland), so that ties cannot cycle. The energy never increases, hence the method
terminates.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import nnls as plain_nnls

from fecontact.solvers.problem import Outcome, Status
from fecontact.solvers.scaling import ROUNDING, ScaledProblem

DEPENDENT = 1e-13
"""Squared Cholesky pivot (of a matrix of unit diagonal) at which a point depends on the active ones."""

NEWCOMER = 1e-10
"""A tension of the last point to enter, up to this share, is rounding and set to zero."""

SPURIOUS = 1e-9
"""Penetration of a dependent point that no force removes, for data of order one: rounding times the set's condition."""

PATIENCE = 30
"""Steps of length zero in a row before the smallest index decides."""


class _TouchingSet:
    """Active points in order of entry, and the Cholesky factor of S + B^T B on them."""

    def __init__(self, problem: ScaledProblem) -> None:
        self.problem = problem
        self.points: list[int] = []
        self._L = np.zeros((16, 16), order="F")

    def _factor(self) -> np.ndarray:
        return self._L[: len(self.points), : len(self.points)]

    def _column(self, k: int) -> np.ndarray:
        B = self.problem.B
        return np.asarray(self.problem.matrix[k, self.points] + B[:, k] @ B[:, self.points])

    def enter(self, k: int) -> np.ndarray | None:
        """Add a point; if it depends on the others, add nothing and return the direction, shape (a,), without energy.

        Along it the force at k grows by one and those at the active points change by the direction.
        """
        row = solve_triangular(self._factor(), self._column(k), lower=True, check_finite=False)
        B = self.problem.B[:, k]
        pivot = self.problem.matrix[k, k] + B @ B - row @ row
        if pivot <= DEPENDENT:
            return -solve_triangular(self._factor(), row, lower=True, trans=1, check_finite=False)
        size = len(self.points)
        if size == len(self._L):
            larger = np.zeros((2 * size, 2 * size), order="F")
            larger[:size, :size] = self._L
            self._L = larger
        self._L[size, :size] = row
        self._L[size, size] = np.sqrt(pivot)
        self.points.append(k)
        return None

    def leave(self, position: int) -> None:
        """Remove the point at a position; only the factor behind it changes."""
        size = len(self.points)
        gone = self._L[position + 1 : size, position].copy()
        behind = self._L[position + 1 : size, position + 1 : size]
        block = behind @ behind.T + np.outer(gone, gone)
        self._L[position : size - 1, :position] = self._L[position + 1 : size, :position]
        self._L[position : size - 1, position : size - 1] = np.linalg.cholesky(block)
        self._L[size - 1, :] = 0.0
        del self.points[position]

    def solve(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the forces (a,) and the multiplier (r,) that close the gaps of the points and carry the load."""
        B = self.problem.B[:, self.points]
        right = np.column_stack([B.T @ self.problem.F - self.problem.g[self.points], B.T])
        half = solve_triangular(self._factor(), right, lower=True, check_finite=False)
        schur = half[:, 1:].T @ half[:, 1:]
        # the least-norm multiplier: some motions may not be resisted by these points
        p, _, rank, _ = np.linalg.lstsq(schur, half[:, 1:].T @ half[:, 0] - self.problem.F, rcond=DEPENDENT)
        if rank == len(self.points):
            # the load alone decides; gaps many orders larger would leave their rounding
            return np.linalg.lstsq(B, self.problem.F, rcond=None)[0], p
        rest = half[:, 0] - half[:, 1:] @ p
        return solve_triangular(self._factor(), rest, lower=True, trans=1, check_finite=False), p


def nnls(problem: ScaledProblem, start: np.ndarray | None = None, *, max_iterations: int | None = None) -> Outcome:
    """Solve by Lawson and Hanson's method with equality rows.

    Parameters
    ----------
    problem : ScaledProblem
    start : ndarray of bool, shape (n,), optional
        Initial active set.
    max_iterations : int, optional
        Largest number of steps, 10 per point by default.

    Returns
    -------
    Outcome
        ``solved``, ``unbounded`` or ``iteration-limit``. The history is the largest penetration.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> twins = scale(np.ones((2, 2)), np.array([0.5, 0.0]), np.ones((1, 2)), np.array([1.0]))
    >>> outcome = nnls(twins)
    >>> outcome.status.value, twins.forces(outcome.x).round(12).tolist()
    ('solved', [0.0, 1.0])
    """
    x = _carried(problem, start)
    touching = _TouchingSet(problem)
    wanted = (
        np.flatnonzero(x) if start is None else np.concatenate([np.flatnonzero(x), np.flatnonzero(start & (x == 0))])
    )
    for k in wanted:
        touching.enter(int(k))
    limit = 10 * problem.n + 50 if max_iterations is None else max_iterations
    history: list[float] = []
    idle = 0
    refused = np.zeros(problem.n, dtype=bool)
    p = np.zeros(problem.r)
    for nit in range(limit):
        target, p = touching.solve()
        points = np.array(touching.points, dtype=int)
        if -NEWCOMER * np.abs(target).max(initial=0.0) < target[-1:].min(initial=0.0) < 0.0:
            target[-1] = 0.0
        if target.min(initial=0.0) < -problem.rounding_of(target):
            length, position = _cut(x[points], target - x[points], idle > PATIENCE, points)
            x[points] = np.maximum(x[points] + length * (target - x[points]), 0.0)
            k = int(points[position])
            x[k] = 0.0
            touching.leave(position)
            # a point in tension as soon as it enters was added by rounding
            if length == 0.0 and position == len(points) - 1:
                refused[k] = True
            idle = idle + 1 if length == 0.0 else 0
            if length > 0.0:
                refused[:] = False
            continue
        x[points] = np.maximum(target, 0.0)
        k, deepest = _entering(problem, x, p, points, refused, idle > PATIENCE)
        history.append(deepest)
        if k < 0:
            return Outcome(x, p, Status.SOLVED, "solved", nit, history)
        direction = touching.enter(k)
        if direction is None:
            continue
        length, position = _cut(x[points], direction, idle > PATIENCE, points)
        if position < 0 and deepest <= SPURIOUS:
            refused[k] = True
            continue
        if position < 0:
            message = "interference that no deflection and no motion removes: forces grow without limit"
            return Outcome(x, p, Status.UNBOUNDED, message, nit, history)
        x[points] = np.maximum(x[points] + length * direction, 0.0)
        x[k] += length
        x[points[position]] = 0.0
        touching.leave(position)
        touching.enter(k)
        idle = idle + 1 if length == 0.0 else 0
    return Outcome(x, p, Status.ITERATION_LIMIT, f"{limit} steps were not enough", limit, history)


def _carried(problem: ScaledProblem, start: np.ndarray | None) -> np.ndarray:
    """Return forces (n,) that balance the load on at most r points, if possible among those of `start`."""
    x = np.zeros(problem.n)
    if not problem.F.any():
        return x
    if start is not None and start.any():
        x[start], distance = plain_nnls(problem.B[:, start], problem.F)
        if distance <= ROUNDING * float(np.linalg.norm(problem.F)):
            return x
        x[:] = 0.0
    return np.asarray(plain_nnls(problem.B, problem.F, maxiter=30 * problem.n + 100)[0])


def _cut(x: np.ndarray, step: np.ndarray, smallest: bool, points: np.ndarray) -> tuple[float, int]:
    """Longest step that leaves x + length * step >= 0, and the position that limits it (-1: none)."""
    falling = np.flatnonzero(step < -ROUNDING * np.abs(step).max(initial=0.0))
    if falling.size == 0:
        return np.inf, -1
    lengths = x[falling] / -step[falling]
    length = float(lengths.min())
    tied = falling[lengths <= length]
    # of tied points: the steepest keeps the factor well conditioned, the smallest index cannot cycle
    position = tied[points[tied].argmin()] if smallest else tied[step[tied].argmin()]
    return length, int(position)


def _entering(
    problem: ScaledProblem, x: np.ndarray, p: np.ndarray, points: np.ndarray, refused: np.ndarray, smallest: bool
) -> tuple[int, float]:
    """Point to enter (-1: none) and the largest penetration."""
    gap, rounding = problem.gap_and_rounding(x, p)
    gap[points] = 0.0
    deepest = -float(gap.min())
    candidates = np.flatnonzero((gap < -rounding) & ~refused)
    if candidates.size == 0:
        return -1, deepest
    return int(candidates[0] if smallest else candidates[gap[candidates].argmin()]), deepest
