"""A scene with its bodies in other poses."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

from fecontact.bodies.pose import Pose
from fecontact.bodies.protocol import Body
from fecontact.common.arguments import mapping
from fecontact.common.errors import InputError
from fecontact.contact.loads import check_member
from fecontact.contact.model import SceneModel
from fecontact.scene.carried import CarriedScene, with_bodies


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
    return with_bodies(scene, [_posed(b, poses[b]) if b in poses else b for b in scene.bodies])


def _posed(body: Any, pose: Pose) -> Any:
    """The same body in another pose; cached results in its own axes are kept."""
    other = copy.copy(body)
    object.__setattr__(other, "pose", pose)
    return other
