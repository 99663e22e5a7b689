"""Weighted sums over the samples of a mortar coupling, block by block to limit memory.

All results are linear in the weights of the samples: gaps, rows on the nodes of both bodies, lines of action and their
moments. Each block is summed per multiplier, and the sums of all blocks are added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.contact.coupling.nodal import MortarIntegrals
from fecontact.surfaces.facet_surface import Projection
from fecontact.surfaces.nodal_weights import components_along


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
        np.cross(x - origin, normals),
        np.cross(lever, projection.normals),
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
