"""Areas and rows of the nodes of a surface."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array
from fecontact.common.errors import MeshError
from fecontact.mesh.facets import nodal_areas, tributary_areas
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.section_curve import CurveSurface


def components_along(weights: sp.csr_matrix, directions: Array) -> sp.csr_matrix:
    """Rows for the component along `directions` (n, 3) of points interpolated by `weights` (n, n_nodes)."""
    count, data = np.diff(weights.indptr), np.empty((weights.nnz, 3))
    columns = np.empty(data.shape, weights.indices.dtype)
    for k in range(3):
        np.multiply(weights.data, np.repeat(directions[:, k], count), out=data[:, k])
        np.add(3 * weights.indices, k, out=columns[:, k])
    shape = (weights.shape[0], 3 * weights.shape[1])
    return sp.csr_matrix((data.ravel(), columns.ravel(), 3 * weights.indptr), shape=shape)


def contact_weights(surface: FacetSurface) -> Array:
    """Area (n_nodes,) by which a nodal contact force is divided to give a pressure; zero at hanging nodes.

    Faces of four nodes or with a centre node: the consistent weights, which are positive. Eight-node faces and six-node
    triangles: their consistent corner weights are negative or zero, so tributary areas are used instead; the forces
    themselves remain wrong at the corners. Areas of hanging nodes go to those they follow from. A node alone has its
    share of all faces round it.

    Raises
    ------
    MeshError
        If one is not positive.
    """
    return surface.once(_contact_weights)


def _contact_weights(surface: FacetSurface) -> Array:
    weights, ties = facet_weights(surface), surface.ties
    if ties is None:
        return weights
    weights = ties.gathered(weights, ties.weights)
    free = np.setdiff1d(surface.nodes, ties.nodes)
    if (weights[free] <= 0).any():
        where = np.array2string(surface.points[free[np.argmin(weights[free])]], precision=4)
        raise MeshError(
            f"The node of the contact surface {surface.name!r} at {where} has no positive area: the faces round it are "
            "too different in size. Divide the larger ones too.",
            code="no-area",
        )
    return weights


def facet_weights(surface: FacetSurface) -> Array:
    """Areas (n_nodes,) of all nodes, hanging ones too; see `contact_weights`.

    Raises
    ------
    MeshError
        If one is not positive.
    """
    if isinstance(surface, CurveSurface):
        return surface.nodal_areas
    if surface.facets.shape[1] == 8:
        return tributary_areas(surface.points, surface.facets)
    weights = nodal_areas(surface.points, surface.facets)
    bad = weights[surface.facets].min(axis=1) <= 0
    if bad.any():
        raise MeshError(
            f"Face {np.argmax(bad)} of the contact surface {surface.name!r} is so distorted that a nodal weight is not "
            "positive; a contact force there would not be a pressure. Make its sides and angles more equal.",
            code="no-area",
        )
    return weights
