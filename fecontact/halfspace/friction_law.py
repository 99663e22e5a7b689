"""Friction of a surface that rolls: one coefficient, one for each direction, or one that depends on the slip.

With coefficients along the rolling and to its left tractions lie in an ellipse and slip does the most work on them; as
in scenes, with variables in which it is a disc, see `contact.contact`.

Where friction falls with slip there may be several steady states, or none (Vollebregt & Schuttelaars, J. Sound Vib. 331
(2012) 2141).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError

FrictionOfRolling = float | tuple[float, float] | Callable[[Array], Array]

#: Slips at which a law is looked at: none, and up to the speed of rolling.
SLIPS = np.concatenate([[0.0], np.geomspace(1e-8, 1.0, 161)])

#: Step of the derivative of friction over the slip, relative to it.
STEP = 1e-6

FALLS = {
    "exponential": lambda x: 0.5**x,
    "rational": lambda x: 1 / (1 + x),
    "linear": lambda x: np.maximum(0.0, 1 - x / 2),
}


@dataclass(frozen=True)
class FallingFriction:
    """Friction that falls with the velocity of slip over the speed of rolling.

    Parameters
    ----------
    static, kinetic : float
        Coefficients without slip, and far from it.
    half : float
        Slip at which half of the fall is behind.
    law : {'exponential', 'rational', 'linear'}
        With x = slip / half, what is left of the fall: 2^-x, 1 / (1 + x), or 1 - x/2, not below zero. In CONTACT L = 4,
        3 and 2.
    across : float
        Coefficients to the left over those along the rolling, which the others are.

    Examples
    --------
    >>> FallingFriction(0.3, 0.2, half=1e-3)(1e-3)
    0.25
    """

    static: float
    kinetic: float
    half: float
    law: str = "exponential"
    across: float = 1.0

    def __post_init__(self) -> None:
        checks.unlike_friction((1.0, self.across))
        checks.among("law", self.law, tuple(FALLS))
        checks.positive("the slip at half of the fall", self.half)
        if not checks.friction(self.kinetic) <= checks.friction(self.static):
            raise InputError(f"Friction that falls has static >= kinetic; found {self.static:g}, {self.kinetic:g}.")

    def __call__(self, slip: Any) -> Any:
        """The coefficient at slips."""
        return self.kinetic + (self.static - self.kinetic) * FALLS[self.law](slip / self.half)


@dataclass(frozen=True, eq=False)
class FrictionLaw:
    """Friction along the direction of rolling, to its left, and over the slip.

    Attributes
    ----------
    mu : float
        The largest coefficient.
    ratio : (2,) array
        Coefficients along and to the left over it.
    of_slip : function of slips (nx, ny), optional
        In place of one coefficient.
    """

    mu: float
    ratio: Array
    of_slip: Callable[[Array], Array] | None = None

    @classmethod
    def of(cls, given: Any) -> FrictionLaw:
        """The law of a number, two numbers, or a function of slips.

        Raises
        ------
        InputError
        """
        if callable(given):
            values = np.asarray(given(SLIPS), dtype=float)
            if values.shape != SLIPS.shape or not (np.isfinite(values) & (values >= 0)).all():
                raise InputError(
                    "Friction as a function takes an array of slips, velocities over that of rolling, and gives as "
                    "many coefficients, finite and not negative: lambda slip: 0.2 + 0.1 * np.exp(-slip / 1e-3), say.",
                    code="friction-of-slip",
                )
            pair = np.array([1.0, getattr(given, "across", 1.0)])
            return cls(float(values.max() * pair.max()), pair / pair.max(), lambda slip: pair.max() * given(slip))
        if (several := checks.array_of(given)) is not None and several.shape == (2,):
            pair = np.array(checks.unlike_friction(given))
            return cls(float(pair.max()), pair / pair.max())
        return cls(checks.friction(given, infinite=True), np.ones(2))

    @property
    def unlike(self) -> bool:
        """Whether it differs along and across."""
        return bool(self.ratio.min() < 1)

    @property
    def far(self) -> float:
        """The coefficient at slips of the speed of rolling."""
        return self.mu if self.of_slip is None else float(self.of_slip(SLIPS)[-1])

    def coefficient(self, slip: Array) -> Array | float:
        """Largest coefficient in any direction, at slips (nx, ny)."""
        return self.mu if self.of_slip is None else np.asarray(self.of_slip(slip), dtype=float)

    def around(self, slip: Array) -> tuple[Array, Array]:
        """Coefficients at slips (nx, ny) and their derivatives by it, differences over a step of `STEP`."""
        of = self.coefficient
        step = STEP * np.maximum(slip, SLIPS[1])
        at = of(slip)
        return np.asarray(at), np.asarray((of(slip + step) - at) / step)

    @property
    def figures(self) -> float | Array:
        """What tells it from others."""
        if self.of_slip is None:
            return self.mu * self.ratio if self.unlike else self.mu
        return np.multiply.outer(self.ratio, self.of_slip(SLIPS))

    def __str__(self) -> str:
        def sides(mu: float) -> str:
            return (
                "{:.6g} along the rolling, {:.6g} to its left".format(*mu * self.ratio) if self.unlike else f"{mu:.6g}"
            )

        if self.of_slip is None:
            return f"friction: {sides(self.mu)}"
        still = float(np.max(self.coefficient(SLIPS[:1])))
        return f"friction: {sides(still)} without slip, {sides(self.far)} at that of rolling"
