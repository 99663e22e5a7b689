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


def test_results_of_jam_are_columns_by_their_paths(tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "walking.h5"
    with h5py.File(path, "w") as file:
        file["time"] = [0.0, 0.5, 1.0]
        file["knee/coordinateset/flex_r/value"] = [0.0, 10.0, 30.0]
        file["knee/forceset/contact/force"] = np.arange(9.0).reshape(3, 3)
        file["knee/forceset/contact/triangles"] = np.zeros((3, 20))
        file["knee/names"] = [b"a", b"b", b"c"]
    motion = fc.read_motion(path)
    assert motion.in_degrees
    assert motion.at([0.25]).column("knee/coordinateset/flex_r/value").tolist() == [5.0]
    assert motion.vector("knee/forceset/contact/force").tolist() == np.arange(9.0).reshape(3, 3).tolist()
    assert len(motion.names) == 4
    with pytest.raises(InputError, match="no column"):
        motion.vector("knee/forceset/contact/moment")
    with h5py.File(path, "a") as file:
        del file["time"]
    with refused(InputError, "no-results"):
        fc.read_motion(path)
    path.write_text("no file of this kind")
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
    assert any("20.0 %" in warning for warning in table.warnings if warning.startswith("0002: "))
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


def flat(height=0.0):
    return dome(40.0).mapped(lambda x: x * [2.0, 2.0, 0.0] + [0.0, 0.0, height])


PAIR = {"units": ("mm", "N", "MPa"), "names": ("femur", "tibia")}


def test_an_elastic_foundation_gives_by_its_own_pressure_and_thickness():
    # two layers of thickness that varies along x, pressed flat by d: p = K d / (h1 + h2) at each point
    x = flat().points[:, 0]
    thick = (0.5 + 0.05 * x, 1.0 + 0.1 * x**2)
    soft = fc.Material(E=10.0, nu=0.45)
    joint = fc.Joint(flat().flipped(), flat(), thick, soft, surfaces="cartilage", foundation=True, **PAIR)
    table = joint.follow([fc.Pose(translation=(0, 0, -0.01))], keep="pressure")
    modulus = 10.0 * 0.55 / (1.45 * 0.1)
    field = table.fields("pressure")[0]
    places = field.points[:, 0]
    exact = modulus * 0.01 / (1.5 + 0.05 * places + 0.1 * places**2)
    assert np.abs(field.values / exact - 1).max() < 0.02  # thickness is linear on facets of 1 mm, not square
    acl = fc.Ligament("ACL", (0, 0, 1), (0, 0, 0), 1.0, 1.0)
    for one in ({"springs": [acl]}, {"layers": 2}):
        with refused(InputError, "foundation"):
            fc.Joint(flat().flipped(), flat(), 1.0, soft, foundation=True, **one)
    with refused(InputError, "wrong-class", "elastic foundation"):
        fc.Joint(flat().flipped(), flat(), 1.0, fc.NeoHookean(1.0, 0.3), foundation=True)
    with refused(InputError, "thickness-not-positive"):
        fc.Joint(flat().flipped(), flat(), -1.0, soft, foundation=True).follow([fc.Pose()])


def test_layers_grow_from_free_surfaces_to_the_bone():
    bone, free = dome(4.0, 20), dome(5.0, 20)  # the free surface covers a part of the bone
    partner = flat(4.95).flipped()
    soft = fc.Material(E=10.0, nu=0.3)
    joint = fc.Joint(partner, free, (0.01, bone), soft, surfaces=("bone", "cartilage"), **PAIR)
    layer = joint.bodies[1]
    assert layer.contact == ("base",)
    mesh = layer.mesh
    corners = mesh.points[np.unique(mesh.face_nodes(mesh.faces("top"))[:, :4])]
    # facets of 0.1 depart from their sphere of 4 by 0.1^2 / (4 R)
    assert np.abs(np.linalg.norm(corners, axis=1) - 4.0).max() < 0.1**2 / 16
    outer = mesh.points[np.unique(mesh.face_nodes(mesh.faces("base"))[:, :4])]
    assert np.abs(np.linalg.norm(outer, axis=1) - 5.0).max() < 1e-12
    assert joint.follow([fc.Pose()]).column("force_z")[0] > 0
    with refused(InputError, "unknown-name", "surfaces"):
        fc.Joint(partner, bone, 1.0, soft, surfaces="skin")


def test_a_thickness_may_have_a_least_value_where_the_bone_is_missing():
    bone = flat()
    free = flat(0.5).mapped(lambda x: np.column_stack([x[:, :2] + [1.0, 0.0], x[:, 2] - 0.1 * x[:, 0]]))
    with refused(InputError, "cartilage-off-bone"):
        fc.thickness_between(bone, free)
    found = fc.thickness_between(bone, free, least=0.48)
    lean = 0.5 - 0.1 * (bone.points[:, 0] - 1.0)
    inside = bone.points[:, 0] >= -1.0
    assert np.abs(found - np.maximum(lean, 0.48))[inside].max() < 1e-9
    assert np.all(found[~inside] == 0.48)


def test_a_joint_takes_a_least_thickness_for_surfaces_of_bones_only():
    soft, free = fc.Material(E=10.0, nu=0.0), flat(0.5)
    given = {"material": soft, "surfaces": "cartilage"}
    joint = fc.Joint(free.flipped(), free, thickness=(2.0, flat(0.2)), least=(None, 0.4), **given)
    assert abs(float(np.ptp(joint.bodies[1].mesh.points[:, 2])) - 0.4) < 1e-12
    with refused(InputError, "least"):
        _ = fc.Joint(free.flipped(), free, thickness=2.0, least=0.4, **given).bodies


def closed_dome():
    """A shell of constant thickness on a dome, as one closed surface facing outwards; and its dome."""
    bone = dome(4.0, 8)
    mesh = fc.extrude(bone, 0.5)
    facets = mesh.face_nodes(mesh.outer_faces)[:, :4]
    return fc.SurfaceMesh(mesh.points, facets), bone


def test_a_closed_solid_of_cartilage_has_a_free_side_and_a_side_on_the_bone():
    solid, bone = closed_dome()
    for free, back in (
        fc.cartilage_sides(solid, bone),
        fc.cartilage_sides(solid, towards=(0.0, 0.0, 9.0)),
    ):
        inner = np.linalg.norm(back.points[back.nodes], axis=1)
        outer = np.linalg.norm(free.points[free.nodes], axis=1)
        assert np.abs(inner - 4.0).max() < 1e-9
        assert np.abs(outer - 4.5).max() < 1e-3  # normals of facets are not those of the sphere
        assert (back.normals[back.nodes][:, 2] > 0).all()
        assert (free.normals[free.nodes][:, 2] > 0).all()
    free, back = fc.cartilage_sides(solid, towards=(0.0, 0.0, 9.0))
    assert np.abs(fc.thickness_between(back, free)[back.nodes] - 0.5).max() < 0.02
    for given, told in (
        ({"solid": bone, "bone": bone}, ("open",)),
        ({}, ("sides", "towards=")),
        ({"bone": bone, "towards": (0, 0, 9)}, ("sides",)),
        ({"towards": (0, 0, 9), "angle": 179.0}, ("no-sides", "179 degrees")),
    ):
        with refused(InputError, *told):
            fc.cartilage_sides(**{"solid": solid, **given})


def test_with_friction_poses_are_one_path():
    soft, mu = fc.Material(E=10.0, nu=0.0), 0.2
    joint = fc.Joint(flat().flipped(), flat(), (0.5, 1.0), soft, friction=mu, **PAIR)
    # pressed by 0.03 of 1.5 mm: p = 0.2; dragged: shear modulus 5 over 1.5 mm until mu p = 0.04 at 0.012 mm
    ways = [0.0, 0.006, 0.03, 0.024]
    poses = [fc.Pose(translation=(x, 0.0, 1.47)) for x in ways]
    table = joint.follow(poses, times=[0, 1, 2, 3], keep="pressure", parameters={"way": ways})
    drag = np.abs(table.column("force_x"))
    stuck = 16.0 * 5.0 * 0.006 / 1.5
    # what sticks is sheared, less at the rim, which is free of stress; what slips is held by mu N
    assert drag[0] < 1e-12
    assert 0.8 * stuck < drag[1] < stuck
    assert abs(drag[2] - mu * table.column("force_z")[2]) < 1e-9
    # on the way back it sticks again: the same change for the same way, but for the slip that is left at the rim
    assert abs((drag[2] - drag[3]) / drag[1] - 1) < 0.05
    assert table.column("way").tolist() == ways
    # under a load the bone keeps the components that are named
    loaded = joint.follow([fc.Pose(translation=(x, 0.0, 1.5)) for x in (0.0, 0.1)], (0, 0, -3.2), free="z")
    assert np.abs(np.abs(loaded.column("force_x")) - [0.0, 0.2 * 3.2]).max() < 1e-9
    for given in ({"maps": "maps"}, {"processes": 2}, {"forces": (0, 0, -1.0)}):
        with refused(InputError, "path-with-friction"):
            joint.follow(poses, **given)


def test_ligaments_pull_and_the_table_has_their_tension():
    soft = fc.Material(E=10.0, nu=0.0)
    acl = fc.Ligament("ACL", (0.0, 0.0, 1.0), (0.0, 0.0, -2.0), stiffness=50.0, slack_length=4.0, toe=0.0)
    joint = fc.Joint(flat().flipped(), flat(), (0.5, 1.0), soft, springs=[acl], **PAIR)
    # 1.5 + 1 + 2 = 4.5 mm long: a strain of 0.125
    table = joint.follow([fc.Pose(translation=(0, 0, z)) for z in (1.5, 1.0 + 0.47)])
    assert np.allclose(table.column("ACL: tension"), [50 * 0.125, 50 * (4.47 / 4 - 1)])
    # free along z the ligament alone presses: 50/4 (0.5 - a) = 16 E a / 1.5
    alone = joint.follow([fc.Pose(translation=(0, 0, 1.5))], free="z")
    a = 6.25 / (12.5 + 160 / 1.5)
    assert np.allclose(alone.column("force_z"), 160 * a / 1.5)
    assert np.allclose(alone.column("ACL: tension"), 160 * a / 1.5)
    with refused(InputError, "wrong-class", "Each spring"):
        fc.Joint(flat().flipped(), flat(), 1.0, soft, springs=["ACL"])


@pytest.mark.parametrize("side", SIDES)
def test_the_table_has_the_angles_of_the_solved_poses(side):
    soft = fc.Material(E=10.0, nu=0.0)
    # bones with their own axes, turned from the clinical ones
    turn = Rotation.from_euler("xyz", [0.3, -0.2, 0.5]).as_matrix()
    tibial = fc.Pose(turn, (0.1, 0.2, -0.3))
    knee = fc.GroodSuntay(flexion=0.4, adduction=0.1, external_rotation=0.2, distraction=-0.4, side=side)
    pose = knee.femur
    back = tibial.rotation.T, -tibial.rotation.T @ tibial.translation
    # the femur whose clinical axes are at that pose in the tibia's
    femoral = fc.Pose(pose.rotation, pose.translation).then(tibial.rotation, tibial.translation)
    assert np.allclose(back[0] @ femoral.rotation, pose.rotation)
    joint = fc.Joint(flat().flipped(), flat(), 0.5, soft, anatomy=(femoral, tibial), side=side, **PAIR)
    table = joint.follow([fc.Pose(translation=(0, 0, 0.99))])
    moved = fc.GroodSuntay.of(tibial.relative_to(femoral.then(np.eye(3), (0, 0, 0.99))), side)
    for name in ("flexion", "adduction", "external_rotation", "lateral", "anterior", "distraction"):
        assert abs(table.column(name)[0] - getattr(moved, name)) < 1e-9
    # a load moves the bone by its compression, and the table tells where to
    free = joint.follow([fc.Pose(translation=(0, 0, 1.0))], (0, 0, -16.0))
    settled = fc.GroodSuntay.of(tibial.relative_to(femoral.then(np.eye(3), (0, 0, 0.9))), side)
    assert abs(free.column("distraction")[0] - settled.distraction) < 1e-9
    with refused(InputError, "parameters", "'flexion'"):
        joint.follow([fc.Pose()], parameters={"flexion": [1.0]})
    with refused(InputError, "parameters", "'load'"):
        joint.follow([fc.Pose()], parameters={"load": [1.0, 2.0]})


def test_axes_of_opensim_are_forwards_upwards_and_to_the_right():
    joint = fc.Joint(flat().flipped(), flat(), 0.5, fc.Material(E=10.0, nu=0.0), anatomy="opensim", **PAIR)
    # in OpenSim's axes z is to the right, so a turn of the tibia by -a about it, of the femur by +a, is flexion
    turned = fc.Pose(fc.rotation_about((0, 0, 1), np.radians(0.5)), (0.0, 0.0, 0.99))
    assert abs(joint.follow([turned]).column("flexion")[0] - 0.5) < 1e-9
