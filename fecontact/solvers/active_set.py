"""Primal-dual active set: the fastest solver; a few Cholesky solves, nearly independent of the number of points.

The step is Newton's on min(x, w) = 0 (Hintermueller, Ito & Kunisch 2002): solve on the active set, then remove the
points in tension and add those that penetrate. It can cycle, so it is safeguarded by block principal pivoting (Judice &
Pires 1994): where full exchanges have not lowered the number of wrong points for a while, only the last of them is
exchanged (Murty's rule) until the number falls. This terminates for a positive definite S.

Contact problem on a given active set: one symmetric solve with the rigid motion eliminated.

    S_AA x_A + B_A^T p = -g_A,     B_A x_A = F,     x = 0 elsewhere

The rows of B on the set are orthonormalised to V, and V^T V is added to S_AA. On B x = F this changes only the
multiplier. It makes the block positive definite whenever the equality problem has a unique solution, even where S is
singular (rigid bodies). It is not a penalty: the rows hold exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve
from scipy.linalg.lapack import dpotrf, dpstrf

from fecontact.solvers.problem import Outcome, Status
from fecontact.solvers.projected_cg import projected_cg
from fecontact.solvers.scaling import ScaledProblem

DEPENDENT = 1e-12
"""Squared Cholesky pivot (of a matrix of unit diagonal) at which a point depends on the others of its set."""

NEARLY_DEPENDENT_ROW = 1e-9
"""Singular value of the orthonormal rows restricted to the set, at which the set does not resist that motion."""


@dataclass(frozen=True, eq=False)
class PointSet:
    """Solution of the equality problem on a set of points.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Forces, zero outside the set; of any sign.
    p : ndarray, shape (r,)
        Multiplier; of least norm where the set does not resist a motion.
    unbalanced : ndarray, shape (r,)
        Part of the load that forces on the set cannot balance; usually zero.
    dropped : ndarray of int
        Points of the set that depend on the others; their force is zero and their gap follows.
    """

    x: np.ndarray
    p: np.ndarray
    unbalanced: np.ndarray
    dropped: np.ndarray


def solve_on(problem: ScaledProblem, points: np.ndarray) -> PointSet:
    """Solve the equality problem on `points`, with one step of iterative refinement.

    Parameters
    ----------
    problem : ScaledProblem
    points : ndarray of int, shape (a,)

    Returns
    -------
    PointSet

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> problem = scale(np.eye(3), np.zeros(3), np.ones((1, 3)), np.array([1.0]))
    >>> (problem.forces(solve_on(problem, np.array([0, 1])).x) + 0.0).round(12).tolist()
    [0.5, 0.5, 0.0]
    """
    U, s, V = _rows_on(problem, points)
    load = (U.T @ problem.F) / s
    unbalanced = _unbalanced(problem.F, U)
    S = problem.matrix[np.ix_(points, points)]
    factor, kept = _factor(S, V)
    x, p = np.zeros(problem.n), np.zeros(len(s))
    dropped = points[~kept]
    points, V = points[kept], V[:, kept]
    if len(dropped):
        S = S[np.ix_(kept, kept)]
    Y = cho_solve((factor, True), V.T, check_finite=False)
    schur = V @ Y
    x_A = np.zeros(len(points))
    for _ in range(2):
        rest = -problem.g[points] - S @ x_A - V.T @ p
        missing = load - V @ x_A
        step = cho_solve((factor, True), rest + V.T @ missing, check_finite=False)
        p_step = np.linalg.lstsq(schur, V @ step - missing, rcond=None)[0]
        x_A = x_A + step - Y @ p_step
        p = p + p_step
    x[points] = x_A
    return PointSet(x, U @ (p / s), unbalanced, dropped)


def first_touch(problem: ScaledProblem, unbalanced: np.ndarray, gap: np.ndarray) -> int:
    """Point whose gap closes first when the bodies move along the unbalanced load.

    Parameters
    ----------
    problem : ScaledProblem
    unbalanced : ndarray, shape (r,)
        The motion goes along -unbalanced.
    gap : ndarray, shape (n,)
        Initial gap; infinite for points to be ignored.

    Returns
    -------
    int
        The point, or -1 if the motion closes no gap.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> problem = scale(np.eye(3), np.array([2.0, 1.0, 3.0]), np.ones((1, 3)), np.array([1.0]))
    >>> first_touch(problem, problem.F, problem.g)
    1
    """
    closing = problem.B.T @ unbalanced
    candidates = (closing > NEARLY_DEPENDENT_ROW * np.linalg.norm(unbalanced)) & np.isfinite(gap)
    if not candidates.any():
        return -1
    distance = np.full(problem.n, np.inf)
    np.divide(gap, closing, out=distance, where=candidates)
    return int(distance.argmin())


def least_motion(problem: ScaledProblem, points: np.ndarray, p: np.ndarray) -> np.ndarray:
    """The least motion (r,) that is the same as p where points (a,) touch; p itself where they resist all of it."""
    resisted = _rows_on(problem, points)[0]
    return p if resisted.shape[1] == problem.r else resisted @ (resisted.T @ p)


def _rows_on(problem: ScaledProblem, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Singular vectors U (r, k), V (k, a) and values (k,) of the motions that points (a,) resist."""
    if problem.r == 0 or len(points) == 0:
        return np.zeros((problem.r, 0)), np.empty(0), np.zeros((0, len(points)))
    U, s, V = np.linalg.svd(problem.B[:, points], full_matrices=False)
    rank = int((s > NEARLY_DEPENDENT_ROW).sum())
    return U[:, :rank], s[:rank], V[:rank]


def _unbalanced(F: np.ndarray, U: np.ndarray) -> np.ndarray:
    rest = F - U @ (U.T @ F)
    return np.zeros_like(F) if np.linalg.norm(rest) <= NEARLY_DEPENDENT_ROW * np.linalg.norm(F) else rest


def _factor(S: np.ndarray, V: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower Cholesky factor of S + V^T V, restricted to an independent subset of points where it is singular."""
    size = len(S)
    kept = np.ones(size, dtype=bool)
    if size == 0:
        return np.empty((0, 0)), kept
    # the transpose is the same matrix in Fortran order: LAPACK factorises it in place, without a copy
    factor, info = dpotrf((S + V.T @ V).T, lower=1, clean=0, overwrite_a=1)
    if info == 0 and (factor.diagonal() ** 2).min() > DEPENDENT:
        return factor, kept
    H = S + V.T @ V
    _, order, rank, _ = dpstrf(H, tol=DEPENDENT * H.diagonal().max(), lower=1)
    kept[order[rank:] - 1] = False
    # the kept points were chosen by pivoting: plain Cholesky is safe on them
    factor, _ = dpotrf(H[np.ix_(kept, kept)], lower=1, clean=0)
    return factor, kept


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
