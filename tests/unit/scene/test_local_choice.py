"""Whether a local body serves, in one sentence: contacts for which it does, and those for which it does not."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.scene.cost import explain

STEEL, OVER = fc.Material(E=1.0, nu=0.3), fc.rotation_about((1, 0, 0), np.pi)


def block(**options):
    mesh = fc.shapes.block((4.0, 4.0, 2.0), (4, 4, 2))
    return fc.ElasticBody(mesh, STEEL, **{"contact": "top", "supports": {"bottom": "xyz"}, "name": "block", **options})


def told(body, other, friction=0.0, **loads):
    scene = fc.Scene([body, other], [fc.Contact(body, other, friction=friction)])
    return explain(scene, loads)


def ball(at=(2.2, 1.9, 2.0), radius=5.0):
    return fc.RigidBody(fc.Sphere(radius), pose=fc.Pose(translation=at), name="ball")


def test_a_small_contact_within_a_face_is_served() -> None:
    """With the size of the contact by Hertz and the faces of the mesh across it."""
    body, other = block(), ball()
    explanation = told(body, other, forces={other: (0, 0, -1e-3)})
    (sentence,) = explanation.local
    size = 2 * fc.hertz.spheres((5.0, float("inf")), (None, STEEL), force=1e-3).a
    assert sentence == (
        f"block.top on ball.surface: a local body of 'block' serves: the contact is about {size:.3g} x {size:.3g}, its "
        f"window of {1.15 * size:.3g} x {1.15 * size:.3g} lies within one smooth face, and {size:.2g} faces lie across "
        "the contact, of 12 or more that are needed without it."
    )
    assert f"Local:     {sentence}" in str(explanation)


@pytest.mark.full
def test_two_elastic_bodies_have_a_sentence_each() -> None:
    lower = block()
    upper = fc.ElasticBody(fc.shapes.half_sphere(3.0, level=1), STEEL, "cap", {"base": "xyz"}, name="cap")
    upper = upper.placed([2.0, 2.0, 2.0])
    (sentence,) = told(upper, lower, forces={upper: (0, 0, -1e-3)}).local
    assert "of 'cap' serves" in sentence
    assert "of 'block' serves" in sentence


REFUSED = {
    "edge": (ball((0.1, 2.0, 2.0)), 5e-3, "reaches across an edge"),
    "conforming": (fc.RigidBody(fc.Plane(), pose=fc.Pose(OVER, (0, 0, 2.0))), 1e-3, "conform"),
    "large": (ball(radius=50.0), 1.0, "reaches across an edge"),
    "no load": (ball((2.0, 2.0, 2.1)), 0.0, "do not touch"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_where_none_serves_the_reason_is_told(case: str) -> None:
    other, force, reason = REFUSED[case]
    (sentence,) = told(block(), other, forces={other: (0, 0, -force)} if force else {}).local
    assert "no local body, but finite elements with accuracy=" in sentence
    assert reason in sentence


def test_friction_and_bodies_without_a_mesh_in_space() -> None:
    other = ball()
    (sentence,) = told(block(), other, 0.3, forces={other: (0, 0, -1e-3)}).local
    assert "has friction" in sentence
    section = fc.PlaneBody(fc.sections.rectangle((1.0, 1.0), (4, 4)), STEEL, contact="bottom", supports={"top": "xz"})
    floor = fc.RigidBody(fc.Plane())
    assert told(section, floor, motions={section: {"z": -0.01}}).local == ()
