import math

import numpy as np
import pytest
from refusals import refused
from scipy.integrate import quad

from fecontact import InputError, Material
from fecontact.analytic import hertz, punch


def load(contact):
    # r = a sin(t) turns the root at the edge into a smooth integrand.
    a = contact.a
    return quad(
        lambda t: 2 * np.pi * a**2 * np.sin(t) * np.cos(t) * float(contact.pressure(a * np.sin(t))),
        0,
        np.pi / 2,
        epsabs=1e-13,
        limit=200,
    )[0]


def test_flat_punch():
    contact = punch.flat(radius=2.0, modulus=3.0, force=7.0)
    # VERIFICATION 4.
    assert contact.approach == pytest.approx(7.0 / (2 * 2.0 * 3.0), rel=1e-15)
    r = np.array([0.0, 1.0, 1.9])
    np.testing.assert_allclose(contact.pressure(r), 7.0 / (8 * np.pi) / np.sqrt(1 - r**2 / 4), rtol=1e-14)
    assert np.isinf(contact.pressure(2.0))
    assert load(contact) == pytest.approx(7.0, rel=1e-10)
    assert contact.mean_pressure == pytest.approx(7.0 / (4 * np.pi), rel=1e-15)
    other = punch.flat(radius=2.0, modulus=3.0, approach=contact.approach)
    assert other.force == pytest.approx(7.0, rel=1e-15)


@pytest.mark.parametrize("r", [0.5, 0.9, 1.2, 5.0])
def test_flat_punch_displaces_as_summed_rings(r, ring_displacement):
    contact = punch.flat(radius=1.0, modulus=3.0, force=7.0)
    # The root of infinity at the edge limits quad() to about 1e-7.
    expected = ring_displacement(contact.pressure, 1.0 - 1e-15, r, 3.0)
    assert float(contact.displacement(r)) == pytest.approx(expected, rel=1e-6)


def test_tilted_punch_carries_force_and_moment():
    a, e = 2.0, 0.5
    contact = punch.flat(radius=a, modulus=3.0, force=7.0, offset=e)
    t, w = np.polynomial.legendre.leggauss(40)
    t, w = (t + 1) * np.pi / 4, w * np.pi / 4
    angle = 2 * np.pi * np.arange(8) / 8
    x, y = a * np.outer(np.sin(t), np.cos(angle)), a * np.outer(np.sin(t), np.sin(angle))
    values = contact.pressure(x, y) * (w * a**2 * np.sin(t) * np.cos(t))[:, None] * 2 * np.pi / 8
    assert values.sum() == pytest.approx(7.0, rel=1e-12)  # analytic integrand
    assert (values * x).sum() == pytest.approx(7.0 * e, rel=1e-12)
    # Work: the couple 4 E* a^3 theta/3 (Johnson 1985, section 5.1).
    assert contact.tilt == pytest.approx(7.0 * e / (4 * 3.0 * a**3 / 3), rel=1e-14)


def test_tilted_punch_at_the_limit_of_full_contact():
    contact = punch.flat(radius=3.0, modulus=1.0, force=1.0, offset=1.0)
    x = np.linspace(-3, 3, 101)
    assert np.all(contact.pressure(x) >= 0)
    assert float(contact.pressure(-3.0)) == 0.0
    with refused(InputError, "punch-lifts-off", "1.001"):
        punch.flat(radius=3.0, modulus=1.0, force=1.0, offset=1.001)


@pytest.mark.parametrize("place", [(0.3, 0.2), (-0.5, 0.5), (1.3, 0.4), (-2.0, 0.0), (0.0, 1.7)])
def test_tilted_punch_displaces_as_summed_point_loads(place):
    contact = punch.flat(radius=1.0, modulus=2.0, force=7.0, offset=0.3)

    def chord(angle):
        # Along a chord p = (A + B s)/sqrt(quadratic): its integral is pi times the value of A + B s at the middle.
        c, s = np.cos(angle), np.sin(angle)
        middle = -(place[0] * c + place[1] * s)
        square = 1 - place[0] ** 2 - place[1] ** 2 + middle**2
        return np.pi * (1 + 3 * 0.3 * (place[0] + middle * c)) if square > 0 else 0.0

    distance = math.hypot(*place)
    half = np.pi / 2 if distance < 1 else math.asin(1 / distance)
    toward = math.atan2(place[1], place[0])
    expected = quad(chord, toward - half, toward + half, epsabs=1e-12)[0]
    expected *= contact.mean_pressure / 2 / (np.pi * contact.E_star)
    assert float(contact.displacement(*place)) == pytest.approx(expected, rel=1e-9)


def test_tilt_far_away_decays_as_a_couple():
    contact = punch.flat(radius=1.0, modulus=2.0, force=7.0, offset=0.3)
    central = punch.flat(radius=1.0, modulus=2.0, force=7.0)
    for r in (1e3, 1e5):
        couple = float(contact.displacement(r) - contact.displacement(-r)) / 2
        # M x/(pi E* r^3) with M = P e; the subtraction here costs r/0.3 in rounding.
        assert couple == pytest.approx(7.0 * 0.3 / (np.pi * 2.0 * r**2), rel=r**-2 + 1e-15 * r * 10)
        assert float(central.displacement(r)) == pytest.approx(7.0 / (np.pi * 2.0 * r), rel=r**-2)


def test_cone():
    beta = 0.1
    contact = punch.cone(angle=beta, modulus=3.0, approach=0.2)
    slope = math.tan(beta)
    # VERIFICATION 4.
    assert contact.a == pytest.approx(2 * 0.2 / (np.pi * slope), rel=1e-14)
    assert contact.force == pytest.approx(2 * 3.0 * 0.2**2 / (np.pi * slope), rel=1e-14)
    r = contact.a * np.array([1e-6, 0.3, 0.9, 1 - 1e-9])
    np.testing.assert_allclose(contact.pressure(r), 1.5 * slope * np.arccosh(contact.a / r), rtol=1e-12)
    assert np.isinf(contact.pressure(0.0))
    assert float(contact.pressure(contact.a * 1.1)) == 0.0


def test_paraboloid_is_hertz():
    sphere = hertz.spheres(radii=(5.0, np.inf), materials=(Material(1.0, 0.0), None), force=0.1)
    contact = punch.power(coefficient=0.1, exponent=2.0, modulus=1.0, force=0.1)
    r = sphere.a * np.array([0.0, 0.4, 0.99, 1.5, 100.0])
    assert contact.a == pytest.approx(sphere.a, rel=1e-14)
    assert contact.approach == pytest.approx(sphere.approach, rel=1e-14)
    np.testing.assert_allclose(contact.pressure(r), sphere.pressure(r), rtol=1e-13)
    np.testing.assert_allclose(contact.displacement(r), sphere.displacement(r), rtol=1e-12)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.1, 1.7, 2.0, 2.5, 3.0, 6.0, 20.0])
def test_power_law(exponent, ring_displacement):
    contact = punch.power(coefficient=0.3, exponent=exponent, modulus=2.0, a=1.3)
    assert load(contact) == pytest.approx(contact.force, rel=1e-7)  # quad() on the singular tip of exponent 0.5
    for other in (
        punch.power(coefficient=0.3, exponent=exponent, modulus=2.0, force=contact.force),
        punch.power(coefficient=0.3, exponent=exponent, modulus=2.0, approach=contact.approach),
    ):
        assert other.a == pytest.approx(1.3, rel=1e-13)
        assert other.approach == pytest.approx(contact.approach, rel=1e-13)
        assert other.force == pytest.approx(contact.force, rel=1e-13)
    for r in (0.4, 1.2, 2.0):
        expected = ring_displacement(contact.pressure, 1.3, r, 2.0)
        assert float(contact.displacement(r)) == pytest.approx(expected, rel=1e-6)  # quad(), as above
    # Stiffness is the slope dP/d(delta), whatever the profile: central difference, error (1e-4)^2.
    up, down = (
        punch.power(coefficient=0.3, exponent=exponent, modulus=2.0, approach=contact.approach * f)
        for f in (1.0001, 0.9999)
    )
    assert contact.stiffness == pytest.approx((up.force - down.force) / (up.approach - down.approach), rel=1e-7)


@pytest.mark.parametrize("exponent", [0.5, 0.9, 1.2, 1.7, 2.5, 4.0])
def test_power_law_pressure_near_the_axis(exponent):
    contact = punch.power(coefficient=0.3, exponent=exponent, modulus=2.0, a=1.0)
    scale = exponent * 2.0 * contact.approach / np.pi
    for r in (1e-12, 1e-5, 0.3, 0.4999999, 0.5000001):
        # s = r cosh(t): Gauss quadrature on panels of t.
        edges = np.linspace(0, np.arccosh(1 / r), 20)
        t, w = np.polynomial.legendre.leggauss(20)
        nodes = edges[:-1, None] + np.diff(edges)[:, None] * (t + 1) / 2
        expected = np.sum(np.diff(edges)[:, None] / 2 * w * (r * np.cosh(nodes)) ** (exponent - 1))
        assert float(contact.pressure(r)) == pytest.approx(scale * expected, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: punch.flat(radius=-1.0, modulus=1.0, force=1.0), ("not-positive", "The radius")),
        (lambda: punch.flat(radius=1.0, modulus=1.0), ("one-of", "force=, approach=")),
        (lambda: punch.cone(angle=2.0, modulus=1.0, force=1.0), ("input", "below pi/2")),
        (lambda: punch.cone(angle=0.0, modulus=1.0, force=1.0), ("not-positive", "The angle")),
        (lambda: punch.power(coefficient=1.0, exponent=0.0, modulus=1.0, force=1.0), ("not-positive", "The exponent")),
        (
            lambda: punch.power(coefficient=1.0, exponent=2.0, modulus=1.0, force=1.0, a=1.0),
            ("one-of", "force=, approach="),
        ),
    ],
)
def test_bad_input_is_named(make, message):
    with refused(InputError, *message):
        make()
