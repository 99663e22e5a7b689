"""Angles and translations of a knee in its joint coordinate system (Grood & Suntay 1983).

Axes of both bones at rest: x to the right of the subject, y forwards, z upwards, right-handed. The joint's axes are

    e1 = x of the femur (flexion),   e3 = z of the tibia (internal and external rotation),   e2 = e3 x e1 / |e3 x e1|,

the last one floating between both. The three rotations about them do not depend on their order, and neither do the
translations of the tibia's origin along them. Signs are anatomical, so that left and right knees have the same values.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from functools import cached_property

import numpy as np

from fecontact.bodies.pose import Pose, rotation_about
from fecontact.common.arguments import instance
from fecontact.common.checks import among, finite
from fecontact.common.errors import InputError

SIDES = {"right": 1.0, "left": -1.0}
#: Pose of these axes in those of OpenSim's bodies: x forwards, y upwards, z to the right.
OPENSIM = Pose(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]))
#: Cosine of the adduction below which flexion and rotation are about one axis.
ALIGNED = 1e-6


@dataclass(frozen=True)
class GroodSuntay:
    """Pose of a tibia relative to its femur by clinical angles (degrees) and translations.

    Parameters
    ----------
    flexion : float
        Rotation of the tibia about e1: its lower end goes backwards.
    adduction : float
        About e2: its lower end goes towards the middle of the body (varus).
    external_rotation : float
        About e3: the toes turn outwards.
    lateral, anterior, distraction : float
        Translations of the tibia's origin from the femur's: along e1 away from the middle of the body, along e2
        forwards, along e3 downwards, away from the femur.
    side : {'right', 'left'}

    Raises
    ------
    InputError
        For a value that is not finite, or an unknown side.

    Notes
    -----
    Source: Grood & Suntay, A joint coordinate system for the clinical description of three-dimensional motions, J.
    Biomech. Eng. 105 (1983), 136-144.

    Examples
    --------
    >>> tibia = GroodSuntay(flexion=90.0, distraction=30.0).pose
    >>> (tibia.rotation @ [0, 0, 1]).round(12).tolist()
    [0.0, 1.0, 0.0]
    >>> GroodSuntay.of(tibia).distraction
    30.0
    """

    flexion: float = 0.0
    adduction: float = 0.0
    external_rotation: float = 0.0
    lateral: float = 0.0
    anterior: float = 0.0
    distraction: float = 0.0
    side: str = "right"

    def __post_init__(self) -> None:
        among("side", self.side, SIDES)
        for name, value in zip(vars(self), astuple(self)[:-1], strict=False):
            finite(f"the {name.replace('_', ' ')}", value)

    @cached_property
    def pose(self) -> Pose:
        """Pose of the tibia in the femur's axes."""
        s = SIDES[self.side]
        a, b, c = np.radians([self.flexion, s * self.adduction, s * self.external_rotation])
        turn = rotation_about((1, 0, 0), -a) @ rotation_about((0, 1, 0), b) @ rotation_about((0, 0, 1), -c)
        axes = _axes(turn)
        return Pose(turn, axes @ np.array([s * self.lateral, self.anterior, -self.distraction]))

    @cached_property
    def femur(self) -> Pose:
        """Pose of the femur in the tibia's axes."""
        return Pose().relative_to(self.pose)

    @classmethod
    def of(cls, pose: Pose, side: str = "right") -> GroodSuntay:
        """Angles and translations of a pose of the tibia in the femur's axes.

        Raises
        ------
        InputError
            If the tibia lies along the axis of flexion, so that flexion and rotation are not distinct.
        """
        among("side", side, SIDES)
        turn, s = instance("the pose of a tibia", pose, Pose).rotation, SIDES[side]
        across, forwards, upwards = turn[:, 2]
        if np.hypot(forwards, upwards) < ALIGNED:
            raise InputError(
                "The tibia is adducted by 90 degrees: flexion and rotation are about one axis. Check the axes of both "
                "bones; z is along the shaft, x along the axis of flexion.",
                code="gimbal-lock",
            )
        axes = _axes(turn)
        angles = (
            np.arctan2(forwards, upwards),
            s * np.arctan2(across, np.hypot(forwards, upwards)),
            s * np.arctan2(-axes[:, 1] @ turn[:, 0], axes[:, 1] @ turn[:, 1]),
        )
        shift = np.linalg.solve(axes, pose.translation) * np.array([s, 1.0, -1.0])
        flexion, adduction, rotation = np.degrees(angles).tolist()
        lateral, anterior, distraction = shift.tolist()
        return cls(flexion, adduction, rotation, lateral, anterior, distraction, side)


def _axes(turn: np.ndarray) -> np.ndarray:
    """Columns e1, e2, e3 (3, 3) in the femur's axes, of a tibia's rotation."""
    first, third = np.array([1.0, 0.0, 0.0]), turn[:, 2]
    second = np.cross(third, first)
    return np.stack([first, second / np.linalg.norm(second), third], axis=1)
