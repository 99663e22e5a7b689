"""Gmsh's .msh files of version 1, 2, 4.0 and 4.1, as text and binary (Gmsh Reference Manual, "Gmsh file formats").

Physical volumes become element sets, physical surfaces boundaries, by their names or as 'volume_5' and 'surface_5'; in
a file without any, those of the geometry.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import index_array
from fecontact.common.errors import MeshError
from fecontact.mesh.formats.raw import RawMesh, joined_numbers, numbers_of

#: Solid cells by gmsh's number: kind and those of its nodes that are used; the others are in faces.
SOLIDS = {
    4: ("tet4", 4),
    5: ("hex8", 8),
    6: ("wedge6", 6),
    7: ("pyramid5", 5),
    11: ("tet10", 10),
    12: ("hex27", 27),
    13: ("wedge15", 15),
    14: ("pyramid13", 13),
    17: ("hex20", 20),
    18: ("wedge15", 15),
    19: ("pyramid13", 13),
}
#: Corners of surface cells.
FACETS = {2: 3, 3: 4, 9: 3, 10: 4, 16: 4, 20: 3, 21: 3, 36: 4, 39: 4}
#: Nodes of all cells.
N_NODES = {1: 2, 2: 3, 3: 4, 4: 4, 5: 8, 6: 6, 7: 5, 8: 3, 9: 6, 10: 9, 11: 10, 12: 27, 13: 18, 14: 14, 15: 1, 16: 8}
N_NODES |= {17: 20, 18: 15, 19: 13, 20: 9, 21: 10, 22: 12, 23: 15, 24: 15, 25: 21, 26: 4, 27: 5, 28: 6, 29: 20, 30: 35}
N_NODES |= {31: 56, 36: 16, 37: 25, 38: 36, 39: 12, 90: 40, 91: 75, 92: 64, 93: 125, 118: 30, 119: 55}
LINES = {1, 8, 26, 27, 28}
#: Solids of higher order, in words; what to do about them.
HIGHER = {
    kind: f"{name} of order {order}, which is too high: write the file again at order 2 (gmsh -order 2)"
    for name, kinds in {
        "tetrahedra": {29: 3, 30: 4, 31: 5},
        "wedges": {90: 3, 91: 4},
        "hexahedra": {92: 3, 93: 4},
        "pyramids": {118: 3, 119: 4},
    }.items()
    for kind, order in kinds.items()
}
POINT = 15
#: Cells of sections.
SHEETS = {2: "tri3", 3: "quad4", 9: "tri6", 10: "quad9", 16: "quad8"}


@dataclass
class Cells:
    """Cells of one type: numbers (n,), nodes (n, k) by their numbers in the file, and their tags.

    `physical` and `geometrical` are pairs (cell, tag) of int arrays (m, 2).
    """

    kind: int
    ids: IntArray
    nodes: IntArray
    physical: IntArray
    geometrical: IntArray


@dataclass
class Contents:
    """What a file holds."""

    ids: list[IntArray] = field(default_factory=list)
    points: list[Array] = field(default_factory=list)
    cells: list[Cells] = field(default_factory=list)
    names: dict[tuple[int, int], str] = field(default_factory=dict)
    #: Physical groups of the entities (dimension, number) of version 4.
    entities: dict[tuple[int, int], IntArray] = field(default_factory=dict)


class Stream:
    """Numbers one after the other, from text or binary."""

    def __init__(self, data: bytes, name: str) -> None:
        self.data, self.at, self.name = data, 0, name
        self.binary, self.order, self.version = False, "<", 1.0
        self.text = b""
        self.words: list[bytes] = []
        self.word = 0

    def line(self) -> str:
        """The next line that is not blank; empty at the end."""
        while self.at < len(self.data):
            end = self.data.find(b"\n", self.at)
            end = len(self.data) if end < 0 else end
            text, self.at = self.data[self.at : end].strip(), end + 1
            if text:
                return text.decode("utf-8", errors="replace")
        return ""

    def open(self, section: str) -> None:
        """Begin a section of numbers."""
        if not self.binary:
            end = self.data.find(b"$End" + section.encode(), self.at)
            end = end if end >= 0 else self.data.find(b"$END" + section.encode(), self.at)
            if end < 0:
                raise MeshError(f"{self.name} could not be read: ${section} has no end. The file is damaged.")
            self.text = self.data[self.at : end]
            self.words, self.word = self.text.split(), 0
            self.at = end

    def close(self, section: str) -> None:
        """Skip what is left of a section."""
        end = self.data.upper().find(b"$END" + section.upper().encode(), self.at)
        self.at = len(self.data) if end < 0 else self.data.find(b"\n", end) % (len(self.data) + 1)

    def take(self, count: int, kind: str) -> Any:
        """The next numbers: 'i' of 4 bytes, 'u' of 8 bytes, 'd' floats; text has no widths."""
        if not self.binary:
            words = self.words[self.word : self.word + count]
            if count < 0 or len(words) < count:
                raise MeshError(f"{self.name} could not be read: numbers are missing. The file is damaged.")
            self.word += count
            return np.array(words, dtype=float if kind == "d" else np.int64)
        dtype = np.dtype(self.order + {"i": "i4", "u": "u8", "d": "f8"}[kind])
        size = count * dtype.itemsize
        if count < 0 or self.at + size > len(self.data):
            raise MeshError(f"{self.name} could not be read: it ends too early. The file is damaged.")
        values = np.frombuffer(self.data, dtype, count, self.at)
        self.at += size
        return values.astype(float if kind == "d" else np.int64)

    def records(self, count: int, fields: str) -> list[Any]:
        """`count` records of numbers of these kinds, such as 'iddd', as one array (count, k) for each run of a kind."""
        runs = [(kind, len(part)) for kind, part in _runs(fields)]
        if self.binary:
            dtype = np.dtype(
                [
                    (str(k), self.order + {"i": "i4", "u": "u8", "d": "f8"}[kind], (n,))
                    for k, (kind, n) in enumerate(runs)
                ]
            )
            size = count * dtype.itemsize
            if count < 0 or self.at + size > len(self.data):
                raise MeshError(f"{self.name} could not be read: it ends too early. The file is damaged.")
            table = np.frombuffer(self.data, dtype, count, self.at)
            self.at += size
            return [table[str(k)].astype(float if kind == "d" else np.int64) for k, (kind, _) in enumerate(runs)]
        # numbers of nodes are exact as floats
        table = self.take(count * len(fields), "d" if "d" in fields else "i").reshape(count, len(fields))
        ends = np.cumsum([n for _, n in runs])[:-1]
        columns = np.split(table, ends, axis=1)
        return [
            c if kind == "d" else index_array("the numbers of nodes and cells", c)
            for c, (kind, _) in zip(columns, runs, strict=True)
        ]

    def rows(self, count: int) -> list[list[bytes]]:
        """Words of the next lines of text; the first line of a section, its count, has been taken."""
        found = [row for row in (line.split() for line in self.text.splitlines()) if row][1 : count + 1]
        if len(found) < count:
            raise MeshError(f"{self.name} could not be read: rows are missing. The file is damaged.")
        return found


def _runs(fields: str) -> Iterator[tuple[str, str]]:
    """Runs of equal letters."""
    start = 0
    for k in range(1, len(fields) + 1):
        if k == len(fields) or fields[k] != fields[start]:
            yield fields[start], fields[start:k]
            start = k


def read_gmsh(path: Path) -> RawMesh:
    """Read a .msh file.

    Raises
    ------
    MeshError
        If it is damaged or of an unknown version.
    """
    stream, out = Stream(path.read_bytes(), path.name), Contents()
    try:
        while section := stream.line():
            if section.startswith("$") and not section.upper().startswith("$END"):
                _section(section[1:], stream, out)
    except (ValueError, IndexError, KeyError, OverflowError) as error:
        if isinstance(error, MeshError):
            raise
        raise MeshError(f"{path.name} could not be read: {error}. The file is damaged.", code="damaged") from error
    if not out.points:
        raise MeshError(f"{path.name} could not be read: it has no nodes. The file is damaged or of another type.")
    return _mesh(out, path.name)


def _section(name: str, stream: Stream, out: Contents) -> None:
    """Read a section; unknown ones are skipped."""
    readers = {
        "NOD": _nodes_1_2,
        "ELM": _elements_1,
        "Nodes": _nodes_4 if stream.version >= 4 else _nodes_1_2,
        "Elements": _elements_4 if stream.version >= 4 else _elements_2,
        "Entities": _entities,
    }
    if name == "MeshFormat":
        version, binary, _ = stream.line().split()
        stream.version, stream.binary = float(version), binary == "1"
        if not (2 <= stream.version < 3 or 4 <= stream.version < 5):
            raise MeshError(f"{stream.name} is of gmsh's version {version}; expected 1, 2, 4.0 or 4.1.", code="version")
        if stream.binary:
            one = np.frombuffer(stream.data, "<i4", 1, stream.at)[0]
            stream.order, stream.at = "<" if one == 1 else ">", stream.at + 4
    elif name == "PhysicalNames":
        for _ in range(int(stream.line())):
            dimension, tag, text = stream.line().split(maxsplit=2)
            out.names[int(dimension), int(tag)] = text.strip().strip('"')
    elif name in readers:
        if stream.binary and stream.version < 4:
            count = int(stream.line())
            readers[name](stream, out, count)
        else:
            stream.open(name)
            count = int(stream.take(1, "u")[0]) if stream.version < 4 else 0
            readers[name](stream, out, count)
    stream.close(name)


def _nodes_1_2(stream: Stream, out: Contents, count: int) -> None:
    ids, points = stream.records(count, "iddd")
    out.ids.append(ids[:, 0])
    out.points.append(points)


def _elements_1(stream: Stream, out: Contents, count: int) -> None:
    """Number, type, physical and geometrical region, number of nodes, nodes."""
    rows: dict[int, list[list[bytes]]] = {}
    for row in stream.rows(count):
        rows.setdefault(int(row[1]), []).append([row[0], *row[2:4], *row[5:]])
    for kind, found in rows.items():
        _add(out, kind, np.array(found, dtype=np.int64), 2)


def _elements_2(stream: Stream, out: Contents, count: int) -> None:
    """Text: number, type, number of tags, tags, nodes. Binary: blocks of one type, with a head of three numbers."""
    rows: dict[tuple[int, int], list[Any]] = {}
    if not stream.binary:
        for row in stream.rows(count):
            rows.setdefault((int(row[1]), int(row[2])), []).append([row[0], *row[3:]])
    while stream.binary and count > 0:
        kind, n, n_tags = stream.take(3, "i").tolist()
        rows.setdefault((kind, n_tags), []).extend(stream.records(n, "i" * (1 + n_tags + N_NODES[kind]))[0].tolist())
        count -= max(n, 1)
    for (kind, n_tags), found in rows.items():
        _add(out, kind, np.array(found, dtype=np.int64), n_tags)


def _add(out: Contents, kind: int, rows: IntArray, n_tags: int) -> None:
    """Cells of rows (n, 1 + n_tags + nodes): number, physical tag, geometrical tag, others, nodes."""
    cell = np.arange(len(rows))
    tags = [np.stack([cell, rows[:, 1 + k]], axis=1) for k in range(min(n_tags, 2))]
    tags += [np.zeros((0, 2), np.int64)] * (2 - len(tags))
    physical = tags[0][tags[0][:, 1] != 0]
    out.cells.append(Cells(kind, rows[:, 0], rows[:, 1 + n_tags :], physical, tags[1]))


def _entities(stream: Stream, out: Contents, _: int) -> None:
    """Physical groups of points, curves, surfaces and volumes."""
    counts = stream.take(4, "u").tolist()
    for dimension, count in enumerate(counts):
        for _ in range(count):
            tag = int(stream.take(1, "i")[0])
            stream.take(3 if dimension == 0 and stream.version > 4.05 else 6, "d")
            out.entities[dimension, tag] = stream.take(int(stream.take(1, "u")[0]), "i")
            if dimension:
                stream.take(int(stream.take(1, "u")[0]), "i")


def _nodes_4(stream: Stream, out: Contents, _: int) -> None:
    blocks = int(stream.take(4 if stream.version > 4.05 else 2, "u")[0])
    for _ in range(blocks):
        first, second, parametric = stream.take(3, "i").tolist()
        count = int(stream.take(1, "u")[0])
        if stream.version > 4.05:
            ids = stream.take(count, "u")
            (points,) = stream.records(count, "ddd" + "d" * (first if parametric else 0))
        else:
            numbers, points = stream.records(count, "iddd" + "d" * (second if parametric else 0))
            ids = numbers[:, 0]
        out.ids.append(ids)
        out.points.append(points[:, :3])


def _elements_4(stream: Stream, out: Contents, _: int) -> None:
    newer = stream.version > 4.05
    blocks = int(stream.take(4 if newer else 2, "u")[0])
    for _ in range(blocks):
        first, second, kind = stream.take(3, "i").tolist()
        dimension, entity = (first, second) if newer else (second, first)
        count = int(stream.take(1, "u")[0])
        (rows,) = stream.records(count, ("u" if newer else "i") * (1 + N_NODES[kind]))
        cell = np.arange(count)
        groups = np.abs(out.entities.get((dimension, entity), np.zeros(0, np.int64)))
        physical = np.stack([np.tile(cell, len(groups)), np.repeat(groups, count)], axis=1)
        geometrical = np.stack([cell, np.full(count, entity)], axis=1)
        out.cells.append(Cells(kind, rows[:, 0], rows[:, 1:], physical, geometrical))


def _mesh(out: Contents, source: str) -> RawMesh:
    """Solids and surfaces with their groups."""
    ids = np.concatenate(out.ids)
    ids, first = np.unique(ids, return_index=True)
    points = np.concatenate(out.points)[first]
    grouped = any(len(c.physical) for c in out.cells)
    blocks, numbers, start = [], [], 0
    groups: dict[str, list[IntArray]] = {}
    facets: dict[str, list[IntArray]] = {}
    left: Counter[str] = Counter()
    sheets: list[tuple[str, str, IntArray]] = []
    lines: dict[str, list[IntArray]] = {}
    for c in (c for c in out.cells if c.kind != POINT):
        if c.kind not in SOLIDS and c.kind not in FACETS and c.kind not in LINES:
            left[HIGHER.get(c.kind, f"cells of gmsh's type {c.kind}")] += len(c.ids)
            continue
        dimension = 3 if c.kind in SOLIDS else 2 if c.kind in FACETS else 1
        what = ("curve", "surface", "volume")[dimension - 1]
        nodes = numbers_of(ids, c.nodes, "node", source)
        tags = c.physical if grouped else c.geometrical
        named = {t: out.names.get((dimension, t), f"{what}_{t}") for t in np.unique(tags[:, 1]).tolist()}
        members = {name: tags[tags[:, 1] == t, 0] for t, name in named.items()}
        if dimension == 3:
            kind, used = SOLIDS[c.kind]
            blocks.append((kind, nodes[:, :used]))
            numbers.append(c.ids)
            for name, cells in members.items():
                groups.setdefault(name, []).append(start + cells)
            start += len(c.ids)
        elif dimension == 2:
            for name, cells in members.items():
                facets.setdefault(name, []).append(nodes[cells, : FACETS[c.kind]])
                sheets += [(name, SHEETS[c.kind], nodes[cells])] if c.kind in SHEETS else []
        else:
            for name, cells in members.items():
                lines.setdefault(name, []).append(nodes[cells, :2])
    sets = {name: np.concatenate(parts) for name, parts in groups.items()}
    cells = joined_numbers(numbers)
    return RawMesh(points, blocks, sets, facets, left=left, sheets=sheets, lines=lines, node_ids=ids, element_ids=cells)
