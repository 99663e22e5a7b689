"""Work-precision diagram: error against processor seconds and against degrees of freedom, one curve per method."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from fecontact.app.compare.precision import TARGETS, curves, error_of, order
from fecontact.common.errors import InputError
from fecontact.results.pictures.draw import save_figure

Row = dict[str, Any]

MARKERS = "osD^vP*X<>hp"
AXES = (("seconds", "processor time [s]"), ("dofs", "degrees of freedom"))


def draw(
    rows: Sequence[Row], title: str, path: str | Path | None = None, published: Sequence[Row] = (), note: str = ""
) -> Figure:
    """Draw the diagram.

    Parameters
    ----------
    rows : sequence of dict
        As from `run.compare`.
    title : str
    path : str or Path, optional
        File to write; the suffix decides the format.
    published : sequence of dict
        Figures from elsewhere, drawn as grey points without a line: 'method', 'dofs', 'seconds', 'errors'.
    note : str
        A line under the diagram.

    Raises
    ------
    InputError
        If no row has figures.
    """
    found = curves(rows)
    if not found:
        raise InputError("None of the runs gave figures, so there is nothing to draw.")
    figure = Figure(figsize=(12.5, 6.6), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, (against, name) in zip(panels, AXES, strict=True):
        _panel(axes, found, against)
        _reference(axes, published, against)
        axes.set_xlabel(name)
    panels[0].set_ylabel("relative L2 error of the pressure")
    panels[0].yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{100 * v:g} %"))
    handles, labels = panels[1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8.5, frameon=False)
    figure.suptitle(f"{title}\n{note}" if note else title, fontsize=11)
    save_figure(figure, path)
    return figure


def _panel(axes: Axes, found: dict[str, list[Row]], against: str) -> None:
    colours = iter(colormaps["tab20"].colors[::2] + colormaps["tab20"].colors[1::2])  # type: ignore[attr-defined]
    greys = iter(("black", "0.35", "0.55", "0.2", "0.45"))
    for k, (label, rows) in enumerate(found.items()):
        peer = rows[0]["peer"]
        colour = next(greys, "0.5") if peer else next(colours, "tab:blue")
        rate = order(rows, "dofs")
        text = label if math.isnan(rate) else f"{label} (dofs$^{{{-rate:+.2f}}}$)"
        axes.loglog(
            [row[against] for row in rows],
            [error_of(row) for row in rows],
            "--" if peer else "-",
            marker=MARKERS[k % len(MARKERS)],
            ms=5,
            lw=1.3,
            color=colour,
            mfc="white" if peer else colour,
            label=text,
        )
    for target in TARGETS:
        axes.axhline(target, color="0.8", lw=0.8, zorder=0)
    axes.grid(True, which="major", color="0.93")
    axes.spines[["top", "right"]].set_visible(False)


def _reference(axes: Axes, published: Sequence[Row], against: str) -> None:
    names = dict.fromkeys(row["method"] for row in published)
    for marker, name in zip("+x1234|_", names, strict=False):
        rows = [row for row in published if row["method"] == name]
        axes.plot(
            [row[against] for row in rows],
            [error_of(row) for row in rows],
            marker,
            color="0.5",
            label=f"{name}, published elsewhere",
        )
