"""Rigid, frictionless, flat circular punch on a half-space, pressed centrally or tilted."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fecontact.analytic._contact import Tabulated
from fecontact.analytic._functions import arctan_defect
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError


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
            "for which there is no closed form."
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
