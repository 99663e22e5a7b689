"""A scene with its bodies in other poses, and loads given for the original bodies carried over to it."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from numpy.typing import ArrayLike

from fecontact.bodies.pose import Pose
from fecontact.bodies.protocol import Body
from fecontact.common.errors import InputError
from fecontact.contact.loads import check_member
from fecontact.contact.model import SceneModel

#: Arguments of `Scene.solve` whose keys are bodies.
KEYED = ("forces", "moments", "motions", "free", "pressures")


@dataclass(frozen=True, eq=False)
class PosedScene:
    """A scene in other poses.

    Attributes
    ----------
    scene : SceneModel
        Of the moved bodies, which share their models with the originals.
    originals : tuple of Body
        In the scene's order.
    """

    scene: SceneModel
    originals: tuple[Body, ...]

    def body(self, original: Any) -> Any:
        """The moved body for an original one; anything else is given back as it is."""
        for old, new in zip(self.originals, self.scene.bodies, strict=True):
            if old is original:
                return new
        return original

    def loads(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        """Arguments of `Scene.solve` with the moved bodies as keys."""
        out = dict(arguments)
        for name in KEYED:
            if out.get(name):
                out[name] = {
                    (self.body(k[0]), *k[1:]) if isinstance(k, tuple) else self.body(k): v for k, v in out[name].items()
                }
        return out


def posed_scene(scene: SceneModel, poses: Mapping[Body, Pose]) -> PosedScene:
    """The scene with some bodies in new poses; contacts and springs follow.

    Raises
    ------
    InputError
        If a pose is given for something else than a body of the scene, or is none.
    """
    for body, pose in poses.items():
        check_member(body, scene.bodies, "A pose")
        if not isinstance(pose, Pose):
            raise InputError(
                f"The pose of {body.name!r} must be a fecontact.Pose(rotation, translation); found {pose!r}."
            )
    new = {id(b): _posed(b, poses[b]) if b in poses else b for b in scene.bodies}

    def end(given: tuple[Body | None, ArrayLike]) -> tuple[Body | None, ArrayLike]:
        return (None if given[0] is None else new[id(given[0])], given[1])

    contacts = [replace(c, slave=new[id(c.slave)], master=new[id(c.master)]) for c in scene.contacts]
    springs = [replace(s, start=end(s.start), end=end(s.end)) for s in scene.springs]
    return PosedScene(
        replace(scene, bodies=tuple(new.values()), contacts=contacts, springs=springs), tuple(scene.bodies)
    )


def _posed(body: Any, pose: Pose) -> Any:
    """The same body elsewhere: what it has worked out in its own axes stays."""
    other = copy.copy(body)
    object.__setattr__(other, "pose", pose)
    return other
