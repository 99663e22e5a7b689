"""Which facets of two surfaces can come within a reach of each other, by lower bounds of their distance.

Why what is left out cannot touch: let d be a lower bound of the distance of a slave facet from the whole master. If no
point of that facet moves by more than a, no point of the master by more than b, and a + b < d, then no point of the
facet meets the master on the way, and a facet that starts outside ends outside. The gap of a pair is no smaller than
the distance of its points, and its change no larger than a + b, so that linearised gaps are positive too. Facets that
start inside are paired whatever their distance. a and b follow from the nodes' displacements and the Lebesgue constant
max sum |N_a|, which bounds what shape functions make of them in between.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fecontact.interface.surface import FacetSurface
from fecontact.mesh.facets import distinct_columns, facet_centres, facet_nodes, facet_shapes

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: Rings of facets round those within reach that are paired with them, so that a hat within reach is whole and a sliver
#: at a rim finds the hat that it joins.
RINGS = 2
#: Sum of the absolute shape functions other than the corners', on facets of 8 or 9 columns: 2 in the middle of an
#: eight-node facet, less on all others.
BULGE = 2.0


@dataclass(frozen=True, eq=False)
class Bounds:
    """What is known of all facets of a surface without a search, in the surface's axes.

    A facet is x = L + sum N_a d_a, L interpolating its corners linearly and d_a the offsets of the other nodes from L,
    so that it lies no further than `bulge` = `BULGE` max |d_a| from the hull of its corners.

    Attributes
    ----------
    corners : (n, 4, 3) array
    centre, normal : (n, 3) arrays
        Of the facet's middle.
    bulge : (n,) array
    radius : (n,) array
        Of a ball round the centre that holds the facet.
    trees : tuple of (IntArray, float, cKDTree)
        Facets of similar radius, the largest radius among them, and their centres.
    """

    corners: Array
    centre: Array
    normal: Array
    bulge: Array
    radius: Array
    trees: tuple[tuple[IntArray, float, cKDTree], ...]
    all_centres: cKDTree


def bounds_of(surface: FacetSurface) -> Bounds:
    """Bounds of a surface, worked out once."""
    if "bounds" not in surface.known:
        surface.known["bounds"] = _bounds(surface)
    found = surface.known["bounds"]
    assert isinstance(found, Bounds)
    return found


def _bounds(surface: FacetSurface) -> Bounds:
    n, k = surface.facets.shape
    x = surface.points[surface.facets]
    bulge = np.zeros(n)
    if k > 4:
        off = np.zeros((n, k))
        for kind in (False, True):
            rows = np.flatnonzero(surface.triangle == kind)
            linear = facet_shapes(4, np.full(k, kind), facet_nodes(k, kind))[0]
            off[rows] = np.linalg.norm(x[rows] - np.einsum("ab,nbi->nai", linear, x[rows, :4]), axis=2)
        bulge = BULGE * np.where(distinct_columns(surface.facets), off, 0.0).max(axis=1)
    middle = facet_centres(surface.triangle)
    every = np.arange(n)
    centre = surface.evaluate(every, middle)[0]
    corners = x[:, :4]
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1) + bulge
    size = np.floor(np.log2(radius / radius.min())).astype(int)
    groups = [np.flatnonzero(size == s) for s in np.unique(size)]
    trees = tuple((g, float(radius[g].max()), cKDTree(centre[g])) for g in groups)
    return Bounds(corners, centre, surface.normals(every, middle), bulge, radius, trees, cKDTree(centre))


@dataclass(frozen=True, eq=False)
class Near:
    """Parts of two surfaces that are paired.

    Attributes
    ----------
    facets : (n_slave_facets,) bool array
        Slave facets within reach and rings of facets round them.
    nodes : (n_slave_nodes,) bool array
        Nodes all of whose facets are among these, and one of them within reach or next to one that is.
    opposite : (n_master_facets,) bool array
        Master facets that hold the nearest point of any point of the slave facets.
    clearance : (n_slave_facets,) array
        Lower bound of the distance of each slave facet that is out of reach from the whole master; infinite for those
        within.
    """

    facets: Mask
    nodes: Mask
    opposite: Mask
    clearance: Array


def near_parts(slave: FacetSurface, master: FacetSurface, rotation: Array, translation: Array, reach: float) -> Near:
    """Parts of two surfaces whose distance may be less than a reach.

    Parameters
    ----------
    slave, master : FacetSurface
    rotation, translation
        Pose of the slave's axes seen from the master's.
    reach : float

    Returns
    -------
    Near
    """
    own, other = bounds_of(slave), bounds_of(master)
    centre = own.centre @ rotation.T + translation
    to_centre, nearest = other.all_centres.query(centre)
    clearance = to_centre - own.radius - other.radius.max()
    inside = np.einsum("ni,ni->n", centre - other.centre[nearest], other.normal[nearest]) < 0
    clearance = np.where(inside, 0.0, clearance)
    doubtful = np.flatnonzero(~inside & (clearance <= reach))
    clearance[doubtful] = _least_distances(own, other, rotation, translation, centre, doubtful, reach)
    within = clearance <= reach
    facets = _with_rings(slave, within, RINGS)
    nodes = np.zeros(len(slave.points), bool)
    nodes[slave.facets[facets]] = True
    nodes[slave.facets[~facets]] = False
    kept = np.flatnonzero(facets)
    farthest = to_centre[kept] + own.radius[kept]
    opposite = np.zeros(len(master.facets), bool)
    for members, radius, tree in other.trees:
        found = tree.query_ball_point(centre[kept], farthest + own.radius[kept] + radius)
        opposite[members[_flat(found)[1]]] = True
    return Near(facets, nodes, opposite, np.where(within, np.inf, clearance))


def _flat(lists: NDArray[np.object_]) -> tuple[IntArray, IntArray]:
    """Lists of numbers as two arrays: which list, and the number."""
    count = np.fromiter(map(len, lists), dtype=np.int64, count=len(lists))
    if not count.sum():
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    return np.repeat(np.arange(len(lists)), count), np.concatenate([np.asarray(f, dtype=np.int64) for f in lists if f])


def _least_distances(
    own: Bounds, other: Bounds, rotation: Array, translation: Array, centre: Array, chosen: IntArray, reach: float
) -> Array:
    """Lower bounds of the distance of chosen slave facets from the master, exact enough to tell them from a reach.

    Two facets are apart by no less than their balls are, nor than their hulls along either normal or the line of their
    centres. Pairs further apart than twice the reach are not looked at, so no bound exceeds that.
    """
    least = np.full(len(chosen), 2 * reach)
    for members, radius, tree in other.trees:
        found = tree.query_ball_point(centre[chosen], 2 * reach + own.radius[chosen] + radius)
        which, hit = _flat(found)
        s, m = chosen[which], members[hit]
        between = centre[s] - other.centre[m]
        length = np.linalg.norm(between, axis=1)
        apart = length - own.radius[s] - other.radius[m]
        corners = own.corners[s] @ rotation.T + translation
        line = np.divide(between, length[:, None], out=np.zeros_like(between), where=length[:, None] > 0)
        for direction in (other.normal[m], own.normal[s] @ rotation.T, line):
            ours = np.einsum("nai,ni->na", corners, direction)
            theirs = np.einsum("nai,ni->na", other.corners[m], direction)
            above, below = ours.min(axis=1) - theirs.max(axis=1), theirs.min(axis=1) - ours.max(axis=1)
            apart = np.maximum(apart, np.maximum(above, below) - own.bulge[s] - other.bulge[m])
        np.minimum.at(least, which, np.maximum(apart, 0.0))
    return least


def _with_rings(surface: FacetSurface, chosen: Mask, rings: int) -> Mask:
    """Facets and so many rings of neighbours round them, each of all facets that share a node."""
    for _ in range(rings):
        touched = np.zeros(len(surface.points), bool)
        touched[surface.facets[chosen]] = True
        chosen = np.asarray(touched[surface.facets].any(axis=1))
    return chosen


@cache
def lebesgue(n_columns: int) -> float:
    """Upper bound of sum |N_a| over a facet: 1 bilinear, 25/16 on nine nodes, 3 on eight; triangles less than these.

    Six- and seven-node triangles reach 5/3 and less than 2; facets of nine columns may be such.
    """
    return {4: 1.0, 8: 3.0, 9: 2.0}[n_columns]


def needed_clearance(surface: FacetSurface, displacement: Array, opposite: float) -> Array:
    """Distance (n_facets,) that may close: each slave facet's largest displacement and the master's together.

    Parameters
    ----------
    surface : FacetSurface
    displacement : (n_points, 3) array
        Of the slave's nodes.
    opposite : float
        The master's largest, see `largest_displacement`.
    """
    return _facet_displacements(surface, displacement) + opposite


def largest_displacement(surface: FacetSurface, displacement: Array) -> float:
    """Upper bound of the displacement of any point of a surface, from its nodes (n_points, 3)."""
    return float(_facet_displacements(surface, displacement).max())


def _facet_displacements(surface: FacetSurface, displacement: Array) -> Array:
    """Upper bound (n_facets,) of the displacement of any point of a facet.

    |u| <= |m| + L max |u_a - m| with the mean m of the nodes: shape functions sum to one, and only the rest is enlarged
    by the Lebesgue constant L.
    """
    u = displacement[surface.facets]
    mean = u.mean(axis=1)
    rest = np.linalg.norm(u - mean[:, None], axis=2).max(axis=1)
    return np.asarray(np.linalg.norm(mean, axis=1) + lebesgue(surface.facets.shape[1]) * rest)
