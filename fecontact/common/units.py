"""Names of units for pictures and tables."""

from __future__ import annotations

from dataclasses import dataclass

from fecontact.common.arguments import items, label
from fecontact.common.errors import InputError


@dataclass(frozen=True)
class Units:
    """Names of units for labels; empty ones are left out.

    Examples
    --------
    >>> Units(stress="MPa").axis_label("pressure", "stress")
    'pressure [MPa]'
    """

    length: str = ""
    force: str = ""
    stress: str = ""

    def __post_init__(self) -> None:
        for name in ("length", "force", "stress"):
            label(f"the unit of {name}", getattr(self, name))

    @classmethod
    def of(cls, given: object) -> Units:
        """Names of units as users give them: of length, of force and, unless force over length squared, of stress.

        Raises
        ------
        InputError
            If it is no such names.

        Examples
        --------
        >>> Units.of(("mm", "N")).stress, Units.of(("mm", "N", "MPa")).stress, Units.of(()).stress
        ('N/mm²', 'MPa', '')
        """
        if isinstance(given, Units):
            return given
        names = items("units", given, "names of the units of length, force and stress")
        if len(names) > 3:
            raise InputError(f"Units are names of length, force and stress; found {len(names)} of them.", code="units")
        length, force, stress = [*names, "", "", ""][:3]
        own = cls(length, force, stress)
        return own if stress or not (length and force) else cls(length, force, f"{force}/{length}²")

    def with_defaults(self, others: Units) -> Units:
        """The names given here, and of others where there are none."""
        return Units(self.length or others.length, self.force or others.force, self.stress or others.stress)

    def axis_label(self, text: str, kind: str) -> str:
        """A label with its unit in brackets."""
        unit = getattr(self, kind)
        return f"{text} [{unit}]" if unit else text

    def suffix(self, kind: str, power: str = "") -> str:
        """A unit behind numbers, after a space."""
        moment = f"{self.force}·{self.length}" if self.force and self.length else ""
        unit = moment if kind == "moment" else getattr(self, kind)
        return f" {unit}{power}" if unit else ""

    def number(self, value: float, kind: str, power: str = "") -> str:
        """A number with its unit."""
        return f"{value:.4g}{self.suffix(kind, power)}"
