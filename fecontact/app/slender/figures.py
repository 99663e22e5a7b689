"""Figures of a problem of slender beams."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fecontact.common.arrays import Array


@dataclass(frozen=True, eq=False)
class SlenderFigures:
    """Figures of a problem beside known ones, and the shapes on the way.

    Attributes
    ----------
    name, unit : str
    n : int
        Elements.
    rows : tuple of (str, float, float)
        Case, figure found, known figure.
    remarks : dict of str to float
    shapes : tuple of (str, (m, 3) array)
        Points of the axis, to draw.
    seconds : float
    """

    name: str
    unit: str
    n: int
    rows: tuple[tuple[str, float, float], ...]
    remarks: dict[str, float]
    shapes: tuple[tuple[str, Array], ...]
    seconds: float

    @property
    def error(self) -> float:
        """Largest difference from a known figure."""
        return max(abs(found - known) for _, found, known in self.rows)

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts."""
        cases = [{"case": case, "found": found, "known": known} for case, found, known in self.rows]
        head = {"problem": self.name, "elements": self.n, "unit": self.unit, "seconds": self.seconds}
        return {**head, "cases": cases, "error": self.error, **self.remarks}

    def __str__(self) -> str:
        lines = [f"{self.name}, {self.n} elements [{self.unit}]", f"  {'':14}{'found':>12}{'known':>12}{'error':>11}"]
        lines += [f"  {case:14}{found:>12.6g}{known:>12.6g}{found - known:>+11.1e}" for case, found, known in self.rows]
        lines += [f"  {name}: {value:.3g}" for name, value in self.remarks.items()]
        return "\n".join([*lines, f"  {self.seconds:.2f} s"])
