"""Stress inside half-spaces, contact stiffness and the area with its edge fitted, each against something else."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.analytic import boussinesq
from fecontact.common.material import von_mises
from fecontact.halfspace import pictures
from fecontact.halfspace.inside import mean_distance
from fecontact.halfspace.pictures import section
from fecontact.surfaces import FlatPunch, Paraboloid, self_affine

UNIT = fc.Material(E=2.0, nu=0.3)
VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
POINTS = np.column_stack(
    [np.random.default_rng(0).uniform(-1.5, 1.5, (40, 2)), -np.tile([0.0, 0.1, 0.3, 0.31, 0.45, 0.6, 1.5, 2.0], 5)]
)


def ball(material=UNIT, n=32, side=3.0, **options):
    half = fc.HalfSpace(material, size=(side, side), cells=(n, n), **options)
    return half, half.press(Paraboloid(1.0), force=2.0)


def test_ball_against_hertz_on_the_axis():
    _, contact = ball(n=64)
    hertz = fc.hertz.spheres((1.0, np.inf), (None, UNIT), force=2.0)
    z = np.array([0.1, 0.3, 0.6, 1.0]) * hertz.a
    exact = hertz.stress_on_axis(z, body=1)
    found = contact.stress(np.column_stack([0 * z, 0 * z, -z]))
    # 20 cells per radius: the edge of the pressure is that of cells
    assert np.abs(found[:, 2] - exact.zz).max() < 2e-3 * hertz.p0
    assert np.abs(found[:, 0] - exact.rr).max() < 2e-3 * hertz.p0


def test_layers_of_the_same_material_change_nothing():
    _, alone = ball()
    _, layered = ball(layers=[fc.Layer(UNIT, 0.3), fc.Layer(UNIT, 0.2)])
    # two ways to the same field: Love's rectangles and Hankel transforms, joined at the first interface
    assert np.abs(alone.stress(POINTS) - layered.stress(POINTS)).max() < 1e-6 * alone.max_pressure


@pytest.mark.full
def test_layers_balance_the_force_at_their_base():
    stiff = fc.Material(E=20.0, nu=0.2)
    _, contact = ball(layers=[fc.Layer(stiff, 0.4)])
    x = np.linspace(-10, 10, 81)
    X, Y = np.meshgrid(x, x, indexing="ij")
    for depth in (0.4, 0.5):
        carried = contact.stress(np.column_stack([X.ravel(), Y.ravel(), np.full(X.size, -depth)]))[:, 2].sum() * 0.25**2
        # what passes further out is (depth/10)^3 of it, the stiff layer as deep as 0.86
        assert abs(-carried / 2.0 - 1) < 3e-3


def test_a_frictionless_interface_has_no_shear():
    _, contact = ball(None, layers=[fc.Layer(UNIT, 0.5, "frictionless")])
    stress = contact.stress([[0.4, 0.1, -0.5], [0.9, -0.3, -0.5]])
    assert np.abs(stress[:, 4:]).max() < 1e-6 * contact.max_pressure
    with refused(fc.InputError, "input", "0.5"):
        contact.stress([[0.0, 0.0, -0.6]])


def test_one_wave_in_full_contact():
    half = fc.HalfSpace(UNIT, size=(1.0, 1.0), cells=(32, 32), periodic=True)
    k = 2 * np.pi
    contact = half.press((-0.01 * np.cos(k * half.grid.x))[:, None] * np.ones(32), force=5.0)
    amplitude = 0.01 * k * UNIT.plane_strain_modulus / 2
    x, z = 0.13, 0.21
    found = contact.stress([[x, 0.2, -z]])[0]
    decay = amplitude * np.exp(-k * z)
    confined = -5.0 * UNIT.nu / (1 - UNIT.nu)
    exact = [
        confined - (1 - k * z) * decay * np.cos(k * x),
        confined - 2 * UNIT.nu * decay * np.cos(k * x),
        -5.0 - (1 + k * z) * decay * np.cos(k * x),
        0.0,
        0.0,
        k * z * decay * np.sin(k * x),
    ]
    # closed form of a wave of pressure; the pressures found are certified to 1e-8
    assert np.abs(found - exact).max() < 1e-6 * amplitude


def test_a_long_period_is_a_free_surface():
    _, free = ball(n=128, side=12.0)
    half = fc.HalfSpace(UNIT, size=(12.0, 12.0), cells=(128, 128), periodic=True)
    periodic = half.press(Paraboloid(1.0), force=2.0)
    deep = POINTS[POINTS[:, 2] < -0.05]
    # the neighbours and the mean, of order force/side^2
    assert np.abs(free.stress(deep) - periodic.stress(deep)).max() < 2 * 2.0 / 12**2


@pytest.mark.parametrize("force", [0.001, 0.01, 0.1])
def test_stiffness_is_the_slope_of_force_over_approach(force):
    rough = self_affine((64, 64), (1.0, 1.0), hurst=0.8, rms_slope=0.1, seed=1, longest=0.25)
    half = fc.HalfSpace(UNIT, size=(1.0, 1.0), cells=(64, 64), periodic=True)
    at = [half.press(rough.z, force=force * f, tolerance=1e-10) for f in (1.0, 1.0001)]
    slope = 1e-4 * force / (at[1].approach - at[0].approach)
    # a cell that joins in between changes the slope by its share of the contact
    assert abs(half.stiffness(at[0]) / slope - 1) < 0.01


def test_full_contact_of_a_periodic_surface_is_stiff():
    half = fc.HalfSpace(UNIT, size=(1.0, 1.0), cells=(8, 8), periodic=True)
    assert half.stiffness(half.press(np.zeros((8, 8)), force=1.0)) == np.inf


@pytest.mark.parametrize("n", [64, 96, 128, 200])
def test_edge_fitted_area_of_a_ball(n):
    half = fc.HalfSpace(fc.Material(1.0, 0.0), size=(3.05, 3.05), cells=(n, n))
    contact = half.press(Paraboloid(1.0), force=4 / 3)
    # counting cells errs by up to 1/n (1.3e-2 at 64); the fitted edge by less than half of that
    assert abs(contact.figures["area"] / np.pi - 1) < 0.5 / n


def test_the_edge_of_a_flat_punch_is_known():
    half = fc.HalfSpace(UNIT, size=(3.0, 3.0), cells=(64, 64))
    contact = half.press(FlatPunch(radius=1.0), force=2.0)
    assert contact.figures["area"] == contact.area


def crowded(n=30, side=0.3, layers=(), size_y=None):
    """Pressures on cells whose edges are no round numbers in binary."""
    half = fc.HalfSpace(UNIT, size=(side, size_y or side), cells=(n, n), layers=layers)
    return half, half.press(Paraboloid(side), approach=side / 40)


def edges(grid):
    return [(np.arange(n + 1) - n / 2) * cell for n, cell in zip(grid.shape, grid.cell, strict=True)]


LAYERS = [[], [fc.Layer(fc.Material(E=9.0, nu=0.2), 0.02)]]


@pytest.mark.by_day("oblong-homogeneous", "square-layered")
@pytest.mark.parametrize("layers", LAYERS, ids=["homogeneous", "layered"])
@pytest.mark.parametrize("size_y", [0.3, 0.41], ids=["square", "oblong"])
def test_stress_on_edges_and_corners_of_cells_is_the_mean_of_the_sides(layers, size_y):
    half, contact = crowded(12, layers=layers, size_y=size_y)
    x, y = edges(half.grid)
    p = np.pad(contact.pressure, 1)
    mean = {
        "edges across x": (np.meshgrid(x, half.grid.y, indexing="ij"), (p[1:, 1:-1] + p[:-1, 1:-1]) / 2),
        "edges across y": (np.meshgrid(half.grid.x, y, indexing="ij"), (p[1:-1, 1:] + p[1:-1, :-1]) / 2),
        "corners": (np.meshgrid(x, y, indexing="ij"), (p[1:, 1:] + p[:-1, 1:] + p[1:, :-1] + p[:-1, :-1]) / 4),
    }
    step = 1e-4 * np.array([*half.grid.cell, 0.0])
    for where, (places, pressure) in mean.items():
        points = np.stack([*(c.ravel() for c in places), np.zeros(pressure.size)], axis=1)
        found = contact.stress(points)
        assert np.isfinite(found).all(), where
        # zz is the applied pressure; a layer's part of it is that of its transforms, to 1e-6
        least = 1e-12 if not layers else 1e-6
        assert np.abs(found[:, 2] + pressure.ravel()).max() < least * contact.max_pressure, where
        assert np.abs(found[:, 4:]).max() < least * contact.max_pressure, where
        # along x and y against the four sides, a ten-thousandth of a cell away: fields vary by some p0 over a cell
        sides = [step * (sx, sy, 0) for sx in (-1, 1) for sy in (-1, 1)]
        around = [contact.stress(points + side) for side in sides]
        difference = np.abs(found - np.mean(around, axis=0)) / contact.max_pressure
        assert difference[:, :2].max() < 1e-3, where
        if where != "corners":
            assert difference[:, 3].max() < 2e-3, where


def test_shear_at_a_corner_of_cells_is_that_of_its_neighbourhood():
    """Where the mixed difference of four pressures vanishes there is no logarithm, and xy has a limit."""
    half, contact = crowded()
    x = half.grid.x
    plane = replace(contact, pressure=1 + 2 * x[:, None] / 0.15 + 1 * x / 0.15)  # a plane: no mixed differences
    x, y = (e[5:-5] for e in edges(half.grid))
    X, Y = np.meshgrid(x, y, indexing="ij")
    points = np.stack([X.ravel(), Y.ravel(), 0 * X.ravel()], axis=1)[::7]
    around = [plane.stress(points + np.array([sx * 1e-6, sy * 1e-6, 0.0])) for sx in (-1, 1) for sy in (-1, 1)]
    found = plane.stress(points)
    # a ten-thousandth of a cell away, where the field changes by about its size over a cell
    assert np.abs(found - np.mean(around, axis=0)).max() < 1e-3 * np.abs(found).max()


@pytest.mark.parametrize("shape", [(1.0, 1.0), (1.0, 0.4), (1e-6, 3e-6)])
def test_the_distance_at_which_shear_at_a_corner_is_taken(shape):
    """Where xy is infinite, its logarithm counts with its mean over a cell about the corner."""
    a, b = shape
    # 400 x 400 midpoints: the middle cell of the rule errs by about 1/400^2, the kink of its neighbours no more
    t = (np.arange(400) + 0.5) / 400 * 2 - 1
    mean = np.log(np.hypot(a * t[:, None], b * t[None, :])).mean()
    assert abs(np.log(mean_distance(a, b)) - mean) < 1e-4
    half = fc.HalfSpace(UNIT, size=(8 * a, 8 * b), cells=(4, 4))
    contact = half.press(np.pad(np.zeros((2, 2)), 1, constant_values=np.inf), approach=0.01 * a)
    alone = replace(contact, pressure=np.pad([[1.0]], ((1, 2), (1, 2))))  # one cell, its corner at the origin
    r = mean_distance(a, b) / 2**0.5
    near = [alone.stress([[i * r, j * r, 0.0]])[0, 3] for i in (-1, 1) for j in (-1, 1)]
    # the other corners' logarithms are not constant so far away: a tenth of (1 - 2 nu)/(2 pi) p
    assert abs(alone.stress([[0.0, 0.0, 0.0]])[0, 3] - np.mean(near)) < 0.1 * 0.4 / (2 * np.pi)


@pytest.mark.parametrize("off", [0.0, 1e-18, 1e-15, 1e-12, 1e-10])
def test_points_next_to_places_that_stand_for_a_cell(off):
    """Point forces at nine places of a cell are replaced nearby, and leave nothing of their size behind."""
    half, contact = crowded()
    x, y = half.grid.x[15], half.grid.y[14]
    for shift in (0.0, np.sqrt(0.15) * half.grid.cell[0]):
        for depth in (0.0, off):
            here = contact.stress([[x + shift + off, y - off, -depth]])
            beside = contact.stress([[x + shift + 1e-5, y, 0.0]])
            # a thousandth of a cell away, where the field changes by about its size over a cell
            assert np.abs(here - beside).max() < 3e-3 * contact.max_pressure


def test_points_above_corners_of_cells_tend_to_the_surface():
    half, contact = crowded()
    x, y = edges(half.grid)
    X, Y = np.meshgrid(x[10:-10], y[10:-10], indexing="ij")
    points = np.stack([X.ravel(), Y.ravel(), 0 * X.ravel()], axis=1)
    found, below = contact.stress(points), contact.stress(points - [0.0, 0.0, 1e-6])
    p = np.pad(contact.pressure, 1)
    jump = max(np.abs(np.diff(p, axis=k)).max() for k in (0, 1))
    # zz tends to the mean; the others jump there by the pressures' differences, and shear is no longer nought
    assert np.abs(found[:, 2] - below[:, 2]).max() < 1e-3 * contact.max_pressure
    assert np.abs(found[:, :2] - below[:, :2]).max() < jump
    assert np.isfinite(below).all()


def test_an_interface_is_where_the_thicknesses_add_up_to():
    """0.1 + 0.7 is less than 0.8 in binary: there the upper layer counts all the same."""
    stiff = fc.Material(E=20.0, nu=0.2)
    assert 0.1 + 0.7 < 0.8
    for periodic in (False, True):
        _, contact = ball(layers=[fc.Layer(UNIT, 0.1), fc.Layer(stiff, 0.7)], periodic=periodic)
        on, above, below = contact.stress([[0.1, 0.2, z] for z in (-0.8, -0.8 + 1e-9, -0.8 - 1e-9)])
        assert np.abs(on - above).max() < 1e-6 * contact.max_pressure
        assert np.abs(on - below).max() > 1e-3 * contact.max_pressure


def test_periodic_stress_at_corners_of_cells_is_that_of_its_neighbourhood():
    half = fc.HalfSpace(UNIT, size=(0.3, 0.3), cells=(30, 30), periodic=True, layers=LAYERS[1])
    waves = 1e-3 * np.cos(2 * np.pi * half.grid.x / 0.3)
    contact = half.press(waves[:, None] + waves, force=2e-4)
    points = np.array([[0.0, 0.0, 0.0], [0.15, 0.15, 0.0], [0.01, 0.15, 0.0], [0.01, 0.01, -0.02]])
    moved = contact.stress(points + np.array([1e-7, -1e-7, 0.0]))
    # a hundred-thousandth of a cell away
    assert np.abs(contact.stress(points) - moved).max() < 1e-3 * contact.max_pressure


@pytest.mark.parametrize("along", [(1.0, 0.0), (0.6, -0.8)])
def test_a_sliding_ball_against_hamilton(along):
    """Surface stresses by tractions q0 sqrt(1 - r^2/a^2) on a circle (Hamilton 1983; strains: Johnson eq. 3.91)."""
    half = fc.HalfSpace(UNIT, size=(3.0, 3.0), cells=(64, 64), against=UNIT)
    mu, e = 0.3, np.array(along)
    sliding = half.press(Paraboloid(1.0), force=2.0, friction=mu, shift=tuple(2.0 * e))
    smooth = half.press(Paraboloid(1.0), force=2.0)
    hertz = fc.hertz.spheres((1.0, np.inf), (UNIT, UNIT), force=2.0)
    x = half.grid.x[[20, 26, 35, 43]]
    points = np.column_stack([x, x[::-1], 0 * x])
    found = (sliding.stress(points) - smooth.stress(points)) / (mu * hertz.p0)
    s, t = points[:, :2] @ e / hertz.a, points[:, :2] @ [-e[1], e[0]] / hertz.a
    nu = UNIT.nu
    ss, tt, st = -np.pi * (4 + nu) * s / 8, -3 * np.pi * nu * s / 8, -np.pi * (2 - nu) * t / 8
    turn = np.stack([e, [-e[1], e[0]]], axis=1)
    plane = np.einsum("ai,nij,bj->nab", turn, np.array([[ss, st], [st, tt]]).transpose(2, 0, 1), turn)
    for k, (i, j) in ((0, (0, 0)), (1, (1, 1)), (3, (0, 1))):
        # slip is radial too, and turns tractions by up to 1 %; 20 cells per radius
        assert np.abs(found[:, k] - plane[:, i, j]).max() < 0.02
    traction = sliding.traction[:, [20, 26, 35, 43], [43, 35, 26, 20]]
    np.testing.assert_allclose(found[:, [5, 4]] * mu * hertz.p0, traction.T, atol=1e-10 * hertz.p0)


def test_tractions_are_carried_through_every_depth():
    half = fc.HalfSpace(UNIT, size=(3.0, 3.0), cells=(8, 8), against=UNIT)
    dragged = half.press(Paraboloid(1.0), force=2.0, friction=0.3, tangential=(0.3, 0.2))
    x = np.linspace(-8, 8, 33)
    X, Y = np.meshgrid(x, x, indexing="ij")
    points = np.column_stack([X.ravel(), Y.ravel(), np.full(X.size, -1.0)])
    carried = dragged.stress(points).sum(axis=0) * 0.5**2
    # a part passes beyond: that of a point force, but for the square of radius over distance
    alone = -boussinesq.stress(points * [1, 1, -1], force=(0.3, 0.2, 0.0), material=UNIT).sum(axis=0) * 0.5**2
    np.testing.assert_allclose(carried[[5, 4]], alone[2, :2], rtol=0.01)
    assert 0.75 < alone[2, 0] / 0.3 < 1


@pytest.mark.parametrize(
    ("shape", "options"),
    [((51, 36), {}), ((51, 36), {"layers": [fc.Layer(fc.Material(4.0, 0.2), 0.03)]}), ((32, 32), {"periodic": True})],
)
def test_the_section_is_below_the_peak_and_has_its_stresses(shape, options):
    half = fc.HalfSpace(fc.Material(1.0, 0.3), (1.0, 0.8), shape, **options)
    x, y = half.grid.x[:, None], half.grid.y[None, :]
    z = np.minimum((x + 0.1) ** 2 + y**2, 20 * ((x - 0.2) ** 2 + (y - 0.2) ** 2) - 0.003)  # a needle beside a ball
    contact = half.press(z, force=0.005)
    at, along, depths, stress = section(contact)
    i, j = np.unravel_index(contact.pressure.argmax(), shape)
    assert at == half.grid.y[j] > 0.15
    points = np.stack([a.ravel() for a in np.meshgrid(along, at, depths, indexing="ij")], axis=1)
    some = np.random.default_rng(1).choice(len(points), 150, replace=False)
    exact = contact.stress(points[some])
    # blocks are an eighth of the depth at most: (1/24)(1/8)^2 of a field that is squared in curvature by some 15
    assert np.abs(stress.reshape(-1, 6)[some] - exact).max() < 0.01 * contact.max_pressure
    # within a cell below the needle, where joined cells and a plane y = 0 had next to nothing
    mises = von_mises(stress.reshape(-1, 6)).reshape(stress.shape[:2])
    assert mises.max() > 0.3 * contact.max_pressure
    assert abs(along[np.unravel_index(mises.argmax(), mises.shape)[0]] - half.grid.x[i]) < 1.5 * half.grid.cell[0]
    if half.layers:
        assert {-0.03, -0.03 * (1 + 1e-9)} <= set(depths)


@pytest.mark.full
def test_large_grids_and_no_contact_have_a_section(monkeypatch):
    half = fc.HalfSpace(fc.Material(1.0, 0.3), (1.0, 1.0), (64, 64))
    ball = half.press(fc.Sphere(2.0), force=0.01)
    fine = section(ball)[3]
    monkeypatch.setattr(pictures, "SECTION_CELLS", 32)
    assert "of blocks of 2 x 2 cells" in ball.plot().axes[3].get_title()
    assert abs(von_mises(section(ball)[3].reshape(-1, 6)).max() / von_mises(fine.reshape(-1, 6)).max() - 1) < 0.01
    assert not section(half.press(fc.Sphere(2.0), approach=-0.01))[3].any()
