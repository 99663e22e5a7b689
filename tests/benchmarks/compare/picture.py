"""Work-precision diagram: error against processor seconds and against degrees of freedom, one curve per method."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from compare.table import Row, curves, error_of, order
from fecontact.common.errors import InputError
from fecontact.common.files import save_figure

MARKERS = "osD^vP*X<>hp"
AXES = (("seconds", "processor time [s]"), ("dofs", "degrees of freedom"))
#: Pressure errors marked by a line.
TARGETS = (0.05, 0.01, 0.001)


def draw(rows: Sequence[Row], title: str, path: str | Path | None = None, note: str = "") -> Figure:
    """Draw the diagram.

    Parameters
    ----------
    rows : sequence of dict
        As in `table`; the first of a method may have a 'style', keyword arguments of matplotlib's lines.
    title : str
    path : str or Path, optional
        File to write; the suffix decides the format.
    note : str
        A line under the title.

    Raises
    ------
    InputError
        If no row has figures.
    """
    found = curves(rows)
    if not found:
        raise InputError("None of the runs gave figures, so there is nothing to draw.")
    colours = [*colormaps["tab20"].colors[::2], *colormaps["tab20"].colors[1::2]]  # type: ignore[attr-defined]
    figure = Figure(figsize=(12.5, 6.6), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, (against, name) in zip(panels, AXES, strict=True):
        for k, (label, runs) in enumerate(found.items()):
            rate = order(runs, "dofs")
            style = {"color": colours[k % len(colours)], "marker": MARKERS[k % len(MARKERS)], "ms": 5, "lw": 1.3}
            style["label"] = label if math.isnan(rate) else f"{label} (dofs$^{{{-rate:+.2f}}}$)"
            x, y = [row[against] for row in runs], [error_of(row) for row in runs]
            axes.loglog(x, y, **style | runs[0].get("style", {}))
        for target in TARGETS:
            axes.axhline(target, color="0.8", lw=0.8, zorder=0)
        axes.grid(True, which="major", color="0.93")
        axes.spines[["top", "right"]].set_visible(False)
        axes.set_xlabel(name)
    panels[0].set_ylabel("relative L2 error of the pressure")
    panels[0].yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{100 * v:g} %"))
    handles, labels = panels[1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8.5, frameon=False)
    figure.suptitle(f"{title}\n{note}" if note else title, fontsize=11)
    save_figure(figure, path)
    return figure
