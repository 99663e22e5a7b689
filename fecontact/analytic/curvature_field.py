"""First effect of a face's curvature on the fields of a point load.

A body fills z >= h(x, y) = (k_11 x^2 + 2 k_12 x y + k_22 y^2)/2: positive curvatures are convex. The half-space fields
of a load at the origin leave on its face the tangential traction d_b(h sigma_ab), of the order curvature/distance. The
field here is that of the half-space under the opposite traction; added to Boussinesq's and Cerruti's it leaves a
traction that is bounded. Its stresses fall as 1/distance, its displacements are angular functions and a logarithm.

The tractions are sums of exp(i k theta)/r. With w = (x + i y)/(rho + z), the functions L_j = w^j/j, their conjugates
for j < 0, and L_0 = -log(rho + z) are harmonic, -dL_j/dz is exp(i j theta)/r at z = 0, and their derivatives along x
and y are such functions again. docs/theory/local-bodies.md has the derivation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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
    docs/theory/local-bodies.md; the potentials of tangential tractions are Cerruti's, K. L. Johnson, Contact Mechanics,
    1985, section 3.2.

    Examples
    --------
    >>> material = Material(E=2.0, nu=0.0)
    >>> u, _ = fields([0.5, 0.0, 0.0], force=(0, 0, 4 * np.pi), curvature=np.eye(2), length=1.0, material=material)
    >>> bool(np.isclose(u[2], np.log(2)))
    True
    """
    found = _Field.of(points, force, curvature, length, material)
    return found.displacement(), found.stress()


def displacement(
    points: ArrayLike, *, force: ArrayLike, curvature: ArrayLike, length: float, material: Material
) -> Array:
    """Return the displacement (..., 3) alone, see `fields`.

    Examples
    --------
    >>> plain = Material(E=2.0, nu=0.0)
    >>> u = displacement([0.5, 0.0, 0.0], force=(0, 0, 4 * np.pi), curvature=np.eye(2), length=1.0, material=plain)
    >>> bool(np.isclose(u[2], np.log(2)))
    True
    """
    return _Field.of(points, force, curvature, length, material).displacement()


def stress(points: ArrayLike, *, force: ArrayLike, curvature: ArrayLike, material: Material) -> Array:
    """Return the stress (..., 3, 3) alone, see `fields`; it knows no unit of length.

    Examples
    --------
    >>> plain = Material(E=2.0, nu=0.0)
    >>> stress([0.5, 0.0, 0.0], force=(0, 0, np.pi), curvature=np.eye(2), material=plain).diagonal().round(3) + 0.0
    array([ 0., -2.,  0.])
    """
    return _Field.of(points, force, curvature, 1.0, material).stress()


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


@dataclass(frozen=True, eq=False)
class _Field:
    """Displacement and stress from the three potentials.

    With u = u_x + i u_y and D = d/dx + i d/dy: 2 mu u = (2 - nu) A + nu M + z/2 (A - M),z and
    2 mu u_z = (1 - 2 nu) Re B - z Re B,z. A has the traction as -A,z; M is D^2 of the second integral along z of A's
    conjugate, B the conjugate D of the first integral of A.
    """

    z: Array
    rho: Array
    powers: Series
    direct: Series
    bent: Series
    B: Series
    length: float
    material: Material

    @classmethod
    def of(cls, points: ArrayLike, force: ArrayLike, curvature: ArrayLike, length: float, material: Material) -> _Field:
        """With checked arguments of `fields`."""
        place = checks.point_array("points", points, 3)
        vector = checks.point_array("the force", force, 3)
        tensor = checks.point_array("the curvature", curvature, 2)
        checks.lengths(length=length)
        if tensor.ndim < 2 or tensor.shape[-2] != 2:
            raise InputError(f"Expected curvatures of shape (..., 2, 2); found {tensor.shape}.", code="curvature-shape")
        rho, z, nu = np.linalg.norm(place, axis=-1), place[..., 2], material.nu
        if np.any(rho + z <= 1e-12 * rho):
            raise InputError("Expected points away from the load and not over it; the fields are infinite there.")
        A = _tractions(vector, tensor, nu)
        M = {2 - k: (-1 if k == 1 else 1) * np.conj(c) for k, c in A.items()}
        B = {k - 1: (-1 if k >= 1 else 1) * c for k, c in A.items()}
        most = max(abs(j) for series in (A, M, B) for j in series) + 1
        powers = _powers((place[..., 0] + 1j * place[..., 1]) / (rho + z), most)
        return cls(z, rho, powers, _sum((2 - nu, A), (nu, M)), _sum((0.5, A), (-0.5, M)), B, length, material)

    def _value(self, terms: Series) -> Array:
        logarithm = -np.log((self.rho + self.z) / self.length)
        return np.asarray(sum(c * (self.powers[j] / abs(j) if j else logarithm) for j, c in terms.items()))

    def _E(self, terms: Series) -> Array:
        return np.asarray(sum(c * self.powers[j] for j, c in terms.items()) / self.rho)

    def _F(self, terms: Series) -> Array:
        """The derivative of E along z."""
        by_order = sum(c * abs(j) * self.powers[j] for j, c in terms.items())
        return np.asarray(-(by_order + self.z * self._E(terms)) / self.rho**2)

    def _planar(self, derivative: Derivative) -> Array:
        """2 mu times a derivative of u_x + i u_y, z held."""
        return self._E(derivative(self.direct)) + self.z * self._F(derivative(self.bent))

    def displacement(self) -> Array:
        """Displacement (..., 3)."""
        u = self._value(self.direct) + self.z * self._E(_down(self.bent))
        u_z = (1 - 2 * self.material.nu) * self._value(self.B).real - self.z * self._E(_down(self.B)).real
        return np.stack(np.broadcast_arrays(u.real, u.imag, u_z), axis=-1) / (2 * self.material.shear_modulus)

    def stress(self) -> Array:
        """Stress (..., 3, 3)."""
        nu, B, z = self.material.nu, self.B, self.z
        # D of the real part of B, as half of D B and the conjugate of D* B
        slope = (1 - 2 * nu) * (self._E(_along(B)) + np.conj(self._E(_conjugate(B)))) / 2
        slope = slope - z * (self._F(_along(B)) + np.conj(self._F(_conjugate(B)))) / 2
        shear = self._planar(_down) + self._E(_down(self.bent)) + slope
        depth = -2 * nu * self._E(_down(B)).real - z * self._F(_down(B)).real
        return _hooke(self._planar(_conjugate).real, self._planar(_along), shear, depth, nu)


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
