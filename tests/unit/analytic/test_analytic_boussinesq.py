import numpy as np
import pytest
from refusals import refused

from fecontact import InputError, Material
from fecontact.analytic import boussinesq

POINTS = [[0.3, 0.2, 0.4], [-1.2, 0.5, 0.3], [0.0, 0.0, 2.0], [0.01, -0.02, 1.0]]
LOADS = [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.3, -0.7, 0.5)]


@pytest.mark.parametrize("nu", [-0.3, 0.0, 0.3, 0.4999])
@pytest.mark.parametrize("load", LOADS)
def test_stress_follows_from_the_displacement(nu, load, hooke):
    material = Material(E=2.0, nu=nu)
    for place in POINTS:
        point = np.array(place)
        found = boussinesq.stress(point, force=load, material=material)
        expected = hooke(lambda p: boussinesq.displacement(p, force=load, material=material), point, material, 1e-3)
        # Fourth-order differences, step 1e-3; the bulk modulus multiplies their error by 1/(1 - 2 nu).
        assert np.abs(found - expected).max() < 2e-8 / (1 - 2 * nu)


@pytest.mark.parametrize("load", LOADS)
def test_stress_is_in_equilibrium(load, divergence):
    material = Material(E=2.0, nu=0.3)
    for place in POINTS:
        found = divergence(lambda p: boussinesq.stress(p, force=load, material=material), np.array(place), 1e-3)
        assert np.abs(found).max() < 1e-7  # fourth-order differences of fields that vary over 0.3


@pytest.mark.parametrize("load", LOADS)
def test_planes_below_carry_the_load(load):
    # z = 1; r = tan(t) maps the plane on a finite interval on which the integrand is smooth.
    t, w = np.polynomial.legendre.leggauss(60)
    t, w = (t + 1) * np.pi / 4, w * np.pi / 4
    angle = 2 * np.pi * np.arange(8) / 8
    r = np.tan(t)
    points = np.stack(
        [np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)), np.ones((60, 8))],
        axis=-1,
    )
    traction = boussinesq.stress(points, force=load, material=Material(1.0, 0.3))[..., 2].mean(axis=1)
    total = 2 * np.pi * np.sum((w * r / np.cos(t) ** 2)[:, None] * traction, axis=0)
    np.testing.assert_allclose(-total, load, rtol=0, atol=1e-12)  # analytic integrand


@pytest.mark.parametrize("load", LOADS)
def test_surface_is_free_of_traction(load):
    stress = boussinesq.stress([[1.0, 0.5, 0.0], [-3.0, 0.1, 0.0]], force=load, material=Material(1.0, 0.3))
    np.testing.assert_allclose(stress[..., 2], 0.0, rtol=0, atol=1e-16)
    np.testing.assert_allclose(stress, np.swapaxes(stress, -1, -2), rtol=0, atol=0)


def test_surface_compliance_is_reciprocal():
    # Maxwell-Betti: load at the origin seen at p, and load at p seen at the origin.
    material = Material(1.0, 0.2)
    there = boussinesq.compliance([0.7, -0.4, 0.0], material)
    back = boussinesq.compliance([-0.7, 0.4, 0.0], material)
    np.testing.assert_allclose(there, back.T, rtol=0, atol=1e-16)


def test_surface_displacement_is_the_normal_part():
    material = Material(1.0, 0.3)
    tensor = boussinesq.compliance([[0.3, 0.4, 0.0]], material)
    found = boussinesq.surface_displacement(0.5, force=2.0, modulus=material.plane_strain_modulus)
    assert float(found) == pytest.approx(2 * tensor[0, 2, 2], rel=1e-15)


def test_near_the_axis_nothing_cancels():
    material = Material(1.0, 0.25)
    on_axis = boussinesq.stress([0.0, 0.0, 1.0], force=(0.3, 0.2, 1.0), material=material)
    beside = boussinesq.stress([1e-12, 0.0, 1.0], force=(0.3, 0.2, 1.0), material=material)
    np.testing.assert_allclose(beside, on_axis, rtol=0, atol=1e-12)  # slopes of order 1 times 1e-12
    tiny = boussinesq.stress([1e-40, 0.0, 1e-40], force=(0.3, 0.2, 1.0), material=material)
    unit = boussinesq.stress([1.0, 0.0, 1.0], force=(0.3, 0.2, 1.0), material=material)
    np.testing.assert_allclose(tiny * 1e-80, unit, rtol=1e-13, atol=1e-15)


def test_stress_is_left_out_within_a_core():
    x = np.array([0.05, 0.2])
    found = boussinesq.stress_components(x, 0 * x, 0 * x, (1.0, 0.0, 1.0), 0.25, core=0.1)
    assert not found[0].any()
    exact = boussinesq.stress([0.2, 0.0, 0.0], force=(1.0, 0.0, 1.0), material=Material(1.0, 0.25))
    np.testing.assert_allclose(found[1, [0, 5]], [exact[0, 0], exact[0, 2]], rtol=0, atol=1e-14)


def test_shapes_follow_the_points():
    points = np.ones((4, 5, 3))
    material = Material(1.0, 0.3)
    assert boussinesq.displacement(points, force=(0, 0, 1), material=material).shape == (4, 5, 3)
    assert boussinesq.stress(points, force=(0, 0, 1), material=material).shape == (4, 5, 3, 3)


def test_each_point_may_have_its_own_force():
    material = Material(2.0, 0.3)
    points, forces = np.array(POINTS), np.array(LOADS)
    for field in (boussinesq.displacement, boussinesq.stress):
        together = field(points[:, None], force=forces, material=material)
        assert together.shape[:2] == (len(points), len(forces))
        for j, force in enumerate(forces):
            np.testing.assert_array_equal(together[:, j], field(points, force=force, material=material))


@pytest.mark.parametrize("load", LOADS)
def test_fields_continue_above_the_plane(load, hooke, divergence):
    material = Material(2.0, 0.3)
    point = np.array([0.8, -0.5, -0.3])

    def stress(p):
        return boussinesq.stress(p, force=load, material=material, above=0.5)

    def displacement(p):
        return boussinesq.displacement(p, force=load, material=material, above=0.5)

    # Fourth-order differences of fields that vary over 0.6.
    np.testing.assert_allclose(stress(point), hooke(displacement, point, material, 1e-3), rtol=0, atol=2e-9)
    np.testing.assert_allclose(divergence(stress, point, 1e-3), 0.0, rtol=0, atol=2e-9)


def test_bad_input_is_named():
    material = Material(1.0, 0.3)
    with refused(InputError, "points-outside-body", "z >= 0"):
        boussinesq.displacement([0.0, 0.0, -1.0], force=(0, 0, 1), material=material)
    with refused(InputError, "input", "origin"):
        boussinesq.stress([0.0, 0.0, 0.0], force=(0, 0, 1), material=material)
    with refused(InputError, "wrong-shape", "with 3"):
        boussinesq.stress([0.0, 0.0], force=(0, 0, 1), material=material)
    with refused(InputError, "forces"):
        boussinesq.stress([0.0, 0.0, 1.0], force=np.ones((3, 2)), material=material)
    with refused(InputError, "points-outside-body", "-0.5 times the distance"):
        boussinesq.stress([0.0, 0.1, -0.1], force=(0, 0, 1), material=material, above=0.5)
    with refused(InputError, "above-range", "1.0"):
        boussinesq.stress([0.0, 0.0, 1.0], force=(0, 0, 1), material=material, above=1.0)
    with refused(InputError, "input", "under the load"):
        boussinesq.surface_displacement([1.0, 0.0], force=1.0, modulus=1.0)
