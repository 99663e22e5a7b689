"""Gradients of results: Hertz's exponents, central differences of new solutions, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.halfspace import gradient as halfspace_gradient
from fecontact.solvers import ContactProblem, solve
from fecontact.solvers.gradient import weakly_active

STEEL = fc.Material(E=210e3, nu=0.3)
#: Central differences of certified solutions against the adjoint, relative: their steps of 1e-5, and rounding.
AGREE = 1e-6


def differences(figure, step):
    return (figure(step) - figure(-step)) / (2 * step)


def half_space(E=1.0, cells=64, **options):
    return fc.HalfSpace(fc.Material(E=E, nu=0.3), size=(3.0, 3.0), cells=(cells, cells), **options)


def test_hertz_exponents():
    """Largest pressure of a ball: F^(1/3), R^(-2/3), E^(2/3), on 64 cells within 1 percent."""
    half = half_space()
    ball = half.press(fc.surfaces.Paraboloid(1.0), force=1.4)
    peak = half.gradient(ball)
    heights = half.heights_of(fc.surfaces.Paraboloid(1.0))  # r^2 / 2R, less by dR / R
    assert abs(peak.load * ball.force / peak.value - 1 / 3) < 0.01 / 3
    assert abs(-(peak.heights * heights).sum() / peak.value + 2 / 3) < 0.02 / 3
    assert abs(peak.E / peak.value - 2 / 3) < 0.02 / 3
    assert not len(peak.weak)


@pytest.mark.parametrize(
    ("what", "options", "load"),
    [
        pytest.param("max_pressure", {}, {"force": 1.4}, marks=pytest.mark.full),
        ("area", {}, {"force": 1.4}),
        pytest.param("approach", {}, {"force": 1.4}, marks=pytest.mark.full),
        pytest.param("force", {}, {"approach": 0.9}, marks=pytest.mark.full),
        ("weights", {"against": fc.Material(E=3.0, nu=0.2)}, {"force": 1.0}),
        ("max_pressure", {}, {"force": 1.4, "load_point": (0.05, 0.1)}),
    ],
)
def test_half_spaces_against_central_differences(what, options, load):
    """By all heights at once along a smooth field, by the load and by the modulus, with the same cells in contact."""
    half = half_space(cells=32, **options)
    x, y = half.grid.x[:, None], half.grid.y[None, :]
    heights, along = (x**2 + 1.3 * y**2) / 2 + 0.01 * np.cos(7 * x + y), np.sin(2 * x + 0.3) * np.cos(3 * y)
    weights = 1 + x + y**2
    point = {"load_point": load["load_point"]} if "load_point" in load else {}

    def figure(z=heights, modulus=1.0, **given):
        found = half_space(modulus, 32, **options).press(z, tolerance=1e-13, symmetry=False, **{**load, **given})
        if what == "weights":
            return float((weights * found.pressure).sum())
        return found.figures[what]

    contact = half.press(heights, tolerance=1e-13, **load)
    found = half.gradient(contact, weights if what == "weights" else what, **point)
    name = "approach" if "approach" in load else "force"
    step = 1e-5
    for slope, by in (
        ((found.heights * along).sum(), lambda h: figure(heights + h * along)),
        (found.load, lambda h: figure(**{name: load[name] + h})),
        (found.E, lambda h: figure(modulus=1.0 + h)),
    ):
        assert abs(differences(by, step) - slope) < AGREE * max(abs(slope), abs(found.value))
    assert abs(found.value - figure()) < 1e-10 * abs(found.value)


def scene_of(mu=0.0, modulus=210e3):
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (6, 6, 3))
    block = fc.ElasticBody(mesh, fc.Material(modulus, 0.3), contact="top", supports={"bottom": "xyz"})
    ball = fc.RigidBody(fc.Sphere(3.0)).placed((1.0, 1.1, 1.0))
    return fc.Scene([block, ball], [fc.Contact(block, ball, friction=mu)])


def pressed(mu, force=-2000.0, modulus=210e3):
    """The scene, pressed and, with friction, pushed along x; its result."""
    scene = scene_of(mu, modulus)
    moved = {scene.bodies[1]: {"x": 0.002}} if mu else None
    load = {scene.bodies[1]: (0.0, 0.0, force)}
    return scene, scene.solve(load, motions=moved, finite_motion=False, tolerance=1e-12)


@pytest.mark.parametrize(
    ("mu", "what"),
    [
        (0.3, "max_pressure"),
        pytest.param(0.0, "max_pressure", marks=pytest.mark.full),
        pytest.param(0.3, "weights", marks=pytest.mark.full),
    ],
)
def test_scenes_against_central_differences(mu, what):
    """By load and modulus, without friction and with points that stick and slide."""
    weights = np.linspace(1.0, 2.0, len(scene_of().solve(motions={}).contacts[0].gap))

    def figure(**given):
        contact = pressed(mu, **given)[1].contacts[0]
        return contact.max_pressure if what == "max_pressure" else float(weights @ contact.pressure)

    scene, result = pressed(mu)
    if mu:
        assert result.contacts[0].stick_area > 0
        assert result.contacts[0].slip_area > 0
    found = result.gradient(weights if what == "weights" else what)
    block, ball = scene.bodies
    by_force = differences(lambda h: figure(force=-2000.0 + h), 0.05)
    assert abs(found.loads[ball][2] - by_force) < AGREE * abs(by_force)
    by_modulus = differences(lambda h: figure(modulus=210e3 + h), 5.0)
    assert abs(found.E[block] - by_modulus) < AGREE * max(abs(by_modulus), abs(found.value) / 210e3)


def test_gaps_of_a_scene_against_central_differences():
    """Of the condensed problem with one gap changed, solved anew."""
    scene = scene_of()
    result = scene.solve({scene.bodies[1]: (0.0, 0.0, -2000.0)}, finite_motion=False, tolerance=1e-12)
    contact, problem = result.contacts[0], result.problem
    peak = int(contact.pressure.argmax())
    row = int(np.flatnonzero(contact._candidates == peak)[0])
    found = result.gradient().gaps[0]
    for k in np.flatnonzero(contact.active[contact._candidates])[:4]:

        def pressure(h, k=k):
            moved = problem.g + h * (np.arange(problem.n) == k)
            return solve(replace(problem, g=moved), tolerance=1e-13).forces[row] / contact.weights[peak]

        slope = found[contact._candidates[k]]
        assert abs(differences(pressure, 1e-7) - slope) < AGREE * np.abs(found).max()


@pytest.mark.parametrize("mu", [0.0, pytest.param(0.3, marks=pytest.mark.full)])
def test_motions_of_a_scene_against_central_differences(mu):
    """How deep a ball is pressed, and beside it how far along: by the load and the modulus."""
    weights = np.array([0.5 * (mu == 0), 0.0, -1.0, 0.0, 0.0, 0.0])  # along x it is held with friction

    def figure(**given):
        scene, result = pressed(mu, **given)
        motion = result.rigid_motion(scene.bodies[1])
        return float(weights @ [*motion.translation, *motion.rotation])

    scene, result = pressed(mu)
    block, ball = scene.bodies
    found = result.gradient({ball: weights}, of=["loads", "E"])
    assert found.value == pytest.approx(figure(), rel=1e-12)
    assert found.gaps == ()
    by_force = differences(lambda h: figure(force=-2000.0 + h), 0.05)
    assert abs(found.loads[ball][2] - by_force) < AGREE * abs(by_force)
    by_modulus = differences(lambda h: figure(modulus=210e3 + h), 5.0)
    assert abs(found.E[block] - by_modulus) < AGREE * abs(by_modulus)


def test_only_what_is_asked_for():
    scene = scene_of()
    result = scene.solve({scene.bodies[1]: (0.0, 0.0, -2000.0)}, finite_motion=False)
    whole, part = result.gradient("force"), result.gradient("force", of=["gaps"])
    np.testing.assert_array_equal(whole.gaps[0], part.gaps[0])
    assert not part.loads
    assert not part.E
    with refused(fc.InputError, "unknown-name", "'mass'"):
        result.gradient(of=["mass"])
    with refused(fc.InputError, "not-in-scene"):
        result.gradient({fc.RigidBody(fc.Plane()): np.zeros(6)})
    with refused(fc.InputError, "weights-shape", "6 components"):
        result.gradient({scene.bodies[1]: np.zeros(3)})


def test_two_free_motions_with_friction_against_central_differences():
    """A ball pressed and dragged by forces: the tangent is not symmetric, and both motions are free."""

    def figure(force=-2000.0, along=300.0):
        scene = scene_of(0.3)
        load = {scene.bodies[1]: (along, 0.0, force)}
        free = {scene.bodies[1]: "x z"}
        return scene, scene.solve(load, free=free, finite_motion=False, tolerance=1e-12)

    scene, result = figure()
    contact, ball = result.contacts[0], scene.bodies[1]
    assert contact.stick_area > 0
    assert contact.slip_area > 0
    found = result.gradient(of=["loads"]).loads[ball]
    for k, name, start in ((0, "along", 300.0), (2, "force", -2000.0)):
        slope = differences(lambda h, n=name, at=start: figure(**{n: at + h})[1].contacts[0].max_pressure, 0.05)
        assert abs(found[k] - slope) < AGREE * abs(found[2])


@pytest.mark.parametrize(
    ("what", "driven"),
    [
        ("tractions", {"force": 1.0, "tangential": (0.12, 0.03)}),
        pytest.param("tractions", {"approach": 0.85, "shift": (0.12, 0.02)}, marks=pytest.mark.full),
        pytest.param("max_pressure", {"force": 1.0, "tangential": (0.12, 0.03)}, marks=pytest.mark.full),
    ],
)
def test_friction_of_half_spaces_against_central_differences(what, driven):
    """By heights along a smooth field, by both loads and the modulus; tractions lift the surface, pressures drag it."""
    (normal, at), (tangential, along) = driven.items()
    x, y = (np.linspace(-1.375, 1.375, 12)[:, None], np.linspace(-1.375, 1.375, 12)[None, :])
    heights = (x**2 + 1.3 * y**2) / 2 + 0.003 * np.cos(5 * x + y)
    field, weights = np.sin(2 * x + 0.3) * np.cos(3 * y), np.stack([1 + x + y**2, 1 + x / 2 - y, 0.3 + x * y])

    def pressed(z=heights, E=1.0, by=0.0, drag=0.0):
        half = fc.HalfSpace(fc.Material(E, 0.2), size=(3.0, 3.0), cells=(12, 12))
        load = {normal: at + by, tangential: (along[0] + drag, along[1])}
        return half, half.press(z, friction=0.3, tolerance=1e-12, symmetry=False, **load)

    def figure(**given):
        contact = pressed(**given)[1]
        forces = np.stack([contact.pressure, *contact.traction])
        return contact.max_pressure if what == "max_pressure" else float((weights * forces).sum())

    half, contact = pressed()
    assert contact.sticking.any()
    assert contact.slipping.any()
    found = half.gradient(contact, weights if what == "tractions" else what, by_shift=tangential == "shift")
    assert found.value == pytest.approx(figure(), rel=1e-12)
    for slope, change in (
        ((found.heights * field).sum(), lambda h: figure(z=heights + h * field)),
        (found.load, lambda h: figure(by=h)),
        (found.tangential[0], lambda h: figure(drag=h)),
        (found.E, lambda h: figure(E=1.0 + h)),
    ):
        by = differences(change, 1e-6)
        assert abs(slope - by) < AGREE * max(abs(by), abs(found.value))


def test_points_about_to_open_are_listed():
    """Of two springs one just touches: forces are one-sided there, and it is told."""
    problem = ContactProblem(np.eye(3), np.array([-1.0, 0.0, 1.0]))
    assert weakly_active(problem, np.array([1.0, 0.0, 0.0]), np.zeros(0)).tolist() == [1]
    firm = ContactProblem(np.eye(3), np.array([-1.0, 0.5, 1.0]))
    assert not len(weakly_active(firm, np.array([1.0, 0.0, 0.0]), np.zeros(0)))


def test_what_has_no_gradient_is_refused(monkeypatch):
    half = half_space()
    ball = half.press(fc.surfaces.Paraboloid(1.0), force=1.4)
    with refused(fc.InputError, "unknown-name", "'peak'"):
        half.gradient(ball, "peak")
    with refused(fc.InputError, "input", "(64, 64)"):
        half.gradient(ball, np.ones(3))
    coarse = half_space(cells=16)
    rubbed = coarse.press(fc.surfaces.Paraboloid(1.0), force=0.2, friction=0.3)
    with refused(fc.InputError, "unknown-name", "'area'"):
        coarse.gradient(rubbed, "area")
    with refused(fc.InputError, "input", "(3, 16, 16)"):
        coarse.gradient(rubbed, np.ones((2, 16, 16)))
    monkeypatch.setattr(halfspace_gradient, "MOST_CELLS", 5)
    with refused(fc.InputError, "no-gradient", "coarser"):
        coarse.gradient(rubbed)
    scene = scene_of()
    load = {scene.bodies[1]: (0.0, 0.0, -100.0)}
    with refused(fc.InputError, "no-gradient", "finite_motion=False"):
        scene.solve(load, finite_motion=True).gradient()
    with refused(fc.InputError, "weights-shape"):
        scene.solve(load, finite_motion=False).gradient([1.0])
