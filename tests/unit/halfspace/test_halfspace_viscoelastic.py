"""Visco-elastic half-spaces: creep from a Prony series, balls pressed and let go, memory of friction, refusals."""

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
from refusals import refused

import fecontact as fc

BALL = fc.surfaces.Paraboloid(1.0)
RUBBER = fc.Viscoelastic(fc.Material(1.0, 0.3), prony=[(0.5, 1.0), (0.3, 4.0)])


def half_space(cells=32, material=RUBBER, size=3.6, **options):
    return fc.HalfSpace(material, size=(size, size), cells=(cells, cells), **options)


@pytest.mark.parametrize(
    "prony",
    [
        [(0.5, 1.0)],
        [(0.2, 1.0), (0.3, 1.0)],
        [(0.1, 10.0**k) for k in range(-6, 3)],
        [(1e-6, 1.0), (0.99, 1.0001)],
        [(1e-3, 1e9), (0.2, 1e-9)],
    ],
)
def test_creep_is_the_inverse_of_relaxation(prony):
    """In Laplace's variable the product of both is one."""
    (s, theta), (g, tau) = fc.Viscoelastic(fc.Material(1.0, 0.3), prony).creep, np.array(prony).T
    for p in [0.0, *10.0 ** np.arange(-10, 11)]:
        relaxation, creep = 1 - (g / (1 + p * tau)).sum(), 1 + (s / (1 + p * theta)).sum()
        assert abs(relaxation * creep - 1) < 1e-9
    assert (s > 0).all()


def creep(t):
    s, theta = RUBBER.creep
    return 1 + (s * -np.expm1(-np.asarray(t)[..., None] / theta)).sum(axis=-1)


def test_ball_under_a_force_held():
    """Lee & Radok 1960: Hertz's ball with the creep of the material, as the contact does not shrink."""
    times, force = np.array([0.0, 0.1, 0.5, 2.0, 10.0, 10.0, 1e3, 1e6]), 0.1
    steps = [fc.PressStep(force=force, time=t) for t in times]
    path = half_space(64).press_path(BALL, steps, friction=0.0)
    modulus = RUBBER.material.plane_strain_modulus
    exact = (3 * force * creep(times) / (4 * modulus)) ** (2 / 3)
    approach = np.array([contact.approach for contact in path])
    assert np.abs(approach / exact - 1).max() < 2e-3
    assert approach[4] == pytest.approx(approach[5], rel=1e-9)  # at the same time, the same loads: nothing happens
    assert (path.time == times).all()
    # after a long time it is the elastic answer of the relaxed material
    relaxed = half_space(64, RUBBER.relaxed).press(BALL, force=force)
    assert np.abs(path.last.pressure - relaxed.pressure).max() < 1e-3 * relaxed.max_pressure
    assert path.last.approach == pytest.approx(relaxed.approach, rel=1e-4)
    assert path.last.displacement[32, 32] == pytest.approx(relaxed.displacement[32, 32], rel=1e-4)


def test_ball_that_comes_and_goes():
    """Ting 1966: in retreat the contact is as at an earlier time t1, of which the force alone is needed."""
    speed, top, modulus, psi = 0.5, 1.0, RUBBER.material.plane_strain_modulus, RUBBER.remaining

    def pulled(a, b):
        return scipy.integrate.quad(psi, a, b)[0]

    def ting(t):
        t1 = t
        if t > top:
            t1 = scipy.optimize.brentq(lambda s: pulled(t - top, t - s) - pulled(0.0, t - top), 0.0, top)
        return 2 * modulus * speed**1.5 * scipy.integrate.quad(lambda s: psi(t - s) * np.sqrt(s), 0, t1)[0]

    times = np.linspace(0.125, 1.5, 12)
    steps = [fc.PressStep(approach=speed * (t if t <= top else 2 * top - t), time=float(t)) for t in times]
    path = half_space().press_path(BALL, steps, friction=0.0)
    exact = np.array([ting(t) for t in times])
    assert np.abs(path.force - exact).max() < 2e-3 * exact.max()
    assert exact[-1] < 0.15 * exact.max()  # it has nearly let go, where the elastic ball has a third of its force


@pytest.mark.parametrize(
    ("by", "times", "loads", "friction"),
    [
        ("approach", [0.25, 0.5, 0.75, 1.0, 1.25], [0.125, 0.25, 0.375, 0.5, 0.375], 0.0),  # Ting's ball
        ("approach", [0.0, 0.3, 2.0, 20.0], [0.2, 0.2, 0.2, 0.2], 0.0),  # held: it relaxes
        ("force", [0.0, 0.3, 2.0, 20.0], [0.1, 0.1, 0.1, 0.1], 0.0),  # Lee & Radok's ball
        ("approach", [1.0, 2.5, 9.0], [0.2, 0.1, 0.25], 0.3),
        ("force", [1.0, 2.5, 9.0], [0.08, 0.03, 0.1], 0.3),
    ],
)
def test_error_of_the_steps_in_time(by, times, loads, friction):
    """Beside eight times as many steps of the same history, with friction four times."""
    half, n = half_space(12), 4 if friction else 8

    def path(n):
        t0 = load0 = 0.0
        steps = []
        for t, load in zip(times, loads, strict=True):
            shares = np.arange(1, n + 1) / n if t > t0 else [1.0]
            steps += [fc.PressStep(**{by: load0 + w * (load - load0)}, time=t0 + w * (t - t0)) for w in shares]
            t0, load0 = t, load
        return half.press_path(BALL, steps, friction)

    coarse, fine = path(1), path(n)
    ends = [contact for contact in fine if min(abs(contact.time - np.array(times))) < 1e-12]
    off = [np.linalg.norm(a.pressure - b.pressure) for a, b in zip(coarse, ends, strict=True)]
    true = [error / np.linalg.norm(end.pressure) for error, end in zip(off, ends, strict=True)]
    found = [contact.time_error.pressure for contact in coarse]
    assert 0.5 * max(true) < max(found) < 3 * max(true)
    if by == "force":
        assert all(contact.time_error.force < 1e-9 for contact in coarse)
    assert max(contact.time_error.pressure for contact in fine) < 0.35 * max(found)  # contact grows by cells
    warned = [any("steps in time" in text for text in contact.warnings) for contact in coarse]
    assert warned == [max(contact.time_error) > 0.05 for contact in coarse]
    assert "error by the steps in time" in str(coarse.last)
    assert coarse.last.summary()["time_error"]["pressure"] == found[-1]


def test_steps_in_time_are_cut_to_an_accuracy():
    """Held for long in one step: cut where it relaxes, with longer parts later."""
    half = half_space(12)
    steps = [fc.PressStep(approach=0.2, time=t) for t in (0.0, 8.0)]
    whole, cut = (half.press_path(BALL, steps, 0.0, accuracy=accuracy) for accuracy in (None, 0.01))
    fine = half.press_path(
        BALL, [steps[0], *(fc.PressStep(approach=0.2, time=t) for t in np.geomspace(0.04, 8, 30))], 0.0
    )
    true = [abs(path.last.force / fine.last.force - 1) for path in (whole, cut)]
    assert whole.cuts == (1, 1)
    assert 4 < cut.cuts[1] < 24
    assert true[0] > 0.1
    assert true[1] < 0.01
    assert max(cut.last.time_error) < 0.01
    times = np.diff([0.0, *(part.time for part in cut.last.parts), 8.0])
    assert times[-1] > 3 * times[0]
    assert (half.press_path(BALL, steps, 0.0, accuracy=10.0).force == whole.force).all()


def test_error_of_the_steps_in_time_of_a_punch():
    """Under forces that change evenly there is none; at approaches it is that of all pressures alike."""
    half, times = half_space(16, size=1.0), (1.0, 3.0, 9.0)
    z = np.where(np.hypot(half.grid.x[:, None], half.grid.y) < 0.3, 0.0, np.inf)
    pressed = half.press_path(z, [fc.PressStep(force=t, time=t) for t in times], friction=0.0)
    assert max(max(contact.time_error) for contact in pressed) < 1e-3
    coarse = half.press_path(z, [fc.PressStep(approach=t, time=t) for t in times], friction=0.0)
    fine = half.press_path(z, [fc.PressStep(approach=t, time=t) for t in np.arange(1, 37) / 4], friction=0.0)
    true = coarse.force / fine.force[[3, 11, 35]] - 1
    for contact, error in zip(coarse, true, strict=True):
        assert contact.time_error.pressure == pytest.approx(error, rel=0.25)  # a parabola for an exponential
        assert contact.time_error.force == pytest.approx(error, rel=0.25)  # a parabola for an exponential


def test_a_surface_that_was_let_go_comes_back():
    """Under a punch, let go at once at the time 3: what has crept stays and goes, as exp(-t/2) of its one term."""
    half = half_space(16, fc.Viscoelastic(fc.Material(1.0, 0.3), [(0.5, 1.0)]), size=1.0)
    z = np.where(np.hypot(half.grid.x[:, None], half.grid.y) < 0.3, 0.0, np.inf)
    held = [fc.PressStep(force=1e-3, time=t) for t in (0.0, 3.0)]
    gone = [fc.PressStep(approach=-1e-3, time=t) for t in (3.0, 4.0, 100.0)]
    path = half.press_path(z, [*held, *gone, fc.PressStep(force=1e-3, time=100.0)], friction=0.0)
    assert [contact.status for contact in path] == ["solved"] * 2 + ["no-contact"] * 3 + ["solved"]
    under, crept = np.isfinite(z), path[1].approach - path[0].approach
    for contact, left in ((path[2], 1.0), (path[3], np.exp(-0.5)), (path[4], 0.0)):
        assert contact.force == 0.0
        assert np.abs(contact.displacement[under] - left * crept).max() < 1e-9 * crept
        assert np.abs(contact.gap[under] - left * crept - 1e-3).max() < 1e-9 * crept
    assert path.last.approach == pytest.approx(path[0].approach, rel=1e-9)


def test_very_slow_and_very_fast_are_elastic_with_friction_too():
    half = half_space(24, against=RUBBER)
    for factor, material in ((1e-9, RUBBER.material), (1e9, RUBBER.relaxed)):
        loads = [
            {"force": 0.1},
            {"force": 0.1, "tangential": (0.03, 0.0)},
            {"force": 0.08, "tangential": (-0.01, 0.01)},
        ]
        steps = [fc.PressStep(**load, time=factor * k) for k, load in enumerate(loads, 1)]
        path = half.press_path(BALL, steps, friction=0.5)
        elastic = half_space(24, material, against=material).press_path(BALL, steps, friction=0.5)
        for one, other in zip(path, elastic, strict=True):
            assert np.abs(one.pressure - other.pressure).max() < 1e-6 * other.max_pressure
            assert np.abs(one.traction - other.traction).max() < 1e-6 * other.max_pressure
            assert np.abs(one.slip - other.slip).max() < 1e-6 * np.abs(other.displacement).max()
            assert one.shift == pytest.approx(other.shift, abs=1e-6)


@pytest.mark.parametrize("periodic", [False, True])
def test_steps_in_parts_change_nothing_where_forces_change_evenly(periodic):
    """A flat punch, whose contact stays as it is: memory is exact for any steps."""
    half = half_space(16, periodic=periodic, size=1.0)
    z = np.where(np.hypot(half.grid.x[:, None], half.grid.y) < 0.3, 0.0, np.inf)
    long = [fc.PressStep(force=t, time=t) for t in (1.0, 3.0)]
    short = [fc.PressStep(force=t, time=t) for t in (0.5, 0.7, 1.0, 2.9, 3.0)]
    one, other = (half.press_path(z, steps, friction=0.0).last for steps in (long, short))
    assert one.approach == pytest.approx(other.approach, rel=1e-9)
    assert one.material == RUBBER.material


def test_friction_slips_against_what_creeps():
    """Pulled at once and held: the ball goes on by itself, as far as the creep of the material takes it."""
    half = half_space(24, fc.Viscoelastic(fc.Material(1.0, 0.0), [(0.5, 1.0)]))
    steps = [fc.PressStep(force=0.1, tangential=(q, 0.0), time=t) for q, t in ((0.0, 0.0), (1e-3, 0.0), (1e-3, 100.0))]
    stuck = half.press_path(BALL, steps, friction=np.inf)
    first, last = stuck.shift[1, 0], stuck.shift[2, 0]
    assert last > 1.05 * first  # what sticks creeps under the new cells too
    assert np.abs(stuck.last.slip).max() < 1e-9


def test_a_file_resumes(tmp_path):
    half = half_space(16)
    steps = [fc.PressStep(force=0.1, tangential=(0.01 * k, 0.0), time=0.5 * k) for k in (0, 1, 2)]
    whole = half.press_path(BALL, steps, friction=0.3, path=tmp_path / "whole.jsonl")
    half.press_path(BALL, steps[:2], friction=0.3, path=tmp_path / "part.jsonl")
    resumed = half.press_path(BALL, steps, friction=0.3, path=tmp_path / "part.jsonl")
    again = half.press_path(BALL, steps, friction=0.3, path=tmp_path / "whole.jsonl")
    for other in (resumed, again):
        assert np.abs(other.last.pressure - whole.last.pressure).max() < 1e-12
        assert np.abs(other.last.slip - whole.last.slip).max() < 1e-12
        assert np.abs(other.last.retarded - whole.last.retarded).max() < 1e-12
        assert other.last.time_error.pressure == pytest.approx(whole.last.time_error.pressure, rel=1e-6)


def test_time_on_an_elastic_half_space_changes_nothing():
    half = half_space(16, RUBBER.material)
    timed = half.press_path(BALL, [fc.PressStep(force=0.1, time=2.0)], friction=0.0).last
    plain = half.press_path(BALL, [fc.PressStep(force=0.1)], friction=0.0).last
    assert (timed.pressure == plain.pressure).all()
    assert (timed.time, plain.time, timed.retarded, timed.time_error) == (2.0, 0.0, None, None)


def test_refused():
    half, press = half_space(8), fc.PressStep
    for made in (
        lambda: half.press(BALL, force=0.1),
        lambda: half.curve(BALL, [0.1]),
        lambda: half.roll(BALL, force=0.1, friction=0.3),
        lambda: fc.Contact(half, fc.RigidBody(fc.Sphere(1.0))),
        lambda: fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), RUBBER),
        lambda: fc.HalfSpace(RUBBER, layers=[fc.Layer(fc.Material(1.0, 0.3), 0.1)]),
    ):
        with refused(fc.InputError, "viscoelastic"):
            made()
    for other in (
        lambda: fc.HalfSpace(fc.Viscoelastic(fc.NeoHookean(1.0, 0.3), [(0.5, 1.0)])),
        lambda: fc.Layer(RUBBER, 0.1),
        lambda: fc.hertz.spheres((1.0, 1.0), (RUBBER, RUBBER), force=1.0),
        lambda: fc.Viscoelastic(RUBBER, [(0.5, 1.0)]),
    ):
        with pytest.raises(fc.InputError, match="Material"):
            other()
    with refused(fc.InputError, "time-missing"):
        half.press_path(BALL, [press(force=0.1)], friction=0.0)
    with refused(fc.InputError, "time-backwards"):
        half.press_path(BALL, [press(force=0.1, time=1.0), press(force=0.1, time=0.5)], friction=0.0)
    with refused(fc.InputError, "time-backwards"):
        press(force=0.1, time=-1.0)
    with refused(fc.InputError, "accuracy-elastic"):
        half_space(8, RUBBER.material).press_path(BALL, [press(force=0.1)], friction=0.0, accuracy=0.01)
    with refused(fc.InputError, "creep-unlike"):
        half_space(8, against=fc.Material(1.0, 0.3)).press_path(BALL, [press(force=0.1, time=1.0)], friction=0.1)
    with refused(fc.InputError, "prony-sum"):
        fc.Viscoelastic(fc.Material(1.0, 0.3), [(0.5, 1.0), (0.5, 2.0)])
    for prony in ([], [(0.5, 0.0)], [0.5, 1.0], [(-0.5, 1.0)]):
        with refused(fc.InputError, "prony-series"):
            fc.Viscoelastic(fc.Material(1.0, 0.3), prony)
