"""Constraints of multipliers at hanging nodes, for a continuous pressure where one slave facet is adjacent to two.

The displacement of a hanging node follows from others, so an independent multiplier there has no displacement to act
on: such multipliers make peaks 20 % too high where a contact covers divided sides (paraboloids of 20-node hexahedra,
`tests/verification/test_divided_hertz.py`). So the pressure along a divided side is that of the facet with the
undivided edge. It is linear on either half of the edge if there is a multiplier at its middle (`mortar_basis`), which
ties the points halfway between ends and middle by halves; on triangles and four-node facets it is linear over the whole
edge, which ties the middle as well. The functions still sum to one, so uniform pressure stays exact.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.surfaces.facet_surface import FacetSurface


def tied_multipliers(surface: FacetSurface) -> sp.csr_matrix | None:
    """Matrix (n_nodes, n_nodes) from free multipliers to all; columns of tied ones are empty.

    None where no node is tied.
    """
    return surface.once(_tied_multipliers)


def _tied_multipliers(surface: FacetSurface) -> sp.csr_matrix | None:
    ties = surface.ties
    if ties is None:
        return None
    a, middle, b, near_a, near_b = ties.edges.T
    linear = np.full(len(a), surface.facets.shape[1] == 4)
    linear |= (ties.whole >= 0) & surface.triangle[ties.whole // 4]
    halves = np.concatenate(
        [np.stack([near_a, a, middle]), np.stack([near_b, middle, b]), np.stack([middle, a, b])[:, linear]], axis=1
    )
    nodes, *ends = halves[:, np.isin(halves, surface.nodes).all(axis=0)]
    row, half = np.tile(np.arange(len(nodes)), 2), np.full(2 * len(nodes), 0.5)
    weights = sp.csr_matrix((half, (row, np.concatenate(ends))), shape=(len(nodes), len(surface.points)))
    # the middle of an edge may be an end of another one
    tied = HangingNodes.closed(nodes, weights)
    free = sp.csr_matrix((np.ones(len(tied.free)), (np.arange(len(tied.free)), tied.free)), tied.transform.shape[::-1])
    return sp.csr_matrix(tied.transform @ free)
