"""Output files of a scene file: checked before the solve, written afterwards."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from fecontact.app.scene_file.toml_table import Arguments, Table, choice, did_you_mean, flag, listed, number, numbers
from fecontact.common.files import check_writable, save_json, write_atomically
from fecontact.results.case_table import TABLE_FILES
from fecontact.results.result import ContactResult

PICTURES = (".png", ".svg", ".pdf")
#: Fields that [outputs] can draw on the bodies; those of the contacts are 'pressure', 'gap', 'friction'.
BODY_PICTURES = ("von_mises", "contact_pressure", "displacement")
CONTACT_PICTURES = ("pressure", "gap", "friction")
FILES = {
    "vtu": (".vtu",),
    "json": (".json",),
    "csv": (".csv",),
    "table": (".txt", ".md", ".log"),
    "report": (".html", ".htm"),
}


@dataclass(frozen=True)
class Output:
    """A file to be written: what, where, and options of a picture."""

    kind: str
    path: Path
    options: Mapping[str, Any]


def unknown_body(name: str, bodies: Mapping[str, Any]) -> str:
    """Message about an unknown body."""
    return f"unknown body {name!r}{did_you_mean(name, bodies)}; the bodies are: {listed(bodies)}."


def read_outputs(table: Table, folder: Path, bodies: Mapping[str, Any], sweep: bool) -> tuple[Output, ...]:
    """The requested files, checked to be writable; for a sweep, a table of its cases only."""
    out: list[Output] = []
    taken: dict[Path, str] = {}
    if sweep and (others := sorted(set(table.values) - {"cases"})):
        table.fault(others[0], "belongs to a single case; a sweep has cases (.csv, .json, .jsonl) as its output.")
    if not sweep and "cases" in table:
        table.fault("cases", "needs the cases of a sweep, [[cases]].")
    for kind in ("cases",) if sweep else (*FILES, *CONTACT_PICTURES, *BODY_PICTURES):
        if kind not in table:
            table.raw(kind)
            continue
        nested = kind not in (*FILES, "cases") and isinstance(table.values[kind], dict)
        entry, key = (table.table(kind), "file") if nested else (table, kind)
        file = entry.text(key, required=True)
        options = _picture_options(entry, kind, bodies) if nested else {}
        if file is None:
            continue
        path = folder / file
        suffixes = TABLE_FILES if sweep else FILES.get(kind, PICTURES)
        if path.suffix.lower() not in suffixes:
            entry.fault(key, f"must end in {' or '.join(suffixes)}; found {file!r}.")
        elif path in taken:
            entry.fault(key, f"names the same file as {taken[path]}.")
        else:
            entry.attempt(partial(check_writable, path), key)
            taken[path] = kind
            out.append(Output(kind, path, options))
    for kind in table.values if sweep or "cases" in table else ():
        table.raw(kind)
    table.finish()
    return tuple(out)


def _picture_options(table: Table, kind: str, bodies: Mapping[str, Any]) -> dict[str, Any]:
    """Options of a picture: of `plot_contacts` or of `view`."""
    found = table.read(OF_CONTACTS if kind in CONTACT_PICTURES else OF_BODIES)
    for name in found.get("bodies", ()):
        if name not in bodies:
            table.fault("bodies", unknown_body(name, bodies))
    table.finish()
    return found


def _scale(table: Table, key: str, required: bool) -> Any:
    given = table.values.get(key)
    return table.text(key, ("auto",), required) if isinstance(given, str) else table.number(key, required)


def _direction(table: Table, key: str, required: bool) -> Any:
    from fecontact.mesh.picture import VIEWS

    given = table.values.get(key)
    return table.numbers(key, 2, required) if isinstance(given, list) else table.text(key, tuple(VIEWS), required)


def _cut(table: Table, key: str, required: bool) -> str | None:
    from fecontact.results.pictures.solids import CUT

    where = table.text(key, required=required)
    if where is not None and not CUT.fullmatch(where):
        table.fault(key, f"reads like 'x<0' or 'z>12.5'; found {where!r}.")
    return where


#: Options of pictures of the contacts, see `plot_contacts`, and of bodies, see `plot_solids`.
OF_CONTACTS: Arguments = {"style": choice(("smooth", "sensels")), "pitch": number}
OF_BODIES: Arguments = {
    "scale": _scale,
    "view": _direction,
    "bodies": Table.texts,
    "cut": _cut,
    "limits": numbers(2),
    "edges": flag,
}


def write_output(output: Output, result: ContactResult, summary: Mapping[str, Any]) -> Path:
    """Write one output; `summary` is for a JSON file."""
    if output.kind == "json":
        return save_json(output.path, dict(summary))
    if output.kind == "report":
        return result.report(output.path, title=str(summary["title"]) or "Contact of bodies")
    if output.kind == "table":
        return write_atomically(output.path, f"{result}\n")
    if output.kind in FILES:
        return result.save(output.path)
    result.plot(output.kind, output.path, **output.options)
    return output.path
