"""Table of a joint's contact along a path of poses."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.files import check_writable, replacing
from fecontact.common.units import Units

#: Columns of the printed table: name, kind of unit, format.
_PRINTED = (
    ("time", "", ".4g"),
    ("force_x", "force", "z.1f"),
    ("force_y", "force", "z.1f"),
    ("force_z", "force", "z.1f"),
    ("area", "area", ".4g"),
    ("max_pressure", "stress", ".4g"),
    ("mean_pressure", "stress", ".4g"),
    ("regions", "", ".0f"),
)


@dataclass(frozen=True, eq=False)
class PathTable:
    """Figures of every pose.

    Attributes
    ----------
    rows : sequence of dict
        Those of `Scene.sweep`.
    figures : dict of (n,) arrays
        time; force_x, force_y, force_z (on the moving bone); area; max_pressure, mean_pressure; centre_x, centre_y,
        centre_z (centre of pressure, NaN without contact); regions; pressure_error (estimated, relative).
    units : Units
    """

    rows: Sequence[Mapping[str, Any]]
    figures: Mapping[str, Array]
    units: Units

    @classmethod
    def of(cls, rows: Sequence[Mapping[str, Any]], times: Sequence[float], moving: str, units: Units) -> PathTable:
        """Of the rows of a sweep with one contact.

        Parameters
        ----------
        rows : sequence of mappings
        times : sequence of float
        moving : str
            Name of the moving body.
        units : Units
        """
        found: dict[str, list[float]] = {}
        for time, row in zip(times, rows, strict=True):
            contact = row["contacts"][0]
            sign = 1.0 if contact["slave"] == moving else -1.0
            centre = contact["centre_of_pressure"] or [np.nan] * 3
            line = {"time": time, **{f"force_{a}": sign * f for a, f in zip("xyz", contact["force"], strict=True)}}
            line |= {"area": contact["outline_area"]} | {k: contact[k] for k in ("max_pressure", "mean_pressure")}
            line |= {f"centre_{a}": x for a, x in zip("xyz", centre, strict=True)}
            line |= {"regions": contact["regions"], "pressure_error": contact["error_estimate"]["pressure"]}
            for name, value in line.items():
                found.setdefault(name, []).append(np.nan if value is None else float(value))
        return cls(rows, {name: np.array(values) for name, values in found.items()}, units)

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
    def warnings(self) -> dict[str, list[str]]:
        """Warnings by the names of the poses, of those that have some."""
        return {row["name"]: row["warnings"] for row in self.rows if row["warnings"]}

    def save(self, path: str | Path) -> Path:
        """Write all columns as CSV, with a head."""
        path = check_writable(path)
        with replacing(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(self.figures)
            writer.writerows([map(repr, line) for line in np.stack(list(self.figures.values()), axis=1).tolist()])
        return path

    def __str__(self) -> str:
        length = self.units.length
        unit = {"force": self.units.force, "stress": self.units.stress, "area": f"{length}2" if length else ""}
        heads = [name + (f" {unit[kind]}" if unit.get(kind) else "") for name, kind, _ in _PRINTED]
        columns = [[f"{value:{form}}" for value in self.figures[name].tolist()] for name, _, form in _PRINTED]
        widths = [max(map(len, [head, *column])) + 2 for head, column in zip(heads, columns, strict=True)]
        lines = [heads, *zip(*columns, strict=True)]
        return "\n".join("".join(f"{w:>{n}}" for w, n in zip(line, widths, strict=True)) for line in lines)
