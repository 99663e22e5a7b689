"""Finite rigid motion: bodies that move and turn far before and while they touch.

An outer loop round the small-motion problem: solve, carry the rigid motions over into the poses, pair again. The
condensed compliance lives in the bodies' axes and is reused. It ends when the poses have settled (`solve_finite`: at
the end the rigid motion within the problem is zero, so nothing of it is linearised), or as soon as what the linearised
motions leave out does not matter any more (`follow`). Strains stay small by assumption.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from fecontact.bodies.pose import Pose, turned
from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array
from fecontact.common.errors import FecontactError, SolverError
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.model import SceneModel
from fecontact.fem.rigid import COMPONENTS
from fecontact.results.checks.linearisation import BEARABLE, driven_motions, linearisation_error
from fecontact.results.result import ContactResult
from fecontact.scene.linear import solved
from fecontact.scene.local_search import SearchHistory, solve_local_case, sorted_case
from fecontact.scene.poses import posed_scene

#: Change of pose, relative to the elastic displacements, at which the poses have settled. The last change is still in
#: the linearised solution, so the error left is of its square.
SETTLED = 1e-4
#: Largest turn (radians) of one step, and largest shift or error of a linearised gap (of a body's size), so that a
#: far-off contact is not overshot.
LARGEST_STEP = 0.2
MOST_STEPS = 60
#: Steps without a better result after which motions are taken not to settle.
PATIENCE = 8
#: Correction, relative to the first motion, from which motions are taken to run away.
GROWTH = 3.0


def solve_finite(scene: SceneModel, arguments: Mapping[str, Any], timer: Stopwatch) -> ContactResult:
    """Solve with poses carried along until they settle.

    Parameters
    ----------
    scene : SceneModel
    arguments : mapping
        Of `Scene.solve`. Prescribed motions are finite: rotation vectors about the reference point, then translations.
    timer : Stopwatch
        Takes the time of all steps.

    Returns
    -------
    ContactResult
        In the final poses; it answers for the original bodies.

    Raises
    ------
    SolverError
        If the poses do not settle.
    """
    path = _Path(scene, arguments, timer)
    change = np.inf
    for _ in range(MOST_STEPS):
        result = path.solved()
        change = path.size_of(path.steps(result)) / _elastic_size(result)
        if change <= SETTLED:
            return path.finished(result)
        path.go_on(result)
    raise SolverError(
        f"The poses have not settled after {MOST_STEPS} steps (last change {change:.1e} of the elastic displacement). "
        "Start nearer to the contact, or hold the components in which the load does not bring the bodies to rest."
    )


def follow(result: ContactResult, arguments: Mapping[str, Any], timer: Stopwatch) -> ContactResult:
    """A result of small motions, or that of poses carried along where linearised motions leave out more than bearable.

    Where the motions do not settle, the best of the results found, which warns of it.

    Parameters
    ----------
    result : ContactResult
        Of small motions.
    arguments : mapping
        Of `Scene.solve`, by which it was found.
    timer : Stopwatch
        That of the result; takes the time of further steps.
    """
    best, least = result, linearisation_error(result).worst
    if least <= BEARABLE:
        return result
    path = _Path(result.scene, arguments, timer)
    path.begin(result)
    waited = 0
    try:
        for _ in range(MOST_STEPS):
            now = path.solved()
            error = linearisation_error(now).worst
            if error <= BEARABLE:
                return path.finished(now)
            waited = 0 if error < least else waited + 1
            if error < least:
                best, least = now, error
            if waited > PATIENCE or path.runs_away(now) or path.at_rest(now):
                break
            path.go_on(now)
    except FecontactError:
        pass  # on the way some pose has no answer: what was found before it stands, with its warning
    return replace(best, originals=result.scene.bodies)


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
            result.state.displacements, result.loading.frames, driven_motions(result), strict=True
        )
    ]
    floor = 1e-9 * min(frame.body.size for frame in result.loading.frames)
    return max(floor, *(float(np.abs(r).max(initial=0.0)) for r in rest))


class _Path:
    """Places visited on the way to rest, and the next one by Anderson's acceleration (Walker & Ni 2011).

    A place (6,) is a body's motion since its start, in which prescribed motions are done. The change of normals with
    the pose is left out of the small-motion problem, so plain repetition converges at a linear rate; the differences
    of a few earlier steps make up for it.
    """

    depth = 5

    def __init__(self, scene: SceneModel, arguments: Mapping[str, Any], timer: Stopwatch) -> None:
        motions = arguments.get("motions") or {}
        self._scene, self._guide, self._watch = scene, SearchHistory(), timer
        self._start = [
            turned(b.pose, _vector(motions[b]), b.pose.to_world(b.reference_point)) if b in motions else b.pose
            for b in scene.bodies
        ]
        self._whole = arguments.get("search", "global") == "global"
        small = {name: given for name, given in arguments.items() if name not in ("search", "finite_motion")}
        self._held = {**small, "motions": {b: dict.fromkeys(given, 0.0) for b, given in motions.items()}}
        sizes = np.array([b.size for b in scene.bodies])
        self._scale = np.concatenate([np.ones((len(sizes), 3)), np.repeat(sizes[:, None], 3, axis=1)], axis=1)
        self._place = np.zeros((len(sizes), 6))
        self._places: list[Array] = []
        self._steps: list[Array] = []

    def solved(self) -> ContactResult:
        """Solution of small motions from the present places."""
        bodies = self._scene.bodies
        poses = {b: _placed(s, b, p) for b, s, p in zip(bodies, self._start, self._place, strict=True)}
        self._now = posed_scene(self._scene, poses)
        return solve_local_case(self._now.scene, self._now.loads(self._held), self._guide, self._watch)

    def finished(self, result: ContactResult) -> ContactResult:
        """The result for the original bodies, on whole surfaces if that was asked for."""
        if self._whole and any(i.region is not None for i in result.interfaces):
            now = self._now.scene
            loading, settings = sorted_case(now, self._now.loads(self._held))
            result = solved(now, loading, None, settings, self._watch)
        return replace(result, originals=self._scene.bodies)

    def begin(self, result: ContactResult) -> None:
        """Go to where a result of small motions leads, besides what is prescribed."""
        steps = np.stack([m - f.prescribed for m, f in zip(driven_motions(result), result.loading.frames, strict=True)])
        self._first = self.size_of(steps)
        self._place = steps * self._share(steps, result)

    def at_rest(self, result: ContactResult) -> bool:
        """Whether the poses have settled."""
        return self.size_of(self.steps(result)) <= SETTLED * _elastic_size(result)

    def runs_away(self, result: ContactResult) -> bool:
        """Whether the next step is far larger than the motion it is to correct, and than a step may be."""
        relative = np.abs(self.steps(result) * self._scale) / self._scale[:, 3:4]
        return bool(self.size_of(self.steps(result)) > GROWTH * self._first and relative.max() > LARGEST_STEP)

    def steps(self, result: ContactResult) -> Array:
        """Change of the places (n_bodies, 6) that the present problem asks for."""
        return np.stack([_advance(p, m) for p, m in zip(self._place, driven_motions(result), strict=True)])

    def size_of(self, steps: Array) -> float:
        """Largest displacement that steps (n_bodies, 6) mean."""
        return float(np.abs(steps * self._scale).max())

    def _share(self, steps: Array, result: ContactResult) -> float:
        """Share of steps that can be gone at once: the whole of shifts whose linearised gaps come true."""
        relative = np.abs(steps * self._scale) / self._scale[:, 3:4]
        shift, turn = float(relative[:, :3].max()), float(relative[:, 3:].max())
        if max(shift, turn) <= LARGEST_STEP:
            return 1.0
        allowed = LARGEST_STEP * float(self._scale[:, 3].min())
        error = linearisation_error(result).gap
        # the error grows with the square of the step
        far = np.sqrt(allowed / error) if error > allowed else 1.0
        return min(max(far, LARGEST_STEP / shift if shift else 1.0), LARGEST_STEP / turn if turn else 1.0)

    def go_on(self, result: ContactResult) -> None:
        """To the next places, from these and the steps that the problem asks for."""
        steps, places = self.steps(result), self._place
        self._guide.settle()
        share = self._share(steps, result)
        if share < 1:
            self._places, self._steps = [], []
            self._place = places + share * steps
            return
        self._places, self._steps = [*self._places, places][-self.depth :], [*self._steps, steps][-self.depth :]
        self._place = places + steps
        if len(self._steps) == 1:
            return
        step_differences = np.stack([(s - steps).ravel() for s in self._steps[:-1]], axis=1)
        place_differences = np.stack([(p - places).ravel() for p in self._places[:-1]], axis=1)
        weight = self._scale.ravel()
        mix = np.linalg.lstsq(weight[:, None] * step_differences, -weight * steps.ravel(), rcond=1e-6)[0]
        self._place = self._place + ((place_differences + step_differences) @ mix).reshape(places.shape)
