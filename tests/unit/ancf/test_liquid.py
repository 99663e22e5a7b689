"""A liquid of bricks: waves in a tank, their decay by viscosity, and a shear flow at any strain."""

import numpy as np
import pytest
import scipy.linalg
from refusals import refused

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, GeneralisedAlpha, Liquid, Viscosity, move

G, RHO, ETA = 9.81, 1000.0, 2.0
LENGTH, DEPTH = 1.0, 0.5
SLIP = {"x_min": "x", "x_max": "x", "y_min": "y", "y_max": "y", "bottom": "z"}


def tank(n, bulk=1e3 * RHO * G * DEPTH):
    mesh = fc.shapes.block((LENGTH, 0.1, DEPTH), (n, 1, n // 2), element="hex8")
    liquid = AncfSolid(AncfSpace(mesh), Liquid(bulk, RHO), points=3, viscosity=Viscosity(newtonian=ETA))
    return Assembly.of([liquid], [SLIP])


def at_rest(a, bulk):
    """Coordinates (n_dofs,) of the column under its weight: bulk ln s / s = - rho g (h - z)."""
    q = a.q0.reshape(-1, 4, 3).copy()
    z = np.linspace(0.0, DEPTH, 2001)
    s = np.ones_like(z)
    for _ in range(5):  # by Newton's method, ln s = - s rho g (h - z) / bulk
        s = np.exp(-s * RHO * G * (DEPTH - z) / bulk)
    height = np.concatenate([[0.0], np.cumsum((s[1:] + s[:-1]) / 2 * np.diff(z))])
    start = q[:, 0, 2].copy()
    q[:, 0, 2], q[:, 3, 2] = np.interp(start, z, height), np.interp(start, z, s)
    return q.ravel()


def wave(a, j):
    """Velocities (n_dofs,) of the wave with j half-lengths in the tank, by potential flow."""
    k, X = j * np.pi / LENGTH, a.q0.reshape(-1, 4, 3)[:, 0]
    x, z, out = k * X[:, 0], k * X[:, 2], np.zeros((len(X), 4, 3))
    out[:, 0, 0], out[:, 0, 2] = -np.sin(x) * np.cosh(z), np.cos(x) * np.sinh(z)
    out[:, 1, 0], out[:, 1, 2] = -k * np.cos(x) * np.cosh(z), -k * np.sin(x) * np.sinh(z)
    out[:, 3, 0], out[:, 3, 2] = -k * np.sin(x) * np.sinh(z), k * np.cos(x) * np.cosh(z)
    return out.ravel()


def test_waves_in_a_tank():
    """omega^2 = g k tanh k h, and by viscosity their amplitude decays as exp(- 2 nu k^2 t) (H. Lamb, section 348)."""
    bulk = 1e3 * RHO * G * DEPTH
    a = tank(8, bulk)
    q, Z, k = at_rest(a, bulk), a.free, np.pi / LENGTH
    weight = a.gravity(np.array([0.0, 0.0, -G]))
    assert np.abs(Z.T @ (weight - a.forces(q))).max() < 1e-6 * np.abs(weight).max()
    K, M = ((Z.T @ A @ Z).toarray() for A in (a.tangent(q), a.mass))
    values, modes = scipy.linalg.eigh(K, M)
    assert values[0] > -0.01  # turns of the liquid are neutral
    found = np.argmax((modes.T @ M @ (Z.T @ wave(a, 1))) ** 2)
    assert abs(values[found] / (G * k * np.tanh(k * DEPTH)) - 1) < 1e-3
    h = 1e-3
    C = h * (Z.T @ a.solids[0].viscous_tangent(q, h) @ Z)
    decay = modes[:, found] @ C @ modes[:, found] / 2
    assert abs(decay / (2 * ETA / RHO * k**2) - 1) < 5e-3


@pytest.mark.full
def test_a_tank_in_time():
    """Kicked along x, the level at the wall swings with the period of the first wave; the volume is kept."""
    a = tank(6, 4e3 * RHO * G * DEPTH)  # its weight, let go at once, presses twice as much
    space = a.solids[0].space
    kick = 0.2 / np.cosh(np.pi * DEPTH / LENGTH) * wave(a, 1)
    motion = move(a, until=1.9, step=0.02, scheme=GeneralisedAlpha(0.5), velocity=kick, gravity=(0, 0, -G), every=1)
    assert motion.success
    wall = space.rows_at(np.array([2]), np.array([[0.0, 0.5, 1.0]]))
    level = np.array([(wall @ frame.reshape(-1, 3))[0, 2] for frame in motion.frames])
    t, up = motion.frame_times, level - level[0]
    crossed = np.flatnonzero(up[1:] * up[:-1] < 0)
    times = t[crossed] - up[crossed] * np.diff(t)[crossed] / np.diff(up)[crossed]
    omega = np.sqrt(G * np.pi / LENGTH * np.tanh(np.pi * DEPTH / LENGTH))
    assert abs((times[2] - times[0]) * omega / (2 * np.pi) - 1) < 0.02
    F = space.gradient_at(motion.now.q, np.arange(len(space.corners)), np.full((len(space.corners), 3), 0.5))
    assert np.abs(np.linalg.det(F) - 1).max() < 1e-3


def test_a_shear_flow_at_any_strain():
    """Between plates at a rate of shear the force is eta rate area, however far they have gone; work is lost."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    solid = AncfSolid(AncfSpace(mesh), Liquid(1e3, 1.0), points=3, viscosity=Viscosity(newtonian=ETA))
    h, shears = 0.1, (2.0, 2.3)
    q0, q1 = (solid.space.affine(np.eye(3) + s * np.outer([1, 0, 0], [0, 0, 1])) for s in shears)
    step = solid.lapse(q0, q1, h)
    up = solid.space.q0.reshape(-1, 3)[::4, 2] > 0.5
    force = step.forces.reshape(-1, 4, 3)[up, 0].sum(axis=0)
    assert np.abs(force - [ETA * 3.0, 0.0, 0.0]).max() < 1e-12
    assert abs(step.lost - step.forces @ (q1 - q0)) < 1e-12
    assert abs(step.lost - ETA * 3.0**2 * h) < 1e-12
    assert np.abs(solid.forces(q1)).max() < 1e-10
    rng = np.random.default_rng(0)
    q, d = q0 + 0.02 * rng.standard_normal(q0.shape), rng.standard_normal(q0.shape)
    ahead, behind = (solid.lapse(q, q + s * 1e-6 * d, h).forces for s in (1, -1))
    change = (ahead - behind) / 2e-6
    assert np.abs(solid.viscous_tangent(q, h) @ d - change).max() < 1e-7 * np.abs(change).max()
    turn = fc.rotation_about((1, 2, 3), 1.1)
    turned = (q.reshape(-1, 3) @ turn.T).ravel()
    assert np.abs(solid.lapse(q, turned, h).forces).max() < 1e-12


def test_refused():
    space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    with refused(fc.InputError, "not-positive"):
        Liquid(0.0)
    with refused(fc.InputError, "liquid"):
        Viscosity(0.1, newtonian=1.0)
    with refused(fc.InputError, "liquid"):
        AncfSolid(space, Liquid(1.0), volumetric="linear")
