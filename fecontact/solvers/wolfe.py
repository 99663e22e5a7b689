"""Wolfe's simplex for quadratic programmes (1959), short form: the reference solver.

The rows w - S l - B^T q = g and B l = F get artificial variables, and the simplex method drives these to zero with one
restriction: a force and the gap of the same point are never basic together (a force may enter where the gap of its own
point leaves, and the other way round). The multiplier q has any sign: its parts q+ and q- share one column, which may
rise or fall and, once basic, never blocks.

Order as in Wolfe's paper: first the load rows with only forces entering, then the others. One objective for both sets
of artificials can end with an unbalanced load, even for a positive definite S: once all gaps are basic no force may
enter.

Limits: the short form needs S positive definite on the null space of B, or g in the range of S. Otherwise artificials
may stay positive; this is reported as status ``artificial`` and never returned as a solution. Use ``nnls``
then.

A simplex dictionary: basic variables as affine functions of the nonbasic ones, exchanged in place.

    basic = T @ nonbasic + h

Only nonbasic columns are stored, never the identity of the basic ones. A second right-hand side of generic numbers is
an infinitesimal perturbation of the first. Comparing h first and then the perturbation is the lexicographic rule: no
basis repeats and no tie remains (Charnes 1952).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.blas import dger

from fecontact.solvers.problem import Outcome, Status
from fecontact.solvers.scaling import SMALLEST, ScaledProblem

PIVOT = 1e-10
"""Entries of a tableau of order one below this size are rounding and never pivots."""

TIE = 1e-12
"""Ratios that differ by less than this share are a tie, decided by the perturbation."""


class Dictionary:
    """Dictionary with named rows and columns; changed in place by `exchange`.

    Parameters
    ----------
    T : ndarray, shape (rows, columns)
    h : ndarray, shape (rows,)
        Values of the basic variables.
    row_names, column_names : ndarray of int
        Basic variable of each row, nonbasic variable of each column.
    """

    def __init__(self, T: np.ndarray, h: np.ndarray, row_names: np.ndarray, column_names: np.ndarray) -> None:
        rows, columns = T.shape
        # Fortran order, so that the rank-one update works in place
        self._all = np.empty((rows, columns + 2), order="F")
        self._all[:, :columns] = T
        self._all[:, columns] = h
        self._all[:, columns + 1] = np.random.default_rng(1959).uniform(0.5, 1.5, rows)
        self.row_names = row_names.copy()
        self.column_names = column_names.copy()

    @property
    def T(self) -> np.ndarray:
        """Coefficients, a view of shape (rows, columns)."""
        return self._all[:, :-2]

    @property
    def h(self) -> np.ndarray:
        """Values of the basic variables, a view of shape (rows,)."""
        return self._all[:, -2]

    @property
    def perturbation(self) -> np.ndarray:
        """Values of the infinitesimal perturbation, a view of shape (rows,)."""
        return self._all[:, -1]

    def negate_row(self, row: int | np.ndarray) -> None:
        """Replace a basic variable by its negative."""
        self._all[row] *= -1.0

    def reset_perturbation(self, rows: np.ndarray) -> None:
        """Restart the lexicographic order from the present basis, where the variables of `rows` are bounded."""
        self.perturbation[rows] = np.random.default_rng(1959).uniform(0.5, 1.5, int(rows.sum()))

    def blocking(self, column: int, sign: float = 1.0, rows: np.ndarray | None = None) -> int:
        """Row whose variable reaches zero first when a nonbasic one grows (sign 1) or falls (sign -1).

        Parameters
        ----------
        column : int
        sign : float
        rows : ndarray of bool, shape (rows,), optional
            Rows that can block; all by default.

        Returns
        -------
        int
            -1 if none does.
        """
        entries = sign * self._all[:, column]
        can = entries < -PIVOT * max(1.0, float(np.abs(entries).max()))
        candidates = np.flatnonzero(can if rows is None else can & rows)
        if candidates.size == 0:
            return -1
        falls = -entries[candidates]
        ratios = self.h[candidates] / falls
        tied = ratios <= ratios.min() + TIE * abs(ratios.min()) + SMALLEST
        candidates, falls = candidates[tied], falls[tied]
        return int(candidates[(self.perturbation[candidates] / falls).argmin()])

    def exchange(self, row: int, column: int) -> None:
        """Make the column's variable basic in the row and the row's variable nonbasic in the column."""
        new_row = self._all[row] / -self._all[row, column]
        old_column = self._all[:, column].copy()
        new_row[column] = 1.0 / self._all[row, column]
        old_column[row] = 0.0
        self._all[row] = 0.0
        self._all[:, column] = 0.0
        dger(1.0, old_column, new_row, a=self._all, overwrite_a=1)
        self._all[row] = new_row
        self.row_names[row], self.column_names[column] = self.column_names[column], self.row_names[row]


LEFT_POSITIVE = 1e-10
"""Sum of the artificial variables, relative to its first value, that counts as zero."""

ROUNDING = 1e-14
"""The same as an absolute number, for data of order one."""

DEAD = -1
"""Name of a column whose artificial variable is eliminated."""


def wolfe(problem: ScaledProblem, start: np.ndarray | None = None, *, max_iterations: int | None = None) -> Outcome:
    """Solve by Wolfe's simplex with restricted basis entry.

    Parameters
    ----------
    problem : ScaledProblem
    start : ignored
        Ignored: the simplex has its own start.
    max_iterations : int, optional
        Largest number of pivots, 20 per point by default.

    Returns
    -------
    Outcome
        ``solved``, ``artificial`` or ``iteration-limit``. The history is the sum of the artificial variables.

    Notes
    -----
    Names: l_k is k, w_k is n + k, z_k (artificial of the gap row k) 2 n + k, q_j 3 n + j, the artificial of load
    row j is 3 n + r + j. As long as z_k is basic, the column of w_k is a single entry in the same row and is not
    stored; when z_k leaves, its column becomes that of w_k. So the tableau has n columns and n + r rows.

    References
    ----------
    P. Wolfe, The simplex method for quadratic programming, Econometrica 27 (1959) 382-398.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> problem = scale(np.eye(3), np.array([0.0, 0.0, 9.0]), np.ones((1, 3)), np.array([1.0]))
    >>> outcome = wolfe(problem)
    >>> outcome.status.value, problem.forces(outcome.x).round(12).tolist()
    ('solved', [0.5, 0.5, 0.0])
    """
    n, r = problem.n, problem.r
    table = _table(problem)
    loads = _carry_loads(table, n, r)
    limit = 20 * n + 50 if max_iterations is None else max_iterations
    history, pivots, ended = _remove_artificials(table, n, r, limit)
    names = table.row_names
    x, p = np.zeros(n), np.zeros(r)
    forces, motions = names < n, (names >= 3 * n) & (names < 3 * n + r)
    x[names[forces]] = np.maximum(table.h[forces], 0.0)
    p[names[motions] - 3 * n] = table.h[motions]
    nit = loads + pivots
    if history and history[-1] > max(LEFT_POSITIVE * history[0], ROUNDING):
        status = Status.ARTIFICIAL if ended else Status.ITERATION_LIMIT
        count = int(((names >= 2 * n) & (names < 3 * n) & (table.h > ROUNDING)).sum())
        message = f"{count} artificial variables were left positive after {nit} pivots, their sum is {history[-1]:.2e}"
        return Outcome(x, p, status, message, nit, history)
    return Outcome(x, p, Status.SOLVED, "solved", nit, history)


def _table(problem: ScaledProblem) -> Dictionary:
    """Set up z = S l + B^T q + g in the gap rows (w left out, see the notes), v = +-(F - B l) in the load rows."""
    n, r = problem.n, problem.r
    sign = np.where(problem.F < 0, -1.0, 1.0)
    T = np.zeros((n + r, n + r))
    T[:n, :n] = problem.matrix
    T[:n, n:] = problem.B.T
    T[n:, :n] = -sign[:, None] * problem.B
    names = np.concatenate([np.arange(n), 3 * n + np.arange(r)])
    rows = np.concatenate([2 * n + np.arange(n), 3 * n + r + np.arange(r)])
    return Dictionary(T, np.concatenate([problem.g, sign * problem.F]), rows, names)


def _carry_loads(table: Dictionary, n: int, r: int) -> int:
    """Drive the artificials of the load rows to zero with forces alone; the gap rows have no sign yet.

    Returns the number of pivots. The caller has checked that the load can be balanced.
    """
    pivots = 0
    while (artificial := table.row_names >= 3 * n + r).any():
        cost = table.T[artificial].sum(axis=0)
        cost[table.column_names >= n] = 0.0
        cost[table.column_names == DEAD] = 0.0
        column = int(cost.argmin())
        row = table.blocking(column, rows=artificial | (table.row_names < n)) if cost[column] < -PIVOT else -1
        if row < 0:
            # the rest is zero: any force in such a row may replace its artificial, by a step of zero length
            row = int(np.flatnonzero(artificial)[0])
            entries = np.where((table.column_names >= 0) & (table.column_names < n), np.abs(table.T[row]), 0.0)
            column = int(entries.argmax())
        table.exchange(row, column)
        if table.column_names[column] >= 3 * n + r:
            _bury(table, column)
        pivots += 1
    return pivots


def _remove_artificials(table: Dictionary, n: int, r: int, limit: int) -> tuple[list[float], int, bool]:
    """Phase with restricted basis entry; returns the sums of the artificials, the pivots, and whether it terminated."""
    gap_rows = np.flatnonzero((table.row_names >= 2 * n) & (table.row_names < 3 * n))
    below = gap_rows[table.h[gap_rows] < 0]
    # artificials are not negative: z = gap - w where the gap is open, z = -gap + w where it is not
    sign = np.ones(n)
    sign[table.row_names[below] - 2 * n] = -1.0
    table.negate_row(below)
    table.reset_perturbation(table.row_names < 3 * n)
    nit = _let_gaps_in(table, n, sign)
    history = [_sum(table, n)]
    while history[-1] > max(LEFT_POSITIVE * history[0], ROUNDING):
        pivot = _restricted_entry(table, n)
        if pivot is None:
            return history, nit, True
        if nit >= limit:
            return history, nit, False
        row, column = pivot
        table.exchange(row, column)
        left = table.column_names[column]
        if 2 * n <= left < 3 * n:
            # its row was z + sign w = ..., so the column of w is that of z times the sign
            table.column_names[column] -= n
            table.T[:, column] *= sign[left - 2 * n]
        nit += 1 + _let_gaps_in(table, n, sign)
        history.append(_sum(table, n))
    return history, nit, True


def _let_gaps_in(table: Dictionary, n: int, sign: np.ndarray) -> int:
    """Replace z_k = gap - w by w_k wherever l_k is not basic: pivots on unit columns, only names change."""
    names = table.row_names
    forceless = np.ones(n, dtype=bool)
    forceless[names[names < n]] = False
    rows = np.flatnonzero((names >= 2 * n) & (names < 3 * n))
    k = names[rows] - 2 * n
    rows = rows[forceless[k] & (sign[k] > 0)]
    names[rows] -= n
    return len(rows)


def _restricted_entry(table: Dictionary, n: int) -> tuple[int, int] | None:
    """Pivot (row, column) with the most negative cost such that l_k and w_k are not both basic, or None."""
    names = table.column_names
    free = names >= 3 * n
    cost = table.T[(table.row_names >= 2 * n) & (table.row_names < 3 * n)].sum(axis=0)
    gain = np.where(free, np.abs(cost), -cost)
    gain[names == DEAD] = 0.0
    row_of = np.full(2 * n, -1)
    basic = table.row_names < 2 * n
    row_of[table.row_names[basic]] = np.flatnonzero(basic)
    blocks = table.row_names < 3 * n
    for column in np.argsort(-gain, kind="stable"):
        if gain[column] <= PIVOT:
            return None
        name = names[column]
        row = table.blocking(int(column), 1.0 if cost[column] < 0 else -1.0, rows=blocks)
        if row < 0:
            continue
        partner = -1 if free[column] else row_of[(name + n) % (2 * n)]
        if partner in (-1, row):
            return row, int(column)
    return None


def _bury(table: Dictionary, column: int) -> None:
    table.column_names[column] = DEAD
    table.T[:, column] = 0.0


def _sum(table: Dictionary, n: int) -> float:
    return float(table.h[(table.row_names >= 2 * n) & (table.row_names < 3 * n)].sum())
