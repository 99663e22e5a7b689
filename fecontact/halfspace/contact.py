"""Result of pressing a rigid surface on a half-space."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy
import scipy.sparse
import scipy.sparse.csgraph
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import among, number_array, positive, vector, whole
from fecontact.common.checks import friction as friction_coefficient
from fecontact.common.compact_repr import compact_repr
from fecontact.common.error_estimate import MAX_ERROR, OF_CELLS, OF_LAYERS, ErrorEstimate, ResponseError
from fecontact.common.errors import InputError, optional
from fecontact.common.material import Material
from fecontact.common.region import Region
from fecontact.common.renamed import redefined, renamed
from fecontact.common.units import UnitNames, Units
from fecontact.halfspace import inside
from fecontact.halfspace.flash_temperature import FlashTemperature, flash_temperature
from fecontact.halfspace.grid import Grid, part_of
from fecontact.halfspace.grid_error import EdgeCells, cells_error_estimate, edge_area, edge_cells
from fecontact.halfspace.layered import STRESSED, Layer, thin_layers
from fecontact.halfspace.pictures import Drawn, draw_pressure, plot_pressed, save_fields
from fecontact.halfspace.transport import Conductance, Distribution, Leakage, conductance, leakage
from fecontact.halfspace.validity import validity_warnings
from fecontact.solvers import Residuals

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Difference of both areas, relative, up to which they are the same.
SAME = 1e-9

#: Cells that share a side or a corner belong to one region.
TOUCHING = np.ones((3, 3), int)


@dataclass(frozen=True)
class SolverReport:
    """Solver statistics.

    Attributes
    ----------
    nit : int
        Conjugate gradient steps on the finest grid.
    rounds : int
        Active sets on the finest grid.
    levels : int
        Number of grids.
    products : int
        Products with a compliance, on all grids.
    transforms : float
        Forward and backward real transforms on all grids, including those of preconditioner and certificate, in units
        of one of the padded whole grid.
    symmetric : (bool, bool)
        Axes of symmetry, of which a half was modelled.
    seconds : float
    history : tuple of float
        Relative gap or penetration after each round.
    """

    nit: int
    rounds: int
    levels: int
    products: int
    transforms: float
    symmetric: tuple[bool, bool]
    seconds: float
    history: tuple[float, ...]

    def __str__(self) -> str:
        return (
            f"{self.nit} iterations in {self.rounds} rounds on the finest of {self.levels} grids; {self.products} "
            f"products, {self.transforms:.1f} transforms of the padded grid, {self.seconds:.3f} s"
        )


@compact_repr
@dataclass(frozen=True, eq=False)
class HalfSpaceContact(Drawn):
    """Contact of a half-space with a rigid surface; made by `HalfSpace.press`.

    Drawn are pressure, gap, displacement and the von Mises stress inside.

    Attributes
    ----------
    grid : Grid
    periodic : bool
    material : Material or None
        Material of the half-space, or of the base under its layers; None for layers on a rigid base.
    layers : tuple of Layer
    pressure : (nx, ny) array
        Uniform over each cell (bilinear: at the nodes), compression positive.
    pressure_kind : {'uniform', 'bilinear', 'point'}
    displacement : (nx, ny) array
        Displacement of the surface into the body; of both bodies together with a counter-material.
    gap : (nx, ny) array
        Gap after deformation; infinite where there is no counter-surface.
    approach : float
        Rigid displacement of the counter-surface into the body, at the origin of the grid: from the undisturbed
        surface, or from the mean plane of a periodic one.
    tilt : (float, float)
        Tilt of the counter-surface: slopes along x and y, rising positive.
    residuals : Residuals
        Recomputed from the problem, relative.
    status : str
        'solved' or 'no-contact'.
    solver : SolverReport
    coarse : (mx, my) array or None
        Pressure on cells twice as large, over the modelled part; None if there was no coarser grid.
    between : str
        Warning of an overlap between the middles of the cells, see `validity`; empty without one.
    given : {'force', 'approach'}
        Which of the two was prescribed.
    hardness : (nx, ny) array or None
        Largest pressures, see `hardness`; None without.
    dent : (nx, ny) array or None
        With a hardness, depth by which the surface has yielded, beside the elastic `displacement`; it stays.
    plastic : (nx, ny) bool array or None
        With a hardness, cells that yield under this load.
    """

    grid: Grid
    periodic: bool
    material: Material | None
    layers: tuple[Layer, ...]
    pressure: Array
    pressure_kind: str
    displacement: Array
    gap: Array
    approach: float
    tilt: tuple[float, float]
    residuals: Residuals
    status: str
    solver: SolverReport
    coarse: Array | None
    between: str = field(default="", kw_only=True, repr=False)
    given: str = field(default="force", kw_only=True, repr=False)
    hardness: Array | None = field(default=None, kw_only=True, repr=False)
    dent: Array | None = field(default=None, kw_only=True, repr=False)
    plastic: Mask | None = field(default=None, kw_only=True, repr=False)

    @property
    def active(self) -> Mask:
        """Cells (nx, ny) that carry pressure."""
        return self.pressure > 0

    @cached_property
    def force(self) -> float:
        """Total force."""
        return float(self.pressure.sum()) * self.grid.area

    @property
    def area(self) -> float:
        """Area with the edge located within its cells, see `edge`; several times more accurate for smooth surfaces."""
        return self._redefined("area", "the area with its edge within the cells, as it is printed", "point_area")

    @property
    def point_area(self) -> float:
        """Area of the cells that carry pressure; error of first order in the cell size."""
        return int(self.active.sum()) * self.grid.area

    edge_area = renamed("edge_area", "area", lambda contact: contact.figures["area"])

    @cached_property
    def figures(self) -> dict[str, float]:
        """Figures by name: what objects, prints, files, tables and pictures show."""
        area = edge_area(self._edge, int(self.active.sum()))[0] * self.grid.area
        return {
            "force": self.force,
            "approach": self.approach,
            "area": area,
            "point_area": self.point_area,
            "area_fraction": area / (self.grid.n_cells * self.grid.area),
            "max_pressure": self.max_pressure,
            "mean_pressure": self.force / area if area > 0 else 0.0,
            "mean_gap": self.mean_gap,
            **({} if self.dent is None else {"plastic_area": self.plastic_area, "max_dent": float(self.dent.max())}),
        }

    def _redefined(self, name: str, meaning: str, former: str) -> float:
        """A figure that had another value before, with a warning where it has."""
        if abs(self.figures["area"] - self.point_area) > SAME * self.point_area:
            redefined(name, meaning, former)
        return self.figures[name]

    @cached_property
    def _reserve(self) -> Array | None:
        """What pressures (nx, ny) lack of the hardness, zero where the surface yields; None without a hardness."""
        if self.hardness is None or self.plastic is None:
            return None
        most = np.minimum(self.hardness, 2 * self.max_pressure)  # beyond it any number is as good
        return np.where(self.plastic, 0.0, most - self.pressure)

    @property
    def plastic_area(self) -> float:
        """Area that yields under this load; zero without a hardness."""
        return 0.0 if self.plastic is None else int(self.plastic.sum()) * self.grid.area

    @cached_property
    def _edge(self) -> EdgeCells:
        return edge_cells(self.pressure, self.gap, self.periodic)

    @cached_property
    def error_estimate(self) -> ErrorEstimate:
        """Estimated discretisation errors, see `grid_error`.

        Examples
        --------
        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(3.0, 3.0), cells=(64, 64))
        >>> print(half.press(fc.surfaces.Paraboloid(1.0), force=4 / 3).error_estimate)
        pressure: about 0.9 % (peak 0.2 %, area 0.4 %), resolved by 44 faces across
        """
        part = part_of(self.grid.shape, self.solver.symmetric)
        points = self.pressure_kind == "point"
        fields = (self.pressure, self.gap, self.coarse)
        return cells_error_estimate(self.grid, *fields, part, self._edge, points, self._reserve, self.dent)

    @cached_property
    def response_error(self) -> ResponseError:
        """Estimated error of the approach under a given force, or of the force at a given approach.

        The energy is off by the square of the pressure's error, times `OF_CELLS`; see `results.response_error`.

        Examples
        --------
        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(3.0, 3.0), cells=(24, 24))
        >>> ball = half.press(fc.surfaces.Paraboloid(1.0), force=4 / 3)
        >>> print(ball.response_error, "; true:", round(abs(ball.approach - 1), 4))
        approach about 0.1 % ; true: 0.0011
        """
        error, energy = self.error_estimate.pressure, float(np.vdot(self.pressure, self.displacement))
        if not (np.isfinite(error) and energy > 0):
            return ResponseError()
        least = OF_LAYERS / self.error_estimate.faces_across**2 if self.layers else 0.0
        force = OF_CELLS * min(1.0, max(error**2, least))
        if self.given == "approach":
            return ResponseError(force=force)
        growth = 2 * (self.approach * float(self.pressure.sum()) / energy - 1)
        return ResponseError(approach=force / (1 + min(max(growth, 0.0), 1.0)))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of overlaps, large errors, contacts not resolved, and strains and slopes that are not small."""
        between = (self.between,) if self.between else ()
        moved = self.displacement if self.dent is None else self.displacement + self.dent
        limits = validity_warnings(self, self.pressure, self.gap, moved)
        return (*between, *self._error_warnings, *limits)

    @property
    def _error_warnings(self) -> tuple[str, ...]:
        """Warning of a contact not resolved, or of an estimated error of pressure, peak or area above a tenth."""
        estimate = self.error_estimate
        if not estimate.largest > MAX_ERROR:
            return ()
        if not estimate.resolved:
            return (
                f"The contact is {estimate.faces_across:.2g} cells across: its peak and area are not resolved, and its "
                f"pressure may be off by about {estimate.amount}. Take more cells, or a smaller grid around it.",
            )
        return (
            f"The pressure may be off by about {estimate.amount}: the contact is resolved by "
            f"{estimate.faces_across:.2g} cells across. Take more cells, or a smaller grid around it.",
        )

    @property
    def area_fraction(self) -> float:
        """Contact area over the area of the grid."""
        return self._redefined("area_fraction", "that of the area with its edge within the cells", "active.mean()")

    @property
    def max_pressure(self) -> float:
        """Largest pressure."""
        return float(self.pressure.max())

    @property
    def mean_pressure(self) -> float:
        """Force over contact area; zero without contact."""
        return self._redefined("mean_pressure", "over the area with its edge within the cells", "force / point_area")

    @cached_property
    def centre_of_pressure(self) -> tuple[float, float]:
        """Mean position weighted by pressure; NaN without contact."""
        total = self.pressure.sum()
        if total == 0:
            return (np.nan, np.nan)
        x, y = self.pressure.sum(axis=1) @ self.grid.x / total, self.pressure.sum(axis=0) @ self.grid.y / total
        return float(x), float(y)

    @property
    def mean_gap(self) -> float:
        """Mean gap over the cells that have a counter-surface."""
        return float(self.gap[np.isfinite(self.gap)].mean())

    @cached_property
    def region(self) -> IntArray:
        """Number (nx, ny) of the connected part of the contact that a cell belongs to, from 1; 0 without contact."""
        label, count = scipy.ndimage.label(self.active, TOUCHING)
        if self.periodic and count:
            pairs = [(label[0], np.roll(label[-1], s)) for s in (-1, 0, 1)]
            pairs += [(label[:, 0], np.roll(label[:, -1], s)) for s in (-1, 0, 1)]
            a, b = np.concatenate([p[0] for p in pairs]), np.concatenate([p[1] for p in pairs])
            both = (a > 0) & (b > 0)
            joined = scipy.sparse.coo_matrix((np.ones(both.sum()), (a[both], b[both])), (count + 1, count + 1))
            number = scipy.sparse.csgraph.connected_components(joined, directed=False)[1]
            label = number[label]
        return np.asarray(label, dtype=np.int64)

    @property
    def n_regions(self) -> int:
        """Number of connected parts of the contact."""
        return int(self.region.max())

    @property
    def _cell_forces(self) -> Array:
        """Forces (3, nx, ny) on the cells."""
        none = np.zeros(self.grid.shape)
        return np.stack([none, none, -self.pressure]) * self.grid.area

    @cached_property
    def regions(self) -> tuple[Region, ...]:
        """Connected parts of the contact, in the order of `region`; their areas and forces add up to its own."""
        label, n = self.region, self.n_regions

        def total(values: Array | Mask) -> Array:
            return np.asarray(np.bincount(label.ravel(), np.ravel(values), n + 1)[1:], float)

        at = np.stack(np.broadcast_arrays(self.grid.x[:, None], self.grid.y[None, :], 0.0))
        f, force, cell = self._cell_forces, total(self.pressure) * self.grid.area, self.grid.area
        beyond = np.bincount(label[tuple(self._edge.place)], self._edge.excess[0], n + 1)[1:]
        point_area, centre = total(self.active) * cell, [total(x * self.pressure) * cell / force for x in at]
        area = point_area + beyond * cell
        columns = {
            "area": area,
            "force": np.transpose([total(part) for part in f]),
            "moment": np.transpose([total(part) for part in np.cross(at, f, axis=0)]),
            "max_pressure": scipy.ndimage.maximum(self.pressure, label, np.arange(1, n + 1)),
            "mean_pressure": np.divide(force, area, out=np.zeros(n), where=area > 0),
            "centre_of_pressure": np.transpose(centre),
            "point_area": point_area,
        }
        return tuple(Region(**{name: values[k] for name, values in columns.items()}) for k in range(n))

    def to_xarray(self) -> Any:
        """Pressure, gap and displacement over x and y as an xarray Dataset, with the figures as its attributes.

        Raises
        ------
        MissingPackageError
            If xarray is not installed.
        """
        fields = {name: (("x", "y"), getattr(self, name)) for name in ("pressure", "gap", "displacement")}
        places = {"x": self.grid.x, "y": self.grid.y}
        return optional("xarray", "A Dataset").Dataset(fields, coords=places, attrs=dict(self.figures))

    def moment_radius(self) -> float:
        """Contact radius of a Hertz pressure from its second moment, a^2 = (5/2) sum(p r^2)/sum(p)."""
        x, y = self.centre_of_pressure
        r2 = ((self.grid.x - x) ** 2)[:, None] + ((self.grid.y - y) ** 2)[None, :]
        return float(np.sqrt(2.5 * (self.pressure * r2).sum() / self.pressure.sum()))

    def stress(self, points: ArrayLike, chunk: int = 20_000) -> Array:
        """Stress inside the half-space.

        By Love's rectangles for a free homogeneous half-space, by transforms for a layered or periodic one, see
        `inside`.

        Parameters
        ----------
        points : (n, 3) array_like
            Points with z <= 0. On an interface between layers the stress of the upper one is given; on an edge or a
            corner of a cell, on the surface, the mean of the limits from all sides, where the pressure jumps. There, at
            corners, xy is infinite as a logarithm times the mixed difference of the four pressures: its mean over a
            cell is taken.
        chunk : int
            Pairs of point and cell per batch.

        Returns
        -------
        (n, 6) array
            Components xx, yy, zz, xy, yz, xz, tension positive. For a periodic half-space the mean in-plane strain is
            zero.

        Raises
        ------
        InputError
            If a point lies outside, or in a rigid base, or layers at the top of a free one are thinner than half
            a cell.

        Examples
        --------
        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.3), size=(3.0, 3.0), cells=(32, 32))
        >>> contact = half.press(fc.Sphere(10.0), force=0.1)
        >>> contact.stress([[0.0, 0.0, -0.5]]).shape
        (1, 6)
        """
        where = number_array("points inside the half-space", points)
        whole("chunk", chunk)
        if where.ndim != 2 or where.shape[1] != 3 or not np.isfinite(where).all() or (where[:, 2] > 0).any():
            raise InputError("Points inside the half-space must be an array (n, 3) of finite numbers with z <= 0.")
        if len(where) == 0:
            return np.zeros((0, 6))
        if not self.periodic and (thin := thin_layers(self.layers, STRESSED * max(self.grid.cell))):
            raise InputError(
                f"The stress inside varies within a cell, {max(self.grid.cell):g} wide, over the {thin} thin layer(s) "
                "at the top. Take cells no wider than twice the top layer's thickness, or leave such layers out to see "
                "what is below.",
                code="cells-too-wide",
            )
        downwards = where * np.array([1.0, 1.0, -1.0])
        loaded = inside.Loaded(self.grid, self.pressure, self.material, self.layers)
        stress = loaded.periodic(downwards) if self.periodic else loaded.free(downwards, chunk)
        return np.asarray(stress * inside.OUTWARDS)

    def conductance(self, k1: float, k2: float) -> Conductance:
        """Thermal or electric conductance between two half-spaces, with bounds.

        Current through what touches alone, over the difference of the potentials (temperatures) far from the contact;
        on a periodic surface that of the constriction, per period.

        Parameters
        ----------
        k1, k2 : float
            Conductivities of both bodies.

        Raises
        ------
        InputError
            With layers, which conduct in their own way.

        Examples
        --------
        A round spot of radius 1 has 2 k a.

        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(2.6, 2.6), cells=(64, 64))
        >>> print(half.press(fc.surfaces.Paraboloid(1.0), force=4 / 3).conductance(k1=50.0, k2=50.0))
        conductance 99.8703, between 99.9569 and 103.086
        """
        if self.layers:
            raise InputError(
                "Conductance is offered for homogeneous half-spaces: layers conduct in their own way. Press on a "
                "half-space without layers.",
                code="conductance-of-layers",
            )
        mean = 2 / (1 / positive("k1", k1) + 1 / positive("k2", k2))
        return conductance(self.grid, self.region, self.figures["area"], self.periodic, mean)

    def leakage(self, drop: float, viscosity: float, along: str = "x") -> Leakage:
        """Flow of a fluid through the gaps, from one side of the grid to the other, by Reynolds' equation.

        The gaps are those of the dry contact: the pressure of the fluid is small beside those of the contact. A
        periodic surface goes on across the flow; of a free one the sides are walls.

        Parameters
        ----------
        drop : float
            Difference of the fluid's pressure between both sides.
        viscosity : float
            Dynamic viscosity.
        along : {'x', 'y'}

        Raises
        ------
        InputError
            If some cells have no counter-surface.
        """
        among("along", along, ("x", "y"))
        drop, viscosity = positive("the drop of pressure", drop), positive("the viscosity", viscosity)
        return leakage(self.grid, self.gap, self.active, self.periodic, drop, viscosity, "xy".index(along))

    def flash_temperature(
        self,
        velocity: tuple[float, float],
        *,
        conductivity: float,
        diffusivity: float,
        friction: float | None = None,
        heat: ArrayLike | None = None,
    ) -> FlashTemperature:
        """Steady rise of the temperature of one of both surfaces, over which the contact moves.

        The heat all goes into this body. It divides between two: temperatures T1 and T2, each with all the heat, give
        about T1 T2 / (T1 + T2) (Blok).

        Parameters
        ----------
        velocity : (float, float)
            Of the contact over the body, along x and y; (0, 0) on the body that moves with it.
        conductivity, diffusivity : float
        friction : float, optional
            Coulomb's mu: heat is mu p |velocity|. Of a contact with friction, its own.
        heat : (nx, ny) array_like, optional
            Heat per area and time instead: `work_density` times the speed of a contact that rolls.

        Raises
        ------
        InputError
            If neither friction nor heat is known, or numbers are out of range.

        Examples
        --------
        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=210e3, nu=0.3), size=(0.6, 0.6), cells=(64, 64))
        >>> ball = half.press(fc.Sphere(10.0), force=100.0)  # mm, N, s
        >>> print(ball.flash_temperature((1000.0, 0.0), conductivity=50.0, diffusivity=14.0, friction=0.1))
        flash temperature: largest 222.539, mean where it is heated 127.463
        """
        moved = vector("the velocity", velocity, 2)
        if heat is None:
            mu = getattr(self, "friction", None) if friction is None else friction
            if mu is None or (friction is None and getattr(self, "law", None)):
                raise InputError(
                    "The heat is not known: give friction=, Coulomb's mu, or heat= per area and time.", code="no-heat"
                )
            heat = friction_coefficient(mu) * self.pressure * np.hypot(*moved)
        q = number_array("the heat", heat)
        if q.shape != self.grid.shape or not np.isfinite(q).all():
            raise InputError(f"The heat must be finite numbers {self.grid.shape}, one a cell; found {q.shape}.")
        k, kappa = positive("the conductivity", conductivity), positive("the diffusivity", diffusivity)
        return flash_temperature(self.grid, q, self.periodic, moved, k, kappa)

    def distribution(self, field: str = "pressure", bins: int = 50) -> Distribution:
        """Probability density of the pressure where it touches, or of the gap where it does not.

        Parameters
        ----------
        field : {'pressure', 'gap'}
        bins : int

        Examples
        --------
        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(2.6, 2.6), cells=(64, 64))
        >>> found = half.press(fc.surfaces.Paraboloid(1.0), force=4 / 3).distribution(bins=4)
        >>> found.density.round(1)  # of a ball it grows with the pressure, 2 p / p0^2
        array([0.4, 1.3, 1.9, 2.7])
        """
        among("field", field, ("pressure", "gap"))
        values = self.pressure[self.active] if field == "pressure" else self.gap[~self.active & np.isfinite(self.gap)]
        return Distribution.of(field, values, whole("bins", bins))

    @property
    def has_stiffness(self) -> bool:
        """Whether the force grows with the approach as that of a punch with the contact's outline."""
        return True

    def picture(self, units: Units, name: str = "", path: str | Path | None = None) -> Any:
        """What `plot` draws, with the name of the surface."""
        return plot_pressed(self, path, units, name)

    def _drawn(self, path: str | Path | None, units: Units) -> Any:
        return self.picture(units, path=path)

    def _draw_in(self, ax: Axes, units: Units) -> None:
        draw_pressure(ax, self, units)

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON."""
        return {
            "status": self.status,
            "periodic": self.periodic,
            "cells": list(self.grid.shape),
            "size": list(self.grid.size),
            **self.figures,
            "tilt": list(self.tilt),
            "regions": self.n_regions,
            "error_estimate": self.error_estimate.summary(),
            "response_error": self.response_error.summary(),
            "warnings": list(self.warnings),
            "residuals": self.residuals.as_dict(),
        }

    def columns(self) -> dict[str, Array]:
        """Fields (nx, ny) on the cells by name."""
        dents = {} if self.dent is None else {"dent": self.dent}
        return {"pressure": self.pressure, "gap": self.gap, "displacement": self.displacement, **dents}

    def save(self, path: str | Path, *, units: UnitNames = ()) -> Path:
        """Write the contact; the suffix decides: .json (summary), .csv (a row per cell), .npz (arrays for numpy).

        With names of `units`, as for `plot`, heads of columns have them, and the other files an entry ``units``.

        Raises
        ------
        InputError
            For another suffix, or a file that cannot be written.

        Examples
        --------
        >>> import tempfile
        >>> from pathlib import Path
        >>> import numpy as np
        >>> import fecontact as fc
        >>> contact = fc.HalfSpace(fc.Material(E=1.0, nu=0.3)).press(fc.Sphere(10.0), force=0.02)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     saved = np.load(contact.save(Path(folder) / "ball.npz"))
        ...     float((saved["pressure"] * contact.grid.area).sum().round(12))
        0.02
        """
        return save_fields(path, self.grid, self.columns(), self.summary(), units)

    @property
    def _printed(self) -> dict[str, float]:
        """Printed figures by their words."""
        f = self.figures
        return {
            "force": f["force"],
            "approach": f["approach"],
            "area": f["area"],
            "area of its cells": f["point_area"],
            "maximum pressure": f["max_pressure"],
            "mean pressure": f["mean_pressure"],
            "mean gap": f["mean_gap"],
            "regions": self.n_regions,
            **({} if self.dent is None else {"plastic area": f["plastic_area"], "largest dent": f["max_dent"]}),
        }

    def __str__(self) -> str:
        kind = "periodic" if self.periodic else "free"
        modelled = ("whole", "half", "quarter")[sum(self.solver.symmetric)]
        lines = [
            *(f"{name:19}{value:>14.6g}" for name, value in self._printed.items()),
            *map(str, self._reports),
            f"residuals: {self.residuals}",
            f"error of {self.error_estimate}",
            *([f"error of the {self.response_error}"] if str(self.response_error) else []),
            *(f"Warning: {text}" for text in self.warnings),
        ]
        head = f"Half-space, {kind}, {self.grid.shape[0]} x {self.grid.shape[1]} cells ({modelled} modelled)"
        return "\n  ".join([f"{head}: {self.status}", *lines])

    @property
    def _reports(self) -> tuple[object, ...]:
        """Statistics of the solvers, to be printed."""
        return (self.solver,)
