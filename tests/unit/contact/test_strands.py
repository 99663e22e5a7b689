"""Ligaments that are led through points or round a cylinder, beside the shortest way and work."""

import numpy as np
import pytest
from refusals import refused
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact.bodies.pose import Pose
from fecontact.contact.springs import spring_rows
from fecontact.scene.carried import posed_scene

RNG = np.random.default_rng(7)
R = 2.0


def cylinder(length=np.inf):
    return fc.WrapCylinder((0.3, -0.2, 0.1), (0.2, 0.1, 1.0), R, length)


def frame(given):
    """Axes (3, 3) as columns, the last one the cylinder's."""
    axis = np.asarray(given.axis) / np.linalg.norm(given.axis)
    first = np.linalg.svd(axis[None])[2][1]
    return np.stack([first, np.cross(axis, first), axis], axis=1)


def shortest(given, start, end):
    """Least length of a line, a helix and a line that do not enter the cylinder, by numerical minimisation."""
    Q = frame(given)
    ends = [(p - given.centre) @ Q for p in (start, end)]

    def touching(x):
        return [(np.array([np.cos(a), np.sin(a), 0.0]), z) for a, z in x.reshape(2, 2)]

    def length(x):
        at = [given.radius * n + [0, 0, z] for n, z in touching(x)]
        helix = np.hypot(given.radius * (x[2] - x[0]), x[3] - x[1])
        return helix + sum(np.linalg.norm(p - q) for p, q in zip(ends, at, strict=True))

    def seen(x):
        return [n @ p - given.radius for p, (n, _) in zip(ends, touching(x), strict=True)]

    angles = np.unwrap([np.arctan2(p[1], p[0]) for p in ends])
    begin = np.array([[0.9 * angles[0] + 0.1 * angles[1], ends[0][2]], [0.1 * angles[0] + 0.9 * angles[1], ends[1][2]]])
    options = {"ftol": 1e-14, "maxiter": 500}
    found = minimize(length, begin.ravel(), method="SLSQP", constraints={"type": "ineq", "fun": seen}, options=options)
    return found.fun


def outside(given):
    """Two points on opposite sides of the cylinder, at different heights."""
    Q, angle = frame(given), RNG.uniform(0, 2 * np.pi)
    ends = []
    for turn in (0.0, RNG.uniform(2.3, 3.0)):
        r = R * RNG.uniform(1.1, 3.0)
        ends.append(Q @ [r * np.cos(angle + turn), r * np.sin(angle + turn), RNG.uniform(-3, 3)] + given.centre)
    return ends


def test_the_way_round_a_cylinder_is_the_shortest_one():
    given = cylinder()
    for _ in range(5):
        start, end = outside(given)
        spring = fc.Spring(1.0, (fc.RigidBody(fc.Plane()), start), (None, end), around=(None, given))
        touching = np.stack([spring.strands[0].ends[1], spring.strands[1].ends[0]])
        # the minimisation ends at a length that changes by 1e-14, within its constraints to their root
        assert abs(shortest(given, start, end) / spring.length - 1) < 1e-7
        # straight parts are tangents, and the slope along the axis goes on
        axis = frame(given)[:, 2]
        for strand, point in zip(spring.strands, touching, strict=True):
            off = point - given.centre - ((point - given.centre) @ axis) * axis
            assert abs(np.linalg.norm(off) - R) < 1e-13
            assert abs(strand.direction @ off) < 1e-13
        assert abs((spring.strands[0].direction - spring.strands[1].direction) @ axis) < 1e-13


def test_a_quarter_of_a_circle_by_hand():
    given = fc.WrapCylinder((0, 0, 0), (0, 0, 5.0), 1.0)
    ground = fc.RigidBody(fc.Plane())
    flat = fc.Spring(1.0, (ground, (-3.0, 1.0, 0)), (None, (1.0, -0.25, 0)), around=(None, given))
    assert abs(flat.length - (3.25 + np.pi / 2)) < 1e-14
    # unrolled, 4 along the axis
    steep = fc.Spring(1.0, (ground, (-3.0, 1.0, 0)), (None, (1.0, -0.25, 4.0)), around=(None, given))
    assert abs(steep.length - np.hypot(3.25 + np.pi / 2, 4)) < 1e-14
    # the straight way passes by
    aside = fc.Spring(1.0, (ground, (-3.0, 1.0, 0)), (None, (3.0, 1.0 + 1e-9, 1.0)), around=(None, given))
    assert abs(aside.length - np.hypot(6, 1)) < 1e-9
    assert len(aside.strands) == 1


def block_held_at(face, pressed):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    return fc.ElasticBody(mesh, fc.Material(E=1e3, nu=0.0), pressed, {face: "xyz"}, name="block")


@pytest.mark.parametrize("carrier", ["ground", "ball"])
@pytest.mark.parametrize("how", ["around", "via"])
def test_its_moment_arms_are_the_changes_of_its_length(how, carrier):
    pose = Pose(Rotation.from_rotvec([0.1, -0.2, 0.3]).as_matrix(), (0.5, 0.5, 2.0))
    ball = fc.RigidBody(fc.Sphere(1.0), name="ball").placed(pose.translation, rotation=pose.rotation)
    block, on = block_held_at("bottom", "top"), None if carrier == "ground" else ball
    given = fc.WrapCylinder((0.2, 0.0, 0.1 if on else 3.0), (0.1, 1.0, 0.0), 0.6)
    through = [(on, (0.9, 0.1, 0.8 if on else 3.0)), (None, (1.5, 0.4, 3.4))]
    led = {"around": (on, given)} if how == "around" else {"via": through}
    spring = fc.Spring(1.0, (ball, (-1.1, 0.3, 0.4)), (None, (2.0, 0.3, 3.5 if on is None else 2.0)), **led)
    assert len(spring.strands) == (2 if how == "around" else 3)
    scene = fc.Scene([ball, block], [fc.Contact(ball, block)], [spring])
    (row,) = spring_rows(scene.springs).rows(ball).toarray() @ np.kron(np.eye(2), ball.pose.rotation.T)

    def length(motion):
        turn = Rotation.from_rotvec(motion[3:]).as_matrix()
        moved = Pose(turn @ pose.rotation, pose.translation + motion[:3])
        (now,) = posed_scene(scene, {ball: moved}).scene.springs
        return now.length

    h = 1e-5
    for k, unit in enumerate(np.eye(6)):
        slope = (length(h * unit) - length(-h * unit)) / (2 * h)
        assert abs(slope + row[k]) < 1e-8  # rows are of shortening


def test_a_ligament_over_a_fixed_pulley_pulls_by_its_stretch():
    # the strand beside the pulley of radius 1 is vertical, whatever the one beyond it is
    block, floor = block_held_at("top", "bottom"), fc.RigidBody(fc.Plane(), name="floor")
    pulley = fc.WrapCylinder((1.5, 0.5, 5.0), (0.0, 1.0, 0.0), 1.0)
    spring = fc.Spring(10.0, (block, (0.5, 0.5, 1.0)), (None, (2.4, 0.5, 9.0)), around=(None, pulley))
    assert np.allclose(spring.strands[0].ends[1], (0.5, 0.5, 5.0), rtol=0, atol=1e-14)
    scene = fc.Scene([block, floor], [fc.Contact(block, floor)], [spring])
    assert scene.solve(motions={block: {"z": -0.001}}).springs[0].tension == pytest.approx(0.01, rel=1e-9)
    assert scene.solve(motions={block: {"z": 0.001}}).springs[0].tension == 0


def test_what_cannot_be_led_is_refused():
    ball = fc.RigidBody(fc.Sphere(1.0))
    ends = (ball, (0, 0, 2.0)), (None, (0, 0, 6.0))
    with refused(fc.InputError, "inside-cylinder"):
        fc.Spring(1.0, *ends, around=(None, fc.WrapCylinder((0, 0, 6.0), (1, 0, 0), 1.0)))
    opposite = fc.WrapCylinder((0, 0, 4.0), (1, 0, 0), 1.0)
    with refused(fc.InputError, "two-ways"):
        fc.Spring(1.0, *ends, around=(None, opposite))
    # a little to one side, it is led on that side
    beside = fc.Spring(1.0, (ball, (0, 1e-6, 2.0)), (None, (0, 0, 6.0)), around=(None, opposite))
    assert len(beside.strands) == 2
    assert beside.strands[0].ends[1][1] > 0.8
    with refused(fc.InputError, "beyond-cylinder"):
        fc.Spring(1.0, *ends, around=(None, fc.WrapCylinder((5.0, 0.1, 5.0), (1, 0, 0), 0.5, length=8.0)))
    assert fc.Spring(1.0, *ends, around=(None, fc.WrapCylinder((5.0, 0.1, 5.0), (1, 0, 0), 0.5, length=10.1))).strands
    with refused(fc.InputError, "led"):
        fc.Spring(1.0, *ends, kind="linear", via=[(None, (0, 1.0, 5.0))])
    with refused(fc.InputError, "led"):
        fc.Spring(1.0, *ends, via=[(None, (0, 1.0, 5.0))], around=(None, cylinder()))
    with refused(fc.InputError, "no-axis"):
        fc.WrapCylinder((0, 0, 0), (0, 0, 0), 1.0)
    with refused(fc.InputError, "not-positive"):
        fc.WrapCylinder((0, 0, 0), (0, 0, 1), 1.0, length=0.0)
    assert [len(s.ends) for s in fc.Spring(1.0, *ends, via=[(None, (0, 1.0, 5.0))]).strands] == [2, 2]
