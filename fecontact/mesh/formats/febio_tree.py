"""Trees of FEBio .feb files of all versions: what is in other files put in its place."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from fecontact.common.errors import MeshError

Element = ElementTree.Element

#: Sections of a model file; others at its top are counted as left out.
MESH_SECTIONS = ("Mesh", "Geometry")


def read_tree(path: Path) -> tuple[Element, tuple[str, ...]]:
    """Root of a file, with included files in their places, and the files that are missing.

    ``<Include>file</Include>`` stands for the sections of another file (FEBio user manual, "Include Section"), and
    ``<Geometry from="file">`` or any section with ``from`` for the section of the same name there.

    Raises
    ------
    MeshError
        If a file is not XML, is no model, or files include each other in a circle.
    """
    missing: list[str] = []
    return _model(path, (), missing), tuple(missing)


def _model(path: Path, within: tuple[Path, ...], missing: list[str]) -> Element:
    if path.resolve() in within:
        raise MeshError(f"{within[-1].name} includes {path.name}, which includes it: a circle without an end.")
    try:
        root = ElementTree.parse(path).getroot()
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
            other = _model(path.parent / name, (*within, path.resolve()), missing)
            whole.extend(s for s in other if section.tag in ("Include", s.tag))
    return whole
