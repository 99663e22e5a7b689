"""A body that slides to its rest is followed in the same steps in every frame and unit."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import fecontact as fc

FRAMES = ({"angle": 1.1}, {"length": 1e3, "modulus": 2e5})


def pressed_by_a_cone(angle=0.0, length=1.0, modulus=1.0):
    """A block on a plane of symmetry, pushed aside by a cone that a force presses on its top."""
    turn = Rotation.from_rotvec((0.0, 0.0, angle)).as_matrix()
    size = np.array([1.074, 0.803, 0.455])
    mesh = fc.shapes.block(tuple(length * size), (5, 2, 2))
    block = fc.ElasticBody(mesh, fc.Material(modulus, 0.0), contact="top", supports={"bottom": "z"}, name="block")
    at = turn @ (length * np.array([0.2046, 0.1666, 0.4638]))
    cone = fc.RigidBody(fc.surfaces.Cone(0.5807), pose=fc.Pose(translation=tuple(at), rotation=turn), name="cone")
    block = block.placed(rotation=turn)
    force = turn @ np.array([0.0014565, 0.0, -0.014565]) * modulus * length**2
    return fc.Scene([block, cone], [fc.Contact(block, cone)]).solve({cone: force})


def figures(result, length=1.0, modulus=1.0):
    (contact,) = result.contacts
    force, peak = np.linalg.norm(contact.force) / (modulus * length**2), contact.max_pressure / modulus
    return np.array([force, peak, contact.area / length**2])


def test_the_rest_is_the_same_in_every_frame_and_unit():
    """Peaks were 7 to 37 % apart: steps were measured by components, and by the size 1 of a cone in any unit."""
    found = figures(pressed_by_a_cone())
    for frame in FRAMES:
        units = {name: value for name, value in frame.items() if name != "angle"}
        assert np.abs(figures(pressed_by_a_cone(**frame), **units) / found - 1).max() < 1e-6


@pytest.mark.parametrize("size", [1.0, 7.0])
def test_rigid_shapes_take_the_size_of_the_largest_other(size):
    block = fc.ElasticBody(fc.shapes.block((2.0, 2.0, 1.0), (1, 1, 1)), fc.Material(1.0, 0.3), "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane(size))
    assert fc.Scene([block, floor], [fc.Contact(block, floor)]).sizes.tolist() == [block.size, block.size]
    ball = fc.RigidBody(fc.Sphere(3.0)).placed((0.0, 0.0, 0.0))
    assert fc.Scene([ball, floor], [fc.Contact(ball, floor)]).sizes.tolist() == [max(6.0, size)] * 2
