import numpy as np
import pytest
from refusals import refused
from scipy.integrate import quad

from fecontact import InputError, Material
from fecontact.analytic import disc, hertz

STEEL = Material(E=210e3, nu=0.3)
SOFT = Material(E=1.0, nu=0.0)


def unit_contact(nu=0.3):
    """a = 1, p0 = 1 to be read as units."""
    material = Material(E=np.pi / 2 * (1 - nu**2), nu=nu)
    return hertz.spheres(radii=(1.0, np.inf), materials=(material, None), approach=1.0)


def test_textbook_values_of_two_steel_spheres():
    # VERIFICATION 1, evaluated by hand from the cube-root formulas.
    contact = hertz.spheres(radii=(250.0, 250.0), materials=(STEEL, STEEL), force=7124.0)
    E_star = 210e3 / (1 - 0.09) / 2
    a = (3 * 7124.0 * 125.0 / (4 * E_star)) ** (1 / 3)
    assert contact.E_star == pytest.approx(E_star, rel=1e-15)
    assert contact.a == pytest.approx(a, rel=1e-15)
    assert contact.approach == pytest.approx(a**2 / 125.0, rel=1e-15)
    assert contact.p0 == pytest.approx(3 * 7124.0 / (2 * np.pi * a**2), rel=1e-14)
    assert contact.mean_pressure == pytest.approx(7124.0 / (np.pi * a**2), rel=1e-14)


@pytest.mark.parametrize(
    ("force", "a", "p0", "approach"), [(726.4, 0.18368, 10280.0, 0.002699), (454.0, 0.157044, 8789.4, 0.0019730)]
)
def test_half_spheres_of_the_report(force, a, p0, approach):
    # R = 25 cm, E = 2e6 kgf/cm^2, nu = 0.3; figures of Hertz's formulas to the digits given.
    material = Material(E=2.0e6, nu=0.3)
    contact = hertz.spheres(radii=(25.0, 25.0), materials=(material, material), force=force)
    assert contact.a == pytest.approx(a, rel=1e-4)
    assert contact.p0 == pytest.approx(p0, rel=1e-4)
    assert contact.approach == pytest.approx(approach, rel=1e-4)


def test_force_and_approach_are_inverse_of_each_other():
    by_force = hertz.spheres(radii=(3.0, -5.0), materials=(STEEL, SOFT), force=0.02)
    by_approach = hertz.spheres(radii=(3.0, -5.0), materials=(STEEL, SOFT), approach=by_force.approach)
    assert by_approach.force == pytest.approx(0.02, rel=1e-14)
    assert by_approach.a == pytest.approx(by_force.a, rel=1e-14)


def test_stiffness_is_the_slope_of_force_over_approach():
    def load(approach):
        return hertz.spheres(radii=(3.0, 5.0), materials=(STEEL, SOFT), approach=approach).force

    contact = hertz.spheres(radii=(3.0, 5.0), materials=(STEEL, SOFT), approach=0.01)
    # Central difference of P ~ delta^1.5: error (h/delta)^2/24 = 4e-8 for h = 1e-3 delta.
    assert contact.stiffness == pytest.approx((load(0.010005) - load(0.009995)) / 1e-5, rel=1e-7)


def test_pressure_carries_the_force():
    contact = unit_contact()
    # r = sin(t) makes the integrand analytic: quadrature is exact to rounding.
    total = quad(lambda t: 2 * np.pi * np.sin(t) * np.cos(t) * float(contact.pressure(np.sin(t))), 0, np.pi / 2)[0]
    assert total == pytest.approx(contact.force, rel=1e-12)


@pytest.mark.parametrize("r", [0.0, 0.3, 0.999, 1.0, 1.001, 2.0, 30.0])
def test_displacement_is_that_of_summed_point_loads(r, ring_displacement):
    contact = unit_contact()
    if r == 0:
        expected = quad(lambda s: 2 / contact.E_star * float(contact.pressure(s)), 0, 1, epsabs=1e-13)[0]
    else:
        expected = ring_displacement(contact.pressure, 1.0, r, contact.E_star)
    # quad() reaches about 1e-9 over the logarithm under the ring.
    assert float(contact.displacement(r)) == pytest.approx(expected, rel=1e-8)


def test_displacement_far_away_is_that_of_a_point_load():
    contact = unit_contact()
    for r in (1e4, 1e8, 1e14):
        # The next term is (a/r)^2 / 5 of it.
        expected = contact.force / (np.pi * contact.E_star * r)
        assert float(contact.displacement(r)) == pytest.approx(expected, rel=1e-14 + r**-2)


def test_gap_is_geometry_less_approach_plus_displacement():
    contact = unit_contact()
    r = np.array([0.0, 0.5, 1.0, 1.1, 2.0, 7.0])
    direct = r**2 / 2 - contact.approach + contact.displacement(r)
    np.testing.assert_allclose(contact.gap(r), direct, rtol=0, atol=2e-14)  # rounding of terms up to 25
    # Near the edge the gap opens as (8 sqrt(2)/(3 pi)) (r - 1)^(3/2), where the direct form has no digit left.
    for distance in (1e-6, 1e-9):
        lead = 8 * np.sqrt(2) / (3 * np.pi) * ((1 + distance) - 1) ** 1.5
        assert float(contact.gap(1 + distance)) == pytest.approx(lead, rel=10 * distance)


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.4999])
@pytest.mark.parametrize(("r", "z"), [(0.0, 0.5), (0.4, 0.3), (1.0, 0.5), (1.7, 0.4), (0.3, 5.0)])
def test_stress_is_that_of_summed_point_loads(nu, r, z, summed_disc):
    stress = disc.hertz_stress(r, z, a=1.0, p0=1.0, nu=nu)
    tensor = summed_disc(lambda s: np.sqrt(1 - s**2), 1.0, np.array([r, 0.0, z]), Material(1.0, nu))
    # 80 x 128 points: geometric convergence, 1e-12 at the depths chosen.
    found = np.array([stress.rr, stress.tt, stress.zz, stress.rz])
    np.testing.assert_allclose(found, [tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 2]], rtol=0, atol=1e-11)


def test_stress_is_in_equilibrium(divergence):
    def cartesian(point):
        x, y, z = point
        r, angle = np.hypot(x, y), np.arctan2(y, x)
        s = disc.hertz_stress(r, z, a=1.0, p0=1.0, nu=0.3)
        c, n = np.cos(angle), np.sin(angle)
        turn = np.array([[c, -n, 0], [n, c, 0], [0, 0, 1]])
        return turn @ np.array([[s.rr, 0, s.rz], [0, s.tt, 0], [s.rz, 0, s.zz]]) @ turn.T

    for point in ([0.3, 0.2, 0.4], [1.2, -0.5, 0.3], [0.05, 0.0, 2.0]):
        # Differences of fourth order with step 2e-3: error 1e-10, rounding 1e-13.
        assert np.abs(divergence(cartesian, np.array(point), 2e-3)).max() < 1e-8


def test_stress_at_the_surface():
    r = np.array([0.0, 0.5, 0.99, 1.0, 1.5, 50.0])
    nu = 0.3
    stress = disc.hertz_stress(r, 0.0, a=1.0, p0=1.0, nu=nu)
    np.testing.assert_allclose(stress.zz, -disc.hertz_pressure(r, a=1.0, p0=1.0), rtol=0, atol=1e-15)
    np.testing.assert_allclose(stress.rz, 0.0, rtol=0, atol=1e-15)
    # Johnson 1985, eq. (3.43)-(3.44): pure shear outside, (1 - 2 nu)/3 at the edge.
    outside = (1 - 2 * nu) / (3 * np.maximum(r, 1.0) ** 2)
    np.testing.assert_allclose(stress.rr[r >= 1], outside[r >= 1], rtol=1e-14)
    np.testing.assert_allclose(stress.tt[r >= 1], -outside[r >= 1], rtol=1e-14)
    np.testing.assert_allclose(stress.rr[0], -(1 + 2 * nu) / 2, rtol=1e-14)


def test_stress_far_away_is_that_of_a_point_load():
    from fecontact.analytic import boussinesq

    nu = 0.3
    for scale in (1e5, 1e9):
        point = scale * np.array([0.6, 0.0, 0.8])
        found = disc.hertz_stress(point[0], point[2], a=1.0, p0=1.0, nu=nu)
        tensor = boussinesq.stress(point, force=(0, 0, 2 * np.pi / 3), material=Material(1.0, nu))
        expected = np.array([tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 2]])
        values = np.array([found.rr, found.tt, found.zz, found.rz])
        # Next term (a/r)^2 = 1e-10 of it; without stable forms nothing would be left at 1e9.
        np.testing.assert_allclose(values, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_stress_is_continuous_at_tiny_depth_and_radius():
    at_surface = disc.hertz_stress(0.7, 0.0, a=1.0, p0=1.0, nu=0.3)
    below = disc.hertz_stress(0.7, 1e-13, a=1.0, p0=1.0, nu=0.3)
    on_axis = disc.hertz_stress(0.0, 0.7, a=1.0, p0=1.0, nu=0.3)
    beside = disc.hertz_stress(1e-13, 0.7, a=1.0, p0=1.0, nu=0.3)
    for one, other in ((at_surface, below), (on_axis, beside)):
        for name in ("rr", "tt", "zz", "rz"):
            assert abs(float(getattr(one, name) - getattr(other, name))) < 1e-12  # slopes of order 1 times 1e-13


def test_axis_agrees_with_the_textbook():
    contact = unit_contact(nu=0.25)
    z = np.array([0.1, 0.5, 1.0, 3.0])
    stress = contact.stress_on_axis(z)
    # Johnson 1985, eq. (3.45).
    np.testing.assert_allclose(stress.zz, -1 / (1 + z**2), rtol=1e-13)
    lateral = -1.25 * (1 - z * np.arctan(1 / z)) + 0.5 / (1 + z**2)
    np.testing.assert_allclose(stress.rr, lateral, rtol=0, atol=1e-15)
    np.testing.assert_allclose(stress.tt, stress.rr, rtol=0, atol=1e-15)


def test_largest_shear_below_the_surface():
    contact = hertz.spheres(radii=(250.0, 250.0), materials=(STEEL, STEEL), force=7124.0)
    shear, depth = contact.max_shear()
    assert shear / contact.p0 == pytest.approx(0.310, abs=5e-4)  # Johnson 1985, table 4.1 gives two digits
    assert depth / contact.a == pytest.approx(0.48, abs=5e-3)
    grid = contact.stress_on_axis(np.linspace(0, 3 * contact.a, 3001)).max_shear
    # A grid of step a/1000 misses a parabola's top by less than 1e-6 of it.
    assert shear == pytest.approx(grid.max(), rel=1e-6)
    assert shear >= grid.max()


@pytest.mark.parametrize("nu", [-0.9, 0.0, 0.4999])
def test_largest_shear_for_all_materials(nu):
    contact = unit_contact(nu)
    shear, depth = contact.max_shear()
    grid = contact.stress_on_axis(np.linspace(0, 3, 3001)).max_shear
    assert shear == pytest.approx(grid.max(), rel=1e-6)
    assert 0 < depth < 1


@pytest.mark.parametrize("factor", [1e-9, 1e-3, 1e3, 1e9])
def test_any_units(factor):
    base = hertz.spheres(radii=(3.0, 5.0), materials=(STEEL, SOFT), force=0.1)
    lengths = hertz.spheres(radii=(3.0 * factor, 5.0 * factor), materials=(STEEL, SOFT), force=0.1 * factor**2)
    assert lengths.a == pytest.approx(base.a * factor, rel=1e-14)
    assert lengths.p0 == pytest.approx(base.p0, rel=1e-14)


def test_seat_and_plane():
    ball_in_seat = hertz.spheres(radii=(10.0, -11.0), materials=(STEEL, STEEL), force=1.0)
    assert pytest.approx(110.0, rel=1e-15) == ball_in_seat.R
    assert hertz.spheres(radii=(np.inf, 10.0), materials=(STEEL, STEEL), force=1.0).R == 10.0


def test_printing_gives_an_aligned_table():
    lines = str(unit_contact()).splitlines()
    columns = {line.index(line.split()[-1]) for line in lines[1:]}
    assert len(lines) == 9
    assert len(columns) == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"radii": (10.0, -10.0), "force": 1.0}, ("surfaces-do-not-touch",)),
        ({"radii": (10.0, -9.0), "force": 1.0}, ("surfaces-do-not-touch",)),
        ({"radii": (np.inf, np.inf), "force": 1.0}, ("surfaces-do-not-touch",)),
        ({"radii": (0.0, 1.0), "force": 1.0}, ("input", "not zero")),
        ({"radii": (np.nan, 1.0), "force": 1.0}, ("input", "not zero")),
        ({"radii": 3.0, "force": 1.0}, ("radii", "3.0")),
        ({"radii": (1.0, 1.0), "force": 0.0}, ("not-positive",)),
        ({"radii": (1.0, 1.0), "force": np.nan}, ("not-positive", "The force")),
        ({"radii": (1.0, 1.0), "force": "much"}, ("not-positive", "The force")),
        ({"radii": (1.0, 1.0), "approach": -1.0}, ("not-positive",)),
        ({"radii": (1.0, 1.0)}, ("one-of", "force=, approach=")),
        ({"radii": (1.0, 1.0), "force": 1.0, "approach": 1.0}, ("one-of", "force=, approach=")),
        ({"radii": (1.0, 1.0), "force": 1.0, "materials": (None, None)}, ("input", "rigid")),
        ({"radii": (1.0, 1.0), "force": 1.0, "materials": (STEEL, 3)}, ("no-body", "3")),
        ({"radii": (1.0, 1.0), "force": 1.0, "materials": STEEL}, ("input", "materials")),
    ],
)
def test_bad_input_is_named(arguments, message):
    with refused(InputError, *message):
        hertz.spheres(**{"materials": (STEEL, None), **arguments})


def test_bad_points_are_named():
    contact = hertz.spheres(radii=(1.0, 1.0), materials=(STEEL, None), force=1.0)
    with refused(InputError, "not-finite", "r"):
        contact.pressure([0.0, np.nan])
    with refused(InputError, "negative-depth", "r"):
        contact.pressure(-1.0)
    with refused(InputError, "not-numbers", "r"):
        contact.pressure("middle")
    with refused(InputError, "rigid-body"):
        contact.stress(0.0, 1.0, body=1)
    with refused(InputError, "unknown-body", "2"):
        contact.stress(0.0, 1.0, body=2)
