"""Plane and axisymmetric bodies of a scene file."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from fecontact.app.scene_file.meshes import (
    Arguments,
    check_name,
    choice,
    integer,
    is_division,
    made,
    number,
    numbers,
    shape_of,
)
from fecontact.app.scene_file.toml_table import Table
from fecontact.bodies import AxisymmetricBody, PlaneBody
from fecontact.bodies.section import STATES
from fecontact.mesh import section_shapes as sections
from fecontact.mesh.section_mesh import SectionMesh


def _divisions(table: Table, key: str, required: bool) -> Any:
    """Two counts, or lists of positions in their place."""
    value = table.raw(key, required)
    if value is None:
        return None
    if not isinstance(value, list) or len(value) != 2 or not all(map(is_division, value)):
        table.fault(key, f"must be two counts or lists of increasing positions; found {value!r}.")
        return None
    return tuple(value)


def _cap(radius: float = math.inf, **given: Any) -> SectionMesh:
    """A cap, flat unless it has a radius."""
    return sections.cap(radius, **given)


_ELEMENT = choice(tuple(sections.ELEMENTS))
_GRADED: Arguments = {"level": integer, "element": _ELEMENT}

SHAPES: dict[str, tuple[Callable[..., SectionMesh], Arguments]] = {
    "rectangle": (
        sections.rectangle,
        {"size!": numbers(2), "divisions!": _divisions, "start": number, "element": _ELEMENT},
    ),
    "ring": (
        sections.ring,
        {"inner!": number, "outer!": number, "height!": number, "divisions!": _divisions, "element": _ELEMENT},
    ),
    "annulus": (
        sections.annulus,
        {"inner!": number, "outer!": number, "divisions": _divisions, "element": _ELEMENT},
    ),
    "cap": (_cap, {"radius": number, "extent!": number, "depth!": number, "contact_radius!": number, **_GRADED}),
    "half_disc": (sections.half_disc, {"radius!": number, "contact_radius": number, **_GRADED}),
}


def section_body(
    name: str,
    kind: str,
    table: Table,
    material_of: Callable[[SectionMesh | None], Any],
) -> PlaneBody | AxisymmetricBody | None:
    """A body of type 'plane' or 'axisymmetric'; None if it is wrong.

    Parameters
    ----------
    name, kind : str
    table : Table
    material_of : callable
        Reads the material, given the mesh.
    """
    mesh: SectionMesh | None = shape_of(table.table("shape", required=True), SHAPES)
    material = material_of(mesh)
    contact = table.texts("contact") or ()
    held = table.table("supports")
    supports = {boundary: held.text(boundary) or "" for boundary in held.values}
    options: dict[str, Any] = {
        "backend": table.text("backend", ("auto", "pardiso", "superlu")),
        "integration": table.text("integration", ("auto", "full", "selective")),
    }
    if kind == "plane":
        options |= {"thickness": table.number("thickness"), "plane": table.text("plane", STATES)}
    if mesh is not None:
        for boundary in contact:
            check_name(table, "contact", boundary, mesh.boundaries, "boundary")
        for boundary in supports:
            check_name(held, boundary, boundary, mesh.boundaries, "boundary")
    if mesh is None or material is None or table.faults.touched(table.place):
        return None
    make = PlaneBody if kind == "plane" else AxisymmetricBody
    given = {k: v for k, v in options.items() if v is not None}
    body: PlaneBody | AxisymmetricBody | None = made(
        table, None, lambda: make(mesh, material, contact, supports, name=name, **given)
    )
    return body
