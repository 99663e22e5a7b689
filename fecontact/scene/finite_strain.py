"""Scenes with bodies at finite strain: Newton's method whose every iteration is a linear scene.

A body with a law is linearised at its present state into a linear body: its deformed mesh, its tangent, its internal
forces as a load (`Body._linearised`). The scene of these bodies is paired, condensed and solved as any other,
with the same certificate and the exact law of friction, for the change of the state. Where nothing changes any more,
its answer is that of the nonlinear scene. Closed gaps hold bodies that are not stable without them (`contact.hold`).

Normals turn with the surfaces, which the linear scene does not know: the forces of the last iteration add a stiffness
for it (`contact.turning`). What it neglects makes convergence linear; Anderson's acceleration makes up for it (Walker &
Ni, SIAM J. Numer. Anal. 49 (2011) 1715).

Friction acts over load steps: slip is counted from the start of the step, point by point of the material.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, cast

import numpy as np
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import elastic_among
from fecontact.bodies.pose import Pose, turned
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import FecontactError, InputError, SolverError, SupportError
from fecontact.common.path import HALVINGS, in_parts
from fecontact.common.progress import set_part
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.friction_rows import TangentialRows
from fecontact.contact.hold import Hold
from fecontact.contact.interface import Interface
from fecontact.contact.loads import Loading, LoadStep
from fecontact.contact.model import SceneModel
from fecontact.contact.springs import spring_rows
from fecontact.contact.step_end import StepEnd
from fecontact.contact.turning import following_stiffness, press, turning_with
from fecontact.fem.finite_strain import State
from fecontact.fem.laws import InvertedError, laws_of
from fecontact.fem.rigid import COMPONENTS
from fecontact.results.linearisation import Equilibrium, unbalanced
from fecontact.results.result import ContactResult
from fecontact.scene.carried import CarriedScene, posed, with_bodies
from fecontact.scene.linear import Settings, solved
from fecontact.scene.stability import Weakest, is_stable, not_found_beyond, not_stable, weakest
from fecontact.surfaces.facet_surface import with_nodes
from fecontact.surfaces.normals import normals_of

#: Change of displacements and residual of forces, relative to the size of the bodies and to the largest force inside,
#: at convergence.
TOLERANCE = 1e-8
#: Residual up to which the change alone decides: near nu = 1/2 a change by rounding has large forces. No residual of
#: contact and friction may be above it, penetration ten times: across a row of single cells friction is rounding.
BALANCED = 1e-6
#: Ratio of residuals above the tolerance, each to the last one, up to which iterations go on: rounding falls less.
FALLS = 0.5
#: Change of two iterations up to which the residual alone decides: where a tangent is nearly singular, changes are
#: rounding before they are small.
NEARLY = 1e-5
MAX_ITERATIONS = 25
#: Change above which a step that has begun to settle runs away, and the iteration from which that is judged.
RUNS_AWAY, SETTLING = 5.0, 6
#: Change up to which all of as many iterations leave the residual to decide, which may be `BALANCED`.
SETTLED = 1e-6
#: Stiffness of the weakest motion, over that at rest, up to which a step that finds no equilibrium ends at an unstable
#: one.
CRITICAL = 0.5
#: Displacement over that of a linear step from which bodies have jumped: at least 1.9 over snaps, below 1 elsewhere.
JUMP = 1.5
#: Least share of a step of Newton's method that keeps all cells upright.
MIN_SHARE = 1e-3
#: Solutions of one iteration with fewer and fewer held points.
MAX_HOLDS = 12
#: Codes of errors of tangents that are not stable, even where closed gaps hold them.
UNSTABLE = ("singular", "not-semidefinite", "indefinite")
#: Codes of errors of an iteration that smaller steps may not have: singular problems, and faces it has distorted.
SMALLER = ("singular", "not-semidefinite", "no-area")
#: Codes of errors of bodies of which no surfaces face each other any more, and of points that cross edges to and fro.
APART, EDGES = "not-facing", "edges"
#: Iterations within which points that cross edges come back, and the least turn of their normals, over the change of
#: displacements relative to the size, that no smooth surface has.
TO_AND_FRO, SHARP = 4, 10.0
#: Change of unit normals since rest from which on the tangent knows of it.
TURNED = 1e-2
#: Acceleration: earlier iterations that it uses, the change below which it begins, and the ratio of changes above
#: which convergence is linear.
DEPTH, BEGIN, SLOW = 5, 1e-3, 0.1


#: Damping of tangents that are not stable: a share of the stiffness of the present shape at rest, the first and the
#: largest, its growth where that is not enough, and its fall in each iteration, down to the least.
FIRST_DAMPING, MAX_DAMPING, DAMPING_GROWS, DAMPING_FALLS, MIN_DAMPING = 0.1, 3.0, 3.0, 4.0, 0.02
#: Fall, in each iteration, of the damping below which a tangent was not stable: less is not tried at once.
NEED_FALLS = 0.7

#: Components of prescribed motions that are rotation vectors.
TURNS = COMPONENTS[3:]


def is_nonlinear(model: SceneModel) -> bool:
    """Whether a body of a scene has a law of finite strain."""
    return any(body._finite_strain is not None for body in model.bodies)


@dataclass(frozen=True, eq=False)
class Reached:
    """A converged load step.

    Attributes
    ----------
    model : SceneModel
        With the sides and the coupling of contacts that were chosen in the first iteration of all.
    step : LoadStep
    states : tuple of State or None
        Of each body; None of linear ones.
    poses : tuple of Pose
    hold : Hold
        Points that are closed and that stick.
    displacements : tuple of (n_dofs,) array or None
        Of linear bodies with friction: without rigid motion.
    result : ContactResult or None
    equilibria : tuple of Equilibrium
        Of all steps so far.
    weakest : Weakest, optional
        The motion that nothing resists, of a state that is not stable.
    """

    model: SceneModel
    step: LoadStep
    states: tuple[State | None, ...]
    poses: tuple[Pose, ...]
    hold: Hold
    displacements: tuple[Array | None, ...] = ()
    result: ContactResult | None = None
    equilibria: tuple[Equilibrium, ...] = ()
    weakest: Weakest | None = None

    def result_of(self, bodies: Sequence[Body]) -> ContactResult:
        """Its result, for the bodies as they were given."""
        assert self.result is not None
        return replace(self.result, _originals=tuple(bodies), finite_strain=self.equilibria)

    @property
    def residual(self) -> float:
        """Of the last step: largest unbalanced force on a node, relative to the largest force inside."""
        return self.equilibria[-1].residual

    @property
    def kept(self) -> dict[str, Any]:
        """What `next_reached` makes it from again."""
        names = ("states", "poses", "hold", "displacements", "equilibria")
        sides = [(contact.coupling, contact.swap) for contact in self.model.contacts]
        return {**{name: getattr(self, name) for name in names}, "sides": sides}


def solve_at_finite_strain(model: SceneModel, step: LoadStep, settings: Settings, timer: Stopwatch) -> ContactResult:
    """Solution of a scene with bodies at finite strain, in as many load steps as it needs.

    Raises
    ------
    InputError
        For settings that are not offered with laws of finite strain.
    SolverError
        If the smallest step has no certified solution.
    """
    start = at_rest(model, step)

    def solve(begin: float, end: float, last: Reached | None) -> Reached:
        return next_reached(last or start, start.step.between(step, end), (begin, end), settings, timer)

    *_, (_, reached) = in_parts(solve, None)
    return reached.result_of(model.bodies)


def at_rest(model: SceneModel, step: LoadStep) -> Reached:
    """The unloaded state of a scene, with what is free in a step; its linear bodies are condensed."""
    _condense_linear(model)
    none = [np.zeros(0, np.int64)] * len(model.contacts)
    return Reached(
        model,
        LoadStep(free=step.free),
        tuple(None if (cells := body._finite_strain) is None else cells.rest for body in model.bodies),
        tuple(body.pose for body in model.bodies),
        Hold(none, none),
        displacements=(None,) * len(model.bodies),
    )


def next_reached(
    start: Reached,
    end: LoadStep,
    part: tuple[float, float],
    settings: Settings,
    timer: Stopwatch,
    known: Mapping[str, Any] | None = None,
) -> Reached:
    """The state under other loads, at the end of a part of a step, or certified from what `Reached.kept` has of it.

    Raises
    ------
    SolverError
        With the code ``unstable`` and the motion that hardly anything resists, if the smallest part ends there.
    """
    smallest = part[1] - part[0] <= 1 / 2**HALVINGS
    ways: list[dict[str, bool]] = [{}]
    if known is None:
        # what the rims of pressures that follow leave out of the tangent may lead away, and so may turning surfaces
        borne = [body for body, _ in end.pressures if body._finite_strain is not None]
        ways += [{"following": False}] if borne else []
        ways += [{"turning": False}, *([{"damped": True}] if smallest else [])] if _soft_pairs(start.model) else []
    try:
        for k, way in enumerate(ways):
            newton = _Newton(settings, timer, start, end, known, **way)
            try:
                reached = newton.converged()
                break
            except SolverError:
                if k == len(ways) - 1:
                    raise
        if newton.jumped and (not smallest or _critical(start)):
            raise SolverError("The bodies jump to another equilibrium.", code="jump")
    except SolverError as error:
        if not smallest:
            raise
        told = error.code in (APART, EDGES)
        last = None if told or error.code == InvertedError.code else _critical(start)
        cautions = _cautions(start.model)
        if last is None:
            raise SolverError(f"{error}{cautions}", code=error.code if told else "no-equilibrium") from error
        raise SolverError(not_found_beyond(last, part[0]) + cautions, code="unstable") from error
    assert reached.result is not None
    if is_stable(reached.result):
        return reached
    now = weakest(reached.result)
    unstable = not_stable(_weakest(start), now, part)
    equilibria = (*reached.equilibria[:-1], replace(reached.equilibria[-1], unstable=unstable))
    return replace(reached, weakest=now, equilibria=equilibria)


def _cautions(model: SceneModel) -> str:
    """What the laws of a scene say of their constants, each once, after a sentence."""
    laws = [law.caution for body in elastic_among(model.bodies) for law in laws_of(body.material)]
    return "".join(f" {text}" for text in dict.fromkeys(laws) if text)


def _soft_pairs(model: SceneModel) -> bool:
    """Whether a contact is between two bodies with laws of finite strain."""
    return any(all(body._finite_strain is not None for body in contact.bodies) for contact in model.contacts)


def _weakest(state: Reached) -> Weakest | None:
    """The weakest motion of a state; None at rest."""
    return state.weakest or (None if state.result is None else weakest(state.result))


def _critical(state: Reached) -> Weakest | None:
    """The weakest motion of a state that is about to be unstable; None of others."""
    found = _weakest(state)
    return found if found is not None and found.stiffness <= CRITICAL else None


#: Values of options that are offered with a law of finite strain, and the remedy for others.
OFFERED: Mapping[str, tuple[tuple[object, ...], str]] = {
    "search": (("global",), "leave it out"),
    "finite_motion": (("auto", True), "leave it out: motions are finite"),
    "engine": (("own",), "leave it out"),
}


def _condense_linear(model: SceneModel) -> None:
    """Condense linear bodies onto their whole surfaces, once for all iterations: which nodes touch changes in them."""
    springs = spring_rows(model.springs)
    for body in elastic_among(model.bodies):
        ends = [end for c in model.contacts for end in zip(c.bodies, c.surfaces or (), strict=True)]
        names = {name for other, name in ends if other is body}
        if body._finite_strain is not None or not names:
            continue
        surfaces = [body.surface(name) for name in names]
        on = [surface.project(surface.points[surface.nodes]) for surface in surfaces]
        rows = [body._trace(places, np.ones_like(places.points)) for places in on]
        rows += [ends for ends in (springs.rows(body),) if ends is not None]
        body.model.condensed(np.unique(np.concatenate([body.model.touched(each) for each in rows])), Stopwatch())


def refuse_with_laws(model: SceneModel, **given: object) -> None:
    """Refuse options that are not offered for scenes with a law of finite strain.

    Raises
    ------
    InputError
    """
    if not is_nonlinear(model):
        return
    for name, value in given.items():
        offered, remedy = OFFERED[name]
        if not any(isinstance(value, type(each)) and value == each for each in offered):  # 1 is not True
            raise InputError(
                f"{name}={value!r} is not offered for bodies with a law of finite strain: {remedy}.",
                code="finite-strain",
            )


class _Newton:
    """One load step."""

    def __init__(
        self,
        settings: Settings,
        timer: Stopwatch,
        start: Reached,
        end: LoadStep,
        known: Mapping[str, Any] | None = None,
        following: bool = True,
        turning: bool = True,
        damped: bool = False,
    ) -> None:
        self._model, self._settings, self._timer, self._following = start.model, settings, timer, following
        self._start, self._end, self._known = start, end, known
        self._states, self._hold, self._bodies = list(start.states), start.hold, list(start.model.bodies)
        # rotations are finite; shifts are part of the linear scene, so that nothing overlaps at first
        self._motions = motions_between(start.step, end, whole=known is None)
        self._poses = [_turned(*each, self._motions) for each in zip(start.model.bodies, start.poses, strict=True)]
        self._turned_poses = tuple(self._poses)
        self._size = max(body.size for body, state in zip(start.model.bodies, start.states, strict=True) if state)
        self._elastic = list(start.displacements)
        if known is not None:
            self._states = [None if each is None else State(**each) for each in known["states"]]
            self._poses, self._hold = [Pose(**each) for each in known["poses"]], Hold(**known["hold"])
            self._elastic = list(known["displacements"])
            contacts = [
                replace(contact, coupling=coupling, swap=swap)
                for contact, (coupling, swap) in zip(start.model.contacts, known["sides"], strict=True)
            ]
            self._model = replace(start.model, contacts=contacts)
        self._changes: list[float] = []
        self._violated = ""
        #: Directions in which points press, of the last iterations, see `_directions`.
        self._pressing: list[list[tuple[IntArray, Array]]] = []
        #: A state that has settled, and is not stable: of the points by its rim that open and close, one may be.
        self._settled: Reached | None = None
        self._past: list[tuple[Array, Array]] = []
        #: Motions so far, rotations as lengths.
        self._way = [np.zeros(6)] * len(start.model.bodies)
        self._turning = 1.0 if turning else 0.0
        self._damped, self._damping, self._needed = damped, 0.0, 0.0

    def converged(self) -> Reached:
        """The state under the loads at the end of the step.

        Raises
        ------
        SolverError
            If it was not found.
        """
        best: Reached | None = None
        for k in range(MAX_ITERATIONS):
            try:
                found = self._attempted(first=k == 0)
            except FecontactError:
                if best is None and self._settled is None:
                    raise
                break
            if found is not None and (found.residual <= TOLERANCE or self._known is not None):
                return found
            if best is not None and (found is None or found.residual > FALLS * best.residual):
                return best if found is None or best.residual <= found.residual else found
            best = found
            if best is None and k + 1 >= SETTLING and self._changes[-1] > RUNS_AWAY:
                break
        best = best or self._settled
        if best is not None:
            return best
        edges = self._edges()
        why = edges or self._violated or "the smallest load step was too large, or the body is not stable"
        raise SolverError(
            f"Newton's method found no equilibrium in {len(self._changes)} iterations (last change of displacements "
            f"{self._changes[-1]:.1e} of the size); {why}.",
            code=EDGES if edges else "no-equilibrium",
        )

    def _edges(self) -> str:
        """Which points go to and fro across edges of their partner, in words; empty where none do."""
        found = ""
        most = max(TURNED, SHARP * max(self._changes[-TO_AND_FRO:]))
        for before, now in pairwise(self._pressing[-TO_AND_FRO:]):
            for contact, (nodes, old), (others, new) in zip(self._model.contacts, before, now, strict=True):
                _, mine, its = np.intersect1d(nodes, others, return_indices=True)
                turns = np.linalg.norm(new[its] - old[mine], axis=1)
                if turns.max(initial=0.0) > most:
                    most, n = float(turns.max()), int((turns > TURNED).sum())
                    slave, master = (body.name for body in contact.bodies[:: -1 if contact.swap == "always" else 1])
                    found = (
                        f"points of {slave!r} ({n}) go to and fro across edges of faces of {master!r}, where their "
                        f"normals jump by {np.degrees(most):.0f} degrees: make this surface smooth, or its faces finer"
                    )
        return found

    def _attempted(self, first: bool) -> Reached | None:
        """An iteration, whose errors say whether smaller steps may help."""
        set_part(f"iteration {len(self._changes) + 1}" + (f", change {self._changes[-1]:.1e}" if self._changes else ""))
        try:
            return self._iteration(first)
        except SupportError as error:
            if first:
                raise
            raise SolverError(str(error), code="no-equilibrium") from error
        except (InvertedError, np.linalg.LinAlgError) as error:
            raise SolverError(str(error), code=getattr(error, "code", "singular")) from error
        except FecontactError as error:
            if error.code not in SMALLER:
                raise
            raise SolverError(str(error), code="no-equilibrium") from error

    @property
    def jumped(self) -> bool:
        """Whether bodies have gone to another equilibrium, as after a snap: far beyond the linear steps from both ends.

        Displacements that grow ever faster or ever slower with the load are between these.
        """
        every = zip(self._model.bodies, self._start.states, self._states, self._turned_poses, self._poses, strict=True)
        moved = max(
            float(np.abs(_points(body, then, p) - _points(body, now, q)).max())
            for body, then, now, p, q in every
            if then and now
        )
        moved /= self._size
        if self._known is not None or moved < max(BEGIN, JUMP * self._changes[0]):
            return False
        start = replace(
            self._start, model=self._model, step=self._end, states=tuple(self._states), poses=tuple(self._poses),
            hold=self._hold, displacements=tuple(self._elastic),
        )  # fmt: skip
        back = _Newton(self._settings, self._timer, start, self._start.step, None)
        with suppress(FecontactError):
            back._iteration(first=True)
        return moved > JUMP * max(back._changes, default=np.inf)

    def _iteration(self, first: bool) -> Reached | None:
        self._damping = max(self._damping / DAMPING_FALLS, self._needed)
        self._damping *= self._damping > MIN_DAMPING
        self._needed *= NEED_FALLS
        while True:
            with self._timer("linearise"):
                carried = self._linearised()
            try:
                result, hold = self._solved(carried.scene, self._loads(carried, first), self._turning)
                break
            except FecontactError as error:
                damping = max(FIRST_DAMPING, DAMPING_GROWS * self._damping)
                if error.code not in UNSTABLE or damping > MAX_DAMPING or not (self._damped or self._turning):
                    raise
                if self._damped:
                    self._damping = damping
                    self._needed = damping / DAMPING_GROWS
                else:
                    self._turning = 0.0
        if first:
            self._fix_sides(result)
        with self._timer("advance"):
            steps, change = self._steps(result)
            if self._damping:
                accelerated, motions = steps, list(result._state.motions)
            else:
                accelerated, motions = self._accelerated(steps, result._state.motions, change, hold)
            share = self._advance(result, accelerated, motions)
            if share < 1 and first:
                raise SolverError("The load step turns material inside out.", code=InvertedError.code)
            self._hold = hold
            self._changes.append(change / self._size)
            residual = self._residual(result)
        change = self._changes[-1]
        small = change <= TOLERANCE and residual <= BALANCED
        small |= residual <= TOLERANCE and max(self._changes[-2:]) <= NEARLY
        small &= not self._damping or residual <= TOLERANCE
        # where points open and close by rounding, neither falls any further
        settled = len(self._changes) > SETTLING and max(self._changes[-SETTLING:]) <= SETTLED and residual <= BALANCED
        if share < 1 or not (small or settled):
            return None
        self._damp(-self._damping)  # the stiffness of the answer is the tangent
        found = self._reached(result, residual)
        assert found.result is not None
        certificate = found.result.residuals()
        self._violated = f"its answer breaks the conditions of contact: {certificate}"
        if not certificate.within(BALANCED):
            return None
        if small or is_stable(found.result):
            return found
        self._settled = found
        return None

    def _linearised(self) -> CarriedScene:
        every = zip(self._model.bodies, self._bodies, self._states, self._poses, strict=True)
        # a linear body follows from itself in the last iteration, with what it has found of its compliance
        self._bodies = [posed(b, p) if s is None else given._linearised(s, p) for given, b, s, p in every]
        new = dict(zip(map(id, self._model.bodies), self._bodies, strict=True))
        self._damp(self._damping)
        for (body, name), pressure in self._end.pressures.items():
            for loaded in elastic_among([new[id(body)]]):
                constant = not callable(pressure) and np.ndim(pressure) == 0
                if self._following and constant and loaded._inner_forces is not None:
                    loaded._bend(following_stiffness(loaded._boundary_surface(name), float(cast(float, pressure))))
        return with_bodies(self._model, self._bodies)

    def _damp(self, share: float) -> None:
        """Add a share of the stiffness of the present shape at rest to the tangents."""
        for body in elastic_among(self._bodies) if share else ():
            if body._inner_forces is not None:
                K = body.model.unstressed().stiffness
                body._bend(share * (K + sp.triu(K, 1).T))

    def _loads(self, carried: CarriedScene, first: bool) -> Loading:
        """Loads with the internal forces; prescribed motions are taken in the first iteration."""
        motions = {
            body: {c: v if first and c not in TURNS else 0.0 for c, v in given.items()}
            for body, given in self._motions.items()
        }
        bodies = carried.scene.bodies
        loading = carried.step(replace(self._end, motions=motions)).on(bodies, self._model.bodies)
        loads = [
            given
            if (inner := body._inner_forces) is None
            else (np.zeros(body.n_dofs) if given is None else given) - inner
            for body, given in zip(bodies, loading.distributed, strict=True)
        ]
        return replace(loading, distributed=tuple(loads))

    def _turned(self, k: int, scene: SceneModel, interface: Interface) -> bool:
        """Whether normals of the slave have turned where contact k presses, since it was at rest."""
        nodes = self._hold.closed[k]
        if interface.slave._inner_forces is None:
            return True
        body = self._model.bodies[[each is interface.slave for each in scene.bodies].index(True)]
        rest = normals_of(with_nodes(body.surface(interface.surfaces[0]))).nodal[nodes]
        now = normals_of(interface.slave_surface).nodal[nodes]
        return bool(np.abs(now - rest).max(initial=0.0) > TURNED)

    def _solved(self, scene: SceneModel, loading: Loading, turning: float) -> tuple[ContactResult, Hold]:
        """Solution of the linear scene; where it needs held points, with those that stay closed."""
        past = self._slip_since(scene, loading) if scene.has_friction else None
        hold = self._hold if turning else replace(self._hold, turns=())
        interfaces = scene.interfaces(loading)
        if interfaces and not (scene.springs or any(len(each.gap) for each in interfaces)):
            raise SolverError(_not_facing(interfaces), code=APART)
        free = {frame.body for frame in loading.frames if frame.free[3:].any() and frame.body._inner_forces is None}
        self._pressing.append([_directions(*each, hold) for each in enumerate(interfaces)])
        for k, interface in enumerate(interfaces):
            turns = interface.master in free
            share = turning if turns or self._turned(k, scene, interface) else 0.0
            press(interface, interface.pairing.of_points(hold.pressing(k, interface.pairing.nodes)), share, turns)
        settings = self._settings
        for _ in range(MAX_HOLDS):
            try:
                result = solved(scene, loading, None, settings, self._timer, (), past, hold)
            except SolverError as error:
                if error.code != "not-certified" or settings.tolerance >= BALANCED:
                    raise
                settings = replace(settings, tolerance=TOLERANCE if settings.tolerance < TOLERANCE else BALANCED)
                continue
            found = _touching(result)
            needed = result._condensed.held_motions is not None
            if not needed or hold.within(found):
                return result, replace(found, at_once=needed)
            hold = replace(hold.common(found), at_once=True)
        raise SolverError("The points that are held open again and again.", code="indefinite")

    def _fix_sides(self, result: ContactResult) -> None:
        """Keep the slave and the coupling of each contact: what is held and slips is known by its nodes."""
        contacts = [
            replace(given, coupling=found.coupling, swap="always" if found._swapped else "never")
            for given, found in zip(self._model.contacts, result.contacts, strict=True)
        ]
        self._model = replace(self._model, contacts=contacts)

    def _slip_since(self, scene: SceneModel, loading: Loading) -> StepEnd:
        """The start of the step, from which the slip of its points counts."""
        since = {}
        begin, rest = self._start.states, self._start.displacements
        for body, state, first, linear in zip(scene.bodies, self._states, begin, rest, strict=True):
            if state is not None and first is not None:
                since[id(body)] = first.u - state.u
            elif linear is not None:
                since[id(body)] = linear
        last = None if self._start.result is None else self._start.result._step_end
        places, nodes, moved, pressed = [], [], [], []
        for k, (contact, interface) in enumerate(zip(scene.contacts, scene.interfaces(loading), strict=True)):
            if contact.mu > 0:
                own = interface.pairing.nodes
                by = TangentialRows(interface, k, contact.mu).relative_motion(since)
                places.append(np.full(len(own), k))
                nodes.append(own)
                moved.append(interface.pairing.unmixed(by @ interface.master.pose.rotation))
                pressed.append(np.zeros(len(own), bool) if last is None else last.of(k, last.pressed, own))
        return StepEnd(
            self._start.poses,
            chosen=[np.zeros(0, np.int64)] * len(scene.contacts),
            contact=np.concatenate(places),
            nodes=np.concatenate(nodes),
            displacement=np.concatenate(moved),
            pressed=np.concatenate(pressed),
            change=np.zeros(sum(map(len, nodes))),
        )

    def _steps(self, result: ContactResult) -> tuple[list[Array | None], float]:
        """Changes of the states, and the largest change of a displacement, of motions of bodies too."""
        steps: list[Array | None] = []
        largest = 0.0
        every = zip(
            result._loading.frames, result._state.displacements, result._state.motions, self._states, strict=True
        )
        for k, (frame, d, motion, state) in enumerate(every):
            elastic = d - frame.modes(motion[:, None])[:, 0]
            own = np.abs(d).max(initial=0.0)
            if state is None:
                before = self._elastic[k]
                own = np.abs(elastic if before is None else elastic - before).max(initial=0.0)
                own = max(
                    own, np.linalg.norm(motion[:3]), min(frame.body.size, self._size) * np.linalg.norm(motion[3:])
                )
                self._elastic[k] = elastic
            steps.append(None if state is None else elastic)
            largest = max(largest, float(own))
        return steps, largest

    def _accelerated(
        self, steps: Sequence[Array | None], motions: Sequence[Array], change: float, hold: Hold
    ) -> tuple[list[Array | None], list[Array]]:
        """The steps and motions, or better ones by earlier iterations where convergence is linear."""
        lengths = np.repeat([1.0, self._size], 3)
        turned = [motion * lengths for motion in motions]
        x = np.concatenate([*(s.u for s in self._states if s is not None), *self._way])
        r = np.concatenate([*(d for d in steps if d is not None), *turned])
        out, past = list(steps), self._past[-DEPTH:]
        self._past.append((x, r))
        relative = change / self._size
        slow = len(self._changes) > 2 and relative > SLOW * self._changes[-1] and hold.same(self._hold)
        if slow and relative <= BEGIN and past:
            dx, dr = (np.array([now - old[k] for old in past]).T for k, now in enumerate((x, r)))
            mix = np.linalg.lstsq(dr, r, rcond=1e-10)[0]
            better, start = r - (dx + dr) @ mix, 0
            for k, d in enumerate(steps):
                if d is not None:
                    out[k] = better[start : start + len(d)]
                    start += len(d)
            turned = list(better[start:].reshape(-1, 6))
        self._way = [before + motion for before, motion in zip(self._way, turned, strict=True)]
        return out, [motion / lengths for motion in turned]

    def _advance(self, result: ContactResult, steps: Sequence[Array | None], motions: Sequence[Array]) -> float:
        """Take a step, or the share of it that keeps cells upright; poses follow a whole one."""
        share = 1.0
        while True:
            try:
                trial = [self._moved(k, d, share) for k, d in enumerate(steps)]
                break
            except InvertedError:
                share /= 2
                if share < MIN_SHARE:
                    raise
        self._states = [None if t is None else t[0] for t in trial]
        self._forces = [None if t is None else t[1] for t in trial]
        if share == 1:
            frames = zip(self._poses, motions, result._loading.frames, strict=True)
            self._poses = [turned(pose, motion, frame.point) for pose, motion, frame in frames]
        return share

    def _moved(self, k: int, d: Array | None, share: float) -> tuple[State, Array] | None:
        """State and internal forces of body k after a share of a step."""
        cells, state = self._model.bodies[k]._finite_strain, self._states[k]
        if d is None or state is None or cells is None:
            return None
        moved = cells.advanced(state, d, share)
        return moved, cells.at(moved, tangent=False).forces

    def _residual(self, result: ContactResult) -> float:
        """Largest unbalanced force on a node of a body at finite strain, relative to the largest force inside it."""
        forces = (result.friction or result.solution).forces
        pairs = zip(result._condensed.parts, self._forces, strict=True)
        return max(unbalanced(part, forces, inner) for part, inner in pairs)

    def _reached(self, result: ContactResult, residual: float) -> Reached:
        states = self._states
        scale = max(float(np.abs(s.u).max()) for s in states if s is not None)
        scale = max(scale, result._state.scale)
        result = replace(result, _state=replace(result._state, scale=scale))
        equilibria = (*self._start.equilibria, Equilibrium(len(self._changes), self._changes[-1], residual))
        if self._known is not None:
            equilibria = tuple(Equilibrium(**each) for each in self._known["equilibria"])
        return Reached(
            self._model, self._end, tuple(states), tuple(self._poses), self._hold, tuple(self._elastic),
            result, equilibria,
        )  # fmt: skip


def _directions(k: int, interface: Interface, hold: Hold) -> tuple[IntArray, Array]:
    """Slave nodes of the points of contact k that are closed, and the directions (n, 3) in which the master pushes."""
    pairing = interface.pairing
    of = np.isin(pairing.nodes, hold.closed[k])
    return pairing.nodes[of], (pairing.average[of] @ pairing.slave_normals) @ interface.slave.pose.rotation.T


def _not_facing(interfaces: Sequence[Interface]) -> str:
    """Why a scene has no point that may touch."""
    pairs = [
        f"{each.surfaces[0]!r} of {each.slave.name!r} and {each.surfaces[1]!r} of {each.master.name!r}"
        for each in interfaces
    ]
    return (
        f"No surfaces face each other any more: {', '.join(pairs)} slid off each other or turned away. Move the bodies "
        "less, make the surface of one larger, or hold the bodies together by a spring."
    )


def _turned(body: Body, pose: Pose, motions: Mapping[Body, Mapping[str, float]]) -> Pose:
    """The pose after the prescribed rotations."""
    turn = [motions.get(body, {}).get(c, 0.0) for c in TURNS]
    return turned(pose, np.array([0.0, 0.0, 0.0, *turn]), pose.to_world(body.reference_point)) if any(turn) else pose


def _points(body: Body, state: State, pose: Pose) -> Array:
    """Points (n, 3) of the mesh of a body at a state, in world axes."""
    (meshed,) = elastic_among([body])
    return pose.to_world(meshed.mesh.points + meshed.model.at_points(state.u))


def motions_between(start: LoadStep, end: LoadStep, whole: bool) -> dict[Body, dict[str, float]]:
    """Changes of the prescribed motions from one step to the next, or zero ones; rotation vectors compose.

    What only the first prescribes goes back, where the second has no load on it.
    """
    out = {}
    for body in {**start.motions, **end.motions}:
        one, other = start.motions.get(body, {}), end.motions.get(body, {})
        names = [*other, *(c for c in one if c not in other and c not in _released(end, body))]
        change = {c: other.get(c, 0.0) - one.get(c, 0.0) for c in names}
        if {*one, *other} & set(TURNS):
            after, before = (Rotation.from_rotvec([m.get(c, 0.0) for c in TURNS]) for m in (other, one))
            change |= {c: t for c, t in zip(TURNS, (after * before.inv()).as_rotvec(), strict=True) if c in names}
        out[body] = change if whole else dict.fromkeys(names, 0.0)
    return out


def _released(step: LoadStep, body: Body) -> set[str]:
    """Components in which a load drives a body as a whole, or in which it is free."""
    free = step.free.get(body, ())
    force = sum((np.asarray(f, float) for at, f in step.forces.items() if at is body), np.zeros(3))
    load = np.concatenate([force, np.asarray(step.moments.get(body, np.zeros(3)), float)])
    return {*(free.split() if isinstance(free, str) else free), *np.array(COMPONENTS)[load != 0].tolist()}


def _touching(result: ContactResult) -> Hold:
    """Slave nodes of the closed points of each contact, and of those that stick: of the solver's points.

    Points that share means with others, as at a rim, may bear force where the solver's are open.
    """
    closed, stuck, forces = [], [], []
    first = start = 0
    turns = [np.zeros((3, 3)) for _ in result._loading.frames]
    for fields, interface in zip(result.contacts, result._interfaces, strict=True):
        nodes = interface.pairing.nodes[fields._candidates]
        pressing = result.solution.forces[first : first + len(nodes)]
        first, sticks = first + len(nodes), np.zeros(len(nodes), bool)
        if fields.friction is not None and result.friction is not None:
            here = slice(start, start + len(nodes))
            sticks, start = result.friction.touching[here] & ~result.friction.sliding[here], start + len(nodes)
        closed.append(nodes[pressing > 0])
        stuck.append(nodes[sticks])
        forces.append(np.where(sticks, 0.0, pressing)[pressing > 0])
        if fields.friction is None or not sticks.any():
            continue
        at = fields._candidates[sticks]
        on_slave = fields.forces[at, None] * fields.normals[at] + fields.friction.forces[at]
        for k, frame in enumerate(result._loading.frames):
            sign = (frame.body is interface.slave) - 1.0 * (frame.body is interface.master)
            if sign and frame.free[3:].any() and frame.body._inner_forces is None:
                turns[k] += turning_with(fields.points[at] - frame.point, sign * on_slave)
    return Hold(closed, stuck, forces=forces, turns=turns)
