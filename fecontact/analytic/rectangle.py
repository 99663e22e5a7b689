"""Half-space under uniform pressure on a rectangle (Love 1929).

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
    sides = rectangle_sides(half_sides)
    xs, ys = np.broadcast_arrays(checks.coordinates("x", x), checks.coordinates("y", y))
    points = np.stack([xs, ys, np.zeros_like(xs)], axis=-1)

    def near(close: Array) -> Array:
        return potentials(close, sides).V

    def far(offsets: Array) -> Array:
        return np.asarray(1 / np.linalg.norm(offsets, axis=-1))

    factor = checks.finite("the pressure", pressure) / (np.pi * checks.positive("the modulus", modulus))
    return np.asarray(factor * near_or_far(points, sides, near, far))


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
    sides = rectangle_sides(half_sides)
    coordinates = inside(points)
    nu = material.nu
    scale = checks.finite("the pressure", pressure) / (4 * np.pi * material.shear_modulus)

    def near(close: Array) -> Array:
        f = potentials(close, sides)
        u_x = 0.0 - (f.z * f.V_x + (1 - 2 * nu) * f.chi_x)
        u_y = 0.0 - (f.z * f.V_y + (1 - 2 * nu) * f.chi_y)
        return np.stack([scale * u_x, scale * u_y, scale * (2 * (1 - nu) * f.V - f.z * f.V_z)], axis=-1)

    def far(offsets: Array) -> Array:
        return boussinesq.displacement(offsets, force=(0.0, 0.0, pressure), material=material)

    return near_or_far(coordinates, sides, near, far)


def stress(
    points: ArrayLike,
    *,
    half_sides: tuple[float, float],
    pressure: float,
    material: Material,
    corner_distance: float = 0.0,
) -> Array:
    """Return the stress in the half-space and on its surface.

    Parameters
    ----------
    points, half_sides, pressure, material
        As in `displacement`.
    corner_distance : float
        Distance assumed at the four corners, where xy is infinite as the logarithm of the distance.

    Returns
    -------
    numpy.ndarray, shape (..., 3, 3)
        Stress tensors, tension positive. On the edges and at the corners of the rectangle, where some components jump,
        the mean of their limits along the surface from all sides; on the surface the shears with z are zero. Points
        within rounding of an edge count as on it.

    Raises
    ------
    InputError
        If a point lies outside the half-space, or a side is not positive.

    References
    ----------
    Love 1929, section 2 and 4.

    Examples
    --------
    >>> tensor = stress([0.0, 0.0, 0.0], half_sides=(1.0, 1.0), pressure=1.0, material=Material(1.0, 0.25))
    >>> tensor.diagonal().round(6)
    array([-0.75, -0.75, -1.  ])
    """
    sides = rectangle_sides(half_sides)
    coordinates = inside(points)
    nu = material.nu
    scale = checks.finite("the pressure", pressure) / (2 * np.pi)

    def near(close: Array) -> Array:
        f = potentials(close, sides, corner_distance if scale else 1.0)
        tensor = np.empty((*close.shape[:-1], 3, 3))
        tensor[..., 0, 0] = 2 * nu * f.V_z - (1 - 2 * nu) * f.chi_xx - f.W_xx
        tensor[..., 1, 1] = 2 * nu * f.V_z - (1 - 2 * nu) * f.chi_yy - f.W_yy
        tensor[..., 2, 2] = f.V_z + f.W_xx + f.W_yy
        tensor[..., 0, 1] = tensor[..., 1, 0] = -(1 - 2 * nu) * f.chi_xy - f.W_xy
        tensor[..., 0, 2] = tensor[..., 2, 0] = -f.W_xz
        tensor[..., 1, 2] = tensor[..., 2, 1] = -f.W_yz
        return scale * tensor

    def far(offsets: Array) -> Array:
        return boussinesq.stress(offsets, force=(0.0, 0.0, pressure), material=material)

    return near_or_far(coordinates, sides, near, far)


@dataclass(frozen=True, eq=False)
class Potentials:
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


def potentials(points: Array, sides: tuple[float, float], corner_distance: float = 0.0) -> Potentials:
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
    return Potentials(
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


def near_or_far(
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


def rectangle_sides(half_sides: tuple[float, float]) -> tuple[float, float]:
    """Return half-sides, checked to be two positive lengths."""
    try:
        a, b = half_sides
    except (TypeError, ValueError):
        raise InputError(f"Expected half_sides=(a, b); found {half_sides!r}.", code="half-sides") from None
    return checks.positive("the half-side a", a), checks.positive("the half-side b", b)


def inside(points: ArrayLike) -> Array:
    """Return points (..., 3) as an array, checked to lie at z >= 0."""
    coordinates = checks.point_array("points", points, 3)
    if np.any(coordinates[..., 2] < 0):
        raise InputError(f"Expected points with z >= 0, inside the body; found z = {coordinates[..., 2].min()}.")
    return coordinates + 0.0  # z = -0.0 would give the angle of the other side
