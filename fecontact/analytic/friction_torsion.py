"""A ball twisted on a Hertz contact with friction: Lubkin."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipkinc, ellipkm1

from fecontact.analytic._frictional import Frictional
from fecontact.analytic._quadrature import double_exponential
from fecontact.analytic.hertz_circle import CircularContact
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError

LEAST = 1e-60
"""Radius of stick over that of the contact, below which the rotation is refused as beyond all torque."""


@dataclass(frozen=True)
class TorsionSlip(Frictional[CircularContact]):
    """Circular contact under a constant normal force and a torque about the normal that grew from zero.

    Made by `lubkin`.

    Parameters
    ----------
    contact : CircularContact
        Contact under the normal force.
    friction : float
        Coulomb's mu.
    torque : float
        Torque M about the normal, at most 3 pi mu P a/16.
    c : float
        Radius of stick.
    rotation : float
        Rotation of one body against the other about the normal, in radians.
    shear_modulus : float
        1/(1/G1 + 1/G2).

    References
    ----------
    J. L. Lubkin, J. Appl. Mech. 18 (1951) 183; K. L. Johnson, Contact Mechanics, 1985, section 7.5.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> steel = Material(E=210e3, nu=0.3)
    >>> ball = hertz.spheres(radii=(10.0, np.inf), materials=(steel, steel), force=100.0)
    >>> print(lubkin(ball, friction=0.3, torque=2.0))
    Torsion of a ball with partial slip (Lubkin)
      normal force     P      100
      friction         mu     0.3
      torque           M      2
      greatest torque  Mmax   3.29795
      contact radius   a      0.186626
      stick radius     c      0.141249
      rotation         theta  0.00208967
    """

    torque: float
    c: float
    rotation: float
    shear_modulus: float

    _title = "Torsion of a ball with partial slip (Lubkin)"
    _rows = (
        ("normal force", "P", "force"),
        ("friction", "mu", "friction"),
        ("torque", "M", "torque"),
        ("greatest torque", "Mmax", "greatest_torque"),
        ("contact radius", "a", "a"),
        ("stick radius", "c", "c"),
        ("rotation", "theta", "rotation"),
    )

    @property
    def greatest_torque(self) -> float:
        """3 pi mu P a/16, that of sliding on the whole contact."""
        return _greatest(self.contact, self.friction)

    @property
    def stiffness(self) -> float:
        """Slope dM/d(rotation), that of a disc of the radius of stick, 16 G c^3/3 (Reissner & Sagoci 1944)."""
        return 16 / 3 * self.shear_modulus * self.c**3

    def traction(self, r: ArrayLike) -> Array:
        """Return the traction round the axis, mu p in the annulus of slip, zero outside the contact.

        Parameters
        ----------
        r : array_like
            Distance from the axis, any shape.

        Returns
        -------
        numpy.ndarray
            Traction, shape of `r`.

        Raises
        ------
        InputError
            If a distance is negative or not finite.

        Notes
        -----
        In the circle of stick, with k = c/a, K' and E' of the modulus sqrt(1 - k^2), F and E of the modulus k and
        sin(phi) = sqrt((c^2 - r^2)/(a^2 - r^2))/k: (2/pi) mu p (pi/2 + (K' - E') F(phi, k) - K' E(phi, k)).

        References
        ----------
        Lubkin 1951.
        """
        pressure = self.contact.pressure(r)
        k = self.c / self.a
        if k == 0:
            return np.asarray(self.friction * pressure)
        inside = np.minimum(np.asarray(r, dtype=float), self.c) / self.c
        full, second = float(ellipkm1(k**2)), float(ellipe(1 - k**2))
        sine = np.sqrt((1 - inside) * (1 + inside) / ((1 - k * inside) * (1 + k * inside)))
        phi = np.arcsin(np.minimum(sine, 1.0))
        less = 1 + 2 / np.pi * ((full - second) * ellipkinc(phi, k**2) - full * ellipeinc(phi, k**2))
        return np.asarray(self.friction * pressure * less)


def lubkin(
    contact: CircularContact, friction: float, *, torque: float | None = None, rotation: float | None = None
) -> TorsionSlip:
    """Return the partial slip of a Hertz contact under a torque about its normal.

    Exact for any materials: torsion displaces no point along the normal.

    Parameters
    ----------
    contact : CircularContact
        From `hertz.spheres`.
    friction : float
        Coulomb's mu, positive.
    torque : float, optional
        Torque, positive, at most 3 pi mu P a/16.
    rotation : float, optional
        Rotation of one body against the other; give this or the torque. The full torque takes an infinite one.

    Returns
    -------
    TorsionSlip

    Raises
    ------
    InputError
        If not exactly one of torque and rotation is given, a value is not positive, or the contact would slide as a
        whole.

    Notes
    -----
    As the circle of stick shrinks from t to t - dt, it turns as a bonded disc by d theta, with the torque 16 G t^3/3 d
    theta; the rotation at the radius of stick c is (mu p0/(2 G)) (K' - E').

    References
    ----------
    J. L. Lubkin, J. Appl. Mech. 18 (1951) 183; J. Jaeger, Arch. Appl. Mech. 65 (1995) 478.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> ball = hertz.spheres(radii=(1.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), force=4e-3 / 3)
    >>> slight = lubkin(ball, friction=0.5, torque=1e-9)
    >>> round(slight.torque / slight.rotation / slight.stiffness, 3)
    1.0
    """
    mu = checks.positive("the friction", friction)
    shear = 1 / sum(1 / m.shear_modulus for m in contact.materials if m is not None)
    name, value = checks.one_of(torque=torque, rotation=rotation)
    unit, greatest = mu * contact.p0 / (2 * shear), _greatest(contact, mu)
    if name == "torque":
        if value >= greatest:
            raise InputError(
                f"The contact slides as a whole: the torque must be below 3 pi mu P a/16 = {greatest:g}; found "
                f"{value:g}."
            )
        share = value / greatest
        k = math.exp(brentq(lambda log: _share(math.exp(log)) - share, math.log(LEAST), 0.0, xtol=1e-14))
        return TorsionSlip(contact, mu, value, k * contact.a, unit * _turn(k), shear)
    if value >= unit * _turn(LEAST):
        raise InputError(
            f"The contact slides as a whole at a rotation of {value:g}: give the rotation at partial slip."
        )
    k = math.exp(brentq(lambda log: _turn(math.exp(log)) - value / unit, math.log(LEAST), 0.0, xtol=1e-14))
    return TorsionSlip(contact, mu, greatest * _share(k), k * contact.a, value, shear)


def _greatest(contact: CircularContact, mu: float) -> float:
    return 3 * math.pi / 16 * mu * contact.force * contact.a


def _turn(k: float) -> float:
    """K' - E' of the modulus sqrt(1 - k^2), which vanishes as pi (1 - k^2)/4 near k = 1."""
    m = (1 - k) * (1 + k)
    if m < 1e-3:
        return math.pi * m / 4 * (1 + 3 * m / 8 + 15 * m**2 / 64 + 175 * m**3 / 1024 + 2205 * m**4 / 16384)
    return float(ellipkm1(k**2) - ellipe(m))


def _share(k: float) -> float:
    """Torque over its greatest value: the integral of t^2 E(1 - t^2) from k to 1 over that from 0, 3 pi^2/64."""
    nodes, weights = double_exponential(5)
    t = k + (1 - k) * nodes
    return float((1 - k) * weights @ (t**2 * ellipe((1 - t) * (1 + t))) * 64 / (3 * math.pi**2))
