"""Local body: an elastic body of any shape with the accuracy of a half-space at its contact."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, cast

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.halfspace import HalfSpace
from fecontact.bodies.local.factored import Factored
from fecontact.bodies.local.known import Known
from fecontact.bodies.local.on_mesh import OnMesh
from fecontact.bodies.local.placing import Wish, facing_window, free_facets, place_window
from fecontact.bodies.local.pressed import NodalFields
from fecontact.bodies.local.remainder import LARGEST_DEFECT, Remainder, surface_weights
from fecontact.bodies.local.stack import material_at
from fecontact.bodies.local.surface import half_space_opposite, window_surface
from fecontact.bodies.local.window import Window, inclined, principal
from fecontact.bodies.pose import Pose
from fecontact.bodies.protocol import Reduced
from fecontact.common.arguments import text
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.one_line import one_line
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.rigid import rigid_modes
from fecontact.fem.support import symmetry_planes
from fecontact.halfspace.compliance import Bend, SurfaceCompliance
from fecontact.halfspace.kernels import SELF_TERM_RATIO
from fecontact.halfspace.operator import CellModel
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.nodal_weights import components_along


@one_line
@dataclass(frozen=True, eq=False, init=False)
class LocalBody(OnMesh):
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
    shape : (int, int)
        Cells along the sides.
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
    >>> local = fc.LocalBody(block, at=(2.0, 2.0, 2.0), window=1.0, shape=(32, 32))
    >>> ball = fc.RigidBody(fc.Sphere(10.0), pose=fc.Pose(translation=(2.0, 2.0, 2.0)))
    >>> scene = fc.Scene([local, ball], [fc.Contact(local, ball)])
    >>> result = scene.solve(forces={ball: (0.0, 0.0, -0.005)})
    >>> round(float(np.abs(result.contacts[0].force[2])), 9)
    0.005
    """

    contact: ClassVar[tuple[str, ...]] = ("window",)

    body: ElasticBody
    wish: Wish
    given: Window | None
    name: str
    pose: Pose
    shared: dict[str, Any] = field(repr=False)

    def __init__(
        self,
        body: ElasticBody,
        at: ArrayLike | None = None,
        window: float | tuple[float, float] | None = None,
        shape: tuple[int, int] = (128, 128),
        name: str | None = None,
    ) -> None:
        if not isinstance(body, ElasticBody) or body.dimension != "space":
            raise InputError(f"A local body is made of an ElasticBody in space; found {body!r}.", code="no-elastic")
        wish = Wish.of(at, window, shape)
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
        for name in ("_surface", "cell_model", "rigid_modes", "weighted_modes"):
            vars(other).pop(name, None)
        for key, value in {"given": window, "shared": {"known": self.known}}.items():
            object.__setattr__(other, key, value)
        return other

    def met_by(self, partner: object) -> LocalBody:
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
    def known(self) -> Known:
        """What its windows have in common."""
        return cast(Known, self.shared.setdefault("known", Known()))

    @property
    def factored(self) -> Factored:
        """Its stiffness; the same object in every pose."""
        if "factored" not in self.shared:
            self.shared["factored"] = self.known.factored(self.body.model, self.window)
        return cast(Factored, self.shared["factored"])

    @property
    def remainder(self) -> Remainder:
        """What its compliance is beside a half-space's; the same object in every pose."""
        if "remainder" not in self.shared:
            found = self.known.remainder(self.factored, self.window, self.material)
            if found.defect > LARGEST_DEFECT:
                found = self.known.on_divided_mesh(self.body, found, self.name)
            self.shared["remainder"] = found
        return cast(Remainder, self.shared["remainder"])

    @property
    def nodal_fields(self) -> NodalFields:
        """Half-spaces' displacements of the mesh's nodes; the same object in every pose."""
        if "nodal" not in self.shared:
            self.shared["nodal"] = NodalFields.of(self.remainder, self.mesh.points)
        return cast(NodalFields, self.shared["nodal"])

    @cached_property
    def cell_model(self) -> CellModel:
        """Compliance among the cells of the window."""
        along_x, along_y = principal(self.window)
        bent = (Bend(self.material, (float(along_x), float(along_y))),) if along_x or along_y else ()
        stack = self.remainder.stack
        layers, below = ((), self.material) if stack is None else (stack.layers, stack.base)
        base = SurfaceCompliance(self.window.grid, below, layers, None, "uniform", SELF_TERM_RATIO, False, bent)
        return CellModel(base, self.window.mirrored, (self.remainder.term, *inclined(self.window, self.material)))

    @property
    def n_cells(self) -> int:
        """Number of modelled cells; none before the window is placed."""
        return len(self.given.cells) if self.given is not None else 0

    @cached_property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions about the reference point."""
        return rigid_modes(self._surface.points, self.reference_point)

    @cached_property
    def _surface(self) -> FacetSurface:
        mesh = self.body.model.mesh
        if self.given is None:
            facets = free_facets(mesh, symmetry_planes(mesh, self.body.supports))
            return FacetSurface(mesh.points, facets, self.contact[0])
        return window_surface(self.given, np.concatenate([self.given.cells, mesh.points]), self.contact[0])

    def surface(self, name: str) -> FacetSurface:
        """Its window; the whole skin of the body before the window is placed."""
        if name not in self.contact:
            raise InputError(
                f"The contact surface of {self.name!r} is its window, {self.contact[0]!r}; found {name!r}."
            )
        return self._surface

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """Compliance along rows: a matrix, or an operator for many rows of one cell each."""
        with timer("factorise"):
            self.remainder  # noqa: B018 - made here, once
        with timer("condense"):
            normal, nodal = self._split(rows)
            response = np.zeros(rows.shape[0])
            if loads is not None and loads.any():
                u = self.factored.solve(self.on_mesh(loads)[:, None])
                response = (normal @ self.smooth_outward(u) + nodal @ u)[:, 0]
            if nodal.nnz == 0:
                return Reduced(self.cell_model.along(normal), response)
            # springs and the like are fastened to few nodes
            u = self.factored.solve(nodal.T.toarray())
            across = normal @ self.smooth_outward(u)
            S = self.cell_model.dense(normal) + across + across.T + nodal @ u
            return Reduced((S + S.T) / 2, response)

    def _split(self, rows: sp.csr_matrix) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Parts (n, n_cells), along the outward normal, and (n, body.n_dofs) of rows (n, n_dofs)."""
        n = 3 * self.n_cells
        outward = sp.kron(sp.eye_array(self.n_cells), self.window.normal[:, None], format="csr")
        normal = sp.csr_matrix(rows[:, :n] @ outward)
        nodal = sp.csr_matrix(rows[:, n:])
        for part in (normal, nodal):
            part.eliminate_zeros()
        return normal, nodal

    def smooth_outward(self, u: Array) -> Array:
        """Displacements (n_cells, k) of the cells along the outward normal by smooth ones (body.n_dofs, k)."""
        found, term = self.remainder, self.remainder.term
        nodes = surface_weights(self.body.model.mesh, self.window, found.points)
        values = components_along(nodes, np.tile(self.window.normal, (len(found.points), 1))) @ u
        return np.stack([term.spread(column).ravel() for column in values.T], axis=1)

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Elastic displacements (n_dofs,) under forces along rows and loads."""
        normal, nodal = self._split(rows)
        f = np.asarray(nodal.T @ forces if loads is None else nodal.T @ forces + self.on_mesh(loads))
        u, cells = np.zeros((len(f), 1)), np.zeros(self.n_cells)
        if f.any():
            u = self.factored.solve(f[:, None])
            cells = self.smooth_outward(u)[:, 0]
        (p,) = pressures([self.window], [normal], forces)
        if p.any():
            cells = cells - self.cell_model.product.apply(p).ravel()
            u[:, 0] += self.remainder.fields @ self.remainder.term.gathered(p)
            u[:, 0] += self.nodal_fields.displacement(p).ravel()
        return np.concatenate([(cells[:, None] * self.window.normal).ravel(), u[:, 0]])

    def loaded_windows(self, rows: sp.csr_matrix, forces: Array) -> list[tuple[Remainder, Array]]:
        """Its window, and the pressures (nx, ny) on it by forces along rows."""
        return [(self.remainder, p) for p in pressures([self.window], [self._split(rows)[0]], forces)]

    def describe(self) -> str:
        """One-line description of the model."""
        if self.given is None:
            return f"{self.name}: window where it is touched; on {self.body.describe()}"
        nx, ny = self.given.shape
        made = self.shared.get("remainder")
        known = "" if made is None else f", {len(made.core)} smooth loads, Betti defect {made.defect:.1e}"
        return f"{self.name}: window of {nx} x {ny} cells{known}; on {self.body.describe()}"


def pressures(windows: Sequence[Window], normals: Sequence[sp.csr_matrix], forces: Array) -> list[Array]:
    """Pressures (nx, ny) on windows by forces along rows, whose parts along outward normals are (n, cells)."""
    return [
        -np.asarray(normal.T @ forces).reshape(window.shape) / window.grid.area
        for window, normal in zip(windows, normals, strict=True)
    ]
