"""Normals of a surface of facets that are continuous over its facets' sides.

The normal of a facet is discontinuous at its sides. A line of action needs a continuous one, so nodal normals, averaged
over the facets round each node, are interpolated like positions. On an edge (`MAX_ANGLE`) the normal is not unique:
facets keep their own there. At the rim half of a node's neighbourhood is missing and the average is inclined, which
matters on planes of symmetry only: there the normal is projected onto the plane.

Lines of action: where a line between the normals of both surfaces meets the master.

A pair of points x on the slave and y on the master has one line of action, on which both lie,

    x = y + d m,    m = share n1 + (1 - share) n2(y),    share = c2 / (c1 + c2),

with n2 the master's outward normal at y, n1 the slave's at x reversed, and c = 1 / E* the compliance of either body:
between equal bodies the mean of both normals, against a rigid body the rigid body's normal. Forces along it are
collinear, so moments balance too, and the result does not depend on the choice of slave: mirror images are in contact
along the normal of the plane between them. The three equations are solved for y's coordinates and d by Newton's method
from the nearest point, with normals that are continuous over facets' sides (`surfaces.normals`).

Where no such point exists (the line misses the master at its rim or an edge, or the surfaces do not face each other)
the closest point and the line to it are used.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fecontact.common.arrays import ROUNDING, Array, IntArray, Mask
from fecontact.mesh.facets import facet_nodes, unit_vectors
from fecontact.mesh.surface_mesh import averaged_normals
from fecontact.surfaces.closest_point import (
    BLOCK,
    FacetPolynomials,
    chosen,
    cross,
    dot,
    facet_polynomials,
    first_derivatives,
)
from fecontact.surfaces.facet_surface import BESIDE, FacetSurface, Projection, Surface

#: Largest angle (degrees) between the average at a node and the normal of a facet there, so that a polygon of eight
#: sides counts as round and an edge of 50 degrees as an edge.
MAX_ANGLE = 25.0
#: Largest inclination of an average to a plane of symmetry, relative to the change of the normal over the facets there:
#: half of it for flat facets, more where they become narrower; curved ones are inclined by the cube of their size only.
BIAS_FLAT, BIAS_CURVED = 2.0, 0.2


@dataclass(frozen=True, eq=False)
class Normals:
    """Continuous normals of a surface.

    Attributes
    ----------
    nodal : (n_points, 3) array
        Outward unit vectors at the nodes, zero at other points.
    sharp : (n_points,) bool array
        Nodes on edges.
    field : FacetPolynomials
        Interpolated normals over all facets, only approximately of unit length.
    even : (n_facets,) bool array
        Facets over which they are constant.
    """

    nodal: Array
    sharp: Mask
    field: FacetPolynomials
    even: Mask

    def at(self, facet: IntArray, local: Array) -> Array:
        """Normals (n, 3) at coordinates (n, 2) of facets (n,), by interpolation."""
        return self.field.values(facet, local)


def normals_of(surface: FacetSurface) -> Normals:
    """Continuous normals of a surface, cached; those of a curve are on its ribbon."""
    return surface.spatial.once(_normals)


def field_derivative(surface: FacetSurface, facet: IntArray, local: Array) -> tuple[Array, Array]:
    """Unit normals (n, 3) by interpolation, and their derivatives (n, 3, 2) by facet coordinates."""
    field, turned = normals_of(surface).field.evaluate(facet, local)
    length = np.linalg.norm(field, axis=1)
    unit = field / length[:, None]
    turned = turned - unit[:, :, None] * (unit[:, None] @ turned)
    return unit, turned / length[:, None, None]


#: Step, relative to the size of a shape, of the differences for the derivative of its normals.
NORMAL_STEP = 1e-6
#: Difference of unit normals over that step from which on it crosses an edge.
EDGE = 1e-3


def normal_derivative(surface: Surface, points: Array, size: float) -> Array:
    """Derivative (n, 3, 3) of a surface's normals by the positions of points (n, 3), by differences; none on edges."""
    step, H = NORMAL_STEP * size, np.zeros((len(points), 3, 3))
    for k, unit in enumerate(np.eye(3)):
        ahead, behind = surface.project(points + step * unit), surface.project(points - step * unit)
        H[:, :, k] = ahead.normals - behind.normals
    H[np.abs(H).max(axis=(1, 2)) > EDGE] = 0.0
    return (H + H.swapaxes(1, 2)) / (4 * step)


def opposing(surface: FacetSurface, nodes: IntArray) -> Array:
    """Inward unit normals (n, 3) at nodes (n,); zero on edges."""
    normals = normals_of(surface)
    return np.where(normals.sharp[nodes, None], 0.0, -normals.nodal[nodes])


def _normals(surface: FacetSurface) -> Normals:
    nodal, cosine = averaged_normals(surface.points, surface.facets)
    sharp = cosine < np.cos(np.radians(MAX_ANGLE)) + ROUNDING
    if surface.planes is not None:
        nodal = _within(surface, nodal, *surface.planes)
    if surface.ties is not None:
        # interpolated as they are on the facet whose side is not divided
        nodal = surface.ties.followed(nodal)
    corners = nodal[surface.facets]
    edged = np.flatnonzero(sharp[surface.facets].any(axis=1))
    if len(edged):
        k = surface.facets.shape[1]
        places = np.stack([facet_nodes(k, False), facet_nodes(k, True)])[surface.triangle[edged].astype(int)]
        own = surface.normals(np.repeat(edged, k), places.reshape(-1, 2)).reshape(-1, k, 3)
        corners[edged] = np.where(sharp[surface.facets[edged], None], own, corners[edged])
    index = np.arange(corners.shape[0] * corners.shape[1]).reshape(corners.shape[:2])
    field = facet_polynomials(corners.reshape(-1, 3), index, surface.triangle)
    even = np.ptp(corners, axis=1).max(axis=1) <= 1e-14
    return Normals(nodal, sharp, field, np.asarray(even))


def _within(surface: FacetSurface, nodal: Array, nodes: IntArray, across: Array) -> Array:
    """Nodal normals without components across planes of symmetry that are due to averaging.

    At such a plane the average over half a neighbourhood is inclined by half the change of the normal over a facet,
    much less on curved facets. A larger inclination means that the surface does not meet the plane at a right angle.
    """
    on = np.isin(nodes, surface.of_facets)
    nodes, across = nodes[on], across[on]
    around = surface.facets[surface.facets_of_node[np.searchsorted(surface.of_facets, nodes)]]
    lean = np.einsum("ni,ni->n", nodal[nodes], across)
    turn = np.abs(np.einsum("nfai,ni->nfa", nodal[around], across) - lean[:, None, None]).max(axis=(1, 2))
    biased = np.abs(lean) <= (BIAS_FLAT if surface.facets.shape[1] == 4 else BIAS_CURVED) * turn
    planes = np.zeros((len(nodal), 3, 3))
    np.add.at(planes, nodes[biased], np.einsum("ni,nj->nij", across[biased], across[biased]))
    held = np.unique(nodes[biased])
    inverse = np.linalg.pinv(planes[held], rcond=ROUNDING, hermitian=True)
    inside = nodal[held] - np.einsum("nij,njk,nk->ni", inverse, planes[held], nodal[held])
    out = nodal.copy()
    out[held] = inside / np.linalg.norm(inside, axis=1, keepdims=True)
    return out


#: Cosine between both normals (one reversed) below which surfaces do not face each other: the master's normal is used.
FACING = 0.2
#: Extension of a facet beyond its sides.
SLACK = 0.5
#: Largest number of Newton steps; three or four suffice for small gaps.
MAX_ITERATIONS = 15
#: Step in a facet's coordinates at convergence: the remaining error is of the order of its square.
STEP_TOLERANCE = 1e-7
#: Largest number of facets tried in turn.
MAX_FACETS = 4


def project_along(
    master: Surface, points: Array, normals: Array, share: float, nearest: Projection | None = None
) -> Projection:
    """Projection of points (n, 3) of the slave along lines between both normals.

    Parameters
    ----------
    master : Surface
        One without facets is rigid; its own normal is used.
    points : (n, 3) array
        In the master's axes.
    normals : (n, 3) array
        The slave's unit normals there, reversed so that they point out of the master; zero where there is none.
    share : float
        Weight of the slave's normal, between 0 and 1.
    nearest : Projection, optional
        The closest points, if they are known.
    """
    nearest = master.project(points) if nearest is None else nearest
    if share == 0 or not isinstance(master, FacetSurface):
        return nearest
    assert nearest.facet is not None
    assert nearest.local is not None
    surface = master.spatial
    facet, local = nearest.facet.copy(), nearest.local.copy()
    found = np.zeros(len(points), bool)
    rows = np.arange(len(points))
    for _ in range(MAX_FACETS):
        place, met = meet(surface, facet[rows], local[rows], points[rows], normals[rows], share)
        on = met & _on_facet(surface, facet[rows], place)
        found[rows[on]] = True
        local[rows[on]] = place[on]
        rows, place = rows[~on], place[~on]
        if len(rows) == 0:
            break
        # the line met the facet's extension: the facet below that point is tried next
        landing = surface.evaluate(facet[rows], place)[0]
        below = surface.project(landing, n_near=1)
        assert below.facet is not None
        assert below.local is not None
        other = (below.facet != facet[rows]) & ~below.outside
        rows = rows[other]
        facet[rows], local[rows] = below.facet[other], below.local[other]
    facet, local = np.where(found, facet, nearest.facet), np.where(found[:, None], local, nearest.local)
    along = projection_at(master, facet, local, points, normals, share)
    return replace(
        along,
        normals=np.where(found[:, None], along.normals, nearest.normals),
        gap=np.where(found, along.gap, nearest.gap),
        outside=~found & nearest.outside,
    )


def projection_at(
    master: FacetSurface, facet: IntArray, local: Array, points: Array, normals: Array, share: float
) -> Projection:
    """Projection with known facets (n,) and coordinates (n, 2), on the lines of points (n, 3)."""
    x, _, N = master.evaluate(facet, local)
    lines = share * normals + (1 - share) * normals_of(master).at(facet, local)
    lines = unit_vectors(lines)
    gap = np.einsum("ni,ni->n", points - x, lines)
    outside = np.zeros(len(points), bool)
    return Projection(x, lines, gap, outside, master.rows_of(facet, N), facet, local, master.name)


def _on_facet(surface: FacetSurface, facet: IntArray, local: Array) -> Mask:
    """Whether coordinates (n, 2) lie on facets (n,)."""
    most = np.where(surface.triangle[facet], local.sum(axis=1), local.max(axis=1))
    return np.asarray((local.min(axis=1) >= -BESIDE) & (most <= 1 + BESIDE))


def meet(
    surface: FacetSurface,
    facet: IntArray,
    local: Array,
    points: Array,
    normals: Array,
    share: float,
    slack: float = SLACK,
) -> tuple[Array, Mask]:
    """Intersection of lines through points (n, 3) with given facets, extended beyond their sides.

    Parameters
    ----------
    surface : FacetSurface
    facet, local : (n,) and (n, 2) arrays
        Facets, and initial coordinates.
    points : (n, 3) array
    normals : (n, 3) array
        At the points, oriented as the surface's normals; zero where there is none.
    share : float
        Weight of `normals`; the surface's own have weight 1 - share.
    slack : float
        Extension of the facets beyond their sides.

    Returns
    -------
    local : (n, 2) array
    met : (n,) bool array
    """
    out, met = np.empty((len(points), 2)), np.empty(len(points), bool)
    for first in range(0, len(points), BLOCK):
        part = slice(first, first + BLOCK)
        out[part], met[part] = _met(surface, facet[part], local[part], points[part], normals[part], share, slack)
    return out, met


def _met(
    surface: FacetSurface,
    facet: IntArray,
    local: Array,
    points: Array,
    normals: Array,
    share: float,
    slack: float,
) -> tuple[Array, Mask]:
    """`meet` for one block of points."""
    local, met = np.clip(local, -slack, 1 + slack).T.copy(), np.zeros(len(points), bool)
    active = np.flatnonzero(_facing(surface, facet, local.T, normals))
    polynomials = _lines_from(surface, facet[active], points[active], normals[active], share)
    only_triangles = surface.polynomials.only_triangles
    going, d = np.ones(len(active), bool), np.zeros(0)
    for k in range(MAX_ITERATIONS if len(active) else 0):
        before = local[:, active]
        value, along_s, along_t = first_derivatives(polynomials, before[0], before[1], only_triangles)
        r, m = value[:3], value[3:]
        d = d if k else -dot(r, m) / dot(m, m)
        F, a, b = r + d * m, along_s[:3] + d * along_s[3:], along_t[:3] + d * along_t[3:]
        b_m, a_F = cross(b, m), cross(a, F)
        det = dot(a, b_m)
        # beyond a centre of curvature the lines have crossed
        forward = det > 0
        inverse = np.divide(-1.0, det, out=np.zeros_like(det), where=forward & going)
        step = np.stack([dot(F, b_m), dot(m, a_F)])
        step *= inverse
        d = d - dot(a_F, b) * inverse
        after = np.clip(before + np.clip(step, -1.0, 1.0), -slack, 1 + slack)
        local[:, active] = after
        small = forward & (np.abs(step).max(axis=0) <= STEP_TOLERANCE)
        met[active[going & small]] = True
        going &= forward & ~small & (after != before).any(axis=0)
        left = np.flatnonzero(going)
        if len(left) == 0:
            break
        # the others stay where they are; to leave them out of the arrays takes as long as a step
        if 2 * len(left) < len(active):
            active, polynomials, d, going = active[left], polynomials[..., left], d[left], going[left]
    out = np.ascontiguousarray(local.T)
    met[met] = _facing(surface, facet[met], out[met], normals[met])
    return out, met


def _lines_from(surface: FacetSurface, facet: IntArray, points: Array, normals: Array, share: float) -> Array:
    """Coefficients (m, m, 6, n) of facets relative to points (n, 3), and of the lines of action."""
    field, place = normals_of(surface).field, surface.polynomials
    m = len(place.coefficients)
    out = np.empty((m, m, 6, len(facet)))
    for i in range(m):
        for j in range(m - i if place.only_triangles else m):
            chosen(place.coefficients[i, j], facet, out[i, j, :3])
            chosen(field.coefficients[i, j], facet, out[i, j, 3:])
            out[i, j, 3:] *= 1 - share
    out[0, 0, :3] += chosen(place.origin, facet) - points.T
    out[0, 0, 3:] += share * normals.T + (1 - share) * chosen(field.origin, facet)
    return out


def _facing(surface: FacetSurface, facet: IntArray, local: Array, normals: Array) -> Mask:
    """Mask of normals (n, 3) oriented as the surface's; True for zero ones."""
    own = normals_of(surface).at(facet, local)
    cosine = np.einsum("ni,ni->n", own, normals)
    return np.asarray((cosine >= FACING * np.linalg.norm(own, axis=1)) | ~normals.any(axis=1))
