"""Nested iteration: the solution on a coarse grid, interpolated to the next finer one, is the start there.

Every grid is solved only around the expected contact. The gaps of the whole grid are checked afterwards: where the
surfaces penetrate outside the part, it is enlarged and solved again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.fft

from fecontact.common.arrays import Array, Mask
from fecontact.halfspace.bounded import solve_bounded
from fecontact.halfspace.cg import GridIterate, GridProblem, solve_on_grid
from fecontact.halfspace.fft import (
    Convolution,
    Corrected,
    DampedInverse,
    DiagonalTerm,
    Product,
    Tally,
    Term,
    kernel_spectrum,
)
from fecontact.halfspace.grid import Even, block_sums

#: Largest number of cells per side of the coarsest grid.
COARSEST = 24

#: Tolerance on the coarser grids, below their discretisation error; on the next coarser, whose pressure tells the error
#: of the finest.
COARSE_TOLERANCE, NEXT_TOLERANCE = 1e-3, 1e-4

#: Tolerance from which single precision suffices throughout.
ROUGH_ENOUGH = 1e-4

#: 16/3 / sqrt(pi), times E* over the side of a square cell and its displacement by unit pressure on it (Love 1929).
HERTZ = 16 / 3 / math.sqrt(math.pi) * 4 * math.log(1 + math.sqrt(2)) / math.pi

#: Cells added round the expected contact, besides a thirtieth of its width.
MARGIN = 2

#: Mean gap, over the largest, at which the force on a periodic surface counts as unbounded.
MEAN_PLANE = 1e-9

#: Share of the grid above which the whole grid is solved instead of a part.
WORTHWHILE = 0.75


@dataclass(frozen=True, eq=False)
class GridLevel:
    """The contact problem on one grid, on the half or quarter with positive coordinates where it is symmetric.

    Attributes
    ----------
    kernel : (kx, ky) array
        Free: displacements at offsets 0, 1, ... cells by unit pressure on a cell. Periodic: spectrum (half the number
        of cells plus one in each direction).
    periodic : bool
    g : (nx, ny) array
        Gap without pressure; any finite number where there is no counter-surface.
    allowed : (nx, ny) bool array
    B : (m, nx, ny) array
    F : (m,) array
        Loads; with symmetry, those of the modelled part.
    symmetric : (bool, bool)
    smooth : tuple of Term
        Additions to the compliance, over the modelled part.
    bound : (nx, ny) array, optional
        Largest pressures, see `GridProblem`.
    depth : int
        How often the grid was coarsened by two.
    """

    kernel: Array
    periodic: bool
    g: Array
    allowed: Mask
    B: Array
    F: Array
    symmetric: Even
    smooth: tuple[Term, ...] = ()
    bound: Array | None = None
    depth: int = 0

    @property
    def whole(self) -> tuple[slice, slice]:
        """The part that covers the whole grid."""
        return slice(0, self.g.shape[0]), slice(0, self.g.shape[1])

    @cached_property
    def convolution(self) -> Convolution:
        """Product with the kernel among all cells."""
        return Convolution.of_grid(self.kernel, self.periodic, self.g.shape, self.symmetric)

    @property
    def is_bounded(self) -> bool:
        """False if no pressures open the gaps: beyond the mean plane of a periodic surface, which none displaces."""
        stiff = self.periodic and not self.kernel[0, 0] and not len(self.F) and self.allowed.all()
        size = float(np.abs(self.g).max()) if stiff else 0.0
        return not (size and self.g.min() < 0 and self.g.mean() <= MEAN_PLANE * size)


def compliance(level: GridLevel, part: tuple[slice, slice], tally: Tally, workers: int | None) -> Product:
    """Compliance among the cells of a part of a grid."""
    shape = (part[0].stop - part[0].start, part[1].stop - part[1].start)
    if part == level.whole:
        convolution = replace(level.convolution, tally=tally, workers=workers)
    else:
        convolution = Convolution.of_grid(level.kernel, level.periodic, shape, level.symmetric, tally, workers)
    return Corrected(convolution, tuple(term.part(part) for term in level.smooth)) if level.smooth else convolution


def preconditioner(
    level: GridLevel, part: tuple[slice, slice], tally: Tally, workers: int | None
) -> Convolution | DampedInverse:
    """Inverse symbol of the compliance of a part, as if periodic, without padding; with that of cells by themselves."""
    shape = (part[0].stop - part[0].start, part[1].stop - part[1].start)
    spectrum = level.kernel
    if not level.periodic:
        cells = _cells(shape, level.symmetric)
        halves = tuple(max(1, (n + 1) // 2) for n in cells)
        spectrum = kernel_spectrum(level.kernel[: cells[0], : cells[1]], (halves[0], halves[1]))
    largest = float(spectrum.max())
    inverse = 1 / np.where(spectrum > 1e-9 * largest, spectrum, largest)
    bodies = Convolution.even(inverse, shape, level.symmetric, tally, product=False, workers=workers)
    alone = [term.own[part] for term in level.smooth if isinstance(term, DiagonalTerm)]
    if not alone:
        return bodies
    own = float(spectrum.mean())
    both = own + np.sum(alone, axis=0)
    return DampedInverse(bodies, np.sqrt(own / both), (1 - own / both) / both)


def _cells(shape: tuple[int, int], symmetric: Even) -> tuple[int, int]:
    return (shape[0] * (1 + symmetric[0]), shape[1] * (1 + symmetric[1]))


def coarser(level: GridLevel, kernel: Array) -> GridLevel:
    """The level on cells twice as large; a row that extends beyond the grid has no counter-surface.

    Gaps and bounds are means, rows are sums over the cells that have a counter-surface.
    """
    count = block_sums(level.allowed.astype(np.int8))
    everywhere = bool(level.allowed.all())
    g = block_sums(level.g if everywhere else level.g * level.allowed) / np.maximum(count, 1)
    B = block_sums(level.B if everywhere else level.B * level.allowed)
    smooth = tuple(term.coarser() for term in level.smooth)
    bound = level.bound
    if bound is not None:
        bound = block_sums(bound if everywhere else np.where(level.allowed, bound, 0.0)) / np.maximum(count, 1)
        bound = np.where(count > 0, bound, np.inf)
    return replace(level, kernel=kernel, g=g, allowed=count > 0, B=B, smooth=smooth, bound=bound, depth=level.depth + 1)


def finer(values: Array, shape: tuple[int, int], symmetric: Even, periodic: bool) -> Array:
    """Values of a coarse grid interpolated linearly at the cells of the next finer one, of the given shape."""
    for axis in (0, 1):
        v = np.moveaxis(values, axis, 0)
        closed = periodic and not symmetric[axis]
        near, far = 0.75 * v, 0.25 * v
        out = np.empty((2 * len(v), v.shape[1]))
        out[0], out[-1] = near[0] + far[-1 if closed else 0], near[-1] + far[0 if closed else -1]
        np.add(near[1:], far[:-1], out=out[2::2])
        np.add(near[:-1], far[1:], out=out[1:-1:2])
        values = np.moveaxis(out[: shape[axis]], 0, axis)
    return np.ascontiguousarray(values)


def start_on(level: GridLevel, coarse: Array) -> tuple[Array, Mask]:
    """Start (nx, ny) and active cells of a level from the pressures of the next coarser one.

    Squares of the pressure fall linearly to the edge. Continued so to the next cell outside and interpolated, they tell
    where the edge is within the coarse cells. Beyond these all is zero.
    """
    shape, whole = level.g.shape, (slice(0, coarse.shape[0]), slice(0, coarse.shape[1]))
    start, active = np.zeros(shape), np.zeros(shape, bool)
    box = whole if level.periodic else around(coarse > 0, level.symmetric)
    part = tuple(slice(2 * s.start, min(2 * s.stop, n)) for s, n in zip(box, shape, strict=True))
    squares = _continued(coarse[box] ** 2, level.symmetric, level.periodic)
    squares = finer(squares, start[part].shape, level.symmetric, level.periodic)
    np.logical_and(squares > 0, level.allowed[part], out=active[part])
    np.sqrt(np.maximum(squares, 0.0, out=squares), out=start[part])
    return start, active


def _continued(squares: Array, symmetric: Even, periodic: bool) -> Array:
    """Values (nx, ny), positive where there is contact, continued linearly to the zeros beside, where they fall."""
    total, count = np.zeros(squares.shape), np.zeros(squares.shape)
    for axis in (0, 1):
        v = np.moveaxis(squares, axis, 0)
        ends = [(2, 2), (0, 0)]
        wide = np.pad(v, ends, "wrap" if periodic else "symmetric")
        if not symmetric[axis] and not periodic:
            wide[:2] = 0.0
        if not periodic:
            wide[-2:] = 0.0
        for near, far in ((wide[1:-3], wide[:-4]), (wide[3:-1], wide[4:])):
            found = (v == 0) & (near > 0) & (far > 0)
            np.moveaxis(total, axis, 0)[found] += (2 * near - far)[found]
            np.moveaxis(count, axis, 0)[found] += 1
    return squares + np.minimum(total, 0.0) / np.maximum(count, 1)


def around(active: Mask, symmetric: Even) -> tuple[slice, slice]:
    """Part of a grid round the cells that may touch, of a size with a fast transform."""
    out = []
    for axis in (0, 1):
        hit = np.flatnonzero(active.any(axis=1 - axis))
        n = active.shape[axis]
        if len(hit) == 0:
            return slice(0, active.shape[0]), slice(0, active.shape[1])
        margin = MARGIN + int(hit[-1] - hit[0]) // 30
        first = 0 if symmetric[axis] else max(0, int(hit[0]) - margin)
        wanted = scipy.fft.next_fast_len(int(hit[-1]) + 1 + margin - first, real=True)
        last = min(n, first + wanted)
        out.append(slice(first, last))
    return out[0], out[1]


def solve_level(
    level: GridLevel, start: Array, active: Mask, tolerance: float, tally: Tally, workers: int | None
) -> GridIterate:
    """Solve on the part of a grid round the start's contact, enlarged while there is contact beyond it.

    Displacements outside the part are found with it.
    """
    part = level.whole if level.periodic else around(active, level.symmetric)
    if _share(part, level) > WORTHWHILE:
        part = level.whole
    while True:
        exact, inverse = compliance(level, part, tally, workers), preconditioner(level, part, tally, workers)
        rough = exact
        if not (level.periodic and active.all()):  # in full contact of a periodic one the inverse is exact
            rough, inverse = exact.rough, inverse.rough
        problem = GridProblem(
            exact if tolerance < ROUGH_ENOUGH else rough,
            rough,
            inverse,
            level.g[part],
            level.allowed[part],
            level.B[:, *part],
            level.F,
            bound=None if level.bound is None else level.bound[part],
        )
        at = solve_on_grid(problem, start[part], active[part], tolerance)
        if not at.converged and level.bound is not None:
            at = solve_bounded(problem, at, tolerance)
            if not at.converged and part != level.whole:  # what a part does not bear the whole may
                part = level.whole
                continue
        if part == level.whole:
            return at
        at = _spread(at, level, part, tolerance, tally, workers)
        if _reaches_border(at.active, part):
            start, active, part = at.p, at.active, level.whole
            continue
        missed = _penetrating(at, level, tolerance)
        missed[part] = False
        if not missed.any():
            return at
        start, active = at.p, at.active | missed
        missed[part] = True
        part = around(missed, level.symmetric)
        if _share(part, level) > WORTHWHILE:
            part = level.whole


def _share(part: tuple[slice, slice], level: GridLevel) -> float:
    return (part[0].stop - part[0].start) * (part[1].stop - part[1].start) / level.g.size


def _spread(
    at: GridIterate, level: GridLevel, part: tuple[slice, slice], tolerance: float, tally: Tally, workers: int | None
) -> GridIterate:
    """Solution on a part as arrays over the whole grid."""
    p, active = np.zeros(level.g.shape), np.zeros(level.g.shape, bool)
    p[part], active[part] = at.p, at.active
    operator = compliance(level, level.whole, tally, workers)
    if tolerance >= ROUGH_ENOUGH:
        operator = operator.rough
    return replace(at, p=p, u=operator.apply(p), active=active, recomputed=tolerance < ROUGH_ENOUGH)


def _penetrating(at: GridIterate, level: GridLevel, tolerance: float) -> Mask:
    """Cells whose surfaces penetrate by more than a tolerance of the largest displacement."""
    gap = at.u + level.g + np.einsum("k,kij->ij", at.q, level.B)
    largest = float(np.abs(at.u).max(where=level.allowed, initial=0.0))
    return np.asarray(level.allowed & (gap < -tolerance * largest))


def _reaches_border(active: Mask, part: tuple[slice, slice]) -> bool:
    """Whether cells in contact lie at a border of the part inside the grid."""
    touching = False
    for axis in (0, 1):
        lines = np.moveaxis(active, axis, 0)
        first, last = part[axis].start, part[axis].stop
        touching |= first > 0 and bool(lines[first].any())
        touching |= last < len(lines) and bool(lines[last - 1].any())
    return touching


#: Solution of a level from a start and active cells, as by `solve_level`.
LevelSolver = Callable[[GridLevel, Array, Mask, float, Tally, int | None], GridIterate]


def solve_nested(
    level: GridLevel,
    kernel_of: Callable[[int], Array],
    tolerance: float,
    tally: Tally,
    workers: int | None = None,
    solve: LevelSolver = solve_level,
) -> tuple[GridIterate, int, Array | None]:
    """Solve on a grid, starting from coarser ones.

    Parameters
    ----------
    level : GridLevel
        The finest level.
    kernel_of : function of int
        Kernel of the grid coarsened that many times by two.
    tolerance : float
        See `solve_on_grid`.
    tally : Tally
    workers : int, optional
    solve : callable
        Of each level.

    Returns
    -------
    iterate : GridIterate
        Solution on the finest grid.
    n_levels : int
    coarse : (mx, my) array or None
        Pressure on the next coarser grid; None without one.
    """
    start, active, n_levels, coarse = solve_coarser(level, kernel_of, tolerance, tally, workers, solve)
    return solve(level, start, active, tolerance, tally, workers), n_levels, coarse


def solve_coarser(
    level: GridLevel,
    kernel_of: Callable[[int], Array],
    tolerance: float,
    tally: Tally,
    workers: int | None = None,
    solve: LevelSolver = solve_level,
) -> tuple[Array, Mask, int, Array | None]:
    """Start (nx, ny) and active cells of a grid from coarser ones; number of grids, pressure on the next coarser."""
    levels = [level]
    while max(_cells(levels[-1].g.shape, level.symmetric)) > COARSEST and can_coarsen(levels[-1]):
        levels.append(coarser(levels[-1], kernel_of(len(levels))))
        if not levels[-1].is_bounded:  # larger cells have closed holes of the counter-surface
            levels.pop()
            break
    first, coarse = levels[-1], None
    start, active = first_start(first)
    for k in range(len(levels) - 1, 0, -1):
        within = max(tolerance, COARSE_TOLERANCE) if k > 1 else NEXT_TOLERANCE
        at = solve(levels[k], start, active, within, tally, workers)
        coarse = np.maximum(at.p, 0.0)
        start, active = start_on(levels[k - 1], coarse)
    return start, active, len(levels), coarse


def first_start(level: GridLevel) -> tuple[Array, Mask]:
    """Start (nx, ny) and active cells of the coarsest grid: overlapping cells if the approach is prescribed.

    Under a force the cells below the height d at which F = 16/3 E* sqrt(A/pi) (d - mean height below), as of Hertz's
    paraboloid, and pressures as the root of their depth; all cells where the first row is not that of a force.
    """
    none, allowed = np.zeros(level.g.shape), level.allowed
    if not len(level.F):
        return none, allowed & (level.g < 0)
    rows = level.B[0][allowed]
    if rows.min() * rows.max() <= 0:
        return none, allowed
    total = float(level.F[0] / rows[np.abs(rows).argmax()])
    if total <= 0:
        return none, allowed
    g, images = np.sort(level.g[allowed]), 2 ** sum(level.symmetric)
    count, own = np.arange(1, len(g) + 1), float(level.kernel.mean() if level.periodic else level.kernel[0, 0])
    borne = HERTZ / own * np.sqrt(count * images) * (g - np.cumsum(g) / count)
    d = g[min(int(np.searchsorted(borne, total * images)), len(g) - 1)]
    depth = np.where(allowed, np.sqrt(np.maximum(d - level.g, 0.0)), 0.0)
    return depth * (total / (float(depth.sum()) or 1.0)), allowed & (level.g <= d)


def can_coarsen(level: GridLevel) -> bool:
    """Whether the level can be coarsened: a period must remain an even number of cells."""
    cells = _cells(level.g.shape, level.symmetric)
    return min(cells) >= 8 and (not level.periodic or (cells[0] % 4 == 0 and cells[1] % 4 == 0))
