import numpy as np
import pytest
from refusals import refused
from scipy.integrate import quad
from scipy.special import j0

from fecontact import InputError, Material
from fecontact.analytic import hertz, layer


def wave_compliance(k, h, material, base):
    """Surface displacement of a layer under p = cos(kx), solved from Airy's stress function and its four constants.

    phi = f(z) cos(kx), z from the surface (0) to the base (h), f a combination of exp and z exp. Stresses xx = f'' cos,
    zz = -k^2 f cos, xz = k f' sin; displacements from plane-strain Hooke.
    """
    nu, G = material.nu, material.shear_modulus

    def rows(z):
        # Value and derivatives up to third order of exp(k(z-h)), z exp(k(z-h)), exp(-kz), z exp(-kz).
        up, down = np.exp(k * (z - h)), np.exp(-k * z)
        f = np.array([up, z * up, down, z * down])
        f1 = np.array([k * up, (1 + k * z) * up, -k * down, (1 - k * z) * down])
        f2 = np.array([k**2 * up, (2 * k + k**2 * z) * up, k**2 * down, (-2 * k + k**2 * z) * down])
        f3 = np.array([k**3 * up, (3 * k**2 + k**3 * z) * up, -(k**3) * down, (3 * k**2 - k**3 * z) * down])
        # 2G e_xx = (1 - nu) xx - nu zz gives u; 2G e_xz = xz with it gives w.
        u = ((1 - nu) * f2 + nu * k**2 * f) / (2 * G * k)  # times sin(kx)
        w = ((1 - nu) * f3 - (2 - nu) * k**2 * f1) / (2 * G * k**2)  # times cos(kx)
        return f, f1, u, w

    f, f1, _, w_top = rows(0.0)
    _, g1, u, w = rows(h)
    # Surface: zz = -p with p = cos(kx), no shear. Base: w = 0 and u = 0, or w = 0 and no shear.
    matrix = np.array([-(k**2) * f, f1, w, u if base == "bonded" else g1])
    constants = np.linalg.solve(matrix, np.array([-1.0, 0.0, 0.0, 0.0]))
    return float(w_top @ constants)


@pytest.mark.parametrize("base", ["bonded", "frictionless"])
@pytest.mark.parametrize("nu", [-0.2, 0.0, 0.3, 0.45, 0.4999])
def test_kernels_are_those_of_the_elastic_layer(base, nu):
    material = Material(E=2.0, nu=nu)
    for k in (0.3, 1.0, 3.0, 8.0):
        expected = wave_compliance(k, 0.7, material, base)
        found = layer.compliance(k, 0.7, material, base)
        # The 4 x 4 system has a condition of 1e4 for the longest wave, more when incompressible.
        assert float(found) == pytest.approx(expected, rel=1e-9)


def test_kernels_from_long_to_short_waves():
    for nu in (0.0, 0.3, 0.4999999999):
        material = Material(E=1.0, nu=nu)
        g = 3 - 4 * nu
        assert float(layer.bonded_kernel(0.0, 2.0, material)) == 0.0
        assert float(layer.bonded_kernel(1e6, 2.0, material)) == pytest.approx(1.0, rel=1e-15)
        for k in (1e-9, 1e-6, 1e-4):
            # Series of the numerator for long waves, both terms: 4 (g - 1) kh + (8/3) (kh)^3.
            series = (4 * (g - 1) * 2 * k + 8 / 3 * (2 * k) ** 3) / (g + 1) ** 2
            assert float(layer.bonded_kernel(k, 2.0, material)) == pytest.approx(series, rel=1e-6)
    assert float(layer.frictionless_kernel(1e-8, 2.0)) == pytest.approx(1e-8, rel=1e-7)
    assert float(layer.frictionless_kernel(1e6, 2.0)) == pytest.approx(1.0, rel=1e-15)
    waves = np.linspace(0, 20, 2001)
    for values in (layer.bonded_kernel(waves, 1.0, Material(1.0, 0.45)), layer.frictionless_kernel(waves, 1.0)):
        assert np.all(np.abs(np.diff(values)) < 0.02)  # no jump where the series takes over


def test_compliance_at_rest_is_the_uniform_column():
    material = Material(E=5.0, nu=0.3)
    column = 2.0 * 1.3 * 0.4 / (5.0 * 0.7)
    np.testing.assert_allclose(layer.compliance([0.0, 1e-8], 2.0, material), column, rtol=1e-7)
    sliding = layer.compliance([0.0, 1e-8], 2.0, material, "frictionless")
    np.testing.assert_allclose(sliding, 2.0 / material.plane_strain_modulus, rtol=1e-7)


TABLE = {
    (0.0, 0.5): (1.38565, 0.78284, 0.66309),
    (0.0, 2.0): (2.25911, 0.59216, 1.20867),
    (0.3, 0.5): (1.40223, 0.75885, 0.67168),
    (0.3, 2.0): (2.50527, 0.57300, 1.37248),
    (0.45, 0.5): (1.42505, 0.71971, 0.68347),
    (0.45, 2.0): (3.03448, 0.50988, 1.72591),
    (0.4999, 0.5): (1.43851, 0.69630, 0.69044),
    (0.4999, 2.0): (3.46301, 0.45505, 2.01510),
}


@pytest.mark.parametrize(("nu", "ratio"), TABLE)
def test_reference_table(nu, ratio):
    # VERIFICATION 10: PR/(E* a^3), delta R/a^2, p0 R/(E* a), printed to 5e-6.
    a, R = 3.0, 70.0
    material = Material(E=8.0, nu=nu)
    contact = layer.paraboloid(radius=R, thickness=a / ratio, material=material, a=a)
    found = (
        contact.force * R / (contact.E_star * a**3),
        contact.approach * R / a**2,
        contact.p0 * R / (contact.E_star * a),
    )
    np.testing.assert_allclose(found, TABLE[nu, ratio], rtol=0, atol=6e-6)


@pytest.mark.parametrize("base", ["bonded", "frictionless"])
@pytest.mark.parametrize(("nu", "ratio"), [(0.0, 0.5), (0.3, 2.0), (0.4999, 2.0), (0.3, 8.0)])
def test_pressure_presses_the_layer_into_the_paraboloid(base, nu, ratio, ring_displacement):
    material = Material(E=1.0, nu=nu)
    h = 1 / ratio
    contact = layer.paraboloid(radius=1.0, thickness=h, material=material, a=1.0, base=base)
    kernel = layer.bonded_kernel if base == "bonded" else layer.frictionless_kernel
    t, w = np.polynomial.legendre.leggauss(120)
    angle, w = (t + 1) * np.pi / 4, w * np.pi / 4
    s = np.sin(angle)
    weight = contact.pressure(s) * s * np.cos(angle) * w
    k, w_k = np.polynomial.legendre.leggauss(400)
    k, w_k = (k + 1) * 15 * ratio, w_k * 15 * ratio  # 1 - M has decayed to exp(-60)
    transform = j0(np.outer(k, s)) @ weight
    for r in (0.0, 0.35, 0.8, 1.0):
        half_space = (
            ring_displacement(contact.pressure, 1.0, r, contact.E_star)
            if r > 0
            else quad(lambda x: 2 / contact.E_star * float(contact.pressure(x)), 0, 1, epsabs=1e-12)[0]
        )
        less = 2 / contact.E_star * np.sum(w_k * (1 - kernel(k, h, material)) * transform * j0(k * r))
        # quad() under the ring 1e-9; the difference of both terms loses one digit for thin layers.
        assert half_space - less == pytest.approx(contact.approach - r**2 / 2, abs=1e-7)
    total = 2 * np.pi * weight.sum()
    assert total == pytest.approx(contact.force, rel=1e-12)  # smooth integrand in the angle


def test_thick_layer_is_hertz():
    material = Material(E=1.0, nu=0.3)
    for a in (1e-3, 1e-6):
        contact = layer.paraboloid(radius=1.0, thickness=1.0, material=material, a=a)
        sphere = hertz.spheres(radii=(1.0, np.inf), materials=(material, None), approach=a**2)
        force, approach, p0 = layer.thick(radius=1.0, material=material, a=a)
        assert force == pytest.approx(sphere.force, rel=1e-14)
        assert approach == pytest.approx(sphere.approach, rel=1e-14)
        assert contact.approach == pytest.approx(approach, rel=2 * a)  # range stated: the error grows as a/h
        assert contact.force == pytest.approx(force, rel=10 * a**3 + 1e-13)  # of third order
        assert contact.p0 == pytest.approx(p0, rel=10 * a**3 + 1e-13)


def test_thin_asymptotes_within_their_stated_errors():
    for base in ("bonded", "frictionless"):
        errors = []
        for ratio in (10.0, 40.0):
            material = Material(E=1.0, nu=0.3)
            exact = layer.paraboloid(radius=1.0, thickness=1 / ratio, material=material, a=1.0, base=base)
            force, approach, p0 = layer.thin_compressible(
                radius=1.0, thickness=1 / ratio, material=material, a=1.0, base=base
            )
            errors.append(abs(exact.force / force - 1))
            assert abs(exact.approach / approach - 1) < 0.6 / ratio
            assert abs(exact.p0 / p0 - 1) < 0.6 / ratio
        assert errors[1] < 0.3 * errors[0]  # falls as h/a
        assert errors[0] < 0.11
    material = Material(E=1.0, nu=0.499999)
    errors = []
    for ratio in (10.0, 40.0):
        exact = layer.paraboloid(radius=1.0, thickness=1 / ratio, material=material, a=1.0)
        force, approach, _ = layer.thin_incompressible(radius=1.0, thickness=1 / ratio, material=material, a=1.0)
        errors.append((abs(exact.force / force - 1), abs(exact.approach / approach - 1)))
    assert errors[1][0] < 0.3 * errors[0][0]
    assert errors[1][1] < 0.3 * errors[0][1]


@pytest.mark.by_day("0.0-bonded")
@pytest.mark.parametrize("base", ["bonded", "frictionless"])
@pytest.mark.parametrize("nu", [0.0, 0.4999])
def test_force_and_approach_are_inverse_of_each_other(base, nu):
    material = Material(E=3.0, nu=nu)
    for a in (1e-4, 0.5, 5.0):
        contact = layer.paraboloid(radius=7.0, thickness=0.5, material=material, a=a, base=base)
        by_force = layer.paraboloid(radius=7.0, thickness=0.5, material=material, force=contact.force, base=base)
        by_approach = layer.paraboloid(
            radius=7.0, thickness=0.5, material=material, approach=contact.approach, base=base
        )
        assert by_force.a == pytest.approx(a, rel=1e-10)  # root finding to 1e-14 in log a, rounding of the solve
        assert by_approach.a == pytest.approx(a, rel=1e-10)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"a": 60.0}, ("layer-too-thin", "50.0")),
        ({"force": 1e12}, ("layer-too-thin", "50.0")),
        ({"approach": -1.0}, ("not-positive", "The approach")),
        ({}, ("one-of", "force=, approach=, a=")),
        ({"a": 1.0, "base": "glued"}, ("unknown-base", "'glued'")),
        ({"a": 1.0, "thickness": 0.0}, ("not-positive", "The thickness")),
    ],
)
def test_bad_input_is_named(arguments, message):
    with refused(InputError, *message):
        layer.paraboloid(**{"radius": 1.0, "thickness": 1.0, "material": Material(1.0, 0.3), **arguments})


def test_bad_waves_are_named():
    with refused(InputError, "negative-depth", "Expected k"):
        layer.bonded_kernel([-1.0], 1.0, Material(1.0, 0.3))
