"""Pairing of a half-space's cells along the half-space's normal."""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array
from fecontact.contact.coupling.facing import STEEPEST
from fecontact.contact.coupling.nodal import Pairing, nodal_pairing
from fecontact.surfaces.facet_surface import FacetSurface, Projection, Surface
from fecontact.surfaces.rigid.indenter import heights_of

CLOSE = 1e-14
"""Distance, relative to the size of the surfaces, at which the search along a vertical line has converged."""


MOST_STEPS = 60


def straight_above(points: Array, master: Surface, rotation: Array, translation: Array) -> Projection:
    """Intersection of lines along +z through points (n, 3) with the master; `gap` is measured along them.

    Taken from `heights` where the surface has them and is not tilted; otherwise by Newton's method, with steps of the
    distance over its cosine.
    """
    direction = rotation[:, 2]
    start = points @ rotation.T + translation
    normals = np.tile(-direction, (len(points), 1))
    heights = heights_of(master)
    if heights is not None and np.array_equal(rotation, np.eye(3)):
        height = heights(start[:, 0], start[:, 1])
        outside = ~np.isfinite(height)
        height = np.where(outside, start[:, 2], height)
        projection = np.stack([start[:, 0], start[:, 1], height], axis=1)
        return Projection(projection, normals, height - start[:, 2], outside)
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
    projection = start + travel[:, None] * direction
    return Projection(
        projection, normals, travel, found.outside | lost, found.weights, found.facet, found.local, found.surface
    )


def pair_cells(surface: FacetSurface, area: float, master: Surface, rotation: Array, translation: Array) -> Pairing:
    """Pair every cell with the point of the master vertically above it.

    A half-space is displaced along its normal only, so gaps and forces are along it.

    Parameters
    ----------
    surface : FacetSurface
        Surface of the half-space.
    area : float
        Area of a cell.
    master : Surface
    rotation, translation
        Pose of this surface's axes in the master's.
    """
    projection = straight_above(surface.points, master, rotation, translation)
    n = len(surface.points)
    return nodal_pairing(surface, np.arange(n), np.full(n, area), projection, rotation, translation)
