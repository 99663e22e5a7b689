"""Load paths and sweeps of scenes with laws of finite strain: back to rest, work and energy, resumed, one step."""

from __future__ import annotations

import json

import numpy as np
import pytest

import fecontact as fc
from fecontact.contact.loads import LoadStep
from fecontact.scene.finite_strain import motions_between
from tests.refusals import refused


def pressed(mu=0.0, cells=2, supports=None):
    """A block on the ground below a plate."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (cells, cells, cells), element="hex8")
    law = fc.NeoHookean(E=1.0, nu=0.45)
    block = fc.ElasticBody(mesh, law, contact="top", supports=supports or {"bottom": "xyz"}, name="block")
    plate = fc.RigidBody(fc.Plane(), name="plate").placed((0, 0, -1.0)).placed(rotation=np.diag([1.0, -1, -1]))
    return block, plate, fc.Scene([block, plate], [fc.Contact(block, plate, friction=mu)])


def moved(plate, *places):
    """Steps to places (x, z)."""
    return [{"motions": {plate: {"x": x, "z": z}}} for x, z in places]


def test_a_body_without_friction_comes_back_to_rest() -> None:
    block, plate, scene = pressed()
    path = scene.solve_path(moved(plate, (0, -0.2), (0, -0.4), (0, -0.2), (0, 0.1)))
    assert np.abs(path[3].displacement(block)).max() < 1e-8
    assert path[3].strain_energy(block) < 1e-15
    assert not path.forces[3].any()
    assert np.abs(path[2].displacement(block) - path[0].displacement(block)).max() < 1e-8
    assert path[1].strain_energy(block) > 4 * path[0].strain_energy(block)
    assert np.abs(path.motions(plate)[:, 2] - [-0.2, -0.4, -0.2, 0.1]).max() < 1e-12
    # what a step leaves out goes back
    back = scene.solve_path([*moved(plate, (0, -0.2)), {}])
    assert np.abs(back.last.displacement(block)).max() < 1e-8


def test_a_path_of_one_step_is_a_solution() -> None:
    for mu in (0.0, 0.3):
        block, plate, scene = pressed(mu)
        (step,) = moved(plate, (0.02, -0.25))
        path, alone = scene.solve_path([step]), scene.solve(**step)
        assert np.abs(path[0].displacement(block) - alone.displacement(block)).max() < 1e-12
        assert np.abs(path[0].contacts[0].forces - alone.contacts[0].forces).max() < 1e-12
        assert [each.iterations for each in path[0].finite_strain] == [each.iterations for each in alone.finite_strain]
        assert not [text for text in path[0].notes if "order of loads" in text]


def test_steady_sliding_dissipates_the_work_and_keeps_the_energy() -> None:
    block, plate, scene = pressed(0.1, cells=1)
    path = scene.solve_path(moved(plate, (0, -0.2), (2.0, -0.2), (50.0, -0.2), (50.15, -0.2)))
    slow, fast = path[2], path[3]
    assert (path.friction_work >= 0).all()
    assert fast.strain_energy(block) == pytest.approx(slow.strain_energy(block), abs=1e-8)
    assert fast.reaction(plate)[0] == pytest.approx(0.1 * fast.contacts[0].total_force, rel=1e-8)
    assert path.friction_work[3, 0] == pytest.approx(0.15 * fast.reaction(plate)[0], rel=1e-7)


def test_work_is_the_energy_to_the_second_order_of_steps() -> None:
    missing = []
    for n in (2, 4, 8):
        block, plate, scene = pressed(cells=1)
        path = scene.solve_path(moved(plate, *((0, -0.3 * k / n) for k in range(1, n + 1))))
        force = np.concatenate([[0.0], -path.forces[:, 0, 2]])
        missing.append(0.3 / n * (force[1:] + force[:-1]).sum() / 2 / path.last.strain_energy(block) - 1)
    assert abs(missing[2]) < 4e-3
    assert np.abs(np.array(missing[:-1]) / missing[1:] - 4).max() < 0.2


@pytest.mark.parametrize("mu", [0.0, 0.1])
def test_a_resumed_path_is_the_uninterrupted_one(mu: float, tmp_path) -> None:
    """The second step, a release, is cut in parts; the file ends before it and after it."""
    block, plate, scene = pressed(mu, cells=1)
    steps = moved(plate, (0, -0.6), (0, -0.2), (0.1, -0.3))
    whole = scene.solve_path(steps, tmp_path / "whole")
    assert whole.cuts[1] > 1
    lines = (tmp_path / "whole").read_text().splitlines(keepends=True)
    for done in (1, 2):
        (tmp_path / "cut").write_text("".join(lines[:done]))
        resumed = scene.solve_path(steps, tmp_path / "cut")
        assert resumed.cuts == whole.cuts
        assert np.abs(resumed.forces - whole.forces).max() < 1e-9
        assert np.abs(resumed.friction_work - whole.friction_work).max() < 1e-9
        for one, other in zip(resumed, whole, strict=True):
            assert np.abs(one.displacement(block) - other.displacement(block)).max() < 1e-9
            assert [each.iterations for each in one.finite_strain] == [each.iterations for each in other.finite_strain]
    assert json.loads(lines[0])["contacts"][0]["force"] == pytest.approx(whole.forces[0, 0].tolist())
    with refused(fc.InputError, "row-of-another", "motions"):
        scene.solve_path(steps[1:], tmp_path / "whole")


def test_steps_turn_from_the_place_where_the_last_one_ended() -> None:
    body = fc.RigidBody(fc.Plane())
    quarter = np.pi / 2
    one, other = ({body: {"rx": a, "ry": b, "rz": 0.0}} for a, b in ((quarter, 0.0), (0.0, quarter)))
    first, then = (LoadStep.of({"motions": motions}) for motions in (one, other))
    change = motions_between(first, then, True)[body]
    turn = fc.rotation_about((0, 1, 0), quarter) @ fc.rotation_about((1, 0, 0), quarter).T
    angle = np.linalg.norm(list(change.values()))
    assert np.abs(fc.rotation_about(tuple(change.values()), angle) - turn).max() < 1e-12
    assert set(motions_between(first, then, False)[body].values()) == {0.0}
    # what is loaded is not moved back
    loaded = LoadStep.of({"forces": {body: (0, 0, 1.0)}})
    lifted = LoadStep.of({"motions": {body: {"x": 0.3, "z": 0.2}}})
    assert motions_between(lifted, loaded, True) == {body: {"x": -0.3}}
    assert motions_between(lifted, LoadStep.of({"free": {body: "x z"}}), True) == {body: {}}


def test_a_force_takes_over_from_a_motion() -> None:
    block, plate, scene = pressed()
    first = scene.solve_path(moved(plate, (0, -0.2)))
    force = first.last.reaction(plate)[2]
    path = scene.solve_path([{"motions": {plate: {"z": -0.2}}}, {"forces": {plate: (0, 0, force)}}])
    assert np.abs(path[1].displacement(block) - path[0].displacement(block)).max() < 1e-8
    assert path.motions(plate)[1, 2] == pytest.approx(-0.2, abs=1e-8)


def test_a_sweep_solves_each_case_from_rest() -> None:
    _, plate, scene = pressed(0.2)
    cases = [{"motions": {plate: {"z": z}}} for z in (-0.1, -0.2)]
    table = scene.sweep(cases)
    alone = [scene.solve(**case) for case in cases]
    forces = np.array([row["contacts"][0]["force"] for row in table.rows])
    assert np.abs(forces - [r.contacts[0].force for r in alone]).max() < 1e-12
    closer = {**cases[0], "accuracy": 0.5}
    divided = scene.sweep([closer]).rows[0]["contacts"][0]["force"]
    assert np.abs(divided - scene.solve(**closer).contacts[0].force).max() < 1e-12
    assert 0.8 < divided[2] / forces[0, 2] < 1
    with refused(fc.InputError, "finite-strain", "search"):
        scene.sweep([cases[0], {**cases[1], "search": "local"}])


def test_accuracy_is_refused_for_paths() -> None:
    _, plate, scene = pressed()
    with refused(fc.InputError, "finite-strain", "accuracy"):
        scene.solve_path(moved(plate, (0, -0.1)), accuracy=0.1)


def test_a_block_that_slides_off_its_partner_is_an_end_of_the_path_with_its_reason() -> None:
    """Between one step and the next no surface faces the other: the step is cut, and not answered without contact."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    body = fc.ElasticBody(mesh, fc.NeoHookean(E=1.0, nu=0.3), contact="bottom", supports={"top": "xyz"}, name="block")
    table = fc.RigidBody(fc.surfaces.FlatPunch(sides=(4.0, 4.0)), name="table").placed(rotation=np.diag([1.0, -1, -1]))
    scene = fc.Scene([body, table], [fc.Contact(body, table)])
    with refused(fc.SolverError, "not-facing", "Step 2 of 2", "'bottom' of 'block'", "'table'", "spring"):
        scene.solve_path([{"motions": {body: {"z": -0.1}}}, {"motions": {body: {"z": -0.1, "x": 9.0}}}])


def test_of_two_blocks_the_one_that_slides_off_is_told() -> None:
    """The other is pressed as before, and nothing is told before."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    law = fc.NeoHookean(E=1.0, nu=0.3)
    stays = fc.ElasticBody(mesh, law, contact="bottom", supports={"top": "xyz"}, name="stays").placed((-1.5, 0, 0))
    leaves = stays.placed((2.0, 0, 0), name="leaves")
    table = fc.RigidBody(fc.surfaces.FlatPunch(sides=(4.0, 4.0)), name="table").placed(rotation=np.diag([1.0, -1, -1]))
    scene = fc.Scene([stays, leaves, table], [fc.Contact(stays, table), fc.Contact(leaves, table)])
    steps = [{"motions": {stays: {"z": -0.1}, leaves: {"z": -0.1, "x": x}}} for x in (0.0, 9.0)]
    on, off = scene.solve_path(steps)
    told = [[text for text in each.warnings if "face each other any more" in text] for each in (on, off)]
    assert told[0] == []
    assert len(told[1]) == 1
    assert "'leaves'" in told[1][0]
    assert off.contacts[1].total_force == 0.0
    assert np.abs(off.displacement(leaves)[:, 2] + 0.1).max() < 1e-8
    assert off.contacts[0].total_force == pytest.approx(on.contacts[0].total_force, rel=1e-8)
