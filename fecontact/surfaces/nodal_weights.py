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
    count = np.diff(weights.indptr)
    d = np.repeat(directions, count, axis=0)
    data = (weights.data[:, None] * d).ravel()
    columns = (3 * weights.indices[:, None] + np.arange(3)).ravel()
    return sp.csr_matrix((data, columns, 3 * weights.indptr), shape=(weights.shape[0], 3 * weights.shape[1]))


def contact_weights(surface: FacetSurface) -> Array:
    """Area (n_nodes,) by which a nodal contact force is divided to give a pressure.

    Faces of four nodes or with a centre node: the consistent weights, which are positive. Eight-node faces and six-node
    triangles: their consistent corner weights are negative or zero, so tributary areas are used instead; the forces
    themselves remain wrong at the corners.
    """
    return surface.once(_contact_weights)


def _contact_weights(surface: FacetSurface) -> Array:
    if isinstance(surface, CurveSurface):
        return surface.nodal_areas
    if surface.facets.shape[1] == 8:
        return tributary_areas(surface.points, surface.facets)
    weights = nodal_areas(surface.points, surface.facets)
    bad = weights[surface.facets].min(axis=1) <= 0
    if bad.any():
        raise MeshError(
            f"Face {np.argmax(bad)} of the contact surface {surface.name!r} is so distorted that a nodal weight is not "
            "positive; a contact force there would not be a pressure. Make its sides and angles more equal."
        )
    return weights
