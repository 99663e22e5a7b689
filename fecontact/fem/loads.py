"""Consistent nodal forces of loads on a mesh: body forces, tractions and pressures."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array, IntArray
from fecontact.fem.stiffness import batches, volume_elements
from fecontact.mesh.facets import facet_integrals
from fecontact.mesh.mesh import Mesh


def body_force(mesh: Mesh, field: Callable[[Array], Array], density: ArrayLike = 1.0) -> Array:
    """Nodal forces of a force per mass ``field(points (n, 3)) -> (n, 3)``.

    Parameters
    ----------
    mesh : Mesh
    field : callable
    density : float or (n_cells,) array

    Returns
    -------
    (3 n_points,) array
    """
    rho = np.broadcast_to(np.asarray(density, dtype=float), len(mesh.cells))
    f = np.zeros((len(mesh.points), 3))
    for batch in batches(mesh):
        x = np.einsum("qa,cai->cqi", batch.N, mesh.points[batch.nodes])
        b = field(x.reshape(-1, 3)).reshape(x.shape)
        nodal = np.einsum("qa,cqi,cq->cai", batch.N, b, batch.dV * rho[batch.cells, None])
        np.add.at(f, batch.nodes, nodal)
    return f.ravel()


def moments_of_volume(mesh: Mesh, density: ArrayLike = 1.0) -> tuple[float, Array]:
    """Mass (volume for unit density) and its centre (3,)."""
    rho = np.broadcast_to(np.asarray(density, dtype=float), len(mesh.cells))
    mass, first = 0.0, np.zeros(3)
    for cells, x, dV in volume_elements(mesh):
        dm = dV * rho[cells, None]
        mass += dm.sum()
        first += np.einsum("cq,cqi->i", dm, x)
    return float(mass), first / mass


def surface_traction(mesh: Mesh, faces: IntArray, traction: Callable[[Array, Array], Array]) -> Array:
    """Nodal forces (3 n_points,) of ``traction(points (n, 3), unit outward normals (n, 3)) -> (n, 3)`` on faces."""
    facets = mesh.face_nodes(faces)
    N, x, dA = facet_integrals(mesh.points, facets)
    area = np.linalg.norm(dA, axis=2)
    t = traction(x.reshape(-1, 3), (dA / area[..., None]).reshape(-1, 3)).reshape(x.shape)
    f = np.zeros((len(mesh.points), 3))
    np.add.at(f, facets, np.einsum("fqa,fqi,fq->fai", N, t, area))
    return f.ravel()
