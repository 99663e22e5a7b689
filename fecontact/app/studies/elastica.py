"""The elastica of Campanelli, Berzeri & Shabana (1999): a cantilever under a compressive force at its tip, in SI units.

Source: M. Campanelli, M. Berzeri & A. A. Shabana, Comparison between the absolute nodal coordinate formulation and
incremental procedures, report MBS99-2-UIC, Chicago 1999, section 4 and tables 1 and 2 (J. Mech. Des. 122, 2000).
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from fecontact.analytic.elastica import elastica
from fecontact.ancf import Assembly, Stage, State, equilibrium
from fecontact.ancf.slender import CorotationalBeam, Joints, Structure, line, straight
from fecontact.app.studies.study import Study, slender_study
from fecontact.common.errors import SolverError

EA, EI = 2.0e9 * 1.257e-3, 2.0e9 * 1.257e-7
CRITICAL = math.pi**2 * EI / 4
#: Loads of the paper's tables over the critical one.
LOADS = (1.015, 1.063, 1.152, 1.293, 1.518, 1.884, 2.541, 4.029, 9.116)
#: The paper's angles in degrees, by elements: absolute nodal coordinates (table 2) and the corotational procedure as it
#: stands in ANSYS (table 1), which gave none for the last two loads.
PAPER = {
    "paper, ANCF": {
        10: (21.41, 38.56, 58.80, 78.55, 98.53, 118.48, 138.56, 158.88, 175.57),
        20: (22.53, 39.74, 60.11, 80.04, 100.17, 120.20, 140.22, 160.22, 176.11),
    },
    "paper, ANSYS": {
        10: (33.25, 41.51, 59.35, 79.53, 99.82, 119.98, 130.77, math.nan, math.nan),
        20: (33.85, 42.15, 59.80, 79.79, 99.93, 119.98, 131.84, math.nan, math.nan),
    },
}


def cantilever(n: int, measure: str = "turn", stiffer: float = 1.0) -> tuple[Structure, list[sp.csr_matrix]]:
    """The paper's beam, clamped, and its conditions; its axis may be stiffer by a factor."""
    beam = line(straight((0, 0, 0), (1, 0, 0), n), EA=stiffer * EA, EI=EI, measure=measure)
    joints = Joints([beam])
    return beam, [joints.flat(), joints.clamped((0, 0))]


def corotational(n: int, procedure: str) -> tuple[CorotationalBeam, list[sp.csr_matrix]]:
    """The same beam, clamped, by a corotational procedure."""
    beam = CorotationalBeam(straight((0, 0, 0), (1, 0, 0), n), EA=EA, EI=EI, procedure=procedure)
    joints = Joints([beam])
    return beam, [joints.clamped((0, 0))]


def follow(
    beam: Structure | CorotationalBeam, conditions: Sequence[sp.csr_matrix], loads: Sequence[float] = LOADS
) -> list[State]:
    """Equilibria under increasing loads, each from the one before.

    A force across, which vanishes as the first load rises, starts the bending; with 0.3 of that load the bar bends on
    the way as much as it does in the end.

    Raises
    ------
    SolverError
        If an equilibrium is not found.
    """
    assembly = Assembly([beam], conditions)
    found: list[State] = []
    for load in loads:

        def stage(level: float, force: float = load * CRITICAL, first: bool = not found) -> Stage:
            f = np.zeros(beam.vectors.shape)
            f[-1, 0, :2] = (-level * force, 0.3 * (1 - level) * force) if first else (-force, 0.0)
            return Stage(assembly, f.ravel())

        path = equilibrium(stage, steps=1 if found else 2, start=found[-1] if found else None, tolerance=1e-10)
        if not path.success:
            raise SolverError(f"The elastica under {load} of the critical load was not found. {path.message}")
        found.append(path.last)
    return found


def solve(n: int, measure: str) -> Study:
    """The nine loads, beside the closed form, both corotational procedures and the paper's tables."""
    began = time.perf_counter()
    beam, conditions = cantilever(n, measure)
    states = follow(beam, conditions)
    seconds = time.perf_counter() - began
    found = [math.degrees(beam.angles(s.q)[-1]) for s in states]
    known = [math.degrees(elastica(load * CRITICAL, 1.0, EI, EA).angle) for load in LOADS]
    cases = {f"{load:.3f} Pcr": both for load, both in zip(LOADS, zip(found, known, strict=True), strict=True)}
    beside, remarks = {}, {}
    for procedure in ("modern", "1986"):
        other, others_held = corotational(n, procedure)
        bent = follow(other, others_held)
        beside[f"corotational, {procedure}"] = tuple(math.degrees(other.angles(s.q)[-1]) for s in bent)
        turned = max(float(np.abs(other.local_turns(s.q)).max()) for s in bent)
        remarks[f"largest turn in an element, corotational, {procedure}"] = math.degrees(turned)
    bent = follow(*cantilever(n, "chord"))
    beside["in the chord's frame"] = tuple(math.degrees(beam.angles(s.q)[-1]) for s in bent)
    beside |= {name: columns[n] for name, columns in PAPER.items() if n in columns}
    shapes = {f"{load:.3f}": beam.points(s.q).reshape(-1, 3) for load, s in zip(LOADS, states, strict=True)}
    return slender_study("elastica", "degrees", n, cases, shapes, seconds, remarks, beside)
