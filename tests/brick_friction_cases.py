"""Friction of bricks over many steps, for tests and, with more steps, `benchmarks/bench_brick_friction.py`."""

from __future__ import annotations

import math

import numpy as np

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, Stage, equilibrium, move

FLOOR = fc.RigidBody(fc.Plane(), name="floor")
ANGLE = 0.3
PULL = 9.81 * np.array([math.sin(ANGLE), 0.0, -math.cos(ANGLE)])


def brick(divisions=(1, 1, 1)):
    """A block of 1 x 1 x 0.5."""
    mesh = fc.shapes.block((1.0, 1.0, 0.5), divisions, element="hex8")
    return AncfSolid(AncfSpace(mesh), fc.Material(E=1e3, nu=0.3, density=1.0), points=3)


def slope(mu):
    """One brick on a slope, its weight, and its state at rest."""
    a = Assembly.of([brick()], None, [(0, "bottom", FLOOR, mu)])
    return a, a.gravity(PULL)


def creep_at_rest(steps):
    """Largest motion in static steps of constant load after the first, relative to the slip in that one.

    Friction barely holds the block: mu = 1.05 tan(angle).
    """
    a, weight = slope(1.05 * math.tan(ANGLE))
    path = equilibrium(lambda level: Stage(a, forces=weight), steps=steps)
    assert path.success
    assert len(path.states) == steps
    assert max(s.friction.defect for s in path.states) < 1e-9
    return np.abs(path.last.q - path.states[0].q).max() / np.abs(path.states[0].friction.slip[0]).max()


def creep_in_shakes(shakes):
    """Largest motion of the feet between shakes of the same sense, from the third on, relative to the swing.

    Static loads shake the block across the slope; its rims slip to and fro at first, and every step is solved.
    """
    a, weight = slope(2 * math.tan(ANGLE))
    across, last, at = a.gravity(np.array([0.0, 0.2, 0.0])), None, []
    for k in range(shakes + 1):
        load = weight + (-1) ** k * across if k else weight
        path = equilibrium(lambda level, f=load: Stage(a, forces=f), steps=1, start=last, tolerance=1e-12)
        assert path.success
        last = path.last
        at.append(last.q)
    feet = np.array([a.touches[0].positions(q) for q in at[3:]])
    feet = feet[: len(feet) // 2 * 2].reshape(-1, 2, *feet.shape[1:])
    return np.abs(feet - feet[0]).max() / np.abs(at[-1] - at[-2]).max()


def creep_in_motion(steps, scheme, step=0.01):
    """Largest motion of the feet in steps of motion from rest, relative to the slip in the static loading step."""
    a, weight = slope(1.05 * math.tan(ANGLE))
    rest = equilibrium(lambda level: Stage(a, forces=weight), steps=1, tolerance=1e-12).last
    every = max(1, steps // 200)
    motion = move(a, until=steps * step, step=step, scheme=scheme, start=rest, forces=weight, every=every)
    assert motion.success
    assert len(motion.time) == steps + 1
    at = np.array([a.touches[0].positions(q) for q in motion.frames])
    return np.abs(at - at[0]).max() / np.abs(rest.friction.slip[0]).max()
