"""Quadrature of all kinds of elements, in the hexahedron's reference coordinates.

The 27 Gauss points of the hexahedron integrate its degenerate forms too, but cluster at the coalesced edges. Wedges and
tetrahedra in the form in which meshes are read (`WEDGE`, `TETRAHEDRON`) therefore have their own rules, mapped to the
hexahedron's coordinates: 18 points for a wedge of 15 nodes (21 with centroid nodes) and 14 for a tetrahedron of ten.
All weights are positive, and curved elements pass the patch test; the tetrahedron's usual four points are exact for
straight edges only. Other degenerate forms keep the hexahedron's points.
"""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np
from skfem.quadrature import get_quadrature
from skfem.refdom import RefHex, RefLine, RefTet, RefTri

from fecontact.common.arrays import Array
from fecontact.mesh.element.degenerate import Pattern, element_basis
from fecontact.mesh.element.hexahedron import hex_quadrature

#: Node pattern of each: wedge a b c c, d e f f; tetrahedron a b c c, d d d d; pyramid.
WEDGE: Pattern = (0, 1, 2, 2, 4, 5, 6, 6, 8, 9, 2, 11, 12, 13, 6, 15, 16, 17, 18, 18)
TETRAHEDRON: Pattern = (0, 1, 2, 2, 4, 4, 4, 4, 8, 9, 2, 11, 4, 4, 4, 4, 16, 17, 18, 18)
PYRAMID: Pattern = (0, 1, 2, 3, 4, 4, 4, 4, 8, 9, 10, 11, 4, 4, 4, 4, 16, 17, 18, 19)

#: Degrees of a wedge's rule over the triangle and along the axis with 6, with 15 and with centroid nodes.
_WEDGE_DEGREE = {8: (2, 3), 20: (4, 5), "centroid": (5, 5)}
#: Rule of degree 5 with 14 points (Walkington, 2000): barycentric coordinate of the distinct one(s), and the weight.
_VERTEX_ORBITS = ((0.0673422422100982, 0.1126879257180158), (0.7217942490673264, 0.0734930431163619))
_EDGE_ORBIT = (0.0455037041256497, 0.0425460207770812)


def _tetrahedron_14() -> tuple[Array, Array]:
    """Barycentric coordinates (3, 14) of the last three corners and weights (14,)."""
    points, weights = [], []
    for odd, weight in _VERTEX_ORBITS:
        points += [np.where(np.arange(4) == k, odd, (1 - odd) / 3) for k in range(4)]
        weights += 4 * [weight]
    small, weight = _EDGE_ORBIT
    points += [np.where(np.isin(np.arange(4), pair), small, 0.5 - small) for pair in combinations(range(4), 2)]
    weights += 6 * [weight]
    return np.array(points).T[1:], np.array(weights) / np.sum(weights) / 6


@cache
def element_quadrature(n_nodes: int, pattern: Pattern, midfaces: tuple[int, ...] = ()) -> tuple[Array, Array]:
    """Points (n_q, 3) and weights (n_q,) for the stiffness of one kind of element.

    Parameters
    ----------
    n_nodes, pattern, midfaces
        As in `basis.element_basis`.

    Examples
    --------
    >>> [len(element_quadrature(20, p)[1]) for p in (tuple(range(20)), WEDGE, TETRAHEDRON)]
    [27, 18, 14]
    """
    if n_nodes in (8, 20) and pattern == TETRAHEDRON[:n_nodes]:
        (b, c, d), W = get_quadrature(RefTet, 1) if n_nodes == 8 else _tetrahedron_14()
        rest = 1 - c - d
        return np.stack([b / rest, c / (1 - d), d], axis=1), W / (rest * (1 - d))
    if n_nodes in (8, 20) and pattern == WEDGE[:n_nodes]:
        across, along = _WEDGE_DEGREE["centroid" if midfaces else n_nodes]
        (b, c), W = get_quadrature(RefTri, across)
        (z,), Wz = get_quadrature(RefLine, along)
        plane = np.stack([b / (1 - c), c], axis=1)
        X = np.concatenate([np.repeat(plane, len(z), axis=0), np.tile(z, len(b))[:, None]], axis=1)
        return X, np.repeat(W / (1 - c), len(z)) * np.tile(Wz, len(b))
    return hex_quadrature(n_nodes)


@cache
def reduced_quadrature(n_nodes: int) -> tuple[Array, Array]:
    """Points (n_q, 3) and weights (n_q,) one order lower: one for 8 nodes, eight for 20 and 27.

    For the volumetric part of nearly incompressible elements; alone they would leave zero-energy modes.
    """
    if n_nodes == 8:
        return np.full((1, 3), 0.5), np.ones(1)
    X, W = get_quadrature(RefHex, 3)
    return np.ascontiguousarray(X.T), W


@cache
def quadrature_basis(n_nodes: int, pattern: Pattern, midfaces: tuple[int, ...]) -> tuple[Array, Array]:
    """Shape functions and their derivatives of one kind of element at its quadrature points, read-only.

    Parameters
    ----------
    n_nodes, pattern, midfaces
        As in `degenerate.element_basis`.
    """
    basis = element_basis(n_nodes, pattern, midfaces, element_quadrature(n_nodes, pattern, midfaces)[0])
    for values in basis:
        values.setflags(write=False)
    return basis
