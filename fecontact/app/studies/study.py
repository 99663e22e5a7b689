"""The result of a study: figures beside exact ones, rows, and a picture."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure as Picture

from fecontact.common.arrays import Array
from fecontact.common.compact_repr import compact_repr
from fecontact.common.files import save_figure
from fecontact.common.table import Column, Table
from fecontact.common.units import UnitNames, Units


@dataclass(frozen=True)
class Figure:
    """A figure found, and its exact value if one is known.

    Examples
    --------
    >>> Figure(1.01, 1.0, "mm").error, Figure(0.02, 0.0).error, Figure(3.0).error
    (0.010000000000000009, 0.02, None)
    """

    found: float
    exact: float | None = None
    unit: str = ""

    @property
    def error(self) -> float | None:
        """Relative error; where the exact value is zero, the figure itself."""
        if self.exact is None:
            return None
        return self.found / self.exact - 1 if self.exact else self.found


@compact_repr
@dataclass(frozen=True, eq=False)
class Study:
    """Result of a study; the command line prints, saves and draws every study in the same way.

    Attributes
    ----------
    name : str
        What was solved, in one line.
    figures : mapping of str to Figure
        They are printed; a study without figures prints its rows.
    rows : Table
        The rows of its CSV file.
    draw : callable
        Function ``draw(units)`` that returns the picture.
    data : mapping
        Everything for scripts, ready for JSON.
    solved : object
        The result, contact or path behind the figures; of a curve the studies of its loads.
    source : str
        The closed form that the figures are compared with.
    notes : sequence of str
        Lines printed below.
    """

    name: str
    figures: Mapping[str, Figure]
    rows: Table
    draw: Callable[[Units], Picture]
    data: Mapping[str, Any]
    solved: Any = None
    source: str = ""
    notes: Sequence[str] = ()

    @property
    def errors(self) -> dict[str, float]:
        """Errors of the figures that have an exact value."""
        return {name: f.error for name, f in self.figures.items() if f.error is not None}

    def __str__(self) -> str:
        table = self.rows
        if self.figures:
            columns: list[Column | str] = ["", Column("found"), Column("exact"), Column("error", "+.1e")]
            named = [(Column(name, unit=f.unit).head, f) for name, f in self.figures.items()]
            rows = [(name, f.found, f.exact, f.error) for name, f in named]
            table = Table(columns, rows) if self.errors else Table(columns[:2], [row[:2] for row in rows])
        beside = [f"beside: {self.source}"] if self.source else []
        return "\n".join([self.name, *beside, str(table), *self.notes])

    def save(self, path: str | Path) -> Path:
        """Write the rows to a CSV file."""
        return self.rows.save(path)

    def plot(self, path: str | Path | None = None, *, units: UnitNames = ()) -> Picture:
        """Draw the picture with these names of units, and write it to `path` if given."""
        return save_figure(self.draw(Units.of(units)), path)


def compared(figures: Mapping[str, Figure]) -> dict[str, dict[str, float | None]]:
    """Figures, exact values and errors by name, ready for JSON: None where a number is not finite."""
    exact = {name: f.exact for name, f in figures.items() if f.exact is not None}
    errors = {name: f.error for name, f in figures.items() if f.error is not None}
    return {
        "figures": finite({n: f.found for n, f in figures.items()}),
        "exact": finite(exact),
        "errors": finite(errors),
    }


def finite(values: Mapping[str, float]) -> dict[str, float | None]:
    """Numbers by name, None where they are not finite."""
    return {name: float(value) if math.isfinite(value) else None for name, value in values.items()}


def slender_study(
    name: str,
    unit: str,
    n: int,
    cases: Mapping[str, tuple[float, float]],
    shapes: Mapping[str, Array],
    seconds: float,
    remarks: Mapping[str, float] | None = None,
    beside: Mapping[str, Sequence[float]] | None = None,
) -> Study:
    """A study of beams.

    Parameters
    ----------
    name, unit : str
    n : int
        Elements.
    cases : mapping of str to (float, float)
        Figure found and known figure, NaN where it is not, whose errors are differences.
    shapes : mapping of str to (m, 3) array
        Points of the axis, to draw.
    seconds : float
        Of the solution, without the other procedures.
    remarks : mapping of str to float, optional
    beside : mapping of str to sequence of float, optional
        The same figures by other procedures; NaN where they have none.
    """
    remarks, beside = remarks or {}, beside or {}
    others = [{name: values[k] for name, values in beside.items()} for k in range(len(cases))]
    error = max(abs(found - known) for found, known in cases.values() if math.isfinite(known))
    both = list(zip(cases.items(), map(finite, others), strict=True))
    data = [{"case": case, **finite({"found": f, "known": known}), **other} for (case, (f, known)), other in both]
    head = {"problem": name, "elements": n, "unit": unit, "seconds": seconds}
    columns: list[Column | str] = ["case", "found", Column("known", blank="-"), Column("error", "+.1e", blank="-")]
    columns += [Column(other, blank="-") for other in beside]
    rows = [
        (case, found, *finite({"known": known, "error": found - known}).values(), *other.values())
        for (case, (found, known)), other in both
    ]
    title = f"{name}, {n} elements"

    def draw(_: Units) -> Picture:
        picture = Picture(figsize=(7.0, 5.4), layout="constrained")
        axes = picture.subplots()
        colours = colormaps["viridis"](np.linspace(0, 0.9, len(shapes)))
        for (label, points), colour in zip(shapes.items(), colours, strict=True):
            axes.plot(points[:, 0], points[:, 1], color=colour, label=label)
        axes.set_aspect("equal")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.set_title(f"{title}, largest error {error:.2g} {unit}")
        axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
        return picture

    notes = [*(f"{remark}: {value:.3g}" for remark, value in remarks.items()), f"{seconds:.2f} s"]
    everything = {**head, "cases": data, "error": error, **remarks}
    return Study(f"{title} [{unit}]", {}, Table(columns, rows), draw, everything, notes=notes)
