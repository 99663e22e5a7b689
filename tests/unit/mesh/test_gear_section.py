"""Involute gears: what a rack cuts, by what is measured on gears and by how two of them roll on each other."""

import math

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.mesh.gear_section import Gear, centre_distance, involute

GEARS = (Gear(4.0, 20), Gear(2.5, 33, shift=0.4), Gear(1.0, 18, math.radians(22.5), shift=-0.05))


def flank_points(gear, n=40):
    """Points of the right flank of a tooth upwards."""
    radius = np.linspace(gear.form_radius, gear.outer_radius, n)
    angle = gear.half_angle(radius)
    return np.stack([radius * np.sin(angle), radius * np.cos(angle)], axis=1)


@pytest.mark.parametrize("gear", GEARS)
def test_span_over_teeth(gear):
    """The base tangent over k teeth, m cos(a) ((k - 1/2) pi + z inv(a)) + 2 x m sin(a); K. Roth, Zahnradtechnik, 1989.

    Flanks k - 1 pitches apart, whose common normal touches the base circle: one below that pitch's middle, one above.
    """
    a, m, k = gear.pressure_angle, gear.module, 3
    span = m * math.cos(a) * ((k - 0.5) * math.pi + gear.teeth * involute(a)) + 2 * gear.shift * m * math.sin(a)
    # both ends on one tangent of the base circle, span / 2 from the place where it touches
    radius = np.array([math.hypot(gear.base_radius, span / 2)])
    assert gear.form_radius < radius[0] < gear.outer_radius
    roll = span / 2 / gear.base_radius
    from_middle = gear.half_angle(radius)[0] + (k - 1) * math.pi / gear.teeth
    assert math.atan(roll) == pytest.approx(from_middle, rel=1e-12)


@pytest.mark.parametrize("gear", GEARS)
def test_flank_and_fillet_are_one_smooth_outline(gear):
    """The fillet by the rolling tip begins where the involute ends, along its tangent, and ends on the root circle."""
    fillet = gear._fillet(400)
    assert fillet[0, 1] == pytest.approx(gear.form_radius, rel=1e-13)
    assert fillet[0, 0] == pytest.approx(gear.half_angle(np.array([gear.form_radius]))[0], rel=1e-12)
    assert fillet[-1, 1] == pytest.approx(gear.root_radius, rel=1e-13)
    step = 1e-5 * gear.module
    slope = np.diff(gear.half_angle(gear.form_radius + np.array([0, step])))[0] / step
    below = (fillet[1, 0] - fillet[0, 0]) / (fillet[1, 1] - fillet[0, 1])
    assert below * gear.pitch_radius == pytest.approx(slope * gear.pitch_radius, abs=0.02)  # chords of 1/400 of it


@pytest.mark.parametrize("shifts", [(0.0, 0.0), (0.3, 0.1), (0.4, -0.2)])
def test_gears_roll_on_each_other_without_backlash(shifts):
    """At the centre distance both flanks of a gap touch, at any turn: the least gap between outlines is nothing."""
    one, other = (Gear(3.0, z, shift=x) for z, x in zip((22, 35), shifts, strict=True))
    distance = centre_distance(one, other)
    fine = flank_points(other, 20000)
    for turn in (-0.05, 0.0, 0.04):
        for side in (1, -1):
            flank = flank_points(one, 300) * [side, 1]
            c, s = math.cos(turn), math.sin(turn)
            x = flank @ np.array([[c, -s], [s, c]])
            back = math.pi - side * math.pi / other.teeth - turn * one.teeth / other.teeth
            c, s = math.cos(back), math.sin(back)
            y = (x - [0, distance]) @ np.array([[c, s], [-s, c]])  # in the axes of the other's tooth, turned upwards
            r = np.hypot(*y.T)
            near = (r > other.form_radius) & (r < other.outer_radius)
            off = r[near] * (
                side * np.arctan2(y[near, 0], y[near, 1]) - np.interp(r[near], np.hypot(*fine.T), np.arctan2(*fine.T))
            )
            assert abs(off.min()) < 2e-4 * one.module  # of 300 points of the flank


def test_section_has_the_flanks_where_they_belong():
    gear = Gear(4.0, 20)
    mesh = gear.section(3, flank=10)
    for k in range(3):
        for side, sign in (("left", -1), ("right", 1)):
            x = mesh.points[mesh.boundary_nodes(f"{side} {k}")]
            r, angle = np.hypot(x[:, 0], x[:, 2]), np.arctan2(x[:, 0], x[:, 2])
            off = r * (sign * (angle - (k - 1) * 2 * math.pi / 20) - gear.half_angle(r))
            assert np.abs(off).max() < 1e-10  # nodes in the middle of sides too
            assert r.min() == pytest.approx(gear.form_radius)
            assert r.max() == pytest.approx(gear.outer_radius)
    assert np.hypot(*mesh.points[mesh.boundary_nodes("bore")][:, ::2].T) == pytest.approx(gear.root_radius - 10.0)


def test_relief_and_refusals():
    plain, relieved = Gear(4.0, 20), Gear(4.0, 20, relief=0.02)
    r = np.linspace(plain.form_radius, plain.outer_radius, 5)
    off = plain.base_radius * (plain.half_angle(r) - relieved.half_angle(r))  # along the normal
    assert off[-1] == pytest.approx(0.02)
    assert off[:3] == pytest.approx(0.0, abs=1e-15)
    with refused(fc.InputError, "undercut", "undercuts 12 teeth with a shift of 0: take more teeth, or a shift"):
        Gear(4.0, 12)
    Gear(4.0, 12, shift=0.4)
    with refused(fc.InputError, "pointed", "pointed"):
        Gear(4.0, 12, shift=1.0)
    with refused(fc.InputError, "gear-pair", "one module"):
        centre_distance(plain, Gear(3.0, 20))
