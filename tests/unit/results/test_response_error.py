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
    # that of the contact, at a single node, remains
    assert better.response_error.force < 0.2 * found.force
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
    of_body = [abs(parts.sum()) for parts in both._response_errors.cells["force"]]
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


@pytest.mark.parametrize(("error", "factor"), [(0.5, 3.3), (0.95, 16.5), (2.0, 16.5), (0.0, 1.65)])
def test_bodies_that_are_too_stiff_by_more_than_is_known_count_as_known(error, factor):
    """By hand: 1.65 over what the error leaves of the body's energy, a tenth of it at least."""
    own = EnergyError(np.arange(2), error * np.array([0.9, 0.1]), np.array([0.5, 0.5]), 1.0)
    assert np.abs(_amplified(own, np.ones(2)) - factor).max() < 1e-12


def test_friction_has_an_estimate_too():
    mesh = fc.shapes.block((8.0, 0.5, 1.0), (10, 1, 2), element="hex8")
    body = fc.ElasticBody(mesh, SOFT, "top", HELD)
    ball = fc.RigidBody(fc.Sphere(5.0)).placed((6.4, 0.0, 1.0))
    result = fc.Scene([body, ball], [fc.Contact(body, ball, friction=0.3)]).solve(motions={ball: {"z": -0.1}})
    smooth = pressed((10, 1, 2), "hex8", motions={"z": -0.1})[0]
    assert abs(result.response_error.force / smooth.response_error.force - 1) < 0.1


def test_it_is_printed_saved_and_warned_of(driven):
    coarse, better = driven
    assert f"errors of forces and motions by the meshes: {coarse.response_error}" in str(coarse)
    assert coarse.summary()["response_error"]["force"] == coarse.response_error.force
    assert any("the force about" in text and "20 nodes" in text for text in coarse.warnings)
    assert not any("too stiff" in text for text in better.warnings)


def test_a_ball_reaches_into_flat_faces_between_their_nodes():
    """Faces of 4 nodes, all in contact with z = r^2 / 2R: the mean gap is that of the chords, -h^2 / 6R."""
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (4, 4, 2), element="hex8").translated((-0.5, -0.5, -0.5))
    body = fc.ElasticBody(mesh, SOFT, "top", {"bottom": "xyz"})
    ball = fc.RigidBody(fc.surfaces.Paraboloid(100.0))
    result = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -0.02}})
    (contact,) = result.contacts
    assert contact.active.all()
    inner = np.abs(contact.points[:, :2]).max(axis=1) < 0.4
    chord = 0.25**2 / 600
    assert np.abs(contact._between_nodes.means[inner] + chord).max() < 0.08 * chord
    smooth = fc.ElasticBody(
        fc.shapes.block((1.0, 1.0, 0.5), (4, 4, 2)).translated((-0.5, -0.5, -0.5)), SOFT, "top", {"bottom": "xyz"}
    )
    better = fc.Scene([smooth, ball], [fc.Contact(smooth, ball)]).solve(motions={ball: {"z": -0.02}})
    assert np.abs(better.contacts[0]._between_nodes.means).max() < 1e-3 * chord


def test_bulky_bodies_by_force_and_by_motion():
    """A ball on a block: what the force exceeds, over the power 1.6 with which it grows, is what the approach lacks."""
    told, found = [], []
    for n in (5, 10):
        grid = np.linspace(0, 1, n + 1) ** 1.3
        mesh = fc.shapes.block((1.0, 1.0, 1.0), (grid, grid, 1 - grid[::-1]))
        body = fc.ElasticBody(mesh, SOFT, "top", {"bottom": "xyz", "x_min": "x", "y_min": "y"})
        ball = fc.RigidBody(fc.surfaces.Paraboloid(4.0)).placed((0, 0, 1.0))
        scene = fc.Scene([body, ball], [fc.Contact(body, ball)])
        moved = scene.solve(motions={ball: {"z": -0.03}}, finite_motion=False)
        pushed = scene.solve(forces={ball: (0, 0, -0.005)}, finite_motion=False)
        found.append((moved.contacts[0].total_force, -pushed.rigid_motion(ball).translation[2]))
        told.append((moved.response_error.force, pushed.response_error.approach))
    errors = found[0][0] / found[1][0] - 1, found[1][1] / found[0][1] - 1
    for error, estimate in zip(errors, told[0], strict=True):
        assert 0.8 * abs(error) < estimate < 3 * abs(error)
    assert abs(told[0][0] / told[0][1] - 1.6) < 0.3


def test_bodies_without_an_estimate_are_named():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    bricks = fc.AncfBody(mesh, SOFT, contact="bottom", supports={"top": "xyz"}, name="bricks")
    floor = fc.RigidBody(fc.Plane())
    result = fc.Scene([bricks, floor], [fc.Contact(bricks, floor)]).solve(motions={bricks: {"z": -0.01}})
    assert str(result.response_error) == ""
    assert "errors of forces and motions by the meshes: not estimated with 'bricks'" in str(result)


def test_a_foundation_in_a_scene():
    """Winkler's foundation below a paraboloid, P = k pi R d^2."""
    mesh = fc.shapes.block((2.0, 2.0, 0.5), (10, 10, 1), element="hex8").translated((-1, -1, -0.5))
    springs = fc.ElasticLayer(SOFT, 1.0, surface=(mesh, "top"))
    ball = fc.RigidBody(fc.surfaces.Paraboloid(10.0))
    result = fc.Scene([springs, ball], [fc.Contact(springs, ball)]).solve(motions={ball: {"z": -0.0125}})
    true = springs.contact_modulus * np.pi * 10.0 * 0.0125**2
    error = abs(result.contacts[0].total_force / true - 1)
    assert 0.8 * error < result.response_error.force < 5 * error


def test_the_sign_is_told_where_the_elements_make_most_of_it(driven):
    assert any("are too stiff: the force about" in text and "too large" in text for text in driven[0].warnings)
    mesh = fc.shapes.block((4.0, 4.0, 2.0), (8, 8, 4)).translated((-2.0, -2.0, -2.0))
    plate = fc.ElasticBody(mesh, fc.Material(E=70e3, nu=0.33), contact="top", supports={"bottom": "xyz"})
    ball = fc.RigidBody(fc.Sphere(10.0))
    result = fc.Scene([plate, ball], [fc.Contact(plate, ball)]).solve(forces={ball: (0, 0, -100.0)})
    assert any("or the faces in contact too large: the approach about 40 % off" in text for text in result.warnings)
