"""Search radius of a contact, and facets in which near parts can be paired.

A rough gap is the offset of a facet's centre from the nearest facet of the other surface along that one's normal. It
serves to condense models onto enough nodes at once; what it misses is found when the surfaces are paired.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fecontact.bodies.elastic import elastic_among
from fecontact.bodies.pose import Pose
from fecontact.bodies.protocol import Body
from fecontact.contact.search.region import RigidIncrement
from fecontact.surfaces.facet_surface import FacetSurface, facets_of


@dataclass(frozen=True, eq=False)
class SearchRadius:
    """Search radius of a contact.

    Attributes
    ----------
    distance : float
        Radius within which points are paired to choose the coupling, without the predicted motion.
    elastic : float
        Displacement of both sides together beyond the predicted motion, for mortar coupling.
    increment : RigidIncrement, optional
        Predicted rigid motion of one side relative to the other, in world axes; None if unknown.
    """

    distance: float
    elastic: float
    increment: RigidIncrement | None = None

    def turned_over(self) -> SearchRadius:
        """The same with swapped sides of the contact."""
        if self.increment is None:
            return self
        return replace(self, increment=RigidIncrement(-self.increment.shift, -self.increment.turn))

    def increment_in(self, pose: Pose) -> RigidIncrement:
        """The predicted motion in the axes of a body."""
        assert self.increment is not None
        return in_axes(self.increment, pose)


def plain_facets(bodies: Sequence[Body], names: Sequence[str]) -> list[FacetSurface] | None:
    """Surfaces of a contact if near parts of them can be paired: facets of two elastic bodies, nodes as usual."""
    surfaces = [facets_of(b.surface(name)) for b, name in zip(bodies, names, strict=True)]
    if len(elastic_among(bodies)) < 2:
        return None
    facets = [s for s in surfaces if s is not None and s.is_divisible]
    return facets if len(facets) == 2 else None


def in_axes(increment: RigidIncrement, pose: Pose) -> RigidIncrement:
    """A rigid increment in world axes, transformed to those of a body."""
    R, t = pose.rotation, pose.translation
    return RigidIncrement((increment.shift + np.cross(increment.turn, t)) @ R, increment.turn @ R)
