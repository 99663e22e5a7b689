"""Lemke's complementary pivoting: finite for every positive semidefinite compliance, singular ones included.

The equilibrium rows are eliminated exactly first: r points far apart are exchanged with the r multipliers. That is a
principal pivot, so what remains is a standard complementarity problem y = M z + h, y, z >= 0, y . z = 0, with M
positive semidefinite, on which Lemke's method ends with a solution, or on a ray if none exists (Lemke 1965; Cottle,
Pang & Stone 1992, chapter 4). Ties are decided lexicographically.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import qr

from fecontact.solvers.outcome import Outcome
from fecontact.solvers.problem import Status
from fecontact.solvers.scaling import SMALLEST, ScaledProblem
from fecontact.solvers.tableau import Dictionary

CLOSED = 1e-12
"""Covering variable that counts as zero, for data of order one: a ray there is a solution."""


def lemke(problem: ScaledProblem, start: np.ndarray | None = None, *, max_iterations: int | None = None) -> Outcome:
    """Solve by complementary pivoting.

    Parameters
    ----------
    problem : ScaledProblem
    start : ignored
        Ignored: complementary pivoting has its own start.
    max_iterations : int, optional
        Largest number of pivots, 20 per point by default.

    Returns
    -------
    Outcome
        ``solved``, ``ray`` (no answer exists) or ``iteration-limit``. The history is the covering variable.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> twins = scale(np.ones((2, 2)), np.array([0.0, 0.5]), np.ones((1, 2)), np.array([1.0]))
    >>> outcome = lemke(twins)
    >>> outcome.status.value, twins.forces(outcome.x).round(12).tolist()
    ('solved', [1.0, 0.0])
    """
    far = _far_points(problem.B)
    M, h = _without_rows(problem, far)
    limit = 20 * problem.n + 50 if max_iterations is None else max_iterations
    z, status, message, history = _complementary(M, h, limit)
    y = M @ z + h
    x = np.maximum(z, 0.0)
    x[far] = np.maximum(y[far], 0.0)
    rest = z[far] - problem.g[far] - problem.matrix[far] @ x
    return Outcome(x, np.linalg.solve(problem.B[:, far].T, rest), status, message, len(history), history)


def _far_points(B: np.ndarray) -> np.ndarray:
    """As many points (r,) as there are rows, chosen so that the rows on them are well conditioned."""
    if len(B) == 0:
        return np.empty(0, dtype=int)
    return np.asarray(qr(B, mode="r", pivoting=True)[1][: len(B)], dtype=int)


def _without_rows(problem: ScaledProblem, far: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """M (n, n) and h (n,) of the complementarity problem left when the rows are eliminated.

    z is the gap at the far points and the force elsewhere; y is the other of the two.
    """
    S, B, g = problem.matrix, problem.B, problem.g
    others = np.setdiff1d(np.arange(problem.n), far)
    at_far = np.linalg.solve(B[:, far], np.column_stack([problem.F, B[:, others]]))
    forces, N = at_far[:, 0], at_far[:, 1:]
    S_far, cross = S[np.ix_(far, far)], S[np.ix_(far, others)]
    coupling = N.T @ (cross - S_far @ N / 2)
    M, h = np.zeros_like(S), np.empty(problem.n)
    M[np.ix_(others, others)] = S[np.ix_(others, others)] - coupling - coupling.T
    M[np.ix_(others, far)] = N.T
    M[np.ix_(far, others)] = -N
    h[far] = forces
    h[others] = g[others] - N.T @ (g[far] + S_far @ forces) + cross.T @ forces
    return M, h


def _complementary(M: np.ndarray, h: np.ndarray, limit: int) -> tuple[np.ndarray, Status, str, list[float]]:
    """Return z of y = M z + h, y, z >= 0, y . z = 0. Names: y_k is k, z_k is n + k, the covering variable 2 n."""
    n = len(h)
    cover = 2 * n
    history: list[float] = []
    z = np.zeros(n)
    if h.min() >= -SMALLEST:
        return z, Status.SOLVED, "solved", history
    table = Dictionary(np.column_stack([M, np.ones(n)]), h, np.arange(n), np.arange(n, cover + 1))
    row = table.lowest(np.arange(n))
    left = int(table.row_names[row])
    table.exchange(row, n)
    cover_row = row
    while left != cover and len(history) < limit:
        history.append(float(table.h[cover_row]))
        entering = left + n if left < n else left - n
        column = int(np.flatnonzero(table.column_names == entering)[0])
        row = table.blocking(column, prefer=cover_row)
        if row < 0 and history[-1] > CLOSED:
            return z, Status.RAY, "complementary pivoting ended on a ray: no answer exists", history
        if row < 0:
            left = cover
            break
        left = int(table.row_names[row])
        table.exchange(row, column)
    basic = (table.row_names >= n) & (table.row_names < cover)
    z[table.row_names[basic] - n] = table.h[basic]
    if left != cover:
        return z, Status.ITERATION_LIMIT, f"{limit} pivots were not enough", history
    return z, Status.SOLVED, "solved", history
