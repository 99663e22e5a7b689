import numpy as np
import pytest
from refusals import refused

from fecontact import InputError, Material
from fecontact.analytic import disc


@pytest.mark.parametrize("r", [0.2, 0.999, 1.001, 1.5, 20.0])
def test_uniform_displacement_is_that_of_summed_rings(r, ring_displacement):
    found = disc.uniform_displacement(r, a=1.0, pressure=1.0, modulus=2.0)
    # quad() reaches about 1e-9 over the logarithm under the ring.
    assert float(found) == pytest.approx(ring_displacement(lambda s: 1.0, 1.0, r, 2.0), rel=1e-8)


def test_uniform_displacement_at_centre_edge_and_far_away():
    # Johnson 1985, eqs. (3.29): 2 p a/E', 4 p a/(pi E'), P/(pi E' r).
    found = disc.uniform_displacement([0.0, 3.0, 3.0 * (1 + 1e-15)], a=3.0, pressure=2.0, modulus=5.0)
    np.testing.assert_allclose(found, [12 / 5, 24 / (5 * np.pi), 24 / (5 * np.pi)], rtol=1e-13)
    for r in (1e6, 1e12):
        far = disc.uniform_displacement(r, a=3.0, pressure=2.0, modulus=5.0)
        assert float(far) == pytest.approx(2 * np.pi * 9 / (np.pi * 5 * r), rel=1e-11)  # next term (a/r)^2/8


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.4999])
@pytest.mark.parametrize("z", [0.3, 1.0, 5.0])
def test_uniform_stress_on_axis_is_that_of_summed_point_loads(nu, z, summed_disc):
    tensor = summed_disc(np.ones_like, 1.0, np.array([0.0, 0.0, z]), Material(1.0, nu))
    stress = disc.uniform_stress_on_axis(z, a=1.0, pressure=1.0, nu=nu)
    found = [float(stress.rr), float(stress.tt), float(stress.zz)]
    np.testing.assert_allclose(found, tensor.diagonal(), rtol=0, atol=1e-12)  # analytic integrand


def test_uniform_stress_at_great_depth():
    z = 1e8
    stress = disc.uniform_stress_on_axis(z, a=1.0, pressure=1.0, nu=0.3)
    # Point load P = pi: -3 P/(2 pi z^2) and (1 - 2 nu) P/(4 pi z^2); next term (a/z)^2.
    assert float(stress.zz) * z**2 == pytest.approx(-1.5, rel=1e-12)
    assert float(stress.rr) * z**2 == pytest.approx(0.1, rel=1e-12)


def test_measures_of_stress():
    stress = disc.hertz_stress([0.3, 1.4], [0.5, 0.2], a=1.0, p0=1.0, nu=0.3)
    for i in range(2):
        tensor = np.array([[stress.rr[i], 0, stress.rz[i]], [0, stress.tt[i], 0], [stress.rz[i], 0, stress.zz[i]]])
        principal = np.linalg.eigvalsh(tensor)
        deviator = tensor - np.trace(tensor) / 3 * np.eye(3)
        assert stress.max_shear[i] == pytest.approx((principal[2] - principal[0]) / 2, rel=1e-13)
        assert stress.von_mises[i] == pytest.approx(np.sqrt(1.5 * np.sum(deviator**2)), rel=1e-13)


def test_bad_input_is_named():
    with refused(InputError, "not-positive", "The radius a"):
        disc.hertz_pressure(0.0, a=0.0, p0=1.0)
    with refused(InputError, "not-positive", "The modulus"):
        disc.uniform_displacement(0.0, a=1.0, pressure=1.0, modulus=-1.0)
    with refused(InputError, "negative-depth", "Expected z"):
        disc.uniform_stress_on_axis(-1.0, a=1.0, pressure=1.0, nu=0.3)
