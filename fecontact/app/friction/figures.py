"""Figures of a study of friction beside those of a closed form.

Pictures of friction on half-spaces: stick, slip and tractions; loops; rolling.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fecontact.analytic.friction import RoundSlip
from fecontact.common.files import save_figure
from fecontact.common.units import Units
from fecontact.halfspace import FrictionPath
from fecontact.halfspace.pictures import draw_stick_slip


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


def plot_study(study: HalfSpaceFigures, path: str | Path | None = None, units: Units | None = None) -> Figure:
    """Tractions over x beside the closed form, and a map of stick and slip, a loop, or the creep while rolling."""
    names = units or Units()
    figure = Figure(figsize=(11.6, 5.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_tractions(left, study, names)
    if study.rolls:
        _draw_creep(right, study, names)
    elif len(study.path.contacts) > 1:
        _draw_loop(right, study.path, study.exact, names)
    else:
        draw_stick_slip(right, study.path.last, names)
    figure.suptitle(f"{study.name}, friction {study.path.last.friction:g}, beside {study.source}")
    return save_figure(figure, path)


def draw_tractions(axes: Any, study: HalfSpaceFigures, names: Units) -> None:
    """Draw tractions and their limit along the middle of the grid, beside the closed form."""
    last, exact = study.path.last, study.exact
    middle, period = last.grid.shape[1] // 2, last.grid.size[0]
    x = (last.grid.x - last.position[0] + period / 2) % period - period / 2
    order = np.argsort(x)
    near = order[np.abs(x[order]) <= 1.2 * exact.a]
    axes.plot(x[near], last.traction[0][near, middle], "o", markersize=3, color="tab:blue", label="traction")
    axes.plot(x[near], last.friction * last.pressure[near, middle], color="tab:orange", label="friction x pressure")
    line = np.linspace(-1.2 * exact.a, 1.2 * exact.a, 800)
    known = exact.traction(line if study.rolls else np.abs(line))
    axes.plot(line, known, color="black", linewidth=1.0, label="closed form")
    axes.set_xlabel(names.after("x", "length"))
    axes.set_ylabel(names.after("traction", "stress"))
    axes.legend()


def _draw_loop(axes: Any, path: FrictionPath, exact: RoundSlip, names: Units) -> None:
    """Draw force over shift, with the closed form."""
    axes.plot(path.shift[:, 0], path.tangential[:, 0], "o", markersize=4, color="tab:blue", label="found")
    force = np.linspace(-exact.tangential, exact.tangential, 400)
    axes.plot(exact.shift_in_cycle(force), force, color="black", linewidth=1.0, label="closed form")
    axes.plot(-exact.shift_in_cycle(-force), force, color="black", linewidth=1.0)
    axes.set_xlabel(names.after("shift", "length"))
    axes.set_ylabel(names.after("tangential force", "force"))
    axes.grid(alpha=0.3)
    axes.legend()


def _draw_creep(axes: Any, study: HalfSpaceFigures, names: Units) -> None:
    """Draw the creepage over the distance rolled, with the steady one."""
    contacts = study.path.contacts[1:]
    at = np.array([contact.position[0] for contact in contacts])
    creep = np.diff(study.path.shift[1:, 0]) / np.diff(at)
    axes.plot(at[1:], creep, color="tab:blue", label="found")
    axes.axhline(study.exact.creepage, color="black", linewidth=1.0, linestyle="--", label="steady (Carter)")
    axes.set_xlabel(names.after("distance rolled", "length"))
    axes.set_ylabel("creepage")
    axes.grid(alpha=0.3)
    axes.legend()
