"""Maps of quadrilateral facets to a plane in which straight sides are straight.

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
from fecontact.contact.coupling.mortar_basis import ORDER
from fecontact.mesh.facets import facet_centres, facet_nodes, facet_shapes
from fecontact.surfaces.facet_surface import FacetSurface

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
    origin : (n_facets, 3) array
        The facet's centre.
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
    return TangentPlaneMap(middle, x, plane, image.mean(axis=1), a, b, d, taper, departure, flat)


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


def degrees(plane_map: TangentPlaneMap, facet: IntArray, triangle: Array, departure: Array) -> IntArray:
    """Degrees of quadrature (n,) for triangles (n, 3, 2) in the planes of facets (n,).

    The error of a rule of degree n is `LEADS` tau^n times the triangle's area (`_nearness`). It is kept below `EXACT`
    times the facet's area on flat facets, and below the `departure` (n,) from flatness, which is an error anyway, on
    others.
    """
    degree = np.full(len(facet), ORDER)
    bent = np.flatnonzero(plane_map.taper[facet] > 0)
    if len(bent):
        corners = triangle[bent]
        share = np.abs(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])) / 2
        error = (
            np.array(LEADS) * _nearness(plane_map, facet[bent], corners)[:, None] ** np.array(DEGREES) * share[:, None]
        )
        enough = error <= np.maximum(departure[bent], EXACT)[:, None]
        enough[:, -1] = True
        degree[bent] = np.array(DEGREES)[enough.argmax(axis=1)]
    return degree


def _nearness(plane_map: TangentPlaneMap, facet: IntArray, triangle: Array) -> Array:
    """Nearness of the fold to triangles (n, 3, 2) in the planes of facets (n,): 0 infinitely far, 1 on them.

    Polynomials in the facet's coordinates have a branch point where the Jacobian J is zero. J^2 is a quadratic
    polynomial of the plane's coordinates. With its roots z along a side -1 <= z <= 1, a rule's error falls as rho^-n,
    where rho = |z +- sqrt(z^2 - 1)| > 1 is the sum of the half axes of the ellipse through z with foci at the side's
    ends (L. N. Trefethen, SIAM Review 50, 2008, p. 67, theorem 4.5); the largest 1 / rho of the three sides is taken.
    """
    places = np.concatenate([triangle, (triangle + np.roll(triangle, -1, axis=1)) / 2], axis=1)
    squared = plane_map.from_plane(np.repeat(facet, 6), places.reshape(-1, 2))[1].reshape(-1, 6) ** 2
    start, end, middle = squared[:, :3], np.roll(squared[:, :3], -1, axis=1), squared[:, 3:]
    slope, bend = (end - start) / 2, (end + start) / 2 - middle
    # one over the root nearest to the middle; stable where J^2 is nearly linear or constant
    root = np.abs(slope) + np.sqrt((slope**2 - 4 * middle * bend).astype(complex))
    # a side whose middle is on the fold has nearness 1
    off = middle > np.finfo(float).eps * np.abs(root)
    inverse = np.divide(root, 2 * middle, out=np.ones_like(root), where=off)
    return np.asarray(np.where(off, np.abs(inverse / (1 + np.sqrt(1 - inverse**2))), 1.0).max(axis=1))
