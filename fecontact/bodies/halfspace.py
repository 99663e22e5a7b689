"""Elastic half-space."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, cast

import numpy as np
import scipy.sparse as sp

from fecontact.bodies.body import Reduced
from fecontact.bodies.pose import Pose
from fecontact.bodies.surface_body import SurfaceBody
from fecontact.common.arguments import flag, instance, items, spelled, text
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import positive
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.renamed import renamed_argument
from fecontact.common.stopwatch import Stopwatch
from fecontact.common.viscoelastic import Viscoelastic
from fecontact.halfspace import kernels
from fecontact.halfspace.compliance import SurfaceCompliance
from fecontact.halfspace.grid import Grid, GridSurface, grid_surface
from fecontact.halfspace.layered import Layer
from fecontact.halfspace.operator import CellModel, Part, coarse_pressure
from fecontact.halfspace.pressable import Pressable
from fecontact.halfspace.rollable import Rollable
from fecontact.halfspace.viscoelastic import elastic, memory_of
from fecontact.solvers import ContactProblem


@spelled
@compact_repr
@dataclass(frozen=True, eq=False, init=False)
class HalfSpace(Pressable, Rollable, SurfaceBody):
    """An elastic half-space z <= 0 with a grid of cells on its surface, centred on the origin.

    Parameters
    ----------
    material : Material, Viscoelastic or None
        None with layers: a rigid base. A visco-elastic one is served by `press_path`, whose steps have times, and
        by `press` with a velocity; the attribute is its material at once.
    size : (float, float)
        Sides of the grid along x and y.
    cells : (int, int)
        Numbers of cells along x and y.
    periodic : bool
        Whether the surface repeats beyond the grid. Its approach is then relative to the mean plane of the surface.
    layers : sequence of Layer
        Layers from the surface downwards.
    against : Material or Viscoelastic, optional
        Material of a counter-body that is elastic too: its compliance as a half-space is added, which is exact for two
        smooth frictionless half-spaces. Without it the counter-body is rigid.
    pressure : {'uniform', 'bilinear', 'point'}
        Pressure over a cell; 'point' is the report's version, a force at its centre (Elangovan 1978 after Conry &
        Seireg 1971).
    self_ratio : float
        With 'point': displacement under the force over that at the nearest neighbour.
    name : str, optional

    Attributes
    ----------
    grid : Grid
        Cells of the surface.
    compliance : SurfaceCompliance
        Compliance of the surface.

    Raises
    ------
    InputError
        If sizes, numbers of cells or options are invalid.

    Examples
    --------
    A steel sphere of radius 10 mm against a steel plane:

    >>> import fecontact as fc
    >>> steel = fc.Material(E=210e3, nu=0.3)
    >>> half = fc.HalfSpace(steel, size=(0.6, 0.6), cells=(64, 64), against=steel)
    >>> contact = half.press(fc.Sphere(10.0), force=100.0)
    >>> hertz = fc.hertz.spheres((10.0, float("inf")), (steel, steel), force=100.0)
    >>> abs(contact.approach / hertz.approach - 1) < 2e-4, abs(contact.max_pressure / hertz.p0 - 1) < 2e-3
    (True, True)
    """

    required: ClassVar = ("facets",)

    material: Material | None
    grid: Grid
    periodic: bool
    layers: tuple[Layer, ...]
    against: Material | None
    pressure: str
    self_ratio: float
    name: str
    pose: Pose
    compliance: SurfaceCompliance = field(repr=False)

    def __init__(
        self,
        material: Material | Viscoelastic | None,
        size: tuple[float, float] = (4.0, 4.0),
        cells: tuple[int, int] = (256, 256),
        periodic: bool = False,
        *,
        layers: Sequence[Layer] = (),
        against: Material | Viscoelastic | None = None,
        pressure: str = "uniform",
        self_ratio: float = kernels.SELF_TERM_RATIO,
        name: str = "half-space",
        shape: tuple[int, int] | None = None,
    ) -> None:
        for what, given in (("material", material), ("counter-body's material", against)):
            instance(f"the {what} of a half-space", elastic(given), (Material, type(None)))
        memory = memory_of((material, against))
        if memory and layers:
            raise InputError(
                "Layers on or under a visco-elastic half-space are not offered: its displacements would not creep as "
                "one. Leave out the layers, or take Materials.",
                code="viscoelastic",
            )
        for layer in items("the layers of a half-space", layers, "Layer objects"):
            instance("each of the layers of a half-space", layer, Layer)
        compliance = SurfaceCompliance(
            Grid(size, renamed_argument("HalfSpace", "shape", "cells", shape, cells)), elastic(material), tuple(layers),
            elastic(against), pressure, positive("self_ratio", self_ratio), flag("periodic", periodic), memory=memory,
        )  # fmt: skip
        same = ("material", "grid", "periodic", "layers", "against", "pressure", "self_ratio")
        vars(self).update({key: getattr(compliance, key) for key in same}, compliance=compliance, pose=Pose())
        vars(self)["name"] = text("the name of a half-space", name)

    def _met_by(self, partner: object) -> HalfSpace:
        """The half-space with cells opposite those of a local body; itself for other partners."""
        faced = getattr(partner, "half_space_opposite", None)
        return self if faced is None else cast(HalfSpace, faced(self))

    @property
    def _matrix_free(self) -> bool:
        """Its compliance is applied by Fourier transforms."""
        return True

    def _size_lines(self, twin: str = "") -> list[str]:
        """Report lines."""
        return [f"{self.name}: a half-space, of which only the surface is cut"]

    @property
    def size(self) -> float:
        """Diagonal of the grid."""
        return math.hypot(*self.grid.size)

    @property
    def reference_point(self) -> Array:
        """The origin of its axes."""
        return np.zeros(3)

    @property
    def contact_modulus(self) -> float:
        """E* of the bodies that it represents."""
        return self.compliance.modulus

    @cached_property
    def _cells(self) -> CellModel:
        return CellModel(self.compliance)

    @cached_property
    def facets(self) -> GridSurface:  # type: ignore[override]
        """Its surface: cell centres and quadrilaterals between them."""
        self._refuse_memory("a scene")
        return grid_surface(self.grid, "surface", self.periodic, self.compliance.pressure == "point")

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """Compliance along rows: a matrix, or an operator for many rows of one cell each."""
        with timer("condense"):
            with_friction = _along_surface(rows)
            compliance = (
                self._cells.in_space(rows) if with_friction else self._cells.along(_along(rows, self.facets.normal))
            )
            return Reduced(compliance, np.zeros(rows.shape[0]))

    def coarse_pressure(self, cells: IntArray, problem: ContactProblem) -> tuple[Array | None, Part]:
        """Pressure on cells twice as large by a problem whose rows are cells (n,); see `halfspace.operator`."""
        return coarse_pressure(self._cells, cells, problem)

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Elastic displacements (n_dofs,) under forces along rows."""
        cells, normal = self._cells, self.facets.normal
        if _along_surface(rows):
            return cells.displaced(np.asarray(rows.T @ forces).reshape(-1, 3)).ravel()
        outward = np.asarray(_along(rows, normal).T @ forces).reshape(cells.shape)
        if not outward.any():
            return np.zeros(self.n_dofs)
        u = cells.product.apply(outward / self.grid.area)
        return np.asarray((u.reshape(-1, 1) * normal).ravel())

    def describe(self) -> str:
        """One-line description of the model."""
        kind = "periodic" if self.periodic else "free"
        stack = f", {len(self.layers)} layer(s)" if self.layers else ""
        return f"{self.name}: {kind} half-space, {self.grid.shape[0]} x {self.grid.shape[1]} cells{stack}"


def _along_surface(rows: sp.csr_matrix) -> bool:
    """Whether some of rows (n, 3 n_cells) are of friction: more along the surface than across it."""
    squares = rows.multiply(rows).tocsr()
    across = squares[:, 2::3].sum(axis=1)
    return bool((squares.sum(axis=1) > 2 * across).any())


def _along(rows: sp.csr_matrix, normal: Array) -> sp.csr_matrix:
    """Parts (n, n_cells) of rows (n, 3 n_cells) for displacements along a normal (3,)."""
    part = sp.csr_matrix(rows @ sp.kron(sp.eye_array(rows.shape[1] // 3), normal[:, None], format="csr"))
    part.eliminate_zeros()
    return part
