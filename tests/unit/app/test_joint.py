"""Joints: clinical angles, motion files, thickness of cartilage, and a path of poses."""

import numpy as np
import pytest
from refusals import refused
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact import InputError
from fecontact.app.joint.cartilage import thickness_between

RNG = np.random.default_rng(5)
SIDES = ("right", "left")
E1, E2, E3 = np.eye(3)


def pose_of(side, **values):
    return fc.GroodSuntay(**values, side=side).pose


@pytest.mark.parametrize("side", SIDES)
def test_each_angle_turns_the_tibia_as_anatomy_says(side):
    outwards = E1 if side == "right" else -E1  # away from the middle of the body
    shin = -E3  # from the knee to the ankle
    bent = pose_of(side, flexion=90.0).rotation
    assert np.allclose(bent @ shin, -E2)  # the ankle goes backwards
    bowed = pose_of(side, adduction=30.0).rotation @ shin
    assert np.allclose(bowed, np.cos(np.pi / 6) * shin - 0.5 * outwards)  # the ankle goes to the middle
    toes = pose_of(side, external_rotation=20.0).rotation @ E2
    assert np.allclose(toes @ outwards, np.sin(np.radians(20)))
    # translations at rest: outwards, forwards, and downwards
    assert np.allclose(pose_of(side, lateral=1, anterior=2, distraction=3).translation, outwards + 2 * E2 - 3 * E3)


@pytest.mark.parametrize("side", SIDES)
def test_rotations_about_the_joints_axes_do_not_depend_on_their_order(side):
    values = {"flexion": 40.0, "adduction": 12.0, "external_rotation": -25.0}
    whole = pose_of(side, **values).rotation
    sign = 1.0 if side == "right" else -1.0
    # the tibia is turned about e3 first or last: its own z axis before, and where it has gone after
    without = pose_of(side, **{**values, "external_rotation": 0.0}).rotation
    about = Rotation.from_rotvec(np.radians(25.0) * sign * without[:, 2]).as_matrix()
    assert np.allclose(about @ without, whole)
    # the same of flexion about e1, which is the femur's
    straight = pose_of(side, **{**values, "flexion": 0.0}).rotation
    assert np.allclose(Rotation.from_rotvec(-np.radians(40.0) * E1).as_matrix() @ straight, whole)
    # and of adduction about the floating axis, normal to both
    level = pose_of(side, **{**values, "adduction": 0.0}).rotation
    floating = np.cross(level[:, 2], E1)
    assert np.allclose(Rotation.from_rotvec(np.radians(12.0) * sign * floating).as_matrix() @ level, whole)


@pytest.mark.parametrize("side", SIDES)
def test_angles_come_back_from_the_pose_and_the_femur_moves_the_other_way(side):
    for values in RNG.uniform(-80, 80, (20, 6)):
        given = fc.GroodSuntay(*values.tolist(), side=side)
        back = fc.GroodSuntay.of(given.pose, side)
        found = [getattr(back, name) for name in ("flexion", "adduction", "external_rotation")]
        found += [back.lateral, back.anterior, back.distraction]
        assert np.allclose(found, values, atol=1e-9)
        points = RNG.normal(size=(4, 3))
        assert np.allclose(given.femur.to_world(given.pose.to_world(points)), points)
    # the mirror image of a right knee is a left knee of the same angles
    mirror = np.diag([-1.0, 1.0, 1.0])
    right, left = (fc.GroodSuntay(*values.tolist(), side=s).pose for s in SIDES)
    assert np.allclose(mirror @ right.rotation @ mirror, left.rotation)
    assert np.allclose(mirror @ right.translation, left.translation)


def test_angles_that_say_nothing_are_refused():
    with refused(InputError, "unknown-name", "side"):
        fc.GroodSuntay(side="middle")
    with refused(InputError, "not-finite", "The external rotation"):
        fc.GroodSuntay(external_rotation=np.nan)
    with refused(InputError, "gimbal-lock"):
        fc.GroodSuntay.of(fc.GroodSuntay(adduction=90.0).pose)


GOOD = """walk
version=1
nRows=3
nColumns=3
inDegrees={unit}

Some words of the program that wrote it.
endheader
time\tknee_angle_r\tknee_tx
0.0\t{a}\t1.5
0.5\t{b}\t2.5
1.0\t{c}\t4.5
"""


def written(tmp_path, text, name="walk.mot"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_motion_file_is_read_in_degrees_or_radians(tmp_path):
    degrees = fc.read_motion(written(tmp_path, GOOD.format(unit="yes", a=10.0, b=20.0, c=40.0)))
    assert degrees.names == ("knee_angle_r", "knee_tx")
    assert degrees.times.tolist() == [0.0, 0.5, 1.0]
    assert degrees.angle("-knee_angle_r").tolist() == [-10.0, -20.0, -40.0]
    assert "3 times from 0 to 1: knee_angle_r, knee_tx" in repr(degrees)
    between = degrees.at([0.25, 0.75])
    assert between.angle("knee_angle_r").tolist() == [15.0, 30.0]
    assert between.column("knee_tx").tolist() == [2.0, 3.5]
    a, b, c = np.radians([10.0, 20.0, 40.0])
    radians = fc.read_motion(written(tmp_path, GOOD.format(unit="no", a=a, b=b, c=c)))
    assert np.allclose(radians.angle("knee_angle_r"), [10.0, 20.0, 40.0])
    # the older head of .sto files
    old = GOOD.format(unit="yes", a=1, b=2, c=3).replace("nRows=3", "datarows 3").replace("nColumns=3", "datacolumns 3")
    assert len(fc.read_motion(written(tmp_path, old, "walk.sto")).times) == 3
    for times, missing in (([2.0], ("input", "outside")), ([np.nan], ("input", "no times"))):
        with refused(InputError, *missing):
            degrees.at(times)
    with refused(InputError, "input", "'hip'"):
        degrees.column("hip")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("endheader\n", "", ("no-endheader",)),
        ("nRows=3", "nRows=4", ("input", "of 4")),
        ("nColumns=3", "nColumns=9", ("input", "of 9")),
        ("nRows=3", "nRows=three", ("not-a-number", "line 3")),
        ("inDegrees=yes", "inDegrees=maybe", ("in-degrees", "'maybe'")),
        ("time\t", "t\t", ("input", "must be 'time'")),
        ("knee_tx", "knee_angle_r", ("columns-twice",)),
        ("2.5", "", ("row-length", "line 11", "11: 2", "for 3")),
        ("2.5", "two", ("not-a-number", "line 11")),
        ("2.5", "nan", ("not-finite", "line 11")),
        ("0.5\t", "0.0\t", ("input", "line 11", "time 0")),
    ],
)
def test_a_motion_file_that_is_none_is_refused_with_its_line(tmp_path, old, new, told):
    text = GOOD.format(unit="yes", a=10.0, b=20.0, c=40.0)
    assert old in text
    with refused(InputError, *told):
        fc.read_motion(written(tmp_path, text.replace(old, new, 1)))


def test_a_motion_file_without_rows_or_without_file_is_refused(tmp_path):
    with refused(InputError, "no-rows"):
        fc.read_motion(written(tmp_path, "endheader\ntime x\n"))
    for path in (tmp_path / "none.mot", tmp_path):
        with refused(InputError, "unreadable"):
            fc.read_motion(path)


def dome(radius, n=4, centre=0.0):
    """Part of a sphere, facing up."""
    x, y = np.meshgrid(*[np.linspace(-1.0, 1.0, n + 1)] * 2, indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    facets = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    points = np.stack([x, y, centre + np.sqrt(radius**2 - x**2 - y**2)], axis=-1).reshape(-1, 3)
    return fc.SurfaceMesh(points, np.stack([f.ravel() for f in facets], axis=1))


def test_thickness_between_concentric_spheres_is_the_difference_of_radii():
    bone, outer = dome(4.0), dome(5.0, 40).mapped(lambda x: x * [1.6, 1.6, 1.0])
    outer = outer.mapped(lambda x: np.column_stack([x[:, :2], np.sqrt(25 - (x[:, :2] ** 2).sum(axis=1))]))
    # the outer facets depart from their sphere by 0.08^2 / (8 R); at the bone's corner the mean normal leans by half a
    # facet's diagonal over R, 0.09, which lengthens the way by its square over two at the most
    assert np.abs(thickness_between(bone, outer)[bone.nodes] - 1.0).max() < 0.09**2 / 2
    for wrong in (outer.flipped(), dome(5.0).mapped(lambda x: x + 5.0 * E1), dome(3.0, 40)):
        with refused(InputError, "cartilage-off-bone"):
            thickness_between(bone, wrong)


@pytest.fixture(scope="module")
def joint():
    flat = dome(40.0).mapped(lambda x: x * [2.0, 2.0, 0.0])
    return fc.Joint(
        flat.flipped(),
        flat,
        (0.5, 1.0),
        fc.Material(E=10.0, nu=0.0),
        units=("mm", "N", "MPa"),
        names=("femur", "tibia"),
    )


def test_layers_with_a_law_are_compressed_as_its_closed_form_says():
    flat = dome(40.0).mapped(lambda x: x * [2.0, 2.0, 0.0])
    joint = fc.Joint(flat.flipped(), flat, (0.5, 1.0), fc.NeoHookean(E=10.0, nu=0.0))
    stretches = np.array([0.95, 0.7])
    table = joint.follow([fc.Pose(translation=(0.0, 0.0, 1.5 * s)) for s in stretches])
    # nu = 0: no strain across, so that the Cauchy pressure is E/2 (1/s - s) of the present stretch s
    assert np.abs(table.column("max_pressure") - 5.0 * (1 / stretches - stretches)).max() < 1e-7
    assert np.abs(table.column("area") - 16.0).max() < 1e-9


def test_a_path_gives_a_table_and_maps_and_goes_on_where_it_stopped(joint, tmp_path):
    heights = np.array([1.5, 1.6, 1.45])
    matrices = np.tile(np.eye(4), (3, 1, 1))
    matrices[:, 2, 3] = heights
    forces = -np.outer([8.0, 16.0, 32.0], E3)
    path, maps = tmp_path / "rows.jsonl", tmp_path / "maps"
    table = joint.follow(matrices, forces, times=[0.0, 0.1, 0.2], path=path, maps=maps)
    # without bulging (nu = 0) uniform pressure: force over area, and the layers give by p (t / E)
    assert np.allclose(table.column("mean_pressure"), [0.5, 1.0, 2.0])
    assert np.allclose(table.column("max_pressure"), [0.5, 1.0, 2.0])
    assert np.allclose(table.column("force_z"), [8.0, 16.0, 32.0])
    assert np.allclose(table.column("area"), 16.0)
    assert sorted(p.name for p in maps.iterdir()) == [f"000{k}.{kind}" for k in range(3) for kind in ("csv", "png")]
    head, *points = (maps / "0002.csv").read_text().splitlines()
    assert np.allclose([float(line.split(",")[head.split(",").index("pressure")]) for line in points], 2.0)
    # the same path again: nothing is solved, so no maps are written
    for file in maps.iterdir():
        file.unlink()
    again = joint.follow(matrices, forces, times=[0.0, 0.1, 0.2], path=path, maps=maps)
    assert str(again) == str(table)
    assert not list(maps.iterdir())
    assert str(table).splitlines()[0].split()[:4] == ["case", "time", "forces", "femur"]
    assert "femur on tibia: forces on femur" in str(table)
    saved = np.genfromtxt(table.save(tmp_path / "table.csv"), delimiter=",", names=True)
    assert np.allclose(saved["mean_pressure"], [0.5, 1.0, 2.0])
    assert any("20.0 %" in warning for warning in table.warnings["0002"])
    with refused(InputError, "unknown-name", "'peak'"):
        table.column("peak")


def test_without_forces_the_bone_stays_where_it_is(joint):
    # layers of 0.5 and 1 mm pressed together by 0.15 mm: p = E 0.15 / 1.5
    table = joint.follow([fc.Pose(translation=(0, 0, 1.35))])
    assert np.allclose(table.column("mean_pressure"), 1.0)
    # a force that acts beside the middle presses more on one side, if the bone may tilt
    tilted = joint.follow([fc.Pose(translation=(0, 0, 1.5))], (0, 0, -16.0), free="z ry", at=(0.2, 0.0, 0.0))
    # the tilt of 0.02 shifts it by its square, 4e-4, times the arm of 1.5 mm, and less
    assert abs(tilted.column("centre_x")[0] - 0.2) < 0.01 * 0.2


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"poses": []}, ("no-steps",)),
        ({"poses": [np.eye(3)]}, ("no-pose", "Pose 0")),
        ({"poses": ["up"]}, ("wrong-class", "Pose 0")),
        ({"poses": [2 * np.eye(4)]}, ("no-pose",)),
        ({"forces": [[0, 0, 1], [0, 0, 1]]}, ("input", "one vector")),
        ({"moments": "up"}, ("not-numbers", "the moments")),
        ({"times": [0.0, 1.0]}, ("times-differ", "are 1", "and 2")),
        ({"at": (0, 0)}, ("not-a-vector", "three")),
    ],
)
def test_what_is_no_path_is_refused(joint, given, told):
    with refused(InputError, *told):
        joint.follow(**{"poses": [fc.Pose()], "forces": (0, 0, -1.0), **given})


def test_bones_and_materials_that_are_none_are_refused(joint):
    with refused(InputError, "wrong-class", "The moving bone"):
        fc.Joint("femur.stl", joint.fixed, 1.0, fc.Material(1.0, 0.3))
    with refused(InputError, "wrong-class", "The material"):
        fc.Joint(joint.moving, joint.fixed, 1.0, 10.0)
    with refused(InputError, "input", "names are those of the moving and the fixed bone"):
        fc.Joint(joint.moving, joint.fixed, 1.0, fc.Material(1.0, 0.3), names=("femur",))
    with refused(InputError, "one-or-two-values", "found 3"):
        fc.Joint(joint.moving, joint.fixed, (1.0, 2.0, 3.0), fc.Material(1.0, 0.3)).bodies  # noqa: B018
