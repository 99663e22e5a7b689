"""What linearised rigid motions leave out, and poses carried along where it matters."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused
from scipy.optimize import brentq

import fecontact as fc
import fecontact.scene.finite_rotation as finite
from fecontact.results import linearisation
from fecontact.results.linearisation import (
    BEARABLE,
    LinearisationError,
    _driven,
    _Motion,
    _turn_by_deflection,
    linearisation_error,
)
from fecontact.results.warnings import unborne_motions

SOLID = fc.Material(E=1000.0, nu=0.3)
RADIUS = 5.0


def pad():
    mesh = fc.shapes.block((4.0, 4.0, 1.0), (8, 8, 2)).translated((-2.0, -2.0, -1.0))
    return fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}, name="pad")


def under_ball(height=0.0, unit=1.0, **loads):
    """A ball on a pad; loads are the ball's."""
    plate = pad()
    ball = fc.RigidBody(fc.Sphere(radius=RADIUS), name="ball").placed((0.0, 0.0, height))
    given = {k: {ball: v} if k in ("forces", "motions") else v for k, v in loads.items()}
    return fc.Scene([plate, ball], [fc.Contact(plate, ball)]).solve(**given), ball


def test_error_of_a_shift_has_the_size_that_geometry_tells():
    shift = 0.1
    result, _ = under_ball(motions={"x": shift, "z": -0.05}, finite_motion=False)
    error = linearisation_error(result)
    # a ball that moves along itself by d changes gaps by d^2 / 2R more than linearly, and the line of action by d / R;
    # the pad is drawn along by some thousandths of that
    assert error.gap == pytest.approx(shift**2 / (2 * RADIUS), rel=0.02)
    assert error.direction == pytest.approx(shift / RADIUS, rel=0.02)
    assert error.approach == pytest.approx(0.05, rel=0.1)


@pytest.mark.parametrize("unit", [1.0, 1e3, 1 / 3])
@pytest.mark.parametrize("at", [(0.0, 0.0), (0.13, -0.07)])
def test_one_point_is_judged_by_the_approach_in_every_unit(at, unit):
    """A point alone has no width; rounding of its place as one said that 900 times the approach was left out."""
    mesh = fc.shapes.block((4.0 * unit, 4.0 * unit, unit), (2, 2, 1)).translated((-2.0 * unit, -2.0 * unit, -unit))
    plate = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}, name="pad")
    ball = fc.RigidBody(fc.Sphere(radius=RADIUS * unit), name="ball").placed((at[0] * unit, at[1] * unit, 0.0))
    scene = fc.Scene([plate, ball], [fc.Contact(plate, ball)])
    result = scene.solve(motions={ball: {"z": -0.05 * unit}}, finite_motion=False)
    assert result.n_active == 1
    error = linearisation_error(result)
    # the ball's gap at the node before it is pressed: its distance from the pole squared over twice the radius
    depth = 0.05 - (at[0] ** 2 + at[1] ** 2) / (2 * RADIUS)
    assert error.approach / unit == pytest.approx(depth, rel=1e-2)
    assert error.gap < BEARABLE * error.approach


def test_small_motions_are_left_as_they_are():
    result, _ = under_ball(motions={"z": -0.05})
    alone, _ = under_ball(motions={"z": -0.05}, finite_motion=False)
    assert linearisation_error(result).worst < BEARABLE
    assert result._originals == ()
    assert result.contacts[0].total_force == alone.contacts[0].total_force


@pytest.mark.parametrize(
    ("finite_motion", "height", "z"), [("auto", 0.0, -0.05), (False, 0.0, -0.05), ("auto", 3.0, -3.05)]
)
def test_the_error_is_worked_out_once_for_a_result(monkeypatch, finite_motion, height, z):
    judged = []
    of_contact = linearisation._of_contact
    monkeypatch.setattr(linearisation, "_of_contact", lambda *given: judged.append(given[1]) or of_contact(*given))
    result, _ = under_ball(height, motions={"z": z}, finite_motion=finite_motion, search="local")
    assert not any("move or turn far" in text for text in result.warnings)
    assert str(result)
    assert result.summary()["warnings"] == list(result.warnings)
    # once for every solution on the way: a ball from afar is carried along and solved again
    assert len(judged) == len(set(map(id, judged))) == (2 if (finite_motion, height) == ("auto", 3.0) else 1)
    assert (result._linearisation is not None) == (finite_motion == "auto")


@pytest.mark.parametrize("load", [{"forces": (0.0, 0.0, -20.0)}, {"motions": {"z": -3.05}}])
def test_ball_that_comes_from_far_presses_as_if_placed_there(load):
    far, ball = under_ball(3.0, **load)
    near, other = under_ball(0.0, **({"motions": {"z": -0.05}} if "motions" in load else load))
    # what is left of linearised motions is below 1e-3 of the approach; forces go with its power 3 / 2
    assert abs(far.contacts[0].max_pressure / near.contacts[0].max_pressure - 1) < 2e-3
    assert abs(far.rigid_motion(ball).translation[2] - near.rigid_motion(other).translation[2] + 3.0) < 1e-4
    assert not any("turn far" in text for text in far.warnings)
    linear, _ = under_ball(3.0, **load, finite_motion=False)
    assert abs(linear.contacts[0].max_pressure / near.contacts[0].max_pressure - 1) > 0.03
    (warning,) = (text for text in linear.warnings if "turn far" in text)
    error = linearisation_error(linear)
    assert f"{100 * error.gap / error.approach:.2g} % of the indentation" in warning
    assert error.worst > 10 * BEARABLE


def test_sideways_motion_of_the_ball_presses_as_if_placed_there():
    moved, _ = under_ball(motions={"x": 0.25, "z": -0.02})
    plate, ball = pad(), fc.RigidBody(fc.Sphere(radius=RADIUS)).placed((0.25, 0.0, -0.02))
    placed = fc.Scene([plate, ball], [fc.Contact(plate, ball)]).solve(motions={ball: {"z": 0.0}})
    # prescribed motions are finite from the start: the same pose to rounding
    assert abs(moved.contacts[0].total_force / placed.contacts[0].total_force - 1) < 1e-9


def test_contact_that_linearised_turns_overlook_is_found():
    turn, gap = 1.2, 2.9
    # about its pole a ball turned by t comes down by R (1 - cos t) and aside by R sin t, which x takes back
    loads = {"motions": {"ry": turn, "x": -RADIUS * np.sin(turn)}}
    result, _ = under_ball(gap, **loads)
    linear, _ = under_ball(gap, **loads, finite_motion=False)
    assert linear.status == "no-contact"
    assert "lose or overlook" in linear.warnings[0]
    placed, _ = under_ball(gap - RADIUS * (1 - np.cos(turn)), motions={"z": 0.0})
    assert abs(result.contacts[0].total_force / placed.contacts[0].total_force - 1) < 1e-9


def test_lever_on_a_rope_finds_its_angle():
    lever = fc.RigidBody(fc.Plane(), name="lever")
    rope = fc.Spring(2.0, (lever, (3.0, 0.0, 0.0)), (None, (3.0, 0.0, 4.0)), slack_length=4.0, name="rope")
    scene = fc.Scene([lever], [], springs=[rope])

    def unbalance(t):
        tip = np.array([3 * np.cos(t), -3 * np.sin(t)])
        line = np.array([3.0, 4.0]) - tip
        length = np.linalg.norm(line)
        return 2.0 * (length - 4.0) * (tip[0] * line[1] - tip[1] * line[0]) / length - 1.5

    angle = brentq(unbalance, 1e-6, 1.0)
    found = scene.solve(moments={lever: (0.0, 1.5, 0.0)})
    assert abs(found.rigid_motion(lever).rotation[1] / angle - 1) < BEARABLE
    linear = scene.solve(moments={lever: (0.0, 1.5, 0.0)}, finite_motion=False)
    assert any("move or turn far" in text for text in linear.warnings)
    # the rope's end goes down a circle: the length is off by what the tip's arc leaves out, 3 t^2 / 2 across
    assert linearisation_error(linear).direction == pytest.approx(3 * 0.0833**2 / 2 / 4, rel=0.1)


def test_motions_that_do_not_settle_are_warned_of(monkeypatch):
    monkeypatch.setattr(finite, "BEARABLE", 1e-30)
    monkeypatch.setattr(finite, "MAX_ITERATIONS", 1)
    result, ball = under_ball(3.0, motions={"z": -3.05, "x": 0.3}, finite_motion="auto")
    assert abs(result.rigid_motion(ball).translation[0] - 0.3) < 1e-12
    for error, warned in ((0.009, False), (0.011, True)):
        left = LinearisationError(error, 1.0, 0.0)
        texts = list(unborne_motions(replace(result, _linearisation=left)))
        assert ["does not mend it" in text for text in texts] == [True] * warned


def test_displacements_count_from_where_bodies_were_given(tmp_path):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    body = fc.ElasticBody(mesh, SOLID, "bottom", {"top": "xyz"}, name="block").placed((3.0, 1.0, 0.0))
    plane = fc.RigidBody(fc.Plane())
    turn = 0.7
    result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(motions={body: {"rz": turn, "z": -1e-3}})
    points = body.pose.to_world(body.mesh.points)
    centre = body.pose.to_world(body.reference_point)
    Q = fc.rotation_about((0, 0, 1), turn)
    expected = centre + (points - centre) @ Q.T + [0, 0, -1e-3] - points
    # besides the turn there are strains of 1e-3 of a unit block
    assert np.abs(result.displacement(body) - expected).max() < 2e-3
    assert np.abs(result.displacement(body)[:, :2] - expected[:, :2]).max() > 1e-5
    top = body.mesh.boundary_nodes("top")
    assert np.abs(result.displacement(body)[top] - expected[top]).max() < 1e-12
    side = body.mesh.face_nodes(body.mesh.faces("x_max"))
    middle = expected[side[:, :4]].mean(axis=(0, 1))
    assert np.abs(result.boundary_motion(body, "x_max") - middle).max() < 2e-3
    file = meshio.read(result.save(tmp_path / "turned.vtu"))
    low = file.points.min(axis=0)
    assert np.abs(low - points.min(axis=0)).max() < 1e-12
    assert np.abs(np.linalg.norm(file.point_data["displacement"], axis=1).max() - np.sqrt(2) * np.sin(turn / 2)) < 2e-3


def test_unknown_choice_is_refused():
    with refused(fc.InputError, "motion", "'yes'"):
        under_ball(motions={"z": -0.05}, finite_motion="yes")


def test_a_body_that_is_carried_along_by_its_deflection_is_shifted_by_its_mean():
    rng = np.random.default_rng(4)
    points, point = rng.normal(size=(40, 3)), np.array([3.0, -1.0, 2.0])
    shift, turn = np.array([0.3, -0.2, 0.5]), np.array([0.02, 0.01, -0.03])
    rigid = np.concatenate([shift, turn])
    nodes, forces = rng.choice(40, 12, replace=False), rng.uniform(0.1, 1.0, 12)
    weights = sp.csr_matrix((np.ones(12), nodes, np.arange(13)), shape=(12, 40))
    deflection = rng.normal(size=(40, 3))
    field = shift + np.cross(turn, points - point) + deflection
    found = _Motion(fc.RigidBody(fc.Plane()), point, rigid, field).in_contact(weights, points[nodes], forces)
    mean = forces @ deflection[nodes] / forces.sum()
    assert np.abs(found.motion - rigid - np.concatenate([mean, np.zeros(3)])).max() < 1e-12  # rounding


@pytest.mark.by_day("1")
@pytest.mark.parametrize("level", [1, 2])
def test_a_quarter_of_a_ball_is_judged_like_the_whole(level):
    # the slope of an indentation on a quarter of the contact is no turn, and nothing moves far
    hertz = fc.hertz.spheres(radii=(250.0, 250.0), materials=(SOLID, SOLID), force=30.0)
    mesh = fc.shapes.quarter_sphere(250.0, contact_radius=hertz.a, level=level)
    ball = fc.ElasticBody(mesh, SOLID, contact="cap", supports={"base": "xyz", "sym_x": "x", "sym_y": "y"})
    plane = fc.RigidBody(fc.Plane())
    result = fc.Scene([ball, plane], [fc.Contact(ball, plane)]).solve(forces={ball: (0, 0, -7.5)})
    assert result._originals == ()
    assert linearisation_error(result).worst < BEARABLE / 10


def dragged(depth, way, finite_motion):
    """A rigid roller of radius 1 pressed into a pad with friction, then dragged; four steps each."""
    mesh = fc.sections.rectangle((4.0, 2.0), (96, 24)).translated((-2.0, 0.0, -2.0))
    body = fc.PlaneBody(mesh, fc.Material(E=1.0, nu=0.3), "top", {"bottom": "xz"}, name="pad")
    roller = fc.RigidBody(fc.surfaces.Cylinder(1.0), name="roller")
    scene = fc.Scene([body, roller], [fc.Contact(body, roller, friction=0.3)])
    steps = [{"motions": {roller: {"x": 0.0, "z": -depth * k / 4}}} for k in (1, 2, 3, 4)]
    steps += [{"motions": {roller: {"x": way * k / 4, "z": -depth}}} for k in (1, 2, 3, 4)]
    return scene.solve_path(steps, finite_motion=finite_motion)[-1]


@pytest.mark.parametrize(("depth", "true"), [(0.02, 0.00280), (0.1, 0.01885)])
def test_a_contact_that_deflections_shift_is_judged(depth, true):
    """Poses do not take up that the pad is drawn along: normals stay, and the force of the drag is up to 17 % less.

    The true forces are of contact at the deformed nodes of the same mesh, 24 steps each, computed apart from here.
    """
    result = dragged(depth, depth, True)
    contact = result.contacts[0]
    assert contact.friction.sliding[contact.active].all()
    error = (true - contact.force[0]) / np.linalg.norm(contact.friction.forces, axis=1).sum()
    assert 0.8 < linearisation_error(result).friction / error < 1.25
    texts = [text for text in result.warnings if "turn far" in text]
    assert len(texts) == (error > 0.1)
    assert all("change tractions of friction by 16 %" in text and "fecontact.ancf" in text for text in texts)


def test_what_sticks_is_better_left_where_it_was_paired():
    """What sticks goes along with the roller: small motions are true, and poses that only the roller has are not."""
    small, carried = (dragged(0.1, 0.03, finite) for finite in (False, True))
    assert linearisation_error(small).friction < 0.01 < 0.1 < linearisation_error(carried).friction
    assert linearisation_error(small).deflected > 1
    assert not any("turn far" in text for text in small.warnings)
    # contact at the deformed nodes of the same mesh, 24 steps each, computed apart from here: 0.01123
    assert abs(small.contacts[0].force[0] / 0.01123 - 1) < 0.01


def test_how_far_deflections_turn_normals_does_not_depend_on_the_axes():
    """A roller on a block, and both turned: a random scene of bricks had its poses carried along in one only."""

    def bound(turn):
        body = pad().placed((0.0, 0.0, 0.0), turn)
        roller = fc.RigidBody(fc.surfaces.Cylinder(RADIUS)).placed((0.0, 0.0, 0.0), turn)
        down = dict(zip("xyz", turn @ [0.0, 0.0, -0.05], strict=True))
        result = fc.Scene([body, roller], [fc.Contact(body, roller)]).solve(motions={roller: down}, finite_motion=False)
        frames = enumerate(result._loading.frames)
        moved = {id(f.body): _Motion(f.body, f.point, np.zeros(6), _driven(result, k, np.zeros(6))) for k, f in frames}
        return _turn_by_deflection(result._interfaces[0], result.contacts[0], moved)

    straight, turned = bound(np.eye(3)), bound(fc.rotation_about((1.0, 2.0, 3.0), 0.8))
    assert straight > 1e-4
    assert abs(turned / straight - 1) < 1e-9
