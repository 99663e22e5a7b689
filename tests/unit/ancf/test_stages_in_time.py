"""Motion under loads, supports and rigid bodies that vary in time, and from a static state."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from refusals import refused

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    Assembly,
    EnergyMomentum,
    FollowerPressure,
    GeneralisedAlpha,
    Joints,
    Moment,
    Stage,
    equilibrium,
    move,
)
from fecontact.ancf.slender import line, straight
from fecontact.ancf.system import dynamics

SCHEMES = pytest.mark.parametrize("scheme", [GeneralisedAlpha(), EnergyMomentum()], ids=["alpha", "energy"])


def bar(supports=None, divisions=(2, 1, 1), size=(2.0, 1.0, 1.0), E=100.0, floor=None):
    mesh = fc.shapes.block(size, divisions, element="hex8")
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=E, nu=0.0, density=1.0), points=3)
    contacts = [fc.Contact(solid.side("bottom"), floor)] if floor else []
    return Assembly.of([solid], None if supports is None else [supports], contacts)


@pytest.mark.full
def test_let_go_of_a_preload_it_oscillates_about_the_unloaded_state_at_its_frequency():
    """A static load w^2 M phi bends the bar by its lowest mode phi; released it moves as phi cos(w t)."""
    a = bar({"x_min": "xyz"}, size=(4.0, 1.0, 0.5))
    Z = a.free
    K, M = (Z.T @ A @ Z for A in (a.tangent(a.q0), a.mass))
    square, modes = scipy.linalg.eigh(K.toarray(), M.toarray(), subset_by_index=[0, 0])
    shape, w = 1e-4 * (Z @ modes[:, 0]), float(np.sqrt(square[0]))
    path = equilibrium(lambda s: Stage(a, forces=s * w**2 * (a.mass @ shape)), steps=1)
    motion = move(a, until=2 * np.pi / w, step=0.02 / w, scheme=EnergyMomentum(), start=path.last, every=1)
    assert motion.success
    amplitude = (motion.frames - a.q0) @ (a.mass @ shape) / (shape @ (a.mass @ shape))
    # the mid-point rule lengthens the period by (w h)^2/12 = 3e-5; strains are small, of 1e-4
    assert np.abs(amplitude - np.cos(w * motion.frame_times)).max() < 1e-3
    assert abs(motion.energy[0] / path.last.energy - 1) < 1e-12
    assert motion.drift < 1e-9
    assert np.abs(motion.work).max() < 1e-12 * motion.energy[0]


@SCHEMES
def test_a_base_that_accelerates_is_gravity(scheme):
    """In the frame of a base that accelerates uniformly there is a weight; both schemes are exact for parabolas."""
    a, pull = bar({"x_min": "xyz"}), np.array([0.3, 0.0, -0.5])
    base = a.translation(pull)
    until, step = 0.5, 0.05
    driven = move(lambda t: Stage(a, motion=t * t / 2 * a.held(base)), until=until, step=step, scheme=scheme, every=1)
    heavy = move(a, until=until, step=step, scheme=scheme, gravity=-pull, every=1)
    away = driven.frames - driven.frame_times[:, None] ** 2 / 2 * base - heavy.frames
    assert np.abs(away).max() < 1e-9  # the velocity of the base is a difference, rounded to 1e-16 / 5e-4
    if isinstance(scheme, EnergyMomentum):
        assert driven.drift < 1e-9
        assert abs(driven.work[-1] - driven.energy[-1]) < 1e-9 * driven.work[-1]
    else:  # trapezoidal work, and a scheme that damps
        assert abs(driven.work[-1] / driven.energy[-1] - 1) < 0.05


@pytest.mark.by_day("alpha")
@SCHEMES
def test_a_floor_that_moves_is_a_body_that_falls(scheme):
    """Galilei: a plane at speed v hits a body at rest as a body at speed v hits a plane at rest."""
    v, floor = 0.5, fc.RigidBody(fc.Plane())
    mesh_up = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8").translated((0.0, 0.0, 0.012))
    solid = AncfSolid(AncfSpace(mesh_up), fc.Material(E=100.0, nu=0.0, density=1.0), points=3)
    a = Assembly.of([solid], None, [fc.Contact(solid.side("bottom"), floor)])
    arguments = {"until": 0.2, "step": 0.01, "scheme": scheme, "every": 1}
    pushed = move(lambda t: Stage(a.with_rigid(floor.placed((0, 0, v * t)))), **arguments)
    falling = move(a, velocity=(0.0, 0.0, -v), **arguments)
    assert falling.contact_force[:, 0, 2].max() > 0
    away = pushed.frames - v * pushed.frame_times[:, None] * a.translation(np.array([0, 0, 1.0])) - falling.frames
    assert np.abs(away).max() < 1e-9
    assert np.abs(pushed.contact_force - falling.contact_force).max() < 1e-6 * falling.contact_force.max()
    if isinstance(scheme, EnergyMomentum):
        assert pushed.drift < 1e-9
        # what the plane does: the impulse it gives times its speed
        assert abs(pushed.work[-1] - v * pushed.momentum[-1, 2]) < 1e-9
    assert pushed.work[-1] > 0.1


@SCHEMES
def test_supports_let_go(scheme):
    """A block hung up and let go at t = 0.1 falls freely, by parabolas of its centre of mass."""
    hung, loose = bar({"top": "xyz"}), bar()
    loose = replace(loose, solids=hung.solids)
    motion = move(
        lambda t: Stage(hung if t <= 0.1 + 1e-9 else loose), until=0.3, step=0.01, scheme=scheme, gravity=(0, 0, -1.0)
    )
    fall = motion.time > 0.1
    momentum = motion.momentum[fall, 2] + 2.0 * (motion.time[fall] - motion.time[fall][0])
    assert np.ptp(momentum) < 1e-9  # mass 2, weight 2
    # the damped scheme loses some of the energy of elastic vibrations
    assert motion.drift < (1e-8 if isinstance(scheme, EnergyMomentum) else 2e-2)


def test_a_moment_spins_a_free_body_up():
    """Angle M t^2 / (2 I), I = (a^2 + b^2) m / 12; stiff, so that inertia deforms it by 1e-5."""
    a = bar(E=1e6)
    M, inertia, until = 2.0, 2.0 * (4 + 1) / 12, 0.5
    motion = move(
        lambda t: Stage(a, follow=[Moment(0, "top", (0.0, 0.0, M))]),
        until=until, step=0.02, scheme=EnergyMomentum(), every=1,
    )  # fmt: skip
    gradient = a.solids[0].space.gradient_at(motion.frames[-1], np.array([0]), np.array([[0.5, 0.5, 0.5]]))[0]
    angle = float(np.arctan2(gradient[1, 0], gradient[0, 0]))
    assert abs(angle / (M * until**2 / 2 / inertia) - 1) < 1e-3
    assert abs(motion.work[-1] / (M * angle) - 1) < 1e-3
    assert abs(motion.energy[-1] / motion.work[-1] - 1) < 1e-6
    assert np.abs(motion.momentum[-1]).max() < 1e-9


def test_a_pressure_that_grows_does_its_work():
    a = bar({"x_min": "xyz"})
    motion = move(
        lambda t: Stage(a, follow=[FollowerPressure(0, "x_max", -5.0 * t)]),
        until=0.5,
        step=0.02,
        scheme=EnergyMomentum(),
    )
    assert motion.success
    assert motion.work[-1] > 1e-3
    assert motion.drift < 1e-8


@SCHEMES
def test_a_moment_that_varies_does_its_work(scheme):
    """Strain and kinetic energy are the sum of M dtheta, by the trapezoidal rule, off by the square of a step."""
    beam = line(straight((0, 0, 0), (1, 0, 0), 2), EA=100.0, EI=1.0, mass=1.0)
    joints = Joints([beam])
    conditions = [joints.flat(), joints.clamped((0, 0))]

    a = Assembly([beam], conditions)

    def stage(t):
        return Stage(a, follow=[Moment(0, -1, (0, 0, 0.8 * np.sin(9 * t)))])

    motion = move(stage, until=0.2, step=0.01, scheme=scheme, every=1)
    # generalised-alpha damps, and its work is trapezoidal; it drifted by a third where this work was left out
    assert motion.drift < (1e-9 if isinstance(scheme, EnergyMomentum) else 2e-3)
    angle = np.array([beam.angles(q)[-1] for q in motion.frames])
    moment = 0.8 * np.sin(9 * motion.frame_times)
    work = np.append(0.0, np.cumsum((moment[1:] + moment[:-1]) / 2 * np.diff(angle)))
    own = motion.kinetic + [beam.energy(q) for q in motion.frames]
    assert work[-1] > 0.02
    assert np.abs(own - work).max() < 0.01 * own.max()


@pytest.mark.parametrize(("scheme", "each"), [(GeneralisedAlpha(), 1), (EnergyMomentum(), 2)])
def test_a_stage_is_made_once_a_time(scheme, each):
    """The end of a step, and of the energy-momentum scheme its middle."""
    a, asked = bar({"x_min": "xyz"}), []

    def stage(t):
        asked.append(t)
        return Stage(a, forces=t * a.gravity(np.array([1.0, 0.0, 0.0])))

    motion = move(stage, until=0.5, step=0.1, scheme=scheme)
    begun = [t for t in asked if t <= 0 or t in (1e-3, 2e-3)]
    assert len(asked) - len(begun) == each * (len(motion.time) - 1)
    assert len(set(asked)) >= len(asked) - 1


@SCHEMES
def test_what_rests_on_a_floor_stays(scheme):
    floor, held = fc.RigidBody(fc.Plane()), {"x_min": "x", "y_min": "y"}
    pressed = bar({**held, "top": "z"}, floor=floor)
    loose = Assembly.of(pressed.solids, [held], pressed.contacts)
    weight, down = (pressed.translation(np.array([0.0, 0.0, z])) for z in (-5.0, -0.1))
    path = equilibrium(
        lambda s: Stage(pressed, forces=s * (pressed.mass @ weight), motion=s * pressed.held(down)), steps=1
    )
    assert path.success
    motion = move(pressed, until=0.2, step=0.02, scheme=scheme, start=path.last, gravity=(0, 0, -5.0), every=1)
    assert np.abs(motion.frames - path.last.q).max() < 1e-8
    assert motion.contact_force[-1, 0, 2] > 5.0
    # without the guide on top it springs up
    onwards = move(loose, until=0.3, step=0.02, scheme=scheme, start=motion.now, gravity=(0, 0, -5.0), every=1)
    assert onwards.time[0] == motion.time[-1]
    assert onwards.momentum[:, 2].max() > 0.1


def moved(a, **given):
    return move(a, **{"until": 0.1, "step": 0.1, **given})


class Balking(EnergyMomentum):
    """A scheme that makes no step longer than a length."""

    longest = 0.0

    def step(self, at, begin, now, h, tolerance):
        if h > Balking.longest:
            raise fc.SolverError("It balks.")
        return super().step(at, begin, now, h, tolerance)


def test_steps_that_stay_short_stop_the_motion(monkeypatch):
    """Many in a row below a sixteenth of that given, not those above; adapted to an accuracy they may be shorter."""
    assert dynamics.MAX_SHORT == 300
    monkeypatch.setattr(dynamics, "MAX_SHORT", 16)
    a = bar({"x_min": "xyz"}, divisions=(1, 1, 1))
    run = {"until": 0.1, "step": 0.08, "gravity": (0, 0, -1e-3), "scheme": Balking(), "every": 1000}
    monkeypatch.setattr(Balking, "longest", 0.08 / 16)
    assert move(a, **run).success
    monkeypatch.setattr(Balking, "longest", 0.08 / 31)
    stopped = move(a, **run)
    assert not stopped.success
    assert all(word in stopped.message for word in ("16 steps", "0.005", "24 like them", "It balks.", "step=0.01"))
    assert abs(stopped.now.time - 16 * 0.08 / 32) < 1e-12
    assert len(stopped.time) == 17
    on = move(a, **{**run, "step": 0.01}, start=stopped.now)
    assert on.success
    assert move(a, **run, accuracy=1.0).success


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda a, s: moved(lambda t: Stage(a if t == 0 else bar(divisions=(3, 1, 1)))), ("stage-differs", "192")),
        (lambda a, s: moved(bar(divisions=(3, 1, 1)), start=s), ("start", "144", "192")),
        (lambda a, s: moved(lambda t: Stage(a), start=replace(s, q=1.1 * s.q)), ("start-differs",)),
        (lambda a, s: moved(a, start=moved(a).now, until=0.2, velocity=(1, 0, 0)), ("two-starts",)),
    ],
)
def test_refused(make, match):
    a = bar({"x_min": "xyz"})
    state = equilibrium(lambda s: Stage(a), steps=1).last
    with refused(fc.InputError, *match):
        make(a, state)


def test_the_record_of_other_stages_is_refused(tmp_path):
    a, file = bar({"x_min": "xyz"}), tmp_path / "run.npz"
    pull = a.gravity(np.array([1.0, 0.0, 0.0]))
    moved(lambda t: Stage(a, forces=t * pull), path=file)
    assert moved(lambda t: Stage(a, forces=t * pull), path=file).success
    with refused(fc.InputError, "record-of-another", "the loads"):
        moved(lambda t: Stage(a, forces=t * t * pull), path=file)


def test_the_record_of_other_moments_is_refused(tmp_path):
    beam, file = line(straight((0, 0, 0), (1, 0, 0), 2), EA=100.0, EI=1.0, mass=1.0), tmp_path / "run.npz"
    joints = Joints([beam])
    conditions = [joints.flat(), joints.clamped((0, 0))]

    a = Assembly([beam], conditions)

    def turned(rate):
        return lambda t: Stage(a, follow=[Moment(0, -1, (0, 0, rate * t))])

    moved(turned(1.0), path=file)
    with refused(fc.InputError, "record-of-another", "the loads"):
        moved(turned(2.0), path=file)
