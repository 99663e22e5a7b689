"""Profiles of wheels and rails: files, the curve through the points, and places where they meet."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fecontact as fc
from fecontact.surfaces.profile import Profile, read_profile
from fecontact.surfaces.wheel_rail import WheelOnRail
from tests.refusals import refused

MESHES = Path(__file__).parents[3] / "meshes"
SIMPACK = """header.begin
  type = 0
header.end
spline.begin
  {keys}
  units.len.f = 1000.0  ! lengths in a metre
  point.begin
    ! y z
    {points}
  point.end
spline.end
"""
#: A rail's head, heights down as in the file.
POINTS = "-30 14\n-20 2\n-10 0.5 1.0\n0 0\n10 0.5\n20 2\n30 13"


def written(folder, name, text):
    file = folder / name
    file.write_text(text)
    return file


def simpack(folder, keys="", points=POINTS):
    return read_profile(written(folder, "rail.prr", SIMPACK.format(keys=keys, points=points)))


def test_keys_of_simpack_are_obeyed(tmp_path):
    plain = simpack(tmp_path)
    assert np.array_equal(plain.points[[0, 3, 6]], [[-30, -14], [0, 0], [30, -13]])
    assert np.array_equal(simpack(tmp_path, "mirror.y = 1").points[:, 0], -plain.points[::-1, 0])
    assert np.array_equal(simpack(tmp_path, "mirror.z = 1").points[:, 1], -plain.points[:, 1])
    moved = simpack(tmp_path, "shift.y = 2.5\n  shift.z = -1")
    assert np.allclose(moved.points - plain.points, [2.5, 1.0], atol=1e-12)
    bounded = simpack(tmp_path, "bound.y.min = -25\n  bound.y.max = 35")
    assert np.array_equal(bounded.points, plain.points[1:])
    assert np.array_equal(simpack(tmp_path, "inversion = 1").points, plain.points)
    file = tmp_path / "rail.prr"
    assert np.allclose(read_profile(file, unit=1.0).points, 1e-3 * plain.points, rtol=1e-15)
    assert np.array_equal(read_profile(file, mirror=True).points[:, 0], -plain.points[::-1, 0])


def test_a_file_of_miniprof_is_that_of_simpack(tmp_path):
    """Its Y may point up or down; lines in quotes are comments."""
    for sign in (1, -1):
        rows = [f'{line.split()[0]}\t{sign * float(line.split()[1])}  " note' for line in POINTS.splitlines()]
        text = "\n".join(["Filename=x.ban", "XYPoints=7", '"Tilt=', "ColumnDef=X,Y", "", *rows, '"99 99'])
        file = written(tmp_path, "rail.ban", text)
        assert np.allclose(read_profile(file).points, simpack(tmp_path).points, rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.prr", "1 2\n3 4", "point.begin"),
        ("a.prr", SIMPACK.format(keys="rotate = 0.1", points=POINTS), "rotate = 0.1 is not offered"),
        ("a.prr", SIMPACK.format(keys="approx.smooth = 1e-6", points=POINTS), "approx.smooth"),
        ("a.prr", SIMPACK.format(keys="", points=POINTS).replace("units.len.f", "units.len"), "units.len.f"),
        ("a.prr", SIMPACK.format(keys="", points="1 2\n3"), "two numbers"),
        ("a.csv", "y,z\n0,0\n1,0\n", "found 2 points"),
        ("a.csv", "0,zero\n1,0\n2,0\n3,0", "zero"),
    ],
)
def test_files_that_do_not_fit_are_refused(tmp_path, name, text, said):
    with refused(fc.InputError, "unreadable", said, name):
        read_profile(written(tmp_path, name, text))


def test_other_files_and_points_are_refused(tmp_path):
    with refused(fc.InputError, "no-file"):
        read_profile(tmp_path / "none.prw")
    with pytest.raises(fc.InputError, match="suffix of a profile"):
        read_profile(written(tmp_path, "a.stl", ""))
    with refused(fc.InputError, "wrong-shape"):
        Profile(np.zeros((3, 2)))
    with refused(fc.InputError, "wrong-shape", "apart"):
        Profile(np.array([[0, 0], [1e-9, 0], [1, 0], [1 + 1e-9, 0], [2, 1]]))
    with pytest.raises(fc.InputError, match="smoothing"):
        Profile(np.random.default_rng(0).random((5, 2)), -1.0)


def arc(radius, n=61, reach=0.4, noise=0.0):
    angle = np.linspace(-reach, reach, n)
    points = np.stack([radius * np.sin(angle), radius * (np.cos(angle) - 1)], axis=1)
    return points + noise * np.random.default_rng(1).normal(size=points.shape)


def test_the_curve_goes_through_the_points_and_between_them_by_fourth_order():
    profile = Profile(arc(80.0))
    y = np.linspace(-25, 25, 77)
    assert np.abs(profile.height(y) - (np.sqrt(80.0**2 - y**2) - 80.0)).max() < 2e-5
    assert np.abs(profile.angle(y) + np.arcsin(y / 80.0)).max() < 2e-5
    assert profile.deviation < 1e-12
    assert profile.left_out == 0
    assert np.isnan(profile.height(40.0))
    turned = profile.turned(0.1)
    assert abs(turned.angle(0.0) - 0.1) < 2e-5


def test_smoothing_takes_noise_away():
    noisy = arc(80.0, noise=0.01)
    y = np.linspace(-20, 20, 41)
    exact = -np.arcsin(y / 80.0)
    rough, smooth = (np.abs(Profile(noisy, s).angle(y) - exact).max() for s in (0.0, 0.014))
    assert smooth < 0.3 * rough
    assert abs(Profile(noisy, 0.01).deviation - 0.01) < 1e-4


def test_points_next_to_each_other_are_left_out():
    points = arc(80.0)
    twice = np.concatenate([points[:10], points[9:10] + 1e-9, points[10:]])
    assert Profile(twice).left_out == 1
    assert np.array_equal(Profile(twice).points, Profile(points).points)


def test_the_gauge_face_is_found_or_refused():
    rail = read_profile(MESHES / "MBench_UIC60_v3.prr")
    y = rail.gauge_face(14.0)
    assert abs(rail.height(y) + 14.0) < 1e-6
    assert abs(y + 43.03) < 0.01
    with refused(fc.InputError, "gauge-face", "rail_position="):
        Profile(arc(80.0)).gauge_face(14.0)


def spheres_wheel():
    """A ball of radius 100 as a wheel on a circular rail of radius 80."""
    return WheelOnRail(Profile(arc(100.0) * [1, -1]), Profile(arc(80.0)), 100.0, 750.0, 750.0)


@pytest.mark.parametrize("yaw", [0.0, 0.02])
@pytest.mark.parametrize("roll", [0.0, -0.03])
def test_a_ball_touches_where_its_middle_says(yaw, roll):
    """Of a ball the place follows from its middle alone: the gap is the distance from there to the rail's axis."""
    pair = replace(spheres_wheel(), yaw=yaw, roll=roll, shift=1.0)
    middle = pair.middle + pair.axes @ [0.0, 750.0, 0.0]
    height = math.sqrt(180.0**2 - (middle[1] - 750.0) ** 2) - 80.0  # of its middle, where the ball touches the rail
    assert abs(pair.touching_lift - (height - middle[2])) < 3e-5
    pair = replace(pair, lift=pair.touching_lift - 0.01)
    (place,) = pair.places()
    middle = pair.middle + pair.axes @ [0.0, 750.0, 0.0]
    angle = -math.asin((middle[1] - 750.0) / math.hypot(middle[1] - 750.0, middle[2] + 80.0))
    assert abs(place.angle - angle) < 1e-5
    assert abs(place.origin[0] - middle[0]) < 1e-4
    # in the plane of the place: ball less rail, over the plane
    x, s = np.linspace(-2, 2, 5), np.linspace(-2, 2, 7)
    along, across, normal = place.axes @ (middle - place.origin)
    ball = normal - np.sqrt(100.0**2 - (x[:, None] - along) ** 2 - (s - across) ** 2)
    rail_middle = place.axes @ (np.array([0.0, 750.0, -80.0]) - place.origin)
    rail = rail_middle[2] + np.sqrt(80.0**2 - (s - rail_middle[1]) ** 2)
    assert np.abs(place.gap(x, s) - (ball - rail)).max() < 1e-4
    assert np.isinf(place.gap(x, np.array([500.0]))).all()


def test_creepages_have_their_signs():
    """A wheel that turns too fast slips backwards; one that heads to the left slips to the right; spin by its angle."""
    pair = spheres_wheel()
    pair = replace(pair, lift=pair.touching_lift - 1e-3)
    (place,) = pair.places()
    along, across, spin = place.rigid_motion(1.01)
    assert abs(along - (1 - 1.01) / 1.005) < 1e-4
    assert abs(across) < 1e-6
    assert abs(spin) < 1e-6
    (turned,) = replace(pair, yaw=0.01, lift=pair.lift).places() or [place]
    along, across, spin = turned.rigid_motion()
    assert abs(across + 0.01 * turned.rolling_radius / 100.0) < 1e-3
    (shifted,) = (lambda at: replace(at, lift=at.touching_lift - 1e-3))(replace(pair, shift=5.0)).places()
    assert abs(shifted.rigid_motion()[2] + math.sin(shifted.angle) / 100.0) < 1e-5


def bumps(distance, at=0.0):
    """A rail with two crowns beside each other."""
    y = np.linspace(-40, 40, 801)
    return Profile(np.stack([y, -((np.abs(y) - distance / 2) ** 2) / 600 - at * y], axis=1), 1e-4)


@pytest.mark.parametrize(("join", "count"), [(0.0, 2), (5.0, 2), (12.0, 1)])
def test_places_nearer_than_asked_share_a_plane(join, count):
    wheel = Profile(np.stack([np.linspace(-60, 60, 31), np.zeros(31)], axis=1))
    pair = WheelOnRail(wheel, bumps(15.0), 460.0, 0.0, 0.0)
    pair = replace(pair, lift=pair.touching_lift - 0.02)
    assert len(pair.places(join)) == count  # overlaps 15 mm apart, less twice the root of 2 x 300 x .02
    assert not replace(pair, lift=pair.lift + 1.0).places(join)
