"""A scene with replaced bodies, in new poses or on finer meshes, and the loads mapped to them.

A scene with its bodies in other poses.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from fecontact.bodies.body import Body
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import mapping
from fecontact.common.errors import InputError
from fecontact.contact.loads import LoadStep, check_member
from fecontact.contact.model import SceneModel


@dataclass(frozen=True, eq=False)
class CarriedScene:
    """A scene with new bodies in place of the given ones.

    Attributes
    ----------
    scene : SceneModel
        Scene of the new bodies.
    originals : tuple of Body
        The given bodies, in the same order.
    """

    scene: SceneModel
    originals: tuple[Body, ...]

    def body(self, original: Any) -> Any:
        """The new body for an original one; anything else is returned unchanged."""
        for old, new in zip(self.originals, self.scene.bodies, strict=True):
            if old is original:
                return new
        return original

    def step(self, given: LoadStep) -> LoadStep:
        """A load step with the new bodies as keys."""
        return given.carried(self.body)


def with_bodies(scene: SceneModel, bodies: Sequence[Body]) -> CarriedScene:
    """The scene with new bodies, given in its order; contacts and springs follow, and windows face each other."""
    new = {id(old): body for old, body in zip(scene.bodies, bodies, strict=True)}
    for contact in scene.contacts:
        for body, other in ((contact.master, contact.slave), (contact.slave, contact.master)):
            new[id(body)] = new[id(body)]._met_by(new[id(other)])
    bodies = [new[id(old)] for old in scene.bodies]

    def end(given: tuple[Body | None, Any]) -> tuple[Body | None, Any]:
        return (None if given[0] is None else new[id(given[0])], given[1])

    contacts = [replace(c, slave=new[id(c.slave)], master=new[id(c.master)]) for c in scene.contacts]
    springs = [
        replace(
            s,
            start=end(s.start),
            end=end(s.end),
            via=[end(each) for each in s.via],
            around=None if s.around is None else end(s.around),
        )
        for s in scene.springs
    ]
    return CarriedScene(replace(scene, bodies=tuple(bodies), contacts=contacts, springs=springs), tuple(scene.bodies))


def posed_scene(scene: SceneModel, poses: Mapping[Body, Pose] | None) -> CarriedScene:
    """The scene with some bodies in new poses; they share their models with the originals.

    Raises
    ------
    InputError
        If a key is not a body of the scene, or a value is not a pose.
    """
    poses = mapping("poses", poses)
    for body, pose in poses.items():
        check_member(body, scene.bodies, "A pose")
        if not isinstance(pose, Pose):
            raise InputError(
                f"The pose of {body.name!r} must be a fecontact.Pose(rotation, translation); found {pose!r}."
            )
    return with_bodies(scene, [posed(b, poses[b]) if b in poses else b for b in scene.bodies])


def posed(body: Any, pose: Pose) -> Any:
    """The same body in another pose; cached results in its own axes are kept."""
    other = copy.copy(body)
    object.__setattr__(other, "pose", pose)
    return other
