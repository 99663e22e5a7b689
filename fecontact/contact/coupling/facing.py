"""Selection of pairs that face each other: their outward normals are opposed.

A pair acts along one line. If the slave's normal is not opposed to the master's, the two do not face each other and are
not a contact. Every contact that can carry load passes: at an edge or corner of the slave any of its faces may face the
master, and on smooth bodies in contact the normals are opposed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.facets import distinct_columns, facet_nodes
from fecontact.surfaces.facet_surface import FacetSurface, Projection

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


def _corners(surface: FacetSurface) -> _Corners:
    if surface.out_of_plane is not None:
        facet, column = np.divmod(np.arange(surface.facets.size), 3)
        local = np.stack([_ALONG_SIDE[column], np.full(len(column), 0.5)], axis=1)
    else:
        k = surface.facets.shape[1]
        facet, column = np.nonzero(distinct_columns(surface.facets))
        reference = np.stack([facet_nodes(k, False), facet_nodes(k, True)])
        local = reference[surface.triangle[facet].astype(int), column]
    _, tangents, _ = surface.evaluate(facet, local)
    normals = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    node = surface.facets[facet, column]
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
