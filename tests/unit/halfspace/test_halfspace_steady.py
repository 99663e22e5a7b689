"""Contacts that move steadily over visco-elastic half-spaces: cylinders of Hunter and CONTACT, limits, what is lost."""

import numpy as np
import pytest
import scipy.fft
import scipy.optimize
from scipy.special import ive, kve

import fecontact as fc
from fecontact.halfspace.steady import Motion
from tests.refusals import refused

BALL = fc.surfaces.Paraboloid(1.0)
RUBBER = fc.Viscoelastic(fc.Material(1.0, 0.3), prony=[(0.5, 1.0), (0.2, 6.0)])
PLAIN = fc.Viscoelastic(fc.Material(1.0, 0.3), prony=[(0.5, 1.0)])


def half_space(cells=32, material=RUBBER, size=3.6, **options):
    return fc.HalfSpace(material, size=(size, size), cells=(cells, cells), **options)


def cylinder(material, width, cells, length, velocity, curvature, force, **options):
    """A long cylinder on cells as long as it is, between rims without counter-surface."""
    half = fc.HalfSpace(material, size=(width, 3 * length), cells=(cells, 3), **options)
    z = np.full(half.grid.shape, np.inf)
    z[:, 1] = curvature * half.grid.x**2 / 2
    return half.press(z, force=force, velocity=(velocity, 0.0))


@pytest.mark.parametrize(
    ("time", "approach", "pressure", "cells"),
    [(0.009, 2.36736, 78.74, (26, 86)), (0.045, 2.06321, 84.72, (26, 81)), (2.0, 1.45462, 85.31, (23, 78))],
)
def test_contact_s_cylinders(time, approach, pressure, cells):
    """CONTACT's example visc_cylindr after Wang & Knothe 1993 (program of 2025-07-23): two cylinders of PA6."""
    polyamide = fc.Viscoelastic(fc.Material(E=2 * 1143.0 * 1.4, nu=0.4), prony=[(0.5, time / 2)])
    found = cylinder(polyamide, 15.84, 99, 1000.0, 1000.0, 0.02, 600e3, against=polyamide)
    assert found.approach == pytest.approx(approach, rel=1e-4)
    assert found.max_pressure == pytest.approx(pressure, rel=3e-4)
    touching = np.flatnonzero(found.active[:, 1]) + 1
    assert (touching[0], touching[-1]) == cells
    assert found.residuals.within(1e-8)


def hunter(force, modulus, radius, share, length):
    """Half-width, middle and centre of pressure of a rolling cylinder, load per length (Hunter 1961), creep 1 + s.

    With P = (1 + s) p - l p' in the contact, whose displacements are those of (x - l)/R; no pressure at both ends, and
    the slope of the surface ahead goes on into the contact.
    """

    def of(c):
        y, z = (1 + share) * c / length, c / length
        i, k = ive(1, y) / ive(0, y), kve(1, z) / kve(0, z)
        x = length * share / (1 + share) * i / (k + i)
        return x, x * c * k

    def excess(c):
        return np.pi * modulus / (2 * radius * (1 + share)) * (c**2 / 2 + of(c)[1]) - force

    c = scipy.optimize.brentq(excess, 1e-3 * np.sqrt(force * radius / modulus), 10 * np.sqrt(force * radius / modulus))
    x = of(c)[0]
    first = -np.pi * modulus * c**2 / (4 * radius) * (x - length)
    return c, x, x + (first - length * force) / (1 + share) / force


@pytest.mark.parametrize("velocity", [0.1, 1.0, 10.0])
def test_hunter_s_cylinder(velocity):
    share, time = (float(part[0]) for part in PLAIN.creep)
    modulus, radius, force = PLAIN.material.plane_strain_modulus, 1.0, 0.2
    found = cylinder(PLAIN, 2.4, 200, 3e4, velocity, 1 / radius, force * 3e4)
    c, middle, centre = hunter(force, modulus, radius, share, time * velocity)
    edges = found.grid.x[np.flatnonzero(found.active[:, 1])[[0, -1]]]
    assert edges[0] == pytest.approx(middle - c, abs=0.012)
    assert edges[1] == pytest.approx(middle + c, abs=0.012)
    assert found.drag / found.force == pytest.approx(centre / radius, rel=2e-3)
    assert found.centre_of_pressure[0] / radius == pytest.approx(centre / radius, rel=1e-2)


def test_very_slow_and_very_fast_are_elastic():
    for velocity, material in ((1e-8, RUBBER.relaxed), (1e8, RUBBER.material)):
        found = half_space().press(BALL, force=0.1, velocity=(velocity, 0.0))
        elastic = half_space(material=material).press(BALL, force=0.1)
        assert np.abs(found.pressure - elastic.pressure).max() < 1e-5 * elastic.max_pressure
        assert found.approach == pytest.approx(elastic.approach, rel=1e-6)
        assert abs(found.drag) < 1e-5 * found.force


@pytest.mark.parametrize("velocity", [(2.0, 0.0), (1.0, -0.7)])
def test_what_is_lost_is_the_work_of_the_pressures(velocity):
    """On a rough, periodic surface: power by the creep against that of pressures on the rates of displacements."""
    half = half_space(64, size=1.0, periodic=True)
    rng = np.random.default_rng(1)
    z = np.zeros(half.grid.shape)
    for kx, ky, phase in zip(rng.integers(-5, 6, 20), rng.integers(-5, 6, 20), rng.uniform(0, 7, 20), strict=True):
        z += 1e-2 * np.cos(2 * np.pi * (kx * half.grid.x[:, None] + ky * half.grid.y) + phase)
    found = half.press(z, force=0.02, velocity=velocity)
    assert 0.05 < found.active.mean() < 0.9
    k = 2 * np.pi * np.stack(np.meshgrid(*2 * [scipy.fft.fftfreq(64, 1 / 64)], indexing="ij"))
    k[np.abs(k) > 2 * np.pi * 31.5] = 0
    along = np.tensordot(velocity, k, 1)
    rate = -scipy.fft.ifft2(1j * along * scipy.fft.fft2(found.displacement)).real
    work = (found.pressure * rate).sum() * half.grid.area
    assert found.power == pytest.approx(work, rel=2e-2)
    assert found.drag > 0


def test_a_ball_is_pushed_back_by_its_pressures():
    """Frictionless: the pressures' horizontal part, of slopes x/R, is the drag by what is lost; its error is told."""
    fine = half_space(96).press(BALL, force=0.1, velocity=(0.5, 0.0))
    assert fine.drag == pytest.approx(fine.force * fine.centre_of_pressure[0], rel=3e-3)
    coarse = half_space(32).press(BALL, force=0.1, velocity=(0.5, 0.0))
    error = abs(coarse.drag - fine.drag)
    assert 0.5 * error < coarse.drag_error < 20 * error
    assert "drag" in str(coarse)
    assert coarse.summary()["drag"] == coarse.drag


def test_directions_and_equal_terms():
    first = half_space(24, PLAIN).press(BALL, force=0.1, velocity=(1.0, 0.0))
    split = fc.Viscoelastic(PLAIN.material, prony=[(0.2, 1.0), (0.3, 1.0)])
    others = {
        (-1.0, 0.0): lambda p: p[::-1],
        (0.0, 1.0): lambda p: p.T,
        (0.0, -1.0): lambda p: p.T[:, ::-1],
    }
    for velocity, turned in others.items():
        found = half_space(24, split).press(BALL, force=0.1, velocity=velocity)
        assert np.abs(found.pressure - turned(first.pressure)).max() < 1e-8 * first.max_pressure
        assert found.drag == pytest.approx(first.drag, rel=1e-8)
    held = half_space(24, PLAIN).press(BALL, approach=first.approach, velocity=(1.0, 0.0))
    assert held.force == pytest.approx(0.1, rel=1e-7)
    tilted = half_space(24, PLAIN).press(BALL, force=0.1, load_point=(0.0, 0.0), velocity=(1.0, 0.0))
    assert tilted.centre_of_pressure == pytest.approx((0.0, 0.0), abs=1e-7)


def test_compliances_are_made_once_a_grid(monkeypatch):
    """Of the answer, its certificate and both drags."""
    made, make = [], Motion._compliance
    monkeypatch.setattr(Motion, "_compliance", lambda *given: made.append(given[1]) or make(*given))
    half_space(48).press(BALL, force=0.1, velocity=(1.0, 0.0))
    assert made == [(24, 24), (48, 48)]


def test_apart_nothing_is_pressed():
    found = half_space(16).press(BALL, approach=-0.1, velocity=(1.0, 0.0))
    assert (found.status, found.force, found.drag) == ("no-contact", 0.0, 0.0)
    assert len(found.plot().axes) == 4


@pytest.mark.parametrize("velocity", [(1.0, 0.0), (0.0, -1.0)])
def test_picture(velocity):
    """The section is through the largest pressure, ahead to the right; in the contact both surfaces are one."""
    found = half_space(24).press(BALL, force=0.1, velocity=velocity)
    pressed, section, *_ = found.plot(length="mm").axes
    assert section.get_xlabel() == "place along the motion [mm]"
    (s, body), (_, counter) = (line.get_data() for line in section.lines)
    touching = np.abs(s - (found.centre_of_pressure @ np.array(velocity))) < 0.15
    assert np.abs(body - counter)[touching].max() < 1e-6
    assert np.nanmin(body[s > 1.0]) > np.nanmax(body[s < -1.0])  # behind it has not come back yet
    assert np.abs(pressed.lines[0].get_data() - np.array(found.centre_of_pressure)[:, None]).max() < 1e-12


def test_refused():
    half = half_space(8)
    for others in ({"friction": 0.3}, {"hardness": 1.0}, {"tangential": (0.1, 0.0)}):
        with refused(fc.InputError, "velocity-alone"):
            half.press(BALL, force=0.1, velocity=(1.0, 0.0), **others)
    with refused(fc.InputError, "not-with-adhesion"):
        half_space(8, RUBBER.material).press(BALL, approach=0.1, velocity=(1.0, 0.0), adhesion=fc.Dugdale(1e-3, 1e-2))
    with refused(fc.InputError, "velocity-elastic"):
        half_space(8, RUBBER.material).press(BALL, force=0.1, velocity=(1.0, 0.0))
    with refused(fc.InputError, "at-rest"):
        half.press(BALL, force=0.1, velocity=(0.0, 0.0))
    with refused(fc.InputError, "not-with-adhesion", "several contacts"):
        half.stiffness(half.press(BALL, force=0.1, velocity=(1.0, 0.0)))
    with refused(fc.InputError, "off-axis"):
        half.press(BALL, force=0.1, velocity=(1.0, 1.0))
    with refused(fc.InputError, "pressure-not-available"):
        half_space(8, pressure="bilinear").press(BALL, force=0.1, velocity=(1.0, 0.0))
