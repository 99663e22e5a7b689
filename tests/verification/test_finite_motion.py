"""Finite rigid motion against closed forms: equilibrium angles far beyond what a linearised rotation bears."""

import numpy as np
import pytest

import fecontact as fc


@pytest.mark.parametrize("angle", [0.5, -0.3])
def test_ball_rolls_on_a_soft_pad_to_the_angle_of_statics(angle, row):
    """A rigid ball pressed at its pole into a soft pad and turned by a moment.

    Statics: without friction the pad's forces pass through the centre of the ball, so the force P at the pole, then R
    sin t aside of the centre, balances the moment M = P R sin t, however the pad gives. The ball sinks in by 2 percent
    of R, so that a pose that has not settled shows: 1e-4 of that leaves an error far below the 1e-5 allowed. The pad
    has its middle under the centre, so that nothing pushes sideways.
    """
    radius, load = 2.0, 1.0
    aside = radius * np.sin(angle)
    mesh = fc.shapes.block((3.0, 3.0, 1.0), (8, 8, 2)).translated((-1.5, -1.5, -1.0))
    pad = fc.ElasticBody(mesh, fc.Material(E=20.0, nu=0.3), "top", {"bottom": "xyz"}, name="pad")
    ball = fc.RigidBody(fc.Sphere(radius=radius), name="ball").placed((-aside, 0.0, 0.0))
    result = fc.Scene([pad, ball], [fc.Contact(pad, ball)]).solve(
        forces={ball: (0.0, 0.0, -load)}, moments={ball: (0.0, load * aside, 0.0)}, free={ball: "z ry"},
        finite_motion=True,
    )  # fmt: skip
    motion, case = result.rigid_motion(ball), f"rigid ball rolls on a soft pad, {angle:g} rad"
    row(case, "angle", angle, motion.rotation[1], 1e-5, result.n_dofs)
    # the pole is where the turn puts it under a centre that has come down by as much as the pad gives
    sunk = radius * (1 - np.cos(angle)) - motion.translation[2]
    row(case, "sunk / largest displacement of the pad", 1.0, sunk / result._state.scale, 1e-4, result.n_dofs)
    row(case, "force sideways / load", 0.0, result.contacts[0].force[0] / load, 1e-5, result.n_dofs)


@pytest.mark.parametrize(
    ("law", "guide", "wall", "finite"),
    [
        (fc.Material(1.0, 0.0), 0.0, 0.3, False),
        (fc.Material(1.0, 0.0), 0.3, 0.3, True),
        (fc.Material(1.0, 0.0), 0.6, 0.2, True),
        (fc.NeoHookean(1.0, 0.0, 1.0), 0.5, 0.5, True),
    ],
)
def test_a_slide_on_a_guide_that_has_turned(law, guide, wall, finite, row):
    """A block free to slide along itself, turned with its guide and pressed against a wall by a force along x.

    Statics: the guide bears what is across it, so the wall's force N along its normal n has N (n . g) = P (g . x) along
    the guide g. Its frame moves along the guide alone.
    """
    load, (g, n) = 0.002, (np.array([np.cos(t), np.sin(t), 0.0]) for t in (guide, wall))
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)).translated((-0.5, -0.5, -0.5))
    block = fc.ElasticBody(mesh, law, "x_max", {"y_min": "yz", "y_max": "yz"}, name="block")
    turn = fc.rotation_about((0, 0, 1), wall) @ fc.rotation_about((0, 1, 0), -np.pi / 2)
    plane = fc.RigidBody(fc.Plane(), name="wall").placed(0.7 * n, turn)
    result = fc.Scene([block, plane], [fc.Contact(block, plane)]).solve(
        forces={block: (load, 0, 0)}, motions={block: {"rz": guide}} if guide else None, finite_motion=finite
    )
    motion, case = result.rigid_motion(block), f"slide on a guide turned by {guide:g}, wall by {wall:g}"
    row(case, "force / load", g[0] / (n @ g), -float(result.contacts[0].force @ n) / load, 1e-9, result.n_dofs)
    assert abs(np.cross(g, motion.translation)).max() <= 1e-12
    assert motion.translation @ g > 0
