"""Newton's step of poses beside what further problems of small motions ask for."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.bodies.pose import turned
from fecontact.results.linearisation import driven_motions
from fecontact.scene import turning_steps
from fecontact.scene.carried import posed_scene
from fecontact.scene.turning_steps import newton_step

LOAD = (0.0, 0.0, -40.0)


def patch(radius, half, n):
    """A square part of a sphere, facing up: a bowl of negative radius."""
    x, y = np.meshgrid(*[np.linspace(-half, half, n + 1)] * 2, indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    facets = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    z = np.sign(radius) * (np.sqrt(radius**2 - x**2 - y**2) - abs(radius))
    return fc.SurfaceMesh(np.stack([x, y, z], axis=-1).reshape(-1, 3), np.stack([f.ravel() for f in facets], axis=1))


def ball_in_bowl(swap, n=14):
    """A ball, longer along y, in a bowl."""
    ball = patch(12.0, 6.0, n).mapped(lambda x: x * [1, 1.5, -1]).flipped()
    joint = fc.Joint(ball, patch(-30.0, 10.0, n), 1.0, fc.Material(E=10.0, nu=0.3))
    return fc.Scene(list(joint.bodies), [fc.Contact(*joint.bodies, coupling="mortar", swap=swap)])


def answer(scene, pose, free):
    """Result of small motions in a pose, and the steps (2, 6) by which they move the bodies."""
    now = posed_scene(scene, {scene.bodies[0]: pose}).scene
    ball = now.bodies[0]
    result = fc.Scene(now.bodies, now.contacts).solve(forces={ball: LOAD}, free={ball: free}, finite_motion=False)
    return result, driven_motions(result)


def left_after(scene, pose, step, free):
    """The step that is asked for after another one."""
    return answer(scene, turned(pose, step[0], pose.to_world(scene.bodies[0].reference_point)), free)[1][0]


START = fc.Pose(translation=(0.4, -0.2, 2.0))


# where the points of the contact stay in the bowl, its faces are to be finer
@pytest.mark.parametrize(
    ("swap", "n", "free"), [("never", 14, "x y z"), pytest.param("always", 20, "x z", marks=pytest.mark.full)]
)
def test_it_leads_nearly_to_where_the_motions_settle(swap, n, free):
    scene = ball_in_bowl(swap, n)
    result, plain = answer(scene, START, free)
    ahead = newton_step(result, plain)
    left = [np.linalg.norm(left_after(scene, START, step, free)[:2]) for step in (plain, ahead)]
    assert left[1] < left[0] / 4
    # nothing that is held moves
    assert not ahead[1].any()
    held = [k for k, name in enumerate(("x", "y", "z", "rx", "ry", "rz")) if name not in free.split()]
    assert not ahead[0, held].any()


def test_where_the_next_step_may_be_as_long_steps_stay_as_they_are(monkeypatch):
    scene = ball_in_bowl("never")
    result, plain = answer(scene, START, "x y z")
    assert (newton_step(result, plain) != plain).any()
    monkeypatch.setattr(turning_steps, "LARGEST", 1e-6)
    assert (newton_step(result, plain) == plain).all()
