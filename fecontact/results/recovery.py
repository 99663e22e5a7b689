"""Recovery of a smooth pressure and of the edge of a contact: polynomials fitted to patches of faces.

At the edge of a contact of smooth bodies the pressure falls to zero as the square root of the distance, and its square
falls linearly: a polynomial fitted to squares is zero at the edge, also inside a face. Beyond it the polynomial is
negative and the pressure zero. The patch of a face are the nodes of all faces that share a node with it, as in the
recovery of stresses (Zienkiewicz & Zhu 1992, *The superconvergent patch recovery*). Nodes without pressure count where
the polynomial is positive.

The level of a node is its distance from the edge, positive inside. Near the edge, at a distance d,

    p = A sqrt(d) inside,   g = 4 A / (3 E*) d^(3/2) outside,

with one factor A: the first terms of the pressure and the gap of Hertz's line contact (Johnson 1985, *Contact
Mechanics*, section 4.2(c)), which every smooth edge resembles near enough. So p^2 / A^2 inside and
-(3 E* g / (4 A))^(2/3) outside are one function, linear to first order, that is zero at the edge. Polynomials are
fitted to it on the same patches, to nodes on both sides of the edge, so that its place is interpolated. A is the factor
for which the slope is one. Gaps are the more accurate: their errors are those of displacements, and so are the weights.

A layer thinner than the facets gives like a foundation of springs: pressures inside and gaps outside are linear, with a
ratio k of their slopes. There p - k g is fitted. The factors A of both sides decide which law holds: they differ by an
order of magnitude in thin layers and agree in thick bodies.

The recovered field is continuous: inside, the squared pressures of the patches are averaged at the nodes and
interpolated by the functions of the coupling. On facets that the outline cuts p^2 = phi c, with phi the level and c
linear on the patch of each facet and averaged at the nodes: it is zero on the outline and its square falls linearly
there. tests/benchmarks/bench_outlines.py compares it with the nodal pressure, which is kept where it is the better: on
facets cut in a mortar coupling, whose pressures are means; at sharp edges and rims, where the pressure is not a square
root; and in contacts of fewer than `RESOLVED` faces across.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask, cross
from fecontact.common.compact_repr import compact_repr
from fecontact.results.facet_samples import facet_samples, hats, pressure_shapes

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
    normal = cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    size = np.sqrt(np.linalg.norm(normal, axis=1) / 2)
    normal /= 2 * size[:, None] ** 2
    one = corners[:, 1] - corners[:, 0]
    one -= np.einsum("ni,ni->n", one, normal)[:, None] * normal
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    return corners.mean(axis=1), np.stack([one, cross(normal, one)], axis=1) / size[:, None, None]


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


if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields

#: Errors, relative to a facet's size: of distances by pressures, over the root of the distance; by gaps, times the
#: root of the distance, and at least. The factors are the scatter of nodal values round Hertz's, on hexahedra and
#: tetrahedra, nodal and mortar coupling.
BY_PRESSURE, BY_GAP, MIN_ERROR = 0.1, 0.03, 0.02
#: Distances in facets at which the first of these errors grows no smaller and the second no larger.
NEAREST = (0.1, 0.01)
#: Iterations of the factor A, and its exponent on the slope: a pressure alone would want 1/2, a gap alone 3/2.
FACTOR_PASSES, EXPONENT = 5, 0.75
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
    inside = contact._at_nodes @ contact.pressure > 0
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
    facing = np.diff(contact._at_nodes.indptr) > 0
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
    springs = contact.slave._is_foundation or _like_springs(found)
    coefficients, good = _by_springs(found) if springs else _by_roots(found)
    at_nodes = np.einsum("fdi,fai->fad", axes, contact.nodes[own] - centres[:, None])
    return np.einsum("fak,fk->fa", monomials(at_nodes), coefficients) * found.size[:, None], good


def _patches(contact: ContactFields, chosen: IntArray, centres: Array, axes: Array) -> _Patches:
    known = np.diff(contact._at_nodes.indptr) == 1
    facet, node = patches(contact.facets, chosen, known)
    local = np.einsum("pdi,pi->pd", axes[facet], contact.nodes[node] - centres[facet])
    weights = node_weights((contact._at_nodes @ contact.weights)[node], local)
    pressure = (contact._at_nodes @ contact.pressure)[node]
    gap = np.maximum(contact._at_nodes @ contact.gap, 0.0)[node]
    size = 1 / np.linalg.norm(axes[:, 0], axis=1)
    modulus = 1 / sum(1 / body.contact_modulus for body in (contact.slave, contact.master))
    return _Patches(facet, monomials(local), local, weights, pressure > 0, pressure, gap, size, modulus)


def _like_springs(found: _Patches) -> bool:
    """Whether pressures inside are steeper than the gaps outside would make them on thick bodies."""
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
    for _ in range(FACTOR_PASSES):
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


class NodalPressure(NamedTuple):
    """Pressures at the nodes (m,), those that carry information (else NaN), facets with pressure, and where bounded."""

    pressure: Array
    known: Array
    loaded: Mask
    bounded: Mask


def nodal_pressure(contact: ContactFields) -> NodalPressure | None:
    """Pressure of a contact at the nodes of its facets; None without pressure."""
    nodal = contact._at_nodes @ contact.pressure
    # nodes between contact points, as on a triangle's sides in a mortar coupling, carry no information
    known = np.where(np.diff(contact._at_nodes.indptr) == 1, nodal, np.nan)
    if not (known > 0).any():
        return None
    loaded = (nodal[contact.facets] > 0).any(axis=1)
    if (edge := contact._singular_edge) is None:
        return NodalPressure(nodal, known, loaded, loaded)
    at_edge = np.asarray(contact._at_nodes @ edge.points > 0)
    known[at_edge] = np.nan
    return NodalPressure(nodal, known, loaded, loaded & ~at_edge[contact.facets].any(axis=1))


def recovered_on(contact: ContactFields, field: NodalPressure, chosen: IntArray) -> RecoveredPressure:
    """Recovered pressure on chosen facets on which it is bounded."""
    # on an elastic foundation the pressure falls to zero linearly
    power = 1 if contact.slave._is_foundation else 2
    # only facets with pressure: which others were paired is a matter of the search
    counted = np.flatnonzero(field.bounded)
    facets, own = contact.facets[counted], np.searchsorted(counted, chosen)
    return recovered(contact.nodes, facets, own, field.known, contact._at_nodes @ contact.weights, power)


#: Faces across a contact from which its pressure is recovered.
RESOLVED = 4.0
#: Least distance from the edge, in facets, by which the weight of a node's squared pressure is divided.
MIN_DEPTH = 0.1
#: Columns of the polynomials for c: constant and linear.
LINEAR = 3


@compact_repr
@dataclass(frozen=True, eq=False)
class RecoveredField:
    """Recovered pressure of a contact.

    Attributes
    ----------
    contact : ContactFields
    pressure : (m,) array
        At the nodes of the facets; that of the contact where it is not recovered.
    level, factor : (m,) arrays
        phi and c at the nodes.
    cut : (n_facets,) bool array
        Facets on which p^2 = phi c (or p = phi c on a foundation).
    """

    contact: ContactFields
    pressure: Array
    level: Array
    factor: Array
    cut: Mask

    def at(self, local: Array) -> Array:
        """Pressure (n_facets, n_q) at common coordinates (n_q, 2 | 1) of all facets."""
        facets, mortar = self.contact.facets, self.contact.coupling == "mortar"
        value = np.einsum("fqa,fa->fq", pressure_shapes(facets, local, mortar), self.pressure[facets])
        if self.cut.any():
            own = facets[self.cut]
            shapes = hats(own, local, False)
            square = [np.maximum(np.einsum("fqa,fa->fq", shapes, v[own]), 0.0) for v in (self.level, self.factor)]
            value[self.cut] = (square[0] * square[1]) ** (1 / _power(self.contact))
        return np.asarray(value)

    def sampled(self, n: int = 4) -> tuple[Array, Array, Array]:
        """Points (n_samples, 3), pressures and areas (n_samples,), n x n on each facet, as `ContactFields.sampled`."""
        contact = self.contact
        every = facet_samples(contact.nodes, contact.facets, contact.coupling == "mortar", contact._extent, n)
        return every.points.reshape(-1, 3), self.at(every.local).ravel(), every.areas.ravel()


def recovered_field(contact: ContactFields, across: float) -> RecoveredField:
    """Recovered pressure of a contact so many faces across."""
    field, n = nodal_pressure(contact), len(contact.nodes)
    none = np.zeros(len(contact.facets), bool)
    if field is None or contact.facets.shape[1] == 3 or not across >= RESOLVED:
        nodal = np.asarray(contact._at_nodes @ contact.pressure)
        return RecoveredField(contact, nodal, np.zeros(n), np.zeros(n), none)
    facets, level = contact.facets, contact._edge_level
    facing = (np.diff(contact._at_nodes.indptr) > 0)[facets].all(axis=1)
    smooth = facing & (field.bounded | ~field.loaded)
    crossed = (level > 0)[facets].any(axis=1) & (level <= 0)[facets].any(axis=1)
    cut = none if contact.coupling == "mortar" else crossed & smooth
    kept = np.zeros(n, bool)
    kept[facets[field.loaded & (~smooth | (crossed & ~cut))]] = True
    pressure = np.where(kept, field.pressure, np.where(level > 0, _averaged(contact, field), 0.0))
    return RecoveredField(contact, pressure, level, _factor(contact, field, level, cut), cut)


def _averaged(contact: ContactFields, field: NodalPressure) -> Array:
    """Recovered pressure (m,) averaged at nodes over facets on which it is bounded, else that of the contact."""
    chosen = np.flatnonzero(field.bounded)
    if not len(chosen):
        return field.pressure
    own, power = contact.facets[chosen], _power(contact)
    there = recovered_on(contact, field, chosen).at(contact.nodes[own]) ** power
    count = np.bincount(own.ravel(), minlength=len(contact.nodes))
    mean = np.bincount(own.ravel(), there.ravel(), len(contact.nodes)) / np.maximum(count, 1)
    return np.where(count > 0, mean ** (1 / power), field.pressure)


def _factor(contact: ContactFields, field: NodalPressure, level: Array, cut: Mask) -> Array:
    """Factor c (m,) at the nodes of cut facets, from the pressures at nodes within the outline."""
    chosen = np.flatnonzero(cut)
    if not len(chosen):
        return np.zeros(len(level))
    own = contact.facets[chosen]
    centres, axes = facet_frames(contact.nodes, own)
    facet, node = patches(contact.facets, chosen, np.isfinite(field.known) & (level > 0))
    local = np.einsum("pdi,pi->pd", axes[facet], contact.nodes[node] - centres[facet])
    size = 1 / np.linalg.norm(axes[:, 0], axis=1)
    depth = level[node] / size[facet]
    weights = node_weights((contact._at_nodes @ contact.weights)[node], local) / np.maximum(depth, MIN_DEPTH)
    terms = monomials(local)[:, :LINEAR] * depth[:, None]
    values = field.pressure[node] ** _power(contact)
    coefficients = fitted(facet, terms, values, weights, np.ones(len(facet), bool), len(chosen)) / size[:, None]
    at_nodes = np.einsum("fdi,fai->fad", axes, contact.nodes[own] - centres[:, None])
    each = np.einsum("fak,fk->fa", monomials(at_nodes)[..., :LINEAR], coefficients)
    count = np.bincount(own.ravel(), minlength=len(level))
    return np.asarray(np.bincount(own.ravel(), each.ravel(), len(level)) / np.maximum(count, 1))


def _power(contact: ContactFields) -> int:
    """Power of the pressure that falls linearly to zero at the edge."""
    return 1 if contact.slave._is_foundation else 2
