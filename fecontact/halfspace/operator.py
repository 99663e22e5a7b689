"""Compliance of a half-space along the rows of a scene's problem: a matrix, or an operator with its own solver."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.halfspace.cg import GridIterate
from fecontact.halfspace.compliance import JointCompliance, SurfaceCompliance, TangentialCompliance, check_thickness
from fecontact.halfspace.fft import Convolution, Corrected, Product, Tally, Term
from fecontact.halfspace.friction import FIRST_TOLERANCE, MAX_STAGGERED, REDUCTION, SLIDING, Friction
from fecontact.halfspace.grid import Even, at_offsets, even_axes, part_of, unfold
from fecontact.halfspace.nested import GridLevel, solve_coarser, solve_nested
from fecontact.halfspace.tresca import TrescaProblem, solve_nested_tresca, solve_tresca
from fecontact.solvers import ContactProblem, Solution, Status
from fecontact.solvers.coulomb import friction_limit, sizes
from fecontact.solvers.problem import Outcome

Part = tuple[slice, slice]

#: Cells in a scene's rows up to which the compliance among them is formed as a matrix.
MAX_CELLS = 3000

#: Rows of a scene up to which the compliance is a matrix.
DENSE_LIMIT = 1500

#: Opening by a motion, relative to the largest, that is rounding.
APART = 1e-9

#: Largest number of reassignments of cells under several bodies.
MAX_SHARES = 20


@dataclass(frozen=True, eq=False)
class CellModel:
    """Compliance among the cells of a grid, or of the half or quarter of it that planes of symmetry leave.

    Attributes
    ----------
    body : SurfaceCompliance or JointCompliance
        With the whole grid.
    mirrored : (bool, bool)
        Axes along which only the cells with positive coordinates are modelled; the others have the same pressures.
    smooth : tuple of Term
        Additions, over the modelled cells.
    """

    body: SurfaceCompliance | JointCompliance
    mirrored: Even = (False, False)
    smooth: tuple[Term, ...] = ()

    @cached_property
    def part(self) -> tuple[slice, slice]:
        """The modelled cells."""
        return part_of(self.body.grid.shape, self.mirrored)

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Numbers of modelled cells along x and y."""
        return self.part[0].stop - self.part[0].start, self.part[1].stop - self.part[1].start

    @property
    def n_cells(self) -> int:
        """Number of modelled cells."""
        return self.shape[0] * self.shape[1]

    @cached_property
    def product(self) -> Product:
        """Displacements of all modelled cells by pressures on them."""
        convolution = Convolution.of_grid(self.body.kernel(), self.body.periodic, self.shape, self.mirrored)
        return Corrected(convolution, self.smooth) if self.smooth else convolution

    @cached_property
    def tangential(self) -> TangentialCompliance:
        """Displacements along the surface by tractions, and their coupling with pressures."""
        return self.friction.compliance(0, self.shape)

    def displaced(self, forces: Array) -> Array:
        """Displacements (n_cells, 3) of all cells by forces (n_cells, 3), z outwards."""
        q = np.moveaxis(forces.reshape(*self.shape, 3), 2, 0) / self.body.grid.area
        normal = self.product.apply(q[2]) - self.tangential.normal_displacement(q[:2])
        along = self.tangential.apply(q[:2]) + self.tangential.of_pressure(-q[2])
        return np.stack([*along, normal], axis=2).reshape(-1, 3)

    @cached_property
    def friction(self) -> Friction:
        """Compliances among the cells of parts of the grid, made so far."""
        assert isinstance(self.body, SurfaceCompliance)
        check_thickness(self.body)
        return Friction(self.body, 0.0, 0.0)

    def in_space(self, rows: sp.csr_matrix) -> Array | FrictionCompliance:
        """Compliance along rows (n, 3 n_cells), z outwards: a matrix, or an operator as in `along`."""
        single = rows.nnz == rows.shape[0] and bool((np.diff(rows.indptr) == 1).all())
        if rows.shape[0] > DENSE_LIMIT and single and bool((np.abs(np.abs(rows.data) - 1) < 1e-12).all()):
            return FrictionCompliance(self, rows)
        return self.dense_in_space(rows)

    def dense_in_space(self, rows: sp.csr_matrix) -> Array:
        """Displacements along rows (n, 3 n_cells), z outwards, by unit forces along them, (n, n)."""
        used = np.unique(rows.indices // 3)
        by, n = self.tangential, len(used)
        place = np.divmod(used, self.shape[1])
        K = np.zeros((n, 3, n, 3))
        K[:, 2, :, 2] = self._among(used)
        for at, sign, convolution in (((0, 1), 1, by.tractions), ((2,), -1, by.lift)):
            tables = [] if convolution is None else convolution.among(*place)
            for i, row in zip(at, tables, strict=False):
                for j, table in enumerate(row):
                    if table is not None:
                        K[:, i, :, j] = sign * table / self.body.grid.area
        K[:, :2, :, 2] = K[:, 2, :, :2].transpose(1, 2, 0)
        local = rows[:, (3 * used[:, None] + np.arange(3)).ravel()]
        half = local @ K.reshape(3 * n, 3 * n)
        return np.asarray((local @ half.T).T)

    def plus(self, other: CellModel) -> CellModel | None:
        """Both together, cell on cell; None unless they have the same cells and are free."""
        one, two = self.body, other.body
        if one.grid != two.grid or self.mirrored != other.mirrored or one.periodic or two.periodic:
            return None
        return CellModel(JointCompliance((one, two)), self.mirrored, self.smooth + other.smooth)

    def along(self, rows: sp.csr_matrix) -> Array | GridCompliance:
        """Compliance along rows (n, n_cells): a matrix, or an operator for more than `DENSE_LIMIT` of one cell each."""
        if rows.shape[0] > DENSE_LIMIT and _is_selection(rows):
            return GridCompliance(self, rows.indices.astype(np.int64))
        return self.dense(rows)

    def dense(self, rows: sp.csr_matrix) -> Array:
        """Displacements along rows (n, n_cells) by unit forces along them, (n, n).

        Few cells: from the table of offsets. Many: by one transform for each row's force.
        """
        used = np.unique(rows.indices)
        if len(used) > MAX_CELLS:
            columns = [rows @ self.product.apply(row.toarray().reshape(self.shape)).ravel() for row in rows]
            S = np.stack(columns, axis=1) / self.body.grid.area
            return np.asarray((S + S.T) / 2)
        local = rows[:, used]
        half = local @ self._among(used)
        return np.asarray((local @ half.T).T)

    def _among(self, cells: IntArray) -> Array:
        """Displacements (n, n) of cells (n,) by unit forces on them and on their mirror images."""
        grid = self.body.grid
        if self.body.periodic:
            unit = np.zeros(grid.shape)
            unit[0, 0] = 1.0
            table = self.product.apply(unit)
        else:
            table = self.body.kernel()
        among = at_offsets(table, cells, self.shape, self.mirrored) / grid.area
        for term in self.smooth:
            among = among + term.among(cells)
        return np.asarray(among)


class GridCompliance(LinearOperator):
    """Compliance operator along rows of one cell each, with the fast solver of the grid.

    Parameters
    ----------
    model : CellModel
    cells : (n,) int array
        Cell of each row; a cell under several bodies appears several times.
    """

    def __init__(self, model: CellModel, cells: IntArray) -> None:
        super().__init__(dtype=np.dtype(float), shape=(len(cells), len(cells)))
        self.model, self.cells = model, cells

    def _matvec(self, x: Array) -> Array:
        return self.displacement(self.cells, np.ravel(x))[self.cells]

    def _adjoint(self) -> GridCompliance:
        return self

    def plus(self, other: LinearOperator) -> GridCompliance | None:
        """The sum with the compliance of a partner whose cells lie on these; None if they do not."""
        if not isinstance(other, GridCompliance) or not np.array_equal(self.cells, other.cells):
            return None
        both = self.model.plus(other.model)
        return None if both is None else GridCompliance(both, self.cells)

    def displacement(self, cells: IntArray, forces: Array) -> Array:
        """Displacements (n_cells,) by forces on cells."""
        total = np.bincount(cells, weights=forces, minlength=self.model.n_cells).reshape(self.model.shape)
        return np.asarray(self.model.product.apply(total / self.model.body.grid.area)).ravel()

    solver = "nested-grid"

    def solve_contact(self, problem: ContactProblem, tolerance: float) -> Outcome:
        """Solve a problem with this compliance, in its own units.

        Cells under several bodies are assigned to the nearest; where another one penetrates in the solution, they are
        reassigned with the motions found.

        Parameters
        ----------
        problem : ContactProblem
        tolerance : float
            Tolerance of the certificate.

        Returns
        -------
        Outcome
            Forces and motions in the units of the problem.
        """
        q, forces, nit = np.zeros(problem.m), np.zeros(problem.n), 0
        several = len(np.unique(self.cells)) < problem.n
        for _ in range(MAX_SHARES if several else 1):
            owner = self._owners(problem.g + problem.B.T @ q)
            at, q = _solve(self.model, self.cells[owner], problem, owner, tolerance)
            nit += at.nit
            forces = np.zeros(problem.n)
            forces[owner] = np.maximum(at.p, 0.0).ravel()[self.cells[owner]] * self.model.body.grid.area
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


class FrictionCompliance(LinearOperator):
    """Compliance operator along rows of one component of a cell each, with a solver of friction on the grid.

    Parameters
    ----------
    model : CellModel
    rows : (n, 3 n_cells) csr_matrix
    """

    def __init__(self, model: CellModel, rows: sp.csr_matrix) -> None:
        super().__init__(dtype=np.dtype(float), shape=(rows.shape[0], rows.shape[0]))
        self.model, self.rows = model, rows
        self.place, self.sign = np.asarray(rows.indices, dtype=np.int64), np.sign(rows.data)

    def _matvec(self, x: Array) -> Array:
        forces = np.bincount(self.place, weights=self.sign * np.ravel(x), minlength=3 * self.model.n_cells)
        displaced = self.model.displaced(np.asarray(forces, dtype=float).reshape(-1, 3))
        return np.asarray(self.sign * displaced.ravel()[self.place])

    def _adjoint(self) -> FrictionCompliance:
        return self

    def array(self) -> Array:
        """The compliance as an array."""
        return self.model.dense_in_space(self.rows)

    def normal(self, rows: IntArray) -> GridCompliance:
        """Compliance among normal rows."""
        return GridCompliance(self.model, self.place[rows] // 3)

    def solve_friction(self, problem: ContactProblem, tolerance: float) -> Solution | None:
        """Pressures and tractions by staggered iteration, as `friction.press_step`.

        None where motions both open and slide, cells belong to several points, or no certified solution is found.
        """
        normals, tangents, grid = problem.normals, problem.tangents, self.model.body.grid
        cells, split = self.place[normals] // 3, _apart(problem)
        several = len(np.unique(cells)) < len(cells) or (self.sign[normals] > 0).any()
        if split is None or several or tangents.shape[1] != 2:
            return None
        friction, shape = self.model.friction, self.model.shape
        (Tn, Tt), coupled = split, friction.coupled

        def on_grid(values: Array) -> Array:
            """Values (..., N) of tangential rows as fields (..., 2, nx, ny)."""
            rows = tangents.ravel()
            out = np.zeros((*values.shape[:-1], 3 * self.model.n_cells))
            out[..., self.place[rows]] = self.sign[rows] * values[..., rows]
            return np.moveaxis(out.reshape(*values.shape[:-1], *shape, 3)[..., :2], -1, -3)

        def of_cells(values: Array, at: IntArray) -> Array:
            out = np.zeros(self.model.n_cells)
            out[at] = values
            return out.reshape(shape)

        mu = of_cells(problem.mu, self.place[problem.points] // 3)
        slip, B, F = on_grid(problem.g), on_grid(Tt.T @ problem.B), Tt.T @ problem.F / grid.area
        x, m, q = np.zeros(problem.n), np.zeros(len(F)), None
        within = max(FIRST_TOLERANCE, tolerance) if coupled else tolerance
        for k in range(MAX_STAGGERED):
            x[normals] = 0.0
            g = (problem.g + self @ x)[normals] if coupled and k else problem.g[normals]
            pressed = ContactProblem(self.normal(normals), g, Tn.T @ problem.B[:, normals], Tn.T @ problem.F)
            found = self.normal(normals).solve_contact(pressed, within)
            if found.status is not Status.SOLVED or not found.x.any():
                return None
            p = of_cells(found.x / grid.area, cells)
            box = friction.box(p)
            compliance = friction.compliance(0, (box[0].stop - box[0].start, box[1].stop - box[1].start))
            c = slip[:, *box] + compliance.of_pressure(p[box])
            tresca = TrescaProblem(compliance, friction_limit(mu[box], p[box]), c, B[:, :, *box], F)
            if _slides(tresca):
                return None
            if q is None:
                at = solve_nested_tresca(tresca, friction.compliance, np.zeros(c.shape), m, 0.1 * within)
            else:
                at = solve_tresca(tresca, q[:, *box], m, 0.1 * within)
            if at.defect > within:
                return None
            q, m = np.zeros((2, *shape)), at.m
            q[:, *box] = at.q
            along = np.concatenate([np.moveaxis(q, 0, -1), np.zeros((*shape, 1))], axis=-1).ravel()[self.place]
            x = self.sign * along * grid.area
            x[normals] = found.x
            motion = Tn @ found.p - Tt @ m
            residuals = problem.residuals(x, motion)
            if residuals.within(tolerance):
                return Solution(problem, x, motion, Status.SOLVED, "solved", k + 1, "grid")
            if not coupled or residuals.worst > 1:
                return None
            within = max(tolerance, min(within, REDUCTION * residuals.worst))
        return None


def _slides(problem: TrescaProblem) -> bool:
    """Whether a load alone, or all together along themselves, exceed what the limits hold."""
    directions = [*np.eye(len(problem.F)), problem.F]
    held = [(problem.limit * sizes(np.tensordot(along, problem.B, 1))).sum() for along in directions if problem.F.any()]
    return any(abs(along @ problem.F) >= SLIDING * most for along, most in zip(directions, held, strict=False))


def _apart(problem: ContactProblem) -> tuple[Array, Array] | None:
    """Combinations (m, k) of rows of equilibrium: of normal forces alone, and of tangential ones; None with others.

    Both are null spaces, by singular values.
    """
    out = []
    for others in (problem.tangents.ravel(), problem.normals):
        axes, size, _ = np.linalg.svd(problem.B[:, others], full_matrices=False)
        out.append(axes[:, int((size > APART * size.max(initial=0.0)).sum()) :])
    both = np.concatenate(out, axis=1)
    if both.shape[0] != both.shape[1] or (len(both) and np.linalg.cond(both) > 1 / APART):
        return None
    return out[0], out[1]


def _solve(
    model: CellModel, cells: IntArray, problem: ContactProblem, owner: IntArray, tolerance: float
) -> tuple[GridIterate, Array]:
    """Solve with the given rows only; the pressures are those of all modelled cells."""
    level, found, scale = _level(model, cells, problem, owner)
    if not level.is_bounded:
        raise InputError(
            f"The bodies overlap the mean plane of the periodic half-space by {-level.g.mean():.6g} in the mean: their "
            "force is unbounded. Move them out by more than that, or prescribe the force.",
            code="overlaps-mean-plane",
        )
    at, *_ = solve_nested(level, model.body.kernel, tolerance, Tally(4 * model.body.grid.n_cells))
    return replace(at, p=unfold(at.p, found)), at.q / scale


def coarse_pressure(model: CellModel, cells: IntArray, problem: ContactProblem) -> tuple[Array | None, Part]:
    """Pressure on cells twice as large of a problem whose rows are cells (n,), and the part of the grid it is of.

    None where the grid has no coarser one.
    """
    level, found, _ = _level(model, cells, problem, np.arange(problem.n))
    *_, coarse = solve_coarser(level, model.body.kernel, 0.0, Tally(4 * model.body.grid.n_cells))
    return coarse, part_of(model.shape, found)


def _level(
    model: CellModel, cells: IntArray, problem: ContactProblem, owner: IntArray
) -> tuple[GridLevel, Even, Array]:
    """The grid problem of given rows, its axes of symmetry, and the scales of its equilibrium rows."""
    body, shape = model.body, model.shape
    allowed = np.zeros(model.n_cells, bool)
    allowed[cells] = True
    g = np.zeros(model.n_cells)
    g[cells] = problem.g[owner]
    rows = np.zeros((problem.m, model.n_cells))
    rows[:, cells] = problem.B[:, owner]
    scale = np.abs(rows).max(axis=1, initial=0.0)
    scale[scale == 0] = 1.0
    rows = (rows / scale[:, None]).reshape(problem.m, *shape)
    allowed, g = allowed.reshape(shape), g.reshape(shape)
    # a smooth term is symmetric only where planes of symmetry make it so: such a grid is a part already
    apart = model.smooth or any(model.mirrored)
    found = (False, False) if apart else even_axes(g, allowed, rows)
    part = part_of(shape, found)
    level = GridLevel(
        kernel=body.kernel(),
        periodic=body.periodic,
        g=np.ascontiguousarray(g[part]),
        allowed=np.ascontiguousarray(allowed[part]),
        B=np.ascontiguousarray(rows[:, *part]),
        F=problem.F / scale / body.grid.area / 2 ** sum(found),
        symmetric=found if any(found) else model.mirrored,
        smooth=model.smooth,
    )
    return level, found, scale


def _is_selection(rows: sp.csr_matrix) -> bool:
    """Whether every row has one cell, with the sign of a contact from above."""
    return rows.nnz == rows.shape[0] and bool(
        (np.diff(rows.indptr) == 1).all() and (np.abs(rows.data + 1) < 1e-12).all()
    )
