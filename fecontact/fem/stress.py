"""Strain and stress recovery: at Gauss points, extrapolated to the nodes and averaged there.

A corner whose Jacobian vanishes (a coalesced edge, two sides with one tangent) gives right displacements and wrong
stresses if these are taken there (Elangovan 1978, appendix B, fig. B-8). So stresses are taken at the Gauss points,
where every valid element is regular, and carried to the nodes by a fit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fecontact.fem.stiffness import batches
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.reference import hex_nodes, hex_quadrature

Array = NDArray[np.float64]

#: Order of the six components of symmetric tensors, as in VTK files.
VOIGT = ("xx", "yy", "zz", "xy", "yz", "xz")
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def gauss_strain(mesh: Mesh, u: Array) -> tuple[Array, Array]:
    """Strains at the Gauss points.

    Parameters
    ----------
    mesh : Mesh
    u : (n_points, 3) array

    Returns
    -------
    strain : (n_cells, n_q, 6) array
        Tensor components in the order of `VOIGT` (shears are not doubled).
    points : (n_cells, n_q, 3) array
    """
    n_q = len(hex_quadrature(mesh.cells.shape[1])[1])
    strain = np.empty((len(mesh.cells), n_q, 6))
    points = np.empty((len(mesh.cells), n_q, 3))
    for batch in batches(mesh):
        gradient = np.einsum("cqaj,cai->cqij", batch.gradients, u[batch.nodes])
        for k, (i, j) in enumerate(_PAIRS):
            strain[batch.cells, :, k] = (gradient[..., i, j] + gradient[..., j, i]) / 2
        points[batch.cells] = np.einsum("qa,cai->cqi", batch.N, mesh.points[batch.nodes])
    return strain, points


def hooke(strain: Array, lame: Array, shear: Array) -> Array:
    """Isotropic stress (..., 6) of strains (..., 6); `lame` and `shear` broadcast over the leading axes."""
    stress = 2 * shear[..., None] * strain
    stress[..., :3] += (lame * strain[..., :3].sum(axis=-1))[..., None]
    return stress


def to_nodes(mesh: Mesh, values: Array) -> Array:
    """Gauss-point values (n_cells, n_q, k) fitted in each cell, taken at its nodes and averaged: (n_points, k).

    The fit is the least-squares polynomial of the quadrature's own tensor degree less one: linear in each coordinate
    for 27 points, constant for 8, where superconvergence is found (Hinton & Campbell 1974).
    """
    X, _ = hex_quadrature(mesh.cells.shape[1])
    linear = len(X) == 27
    total = np.zeros((len(mesh.points), values.shape[2]))
    count = np.zeros(len(mesh.points))
    for group in mesh.cell_groups:
        where = _node_positions(mesh, group.pattern, group.midfaces)
        fit = _trilinear(where) @ np.linalg.pinv(_trilinear(X)) if linear else np.full((len(where), len(X)), 1 / len(X))
        nodal = np.einsum("nq,cqk->cnk", fit, values[group.cells])
        np.add.at(total, group.nodes, nodal)
        np.add.at(count, group.nodes, 1.0)
    return total / np.maximum(count, 1.0)[:, None]


def _trilinear(X: Array) -> Array:
    x, y, z = X.T
    return np.stack([np.ones_like(x), x, y, z, x * y, y * z, x * z, x * y * z], axis=1)


def _node_positions(mesh: Mesh, pattern: tuple[int, ...], midfaces: tuple[int, ...]) -> Array:
    """Reference positions of a group's nodes; a coalesced node is taken at the middle of its edge or face."""
    reference = hex_nodes(mesh.cells.shape[1])
    p = np.asarray(pattern)
    distinct = [reference[p == node].mean(axis=0) for node in np.unique(p)]
    centres = hex_nodes(27)[[20 + face for face in midfaces]]
    return np.concatenate([np.stack(distinct), centres.reshape(-1, 3)])


def von_mises(stress: Array) -> Array:
    """Equivalent stress (...) of components (..., 6)."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3 * (xy**2 + yz**2 + xz**2))
