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

#: Places of the components xx, yy, zz, xy, yz, xz in a tensor.
TENSOR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])


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
    coordinates, _, _ = _geometry(points, above)
    x, y, z = np.moveaxis(coordinates, -1, 0)
    Qx, Qy, P = np.moveaxis(_load(force), -1, 0)
    return np.asarray(stress_components(x, y, z, (Qx, Qy, P), material.nu)[..., TENSOR])


def stress_components(
    x: Array,
    y: Array,
    z: Array,
    force: tuple[Array | float, Array | float, Array | float],
    nu: float,
    core: float = 0.0,
) -> Array:
    """Return the stress components (..., 6) at offsets from a point load, without checks.

    Parameters
    ----------
    x, y, z : numpy.ndarray
        Offsets from the load, broadcast together.
    force : tuple of three array_like
        Load (Qx, Qy, P), numbers or broadcast with the offsets.
    nu : float
        Poisson's ratio.
    core : float
        Distance from the load within which the stress is taken as zero.

    Returns
    -------
    numpy.ndarray, shape (..., 6)
        xx, yy, zz, xy, yz, xz.

    References
    ----------
    As of `stress`; Johnson 1985, equation 3.76.

    Examples
    --------
    >>> stress_components(np.zeros(1), np.zeros(1), np.ones(1), (0.0, 0.0, 2 * np.pi), 0.25)[0, :3]
    array([ 0.25,  0.25, -3.  ])
    """
    Qx, Qy, P = force
    square = x**2 + y**2 + z**2
    deep = square > core**2
    rho = np.sqrt(np.where(deep, square, 1.0))
    inverse = 1 / rho
    s = 1 / (rho + z)
    shares = []  # of each component of the load: parts of xx, yy, xy with 1 - 2 nu, and its product with the offset
    if np.any(P):
        # with f = (1 - z/rho)/r^2 the part of 1 - 2 nu is f I - g (r^2 I - r r^T), without a quotient by r
        f = s * inverse
        scaled = P * f
        g = scaled * f * (2 * rho + z) * inverse
        shares.append((scaled - y * y * g, scaled - x * x * g, x * y * g, P * z))
    if np.any(Qx):
        shares.append(_by_shear(x, y, Qx, s, inverse))
    if np.any(Qy):
        yy, xx, xy, along = _by_shear(y, x, Qy, s, inverse)
        shares.append((xx, yy, xy, along))
    if not shares:
        return np.zeros((*square.shape, 6))
    xx, yy, xy, along = shares[0]
    for more in shares[1:]:
        xx, yy, xy, along = (one + other for one, other in zip((xx, yy, xy, along), more, strict=True))
    lateral, axial = (1 - 2 * nu) * deep, 3 * along * (inverse * inverse * inverse * inverse * inverse * deep)
    normal = [lateral * xx - axial * x * x, lateral * yy - axial * y * y, -axial * z * z]
    shears = [lateral * xy - axial * x * y, -axial * y * z, -axial * x * z]
    return np.asarray(np.stack([*normal, *shears], axis=-1) / (2 * np.pi))


def _by_shear(a: Array, b: Array, Q: Array | float, s: Array, inverse: Array) -> tuple[Array, Array, Array, Array]:
    """Parts along, across and in shear by a load along a; with s = 1/(rho + z) and 1/rho."""
    beside, cubed = s * s * inverse, inverse * inverse * inverse
    g = s * s * cubed + 2 * s * beside * inverse
    curved, Qa = a * a * g, Q * a
    return Qa * (cubed - 3 * beside + curved), Qa * (cubed - beside + b * b * g), Q * b * (curved - beside), Qa


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
