"""How much of a result linearised motions leave out."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LinearisationError:
    """Errors of a result due to linearised motions.

    Attributes
    ----------
    gap : float
        Largest change of a gap or of a spring's length; infinite where contact is lost or missed.
    approach : float
        Largest elastic approach of two surfaces or elongation of a spring, the scale of `gap`.
    direction : float
        Change (radians) of the direction of a contact's resultant or of a spring.
    stretch : float
        Largest stretch of a body by a linearised rotation t: t^2 / 2.
    friction : float
        Change of tractions of friction (L2), relative, as normals turn.
    deflected : float
        Shift of a contact by what its bodies deflect, which poses do not take up, over its whole shift.
    """

    gap: float
    approach: float
    direction: float
    stretch: float = 0.0
    friction: float = 0.0
    deflected: float = 0.0

    @property
    def worst(self) -> float:
        """The largest of the change of gap over the approach, of direction, and of the stretch."""
        return max(self.gap / self.approach, self.direction, self.stretch)


@dataclass(frozen=True)
class CarriedMotion:
    """What carrying the poses along has changed, against the answer to linearised motions.

    Attributes
    ----------
    motion : float
        Largest change of a rigid motion, relative to the largest motion; rotations by the size of their body.
    force : float
        Largest change of a contact's force, relative to the largest.
    rest : float
        The motion by which the poses would go on, relative to the largest: what is still linearised.
    """

    motion: float
    force: float
    rest: float
