"""Hanging nodes of a surface of facets: their weights, and sides of one facet adjacent to two.

Contact forces act at nodes that do not hang. The areas of hanging nodes are added to the nodes they follow from, by the
weights of the ties: the integral of the functions of the free nodes, so that a uniform pressure stays exact. Pressures
at hanging nodes are interpolated like displacements (`mesh.hanging_nodes`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.facets import edge_keys, found, sides_of
from fecontact.mesh.hanging_nodes import HangingNodes


@dataclass(frozen=True, eq=False)
class SurfaceTies:
    """The hanging nodes of a surface.

    Attributes
    ----------
    nodes : (n,) int array
        Hanging nodes on the surface.
    weights : (n, n_points) csr_matrix
        u[nodes] = weights @ u.
    edges : (m, 5) int array
        Divided edges on the surface, as in `HangingNodes`.
    whole : (m,) int array
        Side of the facet with the undivided edge, as 4 facet + side; -1 if it is not a facet of the surface.
    halves : (m, 2) int array
        Sides of facets along the two halves, likewise.
    """

    nodes: IntArray
    weights: sp.csr_matrix
    edges: IntArray
    whole: IntArray
    halves: IntArray

    @cached_property
    def inner_sides(self) -> IntArray:
        """Sides with a facet of the surface on either side, one of them or two."""
        met = (self.whole >= 0) & (self.halves >= 0).any(axis=1)
        sides = np.concatenate([self.whole[met], self.halves[met].ravel()])
        return sides[sides >= 0]

    @cached_property
    def beside(self) -> tuple[IntArray, IntArray]:
        """Points of divided edges (k,) without their ends, and the facet (k,) with the undivided edge."""
        met = np.flatnonzero(self.whole >= 0)
        nodes, facet = self.edges[met][:, [1, 3, 4]].ravel(), np.repeat(self.whole[met] // 4, 3)
        return nodes[nodes >= 0], facet[nodes >= 0]

    def with_tied(self, nodes: Mask) -> Mask:
        """Nodes (n_points,), those along divided edges that they are tied to, and all that are tied to these."""
        ends, between = self.edges[:, [0, 2]], self.edges[:, [1, 3, 4]]
        between = np.where(between < 0, self.edges[:, 1:2], between)
        out = nodes.copy()
        out[ends[nodes[between].any(axis=1)]] = True
        while True:
            before = out.copy()
            out[between[(out[ends].any(axis=1)) | out[self.edges[:, 1]]]] = True
            if np.array_equal(before, out):
                return out

    def onto(self, lost: Mask) -> sp.csr_matrix:
        """Weights (n, n_points) of the nodes in terms of those that are not lost (n_points,).

        A row with lost nodes keeps its positive weights on the others, scaled to sum one.
        """
        kept = sp.csr_matrix(self.weights @ sp.diags((~lost).astype(float)))
        cut = abs(self.weights) @ lost.astype(float) > 0
        positive = sp.diags(cut.astype(float)) @ kept.maximum(0.0)
        total = np.asarray(positive.sum(axis=1)).ravel()
        scale = np.divide(1.0, total, out=np.zeros_like(total), where=total > 0)
        out = sp.csr_matrix(sp.diags((~cut).astype(float)) @ kept + sp.diags(scale) @ positive)
        out.eliminate_zeros()
        return out

    def followed(self, values: Array) -> Array:
        """Values (n_points, k) with those at hanging nodes interpolated from the others."""
        out = values.copy()
        out[self.nodes] = self.weights @ values
        return out

    def gathered(self, areas: Array, onto: sp.csr_matrix) -> Array:
        """Areas (n_points,) with those of hanging nodes added to others, by weights (n, n_points)."""
        out = areas.copy()
        out[self.nodes] = 0.0
        return np.asarray(out + onto.T @ areas[self.nodes])

    def at_nodes(self, nodes: IntArray, onto: sp.csr_matrix) -> sp.csr_matrix:
        """Values (n_points, k) at all nodes from those at some (k,), interpolated at hanging ones."""
        n, k = onto.shape[1], len(nodes)
        insert = sp.csr_matrix((np.ones(len(self.nodes)), (self.nodes, np.arange(len(self.nodes)))), (n, onto.shape[0]))
        own = sp.csr_matrix((np.ones(k), (nodes, np.arange(k))), shape=(n, k))
        out = sp.csr_matrix(own + insert @ onto[:, nodes])
        out.eliminate_zeros()
        return out


def surface_ties(facets: IntArray, hanging: HangingNodes | None) -> SurfaceTies | None:
    """Ties of the hanging nodes on a surface of facets (n_facets, 4 | 8 | 9); None where there are none."""
    if hanging is None:
        return None
    on = np.zeros(hanging.n_points, bool)
    on[facets] = True
    rows = np.flatnonzero(on[hanging.nodes])
    if len(rows) == 0:
        return None
    sides = edge_keys(sides_of(facets).reshape(-1, 2))
    along = found(edge_keys(hanging.edges[:, [[0, 2], [0, 1], [1, 2]]]), sides)
    there = (along >= 0).any(axis=1)
    along = along[there]
    return SurfaceTies(hanging.nodes[rows], hanging.weights[rows], hanging.edges[there], along[:, 0], along[:, 1:])
