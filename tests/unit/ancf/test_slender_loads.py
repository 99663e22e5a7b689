"""Loads on lines, beams and plates: points within elements, loads along axes, pressures, moments in space."""

import numpy as np
import pytest
import scipy.linalg
from refusals import refused

import fecontact as fc
from fecontact.ancf import (
    Assembly,
    EnergyMomentum,
    FollowerPressure,
    Joints,
    Moment,
    Stage,
    equilibrium,
    force_at,
    move,
    traction,
)
from fecontact.ancf.slender import CorotationalBeam, beam, line, plate, straight, strip, thick_plate

RUBBER = fc.Material(E=12.0, nu=0.0)
POINTS = straight((0, 0, 0), (2, 0, 0), 2)
CORNERS = [(0, 0, 0), (2, 0, 0), (0, 1, 0)]
MEMBERS = {
    "line": lambda: line(POINTS, EA=5.0, EI=0.3),
    "strip": lambda: strip(POINTS, RUBBER, width=0.3, height=0.4),
    "beam": lambda: beam(POINTS, RUBBER, width=0.3, height=0.4),
    "plate": lambda: plate(CORNERS, (2, 1), RUBBER, 0.1),
    "shell": lambda: plate(CORNERS, (2, 2), RUBBER, 0.1, radius=0.8),
    "thick plate": lambda: thick_plate(CORNERS, (2, 1), RUBBER, 0.1),
}


@pytest.fixture(params=MEMBERS)
def member(request):
    return MEMBERS[request.param]()


def shaken(member, seed=0):
    """Coordinates turned by a large angle and shaken."""
    q = (member.q0.reshape(-1, 3) @ fc.rotation_about((1, 2, -1), 1.1).T).ravel()
    return q + 0.05 * np.random.default_rng(seed).uniform(-1, 1, len(q))


def clamped_at_zero(member, *more):
    joints = Joints([member])
    return Assembly([member], [joints.clamped((0, 0)), *more])


def test_a_force_within_an_element_and_a_load_along_the_axis_bend_a_bar_as_in_the_books():
    """Cubic elements are exact at their nodes: P a^2 (3 L - a) / (6 E I) and w L^4 / (8 E I), under small loads."""
    bar = line(straight((0, 0, 0), (2, 0, 0), 3), EA=1e4, EI=1.0)
    a = clamped_at_zero(bar)
    for load, exact in (
        (force_at(bar, (0.9, 0, 0), (0, 1e-5, 0)), 1e-5 * 0.9**2 * (3 * 2 - 0.9) / 6),
        (traction(bar, "axis", (0, 1e-5, 0)), 1e-5 * 2**4 / 8),
        (traction(bar, "axis", lambda x, t: x[:, [0]] * [[0, 1e-5, 0]]), 1e-5 * 11 * 2**5 / 120),
    ):
        q = equilibrium(lambda level, f=load: Stage(a, level * f), steps=1).last.q
        assert abs(q.reshape(-1, 2, 3)[-1, 0, 1] / exact - 1) < 1e-8  # geometry of the second order: 1e-9


def test_forces_and_pressures_have_their_resultants(member):
    at, f = member.positions(member.q0)[0] * 0.3 + member.positions(member.q0)[1] * 0.7, np.array([1.0, -2.0, 0.5])
    if len(member.cells[0]) == 2:
        middle = member.vectors[:, 0].mean(axis=0)
        exact = [*f, *np.cross(at - middle, f)]
        assert np.abs(force_at(member, at, f) @ member.rigid_modes - exact).max() < 1e-12
        assert np.abs(traction(member, "axis", f) @ member.rigid_modes - [*(2 * f), 0, 0, 0]).max() < 1e-12
        with refused(fc.InputError, "off-axis"):
            force_at(member, (0.5, 0.1, 0.0), f)
    else:
        radius = 0.8 if np.ptp(member.vectors[:, 0, 2]) > 0.1 else None
        along = (
            (2.0, 0.0) if radius is None else (2 * radius * np.sin(1 / radius), 2 * radius * (1 - np.cos(1 / radius)))
        )
        for side, sign in (("top", 1), ("bottom", -1)):
            Q = traction(member, side, lambda x, n: -3.0 * n) @ member.rigid_modes[:, :3]
            # cubic elements are an arc to 1e-4
            assert np.abs(Q - sign * 3.0 * np.array([0, along[1], -along[0]])).max() < 1e-3
    with refused(fc.InputError, "unknown-name", "boundary"):
        traction(member, "rim", f)


def test_loads_that_follow_have_the_derivative_they_say(member):
    q, step = shaken(member), 1e-6
    plated = len(member.cells[0]) == 4
    loads = [Moment(0, 1, (0.4, -1.0, 2.0)), *([FollowerPressure(0, "top", 2.0)] if plated else [])]
    for load in loads:
        K = load.tangent(member, q).toarray()
        for k in np.random.default_rng(1).choice(len(q), 12, replace=False):
            h = step * (np.arange(len(q)) == k)
            difference = (load.forces(member, q + h) - load.forces(member, q - h)) / (2 * step)
            assert np.abs(K[:, k] - difference).max() < 1e-7


def test_a_moment_does_its_work_on_turns_alone(member):
    """m . dtheta on a common turn, nothing on a shift; nothing along what has no other direction."""
    q, m = shaken(member), np.array([0.4, -1.0, 2.0])
    if member.vectors.shape[1] == 2 or member.name == "strip":
        t = q.reshape(len(member.vectors), -1, 3)[1, -1]
        m_does = m - (m @ t) / (t @ t) * t
    else:
        m_does = m
    Q = Moment(0, 1, m).forces(member, q)
    for e in np.eye(3):
        assert abs(np.cross(e, q.reshape(-1, 3)).ravel() @ Q - e @ m_does) < 1e-12
        assert abs(member.translation(e) @ Q) < 1e-15


@pytest.mark.parametrize(("kind", "n", "far"), [("line", 8, 2e-3), ("beam", 32, 1.5e-2), ("plate", 8, 2e-3)])
def test_an_end_moment_rolls_a_bar_up(kind, n, far):
    """2 pi E I / L: the axis is a circle, and its end where it began. Source: Euler and Bernoulli, nu = 0."""
    L, h = 10.0, 0.1
    steel = fc.Material(E=12 / h**3, nu=0.0)  # E I = 1 for a width of one
    if kind == "line":
        bar, end = line(straight((0, 0, 0), (L, 0, 0), n), EA=12 / h**2, EI=1.0), [n]
        more = [Joints([bar]).flat()]
    elif kind == "beam":
        bar, end, more = beam(straight((0, 0, 0), (L, 0, 0), n), steel, width=h, height=1.0), [n], []
    else:
        bar, end = plate([(0, 0, 0), (L, 0, 0), (0, 1, 0)], (n, 1), steel, h), [2 * n, 2 * n + 1]
        more = [Joints([bar]).clamped((0, 1))]
    axis = (0, 1, 0) if kind == "plate" else (0, 0, 1)
    a = clamped_at_zero(bar, *more)
    each = 2 * np.pi / L / len(end) * np.array(axis)
    path = equilibrium(lambda level: Stage(a, follow=[Moment(0, k, level * each) for k in end]), steps=8)
    assert path.success
    off = bar.positions(path.last.q)[end] - bar.positions(bar.q0)[[0, 1][: len(end)]]
    # cubic axes of 45 degrees an element, linear turns of a beam's section of 11
    assert np.abs(off).max() < far * L


def test_a_tube_widens_under_pressure_from_inside():
    """p R^2 / (E t), less by 1 + t^2 / (12 R^2) as the curvature of a Kirchhoff shell changes too; a quarter of it."""
    R, t, p, n = 1.0, 0.2, 1e-6, 6
    tube = plate([(0, 0, 0), (0.5, 0, 0), (0, R * np.pi / 2, 0)], (1, n), fc.Material(E=1.0, nu=0.0), t, radius=R)
    joints, planes = Joints([tube]), {(0, n + 1): [(0, 1, 0), (0, 0, 1)], (n, 2 * n + 1): [(0, 0, 1), (0, 1, 0)]}
    held = [joints.pinned((0, k), [(1, 0, 0)]) for k in range(n + 1)]
    for ends, (normal, along) in planes.items():
        for k in ends:
            held += [joints.pinned((0, k), [normal])]
            held += [joints.guided((0, k), 1, [normal]), joints.guided((0, k), 2, [along])]
    # the normal x cross y points inwards, so that pressure from inside acts on the top
    a = Assembly([tube], held)
    q = equilibrium(lambda level: Stage(a, follow=[FollowerPressure(0, "top", level * p)]), steps=1).last.q
    widened = np.linalg.norm((tube.positions(q) - [0, 0, R])[:, 1:], axis=1) - R
    assert np.abs(widened / (p * R**2 / t / (1 + t**2 / (12 * R**2))) - 1).max() < 1e-3


def test_followers_are_refused_where_there_is_nothing_to_turn():
    bent = CorotationalBeam(straight((0, 0, 0), (1, 0, 0), 1), EA=1.0, EI=1.0)
    with refused(fc.InputError, "no-bricks"):
        Stage(Assembly([bent], [Joints([bent]).clamped((0, 0))]), follow=[Moment(0, 0, (0, 0, 1))])
    bar = MEMBERS["line"]()
    with refused(fc.InputError, "unknown-node"):
        Moment(0, 7, (0, 0, 1)).forces(bar, bar.q0)
    with refused(fc.InputError, "unknown-name", "boundary"):
        FollowerPressure(0, "axis of the world", 1.0).forces(bar, bar.q0)


@pytest.mark.parametrize("name", ["line", "strip", "plate"])
def test_a_damped_bar_swings_less_by_its_ratio(name):
    """Free vibration of a cantilever in its first bending mode: a ratio t_r w / 2, and no energy unaccounted for."""
    retardation, material = 0.04, fc.Material(E=12e3, nu=0.0, density=1.0)
    bar = {
        "line": lambda: line(straight((0, 0, 0), (1, 0, 0), 4), EA=12.0, EI=1e-2, mass=1e-3),
        "strip": lambda: strip(straight((0, 0, 0), (1, 0, 0), 8), material, width=0.01, height=0.1),
        "plate": lambda: plate([(0, 0, 0), (1, 0, 0), (0, 0.1, 0)], (4, 1), material, 0.1),
    }[name]().damped(retardation)
    joints = Joints([bar])
    held = [joints.clamped((0, k)) for k in ((0, 1) if name == "plate" else (0,))]
    a = Assembly([bar], [*held, *([] if name == "plate" else [joints.flat()])])
    K, M = (a.free.T @ A @ a.free for A in (bar.tangent(bar.q0), bar.mass))
    values, modes = scipy.linalg.eigh(K.toarray(), M.toarray())
    w, mode = np.sqrt(values[0]), a.free @ modes[:, 0]
    n = 2  # periods
    period = 2 * np.pi / (w * np.sqrt(1 - (retardation * w / 2) ** 2))
    start = 1e-5 / np.abs(mode).max() * w * mode
    motion = move(a, until=n * period, step=period / 64, scheme=EnergyMomentum(), velocity=start, every=64)
    assert motion.drift < 1e-9
    speed = [abs(start @ bar.mass @ v) for v in (start, motion.now.v)]
    ratio = retardation * w / 2
    found = -np.log(speed[1] / speed[0]) / (2 * np.pi * n) * np.sqrt(1 - ratio**2)
    # the mid-point rule is off by (w h)^2 / 12 in the period, and by its square in the ratio
    assert abs(found / ratio - 1) < 0.01
