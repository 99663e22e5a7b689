"""Table of many results: cases of a sweep, poses of a joint or steps of a load path, one row each."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np

from fecontact.common.arguments import file_path
from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.files import check_writable, save_json, write_atomically
from fecontact.common.units import Units
from fecontact.results.page import table_cell

#: Suffixes of files of a table.
TABLE_FILES = (".csv", ".json", ".jsonl")
#: Figures of a contact by name, with the kind and power of their units.
FIGURES: dict[str, tuple[str, str]] = {
    **{f"force_{axis}": ("force", "") for axis in "xyz"},
    "force": ("force", ""),
    "area": ("length", "²"),
    "max_pressure": ("stress", ""),
    "mean_pressure": ("stress", ""),
    **{f"centre_{axis}": ("length", "") for axis in "xyz"},
    "regions": ("", ""),
    "pressure_error": ("", ""),
    "stick_area": ("length", "²"),
    "slip_area": ("length", "²"),
    "dissipated": ("moment", ""),
}
#: Figures of a case as a whole.
WHOLE = ("case", "status", "residual", "iterations", "seconds", "warnings")
#: Figures of a contact that are printed.
PRINTED = ("force_x", "force_y", "force_z", "area", "max_pressure", "mean_pressure", "regions")
#: Kinds of units of what is given, by the first word.
GIVEN = {"forces": "force", "moments": "moment", "motions": "length", "poses": "length", "pressures": "stress"}
#: Component of a vector, relative to its largest, that is shown as zero.
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class CaseTable(Sequence[Mapping[str, Any]]):
    """Figures of many cases, a row for each. As a sequence it is that of the rows.

    Attributes
    ----------
    rows : tuple of dict
        `ContactResult.summary` of each case, with its ``name``, its ``loads`` and its ``parameters``, by name.
    contacts : tuple of (str, str)
        Names of the bodies of each contact as given. Forces in columns are on the first of them, whichever is the
        slave.
    units : Units

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), "bottom", {"top": "xyz"}, name="block")
    >>> floor = fc.RigidBody(fc.Plane(), name="floor")
    >>> scene = fc.Scene([block, floor], [fc.Contact(block, floor)])
    >>> table = scene.sweep([{"motions": {block: {"z": z}}, "parameters": {"depth": -z}} for z in (-0.01, -0.02)])
    >>> table
    CaseTable(2 cases, block on floor: force 0.01 to 0.02, peak 0.01 to 0.02)
    >>> table.column("max_pressure").round(9).tolist(), table.column("depth").tolist()
    ([0.01, 0.02], [0.01, 0.02])
    """

    rows: tuple[Mapping[str, Any], ...]
    contacts: tuple[tuple[str, str], ...]
    units: Units

    def __len__(self) -> int:
        """Number of cases."""
        return len(self.rows)

    @overload
    def __getitem__(self, k: int | str) -> Mapping[str, Any]: ...

    @overload
    def __getitem__(self, k: slice) -> tuple[Mapping[str, Any], ...]: ...

    def __getitem__(self, k: int | str | slice) -> Mapping[str, Any] | tuple[Mapping[str, Any], ...]:
        """Row of a case by number or name, or some of the rows."""
        if isinstance(k, str):
            among("case", k, self.names)
            return self.rows[self.names.index(k)]
        return self.rows[k]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the cases."""
        return tuple(str(row["name"]) for row in self.rows)

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Label of each contact."""
        return tuple(f"{one} on {other}" for one, other in self.contacts)

    @property
    def warnings(self) -> dict[str, list[str]]:
        """Warnings by the names of the cases, of those that have some."""
        return {row["name"]: row["warnings"] for row in self.rows if row["warnings"]}

    @cached_property
    def figures(self) -> dict[str, Array]:
        """Columns (n,) of numbers by name: what was given, figures of the contacts, and figures of the solution.

        Given: parameters by their names, loads and poses as ``forces ball z``. Contacts: names of `FIGURES`, with
        several contacts after the label of each, ``femur on tibia: area``; of sides of a plane, ``medial: force_z``. A
        figure that a case has not is NaN.
        """
        lines = [self._figures(row) for row in self.rows]
        names = dict.fromkeys(name for line in lines for name in line)
        return {name: np.array([line.get(name, np.nan) for line in lines], float) for name in names}

    def column(self, name: str) -> Array:
        """Figures (n,) of one name, see `figures`.

        Raises
        ------
        InputError
            If there are none of that name.
        """
        among("column", name, self.figures)
        return self.figures[name]

    def _figures(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """All numbers of a row by the name of their column; None stands for a figure without value."""
        out = {**row.get("parameters", {}), **row.get("loads", {})}
        for label, (first, _), contact in zip(self.labels, self.contacts, row["contacts"], strict=True):
            head = f"{label}: " if len(self.contacts) > 1 else ""
            sign = 1.0 if contact["slave"] == first else -1.0
            out |= {f"{head}{name}": value for name, value in _of_contact(contact, sign).items()}
            for side, part in contact.get("sides", {}).items():
                found = _resultant(part, sign, part["area"])
                out |= {f"{head}{side}: {name}": value for name, value in found.items()}
        out |= {f"{spring['name']}: tension": spring["tension"] for spring in row["springs"]}
        plain = [value for value in row["residuals"].values() if not isinstance(value, Mapping)]
        out |= {"residual": max(plain), "iterations": row["iterations"], "seconds": row["seconds"]["total"]}
        return out | {"warnings": len(row["warnings"])}

    def save(self, path: str | Path) -> Path:
        """Write the table; the suffix decides: .csv (`to_csv`), .json (`to_json`), .jsonl (a row in each line).

        Raises
        ------
        InputError
            For another suffix, or a file that cannot be written.
        """
        path = file_path("the path of a table", path)
        suffix = path.suffix.lower()
        among("suffix of a file of a table", suffix, TABLE_FILES)
        if suffix == ".jsonl":
            return write_atomically(path, "".join(json.dumps(row) + "\n" for row in self.rows))
        return self.to_csv(path) if suffix == ".csv" else self.to_json(path)

    def to_csv(self, path: str | Path) -> Path:
        """Write all columns with the names of the cases and their status, a row for each case."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["case", "status", *self.figures])
        numbers = np.stack(list(self.figures.values()), axis=1).tolist()
        for row, line in zip(self.rows, numbers, strict=True):
            writer.writerow([row["name"], row["status"], *map(repr, line)])
        return write_atomically(check_writable(path), text.getvalue())

    def to_json(self, path: str | Path) -> Path:
        """Write all rows, ``{"cases": [...]}``."""
        return save_json(path, {"cases": list(self.rows)})

    def lines(self) -> tuple[list[str], list[list[str]]]:
        """Heads and lines of the printed table: a line for each case and contact, with what was given and changes."""
        figures, several = self.figures, len(self.contacts) > 1
        given = [name for name in self._given if np.ptp(figures[name]) != 0]  # NaN, in some cases only, shows too
        heads = ["case", *map(self.headed, given), *(["contact"] if several else [])]
        heads += [*map(self.headed, PRINTED), "warnings"]
        out = []
        for k, name in enumerate(self.names):
            start = [name, *(f"{figures[column][k]:.4g}" for column in given)]
            for label in self.labels:
                head = f"{label}: " if several else ""
                values = np.array([figures[f"{head}{figure}"][k] for figure in PRINTED])
                force = values[:3]
                force[np.abs(force) <= ROUNDING * np.abs(force).max()] = 0.0
                line = [*([label] if several else []), *(f"{v:.4g}" for v in values)]
                out.append([*start, *line, f"{figures['warnings'][k]:.0f}"])
        return heads, out

    @property
    def _given(self) -> list[str]:
        """Columns of what was given."""
        return list(dict.fromkeys(n for row in self.rows for n in (*row.get("parameters", {}), *row.get("loads", {}))))

    def headed(self, name: str) -> str:
        """A column's name with its unit; angles, and parameters of users, have none."""
        first, _, rest = name.partition(" ")
        kind, power = FIGURES.get(name.rpartition(": ")[2], ("", ""))
        if first in GIVEN and rest.split()[-1][0] != "r":
            kind = GIVEN[first]
        return f"{name}{self.units.behind(kind, power)}" if kind else name

    def __str__(self) -> str:
        heads, lines = self.lines()
        columns = [(head, *rest) for head, *rest in zip(heads, *lines, strict=True)]
        sides = ["<" if column[0] in ("case", "contact") else ">" for column in columns]
        wide = [[f"{w:{side}{max(map(len, c))}}" for w in c] for side, c in zip(sides, columns, strict=True)]
        return "\n".join(["  ".join(line).rstrip() for line in zip(*wide, strict=True)] + self._remarks())

    def _remarks(self) -> list[str]:
        """Which forces are meant, and warnings."""
        told = [f"{label}: forces on {one}" for label, (one, _) in zip(self.labels, self.contacts, strict=True)]
        first = next(iter(self.warnings.items()), None)
        if first is not None:
            told.append(f"{len(self.warnings)} of {len(self)} cases have warnings; {first[0]}: {first[1][0]}")
        return told

    def __repr__(self) -> str:
        parts = [f"{len(self)} case{'' if len(self) == 1 else 's'}"]
        for label in self.labels[:2] if self.rows else ():
            head = f"{label}: " if len(self.contacts) > 1 else ""
            force, peak = (_range(self.figures[f"{head}{name}"]) for name in ("force", "max_pressure"))
            parts.append(f"{label}: force {force}, peak {peak}")
        more = [f"and {len(self.labels) - 2} more"] if len(self.labels) > 2 else []
        return f"CaseTable({', '.join([*parts, *more])})"

    def _repr_html_(self) -> str:
        return table_cell(*self.lines(), self._remarks())


def _of_contact(contact: Mapping[str, Any], sign: float) -> dict[str, Any]:
    """Figures of a contact; force and mean pressure belong to the area with the edge located within the faces."""
    area = contact["outline_area"]
    out = _resultant(contact, sign, area)
    friction = contact.get("friction", {})
    out |= {name: friction[name] for name in ("stick_area", "slip_area", "dissipated") if name in friction}
    return out | {"regions": contact["regions"], "pressure_error": contact["error_estimate"]["pressure"]}


def _resultant(part: Mapping[str, Any], sign: float, area: float) -> dict[str, Any]:
    """Figures of a contact or of a part of it, of which `area` is given."""
    force = np.asarray(part["force"], float)
    centre = part["centre_of_pressure"] or [np.nan] * 3
    return {
        **{f"force_{axis}": sign * f for axis, f in zip("xyz", force.tolist(), strict=True)},
        "force": float(np.linalg.norm(force)),
        "area": area,
        "max_pressure": part["max_pressure"],
        "mean_pressure": part["mean_pressure"] * part["area"] / area if area > 0 else 0.0,
        **{f"centre_{axis}": x for axis, x in zip("xyz", centre, strict=True)},
    }


def _range(values: Array) -> str:
    low, high = f"{values.min():.4g}", f"{values.max():.4g}"
    return low if low == high else f"{low} to {high}"
