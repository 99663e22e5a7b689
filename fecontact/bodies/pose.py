"""Pose of a body: a rotation and a translation, separate from its coordinates.

Compliance is computed in the body's own axes and does not change with the pose. So a body can be far from the origin
without loss of accuracy, and a sweep of poses needs one factorisation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from fecontact.common.arguments import instance
from fecontact.common.arrays import Array
from fecontact.common.checks import array_of, number, point_array, vector
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, shown


def rotation_about(axis: ArrayLike, angle: float) -> Array:
    """Rotation matrix (3, 3) by an angle (radians) about an axis through the origin (Rodrigues' formula).

    Examples
    --------
    >>> import numpy as np
    >>> (rotation_about((0, 0, 1), np.pi / 2) @ [1, 0, 0]).round(12).tolist()
    [0.0, 1.0, 0.0]
    """
    a = vector("a rotation axis", axis)
    if not a.any():
        raise InputError(f"A rotation axis must be a vector of three numbers, not zero; found {shown(axis)}.")
    if not math.isfinite(number(angle)):
        raise InputError(f"The angle of a rotation must be a finite number (radians); found {shown(angle)}.")
    x, y, z = a / np.linalg.norm(a)
    W = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    # 2 sin^2(angle/2) instead of 1 - cos(angle): exact for small angles
    return np.eye(3) + np.sin(angle) * W + 2 * np.sin(angle / 2) ** 2 * (W @ W)


@compact_repr
@dataclass(frozen=True, eq=False)
class Pose:
    """Rigid placement ``x_world = rotation @ x_body + translation``.

    Attributes
    ----------
    rotation : (3, 3) array
    translation : (3,) array
    """

    rotation: Array = field(default_factory=lambda: np.eye(3))
    translation: Array = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        t = vector("a translation", self.translation)
        Q = array_of(self.rotation)
        if Q is None or Q.shape != (3, 3) or not _is_rotation(Q):
            raise InputError(
                "A rotation must be a proper orthogonal 3x3 matrix (use fecontact.rotation_about(axis, angle)); "
                f"found {shown(self.rotation)}.",
                code="no-rotation",
            )
        object.__setattr__(self, "rotation", Q)
        object.__setattr__(self, "translation", t)

    def then(self, rotation: ArrayLike, translation: ArrayLike) -> Pose:
        """This pose followed by a further rotation about the world's origin and a translation."""
        step = Pose(rotation, translation)  # type: ignore[arg-type]
        return Pose(step.rotation @ self.rotation, step.rotation @ self.translation + step.translation)

    def to_world(self, points: Array) -> Array:
        """World coordinates (n, 3) of body coordinates."""
        return point_array("points", points, 3) @ self.rotation.T + self.translation

    def to_body(self, points: Array) -> Array:
        """Body coordinates (n, 3) of world coordinates."""
        return (point_array("points", points, 3) - self.translation) @ self.rotation

    def relative_to(self, other: Pose) -> Pose:
        """This body's pose in another's axes; a common offset cancels without rounding."""
        instance("the other pose", other, Pose)
        return Pose(other.rotation.T @ self.rotation, (self.translation - other.translation) @ other.rotation)


def _is_rotation(Q: Array) -> bool:
    """Whether a matrix (3, 3) is proper orthogonal."""
    return bool(np.abs(Q).max() <= 2 and np.allclose(Q @ Q.T, np.eye(3), atol=1e-9) and np.linalg.det(Q) > 0)


def turned(pose: Pose, motion: Array, point: Array) -> Pose:
    """Pose after a finite motion (6,): rotation vector about a world point, then translation."""
    Q = Rotation.from_rotvec(motion[3:]).as_matrix()
    return Pose(Q @ pose.rotation, Q @ (pose.translation - point) + point + motion[:3])
