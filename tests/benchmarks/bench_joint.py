"""Joint of two triangulated layers along a gait cycle: processor seconds of each pose, the first included.

    OMP_NUM_THREADS=1 python tests/benchmarks/bench_joint.py [n poses] [--pictures]

The bodies are those of examples/gait.py, 4 n^2 triangles each: the femur finds its place on the tibia in two directions
and along the force, so a pose takes one to three solutions of small motions.
"""

from __future__ import annotations

import argparse
import importlib.util
import tempfile
import time
from pathlib import Path
from types import ModuleType

import fecontact as fc


def gait() -> ModuleType:
    """The example as a module."""
    path = Path(__file__).parents[2] / "examples" / "gait.py"
    spec = importlib.util.spec_from_file_location("gait", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("n", nargs="?", type=int, default=25)
    parser.add_argument("poses", nargs="?", type=int, default=20)
    parser.add_argument("--pictures", action="store_true", help="write the maps too")
    options = parser.parse_args()
    example = gait()
    example.main(n=5, poses=1, out=tempfile.mkdtemp())
    began = time.process_time()
    joint = fc.Joint(example.condyle(options.n), example.plateau(options.n), example.THICKNESS, example.CARTILAGE)
    print(f"{sum(body.n_dofs for body in joint.bodies)} dofs in all, made in {time.process_time() - began:.1f} s")
    share, path, forces = example.gait(options.poses)
    maps = tempfile.mkdtemp() if options.pictures else None
    began = time.process_time()
    table = joint.follow(path, forces, free="x y", times=share, maps=maps)
    spent = time.process_time() - began
    slowest = max(row["seconds"]["total"] for row in table.rows)
    print(f"{len(path)} poses: {spent:.1f} s CPU, {spent / len(path):.2f} s a pose; the longest {slowest:.1f} s (wall)")
    total: dict[str, float] = {}
    for row in table.rows:
        for stage, seconds in row["seconds"].items():
            total[stage] = total.get(stage, 0.0) + seconds
    print("wall seconds of stages: " + "  ".join(f"{k} {v:.2f}" for k, v in total.items()))


if __name__ == "__main__":
    main()
