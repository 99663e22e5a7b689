"""First step of friction: processor seconds of a ball that is pressed on a block and dragged, in one step.

    python tests/benchmarks/bench_friction_step.py           80,703 unknowns, 1,741 candidates
    python tests/benchmarks/bench_friction_step.py 20 5      other divisions of the block, across and in depth

The step presses points anew and is solved three times: whole, and in two halves that tell the error of its size.
"""

import sys
import time

import fecontact as fc
from fecontact.surfaces import Paraboloid

FORCE = 0.15


def main():
    across, deep = map(int, sys.argv[1:]) if len(sys.argv) == 3 else (24, 10)
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (across, across, deep))
    block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), "top", {"bottom": "xyz"}, name="block")
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    middle = (*((low + high) / 2)[:2], high[2])
    ball = fc.RigidBody(Paraboloid(5.0), name="ball").placed(translation=middle)
    scene = fc.Scene([block, ball], [fc.Contact(block, ball, friction=0.3)])
    began = time.process_time()
    path = scene.solve_path([{"forces": {ball: (0.15 * FORCE, 0, -FORCE)}, "free": {ball: "x z"}}])
    seconds, last = time.process_time() - began, path.last
    print(f"{last.n_dofs} unknowns, {last.n_candidates} candidates, {last.friction.nit} Newton steps: {seconds:.1f} s")
    print(f"stick area {last.contacts[0].stick_area:.9f}, largest pressure {last.contacts[0].max_pressure:.9f}")


if __name__ == "__main__":
    main()
