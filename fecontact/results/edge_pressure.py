"""Pressure with its square root at the edge: a better reading of a contact that has been found.

Polynomials on facets cannot follow a pressure that falls to zero as the square root of the distance from the edge: most
of their error lies in the outermost twentieth of the radius (docs/accuracy.py). Here

    p = sqrt(phi) c

with phi the smooth function of `results.contact_outline`, zero on the edge. Near the outline c is bilinear in the
corners of facets, and forces are integrals against the nodes' functions: with as many coefficients as nodes the problem
would be unstable. Inside, where c varies and sqrt(phi) is smooth, c has the shape functions of the facets, and the
force of a node is its coefficient times the integral of sqrt(phi) N, as that of a nodal pressure is. Hanging nodes
follow from the others. c follows from the condensed problem of the solution by Galerkin's method: with forces f = P c,

    P^T (S f + g + B^T q) = 0,   B f = F,

the gap vanishes in the mean over every function. A factor that carries the singularity: the partition of unity method
(Melenk & Babuska 1996); the square root at the free edge of smooth bodies: Johnson 1985, *Contact Mechanics*, ch. 4.

On a wrong outline the pressure has an inverse square root at the edge, and c leaves it: with a radius 0.1 % too large c
falls by a tenth in the outermost facets. Moving the outline by da_k changes the pressure by -c h_k da_k / (2
sqrt(phi)), and with it c by dc_k. Newton's method takes the outline on which c near the edge is smoothest: least
squares of c + sum_k dc_k da_k less a function that is linear in phi with the angular terms of the outline.

Quadrature: on every line across a facet the outline phi = 0 is found, inside the facet or beyond it. With x = e -+ v^2,
e the place of the outline, sqrt(phi) and dx / sqrt(phi) are smooth in v, and Gauss points in v integrate them (the
substitution for end singularities of algebraic order, Davis & Rabinowitz 1984, *Methods of Numerical Integration*,
section 2.12).

What is certified is the nodal problem. Displacements, stresses and gaps of the result follow its forces. This pressure
has residuals and forces of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.facets import facet_shapes, nodal_areas, shapes_on_square, sides_of, triangular
from fecontact.results.contact_fields import ContactFields
from fecontact.results.contact_outline import Mirror, Outline, ellipse_of_moments, planes_of_symmetry
from fecontact.solvers import ContactProblem
from fecontact.solvers.active_set import solve_on

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


#: Fewest points of a region with an outline of its own.
MIN_POINTS = 12
#: Width of points over their length that counts as a line.
ON_A_LINE = 1e-6


@dataclass(frozen=True, eq=False)
class EdgeRegion:
    """A connected contact area with its outline.

    Attributes
    ----------
    number : int
        As in `ContactFields.region`.
    outline : Outline
    mirrors : tuple of Mirror
        Planes of symmetry at which it ends.
    near : (k,) int array
        Facets of the contact on which it may lie.
    """

    number: int
    outline: Outline
    mirrors: tuple[Mirror, ...]
    near: IntArray


def regions_with_edge(contact: ContactFields) -> list[EdgeRegion]:
    """Regions with enough points, with the ellipses of their moments scaled to the area of the recovered edge.

    Moments give the place and the axes of an outline, whatever the mesh; its size only if the pressure is that of
    Hertz. The outline (`results.contact_outline`) gives the size.
    """
    at_nodes = contact._at_nodes.copy()
    at_nodes.data = contact.region[at_nodes.indices].astype(float)
    of_node = at_nodes.max(axis=1).toarray().ravel().astype(np.int64)
    of_facet = of_node[contact.facets]
    beside = _facets_by_nodes(contact.facets, len(contact.nodes))
    areas = contact.outline.areas
    out = []
    for k in range(1, int(contact.region.max(initial=0)) + 1):
        points = np.flatnonzero(contact.region == k)
        if len(points) < MIN_POINTS or _flat(contact.points[points]):
            continue
        own, alien = (of_facet == k).any(axis=1), ((of_facet != k) & (of_facet > 0)).any(axis=1)
        near = (beside @ (beside.T @ own.astype(float)) > 0) & ~alien
        mirrors = planes_of_symmetry(contact._surface, contact.slave.pose, contact._node_numbers[of_node == k])
        forces = contact.forces[points]
        outline = ellipse_of_moments(contact.points[points], forces, forces @ contact.normals[points], mirrors)
        if areas[near].sum() == 0:
            continue
        scale = np.sqrt(areas[near].sum() * 2 ** len(mirrors) / outline.area)
        outline = replace(outline, axes=outline.axes / scale)
        out.append(EdgeRegion(k, outline, mirrors, np.flatnonzero(near)))
    return out


def _flat(points: Array) -> bool:
    """Whether points (n, 3) lie on a line."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[1] <= ON_A_LINE * spread[0])


def _facets_by_nodes(facets: IntArray, n: int) -> sp.csr_matrix:
    """Incidence (n_facets, n_nodes)."""
    pointer = np.arange(0, facets.size + 1, facets.shape[1])
    return sp.csr_matrix((np.ones(facets.size), facets.ravel(), pointer), shape=(len(facets), n))


#: Degrees of outlines tried in turn, and steps of Newton's method on each.
DEGREES, STEPS = (2, 4, 6), 8
#: Largest change of a coefficient in a step, and largest movement, relative to the size, when the outline has settled,
#: and the one accepted after the last step.
MAX_STEP, STEP_TOLERANCE, ACCEPTED_STEP = 0.1, 2e-5, 5e-4
#: Movement by terms of the next degree, relative to the size, up to which they are not needed.
FOUND = 2e-3
#: Layers of facets from the edge on which c is to be smooth.
SMOOTH_LAYERS = 4
#: Accepted tension over the peak, overlap outside over the elastic deflection, and change of area beyond the surface.
TENSION, OVERLAP, AREA = 1e-2, 2e-3, 0.05
#: Most difference from the nodal pressure over the misfit of its reconstructions, and samples of a facet to find it.
MAX_CHANGE, SAMPLES = 1.5, 6
#: Accepted imbalance and mean gap, relative.
BALANCE = 1e-10


@dataclass(frozen=True)
class EdgeResiduals:
    """Residuals of an edge pressure; all numbers are relative and dimensionless.

    Attributes
    ----------
    tension : float
        Largest negative coefficient, over the largest positive one.
    overlap : float
        Largest negative gap at points wholly outside the outlines, over the largest elastic deflection.
    equilibrium : float
        Largest imbalance of forces and moments, over the load.
    weak_gap : float
        Largest mean gap over a function of the pressure, over its mean elastic deflection.
    outline : float
        Movement of the outline, over its size, in the last step.
    change : float
        L2 norm of its difference from the nodal pressure, over the latter's.
    """

    tension: float
    overlap: float
    equilibrium: float
    weak_gap: float
    outline: float
    change: float


@dataclass(frozen=True, eq=False)
class EdgePressure:
    """Pressure of a contact with its square root at the edge, or the reason why there is none.

    Attributes
    ----------
    contact : ContactFields
    regions : tuple of EdgeRegion
        Connected regions with their outlines, the most loaded first.
    functions : tuple of RegionFunctions
    coefficients : tuple of (n_nodes,) arrays
        c at the contact's nodes, for each region.
    forces : (n,) array
        Contact forces at the points with the same virtual work.
    residuals : EdgeResiduals, optional
    note : str
        Why the nodal pressure has to do; empty if this pressure passed its checks.
    """

    contact: ContactFields
    regions: tuple[EdgeRegion, ...]
    functions: tuple[RegionFunctions, ...]
    coefficients: tuple[Array, ...]
    forces: Array
    residuals: EdgeResiduals | None
    note: str = ""

    @property
    def accepted(self) -> bool:
        """Whether it passed its checks."""
        return not self.note

    @property
    def outlines(self) -> tuple[Outline, ...]:
        """Outlines of the regions."""
        return tuple(region.outline for region in self.regions)

    def sampled(self, n: int = 4) -> tuple[Array, Array, Array]:
        """Pressure sampled inside the facets, as `ContactFields.sampled`; the nodal one where it was not accepted.

        Parameters
        ----------
        n : int
            Samples per side of a facet.

        Returns
        -------
        points : (n_samples, 3) array
        values : (n_samples,) array
        areas : (n_samples,) array
        """
        contact = self.contact
        points, nodal, areas = contact.sampled(contact.pressure, n)
        if not self.accepted:
            return points, nodal, areas
        values = nodal.reshape(len(contact.facets), -1)
        places = points.reshape(*values.shape, 3)
        t = (np.arange(n) + 0.5) / n
        local = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
        s, t = local.T
        hats = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1)
        for region, found, c in zip(self.regions, self.functions, self.coefficients, strict=True):
            facets = contact.facets[found.facets]
            smooth = np.einsum("fqa,fa->fq", shapes_on_square(facets, local)[0], c[facets])
            inside = np.where(found.bilinear[:, None], c[facets[:, :4]] @ hats.T, smooth)
            root = np.sqrt(np.maximum(region.outline.level(places[found.facets]), 0.0))
            values[region.near] = 0.0
            values[found.facets] = root * inside
        return points, values.ravel(), areas


class _NotFoundError(Exception):
    """Why there is no edge pressure."""


@dataclass(frozen=True, eq=False)
class _Problem:
    """The condensed problem, and the rows of one contact in it."""

    contact: ContactFields
    problem: ContactProblem
    rows: IntArray
    forces: Array
    corner_areas: Array

    def on_rows(self, nodal: Array) -> Array:
        """Forces (n_candidates, k) of the problem from nodal ones (n_nodes, k) of the contact."""
        at_points = np.asarray(self.contact._at_nodes.T @ nodal)
        out = np.zeros((self.problem.n, nodal.shape[1]))
        known = self.rows >= 0
        if at_points[~known].any():
            raise _NotFoundError("it reaches points that were no candidates")
        out[self.rows[known]] = at_points[known]
        return out


@dataclass(frozen=True, eq=False)
class _Answer:
    """Solution on given outlines, and its change as they move."""

    functions: list[RegionFunctions]
    coefficients: list[Array]
    changes: list[Array]
    columns: Array
    forces: Array
    q: Array


def edge_pressure(contact: ContactFields, problem: ContactProblem, first: int, forces: Array) -> EdgePressure:
    """Edge pressure of a contact.

    Parameters
    ----------
    contact : ContactFields
    problem : ContactProblem
        The condensed problem of the solution.
    first : int
        Row of the contact's first candidate in it.
    forces : (n,) array
        Its solution.
    """
    none = EdgePressure(contact, (), (), (), contact.forces, None)
    if reason := _unsuitable(contact):
        return replace(none, note=reason)
    rows = np.full(len(contact.points), -1)
    rows[contact._candidates] = first + np.arange(len(contact._candidates))
    areas = nodal_areas(contact.nodes, contact.facets[:, :4])
    setting = _Problem(contact, problem, rows, forces, areas)
    try:
        regions = regions_with_edge(contact)
        if not regions:
            raise _NotFoundError("no connected region has enough points for an outline")
        regions, smooth, moved = _settled(setting, regions)
        answer = _answer(setting, regions, smooth)
    except _NotFoundError as reason:
        return replace(none, note=f"nodal pressure: {reason}")
    at_points = np.zeros(len(contact.points))
    at_points[contact._candidates] = answer.forces[rows[contact._candidates]]
    parts = tuple(regions), tuple(answer.functions), tuple(answer.coefficients)
    out = EdgePressure(contact, *parts, at_points, None)
    residuals = _residuals(setting, answer, moved, _change(out))
    return replace(out, residuals=residuals, note=_objection(out, residuals))


def _change(found: EdgePressure) -> float:
    """Relative L2 norm of the difference from the nodal pressure."""
    contact = found.contact
    (_, nodal, areas), (_, values, _) = contact.sampled(contact.pressure, SAMPLES), found.sampled(SAMPLES)
    return float(np.sqrt(areas @ (values - nodal) ** 2 / (areas @ nodal**2)))


def _unsuitable(contact: ContactFields) -> str:
    """Why a contact has no pressure with a square root on facets; empty if it may have one."""
    reasons = (
        (not contact.active.any(), "nothing touches"),
        (contact._is_curve, "the bodies are sections"),
        (contact.coupling != "nodal", "with mortar coupling forces are means over multiplier functions"),
        (contact.friction is not None, "with friction the pressures follow from the tractions too"),
        (contact._surface.cell_area is not None, "the surface is a grid of cells"),
        (
            contact.slave._is_foundation or contact.master._is_foundation,
            "on an elastic foundation the pressure falls to zero linearly",
        ),
    )
    return next((f"nodal pressure: {reason}" for found, reason in reasons if found), "")


def _answer(setting: _Problem, regions: Sequence[EdgeRegion], smooth: Sequence[Mask | None]) -> _Answer:
    """Galerkin's solution on given outlines. Points with force outside the regions keep their own unknown."""
    contact, problem = setting.contact, setting.problem
    for region in regions:
        if not (region.outline.level(contact.nodes[contact.facets[region.near]]) > 0).any():
            raise _NotFoundError("its outline vanishes")
    functions = [
        region_functions(contact, region.outline, region.near, setting.corner_areas, s)
        for region, s in zip(regions, smooth, strict=True)
    ]
    own = [setting.on_rows(found.forces) for found in functions]
    others = setting.forces > 0
    covered = np.zeros(len(contact.points), bool)
    for region in regions:
        covered |= contact.region == region.number
    others[setting.rows[covered & (setting.rows >= 0)]] = False
    columns = np.concatenate([*own, np.eye(problem.n)[:, others]], axis=1)
    response = problem.S @ columns
    S, B = columns.T @ response, problem.B @ columns
    S = (S + S.T) / 2

    def solved(g: Array, F: Array) -> tuple[Array, Array]:
        small = ContactProblem(S, g, B, F).scaled()
        found = solve_on(small, np.arange(small.n))
        return small.forces(found.x), small.motion(found.p)

    c, q = solved(columns.T @ problem.g, problem.F)
    ends = np.cumsum([0] + [part.shape[1] for part in own])
    coefficients = [f.extension @ c[s:e] for f, s, e in zip(functions, ends[:-1], ends[1:], strict=True)]
    changes = []
    for f, at_nodes, s, e in zip(functions, coefficients, ends[:-1], ends[1:], strict=True):
        moved = setting.on_rows(f.by_outline(at_nodes))
        away, load = response.T @ moved, problem.B @ moved
        changes.append(
            np.stack([f.extension @ solved(a, -b)[0][s:e] for a, b in zip(away.T, load.T, strict=True)], axis=1)
        )
    return _Answer(functions, coefficients, changes, columns, columns @ c, q)


def _settled(setting: _Problem, regions: list[EdgeRegion]) -> tuple[list[EdgeRegion], list[Mask | None], float]:
    """Regions with the outlines on which c is smoothest near the edge, and the last movement."""
    smooth: list[Mask | None] = [None] * len(regions)
    for degree in DEGREES:
        regions = [replace(r, outline=r.outline.to_degree(degree, r.mirrors)) for r in regions]
        for _ in range(STEPS):
            answer = _answer(setting, regions, smooth)
            if smooth[0] is None:
                pairs = zip(answer.functions, answer.coefficients, strict=True)
                smooth = [nearly_bilinear(setting.contact, f, c) for f, c in pairs]
                answer = _answer(setting, regions, smooth)
            steps = _steps(setting, regions, answer)
            moved = max(_movement(r.outline, step) for r, step in zip(regions, steps, strict=True))
            regions = [replace(r, outline=r.outline.moved(step)) for r, step in zip(regions, steps, strict=True)]
            if moved < STEP_TOLERANCE:
                break
        if moved > ACCEPTED_STEP:
            raise _NotFoundError("its outline did not settle")
        higher = [replace(r, outline=r.outline.to_degree(degree + 2, r.mirrors)) for r in regions]
        answer = _answer(setting, higher, smooth)
        steps = _steps(setting, higher, answer)
        if max(_movement(r.outline, step) for r, step in zip(higher, steps, strict=True)) < FOUND:
            return regions, smooth, moved
    raise _NotFoundError(f"its outline is not that of a polynomial of degree {DEGREES[-1]}")


def _steps(setting: _Problem, regions: Sequence[EdgeRegion], answer: _Answer) -> list[Array]:
    parts = zip(regions, answer.functions, answer.coefficients, answer.changes, strict=True)
    return [_step(setting, region, found, c, changes) for region, found, c, changes in parts]


def _step(setting: _Problem, region: EdgeRegion, found: RegionFunctions, c: Array, changes: Array) -> Array:
    """Change (n_terms,) of the outline that makes the coefficients (n_nodes,) near the edge smoothest."""
    contact, outline = setting.contact, region.outline
    facets = contact.facets[found.facets]
    reached = np.zeros(len(contact.nodes), bool)
    zone = (outline.level(contact.nodes[facets]) <= 0).any(axis=1)
    for _ in range(SMOOTH_LAYERS):
        reached[facets[zone, :4]] = True
        zone = reached[facets[:, :4]].any(axis=1)
    own = found.own[reached[found.own]] if reached.any() else found.own
    x = contact.nodes[own]
    angular = outline.angular_terms(x)
    smooth = np.concatenate([angular, angular * outline.level(x)[:, None]], axis=1)
    system = np.concatenate([changes[own], -smooth], axis=1)
    if system.shape[0] < system.shape[1]:
        raise _NotFoundError("too few facets lie round its edge")
    step = np.linalg.lstsq(system, -c[own], rcond=1e-10)[0][: changes.shape[1]]
    return np.clip(step, -MAX_STEP, MAX_STEP)


def _movement(outline: Outline, step: Array) -> float:
    """Largest movement of an outline, relative to its size."""
    return float(np.abs(outline.terms(outline.ring()) @ step).max() / 2)


def _residuals(setting: _Problem, answer: _Answer, moved: float, change: float) -> EdgeResiduals:
    problem = setting.problem
    deflection = problem.S @ answer.forces
    gap = deflection + problem.g + problem.B.T @ answer.q
    scale = float(np.abs(deflection).max())
    outside = ~(answer.columns != 0).any(axis=1)
    mean = np.abs(answer.columns.T) @ np.abs(deflection)
    weak = np.divide(np.abs(answer.columns.T @ gap), mean, out=np.zeros_like(mean), where=mean > 0)
    lowest = min(float(c[f.own].min()) for f, c in zip(answer.functions, answer.coefficients, strict=True))
    peak = max(float(c.max()) for c in answer.coefficients)
    return EdgeResiduals(
        tension=max(0.0, -lowest / peak) if peak > 0 else np.inf,
        overlap=max(0.0, -float(gap[outside].min(initial=0.0))) / scale if scale > 0 else np.inf,
        equilibrium=problem.residuals(answer.forces, answer.q).equilibrium,
        weak_gap=float(weak.max()),
        outline=moved,
        change=change,
    )


def _objection(found: EdgePressure, r: EdgeResiduals) -> str:
    """Why an edge pressure does not pass; empty if it does."""
    assert found.contact._readings is not None
    likely = MAX_CHANGE * found.contact._readings.error
    checks = (
        (r.tension > TENSION, f"it would pull, by {r.tension:.1%} of its peak"),
        (r.overlap > OVERLAP, f"the bodies would overlap beside it, by {r.overlap:.1%} of the elastic deflection"),
        (r.equilibrium > BALANCE, f"its forces are not in equilibrium, by {r.equilibrium:.0e}"),
        (r.weak_gap > BALANCE, f"its mean gaps are not zero, but {r.weak_gap:.0e} of the deflection"),
        (_leaves(found), "its outline leaves the surface"),
        (r.change > likely, f"it differs by {r.change:.1%}, more than the estimated error of {likely:.1%} explains"),
    )
    return next((f"nodal pressure: {words}" for failed, words in checks if failed), "")


def _leaves(found: EdgePressure) -> bool:
    """Whether facets cover less than the outlines enclose."""
    pairs = zip(found.regions, found.functions, strict=True)
    return any(f.area * 2 ** len(r.mirrors) < (1 - AREA) * r.outline.area for r, f in pairs)
