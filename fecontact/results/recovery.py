"""Recovery of a smooth pressure: polynomials fitted to the squared pressure, face by face.

At the edge of a contact of smooth bodies the pressure falls to zero as the square root of the distance, and its square
falls linearly: a polynomial fitted to squares is zero at the edge, also inside a face. Beyond it the polynomial is
negative and the pressure zero. The patch of a face are the nodes of all faces that share a node with it, as in the
recovery of stresses (Zienkiewicz & Zhu 1992, *The superconvergent patch recovery*). Nodes without pressure count where
the polynomial is positive.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask

#: Weight of a node at a distance of r faces: area / (OFFSET + r)^2.
OFFSET = 0.3
#: Least weight of a node's area, relative to the mean.
MIN_AREA = 1e-3
#: Ratio of the eigenvalues of a patch's moments below which its nodes do not determine a polynomial.
INDEPENDENT = 1e-4
#: By the number of monomials of second degree: numbers of monomials fitted, and least number of nodes for each. A
#: quadratic through as many nodes as it has coefficients would not smooth.
DEGREES = {6: ((6, 8), (3, 3), (1, 1)), 3: ((3, 4), (2, 2), (1, 1))}
#: Iterations over nodes without pressure.
PASSES = 2


@dataclass(frozen=True, eq=False)
class RecoveredPressure:
    """Polynomials over faces, in coordinates of each face relative to its size.

    Attributes
    ----------
    centres : (n, 3) array
    axes : (n, d, 3) array
        Two unit vectors along a face, or one along the side of a section, divided by its size.
    coefficients : (n, k) array
        Coefficients of 1, x, y, x^2, xy, y^2, or of 1, x, x^2.
    power : int
        Power of the pressure that the polynomials represent.
    """

    centres: Array
    axes: Array
    coefficients: Array
    power: int

    def at(self, points: Array) -> Array:
        """Pressures (n, q) at points (n, q, 3) of the faces."""
        local = np.einsum("fdi,fqi->fqd", self.axes, points - self.centres[:, None])
        value = np.einsum("fqk,fk->fq", monomials(local), self.coefficients)
        return np.asarray(np.maximum(value, 0.0) ** (1 / self.power))


def monomials(local: Array) -> Array:
    """Monomials to the second degree (..., 3 | 6) of coordinates (..., 1 | 2).

    Examples
    --------
    >>> monomials(np.array([[2.0, 3.0]])).tolist()
    [[1.0, 2.0, 3.0, 4.0, 6.0, 9.0]]
    """
    one = np.ones(local.shape[:-1])
    x = local[..., 0]
    if local.shape[-1] == 1:
        return np.stack([one, x, x**2], axis=-1)
    y = local[..., 1]
    return np.stack([one, x, y, x**2, x * y, y**2], axis=-1)


def recovered(
    nodes: Array, facets: IntArray, chosen: IntArray, pressure: Array, areas: Array, power: int = 2
) -> RecoveredPressure:
    """Fit polynomials to a power of the pressure.

    Parameters
    ----------
    nodes : (m, 3) array
    facets : (n_facets, 3 | 4 | 8 | 9) int array
        As in `mesh.facets`; three columns: sides of a section.
    chosen : (n,) int array
        Facets to fit.
    pressure : (m,) array
        Pressure at the nodes; NaN where unknown.
    areas : (m,) array
        Areas of the nodes, their weights.
    power : int
        2 where the pressure falls to zero as a square root, 1 where linearly, as on a foundation.

    Examples
    --------
    A half-ellipse is recovered as it is, wherever the edge at x = 1.1 lies:

    >>> nodes = np.stack([np.linspace(0, 2, 9), np.zeros(9), np.zeros(9)], axis=1)
    >>> sides = np.array([[0, 2, 1], [2, 4, 3], [4, 6, 5], [6, 8, 7]])
    >>> p = np.sqrt(np.maximum(1.1**2 - nodes[:, 0] ** 2, 0))
    >>> found = recovered(nodes, sides, np.arange(3), p, np.ones(9))
    >>> found.at(np.array([[[0.3, 0, 0]], [[0.9, 0, 0]], [[1.2, 0, 0]]])).round(12).ravel().tolist()
    [1.058300524426, 0.632455532034, 0.0]
    """
    centres, axes = facet_frames(nodes, facets[chosen])
    facet, node = patches(facets, chosen, np.isfinite(pressure))
    local = np.einsum("pdi,pi->pd", axes[facet], nodes[node] - centres[facet])
    terms, values = monomials(local), pressure[node] ** power
    weights = node_weights(areas[node], local)
    counted = pressure[node] > 0
    coefficients = np.zeros((len(chosen), terms.shape[1]))
    for _ in range(PASSES + 1):
        coefficients = fitted(facet, terms[counted], values[counted], weights[counted], counted, len(chosen))
        pressed = ~counted & (np.einsum("pk,pk->p", terms, coefficients[facet]) > 0)
        if not pressed.any():
            break
        counted |= pressed
    return RecoveredPressure(centres, axes, coefficients, power)


def node_weights(areas: Array, local: Array) -> Array:
    """Weights (n_pairs,) of nodes by their areas and their coordinates (n_pairs, d) from the centre of a facet."""
    return np.asarray(np.maximum(areas, MIN_AREA * areas.mean()) / (OFFSET + np.linalg.norm(local, axis=1)) ** 2)


def facet_frames(nodes: Array, facets: IntArray) -> tuple[Array, Array]:
    """Centres (n, 3) of facets and axes (n, d, 3) along them over their size."""
    if facets.shape[1] == 3:
        ends = nodes[facets[:, :2]]
        along = ends[:, 1] - ends[:, 0]
        return ends.mean(axis=1), (along / (along**2).sum(axis=1, keepdims=True))[:, None]
    corners = nodes[facets[:, :4]]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    size = np.sqrt(np.linalg.norm(normal, axis=1) / 2)
    normal /= 2 * size[:, None] ** 2
    one = corners[:, 1] - corners[:, 0]
    one -= np.einsum("ni,ni->n", one, normal)[:, None] * normal
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    return corners.mean(axis=1), np.stack([one, np.cross(normal, one)], axis=1) / size[:, None, None]


def patches(facets: IntArray, chosen: IntArray, known: Mask) -> tuple[IntArray, IntArray]:
    """Pairs (n_pairs,) of a chosen facet, by its index among them, and a known node of it or its neighbours."""
    n, k = facets.shape
    pointer = np.arange(0, n * k + 1, k)
    member = sp.csr_matrix((np.ones(n * k), facets.ravel(), pointer), shape=(n, len(known)))
    patch = ((member[chosen] @ member.T) @ member @ sp.diags(known.astype(float))).tocsr()
    patch.eliminate_zeros()
    return np.repeat(np.arange(len(chosen)), np.diff(patch.indptr)), patch.indices


def fitted(facet: IntArray, terms: Array, values: Array, weights: Array, counted: Mask, n: int) -> Array:
    """Coefficients (n, k) by weighted least squares, of the highest degree that each patch determines."""
    k = terms.shape[1]
    own = facet[counted]
    collect = sp.csr_matrix((weights, (own, np.arange(len(own)))), shape=(n, len(own)))
    count = np.bincount(own, minlength=n)
    scale = np.maximum(collect @ np.ones(len(own)), np.finfo(float).tiny)[:, None]
    moments = (collect @ (terms[:, :, None] * terms[:, None, :]).reshape(-1, k * k) / scale).reshape(n, k, k)
    right = collect @ (terms * values[:, None]) / scale
    out, done = np.zeros((n, k)), np.zeros(n, bool)
    for used, fewest in DEGREES[k]:
        rows = np.flatnonzero(~done & (count >= fewest))
        part = moments[rows, :used, :used]
        eigenvalues = np.linalg.eigvalsh(part)
        rows, part = (a[eigenvalues[:, 0] > INDEPENDENT * eigenvalues[:, -1]] for a in (rows, part))
        out[rows, :used] = np.linalg.solve(part, right[rows, :used, None])[..., 0]
        done[rows] = True
    return out
