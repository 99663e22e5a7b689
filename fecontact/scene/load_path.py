"""Load paths: a sequence of load steps with friction, whose answer depends on their order.

Slip of a step is counted from the end of the step before, so that what sticks keeps its displacement. A step without
certified solution is cut in halves, with loads and motions in between. A step with the loads of the last one has its
solution, without slip: it is certified, not solved.

In a file a path has a row of JSON for each step, from which an interrupted one goes on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import elastic_among
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import file_path, instance, items, spelled
from fecontact.common.arrays import ROUNDING, Array
from fecontact.common.checks import number_array, positive, share, whole
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, SolverError
from fecontact.common.fingerprint import fingerprint
from fecontact.common.path import Path, Steps, follow
from fecontact.common.renamed import renamed
from fecontact.common.stopwatch import Stopwatch
from fecontact.common.table import Column, Table
from fecontact.common.units import UnitNames, refuse_units
from fecontact.contact.contact import Contact
from fecontact.contact.loads import LOADS, LoadStep
from fecontact.contact.model import SceneModel
from fecontact.contact.step_end import StepEnd, at_nodes
from fecontact.fem.rigid import COMPONENTS
from fecontact.results.case_table import CaseTable, fields_to_keep, kept_of, plane_of, row_of
from fecontact.results.files import save_series
from fecontact.results.friction_fields import with_parts
from fecontact.results.result import ContactResult
from fecontact.results.resultants import DividingPlane, resultant
from fecontact.scene.adaptive import Target, solve_to_accuracy
from fecontact.scene.carried import CarriedScene
from fecontact.scene.finite_rotation import carried_poses, check_rest, solve_finite
from fecontact.scene.finite_strain import Reached, at_rest, is_nonlinear, next_reached
from fecontact.scene.linear import Settings, solved
from fecontact.scene.solve import refuse_limits_alone
from fecontact.scene.sweep_case import fingerprints, loads_of, numbered
from fecontact.scene.wear import WornSteps, checked
from fecontact.solvers import TOLERANCE


@compact_repr
@dataclass(frozen=True, eq=False)
class LoadPath(Path[ContactResult]):
    """Results of a scene at the ends of the steps of a load path.

    Attributes
    ----------
    steps : tuple of ContactResult
        At the end of every step given.
    cuts : tuple of int
        Parts in which every step was solved.
    loads : tuple of dict
        Loads at the end of every step by name, see `scene.sweep_case`.
    """

    loads: tuple[Mapping[str, float], ...] = field(repr=False)

    dissipated = renamed("dissipated", "friction_work")

    @cached_property
    def friction_work(self) -> Array:
        """Work of friction (n_steps, n_contacts) during every step; zero for contacts without friction."""
        return np.array([[c.friction.friction_work if c.friction else 0.0 for c in r.contacts] for r in self.steps])

    @cached_property
    def forces(self) -> Array:
        """Forces (n_steps, n_contacts, 3) on the first body of each contact, friction included."""
        return np.array([[resultant(c)[0] for c in result.contacts] for result in self.steps])

    @cached_property
    def figures(self) -> Mapping[str, Array]:
        """Columns (n_steps,) of numbers by name, see `CaseTable.figures`."""
        return self.table().figures

    def rows(self) -> Sequence[Mapping[str, Any]]:
        """Rows of the table of the steps."""
        return self.table().rows

    @cached_property
    def worn_volume(self) -> Array:
        """Volume (n_steps, n_contacts) worn off by the ends of the steps; zero without wear."""
        return np.array([[c.worn_volume for c in result.contacts] for result in self.steps])

    def motions(self, body: Body) -> Array:
        """Rigid motions (n_steps, 6) of a body's frame: translations and rotation vectors."""
        found = [result.rigid_motion(body) for result in self.steps]
        return np.array([np.concatenate([m.translation, m.rotation]) for m in found])

    def wear_depth(self, contact: int, coefficient: float) -> Array:
        """Wear depth (n,) at the points of a contact by Archard's law, h = k int p |ds|.

        Parameters
        ----------
        contact : int
            Number of the contact in the scene.
        coefficient : float
            Archard's k: volume per force and distance, one over pressure. The work of friction by area is mu times the
            integral. Every step, or part of a step that was cut, counts with the chord of its path.

        Returns
        -------
        (n,) array
            At the points of the last step.
        """
        positive("the coefficient of wear", coefficient)
        whole("the number of the contact", contact, 0, len(self.steps[0].contacts) - 1)
        found = [
            (result.contacts[contact].friction, result._interfaces[contact].pairing.nodes) for result in self.steps
        ]
        if self.last.contacts[contact].worn is not None:
            raise InputError(
                f"Contact {contact} of this path has worn: its depth is contacts[{contact}].worn.", code="worn-already"
            )
        if any(f is None or np.isinf(f.mu).any() for f, _ in found):
            raise InputError(f"Contact {contact} has no finite friction: Archard's law needs its work.")
        last = found[-1][1]
        return coefficient * np.sum([at_nodes(f.sliding_integral, own, last) for f, own in found if f], axis=0)

    def table(
        self,
        times: Sequence[float] | None = None,
        *,
        keep: str | Sequence[str] = (),
        split: DividingPlane | tuple[ArrayLike, ArrayLike] | None = None,
    ) -> CaseTable:
        """Figures of all steps, a row for each, to print, draw and save.

        Parameters
        ----------
        times : sequence of float, optional
            Time of each step, for a column.
        keep, split
            Fields for maps, and a plane that divides contacts, as in `Scene.sweep`.

        Raises
        ------
        InputError
            If there are other numbers of times than steps, or a field or a plane is none.
        """
        first = self.steps[0]
        bodies = [result._unrefined or result._originals or result.scene.bodies for result in self.steps]
        fields, plane = fields_to_keep(keep, first.scene), plane_of(split, bodies[0])
        given: list[dict[str, float]] = [{} for _ in self.steps]
        if times is not None:
            given = [{"time": float(t)} for t in number_array("the times of the steps", times).ravel()]
            if len(given) != len(self):
                raise InputError(f"There are {len(self)} steps and {len(given)} times.", code="times-differ")
        rows = []
        for k, result in enumerate(self.steps):
            row = row_of(result, plane, bodies[k])
            rows.append({"name": f"step {k + 1}", **row, "parameters": given[k], "loads": dict(self.loads[k])})
        names = tuple((c.slave.name, c.master.name) for c in first.scene.contacts)
        maps = tuple(kept_of(result, fields) for result in self.steps)
        return CaseTable(tuple(rows), names, first.scene.unit_names, maps)

    def save(self, path: str | FilePath, times: Sequence[float] | None = None, *, units: UnitNames = ()) -> FilePath:
        """Write the path; the suffix decides: .pvd with a .vtu for each step, or as `CaseTable.save`.

        Parameters
        ----------
        path : str or Path
        times : sequence of float, optional
            Time of each step; in a .pvd their numbers from 0 unless given.
        units
            As for `CaseTable.save`.

        Raises
        ------
        InputError
            For another suffix, a file that cannot be written, or another number of times than of steps.
        """
        if file_path("the path of a load path", path).suffix.lower() != ".pvd":
            return self.table(times).save(path, units=units)
        refuse_units(".pvd", units)
        return save_series(self.steps, path, None if times is None else number_array("the times", times).tolist())

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()

    def __str__(self) -> str:
        names = ("normal", "friction", "stick area", "slip area", "work")
        columns = [Column("step"), *(Column(name, ".5g") for name in names)]
        rows = [
            (k, c.total_force, float(np.linalg.norm(f.force)), c.stick_area, c.slip_area, f.friction_work)
            for k, result in enumerate(self.steps, start=1)
            for c in result.contacts
            if (f := c.friction) is not None
        ]
        return str(Table(columns, rows))


#: Excess of the path of a point over its chord from which a step is cut: a turn on the spot by 0.22 rad.
CURVED = 2e-3
#: Change of a prescribed rotation (radians) from which a step is cut at once: poses do not tell whole turns.
MAX_TURN = 3.0
#: Friction of points pressed anew by a step, over the limit of all points, from which the step is solved in halves too.
MUCH_ANEW = 0.05
#: Error of friction over its change by steps of half the size: 2 for errors of the first order, and 1.0 to 1.9 where
#: rollers were pressed in 1 to 10 steps.
ERROR_OVER_CHANGE = 1.5
#: Advice where even the parts of a cut step turn too far.
SMALLER = "Give smaller load steps."


@spelled
def solve_path(
    model: SceneModel,
    steps: Sequence[Mapping[str, Any]],
    path: str | FilePath | None = None,
    *,
    finite_motion: bool = False,
    accuracy: float | Mapping[str, float] | None = None,
    max_dofs: int | None = None,
    max_seconds: float | None = None,
    tolerance: float = TOLERANCE,
    progress: bool | None = None,
    wear: Mapping[Contact, float] | None = None,
) -> LoadPath:
    """Solve load steps one after the other, with the slip and stick of each carried to the next.

    Parameters
    ----------
    model : SceneModel
        The scene; as its method `Scene.solve_path`, the scene itself.
    steps : sequence of mappings
        Loads at the end of each step, as arguments of `Scene.solve`: ``forces``, ``moments``, ``motions``, ``free``,
        ``pressures``, ``tractions``, ``gravity``. They are totals, not increments: what a step leaves out is zero
        at its end. A body is free, loaded or moved in the same components in all steps, or its change from one to the
        other is part of the step. ``scene``, of the same bodies and contacts in the same order, with other supports
        or coefficients of friction, takes the place of the scene in a step, whose loads are on its bodies: from its
        beginning nothing holds what its supports do not.
    path : str or Path, optional
        File of JSON lines, a row per step, written as steps are done: figures of the result and what the next step
        goes on from. Steps already in it are not solved again but rebuilt from their forces and certified, so that an
        interrupted path goes on where it stopped. A row of another model, step or history is refused.
    finite_motion : bool
        Whether rigid motions are finite: poses are updated in every step until they converge, prescribed motions are
        finite (rotation vectors, from the given poses), and slip is counted on surfaces that move along. By default
        motions are small; with laws of finite strain they are always finite.
    accuracy : float or mapping of str to float, optional
        Relative error of the contact pressure and of the tractions of friction (L2) at the end of the path, such as
        0.02: the path is solved, meshes are divided where its last step needs it, and it is solved again, until the
        estimated errors are within it; by name as in `Scene.solve`. Fields belong to the divided bodies,
        ``path[k].solved(body)``; ``path[-1].convergence`` has the rounds. Not together with a file.
    max_dofs, max_seconds : int and float, optional
        Limits of the way there, as in `Scene.solve`.
    tolerance : float
        Of the certificate of every step, see `solvers.Residuals`.
    progress : bool, optional
        Whether to show the steps on standard error; by default where that is a terminal.
    wear : mapping of Contact to float, optional
        Archard's coefficients k, volume per force and length of slip: the body that a contact names first wears by k p
        |ds| where it slips, without friction too, and the next step begins with the worn shape, see `common.wear`. A
        step may then have ``cycles``: how often it is passed, in a load cycle that goes on, from the end of the step
        before; a passage is one way, the way back a step of its own. ``path[k].contacts[i].worn`` is the depth. Steps
        are cut until the error of the depth is 1 %. Not together with a file, an accuracy or laws of finite strain.

    Returns
    -------
    LoadPath

    Raises
    ------
    InputError, SupportError, SolverError
        The message has the number of the step.

    Examples
    --------
    A block on a floor is pressed, then dragged and released:

    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> scene = fc.Scene([block, floor], [fc.Contact(block, floor, friction=0.3)])
    >>> path = scene.solve_path([{"motions": {block: {"z": -0.01, "x": x}}} for x in (0.0, 0.02, 0.0)])
    >>> path.forces[:, 0, 0].round(9).tolist()
    [0.0, -0.003, 0.003]
    """
    steps = [instance("each of the steps", step, Mapping) for step in items("the steps", steps, "steps")]
    if not steps:
        raise InputError("A load path needs at least one step.", code="no-steps")
    for k, step in enumerate(steps):
        known = (*LOADS, "scene") if wear is None else (*LOADS, "scene", "cycles")
        if unknown := sorted(map(str, set(step) - set(known))):
            raise InputError(f"Step {k + 1} has {', '.join(map(repr, unknown))}; expected {', '.join(known)}.")
    if finite_motion not in (True, False):
        raise InputError(f"finite_motion of a load path must be True or False; found {finite_motion!r}.", code="motion")
    soft = is_nonlinear(model)
    if soft and accuracy is not None:
        raise InputError(
            f"accuracy={accuracy!r} is not offered for paths of bodies with a law of finite strain, whose "
            "states are of one mesh: leave it out, or give it to Scene.solve for each load.",
            code="finite-strain",
        )
    scenes = [step.get("scene", model) for step in steps]
    if own := [k for k, scene in enumerate(scenes, start=1) if scene is not model]:
        _check_alike(model, scenes)
        if soft or accuracy is not None or wear is not None:
            raise InputError(
                f"Step {own[0]} has a scene of its own, which is not offered with accuracy=, wear or laws of finite "
                "strain.",
                code="scene-of-step",
            )
    if not (any(scene.has_friction for scene in scenes) or soft or wear is not None):
        raise InputError("No contact has friction: the order of loads does not matter; use Scene.solve or Scene.sweep.")
    share("the tolerance", tolerance)
    loads = [LoadStep.of({name: load for name, load in step.items() if name != "scene"}) for step in steps]
    way = SceneSteps(model, loads, finite_motion, tolerance, scenes if own else ())
    refuse_limits_alone(accuracy, max_dofs, max_seconds)
    if wear is not None:
        others = {"path=": path is not None, "accuracy=": accuracy is not None, "laws of finite strain": soft}
        coefficients, cycles = checked(model, wear, [step.get("cycles") for step in steps], others)
        first = [replace(c, swap="never") if i in coefficients else c for i, c in enumerate(model.contacts)]
        worn = WornSteps(replace(way, model=replace(model, contacts=first)), coefficients, cycles)
        found, cuts = follow(worn, len(steps), None, progress)
        return LoadPath(tuple(each.result for each in found), cuts, tuple(loads_of(vars(s)) for s in way.steps))
    if soft:
        return _SoftSteps(way).path(path, progress)
    if accuracy is None:
        return way.path(path, progress)
    if path is not None:
        raise InputError("A path that is solved to an accuracy has no file: its rows would be of changing meshes.")
    return _path_to(way, Target(accuracy, max_dofs, max_seconds), progress)


@dataclass(frozen=True, eq=False)
class SceneSteps(Steps[ContactResult]):
    """Load steps of a scene, and how they are solved."""

    model: SceneModel
    steps: Sequence[LoadStep]
    finite_motion: bool
    tolerance: float
    scenes: Sequence[SceneModel] = ()

    def at(self, k: int) -> SceneSteps:
        """The same with the scene of step k."""
        return replace(self, model=self.scenes[k]) if self.scenes else self

    def is_new(self, k: int) -> bool:
        """Whether step k has another scene than the one before."""
        return bool(self.scenes) and k > 0 and self.scenes[k] is not self.scenes[k - 1]

    def halvings(self, k: int, before: ContactResult | None) -> int:
        """None where supports change: halfway they are neither."""
        return 0 if self.is_new(k) else super().halvings(k, before)

    def path(self, file: str | FilePath | None, progress: bool | None) -> LoadPath:
        """The path on the meshes given."""
        return LoadPath(*follow(self, len(self.steps), file, progress), tuple(loads_of(vars(s)) for s in self.steps))

    def loads(self, k: int, share: float) -> LoadStep:
        """Loads a share of the way through step k."""
        before = self.steps[k - 1] if k else LoadStep()
        if self.is_new(k):
            # of what supports were, only motions tell where poses begin
            before = CarriedScene(self.scenes[k], tuple(self.scenes[k - 1].bodies)).step(before)
            before = replace(before, displacements={})
        return before.between(self.steps[k], share)

    def prints(self) -> Mapping[str, Mapping[str, str]]:
        """Fingerprints by part of each step by its number."""
        settings = {"finite_motion": self.finite_motion, "tolerance": self.tolerance}
        steps = {str(k): {**vars(step), **settings} for k, step in enumerate(self.steps, 1)}
        if not self.scenes:
            return fingerprints(self.model, steps)
        each = zip(self.scenes, steps.items(), strict=True)
        return {k: fingerprints(scene, {k: step})[k] for scene, (k, step) in each}

    def row(self, result: ContactResult) -> Mapping[str, Any]:
        """The summary."""
        return result.summary()

    def end(self, part: ContactResult) -> StepEnd:
        """What the next step begins from."""
        assert part._step_end is not None
        return part._step_end

    def solved(self, step: LoadStep, past: StepEnd | None, poses: Sequence[Pose]) -> ContactResult:
        """Result of a step or a part of it; poses, if finite, are sought from those given."""
        settings, model = Settings(tolerance=self.tolerance), self.model
        if self.finite_motion:
            return solve_finite(model, step, settings, Stopwatch(), poses, past)
        return check_rest(solved(model, step.on(model.bodies), None, settings, Stopwatch(), (), past))

    def coupled_as(self, result: ContactResult) -> SceneSteps:
        """The same with the contacts coupled as in a result: by the same sides and points."""
        contacts = [
            replace(
                contact,
                swap="never" if interface.slave is own.slave else "always",
                coupling=interface.pairing.coupling,
            )
            for contact, own, interface in zip(
                self.model.contacts, result.scene.contacts, result._interfaces, strict=True
            )
        ]
        return replace(self, model=replace(self.model, contacts=contacts))

    def following(
        self, step: LoadStep, past: StepEnd | None, poses: Sequence[Pose], last: ContactResult | None
    ) -> ContactResult:
        """Result of a step after the last result, with the same coupling.

        Raises
        ------
        SolverError
            Also where it is solved, but points turn too far.
        """
        found = self.solved(step, past, poses)
        if last is not None and _coupling(found) != _coupling(last):
            # loads may suggest another coupling, whose points have no past
            found = self.coupled_as(last).solved(step, past, poses)
        detour = max((c.friction.detour for c in found.contacts if c.friction is not None), default=0.0)
        if detour > CURVED:
            raise SolverError(f"Points slide along paths that are {detour:.1%} longer than their chords. {SMALLER}")
        return found

    def part(
        self, k: int, before: ContactResult | None, start: float, end: float, last: ContactResult | None,
        known: Any = None,
    ) -> ContactResult:  # fmt: skip
        """Result of a part of step k.

        Raises
        ------
        SolverError
            Also where it is solved, but points or bodies turn too far.
        """
        first, then, self = self.loads(k, start), self.loads(k, end), self.at(k)
        if last is not None and not self.is_new(k) and _same(self.model, first, then):
            return unchanged(last, self.tolerance)
        if self.finite_motion and not self.model.twists and _largest_turn(first, then) > MAX_TURN:
            raise SolverError(f"A body turns by more than {MAX_TURN:g} rad. {SMALLER}")
        # the frictionless solution is a better start than the forces of the last step
        past = None if last is None else replace(self.end(last), forces=np.zeros(0))
        poses: Sequence[Pose] = () if past is None else carried_poses(self.model, first, then, past.poses)
        kept = None if known is None else StepEnd.read(known)
        if kept is not None:
            past = past or StepEnd(tuple(body.pose for body in self.model.bodies))
            past, poses = replace(past, chosen=kept.chosen, forces=kept.forces, q=kept.q), kept.poses
        found = self.following(then, past, poses, last)
        change = self.end(found).change if kept is None else kept.change
        return replace(found, _follows_step=True, _step_end=replace(self.end(found), change=change))

    def joined(self, parts: Sequence[ContactResult]) -> ContactResult:
        """The last part of a step, with the work and the sliding of those before it."""
        return _joined(parts)

    def judged(self, k: int, result: ContactResult, last: ContactResult | None, cuts: int) -> ContactResult:
        """The result with the change of its friction by smaller steps; of steps before it that stays at what sticks."""
        end = self.end(result)
        if last is not None and end is last._step_end:
            return result
        halved = self._halved(k, result, last) if cuts == 1 and not self.is_new(k) else None
        change = np.zeros(len(end.nodes))
        for i, contact in enumerate(result.contacts):
            if (friction := contact.friction) is None:
                continue
            own = end.contact == i
            if last is not None:
                change[own] = self.end(last).of(i, self.end(last).change, end.nodes[own]) * friction.sticking
            if halved is not None and (other := halved.contacts[i].friction) is not None:
                forces = at_nodes(other.forces, halved._interfaces[i].pairing.nodes, end.nodes[own])
                size = np.linalg.norm(friction.forces - forces, axis=1)
                change[own] = np.hypot(change[own], ERROR_OVER_CHANGE * size)
        return replace(result, _step_end=replace(end, change=change))

    def _halved(self, k: int, found: ContactResult, last: ContactResult | None) -> ContactResult | None:
        """The result of step k in two halves; None where points that it presses anew carry little friction.

        Such points slip from where the step begins, and not from where they touch. What sticks is off by the
        displacement before that: with steps of half the size by about half of it.
        """
        start = self.end(found if last is None else last)
        if last is None:
            poses, n = tuple(b.pose for b in self.model.bodies), len(start.nodes)
            start = replace(start, poses=poses, displacement=np.zeros((n, 3)), pressed=np.zeros(n, bool))
        if not any(_presses_anew(found, i, start, self.finite_motion) for i in np.unique(self.end(found).contact)):
            return None
        same = self.at(k).coupled_as(found)
        try:
            for share in (0.0, 0.5):
                before, after = self.loads(k, share), self.loads(k, share + 0.5)
                start = replace(start, forces=np.zeros(0))
                result = same.solved(after, start, carried_poses(same.model, before, after, start.poses))
                start = self.end(result)
        except SolverError:
            return None
        return result


def _check_alike(model: SceneModel, scenes: Sequence[Any]) -> None:
    """Refuse scenes of steps with other bodies or contacts than those of a scene.

    Raises
    ------
    InputError
    """

    def what(scene: SceneModel) -> Any:
        points = [len(b.mesh.points) for b in elastic_among(scene.bodies)]
        contacts = [(c.slave.name, c.master.name, c.surfaces, c.mu > 0) for c in scene.contacts]
        return [b.name for b in scene.bodies], points, contacts, len(scene.springs)

    for k, scene in enumerate(scenes, start=1):
        if what(instance(f"the scene of step {k}", scene, SceneModel)) != what(model):
            raise InputError(
                f"The scene of step {k} has other bodies, contacts or springs; what steps may change are supports and "
                "how large friction is.",
                code="scene-of-step",
            )


def _joined(parts: Sequence[ContactResult]) -> ContactResult:
    """The last of some parts of a step, with the work and the sliding of those before it."""
    if len(parts) == 1:
        return parts[0]
    *others, last = parts
    contacts = [
        c
        if c.friction is None
        else replace(
            c,
            friction=with_parts(
                c.friction,
                last._interfaces[k].pairing.nodes,
                [(f, p._interfaces[k].pairing.nodes) for p in others if (f := p.contacts[k].friction) is not None],
            ),
        )
        for k, c in enumerate(last.contacts)
    ]
    return replace(last, contacts=tuple(contacts))


@dataclass(frozen=True, eq=False)
class _SoftSteps(Steps[Reached]):
    """The same with laws of finite strain: every part goes on from the state of the last one."""

    way: SceneSteps

    def path(self, file: str | FilePath | None, progress: bool | None) -> LoadPath:
        """The path."""
        found, cuts = follow(self, len(self.way.steps), file, progress)
        results = [replace(each.result_of(self.way.model.bodies), _follows_step=True) for each in found]
        return LoadPath(tuple(results), cuts, tuple(loads_of(vars(step)) for step in self.way.steps))

    def prints(self) -> Mapping[str, Mapping[str, str]]:
        """Fingerprints by part of each step by its number."""
        return self.way.prints()

    def row(self, result: Reached) -> Mapping[str, Any]:
        """The summary."""
        return result.result_of(self.way.model.bodies).summary()

    def end(self, part: Reached) -> Mapping[str, Any]:
        """The state."""
        return part.kept

    def part(
        self, k: int, before: Reached | None, start: float, end: float, last: Reached | None, known: Any = None
    ) -> Reached:
        """State after a part of step k."""
        last = last or at_rest(self.way.model, self.way.steps[0])
        for body in () if last.result is None else last.result._elastic_bodies:
            if body._inner_forces is not None:
                body.model.condensation = None  # a factor for each state would fill the memory
        if start == 0:
            last = replace(last, equilibria=())
        return next_reached(
            last, self.way.loads(k, end), (start, end), Settings(tolerance=self.way.tolerance), Stopwatch(), known
        )

    def joined(self, parts: Sequence[Reached]) -> Reached:
        """The last part of a step, with the work and the sliding of those before it."""
        return replace(parts[-1], result=_joined([part.result for part in parts if part.result is not None]))


def _path_to(way: SceneSteps, target: Target, progress: bool | None) -> LoadPath:
    """The path on meshes divided until the pressure of its last step is within a target."""
    originals = tuple(way.model.bodies)
    rounds: list[LoadPath] = []

    def solve(model: SceneModel, *_: object) -> ContactResult:
        carried = CarriedScene(model, originals)
        rounds.append(replace(way, model=model, steps=[carried.step(step) for step in way.steps]).path(None, progress))
        return rounds[-1].last

    last = solve_to_accuracy(way.model, LoadStep(), target, solve)
    results = [replace(result, _unrefined=originals) for result in rounds[-1].steps[:-1]]
    return replace(rounds[-1], steps=(*results, last))


def _presses_anew(found: ContactResult, number: int, before: StepEnd, finite: bool) -> bool:
    """Whether points that were open, beyond rounding, carry friction above a share of the limit of all points."""
    interface, contact = found._interfaces[number], found.contacts[number]
    friction = contact.friction
    assert friction is not None
    anew = friction.touching & ~before.of(number, before.pressed, interface.pairing.nodes)
    if not finite:  # gaps are those before the step
        anew &= interface.gap > ROUNDING * interface.slave.size
    root, mu = np.sqrt(friction.weights), np.where(np.isfinite(friction.mu_along_slip), friction.mu_along_slip, 1.0)
    tangential, limit = np.linalg.norm(friction.forces, axis=1) / root, mu * contact.forces / root
    return bool(np.linalg.norm(tangential[anew]) > MUCH_ANEW * np.linalg.norm(limit))


def _same(model: SceneModel, before: LoadStep, after: LoadStep) -> bool:
    """Whether two steps have the same loads."""
    one, other = (fingerprint(numbered(vars(loads), model.bodies)) for loads in (before, after))
    return one == other


def unchanged(result: ContactResult, tolerance: float) -> ContactResult:
    """Result of a further step under the same loads: the same forces and displacements, and no slip, certified.

    Slip is counted from the end of the step, at which the points are already.

    Raises
    ------
    SolverError
        If the certificate does not hold.
    """
    solution = result.friction
    assert solution is not None
    problem = solution.problem
    g = problem.g.copy()
    g[problem.tangents] -= solution.slip
    solution = replace(solution, problem=replace(problem, g=g), nit=0, seconds=0.0, history=())
    if not solution.residuals.within(tolerance):
        raise SolverError(f"The step before is not certified under the same loads: {solution.residuals}.")
    still = [
        c
        if c.friction is None
        else replace(c, friction=replace(c.friction, slip=np.zeros_like(c.friction.slip), earlier=None))
        for c in result.contacts
    ]
    return replace(result, contacts=tuple(still), solution=solution.normal, friction=solution)


def _largest_turn(given: LoadStep, step: LoadStep) -> float:
    """Largest change (radians) of a prescribed rotation vector from one step to the next."""
    one, other = given.motions, step.motions
    turns = [
        np.linalg.norm([other.get(b, {}).get(c, 0.0) - one.get(b, {}).get(c, 0.0) for c in COMPONENTS[3:]])
        for b in {**one, **other}
    ]
    return float(max(turns, default=0.0))


def _coupling(result: ContactResult) -> list[tuple[str, str]]:
    """Slave and coupling of each contact."""
    return [(interface.slave.name, interface.pairing.coupling) for interface in result._interfaces]
