"""Pictures of contacts on half-spaces: pressure, gap, displacement and stress inside, and curves over the load."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fecontact.app.indentation.figures import CurveFigures, IndentationFigures
from fecontact.bodies import HalfSpaceContact
from fecontact.common.arrays import Array
from fecontact.common.units import Units
from fecontact.fem.stress import von_mises
from fecontact.results.pictures.figure import save_figure

SECTION = (61, 31)
"""Points of the section through the body, along the surface and downwards."""

SECTION_CELLS = 32
"""Cells per side onto which the pressures of a free half-space are aggregated for the section."""

FEWEST = 0.02
"""Least depth of the section's points, as a share of a cell."""


def plot_indentation(found: IndentationFigures, path: str | Path | None = None, units: Units | None = None) -> Figure:
    """Pressure, gap, displacement of the surface, and the von Mises stress below the line y = 0 (or nearest to it).

    Parameters
    ----------
    found : IndentationFigures
    path : str or Path, optional
        File to write; the suffix decides the format.
    units : plot.Units, optional
        Units for labels.
    """
    names, contact = units or Units(), found.contact
    figure = Figure(figsize=(11.6, 8.6), layout="compressed")
    (first, second), (third, fourth) = figure.subplots(2, 2)
    gap = np.where(np.isfinite(contact.gap), contact.gap, np.nan)
    # limit the scale: the gap of a round shape is large far from the contact
    limit = float(np.nanquantile(gap, 0.9)) if not contact.periodic else None
    draw_map(first, contact, contact.pressure, "magma_r", names.after("pressure", "stress"), names)
    draw_map(second, contact, gap, "viridis", names.after("gap", "length"), names, limit)
    draw_map(third, contact, contact.displacement, "YlGnBu", names.after("displacement", "length"), names)
    draw_section(fourth, contact, names)
    if found.exact is not None and found.exact.pressure is not None:
        _draw_outline(first, found)
    figure.suptitle(
        f"{found.name}: force {names.number(contact.force, 'force')}, "
        f"area {names.number(contact.edge_area, 'length', '²')}, "
        f"approach {names.number(contact.approach, 'length')}"
    )
    return save_figure(figure, path)


def draw_map(
    axes: Any,
    contact: HalfSpaceContact,
    values: Array,
    colours: str,
    label: str,
    names: Units,
    limit: float | None = None,
) -> None:
    """Draw values (nx, ny) on the cells."""
    grid = contact.grid
    half = (grid.size[0] / 2, grid.size[1] / 2)
    drawn = axes.imshow(
        values.T,
        origin="lower",
        extent=(-half[0], half[0], -half[1], half[1]),
        cmap=colours,
        vmax=limit,
        aspect="equal" if max(half) < 4 * min(half) else "auto",
        interpolation="nearest",
    )
    axes.figure.colorbar(drawn, ax=axes, label=label, extend="max" if limit is not None else "neither")
    axes.set_xlabel(names.after("x", "length"))
    axes.set_ylabel(names.after("y", "length"))


def _draw_outline(axes: Any, found: IndentationFigures) -> None:
    """The edge of the closed form's contact."""
    assert found.exact is not None
    if found.contact.periodic:
        return
    angle = np.linspace(0, 2 * np.pi, 200)
    a, b = found.exact.half_widths
    axes.plot(a * np.cos(angle), b * np.sin(angle), "--", color="tab:cyan", linewidth=1.2, label="exact edge")
    axes.legend(loc="upper right", fontsize="small")


def section(contact: HalfSpaceContact, y: float = 0.0, depth: float | None = None) -> tuple[Array, Array, Array]:
    """Stress in the plane y = constant below the contact.

    Parameters
    ----------
    contact : HalfSpaceContact
    y : float
    depth : float, optional
        Depth of the section; by default half the grid's side (a fifth if periodic) or, on a rigid base, the layers.

    Returns
    -------
    x : (n,) array
    z : (m,) array
        If the depth is not positive.
    stress : (n, m, 6) array
        xx, yy, zz, xy, yz, xz, tension positive.
    """
    grid = contact.grid
    deepest = grid.size[0] / (5 if contact.periodic else 2) if depth is None else depth
    if contact.material is None:
        deepest = min(deepest, sum(layer.thickness for layer in contact.layers))
    highest = FEWEST * min(grid.cell)
    x = np.linspace(-0.5, 0.5, SECTION[0]) * (grid.size[0] - grid.cell[0])
    z = -np.linspace(highest, deepest, SECTION[1])
    X, Z = np.meshgrid(x, z, indexing="ij")
    points = np.stack([X.ravel(), np.full(X.size, y), Z.ravel()], axis=1)
    return x, z, _gathered(contact).stress(points).reshape(*X.shape, 6)


def _gathered(contact: HalfSpaceContact) -> HalfSpaceContact:
    """The contact on larger cells with the same forces, for stresses at a depth."""
    while (
        not contact.periodic and max(contact.grid.shape) > SECTION_CELLS and not any(n % 2 for n in contact.grid.shape)
    ):
        nx, ny = contact.grid.shape
        pressure = contact.pressure.reshape(nx // 2, 2, ny // 2, 2).mean(axis=(1, 3))
        contact = replace(contact, grid=contact.grid.coarser, pressure=pressure)
    return contact


def draw_section(axes: Any, contact: HalfSpaceContact, names: Units) -> None:
    """Draw the von Mises stress below the middle of the pressure."""
    centre = contact.centre_of_pressure[1]
    x, z, stress = section(contact, y=float(centre) if np.isfinite(centre) and not contact.periodic else 0.0)
    values = von_mises(stress.reshape(-1, 6)).reshape(stress.shape[:2])
    drawn = axes.contourf(x, z, values.T, levels=24, cmap="YlOrRd")
    axes.figure.colorbar(drawn, ax=axes, label=names.after("von Mises stress", "stress"))
    depth = 0.0
    for layer in contact.layers:
        depth -= layer.thickness
        if depth > z[-1]:
            axes.axhline(depth, color="black", linewidth=0.8)
    axes.set_xlabel(names.after("x", "length"))
    axes.set_ylabel(names.after("z", "length"))
    axes.set_aspect("equal" if -z[-1] > 0.2 * (x[-1] - x[0]) else "auto")


def plot_curve(found: CurveFigures, path: str | Path | None = None, units: Units | None = None) -> Figure:
    """Plot approach, area, stiffness and mean gap over the force, with the closed form where there is one."""
    names = units or Units()
    figure = Figure(figsize=(10.0, 7.6), layout="constrained")
    force = found.column("force")
    panels = (
        ("approach", names.after("approach", "length")),
        ("area, edge fitted", "contact area" + (f" [{names.length}²]" if names.length else "")),
        ("stiffness", "stiffness" + (f" [{names.force}/{names.length}]" if names.force and names.length else "")),
        ("mean gap", names.after("mean gap", "length")),
    )
    for axes, (name, label) in zip(figure.subplots(2, 2).ravel(), panels, strict=True):
        values = found.column(name)
        axes.plot(force, np.where(np.isfinite(values), values, np.nan), "o-", markersize=4, label="found")
        key = "contact area" if name == "area, edge fitted" else name
        known = [step.exact.figures.get(key, np.nan) if step.exact else np.nan for step in found.steps]
        if np.isfinite(known).any():
            axes.plot(force, known, "k--", linewidth=1.0, label="exact")
            axes.legend()
        axes.set_xlabel(names.after("force", "force"))
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    figure.suptitle(f"{found.steps[0].name}, {len(found.steps)} loads")
    return save_figure(figure, path)
