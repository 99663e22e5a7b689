"""Adhesive contact of balls and waves: JKR, DMT, Maugis' transition between them, and Johnson's wave.

The energy w is per area of both surfaces, forces are compressive; a rigid ball of radius R (or two, 1/R = 1/R1 + 1/R2)
presses on a half-space of modulus E*.

References
----------
D. Maugis, J. Colloid Interface Sci. 150 (1992) 243; K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. A 324
(1971) 301; B. V. Derjaguin, V. M. Muller, Y. P. Toporov, J. Colloid Interface Sci. 53 (1975) 314; K. L. Johnson, Int.
J. Solids Struct. 32 (1995) 423.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common import checks
from fecontact.common.arrays import Array

#: Ratios of the zone's radius to that of the contact, less one, among which the pull-off is looked for.
RATIOS = np.logspace(-6, 6, 120_001)


class AdhesiveBall(NamedTuple):
    """States of a ball's contact, arrays (n,): force, approach, radius of the contact and of the adhesive zone."""

    force: Array
    approach: Array
    a: Array
    c: Array

    @property
    def pull_off(self) -> float:
        """Largest tensile force."""
        return -float(self.force.min())


def transition(radius: float, modulus: float, work: float, range: float) -> float:
    """Maugis' lambda = 2 s0 (R/(pi w K^2))^(1/3) with K = 4 E*/3: DMT below 0.1, JKR above 5.

    Examples
    --------
    >>> round(transition(radius=1.0, modulus=1.0, work=1e-5, range=2e-4), 3)
    2.616
    """
    R, K, w, reach = _checked(radius, modulus, work, range)
    return 2 * (w / reach) * (R / (math.pi * w * K * K)) ** (1 / 3)


def maugis(radius: float, modulus: float, work: float, range: float, ratios: ArrayLike = 1 + RATIOS) -> AdhesiveBall:
    """A ball whose surfaces attract each other by w/range up to a gap of `range`, at ratios c/a above one.

    The states are in the order of the ratios, which fall as the ball is pressed in; some are not stable.

    Examples
    --------
    Between JKR, 3/2 pi w R, and DMT, 2 pi w R:

    >>> near, far = (maugis(1.0, 1.0, 1e-5, reach).pull_off / (np.pi * 1e-5) for reach in (2e-5, 1.0))
    >>> round(near, 3), round(far, 3)
    (1.5, 2.0)
    """
    R, K, w, _ = _checked(radius, modulus, work, range)
    lam = transition(radius, modulus, work, range)
    m = checks.number_array("ratios of the radii", ratios)
    root = np.sqrt(m * m - 1)
    turn = np.arctan(root)
    square, linear = lam / 2 * (root + (m * m - 2) * turn), 4 / 3 * lam**2 * (root * turn - m + 1)
    a = 2 / (linear + np.sqrt(linear**2 + 4 * square))
    unit = (math.pi * w * R * R / K) ** (1 / 3)
    force = math.pi * w * R * (a**3 - lam * a**2 * (root + m * m * turn))
    return AdhesiveBall(force, unit**2 / R * (a**2 - 4 / 3 * lam * a * root), unit * a, unit * a * m)


def jkr(radius: float, modulus: float, work: float, a: ArrayLike) -> AdhesiveBall:
    """A ball with attraction of no range, at radii of its contact.

    Examples
    --------
    >>> ball = jkr(1.0, 1.0, 1e-5, np.linspace(0.001, 0.1, 10_000))
    >>> round(ball.pull_off / (np.pi * 1e-5), 4)
    1.5
    """
    R, K, w, _ = _checked(radius, modulus, work, 1.0)
    r = checks.number_array("radii of the contact", a)
    edge = np.sqrt(6 * math.pi * w * K * r**3)
    return AdhesiveBall(K * r**3 / R - edge, r**2 / R - 2 / 3 * edge / (K * r), r, r)


def wave(amplitude: float, wavelength: float, modulus: float, work: float, half_width: ArrayLike) -> Array:
    """Mean pressure (n,) on the wave Delta cos(2 pi x/lambda) with attraction of no range, at half-widths of contact.

    Johnson's p* sin^2(pi a/lambda) - (2 E* w/lambda tan(pi a/lambda))^(1/2), with p* = pi E* Delta/lambda; where it
    falls with the half-width, the state is not stable under a given force.

    Examples
    --------
    >>> wave(0.01, 1.0, 1.0, 0.0, np.array([0.25])).round(6)
    array([0.015708])
    """
    for name, value in (("amplitude", amplitude), ("wavelength", wavelength), ("modulus", modulus)):
        checks.positive(name, value)
    turn = math.pi * checks.number_array("half-widths", half_width) / wavelength
    closing = math.pi * modulus * amplitude / wavelength
    return np.asarray(closing * np.sin(turn) ** 2 - np.sqrt(2 * modulus * work / wavelength * np.tan(turn)))


def _checked(radius: float, modulus: float, work: float, range: float) -> tuple[float, float, float, float]:
    """Radius, K = 4 E*/3, work and range."""
    named = {"radius": radius, "modulus": modulus, "work of adhesion": work, "range of adhesion": range}
    R, E, w, reach = (checks.positive(f"the {name}", value) for name, value in named.items())
    return R, 4 / 3 * E, w, reach
