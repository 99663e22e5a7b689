"""Joints and hubs of bricks: what they tie, against rigid bodies and beams."""

import numpy as np
import pytest
from refusals import refused
from scipy.integrate import solve_ivp

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    Assembly,
    EnergyMomentum,
    Joints,
    Moment,
    Stage,
    equilibrium,
    force_at,
    hold,
    move,
)
from fecontact.ancf.slender import line, straight
from fecontact.ancf.system.joints import free_directions


def bar(size, divisions, E=1.0, at=(0.0, 0.0, 0.0)):
    mesh = fc.shapes.block(size, divisions, element="hex8").translated(at)
    return AncfSolid(AncfSpace(mesh), fc.Material(E=E, nu=0.0, density=1.0), points=3)


@pytest.fixture(scope="module")
def cubes():
    return Joints([bar((1.0, 1.0, 1.0), (1, 1, 1)), bar((1.0, 1.0, 1.0), (1, 1, 1), at=(1.0, 0.0, 0.0))])


def test_joints_tie_what_they_say_and_leave_the_rest(cubes):
    one, other = (0, (1.0, 0.3, 0.5)), (1, (1.0, 0.3, 0.5))
    for condition, rank in (
        (cubes.pinned(one), 3),
        (cubes.pinned(one, [(1, 1, 0)]), 1),
        (cubes.pinned((0, [(0.0, 0.0, 0.5), (0.0, 1.0, 0.5)])), 6),
        (cubes.clamped(one), 12),
        (cubes.guided(one, 2), 3),
        (cubes.spherical(one, other), 3),
        (cubes.slot(one, other, (1, 1, 1)), 2),
        (cubes.revolute(one, other, 2), 6),
        (cubes.rigid(one, other), 12),
        (cubes.held(1, {"x_max": "xyz"}), 36),
        (cubes.affine(0), 84),
        (cubes.follows(1, "x_min", 0), 36),
    ):
        Z = cubes.free([condition]).toarray()
        assert Z.shape == (192, 192 - rank)
        assert np.abs(Z.T @ Z - np.eye(Z.shape[1])).max() < 1e-13
        assert np.abs(condition @ Z).max() < 1e-13


def test_what_follows_a_hub_moves_with_it(cubes):
    """One affine motion of both solids fulfils the conditions, and one of the second alone does not."""
    rng, (hub, cube) = np.random.default_rng(0), cubes.structures
    A, b = np.eye(3) + rng.standard_normal((3, 3)), rng.standard_normal(3)
    rest = np.concatenate([hub.q0, cube.q0])
    both = np.concatenate([hub.space.affine(A, b), cube.space.affine(A, b)]) - rest
    alone = np.concatenate([hub.q0, cube.space.affine(A, b)]) - rest
    for condition in (cubes.follows(1, "x_min", 0), cubes.affine(0)):
        assert np.abs(condition @ both).max() < 1e-12
    assert np.abs(cubes.follows(1, "x_min", 0) @ alone).max() > 0.1


def test_a_stiff_bar_on_a_hinge_is_the_physical_pendulum():
    """Hinged at two points of its middle plane, released level. Source: I phi'' = m g (L/2) cos phi, to 1e-10."""
    length, side, until = 1.0, 0.1, 0.6
    stick = bar((length, side, side), (2, 1, 1), E=1e6)
    joints = Joints([stick])
    hinge = joints.pinned((0, [(0.0, 0.0, side / 2), (0.0, side, side / 2)]))
    a = Assembly([stick], [hinge])
    motion = move(a, until=until, step=0.01, scheme=EnergyMomentum(), gravity=(0, 0, -9.81), every=1)
    tip = np.array([stick.space.points_at(q, np.array([1]), np.array([[1.0, 0.5, 0.5]]))[0] for q in motion.frames])
    angle = np.unwrap(np.arctan2(side / 2 - tip[:, 2], tip[:, 0]))
    inertia = (length**2 / 4 + (length**2 + side**2) / 12) / (length / 2)
    exact = solve_ivp(
        lambda _, y: [y[1], 9.81 * np.cos(y[0]) / inertia],
        (0, until), [0.0, 0.0], t_eval=motion.frame_times, rtol=1e-10, atol=1e-12,
    ).y[0]  # fmt: skip
    assert np.abs(angle - exact).max() < 2e-3  # (w h)^2 / 12 of the angle, and 1e-4 of strain
    assert motion.drift < 1e-9


@pytest.mark.full
def test_two_bars_in_flight_keep_momentum_energy_and_the_joint():
    one, other = bar((1.0, 0.2, 0.2), (1, 1, 1), 100.0), bar((1.0, 0.2, 0.2), (1, 1, 1), 100.0, (1.0, 0.0, 0.0))
    joints, x = Joints([one, other]), (1.0, 0.1, 0.1)
    a = Assembly([one, other], [joints.revolute((0, x), (1, x), 2)])
    spin = one.space.affine(np.array([[0.0, 0, -1], [0, 0, 0], [1, 0, 0]]), (0.0, 0.0, -1.0))
    velocity = np.concatenate([spin, -other.space.affine(np.array([[0.0, 0, -1], [0, 0, 0], [1, 0, 0]]), (0, 0, -1.0))])
    motion = move(a, until=0.5, step=0.02, scheme=EnergyMomentum(), velocity=velocity, every=1)
    assert motion.drift < 1e-9
    assert np.abs(motion.momentum - motion.momentum[0]).max() < 1e-12
    point = [np.array([0]), np.array([[1.0, 0.5, 0.5]])], [np.array([0]), np.array([[0.0, 0.5, 0.5]])]
    q = motion.frames[-1]
    ends = [s.space.points_at(a.part(q, k), *point[k]) for k, s in enumerate((one, other))]
    assert np.abs(ends[0] - ends[1]).max() < 1e-12
    folded = [s.space.gradient_at(a.part(q, k), *point[k])[0] @ [1, 0, 0] for k, s in enumerate((one, other))]
    assert folded[0] @ folded[1] < 0.9 * np.linalg.norm(folded[0]) * np.linalg.norm(folded[1])


@pytest.fixture(scope="module")
def with_hub():
    """A cantilever of length 10 and side 1 whose end is carried by a hub, half a length beyond it."""
    beam, hub = bar((10.0, 1.0, 1.0), (4, 1, 1), E=1e3), bar((1.0, 1.0, 1.0), (1, 1, 1), E=1e6, at=(15.0, 0.0, 0.0))
    joints = Joints([beam, hub])
    conditions = [joints.held(0, {"x_min": "xyz"}), joints.affine(1), joints.follows(0, "x_max", 1)]
    return Assembly([beam, hub], conditions)


def test_moments_and_offset_forces_on_a_hub_bend_a_beam(with_hub):
    """Euler and Bernoulli: the angle of the end is M L / (E I), and F L (L/2 + d) / (E I) for a force d beyond it."""
    a, EI, length = with_hub, 1e3 / 12, 10.0
    hub = a.solids[1].space

    def angle(stage):
        path = equilibrium(stage, steps=1)
        assert path.success
        F = hub.gradient_at(a.part(path.last.q, 1), np.array([0]), np.array([[0.5, 0.5, 0.5]]))[0]
        return np.arctan2(-F[2, 0], F[0, 0])

    moment = 1e-3
    turned = angle(lambda s: Stage(a, follow=[Moment(1, "top", (0.0, s * moment, 0.0))]))
    assert abs(turned / (moment * length / EI) - 1) < 1e-3
    force = np.concatenate([np.zeros(a.starts[1]), force_at(hub, (15.5, 0.5, 0.5), (0.0, 0.0, -moment))])
    turned = angle(lambda s: Stage(a, forces=s * force))
    assert abs(turned / (moment * length * (length / 2 + 5.5) / EI) - 1) < 1e-3


def test_a_hub_is_driven(with_hub):
    """A hub turned by a given angle needs the moment of the beam in pure bending about the end, if it may shift."""
    length, turn, joints = 10.0, 2e-3, Joints(with_hub.solids)
    fixed = [joints.held(0, {"x_min": "xyz"}), joints.affine(1), joints.follows(0, "x_max", 1)]
    driven = [joints.guided((1, (15.5, 0.5, 0.5)), k) for k in (1, 2, 3)]
    motion = joints.motion([*fixed, *driven], [None] * 3 + [*(fc.rotation_about((0, 1, 0), turn) - np.eye(3)).T])
    a = Assembly(with_hub.solids, [*fixed, *driven])
    path = equilibrium(lambda s: Stage(a, motion=s * motion), steps=1)
    assert path.success
    moment = 2 * path.last.energy / turn
    assert abs(moment / (1e3 / 12 * turn / length) - 1) < 1e-3


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda j: j.pinned((2, (0, 0, 0))), ("unknown", "are 2")),
        (lambda j: j.pinned((0, (5.0, 0, 0))), ("points-outside-body",)),
        (lambda j: j.pinned((0, 3)), ("input", "three finite numbers")),
        (lambda j: j.guided((0, (0.0, 0, 0)), 4), ("too-few-gradients", "and 3")),
        (lambda j: j.follows(0, "x_min", 0), ("follows-itself",)),
        (lambda j: j.held(0, {"lid": "xyz"}), ("unknown-boundary", "'lid'")),
        (lambda j: j.motion([j.pinned((0, (0, 0, 0)))], [(1.0, 0.0)]), ("change-shape", "[3]")),
        (lambda j: j.motion([j.pinned((0, (0, 0, 0)))] * 2, [None, (1.0, 0, 0)]), ("input", "contradict")),
        (lambda j: Joints([line(straight((0, 0, 0), (1, 0, 0), 1), EA=1.0, EI=1.0)]).affine(0), ("no-bricks",)),
    ],
)
def test_refused(cubes, make, match):
    with refused(fc.InputError, *match):
        make(cubes)


def test_supports_and_joints_bear_what_statics_says():
    """A bar on a roller and a pin, from whose end another hangs by a ball joint. Source: balance of moments."""
    mesh = fc.shapes.block((2.0, 0.5, 0.5), (2, 1, 1), element="hex8")
    upper = AncfSolid(AncfSpace(mesh), fc.Material(E=1e4, nu=0.3, density=1.0), points=3)
    lower = AncfSolid(AncfSpace(mesh.translated((2.0, 0.0, 0.0))), fc.Material(E=1e4, nu=0.3, density=1.0), points=3)
    joints = Joints([upper, lower])
    left, right = (0, (0.0, 0.25, 0.25)), (0, (2.0, 0.25, 0.25))
    far = (1, (4.0, 0.25, 0.25))
    no_spin = [joints.pinned((k, (x, 0.25, 0.5)), (0, 1, 0)) for k, x in ((0, 0.0), (1, 4.0))]
    conditions = [
        joints.pinned(left),
        joints.pinned(right, [(0, 1, 0), (0, 0, 1)]),
        joints.spherical(right, (1, (2.0, 0.25, 0.25))),
        joints.pinned(far, [(0, 1, 0), (0, 0, 1)]),
        *no_spin,
    ]
    a, weight = Assembly([upper, lower], conditions), 2.0 * 0.5 * 0.5
    state = equilibrium(lambda level: Stage(a, forces=level * a.gravity(np.array([0.0, 0.0, -1.0]))), steps=1).last
    # bars hardly bend: each end bears half of its bar, and the right support both halves there
    found = [state.reaction(k) for k in range(len(conditions))]
    assert np.abs(found[0] - [0.0, 0.0, weight / 2]).max() < 1e-3 * weight
    assert np.abs(found[1] - [0.0, weight]).max() < 1e-3 * weight
    assert abs(abs(found[2][2]) - weight / 2) < 1e-3 * weight
    assert np.abs(found[3] - [0.0, weight / 2]).max() < 1e-3 * weight
    every = sum(C.T @ f for C, f in zip(conditions, found, strict=True))
    assert np.abs(every - state.reactions).max() < 1e-10


def test_supports_are_rows_not_free_directions():
    space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    solid = AncfSolid(space, fc.Material(E=1.0, nu=0.3))
    joints = Joints([solid])
    for wrong in (joints.free([joints.affine(0)]), [joints.affine(0)[:, :12]]):
        with refused(fc.InputError, "supports", "96 columns"):
            Assembly([solid], wrong)


def test_oblique_supports_of_many_nodes_leave_what_each_leaves_alone():
    """Of 25 nodes held along a slant: each holds its position and two gradients, so three coordinates fewer."""
    space = AncfSpace(fc.shapes.block((1.0, 1.0, 0.5), (4, 4, 1), element="hex8"))
    solid, slant = AncfSolid(space, fc.Material(E=1.0, nu=0.3)), np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    a = Assembly.of([solid], [{"bottom": tuple(slant)}])
    Z = a.free.toarray()
    assert Z.shape == (space.n_dofs, space.n_dofs - 25 * 3)
    assert np.abs(Z.T @ Z - np.eye(Z.shape[1])).max() < 1e-14
    assert np.abs(a.supports[0] @ Z).max() < 1e-14
    # the same directions as node by node
    alone = hold(space, {"bottom": tuple(slant)}).free.toarray()
    assert np.abs(Z @ Z.T - alone @ alone.T).max() < 1e-13
    # rows that say the same twice hold no more, and none hold nothing
    twice = free_directions([a.supports[0], a.supports[0][:7]], space.n_dofs).toarray()
    assert np.abs(twice @ twice.T - Z @ Z.T).max() < 1e-13
    assert abs(free_directions([], 3) - np.eye(3)).max() == 0.0
