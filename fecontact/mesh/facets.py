"""Integrals over curved facets: nodal areas and vector area elements."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fecontact.mesh.reference import quad_quadrature, quad_shapes

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def facet_integrals(points: Array, facets: IntArray, order: int = 5) -> tuple[Array, Array, Array]:
    """Shape functions and vector area elements of curved facets at Gauss points.

    Facets are integrated by a rule of our own because scikit-fem's `FacetBasis` inverts the curved mapping by Newton
    with an absolute tolerance.

    Parameters
    ----------
    points : (n_points, 3) array
    facets : (n_facets, 4 | 8 | 9) int array

    Returns
    -------
    N : (n_q, n_nodes) array
    x : (n_facets, n_q, 3) array
        Positions.
    dA : (n_facets, n_q, 3) array
        Outward normal times area times quadrature weight.
    """
    X, W = quad_quadrature(order)
    N, dN = quad_shapes(facets.shape[1], X)
    nodes = points[facets]
    x = np.einsum("qa,fai->fqi", N, nodes)
    tangents = np.einsum("qaj,fai->fqij", dN, nodes)
    dA = np.cross(tangents[..., 0], tangents[..., 1]) * W[:, None]
    return N, x, dA


def nodal_areas(points: Array, facets: IntArray) -> Array:
    """Consistent nodal weights (n_points,) of a surface, the integrals of its shape functions.

    On a plane nine-node face they are 1/36, 4/36 and 16/36 of its area; on an eight-node face the corners get -1/12.
    """
    N, _, dA = facet_integrals(points, facets)
    weights = np.zeros(len(points))
    np.add.at(weights, facets, np.einsum("qa,fq->fa", N, np.linalg.norm(dA, axis=2)))
    return weights


def tributary_areas(points: Array, facets: IntArray) -> Array:
    """Positive nodal areas (n_points,): each facet's area shared in proportion to the diagonal of its mass matrix.

    For an eight-node face, whose consistent weights are negative at the corners (Hinton, Rock & Zienkiewicz 1976).
    """
    N, _, dA = facet_integrals(points, facets)
    area = np.linalg.norm(dA, axis=2)
    diagonal = np.einsum("qa,qa,fq->fa", N, N, area)
    shares = diagonal / diagonal.sum(axis=1, keepdims=True) * area.sum(axis=1, keepdims=True)
    weights = np.zeros(len(points))
    np.add.at(weights, facets, shares)
    return weights
