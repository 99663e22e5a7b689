"""Convergence of an adaptive solution: one step for each division of the meshes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from fecontact.common.compact_repr import compact_repr
from fecontact.common.error_estimate import percent
from fecontact.common.table import Column, Table

#: Figures of which an accuracy can be asked by name; an accuracy without a name is that of the pressure.
FIGURES = ("pressure", "peak", "area", "force", "approach", "tilt")


def asked(accuracy: float | Mapping[str, float]) -> dict[str, float]:
    """Accuracies by the names of figures.

    Examples
    --------
    >>> asked(0.02)
    {'pressure': 0.02}
    """
    return dict(accuracy) if isinstance(accuracy, Mapping) else {"pressure": accuracy}


@dataclass(frozen=True)
class Step:
    """One solution of the sequence.

    Attributes
    ----------
    n_dofs, n_hanging, n_candidates : int
        Unknowns of all elastic bodies, hanging nodes among them, and candidate contact points.
    pressure, traction, peak : float
        Estimated relative errors, the largest of all contacts: of the pressure in L2, of the tractions of friction
        (None without friction), and of the largest pressure.
    max_pressure, area : float
        Largest pressure, and area of all contacts.
    seconds : float
        Time from the start to the end of this step.
    area_error : float
        Estimated relative error of the area, the largest of all contacts.
    force, approach, tilt : float or None
        Estimated relative errors of forces and motions, see `results.response_error`.
    """

    n_dofs: int
    n_hanging: int
    n_candidates: int
    pressure: float
    traction: float | None
    peak: float
    max_pressure: float
    area: float
    seconds: float
    area_error: float = 0.0
    force: float | None = None
    approach: float | None = None
    tilt: float | None = None

    @property
    def errors(self) -> dict[str, float]:
        """Estimated errors by the names of `FIGURES`; unknown ones, as of a peak without bound, are omitted."""
        found = {
            "pressure": max(self.pressure, self.traction or 0.0), "peak": self.peak, "area": self.area_error,
            "force": self.force, "approach": self.approach, "tilt": self.tilt,
        }  # fmt: skip
        return {name: error for name, error in found.items() if error is not None and math.isfinite(error)}

    def over(self, accuracy: float | Mapping[str, float]) -> float:
        """Largest ratio of an error to the accuracy asked of it; what is not resolved is off by all of it."""
        unresolved = {} if math.isfinite(self.area_error) else {"peak": 1.0, "area": 1.0}
        found = unresolved | self.errors
        return max(found.get(name, 0.0) / wanted for name, wanted in asked(accuracy).items())

    def text(self, accuracy: float | Mapping[str, float]) -> str:
        """Errors of the figures that were asked for, in words."""
        found = self.errors
        return ", ".join(f"{name} {percent(found[name])}" for name in asked(accuracy) if name in found)


@compact_repr
@dataclass(frozen=True)
class Convergence:
    """The steps of `Scene.solve(accuracy=...)`; the last is that of the result.

    Attributes
    ----------
    accuracy : float or mapping of str to float
        Requested relative error of the pressure, and of the tractions of friction; or of figures by name.
    steps : tuple of Step
    met : bool
        Whether the estimate times its safety factor is within it.
    reason : str
        Reason of the end.
    """

    accuracy: float | Mapping[str, float]
    steps: tuple[Step, ...]
    met: bool
    reason: str

    def as_dict(self) -> dict[str, Any]:
        """All figures, ready for JSON; the error of a peak without bound is None."""
        steps = [asdict(s) | {"peak": _finite(s.peak)} for s in self.steps]
        plain = dict(self.accuracy) if isinstance(self.accuracy, Mapping) else self.accuracy
        return {**vars(self), "accuracy": plain, "steps": steps}

    @property
    def table(self) -> Table:
        """A row for each step."""
        known = [n for n in ("force", "approach", "tilt") if any(getattr(s, n) is not None for s in self.steps)]
        errors = [Column(n, ".2%", blank="none") for n in ("pressure", "traction", "peak", *known)]
        columns: list[Column | str] = [
            "dofs",
            "hanging",
            "candidates",
            *errors[:3],
            "max p",
            "area",
            Column("s", ".2f"),
            *errors[3:],
        ]
        rows = [
            (
                *(s.n_dofs, s.n_hanging, s.n_candidates, s.pressure, s.traction, _finite(s.peak)),
                *(s.max_pressure, s.area, s.seconds, *(_finite(getattr(s, n)) for n in known)),
            )
            for s in self.steps
        ]
        return Table(columns, rows, [f"Accuracy {accuracy_text(self.accuracy)}: {self.reason}"])

    def __str__(self) -> str:
        return str(self.table)


def accuracy_text(accuracy: float | Mapping[str, float]) -> str:
    """An accuracy as text.

    Examples
    --------
    >>> accuracy_text(0.02), accuracy_text({"pressure": 0.02, "force": 0.01})
    ('0.02', 'pressure 0.02, force 0.01')
    """
    if not isinstance(accuracy, Mapping):
        return f"{accuracy:.3g}"
    return ", ".join(f"{name} {value:.3g}" for name, value in accuracy.items())


def _finite(error: float | None) -> float | None:
    return None if error is None or not math.isfinite(error) else error
