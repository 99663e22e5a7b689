"""Pictures of friction on half-spaces: stick, slip and tractions; loops; rolling."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fecontact.analytic.friction import RoundSlip
from fecontact.app.friction.figures import HalfSpaceFigures
from fecontact.bodies import FrictionPath
from fecontact.bodies.halfspace.pictures import draw_stick_slip
from fecontact.common.figure import save_figure
from fecontact.common.units import Units


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
