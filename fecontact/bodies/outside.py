"""What is known of a body's whole outside, be it in contact or not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.surfaces.facet_surface import Surface


@dataclass(frozen=True, eq=False)
class Outside:
    """A body's outside in its own axes.

    Attributes
    ----------
    points : (n, 3) array
        Spread over it; none for surfaces that go on without end.
    surface : Surface or None
        None where it is not known or encloses nothing.
    length : float
        The body's size; infinite for a plane, which has none.
    radius : float
        Distance from its points within which all is the body.
    is_bounded : bool
        Whether the body lies within a box round its points.
    depth : float
        How far behind the surface a point can be and still be known to be inside.
    may_hold : function (points, radius) -> mask, optional
        Whether a ball round a point may reach into the body, where feet do not tell.
    """

    points: Array
    surface: Surface | None
    length: float
    radius: float = 0.0
    is_bounded: bool = False
    depth: float = np.inf
    may_hold: Callable[[Array, float], Mask] | None = None
