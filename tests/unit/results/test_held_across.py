"""Loads that become wedges are warned of, with what the hold takes; those that are held on purpose are not."""

import numpy as np
import pytest

import fecontact as fc

SOLID = fc.Material(E=1e4, nu=0.3)
SLOPE = 0.3


def on_slope(height=0.0, **loads):
    """A ball pressed down on a slope of an elastic wedge: contacts push it aside by tan(slope) of the load."""
    mesh = fc.shapes.block((8.0, 8.0, 2.0), (16, 16, 3)).translated((-4.0, -4.0, -2.0))
    turn = fc.rotation_about((0, 1, 0), SLOPE)
    wedge = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}, name="wedge").placed(rotation=turn)
    ball = fc.RigidBody(fc.Sphere(radius=5.0), name="ball").placed(turn @ (0.0, 0.0, 5.0) - (0.0, 0.0, 5.0))
    scene = fc.Scene([wedge, ball], [fc.Contact(wedge, ball)])
    given = {k: {ball: v} for k, v in loads.items()}
    return scene.solve(**given)


def about(result):
    return [text for text in result.warnings if "held across" in text]


@pytest.mark.full
def test_ball_pressed_on_a_slope_is_held_by_what_statics_tells():
    (text,) = about(on_slope(forces=(0.0, 0.0, -20.0)))
    assert f"{100 * np.tan(SLOPE):.0f} % of the load" in text
    assert about(on_slope(forces=(0.0, 0.0, -20.0), motions={"x": 0.0})) == []


def v_groove(**loads):
    """A ball in a groove of two flats: contacts on both sides carry an oblique load."""
    turns = [fc.rotation_about((0, 1, 0), a) for a in (0.6, -0.6)]
    mesh = fc.shapes.block((8.0, 4.0, 2.0), (16, 8, 3)).translated((-4.0, -2.0, -2.0))
    flats = [
        fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}, name=name).placed(Q @ (0.0, 0.0, -5.0), rotation=Q)
        for name, Q in zip(("left", "right"), turns, strict=True)
    ]
    ball = fc.RigidBody(fc.Sphere(radius=5.0), name="ball").placed((0.0, 0.0, -5.0))
    scene = fc.Scene([*flats, ball], [fc.Contact(flat, ball) for flat in flats])
    return scene.solve(**{k: {ball: v} for k, v in loads.items()}), ball


def test_oblique_load_in_a_groove_is_shared_as_statics_tells_where_the_frame_is_free():
    load = np.array([5.0, 0.0, -20.0])
    result, _ = v_groove(forces=load, free="x z")
    assert about(result) == []
    left, right = (c.force for c in result.contacts)  # on the flats
    assert np.abs(left + right - load).max() < 1e-8 * 20
    # two forces along the flats' normals balance the load: a 2 x 2 system; contacts are a few percent of R wide
    normals = np.array([[np.sin(0.6), np.cos(0.6)], [-np.sin(0.6), np.cos(0.6)]])
    shares = np.linalg.solve(normals.T, -load[[0, 2]])
    found = [np.linalg.norm(left), np.linalg.norm(right)]
    assert found == pytest.approx(shares, rel=0.01)


def test_oblique_load_in_a_groove_held_across_is_warned_of_with_what_the_hold_takes():
    load = np.array([5.0, 0.0, -20.0])
    result, ball = v_groove(forces=load)
    reaction = result.reaction(ball)[:3]
    along = load / np.linalg.norm(load)
    share = np.linalg.norm(reaction - (reaction @ along) * along) / np.linalg.norm(load)
    (text,) = about(result)
    assert share > 0.1
    assert f"{100 * share:.0f} % of the load" in text
    held, _ = v_groove(forces=(0.0, 0.0, -20.0))
    assert about(held) == []
