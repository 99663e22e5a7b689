"""The result of a study: figures beside exact ones, rows, and a picture."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure as Picture

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
