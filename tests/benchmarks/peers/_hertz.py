"""What the adapters share: the problem H1 in units of its own, errors on a grid of points, and the command line.

An adapter is a script with two ways to be called: ``--about`` prints {"method", "kind", "problems", "settings",
"version"}; ``PROBLEM SETTING`` solves and prints one line of JSON, {"dofs", "errors", "seconds", ...}. The
option ``--peers`` of `tests/benchmarks/compare` runs all adapters of a folder; each may also be run by hand.
"""

from __future__ import annotations

import json
import math
import resource
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

#: Two equal spheres, cm and kgf, as in `fecontact hertz`; then Hertz's solution.
R, E, NU, FORCE = 25.0, 2.0e6, 0.3, 726.4
E_STAR = E / (1 - NU**2) / 2
A = (3 * FORCE * (R / 2) / (4 * E_STAR)) ** (1 / 3)
P0 = 3 * FORCE / (2 * math.pi * A**2)
APPROACH = A**2 / (R / 2)


def grid(n: int) -> tuple[float, np.ndarray, np.ndarray]:
    """Side of a square box of 3 a, and the middles x, y (n, n) of its n x n cells."""
    x = (np.arange(n) - (n - 1) / 2) * (3 * A / n)
    return 3 * A, *np.meshgrid(x, x, indexing="ij")


def grid_errors(x: np.ndarray, y: np.ndarray, pressure: np.ndarray, approach: float | None = None) -> dict[str, Any]:
    """Relative errors of pressures at points that stand for equal areas; only the first one without a sign."""
    r2 = (x**2 + y**2) / A**2
    exact = P0 * np.sqrt(np.maximum(1 - r2, 0))
    near = r2 <= 1.44
    k = np.unravel_index(np.argmin(r2), r2.shape)
    return {
        "pressure_l2": float(np.sqrt(((pressure - exact)[near] ** 2).sum() / (exact[near] ** 2).sum())),
        "centre_pressure": float(pressure[k] / exact[k] - 1),
        "edge_radius": float(np.sqrt(2.5 * (pressure * r2).sum() / pressure.sum()) - 1),
        "approach": None if approach is None else approach / APPROACH - 1,
    }


def adapter(
    about: dict[str, Any], settings: Sequence[Any], solved: Callable[[Any], dict[str, Any]], problem: str = "hertz"
) -> None:
    """Answer the command line: introduce the program, or solve once for what is loaded late and once to be timed."""
    if sys.argv[1:] == ["--about"]:
        print(json.dumps({**about, "problems": [problem], "settings": list(settings)}))
        return
    if len(sys.argv) != 3 or sys.argv[1] != problem:
        raise SystemExit(f"usage: {sys.argv[0]} --about | {problem} SETTING")
    solved(settings[0])
    row = solved(type(settings[0])(sys.argv[2]))
    row["peak_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps(row))
