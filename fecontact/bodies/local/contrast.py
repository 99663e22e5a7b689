"""Loads on the cells of other materials than that of the half-space which is subtracted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fecontact.analytic.face_loads import FaceLoads, stresses
from fecontact.common.arrays import Array, Mask
from fecontact.common.material import Material
from fecontact.fem.model import Model
from fecontact.fem.stiffness import Batch, batches
from fecontact.mesh.mesh import Mesh


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
