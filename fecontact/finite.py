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
from scipy.spatial.transform import Rotation

from fecontact.bodies.pose import Pose
from fecontact.bodies.protocol import Body
from fecontact.errors import SolverError
from fecontact.fem.rigid import COMPONENTS
from fecontact.moved import moved, turned
from fecontact.partly import Guide, solve_guided

if TYPE_CHECKING:
    from fecontact.result import ContactResult
    from fecontact.scene import Scene

Array = NDArray[np.float64]

#: Change of pose, relative to the elastic displacements, at which the poses have settled. The last change is still in
#: the linearised solution, so the error left is of its square.
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
    start = {
        b: turned(b.pose, _vector(motions[b]), b.pose.to_world(b.reference_point)) if b in motions else b.pose
        for b in scene.bodies
    }
    whole = bool(arguments.get("whole", True))
    small = {name: given for name, given in arguments.items() if name not in ("whole", "finite_motion")}
    held = {**small, "motions": {b: dict.fromkeys(given, 0.0) for b, given in motions.items()}}
    guide = Guide()
    path = _Path(np.array([b.size for b in scene.bodies]))
    places = np.zeros((len(scene.bodies), 6))
    change = np.inf
    for _ in range(MOST_STEPS):
        now = moved(scene, {b: _placed(start[b], b, place) for b, place in zip(scene.bodies, places, strict=True)})
        result = solve_guided(now.scene, now.loads(held), guide)
        steps = np.stack([_advance(p, m) for p, m in zip(places, result.state.motions, strict=True)])
        change = path.size_of(steps) / _elastic_size(result)
        if change <= SETTLED:
            if whole and any(i.near is not None for i in result.interfaces):
                result = now.scene.solve(**now.loads(held))
            return replace(result, originals=scene.bodies)
        guide.settle()
        places = path.following(places, steps)
    raise SolverError(
        f"The poses have not settled after {MOST_STEPS} steps (last change {change:.1e} of the elastic displacement). "
        "Start nearer to the contact, or hold the components in which the load does not bring the bodies to rest."
    )


def _vector(given: Mapping[str, float]) -> Array:
    return np.array([given.get(name, 0.0) for name in COMPONENTS], dtype=float)


def _placed(start: Pose, body: Body, place: Array) -> Pose:
    """Pose after a finite motion (6,) from the start: rotation vector about the reference point, then translation."""
    return turned(start, place, start.to_world(body.reference_point))


def _advance(place: Array, motion: Array) -> Array:
    """Change of a place (6,) by a further motion (6,); rotations are composed, not added."""
    total = (Rotation.from_rotvec(motion[3:]) * Rotation.from_rotvec(place[3:])).as_rotvec()
    return np.concatenate([motion[:3], total - place[3:]])


def _elastic_size(result: ContactResult) -> float:
    """Largest elastic displacement, but not less than 1e-9 of a body."""
    rest = [
        u - frame.modes(motion[:, None])[:, 0]
        for u, frame, motion in zip(
            result.state.displacements, result.loading.frames, result.state.motions, strict=True
        )
    ]
    floor = 1e-9 * min(frame.body.size for frame in result.loading.frames)
    return max(floor, *(float(np.abs(r).max(initial=0.0)) for r in rest))


class _Path:
    """Places visited on the way to rest, and the next one by Anderson's acceleration (Walker & Ni 2011).

    The change of normals with the pose is left out of the small-motion problem, so plain repetition converges at a
    linear rate; the differences of a few earlier steps make up for it.
    """

    depth = 5

    def __init__(self, sizes: Array) -> None:
        self._scale = np.concatenate([np.ones((len(sizes), 3)), np.repeat(sizes[:, None], 3, axis=1)], axis=1)
        self._places: list[Array] = []
        self._steps: list[Array] = []

    def size_of(self, steps: Array) -> float:
        """Largest displacement that steps (n_bodies, 6) mean."""
        return float(np.abs(steps * self._scale).max())

    def following(self, places: Array, steps: Array) -> Array:
        """The next places from these and the steps the problem asks for."""
        largest = float((np.abs(steps * self._scale) / self._scale[:, 3:4]).max())
        if largest > LARGEST_STEP:
            self._places, self._steps = [], []
            return places + steps * (LARGEST_STEP / largest)
        self._places, self._steps = [*self._places, places][-self.depth :], [*self._steps, steps][-self.depth :]
        if len(self._steps) == 1:
            return places + steps
        step_differences = np.stack([(s - steps).ravel() for s in self._steps[:-1]], axis=1)
        place_differences = np.stack([(p - places).ravel() for p in self._places[:-1]], axis=1)
        weight = self._scale.ravel()
        share = np.linalg.lstsq(weight[:, None] * step_differences, -weight * steps.ravel(), rcond=1e-6)[0]
        correction = (place_differences + step_differences) @ share
        return places + steps + correction.reshape(places.shape)
