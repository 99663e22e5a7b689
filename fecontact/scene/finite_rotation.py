"""Finite rigid motion of bodies: large translations and rotations.

An outer loop round the small-motion problem: solve, update the poses by the rigid motions, pair again. The condensed
compliance is in the bodies' axes and is reused. It ends when the poses have converged (`solve_finite`: the rigid motion
in the last problem is zero, so none of it is linearised), or as soon as the error of linearised motions is tolerable
(`follow`). Strains are assumed small.

Check that bodies are in equilibrium: motions larger than any length of their scene are refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from fecontact.bodies.body import Body
from fecontact.bodies.pose import Pose, turned
from fecontact.common.arrays import Array
from fecontact.common.errors import FecontactError, SolverError, SupportError
from fecontact.common.progress import set_part
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.loads import Loading, LoadStep
from fecontact.contact.model import SceneModel
from fecontact.contact.step_end import StepEnd
from fecontact.fem.rigid import COMPONENTS
from fecontact.results.linearisation import BEARABLE, CarriedMotion, driven_motions, linearisation_error
from fecontact.results.result import ContactResult
from fecontact.scene.carried import posed_scene
from fecontact.scene.linear import Settings, solved
from fecontact.scene.local_search import SearchHistory, solve_local
from fecontact.scene.turning_steps import newton_step

#: Change of pose, relative to the elastic displacements, at convergence. The last change is included in the linearised
#: solution, so the remaining error is of its square. Compliances that are products come to rest without Newton's steps,
#: with another last change: figures of one scene by both differ by up to some 3e-6, within this tolerance.
STEP_TOLERANCE = 1e-4
#: Change of pose, relative to the motions, at which 'auto' stops: a load that goes along with a body turns it further,
#: which the errors of gaps do not show. And the estimate of what further poses would change at which it stops, too: as
#: much as the square of the former.
CARRIED, FURTHER = 1e-3, 1e-5
#: Largest rotation (radians) of one step, and largest translation or error of a linearised gap (relative to a body's
#: size), so that a distant contact is not overshot.
MAX_STEP = 0.2
MAX_ITERATIONS = 60
#: Steps without a better result after which the motions count as not converging.
PATIENCE = 8
#: Correction, relative to the first motion, above which the motions count as diverging.
GROWTH = 3.0


def solve_finite(
    scene: SceneModel,
    step: LoadStep,
    settings: Settings,
    timer: Stopwatch,
    poses: Sequence[Pose] = (),
    past: StepEnd | None = None,
) -> ContactResult:
    """Solve with poses updated until they converge.

    Parameters
    ----------
    scene : SceneModel
    step : LoadStep
        Prescribed motions are finite: rotation vectors about the reference point, then translations.
    settings : Settings
    timer : Stopwatch
        Timer of all steps.
    poses : sequence of Pose, optional
        Poses to begin with, such as the final ones of a similar case; they do not change the solution.
    past : StepEnd, optional
        With friction: end of the last load step; by default the unloaded state in the given poses.

    Returns
    -------
    ContactResult
        Result in the final poses, accessed by the original bodies.

    Raises
    ------
    SolverError
        If the poses do not converge.
    """
    path = _Path(scene, step, settings, timer, past)
    if poses:
        path.begin_at(poses)
    change = np.inf
    for k in range(MAX_ITERATIONS):
        set_part(f"pose {k + 1}")
        result = path.solved()
        change = path.size_of(path.steps(result)) / _elastic_size(result)
        carried = path.carried(result)
        if change <= STEP_TOLERANCE:
            return path.finished(replace(result, _carried=None if poses else carried))
        path.go_on(result)
    raise SolverError(
        f"The poses have not settled after {MAX_ITERATIONS} steps (last change {change:.1e} of the elastic "
        "displacement). Start nearer to the contact, or hold the components in which the load does not bring the "
        "bodies to rest.",
        code="not-settled",
    )


def follow(
    result: ContactResult,
    step: LoadStep,
    settings: Settings,
    timer: Stopwatch,
    history: SearchHistory | None = None,
) -> ContactResult:
    """The result of small motions, or one with updated poses where the error of linearised motions is too large.

    If the motions do not converge, the best of the results, with a warning.

    Parameters
    ----------
    result : ContactResult
        Result of small motions.
    step : LoadStep
    settings : Settings
    timer : Stopwatch
        Timer of the result, also used for further steps.
    history : SearchHistory, optional
        After that result: what it has needed is predicted for the further steps.
    """
    best, least = _judged(result)
    if least <= BEARABLE:
        return best
    path = _Path(result.scene, step, settings, timer, history=history)
    if path.at_rest(best):  # it is deflections, which poses do not take up
        return best
    path.begin(best)
    return _followed(path, best, least)


def follow_from(
    scene: SceneModel, step: LoadStep, settings: Settings, timer: Stopwatch, poses: Sequence[Pose]
) -> ContactResult | None:
    """`follow` from poses other than the first; None where they have no solution.

    Parameters
    ----------
    scene : SceneModel
    step : LoadStep
    settings : Settings
    timer : Stopwatch
    poses : sequence of Pose
        Such as the final ones on a coarser mesh.
    """
    path = _Path(scene, step, settings, timer)
    path.begin_at(poses)
    try:
        best, least = _judged(path.solved())
    except FecontactError:
        return None  # from the first poses there may be one
    if least <= BEARABLE:
        return path.finished(best)
    if path.at_rest(best):
        return replace(best, _originals=path.originals)
    path.carried(best)
    path.go_on(best)
    # the first result has carried poses already
    return replace(_followed(path, best, least), _carried=None)


def _followed(path: _Path, best: ContactResult, least: float) -> ContactResult:
    """The first bearable result on a path whose motions settle, or the best before they stop to converge."""
    waited = 0
    carried: CarriedMotion | None = None
    try:
        for k in range(MAX_ITERATIONS):
            set_part(f"pose {k + 2}")
            now, error = _judged(path.solved())
            change = path.carried(now)
            if error <= BEARABLE and (change is None or change.rest <= CARRIED or path.left(now, change) <= FURTHER):
                return path.finished(replace(now, _carried=change))
            # of bearable ones the one whose motions have changed least
            nearer = carried is None or change is None or change.rest < carried.rest
            better = nearer if error <= BEARABLE and least <= BEARABLE else error < least
            waited = 0 if better else waited + 1
            if better:
                best, least, carried = now, error, change
            if waited > PATIENCE or path.runs_away(now) or path.at_rest(now):
                break
            path.go_on(now)
    except FecontactError:
        pass  # a pose without a solution: the earlier result is returned with its warning
    return replace(best, _originals=path.originals, _carried=carried)


def _judged(result: ContactResult) -> tuple[ContactResult, float]:
    """The result with the error of linearised motions, and the worst of it."""
    error = linearisation_error(result)
    return replace(result, _linearisation=error), error.worst


def carried_poses(scene: SceneModel, before: LoadStep, now: LoadStep, poses: Sequence[Pose]) -> list[Pose]:
    """Poses to begin a load step at: those of the last one, with the change of the prescribed motions.

    Parameters
    ----------
    scene : SceneModel
        Scene in the given poses.
    before, now : LoadStep
        The last step and this one.
    poses : sequence of Pose
        At the end of the last step.
    """
    out = []
    for body, pose in zip(scene.bodies, poses, strict=True):
        last, start = (_prescribed(body, _posed(scene, step)) for step in (before, now))
        out.append(_placed(start, body, _motion(last, body, pose)))
    return out


def _taken_up(scene: SceneModel) -> Array:
    """One for each component (6,) of motions that poses take up, zero for twists of bodies of revolution."""
    return np.array([0.0 if scene.twists and name == "rz" else 1.0 for name in COMPONENTS])


def _posed(scene: SceneModel, step: LoadStep) -> dict[Body, dict[str, float]]:
    """Prescribed motions that poses take up."""
    every = step.motions.items()
    return {b: {c: v for c, v in motion.items() if not (scene.twists and c == "rz")} for b, motion in every}


def _prescribed(body: Body, motions: Mapping[Body, Mapping[str, float]]) -> Pose:
    """Pose of a body after its prescribed motion."""
    return _placed(body.pose, body, _vector(motions[body])) if body in motions else body.pose


def _vector(given: Mapping[str, float]) -> Array:
    return np.array([given.get(name, 0.0) for name in COMPONENTS], dtype=float)


def _placed(start: Pose, body: Body, place: Array) -> Pose:
    """Pose after a finite motion (6,) from the start: rotation vector about the reference point, then translation."""
    return turned(start, place, start.to_world(body.reference_point))


def _motion(start: Pose, body: Body, pose: Pose) -> Array:
    """Finite motion (6,) from the start to a pose; the inverse of `_placed`."""
    turn = Rotation.from_matrix(pose.rotation @ start.rotation.T).as_rotvec()
    return np.concatenate([pose.to_world(body.reference_point) - start.to_world(body.reference_point), turn])


def _advance(place: Array, motion: Array) -> Array:
    """Motion (6,) composed with a further motion (6,); rotations are composed, not added."""
    total = (Rotation.from_rotvec(motion[3:]) * Rotation.from_rotvec(place[3:])).as_rotvec()
    return np.concatenate([motion[:3], total - place[3:]])


def _elastic_size(result: ContactResult) -> float:
    """Largest elastic displacement, at least 1e-9 of a body's size."""
    motions = np.where(_taken_up(result.scene), driven_motions(result), result._motions)
    rest = [
        u - frame.modes(motion[:, None])[:, 0]
        for u, frame, motion in zip(result._state.displacements, result._loading.frames, motions, strict=True)
    ]
    floor = 1e-9 * float(result.scene.sizes.min())
    return max(floor, *(float(np.abs(r).max(initial=0.0)) for r in rest))


def _forces(result: ContactResult) -> Array:
    """Sizes (n_contacts,) of the forces of contacts."""
    return np.array([contact.total_force for contact in result.contacts])


class _Path:
    """Iteration of the bodies' motions to equilibrium, with Anderson acceleration (Walker & Ni 2011).

    An iterate (6,) is a body's motion since its start, including prescribed motions. The small-motion problem neglects
    the change of normals with the pose, so plain iteration converges linearly; the differences of a few earlier steps
    accelerate it.
    """

    depth = 5

    def __init__(
        self,
        scene: SceneModel,
        step: LoadStep,
        settings: Settings,
        timer: Stopwatch,
        past: StepEnd | None = None,
        history: SearchHistory | None = None,
    ) -> None:
        posed = _posed(scene, step)
        self._scene, self._settings, self._watch = scene, settings, timer
        self._guide = SearchHistory(() if history is None else history.search_radii)
        self._guide.settle()  # the poses are moved by the predicted motion
        # the unloaded state of bodies with friction is that of the poses given
        self._past = past or (StepEnd(tuple(b.pose for b in scene.bodies)) if scene.has_friction else None)
        self._start = [_prescribed(body, posed) for body in scene.bodies]
        left = {b: {**given, **dict.fromkeys(posed[b], 0.0)} for b, given in step.motions.items()}
        self._held = replace(step, motions=left)
        self._sizes = scene.sizes
        self._scale = np.where(np.arange(6) < 3, 1.0, scene.sizes[:, None])
        self._place = np.zeros(self._scale.shape)
        self._places: list[Array] = []
        self._steps: list[Array] = []
        #: Length of the last step, zero where it was cut.
        self._last = 0.0
        #: Motions and forces of contacts of the first result.
        self._linear: tuple[Array, Array] | None = None

    @property
    def originals(self) -> Sequence[Body]:
        """The bodies as they were given."""
        return self._scene.bodies

    def solved(self) -> ContactResult:
        """Solution of small motions from the present iterate."""
        bodies = self._scene.bodies
        poses = {b: _placed(s, b, p) for b, s, p in zip(bodies, self._start, self._place, strict=True)}
        self._now = posed_scene(self._scene, poses)
        scene, loading = self._now.scene, self._loading()
        if self._past is None:
            return solve_local(scene, loading, self._settings, self._watch, self._guide)
        return solved(scene, loading, None, self._settings, self._watch, (), self._past)

    def _loading(self) -> Loading:
        """Loads on the bodies in the present poses."""
        return self._now.step(self._held).on(self._now.scene.bodies, self._scene.bodies)

    def finished(self, result: ContactResult) -> ContactResult:
        """The result for the original bodies, on whole surfaces if requested."""
        carried = result._carried
        if self._settings.search == "global" and any(i.region is not None for i in result._interfaces):
            result = solved(self._now.scene, self._loading(), None, self._settings, self._watch)
        return replace(result, _originals=self.originals, _carried=carried)

    def begin(self, result: ContactResult) -> None:
        """Set the first iterate from a result of small motions and the prescribed motions."""
        prescribed = [f.prescribed for f in result._loading.frames]
        steps = driven_motions(result) - prescribed * _taken_up(self._scene)
        self._first = self.size_of(steps)
        ahead = newton_step(result, steps)
        share = self._share(ahead, result)
        self._place, self._last = ahead * share, self._first if share == 1 else 0.0
        self._linear = steps, _forces(result)

    def begin_at(self, poses: Sequence[Pose]) -> None:
        """Set the first iterate from poses of the bodies."""
        every = zip(self._scene.bodies, self._start, poses, strict=True)
        self._place = np.stack([_motion(start, body, pose) for body, start, pose in every])
        self._first = self.size_of(self._place)

    def carried(self, result: ContactResult) -> CarriedMotion | None:
        """What carrying the poses has changed since the first result; None of that one itself."""
        steps, forces = self.steps(result), _forces(result)
        motions = self._place + steps
        if self._linear is None:
            self._linear = motions, forces
            return None
        first, pressed = self._linear
        size = max(self.size_of(motions), _elastic_size(result))
        largest = float(max(forces.max(initial=0.0), pressed.max(initial=0.0))) or 1.0
        force = float(np.abs(forces - pressed).max(initial=0.0)) / largest
        return CarriedMotion(self.size_of(motions - first) / size, force, self.size_of(steps) / size)

    def left(self, result: ContactResult, change: CarriedMotion) -> float:
        """Estimate of what further poses would change of the motions of a result, relative to the largest.

        The last step is among those motions. Steps that become shorter by a factor q add q / (1 - q) of the last one
        (Hairer & Wanner, Solving Ordinary Differential Equations II, 2nd ed. 1996, section IV.8), and Newton's step
        what it adds, if that is more.
        """
        steps = self.steps(result)
        size = self.size_of(steps)
        if size >= self._last:
            return change.rest
        more = self.size_of(newton_step(result, steps) - steps)
        return change.rest * max(size / (self._last - size), more / size if size else 0.0)

    def at_rest(self, result: ContactResult) -> bool:
        """Whether the poses have converged."""
        return self.size_of(self.steps(result)) <= STEP_TOLERANCE * _elastic_size(result)

    def runs_away(self, result: ContactResult) -> bool:
        """Whether the next step is far larger than the motion it corrects and than the step limit."""
        relative = self._lengths(self.steps(result)) / self._sizes[:, None]
        return bool(self.size_of(self.steps(result)) > GROWTH * self._first and relative.max() > MAX_STEP)

    def steps(self, result: ContactResult) -> Array:
        """Change of the iterate (n_bodies, 6) by the present problem."""
        return np.stack([_advance(p, m) for p, m in zip(self._place, driven_motions(result), strict=True)])

    def size_of(self, steps: Array) -> float:
        """Largest displacement due to steps (n_bodies, 6)."""
        return float(self._lengths(steps).max())

    def _lengths(self, steps: Array) -> Array:
        """Lengths (n_bodies, 2) of the translations and rotations of steps (n_bodies, 6), the same in all axes."""
        return np.asarray(np.linalg.norm((steps * self._scale).reshape(-1, 2, 3), axis=2))

    def _share(self, steps: Array, result: ContactResult) -> float:
        """Admissible share of a step, limited by rotation, translation and the error of linearised gaps."""
        shift, turn = (float(each.max()) for each in self._lengths(steps).T / self._sizes)
        if max(shift, turn) <= MAX_STEP:
            return 1.0
        allowed = MAX_STEP * float(self._sizes.min())
        error = linearisation_error(result).gap
        # the error grows with the square of the step
        far = np.sqrt(allowed / error) if error > allowed else 1.0
        return min(max(far, MAX_STEP / shift if shift else 1.0), MAX_STEP / turn if turn else 1.0)

    def go_on(self, result: ContactResult) -> None:
        """Set the next iterate from the present one and its step."""
        own, places = self.steps(result), self._place
        steps = newton_step(result, own)
        self._guide.settle()
        share = self._share(steps, result)
        self._last = self.size_of(own) if share == 1 else 0.0
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


#: Largest rotation (radians) and translation (relative to the largest body, gap and elastic displacement) of a body
#: held by contacts; a larger motion was resisted by slight slopes, the corners of facets or rounding only.
MAX_TURN, MAX_SHIFT = 1.0, 1e3


def check_rest(result: ContactResult) -> ContactResult:
    """The result; refused if a body moved further than any length of its scene.

    A load along a motion resisted only by rounding or the corners of facets (a ring on a round shaft with a
    non-matching mesh) has an algebraic solution: the body rotates until a slope of 1e-8 balances the load.

    Raises
    ------
    SupportError
        Describes the motion.
    """
    frames, state = result._loading.frames, result._state
    sizes = result.scene.sizes
    gaps = np.concatenate([i.gap for i in result._condensed.interfaces])
    known = max(sizes) + float(np.abs(gaps[np.isfinite(gaps)]).max(initial=0.0))
    found = [motion - frame.prescribed for frame, motion in zip(frames, state.motions, strict=True)]
    shifts, turns = np.linalg.norm(np.reshape(found, (-1, 2, 3)), axis=2).T
    if turns.max() <= MAX_TURN and shifts.max() <= MAX_SHIFT * known:
        return result
    # a load that deforms the bodies by as much has an equilibrium, if an absurd one; strains are warned of
    rest = [u - f.modes(m[:, None])[:, 0] for u, f, m in zip(state.displacements, frames, state.motions, strict=True)]
    elastic = max(float(np.abs(r).max(initial=0.0)) for r in rest)
    texts = []
    for frame, motion, turn, shift in zip(frames, found, turns, shifts, strict=True):
        if turn > MAX_TURN * max(1.0, elastic / max(sizes)):
            texts.append(f"{frame.describe(motion)}, by {turn:.3g} rad")
        elif shift > MAX_SHIFT * max(known, elastic):
            texts.append(f"{frame.describe(motion)}, by {shift:.3g}")
    if not texts:
        return result
    raise SupportError(
        "Contacts and springs resist a motion so little (by slight slopes, the corners of facets or rounding) that it "
        f"goes beyond all lengths of the scene; what was found is no rest - {'; '.join(texts)}. Support the body in "
        "that motion, prescribe it with motions=, change the load, or start nearer to the rest that "
        "finite_motion=True is to find.",
        code="no-rest",
    )
