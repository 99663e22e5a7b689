"""Pairs of contact points: each slave node with its closest point on the master, and a common line of action.

The line lies between both normals, weighted towards that of the stiffer body (`surfaces.normals`). Both bodies
get opposite forces along it, so that forces and moments balance exactly.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from fecontact.bodies.body import Body
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.one_line import one_line
from fecontact.contact.coupling.covered_area import CoveredRim
from fecontact.contact.coupling.surface_pair import NONE_AVERTED, Averted, SurfacePair, unopposed
from fecontact.surfaces.facet_surface import FacetSurface, Projection
from fecontact.surfaces.nodal_weights import components_along, contact_weights, facet_weights
from fecontact.surfaces.surface_ties import SurfaceTies

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


@one_line
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
        Number of slave nodes left out because they lie beyond the master's rim or do not face it.
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
        The nearest pair left out because it does not face.
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

    def nodes_at(self, points: IntArray) -> IntArray:
        """Nodes of some contact points, and hanging nodes that with nodal coupling follow from these alone."""
        if self.spread is None or self.coupling != "nodal":
            return self.nodes[points]
        chosen = np.zeros(len(self.nodes))
        chosen[points] = 1.0
        some = sp.csr_matrix((np.ones(self.spread.nnz), self.spread.indices, self.spread.indptr), self.spread.shape)
        count = np.diff(some.indptr)
        return np.flatnonzero((count > 0) & (some @ chosen == count))

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
        return self.average @ slave.trace(projection, self.slave_normals)

    def master_rows(self, master: Body) -> sp.csr_matrix:
        """Rows (n, n_dofs): opening by the master's displacements, -n at the closest points."""
        if self.sums is not None:
            return self.sums.on_master
        return self.average @ master.trace(self.projection, -self.projection.normals)

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
        return np.asarray(self.average @ np.cross(lever, self.projection.normals))


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
    """Facets of which the centre node, three corners of four, or all corners face the master."""
    paired = np.zeros(len(slave.points), bool)
    paired[nodes] = True
    on = paired[slave.facets]
    corners = on[:, : min(4, on.shape[1])]
    inside = corners.sum(axis=1) >= np.where(slave.triangle, 4, 3)
    if on.shape[1] == 9:
        inside |= on[:, 8]
    return np.flatnonzero(inside)
