"""Newton steps of load steps with friction on nearly incompressible blocks: counts are bounded."""

from __future__ import annotations

import numpy as np
import pytest

import fecontact as fc


@pytest.fixture(scope="module")
def block() -> fc.ElasticBody:
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 2))
    return fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.49), "bottom", {"top": "xyz"}, name="block")


@pytest.mark.parametrize("mu", [0.3, 2.0])
def test_random_load_steps_take_few_newton_steps(block: fc.ElasticBody, mu: float) -> None:
    """Random motions with turns. At mu = 2 they took up to 14 while all friction came in at once."""
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([block, floor], [fc.Contact(block, floor, friction=mu)])
    moves = np.random.default_rng(0).uniform(-0.02, [0.02, 0.02, 0.0, 0.02, 0.02, 0.02], size=(5, 6))
    names = ("x", "y", "z", "rx", "ry", "rz")
    path = scene.solve_path([{"motions": {block: dict(zip(names, m, strict=True))}} for m in moves])
    steps = [result.friction.nit for result in path.steps]
    assert max(steps) <= 12
    assert max(result.friction.residuals.worst for result in path.steps) <= 1e-10
    assert path.cuts == (1,) * 5


def test_a_layer_has_its_candidates_at_once() -> None:
    """A ball pressed into a thin layer, then moved a little: no second round, and the candidates stay."""
    found = {}
    for depth in (0.3, 2.0):
        mesh = fc.shapes.block((2.0, 2.0, depth), (6, 6, 1)).translated((-1.0, -1.0, -depth))
        pad = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), "top", {"bottom": "xyz"}, name="pad")
        ball = fc.RigidBody(fc.Sphere(3.0), name="ball")
        scene = fc.Scene([pad, ball], [fc.Contact(pad, ball, friction=0.3)])
        found[depth] = scene.solve_path([{"motions": {ball: {"z": -0.12, "x": x}}} for x in (0.0, 0.01)])
    layer, thick = found[0.3], found[2.0]
    assert [result.rounds for result in (*layer, *thick)] == [1, 1, 1, 1]
    assert layer[0].n_candidates > thick[0].n_candidates  # a thick body gives way round the ball: fewer may touch
    assert layer[1].n_candidates == layer[0].n_candidates


def pulled_belt(n, mu, pulls):
    """Path of a thin belt on half a drum, of n elements."""
    mesh = fc.sections.annulus(1.0, 1.01, (n, 1), element="quad9")
    belt = fc.PlaneBody(mesh, fc.Material(E=100.0, nu=0.0), "inner", {"sym_x": "x"}, name="belt")
    drum = fc.RigidBody(fc.surfaces.Cylinder(1.0), name="drum").placed((0.0, 0.0, -1.0))
    scene = fc.Scene([belt, drum], [fc.Contact(belt, drum, friction=mu)])
    slack = {(belt, "sym_z"): (0.0, 0.0, -1e-3)}
    return scene.solve_path([{"forces": slack, "motions": {belt: {"x": -pull}}} for pull in pulls])


def test_a_belt_that_slides_takes_few_newton_steps() -> None:
    """Pulled one way, then the other: a section, whose directions of slip are signs."""
    path = pulled_belt(20, 0.3, (0.0, 0.02, -0.01))
    assert max(result.friction.nit for result in path.steps) <= 5


def test_a_belt_with_much_friction_converges() -> None:
    """Pulled a little at mu = 2, half of the belt turns back: without a second try by gaps the step is cut in two."""
    path = pulled_belt(40, 2.0, (0.0, 0.002))
    assert path.cuts == (1, 1)
    assert path[1].friction.nit <= 50
    assert path[1].friction.residuals.worst <= 1e-10


@pytest.mark.full
def test_a_strip_that_slides_back_converges() -> None:
    """A thin strip on a plane, pulled and let back: with 50 Newton steps the last step was cut in three."""
    mesh = fc.shapes.block((20.0, 1.0, 0.05), (12, 1, 1))
    strip = fc.ElasticBody(mesh, fc.Material(E=1000.0, nu=0.3), "bottom", {"x_max": "x"}, name="strip")
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([strip, floor], [fc.Contact(strip, floor, friction=5.0)])
    pressed = {(strip, "top"): 0.01}
    path = scene.solve_path([{"pressures": pressed, "motions": {strip: {"x": x}}} for x in (0.0, 0.04, 0.4, 0.12)])
    assert path.cuts == (1, 1, 1, 1)
    assert all(result.friction.residuals.within(1e-10) for result in path.steps)
    # all of it slides at the end of the pull: friction is mu times the load
    assert abs(path[2].reaction(strip)[0]) == pytest.approx(5.0 * 0.01 * 20.0, rel=0.02)
