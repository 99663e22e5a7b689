"""Row of a result for a table of many, and fields that are kept of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

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
            raise InputError(f"split is a DividingPlane, or a point and a normal; found {shown(split)}.")
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
