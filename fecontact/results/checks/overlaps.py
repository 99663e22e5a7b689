"""Check for overlaps of bodies without a declared contact between them.

Points of one body are projected on the other, in the final positions: the centre of a sphere, the outer nodes of an
elastic body, and points spread over other rigid surfaces. Bodies with disjoint bounding boxes are skipped.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import combinations

import numpy as np

from fecontact.common.arrays import Array
from fecontact.results.solved_scene import SolvedScene

#: Depth, relative to the smaller body, above which an overlap counts: chords of touching round faces make less.
LEAST_DEPTH = 1e-4


def undeclared_overlaps(result: SolvedScene) -> Iterator[str]:
    """Warnings of overlapping pairs of bodies without a contact."""
    declared = {frozenset((id(c.slave), id(c.master))) for c in result.scene.contacts}
    bodies = result.scene.bodies
    if len(bodies) * (len(bodies) - 1) // 2 == len(declared):
        return
    placed = [_Placed(result, k) for k in range(len(bodies))]
    for one, other in combinations(placed, 2):
        if frozenset((id(one.body), id(other.body))) in declared:
            continue
        depth = max(one.depth_in(other), other.depth_in(one))
        if depth > LEAST_DEPTH * min(one.outside.length, other.outside.length):
            yield (
                f"{one.body.name!r} and {other.body.name!r} overlap by {depth:.4g} and no contact between them was "
                "declared, so that nothing keeps them apart: add a Contact, or move one of them."
            )


class _Placed:
    """A body in its final position."""

    def __init__(self, result: SolvedScene, number: int) -> None:
        self.body = result.scene.bodies[number]
        self.outside = self.body.outside(result.state.displacements[number])
        self._motion, self._point = result.state.motions[number], result.loading.frames[number].point

    @cached_property
    def points(self) -> Array:
        """Points (n, 3) of the body in world axes; none for infinite surfaces."""
        return self._moved(self.body.pose.to_world(self.outside.points))

    def _moved(self, points: Array, sign: float = 1.0) -> Array:
        """Points (n, 3) after or before the small motion of a rigid body; displacements of others include it."""
        if not self.body.is_rigid:
            return points
        shift, turn = np.split(self._motion, 2)
        return points + sign * (shift + np.cross(turn, points - self._point))

    @cached_property
    def _box(self) -> tuple[Array, Array] | None:
        """Corners of a bounding box; None for a body that may be infinite."""
        if not self.outside.is_bounded or not len(self.points):
            return None
        return self.points.min(axis=0) - self.outside.radius, self.points.max(axis=0) + self.outside.radius

    def depth_in(self, other: _Placed) -> float:
        """Largest depth of points of this body inside another; zero if none are inside."""
        points, radius, it = self.points, self.outside.radius, other.outside
        if it.surface is None or not len(points):
            return 0.0
        if other._box is not None:
            low, high = other._box
            points = points[((points >= low - radius) & (points <= high + radius)).all(axis=1)]
            if not len(points):
                return 0.0
        seen = other.body.pose.to_body(other._moved(points, -1.0))
        projection = it.surface.project(seen)
        depth = np.where(projection.outside, -np.inf, radius - projection.gap)
        if it.may_hold is not None:
            depth[~it.may_hold(seen, radius)] = -np.inf
        # a point behind an open surface need not be inside
        depth[depth > it.depth + 2 * radius] = -np.inf
        return max(0.0, float(depth.max()))
