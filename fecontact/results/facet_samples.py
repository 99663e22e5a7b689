"""Samples over the facets of a contact: positions, areas, and the functions that interpolate a pressure there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask, cross
from fecontact.contact.coupling.mortar_basis import multiplier_shapes, multipliers_on_square
from fecontact.mesh.facets import TRIANGLE_COLUMNS, shapes_on_square, triangular
from fecontact.mesh.section_mesh import line_shapes

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields


@dataclass(frozen=True, eq=False)
class FacetSamples:
    """Samples at the same n_q coordinates of each of n facets.

    Attributes
    ----------
    points : (n, n_q, 3) array
    areas : (n, n_q) array
        Area of each sample.
    shapes : (n, n_q, k) array
        Functions by which the pressure at the facets' nodes is interpolated.
    local : (n_q, 2 | 1) array
        Coordinates of the samples in each facet.
    """

    points: Array
    areas: Array
    shapes: Array
    local: Array


def facet_samples(
    nodes: Array, facets: IntArray, mortar: bool, extent: Callable[[Array], Array], n: int
) -> FacetSamples:
    """Samples at the centres of n x n equal cells of the facets' coordinates, or of n equal parts of a section's side.

    Parameters
    ----------
    nodes : (m, 3) array
    facets : (n_facets, 3 | 4 | 8 | 9) int array
        As in `mesh.facets`; three columns: sides of a section.
    mortar : bool
        Whether the pressure is that of a mortar coupling.
    extent : function
        Out-of-plane extent (n,) of a section's side at points (n, 3).
    n : int
    """
    t = (np.arange(n) + 0.5) / n
    x = nodes[facets]
    if facets.shape[1] == 3:
        N, dN = line_shapes(t)
        points, local = N @ x, t[:, None]
        areas = np.linalg.norm(dN @ x, axis=2) / n * extent(points.reshape(-1, 3)).reshape(points.shape[:2])
    else:
        local = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
        N, dN = shapes_on_square(facets, local)
        tangents = np.einsum("fqaj,fai->fqij", dN, x, optimize=True)
        points = N @ x
        areas = np.linalg.norm(cross(tangents[..., 0], tangents[..., 1]), axis=-1) / n**2
    return FacetSamples(points, areas, pressure_shapes(facets, local, mortar), local)


def pressure_shapes(facets: IntArray, local: Array, mortar: bool) -> Array:
    """Functions (n_facets, n_q, k) of the pressure at common coordinates of all facets.

    The coordinates are those of the square, (n_q, 2), or of a section's side, (n_q, 1). With nodal coupling they are
    the facets' shape functions, with mortar coupling the multiplier basis.
    """
    if mortar:
        return hats(facets, local, mortar)
    if facets.shape[1] == 3:
        return np.broadcast_to(line_shapes(local[:, 0])[0], (len(facets), len(local), 3))
    return shapes_on_square(facets, local)[0]


def hats(facets: IntArray, local: Array, mortar: bool) -> Array:
    """Functions (n_facets, n_q, k) linear between neighbouring nodes, or the multiplier basis of a mortar coupling.

    The two differ only on triangles with mid-side nodes, where the multipliers are at the corners.
    """
    if facets.shape[1] == 3:
        straight = multiplier_shapes(3, np.zeros(len(local), bool), local)
        return np.broadcast_to(straight, (len(facets), *straight.shape))
    out = multipliers_on_square(facets, local)
    triangle = triangular(facets)
    if not mortar and facets.shape[1] > 4 and triangle.any():
        s, t = local.T
        out[triangle] = _fan(facets.shape[1], np.stack([(1 - s) * (1 - t), s * (1 - t), t], axis=1))
    return out


def _fan(n_columns: int, L: Array) -> Array:
    """Linear functions (n_q, n_columns) on the six triangles round a centroid, at barycentric coordinates (n_q, 3).

    Between the corner with the largest coordinate, the middle of the side towards the second and the centroid they are
    the differences of the coordinates in order of size. Without a node there the centroid has the mean of the middles.
    """
    corners, middles, centroid = np.split(np.array(TRIANGLE_COLUMNS[n_columns]), [3, 6])
    order = np.argsort(-L, axis=1, kind="stable")
    first, second, third = np.take_along_axis(L, order, axis=1).T
    each = np.arange(len(L))
    out = np.zeros((len(L), n_columns))
    out[each, corners[order[:, 0]]] = first - second
    # the middle of the side from corner k to k + 1 is opposite the corner k + 2
    out[each, middles[(order[:, 2] + 1) % 3]] = 2 * (second - third)
    if len(centroid):
        out[:, centroid[0]] = 3 * third
    else:
        out[:, middles] += third[:, None]
    return out


def without(shapes: Array, left_out: Mask) -> Array:
    """Functions (n_facets, n_q, k) of the other nodes, over their sum, for excluded nodes (n_facets, k).

    A pressure is constant towards them, a uniform one is kept, and it is the mean where the others' functions vanish.
    """
    others = (shapes + np.finfo(float).eps) * ~left_out[:, None, :]
    return np.asarray(others / others.sum(axis=2, keepdims=True))


def past_rim(contact: ContactFields, points: Array) -> Mask:
    """Whether points (..., 3) of the slave lie beyond the rim of the master."""
    if not points.size:
        return np.zeros(points.shape[:-1], bool)
    places = contact.master.pose.to_body(points.reshape(-1, 3))
    return contact.master.surface(contact.surfaces[1]).project(places).outside.reshape(points.shape[:-1])


def beside_plane(samples: FacetSamples, point: Array, normal: Array) -> Array:
    """Part (n, n_q) of each sample that lies on the side of a plane to which its unit normal (3,) points.

    As of a square of the sample's area, parallel to the plane.
    """
    across = (samples.points - point) @ normal / np.sqrt(np.maximum(samples.areas, np.finfo(float).tiny))
    return np.clip(across + 0.5, 0.0, 1.0)
