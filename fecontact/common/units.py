"""Names of units for pictures and tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fecontact.common.arguments import items, label
from fecontact.common.errors import InputError

#: Kind and power of the unit of columns of files.
COLUMNS: dict[str, tuple[str, str]] = {
    **dict.fromkeys(["x", "y", "z", "gap", "displacement", "dent", "worn"], ("length", "")),
    **dict.fromkeys(["sx", "sy", "sz", "slip_x", "slip_y"], ("length", "")),
    **dict.fromkeys(["pressure", "attraction", "traction_x", "traction_y", "tx", "ty", "tz"], ("stress", "")),
    **{"force": ("force", ""), "area": ("length", "²")},
}


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

    @classmethod
    def labels(cls, given: object, kind: str = "stress", **beside: str) -> Units:
        """Names of units as pictures and files take them: as `of`, or a text, the unit of one kind.

        Parameters
        ----------
        given : (length, force) or (length, force, stress), Units or str
        kind : {'length', 'force', 'stress'}
            What a text is the unit of.
        **beside : str
            Names of units by their kinds, where `given` has none.

        Raises
        ------
        InputError
            If it is no such names.

        Examples
        --------
        >>> Units.labels("MPa", length="mm")
        Units(length='mm', force='', stress='MPa')
        >>> Units.labels(("um", "mN", "kPa"), "length").length
        'um'
        """
        names = cls(**{kind: given}) if isinstance(given, str) else cls.of(given)
        return names.with_defaults(cls(**beside))

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

    def heads(self, names: Sequence[str]) -> list[str]:
        """Heads of columns of a file, with their units where these are known.

        Examples
        --------
        >>> Units("mm", "N", "MPa").heads(["contact", "x", "area", "pressure"])
        ['contact', 'x [mm]', 'area [mm²]', 'pressure [MPa]']
        """
        units = [self.suffix(*COLUMNS[name]).strip() if name in COLUMNS else "" for name in names]
        return [f"{name} [{unit}]" if unit else name for name, unit in zip(names, units, strict=True)]


#: What doors take for names of units.
UnitNames = str | Sequence[str] | Units


def refuse_units(suffix: str, units: UnitNames) -> None:
    """Refuse names of units for a file that has no place for them.

    Raises
    ------
    InputError
        If there are any.
    """
    if units:
        raise InputError(
            f"A {suffix} file has no place for names of units; leave units= out.", code="no-place-for-units"
        )
