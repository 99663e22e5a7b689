"""Estimated errors of a half-space's contact, from its edge cells and from the next coarser grid of its nesting.

At a straight edge along the cells the pressure is K sqrt(s) of the distance s, whatever the loads, and the error of
uniform pressures depends only on where in its cell the edge lies. So does the ratio of the last two pressures, which
gives the error (`EDGE_ERROR`, from Westergaard's wavy surface on fine grids). Other edges are parted as in `edge`.

Inside, the change from the grid of cells twice as large counts. A smooth pressure has a third of it as its error, one
with a kink or a logarithm about all.

The largest pressure is that of a cell. Below a rounded tip the pressure is p0 - C r^s: s is 2 where the surface is
smooth, n - 1 below a tip r^n. Its means over squares of 2, 4 and 6 cells round the largest pressure lack C' 2^s, C' 4^s
and C' 6^s, from which s and p0 follow. Below a cone or a wedge s is 0, a logarithm: the pressure has no bound.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.ndimage

from fecontact.bodies.halfspace.edge import EdgeCells, edge_area
from fecontact.bodies.halfspace.nested import blocks
from fecontact.common.arrays import Array, Mask
from fecontact.common.error_estimate import NO_CONTACT, ErrorEstimate

#: Ratio of the last two pressures at a straight edge.
EDGE_RATIO = np.array([0.0, 0.05, 0.1, 0.175, 0.18, 0.19, 0.2, 0.222, 0.25, 0.3, 0.37, 0.46, 0.6, 0.622, 0.65, 0.7])
#: Root of the summed squared errors of a row's cells there, over the last pressure but one.
EDGE_ERROR = np.array(
    [0.056, 0.068, 0.107, 0.177, 0.131, 0.07, 0.044, 0.022, 0.036, 0.061, 0.072, 0.062, 0.015, 0.006, 0.011, 0.037]
)
#: Factor on it, for edges that run across the cells.
OBLIQUE = 1.1
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
LEAST_SHARE, AREA_SHARE, AREA_SHARE_STEEP = 0.25, 0.35, 0.65
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


def grid_error_estimate(
    pressure: Array,
    coarse: Array | None,
    modelled: tuple[slice, slice],
    edge: EdgeCells,
    points: bool = False,
    ends: Mask | None = None,
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
    squares = np.interp(edge.last / edge.before, EDGE_RATIO, EDGE_ERROR) ** 2 @ (edge.share * edge.before**2)
    counted, change_over_error, usual = np.ones(pressure.shape, bool), CHANGE_OF_POINTS if points else CHANGE, USUAL
    if ends is not None and ends.any():
        change_over_error, usual = CHANGE_OF_OUTLINE, USUAL_OF_OUTLINE
        counted = ~scipy.ndimage.binary_dilation(ends, np.ones((3, 3)), BESIDE)
    norm = float(np.linalg.norm(pressure[counted]))
    if norm == 0:
        return ErrorEstimate.none("not estimated so near an edge where it has no bound")
    at_edge = float(np.sqrt(squares) / norm)
    area = int((pressure > 0).sum())
    by_gaps, by_pressures = edge_area(edge, area)
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
    share, of_area = (1.0, AREA_SHARE_STEEP) if at_rim else (LEAST_SHARE, AREA_SHARE)
    found = ErrorEstimate(
        pressure=error,
        geometry=0.0,
        interior=inside,
        peak=max(peak.error, of_peak, share * error),
        area=max(abs(by_pressures / by_gaps - 1) if by_gaps else 1.0, of_area * error),
        faces_across=across,
    )
    return found if pressure.all() else found.within_resolution()


def _changes(pressure: Array, coarse: Array, counted: Mask) -> tuple[float, float]:
    """Changes from the coarser grid, over whole blocks of counted cells: relative L2 norm, and of the largest."""
    block = blocks(pressure)
    means = block.sum(axis=(-3, -1)) / 4
    inside = ((block > 0) & blocks(counted)).all(axis=(-3, -1))
    change = float(np.linalg.norm((means - coarse)[inside]) / np.linalg.norm(means[inside])) if inside.any() else 0.0
    return change, abs(float(coarse.max()) / float(pressure.max()) - 1)


def _across(pressure: Array, area: int) -> float:
    """Cells across: four times their number over that of the sides around them, on a disc 4/pi; with no edge, all."""
    sides = sum(int(((pressure > 0) != np.roll(pressure > 0, 1, axis)).sum()) for axis in (0, 1))
    return float(16 / np.pi * area / sides) if sides else float(min(pressure.shape))
