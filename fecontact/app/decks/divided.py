"""The deck of a mesh whose cells are divided: the same question on a finer mesh, for every program that reads decks.

Each solid element is divided into eight of its kind (see `mesh.refine`). Nodes keep their numbers, new ones have
numbers above all others, and so have all elements. Sets and surfaces hold what lies within them; so do supports,
temperatures and materials that name sets, while supports of single nodes stay at these. Pressures act on the parts of
their faces. Forces on nodes stay on the nodes of the deck, where they are point forces.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fecontact.app.decks.sections import state_of
from fecontact.common.arrays import IntArray
from fecontact.common.checks import whole
from fecontact.common.errors import InputError
from fecontact.mesh.build import build
from fecontact.mesh.formats.abaqus import mesh_of
from fecontact.mesh.formats.abaqus_deck import FACES, KeywordSection, labelled_faces, one_spelling
from fecontact.mesh.formats.raw import RawMesh
from fecontact.mesh.kinds import KINDS
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.refine import refined

#: Keywords of decks that are not flat, or whose sets have to stay as they are.
NOT_DIVIDED = ("PART", "INSTANCE", "EQUATION", "DSLOAD")
#: Keywords of fields at nodes, which need every node.
FIELDS = ("TEMPERATURE", "INITIAL CONDITIONS")
#: Loads of *DLOAD on cells as a whole.
ON_CELLS = ("GRAV", "CENTRIF")
#: Most divisions of a deck: 512 cells of each.
MOST = 3
#: Numbers on a line; ccx reads up to 16, each of up to 20 characters.
PER_LINE = 11
#: Begins names of temporary sets; no name that a deck gives.
OWN = "\0"


def divided_deck(keywords: Sequence[KeywordSection], source: str, times: int) -> list[KeywordSection]:
    """Keywords of a deck whose solid elements are divided so many times.

    Raises
    ------
    InputError, MeshError
        If that would change the question.

    Examples
    --------
    >>> corners = "0,0,0", "1,0,0", "1,1,0", "0,1,0", "0,0,1", "1,0,1", "1,1,1", "0,1,1"
    >>> nodes = KeywordSection("NODE", {}, [f"{k},{x}" for k, x in enumerate(corners, 1)])
    >>> cell = KeywordSection("ELEMENT", {"TYPE": "C3D8"}, ["1,1,2,3,4,5,6,7,8"])
    >>> top = KeywordSection("SURFACE", {"NAME": "TOP"}, ["1,S2"])
    >>> [(s.keyword, len(s.lines)) for s in divided_deck([nodes, cell, top], "a deck", 1)]
    [('NODE', 19), ('NODE', 8), ('ELEMENT', 8), ('SURFACE', 4)]
    """
    out = one_spelling(list(keywords))
    for _ in range(whole("the number of divisions of a deck", times, 0, MOST)):
        out = _once(out, source)
    return out


def _once(keywords: list[KeywordSection], source: str) -> list[KeywordSection]:
    for s in keywords:
        numbered = s.keyword in FIELDS and any(line.split(",")[0].strip().isdigit() for line in s.lines)
        if numbered or s.keyword in NOT_DIVIDED:
            raise _refused(f"{s.place}: *{s.keyword}{' of single nodes' * numbered}")
    if state_of(keywords) is not None:
        raise _refused(f"{source}: plane elements")
    raw = mesh_of(keywords, source)
    mesh = build(raw, source)
    kinds = np.repeat(np.array([kind for kind, _ in raw.blocks], np.str_), [len(cells) for _, cells in raw.blocks])
    if len(mesh.cells) != len(kinds) or any(kind.startswith("pyramid") for kind, _ in raw.blocks):
        raise _refused(f"{source}: elements that are listed again, or pyramids")
    chosen = _blocks(keywords, raw) | _loaded(keywords, raw, kinds)
    faces = {name: found for name, found in chosen.items() if found.ndim == 2}
    groups = {name: found for name, found in chosen.items() if found.ndim == 1}
    mesh = replace(mesh, groups={**raw.groups, **groups}, boundaries={**raw.faces, **faces})
    after = refined(mesh, np.arange(len(mesh.cells)))
    if len(after.cells) != 8 * len(mesh.cells):
        raise _refused(f"{source}: hexahedra with nodes in one place")
    return _written(keywords, raw, mesh, after)


def _refused(what: str) -> InputError:
    return InputError(
        f"{what}: such a deck is not divided here, as the question would change. Divide its mesh where it was made.",
        code="not-divided",
    )


def _blocks(keywords: Sequence[KeywordSection], raw: RawMesh) -> dict[str, IntArray]:
    """Cells (n,) of each *ELEMENT of solids, by its place among the keywords."""
    own = [k for k, s in enumerate(keywords) if s.lines and _is_solid(s)]
    ends = np.cumsum([len(cells) for _, cells in raw.blocks])
    return {
        f"{OWN}{k}": np.arange(end - len(raw.blocks[i][1]), end)
        for i, (k, end) in enumerate(zip(own, ends, strict=True))
    }


def _is_solid(s: KeywordSection) -> bool:
    return s.keyword == "ELEMENT" and re.match(r"D?C3D\d", s.parameters.get("TYPE", "").upper()) is not None


def _loaded(keywords: Sequence[KeywordSection], raw: RawMesh, kinds: NDArray[np.str_]) -> dict[str, IntArray]:
    """Faces (n, 2) or cells (n,) of the data lines of *DLOAD, by the places of keyword and line."""
    out: dict[str, IntArray] = {}
    known = {name.upper(): cells for name, cells in raw.groups.items()}
    for k, row, line in (
        (k, row, line) for k, s in enumerate(keywords) if s.keyword == "DLOAD" for row, line in enumerate(s.lines)
    ):
        member, label = [*(word.strip().upper() for word in line.split(",")), ""][:2]
        number = np.flatnonzero(np.asarray(raw.element_ids) == int(member)) if member.isdigit() else None
        cells = known.get(member, np.zeros(0, np.int64)) if number is None else number
        if not len(cells) or not (re.fullmatch(r"P\d", label) or label in ON_CELLS):
            raise _refused(
                f"{keywords[k].place}: the load {line!r} on other than solids, or not {', '.join(ON_CELLS)} or P1 to P6"
            )
        out[f"{OWN}{k} {row}"] = cells if label in ON_CELLS else labelled_faces(cells, kinds, f"S{label[1]}", line)
    return out


def _written(keywords: Sequence[KeywordSection], raw: RawMesh, before: Mesh, after: Mesh) -> list[KeywordSection]:
    """The keywords with nodes, elements, sets, surfaces and loads of the divided mesh."""
    numbers, node_ids = before.file_nodes, raw.node_ids
    assert numbers is not None
    assert node_ids is not None
    own = [name for name in after.groups if re.fullmatch(f"{OWN}\\d+", name)]
    kind = {name: KINDS[raw.blocks[i][0]] for i, name in enumerate(own)}
    columns = {name: [k.embedding.index(node) for node in range(k.n_nodes)] for name, k in kind.items()}
    nodes = {name: after.cells[after.groups[name]][:, columns[name]] for name in own}
    ids = np.append(numbers, np.full(len(after.points) - len(numbers), -1))
    new = np.unique(np.concatenate([n.ravel() for n in nodes.values()]))
    new = new[ids[new] < 0]
    ids[new] = int(node_ids.max()) + 1 + np.arange(len(new))
    named = {key.upper(): members for key, members in after.node_sets.items()}
    for s in (s for s in keywords if s.keyword in FIELDS and s.lines):
        members = [named.get(line.split(",")[0].strip().upper(), new[:0]) for line in s.lines]
        if len(np.setdiff1d(new, np.concatenate(members))):
            raise _refused(f"{s.place}: *{s.keyword} of sets between which new nodes are in none")
    others = [line.split(",")[0] for s in keywords if s.keyword == "ELEMENT" for line in s.lines]
    first = 1 + max(int(word) for word in others)
    shapes = np.empty(len(after.cells), object)
    for name in own:
        shapes[after.groups[name]] = kind[name].name.rstrip("0123456789")

    def added(name: str) -> list[str]:
        members = ids[np.setdiff1d(after.node_sets.get(name, new[:0]), np.flatnonzero(numbers >= 0))]
        return _lines(members[members >= 0])

    def on(name: str, label: str) -> list[str]:
        faces = after.boundaries[name].tolist()
        return [f"{first + c},{label}{FACES[shapes[c]].index(local) + 1}" for c, local in faces]

    def loads(key: str, lines: Sequence[str]) -> Iterator[str]:
        for row, line in enumerate(lines):
            _, label, rest = line.split(",", 2)
            there = f"{key} {row}"
            faces = there in after.boundaries
            parts = on(there, "P") if faces else [f"{first + c},{label}" for c in after.groups[there].tolist()]
            yield from (f"{part},{rest}" for part in parts)

    sets = {key.upper(): node_ids[members].tolist() for key, members in raw.node_sets.items()}

    def by_node(line: str) -> list[str]:
        """A line of *CLOAD that names a set as lines of its nodes, those of the mesh as it was."""
        name, comma, rest = line.partition(",")
        members = sets.get(name.strip().upper())
        return [line] if members is None else [f"{n}{comma}{rest}" for n in members]

    rows = zip(ids[new].tolist(), after.points[new].tolist(), strict=True)
    places = [f"{n},{x:.12e},{y:.12e},{z:.12e}" for n, (x, y, z) in rows]
    out: list[KeywordSection] = []
    for k, s in enumerate(keywords):
        key, lines = f"{OWN}{k}", s.lines
        name = s.parameters.get("NAME" if s.keyword == "SURFACE" else s.keyword, "")
        of_nodes = s.keyword == "SURFACE" and s.parameters.get("TYPE", "ELEMENT").upper() == "NODE"
        if s.keyword == "NODE":
            out += [] if any(part.keyword == "NODE" for part in out) else [KeywordSection("NODE", {}, places, s.place)]
            if members := added(s.parameters.get("NSET", "")):
                out += [s, KeywordSection("NSET", {"NSET": s.parameters["NSET"]}, members, s.place)]
                continue
        elif key in nodes:
            rows_of = np.column_stack([first + after.groups[key], ids[nodes[key]]])
            lines = [line for row in rows_of for line in _lines(row, ",")]
        elif s.keyword == "NSET" and "ELSET" not in s.parameters:
            lines = (_lines(node_ids[raw.node_sets[name]]) if "GENERATE" in s.parameters else lines) + added(name)
        elif s.keyword == "ELSET" and name in after.groups:
            lines = _lines(first + after.groups[name])
        elif of_nodes and all(line.strip(" ,").isdigit() for line in lines):
            lines = lines + [word for line in added(name) for word in line.split(",")]
        elif s.keyword == "SURFACE" and not of_nodes and name in after.boundaries:
            lines = on(name, "S")
        elif s.keyword == "CLOAD":
            lines = [line for row in lines for line in by_node(row)]
        elif s.keyword == "DLOAD":
            lines = list(loads(key, lines))
        listed = {word: value for word, value in s.parameters.items() if word != "GENERATE"}
        out.append(s if lines is s.lines else replace(s, parameters=listed, lines=lines))
    return out


def _lines(numbers: IntArray, end: str = "") -> list[str]:
    """Data lines of numbers; all but the last with something at their ends."""
    words = [str(n) for n in numbers.tolist()]
    lines = [",".join(words[k : k + PER_LINE]) for k in range(0, len(words), PER_LINE)]
    return [f"{line}{end}" for line in lines[:-1]] + lines[-1:]
