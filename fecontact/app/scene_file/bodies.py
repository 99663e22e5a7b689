"""Materials and bodies of a scene file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fecontact import surfaces
from fecontact.app import options
from fecontact.app.scene_file.meshes import (
    SHAPES,
    Arguments,
    arguments_of,
    check_name,
    choice,
    existing,
    mesh_of,
    number,
    numbers,
    section_of,
    shape_of,
)
from fecontact.app.scene_file.toml_table import Table, did_you_mean, listed
from fecontact.bodies import (
    AxisymmetricBody,
    ElasticBody,
    ElasticLayer,
    HalfSpace,
    LocalBody,
    PlaneBody,
    Pose,
    RigidBody,
    rotation_about,
)
from fecontact.bodies.elastic import INTEGRATIONS
from fecontact.bodies.geometry import CHOICES
from fecontact.bodies.layer import LAWS
from fecontact.bodies.section import STATES
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.condensation import ROUTES
from fecontact.fem.factor import DIRECT
from fecontact.fem.support import Support, checked_support
from fecontact.halfspace import Layer
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import SectionMesh
from fecontact.surfaces.rigid.rough import TRENDS

AnyBody = ElasticBody | LocalBody | RigidBody | HalfSpace | ElasticLayer


#: Makers of rigid shapes and their arguments.
RIGID_SHAPES: dict[str, tuple[Callable[..., Any], Arguments]] = {
    kind: (
        shape.make,
        {f"{p.key}{'!' if p.required else ''}": number if p.count == 1 else numbers(p.count) for p in shape.parameters},
    )
    for kind, shape in options.SHAPES.items()
}


def _geometry(table: Table, key: str, required: bool) -> Any:
    """What contact faces are placed on: a word, a shape, or one of these by contact boundary."""
    if not isinstance(table.raw(key, required), dict):
        return table.text(key, CHOICES)
    entry = table.table(key)
    if "kind" in entry:
        return _posed(entry)
    return {
        k: _posed(entry.table(k)) if isinstance(v, dict) else entry.text(k, CHOICES) for k, v in entry.values.items()
    }


def _posed(table: Table) -> RigidBody | None:
    """A rigid shape with its pose in the axes of a mesh."""
    pose, shape = _pose(table.table("pose")), shape_of(table, RIGID_SHAPES)
    return None if shape is None or pose is None else RigidBody(shape).placed(*pose)


def _flag(table: Table, key: str, required: bool) -> bool | str | None:
    """True or false."""
    return table.flag(key)


_INTEGRATED: Arguments = {"integration": choice(INTEGRATIONS)}
_SECTION: Arguments = {"backend": choice(("auto", *DIRECT)), **_INTEGRATED}

#: Bodies with a mesh, and their specific keys.
MESHED: dict[str, tuple[Callable[..., ElasticBody], Arguments]] = {
    "elastic": (
        ElasticBody,
        {
            "pressure": choice(("midface", "nodal")),
            "backend": choice(("auto", *DIRECT, "amg")),
            **_INTEGRATED,
            "condensation": choice(ROUTES),
            "geometry": _geometry,
        },
    ),
    "plane": (PlaneBody, {**_SECTION, "thickness": number, "plane": choice(STATES)}),
    "axisymmetric": (AxisymmetricBody, {**_SECTION, "torsion": _flag}),
}

TYPES = ("elastic", "local", "rigid", "half-space", "layer", "plane", "axisymmetric")

Materials = Mapping[str, Material | None]


def read_materials(table: Table) -> dict[str, Material | None]:
    """Materials by name; None for invalid ones."""
    out: dict[str, Material | None] = {}
    for name, entry in table.subtables():
        E, nu = entry.number("E", required=True), entry.number("nu", required=True)
        density = entry.number("density")
        entry.finish()
        out[name] = None
        if E is not None and nu is not None:
            out[name] = entry.attempt(partial(Material, E, nu, density))
    return out


def read_bodies(table: Table, materials: Materials, folder: Path) -> dict[str, AnyBody | None]:
    """Bodies by name; None for invalid ones."""
    out: dict[str, AnyBody | None] = {}
    for name, entry in table.subtables():
        kind = entry.text("type", TYPES) or "elastic"
        body: AnyBody | None
        if kind in MESHED:
            body = _meshed(name, kind, entry, materials, folder, out)
        elif kind == "local":
            body = _local(name, entry, materials, folder, out)
        elif kind == "rigid":
            body = _rigid(name, entry, folder)
        elif kind == "half-space":
            body = _half_space(name, entry, materials)
        else:
            body = _layer(name, entry, materials, folder, out)
        pose = _pose(entry.table("pose"))
        entry.finish()
        out[name] = body if body is None or pose is None else body.placed(*pose)
    return out


def _meshed(
    name: str, kind: str, table: Table, materials: Materials, folder: Path, bodies: Mapping[str, Any]
) -> ElasticBody | None:
    """A body of finite elements: a solid or a section."""
    make, arguments = MESHED[kind]
    mesh: Mesh | SectionMesh | None
    held = table.table("supports")
    if kind == "elastic":
        mesh, supports = mesh_of(table, folder, bodies), _supports(held)
    else:
        mesh = section_of(table, folder, SHAPES)
        supports = {boundary: held.text(boundary) or "" for boundary in held.values}
    material = _material_of(table, materials, mesh)
    contact = table.texts("contact") or ()
    given = arguments_of(table, arguments)
    if mesh is None:
        return None
    for boundary in contact:
        check_name(table, "contact", boundary, mesh.boundaries, "boundary")
    for boundary in supports:
        check_name(held, boundary, boundary, {**mesh.boundaries, **mesh.node_sets}, "boundary")
    if material is None or table.faulty:
        return None
    return table.attempt(lambda: make(mesh, material, contact, supports, name=name, **given))


def _local(name: str, table: Table, materials: Materials, folder: Path, bodies: Mapping[str, Any]) -> LocalBody | None:
    """An elastic body with a window."""
    at, cells, window = table.numbers("at"), table.numbers("cells", 2), table.raw("window")
    if cells is not None and any(n != int(n) for n in cells):
        table.fault("cells", f"must be two whole numbers; found {list(cells)!r}.")
    body = _meshed(name, "elastic", table, materials, folder, bodies)
    if body is None or table.faulty:
        return None
    make = partial(LocalBody, body, at, window)
    return table.attempt(make if cells is None else partial(make, (int(cells[0]), int(cells[1]))))


def _material_of(
    table: Table, materials: Materials, mesh: Mesh | SectionMesh | None
) -> Material | dict[str, Material] | None:
    """One material by name, or materials by element set; None if any is invalid."""
    given = table.raw("material", required=True)
    if given is None:
        return None
    if isinstance(given, str):
        return _named(table, "material", materials)
    if not isinstance(given, dict):
        table.fault("material", f"must be the name of a material or a table of names by element set; found {given!r}.")
        return None
    entry = table.table("material")
    out = {}
    for group in entry.values:
        if mesh is not None:
            check_name(entry, group, group, mesh.groups, "element set")
        out[group] = _named(entry, group, materials)
    found = {k: v for k, v in out.items() if v is not None}
    return found if len(found) == len(entry.values) else None


def _named(table: Table, key: str, materials: Materials, required: bool = False) -> Material | None:
    """The material that a key names; None if it is unknown or invalid."""
    name = table.text(key, required=required)
    if name is None:
        return None
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


def _rigid(name: str, table: Table, folder: Path) -> RigidBody | None:
    given = [key for key in ("shape", "heights", "surface") if key in table]
    if len(given) != 1:
        kinds = listed(RIGID_SHAPES)
        table.fault(
            None,
            f"needs one of shape (a table; kinds: {kinds}), heights and surface (tables with a file); "
            f"found {' and '.join(given) or 'none'}.",
        )
        return None
    if "shape" in table:
        shape = shape_of(table.table("shape", required=True), RIGID_SHAPES)
        return None if shape is None else RigidBody(shape, name)
    if "heights" in table:
        return _heights(name, table.table("heights"), folder)
    entry = table.table("surface")
    path, scale, part = existing(entry, "file", folder), entry.number("scale"), entry.text("part")
    entry.finish()
    if path is None or entry.faulty:
        return None
    return entry.attempt(lambda: RigidBody.from_surface(path, 1.0 if scale is None else scale, name, part), "file")


def _heights(name: str, table: Table, folder: Path) -> RigidBody | None:
    """A surface z(x, y) from a file."""
    path, size, unit = existing(table, "file", folder), table.numbers("size", 2), table.number("unit")
    trend, peaks_up = table.text("trend", TRENDS), table.flag("peaks_up")
    table.finish()
    if path is None or table.faulty:
        return None
    sides = None if size is None else (size[0], size[1])
    found = table.attempt(lambda: surfaces.read_topography(path, unit, sides), "file")
    if found is None:
        return None
    if (sides := found.size) is None:
        table.fault("size", f"is missing, and {path.name} does not give it.")
        return None

    def make() -> RigidBody:
        z = found.z if trend is None else surfaces.detrend(found.z, trend)
        return RigidBody.from_heights(-z if peaks_up else z, sides, name)

    return table.attempt(make)


def _half_space(name: str, table: Table, materials: Materials) -> HalfSpace | None:
    size, cells = table.numbers("size", 2, required=True), table.numbers("cells", 2, required=True)
    periodic = table.flag("periodic")
    material, against = (_named(table, key, materials) for key in ("material", "against"))
    layers = [_stacked(entry, materials) for entry in table.tables("layers")]
    if cells is not None and any(n != int(n) for n in cells):
        table.fault("cells", f"must be two whole numbers; found {list(cells)!r}.")
    if size is None or cells is None or None in layers or table.faulty:
        return None
    return table.attempt(
        lambda: HalfSpace(
            material,
            (size[0], size[1]),
            (int(cells[0]), int(cells[1])),
            bool(periodic),
            layers=[layer for layer in layers if layer is not None],
            against=against,
            name=name,
        )
    )


def _stacked(table: Table, materials: Materials) -> Layer | None:
    """One layer of a half-space."""
    material, thickness = _named(table, "material", materials, True), table.number("thickness", required=True)
    interface = table.text("interface", ("bonded", "frictionless")) or "bonded"
    table.finish()
    if material is None or thickness is None:
        return None
    return table.attempt(lambda: Layer(material, thickness, interface))


def _layer(
    name: str, table: Table, materials: Materials, folder: Path, bodies: Mapping[str, Any]
) -> ElasticLayer | None:
    mesh = mesh_of(table, folder, bodies)
    material, thickness = _named(table, "material", materials, True), table.number("thickness", required=True)
    covers, law = table.text("covers", required=True), table.text("law", LAWS) or "bonded"
    if mesh is not None and covers is not None:
        check_name(table, "covers", covers, mesh.boundaries, "boundary")
    if mesh is None or material is None or thickness is None or covers is None or table.faulty:
        return None
    return table.attempt(lambda: ElasticLayer(material, thickness, (mesh, covers), law, name))


def pose_of(table: Table) -> Pose | None:
    """Pose from a table of translation and rotation; None if invalid."""
    given = _pose(table)
    return None if given is None else Pose(given[1], np.asarray(given[0], dtype=float))


def _pose(table: Table) -> tuple[Any, Any] | None:
    """Translation and rotation matrix; None if invalid."""
    translation = table.numbers("translation") or (0.0, 0.0, 0.0)
    rotation = np.eye(3)
    if "rotation" in table:
        turn = table.table("rotation")
        axis, angle = turn.numbers("axis", required=True), turn.number("angle_deg", required=True)
        turn.finish()
        if axis is not None and angle is not None:
            turned = turn.attempt(lambda: rotation_about(axis, math.radians(angle)), "axis")
            rotation = rotation if turned is None else turned
    table.finish()
    return None if table.faulty else (translation, rotation)
