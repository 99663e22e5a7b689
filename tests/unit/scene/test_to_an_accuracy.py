"""Solving to an accuracy: meshes are divided where the pressure needs it, limits stop it, everything carries over."""

import json
import re

import numpy as np
import pytest
from common_scenes import BALL_ON_BLOCK
from refusals import refused
from skfem import Basis, ElementHex1, ElementVector
from skfem.models.elasticity import lame_parameters, linear_elasticity

import fecontact as fc
from fecontact import read_scene
from fecontact.app.cli import main
from fecontact.bodies.elastic import of_one_model
from fecontact.scene import adaptive, finite_rotation
from fecontact.scene.adaptive import SAFETY, edge_points, facets_at, marked_cells
from fecontact.scene.cost import explain
from fecontact.surfaces import FlatPunch, Paraboloid

STEEL = fc.Material(E=1.0, nu=0.3)
RADIUS, CONTACT = 10.0, 0.5
#: Hertz: a rigid paraboloid on a half-space, a quarter of it.
FORCE = 4 * STEEL.plane_strain_modulus * CONTACT**3 / (3 * RADIUS) / 4
PEAK = 2 * STEEL.plane_strain_modulus * CONTACT / (np.pi * RADIUS)


def scene(element="hex20", **options):
    """A quarter of a block of 4 x 4 x 4, two faces a radius, and a rigid paraboloid under it."""
    x = np.array([0.0, 0.25, 0.5, 0.75, 1.2, 2.2, 4.0])
    mesh = fc.shapes.block((4.0, 4.0, 4.0), (x, x, x), element=element)
    held = {"x_min": "x", "y_min": "y", "top": "xyz"}
    block = fc.ElasticBody(mesh, STEEL, "bottom", held, name="block", **options)
    ball = fc.RigidBody(Paraboloid(RADIUS), name="ball").placed(rotation=fc.rotation_about((1, 0, 0), np.pi))
    return block, ball, fc.Scene([block, ball], [fc.Contact(block, ball)])


@pytest.fixture(scope="module")
def solved():
    block, ball, both = scene()
    return block, ball, both.solve(forces={block: (0, 0, -FORCE)}, accuracy=0.06)


def test_the_estimate_comes_within_the_accuracy(solved):
    _, _, result = solved
    steps = result.convergence.steps
    assert result.convergence.met
    assert SAFETY * steps[-1].pressure <= 0.06 < SAFETY * steps[-2].pressure
    assert [s.n_dofs for s in steps] == sorted(s.n_dofs for s in steps)
    assert steps[-1].n_dofs == result.n_dofs
    assert steps[-1].pressure == result.contacts[0].error_estimate.pressure


def test_the_error_is_within_the_accuracy(solved):
    _, _, result = solved
    contact = result.contacts[0]
    x, p, areas = contact.sampled(contact.pressure, 8)
    exact = PEAK * np.sqrt(np.maximum(1 - (np.hypot(x[:, 0], x[:, 1]) / CONTACT) ** 2, 0))
    assert np.sqrt((areas * (p - exact) ** 2).sum() / (areas * exact**2).sum()) < 0.06
    assert abs(contact.max_pressure / PEAK - 1) < 0.03
    assert abs(contact.force[2] / FORCE - 1) < 1e-9
    assert result.residuals().worst < 1e-9


def test_what_is_known_of_a_contact_is_its_edge(solved):
    """Source: Hertz's radius."""
    _, _, result = solved
    interface, radius = result._interfaces[0], np.hypot(*result.contacts[0].points.T[:2])
    known = adaptive._known(result.contacts[0], interface)
    chosen, inside = known.candidates(interface), known.touching(interface, np.arange(len(radius)))
    assert inside[radius < 0.98 * CONTACT].all()
    assert not inside[radius > 1.02 * CONTACT].any()
    assert set(np.flatnonzero(radius < 1.01 * CONTACT)) <= set(chosen)
    assert radius[chosen].max() < 1.1 * CONTACT
    assert known.touching(interface, chosen).sum() == inside.sum()


def test_results_are_asked_of_the_given_bodies(solved):
    block, ball, result = solved
    finer = result.solved(block)
    assert result.displacement(block).shape == finer.mesh.points.shape != block.mesh.points.shape
    assert abs(result.reaction(ball)[2] / FORCE - 1) < 1e-9
    assert result.stress(block).shape == (len(finer.mesh.points), 6)
    assert result.rigid_motion(ball).translation.shape == (3,)


def test_the_steps_are_printed_drawn_and_saved(solved, tmp_path):
    _, _, result = solved
    assert "Accuracy 0.06" in str(result)
    assert result.summary()["convergence"]["met"]
    assert len(result.plot("convergence", tmp_path / "steps.png").axes) == 2
    assert (tmp_path / "steps.png").stat().st_size > 0
    result.save(tmp_path / "fields.vtu")


def test_a_limit_of_unknowns_ends_with_the_best_answer():
    block, _, both = scene()
    result = both.solve(forces={block: (0, 0, -FORCE)}, accuracy=1e-3, max_dofs=6000)
    assert not result.convergence.met
    assert "max_dofs" in result.convergence.reason
    assert result.n_dofs <= 6000
    assert any("accuracy" in text for text in result.warnings)


def test_what_cannot_be_divided_says_so():
    half = fc.HalfSpace(STEEL, size=(2.0, 2.0), cells=(32, 32))
    ball = fc.RigidBody(Paraboloid(RADIUS))
    result = fc.Scene([half, ball], [fc.Contact(half, ball)]).solve(forces={ball: (0, 0, -4 * FORCE)}, accuracy=1e-4)
    assert not result.convergence.met
    assert "divided" in result.convergence.reason


def test_bodies_whose_cells_are_not_known_to_be_divisible_say_so():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    basis = Basis(mesh.to_skfem(), ElementVector(ElementHex1()), intorder=3)
    K = linear_elasticity(*lame_parameters(1.0, 0.3)).assemble(basis)
    held = {"bottom": "xyz"}
    given = fc.AssembledBody.from_skfem(basis, K, STEEL, contact="top", supports=held)
    for body in (given, fc.AncfBody(mesh, STEEL, "top", held)):
        ball = fc.RigidBody(Paraboloid(RADIUS)).placed((0.5, 0.5, 1.0))
        result = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -0.01}}, accuracy=0.01)
        assert "divided" in result.convergence.reason
        assert not result.convergence.met


@pytest.mark.parametrize("kind", ["bricks", "window"])
def test_an_error_of_the_force_that_is_not_estimated_is_not_met(kind):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (4, 4, 2), element="hex8").translated((-0.5, -0.5, -1.0))
    material, held, ball = fc.Material(1.0, 0.3), {"bottom": "xyz"}, fc.RigidBody(Paraboloid(2.0))
    body = fc.AncfBody(mesh, material, "top", held, name="soft")
    if kind == "window":
        body = fc.LocalBody(
            fc.ElasticBody(mesh, material, supports=held), at=(0.0, 0.0, 0.0), window=0.7, cells=(8, 8), name="soft"
        )
    given = {"motions": {ball: {"z": -0.03}}, "accuracy": {"force": 0.05}}
    told = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(**given).convergence
    assert not told.met
    assert told.reason == "errors of forces and motions are not estimated with 'soft', whose elements give none"


@pytest.mark.parametrize("load", [{"motions": {"z": -0.03}}, {"forces": (0, 0, -0.01)}])
def test_an_error_of_the_force_that_is_estimated_or_given_is_met(load):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (4, 4, 2)).translated((-0.5, -0.5, -1.0))
    body, ball = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "top", {"bottom": "xyz"}), fc.RigidBody(Paraboloid(2.0))
    ((kind, value),) = load.items()
    result = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(**{kind: {ball: value}}, accuracy={"force": 0.05})
    assert result.convergence.met


def test_without_an_accuracy_there_are_no_steps():
    block, _, both = scene()
    result = both.solve(forces={block: (0, 0, -FORCE)})
    assert result.convergence is None
    with refused(fc.InputError, "input", "accuracy"):
        result.plot("convergence")


@pytest.mark.parametrize(
    ("options", "found"),
    [
        ({"accuracy": 0.0}, ("not-positive", "The accuracy")),
        ({"accuracy": 2.0}, ("input", "02 for 2 %")),
        ({"accuracy": np.nan}, ("not-positive", "The accuracy")),
        ({"accuracy": 0.1, "max_dofs": -1}, ("not-positive", "The limit max_dofs")),
        ({"max_seconds": 3.0}, ("limit-without-accuracy",)),
    ],
)
def test_wrong_targets_are_refused(options, found):
    block, _, both = scene()
    with refused(fc.InputError, *found):
        both.solve(forces={block: (0, 0, -FORCE)}, **options)


def test_a_scene_file_and_the_command_line_ask_for_an_accuracy(tmp_path, written, capsys):
    path = written(BALL_ON_BLOCK + "[solve]\naccuracy = 0.3\n")
    assert read_scene(path).solve().convergence.accuracy == 0.3
    assert main(["solve", str(path), "--accuracy", "20%", "--json", str(tmp_path / "out.json")]) == 0
    told = json.loads((tmp_path / "out.json").read_text())["convergence"]
    assert told["accuracy"] == 0.2
    assert told["met"]
    assert (
        main(["solve", str(path), "--accuracy", "pressure=30%, force=0.4", "--json", str(tmp_path / "out.json")]) == 0
    )
    told = json.loads((tmp_path / "out.json").read_text())["convergence"]
    assert told["accuracy"] == {"pressure": 0.3, "force": 0.4}
    named = written(
        path.read_text().replace("accuracy = 0.3", "accuracy = {pressure = 0.3, force = 0.4}"), "named.toml"
    )
    assert read_scene(named).solve().convergence.accuracy == {"pressure": 0.3, "force": 0.4}
    named.write_text(path.read_text().replace("accuracy = 0.3", "accuracy = {pressure = 0.3, strength = 0.4}"))
    with refused(fc.InputError, "scene-file", "'strength'"):
        read_scene(named)
    path.write_text(path.read_text().replace("accuracy = 0.3", "max_dofs = 3000"))
    with refused(fc.InputError, "scene-file"):
        read_scene(path)
    path.write_text(path.read_text().replace("max_dofs = 3000", "accuracy = 3"))
    with refused(fc.InputError, "scene-file", "1"):
        read_scene(path)


def test_each_case_of_a_sweep_is_solved_to_the_accuracy():
    block, _, both = scene()
    cases = [{"name": f"{k}", "forces": {block: (0, 0, -k * FORCE)}, "accuracy": 0.1} for k in (1, 2)]
    rows = both.sweep(cases)
    assert all(row["convergence"]["met"] for row in rows)
    alone = both.solve(forces={block: (0, 0, -2 * FORCE)}, accuracy=0.1)
    assert abs(rows[1]["contacts"][0]["max_pressure"] / alone.contacts[0].max_pressure - 1) < 1e-9


def test_a_limit_of_memory_ends_with_the_best_answer(monkeypatch):
    block, _, both = scene()
    monkeypatch.setattr("fecontact.scene.adaptive.memory_budget", lambda: 1e6)
    result = both.solve(forces={block: (0, 0, -FORCE)}, accuracy=1e-3)
    assert len(result.convergence.steps) == 1
    assert "GB" in result.convergence.reason


def test_a_singular_edge_ends_with_the_reason():
    """A rigid flat punch: the pressure at its edge has no bound, and the error hardly falls."""
    block, _, _ = scene()
    punch = fc.RigidBody(FlatPunch(CONTACT), name="punch").placed(rotation=fc.rotation_about((1, 0, 0), np.pi))
    both = fc.Scene([block, punch], [fc.Contact(block, punch)])
    result = both.solve(forces={block: (0, 0, -FORCE)}, accuracy=0.005, max_dofs=10_000)
    assert not result.convergence.met
    assert any("accuracy" in text for text in result.warnings)


def test_what_an_accuracy_may_take_is_told_beforehand(solved):
    block, _, result = solved
    both = fc.Scene(result._unrefined, [fc.Contact(*result._unrefined)])
    told = str(explain(both, {"forces": {block: (0, 0, -FORCE)}}, accuracy=0.06))
    n, unknowns = re.search(r"about (\d+) divisions, to (\S+) unknowns", told).groups()
    assert abs(int(n) - (len(result.convergence.steps) - 1)) <= 1
    assert 0.4 < float(unknowns) / result.n_dofs < 2.5
    assert "divisions" not in str(explain(both))


def test_linear_cells_are_divided_below_the_contact_too():
    """Their faces alone would leave some percent of error; quadratic ones are not marked there."""
    for element, marked in (("hex8", True), ("hex20", False)):
        block, _, both = scene(element)
        contact = both.solve(forces={block: (0, 0, -FORCE)}).contacts[0]
        ours, theirs = marked_cells(contact, 0.05)
        assert (len(ours) > 0) == marked
        assert len(theirs) == 0
        assert np.isin(ours, contact._energy_errors[0].cells).all()


# poses settle to 1e-4 of the elastic displacement, and the error is of the square; or linearised motions are bearable
@pytest.mark.by_day("True-1e-06")
@pytest.mark.parametrize(("finite_motion", "tolerance"), [(True, 1e-6), ("auto", 1e-3)])
def test_finite_motion_goes_on_from_the_coarser_mesh(monkeypatch, finite_motion, tolerance):
    """The poses found on one mesh are where the next begins; the answer is that of the finest mesh by itself."""
    mesh = fc.shapes.block((4.0, 4.0, 2.0), (8, 8, 4)).translated((-2.0, -2.0, -2.0))
    block = fc.ElasticBody(mesh, STEEL, "top", {"bottom": "xyz"}, name="block")
    ball = fc.RigidBody(fc.Sphere(2.0), name="ball").placed(translation=(0.1, 0.05, 0.6))
    both = fc.Scene([block, ball], [fc.Contact(block, ball)])
    # 'auto' goes on where small motions err, and ends where what is left of them is small beside the approach
    along, force = ({"x": 0.0, "y": 0.0}, 0.2) if finite_motion is True else ({"x": 0.4, "y": 0.0}, 0.01)
    given = {"motions": {ball: along}, "forces": {ball: (0, 0, -force)}, "finite_motion": finite_motion}
    counts = []
    real_step, real_path = adaptive._step, finite_rotation._Path.solved
    restarts, real_begin = [], finite_rotation._Path.begin

    def counted(path):
        counts[-1] += 1
        return real_path(path)

    def begun(*arguments):
        counts.append(0)
        return real_step(*arguments)

    monkeypatch.setattr(finite_rotation._Path, "solved", counted)
    monkeypatch.setattr(adaptive, "_step", begun)
    monkeypatch.setattr(finite_rotation._Path, "begin", lambda *a: restarts.append(1) or real_begin(*a))
    counts.append(0)
    result = both.solve(**given, accuracy=0.15)
    n = len(result.convergence.steps)
    assert n > 1
    if finite_motion is True:
        assert max(counts[1:n]) < counts[0]
    else:
        assert counts[0] == 2  # until the motions settle
        assert counts[1:n] == [1] * (n - 1)
        assert len(restarts) == 1  # from small motions, on the first mesh only
    finest = result.solved(block)
    alone = fc.Scene([finest, ball], [fc.Contact(finest, ball)]).solve(**given)
    assert abs(result.contacts[0].max_pressure / alone.contacts[0].max_pressure - 1) < tolerance


def test_the_edge_is_found_on_other_meshes_of_the_body(solved):
    """The edge runs along the circle, and only through facets that lie on both sides of it."""
    block, _, result = solved
    points = edge_points(result.contacts[0])
    radius = np.hypot(points[:, 0], points[:, 1])
    assert len(points) > 10
    # a quarter of the block's faces under the contact's radius of two
    assert np.abs(radius - CONTACT).max() < 0.125 * CONTACT
    surface = block.surface("bottom")
    corners = surface.points[surface.facets[facets_at(points, block, "bottom"), :4]]
    outside = np.hypot(corners[..., 0], corners[..., 1]) > CONTACT
    assert (outside.any(axis=1) & ~outside.all(axis=1)).all()
    assert len(facets_at(points[:0], block, "bottom")) == 0


#: Force on a quarter of the plate below, on 20-node cells graded to its clamped sides (8 x 8 x 4, `accuracy` 0.03).
PLATE = 0.003468


def test_figures_are_asked_for_by_name():
    """Bending of a plate of 8-node cells: its force is divided for, which the pressure alone leaves too large."""
    mesh = fc.shapes.block((5.0, 5.0, 1.0), (4, 4, 1), element="hex8")
    body = fc.ElasticBody(mesh, STEEL, "top", {"x_min": "x", "y_min": "y", "x_max": "xyz", "y_max": "xyz"})
    ball = fc.RigidBody(fc.Sphere(20.0)).placed((0, 0, 1.0))
    plate, asked = fc.Scene([body, ball], [fc.Contact(body, ball)]), {"pressure": 0.2, "force": 0.1}
    loads = {"motions": {ball: {"z": -0.1}}, "finite_motion": False}
    coarse, by_name = (plate.solve(**loads, accuracy=a) for a in (0.2, asked))
    assert coarse.convergence.met
    assert any("Estimated errors of other figures are larger: force" in text for text in coarse.warnings)
    assert by_name.convergence.met
    assert by_name.convergence.accuracy == asked
    assert SAFETY * by_name.response_error.force <= 0.1 < coarse.response_error.force
    assert not any("larger: force" in text for text in by_name.warnings)
    assert abs(by_name.contacts[0].total_force / PLATE - 1) < 0.1 < coarse.contacts[0].total_force / PLATE - 1
    assert by_name.summary()["convergence"]["accuracy"] == asked
    assert "pressure 0.2, force 0.1" in str(by_name.convergence)


@pytest.mark.parametrize(
    ("accuracy", "found"),
    [({"forces": 0.1}, ("no-figure", "'forces'")), ({}, ("no-figure", "none")),
     ({"force": 2.0}, ("input", "of the force"))],
)  # fmt: skip
def test_wrong_names_of_figures_are_refused(accuracy, found):
    block, _, both = scene("hex8")
    with refused(fc.InputError, *found):
        both.solve(forces={block: (0, 0, -FORCE)}, accuracy=accuracy)


@pytest.mark.full
def test_equal_balls_stay_of_one_model(monkeypatch):
    """Two balls that press on each other are divided alike: one factor, and the forces of two models."""
    level = fc.shapes.Level(core=2, rings=2, edge=0.2, layer=0.3)
    mesh = fc.shapes.half_sphere(RADIUS, contact_radius=CONTACT, level=level, sector="half")
    lower = fc.ElasticBody(mesh, STEEL, "cap", {"base": "xyz", "sym_y": "y"}, name="lower")
    upper = lower.placed(rotation=np.diag([-1.0, 1.0, -1.0]), name="upper")
    both, found = fc.Scene([lower, upper], [fc.Contact(lower, upper)]), []
    for shared in (True, False):
        if not shared:
            monkeypatch.setattr(adaptive, "of_one_model", lambda *_: None)
        result = both.solve(forces={upper: (0, 0, FORCE)}, accuracy=0.05, finite_motion=False)
        assert len(result.convergence.steps) > 1
        one, other = (result.solved(body) for body in (lower, upper))
        assert (one.model is other.model) == shared
        assert ("factorised once for both" in str(result)) == shared
        found.append(result.contacts[0].forces)
    # one linear problem: rounding times the condition of the compliance
    assert np.abs(found[0] - found[1]).max() <= 1e-10 * found[1].max()


def test_bodies_that_are_divided_otherwise_or_were_of_two_models_share_none():
    block, _, _ = scene()
    twin, other = block.placed(name="twin"), fc.ElasticBody(block.mesh, STEEL, "bottom", block.supports)
    before = [block, twin, twin, other]
    marks = [np.array([0]), np.array([0]), np.array([5]), np.array([0])]
    finer = [body._divided({"bottom": mark}) for body, mark in zip(before, marks, strict=True)]
    of_one_model(finer, before)
    assert finer[1].model is finer[0].model
    assert finer[1].mesh is finer[0].mesh
    assert finer[2].model is not finer[0].model
    assert finer[3].model is not finer[0].model
