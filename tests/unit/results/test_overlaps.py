"""Bodies that overlap without a contact between them are named with the depth; those that only touch are not."""

import numpy as np
import pytest

import fecontact as fc

SOLID = fc.Material(E=1000.0, nu=0.3)


def overlaps(result):
    return [w for w in result.warnings if "no contact between them was declared" in w]


def said(text):
    return float(text.split("overlap by ")[1].split()[0])


def block(name, size=(4.0, 4.0, 1.0), cells=(4, 4, 1), contact=("top",), held="bottom"):
    return fc.ElasticBody(fc.shapes.block(size, cells), SOLID, contact, {held: "xyz"}, name=name)


def balls_on_a_block(distance, contact=False, scale=1.0, finite="auto"):
    """Two rigid balls of radius 1 on one block, their centres that far apart, pressed down by 0.01."""
    mesh = fc.shapes.block((4.0, 4.0, 1.0), (8, 8, 2)).scaled(scale)
    base = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}, name="block")
    balls = [
        fc.RigidBody(fc.Sphere(scale), name=n).placed((scale * (2 + side * distance / 2), 2 * scale, scale))
        for n, side in (("left", -1), ("right", 1))
    ]
    contacts = [fc.Contact(base, ball) for ball in balls]
    scene = fc.Scene([base, *balls], contacts)
    return scene.solve(motions={ball: {"z": -0.01 * scale} for ball in balls}, finite_motion=finite)


@pytest.mark.parametrize("scale", [1.0, 1e-3])
@pytest.mark.parametrize("finite", ["auto", True, False])
def test_rigid_balls_inside_one_another_are_named_with_the_depth(scale, finite):
    """Source: geometry. Balls whose centres are d apart overlap by 2 R - d."""
    (text,) = overlaps(balls_on_a_block(0.25, scale=scale, finite=finite))
    assert "'left' and 'right'" in text
    assert abs(said(text) / (1.75 * scale) - 1) < 1e-3  # four digits are said


@pytest.mark.parametrize("distance", [2.0, 2.5])
def test_balls_beside_one_another_are_not(distance):
    assert overlaps(balls_on_a_block(distance)) == []


def stacked(depth, declared=False):
    """A block in contact with a floor, and a second one that stands in it that deep."""
    lower = block("lower", contact=("top", "bottom"), held="x_min")
    upper = block("upper", (1.0, 1.0, 1.0), (2, 2, 2), ("bottom",), "top").placed((1.5, 1.5, 1.0 - depth))
    floor = fc.RigidBody(fc.Plane(), name="floor")
    contacts = [fc.Contact(lower, floor, surfaces=("bottom", "surface"))]
    if declared:
        contacts.append(fc.Contact(upper, lower, surfaces=("bottom", "top")))
    return fc.Scene([lower, upper, floor], contacts).solve()


def test_elastic_blocks_that_overlap_are_named_with_the_depth():
    """Source: geometry."""
    (text,) = overlaps(stacked(0.05))
    assert "'lower' and 'upper'" in text
    assert abs(said(text) - 0.05) < 1e-4
    assert overlaps(stacked(0.05, declared=True)) == []


def test_faces_that_touch_are_not():
    assert overlaps(stacked(0.0)) == []
    assert overlaps(stacked(1e-9)) == []


def test_an_elastic_block_in_a_rigid_floor_or_ball():
    """Source: geometry; the block's lowest nodes, and a ball within a face of it."""
    lower = block("lower")
    upper = block("upper", (1.0, 1.0, 1.0), (2, 2, 2), ("bottom",), "top").placed((1.5, 1.5, 1.0))
    contact = fc.Contact(upper, lower)
    floor = fc.RigidBody(fc.Plane(), name="floor").placed((0, 0, 0.02))
    (text,) = overlaps(fc.Scene([lower, upper, floor], [contact]).solve(motions={upper: {"z": -1e-6}}))
    assert "'lower' and 'floor'" in text
    assert abs(said(text) - 0.02) < 1e-4
    ball = fc.RigidBody(fc.Sphere(0.2), name="ball").placed((0.4, 0.4, 0.97))
    (text,) = overlaps(fc.Scene([lower, upper, ball], [contact]).solve(motions={upper: {"z": -1e-6}}))
    assert "'lower' and 'ball'" in text
    assert abs(said(text) - 0.03) < 1e-4


def test_two_rigid_planes_are_a_corner():
    lower = block("lower", contact=("bottom",), held="top")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    wall = floor.placed((-0.5, 0, 0), fc.rotation_about((0, 1, 0), np.pi / 2), name="wall")
    result = fc.Scene([lower, floor, wall], [fc.Contact(lower, floor)]).solve(motions={lower: {"z": -0.001}})
    assert overlaps(result) == []


def test_sections_that_overlap():
    """Source: geometry."""
    mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
    one = fc.PlaneBody(mesh, SOLID, "bottom", {"top": "xz"}, name="one")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    for shift, depth in ((0.9, 0.1), (1.0, None)):
        two = one.placed((shift, 0, 0), name="two")
        scene = fc.Scene([one, two, floor], [fc.Contact(one, floor), fc.Contact(two, floor)])
        found = overlaps(scene.solve(motions={one: {"z": -1e-5}, two: {"z": -1e-5}}))
        assert bool(found) is (depth is not None)
        if depth:
            assert abs(said(found[0]) - depth) < 1e-3


@pytest.mark.parametrize(("down", "depth"), [(0.15, None), (0.3, 0.1)])
def test_a_body_carried_by_a_finite_motion_is_where_it_has_come_to_rest(down, depth):
    """Source: geometry. A block 0.2 above another one is moved down; what counts is its final place, once."""
    lower = block("lower", contact=("bottom",), held="top")
    upper = block("upper", (1.0, 1.0, 1.0), (2, 2, 2), ("bottom",), "top").placed((1.5, 1.5, 1.2))
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([lower, upper, floor], [fc.Contact(lower, floor)])
    result = scene.solve(motions={lower: {"z": -1e-5}, upper: {"z": -down}}, finite_motion=True)
    found = overlaps(result)
    assert len(found) == (depth is not None)
    if depth:
        assert abs(said(found[0]) - depth) < 1e-3  # four digits are said, and the lower block moves by 1e-5
