"""Bodies with a law of finite strain beside every other kind of body, load and motion."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.optimize import brentq

import fecontact as fc
from fecontact.bodies import halfspace
from fecontact.bodies.local import body as local
from fecontact.common.path import in_parts
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.loads import LoadStep
from fecontact.contact.turning import turning_with
from fecontact.fem import model
from fecontact.halfspace import operator
from fecontact.results.result import ContactResult
from fecontact.scene import finite_strain
from fecontact.scene.linear import Settings
from tests.hanging_meshes import step
from tests.refusals import refused

STEEL = fc.Material(E=5.0, nu=0.3, density=2.0)
SOFT = fc.NeoHookean(E=1.0, nu=0.3, density=1.0)
FLIP = np.diag([1.0, -1.0, -1.0])


def dome(material=SOFT, divisions=(4, 4, 2), supports=None, curve=0.3, points=lambda x: x):
    """A block held at its top, with a curved bottom that is the lowest at the origin."""
    mesh = fc.shapes.block((1.0, 1.0, 0.8), divisions, element="hex8")
    mesh = mesh.mapped(lambda x: x - [0.5, 0.5, 0.0] + ((x[:, :2] - 0.5) ** 2).sum(axis=1)[:, None] * [0, 0, curve])
    held = {"top": "xyz"} if supports is None else supports
    return fc.ElasticBody(mesh.mapped(points), material, "bottom", held, name="dome", geometry="plain")


def slab(material=STEEL, mesh=None, **given):
    if mesh is None:
        mesh = fc.shapes.block((2.0, 2.0, 1.0), (4, 4, 2), element="hex8").mapped(lambda x: x - [1.0, 1.0, 1.0])
    return fc.ElasticBody(mesh, material, "top", {"bottom": "xyz"}, name="slab", **given)


def layered():
    mesh = slab().mesh.with_group("upper", lambda x: x[:, 2] > -0.5).with_group("lower", lambda x: x[:, 2] < -0.5)
    return slab({"upper": fc.Material(2.0, 0.3), "lower": fc.Material(5.0, 0.3)}, mesh)


def in_facets():
    mesh = slab().mesh
    return fc.RigidBody(fc.surfaces.Facets(fc.SurfaceMesh(mesh.points, mesh.face_nodes(mesh.outer_faces))))


def heights():
    x = (np.arange(33) / 32 - 0.5) * 1.6
    hills = fc.RigidBody.from_heights(0.01 * (x[:, None] ** 2 + 0.5 * x**2), (1.6, 1.6), name="heights")
    return hills.placed(rotation=FLIP)


PARTNERS = {
    "plane": lambda: fc.RigidBody(fc.Plane(), name="floor"),
    "heights": heights,
    "facets": in_facets,
    "linear": slab,
    "layered": layered,
    "multigrid": lambda: slab(backend="amg"),
    "gram-schmidt": lambda: slab(condensation="gram-schmidt"),
    "hanging": lambda: slab(mesh=step("hex8").mapped(lambda x: x - [1.0, 1.0, 1.0])),
    "half-space": lambda: fc.HalfSpace(STEEL, size=(1.6, 1.6), cells=(16, 16)),
    "local body": lambda: fc.LocalBody(slab(), at=(0, 0, 0), window=1.2, cells=(16, 16)),
    "layer": lambda: fc.ElasticLayer(STEEL, thickness=0.2, surface=(slab().mesh, "top")),
    "bricks": lambda: fc.AncfBody(slab().mesh, STEEL, "top", {"bottom": "xyz"}, name="bricks"),
}
#: Bodies that give along their normal only.
NORMAL_ONLY = ("layer", "local body")


def pressed(body, other, depth, mu=0.0):
    scene = fc.Scene([body, other], [fc.Contact(body, other, friction=mu)])
    return scene.solve(motions={body: {"z": -depth, "x": 0.3 * depth if mu else 0.0}})


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("partner", PARTNERS)
def test_small_strains_are_the_linear_answer_beside_every_body(partner, mu) -> None:
    other = PARTNERS[partner]()
    if mu and partner in NORMAL_ONLY:
        with refused(fc.InputError, "friction-normal-only", "elastic body or a half-space"):
            pressed(dome(), other, 1e-7, mu)
        return
    # beside meshes faces do not match: the points of the solver are mixed from those of the slave
    at = (0.07, 0.03, 0.0) if isinstance(other, fc.ElasticBody) else (0.0, 0.0, 0.0)
    bodies = (dome(law, curve=0.0).placed(at) for law in (SOFT.at_rest, SOFT))
    linear, finite = (pressed(body, other, 1e-7, mu).contacts[0] for body in bodies)
    assert linear.total_force > 0
    assert finite.total_force == pytest.approx(linear.total_force, rel=1e-6)
    slivers = partner == "bricks"  # with large pressures and small forces at the rim
    if not slivers:
        assert np.abs(linear.pressure - finite.pressure).max() < 1e-6 * linear.max_pressure
    if mu:
        one, other = (
            np.atleast_2d(f.friction.forces.sum(axis=0) if slivers else f.friction.forces) for f in (linear, finite)
        )
        assert np.abs(one - other).max() < 1e-6 * linear.total_force


@pytest.mark.parametrize("partner", PARTNERS)
def test_a_quarter_of_the_height_takes_few_iterations_beside_every_body(partner) -> None:
    result = pressed(dome(), PARTNERS[partner](), 0.2, 0.0 if partner in NORMAL_ONLY else 0.3)
    (only,) = result.finite_strain
    assert only.iterations <= 8
    assert result.residuals().worst < 1e-8
    assert only.residual < 1e-8


@pytest.mark.parametrize("partner", ["linear", "hanging", "bricks", "half-space", "local body"])
def test_a_linear_partner_is_condensed_once(partner, monkeypatch) -> None:
    found = Counter()

    def counted(module, name):
        made = getattr(module, name)

        def call(*args, **given):
            found[name, args[0].shape[0] if hasattr(args[0], "shape") else 0] += 1
            return made(*args, **given)

        monkeypatch.setattr(module, name, call)

    for name in ("factorise", "bordered", "condense"):
        counted(model, name)
    for module in (halfspace, local):
        counted(module, "CellModel")
    body = dome()
    result = pressed(body, PARTNERS[partner](), 0.2)
    soft = ("bordered", len(body.model.solved_dofs))
    assert found.pop(soft) >= result.finite_strain[0].iterations > 3
    assert found
    assert set(found.values()) == {1}


def test_an_unstable_body_is_held_on_cells_whose_compliance_is_no_matrix(monkeypatch) -> None:
    """Beside a window of many cells: springs on closed gaps need the matrix, which is then made."""
    found = []
    for limit in (1500, 10):
        for module in (local, operator):
            monkeypatch.setattr(module, "DENSE_LIMIT", limit)
        result = pressed(dome(curve=0.0), PARTNERS["local body"](), 0.32)
        assert result._condensed.held_motions is not None
        found.append(result.contacts[0].pressure)
    assert np.abs(found[0] - found[1]).max() < 1e-9 * found[0].max()


def in_plane(law, stretch):
    """Stress along a stretch, held across."""
    return law.cauchy(np.diag([1.0, 1.0, stretch]))[2, 2]


@pytest.mark.parametrize("kind", ["plane", "revolved"])
def test_a_soft_section_on_a_linear_one(kind) -> None:
    """Both held across: uniform stress, which shortens the lower one, of nu = 0, by its share of its modulus."""
    plane = kind == "plane"
    make, sides = (fc.PlaneBody, {"left": "x", "right": "x"}) if plane else (fc.AxisymmetricBody, {"right": "x"})
    pad = make(fc.sections.rectangle((1.0, 1.0), (3, 2)), SOFT, "bottom", {"top": "z", **sides}, name="pad")
    base = fc.sections.rectangle((1.0, 1.0), (2, 2))
    base = make(base, fc.Material(8.0, 0.0), "top", {"bottom": "z", **sides}, name="base").placed((0, 0, -1.0))
    result = fc.Scene([pad, base], [fc.Contact(pad, base)]).solve(motions={pad: {"z": -0.4}})
    stretch = brentq(lambda s: 1 - s - in_plane(SOFT, s) / 8.0 - 0.4, 0.4, 1.0, xtol=1e-15)
    stress = in_plane(SOFT, stretch)
    assert np.abs(result.contacts[0].pressure / -stress - 1).max() < 1e-8
    assert result.contacts[0].total_force == pytest.approx(-stress * (1.0 if plane else np.pi), rel=1e-8)
    assert result.displacement(base)[:, 2].min() == pytest.approx(stress / 8.0, rel=1e-8)


def test_a_spring_acts_as_its_force_does() -> None:
    """Its end moves with the node, and its direction is that between the ends as they are."""
    body, corner, far = dome(curve=0.0), np.array([0.5, 0.5, 0.0]), np.array([2.0, 0.5, -1.0])
    body = body.placed((0.3, 0.1, 0.2), fc.rotation_about((1.0, 2.0, 0.5), 0.4))
    corner_now = body.pose.to_world(corner[None])[0]
    floor = fc.RigidBody(fc.Plane(), name="floor").placed((0, 0, -5.0))
    spring = fc.Spring(0.05, (body, corner), (None, far), slack_length=1.0)
    contacts = [fc.Contact(body, floor)]
    result = fc.Scene([body, floor], contacts, [spring]).solve()
    (state,) = result.springs
    node = int(np.argmin(np.linalg.norm(body.mesh.points - corner, axis=1)))
    moved = result.displacement(body)[node]
    assert np.linalg.norm(moved) > 0.05
    way = far - corner_now - moved
    assert state.elongation == pytest.approx(np.linalg.norm(way) - 1.0, abs=1e-7)
    assert state.tension == pytest.approx(0.05 * state.elongation, rel=1e-7)
    pull = state.tension * way / np.linalg.norm(way)
    other = fc.Scene([body, floor], contacts).solve(forces={(body, tuple(corner)): pull})
    assert np.abs(other.displacement(body) - result.displacement(body)).max() < 1e-7


def ring():
    """A roller of 16 equal cells around on a rigid core, above a floor."""
    mesh = fc.shapes.thick_ring(0.5, 1.0, 0.25, (16, 2, 1), sector="full", element="hex8")
    held = {"inner": "xyz", "bottom": "z", "top": "z"}
    body = fc.ElasticBody(mesh, SOFT, "outer", held, name="ring", geometry="plain")
    upright = fc.RigidBody(fc.Plane(), name="floor").placed(rotation=fc.rotation_about((0, 1, 0), np.pi / 2))
    return body, upright.placed((-1.0, 0, 0))


def test_a_roller_turned_by_whole_cells_is_pressed_alike() -> None:
    """By an eighth and by 112.5 degrees in one step; halves of a step turn about the same axis."""
    forces = []
    for turn in (0.0, 2 * np.pi / 8, 5 * np.pi / 8):
        body, floor = ring()
        scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
        result = scene.solve(motions={body: {"rz": turn}, floor: {"x": 0.15}})
        assert len(result.finite_strain) == 1
        forces.append(result.contacts[0].total_force)
        assert np.abs(result.rigid_motion(body).rotation - [0, 0, turn]).max() < 1e-12
    assert np.ptp(forces) < 1e-9 * forces[0]


def test_turning_a_body_is_turning_its_partner_the_other_way() -> None:
    found = []
    for turned in (0, 1):
        bodies = dome(curve=0.0), fc.RigidBody(fc.Plane(), name="floor")
        scene = fc.Scene(bodies, [fc.Contact(*bodies, friction=0.4)])
        motions = {bodies[0]: {"z": -0.2}, bodies[1]: {}}
        motions[bodies[turned]]["rz"] = (0.7, -0.7)[turned]
        result = scene.solve(motions=motions)
        friction = result.contacts[0].friction
        assert friction.sliding.any()
        found.append([result.contacts[0].total_force, *np.linalg.norm(friction.forces, axis=1)])
    assert np.abs(np.subtract(*found)).max() < 1e-9 * found[0][0]


def test_a_torque_turns_a_free_plate_as_its_motion_does() -> None:
    body, plate = dome(curve=0.0), fc.RigidBody(fc.Plane(), name="plate")
    scene = fc.Scene([body, plate], [fc.Contact(body, plate, friction=np.inf)])
    moved = scene.solve(motions={plate: {"z": 0.02, "rz": 0.02}})
    torque = moved.reaction(plate)[5]
    loaded = scene.solve(motions={plate: {"z": 0.02}}, moments={plate: (0, 0, torque)})
    assert abs(loaded.rigid_motion(plate).rotation[2]) == pytest.approx(0.02, abs=1e-7)


def test_motions_of_a_free_plate_are_accelerated() -> None:
    """A torque on a plate that is pressed by 10 %: as its motion by .1, in 9 iterations; 16 without its motions."""
    body, plate = dome(curve=0.0), fc.RigidBody(fc.Plane(), name="plate")
    scene = fc.Scene([body, plate], [fc.Contact(body, plate, friction=np.inf)])
    torque = scene.solve(motions={plate: {"z": 0.08, "rz": 0.1}}).reaction(plate)[5]
    loaded = scene.solve(motions={plate: {"z": 0.08}}, moments={plate: (0, 0, torque)})
    assert loaded.rigid_motion(plate).rotation[2] == pytest.approx(0.1, abs=1e-7)
    assert loaded.finite_strain[0].iterations <= 11


def test_a_torque_turns_a_plate_that_is_pressed_by_a_quarter_as_its_motion_does() -> None:
    """The forces that stick press towards the middle: they resist the turn 2.6 times as much as the rubber does."""
    body, plate = dome(curve=0.0), fc.RigidBody(fc.Plane(), name="plate")
    scene = fc.Scene([body, plate], [fc.Contact(body, plate, friction=np.inf)])
    torque = scene.solve(motions={plate: {"z": 0.2, "rz": 0.1}}).reaction(plate)[5]
    loaded = scene.solve(motions={plate: {"z": 0.2}}, moments={plate: (0, 0, torque)})
    assert loaded.rigid_motion(plate).rotation[2] == pytest.approx(0.1, abs=2e-7)
    assert [step.iterations for step in loaded.finite_strain] == [9]


def test_forces_that_move_with_a_body_resist_its_turns_as_differences_say() -> None:
    """Moments of dead forces after turns by a small angle, with a force whose moment is zero: K is symmetric then."""
    rng = np.random.default_rng(3)
    points, forces = rng.normal(size=(2, 7, 3))
    forces -= forces.mean(axis=0)
    cross = np.stack([np.cross(np.eye(3), p) for p in points], axis=1).reshape(3, -1)  # moment of unit forces
    forces -= (np.linalg.pinv(cross) @ (cross @ forces.ravel())).reshape(-1, 3)
    step = 1e-5
    K = np.empty((3, 3))
    for k, axis in enumerate(np.eye(3)):
        ends = [np.cross(points @ fc.rotation_about(axis, turn).T, forces).sum(axis=0) for turn in (step, -step)]
        K[:, k] = (ends[1] - ends[0]) / (2 * step)
    assert np.abs(K - turning_with(points, forces)).max() < 1e-9


def test_a_free_soft_body_under_a_tilted_plate_has_its_warnings() -> None:
    """Its motions are eliminated with the closed gaps that hold it, and have no rows in the estimates."""
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (2, 2, 2), element="hex8")
    pad = fc.ElasticBody(mesh, fc.NeoHookean(E=1.0, nu=0.45), ("top", "bottom"), name="pad")
    plate = fc.RigidBody(fc.Plane(), name="plate").placed((1.0, 1.0, 1.0), rotation=FLIP)
    floor = fc.RigidBody(fc.Plane(), name="floor")
    contacts = [fc.Contact(pad, each, surfaces=(name, "surface")) for name, each in (("top", plate), ("bottom", floor))]
    held = {pad: {"x": 0.0, "y": 0.0, "rz": 0.0}, plate: {"z": -0.25}}
    result = fc.Scene([pad, plate, floor], contacts).solve(motions=held, moments={plate: (0, 0.05, 0)})
    assert result._condensed.held_motions is not None
    assert result.response_error.approach > 0
    assert isinstance(result.warnings, tuple)


@pytest.mark.parametrize(
    ("shape", "depth", "moment", "mu", "most"),
    [
        (fc.Plane(), 0.25, (0.0, 0.15, 0.0), 0.0, 7),
        (fc.Plane(), 0.25, (0.0, 0.15, 0.0), 0.1, 10),
        (fc.Plane(), 0.4, (0.1, 0.15, 0.0), 0.0, 11),
        (fc.surfaces.Paraboloid(4.0), 0.3, (0.0, 0.1, 0.0), 0.0, 13),
    ],
    ids=["plate", "friction", "two fifths", "bowl"],
)
def test_a_moment_tilts_what_presses_rubber_in_one_step(shape, depth, moment, mu, most) -> None:
    """Its motion, prescribed, has the same moment along the load as reaction; across it the plate is held."""
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (4, 4, 2), element="hex8")
    pad = fc.ElasticBody(mesh, fc.NeoHookean(E=1.0, nu=0.45), "top", {"bottom": "xyz"}, name="pad")
    upright = isinstance(shape, fc.Plane)
    plate = fc.RigidBody(shape, name="plate").placed((1.0, 1.0, 1.0), rotation=FLIP if upright else np.eye(3))
    scene = fc.Scene([pad, plate], [fc.Contact(pad, plate, friction=mu)])
    held = {"x": 0.0, "y": 0.0, "z": -depth}
    loaded = scene.solve(motions={plate: held}, moments={plate: moment})
    (step,) = loaded.finite_strain
    assert step.iterations <= most
    assert loaded.residuals().worst < 1e-8
    turn = loaded.rigid_motion(plate).rotation
    moved = scene.solve(motions={plate: {**held, **dict(zip(("rx", "ry", "rz"), turn, strict=True))}})
    assert (moved.reaction(plate)[3:] - moment) @ moment == pytest.approx(0.0, abs=1e-8)


def test_a_step_that_fails_is_tried_again_without_its_pressures_tangent_only_where_it_has_one(monkeypatch) -> None:
    """A pressure on a linear partner has none."""
    found = Counter()

    def fails(newton):
        found[newton._following] += 1
        newton._linearised()
        raise fc.SolverError("It fails.", code="no-equilibrium")

    monkeypatch.setattr(finite_strain._Newton, "converged", fails)
    monkeypatch.setattr(finite_strain, "in_parts", lambda solve, last: iter([(1.0, solve(0.0, 1.0, last))]))
    body, base = dome(), slab()
    scene = fc.Scene([body, base], [fc.Contact(body, base)])
    for loaded, tries in ((base, {True: 1}), (body, {True: 1, False: 1})):
        found.clear()
        with refused(fc.SolverError, "no-equilibrium", "fails"):
            scene.solve(motions={body: {"z": -0.1}}, pressures={(loaded, "top" if loaded is base else "bottom"): 0.01})
        assert found == tries


def test_copies_of_a_soft_body_are_pressed_alike_and_beside_each_other() -> None:
    """Two copies of one model, one turned upside down, under one load each; alone they are the same."""
    first = dome()
    second = first.placed((3.0, 0, 0), fc.rotation_about((0, 0, 1), 0.5), name="second")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    both = fc.Scene([first, second, floor], [fc.Contact(first, floor), fc.Contact(second, floor)])
    result = both.solve(motions={first: {"z": -0.2}, second: {"z": -0.1}})
    for body, contact, depth in zip((first, second), result.contacts, (0.2, 0.1), strict=True):
        alone = pressed(body, floor, depth).contacts[0]
        assert np.abs(alone.pressure - contact.pressure).max() < 1e-9 * alone.max_pressure


def test_a_quarter_is_a_quarter_of_the_whole() -> None:
    whole = pressed(dome(divisions=(4, 4, 2)), PARTNERS["plane"](), 0.2)
    mesh = fc.shapes.block((0.5, 0.5, 0.8), (2, 2, 2), element="hex8")
    mesh = mesh.mapped(lambda x: x + (x[:, :2] ** 2).sum(axis=1)[:, None] * [0, 0, 0.3])
    supports = {"top": "xyz", "x_min": "n", "y_min": "n"}
    quarter = fc.ElasticBody(mesh, SOFT, "bottom", supports, name="quarter", geometry="plain")
    found = pressed(quarter, PARTNERS["plane"](), 0.2)
    assert 4 * found.contacts[0].total_force == pytest.approx(whole.contacts[0].total_force, rel=1e-9)


@pytest.mark.parametrize(("length", "modulus"), [(1e-6, 1e6), (1e6, 1e-6), (1e-6, 1.0), (1.0, 1e6)])
def test_units_do_not_matter(length, modulus) -> None:
    forces = []
    for unit, E in ((1.0, 1.0), (length, modulus)):
        body = dome(fc.NeoHookean(E, 0.45), points=lambda x, unit=unit: unit * x)
        base = slab(fc.Material(5 * E, 0.3), slab().mesh.mapped(lambda x, unit=unit: unit * x))
        forces.append(pressed(body, base, 0.2 * unit, 0.3).contacts[0].total_force / E / unit**2)
    assert forces[1] == pytest.approx(forces[0], rel=1e-9)


def test_numbers_of_nodes_do_not_matter() -> None:
    body = dome()
    order = np.random.default_rng(1).permutation(len(body.mesh.points))
    points = np.empty_like(body.mesh.points)
    points[order] = body.mesh.points
    mesh = replace(body.mesh, points=points, cells=order[body.mesh.cells])
    other = fc.ElasticBody(mesh, SOFT, "bottom", {"top": "xyz"}, geometry="plain")
    one, two = (pressed(b, slab(), 0.2, 0.3).contacts[0] for b in (body, other))
    assert two.total_force == pytest.approx(one.total_force, rel=1e-9)
    assert two.max_pressure == pytest.approx(one.max_pressure, rel=1e-9)


def test_points_that_bear_the_force_of_others_are_not_held() -> None:
    # points at the rim of the covered part share means: they bear force where the solver's own ones are open
    below = fc.shapes.block((1.0, 1.0, 1.0), (2, 1, 1), element="hex27")
    above = fc.shapes.block((0.8, 1.0, 0.8), (1, 1, 1), element="hex8").mapped(lambda x: x + np.array([0.6, 0.0, 1.0]))
    found = []
    for turn in (np.eye(3), fc.rotation_about((0, 0, 1), 1.1)):
        low = fc.ElasticBody(below, SOFT, "top", {"bottom": "xyz"}, geometry="plain").placed(rotation=turn)
        up = fc.ElasticBody(above, fc.NeoHookean(5.0, 0.3), "bottom", {"top": "xyz"}, geometry="plain")
        up = up.placed(rotation=turn)
        result = fc.Scene([low, up], [fc.Contact(low, up, friction=0.3)]).solve(motions={up: {"z": -0.5}})
        assert result._condensed.held_motions is not None
        assert [step.iterations <= 10 for step in result.finite_strain] == [True]
        assert result.residuals().within(1e-8)
        found.append(result.contacts[0].force @ turn)
    # equal to the tolerance of Newton's method
    assert np.abs(found[0] - found[1]).max() < 1e-8


@pytest.mark.parametrize(("penetration", "accepted"), [(9e-6, True), (2e-5, False), (np.nan, False)])
def test_a_state_that_breaks_a_condition_of_contact_is_no_answer(penetration, accepted, monkeypatch) -> None:
    true = ContactResult.residuals
    monkeypatch.setattr(ContactResult, "residuals", lambda self: replace(true(self), penetration=penetration))
    monkeypatch.setattr(finite_strain, "MAX_ITERATIONS", 6)
    one, floor = dome(divisions=(1, 1, 1)), fc.RigidBody(fc.Plane(), name="floor")
    if accepted:
        assert pressed(one, floor, 0.1).residuals().penetration == penetration
    else:
        said = f"breaks the conditions of contact: penetration {penetration:.1e}"
        with refused(fc.SolverError, "no-equilibrium", said):
            pressed(one, floor, 0.1)


@pytest.mark.parametrize(
    ("change", "residual", "stable", "later"),
    [
        pytest.param(9e-7, 9e-7, [True], 0, id="stable"),
        pytest.param(9e-7, 9e-7, [False, False, True], 2, id="stable later"),
        pytest.param(9e-7, 9e-7, [False] * 20, 20, id="never stable"),
        pytest.param(2e-6, 9e-7, [], None, id="changes too large"),
        pytest.param(9e-7, 2e-6, [], None, id="forces too large"),
    ],
)
def test_a_step_whose_changes_fall_no_further_has_settled(change, residual, stable, later, monkeypatch) -> None:
    """Floors stand for points that open and close by rounding: within the bounds of every answer there is one.

    A stable one is taken at once, of those that are not the last. Outside there is none.
    """
    body, plane = dome(divisions=(2, 2, 1)), fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([body, plane], [fc.Contact(body, plane)])
    step = LoadStep(motions={body: {"z": -0.1}})
    one = finite_strain._Newton(Settings(), Stopwatch(), finite_strain.at_rest(scene, step), step)
    steps, true, large, most = one._steps, one._residual, [], 13

    def floored(result):
        taken, largest = steps(result)
        large.extend([largest] * (largest > finite_strain.SETTLED * one._size))
        return taken, max(largest, change * one._size)

    monkeypatch.setattr(one, "_steps", floored)
    monkeypatch.setattr(one, "_residual", lambda result: max(true(result), residual))
    monkeypatch.setattr(finite_strain, "is_stable", lambda result: stable.pop(0) if stable else True)
    monkeypatch.setattr(finite_strain, "MAX_ITERATIONS", most)
    if later is None:
        with refused(fc.SolverError, "no-equilibrium", f"found no equilibrium in {most} iterations"):
            one.converged()
        return
    found = one.converged()
    assert found.equilibria[0].iterations == min(len(large) + finite_strain.SETTLING + later, most)
    force = pressed(body, plane, 0.1).contacts[0].total_force
    assert abs(found.result.contacts[0].total_force / force - 1) < 1e-8


@pytest.mark.parametrize("degrees", [0.0, 5.0])
def test_points_that_cross_an_edge_to_and_fro_are_told(degrees: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A point in a groove lies on both its sides, of which each pushes it over to the other; on a plane it rests."""
    monkeypatch.setattr(finite_strain, "MAX_ITERATIONS", 7)
    monkeypatch.setattr(finite_strain, "in_parts", partial(in_parts, halvings=0))
    monkeypatch.setattr(finite_strain, "HALVINGS", 0)
    up = np.tan(np.radians(degrees))
    points = np.array([[x, y, up * abs(x)] for x in (-1.0, 0.0, 1.0) for y in (-1.0, 1.0)])
    sides = fc.SurfaceMesh(points, np.array([[0, 2, 3, 1], [2, 4, 5, 3]]))
    groove, plain = fc.RigidBody(fc.surfaces.Facets(sides), name="groove"), fc.RigidBody(fc.Plane(), name="plane")
    body = dome(divisions=(2, 2, 1), points=lambda x: x + np.array([0.005, 0.0, 0.0]))
    if degrees:
        said = ("points of 'dome' (1) go to and fro across edges of faces of 'groove'", "jump by 10 degrees")
        with refused(fc.SolverError, "edges", *said):
            pressed(body, groove, 0.05)
        return
    one, two = (pressed(body, other, 0.05).contacts[0].total_force for other in (groove, plain))
    assert abs(one / two - 1) < 1e-9


@pytest.mark.parametrize(("code", "parts"), [("no-area", 2), ("sliver", None)])
def test_faces_that_an_iteration_distorts_ask_for_smaller_steps(code: str, parts: int | None, monkeypatch) -> None:
    newton, calls = finite_strain._Newton, []
    solved = newton._solved

    def distorting(self, *given):
        calls.append(given)
        if len(calls) == 2:
            raise fc.MeshError("A face is so distorted.", code=code)
        return solved(self, *given)

    monkeypatch.setattr(newton, "_solved", distorting)
    body, plane = dome(divisions=(2, 2, 1)), fc.RigidBody(fc.Plane(), name="floor")
    if parts is None:
        with refused(fc.MeshError, code, "so distorted"):
            pressed(body, plane, 0.05)
    else:
        assert len(pressed(body, plane, 0.05).finite_strain) == parts
