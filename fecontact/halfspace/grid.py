"""Rectangular grids of equal cells on the surface of a half-space, and that surface in a scene.

Mirror symmetry of a problem about the middle of its grid: detection, reduction and expansion. Sums of blocks of cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import array_of, positives
from fecontact.common.errors import InputError, shown
from fecontact.surfaces.facet_surface import FacetSurface, Projection

#: Cells of a grid, beyond which one field fills 8 GB.
MAX_CELLS = 10**9


@dataclass(frozen=True)
class Grid:
    """Cells of equal size on a rectangle centred on the origin.

    Parameters
    ----------
    size : (float, float)
        Sides of the rectangle along x and y.
    shape : (int, int)
        Number of cells along x and y, at least 2 each.

    Raises
    ------
    InputError
        If sides are not positive, or numbers of cells are not integers of at least 2.

    Examples
    --------
    >>> grid = Grid((4.0, 2.0), (4, 2))
    >>> grid.cell, grid.x.tolist()
    ((1.0, 1.0), [-1.5, -0.5, 0.5, 1.5])
    """

    size: tuple[float, float]
    shape: tuple[int, int]

    def __post_init__(self) -> None:
        counts = array_of(self.shape)
        if counts is None or counts.shape != (2,) or not (counts >= 2).all() or (counts % 1).any():
            raise InputError(
                f"A grid's shape must be two whole numbers of cells, at least 2; found {shown(self.shape)}.",
                code="grid-shape",
            )
        if counts.prod() > MAX_CELLS:
            raise InputError(f"A grid of {counts[0]:g} x {counts[1]:g} cells does not fit into memory; take fewer.")
        object.__setattr__(self, "size", positives("a grid's size", self.size, 2))
        object.__setattr__(self, "shape", (int(counts[0]), int(counts[1])))

    @property
    def cell(self) -> tuple[float, float]:
        """Sides of a cell."""
        return self.size[0] / self.shape[0], self.size[1] / self.shape[1]

    @property
    def area(self) -> float:
        """Area of a cell."""
        return self.cell[0] * self.cell[1]

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]

    @cached_property
    def x(self) -> Array:
        """Centres (nx,) of the cells along x; exactly antisymmetric."""
        return _centres(self.size[0], self.shape[0])

    @cached_property
    def y(self) -> Array:
        """Centres (ny,) of the cells along y; exactly antisymmetric."""
        return _centres(self.size[1], self.shape[1])

    @property
    def coarser(self) -> Grid:
        """The grid of cells twice as large that covers this one; it may extend beyond by one row of cells."""
        counts = ((self.shape[0] + 1) // 2, (self.shape[1] + 1) // 2)
        dx, dy = self.cell
        return Grid((2 * dx * counts[0], 2 * dy * counts[1]), counts)


def _centres(side: float, n: int) -> Array:
    return np.asarray((np.arange(n) - (n - 1) / 2) * (side / n), dtype=float)


Even = tuple[bool, bool]

#: Difference of mirrored values, relative to the largest, that counts as rounding.
ROUNDING = 1e-14


def even_axes(values: Array, allowed: Mask, rows: Array) -> Even:
    """Axes about whose middle values (nx, ny), mask (nx, ny) and rows (m, nx, ny) are mirror images.

    Examples
    --------
    >>> import numpy as np
    >>> z = np.array([[1.0, 2.0], [1.0, 2.0]])
    >>> even_axes(z, z > 0, np.ones((1, 2, 2)))
    (True, False)
    """
    fields = [values, *rows] if allowed.all() else [values, *rows, allowed.astype(float)]
    limits = [ROUNDING * max(float(field.max()), -float(field.min())) for field in fields]
    out = []
    for axis, n in enumerate(values.shape):
        halves = (np.split(np.moveaxis(field, axis, 0), [n // 2]) for field in fields if n % 2 == 0)
        off = (low - high[::-1] for low, high in halves)
        within = (max(float(d.max()), -float(d.min())) <= limit for d, limit in zip(off, limits, strict=False))
        out.append(n % 2 == 0 and all(within))
    return out[0], out[1]


def part_of(shape: tuple[int, int], symmetric: Even) -> tuple[slice, slice]:
    """The half or quarter with positive coordinates."""
    x, y = (slice(n // 2 if even else 0, n) for n, even in zip(shape, symmetric, strict=True))
    return x, y


def unfold(values: NDArray, symmetric: Even) -> NDArray:
    """Values of a half or quarter mirrored to the whole grid.

    Examples
    --------
    >>> import numpy as np
    >>> unfold(np.array([[1.0, 2.0]]), (False, True)).tolist()
    [[2.0, 1.0, 1.0, 2.0]]
    """
    if not any(symmetric):
        return values
    shape = (values.shape[0] * (1 + symmetric[0]), values.shape[1] * (1 + symmetric[1]))
    out, (x, y) = np.empty(shape, values.dtype), part_of(shape, symmetric)
    out[x, y] = values
    if symmetric[1]:
        out[x, : y.start] = values[:, ::-1]
    if symmetric[0]:
        out[: x.start] = out[: x.start - 1 : -1]
    return out


def at_offsets(table: Array, cells: IntArray, shape: tuple[int, int], mirrored: Even) -> Array:
    """Sums (n, n) of a table of offsets 0, 1, ... from cells (n,), numbered row by row, to others and their images.

    Cells of an axis that is mirrored are those with positive coordinates: a cell's image is as far on the other side.

    Examples
    --------
    >>> import numpy as np
    >>> at_offsets(np.array([[4.0, 2.0, 1.0, 0.5]]), np.array([0, 1]), (1, 2), (False, True)).tolist()
    [[6.0, 3.0], [3.0, 4.5]]
    """
    along = []
    for index, even in zip(np.divmod(cells, shape[1]), mirrored, strict=True):
        images = (index, -1 - index) if even else (index,)
        along.append([np.abs(index[:, None] - at) for at in images])
    return np.asarray(sum(table[ix, iy] for ix in along[0] for iy in along[1]))


def block_sums(values: NDArray, axes: Sequence[int] = (-2, -1)) -> NDArray:
    """Sums over blocks of 2 x 2 cells (..., mx, my), or of 2 along one axis; those at an odd end have fewer.

    Examples
    --------
    >>> import numpy as np
    >>> block_sums(np.ones((3, 2))).tolist()
    [[4.0], [2.0]]
    """
    for axis in axes:
        along = np.moveaxis(values, axis, -1)
        sums = along[..., ::2].copy()
        sums[..., : along.shape[-1] // 2] += along[..., 1::2]
        values = np.moveaxis(sums, -1, axis)
    return values


def block_means(values: NDArray, axes: Sequence[int] = (0, 1)) -> Array:
    """Means over blocks of 2 x 2 cells (mx, my, ...), or of 2 along one axis; at an odd end of the cells there are."""
    count = np.ones(values.shape[: len(axes)]).reshape(*values.shape[: len(axes)], *(1,) * (values.ndim - len(axes)))
    return np.asarray(block_sums(values, axes) / block_sums(count, axes))


#: Distance from the middle of a cell, in cells, that is rounding.
ON_CELL = 1e-8


@dataclass(frozen=True, eq=False)
class GridSurface(FacetSurface):
    """The plane z = 0 with cell centres as nodes and quadrilaterals between them as facets.

    Parameters
    ----------
    grid : Grid
    start : int
        Number of the first cell among the points.
    periodic : bool
        Whether it repeats itself.
    point_forces : bool
        Whether the pressure of a cell is a force at its centre.
    """

    grid: Grid | None = None
    start: int = 0
    periodic: bool = False
    point_forces: bool = False

    @property
    def is_window(self) -> bool:
        """Whether the cells are those of a part of a surface."""
        return False

    @property
    def cells(self) -> Grid:
        """The grid."""
        assert self.grid is not None
        return self.grid

    @property
    def cell_area(self) -> float:
        """Area of a cell."""
        return self.cells.area

    @property
    def axes(self) -> tuple[Array, Array]:
        """Coordinates of the cells along x and y."""
        return self.cells.x, self.cells.y

    @property
    def normal(self) -> Array:
        """Outward normal (3,) of the plane, along which the cells are displaced."""
        return np.array([0.0, 0.0, 1.0])

    @property
    def is_divisible(self) -> bool:
        """False: all cells are paired at once."""
        return False

    def project(self, points: Array, n_near: int = 3) -> Projection:
        """Projection along z of points (n, 3), with bilinear weights, which preserve the moment of a force."""
        index, local, outside = [], [], np.zeros(len(points), bool)
        for axis, (x, side) in enumerate(zip(self.axes, self.cells.cell, strict=True)):
            place = (points[:, axis] - x[0]) / side
            outside |= (place < -ON_CELL) | (place > len(x) - 1 + ON_CELL)
            first = np.clip(np.floor(place), 0, len(x) - 2).astype(np.int64)
            index.append(first)
            within = np.clip(place - first, 0.0, 1.0)
            # a point on a cell's middle is that cell's alone
            local.append(np.where(np.abs(within - np.round(within)) < ON_CELL, np.round(within), within))
        ny = len(self.axes[1])
        facet = index[0] * (ny - 1) + index[1]
        s, t = local
        weights = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1)
        indptr = np.arange(0, weights.size + 1, 4)
        corners = between_cells(len(self.axes[0]), ny)[facet] + self.start
        matrix = sp.csr_matrix((weights.ravel(), corners.ravel(), indptr), (len(points), len(self.points)))
        matrix.eliminate_zeros()
        normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        projection = points * np.array([1.0, 1.0, 0.0])
        return Projection(projection, normals, points[:, 2].copy(), outside, matrix, facet, np.stack(local, axis=1))


def grid_surface(grid: Grid, name: str, periodic: bool = False, point_forces: bool = False) -> GridSurface:
    """The surface of a half-space with the given grid."""
    nx, ny = grid.shape
    points = np.zeros((grid.n_cells, 3))
    points[:, 0] = np.repeat(grid.x, ny)
    points[:, 1] = np.tile(grid.y, nx)
    return GridSurface(points, between_cells(nx, ny), name, grid=grid, periodic=periodic, point_forces=point_forces)


def between_cells(nx: int, ny: int) -> IntArray:
    """Quadrilaterals (n, 4) between the centres of nx times ny cells, numbered row by row.

    Examples
    --------
    >>> between_cells(2, 2).tolist()
    [[0, 2, 3, 1]]
    """
    corner = (np.arange(nx - 1)[:, None] * ny + np.arange(ny - 1)).ravel()
    return np.stack([corner, corner + ny, corner + ny + 1, corner + 1], axis=1)
