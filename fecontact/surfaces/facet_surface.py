"""Surfaces of linear or quadratic facets, quadrilaterals and triangles, and projection of points on them.

The closest point on a curved facet is found by Newton's method, for all points and their nearby facets at once.

Contact forces act at nodes that do not hang. The areas of hanging nodes are added to the nodes they follow from, by the
weights of the ties: the integral of the functions of the free nodes, so that a uniform pressure stays exact. Pressures
at hanging nodes are interpolated like displacements (`mesh.hanging_nodes`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, Self, TypeVar, cast

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from fecontact.common.arrays import Array, IntArray, Mask, cross
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import MeshError
from fecontact.mesh.facets import edge_keys, facet_shapes, facets_at_sides, found, sides_of, triangular
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.mesh.section_mesh import Extent
from fecontact.mesh.surface_mesh import averaged_normals
from fecontact.surfaces.closest_point import FacetPolynomials, FlatFacets, facet_polynomials, shapes_at

T = TypeVar("T")


#: Tangential offset, relative to the surface's size, below which it is rounding: coordinates are accurate to 1e-16 of
#: it.
SHORTEST_OFFSET = 1e-12
#: Difference of distances, relative to them and to a facet, below which facets are equally near: by rounding and by the
#: steps of Newton's method.
EQUAL = 1e-12
#: Most parts into which a side of a slender facet is divided for the search of the nearest facets.
MAX_PARTS = 256
#: Distance from a side, in a facet's coordinates, that counts as on it, and what a corner's function may lack of one.
BESIDE, CORNER = 1e-9, 1e-8
#: Sine of the angle between offset and normal above which a point whose closest point is on the rim lies outside.
RIM_LEAN = 0.2
#: Cosine between a facet's normal and the average at its node below which the node lies on a sharp edge.
SHARP = 0.9


@compact_repr
@dataclass(frozen=True, eq=False)
class Projection:
    """Closest points of n points on a surface, in the surface's own axes.

    Attributes
    ----------
    points : (n, 3) array
        The closest points.
    normals : (n, 3) array
        Outward unit vectors along the line from closest point to point: the surface's normals there.
    gap : (n,) array
        Signed distance along the normal; negative inside the body.
    outside : (n,) bool array
        Whether the closest point is on the rim of the surface and the given point outside the rim.
    weights : (n, n_nodes) csr_matrix, optional
        Interpolation from the mesh nodes; None for a surface without nodes.
    facet, local : (n,) and (n, 2) arrays, optional
        Facet, and coordinates on it.
    surface : str
        Name of the surface of these facets.
    """

    points: Array
    normals: Array
    gap: Array
    outside: Mask
    weights: sp.csr_matrix | None = None
    facet: IntArray | None = None
    local: Array | None = None
    surface: str = ""

    def chosen(self, kept: IntArray) -> Projection:
        """A subset of the closest points."""
        given = {name: value for name, value in vars(self).items() if name != "surface" and value is not None}
        return replace(self, **{name: value[kept] for name, value in given.items()})


class Surface(Protocol):
    """A surface on which points can be projected."""

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3) given in the surface's axes."""


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
    mortar_on_quad8 : bool
        Whether eight-node facets can carry a multiplier basis, because their displacements have bubble functions; see
        `contact.coupling.mortar_basis`.
    planes : ((k,) int array, (k, 3) array), optional
        Nodes on planes of symmetry and the normals of these planes; a node on two of them is listed twice.
    hanging : HangingNodes, optional
        Of the mesh, see `mesh.hanging_nodes`.
    alone : (k,) int array, optional
        Of a set of nodes, which touch with a force each: these; the facets are those round them.
    """

    points: Array
    facets: IntArray
    name: str = "surface"
    mortar_on_quad8: bool = False
    planes: tuple[IntArray, Array] | None = None
    hanging: HangingNodes | None = None
    alone: IntArray | None = None

    @property
    def of_nodes(self) -> bool:
        """Whether it is a set of nodes, whose forces are no field of pressure."""
        return self.alone is not None

    @cached_property
    def nodes(self) -> IntArray:
        """Distinct node numbers of the surface."""
        return self.of_facets if self.alone is None else self.alone

    @cached_property
    def of_facets(self) -> IntArray:
        """Distinct nodes of its facets."""
        return np.unique(self.facets)

    @cached_property
    def ties(self) -> SurfaceTies | None:
        """The hanging nodes among its own; None where there are none."""
        return None if self.of_nodes else surface_ties(self.facets, self.hanging)

    @property
    def out_of_plane(self) -> Extent | None:
        """Out-of-plane extent of the section for a curve; None for facets in space."""
        return None

    @property
    def revolved(self) -> bool:
        """Whether it is a curve of a body of revolution."""
        return self.out_of_plane is not None and self.out_of_plane.revolved

    @property
    def cell_area(self) -> float | None:
        """Area of a node's cell, if equal for all nodes and each responds along its own normal only; else None."""
        return None

    @property
    def is_divisible(self) -> bool:
        """Whether the parts near contact can be paired alone."""
        return not (self.mortar_on_quad8 or self.of_nodes)

    def cut(
        self, master: Surface | None, rotation: Array, translation: Array, share: float
    ) -> tuple[IntArray, Array, Array] | None:
        """Samples on segments of a section's sides, see `section_curve.curve_samples`; None for facets in space."""
        return None

    @property
    def spatial(self) -> FacetSurface:
        """Facets in space on which points are projected: the surface itself, or the ribbon of a section's curve."""
        return self

    def moved(self, rotation: Array, translation: Array) -> Self:
        """The surface in other axes, rotated and translated."""
        planes = None if self.planes is None else (self.planes[0], self.planes[1] @ rotation.T)
        return replace(self, points=self.points @ rotation.T + translation, planes=planes)

    @cached_property
    def triangle(self) -> Mask:
        """Mask (n_facets,) of triangles."""
        return triangular(self.facets)

    @cached_property
    def _known(self) -> dict[object, object]:
        return {}

    def once(self, work_out: Callable[[FacetSurface], T]) -> T:
        """Cached result of a function of this surface alone."""
        if work_out not in self._known:
            self._known[work_out] = work_out(self)
        return cast(T, self._known[work_out])

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.points[self.facets].reshape(-1, 3), axis=0)))

    @cached_property
    def mean_facet_size(self) -> Array:
        """Square root of the approximate area (n_facets,) of each facet."""
        corners = self.points[self.facets[:, :4]]
        diagonals = corners[:, [2, 3]] - corners[:, [0, 1]]
        return np.sqrt(np.linalg.norm(cross(diagonals[:, 0], diagonals[:, 1]), axis=1) / 2)

    @cached_property
    def tree(self) -> cKDTree:
        """Search tree of its nodes."""
        return cKDTree(self.points[self.of_facets])

    @cached_property
    def facets_of_node(self) -> IntArray:
        """Facets around each surface node (n_surface_nodes, most), padded by repeating the first.

        A facet with a hanging node on its undivided side is around that node too.
        """
        nodes = self.of_facets
        local = np.searchsorted(nodes, self.facets.ravel())
        owner = np.repeat(np.arange(len(self.facets)), self.facets.shape[1])
        if self.ties is not None:
            node, facet = self.ties.beside
            known = np.isin(node, nodes)
            local = np.concatenate([local, np.searchsorted(nodes, node[known])])
            owner = np.concatenate([owner, facet[known]])
        order = np.argsort(local, kind="stable")
        count = np.bincount(local, minlength=len(self.nodes))
        start = np.concatenate([[0], np.cumsum(count)[:-1]])
        column = np.arange(count.max())[None, :]
        return owner[order][start[:, None] + np.where(column < count[:, None], column, 0)]

    @cached_property
    def along_slender(self) -> tuple[cKDTree, IntArray] | None:
        """Search tree of places along the sides of slender facets, and the facets (n, 2) beside each; None without any.

        The nodes nearest to a point of a slender facet need not be its own, nor those of its neighbours.
        """
        ends = np.sort(sides_of(self.facets).reshape(-1, 2), axis=1)
        length = np.linalg.norm(np.diff(self.points[ends], axis=1)[:, 0], axis=1).reshape(-1, 4)
        longest = length.max(axis=1, keepdims=True, initial=np.finfo(float).tiny)
        area = (1 + self.triangle) * self.mean_facet_size**2
        # twice the width is as far apart as they are
        parts = np.ceil(length / np.maximum(2 * area[:, None] / longest, longest / MAX_PARTS))
        if parts.max(initial=0) <= 2:
            return None
        sides, which = np.unique(ends, axis=0, return_inverse=True)
        order = np.argsort(which.ravel(), kind="stable")
        first = np.searchsorted(which.ravel()[order], np.arange(len(sides)))
        owner, most = order // 4, np.maximum.reduceat(parts.ravel()[order], first).astype(np.int64)
        each = np.repeat(np.arange(len(sides)), np.where(most > 2, most - 1, 0))
        share = (np.arange(len(each)) - np.searchsorted(each, each) + 1) / most[each]
        start, end = self.points[sides[each]].swapaxes(0, 1)
        beside = np.stack([owner[first], owner[np.append(first[1:], len(owner)) - 1]], axis=1)
        return cKDTree(start + share[:, None] * (end - start)), beside[each]

    @cached_property
    def on_rim(self) -> Mask:
        """Mask (n_facets, 4) of the facets' sides that belong to no other facet; never the missing one of triangles."""
        alone = facets_at_sides(self.facets) == 1
        if self.ties is not None:
            alone.flat[self.ties.inner_sides] = False
        return alone

    @cached_property
    def rim_nodes(self) -> Mask:
        """Mask of mesh nodes (n_nodes,) on the surface's rim."""
        facet, side = self.rim_sides
        ends = [self.facets[facet, side], self.facets[facet, (side + 1) % 4]]
        if self.facets.shape[1] > 4:
            ends.append(self.facets[facet, 4 + side])
        out = np.zeros(len(self.points), bool)
        out[np.concatenate(ends)] = True
        return out

    @property
    def rim_sides(self) -> tuple[IntArray, IntArray]:
        """Facets (n,) and sides (n,) on the rim."""
        facet, side = np.nonzero(self.on_rim)
        return facet, side

    def extent(self, points: Array) -> Array:
        """Weight (n,) of a piece of area at points (n, 3): one, or the out-of-plane extent of a section."""
        return np.ones(len(points))

    def evaluate(self, facet: IntArray, local: Array) -> tuple[Array, Array, Array]:
        """Positions (n, 3), tangents (n, 3, 2) and shape functions (n, k) at facet coordinates."""
        triangle, degree = self.triangle[facet], self.polynomials.degree
        shapes = shapes_at(self.facets.shape[1], triangle, degree, local)
        return *self.polynomials.evaluate(facet, local), shapes

    def slopes(self, facet: IntArray, local: Array) -> Array:
        """Derivatives (n, k, 2) of the shape functions by facet coordinates."""
        return facet_shapes(self.facets.shape[1], self.triangle[facet], local)[1]

    @cached_property
    def polynomials(self) -> FacetPolynomials:
        """The facets as polynomials."""
        return facet_polynomials(self.points, self.facets, self.triangle)

    @cached_property
    def _flat(self) -> FlatFacets:
        """The facets as flat triangles."""
        return FlatFacets.of(self.points, self.facets)

    def normals(self, facet: IntArray, local: Array) -> Array:
        """Outward unit normals (n, 3)."""
        _, tangents, _ = self.evaluate(facet, local)
        n = cross(tangents[:, :, 0], tangents[:, :, 1])
        length = np.linalg.norm(n, axis=1)
        if (length == 0).any():
            raise MeshError(
                f"Facet {facet[np.argmin(length)]} of {self.name!r} has no normal: two of its sides coincide.",
                code="no-normal",
            )
        return n / length[:, None]

    def project(self, points: Array, n_near: int = 3) -> Projection:
        """Projection of points (n, 3): the closest point over the facets round each point's `n_near` nearest nodes."""
        point, facet = self._around(points, n_near)
        kept, start = self._flat.nearest(points, point, facet)
        point, facet = point[kept], facet[kept]
        local, distance2 = self.polynomials.closest(points[point], facet, start=start)
        # the nearest facet of each point; of equal ones the first, so that shared edges are decided once
        distance, first = np.sqrt(distance2), np.searchsorted(point, np.arange(len(points)))
        least = np.minimum.reduceat(distance, first)[point]
        equal = distance <= (1 + EQUAL) * least + EQUAL * self.mean_facet_size[facet]
        best = np.minimum.reduceat(np.where(equal, np.arange(len(point)), len(point)), first)
        facet, local = facet[best], local[best]
        x, _, N = self.evaluate(facet, local)
        offset = points - x
        normals = self._lines_of_action(facet, local, N, offset)
        gap = np.einsum("ni,ni->n", offset, normals)
        outside = self._outside(facet, local, N, offset)
        return Projection(x, normals, gap, outside, self.rows_of(facet, N), facet, local, self.name)

    def facets_near(self, points: Array) -> IntArray:
        """Facets (n,) nearest to points (n, 3), or neighbours of these: by triangles through their corners."""
        point, facet = self._around(points, 3)
        distance = self._flat.closest(points[point], facet)[1]
        first = np.searchsorted(point, np.arange(len(points)))
        least = np.minimum.reduceat(distance, first)[point]
        return facet[np.minimum.reduceat(np.where(distance <= least, np.arange(len(point)), len(point)), first)]

    def _around(self, points: Array, n_near: int) -> tuple[IntArray, IntArray]:
        """Pairs (n,) of a point and a facet round one of its nearest nodes, sorted by both."""
        _, near = self.tree.query(points, k=min(n_near, len(self.of_facets)))
        around = self.facets_of_node[near.reshape(len(points), -1)].reshape(len(points), -1)
        if self.along_slender is not None:
            tree, beside = self.along_slender
            near = tree.query(points, k=n_near)[1].reshape(len(points), -1) % len(beside)
            around = np.concatenate([around, beside[near].reshape(len(points), -1)], axis=1)
        around = np.sort(around, axis=1)
        point, place = np.nonzero(np.diff(around, axis=1, prepend=-1))
        return point, around[point, place]

    def rows_of(self, facet: IntArray, N: Array) -> sp.csr_matrix:
        """Interpolation (n, n_nodes) from the mesh nodes by shape functions (n, k) of facets (n,)."""
        columns = self.facets[facet]
        pointer = np.arange(0, columns.size + 1, columns.shape[1])
        return sp.csr_matrix((N.ravel(), columns.ravel(), pointer), shape=(len(N), len(self.points)))

    @cached_property
    def mean_normals(self) -> Array:
        """Unit normals (n_nodes, 3) averaged over the facets round each surface node; zero elsewhere."""
        normals = averaged_normals(self.points, self.facets)[0]
        return normals if self.ties is None else self.ties.followed(normals)

    def smooth_normals(self, projection: Projection) -> Array:
        """Unit normals (n, 3) at closest points on it, continuous between facets."""
        assert projection.weights is not None
        mean = projection.weights @ self.mean_normals
        length = np.linalg.norm(mean, axis=1, keepdims=True)
        return np.divide(mean, length, out=projection.normals.copy(), where=length > 0)

    def _lines_of_action(self, facet: IntArray, local: Array, N: Array, offset: Array) -> Array:
        """Outward unit vectors from closest point to point: a force along them has no moment about the closest point.

        Inside a facet this is the normal. On an edge or corner between facets it can be any direction of the normal
        cone and is taken from the offset; where the offset differs from the mean normal by rounding only, the mean
        normal is taken (on a flat surface all lines are then parallel, for any length of the offsets).
        """
        normals = self.normals(facet, local)
        on_edge = self._at_sides(facet, local).any(axis=1)
        nodal, own = self.mean_normals[self.facets[facet[on_edge]]], normals[on_edge, None]
        # an average round a sharp edge is none of the normals beside it, except on that edge
        sharp = (nodal * own).sum(axis=2) < SHARP
        beside = (N[on_edge] * ~sharp).sum(axis=1) > BESIDE
        nodal = np.where((sharp & beside[:, None])[:, :, None], own, nodal)
        mean = np.einsum("na,nai->ni", N[on_edge], nodal)
        mean /= np.linalg.norm(mean, axis=1, keepdims=True)
        along = offset[on_edge]
        length = np.linalg.norm(along, axis=1)
        sideways = np.linalg.norm(along - np.einsum("ni,ni->n", along, mean)[:, None] * mean, axis=1)
        long = sideways > SHORTEST_OFFSET * self.size
        sign = np.where(np.einsum("ni,ni->n", along, mean) < 0, -1.0, 1.0)
        lines = np.divide(along, (sign * length)[:, None], out=mean.copy(), where=long[:, None])
        normals[on_edge] = lines
        return normals

    def _at_sides(self, facet: IntArray, local: Array) -> Mask:
        """Mask (n, 4) of the sides of their facet on which points lie."""
        s, t = local.T
        triangle = self.triangle[facet]
        right = np.where(triangle, s + t, s) >= 1 - BESIDE
        return np.stack([t <= BESIDE, right, ~triangle & (t >= 1 - BESIDE), s <= BESIDE], axis=1)

    def distance_to_facet(self, points: Array, facet: IntArray) -> Array:
        """Distance (n,) of each point from its given facet."""
        return np.sqrt(self.polynomials.closest(points, facet)[1])

    def _outside(self, facet: IntArray, local: Array, N: Array, offset: Array) -> Mask:
        """Whether a closest point lies on the rim and the point's offset is directed outwards across it.

        On a plane of symmetry a coarse facet's normal is slightly inclined to the plane, so a small angle is tolerated.
        A facet may reach the rim with a corner only: then its own sides do not tell, but that node.
        """
        normals = self.normals(facet, local)
        sideways = offset - np.einsum("ni,ni->n", offset, normals)[:, None] * normals
        sideways = np.linalg.norm(sideways, axis=1)
        leaning = (sideways > 1e-6 * self.mean_facet_size[facet]) & (
            sideways > RIM_LEAN * np.linalg.norm(offset, axis=1)
        )
        beside = self._at_sides(facet, local) & self.on_rim[facet]
        corner = (N[:, :4] >= 1 - CORNER) & self.rim_nodes[self.facets[facet, :4]]
        return leaning & (beside | corner).any(axis=1)


def facets_of(surface: Surface) -> FacetSurface | None:
    """The surface if it has nodes and facets, else None."""
    return surface if isinstance(surface, FacetSurface) else None


def own_facets(surface: Surface) -> FacetSurface | None:
    """Facets of a surface, those of a rigid body included; None for smooth shapes."""
    return getattr(surface, "facet_surface", None) or facets_of(surface)


def with_nodes(surface: Surface) -> FacetSurface:
    """The surface, typed as one with nodes, as every slave's is."""
    assert isinstance(surface, FacetSurface)
    return surface


def has_cells(surface: Surface) -> bool:
    """Whether a surface is the grid of a half-space."""
    facets = facets_of(surface)
    return facets is not None and facets.cell_area is not None


@dataclass(frozen=True, eq=False)
class SurfaceTies:
    """The hanging nodes of a surface.

    Attributes
    ----------
    nodes : (n,) int array
        Hanging nodes on the surface.
    weights : (n, n_points) csr_matrix
        u[nodes] = weights @ u.
    edges : (m, 5) int array
        Divided edges on the surface, as in `HangingNodes`.
    whole : (m,) int array
        Side of the facet with the undivided edge, as 4 facet + side; -1 if it is not a facet of the surface.
    halves : (m, 2) int array
        Sides of facets along the two halves, likewise.
    """

    nodes: IntArray
    weights: sp.csr_matrix
    edges: IntArray
    whole: IntArray
    halves: IntArray

    @cached_property
    def inner_sides(self) -> IntArray:
        """Sides with a facet of the surface on either side, one of them or two."""
        met = (self.whole >= 0) & (self.halves >= 0).any(axis=1)
        sides = np.concatenate([self.whole[met], self.halves[met].ravel()])
        return sides[sides >= 0]

    @cached_property
    def beside(self) -> tuple[IntArray, IntArray]:
        """Points of divided edges (k,) without their ends, and the facet (k,) with the undivided edge."""
        met = np.flatnonzero(self.whole >= 0)
        nodes, facet = self.edges[met][:, [1, 3, 4]].ravel(), np.repeat(self.whole[met] // 4, 3)
        return nodes[nodes >= 0], facet[nodes >= 0]

    def with_tied(self, nodes: Mask) -> Mask:
        """Nodes (n_points,), those along divided edges that they are tied to, and all that are tied to these."""
        ends, between = self.edges[:, [0, 2]], self.edges[:, [1, 3, 4]]
        between = np.where(between < 0, self.edges[:, 1:2], between)
        out = nodes.copy()
        out[ends[nodes[between].any(axis=1)]] = True
        while True:
            before = out.copy()
            out[between[(out[ends].any(axis=1)) | out[self.edges[:, 1]]]] = True
            if np.array_equal(before, out):
                return out

    def onto(self, lost: Mask) -> sp.csr_matrix:
        """Weights (n, n_points) of the nodes in terms of those that are not lost (n_points,).

        A row with lost nodes keeps its positive weights on the others, scaled to sum one.
        """
        kept = sp.csr_matrix(self.weights @ sp.diags((~lost).astype(float)))
        cut = abs(self.weights) @ lost.astype(float) > 0
        positive = sp.diags(cut.astype(float)) @ kept.maximum(0.0)
        total = np.asarray(positive.sum(axis=1)).ravel()
        scale = np.divide(1.0, total, out=np.zeros_like(total), where=total > 0)
        out = sp.csr_matrix(sp.diags((~cut).astype(float)) @ kept + sp.diags(scale) @ positive)
        out.eliminate_zeros()
        return out

    def followed(self, values: Array) -> Array:
        """Values (n_points, k) with those at hanging nodes interpolated from the others."""
        out = values.copy()
        out[self.nodes] = self.weights @ values
        return out

    def gathered(self, areas: Array, onto: sp.csr_matrix) -> Array:
        """Areas (n_points,) with those of hanging nodes added to others, by weights (n, n_points)."""
        out = areas.copy()
        out[self.nodes] = 0.0
        return np.asarray(out + onto.T @ areas[self.nodes])

    def at_nodes(self, nodes: IntArray, onto: sp.csr_matrix) -> sp.csr_matrix:
        """Values (n_points, k) at all nodes from those at some (k,), interpolated at hanging ones."""
        n, k = onto.shape[1], len(nodes)
        insert = sp.csr_matrix((np.ones(len(self.nodes)), (self.nodes, np.arange(len(self.nodes)))), (n, onto.shape[0]))
        own = sp.csr_matrix((np.ones(k), (nodes, np.arange(k))), shape=(n, k))
        out = sp.csr_matrix(own + insert @ onto[:, nodes])
        out.eliminate_zeros()
        return out


def surface_ties(facets: IntArray, hanging: HangingNodes | None) -> SurfaceTies | None:
    """Ties of the hanging nodes on a surface of facets (n_facets, 4 | 8 | 9); None where there are none."""
    if hanging is None:
        return None
    on = np.zeros(hanging.n_points, bool)
    on[facets] = True
    rows = np.flatnonzero(on[hanging.nodes])
    if len(rows) == 0:
        return None
    sides = edge_keys(sides_of(facets).reshape(-1, 2))
    along = found(edge_keys(hanging.edges[:, [[0, 2], [0, 1], [1, 2]]]), sides)
    there = (along >= 0).any(axis=1)
    along = along[there]
    return SurfaceTies(hanging.nodes[rows], hanging.weights[rows], hanging.edges[there], along[:, 0], along[:, 1:])
