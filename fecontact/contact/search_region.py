"""Parts of two surfaces that can come into contact, by lower bounds of their distance and of its change.

A part is a quarter of a quadratic facet, on which its multipliers are bilinear, or else a whole facet. Bernstein
coefficients, on the unit square or on a triangle, bound values between nodes: displacements by the largest coefficient,
the cone of normals by those of x_s x x_t and of the normals interpolated between nodes (`surfaces.normals`).

Proof that an omitted part cannot touch: let d be a lower bound of its distance from a facet of the master, r the rigid
motion of the slave relative to the master, and e, f the largest elastic displacements of part and facet. A gap g along
a line of action n changes by n . r(x) + n . (e - f), as the master's rotation moves point and closest point equally
along n. The line lies between both normals (`surfaces.normals`), n = v / |v| with v a weighted mean of n1 and n2. With
the normals of each in a cone round an axis, n_i . r is no less than b_i = |r| cos(angle to the axis + half angle of the
cone), and v . r no less than the smaller b. Where that is negative, division by |v| < 1 lowers it: |v| >= cos(half the
angle between n1 and n2), with the angle bounded by the cones and by the limit for lines between normals. So if
d + min n . r - e - f > 0 for all facets of the master, no linearised gap of the part closes. Parts that start inside
are always paired.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import elastic_among
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray, Mask, cross
from fecontact.mesh.element import QUAD_CORNERS, quad_nodes
from fecontact.mesh.facets import facet_centres, facet_shapes, unit_vectors
from fecontact.surfaces.closest_point import bulges
from fecontact.surfaces.facet_surface import FacetSurface, facets_of
from fecontact.surfaces.normals import FACING, normals_of


@dataclass(frozen=True, eq=False)
class Bounds:
    """Bounds of all facets of a surface, in the surface's axes.

    A facet is x = L + sum N_a d_a, L interpolating its corners linearly and d_a the offsets of the other nodes from L,
    so that it lies within `bulge` of the hull of its corners, see `surfaces.closest_point`.

    Attributes
    ----------
    corners : (n, 4, 3) array
    centre, normal : (n, 3) arrays
        Centre of the facet.
    bulge : (n,) array
    radius : (n,) array
        Radius of a ball round the centre that contains the facet.
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
    """Bounds of a surface, cached."""
    return surface.once(_bounds)


def _bounds(surface: FacetSurface) -> Bounds:
    n, bulge = len(surface.facets), bulges(surface.points, surface.facets)
    middle = facet_centres(surface.triangle)
    every = np.arange(n)
    centre = surface.evaluate(every, middle)[0]
    corners = surface.points[surface.facets[:, :4]]
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1) + bulge
    size = np.floor(np.log2(radius / radius.min())).astype(int)
    groups = [np.flatnonzero(size == s) for s in np.unique(size)]
    trees = tuple((g, float(radius[g].max()), cKDTree(centre[g])) for g in groups)
    return Bounds(corners, centre, surface.normals(every, middle), bulge, radius, trees, cKDTree(centre), surface.tree)


@dataclass(frozen=True, eq=False)
class FacetParts:
    """A surface divided into parts.

    Attributes
    ----------
    surface : FacetSurface
        The surface with the parts as facets.
    owner : (n_parts,) int array
        Facet of each part.
    columns : (n_parts, k) bool array
        Nodes of that facet whose multipliers are nonzero on the part.
    """

    surface: FacetSurface
    owner: IntArray
    columns: Mask


def parts_of(surface: FacetSurface) -> FacetParts:
    """Quarters of quadratic quadrilaterals, whole facets of other kinds; cached."""
    return surface.once(_parts)


def _parts(surface: FacetSurface) -> FacetParts:
    n, k = surface.facets.shape
    if k == 4 or surface.triangle.any():
        return FacetParts(surface, np.arange(n), np.ones((n, k), bool))
    low = 0.5 * QUAD_CORNERS[:, None]
    local = (low + 0.5 * quad_nodes(9)).reshape(-1, 2)
    points = surface.evaluate(np.repeat(np.arange(n), len(local)), np.tile(local, (n, 1)))[0]
    nodes = quad_nodes(k)
    columns = ((nodes >= low) & (nodes <= low + 0.5)).all(axis=2)
    cut = FacetSurface(points, np.arange(len(points)).reshape(-1, 9), surface.name)
    return FacetParts(cut, np.repeat(np.arange(n), 4), np.tile(columns, (n, 1)))


@dataclass(frozen=True, eq=False)
class Cones:
    """Cones that contain the normals of each facet, its own and interpolated ones, and of its neighbours.

    Attributes
    ----------
    axis : (n, 3) array
    angle : (n,) array
        Half angles.
    """

    axis: Array
    angle: Array

    def chosen(self, rows: IntArray) -> Cones:
        """A subset of the cones."""
        return Cones(self.axis[rows], self.angle[rows])


def cones_of(surface: FacetSurface) -> Cones:
    """Cones of normals, cached."""
    return surface.once(_cones)


@cache
def _bernstein(degree: int, triangle: bool = False) -> tuple[Array, Array]:
    """A grid (n, 2) on the unit square, and the matrix (n, n) from values there to Bernstein coefficients.

    On a triangle, for polynomials whose powers sum to the degree at most (G. Farin, Computer Aided Geometric Design 3,
    1986, p. 83): their values lie in the hull of the coefficients there too.
    """
    t = np.linspace(0.0, 1.0, degree + 1)
    if triangle:
        power = np.array([(i, j, degree - i - j) for i in range(degree + 1) for j in range(degree + 1 - i)])
        times = [math.factorial(degree) // math.prod(map(math.factorial, p)) for p in power.tolist()]
        coordinates = power / degree
        basis = np.array(times) * (coordinates[:, None] ** power).prod(axis=2)
        return coordinates[:, :2], np.linalg.inv(basis)
    basis = np.stack([math.comb(degree, i) * t**i * (1 - t) ** (degree - i) for i in range(degree + 1)], axis=1)
    grid = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    return grid, np.linalg.inv(np.kron(basis, basis))


#: Degrees of x_s x x_t and of the interpolated normals: in each coordinate, and in both together on a triangle.
_NORMAL_DEGREES = {False: (3, 2), True: (4, 3)}


def _cross_products(surface: FacetSurface, facet: IntArray, local: Array) -> Array:
    """x_s x x_t (n, 3)."""
    tangents = surface.evaluate(facet, local)[1]
    return cross(tangents[..., 0], tangents[..., 1])


def _interpolated(surface: FacetSurface, facet: IntArray, local: Array) -> Array:
    """Interpolated normals (n, 3), not of unit length."""
    return normals_of(surface).at(facet, local)


def _cones(surface: FacetSurface) -> Cones:
    n = len(surface.facets)
    axis = bounds_of(surface).normal
    own = np.zeros(n)
    for kind in (False, True):
        rows = np.flatnonzero(surface.triangle == kind)
        for degree, normals in zip(_NORMAL_DEGREES[kind], (_cross_products, _interpolated), strict=True):
            grid, to_bernstein = _bernstein(degree, kind)
            values = normals(surface, np.repeat(rows, len(grid)), np.tile(grid, (len(rows), 1)))
            coefficients = to_bernstein @ values.reshape(len(rows), len(grid), 3)
            along = np.einsum("npi,ni->np", coefficients, axis[rows])
            length = np.linalg.norm(coefficients, axis=2)
            # a coefficient of zero has no direction
            cosine = np.divide(along, length, out=np.full_like(along, -1.0), where=length > 0).min(axis=1, initial=1.0)
            own[rows] = np.maximum(own[rows], np.arccos(np.clip(cosine, -1.0, 1.0)))
    member = sp.csr_matrix((np.ones(4 * n), (np.repeat(np.arange(n), 4), surface.facets[:, :4].ravel())))
    pair = (member @ member.T).tocoo()
    between = np.arccos(np.clip(np.einsum("ni,ni->n", axis[pair.row], axis[pair.col]), -1.0, 1.0))
    angle: Array = own.copy()
    np.maximum.at(angle, pair.row, between + own[pair.col])
    return Cones(axis, angle)


@cache
def lebesgue(n_columns: int) -> float:
    """Upper bound of sum |N_a| over a facet: 1 bilinear, 25/16 on nine nodes, 3 on eight; less on triangles.

    Six-node triangles have 5/3, seven-node triangles less than 2; facets of nine columns may be triangles.
    """
    return {4: 1.0, 8: 3.0, 9: 2.0}[n_columns]


@cache
def _to_quarters(n_columns: int) -> Array:
    """From nodal values (n_columns,) of a quadratic quadrilateral to Bernstein coefficients (4, 9) of its quarters."""
    grid, to_bernstein = _bernstein(2)
    local = (0.5 * QUAD_CORNERS[:, None] + 0.5 * grid).reshape(-1, 2)
    N = facet_shapes(n_columns, np.zeros(len(local), bool), local)[0].reshape(4, 9, n_columns)
    return np.asarray(to_bernstein @ N)


def mean_displacements(surface: FacetSurface, displacement: Array, whole: bool = False) -> tuple[Array, Array]:
    """Means (n, 3) of the displacements of parts or whole facets, and bounds (n,) of what is added to them anywhere.

    On a quarter of a quadratic facet the rest is no larger than the largest difference of a Bernstein coefficient from
    their mean. Elsewhere it is bounded by L max |u_a - m| with the mean m of the nodes: shape functions sum to one, and
    only the rest is enlarged by the Lebesgue constant L.

    Parameters
    ----------
    surface : FacetSurface
    displacement : (n_points, 3) array
        Of the nodes.
    whole : bool
        Whole facets instead of parts.
    """
    u, enlarged = displacement[surface.facets], lebesgue(surface.facets.shape[1])
    if len(parts_of(surface).owner) > len(u):
        u, enlarged = (_to_quarters(u.shape[1]) @ u[:, None]).reshape(-1, 36 if whole else 9, 3), 1.0
    mean = u.mean(axis=1)
    return mean, enlarged * np.linalg.norm(u - mean[:, None], axis=2).max(axis=1)


#: Rings of facets paired round those within the search radius, so that multipliers there are complete and a sliver at a
#: rim finds the multiplier that it joins.
RINGS = 2
#: Rings over which displacements are carried from one pose to the next; beyond, any facet may move as the largest.
MAX_RINGS = 20


@dataclass(frozen=True, eq=False)
class RigidIncrement:
    """Small rigid motion x -> shift + turn x x (vectors (3,)) of a slave relative to its master, in its axes."""

    shift: Array
    turn: Array

    def at(self, points: Array) -> Array:
        """Displacements (n, 3) of points (n, 3)."""
        return self.shift + cross(self.turn, points)


STILL = RigidIncrement(np.zeros(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class SearchRegion:
    """Paired parts of two surfaces.

    Attributes
    ----------
    facets : (n_slave_facets,) bool array
        Paired slave facets.
    nodes : (n_slave_nodes,) bool array
        Paired nodes: those of parts within the radius, and of rings round them at the master's rim.
    opposite : (n_master_facets,) bool array
        Master facets that contain the closest point of any point of the slave facets.
    within : (n_slave_parts,) bool array
        Parts that may come into contact within the radius; all others are omitted.
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
    search_radius: float | tuple[Array, Array],
    increment: RigidIncrement = STILL,
    rings: int = 0,
) -> SearchRegion:
    """Parts of two surfaces whose distance, after a rigid motion, may be less than a search radius.

    Parameters
    ----------
    slave, master : FacetSurface
    rotation, translation
        Pose of the slave's axes in the master's.
    search_radius : float, or (n_slave_parts,) and (n_master_facets,) arrays
        Displacement of both surfaces together beyond the predicted motion, or of each part and of each facet.
    increment : RigidIncrement, optional
        Predicted rigid motion.
    rings : int
        Rings of facets round those within reach that are paired too.

    Returns
    -------
    SearchRegion
    """
    parts = parts_of(slave)
    own, other = bounds_of(parts.surface), bounds_of(master)
    place = _Place(own, other, rotation, translation, increment)
    most = search_radius[0] + search_radius[1].max() if isinstance(search_radius, tuple) else search_radius
    reach = most + place.motion
    far = place.to_centre - own.radius - other.radius.max() > reach
    within = place.inside.copy()
    doubtful = np.flatnonzero(~place.inside & ~far)
    cones = _cones_between(slave, master, rotation)
    within[place.pairs(doubtful, reach[doubtful], cones, search_radius)[0]] = True
    nodes = np.zeros(len(slave.points), bool)
    part, column = np.nonzero(parts.columns & within[:, None])
    nodes[slave.facets[parts.owner[part], column]] = True
    if slave.ties is not None:
        # multipliers along divided sides are tied to others; a shape within reach takes all that it is made of
        nodes = slave.ties.with_tied(nodes)
    facets: Mask = np.asarray(nodes[slave.facets].any(axis=1))
    if rings:
        whole = with_rings(slave, np.bincount(parts.owner, within, len(slave.facets)) > 0, rings)
        nodes[slave.facets[whole]] = True
        facets = np.asarray(nodes[slave.facets].any(axis=1))
    rim = _at_rim(slave, master, facets, rotation, translation)
    if rim.any():
        # a multiplier with a sliver of its area at a rim joins the nearest one with a larger share, which must be
        # included
        around = with_rings(slave, rim, RINGS)
        facets = facets | around
        nodes[slave.facets[around]] = True
        nodes[slave.facets[~facets]] = False
    return SearchRegion(facets, nodes, place.opposite(facets[parts.owner]), within)


def _at_rim(slave: FacetSurface, master: FacetSurface, facets: Mask, rotation: Array, translation: Array) -> Mask:
    """Mask of chosen slave facets that reach the outermost facets of the master."""
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
    elastic: Sequence[tuple[Array, Array]],
) -> tuple[bool, float]:
    """Whether an omitted part can have touched, and the radius needed for these displacements.

    Parameters
    ----------
    near : SearchRegion
    slave, master, rotation, translation
        As in `search_region`.
    increment : RigidIncrement
        Rigid motion of the slave relative to the master.
    elastic : pair of ((n, 3), (n,)) arrays
        Elastic displacements of the slave's parts and of the master's facets in their own axes, see
        `mean_displacements`.
    """
    parts = parts_of(slave)
    own, other = bounds_of(parts.surface), bounds_of(master)
    place = _Place(own, other, rotation, translation, increment)
    (ours, our_rest), (theirs, their_rest) = elastic
    ours = ours @ rotation.T
    most = np.linalg.norm(ours, axis=1) + our_rest, np.linalg.norm(theirs, axis=1) + their_rest
    needed = place.motion + most[0] + most[1].max()
    close = place.to_centre - own.radius - other.radius.max() <= needed
    doubtful = np.flatnonzero((~place.inside | ~near.within) & close)
    cones = _cones_between(slave, master, rotation)
    part, facet, apart = place.pairs(doubtful, needed[doubtful], cones, most)
    left = apart + place.closing(part, facet, cones)
    rest = our_rest[part] + their_rest[facet]
    met = (apart <= 0) | (apart + place.closing(part, facet, cones, (ours, theirs)) <= rest)
    return bool((~near.within[part[met]]).any()), float(left[apart > 0].max(initial=0.0))


def _cones_between(slave: FacetSurface, master: FacetSurface, rotation: Array) -> tuple[Cones, Cones]:
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
    """Angles (n,) between unit vectors (n, 3) and vectors (n, 3) of given size; pi/2 where that is zero."""
    along = np.einsum("ni,ni->n", axis, vector)
    cosine = np.divide(along, size, out=np.zeros_like(size), where=size > 0)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


class _Place:
    """Parts of a slave in the master's axes, with their predicted motion."""

    def __init__(
        self, own: Bounds, other: Bounds, rotation: Array, translation: Array, increment: RigidIncrement
    ) -> None:
        self.own, self.other, self.rotation = own, other, rotation
        self.centre = own.centre @ rotation.T + translation
        self._corners = own.corners @ rotation.T + translation
        self.to_centre, nearest = other.all_centres.query(self.centre)
        self.to_node = other.nodes.query(self.centre)[0]
        offset = self.centre - other.centre[nearest]
        self.inside = np.einsum("ni,ni->n", offset, other.normal[nearest]) < 0
        self.increment = increment.at(self.centre)
        #: largest deviation of the predicted motion over a part from that at its centre, and its largest magnitude
        #: there
        self.spread = float(np.linalg.norm(increment.turn)) * own.radius
        self.motion = np.linalg.norm(self.increment, axis=1) + self.spread

    def closing(
        self, s: IntArray, m: IntArray, cones: tuple[Cones, Cones], elastic: tuple[Array, Array] | None = None
    ) -> Array:
        """Lower bounds (n,) of what the motion adds to the distance of parts s (n,) and facets m (n,).

        With `elastic`, mean displacements of all parts and facets, these too. `cones` are those of all parts and of all
        facets.
        """
        motion = self.increment[s] if elastic is None else self.increment[s] + elastic[0][s] - elastic[1][m]
        return np.asarray(least_along_lines(motion, cones[0].chosen(s), cones[1].chosen(m)) - self.spread[s])

    def pairs(
        self,
        chosen: IntArray,
        radius: Array,
        cones: tuple[Cones, Cones],
        most: float | tuple[Array, Array],
    ) -> tuple[IntArray, IntArray, Array]:
        """Pairs of chosen parts and master facets within `radius` (n_chosen,) that may close, and their distances.

        Pairs whose lower bound of the distance is more than `most` after the predicted motion, or than the sum of
        values of all parts and of all facets, are left out. The distance of two facets is at least that of their balls,
        and that of their hulls along either normal or the line of their centres. It is not positive where a part may be
        inside at the start. See `closing` for `cones`.
        """
        own, other, centre = self.own, self.other, self.centre
        found = []
        for members, largest, tree in other.trees:
            which, hit = flattened(tree.query_ball_point(centre[chosen], radius + own.radius[chosen] + largest))
            found.append((chosen[which], members[hit]))
        s, m = (np.concatenate(f) for f in zip(*found, strict=True))
        closing = self.closing(s, m, cones)
        allowed = most[0][s] + most[1][m] if isinstance(most, tuple) else np.full(len(s), most)
        apart = np.linalg.norm(centre[s] - other.centre[m], axis=1) - own.radius[s] - other.radius[m]
        # the balls' distance decides most pairs, the hulls' along the facet's normal most of the others
        for bound in (None, self._along_normals_of_facets, self._along_normals_of_parts, self._along_centres):
            if bound is not None:
                apart = np.maximum(apart, bound(s, m) - own.bulge[s] - other.bulge[m])
            kept = np.flatnonzero((apart <= 0) | (apart + closing <= allowed))
            s, m, closing, allowed, apart = (a[kept] for a in (s, m, closing, allowed, apart))
        return s, m, apart

    def opposite(self, chosen: Mask) -> Mask:
        """Mask of master facets (n_facets,) that may contain the closest point of points of chosen parts."""
        centre, radius = self.centre[chosen], self.own.radius[chosen]
        farthest = self.to_node[chosen] + 2 * radius
        out = np.zeros(len(self.other.centre), bool)
        for members, largest, tree in self.other.trees:
            out[members[flattened(tree.query_ball_point(centre, farthest + largest))[1]]] = True
        return out

    def _along_normals_of_facets(self, s: IntArray, m: IntArray) -> Array:
        """Distance (n,) of the hulls of parts s (n,) and facets m (n,) along the facets' normals."""
        every = np.arange(len(self.other.centre))
        own = _extent(self._corners, s, self.other.normal[m])
        return _between(own, [e[m] for e in _extent(self.other.corners, every, self.other.normal)])

    def _along_normals_of_parts(self, s: IntArray, m: IntArray) -> Array:
        every, normal = np.arange(len(self.centre)), self.own.normal @ self.rotation.T
        own = [e[s] for e in _extent(self._corners, every, normal)]
        return _between(own, _extent(self.other.corners, m, normal[s]))

    def _along_centres(self, s: IntArray, m: IntArray) -> Array:
        between = self.centre[s] - self.other.centre[m]
        line = unit_vectors(between)
        return _between(_extent(self._corners, s, line), _extent(self.other.corners, m, line))


def _between(one: Sequence[Array], other: Sequence[Array]) -> Array:
    """Distance (n,) of intervals, each given by its ends (n,); negative where they overlap."""
    return np.maximum(one[0] - other[1], other[0] - one[1])


def _extent(corners: Array, chosen: IntArray, direction: Array) -> tuple[Array, Array]:
    """Least and largest coordinates (n,) of the corners (n_facets, k, 3) of chosen facets along directions (n, 3)."""
    x, y, z = np.ascontiguousarray(direction.T)
    least, most = np.full(len(x), np.inf), np.full(len(x), -np.inf)
    for corner in np.ascontiguousarray(corners.transpose(1, 2, 0)):
        along = corner[0][chosen] * x
        along += corner[1][chosen] * y
        along += corner[2][chosen] * z
        np.minimum(least, along, out=least)
        np.maximum(most, along, out=most)
    return least, most


def flattened(lists: NDArray[np.object_]) -> tuple[IntArray, IntArray]:
    """Lists of numbers as two arrays: number of the list, and entry."""
    count = np.fromiter(map(len, lists), dtype=np.int64, count=len(lists))
    if not count.sum():
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    return np.repeat(np.arange(len(lists)), count), np.concatenate([np.asarray(f, dtype=np.int64) for f in lists if f])


def with_rings(surface: FacetSurface, chosen: Mask, rings: int) -> Mask:
    """Facets and a number of rings of neighbours, each of all facets that share a node."""
    for _ in range(rings):
        touched = np.zeros(len(surface.points), bool)
        touched[surface.facets[chosen]] = True
        chosen = np.asarray(touched[surface.facets].any(axis=1))
    return chosen


@dataclass(frozen=True, eq=False)
class LocalReach:
    """Elastic displacements of the facets of both sides of a contact in a similar case.

    Attributes
    ----------
    sides : pair of (n_facets,) arrays
        Upper bounds, see `mean_displacements`.
    poses : (Pose, Pose)
        Of both bodies in that case.
    """

    sides: tuple[Array, Array]
    poses: tuple[Pose, Pose]

    def turned_over(self) -> LocalReach:
        """The same with swapped sides of the contact."""
        return LocalReach(self.sides[::-1], self.poses[::-1])

    def here(self, surfaces: Sequence[FacetSurface], poses: Sequence[Pose]) -> tuple[Array, Array]:
        """Displacements expected in other poses, of the parts of the one side and of the facets of the other.

        A contact moves over either surface by as much at most as one surface moves along the other: each facet takes
        the largest value so far round it, and rings of facets beyond.
        """
        then, now = (p[0].relative_to(p[1]) for p in (self.poses, poses))
        own = surfaces[0].points[surfaces[0].nodes]
        moved = float(np.linalg.norm(then.to_world(own) - now.to_world(own), axis=1).max())
        out = []
        for surface, reach in zip(surfaces, self.sides, strict=True):
            rings = int(np.ceil(moved / surface.mean_facet_size.mean()))
            for _ in range(min(rings, MAX_RINGS)):
                at_nodes = np.zeros(len(surface.points))
                np.maximum.at(at_nodes, surface.facets, reach[:, None])
                reach = at_nodes[surface.facets].max(axis=1)
            out.append(reach if rings <= MAX_RINGS else np.full(len(reach), reach.max()))
        return out[0][parts_of(surfaces[0]).owner], out[1]


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
    local : LocalReach, optional
        Displacement of every facet of both sides; None if unknown.
    chosen : (bool, str, str), optional
        Coupling chosen in nearly the same poses: whether the sides are swapped, its kind, and the note.
    """

    distance: float
    elastic: float
    increment: RigidIncrement | None = None
    local: LocalReach | None = None
    chosen: tuple[bool, str, str] | None = None

    def turned_over(self) -> SearchRadius:
        """The same with swapped sides of the contact."""
        if self.increment is None:
            return self
        local = None if self.local is None else self.local.turned_over()
        return replace(self, increment=RigidIncrement(-self.increment.shift, -self.increment.turn), local=local)

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
    return RigidIncrement((increment.shift + cross(increment.turn, t)) @ R, increment.turn @ R)
