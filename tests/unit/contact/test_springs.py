"""Springs and ligaments against hand calculations."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc


def ball_on_floor():
    """A rigid floor and an elastic block whose top is the frame."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    block = fc.ElasticBody(mesh, fc.Material(E=1000.0, nu=0.3), "bottom", {"top": "xyz"}, name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    return block, floor


def test_ligament_carries_a_pull_and_is_slack_under_a_push():
    block, floor = ball_on_floor()
    spring = fc.Spring(10.0, (block, (0.5, 0.5, 1.0)), (None, (0.5, 0.5, -3.0)), name="ligament")
    scene = fc.Scene([block, floor], [fc.Contact(block, floor)], springs=[spring])
    pulled = scene.solve(forces={block: (0, 0, 5.0)})
    # the top is the frame: the whole load goes through the ligament, which stretches by 5/10
    assert abs(pulled.springs[0].tension - 5.0) < 1e-12
    assert abs(pulled.springs[0].elongation - 0.5) < 1e-12
    assert abs(pulled.rigid_motion(block).translation[2] - 0.5) < 1e-12
    assert pulled.contacts[0].total_force == 0
    pushed = scene.solve(forces={block: (0, 0, -5.0)})
    assert pushed.springs[0].tension == 0
    assert abs(pushed.contacts[0].total_force - 5.0) < 1e-12
    assert pushed.springs[0].elongation < 0


def test_pretension_presses_the_bodies_together():
    block, floor = ball_on_floor()
    spring = fc.Spring(10.0, (block, (0.5, 0.5, 1.0)), (None, (0.5, 0.5, -3.0)), slack_length=3.5)
    result = fc.Scene([block, floor], [fc.Contact(block, floor)], springs=[spring]).solve(free={block: "z"})
    # tension = k (0.5 + motion), motion = -tension / K_block: a series of two springs
    tension = result.springs[0].tension
    stiffness = tension / -result.rigid_motion(block).translation[2]
    assert abs(tension - 10.0 * 0.5 / (1 + 10.0 / stiffness)) < 1e-10
    assert abs(result.contacts[0].total_force - tension) < 1e-10


def test_a_ligament_with_a_toe_pulls_as_blankevoort_and_huiskes_say():
    block, floor = ball_on_floor()
    length, per_strain, toe = 4.0, 400.0, 0.06
    ends = (block, (0.5, 0.5, 1.0)), (None, (0.5, 0.5, -3.0))
    ligament = fc.Spring(per_strain / length, *ends, toe=toe)
    scene = fc.Scene([block, floor], [fc.Contact(block, floor)], springs=[ligament])
    for strain in (-0.01, 0.001, 0.02, 0.06, 0.1):
        found = scene.solve(motions={block: {"z": strain * length}}).springs[0]
        exact = per_strain * (max(strain, 0) ** 2 / (2 * toe) if strain < toe else strain - toe / 2)
        # the fibres' polygon touches the parabola between its corners: k toe / (8 n^2) of 10 fibres
        assert abs(found.tension - exact) <= per_strain * toe / 800 * (1 + 1e-9)
        assert abs(found.elongation - strain * length) < 1e-12
    # a load is carried at the strain of the closed form
    pulled = scene.solve(forces={block: (0, 0, 20.0)}).springs[0]
    assert abs(pulled.tension - 20.0) < 1e-10
    assert abs(pulled.elongation - length * (20.0 / per_strain + toe / 2)) < 1e-10
    for wrong in ({"toe": -0.1}, {"toe": 2.0}, {"toe": 0.1, "kind": "linear"}):
        with refused(fc.InputError, "toe"):
            fc.Spring(1.0, *ends, **wrong)


def test_linear_spring_pushes_and_pulls():
    block, floor = ball_on_floor()
    spring = fc.Spring(10.0, (block, (0.5, 0.5, 1.0)), (None, (0.5, 0.5, 4.0)), kind="linear")
    lifted = fc.Scene([block, floor], [fc.Contact(block, floor)], [spring]).solve(forces={block: (0, 0, 2.0)})
    assert abs(lifted.springs[0].tension + 2.0) < 1e-12  # shortened by 0.2: it pushes back
    assert abs(lifted.rigid_motion(block).translation[2] - 0.2) < 1e-12


def test_all_ligaments_slack_under_a_pull_is_refused_in_words():
    block, floor = ball_on_floor()
    above = fc.Spring(10.0, (block, (0.5, 0.5, 1.0)), (None, (0.5, 0.5, 4.0)))
    scene = fc.Scene([block, floor], [fc.Contact(block, floor)], springs=[above])
    with refused(fc.SupportError, "free-motion", "'spring'"):
        scene.solve(forces={block: (0, 0, 5.0)})


def test_a_motion_that_slackens_all_ligaments_says_so():
    # two ligaments to the ground at the side: a push towards them is carried by neither them nor the smooth floor
    block, floor = ball_on_floor()
    sides = [
        fc.Spring(10.0, (block, (1.0, y, 1.0)), (None, (4.0, y, 1.0)), slack_length=3.0, name=name)
        for y, name in ((0.0, "front"), (1.0, "back"))
    ]
    scene = fc.Scene([block, floor], [fc.Contact(block, floor)], springs=sides)
    with refused(fc.SupportError, "free-motion", "'front'", "'back'"):
        scene.solve(forces={block: (5.0, 0, -10.0)}, free={block: "x z"})
    # away from them they carry it, half each
    result = scene.solve(forces={block: (-5.0, 0, -10.0)}, free={block: "x z"}, finite_motion=False)
    assert max(abs(s.tension - 2.5) for s in result.springs) < 1e-9


def test_spring_between_two_bodies_is_an_internal_force():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    steel = fc.Material(E=1000.0, nu=0.3)
    lower = fc.ElasticBody(mesh, steel, "top", {"bottom": "xyz"}, name="lower")
    upper = fc.ElasticBody(mesh, steel, "bottom", {"top": "xyz"}, name="upper").placed((0, 0, 1.0))
    bolt = fc.Spring(50.0, (upper, (0.5, 0.5, 1.0)), (lower, (0.5, 0.5, 0.0)), slack_length=1.9, name="bolt")
    result = fc.Scene([lower, upper], [fc.Contact(upper, lower)], springs=[bolt]).solve(free={upper: "z"})
    # equilibrium of the upper block: contact force equals bolt tension, to rounding
    assert abs(result.contacts[0].total_force / result.springs[0].tension - 1) < 1e-10
    assert result.springs[0].tension > 0


def test_floating_body_is_tied_at_its_nodes_only():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    loose = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), "bottom", name="loose")
    with refused(fc.InputError, "no-node-there"):
        loose.attachment(np.array([0.1, 0.1, 0.1]), np.array([0, 0, 1.0]))
    row = loose.attachment(np.array([0.0, 0.0, 1.0]), np.array([0, 0, 1.0]))
    assert abs((row @ loose.rigid_modes)[0, 2] - 1) < 1e-12  # moves with the body


def test_frame_point_follows_the_rigid_motion_exactly():
    block, _ = ball_on_floor()
    point, direction = np.array([3.0, -2.0, 5.0]), np.array([0.0, 0.6, 0.8])
    row = block.attachment(point, direction)
    from fecontact.fem.rigid import rigid_modes

    exact = direction @ rigid_modes(point[None, :], block.reference_point)
    assert np.abs(row @ block.rigid_modes - exact).max() < 1e-12


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stiffness": -1.0}, ("not-positive", "The stiffness of 'spring'")),
        ({"kind": "rubber"}, ("unknown-name", "kind")),
        ({"slack_length": -1.0}, ("input", "must not be negative")),
        ({"end": (None, (0, 0, float("nan")))}, ("not-a-vector", "An end of 'spring'")),
        ({"end": (None, (0.5, 0.5, 1.0))}, ("input", "'spring'")),
    ],
)
def test_bad_springs_are_named(changes, message):
    block, _ = ball_on_floor()
    given = {"stiffness": 1.0, "start": (block, (0.5, 0.5, 1.0)), "end": (None, (0.0, 0.0, 0.0)), **changes}
    with refused(fc.InputError, *message):
        fc.Spring(**given)


def test_spring_on_a_foreign_body_is_refused():
    block, floor = ball_on_floor()
    other = fc.RigidBody(fc.Plane(), name="other")
    spring = fc.Spring(1.0, (block, (0.5, 0.5, 1.0)), (other, (0.0, 0.0, 0.0)))
    with refused(fc.InputError, "not-in-scene", "'other'", "'spring'"):
        fc.Scene([block, floor], [fc.Contact(block, floor)], springs=[spring])
