"""Materials of a body below its window: the one at the surface, and the layers where they follow each other in depth.

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
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fecontact.analytic.face_loads import FaceLoads, stresses
from fecontact.bodies.local.factored import Factored
from fecontact.bodies.local.window import Window, facing
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.model import Model
from fecontact.fem.stiffness import Batch, batches
from fecontact.halfspace.layered import Layer, point_difference
from fecontact.mesh.element import FACES
from fecontact.mesh.facets import cells_at_faces, face_keys
from fecontact.mesh.mesh import Mesh
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.section_curve import along_line

SAMPLES = 10
"""Places along a side of a window at which its material is looked up."""


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
