"""Line contact of a sinusoidal surface with a flat half-space (Westergaard 1939)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import hyp2f1

from fecontact.analytic._contact import PlaneContact
from fecontact.analytic._functions import trough_gap
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError


@dataclass(frozen=True)
class SinusoidContact(PlaneContact):
    """Contact of the surface Delta cos(2 pi x/lambda) with a flat, crests at x = 0; made by `westergaard`.

    Parameters
    ----------
    mean_pressure : float
        Load per length over the wavelength.
    closing_pressure : float
        Mean pressure p* = pi E* Delta/lambda at which contact becomes complete.
    a : float
        Half-width of the contact at each crest; lambda/2 in complete contact.
    mean_gap : float
        Mean distance of the deformed surfaces over a wavelength.
    amplitude, wavelength : float
        Delta and lambda.
    E_star : float
        Contact modulus.

    References
    ----------
    H. M. Westergaard, J. Appl. Mech. 6 (1939) 49; K. L. Johnson, Contact Mechanics, 1985, section 13.2.

    Examples
    --------
    >>> print(westergaard(amplitude=0.01, wavelength=1.0, modulus=100.0, mean_pressure=np.pi / 2))
    Westergaard's sinusoid
      mean pressure     pm      1.5708
      closing pressure  p*      3.14159
      maximum pressure  p0      4.44288
      half-width        a       0.25
      area fraction     2a/lam  0.5
      mean gap          g       0.00153426
      amplitude         Delta   0.01
      wavelength        lam     1
      contact modulus   E*      100
    >>> contact = westergaard(amplitude=0.01, wavelength=1.0, modulus=100.0, mean_pressure=np.pi / 2)
    >>> contact.pressure([0.0, 0.125, 0.5, 1.0]).round(6)
    array([4.442883, 3.451618, 0.      , 4.442883])
    >>> contact.gap([0.0, 0.25, 0.5]).round(6)
    array([0.      , 0.      , 0.005328])
    """

    mean_pressure: float
    closing_pressure: float
    a: float
    mean_gap: float
    amplitude: float
    wavelength: float
    E_star: float

    _title = "Westergaard's sinusoid"
    _rows = (
        "mean_pressure",
        ("closing pressure", "p*", "closing_pressure"),
        ("maximum pressure", "p0", "max_pressure"),
        ("half-width", "a", "a"),
        ("area fraction", "2a/lam", "area_fraction"),
        ("mean gap", "g", "mean_gap"),
        ("amplitude", "Delta", "amplitude"),
        ("wavelength", "lam", "wavelength"),
        "E_star",
    )

    @property
    def complete(self) -> bool:
        """Whether the surfaces touch everywhere."""
        return self.mean_pressure >= self.closing_pressure

    @property
    def area_fraction(self) -> float:
        """2 a / lambda."""
        return 2 * self.a / self.wavelength

    @property
    def max_pressure(self) -> float:
        """Pressure at the crests."""
        if self.complete:
            return self.mean_pressure + self.closing_pressure
        return 2 * math.sqrt(self.mean_pressure * self.closing_pressure)

    def _pressure(self, x: Array) -> Array:
        """Westergaard 1939; Johnson 1985, chapter 13."""
        psi = np.pi * self._phase(x)
        if self.complete:
            return np.asarray(self.mean_pressure + self.closing_pressure * np.cos(2 * psi))
        if self.a == 0:
            return np.zeros_like(psi)
        edge = np.pi * self.a / self.wavelength
        # sin^2(edge) - sin^2(psi) = sin(edge - psi) sin(edge + psi) is accurate near the edge.
        open_part = np.maximum(np.sin(edge - psi) * np.sin(edge + psi), 0.0)
        inside = np.abs(psi) < edge
        return np.asarray(np.where(inside, 2 * self.closing_pressure * np.cos(psi) * np.sqrt(open_part), 0.0))

    def _gap(self, x: Array) -> Array:
        """The integral of the slope, which is the analytic continuation of the pressure (Johnson 1985, section 13.2).

        2 Delta (s sqrt(s^2 - s_a^2) - s_a^2 arccosh(s/s_a)) with s = |sin(pi x/lambda)|, s_a its value at x = a.
        """
        s = np.abs(np.sin(np.pi * self._phase(x)))
        if self.complete:
            return np.zeros_like(s)
        edge = math.sin(math.pi * self.a / self.wavelength)
        if edge == 0:
            return np.asarray(2 * self.amplitude * s**2)
        return np.asarray(2 * self.amplitude * edge**2 * trough_gap(s / edge))

    def _phase(self, x: Array) -> Array:
        """x/lambda reduced to the nearest crest."""
        phase = x / self.wavelength
        return np.asarray(phase - np.round(phase))


def westergaard(*, amplitude: float, wavelength: float, modulus: float, mean_pressure: float) -> SinusoidContact:
    """Return the contact of a sinusoidal surface with a flat one under a mean pressure.

    Parameters
    ----------
    amplitude, wavelength : float
        Delta and lambda of the surface Delta cos(2 pi x/lambda), positive; plane strain.
    modulus : float
        Contact modulus E*.
    mean_pressure : float
        Load per area, zero or positive.

    Returns
    -------
    SinusoidContact
        Half-width and mean gap; its methods give the fields.

    Raises
    ------
    InputError
        If a number is not positive, or the mean pressure negative.

    Notes
    -----
    sin^2(pi a/lambda) = pm/p* = beta; mean gap = Delta (1 - beta + beta log beta), written with a hypergeometric
    function in 1 - beta, accurate close to complete contact.

    References
    ----------
    Westergaard 1939; Johnson 1985, chapter 13.

    Examples
    --------
    >>> westergaard(amplitude=0.01, wavelength=1.0, modulus=100.0, mean_pressure=4.0).complete
    True
    """
    delta, lam = checks.positive("the amplitude", amplitude), checks.positive("the wavelength", wavelength)
    E_star = checks.positive("the modulus", modulus)
    pm = checks.finite("the mean pressure", mean_pressure)
    if pm < 0:
        raise InputError(f"Expected a mean pressure >= 0 (compression positive); found {mean_pressure!r}.")
    closing = math.pi * E_star * delta / lam
    closed = min(pm / closing, 1.0)
    still_open = max((closing - pm) / closing, 0.0)
    # atan2 of both parts: arcsin alone loses half the digits close to complete contact.
    a = lam / math.pi * math.atan2(math.sqrt(closed), math.sqrt(still_open))
    mean_gap = delta * still_open**2 / 2 * float(hyp2f1(1.0, 1.0, 3.0, still_open))
    return SinusoidContact(
        mean_pressure=pm,
        closing_pressure=closing,
        a=a,
        mean_gap=mean_gap,
        amplitude=delta,
        wavelength=lam,
        E_star=E_star,
    )
