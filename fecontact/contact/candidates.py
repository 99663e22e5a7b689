"""Candidate pairs: those that may touch, estimated from the gap before a solve.

The cost grows with the candidates, so there should be few. A missing pair that penetrates is found by the certificate
and added, so the choice affects the time but not the solution.

First candidates of a contact: pairs near enough to touch under the loads, estimated before a solve.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import elastic_among
from fecontact.common.arrays import ROUNDING, Array, IntArray, Mask
from fecontact.contact.coupling.nodal import SurfacePair
from fecontact.contact.interface import Interface
from fecontact.contact.loads import Loading
from fecontact.contact.search_region import flattened
from fecontact.surfaces.facet_surface import FacetSurface

#: Share of the estimated rigid overlap within which pairs are candidates; one half for a Hertz contact.
MARGIN = 0.72
#: The same with friction, whose candidates have three rows each. Of 60 random balls, ellipsoids and cylinders on blocks
#: as thick as an eighth of their width to all of it, 59 needed 0.52 at most, and one on 6 x 6 cells 0.58.
RUBBING_MARGIN = 0.55
#: The same of a thin layer whose overlap is prescribed: it touches wherever it overlaps.
LAYER_MARGIN = 1.0
#: Least number of candidates of a contact.
MIN_CANDIDATES = 12


def approach_for_load(gap: Array, area: Array, modulus: float, force: float, thickness: float | None = None) -> float:
    """Estimate of the rigid approach at which the overlap of the undeformed surfaces carries a force.

    An overlap of volume V and area A is taken to carry about E* V / sqrt(A). For a paraboloid, where V = pi R d^2 and
    A = 2 pi R d at approach d, that is 0.94 of the elastic force; for other shapes it is an order of magnitude. In a
    plane the width A / t of the overlap replaces sqrt(A).

    Parameters
    ----------
    gap : (n,) array
        Gaps; the smallest is zero.
    area : (n,) array
    modulus : float
        Contact modulus E*.
    force : float
    thickness : float, optional
        Thickness t of a plane problem.

    Returns
    -------
    float
        Approach measured from first touch.
    """
    order = np.argsort(gap)
    g, a = gap[order], area[order]
    covered = np.cumsum(a)
    volume = g * covered - np.cumsum(a * g)
    width = np.sqrt(covered) if thickness is None else covered / thickness
    carried = modulus * volume / width
    k = int(np.searchsorted(np.maximum.accumulate(carried), force))
    if k >= len(g):
        # everything overlaps and the rest of the approach is uniform
        return float(g[-1] + (force - carried[-1]) / (modulus * covered[-1] / width[-1]))
    if k == 0:
        return float(g[0])
    # between two nodes the area is that of the lower: modulus * (volume + A (d - g)) / width = force
    extra = (force - carried[k - 1]) / (modulus * covered[k - 1] / width[k - 1])
    return float(g[k - 1] + extra)


def choose(gap: Array, approach: float, layer: bool = False, equal: float = 0.0, *, rubs: bool = False) -> IntArray:
    """Pairs whose gap above the smallest is within a margin of an approach, at least `MIN_CANDIDATES`.

    The margin is `LAYER_MARGIN` for layers, `RUBBING_MARGIN` with friction and `MARGIN` otherwise. Gaps that differ by
    at most `equal` are chosen together.

    Examples
    --------
    >>> gap = np.linspace(-1.0, 1.0, 200)
    >>> len(choose(gap, 1.0)), len(choose(gap, 1.0, layer=True))
    (72, 100)
    """
    order = np.argsort(gap, kind="stable")
    above = gap[order] - gap[order[0]]
    margin = LAYER_MARGIN if layer else RUBBING_MARGIN if rubs else MARGIN
    within = max(margin * approach, above[min(MIN_CANDIDATES, len(gap)) - 1])
    return np.sort(order[above <= within + equal])


def grow(chosen: IntArray, gap: Array, penetrating: Mask) -> IntArray:
    """Candidates plus the penetrating pairs and all others up to 1.5 times their initial gap."""
    limit = gap[penetrating].max() - gap.min()
    return np.union1d(chosen, np.flatnonzero(gap - gap.min() <= 1.5 * limit))


def widen(chosen: IntArray, gap: Array) -> IntArray:
    """Candidates plus pairs up to twice the gap above the smallest, at least twice as many in all.

    Examples
    --------
    >>> widen(np.array([0, 1]), np.array([0.0, 0.1, 0.15, 0.3, 0.4])).tolist()
    [0, 1, 2, 3]
    """
    above = gap - gap.min()
    search_radius = max(2 * float(above[chosen].max()), float(np.sort(above)[min(2 * len(chosen), len(gap)) - 1]))
    return np.union1d(chosen, np.flatnonzero(above <= search_radius))


#: Share of the elastic displacement up to which gaps, after the predicted motion, make first candidates.
LIKELY = 0.4


@dataclass(frozen=True, eq=False)
class KnownContact:
    """Contact of a similar case, such as one on a coarser mesh.

    Attributes
    ----------
    points : (n, 3) array
        Contact points with force, in world axes.
    depth, beyond : (n,) arrays
        Their distances from the edge of that contact, and distances beyond it within which others may touch.
    """

    points: Array
    depth: Array
    beyond: Array

    def candidates(self, interface: Interface) -> IntArray:
        """Contact points that may touch."""
        return self._within(interface, self.depth + self.beyond)

    def touching(self, interface: Interface, chosen: IntArray) -> Mask:
        """Mask of chosen points within the edge: the first active set."""
        return np.isin(chosen, self._within(interface, self.depth))

    def _within(self, interface: Interface, distance: Array) -> IntArray:
        """Contact points within a distance (n,) from one of the points."""
        tree = cKDTree(interface.slave.pose.to_world(interface.pairing.slave_points))
        return np.unique(flattened(tree.query_ball_point(self.points, distance))[1])


def first_candidates(interface: Interface, opening: Array, loading: Loading, rubs: bool) -> IntArray:
    """First candidates, with friction or without; with a predicted motion, the condensed points near after it."""
    search_radius, pairing = interface.search_radius, interface.pairing
    bodies = interface.slave, interface.master
    first = _likely(bodies, interface.slave_surface, opening, pairing.nodes, pairing.weights, loading, rubs)
    if search_radius is None or search_radius.increment is None or pairing.coupling != "mortar":
        return first
    increment = search_radius.increment_in(interface.slave.pose).at(interface.slave_nodes)
    near = np.flatnonzero(interface.gap + interface.slave_rows @ increment.ravel() <= LIKELY * search_radius.elastic)
    ready = np.ones(len(near), bool)
    for body in elastic_among(bodies):
        rows = interface.rows(body)
        if rows is not None:
            ready &= body.model.has_condensed(rows[near])
    return near[ready] if ready.all() and len(near) >= MIN_CANDIDATES else np.union1d(first, near[ready])


def likely_nodes(surfaces: SurfacePair, areas: Array, bodies: tuple[Body, Body], loading: Loading) -> IntArray:
    """Rows of the slave's nodes that may touch under a load, before anything is paired.

    Parameters
    ----------
    surfaces : SurfacePair
    areas : (n_nodes,) array
        Of all nodes of the slave.
    bodies : (Body, Body)
        Slave and master.
    loading : Loading
    """
    rows = np.flatnonzero(surfaces.facing)
    if len(rows) == 0:
        return rows
    surface, nodes, closest = surfaces.slave, surfaces.nodes[rows], surfaces.closest
    n = closest.normals[rows]
    pose = bodies[1].pose
    ours, theirs = (
        _prescribed(body, pose.to_world(x[rows]), loading) @ pose.rotation
        for body, x in zip(bodies, (surfaces.points, closest.points), strict=True)
    )
    opening = closest.gap[rows] + np.einsum("ni,ni->n", n, ours - theirs)
    return rows[_likely(bodies, surface, opening, nodes, areas[nodes], loading)]


def _prescribed(body: Body, points: Array, loading: Loading) -> Array:
    """Displacements (n, 3) of world points (n, 3) of a body by its prescribed rigid motion."""
    frame = next(f for f in loading.frames if f.body is body)
    return frame.prescribed[:3] + np.cross(frame.prescribed[3:], points - frame.point)


def _likely(
    bodies: tuple[Body, Body],
    surface: FacetSurface,
    opening: Array,
    nodes: IntArray,
    areas: Array,
    loading: Loading,
    rubs: bool = False,
) -> IntArray:
    """Candidates (k,) among slave nodes (n,), from gaps after the prescribed motions, areas and size of the loads."""
    if not len(opening):
        return np.zeros(0, np.int64)
    equal = ROUNDING * surface.size
    nearest = nodes[opening <= opening.min() + equal]
    overlap = approach = max(0.0, -float(opening.min()))
    force = loading.magnitude
    if force > 0:
        compliance = sum(1 / b.contact_modulus for b in bodies)
        if compliance > 0:
            images = _mirror_images(bodies[0], nearest)
            along = surface.out_of_plane
            thickness = None if along is None else along.thickness
            scale = approach_for_load(
                opening - opening.min(), images * areas, 1 / compliance, images * force, thickness
            )
            approach = max(approach, scale)
    layer = approach == overlap > 0 and _is_layer(bodies, surface, nearest, float(areas[opening < 0].sum()))
    return choose(opening, approach, layer, equal, rubs=rubs)


def _is_layer(bodies: tuple[Body, Body], surface: FacetSurface, nearest: IntArray, overlapping: float) -> bool:
    """Whether the overlap of undeformed surfaces has a larger radius than the softer body is thick below it."""
    soft = max(
        (b for b in elastic_among(bodies) if not b.mesh.is_flat), key=lambda b: 1 / b.contact_modulus, default=None
    )
    if soft is None:
        return False
    normal = surface.mean_normals[nearest[0]] @ bodies[0].pose.rotation.T @ soft.pose.rotation
    area = _mirror_images(bodies[0], nearest) * overlapping
    return area > np.pi * float(np.ptp(soft.mesh.points @ normal)) ** 2


def _mirror_images(slave: Body, nearest: IntArray) -> int:
    """Estimated ratio of the whole to the modelled part, to relate the load to the area.

    A boundary held in one component only through the point nearest contact counts as a plane of symmetry. A wrong
    estimate costs time but not accuracy.
    """
    return 2 ** slave._planes_through(nearest)
