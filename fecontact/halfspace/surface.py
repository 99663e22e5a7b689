"""Surface of a half-space in a scene: cells paired along the surface's own normal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.halfspace.grid import Grid
from fecontact.surfaces.facet_surface import FacetSurface, Projection

ON_CELL = 1e-8
"""Distance from the middle of a cell, in cells, that is rounding."""


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
