import numpy as np
import pytest
from refusals import refused
from scipy.integrate import quad

from fecontact import InputError, Material
from fecontact.analytic import axisymmetric, hertz, punch

PLACES = np.array([0.0, 1e-6, 0.3, 0.9, 1.0, 1.7])


def sphere_slope(r):
    return r / np.sqrt(25 - r**2)


def sphere_height(r):
    return r**2 / (5 + np.sqrt(25 - r**2))


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0, 4.0, 9.0])
def test_power_profiles_by_slope_and_by_height(exponent):
    target = punch.power(coefficient=0.3, exponent=exponent, modulus=2.0, a=1.0)
    by_slope = axisymmetric.indent(slope=lambda r: 0.3 * exponent * r ** (exponent - 1), modulus=2.0, a=1.0)
    by_height = axisymmetric.indent(height=lambda r: 0.3 * r**exponent, modulus=2.0, a=1.0)
    # Differences of eighth order: 1e-13 for moderate powers from slopes, 1e-11 from heights.
    for contact, tolerance in ((by_slope, 1e-12), (by_height, 1e-11)):
        assert contact.approach == pytest.approx(target.approach, rel=tolerance)
        assert contact.force == pytest.approx(target.force, rel=tolerance)
        np.testing.assert_allclose(contact.displacement(PLACES), target.displacement(PLACES), rtol=tolerance)
        np.testing.assert_allclose(contact.pressure(PLACES[1:]), target.pressure(PLACES[1:]), rtol=tolerance, atol=0)
    assert by_slope.stiffness == target.stiffness


def test_sharp_tip_has_infinite_pressure_and_a_round_one_has_not():
    assert np.isinf(axisymmetric.indent(slope=np.ones_like, modulus=1.0, a=1.0).pressure(0.0))
    round_tip = axisymmetric.indent(slope=lambda r: r, modulus=np.pi / 2, a=1.0)
    assert float(round_tip.pressure(0.0)) == pytest.approx(1.0, rel=1e-12)


def test_full_sphere_is_sneddons():
    # Sneddon 1965, section 6: rigid sphere of radius R (not its paraboloid).
    a, R = 2.0, 5.0
    log = np.log((R + a) / (R - a))
    contact = axisymmetric.indent(slope=sphere_slope, modulus=1.0, a=a)
    assert contact.approach == pytest.approx(a / 2 * log, rel=1e-13)
    assert contact.force == pytest.approx((R**2 + a**2) / 2 * log - a * R, rel=1e-13)
    by_force = axisymmetric.indent(height=sphere_height, modulus=1.0, force=contact.force, limit=4.5)
    assert by_force.a == pytest.approx(a, rel=1e-11)
    by_approach = axisymmetric.indent(slope=sphere_slope, modulus=1.0, approach=contact.approach, limit=4.5)
    assert by_approach.a == pytest.approx(a, rel=1e-12)


def test_full_sphere_at_light_load_is_hertz():
    contact = axisymmetric.indent(slope=sphere_slope, modulus=1.0, approach=1e-8, limit=1.0)
    target = hertz.spheres(radii=(5.0, np.inf), materials=(Material(1.0, 0.0), None), approach=1e-8)
    # The sphere differs from its paraboloid by (a/R)^2 = 2e-9.
    assert contact.force == pytest.approx(target.force, rel=1e-8)


def test_cone_with_a_flat_end():
    # Slope 0 to r = b, then tan(beta): closed forms with cos(phi) = b/a (Ejike 1981; Ciavarella 1999).
    b, slope = 0.4, 0.2
    contact = axisymmetric.indent(slope=lambda r: np.where(r < b, 0.0, slope), modulus=2.0, breaks=(b,), a=1.0)
    phi = np.arccos(b)
    assert contact.approach == pytest.approx(slope * phi, rel=1e-13)
    assert contact.force == pytest.approx(2 * 2.0 * slope * (phi + np.sin(phi) * np.cos(phi)) / 2, rel=1e-13)
    assert np.isinf(contact.pressure(b))
    for r in (0.0, 0.1, 0.399, 0.401, 0.9):
        # By hand: t G = slope t arccos(b/t); its derivative over sqrt(t^2 - r^2), with t = low + (a - low) v^2.
        low = max(r, b)

        def integrand(v, r=r, low=low):
            t = low + (1 - low) * v**2
            # Distances from the ends without rounding: t - low = (1 - low) v^2.
            over_b = (t - low + low - b) * (t + b)
            over_r = (t - low + low - r) * (t + r)
            return (np.arccos(b / t) + b / np.sqrt(over_b)) / np.sqrt(over_r) * 2 * (1 - low) * v

        expected = 2.0 / np.pi * slope * quad(integrand, 0, 1, epsabs=1e-12, limit=200)[0]
        assert float(contact.pressure(r)) == pytest.approx(expected, rel=1e-8)  # quad() next to the logarithm at b


def test_rounded_cone_with_named_break():
    # Paraboloid joined smoothly to a cone at b: a kink in f'' only.
    b, R = 0.4, 2.0
    contact = axisymmetric.indent(slope=lambda r: np.minimum(r, b) / R, modulus=2.0, breaks=(b,), a=1.0)
    t = np.arcsin(b)
    approach = ((1 - np.cos(t)) + b * (np.pi / 2 - t)) / R
    assert contact.approach == pytest.approx(approach, rel=1e-13)
    # Pressure carries the force: Gauss quadrature on both sides of the kink (t ln t there), in r = sin.
    nodes, weights = np.polynomial.legendre.leggauss(40)
    total = 0.0
    for low, high in ((0.0, t), (t, np.pi / 2)):
        angle = low + (high - low) * (nodes + 1) / 2
        values = contact.pressure(np.sin(angle)) * 2 * np.pi * np.sin(angle) * np.cos(angle)
        total += (high - low) / 2 * np.sum(weights * values)
    assert total == pytest.approx(contact.force, rel=1e-4)


def test_heights_with_kinks_serve_as_well_as_slopes():
    b = 0.4
    r = np.array([0.0, 0.3, b, 0.5, 0.9])
    profiles = [
        (lambda r: np.minimum(r, b) / 2, lambda r: np.where(r < b, r**2 / 4, b**2 / 4 + (r - b) * b / 2)),
        (lambda r: np.where(r < b, 0.0, 0.2), lambda r: 0.2 * np.maximum(r - b, 0.0)),
    ]
    for slope, height in profiles:
        one = axisymmetric.indent(slope=slope, modulus=2.0, breaks=(b,), a=1.0)
        other = axisymmetric.indent(height=height, modulus=2.0, breaks=(b,), a=1.0)
        # One-sided differences of heights: 300 eps/h^2 with h = r/100, summed over few nodes near the kink.
        np.testing.assert_allclose(other.pressure(r), one.pressure(r), rtol=1e-10)
        assert other.force == pytest.approx(one.force, rel=1e-12)


def test_unnamed_kinks_are_found_out():
    with refused(InputError, "integrals-diverge"):
        axisymmetric.indent(slope=lambda r: np.where(r < 0.4, 0.0, 1.0), modulus=1.0, a=1.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, ("input", "exactly one of slope= and height=; found none")),
        ({"slope": np.ones_like, "height": np.ones_like}, ("input", "found both")),
        ({"slope": np.ones_like, "a": None}, ("one-of", "a=, force=, approach=")),
        ({"slope": np.ones_like, "a": None, "force": 1.0}, ("input", "limit=")),
        ({"slope": np.ones_like, "a": None, "force": 1.0, "limit": 1e-3}, ("limit-too-small", "force")),
        ({"slope": np.ones_like, "breaks": (-1.0,)}, ("not-positive", "A break")),
        ({"slope": lambda r: np.full_like(r, np.nan)}, ("integrals-diverge",)),
        (
            {"slope": lambda r: np.full_like(r, np.nan), "a": None, "force": 1.0, "limit": 1.0},
            ("profile-not-finite", "nan"),
        ),
        ({"slope": np.ones_like, "modulus": 0.0}, ("not-positive", "The modulus")),
    ],
)
def test_bad_input_is_named(arguments, message):
    with refused(InputError, *message):
        axisymmetric.indent(**{"modulus": 1.0, "a": 1.0, **arguments})
