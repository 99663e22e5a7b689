"""Approach, area and pressures of a contact with a half-space over the force."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.one_line import one_line
from fecontact.common.progress import progress_line
from fecontact.common.table import Table
from fecontact.common.units import Units
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.pressing import Load

#: Figures of each load.
COLUMNS = ("force", "approach", "area", "max_pressure", "mean_pressure", "mean_gap", "regions", "pressure_error")


def load_figures(contact: HalfSpaceContact) -> dict[str, float]:
    """Figures of a contact by the names in `COLUMNS`."""
    found = {**contact.figures, "regions": float(contact.n_regions), "pressure_error": contact.error_estimate.pressure}
    return {name: found[name] for name in COLUMNS}


@one_line
@dataclass(frozen=True, eq=False)
class LoadCurve:
    """Figures of a contact over the force; made by `HalfSpace.curve`.

    Attributes
    ----------
    figures : dict of (n,) arrays
        force, approach, area, max_pressure, mean_pressure, mean_gap, regions (their number) and pressure_error
        (estimated, relative), in the order of the forces given.
    warnings : tuple of str
        With the force that each concerns.
    """

    figures: Mapping[str, Array]
    warnings: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Number of loads."""
        return len(self.figures["force"])

    def column(self, name: str) -> Array:
        """Figures (n,) of one name.

        Raises
        ------
        InputError
            If there are none of that name.
        """
        among("column", name, self.figures)
        return self.figures[name]

    @property
    def force(self) -> Array:
        """Forces (n,)."""
        return self.figures["force"]

    @property
    def approach(self) -> Array:
        """Approaches (n,)."""
        return self.figures["approach"]

    @property
    def area(self) -> Array:
        """Areas (n,), with the edge located within the cells."""
        return self.figures["area"]

    def to_csv(self, path: str | Path) -> Path:
        """Write a row for each load, with a head.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        return self._table.save(path)

    def plot(self, path: str | Path | None = None, *, length: str = "", force: str = "", stress: str = "") -> Any:
        """Draw approach, area, pressures and mean gap over the force, a matplotlib figure.

        Parameters
        ----------
        path : str or Path, optional
            File to write; the suffix decides the format.
        length, force, stress : str
            Names of units, for labels.

        Raises
        ------
        InputError
            If the file cannot be written, or a name is no text.
        """
        from fecontact.halfspace.pictures import plot_over_force

        names = Units(length, force, stress)
        panels = {
            names.after("approach", "length"): {"": self.approach},
            "area" + (f" [{length}²]" if length else ""): {"": self.area},
            names.after("pressure", "stress"): {n: self.figures[f"{n}_pressure"] for n in ("max", "mean")},
            names.after("mean gap", "length"): {"": self.figures["mean_gap"]},
        }
        return plot_over_force(self.force, panels, f"{len(self)} loads", names, path)

    def __str__(self) -> str:
        return str(self._table)

    @property
    def _table(self) -> Table:
        rows = list(zip(*(values.tolist() for values in self.figures.values()), strict=True))
        return Table(list(self.figures), rows, [f"Warning: {text}" for text in self.warnings])


def load_curve(loads: Sequence[Load], pressed: Callable[[Load], HalfSpaceContact], progress: bool | None) -> LoadCurve:
    """Figures of contacts under loads, see `HalfSpace.curve`."""
    rows, warnings = [], []
    with progress_line("curve", progress, len(loads), "load") as line:
        for load in loads:
            contact = pressed(load)
            rows.append(load_figures(contact))
            warnings += [f"At the force {load.force:g}: {text}" for text in contact.warnings]
            line.update()
    return LoadCurve({name: np.array([row[name] for row in rows]) for name in COLUMNS}, tuple(warnings))
