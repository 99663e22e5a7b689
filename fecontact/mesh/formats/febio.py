"""FEBio .feb files (specification 2.5, 3 and 4): nodes, elements, surfaces, node and element sets of the mesh."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError
from fecontact.mesh.formats.raw import RawMesh, numbers_of

Element = ElementTree.Element

#: Solid elements by FEBio's names.
SOLIDS = {
    "tet4": "tet4",
    "tet10": "tet10",
    "penta6": "wedge6",
    "penta15": "wedge15",
    "pyra5": "pyramid5",
    "pyra13": "pyramid13",
    "hex8": "hex8",
    "hex20": "hex20",
    "hex27": "hex27",
}
FACETS = {"tri3": 3, "tri6": 3, "tri7": 3, "quad4": 4, "quad8": 4, "quad9": 4}
_SHELLS = ("tri3", "tri6", "quad4", "quad8", "quad9", "q4ans", "q4eas")


def read_febio(path: Path) -> RawMesh:
    """Read the mesh of an FEBio file; parts become element sets.

    Raises
    ------
    MeshError
        If the file is not XML, has no mesh, or refers to undefined items.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise MeshError(f"{path.name} is no complete XML file: {error}.") from error
    mesh = root.find("Mesh")
    mesh = root.find("Geometry") if mesh is None else mesh
    if root.tag != "febio_spec" or mesh is None:
        raise MeshError(f"{path.name} has no <Mesh> section under <febio_spec>; found the root <{root.tag}>.")
    try:
        return _mesh(mesh, path.name)
    except (ValueError, TypeError) as error:
        if isinstance(error, MeshError):
            raise
        raise MeshError(f"{path.name} holds a number that cannot be read: {error}.") from error


def _mesh(mesh: Element, source: str) -> RawMesh:
    ids, points = _nodes(mesh, source)
    blocks: list[tuple[str, IntArray]] = []
    groups: dict[str, IntArray] = {}
    element_ids: list[IntArray] = []
    start = 0
    for section in mesh.findall("Elements"):
        kind = section.get("type", "").lower()
        rows = _rows(section, "elem", source)
        if kind in _SHELLS or not len(rows):
            continue
        if kind not in SOLIDS:
            raise MeshError(f"{source} holds elements of the type {kind!r}; expected one of {', '.join(SOLIDS)}.")
        blocks.append((SOLIDS[kind], numbers_of(ids, rows, "node", source)))
        element_ids.append(_ids(section, "elem"))
        name = section.get("name") or section.get("elset") or f"part_{len(blocks)}"
        groups[name] = np.concatenate([groups.get(name, np.zeros(0, np.int64)), start + np.arange(len(rows))])
        start += len(rows)
    all_elements = np.concatenate(element_ids) if element_ids else np.zeros(0, np.int64)
    for section in mesh.findall("ElementSet"):
        groups[section.get("name", "set")] = numbers_of(all_elements, _members(section), "element", source)
    facets: dict[str, list[IntArray]] = {}
    for section in mesh.findall("Surface"):
        for tag, n in FACETS.items():
            rows = _rows(section, tag, source)
            if len(rows):
                facets.setdefault(section.get("name", "surface"), []).append(
                    numbers_of(ids, rows[:, :n], "node", source)
                )
    node_sets = {
        section.get("name", "nodes"): numbers_of(ids, _members(section), "node", source)
        for section in mesh.findall("NodeSet")
    }
    for section in mesh.findall("Nodes"):
        if section.get("name"):
            node_sets.setdefault(section.get("name", ""), numbers_of(ids, _ids(section, "node"), "node", source))
    return RawMesh(points, blocks, groups, facets, {}, node_sets)


def _nodes(mesh: Element, source: str) -> tuple[IntArray, Array]:
    nodes = [node for section in mesh.findall("Nodes") for node in section.findall("node")]
    if not nodes:
        raise MeshError(f"{source} defines no nodes.")
    ids = np.array([node.get("id") for node in nodes], dtype=np.int64)
    rows = [(node.text or "").split(",") for node in nodes]
    wrong = next((k for k, row in enumerate(rows) if len(row) != 3), None)
    if wrong is not None:
        raise MeshError(f"{source}: node {ids[wrong]} has {len(rows[wrong])} coordinates; expected 3.")
    return ids, np.array(rows, dtype=float)


def _rows(section: Element, tag: str, source: str) -> IntArray:
    """Node numbers (n, k) of the entries of a section."""
    rows = [(entry.text or "").split(",") for entry in section.findall(tag)]
    if len({len(row) for row in rows}) > 1:
        raise MeshError(
            f"{source}: the section {section.get('name')!r} has entries <{tag}> with different numbers of nodes."
        )
    return np.array(rows, dtype=np.int64)


def _ids(section: Element, tag: str) -> IntArray:
    return np.array([entry.get("id") for entry in section.findall(tag)], dtype=np.int64)


def _members(section: Element) -> IntArray:
    """Numbers in a set: entries with an id, or a comma-separated list."""
    entries = [entry.get("id") for entry in section]
    listed = (section.text or "").replace(",", " ").split()
    return np.array(entries if entries else listed, dtype=np.int64)
