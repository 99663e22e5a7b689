"""A simplex dictionary: basic variables as affine functions of the nonbasic ones, exchanged in place.

    basic = T @ nonbasic + h

Only nonbasic columns are stored, never the identity of the basic ones. A second right-hand side of generic numbers is
an infinitesimal perturbation of the first. Comparing h first and then the perturbation is the lexicographic rule: no
basis repeats and no tie remains (Charnes 1952).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.blas import dger

from fecontact.solvers.scaling import SMALLEST

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
