"""Finite rigid motion: bodies that move and turn far before and while they touch.

An outer loop round the small-motion problem: solve, carry the rigid motions over into the poses, pair again, until
the poses stop changing. The condensed compliance lives in the bodies' axes and is reused. At the end the rigid motion
within the problem is zero, so nothing of it is linearised; strains stay small by assumption.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fecontact.bodies.pose import Pose
from fecontact.bodies.protocol import Body
from fecontact.errors import SolverError
from fecontact.fem.rigid import COMPONENTS
from fecontact.moved import Moved, moved, turned

if TYPE_CHECKING:
    from fecontact.result import ContactResult
    from fecontact.scene import Scene

Array = NDArray[np.float64]

#: Change of pose, relative to the elastic displacements, at which the poses have settled: the last change is still in the
#: linearised solution, so the error left is of its square.
SETTLED = 1e-4
#: Largest turn (radians) and shift (of a body's size) of one step, so that a far-off contact is not overshot.
LARGEST_STEP = 0.2
MOST_STEPS = 60


def solve_finite(scene: Scene, arguments: Mapping[str, Any]) -> ContactResult:
    """Solve with poses carried along.

    Parameters
    ----------
    scene : Scene
    arguments : mapping
        Of `Scene.solve`. Prescribed motions are finite: rotation vectors about the reference point, then translations.

    Returns
    -------
    ContactResult
        In the final poses; it answers for the original bodies.

    Raises
    ------
    SolverError
        If the poses do not settle.
    """
    motions = arguments.get("motions") or {}
    prescribed = {body: _vector(given) for body, given in motions.items()}
    poses: dict[Body, Pose] = {
        b: turned(b.pose, prescribed[b], b.pose.to_world(b.reference_point)) if b in prescribed else b.pose
        for b in scene.bodies
    }
    held = {**arguments, "motions": {b: dict.fromkeys(given, 0.0) for b, given in motions.items()}}
    change = np.inf
    for _ in range(MOST_STEPS):
        now = moved(scene, poses)
        result = now.scene.solve(**now.loads(held))
        change, poses = _step(now, result, poses)
        if change <= SETTLED:
            return replace(result, originals=scene.bodies)
    raise SolverError(
        f"The poses have not settled after {MOST_STEPS} steps (last change {change:.1e} of the elastic displacement). "
        "Start nearer to the contact, or hold the components in which the load does not bring the bodies to rest."
    )


def _vector(given: Mapping[str, float]) -> Array:
    return np.array([given.get(name, 0.0) for name in COMPONENTS], dtype=float)


def _step(now: Moved, result: ContactResult, poses: Mapping[Body, Pose]) -> tuple[float, dict[Body, Pose]]:
    """New poses, and the largest change relative to the elastic displacements."""
    new, largest, elastic = {}, 0.0, 0.0
    for k, original in enumerate(now.originals):
        frame, motion = result.loading.frames[k], result.state.motions[k]
        size = frame.body.size
        reach = max(float(np.linalg.norm(motion[:3])) / size, float(np.linalg.norm(motion[3:])))
        share = min(1.0, LARGEST_STEP / reach) if reach > 0 else 1.0
        new[original] = turned(poses[original], share * motion, frame.point)
        largest = max(largest, reach * size)
        rest = result.state.displacements[k] - frame.modes(motion[:, None])[:, 0]
        elastic = max(elastic, float(np.abs(rest).max(initial=0.0)))
    floor = 1e-9 * min(b.size for b in now.scene.bodies)
    return largest / max(elastic, floor), new
