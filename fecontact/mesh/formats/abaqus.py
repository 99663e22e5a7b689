"""Abaqus and CalculiX .inp files: nodes, elements, and sets and surfaces with their names."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fecontact.errors import MeshError
from fecontact.mesh.formats.raw import RawMesh, numbers_of
from fecontact.mesh.kinds import KINDS

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Solid elements: our kind by the digits after C3D; letters after them (R, H, I, M, ...) change no geometry.
SOLIDS = {
    "4": "tet4",
    "10": "tet10",
    "5": "pyramid5",
    "13": "pyramid13",
    "6": "wedge6",
    "15": "wedge15",
    "8": "hex8",
    "20": "hex20",
    "27": "hex27",
}
#: Surface elements: number of nodes by type; the letters R, T, H after it are dropped.
SURFACE_ELEMENTS = {"3": 3, "4": 4, "6": 6, "8": 8, "65": 6}
_SURFACE_PREFIXES = ("STRI", "SFM3D", "M3D", "R3D", "CPS", "CPE", "S")
#: Local face of the hexahedron for S1, S2, ... of each shape (our faces: -x, +x, -y, +y, -z, +z).
FACES = {
    "hex": (4, 5, 2, 1, 3, 0),
    "wedge": (4, 5, 2, 1, 0),
    "pyramid": (4, 2, 1, 3, 0),
    "tet": (4, 2, 1, 0),
}


@dataclass(frozen=True)
class Section:
    """A keyword with its parameters (names in capitals) and data lines."""

    keyword: str
    parameters: dict[str, str]
    lines: list[str]


@dataclass(frozen=True, eq=False)
class _Deck:
    """Numbers of a deck: nodes, elements and sets, each by the file's own numbers."""

    node_ids: IntArray
    points: Array
    element_ids: IntArray
    kinds: list[str]
    source: str


def read_abaqus(path: Path) -> RawMesh:
    """Read an input file: flat, or with one part that stands where it was drawn.

    Raises
    ------
    MeshError
        If the file has several parts, unknown elements, broken numbers or missing references.
    """
    sections = _flat(list(_sections(path)), path.name)
    try:
        return _mesh(sections, path.name)
    except (ValueError, IndexError) as error:
        if isinstance(error, MeshError):
            raise
        raise MeshError(f"{path.name} holds a line that cannot be read: {error}.") from error


def _sections(path: Path) -> Iterator[Section]:
    """Keywords of a file in their order, included files in place."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise MeshError(f"{path} could not be read: {error.strerror}.") from error
    keyword, lines = "", []
    parameters: dict[str, str] = {}
    for line in text.splitlines():
        if line.startswith("**") or not line.strip():
            continue
        if not line.startswith("*"):
            lines.append(line.strip())
            continue
        if keyword:
            yield Section(keyword, parameters, lines)
        head, *rest = line[1:].split(",")
        keyword, lines = " ".join(head.upper().split()), []
        pairs = [item.partition("=") for item in rest if item.strip()]
        parameters = {name.strip().upper(): value.strip().strip('"') for name, _, value in pairs}
        if keyword == "INCLUDE":
            yield from _sections(path.parent / parameters.get("INPUT", ""))
            keyword = ""
    if keyword:
        yield Section(keyword, parameters, lines)


def _flat(sections: list[Section], source: str) -> list[Section]:
    """Take the single part of an assembly, with the sets that the assembly defines on it."""
    n_parts = sum(s.keyword == "PART" for s in sections)
    moved = any(s.keyword == "INSTANCE" and s.lines for s in sections)
    if n_parts > 1 or moved:
        raise MeshError(
            f"{source} has {n_parts} parts{' placed by *INSTANCE' if moved else ''}; expected a flat file or one part "
            "that is not moved. Write it without parts and instances, or each part to a file of its own."
        )
    if n_parts == 0:
        return sections
    end = next(k for k, s in enumerate(sections) if s.keyword == "END PART")
    later = [s for s in sections[end:] if "INSTANCE" in s.parameters or s.keyword == "SURFACE"]
    return sections[:end] + later


def _mesh(sections: list[Section], source: str) -> RawMesh:
    nodes = [_table(s.lines, 4, float) for s in sections if s.keyword == "NODE"]
    table = np.concatenate(nodes) if nodes else np.zeros((0, 4))
    if not len(table):
        raise MeshError(f"{source} defines no nodes (*NODE).")
    node_ids = table[:, 0].astype(np.int64)
    blocks: list[tuple[str, IntArray]] = []
    kinds: list[str] = []
    element_ids: list[IntArray] = []
    facets: dict[str, list[IntArray]] = {}
    groups: dict[str, list[IntArray]] = {}
    for section in (s for s in sections if s.keyword == "ELEMENT"):
        kind, n_nodes = _kind(section.parameters.get("TYPE", ""), source)
        if n_nodes == 0:
            continue
        rows = _table(section.lines, n_nodes + 1, int)
        cells = numbers_of(node_ids, rows[:, 1:], "node", source)
        name = section.parameters.get("ELSET")
        if kind == "facet":
            facets.setdefault(name or "surface", []).append(cells[:, : 3 if n_nodes in (3, 6) else 4])
            continue
        start = len(kinds)
        blocks.append((kind, cells))
        kinds += [kind] * len(rows)
        element_ids.append(rows[:, 0])
        if name:
            groups.setdefault(name, []).append(start + np.arange(len(rows)))
    all_elements = np.concatenate(element_ids) if element_ids else np.zeros(0, np.int64)
    deck = _Deck(node_ids, table[:, 1:], all_elements, kinds, source)
    sets = _element_sets(sections, deck, {k: np.concatenate(v) for k, v in groups.items()}, set(facets))
    node_sets = _node_sets(sections, deck, blocks, sets)
    faces, open_sets = _surfaces(sections, deck, sets, node_sets)
    return RawMesh(deck.points, blocks, sets, facets, faces, {**node_sets, **open_sets})


def _table(lines: list[str], columns: int, dtype: type) -> NDArray:
    """Rows of numbers; a row may run over several lines."""
    text = ",".join(line.rstrip(",") for line in lines)
    values: NDArray = np.array([v for v in text.replace(" ", "").split(",") if v], dtype=dtype)
    if len(values) % columns:
        raise MeshError(
            f"A block that begins with {lines[0]!r} has {len(values)} numbers, no multiple of the {columns} that a row "
            "needs. The file is damaged or of another element type than it says."
        )
    return values.reshape(-1, columns)


def _kind(name: str, source: str) -> tuple[str, int]:
    """Our kind and number of nodes of an element type; ('facet', n) for surfaces, ('', 0) for lines and points."""
    upper = name.upper()
    if upper.startswith("C3D"):
        digits = "".join(c for c in upper[3:] if c.isdigit())
        if digits in SOLIDS:
            return SOLIDS[digits], KINDS[SOLIDS[digits]].n_nodes
        raise MeshError(f"{source} holds elements of the type {name!r}; expected C3D with {', '.join(SOLIDS)} nodes.")
    for prefix in _SURFACE_PREFIXES:
        digits = "".join(c for c in upper.removeprefix(prefix) if c.isdigit())
        if upper.startswith(prefix) and digits in SURFACE_ELEMENTS:
            return "facet", SURFACE_ELEMENTS[digits]
    return "", 0


def _listed(section: Section, sets: dict[str, IntArray], ids: IntArray, what: str, source: str) -> IntArray:
    """Members of a set: numbers, ranges (GENERATE) or names of other sets."""
    if "GENERATE" in section.parameters:
        rows = [[int(v) for v in line.split(",") if v.strip()] for line in section.lines]
        ranges = [np.arange(r[0], r[1] + 1, r[2] if len(r) > 2 else 1) for r in rows]
        return numbers_of(ids, np.concatenate([np.zeros(0, np.int64), *ranges]), what, source)
    items = [v.strip() for line in section.lines for v in line.split(",") if v.strip()]
    known = {k.upper(): v for k, v in sets.items()}
    numbers = np.array([int(v) for v in items if v.lstrip("-").isdigit()], dtype=np.int64)
    names = [v for v in items if not v.lstrip("-").isdigit()]
    for name in names:
        if name.upper() not in known:
            raise MeshError(f"{source}: a set names the {what} set {name!r}, which does not exist before it.")
    return np.concatenate(
        [numbers_of(ids, numbers, what, source), *(known[v.upper()] for v in names)]
        if len(numbers)
        else [np.zeros(0, np.int64), *(known[v.upper()] for v in names)]
    )


def _element_sets(
    sections: list[Section], deck: _Deck, sets: dict[str, IntArray], surfaces: set[str]
) -> dict[str, IntArray]:
    """Sets of solid elements; sets of surface elements have been taken as surfaces already."""
    out = dict(sets)
    for s in sections:
        name = s.parameters.get("ELSET", "")
        if s.keyword != "ELSET" or name in surfaces:
            continue
        members = _listed(s, out, deck.element_ids, "element", deck.source)
        out[name] = np.union1d(out.get(name, np.zeros(0, np.int64)), members)
    return out


def _node_sets(
    sections: list[Section], deck: _Deck, blocks: list[tuple[str, IntArray]], sets: dict[str, IntArray]
) -> dict[str, IntArray]:
    out: dict[str, IntArray] = {}
    of_nodes = {s.parameters["NSET"]: s for s in sections if s.keyword == "NODE" and "NSET" in s.parameters}
    for name, s in of_nodes.items():
        ids = _table(s.lines, 4, float)[:, 0].astype(np.int64)
        out[name] = numbers_of(deck.node_ids, ids, "node", deck.source)
    for s in (s for s in sections if s.keyword == "NSET"):
        name = s.parameters.get("NSET", "")
        if "ELSET" in s.parameters:
            members = _nodes_of(sets.get(s.parameters["ELSET"], np.zeros(0, np.int64)), blocks)
        else:
            members = _listed(s, out, deck.node_ids, "node", deck.source)
        out[name] = np.union1d(out.get(name, np.zeros(0, np.int64)), members)
    return out


def _nodes_of(elements: IntArray, blocks: list[tuple[str, IntArray]]) -> IntArray:
    nodes, start = [np.zeros(0, np.int64)], 0
    for _, cells in blocks:
        inside = elements[(elements >= start) & (elements < start + len(cells))] - start
        nodes.append(cells[inside].ravel())
        start += len(cells)
    return np.unique(np.concatenate(nodes))


def _surfaces(
    sections: list[Section], deck: _Deck, sets: dict[str, IntArray], node_sets: dict[str, IntArray]
) -> tuple[dict[str, IntArray], dict[str, IntArray]]:
    """Surfaces as (cell, local face) and those that are given by nodes."""
    faces: dict[str, IntArray] = {}
    by_nodes: dict[str, IntArray] = {}
    known = {k.upper(): v for k, v in sets.items()}
    for s in (s for s in sections if s.keyword == "SURFACE"):
        name = s.parameters.get("NAME", "surface")
        if s.parameters.get("TYPE", "ELEMENT").upper() == "NODE":
            by_nodes[name] = _listed(
                Section("", {}, [x.split(",")[0] for x in s.lines]), node_sets, deck.node_ids, "node", deck.source
            )
            continue
        parts = []
        for line in s.lines:
            member, _, label = (v.strip() for v in line.partition(","))
            label = label.split(",")[0].strip().upper()
            if member.isdigit():
                cells = numbers_of(deck.element_ids, np.array([int(member)]), "element", deck.source)
            elif member.upper().split(".")[-1] in known:
                cells = known[member.upper().split(".")[-1]]
            else:
                raise MeshError(f"{deck.source}: surface {name!r} names the element set {member!r}, which is missing.")
            parts.append(np.stack([cells, [_face(deck.kinds[c], label, name) for c in cells.tolist()]], axis=1))
        faces[name] = np.concatenate(parts) if parts else np.zeros((0, 2), np.int64)
    return faces, by_nodes


def _face(kind: str, label: str, name: str) -> int:
    """Local face of the hexahedron of a face label S1, S2, ..."""
    faces = FACES[kind.rstrip("0123456789")]
    if not (label[:1] == "S" and label[1:].isdigit() and 1 <= int(label[1:]) <= len(faces)):
        raise MeshError(f"Surface {name!r} names the face {label!r} of a {kind} cell; expected S1 ... S{len(faces)}.")
    return faces[int(label[1:]) - 1]
