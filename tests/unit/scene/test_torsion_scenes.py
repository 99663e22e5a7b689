"""Bodies of revolution with torsion: rigid motions, loads, both sides of a contact, results, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import read_scene
from fecontact.mesh.section_mesh import Extent

STEEL = fc.Material(E=1.0, nu=0.3, density=2.0)
#: A twist at which parts stick and others slide.
TURN = 0.003
TURNED = np.diag([1.0, -1.0, -1.0])


def ring(contact: str = "top", **options: object) -> fc.AxisymmetricBody:
    mesh = fc.sections.ring(1.0, 2.0, 1.0, (3, 2))
    other = {"top": "bottom", "bottom": "top"}[contact]
    return fc.AxisymmetricBody(mesh, STEEL, contact, {other: "xyz"}, **{"torsion": True, "name": "ring", **options})


def discs(friction: float = 0.3) -> tuple[fc.Scene, fc.AxisymmetricBody, fc.AxisymmetricBody]:
    """A disc on a ring, whose sides do not match, pressed and twisted."""
    lower = ring("top", name="lower")
    mesh = fc.sections.rectangle((2.5, 1.0), (9, 2)).translated((0, 0, 1.0))
    upper = fc.AxisymmetricBody(mesh, STEEL, "bottom", {"top": "xyz"}, torsion=True, name="upper")
    return fc.Scene([upper, lower], [fc.Contact(upper, lower, friction=friction)]), upper, lower


def twisted(scene: fc.Scene, body: fc.AxisymmetricBody, turn: float, **options: object) -> fc.ContactResult:
    down = -0.01 if body.name == "upper" else 0.01
    steps = [{"motions": {body: {"z": down, "rz": angle}}} for angle in (0.0, turn)]
    return scene.solve_path(steps, **options)[1]


@pytest.mark.parametrize("inner", [0.0, 0.5])
def test_a_free_body_has_two_rigid_motions(inner: float) -> None:
    """Along the axis and about it, without energy; the mass of the latter is its moment of inertia."""
    mesh = fc.sections.rectangle((1.0 - inner, 2.0), (2, 2), start=inner)
    model = fc.AxisymmetricBody(mesh, STEEL, torsion=True).model
    upper = model.stiffness.toarray()
    K = upper + upper.T - np.diag(upper.diagonal())
    free = np.setdiff1d(np.arange(model.n_dofs), model.held)
    size = np.linalg.eigvalsh(K[np.ix_(free, free)])
    assert (size[:2] < 1e-13 * size[-1]).all()
    assert size[2] > 1e-4 * size[-1]
    inertia = model.rigid_modes[:, 5] @ model.weighted_modes[:, 5]
    assert abs(inertia / (2.0 * math.pi / 2 * 2.0 * (1 - inner**4)) - 1) < 1e-12
    assert model.free_motions.shape == (6, 2)


def test_without_torsion_nothing_is_added() -> None:
    mesh = fc.sections.ring(1.0, 2.0, 1.0, (3, 2))
    plain, twist = (fc.AxisymmetricBody(mesh, STEEL, torsion=t).model for t in (False, True))
    assert plain.n_unknowns * 3 == twist.n_unknowns * 2
    one, other = plain.stiffness.toarray().reshape(-1, 3, len(mesh.points), 3), twist.stiffness.toarray()
    np.testing.assert_array_equal(one[:, [0, 2]][..., [0, 2]], other.reshape(one.shape)[:, [0, 2]][..., [0, 2]])


def test_torques_are_equal_and_opposite_and_of_the_tractions() -> None:
    scene, upper, lower = discs()
    result = twisted(scene, upper, TURN)
    c = result.contacts[0]
    f = c.friction
    assert 0 < f.sliding.sum() < f.touching.sum()
    torque = Extent(None).couples(c.points, f.forces).sum(axis=0)[2]
    sign = 1 if c.bodies[0] is c.slave else -1  # the moment is that on the body named first, tractions on the slave
    assert (
        abs(sign * c.moment[2] / torque - 1) < 2e-2
    )  # points of sides, whose forces act at means of the circumference
    reactions = [result.reaction(body)[5] for body in (upper, lower)]
    assert abs(sum(reactions)) < 1e-12 * abs(reactions[0])
    assert abs(abs(c.moment[2]) / abs(reactions[0]) - 1) < 1e-12
    assert abs(sum(result.reaction(body, "top" if body is upper else "bottom")[5] for body in (upper, lower))) < 1e-12
    np.testing.assert_allclose(sum(part.moment for part in c.regions), c.moment, atol=1e-14)
    assert result.friction.residuals.worst < 1e-10
    # the same by turning the other body, by sides in the other order, and turned half round with all of it
    other = twisted(scene, lower, -TURN)
    assert abs(other.reaction(upper)[5] / reactions[0] - 1) < 1e-10
    bodies = [body.placed(rotation=TURNED) for body in (upper, lower)]
    down = fc.Scene(bodies, [fc.Contact(*bodies[::-1], friction=0.3)])
    steps = [{"motions": {bodies[0]: {"z": 0.01, "rz": angle}}} for angle in (0.0, TURN)]
    assert abs(down.solve_path(steps)[1].reaction(bodies[0])[5] / reactions[0] - 1) < 1e-9


def test_a_twist_of_any_size_is_no_finite_motion() -> None:
    """The surface of a body of revolution stays as it is: poses do not turn, and the answer is the same."""
    scene, upper, _ = discs()
    small, large = (twisted(scene, upper, 4.0, finite_motion=finite) for finite in (False, True))
    assert small.contacts[0].friction.sliding.sum() == small.contacts[0].friction.touching.sum()
    assert not any("turn far" in text for text in small.warnings)
    np.testing.assert_allclose(large.reaction(upper)[5], small.reaction(upper)[5], rtol=2e-3)
    assert abs(large.rigid_motion(upper).rotation[2] - 4.0) < 1e-9
    once = scene.solve(motions={upper: {"z": -0.01, "rz": 4.0}})
    assert abs(once.reaction(upper)[5] / small.reaction(upper)[5] - 1) < 5e-2


def test_a_torque_on_a_boundary() -> None:
    """A circumferential traction r on the end of a tube is the torque int r^2 2 pi r dr, and twists it so far."""
    tube = ring()
    floor = fc.RigidBody(fc.Plane(), name="floor").placed((0, 0, 1.2)).placed(rotation=TURNED)
    scene = fc.Scene([tube, floor], [fc.Contact(tube, floor)])
    found = scene.solve(tractions={(tube, "top"): lambda x: np.outer(x[:, 0], (0.0, 1e-3, 0.0))})
    torque = 1e-3 * math.pi / 2 * (2.0**4 - 1)
    assert abs(found.reaction(tube)[5] / -torque - 1) < 1e-10
    turn = torque / (STEEL.shear_modulus * math.pi / 2 * 15)
    u = found._state.displacements[0].reshape(-1, 3)
    np.testing.assert_allclose(u[:, 1], turn * tube.mesh.points[:, 0] * tube.mesh.points[:, 2], atol=1e-12)


def test_friction_vanishes_on_the_axis() -> None:
    """Tractions across the axis have no direction there; round the axis they grow from zero as the radius."""
    mesh = fc.sections.rectangle((1.0, 1.0), (4, 2))
    disc = fc.AxisymmetricBody(mesh, STEEL, "bottom", {"top": "xyz"}, torsion=True)
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([disc, floor], [fc.Contact(disc, floor, friction=math.inf)])
    steps = [{"motions": {disc: {"z": -0.01, "rz": turn}}} for turn in (0.0, 0.02)]
    f = scene.solve_path(steps)[1].contacts[0].friction
    radius = scene.solve_path(steps)[1].contacts[0].points[:, 0]
    np.testing.assert_allclose(f.traction[:, 1], -STEEL.shear_modulus * 0.02 * radius, atol=1e-10)
    assert not f.traction[radius == 0].any()


@pytest.mark.parametrize("axis", [(0, 1, 0), (1, 0, 0)])
def test_two_coefficients_round_the_axis_and_across(axis: tuple[int, int, int]) -> None:
    """A ring that slides in all its width and is twisted: the coefficient round the axis; pressed alone the other."""
    body, floor = ring("bottom"), fc.RigidBody(fc.Plane())
    scene = fc.Scene([body, floor], [fc.Contact(body, floor, friction=(0.1, 0.3), friction_axis=axis)])
    steps = [{"motions": {body: {"z": -0.01, "rz": turn}}} for turn in (0.0, 5.0)]
    c = scene.solve_path(steps)[1].contacts[0]
    assert c.friction.sliding.all()
    mu = 0.1 if axis[1] else 0.3
    np.testing.assert_allclose(c.friction.traction[:, 1], -mu * c.pressure, rtol=1e-5)
    across = 0.4 - mu
    ratio = c.friction.traction[:, 0] / c.friction.traction[:, 1]
    slope = c.friction.slip[:, 0] / c.friction.slip[:, 1] * (across / mu) ** 2
    np.testing.assert_allclose(ratio, slope, atol=1e-9)


def test_results_and_files(tmp_path) -> None:
    scene, upper, _ = discs()
    result = twisted(scene, upper, TURN)
    figure = result.plot("friction")
    labels = [t.get_text() for t in figure.axes[0].get_legend().get_texts()]
    assert {"in the plane", "round the axis", "sticks", "slides"} <= set(labels)
    assert len(labels) == len(set(labels))
    result.save(tmp_path / "twist.vtu")
    result.save(tmp_path / "twist.csv")
    assert "torsion" in str(result)
    rows = scene.sweep([{"motions": {upper: {"z": -0.01, "rz": turn}}} for turn in (1e-3, 4.0)])
    assert len(rows) == 2


def test_a_scene_file_with_torsion(written) -> None:
    text = """
    [materials.steel]
    E = 1.0
    nu = 0.3
    [bodies.ring]
    type = "axisymmetric"
    torsion = true
    shape = {kind = "ring", inner = 1.0, outer = 2.0, height = 1.0, divisions = [2, 2]}
    material = "steel"
    contact = "bottom"
    supports = {top = "xyz"}
    [bodies.floor]
    type = "rigid"
    shape = {kind = "plane"}
    [[contacts]]
    slave = "ring"
    master = "floor"
    friction = 0.3
    [[steps]]
    motions.ring = {z = -0.01}
    [[steps]]
    motions.ring = {z = -0.01, rz = 0.01}
    """
    path = written(text, "twist.toml")
    found = read_scene(path)
    assert found.scene.twists
    assert found.scene.solve_path(found.steps)[1].contacts[0].moment[2] < 0


def mixed() -> fc.Scene:
    plain = fc.AxisymmetricBody(ring().mesh.translated((0, 0, -1.0)), STEEL, "top", {"bottom": "xz"}, name="plain")
    above = ring("bottom")
    return fc.Scene([above, plain], [fc.Contact(above, plain)])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ring(torsion=1.5), ("not-true-or-false", "Torsion")),
        (lambda: ring(torsion=False), ("support-components", "'x' and 'z'", "'xyz'")),
        (lambda: mixed(), ("mixed-dimensions",)),
    ],
)  # fmt: skip
def test_what_is_not_offered_is_refused(make, words: str) -> None:
    with refused(fc.InputError, *words):
        make()


def test_a_torque_without_torsion_is_refused_with_advice() -> None:
    mesh = fc.sections.ring(1.0, 2.0, 1.0, (3, 2))
    body = fc.AxisymmetricBody(mesh, STEEL, "bottom", {"top": "xz"})
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([body, floor], [fc.Contact(body, floor, friction=0.3)])
    with refused(fc.InputError, "motion-not-in-plane", "only z"):
        scene.solve(motions={body: {"z": -0.01, "rz": 0.1}})
    with refused(fc.InputError, "motion-not-in-plane", "only z"):
        scene.solve(motions={body: {"z": -0.01, "x": 0.1}})
