import numpy as np
import pytest
from refusals import refused

from fecontact import InputError, Material
from fecontact.analytic import boussinesq, rectangle

SIDES = (1.0, 0.6)
PLACES = [[0.3, 0.2, 0.4], [-1.2, 0.5, 0.3], [0.0, 0.0, 2.0], [1.0, 0.6, 0.5], [0.4, 0.6, 0.25]]


def summed(field, place, material, order=120):
    """Field of the rectangle as a sum of point loads."""
    t, w = np.polynomial.legendre.leggauss(order)
    points = np.zeros((order, order, 3))
    points[..., 0] = place[0] - SIDES[0] * t[:, None]
    points[..., 1] = place[1] - SIDES[1] * t[None, :]
    points[..., 2] = place[2]
    values = field(points, force=(0.0, 0.0, 1.0), material=material)
    return np.einsum("a,b,ab...->...", w * SIDES[0], w * SIDES[1], values)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.4999])
@pytest.mark.parametrize("place", PLACES)
def test_fields_are_those_of_summed_point_loads(nu, place):
    material = Material(E=2.0, nu=nu)
    arguments = {"half_sides": SIDES, "pressure": 1.0, "material": material}
    # 120 points per side at depths of 0.25 and more: geometric convergence to rounding.
    np.testing.assert_allclose(
        rectangle.displacement(place, **arguments), summed(boussinesq.displacement, place, material), rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(
        rectangle.stress(place, **arguments), summed(boussinesq.stress, place, material), rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("place", PLACES)
def test_stress_is_in_equilibrium_and_follows_from_the_displacement(place, divergence, hooke):
    material = Material(E=2.0, nu=0.3)
    arguments = {"half_sides": SIDES, "pressure": 1.0, "material": material}
    point = np.array(place)
    found = divergence(lambda p: rectangle.stress(p, **arguments), point, 1e-3)
    assert np.abs(found).max() < 1e-8  # fourth-order differences, step 1e-3
    expected = hooke(lambda p: rectangle.displacement(p, **arguments), point, material, 1e-3)
    assert np.abs(rectangle.stress(point, **arguments) - expected).max() < 1e-8


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.3, -0.5), (1.0, 0.6), (1.0, 0.1), (1.7, 0.6), (-4.0, 3.0)])
def test_surface_displacement_is_the_integral_of_one_over_distance(place):
    # Four right triangles per corner pair: exact integral of 1/d by polar coordinates about the point,
    # integral over each side of h/cos, the log of (tan + sec), by Gauss quadrature over the angle.
    t, w = np.polynomial.legendre.leggauss(200)
    total = 0.0
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * np.array(SIDES) - np.array(place)
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = (end - start) / np.linalg.norm(end - start)
        height = start[0] * along[1] - start[1] * along[0]  # signed distance of the side
        if abs(height) < 1e-14:
            continue
        low, high = np.arctan2(start @ along, abs(height)), np.arctan2(end @ along, abs(height))
        angle = low + (high - low) * (t + 1) / 2
        total += height * (high - low) / 2 * np.sum(w / np.cos(angle))
    found = rectangle.surface_displacement(*place, half_sides=SIDES, pressure=np.pi, modulus=1.0)
    assert float(found) == pytest.approx(total, rel=1e-12)  # 200 points on a smooth secant


def test_surface_and_interior_agree():
    material = Material(E=2.0, nu=0.3)
    x, y = np.meshgrid(np.linspace(-9, 9, 7), np.linspace(-1, 1, 5))
    surface = rectangle.surface_displacement(
        x, y, half_sides=SIDES, pressure=3.0, modulus=material.plane_strain_modulus
    )
    points = np.stack([x, y, np.zeros_like(x)], axis=-1)
    inside = rectangle.displacement(points, half_sides=SIDES, pressure=3.0, material=material)
    np.testing.assert_allclose(inside[..., 2], surface, rtol=1e-13)


def test_surface_tractions():
    x, y = np.array([0.0, 0.9, 1.1, 1.0, 1.0, 0.5]), np.array([0.0, -0.5, 0.0, 0.0, 0.6, -0.6])
    points = np.stack([x, y, np.zeros_like(x)], axis=-1)
    stress = rectangle.stress(points[[0, 1, 2, 3, 5]], half_sides=SIDES, pressure=2.0, material=Material(1.0, 0.3))
    np.testing.assert_allclose(stress[..., 2, 2], [-2.0, -2.0, 0.0, -1.0, -1.0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(stress[..., :2, 2], 0.0, rtol=0, atol=1e-15)
    corner = rectangle.stress(points[4], half_sides=SIDES, pressure=2.0, material=Material(1.0, 0.3))
    assert corner[2, 2] == pytest.approx(-0.5, abs=1e-15)
    assert np.isinf(corner[0, 1])


def test_fields_join_where_the_quadrature_takes_over():
    # The factor FAR = 6 times the longer half-side; a jump would be an error of one of both.
    material = Material(1.0, 0.3)
    arguments = {"half_sides": SIDES, "pressure": 1.0, "material": material}
    for direction in ([1.0, 0.0, 0.0], [0.6, 0.0, 0.8], [0.3, 0.9, 0.1], [0.0, 0.0, 1.0]):
        unit = np.array(direction) / np.linalg.norm(direction)
        near, far = 6 * unit * (1 - 1e-14), 6 * unit * (1 + 1e-14)
        size = np.abs(rectangle.stress(near, **arguments)).max()
        jump = rectangle.stress(near, **arguments) - rectangle.stress(far, **arguments)
        # Rounding of the corner sums (terms of order 1) against a field of 1e-2, that is 1e-13 of it.
        assert np.abs(jump).max() < 1e-12 * size
        jump = rectangle.displacement(near, **arguments) - rectangle.displacement(far, **arguments)
        assert np.abs(jump).max() < 1e-14


def test_far_away_it_is_a_point_load():
    material = Material(1.0, 0.3)
    point = 1e6 * np.array([0.6, 0.0, 0.8])
    arguments = {"half_sides": SIDES, "pressure": 1.0, "material": material}
    force = (0.0, 0.0, 4 * SIDES[0] * SIDES[1])
    expected = boussinesq.stress(point, force=force, material=material)
    found = rectangle.stress(point, **arguments)
    # Next term (size/distance)^2 = 1e-12; the corner sums alone would have lost 12 digits.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


def test_planes_below_carry_the_load():
    t, w = np.polynomial.legendre.leggauss(200)
    reach = np.sinh(6 * t)  # x = sinh(s) covers +-200 half-sides with points dense in the middle
    weight = w * 6 * np.cosh(6 * t)
    x, y = np.meshgrid(reach, reach, indexing="ij")
    points = np.stack([x, y, np.full_like(x, 0.7)], axis=-1)
    zz = rectangle.stress(points, half_sides=SIDES, pressure=1.0, material=Material(1.0, 0.3))[..., 2, 2]
    total = -np.einsum("a,b,ab->", weight, weight, zz)
    # What lies beyond 200 half-sides is of order (0.7/200)^3 = 4e-8.
    assert total == pytest.approx(4 * SIDES[0] * SIDES[1], rel=1e-6)


def test_no_digits_are_lost_at_tiny_depth():
    material = Material(1.0, 0.3)
    arguments = {"half_sides": SIDES, "pressure": 1.0, "material": material}
    for place in ([0.5, 0.2, 0.0], [1.5, 0.6, 0.0], [-1.0, 0.3, 0.0]):
        surface = rectangle.displacement(place, **arguments)
        below = rectangle.displacement([place[0], place[1], 1e-13], **arguments)
        assert np.abs(below - surface).max() < 1e-11  # slopes of order log(1e13) times 1e-13


def test_bad_input_is_named():
    material = Material(1.0, 0.3)
    with refused(InputError, "not-positive", "The half-side b"):
        rectangle.stress([0, 0, 1.0], half_sides=(1.0, 0.0), pressure=1.0, material=material)
    with refused(InputError, "no-load", "pressure"):
        rectangle.stress([0, 0, 1.0], half_sides=(1.0, 1.0), material=material)
    with refused(InputError, "half-sides", "1.0"):
        rectangle.stress([0, 0, 1.0], half_sides=1.0, pressure=1.0, material=material)
    with refused(InputError, "input", "z >= 0"):
        rectangle.displacement([0, 0, -1.0], half_sides=SIDES, pressure=1.0, material=material)
    with refused(InputError, "not-finite", "The pressure"):
        rectangle.surface_displacement(0.0, 0.0, half_sides=SIDES, pressure=np.nan, modulus=1.0)


@pytest.mark.by_day("1e-09-1e-09-0.0", "0.3-0.30000000000000004--0.0")
@pytest.mark.parametrize("zero", [0.0, -0.0])
@pytest.mark.parametrize(("a", "x"), [(0.3, 0.1 + 0.2), (1.0, 1.0), (1e-9, 1e-9)])
def test_edges_and_corners_are_the_mean_of_their_sides(zero, a, x):
    """Whatever the sign of zero, and where the edge is met but for rounding."""
    b, steel = 2 * a, Material(E=1.0, nu=0.3)
    options = {"half_sides": (a, b), "pressure": 1.0, "material": steel}
    for sx, sy in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        for point, share in (((sx * x, 0.3 * b), 0.5), ((0.3 * a, sy * b), 0.5), ((sx * x, sy * b), 0.25)):
            found = rectangle.stress([*point, zero], **options)
            h = 1e-7 * a
            sides = [[point[0] + i * h, point[1] + j * h, 0.0] for i in (-1, 1) for j in (-1, 1)]
            mean = rectangle.stress(sides, **options).mean(axis=0)
            # the field changes by about p over a, and is rounded to 1e-16 / 1e-7
            assert abs(found[2, 2] + share) < 1e-12
            assert np.abs(found - mean)[[0, 1, 2], [0, 1, 2]].max() < 1e-6
            assert np.abs(found[2, :2]).max() < 1e-12
            if share == 0.5:
                assert abs(found[0, 1] - mean[0, 1]) < 1e-6
            else:  # infinite, or as at a distance that is given
                assert abs(found[0, 1]) == np.inf
                near = rectangle.stress([*point, zero], corner_distance=h * 2**0.5, **options)
                assert abs(near[0, 1] - mean[0, 1]) < 1e-6
            moved = rectangle.displacement([*point, zero], **options)
            assert np.abs(moved - rectangle.displacement(sides, **options).mean(axis=0)).max() < 1e-6 * a


def test_no_pressure_is_no_stress_at_a_corner():
    found = rectangle.stress([1.0, 1.0, 0.0], half_sides=(1.0, 1.0), pressure=0.0, material=Material(E=1.0, nu=0.3))
    assert not found.any()
