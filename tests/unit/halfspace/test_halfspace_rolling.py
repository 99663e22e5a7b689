"""Steady rolling on half-spaces: products, signs, frames, units, loads, errors, refusals."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.halfspace import creep, rolling, tresca
from fecontact.halfspace.compliance import tangential_compliance
from fecontact.halfspace.rolling import RULES, RollingFriction, RollingStep
from fecontact.surfaces import Paraboloid

STEEL, RUBBER = fc.Material(E=1.0, nu=0.28), fc.Material(E=0.2, nu=0.45)
MU, FORCE = 0.3, 2e-4
BALL = Paraboloid(1.0, 0.6)


def half(n=20, against=STEEL, turned=False, **more):
    size, cells = (0.22, 0.176), (n, n - 4)
    if turned:
        size, cells = size[::-1], cells[::-1]
    return fc.HalfSpace(STEEL, size, cells, against=against, **more)


def rolled(body=None, surface=BALL, force=FORCE, friction=MU, **more):
    return (body or half()).roll(surface, force=force, friction=friction, **more)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("towards", [(1, 0), (-1, 0), (0, 1), (0, -2), (0.6, -0.8)])
@pytest.mark.parametrize("against", [None, RUBBER])
def test_products_are_differences_of_displacements_ahead(rule, towards, against):
    n, reach = 8, 2
    body = fc.HalfSpace(STEEL, (2.0, 3.0), (n + 2 * reach, n + 2 * reach), against=against).compliance
    whole = tangential_compliance(body, (slice(0, n + 2 * reach),) * 2)
    axes = RollingStep(force=1.0, towards=towards).axes
    rolling = RollingFriction(body, MU, 1e-8, axes=axes, rule=rule).compliance(0, (n, n))
    rng = np.random.default_rng(1)
    q, p = rng.normal(size=(2, n, n)), rng.normal(size=(n, n))
    inner = (slice(reach, -reach),) * 2
    Q, P = np.zeros((2, *whole.shape)), np.zeros(whole.shape)
    Q[:, *inner], P[inner] = q, p
    for u, found in ((whole.apply(Q), rolling.apply(q)), (whole.of_pressure(P), rolling.of_pressure(p))):
        expected = np.zeros((2, n, n))
        for axis, cosine in enumerate(axes[0]):
            for ahead, weight in enumerate(RULES[rule][0]):
                moved = np.roll(u, -ahead * int(np.sign(cosine)), axis + 1)[:, *inner]
                expected += abs(cosine) / body.grid.cell[axis] * weight * moved
        np.testing.assert_allclose(found, expected, atol=1e-12 * max(np.abs(u).max(), 1e-300) / min(body.grid.cell))
    assert np.vdot(q, rolling.apply(q)) > 0


def test_figures_and_signs_of_contact():
    """Case 1 of its example fastsim, as printed in its file fastsim.ref_out of 2023, by its rule."""
    G, nu, FN = 82000.0, 0.28, 82000.0
    steel = fc.Material(E=2 * G * (1 + nu), nu=nu)
    body = fc.HalfSpace(steel, (17.6, 8.8), (44, 44), against=steel)
    surface = Paraboloid(1 / (2 * 0.8464e-3), 1 / (2 * 0.2406e-2))
    options = {"force": FN, "friction": 0.3, "creepage": (0.0, -6.25e-4), "spin": 6.25e-4}
    theirs = body.roll(surface, rule="contact", **options)
    assert theirs.max_pressure == pytest.approx(1223, abs=1.5)
    assert -theirs.tangential[1] / (0.3 * FN) == pytest.approx(-0.6074, abs=1e-4)
    assert abs(theirs.tangential[0]) < 1e-8 * FN
    assert -theirs.torque == pytest.approx(-4.821e4, abs=12)  # curvatures are printed to four digits
    assert -theirs.friction_work * 30 == pytest.approx(-540.4, abs=0.1)  # at 30 m/s, N m/s
    assert (int(theirs.sticking.sum()), int(theirs.active.sum())) == (356, 1276)
    assert theirs.residuals.within(1e-8)


def test_turned_axes_and_surfaces_give_turned_answers():
    options = {"creepage": (6e-3, -3e-3), "spin": 0.08}
    one = rolled(**options)
    other = rolled(half(turned=True), Paraboloid(0.6, 1.0), towards=(0, 3), **options)
    back = rolled(towards=(-1, 0), **options)
    for found, turn in ((other, 1), (back, 2)):
        vectors = np.rot90(found.traction, -turn, axes=(1, 2))  # rot90 turns x to -y of arrays
        x, y = {1: (vectors[1], -vectors[0]), 2: (-vectors[0], -vectors[1])}[turn]
        scale = np.abs(one.traction).max()
        assert np.abs(np.stack([x, y]) - one.traction).max() < 1e-7 * scale
        np.testing.assert_allclose(found.tangential, one.tangential, atol=1e-9 * MU * FORCE)
        assert found.torque == pytest.approx(one.torque, abs=1e-9 * MU * FORCE * 0.1)
        across = one.heat_per_area[::-1]  # the left of rolling is -x in one, -y in the other
        np.testing.assert_allclose(found.heat_per_area, across, atol=1e-8 * across.max())


def test_mirrored_creepage_gives_mirrored_tractions():
    one, other = rolled(creepage=(3e-3, 6e-3), spin=0.1), rolled(creepage=(3e-3, -6e-3), spin=-0.1)
    np.testing.assert_allclose(other.tangential, np.array([1, -1]) * one.tangential, atol=1e-9 * MU * FORCE)
    np.testing.assert_allclose(other.slip[0], one.slip[0][:, ::-1], atol=1e-9)


def test_other_directions_lie_within_the_error():
    """A ball has no direction: what rolls along another one differs by no more than both errors."""
    body = fc.HalfSpace(STEEL, (0.2, 0.2), (32, 32), against=STEEL)
    one, other = (
        body.roll(Paraboloid(1.0), force=FORCE, friction=MU, creepage=(3e-3, 6e-3), spin=0.08, towards=t)
        for t in ((1, 0), (1, 0.7))
    )
    change = np.hypot(*np.subtract(one.tangential, other.tangential))
    assert 0 < change < one.rolling_error.force + other.rolling_error.force


def test_no_units():
    length, stress = 1e3, 7e-4
    body = half()
    one = rolled(body, creepage=(4e-3, None), tangential=(None, 2e-5), spin=0.08)
    material = fc.Material(E=stress, nu=0.28)
    large = fc.HalfSpace(material, (0.22 * length, 0.176 * length), body.grid.shape, against=material)
    other = large.roll(
        Paraboloid(length, 0.6 * length), force=FORCE * stress * length**2, friction=MU, creepage=(4e-3, None),
        tangential=(None, 2e-5 * stress * length**2), spin=0.08 / length,
    )  # fmt: skip
    np.testing.assert_allclose(other.traction / stress, one.traction, atol=1e-9 * one.max_pressure)
    np.testing.assert_allclose(other.creepage, one.creepage, atol=1e-9 * 1e-3)
    assert other.friction_work / (stress * length**2) == pytest.approx(one.friction_work, rel=1e-9)
    assert other.rolling_error.traction == pytest.approx(one.rolling_error.traction, rel=1e-3)  # of tolerance 1e-4


def test_forces_give_the_creepages_back():
    one = rolled(creepage=(3e-3, -6e-3), spin=0.1)
    fx, fy = one.tangential
    for options in (
        {"tangential": (fx, fy)},
        {"creepage": (3e-3, None), "tangential": (None, fy)},
        {"creepage": (None, -6e-3), "tangential": (fx, None)},
    ):
        other = rolled(spin=0.1, **options)
        np.testing.assert_allclose(other.creepage, (3e-3, -6e-3), atol=1e-8)
        np.testing.assert_allclose(other.tangential, (fx, fy), atol=1e-9 * MU * FORCE)
    near = rolled(spin=0.1, creepage=(3e-3, -5.9e-3), start=one)
    assert near.tangential_solver.newton <= one.tangential_solver.newton


@pytest.mark.parametrize("share", [0.9, 0.99])
def test_forces_near_sliding(share):
    found = rolled(tangential=(-share * MU * FORCE, 0.0))
    assert found.tangential[0] == pytest.approx(-share * MU * FORCE, rel=1e-9)
    assert found.creepage[0] < 0
    assert found.residuals.within(1e-8)


def test_free_rolling_of_like_and_unlike_bodies():
    free = rolled()
    assert not free.traction.any()
    assert free.friction_work == 0
    assert free.creepage == (0.0, 0.0)
    spinning = rolled(spin=0.1)
    np.testing.assert_allclose(spinning.tangential, 0.0, atol=1e-9 * MU * FORCE)
    assert abs(spinning.creepage[1]) > 1e-4
    assert spinning.friction_work > 0
    # unlike bodies micro-slip without a force (Johnson, Contact Mechanics, section 8.2), and creep
    unlike = rolled(half(against=RUBBER))
    assert unlike.traction.any()
    assert unlike.tangential_solver.staggered > 1
    assert unlike.residuals.within(1e-8)
    np.testing.assert_allclose(unlike.tangential, 0.0, atol=1e-9 * MU * FORCE)


def test_work_of_friction_is_that_of_forces_on_creepages():
    found = rolled(half(n=40), creepage=(6e-3, -3e-3), spin=0.1)
    assert found.creep_work == pytest.approx(found.friction_work, rel=0.06)
    assert found.heat_per_area.sum() * found.grid.cell[1] == pytest.approx(found.friction_work, rel=1e-12)
    assert (found.work_density >= -1e-8 * found.work_density.max()).all()
    worn = found.worn_per_pass(2e-9)  # Archard's k times pressure and slip: by the work, k over mu
    assert worn.sum() * found.grid.cell[1] == pytest.approx(2e-9 / MU * found.friction_work, rel=1e-12)
    with pytest.raises(InputError, match="coefficient of wear"):
        found.worn_per_pass(0.0)


def test_a_wheel_that_slides_wears_its_track_as_an_ellipse_of_pressures():
    """Hertz's ball sliding by c of its way: k c int p dx = k c pi/2 p0 a (1 - y^2/a^2), volume per length k c F."""
    found = rolled(half(n=48), Paraboloid(0.8), creepage=(0.5, 0.0), friction=1e-3)
    y = found.grid.y
    worn, peak = found.worn_per_pass(1.0) / 0.5, found.max_pressure
    a = (1.5 * found.force / (np.pi * peak)) ** 0.5
    np.testing.assert_allclose(worn, np.pi / 2 * peak * a * np.maximum(0, 1 - (y / a) ** 2), atol=0.03 * peak * a)
    assert worn.sum() * found.grid.cell[1] == pytest.approx(found.force, rel=2e-3)


def test_full_sliding_is_that_of_rigid_bodies():
    """At large creepages the slip is the rigid one: tractions mu p along it."""
    found = rolled(creepage=(0.3, 0.4))
    np.testing.assert_allclose(found.traction, MU * np.multiply.outer([0.6, 0.8], found.pressure), atol=2e-2 * MU)
    np.testing.assert_allclose(found.tangential, (0.6 * MU * FORCE, 0.8 * MU * FORCE), rtol=2e-2)


def test_a_layer_of_the_same_material_changes_nothing():
    layered = half(against=None, layers=(fc.Layer(STEEL, 0.05),))
    plain = rolled(half(against=None), creepage=(3e-3, 6e-3), spin=0.08)
    found = rolled(layered, creepage=(3e-3, 6e-3), spin=0.08)
    np.testing.assert_allclose(found.tangential, plain.tangential, rtol=1e-5)
    soft = rolled(half(against=None, layers=(fc.Layer(RUBBER, 0.05),)), creepage=(3e-3, 6e-3), spin=0.08)
    assert np.hypot(*soft.tangential) < np.hypot(*plain.tangential)
    assert soft.residuals.within(1e-8)


def test_the_error_estimate_holds_and_shrinks():
    options = {"creepage": (3e-3, -6e-3), "spin": 0.1}
    coarse, fine = (
        fc.HalfSpace(STEEL, (0.2, 0.16), (n, n), against=STEEL).roll(BALL, force=FORCE, friction=MU, **options)
        for n in (28, 112)
    )
    q = fine.traction.reshape(2, 28, 4, 28, 4).mean(axis=(2, 4))
    true = np.linalg.norm(coarse.traction - q) / np.linalg.norm(q)
    assert 0.8 < coarse.rolling_error.traction / true < 3
    off = np.hypot(*np.subtract(coarse.tangential, fine.tangential))
    assert 0.5 * off < coarse.rolling_error.force
    assert fine.rolling_error.traction < 0.6 * coarse.rolling_error.traction
    assert coarse.rolling_error.creepage == 0
    by_force = rolled(tangential=(2e-5, 0.0))
    assert by_force.rolling_error.force == 0 < by_force.rolling_error.creepage


def test_an_estimate_without_convergence_is_told(monkeypatch):
    options = {"creepage": (3e-3, -6e-3), "spin": 0.1}
    one = rolled(**options)
    assert not any("did not converge" in text for text in one.warnings)
    monkeypatch.setattr(rolling, "COARSE_TOLERANCE", 0.0)
    monkeypatch.setattr(tresca, "MAX_ROUNDS", 1)
    other = rolled(half(n=12), **options)
    assert any("did not converge" in text for text in other.warnings)
    assert "did not converge" in str(other)


def test_results_print_save_draw_and_have_stresses(tmp_path):
    found = rolled(creepage=(3e-3, 6e-3), spin=0.08)
    text = str(found)
    assert "creepage along" in text
    assert "tractions: about" in text
    assert "work of friction" in text
    summary = found.summary()
    assert summary["creepage"] == (3e-3, 6e-3)
    assert set(summary["rolling_error"]) == {"traction", "force", "torque", "creepage", "coarse_defect"}
    saved = np.load(found.save(tmp_path / "rolling.npz"))
    np.testing.assert_allclose(saved["slip_x"], found.slip[0])
    assert found.save(tmp_path / "rolling.json").stat().st_size > 100
    assert found.plot(tmp_path / "rolling.png") is not None
    assert found.stress([[0.0, 0.0, -0.01]]).shape == (1, 6)


def test_what_is_wrong_is_refused():
    body = half()
    with refused(InputError, "one-of", "creepage"):
        rolled(creepage=(1e-3, 0.0), tangential=(0.0, None))
    with refused(InputError, "one-of"):
        body.roll(BALL, friction=MU)
    with refused(InputError, "slides-as-a-whole", "creepage"):
        rolled(tangential=(1.1 * MU * FORCE, 0.0))
    for friction in ((0.3, 0.2, 0.1), np.full((20, 16), 0.3)):
        with refused(InputError, "friction-isotropic"):
            rolled(friction=friction)
    with refused(InputError, "friction-too-unlike"):
        rolled(friction=(0.3, 1e-4))
    for law in (lambda slip: 0.3, lambda slip: -slip, lambda slip: 1 / slip):
        with refused(InputError, "friction-of-slip"), np.errstate(divide="ignore"):
            rolled(friction=law)
    with refused(InputError, "slides-as-a-whole", "(0, 1)", "above 0.33"):  # of the larger coefficient
        rolled(friction=(0.3, 0.1), tangential=(0.0, 1.1 * 0.1 * FORCE), towards=(0.6, 0.8))
    with refused(InputError, "friction-too-unlike"):
        fc.FallingFriction(0.3, 0.2, 1e-3, across=1e-4)
    with pytest.raises(InputError, match="static >= kinetic"):
        fc.FallingFriction(0.2, 0.3, 1e-3)
    with refused(InputError, "other-grid"):
        rolled(half(n=24), start=rolled())
    with refused(InputError, "rolling-periodic"):
        rolled(fc.HalfSpace(STEEL, (1.0, 1.0), (8, 8), periodic=True))
    with pytest.raises(InputError, match="direction of rolling"):
        rolled(towards=(0, 0))
    with pytest.raises(InputError, match="rule"):
        rolled(rule="central")
    with pytest.raises(InputError, match="two numbers"):
        rolled(creepage=1e-3)
    with pytest.raises(InputError, match="axis of the grid"):
        _ = rolled(towards=(1, 1)).heat_per_area
    along = rolled(towards=(np.cos(np.pi / 2), 1.0), creepage=(6e-3, 0.0))  # 6e-17 of an axis is rounding
    assert along.heat_per_area.shape == (20,)
    assert rolled(friction=0.0).rolling_error.traction == 0


def test_creep_coefficients_are_the_limit_of_small_creepages():
    body = half(n=32)
    found = body.creep_coefficients(BALL, force=FORCE)
    creepage, spin = (1e-3, 2e-3), 0.03
    sticking = rolled(body, friction=np.inf, creepage=creepage, spin=spin)
    *forces, torque = found.forces(creepage, spin)
    np.testing.assert_allclose(forces, sticking.tangential, rtol=0.03)  # C23 and C32 differ by the cells
    assert torque == pytest.approx(sticking.torque, rel=0.15)
    small = rolled(body, creepage=tuple(1e-3 * np.array(creepage)), spin=1e-3 * spin)
    np.testing.assert_allclose(1e3 * np.array(small.tangential), forces, rtol=0.06)
    assert max(found.errors) < 0.2
    assert "C11" in str(found)


def test_creep_coefficients_do_not_depend_on_units_direction_and_stiffness():
    one = half().creep_coefficients(BALL, force=FORCE)
    material = fc.Material(E=50.0, nu=0.28)
    size, cells = (1.76, 2.2), (16, 20)
    turned = fc.HalfSpace(material, size, cells, against=material)
    other = turned.creep_coefficients(Paraboloid(6.0, 10.0), force=50 * 100 * FORCE, towards=(0, -1))
    for name in ("c11", "c22", "c23", "c33"):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-6)
    rigid = half(against=None).creep_coefficients(BALL, force=2 * FORCE)  # twice as stiff: the same contact
    assert rigid.c11 == pytest.approx(one.c11, rel=1e-6)
    assert rigid.shear_modulus == pytest.approx(2 * one.shear_modulus)


def test_a_creep_curve_is_its_points(tmp_path):
    curve = half().creep_curve(BALL, [2e-3, 6e-3], spins=(0.0, 0.1), force=FORCE, friction=MU)
    assert len(curve) == 4
    np.testing.assert_array_equal(curve.spin, [0, 0, 0.1, 0.1])
    lone = rolled(creepage=(6e-3, 0.0), spin=0.1)
    np.testing.assert_allclose(curve.tangential[3], lone.tangential, atol=1e-8 * MU * FORCE)
    assert (np.diff(curve.tangential[:2, 0]) > 0).all()
    assert "stick_share" in str(curve)
    assert "force_along" in curve.save(tmp_path / "curve.csv").read_text()
    assert curve.plot(tmp_path / "curve.png") is not None
    lateral = half().creep_curve(BALL, [(0.0, 2e-3)], force=FORCE, friction=MU, towards=(0, 1))
    assert lateral.tangential[0, 1] > 0
    for given in ({"creepage": (1e-3, 0.0)}, {"spin": 0.1}):
        with refused(InputError, "unknown-option"):
            half().creep_curve(BALL, [2e-3], force=FORCE, friction=MU, **given)
    with refused(InputError, "wrong-shape", "spins of a curve"):
        half().creep_curve(BALL, [2e-3], spins=[[0.1, 0.2]], force=FORCE, friction=MU)
    with refused(InputError, "wrong-shape", "creepages of a curve"):
        half().creep_curve(BALL, np.ones((2, 3)), force=FORCE, friction=MU)


@pytest.mark.parametrize("against", [STEEL, RUBBER])
def test_creep_curves_go_on_from_their_file(tmp_path, monkeypatch, against):
    """Points of the file are certified, not solved; pressures are solved for once; another curve is refused."""
    body, file = half(against=against), tmp_path / "curve.jsonl"
    options = {"spins": (0.0, 0.1), "force": FORCE, "friction": MU}
    one = body.creep_curve(BALL, [2e-3, 6e-3], **options, path=file)
    rows = file.read_text().splitlines()
    file.write_text("\n".join(rows[:3]) + "\n")
    solved, pressed = [], []
    roll, press = creep.roll, creep.press
    monkeypatch.setattr(creep, "roll", lambda *given: solved.append(1) or roll(*given))
    monkeypatch.setattr(creep, "press", lambda *given: pressed.append(1) or press(*given))
    other = body.creep_curve(BALL, [2e-3, 6e-3], **options, path=file)
    assert (len(solved), len(pressed)) == (1, 1)
    np.testing.assert_allclose(other.tangential, one.tangential, atol=1e-9 * MU * FORCE)
    np.testing.assert_allclose(other[1].slip, one[1].slip, atol=1e-12)
    assert other[0].rolling_error == one[0].rolling_error
    with refused(InputError, "row-of-another", "friction"):
        body.creep_curve(BALL, [2e-3, 6e-3], **{**options, "friction": 0.2}, path=file)


def test_a_path_goes_on_from_steady_rolling():
    """By CONTACT's rule steps of one cell are the steady state; by the other rule they leave it by the rules' error."""
    body = half(n=24)
    cell, pull = body.grid.cell[0], (0.6 * MU * FORCE, 0.0)
    steps = [fc.PressStep(force=FORCE, tangential=pull, position=(k * cell, 0.0)) for k in (1, 2)]
    for rule, most in (("contact", 1e-7), ("blended", 0.05)):
        steady = rolled(body, tangential=pull, rule=rule)
        path = body.press_path(BALL, steps, MU, start=steady)
        creep = np.diff(path.shift[:, 0], prepend=0) / cell
        np.testing.assert_allclose(creep, steady.creepage[0], rtol=most)
    assert abs(creep[1] - steady.creepage[0]) > 1e-3 * steady.creepage[0]
    again = body.press_path(BALL, steps[1:], MU, start=path[0])
    np.testing.assert_allclose(again.shift, path.shift[1:], atol=1e-9)
    with refused(InputError, "other-grid", "friction"):
        body.press_path(BALL, steps, 2 * MU, start=steady)
    with refused(InputError, "other-grid"):
        half().press_path(BALL, steps, MU, start=steady)
    with refused(InputError, "wrong-class"):
        body.press_path(BALL, steps, MU, start=body.press(BALL, force=FORCE))


def test_a_track_stays_where_it_is(tmp_path):
    """A track as the surface's own shape, turned over, is the same; a bump is passed and left behind."""
    body, file = half(n=24), tmp_path / "path.jsonl"
    cell, bump = body.grid.cell[0], 6e-5 * np.exp(-(((half(n=24).grid.x[:, None] - 0.03) / 0.01) ** 2))
    track = np.broadcast_to(bump, body.grid.shape)
    where = [(float(x), 0.0) for x in cell * np.arange(-2, 3)]
    steps = [fc.PressStep(force=FORCE, tangential=(0.3 * MU * FORCE, 0.0), position=x) for x in where]
    path = body.press_path(BALL, steps, MU, track=track, path=file)
    x, y = body.grid.x[:, None], body.grid.y
    z = BALL.heights(x - where[2][0], y) - track
    # closer than by default, 1e-8 of the displacement, which the pressures of single cells amplify
    alone = body.press(z, force=FORCE, tolerance=1e-10)
    assert path[2].max_pressure == pytest.approx(alone.max_pressure, rel=1e-8)
    assert path[4].max_pressure > 1.01 * body.press_path(BALL, steps[4:], MU).last.max_pressure
    with refused(InputError, "row-of-another", "heights"):
        body.press_path(BALL, steps, MU, path=file)


def test_pictures_of_creep_curves_have_the_side_of_the_creepage():
    across = [(c, -c) for c in (-6e-3, -2e-3, 2e-3, 6e-3)]
    curve = half().creep_curve(BALL, across, force=FORCE, friction=MU)
    x = curve.plot().axes[0].lines[0].get_xdata()
    np.testing.assert_allclose(x, np.sqrt(2) * np.array([-6e-3, -2e-3, 2e-3, 6e-3]), atol=1e-12)
    force = curve.plot().axes[0].lines[0].get_ydata()
    assert (np.diff(force) > 0).all()  # a signed force: no V
    np.testing.assert_allclose(force, -force[::-1], atol=1e-7)
    sticking = half().creep_curve(BALL, [2e-3], force=FORCE, friction=np.inf).plot().axes[0]
    assert sticking.lines[0].get_ydata()[0] > 0  # infinite friction has no limit to be drawn over


def test_a_start_from_another_load_changes_nothing():
    """Neither the answer nor its errors, though its pressures are others."""
    one, far = rolled(creepage=(3e-3, -6e-3)), rolled(force=2 * FORCE, creepage=(6e-3, 0.0))
    other = rolled(creepage=(3e-3, -6e-3), start=far)
    np.testing.assert_allclose(other.traction, one.traction, atol=1e-7 * one.max_pressure)
    assert other.rolling_error.traction == pytest.approx(one.rolling_error.traction, rel=1e-3)


SPINNING = {"creepage": (6e-3, -3e-3), "spin": 0.08}


@pytest.mark.parametrize("towards", [(1, 0), (0.6, -0.8)])
def test_equal_coefficients_and_constant_laws_are_coulombs(towards):
    one = rolled(towards=towards, **SPINNING)
    for friction in ((MU, MU * (1 - 1e-12)), lambda slip: MU + 0 * slip, fc.FallingFriction(MU, MU, 1e-3)):
        other = rolled(friction=friction, towards=towards, **SPINNING)
        np.testing.assert_allclose(other.traction, one.traction, atol=1e-9 * one.max_pressure)
        assert other.stick_area == pytest.approx(one.stick_area, rel=1e-6)
        assert other.rolling_error.traction == pytest.approx(one.rolling_error.traction, rel=1e-6)
        np.testing.assert_allclose(other.sliding_integral, one.sliding_integral, atol=1e-7 * one.max_pressure)


@pytest.mark.parametrize("towards", [(1, 0), (0, -1), (0.6, -0.8)])
@pytest.mark.parametrize("against", [STEEL, RUBBER])
def test_unlike_coefficients_slip_normal_to_their_ellipse(towards, against):
    """t_k = -mu_k^2 s_k p / |mu s| where it slips, within the ellipse where it sticks, whatever the axes."""
    mu = np.array([0.3, 0.15])
    found = rolled(half(against=against), friction=tuple(mu), towards=towards, **SPINNING)
    axes = RollingStep(force=1.0, towards=towards).axes
    t, s = (np.tensordot(axes, v, 1) for v in (found.traction, found.slip))
    at = found.slipping
    assert 0 < at.sum() < found.active.sum()
    rate = np.hypot(*(mu[:, None, None] * s))[at]
    exact = mu[:, None] ** 2 * s[:, at] * found.pressure[at] / rate
    close = rate > 1e-5 * rate.max()  # directions of the least slips are rounding
    np.testing.assert_allclose(-t[:, at][:, close], exact[:, close], atol=1e-5 * found.max_pressure)
    assert (np.hypot(*(t / mu[:, None, None])) <= found.pressure + 1e-9 * found.max_pressure).all()
    assert np.abs(s[:, found.sticking]).max() < 1e-7
    assert found.residuals.within(1e-8)
    assert "along the rolling" in str(found)


def test_unlike_coefficients_turn_with_the_rolling():
    one = rolled(friction=(0.3, 0.15), **SPINNING)
    other = rolled(half(turned=True), Paraboloid(0.6, 1.0), friction=(0.3, 0.15), towards=(0, 3), **SPINNING)
    np.testing.assert_allclose(other.tangential, one.tangential, atol=1e-9 * MU * FORCE)
    fx, fy = one.tangential
    held = rolled(friction=(0.3, 0.15), tangential=(fx, fy), spin=SPINNING["spin"])
    np.testing.assert_allclose(held.creepage, SPINNING["creepage"], atol=1e-7)


def test_full_sliding_has_the_friction_of_its_slip():
    """At large creepages slip is the rigid one: tractions mu(creepage) p, or on the ellipse."""
    law = fc.FallingFriction(0.4, 0.2, 0.5, "rational")
    found = rolled(friction=law, creepage=(0.3, 0.4))
    assert np.hypot(*found.tangential) == pytest.approx(0.3 * FORCE, rel=1e-2)
    lay = rolled(friction=(0.3, 0.15), creepage=(0.3, 0.4))
    exact = np.array([0.09 * 0.3, 0.0225 * 0.4]) / np.hypot(0.09, 0.06)
    np.testing.assert_allclose(lay.tangential, exact * FORCE, rtol=2e-2)


@pytest.mark.parametrize(("against", "towards"), [(STEEL, (1, 0)), (RUBBER, (0.6, -0.8))])
def test_friction_that_falls_and_differs_by_direction(against, towards):
    """t_k = -mu_k^2 s_k p / |mu s| where it slips, with coefficients of that slip; far, as of rigid bodies."""
    law = fc.FallingFriction(MU, 0.18, 5e-3, across=0.5)
    found = rolled(half(against=against), friction=law, towards=towards, **SPINNING)
    axes = RollingStep(force=1.0, towards=towards).axes
    t, s = (np.tensordot(axes, v, 1) for v in (found.traction, found.slip))
    mu = np.multiply.outer([1.0, 0.5], law(np.hypot(*s)))
    at, rate = found.slipping, np.hypot(*(mu * s))
    close = at & (rate > 1e-3 * rate.max())
    exact = (mu**2 * s * found.pressure / np.maximum(rate, 1e-300))[:, close]
    np.testing.assert_allclose(-t[:, close], exact, atol=1e-5 * found.max_pressure)
    assert (np.hypot(*(t / mu)) <= found.pressure + 1e-7 * found.max_pressure).all()
    assert 0 < close.sum() <= at.sum() < found.active.sum()
    assert found.residuals.within(1e-8)
    assert "0.15 to its left without slip" in str(found)
    slides = rolled(friction=fc.FallingFriction(0.4, 0.2, 0.5, "rational", across=0.5), creepage=(0.3, 0.4))
    rigid = 0.3 * np.array([0.3, 0.25 * 0.4]) / np.hypot(0.3, 0.5 * 0.4)
    np.testing.assert_allclose(slides.tangential, rigid * FORCE, rtol=2e-2)


@pytest.mark.parametrize("law", ["exponential", "rational", "linear"])
def test_falling_friction_is_that_of_its_own_slip(law):
    of = fc.FallingFriction(MU, 0.18, 5e-3, law)
    assert of(0.0) == MU
    assert of(5e-3) == pytest.approx(0.24)
    found = rolled(friction=of, **SPINNING)
    limit = of(np.hypot(*found.slip)) * found.pressure
    np.testing.assert_allclose(np.hypot(*found.traction)[found.slipping], limit[found.slipping], atol=1e-7)
    assert (np.hypot(*found.traction) <= limit + 1e-8 * found.max_pressure).all()
    assert 0 < found.sticking.sum() < found.active.sum()
    assert found.residuals.within(1e-8)
    assert found.also is None
    assert "without slip" in str(found)
    assert 0.4 < found.rolling_error.traction / rolled(**SPINNING).rolling_error.traction < 3
    with refused(InputError, "no-heat"):
        found.flash_temperature((1.0, 0.0), conductivity=1.0, diffusivity=1.0)


def test_friction_whose_limits_do_not_settle_by_themselves():
    """Here limits of the slip before go to and fro for ever: Newton's method finds the answer."""
    found = rolled(half(n=44), friction=fc.FallingFriction(MU, 0.18, 5e-3, "linear"), **SPINNING)
    assert found.residuals.within(1e-8)
    assert found.tangential[0] == pytest.approx(0.12939648 * FORCE, rel=1e-6)


def test_several_solutions_of_falling_friction_are_told(tmp_path):
    """Steep falls have one solution from the friction without slip and another from sliding; gentle ones have one."""
    steep = fc.FallingFriction(MU, 0.03, 3e-5)
    found = rolled(friction=steep, creepage=(3e-3, 0.0))
    assert found.also is not None
    assert found.also[0] < found.tangential[0] - 1e-3 * MU * FORCE
    assert any("several solutions" in text for text in found.warnings)
    # a force above what sliding holds is held by the same creepage, or transmitted by a larger one
    held = rolled(friction=fc.FallingFriction(MU, 0.1, 2e-2), tangential=(0.12 * FORCE, 0.0))
    assert any("larger creepage" in text for text in held.warnings)
    assert not rolled(friction=fc.FallingFriction(MU, 0.1, 2e-2), tangential=(0.05 * FORCE, 0.0)).warnings
    options = {"force": FORCE, "friction": steep, "path": tmp_path / "curve.jsonl"}
    one, other = (half().creep_curve(BALL, [3e-3], **options) for _ in range(2))
    assert one.last.also == pytest.approx(other.last.also)
    assert one.warnings == other.warnings
    with refused(InputError, "row-of-another", "friction"):
        half().creep_curve(BALL, [3e-3], **{**options, "friction": fc.FallingFriction(MU, 0.03, 4e-5)})


def test_figures_of_contact_with_falling_friction():
    """The first case of its example veldep_fric, as printed in its file veldep_fric.ref_out of 2025, by its rule."""
    G, nu, force, dx = 82000.0, 0.28, 622216.0, 0.1
    steel = fc.Material(E=2 * G * (1 + nu), nu=nu)
    body = fc.HalfSpace(steel, (92 * dx, 800.0), (92, 4), against=steel)
    z = np.full((92, 4), np.inf)
    z[:, 1] = (body.grid.x - dx / 2) ** 2 / 2 / 460  # one cell of 200 across, with a middle of a cell below the axle
    law = fc.FallingFriction(0.3, 0.18, 100 / 45000)
    found = body.roll(z, force=force, friction=law, creepage=(9.999e-4, 0.0), rule="contact")
    assert found.tangential[0] / (0.3 * force) == pytest.approx(0.5941, abs=5e-5)
    assert found.friction_work * 45 == pytest.approx(4849, abs=0.5)  # at 45 m/s
    assert found.max_pressure == pytest.approx(495.3, abs=0.05)
    assert (int(found.sticking.sum()), int(found.active.sum())) == (45, 81)
