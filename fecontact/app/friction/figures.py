"""Figures of a study of friction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from fecontact.bodies import FrictionPath


@dataclass(frozen=True, eq=False)
class StudyFigures:
    """The path of a study, and its figures beside those of the closed form; made by `studies.run`.

    Attributes
    ----------
    name, source : str
        Name of the study, and of the closed form.
    path : FrictionPath
    exact : RoundSlip or RollingSlip
        The closed form.
    figures : dict of str to (float, float or None)
        Figures found, each with its exact value where there is one.
    rolls : bool
        Whether a roller rolls along x, or a ball is dragged.
    """

    name: str
    source: str
    path: FrictionPath
    exact: Any
    figures: dict[str, tuple[float, float | None]]
    rolls: bool = False

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
            **self.path.as_dict(),
        }

    def __str__(self) -> str:
        last = self.path.last
        lines = [
            f"{self.name}, friction {last.friction:g}, {last.grid.shape[0]} x {last.grid.shape[1]} cells, "
            f"{len(self.path.contacts)} step(s)",
            f"beside: {self.source}",
            f"  {'':26}{'found':>14}{'exact':>14}{'error':>11}",
        ]
        for name, (found, exact) in self.figures.items():
            compared = "" if exact is None else f"{exact:>14.6g}{self.errors[name]:>+11.1e}"
            lines.append(f"  {name:26}{found:>14.6g}{compared}")
        worst = max(contact.friction_residuals.worst for contact in self.path.contacts)
        return "\n".join([*lines, f"worst residual of a step: {worst:.1e}"])
