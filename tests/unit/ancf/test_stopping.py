"""Velocities of points that stop: impulses within their cones, energy lost, and none where all slide."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly
from fecontact.ancf.system.slip import initial_friction, slips, stopped


@pytest.fixture(scope="module")
def block():
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (1, 1, 1), element="hex8")
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.3, density=2.0), points=2)
    a = Assembly.of([solid], None, [fc.Contact(solid.side("bottom"), fc.RigidBody(fc.Plane()), friction=0.5)])
    slip = slips(a.constraints, a.conditions(a.q0).parts, a.q0, initial_friction(a.constraints, a.q0).start)
    v = a.translation(np.array([1.0, 0.5, 0.0])) + 0.1 * np.random.default_rng(0).standard_normal(a.n_dofs)
    return a, slip, v


def kinetic(a, v):
    return v @ (a.mass @ v) / 2


@pytest.mark.parametrize(("pressed", "halts"), [(1e3, True), (0.02, False), (1e-6, False)])
def test_impulses_within_the_cones(block, pressed, halts):
    a, slip, v = block
    normal, t, h = np.full(8, pressed), np.zeros(16), 0.1
    after, lost = stopped(a, v, slip, normal, t, np.zeros(16), h)
    assert lost == pytest.approx(kinetic(a, v) - kinetic(a, after), rel=1e-9)
    assert lost > 0
    speed = np.linalg.norm((slip.T @ after).reshape(2, -1), axis=0)
    assert (speed.max() < 1e-12) == halts
    if halts:
        return
    # all impulses together change the momentum by no more than the cones have, and that against the motion
    change = (a.momentum(after) - a.momentum(v))[:2]
    assert np.linalg.norm(change) <= 8 * 0.5 * pressed * h * (1 + 1e-9)
    assert change @ [1.0, 0.5] < 0


def test_a_moving_floor_takes_what_sticks_along(block):
    a, slip, v = block
    driven = slip.components(np.tile([0.3, -0.2, 0.0], (8, 1)))
    after, _ = stopped(a, v, slip, np.full(8, 1e3), np.zeros(16), driven, 0.1)
    assert np.abs(slip.T @ after - driven).max() < 1e-12


def test_what_slides_or_is_open_keeps_its_velocity(block):
    a, slip, v = block
    sliding = slip.components(np.tile([-0.5, 0.0, 0.0], (8, 1)))
    for normal, t in ((np.ones(8), sliding), (np.zeros(8), np.zeros(16))):
        after, lost = stopped(a, v, slip, normal, t, np.zeros(16), 0.1)
        assert lost == 0.0
        assert after is v
