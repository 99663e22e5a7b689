"""Pressures up to a hardness: dents, certificate, reloading, friction, curves and refusals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.app.cli import main
from fecontact.halfspace.hardness import with_hardness
from fecontact.halfspace.pressing import Load, normal_residuals
from fecontact.solvers.coulomb import Residuals, ResidualScales

PLAIN = fc.Material(E=1.0, nu=0.0)
BALL = fc.surfaces.Paraboloid(1.0)


@pytest.fixture(scope="module")
def rough() -> np.ndarray:
    """Every second cell of a self-affine surface of 512 x 512 cells."""
    z = fc.surfaces.self_affine((512, 512), size=(1, 1), hurst=0.8, rms_slope=0.08, shortest=8 / 512, seed=1).z
    return np.asarray(z[::2, ::2])


def periodic(n: int) -> fc.HalfSpace:
    return fc.HalfSpace(PLAIN, size=(1.0, 1.0), cells=(n, n), periodic=True)


def free(n: int = 48, **options: object) -> fc.HalfSpace:
    return fc.HalfSpace(PLAIN, size=(3.0, 3.0), cells=(n, n), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(("mean", "area"), [(0.04, 0.74289), (0.07, 0.94376), (0.09, 0.99086)])
def test_rough_areas_are_those_of_another_program(rough: np.ndarray, mean: float, area: float) -> None:
    """ContactMechanics 1.8.3, `PlasticNonPeriodic...` of the same cells: cells that touch, to all its digits."""
    contact = periodic(256).press(rough, force=mean, hardness=0.1)
    assert round(float(contact.active.mean()), 5) == area
    assert contact.residuals.worst < 1e-8
    assert contact.max_pressure == 0.1


def test_a_hardness_that_is_not_reached_changes_no_bit(rough: np.ndarray) -> None:
    half, z = periodic(128), rough[::2, ::2]
    elastic = half.press(z, force=0.04)
    for hardness in (np.inf, 2 * elastic.max_pressure):
        hard = half.press(z, force=0.04, hardness=hardness)
        assert (hard.pressure == elastic.pressure).all()
        assert hard.dent is not None
        assert not hard.dent.any()
        assert hard.plastic_area == 0


@pytest.mark.parametrize("change", [0.0, 1e-15, -1e-15, 1e-13])
def test_rounding_does_not_decide_what_yields(change: float) -> None:
    """A hardness that is the largest elastic pressure: what is above it by rounding does not yield."""
    half = free()
    elastic = half.press(BALL, force=0.5)
    hard = half.press(BALL, force=0.5, hardness=elastic.max_pressure * (1 + change))
    assert hard.plastic is not None
    assert not hard.plastic.any()


def test_pressed_again_on_its_dent_it_is_elastic(rough: np.ndarray) -> None:
    half, z = periodic(128), rough[::2, ::2]
    first = half.press(z, force=0.06, hardness=0.1, tolerance=1e-10)
    assert first.dent is not None
    assert first.plastic is not None
    assert first.plastic.mean() > 0.2
    again = half.press(z + first.dent, force=0.06, tolerance=1e-10)
    assert np.abs(again.pressure - first.pressure).max() < 1e-8 * 0.1
    assert abs(again.approach - first.approach) < 1e-9 * first.displacement.max()
    hard = half.press(z + first.dent, force=0.06, hardness=0.1, tolerance=1e-10)
    assert hard.plastic_area == 0


def test_a_soft_surface_is_cut_by_the_counter_surface(rough: np.ndarray) -> None:
    """The limit of no elasticity: area force over hardness, cells those of the lowest heights (bearing area)."""
    half, z = periodic(128), rough[::2, ::2]
    for share in (0.1, 0.4):
        hardness = 2e-4
        contact = half.press(z, force=share * hardness, hardness=hardness)
        lowest = z <= np.quantile(z, share)
        assert abs(contact.active.mean() - share) < 0.002
        assert (contact.active != lowest).mean() < 0.005
        height = z[contact.plastic].max()
        assert abs(contact.approach - height) < 0.01 * np.ptp(z)


def test_the_certificate_sees_both_bounds() -> None:
    found, scales = Residuals(0.0, 0.0, 0.0, 0.0), ResidualScales(force=1.0, gap=1.0, point=1.0)
    p, hardness = np.array([[0.0, 1.0, 0.5]]), np.ones((1, 3))
    good = with_hardness(found, p, np.array([[0.0, 0.3, 0.0]]), hardness, scales)
    assert good.worst == 0.0
    assert with_hardness(found, p, np.array([[0.0, 0.3, 0.2]]), hardness, scales).complementarity == 0.2
    assert with_hardness(found, p, np.array([[0.0, -0.3, 0.0]]), hardness, scales).penetration == 0.3
    above = with_hardness(found, p + 0.1, np.zeros((1, 3)), hardness, scales)
    assert abs(above.tension - 0.1) < 1e-15


def test_the_certificate_is_that_of_given_fields() -> None:
    half, load = free(), Load(1.0, None, None)
    contact = half.press(BALL, force=1.0, hardness=0.3)
    z = half.heights_of(BALL)
    assert contact.dent is not None
    assert normal_residuals(half.compliance, z, load, contact).worst < 1e-8
    for wrong in (replace(contact, dent=1.01 * contact.dent), replace(contact, hardness=0.99 * contact.hardness)):
        assert normal_residuals(half.compliance, z, load, wrong).worst > 1e-6


@pytest.mark.parametrize("options", [{}, {"symmetry": False}, {"load_point": (0.01, 0.0)}])
def test_a_ball_yields_first_where_hertz_has_its_peak(options: dict[str, object]) -> None:
    """No dent while p0 < H; far above it F tends to H times the area 2 pi R (approach) of the plane cut."""
    half, peak = free(), fc.hertz.spheres((1.0, np.inf), (PLAIN, fc.Material(E=1e9, nu=0.0)), force=0.5).p0
    assert half.press(BALL, force=0.5, hardness=1.02 * peak, **options).plastic_area == 0  # type: ignore[call-overload]
    hard = half.press(BALL, force=0.5, hardness=0.9 * peak, **options)  # type: ignore[call-overload]
    assert hard.plastic.any()
    assert np.hypot(half.grid.x[:, None], half.grid.y[None])[hard.plastic].max() < 0.6 * hard.moment_radius()
    assert hard.pressure.max() == 0.9 * peak
    assert abs(hard.force - 0.5) < 1e-12


def test_hardness_of_each_cell_and_symmetry() -> None:
    """Softer on one side: not symmetric, and the dent is larger there."""
    half = free()
    field = np.where(half.grid.x[:, None] < 0, 0.2, 0.4) * np.ones(half.grid.shape)
    contact = half.press(BALL, force=0.6, hardness=field)
    assert contact.solver.symmetric == (False, True)
    assert (contact.pressure <= field).all()
    assert contact.dent is not None
    left, right = contact.dent[:24].sum(), contact.dent[24:].sum()
    assert left > 2 * right
    assert contact.residuals.worst < 1e-8


def test_the_whole_punch_at_its_hardness_and_beyond() -> None:
    half = free(32)
    punch = np.where(np.hypot(half.grid.x[:, None], half.grid.y[None]) < 1.0, 0.0, np.inf)
    most = 0.1 * np.isfinite(punch).sum() * half.grid.area
    assert (half.press(punch, force=0.999 * most, hardness=0.1).pressure <= 0.1).all()
    with refused(fc.InputError, "force-above-hardness", f"{1.01 * most:g}", f"{most:g}"):
        half.press(punch, force=1.01 * most, hardness=0.1)


def test_a_punch_at_its_hardness_under_a_load_beside_its_middle() -> None:
    """A square punch of side 2 a, loaded b from its middle, bears H (2 a) 2 (a - b): pressures at H round the load."""
    half = free(48)
    punch = np.where(np.maximum(abs(half.grid.x[:, None]), abs(half.grid.y[None])) < 1.0, 0.0, np.inf)
    most = 0.1 * 2 * 2 * (1.0 - 0.25)
    under = half.press(punch, force=0.999 * most, hardness=0.1, load_point=(0.25, 0.0))
    assert under.residuals.worst < 1e-8
    assert abs(under.centre_of_pressure[0] - 0.25) < 1e-9
    with refused(fc.InputError, "force-above-hardness", f"{1.001 * most:g}", f"{most:g}"):
        half.press(punch, force=1.001 * most, hardness=0.1, load_point=(0.25, 0.0))
    unbounded = np.where(half.grid.x[:, None] > 0.5, np.inf, 0.1) * np.ones(48)
    assert half.press(punch, force=1.2 * most, hardness=unbounded, load_point=(0.25, 0.0)).residuals.worst < 1e-8


@pytest.mark.parametrize("seed", range(24))
def test_nearly_rigid_surfaces_that_tilt_are_solved_or_refused(seed: int) -> None:
    """Heights far above elastic displacements, hardly a cell between its bounds.

    A force F is borne if and only if sum_i H_i max(0, 1 + b x_i + c y_i) >= F for all (b, c), x and y from the load
    point (Farkas), here on a fan of these: the linear programme is checked by its dual.
    """
    r = np.random.default_rng(seed)
    n = tuple(int(c) for c in r.choice([8, 12, 16, 24], 2))
    half = fc.HalfSpace(PLAIN, size=(1.0, float(r.uniform(0.5, 2))), cells=n)
    x, y = half.grid.x[:, None], half.grid.y[None]
    kinds = (x**2 + y**2, r.standard_normal(n), x + 0.5 * y, np.zeros(n))
    z = 10 ** r.uniform(-2, 0) * kinds[seed % 4]
    z[[0, -1]] = z[:, [0, -1]] = np.inf
    hardness = 10 ** r.uniform(-3.7, -1)
    force = r.uniform(0.1, 0.95) * hardness * np.isfinite(z).sum() * half.grid.area
    point = (float(r.uniform(-0.3, 0.3)), float(r.uniform(-0.3, 0.3) * half.grid.size[1]))
    fan = np.stack([np.ones(2000), *r.standard_normal((2, 2000)) * 4])
    reach = fan[0] + np.multiply.outer(x - point[0] + 0 * y, fan[1]) + np.multiply.outer(y - point[1] + 0 * x, fan[2])
    borne = (np.maximum(reach, 0.0) * np.isfinite(z)[..., None]).sum(axis=(0, 1)) * hardness * half.grid.area
    if borne.min() < force:
        with refused(fc.InputError, "force-above-hardness"):
            half.press(z, force=force, hardness=hardness, load_point=point)
    elif borne.min() > 1.05 * force:  # of a fan, not of all
        assert half.press(z, force=force, hardness=hardness, load_point=point).residuals.worst < 1e-8


def test_what_is_no_hardness_is_refused() -> None:
    half = free(16)
    with refused(fc.InputError, "hardness-too-low", "9e-05"):
        half.press(BALL, force=0.1, hardness=9e-5)
    assert half.press(BALL, force=1e-4, hardness=1.1e-4).plastic_area > 0
    for bad in (0.0, -1.0):
        with refused(fc.InputError, "hardness-too-low"):
            half.press(BALL, force=0.1, hardness=bad)
    with refused(fc.InputError, "wrong-shape"):
        half.press(BALL, force=0.1, hardness=np.ones(16))


def test_layers_yield_at_their_top() -> None:
    stiff = fc.HalfSpace(PLAIN, size=(3.0, 3.0), cells=(48, 48), layers=[fc.Layer(fc.Material(E=4.0, nu=0.3), 0.2)])
    contact = stiff.press(BALL, force=0.6, hardness=0.35)
    assert contact.plastic_area > 0
    assert contact.dent is not None
    again = stiff.press(stiff.heights_of(BALL) + contact.dent, force=0.6)
    assert np.abs(again.pressure - contact.pressure).max() < 1e-6


def test_traction_is_at_most_friction_times_the_hardness() -> None:
    half = free()
    contact = half.press(BALL, force=1.0, friction=0.3, shift=(10.0, 0.0), hardness=0.3)
    assert contact.plastic is not None
    assert contact.plastic.any()
    assert np.abs(np.hypot(*contact.traction)[contact.plastic] - 0.09).max() < 1e-15
    assert contact.residuals.worst < 1e-10


def test_a_path_carries_the_dent_and_goes_on_from_its_file(tmp_path: Path) -> None:
    half = free(24, against=PLAIN)  # no coupling of pressures and tractions, which remember
    steps = [fc.PressStep(force=f, tangential=(0.1 * f, 0.0)) for f in (0.5, 1.0, 0.5, 1.0)]
    path = half.press_path(BALL, steps, 0.3, path=tmp_path / "path.jsonl", hardness=0.25)
    dents = [c.dent for c in path.steps]
    assert [c.plastic_area > 0 for c in path.steps] == [True, True, False, False]
    assert np.abs(dents[2] - dents[1]).max() == 0
    assert np.abs(path[3].pressure - path[1].pressure).max() < 1e-8
    assert path.figures["max_dent"][1] > path.figures["max_dent"][0] > 0
    known = half.press_path(BALL, steps, 0.3, path=tmp_path / "path.jsonl", hardness=0.25)
    assert (known.last.pressure == path.last.pressure).all()
    assert (known.last.dent == path.last.dent).all()
    with refused(fc.InputError, "row-of-another", "hardness"):
        half.press_path(BALL, steps, 0.3, path=tmp_path / "path.jsonl", hardness=0.26)


def test_a_curve_loads_and_unloads(tmp_path: Path) -> None:
    """Unloading is stiffer than loading, by the dent, and loading again meets the first curve at its end."""
    half, forces = free(), [0.4, 0.8, 1.2, 0.8, 0.4, 1.2]
    curve = half.curve(BALL, forces, hardness=0.3, path=tmp_path / "curve.jsonl")
    area, approach = curve.figures["area"], curve.approach
    assert approach[4] > 1.2 * approach[0]
    assert abs(approach[5] - approach[2]) < 1e-8 * approach[2]
    assert area[3] > area[1]
    assert (curve.figures["plastic_area"][3:] == 0).all()
    known = half.curve(BALL, forces, hardness=0.3, path=tmp_path / "curve.jsonl")
    assert (known.approach == approach).all()
    assert "plastic_area" in str(curve)


def test_units_do_not_matter() -> None:
    half = free(32)
    contact = half.press(BALL, force=1.0, hardness=0.3)
    other = fc.HalfSpace(fc.Material(E=1e6, nu=0.0), size=(3e3, 3e3), cells=(32, 32))
    scaled = other.press(fc.surfaces.Paraboloid(1e3), force=1e12, hardness=0.3e6)
    assert contact.plastic is not None
    assert (contact.plastic == scaled.plastic).all()
    assert np.abs(scaled.pressure / 1e6 - contact.pressure).max() < 1e-9


def test_the_error_is_estimated_where_a_ball_yields_and_a_punch_has_a_bound() -> None:
    """Beside 256 x 256 cells; at the outline of a punch that yields the pressure is known to be the hardness."""
    fine = free(256)
    for hardness in (0.3, 0.15):
        truth = fine.press(BALL, force=0.5, hardness=hardness).pressure.reshape(32, 8, 32, 8).mean(axis=(1, 3))
        coarse = free(32).press(BALL, force=0.5, hardness=hardness)
        error = float(np.linalg.norm(coarse.pressure - truth) / np.linalg.norm(truth))
        assert 0.8 < coarse.error_estimate.pressure / error < 8
    half = free(32)
    punch = np.where(np.hypot(half.grid.x[:, None], half.grid.y[None]) < 1.0, 0.0, np.inf)
    assert half.press(punch, force=0.1).error_estimate.unbounded is not None
    assert half.press(punch, force=0.1, hardness=0.04).error_estimate.unbounded is None


def test_a_steep_dent_is_not_taken_for_the_counter_surface() -> None:
    """Slopes are those of the counter-surface, which is flatter than the gap without its dent."""
    half = free(32)
    contact = half.press(BALL, force=0.05, hardness=0.02)
    assert contact.dent is not None
    own = half.heights_of(BALL)
    assert np.abs(contact.gap - contact.displacement - contact.dent + contact.approach - own).max() < 1e-12


def test_the_command_line_carries_dents_over_its_loads(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["halfspace", "sphere", "--radius", "10", "--E", "210e3", "--hardness", "2000", "--cells", "16"]
    assert main([*words, "--loads", "50,200,50"]) == 0
    first, _, last = (line.split() for line in capsys.readouterr().out.splitlines()[2:5])
    assert float(last[2]) > 1.2 * float(first[2])
    assert main([*words, "--force", "200"]) == 0
    assert "plastic area" in capsys.readouterr().out
