"""Motion in time: steps of a scheme, balance of energy and momentum, and a resumable record."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from tqdm import tqdm

from fecontact.ancf.system.assembly import Assembly
from fecontact.ancf.system.contact_result import WithContacts
from fecontact.ancf.system.moving_contact import NEAR, ContactConstraints
from fecontact.ancf.system.schemes import RATE, GeneralisedAlpha, Instant, Scheme, acting
from fecontact.ancf.system.stage import Stage, StageAt, Start, rate
from fecontact.ancf.system.statics import State
from fecontact.ancf.system.tangent import UnstableError
from fecontact.common.arrays import Array
from fecontact.common.checks import lengths
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, SolverError
from fecontact.common.files import check_writable, replacing
from fecontact.common.fingerprint import fingerprint
from fecontact.common.renamed import renamed
from fecontact.fem.laws import InvertedError
from fecontact.solvers.coulomb import Residuals

#: Halvings of the step, less the steps made since, after which the motion stops.
MAX_HALVINGS = 12
#: Share of the step given below which steps are short, of steps that adapt to an accuracy too, and how many in a row
#: stop the motion.
SHORT, SHORT_ADAPTED, MAX_SHORT = 1 / 16, 1 / 4096, 300
#: Distance of a start from where its supports hold it, relative to the size of the bodies, that is rounding.
HELD = 1e-8
#: Overlap, relative to the size of the bodies, that is rounding.
MIN_OVERLAP = 1e-9
#: Steps after which stages are compared with those of a record.
SAMPLED = (0, 1, 3, 10, 30, 100, 300, 1000)


@compact_repr
@dataclass(frozen=True, eq=False)
class Motion(WithContacts):
    """Results at the end of every step; `contacts` are those of the last one.

    With `EnergyMomentum` a contact force is one over the last step.

    Attributes
    ----------
    success : bool
        Whether the end time was reached.
    message : str
    time : (n,) array
    kinetic, strain, potential : (n,) arrays
        Energies; the potential of dead loads is zero at the initial coordinates.
    work, viscous_work, friction_work : (n,) arrays
        Work of loads that follow, as moments, and of what varies in time, energy lost to viscosity and plastic flow,
        and work of friction, from the start.
    momentum : (n, 3) array
    contact_force : (n, n_contacts, 3) array
        Resultant on each slave, with friction.
    overlaps : (n, n_contacts) array
        Depth to which the two sides overlap while nothing presses, as all mean gaps are open; zero where forces act.
    penetration : (n,) array
        Largest penetration of a mean gap.
    nit : (n,) array
    step_residuals : (n, 7) array
        Of contact, friction and equilibrium of each step, in the order of `Residuals`; `residuals` has the largest.
    frames : (n_frames, n_dofs) array
        Saved coordinates, at `frame_times`.
    now : Instant
        The last state.
    constraints : tuple of ContactConstraints
        The contacts at its end.
    warnings : tuple of str
        See `Assembly.warnings`; also printed.
    """

    success: bool
    message: str
    time: Array
    kinetic: Array
    strain: Array
    potential: Array
    work: Array
    viscous_work: Array
    friction_work: Array
    momentum: Array
    contact_force: Array
    overlaps: Array
    penetration: Array
    nit: Array
    step_residuals: Array
    frames: Array
    frame_times: Array
    now: Instant
    constraints: tuple[ContactConstraints, ...] = field(default=(), repr=False)
    warnings: tuple[str, ...] = ()

    dissipated, rubbed = renamed("dissipated", "viscous_work"), renamed("rubbed", "friction_work")

    @property
    def _on_contacts(self) -> tuple[Array, Sequence[Sequence[Array]]]:
        found = self.now.forces, self.now.tangential, self.now.slip
        ends = np.cumsum([t.n_multipliers for t in self.constraints])[:-1]
        return self.now.q, [np.split(x, ends) if self.constraints else [] for x in found]

    @property
    def residuals(self) -> Residuals:
        """Largest of all steps, of the problem that each has solved.

        Gaps are relative to the size of the bodies; with `EnergyMomentum` they are changes of the gaps in a step, see
        `schemes`. That of equilibrium is of the last iterate but one, which the last change reduces further.
        """
        found = self.step_residuals.max(axis=0).tolist()
        return Residuals(*found if any(t.friction for t in self.constraints) else found[:4])

    @property
    def energy(self) -> Array:
        """Total energy (n,)."""
        return self.kinetic + self.strain + self.potential

    @property
    def drift(self) -> float:
        """Largest change of the total energy, less all work and losses, relative to the largest kinetic energy."""
        balance = self.energy - self.work + self.viscous_work + self.friction_work
        change = balance - balance[0]
        return float(np.abs(change).max() / max(self.kinetic.max(), np.finfo(float).tiny))

    def __str__(self) -> str:
        each = self.nit[1:].mean() if len(self.nit) > 1 else 0
        return (
            f"{self.message}\n"
            f"  steps        {len(self.time) - 1}, {each:.1f} iterations each\n"
            f"  kinetic      largest {self.kinetic.max():.6g}\n"
            f"  strain       largest {self.strain.max():.6g}\n"
            f"  energy drift {self.drift:.2e} of the largest kinetic energy\n"
            f"  penetration  {self.penetration.max():.3g}\n"
            f"  residuals    largest {self.residuals.worst:.1e}"
            + "".join(f"\n{each}" for each in self.warnings)
            + "".join(
                f"\nContact {k} never carries, but its sides overlap by up to {depth:.4g}: elements or faces, whose "
                "mean gaps count, are longer than the contact. Divide them there."
                for k, depth in enumerate(self.overlaps.max(axis=0))
                if depth > 0 and not self.contact_force[:, k].any()
            )
        )


def move(
    assembly: Assembly | StageAt,
    *,
    until: float,
    step: float,
    scheme: Scheme | None = None,
    start: State | Instant | None = None,
    velocity: ArrayLike | None = None,
    gravity: ArrayLike | None = None,
    forces: Array | None = None,
    accuracy: float | None = None,
    every: int = 10,
    tolerance: float = 1e-9,
    path: str | Path | None = None,
) -> Motion:
    """Integrate the motion of ANCF solids in time.

    Parameters
    ----------
    assembly : Assembly, or callable
        ``stage(time)``: the `Stage` at a time, with loads, prescribed motions of supports and poses of rigid bodies
        that vary, for the same solids and contacts. Supports may differ, too: they may let go at some time.
    until, step : float
        End time, and step length (the largest, if steps adapt).
    scheme : GeneralisedAlpha or EnergyMomentum, optional
        `GeneralisedAlpha()` unless given.
    start : State or Instant, optional
        Begin at rest at a static equilibrium, or with the positions, velocities and time of another motion's end
        (`Motion.now`). An assembly given alone keeps supported coordinates where the start has them.
    velocity : (n_dofs,) array or (3,), optional
        Initial velocity of what is not supported; three numbers: of all bodies.
    gravity : (3,), optional
        Acceleration.
    forces : (n_dofs,) array, optional
        Constant dead loads.
    accuracy : float, optional
        Largest local error of a coordinate, which controls the step; constant steps without it. In either case a step
        that does not converge is halved, and lengthened again afterwards.
    every : int
        Steps between saved frames.
    tolerance : float
        Tolerance of the iterations, relative to the motion of a step.
    path : str or Path, optional
        File (``.npz``) to which the record is written at every frame. If it exists, the motion is resumed from its end.
        It holds fingerprints of bodies, supports, contacts, loads (those of stages at some times), start, initial
        velocity and scheme, which must be the same; `until` and `every` may differ.

    Returns
    -------
    Motion
        With ``success`` False, the reason and all that was found before, if a step could not be made without turning
        material inside out (det F <= 0 at a Gauss point) or at all, or if 300 steps in a row were shorter than 1/16 of
        `step`, with `accuracy` than 1/4096.

    Raises
    ------
    InputError
        For times that are not positive, shapes that do not fit, a start that the supports do not hold where it is, or a
        file of another motion.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.ancf import AncfSolid, AncfSpace, EnergyMomentum, Stage
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    >>> cube = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.0, density=2.0))
    >>> a = Assembly.of([cube])
    >>> push = a.gravity(np.array([0.5, 0.0, 0.0]))  # a force of one that grows with time
    >>> motion = move(lambda t: Stage(a, forces=t * push), until=1.0, step=0.1, scheme=EnergyMomentum())
    >>> float(motion.momentum[-1, 0].round(9)), float(motion.work[-1].round(9))
    (0.5, 0.0625)
    """
    lengths(until=until, step=step, **({} if accuracy is None else {"accuracy": accuracy}))
    if every < 1:
        raise InputError(f"every must be at least 1; found {every!r}.", code="every-below-one")
    chosen = GeneralisedAlpha() if scheme is None else scheme
    begin = None if start is None else start.begin
    given = assembly if callable(assembly) else _held_at(assembly, begin)
    first = given(0.0 if begin is None else begin.time)
    a = first.assembly
    load = np.zeros(a.n_dofs) if forces is None else np.asarray(forces, dtype=float)
    if load.shape != (a.n_dofs,):
        raise InputError(f"forces must hold {a.n_dofs} numbers; found the shape {load.shape}.", code="force-shape")
    if gravity is not None:
        load = load + a.gravity(np.asarray(gravity, dtype=float))
    file = None if path is None else check_writable(path)
    if file is not None and file.exists() and not file.is_file():
        raise InputError(f"{file} is not a plain file, so no record can be kept in it; choose another path.")
    at, stage = _checked(given, load, a), _loaded(first, load)
    now = _begun(at, stage, begin, velocity, step)
    prints = {}
    if file is not None:
        # fingerprints of the input, not of derived quantities, which may be rounded differently on another machine
        varying = [_acting(given(k * step)) for k in SAMPLED] if callable(assembly) else ()
        prints = {
            "the bodies (meshes, materials, laws)": fingerprint(a.solids),
            "the supports": fingerprint(*a.supports, *a.rigid),
            "the contacts": fingerprint([t.pair for t in a.constraints]),
            "the loads (gravity, forces, stages)": fingerprint(
                np.zeros(3) if gravity is None else gravity, forces, varying
            ),
            "the initial velocity": fingerprint(np.zeros(3) if velocity is None else velocity),
            "the start": fingerprint(begin),
            "the figures that this version keeps": fingerprint("residuals"),
            "the scheme (its kind and constants, step, accuracy, tolerance)": fingerprint(
                chosen, step, accuracy, tolerance
            ),
        }
    record = _Record.read(file, prints, at) if file is not None and file.exists() else None
    if record is None:
        record = _Record.begun(first, now, load, prints)
    return _march(at, record, chosen, load, until, step, accuracy, every, tolerance, file)


def _checked(given: StageAt, load: Array, first: Assembly) -> StageAt:
    """Stages in time with constant loads, refused where they are not of the same coordinates and contacts."""

    def at(time: float) -> Stage:
        stage = given(time)
        a, b = stage.assembly, first
        if a is not b and (a.n_dofs, _multipliers(a)) != (b.n_dofs, _multipliers(b)):
            raise InputError(
                f"The stage at t = {time:.6g} has {a.n_dofs} coordinates and contacts of {_multipliers(a)} multipliers"
                f", the first one {b.n_dofs} and {_multipliers(b)}: only supports, loads and poses may vary in time.",
                code="stage-differs",
            )
        return _loaded(stage, load)

    return at


def _loaded(stage: Stage, load: Array) -> Stage:
    """A stage with constant loads (n_dofs,) beside its own."""
    return replace(stage, forces=load if stage.forces is None else load + stage.forces)


def _multipliers(a: Assembly) -> tuple[int, ...]:
    return tuple(t.n_multipliers for t in a.constraints)


def _held_at(assembly: Assembly, start: Start | None) -> StageAt:
    """The assembly at all times, its supports where the start has them."""
    if start is None:
        stage = Stage(assembly)
    elif start.q.shape == (assembly.n_dofs,):
        stage = Stage(assembly, motion=assembly.held(start.q - assembly.q0))
    else:
        raise InputError(f"The start has {start.q.size} coordinates and the assembly {assembly.n_dofs}.", code="start")
    return lambda _: stage


def _acting(stage: Stage) -> tuple[object, ...]:
    """What varies in a stage, for a fingerprint."""
    a = stage.assembly
    return stage.forces, stage.motion, tuple(stage.follow), [t.pair for t in a.constraints]


def _approach(begin: Stage, end: Stage, then: Instant, now: Instant) -> float:
    """Largest approach of two bodies in a step, see `ContactConstraints.approach`; zero without contacts."""
    pairs = zip(begin.assembly.constraints, end.assembly.constraints, strict=True)
    return max((after.approach(then.q, now.q, before) for before, after in pairs), default=0.0)


def _begun(at: StageAt, stage: Stage, start: Start | None, velocity: ArrayLike | None, step: float) -> Instant:
    """The first instant, with its acceleration (without contact)."""
    time = 0.0 if start is None else start.time
    if start is not None and start.memory is not None:
        stage = stage.remembering(start.memory)
    a = stage.assembly
    q = a.q0 + stage.jump(a.q0) if start is None else start.q
    forces = np.zeros(a.n_multipliers)
    if start is not None:
        forces = start.forces
        off = a.largest_change(stage.jump(q)) if q.shape == a.q0.shape else np.inf
        if off > HELD * a.size or forces.shape != (a.n_multipliers,):
            raise InputError(
                f"The start has {q.size} coordinates and {forces.size} contact forces, the assembly {a.n_dofs} and "
                f"{a.n_multipliers}, and the supports at t = {time:.6g} hold it {off:.3g} away from where it is: "
                "start from a state of the same solids and contacts, with Stage(.., motion=assembly.held(state.q - "
                "assembly.q0)) at first.",
                code="start-differs",
            )
        if velocity is not None and start.v is not None:
            raise InputError("A motion that goes on from another has its velocity; give no other.", code="two-starts")
    v = _velocity(a, velocity) if start is None or start.v is None else start.v
    e = RATE * step
    # of the prescribed motion, from velocities one difference apart
    now, *after = rate(at, stage, time, -e), *(rate(at, at(t), t, -e) for t in (time + e, time + 2 * e))
    driven = (4 * after[0] - 3 * now - after[1]) / (2 * e)
    v = v - a.held(v) + now
    acceleration = driven + a.accelerated(stage.load(q) - a.forces(q) - a.mass @ driven, q, v)
    memory, stored, none = a.relaxed(q), 0.0, np.zeros((len(forces), 3))
    if start is not None and start.memory is not None:
        memory, stored = start.memory, start.stored
    applied = acting(stage, q, acceleration)
    return Instant(time, q, v, acceleration, acceleration, forces, applied, memory, none, none, none, stored=stored)


def _velocity(a: Assembly, velocity: ArrayLike | None) -> Array:
    v = np.zeros(3) if velocity is None else np.asarray(velocity, dtype=float)
    if v.shape == (3,):
        v = a.translation(v)
    if v.shape != (a.n_dofs,) or not np.isfinite(v).all():
        raise InputError(f"velocity must be three finite numbers or one per coordinate; found the shape {v.shape}.")
    return v


def _march(
    at: StageAt, record: _Record, scheme: Scheme, load: Array, until: float, step: float, accuracy: float | None,
    every: int, tolerance: float, file: Path | None,
) -> Motion:  # fmt: skip
    """Step until the end, shorter where needed."""
    now, stage, h, halvings, short, why = record.now, record.stage, step, 0, 0, "The accuracy asks for them."
    least = step * (SHORT if accuracy is None else SHORT_ADAPTED)
    with tqdm(total=until, initial=now.time, desc="time", disable=None, bar_format="{l_bar}{bar}| {elapsed}") as bar:
        while now.time < until * (1 - 1e-12):
            length = min(h, until - now.time)
            length = until - now.time if until - now.time < 1.001 * length else length
            try:
                after, there = scheme.step(at, stage, now, length, tolerance)
                there.assembly.check_inverted(after.q)
                wrong = 0.0 if accuracy is None else scheme.error(now, after, length) / accuracy
                trouble = "" if wrong <= 1 else "The local error stayed too large."
                if (closer := _approach(stage, there, now, after)) > NEAR:
                    trouble = f"Bodies meet and approach by {closer:.2g} of their thickness in a step of {length:.2g}."
            except (UnstableError, InvertedError, SolverError) as error:
                wrong, trouble = np.inf, str(error)
            if trouble:
                halvings, h, why = halvings + 1, length / 2, trouble
                if halvings > MAX_HALVINGS:
                    message = f"Stopped at t = {now.time:.6g}: {trouble} The last good state is kept."
                    return record.motion(False, message)
                continue
            # counted back one by one: steps that shrink towards an instant they cannot pass come to an end
            halvings = max(0, halvings - 1)
            # all these schemes have a local error of the third order in the step
            h = min(step, 2 * length if accuracy is None else length * min(2.0, 0.9 * max(wrong, 1e-3) ** (-1 / 3)))
            now, stage = after, there
            record.add(stage, now, load, (len(record.rows) % every) == 0 or now.time >= until * (1 - 1e-12))
            bar.update(length)
            if file is not None and len(record.rows) % every == 0:
                record.write(file)
            short = short + 1 if length < least else 0
            if short == MAX_SHORT and now.time < until:
                covered = now.time - record.rows[-1 - MAX_SHORT]["time"]
                left = round((until - now.time) / covered * MAX_SHORT)
                message = (
                    f"Stopped at t = {now.time:.6g}: the last {MAX_SHORT} steps were all shorter than {least:.2g}, of "
                    f"{step:.2g} given, and {left:,} like them are left to {until:.6g}. {why} Let the motion be "
                    f"smoother (viscosity, finer members), or go on with start=motion.now and step={2 * least:.2g}."
                )
                return record.motion(False, message)
    if file is not None:
        record.write(file)
    return record.motion(True, f"Reached t = {now.time:.6g}.")


class _Record:
    """Figures of each step by name, saved frames and the last state; written to and read from a file."""

    def __init__(
        self, rows: list[dict[str, Any]], frames: list[Array], frame_times: list[float], now: Instant, stage: Stage,
        prints: Mapping[str, str],
    ) -> None:  # fmt: skip
        self.rows, self.frames, self.frame_times, self.prints = rows, frames, frame_times, prints
        self.now, self.stage = now, stage

    @classmethod
    def begun(cls, stage: Stage, now: Instant, load: Array, prints: Mapping[str, str]) -> _Record:
        """A record of the initial state."""
        record = cls([], [], [], now, stage, prints)
        record.add(stage, now, load, True)
        return record

    def add(self, stage: Stage, now: Instant, load: Array, frame: bool) -> None:
        """Append a state; `load` are the constant ones, which have a potential."""
        a = stage.assembly.remembering(now.memory)
        conditions = a.conditions(now.q)
        finite = conditions.gap[np.isfinite(conditions.gap)]
        resultants, depths = [], []
        each = zip(a.constraints, conditions.parts, a.split(now.forces), a.split(now.tangential), strict=True)
        for touch, part, forces, dragged in each:
            k = a.starts.index(touch.slave_start)
            moves = np.stack([a.solids[k].translation(e) for e in np.eye(3)])
            depth = touch.overlap(now.q, part, forces)
            resultants.append(moves @ a.part(part.G.T @ forces, k) + dragged.sum(axis=0))
            depths.append(depth if depth > MIN_OVERLAP * a.size else 0.0)
        potential = -float(load @ (now.q - a.q0))
        self.rows.append(
            {
                "time": now.time,
                "kinetic": float(now.v @ (a.mass @ now.v)) / 2,
                "strain": a.energy(now.q) + now.stored,
                "potential": potential,
                # the work of constant loads is the change of their potential
                "work": now.work + potential - (self.rows[0]["potential"] if self.rows else potential),
                "viscous_work": now.viscous_work,
                "friction_work": now.friction_work,
                "momentum": a.momentum(now.v),
                "contact_force": np.reshape(resultants, (-1, 3)),
                "overlaps": np.array(depths),
                "penetration": float(max(0.0, -finite.min(initial=0.0))),
                "nit": now.nit,
                "step_residuals": now.residuals,
            }
        )
        self.now, self.stage = now, stage
        if frame:
            self.frames.append(now.q)
            self.frame_times.append(now.time)

    def _columns(self) -> dict[str, Array]:
        return {name: np.array([row[name] for row in self.rows]) for name in self.rows[0]}

    def motion(self, success: bool, message: str) -> Motion:
        """The figures by name."""
        return Motion(
            success, message, **self._columns(), frames=np.array(self.frames), frame_times=np.array(self.frame_times),
            now=self.now, constraints=self.stage.assembly.constraints,
            warnings=self.stage.assembly.remembering(self.now.memory).warnings,
        )  # fmt: skip

    def write(self, file: Path) -> None:
        """Replace the file by the present record."""
        figures: dict[str, Any] = {f"now_{f.name}": np.asarray(getattr(self.now, f.name)) for f in fields(Instant)}
        figures |= {f"step_{name}": column for name, column in self._columns().items()}
        with replacing(file) as part, part.open("wb") as stream:
            np.savez(
                stream, prints=json.dumps(self.prints), frames=self.frames, frame_times=self.frame_times, **figures
            )

    @classmethod
    def read(cls, file: Path, prints: Mapping[str, str], at: StageAt) -> _Record:
        """The record in a file, of a motion with stages in time.

        Raises
        ------
        InputError
            If the file is not the record of this motion.
        """
        try:
            with np.load(file) as data:
                found = {"prints": "{}", **data}
                kept, frames = json.loads(str(found["prints"])), list(found["frames"])
        except (OSError, ValueError, KeyError) as error:
            raise InputError(f"{file} is not the record of a motion; choose another file.", code="no-record") from error
        if not kept:
            raise InputError(
                f"{file} does not say of which motion it is the record (it was written by an earlier version), so that "
                "it cannot be gone on with; choose another path, or delete the file.",
                code="record-too-old",
            )
        if other := [name for name, value in prints.items() if kept.get(name) != value]:
            raise InputError(
                f"{file} is the record of another motion: it differs in {' and '.join(other)}. Choose another path, "
                "delete the file, or continue with the original input.",
                code="record-of-another",
            )
        columns = {name[5:]: column for name, column in found.items() if name.startswith("step_")}
        rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
        # numbers, where a file has arrays without axes
        now = Instant(**{f.name: x if (x := found[f"now_{f.name}"]).ndim else x.item() for f in fields(Instant)})
        return cls(rows, frames, found["frame_times"].tolist(), now, at(now.time), prints)
