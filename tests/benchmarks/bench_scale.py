"""Multigrid against the degrees of freedom: steps, processor seconds and memory, with the fitted exponents.

    python tests/benchmarks/bench_scale.py                 the table up to 1e5 degrees of freedom
    python tests/benchmarks/bench_scale.py 14 20 31 46 69  other divisions; 69 makes 1.03 million (some gigabytes)
    python tests/benchmarks/bench_scale.py --one 31 amg    one row; or with a direct back-end: auto
    python tests/benchmarks/bench_scale.py --two 31 amg    two elastic blocks whose meshes do not match

A quarter of a block of 8-node hexahedra, graded towards the corner where a rigid ball presses. Each row runs in a
process of its own; seconds are those of one thread from the stiffness to the certified answer.
"""

import os
import subprocess
import sys
import time

import numpy as np

import fecontact as fc
from fecontact.results.report import peak_memory

DIVISIONS = (9, 14, 20, 31)
HEAD = "| dofs | candidates | in contact | sets | steps | seconds | peak, MB |"


def graded(n, side, ratio=6.0):
    """Positions from 0 to side, the last interval about three times `ratio` as long as the first."""
    x = np.linspace(0.0, 1.0, n + 1)
    return list(side * (x + (ratio - 1) * x**3) / ratio)


def scene(n, backend):
    """The ball and the scene of it and the block."""
    positions = graded(n, 8.0)
    downwards = [8.0 - z for z in positions[::-1]]
    mesh = fc.shapes.block((8.0, 8.0, 8.0), (positions, positions, downwards), element="hex8")
    supports = {"bottom": "xyz", "x_min": "x", "y_min": "y"}
    body = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "top", supports, name="block", backend=backend)
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    ball = fc.RigidBody(fc.Sphere(10.0), name="ball").placed(translation=(low[0], low[1], high[2]))
    return ball, fc.Scene([body, ball], [fc.Contact(body, ball)])


def two_blocks(n, backend):
    """A quarter of a block with a round lower face, of n + 1 divisions, and of the flat one below, of n."""
    bodies = []
    for count, name, near, far in ((n, "lower", "top", "bottom"), (n + 1, "upper", "bottom", "top")):
        along = graded(count, 8.0)
        heights = [8.0 - z for z in along[::-1]] if name == "lower" else along
        mesh = fc.shapes.block((8.0, 8.0, 8.0), (along, along, heights), element="hex8")
        if name == "upper":
            # the paraboloid fades out towards the upper face
            mesh = mesh.mapped(lambda x: x + np.outer((x[:, :2] ** 2).sum(axis=1) / 20 * (1 - x[:, 2] / 8), (0, 0, 1)))
        supports = {far: "xyz", "x_min": "x", "y_min": "y"}
        bodies.append(fc.ElasticBody(mesh, fc.Material(1.0, 0.3), near, supports, name=name, backend=backend))
    lower, upper = bodies[0], bodies[1].placed(translation=(0.0, 0.0, 8.0))
    return upper, fc.Scene([upper, lower], [fc.Contact(upper, lower)])


def figures(n, backend, make=scene):
    """Degrees of freedom, candidates, in contact, sets, steps, seconds, peak memory."""
    ball, model = make(n, backend)
    began = time.process_time()
    result = model.solve(forces={ball: (0.0, 0.0, -0.03)})
    seconds = time.process_time() - began
    steps = getattr(model.bodies[0].model.condensation.factor, "steps", 0)
    return result.n_dofs, result.n_candidates, result.n_active, result.nit, steps, seconds, peak_memory()


def main():
    if sys.argv[1:2] in (["--one"], ["--two"]):
        make = scene if sys.argv[1] == "--one" else two_blocks
        print("| {} | {} | {} | {} | {} | {:.1f} | {:.0f} |".format(*figures(int(sys.argv[2]), sys.argv[3], make)))
        return
    print(HEAD)
    print("|" + "---|" * (HEAD.count("|") - 1))
    rows = []
    for n in map(int, sys.argv[1:] or DIVISIONS):
        command = [sys.executable, __file__, "--one", str(n), "amg"]
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        out = subprocess.run(command, capture_output=True, text=True, env=environment, check=True).stdout.strip()
        print(out, flush=True)
        rows.append([float(cell) for cell in out.strip("| ").split(" | ")])
    table = np.log(np.array(rows)[:, [0, 4, 5]])
    for k, what in ((1, "steps"), (2, "seconds")):
        print(f"{what} grow with the degrees of freedom to the power {np.polyfit(table[:, 0], table[:, k], 1)[0]:.2f}")


if __name__ == "__main__":
    main()
