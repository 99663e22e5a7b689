"""Bodies with windows on the surface of a mesh: compliance, loads, rigid motions, report.

A load in one window displaces another one by the fields of the half-space at the load and by the remainder; both are
smooth there, and are interpolated between the Chebyshev nodes of the two windows.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator

from fecontact.bodies.body import Body, Outside, Reduced
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.inner_fields import InnerFields
from fecontact.bodies.local.coupled_windows import solve_together
from fecontact.bodies.local.pressed import BelowWindows
from fecontact.bodies.local.remainder import Remainder
from fecontact.bodies.local.surface import WindowSurface, window_surface
from fecontact.bodies.local.window import Window
from fecontact.common.arrays import Array, IntArray
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.energy_error import NO_CELLS, EnergyError
from fecontact.fem.rigid import rigid_modes
from fecontact.halfspace.operator import DENSE_LIMIT
from fecontact.mesh.mesh import Mesh
from fecontact.solvers import ContactProblem
from fecontact.solvers.problem import Outcome

if TYPE_CHECKING:
    from fecontact.bodies.local.body import LocalBody


class MeshedWindows(Body):
    """A body whose displacements are those of the cells of its windows, then those of the nodes of its mesh."""

    body: ElasticBody
    name: str

    @property
    @abstractmethod
    def placed_windows(self) -> Sequence[Window]:
        """The windows; none before they are placed."""

    @property
    @abstractmethod
    def windows(self) -> Sequence[LocalBody]:
        """The windows with their compliance, with one factor of the stiffness."""

    @property
    def across(self) -> Mapping[tuple[int, int], Array]:
        """Displacements into the body (k_i, k_j) at the nodes of window i by unit forces at those of another, j."""
        return {}

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """Number of each window's first cell; last the number of all cells."""
        return tuple(int(n) for n in np.cumsum([0, *(len(window.cells) for window in self.placed_windows)]))

    @property
    def n_cells(self) -> int:
        """Number of modelled cells of all windows."""
        return self.starts[-1]

    @cached_property
    def _points(self) -> Array:
        """Cells and points of the mesh, all that is displaced."""
        return np.concatenate([*(window.cells for window in self.placed_windows), self.body.model.mesh.points])

    @cached_property
    def _surfaces(self) -> dict[str, WindowSurface]:
        return {
            name: window_surface(window, self._points, name, start)
            for name, window, start in zip(self.contact, self.placed_windows, self.starts, strict=False)
        }

    @cached_property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions about the reference point."""
        return rigid_modes(self._points, self.reference_point)

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """Compliance along rows: a matrix, or an operator for many rows."""
        with timer("factorise"):
            for part in self.windows:
                part.remainder  # noqa: B018 - made here, once
            self.across  # noqa: B018 - made here, once
        with timer("condense"):
            normals, nodal = self._split(rows)
            response = np.zeros(rows.shape[0])
            if loads is not None and loads.any():
                u = self.windows[0].factored.solve(self.on_mesh(loads)[:, None])
                response = self._by_mesh(normals, nodal, u)[:, 0]
            pressed = [i for i, normal in enumerate(normals) if normal.nnz]
            if nodal.nnz == 0 and len(pressed) == 1:
                return Reduced(self.windows[pressed[0]].cell_model.along(normals[pressed[0]]), response)
            if nodal.nnz == 0 and rows.shape[0] > DENSE_LIMIT:
                cells = _cells_of(normals)
                kind = WindowsCompliance if cells is None else partial(SolvingWindows, cells=cells)
                return Reduced(kind(self, normals), response)
            return Reduced(self._dense(normals, nodal), response)

    def _split(self, rows: sp.csr_matrix) -> tuple[list[sp.csr_matrix], sp.csr_matrix]:
        """Parts (n, cells of a window) along the outward normals, and (n, body.n_dofs), of rows (n, n_dofs)."""
        normals = []
        for window, start in zip(self.placed_windows, self.starts, strict=False):
            outward = sp.kron(sp.eye_array(len(window.cells)), window.normal[:, None], format="csr")
            normals.append(sp.csr_matrix(rows[:, 3 * start : 3 * (start + len(window.cells))] @ outward))
        nodal = sp.csr_matrix(rows[:, 3 * self.n_cells :])
        for each in (*normals, nodal):
            each.eliminate_zeros()
        return normals, nodal

    def _by_mesh(self, normals: Sequence[sp.csr_matrix], nodal: sp.csr_matrix, u: Array) -> Array:
        """Displacements (n, k) along rows by smooth ones (body.n_dofs, k)."""
        own = [normal @ part.smooth_outward(u) for normal, part in zip(normals, self.windows, strict=True)]
        return np.asarray(sum(own) + nodal @ u)

    def _dense(self, normals: Sequence[sp.csr_matrix], nodal: sp.csr_matrix) -> Array:
        """Compliance (n, n) along rows."""
        n = nodal.shape[0]
        S = np.zeros((n, n))
        ends = []
        for normal, part in zip(normals, self.windows, strict=True):
            rows = np.flatnonzero(np.diff(normal.indptr))
            S[np.ix_(rows, rows)] += part.cell_model.dense(normal[rows])
            ends.append(normal @ part.remainder.term.matrix)
        for (i, j), core in self.across.items():
            S += ends[i] @ core @ ends[j].T
        if nodal.nnz:
            # springs and the like are fastened to few nodes
            u = self.windows[0].factored.solve(nodal.T.toarray())
            beside = self._by_mesh(normals, sp.csr_matrix(nodal.shape), u)
            S += beside + beside.T + nodal @ u
        return np.asarray((S + S.T) / 2)

    def pressed(self, pressures: Sequence[Array]) -> list[Array]:
        """Displacements (nx, ny) into the body of all windows by pressures (nx, ny) on them."""
        terms = [part.remainder.term for part in self.windows]
        forces = [term.gathered(p) for term, p in zip(terms, pressures, strict=True)]
        out = []
        for i, (part, term, p) in enumerate(zip(self.windows, terms, pressures, strict=True)):
            own = part.cell_model.product.apply(p) if p.any() else np.zeros_like(p)
            others = [core @ forces[b] for (a, b), core in self.across.items() if a == i]
            out.append(own + term.spread(np.sum(others, axis=0)) if others else own)
        return out

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Elastic displacements (n_dofs,) under forces along rows and loads."""
        normals, nodal = self._split(rows)
        f = np.asarray(nodal.T @ forces if loads is None else nodal.T @ forces + self.on_mesh(loads))
        u = self.windows[0].factored.solve(f[:, None]) if f.any() else np.zeros((len(f), 1))
        cells = [part.smooth_outward(u)[:, 0] for part in self.windows]
        pressures = self.pressures(normals, forces)
        if any(p.any() for p in pressures):
            cells = [own - moved.ravel() for own, moved in zip(cells, self.pressed(pressures), strict=True)]
            for part, p in zip(self.windows, pressures, strict=True):
                u[:, 0] += part.remainder.fields @ part.remainder.term.gathered(p)
                u[:, 0] += part.nodal_fields.displacement(p).ravel()
        normal = [window.normal for window in self.placed_windows]
        return np.concatenate([*((own[:, None] * n).ravel() for own, n in zip(cells, normal, strict=True)), u[:, 0]])

    def loaded_windows(self, rows: sp.csr_matrix, forces: Array) -> list[tuple[Remainder, Array]]:
        """Its windows, and the pressures (nx, ny) on them by forces along rows."""
        found = (part.remainder for part in self.windows)
        return list(zip(found, self.pressures(self._split(rows)[0], forces), strict=True))

    def pressures(self, normals: Sequence[sp.csr_matrix], forces: Array) -> list[Array]:
        """Pressures (nx, ny) on its windows by forces along rows, whose parts along outward normals are given."""
        return [
            -np.asarray(normal.T @ forces).reshape(window.shape) / window.grid.area
            for window, normal in zip(self.placed_windows, normals, strict=True)
        ]

    @property
    def mesh(self) -> Mesh:
        """The mesh of its elastic body."""
        return self.body.mesh

    @property
    def n_dofs(self) -> int:
        """Three for each cell, then three for each node of the mesh."""
        return 3 * self.n_cells + self.body.n_dofs

    @property
    def notes(self) -> tuple[str, ...]:
        """Corrections made when its mesh was read."""
        return self.body.notes

    @property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        return self.body.size

    @property
    def reference_point(self) -> Array:
        """Centre of mass (of volume where no density is given), in the body's axes."""
        return self.body.reference_point

    @property
    def contact_modulus(self) -> float:
        """E / (1 - nu^2) of the softest material."""
        return self.body.contact_modulus

    @property
    def matrix_free(self) -> bool:
        """Its compliance is applied by Fourier transforms."""
        return True

    @property
    def farthest(self) -> float:
        """Largest coordinate of its mesh."""
        return self.body.farthest

    @property
    def free_motions(self) -> Array:
        """Rigid motions (6, k) that the supports do not resist."""
        return self.body.free_motions

    @cached_property
    def weighted_modes(self) -> Array:
        """Nodal forces (n_dofs, 6) of unit accelerations in the rigid motions about the reference point: M R."""
        return self.of_mesh(self.body.weighted_modes)

    def of_mesh(self, values: Array) -> Array:
        """Values (n_dofs, ...) of the mesh's (body.n_dofs, ...), zero at the cells."""
        return np.concatenate([np.zeros((3 * self.n_cells, *values.shape[1:])), values])

    def attachment(self, point: Array, direction: Array) -> sp.csr_matrix:
        """One row (1, n_dofs) for the displacement at a point along a direction, see `ElasticBody.attachment`."""
        row = self.body.attachment(point, direction)
        return sp.csr_matrix(sp.hstack([sp.csr_matrix((1, 3 * self.n_cells)), row]))

    def boundary_force(self, name: str, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a resultant (3,) in its axes, as a uniform traction on a boundary."""
        return self.of_mesh(self.body.boundary_force(name, force))

    def boundary_traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of ``field(points, outward normals) -> (n, 3)``, all in its axes."""
        return self.of_mesh(self.body.boundary_traction(name, field))

    def over_boundary(self, name: str, values: Array) -> Callable[[Array], Array]:
        """Function of points (n, 3) on a boundary that interpolates values at its nodes."""
        return self.body.over_boundary(name, values)

    def count_nodes(self, name: str) -> int:
        """Number of nodes of a boundary."""
        return self.body.count_nodes(name)

    def point_force(self, point: Array, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a force (3,) at a point (3,), both in its axes."""
        return self.of_mesh(self.body.point_force(point, force))

    def body_force(self, gravity: Array) -> Array:
        """Nodal forces (n_dofs,) of gravity (3,) in its axes."""
        return self.of_mesh(self.body.body_force(gravity))

    def on_mesh(self, loads: Array) -> Array:
        """Loads (body.n_dofs,) on the mesh; the cells carry contact forces only."""
        return loads[3 * self.n_cells :]

    def inner_fields(self, displacement: Array, rows: sp.csr_matrix, forces: Array) -> InnerFields:
        """Fields inside: those of half-spaces under the pressures on the windows, and of the elements beside them."""
        beside = BelowWindows(self.loaded_windows(rows, forces))
        u = self.on_mesh(displacement) - beside.displacement(self.mesh.points).ravel()
        return InnerFields(self.body.model, u, beside)

    def energy_error(self, displacement: Array, points: Array, reach: float) -> EnergyError:
        """None: its mesh carries a smooth field only."""
        return NO_CELLS

    def outside(self, displacement: Array) -> Outside:
        """Its outer surface, displaced by (n_dofs,)."""
        return self.body.outside(self.on_mesh(displacement))

    def at_points(self, displacement: Array) -> Array:
        """Displacements (n_points, 3) of its mesh's points by generalised ones (n_dofs,)."""
        return self.body.at_points(self.on_mesh(displacement))

    def size_lines(self, twin: str = "") -> list[str]:
        """Report lines on the size that the model represents."""
        return self.body.size_lines(twin)


class WindowsCompliance(LinearOperator):
    """Compliance along rows in several windows.

    Parameters
    ----------
    body : MeshedWindows
    normals : list of (n, cells of a window) csr_matrix
        Parts of the rows along the windows' outward normals.
    """

    def __init__(self, body: MeshedWindows, normals: Sequence[sp.csr_matrix]) -> None:
        n = normals[0].shape[0]
        super().__init__(dtype=np.dtype(float), shape=(n, n))
        self.body, self.normals = body, normals

    def _matvec(self, x: Array) -> Array:
        pressures = self.body.pressures(self.normals, np.ravel(x))
        moved = self.body.pressed(pressures)
        return np.asarray(-sum(normal @ u.ravel() for normal, u in zip(self.normals, moved, strict=True)))

    def _adjoint(self) -> WindowsCompliance:
        return self


class SolvingWindows(WindowsCompliance):
    """The same along rows of one cell each, no cell twice, with a solver of its own.

    Parameters
    ----------
    body, normals
        As of `WindowsCompliance`.
    cells : (n,) int array
        Cell of each row, numbered through all windows.
    """

    solver = "joint-grids"

    def __init__(self, body: MeshedWindows, normals: Sequence[sp.csr_matrix], cells: IntArray) -> None:
        super().__init__(body, normals)
        self.cells = cells

    def solve_contact(self, problem: ContactProblem, tolerance: float) -> Outcome:
        """Solve a problem with this compliance, in its own units."""
        models = [part.cell_model for part in self.body.windows]
        return solve_together(problem, self.cells, models, self._displacements, tolerance)

    def _displacements(self, forces: Array) -> Array:
        """Displacements (n_cells,) into the body of all cells by forces on them."""
        parts = self.body.windows
        each = np.split(forces, self.body.starts[1:-1])
        p = [f.reshape(part.window.shape) / part.window.grid.area for f, part in zip(each, parts, strict=True)]
        return np.concatenate([u.ravel() for u in self.body.pressed(p)])


def _cells_of(normals: Sequence[sp.csr_matrix]) -> IntArray | None:
    """Cell of each row, numbered through all windows; None unless rows are single, distinct cells, pressed inwards."""
    rows = sp.csr_matrix(sp.hstack(normals))
    single = (np.diff(rows.indptr) == 1).all() and (np.abs(rows.data + 1) < 1e-12).all()
    cells = rows.indices.astype(np.int64)
    return cells if single and len(np.unique(cells)) == rows.shape[0] else None
