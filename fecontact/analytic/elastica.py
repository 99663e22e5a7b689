"""Elastica: a slender cantilever under a compressive force at its tip that keeps its direction."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.optimize

from fecontact.common.arrays import Array
from fecontact.common.checks import lengths
from fecontact.common.errors import InputError

#: Points of the quadrature over the amplitude; the integrand is smooth and periodic.
POINTS = 200


@dataclass(frozen=True)
class Elastica:
    """The bent shape.

    Attributes
    ----------
    angle : float
        Of the tip's tangent, in radians, up to pi.
    x, y : float
        Place of the tip along and across the initial axis.
    moment : float
        At the clamp.
    """

    angle: float
    x: float
    y: float
    moment: float


def elastica(force: float, length: float, EI: float, EA: float = math.inf) -> Elastica:
    """Bent equilibrium of a cantilever under a compressive axial force above the critical one.

    Strains are the stretch |r'| - 1 and the turn of the tangent per initial length. With t the angle of the tangent,
    EI t'' = -P sin t (1 - P cos t / EA), once integrated EI t'^2 / 2 = P (cos t - cos a) [1 - P (cos t + cos a) / 2 EA]
    with the tip's angle a; sin(t/2) = sin(a/2) sin(phi) makes the length and the tip's place smooth integrals over phi
    from 0 to pi/2.

    Parameters
    ----------
    force, length, EI : float
    EA : float
        Rigidity of stretch; infinite unless given.

    Raises
    ------
    InputError
        If the force is not above the critical one.

    Notes
    -----
    Source: S. P. Timoshenko & J. M. Gere, Theory of Elastic Stability, section 2.7, with the stretch of the axis added
    as by A. Magnusson, M. Ristinmaa & C. Ljung, Int. J. Solids Struct. 38 (2001).

    Examples
    --------
    >>> bent = elastica(1.015 * math.pi**2 / 4, 1.0, 1.0)
    >>> round(math.degrees(bent.angle), 3)
    19.743
    """
    lengths(force=force, length=length, EI=EI)
    if not force < EA:
        raise InputError(f"EA must exceed the force {force!r}; found {EA!r}.")
    small, large = 1e-4, math.pi - 1e-6
    if _length(small, force, EI, EA)[0] >= length:
        raise InputError(
            f"A force of {force!r} is not above the critical one, {_critical(length, EI, EA):.6g}: the axis stays "
            "straight."
        )
    angle = float(scipy.optimize.brentq(lambda a: _length(a, force, EI, EA)[0] - length, small, large, xtol=1e-14))
    cosine = math.cos(angle)
    # at the clamp t = 0; the moment there is the force times its arm
    moment = math.sqrt(2 * EI * force * (1 - cosine) * (1 - force * (1 + cosine) / (2 * EA)))
    return Elastica(angle, _length(angle, force, EI, EA)[1], moment / force, moment)


def _critical(length: float, EI: float, EA: float) -> float:
    """The least force: P (1 - P / EA) = pi^2 EI / 4 L^2."""
    euler = math.pi**2 * EI / (4 * length**2)
    return euler if math.isinf(EA) else EA / 2 * (1 - math.sqrt(1 - 4 * euler / EA))


def _length(angle: float, force: float, EI: float, EA: float) -> tuple[float, float]:
    """Length, and place of the tip along the axis, of a cantilever whose tip has this angle."""
    # the trapezoidal rule over a quarter period of a smooth even function converges as for periodic ones
    phi = np.linspace(0, math.pi / 2, POINTS + 1)
    weight = np.full(POINTS + 1, math.pi / 2 / POINTS)
    weight[[0, -1]] /= 2
    k = math.sin(angle / 2)
    half = k * np.sin(phi)  # sin(t/2)
    cosine = 1 - 2 * half**2
    squeezed = 1 - force * (cosine + math.cos(angle)) / (2 * EA)
    ds: Array = weight * math.sqrt(EI / force) / np.sqrt((1 - half**2) * squeezed)
    stretch = 1 - force * cosine / EA
    return float(ds.sum()), float((ds * stretch * cosine).sum())
