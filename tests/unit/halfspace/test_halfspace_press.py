"""The half-space's own solver: against the dense reference, its invariances, its refusals."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.halfspace.nested import first_start
from fecontact.halfspace.operator import CellModel, GridCompliance
from fecontact.halfspace.pressing import Load, grid_level
from fecontact.solvers import ContactProblem, solve
from fecontact.surfaces import Cone, FlatPunch, Paraboloid, self_affine

UNIT = fc.Material(E=1.0, nu=0.0)


def reference(half, z, **load):
    """The same contact by a dense active-set solver."""
    import scipy.sparse as sp

    S = CellModel(half.compliance).dense(sp.identity(half.grid.n_cells, format="csr"))
    if "force" in load:
        B, F = np.ones((1, z.size)), np.array([load["force"]])
        return solve(ContactProblem(S, z.ravel(), B, F), tolerance=1e-11)
    return solve(ContactProblem(S, z.ravel() - load["approach"]), tolerance=1e-11)


@pytest.mark.parametrize("load", [{"force": 0.4}, {"approach": 0.3}])
@pytest.mark.parametrize("pressure", ["uniform", "bilinear", "point"])
def test_same_as_the_dense_solver(load, pressure):
    half = fc.HalfSpace(UNIT, size=(3.0, 2.4), cells=(21, 16), pressure=pressure)
    x, y = half.grid.x[:, None], half.grid.y[None, :]
    z = (x - 0.2) ** 2 / 2 + y**2 + 0.02 * np.cos(7 * x) * np.cos(5 * y)
    contact = half.press(z, **load, tolerance=1e-11)
    forces = reference(half, z, **load).forces
    # both certified to 1e-11 of the deflection; a pressure is a deflection over a cell's own compliance
    assert np.abs(contact.pressure.ravel() * half.grid.area - forces).max() < 1e-8 * forces.max()


def test_a_cell_that_coarser_grids_do_not_see_touches():
    half = fc.HalfSpace(UNIT, size=(3.0, 2.4), cells=(40, 32))
    x, y = half.grid.x[:, None], half.grid.y[None, :]
    z = ((x + 0.7) ** 2 + y**2) / 2
    z[33, 25] = -0.02  # its block of four is higher than the ball: coarser grids touch the ball alone
    contact = half.press(z, force=0.01, tolerance=1e-11)
    assert contact.pressure[33, 25] > 0
    assert contact.n_regions == len(contact.regions) == 2
    forces = reference(half, z, force=0.01).forces
    assert np.abs(contact.pressure.ravel() * half.grid.area - forces).max() < 1e-8 * forces.max()


@pytest.mark.parametrize("mu", [None, 0.5])
def test_regions_of_two_balls_add_up_to_the_contact(mu):
    half = fc.HalfSpace(UNIT, size=(6.0, 3.0), cells=(64, 32))
    x, y = half.grid.x[:, None], half.grid.y[None, :]
    z = ((np.abs(x) - 1.5) ** 2 + y**2) / 2  # two of radius 1, alike
    drag = {} if mu is None else {"friction": mu, "tangential": (0.0, 0.02)}
    contact = half.press(z, force=0.2, **drag)
    left, right = contact.regions
    assert abs(left.area + right.area - contact.figures["area"]) < 1e-12
    for one in (left, right):
        np.testing.assert_allclose(one.force[1:], [0.0 if mu is None else 0.01, -0.1], rtol=0, atol=1e-9)
        assert abs(one.max_pressure - contact.max_pressure) < 1e-9
        assert abs(one.mean_pressure * one.area - 0.1) < 1e-9
        assert abs(one.point_area - contact.point_area / 2) < 1e-12
    assert abs(left.force[0] + right.force[0]) < 1e-9  # with friction the two draw each other nearer
    x, y, _ = right.centre_of_pressure
    np.testing.assert_allclose(left.centre_of_pressure, [-x, y, 0.0], rtol=0, atol=1e-9)
    assert abs(x - 1.5) < half.grid.cell[0]
    np.testing.assert_allclose(right.moment[:2], [-0.1 * y, 0.1 * x], rtol=0, atol=1e-9)  # about the origin
    if mu is not None:
        assert abs(left.moment[2] + right.moment[2] - contact.torque) < 1e-9
    assert half.press(z + 1.0, approach=0.5).regions == ()


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5, 13, 80, 88])
def test_rough_presses_are_certified(seed):
    rng = np.random.default_rng(seed)
    kind = ("free", "rim", "periodic", "layered", "friction")[seed % 5]
    shape = tuple(rng.choice([32, 48, 64], 2))
    size = (shape[0] / 32, shape[1] / 32)
    soft = fc.Material(1.0, rng.uniform(0, 0.45))
    layers = [fc.Layer(soft, 10 ** rng.uniform(-1.5, 0.5))] if kind == "layered" else []
    half = fc.HalfSpace(fc.Material(3.0, 0.3), size, shape, kind == "periodic", layers=layers)
    waves = self_affine(shape, size, hurst=rng.uniform(0.3, 1), seed=seed, rms_slope=0.05, shortest=0.1).z
    x, y = half.grid.x[:, None] / min(size), half.grid.y[None, :] / min(size)
    dome = 0 if half.periodic else np.ptp(waves) * 10 ** rng.uniform(0.8, 1.5) * ((x - 0.1) ** 2 + y**2)
    z = waves + dome
    if kind == "rim":
        z = np.where(np.hypot(x, y) < 0.45, z, np.inf)
    force = half.contact_modulus * min(size) ** 2 * np.ptp(waves) * 10 ** rng.uniform(-4, -2)
    if kind == "friction":
        dragged = half.press(z - z.min(), force=force, friction=0.3, tangential=(0.2 * force, 0.1 * force))
        assert dragged.residuals.within(1e-10)
    contact = half.press(z - z.min(), force=force)
    assert contact.residuals.within(1e-8)
    assert abs(contact.force / force - 1) < 1e-8


def test_symmetry_changes_nothing():
    half = fc.HalfSpace(UNIT, size=(3.0, 3.0), cells=(64, 64))
    quarter = half.press(Paraboloid(1.0), force=4 / 3, tolerance=1e-10)
    whole = half.press(Paraboloid(1.0), force=4 / 3, tolerance=1e-10, symmetry=False)
    assert quarter.solver.symmetric == (True, True)
    assert whole.solver.symmetric == (False, False)
    # tolerance 1e-10 in gaps, times the condition of 40 cells per diameter
    assert np.abs(quarter.pressure - whole.pressure).max() < 1e-8 * whole.max_pressure
    assert abs(quarter.approach - whole.approach) < 1e-9


def test_units_and_scale():
    mm = fc.HalfSpace(fc.Material(210e3, 0.3), size=(0.6, 0.6), cells=(48, 48)).press(Paraboloid(10.0), force=100.0)
    m = fc.HalfSpace(fc.Material(210e9, 0.3), size=(0.6e-3, 0.6e-3), cells=(48, 48)).press(
        Paraboloid(10e-3), force=100.0
    )
    assert np.abs(m.pressure / 1e6 - mm.pressure).max() < 1e-7 * mm.max_pressure  # two runs at tolerance 1e-8
    assert abs(m.approach * 1e3 / mm.approach - 1) < 1e-8


def test_two_elastic_bodies_by_one_half_space():
    steel, rubber = fc.Material(210e3, 0.3), fc.Material(5.0, 0.45)
    both = fc.HalfSpace(steel, size=(8.0, 8.0), cells=(48, 48), against=rubber).press(Paraboloid(10.0), force=5.0)
    hertz = fc.hertz.spheres((10.0, np.inf), (steel, rubber), force=5.0)
    assert abs(both.approach / hertz.approach - 1) < 5e-4  # 16 cells per contact radius
    assert abs(both.moment_radius() / hertz.a - 1) < 2e-3


@pytest.mark.parametrize("point", [(0.15, 0.0), (0.0, 0.2), (0.1, -0.15)])
def test_free_tilt_balances_the_moment(point):
    half = fc.HalfSpace(UNIT, size=(3.0, 3.0), cells=(48, 48))
    contact = half.press(FlatPunch(radius=1.0), force=2.0, load_point=point)
    assert np.abs(np.array(contact.centre_of_pressure) - point).max() < 1e-12  # exact statics
    assert abs(contact.force / 2.0 - 1) < 1e-12
    # the loaded side goes down: heights rise away from it
    assert np.dot(contact.tilt, point) < 0


def test_tilt_of_a_flat_punch_is_the_known_one():
    # rocking of a rigid disc, P e = (4/3) E* a^3 tilt (Borowicka 1943); full contact while e < a/3
    half = fc.HalfSpace(UNIT, size=(3.0, 3.0), cells=(192, 192))
    contact = half.press(FlatPunch(radius=1.0), force=2.0, load_point=(0.2, 0.0))
    assert abs(-contact.tilt[0] / (3 * 2.0 * 0.2 / 4) - 1) < 0.01  # outline of the punch to a cell, third power


def test_periodic_mean_plane_and_full_contact():
    half = fc.HalfSpace(UNIT, size=(1.0, 1.0), cells=(64, 64), periodic=True)
    x = half.grid.x
    z = 0.01 * (1 - np.cos(2 * np.pi * x))[:, None] * np.ones(64)
    p_star = np.pi * 0.01
    contact = half.press(z, force=1.5 * p_star)
    exact = 1.5 * p_star + p_star * np.cos(2 * np.pi * x)
    assert contact.area_fraction == 1.0
    assert np.abs(contact.pressure - exact[:, None]).max() < 1e-9 * p_star  # one wave: exact but for the tolerance
    assert abs(contact.displacement.mean()) < 1e-15
    assert abs(contact.approach / 0.01 - 1) < 1e-7  # full contact: the mean of the heights
    assert contact.mean_gap < 1e-9


def test_cells_without_surface_carry_nothing():
    half = fc.HalfSpace(UNIT, size=(2.0, 2.0), cells=(40, 40))
    z = np.full((40, 40), np.inf)
    z[5:12, 8:30] = 0.0
    contact = half.press(z, force=1.0)
    assert contact.active.sum() == 7 * 22
    assert np.isinf(contact.gap[0, 0])
    assert contact.n_regions == 1


def test_no_contact():
    half = fc.HalfSpace(UNIT, size=(2.0, 2.0), cells=(16, 16))
    contact = half.press(Paraboloid(1.0), approach=-0.1)
    assert contact.status == "no-contact"
    assert contact.force == 0.0
    assert not contact.pressure.any()
    assert contact.gap.min() > 0.1


def test_rough_surface_repeats_and_grows_with_load():
    rough = self_affine((64, 64), (1.0, 1.0), hurst=0.8, seed=3, rms_slope=0.1)
    half = fc.HalfSpace(UNIT, size=(1.0, 1.0), cells=(64, 64), periodic=True)
    fractions = [half.press(rough.z, force=f).area_fraction for f in (0.002, 0.005, 0.01)]
    assert fractions == sorted(fractions)
    assert fractions[-1] == half.press(rough.z, force=0.01).area_fraction


def test_stress_under_a_sphere():
    half = fc.HalfSpace(fc.Material(1.0, 0.3), size=(3.0, 3.0), cells=(64, 64))
    force = 4 / 3 * half.compliance.modulus
    contact = half.press(Paraboloid(1.0), force=force)
    hertz = fc.hertz.spheres((1.0, np.inf), (fc.Material(1.0, 0.3), None), force=force)
    depth = np.array([0.3, 0.48, 1.0])
    found = contact.stress(np.stack([0 * depth, 0 * depth, -depth], axis=1))
    exact = hertz.stress_on_axis(depth)
    # pressures of 21 cells per radius are good to about 0.5 %
    assert np.abs(found[:, 2] / hertz.p0 - exact.zz / hertz.p0).max() < 5e-3
    assert np.abs(found[:, 0] / hertz.p0 - exact.rr / hertz.p0).max() < 5e-3


def test_transforms_do_not_grow_with_the_grid():
    counts, steps = [], []
    for n in (64, 128, 256):
        half = fc.HalfSpace(UNIT, size=(3.0, 3.0), cells=(n, n))
        report = half.press(Paraboloid(1.0), force=4 / 3, symmetry=False).solver
        counts.append(report.transforms)
        steps.append(report.nit)
    assert max(counts) < 50  # 30 to 38 found
    assert max(steps) <= 15  # 9 to 12 found


def test_operator_and_matrix_agree():
    import scipy.sparse as sp

    half = fc.HalfSpace(UNIT, size=(1.0, 2.0), cells=(6, 8))
    cells = np.array([3, 17, 17, 40])
    rows = sp.csr_matrix((np.ones(4), (np.arange(4), cells)), shape=(4, 48))
    operator = GridCompliance(CellModel(half.compliance), cells)
    assert np.abs(operator @ np.eye(4) - CellModel(half.compliance).dense(rows)).max() < 1e-14
    periodic = fc.HalfSpace(UNIT, size=(1.0, 2.0), cells=(6, 8), periodic=True)
    wave = np.random.default_rng(0).random((6, 8))
    S = CellModel(periodic.compliance).dense(sp.identity(48, format="csr"))
    u = CellModel(periodic.compliance).product.apply(wave / periodic.grid.area)
    assert np.abs(S @ wave.ravel() - u.ravel()).max() < 1e-13


@pytest.mark.parametrize(
    ("surface", "load", "message"),
    [
        (Paraboloid(1.0), {"force": -1.0}, ("force-not-positive",)),
        (Paraboloid(1.0), {"force": 0.0}, ("force-not-positive",)),
        (Paraboloid(1.0), {"force": np.nan}, ("not-finite", "The force")),
        (Paraboloid(1.0), {}, ("one-of",)),
        (Paraboloid(1.0), {"force": 1.0, "approach": 1.0}, ("one-of",)),
        (Paraboloid(1.0), {"approach": 0.1, "load_point": (0.0, 0.0)}, ("load-point-without-force",)),
        (Paraboloid(1.0), {"force": 50.0}, ("grid-too-small",)),
        (FlatPunch(radius=0.5), {"force": 1.0, "load_point": (0.9, 0.0)}, ("load-point-outside",)),
        (np.full((32, 32), np.nan), {"force": 1.0}, ("heights-nan",)),
        (np.full((32, 32), np.inf), {"force": 1.0}, ("no-counter-surface",)),
        (np.zeros((31, 32)), {"force": 1.0}, ("heights-shape", "(31, 32)")),
        (Cone(0.1), {"force": 1e-3, "tolerance": 0.0}, ("no-share", "The tolerance")),
    ],
)
def test_bad_loads_and_heights(surface, load, message):
    half = fc.HalfSpace(UNIT, size=(2.5, 2.5), cells=(32, 32))
    with refused(InputError, *message):
        half.press(surface, **load)


def test_the_size_named_is_enough():
    half = fc.HalfSpace(UNIT, size=(2.0, 2.0), cells=(64, 64))
    with refused(InputError, "grid-too-small") as caught:
        half.press(Paraboloid(1.0), force=4 / 3 * 1.2)
    needed = float(str(caught.value).split("about ")[1].split(" ")[0])
    fc.HalfSpace(UNIT, size=(needed, needed), cells=(64, 64)).press(Paraboloid(1.0), force=4 / 3 * 1.2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"cells": (33, 32), "periodic": True}, ("odd-cells", "(33, 32)")),
        ({"pressure": "cubic"}, ("unknown-name", "pressure")),
        ({"pressure": "point", "periodic": True}, ("pressure-not-available",)),
        ({"material": None}, ("input", "rigid")),
    ],
)
def test_bad_half_spaces(options, message):
    with refused(InputError, *message):
        fc.HalfSpace(**{"material": UNIT, **options})


@pytest.mark.parametrize("layers", [[], [fc.Layer(UNIT, 0.1)]])
def test_periodic_approach_beyond_the_mean_plane_is_refused_before_the_solve(layers, monkeypatch):
    half = fc.HalfSpace(UNIT, size=(1.0, 1.0), cells=(32, 32), periodic=True, layers=layers)
    z = 0.01 * (1 - np.cos(2 * np.pi * half.grid.x))[:, None] * np.ones(32)
    assert half.press(z, approach=0.0099).residuals.within(1e-8)
    # full contact needs p* = pi E* amplitude / wavelength in the mean (Westergaard 1939), and no more at the mean plane
    assert abs(half.press(z, approach=0.01 * (1 - 1e-4)).force / (np.pi * 0.01) - 1) < 0.02
    monkeypatch.setattr("fecontact.halfspace.pressing.solve_nested", None)
    for approach in (0.01, 0.0101, 0.5):
        with refused(InputError, "approach-too-large", "0.01", "0.00995185"):
            half.press(z, approach=approach)
    with refused(InputError, "approach-too-large", "-0.29", "0.00995185"):
        half.press(z - 0.3, approach=0.0)


def test_a_period_with_holes_or_on_a_rigid_base_takes_any_approach():
    z = 0.01 * np.cos(np.arange(32.0))[:, None] * np.ones(32) + 0.01
    rigid_base = fc.HalfSpace(None, (1.0, 1.0), (32, 32), periodic=True, layers=[fc.Layer(UNIT, 0.1)])
    assert rigid_base.press(z, approach=0.03).area_fraction == 1
    holes = fc.HalfSpace(UNIT, (1.0, 1.0), (32, 32), periodic=True)
    z[::4] = np.inf
    assert holes.press(z, approach=0.03).residuals.within(1e-8)


def test_bodies_beyond_the_mean_plane_of_a_period_are_refused():
    half = fc.HalfSpace(UNIT, (1.0, 1.0), (48, 48), periodic=True)
    wave = fc.RigidBody(fc.surfaces.FunctionSurface(lambda x, y: 0.01 * (1 - np.cos(2 * np.pi * x)) + 0 * y, 1.0))
    with refused(InputError, "overlaps-mean-plane", "0.002"):
        fc.Scene([half, wave], [fc.Contact(half, wave)]).solve(motions={wave: {"z": -0.012}})


def test_print_and_describe():
    half = fc.HalfSpace(UNIT, size=(3.0, 3.0), cells=(32, 32))
    contact = half.press(Paraboloid(1.0), force=0.5)
    assert "32 x 32 cells (quarter modelled): solved" in str(contact)
    assert half.describe() == "half-space: free half-space, 32 x 32 cells"


@pytest.mark.parametrize("depth", [1e-8, 1e-5, 1e-3])
def test_a_ball_between_the_cells_is_warned_of(depth):
    """R 2 between four cells: Hertz's 4/3 E* sqrt(R) d^1.5, of which the formula of the overlap gives 0.94."""
    half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(2.0, 2.0), cells=(16, 16))
    contact = half.press(fc.Sphere(2.0), approach=depth)
    (text,) = contact.warnings
    assert contact.force == 0
    assert f"overlaps the half-space by {depth:.3g} at" in text
    assert abs(float(text.split("about ")[1].split()[0]) / (4 / 3 * 2.0**0.5 * depth**1.5) - 0.94) < 0.04
    assert text in str(contact)
    assert half.press(fc.Sphere(2.0), approach=0.05).force > 0


def test_shapes_that_cells_see_are_not_warned_of():
    half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(3.0, 3.0), cells=(64, 64))
    for shape in (fc.Sphere(2.0), fc.surfaces.FlatPunch(radius=0.5), fc.surfaces.Cone(0.1)):
        assert not half.press(shape, force=0.05).between
    assert not half.press(fc.Sphere(2.0), approach=-1e-8).between


def test_cells_by_their_former_name_warn():
    block = fc.ElasticBody(fc.shapes.block((2.0, 2.0, 1.0), (2, 2, 1)), UNIT, supports={"bottom": "xyz"})
    with pytest.warns(DeprecationWarning, match=r"HalfSpace\(cells=\)"):
        assert fc.HalfSpace(UNIT, shape=(4, 6)).grid.shape == (4, 6)
    with pytest.warns(DeprecationWarning, match=r"LocalBody\(cells=\)"):
        assert fc.LocalBody(block, (1.0, 1.0, 1.0), 0.4, shape=(4, 6)).window.shape == (4, 6)


def test_the_coarsest_grid_starts_with_the_cells_that_a_paraboloid_presses_by_hertz():
    stiff = fc.HalfSpace(fc.Material(E=210e3, nu=0.3), size=(0.3, 0.3), cells=(128, 128))
    hertz = fc.hertz.spheres((1.0, float("inf")), (stiff.material, None), force=50.0)
    z, load = stiff.heights_of(Paraboloid(1.0)), Load(50.0, None, None)
    level = grid_level(stiff.compliance, z, np.isfinite(z), load, True)
    start, active = first_start(level)
    exact = np.pi * hertz.a**2
    assert abs(4 * active.sum() * stiff.grid.area / exact - 1) < 0.02  # cells at the edge: 1 / 80 of it
    assert start.sum() == pytest.approx(level.F[0])
    down = replace(level, B=-level.B, F=-level.F)  # rows of a scene
    assert (first_start(down)[1] == active).all()
    turning = replace(level, B=level.B * (np.arange(64.0) - 30)[None, :, None])  # no row of a force
    assert first_start(turning)[1].all()
    on_part = replace(level, allowed=z[64:, 64:] > 1e-4)  # a ring
    assert not (first_start(on_part)[1] & ~on_part.allowed).any()
    assert (first_start(replace(level, B=level.B[:0], F=level.F[:0], g=level.g - 1e-4))[1] == (level.g < 1e-4)).all()
