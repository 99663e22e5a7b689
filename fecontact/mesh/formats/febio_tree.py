"""Trees of FEBio .feb files of all versions: what is in other files put in its place."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

from fecontact.common.errors import MeshError

Element = ElementTree.Element

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
        raise MeshError(f"{path.name} is no complete XML file: {error}.") from error
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
