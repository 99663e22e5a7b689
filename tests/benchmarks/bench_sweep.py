"""Sweep of a gait cycle: seconds of 100 poses in units of the first solution, on knee-like bodies of 30,000 unknowns.

    OMP_NUM_THREADS=1 python tests/benchmarks/bench_sweep.py [n poses] [--processes 2]

The bodies are those of examples/knee.py: two condyles on two plateaus, coupled by mortar on faces that do not match.
Flexion swings between 0 and 60 degrees as in a step, the load between 0.3 and 2.2 kN in two humps (the shape of ISO
14243-1, not its figures); the femur is free to tilt. Printed are CPU seconds, those of the children included, for one
`Scene.solve` on fresh bodies and for the sweep, their ratio, and wall seconds.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import time
from pathlib import Path
from types import ModuleType

import numpy as np

import fecontact as fc


def knee() -> ModuleType:
    """The example as a module."""
    path = Path(__file__).parents[2] / "examples" / "knee.py"
    spec = importlib.util.spec_from_file_location("knee", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def gait(poses: int) -> list[tuple[float, float]]:
    """Flexion in degrees and load over a cycle."""
    phase = np.linspace(0.0, 1.0, poses, endpoint=False)
    swing = 7.5 * (1 - np.cos(4 * np.pi * phase)) + 45.0 * np.exp(-(((phase - 0.72) / 0.12) ** 2))
    humps = np.exp(-(((phase - 0.13) / 0.08) ** 2)) + 1.15 * np.exp(-(((phase - 0.45) / 0.09) ** 2))
    return list(zip(swing.tolist(), (100.0 + 750.0 * humps).tolist(), strict=True))


def scene(module: ModuleType, n: int) -> tuple[fc.Scene, fc.ElasticBody]:
    """The femur over the tibia in extension."""
    below = module.tibia(n)
    bone = module.femur(n).placed((0.0, 0.0, module.HEIGHT))
    return fc.Scene([below, bone], [fc.Contact(bone, below)]), bone


def cases(bone: fc.ElasticBody, poses: int) -> list[dict]:
    """One case for every instant of the cycle."""
    up = bone.pose.translation
    return [
        {
            "poses": {bone: fc.Pose(fc.rotation_about((1, 0, 0), np.radians(angle)), up)},
            "forces": {bone: (0.0, 0.0, -load)},
            "free": {bone: "ry"},
        }
        for angle, load in gait(poses)
    ]


def cpu() -> float:
    """CPU seconds of this process and of children that have ended."""
    t = os.times()
    return t.user + t.system + t.children_user + t.children_system


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("n", nargs="?", type=int, default=8, help="faces across a condyle")
    parser.add_argument("poses", nargs="?", type=int, default=100)
    parser.add_argument("--processes", type=int, default=1)
    options = parser.parse_args()
    module = knee()
    warm, bone = scene(module, 5)
    warm.solve(**{k: v for k, v in cases(bone, 1)[0].items() if k != "poses"})
    whole, bone = scene(module, options.n)
    first = {k: v for k, v in cases(bone, options.poses)[0].items() if k != "poses"}
    began, wall = cpu(), time.perf_counter()
    result = whole.solve(**first)
    result.summary()
    one, one_wall = cpu() - began, time.perf_counter() - wall
    stages = "  ".join(f"{k} {v:.2f}" for k, v in result.seconds.items())
    print(f"{result.n_dofs} dofs; first solution {one:.2f} s CPU, {one_wall:.2f} s wall; {stages}", flush=True)
    whole, bone = scene(module, options.n)
    began, wall = cpu(), time.perf_counter()
    extra = {"processes": options.processes} if options.processes > 1 else {}
    rows = whole.sweep(cases(bone, options.poses), **extra)
    many, many_wall = cpu() - began, time.perf_counter() - wall
    print(f"{len(rows)} poses {many:.2f} s CPU, {many_wall:.2f} s wall: {many / one:.1f} times the first solution")
    total: dict[str, float] = {}
    for row in rows:
        for stage, seconds in row["seconds"].items():
            total[stage] = total.get(stage, 0.0) + seconds
    print("stages in all: " + "  ".join(f"{k} {v:.2f}" for k, v in total.items()))


if __name__ == "__main__":
    main()
