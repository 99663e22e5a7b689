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
from fecontact.mesh.facets import facet_shapes, triangular
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.surfaces.facet_surface import FacetSurface

#: Multipliers times biquadratic functions on parallelograms: polynomials of degree six on the triangles of a segment.
ORDER = 6
#: Twice the area of a piece, in a facet's coordinates, that is rounding.
SLIVER = 1e-11
#: Distance of vertices, and relative difference of areas, that is rounding.
SAME = 1e-10
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


def cut(polygon: Array, count: IntArray) -> tuple[Array, IntArray]:
    """Triangles and quadrilaterals that polygons consist of.

    The smallest triangle of three vertices in turn is cut off until four vertices are left; of equal ones that whose
    middle vertex is the lowest along one direction. Reflex vertices have triangles that are subtracted. So nothing
    depends on where a polygon's list begins, or on whether rounding made two vertices of one.

    Parameters
    ----------
    polygon : (n, most, 2) array
        Vertices, of which the first `count` (n,) of each row are valid, in either sense of rotation.

    Returns
    -------
    corners : (n_pieces, 4, 2) array
        Of pieces whose area is more than rounding, counter-clockwise where that is positive; triangles repeat the last.
    of : (n_pieces,) int array
        Polygon of each.

    Examples
    --------
    >>> house = np.array([[[0.0, 0.0], [1, 0], [1, 1], [0.5, 1.5], [0, 1]]])
    >>> corners, of = cut(house, np.array([5]))
    >>> _doubles(corners).tolist()
    [0.5, 2.0]
    """
    column = np.arange(polygon.shape[1])
    following = np.where(column + 1 < count[:, None], column + 1, 0)
    after = _taken(polygon, following)
    distinct = (column < count[:, None]) & (np.abs(after - polygon).max(axis=2) > SAME)
    turns = (_crossed(polygon - polygon[:, :1], after - polygon[:, :1]) * distinct).sum(axis=1) < 0
    # distinct vertices first, in reverse order where they are clockwise
    order = np.argsort(np.where(distinct, np.where(turns[:, None], -column, column), len(column)), axis=1)
    count = distinct.sum(axis=1)
    of = np.flatnonzero(count > 2)
    polygon, count = _taken(polygon[of], order[of]), count[of]
    pieces, owners = [], []
    while len(many := np.flatnonzero(count > 4)):
        vertices, most = polygon[many], count[many, None]
        before = _taken(vertices, np.where(column > 0, column - 1, most - 1))
        after = _taken(vertices, np.where(column + 1 < most, column + 1, 0))
        area = np.where(column < most, np.abs(_crossed(vertices - before, after - before)), np.inf)
        small = area <= (1 + SAME) * area.min(axis=1, keepdims=True) + SLIVER
        ear = np.where(small, vertices @ LOWEST, np.inf).argmin(axis=1)
        row = np.arange(len(many))
        ends = vertices[row, ear], after[row, ear]
        pieces.append(np.stack([before[row, ear], *ends, ends[1]], axis=1))
        owners.append(of[many])
        left = np.minimum(column + (column >= ear[:, None]), len(column) - 1)
        polygon[many] = _taken(vertices, left)
        count[many] -= 1
    pieces.append(_taken(polygon, np.minimum(np.arange(4), count[:, None] - 1)))
    owners.append(of)
    corners, of = np.concatenate(pieces), np.concatenate(owners)
    real = np.abs(_doubles(corners)) > SLIVER
    return corners[real], of[real]


def _taken(vertices: Array, which: IntArray) -> Array:
    """Chosen vertices (n, k, 2) of rows of vertices (n, m, 2) by their numbers (n, k)."""
    return vertices[np.arange(len(vertices))[:, None], which]


def _crossed(u: Array, v: Array) -> Array:
    """Cross products of vectors (..., 2) of the plane."""
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


def _doubles(corners: Array) -> Array:
    """Twice the signed areas (n,) of quadrilaterals (n, 4, 2)."""
    return _crossed(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])


def piece_samples(corners: Array, order: int = ORDER) -> tuple[Array, Array, IntArray]:
    """Quadrature over triangles and quadrilaterals.

    On quadrilaterals by Gauss's rule along both sides of the square that is mapped on them bilinearly. It has one point
    more than polynomials of the degree need, and its error on curved facets is then below that of the rule of this
    degree on triangles about the centre, with half as many points.

    Parameters
    ----------
    corners : (n, 4, 2) array
        See `cut`.
    order : int
        Degree of exactness of the rule.

    Returns
    -------
    local : (n_samples, 2) array
    weight : (n_samples,) array
    own : (n_samples,) int array
        Piece of each sample.

    Examples
    --------
    >>> square = np.array([[[0.0, 0], [1, 0], [1, 1], [0, 1]]])
    >>> local, weight, own = piece_samples(square)
    >>> round(float((weight * local[:, 0] ** 2 * local[:, 1] ** 3).sum()) * 12, 12)
    1.0
    """
    three = (corners[:, 3] == corners[:, 2]).all(axis=1)
    triangles, quads = np.flatnonzero(three), np.flatnonzero(~three)
    X, W = triangle_rule(order)
    corner = corners[triangles, :1]
    local = corner + np.einsum("jq,njk->nqk", X, corners[triangles, 1:3] - corner)
    weight = _doubles(corners[triangles])[:, None] * W
    U, squared = get_quadrature(RefQuad, 2 * (order // 2) + 3)
    N, slopes = facet_shapes(4, np.zeros(len(squared), bool), U.T)
    x, along_u, along_v = (rows @ corners[quads] for rows in (N, slopes[..., 0], slopes[..., 1]))
    places = np.concatenate([local.reshape(-1, 2), x.reshape(-1, 2)])
    weights = np.concatenate([weight.ravel(), (_crossed(along_u, along_v) * squared).ravel()])
    return places, weights, np.concatenate([np.repeat(triangles, len(W)), np.repeat(quads, len(squared))])


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
                local, weight, _ = piece_samples(outlines[:, [0, 1, 2, 2]])
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
