"""Friction of bricks over many steps and random walks: creep of a block at rest on a slope, and every condition.

    OMP_NUM_THREADS=1 python tests/benchmarks/bench_brick_friction.py [steps walks]

The cases are those of tests/brick_friction_cases.py, which tests run with fewer steps.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from brick_friction_cases import creep_at_rest, creep_in_motion, creep_in_shakes, elastic_cycle, random_walk

from fecontact.ancf import EnergyMomentum, GeneralisedAlpha


def main() -> None:
    """Print the table."""
    steps, walks = map(int, sys.argv[1:3]) if len(sys.argv) > 2 else (10_000, 100)
    cases: dict[str, Callable[[], float]] = {
        "constant load, motion / first slip": lambda: creep_at_rest(steps),
        "shaken within the cones, motion of the feet / swing": lambda: creep_in_shakes(steps),
        "in motion, GeneralisedAlpha, feet / first slip": lambda: creep_in_motion(steps, GeneralisedAlpha(0.8)),
        "in motion, EnergyMomentum, feet / first slip": lambda: creep_in_motion(steps, EnergyMomentum()),
    }
    for name, case in cases.items():
        began = time.process_time()
        found = case()
        spent = time.process_time() - began
        print(f"{name:<55} {found:9.1e}  {steps} steps, {1e3 * spent / steps:.1f} ms CPU each", flush=True)
    began = time.process_time()
    found = [random_walk(seed) for seed in range(walks)]
    spent = time.process_time() - began
    print(f"{walks} random walks of 8 steps, {spent / walks:.2f} s CPU each")
    for name in found[0]:
        values = [walk[name] for walk in found]
        print(f"  {name:<15} from {min(values):9.1e} to {max(values):9.1e}")
    cycles = [elastic_cycle(seed) for seed in range(walks)]
    print(f"{walks} elastic cycles: " + ", ".join(f"{worst:.1e}" for worst in map(max, zip(*cycles, strict=True))))


if __name__ == "__main__":
    main()
