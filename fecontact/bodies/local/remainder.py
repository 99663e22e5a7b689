"""Remainder of a body's compliance after that of a half-space: smooth, from a coarse finite element model.

The response of the surface to a point load is that of a half-space, u_B, plus a remainder. The remainder is the
displacement of the body under the tractions -t(u_B) on its other faces and the displacements -u_B of its supports; it
has no singularity, so a coarse mesh gives it, and a polynomial interpolates it, in the point of observation and in that
of the load. This is subtraction of a fundamental solution, as in the treatment of point loads and cracks by finite
elements.

By Betti's theorem the remainder is symmetric in the two points. Of finite elements it is so up to their error: its
asymmetry is an estimate of that error, which costs nothing.

Remainder on a finer mesh, where the body's own is too coarse for what lies beside its window, such as an edge.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from fecontact.analytic.face_loads import FaceLoads, displacements, stresses
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.local.factored import Factored
from fecontact.bodies.local.relief import coefficients, interpolation
from fecontact.bodies.local.stack import Stack, contrast_loads, stack_below
from fecontact.bodies.local.window import Window, facing, own_part, singular_part, sources
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.halfspace.smooth import SmoothTerm
from fecontact.mesh.facets import facet_integrals
from fecontact.mesh.mesh import Mesh
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.nodal_weights import components_along

ORDERS = (6, 8, 10, 12)
"""Nodes along each side of a window that are tried in turn; even, so that half of them serve where it is mirrored."""

SMALL = 1e-4
"""Coefficients of the highest degree, relative to the mean compliance of the window, at which the order suffices."""

OF_DEFECT = 0.5
"""The same relative to the asymmetry, which is the mesh's error: more nodes would follow that."""

DECAY = 0.7
"""Ratio of these coefficients at one order to those at the last from which more nodes are of no use."""

MAX_DEFECT = 0.01
"""Asymmetry of the remainder, relative to the mean compliance of the window, from which it is found on a finer mesh."""

BESIDE = 0.05
"""Distance from a window's relief, relative to the window, up to which faces are taken to be on it."""

IN_PLANE = 1e-9
"""Distance from a plane, relative to the body's size, within which a face lies in it."""

RULES = ((1.0, 11), (2.5, 6), (5.0, 4), (np.inf, 3))
"""Distance of faces from the window, in their sizes, up to which a quadrature of an order serves."""

OF_LAYERS = 24
"""Nodes along each side of a window for the mean effect of layers."""

MIN_MEAN = 1e-3
"""Mean compliance of a window, relative to a half-space's, below which it is not resolved: taken as that, so that the
asymmetry and the last coefficients show it."""

UNIFORM = 2.973210
"""Mean of 1/r between the points of a unit square: 4 ln(1 + sqrt 2) - 4/3 (sqrt 2 - 1)."""


@dataclass(frozen=True, eq=False)
class Remainder:
    """Remainder at the Chebyshev nodes of a window.

    Attributes
    ----------
    window : Window
    order : int
        Nodes along each side.
    core : (k, k) array
        Displacements into the body at the nodes by unit forces there, symmetric.
    fields : (n_dofs, k) array
        Displacements of the mesh's nodes, without those of the half-space.
    material : Material
        Of the half-space.
    sources : tuple of FaceLoads
        The unit loads at the nodes.
    mean : float
        Mean displacement of the window per force uniform over it.
    defect : float
        Largest asymmetry of the core before it was made symmetric, relative to the mean.
    tail : float
        Largest coefficient of the highest degree, relative to the same.
    stack : Stack, optional
        Layers whose kernel takes a part of the remainder; None: the kernel of a homogeneous half-space.
    """

    window: Window
    order: int
    core: Array
    fields: Array
    material: Material
    sources: tuple[FaceLoads, ...]
    mean: float
    defect: float
    tail: float
    stack: Stack | None = None

    @cached_property
    def points(self) -> Array:
        """The nodes (k, 3) on the surface, in the body's axes."""
        return self.window.on_surface(*self.window.node_places(self.order))

    @cached_property
    def term(self) -> SmoothTerm:
        """The remainder between the window's cells."""
        x, y = (
            interpolation(along, half, self.order, mirrored)
            for along, half, mirrored in zip(self.window.along, self.window.half, self.window.mirrored, strict=True)
        )
        return SmoothTerm(x, y, self.core, self.window.grid.area)


def remainder(factored: Factored, window: Window, material: Material) -> Remainder:
    """Remainder of a body in a window, with as many nodes as its smoothness needs.

    Parameters
    ----------
    factored : Factored
    window : Window
    material : Material
        Of the body below the window.

    Returns
    -------
    Remainder
    """
    stack = stack_below(factored, window)
    found = _at_order(factored, window, material, ORDERS[0], stack)
    for order in ORDERS[1:]:
        before = found.tail
        if before <= max(SMALL, OF_DEFECT * found.defect):
            break
        found = _at_order(factored, window, material, order, stack)
        if found.tail > DECAY * before:
            break
    return found


def _at_order(factored: Factored, window: Window, material: Material, order: int, stack: Stack | None) -> Remainder:
    mesh, loads = factored.model.mesh, sources(window, order)
    forces = _loads(mesh, window, loads, material) + contrast_loads(factored.model, loads, material)
    fields = factored.solve(forces, _at_supports(factored, loads, material))
    points = window.on_surface(*window.node_places(order))
    inwards = np.tile(-window.normal, (len(points), 1))
    core = components_along(surface_weights(mesh, window, points), inwards) @ fields
    if window.relief is not None:
        core = core + _direct(points, loads, inwards[0], material) - singular_part(window, order, material)
        core = core + np.diag(own_part(window, order, loads, material))
    asymmetry, core = _asymmetry(core), (core + core.T) / 2
    tail = _tail(core, window, order)
    if stack is not None:
        layered = core - stack.difference(window, order)
        less = _tail(layered, window, order)
        core, tail, stack = (layered, less, stack) if less < tail else (core, tail, None)
    alone = half_space_compliance(window, material)
    smooth = _mean(core, window, order)
    if stack is not None:
        smooth += _mean(stack.difference(window, OF_LAYERS), window, OF_LAYERS)
    mean = max(alone + smooth, MIN_MEAN * alone)
    return Remainder(window, order, core, fields, material, loads, mean, asymmetry / mean, tail / mean, stack)


def _direct(points: Array, loads: Sequence[FaceLoads], inwards: Array, material: Material) -> Array:
    """Displacements (k, k) into the body at points by the half-spaces' fields of loads there and of their images.

    A load's own at its place is left out, see `own_part`.
    """
    out = np.zeros((len(points), len(loads)))
    for k, load in enumerate(loads):
        others = np.arange(len(points)) != k
        out[others, k] = (displacements(points[others], load, material) @ inwards).sum(axis=0)
        if len(load.places) > 1:
            mirrored = FaceLoads(
                load.places[1:],
                load.normals[1:],
                load.forces[1:],
                None if load.curvatures is None else load.curvatures[1:],
                load.length,
            )
            out[k, k] = (displacements(points[k : k + 1], mirrored, material) @ inwards).sum()
    return out


def half_space_compliance(window: Window, material: Material) -> float:
    """Mean displacement of the window, as part of a half-space, per force uniform over it."""
    side = float(np.sqrt(np.prod(window.grid.size)))
    return UNIFORM / (np.pi * material.plane_strain_modulus * side) * 2 ** sum(window.mirrored)


def _mean(core: Array, window: Window, order: int) -> float:
    """Mean displacement of the window by the remainder, per force uniform over it."""
    x, y = (
        interpolation(along, half, order, mirrored).mean(axis=0)
        for along, half, mirrored in zip(window.along, window.half, window.mirrored, strict=True)
    )
    weights = np.outer(x, y).ravel()
    return float(weights @ core @ weights)


def _asymmetry(core: Array) -> float:
    return float(np.abs(core - core.T).max()) / 2


def _tail(core: Array, window: Window, order: int) -> float:
    """Largest coefficient of the highest degree along either direction of the point of observation."""
    matrices = [
        coefficients(half, order, mirrored) for half, mirrored in zip(window.half, window.mirrored, strict=True)
    ]
    kx, ky = (len(m) for m in matrices)
    values = np.einsum("ia,jb,abn->ijn", *matrices, core.reshape(kx, ky, -1))
    return float(max(np.abs(values[-1]).max(), np.abs(values[:, -1]).max()))


def in_planes(mesh: Mesh, window: Window) -> tuple[IntArray, IntArray]:
    """Outer faces (n, 2) without traction, in a flat window or on planes of symmetry, and the others."""
    faces = mesh.outer_faces
    corners = window.coordinates(mesh.points)[mesh.face_nodes(faces)[:, :4]]
    flat = np.abs(corners).max(axis=1) <= IN_PLANE * np.ptp(mesh.points, axis=0).max()
    free = (flat & np.array([*window.mirrored, window.relief is None])).any(axis=1)
    return faces[free], faces[~free]


def facet_groups(mesh: Mesh, faces: IntArray) -> Iterator[IntArray]:
    """Facets of faces (n, 2), those with a mid-face node apart from those without."""
    middle = np.zeros(len(faces), bool)
    if mesh.midface is not None:
        middle = mesh.midface[faces[:, 0], faces[:, 1]] >= 0
    for chosen in (middle, ~middle):
        if chosen.any():
            yield mesh.face_nodes(faces[chosen])


def _loads(mesh: Mesh, window: Window, loads: Sequence[FaceLoads], material: Material) -> Array:
    """Nodal forces (n_dofs, k) of the tractions of point loads on the other faces, with opposite sign."""
    f = np.zeros((len(mesh.points), 3, len(loads)))
    for facets in facet_groups(mesh, in_planes(mesh, window)[1]):
        corners = mesh.points[facets[:, :4]]
        size = np.linalg.norm(np.ptp(corners, axis=1), axis=1)
        away = np.linalg.norm(corners - window.origin, axis=2).min(axis=1) - np.linalg.norm(window.half)
        rule = np.searchsorted([limit for limit, _ in RULES], away / size)
        for k, (_, order) in enumerate(RULES):
            chosen = rule == k
            if not chosen.any():
                continue
            N, x, dA = facet_integrals(mesh.points, facets[chosen], order)
            x, dA = _smoothed(window, x, dA)
            for n, load in enumerate(loads):
                stress = stresses(x.reshape(-1, 3), load, material).sum(axis=0).reshape(*x.shape, 3)
                nodal = np.einsum("fqa,fqij,fqj->fai", N, stress, dA, optimize=True)
                np.subtract.at(f[:, :, n], facets[chosen], nodal)
    return f.reshape(-1, len(loads))


def _smoothed(window: Window, x: Array, dA: Array) -> tuple[Array, Array]:
    """Points (..., 3) and areas (..., 3) of faces, those near the window on its relief instead of the mesh.

    Near a load the traction on a face that is tangent to the surface is bounded; on the mesh's faces it is not.
    """
    if window.relief is None:
        return x, dA
    local = window.coordinates(x)
    u, v = local[..., 0], local[..., 1]
    depth = window.relief.depth(u, v)
    on = window.relief.covers(u, v) & (np.abs(local[..., 2] + depth) <= BESIDE * np.linalg.norm(window.half))
    up = np.concatenate([window.relief.slopes(u, v), np.ones((*u.shape, 1))], axis=-1) @ window.axes.T
    there = window.at(u, v) - depth[..., None] * window.normal
    projected = (dA @ window.normal)[..., None] * up
    return np.where(on[..., None], there, x), np.where(on[..., None], projected, dA)


def _at_supports(factored: Factored, loads: Sequence[FaceLoads], material: Material) -> Array:
    """Displacements (n_dofs, k) that the supports need: those of point loads, with opposite sign; zero elsewhere."""
    model = factored.model
    points = model.mesh.points
    marks = np.zeros(model.n_coordinates)
    marks[factored.held] = 1.0
    nodes = np.flatnonzero(marks.reshape(-1, 3).any(axis=1))
    if model.coordinates.ties is not None:
        nodes = model.coordinates.ties.free[nodes]
    out = np.zeros((len(points), 3, len(loads)))
    for k, load in enumerate(loads):
        out[nodes, :, k] = -displacements(points[nodes], load, material).sum(axis=0)
    return out.reshape(-1, len(loads))


def surface_weights(mesh: Mesh, window: Window, points: Array) -> sp.csr_matrix:
    """Interpolation (n, n_nodes) of the surface of the window, from the mesh's nodes to points (n, 3)."""
    nearest, out = np.full(len(points), np.inf), sp.csr_matrix((len(points), len(mesh.points)))
    for facets in facet_groups(mesh, facing(mesh, mesh.outer_faces, window.normal)):
        found = FacetSurface(mesh.points, facets).project(points)
        away = np.linalg.norm(points - found.points, axis=1)
        better = away < nearest
        nearest = np.minimum(nearest, away)
        assert found.weights is not None
        out = sp.diags_array((~better).astype(float)) @ out + sp.diags_array(better.astype(float)) @ found.weights
    return sp.csr_matrix(out)


SIZES = (2.0, 1.0, 0.5, 0.25)
"""Sizes of cells that are tried, over their distance from the images of the window's points."""

MIN_GAP = 0.05
"""Least distance of a point from the other faces that counts, over the half-diagonal of the window."""

MAX_CELLS, GROWTH = 4000, 3
"""Cells up to which a mesh is divided by itself, and up to how many times its own; some ten seconds."""

HOPELESS = 10.0
"""Asymmetry after two divisions, over the largest allowed, from which more cells are of no use: the window is too near.
"""


def on_divided_mesh(body: ElasticBody, window: Window, material: Material, found: Remainder, name: str) -> Remainder:
    """The remainder of a body with its mesh divided round the window until it is symmetric, at the body's own nodes.

    Raises
    ------
    InputError
        If that takes too many cells.
    """
    finer, tried, most = body, len(body.mesh.cells), max(MAX_CELLS, GROWTH * len(body.mesh.cells))
    for times, size in enumerate(SIZES):
        if times >= 2 and found.defect > HOPELESS * MAX_DEFECT:
            break
        finer = _divided(finer, window, found.order, size, most)
        if len(finer.mesh.cells) > most:
            break
        if len(finer.mesh.cells) == tried:
            continue
        tried = len(finer.mesh.cells)
        found = remainder(Factored.of(finer.model, window.origin[None]), window, material)
        if found.defect <= MAX_DEFECT:
            _, same = cKDTree(finer.mesh.points).query(body.mesh.points)
            fields = found.fields.reshape(len(finer.mesh.points), 3, -1)[same]
            return replace(found, fields=fields.reshape(3 * len(same), -1))
    needs = "more cells are of no use so near"
    if len(finer.mesh.cells) > tried:
        needs = f"it would take more than {len(finer.mesh.cells)} cells"
    raise InputError(
        f"The compliance of {name!r} in its window contradicts Betti's theorem by {100 * found.defect:.2g} %, more "
        f"than {100 * MAX_DEFECT:g} %, also with its mesh divided round the window, to {tried} cells: {needs} to "
        "what lies beside or below the window (edges, holes, supports, layers). Take a smaller window, or a finer mesh "
        f"there; its sides are {window.grid.size}.",
        code="compliance-not-symmetric",
    )


def _divided(body: ElasticBody, window: Window, order: int, size: float, most: int) -> ElasticBody:
    """The body with cells no larger than a share of their distance from the images of the window's points.

    An image lies beyond the face nearest to a point, as far from it as the point; it is where the smooth field that the
    mesh carries would be singular.
    """
    points = window.on_surface(*window.node_places(order))
    nearest, gap = np.zeros(points.shape), np.full(len(points), np.inf)
    for facets in facet_groups(body.mesh, in_planes(body.mesh, window)[1]):
        there = FacetSurface(body.mesh.points, facets).project(points).points
        away = np.linalg.norm(there - points, axis=1)
        nearest, gap = np.where((away < gap)[:, None], there, nearest), np.minimum(away, gap)
    gap = np.maximum(gap, MIN_GAP * float(np.linalg.norm(window.half)))
    while len(body.mesh.cells) <= most:
        corners = body.mesh.points[body.mesh.cells[:, : body.mesh.n_corners]]
        away = np.full(len(corners), np.inf)
        for place, beyond in zip(nearest, gap, strict=True):
            away = np.minimum(away, np.linalg.norm(corners - place, axis=2).min(axis=1) + beyond)
        large = np.ptp(corners, axis=1).max(axis=1) > size * away
        if not large.any():
            break
        body = body.divided({}, np.flatnonzero(large))
    return body
