"""Paths of contact points during a load step of finite motion, and the time at which open points touch.

Between its two ends a step's relative motion is a screw, the same from every frame of reference. A point that was open
at the last end slips from where it touches: what it moved before is no slip. So a body that rolls by many widths of
its contact in one step has slid by none.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, Mask

#: Times of a step at which points are placed, its ends included.
TIMES = 33

#: Share of a gap's range, and of the largest distance moved, that counts as rounding.
ROUNDING = 1e-9


def screw_paths(points: Array, start: Pose, end: Pose) -> Array:
    """Positions (k, n, 3) of body points (n, 3) at equal times of the screw from one pose to another.

    With a rotation vector r and the translation V v of the twist (r, v), V = I + (1 - cos a) / a^2 [r] + (a - sin a) /
    a^3 [r]^2 and a = |r| (Rodrigues).

    Examples
    --------
    A quarter turn about the point (1, 0, 0):

    >>> import numpy as np
    >>> from fecontact.bodies.pose import rotation_about
    >>> end = Pose(rotation_about((0, 0, 1), np.pi / 2), np.array([1.0, -1.0, 0.0]))
    >>> path = screw_paths(np.array([[2.0, 0.0, 0.0]]), Pose(), end)
    >>> bool(np.allclose(np.linalg.norm(path - [1.0, 0.0, 0.0], axis=2), 1.0))
    True
    """
    turn = end.rotation @ start.rotation.T
    shift = end.translation - turn @ start.translation
    r = Rotation.from_matrix(turn).as_rotvec()
    times = np.linspace(0.0, 1.0, TIMES)
    v = np.linalg.solve(_spread(r), shift)
    turns = Rotation.from_rotvec(times[:, None] * r).as_matrix()
    shifts = np.stack([t * (_spread(t * r) @ v) for t in times])
    at_start = points @ start.rotation.T + start.translation
    return np.asarray(np.einsum("kij,nj->kni", turns, at_start) + shifts[:, None])


def _spread(r: Array) -> Array:
    """The matrix V (3, 3) of a rotation vector."""
    angle = float(np.linalg.norm(r))
    x, y, z = r
    W = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    # sin(x)/x is exact for small angles
    half = np.sinc(angle / 2 / np.pi) ** 2 / 2
    third = (1 - np.sinc(angle / np.pi)) / angle**2 if angle > 1e-4 else 1 / 6
    return np.asarray(np.eye(3) + half * W + third * W @ W)


def touching_points(paths: Array, gaps: Array, normals: Array, pressed: Mask) -> Array:
    """Where points are from which their slip counts: those pressed before at the start, others where they touch.

    Parameters
    ----------
    paths : (k, n, 3) array
        Positions of the points.
    gaps : (n,) array
        Gaps at the end, with the displacements of the start.
    normals : (n, 3) array
        Unit normals out of the other surface at the end, in whose tangent plane it is taken to continue.
    pressed : (n,) bool array
        Points that were pressed at the start.

    Returns
    -------
    (n, 3) array
        Where a point does not come to touch: where it first is nearest.
    """
    w = gaps + np.einsum("kni,ni->kn", paths - paths[-1], normals)
    least = w.min(axis=0)
    rounding = ROUNDING * (w.max(axis=0) - least + np.abs(paths[-1] - paths[0]).max(initial=0.0))
    level = np.maximum(least, 0.0) + rounding
    first = np.argmax(w <= level, axis=0)
    first[pressed] = 0
    before, n = np.maximum(first - 1, 0), np.arange(len(first))
    fall = w[before, n] - w[first, n]
    share = np.divide(w[before, n] - level, fall, out=np.ones(len(n)), where=fall > 0)
    return np.asarray(paths[before, n] + share[:, None] * (paths[first, n] - paths[before, n]))
