import numpy as np
import pytest
from refusals import refused
from scipy.integrate import quad

from fecontact import InputError, Material
from fecontact.analytic import boussinesq, hertz

STEEL = Material(E=210e3, nu=0.3)
PLANE = (np.inf, np.inf)


def chord_displacement(contact, x, y):
    """Surface displacement as integral of p/distance: chords through the point, whose share is known (semicircle)."""

    def chord(angle):
        c, d = np.cos(angle), np.sin(angle)
        q0 = (x / contact.a) ** 2 + (y / contact.b) ** 2
        q1 = x * c / contact.a**2 + y * d / contact.b**2
        q2 = (c / contact.a) ** 2 + (d / contact.b) ** 2
        return max(1 - q0 + q1**2 / q2, 0.0) * np.pi / 2 / np.sqrt(q2)

    toward = np.arctan2(y, x)
    # Broken at the direction of the centre; the kinks where chords leave the ellipse limit quad() to about 1e-9.
    parts = quad(chord, toward - np.pi / 2, toward, limit=400, epsabs=0, epsrel=1e-11)[0]
    parts += quad(chord, toward, toward + np.pi / 2, limit=400, epsabs=0, epsrel=1e-11)[0]
    return contact.p0 / (np.pi * contact.E_star) * parts


@pytest.mark.parametrize(
    ("radii", "a", "b", "p0", "approach"),
    [
        ((20.0, 10.0), 0.5645994, 0.3560339, 2375.2517, 0.01430732),
        ((40.0, 10.0), 0.7810039, 0.3123133, 1957.4813, 0.01250157),
        ((100.0, 10.0), 1.1731023, 0.2607214, 1561.0931, 0.01027963),
    ],
)
def test_reference_ellipses(radii, a, b, p0, approach):
    # VERIFICATION 2, to the digits printed there.
    contact = hertz.ellipse(radii=(radii, PLANE), materials=(STEEL, STEEL), force=1000.0)
    assert contact.a == pytest.approx(a, abs=6e-8)
    assert contact.b == pytest.approx(b, abs=6e-8)
    assert contact.p0 == pytest.approx(p0, abs=6e-5)
    assert contact.approach == pytest.approx(approach, abs=6e-9)


def test_circle_is_the_limit():
    circle = hertz.spheres(radii=(10.0, np.inf), materials=(STEEL, None), force=1000.0)
    for excess in (0.0, 1e-15, 1e-12, 1e-8, 1e-4):
        contact = hertz.ellipse(radii=((10.0 * (1 + excess), 10.0), PLANE), materials=(STEEL, None), force=1000.0)
        # a/b - 1 = (2/3) excess to first order.
        assert contact.a / contact.b - 1 == pytest.approx(2 / 3 * excess, abs=1e-14, rel=1e-3)
        assert contact.approach == pytest.approx(circle.approach, rel=1e-14 + excess)
        assert contact.p0 == pytest.approx(circle.p0, rel=1e-13 + excess)


@pytest.mark.parametrize("ratio", [1e2, 1e5, 1e10, 1e14])
def test_very_long_ellipses_satisfy_the_asymptote(ratio):
    contact = hertz.ellipse(radii=((ratio, 1.0), PLANE), materials=(Material(1.0, 0.0), None), force=1e-6)
    k = contact.b / contact.a
    # K - E -> log(4/k) - 1 and E -> 1 for k -> 0, with errors of order k^2 log k.
    assert pytest.approx(1 / (k**2 * (np.log(4 / k) - 1)), rel=1e-12 + 10 * k) == contact.B / contact.A
    assert contact.approach == pytest.approx(contact.p0 * contact.b * np.log(4 / k), rel=1e-12 + 10 * k**2)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.0, np.pi / 2, 2.5, -0.7])
def test_curvatures_at_any_angle_are_those_of_the_summed_forms(angle):
    radii = ((7.0, 3.0), (-40.0, 5.0))
    contact = hertz.ellipse(radii=radii, materials=(STEEL, STEEL), angle=angle, force=1.0)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    form = np.diag([1 / 7.0, 1 / 3.0]) / 2 + turn @ np.diag([-1 / 40.0, 1 / 5.0]) @ turn.T / 2
    values, vectors = np.linalg.eigh(form)
    assert pytest.approx(values[0], rel=1e-13) == contact.A
    assert pytest.approx(values[1], rel=1e-13) == contact.B
    along = np.array([np.cos(contact.angle), np.sin(contact.angle)])
    assert abs(along @ vectors[:, 0]) == pytest.approx(1.0, abs=1e-13)
    assert -np.pi / 2 < contact.angle <= np.pi / 2


def test_cylinders_crossed_at_a_small_angle_keep_their_digits():
    for angle in (1e-3, 1e-6):
        contact = hertz.ellipse(
            radii=((np.inf, 10.0), (np.inf, 10.0)), materials=(STEEL, STEEL), angle=angle, force=1.0
        )
        # Equal cylinders: A = (1 - cos(angle))/(2R), which subtraction would lose at 1e-6.
        assert pytest.approx(np.sin(angle / 2) ** 2 / 10, rel=1e-13) == contact.A


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.4, 0.0), (0.3, 0.2), (0.0, 0.9), (1.5, 0.1), (3.0, 2.0)])
def test_displacement_is_that_of_summed_point_loads(place):
    contact = hertz.ellipse(radii=((40.0, 10.0), PLANE), materials=(STEEL, STEEL), force=1000.0)
    expected = chord_displacement(contact, *place)
    assert float(contact.displacement(*place)) == pytest.approx(expected, rel=1e-8)


def test_bodies_touch_inside_and_do_not_outside():
    contact = hertz.ellipse(radii=((100.0, 10.0), PLANE), materials=(STEEL, STEEL), force=1000.0)
    angle = np.linspace(0, 2 * np.pi, 25)
    for scale in (0.2, 0.9, 1.0):
        x, y = scale * contact.a * np.cos(angle), scale * contact.b * np.sin(angle)
        gap = contact.A * x**2 + contact.B * y**2 - contact.approach + contact.displacement(x, y)
        # Terms of the size of the approach, rounding.
        np.testing.assert_allclose(gap, 0.0, rtol=0, atol=1e-13 * contact.approach)
    x, y = 1.01 * contact.a * np.cos(angle), 1.01 * contact.b * np.sin(angle)
    assert np.all(contact.A * x**2 + contact.B * y**2 - contact.approach + contact.displacement(x, y) > 0)


def test_displacement_far_away_is_that_of_a_point_load():
    contact = hertz.ellipse(radii=((40.0, 10.0), PLANE), materials=(STEEL, STEEL), force=1000.0)
    for r in (1e5, 1e10):
        expected = contact.force / (np.pi * contact.E_star * r)
        found = contact.displacement(r * np.cos(0.7), r * np.sin(0.7))
        assert float(found) == pytest.approx(expected, rel=1e-9)  # next term (a/r)^2 = 6e-11


def test_pressure_carries_the_force():
    contact = hertz.ellipse(radii=((40.0, 10.0), PLANE), materials=(STEEL, STEEL), force=1000.0)
    t, w = np.polynomial.legendre.leggauss(40)
    t, w = (t + 1) * np.pi / 4, w * np.pi / 4
    angle = 2 * np.pi * np.arange(8) / 8
    x = contact.a * np.outer(np.sin(t), np.cos(angle))
    y = contact.b * np.outer(np.sin(t), np.sin(angle))
    values = contact.pressure(x, y).mean(axis=1)
    total = 2 * np.pi * contact.a * contact.b * np.sum(w * values * np.sin(t) * np.cos(t))
    assert total == pytest.approx(1000.0, rel=1e-12)  # analytic integrand
    assert contact.mean_pressure == pytest.approx(1000.0 / (np.pi * contact.a * contact.b), rel=1e-14)
    assert float(contact.pressure(contact.a * 1.001, 0.0)) == 0.0


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.4999])
@pytest.mark.parametrize("z", [0.3, 1.0, 4.0])
def test_stress_on_the_axis_is_that_of_summed_point_loads(nu, z):
    material = Material(E=1.0, nu=nu)
    contact = hertz.ellipse(radii=((40.0, 10.0), PLANE), materials=(material, None), force=1e-3)
    t, w = np.polynomial.legendre.leggauss(80)
    t, w = (t + 1) * np.pi / 4, w * np.pi / 4
    angle = 2 * np.pi * np.arange(200) / 200
    points = np.zeros((80, 200, 3))
    points[..., 0] = contact.a * np.outer(np.sin(t), np.cos(angle))
    points[..., 1] = contact.b * np.outer(np.sin(t), np.sin(angle))
    points[..., 2] = z * contact.a
    weight = w * contact.p0 * np.cos(t) ** 2 * np.sin(t) * contact.a * contact.b * 2 * np.pi / 200
    tensor = np.einsum("t,taij->ij", weight, boussinesq.stress(points, force=(0, 0, 1), material=material))
    stress = contact.stress_on_axis(z * contact.a)
    found = np.array([stress.xx, stress.yy, stress.zz])
    # 80 x 200 points at depths of 0.3 a and more: better than 1e-10 of p0.
    np.testing.assert_allclose(found, tensor.diagonal(), rtol=0, atol=1e-10 * contact.p0)


def test_stress_on_the_axis_of_circle_and_line_limits():
    z = np.array([0.0, 1e-8, 0.2, 0.7, 3.0])
    circle = hertz.spheres(radii=(10.0, np.inf), materials=(STEEL, None), force=1000.0)
    nearly = hertz.ellipse(radii=((10.0 + 1e-12, 10.0), PLANE), materials=(STEEL, None), force=1000.0)
    expected, found = circle.stress_on_axis(z * circle.a), nearly.stress_on_axis(z * circle.a)
    for one, other in ((expected.rr, found.xx), (expected.tt, found.yy), (expected.zz, found.zz)):
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-12 * circle.p0)
    line = hertz.line(radii=(1.0, np.inf), materials=(STEEL, None), force=1.0)
    long = hertz.ellipse(radii=((1e10, 1.0), PLANE), materials=(STEEL, None), force=1.0)
    expected, found = line.stress_on_axis(z * line.a), long.stress_on_axis(z * long.b)
    for name in ("xx", "yy", "zz"):
        one = getattr(expected, {"xx": "yy", "yy": "xx", "zz": "zz"}[name]) / line.p0
        np.testing.assert_allclose(getattr(found, name) / long.p0, one, rtol=0, atol=1e-5)  # (b/a)^2 log(a/b) z


def test_largest_shear_lies_between_circle_and_line():
    for ratio, low, high in ((1.0 + 1e-9, 0.309, 0.311), (3.0, 0.30, 0.33), (1e8, 0.299, 0.301)):
        contact = hertz.ellipse(radii=((ratio, 1.0), PLANE), materials=(Material(1.0, 0.3), None), force=1e-3)
        shear, depth = contact.max_shear()
        assert low < shear / contact.p0 < high  # Johnson 1985, table 4.1: 0.31, 0.32, 0.30
        grid = contact.stress_on_axis(np.linspace(0, contact.b, 1001)).max_shear
        assert shear == pytest.approx(grid.max(), rel=1e-5)
        assert 0.4 < depth / contact.b < 0.8


def test_force_and_approach_are_inverse_of_each_other():
    one = hertz.ellipse(radii=((7.0, 3.0), (4.0, 5.0)), angle=0.4, materials=(STEEL, STEEL), force=12.0)
    other = hertz.ellipse(radii=((7.0, 3.0), (4.0, 5.0)), angle=0.4, materials=(STEEL, STEEL), approach=one.approach)
    assert other.force == pytest.approx(12.0, rel=1e-13)
    assert other.stiffness == pytest.approx(1.5 * 12.0 / one.approach, rel=1e-13)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"radii": ((np.inf, 10.0), PLANE)}, ("no-point-contact",)),
        ({"radii": ((10.0, 10.0), (-9.0, 20.0))}, ("no-point-contact",)),
        ({"radii": (PLANE, PLANE)}, ("no-point-contact",)),
        ({"radii": ((10.0, 0.0), PLANE)}, ("radii", "((10.0, 0.0), (inf, inf))")),
        ({"radii": (10.0, 10.0)}, ("radii", "(10.0, 10.0)")),
        ({"radii": ((10.0, np.nan), PLANE)}, ("no-point-contact",)),
        ({"radii": ((10.0, 5.0), PLANE), "angle": np.inf}, ("not-finite", "The angle")),
        ({"radii": ((10.0, 5.0), PLANE), "approach": 1.0}, ("one-of", "force=, approach=")),
    ],
)
def test_bad_input_is_named(arguments, message):
    with refused(InputError, *message):
        hertz.ellipse(**{"materials": (STEEL, None), "force": 1.0, **arguments})
