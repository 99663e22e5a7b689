"""Segments of two surfaces, in which one slave facet meets one master facet, and quadrature on them.

Segments are found in the plane of the slave facet (`contact.coupling.tangent_plane`): the master facet's outline is
mapped there and clipped to the convex outlines of the sub-faces on which the slave's multipliers are smooth (Sutherland
& Hodgman 1974), so that segments tile the common area of both surfaces. They are divided into triangles, each with a
rule whose degree follows the taper of both facets over it.
"""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.contact.coupling.mortar_basis import TRIANGLE_ORDER, fans, sub_faces, triangle_samples
from fecontact.contact.coupling.tangent_plane import FOLD, TangentPlaneMap, degrees, tangent_plane_maps
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.line_of_action import FACING, SLACK, meet
from fecontact.surfaces.normals import normals_of

#: Difference of unit normals that counts as rounding.
PARALLEL = 1e-14
#: Distance from a side, in a facet's coordinates, at which a vertex of another facet counts as on it: rounding and the
#: steps of Newton's method. Sides along which two facets meet are then not cut anywhere.
ON_LINE = 1e-10


def segment_samples(
    slave: FacetSurface, master: FacetSurface, f: IntArray, m: IntArray, share: float
) -> tuple[IntArray, Array, Array, IntArray]:
    """Quadrature over the segments of pairs of facets.

    Parameters
    ----------
    slave, master : FacetSurface
        Both surfaces in the same axes.
    f, m : (n_pairs,) int arrays
        Facets of the slave and of the master.
    share : float
        Weight of the slave's normal in the lines of action.

    Returns
    -------
    facet : (n,) int array
        Slave facets of the samples.
    local : (n, 2) array
        Their coordinates there.
    weight : (n,) array
        Weights in those coordinates.
    on_master : (n,) int array
        Master facets of the samples.
    """
    plane_map, below = tangent_plane_maps(slave), tangent_plane_maps(master)
    outline = _outlines(slave, master, f, m, plane_map, share)
    pairs, corners, doubles = [], [], []
    for kind in (False, True):
        members = np.flatnonzero(slave.triangle[f] == kind)
        if len(members):
            windows = sub_faces(slave.facets.shape[1], kind)
            pair = np.repeat(members, len(windows))
            window = plane_map.to_plane(f[pair], np.tile(windows, (len(members), 1, 1)))
            kept = _near(outline[members], window.reshape(len(members), len(windows), -1, 2))
            pair = pair[kept]
            polygon, count = clip(outline[pair], window[kept])
            triangle, double, piece = fans(polygon, count)
            pairs.append(pair[piece])
            corners.append(triangle)
            doubles.append(double)
    pair, triangle, double = np.concatenate(pairs), np.concatenate(corners), np.concatenate(doubles)
    degree = _degrees(slave, master, plane_map, f[pair], below, m[pair], triangle)
    parts = []
    for order in np.unique(degree):
        of = np.flatnonzero(degree == order)
        local, weight, own = triangle_samples(triangle[of], double[of], int(order))
        sampled = pair[of][own]
        local, jacobian = plane_map.from_plane(f[sampled], local)
        parts.append((f[sampled], local, weight / jacobian, m[sampled]))
    if not parts:
        return np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros(0), np.zeros(0, np.int64)
    facet, local, weight, on_master = (np.concatenate(p) for p in zip(*parts, strict=True))
    return facet, local, weight, on_master


def _near(outline: Array, windows: Array) -> IntArray:
    """Windows (n, n_windows, k, 2), numbered through, whose bounding boxes meet those of their outlines (n, m, 2)."""
    low, high = outline.min(axis=1)[:, None], outline.max(axis=1)[:, None]
    met = (low <= windows.max(axis=2)) & (high >= windows.min(axis=2))
    return np.flatnonzero(met.all(axis=2))


def _degrees(
    slave: FacetSurface,
    master: FacetSurface,
    plane_map: TangentPlaneMap,
    f: IntArray,
    below: TangentPlaneMap,
    m: IntArray,
    triangle: Array,
) -> IntArray:
    """Degrees of quadrature (n,) for both sides on triangles (n, 3, 2) in the planes of slave facets f (n,)."""
    departure = np.maximum(plane_map.departure[f], below.departure[m])
    degree = degrees(plane_map, f, triangle, departure)
    degree[slave.triangle[f] & master.triangle[m]] = TRIANGLE_ORDER
    bent = np.flatnonzero(below.taper[m] > 0)
    if len(bent):
        local, _ = plane_map.from_plane(np.repeat(f[bent], 3), triangle[bent].reshape(-1, 2))
        x, _, _ = slave.evaluate(np.repeat(f[bent], 3), local)
        seen = below.projected(np.repeat(m[bent], 3), x).reshape(-1, 3, 2)
        degree[bent] = np.maximum(degree[bent], degrees(below, m[bent], seen, departure[bent]))
    return degree


def _outlines(
    slave: FacetSurface, master: FacetSurface, f: IntArray, m: IntArray, plane_map: TangentPlaneMap, share: float
) -> Array:
    """Outlines (n_pairs, 4 | 8, 2) of master facets in the planes of slave facets, counter-clockwise or not.

    A triangle's outline repeats its last corner, for its sides of zero length.

    Every vertex has one image in the plane of a slave facet, so neighbouring master facets keep their common sides and
    tile the slave facet. The image is the intersection of the vertex's line of action (`surfaces.line_of_action`) with
    the slave facet; where there is none within the extended facet before its fold, the intersection with the tangent
    plane at its centre. For parallel flat facets both are the projection.
    """
    corners = master.facets[m][:, :4]
    ring = corners
    if master.facets.shape[1] > 4:
        ring = np.stack([corners, master.facets[m][:, 4:8]], axis=2).reshape(len(m), 8)
    # a vertex is shared by the master's facets around it
    key, place = np.unique(f[:, None] * len(master.points) + ring, return_inverse=True)
    facet, node = np.divmod(key, len(master.points))
    return _images(slave, master, facet, node, plane_map, share)[place.reshape(ring.shape)]


def _images(
    slave: FacetSurface, master: FacetSurface, facet: IntArray, node: IntArray, plane_map: TangentPlaneMap, share: float
) -> Array:
    """Images (n, 2) of nodes (n,) of the master in the planes of slave facets (n,), see `_outlines`."""
    vertices = master.points[node]
    own, theirs = normals_of(slave), normals_of(master).nodal[node]
    normal = slave.normals(np.arange(len(slave.facets)), plane_map.middle)[facet]
    parallel = plane_map.flat[facet] & own.even[facet] & (np.abs(normal + theirs).max(axis=1) <= PARALLEL)
    lines = share * normal - (1 - share) * theirs
    cosine = np.einsum("ni,ni->n", lines, normal)
    height = np.einsum("ni,ni->n", vertices - plane_map.origin[facet], normal)
    seen = ~parallel & (cosine > FACING)
    vertices_seen = vertices - np.divide(height, cosine, out=np.zeros_like(height), where=seen)[:, None] * lines
    plane = plane_map.projected(facet, vertices_seen)
    rows = np.flatnonzero(~parallel & ((plane > -SLACK) & (plane < 1 + SLACK)).all(axis=1))
    start, _ = plane_map.from_plane(facet[rows], plane[rows])
    local, met = meet(slave, facet[rows], start, vertices[rows], -theirs[rows], 1 - share, 2 * SLACK)
    met &= plane_map.jacobian(facet[rows], local) > FOLD
    rows, local = rows[met], local[met]
    plane[rows] = plane_map.to_plane(facet[rows], local)
    return plane


def clip(polygons: Array, windows: Array) -> tuple[Array, IntArray]:
    """Clip polygons to convex windows, in batch (Sutherland & Hodgman 1974).

    Parameters
    ----------
    polygons : (n, m, 2) array
    windows : (n, k, 2) array
        Convex outlines, counter-clockwise.

    Returns
    -------
    clipped : (n, most, 2) array
        Vertices, of which the first `count` of each row are valid.
    count : (n,) int array

    Examples
    --------
    >>> import numpy as np
    >>> square = np.array([[[0.5, 0.5], [2.0, 0.5], [2.0, 2.0], [0.5, 2.0]]])
    >>> clipped, count = clip(square, np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]]))
    >>> sorted(map(tuple, clipped[0, : count[0]].tolist()))
    [(0.5, 0.5), (0.5, 1.0), (1.0, 0.5), (1.0, 1.0)]
    """
    count = np.full(len(polygons), polygons.shape[1])
    for side in range(windows.shape[1]):
        start = windows[:, side]
        along = windows[:, (side + 1) % windows.shape[1]] - start
        polygons, count = _clip_side(polygons, count, start, along)
    return polygons, count


def _clip_side(polygons: Array, count: IntArray, start: Array, along: Array) -> tuple[Array, IntArray]:
    """Parts of polygons to the left of lines through `start` (n, 2) along `along` (n, 2)."""
    n, m, _ = polygons.shape
    column = np.arange(m)[None, :]
    valid = column < count[:, None]
    following = np.where(column + 1 < count[:, None], column + 1, 0)
    after = np.take_along_axis(polygons, following[:, :, None].repeat(2, axis=2), axis=1)
    offset = polygons - start[:, None]
    height = along[:, None, 0] * offset[..., 1] - along[:, None, 1] * offset[..., 0]
    height_after = np.take_along_axis(height, following, axis=1)
    left = height >= -ON_LINE
    crossing = valid & (left != (height_after >= -ON_LINE))
    share = np.clip(np.divide(height, height - height_after, out=np.zeros_like(height), where=crossing), 0.0, 1.0)
    cut = polygons + share[:, :, None] * (after - polygons)
    points = np.stack([polygons, cut], axis=2).reshape(n, 2 * m, 2)
    kept = np.stack([valid & left, crossing], axis=2).reshape(n, 2 * m)
    order = np.argsort(~kept, axis=1, kind="stable")
    count = kept.sum(axis=1)
    order = order[:, : max(int(count.max(initial=0)), 1)]
    return np.take_along_axis(points, order[:, :, None].repeat(2, axis=2), axis=1), count
