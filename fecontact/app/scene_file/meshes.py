"""Meshes of a scene file: from a file, a shape or a layer extruded from a surface, with further boundaries.

Sections of a scene file: the shapes of plane and axisymmetric bodies.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial, reduce
from pathlib import Path
from typing import Any

from fecontact.app.scene_file.toml_table import Table, did_you_mean, listed
from fecontact.bodies.elastic import elastic_among
from fecontact.mesh import pick, shapes
from fecontact.mesh import section_shapes as sections
from fecontact.mesh.layer import extrude
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.pick import Pick
from fecontact.mesh.read import read_section, read_surface
from fecontact.mesh.section_mesh import SectionMesh
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.surfaces.repair import repair_surface
from fecontact.surfaces.solid import mesh_solid

ELEMENTS = ("hex8", "hex20", "hex27")
SECTORS = tuple(shapes.SECTORS)
SOURCES = ("mesh", "shape", "solid", "extrude")

#: Readers of the arguments of shapes; a name that ends in ! is required.
Arguments = Mapping[str, Callable[[Table, str, bool], Any]]


def number(table: Table, key: str, required: bool) -> Any:
    """A finite number."""
    return table.number(key, required)


def integer(table: Table, key: str, required: bool) -> Any:
    """An integer."""
    return table.integer(key, required)


def numbers(count: int) -> Callable[[Table, str, bool], Any]:
    """A list of given length of finite numbers."""
    return lambda table, key, required: table.numbers(key, count, required)


def choice(choices: Sequence[str]) -> Callable[[Table, str, bool], Any]:
    """One of given texts."""
    return lambda table, key, required: table.text(key, choices, required)


def divisions(count: int) -> Callable[[Table, str, bool], Any]:
    """Two or three counts or lists of positions."""

    def read(table: Table, key: str, required: bool) -> Any:
        value = table.raw(key, required)
        if value is None:
            return None
        if not isinstance(value, list) or len(value) != count or not all(map(_is_division, value)):
            words = {2: "two", 3: "three"}[count]
            table.fault(key, f"must be {words} counts or lists of increasing positions; found {value!r}.")
            return None
        return tuple(value)

    return read


def _is_division(value: Any) -> bool:
    """Whether a value is a count or a list of numbers."""
    if isinstance(value, list):
        return all(isinstance(v, int | float) and not isinstance(v, bool) for v in value)
    return isinstance(value, int) and not isinstance(value, bool) and value > 0


_RINGS: Arguments = {
    "contact_radius": number,
    "level": integer,
    "sector": choice(SECTORS),
    "element": choice(ELEMENTS),
}
_QUARTER = {k: v for k, v in _RINGS.items() if k != "sector"}

ELASTIC_SHAPES: dict[str, tuple[Callable[..., Mesh], Arguments]] = {
    "block": (shapes.block, {"size!": numbers(3), "divisions!": divisions(3), "element": choice(ELEMENTS)}),
    "thick_ring": (
        shapes.thick_ring,
        {
            "inner!": number,
            "outer!": number,
            "height!": number,
            "divisions": divisions(3),
            "sector": choice(SECTORS),
            "element": choice(ELEMENTS),
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
    "near": lambda table, key, required: table.raw(key, required),
    "near_size": number,
    "growth": number,
    "scale": number,
}
REPAIR: Arguments = {"holes": integer, "smoothing": integer}


def arguments_of(table: Table, arguments: Arguments) -> dict[str, Any]:
    """Arguments given in a table."""
    names = {name.rstrip("!"): name.endswith("!") for name in arguments}
    given = {name: read(table, name, names[name]) for name, read in zip(names, arguments.values(), strict=True)}
    return {name: value for name, value in given.items() if value is not None}


def shape_of(table: Table, known: Mapping[str, tuple[Callable[..., Any], Arguments]]) -> Any:
    """The shape of a table, or None."""
    kind = table.text("kind", tuple(known), required=True)
    if kind is None:
        return None
    make, arguments = known[kind]
    given = arguments_of(table, arguments)
    table.finish()
    return None if table.faulty else table.attempt(lambda: make(**given))


def mesh_of(table: Table, folder: Path, bodies: Mapping[str, Any]) -> Mesh | None:
    """Mesh from a file, a shape or a surface, with the boundaries that the table adds."""
    given = [key for key in SOURCES if key in table]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        table.fault(None, f"needs one of mesh (a file), shape, solid and extrude (tables); found {found}.")
    scale, element, file = table.number("scale"), table.text("element"), table.text("mesh")
    part = table.text("part")
    for key in ("scale", "element", "part"):
        if key in table and "mesh" not in table:
            table.fault(key, "belongs to a mesh from a file; others have their own sizes, elements and parts.")
    mesh: Mesh | None = None
    if "shape" in table:
        mesh = shape_of(table.table("shape"), ELASTIC_SHAPES)
    elif "solid" in table:
        mesh = _solid(table.table("solid"), folder)
    elif "extrude" in table:
        mesh = _extruded(table.table("extrude"), folder, bodies)
    elif file is not None and (path := existing(table, "mesh", folder)) is not None:
        from fecontact.mesh.read import read_mesh

        mesh = table.attempt(lambda: read_mesh(path, 1.0 if scale is None else scale, element, part), "mesh")
    return _with_boundaries(table.table("boundaries"), mesh)


def existing(table: Table, key: str, folder: Path) -> Path | None:
    """The existing file that a key names, else None."""
    file = table.text(key, required=True)
    if file is None:
        return None
    path = folder / file
    if path.is_file():
        return path
    table.fault(key, f"there is no file {path}.")
    return None


def _solid(table: Table, folder: Path) -> Mesh | None:
    """What a CAD file or a closed surface encloses, the surface repaired where that is asked for."""
    path, given, mended = existing(table, "file", folder), arguments_of(table, SOLID), arguments_of(table, REPAIR)
    table.finish()
    if path is None or table.faulty:
        return None
    return table.attempt(lambda: mesh_solid(repair_surface(path, **mended) if mended else path, **given))


def _extruded(table: Table, folder: Path, bodies: Mapping[str, Any]) -> Mesh | None:
    """A layer on a surface from a file, or on the boundary of a body declared earlier."""
    surface: SurfaceMesh | None = None
    if ("surface" in table) == ("body" in table):
        table.fault(None, "needs either surface (a file) or body with boundary.")
    scale, boundary = table.number("scale"), table.text("boundary", required="body" in table)
    part = table.text("part")
    mended = arguments_of(table, {**REPAIR, "size": number})
    if "surface" in table and (path := existing(table, "surface", folder)) is not None:
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
    thickness = table.number("thickness", required=True)
    layers = table.raw("layers")
    flip, strict = table.flag("flip"), table.flag("strict")
    table.finish()
    if surface is None or thickness is None or table.faulty:
        return None
    side = surface.flipped() if flip else surface
    return table.attempt(lambda: extrude(side, thickness, 1 if layers is None else layers, strict=bool(strict)))


def _surface(path: Path, part: str | None, scale: float, mended: Mapping[str, Any]) -> SurfaceMesh:
    """A surface from a file, repaired where that is asked for."""
    if not mended or part is not None:
        found = read_surface(path, part, scale)
        return repair_surface(found, **mended) if mended else found
    return repair_surface(path, scale=scale, **mended)


def section_of(table: Table, folder: Path, known: Mapping[str, tuple[Callable[..., Any], Arguments]]) -> Any:
    """Section from a file or a shape, or None."""
    scale, part = table.number("scale"), table.text("part")
    if "mesh" not in table:
        for key in ("scale", "part"):
            if key in table:
                table.fault(key, "belongs to a section from a file (mesh).")
        return shape_of(table.table("shape", required=True), known)
    if "shape" in table:
        table.fault("shape", "a section is from a file (mesh) or of a shape, not both.")
        table.raw("shape")
    path = existing(table, "mesh", folder)
    if path is None or table.faulty:
        return None
    return table.attempt(lambda: read_section(path, part, 1.0 if scale is None else scale), "mesh")


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


def _picks(table: Table) -> list[Pick]:
    """The conditions plane, box, facing and flood that a table gives."""
    out: list[Pick | None] = []
    if "plane" in table:
        plane = table.table("plane")
        point, normal = plane.numbers("point", required=True), plane.numbers("normal", required=True)
        tolerance = plane.number("tolerance")
        plane.finish()
        if point and normal:
            out.append(plane.attempt(partial(pick.plane, point, normal, tolerance)))
    corners = table.raw("box")
    if corners is not None:
        try:
            low, high = corners
            out.append(table.attempt(partial(pick.box, low, high), "box"))
        except (TypeError, ValueError):
            table.fault("box", f"must be two opposite corners [[x, y, z], [x, y, z]]; found {corners!r}.")
    for key, what, make in (("facing", "direction", pick.facing), ("flood", "seed", pick.flood)):
        if key in table:
            entry = table.table(key)
            vector, angle = entry.numbers(what, required=True), entry.number("angle_deg")
            entry.finish()
            if vector:
                out.append(entry.attempt(partial(make, vector, 30.0 if angle is None else angle)))
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
    "annulus": (
        sections.annulus,
        {"inner!": number, "outer!": number, "divisions": divisions(2), "element": _ELEMENT},
    ),
    "cap": (_cap, {"radius": number, "extent!": number, "depth!": number, "contact_radius!": number, **_GRADED}),
    "half_disc": (sections.half_disc, {"radius!": number, "contact_radius": number, **_GRADED}),
}
