"""Level of a contact: its distance from the edge at the nodes of its facets, positive inside, from pressures and gaps.

Near the edge of a contact of smooth elastic bodies, at a distance d,

    p = A sqrt(d) inside,   g = 4 A / (3 E*) d^(3/2) outside,

with one factor A: the first terms of the pressure and the gap of Hertz's line contact (Johnson 1985, *Contact
Mechanics*, section 4.2(c)), which every smooth edge resembles near enough. So p^2 / A^2 inside and
-(3 E* g / (4 A))^(2/3) outside are one function, linear to first order, that is zero at the edge. Polynomials are
fitted to it on the patches of facets as in `results.recovery`, to nodes on both sides of the edge, so that its place is
interpolated. A is the factor for which the slope is one.

Gaps are the more accurate: their errors are those of displacements, and so are the weights.

A layer thinner than the facets gives like a foundation of springs: pressures inside and gaps outside are linear, with a
ratio k of their slopes. There p - k g is fitted. Which law holds is told by the factors A of both sides, which differ
by an order of magnitude in thin layers and agree in thick bodies.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.results.recovery import facet_frames, fitted, monomials, node_weights, patches

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields

#: Errors, relative to a facet's size: of distances by pressures, over the root of the distance; by gaps, times the
#: root of the distance, and at least. The factors are the scatter of nodal values round Hertz's, on hexahedra and
#: tetrahedra, nodal and mortar coupling.
BY_PRESSURE, BY_GAP, MIN_ERROR = 0.1, 0.03, 0.02
#: Distances in facets at which the first of these errors grows no smaller and the second no larger.
NEAREST = (0.1, 0.01)
#: Iterations of the factor A, and its exponent on the slope: a pressure alone would want 1/2, a gap alone 3/2.
PASSES, EXPONENT = 5, 0.75
#: Slopes within which a fit counts, and the largest change of A in an iteration.
SLOPES, CHANGE = (0.5, 2.0), 5.0
#: Ratio of the factors A by pressures and by gaps above which bodies give like springs. It is 0.4 to 2.2 in contacts of
#: thick bodies, 2.9 to 18 in cartilages no thicker than the facets.
SPRINGS = 2.5
#: Distance in facets up to which nodes may lie on the other side of the edge than their force says.
LIMIT = 0.5
#: Least distance in facets of nodes all of whose facets are on one side.
CLEAR = 0.05


class _Patches(NamedTuple):
    """Pairs of a chosen facet, by its index (n_pairs,), and a node of its patch."""

    facet: IntArray
    terms: Array
    local: Array
    weights: Array
    inside: Mask
    pressure: Array
    gap: Array
    size: Array
    modulus: float

    def fitted(self, values: Array, weights: Array, counted: Mask | None = None) -> Array:
        """Coefficients (n, k) of polynomials through values (n_pairs,) at some of the nodes."""
        some = np.ones(len(self.facet), bool) if counted is None else counted
        return fitted(self.facet, self.terms[some], values[some], weights[some], some, len(self.size))

    def means(self, weights: Array) -> Array:
        """Weighted means (n, d) of the coordinates of the nodes of each patch."""
        n = len(self.size)
        total = np.maximum(np.bincount(self.facet, weights, n), np.finfo(float).tiny)
        return np.stack([np.bincount(self.facet, weights * x, n) / total for x in self.local.T], axis=1)


def edge_level(contact: ContactFields) -> Array:
    """Distances (m,) of the nodes from the edge of the contact; far from it only their signs count.

    Nodes that face nothing are outside.

    Parameters
    ----------
    contact : ContactFields
    """
    nodes, facets = contact.nodes, contact.facets
    inside = contact.at_nodes @ contact.pressure > 0
    size = facet_sizes(nodes, facets)
    level = np.where(inside, size, -size)
    here = inside[facets].any(axis=1) & (~inside)[facets].any(axis=1)
    at_edge = np.zeros(len(nodes), bool)
    at_edge[facets[here]] = True
    chosen = np.flatnonzero(at_edge[facets].any(axis=1))
    if not len(chosen):
        return level
    values, good = _fitted_levels(contact, chosen)
    own = facets[chosen][good].ravel()
    count = np.bincount(own, minlength=len(nodes))
    mean = np.bincount(own, values[good].ravel(), minlength=len(nodes)) / np.maximum(count, 1)
    least = np.where(at_edge, -LIMIT, CLEAR) * size
    bound = np.where(inside, np.maximum(mean, least), np.minimum(mean, -least))
    unfitted = np.where(inside, LIMIT / 2, -LIMIT / 2) * size
    facing = np.diff(contact.at_nodes.indptr) > 0
    near = np.zeros(len(nodes), bool)
    near[facets[chosen]] = True
    return np.where(near & facing, np.where(count > 0, bound, unfitted), level)


def facet_sizes(nodes: Array, facets: IntArray) -> Array:
    """Mean size (m,) of the facets round each node."""
    _, axes = facet_frames(nodes, facets)
    each = np.repeat(1 / np.linalg.norm(axes[:, 0], axis=1), facets.shape[1])
    count = np.bincount(facets.ravel(), minlength=len(nodes))
    return np.asarray(np.bincount(facets.ravel(), each, len(nodes)) / np.maximum(count, 1))


def _fitted_levels(contact: ContactFields, chosen: IntArray) -> tuple[Array, Mask]:
    """Levels (n, k) at the nodes of chosen facets by the polynomial of each, and which (n,) have one."""
    own = contact.facets[chosen]
    centres, axes = facet_frames(contact.nodes, own)
    found = _patches(contact, chosen, centres, axes)
    springs = contact.slave.is_foundation or _like_springs(found)
    coefficients, good = _by_springs(found) if springs else _by_roots(found)
    at_nodes = np.einsum("fdi,fai->fad", axes, contact.nodes[own] - centres[:, None])
    return np.einsum("fak,fk->fa", monomials(at_nodes), coefficients) * found.size[:, None], good


def _patches(contact: ContactFields, chosen: IntArray, centres: Array, axes: Array) -> _Patches:
    known = np.diff(contact.at_nodes.indptr) == 1
    facet, node = patches(contact.facets, chosen, known)
    local = np.einsum("pdi,pi->pd", axes[facet], contact.nodes[node] - centres[facet])
    weights = node_weights((contact.at_nodes @ contact.weights)[node], local)
    pressure = (contact.at_nodes @ contact.pressure)[node]
    gap = np.maximum(contact.at_nodes @ contact.gap, 0.0)[node]
    size = 1 / np.linalg.norm(axes[:, 0], axis=1)
    modulus = 1 / sum(1 / body.contact_modulus for body in (contact.slave, contact.master))
    return _Patches(facet, monomials(local), local, weights, pressure > 0, pressure, gap, size, modulus)


def _like_springs(found: _Patches) -> bool:
    """Whether pressures inside are steeper than the gaps outside of thick bodies tell."""
    inner, outer = (
        _slopes(found.fitted(v, found.weights, side), found.means(found.weights * side))
        for v, side in ((found.pressure**2, found.inside), (_root(found), ~found.inside))
    )
    both = (inner > 0) & (outer > 0)
    factors = np.sqrt(inner[both] / found.size[both]) / (outer[both] / found.size[both]) ** 1.5
    return bool(both.any() and np.median(factors) > SPRINGS)


def _root(found: _Patches) -> Array:
    """Gaps (n_pairs,) to the power 2/3, scaled so that A^(2/3) is their slope."""
    return np.asarray((3 / 4 * found.modulus * found.gap) ** (2 / 3))


def _by_springs(found: _Patches) -> tuple[Array, Mask]:
    """Distances as p - k g over its slope: coefficients (n, k), and which (n,) are good.

    Where p - k g is a polynomial, what polynomials leave of p is k times what they leave of g.
    """
    both = [found.fitted(values, found.weights) for values in (found.pressure, found.gap)]
    left = [
        values - np.einsum("pk,pk->p", found.terms, fit[found.facet])
        for values, fit in zip((found.pressure, found.gap), both, strict=True)
    ]
    of_pressure, of_gap = (float(found.weights @ rest**2) for rest in left)
    ratio = np.sqrt(of_pressure / of_gap) if of_gap > 0 else 0.0
    coefficients = both[0] - ratio * both[1]
    slope = _slopes(coefficients, found.means(found.weights))
    good = slope > SLOPES[0] * np.median(slope)
    return coefficients / np.where(good, slope, 1.0)[:, None], good


def _by_roots(found: _Patches) -> tuple[Array, Mask]:
    """Distances as p^2 / A^2 and -(3 E* g / (4 A))^(2/3): coefficients (n, k), and which (n,) are good."""
    facet, inside, n = found.facet, found.inside, len(found.size)
    squares, gaps = found.pressure**2, _root(found)
    factor = np.bincount(facet, squares * inside, n) / np.maximum(np.bincount(facet, inside, n), 1) / found.size
    factor = np.where(factor > 0, factor, factor.max())  # A^2
    coefficients, slope = np.zeros((n, found.terms.shape[1])), np.ones(n)
    for _ in range(PASSES):
        a = factor[facet]
        distance = np.where(inside, squares / a, gaps / a ** (1 / 3)) / found.size[facet]
        weights = found.weights / _variance(distance, inside)
        coefficients = found.fitted(np.where(inside, distance, -distance), weights)
        slope = _slopes(coefficients, found.means(weights))
        factor *= np.clip(slope, 1 / CHANGE, CHANGE) ** (2 * EXPONENT)
    return coefficients, (slope > SLOPES[0]) & (slope < SLOPES[1])


def _variance(distance: Array, inside: Mask) -> Array:
    """Squared errors (n_pairs,) of distances in facets."""
    by_pressure = BY_PRESSURE**2 * np.maximum(distance, NEAREST[0])
    by_gap = BY_GAP**2 / np.maximum(distance, NEAREST[1]) + MIN_ERROR**2
    return np.where(inside, by_pressure, by_gap)


def _slopes(coefficients: Array, at: Array) -> Array:
    """Slopes (n,) of polynomials (n, k) at coordinates (n, d)."""
    c, x = coefficients.T, at[:, 0]
    if at.shape[1] == 1:
        return np.abs(c[1] + 2 * c[2] * x)
    y = at[:, 1]
    return np.hypot(c[1] + 2 * c[3] * x + c[4] * y, c[2] + c[4] * x + 2 * c[5] * y)
