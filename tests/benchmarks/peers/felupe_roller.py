"""A rubber roller pressed by 46 % in felupe (Dutzler, github.com/adtzlr/felupe), on a rigid plane by a penalty.

Quadrilaterals of 4 nodes in plane strain, Newton's method, factors by PARDISO where pypardiso is installed; the penalty
is a factor of the gap in each node's force.
"""

from __future__ import annotations

import time
from typing import Any

import felupe as fem
import numpy as np
from _hertz import adapter
from _roller import DEPTH, FORCE, NU, OUTER, WIDTH, E, place

try:
    from pypardiso import spsolve  # several times as quick
except ImportError:
    from scipy.sparse.linalg import spsolve

#: Cells through the rubber (four times as many around), steps and penalty: the quickest that were found, from coarse to
#: fine; among them felupe's own penalty, 1. An error of the penalty, which is soft, may hide one of the stiff mesh.
SETTINGS = ("8:4:10", "16:4:1", "16:4:10", "32:6:100", "64:8:1000")


def solved(setting: str) -> dict[str, Any]:
    """Solve at one setting."""
    through, steps, penalty = (int(part) for part in setting.split(":"))
    began = time.process_time()
    mesh = fem.mesh.Rectangle(n=(through + 1, 4 * through + 1))
    s, t = mesh.points.T
    outside = np.flatnonzero(np.isclose(s, 1.0) & (t < 0.5))
    x, z = place(s, t)
    # the floor's own point, just below the roller
    mesh.update(points=np.vstack([np.column_stack([x, z]), [0.0, -OUTER - 1e-9]]))
    floor = mesh.npoints - 1
    mesh.points_without_cells = mesh.points_without_cells[:-1]
    field = fem.FieldContainer([fem.FieldPlaneStrain(fem.RegionQuad(mesh), dim=2)])
    mu, lame = E / 2 / (1 + NU), E * NU / (1 + NU) / (1 - 2 * NU)
    rubber = fem.SolidBody(fem.NeoHookeCompressible(mu=mu, lmbda=lame), field)
    contact = fem.ContactRigidPlane(
        field, points=outside, centerpoint=floor, normal=[0.0, 1.0], items=[rubber], multiplier=float(penalty)
    )
    core, middle = np.zeros(mesh.npoints, bool), np.zeros(mesh.npoints, bool)
    core[:floor], middle[:floor] = np.isclose(s, 0.0), np.isclose(t, 0.0) | np.isclose(t, 1.0)
    last = np.arange(mesh.npoints) == floor
    held = {
        "core": fem.Boundary(field[0], mask=core),
        "middle": fem.Boundary(field[0], mask=middle & ~core, skip=(0, 1)),
        "floor": fem.Boundary(field[0], mask=last, skip=(0, 1)),
        "pressed": fem.Boundary(field[0], mask=last, skip=(1, 0)),
    }
    way = fem.math.linsteps([0, 1], num=steps) * DEPTH
    step = fem.Step(items=[rubber, contact], ramp={held["pressed"]: way}, boundaries=held)
    job = fem.CharacteristicCurve(steps=[step], boundary=held["pressed"])
    job.evaluate(verbose=0, tol=1e-6, solver=spsolve)
    force = 2 * WIDTH * abs(float(np.array(job.y)[-1, 1]))
    seconds = time.process_time() - began
    gap = z[outside] + field[0].values[outside, 1] - (-OUTER + DEPTH)
    return {
        "dofs": 2 * floor,
        "seconds": seconds,
        "mesh_seconds": 0.0,
        "steps": steps,
        "force": force,
        "penetration": float(-gap.min()),
        "errors": {"force": force / FORCE - 1},
    }


if __name__ == "__main__":
    about = {"method": "felupe, 4-node quadrilaterals, penalty", "kind": "solid", "version": fem.__version__}
    adapter(about, SETTINGS, solved, "roller")
