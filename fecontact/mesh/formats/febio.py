"""FEBio .feb files (specification 1.2 to 4.0): nodes, elements, surfaces, node and element sets of the mesh.

Trees of FEBio .feb files of all versions: what is in other files put in its place.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np
from scipy.spatial.transform import Rotation

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError
from fecontact.mesh.formats.raw import RawMesh, joined_numbers, known_members, numbers_of
from fecontact.mesh.kinds import KINDS

#: Sections of a model file that hold its mesh.
MESH_SECTIONS = ("Mesh", "Geometry")
#: Tags of nodes, cells, facets and members of sets.
ENTRIES = {
    "node",
    "elem",
    "n",
    "tri3",
    "tri6",
    "tri7",
    "quad4",
    "quad8",
    "quad9",
    "hex8",
    "tet4",
    "penta6",
    "e",
    "face",
}


def read_tree(path: Path, numbered: bool = False) -> tuple[Element, tuple[str, ...]]:
    """Root of a file, with included files in their places, and the files that are missing.

    With `numbered`, elements have their line as the attribute ``line``, and nodes and cells are left out.

    ``<Include>file</Include>`` stands for the sections of another file (FEBio user manual, "Include Section"), and
    ``<Geometry from="file">`` or any section with ``from`` for the section of the same name there.

    Raises
    ------
    MeshError
        If a file is not XML, is no model, or files include each other in a circle.
    """
    missing: list[str] = []
    return _model(path, (), missing, _numbered if numbered else _plain), tuple(missing)


def _plain(path: Path) -> Element:
    return ElementTree.parse(path).getroot()


def _numbered(path: Path) -> Element:
    """Root with lines; entries of the mesh, whose tags repeat a thousand times, are left out."""
    builder, parser = ElementTree.TreeBuilder(), expat.ParserCreate()
    open_tags: list[bool] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        open_tags.append(tag not in ENTRIES)
        if open_tags[-1]:
            builder.start(tag, {**attributes, "line": f"{path.name}, line {parser.CurrentLineNumber}"})

    def end(tag: str) -> None:
        if open_tags.pop():
            builder.end(tag)

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = lambda text: builder.data(text) if open_tags and open_tags[-1] else None
    try:
        parser.Parse(path.read_bytes(), True)
    except expat.ExpatError as error:
        raise ElementTree.ParseError(str(error)) from None
    return builder.close()


def _model(path: Path, within: tuple[Path, ...], missing: list[str], parse: Callable[[Path], Element]) -> Element:
    if path.resolve() in within:
        raise MeshError(f"{within[-1].name} includes {path.name}, which includes it: a circle without an end.")
    try:
        root = parse(path)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise MeshError(f"{path.name} is no complete XML file: {error}.", code="incomplete-xml") from error
    if root.tag != "febio_spec":
        raise MeshError(f"{path.name} is no FEBio model, whose root is <febio_spec>; found the root <{root.tag}>.")
    whole = ElementTree.Element(root.tag, root.attrib)
    for section in root:
        name = section.get("from") or ((section.text or "").strip() if section.tag == "Include" else "")
        if not name:
            whole.append(section)
        elif not (path.parent / name).is_file():
            missing.append(name)
        else:
            other = _model(path.parent / name, (*within, path.resolve()), missing, parse)
            whole.extend(s for s in other if section.tag in ("Include", s.tag))
    return whole


Element = ElementTree.Element

#: Solid elements by FEBio's names; of 15-node tetrahedra the nodes of faces and centre are left out.
SOLIDS = {name.replace("wedge", "penta").replace("pyramid", "pyra"): name for name in KINDS} | {"tet15": "tet10"}
FACETS = {"tri3": 3, "tri6": 3, "tri7": 3, "tri10": 3, "quad4": 4, "quad8": 4, "quad9": 4}
SHELLS = {**FACETS, "q4ans": 4, "q4eas": 4}


def read_febio(path: Path) -> RawMesh:
    """Read the mesh of an FEBio file; parts become element sets, shells are kept apart.

    Raises
    ------
    MeshError
        If the file is not XML, has no mesh, or refers to undefined nodes.
    """
    root, missing = read_tree(path)
    sections = [s for tag in MESH_SECTIONS for s in root.findall(tag)]
    if not sections:
        also = f" Files that it includes are missing: {', '.join(missing)}." if missing else ""
        raise MeshError(f"{path.name} has no <Mesh> or <Geometry> section under <febio_spec>.{also}", code="no-mesh")
    try:
        own = _mesh([s for section in sections for s in section], "", path.name)
        raw = RawMesh.joined([own, *_parts(sections, path.name)])
    except (ValueError, TypeError, OverflowError) as error:
        if isinstance(error, MeshError):
            raise
        raise MeshError(f"{path.name} holds a number that cannot be read: {error}.", code="bad-number") from error
    if not len(raw.points):
        raise MeshError(f"{path.name} defines no nodes.")
    left = Counter(raw.left) + Counter({f"file to be included, {name}, which is missing": 1 for name in missing})
    return replace(raw, left=left)


def _parts(sections: Sequence[Element], source: str) -> list[RawMesh]:
    """Meshes of <Part>s that are instances, and of <Instance>s of parts, in their places (specification 2.5)."""
    parts = {p.get("name", ""): p for section in sections for p in section.findall("Part")}
    out = [_mesh(list(p), f"{name}.", source) for name, p in parts.items() if p.get("type") == "instance"]
    for i in (i for section in sections for i in section.findall("Instance")):
        name = i.get("part", "")
        if name not in parts:
            raise MeshError(
                f"{source}: an instance is of the part {name!r}; the parts are: {', '.join(parts) or 'none'}.",
                code="unknown-part",
            )
        raw = _mesh(list(parts[name]), f"{i.get('name', name)}.", source)
        out.append(replace(raw, points=_placed(raw.points, i, source)))
    return out


def _placed(points: Array, instance: Element, source: str) -> Array:
    """Points scaled, rotated and then translated as an instance says."""
    scale, shift = (_vector(instance, tag, 3, default) for tag, default in (("scale", 1.0), ("translate", 0.0)))
    rotate = instance.find("rotate")
    turn = Rotation.identity()
    if rotate is not None:
        kind = rotate.get("type", "quaternion")
        if kind not in ("quaternion", "vector"):
            raise MeshError(f"{source}: an instance is rotated by {kind} angles; write a quaternion or a vector.")
        make, n = (Rotation.from_quat, 4) if kind == "quaternion" else (Rotation.from_rotvec, 3)
        turn = make(_vector(instance, "rotate", n, 0.0))
    return np.asarray(turn.apply(scale * points) + shift)


def _vector(parent: Element, tag: str, count: int, default: float) -> Array:
    text = parent.findtext(tag)
    values = np.full(count, default) if text is None else np.array(text.split(","), dtype=float)
    if len(values) != count:
        raise MeshError(f"<{tag}> needs {count} numbers; found {text!r}.")
    return values


def _mesh(sections: Sequence[Element], prefix: str, source: str) -> RawMesh:
    """Mesh of sections that share their numbers; `prefix` comes before its names."""
    ids, points = _nodes(sections, source)
    blocks: list[tuple[str, IntArray]] = []
    groups: dict[str, list[IntArray]] = {}
    numbers: dict[str, list[IntArray]] = {"solid": [], "other": []}
    shells: dict[str, list[IntArray]] = {}
    left: Counter[str] = Counter()
    start = 0
    for name, kind, entries in _elements(sections):
        numbers["solid" if kind in SOLIDS else "other"].append(_ids(entries))
        if kind not in SOLIDS and kind not in SHELLS:
            left[f"elements of type {kind}"] += len(entries)
            continue
        rows = numbers_of(ids, _rows(entries, name, source), "node", source)
        if kind in SHELLS:
            shells.setdefault(prefix + name, []).append(rows[:, : SHELLS[kind]])
            continue
        blocks.append((SOLIDS[kind], rows[:, :10] if kind == "tet15" else rows))
        groups.setdefault(prefix + (name or f"part_{len(blocks)}"), []).append(start + np.arange(len(rows)))
        start += len(rows)
    solid, other = map(joined_numbers, numbers.values())
    sets = {name: np.concatenate(members) for name, members in groups.items()}
    for s in (s for s in sections if s.tag == "ElementSet"):
        name = prefix + s.get("name", "set")
        sets[name] = known_members(solid, _members(s), other, left, name, "element")
    facets: dict[str, list[IntArray]] = {}
    for s in (s for s in sections if s.tag == "Surface"):
        for tag, n in FACETS.items():
            if entries := s.findall(tag):
                rows = numbers_of(ids, _rows(entries, s.get("name"), source)[:, :n], "node", source)
                facets.setdefault(prefix + s.get("name", "surface"), []).append(rows)
    named = _node_sets(sections, ids, prefix, left)
    return RawMesh(
        points, blocks, sets, facets, node_sets=named, shells=shells, left=left, node_ids=ids, element_ids=solid
    )


def _elements(sections: Sequence[Element]) -> list[tuple[str, str, list[Element]]]:
    """Name, type and entries of each block; before version 2 the entries' tags are the types, their `mat` the names."""
    out = []
    for s in (s for s in sections if s.tag == "Elements"):
        name = s.get("name") or s.get("elset") or ""
        if s.findall("elem") or s.get("type"):
            out.append((name, s.get("type", "").lower(), s.findall("elem")))
            continue
        blocks: dict[tuple[str, str], list[Element]] = {}
        for entry in s:
            blocks.setdefault((name or f"material_{entry.get('mat')}", entry.tag.lower()), []).append(entry)
        out += [(*key, entries) for key, entries in blocks.items()]
    return [block for block in out if block[2]]


def _nodes(sections: Sequence[Element], source: str) -> tuple[IntArray, Array]:
    nodes = [node for section in sections if section.tag == "Nodes" for node in section.findall("node")]
    rows = [(node.text or "").split(",") for node in nodes]
    ids = _ids(nodes)
    wrong = next((k for k, row in enumerate(rows) if len(row) != 3), None)
    if wrong is not None:
        raise MeshError(f"{source}: node {ids[wrong]} has {len(rows[wrong])} coordinates; expected 3.", code="no-point")
    return ids, np.array(rows, dtype=float).reshape(-1, 3)


def _node_sets(sections: Sequence[Element], ids: IntArray, prefix: str, left: dict[str, int]) -> dict[str, IntArray]:
    """Node sets by name, which may name others, and blocks of nodes that have a name."""
    out: dict[str, IntArray] = {}
    none = np.zeros(0, np.int64)
    for s in (s for s in sections if s.tag == "NodeSet"):
        name = prefix + s.get("name", "nodes")
        others = [out[prefix + n] for e in s if e.get("id") is None and prefix + (n := (e.text or "").strip()) in out]
        out[name] = np.concatenate([known_members(ids, _members(s), none, left, name, "node"), *others])
    for s in (s for s in sections if s.tag == "Nodes" and s.get("name")):
        out.setdefault(prefix + s.get("name", ""), numbers_of(ids, _ids(s.findall("node")), "node", "the file"))
    return out


def _rows(entries: Sequence[Element], name: str | None, source: str) -> IntArray:
    """Node numbers (n, k) of the entries of a section."""
    rows = [(entry.text or "").split(",") for entry in entries]
    if len({len(row) for row in rows}) > 1:
        raise MeshError(
            f"{source}: the section {name!r} has entries <{entries[0].tag}> with different numbers of nodes."
        )
    return np.array(rows, dtype=np.int64)


def _ids(entries: Sequence[Element]) -> IntArray:
    return np.array([entry.get("id") for entry in entries], dtype=np.int64)


def _members(section: Element) -> IntArray:
    """Numbers in a set: entries with an id, or a comma-separated list with ranges ``first:last:step``."""
    entries = [entry.get("id") for entry in section if entry.get("id") is not None]
    listed = [[int(v) for v in word.split(":")] for word in (section.text or "").replace(",", " ").split()]
    ranges = [np.arange(r[0], r[1] + 1, r[2] if len(r) > 2 else 1) for r in listed if len(r) > 1]
    single = np.array(entries if entries else [r[0] for r in listed if len(r) == 1], dtype=np.int64)
    return np.concatenate([single, *ranges]).astype(np.int64)
