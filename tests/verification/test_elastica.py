"""Beams in absolute nodal coordinates at large rotations: elastica, a full circle, a falling pendulum."""

import math

import numpy as np
import pytest

from fecontact.analytic.elastica import elastica
from fecontact.ancf import Assembly, EnergyMomentum, Stage, equilibrium, move
from fecontact.app.slender.elastica import CRITICAL, EA, EI, LOADS, cantilever, corotational, follow
from fecontact.app.slender.problems import pendulum


@pytest.mark.parametrize(("n", "most"), [(10, 0.013), (20, 6e-4)])
def test_elastica(n, most, row):
    """A cantilever under a compressive force at its tip, from just above the critical load to 176 degrees.

    Source: L. M. Campanelli, M. Berzeri & A. A. Shabana, J. Mech. Des. 122 (2000), table 2, whose errors are 1.8 and
    3.2 degrees; the exact solution of the same strain measure. Cubic functions with stretch integrated at five points
    reach 0.011 degrees with ten elements, and lock where the axis is stiffer; here it is 0.0128, without locking.
    """
    beam, free = cantilever(n)
    states = follow(beam, free)
    angles, last = [math.degrees(beam.angles(s.q)[-1]) for s in states], beam.positions(states[-1].q)[-1]
    exact = [elastica(load * CRITICAL, 1.0, EI, EA) for load in LOADS]
    for load, found, known in zip(LOADS, angles, exact, strict=True):
        case, error = f"elastica, {n} elements, P = {load} Pcr", abs(found - math.degrees(known.angle))
        row(
            f"elastica, {n} elements, P = {load} Pcr", "error of the tip's angle, degrees", 0.0, error, most, dofs=4 * n
        )
    row(case, "tip along the axis", exact[-1].x, last[0], 0.05 * 10 / n**2, dofs=4 * n)
    row(case, "tip across", exact[-1].y, last[1], 0.05 * 10 / n**2, dofs=4 * n)


def test_elastica_of_an_axis_a_thousand_times_as_stiff(row):
    """The inextensible limit; stretch must not lock bending."""
    beam, free = cantilever(20, stiffer=1000.0)
    found = math.degrees(beam.angles(follow(beam, free, LOADS[:5])[-1].q)[-1])
    known = math.degrees(elastica(LOADS[4] * CRITICAL, 1.0, EI).angle)
    row("elastica, 20 elements, EA x 1000", "error of the tip's angle, degrees", 0.0, abs(found - known), 0.01)


@pytest.mark.parametrize(("procedure", "most"), [("modern", (3e-4, 6e-5)), ("1986", (1.4, 0.34))])
def test_elastica_by_corotational_beams(procedure, most, row):
    """The baseline of the same paper, against the same closed form.

    Pseudo-vectors in place of turns are off by t^3/24, where the axis bends most: order 2. Cubic functions in a frame
    of their own are those of the linear beam, exact at its nodes, and better here than a cubic axis.
    """
    exact = np.degrees([elastica(load * CRITICAL, 1.0, EI, EA).angle for load in LOADS])
    for n, limit in zip((10, 20), most, strict=True):
        beam, free = corotational(n, procedure)
        angles = np.degrees([beam.angles(s.q)[-1] for s in follow(beam, free)])
        error = float(np.abs(angles - exact).max())
        row(f"elastica, {n} corotational beams, {procedure}", "error of the angle, degrees", 0.0, error, limit)


def test_full_circle(row):
    """A bar bent by the moment 2 pi EI / L at its end; the angle converges with the fourth power of the elements."""
    errors = []
    for n, most in ((10, 0.3), (20, 0.02)):
        beam, free = cantilever(n)
        moment = 2 * math.pi * EI

        def stage(level, beam=beam, free=free, moment=moment):
            return Stage(Assembly([beam.turned(((-1, level * moment),))], free))

        path = equilibrium(stage, steps=8)
        assert path.success
        errors.append(abs(math.degrees(beam.angles(path.last.q)[-1]) - 360))
        row(f"full circle, {n} elements", "error of the tip's angle, degrees", 0.0, errors[-1], most, dofs=4 * n)
    # between 10 and 20 elements; between 20 and 40 it is 4.2
    row("full circle", "order", 4.0, math.log2(errors[0] / errors[1]), 0.1)


#: Deflection of the middle of a falling pendulum from its chord, at 0.1, 0.2, 0.3, 0.4 s; 100 elements, integrated with
#: an energy drift of 1e-11 (the reference data of this project).
FALLING = {9.81: (-0.024557, -0.100062, -0.234782, -0.21754)}


def test_falling_pendulum(row):
    """A very flexible bar, pinned at one end, falls from rest: shape and energy.

    Source: Campanelli, Berzeri & Shabana 2000, section 6 (density 5540, which the paper does not give); a solution of
    the same equations by a Runge-Kutta integrator of the eighth order.
    """
    n = 12
    beam, free = pendulum(n)
    assembly = Assembly([beam], free)
    motion = move(assembly, until=0.4, step=2e-3, gravity=(0, -9.81, 0), scheme=EnergyMomentum(), every=50)
    assert motion.success
    for t, q, known in zip(motion.frame_times[1:], motion.frames[1:], FALLING[9.81], strict=True):
        x = beam.positions(q)
        chord = (x[-1] - x[0]) / np.linalg.norm(x[-1] - x[0])
        middle = chord[0] * (x[n // 2] - x[0])[1] - chord[1] * (x[n // 2] - x[0])[0]
        off = abs(middle - known)
        # twelve elements and steps of 2 ms: a thousandth of the length, later three
        row(f"pendulum at t = {t:.1f} s", "error of the middle's deflection, m", 0.0, off, 4e-3, dofs=4 * n)
    row("pendulum", "drift of the energy", 0.0, motion.drift, 1e-6, dofs=4 * n)
