"""Loads that follow the deformation against closed forms; points and moments; what a stage refuses."""

from itertools import pairwise

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    Assembly,
    FollowerPressure,
    Moment,
    Stage,
    equilibrium,
    force_at,
    released_at,
)


def turned(space, shake):
    """Coordinates turned by a large angle and shaken."""
    turn = fc.rotation_about((1.0, 2.0, -0.5), 1.3)
    return space.affine(turn) + shake * np.random.default_rng(0).standard_normal(space.n_dofs)


@pytest.fixture(scope="module")
def space():
    return AncfSpace(fc.shapes.block((1.0, 1.2, 0.8), (2, 1, 1), element="hex8"))


@pytest.mark.parametrize("at", ["x_max", "top", 3])
def test_a_moment_is_that_and_no_force_in_any_state(space, at):
    q, m = turned(space, 0.1), np.array([1.0, -2.0, 0.5])
    load = Moment(0, at, m)
    e, Q = q.reshape(-1, 3), load.forces(space, q).reshape(-1, 3)
    # virtual work on translations and on turns of the present shape: dr = w x r, d(dr/dX) = w x dr/dX
    assert np.abs(Q[space.start].sum(axis=0)).max() < 1e-13
    assert np.abs(np.cross(e, Q).sum(axis=0) - m).max() < 1e-13
    d, h = np.random.default_rng(1).standard_normal(space.n_dofs), 1e-5
    change = (load.forces(space, q + h * d) - load.forces(space, q - h * d)) / (2 * h)
    assert np.abs(load.tangent(space, q) @ d - change).max() < 1e-8 * np.abs(change).max()  # central differences, h^2


def test_a_moment_does_the_work_of_the_angle_in_a_plane(space):
    """Potential -M angle: its work on a closed loop of turns and stretches in a plane is nothing."""
    load, work = Moment(0, "x_max", (0.0, 0.0, 1.0)), 0.0
    angles = np.linspace(0, 2 * np.pi, 2001)
    states = [space.affine(fc.rotation_about((0, 0, 1), a) @ np.diag([1 + 0.3 * np.sin(a), 1.0, 1.0])) for a in angles]
    for before, after in pairwise(states):
        work += load.forces(space, (before + after) / 2) @ (after - before)
    assert abs(work - 2 * np.pi) < 1e-5  # the mid-point rule's (2 pi / 2000)^2


@pytest.mark.full
def test_a_cantilever_rolled_into_a_circle_by_its_end_moment():
    """M = 2 pi E I / L. A solid of L/h = 100 differs from Euler's beam by (2 pi h/L)^2 = 0.4 %; 12 bricks: 0.4 %."""
    n, length, h, E = 12, 10.0, 0.1, 1e4
    mesh = fc.shapes.block((length, h, h), (n, 1, 1), element="hex8").translated((0.0, -h / 2, -h / 2))
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=E, nu=0.0), points=3)
    a = Assembly.of([solid], [{"x_min": "xyz"}])
    moment = 2 * np.pi * E * h**4 / 12 / length
    path = equilibrium(lambda s: Stage(a, follow=[Moment(0, "x_max", (0.0, -s * moment, 0.0))]), steps=6)
    assert path.success
    x = solid.space.points_at(path.last.q, np.arange(n), np.full((n, 3), 0.5))
    radius = length / (2 * np.pi)
    assert np.abs(np.hypot(x[:, 0], x[:, 2] - radius) / radius - 1).max() < 8e-3
    assert abs(path.last.energy / (np.pi * moment) - 1) < 4e-3
    assert np.abs(path.last.reactions.reshape(-1, 3)[solid.space.start].sum(axis=0)).max() < 1e-8 * moment / h


def tube(x):
    """From radius 1 to 2, a quarter round the axis z."""
    r, angle = 2.0 ** x[:, 0], x[:, 1] * np.pi / 2
    return np.stack([r * np.cos(angle), r * np.sin(angle), x[:, 2]], axis=1)


def shell(x):
    """From radius 1 to 2, between the planes y = 0, z = 0, x = y and x = z: a face's quarter of a cube on a sphere."""
    d = np.stack([np.ones(len(x)), np.tan(np.pi / 4 * x[:, 1]), np.tan(np.pi / 4 * x[:, 2])], axis=1)
    return 2.0 ** x[:, :1] * d / np.linalg.norm(d, axis=1)[:, None]


@pytest.mark.by_day("tube")
@pytest.mark.parametrize("form", [tube, shell])
def test_inflation_of_rubber(form):
    """A thick tube and sphere, inner radius stretched by a half. Source: R. S. Rivlin, Phil. Trans. A 242 (1949).

    With the hoop stretch s = r/R, s^2 R^2 (tube) or s^3 R^3 (sphere) changes by a constant, and of the neo-Hookean
    material p = mu (ln(s1/s2) + (s2^-2 - s1^-2)/2) or mu (2/s2 + s2^-4/2 - 2/s1 - s1^-4/2). The material here has nu =
    0.499, which softens it by some (1 - 2 nu) = 0.2 %.
    """
    nu, inner = 0.499, 1.5
    mesh = fc.shapes.block(
        (1.0, 1.0, 0.5 if form is tube else 1.0),
        (2, 3 if form is tube else 2, 1 if form is tube else 2),
        element="hex20",
    )
    solid = AncfSolid(AncfSpace(mesh.mapped(form)), fc.NeoHookean(2 * (1 + nu), nu), points=3, volumetric=2)
    power = 2 if form is tube else 3
    outer = (2.0**power + inner**power - 1) ** (1 / power) / 2
    if form is tube:
        pressure = np.log(inner / outer) + (outer**-2 - inner**-2) / 2
        a = Assembly.of([solid], [{"y_min": "y", "y_max": "x", "bottom": "z", "top": "z"}])
    else:
        pressure = 2 / outer + outer**-4 / 2 - 2 / inner - inner**-4 / 2
        a = Assembly.of([solid], [{"y_min": "y", "y_max": "n", "bottom": "z", "top": "n"}])
    path = equilibrium(lambda s: Stage(a, follow=[FollowerPressure(0, "x_min", s * pressure)]), steps=4)
    assert path.success
    X, x = (q.reshape(-1, 3)[solid.space.start] for q in (a.q0, path.last.q))
    axes = slice(0, power)
    R, r = (np.linalg.norm(p[:, axes], axis=1) for p in (X, x))
    assert np.abs(r[R < 1.001] / inner - 1).max() < 3e-3
    assert np.abs(r[R > 1.999] / (2 * outer) - 1).max() < 3e-3


def test_forces_anywhere():
    mesh = fc.shapes.block((2.0, 1.0, 1.0), (3, 2, 2), element="hex20")
    space = AncfSpace(mesh.mapped(lambda x: x + 0.1 * np.stack([np.sin(x[:, 1]), x[:, 0] ** 2, np.sin(x[:, 0])], 1)))
    rng = np.random.default_rng(0)
    cells, X = np.arange(12).repeat(5), rng.random((60, 3))
    X[:12, 0] = 1.0  # on faces
    x = space.points_at(space.q0, cells, X)
    found, local = space.located(x)
    assert np.abs(space.points_at(space.q0, found, local) - x).max() < 1e-12
    assert (found[12:] == cells[12:]).all()
    force = np.array([1.0, -2.0, 0.5])
    expected = np.concatenate([force, np.cross(x[20], force)])
    assert np.abs(force_at(space, x[20], force) @ space.rigid_modes() - expected).max() < 1e-12
    with refused(fc.InputError, "points-outside-body", "1 of", "of 2"):
        space.located([x[0], (5.0, 0.0, 0.0)])


def released():
    mesh = fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8")
    point = int(np.flatnonzero((mesh.points == [1.0, 0.0, 0.0]).all(axis=1))[0])
    return AncfSpace(mesh, released_at(mesh, [point])), point


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda a: Stage(a, forces=np.zeros(5)), ("stage-shape", "forces", "144")),
        (lambda a: Stage(a, motion=np.full(144, np.nan)), ("stage-shape", "not finite")),
        (lambda a: Stage(a, motion=a.translation(np.ones(3))), ("motion-not-held", "assembly.held")),
        (lambda a: Stage(a, follow=[FollowerPressure(1, "top", 1.0)]), ("no-bricks", "number 1", "the 1")),
        (lambda a: FollowerPressure(0, "top", np.inf), ("not-finite", "inf")),
        (lambda a: Moment(0, "top", (1.0, 2.0)), ("not-a-vector", "three")),
        (lambda a: Stage(a, follow=[Moment(0, 99, (1.0, 0.0, 0.0))]).load(a.q0), ("input", "no corner")),
        (lambda a: Stage(a, follow=[FollowerPressure(0, "lid", 1.0)]).load(a.q0), ("unknown-boundary", "'lid'")),
        (lambda a: Stage(a, follow=[Moment(0, "top", (1.0, 0.0, 0.0))]).load(0 * a.q0), ("input", "flattened")),
        (
            lambda a: Moment(0, released()[1], (1.0, 0.0, 0.0)).forces(released()[0], released()[0].q0),
            ("input", "released"),
        ),
    ],
)
def test_refused(space, make, match):
    a = Assembly.of([AncfSolid(space, fc.Material(E=1.0, nu=0.3))])
    with refused(fc.InputError, *match):
        make(a)
    held = Assembly.of(a.solids, [{"bottom": "xyz"}])
    moved = held.translation(np.ones(3))
    with refused(fc.InputError, "motion-not-held"):
        Stage(held, motion=moved)  # the top is free
    short = Stage(held, motion=held.held(moved)).jump(held.q0)
    assert np.abs(short - held.held(moved)).max() < 1e-15
