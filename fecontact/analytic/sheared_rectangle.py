"""Half-space under a uniform shear traction on a rectangle.

The half-space fills z >= 0 (z into the body), the rectangle |x| <= a, |y| <= b lies on its surface. The stresses follow
from Cerruti's potentials (Johnson 1985, section 3.2) integrated over the rectangle: V of 1/rho, chi of log(rho + z) and
Omega of z log(rho + z) - rho. For a traction q along x

    2 pi xx = 2 (1 + nu) V_x + 2 nu Omega_xxx - z chi_xxx     2 pi xy = V_y + 2 nu Omega_xxy - z chi_xxy
    2 pi yy = 2 nu V_x + 2 nu Omega_xyy - z chi_xyy           2 pi xz = V_z - z V_xx
    2 pi zz = -z V_xz                                         2 pi yz = -z V_xy

times q, with chi_z = V, Omega_z = chi, and all three harmonic.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fecontact.analytic import boussinesq
from fecontact.analytic.rectangle import inside, near_or_far, potentials, rectangle_sides
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.material import Material


def stress(
    points: ArrayLike, *, half_sides: tuple[float, float], traction: tuple[float, float], material: Material
) -> Array:
    """Return the stress in the half-space and on its surface.

    Parameters
    ----------
    points : array_like, shape (..., 3)
        Points with z >= 0.
    half_sides : tuple of (float, float)
        Half-sides a (along x) and b (along y).
    traction : tuple of (float, float)
        Traction along x and y on the body.
    material : Material
        Material of the half-space.

    Returns
    -------
    numpy.ndarray, shape (..., 3, 3)
        Stress tensors, tension positive. On the edges, on the surface, where components are infinite as the logarithm
        of the distance, that of a distance of twice the half-side; where components jump, the mean of their limits.

    Raises
    ------
    InputError
        If a point lies outside the half-space, or a side is not positive.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, section 3.2, equations 3.3 to 3.7.

    Examples
    --------
    >>> below = stress([0.0, 0.0, 0.0], half_sides=(1.0, 1.0), traction=(1.0, 0.0), material=Material(1.0, 0.3))
    >>> below.round(12)[:, 2] + 0.0
    array([-1.,  0.,  0.])
    """
    a, b = rectangle_sides(half_sides)
    coordinates = inside(points)
    along = [checks.finite("the traction", q) for q in traction]
    swap = np.array([1, 0, 2])
    first = _along_x(coordinates, (a, b), material)
    second = _along_x(coordinates[..., swap], (b, a), material)[..., swap, :][..., swap]
    return np.asarray(along[0] * first + along[1] * second)


def _along_x(points: Array, sides: tuple[float, float], material: Material) -> Array:
    nu = material.nu

    def near(close: Array) -> Array:
        f = potentials(close, sides)
        Omega_xxy, Omega_xyy, z_chi_xxy, z_chi_xyy = _third(close, sides)
        Omega_xxx, z_chi_xxx = -Omega_xyy - f.V_x, -z_chi_xyy - f.W_xz
        tensor = np.empty((*close.shape[:-1], 3, 3))
        tensor[..., 0, 0] = 2 * (1 + nu) * f.V_x + 2 * nu * Omega_xxx - z_chi_xxx
        tensor[..., 1, 1] = 2 * nu * (f.V_x + Omega_xyy) - z_chi_xyy
        tensor[..., 2, 2] = -f.W_xz
        tensor[..., 0, 1] = tensor[..., 1, 0] = f.V_y + 2 * nu * Omega_xxy - z_chi_xxy
        tensor[..., 0, 2] = tensor[..., 2, 0] = f.V_z - f.W_xx
        tensor[..., 1, 2] = tensor[..., 2, 1] = -f.W_xy
        return np.asarray(tensor / (2 * np.pi))

    def far(offsets: Array) -> Array:
        return boussinesq.stress(offsets, force=(1.0, 0.0, 0.0), material=material)

    return near_or_far(points, sides, near, far)


def _third(points: Array, sides: tuple[float, float]) -> tuple[Array, Array, Array, Array]:
    """Omega_xxy, Omega_xyy, z chi_xxy and z chi_xyy: sums over the corners of -X/s, -Y/s, z X/(rho s), z Y/(rho s).

    Here s = rho + z; at a corner itself, where s vanishes, all are zero in the mean over directions.
    """
    signs = np.array([1.0, -1.0])
    X = points[..., 0, None, None] + sides[0] * signs[:, None]
    Y = points[..., 1, None, None] + sides[1] * signs[None, :]
    Z = points[..., 2, None, None]
    rho = np.sqrt(X**2 + Y**2 + Z**2)
    one_by = np.divide(1.0, rho + Z, out=np.zeros_like(rho), where=rho > 0)
    z_by_rho = np.divide(Z, rho, out=np.zeros_like(rho), where=rho > 0)
    weight = signs[:, None] * signs[None, :]
    terms = (-X * one_by, -Y * one_by, z_by_rho * X * one_by, z_by_rho * Y * one_by)
    return tuple((weight * t).sum(axis=(-2, -1)) for t in terms)
