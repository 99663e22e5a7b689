"""Friction in scenes: load paths, stick and slip of blocks, refusals."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
from common_scenes import BLOCK_ON_FLOOR
from refusals import refused

import fecontact as fc
from fecontact.contact.loads import LoadStep
from fecontact.scene import load_path
from fecontact.scene.export import export_problem
from fecontact.scene.load_path import LoadPath


def dragged(mu: float, **options: object) -> tuple[fc.Scene, fc.ElasticBody]:
    """A unit block on a floor, held at its top."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    return fc.Scene([block, floor], [fc.Contact(block, floor, friction=mu, **options)]), block


def sloping(mu: float, angle: float) -> tuple[fc.Scene, dict[str, tuple[float, float, float]]]:
    """A free block of weight 4.9 on a slope."""
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (3, 3, 2))
    block = fc.ElasticBody(mesh, fc.Material(E=1e3, nu=0.3, density=1.0), contact="bottom")
    floor = fc.RigidBody(fc.Plane())
    pull = 9.81 * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    return fc.Scene([block, floor], [fc.Contact(block, floor, friction=mu)]), {"gravity": pull}


def test_a_dragged_block_slides_at_mu_times_the_force() -> None:
    scene, block = dragged(0.3)
    path = scene.solve_path([{"motions": {block: {"z": -0.01, "x": x}}} for x in (0.0, 0.02, 0.0)])
    np.testing.assert_allclose(path.forces[:, 0, 0], [0.0, -0.003, 0.003], atol=1e-14)
    np.testing.assert_allclose(path.forces[:, 0, 2], 0.01, atol=1e-14)
    assert (path.friction_work[1:] > 0).all()
    c = path[1].contacts[0]
    spent = 0.3 * (c.pressure * np.linalg.norm(c.friction.slip, axis=1)) @ c.weights
    assert abs(path.friction_work[1, 0] / spent - 1) < 1e-12
    # the wear depth is k p |s|: all pressure slides
    worn = path.wear_depth(0, 2.0) - 2.0 * sum(
        s.contacts[0].pressure * np.linalg.norm(s.contacts[0].friction.slip, axis=1) for s in path.steps
    )
    assert np.abs(worn).max() < 1e-12 * path.wear_depth(0, 2.0).max()


def test_the_order_of_loads_matters() -> None:
    """Pressed and then dragged, or both at once: the tractions differ; the first is what a path gives."""
    scene, block = dragged(0.8)
    steps = [{"motions": {block: {"z": -0.01}}}, {"motions": {block: {"z": -0.01, "x": 0.002}}}]
    path = scene.solve_path(steps)
    assert path[1].contacts[0].friction.sticking.all()
    once = scene.solve(motions={block: {"z": -0.01, "x": 0.002}})
    assert abs(once.contacts[0].force[0] / path[1].contacts[0].force[0] - 1) < 1e-9  # sticking: the same here
    released = scene.solve_path([*steps, {"motions": {block: {"z": -0.01}}}])
    assert abs(released[2].contacts[0].force[0]) < 1e-14  # no slip: it comes back
    assert abs(released.friction_work).max() < 1e-14


def test_a_block_on_a_slope_stays_or_slides() -> None:
    angle = 0.3
    scene, load = sloping(0.32, angle)
    path = scene.solve_path([load] * 4)
    c = path[3].contacts[0]
    np.testing.assert_allclose(c.friction.force, [-4.905 * np.sin(angle), 0, 0], atol=1e-12)
    assert abs(c.total_force - 4.905 * np.cos(angle)) < 1e-12
    # no creep: later steps under the same load do not slip
    first = np.abs(path[0].contacts[0].friction.slip).max()
    for step in path.steps[1:]:
        assert np.abs(step.contacts[0].friction.slip).max() < 1e-9 * first
    scene, load = sloping(0.30, angle)
    with refused(fc.SupportError, "slides-as-a-whole", f"{np.tan(angle):.3g}"):
        scene.solve(**load)


@pytest.mark.parametrize("cells", [((2, 2, 2), (3, 3, 2)), ((3, 3, 2), (3, 3, 2))])
def test_full_slip_on_faces_that_match_or_not(cells: tuple[tuple[int, ...], tuple[int, ...]]) -> None:
    """Friction is mu times the pressure at every point, and equal and opposite on both bodies."""
    above, below = (fc.shapes.block((1.0, 1.0, 1.0), n) for n in cells)
    top = fc.ElasticBody(
        above.translated((0, 0, 1.0)), fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"}
    )
    low = fc.ElasticBody(below, fc.Material(E=1.0, nu=0.0), contact="top", supports={"bottom": "xyz"})
    mu, p = 0.3, 0.01
    scene = fc.Scene([top, low], [fc.Contact(top, low, friction=mu)])
    path = scene.solve_path([{"motions": {top: {"z": -2 * p, "x": x}}} for x in (0.0, 0.5)])
    c = path[1].contacts[0]
    assert c.friction.sliding.all()
    traction = np.linalg.norm(c.friction.traction, axis=1)
    np.testing.assert_allclose(traction, mu * c.pressure, rtol=1e-10)
    assert abs(np.linalg.norm(c.friction.force) - mu * c.total_force) < 1e-10 * c.total_force
    np.testing.assert_allclose(path[1].reaction(low)[:3], c.force, atol=1e-10 * p)


def test_patch_of_stick_on_faces_that_do_not_match() -> None:
    """Two blocks that stick stretch like one: simple shear by the sides gives a uniform traction on the interface."""
    mu, tau, p = 5.0, 1e-3, 0.01
    top = fc.ElasticBody(
        fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)).translated((0, 0, 1.0)),
        fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"},
    )  # fmt: skip
    low = fc.ElasticBody(
        fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 2)), fc.Material(E=1.0, nu=0.0), contact="top",
        supports={"bottom": "xyz"},
    )  # fmt: skip
    scene = fc.Scene([top, low], [fc.Contact(top, low, friction=mu)])
    # shear stress tau_xz on the sides x = 0 and 1 completes the uniform field
    sides = {(b, s): (0, 0, f) for b in (top, low) for s, f in (("x_min", -tau), ("x_max", tau))}
    pressed = {"motions": {top: {"z": -2 * p}}}
    # u_x = 4 tau (1 + nu) / E at the top, over both heights
    path = scene.solve_path([pressed, {"motions": {top: {"z": -2 * p, "x": 4 * tau}}, "forces": sides}])
    c = path[1].contacts[0]
    assert c.friction.sticking.all()
    np.testing.assert_allclose(c.friction.traction[:, 0], -tau, rtol=1e-9)
    np.testing.assert_allclose(c.pressure, p, rtol=1e-9)


def test_what_is_not_offered_is_refused() -> None:
    scene, block = dragged(0.3)
    motions = {block: {"z": -0.01}}
    with refused(fc.InputError, "motion", "'auto'"):
        scene.solve_path([{"motions": motions}], finite_motion="auto")
    with refused(fc.InputError, "input", "has no file"):
        scene.solve_path([{"motions": motions}], "path.jsonl", accuracy=0.05)
    with refused(fc.InputError, "limit-without-accuracy"):
        scene.solve_path([{"motions": motions}], max_dofs=1000)
    with refused(fc.InputError, "solver"):
        scene.solve(motions=motions, solver="wolfe")
    with refused(fc.InputError, "solver", "solver of its own"):
        scene.sweep([{"motions": motions, "solver": "wolfe"}])
    with refused(fc.InputError, "no-steps"):
        scene.solve_path([])
    with refused(fc.InputError, "input", "Step 1", "'motion'"):
        scene.solve_path([{"motion": motions}])
    with refused(fc.InputError, "input", "no place for friction"):
        export_problem(scene, "problem.npz", motions=motions)
    cartilage = fc.ElasticLayer(fc.Material(E=1.0, nu=0.3), 0.1, (block.mesh, "bottom"))
    ball = fc.RigidBody(fc.Sphere(1.0))
    with refused(fc.InputError, "friction-normal-only"):
        fc.Scene([cartilage, ball], [fc.Contact(cartilage, ball, friction=0.3)]).solve(forces={ball: (0, 0, -1e-3)})
    smooth, block = dragged(0.0)
    with refused(fc.InputError, "input", "No contact has friction"):
        smooth.solve_path([{"motions": {block: {"z": -0.01}}}])


@pytest.mark.parametrize("mu", [-0.1, float("nan"), "0.3", None])
def test_senseless_friction_is_refused(mu: object) -> None:
    with refused(fc.InputError, "friction", "zero or positive"):
        dragged(mu)  # type: ignore[arg-type]


def test_a_step_that_cannot_be_held_has_its_number() -> None:
    scene, block = dragged(0.3)
    press = {"forces": {block: (0, 0, -0.01)}, "free": {block: "x"}}
    with refused(fc.SupportError, "slides-as-a-whole", "Step 2", "of 2"):
        scene.solve_path([press, {"forces": {block: (0.0031, 0, -0.01)}, "free": {block: "x z"}}])


def test_a_torque_is_held_up_to_the_limit_of_its_pressures() -> None:
    """A square block under a uniform pressure: mu times the mean distance from its centre; nothing is cut beyond it.

    The cones of friction alone would allow pressures at the corners, which hold twice as much.
    """
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (4, 4, 1)).translated((-0.5, -0.5, 0.0))
    block = fc.ElasticBody(mesh, fc.Material(E=1e3, nu=0.0), "bottom", name="block")
    floor, press = fc.RigidBody(fc.Plane()), {block: (0.0, 0.0, -1.0)}
    scene = fc.Scene([block, floor], [fc.Contact(block, floor, friction=0.3)])
    mean = (np.sqrt(2) + np.arcsinh(1.0)) / 6
    steps = [{"forces": press}, {"forces": press, "moments": {block: (0.0, 0.0, 0.99 * 0.3 * mean)}}]
    path = scene.solve_path(steps)
    assert path.cuts == (1, 1)
    steps[1]["moments"] = {block: (0.0, 0.0, 1.1 * 0.3 * mean)}
    # 0.33 to 2 %: pressures follow the torque, and the mean distance is a sum over points
    with refused(fc.SupportError, "slides-as-a-whole", "block: rotation about z", "holds 0.9"):
        scene.solve_path(steps)


def test_a_result_tells_its_friction(tmp_path) -> None:
    scene, block = dragged(0.3)
    path = scene.solve_path([{"motions": {block: {"z": -0.01}}}, {"motions": {block: {"z": -0.01, "x": 0.02}}}])
    text = str(path[1])
    assert "friction, mu 0.3" in text
    assert "area stuck, sliding" in text
    assert ", cone " in text
    assert len(str(path).splitlines()) == 3
    told = path[1].summary()
    assert abs(told["contacts"][0]["friction"]["slip_area"] - 1) < 1e-12
    assert told["residuals"]["cone"] < 1e-10
    lines = path[1].save(tmp_path / "points.csv").read_text().splitlines()
    assert lines[0].endswith("tx,ty,tz,sx,sy,sz,state")
    assert all(line.endswith("slip") for line in lines[1:])
    figure = path[1].plot("friction", tmp_path / "friction.png")
    assert (tmp_path / "friction.png").stat().st_size > 5000
    assert "traction of friction" in {axes.get_ylabel() for axes in figure.axes}


def test_what_sticks_keeps_its_place_and_slip_below_rounding_adds_up() -> None:
    """In 10 shakes points that stick keep their displacement to the last bit; 30 slips of 1e-11 are one of 3e-10.

    Each of these is below the rounding of the displacements, 1e-9 of 0.02, by which the sum may be off.
    """
    scene, block = dragged(0.8)
    shakes = [{"motions": {block: {"z": -0.01, "x": 0.002, "y": 1e-3 * (-1) ** k}}} for k in range(10)]
    frictions = [result.contacts[0].friction for result in scene.solve_path(shakes).steps]
    assert all(f.sticking.all() for f in frictions)
    across = frictions[0].moved[:, :2]  # the master's axes are the world's
    assert all((f.moved[:, :2] == across).all() for f in frictions[1:])
    scene, block = dragged(0.3)
    places = [0.0, *(0.02 + 1e-11 * np.arange(31))]
    path = scene.solve_path([{"motions": {block: {"z": -0.01, "x": x}}} for x in places])
    slid = path[-1].contacts[0].friction.moved - path[1].contacts[0].friction.moved
    assert np.abs(slid[:, 0] - 3e-10).max() < 2.1e-11


def test_loads_at_once_are_noted_and_a_path_is_not() -> None:
    scene, block = dragged(0.3)
    motions = {"motions": {block: {"z": -0.01, "x": 0.001}}}
    assert any("order of loads" in text for text in scene.solve(**motions).notes)
    assert not any("order of loads" in text for text in scene.solve_path([motions])[0].notes)


def pressed_and_dragged(n: int, finite_motion: bool = False, path: Path | None = None) -> LoadPath:
    """A rigid roller pressed into a pad in n steps, then dragged in two, by a fifth of the depth in all."""
    mesh = fc.sections.rectangle((4.0, 2.0), (96, 16)).translated((-2.0, 0.0, -2.0))
    pad = fc.PlaneBody(mesh, fc.Material(E=1.0, nu=0.3), "top", {"bottom": "xz"}, name="pad")
    roller = fc.RigidBody(fc.surfaces.Cylinder(1.0), name="roller")
    scene = fc.Scene([pad, roller], [fc.Contact(pad, roller, friction=0.3)])
    places = [(0.0, k / n) for k in range(1, n + 1)] + [(0.1, 1.0), (0.2, 1.0)]
    steps = [{"motions": {roller: {"x": 0.06 * x, "z": -0.06 * z}}} for x, z in places]
    return scene.solve_path(steps, path, finite_motion=finite_motion)


@pytest.mark.parametrize("finite_motion", [False, pytest.param(True, marks=pytest.mark.full)])
def test_large_steps_are_warned_of(finite_motion: bool, tmp_path: Path) -> None:
    """Points that a step presses anew slip from where it began; what sticks keeps the error while it sticks."""
    true, file = pressed_and_dragged(16, finite_motion), tmp_path / "path.jsonl"
    assert not any("steps are large" in text for result in true for text in result.warnings)
    for n in (1, 4):
        path = pressed_and_dragged(n, finite_motion, file if n == 1 else None)
        for k in (-3, -1):  # pressed, dragged
            found, known = (p[k].contacts[0].friction for p in (path, true))
            error = np.linalg.norm((found.forces - known.forces).T / np.sqrt(known.weights))
            error /= np.linalg.norm(known.forces.T / np.sqrt(known.weights))
            (text,) = (text for text in path[k].warnings if "steps are large" in text)
            told = int(re.search(r"by about (\d+) %", text)[1]) / 100  # type: ignore[index]
            assert 0.8 < told / error < 3
    resumed = pressed_and_dragged(1, finite_motion, file)
    assert all("steps are large" in result.warnings[-1] for result in resumed)


def test_steps_of_alike_rollers_are_not_solved_in_halves(monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction does not act as bodies that are alike are pressed: no solution is added to those of the steps."""
    solved = load_path.solved
    asked = []
    monkeypatch.setattr(load_path, "solved", lambda *given: asked.append(0) or solved(*given))
    ring = fc.sections.rectangle((4.0, 1.0), (32, 8)).translated((-2.0, 0.0, -1.0))
    bent = ring.mapped(lambda x: x - np.stack([0 * x[:, 0], 0 * x[:, 0], x[:, 0] ** 2 / 20], axis=1))
    lower = fc.PlaneBody(bent, fc.Material(E=1.0, nu=0.3), "top", {"bottom": "xz"}, name="lower")
    upper = lower.placed(rotation=fc.rotation_about((0, 1, 0), np.pi), name="upper")
    scene = fc.Scene([lower, upper], [fc.Contact(lower, upper, friction=0.3)])
    path = scene.solve_path([{"motions": {upper: {"z": -0.02}}}, {"motions": {upper: {"z": -0.02, "x": 0.001}}}])
    assert len(asked) == 2
    assert not any("steps are large" in text for text in path[-1].warnings)


def test_pictures_of_friction_need_friction() -> None:
    scene, block = dragged(0.0)
    with refused(fc.InputError, "input", "without friction"):
        scene.solve(motions={block: {"z": -0.01}}).plot("friction")


def fails_at_the_second_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second step that is solved finds no solution."""
    given, calls = load_path.solved, []

    def failing(*args: object) -> object:
        calls.append(args)
        if len(calls) == 2:
            raise fc.SolverError("no")
        return given(*args)

    monkeypatch.setattr(load_path, "solved", failing)


def test_a_step_without_certified_solution_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, block = dragged(0.3)
    steps = [{"motions": {block: {"z": -0.01}}}, {"motions": {block: {"z": -0.01, "x": 0.02}}}]
    whole = scene.solve_path(steps)
    halves = scene.solve_path([steps[0], {"motions": {block: {"z": -0.01, "x": 0.01}}}, steps[1]])

    fails_at_the_second_step(monkeypatch)
    cut = scene.solve_path(steps)
    assert cut.cuts == (1, 2)
    assert abs(cut.forces - whole.forces).max() < 1e-12  # full slip: the path does not matter
    # both halves count: work and wear are those of the same halves as steps
    assert abs(cut.friction_work[1, 0] / halves.friction_work[1:, 0].sum() - 1) < 1e-12
    np.testing.assert_allclose(cut.wear_depth(0, 2.0), halves.wear_depth(0, 2.0), rtol=1e-12)
    assert f"{cut.friction_work[1, 0]:.6g}" in str(cut[1])


@pytest.mark.parametrize("finite_motion", [False, True])
def test_an_interrupted_path_goes_on_as_if_it_had_not_been(finite_motion: bool, tmp_path) -> None:
    moves = np.random.default_rng(0).uniform([-0.02, -0.02, -0.02], [0.02, 0.02, 0.0], size=(5, 3))
    file = tmp_path / "path.jsonl"

    def solved(n: int, to: object, first: float = 1.0, **options: object) -> object:
        scene, block = dragged(0.3)
        given = [{"motions": {block: dict(zip("xyz", move, strict=True))}} for move in first * moves[:n]]
        return scene.solve_path(given, to, **{"finite_motion": finite_motion, **options})

    whole = solved(5, None)
    solved(3, file)
    with file.open("a") as rows:
        rows.write('{"name": "4", "half of a row')
    again = solved(5, file)
    assert [step.friction.nit for step in again.steps[:3]] == [0, 0, 0]  # certified, not solved
    np.testing.assert_allclose(again.forces, whole.forces, rtol=1e-12, atol=1e-16)
    np.testing.assert_allclose(again.friction_work, whole.friction_work, rtol=1e-12, atol=1e-18)
    assert len(file.read_text().splitlines()) == 5
    for change, what in (({"first": 1.1}, "motions"), ({"finite_motion": not finite_motion}, "finite_motion")):
        with refused(fc.InputError, "row-of-another", "'1'", what):
            solved(5, file, **change)


def test_a_step_is_of_another_path_if_one_before_it_changed(tmp_path) -> None:
    scene, block = dragged(0.3)
    file = tmp_path / "path.jsonl"
    press, drag = {"motions": {block: {"z": -0.01}}}, {"motions": {block: {"z": -0.01, "x": 0.02}}}
    scene.solve_path([press, drag, press], file)
    lines = file.read_text().splitlines(keepends=True)
    file.write_text("".join(lines[1:]))
    with refused(fc.InputError, "row-of-another", "the steps before"):
        scene.solve_path([drag, drag, press], file)
    for earlier in ('{"name": "1", "fingerprint": {}}\n', lines[0].replace('"format"', '"old"')):
        file.write_text(earlier)
        with refused(fc.InputError, "row-of-another"):
            scene.solve_path([press], file)


def test_loads_half_way_between_two_steps() -> None:
    body, at = object(), np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    one = LoadStep({body: (1.0, 0.0, 0.0)}, tractions={body: lambda x: 2 * x}, motions={body: {"x": 1.0}})
    other = LoadStep(tractions={body: (0.0, 0.0, 4.0)}, gravity=(0.0, 0.0, -2.0), motions={body: {"z": 2.0}})
    half = one.between(other, 0.5)
    np.testing.assert_array_equal(half.tractions[body](at), np.add(at, [0.0, 0.0, 2.0]))
    np.testing.assert_array_equal(one.between(LoadStep(), 0.5).tractions[body](at), at)
    np.testing.assert_array_equal(half.forces[body], [0.5, 0.0, 0.0])
    np.testing.assert_array_equal(half.gravity, [0.0, 0.0, -1.0])
    assert half.motions[body] == {"x": 0.5, "z": 1.0}


def pressed_pad(n: int) -> tuple[fc.Scene, fc.RigidBody]:
    """A ball over a pad of n by n cells, held at its base."""
    mesh = fc.shapes.block((2.0, 2.0, 0.6), (n, n, 2)).translated((-1.0, -1.0, -0.6))
    pad = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), "top", {"bottom": "xyz"}, name="pad")
    ball = fc.RigidBody(fc.Sphere(3.0), name="ball")
    return fc.Scene([pad, ball], [fc.Contact(pad, ball, friction=0.3)]), ball


def test_cases_of_a_sweep_are_single_steps() -> None:
    scene, ball = pressed_pad(6)
    cases = [{"motions": {ball: {"z": -0.1, "x": x}}} for x in (0.012, 0.05)]
    for row, case in zip(scene.sweep(cases), cases, strict=True):
        alone = scene.solve(**case).summary()
        np.testing.assert_allclose(row["contacts"][0]["force"], alone["contacts"][0]["force"], atol=1e-12)
        assert (
            abs(row["contacts"][0]["friction"]["friction_work"] - alone["contacts"][0]["friction"]["friction_work"])
            < 1e-14
        )
        assert any("order of loads" in note for note in row["notes"])


def test_a_path_to_an_accuracy() -> None:
    """Meshes are divided by the last step, pressure and tractions; the forces are those of a uniformly fine mesh."""
    scene, ball = pressed_pad(4)
    steps = [{"motions": {ball: {"z": -0.1, "x": x}}} for x in (0.0, 0.012)]
    path = scene.solve_path(steps, accuracy=0.3)
    assert path[-1].convergence.met
    assert path[-1].n_dofs > scene.solve_path(steps)[-1].n_dofs
    assert max(step.friction.residuals.worst for step in path.steps) < 1e-10
    fine, other = pressed_pad(12)
    exact = fine.solve_path([{"motions": {other: step["motions"][ball]}} for step in steps])
    size = exact.forces[1, 0, 2]
    coarse = np.abs(scene.solve_path(steps).forces - exact.forces).max() / abs(size)
    assert np.abs(path.forces - exact.forces).max() / abs(size) < min(0.01, coarse / 3)
    assert (
        path[0].displacement(path[0].solved(scene.bodies[0])).shape
        == path[1].displacement(path[1].solved(scene.bodies[0])).shape
    )


def test_a_cut_step_is_rebuilt(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, block = dragged(0.3)
    steps = [{"motions": {block: {"z": -0.01}}}, {"motions": {block: {"z": -0.01, "x": 0.02}}}]
    fails_at_the_second_step(monkeypatch)
    cut = scene.solve_path(steps, tmp_path / "path.jsonl")
    again = scene.solve_path(steps, tmp_path / "path.jsonl")
    assert again.cuts == cut.cuts == (1, 2)
    np.testing.assert_array_equal(again.friction_work, cut.friction_work)
    np.testing.assert_allclose(again.wear_depth(0, 2.0), cut.wear_depth(0, 2.0), rtol=1e-12)
    assert cut.table()[1]["contacts"][0]["friction"]["friction_work"] == cut.friction_work[1, 0]
    slips = [found[1].contacts[0].friction.slip for found in (cut, again)]
    np.testing.assert_allclose(slips[1], slips[0], rtol=1e-12)


def test_the_coupling_of_the_first_step_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where loads suggest another coupling, its points would have no past."""
    above, below = (fc.shapes.block((1.0, 1.0, 1.0), (n, n, 2)) for n in (2, 3))
    soft = fc.Material(E=1.0, nu=0.0)
    top = fc.ElasticBody(above.translated((0, 0, 1.0)), soft, "bottom", {"top": "xyz"}, name="top")
    low = fc.ElasticBody(below, soft, "top", {"bottom": "xyz"}, name="low")
    scene = fc.Scene([top, low], [fc.Contact(top, low, friction=0.3)])
    steps = [{"motions": {top: {"z": -0.01, "x": x}}} for x in (0.0, 0.001)]
    kept, real, calls = scene.solve_path(steps), load_path.solved, []

    def other(model: object, *rest: object) -> object:
        calls.append(model)
        if len(calls) == 2:
            model = fc.Scene([top, low], [fc.Contact(top, low, friction=0.3, coupling="nodal")])
        return real(model, *rest)

    monkeypatch.setattr(load_path, "solved", other)
    found = scene.solve_path(steps)
    assert len(calls) == 3
    assert found[1].interfaces[0].pairing.coupling == kept[1].interfaces[0].pairing.coupling == "mortar"
    np.testing.assert_allclose(found.forces, kept.forces, rtol=1e-12, atol=1e-16)


def test_a_load_path_in_a_scene_file(tmp_path, written, capsys) -> None:
    from fecontact.app.cli import main

    text = f"""{BLOCK_ON_FLOOR}
    friction = FRICTION
    [[steps]]
    motions.block = {{z = -0.01}}
    [[steps]]
    motions.block = {{z = -0.01, x = 0.02}}
    [outputs]
    friction = "friction.png"
    """
    file = written(text.replace("FRICTION", "0.3"), "drag.toml")
    assert main(["solve", str(file)]) == 0
    assert "slip area" in capsys.readouterr().out
    assert (tmp_path / "friction.png").exists()
    file.write_text(text.replace("FRICTION", '"rough"'))
    assert np.isinf(fc.read_scene(file).scene.contacts[0].friction)
    file.write_text(text.replace("FRICTION", "-0.3"))
    with refused(fc.InputError, "scene-file"):
        fc.read_scene(file)
    file.write_text(text.replace("FRICTION", "0.3") + "[loads]\nmotions.block = {z = -0.01}\n")
    with refused(fc.InputError, "scene-file"):
        fc.read_scene(file)


def test_a_path_has_a_table_of_its_steps_with_maps_and_sides(tmp_path: Path) -> None:
    scene, block = dragged(0.3)
    path = scene.solve_path([{"motions": {block: {"z": -0.01, "x": x}}} for x in (0.0, 0.02, 0.0)])
    plane = fc.DividingPlane((0.25, 0.0, 0.0), (1.0, 0.0, 0.0), block, ("right", "left"))
    table = path.table([0.0, 0.5, 1.0], keep=("pressure", "friction"), split=plane)
    assert table.names == ("step 1", "step 2", "step 3")
    assert table.column("time").tolist() == [0.0, 0.5, 1.0]
    column = f"motions {block.name} x"
    assert table.column(column).tolist() == [0.0, 0.02, 0.0]
    np.testing.assert_allclose(table.column("force_x"), path.forces[:, 0, 0], atol=1e-14)
    np.testing.assert_allclose(table.column("friction_work"), path.friction_work[:, 0], atol=1e-14)
    # a quarter of a uniform pressure is on the left; once dragged, both sides have their friction
    np.testing.assert_allclose(table.column("left: force_z")[0], 0.0025, rtol=1e-9)
    for name in ("force_x", "force_z"):
        both = table.column(f"left: {name}") + table.column(f"right: {name}")
        np.testing.assert_allclose(both, table.column(name), atol=1e-14)
    np.testing.assert_allclose(table.column("left: force_x")[1], -0.3 * table.column("left: force_z")[1], rtol=1e-9)
    for result in path.steps:
        sides = result.contacts[0].split_by_plane((0.25, 0.0, 0.0), (1.0, 0.0, 0.0))
        np.testing.assert_allclose(sum(side.moment for side in sides), result.contacts[0].moment, atol=1e-14)
    tractions = [kept.values for kept in table.fields("friction")]
    np.testing.assert_allclose(tractions[1], 0.3 * table.fields("pressure")[1].values, rtol=1e-9)
    assert len(table.montage("friction").axes) == 4
    assert path.save(tmp_path / "path.csv").read_text().splitlines()[0].startswith("case,status,motions")
    with refused(fc.InputError, "times-differ", "are 3", "and 2"):
        path.table([0.0, 1.0])
    with refused(fc.InputError, "unknown-name", "suffix"):
        path.save(tmp_path / "path.txt")


def test_a_path_of_finite_motions_is_a_collection_for_paraview(tmp_path: Path) -> None:
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)).translated((-0.5, -0.5, 0.0))
    block = fc.ElasticBody(mesh, fc.Material(E=1e3, nu=0.0), contact="bottom", supports={"top": "xyz"}, name="block")
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([block, floor], [fc.Contact(block, floor, friction=0.3)])
    turns = (0.05, 0.1)
    path = scene.solve_path([{"motions": {block: {"z": -1e-3, "rz": t}}} for t in turns], finite_motion=True)
    path.save(tmp_path / "turn.pvd", times=turns)
    sets = ElementTree.parse(tmp_path / "turn.pvd").findall("./Collection/DataSet")
    assert [float(each.get("timestep", "")) for each in sets] == list(turns)
    for each, turn in zip(sets, turns, strict=True):
        read = meshio.read(tmp_path / each.get("file", ""))
        top = np.abs(read.points[:, 2] - 1.0) < 1e-9
        # the held top turns about the block's reference point on the axis of symmetry, and moves down
        moved = fc.rotation_about((0, 0, 1), turn) @ read.points[top].T - [[0.0], [0.0], [1e-3]]
        np.testing.assert_allclose(read.points[top] + read.point_data["displacement"][top], moved.T, atol=1e-9)
    with refused(fc.InputError, "input", "one time for each"):
        path.save(tmp_path / "turn.pvd", times=[1.0])
