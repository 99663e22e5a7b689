"""Convergence of an adaptive solution: one step for each division of the meshes."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from fecontact.common.one_line import one_line


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

    @property
    def worst(self) -> float:
        """The larger error of pressure and tractions."""
        return max(self.pressure, self.traction or 0.0)


@one_line
@dataclass(frozen=True)
class Convergence:
    """The steps of `Scene.solve(accuracy=...)`; the last is that of the result.

    Attributes
    ----------
    accuracy : float
        Requested relative error of the pressure, and of the tractions of friction.
    steps : tuple of Step
    met : bool
        Whether the estimate times its safety factor is within it.
    reason : str
        Reason of the end.
    """

    accuracy: float
    steps: tuple[Step, ...]
    met: bool
    reason: str

    def as_dict(self) -> dict[str, Any]:
        """All figures, ready for JSON; the error of a peak without bound is None."""
        steps = [asdict(s) | {"peak": s.peak if math.isfinite(s.peak) else None} for s in self.steps]
        return asdict(self) | {"steps": steps}

    def __str__(self) -> str:
        names = ("dofs", "hanging", "candidates", "pressure", "traction", "peak", "max p", "area", "s")
        head = "{:>9} {:>8} {:>11} {:>9} {:>9} {:>8} {:>12} {:>12} {:>7}".format(*names)
        rows = [
            f"{s.n_dofs:>9} {s.n_hanging:>8} {s.n_candidates:>11} {s.pressure:>9.2%} "
            f"{_percent(s.traction):>9} {_percent(s.peak):>8} "
            f"{s.max_pressure:>12.6g} {s.area:>12.6g} {s.seconds:>7.2f}"
            for s in self.steps
        ]
        return "\n".join([head, *rows, f"Accuracy {self.accuracy:.3g}: {self.reason}"])


def _percent(error: float | None) -> str:
    return "none" if error is None or not math.isfinite(error) else f"{error:.2%}"
