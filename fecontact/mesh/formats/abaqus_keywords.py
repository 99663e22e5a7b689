"""Keywords of Abaqus and CalculiX input files with their parameters and data lines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fecontact.common.errors import MeshError

#: Keywords of Abaqus and CalculiX that generate or move nodes and elements. (*TRANSFORM rotates loads and supports
#: only.)
GENERATORS = {
    "SYSTEM",
    "NGEN",
    "NFILL",
    "NCOPY",
    "NMAP",
    "ELGEN",
    "ELCOPY",
    "SYMMETRIC MODEL GENERATION",
    "IMPORT",
    "REFINE MESH",
}
#: Keywords whose data may be in another file.
LISTS = {"NODE", "ELEMENT", "NSET", "ELSET", "SURFACE"}


@dataclass(frozen=True)
class KeywordSection:
    """A keyword with its parameters (names in capitals), data lines, and its place: ``file, line 12``."""

    keyword: str
    parameters: dict[str, str]
    lines: list[str]
    place: str = ""


def read_sections(path: Path) -> Iterator[KeywordSection]:
    """Keywords of a file in order, with included files expanded."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise MeshError(f"{path} could not be read: {error.strerror}.") from error
    keyword, lines = "", []
    parameters: dict[str, str] = {}
    place = ""
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith("**") or not line.strip():
            continue
        if not line.startswith("*"):
            lines.append(line.strip())
            continue
        if keyword:
            yield KeywordSection(keyword, parameters, lines, place)
        place = f"{path.name}, line {number}"
        head, *rest = line[1:].split(",")
        keyword, lines = " ".join(head.upper().split()), []
        pairs = [item.partition("=") for item in rest if item.strip()]
        parameters = {name.strip().upper(): value.strip().strip('"') for name, _, value in pairs}
        if keyword == "INCLUDE":
            yield from read_sections(path.parent / parameters.get("INPUT", ""))
            keyword = ""
    if keyword:
        yield KeywordSection(keyword, parameters, lines, place)


def one_spelling(sections: list[KeywordSection]) -> list[KeywordSection]:
    """Names of sets and surfaces in their first spelling: these files ignore case."""
    first: dict[tuple[str, str], str] = {}
    out = []
    for s in sections:
        given = dict(s.parameters)
        for name in ("ELSET", "NSET", "NAME"):
            if name in given and (name != "NAME" or s.keyword == "SURFACE"):
                given[name] = first.setdefault((name, given[name].upper()), given[name])
        out.append(replace(s, parameters=given))
    return out


def refuse_generated(sections: list[KeywordSection]) -> None:
    """Refuse keywords that generate or move nodes and elements, which would be missing or misplaced.

    Raises
    ------
    MeshError
        Names the keyword and its line.
    """
    for s in sections:
        system = s.parameters.get("SYSTEM", "R").upper() if s.keyword == "NODE" else "R"
        listed = [p for p in ("INPUT", "FILE", "OFFSET") if p in s.parameters and s.keyword in LISTS]
        if s.keyword in GENERATORS:
            what, why = f"*{s.keyword}", "makes or moves nodes or elements"
        elif system != "R":
            what, why = f"*NODE, SYSTEM={system}", "gives cylindrical or spherical coordinates"
        elif listed:
            what, why = f"*{s.keyword}, {listed[0]}=", "takes data from elsewhere or renumbers them"
        else:
            continue
        raise MeshError(
            f"{s.place}: {what} {why}, which is not done here. Write the mesh out in full: plain *NODE and *ELEMENT."
        )


def table(lines: list[str], columns: int, dtype: type) -> NDArray:
    """Rows of numbers; a row may run over several lines."""
    text = ",".join(line.rstrip(",") for line in lines)
    values: NDArray = np.array([v for v in text.replace(" ", "").split(",") if v], dtype=dtype)
    if len(values) % columns:
        raise MeshError(
            f"A block that begins with {lines[0]!r} has {len(values)} numbers, no multiple of the {columns} that a row "
            "needs. The file is damaged or of another element type than it says."
        )
    return values.reshape(-1, columns)
