"""Bodies with windows on the surface of a mesh, which have the accuracy of a half-space at their contacts.

A load in one window displaces another one by the fields of the half-space at the load and by the remainder. Both are
smooth there, and are interpolated between the Chebyshev nodes of the two windows. Contacts in several windows have one
active set; each window has its own preconditioner.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, ClassVar, Self, cast

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.sparse.linalg import LinearOperator
from scipy.spatial import cKDTree

from fecontact.analytic.face_loads import displacements
from fecontact.bodies.body import Body, Outside, Reduced
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.halfspace import HalfSpace
from fecontact.bodies.inner_fields import InnerFields
from fecontact.bodies.local.placing import WindowRequest, facing_window, free_facets, place_window
from fecontact.bodies.local.pressed import BelowWindows, NodalFields
from fecontact.bodies.local.remainder import (
    MAX_DEFECT,
    Factored,
    Remainder,
    material_at,
    on_divided_mesh,
    remainder,
    surface_weights,
)
from fecontact.bodies.local.window import (
    Window,
    WindowSurface,
    half_space_opposite,
    inclined,
    principal,
    window_surface,
)
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import text
from fecontact.common.arrays import Array, IntArray
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.renamed import renamed_argument
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.energy_error import NO_CELLS, EnergyError
from fecontact.fem.expansion import Heated
from fecontact.fem.model import Model
from fecontact.fem.rigid import rigid_modes
from fecontact.fem.support import symmetry_planes
from fecontact.halfspace.cg import GridProblem, solve_on_grid
from fecontact.halfspace.compliance import Bend, SurfaceCompliance
from fecontact.halfspace.fft import Tally
from fecontact.halfspace.kernels import SELF_TERM_RATIO
from fecontact.halfspace.nested import GridLevel, preconditioner
from fecontact.halfspace.operator import DENSE_LIMIT, CellModel
from fecontact.mesh.mesh import Mesh
from fecontact.solvers import ContactProblem, Status
from fecontact.solvers.problem import Outcome
from fecontact.surfaces.facet_surface import FacetSurface
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


def _of_its_body(name: str) -> Any:
    """A member that is its elastic body's."""
    return property(lambda self: getattr(self.body, name), doc=getattr(ElasticBody, name).__doc__)


class MeshedWindows(Body):
    """A body whose displacements are those of the cells of its windows, then those of the nodes of its mesh."""

    body: ElasticBody
    name: str

    parts: Sequence[LocalBody]

    notes, size, reference_point, contact_modulus = map(
        _of_its_body, ("notes", "size", "reference_point", "contact_modulus")
    )
    _farthest, free_motions, _over_boundary, _count_nodes, _size_lines = map(
        _of_its_body, ("_farthest", "free_motions", "_over_boundary", "_count_nodes", "_size_lines")
    )

    @property
    def mesh(self) -> Mesh:
        """The mesh of its elastic body."""
        return self.body.mesh

    @property
    def _windows(self) -> Sequence[LocalBody]:
        """Its parts, with one factor of the stiffness."""
        return self.parts

    @property
    def _placed_windows(self) -> tuple[Window, ...]:
        """The windows of its parts; none before they are placed."""
        return tuple(part.given for part in self.parts if part.given is not None)

    @property
    def _across(self) -> Mapping[tuple[int, int], Array]:
        """Displacements into the body (k_i, k_j) at the nodes of window i by unit forces at those of another, j."""
        return {}

    @cached_property
    def _starts(self) -> tuple[int, ...]:
        """Number of each window's first cell; last the number of all cells."""
        return tuple(int(n) for n in np.cumsum([0, *(len(window.cells) for window in self._placed_windows)]))

    @property
    def _n_cells(self) -> int:
        """Number of modelled cells of all windows."""
        return self._starts[-1]

    @cached_property
    def _points(self) -> Array:
        """Cells and points of the mesh, all that is displaced."""
        return np.concatenate([*(window.cells for window in self._placed_windows), self.body.model.mesh.points])

    @cached_property
    def _surfaces(self) -> dict[str, WindowSurface]:
        return {
            name: window_surface(window, self._points, name, start)
            for name, window, start in zip(self.contact, self._placed_windows, self._starts, strict=False)
        }

    @cached_property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions about the reference point."""
        return rigid_modes(self._points, self.reference_point)

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """Compliance along rows: a matrix, or an operator for many rows."""
        with timer("factorise"):
            for part in self._windows:
                part.remainder  # noqa: B018 - made here, once
            self._across  # noqa: B018 - made here, once
        with timer("condense"):
            normals, nodal = self._split(rows)
            response = np.zeros(rows.shape[0])
            if loads is not None and loads.any():
                u = self._windows[0].factored.solve(self._on_mesh(loads)[:, None])
                response = self._by_mesh(normals, nodal, u)[:, 0]
            pressed = [i for i, normal in enumerate(normals) if normal.nnz]
            if nodal.nnz == 0 and len(pressed) == 1:
                return Reduced(self._windows[pressed[0]]._cell_model.along(normals[pressed[0]]), response)
            if nodal.nnz == 0 and rows.shape[0] > DENSE_LIMIT:
                cells = _cells_of(normals)
                kind = WindowsCompliance if cells is None else partial(SolvingWindows, cells=cells)
                return Reduced(kind(self, normals), response)
            return Reduced(self._dense(normals, nodal), response)

    def _split(self, rows: sp.csr_matrix) -> tuple[list[sp.csr_matrix], sp.csr_matrix]:
        """Parts (n, cells of a window) along the outward normals, and (n, body.n_dofs), of rows (n, n_dofs)."""
        normals = []
        for window, start in zip(self._placed_windows, self._starts, strict=False):
            outward = sp.kron(sp.eye_array(len(window.cells)), window.normal[:, None], format="csr")
            normals.append(sp.csr_matrix(rows[:, 3 * start : 3 * (start + len(window.cells))] @ outward))
        nodal = sp.csr_matrix(rows[:, 3 * self._n_cells :])
        for each in (*normals, nodal):
            each.eliminate_zeros()
        return normals, nodal

    def _by_mesh(self, normals: Sequence[sp.csr_matrix], nodal: sp.csr_matrix, u: Array) -> Array:
        """Displacements (n, k) along rows by smooth ones (body.n_dofs, k)."""
        own = [normal @ part._smooth_outward(u) for normal, part in zip(normals, self._windows, strict=True)]
        return np.asarray(sum(own) + nodal @ u)

    def _dense(self, normals: Sequence[sp.csr_matrix], nodal: sp.csr_matrix) -> Array:
        """Compliance (n, n) along rows."""
        n = nodal.shape[0]
        S = np.zeros((n, n))
        ends = []
        for normal, part in zip(normals, self._windows, strict=True):
            rows = np.flatnonzero(np.diff(normal.indptr))
            S[np.ix_(rows, rows)] += part._cell_model.dense(normal[rows])
            ends.append(normal @ part.remainder.term.matrix)
        for (i, j), core in self._across.items():
            S += ends[i] @ core @ ends[j].T
        if nodal.nnz:
            # springs and the like are fastened to few nodes
            u = self._windows[0].factored.solve(nodal.T.toarray())
            beside = self._by_mesh(normals, sp.csr_matrix(nodal.shape), u)
            S += beside + beside.T + nodal @ u
        return np.asarray((S + S.T) / 2)

    def _pressed(self, pressures: Sequence[Array]) -> list[Array]:
        """Displacements (nx, ny) into the body of all windows by pressures (nx, ny) on them."""
        terms = [part.remainder.term for part in self._windows]
        forces = [term.gathered(p) for term, p in zip(terms, pressures, strict=True)]
        out = []
        for i, (part, term, p) in enumerate(zip(self._windows, terms, pressures, strict=True)):
            own = part._cell_model.product.apply(p) if p.any() else np.zeros_like(p)
            others = [core @ forces[b] for (a, b), core in self._across.items() if a == i]
            out.append(own + term.spread(np.sum(others, axis=0)) if others else own)
        return out

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Elastic displacements (n_dofs,) under forces along rows and loads."""
        normals, nodal = self._split(rows)
        f = np.asarray(nodal.T @ forces if loads is None else nodal.T @ forces + self._on_mesh(loads))
        u = self._windows[0].factored.solve(f[:, None]) if f.any() else np.zeros((len(f), 1))
        cells = [part._smooth_outward(u)[:, 0] for part in self._windows]
        pressures = self._pressures(normals, forces)
        if any(p.any() for p in pressures):
            cells = [own - moved.ravel() for own, moved in zip(cells, self._pressed(pressures), strict=True)]
            for part, p in zip(self._windows, pressures, strict=True):
                u[:, 0] += part.remainder.fields @ part.remainder.term.gathered(p)
                u[:, 0] += part._nodal_fields.displacement(p).ravel()
        normal = [window.normal for window in self._placed_windows]
        return np.concatenate([*((own[:, None] * n).ravel() for own, n in zip(cells, normal, strict=True)), u[:, 0]])

    def _loaded_windows(self, rows: sp.csr_matrix, forces: Array) -> list[tuple[Remainder, Array]]:
        """Its windows, and the pressures (nx, ny) on them by forces along rows."""
        found = (part.remainder for part in self._windows)
        return list(zip(found, self._pressures(self._split(rows)[0], forces), strict=True))

    def _pressures(self, normals: Sequence[sp.csr_matrix], forces: Array) -> list[Array]:
        """Pressures (nx, ny) on its windows by forces along rows, whose parts along outward normals are given."""
        return [
            -np.asarray(normal.T @ forces).reshape(window.shape) / window.grid.area
            for window, normal in zip(self._placed_windows, normals, strict=True)
        ]

    @property
    def n_dofs(self) -> int:
        """Three for each cell, then three for each node of the mesh."""
        return 3 * self._n_cells + self.body.n_dofs

    @property
    def _matrix_free(self) -> bool:
        """Its compliance is applied by Fourier transforms."""
        return True

    @cached_property
    def _weighted_modes(self) -> Array:
        """Nodal forces (n_dofs, 6) of unit accelerations in the rigid motions about the reference point: M R."""
        return self._of_mesh(self.body._weighted_modes)

    def _of_mesh(self, values: Array) -> Array:
        """Values (n_dofs, ...) of the mesh's (body.n_dofs, ...), zero at the cells."""
        return np.concatenate([np.zeros((3 * self._n_cells, *values.shape[1:])), values])

    def attachment(self, point: Array, direction: Array) -> sp.csr_matrix:
        """One row (1, n_dofs) for the displacement at a point along a direction, see `ElasticBody.attachment`."""
        row = self.body.attachment(point, direction)
        return sp.csr_matrix(sp.hstack([sp.csr_matrix((1, 3 * self._n_cells)), row]))

    def _boundary_force(self, name: str, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a resultant (3,) in its axes, as a uniform traction on a boundary."""
        return self._of_mesh(self.body._boundary_force(name, force))

    def _boundary_traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of ``field(points, outward normals) -> (n, 3)``, all in its axes."""
        return self._of_mesh(self.body._boundary_traction(name, field))

    def _point_force(self, point: Array, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a force (3,) at a point (3,), both in its axes."""
        return self._of_mesh(self.body._point_force(point, force))

    def _body_force(self, field: Callable[[Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of forces per mass (n, 3) at points (n, 3), both in its axes."""
        return self._of_mesh(self.body._body_force(field))

    def _on_mesh(self, loads: Array) -> Array:
        """Loads (body.n_dofs,) on the mesh; the cells carry contact forces only."""
        return loads[3 * self._n_cells :]

    def _inner_fields(self, displacement: Array, rows: sp.csr_matrix, forces: Array) -> InnerFields:
        """Fields inside: those of half-spaces under the pressures on the windows, and of the elements beside them."""
        beside = BelowWindows(self._loaded_windows(rows, forces))
        u = self._on_mesh(displacement) - beside.displacement(self.mesh.points).ravel()
        return InnerFields(self.body.model, u, beside)

    def _energy_error(
        self, displacement: Array, points: Array, reach: float, heated: Heated | None = None
    ) -> EnergyError:
        """None: its mesh carries a smooth field only."""
        return NO_CELLS

    def _outside(self, displacement: Array) -> Outside:
        """Its outer surface, displaced by (n_dofs,)."""
        return self.body._outside(self._on_mesh(displacement))

    def _at_points(self, displacement: Array) -> Array:
        """Displacements (n_points, 3) of its mesh's points by generalised ones (n_dofs,)."""
        return self.body._at_points(self._on_mesh(displacement))


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
        pressures = self.body._pressures(self.normals, np.ravel(x))
        moved = self.body._pressed(pressures)
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
        """Solve a problem with this compliance, in its own units, see `halfspace.cg`."""
        n = self.body._n_cells
        allowed, g = np.zeros((1, n), bool), np.zeros((1, n))
        allowed[0, self.cells], g[0, self.cells] = True, problem.g
        scale = np.abs(problem.B).max(axis=1, initial=0.0)
        scale[scale == 0] = 1.0
        rows = np.zeros((problem.m, 1, n))
        rows[:, 0, self.cells] = problem.B / scale[:, None]
        product, inverse = (
            Products(self._displacements),
            Products(_inverse([w._cell_model for w in self.body._windows])),
        )
        start = allowed if problem.m else allowed & (g < 0)
        at = solve_on_grid(
            GridProblem(product, product, inverse, g, allowed, rows, problem.F / scale),  # type: ignore[arg-type]
            np.zeros((1, n)),
            start,
            tolerance,
        )
        status = Status.SOLVED if at.converged else Status.ITERATION_LIMIT
        message = "solved" if at.converged else "the contact area did not settle"
        forces = np.maximum(at.p[0, self.cells], 0.0)
        return Outcome(forces, at.q / scale, status, message, at.nit, list(at.history))

    def _displacements(self, forces: Array) -> Array:
        """Displacements (n_cells,) into the body of all cells by forces on them."""
        parts = self.body._windows
        each = np.split(forces, self.body._starts[1:-1])
        p = [f.reshape(part.window.shape) / part.window.grid.area for f, part in zip(each, parts, strict=True)]
        return np.concatenate([u.ravel() for u in self.body._pressed(p)])


def _cells_of(normals: Sequence[sp.csr_matrix]) -> IntArray | None:
    """Cell of each row, numbered through all windows; None unless rows are single, distinct cells, pressed inwards."""
    rows = sp.csr_matrix(sp.hstack(normals))
    single = (np.diff(rows.indptr) == 1).all() and (np.abs(rows.data + 1) < 1e-12).all()
    cells = rows.indices.astype(np.int64)
    return cells if single and len(np.unique(cells)) == rows.shape[0] else None


#: Remainders that are kept.
LAST = 4


@dataclass(eq=False)
class WindowCache:
    """Factors and remainders of a body, for all of its windows and poses.

    Attributes
    ----------
    factors : list of Factored
    remainders : list of (Factored, Remainder)
        The last ones.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((2.0, 2.0, 2.0), (3, 3, 3))
    >>> body = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), supports={"bottom": "xyz"})
    >>> one = fc.LocalBody(body, (1.0, 1.0, 2.0), 0.5, (8, 8))
    >>> other = one.with_window((0.9, 1.0, 2.0), (0.5, 0.5))
    >>> other.factored is one.factored
    True
    """

    factors: list[Factored] = field(default_factory=list)
    remainders: list[tuple[Factored, Remainder]] = field(default_factory=list)

    def factored(self, model: Model, window: Window) -> Factored:
        """The stiffness for loads in a window."""
        for made in self.factors:
            if made.serves(window.origin):
                return made
        self.factors.append(Factored.of(model, window.origin[None]))
        return self.factors[-1]

    def remainder(self, factored: Factored, window: Window, material: Material) -> Remainder:
        """The remainder in a window."""
        for by, found in self.remainders:
            if by is factored and _same(found.window, window):
                return found
        made = remainder(factored, window, material)
        self.remainders[:] = [*self.remainders, (factored, made)][-LAST:]
        return made

    def on_divided_mesh(self, body: ElasticBody, found: Remainder, name: str) -> Remainder:
        """A remainder that is not symmetric, on a finer mesh in its stead, see `remainder.on_divided_mesh`."""
        made = on_divided_mesh(body, found.window, found.material, found, name)
        self.remainders[:] = [(by, made if other is found else other) for by, other in self.remainders]
        return made


def _same(one: Window, other: Window) -> bool:
    alike = np.array_equal(one.origin, other.origin) and np.array_equal(one.axes, other.axes)
    return alike and one.grid == other.grid and one.mirrored == other.mirrored


@compact_repr
@dataclass(frozen=True, eq=False, init=False)
class LocalBody(MeshedWindows):
    """An elastic body whose contact lies in a small window, on a fine grid of cells.

    The compliance of the window is that of a half-space plus a smooth remainder, which the body's own mesh gives, see
    `bodies.local.remainder`. The mesh needs no refinement at the contact.

    Parameters
    ----------
    body : ElasticBody
    at : (3,) array_like, optional
        Middle of the window, on the body's surface, in its axes. Without it: where the bodies touch first.
    window : float or (float, float), optional
        Sides of the window. Without it: from the load by Hertz's formulas, then fitted to the contact that is found.
    cells : (int, int)
        Numbers of cells along the sides.
    name : str, optional
        The body's unless given.

    Attributes
    ----------
    window : Window
        Once it is placed; `result.solved(body)` is the body of a solution with its window.
    contact : tuple of str
        Its one contact surface, ``"window"``.

    Raises
    ------
    InputError
        If the middle of the window is not on the surface, or the window is not within one smooth face.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((4.0, 4.0, 2.0), (4, 4, 3))
    >>> block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), supports={"bottom": "xyz"})
    >>> local = fc.LocalBody(block, at=(2.0, 2.0, 2.0), window=1.0, cells=(32, 32))
    >>> ball = fc.RigidBody(fc.Sphere(10.0), pose=fc.Pose(translation=(2.0, 2.0, 2.0)))
    >>> scene = fc.Scene([local, ball], [fc.Contact(local, ball)])
    >>> result = scene.solve(forces={ball: (0.0, 0.0, -0.005)})
    >>> round(float(np.abs(result.contacts[0].force[2])), 9)
    0.005
    """

    contact: ClassVar[tuple[str, ...]] = ("window",)
    _has_window = True

    body: ElasticBody
    wish: WindowRequest
    given: Window | None
    name: str
    pose: Pose
    shared: dict[str, Any] = field(repr=False)

    def __init__(
        self,
        body: ElasticBody,
        at: ArrayLike | None = None,
        window: float | tuple[float, float] | None = None,
        cells: tuple[int, int] = (128, 128),
        name: str | None = None,
        *,
        shape: tuple[int, int] | None = None,
    ) -> None:
        if not isinstance(body, ElasticBody) or body._dimension != "space":
            raise InputError(f"A local body is made of an ElasticBody in space; found {body!r}.", code="no-elastic")
        if body.model.is_directed:
            raise InputError(
                f"The window of a local body is that of an isotropic half-space, and {body.name!r} has a material that "
                "is not isotropic. Use the ElasticBody itself with accuracy= when the scene is solved.",
                code="anisotropic",
            )
        wish = WindowRequest.of(at, window, renamed_argument("LocalBody", "shape", "cells", shape, cells))
        placed = None if wish.at is None or wish.sides is None else place_window(body, wish.at, wish.sides, wish.shape)
        fields = {
            "body": body,
            "wish": wish,
            "given": placed,
            "name": body.name if name is None else text("the name of a body", name),
        }
        for key, value in {**fields, "pose": body.pose, "shared": {}}.items():
            object.__setattr__(self, key, value)

    def with_window(self, at: ArrayLike, sides: tuple[float, float]) -> LocalBody:
        """The body with its window about a point (3,) of its axes; it keeps the factor of its stiffness."""
        return self._with(place_window(self.body, np.asarray(at, dtype=float), sides, self.wish.shape))

    def _with(self, window: Window) -> LocalBody:
        other = copy.copy(self)
        for name in ("_surface", "_surfaces", "_points", "_starts", "_cell_model", "rigid_modes", "weighted_modes"):
            vars(other).pop(name, None)
        for key, value in {"given": window, "shared": {"known": self._known}}.items():
            object.__setattr__(other, key, value)
        return other

    def _met_by(self, partner: object) -> LocalBody:
        """The body with the cells of its window opposite those of a partner's; itself if they are, or it has none."""
        if not isinstance(partner, LocalBody) or partner.given is None:
            return self
        pose = partner.pose.relative_to(self.pose)
        if self.given is not None and self.given.faces(partner.given, pose):
            return self
        last = self.shared.get("met")
        if last is None or not last.window.faces(partner.given, pose):
            last = self._with(facing_window(self.body, partner.given, pose, (self.name, partner.name)))
            self.shared["met"] = last
        other = copy.copy(last)
        for key, value in {"pose": self.pose, "name": self.name}.items():
            object.__setattr__(other, key, value)
        return other

    def half_space_opposite(self, half: HalfSpace) -> HalfSpace:
        """A half-space with its cells opposite those of the window; itself if they are, or there is no window yet."""
        if self.given is None:
            return half
        return half_space_opposite(half, self.given, self.pose.relative_to(half.pose), (half.name, self.name))

    @property
    def is_placed(self) -> bool:
        """Whether it has its window; else it gets one when a scene is solved."""
        return self.given is not None

    @property
    def window(self) -> Window:
        """The window.

        Raises
        ------
        InputError
            If it has none yet.
        """
        if self.given is None:
            raise InputError(
                f"{self.name!r} has no window yet; Scene.solve places it where the bodies touch. For anything else "
                "give at=(x, y, z) and window=side when the body is made.",
                code="no-window",
            )
        return self.given

    @property
    def material(self) -> Material:
        """Material of the body in its window; the same object in every pose."""
        if "material" not in self.shared:
            self.shared["material"] = material_at(self.body.model, self.window)
        return cast(Material, self.shared["material"])

    @property
    def _known(self) -> WindowCache:
        """What its windows have in common."""
        return cast(WindowCache, self.shared.setdefault("known", WindowCache()))

    @property
    def factored(self) -> Factored:
        """Its stiffness; the same object in every pose."""
        if "factored" not in self.shared:
            self.shared["factored"] = self._known.factored(self.body.model, self.window)
        return cast(Factored, self.shared["factored"])

    @property
    def remainder(self) -> Remainder:
        """What its compliance is beside a half-space's; the same object in every pose."""
        if "remainder" not in self.shared:
            found = self._known.remainder(self.factored, self.window, self.material)
            if found.defect > MAX_DEFECT:
                found = self._known.on_divided_mesh(self.body, found, self.name)
            self.shared["remainder"] = found
        return cast(Remainder, self.shared["remainder"])

    @property
    def _nodal_fields(self) -> NodalFields:
        """Half-spaces' displacements of the mesh's nodes; the same object in every pose."""
        if "nodal" not in self.shared:
            self.shared["nodal"] = NodalFields.of(self.remainder, self.mesh.points)
        return cast(NodalFields, self.shared["nodal"])

    @cached_property
    def _cell_model(self) -> CellModel:
        """Compliance among the cells of the window."""
        along_x, along_y = principal(self.window)
        bent = (Bend(self.material, (float(along_x), float(along_y))),) if along_x or along_y else ()
        stack = self.remainder.stack
        layers, below = ((), self.material) if stack is None else (stack.layers, stack.base)
        base = SurfaceCompliance(self.window.grid, below, layers, None, "uniform", SELF_TERM_RATIO, False, bent)
        return CellModel(base, self.window.mirrored, (self.remainder.term, *inclined(self.window, self.material)))

    @property
    def parts(self) -> tuple[Self]:  # type: ignore[override]
        """Itself."""
        return (self,)

    @cached_property
    def _surface(self) -> FacetSurface:
        mesh = self.body.model.mesh
        if self.given is None:
            facets = free_facets(mesh, symmetry_planes(mesh, self.body.supports))
            return FacetSurface(mesh.points, facets, self.contact[0])
        return self._surfaces[self.contact[0]]

    def surface(self, name: str) -> FacetSurface:
        """Its window; the whole skin of the body before the window is placed."""
        if name not in self.contact:
            raise InputError(
                f"The contact surface of {self.name!r} is its window, {self.contact[0]!r}; found {name!r}."
            )
        return self._surface

    def _smooth_outward(self, u: Array) -> Array:
        """Displacements (n_cells, k) of the cells along the outward normal by smooth ones (body.n_dofs, k)."""
        found, term = self.remainder, self.remainder.term
        nodes = surface_weights(self.body.model.mesh, self.window, found.points)
        values = components_along(nodes, np.tile(self.window.normal, (len(found.points), 1))) @ u
        return np.stack([term.spread(column).ravel() for column in values.T], axis=1)

    def describe(self) -> str:
        """One-line description of the model."""
        if self.given is None:
            return f"{self.name}: window where it is touched; on {self.body.describe()}"
        nx, ny = self.given.shape
        made = self.shared.get("remainder")
        known = "" if made is None else f", {len(made.core)} smooth loads, Betti defect {made.defect:.1e}"
        return f"{self.name}: window of {nx} x {ny} cells{known}; on {self.body.describe()}"


#: Least distance of two windows, relative to the longer side: nearer ones are not smooth to each other.
APART = 0.25


@compact_repr
@dataclass(frozen=True, eq=False, init=False)
class WindowedBody(MeshedWindows):
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

    @property
    def _windows(self) -> tuple[LocalBody, ...]:
        """The parts, with one factor of the stiffness; the same objects in every pose."""
        if "windows" not in self.shared:
            origins = np.array([part.window.origin for part in self.parts])
            factored = Factored.of(self.body.model, origins)
            self.shared["windows"] = tuple(_with_factor(part, factored) for part in self.parts)
        return cast(tuple[LocalBody, ...], self.shared["windows"])

    @property
    def _across(self) -> dict[tuple[int, int], Array]:
        """Displacements into the body (k_i, k_j) at the nodes of window i by unit forces at those of another, j."""
        return self._coupled[0]

    @property
    def _coupled(self) -> tuple[dict[tuple[int, int], Array], float]:
        if "across" not in self.shared:
            self.shared["across"] = _across(self._windows, self.name)
        return cast(tuple[dict[tuple[int, int], Array], float], self.shared["across"])

    @property
    def defect(self) -> float:
        """Largest violation of Betti's theorem within and between windows, see `Remainder.defect`."""
        return max(self._coupled[1], *(part.remainder.defect for part in self._windows))

    def surface(self, name: str) -> WindowSurface:
        """One of its windows."""
        if name not in self._surfaces:
            raise InputError(f"The windows of {self.name!r} are {', '.join(self.contact)}; found {name!r}.")
        return self._surfaces[name]

    def describe(self) -> str:
        """One-line description of the model."""
        sizes = ", ".join(" x ".join(map(str, part.window.shape)) for part in self.parts)
        known = f", Betti defect {self.defect:.1e}" if "across" in self.shared else ""
        return f"{self.name}: {len(self.parts)} windows of {sizes} cells{known}; on {self.body.describe()}"


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
    vars(other).pop("_cell_model", None)
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
    if defect > MAX_DEFECT:
        raise InputError(
            f"The compliance of {name!r} between its windows contradicts Betti's theorem by {100 * defect:.2g} %, more "
            f"than {100 * MAX_DEFECT:g} %: its mesh is too coarse. Take a finer mesh, or smaller windows."
        )
    return {(i, j): (found[i, j] + found[j, i].T) / 2 for i, j in pairs}, defect


def _seen(part: LocalBody, loaded: LocalBody) -> Array:
    """Displacements (k_i, k_j) into the body at the nodes of a window by unit forces at those of another."""
    points, inwards = part.remainder.points, -part.window.normal
    nodes = surface_weights(part.body.model.mesh, part.window, points)
    smooth = components_along(nodes, np.tile(inwards, (len(points), 1))) @ loaded.remainder.fields
    direct = [(displacements(points, load, loaded.material) @ inwards).sum(axis=0) for load in loaded.remainder.sources]
    return np.asarray(smooth + np.stack(direct, axis=1))
