"""Hertz contact of half-spaces by tamaas (Frerot et al., J. Open Source Softw. 5 (2020) 2121): n x n points.

Polonsky and Keer's conjugate gradients with the kernel of a free (not periodic) half-space, force prescribed.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import tamaas as tm
from _hertz import E_STAR, FORCE, R, adapter, grid, grid_errors


def solved(n: int) -> dict[str, Any]:
    """Solve on n x n points."""
    size, x, y = grid(n)
    surface = -(x**2 + y**2) / R  # of the relative radius R / 2
    began = time.process_time()
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [size, size], [n, n])
    model.E, model.nu = E_STAR, 0.0
    tm.ModelFactory.registerNonPeriodic(model, "dcfft")
    kind = tm.PolonskyKeerRey.pressure
    solver = tm.PolonskyKeerRey(model, surface, 1e-8, kind, kind)
    solver.setIntegralOperator("dcfft")
    solver.solve(FORCE / size**2)
    seconds = time.process_time() - began
    return {"dofs": n * n, "seconds": seconds, "errors": grid_errors(x, y, np.asarray(model.traction))}


if __name__ == "__main__":
    tm.set_log_level(tm.LogLevel.error)
    about = {"method": "tamaas, half-space", "kind": "half-space", "version": tm.__version__}
    adapter(about, (32, 64, 128, 256, 512), solved)
