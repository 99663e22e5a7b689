"""Scenes with laws of finite strain: exact blocks, the hold of closed gaps, results in the present shape, refusals."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import brentq, fsolve

import fecontact as fc
from fecontact.common.path import in_parts
from fecontact.contact.hold import IndefiniteError, held, held_inside, semidefinite
from fecontact.results.linearisation import unbalanced
from fecontact.scene import finite_strain
from tests.refusals import refused

SIDES = {"bottom": "z", "x_min": "x", "y_min": "y"}


def uniaxial(law, stretch: float) -> tuple[float, float]:
    """Cauchy stress along a stretch, and the stretch across it, without stress across."""

    def stress(across: float) -> np.ndarray:
        return law.cauchy(np.diag([across, across, stretch])).diagonal()

    across = brentq(lambda s: stress(s)[0], 0.5, 3.0, xtol=1e-15)
    return stress(across)[2], across


def pressed_block(law, mesh=None, depth=0.5, mu=0.0, **given):
    """A block pressed from above by a plate; smooth sides."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8") if mesh is None else mesh
    body = fc.ElasticBody(mesh, law, contact="top", supports=SIDES, name="block")
    plate = fc.RigidBody(fc.Plane(), name="plate").placed((0, 0, -1.0)).placed(rotation=np.diag([1.0, -1, -1]))
    scene = fc.Scene([body, plate], [fc.Contact(body, plate, friction=mu)])
    return body, plate, scene.solve(motions={plate: {"z": -depth}}, **given)


def test_a_block_is_pressed_to_half_its_height() -> None:
    """Uniform stress, although the tangent is not positive definite there: closed gaps hold it."""
    law = fc.NeoHookean(E=2.0, nu=0.4)
    body, plate, result = pressed_block(law)
    stress, across = uniaxial(law, 0.5)
    contact = result.contacts[0]
    assert result._condensed.held_motions is not None
    assert np.abs(contact.pressure + stress).max() < 1e-8 * abs(stress)
    exact = body.mesh.points * [across - 1, across - 1, -0.5]
    assert np.abs(result.displacement(body) - exact).max() < 1e-9
    assert contact.area == pytest.approx(across**2, rel=1e-9)
    assert result.reaction(plate)[2] == pytest.approx(stress * across**2, rel=1e-8)
    assert result.reaction(body, "bottom")[2] == pytest.approx(-stress * across**2, rel=1e-8)
    assert result.boundary_motion(body, "top") == pytest.approx([(across - 1) / 2, (across - 1) / 2, -0.5], abs=1e-9)
    assert np.abs(result.stress(body) - [0, 0, stress, 0, 0, 0]).max() < 1e-8
    assert np.abs(result.strain(body)[:, 2] - np.log(0.5)).max() < 1e-9
    assert len(result.finite_strain) == 1
    assert result.finite_strain[0].iterations <= 6
    assert result.finite_strain[0].residual < 1e-8
    assert result.residuals().worst < 1e-8
    assert not [text for text in result.warnings if "strain" in text]


def test_remedies_name_only_what_laws_offer() -> None:
    pad = fc.ElasticBody(
        fc.shapes.block((4.0, 4.0, 2.0), (2, 2, 1), element="hex8"),
        fc.NeoHookean(E=1.0, nu=0.3),
        contact="top",
        supports={"bottom": "xyz"},
    )
    ball = fc.RigidBody(fc.Sphere(4.0)).placed((2.0, 2.0, 2.0))
    result = fc.Scene([pad, ball], [fc.Contact(pad, ball, friction=0.2)]).solve(motions={ball: {"z": -0.3}})
    texts = result.warnings + result.notes
    assert any("Refine the faces there or solve with accuracy=0.05." in text for text in texts)
    assert any("order of loads" in text for text in texts)


@pytest.mark.parametrize(
    "law",
    [
        fc.NeoHookean(E=1.0, nu=0.4999),
        fc.MooneyRivlin(c10=0.1, c01=0.05, bulk=100.0),
        fc.Ogden(mu=(0.3, 0.1), alpha=(2.0, -2.0), bulk=5.0),
        fc.HolmesMow(E=1.0, nu=0.2, beta=0.3),
        fc.StVenantKirchhoff(E=1.0, nu=0.3),
    ],
    ids=lambda law: type(law).__name__,
)
def test_every_law_is_its_closed_form_in_a_block(law) -> None:
    body, _, result = pressed_block(law, depth=0.3)
    stress, across = uniaxial(law, 0.7)
    assert np.abs(result.contacts[0].pressure / -stress - 1).max() < 2e-8
    assert np.abs(result.displacement(body)[:, 0] - (across - 1) * body.mesh.points[:, 0]).max() < 1e-8


@pytest.mark.parametrize("nu", [0.33, 0.34])
def test_constants_that_make_a_law_soft_are_warned_of(nu: float) -> None:
    _, _, result = pressed_block(fc.HolmesMow(E=1.0, nu=nu, beta=0.3), depth=0.01)
    told = [text for text in result.warnings if "'block': HolmesMow with nu = 0.34 softens" in text]
    assert len(told) == (nu > 1 / 3)


@pytest.mark.parametrize("nu", [0.33, 0.34])
def test_constants_that_make_a_law_soft_are_told_where_no_equilibrium_is_found(nu: float, monkeypatch) -> None:
    monkeypatch.setattr(finite_strain, "MAX_ITERATIONS", 1)
    monkeypatch.setattr(finite_strain, "in_parts", partial(in_parts, halvings=0))
    monkeypatch.setattr(finite_strain, "HALVINGS", 0)
    with pytest.raises(fc.SolverError) as caught:
        pressed_block(fc.HolmesMow(E=1.0, nu=nu, beta=0.3), depth=0.1)
    assert ("HolmesMow with nu = 0.34 softens" in str(caught.value)) == (nu > 1 / 3)


def fibred(law, sz: float) -> tuple[float, float, float]:
    """Cauchy stress along a stretch of z, and the stretches across it, of a law with its fibres along x."""

    def stress(across) -> np.ndarray:
        return law.cauchy(np.diag([*across, sz])).diagonal()

    sx, sy = fsolve(lambda s: stress(s)[:2], (1.0, 1.2), xtol=1e-14)
    return stress((sx, sy))[2], sx, sy


@pytest.mark.parametrize("nu", [0.3, 0.4999])
@pytest.mark.parametrize("turn", [None, fc.rotation_about((1.0, 2.0, 3.0), 0.7)], ids=["axes", "turned"])
def test_a_block_with_fibres_bulges_across_them(turn, nu: float) -> None:
    law = fc.Fibres(fc.NeoHookean(E=1.0, nu=nu), (1, 0, 0), ksi=2.0, alpha=1.5)
    stress, sx, sy = fibred(law, 0.6)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex20")
    mesh = mesh.mapped(lambda x: x + np.prod(np.sin(np.pi * x), axis=1)[:, None] * [0.12, -0.084, 0.096])
    R, sides = np.eye(3), SIDES
    if turn is not None:
        R = turn
        mesh = mesh.mapped(lambda x: x @ R.T)
        sides = {name: tuple(R[:, "xyz".index(c)]) for name, c in SIDES.items()}
        law = replace(law, direction=R[:, 0])
    body = fc.ElasticBody(mesh, law, contact="top", supports=sides, name="block", geometry="plain")
    plate = fc.RigidBody(fc.Plane(), name="plate").placed((0, 0, -1.0)).placed(rotation=np.diag([1.0, -1, -1]))
    plate = plate.placed(rotation=R)
    result = fc.Scene([body, plate], [fc.Contact(body, plate)]).solve(
        motions={plate: dict(zip("xyz", -0.4 * R[:, 2], strict=True))}
    )
    assert sx < 1.1 < 1.2 < sy
    assert np.abs(result.contacts[0].pressure / -stress - 1).max() < 1e-8
    exact = body.mesh.points @ R * [sx - 1, sy - 1, -0.4]
    assert np.abs(result.displacement(body) @ R - exact).max() < 1e-9
    assert len(result.finite_strain) == 1


@pytest.mark.parametrize("kind", ["plane", "revolved"])
def test_sections_are_pressed_as_solids_are(kind: str) -> None:
    law = fc.NeoHookean(E=1.0, nu=0.45)
    mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
    make = fc.PlaneBody if kind == "plane" else fc.AxisymmetricBody
    supports = {"bottom": "z", "left": "x"} if kind == "plane" else {"bottom": "z"}
    body = make(mesh, law, contact="top", supports=supports, name="section")
    plate = fc.RigidBody(fc.Plane(), name="plate").placed((0, 0, -1.0)).placed(rotation=np.diag([1.0, -1, -1]))
    result = fc.Scene([body, plate], [fc.Contact(body, plate)]).solve(motions={plate: {"z": -0.4}})
    if kind == "plane":
        across = brentq(lambda s: law.cauchy(np.diag([s, 1.0, 0.6]))[0, 0], 0.5, 3.0, xtol=1e-15)
        stress = law.cauchy(np.diag([across, 1.0, 0.6]))[2, 2]
        area = across
    else:
        stress, across = uniaxial(law, 0.6)
        area = np.pi * across**2
    assert np.abs(result.contacts[0].pressure / -stress - 1).max() < 1e-8
    assert abs(result.contacts[0].force[2]) == pytest.approx(-stress * area, rel=1e-8)
    assert np.abs(result.stress(body)[:, 2] / stress - 1).max() < 1e-7


def test_small_strains_are_the_linear_answer() -> None:
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (4, 4, 2), element="hex8")
    ball = fc.RigidBody(fc.Sphere(1e6), name="ball").placed((0, 0, 0.5))
    found = []
    for material in (fc.Material(E=1.0, nu=0.3), fc.NeoHookean(E=1.0, nu=0.3)):
        body = fc.ElasticBody(mesh, material, contact="top", supports={"bottom": "xyz"})
        found.append(fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -1e-7}}).contacts[0])
    linear, finite = found
    assert np.abs(linear.pressure - finite.pressure).max() < 1e-6 * linear.max_pressure


def test_a_force_presses_as_the_motion_that_it_makes() -> None:
    law = fc.NeoHookean(E=1.0, nu=0.3, density=2.0)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    body = fc.ElasticBody(mesh, law, contact=("top", "bottom"), supports={"x_min": "x", "y_min": "y"}, name="block")
    upper = fc.RigidBody(fc.Plane(), name="upper").placed((0, 0, -1.0)).placed(rotation=np.diag([1.0, -1, -1]))
    lower = fc.RigidBody(fc.Plane(), name="lower")
    contacts = [fc.Contact(body, upper, ("top", "surface")), fc.Contact(body, lower, ("bottom", "surface"))]
    scene = fc.Scene([body, upper, lower], contacts)
    stress, across = uniaxial(law, 0.7)
    result = scene.solve(forces={upper: (0, 0, stress * across**2)})
    assert result.rigid_motion(upper).translation[2] == pytest.approx(-0.3, abs=1e-8)
    assert np.abs(result.contacts[1].pressure / -stress - 1).max() < 1e-7
    # the weight is that of the initial volume
    heavy = scene.solve(motions={upper: {"z": -0.3}}, gravity=(0, 0, -0.01))
    carried = heavy.contacts[1].total_force - heavy.contacts[0].total_force
    assert carried == pytest.approx(0.02, rel=1e-8)


def test_friction_holds_the_sides_of_a_pressed_block() -> None:
    """Rough plate: its face keeps its width, and bulges below; with little friction it slides at the limit."""
    law = fc.NeoHookean(E=1.0, nu=0.45)
    body, _, rough = pressed_block(law, depth=0.3, mu=np.inf)
    top = body.mesh.boundary_nodes("top")
    assert np.abs(rough.displacement(body)[top][:, :2]).max() < 1e-8
    assert rough.contacts[0].total_force > 1.02 * pressed_block(law, depth=0.3)[2].contacts[0].total_force
    _, _, slides = pressed_block(law, depth=0.3, mu=0.05)
    friction = slides.contacts[0].friction
    sliding = friction.sliding
    assert sliding.sum() > 3
    forces = np.linalg.norm(friction.forces, axis=1)
    assert np.abs(forces - 0.05 * slides.contacts[0].forces)[sliding].max() < 1e-9


def test_a_turned_scene_and_other_units_have_the_same_answer() -> None:
    law = fc.NeoHookean(E=1.0, nu=0.45)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")

    def force(mesh, law, turn, unit):
        body = fc.ElasticBody(mesh, law, contact="top", supports={"bottom": "xyz"}, name="block").placed(rotation=turn)
        ball = fc.RigidBody(fc.Sphere(2.0 * unit), name="ball").placed((0.4 * unit, 0.5 * unit, unit))
        ball = ball.placed(rotation=turn)
        motion = dict(zip("xyz", turn @ [0, 0, -0.3 * unit], strict=True))
        return fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: motion}).contacts[0].force

    straight = force(mesh, law, np.eye(3), 1.0)
    turn = fc.rotation_about((1.0, 2.0, 3.0), 0.8)
    assert np.abs(force(mesh, law, turn, 1.0) - turn @ straight).max() < 1e-9 * np.linalg.norm(straight)
    large = force(mesh.mapped(lambda x: 1e3 * x), fc.NeoHookean(E=1e6, nu=0.45), np.eye(3), 1e3)
    assert np.abs(large / 1e12 - straight).max() < 1e-9 * np.linalg.norm(straight)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 25.4])
def test_a_body_that_carries_no_force_is_certified_in_any_unit(unit: float) -> None:
    # a ball between the corners of one cell: what is left on its nodes is rounding
    mesh = fc.shapes.block((1.1 * unit, 0.9 * unit, 0.7 * unit), (1, 1, 1), element="hex8")
    body = fc.ElasticBody(mesh, fc.NeoHookean(3.0 / unit**2, 0.49), "top", {"bottom": "xyz"}, name="soft")
    ball = fc.RigidBody(fc.Sphere(2.0 * unit), name="ball")
    ball = ball.placed((0.5 * unit, 0.4 * unit, 0.74 * unit))
    result = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -0.03 * unit}})
    assert result.contacts[0].total_force == 0
    assert result.residuals().equilibrium <= 1e-8
    # a force of a strain of 1e-12 is seen
    part = result._condensed.parts[0]
    inner = result._forces_inside(part.body).ravel()
    inner[3 * int(np.argmax(mesh.points[:, 2]))] += 1e-12 * body.size * float(body.model.stiffness.diagonal().max())
    assert unbalanced(part, np.zeros(result.problem.n), inner) >= 9e-6


def test_a_linear_body_is_the_partner_of_a_soft_one() -> None:
    """A pad glued to nothing on a stiff linear block is pressed as on a rigid plate, up to the stiffness' ratio."""
    pad_law = fc.NeoHookean(E=1.0, nu=0.0)
    pad = fc.shapes.block((1.0, 1.0, 0.5), (2, 2, 1), element="hex8")
    base = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    stiff = fc.ElasticBody(base, fc.Material(E=1e6, nu=0.0), contact="top", supports={"bottom": "xyz"}, name="stiff")
    sides = {"top": "z", "x_min": "x", "y_min": "y"}
    soft = fc.ElasticBody(pad, pad_law, contact="bottom", supports=sides, name="pad").placed((0, 0, 1.0))
    result = fc.Scene([soft, stiff], [fc.Contact(soft, stiff)]).solve(motions={soft: {"z": -0.2}})
    stress, _ = uniaxial(pad_law, 0.6)
    assert np.abs(result.contacts[0].pressure / -stress - 1).max() < 1e-5
    assert result.displacement(stiff)[:, 2].min() == pytest.approx(stress / 1e6, rel=1e-3)


def test_what_is_not_offered_is_refused() -> None:
    law = fc.NeoHookean(E=1.0, nu=0.45)
    for given in ({"search": "local"}, {"finite_motion": False}):
        with refused(fc.InputError, "finite-strain", next(iter(given))):
            pressed_block(law, **given)
    body, _, _ = pressed_block(law, depth=0.1)
    ring = fc.shapes.thick_ring(1.0, 2.0, 0.5, (4, 2, 1))
    with refused(fc.InputError, "finite-strain", "curved"):
        fc.ElasticBody(ring, law, contact="outer", supports={"inner": "n"})
    fc.ElasticBody(ring, law, contact="outer", supports={"sym_x": "n", "sym_y": "n", "bottom": "n"})
    with refused(fc.InputError, "finite-strain", "AncfBody"):
        fc.AncfBody(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), law)
    with refused(fc.InputError, "finite-strain", "block"):
        body.reduce(None, None, None)  # type: ignore[arg-type]


def test_too_much_is_refused_and_nothing_is_turned_inside_out() -> None:
    with refused(fc.SolverError, "no-equilibrium"):
        pressed_block(fc.NeoHookean(E=1.0, nu=0.3), depth=1.2)


def test_held_points_make_an_indefinite_problem_definite_with_the_same_answer() -> None:
    """One stiffness -1 beside the springs of two closed points, against the equations of these alone."""
    K = np.array([[1.0, -1.2, 0.0], [-1.2, 1.0, 0.3], [0.0, 0.3, 2.0]])
    S, g = np.linalg.inv(K), np.array([-0.3, -0.1, 0.05])
    assert np.linalg.eigvalsh(S)[0] < 0
    none = np.zeros((0, 3)), np.zeros(0)
    found = held(S, g, *none, np.array([True, True, False]))
    assert np.linalg.eigvalsh(found.S)[0] > 0
    closed = np.linalg.solve(S[:2, :2], -g[:2])  # gaps zero on both
    forces = np.append(closed, 0.0)
    assert np.abs(found.S @ forces + found.g)[:2].max() < 1e-12
    assert (found.S @ forces + found.g)[2] == pytest.approx((S @ forces + g)[2], abs=1e-12)
    assert semidefinite(np.eye(3))
    assert not semidefinite(S)
    with refused(IndefiniteError, "indefinite"):
        held(S, g, *none, np.zeros(3, bool))


def test_held_points_eliminate_free_motions() -> None:
    K = np.array([[1.0, 1.2], [1.2, 1.0]])
    S, g, B, F = np.linalg.inv(K), np.array([0.1, 0.2]), np.ones((1, 2)), np.array([3.0])
    found = held(S, g, B, F, np.array([True, True]))
    exact = np.linalg.solve(np.block([[S, B.T], [B, np.zeros((1, 1))]]), np.concatenate([-g, F]))
    assert np.abs(found.S @ exact[:2] + found.g).max() < 1e-10
    assert found.motions(exact[:2]) == pytest.approx(exact[2:], abs=1e-10)


def test_springs_of_a_body_at_a_state_are_replaced() -> None:
    body, _, _ = pressed_block(fc.NeoHookean(E=1.0, nu=0.3), depth=0.1)
    model = body._linearised(body._finite_strain.rest, body.pose).model
    bare = model.solved_stiffness().toarray()
    row = sp.csr_matrix(([1.0], ([0], [model.n_dofs - 1])), shape=(1, model.n_dofs))
    for _ in range(2):
        strength = model.stiffen(row)
        assert abs((model.solved_stiffness().toarray() - bare).sum() - strength) < 1e-9 * strength
    model.stiffen(row[:0])
    assert np.array_equal(model.solved_stiffness().toarray(), bare)


@pytest.mark.parametrize("least", [-0.5, 0.0, 1e-13])
def test_springs_inside_a_body_do_not_need_its_inverse(least: float) -> None:
    """A stiffness that is indefinite, or (nearly) singular, pressed by a free plane on two rows of it."""
    axes = np.linalg.qr(np.array([[1.0, 1.0, 0.0], [-1.0, 0.5, 0.3], [0.2, 0.3, 1.0]]))[0]  # gaps resist the first
    K = axes @ np.diag([least, 2.0, 3.0]) @ axes.T
    C, f, g = np.array([[1.0, 0, 0], [0, 1, 0]]), np.array([0.1, -0.2, 0.3]), np.array([0.1, 0.2])
    B, F, w = np.ones((1, 2)), np.array([1.0]), 50.0
    inverse = np.linalg.inv(K + w * C.T @ C)
    springs = np.full(2, w)
    found = held_inside(C @ inverse @ C.T, g, C @ inverse @ f, B, F, springs)
    # u, forces and the motion from K u = f + C^T l, C u + g + B^T q = 0, B l = F
    zero = np.zeros((2, 2)), np.zeros((1, 1))
    left = np.block([[K, -C.T, np.zeros((3, 1))], [C, zero[0], B.T], [np.zeros((1, 3)), B, zero[1]]])
    u, forces, q = np.split(np.linalg.solve(left, np.concatenate([f, -g, F])), [3, 5])
    assert np.abs(found.S @ forces + found.g).max() < 1e-12
    assert found.motions(forces) == pytest.approx(q, abs=1e-11)
    pulled = springs * (g + B.T @ q)
    assert np.abs(inverse @ (f + C.T @ (forces - pulled)) - u).max() < 1e-12
