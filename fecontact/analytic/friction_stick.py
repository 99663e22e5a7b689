"""Stick under a normal load alone, where Poisson's ratios or materials make the surfaces slide on each other."""

from __future__ import annotations

import math

from scipy.optimize import brentq
from scipy.special import ellipk, ellipkm1

from fecontact.common import checks
from fecontact.common.errors import InputError


def stick_ratio(friction: float, beta: float, *, plane: bool = False) -> float:
    """Return the ratio c/a of the radii of stick and contact under a normal load that grows from zero.

    The same for every indenter whose profile is a power of the radius (self-similar contact), flat punch included. The
    effect of the shear tractions on the pressure is left out (Goodman's approximation).

    Parameters
    ----------
    friction : float
        Coulomb's mu, zero or positive; infinite: all sticks.
    beta : float
        Dundurs' second constant, see `dundurs`; zero: no tendency to slip, all sticks.
    plane : bool
        Whether the contact is a line (plane strain) instead of a circle.

    Returns
    -------
    float
        c/a, from 0 without friction to 1; of the half-widths in the plane.

    Raises
    ------
    InputError
        If friction is negative or NaN, or beta is not within -1/2 to 1/2.

    Notes
    -----
    Circle: (a/2c) ln((a + c)/(a - c)) = (mu/|beta|) K'(c/a); plane: K'(c/a)/K(c/a) = |beta|/mu, with complete elliptic
    integrals of modulus c/a and of the complementary one.

    References
    ----------
    D. A. Spence, J. Elasticity 5 (1975) 297; K. L. Johnson, Contact Mechanics, 1985, section 5.4.

    Examples
    --------
    >>> round(stick_ratio(0.3, 2 / 7), 4), round(stick_ratio(0.3, 2 / 7, plane=True), 4)
    (0.9186, 0.7438)
    """
    mu = checks.friction(friction, infinite=True)
    if not -0.5 <= beta <= 0.5:
        raise InputError(f"Dundurs' beta must lie between -1/2 and 1/2; found {beta!r}. See fc.analytic.friction.")
    if mu == 0:
        return 1.0 if beta == 0 else 0.0
    ratio = abs(beta) / mu
    if ratio < 1e-12:
        return 1.0

    def excess(log: float) -> float:
        k2, rest = _squares(log)
        if plane:
            return math.log(float(_first_kind(rest, k2) / _first_kind(k2, rest)) / ratio)
        k = math.sqrt(k2)
        left = (math.log1p(k) - math.log(rest) / 2) / k if k > 1e-4 else 1 + k2 / 3
        return math.log(float(_first_kind(rest, k2)) / (ratio * left))

    low, high = -300.0, 300.0
    if excess(low) < 0:
        return 0.0
    return math.sqrt(_squares(brentq(excess, low, high, xtol=1e-13))[0]) if excess(high) < 0 else 1.0


def _squares(log: float) -> tuple[float, float]:
    """The squared modulus and its complement, both to full relative accuracy, by the logarithm of their ratio."""
    return 1 / (1 + math.exp(-log)), 1 / (1 + math.exp(log))


def _first_kind(m: float, complement: float) -> float:
    """Complete elliptic integral K of parameter m, without cancellation for m near 1."""
    return float(ellipkm1(complement) if complement < 0.5 else ellipk(m))
