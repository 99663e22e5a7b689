"""A rough periodic surface pressed by tamaas or ContactMechanics, for `tests/benchmarks/bench_rough.py`.

`_rough.py PROGRAM HEIGHTS.npy MEAN_PRESSURE HARDNESS PRESSURES.npy` on E* = 1 and a period of 1; HARDNESS may be inf.
It prints the seconds of processor time without the loading of packages and writes the pressures. Tolerances are looser
than those of this package, in the other program's favour.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np


def tamaas(z: np.ndarray, mean: float, hardness: float) -> Any:
    """Polonsky and Keer's conjugate gradients; Kato's saturated ones with a hardness."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [1.0, 1.0], list(z.shape))
    model.E, model.nu = 1.0, 0.0
    if np.isfinite(hardness):
        solver = tm.KatoSaturated(model, -z, 1e-6, hardness)
    else:
        solver = tm.PolonskyKeerRey(model, -z, 1e-6, tm.PolonskyKeerRey.pressure, tm.PolonskyKeerRey.pressure)
    solver.max_iter = 100_000
    solver.solve(mean)
    return model.traction


def contactmechanics(z: np.ndarray, mean: float, hardness: float) -> Any:
    """Constrained conjugate gradients, with overrelaxation where a hardness needs it."""
    from ContactMechanics import PeriodicFFTElasticHalfSpace, make_system
    from SurfaceTopography import Topography

    substrate = PeriodicFFTElasticHalfSpace(z.shape, 1.0, (1.0, 1.0))
    topography = Topography(-z, (1.0, 1.0), periodic=True)
    system = make_system(interaction="hardwall", substrate=substrate, surface=topography)
    bounded = {"hardness": hardness / z.size} if np.isfinite(hardness) else {}
    system.minimize_proxy(external_force=mean, pentol=1e-6 * float(np.std(z)), **bounded)
    return np.abs(np.asarray(substrate.force)) * z.size


if __name__ == "__main__":
    program, heights, mean, hardness, out = sys.argv[1:]
    z, solve = np.load(heights), {"tamaas": tamaas, "contactmechanics": contactmechanics}[program]
    solve(np.ascontiguousarray(z[::16, ::16]), 0.01, np.inf)  # loads what is loaded late
    began = time.process_time()
    pressure = np.array(solve(z, float(mean), float(hardness)))
    print(time.process_time() - began)
    np.save(out, pressure)
