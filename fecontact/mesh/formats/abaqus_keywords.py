"""Keywords of Abaqus and CalculiX input files with their parameters and data lines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fecontact.common.errors import MeshError

#: Keywords of Abaqus and CalculiX that generate or move nodes and elements. (*TRANSFORM rotates loads and supports
#: only, *REFINE MESH meshes anew from results of a step.)
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
    """Keywords of a file in order, with included files expanded.

    A keyword line that ends with a comma goes on in the next line; lines may be indented. A file to be included that
    is missing becomes a section *INCLUDE (see `missing_files`).

    Raises
    ------
    MeshError
        If the file cannot be read, or files include each other in a circle.
    """
    yield from _sections(path, ())


def _sections(path: Path, within: tuple[Path, ...]) -> Iterator[KeywordSection]:
    if path.resolve() in within:
        raise MeshError(f"{within[-1].name} includes {path.name}, which includes it: a circle without an end.")
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise MeshError(f"{path} could not be read: {error.strerror}.") from error
    head, place = "", ""
    lines: list[str] = []
    for number, line in enumerate(map(str.strip, text.splitlines()), start=1):
        if line.startswith("**") or not line:
            continue
        if head.endswith(",") and not lines and ("=" in line or line.upper() == "GENERATE"):
            head += line
        elif not line.startswith("*"):
            lines.append(line)
        else:
            yield from _section(path, head, lines, place, within)
            head, lines, place = line, [], f"{path.name}, line {number}"
    yield from _section(path, head, lines, place, within)


def _section(path: Path, head: str, lines: list[str], place: str, within: tuple[Path, ...]) -> Iterator[KeywordSection]:
    """The keyword of a line with its data, or those of the file that it includes; none of an empty line."""
    keyword, *rest = head[1:].split(",")
    keyword = " ".join(keyword.upper().split())
    pairs = [item.partition("=") for item in rest if item.strip()]
    parameters = {" ".join(name.upper().split()): value.strip().strip('"') for name, _, value in pairs}
    included = path.parent / parameters.get("INPUT", "")
    if keyword == "INCLUDE" and included.is_file():
        yield from _sections(included, (*within, path.resolve()))
    elif keyword:
        yield KeywordSection(keyword, parameters, lines, place)


def missing_files(sections: list[KeywordSection]) -> tuple[str, ...]:
    """Files that are included but missing, each with its place."""
    return tuple(f"{s.parameters.get('INPUT', '')} ({s.place})" for s in sections if s.keyword == "INCLUDE")


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


def numbers(lines: list[str], dtype: type) -> NDArray:
    """All numbers of data lines; ``1.0D0`` is read as 1.0e0.

    Raises
    ------
    ValueError
        Names what is no number.
    """
    text = ",".join(line.rstrip(",") for line in lines).replace(" ", "").replace("\t", "")
    if dtype is float:
        text = text.upper().replace("D", "E")
    return np.array([v for v in text.split(",") if v], dtype=dtype)


def values_of(line: str) -> list[float]:
    """Numbers of a data line in their places, zero where blank; ``1.0D0`` is read as 1.0e0.

    Examples
    --------
    >>> values_of(" , 2.5D0, ,1e5,")
    [0.0, 2.5, 0.0, 100000.0]
    """
    words = [word.strip().upper().replace("D", "E") for word in line.split(",")]
    return [float(word or 0) for word in (words if words[-1] else words[:-1])]


def coordinates(section: KeywordSection) -> NDArray:
    """Rows (n, 4) of *NODE: number and coordinates. What is blank or left out is zero; what follows is not read."""
    counts = np.array([line.count(",") for line in section.lines])
    if (counts == 3).all() and not any(",," in line.replace(" ", "").rstrip(",") for line in section.lines):
        values = numbers(section.lines, float)
        if len(values) == 4 * len(counts):
            return values.reshape(-1, 4)
    rows = [[v.strip() or "0" for v in line.upper().replace("D", "E").split(",")] for line in section.lines]
    return np.array([[*row, "0", "0", "0"][:4] for row in rows], dtype=float).reshape(-1, 4)


def connectivity(section: KeywordSection, columns: int) -> tuple[NDArray[np.int64], int]:
    """Rows (n, columns) of *ELEMENT, number and nodes, over one line or several, and how many numbers follow them.

    Numbers beyond the last node of a row are not read: the extra nodes that some programs write for incompatible modes
    or in the middle of faces.

    Raises
    ------
    MeshError
        If the last row is incomplete.
    """
    counts = np.array([line.rstrip(", \t").count(",") + 1 for line in section.lines])
    values, end = numbers(section.lines, int), np.cumsum(counts)
    ends = np.array([not line.endswith(",") for line in section.lines])
    if len(values) % columns == 0 and np.isin(np.arange(columns, len(values) + 1, columns), end).all():
        return values.reshape(-1, columns), 0
    joined = np.add.reduceat(counts, np.append(0, np.flatnonzero(ends) + 1)[: ends.sum()]) if ends[-1] else counts[:0]
    one_row = len(joined) > 1 or (joined < 2 * columns).all()
    if len(joined) and len(values) == end[-1] and columns <= joined[0] and one_row and (joined == joined[0]).all():
        # a row ends where a line has no comma at its end, with all its surplus
        return values.reshape(-1, joined[0])[:, :columns], len(joined) * int(joined[0] - columns)
    starts, at, broken = [], 0, len(values) != end[-1]
    for line, line_end in zip(section.lines, end.tolist(), strict=True):
        if line_end - at >= columns:
            starts.append(at)
            at = line_end
        broken |= at < line_end and not line.endswith(",")
    if at < len(values) or broken:
        raise MeshError(
            f"{section.place}: a block that begins with {section.lines[0]!r} has {len(values)} numbers, no multiple of "
            f"the {columns} that a row needs. The file is damaged or of another element type than it says."
        )
    return values[np.array(starts)[:, None] + np.arange(columns)], len(values) - columns * len(starts)
