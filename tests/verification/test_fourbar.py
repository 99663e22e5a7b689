"""The four-bar mechanism of Campanelli, Berzeri & Shabana: rigid bars, elastic ones before and in the fold."""

import numpy as np
import pytest
from refusals import refused
from scipy.integrate import solve_ivp

from fecontact import InputError
from fecontact.app.studies.fourbar import GRAVITY, LINKAGE, MOMENT, REFINED, START, Linkage, drive


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
