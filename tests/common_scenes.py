"""Scenes that several files of tests solve."""

import importlib.util
from pathlib import Path

import fecontact as fc

#: A block pressed by a ball, as a scene file.
BALL_ON_BLOCK = """
title = "Block on a ball"
[materials.soft]
E = 1.0
nu = 0.3
[bodies.block]
shape = {kind = "block", size = [1.0, 1.0, 1.0], divisions = [4, 4, 2]}
material = "soft"
contact = "top"
supports = {bottom = "xyz"}
pose = {translation = [-0.5, -0.5, -1.0]}
[bodies.ball]
type = "rigid"
shape = {kind = "sphere", radius = 2.0}
[[contacts]]
slave = "block"
master = "ball"
[loads]
motions.ball = {z = -0.03}
"""

#: A block on a rigid floor, up to its contact; friction and loads are added.
BLOCK_ON_FLOOR = """
[materials.rubber]
E = 1.0
nu = 0.0
[bodies.block]
shape = {kind = "block", size = [1.0, 1.0, 1.0], divisions = [2, 2, 2]}
material = "rubber"
contact = "bottom"
supports = {top = "xyz"}
[bodies.floor]
type = "rigid"
shape = {kind = "plane"}
[[contacts]]
slave = "block"
master = "floor"
"""


def example(name):
    """An example as a module."""
    path = Path(__file__).parents[1] / "examples" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def knee(turn=0.0):
    """The knee of the examples, coarse: condyles on plateaus, coupled by mortar."""
    module = example("knee")
    below = module.tibia(4)
    bone = module.femur(4).placed((0.0, 0.0, module.HEIGHT), rotation=fc.rotation_about((1, 0, 0), turn))
    return fc.Scene([below, bone], [fc.Contact(bone, below)]), bone


def ball_between_blocks():
    """Two elastic bodies of different stiffness; the upper one floats on the other and is pressed by the ball."""
    mesh = fc.shapes.block((2.0, 1.7, 1.0), (3, 3, 2))
    base = fc.ElasticBody(mesh, fc.Material(2.0, 0.3), "top", {"bottom": "xyz"}, name="base")
    sides = {"x_min": "x", "y_min": "y"}
    plate = fc.ElasticBody(mesh, fc.Material(1.0, 0.2), ("bottom", "top"), sides, name="plate")
    plate = plate.placed(translation=(0.0, 0.0, 1.0))
    ball = fc.RigidBody(fc.Sphere(3.0), name="ball").placed(translation=(0.1, 0.05, 5.0))
    contacts = [
        fc.Contact(plate, base, surfaces=("bottom", "top")),
        fc.Contact(plate, ball, surfaces=("top", ball.contact[0])),
    ]
    return base, plate, ball, fc.Scene([base, plate, ball], contacts)
