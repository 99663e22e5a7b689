"""A belt round a drum: tension by Euler and Eytelwein."""

from __future__ import annotations

import math

from fecontact.common import checks
from fecontact.common.errors import InputError


def belt_tension(slack: float, friction: float, angle: float) -> float:
    """Return the tension at the tight end of a belt that slips on the whole angle of wrap, slack exp(mu angle).

    Parameters
    ----------
    slack : float
        Tension at the slack end, positive.
    friction : float
        Coulomb's mu, zero or positive.
    angle : float
        Angle of wrap in radians, zero or positive; may exceed 2 pi.

    Returns
    -------
    float
        Tension at the other end: the largest that friction holds.

    Raises
    ------
    InputError
        If the tension is not positive, or friction or angle is negative or not finite.

    References
    ----------
    L. Euler, Mem. Acad. Sci. Berlin 18 (1769) 265; J. A. Eytelwein, Handbuch der Statik fester Koerper, 1808.

    Examples
    --------
    >>> round(belt_tension(10.0, 0.3, math.pi), 4)
    25.6633
    """
    mu, wrap = checks.friction(friction), float(checks.depths("angle", angle))
    return checks.positive("the tension", slack) * math.exp(mu * wrap)


def belt_slip_angle(slack: float, tight: float, friction: float) -> float:
    """Return the angle on which a belt slips on a drum that it drives or brakes, ln(tight/slack)/mu.

    On the rest of the angle of wrap, towards the end where the belt runs on, it sticks.

    Parameters
    ----------
    slack, tight : float
        Tensions at the ends, positive, the tight one not smaller.
    friction : float
        Coulomb's mu, positive.

    Raises
    ------
    InputError
        If a value is not positive, or the tight end is the slacker one.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, section 8.1 (creep of a belt).

    Examples
    --------
    >>> round(belt_slip_angle(10.0, belt_tension(10.0, 0.3, 2.0), 0.3), 12)
    2.0
    """
    checks.lengths(slack=slack, tight=tight, friction=friction)
    if tight < slack:
        raise InputError(f"Expected tight >= slack; found tight={tight!r} and slack={slack!r}. Exchange them.")
    return math.log(tight / slack) / friction
