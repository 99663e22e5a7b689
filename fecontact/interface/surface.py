"""Surfaces that points can be projected on: linear or quadratic facets of a mesh, quadrilaterals and triangles.

A foot is the point of a surface nearest to a given one. For facets it is found by Newton's method on the curved
facet, for all points and their nearby facets at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fecontact.errors import MeshError
from fecontact.mesh.facets import distinct_columns, facet_centres, facet_nodes, facet_shapes, triangular

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


#: Sideways offset, relative to the surface's size, below which it is rounding: coordinates are good to 1e-16 of it.
SHORTEST_OFFSET = 1e-12
#: Sine of the angle between offset and normal from which a point with its foot on the rim counts as beyond it.
RIM_LEAN = 0.2
#: Distance from a triangle's side, in its local coordinates, that counts as on it.
ON_SIDE = 1e-13


@dataclass(frozen=True, eq=False)
class Feet:
    """Feet of n points on a surface, in the surface's own axes.

    Attributes
    ----------
    points : (n, 3) array
        The feet.
    normals : (n, 3) array
        Outward unit vectors along the line from foot to point: the surface's normals there.
    gap : (n,) array
        Signed distance along the normal; negative inside the body.
    beyond : (n,) bool array
        Whether the nearest point lies on the rim of the surface with the given point outside of it.
    weights : (n, n_nodes) csr_matrix, optional
        Interpolation from the nodes of the surface's mesh; None for a surface without nodes.
    facet, local : (n,) and (n, 2) arrays, optional
        Facet and its coordinates.
    surface : str
        Name of the surface whose facets these are.
    """

    points: Array
    normals: Array
    gap: Array
    beyond: NDArray[np.bool_]
    weights: sp.csr_matrix | None = None
    facet: IntArray | None = None
    local: Array | None = None
    surface: str = ""

    def chosen(self, kept: IntArray) -> Feet:
        """Some of the feet."""
        return Feet(
            self.points[kept],
            self.normals[kept],
            self.gap[kept],
            self.beyond[kept],
            None if self.weights is None else self.weights[kept],
            None if self.facet is None else self.facet[kept],
            None if self.local is None else self.local[kept],
            self.surface,
        )


class Surface(Protocol):
    """Something a point can be projected on."""

    def project(self, points: Array) -> Feet:
        """Feet of points (n, 3) given in the surface's axes."""


@dataclass(frozen=True, eq=False)
class FacetSurface:
    """Curved facets of a mesh.

    Parameters
    ----------
    points : (n_nodes, 3) array
        All nodes of the mesh.
    facets : (n_facets, 4 | 8 | 9) int array
        Node numbers, corners counter-clockwise seen from outside; triangles as in `mesh.facets`.
    name : str
    eight_hats : bool
        Whether eight-node facets can carry pressure shapes, because displacements on them have functions of their own;
        see `interface.hats`.
    """

    points: Array
    facets: IntArray
    name: str = "surface"
    eight_hats: bool = False

    @cached_property
    def nodes(self) -> IntArray:
        """Distinct node numbers of the surface."""
        return np.unique(self.facets)

    @cached_property
    def triangle(self) -> NDArray[np.bool_]:
        """Which facets (n_facets,) are triangles."""
        return triangular(self.facets)

    @cached_property
    def known(self) -> dict[str, object]:
        """What pairings have worked out about this surface alone, by name, for the next ones."""
        return {}

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.points[self.nodes], axis=0)))

    @cached_property
    def mean_facet_size(self) -> Array:
        """Square root of the approximate area (n_facets,) of each facet."""
        corners = self.points[self.facets[:, :4]]
        diagonals = corners[:, [2, 3]] - corners[:, [0, 1]]
        return np.sqrt(np.linalg.norm(np.cross(diagonals[:, 0], diagonals[:, 1]), axis=1) / 2)

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.points[self.nodes])

    @cached_property
    def _facets_of_node(self) -> IntArray:
        """Facets around each surface node (n_surface_nodes, most), filled up by repeating the first."""
        local = np.searchsorted(self.nodes, self.facets.ravel())
        owner = np.repeat(np.arange(len(self.facets)), self.facets.shape[1])
        order = np.argsort(local, kind="stable")
        count = np.bincount(local, minlength=len(self.nodes))
        start = np.concatenate([[0], np.cumsum(count)[:-1]])
        column = np.arange(count.max())[None, :]
        return owner[order][start[:, None] + np.where(column < count[:, None], column, 0)]

    @cached_property
    def _on_rim(self) -> NDArray[np.bool_]:
        """Of each facet's four sides (n_facets, 4), those that belong to no other facet."""
        corners = self.facets[:, :4]
        sides = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        _, inverse, count = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
        return (count[inverse.ravel()] == 1).reshape(-1, 4)

    def extent(self, points: Array) -> Array:
        """What a piece of area at points (n, 3) stands for, over that area (n,): one; more for sections."""
        return np.ones(len(points))

    def evaluate(self, facet: IntArray, local: Array) -> tuple[Array, Array, Array]:
        """Positions (n, 3), tangents (n, 3, 2) and shape functions (n, k) at facet coordinates."""
        N, dN = facet_shapes(self.facets.shape[1], self.triangle[facet], local)
        x = self.points[self.facets[facet]]
        return np.einsum("na,nai->ni", N, x), np.einsum("naj,nai->nij", dN, x), N

    def normals(self, facet: IntArray, local: Array) -> Array:
        """Outward unit normals (n, 3)."""
        _, tangents, _ = self.evaluate(facet, local)
        n = np.cross(tangents[:, :, 0], tangents[:, :, 1])
        length = np.linalg.norm(n, axis=1)
        if (length == 0).any():
            raise MeshError(
                f"Facet {facet[np.argmin(length)]} of {self.name!r} has no normal: two of its sides coincide."
            )
        return n / length[:, None]

    def project(self, points: Array, n_near: int = 3) -> Feet:
        """Feet of points (n, 3): the nearest over the facets round each point's `n_near` nearest nodes."""
        _, near = self._tree.query(points, k=min(n_near, len(self.nodes)))
        around = self._facets_of_node[near.reshape(len(points), -1)].reshape(len(points), -1)
        # one number for each pair of point and facet: its distinct values are found faster than those of pairs
        key = np.unique((np.arange(len(points))[:, None] * len(self.facets) + around).ravel())
        point, facet = np.divmod(key, len(self.facets))
        local, distance2 = self._newton(points[point], facet)
        # the nearest facet of each point; among equals the first, so that shared edges are decided once
        order = np.lexsort((facet, _rounded(distance2, self.mean_facet_size[facet]), point))
        best = order[np.searchsorted(point[order], np.arange(len(points)))]
        facet, local = facet[best], local[best]
        x, _, N = self.evaluate(facet, local)
        offset = points - x
        normals = self._lines_of_action(facet, local, N, offset)
        gap = np.einsum("ni,ni->n", offset, normals)
        columns = self.facets[facet]
        indptr = np.arange(0, columns.size + 1, columns.shape[1])
        weights = sp.csr_matrix((N.ravel(), columns.ravel(), indptr), shape=(len(points), len(self.points)))
        return Feet(x, normals, gap, self._beyond(facet, local, offset), weights, facet, local, self.name)

    @cached_property
    def _mean_normals(self) -> Array:
        """Unit normals (n_nodes, 3) averaged over the facets round each surface node; zero elsewhere."""
        k = self.facets.shape[1]
        facet, column = np.nonzero(distinct_columns(self.facets))
        reference = np.stack([facet_nodes(k, False), facet_nodes(k, True)])
        normals = self.normals(facet, reference[self.triangle[facet].astype(int), column])
        total = np.zeros_like(self.points)
        np.add.at(total, self.facets[facet, column], normals)
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return np.divide(total, length, out=np.zeros_like(total), where=length > 0)

    def _lines_of_action(self, facet: IntArray, local: Array, N: Array, offset: Array) -> Array:
        """Unit vectors from foot to point, outwards: a force along them has no moment about the foot.

        Inside a facet that is its normal. On an edge or corner between facets any direction of the normal cone can be
        nearest, so the offset itself gives the line; where it does not depart from the mean normal by more than
        rounding, the mean normal does (on a flat surface all lines are parallel, however short the offsets).
        """
        normals = self.normals(facet, local)
        on_edge = self._at_sides(facet, local).any(axis=1)
        mean = np.einsum("na,nai->ni", N[on_edge], self._mean_normals[self.facets[facet[on_edge]]])
        mean /= np.linalg.norm(mean, axis=1, keepdims=True)
        along = offset[on_edge]
        length = np.linalg.norm(along, axis=1)
        sideways = np.linalg.norm(along - np.einsum("ni,ni->n", along, mean)[:, None] * mean, axis=1)
        long = sideways > SHORTEST_OFFSET * self.size
        sign = np.where(np.einsum("ni,ni->n", along, mean) < 0, -1.0, 1.0)
        lines = np.divide(along, (sign * length)[:, None], out=mean.copy(), where=long[:, None])
        normals[on_edge] = lines
        return normals

    def _at_sides(self, facet: IntArray, local: Array) -> NDArray[np.bool_]:
        """On which sides of their facet points lie (n, 4)."""
        s, t = local.T
        triangle = self.triangle[facet]
        right = np.where(triangle, s + t >= 1 - ON_SIDE, s >= 1)
        return np.stack([t <= 0, right, ~triangle & (t >= 1), s <= 0], axis=1)

    def distance_to_facet(self, points: Array, facet: IntArray) -> Array:
        """Distance (n,) of each point from its given facet."""
        return np.sqrt(self._newton(points, facet)[1])

    def nearest_on(self, facet: IntArray, points: Array, slack: float) -> Array:
        """Coordinates (n, 2) of the point of each given facet nearest to `points`, up to `slack` beyond its sides."""
        return self._newton(points, facet, slack=slack)[0]

    def _newton(self, points: Array, facet: IntArray, iterations: int = 30, slack: float = 0.0) -> tuple[Array, Array]:
        """Nearest point of given facets: Newton on half the squared distance, kept within the facet.

        Gauss-Newton's matrix replaces the Hessian where that is not positive definite; a coordinate that leaves the
        facet (extended by `slack` on all sides) is held at its bound.
        """
        triangle = self.triangle[facet]
        local = facet_centres(triangle)
        active = np.arange(len(points))
        polynomials = _polynomials(self.points[self.facets[facet]] - points[:, None, :], triangle)
        for _ in range(iterations):
            gradient, hessian = _derivatives(polynomials[active], local[active])
            new = np.empty_like(gradient)
            # continued beyond its sides, a triangle too is searched in a square
            inside = triangle[active] if slack == 0 else np.zeros(len(active), bool)
            rows = np.flatnonzero(~inside)
            new[rows] = _step_in_square(local[active[rows]], gradient[rows], hessian[rows], slack)
            rows = np.flatnonzero(inside)
            new[rows] = _step_in_triangle(local[active[rows]], gradient[rows], hessian[rows])
            moved = np.abs(new - local[active]).max(axis=1)
            local[active] = new
            active = active[moved > 1e-13]
            if len(active) == 0:
                break
        x, _, _ = self.evaluate(facet, local)
        return local, ((points - x) ** 2).sum(axis=1)

    def _beyond(self, facet: IntArray, local: Array, offset: Array) -> NDArray[np.bool_]:
        """Whether a foot lies on a rim side while the point's offset leans outwards across it.

        On a plane of symmetry a coarse facet's normal leans a little out of the plane, so a small angle is let pass.
        """
        normals = self.normals(facet, local)
        sideways = offset - np.einsum("ni,ni->n", offset, normals)[:, None] * normals
        sideways = np.linalg.norm(sideways, axis=1)
        leaning = (sideways > 1e-6 * self.mean_facet_size[facet]) & (
            sideways > RIM_LEAN * np.linalg.norm(offset, axis=1)
        )
        return leaning & (self._at_sides(facet, local) & self._on_rim[facet]).any(axis=1)


def _newton_direction(gradient: Array, hessian: Array) -> Array:
    """Solve -H^-1 g of (n, 2, 2) matrices; zero where H is singular."""
    det = hessian[:, 0, 0] * hessian[:, 1, 1] - hessian[:, 0, 1] ** 2
    det = np.where(det > 0, det, np.inf)
    s = (hessian[:, 1, 1] * gradient[:, 0] - hessian[:, 0, 1] * gradient[:, 1]) / det
    t = (hessian[:, 0, 0] * gradient[:, 1] - hessian[:, 1, 0] * gradient[:, 0]) / det
    return -np.stack([s, t], axis=1)


def _step_in_square(local: Array, gradient: Array, hessian: Array, slack: float) -> Array:
    """Where Newton's step leads within the unit square, extended by `slack` on all sides."""
    # a coordinate at its bound that would leave the facet is fixed, the other moves alone
    held = ((local <= -slack) & (gradient > 0)) | ((local >= 1 + slack) & (gradient < 0))
    gradient, hessian = np.where(held, 0.0, gradient), hessian.copy()
    fixed = held.any(axis=1)
    hessian[fixed, 0, 1] = hessian[fixed, 1, 0] = 0.0
    return np.clip(local + np.clip(_newton_direction(gradient, hessian), -1.0, 1.0), -slack, 1.0 + slack)


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
    step = _newton_direction(gradient, hessian)
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


def _rounded(distance2: Array, size: Array) -> Array:
    """Logarithms of squared distances with their last digits cut off, so that equal ones compare equal.

    Cut at 1e-12, for a foot moves sideways by the root of that, and at 1e-12 of the facet's size.
    """
    return np.asarray(np.round(np.log(distance2 + (1e-12 * size) ** 2 + 1e-300), 12), dtype=np.float64)


@cache
def _coefficients(n_columns: int, triangle: bool, degree: int) -> Array:
    """Coefficients ((degree + 1)^2, n_columns) of a facet's shape functions over the monomials s^i t^j.

    scikit-fem gives values and first derivatives only; as polynomials they can be derived as often as Newton needs.
    """
    t = np.linspace(0.0, 1.0, degree + 1)
    grid = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    values = facet_shapes(n_columns, np.full(len(grid), triangle), grid)[0]
    power = np.vander(t, degree + 1, increasing=True)
    return np.linalg.solve(np.kron(power, power), values)


def _polynomials(offsets: Array, triangle: NDArray[np.bool_]) -> Array:
    """Facets as polynomials (n, 3, degree + 1, degree + 1) in s and t, from nodes (n, k, 3) relative to points."""
    degree = 3 if triangle.any() else 2
    n, k, _ = offsets.shape
    out = np.empty((n, (degree + 1) ** 2, 3))
    for kind in (False, True):
        rows = np.flatnonzero(triangle == kind)
        if len(rows):
            out[rows] = _coefficients(k, kind, degree) @ offsets[rows]
    return np.ascontiguousarray(out.transpose(0, 2, 1)).reshape(n, 3, degree + 1, degree + 1)


def _derivatives(polynomials: Array, local: Array) -> tuple[Array, Array]:
    """Gradient (n, 2) of half the squared distance and a positive definite matrix (n, 2, 2) for its Hessian."""
    degree = polynomials.shape[3] - 1
    rank = np.arange(degree + 1.0)
    powers = local[:, :, None] ** rank  # (n, 2, degree + 1)
    first, second = np.zeros_like(powers), np.zeros_like(powers)
    first[..., 1:] = rank[1:] * powers[..., :-1]
    second[..., 2:] = (rank[2:] * rank[1:-1]) * powers[..., :-2]
    along_t = polynomials @ np.stack([powers[:, 1], first[:, 1], second[:, 1]], axis=2)[:, None]  # (n, 3, i, 3)
    in_s = np.stack([powers[:, 0], first[:, 0], second[:, 0]], axis=1)[:, None]  # (n, 1, 3, i)
    D = in_s @ along_t  # (n, 3, order in s, order in t)
    r, x_s, x_t = D[:, :, 0, 0], D[:, :, 1, 0], D[:, :, 0, 1]

    def dot(u: Array, v: Array) -> Array:
        return np.asarray((u * v).sum(axis=1))

    gradient = np.stack([dot(r, x_s), dot(r, x_t)], axis=1)
    a, b, c = dot(x_s, x_s), dot(x_s, x_t), dot(x_t, x_t)
    ha, hb, hc = a + dot(r, D[:, :, 2, 0]), b + dot(r, D[:, :, 1, 1]), c + dot(r, D[:, :, 0, 2])
    indefinite = (ha * hc - hb**2 <= 0.01 * a * c) | (ha <= 0)
    ha, hb, hc = (np.where(indefinite, g, h) for g, h in ((a, ha), (b, hb), (c, hc)))
    return gradient, np.stack([np.stack([ha, hb], axis=1), np.stack([hb, hc], axis=1)], axis=1)
