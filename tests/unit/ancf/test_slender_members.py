"""Slender members in contact with each other, beside linear theory of beams and strings."""

import math

import numpy as np
import pytest
from refusals import refused
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    Assembly,
    EnergyMomentum,
    GeneralisedAlpha,
    Joints,
    Stage,
    equilibrium,
    move,
)
from fecontact.ancf.slender import line, plate, straight, strip
from fecontact.ancf.slender.closest import Middle, closest

X, Y, Z = np.eye(3)


def bound(members, *contact, **friction):
    """Constraints of a contact between free members."""
    return Assembly(members, [], [fc.Contact(*contact, **friction)]).constraints[0]


def crossed(angle, n=(5, 4), radii=(0.05, 0.04), apart=0.0, at=(0.37, -0.21)):
    """Two lines across each other, one above the other, which their middles are off the crossing."""
    way = np.array([math.cos(angle), math.sin(angle), 0.0])
    high = np.array([0, 0, sum(radii) + apart])
    one = line(straight(at[0] * X - X + high, at[0] * X + X + high, n[0]), EA=1e3, EI=1.0, mass=1.0)
    other = line(straight(at[1] * way - way, at[1] * way + way, n[1]), EA=1e3, EI=1.0, mass=1.0)
    return [one, other], bound([one, other], one.side(radii[0]), other.side(radii[1]))


def start(structures):
    return np.concatenate([s.q0 for s in structures])


def noisy(structures, size, seed=0):
    return start(structures) + size * np.random.default_rng(seed).normal(size=sum(s.n_dofs for s in structures))


CASES = {
    "crossing": lambda: crossed(1.1),
    "crossing at a small angle": lambda: crossed(0.15),
    "along": lambda: crossed(0.0, at=(0.37, -0.21)),
    "on a plate": lambda: on_a_plate(),
    "plates": lambda: plates(),
    "end of a strip on another": lambda: strips(),
}


def on_a_plate():
    sheet = plate([(-1, -1, 0), (1, -1, 0), (-1, 1, 0)], (2, 3), fc.Material(E=1e3, nu=0.3), 0.1)
    bar = line(straight((-0.7, 0.1, 0.09), (0.6, 0.3, 0.09), 3), EA=1e3, EI=1.0)
    return [bar, sheet], bound([bar, sheet], bar.side(0.04), sheet.side(0.05))


def strips():
    rubber = fc.Material(E=1e3, nu=0.3)
    made = [
        strip(points, rubber, width=0.1, height=0.1)
        for points in (straight((0.3, 0.12, 0), (0.6, 1, 0), 2), straight((0, 0, 0), (1, 0, 0), 3))
    ]
    return made, bound(made, made[0].side(0.05), made[1].side(0.05))


def plates():
    made = [
        plate([(-a, -a, h), (a, -a, h), (-a, a, h)], (2, 2), fc.Material(E=1e3, nu=0.3), 0.1)
        for a, h in ((0.7, 0.1), (1.0, 0.0))
    ]
    return made, bound(made, made[0].side(0.05), made[1].side(0.05))


@pytest.mark.parametrize("case", CASES)
def test_gradient_and_second_derivative_of_the_gaps(case):
    """Central differences along a random direction, in a deformed state."""
    structures, contact = CASES[case]()
    q, d, h = noisy(structures, 0.01), np.random.default_rng(1).normal(size=contact.n_dofs), 1e-6
    now, ahead, behind = contact.at(q), contact.at(q + h * d), contact.at(q - h * d)
    seen = np.isfinite(now.gap)
    assert now.G[seen] @ d == pytest.approx((ahead.gap[seen] - behind.gap[seen]) / (2 * h), abs=1e-6)
    forces = np.where(seen, np.random.default_rng(2).random(len(seen)), 0.0)
    bent = contact.curvature(now, forces)
    change = (ahead.G - behind.G).T @ forces / (2 * h)
    assert bent @ d == pytest.approx(change, abs=1e-5 * np.abs(change).max())
    assert abs(bent - bent.T).max() < 1e-9 * abs(bent).max()


@pytest.mark.parametrize("case", CASES)
def test_action_is_reaction_in_force_and_moment(case):
    """Contact forces on both members have no resultant and no moment, and follow a common motion."""
    structures, contact = CASES[case]()
    q = noisy(structures, 0.01)
    now = contact.at(q)
    turn, shift = Rotation.from_rotvec([0.3, -1.1, 0.7]), np.array([3.0, -2.0, 1.0])
    vectors = turn.apply(q.reshape(-1, 3))
    at = np.concatenate([s.vectors.shape[1] * np.arange(len(s.vectors)) for s in structures[:1]])
    first = len(structures[0].vectors) * structures[0].vectors.shape[1]
    at = np.concatenate([at, first + structures[1].vectors.shape[1] * np.arange(len(structures[1].vectors))])
    arms = q.reshape(-1, 3).copy()
    push = np.zeros_like(arms)
    push[at] = 1.0
    vectors[at] += shift
    moved = contact.at(vectors.ravel())
    assert moved.gap == pytest.approx(now.gap, abs=1e-12)
    G = now.G.toarray().reshape(len(now.gap), -1, 3)
    assert np.abs(G[:, at].sum(axis=1)).max() < 1e-12
    assert np.abs(np.cross(arms, G).sum(axis=1)).max() < 1e-12
    assert moved.G.toarray() == pytest.approx(turn.apply(G.reshape(-1, 3)).reshape(moved.G.shape), abs=1e-11)


def lift(path, a, of=0):
    """Resultant contact force on the slave of a contact, upwards (z)."""
    part, k = a.conditions(path.last.q).parts[of], a.starts.index(a.constraints[of].slave_start)
    forces = a.part(part.G.T @ path.last.forces[of], k)
    return float(a.solids[k].translation(Z) @ forces)


@pytest.mark.parametrize(
    ("angle", "at", "under"),
    [(90.0, 0.63, 0.44), (30.0, 0.63, 0.44), (8.0, 0.63, 0.44), (90.0, 1.0, 0.3), (50.0, 0.6, 0.6)],
)
def test_two_crossing_cantilevers(angle, at, under):
    """One on the other, its end loaded. Source: linear theory, P (3 L a^2 - a^3) / (6 EI) and the like.

    They touch between nodes, at the end of one, and at the end of the other and a node of the first.
    """
    bend, other_bend, span, load = 2.0, 3.0, 1.0, 1e-4
    way = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle)), 0.0])
    begin = at * X - under * way
    one = line(straight((0, 0, 0.02), (span, 0, 0.02), 5), EA=1e4, EI=bend)
    other = line(straight(begin, begin + 0.6 * way, 4), EA=1e4, EI=other_bend)
    joints = Joints([one, other])
    conditions = [joints.clamped((0, 0)), joints.clamped((1, 0))]
    a = Assembly([one, other], conditions, [fc.Contact(one.side(0.01), other.side(0.01))])
    forces = np.zeros(a.n_dofs)
    forces[one.n_dofs - 4] = -load
    path = equilibrium(lambda level: Stage(a, forces=level * forces), steps=1)
    assert path.success
    flexible = at**3 / (3 * bend) + under**3 / (3 * other_bend)
    expected = load * (3 * span * at**2 - at**3) / (6 * bend) / flexible
    # ends that deflect by 1e-5 of their length
    assert lift(path, a) == pytest.approx(expected, rel=1e-4)


def test_a_crossing_passes_from_element_to_element():
    """A cantilever under an end load slides along itself over another. Source: linear theory at its last place."""
    bend, under, at, way, load = 2.0, 0.44, 0.63, 0.3, 5e-3
    one = line(straight((0, 0, 0.02), (1, 0, 0.02), 10), EA=1e4, EI=bend)
    other = line(straight((at, -under, 0), (at, 0.2, 0), 8), EA=1e4, EI=bend)
    joints = Joints([one, other])
    held = [joints.clamped((0, 0)), joints.clamped((1, 0))]
    a = Assembly([one, other], held, [fc.Contact(one.side(0.01), other.side(0.01))])
    forces, motion = np.zeros(a.n_dofs), joints.motion(held, [[*(way * X), 0.0, 0.0], None])
    forces[one.n_dofs - 4] = -load
    path = equilibrium(lambda level: Stage(a, forces=min(1, 3 * level) * forces, motion=level * motion), steps=3)
    assert path.success
    assert [int(s.forces[0].argmax()) for s in path.steps] == [5, 4, 3]
    rest = at - way
    expected = load * (3 * rest**2 - rest**3) / (6 * bend) / ((rest**3 + under**3) / (3 * bend))
    # a cubic element leaves out how it bends by itself under a force within, 1e-4 of the whole
    assert lift(path, a) == pytest.approx(expected, rel=5e-4)


@pytest.mark.parametrize("n", [(16, 16), (17, 20)])
def test_a_taut_cable_laid_across_another(n):
    """Crossing at nodes and between them; one is let down on the other.

    A string of tension T, which bends with EI, yields at its middle by F L / (4 T) (1 - tanh(z) / z), where z is L / 2
    sqrt(T / EI) (S. P. Timoshenko, Strength of Materials II, chapter 2).
    """
    stretch, down, low, EA, EI, r = 1e-2, 1e-4, 1.3, 100.0, 2.5e-3, 0.02
    one = line(straight((-0.5, 0, 2 * r), (0.5, 0, 2 * r), n[0]), EA=EA, EI=EI)
    other = line(straight((0, -low / 2, 0), (0, low / 2, 0), n[1]), EA=EA, EI=EI)
    joints, ends = Joints([one, other]), [(0, 0), (0, -1), (1, 0), (1, -1)]
    held = [joints.pinned(e) for e in ends]
    a = Assembly([one, other], held, [fc.Contact(one.side(r), other.side(r))])
    pull = [-stretch / 2 * X, stretch / 2 * X, -stretch * low / 2 * Y, stretch * low / 2 * Y]
    motion = joints.motion(held, [p - (down * Z if k < 2 else 0.0) for k, p in enumerate(pull)])
    path = equilibrium(lambda level: Stage(a, motion=level * motion), steps=2)
    assert path.success
    # per present length EI is larger by the stretch, as curvature counts per initial one
    tension, spans = EA * stretch, np.array([1.0, low]) * (1 + stretch)
    z = spans / 2 * math.sqrt(tension / (EI * (1 + stretch)))
    yielding = (spans / (4 * tension) * (1 - np.tanh(z) / z)).sum()
    # elements are as long as the layer of bending
    assert lift(path, a) == pytest.approx(down / yielding, rel=1e-3)


@pytest.mark.parametrize(("n", "force", "pressure"), [((6, 6), 1e-6, 1e-5), ((6, 8), 1e-2, 0.05)])
def test_two_stacked_cantilevers_share_the_load(n, force, pressure):
    """Weight on the upper one; both have one deflection, so that each takes its share by its rigidity."""
    bends, weight, h = (2.0, 3.0), 1e-4, 0.02
    made = [
        line(straight((0, up, 0), (1, up, 0), k), EA=1e4, EI=bend, mass=weight)
        for up, k, bend in zip((h, 0.0), n, bends, strict=True)
    ]
    joints = Joints(made)
    conditions = [joints.flat(), joints.clamped((0, 0)), joints.clamped((1, 0))]
    a = Assembly(made, conditions, [fc.Contact(made[0].side(h / 2), made[1].side(h / 2))])
    load = np.concatenate([made[0].mass @ made[0].translation(-Y), np.zeros(made[1].n_dofs)])
    path = equilibrium(lambda level: Stage(a, forces=level * load), steps=1)
    assert path.success
    share = weight * bends[1] / sum(bends)
    assert path.last.reactions[made[0].n_dofs + 1] == pytest.approx(share, rel=force)
    # elements of one length have one deflection; others differ next to the clamp, where nothing yields
    assert path.last.forces[0][:6] * 6 == pytest.approx(share, rel=pressure)
    assert path.last.forces[0][6:] == pytest.approx(0.0, abs=0.01 * share)


def test_a_bar_pressed_on_a_plate():
    """Across a cantilever plate, nu = 0. Source: its deflection by linear theory, F a^3 / (3 EI)."""
    a_, width, thick, E, down = 0.83, 0.4, 0.02, 1e6, 1e-5
    sheet = plate([(0, 0, 0), (1, 0, 0), (0, width, 0)], (6, 2), fc.Material(E=E, nu=0.0), thick)
    high = thick / 2 + 0.01
    bar = line(straight((a_, 0, high), (a_, width, high), 3), EA=1e6, EI=1e3)
    joints = Joints([bar, sheet])
    edge = np.flatnonzero(sheet.vectors[:, 0, 0] < 1e-9)
    held = [joints.clamped((1, k)) for k in edge] + [joints.pinned((0, k)) for k in (0, -1)]
    a = Assembly([bar, sheet], held, [fc.Contact(bar.side(0.01), sheet.side(thick / 2))])
    motion = joints.motion(held, [None] * len(edge) + [-down * Z] * 2)
    path = equilibrium(lambda level: Stage(a, motion=level * motion), steps=1)
    assert path.success
    assert lift(path, a) == pytest.approx(3 * E * width * thick**3 / 12 * down / a_**3, rel=1e-4)


@pytest.mark.by_day("scheme0")
@pytest.mark.parametrize("scheme", [GeneralisedAlpha(), EnergyMomentum()])
def test_a_bar_thrown_across_another(scheme):
    """Both in free flight: momentum and its moment stay, energy as the scheme has it, and they part again."""
    (one, other), contact = crossed(1.2, n=(2, 2), apart=0.004, at=(0.2, 0.1))
    a = Assembly([one, other], [], [fc.Contact(contact.slave, contact.master)])
    motion = move(a, until=6e-3, step=5e-4, velocity=np.concatenate([one.translation(-Z), 0 * other.q0]), scheme=scheme)
    assert motion.success
    hit = motion.contact_force[:, 0, 2]
    assert hit.max() > 0
    assert np.ptp(motion.momentum, axis=0) == pytest.approx(0.0, abs=1e-8)
    spun = [np.cross(q.reshape(-1, 3), (a.mass @ v).reshape(-1, 3)).sum(axis=0) for q, v in motion_ends(motion, a, one)]
    assert spun[1] == pytest.approx(spun[0], abs=1e-6)
    assert motion.drift < (1e-12 if isinstance(scheme, EnergyMomentum) else 0.01)
    assert contact.at(motion.now.q).gap.min() > 0


def motion_ends(motion, a, one):
    """Coordinates and velocities at both ends."""
    thrown = np.concatenate([one.translation(-Z), np.zeros(a.n_dofs - one.n_dofs)])
    return [(a.q0, thrown), (motion.now.q, motion.now.v)]


def test_bad_input():
    (one, other), _ = crossed(1.0)
    with refused(fc.InputError, "contact-with-itself"):
        fc.Contact(one.side(0.1), one.side(0.1))
    with refused(fc.InputError, "input", "not both zero"):
        bound([one, other], one.side(), other.side())
    with refused(fc.InputError, "initial-overlap", "0.51"):
        bound([one, other], one.side(0.3), other.side(0.3))
    with refused(fc.InputError, "not-in-assembly"):
        bound([one, one], one.side(0.1), other.side(0.1))
    solid = AncfSolid(AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")), fc.Material(1.0, 0.3))
    with refused(fc.InputError, "bricks-and-members"):
        bound([one, solid], one.side(0.1), solid.side("top"))
    with refused(fc.InputError, "bricks-and-members"):
        bound([one, solid], solid.side("top"), one.side(0.1))


@pytest.mark.parametrize("beyond", [False, True])
def test_a_bar_within_elements_of_a_plate_is_named(beyond):
    """Source: geometry. Its lowest point is within an element; beyond the plate's rim it overlaps nothing."""
    sheet = plate([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (2, 2), fc.Material(E=1e3, nu=0.3), 0.04)
    x, depth = np.array([-0.5, 0.5]) + 0.3, 0.001
    # the cubic whose ends rise at slopes of one has its lowest point 1/4 below them
    ends = np.array([[[t, 0.6 + beyond, 0.25 + 0.04 - depth], [1.0, 0, k]] for t, k in zip(x, (-1, 1), strict=True)])
    bar = line(straight((x[0], 0.6, 1), (x[1], 0.6, 1), 1), EA=1e3, EI=1.0)
    contact = bound([bar, sheet], bar.side(0.02), sheet.side(0.02))
    q = np.concatenate([ends.ravel(), sheet.q0])
    part = contact.at(q)
    assert part.gap.min() > 0
    assert contact.overlap(q, part, np.zeros(contact.n_multipliers)) == pytest.approx(0 if beyond else depth, abs=1e-12)


def test_an_element_with_two_crossings_that_touch_is_refused():
    one = line(straight((-1, 0, 0.1), (1, 0, 0.1), 1), EA=1.0, EI=1.0)
    two = line([straight((x, -1, 0), (x, 1, 0), 1) for x in (-0.5, 0.5)], EA=1.0, EI=1.0)
    contact = bound([one, two], one.side(0.05), two.side(0.05))
    q = start([one, two])
    q[2] = q[8] = 0.099
    with refused(fc.SolverError, "crossed-twice"):
        contact.at(q)


def test_closest_points_are_no_farther_than_samples():
    """Of a bent line and a bent plate, against a dense set of their points."""
    rng, t = np.random.default_rng(3), np.linspace(0, 1, 401)
    for member, grid in ((crossed(1.0)[0][0], t[:, None]), (on_a_plate()[0][1], None)):
        middle, q = Middle(member, 0), member.q0 + 0.02 * rng.normal(size=member.n_dofs)
        if grid is None:
            grid = np.stack(np.meshgrid(t[::8], t[::8]), axis=-1).reshape(-1, 2)
        n, points = len(member.cells), rng.normal(size=(60, 3))
        dense = middle.at(q, np.arange(n).repeat(len(grid)), np.tile(grid, (n, 1)))[0]
        found = middle.at(q, *middle.project(q, points))[0]
        least = np.linalg.norm(dense - points[:, None], axis=2).min(axis=1)
        assert (np.linalg.norm(found - points, axis=1) <= least * (1 + 1e-9)).all()


def test_closest_points_of_a_skew_element_from_its_corners():
    """Of points beside a parallelogram: on one of its sides, at the foot on that segment."""
    sheet = plate([X * 0, X, Y], (1, 1), fc.Material(E=1e3, nu=0.3), 0.1)
    skew = np.array([[1.0, 0.8, 0.0], [0.0, 0.6, 0.0], [0.0, 0.0, 1.0]])
    middle, q = Middle(sheet, 0), (sheet.q0.reshape(-1, 3) @ skew.T).ravel()
    around = np.array([[0, 0, 0], X, X + Y, Y]) @ skew.T
    points = np.array([0.9, 0.3, 0]) + 2 * np.stack([np.cos(np.arange(40.0)), np.sin(np.arange(40.0)), np.zeros(40)], 1)
    feet = []
    for a, b in zip(around, np.roll(around, -1, axis=0), strict=True):
        feet.append(a + np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)[:, None] * (b - a))
    expected = np.linalg.norm(points - np.stack(feet), axis=2).min(axis=0)
    for corner in ([0, 0], [1, 0], [1, 1], [0, 1]):
        each = np.zeros(40, dtype=int)
        local = closest(middle, q, each, np.tile(np.array(corner, dtype=float), (40, 1)), points)
        found = np.linalg.norm(middle.at(q, each, local)[0] - points, axis=1)
        assert np.abs(found - expected).max() < 1e-9


def test_a_plate_is_no_slave_of_a_line():
    (bar, sheet), _ = on_a_plate()
    with refused(fc.InputError, "input", "exchange slave and master"):
        bound([bar, sheet], sheet.side(0.05), bar.side(0.04))
