"""Half-space solver: error against time and work, beside tamaas where it is installed.

    python tests/benchmarks/bench_halfspace.py [N ...]

Problem H1: Hertz in a box of 3a, not periodic, force control, tolerance 1e-8, one thread (set OMP_NUM_THREADS=1).
Columns: cells per side, what was modelled, conjugate gradient steps and active sets on the finest grid, products with a
compliance on all grids, real transforms in units of one of the padded 2N x 2N grid, relative L2 error of the pressure
over r <= 1.2 a, errors of the pressure nearest the centre and of the approach, processor seconds, and those in units of
one forward transform of the padded grid timed in the same run. `--memory N` solves one problem of N x N cells, whole,
and tells the largest memory of the process.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np
import scipy.fft

import fecontact as fc
from fecontact.results.report import peak_memory
from fecontact.surfaces import Paraboloid, self_affine

UNIT = fc.Material(E=1.0, nu=0.0)


def forward_transform(n: int) -> float:
    """Seconds of one forward real transform of the padded grid, the best of three."""
    padded = np.zeros((2 * n, 2 * n))
    seconds = []
    for _ in range(3):
        began = time.process_time()
        scipy.fft.rfft2(padded)
        seconds.append(time.process_time() - began)
    return min(seconds)


def errors(n: int, pressure: np.ndarray, approach: float = np.nan) -> str:
    """Errors of pressures on cells of the box 3a, a = 1."""
    x = (np.arange(n) - (n - 1) / 2) * (3.0 / n)
    r = np.hypot(x[:, None], x[None, :])
    exact = 2 / np.pi * np.sqrt(np.maximum(1 - r**2, 0))
    near = r <= 1.2
    l2 = np.sqrt(((pressure - exact)[near] ** 2).sum() / (exact[near] ** 2).sum())
    k = n // 2
    return f"{l2:9.1e} {pressure[k, k] / exact[k, k] - 1:9.1e} {approach - 1:9.1e}"


def hertz(n: int, symmetry: bool, unit: float) -> str:
    """One row of ours."""
    began = time.process_time()
    half = fc.HalfSpace(UNIT, size=(3.0, 3.0), cells=(n, n))
    contact = half.press(Paraboloid(1.0), force=4 / 3, symmetry=symmetry)
    seconds = time.process_time() - began
    s = contact.solver
    return (
        f"{n:5d} {'quarter' if symmetry else 'whole':18} {s.nit:4d} {s.rounds:3d} {s.products:5d} {s.transforms:7.1f} "
        f"{errors(n, contact.pressure, contact.approach)} {seconds:9.3f} {seconds / unit:7.0f}"
    )


def tamaas(n: int, unit: float) -> str:
    """The same by tamaas, with the non-periodic kernel, on n x n points."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.warning)
    x = (np.arange(n) - (n - 1) / 2) * (3.0 / n)
    surface = -(x[:, None] ** 2 + x[None, :] ** 2) / 2
    began = time.process_time()
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [3.0, 3.0], [n, n])
    model.E, model.nu = 1.0, 0.0
    tm.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tm.PolonskyKeerRey(model, surface, 1e-8, tm.PolonskyKeerRey.pressure, tm.PolonskyKeerRey.pressure)
    solver.setIntegralOperator("dcfft")
    solver.solve(4 / 3 / 9.0)
    seconds = time.process_time() - began
    pressure = np.asarray(model.traction)
    return f"{n:5d} {'tamaas':18} {'':22} {errors(n, pressure)} {seconds:9.3f} {seconds / unit:7.0f}"


def peer(name: str, run: Callable[[int, float], str], n: int, unit: float) -> str:
    """A row of a peer, or why there is none."""
    try:
        return run(n, unit)
    except ImportError as missing:
        return f"{n:5d} {name:18} not installed ({missing.name})"


def rough(n: int) -> None:
    """Area against load of a periodic rough surface."""
    surface = self_affine((n, n), (1.0, 1.0), hurst=0.8, seed=1, rms_slope=0.1, longest=0.25, shortest=8 / n)
    half = fc.HalfSpace(UNIT, size=(1.0, 1.0), cells=(n, n), periodic=True)
    print(f"\nrough surface {n} x {n}, periodic: load, area, slope, steps, sets, transforms of the grid, seconds")
    for load in (0.0005, 0.001, 0.003, 0.006, 0.015):
        contact = half.press(surface.z, force=load)
        s, area = contact.solver, contact.area_fraction
        print(
            f"{load:8.4f} {100 * area:6.2f} % {area * surface.rms_slope / load:6.3f} {s.nit:4d} {s.rounds:3d} "
            f"{s.transforms:7.0f} {s.seconds:7.2f}"
        )


HEAD = "    N modelled          nit set  prod   transf      L2    centre  approach   seconds  in transforms"


def table(cells: Sequence[int], peers: bool) -> Iterator[str]:
    """Rows of ours, and of the peer."""
    hertz(64, True, 1.0)  # imports and plans
    yield HEAD
    for n in cells:
        unit = forward_transform(n)
        yield from (hertz(n, symmetry, unit) for symmetry in (True, False))
        if peers:
            yield peer("tamaas", tamaas, n, unit)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cells", nargs="*", type=int, default=[64, 128, 256, 512, 1024])
    parser.add_argument("--peers", action="store_true", help="run tamaas too")
    parser.add_argument("--memory", type=int, default=0, help="cells per side of one large problem, alone")
    parser.add_argument("--rough", type=int, default=0, help="cells per side of a rough surface")
    options = parser.parse_args()
    if options.memory:
        print(hertz(options.memory, False, np.nan))
        print(f"largest memory {peak_memory() / 1024:.2f} GB")
        return
    for line in table(options.cells, options.peers):
        print(line, flush=True)
    if options.rough:
        rough(options.rough)


if __name__ == "__main__":
    main()
