"""Figures of a study of friction beside those of a closed form."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from fecontact.bodies import FrictionPath


@dataclass(frozen=True, eq=False)
class StudyFigures:
    """Figures of a study.

    Attributes
    ----------
    name, source : str
        Name of the study, and of the closed form.
    figures : dict of str to (float, float or None)
        Figures found, each with its exact value where there is one.
    setting : str
        What was solved, in a few words.
    worst_residual : float
        Largest residual of all steps.
    """

    name: str
    source: str
    figures: dict[str, tuple[float, float | None]]
    setting: str
    worst_residual: float

    @cached_property
    def errors(self) -> dict[str, float]:
        """Relative errors; figures whose exact value is zero are their own error."""
        return {
            name: found / exact - 1 if exact else found
            for name, (found, exact) in self.figures.items()
            if exact is not None
        }

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts."""
        return {
            "study": self.name,
            "source": self.source,
            "figures": {name: found for name, (found, _) in self.figures.items()},
            "exact": {name: exact for name, (_, exact) in self.figures.items() if exact is not None},
            "errors": self.errors,
        }

    def __str__(self) -> str:
        lines = [
            f"{self.name}, {self.setting}",
            f"beside: {self.source}",
            f"  {'':32}{'found':>14}{'exact':>14}{'error':>11}",
        ]
        for name, (found, exact) in self.figures.items():
            compared = "" if exact is None else f"{exact:>14.6g}{self.errors[name]:>+11.1e}"
            lines.append(f"  {name:32}{found:>14.6g}{compared}")
        return "\n".join([*lines, f"worst residual of a step: {self.worst_residual:.1e}"])


@dataclass(frozen=True, eq=False)
class HalfSpaceFigures(StudyFigures):
    """Figures of a ball or a roller on a half-space, and its path.

    Attributes
    ----------
    path : FrictionPath
    exact : RoundSlip or RollingSlip
        The closed form.
    rolls : bool
        Whether a roller rolls along x, or a ball is dragged.
    """

    path: FrictionPath
    exact: Any
    rolls: bool = False

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts, with a row per step."""
        return {**super().as_dict(), **self.path.as_dict()}
