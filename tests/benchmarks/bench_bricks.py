"""An iteration of ten bricks with gradients: statics, motion, contact with a curved tool.

    OMP_NUM_THREADS=1 python tests/benchmarks/bench_bricks.py

Printed are milliseconds of processor time per iteration, the least of some runs, and their ratio to a dense Cholesky
factor of as many coordinates in the same run, which depends less on the machine.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import scipy.linalg

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, EnergyMomentum, Stage, equilibrium, move, traction

RUNS = 7


def bar(points: int) -> AncfSolid:
    mesh = fc.shapes.block((10.0, 1.0, 1.0), (10, 1, 1), element="hex8").translated((0.0, -0.5, -1.0))
    return AncfSolid(AncfSpace(mesh), fc.Material(E=1e3, nu=0.3, density=1.0), points=points)


def statics(points: int) -> Callable[[], int]:
    """A cantilever bent by the length of its section."""
    a = Assembly.of([bar(points)], [{"x_min": "xyz"}])
    load = traction(a.solids[0].space, "x_max", (0.0, 0.0, -0.25))
    return lambda: sum(s.nit for s in equilibrium(lambda level: Stage(a, forces=level * load), steps=4).steps)


def motion(points: int) -> Callable[[], int]:
    """The same, let go under its weight."""
    a = Assembly.of([bar(points)], [{"x_min": "xyz"}])
    return lambda: int(move(a, until=0.2, step=0.02, scheme=EnergyMomentum(), gravity=(0, 0, -1.0)).nit.sum())


def tool(points: int) -> Callable[[], int]:
    """A beam into which a roll is pressed."""
    roll = fc.RigidBody(fc.surfaces.Cylinder(2.0))
    solid = bar(points)
    a = Assembly.of([solid], [{"x_min": "xyz", "x_max": "xyz"}], [fc.Contact(solid.side("top"), roll)])
    at = [roll.placed((5.0, 0.0, -0.125 * k)) for k in range(5)]
    return lambda: sum(
        s.nit for s in equilibrium(lambda level: Stage(a.with_rigid(at[round(4 * level)])), steps=4).steps
    )


def milliseconds(run: Callable[[], int]) -> float:
    run()
    least = np.inf
    for _ in range(RUNS):
        start = time.process_time()
        iterations = run()
        least = min(least, (time.process_time() - start) / iterations)
    return 1e3 * least


def main() -> None:
    A = np.eye(492) + 1e-3

    def dense() -> int:
        for _ in range(10):
            scipy.linalg.cho_factor(A)
        return 10

    unit = milliseconds(dense)
    print(f"{'':24}{'ms':>8}{'ratio':>8}")
    for name, make in (("statics", statics), ("motion", motion), ("roll pressed in", tool)):
        for points in (4, 3):
            found = milliseconds(make(points))
            print(f"{name + f', {points} points':24}{found:>8.2f}{found / unit:>8.2f}")
    print(f"{'dense factor':24}{unit:>8.2f}{1:>8.2f}")


if __name__ == "__main__":
    main()
