"""Figures of an indentation and of a curve over the load.

Pictures of contacts on half-spaces: pressure, gap, displacement and stress inside, and curves over the load.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fecontact.app.indentation.closed_forms import Exact
from fecontact.bodies import HalfSpace
from fecontact.common.arrays import Array
from fecontact.common.files import save_figure
from fecontact.common.table import Table
from fecontact.common.units import Units
from fecontact.halfspace import HalfSpaceContact
from fecontact.halfspace.pictures import plot_over_force, plot_pressed
from fecontact.results.report import peak_memory

FIGURES = (
    "force",
    "approach",
    "area",
    "area of its cells",
    "maximum pressure",
    "mean pressure",
    "mean gap",
    "stiffness",
)


def _finite(figures: dict[str, float]) -> dict[str, float | None]:
    """The value, None if not finite, for JSON."""
    return {name: float(value) if math.isfinite(value) else None for name, value in figures.items()}


CURVE = ("force", "approach", "area", "mean gap", "maximum pressure", "stiffness")


@dataclass(frozen=True, eq=False)
class Curve:
    """Figures of a shape on a half-space over a list of loads; made by `curve`.

    Attributes
    ----------
    steps : tuple of Indentation
    """

    steps: tuple[Indentation, ...]

    def column(self, name: str) -> Array:
        """One figure at all loads."""
        return np.array([step.figures[name] for step in self.steps])

    def rows(self) -> list[dict[str, float]]:
        """Figures of each load by name, with the number of regions."""
        return [{**{n: s.figures[n] for n in CURVE}, "regions": s.contact.n_regions} for s in self.steps]

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts."""
        return {"shape": self.steps[0].name, "loads": [step.as_dict() for step in self.steps]}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the contacts, each with the force that it concerns."""
        return tuple(f"At the force {s.contact.force:g}: {text}" for s in self.steps for text in s.contact.warnings)

    def __str__(self) -> str:
        names = (*CURVE, "regions")
        head = "".join(f"{name:>19}" for name in names)
        lines = ["".join(f"{row[name]:>19.6g}" for name in names) for row in self.rows()]
        worst = max(step.contact.residuals.worst for step in self.steps)
        error = max(self.steps, key=lambda step: step.contact.error_estimate.pressure).contact.error_estimate
        ends = [f"residuals: {worst:.1e}", f"largest error of {error}"]
        ends += [f"Warning: {text}" for text in self.warnings]
        return "\n".join([f"{self.steps[0].name}, {len(self.steps)} loads", head, *lines, *ends])

    def save(self, path: str | Path) -> Path:
        """Write a CSV file, one row per load."""
        columns = [name.replace(", ", " ").replace(" ", "_") for name in (*CURVE, "regions")]
        return Table(columns, [tuple(row.values()) for row in self.rows()]).save(path)

    def plot(self, path: str | Path | None = None, length: str = "", force: str = "", stress: str = "") -> Figure:
        """Approach, area, stiffness and mean gap over the force, with the closed form where there is one."""
        names = Units(length, force, stress)
        panels = {
            "approach": names.after("approach", "length"),
            "area": "area" + (f" [{names.length}²]" if names.length else ""),
            "stiffness": "stiffness" + (f" [{names.force}/{names.length}]" if names.force and names.length else ""),
            "mean gap": names.after("mean gap", "length"),
        }
        curves = {}
        for name, label in panels.items():
            known = [step.exact.figures.get(name, np.nan) if step.exact else np.nan for step in self.steps]
            curves[label] = {"found": self.column(name), "exact": np.array(known, float)}
        title = f"{self.steps[0].name}, {len(self.steps)} loads"
        return plot_over_force(self.column("force"), curves, title, names, path)


@dataclass(frozen=True, eq=False)
class Indentation:
    """A contact with its half-space and shape; made by `indent`.

    Attributes
    ----------
    name : str
        Name of the shape.
    shape : surface with `heights`, or (nx, ny) array
    half : HalfSpace
    contact : HalfSpaceContact
    exact : Exact or None
    """

    name: str
    shape: Any
    half: HalfSpace
    contact: HalfSpaceContact
    exact: Exact | None

    @cached_property
    def figures(self) -> dict[str, float]:
        """Figures of the contact by the names in `FIGURES`, with the tilt under an eccentric load."""
        c = self.contact
        found = {
            "force": c.force,
            "approach": c.approach,
            "area": c.figures["area"],
            "area of its cells": c.point_area,
            "maximum pressure": c.max_pressure,
            "mean pressure": c.figures["mean_pressure"],
            "mean gap": c.mean_gap,
            "stiffness": self.half.stiffness(c),
        }
        if any(c.tilt):
            found["tilt (rad)"] = math.hypot(*c.tilt)
        return found

    @cached_property
    def errors(self) -> dict[str, float]:
        """Relative errors against the closed form, and that of the pressure in the L2 norm."""
        if self.exact is None:
            return {}
        known = self.exact.figures
        out = {name: self.figures[name] / value - 1 for name, value in known.items() if value and name in self.figures}
        if self.exact.pressure is not None:
            x, y = self.contact.grid.x[:, None], self.contact.grid.y[None, :]
            where = np.broadcast_to(self.exact.compared(x, y), self.contact.grid.shape)
            target = np.broadcast_to(self.exact.pressure(x, y), self.contact.grid.shape)[where]
            difference = self.contact.pressure[where] - target
            out["pressure, L2"] = float(np.linalg.norm(difference) / np.linalg.norm(target))
        return out

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts."""
        c, s = self.contact, self.contact.solver
        return {
            "shape": self.name,
            "periodic": c.periodic,
            "cells": list(c.grid.shape),
            "size": list(c.grid.size),
            "figures": _finite(self.figures),
            "centre_of_pressure": [v if math.isfinite(v) else None for v in c.centre_of_pressure],
            "regions": c.n_regions,
            "exact": None if self.exact is None else {"source": self.exact.source, **_finite(self.exact.figures)},
            "errors": _finite(self.errors),
            "error_estimate": c.error_estimate.summary(),
            "warnings": list(c.warnings),
            "residuals": c.residuals.as_dict(),
            "iterations": s.nit,
            "transforms": s.transforms,
            "seconds": s.seconds,
            "peak_rss_mb": peak_memory(),
        }

    def __str__(self) -> str:
        c = self.contact
        exact = self.exact.figures if self.exact else {}
        kind = "periodic" if c.periodic else "free"
        stack = f", {len(c.layers)} layer(s)" if c.layers else ""
        lines = [
            f"{self.name} on a {kind} half-space{stack}, {c.grid.shape[0]} x {c.grid.shape[1]} cells on "
            f"{c.grid.size[0]:.6g} x {c.grid.size[1]:.6g}"
        ]
        if self.exact is not None:
            lines.append(f"beside: {self.exact.source}")
            lines.append(f"  {'':20}{'found':>14}{'exact':>14}{'error':>11}")
        for name, value in self.figures.items():
            target = exact.get(name)
            compared = f"{target:>14.6g}" if target is not None else ""
            error = f"{self.errors[name]:>+11.1e}" if name in self.errors else ""
            lines.append(f"  {name:20}{value:>14.6g}{compared}{error}")
        if "pressure, L2" in self.errors:
            lines.append(f"  {'pressure, L2 error':20}{'':28}{self.errors['pressure, L2']:>11.1e}")
        lines.append(f"  {'regions':20}{c.n_regions:>14d}")
        lines.append(f"  centre of pressure  {c.centre_of_pressure[0]:>14.6g}{c.centre_of_pressure[1]:>14.6g}")
        lines.append(f"residuals: {c.residuals}")
        lines.append(f"error of {c.error_estimate}")
        lines += [f"Warning: {text}" for text in c.warnings]
        lines.append(f"{c.solver.nit} iterations, {c.solver.transforms:.1f} transforms, {c.solver.seconds:.3f} s")
        return "\n".join(lines)

    def plot(self, path: str | Path | None = None, length: str = "", force: str = "", stress: str = "") -> Figure:
        """Pressure, gap, displacement, and the von Mises stress in the plane y = constant below the peak."""
        figure = plot_pressed(self.contact, None, Units(length, force, stress), self.name)
        if self.exact is not None and self.exact.pressure is not None:
            _draw_outline(figure.axes[0], self)
        return save_figure(figure, path)

    def save(self, path: str | Path) -> Path:
        """Write a CSV file of one row."""
        return Curve((self,)).save(path)


def _draw_outline(axes: Any, found: Indentation) -> None:
    """The edge of the closed form's contact."""
    assert found.exact is not None
    if found.contact.periodic:
        return
    angle = np.linspace(0, 2 * np.pi, 200)
    a, b = found.exact.half_widths
    axes.plot(a * np.cos(angle), b * np.sin(angle), "--", color="tab:cyan", linewidth=1.2, label="exact edge")
    axes.legend(loc="upper right", fontsize="small")
