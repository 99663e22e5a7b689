"""Surface of a half-space in a scene: cells paired along the surface's own normal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fecontact.bodies.halfspace.grid import Grid
from fecontact.common.arrays import Array
from fecontact.contact.coupling.facing import STEEPEST
from fecontact.contact.coupling.nodal import Pairing, nodal_pairing
from fecontact.surfaces.facet_surface import FacetSurface, Feet, Surface

CLOSE = 1e-14
"""Distance, relative to the size of the surfaces, at which a vertical line has met the other surface."""

MOST_STEPS = 60


@dataclass(frozen=True, eq=False)
class GridSurface(FacetSurface):
    """The plane z = 0 with the middles of cells as nodes and quadrilaterals between them as facets.

    Parameters
    ----------
    grid : Grid
    """

    grid: Grid | None = None

    @property
    def cells(self) -> Grid:
        """The grid."""
        assert self.grid is not None
        return self.grid

    def project(self, points: Array, n_near: int = 3) -> Feet:
        """Feet straight below points (n, 3), with bilinear weights, so that a force spread by them keeps its moment."""
        grid = self.cells
        index, local, beyond = [], [], np.zeros(len(points), bool)
        for axis, (x, side) in enumerate(zip((grid.x, grid.y), grid.cell, strict=True)):
            place = (points[:, axis] - x[0]) / side
            beyond |= (place < 0) | (place > len(x) - 1)
            first = np.clip(np.floor(place), 0, len(x) - 2).astype(np.int64)
            index.append(first)
            local.append(np.clip(place - first, 0.0, 1.0))
        ny = grid.shape[1]
        facet = index[0] * (ny - 1) + index[1]
        s, t = local
        weights = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1)
        indptr = np.arange(0, weights.size + 1, 4)
        matrix = sp.csr_matrix((weights.ravel(), self.facets[facet].ravel(), indptr), (len(points), grid.n_cells))
        normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        feet = points * np.array([1.0, 1.0, 0.0])
        return Feet(feet, normals, points[:, 2].copy(), beyond, matrix, facet, np.stack(local, axis=1))

    def pair(self, master: Surface, rotation: Array, translation: Array) -> Pairing:
        """Pair every cell with the point of the master straight above it.

        A half-space gives along its own normal only, so gaps are measured and forces act along it.

        Parameters
        ----------
        master : Surface
        rotation, translation
            Pose of this surface's axes seen from the master's.
        """
        feet = straight_above(self.points, master, rotation, translation)
        area = np.full(len(self.points), self.cells.area)
        return nodal_pairing(self, np.arange(len(self.points)), area, feet, rotation, translation)


def grid_surface(grid: Grid, name: str) -> GridSurface:
    """The surface of a half-space with the given grid."""
    nx, ny = grid.shape
    points = np.zeros((grid.n_cells, 3))
    points[:, 0] = np.repeat(grid.x, ny)
    points[:, 1] = np.tile(grid.y, nx)
    corner = (np.arange(nx - 1)[:, None] * ny + np.arange(ny - 1)).ravel()
    facets = np.stack([corner, corner + ny, corner + ny + 1, corner + 1], axis=1)
    return GridSurface(points, facets, name, grid=grid)


def straight_above(points: Array, master: Surface, rotation: Array, translation: Array) -> Feet:
    """Where lines along +z through points (n, 3) meet the master; `gap` counts along them.

    Surfaces with `heights` that are not turned against the plane tell it themselves; others are met by steps of the
    distance over its cosine, Newton's method.
    """
    direction = rotation[:, 2]
    start = points @ rotation.T + translation
    normals = np.tile(-direction, (len(points), 1))
    if hasattr(master, "heights") and np.array_equal(rotation, np.eye(3)):
        height = master.heights(start[:, 0], start[:, 1])
        beyond = ~np.isfinite(height)
        height = np.where(beyond, start[:, 2], height)
        feet = np.stack([start[:, 0], start[:, 1], height], axis=1)
        return Feet(feet, normals, height - start[:, 2], beyond)
    travel = np.zeros(len(points))
    lost = np.zeros(len(points), bool)
    size = float(np.ptp(points, axis=0).max())
    for _ in range(MOST_STEPS):
        found = master.project(start + travel[:, None] * direction)
        cosine = -(found.normals @ direction)
        lost |= cosine < STEEPEST
        step = np.where(lost, 0.0, found.gap / np.where(lost, 1.0, cosine))
        travel = travel + step
        if np.abs(step).max(initial=0.0) <= CLOSE * size:
            break
    feet = start + travel[:, None] * direction
    return Feet(feet, normals, travel, found.beyond | lost, found.weights, found.facet, found.local, found.surface)
