"""Half-space under uniform pressure (Love 1929) or shear traction on a rectangle.

The half-space fills z >= 0 (z into the body), the rectangle |x| <= a, |y| <= b lies on its surface. All fields follow
from the potentials V = integral of 1/rho and chi = integral of log(rho + z) over the rectangle, sums over its corners.
Those sums cancel far away, as the square of distance over size; beyond `FAR` times the size the fields are taken from
Gauss quadrature of the point load instead, which is exact to rounding there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fecontact.analytic import boussinesq
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material

FAR = 6.0
#: Distance from an edge, relative to the half-side, below which a point counts as on it.
ROUNDING = 4 * float(np.finfo(float).eps)
# The quadrature error falls as (size/distance)^(2 * order): 12^-16 = 5e-18 for 8 points per side at FAR half-sides.
_ORDER = 8


def surface_displacement(
    x: ArrayLike, y: ArrayLike, *, half_sides: tuple[float, float], pressure: float, modulus: float
) -> Array:
    """Return the normal displacement of the surface.

    Parameters
    ----------
    x, y : array_like
        Coordinates on the surface from the centre of the rectangle, broadcast together.
    half_sides : tuple of (float, float)
        Half-sides a (along x) and b (along y).
    pressure : float
        Pressure, positive into the body.
    modulus : float
        E/(1 - nu^2) of the half-space, or E* for two bodies together.

    Returns
    -------
    numpy.ndarray
        Displacement into the body, of the broadcast shape.

    Raises
    ------
    InputError
        If a coordinate is not finite, or a side or the modulus not positive.

    References
    ----------
    A. E. H. Love, Phil. Trans. R. Soc. A 228 (1929) 377; K. L. Johnson, Contact Mechanics, 1985, chapter 3.

    Examples
    --------
    >>> surface_displacement(0.0, 0.0, half_sides=(1.0, 1.0), pressure=np.pi, modulus=8.0).round(6)
    np.float64(0.881374)
    """
    sides = _rectangle_sides(half_sides)
    xs, ys = np.broadcast_arrays(checks.coordinates("x", x), checks.coordinates("y", y))
    points = np.stack([xs, ys, np.zeros_like(xs)], axis=-1)

    def near(close: Array) -> Array:
        return _potentials(close, sides).V

    def far(offsets: Array) -> Array:
        return np.asarray(1 / np.linalg.norm(offsets, axis=-1))

    factor = checks.finite("the pressure", pressure) / (np.pi * checks.positive("the modulus", modulus))
    return np.asarray(factor * _near_or_far(points, sides, near, far))


def displacement(points: ArrayLike, *, half_sides: tuple[float, float], pressure: float, material: Material) -> Array:
    """Return the displacement in the half-space and on its surface.

    Parameters
    ----------
    points : array_like, shape (..., 3)
        Points with z >= 0.
    half_sides : tuple of (float, float)
        Half-sides a (along x) and b (along y).
    pressure : float
        Pressure, positive into the body.
    material : Material
        Material of the half-space.

    Returns
    -------
    numpy.ndarray, shape (..., 3)
        Displacement vectors, relative to points at infinity.

    Raises
    ------
    InputError
        If a point lies outside the half-space, or a side is not positive.

    References
    ----------
    Love 1929, section 2.

    Examples
    --------
    >>> displacement([0.0, 0.0, 0.0], half_sides=(1.0, 1.0), pressure=1.0, material=Material(1.0, 0.0)).round(6)
    array([0.      , 0.      , 2.244399])
    """
    sides = _rectangle_sides(half_sides)
    coordinates = _inside(points)
    nu = material.nu
    scale = checks.finite("the pressure", pressure) / (4 * np.pi * material.shear_modulus)

    def near(close: Array) -> Array:
        f = _potentials(close, sides)
        u_x = 0.0 - (f.z * f.V_x + (1 - 2 * nu) * f.chi_x)
        u_y = 0.0 - (f.z * f.V_y + (1 - 2 * nu) * f.chi_y)
        return np.stack([scale * u_x, scale * u_y, scale * (2 * (1 - nu) * f.V - f.z * f.V_z)], axis=-1)

    def far(offsets: Array) -> Array:
        return boussinesq.displacement(offsets, force=(0.0, 0.0, pressure), material=material)

    return _near_or_far(coordinates, sides, near, far)


def stress(
    points: ArrayLike,
    *,
    half_sides: tuple[float, float],
    material: Material,
    pressure: float | None = None,
    traction: tuple[float, float] | None = None,
    corner_distance: float = 0.0,
) -> Array:
    """Return the stress in the half-space and on its surface.

    Parameters
    ----------
    points, half_sides, material
        As in `displacement`.
    pressure : float, optional
        Pressure, positive into the body.
    traction : tuple of (float, float), optional
        Shear traction along x and y on the body.
    corner_distance : float
        Distance assumed at the four corners, where xy by the pressure is infinite as the logarithm of the distance.

    Returns
    -------
    numpy.ndarray, shape (..., 3, 3)
        Stress tensors, tension positive. On the edges and at the corners of the rectangle, where some components jump,
        the mean of their limits along the surface from all sides; on the surface the shears with z are those of the
        traction. Points within rounding of an edge count as on it. On the edges, on the surface, where components by
        the traction are infinite as the logarithm of the distance, that of a distance of twice the half-side.

    Raises
    ------
    InputError
        If a point lies outside the half-space, or a side is not positive, or there is no load.

    References
    ----------
    Love 1929, section 2 and 4; for the traction K. L. Johnson, Contact Mechanics, 1985, section 3.2, equations 3.3 to
    3.7.

    Examples
    --------
    >>> tensor = stress([0.0, 0.0, 0.0], half_sides=(1.0, 1.0), pressure=1.0, material=Material(1.0, 0.25))
    >>> tensor.diagonal().round(6)
    array([-0.75, -0.75, -1.  ])
    >>> sheared = stress([0.0, 0.0, 0.0], half_sides=(1.0, 1.0), traction=(1.0, 0.0), material=Material(1.0, 0.3))
    >>> sheared.round(12)[:, 2] + 0.0
    array([-1.,  0.,  0.])
    """
    sides = _rectangle_sides(half_sides)
    coordinates = _inside(points)
    if pressure is None and traction is None:
        raise InputError("Give the pressure on the rectangle, the traction, or both.", code="no-load")
    p = 0.0 if pressure is None else checks.finite("the pressure", pressure)
    along = [checks.finite("the traction", q) for q in traction or (0.0, 0.0)]

    def near(close: Array) -> Array:
        tensor = np.zeros((*close.shape[:-1], 3, 3))
        if p:
            tensor += p * _by_pressure(close, sides, material.nu, corner_distance)
        if along[0]:
            tensor += along[0] * _by_traction(close, sides, material.nu)
        if along[1]:
            exchanged = _by_traction(close[..., EXCHANGED], (sides[1], sides[0]), material.nu)
            tensor += along[1] * exchanged[..., EXCHANGED, :][..., EXCHANGED]
        return np.asarray(tensor / (2 * np.pi))

    def far(offsets: Array) -> Array:
        return boussinesq.stress(offsets, force=(*along, p), material=material)

    return _near_or_far(coordinates, sides, near, far)


#: Exchange of the axes x and y.
EXCHANGED = np.array([1, 0, 2])


def _by_pressure(points: Array, sides: tuple[float, float], nu: float, corner_distance: float) -> Array:
    """2 pi times the stress by a unit pressure."""
    f = _potentials(points, sides, corner_distance)
    tensor = np.empty((*points.shape[:-1], 3, 3))
    tensor[..., 0, 0] = 2 * nu * f.V_z - (1 - 2 * nu) * f.chi_xx - f.W_xx
    tensor[..., 1, 1] = 2 * nu * f.V_z - (1 - 2 * nu) * f.chi_yy - f.W_yy
    tensor[..., 2, 2] = f.V_z + f.W_xx + f.W_yy
    tensor[..., 0, 1] = tensor[..., 1, 0] = -(1 - 2 * nu) * f.chi_xy - f.W_xy
    tensor[..., 0, 2] = tensor[..., 2, 0] = -f.W_xz
    tensor[..., 1, 2] = tensor[..., 2, 1] = -f.W_yz
    return tensor


def _by_traction(points: Array, sides: tuple[float, float], nu: float) -> Array:
    """2 pi times the stress by a unit traction along x, from Cerruti's potentials.

    They are V of 1/rho, chi of log(rho + z) and Omega of z log(rho + z) - rho, with chi_z = V, Omega_z = chi, and all
    three harmonic:

        xx = 2 (1 + nu) V_x + 2 nu Omega_xxx - z chi_xxx     xy = V_y + 2 nu Omega_xxy - z chi_xxy
        yy = 2 nu V_x + 2 nu Omega_xyy - z chi_xyy           xz = V_z - z V_xx
        zz = -z V_xz                                         yz = -z V_xy
    """
    f = _potentials(points, sides)
    Omega_xxy, Omega_xyy, z_chi_xxy, z_chi_xyy = _third(points, sides)
    Omega_xxx, z_chi_xxx = -Omega_xyy - f.V_x, -z_chi_xyy - f.W_xz
    tensor = np.empty((*points.shape[:-1], 3, 3))
    tensor[..., 0, 0] = 2 * (1 + nu) * f.V_x + 2 * nu * Omega_xxx - z_chi_xxx
    tensor[..., 1, 1] = 2 * nu * (f.V_x + Omega_xyy) - z_chi_xyy
    tensor[..., 2, 2] = -f.W_xz
    tensor[..., 0, 1] = tensor[..., 1, 0] = f.V_y + 2 * nu * Omega_xxy - z_chi_xxy
    tensor[..., 0, 2] = tensor[..., 2, 0] = f.V_z - f.W_xx
    tensor[..., 1, 2] = tensor[..., 2, 1] = -f.W_xy
    return tensor


@dataclass(frozen=True, eq=False)
class _Potentials:
    """Derivatives of V and chi; W are second derivatives of V times z, as they enter the stresses."""

    z: Array
    V: Array
    V_x: Array
    V_y: Array
    V_z: Array
    W_xx: Array
    W_yy: Array
    W_xy: Array
    W_xz: Array
    W_yz: Array
    chi_x: Array
    chi_y: Array
    chi_xx: Array
    chi_yy: Array
    chi_xy: Array


def _potentials(points: Array, sides: tuple[float, float], corner_distance: float = 0.0) -> _Potentials:
    """Sum the corner functions; log(Y + rho) enters as asinh(Y/sqrt(X^2 + z^2)): the same sum without cancellation."""
    signs = np.array([1.0, -1.0])
    X, Y = (
        points[..., 0, None, None] + sides[0] * signs[:, None],
        points[..., 1, None, None] + sides[1] * signs[None, :],
    )
    X, Y = np.where(np.abs(X) <= ROUNDING * sides[0], 0.0, X), np.where(np.abs(Y) <= ROUNDING * sides[1], 0.0, Y)
    Z = points[..., 2, None, None]
    weight = signs[:, None] * signs[None, :]
    rho = np.sqrt(X**2 + Y**2 + Z**2)
    square_x, square_y = X**2 + Z**2, Y**2 + Z**2
    with np.errstate(divide="ignore", invalid="ignore"):
        # On an edge line (X = Z = 0) the logarithm is infinite but multiplied by X or Z: the product is zero.
        log_y = np.where(square_x > 0, np.arcsinh(Y / np.sqrt(square_x)), 0.0)
        log_x = np.where(square_y > 0, np.arcsinh(X / np.sqrt(square_y)), 0.0)
        log_z = np.log(np.where(rho > 0, rho + Z, corner_distance))
        by_x = np.where(square_x > 0, 1 / (square_x * rho), 0.0)
        by_y = np.where(square_y > 0, 1 / (square_y * rho), 0.0)
        z_by_rho = np.where(rho > 0, Z / rho, 0.0)
        X_log_z, Y_log_z = np.where(X == 0, 0.0, X * log_z), np.where(Y == 0, 0.0, Y * log_z)
    angle = np.arctan2(X * Y, Z * rho)
    # atan(Y/X) - atan(zY/(X rho)) as one angle: the difference of two nearly equal right angles would cancel.
    turn_x = np.arctan2(X * Y * (rho - Z), X**2 * rho + Z * Y**2)
    turn_y = np.arctan2(X * Y * (rho - Z), Y**2 * rho + Z * X**2)

    def corners(values: Array) -> Array:
        return np.asarray((weight * values).sum(axis=(-2, -1)))

    with np.errstate(invalid="ignore"):
        chi_xy = corners(log_z)
    return _Potentials(
        z=points[..., 2],
        V=corners(X * log_y + Y * log_x - Z * angle),
        V_x=corners(log_y),
        V_y=corners(log_x),
        V_z=-corners(angle),
        W_xx=-corners(X * Y * Z * by_x),
        W_yy=-corners(X * Y * Z * by_y),
        W_xy=corners(z_by_rho),
        W_xz=-corners(Y * Z**2 * by_x),
        W_yz=-corners(X * Z**2 * by_y),
        chi_x=corners(Y_log_z + Z * log_y + X * turn_x),
        chi_y=corners(X_log_z + Z * log_x + Y * turn_y),
        chi_xx=corners(turn_x),
        chi_yy=corners(turn_y),
        chi_xy=chi_xy,
    )


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


def _near_or_far(
    points: Array,
    sides: tuple[float, float],
    near: Callable[[Array], Array],
    far: Callable[[Array], Array],
) -> Array:
    """Evaluate `near` at points close to the rectangle and the quadrature of the point load `far` at the others."""
    flat = points.reshape(-1, 3)
    remote = np.linalg.norm(flat, axis=-1) > FAR * max(sides)
    close_values = near(flat[~remote])
    values = np.empty((len(flat), *close_values.shape[1:]))
    values[~remote] = close_values
    nodes, weights = np.polynomial.legendre.leggauss(_ORDER)
    values[remote] = 0.0
    for xi, weight_x in zip(nodes, weights, strict=True):
        for eta, weight_y in zip(nodes, weights, strict=True):
            offsets = flat[remote] - np.array([sides[0] * xi, sides[1] * eta, 0.0])
            values[remote] += weight_x * weight_y * sides[0] * sides[1] * far(offsets)
    return values.reshape((*points.shape[:-1], *values.shape[1:]))


def _rectangle_sides(half_sides: tuple[float, float]) -> tuple[float, float]:
    """Return half-sides, checked to be two positive lengths."""
    try:
        a, b = half_sides
    except (TypeError, ValueError):
        raise InputError(f"Expected half_sides=(a, b); found {half_sides!r}.", code="half-sides") from None
    return checks.positive("the half-side a", a), checks.positive("the half-side b", b)


def _inside(points: ArrayLike) -> Array:
    """Return points (..., 3) as an array, checked to lie at z >= 0."""
    coordinates = checks.point_array("points", points, 3)
    if np.any(coordinates[..., 2] < 0):
        raise InputError(f"Expected points with z >= 0, inside the body; found z = {coordinates[..., 2].min()}.")
    return coordinates + 0.0  # z = -0.0 would give the angle of the other side
