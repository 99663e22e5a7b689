"""Beams in absolute nodal coordinates at large rotations: elastica, a full circle, a falling pendulum."""

import math

import numpy as np
import pytest

from fecontact.analytic.elastica import elastica
from fecontact.app.studies.elastica import CRITICAL, EA, EI, LOADS, cantilever, corotational, follow
from fecontact.app.studies.slender import run


@pytest.mark.parametrize(("n", "most"), [(10, 0.003), (20, 1.2e-4)])
def test_elastica(n, most, row):
    """A cantilever under a compressive force at its tip, from just above the critical load to 176 degrees.

    Source: L. M. Campanelli, M. Berzeri & A. A. Shabana, J. Mech. Des. 122 (2000), table 2, whose errors are 1.8 and
    3.2 degrees; the exact solution of the same strain measure.
    """
    beam, held = cantilever(n)
    states = follow(beam, held)
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
    beam, held = cantilever(20, stiffer=1000.0)
    found = math.degrees(beam.angles(follow(beam, held, LOADS[:5])[-1].q)[-1])
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
        beam, held = corotational(n, procedure)
        angles = np.degrees([beam.angles(s.q)[-1] for s in follow(beam, held)])
        error = float(np.abs(angles - exact).max())
        row(f"elastica, {n} corotational beams, {procedure}", "error of the angle, degrees", 0.0, error, limit)


def test_full_circle(row):
    """A bar bent by the moment 2 pi EI / L at its end; the angle converges with the fourth power of the elements."""
    errors = []
    for n, most in ((10, 0.03), (20, 0.002), (40, 1.2e-4)):
        _, found, known, _ = run("circle", {"elements": n}).rows.rows[-1]
        errors.append(abs(found - known))
        row(f"full circle, {n} elements", "error of the tip's angle, degrees", 0.0, errors[-1], most, dofs=4 * n)
    row("full circle", "order", 4.0, math.log2(errors[1] / errors[2]), 0.1)


@pytest.mark.by_day("9.81")
@pytest.mark.parametrize("gravity", [9.81, 50.0])
def test_falling_pendulum(gravity, row):
    """A very flexible bar, pinned at one end, falls from rest: shape and energy.

    Source: Campanelli, Berzeri & Shabana 2000, section 6 (density 5540, which the paper does not give); a solution of
    the same equations with 100 elements by a Runge-Kutta integrator of the eighth order. The paper finds twelve
    elements inaccurate under 50 m/s^2.
    """
    found = run("pendulum", {"elements": 12, "gravity": gravity})
    for time, middle, known, _ in found.rows.rows:
        case = f"pendulum, 12 elements, {gravity} m/s^2, {time}"
        row(case, "error of the middle's deflection, m", 0.0, abs(middle - known), 1e-3, dofs=48)
    drift = found.data["drift of the energy"]
    row(f"pendulum, 12 elements, {gravity} m/s^2", "drift of the energy", 0.0, drift, 1e-6, dofs=48)
