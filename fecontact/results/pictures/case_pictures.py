"""Pictures of many cases: quantities over a parameter, a grid of maps with one scale, an animation of the maps.

Picture of the convergence of an adaptive solution: estimated error against unknowns and against time.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError, MissingPackageError
from fecontact.common.files import replacing, save_figure
from fecontact.common.panels import scale_by_decades
from fecontact.common.progress import progress_line
from fecontact.common.units import Units
from fecontact.results.convergence import Convergence, asked
from fecontact.results.field_map import FieldMap
from fecontact.results.pictures.contact_map import Sheet
from fecontact.results.pictures.section_curve import Curves

#: Width of a map of a montage, bounds of its height, and width and height of a panel of curves, in inches.
WIDTH, HEIGHTS, PANEL = 2.9, (1.2, 4.5), (7.0, 2.6)
#: Letters of a line of the title of a map.
LETTERS = 34
#: Cases whose names are written below a picture of curves at most.
NAMED = 16
#: Dots per inch of an animation.
DPI = 110


def plot_columns(
    panels: Mapping[str, Mapping[str, Array]],
    along: tuple[str, Array],
    names: Sequence[str],
    path: str | Path | None,
    ax: Axes | None = None,
) -> Figure:
    """Curves over the cases or a parameter, a panel for each quantity.

    Parameters
    ----------
    panels : mapping of label to curves
        Curves (n,) by their names.
    along : (str, (n,) array)
        Label and values of the horizontal axis; without label the numbers of the cases.
    names : sequence of str
        Names of the cases.
    path : str or Path, optional
    ax : matplotlib Axes, optional
        Where to draw a single panel.
    """
    label, place = along
    order = np.argsort(place, kind="stable")
    if ax is not None and len(panels) != 1:
        raise InputError(
            f"One quantity is drawn into given axes; found {len(panels)}: give it by name.", code="one-axes"
        )
    if ax is None:
        figure = Figure(figsize=(PANEL[0], PANEL[1] * len(panels) + 0.6), layout="constrained")
        every = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    else:
        figure, every = cast(Figure, ax.figure), np.array([ax])
    for axes, (head, curves) in zip(every, panels.items(), strict=True):
        for name, values in curves.items():
            axes.plot(place[order], values[order], "o-", markersize=3.5, linewidth=1.2, label=name)
        axes.set_ylabel(head)
        scale_by_decades(axes, place if label else (), curves.values())
        if axes.get_yscale() == "linear" and all((values >= 0).all() for values in curves.values()):
            axes.set_ylim(0.0, 1.08 * max(float(values.max()) for values in curves.values()) or 1.0)
        axes.grid(color="0.9")
        if len(curves) > 1:
            axes.legend(loc="best", fontsize="small")
    every[-1].set_xlabel(label or "case")
    if not label and len(names) <= NAMED:
        turn = 30 if max(map(len, names)) > 6 else 0
        written = ["\n".join(textwrap.wrap(name, LETTERS // 2)) for name in names]
        every[-1].set_xticks(place, written, rotation=turn, ha="right" if turn else "center")
    return save_figure(figure, path)


def _paper(maps: Sequence[FieldMap], units: Units) -> Sheet | Curves:
    return Curves.of(maps, units) if maps[0].is_curve else Sheet.of(maps, units)


def _height(sheet: Sheet | Curves) -> float:
    """Height of a map of `WIDTH`, in inches."""
    return float(np.clip(WIDTH * sheet.ratio, *HEIGHTS))


def _name(axes: Any, kept: FieldMap, name: str, units: Units) -> None:
    """Title of one map: the case, broken where it is long, and the peak."""
    lines = textwrap.wrap(name, LETTERS)
    if not kept.active.any():
        lines.append("no contact")
    elif kept.what != "gap":
        lines.append(f"peak {units.number(kept.peak, 'stress')}")
    axes.set_title("\n".join(lines), fontsize="small")


def plot_montage(
    maps: Sequence[FieldMap], names: Sequence[str], title: str, units: Units, path: str | Path | None
) -> Figure:
    """A grid of maps of one contact in several cases, with one scale and one window.

    Parameters
    ----------
    maps : sequence of FieldMap
    names : sequence of str
        Of the cases.
    title : str
    units : Units
    path : str or Path, optional
    """
    sheet = _paper(maps, units)
    columns = min(len(maps), max(3, round(np.sqrt(1.4 * len(maps) * _height(sheet) / WIDTH))))
    rows = -(-len(maps) // columns)
    title_lines = max(len(textwrap.wrap(name, LETTERS)) for name in names)
    size = (WIDTH * columns + 1.4, (_height(sheet) + 0.55 + 0.2 * title_lines) * rows + 0.7)
    figure = Figure(figsize=size, layout="compressed")
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for k, axes in enumerate(grid.ravel()):
        if k >= len(maps):
            axes.remove()
            continue
        sheet.draw(axes, maps[k])
        _name(axes, maps[k], names[k], units)
        if k + columns < len(maps):
            axes.set_xlabel("")
        else:
            axes.tick_params(labelbottom=True)
        if k % columns:
            axes.set_ylabel("")
    sheet.add_scale(figure, list(grid.ravel()[: len(maps)]), shrink=0.9, aspect=30)
    figure.suptitle(title, fontsize="medium")
    return save_figure(figure, path)


def animate_maps(
    maps: Sequence[FieldMap], names: Sequence[str], title: str, units: Units, path: str | Path, rate: int
) -> Path:
    """Write the maps of one contact as an animation, a frame for each case: .gif, or .mp4 where ffmpeg is installed.

    Parameters
    ----------
    maps, names, title, units
        As for `plot_montage`.
    path : str or Path
    rate : int
        Frames per second.

    Raises
    ------
    MissingPackageError
        If ffmpeg is missing for .mp4.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise MissingPackageError("An animation .mp4 needs the program ffmpeg; install it, or write a .gif.")
    figure = Figure(layout="constrained")
    FigureCanvasAgg(figure)
    writer: Any = (PillowWriter if suffix == ".gif" else FFMpegWriter)(fps=rate)
    with replacing(path) as partial, progress_line("animate", None, len(maps), "frame") as line:
        # what is laid out for the first frame stays for all of them
        frames = _frames(figure, maps, names, title, units)
        next(frames)
        with writer.saving(figure, str(partial), DPI):
            for _ in maps:
                writer.grab_frame()
                line.update()
                next(frames, None)
    return Path(path)


def _frames(figure: Figure, maps: Sequence[FieldMap], names: Sequence[str], title: str, units: Units) -> Iterator[None]:
    """Draw one map after the other in the same place."""
    sheet = _paper(maps, units)
    figure.set_size_inches(2 * WIDTH + 1.6, 2 * _height(sheet) + 1.3)
    axes = figure.subplots()
    sheet.add_scale(figure, axes, shrink=0.9, aspect=30)
    figure.suptitle(title, fontsize="medium")
    for k, (kept, name) in enumerate(zip(maps, names, strict=True)):
        axes.clear()
        sheet.draw(axes, kept)
        _name(axes, kept, name, units)
        if k == 0:
            figure.canvas.draw()
            figure.set_layout_engine("none")
        yield


def draw_convergence(convergence: Convergence | None) -> Figure:
    """Estimated errors of the pressure and of its peak over unknowns, and over seconds; logarithmic.

    Raises
    ------
    InputError
        Without steps to draw.
    """
    if convergence is None:
        raise InputError("Only a result solved to an accuracy has steps to draw: scene.solve(..., accuracy=0.02).")
    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    steps = convergence.steps
    for axes, label, x in zip(
        figure.subplots(1, 2, sharey=True),
        ("unknowns", "seconds from the start"),
        ([s.n_dofs for s in steps], [s.seconds for s in steps]),
        strict=True,
    ):
        axes.loglog(x, [100 * s.pressure for s in steps], "o-", label="pressure, L2")
        axes.loglog(x, [100 * s.peak for s in steps], "s--", label="peak pressure")
        for name in ("force", "approach", "tilt"):
            if any(name in s.errors for s in steps):
                axes.loglog(x, [100 * s.errors.get(name, math.nan) for s in steps], "^:", label=name)
        for name, value in asked(convergence.accuracy).items():
            axes.axhline(100 * value, color="0.5", linewidth=1.0, label=f"asked of the {name}")
        axes.set_xlabel(label)
        axes.grid(True, which="both", alpha=0.25)
    figure.axes[0].set_ylabel("estimated error, %")
    figure.axes[0].legend()
    return figure
