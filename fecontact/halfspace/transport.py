"""What passes through a contact: heat or current through what touches, a fluid through the gaps; their distributions.

Conduction and incremental contact are one problem: with a tangent stiffness F' and a modulus E*, two bodies of
conductivities k1 and k2 have the conductance 2 F'/(E* (1/k1 + 1/k2)), which depends on the outline alone.

A fluid flows by Reynolds' equation, div(h^3/(12 mu) grad p) = 0, from one side of the grid to the other, with volumes
as cells: conductances of neighbours are in series, so that channels along or across the flow are exact.

References
----------
J. R. Barber, Proc. R. Soc. A 459 (2003) 53; G. Polya & G. Szego, Isoperimetric Inequalities in Mathematical Physics,
1951, chapter 2 (capacities of plates); F. Bottiglione, G. Carbone, L. Mangialardi & G. Mantriota, J. Appl. Phys. 106
(2009) 104902 (leakage).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import scipy
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import spsolve

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError
from fecontact.common.files import new_figure, save_figure
from fecontact.common.material import Material
from fecontact.common.units import Units
from fecontact.halfspace.cg import GridIterate
from fecontact.halfspace.compliance import SurfaceCompliance
from fecontact.halfspace.fft import Tally
from fecontact.halfspace.grid import Grid
from fecontact.halfspace.nested import GridLevel, solve_nested
from fecontact.halfspace.pictures import Drawn, draw_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Relative gap up to which what touches is at one potential.
TOLERANCE = 1e-8

#: Waves shorter than the cells that are counted on each side, along both axes.
ALIASES = 4


@dataclass(frozen=True)
class Conductance:
    """Conductance of a contact, thermal or electric, with bounds.

    Attributes
    ----------
    value : float
        Of the cells that touch: of a disc 32 to 200 cells across within .5 %, mostly .2 %.
    lower, upper : float
        Bounds of the exact one: one round spot of the same area, which has the least, and discs round the parts of the
        contact that do not see each other, or one round all. Of periodic surfaces those of the outline of cells, see
        `periodic_bounds`; infinite in full contact.
    """

    value: float
    lower: float
    upper: float

    def __str__(self) -> str:
        bounds = f", between {self.lower:.6g} and {self.upper:.6g}" if np.isfinite(self.upper) else ""
        return f"conductance {self.value:.6g}{bounds}"


def unit_stiffness(grid: Grid, touching: Mask, periodic: bool) -> float:
    """Slope of force over approach of cells that touch, for E* = 1; infinite for a periodic surface in full contact."""
    if not touching.any():
        return 0.0
    if periodic and touching.all():
        return math.inf
    return grid.area / -float(_raised(grid, touching, periodic).q[0])


def _raised(grid: Grid, touching: Mask, periodic: bool) -> GridIterate:
    """Cells that touch as a flat punch with a unit of pressure in all, for E* = 1."""
    body = SurfaceCompliance(grid, Material(1.0, 0.0), (), None, "uniform", 2.0, periodic)
    ones = np.ones((1, *grid.shape))
    level = GridLevel(body.kernel(), periodic, np.zeros(grid.shape), touching, ones, np.ones(1), (False, False))
    return solve_nested(level, body.kernel, TOLERANCE, Tally(grid.n_cells))[0]


def periodic_bounds(grid: Grid, touching: Mask) -> tuple[float, float]:
    """Bounds of the stiffness of cells that touch of a periodic surface, for E* = 1, from fields of two principles.

    Any pressures p on them have the energy <p, A p> of at least the square of their sum over the stiffness (Thomson).
    Any displacement w that is one on them has <w, S w>/(1 - mean w)^2 of at least the stiffness, S the inverse of A
    (Dirichlet). Here p is even in each cell, and w bilinear between the cells, by a punch that is wider by one cell;
    their energies are sums over waves, those shorter than the cells too.
    """
    p = np.maximum(_raised(grid, touching, True).p, 0.0)
    lower = (float(p.sum()) * grid.area) ** 2 / _energy(grid, p, -1)
    wider = scipy.ndimage.maximum_filter(touching, 3, mode="wrap")
    if wider.all():
        return lower, math.inf
    at = _raised(grid, wider, True)
    w = np.where(wider, 1.0, at.u / -at.q[0])
    return lower, _energy(grid, w, 1) / (1 - float(w.mean())) ** 2


def _energy(grid: Grid, values: Array, power: int) -> float:
    """Integral over a period of a field times its image under (|k|/2)^power, k wave numbers.

    The field is even in each cell for the power -1, bilinear between the cells for the power 1.
    """
    size = np.abs(np.fft.fft2(values) / values.size) ** 2
    waves = [2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(grid.shape, grid.cell, strict=True)]
    total = 0.0
    for shift in itertools.product(range(-ALIASES, ALIASES + 1), repeat=2):
        k, x = zip(*(
            (wave + 2 * np.pi * s / d, np.sinc(wave * d / (2 * np.pi) + s) ** (3 + power))
            for wave, s, d in zip(waves, shift, grid.cell, strict=True)
        ), strict=True)  # fmt: skip
        length = np.hypot(k[0][:, None], k[1]) / 2
        factor = np.divide(1.0, length, out=np.zeros(length.shape), where=length > 0) if power < 0 else length
        total += float((size * factor * x[0][:, None] * x[1]).sum())
    return total * grid.size[0] * grid.size[1]


def conductance(grid: Grid, region: IntArray, area: float, periodic: bool, conductivity: float) -> Conductance:
    """Conductance of numbered parts (nx, ny) of a contact, for the harmonic mean of both conductivities."""
    touching = region > 0
    value = conductivity * unit_stiffness(grid, touching, periodic)
    if not touching.any() or math.isinf(value):
        return Conductance(value, value, value)
    if periodic:
        lower, upper = (conductivity * bound for bound in periodic_bounds(grid, touching))
        return Conductance(max(value, lower), lower, upper)  # potentials at the middles of cells alone give less
    x, y = np.meshgrid(grid.x, grid.y, indexing="ij")
    radii = []
    for label in (region, touching.astype(np.int64)):
        parts = np.arange(1, label.max() + 1)
        middle = [np.concatenate([[0.0], scipy.ndimage.mean(at, label, parts)]) for at in (x, y)]
        away = np.hypot(x - middle[0][label], y - middle[1][label])
        radii.append(float((scipy.ndimage.maximum(away, label, parts) + math.hypot(*grid.cell) / 2).sum()))
    return Conductance(value, 2 * conductivity * math.sqrt(area / math.pi), 2 * conductivity * min(radii))


@dataclass(frozen=True, eq=False)
class Leakage(Drawn):
    """Flow of a fluid through the gaps of a contact; drawn are its pressure and flux.

    Attributes
    ----------
    grid : Grid
    flow : float
        Volume per time from one side of the grid to the other; zero if no way is open.
    is_open : bool
        Whether a way between the cells that touch leads from side to side.
    pressure : (nx, ny) array
        Of the fluid, from the drop at the inlet to zero at the outlet; not a number where none flows.
    flux : (nx, ny) array
        Volume per time and length, size.
    imbalance : float
        Difference of the flows in and out, relative: the certificate of the solution.
    """

    grid: Grid
    flow: float
    is_open: bool
    pressure: Array = field(repr=False)
    flux: Array = field(repr=False)
    imbalance: float

    def _drawn(self, path: str | Path | None, units: Units) -> Figure:
        figure = new_figure((11.0, 5.0))
        left, right = figure.subplots(1, 2)
        draw_map(left, self.grid, self.pressure, "viridis", units.axis_label("pressure of the fluid", "stress"), units)
        shown = np.where(np.isnan(self.pressure), np.nan, self.flux)
        draw_map(right, self.grid, shown, "Blues", "flux, volume per time and length", units)
        figure.suptitle(f"flow {self.flow:.4g}" if self.is_open else "no way is open: nothing flows")
        return save_figure(figure, path)

    def __str__(self) -> str:
        return f"flow {self.flow:.6g} (imbalance {self.imbalance:.1e})" if self.is_open else "no open way: no flow"


def leakage(grid: Grid, gap: Array, closed: Mask, periodic: bool, drop: float, viscosity: float, axis: int) -> Leakage:
    """Flow along an axis through gaps (nx, ny) between cells that are closed; across it periodic, or between walls.

    Raises
    ------
    InputError
        Where there is no counter-surface, and no gap.
    """
    if not np.isfinite(gap).all():
        raise InputError(
            f"A fluid needs a gap everywhere: {int((~np.isfinite(gap)).sum())} cells have no counter-surface. Give it "
            "finite heights there.",
            code="gap-unbounded",
        )
    h = np.moveaxis(np.where(closed, 0.0, np.maximum(gap, 0.0)), axis, 0)
    ratio = grid.cell[1 - axis] / grid.cell[axis]
    k = h**3 / (12 * viscosity)
    number = np.arange(h.size).reshape(h.shape)
    # neighbours along the flow, then across it
    sides = [(number[:-1], number[1:]), (number[:, :-1], number[:, 1:])]
    sides += [(number[:, -1], number[:, 0])] * (periodic and h.shape[1] > 2)
    first, second = (np.concatenate([side[j].ravel() for side in sides]) for j in (0, 1))
    shape = np.where(np.arange(len(first)) < sides[0][0].size, ratio, 1 / ratio)
    both = k.ravel()[first] * k.ravel()[second]
    some = both > 0
    first, second = first[some], second[some]
    T = shape[some] * 2 * both[some] / (k.ravel()[first] + k.ravel()[second])
    part = connected_components(sp.coo_matrix((T, (first, second)), (h.size, h.size)), directed=False)[1]
    through = np.intersect1d(part[number[0]][k[0] > 0], part[number[-1]][k[-1] > 0])
    kept = np.flatnonzero(np.isin(part, through))
    pressure, flux = np.full(h.size, np.nan), np.zeros(h.size)
    if not len(kept):
        return Leakage(grid, 0.0, False, np.full(gap.shape, np.nan), np.zeros(gap.shape), 0.0)
    ends = np.zeros((2, *h.shape))
    ends[0, 0], ends[1, -1] = 2 * ratio * k[0], 2 * ratio * k[-1]
    inlet, outlet = ends.reshape(2, -1)
    L = sp.coo_matrix((np.tile(T, 2), (np.r_[first, second], np.r_[second, first])), (h.size, h.size)).tocsr()
    diagonal = np.asarray(L.sum(axis=1)).ravel() + inlet + outlet
    matrix = (sp.diags_array(diagonal) - L).tocsr()[kept][:, kept]
    scale = 1 / np.sqrt(diagonal[kept])  # gaps of thin wedges have conductances of all sizes
    scaled = (sp.diags_array(scale) @ matrix @ sp.diags_array(scale)).tocsc()
    pressure[kept] = drop * scale * spsolve(scaled, scale * inlet[kept], permc_spec="MMD_AT_PLUS_A")
    p = np.nan_to_num(pressure)
    into, out = float((inlet * (drop - p))[kept].sum()), float((outlet * p)[kept].sum())
    by_pair = T * (p[first] - p[second])
    along = np.abs(first - second) == h.shape[1] if h.shape[1] > 1 else np.ones(len(first), bool)
    through_sides = [np.zeros(h.size), np.zeros(h.size)]
    for j, (these, side) in enumerate(((along, grid.cell[1 - axis]), (~along, grid.cell[axis]))):
        for cells in (first, second):
            through_sides[j] += np.bincount(cells[these], by_pair[these] / (2 * side), h.size)
    through_sides[0] += (inlet * (drop - p) + outlet * p) / (2 * grid.cell[1 - axis])
    flux[kept] = np.hypot(*through_sides)[kept]
    spread = [np.moveaxis(values.reshape(h.shape), 0, axis) for values in (pressure, flux)]
    return Leakage(grid, (into + out) / 2, True, spread[0], spread[1], abs(into - out) / max(into, out))


@dataclass(frozen=True, eq=False)
class Distribution(Drawn):
    """Distribution of a field over cells, as a histogram; drawn are its bars.

    Attributes
    ----------
    name : str
    edges : (n + 1,) array
    density : (n,) array
        Share of the cells in a bin over its width.
    """

    name: str
    edges: Array
    density: Array

    @classmethod
    def of(cls, name: str, values: Array, bins: int) -> Distribution:
        """Of values (n,)."""
        density, edges = np.histogram(values, bins, density=True)
        return cls(name, edges, density)

    def _draw_in(self, ax: Axes, units: Units) -> None:
        ax.stairs(self.density, self.edges, fill=True, alpha=0.6)
        ax.set_xlabel(units.axis_label(self.name, "stress" if self.name == "pressure" else "length"))
        ax.set_ylabel("probability density")
