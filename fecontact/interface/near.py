"""Which parts of two surfaces can come into touch, by lower bounds of their distance and of how it changes.

A part is a quarter of a quadratic facet, on which its hats are bilinear, or else a whole facet. Why a part that is left
out cannot touch: let d be a lower bound of its distance from a facet of the master, r the rigid motion of the slave
seen from the master, and e, f the largest elastic displacements of part and facet. A gap g along a normal n changes by
n . r(x) + n . (e - f), as the master's rotation moves foot and point by the same along n. With the normals of the facet
in a cone round an axis, n . r is no less than |r| cos(angle to the axis + half angle of the cone). So if d + min n . r
- e - f > 0 for all facets of the master, no linearised gap of the part closes. Parts that start inside are paired
whatever their distance. Bernstein coefficients bound what lies between nodes: displacements by their largest, and the
cone by those of x_s x x_t, a polynomial of degree three.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fecontact.interface.surface import FacetSurface
from fecontact.mesh.facets import distinct_columns, facet_centres, facet_nodes, facet_shapes
from fecontact.mesh.reference import QUAD_CORNERS, quad_nodes

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
    all_centres, nodes : cKDTree
    """

    corners: Array
    centre: Array
    normal: Array
    bulge: Array
    radius: Array
    trees: tuple[tuple[IntArray, float, cKDTree], ...]
    all_centres: cKDTree
    nodes: cKDTree


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
    return Bounds(corners, centre, surface.normals(every, middle), bulge, radius, trees, cKDTree(centre), surface.tree)


@dataclass(frozen=True, eq=False)
class Drift:
    """Small rigid motion x -> shift + turn x x (vectors (3,)) of a slave seen from its master, in the master's axes."""

    shift: Array
    turn: Array

    def at(self, points: Array) -> Array:
        """Displacements (n, 3) of points (n, 3)."""
        return self.shift + np.cross(self.turn, points)


STILL = Drift(np.zeros(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class Near:
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


def near_parts(
    slave: FacetSurface, master: FacetSurface, rotation: Array, translation: Array, reach: float, drift: Drift = STILL
) -> Near:
    """Parts of two surfaces whose distance, after a rigid motion, may be less than a reach.

    Parameters
    ----------
    slave, master : FacetSurface
    rotation, translation
        Pose of the slave's axes seen from the master's.
    reach : float
        Displacement of both surfaces together that is allowed for beyond the drift.
    drift : Drift, optional
        Rigid motion that is expected.

    Returns
    -------
    Near
    """
    parts = parts_of(slave)
    own, other = bounds_of(parts.surface), bounds_of(master)
    place = _Place(own, other, rotation, translation, drift)
    far = place.to_centre - own.radius - other.radius.max() > reach + place.motion
    within = place.inside.copy()
    doubtful = np.flatnonzero(~place.inside & ~far)
    part, _, left = place.pairs(doubtful, reach + place.motion[doubtful], cones_of(master))
    within[part[left <= reach]] = True
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
    return Near(facets, nodes, place.opposite(facets[parts.owner]), within)


def _at_rim(slave: FacetSurface, master: FacetSurface, facets: Mask, rotation: Array, translation: Array) -> Mask:
    """Which of the chosen slave facets reach the outermost facets of the master."""
    nodes = np.unique(slave.facets[facets])
    out = np.zeros(len(slave.points), bool)
    if len(nodes):
        foot = master.project(slave.points[nodes] @ rotation.T + translation, n_near=1).facet
        assert foot is not None
        out[nodes] = master.on_rim[foot].any(axis=1)
    return np.asarray(out[slave.facets].any(axis=1) & facets)


def bridged(
    near: Near,
    slave: FacetSurface,
    master: FacetSurface,
    rotation: Array,
    translation: Array,
    drift: Drift,
    elastic: tuple[Array, Array],
) -> tuple[bool, float]:
    """Whether a part that was left out can have come into touch, and the reach that suits the displacements.

    Parameters
    ----------
    near : Near
    slave, master, rotation, translation
        As in `near_parts`.
    drift : Drift
        Rigid motion of the slave seen from the master.
    elastic : (n_slave_parts,) and (n_master_facets,) arrays
        Upper bounds of the displacements besides, see `part_displacements`.
    """
    parts = parts_of(slave)
    own, other = bounds_of(parts.surface), bounds_of(master)
    place = _Place(own, other, rotation, translation, drift)
    ours, theirs = elastic
    needed = place.motion + ours + theirs.max()
    close = place.to_centre - own.radius - other.radius.max() <= needed
    doubtful = np.flatnonzero((~place.inside | ~near.within) & close)
    part, facet, left = place.pairs(doubtful, needed[doubtful], cones_of(master))
    closing = left <= ours[part] + theirs[facet]
    missed = bool((~near.within[part[closing]]).any())
    return missed, float(left.max(initial=0.0, where=closing))


@dataclass(frozen=True, eq=False)
class Parts:
    """A surface cut into parts.

    Attributes
    ----------
    surface : FacetSurface
        With the parts as facets.
    owner : (n_parts,) int array
        Facet that a part belongs to.
    columns : (n_parts, k) bool array
        Nodes of that facet whose hats live on the part.
    """

    surface: FacetSurface
    owner: IntArray
    columns: Mask


def parts_of(surface: FacetSurface) -> Parts:
    """Quarters of quadratic quadrilaterals; whole facets where there are others. Worked out once."""
    if "parts" not in surface.known:
        surface.known["parts"] = _parts(surface)
    found = surface.known["parts"]
    assert isinstance(found, Parts)
    return found


def _parts(surface: FacetSurface) -> Parts:
    n, k = surface.facets.shape
    if k == 4 or surface.triangle.any():
        return Parts(surface, np.arange(n), np.ones((n, k), bool))
    low = 0.5 * QUAD_CORNERS[:, None]
    local = (low + 0.5 * quad_nodes(9)).reshape(-1, 2)
    points = surface.evaluate(np.repeat(np.arange(n), len(local)), np.tile(local, (n, 1)))[0]
    nodes = quad_nodes(k)
    columns = ((nodes >= low) & (nodes <= low + 0.5)).all(axis=2)
    cut = FacetSurface(points, np.arange(len(points)).reshape(-1, 9), surface.name)
    return Parts(cut, np.repeat(np.arange(n), 4), np.tile(columns, (n, 1)))


@dataclass(frozen=True, eq=False)
class Cones:
    """Cones that hold the normals of each facet and its neighbours: `axis` (n, 3), half `angle` (n,)."""

    axis: Array
    angle: Array


def cones_of(surface: FacetSurface) -> Cones:
    """Cones of normals, worked out once."""
    if "cones" not in surface.known:
        surface.known["cones"] = _cones(surface)
    found = surface.known["cones"]
    assert isinstance(found, Cones)
    return found


def _cones(surface: FacetSurface) -> Cones:
    n = len(surface.facets)
    axis = bounds_of(surface).normal
    if surface.triangle.any():
        return Cones(axis, np.full(n, np.pi))
    t = np.linspace(0.0, 1.0, 4)
    grid = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    tangents = surface.evaluate(np.repeat(np.arange(n), 16), np.tile(grid, (n, 1)))[1]
    normals = np.cross(tangents[..., 0], tangents[..., 1]).reshape(n, 16, 3)
    bernstein = np.stack([comb * t**i * (1 - t) ** (3 - i) for i, comb in enumerate((1, 3, 3, 1))], axis=1)
    coefficients = np.linalg.inv(np.kron(bernstein, bernstein)) @ normals
    cosine = np.einsum("npi,ni->np", coefficients, axis) / np.linalg.norm(coefficients, axis=2)
    own = np.arccos(np.clip(cosine.min(axis=1), -1.0, 1.0))
    member = sp.csr_matrix((np.ones(4 * n), (np.repeat(np.arange(n), 4), surface.facets[:, :4].ravel())))
    pair = (member @ member.T).tocoo()
    between = np.arccos(np.clip(np.einsum("ni,ni->n", axis[pair.row], axis[pair.col]), -1.0, 1.0))
    angle = own.copy()
    np.maximum.at(angle, pair.row, between + own[pair.col])
    return Cones(axis, angle)


class _Place:
    """Parts of a slave in the master's axes, and how they drift."""

    def __init__(self, own: Bounds, other: Bounds, rotation: Array, translation: Array, drift: Drift) -> None:
        self.own, self.other, self.rotation, self.translation = own, other, rotation, translation
        self.centre = own.centre @ rotation.T + translation
        self.to_centre, nearest = other.all_centres.query(self.centre)
        self.to_node = other.nodes.query(self.centre)[0]
        offset = self.centre - other.centre[nearest]
        self.inside = np.einsum("ni,ni->n", offset, other.normal[nearest]) < 0
        self.drift = drift.at(self.centre)
        #: how much the drift differs over a part from that at its centre, and its largest size there
        self.spread = float(np.linalg.norm(drift.turn)) * own.radius
        self.motion = np.linalg.norm(self.drift, axis=1) + self.spread

    def pairs(self, chosen: IntArray, radius: Array, cones: Cones) -> tuple[IntArray, IntArray, Array]:
        """Chosen parts and facets of the master no further apart than `radius` (n_chosen,), and what is left of that.

        That is a lower bound of their distance and what the drift does to it. Two facets are apart by no less than
        their balls are, nor than their hulls along either normal or the line of their centres. Where a part may be
        inside at the start, nothing is left: minus infinity.
        """
        own, other, centre = self.own, self.other, self.centre
        found = []
        for members, largest, tree in other.trees:
            which, hit = _flat(tree.query_ball_point(centre[chosen], radius + own.radius[chosen] + largest))
            found.append((chosen[which], members[hit]))
        s, m = (np.concatenate(f) for f in zip(*found, strict=True))
        apart = self._apart(s, m)
        drift = self.drift[s]
        size = np.linalg.norm(drift, axis=1)
        along = np.einsum("ni,ni->n", cones.axis[m], drift)
        cosine = np.divide(along, size, out=np.zeros_like(size), where=size > 0)
        angle = np.minimum(np.arccos(np.clip(cosine, -1.0, 1.0)) + cones.angle[m], np.pi)
        return s, m, np.where(apart > 0, apart + size * np.cos(angle) - self.spread[s], -np.inf)

    def opposite(self, chosen: Mask) -> Mask:
        """Facets of the master (n_facets,) that may hold the nearest point of any point of chosen parts (n_parts,)."""
        centre, radius = self.centre[chosen], self.own.radius[chosen]
        farthest = self.to_node[chosen] + 2 * radius
        out = np.zeros(len(self.other.centre), bool)
        for members, largest, tree in self.other.trees:
            out[members[_flat(tree.query_ball_point(centre, farthest + largest))[1]]] = True
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


def _flat(lists: NDArray[np.object_]) -> tuple[IntArray, IntArray]:
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


@cache
def lebesgue(n_columns: int) -> float:
    """Upper bound of sum |N_a| over a facet: 1 bilinear, 25/16 on nine nodes, 3 on eight; triangles less than these.

    Six- and seven-node triangles reach 5/3 and less than 2; facets of nine columns may be such.
    """
    return {4: 1.0, 8: 3.0, 9: 2.0}[n_columns]


@cache
def _to_quarters(n_columns: int) -> Array:
    """From nodal values (n_columns,) of a quadratic quadrilateral to Bernstein coefficients (4, 9) of its quarters."""
    t = np.array([0.0, 0.5, 1.0])
    bernstein = np.stack([(1 - t) ** 2, 2 * t * (1 - t), t**2], axis=1)
    grid = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    local = (0.5 * QUAD_CORNERS[:, None] + 0.5 * grid).reshape(-1, 2)
    N = facet_shapes(n_columns, np.zeros(len(local), bool), local)[0].reshape(4, 9, n_columns)
    return np.asarray(np.linalg.inv(np.kron(bernstein, bernstein)) @ N)


def part_displacements(surface: FacetSurface, displacement: Array) -> Array:
    """Upper bound (n_parts,) of the displacement of any point of a part, from those of the nodes (n_points, 3).

    On a quarter of a quadratic facet it is no larger than the largest Bernstein coefficient. Elsewhere |u| <= |m| + L
    max |u_a - m| with the mean m of the nodes: shape functions sum to one, and only the rest is enlarged by the
    Lebesgue constant L.
    """
    u = displacement[surface.facets]
    if len(parts_of(surface).owner) > len(u):
        return np.linalg.norm(_to_quarters(u.shape[1]) @ u[:, None], axis=3).max(axis=2).ravel()
    mean = u.mean(axis=1)
    rest = np.linalg.norm(u - mean[:, None], axis=2).max(axis=1)
    return np.asarray(np.linalg.norm(mean, axis=1) + lebesgue(surface.facets.shape[1]) * rest)


def facet_displacements(surface: FacetSurface, displacement: Array) -> Array:
    """The same for whole facets (n_facets,)."""
    return part_displacements(surface, displacement).reshape(len(surface.facets), -1).max(axis=1)
