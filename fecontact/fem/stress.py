"""Strain and stress recovery: at Gauss points, extrapolated to the nodes and averaged there.

At a corner whose Jacobian vanishes (a coalesced edge, two sides with one tangent) displacements are right but stresses
evaluated there are wrong (Elangovan 1978, appendix B, fig. B-8). Stresses are therefore evaluated at the Gauss points,
where every valid element is regular, and extrapolated to the nodes by a fit.
"""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.material import FIRST, SECOND, Material
from fecontact.fem.stiffness import Cells, batches
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import SectionMesh

#: Of shears in sums over the components of two symmetric tensors.
DOUBLED = np.where(FIRST == SECOND, 1.0, 2.0)


def gauss_strain(
    mesh: Mesh | SectionMesh | Cells, u: Array, selective: bool = False, across: Array | None = None
) -> tuple[Array, Array]:
    """Strains at the Gauss points.

    Parameters
    ----------
    mesh : Mesh, SectionMesh or Cells
    u : (n_points, 3) array
    selective : bool
        Whether the volume change is extrapolated from the reduced points by trilinear functions. This is needed where
        the stiffness was integrated selectively; elsewhere it oscillates.
    across : (n_cells,) array, optional
        In plane stress: -lambda / (lambda + 2 mu), the ratio of the strain yy to xx + zz.

    Returns
    -------
    strain : (n_cells, n_q, 6) array
        Tensor components in the order of `VOIGT` (shears are not doubled). Where kinds of element with different
        numbers of points are mixed, n_q is the largest and the rest of a cell's row is NaN.
    points : (n_cells, n_q, 3) array
    """
    cells = Cells.of(mesh)
    n_q = max(len(group.element.rule()[2]) for group in cells.groups)
    strain = np.full((cells.count, n_q, 6), np.nan)
    points = np.full((cells.count, n_q, 3), np.nan)
    for batch in batches(cells):
        gradient = batch.displacement_gradients(u)
        for k, (i, j) in enumerate(zip(FIRST, SECOND, strict=True)):
            strain[batch.cells, : len(batch.N), k] = (gradient[..., i, j] + gradient[..., j, i]) / 2
        points[batch.cells, : len(batch.N)] = batch.N @ cells.points[batch.nodes]
    if selective:
        _replace_volume_change(cells, u, strain)
    if across is not None:
        strain[..., 1] = across[:, None] * (strain[..., 0] + strain[..., 2])
    return strain, points


def _replace_volume_change(cells: Cells, u: Array, strain: Array) -> None:
    """Replace the volume change by that extrapolated from the reduced points, in place."""
    carry = [group.element.carry() for group in cells.groups]
    change = np.empty((cells.count, carry[0].shape[1]))
    for batch in batches(cells, reduced=True):
        change[batch.cells] = batch.volume_change(u)
    for group, each in zip(cells.groups, carry, strict=True):
        own = strain[group.cells, : len(each), :3]
        wanted = change[group.cells] @ each.T
        strain[group.cells, : len(each), :3] = own + ((wanted - own.sum(axis=2)) / 3)[:, :, None]


def hooke(strain: Array, lame: Array, shear: Array) -> Array:
    """Isotropic stress (..., 6) of strains (..., 6); `lame` and `shear` broadcast over the leading axes."""
    stress = 2 * shear[..., None] * strain
    stress[..., :3] += (lame * strain[..., :3].sum(axis=-1))[..., None]
    return stress


def stress_of(strain: Array, lame: Array, shear: Array, moduli: Array | None = None) -> Array:
    """Stresses (n_cells, n_q, 6) of strains: isotropic by (n_cells,), or by moduli (n_cells, n_q or 1, 6, 6)."""
    if moduli is None:
        return hooke(strain, lame[:, None], shear[:, None])
    return np.asarray((moduli @ (DOUBLED * strain)[..., None])[..., 0])


def hooke_inverse(stress: Array, lame: Array, shear: Array) -> Array:
    """Strains (..., 6) of isotropic stresses (..., 6); `lame` and `shear` broadcast over the leading axes."""
    share = lame / (3 * lame + 2 * shear)
    trace = stress[..., :3].sum(axis=-1)
    return np.asarray((stress - (share * trace)[..., None] * (np.arange(6) < 3)) / (2 * shear[..., None]))


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


def to_nodes(
    mesh: Mesh | SectionMesh | Cells, values: Array, among: IntArray | None = None, complete: bool = False
) -> Array:
    """Gauss-point values (n_cells, n_q, k) fitted in each cell, evaluated at its nodes and averaged: (n_points, k).

    With `among`, only those cells count; nodes without such a cell get NaN.

    The fit is by least squares: with the functions of the element's corners (trilinear in a hexahedron, linear in a
    tetrahedron) for quadratic elements, constant for linear ones, where superconvergence is found (Hinton & Campbell
    1974); with `complete` also trilinear in hexahedra of 8 nodes, whose values then are complete linear functions.
    """
    cells = Cells.of(mesh)
    total = np.zeros((len(cells.points), values.shape[2]))
    count = np.zeros(len(cells.points))
    counts = np.ones(cells.count) if among is None else np.isin(np.arange(cells.count), among).astype(float)
    for group in cells.groups:
        fit = group.element.fit(complete)
        nodal = np.einsum("nq,cqk->cnk", fit, values[group.cells, : fit.shape[1]])
        np.add.at(total, group.nodes, nodal * counts[group.cells, None, None])
        np.add.at(count, group.nodes, counts[group.cells, None])
    mean = total / np.maximum(count, 1.0)[:, None]
    if among is not None:
        mean[count == 0] = np.nan
    return mean


def components(tensors: Array) -> Array:
    """Components (..., 6), in the order of `VOIGT`, of symmetric tensors (..., 3, 3)."""
    return np.stack([tensors[..., i, j] for i, j in zip(FIRST, SECOND, strict=True)], axis=-1)
