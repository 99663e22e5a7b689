"""Remainder of a body's compliance after that of a half-space: smooth, from a coarse finite element model.

The response of the surface to a point load is that of a half-space, u_B, plus a remainder. The remainder is the
displacement of the body under the tractions -t(u_B) on its other faces and the displacements -u_B of its supports; it
has no singularity, so a coarse mesh gives it, and a polynomial interpolates it, in the point of observation and in that
of the load. This is subtraction of a fundamental solution, as in the treatment of point loads and cracks by finite
elements.

By Betti's theorem the remainder is symmetric in the two points. Of finite elements it is so up to their error: its
asymmetry is an estimate of that error, which costs nothing.

Remainder on a finer mesh, where the body's own is too coarse for what lies beside its window, such as an edge.

A body's stiffness, factorised once: displacements under loads and given displacements of what is held.

Materials of a body below its window: the one at the surface, and the layers where they follow each other in depth.

The remainder starts from the half-space of the material at the surface. Where layers lie below, it varies over their
thickness; the kernel of the layered half-space takes that part, whose difference from the homogeneous one,

    D(r) = int (k C(k) - 2/E') J_0(k r) dk/(2 pi),

is known (`halfspace.layered`). What is left at the nodes, R - D, is smooth at the distance of edges and
supports, and the sum of kernel and remainder is the same whatever the layers are taken to be: they need not be plane
or parallel, only nearly so.

Loads on the cells of other materials than that of the half-space which is subtracted.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from fecontact.analytic.face_loads import FaceLoads, displacements, stresses
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.local.window import Window, coefficients, facing, interpolation, own_part, singular_part, sources
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.coordinates import restricted
from fecontact.fem.factor import Factor, factorise
from fecontact.fem.model import Model
from fecontact.fem.stiffness import Batch, batches
from fecontact.fem.support import fix_null_space
from fecontact.halfspace.fft import SmoothTerm
from fecontact.halfspace.layered import Layer, point_difference
from fecontact.mesh.element import FACES
from fecontact.mesh.facets import cells_at_faces, face_keys, facet_integrals
from fecontact.mesh.mesh import Mesh
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.nodal_weights import components_along
from fecontact.surfaces.section_curve import along_line

#: Distance from the window, relative to the body's farthest point, beyond which a floating body may be held.
FAR = 0.5


@dataclass(frozen=True, eq=False)
class Factored:
    """A factor of the stiffness over the coordinates that are not held.

    Attributes
    ----------
    model : Model
    solved, held : int arrays
        Coordinates that are solved, and those held by supports or, one for each free motion, artificially.
    """

    model: Model
    solved: IntArray
    held: IntArray

    @classmethod
    def of(cls, model: Model, origins: Array) -> Factored:
        """Of a model; one that floats is held at nodes far from points (n, 3), where the loads will be."""
        held = np.union1d(model.held, _grounded(model, origins))
        solved = np.setdiff1d(np.arange(model.n_coordinates), held, assume_unique=True)
        made = cls(model, solved, held)
        made._parts  # noqa: B018 - made here
        return made

    def __getstate__(self) -> dict[str, Any]:
        """State for other processes: without the factor, which is a library's memory."""
        return {name: getattr(self, name) for name in ("model", "solved", "held")}

    def serves(self, origin: Array) -> bool:
        """Whether what is held artificially is far from a point (3,)."""
        return not np.isin(np.setdiff1d(self.held, self.model.held), _near(self.model, origin[None])).any()

    @cached_property
    def _parts(self) -> tuple[Factor, sp.csr_matrix]:
        """Factor, and the stiffness (n_solved, n_held) between what is solved and what is held."""
        K = self.model.coordinates.stiffness(self.model.stiffness)
        vars(self.model).pop("stiffness", None)
        beside = K[self.solved][:, self.held] + K[self.held][:, self.solved].T
        return factorise(restricted(K, self.solved), self.model.backend), sp.csr_matrix(beside)

    def solve(self, forces: Array, given: Array | None = None) -> Array:
        """Displacements (n_dofs, m) under forces (n_dofs, m), with those of `given` (n_dofs, m) where it is held."""
        coordinates, (factor, beside) = self.model.coordinates, self._parts
        f = coordinates.forces(forces)[self.solved]
        v = np.zeros((self.model.n_coordinates, forces.shape[1]))
        if given is not None:
            v[self.held] = coordinates.of_displacements(given)[self.held]
            f = f - beside @ v[self.held]
        v[self.solved] = factor.solve(np.ascontiguousarray(f.T)).T
        return coordinates.displacements(v)


def _near(model: Model, origins: Array) -> IntArray:
    """Coordinates that are near points (n, 3)."""
    points = model.coordinates.of_functions(model.mesh.points)
    distance = np.linalg.norm(points[:, None] - origins, axis=2).min(axis=1)
    return np.flatnonzero(np.repeat(distance < FAR * distance.max(), 3))


def _grounded(model: Model, origins: Array) -> IntArray:
    """Coordinates far from points, one for each free motion."""
    if model.free_motions.shape[1] == 0:
        return np.zeros(0, dtype=np.int64)
    held = np.union1d(model.held, _near(model, origins))
    return fix_null_space(model.nodal_modes @ model.free_motions, held, model.size)


#: Places along a side of a window at which its material is looked up.
SAMPLES = 10


@dataclass(frozen=True)
class Stack:
    """Layers below a window, and what they lie on.

    Attributes
    ----------
    layers : tuple of Layer
        From the surface downwards.
    base : Material or None
        The half-space below; None: rigid.
    """

    layers: tuple[Layer, ...]
    base: Material | None

    def difference(self, window: Window, order: int) -> Array:
        """Displacements (k, k) at the nodes by unit loads there and their images, less those without layers."""
        x, y = window.node_places(order)
        point = point_difference(2.0 * float(np.linalg.norm(window.half)), self.layers, self.base)
        signs = itertools.product(*((1, -1) if even else (1,) for even in window.mirrored))
        return np.asarray(
            sum(point(np.hypot(x[:, None] - sx * x, y[:, None] - sy * y)) for sx, sy in signs), dtype=float
        )


def material_at(model: Model, window: Window) -> Material:
    """The material of a body in its window.

    Raises
    ------
    InputError
        If there are several.
    """
    if len(model.materials) == 1:
        return model.materials[0]
    faces = facing(model.mesh, model.mesh.outer_faces, window.normal)
    found = FacetSurface(model.mesh.points, _facets(model.mesh, faces)).project(
        window.on_surface(*window.node_places(SAMPLES))
    )
    assert found.facet is not None
    kinds = np.unique(_distinct(model)[faces[found.facet, 0]])
    if len(kinds) > 1:
        raise InputError(
            f"The window, sides {window.grid.size} about {np.array2string(window.origin, precision=4)}, reaches across "
            f"a boundary of materials: {', '.join(repr(model.materials[k]) for k in kinds)} lie in it. Take a smaller "
            "window, or use the ElasticBody itself with accuracy= when the scene is solved.",
            code="window-across-materials",
        )
    return model.materials[kinds[0]]


def stack_below(factored: Factored, window: Window) -> Stack | None:
    """The layers that a line into the body from the middle of a window crosses; None if nothing else lies there."""
    mesh, materials = factored.model.mesh, factored.model.materials
    kind = _distinct(factored.model)
    keys = face_keys(mesh.cells[:, FACES[:, :4]])
    outer = np.zeros(keys.shape, bool)
    outer[tuple(mesh.outer_faces.T)] = True
    layers: list[Layer] = []
    depth, now = 0.0, materials.index(material_at(factored.model, window))
    for _ in range(len(mesh.cells)):  # layers, of which there are at most as many as cells
        cells = np.flatnonzero(kind == now)
        local = np.argwhere(cells_at_faces(mesh.cells[cells]) == 1)
        below = facing(mesh, np.stack([cells[local[:, 0]], local[:, 1]], axis=1), -window.normal)
        material = materials[now]
        if len(below) == 0:
            return None
        exits = FacetSurface(mesh.points, _facets(mesh, below))
        start = window.origin - depth * window.normal
        travel, found, lost = along_line(exits, start[None], -window.normal, facing=False)
        if lost[0] or found.outside[0] or travel[0] <= 0:
            return None
        assert found.facet is not None
        face = below[found.facet[0]]
        others = np.argwhere((keys == keys[tuple(face)]) & (np.arange(len(keys)) != face[0])[:, None])
        layer = Layer(material, float(travel[0]))
        if len(others):
            layers.append(layer)
            depth, now = depth + layer.thickness, int(kind[others[0, 0]])
        elif outer[tuple(face)] and _is_held(factored, mesh.face_nodes(face[None])[0]):
            return Stack((*layers, layer), None)
        else:
            return Stack(tuple(layers), material) if layers else None
    return None


def _distinct(model: Model) -> IntArray:
    """Index of the material of each cell, the first of equal ones."""
    return np.array([model.materials.index(m) for m in model.materials])[model.material_of_cell]


def _facets(mesh: Mesh, faces: IntArray) -> IntArray:
    return mesh.face_nodes(faces)[:, : 8 if mesh.cells.shape[1] > 8 else 4]


def _is_held(factored: Factored, nodes: IntArray) -> bool:
    """Whether supports hold all components of nodes (n,)."""
    model = factored.model
    held = np.zeros(model.n_coordinates, bool)
    held[model.held] = True
    at = np.asarray(held.reshape(-1, 3).all(axis=1))
    free = np.arange(len(at)) if model.coordinates.ties is None else model.coordinates.ties.free
    return bool(np.isin(nodes, free[at]).all())


def contrast_loads(model: Model, loads: Sequence[FaceLoads], material: Material) -> Array:
    """Nodal forces (n_dofs, k) of -int (C - C_0) : eps_0 : eps(w) dV over the cells of other materials.

    With the strains eps_0 of point loads on a half-space of a material C_0, and C of the cells: what is left of the
    displacements then has the equilibrium of the body as it is. They are the loads of J. D. Eshelby's inclusions, Proc.
    R. Soc. A 241 (1957) 376.

    Parameters
    ----------
    model : Model
    loads : sequence of FaceLoads
    material : Material
    """
    lame, twice_shear = model.lame - material.lame, 2 * (model.shear - material.shear_modulus)
    other = (lame != 0) | (twice_shear != 0)
    f = np.zeros((len(model.mesh.points), 3, len(loads)))
    if not other.any():
        return f.reshape(-1, len(loads))
    none = np.zeros(len(lame))
    # the same rules as the stiffness, lest a nearly incompressible material lock
    rules = [(batches(model.mesh), none if model.selective else lame, twice_shear)]
    if model.selective:
        rules.append((batches(model.mesh, reduced=True), lame, none))
    for made, volumetric, deviatoric in rules:
        for batch in made:
            part = _part(batch, other[batch.cells])
            for n, load in enumerate(loads if len(part.cells) else ()):
                nodal = _stretched(model.mesh, part, load, material, volumetric[part.cells], deviatoric[part.cells])
                np.subtract.at(f[:, :, n], part.nodes, nodal)
    return f.reshape(-1, len(loads))


def _part(batch: Batch, chosen: Mask) -> Batch:
    return Batch(batch.cells[chosen], batch.nodes[chosen], batch.N, batch.gradients[chosen], batch.dV[chosen])


def _stretched(mesh: Mesh, batch: Batch, load: FaceLoads, material: Material, lame: Array, twice_shear: Array) -> Array:
    """Nodal forces (n_cells, n_functions, 3) of stresses lame tr(eps) I + twice_shear eps under point loads."""
    x = np.einsum("qa,cai->cqi", batch.N, mesh.points[batch.nodes])
    sigma = stresses(x.reshape(-1, 3), load, material).sum(axis=0).reshape(*x.shape, 3)
    mean = np.trace(sigma, axis1=2, axis2=3)[..., None, None] * np.eye(3)
    eps = ((1 + material.nu) * sigma - material.nu * mean) / material.E
    volume = (1 - 2 * material.nu) / material.E * mean
    stress = lame[:, None, None, None] * volume + twice_shear[:, None, None, None] * eps
    return np.asarray(np.einsum("cqaj,cqij,cq->cai", batch.gradients, stress, batch.dV, optimize=True))


#: Nodes along each side of a window that are tried in turn; even, so that half of them serve where it is mirrored.
ORDERS = (6, 8, 10, 12)

#: Coefficients of the highest degree, relative to the mean compliance of the window, at which the order suffices.
SMALL = 1e-4

#: The same relative to the asymmetry, which is the mesh's error: more nodes would follow that.
OF_DEFECT = 0.5

#: Ratio of these coefficients at one order to those at the last from which more nodes are of no use.
DECAY = 0.7

#: Asymmetry of the remainder, relative to the mean compliance of the window, from which it is found on a finer mesh.
MAX_DEFECT = 0.01

#: Distance from a window's relief, relative to the window, up to which faces are taken to be on it.
BESIDE = 0.05

#: Distance from a plane, relative to the body's size, within which a face lies in it.
IN_PLANE = 1e-9

#: Distance of faces from the window, in their sizes, up to which a quadrature of an order serves.
RULES = ((1.0, 11), (2.5, 6), (5.0, 4), (np.inf, 3))

#: Nodes along each side of a window for the mean effect of layers.
OF_LAYERS = 24

#: Mean compliance of a window, relative to a half-space's, below which it is not resolved: taken as that, so that the
#: asymmetry and the last coefficients show it.
MIN_MEAN = 1e-3

#: Mean of 1/r between the points of a unit square: 4 ln(1 + sqrt 2) - 4/3 (sqrt 2 - 1).
UNIFORM = 2.973210


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
    asymmetry, core = float(np.abs(core - core.T).max()) / 2, (core + core.T) / 2
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


#: Sizes of cells that are tried, over their distance from the images of the window's points.
SIZES = (2.0, 1.0, 0.5, 0.25)

#: Least distance of a point from the other faces that counts, over the half-diagonal of the window.
MIN_GAP = 0.05

#: Cells up to which a mesh is divided by itself, and up to how many times its own; some ten seconds.
MAX_CELLS, GROWTH = 4000, 3

#: Asymmetry after two divisions, over the largest allowed, from which more cells are of no use: the window is too near.
HOPELESS = 10.0


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
        body = body._divided({}, np.flatnonzero(large))
    return body
