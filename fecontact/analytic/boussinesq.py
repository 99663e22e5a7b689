"""Half-space under a point load on its surface: Boussinesq (normal) and Cerruti (tangential).

The half-space fills z >= 0 (z into the body), the load acts at the origin of its surface. Displacements decay as
1/distance and are relative to points at infinity.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material


def surface_displacement(distance: ArrayLike, *, force: float, modulus: float) -> Array:
    """Return the normal surface displacement P / (pi E' d) under a normal point load.

    Parameters
    ----------
    distance : array_like
        Distance d from the load on the surface, any shape, positive.
    force : float
        Normal load P, positive into the body.
    modulus : float
        E' = E/(1 - nu^2) of the half-space, or E* for two bodies together.

    Returns
    -------
    numpy.ndarray
        Displacement into the body, shape of `distance`.

    Raises
    ------
    InputError
        If a distance or the modulus is not positive.

    References
    ----------
    J. Boussinesq, 1885; K. L. Johnson, Contact Mechanics, 1985, chapter 3.

    Examples
    --------
    >>> surface_displacement([1.0, 2.0], force=np.pi, modulus=1.0)
    array([1. , 0.5])
    """
    d = checks.depths("the distance", distance)
    if np.any(d == 0):
        raise InputError("Expected distances > 0: the displacement is infinite under the load itself; found 0.")
    return np.asarray(checks.finite("the force", force) / (np.pi * checks.positive("the modulus", modulus)) / d)


def compliance(points: ArrayLike, material: Material, *, above: float = 0.0) -> Array:
    """Return the displacements due to unit loads in x, y and z: Green's tensor of the half-space.

    Parameters
    ----------
    points : array_like, shape (..., 3)
        Points with z >= -above rho, rho their distance from the load; not the origin.
    material : Material
        Material of the half-space.
    above : float
        Below 1. The field is analytic but on the half-line over the load, so that it can be continued above the plane,
        for a body whose curved face lies partly above its tangent plane.

    Returns
    -------
    numpy.ndarray, shape (..., 3, 3)
        Displacement component i (second last axis) due to a unit force along j (last axis).

    Raises
    ------
    InputError
        If a point lies outside the half-space (beyond `above`) or under the load.

    References
    ----------
    A. E. H. Love, Mathematical Theory of Elasticity, 4th ed. 1927, arts. 135, 166; Johnson 1985, chapter 3.

    Examples
    --------
    >>> bool(np.allclose(compliance([0.0, 0.0, 1.0], Material(1.0, 0.25))[2, 2], 1.25 * 2.5 / (2 * np.pi)))
    True
    """
    coordinates, rho, s = _geometry(points, above)
    nu = material.nu
    planar = coordinates[..., :2]
    depth = coordinates[..., 2]
    tensor = coordinates[..., :, None] * coordinates[..., None, :] / rho[..., None, None] ** 3
    tensor[..., :2, :2] -= (1 - 2 * nu) * planar[..., :, None] * planar[..., None, :] / (rho * s**2)[..., None, None]
    for axis in (0, 1):
        tensor[..., axis, axis] += 1 / rho + (1 - 2 * nu) / s
    tensor[..., 2, 2] = (depth / rho) ** 2 / rho + 2 * (1 - nu) / rho
    coupling = (1 - 2 * nu) * planar / (rho * s)[..., None]
    tensor[..., :2, 2] -= coupling
    tensor[..., 2, :2] += coupling
    return np.asarray(tensor / (4 * np.pi * material.shear_modulus))


def displacement(points: ArrayLike, *, force: ArrayLike, material: Material, above: float = 0.0) -> Array:
    """Return the displacement of the half-space under a point load of any direction.

    Parameters
    ----------
    points, material, above
        As in `compliance`.
    force : array_like, shape (3,) or (..., 3)
        Load (Qx, Qy, P), P positive into the body: one for all points, or broadcast with them.

    Returns
    -------
    numpy.ndarray, shape (..., 3)
        Displacement vectors.

    Raises
    ------
    InputError
        If a point lies outside the half-space or under the load.

    References
    ----------
    Johnson 1985, chapter 3.

    Examples
    --------
    >>> displacement([1.0, 0.0, 0.0], force=(0.0, 0.0, np.pi), material=Material(1.0, 0.0)).round(6)
    array([-0.5,  0. ,  1. ])
    """
    return np.asarray((compliance(points, material, above=above) @ _load(force)[..., None])[..., 0])


def stress(points: ArrayLike, *, force: ArrayLike, material: Material, above: float = 0.0) -> Array:
    """Return the stress in the half-space under a point load of any direction.

    Parameters
    ----------
    points, force, material, above
        As in `displacement`.

    Returns
    -------
    numpy.ndarray, shape (..., 3, 3)
        Stress tensors, tension positive.

    Raises
    ------
    InputError
        If a point lies outside the half-space or under the load.

    Notes
    -----
    The radial part -3 x x^T (x . F) / (2 pi rho^5) balances the load; the rest, a factor (1 - 2 nu), lies in planes of
    constant depth. It is written in 1/(rho + z) to avoid cancellation on the axis.

    References
    ----------
    Johnson 1985, chapter 3.

    Examples
    --------
    >>> stress([0.0, 0.0, 1.0], force=(0.0, 0.0, 2 * np.pi), material=Material(1.0, 0.25)).diagonal()
    array([ 0.25,  0.25, -3.  ])
    """
    coordinates, rho, s = _geometry(points, above)
    vector = _load(force)
    nu = material.nu
    planar, depth = coordinates[..., :2], coordinates[..., 2]
    shear, normal = vector[..., :2], vector[..., 2]
    along = (coordinates * vector).sum(axis=-1)
    sheared = (planar * shear).sum(axis=-1)
    result = -3 * coordinates[..., :, None] * coordinates[..., None, :] * (along / rho**5)[..., None, None]
    outer = planar[..., :, None] * planar[..., None, :]
    mixed = planar[..., :, None] * shear[..., None, :]
    isotropic = normal * (depth / rho**3 - 1 / (rho * s)) + sheared * (1 / rho**3 - 1 / (rho * s**2))
    directed = normal * (rho + s) / (rho**3 * s**2) + sheared * (s + 2 * rho) / (rho**3 * s**3)
    lateral = outer * directed[..., None, None]
    lateral -= (mixed + np.swapaxes(mixed, -1, -2)) / (rho * s**2)[..., None, None]
    lateral += isotropic[..., None, None] * np.eye(2)
    result[..., :2, :2] += (1 - 2 * nu) * lateral
    return np.asarray(result / (2 * np.pi))


def _geometry(points: ArrayLike, above: float) -> tuple[Array, Array, Array]:
    """Return the points, their distance rho from the load, and rho + z."""
    coordinates = checks.point_array("points", points, 3)
    if not 0 <= above < 1:
        raise InputError(f"Expected above >= 0 and < 1, a share of the distance; found {above!r}.", code="above-range")
    rho = np.linalg.norm(coordinates, axis=-1)
    if np.any(coordinates[..., 2] < -above * rho):
        lowest = coordinates[..., 2].min()
        limit = f"z >= -{above:g} times the distance from the load" if above else "z >= 0, inside the body"
        raise InputError(f"Expected points with {limit}; found z = {lowest}.", code="points-outside-body")
    if np.any(rho == 0):
        raise InputError("Expected points away from the load; found the origin, where the fields are infinite.")
    return coordinates, rho, rho + coordinates[..., 2]


def _load(force: ArrayLike) -> Array:
    vector = checks.coordinates("force", force)
    if vector.ndim == 0 or vector.shape[-1] != 3:
        raise InputError(f"Expected forces (Qx, Qy, P) on the last axis; found shape {vector.shape}.", code="forces")
    return vector
