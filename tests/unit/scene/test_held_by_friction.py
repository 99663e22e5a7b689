"""A block that stands on a plane of symmetry and is held along it by the friction of what is pressed on it alone."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import fecontact as fc

FRAMES = ({"angle": 1.1}, {"angle": -2.0}, {"length": 1e3, "modulus": 2e5})


def pressed(size, cells, nu, radius, at, depth, held="z", angle=0.0, length=1.0, modulus=1.0, mu=0.8):
    """A ball pushed into the top of a block, with friction: written in other units, turned about z."""
    turn = Rotation.from_rotvec((0.0, 0.0, angle)).as_matrix()
    mesh = fc.shapes.block(tuple(length * np.array(size)), cells, element="hex20")
    block = fc.ElasticBody(mesh, fc.Material(modulus, nu), contact="top", supports={"bottom": held}, name="block")
    pose = fc.Pose(translation=tuple(turn @ (length * np.array([*at, size[2]]))), rotation=turn)
    ball = fc.RigidBody(fc.Sphere(radius * length), pose=pose, name="ball")
    block = block.placed(rotation=turn)
    scene = fc.Scene([block, ball], [fc.Contact(block, ball, friction=mu)])
    return scene.solve(motions={ball: {"z": -depth * length}})


def figures(result, length=1.0, modulus=1.0):
    (contact,) = result.contacts
    force, peak = np.linalg.norm(contact.force) / (modulus * length**2), contact.max_pressure / modulus
    return np.array([force, peak, contact.area / length**2])


@pytest.mark.parametrize(
    "scene",
    [
        ((1.902, 0.346, 2.152), (4, 3, 4), 0.0, 4.447, (1.4557, 0.1173), 0.000381),
        ((1.002, 0.607, 1.775), (4, 4, 3), 0.0, 4.5085, (0.222, 0.4462), 0.009842),
        ((1.522, 1.663, 0.379), (3, 5, 3), 0.3, 0.75626, (0.00307, 0.052), 0.005664),
    ],
)
def test_friction_alone_holds_it_in_every_frame_and_unit(scene):
    """Without friction the ball pushes it aside until nothing touches: an answer that began there stayed there."""
    result = pressed(*scene)
    found = figures(result)
    # it bears less than the block whose bottom is held all round, and moves by about the depth of the ball
    assert 0.5 < found[0] / figures(pressed(*scene, held="xyz"))[0] < 1
    assert np.linalg.norm(result._motions[0][:3]) < 5 * scene[-1]
    for frame in FRAMES:
        units = {name: value for name, value in frame.items() if name != "angle"}
        assert np.abs(figures(pressed(*scene, **frame), **units) / found - 1).max() < 1e-8


def test_its_certificate_is_that_of_the_problem_with_friction():
    """The rows of its motions hold tangential forces: of the normal ones alone it was rounding over zero, infinite."""
    lower, upper = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 1)), fc.shapes.block((0.5, 0.6, 0.3), (1, 2, 1))
    block = fc.ElasticBody(lower, fc.Material(1.0, 0.3), contact="top", supports={"bottom": "z"}, name="block")
    stamp = fc.ElasticBody(upper, fc.Material(2.0, 0.3), contact="bottom", supports={"top": "xyz"}, name="stamp")
    stamp = stamp.placed((0.2, 0.3, 1.0))
    scene = fc.Scene([block, stamp], [fc.Contact(block, stamp, friction=0.8)])
    result = scene.solve(motions={stamp: {"z": -0.01}})
    assert result.residuals().worst < 1e-10
    assert "inf" not in str(result)


ASIDE = ((1.902, 0.346, 2.152), (4, 3, 4), 0.0, 4.447, (1.4557, 0.1173))


@pytest.mark.parametrize(
    ("change", "aside"),
    [({"mu": 0.0}, True), ({}, False), ({"mu": 0.0, "held": "xyz"}, False), ({"mu": 0.0, "depth": -0.01}, False)],
)
def test_a_body_pushed_aside_is_told(change, aside):
    """Without friction the ball pushes the block away; held, or never touched, it stays."""
    result = pressed(*ASIDE, **{"depth": 0.000381, **change})
    told = [text for text in result.warnings if text.startswith("Nothing touches any more: 'block' was pushed aside")]
    assert bool(told) is aside
    if aside:
        assert not result.contacts[0].active.any()


def test_the_rest_without_a_turn_is_found_before_one_that_drifted():
    """A leaning cone pressed on a block that may turn: stuck at one node, nothing resists a turn about it.

    Newton's method from the first guess ends at another node, with a turn of 1.3 rad: its least turn, 1.1, is that at
    which the block would touch the cone elsewhere.
    """
    mesh = fc.shapes.block((0.494, 2.874, 2.211), (4, 4, 1), element="hex8")
    block = fc.ElasticBody(mesh, fc.Material(1.0, 0.0), contact="top", supports={"bottom": "z"}, name="block")
    lean = Rotation.from_rotvec((0.08565, 0.03693, -0.00392)).as_matrix()
    cone = fc.RigidBody(fc.surfaces.Cone(0.66095), pose=fc.Pose(lean, (0.27415, 0.15373, 2.25546)), name="cone")
    scene = fc.Scene([block, cone], [fc.Contact(block, cone, friction=0.8)])
    result = scene.solve(forces={cone: (0.0, 0.0, -0.02569)})
    assert result.friction.touching.sum() == 1
    assert np.linalg.norm(result._motions[0][3:]) < 0.1
    np.testing.assert_allclose(result.contacts[0].force, (0.0, 0.0, -0.02569), atol=1e-9)
