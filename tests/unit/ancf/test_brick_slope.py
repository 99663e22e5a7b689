"""A block of bricks that nothing but friction holds on a slope. Source: statics of a rigid block."""

import math

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, FollowerPressure, Stage, equilibrium

ANGLE, WEIGHT = 0.3, 0.5 * 9.81
DOWN = np.array([math.sin(ANGLE), 0.0, -math.cos(ANGLE)])


@pytest.fixture(scope="module")
def solid():
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (2, 2, 1), element="hex8")
    return AncfSolid(AncfSpace(mesh), fc.Material(E=1e3, nu=0.3, density=1.0), points=3)


def on_slope(solid, mu, supports=None):
    floor = fc.RigidBody(fc.Plane(), name="floor")
    return Assembly.of([solid], supports, [fc.Contact(solid.side("bottom"), floor, friction=mu)])


def test_it_holds_without_creep(solid):
    """Twenty steps of constant load: with penalties or regularised friction a block creeps by a share in each."""
    a = on_slope(solid, 1.05 * math.tan(ANGLE))
    load = a.gravity(9.81 * DOWN)
    path = equilibrium(lambda level: Stage(a, forces=load), steps=20)
    assert path.success
    assert len(path.steps) == 20
    first, last = path.steps[0], path.last
    assert first.friction.friction_work > 0
    slipped = np.abs(first.friction.slip[0]).max()
    assert np.array_equal(last.q, first.q)
    # the first state serves all: a step of the same loads is certified, not solved
    assert [s.nit for s in path.steps[1:]] == [0] * 19
    assert max(s.friction.friction_work for s in path.steps[1:]) == 0.0
    assert max(s.residuals.slip for s in path.steps) < 1e-9
    assert last.friction.forces[0].sum(axis=0) == pytest.approx([-WEIGHT * math.sin(ANGLE), 0, 0], abs=1e-8)
    assert last.forces[0].sum() == pytest.approx(WEIGHT * math.cos(ANGLE), rel=1e-8)
    # the moment of the weight about the foot: normal forces lie below the centre, 0.25 above the slope
    part = a.conditions(last.q).parts[0]
    at = (part.means @ part.projection.points)[:, 0] @ last.forces[0] / last.forces[0].sum()
    assert at == pytest.approx(0.5 + 0.25 * math.tan(ANGLE), abs=1e-3)
    # a shake across the slope that friction bears: it comes back to where it was but for what slipped at its rims
    moved = [last]
    for k in range(6):
        shaken = a.gravity(9.81 * (DOWN + np.array([0.0, 0.02 * (-1) ** k, 0.0])))
        moved.append(equilibrium(lambda level, f=shaken: Stage(a, forces=f), steps=1, start=moved[-1]).last)
    slipped = [np.abs(s.friction.slip[0]).max() for s in moved[1:]]
    assert slipped[-1] < 0.5 * slipped[0]
    assert np.abs(moved[-1].q - moved[-3].q).max() < 0.1 * np.abs(moved[-1].q - moved[-2].q).max()


def test_it_is_refused_beyond_with_the_friction_that_would_hold(solid):
    a = on_slope(solid, 0.9 * math.tan(ANGLE))
    load = a.gravity(9.81 * DOWN)
    path = equilibrium(lambda level: Stage(a, forces=level * load), steps=1)
    assert not path.success
    assert "at least mu = 0.309" in path.message


def test_it_slides_with_the_right_force(solid):
    """Let down slowly by one face: what friction does not bear hangs there."""
    mu = 0.5 * math.tan(ANGLE)
    a = on_slope(solid, mu, [{"x_min": "x"}])
    load, along = a.gravity(9.81 * DOWN), a.translation(np.array([1.0, 0.0, 0.0]))
    motion = along - a.free @ (a.free.T @ along)
    path = equilibrium(lambda level: Stage(a, forces=load, motion=0.02 * level * motion), steps=3)
    assert path.success
    normal = WEIGHT * math.cos(ANGLE)
    assert path.last.forces[0].sum() == pytest.approx(normal, rel=1e-8)
    hanging = -path.last.reactions @ along
    # the block spreads a little across the slope while it slides down
    assert hanging == pytest.approx(WEIGHT * math.sin(ANGLE) - mu * normal, rel=1e-4)
    # all of it moved by the same length under a constant load
    slid = path.last.level - path.steps[-2].level
    assert path.last.friction.friction_work == pytest.approx(mu * normal * 0.02 * slid, rel=1e-3)


def test_units_do_not_matter():
    """The same block in micrometres and other units of force: as many iterations, the same forces."""
    found = []
    for length, force in ((1.0, 1.0), (1e6, 1e-4)):
        mesh = fc.shapes.block((length, length, 0.5 * length), (1, 1, 1), element="hex8")
        material = fc.Material(E=1e3 * force / length**2, nu=0.3, density=1.0 / length**3)
        small = AncfSolid(AncfSpace(mesh), material, points=3)
        a = on_slope(small, 1.05 * math.tan(ANGLE))
        load = a.gravity(9.81 * force * DOWN)
        path = equilibrium(lambda level, a=a, load=load: Stage(a, forces=load), steps=1)
        found.append((path.last.nit, path.last.friction.forces[0] / force))
    assert found[0][0] == found[1][0]
    assert found[1][1] == pytest.approx(found[0][1], abs=1e-9)


def test_without_friction_a_free_block_is_refused(solid):
    a = on_slope(solid, 0.0)
    with refused(fc.InputError, "free-rigid-motion"):
        equilibrium(lambda level: Stage(a))


def test_levels_of_the_same_loads_are_told_apart(solid):
    """A level is certified, not solved, where assembly, loads and motions are those of the last one, and only there."""
    a = on_slope(solid, 1.05 * math.tan(ANGLE))
    load = a.gravity(9.81 * DOWN)
    assert Stage(a, forces=load).acts_as(Stage(a, forces=load.copy()))
    other = on_slope(solid, 1.05 * math.tan(ANGLE))
    others = [Stage(a), Stage(a, forces=load * (1 + 1e-12)), Stage(other, forces=load)]
    others += [Stage(a, forces=load, motion=0 * load), Stage(a, forces=load, follow=[FollowerPressure(0, "top", 0.1)])]
    assert not any(Stage(a, forces=load).acts_as(stage) for stage in others)
    path = equilibrium(lambda level: Stage(a, forces=load * (1.0 if level < 0.9 else 1.001)), steps=4)
    assert [s.nit > 0 for s in path.steps] == [True, False, False, True]
