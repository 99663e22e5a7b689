"""Rigid hubs: exactly rigid in statics and motion, whatever their material, against rigid bodies and beams."""

from dataclasses import replace

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
    GeneralisedAlpha,
    Joints,
    Moment,
    Stage,
    equilibrium,
    move,
)

SIDES = np.array([1.0, 0.6, 0.3])


def bar(size, divisions, E=1.0, at=(0.0, 0.0, 0.0)):
    mesh = fc.shapes.block(tuple(size), divisions, element="hex8").translated(at)
    return AncfSolid(AncfSpace(mesh), fc.Material(E=E, nu=0.0, density=1.0), points=3)


def corners(solid, q):
    return q.reshape(-1, 3)[solid.space.start]


def distances(solid, q):
    x = corners(solid, q)
    return np.linalg.norm(x[:, None] - x, axis=2)


@pytest.fixture(scope="module")
def block():
    """A free rigid body of a very soft material."""
    hub = bar(SIDES, (1, 1, 1), at=-SIDES / 2)
    return Assembly([hub], [Joints([hub]).affine(0)], rigid=[0])


@pytest.mark.parametrize(("scheme", "error"), [(EnergyMomentum(), 2e-3), (GeneralisedAlpha(0.9), 4e-3)])
def test_a_rigid_hub_tumbles_as_euler_says(block, scheme, error):
    """Spun about its middle axis; I w' = (I w) x w of a cuboid, R' = R [w]x, to 1e-10. Errors are those of h^2."""
    hub, spin, until = block.solids[0], np.array([0.3, 3.0, 0.2]), 0.5
    inertia = SIDES.prod() / 12 * ((SIDES**2).sum() - SIDES**2)
    turning = np.cross(spin, np.eye(3)).T
    motion = move(block, until=until, step=0.02, scheme=scheme, velocity=hub.space.affine(turning), every=5)
    assert motion.success

    def rates(_, y):
        w, R = y[:3], y[3:].reshape(3, 3)
        return np.concatenate([np.cross(inertia * w, w) / inertia, (R @ np.cross(w, np.eye(3)).T).ravel()])

    exact = solve_ivp(rates, (0, until), [*spin, *np.eye(3).ravel()], rtol=1e-10, atol=1e-12).y[3:, -1].reshape(3, 3)
    found = hub.space.gradient_at(motion.frames[-1], np.array([0]), np.full((1, 3), 0.5))[0]
    assert np.abs(found - exact).max() < error
    assert np.abs(exact - np.eye(3)).max() > 0.9  # a large rotation
    for q in motion.frames:
        assert np.abs(distances(hub, q) - distances(hub, block.q0)).max() < 1e-10
    if isinstance(scheme, EnergyMomentum):
        assert motion.drift < 1e-10


@pytest.fixture(scope="module")
def carried():
    """Two soft bars at right angles on a rigid hub that is softer than they are."""
    one = bar((1.0, 0.2, 0.2), (1, 1, 1), 50.0, (0.2, 0.0, 0.0))
    other, hub = bar((0.2, 0.2, 1.0), (1, 1, 1), 50.0, (0.0, 0.0, 0.2)), bar((0.2, 0.2, 0.2), (1, 1, 1))
    joints = Joints([one, other, hub])
    conditions = [joints.affine(2), joints.follows(0, "x_min", 2), joints.follows(1, "bottom", 2)]
    return Assembly(joints.structures, conditions, rigid=[2])


def test_what_a_hub_carries_keeps_energy_and_both_momenta(carried):
    """The moment of momentum is that about the origin, int r x v dm = (q x M v) of all functions."""
    turning = np.cross((1.0, 4.0, 2.0), np.eye(3)).T
    velocity = np.concatenate([s.space.affine(turning) for s in carried.solids])
    motion = move(carried, until=0.2, step=0.02, scheme=EnergyMomentum(), velocity=velocity, every=5)
    assert motion.success
    assert motion.drift < 1e-9
    assert np.abs(motion.momentum - motion.momentum[0]).max() < 1e-12
    now = motion.now
    spun = [
        np.cross(q.reshape(-1, 3), (carried.mass @ v).reshape(-1, 3)).sum(axis=0)
        for q, v in ((carried.q0, velocity), (now.q, now.v))
    ]
    assert np.abs(spun[1] - spun[0]).max() < 1e-9 * np.abs(spun[0]).max()
    hub, bent = carried.solids[2], carried.solids[0]
    assert np.abs(corners(hub, carried.part(now.q, 2)) - corners(hub, hub.q0)).max() > 0.1
    for q in motion.frames:
        assert np.abs(distances(hub, carried.part(q, 2)) - distances(hub, hub.q0)).max() < 1e-10
    assert np.abs(distances(bent, carried.part(now.q, 0)) - distances(bent, bent.q0)).max() > 1e-3


def test_a_moment_on_a_hub_is_that_of_the_clamp_at_large_rotation():
    """A cantilever rolled by its end moment: the reaction is the moment, and the angle M L / (E I) of Euler's beam."""
    length, E = 10.0, 1e3
    beam, hub = bar((length, 0.5, 0.5), (6, 1, 1), E), bar((0.5, 0.5, 0.5), (1, 1, 1), 1.0, (length, 0.0, 0.0))
    joints = Joints([beam, hub])
    conditions = [joints.held(0, {"x_min": "xyz"}), joints.affine(1), joints.follows(0, "x_max", 1)]
    a = Assembly([beam, hub], conditions, rigid=[1])
    moment = 1.5 * E * 0.5**4 / 12 / length

    def stage(level):
        return Stage(a, follow=[Moment(1, "top", (0.0, level * moment, 0.0))])

    path = equilibrium(stage, steps=3)
    assert path.success
    q = path.last.q
    assert np.abs(distances(hub, a.part(q, 1)) - distances(hub, hub.q0)).max() < 1e-10
    F = hub.space.gradient_at(a.part(q, 1), np.array([0]), np.full((1, 3), 0.5))[0]
    assert abs(np.arctan2(-F[2, 0], F[0, 0]) / 1.5 - 1) < 0.01  # six bricks; strains of 4 %
    on_clamp = np.cross(q.reshape(-1, 3), path.last.reactions.reshape(-1, 3)).sum(axis=0)
    assert np.abs(on_clamp + np.array([0.0, moment, 0.0])).max() < 1e-7 * moment
    assert equilibrium(stage, start=path.last).steps == (path.last,)


def test_a_hub_presses_a_brick_on_a_ball():
    """Half a block whose hub may tilt about y; the reaction is what the ball carries."""
    soft, hub = bar((1.0, 1.0, 0.5), (2, 2, 1)), bar((1.0, 1.0, 0.2), (1, 1, 1), 1e-3, (0.0, 0.0, 0.5))
    joints = Joints([soft, hub])
    conditions = [
        joints.affine(1),
        joints.follows(0, "top", 1),
        joints.held(0, {"x_min": "x", "y_min": "y"}),
        joints.guided((1, (0.0, 0.0, 0.7)), 2, (0, 0, 1)),
        joints.pinned((1, (0.0, 0.0, 0.7)), (0, 0, 1)),
    ]
    ball = fc.RigidBody(fc.Sphere(1.0)).placed((0.0, 0.0, 0.0), fc.rotation_about((1, 0, 0), np.pi))
    a = Assembly([soft, hub], conditions, [fc.Contact(soft.side("bottom"), ball)], rigid=[1])
    motion = joints.motion(conditions, [None] * 4 + [-0.05])
    path = equilibrium(lambda level: Stage(a, motion=level * motion), steps=2)
    assert path.success, path.message
    up = a.translation(np.array([0.0, 0.0, 1.0]))
    push = a.conditions(path.last.q).G.T @ path.last.forces[0] @ up
    assert push > 1e-3
    assert abs(push + path.last.reactions @ up) < 1e-8 * push
    assert np.abs(distances(hub, a.part(path.last.q, 1)) - distances(hub, hub.q0)).max() < 1e-10


def test_refused(block):
    hub = block.solids[0]
    with refused(fc.InputError, "input", "does not move affinely"):
        Assembly([hub], [], rigid=[0])
    with refused(fc.InputError, "input", "number 1"):
        Assembly([hub], block.supports, rigid=[1])
    table = [fc.Contact(hub.side("bottom"), fc.RigidBody(fc.Plane()), friction=0.5)]
    with refused(fc.InputError, "free-rigid-motion"):
        equilibrium(lambda _: Stage(replace(block, contacts=table)))
