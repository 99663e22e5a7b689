"""Bounds of a surface's facets: balls and hulls, parts, cones of normals, bounds of displacements.

A part is a quarter of a quadratic facet, on which its multipliers are bilinear, or else a whole facet. Bernstein
coefficients, on the unit square or on a triangle, bound values between nodes: displacements by the largest coefficient,
the cone by those of x_s x x_t and of the normals interpolated between nodes (`surfaces.normals`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.element import QUAD_CORNERS, quad_nodes
from fecontact.mesh.facets import facet_centres, facet_shapes
from fecontact.surfaces.closest_point import bulges
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.normals import normals_of


@dataclass(frozen=True, eq=False)
class Bounds:
    """Bounds of all facets of a surface, in the surface's axes.

    A facet is x = L + sum N_a d_a, L interpolating its corners linearly and d_a the offsets of the other nodes from L,
    so that it lies within `bulge` of the hull of its corners, see `surfaces.closest_point`.

    Attributes
    ----------
    corners : (n, 4, 3) array
    centre, normal : (n, 3) arrays
        Centre of the facet.
    bulge : (n,) array
    radius : (n,) array
        Radius of a ball round the centre that contains the facet.
    trees : tuple of (IntArray, float, cKDTree)
        Facets of similar radius, the largest radius among them, and their centres.
    all_centres, nodes : cKDTree
    """

    corners: Array
    centre: Array
    normal: Array
    bulge: Array
    radius: Array
    trees: tuple[tuple[IntArray, float, cKDTree], ...]
    all_centres: cKDTree
    nodes: cKDTree


def bounds_of(surface: FacetSurface) -> Bounds:
    """Bounds of a surface, cached."""
    return surface.once(_bounds)


def _bounds(surface: FacetSurface) -> Bounds:
    n, bulge = len(surface.facets), bulges(surface.points, surface.facets)
    middle = facet_centres(surface.triangle)
    every = np.arange(n)
    centre = surface.evaluate(every, middle)[0]
    corners = surface.points[surface.facets[:, :4]]
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1) + bulge
    size = np.floor(np.log2(radius / radius.min())).astype(int)
    groups = [np.flatnonzero(size == s) for s in np.unique(size)]
    trees = tuple((g, float(radius[g].max()), cKDTree(centre[g])) for g in groups)
    return Bounds(corners, centre, surface.normals(every, middle), bulge, radius, trees, cKDTree(centre), surface.tree)


@dataclass(frozen=True, eq=False)
class FacetParts:
    """A surface divided into parts.

    Attributes
    ----------
    surface : FacetSurface
        The surface with the parts as facets.
    owner : (n_parts,) int array
        Facet of each part.
    columns : (n_parts, k) bool array
        Nodes of that facet whose multipliers are nonzero on the part.
    """

    surface: FacetSurface
    owner: IntArray
    columns: Mask


def parts_of(surface: FacetSurface) -> FacetParts:
    """Quarters of quadratic quadrilaterals, whole facets of other kinds; cached."""
    return surface.once(_parts)


def _parts(surface: FacetSurface) -> FacetParts:
    n, k = surface.facets.shape
    if k == 4 or surface.triangle.any():
        return FacetParts(surface, np.arange(n), np.ones((n, k), bool))
    low = 0.5 * QUAD_CORNERS[:, None]
    local = (low + 0.5 * quad_nodes(9)).reshape(-1, 2)
    points = surface.evaluate(np.repeat(np.arange(n), len(local)), np.tile(local, (n, 1)))[0]
    nodes = quad_nodes(k)
    columns = ((nodes >= low) & (nodes <= low + 0.5)).all(axis=2)
    cut = FacetSurface(points, np.arange(len(points)).reshape(-1, 9), surface.name)
    return FacetParts(cut, np.repeat(np.arange(n), 4), np.tile(columns, (n, 1)))


@dataclass(frozen=True, eq=False)
class Cones:
    """Cones that contain the normals of each facet, its own and interpolated ones, and of its neighbours.

    Attributes
    ----------
    axis : (n, 3) array
    angle : (n,) array
        Half angles.
    """

    axis: Array
    angle: Array

    def chosen(self, rows: IntArray) -> Cones:
        """A subset of the cones."""
        return Cones(self.axis[rows], self.angle[rows])


def cones_of(surface: FacetSurface) -> Cones:
    """Cones of normals, cached."""
    return surface.once(_cones)


@cache
def _bernstein(degree: int, triangle: bool = False) -> tuple[Array, Array]:
    """A grid (n, 2) on the unit square, and the matrix (n, n) from values there to Bernstein coefficients.

    On a triangle, for polynomials whose powers sum to the degree at most (G. Farin, Computer Aided Geometric Design 3,
    1986, p. 83): their values lie in the hull of the coefficients there too.
    """
    t = np.linspace(0.0, 1.0, degree + 1)
    if triangle:
        power = np.array([(i, j, degree - i - j) for i in range(degree + 1) for j in range(degree + 1 - i)])
        times = [math.factorial(degree) // math.prod(map(math.factorial, p)) for p in power.tolist()]
        coordinates = power / degree
        basis = np.array(times) * (coordinates[:, None] ** power).prod(axis=2)
        return coordinates[:, :2], np.linalg.inv(basis)
    basis = np.stack([math.comb(degree, i) * t**i * (1 - t) ** (degree - i) for i in range(degree + 1)], axis=1)
    grid = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    return grid, np.linalg.inv(np.kron(basis, basis))


#: Degrees of x_s x x_t and of the interpolated normals: in each coordinate, and in both together on a triangle.
_NORMAL_DEGREES = {False: (3, 2), True: (4, 3)}


def _cross_products(surface: FacetSurface, facet: IntArray, local: Array) -> Array:
    """x_s x x_t (n, 3)."""
    tangents = surface.evaluate(facet, local)[1]
    return np.cross(tangents[..., 0], tangents[..., 1])


def _interpolated(surface: FacetSurface, facet: IntArray, local: Array) -> Array:
    """Interpolated normals (n, 3), not of unit length."""
    return normals_of(surface).at(facet, local)


def _cones(surface: FacetSurface) -> Cones:
    n = len(surface.facets)
    axis = bounds_of(surface).normal
    own = np.zeros(n)
    for kind in (False, True):
        rows = np.flatnonzero(surface.triangle == kind)
        for degree, normals in zip(_NORMAL_DEGREES[kind], (_cross_products, _interpolated), strict=True):
            grid, to_bernstein = _bernstein(degree, kind)
            values = normals(surface, np.repeat(rows, len(grid)), np.tile(grid, (len(rows), 1)))
            coefficients = to_bernstein @ values.reshape(len(rows), len(grid), 3)
            along = np.einsum("npi,ni->np", coefficients, axis[rows])
            length = np.linalg.norm(coefficients, axis=2)
            # a coefficient of zero has no direction
            cosine = np.divide(along, length, out=np.full_like(along, -1.0), where=length > 0).min(axis=1, initial=1.0)
            own[rows] = np.maximum(own[rows], np.arccos(np.clip(cosine, -1.0, 1.0)))
    member = sp.csr_matrix((np.ones(4 * n), (np.repeat(np.arange(n), 4), surface.facets[:, :4].ravel())))
    pair = (member @ member.T).tocoo()
    between = np.arccos(np.clip(np.einsum("ni,ni->n", axis[pair.row], axis[pair.col]), -1.0, 1.0))
    angle: Array = own.copy()
    np.maximum.at(angle, pair.row, between + own[pair.col])
    return Cones(axis, angle)


@cache
def lebesgue(n_columns: int) -> float:
    """Upper bound of sum |N_a| over a facet: 1 bilinear, 25/16 on nine nodes, 3 on eight; less on triangles.

    Six-node triangles have 5/3, seven-node triangles less than 2; facets of nine columns may be triangles.
    """
    return {4: 1.0, 8: 3.0, 9: 2.0}[n_columns]


@cache
def _to_quarters(n_columns: int) -> Array:
    """From nodal values (n_columns,) of a quadratic quadrilateral to Bernstein coefficients (4, 9) of its quarters."""
    grid, to_bernstein = _bernstein(2)
    local = (0.5 * QUAD_CORNERS[:, None] + 0.5 * grid).reshape(-1, 2)
    N = facet_shapes(n_columns, np.zeros(len(local), bool), local)[0].reshape(4, 9, n_columns)
    return np.asarray(to_bernstein @ N)


def part_displacements(surface: FacetSurface, displacement: Array) -> Array:
    """Upper bound (n_parts,) of the displacement of any point of a part, from those of the nodes (n_points, 3).

    On a quarter of a quadratic facet it is no larger than the largest Bernstein coefficient. Elsewhere |u| <= |m| + L
    max |u_a - m| with the mean m of the nodes: shape functions sum to one, and only the rest is enlarged by the
    Lebesgue constant L.
    """
    u = displacement[surface.facets]
    if len(parts_of(surface).owner) > len(u):
        return np.linalg.norm(_to_quarters(u.shape[1]) @ u[:, None], axis=3).max(axis=2).ravel()
    mean = u.mean(axis=1)
    rest = np.linalg.norm(u - mean[:, None], axis=2).max(axis=1)
    return np.asarray(np.linalg.norm(mean, axis=1) + lebesgue(surface.facets.shape[1]) * rest)


def facet_displacements(surface: FacetSurface, displacement: Array) -> Array:
    """The same for whole facets (n_facets,)."""
    return part_displacements(surface, displacement).reshape(len(surface.facets), -1).max(axis=1)
