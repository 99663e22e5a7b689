"""Figures of one of many cases as numbers by the names of their columns.

Row of a result for a table of many, and fields that are kept of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fecontact.bodies.pose import Pose
from fecontact.bodies.protocol import Body
from fecontact.common.arguments import items, texts
from fecontact.common.checks import among
from fecontact.common.errors import InputError, shown
from fecontact.contact.loads import check_member
from fecontact.contact.model import SceneModel
from fecontact.results.dividing_plane import DividingPlane, sides_of_contact
from fecontact.results.field_map import FIELDS, FieldMap, field_map
from fecontact.results.result import ContactResult

#: Figures of a contact by name, with the kind and power of their units.
FIGURES: dict[str, tuple[str, str]] = {
    **{f"force_{axis}": ("force", "") for axis in "xyz"},
    "force": ("force", ""),
    "area": ("length", "²"),
    "point_area": ("length", "²"),
    "max_pressure": ("stress", ""),
    "mean_pressure": ("stress", ""),
    **{f"centre_{axis}": ("length", "") for axis in "xyz"},
    "regions": ("", ""),
    "pressure_error": ("", ""),
    "stick_area": ("length", "²"),
    "slip_area": ("length", "²"),
    "friction_work": ("moment", ""),
}
#: Figures of a case as a whole.
WHOLE = ("case", "status", "residual", "iterations", "seconds", "warnings")
#: Kinds of units of what is given, by the first word.
GIVEN = {"forces": "force", "moments": "moment", "motions": "length", "poses": "length", "pressures": "stress"}


def contact_labels(contacts: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    """Label of each contact by the names of its bodies."""
    return tuple(f"{one} on {other}" for one, other in contacts)


def row_figures(row: Mapping[str, Any], contacts: Sequence[tuple[str, str]]) -> dict[str, Any]:
    """All numbers of a row by the name of their column; None stands for a figure without value.

    Parameters
    ----------
    row : mapping
        `ContactResult.summary` with parameters, loads and sides.
    contacts : sequence of (str, str)
        Names of the bodies of each contact.
    """
    out = {**row.get("parameters", {}), **row.get("loads", {})}
    for label, contact in zip(contact_labels(contacts), row["contacts"], strict=True):
        head = f"{label}: " if len(contacts) > 1 else ""
        out |= {f"{head}{name}": value for name, value in _of_contact(contact).items()}
        for side, part in contact.get("sides", {}).items():
            out |= {f"{head}{side}: {name}": value for name, value in _resultant(part).items()}
    out |= {f"{spring['name']}: tension": spring["tension"] for spring in row["springs"]}
    plain = [value for value in row["residuals"].values() if not isinstance(value, Mapping)]
    out |= {"residual": max(plain), "iterations": row["iterations"], "seconds": row["seconds"]["total"]}
    return out | {"warnings": len(row["warnings"])}


def _of_contact(contact: Mapping[str, Any]) -> dict[str, Any]:
    """Figures of a contact."""
    out, friction = _resultant(contact), contact.get("friction", {})
    out |= {name: friction[name] for name in ("stick_area", "slip_area", "friction_work") if name in friction}
    return out | {"regions": contact["regions"], "pressure_error": contact["error_estimate"]["pressure"]}


def _resultant(part: Mapping[str, Any]) -> dict[str, Any]:
    """Figures of a contact or of a part of it."""
    force = np.asarray(part["force"], float)
    centre = part["centre_of_pressure"] or [np.nan] * 3
    return {
        **{f"force_{axis}": f for axis, f in zip("xyz", force.tolist(), strict=True)},
        "force": float(np.linalg.norm(force)),
        **{name: part[name] for name in ("area", "point_area", "max_pressure", "mean_pressure")},
        **{f"centre_{axis}": x for axis, x in zip("xyz", centre, strict=True)},
    }


#: Fields of a result that are kept: by name those of all contacts.
Kept = dict[str, tuple[FieldMap, ...]]


def fields_to_keep(keep: Any, scene: SceneModel) -> tuple[str, ...]:
    """Names of fields, one or several.

    Raises
    ------
    InputError
        If one is none, or the scene has no such field.
    """
    names = texts("the fields to keep", keep)
    for name in names:
        among("field to keep", name, FIELDS)
    if "friction" in names and not scene.has_friction:
        raise InputError("No contact has friction: keep 'pressure' or 'gap', or give Contact(..., friction=...).")
    return names


def plane_of(split: Any, bodies: Sequence[Body]) -> DividingPlane | None:
    """A plane as users give it: a `DividingPlane`, or a point and a normal in world axes.

    Raises
    ------
    InputError
        If it is none, or of a body of another scene.
    """
    if split is None:
        return None
    plane: DividingPlane = split
    if not callable(getattr(split, "in_world", None)):
        given = items("split, where it is no DividingPlane,", split, "a point and a normal")
        if len(given) != 2:
            raise InputError(f"split is a DividingPlane, or a point and a normal; found {shown(split)}.", code="split")
        plane = DividingPlane(*given)
    if plane.body is not None:
        check_member(plane.body, bodies, "The dividing plane")
    return plane


def row_of(result: ContactResult, plane: DividingPlane | None, bodies: Sequence[Body]) -> dict[str, Any]:
    """Summary of a result, with the sides of a plane.

    Parameters
    ----------
    result : ContactResult
    plane : DividingPlane or None
    bodies : sequence of Body
        The scene's bodies as given, in the order of those of the result; the plane moves with one of them.
    """
    row = result.summary()
    if plane is not None:
        found = [k for k, body in enumerate(bodies) if body is plane.body]
        pose = result.scene.bodies[found[0]].pose if found else Pose()
        for figures, contact in zip(row["contacts"], result.contacts, strict=True):
            figures["sides"] = sides_of_contact(contact, plane, pose)
    return row


def kept_of(result: ContactResult, names: Sequence[str]) -> Kept:
    """Fields of all contacts of a result, without its bodies."""
    return {what: tuple(field_map(c, what) for c in result.contacts) for what in names}
