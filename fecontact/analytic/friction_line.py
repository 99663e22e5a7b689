"""Partial slip of cylinders in Hertz's line contact: a tangential force (Cattaneo) and tractive rolling (Carter)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fecontact.analytic._frictional import Frictional
from fecontact.analytic._functions import trough_gap
from fecontact.analytic.hertz_line import LineContact
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError


@dataclass(frozen=True)
class _PartialSlip(Frictional[LineContact]):
    """A line contact with a stick zone of half-width `c`; traction on the second body along the force on the first.

    Parameters
    ----------
    contact : LineContact
        Contact under the normal force.
    friction : float
        Coulomb's mu.
    tangential : float
        Tangential force Q' per length, from zero to mu P'.
    c : float
        Half-width of the zone of stick, a (1 - Q'/(mu P'))^(1/2).
    """

    tangential: float
    c: float

    @property
    def centre(self) -> float:
        """Coordinate of the middle of the zone of stick."""
        return 0.0

    def traction(self, x: ArrayLike) -> Array:
        """Return the tangential traction along the force, zero outside the contact.

        Parameters
        ----------
        x : array_like
            Coordinate across the line of contact, from its centre, any sign and shape.

        Returns
        -------
        numpy.ndarray
            mu p0 (sqrt(1 - x^2/a^2) - (c/a) sqrt(1 - (x - d)^2/c^2)), d the centre of stick; shape of `x`.

        Raises
        ------
        InputError
            If a coordinate is not finite.

        References
        ----------
        K. L. Johnson, Contact Mechanics, 1985, sections 7.2(a) and 8.3.
        """
        offset = checks.coordinates("x", x) - self.centre
        inner = np.sqrt(np.maximum((self.c - offset) * (self.c + offset), 0.0)) / self.a
        return np.asarray(self.friction * (self.contact.pressure(x) - self.contact.p0 * inner))


class LineSlip(_PartialSlip):
    """Line contact under a constant normal force and a tangential force that grew from zero; made by `cattaneo`.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> steel = Material(E=210e3, nu=0.3)
    >>> roller = hertz.line(radii=(10.0, np.inf), materials=(steel, steel), force=1000.0)
    >>> print(cattaneo(roller, friction=0.3, tangential=100.0))
    Partial slip over a line (Cattaneo)
      normal force per length      P'  1000
      friction                     mu  0.3
      tangential force per length  Q'  100
      half-width                   a   0.332186
      half-width of stick          c   0.271229
    """

    _title = "Partial slip over a line (Cattaneo)"
    _rows = (
        ("normal force per length", "P'", "force"),
        ("friction", "mu", "friction"),
        ("tangential force per length", "Q'", "tangential"),
        ("half-width", "a", "a"),
        ("half-width of stick", "c", "c"),
    )

    def slip(self, x: ArrayLike) -> Array:
        """Return the slip: zero where it sticks, opposite to the traction where it slips, NaN outside the contact.

        Notes
        -----
        mu times the gap of a Hertz contact of the half-width of stick, for pressures and tangential tractions displace
        a half-plane along themselves alike.
        """
        at = np.abs(checks.coordinates("x", x))
        c = max(self.c, 1e-12 * self.a)
        slip = 0.0 - self.friction * c * (c / self.contact.R) / 2 * trough_gap(at / c)
        return np.asarray(np.where(at <= self.a, slip, np.nan))


class RollingSlip(_PartialSlip):
    """A cylinder that rolls steadily along +x under a tangential force; made by `carter`.

    The zone of stick is at the leading edge, x = a.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> steel = Material(E=210e3, nu=0.3)
    >>> roller = hertz.line(radii=(10.0, np.inf), materials=(steel, steel), force=1000.0)
    >>> print(carter(roller, friction=0.3, tangential=100.0))
    Tractive rolling (Carter)
      normal force per length      P'  1000
      friction                     mu  0.3
      tangential force per length  Q'  100
      half-width                   a   0.332186
      half-width of stick          c   0.271229
      creepage                     xi  0.00182872
    """

    _title = "Tractive rolling (Carter)"
    _rows = (*LineSlip._rows, ("creepage", "xi", "creepage"))

    @property
    def centre(self) -> float:
        """Coordinate of the middle of the zone of stick, a - c."""
        return self.a - self.c

    @property
    def creepage(self) -> float:
        """Difference of the bodies' speeds over the speed of rolling, mu (a - c)/R; Johnson 1985, section 8.3."""
        return self.friction * (self.a - self.c) / self.contact.R

    def slip_rate(self, x: ArrayLike) -> Array:
        """Return the slip per distance rolled: zero where it sticks, opposite to the traction, NaN outside.

        Notes
        -----
        The creepage less the difference of the tangential strains: -mu sqrt((x - d)^2 - c^2)/R behind the zone of
        stick.

        References
        ----------
        F. W. Carter, Proc. R. Soc. A 112 (1926) 151; Johnson 1985, section 8.3.
        """
        at = checks.coordinates("x", x)
        behind = np.maximum(self.centre - at, 0.0)
        root = np.sqrt(np.maximum((behind - self.c) * (behind + self.c), 0.0))
        rate = 0.0 - self.friction * root / self.contact.R
        return np.asarray(np.where(np.abs(at) <= self.a, rate, np.nan))


def cattaneo(contact: LineContact, friction: float, *, tangential: float) -> LineSlip:
    """Return the partial slip of a line contact under a tangential force across the line.

    Exact where normal and tangential problem are not coupled: equal bodies, or Dundurs' beta = 0.

    Parameters
    ----------
    contact : LineContact
        From `hertz.line`.
    friction : float
        Coulomb's mu, positive.
    tangential : float
        Tangential force Q' per length, positive, at most mu P'.

    Returns
    -------
    LineSlip

    Raises
    ------
    InputError
        If a value is not positive, or the contact slides as a whole.

    References
    ----------
    C. Cattaneo, Rend. Accad. Lincei 27 (1938) 342; K. L. Johnson, Contact Mechanics, 1985, section 7.2(a).

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> roller = hertz.line(radii=(1.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), force=1e-4)
    >>> half = cattaneo(roller, friction=0.4, tangential=0.75 * 0.4 * roller.force)
    >>> round(half.c / half.a, 12), half.slip([0.0, 2 * half.c]) < 0
    (0.5, array([False,  True]))
    """
    return LineSlip(contact, *_stick(contact, friction, tangential))


def carter(contact: LineContact, friction: float, *, tangential: float) -> RollingSlip:
    """Return the steady rolling of cylinders under a tangential force; arguments as in `cattaneo`.

    References
    ----------
    F. W. Carter, Proc. R. Soc. A 112 (1926) 151; K. L. Johnson, Contact Mechanics, 1985, section 8.3.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> roller = hertz.line(radii=(1.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), force=1e-4)
    >>> wheel = carter(roller, friction=0.4, tangential=0.75 * 0.4 * roller.force)
    >>> round(wheel.creepage / (0.4 * wheel.a), 12)
    0.5
    """
    return RollingSlip(contact, *_stick(contact, friction, tangential))


def _stick(contact: LineContact, friction: float, tangential: float) -> tuple[float, float, float]:
    """Checked friction and force, and the half-width of stick."""
    mu = checks.positive("the friction", friction)
    force = checks.positive("the tangential force", tangential)
    limit = mu * contact.force
    if force > limit * (1 + 1e-14):
        raise InputError(
            f"The contact slides as a whole: the tangential force can be at most mu P' = {limit:g}; found {force:g}."
        )
    return mu, force, contact.a * math.sqrt(max(1 - force / limit, 0.0))
