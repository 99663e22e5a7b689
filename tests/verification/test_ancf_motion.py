"""Bricks with gradient coordinates at large deformation and in motion, with contact."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    Assembly,
    EnergyMomentum,
    GeneralisedAlpha,
    Stage,
    equilibrium,
    move,
)

UP = np.array([0.0, 0.0, 1.0])


def bar(divisions, size, material, **options):
    """A straight bar of square section along x, its axis on the x axis."""
    mesh = fc.shapes.block(size, divisions, element="hex8").translated((0.0, -size[1] / 2, -size[2] / 2))
    return AncfSolid(AncfSpace(mesh), material, **options)


@pytest.mark.by_day("8-0.003")
@pytest.mark.parametrize(("n", "most"), [(8, 3e-3), (12, 2e-3)])
def test_bar_bent_into_a_full_circle(n, most, row):
    """A slender bar whose end is turned by 360 degrees. Source: Euler's elastica, U = E I k^2 L / 2.

    The ends are guided along the circle, L = 10, square section of 0.1. Terms of order (thickness / radius)^2 = 4e-3
    tell a St. Venant-Kirchhoff solid from a thin beam; they take about a quarter of that.
    """
    length, thickness = 10.0, 0.1
    solid = bar((n, 1, 1), (length, thickness, thickness), fc.Material(E=1e4, nu=0.0))
    a = Assembly.of([solid], [{"x_min": "xyz", "x_max": "xyz"}])
    space = solid.space
    end = np.flatnonzero(space.mesh.points[space.nodes][:, 0] > length - 1e-9)
    held = (space.start[end][:, None] + [0, 2, 3]).ravel()

    def stage(level):
        angle = 2 * np.pi * level
        turn = fc.rotation_about((0, 1, 0), -angle)
        centre = np.array([length * np.sinc(angle / np.pi), 0.0, 0.0])
        centre[2] = length * (1 - np.cos(angle)) / angle if level else 0.0
        motion = np.zeros((space.n_functions, 3))
        motion[held] = (space.affine(turn, centre - turn @ [length, 0, 0]) - a.q0).reshape(-1, 3)[held]
        return Stage(a, motion=motion.ravel())

    path = equilibrium(stage, steps=16)
    assert path.success
    radius = length / (2 * np.pi)
    exact = 1e4 * thickness**4 / 12 / (2 * radius**2) * length
    row(f"bar into a circle, {n} elements", "strain energy", exact, path.last.energy, most, a.n_dofs)
    cells = np.arange(n)
    middle = space.points_at(path.last.q, cells, np.full((n, 3), 0.5))
    off = np.abs(np.hypot(middle[:, 0], middle[:, 2] - radius) / radius - 1).max()
    row(f"bar into a circle, {n} elements", "axis off the circle / radius", 0.0, off, most, a.n_dofs)


def pressed(n, depth, radius, law=fc.NeoHookean, points=4):
    """Force on a rigid ball pressed into a block of 2 x 2 x 1 held below (a quarter modelled), and the last state."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (n, n, n), element="hex8").translated((0.0, 0.0, -1.0))
    solid = AncfSolid(AncfSpace(mesh), law(E=1.0, nu=0.3), points=points)
    ball = fc.RigidBody(fc.Sphere(radius))
    a = Assembly.of([solid], [{"bottom": "xyz", "x_min": "x", "y_min": "y"}], [fc.Contact(solid.side("top"), ball)])
    path = equilibrium(lambda s: Stage(a.with_rigid(ball.placed((0, 0, -depth * s)))), steps=4)
    assert path.success
    return 4 * float(path.last.reactions @ a.translation(UP)), path.last, a


@pytest.mark.full
def test_soft_block_pressed_by_a_third_of_its_height(row):
    """A rigid ball (R = 1) pressed 0.3 deep into a neo-Hookean block of height 1. Source: refinement of itself."""
    coarse, fine, finer = (pressed(n, 0.3, 1.0) for n in (2, 3, 5))
    row("ball 30 % deep, 4 against 10 elements", "force", finer[0], coarse[0], 0.05, coarse[2].n_dofs)
    row("ball 30 % deep, 6 against 10 elements", "force", finer[0], fine[0], 0.03, fine[2].n_dofs)
    row("ball 30 % deep", "penetration of the hats / size", 0.0, finer[1].residuals.penetration, 1e-9, finer[2].n_dofs)
    row("ball 30 % deep", "force out of balance", 0.0, finer[1].residuals.equilibrium, 1e-9, finer[2].n_dofs)


def test_small_limit_is_that_of_linear_elasticity(row):
    """A ball so large that strains are small. Source: the same block of 20-node hexahedra in a linear scene."""
    depth, radius, n = 0.002, 200.0, 4
    found, _, a = pressed(n, depth, radius)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2 * n, 2 * n, 2 * n)).translated((0.0, 0.0, -1.0))
    held = {"bottom": "xyz", "x_min": "x", "y_min": "y"}
    block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), "top", held, name="block")
    ball = fc.RigidBody(fc.Sphere(radius), name="ball")
    result = fc.Scene([block, ball], [fc.Contact(block, ball)]).solve(motions={ball: {"z": -depth}})
    # strains of 2e-3 and a contact edge inside elements of a third of the contact radius
    row("ball, small limit", "force against hex20", -4 * result.contacts[0].force[2], found, 0.02, a.n_dofs)


def test_strip_between_two_rolls(row):
    """Rolls that squeeze an elastic strip and travel along it: far from its ends nothing changes. Source: translation.

    Frictionless and elastic, a steady travel does no work: the rolls' force along the strip vanishes.
    """
    mesh = fc.shapes.block((8.0, 0.5, 1.0), (16, 1, 2), element="hex8").translated((0.0, -0.25, -0.5))
    solid = AncfSolid(AncfSpace(mesh), fc.NeoHookean(E=1.0, nu=0.3))
    upper = fc.RigidBody(fc.surfaces.Cylinder(2.0), name="upper roll")
    lower = upper.placed(rotation=fc.rotation_about((0, 1, 0), np.pi), name="lower roll")
    plane = {"x_min": "x", "y_min": "y", "y_max": "y"}
    # the middle of the held end carries the strip's height
    mesh_points = np.flatnonzero((mesh.points[:, 0] < 1e-9) & (np.abs(mesh.points[:, 2]) < 1e-9))
    solid = replace(solid, space=AncfSpace(replace(mesh, node_sets={"height": mesh_points})))
    contacts = [fc.Contact(solid.side("top"), upper), fc.Contact(solid.side("bottom"), lower)]
    a = Assembly.of([solid], [{**plane, "height": "z"}], contacts)
    forces, energies = [], []
    places = np.linspace(3.0, 4.0, 5)

    def stage(level):
        squeeze = min(1.0, level / 0.5)
        x = places[0] + (places[-1] - places[0]) * max(0.0, level - 0.5) / 0.5
        half = 0.5 - 0.1 * squeeze
        return Stage(a.with_rigid(upper.placed((x, 0, half)), lower.placed((x, 0, -half))))

    path = equilibrium(stage, steps=8)
    assert path.success
    for state in path.steps:
        if state.level < 0.5 - 1e-9:
            continue
        now = stage(state.level).assembly.conditions(state.q)
        push = [part.G.T @ f for part, f in zip(now.parts, state.forces, strict=True)]
        forces.append([[p @ a.translation(e) for e in (np.array([1.0, 0, 0]), UP)] for p in push])
        energies.append(state.energy)
    forces = np.array(forces)
    down = -forces[:, 0, 1]
    # three hats lie across the contact and pass under the rolls one after the other
    row("strip between rolls", "spread of the roll force", 0.0, np.ptp(down) / down.mean(), 0.06, a.n_dofs)
    row("strip between rolls", "force along / roll force", 0.0, np.abs(forces[:, :, 0]).max() / down.mean(), 0.03)
    row("strip between rolls", "spread of the energy", 0.0, np.ptp(energies) / np.mean(energies), 0.02)
    row("strip between rolls", "upper + lower roll force", 0.0, np.abs(forces[:, :, 1].sum(axis=1)).max(), 1e-8)


@pytest.mark.by_day("conserving-10")
@pytest.mark.parametrize(
    ("n", "scheme", "force", "rebound"),
    [(10, GeneralisedAlpha(0.5), 0.03, 0.08), (10, EnergyMomentum(), 0.02, 0.1), (20, EnergyMomentum(), 0.01, 0.05)],
    ids=["alpha-10", "conserving-10", "conserving-20"],
)
def test_bar_hits_a_wall(n, scheme, force, rebound, row):
    """An elastic bar (nu = 0) that flies against a rigid wall. Source: d'Alembert's waves.

    With speed v the wall feels rho c v A for the time 2 L/c, in which the wave runs to the free end and back; then the
    bar leaves with -v. What contact faces of half an element lose when they stop is of the order 1/n; the front of the
    wave is smeared over some elements, and its tail is what the rebound misses.
    """
    v, area = 0.01, 0.01
    mesh = fc.shapes.block((1.0, 0.1, 0.1), (n, 1, 1), element="hex8").translated((1e-7, 0.0, 0.0))
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.0, density=1.0))
    wall = fc.RigidBody(fc.Plane(), name="wall").placed(rotation=fc.rotation_about((0, 1, 0), np.pi / 2))
    a = Assembly.of([solid], None, [fc.Contact(solid.side("x_min"), wall)])
    h = 0.4 / n
    motion = move(a, until=2.4, step=h, scheme=scheme, velocity=(-v, 0.0, 0.0))
    assert motion.success
    F, t = motion.contact_force[:, 0, 0] / (v * area), motion.time
    case = f"bar on a wall, {n} elements, {type(scheme).__name__}"
    row(case, "wall force / rho c v A", 1.0, F[(t > 0.3) & (t < 1.7)].mean(), force, a.n_dofs)
    pressed = t[F > 0.02]
    row(case, "duration / (2 L / c)", 1.0, (pressed.max() - pressed.min() + h) / 2, 2.5 * h, a.n_dofs)
    row(case, "rebound / speed", 1.0, motion.momentum[-1, 0] / (v * area), rebound, a.n_dofs)
    impulse = (F[1:] * np.diff(t)).sum()
    row(case, "impulse / change of momentum", 1.0, impulse / (motion.momentum[-1, 0] / (v * area) + 1), 1e-6)
    if isinstance(scheme, EnergyMomentum):
        row(case, "energy drift", 0.0, motion.drift, 1e-8)
    else:
        row(case, "energy lost (damping and impact)", 0.0, motion.drift)


@pytest.mark.full
def test_a_bar_hits_another(row):
    """An elastic bar (nu = 0) that flies against an equal one at rest. Source: d'Alembert's waves.

    Both ends move on with v/2, which gives the force rho c (v/2) A, until after 2 L/c both waves are back from the free
    ends and add up to the whole speed: the bars have changed velocities. Tolerances are those of a bar on a wall.
    """
    n, v, area = 10, 0.01, 0.01
    first, other = (
        AncfSolid(
            AncfSpace(fc.shapes.block((1.0, 0.1, 0.1), (n, 1, 1), element="hex8").translated((x, 0.0, 0.0))),
            fc.Material(E=1.0, nu=0.0, density=1.0),
            points=3,
        )
        for x in (-1.0, 1e-7)
    )
    a = Assembly.of([first, other], None, [fc.Contact(first.side("x_max"), other.side("x_min"))])
    along, h = np.array([1.0, 0.0, 0.0]), 0.4 / n
    moved = first.space.affine(np.zeros((3, 3)), along)
    start = np.concatenate([v * moved, np.zeros(other.space.n_dofs)])
    motion = move(a, until=2.4, step=h, scheme=EnergyMomentum(), velocity=start)
    assert motion.success
    F, t = -motion.contact_force[:, 0, 0] / (v * area), motion.time
    case = f"bar on a bar, {n} elements each"
    row(case, "force / rho c (v/2) A", 1.0, 2 * F[(t > 0.3) & (t < 1.7)].mean(), 0.02, a.n_dofs)
    pressed = t[F > 0.02]
    row(case, "duration / (2 L / c)", 1.0, (pressed.max() - pressed.min() + h) / 2, 2.5 * h, a.n_dofs)
    speeds = [
        s.space.affine(np.zeros((3, 3)), along) @ (s.mass @ a.part(motion.now.v, k)) for k, s in enumerate(a.solids)
    ]
    row(case, "speed of the one that was hit / v", 1.0, speeds[1] / (v * area), 0.05, a.n_dofs)
    row(case, "speed left to the other / v", 0.0, speeds[0] / (v * area), 0.05, a.n_dofs)
    momentum = motion.momentum / (v * area) - along
    row(case, "momentum of both, change / m v", 0.0, np.abs(momentum).max(), 1e-8, a.n_dofs)
    row(case, "energy drift", 0.0, motion.drift, 1e-8, a.n_dofs)


@pytest.mark.full
def test_soft_brick_bounces_ten_times_without_losing_energy(row):
    """A soft brick dropped on a floor, ten bounces, energy-momentum scheme. Source: conservation of energy."""
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (2, 2, 1), element="hex8").translated((-0.5, -0.5, 0.05))
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=500.0, nu=0.3, density=1.0), points=3)
    a = Assembly.of([solid], None, [fc.Contact(solid.side("bottom"), fc.RigidBody(fc.Plane(), name="floor"))])
    motion = move(a, until=2.6, step=0.01, scheme=EnergyMomentum(), velocity=(0, 0, -1.0), gravity=(0, 0, -10.0))
    assert motion.success
    pressed = motion.contact_force[:, 0, 2] > 0
    landings = int((pressed[1:] & ~pressed[:-1]).sum())
    assert landings >= 10
    row("bouncing brick", f"energy drift over {landings} bounces", 0.0, motion.drift, 1e-3, a.n_dofs)
    # the motion of a corner in one step: it falls at 1.41 and swings; a corner's multiplier has a 16th of its face
    row("bouncing brick", "deepest penetration / side", 0.0, motion.penetration.max(), 2 * 0.01, a.n_dofs)


def pendulum(n, E, step, until, scheme):
    """Angle of the line from the pin to the far end, its time, and the motion, of a bar hinged at an edge."""
    length, side = 1.0, 0.1
    mesh = fc.shapes.block((length, side, side), (n, 1, 1), element="hex8")
    pin = np.flatnonzero((mesh.points[:, 0] < 1e-9) & (mesh.points[:, 2] < 1e-9))
    mesh = replace(mesh, node_sets={"pin": pin})
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=E, nu=0.3, density=1000.0), points=3)
    a = Assembly.of([solid], [{"pin": "xyz"}])
    motion = move(a, until=until, step=step, scheme=scheme, gravity=(0, 0, -9.81), every=1)
    assert motion.success
    ends = np.array(
        [solid.space.points_at(q, np.array([n - 1]), np.array([[1.0, 0.5, 0.0]]))[0] for q in motion.frames]
    )
    return np.unwrap(np.arctan2(-ends[:, 2], ends[:, 0])), motion.frame_times, motion, a


@pytest.mark.full
def test_stiff_pendulum_is_the_physical_pendulum(row):
    """A stiff bar hinged at an edge, released level. Source: I phi'' = m g d cos(phi + phi0), integrated to 1e-10.

    Only positions are held at the pin; gradients are free there. The step of 1/200 of a swing costs 1e-4.
    """
    length, side = 1.0, 0.1
    reach = np.hypot(length, side) / 2
    lean = np.arctan2(side / 2, length / 2)  # the centre lies above the line from the pin to the far lower edge
    moment = (length**2 + side**2) / 3

    def fall(_, y):
        return [y[1], 9.81 * reach * np.cos(y[0] - lean) / moment]

    until = 1.2
    angle, times, motion, a = pendulum(2, 1e9, 0.006, until, EnergyMomentum())
    exact = solve_ivp(fall, (0, until), [0.0, 0.0], t_eval=times, rtol=1e-10, atol=1e-12).y[0]
    row("stiff pendulum", "angle, largest error (rad)", 0.0, np.abs(angle - exact).max(), 1e-3 * np.pi, a.n_dofs)
    row("stiff pendulum", "energy drift", 0.0, motion.drift, 1e-6, a.n_dofs)


@pytest.mark.full
def test_flexible_pendulum_converges(row):
    """A soft bar hinged at an edge, released level. Source: refinement of itself."""
    angles, drifts, sizes = [], [], []
    for n in (2, 4, 8):
        angle, _, motion, a = pendulum(n, 2e5, 0.01, 0.6, EnergyMomentum())
        angles.append(angle[-1])
        drifts.append(motion.drift)
        sizes.append(a.n_dofs)
    row("flexible pendulum, 2 against 8 elements", "angle at 0.6", angles[2], angles[0], 0.03, sizes[0])
    row("flexible pendulum, 4 against 8 elements", "angle at 0.6", angles[2], angles[1], 1e-2, sizes[1])
    assert abs(angles[1] - angles[2]) < abs(angles[0] - angles[2])
    row("flexible pendulum", "energy drift", 0.0, max(drifts), 1e-6, sizes[2])
