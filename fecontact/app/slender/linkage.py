"""A four-bar linkage of rigid bars: exact kinematics, and its motion under a constant moment on the crank.

The crank turns about the origin, the follower about (ground, 0); the coupler joins their ends. With the crank's angle a
all velocities are proportional to a', so that the energy J(a) a'^2 / 2 + V(a) - M a is constant and the time follows by
quadrature.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.integrate

from fecontact.common.arrays import Array
from fecontact.common.checks import lengths
from fecontact.common.errors import InputError

#: Points of the quadrature of the time.
POINTS = 40001


@dataclass(frozen=True)
class Linkage:
    """Uniform bars.

    Parameters
    ----------
    crank, coupler, follower, ground : float
        Lengths, by which the crank can go round: shortest and longest together below the others (Grashof).
    mass : float
        Per length.

    Raises
    ------
    InputError
        If the crank cannot go round.

    Examples
    --------
    >>> coupler, follower = Linkage(1.0, 4.0, 3.0, 3.5, 1.0).angles(np.array([np.pi / 2]))
    >>> crank_end, coupler_end = 1j, 1j + 4 * np.exp(1j * coupler)
    >>> bool(abs(coupler_end - 3.5 - 3 * np.exp(1j * follower)) < 1e-12)
    True
    """

    crank: float
    coupler: float
    follower: float
    ground: float
    mass: float

    def __post_init__(self) -> None:
        sizes = {k: getattr(self, k) for k in ("crank", "coupler", "follower", "ground")}
        lengths(**sizes, mass=self.mass)
        ordered = sorted(sizes.values())
        if not (ordered[0] + ordered[3] < ordered[1] + ordered[2] and ordered[0] in (self.crank, self.ground)):
            raise InputError(
                f"The crank cannot go round with the lengths {sizes}: shortest and longest together must be below the "
                "others, and the shortest the crank or the ground."
            )

    def angles(self, crank: Array) -> tuple[Array, Array]:
        """Angles of the coupler and the follower, radians, by those of the crank (n,); the coupler's end is above.

        By the triangle of the crank's end, the follower's pin and the coupler's end.
        """
        to_pin = self.ground - self.crank * np.exp(1j * crank)
        size = np.abs(to_pin)
        cosine = (self.coupler**2 + size**2 - self.follower**2) / (2 * self.coupler * size)
        coupler = np.angle(to_pin) + np.arccos(np.clip(cosine, -1.0, 1.0))
        return coupler, np.angle(self.coupler * np.exp(1j * coupler) - to_pin)

    def rates(self, crank: Array) -> tuple[Array, Array]:
        """Angular velocities of the coupler and the follower over that of the crank.

        From the rate of the closed loop, along and across the other bar.
        """
        coupler, follower = self.angles(crank)
        turn = np.sin(coupler - follower)
        return (
            self.crank * np.sin(follower - crank) / (self.coupler * turn),
            self.crank * np.sin(coupler - crank) / (self.follower * turn),
        )

    def inertia(self, crank: Array) -> Array:
        """Moment of inertia felt by the crank (n,): twice the kinetic energy over the square of its rate."""
        coupler, _ = self.angles(crank)
        by_coupler, by_follower = self.rates(crank)
        middle = self.crank * np.exp(1j * crank) + self.coupler / 2 * by_coupler * np.exp(1j * coupler)
        turning = self.crank**3 + self.follower**3 * by_follower**2 + self.coupler**3 * by_coupler**2 / 4
        return np.asarray(self.mass * (self.coupler * np.abs(middle) ** 2 + turning / 3))

    def height(self, crank: Array) -> Array:
        """Sum of mass times height of the bars (n,); gravity times it is the potential."""
        coupler, follower = self.angles(crank)
        end = self.crank * np.sin(crank)
        each = self.crank * end / 2 + self.coupler * (end + self.coupler / 2 * np.sin(coupler))
        return np.asarray(self.mass * (each + self.follower**2 / 2 * np.sin(follower)))

    def driven(self, start: float, turns: float, moment: float, gravity: float) -> tuple[Array, Array]:
        """Times (n,) and angles (n,) of the crank, from rest, until it has gone round `turns` times.

        Raises
        ------
        InputError
            If the moment does not lift the bars.
        """
        # angle = start + s^2: from rest it grows with the square of the time, so that ds / dt is smooth
        s = np.linspace(0.0, np.sqrt(2 * np.pi * turns), POINTS)
        angle = start + s**2
        work = moment * s**2 - gravity * (self.height(angle) - self.height(angle[:1]))
        if not (work[1:] > 0).all():
            raise InputError(f"A moment of {moment!r} does not turn the crank against gravity; give a larger one.")
        rate = np.empty(POINTS)
        rate[1:] = np.sqrt(2 * work[1:] / self.inertia(angle[1:])) / (2 * s[1:])
        rate[0] = 2 * rate[1] - rate[2]
        return scipy.integrate.cumulative_simpson(1 / rate, x=s, initial=0), angle
