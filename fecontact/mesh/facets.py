"""Facets of a surface, quadrilaterals and triangles together: shape functions, areas and integrals.

Facets are one array of 4, 8 or 9 columns: corners, mid-side nodes, centre. A **triangle** is a row whose last two
corners are one node, ``a b c c  ab bc c ca  centroid``; its functions are those of the triangle of 3, 6 or 7 nodes, at
the first column of each node; repeated columns are zero. A triangle's local coordinates run over s, t >= 0, s + t <= 1,
without a singularity. For integrals and pictures the unit square is mapped onto both kinds of facets.

Edges and faces of cells as integer keys, equal for the same edge or face, for fast sorting and searching.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from fecontact.common.arrays import Array, IntArray, Mask, cross
from fecontact.mesh.element import FACES, TRIANGLE_NODES, quad_nodes, quad_quadrature, quad_shapes, triangle_shapes

#: By number of columns: the number of a triangle's nodes, and their columns.
TRIANGLE_COLUMNS = {4: (0, 1, 2), 8: (0, 1, 2, 4, 5, 7), 9: (0, 1, 2, 4, 5, 7, 8)}


def triangular(facets: IntArray) -> Mask:
    """Mask (n_facets,) of triangles: facets whose last two corners are one node."""
    return np.asarray(facets[:, 2] == facets[:, 3])


def sides_of(facets: IntArray) -> IntArray:
    """Directed ends (n_facets, k, 2) of the sides of facets (n_facets, at least k), with k = 4, or 3 of three columns.

    The third side of a triangle of four columns has one node twice.

    Examples
    --------
    >>> sides_of(np.array([[5, 6, 7, 7]])).tolist()
    [[[5, 6], [6, 7], [7, 7], [7, 5]]]
    """
    corners = facets[:, :4]
    return np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)


def distinct_columns(facets: IntArray) -> Mask:
    """Mask (n_facets, n_columns) of the first column of each node of a facet."""
    distinct = np.ones(facets.shape, bool)
    others = np.setdiff1d(np.arange(facets.shape[1]), TRIANGLE_COLUMNS[facets.shape[1]])
    distinct[np.ix_(np.flatnonzero(triangular(facets)), others)] = False
    return distinct


def facet_shapes(n_columns: int, triangle: Mask, X: Array) -> tuple[Array, Array]:
    """Shape functions at one point of each of n facets.

    Parameters
    ----------
    n_columns : int
        4, 8 or 9.
    triangle : (n,) bool array
        Whether the facet is a triangle.
    X : (n, 2) array
        Local coordinates.

    Returns
    -------
    N : (n, n_columns) array
    dN : (n, n_columns, 2) array

    Examples
    --------
    >>> import numpy as np
    >>> facet_shapes(4, np.array([True]), np.array([[0.5, 0.25]]))[0].tolist()
    [[0.25, 0.5, 0.25, 0.0]]
    """
    if not triangle.any():
        return quad_shapes(n_columns, X)
    columns = list(TRIANGLE_COLUMNS[n_columns])
    N, dN = np.zeros((len(X), n_columns)), np.zeros((len(X), n_columns, 2))
    if not triangle.all():
        N[~triangle], dN[~triangle] = quad_shapes(n_columns, X[~triangle])
    rows = np.flatnonzero(triangle)
    N[np.ix_(rows, np.array(columns))], dN[np.ix_(rows, np.array(columns))] = triangle_shapes(len(columns), X[rows])
    return N, dN


def facet_nodes(n_columns: int, triangle: bool) -> Array:
    """Local coordinates (n_columns, 2) of a facet's nodes; repeated columns of a triangle are at its last corner."""
    if not triangle:
        return quad_nodes(n_columns)
    columns = list(TRIANGLE_COLUMNS[n_columns])
    X = np.tile(TRIANGLE_NODES[2], (n_columns, 1))
    X[columns] = TRIANGLE_NODES[: len(columns)]
    return X


def facet_centres(triangle: Mask) -> Array:
    """Local coordinates (n, 2) of the middles of n facets."""
    return np.where(triangle[:, None], 1 / 3, 0.5) * np.ones((len(triangle), 2))


def shapes_on_square(facets: IntArray, X: Array) -> tuple[Array, Array]:
    """Shape functions of all facets at the same points of the unit square.

    For a triangle the upper side of the square is collapsed to the last corner: (s, t) -> (s (1 - t), t).

    Parameters
    ----------
    facets : (n_facets, 4 | 8 | 9) int array
    X : (n_q, 2) array
        Points of the unit square.

    Returns
    -------
    N : (n_facets, n_q, n_columns) array
    dN : (n_facets, n_q, n_columns, 2) array
        With respect to the square's coordinates.
    """
    triangle = triangular(facets)
    k, shape = facets.shape[1], (len(facets), len(X), facets.shape[1])
    N, dN = quad_shapes(k, X)
    if not triangle.any():
        return np.broadcast_to(N, shape), np.broadcast_to(dN, (*shape, 2))
    s, t = X.T
    N3, dN3 = facet_shapes(k, np.ones(len(X), bool), np.stack([s * (1 - t), t], axis=1))
    dN3 = np.stack([dN3[..., 0] * (1 - t)[:, None], dN3[..., 1] - dN3[..., 0] * s[:, None]], axis=-1)
    return np.where(triangle[:, None, None], N3, N), np.where(triangle[:, None, None, None], dN3, dN)


def facet_integrals(points: Array, facets: IntArray, order: int = 5) -> tuple[Array, Array, Array]:
    """Shape functions and vector area elements of curved facets at Gauss points.

    scikit-fem's `FacetBasis` is not used: it inverts the curved mapping by Newton with an absolute tolerance. On a flat
    triangle the rule is exact to a degree one below `order`.

    Parameters
    ----------
    points : (n_points, 3) array
    facets : (n_facets, 4 | 8 | 9) int array

    Returns
    -------
    N : (n_facets, n_q, n_columns) array
    x : (n_facets, n_q, 3) array
        Positions.
    dA : (n_facets, n_q, 3) array
        Outward normal times area times quadrature weight.
    """
    X, W = quad_quadrature(order)
    N, dN = shapes_on_square(facets, X)
    nodes = points[facets]
    x = N @ nodes
    tangents = np.einsum("fqaj,fai->fqij", dN, nodes, optimize=True)
    dA = cross(tangents[..., 0], tangents[..., 1]) * W[:, None]
    return N, x, dA


def nodal_areas(points: Array, facets: IntArray) -> Array:
    """Consistent nodal weights (n_points,) of a surface, the integrals of its shape functions.

    On a plane nine-node face they are 1/36, 4/36 and 16/36 of its area, on a triangle with a centroid node 1/20, 2/15
    and 9/20; on an eight-node face the corners get -1/12, on a six-node triangle 0.
    """
    N, _, dA = facet_integrals(points, facets)
    weights = np.zeros(len(points))
    np.add.at(weights, facets, np.einsum("fqa,fq->fa", N, np.linalg.norm(dA, axis=2)))
    return weights


def tributary_areas(points: Array, facets: IntArray) -> Array:
    """Positive nodal areas (n_points,): each facet's area shared in proportion to the diagonal of its mass matrix.

    For facets without a centre node, whose consistent weights are negative or zero at the corners (Hinton, Rock &
    Zienkiewicz 1976).
    """
    N, _, dA = facet_integrals(points, facets)
    area = np.linalg.norm(dA, axis=2)
    diagonal = np.einsum("fqa,fqa,fq->fa", N, N, area)
    shares = diagonal / diagonal.sum(axis=1, keepdims=True) * area.sum(axis=1, keepdims=True)
    weights = np.zeros(len(points))
    np.add.at(weights, facets, shares)
    return weights


def numbered_between(corners: IntArray, n_points: int, given: IntArray | None = None) -> tuple[IntArray, IntArray]:
    """Numbers (n,) of the nodes between corners (n, k) of edges or faces, and the corners (m, k) of those that are new.

    A node is the one given for it or for the same corners elsewhere (-1 for none), the corner that all of them are, or
    a new one, numbered from `n_points`.

    Examples
    --------
    >>> numbered_between(np.array([[0, 1], [1, 0], [2, 2], [1, 2]]), 5)[0].tolist()
    [5, 5, 2, 6]
    """
    distinct, inverse = np.unique(np.sort(corners, axis=1), axis=0, return_inverse=True)
    inverse = inverse.ravel()
    known = np.where(distinct[:, 0] == distinct[:, -1], distinct[:, 0], -1)
    if given is not None:
        known[inverse[given >= 0]] = given[given >= 0]
    new = np.flatnonzero(known < 0)
    known[new] = n_points + np.arange(len(new))
    return known[inverse] if given is None else np.where(given >= 0, given, known[inverse]), distinct[new]


def components(n: int, pairs: IntArray) -> IntArray:
    """Number of the connected part (n,) of each of n things, joined in pairs (k, 2).

    Examples
    --------
    >>> components(4, np.array([[0, 2]])).tolist()
    [0, 1, 0, 2]
    """
    graph = sp.coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def parts_of_points(cells: IntArray, n_points: int) -> IntArray:
    """Number of the connected part (n_points,) of each point, joined by the cells (n, width) that have it.

    Examples
    --------
    >>> parts_of_points(np.array([[0, 3], [3, 1]]), 4).tolist()
    [0, 0, 1, 0]
    """
    n, width = cells.shape
    pairs = np.stack([np.repeat(np.arange(n), width), n + cells.ravel()], axis=1)
    return components(n + n_points, pairs)[n:]


#: Odd constants (fractional parts of square roots) to hash the corners of a face into one number.
MIX = np.array([0x6A09E667F3BCC909, 0xBB67AE8584CAA73B, 0x3C6EF372FE94F82B, 0xA54FF53A5F1D36F1], dtype=np.uint64)

Keys = NDArray[np.uint64]


def edge_keys(ends: IntArray) -> Keys:
    """Keys (...) of edges with ends (..., 2), in either order.

    Examples
    --------
    >>> bool(edge_keys(np.array([3, 5])) == edge_keys(np.array([5, 3])))
    True
    """
    low, high = ends.min(axis=-1).astype(np.uint64), ends.max(axis=-1).astype(np.uint64)
    return np.asarray((low << np.uint64(32)) | high)


def corner_keys(corners: IntArray) -> IntArray:
    """Sorted corners (n, 4) of faces, equal for equal faces.

    A triangle may list a different one of its corners twice in each of its two cells, so the largest is repeated. Faces
    collapsed to a line or a point get -1.
    """
    ordered = np.sort(corners, axis=1)
    first = np.concatenate([np.ones((len(ordered), 1), bool), ordered[:, 1:] != ordered[:, :-1]], axis=1)
    count = first.sum(axis=1)
    triangle = count == 3
    three = ordered[triangle][first[triangle]].reshape(-1, 3)
    ordered[triangle] = np.concatenate([three, three[:, -1:]], axis=1)
    ordered[count < 3] = -1
    return ordered


def face_keys(corners: IntArray) -> Keys:
    """Keys (...) of faces with corners (..., 4), in any order; 0 for faces collapsed to a line or a point.

    Hashes (sums of sorted corners times odd constants modulo 2^64) sort ten times faster than rows of corners.
    """
    keys = corner_keys(corners.reshape(-1, 4))
    mixed = (keys.astype(np.uint64) * MIX).sum(axis=1, dtype=np.uint64)
    return np.where(keys[:, 0] < 0, np.uint64(0), mixed).reshape(corners.shape[:-1])


def cells_at_faces(cells: IntArray) -> IntArray:
    """Number of cells at each face (n_cells, 6); 0 where the face has collapsed to a line or a point."""
    keys = face_keys(cells[:, FACES[:, :4]])
    _, inverse, count = np.unique(keys, return_inverse=True, return_counts=True)
    return np.where(keys == 0, 0, count[inverse].reshape(keys.shape))


def facets_at_sides(facets: IntArray) -> IntArray:
    """Number of facets at each side (n_facets, k) of `sides_of`; 0 where both ends are one node.

    Examples
    --------
    >>> facets_at_sides(np.array([[0, 1, 2, 3], [1, 4, 2, 2]])).tolist()
    [[1, 2, 1, 1], [1, 1, 0, 2]]
    """
    ends = sides_of(facets)
    _, inverse, count = np.unique(edge_keys(ends), return_inverse=True, return_counts=True)
    return np.where(ends[..., 0] == ends[..., 1], 0, count[inverse.reshape(ends.shape[:2])])


def found(keys: Keys, among: Keys) -> IntArray:
    """Index of each of the keys (...) in `among` (n,); -1 if it is not there.

    Examples
    --------
    >>> found(np.array([4, 9], dtype=np.uint64), np.array([7, 4, 2], dtype=np.uint64)).tolist()
    [1, -1]
    """
    if len(among) == 0:
        return np.full(keys.shape, -1)
    order = np.argsort(among)
    place = order[np.minimum(np.searchsorted(among, keys, sorter=order), len(among) - 1)]
    return np.where(among[place] == keys, place, -1)


def places_among(members: IntArray, n: int) -> IntArray:
    """Place of each of 0 ... n - 1 among distinct members; -1 for those that are none.

    Examples
    --------
    >>> places_among(np.array([2, 0]), 4).tolist()
    [1, -1, 0, -1]
    """
    place = np.full(n, -1, dtype=np.int64)
    place[members] = np.arange(len(members))
    return place


def unit_vectors(vectors: Array) -> Array:
    """Vectors (..., k) over their lengths; zero where these are.

    Examples
    --------
    >>> unit_vectors(np.array([[3.0, 4.0], [0.0, 0.0]])).tolist()
    [[0.6, 0.8], [0.0, 0.0]]
    """
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))
