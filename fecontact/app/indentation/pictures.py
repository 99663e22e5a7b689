"""Pictures of contacts on half-spaces: pressure, gap, displacement and stress inside, and curves over the load."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fecontact.app.indentation.figures import CurveFigures, IndentationFigures
from fecontact.bodies.halfspace.pictures import plot_over_force, plot_pressed
from fecontact.common.figure import save_figure
from fecontact.common.units import Units


def plot_indentation(found: IndentationFigures, path: str | Path | None = None, units: Units | None = None) -> Figure:
    """Pressure, gap, displacement of the surface, and the von Mises stress in the plane y = constant below the peak.

    Parameters
    ----------
    found : IndentationFigures
    path : str or Path, optional
        File to write; the suffix decides the format.
    units : Units, optional
        Units for labels.
    """
    figure = plot_pressed(found.contact, None, units, found.name)
    if found.exact is not None and found.exact.pressure is not None:
        _draw_outline(figure.axes[0], found)
    return save_figure(figure, path)


def _draw_outline(axes: Any, found: IndentationFigures) -> None:
    """The edge of the closed form's contact."""
    assert found.exact is not None
    if found.contact.periodic:
        return
    angle = np.linspace(0, 2 * np.pi, 200)
    a, b = found.exact.half_widths
    axes.plot(a * np.cos(angle), b * np.sin(angle), "--", color="tab:cyan", linewidth=1.2, label="exact edge")
    axes.legend(loc="upper right", fontsize="small")


def plot_curve(found: CurveFigures, path: str | Path | None = None, units: Units | None = None) -> Figure:
    """Plot approach, area, stiffness and mean gap over the force, with the closed form where there is one."""
    names = units or Units()
    panels = {
        "approach": names.after("approach", "length"),
        "area": "area" + (f" [{names.length}²]" if names.length else ""),
        "stiffness": "stiffness" + (f" [{names.force}/{names.length}]" if names.force and names.length else ""),
        "mean gap": names.after("mean gap", "length"),
    }
    curves = {}
    for name, label in panels.items():
        known = [step.exact.figures.get(name, np.nan) if step.exact else np.nan for step in found.steps]
        curves[label] = {"found": found.column(name), "exact": np.array(known, float)}
    title = f"{found.steps[0].name}, {len(found.steps)} loads"
    return plot_over_force(found.column("force"), curves, title, names, path)
