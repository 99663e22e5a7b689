"""Strain and stress recovery: at Gauss points, extrapolated to the nodes and averaged there.

At a corner whose Jacobian vanishes (a coalesced edge, two sides with one tangent) displacements are right but stresses
evaluated there are wrong (Elangovan 1978, appendix B, fig. B-8). Stresses are therefore evaluated at the Gauss points,
where every valid element is regular, and extrapolated to the nodes by a fit.
"""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.material import Material
from fecontact.fem.stiffness import batches
from fecontact.mesh.element import (
    Pattern,
    element_quadrature,
    hex_shapes,
    linear_shapes,
    node_positions,
    reduced_quadrature,
)
from fecontact.mesh.mesh import CellGroup, Mesh

#: Order of the six components of symmetric tensors, as in VTK files.
VOIGT = ("xx", "yy", "zz", "xy", "yz", "xz")
#: Node pattern of a regular hexahedron of 8 nodes.
HEXAHEDRON: Pattern = tuple(range(8))
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def gauss_strain(mesh: Mesh, u: Array, selective: bool = False) -> tuple[Array, Array]:
    """Strains at the Gauss points.

    Parameters
    ----------
    mesh : Mesh
    u : (n_points, 3) array
    selective : bool
        Whether the volume change is extrapolated from the reduced points by trilinear functions. This is needed where
        the stiffness was integrated selectively; elsewhere it oscillates.

    Returns
    -------
    strain : (n_cells, n_q, 6) array
        Tensor components in the order of `VOIGT` (shears are not doubled). Where kinds of element with different
        numbers of points are mixed, n_q is the largest and the rest of a cell's row is NaN.
    points : (n_cells, n_q, 3) array
    """
    n_q = max(len(_gauss_points(mesh, group)) for group in mesh.cell_groups)
    strain = np.full((len(mesh.cells), n_q, 6), np.nan)
    points = np.full((len(mesh.cells), n_q, 3), np.nan)
    for batch in batches(mesh):
        gradient = np.swapaxes(batch.gradients, 2, 3) @ u[batch.nodes][:, None]
        for k, (i, j) in enumerate(_PAIRS):
            strain[batch.cells, : len(batch.N), k] = (gradient[..., i, j] + gradient[..., j, i]) / 2
        points[batch.cells, : len(batch.N)] = batch.N @ mesh.points[batch.nodes]
    if selective:
        _replace_volume_change(mesh, u, strain)
    return strain, points


def _replace_volume_change(mesh: Mesh, u: Array, strain: Array) -> None:
    """Replace the volume change by that extrapolated from the reduced points, in place."""
    X, _ = reduced_quadrature(mesh.cells.shape[1])
    change = np.empty((len(mesh.cells), len(X)))
    for batch in batches(mesh, reduced=True):
        change[batch.cells] = np.einsum("cqai,cai->cq", batch.gradients, u[batch.nodes])
    for group in mesh.cell_groups:
        full = _gauss_points(mesh, group)
        carry = np.ones((len(full), 1))
        if len(X) > 1:
            carry = hex_shapes(8, full)[0] @ np.linalg.inv(hex_shapes(8, X)[0])
        own = strain[group.cells, : len(full), :3]
        wanted = change[group.cells] @ carry.T
        strain[group.cells, : len(full), :3] = own + ((wanted - own.sum(axis=2)) / 3)[:, :, None]


def hooke(strain: Array, lame: Array, shear: Array) -> Array:
    """Isotropic stress (..., 6) of strains (..., 6); `lame` and `shear` broadcast over the leading axes."""
    stress = 2 * shear[..., None] * strain
    stress[..., :3] += (lame * strain[..., :3].sum(axis=-1))[..., None]
    return stress


def strain_of(stress: Array, material: Material) -> Array:
    """Isotropic strain (..., 6) of stresses (..., 6).

    Examples
    --------
    >>> strain_of(np.array([1.0, 0, 0, 0, 0, 0]), Material(E=2.0, nu=0.3)).tolist()
    [0.5, -0.15, -0.15, 0.0, 0.0, 0.0]
    """
    strain = (1 + material.nu) * stress
    strain[..., :3] -= material.nu * stress[..., :3].sum(axis=-1, keepdims=True)
    return np.asarray(strain / material.E)


def _gauss_points(mesh: Mesh, group: CellGroup) -> Array:
    return element_quadrature(mesh.cells.shape[1], group.pattern, group.midfaces)[0]


def to_nodes(mesh: Mesh, values: Array, cells: IntArray | None = None, complete: bool = False) -> Array:
    """Gauss-point values (n_cells, n_q, k) fitted in each cell, evaluated at its nodes and averaged: (n_points, k).

    With `cells`, only those count; nodes without such a cell get NaN.

    The fit is by least squares: with the functions of the element's corners (trilinear in a hexahedron, linear in a
    tetrahedron) for quadratic elements, constant for linear ones, where superconvergence is found (Hinton & Campbell
    1974); with `complete` also trilinear in hexahedra of 8 nodes, whose values then are complete linear functions.
    """
    total = np.zeros((len(mesh.points), values.shape[2]))
    count = np.zeros(len(mesh.points))
    counts = np.ones(len(mesh.cells)) if cells is None else np.isin(np.arange(len(mesh.cells)), cells).astype(float)
    for group in mesh.cell_groups:
        X = _gauss_points(mesh, group)
        fit = np.full((group.nodes.shape[1], len(X)), 1 / len(X))
        if mesh.cells.shape[1] > 8 or (complete and group.pattern == HEXAHEDRON):
            where = node_positions(mesh.cells.shape[1], group.pattern, group.midfaces)
            fit = linear_shapes(group.pattern, where)[0] @ np.linalg.pinv(linear_shapes(group.pattern, X)[0])
        nodal = np.einsum("nq,cqk->cnk", fit, values[group.cells, : len(X)])
        np.add.at(total, group.nodes, nodal * counts[group.cells, None, None])
        np.add.at(count, group.nodes, counts[group.cells, None])
    mean = total / np.maximum(count, 1.0)[:, None]
    if cells is not None:
        mean[count == 0] = np.nan
    return mean


def components(tensors: Array) -> Array:
    """Components (..., 6), in the order of `VOIGT`, of symmetric tensors (..., 3, 3)."""
    return np.stack([tensors[..., i, j] for i, j in _PAIRS], axis=-1)
