"""Half-spaces with friction: products, the certificate, load paths, refusals."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.analytic import boussinesq
from fecontact.halfspace import path as friction_path
from fecontact.halfspace import tresca
from fecontact.halfspace.compliance import tangential_compliance
from fecontact.halfspace.friction import Friction, mixed, press_step
from fecontact.halfspace.kernels import cerruti
from fecontact.halfspace.tresca import TrescaIterate, TrescaProblem, _finer, coarser_tresca, solve_tresca
from fecontact.solvers.coulomb import projected
from fecontact.surfaces import FlatPunch, Paraboloid

PLAIN, STEEL = fc.Material(E=1.0, nu=0.0), fc.Material(E=1.0, nu=0.3)
BALL, MU = Paraboloid(100.0), 0.3


def half(material=STEEL, n=24, against=None, periodic=False):
    return fc.HalfSpace(material, (2.6, 2.6), (n, n), periodic, against=against)


def force_of(body):
    """Force for a contact of radius about 1."""
    return 4 / 300 * body.compliance.modulus


def whole(body):
    nx, ny = body.grid.shape
    return tangential_compliance(body.compliance, (slice(0, nx), slice(0, ny)))


@pytest.mark.parametrize("against", [None, fc.Material(E=5.0, nu=0.1)])
def test_products_are_sums_of_point_forces_far_away(against):
    body = fc.HalfSpace(STEEL, (64.0, 48.0), (64, 48), against=against)
    compliance = whole(body)
    where, there = (5, 7), (50, 40)
    offset = np.array([(there[0] - where[0]) * 1.0, (there[1] - where[1]) * 1.0, 0.0])
    for axis, material_axis in ((0, 0), (1, 1)):
        q = np.zeros((2, 64, 48))
        q[axis][where] = 1.0
        force = np.zeros(3)
        force[material_axis] = 1.0
        u = boussinesq.displacement(offset, force=force, material=STEEL)  # z into the body
        if against is not None:  # the reverse force on the body above, whose own z points up
            above = boussinesq.displacement(offset, force=-force, material=against)
            u = u - above * np.array([1, 1, -1])
        found = [*compliance.apply(q)[:, *there], compliance.normal_displacement(q)[there]]
        # a cell is a point at this distance to (1/55)^2/24
        np.testing.assert_allclose(found, u, rtol=1e-4)
    p = np.zeros((64, 48))
    p[where] = 1.0
    u = boussinesq.displacement(offset, force=(0.0, 0.0, 1.0), material=STEEL)[:2]
    if against is not None:
        u = u - boussinesq.displacement(offset, force=(0.0, 0.0, 1.0), material=against)[:2]
    np.testing.assert_allclose(compliance.of_pressure(p)[:, *there], u, rtol=1e-4)


@pytest.mark.parametrize("periodic", [False, True])
def test_reciprocity(periodic):
    body = half(n=12, periodic=periodic)
    compliance, rng = whole(body), np.random.default_rng(1)
    q, other, p = rng.normal(size=(2, 12, 12)), rng.normal(size=(2, 12, 12)), rng.normal(size=(12, 12))
    one, two = np.vdot(other, compliance.apply(q)), np.vdot(q, compliance.apply(other))
    assert one == pytest.approx(two, rel=1e-12)
    assert np.vdot(p, compliance.normal_displacement(q)) == pytest.approx(
        np.vdot(q, compliance.of_pressure(p)), rel=1e-11
    )
    assert np.vdot(q, compliance.apply(q)) > 0


def test_products_by_direct_sums():
    body = half(n=6)
    tables, compliance = cerruti((6, 6), body.grid.cell), whole(body)
    q = np.random.default_rng(2).normal(size=(2, 6, 6))
    G, nu = STEEL.shear_modulus, STEEL.nu
    expected = np.zeros((2, 6, 6))
    for i in np.ndindex(6, 6):
        for j in np.ndindex(6, 6):
            d = (i[0] - j[0], i[1] - j[1])
            k, sign = (abs(d[0]), abs(d[1])), np.sign(d[0]) * np.sign(d[1])
            direct = (1 - nu) * (tables.xx[k] + tables.yy[k])
            cross = nu * tables.xy[k] * sign
            expected[0][i] += ((direct + nu * tables.xx[k]) * q[0][j] + cross * q[1][j]) / (2 * math.pi * G)
            expected[1][i] += ((direct + nu * tables.yy[k]) * q[1][j] + cross * q[0][j]) / (2 * math.pi * G)
    np.testing.assert_allclose(compliance.apply(q), expected, atol=1e-13)


def test_pressure_draws_the_surface_inwards():
    body = half(n=64)
    r = np.hypot(body.grid.x[:, None], body.grid.y[None, :])
    u = whole(body).of_pressure(np.sqrt(np.maximum(1 - r**2, 0)))
    i = 54
    x = float(body.grid.x[i])
    assert 0.8 < x < 1
    # Johnson 1985, section 3.4: u_r = -(1 - 2 nu)/(6 G) (1 - (1 - r^2)^1.5)/r; beside the axis y = 0, by half a cell
    here = float(r[i, 32])
    exact = -(1 - 2 * 0.3) / (6 * STEEL.shear_modulus) * (1 - (1 - here**2) ** 1.5) / here
    assert u[0, i, 32] == pytest.approx(exact * x / here, rel=2e-3)


def test_a_long_period_is_free():
    free = fc.HalfSpace(STEEL, (32.0, 32.0), (128, 128))
    periodic = fc.HalfSpace(STEEL, (32.0, 32.0), (128, 128), True)
    # smooth tractions of no force in all: images are far dipoles, cells are small
    x, y = free.grid.x[:, None], free.grid.y[None, :]
    bell = np.exp(-(x**2 + y**2) / 2)
    q = np.stack([x * bell, -0.5 * y * bell])
    here = (slice(48, 80), slice(48, 80))
    for name in ("apply", "normal_displacement"):
        one, two = (getattr(whole(body), name)(q)[..., *here] for body in (free, periodic))
        # a dipole's field at the first image, (2/32)^2, and a quarter of that of cells of 1/4, (1/4)^2/24
        assert np.abs(one - two).max() < 0.02 * np.abs(one).max()


@pytest.mark.parametrize("against", [None, STEEL])
def test_without_friction_it_is_the_frictionless_answer(against):
    body = half(against=against)
    plain = body.press(BALL, force=force_of(body), tolerance=1e-10)
    found = body.press(BALL, force=force_of(body), friction=0.0)
    assert np.abs(found.pressure - plain.pressure).max() <= 1e-12 * plain.max_pressure
    assert not found.traction.any()
    assert found.residuals.within(1e-8)
    with refused(InputError, "slides-as-a-whole", "0"):
        body.press(BALL, force=force_of(body), friction=0.0, tangential=(1e-9, 0.0))


def test_rough_surfaces_stick():
    body = half(against=STEEL)
    found = body.press(BALL, force=force_of(body), friction=math.inf, tangential=(5 * force_of(body), 0.0))
    assert not found.slipping.any()
    assert np.abs(found.slip).max() < 1e-8 * found.shift[0]
    # a bonded disc: Q = 8 a shift/((2 - nu)/G for each body); the outline is a staircase of cells
    stiffness = 8 / (2 * (2 - 0.3) / STEEL.shear_modulus)
    assert found.tangential[0] / found.shift[0] == pytest.approx(stiffness * (found.area / math.pi) ** 0.5, rel=0.02)


def test_the_answer_turns_with_the_force():
    body = half()
    force = force_of(body)
    along, across, back = (
        body.press(BALL, force=force, friction=MU, tangential=(0.5 * MU * force * x, 0.5 * MU * force * y))
        for x, y in ((1, 0), (0, 1), (-1, 0))
    )
    scale = along.traction.max()
    np.testing.assert_allclose(across.traction[1], along.traction[0].T, atol=1e-7 * scale)
    np.testing.assert_allclose(back.traction[0], -along.traction[0][::-1], atol=1e-7 * scale)
    assert across.shift[1] == pytest.approx(along.shift[0], rel=1e-7)


@pytest.mark.by_day("1000.0-1e-06")
@pytest.mark.parametrize(("length", "stress"), [(1e-3, 2e11), (1e3, 1e-6)])
def test_the_answer_follows_the_units(length, stress):
    body = half()
    force = force_of(body)
    scaled = fc.HalfSpace(fc.Material(E=stress, nu=0.3), (2.6 * length, 2.6 * length), (24, 24))
    unit = stress * length**2
    one = body.press(BALL, force=force, friction=MU, tangential=(0.5 * MU * force, 0.0))
    two = scaled.press(
        Paraboloid(100 * length), force=force * unit, friction=MU, tangential=(0.5 * MU * force * unit, 0.0)
    )
    np.testing.assert_allclose(two.traction / stress, one.traction, atol=1e-7 * one.traction.max())
    assert two.shift[0] / length == pytest.approx(one.shift[0], rel=1e-7)
    assert two.friction_work / unit / length == pytest.approx(one.friction_work, rel=1e-6)


def test_force_and_shift_are_the_same_problem():
    body = half()
    force = force_of(body)
    pulled = body.press(BALL, force=force, friction=MU, tangential=(0.5 * MU * force, 0.0))
    moved = body.press(BALL, approach=pulled.approach, friction=MU, shift=pulled.shift)
    assert moved.tangential[0] == pytest.approx(pulled.tangential[0], rel=1e-6)
    assert moved.force == pytest.approx(force, rel=1e-6)


def test_a_large_shift_slides():
    body = half(against=STEEL)
    found = body.press(BALL, force=force_of(body), friction=MU, shift=(0.1, 0.0))
    assert not found.sticking.any()
    assert found.tangential[0] == pytest.approx(MU * found.force, rel=1e-3)  # all but the small parts across
    assert found.friction_work > 0


def test_the_certificate_sees_what_is_wrong():
    body = half()
    force = force_of(body)
    friction = Friction(body.compliance, MU, 1e-8)
    step = fc.PressStep(force=force, tangential=(0.5 * MU * force, 0.0))
    good = press_step(friction, body.heights_of(BALL), step, None)
    assert good.residuals.worst < 1e-8
    # where it sticks, slip is what the tolerance leaves of the displacement
    left = 1e-8 * good.displacement.max() * np.hypot(*good.traction).max()
    assert (good.slip * good.traction).sum(axis=0).max() <= left
    numbers = good.residuals
    for name in ("penetration", "tension", "complementarity", "equilibrium", "cone", "slip", "dissipation"):
        assert not replace(numbers, **{name: 1e-6}).within(1e-8)


@pytest.mark.full
def test_newton_and_alternating_directions_agree_with_projected_gradients():
    body = half(n=10)
    compliance, rng = whole(body), np.random.default_rng(3)
    limit = rng.uniform(0, 1, (10, 10)) * (rng.random((10, 10)) < 0.8)
    c = rng.normal(size=(2, 10, 10))
    problem = TrescaProblem(compliance, limit, c, np.zeros((0, 2, 10, 10)), np.zeros(0))
    found = solve_tresca(problem, np.zeros((2, 10, 10)), np.zeros(0), 1e-11)
    assert found.defect <= 1e-11
    at = TrescaIterate(np.zeros((2, 10, 10)), c, np.zeros(0))
    for _ in range(20):
        at = tresca._alternate(problem, at)
    np.testing.assert_allclose(found.q, at.q, atol=1e-7)
    q, largest = np.zeros((2, 10, 10)), 0.5 / compliance.own
    for _ in range(3000):
        q = projected(q - 0.3 * largest * problem.slip(q, np.zeros(0)), limit)
    np.testing.assert_allclose(found.q, q, atol=1e-8)


def test_a_cycle_without_slip_returns_exactly():
    body = half(n=16)
    loads = [(0.0, 0.0), (0.2, 0.1), (-0.1, 0.3), (0.0, 0.0)]
    steps = [fc.PressStep(force=1.0, tangential=load) for load in loads]
    path = body.press_path(FlatPunch(radius=1.0), steps, friction=5.0)
    first, last = path.steps[0], path.last
    assert not last.slipping[last.sticking].any()
    np.testing.assert_allclose(path.friction_work[1:], 0.0, atol=1e-12)
    np.testing.assert_allclose(last.traction, first.traction, atol=1e-7 * first.pressure.max())
    np.testing.assert_allclose(last.shift, first.shift, atol=1e-9)


def test_the_path_matters_and_a_repeated_cycle_repeats():
    body = half(PLAIN, against=PLAIN)
    force = force_of(body)
    loads = [0.0, 0.6, -0.6, 0.6, -0.6, 0.6, 0.0]
    path = body.press_path(
        BALL, [fc.PressStep(force=force, tangential=(MU * force * q, 0.0)) for q in loads], friction=MU
    )
    np.testing.assert_allclose(path.shift[[1, 2]], path.shift[[3, 4]], atol=1e-9 * path.shift.max())
    assert path.friction_work[3] == pytest.approx(path.friction_work[2], rel=1e-6)
    assert path.friction_work[2] == pytest.approx(2 * path.friction_work[1], rel=1e-6)
    assert abs(path.shift[-1, 0]) > 0.05 * path.shift[1, 0]  # unloaded, but displaced and under self-stress
    work = sum(c.work_density for c in path.steps)
    np.testing.assert_allclose(MU * path.wear_depth(2.0), 2 * work)
    with pytest.warns(DeprecationWarning, match=r"wear_depth\(coefficient \* mu\)"):
        np.testing.assert_allclose(path.wear(2.0), 2 * work)
    assert path.work_density.min() >= -1e-9 * path.work_density.max()


@pytest.mark.full
def test_energy_balances_in_a_loop():
    """What the forces put in is dissipated, where the end is the state of the beginning."""
    body = half(PLAIN, against=PLAIN)
    force = force_of(body)
    turn = 0.6 * np.cos(np.linspace(0, 2 * np.pi, 41))
    path = body.press_path(
        BALL, [fc.PressStep(force=force, tangential=(MU * force * q, 0.0)) for q in turn], friction=MU
    )
    q, d = path.tangential[:, 0], path.shift[:, 0]
    put_in = float(((q[1:] + q[:-1]) / 2 * np.diff(d)).sum())
    assert put_in == pytest.approx(path.friction_work[1:].sum(), rel=0.01)  # trapezoids of 20 steps to a branch


def test_torque_and_position():
    body = half(against=STEEL)
    force = force_of(body)
    path = body.press_path(BALL, [fc.PressStep(force=force, torque=0.05 * force)], friction=MU)
    assert path.torque[0] == pytest.approx(0.05 * force, rel=1e-8)
    again = body.press_path(BALL, [fc.PressStep(force=force, twist=float(path.twist[0]))], friction=MU)
    assert again.torque[0] == pytest.approx(path.torque[0], rel=1e-6)
    assert "torque" in str(path.last)
    cell = body.grid.cell[0]
    aside = body.press_path(BALL, [fc.PressStep(force=force, torque=0.05 * force, position=(2 * cell, 0.0))], MU)
    assert aside.twist[0] == pytest.approx(path.twist[0], rel=1e-6)
    np.testing.assert_allclose(aside.last.pressure[2:], path.last.pressure[:-2], atol=1e-7 * path.last.max_pressure)


def test_periodic_contact_with_friction():
    body = half(periodic=True, n=32)
    force = force_of(body)
    found = body.press(BALL, force=force, friction=MU, tangential=(0.5 * MU * force, 0.0))
    assert found.residuals.within(1e-8)
    assert found.tangential[0] == pytest.approx(0.5 * MU * force, rel=1e-8)
    assert 0 < found.stick_area < found.area


def test_reports(tmp_path):
    body = half(PLAIN, n=16, against=PLAIN)
    force = force_of(body)
    path = body.press_path(BALL, [fc.PressStep(force=force, tangential=(q, 0.0)) for q in (0.0, 0.1 * force)], MU)
    assert "2 steps" in str(path)
    assert "stick area" in str(path.last)
    assert json.loads(json.dumps(path.as_dict()))["steps"][1]["tangential_x"] == pytest.approx(0.1 * force)
    rows = path.save(tmp_path / "path.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 3
    assert rows[0].startswith("force,approach,tangential_x")
    assert float(rows[2].split(",")[2]) == pytest.approx(0.1 * force)


REFUSED = {
    "friction": (lambda body: body.press(BALL, force=0.01, friction=-0.1), ("friction", "zero or positive")),
    "nan": (lambda body: body.press(BALL, force=0.01, friction=math.nan), ("friction", "zero or positive")),
    "sliding": (
        lambda body: body.press(BALL, force=0.01, friction=0.3, tangential=(0.004, 0.0)),
        ("slides-as-a-whole", "(1, 0)", "0.4", "0.3"),
    ),
    "torque": (
        lambda body: body.press_path(BALL, [fc.PressStep(force=0.01, torque=1.0)], 0.3),
        ("slides-as-a-whole", "0.3"),
    ),
    "both": (
        lambda body: fc.PressStep(force=1.0, tangential=(0.0, 0.0), shift=(0.0, 0.0)),
        ("input", "tangential", "shift"),
    ),
    "no load": (lambda body: fc.PressStep(tangential=(1.0, 0.0)), ("one-of",)),
    "tension": (lambda body: fc.PressStep(force=-1.0), ("force-not-positive", "-1.0")),
    "nan force": (lambda body: fc.PressStep(force=1.0, tangential=(math.nan, 0.0)), ("not-a-vector", "two")),
    "no steps": (lambda body: body.press_path(BALL, [], 0.3), ("no-steps",)),
    "no step": (lambda body: body.press_path(BALL, [{"force": 1.0}], 0.3), ("wrong-class", "a PressStep")),
    "array": (
        lambda body: body.press_path(body.heights_of(BALL), [fc.PressStep(force=0.01, position=(0.1, 0.0))], 0.3),
        ("heights-fixed",),
    ),
    "tangential alone": (lambda body: body.press(BALL, force=0.01, tangential=(1.0, 0.0)), ("input", "needs friction")),
    "load point": (
        lambda body: body.press(BALL, force=0.01, friction=0.1, load_point=(9.0, 0.0)),
        ("load-point-outside",),
    ),
    "lifted, dragged": (
        lambda body: body.press(BALL, approach=-0.1, friction=0.1, tangential=(1e-3, 0.0)),
        ("nothing-touches", "tangential"),
    ),
    "lifted, rolling": (lambda body: body.roll(BALL, approach=-0.1, friction=0.1), ("nothing-touches",)),
    "lifted, coefficients": (lambda body: body.creep_coefficients(BALL, approach=-0.1), ("nothing-touches",)),
    "second step": (
        lambda body: body.press_path(
            BALL, [fc.PressStep(force=0.01), fc.PressStep(force=0.001, tangential=(0.002, 0.0))], 0.3
        ),
        ("slides-as-a-whole", "Step 2", "of 2", "The contact slides"),
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refusals(name):
    do, told = REFUSED[name]
    with refused(InputError, *told):
        do(half(n=12))


@pytest.mark.parametrize("mu", [0.0, MU, math.inf])
@pytest.mark.parametrize("options", [{"against": STEEL}, {"against": None}, {"against": None, "periodic": True}])
def test_surfaces_that_part_and_meet_again(mu, options, tmp_path):
    """Apart nothing acts; slip after that counts from where they touch, a third before the end of the step."""
    body, step = fc.HalfSpace(STEEL, (3.0, 3.0), (16, 16), **options), fc.PressStep
    steps = [step(approach=-5e-3), step(approach=5e-3), step(approach=-1e-2, shift=(2.5e-3, 0.0))]
    steps += [step(approach=5e-3, shift=(1e-3, 0.0)), step(approach=-2e-2)]
    path = body.press_path(BALL, steps, mu, path=tmp_path / "path.jsonl")
    assert [contact.status for contact in path] == ["no-contact", "solved", "no-contact", "solved", "no-contact"]
    for apart, gap in ((path[0], 5e-3), (path[2], 1e-2), (path[4], 2e-2)):
        assert (apart.force, apart.tangential, apart.friction_work, apart.stick_area) == (0.0, (0.0, 0.0), 0.0, 0.0)
        assert np.abs(apart.gap - body.heights_of(BALL) - gap).max() < 1e-15
        assert "no-contact" in str(apart)
        assert apart.summary()["area"] == 0.0
    left = 1.5e-3 * (5e-3 - body.heights_of(BALL).min()) / 1.5e-2  # of the way by shift, when a first cell touches
    once = body.press(BALL, approach=5e-3, friction=mu, shift=(-left, 0.0))
    assert np.abs(path[3].pressure - once.pressure).max() < 1e-8 * once.max_pressure
    assert np.abs(path[3].traction - once.traction).max() < 1e-8 * once.max_pressure
    assert abs(path[3].friction_work - once.friction_work) < 1e-8 * 5e-4 * once.force
    # where no force drags it, the shift is zero within the tolerance of 1e-10 of the displacement
    assert np.abs(path.shift[:, 0] - [0.0, 0.0, 2.5e-3, 1e-3, 1e-3]).max() < 1e-10 * 5e-3
    again = body.press_path(BALL, steps, mu, path=tmp_path / "path.jsonl")
    assert (again.force == path.force).all()


@pytest.mark.parametrize("against", [True, False])
def test_a_punch_that_tilts(against):
    """A force off the middle of a dragged flat punch: its pressures balance it, and tilt it as without friction.

    Against a body of the same material nothing is coupled: the same tilt. On a rigid punch tractions press, too.
    """
    body = fc.HalfSpace(STEEL, (3.0, 3.0), (24, 24), against=STEEL if against else None)
    punch = FlatPunch(1.0)
    dragged = body.press(punch, force=1.0, friction=MU, load_point=(0.2, 0.0), tangential=(0.1, 0.0))
    smooth = body.press(punch, force=1.0, load_point=(0.2, 0.0), tolerance=1e-10)
    at = (dragged.pressure * body.grid.x[:, None]).sum() / dragged.pressure.sum()
    assert at == pytest.approx(0.2, rel=1e-9)
    assert dragged.residuals.within(1e-10)
    assert dragged.tangential[0] == pytest.approx(0.1, rel=1e-9)
    apart = abs(dragged.tilt[0] / smooth.tilt[0] - 1)
    assert apart < 1e-9 if against else 1e-3 < apart < 0.1


def test_points_and_twisted_periods_are_refused():
    points = fc.HalfSpace(STEEL, (2.6, 2.6), (12, 12), pressure="point")
    with refused(InputError, "friction-uniform", "'point'"):
        points.press(BALL, force=0.01, friction=0.1)
    with refused(InputError, "torsion-not-periodic"):
        half(n=12, periodic=True).press_path(BALL, [fc.PressStep(force=0.01, twist=0.1)], 0.3)
    with refused(InputError, "stress-with-friction"):
        half(n=12, periodic=True).press(BALL, force=0.01, friction=0.1).stress([[0.0, 0.0, -1.0]])


def test_a_step_without_solution_is_cut_in_halves_and_its_work_is_that_of_all_parts(monkeypatch) -> None:
    half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(3.0, 3.0), cells=(16, 16))
    ball, mu = fc.surfaces.Paraboloid(1.0), 0.5
    steps = [fc.PressStep(force=0.5), fc.PressStep(force=0.3, shift=(0.2, 0.0))]
    solve, longest = friction_path.press_step, 0.15

    def stubborn(friction, z, step, last, symmetry):
        if step.shift is not None and step.shift[0] - (last.shift[0] if last else 0.0) > longest:
            raise fc.SolverError("too far")
        return solve(friction, z, step, last, symmetry)

    middle = fc.PressStep(force=0.4, shift=(0.1, 0.0))
    given = half.press_path(ball, [steps[0], middle, steps[1]], mu)
    monkeypatch.setattr(friction_path, "press_step", stubborn)
    path = half.press_path(ball, steps, mu)
    assert path.cuts == (1, 2)
    assert given.cuts == (1, 1, 1)
    assert abs(path.friction_work[1] - given.friction_work[1:].sum()) < 1e-10 * given.friction_work.sum()
    np.testing.assert_allclose(path.last.traction, given.last.traction, rtol=0, atol=1e-12)
    np.testing.assert_allclose(path.wear_depth(1e-3), given.wear_depth(1e-3), rtol=0, atol=1e-15)
    # one that is set down elsewhere in between is not: at places in between it would rub
    with pytest.raises(fc.SolverError, match="Step 2 of 2: too far"):
        half.press_path(ball, [steps[0], fc.PressStep(force=0.3, shift=(0.2, 0.0), position=(0.1, 0.0))], mu)
    longest = 1e-4
    with pytest.raises(fc.SolverError, match="Step 2 of 2: too far"):
        half.press_path(ball, steps, mu)


@pytest.mark.parametrize("against", [None, fc.Material(E=3.0, nu=0.1)])  # the second is coupled
def test_an_interrupted_path_goes_on_as_if_it_had_not_been(against, tmp_path, monkeypatch) -> None:
    half = fc.HalfSpace(fc.Material(E=1.0, nu=0.3), size=(3.0, 3.0), cells=(12, 12), against=against)
    ball, file = fc.surfaces.Paraboloid(1.0), tmp_path / "path.jsonl"
    steps = [fc.PressStep(force=0.3, shift=(x, 0.0)) for x in (0.0, 0.1, -0.05)]
    solve, calls = friction_path.press_step, []

    def stubborn(friction, z, step, last, symmetry):
        calls.append(step)
        if step.shift[0] == 0.1 and last.shift[0] == 0.0:
            raise fc.SolverError("too far")
        return solve(friction, z, step, last, symmetry)

    monkeypatch.setattr(friction_path, "press_step", stubborn)
    whole = half.press_path(ball, steps, 0.5)
    half.press_path(ball, steps[:2], 0.5, path=file)
    calls.clear()
    again = half.press_path(ball, steps, 0.5, path=file)
    assert len(calls) == 1  # the others are certified, not solved
    assert again.cuts == whole.cuts == (1, 2, 1)
    for name in ("traction", "pressure", "gap", "displacement", "slip"):
        for one, other in zip(again, whole, strict=True):
            found, expected = getattr(one, name), getattr(other, name)
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(again.wear_depth(1.0), whole.wear_depth(1.0), rtol=0, atol=1e-14)
    assert again.column("worst_residual").max() < 1e-10
    for change in ({"friction": 0.4}, {"steps": [fc.PressStep(force=0.2), *steps[1:]]}):
        with refused(InputError, "row-of-another", "'1'"):
            half.press_path(ball, **{"steps": steps, "friction": 0.5, **change}, path=file)


def test_a_row_that_is_no_solution_is_refused(tmp_path, monkeypatch) -> None:
    half = fc.HalfSpace(fc.Material(E=1.0, nu=0.3), size=(3.0, 3.0), cells=(12, 12))
    ball, file = fc.surfaces.Paraboloid(1.0), tmp_path / "path.jsonl"
    steps = [fc.PressStep(force=0.3, tangential=(0.05, 0.0))]
    kept = friction_path.FrictionSteps.end
    monkeypatch.setattr(friction_path.FrictionSteps, "end", lambda own, c: {**kept(own, c), "traction": 2 * c.traction})
    half.press_path(ball, steps, 0.5, path=file)
    with refused(fc.SolverError, "not-solved", "no solution"):
        half.press_path(ball, steps, 0.5, path=file)


@pytest.mark.parametrize(
    ("first", "second", "middle"),
    [
        ({"force": 0.5}, {"force": 0.5, "tangential": (0.1, 0.0)}, {"force": 0.5, "tangential": (0.05, 0.0)}),
        ({"approach": 0.1}, {"force": 0.2}, None),
        ({"force": 0.2, "twist": 0.1}, {"force": 0.2}, {"force": 0.2, "tangential": (0.0, 0.0), "twist": 0.05}),
    ],
)
def test_half_way_loads_go_on_from_what_the_last_contact_bears(first, second, middle) -> None:
    half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(3.0, 3.0), cells=(16, 16))
    last = half.press_path(fc.surfaces.Paraboloid(1.0), [fc.PressStep(**first)], 0.5).last
    begin = friction_path._start(np.zeros((1, 1)), fc.PressStep(**second), last, None)
    found = friction_path._between(begin, friction_path._end(fc.PressStep(**second)), 0.5)
    expected = middle or {"force": (last.force + 0.2) / 2, "tangential": (0.0, 0.0)}
    for name, value in expected.items():
        np.testing.assert_allclose(found[name], value, rtol=0, atol=1e-12)
    fc.PressStep(**found)  # as many as a step may have


@pytest.mark.parametrize("gap", [0.0, 1e-4])
def test_two_cells_that_hardly_slip_are_solved(gap):
    # the dissipation of a contact that sticks is judged by next to no work of slip
    half = fc.HalfSpace(fc.Material(1.0, 0.3), (1.0, 1.0), (12, 12))
    heights = np.ones((12, 12))
    heights[5:7, 6] = 0.0, gap
    force, pull = 1e-3, (2.4e-4, -0.8e-4)
    contact = half.press(heights, force=force, friction=0.8, tangential=pull)
    assert contact.residuals.worst < 1e-10
    assert contact.tangential_solver.staggered < 20
    assert np.abs(np.array(contact.tangential) - pull).max() < 1e-13
    # two cells have no part within them that slips: both stick or the contact slides as a whole
    assert np.hypot(*contact.slip).max() < 1e-9 * abs(contact.approach)


def test_tractions_of_coarser_cells_stay_at_the_limits_where_all_slips():
    body = fc.HalfSpace(PLAIN, size=(3.0, 3.0), cells=(24, 24))
    compliances = [tangential_compliance(body.compliance, (slice(0, n), slice(0, n))) for n in (24, 12)]
    x = np.arange(24) - 11.5
    limit = np.sqrt(np.maximum(1 - (x[:, None] ** 2 + x**2) / 100, 0.0))
    c, none = np.zeros((2, 24, 24)), np.zeros((0, 2, 24, 24))
    for most in (limit, np.where(limit > 0, np.inf, 0.0)):  # sliding, and rough surfaces with tractions of 1
        problem = TrescaProblem(compliances[0], most, c, none, np.zeros(0))
        coarse = coarser_tresca(problem, compliances[1])
        share = np.where(np.isfinite(coarse.limit), coarse.limit, 1.0) * coarse.touching
        q = _finer(coarse, np.stack([0.6 * share, 0.8 * share]), problem)
        size = np.where(np.isfinite(most), most, 1.0)
        assert np.abs(np.hypot(*q) - size)[limit > 0].max() < 1e-14


def test_mixing_ends_a_linear_iteration_in_as_many_steps_as_it_has_modes():
    A, b, x, tried = np.diag([0.5, 0.2, -0.3]), np.array([1.0, 2.0, -1.0]), np.zeros(3), []
    for _ in range(4):
        x = mixed(tried, x, A @ x + b)
    assert np.abs(x - np.linalg.solve(np.eye(3) - A, b)).max() < 1e-12
