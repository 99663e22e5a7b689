import numpy as np
import pytest
from refusals import refused
from scipy.integrate import quad

from fecontact import InputError, Material
from fecontact.analytic import hertz

STEEL = Material(E=210e3, nu=0.3)


def unit_contact(nu=0.3):
    """Half-width 1, p0 = 1, R = 1."""
    contact = hertz.line(radii=(1.0, np.inf), materials=(Material(2 * (1 - nu**2), nu), None), force=np.pi / 2)
    assert contact.a == pytest.approx(1.0, rel=1e-15)
    assert contact.p0 == pytest.approx(1.0, rel=1e-15)
    return contact


def flamant(x, z):
    """Stress from the pressure as a sum of line loads (Flamant): xx, zz, xz."""

    def part(weight):
        # s = sin(t) makes the pressure analytic; quad() resolves the peak at s = x.
        return quad(
            lambda t: np.cos(t) ** 2 * weight(x - np.sin(t)),
            -np.pi / 2,
            np.pi / 2,
            epsabs=1e-13,
            limit=400,
            points=[np.arcsin(np.clip(x, -0.99, 0.99))],
        )[0]

    factor = -2 / np.pi
    return (
        factor * part(lambda d: d**2 * z / (d**2 + z**2) ** 2),
        factor * part(lambda d: z**3 / (d**2 + z**2) ** 2),
        factor * part(lambda d: d * z**2 / (d**2 + z**2) ** 2),
    )


def test_textbook_values():
    # VERIFICATION 3.
    contact = hertz.line(radii=(10.0, 30.0), materials=(STEEL, STEEL), force=1000.0)
    a = np.sqrt(4 * 1000.0 * 7.5 / (np.pi * contact.E_star))
    assert contact.a == pytest.approx(a, rel=1e-14)
    assert contact.p0 == pytest.approx(2000.0 / (np.pi * a), rel=1e-14)
    assert contact.mean_pressure == pytest.approx(500.0 / a, rel=1e-14)


def test_pressure_carries_the_force():
    contact = unit_contact()
    total = quad(lambda t: float(contact.pressure(np.sin(t))) * np.cos(t), -np.pi / 2, np.pi / 2)[0]
    assert total == pytest.approx(contact.force, rel=1e-12)


@pytest.mark.parametrize("place", [(0.0, 0.3), (0.5, 0.1), (-0.9, 0.2), (1.0, 0.5), (2.0, 0.3), (0.2, 6.0)])
def test_stress_is_that_of_summed_line_loads(place):
    stress = unit_contact().stress(*place)
    np.testing.assert_allclose([stress.xx, stress.zz, stress.xz], flamant(*place), rtol=0, atol=1e-10)
    assert float(stress.yy) == pytest.approx(0.3 * float(stress.xx + stress.zz), abs=1e-15)


def test_stress_is_in_equilibrium(divergence):
    contact = unit_contact()

    def cartesian(point):
        s = contact.stress(point[0], point[2])
        return np.array([[s.xx, 0, s.xz], [0, s.yy, 0], [s.xz, 0, s.zz]])

    for point in ([0.3, 0.0, 0.4], [-1.3, 0.0, 0.3], [0.0, 0.0, 2.0]):
        assert np.abs(divergence(cartesian, np.array(point), 2e-3)).max() < 1e-8  # fourth order, step 2e-3


def test_stress_at_the_surface():
    x = np.array([-1.5, -1.0, -0.3, 0.0, 0.99, 1.0, 1e6])
    stress = unit_contact().stress(x, 0.0)
    pressure = unit_contact().pressure(x)
    np.testing.assert_allclose(stress.zz, -pressure, rtol=0, atol=1e-15)
    np.testing.assert_allclose(stress.xx, -pressure, rtol=0, atol=1e-15)
    np.testing.assert_allclose(stress.xz, 0.0, rtol=0, atol=1e-15)


def test_stress_far_away_is_that_of_a_line_load():
    for scale in (1e5, 1e9):
        x, z = 0.6 * scale, 0.8 * scale
        stress = unit_contact().stress(x, z)
        factor = -2 * (np.pi / 2) / (np.pi * scale)
        expected = factor * np.array([0.6**2 * 0.8, 0.8**3, 0.6 * 0.8**2])
        # Next term (a/r)^2; direct subtraction of m - z would leave no digit at 1e9.
        np.testing.assert_allclose([stress.xx, stress.zz, stress.xz], expected, rtol=1e-9)


def test_axis_agrees_with_the_textbook():
    z = np.array([0.0, 0.2, 1.0, 4.0])
    stress = unit_contact().stress_on_axis(z)
    root = np.sqrt(1 + z**2)
    # Johnson 1985, eq. (4.46).
    np.testing.assert_allclose(stress.xx, -((1 + 2 * z**2) / root - 2 * z), rtol=0, atol=1e-14)
    np.testing.assert_allclose(stress.zz, -1 / root, rtol=1e-14)


def test_largest_shear():
    shear, depth = unit_contact().max_shear()
    # Johnson 1985, eq. (4.47) gives 0.30 and 0.78; more digits by maximising on a grid.
    z = np.linspace(0, 2, 20001)
    grid = unit_contact().stress_on_axis(z)
    in_plane = np.abs(grid.xx - grid.zz) / 2
    assert shear == pytest.approx(in_plane.max(), rel=1e-7)
    assert depth == pytest.approx(z[in_plane.argmax()], abs=2e-4)


def test_displacement_and_gap():
    contact = unit_contact()
    x = np.array([-3.0, -1.2, 0.5, 1.0, 1.7])
    # The gap by its own slope, sqrt(x^2 - 1) outside (Johnson 1985, section 4.2(c)).
    expected = [quad(lambda t: np.sqrt(t**2 - 1), 1, abs(v))[0] if abs(v) > 1 else 0.0 for v in x]
    np.testing.assert_allclose(contact.gap(x), expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(contact.gap(x), x**2 / 2 + contact.displacement(x), rtol=0, atol=1e-15 * 30)
    distance = 1e-9
    lead = 2 * np.sqrt(2) / 3 * ((1 + distance) - 1) ** 1.5
    assert float(contact.gap(1 + distance)) == pytest.approx(lead, rel=1e-7)
    # Far away the displacement falls as -(1/2)(log(2x) + 1/2): a line load; rounding only.
    assert float(contact.displacement(1e12)) == pytest.approx(-(np.log(2e12) + 0.5) / 2, rel=1e-13)


def test_displacement_is_that_of_summed_line_loads():
    contact = unit_contact()
    # Relative displacement of a half-plane: -(2/(pi E*)) integral of p(s) log|(x - s)/s|.
    for x in (0.4, 1.6):
        total = quad(
            lambda t, x=x: -(np.cos(t) ** 2) * np.log(abs((x - np.sin(t)) / np.sin(t))) if np.sin(t) != 0 else 0.0,
            -np.pi / 2,
            np.pi / 2,
            points=[0.0, np.arcsin(min(x, 1.0))],
            limit=400,
        )[0]
        assert float(contact.displacement(x)) == pytest.approx(2 / (np.pi * contact.E_star) * total, rel=1e-8)


def test_bad_input_is_named():
    with refused(InputError, "not-positive", "The force per length"):
        hertz.line(radii=(1.0, np.inf), materials=(STEEL, None), force=-1.0)
    with refused(InputError, "surfaces-do-not-touch"):
        hertz.line(radii=(1.0, -1.0), materials=(STEEL, None), force=1.0)
    with refused(InputError, "not-finite", "x"):
        unit_contact().stress(np.inf, 0.0)
