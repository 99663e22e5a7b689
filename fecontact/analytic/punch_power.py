"""Rigid frictionless punches with a power-law profile on a half-space: cone, paraboloid and others."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import beta, betaincc, hyp2f1

from fecontact.analytic._contact import RoundIndentation
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError


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
