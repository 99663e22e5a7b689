"""Facets of a surface, quadrilaterals and triangles together: shape functions, areas and integrals.

Facets are one array of 4, 8 or 9 columns: corners, mid-side nodes, centre. A **triangle** is a row whose last two
corners are one node, ``a b c c  ab bc c ca  centroid``; its functions are those of the triangle of 3, 6 or 7 nodes, at
the first column of each node; repeated columns are zero. A triangle's local coordinates run over s, t >= 0, s + t <= 1,
without a singularity. For integrals and pictures the unit square is mapped onto both kinds of facets.
"""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.element.hexahedron import TRIANGLE_NODES, quad_nodes, quad_quadrature, quad_shapes, triangle_shapes

#: By number of columns: the number of a triangle's nodes, and their columns.
TRIANGLE_COLUMNS = {4: (0, 1, 2), 8: (0, 1, 2, 4, 5, 7), 9: (0, 1, 2, 4, 5, 7, 8)}


def triangular(facets: IntArray) -> Mask:
    """Mask (n_facets,) of triangles: facets whose last two corners are one node."""
    return np.asarray(facets[:, 2] == facets[:, 3])


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
    dA = np.cross(tangents[..., 0], tangents[..., 1]) * W[:, None]
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
