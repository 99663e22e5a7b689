"""Sweeps over local bodies: poses share the factor and the remainder, and give what single solutions give."""

import pickle

import numpy as np
import pytest

import fecontact as fc
from fecontact.bodies.local import body
from fecontact.bodies.local.pressed import BelowWindows
from fecontact.bodies.local.remainder import Factored

SOLID, AT = fc.Material(E=1.0, nu=0.3), (3.0, 2.0, 2.0)
FORCE = (0.0, 0.0, -0.01)


def local_block(supports=None, **given) -> fc.LocalBody:
    mesh = fc.shapes.block((6.0, 4.0, 2.0), (6, 4, 3))
    body = fc.ElasticBody(mesh, SOLID, supports={"bottom": "xyz"} if supports is None else supports, name="block")
    return fc.LocalBody(body, cells=(24, 24), **given)


def ball_at(x: float) -> fc.RigidBody:
    return fc.RigidBody(fc.Sphere(5.0), pose=fc.Pose(translation=(AT[0] + x, *AT[1:])), name="ball")


@pytest.mark.by_day("given0-1")
@pytest.mark.parametrize(("given", "remainders"), [({"at": AT, "window": 1.6}, 1), ({}, 3)])
def test_a_path_gives_what_single_poses_give(given: dict, remainders: int, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []

    def factored(model, origins, make=Factored.of):
        made.append("factor")
        return make(model, origins)

    def remainder(*arguments, make=body.remainder):
        made.append("remainder")
        return make(*arguments)

    monkeypatch.setattr(Factored, "of", factored)
    monkeypatch.setattr(body, "remainder", remainder)
    local, ball = local_block(**given), ball_at(0.0)
    path = (0.0, 0.15, 0.3)
    cases = [{"poses": {ball: ball_at(x).pose}, "forces": {ball: FORCE}, "finite_motion": False} for x in path]
    rows = fc.Scene([local, ball], [fc.Contact(local, ball)]).sweep(cases)
    assert made.count("factor") == 1
    assert made.count("remainder") == remainders
    for x, row in zip(path, rows, strict=True):
        alone, other = local_block(**given), ball_at(x)
        result = fc.Scene([alone, other], [fc.Contact(alone, other)]).solve(forces={other: FORCE}, finite_motion=False)
        expected = result.summary()
        for name in ("max_pressure", "area"):
            assert row["contacts"][0][name] == pytest.approx(expected["contacts"][0][name], rel=1e-10)
        np.testing.assert_allclose(row["contacts"][0]["force"], expected["contacts"][0]["force"], atol=1e-12)


def test_the_window_that_comes_back_has_its_remainder() -> None:
    local = local_block(at=AT, window=1.6)
    aside = local.with_window(np.array([2.8, 2.0, 2.0]), (1.6, 1.6))
    again = aside.with_window(np.array(AT), (1.6, 1.6))
    first = local.remainder
    assert aside.remainder is not first
    assert again.remainder is first
    assert again.with_window(np.array(AT), (1.5, 1.6)).remainder is not first


def test_a_floating_body_is_held_far_from_every_window() -> None:
    local = local_block(supports={}, at=AT, window=1.0)
    near = local.with_window(np.array([3.1, 2.0, 2.0]), (1.0, 1.0))
    assert near.factored is local.factored
    under = local.with_window(np.array([3.0, 2.0, 0.0]), (1.0, 1.0))
    held = np.setdiff1d(local.factored.held, local.body.model.held)
    assert (under.factored is local.factored) == local.factored.serves(under.window.origin)
    places = local.body.model.mesh.points[held // 3]
    assert not local.factored.serves(places[0])


def test_a_solved_body_can_be_sent_and_solves_there() -> None:
    local, ball = local_block(at=AT, window=1.6), ball_at(0.1)
    load = {(local, "x_max"): (0.0, 0.0, 0.001)}  # needs the factor
    here = fc.Scene([local, ball], [fc.Contact(local, ball)]).solve(forces={ball: FORCE, **load}, finite_motion=False)
    there = pickle.loads(pickle.dumps(local))
    result = fc.Scene([there, ball], [fc.Contact(there, ball)]).solve(
        forces={ball: FORCE, (there, "x_max"): (0.0, 0.0, 0.001)}, finite_motion=False
    )
    np.testing.assert_allclose(result.contacts[0].pressure, here.contacts[0].pressure, rtol=1e-9, atol=1e-12)


def test_displacements_of_nodes_are_the_fields_there() -> None:
    local = local_block(at=AT, window=1.6)
    p = np.random.default_rng(0).uniform(size=(24, 24))
    points = local.body.model.mesh.points
    expected = BelowWindows([(local.remainder, p)]).displacement(points)
    np.testing.assert_allclose(local._nodal_fields.displacement(p), expected, atol=1e-13 * np.abs(expected).max())
