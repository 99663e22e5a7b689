"""Estimated errors of forces and motions by the elements of whole bodies, against quadratic elements."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.fem.energy_error import EnergyError
from fecontact.results.response_error import _amplified

SOFT = fc.Material(E=1.0, nu=0.3)
HELD = {"x_min": "xyz", "y_min": "y"}


def beam(cells, element, name="beam"):
    """Half of a cantilever of 8 x 1 x 1 along x, and a rigid ball above its end."""
    mesh = fc.shapes.block((8.0, 0.5, 1.0), cells, element=element)
    body = fc.ElasticBody(mesh, SOFT, "top", HELD, name=name)
    return body, fc.RigidBody(fc.Sphere(5.0), name="ball").placed((6.4, 0.0, 1.0))


def pressed(cells, element, **loads):
    """The ball pressed on the beam."""
    body, ball = beam(cells, element)
    scene = fc.Scene([body, ball], [fc.Contact(body, ball)])
    return scene.solve(**{name: {ball: load} for name, load in loads.items()}, finite_motion=False), ball


@pytest.fixture(scope="module")
def driven():
    return [pressed((10, 1, 2), element, motions={"z": -0.1})[0] for element in ("hex8", "hex20")]


def test_force_of_a_given_motion(driven):
    coarse, better = driven
    error = coarse.contacts[0].total_force / better.contacts[0].total_force - 1
    found = coarse.response_error
    assert error > 0.2
    assert 0.8 * error < found.force < 2 * error
    assert found.approach is found.tilt is None
    assert better.response_error.force < 0.1 * found.force
    assert found.worst == found.force


def test_approach_under_a_given_force():
    (coarse, one), (better, two) = (pressed((10, 1, 2), e, forces=(0, 0, -2e-5)) for e in ("hex8", "hex20"))
    error = better.rigid_motion(two).translation[2] / coarse.rigid_motion(one).translation[2] - 1
    found = coarse.response_error
    assert 0.8 * error < found.approach < 2 * error
    assert found.force is None


def test_every_contact_has_its_own_error():
    """Two beams in one scene, moved alike: the force of the coarse one is off as it is alone, the other's is not."""
    coarse, ball = beam((10, 1, 2), "hex8")
    fine, other = beam((10, 1, 2), "hex20", name="fine")
    fine, other = (b.placed(b.pose.translation + np.array([0.0, 9.0, 0.0])) for b in (fine, other))
    scene = fc.Scene([coarse, ball, fine, other], [fc.Contact(coarse, ball), fc.Contact(fine, other)])
    both = scene.solve(motions={ball: {"z": -0.1}, other: {"z": -0.1}}, finite_motion=False)
    alone = pressed((10, 1, 2), "hex8", motions={"z": -0.1})[0].response_error.force
    assert abs(both.response_error.force / alone - 1) < 0.05
    of_body = [abs(parts.sum()) for parts in both.response_errors.cells["force"]]
    assert of_body[2] < 1e-9 * of_body[0]


def test_tilt_of_a_body_that_is_free_to_turn():
    """A rigid plate on the ends of two cantilevers, one of linear cells, pressed off its middle."""
    plate = fc.RigidBody(fc.Plane(), name="plate").placed((0, 0, 1.1), fc.rotation_about((1, 0, 0), np.pi))
    results = []
    for element in ("hex8", "hex20"):
        props = []
        for side, cells in ((-1, "hex20"), (1, element)):
            mesh = fc.shapes.block((4.0, 1.0, 1.0), (8, 1, 2), element=cells).translated((1.0, -0.5, 0.0))
            mesh = mesh.mapped(lambda p: p * [1, 1, 1] + np.outer(0.1 * p[:, 2] * (5 - p[:, 0]) / 4, [0, 0, 1]))
            turn = fc.rotation_about((0, 0, 1), 0.0 if side > 0 else np.pi)
            held = {"x_max": "xyz"}
            props.append(fc.ElasticBody(mesh, SOFT, "top", held, name=f"prop {side}").placed((0, 0, 0), turn))
        scene = fc.Scene([*props, plate], [fc.Contact(p, plate) for p in props])
        results.append(scene.solve(forces={(plate, (0.4, 0.0, 0.0)): (0, 0, -1e-4)}, finite_motion=False))
    tilts = [r.rigid_motion(plate).rotation[1] for r in results]
    error = tilts[1] / tilts[0] - 1
    assert error > 0.2
    assert 0.8 < results[0].response_error.tilt / error < 2


def test_no_error_where_strains_are_those_of_the_elements():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([block, floor], [fc.Contact(block, floor)])
    result = scene.solve(motions={block: {"z": -0.01}})
    assert result.response_error.force < 1e-12
    assert not any("too stiff" in text for text in result.warnings)
    away = scene.solve(motions={block: {"z": 0.01}})
    assert str(away.response_error) == ""
    assert away.response_error.worst == 0.0


def test_cells_that_are_too_stiff_by_more_than_is_known_count_as_known():
    """By hand: 1.65 over what the error leaves of the energy, a tenth of it at least."""
    own = EnergyError(np.arange(4), np.array([0.5, 0.95, 2.0, 0.0]), np.array([1.0, 1.0, 1.0, 0.0]), 1.0)
    assert np.abs(_amplified(own, np.ones(4)) - [3.3, 16.5, 16.5, 1.65]).max() < 1e-12


def test_friction_has_an_estimate_too():
    mesh = fc.shapes.block((8.0, 0.5, 1.0), (10, 1, 2), element="hex8")
    body = fc.ElasticBody(mesh, SOFT, "top", HELD)
    ball = fc.RigidBody(fc.Sphere(5.0)).placed((6.4, 0.0, 1.0))
    result = fc.Scene([body, ball], [fc.Contact(body, ball, friction=0.3)]).solve(motions={ball: {"z": -0.1}})
    smooth = pressed((10, 1, 2), "hex8", motions={"z": -0.1})[0]
    assert abs(result.response_error.force / smooth.response_error.force - 1) < 0.1


def test_it_is_printed_saved_and_warned_of(driven):
    coarse, better = driven
    assert f"errors by the elements of whole bodies: {coarse.response_error}" in str(coarse)
    assert coarse.summary()["response_error"]["force"] == coarse.response_error.force
    assert any("the force about" in text and "20 nodes" in text for text in coarse.warnings)
    assert not any("too stiff" in text for text in better.warnings)
