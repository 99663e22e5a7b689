"""Wear of a scene's contacts along a path of loads, by Archard's law."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.common import wear as shared
from fecontact.solvers import ContactProblem, solve
from tests.refusals import refused

FAR = 1e3


@pytest.fixture
def uncut(monkeypatch):
    """Steps as they are given."""
    monkeypatch.setattr(shared, "WEAR_ERROR", np.inf)


def pressed(partner, friction=0.0, n=4, **options):
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (n, n, 2)).translated((-0.5, -0.5, 0.0))
    block = fc.ElasticBody(mesh, fc.Material(E=1e3, nu=0.3), contact="bottom", supports={"top": "xyz"})
    contact = fc.Contact(block, partner, friction=friction, **options)
    return fc.Scene([block, partner], [contact]), contact


def slid(scene, contact, distances, force, k, **options):
    ball = scene.bodies[1]
    steps = [{"forces": {ball: (0, 0, force)}, "motions": {ball: {"x": x}}} for x in distances]
    return scene.solve_path(steps, wear={contact: k}, **options)


def fretted(k_s, steps, n=6):
    """A ball to and fro by a thousandth on a block, without friction: worn by a total k s in some steps."""
    ball = fc.RigidBody(fc.Sphere(5.0)).placed(rotation=fc.rotation_about((1.0, 0.0, 0.0), np.pi))
    scene, contact = pressed(ball, n=n, coupling="nodal")
    ends = [{"forces": {ball: (0, 0, 10.0)}, "motions": {ball: {"x": (-1) ** j * 5e-4}}} for j in range(steps + 1)]
    cycles = [{}, *[{"cycles": 1e6 / steps}] * steps]
    return scene.solve_path([{**end, **n} for end, n in zip(ends, cycles, strict=True)], wear={contact: k_s / 1e3})


@pytest.mark.parametrize(("friction", "coupling"), [(0.0, "nodal"), (0.2, "nodal"), (0.0, "mortar")])
def test_a_flat_block_wears_to_a_uniform_pressure_and_its_volume(friction, coupling, uncut):
    scene, contact = pressed(fc.RigidBody(fc.Plane()), friction, coupling=coupling)
    path = slid(scene, contact, (0.0, FAR), 10.0, 1e-1)
    found = path.last.contacts[0]
    assert abs(found.pressure / 10.0 - 1).max() < 1e-4
    # the face slips less than its partner is moved by what it gives
    given = 1e-1 * 10.0 * FAR
    assert path.worn_volume[1, 0] == pytest.approx(given, rel=2e-5)
    if friction == 0:
        assert path.worn_volume[1, 0] == pytest.approx(found.weights @ found.worn, rel=1e-12)
    assert path.last.warnings == ()


def test_three_implicit_steps_are_near_many_explicit_ones(uncut):
    total = 5e-3
    path = fretted(total, 3)
    # beside explicit steps on the condensed problem, by the slip that was found
    found, condensed = path.last.contacts[0], path.last.problem
    points = found._candidates
    area, g = found.weights[points], condensed.g - found.worn[points]
    pace = total * 1e3 * np.linalg.norm(found.friction.slip, axis=1)[points]

    def explicit(steps):
        worn = np.zeros(len(points))
        for _ in range(steps):
            forces = solve(ContactProblem(condensed.S, g + worn, condensed.B, condensed.F)).forces
            worn += pace / steps * forces / area
        return worn

    many = explicit(200)
    # the slip of the strained surface changes by as much while it wears
    assert found.worn_volume == pytest.approx(many @ area, rel=0.015)
    assert abs(found.worn[points] - many).max() < 0.02 * many.max()
    assert abs(explicit(10) - many).max() > 0.2 * many.max()


def test_cycles_count_the_slip_of_a_passage(uncut):
    scene, contact = pressed(fc.RigidBody(fc.Plane()), 0.3)
    floor = scene.bodies[1]
    ends = [{"forces": {floor: (0, 0, 1.0)}, "motions": {floor: {"x": x}}} for x in (-0.5, 0.5)]
    path = scene.solve_path([ends[0], {**ends[1], "cycles": 100.0}], wear={contact: 1e-6})
    slip = path.worn_volume[1, 0] - path.worn_volume[0, 0]
    assert slip == pytest.approx(1e-6 * 1.0 * 1.0 * 100, rel=2e-3)


def test_steps_are_cut_and_warned_of_by_their_error():
    path = fretted(1e-2, 1, 3)
    assert path.cuts[1] > 1
    assert 0 < path.last.contacts[0].wear_error < 0.1


@pytest.mark.parametrize(
    ("code", "options", "step"),
    [
        ("wear-alone", {"path": "worn.jsonl"}, {}),
        ("wear-alone", {"accuracy": 0.1}, {}),
        ("no-cycle", {}, {"cycles": 5.0}),
    ],
)
def test_what_is_not_offered_is_refused_by_name(code, options, step):
    scene, contact = pressed(fc.RigidBody(fc.Plane()))
    with refused(fc.InputError, code):
        scene.solve_path([step], wear={contact: 1.0}, **options)


def test_contacts_that_cannot_wear_are_refused():
    with refused(fc.InputError, "not-in-scene"):
        pressed(fc.RigidBody(fc.Plane()))[0].solve_path([{}], wear={pressed(fc.RigidBody(fc.Plane()))[1]: 1.0})
    rough, sticking = pressed(fc.RigidBody(fc.Plane()), np.inf)
    with refused(fc.InputError, "no-slip"):
        rough.solve_path([{}], wear={sticking: 1.0})
    half = fc.HalfSpace(fc.Material(E=1.0, nu=0.3))
    ball = fc.RigidBody(fc.Sphere(5.0)).placed((0.0, 0.0, 5.0))
    touch = fc.Contact(half, ball)
    with refused(fc.InputError, "wear-body", "press_path"):
        fc.Scene([half, ball], [touch]).solve_path([{}], wear={touch: 1.0})


def test_wear_afterwards_is_refused_where_the_shape_has_worn(uncut):
    scene, contact = pressed(fc.RigidBody(fc.Plane()), 0.2)
    path = slid(scene, contact, (0.0, 1.0), 1.0, 1e-6)
    with refused(fc.InputError, "worn-already"):
        path.wear_depth(0, 1.0)
