"""Friction of slender members at their skin, and of one on another."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact.ancf import Assembly, Joints, Stage, equilibrium
from fecontact.ancf.slender import beam, line, plate, straight, strip, thick_plate
from fecontact.ancf.slender.closest import Middle
from fecontact.ancf.slender.contact import skin

X, Y, Z = np.eye(3)
MATERIAL = fc.Material(E=3.0, nu=0.3, density=2.0)
POINTS = straight((0, 0, 0), (2, 0, 0), 2)
CORNERS = [(0, 0, 0), (2, 0, 0), (0, 1, 0)]
MADE = {
    "line": lambda: line(POINTS, EA=5.0, EI=0.3),
    "strip": lambda: strip(POINTS, MATERIAL, width=0.3, height=0.4),
    "beam": lambda: beam(POINTS, MATERIAL, width=0.3, height=0.4),
    "plate": lambda: plate(CORNERS, (2, 1), MATERIAL, 0.1),
    "thick plate": lambda: thick_plate(CORNERS, (2, 1), MATERIAL, 0.1),
}


def bound(members, *contact, **friction):
    """Constraints of a contact between free members."""
    return Assembly(members, [], [fc.Contact(*contact, **friction)]).constraints[0]


def places(middle, rng):
    """Some elements, coordinates on them, and fibres."""
    n = 4
    each = rng.integers(len(middle.structure.cells), size=n)
    return each, rng.random((n, middle.n_axes)), 0.2 * rng.normal(size=(n, 3))


@pytest.mark.parametrize("name", MADE)
def test_points_of_the_skin_follow_a_rigid_motion(name):
    """By any angle, and a line by any turn that is not about its axis."""
    s, rng = MADE[name](), np.random.default_rng(0)
    middle, (each, local, fibre) = Middle(s, 0), places(Middle(s, 0), rng)
    if name in ("line", "strip"):
        # a line's fibres are fixed in turns across its axis; a strip's lie in its plane
        fibre[:, 2] = 0.0
    bent = (
        s.q0
        if name == "line"
        else s.q0 + 0.05 * rng.normal(size=s.n_dofs) * np.array([1, 1, name != "strip"] * (s.n_dofs // 3))
    )
    turn, shift = Rotation.from_rotvec([0, 0, 1.2] if name == "line" else [0.7, -1.1, 2.0]), np.array([3.0, -2.0, 1.0])
    moved = turn.apply(bent.reshape(-1, 3)).reshape(s.vectors.shape)
    moved[:, 0] += shift
    _, then, now = skin(middle, (bent, moved.ravel()), each, local, turn.apply(fibre))
    assert now == pytest.approx(turn.apply(then) + shift, abs=1e-12)
    assert then == pytest.approx(middle.at(bent, each, local)[0] + fibre, abs=1e-12)


@pytest.mark.parametrize("name", MADE)
def test_displacements_of_the_skin_are_derivatives(name):
    """The way back from a displaced state to where a fibre came from, by differences."""
    s, rng, h = MADE[name](), np.random.default_rng(1), 1e-6
    middle, (each, local, fibre) = Middle(s, 0), places(Middle(s, 0), rng)
    q, d = s.q0 + 0.05 * rng.normal(size=s.n_dofs), rng.normal(size=s.n_dofs)
    rows, _, _ = skin(middle, (q, q), each, local, fibre)
    ahead, behind = (skin(middle, (q + step * d, q), each, local, fibre)[1] for step in (h, -h))
    assert (rows @ d).reshape(-1, 3) == pytest.approx((ahead - behind) / (2 * h), abs=1e-7)


@pytest.mark.parametrize("kind", ["beams", "lines"])
def test_a_common_motion_is_no_slip(kind):
    """Of two members that touch, and friction has neither resultant nor moment."""
    axes = straight((-1, 0, 0.1), (1, 0, 0.1), 3), straight((0.1, -1, 0), (0, 1, 0), 3)
    if kind == "beams":
        made = [beam(points, MATERIAL, width=0.1, height=0.1) for points in axes]
    else:
        made = [line(points, EA=1.0, EI=1.0) for points in axes]
    contact = bound(made, made[0].side(0.05), made[1].side(0.05), friction=0.3)
    q = np.concatenate([s.q0 for s in made])
    # about the normal of the crossing, where lines have no twist
    turn = Rotation.from_rotvec([0, 0, 0.8] if kind != "beams" else [0.4, -0.8, 1.2])
    moved = turn.apply(q.reshape(-1, 3))
    part = contact.at(moved.ravel())
    rows, slid = contact.relative_displacement(part, q, moved.ravel(), contact.master.pose)
    seen = ~part.pairs.hidden & (part.projection.gap < 0.05 + 1e-9)
    assert seen.any()
    across = slid - (slid * part.projection.normals).sum(axis=1)[:, None] * part.projection.normals
    assert across[seen] == pytest.approx(0.0, abs=1e-9)
    spun = np.stack([np.cross(e, moved).ravel() for e in ([X, Y, Z] if kind == "beams" else [Z])], axis=1)
    assert (rows @ spun).reshape(len(seen), 3, -1)[seen] == pytest.approx(0.0, abs=1e-9)


def test_a_shaft_is_turned_by_a_plane_that_moves_across():
    """Friction at the skin of a beam that only twists. Source: Saint-Venant, torque G J angle / length.

    Its last element, short, is turned by the way of the plane over the radius; its section hardly yields to shear.
    """
    E, nu, radius, J, way, end = 100.0, 0.25, 0.05, 2e-7, 1e-5, 0.01
    x = [0.0, 0.3, 0.6, 1.0 - end, 1.0]
    shaft = beam(np.outer(x, X) + radius * Z, fc.Material(E=E, nu=nu), width=2 * radius, height=2 * radius, torsion=J)
    joints, ends = Joints([shaft]), range(1, 5)
    held = [joints.clamped((0, 0))]
    for k in ends:
        held += [joints.pinned((0, k), [X, Y]), joints.guided((0, k), 1, Y), joints.guided((0, k), 2, Y)]
        held.append(joints.guided((0, k), 3, Z))
    floor = fc.RigidBody(fc.Plane())
    touch = fc.Contact(shaft.side(radius, [3]), floor, friction=math.inf)
    a, load = Assembly([shaft], held, [touch]), np.zeros(shaft.n_dofs)
    load[[-10, -22]] = -1e-6
    path = equilibrium(lambda level: Stage(a.with_rigid(floor.placed((0, level * way, 0))), forces=load), steps=1)
    assert path.success
    dragged = path.last.friction.forces[0].sum(axis=0)
    torque = E / (2 * (1 + nu)) * J * way / radius / (1 - 2 * end / 3)
    assert dragged[1] * radius == pytest.approx(torque, rel=3e-3)


@pytest.mark.parametrize("mu", [0.0, math.inf])
def test_rough_bars_bend_as_one(mu):
    """Two equal stacked cantilevers under the weight of the upper one: four times as stiff where they cannot slide.

    Source: parallel axes, 2 (E b h^3 / 12 + E b h (h / 2)^2) = E b (2 h)^3 / 12.
    """
    h, EA, weight, n = 0.1, 1200.0, 1e-3, 8
    EI = EA * h**2 / 12
    made = [line(straight((0, up, 0), (1, up, 0), n), EA=EA, EI=EI, mass=weight) for up in (h, 0.0)]
    joints = Joints(made)
    # the clamps let the axes stretch
    held = [c for k in (0, 1) for c in (joints.pinned((k, 0)), joints.guided((k, 0), 1, Y))]
    conditions = [joints.flat(), *held]
    a = Assembly(made, conditions, [fc.Contact(made[0].side(h / 2), made[1].side(h / 2), friction=mu)])
    load = np.concatenate([made[0].mass @ made[0].translation(-Y), np.zeros(made[1].n_dofs)])
    path = equilibrium(lambda level: Stage(a, forces=level * load), steps=1)
    assert path.success
    deflection = h - made[0].positions(a.part(path.last.q, 0))[-1, 1]
    times = 8 if mu else 2
    assert deflection == pytest.approx(weight / (8 * times * EI), rel=1e-4)


def test_a_bar_is_drawn_across_another():
    """A cantilever, pressed on another by its end, is drawn along its axis: the other yields until it slides.

    Source: Coulomb's mu N, and linear theory for what yields, mu N (b^3 / (3 EI) + a / EA).
    """
    mu, at, under, bend, EA, way = 0.3, 0.63, 0.44, 2.0, 1e4, 4e-4
    one = line(straight((0, 0, 0.02), (1, 0, 0.02), 5), EA=EA, EI=bend)
    other = line(straight((at, -under, 0), (at, 0.2, 0), 4), EA=EA, EI=bend)
    joints = Joints([one, other])
    held = [joints.clamped((0, 0)), joints.clamped((1, 0))]
    a = Assembly([one, other], held, [fc.Contact(one.side(0.01), other.side(0.01), friction=mu)])
    load = np.zeros(a.n_dofs)
    load[one.n_dofs - 4] = -1e-2
    pressed = equilibrium(lambda level: Stage(a, forces=level * load), steps=1)
    motion = joints.motion(held, [[*(-way * X), 0.0, 0.0], None])
    path = equilibrium(lambda level: Stage(a, forces=load, motion=level * motion), steps=3, start=pressed.last)
    assert path.success
    end, normal = path.last.friction, path.last.forces[0].sum()
    dragged = end.forces[0].sum(axis=0)
    assert np.linalg.norm(dragged) == pytest.approx(mu * normal, rel=1e-9)
    # bars that turn under their loads drag a little along the other, too
    assert dragged[0] == pytest.approx(mu * normal, rel=1e-3)
    assert end.residuals.slip < 1e-9
    # what pressing alone had dragged, by the turn of the bars at their skin, counts from there
    dragged -= pressed.last.friction.forces[0].sum(axis=0)
    slid = way - dragged[0] * (under**3 / (3 * bend) + at / EA)
    assert sum(s.friction.friction_work for s in path.steps[1:]) == pytest.approx(mu * normal * slid, rel=1e-3)
