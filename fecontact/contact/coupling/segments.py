"""Segments of two surfaces, in which one slave facet meets one master facet, and quadrature on them.

Segments are found in the plane of the slave facet: the master facet's outline is
mapped there and clipped to the convex outlines of the sub-faces on which the slave's multipliers are smooth (Sutherland
& Hodgman 1974), so that segments tile the common area of both surfaces. They are cut into quadrilaterals and
triangles (`mortar_basis.cut`), each with a rule whose degree follows the taper of both facets over it.

Maps of quadrilateral facets to a plane in which straight sides are straight.

Segments of two facets are polygons in a plane but not in a facet's coordinates, in which a straight line across a kite
is curved. The coordinates are mapped to a plane by the bilinear map through the four corners' images on the tangent
plane at the facet's centre; the inverse is in closed form (P. S. Heckbert, Fundamentals of texture mapping and image
warping, 1989, ch. 2). For a flat facet with straight sides this is the facet's own map. On a parallelogram or triangle
it is the identity; on a curved facet it is one to one, so that segments that tile the plane's image tile the facet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.contact.coupling.mortar_basis import ORDER, TRIANGLE_ORDER, cut, piece_samples, sub_faces
from fecontact.mesh.facets import facet_centres, facet_nodes, facet_shapes, unit_vectors
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.normals import FACING, SLACK, meet, normals_of

#: Available degrees of quadrature; the last is the rule of 19 on quarters of triangles, equivalent to 30 near the fold.
DEGREES = (ORDER, 8, 10, 12, 14, 17, 19, 30)
#: Bounds of the error of these rules over tau^n, from 6000 random triangles in 300 random convex quadrilaterals with
#: tau above 0.02.
LEADS = (10.0, 30.0, 7.0, 7.0, 0.6, 0.6, 0.01, 0.003)
#: Relative error of integrals over flat facets by which degrees are chosen.
EXACT = 1e-13
#: Change of a facet's Jacobian from centre to corners, relative to that at the centre, below which it is affine.
AFFINE = 1e-12
#: Deviation of a facet from a flat one with straight sides that counts as rounding.
FLAT = 1e-13
#: Least Jacobian of a map relative to that at the centre: below it the map is near its fold.
FOLD = 0.05


@dataclass(frozen=True, eq=False)
class TangentPlaneMap:
    """Bilinear maps of all facets: x = centre + along_s S + along_t T + twist S T with S = s - 1/2, T = t - 1/2.

    Attributes
    ----------
    middle : (n_facets, 2) array
        Coordinates of the facet's centre in the facet and in the plane.
    origin, normal : (n_facets, 3) arrays
        The facet's centre, and its unit normal there.
    inverse : (n_facets, 2, 3) array
        Matrices from directions to the plane's coordinates.
    centre, along_s, along_t, twist : (n_facets, 2) arrays
    taper : (n_facets,) array
        Largest change of the Jacobian from centre to a corner, relative to that at the centre; zero where affine.
    departure : (n_facets,) array
        Largest distance of a node from the flat facet with straight sides, relative to the facet's size.
    flat : (n_facets,) bool array
        Mask of facets whose own map this is, to rounding.
    """

    middle: Array
    origin: Array
    normal: Array
    inverse: Array
    centre: Array
    along_s: Array
    along_t: Array
    twist: Array
    taper: Array
    departure: Array
    flat: Mask

    def projected(self, facet: IntArray, points: Array) -> Array:
        """Images (n, 2) of points (n, 3) on the tangent planes at the centres of facets (n,)."""
        return self.middle[facet] + np.einsum("nij,nj->ni", self.inverse[facet], points - self.origin[facet])

    def along(self, facet: IntArray, points: Array, lines: Array) -> Array:
        """The same of points moved along `lines` (n, 3) onto the planes, but where these hardly meet them."""
        normal = self.normal[facet]
        cosine = np.einsum("ni,ni->n", lines, normal)
        height = np.einsum("ni,ni->n", points - self.origin[facet], normal)
        way = np.divide(height, cosine, out=np.zeros_like(height), where=cosine > FACING)
        return self.projected(facet, points - way[:, None] * lines)

    def to_plane(self, facet: IntArray, local: Array) -> Array:
        """Images (n, ..., 2) of points (n, ..., 2) of facets (n,), given in their coordinates."""
        out = local.copy()
        bent = np.flatnonzero(self.taper[facet] > 0)
        if len(bent):
            c, a, b, d = self._maps(facet[bent], local.ndim)
            S, T = np.moveaxis(local[bent] - 0.5, -1, 0)[..., None]
            out[bent] = c + a * S + b * T + d * (S * T)
        return out

    def from_plane(self, facet: IntArray, points: Array) -> tuple[Array, Array]:
        """Coordinates (n, 2) of points (n, 2) of the plane inside facets (n,), and the Jacobian (n,) there."""
        local, jacobian = points.copy(), np.ones(len(points))
        bent = np.flatnonzero(self.taper[facet] > 0)
        if len(bent):
            c, a, b, d = self._maps(facet[bent], 2)
            r = points[bent] - c
            whole, twisted = cross(a, b), cross(r, d)
            # each coordinate is the root of a quadratic equation that tends to the affine one; one discriminant
            p, q = whole - twisted, whole + twisted
            s, t = cross(r, b), cross(a, r)
            root = np.sqrt(np.maximum(p**2 + 4 * cross(a, d) * s, 0.0))
            # beyond the fold the sum may be zero: such points are far outside the facet
            least = np.finfo(float).eps * np.abs(whole)
            local[bent] = 0.5 + 2 * np.stack([s / np.maximum(p + root, least), t / np.maximum(q + root, least)], axis=1)
            jacobian[bent] = root
        return local, jacobian

    def jacobian(self, facet: IntArray, local: Array) -> Array:
        """Jacobian (n,) relative to that at the centre."""
        _, a, b, d = self._maps(facet, 2)
        S, T = (local - 0.5).T
        return 1.0 + (S * cross(a, d) + T * cross(d, b)) / cross(a, b)

    def _maps(self, facet: IntArray, ndim: int) -> tuple[Array, ...]:
        shape = (len(facet), *(1,) * (ndim - 2), 2)
        return tuple(v[facet].reshape(shape) for v in (self.centre, self.along_s, self.along_t, self.twist))


def cross(u: Array, v: Array) -> Array:
    """Cross products of vectors (..., 2) of the plane."""
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


def tangent_plane_maps(surface: FacetSurface) -> TangentPlaneMap:
    """Maps of all facets, cached; the identity where a facet is affine or has no convex image."""
    return surface.once(_tangent_plane_maps)


def _tangent_plane_maps(surface: FacetSurface) -> TangentPlaneMap:
    everyone = np.arange(len(surface.facets))
    middle = facet_centres(surface.triangle)
    x, tangents, _ = surface.evaluate(everyone, middle)
    inverse = np.linalg.pinv(tangents)
    offsets = surface.points[surface.facets[:, :4]] - x[:, None]
    image = middle[:, None] + np.einsum("nij,nkj->nki", inverse, offsets)
    k0, k1, k2, k3 = image.swapaxes(0, 1)
    a, b, d = (k1 + k2 - k0 - k3) / 2, (k2 + k3 - k0 - k1) / 2, k0 - k1 + k2 - k3
    whole, most = cross(a, b), np.abs(cross(a, d)) + np.abs(cross(d, b))
    change = np.divide(most, 2 * whole, out=np.full_like(most, np.inf), where=whole != 0)
    bilinear = ~surface.triangle & (change > AFFINE) & (change < 1 - FOLD)
    taper: Array = np.where(bilinear, change, 0.0)
    departure = _departure(surface, tangents)
    plane = np.asarray(inverse, dtype=np.float64)
    flat = (departure <= FLAT) & (surface.triangle | (change < 1 - FOLD))
    normal = unit_vectors(np.cross(tangents[:, :, 0], tangents[:, :, 1]))
    return TangentPlaneMap(middle, x, normal, plane, image.mean(axis=1), a, b, d, taper, departure, flat)


def _departure(surface: FacetSurface, tangents: Array) -> Array:
    """Distance (n_facets,) of nodes from flat facets with straight sides through the corners, over their size."""
    k = surface.facets.shape[1]
    straight = np.stack([facet_shapes(4, np.full(k, kind), facet_nodes(k, kind))[0] for kind in (False, True)])
    nodes = surface.points[surface.facets]
    off = np.abs(nodes - straight[surface.triangle.astype(int)] @ nodes[:, :4]).max(axis=(1, 2))
    normal = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    warp = np.ptp(np.einsum("nki,ni->nk", nodes[:, :4] - nodes[:, :1], normal), axis=1)
    return np.asarray(np.maximum(off, warp) / surface.mean_facet_size)


def degrees(plane_map: TangentPlaneMap, facet: IntArray, pieces: Array, departure: Array) -> IntArray:
    """Degrees of quadrature (n,) for pieces with corners (n, k, 2) in the planes of facets (n,).

    The error of a rule of degree n is `LEADS` tau^n times the area (`_nearness`). It is kept below `EXACT`
    times the facet's area on flat facets, and below the `departure` (n,) from flatness, which is an error anyway, on
    others.
    """
    degree = np.full(len(facet), ORDER)
    bent = np.flatnonzero(plane_map.taper[facet] > 0)
    if len(bent):
        corners = pieces[bent]
        arms = corners - corners[:, :1]
        share = np.abs(cross(arms[:, 1:-1], arms[:, 2:]).sum(axis=1)) / 2
        error = (
            np.array(LEADS) * _nearness(plane_map, facet[bent], corners)[:, None] ** np.array(DEGREES) * share[:, None]
        )
        enough = error <= np.maximum(departure[bent], EXACT)[:, None]
        enough[:, -1] = True
        degree[bent] = np.array(DEGREES)[enough.argmax(axis=1)]
    return degree


def _nearness(plane_map: TangentPlaneMap, facet: IntArray, corners: Array) -> Array:
    """Nearness of the fold to pieces with corners (n, k, 2) in the planes of facets (n,): 0 infinitely far, 1 on them.

    Polynomials in the facet's coordinates have a branch point where the Jacobian J is zero. J^2 is a quadratic
    polynomial of the plane's coordinates. With its roots z along a side -1 <= z <= 1, a rule's error falls as rho^-n,
    where rho = |z +- sqrt(z^2 - 1)| > 1 is the sum of the half axes of the ellipse through z with foci at the side's
    ends (L. N. Trefethen, SIAM Review 50, 2008, p. 67, theorem 4.5); the largest 1 / rho of the sides is taken.
    """
    k = corners.shape[1]
    places = np.concatenate([corners, (corners + np.roll(corners, -1, axis=1)) / 2], axis=1)
    squared = plane_map.from_plane(np.repeat(facet, 2 * k), places.reshape(-1, 2))[1].reshape(-1, 2 * k) ** 2
    start, end, middle = squared[:, :k], np.roll(squared[:, :k], -1, axis=1), squared[:, k:]
    slope, bend = (end - start) / 2, (end + start) / 2 - middle
    # one over the root nearest to the middle; stable where J^2 is nearly linear or constant
    root = np.abs(slope) + np.sqrt((slope**2 - 4 * middle * bend).astype(complex))
    # a side whose middle is on the fold has nearness 1
    off = middle > np.finfo(float).eps * np.abs(root)
    inverse = np.divide(root, 2 * middle, out=np.ones_like(root), where=off)
    return np.asarray(np.where(off, np.abs(inverse / (1 + np.sqrt(1 - inverse**2))), 1.0).max(axis=1))


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
    pairs, pieces = [], []
    for kind in (False, True):
        members = np.flatnonzero(slave.triangle[f] == kind)
        if len(members):
            windows = sub_faces(slave.facets.shape[1], kind)
            pair = np.repeat(members, len(windows))
            window = plane_map.to_plane(f[pair], np.tile(windows, (len(members), 1, 1)))
            kept = _near(outline[members], window.reshape(len(members), len(windows), -1, 2))
            pair = pair[kept]
            polygon, count = clip(outline[pair], window[kept])
            corners, of = cut(polygon, count)
            pairs.append(pair[of])
            pieces.append(corners)
    pair, corners = np.concatenate(pairs), np.concatenate(pieces)
    degree = _degrees(slave, master, plane_map, f[pair], below, m[pair], corners)
    parts = []
    for order in np.unique(degree):
        of = np.flatnonzero(degree == order)
        local, weight, own = piece_samples(corners[of], int(order))
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
    pieces: Array,
) -> IntArray:
    """Degrees of quadrature (n,) for both sides on pieces (n, 4, 2) in the planes of slave facets f (n,)."""
    departure = np.maximum(plane_map.departure[f], below.departure[m])
    degree = degrees(plane_map, f, pieces, departure)
    degree[slave.triangle[f] & master.triangle[m]] = TRIANGLE_ORDER
    bent = np.flatnonzero(below.taper[m] > 0)
    if len(bent):
        facet, opposite = np.repeat(f[bent], 4), np.repeat(m[bent], 4)
        local, _ = plane_map.from_plane(facet, pieces[bent].reshape(-1, 2))
        seen = below.projected(opposite, slave.polynomials.values(facet, local)).reshape(-1, 4, 2)
        degree[bent] = np.maximum(degree[bent], degrees(below, m[bent], seen, departure[bent]))
    return degree


def _outlines(
    slave: FacetSurface, master: FacetSurface, f: IntArray, m: IntArray, plane_map: TangentPlaneMap, share: float
) -> Array:
    """Outlines (n_pairs, 4 | 8, 2) of master facets in the planes of slave facets, counter-clockwise or not.

    A triangle's outline repeats its last corner, for its sides of zero length.

    Every vertex has one image in the plane of a slave facet, so neighbouring master facets keep their common sides and
    tile the slave facet. The image is the intersection of the vertex's line of action (`surfaces.normals`) with
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
    normal = plane_map.normal[facet]
    parallel = plane_map.flat[facet] & own.even[facet] & (np.abs(normal + theirs).max(axis=1) <= PARALLEL)
    lines = np.where(parallel[:, None], 0.0, share * normal - (1 - share) * theirs)
    plane = plane_map.along(facet, vertices, lines)
    rows = np.flatnonzero(~parallel & _within(plane, slave.triangle[facet], SLACK))
    start, _ = plane_map.from_plane(facet[rows], plane[rows])
    local, met = meet(slave, facet[rows], start, vertices[rows], -theirs[rows], 1 - share, 2 * SLACK)
    met &= _within(local, slave.triangle[facet[rows]], 2 * SLACK) & (plane_map.jacobian(facet[rows], local) > FOLD)
    rows, local = rows[met], local[met]
    plane[rows] = plane_map.to_plane(facet[rows], local)
    return plane


def _within(local: Array, triangle: Mask, slack: float) -> Mask:
    """Whether coordinates (n, 2) are on facets extended by `slack`; on triangles the same from each corner."""
    third = np.where(triangle, 1.0 - local.sum(axis=1), 0.5)
    every = np.column_stack([local, third])
    return np.asarray(((every >= -slack) & (every <= 1 + slack)).all(axis=1))


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
