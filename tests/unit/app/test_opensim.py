"""Models of OpenSim: transforms of joints against products of rotations, functions, units, and ligaments."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
from refusals import refused
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact import InputError
from fecontact.app.joint.opensim_functions import spline

#: A knee as files of version 4 have it: axes in an order of their own, one of them not along an axis, offset frames.
KNEE = """<OpenSimDocument Version="40000"><Model><BodySet/><JointSet><objects>
<CustomJoint name="knee">
 <socket_parent_frame>femur_offset</socket_parent_frame><socket_child_frame>/bodyset/tibia</socket_child_frame>
 <frames><PhysicalOffsetFrame name="femur_offset"><socket_parent>/bodyset/femur</socket_parent>
  <translation>0.01 -0.4 0.02</translation><orientation>0.1 0.2 0.3</orientation></PhysicalOffsetFrame></frames>
 <coordinates><Coordinate name="flex"><default_value>0.5</default_value></Coordinate>
  <Coordinate name="slide"><default_value>0.003</default_value></Coordinate></coordinates>
 <SpatialTransform>
  <TransformAxis name="rotation1"><coordinates>flex</coordinates><axis>0 0 2</axis>
   <LinearFunction><coefficients>-1 0</coefficients></LinearFunction></TransformAxis>
  <TransformAxis name="rotation2"><coordinates>flex</coordinates><axis>1 0 0</axis>
   <PolynomialFunction><coefficients>0.2 0 0.1</coefficients></PolynomialFunction></TransformAxis>
  <TransformAxis name="rotation3"><coordinates/><axis>0 1 0</axis><Constant><value>-0.3</value></Constant>
  </TransformAxis>
  <TransformAxis name="translation1"><coordinates>slide</coordinates><axis>1 0 0</axis>
   <LinearFunction><coefficients>1 0.001</coefficients></LinearFunction></TransformAxis>
  <TransformAxis name="translation2"><coordinates>flex</coordinates><axis>0 1 0</axis>
   <MultiplierFunction><function><PiecewiseLinearFunction><x>-1 0 2</x><y>0 0.01 0.03</y></PiecewiseLinearFunction>
   </function><scale>2</scale></MultiplierFunction></TransformAxis>
  <TransformAxis name="translation3"><coordinates/><axis>0 0 1</axis><Constant><value>0</value></Constant>
  </TransformAxis>
 </SpatialTransform>
</CustomJoint>
<WeldJoint name="graft"><socket_parent_frame>/bodyset/femur</socket_parent_frame><socket_child_frame>bone_frame
 </socket_child_frame><frames><PhysicalOffsetFrame name="bone_frame"><socket_parent>/bodyset/bone</socket_parent>
 <translation>0 0.1 0</translation><orientation>0 0 1.5707963267948966</orientation></PhysicalOffsetFrame></frames>
</WeldJoint>
</objects></JointSet><ForceSet>
<Blankevoort1991Ligament name="ACL"><GeometryPath><PathPointSet><objects>
 <PathPoint><socket_parent_frame>/bodyset/femur</socket_parent_frame><location>0.001 0.002 0.003</location></PathPoint>
 <PathPoint><socket_parent_frame>/bodyset/tibia</socket_parent_frame><location>0.004 0.005 0.006</location></PathPoint>
 </objects></PathPointSet></GeometryPath><linear_stiffness>800</linear_stiffness><slack_length>0.03</slack_length>
</Blankevoort1991Ligament>
<Blankevoort1991Ligament name="MCL"><GeometryPath><PathPointSet><objects>
 <PathPoint><socket_parent_frame>/bodyset/tibia</socket_parent_frame><location>0 0 0</location></PathPoint>
 <PathPoint><socket_parent_frame>/bodyset/femur</socket_parent_frame><location>0 0.1 0</location></PathPoint>
 </objects></PathPointSet><PathWrapSet><objects><PathWrap><wrap_object>condyle</wrap_object></PathWrap></objects>
 </PathWrapSet></GeometryPath><linear_stiffness>500</linear_stiffness><slack_length>0.09</slack_length>
 <transition_strain>0.03</transition_strain></Blankevoort1991Ligament>
</ForceSet></Model></OpenSimDocument>"""


def read(tmp_path, text=KNEE):
    path = tmp_path / "leg.osim"
    path.write_text(text, encoding="utf-8")
    return fc.read_osim(path)


def motion(in_degrees=False, **columns):
    values = np.stack([np.atleast_1d(np.asarray(v, float)) for v in columns.values()], axis=1)
    return fc.Motion(np.arange(len(values), dtype=float), tuple(columns), values, in_degrees)


def matrix(rotation, translation):
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation.as_matrix(), translation
    return out


def expected(flex, slide):
    """The tibia in the femur's axes by products of matrices, in metres."""
    offset = matrix(Rotation.from_euler("XYZ", [0.1, 0.2, 0.3]), [0.01, -0.4, 0.02])
    lift = 2 * np.interp(flex, [-1, 0, 2], [0, 0.01, 0.03])
    return offset @ matrix(Rotation.from_euler("ZXY", [-flex, 0.2 * flex**2 + 0.1, -0.3]), [slide + 0.001, lift, 0.0])


def test_a_joint_is_the_product_of_its_turns_and_translations(tmp_path):
    model = read(tmp_path)
    flex, slide = np.array([0.0, 0.7, 1.9]), np.array([0.0, 0.002, -0.004])
    for k, pose in enumerate(model.poses("tibia", "femur", motion(flex=flex, slide=slide), scale=1000.0)):
        exact = expected(flex[k], slide[k])
        assert np.abs(pose.rotation - exact[:3, :3]).max() < 1e-14
        assert np.abs(pose.translation - 1000 * exact[:3, 3]).max() < 1e-10
    # the other way round, and between bodies that two joints tie
    (back,) = model.poses("femur", "tibia", None, scale=1.0)
    assert np.abs(np.linalg.inv(expected(0.5, 0.003))[:3, 3] - back.translation).max() < 1e-15
    (far,) = model.poses("bone", "tibia", None, scale=1.0)
    weld = np.linalg.inv(matrix(Rotation.from_euler("XYZ", [0, 0, np.pi / 2]), [0, 0.1, 0]))
    found = matrix(Rotation.from_matrix(far.rotation), far.translation)
    assert np.abs(np.linalg.inv(expected(0.5, 0.003)) @ weld - found).max() < 1e-14
    (self,) = model.poses("tibia", "tibia", None, scale=1.0)
    assert np.array_equal(self.rotation, np.eye(3))


def test_degrees_are_of_angles_alone_and_states_have_paths_for_names(tmp_path):
    model = read(tmp_path)
    assert (model.coordinates["flex"].is_angle, model.coordinates["slide"].is_angle) == (True, False)
    radians = model.poses("tibia", "femur", motion(flex=0.7, slide=0.002), scale=1.0)[0]
    paths = {"/jointset/knee/flex/value": np.degrees(0.7), "/jointset/knee/slide/value": 0.002, "/knee/flex/speed": 9.0}
    degrees = model.poses("tibia", "femur", motion(in_degrees=True, **paths), scale=1.0)[0]
    assert np.abs(radians.rotation - degrees.rotation).max() < 1e-14
    assert np.abs(radians.translation - degrees.translation).max() < 1e-15
    with refused(InputError, "missing-coordinate", "coordinates slide,"):
        model.poses("tibia", "femur", motion(flex=0.0), scale=1.0)
    with refused(InputError, "unknown-name", "'thigh'"):
        model.poses("tibia", "thigh", None, scale=1.0)
    # a slope other than one: OpenSim calls such a coordinate coupled, and its unit is not told
    coupled = read(tmp_path, KNEE.replace("-1 0</coefficients>", "-2 0</coefficients>"))
    coupled.poses("tibia", "femur", motion(flex=0.7, slide=0.002), scale=1.0)
    with refused(InputError, "unknown-unit", "'flex'"):
        coupled.poses("tibia", "femur", motion(in_degrees=True, flex=40.0, slide=0.002), scale=1.0)


def test_a_file_of_version_2_says_the_same_with_its_older_names(tmp_path):
    x, y = [-2.0, -1.0, -0.3, 0.0, 0.2], [0.0, 0.004, 0.002, -0.005, -0.0055]
    part = (
        "<TransformAxis name='{}'><function>{}</function><coordinates>{}</coordinates><axis>{}</axis></TransformAxis>"
    )
    none = "<Constant><value>0</value></Constant>"
    line = "<LinearFunction><coefficients>1 0</coefficients></LinearFunction>"
    curve = "<NaturalCubicSpline><x>{}</x><y>{}</y></NaturalCubicSpline>".format(
        *(" ".join(map(str, v)) for v in (x, y))
    )
    parts = [("rotation1", line, "knee", "0 0 1"), ("rotation2", none, "", "0 1 0"), ("rotation3", none, "", "1 0 0")]
    parts += [("translation1", curve, "knee", "1 0 0"), ("translation2", none, "", "0 1 0")]
    parts += [("translation3", none, "", "0 0 1")]
    text = f"""<OpenSimDocument Version="20302"><Model><BodySet><objects><Body name="tibia_r"><Joint>
    <CustomJoint name="k"><parent_body> femur_r </parent_body><location_in_parent>0 -0.4 0</location_in_parent>
    <orientation_in_parent>0 0 0.1</orientation_in_parent><location>0 0.02 0</location><orientation>0 0 0</orientation>
    <CoordinateSet><objects><Coordinate name="knee"><motion_type> rotational </motion_type></Coordinate></objects>
    </CoordinateSet><SpatialTransform>{"".join(part.format(*p) for p in parts)}</SpatialTransform>
    </CustomJoint></Joint></Body></objects></BodySet></Model></OpenSimDocument>"""
    angle = -0.6
    pose = read(tmp_path, text).poses("tibia_r", "femur_r", motion(True, knee=np.degrees(angle)), scale=1.0)[0]
    shift = float(spline(np.array(x), np.array(y))(np.array(angle)))
    exact = matrix(Rotation.from_rotvec([0, 0, 0.1]), [0, -0.4, 0]) @ matrix(
        Rotation.from_rotvec([0, 0, angle]), [shift, 0, 0]
    )
    exact = exact @ matrix(Rotation.identity(), [0, -0.02, 0])
    assert np.abs(pose.rotation - exact[:3, :3]).max() < 1e-14
    assert np.abs(pose.translation - exact[:3, 3]).max() < 1e-15


def test_the_spline_is_the_one_of_forsythe_malcolm_and_moler():
    x, y = np.array([0.0, 0.5, 1.7, 2.0, 3.1, 4.0]), np.array([1.0, -0.4, 0.3, 2.0, 1.1, 0.0])
    found = spline(x, y)
    # scipy's cubic spline with the same slopes at the ends is the same curve: continuous second derivatives
    same = CubicSpline(x, y, bc_type=((1, found.slopes[0]), (1, found.slopes[1])))
    t = np.linspace(0, 4, 50)
    assert np.abs(found(t) - same(t)).max() < 1e-13
    # third derivatives at the ends: those of the cubics through four points
    for piece, four in ((0, slice(0, 4)), (-1, slice(2, 6))):
        assert abs(same.c[0, piece] - np.polyfit(x[four], y[four], 3)[0]) < 1e-12
    assert abs(found(np.array([5.0]))[0] - (y[-1] + found.slopes[1])) < 1e-14
    assert np.abs(spline(x[:2], y[:2])(t) - (1.0 - 2.8 * t)).max() < 1e-14


def test_ligaments_have_their_units_and_those_that_wrap_are_asked_for(tmp_path):
    model = read(tmp_path)
    with refused(fc.InputError, "wraps", "MCL"):
        model.ligaments("femur", "tibia", scale=1000.0)
    (acl,) = model.ligaments("femur", "tibia", scale=1000.0, straight=False)
    assert acl == fc.Ligament("ACL", (1.0, 2.0, 3.0), (4.0, 5.0, 6.0), 800.0, 30.0, 0.06)
    both = model.ligaments("femur", "tibia", scale=1000.0, straight=True)
    assert both[1] == fc.Ligament("MCL", (0.0, 100.0, 0.0), (0.0, 0.0, 0.0), 500.0, 90.0, 0.03)
    assert model.ligaments("femur", "bone", scale=1000.0) == []
    # points of both bones lead it, from the moving bone on; those of others are asked for
    start, end = model.paths["ACL"].points
    bent = replace(model.paths["ACL"], points=[start, ("tibia", np.array([0.0, 0.0, 0.01])), end])
    (led,) = replace(model, paths={"ACL": bent}).ligaments("femur", "tibia", scale=1000.0)
    assert led == replace(acl, via=[("fixed", (0.0, 0.0, 10.0))])
    (led,) = replace(model, paths={"ACL": bent}).ligaments("tibia", "femur", scale=1.0)
    assert led.via == [("moving", (0.0, 0.0, 0.01))]
    away = replace(bent, points=[start, ("patella", np.zeros(3)), end])
    with refused(fc.InputError, "wraps", "ACL"):
        replace(model, paths={"ACL": away}).ligaments("femur", "tibia", scale=1000.0)
    with refused(fc.InputError, "wraps", "ACL"):
        replace(model, paths={"ACL": replace(bent, others=["MovingPathPoint"])}).ligaments("femur", "tibia", scale=1.0)


WRAPS = """<BodySet><objects><Body name="femur"><WrapObjectSet><objects><WrapCylinder name="condyle">
 <xyz_body_rotation>1.5707963267948966 0 0</xyz_body_rotation><translation>0.001 0 0.002</translation>
 <quadrant>all</quadrant><radius>0.02</radius><length>0.5</length></WrapCylinder></objects></WrapObjectSet></Body>
</objects></BodySet>"""


MESH = """<Smith2018ContactMesh name="{0}"><socket_frame>/bodyset/{0}</socket_frame><mesh_file>{0}.stl</mesh_file>
 <elastic_modulus>5000000</elastic_modulus><poissons_ratio>0.45</poissons_ratio><thickness>0.003</thickness>
 <use_variable_thickness>{1}</use_variable_thickness><mesh_back_file>{0}_back.stl</mesh_back_file>
 <min_thickness>0.001</min_thickness><location>0 0 {2}</location></Smith2018ContactMesh></Model>"""


def square(path, height, up=True):
    """A square of 10 mm at a height (mm), in metres."""
    points = np.array([[0, 0, height], [10, 0, height], [10, 10, height], [0, 10, height]]) / 1000.0
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    meshio.Mesh(points, [("triangle", triangles if up else triangles[:, ::-1])]).write(path)


def test_contact_meshes_of_jam_are_a_joint(tmp_path):
    square(tmp_path / "shin.stl", 2.0)
    square(tmp_path / "shin_back.stl", 1.5)  # 0.5 mm under it: less than the least of 1 mm
    square(tmp_path / "thigh.stl", 0.0, up=False)
    text = KNEE.replace("</Model>", MESH.format("shin", "true", 0)).replace(
        "</Model>", MESH.format("thigh", "false", 0)
    )
    model = read(tmp_path, text)
    joint = model.joint("thigh", "shin", tmp_path, scale=1000.0, units=("mm", "N", "MPa"))
    assert joint.foundation
    assert joint.names == ("thigh", "shin")
    table = joint.follow([fc.Pose(translation=(0.0, 0.0, 2.0 - 0.04))])
    # 0.04 mm on 3 + 1 mm, and the modulus of a layer that cannot strain sideways: pascals are 1e-6 N/mm^2
    modulus = 5.0 * 0.55 / (1.45 * 0.1)
    assert table.column("max_pressure") == pytest.approx([modulus * 0.04 / 4.0], rel=1e-9)
    # files whose axes are turned
    half = Rotation.from_rotvec([0, 0, np.pi]).as_matrix()
    turned = model.joint("thigh", "shin", tmp_path, scale=1000.0, turned=half)
    assert turned.fixed.points[:, :2].max() < 1e-9
    with refused(fc.InputError, "unknown-name", "contact mesh"):
        model.joint("thigh", "knee", tmp_path, scale=1000.0)
    with refused(fc.InputError, "not-supported", "shin"):
        read(tmp_path, KNEE.replace("</Model>", MESH.format("shin", "true", 1)))


def test_a_ligament_wraps_round_a_cylinder_of_a_bone(tmp_path):
    text = KNEE.replace("<BodySet/>", WRAPS)
    _, mcl = read(tmp_path, text).ligaments("femur", "tibia", scale=1000.0)
    bone, cylinder = mcl.around
    assert (bone, cylinder.radius, cylinder.length) == ("moving", 20.0, 500.0)
    assert np.allclose(cylinder.centre, (1.0, 0.0, 2.0))
    assert np.allclose(cylinder.axis, (0.0, -1.0, 0.0))  # z turned about x by a right angle
    for old, new in (
        ("<quadrant>all", "<quadrant>+x"),
        ("WrapCylinder", "WrapEllipsoid"),
        ("</wrap_object>", "</wrap_object><range>1 2</range>"),
        ('<Body name="femur">', '<Body name="patella">'),
    ):
        with refused(fc.InputError, "wraps", "MCL"):
            read(tmp_path, text.replace(old, new)).ligaments("femur", "tibia", scale=1000.0)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("CustomJoint", "BallJoint", ("not-supported", "'knee'", "BallJoint")),
        ("PolynomialFunction", "GCVSpline", ("unknown-function", "rotation2", "GCVSpline")),
        ("<x>-1 0 2</x>", "<x>0 -1 2</x>", ("input", "translation2", "growing x")),
        ("<axis>1 0 0</axis>", "<axis>0 0 0</axis>", ("not-supported", "rotation2")),
        ("<axis>1 0 0</axis>", "<axis>1 0</axis>", ("bad-value", "'knee'", "expected 3 numbers")),
        ("<coordinates>flex</coordinates>", "<coordinates>flex slide</coordinates>", ("not-supported", "rotation1")),
        ("rotation3", "rotation4", ("missing-element", "'rotation3'")),
        ("<LinearFunction><coefficients>-1 0</coefficients></LinearFunction>", "", ("missing-element", "no function")),
        ("<SpatialTransform>", "<reverse>true</reverse><SpatialTransform>", ("not-supported", "reversed")),
        ("<socket_child_frame>/bodyset/tibia</socket_child_frame>", "", ("bad-value", "'knee'")),
        ("</Model>", "", ("no-osim",)),
    ],
)
def test_what_is_not_known_is_refused_with_its_joint(tmp_path, old, new, told):
    assert old in KNEE
    with refused(InputError, *told):
        read(tmp_path, KNEE.replace(old, new))


def test_files_that_are_no_models_are_refused(tmp_path):
    with refused(InputError, "unreadable"):
        fc.read_osim(tmp_path / "none.osim")
    with refused(InputError, "no-osim", "no joints"):
        read(tmp_path, "<OpenSimDocument/>")
    circle = KNEE.replace("/bodyset/femur<", "/bodyset/tibia<", 1)
    with refused(InputError, "joint-loop"):
        read(tmp_path, circle).poses("tibia", "bone", None, scale=1.0)
    apart = KNEE.replace("<socket_parent_frame>/bodyset/femur<", "<socket_parent_frame>/bodyset/pelvis<", 1)
    with refused(InputError, "not-joined", "'femur'"):
        read(tmp_path, apart).poses("tibia", "bone", None, scale=1.0)


HEAD = "name, x1, y1, z1, x2, y2, z2, stiffness, slack_length, toe\n"


def test_a_table_of_ligaments(tmp_path, written):
    path = written(HEAD + "ACL, 1, 2, 3, 4, 5, 6, 800, 30, 0.06\nLCL, 1, 2, 3, 4, 5, 7, 600, 50, 0\n", "knee.csv")
    acl, lcl = fc.read_ligaments(path)
    assert acl == fc.Ligament("ACL", (1, 2, 3), (4, 5, 6), 800, 30)
    assert lcl.toe == 0
    for text, told in (
        (HEAD.replace("x2", "u2") + "ACL" + ",1" * 9, ("columns", "u2, x2")),
        (HEAD + "ACL" + ",1" * 8 + ",soft", ("numbers", "line 2")),
        (HEAD + "ACL" + ",1" * 6, ("numbers", "line 2")),
        (HEAD + "ACL" + ",1" * 7 + ",0,0", ("not-positive", "slack length")),
    ):
        path.write_text(text, encoding="utf-8")
        with refused(InputError, *told):
            fc.read_ligaments(path)
    with refused(InputError, "unreadable"):
        fc.read_ligaments(tmp_path)
