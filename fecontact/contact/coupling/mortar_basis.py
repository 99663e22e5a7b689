"""Multiplier basis of mortar coupling: non-negative functions that sum to one.

They are bilinear on a four-node quadrilateral and on the four quarters of a nine-node one, linear on the halves of a
section's side, and linear on a triangle of any order, with functions at its corners only (Puso, Laursen & Solberg 2008
also use multipliers of lower order than the displacements). Functions at the mid-side nodes and the centroid of
triangles pass the patch test as well, but the pressure oscillates at the edge of a contact: on two spheres of
tetrahedra, peaks of twice the true pressure. On an eight-node quadrilateral the pressure in the middle is the mean of
those of the mid-side nodes; every linear pressure is still reproduced, but the standard element, whose corners cannot
carry load, is refused unless its surface has `mortar_on_quad8`.

Constraints of multipliers at hanging nodes, for a continuous pressure where one slave facet is adjacent to two.

The displacement of a hanging node follows from others, so an independent multiplier there has no displacement to act
on: such multipliers make peaks 20 % too high where a contact covers divided sides (paraboloids of 20-node hexahedra,
`tests/verification/test_divided_hertz.py`). So the pressure along a divided side is that of the facet with the
undivided edge. It is linear on either half of the edge if there is a multiplier at its middle (`mortar_basis`), which
ties the points halfway between ends and middle by halves; on triangles and four-node facets it is linear over the whole
edge, which ties the middle as well. The functions still sum to one, so uniform pressure stays exact.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import scipy.sparse as sp
from skfem.quadrature import get_quadrature
from skfem.refdom import RefQuad, RefTri

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.element import QUAD_CORNERS, TRIANGLE_NODES, quad_nodes
from fecontact.mesh.facets import triangular
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.surfaces.facet_surface import FacetSurface

#: Multipliers times biquadratic functions on parallelograms: polynomials of degree six on the triangles of a segment.
ORDER = 6
#: Twice the area of a triangle, in a facet's coordinates, that is rounding.
SLIVER = 1e-11
#: Direction that distinguishes the vertices of a polygon; no side of a facet in its own coordinates is across it.
LOWEST = np.array([1.0, (np.sqrt(5.0) - 1) / 2])
#: The same for two triangles: linear multipliers times functions of degree three are of degree four, and the rule of
#: degree five has one point more.
TRIANGLE_ORDER = 5


def has_mortar_basis(surface: FacetSurface) -> bool:
    """Whether a surface can be the slave of a mortar coupling: all but nodes and plain eight-node quadrilaterals."""
    if surface.of_nodes:
        return False
    return surface.facets.shape[1] != 8 or surface.mortar_on_quad8 or bool(surface.triangle.all())


def multiplier_shapes(n_columns: int, triangle: Mask, local: Array) -> Array:
    """Multiplier functions at one point of each of n facets.

    Parameters
    ----------
    n_columns : int
        Columns of the facets: 3 (a side of a section), 4, 8 or 9.
    triangle : (n,) bool array
        Mask of triangles.
    local : (n, 2) array
        Local coordinates; (n, 1) on a side.

    Returns
    -------
    (n, n_columns) array
        Non-negative, with sum one; on triangles zero except at the corners.

    Examples
    --------
    >>> import numpy as np
    >>> multiplier_shapes(9, np.array([False]), np.array([[0.25, 0.5]]))[0].round(12).tolist()
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.5]
    >>> multiplier_shapes(4, np.array([True]), np.array([[0.5, 0.25]]))[0].round(12).tolist()
    [0.25, 0.5, 0.25, 0.0]
    """
    if n_columns == 3:
        return np.asarray(np.maximum(1.0 - 2 * np.abs(local[:, :1] - np.array([0.0, 1.0, 0.5])), 0.0))
    multipliers = np.zeros((len(local), n_columns))
    quads, triangles = np.flatnonzero(~triangle), np.flatnonzero(triangle)
    if len(quads):
        multipliers[quads] = _quad_multipliers(n_columns, local[quads])
    if len(triangles):
        x, y = local[triangles].T
        multipliers[triangles, :3] = np.maximum(np.stack([1 - x - y, x, y], axis=1), 0.0)
    return multipliers


def _quad_multipliers(n_columns: int, local: Array) -> Array:
    """Multiplier functions (n, 4 | 8 | 9) of quadrilaterals."""
    width = 1.0 if n_columns == 4 else 0.5
    nodes = quad_nodes(9 if n_columns == 8 else n_columns)
    places, column = np.unique(nodes, return_inverse=True)
    along_s, along_t = np.maximum(1.0 - np.abs(local.T[:, :, None] - places) / width, 0.0)
    column = column.reshape(nodes.shape)
    multipliers = along_s[:, column[:, 0]] * along_t[:, column[:, 1]]
    if n_columns == 8:
        multipliers[:, 4:8] += multipliers[:, 8:] / 4
    return multipliers[:, :n_columns]


def multipliers_on_square(facets: IntArray, X: Array) -> Array:
    """Multiplier functions (n_facets, n_q, n_columns) of all facets at points (n_q, 2) of the unit square.

    The square is mapped onto triangles as in `mesh.facets.shapes_on_square`.
    """
    s, t = X.T
    out = []
    for kind, local in ((False, X), (True, np.stack([s * (1 - t), t], axis=1))):
        out.append(multiplier_shapes(facets.shape[1], np.full(len(X), kind), local))
    return np.asarray(np.where(triangular(facets)[:, None, None], out[1], out[0]))


@cache
def sub_faces(n_columns: int, triangle: bool) -> Array:
    """Convex outlines (n_sub, 4 | 3, 2), counter-clockwise, of the parts of a facet with smooth multipliers."""
    if triangle:
        return TRIANGLE_NODES[None, :3].copy()
    if n_columns == 4:
        return QUAD_CORNERS[None].copy()
    return np.asarray(0.5 * QUAD_CORNERS[:, None, :] + 0.5 * QUAD_CORNERS[None, :, :])


def triangle_rule(order: int) -> tuple[Array, Array]:
    """Points (2, n) and weights (n,) on the reference triangle, exact to `order`; above 19 that rule on its quarters.

    Examples
    --------
    >>> X, W = triangle_rule(30)
    >>> abs(float((W * X[0] ** 19).sum()) * 20 * 21 - 1) < 1e-12
    True
    """
    X, W = get_quadrature(RefTri, min(order, 19))
    if order < 20:
        return X, W
    half = X / 2
    corners = [half + np.array([[s], [t]]) for s, t in ((0.0, 0.0), (0.5, 0.0), (0.0, 0.5))]
    return np.concatenate([*corners, 0.5 - half], axis=1), np.tile(W / 4, 4)


def fans(polygon: Array, count: IntArray, about_centre: Mask) -> tuple[Array, Array, IntArray]:
    """Fans of triangles of polygons; signed areas, so that reflex parts cancel.

    Fans begin at the centre of area, which is the same in a mirror image, or, where quadrature is exact on any triangle
    and fewer are quicker, at the vertex that is lowest along one direction: wherever a polygon's list begins and
    whether rounding made two vertices of one.

    Parameters
    ----------
    polygon : (n, most, 2) array
        Vertices, of which the first `count` (n,) of each row are valid.
    about_centre : (n,) bool array
        Polygons whose fans begin at the centre.

    Returns
    -------
    triangle : (n_triangles, 3, 2) array
        Corners of triangles whose area is more than rounding.
    double : (n_triangles,) array
        Twice their areas; their sum is positive for each polygon.
    piece : (n_triangles,) int array
        Polygon of each triangle.
    """
    column = np.arange(polygon.shape[1])
    valid = column < count[:, None]
    following = np.where(column + 1 < count[:, None], column + 1, 0)
    after = np.take_along_axis(polygon, following[:, :, None], axis=1)
    lowest = np.where(valid, polygon @ LOWEST, np.inf).argmin(axis=1)
    apex = np.take_along_axis(polygon, lowest[:, None, None], axis=1)
    double = _doubles(apex, polygon, after) * valid
    central = about_centre & (np.abs(double.sum(axis=1)) > SLIVER)
    if central.any():
        b, c, share = polygon[central], after[central], double[central] / double[central].sum(axis=1, keepdims=True)
        # of the apex, b and c; the sum of shares is one
        apex[central] = (apex[central] + np.einsum("nk,nkj->nj", share, b + c)[:, None]) / 3
        double[central] = _doubles(apex[central], b, c) * valid[central]
    double *= np.where(double.sum(axis=1) < 0, -1.0, 1.0)[:, None]
    piece, fan = np.nonzero(np.abs(double) > SLIVER)
    triangle = np.stack([apex[piece, 0], polygon[piece, fan], after[piece, fan]], axis=1)
    return triangle, double[piece, fan], piece


def _doubles(a: Array, b: Array, c: Array) -> Array:
    """Twice the signed areas (n, k) of triangles of vertices (n, 1 | k, 2)."""
    return np.asarray((b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0])


def triangle_samples(triangle: Array, double: Array, order: int = ORDER) -> tuple[Array, Array, IntArray]:
    """Quadrature over triangles.

    Parameters
    ----------
    triangle : (n, 3, 2) array
        Corners.
    double : (n,) array
        Twice their areas.
    order : int
        Degree of exactness of the rule.

    Returns
    -------
    local : (n_samples, 2) array
    weight : (n_samples,) array
    own : (n_samples,) int array
        Triangle of each sample.

    Examples
    --------
    >>> square = np.array([[[0.0, 0], [1, 0], [1, 1], [0, 1]]])
    >>> triangle, double, piece = fans(square, np.array([4]), np.array([True]))
    >>> local, weight, own = triangle_samples(triangle, double)
    >>> round(float((weight * local[:, 0] ** 2 * local[:, 1] ** 3).sum()) * 12, 12)
    1.0
    """
    X, W = triangle_rule(order)
    corner = triangle[:, :1]
    local = corner + np.einsum("jq,njk->nqk", X, triangle[:, 1:] - corner)
    weight = double[:, None] * W[None, :]
    return local.reshape(-1, 2), weight.ravel(), np.repeat(np.arange(len(triangle)), len(W))


def own_samples(facets: IntArray) -> tuple[IntArray, Array, Array]:
    """Quadrature over whole facets: facet (n,), coordinates (n, 2) and weights (n,).

    On squares by Gauss's rule along both sides: halves along a diagonal would follow the numbering of corners.
    """
    triangle = triangular(facets)
    parts = []
    for kind in (False, True):
        members = np.flatnonzero(triangle == kind)
        if len(members):
            outlines = sub_faces(facets.shape[1], kind)
            if kind:
                triangle_of, double, _ = fans(
                    outlines, np.full(len(outlines), outlines.shape[1]), np.zeros(len(outlines), bool)
                )
                local, weight, _ = triangle_samples(triangle_of, double)
            else:
                X, W = get_quadrature(RefQuad, ORDER)
                sides = outlines[0, 2] - outlines[0, 0]
                local = (outlines[:, :1] + X.T * sides).reshape(-1, 2)
                weight = np.tile(W * sides.prod(), len(outlines))
            n = len(members)
            parts.append((np.repeat(members, len(local)), np.tile(local, (n, 1)), np.tile(weight, n)))
    facet, local, weight = (np.concatenate(p) for p in zip(*parts, strict=True))
    return facet, local, weight


def tied_multipliers(surface: FacetSurface) -> sp.csr_matrix | None:
    """Matrix (n_nodes, n_nodes) from free multipliers to all; columns of tied ones are empty.

    None where no node is tied.
    """
    return surface.once(_tied_multipliers)


def _tied_multipliers(surface: FacetSurface) -> sp.csr_matrix | None:
    ties = surface.ties
    if ties is None:
        return None
    a, middle, b, near_a, near_b = ties.edges.T
    linear = np.full(len(a), surface.facets.shape[1] == 4)
    linear |= (ties.whole >= 0) & surface.triangle[ties.whole // 4]
    halves = np.concatenate(
        [np.stack([near_a, a, middle]), np.stack([near_b, middle, b]), np.stack([middle, a, b])[:, linear]], axis=1
    )
    nodes, *ends = halves[:, np.isin(halves, surface.nodes).all(axis=0)]
    row, half = np.tile(np.arange(len(nodes)), 2), np.full(2 * len(nodes), 0.5)
    weights = sp.csr_matrix((half, (row, np.concatenate(ends))), shape=(len(nodes), len(surface.points)))
    # the middle of an edge may be an end of another one
    tied = HangingNodes.closed(nodes, weights)
    free = sp.csr_matrix((np.ones(len(tied.free)), (np.arange(len(tied.free)), tied.free)), tied.transform.shape[::-1])
    return sp.csr_matrix(tied.transform @ free)
