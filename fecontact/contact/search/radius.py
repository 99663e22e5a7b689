"""Which facets of two surfaces may touch, judged from rough gaps before anything is paired, and how far they move.

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
    """Up to where the surfaces of a contact are paired.

    Attributes
    ----------
    distance : float
        Up to which points are paired to tell how the faces are to be coupled, whatever the drift.
    elastic : float
        Displacement of both sides together beyond the drift, for which mortar coupling is done.
    increment : RigidIncrement, optional
        Rigid motion of the one side seen from the other that is expected, in world axes; None if nothing is known.
    """

    distance: float
    elastic: float
    increment: RigidIncrement | None = None

    def turned_over(self) -> SearchRadius:
        """The same with the sides of the contact swapped."""
        if self.increment is None:
            return self
        return replace(self, increment=RigidIncrement(-self.increment.shift, -self.increment.turn))

    def increment_in(self, pose: Pose) -> RigidIncrement:
        """The drift in the axes of a body."""
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
    """A drift in world axes, in those of a body."""
    R, t = pose.rotation, pose.translation
    return RigidIncrement((increment.shift + np.cross(increment.turn, t)) @ R, increment.turn @ R)
