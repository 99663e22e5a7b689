"""Bricks that slide and stick in motion, beside a rigid block. Figures: docs/ancf.md."""

import math

import numpy as np
import pytest
from brick_friction_cases import creep_at_rest, creep_in_motion, creep_in_shakes, elastic_cycle, random_walk

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, EnergyMomentum, GeneralisedAlpha, Stage, equilibrium, move

MASS, GRAVITY = 0.5, 9.81
FLOOR = fc.RigidBody(fc.Plane(), name="floor")
SCHEMES = [GeneralisedAlpha(0.8), EnergyMomentum()]


@pytest.fixture(scope="module")
def solid():
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (1, 1, 1), element="hex8")
    return AncfSolid(AncfSpace(mesh), fc.Material(E=1e3, nu=0.3, density=1.0), points=3)


def resting(solid, mu, pull):
    """The block on the floor under a pull, and its state at rest."""
    a = Assembly.of([solid], None, [fc.Contact(solid.side("bottom"), FLOOR, friction=mu)])
    path = equilibrium(lambda level: Stage(a, forces=a.gravity(pull)), steps=1)
    assert path.success
    return a, path.last


@pytest.mark.parametrize("scheme", SCHEMES, ids=["alpha", "conserving"])
def test_a_block_slides_to_rest(scheme, solid, row):
    """A block pushed along a floor: its speed falls by mu g, then it stays. Source: the rigid block."""
    mu, speed = 0.3, 1.0
    pull = np.array([0.0, 0.0, -GRAVITY])
    a, at_rest = resting(solid, mu, pull)
    stops = speed / (mu * GRAVITY)
    motion = move(
        a, until=1.2 * stops, step=stops / 25, scheme=scheme, start=at_rest, velocity=(speed, 0, 0), gravity=pull
    )
    assert motion.success
    name = f"block that slides to rest, {type(scheme).__name__}"
    # it tilts and swings by the deceleration, v^2/g of which is a hundredth of the way
    middle = len(motion.time) // 2
    fall = (motion.momentum[0, 0] - motion.momentum[middle, 0]) / (MASS * motion.time[middle])
    row(name, "deceleration over mu g", 1.0, fall / (mu * GRAVITY), 0.02)
    along = a.mass @ a.translation(np.array([1.0, 0.0, 0.0])) / MASS
    row(name, "way over v^2 / (2 mu g)", 1.0, along @ (motion.now.q - at_rest.q) * 2 * mu * GRAVITY / speed**2, 0.02)
    # what is left swings: the block is elastic
    row(name, "work of friction over the kinetic energy", 1.0, motion.friction_work[-1] / motion.kinetic[0], 0.03)
    row(name, "least work of a step over the largest", 0.0, min(np.diff(motion.friction_work).min(), 0.0), 1e-14)
    if scheme == EnergyMomentum():
        row(name, "energy and work of friction, drift", 0.0, motion.drift, 1e-9)


@pytest.mark.by_day("conserving")
@pytest.mark.parametrize("scheme", SCHEMES, ids=["alpha", "conserving"])
def test_a_block_stays_on_a_slope_that_is_shaken(scheme, solid, row):
    """Within its cones a block does not creep, however often it is shaken. Source: statics."""
    angle = 0.3
    pull = GRAVITY * np.array([math.sin(angle), 0.0, -math.cos(angle)])
    a, at_rest = resting(solid, 2.5 * math.tan(angle), pull)
    across = a.gravity(np.array([0.0, 0.3, 0.0]))
    weight = a.gravity(pull)
    motion = move(
        lambda t: Stage(a, forces=weight + math.sin(20 * t) * across),
        until=0.7, step=0.014, scheme=scheme, start=at_rest, every=1,
    )  # fmt: skip
    assert motion.success
    part = a.conditions(at_rest.q).parts[0]
    N, A = a.constraints[0].components, part.means
    feet = np.stack([np.kron(A.toarray(), e) @ (N @ (q - at_rest.q)) for q in motion.frames for e in np.eye(3)[:2]])
    moved = np.abs(feet.reshape(len(motion.frames), -1)).max(axis=1)
    swing = np.ptp(motion.frames @ (a.mass @ a.translation(np.array([0.0, 1.0, 0.0]))) / MASS)
    assert swing > 1e-5
    name = f"block on a shaken slope, {type(scheme).__name__}"
    row(name, "motion of its feet over its swing", 0.0, moved.max() / swing, 1e-9)
    # the damping scheme leaves velocities to what sticks, and takes their energy
    work = motion.friction_work[-1] / motion.kinetic.max()
    row(name, "work of friction over the kinetic energy", 0.0, work, 1e-9 if scheme == EnergyMomentum() else 1e-2)


def test_a_belt_carries_a_block_along(solid, row):
    """A block at rest on a floor that moves: mu g speeds it up to the floor's speed. Source: the rigid block.

    The floor's work is the force of friction times its way; half of it heats the contact.
    """
    mu, speed, pull = 0.4, 0.5, np.array([0.0, 0.0, -GRAVITY])
    a, at_rest = resting(solid, mu, pull)
    takes, weight = speed / (mu * GRAVITY), a.gravity(pull)
    motion = move(
        lambda t: Stage(a.with_rigid(FLOOR.placed((speed * t, 0, 0))), forces=weight),
        until=1.5 * takes, step=takes / 16, scheme=EnergyMomentum(), start=at_rest,
    )  # fmt: skip
    assert motion.success
    row("block on a belt", "momentum in the last third", MASS * speed, motion.momentum[-8:, 0].mean(), 0.03)
    row("block on a belt", "energy, work and friction, drift", 0.0, motion.drift, 1e-9)
    row("block on a belt", "work of friction", MASS * speed**2 / 2, motion.friction_work[-1], 0.05)


@pytest.mark.full
def test_nothing_creeps(row):
    """A block that friction holds on a slope. Source: statics; penalties creep by a share of the first slip a step.

    1e4 steps of each: tests/benchmarks/bench_brick_friction.py.
    """
    row("block at rest on a slope", "motion in 200 static steps over the first slip", 0.0, creep_at_rest(200), 1e-12)
    row("block at rest on a slope", "drift in 20 static shakes over the swing", 0.0, creep_in_shakes(20), 1e-9)
    for scheme in SCHEMES:
        name = f"block at rest on a slope, {type(scheme).__name__}"
        row(name, "motion of its feet in 25 steps over the first slip", 0.0, creep_in_motion(25, scheme), 1e-9)


@pytest.mark.full
def test_energy_of_random_walks(row):
    """Coulomb's law, Signorini's and the balance of forces in every step of random walks at large deformation.

    Source: the second law and maximum dissipation; all worked out anew from positions and forces. A walk where nothing
    slides is elastic: back at its begin everything is as it was. 100 walks: tests/benchmarks/bench_brick_friction.py.
    """
    walks = [random_walk(seed) for seed in range(6)]
    worst = {name: max(walk[name] for walk in walks) for name in walks[0]}
    row("random walks of a brick", "least work of a step over the largest", 0.0, -min(w["work"] for w in walks), 1e-12)
    row("random walks of a brick", "excess over the cones over the largest force", 0.0, worst["cone"], 1e-9)
    row("random walks of a brick", "penetration, or gap under a force, over the size", 0.0, worst["gap"], 1e-9)
    row("random walks of a brick", "defect of maximum dissipation", 0.0, worst["dissipation"], 1e-9)
    row(
        "random walks of a brick",
        "forces and moments, over the largest",
        0.0,
        max(worst["force"], worst["moment"]),
        1e-8,
    )
    assert min(w["slides"] for w in walks) > 0.05
    assert min(w["open"] for w in walks) > 0.01
    cycles = np.max([elastic_cycle(seed) for seed in range(2)], axis=0)
    for name, found in zip(("motion over that of the cycle", "change of the forces", "work"), cycles, strict=True):
        row("elastic cycles of a brick on a rough floor", name, 0.0, found, 1e-8)
