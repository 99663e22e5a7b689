"""First candidates of a contact: pairs near enough to touch under the loads, estimated before a solve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fecontact.bodies.elastic import elastic_among
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.contact.interface import Interface
from fecontact.contact.loads import Loading
from fecontact.contact.search.candidates import FEWEST, approach_for_load, choose

#: Share of the elastic displacement up to which gaps, after the predicted motion, make first candidates.
LIKELY = 0.4


@dataclass(frozen=True, eq=False)
class KnownContact:
    """Contact of a similar case, such as one on a coarser mesh.

    Attributes
    ----------
    points : (n, 3) array
        Contact points, in world axes.
    active : (n,) bool array
        Mask of points with force.
    margin : (n,) array
        Margin around active points.
    """

    points: Array
    active: Mask
    margin: Array

    def candidates(self, interface: Interface) -> IntArray:
        """Contact points that may touch: those within the margin of the nearest active one."""
        tree = cKDTree(self.points[self.active])
        distance, nearest = tree.query(interface.slave.pose.to_world(interface.pairing.slave_points))
        return np.flatnonzero(distance <= self.margin[self.active][nearest])

    def touching(self, interface: Interface, chosen: IntArray) -> Mask:
        """Mask of chosen points nearest to an active one: the first active set."""
        places = interface.slave.pose.to_world(interface.pairing.slave_points[chosen])
        return self.active[cKDTree(self.points).query(places)[1]]


def _candidates(interface: Interface, opening: Array, loading: Loading) -> IntArray:
    """First candidates; with a predicted motion, the condensed points that are near after it."""
    search_radius = interface.search_radius
    first = _first_choice(interface, opening, loading)
    if search_radius is None or search_radius.increment is None or interface.pairing.coupling != "mortar":
        return first
    increment = search_radius.increment_in(interface.slave.pose).at(interface.slave_nodes)
    near = np.flatnonzero(interface.gap + interface.slave_rows @ increment.ravel() <= LIKELY * search_radius.elastic)
    ready = np.ones(len(near), bool)
    for body in elastic_among((interface.slave, interface.master)):
        rows = interface.rows(body)
        if rows is not None:
            ready &= body.model.has_condensed(rows[near])
    return near[ready] if ready.all() and len(near) >= FEWEST else np.union1d(first, near[ready])


def _first_choice(interface: Interface, opening: Array, loading: Loading) -> IntArray:
    """Candidates from the gap, the prescribed motions and the size of the loads."""
    approach = max(0.0, -float(opening.min()))
    force = loading.magnitude
    if force > 0:
        compliances = [1 / b.contact_modulus for b in (interface.slave, interface.master)]
        if sum(compliances) > 0:
            images = _mirror_images(interface, opening)
            area = images * interface.pairing.weights
            along = interface.slave_surface.out_of_plane
            thickness = None if along is None else along.thickness
            scale = approach_for_load(opening - opening.min(), area, 1 / sum(compliances), images * force, thickness)
            approach = max(approach, scale)
    return choose(opening, approach)


def _mirror_images(interface: Interface, opening: Array) -> int:
    """Estimated ratio of the whole to the modelled part, to relate the load to the area.

    A boundary held in one component only through the point nearest contact counts as a plane of symmetry. A wrong
    estimate costs time but not accuracy.
    """
    nearest = interface.pairing.nodes[[np.argmin(opening)]]
    return 2 ** interface.slave.planes_through(nearest)
