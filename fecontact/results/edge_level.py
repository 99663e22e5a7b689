"""Level of a contact: its distance from the edge at the nodes of its facets, positive inside, from pressures and gaps.

Near the edge of a contact of smooth elastic bodies, at a distance d,

    p = A sqrt(d) inside,   g = 4 A / (3 E*) d^(3/2) outside,

with one factor A: the first terms of the pressure and the gap of Hertz's line contact (Johnson 1985, *Contact
Mechanics*, section 4.2(c)), which every smooth edge resembles near enough. So p^2 / A^2 inside and
-(3 E* g / (4 A))^(2/3) outside are one function, linear to first order, that is zero at the edge. Polynomials are
fitted to it on the patches of facets as in `results.recovery`, to nodes on both sides of the edge, so that its place is
interpolated. A is the factor for which the slope is one.

Gaps are the more accurate: their errors are those of displacements, and so are the weights.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.results.error_estimate import PressureOnFacets
from fecontact.results.recovery import facet_frames, fitted, monomials, node_weights, patches
from fecontact.surfaces.facet_surface import FacetSurface

#: Errors, relative to a facet's size: of distances by pressures, over the root of the distance; by gaps, times the
#: root of the distance, and at least. The factors are the scatter of nodal values round Hertz's, on hexahedra and
#: tetrahedra, nodal and mortar coupling.
BY_PRESSURE, BY_GAP, LEAST = 0.1, 0.03, 0.02
#: Distances in facets at which the first of these errors grows no smaller and the second no larger.
NEAREST = (0.1, 0.01)
#: Iterations of the factor A, and its exponent on the slope: a pressure alone would want 1/2, a gap alone 3/2.
PASSES, EXPONENT = 5, 0.75
#: Slopes within which a fit counts, and the largest change of A in an iteration.
SLOPES, CHANGE = (0.5, 2.0), 5.0
#: Distance in facets up to which nodes may lie on the other side of the edge than their force says.
LIMIT = 0.5
#: Least distance in facets of nodes all of whose facets are on one side.
CLEAR = 0.05


class PressureAndGap(PressureOnFacets, Protocol):
    """Pressures and gaps of a contact on its facets, as in `contact_fields.ContactFields`."""

    @property
    def gap(self) -> Array:
        """Gaps (n,) after deformation."""

    @property
    def surface(self) -> FacetSurface:
        """The slave's surface, in its own axes."""


class _Sides(NamedTuple):
    """Values of the contact at the nodes of its facets (m,): squared pressure, gap, and what carries information."""

    pressure: Array
    gap: Array
    known: Mask
    pressed: Mask


def edge_level(contact: PressureAndGap) -> Array:
    """Distances (m,) of the nodes from the edge of the contact; far from it only their signs count.

    Nodes that face nothing are outside. On an elastic foundation pressures fall to zero linearly and gaps tell nothing
    of their slope: there the pressures are continued.

    Parameters
    ----------
    contact : PressureAndGap
    """
    nodes, facets = contact.nodes, contact.facets
    sides = _sides(contact)
    inside = contact.at_nodes @ contact.pressure > 0
    size = facet_sizes(nodes, facets)
    level = np.where(inside, size, -size)
    here = inside[facets].any(axis=1) & (~inside)[facets].any(axis=1)
    at_edge = np.zeros(len(nodes), bool)
    at_edge[facets[here]] = True
    chosen = np.flatnonzero(at_edge[facets].any(axis=1))
    if not len(chosen):
        return level
    values, good = _fitted_levels(contact, sides, chosen)
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


def _sides(contact: PressureAndGap) -> _Sides:
    known = np.diff(contact.at_nodes.indptr) == 1
    pressure = contact.at_nodes @ contact.pressure
    gap = np.maximum(contact.at_nodes @ contact.gap, 0.0)
    pressed = pressure > 0
    return _Sides(pressure, gap, known & (pressed | ~contact.slave.is_foundation), pressed)


def facet_sizes(nodes: Array, facets: IntArray) -> Array:
    """Mean size (m,) of the facets round each node."""
    _, axes = facet_frames(nodes, facets)
    each = np.repeat(1 / np.linalg.norm(axes[:, 0], axis=1), facets.shape[1])
    count = np.bincount(facets.ravel(), minlength=len(nodes))
    return np.asarray(np.bincount(facets.ravel(), each, len(nodes)) / np.maximum(count, 1))


def _fitted_levels(contact: PressureAndGap, sides: _Sides, chosen: IntArray) -> tuple[Array, Mask]:
    """Levels (n, k) at the nodes of chosen facets by the polynomial of each, and which (n,) have one."""
    own = contact.facets[chosen]
    centres, axes = facet_frames(contact.nodes, own)
    facet, node = patches(contact.facets, chosen, sides.known)
    local = np.einsum("pdi,pi->pd", axes[facet], contact.nodes[node] - centres[facet])
    terms, n = monomials(local), len(chosen)
    size, inside = 1 / np.linalg.norm(axes[:, 0], axis=1), sides.pressed[node]
    base = node_weights((contact.at_nodes @ contact.weights)[node], local)
    power = 1 if contact.slave.is_foundation else 2
    pressures = sides.pressure[node] ** power
    gaps = 3 / 4 * sides.gap[node] / sum(1 / body.contact_modulus for body in (contact.slave, contact.master))
    count = np.maximum(np.bincount(facet, inside, n), 1)
    factor = np.bincount(facet, pressures * inside, n) / count / size  # A^power
    factor = np.where(factor > 0, factor, factor.max())
    coefficients, slope = np.zeros((n, terms.shape[1])), np.ones(n)
    for _ in range(PASSES):
        a = factor[facet]
        outside = (gaps / a ** (1 / power)) ** (2 / 3)
        distance = np.where(inside, pressures / a, outside) / size[facet]
        weights = base / _variance(distance, inside)
        target = np.where(inside, distance, -distance)
        coefficients = fitted(facet, terms, target, weights, np.ones(len(facet), bool), n)
        slope = _slopes(coefficients, _means(facet, local, weights, n))
        factor *= np.clip(slope, 1 / CHANGE, CHANGE) ** (power * EXPONENT)
    at_nodes = np.einsum("fdi,fai->fad", axes, contact.nodes[own] - centres[:, None])
    values = np.einsum("fak,fk->fa", monomials(at_nodes), coefficients) * size[:, None]
    return values, (slope > SLOPES[0]) & (slope < SLOPES[1])


def _variance(distance: Array, inside: Mask) -> Array:
    """Squared errors (n_pairs,) of distances in facets."""
    by_pressure = BY_PRESSURE**2 * np.maximum(distance, NEAREST[0])
    by_gap = BY_GAP**2 / np.maximum(distance, NEAREST[1]) + LEAST**2
    return np.where(inside, by_pressure, by_gap)


def _means(facet: IntArray, local: Array, weights: Array, n: int) -> Array:
    """Weighted means (n, d) of the coordinates of the nodes of each patch."""
    total = np.maximum(np.bincount(facet, weights, n), np.finfo(float).tiny)
    return np.stack([np.bincount(facet, weights * x, n) / total for x in local.T], axis=1)


def _slopes(coefficients: Array, at: Array) -> Array:
    """Size (n,) of the gradients of polynomials at coordinates (n, d)."""
    c, x = coefficients.T, at[:, 0]
    if at.shape[1] == 1:
        return np.abs(c[1] + 2 * c[2] * x)
    y = at[:, 1]
    return np.hypot(c[1] + 2 * c[3] * x + c[4] * y, c[2] + c[4] * x + 2 * c[5] * y)
