"""Contact in several windows of one body: the active sets of all together, each window with its own preconditioner."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.halfspace.fft import Tally
from fecontact.halfspace.nested import GridLevel, GridProblem, preconditioner, solve_on_grid
from fecontact.halfspace.operator import CellModel
from fecontact.solvers import ContactProblem, Status
from fecontact.solvers.problem import Outcome


@dataclass(frozen=True, eq=False)
class Products:
    """A linear function of all cells of all windows, as one row (1, n).

    Attributes
    ----------
    function : callable
        From values (n,) to values (n,).
    """

    function: Callable[[Array], Array]

    def apply(self, values: Array, out: Array | None = None) -> Array:
        """Values (1, n) of values (1, n), in `out` if it is given."""
        out = np.empty_like(values) if out is None else out
        out[0] = self.function(values[0])
        return out


def solve_together(
    problem: ContactProblem,
    cells: IntArray,
    models: Sequence[CellModel],
    displacements: Callable[[Array], Array],
    tolerance: float,
) -> Outcome:
    """Solve a problem whose rows are cells of windows, see `halfspace.nested`.

    Parameters
    ----------
    problem : ContactProblem
    cells : (n,) int array
        Cell of each row, numbered through all windows.
    models : sequence of CellModel
        Of the windows.
    displacements : callable
        Displacements of all cells by forces on them.
    tolerance : float
    """
    n = sum(model.n_cells for model in models)
    allowed, g = np.zeros((1, n), bool), np.zeros((1, n))
    allowed[0, cells], g[0, cells] = True, problem.g
    scale = np.abs(problem.B).max(axis=1, initial=0.0)
    scale[scale == 0] = 1.0
    rows = np.zeros((problem.m, 1, n))
    rows[:, 0, cells] = problem.B / scale[:, None]
    product = Products(displacements)
    start = allowed if problem.m else allowed & (g < 0)
    at = solve_on_grid(
        GridProblem(product, product, Products(_inverse(models)), g, allowed, rows, problem.F / scale),  # type: ignore[arg-type]
        np.zeros((1, n)),
        start,
        tolerance,
    )
    status = Status.SOLVED if at.converged else Status.ITERATION_LIMIT
    told = "solved" if at.converged else "the contact area did not settle"
    return Outcome(np.maximum(at.p[0, cells], 0.0), at.q / scale, status, told, at.nit, list(at.history))


def _inverse(models: Sequence[CellModel]) -> Callable[[Array], Array]:
    """Approximate forces on all cells by their displacements: each window as if alone and periodic."""
    inverses = []
    for model in models:
        none = np.zeros(model.shape)
        level = GridLevel(
            model.body.kernel(), False, none, none > 0, np.zeros((0, *model.shape)), np.zeros(0), model.mirrored
        )
        inverses.append(preconditioner(level, level.whole, Tally(4 * model.body.grid.n_cells), None))
    ends = np.cumsum([model.n_cells for model in models])

    def forces(u: Array) -> Array:
        parts = zip(np.split(u, ends[:-1]), models, inverses, strict=True)
        return np.concatenate([(one.apply(v.reshape(m.shape)) * m.body.grid.area).ravel() for v, m, one in parts])

    return forces
