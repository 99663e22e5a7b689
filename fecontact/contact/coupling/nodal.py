"""Pairs of contact points: each slave node with its closest point on the master, and a common line of action.

The line lies between both normals, weighted towards that of the stiffer body (`surfaces.normals`); for the cells of a
half-space it is the half-space's normal. Both bodies get opposite forces along it, so that forces and moments balance
exactly. `SurfacePair` holds the projections, which are found once; the coupling is chosen by them.

If the slave's normal is not opposed to the master's, the two do not face each other and are not a contact. Every
contact that can carry load passes: at an edge or corner of the slave any of its faces may face the master, and on
smooth bodies in contact the normals are opposed.

The area of a node at the master's rim is the covered part of the facets round it; a facet that meets the master along a
line is not covered. Facets with all nodes facing the master are fully covered; only those at the rim are examined.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.sparse.linalg import spsolve

from fecontact.bodies.body import Body
from fecontact.common.arrays import Array, IntArray, Mask, cross
from fecontact.common.compact_repr import compact_repr
from fecontact.contact.coupling.mortar_basis import own_samples
from fecontact.contact.coupling.segments import segment_samples
from fecontact.contact.search_region import SearchRegion, bounds_of, flattened
from fecontact.halfspace.grid import GridSurface
from fecontact.mesh.facets import distinct_columns, facet_centres, facet_nodes, unit_vectors
from fecontact.surfaces.facet_surface import FacetSurface, Projection, Surface, SurfaceTies, facets_of, with_nodes
from fecontact.surfaces.nodal_weights import components_along, contact_weights, facet_weights
from fecontact.surfaces.normals import normals_of, opposing, project_along
from fecontact.surfaces.rigid.shapes import heights_of
from fecontact.surfaces.section_curve import along_line

#: Samples along each side of a facet under a rigid shape, whose rim is known only by projection.
ACROSS = 24
#: Radius of search for overlapping facets round the projection of a facet's centre, over the facet's radius; above one,
#: as on curved surfaces projections are further apart than points.
REACH = 1.5
#: Covered shares within this of 0 or 1 count as 0 or 1: rounding, and chords of curved sides.
WHOLE = 0.02


class CoveredRim(NamedTuple):
    """Facets at the master's rim.

    Attributes
    ----------
    facets : (k,) int array
        Slave facets with some nodes facing the master and others beyond its rim.
    share : (k,) array
        Covered share of their area.
    """

    facets: IntArray
    share: Array

    @property
    def partly(self) -> IntArray:
        """Partly covered facets."""
        return self.facets[(self.share > WHOLE) & (self.share < 1 - WHOLE)]


def rim_of(
    slave: FacetSurface,
    master: Surface,
    rotation: Array,
    translation: Array,
    facing: Mask,
    outside: Mask,
    share: float = 0.0,
) -> CoveredRim:
    """Facets at the rim and their covered shares.

    Parameters
    ----------
    slave, master
    rotation, translation
        Pose of the slave's axes in the master's.
    facing, outside : (n_nodes,) bool arrays
        Slave nodes with a projection on the master, and those beyond its rim.
    share : float
        Weight of the slave's normal in the lines of action.
    """
    facets = np.flatnonzero(facing[slave.facets].any(axis=1) & outside[slave.facets].any(axis=1))
    if len(facets) == 0:
        return CoveredRim(facets, np.zeros(0))
    return CoveredRim(facets, covered_shares(slave, master, rotation, translation, facets, share))


def covered_shares(
    slave: FacetSurface, master: Surface, rotation: Array, translation: Array, facets: IntArray, share: float = 0.0
) -> Array:
    """Covered shares (k,) of the areas of facets (k,), ascending; the rest as in `rim_of`."""
    own, moved = replace(slave, facets=slave.facets[facets]), slave.moved(rotation, translation)
    cut, other = slave.cut(master, rotation, translation, share), facets_of(master)
    if cut is not None:
        facet, local, weight = cut
        at_rim = np.isin(facet, facets)
        facet, local, weight = facet[at_rim], local[at_rim], weight[at_rim]
    elif other is not None:
        f, m = _opposite(replace(moved, facets=own.facets), other)
        facet, local, weight, _ = segment_samples(moved, other, facets[f], m, share)
    else:
        facet, local, weight = _even(own)
        facet = facets[facet]
    if cut is not None or other is None:
        weight = np.where(master.project(moved.evaluate(facet, local)[0]).outside, 0.0, weight)
    whole = own.cut(None, rotation, translation, share) or own_samples(own.facets)
    covered = _areas(own, np.searchsorted(facets, facet), local, weight)
    return np.clip(covered / _areas(own, *whole), 0.0, 1.0)


def _areas(surface: FacetSurface, facet: IntArray, local: Array, weight: Array) -> Array:
    """Areas (n_facets,) from weights (n,) of samples at coordinates (n, 2) of facets (n,)."""
    x, tangents, _ = surface.evaluate(facet, local)
    area = weight * np.linalg.norm(cross(tangents[:, :, 0], tangents[:, :, 1]), axis=1) * surface.extent(x)
    return np.asarray(np.bincount(facet, area, len(surface.facets)), dtype=float)


def _even(surface: FacetSurface) -> tuple[IntArray, Array, Array]:
    """Centres of equal cells of all facets, collapsed at a triangle's last corner: facets, coordinates, weights."""
    middles = (np.arange(ACROSS) + 0.5) / ACROSS
    s, t = (c.ravel() for c in np.meshgrid(middles, middles, indexing="ij"))
    n, on = len(surface.facets), np.repeat(surface.triangle, len(s))
    s, t = np.tile(s, n), np.tile(t, n)
    narrow = np.where(on, 1 - t, 1.0)
    return np.repeat(np.arange(n), ACROSS**2), np.stack([s * narrow, t], axis=1), narrow / ACROSS**2


def _opposite(slave: FacetSurface, master: FacetSurface) -> tuple[IntArray, IntArray]:
    """Pairs of facets that face each other and are near enough to overlap; both surfaces in the same axes."""
    own, other = bounds_of(slave), bounds_of(master)
    projection = master.project(own.centre).points
    pairs = []
    for members, largest, tree in other.trees:
        which, hit = flattened(tree.query_ball_point(projection, REACH * own.radius + largest))
        pairs.append(np.stack([which, members[hit]]))
    f, m = np.concatenate(pairs, axis=1)
    opposed = np.einsum("ni,ni->n", own.normal[f], other.normal[m]) < 0
    return f[opposed], m[opposed]


#: Cosine between one normal and the reversed other below which two points do not face each other: 84 degrees. Faces at
#: right angles are excluded for any rounding and curvature; on bodies in contact normals differ by the slopes within
#: the contact, which is far less.
STEEPEST = 0.1
#: Difference of gaps, relative to the slave's size, that counts as rounding.
TIE = 1e-9
#: Coordinates of the three nodes along a section's side.
_ALONG_SIDE = np.array([0.0, 1.0, 0.5])


class Averted(NamedTuple):
    """The excluded pair, not facing each other, that is nearest to contact.

    Attributes
    ----------
    gap : float
        Its gap; infinite where there is none.
    angle : float
        Angle between the normals in degrees; 180: facing.
    facing : float
        Smallest gap of pairs that face each other; infinite where there is none.
    """

    gap: float = np.inf
    angle: float = np.nan
    facing: float = np.inf


#: Value if all pairs face each other.
NONE_AVERTED = Averted()


class _Corners(NamedTuple):
    """Unit normals (n, 3) of facets at their nodes, sorted by node; first index of each node, and the nodes."""

    normals: Array
    first: IntArray
    nodes: IntArray


def facets_at_nodes(surface: FacetSurface) -> tuple[IntArray, Array, IntArray]:
    """Facets (n,) round all nodes, the coordinates (n, 2) of the nodes there, and their numbers (n,)."""
    if surface.out_of_plane is not None:
        facet, column = np.divmod(np.arange(surface.facets.size), 3)
        local = np.stack([_ALONG_SIDE[column], np.full(len(column), 0.5)], axis=1)
    else:
        k = surface.facets.shape[1]
        facet, column = np.nonzero(distinct_columns(surface.facets))
        reference = np.stack([facet_nodes(k, False), facet_nodes(k, True)])
        local = reference[surface.triangle[facet].astype(int), column]
    return facet, local, surface.facets[facet, column]


def _corners(surface: FacetSurface) -> _Corners:
    facet, local, node = facets_at_nodes(surface)
    _, tangents, _ = surface.evaluate(facet, local)
    normals = cross(tangents[:, :, 0], tangents[:, :, 1])
    normals = unit_vectors(normals)
    order = np.argsort(node, kind="stable")
    nodes, first = np.unique(node[order], return_index=True)
    return _Corners(normals[order], first, nodes)


def opposition(slave: FacetSurface, nodes: IntArray, directions: Array) -> Array:
    """Cosine (n,) between directions (n, 3) and the reversed normal of the best-fitting facet round each node."""
    corners = slave.once(_corners)
    count = np.diff(np.append(corners.first, len(corners.normals)))
    towards = np.zeros((len(slave.points), 3))
    towards[nodes] = directions
    cosines = -np.einsum("ni,ni->n", corners.normals, np.repeat(towards[corners.nodes], count, axis=0))
    best = np.zeros(len(slave.points))
    best[corners.nodes] = np.maximum.reduceat(cosines, corners.first)
    return np.asarray(best[nodes])


def unopposed(slave: FacetSurface, nodes: IntArray, projection: Projection, rotation: Array) -> tuple[Mask, Averted]:
    """Mask of slave nodes (n,) that do not face their closest points, and the nearest of them.

    Parameters
    ----------
    rotation : (3, 3) array
        From the slave's axes to those of the closest points.
    """
    cosines = opposition(slave, nodes, projection.normals @ rotation)
    facing = cosines >= STEEPEST
    out = ~facing & ~projection.outside
    least = float(projection.gap[facing & ~projection.outside].min(initial=np.inf))
    if not out.any():
        return out, Averted(facing=least)
    gap = projection.gap[out]
    # of those equally near, the one that faces best
    near = gap - gap.min() <= TIE * slave.size
    angle = float(np.degrees(np.arccos(-np.clip(cosines[out][near].max(), -1.0, 1.0))))
    return out, Averted(float(gap.min()), angle, least)


#: Overhang of a slave face over its master face, relative to the latter's size, up to which it counts as nested.
NESTED_TOLERANCE = 0.02
#: Slave faces tested first for nesting.
FEW = 8


@dataclass(frozen=True, eq=False)
class SurfacePair:
    """A slave placed in its master's axes, with the projections of its nodes, each computed when it is first needed.

    Parameters
    ----------
    slave : FacetSurface
    master : Surface
    rotation, translation
        Pose of the slave's axes in the master's.
    region : SearchRegion, optional
        Parts of the surfaces that may touch; nodes elsewhere are ignored.
    share : float, optional
        Weight of the slave's normal in the lines of action; the master's has the rest.
    keep_samples : bool, optional
        Whether the samples of a mortar coupling are kept, for rows along tangents, instead of their sums.
    """

    slave: FacetSurface
    master: Surface
    rotation: Array
    translation: Array
    region: SearchRegion | None = None
    share: float = 0.0
    keep_samples: bool = False

    @cached_property
    def nodes(self) -> IntArray:
        """Slave nodes (n,) that are looked at."""
        return self.slave.nodes if self.region is None else np.flatnonzero(self.region.nodes)

    @cached_property
    def points(self) -> Array:
        """The nodes (n, 3) in the master's axes."""
        return self.in_master(self.slave.points[self.nodes])

    def in_master(self, points: Array) -> Array:
        """Points (k, 3) of the slave in the master's axes."""
        return points @ self.rotation.T + self.translation

    @cached_property
    def closest(self) -> Projection:
        """Closest points of the master."""
        return self.master.project(self.points)

    @cached_property
    def _opposed(self) -> tuple[Mask, Averted]:
        return unopposed(self.slave, self.nodes, self.closest, self.rotation)

    @property
    def averted(self) -> Averted:
        """The nearest of the nodes that do not face their closest points."""
        return self._opposed[1]

    @cached_property
    def facing(self) -> Mask:
        """Which nodes (n,) face the master."""
        return ~self.closest.outside & ~self._opposed[0]

    @cached_property
    def along_lines(self) -> Projection:
        """Projection of all nodes along their lines of action."""
        return self._along_lines(self.nodes, self.points, self.closest)

    def some_along_lines(self, rows: IntArray) -> Projection:
        """Projection of some of the nodes along their lines of action."""
        return self._along_lines(self.nodes[rows], self.points[rows], self.closest.chosen(rows))

    def _along_lines(self, nodes: IntArray, points: Array, closest: Projection) -> Projection:
        normals = opposing(self.slave, nodes) @ self.rotation.T
        return project_along(self.master, points, normals, self.share, closest)

    @cached_property
    def rim(self) -> CoveredRim:
        """Slave facets at the master's rim."""
        inside, outside = np.zeros(len(self.slave.points), bool), np.zeros(len(self.slave.points), bool)
        if self.slave.of_nodes:
            return CoveredRim(np.zeros(0, np.int64), np.zeros(0))
        inside[self.nodes], outside[self.nodes] = ~self.along_lines.outside, self.along_lines.outside
        return rim_of(self.slave, self.master, self.rotation, self.translation, inside, outside, self.share)


def nested(surfaces: SurfacePair, near: IntArray) -> bool:
    """Whether every slave face near the contact lies inside one master face, so that nodal forces are exact.

    On curved surfaces projections shift tangentially by a share of the facet that vanishes with (r/R)^2;
    `NESTED_TOLERANCE` of a facet's size is tolerated. A triangle's weights are exact to degree three, so it does not
    count as nested in a quadrilateral, whose functions are of degree four. Nor does a face with fewer nodes than the
    master's, whose weights are exact for linear functions only where those are quadratic, nor one that overhangs the
    master's rim.

    Parameters
    ----------
    surfaces : SurfacePair
        On a surface of facets.
    near : int array
        Rows of its nodes near the contact.
    """
    slave = surfaces.slave
    if slave.facets.shape[1] < with_nodes(surfaces.master).facets.shape[1]:
        return False
    near_node, facing = np.zeros((2, len(slave.points)), bool)
    near_node[surfaces.nodes[near]] = True
    faces = np.flatnonzero(near_node[slave.facets].all(axis=1))
    if len(faces) == 0:
        facing[surfaces.nodes[surfaces.facing]] = True
        faces = np.flatnonzero(near_node[slave.facets].any(axis=1) & facing[slave.facets].all(axis=1))
    # one face that is not nested suffices; lines of action of all nodes are worth finding if nodal pairing needs them
    if len(faces) == 0 or not _nested(surfaces, faces[:FEW]):
        return False
    if near_node[slave.facets[surfaces.rim.partly]].any():
        return False
    return len(faces) <= FEW or _nested(surfaces, faces[FEW:], surfaces.along_lines)


def _nested(surfaces: SurfacePair, faces: IntArray, known: Projection | None = None) -> bool:
    """The same of some faces; `known` are the projections of all nodes along their lines of action."""
    slave, master = surfaces.slave, with_nodes(surfaces.master)
    middle = facet_centres(slave.triangle[faces])
    normals = -normals_of(slave).at(faces, middle) @ surfaces.rotation.T
    centres = surfaces.in_master(slave.evaluate(faces, middle)[0])
    holder = project_along(master, centres, normals, surfaces.share).facet
    assert holder is not None
    if (slave.triangle[faces] & ~master.triangle[holder]).any():
        return False
    rows, which = np.unique(np.searchsorted(surfaces.nodes, slave.facets[faces].ravel()), return_inverse=True)
    places = (surfaces.some_along_lines(rows) if known is None else known.chosen(rows)).points[which.ravel()]
    facet = np.repeat(holder, slave.facets.shape[1])
    off = master.distance_to_facet(places, facet)
    return bool((off <= NESTED_TOLERANCE * master.mean_facet_size[facet]).all())


#: Covered share of a node's area that counts as zero: rounding of poses and coordinates.
NOTHING = 1e-6


@dataclass(frozen=True, eq=False)
class MortarIntegrals:
    """Means over the samples of each of n contact points, in place of the samples themselves.

    Attributes
    ----------
    gap : (n,) array
    on_slave, on_master : (n, 3 n_nodes) csr_matrices
        Rows: opening by nodal displacements of either body, in its axes.
    normals, centres, moments : (n, 3) arrays
        Lines of action, positions, and moments of the lines about `origin`, in the slave's axes.
    origin : (3,) array
    levers : (n, 3) array
        Moments of the lines about the closest points, in the master's axes; zero to rounding.
    """

    gap: Array
    on_slave: sp.csr_matrix
    on_master: sp.csr_matrix
    normals: Array
    centres: Array
    moments: Array
    origin: Array
    levers: Array


@compact_repr
@dataclass(frozen=True, eq=False)
class Pairing:
    """Contact points of one contact and their coupling to both bodies.

    Every contact point is a weighted mean of samples: pairs of a point on the slave and its closest point on the
    master. With nodal coupling a point is one sample, a slave node; with mortar coupling it is the mean over a
    multiplier function.

    Attributes
    ----------
    nodes : (n,) int array
        Slave node of each contact point.
    weights : (n,) array
        Area of each; force / weight is a pressure.
    slave_points : (n, 3) array
        The nodes, in the slave's axes.
    average : (n, n_samples) csr_matrix
        Rows that sum to one.
    slave_weights : (n_samples, n_nodes) csr_matrix
        Interpolation of the samples from the slave's nodes.
    slave_normals : (n_samples, 3) array
        Lines of action in the slave's axes; they point out of the MASTER.
    projection : Projection
        Projection of the samples, in the master's axes.
    n_beyond : int
        Number of slave nodes that lie beyond the master's rim or do not face it.
    rotation, translation : (3, 3) and (3,) arrays
        Pose of the slave's axes in the master's.
    covered : (k,) int array
        Slave facets that face the master, at least partly.
    coupling : str
        'nodal' or 'mortar'.
    slave_facet, slave_local : (n_samples,) and (n_samples, 2) arrays, optional
        Facets of the slave and coordinates of the samples; None where the samples are nodes.
    spread : (n_nodes, n) csr_matrix, optional
        Matrix from the pressures of the contact points to those of all slave nodes; None where points are nodes.
    sums : MortarIntegrals, optional
        Given in place of samples.
    mix : (n, n) csr_matrix, optional
        Rows that sum to one: what the solver takes as contact points are means of these, see `mortar`; None for the
        points themselves.
    averted : Averted
        The nearest pair that does not face, and so is no contact point.
    share : float
        Weight of the slave's normal in the lines of action.
    """

    nodes: IntArray
    weights: Array
    slave_points: Array
    average: sp.csr_matrix
    slave_weights: sp.csr_matrix
    slave_normals: Array
    projection: Projection
    n_beyond: int
    rotation: Array
    translation: Array
    covered: IntArray
    coupling: str = "nodal"
    slave_facet: IntArray | None = None
    slave_local: Array | None = None
    spread: sp.csr_matrix | None = None
    sums: MortarIntegrals | None = None
    mix: sp.csr_matrix | None = None
    averted: Averted = NONE_AVERTED
    share: float = 0.0

    @cached_property
    def at_nodes(self) -> sp.csr_matrix:
        """Matrix (n_nodes, n) from values at the contact points to all slave nodes; other rows are empty."""
        if self.spread is not None:
            return self.spread
        n = len(self.nodes)
        return sp.csr_matrix((np.ones(n), (self.nodes, np.arange(n))), shape=(self.slave_weights.shape[1], n))

    @cached_property
    def gap(self) -> Array:
        """Initial gap (n,), negative where the bodies overlap."""
        return self.average @ self.projection.gap if self.sums is None else self.sums.gap

    @cached_property
    def slave_rows(self) -> sp.csr_matrix:
        """Rows (n, 3 n_nodes): opening by displacements of the slave's nodes, +n."""
        if self.sums is not None:
            return self.sums.on_slave
        return self.average @ components_along(self.slave_weights, self.slave_normals)

    def mixed(self, of_points: Any) -> Any:
        """Values or rows of the solver's points, means of those of the points."""
        return of_points if self.mix is None else self.mix @ of_points

    def unmixed(self, means: Array) -> Array:
        """Values (n, ...) of the points from those of the solver's points."""
        return means if self.mix is None else np.asarray(spsolve(self.mix.tocsc(), means))

    def of_points(self, forces: Array) -> Array:
        """Forces (n, ...) of the points from those of the solver's points: the same resultants and the same work."""
        return forces if self.mix is None else self.mix.T @ forces

    def rows_on_slave(self, slave: Body, surface: str) -> sp.csr_matrix:
        """Rows (n, n_dofs): opening by the slave's generalised displacements."""
        if self.slave_facet is None:
            return self.slave_rows
        n = len(self.slave_facet)
        projection = Projection(
            np.zeros((n, 3)), self.slave_normals, np.zeros(n), np.zeros(n, bool),
            self.slave_weights, self.slave_facet, self.slave_local, surface,
        )  # fmt: skip
        return self.average @ slave._trace(projection, self.slave_normals)

    def master_rows(self, master: Body) -> sp.csr_matrix:
        """Rows (n, n_dofs): opening by the master's displacements, -n at the closest points."""
        if self.sums is not None:
            return self.sums.on_master
        return self.average @ master._trace(self.projection, -self.projection.normals)

    def areas_of_means(self, areas: Array) -> Array:
        """Areas or forces (n,) of the solver's points from those of the points, with the same resultants."""
        return areas if self.mix is None else np.asarray(spsolve(self.mix.T.tocsc(), areas))

    def couple_residual(self, points: Array) -> Array:
        """Moments (n, 3) of the lines of action about the closest points, in the master's axes: zero to rounding.

        Parameters
        ----------
        points : (n_nodes, 3) array
            Of the slave.
        """
        if self.sums is not None:
            return self.sums.levers
        lever = (self.slave_weights @ points) @ self.rotation.T + self.translation - self.projection.points
        return np.asarray(self.average @ cross(lever, self.projection.normals))


def pair(surfaces: SurfacePair) -> Pairing:
    """Pair every slave node, except hanging ones, with its closest point, if they face each other.

    Parameters
    ----------
    surfaces : SurfacePair

    Raises
    ------
    MeshError
        If a slave face is so distorted that a nodal weight is not positive.
    """
    slave, nodes, projection, rim = surfaces.slave, surfaces.nodes, surfaces.along_lines, surfaces.rim
    out, nearest = unopposed(slave, nodes, projection, surfaces.rotation)
    inside = np.zeros(len(slave.points), bool)
    inside[nodes] = ~projection.outside
    areas, onto = covered_weights(slave, rim, inside), None
    if slave.ties is not None:
        areas, onto = _gathered(slave, slave.ties, areas, nodes[projection.outside | out])
        free = np.flatnonzero(~np.isin(nodes, slave.ties.nodes))
        nodes, projection, out = nodes[free], projection.chosen(free), out[free]
    weights = areas[nodes]
    nothing = weights <= NOTHING * contact_weights(slave)[nodes]
    projection = replace(projection, outside=projection.outside | out | nothing)
    pairing = nodal_pairing(slave, nodes, weights, projection, surfaces.rotation, surfaces.translation, onto)
    # at the master's rim those too of which only some nodes have a point
    paired = np.diff(pairing.at_nodes.indptr) > 0
    partly = rim.facets[(rim.share > NOTHING) & paired[slave.facets[rim.facets]].any(axis=1)]
    return replace(pairing, averted=nearest, share=surfaces.share, covered=np.union1d(pairing.covered, partly))


def _gathered(slave: FacetSurface, ties: SurfaceTies, areas: Array, outside: IntArray) -> tuple[Array, sp.csr_matrix]:
    """Areas (n_nodes,) of the nodes that do not hang, and the weights (n_hanging, n_nodes) by which the others follow.

    Nodes `outside` have no part in it: none of those that follow from them alone has a value.
    """
    lost = np.ones(len(slave.points), bool)
    lost[slave.nodes] = False
    lost[outside] = True
    gone = lost[ties.nodes]
    areas[ties.nodes[gone]] = 0.0
    onto = sp.csr_matrix(sp.diags((~gone).astype(float)) @ ties.onto(lost))
    onto.eliminate_zeros()
    return ties.gathered(areas, onto), onto


def covered_weights(slave: FacetSurface, rim: CoveredRim, inside: Mask) -> Array:
    """Areas (n_nodes,) of the slave's nodes, hanging ones too, that the master covers.

    The covered part of a facet at the rim is distributed over its nodes `inside` (n_nodes,), so that force over area is
    a mean pressure; mortar coupling resolves its variation over such a facet.
    """
    weights = facet_weights(slave).copy()
    if len(rim.facets) == 0:
        return weights
    facets = slave.facets[rim.facets]
    # facets that share no node, with a triangle's repeated columns at the first
    first = (facets[:, :, None] == facets[:, None, :]).argmax(axis=2)
    alone = np.arange(len(facets))[:, None] * facets.shape[1] + first
    parts = facet_weights(replace(slave, points=slave.points[facets].reshape(-1, 3), facets=alone))
    parts = parts.reshape(facets.shape)
    there = np.where(inside[facets], parts, 0.0)
    there *= (rim.share * parts.sum(axis=1) / there.sum(axis=1))[:, None]
    np.add.at(weights, facets, there - parts)
    return weights


def nodal_pairing(
    slave: FacetSurface,
    nodes: IntArray,
    weights: Array,
    projection: Projection,
    rotation: Array,
    translation: Array,
    onto: sp.csr_matrix | None = None,
) -> Pairing:
    """Pairing of slave nodes (n,) with areas (n,), without those whose projections (n) lie beyond the rim.

    `onto` (n_hanging, n_nodes) are the weights by which the surface's hanging nodes follow, if there are any.
    """
    kept = np.flatnonzero(~projection.outside)
    n = len(kept)
    ones, pointer = np.ones(n), np.arange(n + 1)
    spread, shown = None, nodes[kept]
    if onto is not None and slave.ties is not None:
        spread = slave.ties.at_nodes(shown, onto)
        shown = np.flatnonzero(np.diff(spread.indptr))
    return Pairing(
        nodes=nodes[kept],
        weights=weights[kept],
        slave_points=slave.points[nodes[kept]],
        average=sp.csr_matrix((ones, np.arange(n), pointer), shape=(n, n)),
        slave_weights=sp.csr_matrix((ones, nodes[kept], pointer), shape=(n, len(slave.points))),
        slave_normals=projection.normals[kept] @ rotation,
        projection=projection.chosen(kept),
        n_beyond=len(nodes) - n,
        rotation=rotation,
        translation=translation,
        covered=_covered(slave, shown),
        spread=spread,
    )


def _covered(slave: FacetSurface, nodes: IntArray) -> IntArray:
    """Facets of which the centre node, three corners of four, or all corners face the master; any node alone."""
    paired = np.zeros(len(slave.points), bool)
    paired[nodes] = True
    on = paired[slave.facets]
    if slave.of_nodes:
        return np.flatnonzero(on.any(axis=1))
    corners = on[:, : min(4, on.shape[1])]
    inside = corners.sum(axis=1) >= np.where(slave.triangle, 4, 3)
    if on.shape[1] == 9:
        inside |= on[:, 8]
    return np.flatnonzero(inside)


#: Normal of a half-space in its own axes.
UPWARDS = (0.0, 0.0, 1.0)


def straight_above(
    points: Array,
    master: Surface,
    rotation: Array,
    translation: Array,
    closest: Projection | None = None,
    normal: ArrayLike = UPWARDS,
) -> Projection:
    """Intersection of lines along a normal (3,) through points (n, 3) with the master; `gap` is measured along them.

    Taken from `heights` where the surface has them and the lines are along its z; otherwise by Newton's method, with
    steps of the distance over its cosine; `closest` are the closest points, if they are known.
    """
    direction = rotation @ np.asarray(normal, dtype=float)
    start = points @ rotation.T + translation
    normals = np.tile(-direction, (len(points), 1))
    heights = heights_of(master)
    if heights is not None and np.array_equal(direction, UPWARDS):
        height = heights(start[:, 0], start[:, 1])
        outside = ~np.isfinite(height)
        height = np.where(outside, start[:, 2], height)
        projection = np.stack([start[:, 0], start[:, 1], height], axis=1)
        return Projection(projection, normals, height - start[:, 2], outside)
    travel, found, lost = along_line(master, start, direction, closest)
    projection = start + travel[:, None] * direction
    return Projection(
        projection, normals, travel, found.outside | lost, found.weights, found.facet, found.local, found.surface
    )


def pair_cells(surfaces: SurfacePair, area: float) -> Pairing:
    """Pair every cell with the point of the master vertically above it.

    A half-space is displaced along its normal only, so gaps and forces are along it.

    Parameters
    ----------
    surfaces : SurfacePair
        The half-space's surface is the slave.
    area : float
        Area of a cell.
    """
    surface, rotation, translation = surfaces.slave, surfaces.rotation, surfaces.translation
    known = surfaces.closest if "closest" in vars(surfaces) else None
    cells, normal = surface.nodes, cast(GridSurface, surface).normal
    projection = straight_above(surface.points[cells], surfaces.master, rotation, translation, known, normal)
    return nodal_pairing(surface, cells, np.full(len(cells), area), projection, rotation, translation)
