"""Table of many results: cases of a sweep, poses of a joint or steps of a load path, one row each."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast, overload

import numpy as np

from fecontact.bodies.body import Body
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import file_path, flag, items, texts
from fecontact.common.arrays import Array, without_rounding
from fecontact.common.checks import among, whole
from fecontact.common.errors import InputError, optional, shown
from fecontact.common.files import check_writable, save_json, write_atomically, write_collection
from fecontact.common.renamed import renamed
from fecontact.common.table import Column, Figures, Table
from fecontact.common.units import UnitNames, Units, refuse_units
from fecontact.contact.loads import check_member
from fecontact.contact.model import SceneModel
from fecontact.results.field_map import FIELDS, FieldMap, field_map
from fecontact.results.result import ContactResult
from fecontact.results.resultants import DividingPlane, sides_of_contact

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Figures of a contact by name, with the kind and power of their units.
FIGURES: dict[str, tuple[str, str]] = {
    **{f"force_{axis}": ("force", "") for axis in "xyz"},
    "force": ("force", ""),
    "area": ("length", "²"),
    "point_area": ("length", "²"),
    "max_pressure": ("stress", ""),
    "mean_pressure": ("stress", ""),
    **{f"centre_{axis}": ("length", "") for axis in "xyz"},
    "regions": ("", ""),
    "pressure_error": ("", ""),
    "stick_area": ("length", "²"),
    "slip_area": ("length", "²"),
    "friction_work": ("moment", ""),
}
#: Figures of a case as a whole.
WHOLE = ("case", "status", "residual", "iterations", "seconds", "warnings")
#: Kinds of units of what is given, by the first word.
GIVEN = {"forces": "force", "moments": "moment", "motions": "length", "poses": "length", "pressures": "stress"}


def contact_labels(contacts: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    """Label of each contact by the names of its bodies."""
    return tuple(f"{one} on {other}" for one, other in contacts)


def row_figures(row: Mapping[str, Any], contacts: Sequence[tuple[str, str]]) -> dict[str, Any]:
    """All numbers of a row by the name of their column; None stands for a figure without value.

    Parameters
    ----------
    row : mapping
        `ContactResult.summary` with parameters, loads and sides.
    contacts : sequence of (str, str)
        Names of the bodies of each contact.
    """
    out = {**row.get("parameters", {}), **row.get("loads", {})}
    for label, contact in zip(contact_labels(contacts), row["contacts"], strict=True):
        head = f"{label}: " if len(contacts) > 1 else ""
        out |= {f"{head}{name}": value for name, value in _of_contact(contact).items()}
        for side, part in contact.get("sides", {}).items():
            out |= {f"{head}{side}: {name}": value for name, value in _resultant(part).items()}
    out |= {f"{spring['name']}: tension": spring["tension"] for spring in row["springs"]}
    plain = [value for value in row["residuals"].values() if not isinstance(value, Mapping)]
    out |= {"residual": max(plain), "iterations": row["iterations"], "seconds": row["seconds"]["total"]}
    return out | {"warnings": len(row["warnings"])}


def _of_contact(contact: Mapping[str, Any]) -> dict[str, Any]:
    """Figures of a contact."""
    out, friction = _resultant(contact), contact.get("friction", {})
    out |= {name: friction[name] for name in ("stick_area", "slip_area", "friction_work") if name in friction}
    return out | {"regions": contact["regions"], "pressure_error": contact["error_estimate"]["pressure"]}


def _resultant(part: Mapping[str, Any]) -> dict[str, Any]:
    """Figures of a contact or of a part of it."""
    force = np.asarray(part["force"], float)
    centre = part["centre_of_pressure"] or [np.nan] * 3
    return {
        **{f"force_{axis}": f for axis, f in zip("xyz", force.tolist(), strict=True)},
        "force": float(np.linalg.norm(force)),
        **{name: part[name] for name in ("area", "point_area", "max_pressure", "mean_pressure")},
        **{f"centre_{axis}": x for axis, x in zip("xyz", centre, strict=True)},
    }


#: Fields of a result that are kept: by name those of all contacts.
Kept = dict[str, tuple[FieldMap, ...]]


def fields_to_keep(keep: Any, scene: SceneModel) -> tuple[str, ...]:
    """Names of fields, one or several.

    Raises
    ------
    InputError
        If one is none, or the scene has no such field.
    """
    names = texts("the fields to keep", keep)
    for name in names:
        among("field to keep", name, FIELDS)
    if "friction" in names and not scene.has_friction:
        raise InputError("No contact has friction: keep 'pressure' or 'gap', or give Contact(..., friction=...).")
    return names


def plane_of(split: Any, bodies: Sequence[Body]) -> DividingPlane | None:
    """A plane as users give it: a `DividingPlane`, or a point and a normal in world axes.

    Raises
    ------
    InputError
        If it is none, or of a body of another scene.
    """
    if split is None:
        return None
    plane: DividingPlane = split
    if not callable(getattr(split, "in_world", None)):
        given = items("split, where it is no DividingPlane,", split, "a point and a normal")
        if len(given) != 2:
            raise InputError(f"split is a DividingPlane, or a point and a normal; found {shown(split)}.", code="split")
        plane = DividingPlane(*given)
    if plane.body is not None:
        check_member(plane.body, bodies, "The dividing plane")
    return plane


def row_of(result: ContactResult, plane: DividingPlane | None, bodies: Sequence[Body]) -> dict[str, Any]:
    """Summary of a result, with the sides of a plane.

    Parameters
    ----------
    result : ContactResult
    plane : DividingPlane or None
    bodies : sequence of Body
        The scene's bodies as given, in the order of those of the result; the plane moves with one of them.
    """
    row = result.summary()
    if plane is not None:
        found = [k for k, body in enumerate(bodies) if body is plane.body]
        pose = result.scene.bodies[found[0]].pose if found else Pose()
        for figures, contact in zip(row["contacts"], result.contacts, strict=True):
            figures["sides"] = sides_of_contact(contact, plane, pose)
    return row


def kept_of(result: ContactResult, names: Sequence[str]) -> Kept:
    """Fields of all contacts of a result, without its bodies."""
    return {what: tuple(field_map(c, what) for c in result.contacts) for what in names}


#: Suffixes of files of a table, and of animations.
TABLE_FILES, ANIMATIONS = (".csv", ".json", ".jsonl"), (".gif", ".mp4")
#: Figures of a contact that are printed.
PRINTED = ("force_x", "force_y", "force_z", "area", "max_pressure", "mean_pressure", "regions")
#: Of a side of a plane.
OF_SIDES = ("force", "area", "max_pressure")
#: Maps in a montage at most.
MAX_MAPS = 100


@dataclass(frozen=True, eq=False, repr=False)
class CaseTable(Figures, Sequence[Mapping[str, Any]]):
    """Figures of many cases, a row for each. As a sequence it is that of the rows.

    Attributes
    ----------
    rows : tuple of dict
        `ContactResult.summary` of each case, with its ``name``, its ``loads`` and its ``parameters``, by name.
    contacts : tuple of (str, str)
        Names of the bodies of each contact as given. Forces in columns are on the first of them, whichever is the
        slave.
    units : Units
    maps : tuple of dict
        Fields of the contacts of each case by name, of those that were kept.

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
    maps: tuple[Mapping[str, tuple[FieldMap, ...]], ...] = ()

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

    def to_pandas(self) -> Any:
        """The figures as a pandas DataFrame, a row for each case by its name.

        Raises
        ------
        MissingPackageError
            If pandas is not installed.
        """
        return optional("pandas", "A DataFrame").DataFrame(dict(self.figures), index=list(self.names))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the cases."""
        return tuple(str(row["name"]) for row in self.rows)

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Label of each contact."""
        return contact_labels(self.contacts)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings, each behind the name of its case: ``"gait 3: ..."``."""
        return tuple(f"{row['name']}: {text}" for row in self.rows for text in row["warnings"])

    @cached_property
    def figures(self) -> dict[str, Array]:
        """Columns (n,) of numbers by name: what was given, figures of the contacts, and figures of the solution.

        Given: parameters by their names, loads and poses as ``forces ball z``. Contacts: names of `FIGURES`, with
        several contacts after the label of each, ``femur on tibia: area``; of sides of a plane, ``medial: force_z``. A
        figure that a case has not is NaN; components of loads that are zero in all cases are left out.
        """
        lines = [row_figures(row, self.contacts) for row in self.rows]
        names = dict.fromkeys(name for line in lines for name in line)
        found = {name: np.array([line.get(name, np.nan) for line in lines], float) for name in names}
        idle = {name for row in self.rows for name in row.get("loads", {}) if not found[name].any()}
        return {name: values for name, values in found.items() if name not in idle}

    def with_units(self, units: UnitNames) -> CaseTable:
        """The same numbers with names of units, ``("mm", "N", "MPa")``, where they had others or none.

        Raises
        ------
        InputError
            If they are no names.
        """
        if (given := Units.of(units)) == Units():
            return self
        names = given.with_defaults(self.units)
        return replace(self, units=names, rows=tuple({**row, "units": asdict(names)} for row in self.rows))

    def save(self, path: str | Path, *, units: UnitNames = ()) -> Path:
        """Write the table; the suffix decides.

        .csv (`to_csv`), .json (`to_json`), .jsonl (a row in each line), .pvd (`to_pvd`). With names of `units` heads of
        a .csv have them, and rows of .json and .jsonl an entry ``units``.

        Raises
        ------
        InputError
            For another suffix, or a file that cannot be written.
        """
        path = file_path("the path of a table", path)
        suffix = path.suffix.lower()
        among("suffix of a file of a table", suffix, (*TABLE_FILES, ".pvd"))
        if suffix == ".pvd":
            refuse_units(suffix, units)
            return self.to_pvd(path)
        table = self.with_units(units)
        if suffix == ".jsonl":
            return write_atomically(path, "".join(json.dumps(row) + "\n" for row in table.rows))
        return table.to_csv(path, heads=bool(units)) if suffix == ".csv" else table.to_json(path)

    def to_csv(self, path: str | Path, *, heads: bool = False) -> Path:
        """Write all columns with the names of the cases and their status, a row for each case; `heads` have units."""
        numbers = np.stack(list(self.figures.values()), axis=1).tolist()
        rows = [[row["name"], row["status"], *line] for row, line in zip(self.rows, numbers, strict=True)]
        names = [self.headed(name) if flag("heads", heads) else name for name in self.figures]
        return Table(["case", "status", *names], rows).save(path)

    def to_json(self, path: str | Path) -> Path:
        """Write all rows, ``{"cases": [...]}``."""
        return save_json(path, {"cases": list(self.rows)})

    def to_pvd(self, path: str | Path, over: str | None = None) -> Path:
        """Write the collection of the files .vtu that the cases have written, for ParaView.

        Parameters
        ----------
        path : str or Path
        over : str, optional
            Column that gives the times; ``time`` where there is one, else the cases are numbered.

        Raises
        ------
        InputError
            If a case has no such file, or no time.
        """
        files = [[f for f in row.get("files", ()) if Path(f).suffix.lower() == ".vtu"] for row in self.rows]
        if missing := [name for name, found in zip(self.names, files, strict=True) if not found]:
            raise InputError(f"Case {missing[0]!r} has written no .vtu file: sweep with save='NAME_{{name}}.vtu'.")
        over = "time" if over is None and "time" in self.figures else over
        times = np.arange(len(self), dtype=float) if over is None else self.column(over)
        if not np.isfinite(times).all():
            raise InputError(f"Not all cases have a figure {over!r}, which is to be the time.", code="unknown-figure")
        return write_collection(check_writable(path), [Path(found[-1]) for found in files], times.tolist())

    def plot(
        self,
        *quantities: str,
        over: str | None = None,
        path: str | Path | None = None,
        units: UnitNames = (),
        ax: Axes | None = None,
    ) -> Figure:
        """Draw columns over the cases or over another column, a panel for each; a matplotlib figure.

        Parameters
        ----------
        *quantities : str
            Columns, or figures of all contacts and sides, such as "max_pressure"; force, area and largest pressure
            unless given.
        over : str, optional
            Column of the horizontal axis, such as a parameter; the cases in their order unless given.
        path : str or Path, optional
            File to write; the suffix decides the format.
        units : (length, force) or (length, force, stress), optional
            Names for labels; those of the scene unless given.
        ax : matplotlib Axes, optional
            Where to draw one quantity.

        Raises
        ------
        InputError
            If there is no such column, or no case, or axes are given and several quantities.
        """
        from fecontact.results.pictures.case_pictures import plot_columns

        if not self.rows:
            raise InputError("There are no cases to draw.", code="no-cases")
        chosen = texts("the quantities", quantities) or ("force", "area", "max_pressure")
        named = self.with_units(units)
        panels = {named.headed(name).replace("_", " "): self._curves(name) for name in chosen}
        label, place = ("", np.arange(len(self), dtype=float)) if over is None else (over, self.column(over))
        return plot_columns(panels, (label and named.headed(label), place), self.names, path, ax)

    def _curves(self, name: str) -> dict[str, Array]:
        """Columns of a figure: that of this name, or those of all contacts and sides."""
        found = {c: values for c, values in self.figures.items() if c == name or c.endswith(f": {name}")}
        if not found:
            among("column", name, self.figures)
        return {c.removesuffix(f": {name}") if c != name else "whole": values for c, values in found.items()}

    def fields(
        self, what: str = "pressure", contact: int = 0, cases: Sequence[int | str] | None = None
    ) -> list[FieldMap]:
        """Fields of a contact that were kept, one for each case.

        Parameters
        ----------
        what : {'pressure', 'gap', 'friction'}
        contact : int
            Number of the contact in the scene.
        cases : sequence of int or str, optional
            Numbers or names; all unless given.

        Raises
        ------
        InputError
            If there is no such contact or case, or the field was not kept.
        """
        among("field of a contact", what, FIELDS)
        whole("the number of the contact", contact, 0, len(self.contacts) - 1)
        out = []
        for k in self._numbers(cases):
            kept = self.maps[k] if self.maps else {}
            if what not in kept:
                raise InputError(
                    f"The {what} of case {self.names[k]!r} is not in memory: sweep with keep=({what!r},). Cases that "
                    "were finished in an earlier run, whose rows come from a file, have none.",
                    code="not-kept",
                )
            out.append(kept[what][contact])
        return out

    def _numbers(self, cases: Sequence[int | str] | None) -> list[int]:
        """Numbers of some cases."""
        given = range(len(self)) if cases is None else items("cases", cases, "numbers or names")
        out = []
        for case in given:
            if isinstance(case, str):
                among("case", case, self.names)
            found = self.names.index(case) if isinstance(case, str) else whole("the number of a case", case, 0)
            if found >= len(self):
                raise InputError(f"There is no case {found}; the table has {len(self)} (0, 1, ...).")
            out.append(found)
        if not out:
            raise InputError("No case is to be drawn.")
        return out

    def montage(
        self,
        what: str = "pressure",
        path: str | Path | None = None,
        *,
        contact: int = 0,
        cases: Sequence[int | str] | int | None = None,
        units: UnitNames = (),
    ) -> Figure:
        """Draw the maps of a contact in all cases, with one scale; a matplotlib figure.

        Parameters
        ----------
        what : {'pressure', 'gap', 'friction'}
            A field that was kept, ``scene.sweep(..., keep="pressure")``.
        path : str or Path, optional
            File to write; the suffix decides the format.
        contact : int
            Number of the contact in the scene.
        cases : sequence of int or str, or int, optional
            Numbers or names of the cases, or how many of them, from the first to the last; all unless given.
        units : (length, force) or (length, force, stress), optional
            Names for labels; those of the scene unless given.

        Raises
        ------
        InputError
            If there is no such contact or case, the field was not kept, or there are more cases than fit.
        """
        from fecontact.results.pictures.case_pictures import plot_montage

        chosen = cast("Sequence[int | str] | None", cases)
        if np.isscalar(cases):
            count = min(whole("the number of cases", cases), len(self.rows))
            chosen = np.linspace(0, len(self.rows) - 1, count).round().astype(int).tolist()
        maps, names = self.fields(what, contact, chosen), [self.names[k] for k in self._numbers(chosen)]
        if len(maps) > MAX_MAPS:
            raise InputError(f"{len(maps)} maps do not fit into a picture: choose at most {MAX_MAPS} by cases=.")
        return plot_montage(maps, names, f"{what}, {self.labels[contact]}", self.with_units(units).units, path)

    def animate(
        self,
        path: str | Path,
        what: str = "pressure",
        *,
        contact: int = 0,
        cases: Sequence[int | str] | None = None,
        rate: int = 5,
        units: UnitNames = (),
    ) -> Path:
        """Write the maps of a contact as an animation, a frame for each case: .gif, or .mp4 if ffmpeg is installed.

        Parameters
        ----------
        path : str or Path
        what, contact, cases, units
            As for `montage`.
        rate : int
            Frames per second.

        Raises
        ------
        InputError
            As for `montage`, and for another suffix.
        MissingPackageError
            If ffmpeg is missing for .mp4.
        """
        from fecontact.results.pictures.case_pictures import animate_maps

        among("suffix of an animation", file_path("the path of an animation", path).suffix.lower(), ANIMATIONS)
        maps, names = self.fields(what, contact, cases), [self.names[k] for k in self._numbers(cases)]
        title, shown = f"{what}, {self.labels[contact]}", self.with_units(units).units
        return animate_maps(maps, names, title, shown, check_writable(path), whole("the frames per second", rate))

    @cached_property
    def printed(self) -> Table:
        """The table as it is printed: a row for each case and contact, with what was given and changes."""
        several = len(self.contacts) > 1
        # components of a force are rounding beside its size
        sizes = {name: self.figures.get(name[:-2], v) for name, v in self.figures.items()}
        figures = {name: _rounded(values, sizes[name]) for name, values in self.figures.items()}
        sides = list(dict.fromkeys(s for row in self.rows for c in row["contacts"] for s in c.get("sides", ())))
        printed = [*PRINTED, *(f"{side}: {name}" for side in sides for name in OF_SIDES)]
        given = [name for name in self._given if np.ptp(figures[name]) != 0]  # NaN, in some cases only, shows too
        columns = [Column(name, ".4g", self.unit(name)) for name in (*given, *printed)]
        columns[len(given) : len(given)] = [Column("contact")] if several else []
        rows = [
            (
                *(name, *(figures[column][k] for column in given), *([label] if several else [])),
                *(figures[f"{label}: {figure}" if several else figure][k] for figure in printed),
                int(figures["warnings"][k]),
            )
            for k, name in enumerate(self.names)
            for label in self.labels
        ]
        return Table(["case", *columns, Column("warnings", "d")], rows, self._remarks())

    lines = renamed("lines", "printed", lambda table: lambda: (table.printed.heads, table.printed.cells))

    @property
    def _given(self) -> list[str]:
        """Columns of what was given."""
        told = dict.fromkeys(n for row in self.rows for n in (*row.get("parameters", {}), *row.get("loads", {})))
        return [name for name in told if name in self.figures]

    def unit(self, name: str) -> str:
        """Unit of a column; angles, and parameters of users, have none."""
        first, _, rest = name.partition(" ")
        kind, power = FIGURES.get(name.rpartition(": ")[2], ("", ""))
        if first in GIVEN and rest.split()[-1][0] != "r":
            kind = GIVEN[first]
        return self.units.suffix(kind, power).strip() if kind else ""

    def headed(self, name: str) -> str:
        """A column's name with its unit."""
        return Column(name, unit=self.unit(name)).head

    def __str__(self) -> str:
        return str(self.printed)

    def _remarks(self) -> list[str]:
        """Which forces are meant, and warnings."""
        told = [f"{label}: forces on {one}" for label, (one, _) in zip(self.labels, self.contacts, strict=True)]
        if self.warnings:
            count = sum(bool(row["warnings"]) for row in self.rows)
            told.append(f"{count} of {len(self)} cases have warnings; {self.warnings[0]}")
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
        from fecontact.results.page import table_cell

        return table_cell(self.printed)


def _rounded(values: Array, sizes: Array) -> Array:
    """A column with what is rounding beside the largest of some sizes as zero."""
    return without_rounding(values, float(np.nanmax(np.abs(sizes), initial=0.0)))


def _range(values: Array) -> str:
    low, high = f"{values.min():.4g}", f"{values.max():.4g}"
    return low if low == high else f"{low} to {high}"
