"""The four-bar mechanism of Campanelli, Berzeri & Shabana (1999), section 6, in SI units, driven by a constant moment.

The paper's table 3 contradicts itself and its drive is a figure only. Taken here: a diameter of 0.04 m, which gives its
areas (printed: 0.4 m), the second moment of area of the crank for the follower too, steel of 7848 kg/m^3 by its masses,
and a ground of 0.65 m by its equation 25. The crank starts at rest, upright, under gravity and a constant moment of
30 N m. When it lies along the ground the linkage is all but folded, and coupler and follower turn back within a few
hundredths of a second.

A four-bar linkage of rigid bars: exact kinematics, and its motion under a constant moment on the crank.

The crank turns about the origin, the follower about (ground, 0); the coupler joins their ends. With the crank's angle a
all velocities are proportional to a', so that the energy J(a) a'^2 / 2 + V(a) - M a is constant and the time follows by
quadrature.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.integrate

from fecontact.ancf import Assembly, EnergyMomentum, Moment, Motion, Stage, move
from fecontact.ancf.slender import CorotationalBeam, Joints, Structure, line, straight
from fecontact.app.studies.study import Study, slender_study
from fecontact.common.arrays import Array
from fecontact.common.checks import lengths
from fecontact.common.errors import InputError, SolverError

#: Points of the quadrature of the time.
POINTS = 40001


@dataclass(frozen=True)
class Linkage:
    """Uniform bars.

    Parameters
    ----------
    crank, coupler, follower, ground : float
        Lengths, by which the crank can go round: shortest and longest together below the others (Grashof).
    mass : float
        Per length.

    Raises
    ------
    InputError
        If the crank cannot go round.

    Examples
    --------
    >>> coupler, follower = Linkage(1.0, 4.0, 3.0, 3.5, 1.0).angles(np.array([np.pi / 2]))
    >>> crank_end, coupler_end = 1j, 1j + 4 * np.exp(1j * coupler)
    >>> bool(abs(coupler_end - 3.5 - 3 * np.exp(1j * follower)) < 1e-12)
    True
    """

    crank: float
    coupler: float
    follower: float
    ground: float
    mass: float

    def __post_init__(self) -> None:
        sizes = {k: getattr(self, k) for k in ("crank", "coupler", "follower", "ground")}
        lengths(**sizes, mass=self.mass)
        ordered = sorted(sizes.values())
        if not (ordered[0] + ordered[3] < ordered[1] + ordered[2] and ordered[0] in (self.crank, self.ground)):
            raise InputError(
                f"The crank cannot go round with the lengths {sizes}: shortest and longest together must be below the "
                "others, and the shortest the crank or the ground.",
                code="crank-cannot-turn",
            )

    def angles(self, crank: Array) -> tuple[Array, Array]:
        """Angles of the coupler and the follower, radians, by those of the crank (n,); the coupler's end is above.

        By the triangle of the crank's end, the follower's pin and the coupler's end.
        """
        to_pin = self.ground - self.crank * np.exp(1j * crank)
        size = np.abs(to_pin)
        cosine = (self.coupler**2 + size**2 - self.follower**2) / (2 * self.coupler * size)
        coupler = np.angle(to_pin) + np.arccos(np.clip(cosine, -1.0, 1.0))
        return coupler, np.angle(self.coupler * np.exp(1j * coupler) - to_pin)

    def rates(self, crank: Array) -> tuple[Array, Array]:
        """Angular velocities of the coupler and the follower over that of the crank.

        From the rate of the closed loop, along and across the other bar.
        """
        coupler, follower = self.angles(crank)
        turn = np.sin(coupler - follower)
        return (
            self.crank * np.sin(follower - crank) / (self.coupler * turn),
            self.crank * np.sin(coupler - crank) / (self.follower * turn),
        )

    def inertia(self, crank: Array) -> Array:
        """Moment of inertia felt by the crank (n,): twice the kinetic energy over the square of its rate."""
        coupler, _ = self.angles(crank)
        by_coupler, by_follower = self.rates(crank)
        middle = self.crank * np.exp(1j * crank) + self.coupler / 2 * by_coupler * np.exp(1j * coupler)
        turning = self.crank**3 + self.follower**3 * by_follower**2 + self.coupler**3 * by_coupler**2 / 4
        return np.asarray(self.mass * (self.coupler * np.abs(middle) ** 2 + turning / 3))

    def height(self, crank: Array) -> Array:
        """Sum of mass times height of the bars (n,); gravity times it is the potential."""
        coupler, follower = self.angles(crank)
        end = self.crank * np.sin(crank)
        each = self.crank * end / 2 + self.coupler * (end + self.coupler / 2 * np.sin(coupler))
        return np.asarray(self.mass * (each + self.follower**2 / 2 * np.sin(follower)))

    def driven(self, start: float, turns: float, moment: float, gravity: float) -> tuple[Array, Array]:
        """Times (n,) and angles (n,) of the crank, from rest, until it has gone round `turns` times.

        Raises
        ------
        InputError
            If the moment does not lift the bars.
        """
        # angle = start + s^2: from rest it grows with the square of the time, so that ds / dt is smooth
        s = np.linspace(0.0, np.sqrt(2 * np.pi * turns), POINTS)
        angle = start + s**2
        work = moment * s**2 - gravity * (self.height(angle) - self.height(angle[:1]))
        if not (work[1:] > 0).all():
            raise InputError(f"A moment of {moment!r} does not turn the crank against gravity; give a larger one.")
        rate = np.empty(POINTS)
        rate[1:] = np.sqrt(2 * work[1:] / self.inertia(angle[1:])) / (2 * s[1:])
        rate[0] = 2 * rate[1] - rate[2]
        return scipy.integrate.cumulative_simpson(1 / rate, x=s, initial=0), angle


AREA, SECOND_MOMENT, YOUNG, DENSITY = 1.257e-3, 1.257e-7, 2.1e11, 7848.0
GRAVITY, MOMENT, START, TURNS = 9.81, 30.0, math.pi / 2, 4.0
LINKAGE = Linkage(crank=0.5, coupler=0.7, follower=0.56, ground=0.65, mass=DENSITY * AREA)
#: Inertia of a corotational section, over that of the bar's: positions alone carry the mass, as they do in lines.
ROTARY = 1e-3
#: Seconds, for two revolutions; the linkage folds at 0.73 s and again at about 1.35 s.
UNTIL = 1.6
#: Times before the first fold.
UNFOLDED = 7
#: The crank's angle in degrees at 0.1, 0.2 .. 1.6 s by lines of eight elements a bar, and steps of 1 µs, which resolve
#: the axial waves: a symplectic composition of the sixth order in a program of its own, whose energy drifts by 4e-12.
#: Source: W. Kahan & R.-C. Li, Math. Comput. 66 (1997). Four elements a bar differ by 0.002 degrees to 0.8 s, 0.15 to
#: 1.3 s and 25 at the end: the second fold multiplies what differs.
REFINED = (
    93.047, 102.921, 122.114, 156.524, 226.763, 321.894, 353.751, 395.011,
    435.367, 479.634, 544.137, 660.219, 711.843, 754.435, 798.840, 850.325,
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Course:
    """Motion of the linkage.

    Attributes
    ----------
    motion : Motion
    bars : Structure or CorotationalBeam
        Crank, coupler and follower; the follower's nodes begin at the ground.
    angles : (n, 3) array
        Of their chords at every time, followed beyond full turns.
    sag : (n,) array
        Deflection of the coupler's middle from its chord.
    """

    motion: Motion
    bars: Structure | CorotationalBeam
    angles: Array
    sag: Array

    @property
    def drift(self) -> float:
        """Largest change of energy less the work of loads, over the largest kinetic energy."""
        return self.motion.drift


def constant(_: float) -> float:
    """The moment on the crank at a time, N m, unless another one is given."""
    return MOMENT


def drive(
    n: int,
    step: float,
    until: float,
    corotational: bool = False,
    moment: Callable[[float], float] = constant,
) -> Course:
    """Motion of bars of n elements each, an even number, from rest until a time, by a moment on the crank over time.

    Raises
    ------
    SolverError
        If the motion stops on the way.
    """
    bars = _corotational(n) if corotational else _lines(n)
    joints, first, last = Joints([bars]), [0, n + 1, 2 * n + 2], [n, 2 * n + 1, 3 * n + 2]
    conditions = [joints.pinned((0, first[k]), np.eye(3)[:2]) for k in (0, 2)]
    # pins in the plane: slots along z; the crank's end on the coupler's start, both bars' ends on each other
    conditions += [joints.slot((0, a), (0, b), (0, 0, 1)) for a, b in ((last[0], first[1]), (last[1], last[2]))]
    assembly = Assembly([bars], conditions if corotational else [*conditions, joints.flat()])
    weight, on_angle = assembly.gravity(np.array([0.0, -GRAVITY, 0.0])), np.eye(1, assembly.n_dofs, 2)[0]

    def stage(time: float) -> Stage:
        if corotational:
            return Stage(assembly, weight + moment(time) * on_angle)
        return Stage(assembly, weight, follow=[Moment(0, 0, (0.0, 0.0, moment(time)))])

    motion = move(stage, until=until, step=step, scheme=EnergyMomentum(), every=1, tolerance=1e-7)
    if not motion.success:
        raise SolverError(f"The linkage did not go round. {motion.message}")
    return Course(motion, bars, *_measured(motion.frames, n))


def bars(n: int) -> list[Array]:
    """Nodes (n + 1, 3) of crank, coupler and follower at the start."""
    crank = LINKAGE.crank * np.exp(1j * START)
    end = crank + LINKAGE.coupler * np.exp(1j * LINKAGE.angles(np.array([START]))[0][0])
    corners = [(c.real, c.imag, 0.0) for c in (0j, crank, end, LINKAGE.ground + 0j)]
    return [straight(corners[a], corners[b], n) for a, b in ((0, 1), (1, 2), (3, 2))]


def _lines(n: int) -> Structure:
    return line(bars(n), EA=YOUNG * AREA, EI=YOUNG * SECOND_MOMENT, mass=LINKAGE.mass)


def _corotational(n: int) -> CorotationalBeam:
    EA, EI = YOUNG * AREA, YOUNG * SECOND_MOMENT
    return CorotationalBeam(
        bars(n), EA=EA, EI=EI, mass_per_length=LINKAGE.mass, rotary=ROTARY * DENSITY * SECOND_MOMENT
    )


def _measured(frames: Array, n: int) -> tuple[Array, Array]:
    """Angles (n_frames, 3) of the chords and deflection (n_frames,) of the coupler's middle."""
    nodes = frames.reshape(len(frames), 3, n + 1, -1)
    place = nodes[..., 0] + 1j * nodes[..., 1]
    chords = place[:, :, -1] - place[:, :, 0]
    middle = ((place[:, 1, n // 2] - place[:, 1, 0]) * chords[:, 1].conj()).imag / np.abs(chords[:, 1])
    return np.unwrap(np.angle(chords), axis=0), middle


def solve(n: int, step: float) -> Study:
    """Two revolutions: the crank's angle beside the refined motion, and what rigid bars make of it."""
    began = time.perf_counter()
    found = drive(n, step, UNTIL)
    seconds = time.perf_counter() - began
    other = drive(n, step, UNTIL, corotational=True)
    times = np.arange(0.1, UNTIL + 0.01, 0.1)
    crank, follower = (_at(times, found, np.degrees(found.angles[:, k])) for k in (0, 2))
    cases = {f"t = {t:.1f} s": (float(c), r) for t, c, r in zip(times, crank, REFINED, strict=False)}
    passed, rigid = LINKAGE.driven(START, TURNS, MOMENT, GRAVITY)
    beside = {
        "crank, rigid bars": np.interp(times, passed, np.degrees(rigid), right=math.nan),
        "follower, found": follower,
        "follower, corotational": _at(times, other, np.degrees(other.angles[:, 2])),
        "coupler's middle off its chord, mm": _at(times, found, 1e3 * found.sag),
        "the same, corotational": _at(times, other, 1e3 * other.sag),
    }
    off = np.degrees(LINKAGE.angles(np.radians(crank))[1]) - follower
    off = (off + 180) % 360 - 180
    remarks = {
        "largest error of the crank before the linkage folds, degrees": max(
            abs(c - r) for c, r in list(cases.values())[:UNFOLDED]
        ),
        "follower off rigid bars at the crank's angle, degrees": float(np.abs(off).max()),
        "largest deflection of the coupler's middle, mm": 1e3 * float(np.abs(found.sag).max()),
        "the same by corotational beams, mm": 1e3 * float(np.abs(other.sag).max()),
        "drift of the energy": found.drift,
    }
    return slender_study("fourbar", "degrees", n, cases, _shapes(found), seconds, remarks, beside)


def _at(times: Array, course: Course, values: Array) -> Array:
    return np.interp(times, course.motion.time, values)


def _shapes(course: Course) -> dict[str, Array]:
    """The axes of the bars at twelve times, from the crank's pin to the follower's."""
    out = {}
    for k in np.linspace(0, len(course.motion.time) - 1, 12).astype(int):
        axes = course.bars.drawn(course.motion.frames[k]).points.reshape(3, -1, 3)
        out[f"{course.motion.time[k]:.2f} s"] = np.concatenate([axes[0], axes[1], axes[2, ::-1]])
    return out
