import numpy as np
import pytest
from refusals import refused
from scipy.integrate import quad

from fecontact import InputError, Material
from fecontact.analytic import hertz, sinusoid

DELTA, LAM, E_STAR = 0.02, 1.7, 100.0
CLOSING = np.pi * E_STAR * DELTA / LAM


def contact_at(share):
    return sinusoid.westergaard(amplitude=DELTA, wavelength=LAM, modulus=E_STAR, mean_pressure=share * CLOSING)


@pytest.mark.parametrize("share", [0.01, 0.3, 0.5, 0.95, 0.9999])
def test_pressure_and_area(share):
    contact = contact_at(share)
    # VERIFICATION 5.
    assert np.sin(np.pi * contact.a / LAM) ** 2 == pytest.approx(share, rel=1e-12)
    x = np.linspace(-0.99, 0.99, 7) * contact.a
    psi, edge = np.pi * x / LAM, np.pi * contact.a / LAM
    expected = 2 * share * CLOSING * np.cos(psi) / np.sin(edge) ** 2 * np.sqrt(np.sin(edge) ** 2 - np.sin(psi) ** 2)
    np.testing.assert_allclose(contact.pressure(x), expected, rtol=1e-12)
    # x = a sin(t) makes the integrand smooth.
    total = quad(
        lambda t: float(contact.pressure(contact.a * np.sin(t))) * contact.a * np.cos(t), -np.pi / 2, np.pi / 2
    )[0]
    assert total / LAM == pytest.approx(share * CLOSING, rel=1e-10)
    assert contact.max_pressure == pytest.approx(float(contact.pressure(0.0)), rel=1e-14)


@pytest.mark.parametrize("share", [0.01, 0.3, 0.5, 0.95])
def test_mean_gap_is_the_mean_of_the_gap(share):
    contact = contact_at(share)
    total = quad(lambda x: float(contact.gap(x)), contact.a, LAM / 2, epsabs=1e-14)[0] * 2 / LAM
    assert contact.mean_gap == pytest.approx(total, rel=1e-9, abs=1e-13)


@pytest.mark.parametrize("share", [0.05, 0.5, 0.9])
def test_gap_is_that_of_the_half_plane_under_the_pressure(share):
    contact = contact_at(share)
    n = 2**16
    x = np.arange(n) * LAM / n
    wave = 2 * np.pi * np.fft.rfftfreq(n, LAM / n)
    spectrum = np.fft.rfft(contact.pressure(x))
    spectrum[1:] *= 2 / (E_STAR * wave[1:])  # a wave of pressure p displaces by 2 p/(E* k)
    spectrum[0] = 0.0
    gap = np.fft.irfft(spectrum, n) - DELTA * np.cos(2 * np.pi * x / LAM)
    gap -= gap[0]
    # The root of the pressure at the edge leaves n^(-3/2) = 6e-8 of the amplitude, times a factor of order 10.
    np.testing.assert_allclose(gap, contact.gap(x), rtol=0, atol=1e-6 * DELTA)


def test_complete_contact():
    contact = contact_at(1.5)
    x = np.array([0.0, LAM / 2, LAM])
    assert contact.complete
    assert contact.area_fraction == pytest.approx(1.0, rel=1e-15)
    assert contact.mean_gap == 0.0
    np.testing.assert_allclose(contact.pressure(x), CLOSING * np.array([2.5, 0.5, 2.5]), rtol=1e-14)
    np.testing.assert_allclose(contact.gap(x), 0.0, rtol=0, atol=0)
    assert contact.max_pressure == pytest.approx(2.5 * CLOSING, rel=1e-14)


def test_limits_of_load():
    open_contact = contact_at(0.0)
    assert open_contact.a == 0.0
    assert open_contact.mean_gap == pytest.approx(DELTA, rel=1e-14)
    assert float(open_contact.pressure(0.0)) == 0.0
    assert float(open_contact.gap(LAM / 2)) == pytest.approx(2 * DELTA, rel=1e-15)
    # Close to completion the mean gap is Delta (1 - beta)^2/2; 1 - beta + beta log(beta) would have 8 digits at 1e-8.
    nearly = contact_at(1 - 1e-6)
    assert nearly.mean_gap == pytest.approx(DELTA * 1e-12 / 2, rel=1e-5)


def test_light_load_is_hertz():
    contact = contact_at(1e-6)
    radius = LAM**2 / (4 * np.pi**2 * DELTA)
    force = 1e-6 * CLOSING * LAM
    line = hertz.line(radii=(radius, np.inf), materials=(Material(E_STAR, 0.0), None), force=force)
    assert contact.a == pytest.approx(line.a, rel=1e-6)  # corrections of order beta
    assert contact.max_pressure == pytest.approx(line.p0, rel=1e-6)


def test_fields_repeat_with_the_wavelength():
    contact = contact_at(0.4)
    x = np.linspace(0, LAM, 11)
    np.testing.assert_allclose(contact.pressure(x + 7 * LAM), contact.pressure(x), rtol=0, atol=1e-9 * CLOSING)
    np.testing.assert_allclose(contact.gap(-x), contact.gap(x), rtol=0, atol=1e-14)


def test_bad_input_is_named():
    with refused(InputError, "input", "mean pressure >= 0"):
        contact_at(-0.1)
    with refused(InputError, "not-positive", "The wavelength"):
        sinusoid.westergaard(amplitude=1.0, wavelength=0.0, modulus=1.0, mean_pressure=1.0)
