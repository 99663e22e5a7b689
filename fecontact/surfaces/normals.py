"""Normals of a surface of facets that are continuous over its facets' sides.

The normal of a facet is discontinuous at its sides. A line of action needs a continuous one, so nodal normals, averaged
over the facets round each node, are interpolated like positions. On an edge (`SHARPEST`) the normal is not unique:
facets keep their own there. At the rim half of a node's neighbourhood is missing and the average is inclined, which
matters on planes of symmetry only: there the normal is projected onto the plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.facets import facet_nodes
from fecontact.mesh.surface_mesh import averaged_normals
from fecontact.surfaces.closest_point import FacetPolynomials, facet_polynomials
from fecontact.surfaces.facet_surface import FacetSurface

#: Largest angle (degrees) between the average at a node and the normal of a facet there, so that a polygon of eight
#: sides counts as round and an edge of 50 degrees as an edge.
SHARPEST = 25.0
#: Largest inclination of an average to a plane of symmetry, relative to the change of the normal over the facets there:
#: half of it for flat facets, more where they become narrower; curved ones are inclined by the cube of their size only.
BIAS_FLAT, BIAS_CURVED = 2.0, 0.2
#: Smallest nonzero eigenvalue of the sum of n n^T over planes of symmetry through a node, and difference of cosines;
#: less is rounding.
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Normals:
    """Continuous normals of a surface.

    Attributes
    ----------
    nodal : (n_points, 3) array
        Outward unit vectors at the nodes, zero at other points.
    sharp : (n_points,) bool array
        Nodes on edges.
    field : FacetPolynomials
        Interpolated normals over all facets, only approximately of unit length.
    even : (n_facets,) bool array
        Facets over which they are constant.
    """

    nodal: Array
    sharp: Mask
    field: FacetPolynomials
    even: Mask

    def at(self, facet: IntArray, local: Array) -> Array:
        """Normals (n, 3) at coordinates (n, 2) of facets (n,), by interpolation."""
        return self.field.values(facet, local)


def normals_of(surface: FacetSurface) -> Normals:
    """Continuous normals of a surface, cached; those of a curve are on its ribbon."""
    return surface.spatial.once(_normals)


def opposing(surface: FacetSurface, nodes: IntArray) -> Array:
    """Inward unit normals (n, 3) at nodes (n,); zero on edges."""
    normals = normals_of(surface)
    return np.where(normals.sharp[nodes, None], 0.0, -normals.nodal[nodes])


def _normals(surface: FacetSurface) -> Normals:
    nodal, cosine = averaged_normals(surface.points, surface.facets)
    sharp = cosine < np.cos(np.radians(SHARPEST)) + ROUNDING
    if surface.planes is not None:
        nodal = _within(surface, nodal, *surface.planes)
    if surface.ties is not None:
        # interpolated as they are on the facet whose side is not divided
        nodal = surface.ties.followed(nodal)
    corners = nodal[surface.facets]
    edged = np.flatnonzero(sharp[surface.facets].any(axis=1))
    if len(edged):
        k = surface.facets.shape[1]
        places = np.stack([facet_nodes(k, False), facet_nodes(k, True)])[surface.triangle[edged].astype(int)]
        own = surface.normals(np.repeat(edged, k), places.reshape(-1, 2)).reshape(-1, k, 3)
        corners[edged] = np.where(sharp[surface.facets[edged], None], own, corners[edged])
    index = np.arange(corners.shape[0] * corners.shape[1]).reshape(corners.shape[:2])
    field = facet_polynomials(corners.reshape(-1, 3), index, surface.triangle)
    even = np.ptp(corners, axis=1).max(axis=1) <= 1e-14
    return Normals(nodal, sharp, field, np.asarray(even))


def _within(surface: FacetSurface, nodal: Array, nodes: IntArray, across: Array) -> Array:
    """Nodal normals without components across planes of symmetry that are due to averaging.

    At such a plane the average over half a neighbourhood is inclined by half the change of the normal over a facet,
    much less on curved facets. A larger inclination means that the surface does not meet the plane at a right angle.
    """
    on = np.isin(nodes, surface.nodes)
    nodes, across = nodes[on], across[on]
    around = surface.facets[surface.facets_of_node[np.searchsorted(surface.nodes, nodes)]]
    lean = np.einsum("ni,ni->n", nodal[nodes], across)
    turn = np.abs(np.einsum("nfai,ni->nfa", nodal[around], across) - lean[:, None, None]).max(axis=(1, 2))
    biased = np.abs(lean) <= (BIAS_FLAT if surface.facets.shape[1] == 4 else BIAS_CURVED) * turn
    planes = np.zeros((len(nodal), 3, 3))
    np.add.at(planes, nodes[biased], np.einsum("ni,nj->nij", across[biased], across[biased]))
    held = np.unique(nodes[biased])
    inverse = np.linalg.pinv(planes[held], rcond=ROUNDING, hermitian=True)
    inside = nodal[held] - np.einsum("nij,njk,nk->ni", inverse, planes[held], nodal[held])
    out = nodal.copy()
    out[held] = inside / np.linalg.norm(inside, axis=1, keepdims=True)
    return out
