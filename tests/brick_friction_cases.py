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
    solid = brick()
    a = Assembly.of([solid], None, [fc.Contact(solid.side("bottom"), FLOOR, friction=mu)])
    return a, a.gravity(PULL)


def creep_at_rest(steps):
    """Largest motion in static steps of constant load after the first, relative to the slip in that one.

    Friction barely holds the block: mu = 1.05 tan(angle).
    """
    a, weight = slope(1.05 * math.tan(ANGLE))
    path = equilibrium(lambda level: Stage(a, forces=weight), steps=steps)
    assert path.success
    assert len(path.steps) == steps
    assert max(s.residuals.slip for s in path.steps) < 1e-9
    return np.abs(path.last.q - path.steps[0].q).max() / np.abs(path.steps[0].friction.slip[0]).max()


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
    feet = np.array([a.constraints[0].positions(q) for q in at[3:]])
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
    at = np.array([a.constraints[0].positions(q) for q in motion.frames])
    return np.abs(at - at[0]).max() / np.abs(rest.friction.slip[0]).max()


def moved(a, by, turn=None, middle=(0.5, 0.5, 0.25)):
    """Motion of the supported coordinates: a turn about the middle of the block, then a translation."""
    R, middle = np.eye(3) if turn is None else turn, np.asarray(middle)
    return a.held(a.solids[0].space.affine(R, middle - R @ middle + by) - a.q0)


def steps_through(a, goals):
    """States at the ends of straight ways of the supported coordinates from each goal (n_dofs,) to the next."""
    states, last, begin = [], None, np.zeros(a.n_dofs)
    for goal in goals:
        path = equilibrium(lambda s, p=begin, g=goal: Stage(a, motion=p + s * (g - p)), steps=1, start=last)
        assert path.success, path.message
        states += path.steps[last is not None :]
        last, begin = path.last, goal
    return states


def random_walk(seed, steps=8):
    """A brick held above, moved over a floor at random: up to a fifth of its height, turned by up to 0.2 rad.

    Returns the worst of every condition, worked out anew from positions and forces, and how the points fare:
    least work of a step over the largest; excess over the cones, over the largest normal force; penetration, and gap
    under a force, over the size; defect of maximum dissipation; forces and moments of contact and support.
    """
    rng = np.random.default_rng(seed)
    mu = float(rng.choice([0.1, 0.3, 0.8, 2.0]))
    solid = brick()
    a = Assembly.of([solid], [{"top": "xyz"}], [fc.Contact(solid.side("bottom"), FLOOR, friction=mu)])
    turns = [fc.rotation_about(rng.normal(size=3) * [0.1, 0.1, 1.0], rng.uniform(-0.2, 0.2)) for _ in range(steps)]
    goals = [moved(a, rng.uniform([-0.1, -0.1, -0.06], [0.1, 0.1, 0.01]), turn) for turn in turns]
    states = steps_through(a, goals)
    touch, largest = a.constraints[0], max(s.forces[0].max() for s in states)
    A = touch.slave.quadrature[1]
    worst = dict.fromkeys(("cone", "gap", "dissipation", "force", "moment", "slides", "open"), 0.0)
    work, before = [], touch.positions(a.q0)
    for state in states:
        at = touch.positions(state.q)
        normal, friction = state.forces[0], state.friction.forces[0]
        slip, gap = (A @ (at - before))[:, :2], A @ at[:, 2]
        size, limit = np.linalg.norm(friction, axis=1), mu * normal
        given = limit * np.linalg.norm(slip, axis=1), -(friction[:, :2] * slip).sum(axis=1)
        work.append(given[1].sum())
        forces = A.T @ (friction + normal[:, None] * [0.0, 0.0, 1.0])
        arms = state.q.reshape(-1, 3)
        found = {
            "cone": (size - limit).max() / largest,
            "gap": max(-gap.min(), gap[normal > 0].max(initial=0.0)),
            "dissipation": np.abs(given[0] - given[1]).max() / (largest * np.abs(at - before).max()),
            "force": np.abs(
                forces.sum(axis=0) + np.array([a.translation(e) @ state.reactions for e in np.eye(3)])
            ).max(),
            "moment": np.abs(
                np.cross(at, forces).sum(axis=0) + np.cross(arms, state.reactions.reshape(-1, 3)).sum(axis=0)
            ).max(),
        }
        found["force"], found["moment"] = found["force"] / largest, found["moment"] / largest
        worst.update({name: max(worst[name], float(value)) for name, value in found.items()})
        worst["slides"] += float(((size > (1 - 1e-8) * limit) & (normal > 0)).mean() / len(states))
        worst["open"] += float((normal == 0).mean() / len(states))
        before = at
    return {"work": min(work) / max(work), **worst}


def elastic_cycle(seed, steps=6):
    """A brick pressed on a rough floor, moved at random and back; nothing slides, opens or closes.

    Returns the change of the coordinates over the motion, that of the forces over the largest, and the work of friction
    over the product of both.
    """
    rng = np.random.default_rng(seed)
    mu, pressed = 50.0, np.array([0.0, 0.0, -0.08])
    solid = brick()
    a = Assembly.of([solid], [{"top": "xyz"}], [fc.Contact(solid.side("bottom"), FLOOR, friction=mu)])
    turns = [fc.rotation_about(rng.normal(size=3), rng.uniform(-0.01, 0.01)) for _ in range(steps)]
    way = [moved(a, pressed + rng.uniform(-0.01, 0.01, 3), turn) for turn in turns]
    first, *others = steps_through(a, [moved(a, pressed), *way, moved(a, pressed)])
    forces = [np.column_stack([s.forces[0], s.friction.forces[0]]) for s in (first, *others)]
    assert all((np.linalg.norm(f[:, 1:], axis=1) < mu * f[:, 0]).all() for f in forces)
    far, largest = max(np.abs(s.q - first.q).max() for s in others), np.max(forces)
    left, changed = np.abs(others[-1].q - first.q).max(), np.abs(forces[-1] - forces[0]).max()
    return left / far, changed / largest, sum(abs(s.friction.friction_work) for s in others) / (far * largest)
