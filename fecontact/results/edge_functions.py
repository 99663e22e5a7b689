"""Functions of an edge pressure on the facets of a contact, and the forces of their pressures.

The pressure is sqrt(phi) c (`results.edge_pressure`). Near the outline c is bilinear in the corners of facets, and
forces are integrals against the nodes' functions: with as many coefficients as nodes the problem would be unstable.
Inside, where c varies and sqrt(phi) is smooth, c has the shape functions of the facets, and the force of a node is its
coefficient times the integral of sqrt(phi) N, as that of a nodal pressure is. Hanging nodes follow from the others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.results.contact_fields import ContactFields
from fecontact.results.edge_quadrature import edge_points
from fecontact.results.outline import Outline

#: Least share of a corner's area inside the outline for a coefficient of its own; others follow from neighbours.
OWN_SHARE = 0.3
#: Layers of facets beside those that the outline cuts on which the coefficient is bilinear.
EDGE_LAYERS = 2
#: Deviation from bilinear, relative to the coefficients of a facet, up to which it is bilinear inside as well.
NEARLY_BILINEAR = 0.005


@dataclass(frozen=True, eq=False)
class RegionFunctions:
    """Functions of one region and their forces.

    Attributes
    ----------
    facets : (k,) int array
        Facets of the contact that the region covers at least partly.
    bilinear : (k,) bool array
        Whether the coefficient is bilinear there.
    area : float
        Inside the outline.
    extension : (n_nodes, j) csr_matrix
        Coefficients at the contact's nodes from those of the functions.
    forces : (n_nodes, j) array
        Nodal forces of the functions.
    at_points : (m, n_nodes) csr_matrix
        From the coefficients at nodes to those at m quadrature points.
    onto : (n_nodes, m) csr_matrix
        Nodal forces of a pressure at the quadrature points.
    terms : (m, n_terms) array
        h / (2 sqrt(phi)) at the quadrature points.
    own : (j,) int array
        Nodes of the functions.
    """

    facets: IntArray
    bilinear: Mask
    area: float
    extension: sp.csr_matrix
    forces: Array
    at_points: sp.csr_matrix
    onto: sp.csr_matrix
    terms: Array
    own: IntArray

    def by_outline(self, coefficients: Array) -> Array:
        """Nodal forces (n_nodes, n_terms) of the change of pressure, -c h / (2 sqrt(phi)), as the outline moves."""
        return np.asarray(-(self.onto @ ((self.at_points @ coefficients)[:, None] * self.terms)))


def region_functions(
    contact: ContactFields, outline: Outline, near: IntArray, corner_areas: Array, smooth: Mask | None = None
) -> RegionFunctions:
    """Functions of a region on its outline.

    Parameters
    ----------
    contact : ContactFields
    outline : Outline
    near : (k,) int array
        Facets of the contact on which the region may lie.
    corner_areas : (n_nodes,) array
        Integrals of the corners' bilinear functions over all facets of the contact.
    smooth : (n_facets,) bool array, optional
        Facets inside on which the coefficient is known to be nearly bilinear.
    """
    n = len(contact.nodes)
    chosen = near[(outline.level(contact.nodes[contact.facets[near]]) > 0).any(axis=1)]
    facets = contact.facets[chosen]
    corners = facets[:, :4]
    found = edge_points(contact.nodes, facets, outline.level)
    root = np.sqrt(np.maximum(outline.level(found.points), 0.0)).ravel()
    weight = found.areas.ravel()
    bilinear = _edge_zone(corners, np.asarray((outline.level(contact.nodes[facets]) <= 0).any(axis=1)), n)
    # plain faces of eight nodes have corners without a positive weight
    bilinear |= facets.shape[1] == 8
    if smooth is not None:
        bilinear |= smooth[chosen]
    flat = np.repeat(bilinear, found.areas.shape[1]).astype(float)
    by_corners, by_nodes = _matrix(found.corners, corners, n), _matrix(found.shapes, facets, n)
    near_edge = sp.csr_matrix(sp.diags(flat) @ by_corners)
    onto = sp.csr_matrix(by_nodes.T @ sp.diags(weight))
    inside = np.asarray(onto @ ((1 - flat) * root))
    follow = _hanging(contact)
    free = np.diff(follow.indptr) == 0
    own = _own(facets, bilinear, np.asarray(by_corners.T @ weight), corner_areas) & free
    extension = _extension(facets, bilinear, own, free)
    extension = sp.csr_matrix(extension + follow @ extension)
    forces = (onto @ sp.diags(root) @ near_edge + sp.diags(inside)) @ extension
    least = np.sqrt(np.finfo(float).eps)
    terms = outline.terms(found.points).reshape(len(weight), -1) / (2 * np.maximum(root, least))[:, None]
    at_points = sp.csr_matrix(near_edge + sp.diags(1 - flat) @ by_nodes)
    return RegionFunctions(
        chosen, bilinear, float(weight.sum()), extension, forces.toarray(), at_points, onto, terms, np.flatnonzero(own)
    )


def nearly_bilinear(contact: ContactFields, found: RegionFunctions, coefficients: Array) -> Mask:
    """Facets (n_facets,) of the contact on which coefficients (n_nodes,) are nearly those of their corners."""
    out = np.zeros(len(contact.facets), bool)
    facets = contact.facets[found.facets]
    at = coefficients[facets]
    between = (at[:, :4] + np.roll(at[:, :4], -1, axis=1)) / 2
    middles = at[:, 4:8] if facets.shape[1] > 4 else between
    scale = np.abs(at[:, :4]).max(axis=1)
    out[found.facets] = np.abs(middles - between).max(axis=1) <= NEARLY_BILINEAR * scale
    return out


def _matrix(values: Array, columns: IntArray, n: int) -> sp.csr_matrix:
    """Matrix (k n_q, n) of values (k, n_q, c) at points of k facets with columns (k, c)."""
    k, q, c = values.shape
    cells = np.broadcast_to(columns[:, None, :], values.shape)
    return sp.csr_matrix((values.ravel(), (np.repeat(np.arange(k * q), c), cells.ravel())), shape=(k * q, n))


def _edge_zone(corners: IntArray, cut: Mask, n: int) -> Mask:
    """Facets (k,) that the outline cuts, and layers of facets beside them."""
    reached = np.zeros(n, bool)
    reached[corners[cut]] = True
    for _ in range(EDGE_LAYERS - 1):
        reached[corners[np.flatnonzero(reached[corners].any(axis=1))]] = True
    return np.asarray(reached[corners].any(axis=1))


def _hanging(contact: ContactFields) -> sp.csr_matrix:
    """Weights (n_nodes, n_nodes) by which hanging nodes follow from others; empty rows for all other nodes."""
    at_nodes = contact.at_nodes
    single = np.diff(at_nodes.indptr) == 1
    node_of_point = sp.csr_matrix(sp.diags(single.astype(float)) @ at_nodes).T
    return sp.csr_matrix(sp.diags((~single).astype(float)) @ at_nodes @ node_of_point)


def _own(facets: IntArray, bilinear: Mask, share: Array, whole: Array) -> Mask:
    """Nodes (n,) with a coefficient of their own."""
    corner, zone, inner = (np.zeros(len(whole), bool) for _ in range(3))
    corner[facets[:, :4]] = True
    zone[facets[bilinear]] = True
    inner[facets[~bilinear]] = True
    return (corner & (share > OWN_SHARE * whole)) | (inner & ~zone)


def _extension(facets: IntArray, bilinear: Mask, own: Mask, free: Mask) -> sp.csr_matrix:
    """Coefficients (n, j) at all nodes from those of their own, see `RegionFunctions`.

    Corners that are hardly inside have the mean of their neighbours; middles of sides between a bilinear facet and
    another the mean of the ends.
    """
    n, corners = len(own), facets[:, :4]
    columns = np.flatnonzero(own)
    known = sp.csr_matrix((np.ones(len(columns)), (columns, np.arange(len(columns)))), shape=(n, len(columns)))
    corner = np.zeros(n, bool)
    corner[corners] = True
    member = sp.csr_matrix((np.ones(corners.size), (corners.ravel(), np.repeat(np.arange(len(facets)), 4))))
    member.resize(n, len(facets))
    beside = sp.csr_matrix(member @ member.T)
    corner &= free
    left = corner & ~own
    while left.any():
        means = sp.csr_matrix(beside @ sp.diags((corner & ~left).astype(float)))
        total = np.asarray(means.sum(axis=1)).ravel()
        ready = left & (total > 0)
        if not ready.any():
            break
        scale = np.divide(1.0, total, out=np.zeros(n), where=ready)
        known = sp.csr_matrix(known + sp.diags(scale) @ means @ known)
        left &= ~ready
    zone = facets[bilinear]
    if zone.shape[1] > 4:
        middles, first = np.unique(zone[:, 4:8], return_index=True)
        ends = np.stack([zone[:, :4], np.roll(zone[:, :4], -1, axis=1)], axis=2).reshape(-1, 2)[first]
        between = free[middles] & ~own[middles] & ~corner[middles]
        middles, ends = middles[between], ends[between]
        halves = sp.csr_matrix((np.full(ends.size, 0.5), (np.repeat(middles, 2), ends.ravel())), shape=(n, n))
        known = sp.csr_matrix(known + halves @ known)
    return known
