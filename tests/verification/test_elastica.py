"""Beams in absolute nodal coordinates at large rotations: elastica, a full circle, a falling pendulum."""

import math

import numpy as np
import pytest

from fecontact.analytic.elastica import elastica
from fecontact.ancf import Assembly, EnergyMomentum, Stage, equilibrium, move
from fecontact.ancf.slender import Joints, line, straight

# the paper's beam, in SI units
EA, EI = 2.0e9 * 1.257e-3, 2.0e9 * 1.257e-7
CRITICAL = math.pi**2 * EI / 4
#: Loads of the paper's table, over the critical one.
LOADS = (1.015, 1.063, 1.152, 1.293, 1.518, 1.884, 2.541, 4.029, 9.116)


def cantilever(n, **options):
    beam = line(straight((0, 0, 0), (1, 0, 0), n), **{"EA": EA, "EI": EI, **options})
    joints = Joints([beam])
    return beam, joints.free([joints.flat(), joints.clamped((0, 0))])


def bent(n, loads, **options):
    """Tip angles in degrees and the last state; a small force across, gone at full load, starts the bending."""
    beam, free = cantilever(n, **options)
    assembly, angles, start = Assembly([beam], free), [], None
    for k, load in enumerate(loads):

        def stage(level, load=load, first=k == 0):
            f = np.zeros(beam.vectors.shape)
            f[-1, 0, 0] = -load * CRITICAL * (level if first else 1.0)
            f[-1, 0, 1] = 0.02 * load * CRITICAL * (1 - level) if first else 0.0
            return Stage(assembly, f.ravel())

        path = equilibrium(stage, steps=4 if k == 0 else 1, start=start, tolerance=1e-10)
        assert path.success
        start = path.last
        angles.append(math.degrees(beam.angles(start.q)[-1]))
    return np.array(angles), beam.positions(start.q)[-1]


@pytest.mark.parametrize(("n", "most"), [(10, 0.013), (20, 6e-4)])
def test_elastica(n, most, row):
    """A cantilever under a compressive force at its tip, from just above the critical load to 176 degrees.

    Source: L. M. Campanelli, M. Berzeri & A. A. Shabana, J. Mech. Des. 122 (2000), table 2, whose errors are 1.8 and
    3.2 degrees; the exact solution of the same strain measure. Cubic functions with stretch integrated at five points
    reach 0.011 degrees with ten elements, and lock where the axis is stiffer; here it is 0.0128, without locking.
    """
    angles, last = bent(n, LOADS)
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
    angles, _ = bent(20, LOADS[:5], EA=1000 * EA)
    known = math.degrees(elastica(LOADS[4] * CRITICAL, 1.0, EI).angle)
    row("elastica, 20 elements, EA x 1000", "error of the tip's angle, degrees", 0.0, abs(angles[-1] - known), 0.01)


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
    n, length = 12, 1.2
    beam = line(straight((0, 0, 0), (length, 0, 0), n), EA=0.7e6 * 1.8e-3, EI=0.7e6 * 1.215e-8, mass=5540 * 1.8e-3)
    joints = Joints([beam])
    assembly = Assembly([beam], joints.free([joints.flat(), joints.pinned((0, 0))]))
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
