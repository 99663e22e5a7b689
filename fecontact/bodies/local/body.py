"""Local body: an elastic body of any shape with the accuracy of a half-space at its contact."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, Self, cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.halfspace import HalfSpace
from fecontact.bodies.local.factored import Factored
from fecontact.bodies.local.meshed_windows import MeshedWindows
from fecontact.bodies.local.placing import WindowRequest, facing_window, free_facets, place_window
from fecontact.bodies.local.pressed import NodalFields
from fecontact.bodies.local.remainder import (
    MAX_DEFECT,
    Remainder,
    on_divided_mesh,
    remainder,
    surface_weights,
)
from fecontact.bodies.local.stack import material_at
from fecontact.bodies.local.surface import half_space_opposite
from fecontact.bodies.local.window import Window, inclined, principal
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import text
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.one_line import one_line
from fecontact.fem.model import Model
from fecontact.fem.support import symmetry_planes
from fecontact.halfspace.compliance import Bend, SurfaceCompliance
from fecontact.halfspace.kernels import SELF_TERM_RATIO
from fecontact.halfspace.operator import CellModel
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.nodal_weights import components_along

LAST = 4
"""Remainders that are kept."""


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
        """A remainder that is not symmetric, on a finer mesh in its stead, see `dividing.on_divided_mesh`."""
        made = on_divided_mesh(body, found.window, found.material, found, name)
        self.remainders[:] = [(by, made if other is found else other) for by, other in self.remainders]
        return made


def _same(one: Window, other: Window) -> bool:
    alike = np.array_equal(one.origin, other.origin) and np.array_equal(one.axes, other.axes)
    return alike and one.grid == other.grid and one.mirrored == other.mirrored


@one_line
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
        shape: tuple[int, int] = (128, 128),
        name: str | None = None,
    ) -> None:
        if not isinstance(body, ElasticBody) or body.dimension != "space":
            raise InputError(f"A local body is made of an ElasticBody in space; found {body!r}.", code="no-elastic")
        wish = WindowRequest.of(at, window, shape)
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
        for name in ("_surface", "_surfaces", "_points", "starts", "cell_model", "rigid_modes", "weighted_modes"):
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
    def known(self) -> WindowCache:
        """What its windows have in common."""
        return cast(WindowCache, self.shared.setdefault("known", WindowCache()))

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
            if found.defect > MAX_DEFECT:
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
    def placed_windows(self) -> tuple[Window, ...]:
        """Its window, if it is placed."""
        return () if self.given is None else (self.given,)

    @property
    def windows(self) -> tuple[Self, ...]:
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

    def smooth_outward(self, u: Array) -> Array:
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
