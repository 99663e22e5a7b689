"""Local body: an elastic body of any shape with the accuracy of a half-space at its contact."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, cast

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.halfspace.compliance import SurfaceCompliance
from fecontact.bodies.halfspace.kernels import SELF_TERM_RATIO
from fecontact.bodies.halfspace.operator import CellModel
from fecontact.bodies.local.factored import Factored
from fecontact.bodies.local.interior import nodal_displacement
from fecontact.bodies.local.placing import place_window
from fecontact.bodies.local.remainder import Remainder, checked, remainder, surface_weights
from fecontact.bodies.local.sources import inclined, principal
from fecontact.bodies.local.surface import window_surface
from fecontact.bodies.local.window import Window
from fecontact.bodies.local.wish import Wish
from fecontact.bodies.outside import Outside
from fecontact.bodies.placed import Placed
from fecontact.bodies.pose import Pose
from fecontact.bodies.protocol import Reduced
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.energy_error import NO_CELLS, EnergyError
from fecontact.fem.rigid import rigid_modes
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.nodal_weights import components_along


@dataclass(frozen=True, eq=False, init=False)
class LocalBody(Placed):
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
            raise InputError(f"A local body is made of an ElasticBody in space; found {body!r}.")
        if len(body.model.materials) > 1:
            raise InputError(
                f"A local body has one material, whose half-space it starts from; {body.name!r} has "
                f"{len(body.model.materials)}. Use the ElasticBody itself, with accuracy= when the scene is solved."
            )
        wish = Wish.of(at, window, shape)
        placed = None if wish.at is None or wish.sides is None else place_window(body, wish.at, wish.sides, wish.shape)
        fields = {"body": body, "wish": wish, "given": placed, "name": body.name if name is None else name}
        for key, value in {**fields, "pose": body.pose, "shared": {}}.items():
            object.__setattr__(self, key, value)

    def with_window(self, at: Array, sides: tuple[float, float]) -> LocalBody:
        """The body with its window about a point (3,) of its axes; it keeps the factor of its stiffness."""
        other = copy.copy(self)
        for name in ("_surface", "_cells", "rigid_modes", "weighted_modes"):
            vars(other).pop(name, None)
        placed = place_window(self.body, at, sides, self.wish.shape)
        kept = {"factored": self.shared["factored"]} if "factored" in self.shared else {}
        for key, value in {"given": placed, "shared": kept}.items():
            object.__setattr__(other, key, value)
        return other

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
                "give at=(x, y, z) and window=side when the body is made."
            )
        return self.given

    @property
    def material(self) -> Material:
        """Material of the body."""
        return self.body.model.materials[0]

    @property
    def factored(self) -> Factored:
        """Its stiffness; the same object in every pose."""
        if "factored" not in self.shared:
            self.shared["factored"] = Factored.of(self.body.model, self.window.origin)
        return cast(Factored, self.shared["factored"])

    @property
    def remainder(self) -> Remainder:
        """What its compliance is beside a half-space's; the same object in every pose."""
        if "remainder" not in self.shared:
            self.shared["remainder"] = checked(remainder(self.factored, self.window, self.material), self.name)
        return cast(Remainder, self.shared["remainder"])

    @cached_property
    def _cells(self) -> CellModel:
        along_x, along_y = principal(self.window)
        bend = (float(along_x), float(along_y))
        base = SurfaceCompliance(self.window.grid, self.material, (), None, "uniform", SELF_TERM_RATIO, False, bend)
        return CellModel(base, self.window.mirrored, (self.remainder.term, *inclined(self.window, self.material)))

    @property
    def n_cells(self) -> int:
        """Number of modelled cells; none before the window is placed."""
        return len(self.given.cells) if self.given is not None else 0

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
        """E / (1 - nu^2) of the material below the window."""
        return self.material.plane_strain_modulus

    @property
    def matrix_free(self) -> bool:
        """Its compliance is applied by Fourier transforms."""
        return True

    @property
    def farthest(self) -> float:
        """Largest coordinate of its mesh."""
        return self.body.farthest

    @cached_property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions about the reference point."""
        return rigid_modes(self._surface.points, self.reference_point)

    @property
    def free_motions(self) -> Array:
        """Rigid motions (6, k) that the supports do not resist."""
        return self.body.free_motions

    @cached_property
    def weighted_modes(self) -> Array:
        """Nodal forces (n_dofs, 6) of unit accelerations in the rigid motions about the reference point: M R."""
        return self._of_mesh(self.body.weighted_modes)

    @cached_property
    def _surface(self) -> FacetSurface:
        mesh = self.body.model.mesh
        if self.given is None:
            return FacetSurface(mesh.points, mesh.skin, self.contact[0])
        return window_surface(self.given, mesh.points, self.contact[0])

    def surface(self, name: str) -> FacetSurface:
        """Its window; the whole skin of the body before the window is placed."""
        if name not in self.contact:
            raise InputError(
                f"The contact surface of {self.name!r} is its window, {self.contact[0]!r}; found {name!r}."
            )
        return self._surface

    def _of_mesh(self, values: Array) -> Array:
        """Values (n_dofs, ...) of the mesh's (body.n_dofs, ...), zero at the cells."""
        return np.concatenate([np.zeros((3 * self.n_cells, *values.shape[1:])), values])

    def attachment(self, point: Array, direction: Array) -> sp.csr_matrix:
        """One row (1, n_dofs) for the displacement at a point along a direction, see `ElasticBody.attachment`."""
        row = self.body.attachment(point, direction)
        return sp.csr_matrix(sp.hstack([sp.csr_matrix((1, 3 * self.n_cells)), row]))

    def boundary_force(self, name: str, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a resultant (3,) in its axes, as a uniform traction on a boundary."""
        return self._of_mesh(self.body.boundary_force(name, force))

    def boundary_pressure(self, name: str, pressure: float) -> Array:
        """Nodal forces (n_dofs,) of a pressure on a boundary."""
        return self._of_mesh(self.body.boundary_pressure(name, pressure))

    def point_force(self, point: Array, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a force (3,) at a point (3,), both in its axes."""
        return self._of_mesh(self.body.point_force(point, force))

    def body_force(self, gravity: Array) -> Array:
        """Nodal forces (n_dofs,) of gravity (3,) in its axes."""
        return self._of_mesh(self.body.body_force(gravity))

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """Compliance along rows: a matrix, or an operator for many rows of one cell each."""
        with timer("factorise"):
            self.remainder  # noqa: B018 - made here, once
        with timer("condense"):
            normal, nodal = self._split(rows)
            response = np.zeros(rows.shape[0])
            if loads is not None and loads.any():
                u = self.factored.solve(self._on_mesh(loads)[:, None])
                response = (normal @ self._outward(u) + nodal @ u)[:, 0]
            if nodal.nnz == 0:
                return Reduced(self._cells.along(normal), response)
            # springs and the like are fastened to few nodes
            u = self.factored.solve(nodal.T.toarray())
            across = normal @ self._outward(u)
            S = self._cells.dense(normal) + across + across.T + nodal @ u
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

    def _on_mesh(self, loads: Array) -> Array:
        """Loads (body.n_dofs,) on the mesh; the cells carry contact forces only."""
        return loads[3 * self.n_cells :]

    def _outward(self, u: Array) -> Array:
        """Displacements (n_cells, k) of the cells along the outward normal by smooth ones (body.n_dofs, k)."""
        found, term = self.remainder, self.remainder.term
        nodes = surface_weights(self.body.model.mesh, self.window, found.points)
        values = components_along(nodes, np.tile(self.window.normal, (len(found.points), 1))) @ u
        return np.stack([term.spread(column).ravel() for column in values.T], axis=1)

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Elastic displacements (n_dofs,) under forces along rows and loads."""
        normal, nodal = self._split(rows)
        f = nodal.T @ forces if loads is None else nodal.T @ forces + self._on_mesh(loads)
        outward = np.asarray(normal.T @ forces).reshape(self.window.shape)
        u = self.factored.solve(np.asarray(f)[:, None])
        cells = self._outward(u)[:, 0]
        if outward.any():
            p = -outward / self.window.grid.area
            cells = cells - self._cells.product.apply(p).ravel()
            u[:, 0] += self.remainder.fields @ self.remainder.term.gathered(p)
            u[:, 0] += nodal_displacement(self.remainder, self.body.model.mesh.points, p).ravel()
        return np.concatenate([(cells[:, None] * self.window.normal).ravel(), u[:, 0]])

    def energy_error(self, displacement: Array, points: Array, reach: float) -> EnergyError:
        """None: its mesh carries a smooth field only."""
        return NO_CELLS

    def outside(self, displacement: Array) -> Outside:
        """Its outer surface, displaced by (n_dofs,)."""
        return self.body.outside(self._on_mesh(displacement))

    def at_points(self, displacement: Array) -> Array:
        """Displacements (n_points, 3) of its mesh's points by generalised ones (n_dofs,)."""
        return self.body.at_points(self._on_mesh(displacement))

    def size_lines(self, twin: str = "") -> list[str]:
        """Report lines on the size that the model represents."""
        return self.body.size_lines(twin)

    def describe(self) -> str:
        """One-line description of the model."""
        if self.given is None:
            return f"{self.name}: window where it is touched; on {self.body.describe()}"
        nx, ny = self.given.shape
        made = self.shared.get("remainder")
        known = "" if made is None else f", {len(made.core)} smooth loads, Betti defect {made.defect:.1e}"
        return f"{self.name}: window of {nx} x {ny} cells{known}; on {self.body.describe()}"
