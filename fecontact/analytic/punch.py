"""Rigid frictionless punches on a half-space: flat, tilted flat, cone and power law.

Rigid, frictionless, flat circular punch on a half-space, pressed centrally or tilted.

Rigid frictionless punches with a power-law profile on a half-space: cone, paraboloid and others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import beta, betaincc, hyp2f1

from fecontact.analytic._contact import RoundIndentation, Tabulated
from fecontact.analytic._functions import arctan_defect
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError

__all__ = ["FlatPunch", "PowerPunch", "cone", "flat", "power"]


@dataclass(frozen=True)
class FlatPunch(Tabulated):
    """Flat circular punch, pressed centrally or at an offset that leaves it in full contact; made by `flat`.

    Parameters
    ----------
    force : float
        Load P.
    approach : float
        Displacement delta of the punch's centre, P / (2 a E*).
    a : float
        Radius of the punch.
    offset : float
        Distance e of the load from the centre along x, at most a/3.
    tilt : float
        Rotation of the punch, deeper at positive x, 3 P e / (4 E* a^3).
    E_star : float
        Contact modulus.

    References
    ----------
    I. N. Sneddon, Int. J. Engng Sci. 3 (1965) 47; K. L. Johnson, Contact Mechanics, 1985, sections 3.4-3.5, 5.1.

    Examples
    --------
    >>> print(flat(radius=2.0, modulus=10.0, force=80.0))
    Flat circular punch
      force            P      80
      approach         delta  2
      radius           a      2
      offset           e      0
      tilt (rad)       theta  0
      mean pressure    pm     6.3662
      stiffness        dP/dd  40
      contact modulus  E*     10
    """

    force: float
    approach: float
    a: float
    offset: float
    tilt: float
    E_star: float

    _title = "Flat circular punch"
    _rows = (
        "force",
        "approach",
        ("radius", "a", "a"),
        ("offset", "e", "offset"),
        ("tilt (rad)", "theta", "tilt"),
        "mean_pressure",
        "stiffness",
        "E_star",
    )

    @property
    def mean_pressure(self) -> float:
        """P / (pi a^2)."""
        return self.force / (math.pi * self.a**2)

    @property
    def stiffness(self) -> float:
        """Slope dP/d(delta) = 2 E* a."""
        return 2 * self.E_star * self.a

    def pressure(self, x: ArrayLike, y: ArrayLike = 0.0) -> Array:
        """Return the pressure P/(2 pi a^2) (1 + 3 e x/a^2)/sqrt(1 - r^2/a^2), zero outside the punch.

        Parameters
        ----------
        x, y : array_like
            Coordinates from the centre, x along the offset, broadcast together.

        Returns
        -------
        numpy.ndarray
            Pressure, compression positive; infinite on the edge r = a (zero there where full contact just ends).

        Raises
        ------
        InputError
            If a coordinate is not finite.

        References
        ----------
        Johnson 1985, chapters 3 and 5.

        Examples
        --------
        >>> punch = flat(radius=1.0, modulus=1.0, force=2 * np.pi)
        >>> punch.pressure([0.0, 0.6, 2.0])
        array([1.  , 1.25, 0.  ])
        """
        xi, eta = checks.coordinates("x", x) / self.a, checks.coordinates("y", y) / self.a
        r = np.hypot(xi, eta)
        linear = 1 + 3 * self.offset / self.a * xi
        with np.errstate(divide="ignore", invalid="ignore"):
            shape = np.where((r == 1) & (linear == 0), 0.0, linear / np.sqrt(np.maximum((1 - r) * (1 + r), 0.0)))
        return np.asarray(self.mean_pressure / 2 * np.where(r <= 1, shape, 0.0))

    def displacement(self, x: ArrayLike, y: ArrayLike = 0.0) -> Array:
        """Return the normal surface displacement, inside and outside the contact; coordinates as in `pressure`.

        Returns
        -------
        numpy.ndarray
            Displacement: delta + tilt x inside; outside (2 delta/pi) asin(a/r) plus the part of the tilt.

        References
        ----------
        Johnson 1985, chapter 3; Sneddon 1965.

        Examples
        --------
        >>> punch = flat(radius=1.0, modulus=1.0, force=2.0)
        >>> punch.displacement([0.5, 2.0]).round(6)
        array([1.      , 0.333333])
        """
        xi, eta = checks.coordinates("x", x) / self.a, checks.coordinates("y", y) / self.a
        r = np.maximum(np.hypot(xi, eta), 1.0)
        s = np.sqrt((r - 1) * (r + 1))
        angle = np.arctan2(1.0, s)  # asin(a/r)
        return np.asarray(2 / np.pi * (self.approach * angle + self.tilt * self.a * xi * _tilted(s, angle)))


def _tilted(s: Array, angle: Array) -> Array:
    """Return asin(1/r) - sqrt(r^2 - 1)/r^2, which decays as 2/(3 r^3), from s = sqrt(r^2 - 1), angle = asin(1/r)."""
    # With t = 1/s it is atan t - t/(1 + t^2) = t (t^2/(1 + t^2) - (1 - atan(t)/t)); for small t the second term is a
    # third of the first.
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (1 / (1 + s**2) - arctan_defect(1 / s)) / s
    return np.where(s > 1, far, angle - s / (1 + s**2))


def flat(
    *, radius: float, modulus: float, force: float | None = None, approach: float | None = None, offset: float = 0.0
) -> FlatPunch:
    """Return the indentation by a flat circular punch, tilted if it is loaded at an offset.

    Parameters
    ----------
    radius : float
        Radius a of the punch.
    modulus : float
        E/(1 - nu^2) of the half-space under a rigid punch.
    force : float, optional
        Load P, positive.
    approach : float, optional
        Displacement of the punch's centre, positive; give this or the force.
    offset : float
        Distance e of the load from the centre along x, |e| <= a/3.

    Returns
    -------
    FlatPunch
        Force, approach and tilt; its methods give the fields.

    Raises
    ------
    InputError
        If a number is out of range, or |e| > a/3, where the punch lifts off at one side.

    References
    ----------
    Johnson 1985, sections 3.4-3.5 and 5.1.

    Examples
    --------
    >>> punch = flat(radius=3.0, modulus=1.0, force=9.0, offset=1.0)
    >>> punch.approach, punch.tilt
    (1.5, 0.25)
    """
    a, E_star = checks.positive("the radius", radius), checks.positive("the modulus", modulus)
    e = checks.finite("the offset", offset)
    # A third of the radius may be rounded to just above a/3.
    if abs(e) > a / 3 * (1 + 4e-16):
        raise InputError(
            f"Expected |offset| <= radius/3 = {a / 3}; found {offset!r}. Beyond it the punch lifts off on one side, "
            "for which there is no closed form.",
            code="punch-lifts-off",
        )
    name, value = checks.one_of(force=force, approach=approach)
    load = value if name == "force" else 2 * a * E_star * value
    return FlatPunch(
        force=load,
        approach=load / (2 * a * E_star),
        a=a,
        offset=e,
        tilt=3 * load * e / (4 * E_star * a**3),
        E_star=E_star,
    )


@dataclass(frozen=True)
class PowerPunch(RoundIndentation):
    """Punch of profile f(r) = c r^n; made by `power` or `cone`.

    Parameters
    ----------
    force : float
        Load P = 2 E* n/(n + 1) a delta. The pressure is infinite at r = 0 if the exponent n is at most 1.
    approach : float
        Displacement delta of the punch.
    a : float
        Radius of the contact.
    coefficient, exponent : float
        c and n of the profile.
    E_star : float
        Contact modulus.

    References
    ----------
    L. A. Galin, 1946; I. N. Sneddon, Int. J. Engng Sci. 3 (1965) 47.

    Examples
    --------
    >>> print(power(coefficient=0.5, exponent=2.0, modulus=3.0, approach=1.0))
    Punch of power-law profile
      force            P      4
      approach         delta  1
      contact radius   a      1
      coefficient      c      0.5
      exponent         n      2
      mean pressure    pm     1.27324
      stiffness        dP/dd  6
      contact modulus  E*     3
    >>> power(coefficient=0.5, exponent=2.0, modulus=np.pi / 2, approach=1.0).pressure([0.0, 0.6, 1.5])
    array([1. , 0.8, 0. ])
    >>> cone(angle=0.1, modulus=1.0, approach=1.0).displacement([0.0, 10.0]).round(6)
    array([1.      , 0.209751])
    """

    force: float
    approach: float
    a: float
    coefficient: float
    exponent: float
    E_star: float

    _title = "Punch of power-law profile"
    _rows = (
        "force",
        "approach",
        "a",
        ("coefficient", "c", "coefficient"),
        ("exponent", "n", "exponent"),
        "mean_pressure",
        "stiffness",
        "E_star",
    )

    def _pressure(self, r: Array) -> Array:
        """(n E* delta/(pi a)) times the integral of s^(n-1)/sqrt(s^2 - x^2) over s = x ... 1, x = r/a (Sneddon 1965).

        A hypergeometric function of 1 - x^2; for the cone arccosh(1/x).
        """
        n = self.exponent
        return np.asarray(n * self.E_star * self.approach / (np.pi * self.a) * _power_shape(r / self.a, n))

    def _displacement(self, r: Array) -> Array:
        """Delta - c r^n inside (Sneddon 1965)."""
        xi = r / self.a
        n = self.exponent
        inside = self.approach - self.coefficient * (np.minimum(xi, 1.0) * self.a) ** n
        beyond = np.maximum(xi, 1.0)
        # Integral of s^n/sqrt(x^2 - s^2) over s = 0 ... 1.
        moment = hyp2f1(0.5, (n + 1) / 2, (n + 3) / 2, 1 / beyond**2) / ((n + 1) * beyond)
        outside = 2 * self.approach / np.pi * (np.arcsin(1 / beyond) - moment)
        return np.asarray(np.where(xi <= 1, inside, outside))


def _power_shape(xi: Array, n: float) -> Array:
    """Return the integral of s^(n-1)/sqrt(s^2 - xi^2) over s = xi ... 1, zero for xi >= 1."""
    complement = np.maximum((1 - xi) * (1 + xi), 0.0)
    if n == 1:
        with np.errstate(divide="ignore"):
            return np.arccosh(np.maximum(1 / xi, 1.0))
    wide = np.sqrt(complement) * hyp2f1(1 - n / 2, 1.0, 1.5, complement)
    if n >= 3:
        return np.asarray(wide)
    # Below n = 3 the function varies as xi^(n-1) near the axis, which 1 - xi^2 does not resolve in floating point.
    # Incomplete beta functions are used there, by one step of the recurrence (n - 1) J_n = sqrt(1 - xi^2) + (n - 2)
    # xi^2 J_(n-2) if n > 1.
    power = (1 - n) / 2 if n < 1 else (3 - n) / 2
    with np.errstate(divide="ignore"):
        tip = xi ** (n - 1) / 2 * beta(0.5, power) * betaincc(power, 0.5, np.minimum(xi, 1.0) ** 2)
    close = tip if n < 1 else (np.sqrt(complement) + (n - 2) * tip) / (n - 1)
    return np.where(xi < 0.5, close, wide)


def power(
    *,
    coefficient: float,
    exponent: float,
    modulus: float,
    force: float | None = None,
    approach: float | None = None,
    a: float | None = None,
) -> PowerPunch:
    """Return the indentation by a punch of profile f(r) = c r^n.

    Parameters
    ----------
    coefficient, exponent : float
        c and n > 0 of the profile; 1/(2R) and 2 for a paraboloid.
    modulus : float
        E/(1 - nu^2) of the half-space under a rigid punch.
    force, approach, a : float, optional
        Load, displacement or contact radius, positive; exactly one.

    Returns
    -------
    PowerPunch
        Force, approach and radius; its methods give the fields.

    Raises
    ------
    InputError
        If a number is not positive, or not exactly one of the three is given.

    Notes
    -----
    delta = c sqrt(pi) Gamma(n/2 + 1)/Gamma(n/2 + 1/2) a^n, P = 2 E* n/(n + 1) a delta.

    References
    ----------
    L. A. Galin, Contact Problems, 1953; Sneddon 1965, section 6.

    Examples
    --------
    >>> round(power(coefficient=0.05, exponent=4.0, modulus=1.0, a=1.0).approach, 6)
    0.133333
    """
    c, n = checks.positive("the coefficient", coefficient), checks.positive("the exponent", exponent)
    E_star = checks.positive("the modulus", modulus)
    name, value = checks.one_of(force=force, approach=approach, a=a)
    depth = c * math.sqrt(math.pi) * math.exp(math.lgamma(n / 2 + 1) - math.lgamma(n / 2 + 0.5))  # delta / a^n
    share = 2 * E_star * n / (n + 1)  # P / (a delta)
    if name == "a":
        radius = value
    elif name == "approach":
        radius = (value / depth) ** (1 / n)
    else:
        radius = (value / (share * depth)) ** (1 / (n + 1))
    delta = value if name == "approach" else depth * radius**n
    load = value if name == "force" else share * radius * delta
    return PowerPunch(force=load, approach=delta, a=radius, coefficient=c, exponent=n, E_star=E_star)


def cone(
    *,
    angle: float,
    modulus: float,
    force: float | None = None,
    approach: float | None = None,
    a: float | None = None,
) -> PowerPunch:
    """Return the indentation by a cone, `power` with exponent 1.

    Parameters
    ----------
    angle : float
        Angle beta in radians between the cone's side and the surface, small and positive.
    modulus : float
        E/(1 - nu^2) of the half-space under a rigid cone.
    force, approach, a : float, optional
        As in `power`.

    Returns
    -------
    PowerPunch
        delta = (pi/2) a tan(beta), P = 2 E* delta^2/(pi tan(beta)), p = (E* tan(beta)/2) arccosh(a/r).

    Raises
    ------
    InputError
        If a number is out of range, or not exactly one of the three is given.

    References
    ----------
    A. E. H. Love, Quart. J. Math. 10 (1939) 161; Sneddon 1965, section 6.

    Examples
    --------
    >>> round(cone(angle=0.1, modulus=1.0, a=1.0).approach, 6)
    0.157605
    """
    side = checks.positive("the angle", angle)
    if side >= math.pi / 2:
        raise InputError(f"Expected an angle between the cone and the surface below pi/2 (radians); found {angle!r}.")
    return power(coefficient=math.tan(side), exponent=1.0, modulus=modulus, force=force, approach=approach, a=a)
