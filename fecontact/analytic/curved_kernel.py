"""Displacement of a curved face under a point load on it, near the load, and its integrals over cells of a grid.

Load and displacement are along one direction z, that of a tangent plane near by. The places are given by their
distance (x, y) on that plane and their difference in height; curvatures k are those of the heights. With
d^2 = x^2 + y^2, rho^2 = d^2 + z^2, H the mean curvature, k_d that along (x, y), and mu the shear modulus,

    2 pi mu u = (1 - nu)/rho + nu z^2/rho^3 - (1 - 2 nu)^2/2 (H log(rho/length) - (k_d - H)/2) + O(rho log rho).

The first two terms are those of a plane that goes through both places, whatever its slope; the last is the effect of
curvature, where the tangent plane's field leaves a traction. docs/theory/local-bodies.md has the derivation.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material


def displacement(offset: ArrayLike, *, curvature: ArrayLike, length: float, material: Material) -> Array:
    """Return the displacement by a unit load, without what is bounded and continuous at the load.

    Parameters
    ----------
    offset : array_like, shape (..., 3)
        From the load to the place, both on the face; (x, y) on the plane, z along its normal.
    curvature : array_like, shape (2, 2)
        Second derivatives of the depth of the face below the plane, convex positive.
    length : float
        Unit of length of the logarithm.
    material : Material
        Material of the body.

    Returns
    -------
    numpy.ndarray, shape (...)
        Displacement along z by a unit load along z: symmetric under exchange of the places.

    Raises
    ------
    InputError
        If an offset is zero or the curvature has another shape.

    References
    ----------
    docs/theory/local-bodies.md; for a ball, the logarithm of the exact series: A. L. Titovich & A. N. Norris, J. Mech.
    Mater. Struct. 7 (2012) 701.

    Examples
    --------
    >>> material = Material(E=1.0, nu=0.0)
    >>> displacement([1.0, 0.0, 0.0], curvature=np.zeros((2, 2)), length=1.0, material=material).round(6)
    np.float64(0.31831)
    """
    x, y, z = np.moveaxis(checks.point_array("the offset", offset, 3), -1, 0)
    (k_x, k_xy), (_, k_y) = _tensor(curvature)
    nu = material.nu
    rho = np.sqrt(x**2 + y**2 + z**2)
    if np.any((x == 0) & (y == 0)):
        raise InputError("Expected places beside the load; found the load's own, where the displacement is infinite.")
    turned = ((k_x - k_y) / 2 * (x**2 - y**2) + 2 * k_xy * x * y) / (x**2 + y**2)
    bent = (k_x + k_y) / 2 * np.log(rho / length) - turned / 2
    plane = (1 - nu) / rho + nu * z**2 / rho**3
    return np.asarray((plane - (1 - 2 * nu) ** 2 / 2 * bent) / (2 * np.pi * material.shear_modulus))


def bent_table(
    shape: tuple[int, int], cell: tuple[float, float], *, curvature: ArrayLike, length: float, material: Material
) -> Array:
    """Return what curvature adds to the displacements of cells by unit pressure on a cell.

    Parameters
    ----------
    shape : tuple of (int, int)
        Number of offsets along x and y.
    cell : tuple of (float, float)
        Sides of a cell, along the directions of principal curvature.
    curvature : array_like, shape (2,)
        Principal curvatures, along x and y, convex positive.
    length : float
        Unit of length of the logarithm.
    material : Material
        Material of the body.

    Returns
    -------
    numpy.ndarray, shape (nx, ny)
        Integrals over cells at offsets (i, j) of the last term of `displacement`; even in either direction.

    Raises
    ------
    InputError
        If a length is not positive.

    Notes
    -----
    Second differences of the closed integrals of log r and (x^2 - y^2)/r^2; they cancel as the square of the offset, to
    1e-10 of the value at 1000 cells.

    Examples
    --------
    >>> bent_table((2, 1), (0.1, 0.1), curvature=(1.0, 1.0), length=1.0, material=Material(1.0, 0.0)).round(6)
    array([[0.005354],
           [0.003658]])
    """
    k_x, k_y = np.asarray(curvature, dtype=float)
    checks.lengths(length=length, cell_x=cell[0], cell_y=cell[1])

    def logarithm(x: Array, y: Array) -> Array:
        r2 = (x**2 + y**2) / length**2
        angles = x**2 * np.arctan(y / x) + y**2 * np.arctan(x / y)
        return np.asarray((x * y * (np.log(r2) - 3) + angles) / 2)

    def turned(x: Array, y: Array) -> Array:
        return np.asarray(x**2 * np.arctan(y / x) - y**2 * np.arctan(x / y))

    nu = material.nu
    mean, half = (k_x + k_y) / 2, (k_x - k_y) / 4
    total = mean * _over_cells(shape, cell, logarithm) - half * _over_cells(shape, cell, turned)
    return np.asarray(-((1 - 2 * nu) ** 2) / (4 * np.pi * material.shear_modulus) * total)


def inclined_table(shape: tuple[int, int], cell: tuple[float, float], material: Material) -> Array:
    """Return the kernel T of the effect of slopes on the displacements of cells by pressures p on them.

    Where the face inclines, the two first terms of `displacement` are (1 - nu)/d + (3 nu - 1)/2 z^2/d^3 up to slope^4,
    over 2 pi mu. With f the depths of the cells, z = f(x) - f(s), the second is f^2 T p - 2 f T (f p) + T (f^2 p):
    three convolutions, and for the load on the place's own cell `inclined_own`.

    Parameters
    ----------
    shape : tuple of (int, int)
        Number of offsets along x and y.
    cell : tuple of (float, float)
        Sides of a cell.
    material : Material
        Material of the body.

    Returns
    -------
    numpy.ndarray, shape (nx, ny)
        (3 nu - 1)/(4 pi mu) times the integral of 1/r over the cell and 1/d^2 at its middle; zero at no offset.

    Examples
    --------
    >>> inclined_table((1, 3), (1.0, 1.0), Material(1.0, 0.0)).round(5)
    array([[-0.     , -0.16521, -0.0201 ]])
    """
    inverse = _over_cells(shape, cell, lambda x, y: x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y)))
    d2 = (np.arange(shape[0])[:, None] * cell[0]) ** 2 + (np.arange(shape[1]) * cell[1]) ** 2
    d2[0, 0] = np.inf
    return np.asarray(_inclined(material) * inverse / d2)


def inclined_own(slopes: ArrayLike, cell: tuple[float, float], material: Material) -> Array:
    """Return the effect of slopes on the displacement of a cell by unit pressure on itself.

    Parameters
    ----------
    slopes : array_like, shape (..., 2)
        Slopes of the face along x and y.
    cell : tuple of (float, float)
        Sides of a cell.
    material : Material
        Material of the body.

    Returns
    -------
    numpy.ndarray, shape (...)
        (3 nu - 1)/(4 pi mu) times the integral of (slope . x)^2/r^3 over the cell.

    Examples
    --------
    >>> inclined_own([0.1, 0.0], (1.0, 1.0), Material(1.0, 0.0)).round(6)
    np.float64(-0.002805)
    """
    g = checks.point_array("the slopes", slopes, 2)
    x, y = cell
    integrals = np.array([2 * y * np.arcsinh(x / y), 2 * x * np.arcsinh(y / x)])
    return np.asarray(_inclined(material) * (g**2 @ integrals))


def _inclined(material: Material) -> float:
    return (3 * material.nu - 1) / (4 * np.pi * material.shear_modulus)


def _tensor(curvature: ArrayLike) -> Array:
    tensor = checks.coordinates("the curvature", curvature)
    if tensor.shape != (2, 2):
        raise InputError(f"Expected a curvature tensor of shape (2, 2); found {tensor.shape}.", code="curvature-shape")
    return tensor


def _over_cells(shape: tuple[int, int], cell: tuple[float, float], primitive: Callable[[Array, Array], Array]) -> Array:
    """Integrals over cells at offsets 0, 1, ... from the primitive at their corners, all of which lie off the axes."""
    x, y = (np.arange(n + 1.0) * side - side / 2 for n, side in zip(shape, cell, strict=True))
    return np.asarray(np.diff(np.diff(primitive(x[:, None], y[None]), axis=0), axis=1))
