"""Where straight lines through points meet a surface, by Newton's method on closest points."""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.surfaces.facet_surface import Projection, Surface

CLOSE = 1e-14
"""Step, relative to the extent of the points, at which the search has converged."""

MOST_STEPS = 60

STEEPEST = 0.1
"""Cosine between a line and the surface's inward normal below which the line does not meet it: 84 degrees."""


def along_line(
    surface: Surface, start: Array, direction: Array, first: Projection | None = None, facing: bool = True
) -> tuple[Array, Projection, Mask]:
    """Distances along one direction from points to a surface.

    Parameters
    ----------
    surface : Surface
    start : (n, 3) array
    direction : (3,) array
        Unit vector, into the surface.
    first : Projection, optional
        Closest points of `start`, if they are known.
    facing : bool
        Whether lines that meet the other side of the surface are lost; without it they count too.

    Returns
    -------
    travel : (n,) array
    found : Projection
        Closest points of the points where the lines end.
    lost : (n,) bool array
        Lines that graze the surface, or meet its other side.

    Examples
    --------
    >>> from fecontact.surfaces import Paraboloid
    >>> travel, _, _ = along_line(Paraboloid(1.0), np.array([[0.6, 0.0, -1.0]]), np.array([0.0, 0.0, 1.0]))
    >>> travel.round(12).tolist()
    [1.18]
    """
    travel = np.zeros(len(start))
    lost = np.zeros(len(start), bool)
    size = float(np.ptp(start, axis=0).max())
    for step in range(MOST_STEPS):
        found = first if step == 0 and first is not None else surface.project(start + travel[:, None] * direction)
        cosine = -(found.normals @ direction)
        lost |= (cosine if facing else np.abs(cosine)) < STEEPEST
        further = np.where(lost, 0.0, found.gap / np.where(lost, 1.0, cosine))
        travel = travel + further
        if np.abs(further).max(initial=0.0) <= CLOSE * size:
            break
    return travel, found, lost
