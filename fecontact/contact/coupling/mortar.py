"""Mortar coupling: weighted gaps over the exact overlap of two surfaces.

Nodal forces are a quadrature rule on the slave; where a slave face straddles master faces, the load on the master is
wrong. Here the pressure is a sum of non-negative multiplier functions on the slave, p = sum_k p_k phi_k, p_k >= 0, and
all integrals are over the segments in which one slave face meets one master face:

    weighted gap   w_k = int phi_k n . (x_slave - x_master) dA >= 0,    force on the bodies  +-int phi_k n N dA p_k

The multipliers of a nine-node face are bilinear on its quarters, those of a triangle linear (`mortar_basis`); they sum
to one, so uniform pressure is exact on both sides (Puso & Laursen 2004; Popp et al. 2012 for multipliers on sub-faces).
Segments are those of `segments`.

All results are linear in the weights of the samples. To limit memory, blocks of samples are summed per multiplier, and
the sums of all blocks added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask, cross
from fecontact.common.errors import InputError
from fecontact.contact.coupling.mortar_basis import has_mortar_basis, multiplier_shapes, own_samples, tied_multipliers
from fecontact.contact.coupling.nodal import STEEPEST, MortarIntegrals, Pairing, SurfacePair
from fecontact.contact.coupling.segments import segment_samples, tangent_plane_maps
from fecontact.contact.search_region import SearchRegion
from fecontact.mesh.element import TRIANGLE_NODES
from fecontact.mesh.facets import facet_nodes
from fecontact.surfaces.facet_surface import FacetSurface, Projection, Surface, facets_of, with_nodes
from fecontact.surfaces.nodal_weights import components_along
from fecontact.surfaces.normals import meet, normals_of, project_along, projection_at


class Samples(NamedTuple):
    """Samples that face the master.

    Attributes
    ----------
    facet, local : (n,) and (n, 2) arrays
        Facet and coordinates on the slave.
    multipliers : (n, n_nodes) csr_matrix
        The slave's multiplier functions there times the area of each sample.
    weights : (n, n_nodes) csr_matrix
        Interpolation from the slave's nodes.
    projection : Projection
    """

    facet: IntArray
    local: Array
    multipliers: sp.csr_matrix
    weights: sp.csr_matrix
    projection: Projection


@dataclass(frozen=True, eq=False)
class Block:
    """Sums over one block of samples, for the multipliers (n_used,) in it.

    Attributes
    ----------
    used, facets : (n_used,) and (n_facets,) int arrays
        Nodes of the multipliers, and the slave facets sampled.
    dense : (n_used, 14) array
        Area; gap; normal, position and its moment in the slave's axes; moment of the normal about the closest point.
    on_slave, on_master : (n_used, 3 n_nodes) csr_matrices
    """

    used: IntArray
    facets: IntArray
    dense: Array
    on_slave: sp.csr_matrix
    on_master: sp.csr_matrix


def block_of(samples: Samples, points: Array, origin: Array, rotation: Array, translation: Array) -> Block:
    """Sums of one block.

    Parameters
    ----------
    samples : Samples
    points : (n_nodes, 3) array
        Of the slave.
    origin : (3,) array
        Reference point of moments, in the slave's axes.
    rotation, translation
        Pose of the slave's axes in the master's.
    """
    projection = samples.projection
    assert projection.weights is not None
    multipliers = samples.multipliers.T.tocsr()
    used = np.flatnonzero(np.diff(multipliers.indptr))
    multipliers = multipliers[used]
    normals, x = projection.normals @ rotation, samples.weights @ points
    lever = x @ rotation.T + translation - projection.points
    columns = (
        np.ones(len(x)),
        projection.gap,
        normals,
        x,
        cross(x - origin, normals),
        cross(lever, projection.normals),
    )
    return Block(
        used,
        np.unique(samples.facet),
        multipliers @ np.column_stack(columns),
        multipliers @ components_along(samples.weights, normals),
        multipliers @ components_along(projection.weights, -projection.normals),
    )


def total_areas(blocks: Sequence[Block], n_nodes: int) -> Array:
    """Sampled area (n_nodes,) of each multiplier."""
    out = np.zeros(n_nodes)
    for block in blocks:
        out[block.used] += block.dense[:, 0]
    return out


def summed(blocks: Sequence[Block], gather: sp.csr_matrix, areas: Array, origin: Array) -> MortarIntegrals:
    """Means over the multiplier functions of contact points.

    Parameters
    ----------
    blocks : sequence of Block
    gather : (n, n_nodes) csr_matrix
        Multipliers joined in each contact point.
    areas : (n,) array
        Areas of the contact points.
    origin : (3,) array
        As in `block_of`.
    """
    used = np.concatenate([b.used for b in blocks])
    ones, which = np.ones(len(used)), np.arange(len(used))
    mean = sp.diags(1 / areas) @ gather @ sp.csr_matrix((ones, (used, which)), shape=(gather.shape[1], len(used)))
    _, gap, normals, centres, moments, levers = np.split(
        mean @ np.concatenate([b.dense for b in blocks]), [1, 2, 5, 8, 11], axis=1
    )
    on_slave = mean @ sp.vstack([b.on_slave for b in blocks], format="csr")
    on_master = mean @ sp.vstack([b.on_master for b in blocks], format="csr")
    return MortarIntegrals(gap[:, 0], on_slave, on_master, normals, centres, moments, origin, levers)


#: Pairs of facets segmented, sampled and summed in one block, which bounds the memory for samples.
BLOCK = 3000
#: Samples per block of the integration of multipliers.
AREAS = 50_000
#: Covered share of a multiplier's area, over that of a neighbour, from which on nothing is lent: half a multiplier's.
FULL = 0.5
#: Largest share of a multiplier that acts with neighbours that have less of their area.
MAX_LENT = 0.99
#: The same ratio below which two multipliers would be independent by rounding only: such ones join their neighbours.
NOTHING = 1e-4


def pair_mortar(surfaces: SurfacePair) -> Pairing:
    """Couple two surfaces by weighted gaps.

    Parameters
    ----------
    surfaces : SurfacePair
        The slave's facets with a mortar basis: all but plain eight-node quadrilaterals.

    Raises
    ------
    InputError
        If the slave has eight-node facets (no multiplier for the missing centre).
    """
    slave, master, share, near = surfaces.slave, surfaces.master, surfaces.share, surfaces.region
    rotation, translation = surfaces.rotation, surfaces.translation
    if not has_mortar_basis(slave):
        raise InputError(
            f"Mortar coupling needs a slave whose quadrilateral faces have four or nine nodes; {slave.name!r} has "
            "plain eight-node faces. Make the other body the slave, use pressure='midface', or coupling='nodal'.",
            code="mortar-of-eight-nodes",
        )
    cut, other = slave.cut(master, rotation, translation, share), facets_of(master)
    if cut is not None:
        samples = _samples(slave, master, rotation, translation, share, *cut)
    elif other is not None:
        moved = slave.moved(rotation, translation)
        f, m = _neighbours(slave, other, rotation, translation, near)

        def taken(part: slice) -> Samples:
            pieces = segment_samples(moved, other, f[part], m[part], share)
            return _samples(slave, master, rotation, translation, share, *pieces)

        # bodies whose displacements are not nodal need the samples
        if len(f) > BLOCK and not (slave.mortar_on_quad8 or other.mortar_on_quad8 or surfaces.keep_samples):
            origin = slave.points[slave.nodes].mean(axis=0)
            parts = [slice(start, start + BLOCK) for start in range(0, len(f), BLOCK)]
            blocks = [block_of(taken(part), slave.points, origin, rotation, translation) for part in parts]
            pairing = _paired_in_blocks(slave, other, blocks, origin, rotation, translation, near)
            return replace(pairing, share=share)
        samples = taken(slice(None))
    else:
        samples = _samples(slave, master, rotation, translation, share, *quadrature(slave))
    return replace(_paired(slave, samples, rotation, translation, near), share=share)


#: Intervals along each side of a face between its samples where forces may act at any point.
ACROSS = 16


def pair_anywhere(surfaces: SurfacePair) -> Pairing:
    """Pairing with a grid of samples on each face, its sides and corners included, whatever the coupling is."""
    slave, s = surfaces.slave, np.linspace(0.0, 1.0, ACROSS + 1)
    grid = np.stack(np.meshgrid(s, s, indexing="ij"), -1).reshape(-1, 2)
    facet, local = np.repeat(np.arange(len(slave.facets)), len(grid)), np.tile(grid, (len(slave.facets), 1))
    local[:, 0] *= np.where(slave.triangle[facet], 1 - local[:, 1], 1.0)
    place = surfaces.rotation, surfaces.translation
    samples = _samples(slave, surfaces.master, *place, surfaces.share, facet, local, np.ones(len(facet)))
    return replace(_paired(slave, samples, *place, None), share=surfaces.share)


def _samples(
    slave: FacetSurface,
    master: Surface,
    rotation: Array,
    translation: Array,
    share: float,
    facet: IntArray,
    local: Array,
    weight: Array,
    on_master: IntArray | None = None,
) -> Samples:
    """Samples with quadrature weights (n,) in the slave's coordinates, on given facets (n,) of the master or on any."""
    # in the slave's axes: those of a section rotated by pi have y reversed
    own, tangents, N = slave.evaluate(facet, local)
    x = own @ rotation.T + translation
    normal = cross(tangents[:, :, 0], tangents[:, :, 1]) @ rotation.T
    inwards = -normals_of(slave).at(facet, local) @ rotation.T
    if on_master is None:
        projection = project_along(master, x, inwards, share)
    else:
        projection = _projected_on(with_nodes(master), on_master, x, inwards, share)
    length = np.linalg.norm(normal, axis=1)
    facing = (np.einsum("ni,ni->n", normal, projection.normals) < -STEEPEST * length) & ~projection.outside
    area = weight * length * slave.extent(own)
    kept = np.flatnonzero(facing)
    facet, local, k = facet[kept], local[kept], slave.facets.shape[1]
    columns = slave.facets[facet].ravel()
    pointer = np.arange(0, len(kept) * k + 1, k)
    shape = (len(kept), len(slave.points))
    multipliers = multiplier_shapes(k, slave.triangle[facet], local) * area[kept, None]
    weighted = sp.csr_matrix((multipliers.ravel(), columns, pointer), shape=shape)
    weighted.eliminate_zeros()
    weights = sp.csr_matrix((N[kept].ravel(), columns, pointer), shape=shape)
    return Samples(facet, local, weighted, weights, projection.chosen(kept))


def _paired(
    slave: FacetSurface,
    samples: Samples,
    rotation: Array,
    translation: Array,
    near: SearchRegion | None,
) -> Pairing:
    """Weighted gaps of the slave's nodes from samples, or of the nodes whose multipliers are fully sampled."""
    multipliers = samples.multipliers.T.tocsr()
    points = _points(slave, np.asarray(multipliers.sum(axis=1)).ravel(), near)
    multipliers = (points.gather @ multipliers).tocsr()
    area = np.asarray(multipliers.sum(axis=1)).ravel()
    return points.paired(
        slave,
        area,
        rotation,
        translation,
        average=sp.diags(1 / area) @ multipliers,
        slave_weights=samples.weights,
        slave_normals=samples.projection.normals @ rotation,
        projection=samples.projection,
        covered=np.unique(samples.facet),
        slave_facet=samples.facet,
        slave_local=samples.local,
    )


def _paired_in_blocks(
    slave: FacetSurface,
    master: FacetSurface,
    blocks: list[Block],
    origin: Array,
    rotation: Array,
    translation: Array,
    near: SearchRegion | None,
) -> Pairing:
    """As `_paired`, from sums over blocks; samples are not kept."""
    weights = total_areas(blocks, len(slave.points))
    points = _points(slave, weights, near)
    area = points.gather @ weights
    nothing, none = np.zeros((0, 3)), np.zeros(0, np.int64)
    projection = Projection(
        nothing, nothing, np.zeros(0), np.zeros(0, bool), sp.csr_matrix((0, len(master.points))), none,
        np.zeros((0, 2)), master.name,
    )  # fmt: skip
    return points.paired(
        slave,
        area,
        rotation,
        translation,
        average=sp.csr_matrix((len(area), 0)),
        slave_weights=sp.csr_matrix((0, len(slave.points))),
        slave_normals=nothing,
        projection=projection,
        covered=np.unique(np.concatenate([b.facets for b in blocks])),
        sums=summed(blocks, points.gather, area, origin),
    )


class _Points(NamedTuple):
    """Contact points: their nodes, multipliers (n, n_nodes), shares (n, n) in what the solver takes, nodes beyond."""

    nodes: IntArray
    gather: sp.csr_matrix
    shares: sp.csr_matrix
    whole: Array
    n_beyond: int

    def paired(self, slave: FacetSurface, area: Array, rotation: Array, translation: Array, **samples: Any) -> Pairing:
        """The pairing of these points with areas (n,), from samples or their sums."""
        return Pairing(
            nodes=self.nodes,
            weights=area,
            slave_points=slave.points[self.nodes],
            n_beyond=self.n_beyond,
            rotation=rotation,
            translation=translation,
            coupling="mortar",
            spread=(_multipliers_at_nodes(slave, self.whole) @ self.gather.T).tocsr(),
            mix=self._mix(area),
            **samples,
        )

    def _mix(self, area: Array) -> sp.csr_matrix | None:
        """The solver's points (n, n) as means of these with areas (n,); None where they are the same."""
        if self.shares.nnz == len(area):
            return None
        mixed = self.shares @ sp.diags(area)
        return sp.csr_matrix(sp.diags(1 / (mixed @ np.ones(len(area)))) @ mixed)


def _points(slave: FacetSurface, weights: Array, near: SearchRegion | None) -> _Points:
    """Contact points from the sampled areas (n_nodes,) of all multipliers.

    Multipliers that are not fully sampled are removed from `weights`.
    """
    whole, ties = slave.once(_multiplier_areas), tied_multipliers(slave)
    if near is not None:
        weights[~near.nodes] = 0.0
        whole = np.where(near.nodes, whole, 0.0)
    own, full = (weights, whole) if ties is None else (ties.T @ weights, ties.T @ whole)
    nodes, gather, shares = _lent(slave, own, full)
    n_beyond = int((full > 0).sum() - (own > 0).sum())
    return _Points(nodes, gather if ties is None else (gather @ ties.T).tocsr(), shares, whole, n_beyond)


def _multipliers_at_nodes(slave: FacetSurface, whole: Array) -> sp.csr_matrix:
    """Multipliers (n_nodes, n_nodes) at all nodes: one at its own; a triangle's other nodes from its corners."""
    k, n = slave.facets.shape[1], len(slave.points)
    own = np.flatnonzero(whole > 0)
    rows, columns, values = [own], [own], [np.ones(len(own))]
    if slave.triangle.any() and k > 4:
        multipliers = multiplier_shapes(k, np.ones(k, bool), facet_nodes(k, True))[:, :3]
        facets = slave.facets[slave.triangle]
        node, first = np.unique(facets, return_index=True)
        first, node = first[whole[node] == 0], node[whole[node] == 0]
        facet, place = np.divmod(first, k)
        rows.append(np.repeat(node, 3))
        columns.append(facets[facet, :3].ravel())
        values.append(multipliers[place].ravel())
    return sp.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(n, n))


def _lent(slave: FacetSurface, weights: Array, whole: Array) -> tuple[IntArray, sp.csr_matrix, sp.csr_matrix]:
    """Nodes of the contact points, the multipliers (n, n_nodes) that each has, and the share (n, n) of those in each.

    At the rim of an overlap a multiplier has a part of its area only. Independent it would follow the peak of the
    pressure at the rim, the closer the less it has; left out, it would move the centre of the pressure inwards, by a
    jump where the rim passes. So it acts together with a share of its neighbours along sides of facets that have more
    of their area. This share falls from `MAX_LENT` where it has nothing to zero where its part of its area is half of
    theirs, as at a rim along sides of facets. All functions stay non-negative, they sum to one, and they change
    continuously as the rim moves over the facets, and so do forces and moments.
    """
    cover = np.divide(weights, whole, out=np.zeros_like(whole), where=whole > 0)
    poor, rich = _sides(slave)
    met = (cover[poor] > 0) & (cover[rich] > cover[poor])
    poor, rich = poor[met], rich[met]
    ratio, n = cover[poor] / cover[rich], len(weights)
    lost = np.zeros(n, bool)
    lost[poor[ratio <= NOTHING]] = True
    joined = lost[poor] & ~lost[rich]
    lost[:] = False
    lost[poor[joined]] = True
    used = np.flatnonzero((weights > 0) & ~lost)
    parts = np.where(joined, 1 / np.maximum(np.bincount(poor, joined, n), 1)[poor], 0.0)
    diagonal = np.arange(n)
    own = _matrix(np.where(lost, 0.0, 1.0), parts, diagonal, rich, poor)[used]
    lent = np.where(lost[poor] | lost[rich], 0.0, MAX_LENT * np.maximum(1 - ratio / FULL, 0.0) ** 2)
    lent /= np.maximum(np.bincount(rich, lent, n) / MAX_LENT, 1.0)[rich]
    shares = _matrix(1.0 - np.asarray(np.bincount(rich, lent, n), dtype=float), lent, diagonal, poor, rich)
    return used, own, shares[used][:, used]


def _matrix(on_diagonal: Array, off: Array, diagonal: IntArray, rows: IntArray, columns: IntArray) -> sp.csr_matrix:
    """Square matrix of a diagonal and of other entries."""
    values, n = np.concatenate([on_diagonal, off]), len(diagonal)
    places = np.concatenate([diagonal, rows]), np.concatenate([diagonal, columns])
    out = sp.csr_matrix((values, places), shape=(n, n))
    out.eliminate_zeros()
    return out


def _sides(slave: FacetSurface) -> tuple[IntArray, IntArray]:
    """Pairs of nodes, either way round, at the ends of sides of the parts on which multipliers are linear."""
    facets, k = slave.facets, slave.facets.shape[1]
    if k == 3:
        sides = [facets[:, [[0, 2], [2, 1]]]]
    else:
        quads, around = facets[~slave.triangle], [0, 4, 1, 5, 2, 6, 3, 7] if k > 4 else [0, 1, 2, 3]
        sides = [
            np.stack([of[:, c], of[:, np.roll(c, 1)]], axis=2)
            for of, c in ((quads, around), (facets[slave.triangle], [0, 1, 2]))
        ]
        if k == 9:
            sides.append(quads[:, [[4, 8], [5, 8], [6, 8], [7, 8]]])
    ends = np.concatenate([s.reshape(-1, 2) for s in sides])
    n = len(slave.points)
    pairs = sp.csr_matrix((np.ones(2 * len(ends)), np.concatenate([ends, ends[:, ::-1]]).T), shape=(n, n))
    ties = tied_multipliers(slave)
    if ties is not None:
        pairs = ties.T @ pairs @ ties
    found = sp.coo_matrix(pairs)
    apart = found.row != found.col
    return found.row[apart].astype(np.int64), found.col[apart].astype(np.int64)


def quadrature(slave: FacetSurface) -> tuple[IntArray, Array, Array]:
    """Quadrature over whole facets: facet, coordinates and weights."""
    return slave.cut(None, np.eye(3), np.zeros(3), 0.0) or own_samples(slave.facets)


def multiplier_areas(slave: FacetSurface) -> Array:
    """Integrals (n_nodes,) of all multipliers over the whole slave; tied ones are added to those they follow."""
    areas, ties = slave.once(_multiplier_areas), tied_multipliers(slave)
    return areas if ties is None else np.asarray(ties.T @ areas)


def _multiplier_areas(slave: FacetSurface) -> Array:
    total = np.zeros(len(slave.points))
    facet, local, weight = quadrature(slave)
    for start in range(0, len(facet), AREAS):
        part = slice(start, start + AREAS)
        on, place = facet[part], local[part]
        x, tangents, _ = slave.evaluate(on, place)
        area = weight[part] * np.linalg.norm(cross(tangents[:, :, 0], tangents[:, :, 1]), axis=1) * slave.extent(x)
        np.add.at(
            total, slave.facets[on], multiplier_shapes(slave.facets.shape[1], slave.triangle[on], place) * area[:, None]
        )
    return total


def _projected_on(master: FacetSurface, facet: IntArray, points: Array, normals: Array, share: float) -> Projection:
    """Projection of points (n, 3) with given `normals` on given facets, extended slightly beyond their sides."""
    plane_map = tangent_plane_maps(master)
    lines = share * normals + (1 - share) * plane_map.normal[facet]
    local, _ = plane_map.from_plane(facet, plane_map.along(facet, points, lines))
    local, met = meet(master, facet, local, points, normals, share)
    # where the line of a point misses the extended facet, the closest point on the whole surface is taken
    lost = np.flatnonzero(~met)
    facet, outside = facet.copy(), np.zeros(len(points), bool)
    if len(lost):
        elsewhere = master.project(points[lost])
        assert elsewhere.facet is not None
        assert elsewhere.local is not None
        facet[lost], local[lost], outside[lost] = elsewhere.facet, elsewhere.local, elsewhere.outside
    projection = projection_at(master, facet, local, points, normals, share)
    if len(lost):
        projection.normals[lost], projection.gap[lost] = elsewhere.normals, elsewhere.gap
    return replace(projection, outside=outside)


#: Sample coordinates to find overlapping facets, on quadrilaterals and on triangles.
_PROBES = {
    False: np.stack(np.meshgrid(*[np.array([0.02, 0.5, 0.98])] * 2, indexing="ij"), -1).reshape(-1, 2),
    True: 0.96 * TRIANGLE_NODES + 0.04 / 3,
}


def _probes(surface: FacetSurface, chosen: Mask | None) -> tuple[IntArray, Array]:
    """Sample points over all or chosen facets (n_facets,): their facets (n,) and positions (n, 3)."""
    facets, places = [], []
    for kind, local in _PROBES.items():
        members = np.flatnonzero((surface.triangle == kind) & (True if chosen is None else chosen))
        facets.append(np.repeat(members, len(local)))
        places.append(surface.evaluate(facets[-1], np.tile(local, (len(members), 1)))[0])
    return np.concatenate(facets), np.concatenate(places)


def _neighbours(
    slave: FacetSurface, master: FacetSurface, rotation: Array, translation: Array, near: SearchRegion | None
) -> tuple[IntArray, IntArray]:
    """Pairs of facets that may overlap, from projections of samples of each side on the other, with neighbours."""
    ours, x = _probes(slave, None if near is None else near.facets)
    below = master.facets_near(x @ rotation.T + translation)
    theirs, y = _probes(master, None if near is None else near.opposite)
    above = slave.facets_near((y - translation) @ rotation)
    pairs = np.concatenate([np.stack([ours, below], 1), np.stack([above, theirs], 1)])
    if near is not None:
        pairs = pairs[near.facets[pairs[:, 0]]]
    pairs = np.unique(pairs, axis=0)
    size = len(master.facets)
    near = sp.csr_matrix((np.ones(len(pairs)), pairs.T), shape=(len(slave.facets), size))
    corners = master.facets[:, :4]
    member = sp.csr_matrix((np.ones(corners.size), (np.repeat(np.arange(size), 4), corners.ravel())))
    wide = (near @ (member @ member.T)).tocoo()
    return wide.row.astype(np.int64), wide.col.astype(np.int64)
