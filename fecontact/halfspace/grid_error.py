"""Estimated errors of a half-space's contact, from its edge cells and from the next coarser grid of its nesting.

At a straight edge along the cells the pressure is K sqrt(s) of the distance s, whatever the loads, and the error of
uniform pressures depends only on where in its cell the edge lies. So does the ratio of the last two pressures, which
gives the error (`EDGE_ERROR`, from Westergaard's wavy surface on fine grids). Other edges are parted as in `edge`.

Inside, the change from the grid of cells twice as large counts. A smooth pressure has a third of it as its error, one
with a kink or a logarithm about all.

The largest pressure is that of a cell. Below a rounded tip the pressure is p0 - C r^s: s is 2 where the surface is
smooth, n - 1 below a tip r^n. Its means over squares of 2, 4 and 6 cells round the largest pressure lack C' 2^s, C' 4^s
and C' 6^s, from which s and p0 follow. Below a cone or a wedge s is 0, a logarithm: the pressure has no bound.

Cells at the edge of a contact, and the contact area with its edge located within them.

Counting cells gives the area to first order only. Where the surface is smooth the pressure falls to zero as the square
root of the distance d from the edge and the gap beyond it grows as d^(3/2) (Johnson 1985, *Contact Mechanics*, section
4.2(c)). So a straight line through the squared pressures of the last two cells of each row and column locates the edge,
and so does one through the gaps^(2/3) of the first two cells beyond it. Gaps are the more accurate, as displacements
are; pressures count where the gap does not grow, as between near patches of rough surfaces. Rows and columns each give
an area, as the divergence theorem needs one direction only; each edge is weighted by the squared cosine between its
normal and that direction. Where the counter-surface itself ends, as under a flat punch, the edge is known and not
corrected.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.error_estimate import NO_CONTACT, ErrorEstimate, UnboundedPeak
from fecontact.halfspace.grid import Grid, block_sums

#: Largest correction of an edge, in cells.
FARTHEST = 1.0

#: Mean pressure at an end over that of the contact, below which the pressure falls to zero there.
FALLS = 0.3


class EdgeCells(NamedTuple):
    """Last cells of rows and columns of a contact, beside cells without pressure under the counter-surface.

    Attributes
    ----------
    last, before : (n,) arrays
        Pressure of the last cell and of the one before.
    gap, beyond : (n,) arrays
        Gap of the first cell outside and of the one beyond it; zero where it is in contact or has no counter-surface.
    share : (n,) array
        Squared cosine between the edge's normal and the row or column, taken at the cell before.
    place : (2, n) int array
        Indices of the last cell.
    """

    last: Array
    before: Array
    gap: Array
    beyond: Array
    share: Array
    place: IntArray

    @property
    def excess(self) -> tuple[Array, Array]:
        """Areas (n,) in cells beyond the last cells, negative where the contact ends within; by gaps, by pressures."""
        one, other = (self.share * beyond for beyond in self.ends)
        return one, other

    @property
    def ends(self) -> tuple[Array, Array]:
        """Ends (n,) of rows and columns beyond their last cells, in cells; by gaps, by pressures."""
        square, falls = self.last**2, self.before > self.last
        # from the middle of the last cell
        reach = np.where(falls, square / np.where(falls, self.before**2 - square, 1.0), 0.5)
        near, far = np.cbrt(self.gap**2), np.cbrt(self.beyond**2)
        grows = far > near
        by_gap = np.where(grows, 1.0 - near / np.where(grows, far - near, 1.0), reach)
        one, other = (np.clip(v, 0.5 - FARTHEST, 0.5 + FARTHEST) - 0.5 for v in (by_gap, reach))
        return one, other


def pressed_ends(pressure: Array, allowed: Mask) -> Mask:
    """Cells (nx, ny) in contact beside cells without counter-surface, where the pressure does not fall to zero.

    All of them, or none: that is where their mean pressure is above a part of that of the contact.

    Examples
    --------
    >>> import numpy as np
    >>> flat, round_edge = np.array([[0.0, 2.0, 1.0, 2.0, 0.0]]), np.array([[0.0, 0.1, 1.0, 0.1, 0.0]])
    >>> pressed_ends(flat, flat > 0).tolist(), bool(pressed_ends(round_edge, flat > 0).any())
    ([[False, True, False, True, False]], False)
    """
    active = pressure > 0
    open_beside = [~np.roll(allowed, step, axis) for axis in (0, 1) for step in (-1, 1)]
    ends = active & np.any(open_beside, axis=0)
    if ends.any() and pressure[ends].mean() > FALLS * pressure[active].mean():
        return np.asarray(ends)
    return np.zeros(pressure.shape, bool)


def edge_cells(pressure: Array, gap: Array, periodic: bool) -> EdgeCells:
    """Edge cells of all rows and columns; those of contacts one cell wide are left out.

    Parameters
    ----------
    pressure : (nx, ny) array
    gap : (nx, ny) array
        After deformation; infinite where there is no counter-surface.
    periodic : bool
    """
    parts = [edge_one_way(pressure, gap, axis, step, periodic) for axis in (0, 1) for step in (-1, 1)]
    return EdgeCells(*(np.concatenate(part, axis=-1) for part in zip(*parts, strict=True)))


def edge_one_way(pressure: Array, gap: Array, axis: int, step: int, periodic: bool) -> EdgeCells:
    """Edge cells facing one way; step -1: the contact ends at the upper side, 1: at the lower side."""
    active, allowed = pressure > 0, np.isfinite(gap)
    outside = np.where(active | ~allowed, 0.0, np.maximum(gap, 0.0))

    def beside(values: NDArray, by: int) -> NDArray:
        rolled = np.roll(values, by, axis)
        if not periodic:
            lines = np.moveaxis(rolled, axis, 0)
            lines[slice(0, by) if by > 0 else slice(by, None)] = 0
        return rolled

    at = np.array(np.nonzero(active & ~beside(active, step) & beside(allowed, step) & beside(active, -step)))
    before = at.copy()
    before[axis] = (before[axis] + step) % pressure.shape[axis]
    slope = [_slope(pressure, before, k) for k in (0, 1)]
    total = slope[0] + slope[1]
    share = np.divide(slope[axis], total, out=np.full(total.shape, 0.5), where=total > 0)
    beyond = (beside(outside, step)[tuple(at)], beside(outside, 2 * step)[tuple(at)])
    return EdgeCells(pressure[tuple(at)], pressure[tuple(before)], *beyond, share, at)


def _slope(pressure: Array, at: NDArray, axis: int) -> Array:
    """Squared differences (n,) of squared pressures beside cells (2, n), along an axis."""
    low, high = at.copy(), at.copy()
    low[axis] -= 1
    high[axis] = (high[axis] + 1) % pressure.shape[axis]
    return np.asarray((pressure[tuple(high)] ** 2 - pressure[tuple(low)] ** 2) ** 2)


def edge_area(edge: EdgeCells, count: int) -> tuple[float, float]:
    """Contact area in cells, from their number and those at its edge, by gaps; and by pressures alone.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.arange(-9.5, 10.0)[:, None]  # a strip of half-width 6.8
    >>> strip = np.sqrt(np.maximum(6.8**2 - x**2, 0.0)) * np.ones(20)
    >>> gap = np.maximum(np.abs(x) - 6.8, 0.0) ** 1.5 * np.ones(20)
    >>> by_gaps, by_pressures = edge_area(edge_cells(strip, gap, True), 14 * 20)
    >>> bool(abs(by_gaps / 20 - 2 * 6.8) < 1e-9), bool(abs(by_pressures / 20 - 2 * 6.8) < 0.1)
    (True, True)
    """
    by_gaps, by_pressures = (count + float(excess.sum()) for excess in edge.excess)
    return by_gaps, by_pressures


#: Ratio of the last two pressures at a straight edge.
EDGE_RATIO = np.array([0.0, 0.05, 0.1, 0.175, 0.18, 0.19, 0.2, 0.222, 0.25, 0.3, 0.37, 0.46, 0.6, 0.622, 0.65, 0.7])
#: Root of the summed squared errors of a row's cells there, over the last pressure but one.
EDGE_ERROR = np.array(
    [0.056, 0.068, 0.107, 0.177, 0.131, 0.07, 0.044, 0.022, 0.036, 0.061, 0.072, 0.062, 0.015, 0.006, 0.011, 0.037]
)
#: Factor on it, for edges that run across the cells.
OBLIQUE = 1.1
#: The same at an edge of the contact beside cells that yield, where the pressure falls within a cell.
JUMP = 0.25
#: With no coarser grid: factor for what is inside as well, and least error times the cells across, usual for a disc
#: and for a stepped outline.
ALONE, USUAL, USUAL_OF_OUTLINE = 1.5, 0.2, 0.6
#: Change from the coarser grid over the error inside, of pressures over cells, of point forces, and under ends of the
#: counter-surface, whose outline a coarser grid widens.
CHANGE, CHANGE_OF_POINTS, CHANGE_OF_OUTLINE = 1.2, 0.7, 5.0
#: Cells beside those with a pressure without bound that do not count either.
BESIDE = 2
#: Least error of the largest pressure and of the area, as shares of that of the pressure; of the area where the
#: pressure is largest at its edge, which is steep there: punches r^10 on 24 cells are off by .93 of it.
MIN_SHARE, AREA_SHARE, AREA_SHARE_STEEP = 0.25, 0.43, 0.65
#: Error of the area by many spots, and holes, of few cells: a share of the relative difference of counted cells and
#: outline, about half the outline's length times a cell over the area, and as its square where it is small. Chosen on
#: 34 self-affine surfaces; on 20 others, on 64 and 128 cells along an axis beside 512, the estimate was at least .74 of
#: the error, and within .8 and 3 of it in three quarters; where it is more, errors vanish by chance.
OUTLINE, SMALL_OUTLINE = 0.75, 0.03
#: Error of a pressure that is so steep at its edge over that of a square root.
STEEP = 1.3
#: Exponents s below a tip, and (3^s - 1) / (2^s - 1), the ratio of what means over 6 and 4 cells lack of that over 2.
TIPS = np.linspace(0.05, 2.0, 40)
TIP_RATIOS = (3**TIPS - 1) / (2**TIPS - 1)
#: Ratio up to which it is a logarithm, for which it is log 3 / log 2 = 1.585; cones have 1.54 to 1.59, r^1.2 1.61 to
#: 1.69.
LOGARITHM = 1.598
#: Distance in cells, and as a share of the contact's width, up to which a largest pressure is one at the edge and as
#: much in error as the pressure there.
AT_EDGE, AT_EDGE_OF_WIDTH = 2.5, 0.25


#: Exponent of the inverse distance with which the pressure grows towards the end of a counter-surface.
PUNCH = 0.5


class Peak(NamedTuple):
    """Largest pressure of a grid: its relative error, whether it has no bound, and its distance from the edge."""

    error: float
    unbounded: bool
    depth: float


def peak_of(pressure: Array) -> Peak:
    """The largest pressure and what the cells around it tell of it.

    Parameters
    ----------
    pressure : (nx, ny) array

    Examples
    --------
    Means over cells below a cone and of a paraboloid:

    >>> x = (np.arange(640) - 319.5) / 320
    >>> r = np.hypot(x[:, None], x[None, :])
    >>> cone, round_one = (p.reshape(32, 20, 32, 20).mean(axis=(1, 3)) for p in (np.arccosh(1 + 1 / r), 2 - r**2))
    >>> peak_of(cone).unbounded, peak_of(round_one).unbounded
    (True, False)
    >>> bool(abs(peak_of(round_one).error - (2 / round_one.max() - 1)) < 1e-5)
    True
    """
    i, j = np.unravel_index(int(pressure.argmax()), pressure.shape)
    around = np.arange(-3, 4)
    near = np.take(np.take(pressure, i + around, 0, mode="wrap"), j + around, 1, mode="wrap")
    means = (near[2:4, 2:4].mean(), near[2:4, 3:5].mean(), near[3:5, 2:4].mean(), near[3:5, 3:5].mean())
    a, b = divmod(int(np.argmax(means)), 2)
    six = near[a : a + 6, b : b + 6]
    two, four = float(max(means)), float(six[1:5, 1:5].mean())
    ratio = (two - float(six.mean())) / (two - four) if six.all() and two > four else np.inf
    rest = (two - four) / (2 ** float(np.interp(ratio, TIP_RATIOS, TIPS)) - 1)
    highest = float(pressure[i, j])
    depth = float(np.hypot(*np.meshgrid(around, around))[near == 0].min(initial=np.inf))
    return Peak(abs(two + rest - highest) / highest, ratio < LOGARITHM, depth)


def cells_error_estimate(
    grid: Grid,
    pressure: Array,
    gap: Array,
    coarse: Array | None,
    modelled: tuple[slice, slice],
    edge: EdgeCells,
    points: bool,
    reserve: Array | None = None,
    dent: Array | None = None,
) -> ErrorEstimate:
    """Errors of a contact from its pressure and gap (nx, ny); where the pressure has no bound is named.

    With a hardness also from what the pressure lacks of it, zero where the surface yields, and from the dent: at the
    edge of what yields they are as pressure and gap at that of the contact. Other parameters are as in
    `grid_error_estimate`.
    """
    allowed, extra = np.isfinite(gap), 0.0
    ends = pressed_ends(pressure, allowed)
    if reserve is not None and dent is not None and reserve.min() == 0:
        ends &= reserve > 0
        inner = edge_cells(reserve, np.where(allowed, dent, np.inf), False)
        beside = scipy.ndimage.binary_dilation(reserve == 0)[tuple(edge.place)]
        extra = _squares(inner) + float((JUMP * edge.before[beside]) ** 2 @ edge.share[beside])
    found = grid_error_estimate(pressure, coarse, modelled, edge, points, ends, extra)
    if ends.any():
        at, order = np.where(ends, pressure, 0.0), PUNCH
    elif reserve is not None and reserve.min() == 0:
        return replace(found, peak=MIN_SHARE * found.pressure)  # it is the hardness
    elif pressure.any() and peak_of(pressure).unbounded:
        at, order = pressure, 0.0
    else:
        return found
    i, j = np.unravel_index(np.argmax(at), at.shape)
    place = (float(grid.x[i]), float(grid.y[j]), 0.0)
    return replace(found, peak=np.inf, unbounded=UnboundedPeak("counter-surface", place, order))


def grid_error_estimate(
    pressure: Array,
    coarse: Array | None,
    modelled: tuple[slice, slice],
    edge: EdgeCells,
    points: bool = False,
    ends: Mask | None = None,
    extra: float = 0.0,
) -> ErrorEstimate:
    """Estimate the errors of a contact.

    Parameters
    ----------
    pressure : (nx, ny) array
    coarse : (mx, my) array or None
        On cells twice as large, over the modelled part; None if there was no coarser grid.
    modelled : (slice, slice)
        Part of the grid that was solved, by symmetry.
    edge : EdgeCells
    points : bool
        Whether the pressure of a cell is a force at its centre.
    ends : (nx, ny) bool array, optional
        Cells with a pressure without bound; these and their neighbours do not count.
    extra : float
        Sum of squared errors of cells at other edges.

    Examples
    --------
    >>> p, whole = np.ones((4, 4)), (slice(None), slice(None))
    >>> nothing = EdgeCells(*np.zeros((5, 0)), np.zeros((2, 0), int))
    >>> round(grid_error_estimate(p, 1.012 * np.ones((2, 2)), whole, nothing).pressure, 9)
    0.01
    """
    if not pressure.any():
        return ErrorEstimate.none(NO_CONTACT)
    if points and coarse is None:
        return ErrorEstimate.none("not estimated for point forces on a grid without a coarser one")
    squares = _squares(edge) + extra
    counted, change_over_error, usual = np.ones(pressure.shape, bool), CHANGE_OF_POINTS if points else CHANGE, USUAL
    if ends is not None and ends.any():
        change_over_error, usual = CHANGE_OF_OUTLINE, USUAL_OF_OUTLINE
        counted = ~scipy.ndimage.binary_dilation(ends, np.ones((3, 3)), BESIDE)
    norm = float(np.linalg.norm(pressure[counted]))
    if norm == 0:
        return ErrorEstimate.none("not estimated so near an edge where it has no bound")
    at_edge = float(np.sqrt(squares) / norm)
    area = int((pressure > 0).sum())
    outline, _ = edge_area(edge, area)
    within = abs(area / outline - 1) if outline else 1.0
    across = _across(pressure, area)
    peak = peak_of(pressure)
    if coarse is None:
        inside, of_peak, error = 0.0, 0.0, max(ALONE * at_edge, usual / across)
    else:
        change, of_peak = _changes(pressure[modelled], coarse, counted[modelled])
        inside = change / change_over_error
        error = float(np.hypot(OBLIQUE * at_edge, inside))
    at_rim = peak.depth <= min(AT_EDGE, AT_EDGE_OF_WIDTH * across)
    error = min(1.0, STEEP * error if at_rim else error)
    share, of_area = (1.0, AREA_SHARE_STEEP) if at_rim else (MIN_SHARE, AREA_SHARE)
    found = ErrorEstimate(
        pressure=error,
        geometry=0.0,
        interior=inside,
        peak=max(peak.error, of_peak, share * error),
        area=max(OUTLINE * within**2 / (within + SMALL_OUTLINE), of_area * error),
        faces_across=across,
    )
    return found if pressure.all() else found.within_resolution()


def _squares(edge: EdgeCells) -> float:
    """Sum of the squared errors of rows at straight edges."""
    return float(np.interp(edge.last / edge.before, EDGE_RATIO, EDGE_ERROR) ** 2 @ (edge.share * edge.before**2))


def _changes(pressure: Array, coarse: Array, counted: Mask) -> tuple[float, float]:
    """Changes from the coarser grid, over whole blocks of counted cells: relative L2 norm, and of the largest."""
    means, inside = block_sums(pressure) / 4, block_sums(((pressure > 0) & counted).astype(np.int8)) == 4
    change = float(np.linalg.norm((means - coarse)[inside]) / np.linalg.norm(means[inside])) if inside.any() else 0.0
    return change, abs(float(coarse.max()) / float(pressure.max()) - 1)


def _across(pressure: Array, area: int) -> float:
    """Cells across: four times their number over that of the sides around them, on a disc 4/pi; with no edge, all."""
    sides = sum(int(((pressure > 0) != np.roll(pressure > 0, 1, axis)).sum()) for axis in (0, 1))
    return float(16 / np.pi * area / sides) if sides else float(min(pressure.shape))
