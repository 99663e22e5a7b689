"""Which parts of two surfaces can come into touch, by lower bounds of their distance and of how it changes.

Parts and bounds are those of `contact.search.bounding`. Why a part that is left out cannot touch: let d be a lower
bound of its distance from a facet of the master, r the rigid motion of the slave seen from the master, and e, f the
largest elastic displacements of part and facet. A gap g along a line of action n changes by n . r(x) + n . (e - f), as
the master's rotation moves foot and point by the same along n. The line lies between both normals
(`surfaces.line_of_action`), n = v / |v| with v a mean of n1 and n2, of whatever weights. With the normals of each in
a cone round an axis, n_i . r is no less than b_i = |r| cos(angle to the axis + half angle of the cone), and v . r no
less than the smaller b. Where that is negative, |v| < 1 makes it worse: |v| >= cos(half the angle between n1 and n2),
which is no more than the cones allow, nor than lines between normals are taken for. So if d + min n . r - e - f > 0 for
all facets of the master, no linearised gap of the part closes. Parts that start inside are paired whatever their
distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.contact.search.bounding import Bounds, Cones, bounds_of, cones_of, parts_of
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.line_of_action import FACING

#: Rings of facets round those within reach that are paired with them, so that a hat within reach is whole and a sliver
#: at a rim finds the hat that it joins.
RINGS = 2


@dataclass(frozen=True, eq=False)
class RigidIncrement:
    """Small rigid motion x -> shift + turn x x (vectors (3,)) of a slave seen from its master, in the master's axes."""

    shift: Array
    turn: Array

    def at(self, points: Array) -> Array:
        """Displacements (n, 3) of points (n, 3)."""
        return self.shift + np.cross(self.turn, points)


STILL = RigidIncrement(np.zeros(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class SearchRegion:
    """Parts of two surfaces that are paired.

    Attributes
    ----------
    facets : (n_slave_facets,) bool array
        Slave facets that are paired.
    nodes : (n_slave_nodes,) bool array
        Nodes whose hats or forces are: those of parts within reach, and of rings round them at the master's rim.
    opposite : (n_master_facets,) bool array
        Master facets that hold the nearest point of any point of the slave facets.
    within : (n_slave_parts,) bool array
        Parts that may come into touch as far as the reach tells; all others are left out.
    """

    facets: Mask
    nodes: Mask
    opposite: Mask
    within: Mask


def search_region(
    slave: FacetSurface,
    master: FacetSurface,
    rotation: Array,
    translation: Array,
    search_radius: float,
    increment: RigidIncrement = STILL,
) -> SearchRegion:
    """Parts of two surfaces whose distance, after a rigid motion, may be less than a reach.

    Parameters
    ----------
    slave, master : FacetSurface
    rotation, translation
        Pose of the slave's axes seen from the master's.
    search_radius : float
        Displacement of both surfaces together that is allowed for beyond the drift.
    increment : RigidIncrement, optional
        Rigid motion that is expected.

    Returns
    -------
    Near
    """
    parts = parts_of(slave)
    own, other = bounds_of(parts.surface), bounds_of(master)
    place = _Place(own, other, rotation, translation, increment)
    far = place.to_centre - own.radius - other.radius.max() > search_radius + place.motion
    within = place.inside.copy()
    doubtful = np.flatnonzero(~place.inside & ~far)
    part, _, left = place.pairs(doubtful, search_radius + place.motion[doubtful], _cones(slave, master, rotation))
    within[part[left <= search_radius]] = True
    nodes = np.zeros(len(slave.points), bool)
    part, column = np.nonzero(parts.columns & within[:, None])
    nodes[slave.facets[parts.owner[part], column]] = True
    facets: Mask = np.asarray(nodes[slave.facets].any(axis=1))
    rim = _at_rim(slave, master, facets, rotation, translation)
    if rim.any():
        # a hat that keeps a sliver of its area at a rim joins the nearest fuller one, which has to be there
        around = with_rings(slave, rim, RINGS)
        facets = facets | around
        nodes[slave.facets[around]] = True
        nodes[slave.facets[~facets]] = False
    return SearchRegion(facets, nodes, place.opposite(facets[parts.owner]), within)


def _at_rim(slave: FacetSurface, master: FacetSurface, facets: Mask, rotation: Array, translation: Array) -> Mask:
    """Which of the chosen slave facets reach the outermost facets of the master."""
    nodes = np.unique(slave.facets[facets])
    out = np.zeros(len(slave.points), bool)
    if len(nodes):
        foot = master.project(slave.points[nodes] @ rotation.T + translation, n_near=1).facet
        assert foot is not None
        out[nodes] = master.on_rim[foot].any(axis=1)
    return np.asarray(out[slave.facets].any(axis=1) & facets)


def find_missed(
    near: SearchRegion,
    slave: FacetSurface,
    master: FacetSurface,
    rotation: Array,
    translation: Array,
    increment: RigidIncrement,
    elastic: tuple[Array, Array],
) -> tuple[bool, float]:
    """Whether a part that was left out can have come into touch, and the reach that suits the displacements.

    Parameters
    ----------
    near : SearchRegion
    slave, master, rotation, translation
        As in `search_region`.
    increment : RigidIncrement
        Rigid motion of the slave seen from the master.
    elastic : (n_slave_parts,) and (n_master_facets,) arrays
        Upper bounds of the displacements besides, see `part_displacements`.
    """
    parts = parts_of(slave)
    own, other = bounds_of(parts.surface), bounds_of(master)
    place = _Place(own, other, rotation, translation, increment)
    ours, theirs = elastic
    needed = place.motion + ours + theirs.max()
    close = place.to_centre - own.radius - other.radius.max() <= needed
    doubtful = np.flatnonzero((~place.inside | ~near.within) & close)
    part, facet, left = place.pairs(doubtful, needed[doubtful], _cones(slave, master, rotation))
    closing = left <= ours[part] + theirs[facet]
    missed = bool((~near.within[part[closing]]).any())
    return missed, float(left.max(initial=0.0, where=closing))


def _cones(slave: FacetSurface, master: FacetSurface, rotation: Array) -> tuple[Cones, Cones]:
    """Cones of the reversed normals of the slave's parts, in the master's axes, and of the master's normals."""
    own = cones_of(slave).chosen(parts_of(slave).owner)
    return Cones(-own.axis @ rotation.T, own.angle), cones_of(master)


def least_along_lines(motion: Array, one: Cones, other: Cones) -> Array:
    """Lower bounds (n,) of n . motion (n, 3) for lines of action n between normals of one cone and of another."""
    size = np.linalg.norm(motion, axis=1)
    away = [np.minimum(_angle(c.axis, motion, size) + c.angle, np.pi) for c in (one, other)]
    least = np.cos(np.maximum(*away))
    between = _angle(one.axis, other.axis, np.ones(len(size))) + one.angle + other.angle
    length = np.cos(np.minimum(between, np.arccos(FACING)) / 2)
    return np.asarray(size * np.maximum(np.where(least < 0, least / length, least), -1.0))


def _angle(axis: Array, vector: Array, size: Array) -> Array:
    """Angles (n,) between unit vectors (n, 3) and vectors (n, 3) of given size; right ones where that is zero."""
    along = np.einsum("ni,ni->n", axis, vector)
    cosine = np.divide(along, size, out=np.zeros_like(size), where=size > 0)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


class _Place:
    """Parts of a slave in the master's axes, and how they drift."""

    def __init__(
        self, own: Bounds, other: Bounds, rotation: Array, translation: Array, increment: RigidIncrement
    ) -> None:
        self.own, self.other, self.rotation, self.translation = own, other, rotation, translation
        self.centre = own.centre @ rotation.T + translation
        self.to_centre, nearest = other.all_centres.query(self.centre)
        self.to_node = other.nodes.query(self.centre)[0]
        offset = self.centre - other.centre[nearest]
        self.inside = np.einsum("ni,ni->n", offset, other.normal[nearest]) < 0
        self.increment = increment.at(self.centre)
        #: how much the drift differs over a part from that at its centre, and its largest size there
        self.spread = float(np.linalg.norm(increment.turn)) * own.radius
        self.motion = np.linalg.norm(self.increment, axis=1) + self.spread

    def pairs(self, chosen: IntArray, radius: Array, cones: tuple[Cones, Cones]) -> tuple[IntArray, IntArray, Array]:
        """Chosen parts and facets of the master no further apart than `radius` (n_chosen,), and what is left of that.

        That is a lower bound of their distance and what the drift does to it. Two facets are apart by no less than
        their balls are, nor than their hulls along either normal or the line of their centres. Where a part may be
        inside at the start, nothing is left: minus infinity. `cones` are those of all parts and of all facets.
        """
        own, other, centre = self.own, self.other, self.centre
        found = []
        for members, largest, tree in other.trees:
            which, hit = flattened(tree.query_ball_point(centre[chosen], radius + own.radius[chosen] + largest))
            found.append((chosen[which], members[hit]))
        s, m = (np.concatenate(f) for f in zip(*found, strict=True))
        apart = self._apart(s, m)
        closing = least_along_lines(self.increment[s], cones[0].chosen(s), cones[1].chosen(m))
        return s, m, np.where(apart > 0, apart + closing - self.spread[s], -np.inf)

    def opposite(self, chosen: Mask) -> Mask:
        """Facets of the master (n_facets,) that may hold the nearest point of any point of chosen parts (n_parts,)."""
        centre, radius = self.centre[chosen], self.own.radius[chosen]
        farthest = self.to_node[chosen] + 2 * radius
        out = np.zeros(len(self.other.centre), bool)
        for members, largest, tree in self.other.trees:
            out[members[flattened(tree.query_ball_point(centre, farthest + largest))[1]]] = True
        return out

    def _apart(self, s: IntArray, m: IntArray) -> Array:
        """Lower bounds (n,) of the distance of parts s (n,) from facets m (n,)."""
        own, other = self.own, self.other
        between = self.centre[s] - other.centre[m]
        length = np.linalg.norm(between, axis=1)
        apart = length - own.radius[s] - other.radius[m]
        corners = own.corners[s] @ self.rotation.T + self.translation
        line = np.divide(between, length[:, None], out=np.zeros_like(between), where=length[:, None] > 0)
        for direction in (other.normal[m], own.normal[s] @ self.rotation.T, line):
            ours = (corners @ direction[:, :, None])[..., 0]
            theirs = (other.corners[m] @ direction[:, :, None])[..., 0]
            above, below = ours.min(axis=1) - theirs.max(axis=1), theirs.min(axis=1) - ours.max(axis=1)
            apart = np.maximum(apart, np.maximum(above, below) - own.bulge[s] - other.bulge[m])
        return apart


def flattened(lists: NDArray[np.object_]) -> tuple[IntArray, IntArray]:
    """Lists of numbers as two arrays: which list, and the number."""
    count = np.fromiter(map(len, lists), dtype=np.int64, count=len(lists))
    if not count.sum():
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    return np.repeat(np.arange(len(lists)), count), np.concatenate([np.asarray(f, dtype=np.int64) for f in lists if f])


def with_rings(surface: FacetSurface, chosen: Mask, rings: int) -> Mask:
    """Facets and so many rings of neighbours round them, each of all facets that share a node."""
    for _ in range(rings):
        touched = np.zeros(len(surface.points), bool)
        touched[surface.facets[chosen]] = True
        chosen = np.asarray(touched[surface.facets].any(axis=1))
    return chosen
