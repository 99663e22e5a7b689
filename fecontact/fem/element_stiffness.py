"""Stiffness matrices of isotropic elements in batches.

NumPy only, so that other processes can import it.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from fecontact.common.arrays import Array


def jacobians(x: Array, dN: Array) -> Array:
    """Jacobians dx_i/dX_j (n_cells, n_q, 3, 3) of cells with nodes x (n_cells, n_functions, 3) where `dN` is given."""
    n_q, n_functions, _ = dN.shape
    product = np.swapaxes(x, 1, 2) @ dN.transpose(1, 0, 2).reshape(n_functions, n_q * 3)
    return product.reshape(len(x), 3, n_q, 3).swapaxes(1, 2)


def determinant_3x3(J: Array) -> Array:
    """Determinants (...) of (..., 3, 3) matrices as a triple product."""
    return np.einsum("...i,...i->...", J[..., 0, :], np.cross(J[..., 1, :], J[..., 2, :]))


def inverse_3x3(J: Array) -> tuple[Array, Array]:
    """Inverses and determinants of (..., 3, 3) matrices by cofactors, several times faster than LAPACK's."""
    a, b, c = J[..., 0, :], J[..., 1, :], J[..., 2, :]
    cofactor = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
    det = np.einsum("...i,...i->...", a, cofactor[..., :, 0])
    return cofactor / det[..., None, None], det


def physical_gradients(x: Array, dN: Array, W: Array) -> tuple[Array, Array]:
    """Gradients and volumes at the quadrature points of cells.

    Parameters
    ----------
    x : (n_cells, n_functions, 3) array
        Nodes.
    dN : (n_q, n_functions, 3) array
        Gradients of the functions with respect to the coordinates of the reference cell.
    W : (n_q,) array
        Weights.

    Returns
    -------
    gradients : (n_cells, n_q, n_functions, 3) array
        With respect to physical coordinates.
    dV : (n_cells, n_q) array
        Weights times volume.
    """
    inverse, det = inverse_3x3(jacobians(x, dN))
    return dN[None] @ inverse, det * W


class Gradients(Protocol):
    """Members of a batch that a stiffness needs: those of a `Batch`, or of other elements."""

    @property
    def gradients(self) -> Array:
        """Gradients (n_cells, n_q, n_functions, 3) with respect to physical coordinates."""

    @property
    def dV(self) -> Array:
        """Volumes (n_cells, n_q) of the quadrature points."""


def gradient_products(batch: Gradients) -> Array:
    """Integrals T_aibj of dN_a/dx_i dN_b/dx_j: (n_cells, n_functions a, n_functions b, 3 i, 3 j)."""
    n_cells, n_q, n_functions, _ = batch.gradients.shape
    G = batch.gradients.reshape(n_cells, n_q, 3 * n_functions)
    T = (G * batch.dV[:, :, None]).swapaxes(1, 2) @ G
    return T.reshape(n_cells, n_functions, 3, n_functions, 3).transpose(0, 1, 3, 2, 4)


def element_stiffness(batch: Gradients, lame: Array, shear: Array, volumetric: Gradients | None = None) -> Array:
    """Stiffness matrices of isotropic cells.

    With T_aibj = int dN_a/dx_i dN_b/dx_j, one matrix product per element, the stiffness is
    K_aibj = lambda T_aibj + mu (T_ajbi + delta_ij T_akbk) (Hughes, The Finite Element Method, 1987, section 2.7).

    Parameters
    ----------
    batch : Batch, or other gradients
    lame, shear : (n_cells,) arrays
        Lame constants lambda and mu of the cells.
    volumetric : Batch, optional
        The same cells at reduced points, for the part with lambda (selective reduced integration, Hughes 1987, section
        4.4), against locking of nearly incompressible materials.

    Returns
    -------
    (n_cells, n_functions, n_functions, 3, 3) array
        Axes: cell, node a, node b, component i, component j.
    """
    T = gradient_products(batch)
    T_volumetric = T if volumetric is None else gradient_products(volumetric)
    trace = np.einsum("cabkk->cab", T)
    K = lame[:, None, None, None, None] * T_volumetric + shear[:, None, None, None, None] * T.swapaxes(3, 4)
    for i in range(3):
        K[..., i, i] += shear[:, None, None] * trace
    return K
