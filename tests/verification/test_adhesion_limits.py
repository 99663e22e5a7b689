"""Adhesion on half-spaces against Maugis, JKR and Johnson: pull-off, jumps, energy lost, a wave."""

import math

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import adhesion

WORK, K = 1e-5, 4 / 3
#: Units of radius and force of a ball of radius 1 on E* = 1; that of approach is the radius squared.
RADIUS, FORCE = (math.pi * WORK / K) ** (1 / 3), math.pi * WORK
PLAIN = fc.Material(E=1.0, nu=0.0)


def dugdale(lam):
    return fc.Dugdale(WORK, WORK / (lam / 2 * (math.pi * WORK * K**2) ** (1 / 3)))


def ball(lam, cells, approaches, start=()):
    """Curve of a ball at approaches from that of the pull-off, in units, after those of a start; the exact states."""
    law = dugdale(lam)
    exact = adhesion.maugis(1.0, 1.0, WORK, law.range)
    k = exact.force.argmin()
    side = 2.5 * max(exact.c[k], 1.35 * RADIUS)
    half = fc.HalfSpace(PLAIN, size=(side, side), cells=(cells, cells))
    path = np.r_[start, exact.approach[k] + np.array(approaches) * RADIUS**2]
    return half.curve(fc.surfaces.Paraboloid(1.0), approaches=path, adhesion=law), exact


@pytest.mark.parametrize("cells", [32, 64])
@pytest.mark.parametrize("lam", [0.1, 0.25, 0.5, 1.0, 2.0])
def test_pull_off_of_a_ball(lam, cells, row):
    """From DMT towards JKR: within 0.7 % of Maugis on 32 cells, 0.25 % on 64.

    Source: Maugis, J. Colloid Interface Sci. 150 (1992) 243, equations 6.17 to 6.19.
    """
    curve, exact = ball(lam, cells, [0.2, 0.1, 0.0, -0.1])
    row(f"lambda {lam:g}, {cells} cells", "pull-off over pi w R", exact.pull_off / FORCE, curve.pull_off / FORCE)
    assert abs(curve.pull_off / exact.pull_off - 1) < {32: 0.007, 64: 0.0025}[cells]
    assert curve.figures["stability"].min() > 0
    assert curve.figures["worst_residual"].max() < 1e-6


@pytest.mark.full
def test_jkr_is_the_limit(row):
    """At lambda = 5, cells nearly as wide as the zone: Maugis' pull-off to 0.5 %, that of JKR, 3/2 pi w R, to 1 %.

    So is the approach of coming off.
    """
    curve, exact = ball(5.0, 128, [0.1, 0.0, -0.1, -0.4, -0.46, -0.5], start=[0.0])
    row("128 cells", "pull-off over pi w R", exact.pull_off / FORCE, curve.pull_off / FORCE)
    assert abs(curve.pull_off / exact.pull_off - 1) < 0.005
    limit = adhesion.jkr(1.0, 1.0, WORK, np.linspace(0.01, 3, 10_000) * RADIUS)
    row("128 cells", "pull-off over that of JKR", 1.0, curve.pull_off / limit.pull_off)
    assert abs(curve.pull_off / limit.pull_off - 1) < 0.01
    (off,) = [jump for jump in curve.jumps if not jump.on and jump.after == 0]
    row("128 cells", "approach of coming off", exact.approach.min(), off.approach)
    assert abs(off.approach / limit.approach.min() - 1) < 0.01


@pytest.mark.full
def test_a_loop_loses_what_its_jumps_lose(row):
    """On and off at lambda = 2: jumps at a gap of the range and where Maugis' curve turns back; energy in balance."""
    law, unit = dugdale(2.0), RADIUS**2
    exact = adhesion.maugis(1.0, 1.0, WORK, law.range)
    half = fc.HalfSpace(PLAIN, size=(4 * RADIUS, 4 * RADIUS), cells=(64, 64))
    on = np.linspace(-1.1, 0.1, 13) * unit
    loop = half.curve(fc.surfaces.Paraboloid(1.0), approaches=np.r_[on, on[::-1]], adhesion=law)
    first, last = loop.jumps
    row("64 cells", "approach of coming on", -law.range / unit, first.approach / unit)
    row("64 cells", "approach of coming off", exact.approach.min() / unit, last.approach / unit)
    row("64 cells", "energy lost, loop against jumps", first.lost + last.lost, loop.hysteresis)
    assert abs(first.approach + law.range) < 0.005 * unit
    assert abs(last.approach - exact.approach.min()) < 0.005 * unit
    assert abs(loop.hysteresis / (first.lost + last.lost) - 1) < 0.02


def test_a_wave_comes_to_johnsons(row):
    """Mean pressure at the half-width found, over p*: its difference falls with the width of the zone.

    Source: Johnson, Int. J. Solids Struct. 32 (1995) 423: attraction of no range.
    """
    amplitude, cells = 0.01, 512
    closing = math.pi * amplitude
    work = 0.3**2 * closing**2 / 2
    errors = []
    for zone in (0.02, 0.01):
        law = fc.Dugdale(work, work / math.sqrt(math.pi * work / (4 * zone)))
        half = fc.HalfSpace(PLAIN, size=(1.0, 4 / cells), cells=(cells, 4), periodic=True)
        z = -amplitude * np.cos(2 * math.pi * half.grid.x)[:, None] * np.ones(4)
        curve = half.curve(z, approaches=np.array([-0.8, -0.5, -0.2, -0.4, -0.7]) * amplitude, adhesion=law)
        a, found = curve.figures["area"] / (4 / cells) / 2, curve.force / (4 / cells) / closing
        exact = adhesion.wave(amplitude, 1.0, 1.0, work, a) / closing
        row(f"zone of {zone:g} wavelengths", "mean pressure over p*", float(exact[2]), float(found[2]))
        errors.append(found - exact)
    assert np.abs(errors[0]).max() < 0.03  # width of the zone times the slope over the half-width, below 1.5
    assert np.abs(2 * errors[1] - errors[0]).max() < 0.003  # in proportion to the zone
