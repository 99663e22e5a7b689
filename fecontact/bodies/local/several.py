"""A body with several windows: contacts that are coupled through it.

A load in one window displaces another one by the fields of the half-space at the load and by the remainder; both are
smooth there, and are interpolated between the Chebyshev nodes of the two windows.

Contact in several windows of one body: the active sets of all together, each window with its own preconditioner.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, cast

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator
from scipy.spatial import cKDTree

from fecontact.analytic.face_loads import displacements
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.local.body import LocalBody, pressures
from fecontact.bodies.local.factored import Factored
from fecontact.bodies.local.on_mesh import OnMesh
from fecontact.bodies.local.remainder import LARGEST_DEFECT, Remainder, surface_weights
from fecontact.bodies.local.surface import WindowSurface, window_surface
from fecontact.bodies.pose import Pose
from fecontact.bodies.protocol import Reduced
from fecontact.common.arguments import text
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.common.one_line import one_line
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.rigid import rigid_modes
from fecontact.halfspace.fft import Tally
from fecontact.halfspace.nested import GridLevel, GridProblem, preconditioner, solve_on_grid
from fecontact.halfspace.operator import DENSE_LIMIT, CellModel
from fecontact.solvers import ContactProblem, Status
from fecontact.solvers.problem import Outcome
from fecontact.surfaces.nodal_weights import components_along


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


APART = 0.25
"""Least distance of two windows, relative to the longer side: nearer ones are not smooth to each other."""


@one_line
@dataclass(frozen=True, eq=False, init=False)
class WindowedBody(OnMesh):
    """An elastic body with several windows, each as that of a `LocalBody`.

    Parameters
    ----------
    parts : LocalBody
        Two or more, of the same elastic body, with windows that do not touch.
    name : str, optional
        The body's unless given.

    Attributes
    ----------
    contact : tuple of str
        Its contact surfaces, ``"window 1"``, ``"window 2"``, ... in the order of the parts.

    Raises
    ------
    InputError
        If the parts are of different bodies, have no windows yet, or the windows are too near to each other.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((4.0, 2.0, 1.0), (8, 4, 2))
    >>> beam = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), supports={"bottom": "xyz"})
    >>> two = fc.WindowedBody(*(fc.LocalBody(beam, (x, 1.0, 1.0), 0.8, (24, 24)) for x in (1.0, 3.0)))
    >>> balls = [fc.RigidBody(fc.Sphere(5.0), pose=fc.Pose(translation=(x, 1.0, 1.0))) for x in (1.0, 3.0)]
    >>> contacts = [fc.Contact(two, b, surfaces=(w, "surface")) for b, w in zip(balls, two.contact, strict=True)]
    >>> result = fc.Scene([two, *balls], contacts).solve(forces={b: (0.0, 0.0, -0.002) for b in balls})
    >>> [round(float(np.abs(c.force[2])), 9) for c in result.contacts]
    [0.002, 0.002]
    """

    parts: tuple[LocalBody, ...]
    name: str
    pose: Pose
    shared: dict[str, Any] = field(repr=False)

    def __init__(self, *parts: LocalBody, name: str | None = None) -> None:
        _check(parts)
        first = parts[0]
        values = {
            "parts": parts,
            "name": first.body.name if name is None else text("the name of a body", name),
            "pose": first.pose,
            "shared": {},
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    @property
    def body(self) -> ElasticBody:  # type: ignore[override]
        """The elastic body."""
        return self.parts[0].body

    @property
    def contact(self) -> tuple[str, ...]:
        """Names of its windows."""
        return tuple(f"window {i}" for i in range(1, len(self.parts) + 1))

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """Number of each window's first cell; last the number of all cells."""
        return tuple(int(n) for n in np.cumsum([0, *(part.n_cells for part in self.parts)]))

    @property
    def n_cells(self) -> int:
        """Number of modelled cells of all windows."""
        return self.starts[-1]

    @property
    def windows(self) -> tuple[LocalBody, ...]:
        """The parts, with one factor of the stiffness; the same objects in every pose."""
        if "windows" not in self.shared:
            origins = np.array([part.window.origin for part in self.parts])
            factored = Factored.of(self.body.model, origins)
            self.shared["windows"] = tuple(_with_factor(part, factored) for part in self.parts)
        return cast(tuple[LocalBody, ...], self.shared["windows"])

    @property
    def across(self) -> dict[tuple[int, int], Array]:
        """Displacements into the body (k_i, k_j) at the nodes of window i by unit forces at those of another, j."""
        return self._across[0]

    @property
    def _across(self) -> tuple[dict[tuple[int, int], Array], float]:
        if "across" not in self.shared:
            self.shared["across"] = _across(self.windows, self.name)
        return cast(tuple[dict[tuple[int, int], Array], float], self.shared["across"])

    @property
    def defect(self) -> float:
        """Largest violation of Betti's theorem within and between windows, see `Remainder.defect`."""
        return max(self._across[1], *(part.remainder.defect for part in self.windows))

    @cached_property
    def _surfaces(self) -> dict[str, WindowSurface]:
        points = np.concatenate([*(part.window.cells for part in self.parts), self.body.model.mesh.points])
        return {
            name: window_surface(part.window, points, name, start)
            for name, part, start in zip(self.contact, self.parts, self.starts, strict=False)
        }

    @cached_property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions about the reference point."""
        return rigid_modes(next(iter(self._surfaces.values())).points, self.reference_point)

    def surface(self, name: str) -> WindowSurface:
        """One of its windows."""
        if name not in self._surfaces:
            raise InputError(f"The windows of {self.name!r} are {', '.join(self.contact)}; found {name!r}.")
        return self._surfaces[name]

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """Compliance along rows: a matrix, or an operator for many rows."""
        with timer("factorise"):
            self.across  # noqa: B018 - made here, once
        with timer("condense"):
            normals, nodal = self._split(rows)
            response = np.zeros(rows.shape[0])
            if loads is not None and loads.any():
                response = self._by_mesh(normals, nodal, self.windows[0].factored.solve(self.on_mesh(loads)[:, None]))[
                    :, 0
                ]
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
        for part, start in zip(self.parts, self.starts, strict=False):
            outward = sp.kron(sp.eye_array(part.n_cells), part.window.normal[:, None], format="csr")
            normals.append(sp.csr_matrix(rows[:, 3 * start : 3 * (start + part.n_cells)] @ outward))
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
            others = np.sum([core @ forces[b] for (a, b), core in self.across.items() if a == i], axis=0)
            own = part.cell_model.product.apply(p) if p.any() else 0.0
            out.append(own + term.spread(others))
        return out

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Elastic displacements (n_dofs,) under forces along rows and loads."""
        nodal = self._split(rows)[1]
        f = nodal.T @ forces if loads is None else nodal.T @ forces + self.on_mesh(loads)
        u = self.windows[0].factored.solve(np.asarray(f)[:, None])
        cells = [part.smooth_outward(u)[:, 0] for part in self.windows]
        loaded = self.loaded_windows(rows, forces)
        if any(p.any() for _, p in loaded):
            moved = self.pressed([p for _, p in loaded])
            cells = [own - pressed.ravel() for own, pressed in zip(cells, moved, strict=True)]
            u[:, 0] += sum(found.fields @ found.term.gathered(p) for found, p in loaded)
            u[:, 0] += sum(
                part.nodal_fields.displacement(p).ravel() for part, (_, p) in zip(self.windows, loaded, strict=True)
            )
        outwards = [(own[:, None] * part.window.normal).ravel() for own, part in zip(cells, self.parts, strict=True)]
        return np.concatenate([*outwards, u[:, 0]])

    def loaded_windows(self, rows: sp.csr_matrix, forces: Array) -> list[tuple[Remainder, Array]]:
        """Its windows, and the pressures (nx, ny) on them by forces along rows."""
        found = (part.remainder for part in self.windows)
        return list(zip(found, self.pressures(self._split(rows)[0], forces), strict=True))

    def pressures(self, normals: Sequence[sp.csr_matrix], forces: Array) -> list[Array]:
        """Pressures (nx, ny) on its windows by forces along rows."""
        return pressures([part.window for part in self.parts], normals, forces)

    def describe(self) -> str:
        """One-line description of the model."""
        sizes = ", ".join(" x ".join(map(str, part.window.shape)) for part in self.parts)
        known = f", Betti defect {self.defect:.1e}" if "across" in self.shared else ""
        return f"{self.name}: {len(self.parts)} windows of {sizes} cells{known}; on {self.body.describe()}"


class WindowsCompliance(LinearOperator):
    """Compliance along rows in several windows.

    Parameters
    ----------
    body : WindowedBody
    normals : list of (n, cells of a window) csr_matrix
        Parts of the rows along the windows' outward normals.
    """

    def __init__(self, body: WindowedBody, normals: Sequence[sp.csr_matrix]) -> None:
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

    def __init__(self, body: WindowedBody, normals: Sequence[sp.csr_matrix], cells: IntArray) -> None:
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


def _check(parts: Sequence[LocalBody]) -> None:
    if len(parts) < 2 or not all(isinstance(part, LocalBody) for part in parts):
        raise InputError(f"Expected two or more LocalBody; found {parts!r}.", code="too-few-windows")
    if any(part.body is not parts[0].body for part in parts):
        raise InputError("Expected windows of one elastic body; found LocalBody of several. Make them of the same one.")
    if not all(part.is_placed for part in parts):
        raise InputError("Expected windows with at= and window=; found one that is placed when it is touched.")
    for i, part in enumerate(parts):
        for other in parts[:i]:
            apart = float(cKDTree(other.window.cells).query(part.window.cells)[0].min())
            least = APART * max(*part.window.grid.size, *other.window.grid.size)
            if apart < least:
                raise InputError(
                    f"Two windows of {part.body.name!r}, about {np.array2string(part.window.origin, precision=4)} and "
                    f"{np.array2string(other.window.origin, precision=4)}, are {apart:.4g} apart; expected "
                    f"{least:.4g} or more. Take smaller ones, or one window for both contacts.",
                    code="windows-too-close",
                )


def _with_factor(part: LocalBody, factored: Factored) -> LocalBody:
    """A copy of a local body with another factor of its stiffness."""
    other = copy.copy(part)
    vars(other).pop("cell_model", None)
    object.__setattr__(other, "shared", {"factored": factored})
    return other


def _across(parts: Sequence[LocalBody], name: str) -> tuple[dict[tuple[int, int], Array], float]:
    """Displacements between the nodes of windows, made symmetric, and their largest asymmetry.

    Raises
    ------
    InputError
        If they are too far from symmetric.
    """
    pairs = [(i, j) for i in range(len(parts)) for j in range(len(parts)) if i != j]
    found = {(i, j): _seen(parts[i], parts[j]) for i, j in pairs}
    scale = min(part.remainder.mean for part in parts)
    defect = max(float(np.abs(found[i, j] - found[j, i].T).max()) for i, j in pairs) / 2 / scale
    if defect > LARGEST_DEFECT:
        raise InputError(
            f"The compliance of {name!r} between its windows contradicts Betti's theorem by {100 * defect:.2g} %, more "
            f"than {100 * LARGEST_DEFECT:g} %: its mesh is too coarse. Take a finer mesh, or smaller windows."
        )
    return {(i, j): (found[i, j] + found[j, i].T) / 2 for i, j in pairs}, defect


def _seen(part: LocalBody, loaded: LocalBody) -> Array:
    """Displacements (k_i, k_j) into the body at the nodes of a window by unit forces at those of another."""
    points, inwards = part.remainder.points, -part.window.normal
    nodes = surface_weights(part.body.model.mesh, part.window, points)
    smooth = components_along(nodes, np.tile(inwards, (len(points), 1))) @ loaded.remainder.fields
    direct = [(displacements(points, load, loaded.material) @ inwards).sum(axis=0) for load in loaded.remainder.sources]
    return np.asarray(smooth + np.stack(direct, axis=1))
