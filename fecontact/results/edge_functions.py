"""Functions of a pressure with its square root at the edge, and their integrals over facets.

The pressure is sqrt(phi) c, see `results.edge_pressure`. Near the outline c is bilinear in the corners of facets, and
forces are integrals against the nodes' functions; inside, where c varies and sqrt(phi) is smooth, c has the shape
functions of the facets, and the force of a node is its coefficient times the integral of sqrt(phi) N.

Quadrature: on every line across a facet the outline phi = 0 is found, inside the facet or beyond it. With x = e -+ v^2,
e the place of the outline, sqrt(phi) and dx / sqrt(phi) are smooth in v, and Gauss points in v integrate them (the
substitution for end singularities of algebraic order, Davis & Rabinowitz 1984, *Methods of Numerical Integration*,
section 2.12).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.facets import facet_shapes, sides_of, triangular
from fecontact.results.contact_fields import ContactFields
from fecontact.results.contact_outline import Outline

#: Panels across a facet with Gauss points in each, and Gauss points of each half of a line.
PANELS, ACROSS, ALONG = 3, 4, 6
#: Distance of an outline beyond a facet, in facets, from which on it counts as this far.
BEYOND = 8.0
#: Steps by which the outline is found on a line from its parabola.
CORRECTIONS = 3


@dataclass(frozen=True, eq=False)
class EdgePoints:
    """Quadrature points of n facets, n_q on each.

    Attributes
    ----------
    points : (n, n_q, 3) array
    areas : (n, n_q) array
        Weights, with the facet's area element; zero where the outline leaves nothing.
    shapes : (n, n_q, k) array
        Shape functions of the facets' nodes.
    corners : (n, n_q, 4) array
        Bilinear functions of the corners of the unit square.
    """

    points: Array
    areas: Array
    shapes: Array
    corners: Array


def edge_points(nodes: Array, facets: IntArray, level: Callable[[Array], Array]) -> EdgePoints:
    """Quadrature points inside an outline.

    Parameters
    ----------
    nodes : (m, 3) array
    facets : (n, 4 | 8 | 9) int array
    level : function
        phi (...,) at points (..., 3), positive inside; its square root is to be integrated.

    Examples
    --------
    Half an ellipsoid over the unit square, a quarter of the disc: pi/6.

    >>> square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    >>> disc = lambda x: 1 - (x**2).sum(axis=-1)
    >>> found = edge_points(square, np.array([[0, 1, 2, 3]]), disc)
    >>> value = (found.areas * np.sqrt(disc(found.points))).sum()
    >>> bool(abs(value / (np.pi / 6) - 1) < 2e-4)
    True
    """
    across, weight = _panels()
    steep = _along_second(nodes, facets, level)
    n, q = len(facets), len(across)

    def at(x: Array) -> Array:
        """Level (n, q) at coordinates x (n, q) of the lines."""
        local = _local(x, across, steep)
        return level(_shapes(facets, local)[0] @ nodes[facets])

    low, high, before, after = _interval(at, n, q)
    middle = (low + high) / 2
    v, w = np.polynomial.legendre.leggauss(ALONG)
    v, w = (v + 1) / 2, w / 2
    parts = []
    for end, near, sign in ((before, low, 1.0), (after, high, -1.0)):
        inner, outer = np.sqrt(np.abs(middle - end))[..., None], np.sqrt(np.abs(near - end))[..., None]
        root = outer + (inner - outer) * v
        parts.append((end[..., None] + sign * root**2, 2 * root * (inner - outer) * w))
    x, dx = (np.concatenate(p, axis=2).reshape(n, -1) for p in zip(*parts, strict=True))
    lines = np.repeat(np.arange(q), 2 * ALONG)
    local = _local(x, across[lines], steep)
    shapes, tangents = _shapes(facets, local)
    tangent = np.einsum("fqaj,fai->fqij", tangents, nodes[facets], optimize=True)
    area = np.linalg.norm(np.cross(tangent[..., 0], tangent[..., 1]), axis=-1) * dx * weight[lines]
    s, t = np.moveaxis(local, -1, 0)
    corners = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=-1)
    return EdgePoints(shapes @ nodes[facets], area, shapes, corners)


def _panels() -> tuple[Array, Array]:
    """Coordinates (q,) of lines across the unit square, and their weights."""
    x, w = np.polynomial.legendre.leggauss(ACROSS)
    start = np.arange(PANELS)[:, None]
    return ((start + (x + 1) / 2) / PANELS).ravel(), np.tile(w / (2 * PANELS), PANELS)


def _local(x: Array, across: Array, steep: Array) -> Array:
    """Coordinates (n, q, 2) of the square from those along x (n, q) and across (q,) the lines of each facet."""
    y = np.broadcast_to(across, x.shape)
    return np.where(steep[:, None, None], np.stack([y, x], -1), np.stack([x, y], -1))


def _along_second(nodes: Array, facets: IntArray, level: Callable[[Array], Array]) -> Array:
    """Whether (n,) phi changes more along the second coordinate of each facet."""
    a, b, c, d = level(nodes[facets[:, :4]]).T
    return np.abs(c + d - a - b) > np.abs(b + c - a - d)


def _shapes(facets: IntArray, local: Array) -> tuple[Array, Array]:
    """Shape functions (n, q, k) and derivatives (n, q, k, 2) at points (n, q, 2) of the square."""
    n, q, k = len(facets), local.shape[1], facets.shape[1]
    triangle = np.repeat(triangular(facets), q)
    s, t = local.reshape(-1, 2).T
    own = np.where(triangle[:, None], np.stack([s * (1 - t), t], axis=1), local.reshape(-1, 2))
    N, dN = facet_shapes(k, triangle, own)
    collapsed = np.stack([dN[..., 0] * (1 - t)[:, None], dN[..., 1] - dN[..., 0] * s[:, None]], axis=-1)
    dN = np.where(triangle[:, None, None], collapsed, dN)
    return N.reshape(n, q, k), dN.reshape(n, q, k, 2)


def _interval(at: Callable[[Array], Array], n: int, q: int) -> tuple[Array, Array, Array, Array]:
    """Part of each line (n, q) of the unit square inside the outline, and the places of the outline on either side."""
    x = np.broadcast_to(np.array([0.0, 0.5, 1.0])[:, None, None], (3, n, q))
    start, middle, end = (at(part) for part in x)
    slope, bend = 4 * middle - 3 * start - end, 2 * (start + end - 2 * middle)
    least = np.finfo(float).eps * (np.abs(start) + np.abs(middle) + np.abs(end))
    bend = np.where(np.abs(bend) < least, -least, bend)
    root = np.sqrt(np.maximum(slope**2 - 4 * bend * start, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.where(slope > 0, -slope - root, -slope + root) / 2
        one, two = far / bend, np.where(far == 0, np.inf, start / far)
    before, after = np.fmin(one, two), np.fmax(one, two)
    # a parabola that opens upwards is followed on the side that is inside
    up, over = bend > 0, (bend > 0) & (slope**2 < 4 * bend * start)
    before, after = (
        np.where(up, np.where(end > start, after, -BEYOND), before),
        np.where(up, np.where(end > start, 1 + BEYOND, before), after),
    )
    before, after = np.where(over, -BEYOND, before), np.where(over, 1 + BEYOND, after)
    outside = (slope**2 <= 4 * bend * start) & ~up
    before, after = np.clip(before, -BEYOND, 1 + BEYOND), np.clip(after, -BEYOND, 1 + BEYOND)
    before, after = (_corrected(at, place) for place in (before, after))
    low, high = np.clip(before, 0.0, 1.0), np.clip(after, 0.0, 1.0)
    high = np.where(outside, low, np.maximum(high, low))
    return low, high, np.minimum(before, low), np.maximum(after, high)


def _corrected(at: Callable[[Array], Array], place: Array) -> Array:
    """Places (n, q) of the outline inside the facets, by Newton's method with a difference for the slope."""
    inside = (place > 0) & (place < 1)
    if not inside.any():
        return place
    step = 1e-4
    for _ in range(CORRECTIONS):
        value = at(place)
        slope = (at(place + step) - value) / step
        change = np.divide(value, slope, out=np.zeros_like(value), where=inside & (slope != 0))
        place = place - np.clip(change, -0.1, 0.1)
    return place


#: Least share of a corner's area inside the outline for a coefficient of its own; others follow from neighbours.
OWN_SHARE = 0.3
#: Layers of facets beside those that the outline cuts on which the coefficient is bilinear.
EDGE_LAYERS = 2
#: Deviation from bilinear, relative to the coefficients of a facet, up to which it is bilinear inside as well.
NEARLY_BILINEAR = 0.005


@dataclass(frozen=True, eq=False)
class RegionFunctions:
    """Functions of one region and their forces.

    Attributes
    ----------
    facets : (k,) int array
        Facets of the contact that the region covers at least partly.
    bilinear : (k,) bool array
        Whether the coefficient is bilinear there.
    area : float
        Inside the outline.
    extension : (n_nodes, j) csr_matrix
        Coefficients at the contact's nodes from those of the functions.
    forces : (n_nodes, j) array
        Nodal forces of the functions.
    at_points : (m, n_nodes) csr_matrix
        From the coefficients at nodes to those at m quadrature points.
    onto : (n_nodes, m) csr_matrix
        Nodal forces of a pressure at the quadrature points.
    terms : (m, n_terms) array
        h / (2 sqrt(phi)) at the quadrature points.
    own : (j,) int array
        Nodes of the functions.
    """

    facets: IntArray
    bilinear: Mask
    area: float
    extension: sp.csr_matrix
    forces: Array
    at_points: sp.csr_matrix
    onto: sp.csr_matrix
    terms: Array
    own: IntArray

    def by_outline(self, coefficients: Array) -> Array:
        """Nodal forces (n_nodes, n_terms) of the change of pressure, -c h / (2 sqrt(phi)), as the outline moves."""
        return np.asarray(-(self.onto @ ((self.at_points @ coefficients)[:, None] * self.terms)))


def region_functions(
    contact: ContactFields, outline: Outline, near: IntArray, corner_areas: Array, smooth: Mask | None = None
) -> RegionFunctions:
    """Functions of a region on its outline.

    Parameters
    ----------
    contact : ContactFields
    outline : Outline
    near : (k,) int array
        Facets of the contact on which the region may lie.
    corner_areas : (n_nodes,) array
        Integrals of the corners' bilinear functions over all facets of the contact.
    smooth : (n_facets,) bool array, optional
        Facets inside on which the coefficient is known to be nearly bilinear.
    """
    n = len(contact.nodes)
    chosen = near[(outline.level(contact.nodes[contact.facets[near]]) > 0).any(axis=1)]
    facets = contact.facets[chosen]
    corners = facets[:, :4]
    found = edge_points(contact.nodes, facets, outline.level)
    root = np.sqrt(np.maximum(outline.level(found.points), 0.0)).ravel()
    weight = found.areas.ravel()
    bilinear = _edge_zone(corners, np.asarray((outline.level(contact.nodes[facets]) <= 0).any(axis=1)), n)
    # plain faces of eight nodes have corners without a positive weight
    bilinear |= facets.shape[1] == 8
    if smooth is not None:
        bilinear |= smooth[chosen]
    flat = np.repeat(bilinear, found.areas.shape[1]).astype(float)
    by_corners, by_nodes = _matrix(found.corners, corners, n), _matrix(found.shapes, facets, n)
    near_edge = sp.csr_matrix(sp.diags(flat) @ by_corners)
    onto = sp.csr_matrix(by_nodes.T @ sp.diags(weight))
    inside = np.asarray(onto @ ((1 - flat) * root))
    follow = _hanging(contact)
    free = np.diff(follow.indptr) == 0
    own = _own(facets, bilinear, np.asarray(by_corners.T @ weight), corner_areas) & free
    extension = _extension(facets, bilinear, own, free)
    extension = sp.csr_matrix(extension + follow @ extension)
    forces = (onto @ sp.diags(root) @ near_edge + sp.diags(inside)) @ extension
    least = np.sqrt(np.finfo(float).eps)
    terms = outline.terms(found.points).reshape(len(weight), -1) / (2 * np.maximum(root, least))[:, None]
    at_points = sp.csr_matrix(near_edge + sp.diags(1 - flat) @ by_nodes)
    return RegionFunctions(
        chosen, bilinear, float(weight.sum()), extension, forces.toarray(), at_points, onto, terms, np.flatnonzero(own)
    )


def nearly_bilinear(contact: ContactFields, found: RegionFunctions, coefficients: Array) -> Mask:
    """Facets (n_facets,) of the contact on which coefficients (n_nodes,) are nearly those of their corners."""
    out = np.zeros(len(contact.facets), bool)
    facets = contact.facets[found.facets]
    at = coefficients[facets]
    between = (at[:, :4] + np.roll(at[:, :4], -1, axis=1)) / 2
    middles = at[:, 4:8] if facets.shape[1] > 4 else between
    scale = np.abs(at[:, :4]).max(axis=1)
    out[found.facets] = np.abs(middles - between).max(axis=1) <= NEARLY_BILINEAR * scale
    return out


def _matrix(values: Array, columns: IntArray, n: int) -> sp.csr_matrix:
    """Matrix (k n_q, n) of values (k, n_q, c) at points of k facets with columns (k, c)."""
    k, q, c = values.shape
    cells = np.broadcast_to(columns[:, None, :], values.shape)
    return sp.csr_matrix((values.ravel(), (np.repeat(np.arange(k * q), c), cells.ravel())), shape=(k * q, n))


def _edge_zone(corners: IntArray, cut: Mask, n: int) -> Mask:
    """Facets (k,) that the outline cuts, and layers of facets beside them."""
    reached = np.zeros(n, bool)
    reached[corners[cut]] = True
    for _ in range(EDGE_LAYERS - 1):
        reached[corners[np.flatnonzero(reached[corners].any(axis=1))]] = True
    return np.asarray(reached[corners].any(axis=1))


def _hanging(contact: ContactFields) -> sp.csr_matrix:
    """Weights (n_nodes, n_nodes) by which hanging nodes follow from others; empty rows for all other nodes."""
    at_nodes = contact._at_nodes
    single = np.diff(at_nodes.indptr) == 1
    node_of_point = sp.csr_matrix(sp.diags(single.astype(float)) @ at_nodes).T
    return sp.csr_matrix(sp.diags((~single).astype(float)) @ at_nodes @ node_of_point)


def _own(facets: IntArray, bilinear: Mask, share: Array, whole: Array) -> Mask:
    """Nodes (n,) with a coefficient of their own."""
    corner, zone, inner = (np.zeros(len(whole), bool) for _ in range(3))
    corner[facets[:, :4]] = True
    zone[facets[bilinear]] = True
    inner[facets[~bilinear]] = True
    return (corner & (share > OWN_SHARE * whole)) | (inner & ~zone)


def _extension(facets: IntArray, bilinear: Mask, own: Mask, free: Mask) -> sp.csr_matrix:
    """Coefficients (n, j) at all nodes from those of their own, see `RegionFunctions`.

    Corners that are hardly inside have the mean of their neighbours; middles of sides between a bilinear facet and
    another the mean of the ends.
    """
    n, corners = len(own), facets[:, :4]
    columns = np.flatnonzero(own)
    known = sp.csr_matrix((np.ones(len(columns)), (columns, np.arange(len(columns)))), shape=(n, len(columns)))
    corner = np.zeros(n, bool)
    corner[corners] = True
    member = sp.csr_matrix((np.ones(corners.size), (corners.ravel(), np.repeat(np.arange(len(facets)), 4))))
    member.resize(n, len(facets))
    beside = sp.csr_matrix(member @ member.T)
    corner &= free
    left = corner & ~own
    while left.any():
        means = sp.csr_matrix(beside @ sp.diags((corner & ~left).astype(float)))
        total = np.asarray(means.sum(axis=1)).ravel()
        ready = left & (total > 0)
        if not ready.any():
            break
        scale = np.divide(1.0, total, out=np.zeros(n), where=ready)
        known = sp.csr_matrix(known + sp.diags(scale) @ means @ known)
        left &= ~ready
    zone = facets[bilinear]
    if zone.shape[1] > 4:
        middles, first = np.unique(zone[:, 4:8], return_index=True)
        ends = sides_of(zone).reshape(-1, 2)[first]
        between = free[middles] & ~own[middles] & ~corner[middles]
        middles, ends = middles[between], ends[between]
        halves = sp.csr_matrix((np.full(ends.size, 0.5), (np.repeat(middles, 2), ends.ravel())), shape=(n, n))
        known = sp.csr_matrix(known + halves @ known)
    return known
