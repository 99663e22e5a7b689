"""Contacts divided by a plane, such as the medial and the lateral side of a joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.pose import Pose
from fecontact.bodies.protocol import Body
from fecontact.common.arguments import texts
from fecontact.common.arrays import Array
from fecontact.common.checks import vector
from fecontact.common.errors import InputError, shown
from fecontact.common.one_line import one_line
from fecontact.results.contact_fields import ContactFields


@one_line
@dataclass(frozen=True, eq=False)
class DividingPlane:
    """A plane that divides contacts into two sides.

    Parameters
    ----------
    point, normal : (3,)
        A point of the plane and its normal, which need not have unit length.
    body : Body, optional
        Body in whose axes they are given, with which the plane moves; the world's unless given.
    sides : (str, str)
        Names of the side to which the normal points, and of the other.

    Raises
    ------
    InputError
        If the normal is zero, or the names are not two.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> scene = fc.Scene([block, floor := fc.RigidBody(fc.Plane())], [fc.Contact(block, floor)])
    >>> plane = fc.DividingPlane((0.25, 0, 0), (1, 0, 0), block, sides=("medial", "lateral"))
    >>> table = scene.sweep([{"motions": {block: {"z": -0.01}}}], split=plane)
    >>> table.column("medial: area").round(9).tolist(), table.column("lateral: force_z").round(9).tolist()
    ([0.75], [0.0025])
    """

    point: ArrayLike
    normal: ArrayLike
    body: Body | None = None
    sides: tuple[str, str] = ("front", "back")

    def __post_init__(self) -> None:
        vector("the point of the dividing plane", self.point)
        if not vector("the normal of the dividing plane", self.normal).any():
            raise InputError("The normal of the dividing plane must not be zero.", code="normal-zero")
        names = texts("the sides of the dividing plane", self.sides)
        if len(names) != 2 or names[0] == names[1]:
            raise InputError(f"A plane has two sides with two names; found {shown(self.sides)}.", code="side-names")

    def in_world(self, pose: Pose) -> tuple[Array, Array]:
        """Point and normal in world axes, with the pose of its body."""
        point, normal = np.asarray(self.point, float), np.asarray(self.normal, float)
        return pose.to_world(point), pose.rotation @ normal


def sides_of_contact(contact: ContactFields, plane: DividingPlane, pose: Pose) -> dict[str, dict[str, Any]]:
    """Figures of both sides of a contact by their names, ready for JSON; see `ContactFields.split_by_plane`."""
    parts = contact.split_by_plane(*plane.in_world(pose))
    return {name: part.summary() for name, part in zip(plane.sides, parts, strict=True)}
