"""Abaqus and CalculiX .inp files: nodes, elements, and sets and surfaces with their names.

A file is flat, or an assembly of parts: each *INSTANCE is a copy of a *PART that is translated, then rotated. Sets and
surfaces may belong to a part or to the assembly, which refers to those of its instances as ``instance.set`` or by the
parameter INSTANCE (Abaqus Keywords Reference: *INSTANCE, *NSET, *ELSET, *SURFACE).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError, MeshError
from fecontact.mesh.formats.abaqus_deck import (
    Deck,
    KeywordSection,
    labelled_faces,
    listed,
    member_and_label,
    missing_files,
    nodes_beside,
    nodes_of,
    one_spelling,
    read_deck,
    read_sections,
    refuse_generated,
)
from fecontact.mesh.formats.raw import RawMesh, joined_numbers, numbers_of, part_of


@dataclass(frozen=True, eq=False)
class InstanceParts:
    """Keywords of parts, of instances and of the assembly."""

    parts: dict[str, list[KeywordSection]] = field(default_factory=dict)
    instances: list[tuple[KeywordSection, list[KeywordSection]]] = field(default_factory=list)
    outside: list[KeywordSection] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class Instance:
    """A placed part, and the offsets of its points and cells in the whole mesh; none if it is left out."""

    name: str
    part: str
    deck: Deck
    points: Array
    first_point: int = -1
    first_cell: int = -1

    def numbers(self, local: IntArray, what: str) -> IntArray:
        """Numbers in the whole mesh of points ('node') or cells ('element') of the part; none if it is left out."""
        first = self.first_point if what == "node" else self.first_cell
        return local + first if first >= 0 else local[:0]

    def members(self, name: str, what: str) -> IntArray | None:
        """A set of the part by its name, or one node or element by its number."""
        sets = self.deck.raw.node_sets if what == "node" else self.deck.raw.groups
        known = {k.upper(): v for k, v in sets.items()}
        if not name.isdigit():
            local = known.get(name.upper())
        else:
            local = numbers_of(self.deck.ids(what), np.array([int(name)]), what, self.deck.source)
        return None if local is None else self.numbers(local, what)


def read_abaqus(path: Path, part: str | None = None) -> RawMesh:
    """Read an input file, flat or an assembly; all placed instances go into one mesh.

    Parameters
    ----------
    path : Path
    part : str, optional
        Name of an instance, or of a part with a single instance; of an element set of a flat file. All unless given.

    Returns
    -------
    RawMesh
        Coincident nodes are not merged. Each of several instances is an element set of its name; a set or surface whose
        name occurs more than once is called ``instance.set``. Instances without solid cells are left out.

    Raises
    ------
    InputError
        If there is no such part.
    MeshError
        If the file has unknown elements, broken numbers or missing references.
    """
    return mesh_of(one_spelling(list(read_sections(path))), path.name, part)


def mesh_of(found: list[KeywordSection], source: str, part: str | None = None, plane: bool = False) -> RawMesh:
    """The mesh of keywords, as `read_abaqus`; or the plane one of their sections."""
    missing = missing_files(found)
    try:
        refuse_generated(found)
        sections = _by_place(found, source)
        if sections.parts or sections.instances:
            raw = _assembled(sections, source, part, plane)
        else:
            raw = read_deck(sections.outside, source, plane).raw
            raw = raw if part is None else part_of(raw, part, source)
    except (ValueError, IndexError, OverflowError) as error:
        also = f" Files that it includes are missing: {', '.join(missing)}." if missing else ""
        if isinstance(error, InputError | MeshError):
            raise type(error)(f"{error}{also}", code=error.code) from None
        raise MeshError(f"{source} holds a line that cannot be read: {error}.{also}", code="bad-line") from error
    left = {**raw.left, **{f"file to be included, {name}, which is missing": 1 for name in missing}}
    return replace(raw, left=left)


def _by_place(sections: list[KeywordSection], source: str) -> InstanceParts:
    """Keywords sorted into those of parts, of instances and the others."""
    out = InstanceParts()
    inside: list[KeywordSection] | None = None
    for s in sections:
        if s.keyword == "PART":
            inside = out.parts.setdefault(s.parameters.get("NAME", ""), [])
        elif s.keyword == "INSTANCE":
            inside = []
            out.instances.append((s, inside))
        elif s.keyword in ("END PART", "END INSTANCE"):
            inside = None
        else:
            (out.outside if inside is None else inside).append(s)
    if (out.parts or out.instances) and _has_solids(out.outside):
        raise MeshError(f"{source} has parts and, outside of them, solid elements; move these into a part.")
    return out


def _has_solids(sections: list[KeywordSection]) -> bool:
    return any(s.keyword == "ELEMENT" and s.parameters.get("TYPE", "").upper().startswith("C3D") for s in sections)


def _has_nodes(sections: list[KeywordSection]) -> bool:
    return any(s.keyword == "NODE" and s.lines for s in sections)


def _assembled(sections: InstanceParts, source: str, part: str | None, plane: bool = False) -> RawMesh:
    """One mesh of all instances, with their sets and those of the assembly."""
    instances = _chosen(_instances(sections, source, plane), source, part)
    kept = [i for i in instances if i.first_point >= 0]
    solid = [i for i in kept if len(i.deck.kinds)]
    if not solid and not any(i.deck.raw.shells for i in kept):
        raise MeshError(f"{source} holds no solid cells in {f'its part {part!r}' if part else 'any of its parts'}.")
    blocks = [(kind, cells + i.first_point) for i in kept for kind, cells in i.deck.raw.blocks]
    kinds = np.concatenate([i.deck.kinds for i in kept])
    points = np.concatenate([i.points for i in kept])
    beside = nodes_beside(sections.outside, source)
    own_nodes = dict(zip(beside[0].tolist(), range(len(points), len(points) + len(beside[0])), strict=True))
    node_sets, groups, faces = _of_the_assembly(sections.outside, instances, blocks, kinds, source, own_nodes)
    own = {} if len(solid) == 1 else {i.name: i.first_cell + np.arange(len(i.deck.kinds)) for i in solid}
    taken = {name.upper() for name in (*node_sets, *groups, *faces, *own)}
    count = Counter(name for i in kept for name in {n.upper() for n in _names(i.deck.raw)})

    def called(i: Instance, name: str) -> str:
        return f"{i.name}.{name}" if count[name.upper()] > 1 or name.upper() in taken else name

    raw = RawMesh.joined([i.deck.raw for i in kept], lambda k, name: called(kept[k], name))
    return replace(
        raw,
        points=np.concatenate([points, beside[1]]),
        node_ids=joined_numbers([raw.node_ids, beside[0]]),
        groups={**own, **_filled({**groups, **raw.groups})},
        faces=_filled({**faces, **raw.faces}),
        node_sets=_filled({**node_sets, **raw.node_sets}),
    )


def _names(raw: RawMesh) -> tuple[str, ...]:
    return (*raw.groups, *raw.shells, *raw.faces, *raw.node_sets)


def _instances(sections: InstanceParts, source: str, plane: bool = False) -> list[Instance]:
    """Placed copies of the parts; without an assembly each part has its own coordinates."""
    by_name = {name.upper(): (name, content) for name, content in sections.parts.items()}
    decks: dict[str, Deck] = {}
    empty = KeywordSection("INSTANCE", {}, [])
    placed = sections.instances or [(replace(empty, parameters={"NAME": n, "PART": n}), []) for n in sections.parts]
    out = []
    for head, own in placed:
        name, part = head.parameters.get("NAME", ""), head.parameters.get("PART", "")
        if part.upper() not in by_name:
            known = ", ".join(map(repr, sections.parts)) or "none"
            raise MeshError(f"{source}: the instance {name!r} is of the part {part!r}; the parts are: {known}.")
        part, content = by_name[part.upper()]
        if own or part not in decks:
            deck = read_deck([*content, *own], source, plane) if _has_nodes([*content, *own]) else _nothing(source)
        else:
            deck = decks[part]
        if not own:
            decks[part] = deck
        out.append(Instance(name, part, deck, _placed(deck.raw.points, head, source)))
    return out


def _nothing(source: str) -> Deck:
    """A part without nodes, such as an analytical surface."""
    return Deck(RawMesh(np.zeros((0, 3)), []), source, joined_numbers([]))


def _placed(points: Array, head: KeywordSection, source: str) -> Array:
    """Points translated by the first data line of *INSTANCE, then rotated by the second.

    The second is two points a and b of the axis and an angle in degrees, right-handed about a - b.
    """
    lines = [[float(v) for v in line.split(",") if v.strip()] for line in head.lines]
    if [len(line) for line in lines] not in ([], [3], [3, 7]):
        raise MeshError(
            f"{source}: the instance {head.parameters.get('NAME', '')!r} is placed by {head.lines}; expected a line of "
            "three numbers (translation), and at most one more of seven (two points of an axis, angle in degrees)."
        )
    if lines:
        points = points + np.array(lines[0])
    if len(lines) == 2:
        a, b, angle = np.array(lines[1][:3]), np.array(lines[1][3:6]), lines[1][6]
        length = np.linalg.norm(b - a)
        if not length > 0:
            raise MeshError(
                f"{source}: the two points of an instance's axis of rotation are the same: {head.lines[1]}."
            )
        points = a + Rotation.from_rotvec((b - a) / length * np.deg2rad(angle)).apply(points - a)
    return points


def _chosen(instances: list[Instance], source: str, part: str | None) -> list[Instance]:
    """The instances with their offsets in the whole mesh; those not selected or without nodes get none."""
    wanted = [i for i in instances if part is None or i.name.upper() == part.upper()]
    if not wanted and part is not None:
        wanted = [i for i in instances if i.part.upper() == part.upper()]
    if part is not None and len(wanted) != 1:
        found = f"has {len(wanted)} instances of the part {part!r}" if wanted else f"has no part {part!r}"
        known = ", ".join(repr(i.name) for i in wanted or instances) or "none"
        raise InputError(f"{source} {found}; its instances are: {known}.")
    out, point, cell = [], 0, 0
    for i in instances:
        if i in wanted and len(i.points):
            out.append(replace(i, first_point=point, first_cell=cell))
            point, cell = point + len(i.points), cell + len(i.deck.kinds)
        else:
            out.append(i)
    return out


def _of_the_assembly(
    sections: list[KeywordSection],
    instances: list[Instance],
    blocks: list[tuple[str, IntArray]],
    kinds: NDArray[np.str_],
    source: str,
    own_nodes: Mapping[int, int],
) -> tuple[dict[str, IntArray], dict[str, IntArray], dict[str, IntArray]]:
    """Node sets, element sets and surfaces that the assembly defines; empty ones are left out.

    `own_nodes` are the places of its own nodes (reference points) by their numbers.
    """
    groups = _assembly_sets(sections, instances, "element", source)
    node_sets = _assembly_sets(sections, instances, "node", source, own_nodes)
    for s in (s for s in sections if s.keyword == "NSET" and "ELSET" in s.parameters):
        elements = _resolved(s.parameters["ELSET"], groups, instances, "element", source)
        name = s.parameters.get("NSET", "")
        node_sets[name] = np.unique(joined_numbers([node_sets.get(name), nodes_of(elements, blocks)]))
    faces = {}
    for s in (s for s in sections if s.keyword == "SURFACE"):
        name = s.parameters.get("NAME", "surface")
        pairs = [member_and_label(line) for line in s.lines]
        kind = s.parameters.get("TYPE", "ELEMENT").upper()
        if kind == "NODE":
            parts = [_resolved(m, node_sets, instances, "node", source) for m, _ in pairs]
            node_sets[name] = np.unique(joined_numbers(parts))
        if kind != "ELEMENT":
            continue  # of nodes, or an analytical surface
        cells = [(_resolved(m, groups, instances, "element", source), label) for m, label in pairs]
        faces[name] = np.concatenate(
            [np.zeros((0, 2), np.int64), *(labelled_faces(c, kinds, label, name) for c, label in cells)]
        )
    return _filled(node_sets), _filled(groups), _filled(faces)


def _filled(sets: dict[str, IntArray]) -> dict[str, IntArray]:
    return {name: members for name, members in sets.items() if len(members)}


def _assembly_sets(
    sections: list[KeywordSection],
    instances: list[Instance],
    what: str,
    source: str,
    own_nodes: Mapping[int, int] | None = None,
) -> dict[str, IntArray]:
    """Sets of nodes or elements that name an instance, or members as ``instance.name``."""
    keyword = "NSET" if what == "node" else "ELSET"
    out: dict[str, IntArray] = {}
    for s in sections:
        if s.keyword != keyword or (what == "node" and "ELSET" in s.parameters):
            continue
        name = s.parameters.get(keyword, "")
        if "INSTANCE" in s.parameters:
            i = _instance(s.parameters["INSTANCE"], instances, source)
            sets = i.deck.raw.node_sets if what == "node" else i.deck.raw.groups
            parts = [i.numbers(listed(s, sets, i.deck, what, name), what)] if i.first_point >= 0 else []
        else:
            # plain numbers refer to the assembly's own nodes, which belong to no solid
            items = [] if "GENERATE" in s.parameters else s.items
            parts = [_resolved(v, out, instances, what, source) for v in items if not v.isdigit()]
            own = [own_nodes[int(v)] for v in items if v.isdigit() and int(v) in own_nodes] if own_nodes else []
            parts.append(np.array(own, dtype=np.int64))
        out[name] = np.unique(joined_numbers([out.get(name), *parts]))
    return out


def _instance(name: str, instances: list[Instance], source: str) -> Instance:
    for i in instances:
        if i.name.upper() == name.upper():
            return i
    known = ", ".join(repr(i.name) for i in instances) or "none"
    raise MeshError(f"{source}: a set names the instance {name!r}; the instances are: {known}.")


def _resolved(item: str, sets: Mapping[str, IntArray], instances: list[Instance], what: str, source: str) -> IntArray:
    """Members of a set of the assembly, of ``instance.set``, or of the only instance that has a set of this name."""
    known = {k.upper(): v for k, v in sets.items()}
    if item.upper() in known:
        return known[item.upper()]
    path, _, name = item.rpartition(".")
    owners = [_instance(path.rpartition(".")[2], instances, source)] if path else instances
    if path and owners[0].first_point < 0:
        return np.zeros(0, np.int64)
    if path or not name.isdigit():
        found = [members for i in owners if (members := i.members(name, what)) is not None]
        if len(found) == 1:
            return found[0]
        if found:
            raise MeshError(f"{source}: the {what} set {item!r} exists in {len(found)} instances; say instance.{item}.")
    raise MeshError(f"{source}: a set or surface names the {what} set {item!r}, which is missing.")
