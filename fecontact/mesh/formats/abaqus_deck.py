"""One mesh of an Abaqus or CalculiX input file: a flat file, or the lines between *PART and *END PART.

Keywords of Abaqus and CalculiX input files with their parameters and data lines.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import index_array
from fecontact.common.errors import MeshError
from fecontact.mesh.formats.raw import RawMesh, joined_numbers, known_members, numbers_of
from fecontact.mesh.kinds import KINDS

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

    @property
    def items(self) -> list[str]:
        """Words of all data lines."""
        return [word.strip() for line in self.lines for word in line.split(",") if word.strip()]


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


#: Solid elements: kind of cell by the digits after C3D (DC3D: of heat transfer); letters after them (R, H, I, M, ...)
#: do not change the geometry.
SOLIDS = {str(kind.n_nodes): kind for kind in KINDS.values()}
_SOLID = re.compile(r"D?C3D(\d+)[A-Z]*$")
#: Shells, membranes, rigid and plane elements: number of nodes by type; the letters R, T, H after it are dropped.
SHELLS = {"3": 3, "4": 4, "6": 6, "8": 8, "9": 9, "65": 6}
_SHELL = re.compile(r"(?:STRI|SFM3D|M3D|R3D|DS|SC|CPS|CPE|CAX|DC2D|S)(\d+)[A-Z]*$")
#: Kinds of plane elements (CPS, CPE, CAX) by their number of nodes.
SHEETS = {3: "tri3", 4: "quad4", 6: "tri6", 8: "quad8"}
SHEET = re.compile(r"(CPS|CPE|CAX)([3468])[RIHM]*$")
#: Local face of the hexahedron for S1, S2, ... of each shape (its faces: -x, +x, -y, +y, -z, +z).
FACES = {
    "hex": (4, 5, 2, 1, 3, 0),
    "wedge": (4, 5, 2, 1, 0),
    "pyramid": (4, 2, 1, 3, 0),
    "tet": (4, 2, 1, 0),
    # sides of sections, of which a triangle has its last corner twice
    "quad": (0, 1, 2, 3),
    "tri": (0, 1, 3),
}


@dataclass(frozen=True, eq=False)
class Deck:
    """A mesh, and what sets and surfaces of the file may refer to.

    Attributes
    ----------
    raw : RawMesh
    source : str
        Name of the file.
    others : int array
        Numbers of elements that are not solid.
    other_names : frozenset of str
        Names, in capitals, of element sets that are not solid.
    """

    raw: RawMesh
    source: str
    others: IntArray
    other_names: frozenset[str] = frozenset()

    def ids(self, what: str) -> IntArray:
        """The file's numbers of the points ('node') or of the solid cells ('element')."""
        found = self.raw.node_ids if what == "node" else self.raw.element_ids
        return joined_numbers([]) if found is None else found

    @cached_property
    def kinds(self) -> NDArray[np.str_]:
        """Kind of each solid cell (n_cells,)."""
        kinds = np.array([kind for kind, _ in self.raw.blocks], dtype=np.str_)
        return np.repeat(kinds, np.array([len(cells) for _, cells in self.raw.blocks], dtype=np.int64))


def read_deck(sections: list[KeywordSection], source: str, plane: bool = False) -> Deck:
    """Mesh from keywords, or the plane one of CPS, CPE and CAX; shells and others are left out and counted.

    Raises
    ------
    MeshError
        If there are no nodes, or broken numbers or missing nodes.
    """
    node_ids, points = _nodes(sections, source)
    blocks: list[tuple[str, IntArray]] = []
    element_ids: list[IntArray] = []
    others: list[IntArray] = []
    shells: dict[str, list[IntArray]] = {}
    groups: dict[str, list[IntArray]] = {}
    left: dict[str, int] = {}
    other_names: set[str] = set()
    shell_rows = [np.zeros((0, 5), np.int64)]
    sheets: list[tuple[str, str, IntArray]] = []
    for section in (s for s in sections if s.keyword == "ELEMENT" and s.lines):
        kind, n_nodes = _kind(section.parameters.get("TYPE", ""), plane)
        name = section.parameters.get("ELSET")
        if n_nodes == 0:
            others.append(_first_numbers(section))
            _count(left, f"elements of type {section.parameters.get('TYPE', '').upper()}", len(others[-1]))
            other_names.add((name or "").upper())
            continue
        rows, surplus = connectivity(section, n_nodes + 1)
        if surplus:
            _count(left, f"further nodes of elements of type {section.parameters['TYPE'].upper()}", surplus)
        cells = numbers_of(node_ids, rows[:, 1:], "node", source)
        if kind == "shell":
            others.append(rows[:, 0])
            other_names.add((name or "").upper())
            facets = cells[:, [0, 1, 2, 2 if n_nodes in (3, 6) else 3]]
            shells.setdefault(name or section.parameters["TYPE"], []).append(facets)
            if n_nodes in SHEETS and section.parameters["TYPE"].upper().startswith("C"):
                sheets.append((name or section.parameters["TYPE"], SHEETS[n_nodes], cells))
            shell_rows.append(np.concatenate([rows[:, :1], facets], axis=1))
            continue
        if name:
            start = sum(map(len, element_ids))
            groups.setdefault(name, []).append(start + np.arange(len(rows)))
        blocks.append((kind, cells))
        element_ids.append(rows[:, 0])
    _shell_sets(sections, np.concatenate(shell_rows), shells)
    all_elements = joined_numbers(element_ids)
    _refuse_other_elements(all_elements, blocks, source)
    sets = {k: np.concatenate(v) for k, v in groups.items()}
    raw = RawMesh(
        points, blocks, sets, shells=shells, left=left, sheets=sheets, node_ids=node_ids, element_ids=all_elements
    )
    deck = Deck(raw, source, joined_numbers(others), frozenset(other_names))
    sets = _element_sets(sections, deck)
    deck = replace(deck, raw=replace(deck.raw, groups=sets))
    node_sets = _node_sets(sections, deck)
    faces, open_sets = _surfaces(sections, deck, node_sets)
    return replace(deck, raw=replace(deck.raw, faces=faces, node_sets={**node_sets, **open_sets}))


def _nodes(sections: list[KeywordSection], source: str) -> tuple[IntArray, Array]:
    """Numbers (n,) and coordinates (n, 3) of the nodes."""
    nodes = [coordinates(s) for s in sections if s.keyword == "NODE"]
    rows = np.concatenate(nodes) if nodes else np.zeros((0, 4))
    if not len(rows):
        raise MeshError(f"{source} defines no nodes (*NODE).")
    places = [s.place for s in sections if s.keyword == "NODE"]
    owner = np.repeat(np.arange(len(nodes)), [len(n) for n in nodes])
    rows = _defined_once(rows, "node", [places[k] for k in owner])
    return index_array("the numbers of nodes", rows[:, 0]), rows[:, 1:]


def nodes_beside(sections: list[KeywordSection], source: str) -> tuple[IntArray, Array]:
    """Numbers (n,) and coordinates (n, 3) of the nodes of an assembly itself, possibly none."""
    if any(s.keyword == "NODE" and s.lines for s in sections):
        return _nodes(sections, source)
    return joined_numbers([]), np.zeros((0, 3))


def _first_numbers(section: KeywordSection) -> IntArray:
    """Number at the beginning of each row, which goes on after a comma: of elements that are not read."""
    begins = [True, *(not line.endswith(",") for line in section.lines[:-1])]
    first = [line.split(",")[0].strip() for line, new in zip(section.lines, begins, strict=True) if new]
    return np.array([int(v) for v in first if v.isdigit()], dtype=np.int64)


def _count(left: dict[str, int], what: str, number: int) -> None:
    """Add to the number of what was left out."""
    left[what] = left.get(what, 0) + number


def _defined_once(rows: NDArray, what: str, places: Sequence[str]) -> NDArray:
    """Rows without repeats; refused where two of the same number have different values."""
    _, first, inverse = np.unique(rows[:, 0], return_index=True, return_inverse=True)
    first_of = first[inverse.ravel()]
    other = (rows != rows[first_of]).any(axis=1)
    if other.any():
        k = int(np.argmax(other))
        raise MeshError(
            f"{places[k]}: {what} {int(rows[k, 0])} is defined again with other values; it was first defined at "
            f"{places[first_of[k]]}. Leave one of the two out."
        )
    return rows[np.sort(first)]


def _refuse_other_elements(ids: IntArray, blocks: Sequence[tuple[str, IntArray]], source: str) -> None:
    """Refuse elements of one number with different nodes; identical repeats are dropped later."""
    if len(np.unique(ids)) == len(ids):
        return
    width = max(cells.shape[1] for _, cells in blocks)
    rows = np.concatenate([np.pad(c, ((0, 0), (0, width - c.shape[1])), constant_values=-1) for _, c in blocks])
    _defined_once(np.concatenate([ids[:, None], rows], axis=1), "element", [f"{source}, *ELEMENT"] * len(ids))


def _kind(name: str, plane: bool = False) -> tuple[str, int]:
    """Kind of cell and number of nodes of an element type; ('shell', n) for facets, ('', 0) for all others."""
    upper = name.upper()
    if plane:
        flat = SHEET.match(upper)
        return (SHEETS[int(flat[2])], int(flat[2])) if flat else ("", 0)
    if (solid := _SOLID.match(upper)) and solid[1] in SOLIDS:
        return SOLIDS[solid[1]].name, SOLIDS[solid[1]].n_nodes
    if (shell := _SHELL.match(upper)) and shell[1] in SHELLS:
        return "shell", SHELLS[shell[1]]
    return "", 0


def listed(section: KeywordSection, sets: Mapping[str, IntArray], deck: Deck, what: str, name: str) -> IntArray:
    """Members of a set: numbers, ranges (GENERATE) or names of other sets; those that are not read are left out.

    Numbers of a range that are not in use are passed over, other numbers that the file does not define are counted.
    """
    ids, others = deck.ids(what), joined_numbers([]) if what == "node" else deck.others
    if "GENERATE" in section.parameters:
        return _in_ranges(ids, section)
    items = section.items
    known = {k.upper(): v for k, v in sets.items()}
    numbers = np.array([int(v) for v in items if v.lstrip("-").isdigit()], dtype=np.int64)
    parts = [known_members(ids, numbers, others, deck.raw.left, name, what)]
    for member in (v for v in items if not v.lstrip("-").isdigit()):
        if member.upper() in known:
            parts.append(known[member.upper()])
        elif member.upper() not in deck.other_names:
            raise MeshError(f"{deck.source}: a set names the {what} set {member!r}, which does not exist before it.")
    return np.concatenate(parts)


def _in_ranges(ids: IntArray, section: KeywordSection) -> IntArray:
    """Positions of the numbers first, first + step, ..., last of each line in `ids`."""
    parts = []
    for row in ([int(v) for v in line.split(",") if v.strip()] for line in section.lines):
        first, last, step = (*row, 1)[:3] if len(row) > 1 else (row[0], row[0], 1)
        if step < 1:
            raise MeshError(f"{section.place}: GENERATE needs a step of 1 or more; found {step}.")
        parts.append(np.flatnonzero((ids >= first) & (ids <= last) & ((ids - first) % step == 0)))
    return joined_numbers(parts)


def _element_sets(sections: list[KeywordSection], deck: Deck) -> dict[str, IntArray]:
    """Sets of solid elements."""
    out = dict(deck.raw.groups)
    for s in (s for s in sections if s.keyword == "ELSET"):
        name = s.parameters.get("ELSET", "")
        members = listed(s, out, deck, "element", name)
        out[name] = np.union1d(out.get(name, np.zeros(0, np.int64)), members)
    return out


def _shell_sets(sections: list[KeywordSection], rows: IntArray, shells: dict[str, list[IntArray]]) -> None:
    """Add sets of shells, rows (n, 5) of number and corners, to `shells`."""
    names = set(shells)
    for s in (s for s in sections if s.keyword == "ELSET" and len(rows)):
        if "GENERATE" in s.parameters:
            found = np.unique(_in_ranges(rows[:, 0], s))
        else:
            found = np.flatnonzero(np.isin(rows[:, 0], [int(v) for v in s.items if v.isdigit()]))
        name = s.parameters.get("ELSET", "")
        if len(found) and name not in names:
            shells.setdefault(name, []).append(rows[found, 1:])


def _node_sets(sections: list[KeywordSection], deck: Deck) -> dict[str, IntArray]:
    out: dict[str, IntArray] = {}
    for s in (s for s in sections if s.keyword == "NODE" and "NSET" in s.parameters):
        name, ids = s.parameters["NSET"], index_array("the numbers of nodes", coordinates(s)[:, 0])
        out[name] = np.union1d(out.get(name, ids[:0]), numbers_of(deck.ids("node"), ids, "node", deck.source))
    for s in (s for s in sections if s.keyword == "NSET"):
        name = s.parameters.get("NSET", "")
        if "ELSET" in s.parameters:
            members = nodes_of(deck.raw.groups.get(s.parameters["ELSET"], np.zeros(0, np.int64)), deck.raw.blocks)
        else:
            members = listed(s, out, deck, "node", name)
        out[name] = np.union1d(out.get(name, np.zeros(0, np.int64)), members)
    return out


def nodes_of(elements: IntArray, blocks: Sequence[tuple[str, IntArray]]) -> IntArray:
    """Nodes of solid cells, numbered through the blocks."""
    nodes, start = [], 0
    for _, cells in blocks:
        inside = elements[(elements >= start) & (elements < start + len(cells))] - start
        nodes.append(cells[inside].ravel())
        start += len(cells)
    return np.unique(joined_numbers(nodes))


def _surfaces(
    sections: list[KeywordSection], deck: Deck, node_sets: dict[str, IntArray]
) -> tuple[dict[str, IntArray], dict[str, IntArray]]:
    """Surfaces given as (cell, local face), and those given by nodes."""
    faces: dict[str, IntArray] = {}
    by_nodes: dict[str, IntArray] = {}
    known = {k.upper(): v for k, v in deck.raw.groups.items()}
    for s in (s for s in sections if s.keyword == "SURFACE"):
        name = s.parameters.get("NAME", "surface")
        kind = s.parameters.get("TYPE", "ELEMENT").upper()
        if kind == "NODE":
            nodes = KeywordSection("", {}, [x.split(",")[0] for x in s.lines])
            by_nodes[name] = listed(nodes, node_sets, deck, "node", name)
        if kind != "ELEMENT":
            continue  # of nodes, or an analytical surface
        faces[name] = _labelled(s, name, known, deck)
    return faces, by_nodes


def _labelled(section: KeywordSection, name: str, known: Mapping[str, IntArray], deck: Deck) -> IntArray:
    """Faces (n, 2) of a surface by labels; those of shells are counted as left out."""
    parts, missing = [np.zeros((0, 2), np.int64)], 0
    numbers: dict[str, list[int]] = {}
    for member, label in map(member_and_label, section.lines):
        if member.isdigit():
            numbers.setdefault(label, []).append(int(member))
        elif member.upper() in known:
            parts.append(labelled_faces(known[member.upper()], deck.kinds, label, name))
        elif member.upper() in deck.other_names:
            missing += 1
        else:
            raise MeshError(f"{deck.source}: surface {name!r} names the element set {member!r}, which is missing.")
    for label, given in numbers.items():
        cells = known_members(deck.ids("element"), np.array(given), deck.others, deck.raw.left, name, "element")
        parts.append(labelled_faces(cells, deck.kinds, label, name))
        missing += len(given) - len(cells)
    if missing:
        _count(deck.raw.left, f"entries of the surface {name!r} on other elements", missing)
    return np.concatenate(parts)


def member_and_label(line: str) -> tuple[str, str]:
    """Element set or number, and label of the face, of a data line of *SURFACE."""
    member, _, label = (v.strip() for v in line.partition(","))
    return member, label.split(",")[0].strip().upper()


def labelled_faces(cells: IntArray, kinds: NDArray[np.str_], label: str, name: str) -> IntArray:
    """Faces (n, 2) of cells by a label S1, S2, ...; `kinds` are those of all cells.

    Raises
    ------
    MeshError
        If a cell has no such face.
    """
    local = np.zeros(len(cells), np.int64)
    for kind in np.unique(kinds[cells]):
        local[kinds[cells] == kind] = _face(str(kind), label, name)
    return np.stack([cells, local], axis=1)


def _face(kind: str, label: str, name: str) -> int:
    """Local face of the hexahedron of a face label S1, S2, ..."""
    faces = FACES[kind.rstrip("0123456789")]
    if not (label[:1] == "S" and label[1:].isdigit() and 1 <= int(label[1:]) <= len(faces)):
        raise MeshError(f"Surface {name!r} names the face {label!r} of a {kind} cell; expected S1 ... S{len(faces)}.")
    return faces[int(label[1:]) - 1]
