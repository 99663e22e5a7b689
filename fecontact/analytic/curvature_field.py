"""First effect of a face's curvature on the fields of a point load.

A body fills z >= h(x, y) = (k_11 x^2 + 2 k_12 x y + k_22 y^2)/2: positive curvatures are convex. The half-space fields
of a load at the origin leave on its face the tangential traction d_b(h sigma_ab), of the order curvature/distance. The
field here is that of the half-space under the opposite traction; added to Boussinesq's and Cerruti's it leaves a
traction that is bounded. Its stresses fall as 1/distance, its displacements are angular functions and a logarithm.

The tractions are sums of exp(i k theta)/r. With w = (x + i y)/(rho + z), the functions L_j = w^j/j, their conjugates
for j < 0, and L_0 = -log(rho + z) are harmonic, -dL_j/dz is exp(i j theta)/r at z = 0, and their derivatives along x
and y are such functions again. docs/local_body_theory.md has the derivation.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material

#: Coefficients of functions by their order: of L_j, or of their derivatives E_j = w^j/rho.
Series = dict[int, Array]
Derivative = Callable[[Series], Series]


def fields(
    points: ArrayLike, *, force: ArrayLike, curvature: ArrayLike, length: float, material: Material
) -> tuple[Array, Array]:
    """Return displacement and stress that the curvature of the face adds to the fields of a point load.

    Parameters
    ----------
    points : array_like, shape (..., 3)
        Points below the tangent plane, or above it but not over the load; z into the body.
    force : array_like, shape (3,) or (..., 3)
        Load (Qx, Qy, P) at the origin, P positive into the body.
    curvature : array_like, shape (2, 2) or (..., 2, 2)
        Symmetric tensor of curvature of the face at the load, convex positive.
    length : float
        Unit of length of the logarithm. It changes the displacements by a translation and nothing else.
    material : Material
        Material of the body.

    Returns
    -------
    displacement : numpy.ndarray, shape (..., 3)
    stress : numpy.ndarray, shape (..., 3, 3)
        Tension positive.

    Raises
    ------
    InputError
        If a point is the load's or lies over it.

    References
    ----------
    docs/local_body_theory.md; the potentials of tangential tractions are Cerruti's, K. L. Johnson, Contact Mechanics,
    1985, section 3.2.

    Examples
    --------
    >>> material = Material(E=2.0, nu=0.0)
    >>> u, _ = fields([0.5, 0.0, 0.0], force=(0, 0, 4 * np.pi), curvature=np.eye(2), length=1.0, material=material)
    >>> bool(np.isclose(u[2], np.log(2)))
    True
    """
    place = checks.point_array("points", points, 3)
    vector = checks.point_array("the force", force, 3)
    tensor = checks.point_array("the curvature", curvature, 2)
    checks.lengths(length=length)
    if tensor.ndim < 2 or tensor.shape[-2] != 2:
        raise InputError(f"Expected curvatures of shape (..., 2, 2); found {tensor.shape}.")
    rho = np.linalg.norm(place, axis=-1)
    if np.any(rho + place[..., 2] <= 1e-12 * rho):
        raise InputError("Expected points away from the load and not over it; the fields are infinite there.")
    nu = material.nu
    A = _tractions(vector, tensor, nu)
    M = {2 - k: (-1 if k == 1 else 1) * np.conj(c) for k, c in A.items()}
    B = {k - 1: (-1 if k >= 1 else 1) * c for k, c in A.items()}
    return _evaluate(place, rho, (A, M, B), nu, length, 2 * material.shear_modulus)


def _tractions(force: Array, curvature: Array, nu: float) -> Series:
    """Coefficients of exp(i k theta)/r in the complex traction q_x + i q_y that the half-space is to be given.

    The stress at the surface times 2 pi r^2 is, its part xx - yy + 2 i xy halved, `traceless`, and its part xx + yy
    halved, `mean`; the height of the face over r^2/2 is `height`. q is minus the divergence of their product.
    """
    Q, P = force[..., 0] + 1j * force[..., 1], force[..., 2]
    traceless = {2: (1 - 2 * nu) * P, 1: -(1 - nu / 2) * Q, 3: -1.5 * nu * np.conj(Q)}
    mean = {-1: -(1 + nu) / 2 * Q, 1: -(1 + nu) / 2 * np.conj(Q)}
    bend = (curvature[..., 0, 0] - curvature[..., 1, 1]) / 2 + 1j * curvature[..., 0, 1]
    height = {0: (curvature[..., 0, 0] + curvature[..., 1, 1]) / 2, -2: bend / 2, 2: np.conj(bend) / 2}
    total: Series = {}
    for turn, factor in height.items():
        for part, sign in ((traceless, 1), (mean, -1)):
            for order, value in part.items():
                n = order + turn  # d_b of exp(i n theta) gives n exp(i (n -+ 1) theta)/r
                added = -sign * n * factor * value / (4 * np.pi)
                total[n - sign] = total.get(n - sign, 0.0) + added
    return {k: np.asarray(c) for k, c in total.items()}


def _evaluate(
    place: Array, rho: Array, series: tuple[Series, Series, Series], nu: float, length: float, modulus: float
) -> tuple[Array, Array]:
    """Displacement and stress from the three potentials.

    With u = u_x + i u_y and D = d/dx + i d/dy: 2 mu u = (2 - nu) A + nu M + z/2 (A - M),z and
    2 mu u_z = (1 - 2 nu) Re B - z Re B,z. A has the traction as -A,z; M is D^2 of the second integral along z of A's
    conjugate, B the conjugate D of the first integral of A.
    """
    A, M, B = series
    z = place[..., 2]
    powers = _powers((place[..., 0] + 1j * place[..., 1]) / (rho + z), max(abs(j) for s in series for j in s) + 1)
    direct, bent = _sum((2 - nu, A), (nu, M)), _sum((0.5, A), (-0.5, M))

    def value(terms: Series) -> Array:
        logarithm = -np.log((rho + z) / length)
        return np.asarray(sum(c * (powers[j] / abs(j) if j else logarithm) for j, c in terms.items()))

    def E(terms: Series) -> Array:
        return np.asarray(sum(c * powers[j] for j, c in terms.items()) / rho)

    def F(terms: Series) -> Array:
        """The derivative of E along z."""
        by_order = sum(c * abs(j) * powers[j] for j, c in terms.items())
        return np.asarray(-(by_order + z * E(terms)) / rho**2)

    def planar(derivative: Derivative) -> Array:
        """2 mu times a derivative of u_x + i u_y, z held."""
        return E(derivative(direct)) + z * F(derivative(bent))

    turn = E(_down(bent))
    B_z = E(_down(B)).real
    u = value(direct) + z * turn
    u_z = (1 - 2 * nu) * value(B).real - z * B_z
    displacement = np.stack(np.broadcast_arrays(u.real, u.imag, u_z), axis=-1) / modulus
    # D of the real part of B, as half of D B and the conjugate of D* B
    slope = (1 - 2 * nu) * (E(_along(B)) + np.conj(E(_conjugate(B)))) / 2
    slope = slope - z * (F(_along(B)) + np.conj(F(_conjugate(B)))) / 2
    shear = planar(_down) + turn + slope
    depth = -2 * nu * B_z - z * F(_down(B)).real
    return displacement, _hooke(planar(_conjugate).real, planar(_along), shear, depth, nu)


def _powers(w: Array, most: int) -> Series:
    """Powers of w by their order, those of its conjugate by the negative one."""
    powers = {0: np.ones_like(w)}
    for j in range(1, most + 1):
        powers[j] = powers[j - 1] * w
        powers[-j] = np.conj(powers[j])
    return powers


def _sum(*parts: tuple[float, Series]) -> Series:
    """Sum of series with factors."""
    total: Series = {}
    for factor, terms in parts:
        for j, c in terms.items():
            total[j] = total.get(j, 0.0) + factor * c
    return total


def _along(terms: Series) -> Series:
    """D of a series of L, as a series of E."""
    return {j + 1: (-1 if j >= 0 else 1) * c for j, c in terms.items()}


def _conjugate(terms: Series) -> Series:
    """(d/dx - i d/dy) of a series of L, as a series of E."""
    return {j - 1: (1 if j >= 1 else -1) * c for j, c in terms.items()}


def _down(terms: Series) -> Series:
    """The derivative along z of a series of L, as a series of E."""
    return {j: -c for j, c in terms.items()}


def _hooke(area: Array, twist: Array, shear: Array, depth: Array, nu: float) -> Array:
    """Stress from 2 mu times the strains xx + yy, xx - yy + 2 i xy, 2 (xz + i yz), zz."""
    swell = nu / (1 - 2 * nu) * (area + depth)
    parts = [swell + (area + twist.real) / 2, swell + (area - twist.real) / 2, swell + depth]
    parts += [twist.imag / 2, shear.real / 2, shear.imag / 2]
    xx, yy, zz, xy, xz, yz = np.broadcast_arrays(*parts)
    rows = [np.stack(row, axis=-1) for row in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))]
    return np.stack(rows, axis=-2)
