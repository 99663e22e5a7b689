"""Facets replaced by flat triangles through their corners, to leave out facets that cannot hold a closest point.

A facet is x = L + sum N_a d_a, L interpolating its corners linearly and d_a the offsets of the other nodes from L. So
every point of it is within `BULGE` max |d_a| of a point of L. A quadrilateral's L departs from the two triangles on
either side of its diagonal by st - min(s, t), no more than 1/4, times |x_0 - x_1 + x_2 - x_3|. Distances from a facet
and from its triangles therefore differ by no more than the sum of both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.mesh.facets import distinct_columns, facet_nodes, facet_shapes, triangular
from fecontact.surfaces.closest_point import BLOCK, cross, dot

#: Sum of the absolute shape functions other than the corners', on facets of 8 or 9 columns: 2 in the middle of an
#: eight-node facet, less on all others.
BULGE = 2.0
#: Margin of the bounds of a distance, relative to it and to the facet: rounding.
MARGIN = 1e-9


def bulges(points: Array, facets: IntArray) -> Array:
    """Largest distance (n_facets,) of a facet (n_facets, 4 | 8 | 9) from the hull of its corners."""
    n, k = facets.shape
    if k == 4:
        return np.zeros(n)
    x, off, triangle = points[facets], np.zeros((n, k)), triangular(facets)
    for kind in (False, True):
        rows = np.flatnonzero(triangle == kind)
        linear = facet_shapes(4, np.full(k, kind), facet_nodes(k, kind))[0]
        off[rows] = np.linalg.norm(x[rows] - np.einsum("ab,nbi->nai", linear, x[rows, :4]), axis=2)
    return np.asarray(BULGE * np.where(distinct_columns(facets), off, 0.0).max(axis=1))


@dataclass(frozen=True, eq=False)
class FlatFacets:
    """Triangles through the corners of facets; a triangular facet has one, and a second without area.

    Attributes
    ----------
    corners : (4, 3, n_facets) array
    depart : (n_facets,) array
        Largest difference of the distances of a point from a facet and from its triangles.
    only_triangles : bool
        Whether no facet is a quadrilateral.
    """

    corners: Array
    depart: Array
    only_triangles: bool

    @classmethod
    def of(cls, points: Array, facets: IntArray) -> FlatFacets:
        """Of facets (n_facets, 4 | 8 | 9) on points (n_points, 3)."""
        triangle = triangular(facets)
        x = points[facets[:, :4]]
        warp = np.linalg.norm(x[:, 0] - x[:, 1] + x[:, 2] - x[:, 3], axis=1) / 4
        size = np.linalg.norm(np.ptp(x, axis=1), axis=1)
        depart = bulges(points, facets) + np.where(triangle, 0.0, warp) + MARGIN * size
        return cls(np.ascontiguousarray(x.transpose(1, 2, 0)), depart, bool(triangle.all()))

    def closest(self, points: Array, facet: IntArray) -> tuple[Array, Array]:
        """Coordinates (n, 2) on facets (n,) nearest to points (n, 3) on their triangles, and the distances (n,)."""
        local, square = np.empty((2, len(points))), np.empty(len(points))
        for start in range(0, len(points), BLOCK):
            part = slice(start, start + BLOCK)
            a, b, c, d = self.corners[..., facet[part]] - points[part].T
            square[part], s, t = _on_triangle(a, b, c)
            if not self.only_triangles:
                other, of_c, of_d = _on_triangle(a, c, d)
                # x_0 + s (x_1 - x_0) + t (x_2 - x_1), and below x_0 + s (x_2 - x_3) + t (x_3 - x_0);
                # a triangle's second is its side x_0 to x_2, on which s = 0
                quad, second = (d != c).any(axis=0), other < square[part]
                s, t = np.where(second, quad * of_c, s + quad * t), np.where(second, of_c + of_d, t)
                square[part] = np.minimum(square[part], other)
            local[0, part], local[1, part] = s, t
        return np.ascontiguousarray(local.T), np.sqrt(square)

    def nearest(self, points: Array, point: IntArray, facet: IntArray) -> tuple[IntArray, Array]:
        """The pairs (k,) that can hold a point's closest point among its facets, and where on the triangles (k, 2).

        Parameters
        ----------
        points : (n_points, 3) array
        point, facet : (n,) int arrays
            Pairs of a point and a facet, sorted by point; all of a point's facets.
        """
        local, distance = self.closest(points[point], facet)
        slack = self.depart[facet]
        first = np.flatnonzero(np.diff(point, prepend=-1))
        least = np.minimum.reduceat(distance + slack, first)
        count = np.diff(np.append(first, len(point)))
        kept = np.flatnonzero(distance - slack <= (1 + MARGIN) * np.repeat(least, count))
        return kept, local[kept]


def _on_triangle(a: Array, b: Array, c: Array) -> tuple[Array, Array, Array]:
    """Squared distance (n,) of the origin from triangles with corners (3, n), and shares of b and c in the place.

    Inside the prism on the triangle the place is the foot on its plane, elsewhere the nearest one of its sides. A
    triangle may have no area.
    """
    ab, bc, ca = b - a, c - b, a - c
    normal = cross(ab, bc)
    area2 = dot(normal, normal)
    over, parts, sides = area2 > 0, [], []
    for start, along in ((a, ab), (b, bc), (c, ca)):
        part = dot(cross(start, along), normal)
        over &= part >= 0
        parts.append(part)
        length2 = dot(along, along)
        share = np.clip(np.divide(-dot(start, along), length2, out=np.zeros_like(area2), where=length2 > 0), 0, 1)
        off = start + share * along
        sides.append((dot(off, off), share))
    square, s = sides[0]
    t = np.zeros_like(s)
    for other, of_b, of_c in ((sides[1][0], 1 - sides[1][1], sides[1][1]), (sides[2][0], 0.0, 1 - sides[2][1])):
        nearer = other < square
        square, s, t = np.where(nearer, other, square), np.where(nearer, of_b, s), np.where(nearer, of_c, t)
    inverse = np.divide(1.0, area2, out=np.zeros_like(area2), where=over)
    height = dot(a, normal)
    return (
        np.where(over, height * height * inverse, square),
        np.where(over, parts[2] * inverse, s),
        np.where(over, parts[0] * inverse, t),
    )
