"""Motion in time: steps of a scheme, balance of energy and momentum, and a resumable record."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from tqdm import tqdm

from fecontact.ancf.assembly import Assembly
from fecontact.ancf.laws import InvertedError
from fecontact.ancf.newton import UnstableError
from fecontact.ancf.schemes import GeneralisedAlpha, Instant, Scheme
from fecontact.common.arrays import Array
from fecontact.common.checks import lengths
from fecontact.common.errors import InputError, SolverError
from fecontact.common.files import check_writable, replacing
from fecontact.common.fingerprint import fingerprint
from fecontact.common.one_line import one_line

#: Halvings of the step, less the steps made since, after which the motion stops.
MOST_HALVINGS = 12


@one_line
@dataclass(frozen=True, eq=False)
class Motion:
    """Results at the end of every step.

    Attributes
    ----------
    success : bool
        Whether the end time was reached.
    message : str
    time : (n,) array
    kinetic, strain, potential : (n,) arrays
        Energies; the potential of dead loads is zero at the initial coordinates.
    momentum : (n, 3) array
    contact_force : (n, n_touches, 3) array
        Resultant on each slave.
    penetration : (n,) array
        Largest penetration of a mean gap.
    nit : (n,) array
    frames : (n_frames, n_dofs) array
        Saved coordinates, at `frame_times`.
    now : Instant
        The last state.
    """

    success: bool
    message: str
    time: Array
    kinetic: Array
    strain: Array
    potential: Array
    momentum: Array
    contact_force: Array
    penetration: Array
    nit: Array
    frames: Array
    frame_times: Array
    now: Instant

    @property
    def energy(self) -> Array:
        """Total energy (n,)."""
        return self.kinetic + self.strain + self.potential

    @property
    def drift(self) -> float:
        """Largest change of the total energy from its first value, relative to the largest kinetic energy."""
        return float(np.abs(self.energy - self.energy[0]).max() / max(self.kinetic.max(), np.finfo(float).tiny))

    def __str__(self) -> str:
        each = self.nit[1:].mean() if len(self.nit) > 1 else 0
        return (
            f"{self.message}\n"
            f"  steps        {len(self.time) - 1}, {each:.1f} iterations each\n"
            f"  kinetic      largest {self.kinetic.max():.6g}\n"
            f"  strain       largest {self.strain.max():.6g}\n"
            f"  energy drift {self.drift:.2e} of the largest kinetic energy\n"
            f"  penetration  {self.penetration.max():.3g}"
        )


def move(
    assembly: Assembly,
    *,
    until: float,
    step: float,
    scheme: Scheme | None = None,
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
    assembly : Assembly
    until, step : float
        End time, and step length (the largest, if steps adapt).
    scheme : GeneralisedAlpha or EnergyMomentum, optional
        `GeneralisedAlpha()` unless given.
    velocity : (n_dofs,) array or (3,), optional
        Initial velocity; three numbers: of all bodies.
    gravity : (3,), optional
        Acceleration.
    forces : (n_dofs,) array, optional
        Further dead loads.
    accuracy : float, optional
        Largest local error of a coordinate, which controls the step; constant steps without it. In either case a step
        that does not converge is halved, and lengthened again afterwards.
    every : int
        Steps between saved frames.
    tolerance : float
        Tolerance of the iterations, relative to the motion of a step.
    path : str or Path, optional
        File (``.npz``) to which the record is written at every frame. If it exists, the motion is resumed from its end.
        It holds fingerprints of bodies, supports, contacts, loads, initial velocity and scheme, which must be the same;
        `until` and `every` may differ.

    Returns
    -------
    Motion
        With ``success`` False, the reason and all that was found before, if a step could not be made without turning
        material inside out (det F <= 0 at a Gauss point) or at all.

    Raises
    ------
    InputError
        For times that are not positive, shapes that do not fit, or a file of another motion.
    """
    lengths(until=until, step=step, **({} if accuracy is None else {"accuracy": accuracy}))
    if every < 1:
        raise InputError(f"every must be at least 1; found {every!r}.")
    chosen = GeneralisedAlpha() if scheme is None else scheme
    load = np.zeros(assembly.n_dofs) if forces is None else np.asarray(forces, dtype=float)
    if any(t.friction for t in assembly.touches):
        raise InputError("Motion has no friction yet; give contacts without it, or follow the equilibrium in statics.")
    if load.shape != (assembly.n_dofs,):
        raise InputError(f"forces must hold {assembly.n_dofs} numbers; found the shape {load.shape}.")
    if gravity is not None:
        load = load + assembly.gravity(np.asarray(gravity, dtype=float))
    file = None if path is None else check_writable(path)
    if file is not None and file.exists() and not file.is_file():
        raise InputError(f"{file} is not a plain file, so no record can be kept in it; choose another path.")
    v = _velocity(assembly, velocity)
    prints = {}
    if file is not None:
        # fingerprints of the input, not of derived quantities, which may be rounded differently on another machine
        prints = {
            "the bodies (meshes, materials, laws)": fingerprint(assembly.solids),
            "the supports": fingerprint(assembly.free),
            "the contacts": fingerprint([t.pair for t in assembly.touches]),
            "the loads (gravity, forces)": fingerprint(np.zeros(3) if gravity is None else gravity, forces),
            "the initial velocity": fingerprint(np.zeros(3) if velocity is None else velocity),
            "the scheme (its kind and constants, step, accuracy, tolerance)": fingerprint(
                chosen, step, accuracy, tolerance
            ),
        }
    record = _Record.read(file, prints) if file is not None and file.exists() else None
    if record is None:
        record = _Record.begun(assembly, _first(assembly, v, load), load, prints)
    return _march(assembly, record, chosen, load, until, step, accuracy, every, tolerance, file)


def _velocity(a: Assembly, velocity: ArrayLike | None) -> Array:
    v = np.zeros(3) if velocity is None else np.asarray(velocity, dtype=float)
    if v.shape == (3,):
        v = a.translation(v)
    if v.shape != (a.n_dofs,) or not np.isfinite(v).all():
        raise InputError(f"velocity must be three finite numbers or one per coordinate; found the shape {v.shape}.")
    return np.asarray(a.free @ (a.free.T @ v))


def _first(a: Assembly, v: Array, load: Array) -> Instant:
    """The initial state, with its acceleration (without contact)."""
    acceleration = a.accelerated(load - a.forces(a.q0))
    return Instant(0.0, a.q0, v, acceleration, acceleration, np.zeros(sum(t.n_multipliers for t in a.touches)))


def _march(
    a: Assembly,
    record: _Record,
    scheme: Scheme,
    load: Array,
    until: float,
    step: float,
    accuracy: float | None,
    every: int,
    tolerance: float,
    file: Path | None,
) -> Motion:
    """Step until the end, shorter where needed."""
    now, h, halvings = record.now, step, 0
    with tqdm(total=until, initial=now.time, desc="time", disable=None, bar_format="{l_bar}{bar}| {elapsed}") as bar:
        while now.time < until * (1 - 1e-12):
            length = min(h, until - now.time)
            length = until - now.time if until - now.time < 1.001 * length else length
            try:
                after = scheme.step(a, now, length, load, tolerance)
                a.check_inverted(after.q)
                wrong = 0.0 if accuracy is None else scheme.error(now, after, length) / accuracy
                trouble = "" if wrong <= 1 else "The local error stayed too large."
            except (UnstableError, InvertedError, SolverError) as error:
                wrong, trouble = np.inf, str(error)
            if trouble:
                halvings, h = halvings + 1, length / 2
                if halvings > MOST_HALVINGS:
                    message = f"Stopped at t = {now.time:.6g}: {trouble} The last good state is kept."
                    return record.motion(False, message)
                continue
            # counted back one by one: steps that shrink towards an instant they cannot pass come to an end
            halvings = max(0, halvings - 1)
            # all these schemes have a local error of the third order in the step
            h = min(step, 2 * length if accuracy is None else length * min(2.0, 0.9 * max(wrong, 1e-3) ** (-1 / 3)))
            now = after
            record.add(a, now, load, (len(record.rows) % every) == 0 or now.time >= until * (1 - 1e-12))
            bar.update(length)
            if file is not None and len(record.rows) % every == 0:
                record.write(file)
    if file is not None:
        record.write(file)
    return record.motion(True, f"Reached t = {now.time:.6g}.")


class _Record:
    """Rows of figures, saved frames and the last state; written to and read from a file."""

    def __init__(
        self,
        rows: list[Array],
        frames: list[Array],
        frame_times: list[float],
        now: Instant,
        prints: Mapping[str, str],
    ) -> None:
        self.rows, self.frames, self.frame_times, self.now, self.prints = rows, frames, frame_times, now, prints

    @classmethod
    def begun(cls, a: Assembly, now: Instant, load: Array, prints: Mapping[str, str]) -> _Record:
        """A record of the initial state."""
        record = cls([], [], [], now, prints)
        record.add(a, now, load, True)
        return record

    def add(self, a: Assembly, now: Instant, load: Array, frame: bool) -> None:
        """Append a state."""
        kinetic = float(now.v @ (a.mass @ now.v)) / 2
        conditions = a.conditions(now.q)
        finite = conditions.gap[np.isfinite(conditions.gap)]
        resultants = []
        for touch, part, forces in zip(a.touches, conditions.parts, a.split(now.forces), strict=True):
            space = touch.slave.space
            moves = np.stack([space.affine(np.zeros((3, 3)), e) for e in np.eye(3)])
            own = (part.G.T @ forces)[touch.slave_start : touch.slave_start + space.n_dofs]
            resultants.append(moves @ own)
        figures = [now.time, kinetic, a.energy(now.q), -float(load @ (now.q - a.q0)), *a.momentum(now.v)]
        figures += [float(max(0.0, -finite.min(initial=0.0))), float(now.nit)]
        self.rows.append(np.concatenate([figures, *resultants]))
        self.now = now
        if frame:
            self.frames.append(now.q)
            self.frame_times.append(now.time)

    def motion(self, success: bool, message: str) -> Motion:
        """The figures by name."""
        rows = np.array(self.rows)
        return Motion(
            success, message, rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 3], rows[:, 4:7],
            rows[:, 9:].reshape(len(rows), -1, 3), rows[:, 7], rows[:, 8].astype(int),
            np.array(self.frames), np.array(self.frame_times), self.now,
        )  # fmt: skip

    def write(self, file: Path) -> None:
        """Replace the file by the present record."""
        state = {f"now_{f.name}": np.asarray(getattr(self.now, f.name)) for f in fields(Instant)}
        with replacing(file) as part, part.open("wb") as stream:
            figures = {"rows": np.array(self.rows), "frames": self.frames, "frame_times": self.frame_times}
            np.savez(stream, prints=json.dumps(self.prints), **figures, **state)  # type: ignore[arg-type]

    @classmethod
    def read(cls, file: Path, prints: Mapping[str, str]) -> _Record:
        """The record in a file.

        Raises
        ------
        InputError
            If the file is not the record of this motion.
        """
        try:
            with np.load(file) as data:
                now = Instant(**{f.name: data[f"now_{f.name}"] for f in fields(Instant)})
                rows, frames, times = list(data["rows"]), list(data["frames"]), data["frame_times"].tolist()
                kept = json.loads(str(data["prints"])) if "prints" in data else {}
        except (OSError, ValueError, KeyError) as error:
            raise InputError(f"{file} is not the record of a motion; choose another file.") from error
        if not kept:
            raise InputError(
                f"{file} does not say of which motion it is the record (it was written by an earlier version), so that "
                "it cannot be gone on with; choose another path, or delete the file."
            )
        if other := [name for name, value in prints.items() if kept.get(name) != value]:
            raise InputError(
                f"{file} is the record of another motion: it differs in {' and '.join(other)}. Choose another path, "
                "delete the file, or continue with the original input."
            )
        return cls(rows, frames, times, replace(now, time=float(now.time), nit=int(now.nit)), prints)
