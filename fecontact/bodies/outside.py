"""The whole outer surface of a body, for checks of overlap."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.surfaces.facet_surface import Surface


@dataclass(frozen=True, eq=False)
class Outside:
    """Outer surface of a body, in its own axes.

    Attributes
    ----------
    points : (n, 3) array
        Points spread over it; none for infinite surfaces.
    surface : Surface or None
        None where it is unknown or encloses no volume.
    length : float
        Size of the body; infinite for a plane.
    radius : float
        Distance from its points within which everything belongs to the body.
    is_bounded : bool
        Whether the body lies within a box round its points.
    depth : float
        Depth behind the surface to which a point is known to be inside.
    may_hold : function (points, radius) -> mask, optional
        Whether a ball round a point may reach into the body, where projections do not decide it.
    """

    points: Array
    surface: Surface | None
    length: float
    radius: float = 0.0
    is_bounded: bool = False
    depth: float = np.inf
    may_hold: Callable[[Array, float], Mask] | None = None
