"""Finite rigid motion and sweeps over poses and loads."""

import json

import numpy as np
import pytest
from common_scenes import knee
from refusals import refused

import fecontact as fc
from fecontact.scene import local_search

SOLID = fc.Material(E=1000.0, nu=0.3)


def pad(name="pad"):
    """A flat elastic pad with its base on a rigid plate."""
    mesh = fc.shapes.block((4.0, 4.0, 1.0), (8, 8, 2)).translated((-2.0, -2.0, -1.0))
    return fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}, name=name)


def test_far_off_ball_comes_down_and_gives_the_same_force_as_when_placed_there():
    plate, ball = pad(), fc.RigidBody(fc.Sphere(radius=5.0), name="ball")
    far = ball.placed((0.0, 0.0, 3.0))
    scene = fc.Scene([plate, far], [fc.Contact(plate, far)])
    result = scene.solve(motions={far: {"z": -3.05}}, finite_motion=True)
    near = ball.placed((0.0, 0.0, -0.05))
    direct = fc.Scene([plate, near], [fc.Contact(plate, near)]).solve(motions={near: {"z": 0.0}})
    # the same configuration reached in two ways: equal to rounding
    assert abs(result.contacts[0].total_force / direct.contacts[0].total_force - 1) < 1e-9
    assert abs(result.rigid_motion(far).translation[2] + 3.05) < 1e-12


def test_no_pose_is_solved_twice_where_whole_surfaces_are_paired_anyway(monkeypatch):
    plate, ball = pad(), fc.RigidBody(fc.Sphere(radius=5.0), name="ball").placed((0.0, 0.0, 3.0))
    heights, solved = [], local_search.solved
    monkeypatch.setattr(
        local_search, "solved", lambda s, *rest: heights.append(s.bodies[1].pose.translation[2]) or solved(s, *rest)
    )
    scene = fc.Scene([plate, ball], [fc.Contact(plate, ball)])
    scene.solve(forces={ball: (0.0, 0.0, -20.0)}, finite_motion=True)
    assert len(heights) == len(set(heights)) > 1


def test_ball_rolls_over_by_a_prescribed_turn_without_changing_the_force():
    # a sphere turned about its own centre presents the same surface: the force cannot change
    plate, ball = pad(), fc.RigidBody(fc.Sphere(radius=5.0), name="ball").placed((0, 0, -0.03))
    scene = fc.Scene([plate, ball], [fc.Contact(plate, ball)])
    still = scene.solve(motions={ball: {"z": 0.0}}).contacts[0].total_force
    # about its reference point, the pole, a turn by t moves the centre by R sin t and R (cos t - 1)
    angle = 0.3
    back = {"ry": angle, "x": -5.0 * np.sin(angle), "z": 5.0 * (1 - np.cos(angle))}
    turned = scene.solve(motions={ball: back}, finite_motion=True).contacts[0].total_force
    assert abs(turned / still - 1) < 1e-9


def test_loaded_free_ball_settles_in_a_trough_of_two_springs():
    # a free frame that must turn by a finite angle: a lever on a ligament, against its closed form
    lever = fc.RigidBody(fc.Plane(), name="lever")
    anchor = fc.Spring(2.0, (lever, (3.0, 0.0, 0.0)), (None, (3.0, 0.0, 4.0)), slack_length=4.0, name="rope")
    scene = fc.Scene([lever], [], springs=[anchor])
    result = scene.solve(moments={lever: (0.0, 1.5, 0.0)}, finite_motion=True)
    # equilibrium about the hinge in the turned pose: moment = tension x arm, solved by hand as an independent root
    from scipy.optimize import brentq

    def unbalance(t):
        tip = np.array([3 * np.cos(t), -3 * np.sin(t)])  # x, z after a turn t about y
        rope = np.array([3.0, 4.0]) - tip
        length = np.linalg.norm(rope)
        tension = 2.0 * (length - 4.0)
        return tension * (tip[0] * rope[1] - tip[1] * rope[0]) / length - 1.5

    angle = brentq(unbalance, 1e-6, 1.0)
    assert abs(result.rigid_motion(lever).rotation[1] / angle - 1) < 1e-6  # poses settle to 1e-6 of the displacement


def test_sweep_rows_equal_single_solutions_and_are_written(tmp_path):
    plate, ball = pad(), fc.RigidBody(fc.Sphere(radius=5.0), name="ball")
    scene = fc.Scene([plate, ball], [fc.Contact(plate, ball)])
    cases = [{"name": f"P{p}", "forces": {ball: (0, 0, -p)}} for p in (1.0, 5.0, 20.0)]
    cases.append({"name": "beside", "forces": {ball: (0, 0, -5.0)}, "poses": {ball: fc.Pose(translation=(0.5, 0, 0))}})
    rows = scene.sweep(cases, tmp_path / "sweep.jsonl")
    assert [r["name"] for r in rows] == ["P1.0", "P5.0", "P20.0", "beside"]
    for row, case in zip(rows[:3], cases[:3], strict=True):
        alone = scene.solve(forces=case["forces"]).summary()
        assert abs(row["contacts"][0]["max_pressure"] / alone["contacts"][0]["max_pressure"] - 1) < 1e-9
    assert abs(rows[3]["contacts"][0]["centre_of_pressure"][0] - 0.5) < 0.05
    assert len((tmp_path / "sweep.jsonl").read_text().splitlines()) == 4


def test_a_sweep_of_a_body_at_finite_strain_has_the_rows_of_single_solutions():
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (3, 3, 1), element="hex8")
    law = fc.NeoHookean(E=1.0, nu=0.45)
    soft = fc.ElasticBody(mesh, law, contact="top", supports={"bottom": "xyz"}, name="soft")
    ball = fc.RigidBody(fc.Sphere(radius=2.0), name="ball")
    scene = fc.Scene([soft, ball], [fc.Contact(soft, ball)])
    places = [(1.0, 1.0, 1.0 - depth) for depth in (0.1, 0.3)]
    rows = scene.sweep([{"poses": {ball: fc.Pose(translation=place)}} for place in places])
    for row, place in zip(rows, places, strict=True):
        there = ball.placed(place)
        alone = fc.Scene([soft, there], [fc.Contact(soft, there)]).solve().summary()
        assert abs(row["contacts"][0]["force"][2] / alone["contacts"][0]["force"][2] - 1) < 1e-12
    with refused(fc.InputError, "finite-strain", "search='local'"):
        scene.sweep([{"search": "local", "motions": {ball: {"z": -0.1}}}])


def test_interrupted_sweep_goes_on_where_it_stopped(tmp_path):
    plate, ball = pad(), fc.RigidBody(fc.Sphere(radius=5.0), name="ball")
    scene = fc.Scene([plate, ball], [fc.Contact(plate, ball)])
    cases = [{"name": str(p), "forces": {ball: (0, 0, -p)}} for p in (1.0, 2.0)]
    path = tmp_path / "sweep.jsonl"
    first = scene.sweep(cases[:1], path)[0]
    path.write_text(json.dumps({**first, "kept": True}) + '\n{"name": "2.0", "cut o')
    rows = scene.sweep(cases, path)
    assert rows[0] == {**json.loads(json.dumps(first)), "kept": True}
    assert abs(rows[1]["contacts"][0]["force"][2] + 2.0) < 1e-9 or abs(rows[1]["contacts"][0]["force"][2] - 2.0) < 1e-9


def pressed(E=1000.0, divisions=4, support="xyz", radius=5.0, coupling="auto", height=0.0, spring=2.0):
    """A ball on a pad on a spring, and one case: everything that a row of a sweep depends on can be varied."""
    mesh = fc.shapes.block((4.0, 4.0, 1.0), (divisions, 4, 1)).translated((-2.0, -2.0, -1.0))
    plate = fc.ElasticBody(mesh, fc.Material(E=E, nu=0.3, density=1.0), "top", {"bottom": support}, name="pad")
    ball = fc.RigidBody(fc.Sphere(radius=radius), name="ball").placed((0.0, 0.0, height))
    rope = fc.Spring(spring, (ball, (0.0, 0.0, 5.0)), (None, (0.0, 0.0, 9.0)), slack_length=4.0)
    scene = fc.Scene([plate, ball], [fc.Contact(plate, ball, coupling=coupling)], [rope])
    return scene, ball, {"name": "a", "motions": {ball: {"z": -0.02}}}


@pytest.mark.by_day(every=2)
@pytest.mark.parametrize(
    ("model", "case", "what"),
    [
        ({"E": 1001.0}, {}, "body 'pad'"),
        ({"divisions": 5}, {}, "body 'pad'"),
        ({"support": "z"}, {}, "body 'pad'"),
        ({"radius": 5.1}, {}, "body 'ball'"),
        ({"height": 0.001}, {}, "body 'ball'"),
        ({"coupling": "nodal"}, {}, "contacts"),
        ({"spring": 2.1}, {}, "springs"),
        ({}, {"motions": {"z": -0.03}}, "motions"),
        ({}, {"gravity": (0.0, 0.0, -1.0)}, "gravity"),
        ({}, {"poses": fc.Pose(translation=(0.1, 0.0, 0.0))}, "poses"),
        ({}, {"tolerance": 1e-8}, "tolerance"),
        ({}, {"solver": "nnls"}, "solver"),
        ({"E": 1001.0}, {"gravity": (0.0, 0.0, -1.0)}, "body 'pad', gravity"),
    ],
)
def test_rows_of_another_model_or_case_are_refused_by_name(model, case, what, tmp_path):
    path = tmp_path / "sweep.jsonl"
    scene, _, first = pressed()
    rows = scene.sweep([first], path)
    scene, ball, same = pressed()
    again = scene.sweep([{**same, "gravity": None, "solver": "auto", "forces": {}}], path)
    assert list(again) == json.loads(json.dumps(list(rows)))
    scene, ball, other = pressed(**model)
    case = {k: {ball: v} if k in ("motions", "poses") else v for k, v in case.items()}
    with refused(fc.InputError, "row-of-another", "'a'", "sweep.jsonl") as caught:
        scene.sweep([{**other, **case}], path)
    assert f"({what})" in str(caught.value)
    assert "another path" in str(caught.value)
    assert len(path.read_text().splitlines()) == 1


def test_rows_without_a_fingerprint_are_refused(written):
    scene, _, case = pressed()
    path = written(json.dumps({"name": "a", "status": "solved"}) + "\n", "sweep.jsonl")
    with refused(fc.InputError, "no-fingerprint", "'a'"):
        scene.sweep([case], path)


@pytest.mark.parametrize("processes", [1, 2])
def test_cases_for_bodies_that_are_not_in_the_scene_are_refused_by_name(processes, monkeypatch):
    monkeypatch.setattr(local_search, "solved", lambda *args: pytest.fail("solved before it was refused"))
    scene, ball, good = pressed()
    stranger = fc.RigidBody(fc.Sphere(radius=5.0), name="stranger")
    twin = ball.placed((0.0, 0.0, 0.0))  # equal, but another body
    for other, name in ((stranger, "stranger"), (twin, "ball")):
        for bad in (
            {"poses": {other: fc.Pose()}},
            {"forces": {other: (0.0, 0.0, -1.0)}},
            {"forces": {(other, "top"): (0.0, 0.0, -1.0)}},
            {"moments": {other: (0.0, 0.0, 1.0)}},
            {"motions": {other: {"z": 0.1}}},
            {"motions": {other: {"z": 0.1}}, "finite_motion": True},
            {"free": {other: "x"}},
            {"pressures": {(other, "top"): 1.0}},
        ):
            with refused(fc.InputError, "not-in-scene", "'bad'", f"'{name}'"):
                scene.sweep([good, {**bad, "name": "bad"}], processes=processes)
    with refused(fc.InputError, "load-key", "'bad'"):
        scene.sweep([good, {"name": "bad", "poses": {"ball": fc.Pose()}}], processes=processes)
    with refused(fc.InputError, "input", "'bad'"):
        scene.sweep([good, {"name": "bad", "poses": {ball: (0.0, 0.0, 1.0)}}], processes=processes)
    with refused(fc.InputError, "unknown-option", "'bad'", "force"):
        scene.sweep([good, {"name": "bad", "force": {ball: (0.0, 0.0, 1.0)}}], processes=processes)


def plain(row):
    """A row without what it says of the way to the answer: times, memory, and the points looked at."""
    way = ("seconds", "n_candidates", "rounds", "iterations", "saved", "condensation")
    return {k: v for k, v in row.items() if k not in way and "_mb" not in k and "memory" not in k}


@pytest.mark.full
def test_processes_give_the_same_rows_and_go_on_where_they_stopped(tmp_path):
    dome = fc.shapes.half_sphere(5.0, contact_radius=0.9, level=1)
    lower, ball = pad(), fc.ElasticBody(dome, SOLID, "cap", {"base": "xyz"}, name="ball")
    scene = fc.Scene([lower, ball], [fc.Contact(ball, lower)])
    cases = [
        {"name": f"{k}", "motions": {ball: {"z": -0.02}}, "poses": {ball: fc.Pose(translation=(0.2 * k, 0.1, 0.0))}}
        for k in range(4)
    ]
    one = scene.sweep(cases)
    path = tmp_path / "sweep.jsonl"
    scene.sweep(cases[:1], path)
    many = scene.sweep(cases, path, processes=2)
    assert sorted(json.loads(line)["name"] for line in path.read_text().splitlines()) == ["0", "1", "2", "3"]
    for a, b in zip(one, many, strict=True):
        for x, y in zip(numbers(plain(a)), numbers(plain(b)), strict=True):
            assert abs(x - y) <= 1e-12 * max(1.0, abs(x))
    alone = moved_alone(scene, cases[2])
    assert abs(one[2]["contacts"][0]["max_pressure"] / alone - 1) < 1e-9
    for wrong in (0, 1.5, True):
        with refused(fc.InputError, "not-whole", "processes"):
            scene.sweep(cases, processes=wrong)


def numbers(value):
    """All numbers in a row, in order."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [n for v in value for n in numbers(v)]
    return [value] if isinstance(value, (int, float)) else []


def moved_alone(scene, case):
    """Largest pressure of one case of a sweep, solved by itself on fresh bodies."""
    lower, ball = scene.bodies
    fresh = [fc.ElasticBody(b.mesh, SOLID, b.contact, b.model.supports, name=b.name) for b in (lower, ball)]
    fresh[1] = fresh[1].placed(case["poses"][ball].translation)
    result = fc.Scene(fresh, [fc.Contact(fresh[1], fresh[0])]).solve(motions={fresh[1]: {"z": -0.02}})
    return result.contacts[0].max_pressure


def test_sweep_refuses_equal_names_and_foreign_files(tmp_path):
    plate, ball = pad(), fc.RigidBody(fc.Sphere(radius=5.0), name="ball")
    scene = fc.Scene([plate, ball], [fc.Contact(plate, ball)])
    with refused(fc.InputError, "same-name"):
        scene.sweep([{"name": "a"}, {"name": "a"}])
    (tmp_path / "notes.txt").write_text("hello\nworld\n")
    with refused(fc.InputError, "bad-line", "a row of a sweep"):
        scene.sweep([{"name": "a"}], tmp_path / "notes.txt")
    assert (tmp_path / "notes.txt").read_text() == "hello\nworld\n"


@pytest.mark.full
def test_rows_of_a_sweep_of_flexion_are_those_of_whole_surfaces_solved_alone():
    scene, bone = knee()
    up = bone.pose.translation
    cases = [
        {
            "poses": {bone: fc.Pose(fc.rotation_about((1, 0, 0), angle), up)},
            "forces": {bone: (0.0, 0.0, -load)},
            "free": {bone: "ry"},
        }
        for angle, load in ((0.0, 300.0), (0.1, 900.0), (0.5, 150.0), (0.9, 600.0))
    ]
    rows = scene.sweep(cases)
    for row, case in zip(rows, cases, strict=True):
        fresh, other = knee()
        now = other.placed((0.0, 0.0, 0.0))
        object.__setattr__(now, "pose", case["poses"][bone])
        alone = fc.Scene([fresh.bodies[0], now], [fc.Contact(now, fresh.bodies[0])]).solve(
            forces={now: case["forces"][bone]}, free={now: "ry"}
        )
        whole = alone.summary()["contacts"][0]
        part = row["contacts"][0]
        assert part["slave"] == whole["slave"]
        # the same equations; differences are rounding times the condition of the compliance
        size = np.linalg.norm(whole["force"])
        assert np.abs(np.subtract(part["force"], whole["force"])).max() < 1e-9 * size
        assert np.abs(np.subtract(part["moment"], whole["moment"])).max() < 1e-9 * size * bone.size
        for name in ("area", "max_pressure", "mean_pressure"):
            assert abs(part[name] / whole[name] - 1) < 1e-9
        assert row["n_active"] == alone.n_active


def test_cases_write_their_files_and_those_that_cannot_are_refused_before_any_is_solved(tmp_path):
    plate, ball = pad(), fc.RigidBody(fc.Sphere(radius=5.0), name="ball")
    scene = fc.Scene([plate, ball], [fc.Contact(plate, ball)])
    loads = {"forces": {ball: (0, 0, -20.0)}}
    rows = tmp_path / "rows.jsonl"
    for wrong, code in (("a.txt", "unknown-name"), ("none/a.csv", "no-folder")):
        with refused(fc.InputError, code, "'1'"):
            scene.sweep([loads, {**loads, "save": [tmp_path / wrong]}], rows)
    assert not rows.exists()
    (row,) = scene.sweep([{**loads, "save": [tmp_path / "a.csv", tmp_path / "a.png"]}], rows)
    assert (tmp_path / "a.png").stat().st_size > 2000
    points = np.genfromtxt(tmp_path / "a.csv", delimiter=",", names=True)
    assert abs(abs(points["force"] @ points["nz"]) - 20.0) < 1e-9
    # files are no part of the case: the row is taken as it is
    assert list(scene.sweep([{**loads, "save": [str(tmp_path / "b.csv")]}], rows)) == [row]
    assert not (tmp_path / "b.csv").exists()
