"""Hertz contact of half-spaces by ContactMechanics (Pastewka et al.): n x n points.

Constrained conjugate gradients with the kernel of a free half-space. The approach is prescribed to be Hertz's, so that
its force stands for the error that the others have in the approach.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from _hertz import APPROACH, E_STAR, FORCE, R, adapter, grid, grid_errors
from ContactMechanics import FreeFFTElasticHalfSpace, __version__, make_system
from SurfaceTopography import Topography


def solved(n: int) -> dict[str, Any]:
    """Solve on n x n points."""
    size, x, y = grid(n)
    heights = -(x**2 + y**2) / R
    began = time.process_time()
    substrate = FreeFFTElasticHalfSpace((n, n), E_STAR, (size, size))
    system = make_system(interaction="hardwall", substrate=substrate, surface=Topography(heights, (size, size)))
    found = system.minimize_proxy(offset=APPROACH, pentol=1e-8 * APPROACH)
    seconds = time.process_time() - began
    forces = np.asarray(substrate.force)[:n, :n]
    pressure = np.abs(forces) * (n / size) ** 2
    errors = grid_errors(x, y, pressure)
    errors["force"] = float(np.abs(forces).sum() / FORCE - 1)
    if not found.success:
        raise SystemExit(f"no solution: {found.message}")
    return {"dofs": n * n, "seconds": seconds, "errors": errors}


if __name__ == "__main__":
    about = {"method": "ContactMechanics, half-space", "kind": "half-space", "version": __version__}
    adapter(about, (32, 64, 128, 256, 512), solved)
