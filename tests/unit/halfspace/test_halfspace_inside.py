"""Stress inside half-spaces, contact stiffness and the area with its edge fitted, each against something else."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import boussinesq
from fecontact.bodies.halfspace.inside import _point_force
from fecontact.surfaces import FlatPunch, Paraboloid, self_affine

UNIT = fc.Material(E=2.0, nu=0.3)
VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
POINTS = np.column_stack(
    [np.random.default_rng(0).uniform(-1.5, 1.5, (40, 2)), -np.tile([0.0, 0.1, 0.3, 0.31, 0.45, 0.6, 1.5, 2.0], 5)]
)


def ball(material=UNIT, n=32, side=3.0, **options):
    half = fc.HalfSpace(material, size=(side, side), shape=(n, n), **options)
    return half, half.press(Paraboloid(1.0), force=2.0)


def test_a_point_force_is_boussinesq():
    x = np.random.default_rng(1).uniform(-3, 3, (50, 3))
    x[:, 2] = np.abs(x[:, 2])
    exact = boussinesq.stress(x, force=(0.0, 0.0, 1.0), material=UNIT)
    found = _point_force(*x.T, UNIT.nu)
    for k, (i, j) in enumerate(VOIGT):
        assert np.abs(found[:, k] - exact[:, i, j]).max() < 1e-12 * np.abs(exact).max()


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
    with pytest.raises(fc.InputError, match=r"base below the layers, 0\.5, is rigid"):
        contact.stress([[0.0, 0.0, -0.6]])


def test_one_wave_in_full_contact():
    half = fc.HalfSpace(UNIT, size=(1.0, 1.0), shape=(32, 32), periodic=True)
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
    half = fc.HalfSpace(UNIT, size=(12.0, 12.0), shape=(128, 128), periodic=True)
    periodic = half.press(Paraboloid(1.0), force=2.0)
    deep = POINTS[POINTS[:, 2] < -0.05]
    # the neighbours and the mean, of order force/side^2
    assert np.abs(free.stress(deep) - periodic.stress(deep)).max() < 2 * 2.0 / 12**2


@pytest.mark.parametrize("force", [0.001, 0.01, 0.1])
def test_stiffness_is_the_slope_of_force_over_approach(force):
    rough = self_affine((64, 64), (1.0, 1.0), hurst=0.8, rms_slope=0.1, seed=1, longest=0.25)
    half = fc.HalfSpace(UNIT, size=(1.0, 1.0), shape=(64, 64), periodic=True)
    at = [half.press(rough.z, force=force * f, tolerance=1e-10) for f in (1.0, 1.0001)]
    slope = 1e-4 * force / (at[1].approach - at[0].approach)
    # a cell that joins in between changes the slope by its share of the contact
    assert abs(half.stiffness(at[0]) / slope - 1) < 0.01


def test_full_contact_of_a_periodic_surface_is_stiff():
    half = fc.HalfSpace(UNIT, size=(1.0, 1.0), shape=(8, 8), periodic=True)
    assert half.stiffness(half.press(np.zeros((8, 8)), force=1.0)) == np.inf


@pytest.mark.parametrize("n", [64, 96, 128, 200])
def test_edge_fitted_area_of_a_ball(n):
    half = fc.HalfSpace(fc.Material(1.0, 0.0), size=(3.05, 3.05), shape=(n, n))
    contact = half.press(Paraboloid(1.0), force=4 / 3)
    # counting cells errs by up to 1/n (1.3e-2 at 64); the fitted edge by less than half of that
    assert abs(contact.edge_area / np.pi - 1) < 0.5 / n


def test_the_edge_of_a_flat_punch_is_known():
    half = fc.HalfSpace(UNIT, size=(3.0, 3.0), shape=(64, 64))
    contact = half.press(FlatPunch(radius=1.0), force=2.0)
    assert contact.edge_area == contact.area
