"""Facets as polynomials, and Newton's search for the nearest points of facets, for many points at once.

A facet is x(s, t) = origin + sum c_ij s^i t^j. The last axis of arrays runs over the points, in blocks that fit in the
cache: the operations are few, so memory traffic takes most of the time.

Facets replaced by flat triangles through their corners, to leave out facets that cannot hold a closest point.

A facet is x = L + sum N_a d_a, L interpolating its corners linearly and d_a the offsets of the other nodes from L. So
every point of it is within `BULGE` max |d_a| of a point of L. A quadrilateral's L departs from the two triangles on
either side of its diagonal by st - min(s, t), no more than 1/4, times |x_0 - x_1 + x_2 - x_3|. Distances from a facet
and from its triangles therefore differ by no more than the sum of both.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.facets import distinct_columns, facet_centres, facet_nodes, facet_shapes, triangular

#: Points per block: some dozens of numbers each should fit in a core's cache.
BLOCK = 4096
#: Step in a facet's coordinates at which a nearest point is found.
STEP_TOLERANCE = 1e-13
#: Distance from a triangle's side, in its local coordinates, that counts as on it.
ON_SIDE = 1e-13


@cache
def _coefficients(n_columns: int, triangle: bool, degree: int) -> Array:
    """Coefficients ((degree + 1)^2, n_columns) of a facet's shape functions over the monomials s^i t^j.

    scikit-fem gives values and first derivatives only; Newton's method also needs second ones.
    """
    t = np.linspace(0.0, 1.0, degree + 1)
    grid = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    values = facet_shapes(n_columns, np.full(len(grid), triangle), grid)[0]
    power = np.vander(t, degree + 1, increasing=True)
    c = np.linalg.solve(np.kron(power, power), values)
    if triangle:  # powers sum to the degree at most; the others are rounding
        c[np.add.outer(np.arange(degree + 1), np.arange(degree + 1)).ravel() > degree] = 0.0
    return c


@dataclass(frozen=True, eq=False)
class FacetPolynomials:
    """Facets as polynomials.

    Attributes
    ----------
    origin : (3, n_facets) array
        Each facet's first node, so that the polynomials do not depend on the body's position.
    coefficients : (degree + 1, degree + 1, 3, n_facets) array
        c_ij.
    triangle : (n_facets,) bool array
    """

    origin: Array
    coefficients: Array
    triangle: Mask

    @property
    def degree(self) -> int:
        """Largest power of a coordinate."""
        return len(self.coefficients) - 1

    @cached_property
    def only_triangles(self) -> bool:
        """Whether no facet is a quadrilateral: powers then sum to the degree at most."""
        return bool(self.triangle.all())

    def evaluate(self, facet: IntArray, local: Array) -> tuple[Array, Array]:
        """Positions (n, 3) and tangents (n, 3, 2) at coordinates (n, 2) of facets (n,)."""
        n = len(facet)
        x, tangents = np.empty((n, 3)), np.empty((n, 3, 2))
        for start in range(0, n, BLOCK):
            part = slice(start, start + BLOCK)
            c = chosen(self.coefficients, facet[part])
            s, t = local[part].T
            value, along_s, along_t = first_derivatives(c, s, t, self.only_triangles)
            x[part] = (value + chosen(self.origin, facet[part])).T
            tangents[part, :, 0], tangents[part, :, 1] = along_s.T, along_t.T
        return x, tangents

    def values(self, facet: IntArray, local: Array) -> Array:
        """Positions (n, 3) at coordinates (n, 2) of facets (n,)."""
        x = np.empty((len(facet), 3))
        for start in range(0, len(facet), BLOCK):
            part = slice(start, start + BLOCK)
            value = _values(chosen(self.coefficients, facet[part]), *local[part].T)
            x[part] = (value + chosen(self.origin, facet[part])).T
        return x

    def relative_to(self, facet: IntArray, points: Array) -> Array:
        """Coefficients (degree + 1, degree + 1, 3, n) of facets (n,) relative to points (n, 3)."""
        c = chosen(self.coefficients, facet)
        c[0, 0] += chosen(self.origin, facet) - points.T
        return c

    def closest(
        self, points: Array, facet: IntArray, iterations: int = 30, slack: float = 0.0, start: Array | None = None
    ) -> tuple[Array, Array]:
        """Nearest points of given facets: Newton's method on half the squared distance, kept within the facet.

        Gauss-Newton's matrix replaces the Hessian where that is not positive definite; a coordinate that leaves the
        facet is held at its bound.

        Parameters
        ----------
        points : (n, 3) array
        facet : (n,) int array
            The facet on which each point is projected.
        iterations : int, optional
        slack : float, optional
            By how much facets are extended on all sides, in their coordinates; triangles become squares with it.
        start : (n, 2) array, optional
            Coordinates to begin at; the middles of the facets unless given.

        Returns
        -------
        local : (n, 2) array
            Coordinates of the nearest points.
        distance2 : (n,) array
            Squared distances.
        """
        local, distance2 = np.empty((len(points), 2)), np.empty(len(points))
        for first in range(0, len(points), BLOCK):
            part = slice(first, first + BLOCK)
            begun = None if start is None else start[part]
            local[part], distance2[part] = self._searched(points[part], facet[part], iterations, slack, begun)
        return local, distance2

    def _searched(
        self, points: Array, facet: IntArray, iterations: int, slack: float, start: Array | None
    ) -> tuple[Array, Array]:
        """`closest` for one block of points."""
        triangle = self.triangle[facet]
        local = facet_centres(triangle) if start is None else np.clip(start, -slack, 1 + slack)
        local = local.T.copy()
        active = np.arange(len(points))
        polynomials = self.relative_to(facet, points)
        # continued beyond its sides, a triangle too is searched in a square
        triangle = triangle & (slack == 0)
        for _ in range(iterations):
            before = local[:, active]
            gradient, matrix = derivatives(polynomials, before)
            new = _step_in_square(before, gradient, matrix, slack)
            rows = np.flatnonzero(triangle[active])
            if len(rows):
                a, b, d = matrix[:, rows]
                hessian = np.stack([np.stack([a, b], axis=1), np.stack([b, d], axis=1)], axis=1)
                new[:, rows] = _step_in_triangle(before[:, rows].T, gradient[:, rows].T, hessian).T
            local[:, active] = new
            moving = np.flatnonzero(np.abs(new - before).max(axis=0) > STEP_TOLERANCE)
            if len(moving) == 0:
                break
            if len(moving) < len(active):
                active, polynomials = active[moving], polynomials[..., moving]
        out = np.ascontiguousarray(local.T)
        return out, ((points - self.values(facet, out)) ** 2).sum(axis=1)


def shapes_at(n_columns: int, triangle: Mask, degree: int, local: Array) -> Array:
    """Shape functions (n, n_columns) at coordinates (n, 2) of facets of which some are triangles (n,).

    Sums of monomials up to `degree`, that of the facets as polynomials.
    """
    s, t = local.T
    rank = range(degree + 1)
    powers = np.stack([s**i * t**j for i in rank for j in rank], axis=1)
    rows = np.flatnonzero(triangle)
    N = powers @ _coefficients(n_columns, len(rows) == len(triangle) > 0, degree)
    if 0 < len(rows) < len(triangle):
        N[rows] = powers[rows] @ _coefficients(n_columns, True, degree)
    return N


def facet_polynomials(points: Array, facets: IntArray, triangle: Mask) -> FacetPolynomials:
    """Facets (n_facets, 4 | 8 | 9) on points (n_points, 3) as polynomials."""
    degree = 1 if facets.shape[1] == 4 else 3 if triangle.any() else 2
    origin = points[facets[:, 0]]
    offsets = points[facets] - origin[:, None]
    c = np.empty(((degree + 1) ** 2, 3, len(facets)))
    for kind in (False, True):
        rows = np.flatnonzero(triangle == kind)
        if len(rows):
            c[..., rows] = np.einsum("pa,nai->pin", _coefficients(facets.shape[1], kind, degree), offsets[rows])
    shape = (degree + 1, degree + 1, 3, len(facets))
    return FacetPolynomials(np.ascontiguousarray(origin.T), c.reshape(shape), triangle)


def chosen(values: Array, facet: IntArray, out: Array | None = None) -> Array:
    """Values (..., n_facets) of facets (n,): as by an index, in a third of the time."""
    return np.take(values, facet, axis=-1, out=out, mode="clip")


def _values(c: Array, s: Array, t: Array) -> Array:
    """Values (3, n) of polynomials (m, m, 3, n), by Horner's scheme."""
    in_t = c[:, -1].copy()
    for j in range(c.shape[1] - 2, -1, -1):
        in_t *= t
        in_t += c[:, j]
    value = in_t[-1]
    for i in range(len(c) - 2, -1, -1):
        value *= s
        value += in_t[i]
    return value


def first_derivatives(c: Array, s: Array, t: Array, only_triangles: bool = False) -> tuple[Array, Array, Array]:
    """Value and first derivatives (3, n) of polynomials (m, m, 3, n), by Horner's scheme.

    With `only_triangles` coefficients c_ij with i + j >= m are not read: they are zero on triangles.
    """
    m = len(c)
    value, along_s, along_t = np.zeros((3, *c.shape[2:]))
    for i in range(m - 1, -1, -1):
        highest = m - 1 - i if only_triangles else m - 1
        in_t, slope_t = c[i, highest], np.zeros_like(value)
        for j in range(highest - 1, -1, -1):
            slope_t *= t
            slope_t += in_t
            in_t = in_t * t
            in_t += c[i, j]
        along_s *= s
        along_s += value
        value *= s
        value += in_t
        along_t *= s
        along_t += slope_t
    return value, along_s, along_t


def dot(u: Array, v: Array) -> Array:
    """Scalar products (n,) of vectors (3, n)."""
    return np.asarray(u[0] * v[0] + u[1] * v[1] + u[2] * v[2])


def cross(u: Array, v: Array) -> Array:
    """Vector products (3, n) of vectors (3, n)."""
    return np.stack([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]])


def derivatives(c: Array, local: Array) -> tuple[Array, Array]:
    """Newton's equations for half the squared distance of polynomials from the origin.

    Gauss-Newton's matrix replaces the Hessian where that is not positive definite.

    Parameters
    ----------
    c : (m, m, 3, n) array
    local : (2, n) array

    Returns
    -------
    gradient : (2, n) array
    matrix : (3, n) array
        The components ss, st and tt of a positive definite matrix.
    """
    s, t = local
    in_t, slope_t = c[:, -1], np.zeros_like(c[:, -1])
    bend_t = slope_t
    for j in range(c.shape[1] - 2, -1, -1):
        bend_t = bend_t * t + slope_t
        slope_t = slope_t * t + in_t
        in_t = in_t * t + c[:, j]
    r, x_t, half_tt = in_t[-1], slope_t[-1], bend_t[-1]
    x_s = np.zeros_like(r)
    half_ss, x_st = x_s, x_s
    for i in range(len(c) - 2, -1, -1):
        half_ss = half_ss * s + x_s
        x_s = x_s * s + r
        r = r * s + in_t[i]
        x_st = x_st * s + x_t
        x_t = x_t * s + slope_t[i]
        half_tt = half_tt * s + bend_t[i]
    gradient = np.stack([dot(r, x_s), dot(r, x_t)])
    a, b, d = dot(x_s, x_s), dot(x_s, x_t), dot(x_t, x_t)
    ha, hb, hd = a + 2 * dot(r, half_ss), b + dot(r, x_st), d + 2 * dot(r, half_tt)
    definite = (ha * hd - hb**2 > 0.01 * a * d) & (ha > 0)
    return gradient, np.stack([np.where(definite, h, g) for h, g in ((ha, a), (hb, b), (hd, d))])


def _newton_direction(gradient: Array, matrix: Array) -> Array:
    """Solve -H^-1 g (2, n), H given by its components ss, st, tt (3, n); zero where H is singular."""
    a, b, d = matrix
    det = a * d - b**2
    det = np.where(det > 0, det, np.inf)
    s = (d * gradient[0] - b * gradient[1]) / det
    t = (a * gradient[1] - b * gradient[0]) / det
    return -np.stack([s, t])


def _step_in_square(local: Array, gradient: Array, matrix: Array, slack: float) -> Array:
    """Where Newton's step leads (2, n) within the unit square, extended by `slack` on all sides."""
    # a coordinate at its bound that would leave the facet is fixed, the other moves alone
    held = ((local <= -slack) & (gradient > 0)) | ((local >= 1 + slack) & (gradient < 0))
    gradient, matrix = np.where(held, 0.0, gradient), matrix.copy()
    matrix[1, held.any(axis=0)] = 0.0
    return np.clip(local + np.clip(_newton_direction(gradient, matrix), -1.0, 1.0), -slack, 1.0 + slack)


#: Sides of the reference triangle: a point on it, the outward normal, the direction.
_SIDES = (
    (np.array([0.0, 0.0]), np.array([0.0, -1.0]), np.array([1.0, 0.0])),
    (np.array([1.0, 0.0]), np.array([1.0, 1.0]), np.array([-1.0, 1.0])),
    (np.array([0.0, 0.0]), np.array([-1.0, 0.0]), np.array([0.0, 1.0])),
)


def _step_in_triangle(local: Array, gradient: Array, hessian: Array) -> Array:
    """Where Newton's step leads within the triangle s, t >= 0, s + t <= 1.

    On a side that the full step would cross, the least value of the quadratic model lies on that side or, in a corner,
    on the other one: the better of the two steps along them is taken. Every step stops where it meets a side.
    """
    room = np.stack([(p - local) @ n for p, n, _ in _SIDES], axis=1)
    at = np.asarray(room <= ON_SIDE)
    step = _newton_direction(gradient.T, hessian.reshape(-1, 4)[:, [0, 1, 3]].T).T
    crossing = (at & (np.stack([step @ n for _, n, _ in _SIDES], axis=1) > 0)).any(axis=1, keepdims=True)
    best, gain = np.zeros_like(step), np.zeros(len(step))
    for k, (_, _, along) in enumerate(_SIDES):
        slope = gradient @ along
        length = -slope / np.maximum(np.einsum("i,nij,j->n", along, hessian, along), 1e-300)
        for j, (_, n, _) in enumerate(_SIDES):
            if j != k:
                length = np.where(at[:, j] & (length * (along @ n) > 0), 0.0, length)
        better = at[:, k] & (slope * length < gain)
        gain = np.where(better, slope * length, gain)
        best = np.where(better[:, None], length[:, None] * along, best)
    step = np.where(crossing, best, step)
    speed = np.stack([step @ n for _, n, _ in _SIDES], axis=1)
    along_side = at & (np.abs(speed) <= 1e-12 * np.abs(step).max(axis=1, keepdims=True))
    outwards = (speed > 0) & ~along_side
    share = np.divide(np.maximum(room, 0.0), speed, out=np.ones_like(room), where=outwards).min(axis=1, initial=1.0)
    new = np.maximum(local + share[:, None] * step, 0.0)
    new[new <= ON_SIDE] = 0.0
    return new / np.maximum(new.sum(axis=1, keepdims=True), 1.0)


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
