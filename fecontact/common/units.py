"""Names of units for pictures and tables."""

from __future__ import annotations

from dataclasses import dataclass

from fecontact.common.arguments import label


@dataclass(frozen=True)
class Units:
    """Names of units for labels; empty ones are left out.

    Examples
    --------
    >>> Units(stress="MPa").after("pressure", "stress")
    'pressure [MPa]'
    """

    length: str = ""
    force: str = ""
    stress: str = ""

    def __post_init__(self) -> None:
        for name in ("length", "force", "stress"):
            label(f"the unit of {name}", getattr(self, name))

    def after(self, text: str, kind: str) -> str:
        """A label with its unit in brackets."""
        unit = getattr(self, kind)
        return f"{text} [{unit}]" if unit else text

    def number(self, value: float, kind: str, power: str = "") -> str:
        """A number with its unit."""
        unit = getattr(self, kind)
        return f"{value:.4g} {unit}{power}" if unit else f"{value:.4g}"
