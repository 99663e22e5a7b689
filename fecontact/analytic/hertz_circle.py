"""Hertz contact over a circle: spheres, a sphere in a seat, a sphere on a plane."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from fecontact.analytic import disc
from fecontact.analytic._contact import RoundIndentation
from fecontact.analytic._functions import arctan_defect
from fecontact.analytic.pair import pair_modulus, poisson_ratio, relative_radius
from fecontact.analytic.stress import AxisymmetricStress
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.material import Material


@dataclass(frozen=True)
class CircularContact(RoundIndentation):
    """Frictionless contact of two spherical surfaces under Hertz's assumptions; made by `spheres`.

    Parameters
    ----------
    force : float
        Load P.
    approach : float
        Distance delta by which points far from the contact come together, a^2 / R.
    a : float
        Radius of the contact circle, (3 P R / (4 E*))^(1/3).
    p0 : float
        Pressure at the centre, 3 P / (2 pi a^2).
    R : float
        Relative radius, 1/R = 1/R1 + 1/R2.
    E_star : float
        Contact modulus.
    materials : tuple of (Material or None)
        Materials of the two bodies, None for a rigid one.

    References
    ----------
    H. Hertz, J. reine angew. Math. 92 (1882) 156; K. L. Johnson, Contact Mechanics, 1985, section 4.2.

    Examples
    --------
    >>> steel = Material(E=210e3, nu=0.3)
    >>> print(spheres(radii=(250.0, 250.0), materials=(steel, steel), force=7124.0))
    Hertz contact over a circle
      force             P      7124
      approach          delta  0.0257902
      contact radius    a      1.79549
      maximum pressure  p0     1055.12
      mean pressure     pm     703.411
      stiffness         dP/dd  414343
      relative radius   R      125
      contact modulus   E*     115385
    >>> contact = spheres(radii=(1.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), approach=0.01)
    >>> contact.pressure([0.0, 0.06, 1.0]) / contact.p0
    array([1. , 0.8, 0. ])
    >>> contact.displacement([0.0, 0.1])
    array([0.01 , 0.005])
    """

    force: float
    approach: float
    a: float
    p0: float
    R: float
    E_star: float
    materials: tuple[Material | None, Material | None]

    _title = "Hertz contact over a circle"
    _rows = ("force", "approach", "a", "p0", "mean_pressure", "stiffness", "R", "E_star")

    def _pressure(self, r: Array) -> Array:
        """p0 sqrt(1 - r^2/a^2); Johnson 1985, chapter 3."""
        return disc.hertz_pressure(r, a=self.a, p0=self.p0)

    def _displacement(self, r: Array) -> Array:
        """`approach` at the centre; Johnson 1985, chapter 3."""
        return disc.hertz_displacement(r, a=self.a, p0=self.p0, modulus=self.E_star)

    def gap(self, r: ArrayLike) -> Array:
        """Return the distance of the deformed surfaces, zero inside the contact; distances as in `pressure`.

        Notes
        -----
        r^2/(2R) - approach + displacement, evaluated without the cancellation near the edge.

        References
        ----------
        Johnson 1985, chapters 3 and 4.

        Examples
        --------
        >>> contact = spheres(radii=(1.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), approach=0.01)
        >>> contact.gap([0.0, 0.1, 0.2]).round(8)
        array([0.        , 0.        , 0.01217996])
        """
        xi = checks.depths("r", r) / self.a
        s = np.sqrt(np.maximum((xi - 1) * (xi + 1), 0.0))
        return np.asarray(self.a * (self.a / self.R) / np.pi * (s * arctan_defect(s) + s**2 * np.arctan(s)))

    def stress(self, r: ArrayLike, z: ArrayLike, body: int = 0) -> AxisymmetricStress:
        """Return the stress at points below the surface of one body.

        Parameters
        ----------
        r, z : array_like
            Distance from the axis and depth below the surface, broadcast together.
        body : int
            0 for the first body, 1 for the second.

        Returns
        -------
        AxisymmetricStress
            Stress components, tension positive, each of the broadcast shape.

        Raises
        ------
        InputError
            If a coordinate is negative or not finite, or the body is rigid.

        References
        ----------
        M. T. Huber, Ann. Physik 14 (1904) 153.

        Examples
        --------
        >>> steel = Material(E=210e3, nu=0.3)
        >>> contact = spheres(radii=(250.0, 250.0), materials=(steel, steel), force=7124.0)
        >>> (contact.stress(0.0, [0.0, contact.a]).zz / contact.p0).round(3)
        array([-1. , -0.5])
        """
        return disc.hertz_stress(r, z, a=self.a, p0=self.p0, nu=poisson_ratio(self.materials, body))

    def stress_on_axis(self, z: ArrayLike, body: int = 0) -> AxisymmetricStress:
        """Return the stress at depths z below the centre of the contact: `stress` at r = 0, where rr = tt.

        References
        ----------
        Johnson 1985, chapter 3.

        Examples
        --------
        >>> steel = Material(E=210e3, nu=0.3)
        >>> contact = spheres(radii=(250.0, 250.0), materials=(steel, steel), force=7124.0)
        >>> (contact.stress_on_axis([0.0, contact.a]).rr / contact.p0).round(3)
        array([-0.8  , -0.029])
        """
        return self.stress(0.0, z, body)

    def max_shear(self, body: int = 0) -> tuple[float, float]:
        """Return the largest shear stress on the axis and its depth.

        Parameters
        ----------
        body : int
            0 for the first body, 1 for the second.

        Returns
        -------
        tuple of (float, float)
            Shear stress and depth; about 0.31 p0 and 0.48 a for nu = 0.3.

        Raises
        ------
        InputError
            If the body is rigid.

        References
        ----------
        Johnson 1985, section 4.2.

        Examples
        --------
        >>> steel = Material(E=210e3, nu=0.3)
        >>> contact = spheres(radii=(250.0, 250.0), materials=(steel, steel), force=7124.0)
        >>> tau, depth = contact.max_shear()
        >>> round(tau / contact.p0, 4), round(depth / contact.a, 4)
        (0.31, 0.4809)
        """
        nu = poisson_ratio(self.materials, body)

        def slope(zeta: float) -> float:
            shape = math.atan2(1.0, zeta) - zeta / (1 + zeta**2)
            return (1 + nu) * shape - 3 * zeta / (1 + zeta**2) ** 2

        # The slope is positive at the surface (any nu > -1) and negative at zeta = 1 (nu < 0.5): one root between.
        depth = self.a * brentq(slope, 0.0, 1.0, xtol=1e-15)
        return float(self.stress_on_axis(depth, body).max_shear), depth


def spheres(
    radii: tuple[float, float],
    materials: tuple[Material | None, Material | None],
    *,
    force: float | None = None,
    approach: float | None = None,
) -> CircularContact:
    """Return the Hertz contact of two spheres.

    Parameters
    ----------
    radii : tuple of (float, float)
        Radii R1, R2; negative for a concave surface (a seat), `inf` for a plane.
    materials : tuple of (Material or None)
        Materials of the two bodies, None for a rigid one.
    force : float, optional
        Load P, positive.
    approach : float, optional
        Approach delta, positive; give this or the force.

    Returns
    -------
    CircularContact
        Radius, pressure and approach; its methods give the fields.

    Raises
    ------
    InputError
        If the surfaces do not meet at one point (1/R1 + 1/R2 <= 0), both bodies are rigid, or not exactly one of
        force and approach is given and positive.

    Notes
    -----
    Valid while a is small compared with R1 and R2; a closely fitting seat leaves this range at small loads.

    References
    ----------
    Johnson 1985, chapter 4.

    Examples
    --------
    >>> rubber = Material(E=2.0, nu=0.49)
    >>> round(spheres(radii=(10.0, np.inf), materials=(rubber, None), force=1.0).a, 4)
    1.4177
    >>> round(spheres(radii=(10.0, -11.0), materials=(rubber, None), force=1.0).a, 4)
    3.153
    """
    R = relative_radius(radii)
    E_star = pair_modulus(materials)
    name, value = checks.one_of(force=force, approach=approach)
    if name == "force":
        load, a = value, math.cbrt(3 * value * R / (4 * E_star))
        delta = a * (a / R)
    else:
        delta, a = value, math.sqrt(R * value)
        load = 4 * E_star * a * delta / 3
    p0 = 2 * E_star * a / (np.pi * R)
    return CircularContact(force=load, approach=delta, a=a, p0=p0, R=R, E_star=E_star, materials=materials)
