"""Meshes of a scene file: from a file, a shape or a layer extruded from a surface, with further boundaries.

Sections of a scene file: the shapes of plane and axisymmetric bodies.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial, reduce
from pathlib import Path
from typing import Any

from fecontact.app.scene_file.toml_table import (
    Arguments,
    Reader,
    Table,
    choice,
    flag,
    integer,
    listed,
    number,
    numbers,
)
from fecontact.bodies.elastic import elastic_among
from fecontact.common.errors import did_you_mean
from fecontact.mesh import pick, shapes
from fecontact.mesh import section_shapes as sections
from fecontact.mesh.layer import extrude
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.pick import Pick
from fecontact.mesh.read import read_mesh, read_section, read_surface
from fecontact.mesh.section_mesh import SectionMesh
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.surfaces.repair import repair_surface
from fecontact.surfaces.solid import mesh_solid

ELEMENT = choice(("hex8", "hex20", "hex27"))
SECTOR = choice(tuple(shapes.SECTORS))


def divisions(count: int) -> Reader:
    """Two or three counts or lists of positions."""

    def read(table: Table, key: str, required: bool) -> Any:
        value = table.raw(key, required)
        if value is None or (isinstance(value, list) and len(value) == count and all(map(_is_division, value))):
            return value and tuple(value)
        words = {2: "two", 3: "three"}[count]
        table.fault(key, f"must be {words} counts or lists of increasing positions; found {value!r}.")
        return None

    return read


def _is_division(value: Any) -> bool:
    """Whether a value is a count or a list of numbers."""
    if isinstance(value, list):
        return all(isinstance(v, int | float) and not isinstance(v, bool) for v in value)
    return isinstance(value, int) and not isinstance(value, bool) and value > 0


_RINGS: Arguments = {"contact_radius": number, "level": integer, "sector": SECTOR, "element": ELEMENT}
_QUARTER = {k: v for k, v in _RINGS.items() if k != "sector"}

ELASTIC_SHAPES: dict[str, tuple[Callable[..., Mesh], Arguments]] = {
    "block": (shapes.block, {"size!": numbers(3), "divisions!": divisions(3), "element": ELEMENT}),
    "thick_ring": (
        shapes.thick_ring,
        {
            "inner!": number,
            "outer!": number,
            "height!": number,
            "divisions": divisions(3),
            "sector": SECTOR,
            "element": ELEMENT,
        },
    ),
    "cap": (shapes.cap, {"radius!": number, "extent!": number, "depth!": number, **_RINGS}),
    "cylinder": (shapes.cylinder, {"radius!": number, "height!": number, **_RINGS}),
    "half_sphere": (shapes.half_sphere, {"radius!": number, **_RINGS}),
    "quarter_sphere": (shapes.quarter_sphere, {"radius!": number, **_QUARTER}),
    "sphere": (shapes.sphere, {"radius!": number, **_RINGS}),
}


#: Arguments of `mesh_solid` and of `repair_surface`.
SOLID: Arguments = {
    "size": number,
    "element": choice(("tet10", "hex20", "tet4", "hex8")),
    "near": Table.raw,
    "near_size": number,
    "growth": number,
    "scale": number,
    "part": choice(),
}
REPAIR: Arguments = {"holes": integer, "smoothing": integer}


def shape_of(table: Table, known: Mapping[str, tuple[Callable[..., Any], Arguments]]) -> Any:
    """The shape of a table, or None."""
    kind = table.text("kind", tuple(known), required=True)
    return None if kind is None else table.make(*known[kind])


def mesh_of(table: Table, folder: Path, bodies: Mapping[str, Any]) -> Mesh | None:
    """Mesh from a file, a shape or a surface, with the boundaries that the table adds."""
    sources: dict[str, Callable[[], Mesh | None]] = {
        "mesh": lambda: _from_file(table, folder),
        "shape": lambda: shape_of(table.table("shape"), ELASTIC_SHAPES),
        "solid": lambda: _solid(table.table("solid"), folder),
        "extrude": lambda: _extruded(table.table("extrude"), folder, bodies),
    }
    given = [key for key in sources if key in table]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        table.fault(None, f"needs one of mesh (a file), shape, solid and extrude (tables); found {found}.")
    for key in ("scale", "element", "part", *sources):
        table.raw(key)
        if key in ("scale", "element", "part") and key in table and "mesh" not in table:
            table.fault(key, "belongs to a mesh from a file; others have their own sizes, elements and parts.")
    # where several are given, a table is read rather than a file, for its faults
    chosen = next((key for key in ("shape", "solid", "extrude", "mesh") if key in table), None)
    return _with_boundaries(table.table("boundaries"), None if chosen is None else sources[chosen]())


def _from_file(table: Table, folder: Path) -> Mesh | None:
    given = table.read({"scale": number, "element": choice(), "part": choice()})
    path = existing(folder)(table, "mesh", True)
    return None if path is None else table.attempt(lambda: read_mesh(path, **given), "mesh")


def existing(folder: Path) -> Reader:
    """An existing file, relative to a folder."""

    def read(table: Table, key: str, required: bool) -> Path | None:
        file = table.text(key, required=required)
        if file is None or (folder / file).is_file():
            return None if file is None else folder / file
        table.fault(key, f"there is no file {folder / file}.")
        return None

    return read


def _solid(table: Table, folder: Path) -> Mesh | None:
    """What a CAD file or a closed surface encloses, the surface repaired where that is asked for."""

    def make(file: Path, **given: Any) -> Mesh:
        mended = {key: given.pop(key) for key in REPAIR if key in given}
        return mesh_solid(repair_surface(file, **mended) if mended else file, **given)

    return table.make(make, {"file!": existing(folder), **SOLID, **REPAIR})


def _extruded(table: Table, folder: Path, bodies: Mapping[str, Any]) -> Mesh | None:
    """A layer on a surface from a file, or on the boundary of a body declared earlier."""
    surface: SurfaceMesh | None = None
    if ("surface" in table) == ("body" in table):
        table.fault(None, "needs either surface (a file) or body with boundary.")
    scale, boundary = table.number("scale"), table.text("boundary", required="body" in table)
    part = table.text("part")
    mended = table.read({**REPAIR, "size": number})
    if "surface" in table and (path := existing(folder)(table, "surface", True)) is not None:
        surface = table.attempt(lambda: _surface(path, part, 1.0 if scale is None else scale, mended), "surface")
    for key in mended if "body" in table else ():
        table.fault(key, "belongs to a surface from a file.")
    name = table.text("body")
    elastic = elastic_among([bodies.get(name or "")])
    if name is not None and name not in bodies:
        table.fault("body", f"no body {name!r} is declared before this one{did_you_mean(name, bodies)}.")
    elif boundary is not None and elastic:
        surface = table.attempt(lambda: SurfaceMesh.of(elastic[0].mesh, boundary), "boundary")
    elif name is not None and bodies[name] is not None and not elastic:
        table.fault("body", f"{name!r} has no mesh; a layer grows on an elastic body.")

    def make(thickness: float, layers: Any = 1, flip: bool = False, strict: bool = False) -> Mesh | None:
        if surface is None:
            return None
        return extrude(surface.flipped() if flip else surface, thickness, layers, strict=strict)

    return table.make(make, {"thickness!": number, "layers": Table.raw, "flip": flag, "strict": flag})


def _surface(path: Path, part: str | None, scale: float, mended: Mapping[str, Any]) -> SurfaceMesh:
    """A surface from a file, repaired where that is asked for."""
    if not mended or part is not None:
        found = read_surface(path, part, scale)
        return repair_surface(found, **mended) if mended else found
    return repair_surface(path, scale=scale, **mended)


def section_of(table: Table, folder: Path) -> SectionMesh | None:
    """Section from a file or a shape, or None."""
    given = table.read({"scale": number, "part": choice()})
    if "mesh" not in table:
        for key in given:
            table.fault(key, "belongs to a section from a file (mesh).")
        return shape_of(table.table("shape", required=True), SHAPES)
    if "shape" in table:
        table.fault("shape", "a section is from a file (mesh) or of a shape, not both.")
        table.raw("shape")
    path = existing(folder)(table, "mesh", True)
    return None if path is None or table.faulty else table.attempt(lambda: read_section(path, **given), "mesh")


def _with_boundaries(table: Table, mesh: Mesh | None) -> Mesh | None:
    """The mesh with further boundaries: outer faces that satisfy all conditions of a table."""
    for name, entry in table.subtables():
        picks = _picks(entry)
        if not picks and not entry.faulty:
            entry.fault(None, "needs at least one of plane, box, facing and flood.")
        if mesh is None or not picks or entry.faulty:
            continue
        chosen = reduce(lambda a, b: a & b, picks)
        found = entry.attempt(partial(mesh.with_boundary, name, chosen))
        mesh = mesh if found is None else found
    return mesh


_POINT = numbers(3)
#: Conditions on outer faces that are tables.
PICKS: dict[str, tuple[Callable[..., Pick], Arguments]] = {
    "plane": (pick.plane, {"point!": _POINT, "normal!": _POINT, "tolerance": number}),
    "facing": (
        lambda direction, angle_deg=30.0: pick.facing(direction, angle_deg),
        {"direction!": _POINT, "angle_deg": number},
    ),
    "flood": (lambda seed, angle_deg=30.0: pick.flood(seed, angle_deg), {"seed!": _POINT, "angle_deg": number}),
}


def _picks(table: Table) -> list[Pick]:
    """The conditions plane, box, facing and flood that a table gives."""
    out = [table.table(key).make(*how) for key, how in PICKS.items() if key in table]
    corners = table.raw("box")
    if corners is not None:
        try:
            low, high = corners
            out.append(table.attempt(partial(pick.box, low, high), "box"))
        except (TypeError, ValueError):
            table.fault("box", f"must be two opposite corners [[x, y, z], [x, y, z]]; found {corners!r}.")
    table.finish()
    return [p for p in out if p is not None]


def check_name(table: Table, key: str, name: str, known: Mapping[str, Any], what: str) -> None:
    """Record a fault if a mesh does not have a name."""
    if name not in known:
        table.fault(key, f"the mesh has no {what} {name!r}{did_you_mean(name, known)}; there are: {listed(known)}.")


def _cap(radius: float = math.inf, **given: Any) -> SectionMesh:
    """A cap, flat unless it has a radius."""
    return sections.cap(radius, **given)


_ELEMENT = choice(tuple(sections.ELEMENTS))
_GRADED: Arguments = {"level": integer, "element": _ELEMENT}

SHAPES: dict[str, tuple[Callable[..., SectionMesh], Arguments]] = {
    "rectangle": (
        sections.rectangle,
        {"size!": numbers(2), "divisions!": divisions(2), "start": number, "element": _ELEMENT},
    ),
    "ring": (
        sections.ring,
        {"inner!": number, "outer!": number, "height!": number, "divisions!": divisions(2), "element": _ELEMENT},
    ),
    "annulus": (sections.annulus, {"inner!": number, "outer!": number, "divisions": divisions(2), "element": _ELEMENT}),
    "cap": (_cap, {"radius": number, "extent!": number, "depth!": number, "contact_radius!": number, **_GRADED}),
    "half_disc": (sections.half_disc, {"radius!": number, "contact_radius": number, **_GRADED}),
}
