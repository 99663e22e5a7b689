"""Compliance of a half-space along the rows of a scene's problem: a matrix, or an operator with its own solver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator

from fecontact.bodies.halfspace.cg import GridIterate
from fecontact.bodies.halfspace.compliance import SurfaceCompliance
from fecontact.bodies.halfspace.fft import Convolution, Tally, kernel_spectrum, padded
from fecontact.bodies.halfspace.nested import GridLevel, solve_nested
from fecontact.bodies.halfspace.symmetry import even_axes, part_of, unfold
from fecontact.common.arrays import Array, IntArray
from fecontact.solvers import ComplementarityProblem, Status
from fecontact.solvers.outcome import Outcome

MOST_CELLS = 3000
"""Cells in a scene's rows up to which the compliance among them is formed as a matrix."""

MOST_SHARES = 20
"""Largest number of reassignments of cells under several bodies."""


def whole_grid(body: SurfaceCompliance, workers: int | None = None) -> Convolution:
    """Compliance among all cells."""
    shape = body.grid.shape
    spectrum = body.kernel()
    if not body.periodic:
        spectrum = kernel_spectrum(spectrum, (padded(shape[0]), padded(shape[1])))
    return Convolution(spectrum, shape, (False, False), Tally(body.grid.n_cells), workers=workers)


def dense(body: SurfaceCompliance, rows: sp.csr_matrix) -> Array:
    """Displacements along rows (n, n_cells) by unit forces along them, (n, n).

    Few cells: from the table of offsets. Many: by one transform for each row's force.
    """
    used = np.unique(rows.indices)
    if len(used) > MOST_CELLS:
        operator, shape = whole_grid(body), body.grid.shape
        columns = [rows @ operator.apply(row.toarray().reshape(shape)).ravel() for row in rows]
        S = np.stack(columns, axis=1) / body.grid.area
        return np.asarray((S + S.T) / 2)
    ny = body.grid.shape[1]
    ix, iy = used // ny, used % ny
    if body.periodic:
        unit = np.zeros(body.grid.shape)
        unit[0, 0] = 1.0
        table = whole_grid(body).apply(unit)
    else:
        table = body.kernel()
    among = table[np.abs(ix[:, None] - ix), np.abs(iy[:, None] - iy)] / body.grid.area
    local = rows[:, used]
    half = local @ among
    return np.asarray((local @ half.T).T)


class GridCompliance(LinearOperator):
    """Compliance operator along rows of one cell each, with the fast solver of the grid.

    Parameters
    ----------
    body : SurfaceCompliance
    cells : (n,) int array
        Cell of each row; a cell under several bodies appears several times.
    """

    def __init__(self, body: SurfaceCompliance, cells: IntArray) -> None:
        super().__init__(dtype=np.dtype(float), shape=(len(cells), len(cells)))
        self.body, self.cells = body, cells
        self.convolution = whole_grid(body)

    def _matvec(self, x: Array) -> Array:
        return self.displacement(self.cells, np.ravel(x))[self.cells]

    def _adjoint(self) -> GridCompliance:
        return self

    def displacement(self, cells: IntArray, forces: Array) -> Array:
        """Displacements (n_cells,) by forces on cells."""
        grid = self.body.grid
        total = np.bincount(cells, weights=forces, minlength=grid.n_cells).reshape(grid.shape)
        return np.asarray(self.convolution.apply(total / grid.area)).ravel()

    solver = "nested-grid"

    def solve_contact(self, problem: ComplementarityProblem, tolerance: float) -> Outcome:
        """Solve a problem with this compliance, in its own units.

        Cells under several bodies are assigned to the nearest; where another one penetrates in the solution, they are
        reassigned with the motions found.

        Parameters
        ----------
        problem : ComplementarityProblem
        tolerance : float
            Tolerance of the certificate.

        Returns
        -------
        Outcome
            Forces and motions in the units of the problem.
        """
        q, forces, nit = np.zeros(problem.m), np.zeros(problem.n), 0
        several = len(np.unique(self.cells)) < problem.n
        for _ in range(MOST_SHARES if several else 1):
            owner = self._owners(problem.g + problem.B.T @ q)
            at, q = _solve(self.body, self.cells[owner], problem, owner, tolerance)
            nit += at.nit
            forces = np.zeros(problem.n)
            forces[owner] = np.maximum(at.p, 0.0).ravel()[self.cells[owner]] * self.body.grid.area
            if not at.converged:
                break
            if not several:
                return Outcome(forces, q, Status.SOLVED, "solved", nit, list(at.history))
            if problem.residuals(forces, q).within(tolerance):
                return Outcome(forces, q, Status.SOLVED, "solved", nit, list(at.history))
        return Outcome(forces, q, Status.ITERATION_LIMIT, "the contact area did not settle", nit, list(at.history))

    def _owners(self, gap: Array) -> IntArray:
        """Row of least gap of every cell."""
        order = np.lexsort((gap, self.cells))
        first = np.concatenate([[True], np.diff(self.cells[order]) > 0])
        return order[first]


def _solve(
    body: SurfaceCompliance, cells: IntArray, problem: ComplementarityProblem, owner: IntArray, tolerance: float
) -> tuple[GridIterate, Array]:
    """Solve with the given rows only; the pressures are those of the whole grid."""
    grid = body.grid
    allowed = np.zeros(grid.n_cells, bool)
    allowed[cells] = True
    g = np.zeros(grid.n_cells)
    g[cells] = problem.g[owner]
    rows = np.zeros((problem.m, grid.n_cells))
    rows[:, cells] = problem.B[:, owner]
    scale = np.abs(rows).max(axis=1, initial=0.0)
    scale[scale == 0] = 1.0
    rows = (rows / scale[:, None]).reshape(problem.m, *grid.shape)
    allowed, g = allowed.reshape(grid.shape), g.reshape(grid.shape)
    symmetric = even_axes(g, allowed, rows)
    part = part_of(grid.shape, symmetric)
    level = GridLevel(
        kernel=body.kernel(),
        periodic=body.periodic,
        g=np.ascontiguousarray(g[part]),
        allowed=np.ascontiguousarray(allowed[part]),
        B=np.ascontiguousarray(rows[:, *part]),
        F=problem.F / scale / grid.area / 2 ** sum(symmetric),
        symmetric=symmetric,
    )
    at, _ = solve_nested(level, body.kernel, tolerance, Tally(4 * grid.n_cells))
    return replace(at, p=unfold(at.p, symmetric)), at.q / scale
