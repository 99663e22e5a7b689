"""Half-space loaded by Hertz's or by uniform pressure on a disc.

Stresses need Poisson's ratio of the half-space, displacements its plane-strain modulus E/(1 - nu^2);
with E* in place of that modulus, displacements are those of both bodies together.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe, elliprd

from fecontact.analytic._contact import AxisymmetricStress
from fecontact.analytic._functions import arctan_defect
from fecontact.common import checks
from fecontact.common.arrays import Array


def hertz_pressure(r: ArrayLike, *, a: float, p0: float) -> Array:
    """Return the pressure p0 sqrt(1 - r^2/a^2), zero for r > a.

    Parameters
    ----------
    r : array_like
        Distance from the axis, any shape.
    a : float
        Radius of the disc.
    p0 : float
        Pressure at the centre.

    Returns
    -------
    numpy.ndarray
        Pressure, shape of `r`, compression positive.

    Raises
    ------
    InputError
        If a distance is negative or not finite, or the radius not positive.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, chapter 3.

    Examples
    --------
    >>> hertz_pressure([0.0, 0.6, 2.0], a=1.0, p0=10.0)
    array([10.,  8.,  0.])
    """
    xi = checks.depths("r", r) / checks.positive("the radius a", a)
    return np.asarray(p0 * np.sqrt(np.maximum((1 - xi) * (1 + xi), 0.0)))


def hertz_displacement(r: ArrayLike, *, a: float, p0: float, modulus: float) -> Array:
    """Return the normal surface displacement under Hertz's pressure, inside and outside the disc.

    Parameters
    ----------
    r, a, p0
        As in `hertz_pressure`.
    modulus : float
        E/(1 - nu^2) of the half-space, or E* for both bodies together.

    Returns
    -------
    numpy.ndarray
        Displacement into the body, shape of `r`.

    Raises
    ------
    InputError
        If a distance is negative or not finite, or the radius or modulus not positive.

    Notes
    -----
    Outside, with s = sqrt(r^2/a^2 - 1) and t = 1/s, the textbook form (2a^2 - r^2) asin(a/r) + a sqrt(r^2 - a^2)
    equals a^2 (atan t + (1 - atan(t)/t)/t), which does not cancel for r >> a.

    References
    ----------
    Johnson 1985, chapter 3.

    Examples
    --------
    >>> hertz_displacement([0.0, 1.0], a=1.0, p0=1.0, modulus=np.pi)
    array([0.5 , 0.25])
    """
    xi = checks.depths("r", r) / checks.positive("the radius a", a)
    inside = np.pi / 2 * (2 - np.minimum(xi, 1.0) ** 2)
    beyond = np.maximum(xi, 1.0)
    s = np.sqrt((beyond - 1) * (beyond + 1))
    with np.errstate(divide="ignore"):  # s = 0 at the edge: 1/s is infinite, as the next line expects
        outside = np.arctan2(1.0, s) + s * arctan_defect(1 / s)
    return np.asarray(p0 * a / (2 * checks.positive("the modulus", modulus)) * np.where(xi <= 1, inside, outside))


def hertz_stress(r: ArrayLike, z: ArrayLike, *, a: float, p0: float, nu: float) -> AxisymmetricStress:
    """Return the stress field of a half-space under Hertz's pressure.

    Parameters
    ----------
    r, z : array_like
        Distance from the axis and depth, broadcast together.
    a, p0
        As in `hertz_pressure`.
    nu : float
        Poisson's ratio.

    Returns
    -------
    AxisymmetricStress
        Stress components, tension positive, each of the broadcast shape.

    Raises
    ------
    InputError
        If a coordinate is negative or not finite, or the radius not positive.

    Notes
    -----
    Lengths in units of a. With r^2/(1 + u) + z^2/u = 1 (confocal spheroids) and q = z/sqrt(u), the factor (1 - q^3)/r^2
    of Huber's formulas is (1 + q + q^2)/((1 + q)(1 + u)), and u + q^2 is the discriminant. These forms do not cancel at
    the axis, at the surface or at great depth.

    References
    ----------
    M. T. Huber, Ann. Physik 14 (1904) 153; on the axis Johnson 1985, chapter 3.

    Examples
    --------
    >>> stress = hertz_stress([0.0, 1.0], 0.0, a=1.0, p0=1.0, nu=0.25)
    >>> stress.rr.round(4), stress.tt.round(4)
    (array([-0.75  ,  0.1667]), array([-0.75  , -0.1667]))
    """
    scale = checks.positive("the radius a", a)
    rho, zeta = np.broadcast_arrays(checks.depths("r", r) / scale, checks.depths("z", z) / scale)
    s = (rho - 1) * (rho + 1) + zeta**2
    root = np.hypot(s, 2 * zeta)
    # u and q^2 are the two roots (root +- s)/2; each is formed without subtraction and gives the other by u q^2 = z^2.
    larger = (root + np.abs(s)) / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        smaller = np.where(larger > 0, zeta * (zeta / larger), 0.0)
        u = np.where(s >= 0, larger, smaller)
        q = np.sqrt(np.where(s >= 0, smaller, larger))
        defect = arctan_defect(np.where(u > 0, 1 / np.sqrt(u), np.inf))
        cubic = np.where(root > 0, q**3 / root, 0.0)  # at the edge itself root = 0 and both vanish as its square root
        shear = np.where(root > 0, q**2 * np.sqrt(u) / root, 0.0)
    shell = 1 / (1 + u)
    lateral = (1 - 2 * nu) / 3 * shell * (1 + q + q**2) / (1 + q)
    return AxisymmetricStress(
        rr=p0 * (lateral + cubic - q * ((1 - nu) * shell + (1 + nu) * defect)),
        tt=p0 * (-lateral + q * ((1 - nu) * shell - (1 + nu) * defect)),
        zz=-p0 * cubic,
        rz=-p0 * rho * shell * shear,
    )


def uniform_displacement(r: ArrayLike, *, a: float, pressure: float, modulus: float) -> Array:
    """Return the normal surface displacement under uniform pressure, inside and outside the disc.

    Parameters
    ----------
    r, a, modulus
        As in `hertz_displacement`.
    pressure : float
        Pressure, positive into the body.

    Returns
    -------
    numpy.ndarray
        Displacement into the body, shape of `r`; 2 p a / E' at the centre, 4 p a / (pi E') at the edge.

    Raises
    ------
    InputError
        If a distance is negative or not finite, or the radius or modulus not positive.

    Notes
    -----
    Outside, E(m) - (1 - m) K(m) with m = a^2/r^2 is m (1 - m) R_D(0, 1, 1 - m)/3 in Carlson's integral: no
    cancellation for r >> a.

    References
    ----------
    Johnson 1985, chapter 3.

    Examples
    --------
    >>> uniform_displacement([0.0, 1.0], a=1.0, pressure=1.0, modulus=4.0).round(6)
    array([0.5    , 0.31831])
    """
    xi = checks.depths("r", r) / checks.positive("the radius a", a)
    beyond = np.where(xi > 1, xi, 2.0)
    complement = (1 - 1 / beyond) * (1 + 1 / beyond)
    outside = complement * elliprd(0.0, 1.0, complement) / (3 * beyond)
    shape = np.where(xi > 1, outside, ellipe(np.minimum(xi, 1.0) ** 2))
    return np.asarray(4 * pressure * a / (np.pi * checks.positive("the modulus", modulus)) * shape)


def uniform_stress_on_axis(z: ArrayLike, *, a: float, pressure: float, nu: float) -> AxisymmetricStress:
    """Return the stress at depths z below the centre of a uniformly loaded disc.

    Parameters
    ----------
    z : array_like
        Depth, any shape.
    a : float
        Radius of the disc.
    pressure : float
        Pressure, positive into the body.
    nu : float
        Poisson's ratio.

    Returns
    -------
    AxisymmetricStress
        Stress components, tension positive, shape of `z`; radial and hoop stress are equal.

    Raises
    ------
    InputError
        If a depth is negative or not finite, or the radius not positive.

    References
    ----------
    Johnson 1985, chapter 3; S. P. Timoshenko & J. N. Goodier, Theory of Elasticity, 3rd ed. 1970, art. 139.

    Examples
    --------
    >>> stress = uniform_stress_on_axis([0.0, 1.0], a=1.0, pressure=1.0, nu=0.25)
    >>> stress.zz.round(4), stress.rr.round(4)
    (array([-1.    , -0.6464]), array([-0.75  , -0.0429]))
    """
    zeta = checks.depths("z", z) / checks.positive("the radius a", a)
    root = np.hypot(1, zeta)
    cosine = zeta / root
    # 1 - z/sqrt(1 + z^2) and 1 - (z/sqrt(1 + z^2))^3 without the cancellation at great depth.
    first = 1 / (root * (root + zeta))
    third = first * (1 + cosine + cosine**2)
    lateral = -pressure * ((1 + 2 * nu) * first / 2 - cosine / (2 * root**2))
    return AxisymmetricStress(rr=lateral, tt=lateral, zz=-pressure * third, rz=np.zeros_like(zeta))
