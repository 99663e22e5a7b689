"""The way of a ligament: straight strands between points, and an arc round a cylinder.

A taut, frictionless ligament follows the shortest way. Round a cylinder that is a helix, which begins and ends on the
tangents: a cylinder and its tangent planes are developable, so that the way is a straight line where they are unrolled.
With the distances r1, r2 of both ends from the axis, the angle a between them and the distance z along the axis, the
way round a cylinder of radius R has the length

    sqrt(c^2 + z^2),   c = sqrt(r1^2 - R^2) + R b + sqrt(r2^2 - R^2),   b = a - arccos(R / r1) - arccos(R / r2),

on the side where a is at most pi, and it touches the cylinder where b > 0 (B. A. Garner & M. G. Pandy, The
obstacle-set method for representing muscle paths in musculoskeletal models, Comput. Methods Biomech. Biomed. Eng. 3
(2000), 1). As the way is the shortest, small motions change its length as if it kept the points of its material on the
cylinder: by the strands alone, whose points of tangency move with the body that carries the cylinder.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import ROUNDING, Array
from fecontact.common.checks import check_magnitude, positive, vector
from fecontact.common.errors import InputError

#: Angle up to which ends opposite each other leave the side of the way to rounding.
OPPOSITE = 1e-9


@dataclass(frozen=True)
class WrapCylinder:
    """A cylinder round which a ligament is led, in the axes of the body that carries it.

    Parameters
    ----------
    centre, axis : (3,)
        A point of its axis, the middle of its length; a direction along it, of any length.
    radius : float
    length : float, optional
        Unlimited by default.

    Raises
    ------
    InputError

    Examples
    --------
    >>> WrapCylinder((0.0, 0.0, 0.0), (0.0, 0.0, 2.0), radius=5.0).radius
    5.0
    """

    centre: ArrayLike
    axis: ArrayLike
    radius: float
    length: float = np.inf

    def __post_init__(self) -> None:
        vector("the centre of a wrapping cylinder", self.centre)
        if not vector("the axis of a wrapping cylinder", self.axis).any():
            raise InputError("The axis of a wrapping cylinder is zero: it has no direction.", code="no-axis")
        what = "the radius of a wrapping cylinder"
        check_magnitude(what, positive(what, self.radius))
        if np.isnan(self.length) or self.length <= 0:
            raise InputError("The length of a wrapping cylinder is positive; it may be infinite.", code="not-positive")

    def touched(self, start: Array, end: Array) -> tuple[Array, float] | None:
        """Both points of tangency (2, 3) of the way from one point (3,) to another, and the arc's length.

        None where the straight way passes the cylinder by.

        Raises
        ------
        InputError
            If a point is inside, the way leaves the cylinder at its ends, or two ways are equally long.
        """
        centre, axis, R = np.asarray(self.centre, dtype=float), np.asarray(self.axis, dtype=float), float(self.radius)
        axis = axis / np.linalg.norm(axis)
        offsets = np.stack([start, end]) - centre
        along = offsets @ axis
        across = offsets - along[:, None] * axis
        r = np.linalg.norm(across, axis=1)
        if (r < R * (1 - ROUNDING)).any():
            raise InputError(
                f"A point of a ligament is inside the cylinder that it wraps round, {r.min():.6g} from its axis; the "
                f"radius is {R:.6g}.",
                code="inside-cylinder",
            )
        r = np.maximum(r, R)
        one, other = across / r[:, None]
        sideways = np.cross(axis, one)
        turn = np.arctan2(float(other @ sideways), float(other @ one))
        sense = 1.0 if turn >= 0 else -1.0
        lead, trail = np.arccos(R / r)
        arc = abs(turn) - lead - trail
        if arc <= 0:
            return None
        if np.pi - abs(turn) <= OPPOSITE:
            raise InputError(
                "The ends of a ligament are on opposite sides of the axis of the cylinder that it wraps round: both "
                "ways are equally long. Move an end, or lead the ligament through points (via=).",
                code="two-ways",
            )
        tangents = np.sqrt(r**2 - R**2)
        places = np.array([tangents[0], tangents[0] + R * arc])
        slope = (along[1] - along[0]) / (places[1] + tangents[1])
        angles = sense * np.array([lead, lead + arc])
        round_it = np.cos(angles)[:, None] * one + np.sin(angles)[:, None] * sideways
        heights = along[0] + slope * places
        if np.abs(heights).max() > self.length / 2:
            raise InputError(
                f"A ligament wraps round a cylinder {np.abs(heights).max():.6g} from its middle, beyond its length "
                f"{self.length:.6g}. Give a longer one.",
                code="beyond-cylinder",
            )
        return centre + R * round_it + heights[:, None] * axis, float(R * arc * np.hypot(1.0, slope))


class Strand(NamedTuple):
    """A straight part of a ligament.

    Attributes
    ----------
    carriers : (int, int)
        Numbers of the bodies that carry its ends, see `Spring.carriers`.
    own : pair of (3,) arrays
        Its ends in the axes of these.
    ends : (2, 3) array
        In the world.
    """

    carriers: tuple[int, int]
    own: tuple[Array, Array]
    ends: Array

    @property
    def length(self) -> float:
        """Distance of its ends."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))

    @property
    def direction(self) -> Array:
        """Unit vector (3,) from its start to its end."""
        return (self.ends[1] - self.ends[0]) / self.length
