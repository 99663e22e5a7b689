"""What closed forms of contacts with friction have in common: the contact under the normal force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from fecontact.analytic._contact import Tabulated
from fecontact.analytic.hertz_circle import CircularContact
from fecontact.analytic.hertz_line import LineContact

C = TypeVar("C", CircularContact, LineContact)


@dataclass(frozen=True)
class Frictional(Tabulated, Generic[C]):
    """A contact with friction; a line contact is taken per length.

    Parameters
    ----------
    contact : CircularContact or LineContact
        Contact under the normal force.
    friction : float
        Coulomb's mu.
    """

    contact: C
    friction: float

    @property
    def force(self) -> float:
        """Normal force."""
        return self.contact.force

    @property
    def a(self) -> float:
        """Radius or half-width of the contact."""
        return self.contact.a
