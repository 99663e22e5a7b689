"""Materials and bodies of a scene file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fecontact import surfaces
from fecontact.bodies import ElasticBody, Plane, RigidBody, Sphere, rotation_about
from fecontact.errors import FecontactError, InputError
from fecontact.fem.support import Support, checked_support
from fecontact.material import Material
from fecontact.mesh import shapes
from fecontact.mesh.mesh import Mesh
from fecontact.tomltable import Table, did_you_mean, listed

ELEMENTS = ("hex8", "hex20", "hex27")
SECTORS = tuple(shapes.SECTORS)

#: How each argument of a shape is read; a name that ends in ! must be given.
Arguments = Mapping[str, Callable[[Table, str, bool], Any]]


def _number(table: Table, key: str, required: bool) -> Any:
    return table.number(key, required)


def _integer(table: Table, key: str, required: bool) -> Any:
    return table.integer(key, required)


def _numbers(count: int) -> Callable[[Table, str, bool], Any]:
    return lambda table, key, required: table.numbers(key, count, required)


def _choice(choices: Sequence[str]) -> Callable[[Table, str, bool], Any]:
    return lambda table, key, required: table.text(key, choices, required)


def _divisions(table: Table, key: str, required: bool) -> Any:
    """Three counts, or lists of positions in their place."""
    value = table.raw(key, required)
    if value is None:
        return None
    if not isinstance(value, list) or len(value) != 3 or not all(map(_is_division, value)):
        table.fault(key, f"must be three counts or lists of increasing positions; found {value!r}.")
        return None
    return tuple(value)


def _is_division(value: Any) -> bool:
    if isinstance(value, list):
        return all(isinstance(v, int | float) and not isinstance(v, bool) for v in value)
    return isinstance(value, int) and not isinstance(value, bool) and value > 0


_RINGS: Arguments = {
    "contact_radius": _number,
    "level": _integer,
    "sector": _choice(SECTORS),
    "element": _choice(ELEMENTS),
}
_QUARTER = {k: v for k, v in _RINGS.items() if k != "sector"}

ELASTIC_SHAPES: dict[str, tuple[Callable[..., Mesh], Arguments]] = {
    "block": (shapes.block, {"size!": _numbers(3), "divisions!": _divisions, "element": _choice(ELEMENTS)}),
    "thick_ring": (
        shapes.thick_ring,
        {
            "inner!": _number,
            "outer!": _number,
            "height!": _number,
            "divisions": _divisions,
            "sector": _choice(SECTORS),
            "element": _choice(ELEMENTS),
        },
    ),
    "cap": (shapes.cap, {"radius!": _number, "extent!": _number, "depth!": _number, **_RINGS}),
    "cylinder": (shapes.cylinder, {"radius!": _number, "height!": _number, **_RINGS}),
    "half_sphere": (shapes.half_sphere, {"radius!": _number, **_RINGS}),
    "quarter_sphere": (shapes.quarter_sphere, {"radius!": _number, **_QUARTER}),
    "sphere": (shapes.sphere, {"radius!": _number, **_RINGS}),
}


def _cone(angle_deg: float) -> surfaces.Cone:
    return surfaces.Cone(math.radians(angle_deg))


RIGID_SHAPES: dict[str, tuple[Callable[..., Any], Arguments]] = {
    "plane": (Plane, {"size": _number}),
    "sphere": (Sphere, {"radius!": _number}),
    "paraboloid": (surfaces.Paraboloid, {"radius_x!": _number, "radius_y": _number}),
    "cylinder": (surfaces.Cylinder, {"radius!": _number, "length": _number}),
    "cone": (_cone, {"angle_deg!": _number}),
    "flat_punch": (surfaces.FlatPunch, {"radius": _number, "sides": _numbers(2)}),
    "ellipsoid": (surfaces.Ellipsoid, {"semi_axes!": _numbers(3)}),
    "torus": (surfaces.Torus, {"ring!": _number, "tube!": _number}),
}


def read_materials(table: Table) -> dict[str, Material | None]:
    """Materials by name; None for those that could not be made."""
    out: dict[str, Material | None] = {}
    for name, entry in table.subtables():
        E, nu = entry.number("E", required=True), entry.number("nu", required=True)
        density = entry.number("density")
        entry.finish()
        out[name] = None
        if E is not None and nu is not None:
            out[name] = _made(entry, None, partial(Material, E, nu, density))
    return out


def read_bodies(
    table: Table, materials: Mapping[str, Material | None], folder: Path
) -> dict[str, ElasticBody | RigidBody | None]:
    """Bodies by name; None for those that could not be made."""
    out: dict[str, ElasticBody | RigidBody | None] = {}
    for name, entry in table.subtables():
        kind = entry.text("type", ("elastic", "rigid")) or "elastic"
        body = _elastic(name, entry, materials, folder) if kind == "elastic" else _rigid(name, entry)
        pose = _pose(entry.table("pose"))
        entry.finish()
        out[name] = body if body is None or pose is None else body.placed(*pose)
    return out


def _made(table: Table, key: str | None, make: Callable[[], Any]) -> Any:
    """What `make` makes; its refusal is a fault at the key."""
    try:
        return make()
    except FecontactError as error:
        table.fault(key, str(error))
        return None


def _shape(table: Table, known: Mapping[str, tuple[Callable[..., Any], Arguments]]) -> Any:
    """The shape that a table describes, or None."""
    kind = table.text("kind", tuple(known), required=True)
    if kind is None:
        return None
    make, arguments = known[kind]
    given = {name.rstrip("!"): read(table, name.rstrip("!"), name.endswith("!")) for name, read in arguments.items()}
    table.finish()
    if table.faults.touched(table.place):
        return None
    return _made(table, None, lambda: make(**{k: v for k, v in given.items() if v is not None}))


def _mesh(table: Table, folder: Path) -> Mesh | None:
    """From a file or a shape, whichever is given."""
    if ("mesh" in table) == ("shape" in table):
        table.fault(None, "needs either a mesh (a file) or a shape (a table).")
    scale, element = table.number("scale"), table.text("element")
    mesh: Mesh | None = None
    if "shape" in table:
        for key in ("scale", "element"):
            if key in table:
                table.fault(key, "belongs to a mesh from a file; a shape has its own sizes and element.")
        mesh = _shape(table.table("shape"), ELASTIC_SHAPES)
    file = table.text("mesh")
    if file is None:
        return mesh
    path = folder / file
    if not path.is_file():
        table.fault("mesh", f"there is no file {path}.")
        return mesh
    from fecontact.mesh.read import read_mesh

    mesh = _made(table, "mesh", lambda: read_mesh(path, scale=1.0 if scale is None else scale, element=element))
    return mesh


def _elastic(name: str, table: Table, materials: Mapping[str, Material | None], folder: Path) -> ElasticBody | None:
    mesh = _mesh(table, folder)
    material = _material_of(table, materials, mesh)
    contact = table.texts("contact") or ()
    supports = _supports(table.table("supports"))
    options: dict[str, Any] = {
        "pressure": table.text("pressure", ("midface", "nodal")),
        "backend": table.text("backend", ("auto", "pardiso", "superlu")),
        "integration": table.text("integration", ("auto", "full", "selective")),
    }
    if mesh is not None:
        for boundary in contact:
            _check_name(table, "contact", boundary, mesh.boundaries, "boundary")
        for boundary in supports:
            known = {**mesh.boundaries, **mesh.node_sets}
            _check_name(table.table("supports"), boundary, boundary, known, "boundary")
    if mesh is None or material is None or table.faults.touched(table.place):
        return None
    given = {k: v for k, v in options.items() if v is not None}
    body: ElasticBody | None = _made(
        table, None, lambda: ElasticBody(mesh, material, contact, supports, name=name, **given)
    )
    return body


def _check_name(table: Table, key: str, name: str, known: Mapping[str, Any], what: str) -> None:
    if name not in known:
        table.fault(key, f"the mesh has no {what} {name!r}{did_you_mean(name, known)}; there are: {listed(known)}.")


def _material_of(
    table: Table, materials: Mapping[str, Material | None], mesh: Mesh | None
) -> Material | dict[str, Material] | None:
    """One material by its name, or a table of them by element set; None if any could not be made."""
    given = table.raw("material", required=True)
    if given is None:
        return None
    if isinstance(given, str):
        return _material_named(table, "material", given, materials)
    if not isinstance(given, dict):
        table.fault("material", f"must be the name of a material or a table of names by element set; found {given!r}.")
        return None
    entry = table.table("material")
    out = {}
    for group in entry.values:
        if mesh is not None:
            _check_name(entry, group, group, mesh.groups, "element set")
        name = entry.text(group)
        if name is not None:
            out[group] = _material_named(entry, group, name, materials)
    made = {k: v for k, v in out.items() if v is not None}
    return made if len(made) == len(entry.values) else None


def _material_named(table: Table, key: str, name: str, materials: Mapping[str, Material | None]) -> Material | None:
    if name not in materials:
        hint = did_you_mean(name, materials)
        table.fault(key, f"unknown material {name!r}{hint}; the materials are: {listed(materials)}.")
    return materials.get(name)


def _supports(table: Table) -> dict[str, Support]:
    out = {}
    for boundary in table.values:
        support = table.raw(boundary)
        try:
            checked_support(boundary, support)
            out[boundary] = support
        except InputError:
            expected = "must be components out of x, y, z, n such as 'xyz', or one direction or more such as [1, 1, 0]"
            table.fault(boundary, f"{expected}; found {support!r}.")
    return out


def _rigid(name: str, table: Table) -> RigidBody | None:
    shape = _shape(table.table("shape", required=True), RIGID_SHAPES) if "shape" in table else None
    if "shape" not in table:
        table.fault("shape", f"is missing; the shapes of rigid bodies are: {listed(RIGID_SHAPES)}.")
    return None if shape is None else RigidBody(shape, name)


def _pose(table: Table) -> tuple[Any, Any] | None:
    """Translation and rotation matrix; None if wrong."""
    translation = table.numbers("translation") or (0.0, 0.0, 0.0)
    rotation = np.eye(3)
    if "rotation" in table:
        turn = table.table("rotation")
        axis, angle = turn.numbers("axis", required=True), turn.number("angle_deg", required=True)
        turn.finish()
        if axis is not None and angle is not None:
            rotation = _made(turn, "axis", lambda: rotation_about(axis, math.radians(angle)))
    table.finish()
    return None if table.faults.touched(table.place) else (translation, rotation)
