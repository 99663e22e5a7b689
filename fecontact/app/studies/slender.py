"""The beams of Campanelli, Berzeri & Shabana (1999), in SI units, by lines of absolute nodal coordinates.

Source: M. Campanelli, M. Berzeri & A. A. Shabana, Performance of the incremental and non-incremental finite element
formulations in flexible multibody problems, J. Mech. Des. 122 (2000). The paper does not give the pendulum's density;
5540 is the value in public use.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from itertools import zip_longest
from typing import Any

import numpy as np
import scipy.sparse as sp

from fecontact.ancf import Assembly, EnergyMomentum, Moment, Motion, Stage, equilibrium, move
from fecontact.ancf.slender import CorotationalBeam, Joints, Structure, line, straight
from fecontact.app.studies import elastica, fourbar
from fecontact.app.studies.fourbar import ROTARY
from fecontact.app.studies.study import Study, slender_study
from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.errors import InputError, SolverError

LENGTH = 1.2
#: The pendulum's rigidities and mass per length.
EA, EI, MASS = 0.7e6 * 1.8e-3, 0.7e6 * 1.215e-8, 5540 * 1.8e-3
#: Seconds to which the paper's figures show it, and to which corotational beams are followed beside: later they need
#: ever smaller steps. The paper's own diverged after 0.7 s with 40 elements and did not converge with 12.
LATEST, BESIDE = 1.1, 0.7
#: Elements unless given.
ELEMENTS = {"elastica": 10, "circle": 10, "pendulum": 12, "fourbar": 2}
#: Problems that measure a bar's middle, which must be a node.
EVEN = ("pendulum", "fourbar")
#: Deflection of the pendulum's middle from its chord at 0.1, 0.2, 0.3 and 0.4 s, by gravity: a hundred elements and a
#: Runge-Kutta integrator of the eighth order. Later motions under the larger one are chaotic.
FALLING = {9.81: (-0.024567, -0.100074, -0.234799, -0.217471), 50.0: (-0.126258, -0.315841, 0.188716, 0.021995)}

#: Steps of time, in seconds, unless given.
STEPS = {9.81: 2e-3, 50.0: 1e-3, "fourbar": 5e-4}


def run(name: str, options: Mapping[str, Any]) -> Study:
    """Solve a problem.

    Parameters
    ----------
    name : {'elastica', 'circle', 'pendulum', 'fourbar'}
    options : mapping
        elements, measure, step of time, and of the pendulum gravity and the time until which it is followed.

    Raises
    ------
    InputError
        For an unknown problem, or numbers that do not fit.

    Examples
    --------
    >>> run("circle", {"elements": 20}).data["error"] < 0.02
    True
    """
    among("problem", name, _RUN)
    n = options.get("elements") or ELEMENTS[name]
    if n < 1 or (name in EVEN and n % 2):
        raise InputError(f"Expected one element or more, an even number for pendulum and fourbar; found {n}.")
    if name != "pendulum" and options.get("until") is not None:
        raise InputError(
            f"The time until which it is followed is an option of the pendulum, not of {name}.", code="until"
        )
    return _RUN[name](n, options)


def pendulum(n: int, measure: str = "turn") -> tuple[Structure, list[sp.csr_matrix]]:
    """The paper's falling bar, pinned at one end, and its conditions."""
    beam = line(straight((0, 0, 0), (LENGTH, 0, 0), n), EA=EA, EI=EI, mass=MASS, measure=measure)
    joints = Joints([beam])
    return beam, [joints.flat(), joints.pinned((0, 0))]


def _axis(beam: Structure, q: Array) -> Array:
    return beam.points(q).reshape(-1, 3)


def _elastica(n: int, options: Mapping[str, Any]) -> Study:
    return elastica.solve(n, options.get("measure") or "turn")


def _circle(n: int, options: Mapping[str, Any]) -> Study:
    began = time.perf_counter()
    beam, conditions = elastica.cantilever(n, options.get("measure") or "turn")

    assembly = Assembly([beam], conditions)

    def stage(level: float) -> Stage:
        return Stage(assembly, follow=[Moment(0, -1, (0.0, 0.0, level * 2 * math.pi * elastica.EI))])

    path = equilibrium(stage, steps=8)
    if not path.success:
        raise SolverError(f"The circle was not closed. {path.message}")
    bent = [s for s in path.steps if s.level > 0]
    cases = {f"{s.level:.3f} M": (math.degrees(beam.angles(s.q)[-1]), 360.0 * s.level) for s in bent}
    shapes = {f"{360 * s.level:.0f}°": _axis(beam, s.q) for s in path.steps}
    return slender_study("circle", "degrees", n, cases, shapes, time.perf_counter() - began)


def _pendulum(n: int, options: Mapping[str, Any]) -> Study:
    began = time.perf_counter()
    gravity, step, until = options.get("gravity", 9.81), options.get("step"), options.get("until")
    if gravity not in FALLING:
        raise InputError(f"Fine solutions are known for gravity {' and '.join(map(str, FALLING))}; found {gravity!r}.")
    step = STEPS[gravity] if step is None else step
    known = FALLING[gravity]
    if until is not None and not 0.1 * len(known) <= until <= LATEST:
        raise InputError(f"The pendulum is followed to 0.4 s and up to {LATEST:g} s; found {until!r}.", code="until")
    times: Array = 0.1 * np.arange(1.0, 1 + round(10 * (until or 0.4)))
    beam, conditions = pendulum(n, options.get("measure") or "turn")
    motion = _fallen(Assembly([beam], conditions), times[-1], step, gravity)
    if not motion.success:
        raise SolverError(f"The pendulum did not fall to the end. {motion.message}")
    seconds, sag = time.perf_counter() - began, _sag_at(times, beam, motion)
    cases = {f"t = {t:.1f} s": (float(s), k) for t, s, k in zip_longest(times, sag, known, fillvalue=math.nan)}
    shapes = {f"{t:.1f} s": _axis(beam, motion.frames[np.argmin(np.abs(motion.frame_times - t))]) for t in times}
    remarks = {"drift of the energy": motion.drift}
    beside: dict[str, list[float]] = {}
    for procedure in ("1986", "modern") if until is not None else ():
        other = CorotationalBeam(
            straight((0, 0, 0), (LENGTH, 0, 0), n),
            EA=EA,
            EI=EI,
            mass_per_length=MASS,
            rotary=ROTARY * MASS * EI / EA,
            procedure=procedure,
        )
        held = Assembly([other], [Joints([other]).pinned((0, 0), np.eye(3)[:2])])
        fallen = _fallen(held, min(times[-1], BESIDE), step, gravity)
        beside[f"corotational, {procedure}"] = _sag_at(times, other, fallen).tolist()
        turned = max(float(np.abs(other.local_turns(q)).max()) for q in fallen.frames)
        remarks[f"largest turn within an element, {procedure}, degrees"] = math.degrees(turned)
    return slender_study("pendulum", "m", n, cases, shapes, seconds, remarks, beside)


def _fallen(assembly: Assembly, until: float, step: float, gravity: float) -> Motion:
    return move(assembly, until=until, step=step, gravity=(0, -gravity, 0), scheme=EnergyMomentum(), every=1)


def _sag_at(times: Array, beam: Structure | CorotationalBeam, motion: Motion) -> Array:
    """Deflections (n,) of the middle; NaN after a motion has ended. Steps may have been halved."""
    sag = [_sag(beam, q) for q in motion.frames]
    return np.interp(times, motion.frame_times * (1 + 1e-12), sag, right=math.nan)


def _sag(beam: Structure | CorotationalBeam, q: Array) -> float:
    """Deflection of the middle from the chord."""
    x = beam.positions(q)
    chord = (x[-1] - x[0]) / np.linalg.norm(x[-1] - x[0])
    arm = x[len(x) // 2] - x[0]
    return float(chord[0] * arm[1] - chord[1] * arm[0])


def _fourbar(n: int, options: Mapping[str, Any]) -> Study:
    return fourbar.solve(n, options.get("step") or STEPS["fourbar"])


_RUN: dict[str, Callable[[int, Mapping[str, Any]], Study]] = {
    "elastica": _elastica,
    "circle": _circle,
    "pendulum": _pendulum,
    "fourbar": _fourbar,
}
