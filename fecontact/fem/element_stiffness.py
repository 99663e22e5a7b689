"""Stiffness matrices of elements from the gradients of their functions.

NumPy only: processes that have nothing else integrate their own cells by it, see `fem.petsc`.
"""

from __future__ import annotations

from functools import cache
from typing import Protocol

import numpy as np

from fecontact.common.arrays import Array, IntArray, cross


def jacobians(x: Array, dN: Array) -> Array:
    """Jacobians dx_i/dX_j (n_cells, n_q, 3, 3) of cells with nodes x (n_cells, n_functions, 3) where `dN` is given."""
    n_q, n_functions, _ = dN.shape
    product = np.swapaxes(x, 1, 2) @ dN.transpose(1, 0, 2).reshape(n_functions, n_q * 3)
    return product.reshape(len(x), 3, n_q, 3).swapaxes(1, 2)


def determinant_3x3(J: Array) -> Array:
    """Determinants (...) of (..., 3, 3) matrices as a triple product."""
    return np.einsum("...i,...i->...", J[..., 0, :], cross(J[..., 1, :], J[..., 2, :]))


def inverse_3x3(J: Array) -> tuple[Array, Array]:
    """Inverses and determinants of (..., 3, 3) matrices by cofactors, several times faster than LAPACK's."""
    a, b, c = J[..., 0, :], J[..., 1, :], J[..., 2, :]
    cofactor = np.stack([cross(b, c), cross(c, a), cross(a, b)], axis=-1)
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


def with_means(gradients: Array, dV: Array, reduced: Array, reduced_dV: Array) -> tuple[Array, Array]:
    """Gradients and volumes at the points of a reduced rule, with the volume and the mean gradients of the full rule.

    A uniform pressure then has the forces of its full integral, in every kind and shape of cell: the patch test (Hughes
    1980, *Generalization of selective integration procedures to anisotropic and nonlinear media*). In hexahedra with
    parallel faces the reduced rule has these means by itself; in tetrahedra and wedges with coalesced nodes it has not.

    Parameters
    ----------
    gradients, reduced : (n_cells, n_q, ...) arrays
    dV, reduced_dV : (n_cells, n_q) arrays
    """
    volume = dV.sum(axis=1, keepdims=True)
    weights = reduced_dV * (volume / reduced_dV.sum(axis=1, keepdims=True))
    mean = np.einsum("cq,cq...->c...", dV / volume, gradients)
    mean -= np.einsum("cq,cq...->c...", weights / volume, reduced)
    return reduced + mean[:, None], weights


class Gradients(Protocol):
    """Members of a batch that a stiffness needs: those of a `Batch`, or of other elements."""

    @property
    def gradients(self) -> Array:
        """Gradients (n_cells, n_q, n_functions, 3) with respect to physical coordinates."""

    @property
    def dV(self) -> Array:
        """Volumes (n_cells, n_q) of the quadrature points."""


def _gradient_products(batch: Gradients) -> Array:
    """Integrals T_aibj of dN_a/dx_i dN_b/dx_j: (n_cells, 9 n_functions^2), axes a, i, b, j."""
    n_cells, n_q, n_functions, _ = batch.gradients.shape
    G = batch.gradients.reshape(n_cells, n_q, 3 * n_functions)
    return ((G * batch.dV[:, :, None]).swapaxes(1, 2) @ G).reshape(n_cells, -1)


def upper_pairs(n: int) -> tuple[IntArray, IntArray]:
    """Pairs a <= b of n functions: (n (n + 1) / 2,) each."""
    return np.triu_indices(n)


@cache
def _places(n: int, upper: bool) -> tuple[IntArray, IntArray]:
    """Places of T_aibj and T_ajbi in `_gradient_products`, by pair, i and j; of the pairs a <= b or of all."""
    pairs = upper_pairs(n) if upper else np.indices((n, n)).reshape(2, -1)
    a, b = (np.asarray(each)[:, None] for each in pairs)
    i, j = np.divmod(np.arange(9), 3)
    straight, turned = (3 * n * (3 * a + k) + 3 * b + m for k, m in ((i, j), (j, i)))
    return straight.ravel(), turned.ravel()


def element_stiffness(batch: Gradients, lame: Array, shear: Array, volumetric: Gradients | None = None) -> Array:
    """Stiffness matrices of isotropic cells, see `pair_stiffness`.

    Returns
    -------
    (n_cells, n_functions, n_functions, 3, 3) array
        Axes: cell, node a, node b, component i, component j.
    """
    n = batch.gradients.shape[2]
    return pair_stiffness(batch, lame, shear, volumetric, upper=False).reshape(-1, n, n, 3, 3)


def pair_stiffness(
    batch: Gradients, lame: Array, shear: Array, volumetric: Gradients | None = None, upper: bool = True
) -> Array:
    """Blocks of the stiffness matrices of isotropic cells.

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
    upper : bool
        Whether for the pairs of `upper_pairs` only.

    Returns
    -------
    (n_cells, n_pairs, 9) array
        Rows of the blocks one after the other.
    """
    straight, turned = _places(batch.gradients.shape[2], upper)
    T = _gradient_products(batch)
    K = np.take(T if volumetric is None else _gradient_products(volumetric), straight, axis=1)
    K *= lame[:, None]
    other = np.take(T, turned, axis=1)
    other *= shear[:, None]
    trace = other[:, ::9] + other[:, 4::9] + other[:, 8::9]
    K += other
    for k in (0, 4, 8):
        K[:, k::9] += trace
    return K.reshape(len(K), -1, 9)
