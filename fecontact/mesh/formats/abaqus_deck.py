"""One mesh of an Abaqus or CalculiX input file: a flat file, or the lines between *PART and *END PART."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import IntArray
from fecontact.common.errors import MeshError
from fecontact.mesh.formats.abaqus_keywords import KeywordSection, table
from fecontact.mesh.formats.raw import RawMesh, numbers_of
from fecontact.mesh.kinds import KINDS

#: Solid elements: kind of cell by the digits after C3D; letters after them (R, H, I, M, ...) do not change the
#: geometry.
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
#: Local face of the hexahedron for S1, S2, ... of each shape (its faces: -x, +x, -y, +y, -z, +z).
FACES = {
    "hex": (4, 5, 2, 1, 3, 0),
    "wedge": (4, 5, 2, 1, 0),
    "pyramid": (4, 2, 1, 3, 0),
    "tet": (4, 2, 1, 0),
}


@dataclass(frozen=True, eq=False)
class Deck:
    """A mesh with the file's numbers of nodes and elements.

    Attributes
    ----------
    node_ids, element_ids : int arrays
        The file's numbers of the points and of the solid cells of `raw`.
    kinds : (n_cells,) array of str
    raw : RawMesh
    source : str
        Name of the file.
    """

    node_ids: IntArray
    element_ids: IntArray
    kinds: NDArray[np.str_]
    raw: RawMesh
    source: str


def read_deck(sections: list[KeywordSection], source: str) -> Deck:
    """Mesh from keywords.

    Raises
    ------
    MeshError
        If there are no nodes, or unknown elements, broken numbers or missing references.
    """
    nodes = [table(s.lines, 4, float) for s in sections if s.keyword == "NODE"]
    rows_of_nodes = np.concatenate(nodes) if nodes else np.zeros((0, 4))
    if not len(rows_of_nodes):
        raise MeshError(f"{source} defines no nodes (*NODE).")
    places = [s.place for s in sections if s.keyword == "NODE"]
    owner = np.repeat(np.arange(len(nodes)), [len(n) for n in nodes])
    rows_of_nodes = _defined_once(rows_of_nodes, "node", [places[k] for k in owner])
    node_ids = rows_of_nodes[:, 0].astype(np.int64)
    blocks: list[tuple[str, IntArray]] = []
    kinds: list[str] = []
    element_ids: list[IntArray] = []
    facets: dict[str, list[IntArray]] = {}
    groups: dict[str, list[IntArray]] = {}
    for section in (s for s in sections if s.keyword == "ELEMENT"):
        kind, n_nodes = _kind(section.parameters.get("TYPE", ""), source)
        if n_nodes == 0:
            continue
        rows = table(section.lines, n_nodes + 1, int)
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
    _refuse_other_elements(all_elements, blocks, source)
    points, kinds_of = rows_of_nodes[:, 1:], np.array(kinds, dtype=np.str_)
    sets = {k: np.concatenate(v) for k, v in groups.items()}
    deck = Deck(node_ids, all_elements, kinds_of, RawMesh(points, blocks, sets, facets), source)
    sets = _element_sets(sections, deck)
    deck = replace(deck, raw=replace(deck.raw, groups=sets))
    node_sets = _node_sets(sections, deck)
    faces, open_sets = _surfaces(sections, deck, node_sets)
    return replace(deck, raw=replace(deck.raw, faces=faces, node_sets={**node_sets, **open_sets}))


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


def _kind(name: str, source: str) -> tuple[str, int]:
    """Kind of cell and number of nodes of an element type; ('facet', n) for surfaces, ('', 0) for lines and points."""
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


def listed(section: KeywordSection, sets: Mapping[str, IntArray], ids: IntArray, what: str, source: str) -> IntArray:
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


def _element_sets(sections: list[KeywordSection], deck: Deck) -> dict[str, IntArray]:
    """Sets of solid elements; sets of surface elements have become surfaces."""
    out = dict(deck.raw.groups)
    for s in sections:
        name = s.parameters.get("ELSET", "")
        if s.keyword != "ELSET" or name in deck.raw.facets:
            continue
        members = listed(s, out, deck.element_ids, "element", deck.source)
        out[name] = np.union1d(out.get(name, np.zeros(0, np.int64)), members)
    return out


def _node_sets(sections: list[KeywordSection], deck: Deck) -> dict[str, IntArray]:
    out: dict[str, IntArray] = {}
    of_nodes = {s.parameters["NSET"]: s for s in sections if s.keyword == "NODE" and "NSET" in s.parameters}
    for name, s in of_nodes.items():
        ids = table(s.lines, 4, float)[:, 0].astype(np.int64)
        out[name] = numbers_of(deck.node_ids, ids, "node", deck.source)
    for s in (s for s in sections if s.keyword == "NSET"):
        name = s.parameters.get("NSET", "")
        if "ELSET" in s.parameters:
            members = nodes_of(deck.raw.groups.get(s.parameters["ELSET"], np.zeros(0, np.int64)), deck.raw.blocks)
        else:
            members = listed(s, out, deck.node_ids, "node", deck.source)
        out[name] = np.union1d(out.get(name, np.zeros(0, np.int64)), members)
    return out


def nodes_of(elements: IntArray, blocks: Sequence[tuple[str, IntArray]]) -> IntArray:
    """Nodes of solid cells, numbered through the blocks."""
    nodes, start = [np.zeros(0, np.int64)], 0
    for _, cells in blocks:
        inside = elements[(elements >= start) & (elements < start + len(cells))] - start
        nodes.append(cells[inside].ravel())
        start += len(cells)
    return np.unique(np.concatenate(nodes))


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
            by_nodes[name] = listed(
                KeywordSection("", {}, [x.split(",")[0] for x in s.lines]),
                node_sets,
                deck.node_ids,
                "node",
                deck.source,
            )
            continue
        if kind != "ELEMENT":
            continue  # an analytical surface
        parts = []
        for line in s.lines:
            member, label = member_and_label(line)
            if member.isdigit():
                cells = numbers_of(deck.element_ids, np.array([int(member)]), "element", deck.source)
            elif member.upper() in known:
                cells = known[member.upper()]
            else:
                raise MeshError(f"{deck.source}: surface {name!r} names the element set {member!r}, which is missing.")
            parts.append(labelled_faces(cells, deck.kinds, label, name))
        faces[name] = np.concatenate(parts) if parts else np.zeros((0, 2), np.int64)
    return faces, by_nodes


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
