"""Pairing of a half-space's cells along the half-space's normal."""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array
from fecontact.contact.coupling.nodal import Pairing, nodal_pairing
from fecontact.contact.coupling.surface_pair import SurfacePair
from fecontact.halfspace.surface import GridSurface
from fecontact.surfaces.facet_surface import Projection, Surface
from fecontact.surfaces.rigid.shapes import heights_of
from fecontact.surfaces.section_curve import along_line

UPWARDS = (0.0, 0.0, 1.0)
"""Normal of a half-space in its own axes."""


def straight_above(
    points: Array,
    master: Surface,
    rotation: Array,
    translation: Array,
    closest: Projection | None = None,
    normal: ArrayLike = UPWARDS,
) -> Projection:
    """Intersection of lines along a normal (3,) through points (n, 3) with the master; `gap` is measured along them.

    Taken from `heights` where the surface has them and the lines are along its z; otherwise by Newton's method, with
    steps of the distance over its cosine; `closest` are the closest points, if they are known.
    """
    direction = rotation @ np.asarray(normal, dtype=float)
    start = points @ rotation.T + translation
    normals = np.tile(-direction, (len(points), 1))
    heights = heights_of(master)
    if heights is not None and np.array_equal(direction, UPWARDS):
        height = heights(start[:, 0], start[:, 1])
        outside = ~np.isfinite(height)
        height = np.where(outside, start[:, 2], height)
        projection = np.stack([start[:, 0], start[:, 1], height], axis=1)
        return Projection(projection, normals, height - start[:, 2], outside)
    travel, found, lost = along_line(master, start, direction, closest)
    projection = start + travel[:, None] * direction
    return Projection(
        projection, normals, travel, found.outside | lost, found.weights, found.facet, found.local, found.surface
    )


def pair_cells(surfaces: SurfacePair, area: float) -> Pairing:
    """Pair every cell with the point of the master vertically above it.

    A half-space is displaced along its normal only, so gaps and forces are along it.

    Parameters
    ----------
    surfaces : SurfacePair
        The half-space's surface is the slave.
    area : float
        Area of a cell.
    """
    surface, rotation, translation = surfaces.slave, surfaces.rotation, surfaces.translation
    known = surfaces.closest if "closest" in vars(surfaces) else None
    cells, normal = surface.nodes, cast(GridSurface, surface).normal
    projection = straight_above(surface.points[cells], surfaces.master, rotation, translation, known, normal)
    return nodal_pairing(surface, cells, np.full(len(cells), area), projection, rotation, translation)
