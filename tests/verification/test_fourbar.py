"""The four-bar mechanism of Campanelli, Berzeri & Shabana: rigid bars, elastic ones before and in the fold."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from scipy.integrate import solve_ivp

import fecontact as fc
from fecontact import InputError
from fecontact.ancf import Assembly, EnergyMomentum, FloatingBody, Joints, Moment, Stage, move
from fecontact.app.studies.fourbar import (
    AREA,
    DENSITY,
    GRAVITY,
    LINKAGE,
    MOMENT,
    REFINED,
    SECOND_MOMENT,
    START,
    YOUNG,
    Linkage,
    bars,
    drive,
)


def test_rigid_linkage(row):
    """Closed loops; rates, inertia and height against differences; the driven motion against Lagrange's equation."""
    crank, h = np.linspace(0.1, 6.2, 40), 1e-6
    coupler, follower = LINKAGE.angles(crank)
    ends = LINKAGE.crank * np.exp(1j * crank) + LINKAGE.coupler * np.exp(1j * coupler)
    assert np.abs(ends - LINKAGE.ground - LINKAGE.follower * np.exp(1j * follower)).max() < 1e-15
    changes = np.subtract(LINKAGE.angles(crank + h), LINKAGE.angles(crank - h))
    assert np.abs(np.array(LINKAGE.rates(crank)) - changes / (2 * h)).max() < 1e-8
    # kinetic energy by points of the bars
    x = (np.arange(1000) + 0.5) / 1000
    a, (c, f) = 1.0, (angle[0] for angle in LINKAGE.angles(np.array([1.0])))
    kc, kf = (rate[0] for rate in LINKAGE.rates(np.array([a])))
    tip = 1j * LINKAGE.crank * np.exp(1j * a)
    bars = [(LINKAGE.crank, x * tip), (LINKAGE.coupler, tip + 1j * kc * x * LINKAGE.coupler * np.exp(1j * c))]
    bars.append((LINKAGE.follower, 1j * kf * x * LINKAGE.follower * np.exp(1j * f)))
    kinetic = LINKAGE.mass * sum(length * (np.abs(v) ** 2).mean() for length, v in bars)
    assert abs(LINKAGE.inertia(np.array([a]))[0] / kinetic - 1) < 1e-6

    def slope(function, angle, d=1e-5):
        return (function(np.array([angle + d])) - function(np.array([angle - d])))[0] / (2 * d)

    def lagrange(_, y):
        torque = MOMENT - GRAVITY * slope(LINKAGE.height, y[0]) - slope(LINKAGE.inertia, y[0]) * y[1] ** 2 / 2
        return [y[1], torque / LINKAGE.inertia(y[:1])[0]]

    times, angles = LINKAGE.driven(START, 1.0, MOMENT, GRAVITY)
    found = solve_ivp(lagrange, (0, times[-1]), [START, 0.0], rtol=1e-9, atol=1e-9).y[0, -1]
    row("four-bar, rigid, a revolution", "angle of the crank by Lagrange's equation", found, angles[-1], 1e-6)


@pytest.mark.by_day("True")
@pytest.mark.parametrize("corotational", [False, True])
def test_elastic_linkage(corotational, row):
    """Bars of steel, from rest to the quick part of the first turn: the rigid limit, by two elements each.

    The exact kinematics of the chords are met but for the strains, which are of the order of 1e-5; the steps of 2 ms
    make the crank late.
    """
    course = drive(2, 2e-3, 0.5, corotational=corotational)
    case = f"four-bar, {'corotational beams' if corotational else 'lines'}, 0.5 s"
    exact = LINKAGE.angles(course.angles[:, 0])[1]
    row(case, "follower by exact kinematics, degrees", 0.0, np.degrees(np.abs(course.angles[:, 2] - exact).max()), 3e-3)
    times, angles = LINKAGE.driven(START, 1.0, MOMENT, GRAVITY)
    late = np.degrees(np.interp(course.motion.time, times, angles) - course.angles[:, 0])
    row(case, "crank behind rigid bars, degrees", 0.0, np.abs(late).max(), 0.2)
    row(case, "deflection of the coupler's middle, mm", 0.0, 1e3 * np.abs(course.sag).max(), 0.1)
    row(case, "drift of the energy", 0.0, course.drift, 1e-6)


def test_refined_motion_is_that_of_rigid_bars_before_the_fold(row):
    """The figures that stand beside, of bars of steel until 0.7 s, against the quadrature of the rigid linkage."""
    times, angles = LINKAGE.driven(START, 1.0, MOMENT, GRAVITY)
    rigid = np.degrees(np.interp(0.1 * np.arange(1, 8), times, angles))
    row("four-bar, refined", "crank off rigid bars to 0.7 s, degrees", 0.0, np.abs(rigid - REFINED[:7]).max(), 4e-3)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"coupler": 0.8}, ("crank-cannot-turn",)),
        ({"crank": 0.7, "coupler": 0.5}, ("crank-cannot-turn",)),
        ({"mass": -1.0}, ("not-positive", "mass")),
    ],
)
def test_refusals(given, message):
    with refused(InputError, *message):
        Linkage(**{"crank": 0.5, "coupler": 0.7, "follower": 0.56, "ground": 0.65, "mass": 1.0} | given)


def test_a_moment_too_small_to_lift_the_bars():
    with refused(InputError, "input", "does not turn"):
        LINKAGE.driven(0.5, 1.0, 1.0, GRAVITY)


@pytest.mark.full
def test_bars_with_modes(row):
    """The mechanism of three solids with four modes each, pins at the middles of their ends, to 0.3 s.

    Bars of the same area and second moment; their sections have inertia, up to .1 % of a bar's, that lines have not.
    """
    height = np.sqrt(12 * SECOND_MOMENT / AREA)
    size = np.array([0.0, height, AREA / height])
    members, ends = [], []
    for axis in bars(8):
        length = np.linalg.norm(axis[-1] - axis[0])
        block = fc.shapes.block((length, *size[1:]), (6, 2, 2)).translated(-size / 2)
        ends.append([int(np.linalg.norm(block.points - [x, 0, 0], axis=1).argmin()) for x in (0, length)])
        way = (axis[-1] - axis[0]) / length
        turn = np.array([[way[0], -way[1], 0], [way[1], way[0], 0], [0, 0, 1]])
        mesh = replace(block, points=block.points @ turn.T + axis[0])
        body = fc.ElasticBody(mesh, fc.Material(E=YOUNG, nu=0.3, density=DENSITY))
        members.append(FloatingBody(body.with_modes(4, kept=ends[-1])))
    joints = Joints(members)
    held = [joints.pinned((k, ends[k][0])) for k in (0, 2)]
    held += [joints.spherical((0, ends[0][1]), (1, ends[1][0])), joints.spherical((1, ends[1][1]), (2, ends[2][1]))]
    # no bar turns about its axis or leaves the plane
    held += [joints.pinned((k, node), [(0, 0, 1)]) for k in range(3) for node in range(3)]
    a, weight = Assembly(members, held), None
    weight = a.gravity(np.array([0.0, -GRAVITY, 0.0]))
    stage = Stage(a, weight, follow=[Moment(0, "frame", (0.0, 0.0, MOMENT))])
    motion = move(lambda _: stage, until=0.3, step=2e-3, scheme=EnergyMomentum(), tolerance=1e-7)
    x = members[0].positions(a.part(motion.now.q, 0))[ends[0][1]]
    row(
        "four-bar, bodies with modes, 0.3 s",
        "crank's angle, degrees",
        REFINED[2],
        np.degrees(np.arctan2(x[1], x[0])),
        3e-3,
    )
    row("four-bar, bodies with modes, 0.3 s", "drift of the energy", 0.0, motion.drift, 1e-6)
