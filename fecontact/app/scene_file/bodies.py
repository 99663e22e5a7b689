"""Materials and bodies of a scene file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fecontact import surfaces
from fecontact.app import options
from fecontact.app.scene_file.meshes import check_name, existing, mesh_of, section_of, shape_of
from fecontact.app.scene_file.toml_table import Arguments, Table, choice, did_you_mean, flag, listed, number, numbers
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
from fecontact.bodies.layer import LAWS as LAYER_LAWS
from fecontact.bodies.section import STATES
from fecontact.common.anisotropic import AnisotropicMaterial, CylindricalAxes, OrthotropicMaterial
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.condensation import ROUTES
from fecontact.fem.factor import DIRECT
from fecontact.fem.fibres import Fibres
from fecontact.fem.laws import CompressibleOgden, HolmesMow, Law, MooneyRivlin, NeoHookean, Ogden, StVenantKirchhoff
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


@dataclass(frozen=True)
class Declared:
    """What a body may refer to: materials and bodies by name, None for invalid ones, and the folder of files."""

    materials: Mapping[str, Material | Law | None]
    bodies: Mapping[str, AnyBody | None]
    folder: Path

    def material(self, table: Table, key: str, required: bool = False) -> Material | Law | None:
        """The material that a key names; None if it is unknown or invalid."""
        name = table.text(key, required=required)
        if name is not None and name not in self.materials:
            hint = did_you_mean(name, self.materials)
            table.fault(key, f"unknown material {name!r}{hint}; the materials are: {listed(self.materials)}.")
        return None if name is None else self.materials.get(name)


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


def _cells(table: Table, key: str, required: bool) -> tuple[int, int] | None:
    """Two whole numbers."""
    found = table.numbers(key, 2, required)
    if found is None or any(n != int(n) for n in found):
        if found is not None:
            table.fault(key, f"must be two whole numbers; found {list(found)!r}.")
        return None
    return int(found[0]), int(found[1])


_SECTION: Arguments = {"backend": choice(("auto", *DIRECT)), "integration": choice(INTEGRATIONS)}

#: Bodies with a mesh, and their specific keys.
MESHED: dict[str, tuple[Callable[..., ElasticBody], Arguments]] = {
    "elastic": (
        ElasticBody,
        {
            "pressure": choice(("midface", "nodal")),
            "backend": choice(("auto", *DIRECT, "amg")),
            "integration": choice(INTEGRATIONS),
            "condensation": choice(ROUTES),
            "geometry": _geometry,
        },
    ),
    "plane": (PlaneBody, {**_SECTION, "thickness": number, "plane": choice(STATES)}),
    "axisymmetric": (AxisymmetricBody, {**_SECTION, "torsion": flag}),
}


#: Laws of finite strain by their names in a scene file.
LAWS: dict[str, type[Law]] = {
    law.__name__: law for law in (NeoHookean, StVenantKirchhoff, HolmesMow, MooneyRivlin, Ogden, CompressibleOgden)
}
#: Arguments of a family of fibres in a law.
FIBRES: Arguments = {"direction!": numbers(3), "ksi!": number, "alpha!": number, "beta": number}


def read_materials(table: Table) -> dict[str, Material | Law | None]:
    """Materials by name, laws of finite strain among them; None for invalid ones."""
    out: dict[str, Material | Law | None] = {}
    for name, entry in table.subtables():
        law = entry.text("law", tuple(LAWS))
        kind: Any = _linear(entry) if law is None else LAWS.get(law)
        families = entry.tables("fibres") if law is not None else []
        given = None if kind is None else _constants(kind)
        out[name] = None if given is None else entry.make(partial(_with_axes, kind), given)
        for family in families:
            out[name] = family.make(partial(_with_fibres, out[name]), FIBRES)
    return out


def _linear(entry: Table) -> Any:
    """The class of a linear material, by its constants."""
    if "moduli" in entry:
        return AnisotropicMaterial
    return OrthotropicMaterial if isinstance(entry.raw("E"), list) else Material


def _with_axes(kind: Any, axes: Any = None, **constants: Any) -> Any:
    """A material, whose axes may be a table of cylindrical ones."""
    if axes is not None:
        constants["axes"] = CylindricalAxes(**axes) if isinstance(axes, dict) else axes
    return kind(**constants)


def _with_fibres(law: Any, **family: Any) -> Fibres | None:
    """A law with a family of fibres; None of one that is invalid."""
    return None if law is None else Fibres(law, **family)


def _constants(kind: Any) -> Arguments:
    """Constants of a material, numbers unless it takes lists of them."""
    return {
        f"{f.name}{'!' if f.default is MISSING else ''}": number if str(f.type).startswith("float") else Table.raw
        for f in fields(kind)
    }


def read_bodies(
    table: Table, materials: Mapping[str, Material | Law | None], folder: Path
) -> dict[str, AnyBody | None]:
    """Bodies by name; None for invalid ones."""
    out: dict[str, AnyBody | None] = {}
    for name, entry in table.subtables():
        kind = entry.text("type", tuple(TYPES)) or "elastic"
        body = TYPES[kind](name, entry, Declared(materials, out, folder))
        pose = _pose(entry.table("pose"))
        entry.finish()
        out[name] = body if body is None or pose is None else body.placed(*pose)
    return out


def _meshed(kind: str, name: str, table: Table, declared: Declared) -> ElasticBody | None:
    """A body of finite elements: a solid or a section."""
    make, arguments = MESHED[kind]
    mesh: Mesh | SectionMesh | None
    held = table.table("supports")
    if kind == "elastic":
        mesh, supports = mesh_of(table, declared.folder, declared.bodies), _supports(held)
    else:
        mesh = section_of(table, declared.folder)
        supports = {boundary: held.text(boundary) or "" for boundary in held.values}
    material = _material_of(table, declared, mesh)
    contact = table.texts("contact") or ()
    given = table.read(arguments)
    if mesh is None:
        return None
    for boundary in contact:
        check_name(table, "contact", boundary, {**mesh.boundaries, **mesh.node_sets}, "boundary")
    for boundary in supports:
        check_name(held, boundary, boundary, {**mesh.boundaries, **mesh.node_sets}, "boundary")
    if material is None or table.faulty:
        return None
    return table.attempt(lambda: make(mesh, material, contact, supports, name=name, **given))


def _local(name: str, table: Table, declared: Declared) -> LocalBody | None:
    """An elastic body with a window."""
    window = table.read({"at": numbers(3), "window": Table.raw, "cells": _cells})
    body = _meshed("elastic", name, table, declared)
    return None if body is None or table.faulty else table.attempt(lambda: LocalBody(body, **window))


def _material_of(
    table: Table, declared: Declared, mesh: Mesh | SectionMesh | None
) -> Material | Law | dict[str, Material | Law] | None:
    """One material by name, or materials by element set; None if any is invalid."""
    given = table.raw("material", required=True)
    if given is None:
        return None
    if isinstance(given, str):
        return declared.material(table, "material")
    if not isinstance(given, dict):
        table.fault("material", f"must be the name of a material or a table of names by element set; found {given!r}.")
        return None
    entry = table.table("material")
    out = {}
    for group in entry.values:
        if mesh is not None:
            check_name(entry, group, group, mesh.groups, "element set")
        out[group] = declared.material(entry, group)
    found = {k: v for k, v in out.items() if v is not None}
    return found if len(found) == len(entry.values) else None


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


def _rigid(name: str, table: Table, declared: Declared) -> RigidBody | None:
    given = [key for key in ("shape", "heights", "surface") if key in table]
    if len(given) != 1:
        kinds = listed(RIGID_SHAPES)
        table.fault(
            None,
            f"needs one of shape (a table; kinds: {kinds}), heights and surface (tables with a file); "
            f"found {' and '.join(given) or 'none'}.",
        )
        return None
    entry, file = table.table(given[0]), {"file!": existing(declared.folder)}
    if given == ["shape"]:
        shape = shape_of(entry, RIGID_SHAPES)
        return None if shape is None else RigidBody(shape, name)
    if given == ["heights"]:
        return _heights(name, entry, file)

    def make(file: Path, **more: Any) -> RigidBody:
        return RigidBody.from_surface(file, name=name, **more)

    return entry.make(make, {**file, "scale": number, "part": choice()}, "file")


def _heights(name: str, table: Table, file: Arguments) -> RigidBody | None:
    """A surface z(x, y) from a file."""
    treated = table.read({"trend": choice(TRENDS), "peaks_up": flag})
    found = table.make(_topography, {**file, "size": numbers(2), "unit": number}, "file")
    if found is None:
        return None
    sides = found.size
    if sides is None:
        table.fault("size", f"is missing, and {Path(table.values['file']).name} does not give it.")
        return None

    def make() -> RigidBody:
        z = found.z if "trend" not in treated else surfaces.detrend(found.z, treated["trend"])
        return RigidBody.from_heights(-z if treated.get("peaks_up") else z, sides, name)

    return table.attempt(make)


def _topography(file: Path, size: tuple[float, float] | None = None, unit: float | None = None) -> Any:
    return surfaces.read_topography(file, unit, size)


def _half_space(name: str, table: Table, declared: Declared) -> HalfSpace | None:
    bonded = choice(("bonded", "frictionless"))
    stacked = {"material!": declared.material, "thickness!": number, "interface": bonded}
    layers = [entry.make(Layer, stacked) for entry in table.tables("layers")]
    given = table.read(
        {
            "size!": numbers(2),
            "cells!": _cells,
            "periodic": flag,
            "material": declared.material,
            "against": declared.material,
        }
    )
    if "size" not in given or "cells" not in given or None in layers or table.faulty:
        return None
    material = given.pop("material", None)
    stack = [layer for layer in layers if layer is not None]
    return table.attempt(lambda: HalfSpace(material, layers=stack, name=name, **given))


def _layer(name: str, table: Table, declared: Declared) -> ElasticLayer | None:
    mesh = mesh_of(table, declared.folder, declared.bodies)
    given = table.read({"material!": declared.material, "thickness!": number, "law": choice(LAYER_LAWS)})
    covers = table.text("covers", required=True)
    if mesh is not None and covers is not None:
        check_name(table, "covers", covers, mesh.boundaries, "boundary")
    if mesh is None or covers is None or len({"material", "thickness"} & set(given)) < 2 or table.faulty:
        return None
    return table.attempt(lambda: ElasticLayer(surface=(mesh, covers), name=name, **given))


#: Readers of bodies by their type.
TYPES: dict[str, Callable[[str, Table, Declared], AnyBody | None]] = {
    "elastic": partial(_meshed, "elastic"),
    "local": _local,
    "rigid": _rigid,
    "half-space": _half_space,
    "layer": _layer,
    "plane": partial(_meshed, "plane"),
    "axisymmetric": partial(_meshed, "axisymmetric"),
}


def pose_of(table: Table) -> Pose | None:
    """Pose from a table of translation and rotation; None if invalid."""
    given = _pose(table)
    return None if given is None else Pose(given[1], np.asarray(given[0], dtype=float))


def _pose(table: Table) -> tuple[Any, Any] | None:
    """Translation and rotation matrix; None if invalid."""
    translation = table.numbers("translation") or (0.0, 0.0, 0.0)
    rotation = np.eye(3)
    if "rotation" in table:
        turned = table.table("rotation").make(_rotation, {"axis!": numbers(3), "angle_deg!": number}, "axis")
        rotation = rotation if turned is None else turned
    table.finish()
    return None if table.faulty else (translation, rotation)


def _rotation(axis: Any, angle_deg: float) -> Array:
    return rotation_about(axis, math.radians(angle_deg))
