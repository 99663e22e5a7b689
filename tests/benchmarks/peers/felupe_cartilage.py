"""A rigid ball pressed into a thin layer on a rigid base in felupe: the force by depth, for tests of finite strain.

    peers/bin/python tests/benchmarks/peers/felupe_cartilage.py cartilage 64:0.45

A layer of thickness 1 and radius 6, bonded to its base, neo-Hookean with E = 1, under a ball of radius 4 without
friction, axisymmetric; by 40 % of its thickness. Quadrilaterals of 4 nodes, contact by a penalty whose largest gap is
printed. A setting is the number of cells through the thickness and Poisson's ratio.
"""

from __future__ import annotations

import time
from typing import Any

import felupe as fem
import numpy as np
from _hertz import adapter

try:
    from pypardiso import spsolve  # several times as quick
except ImportError:
    from scipy.sparse.linalg import spsolve

E, RADIUS, EXTENT = 1.0, 4.0, 6.0
DEPTHS = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4)
SETTINGS = ("16:0.45", "32:0.45", "64:0.45", "32:0.49", "64:0.49")
#: Load steps for each depth.
STEPS = 10


class Ball(fem.mechanics.ContactRigidBase):
    """Contact with a rigid ball, as in the documentation of its base class."""

    def _kinematics(self, dx: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        distance = np.linalg.norm(dx, axis=1)
        normal = dx / distance[:, None]
        across = np.eye(2) - normal[:, :, None] * normal[:, None, :]
        return distance - RADIUS, normal, across / distance[:, None, None]


def solved(setting: str) -> dict[str, Any]:
    """Solve at one setting."""
    cells, nu = int(setting.partition(":")[0]), float(setting.partition(":")[2])
    began = time.process_time()
    # felupe's axis of revolution is the first; cells as wide as high to a radius of 2.5, then wider
    inner = np.linspace(0, 2.5, round(2.5 * cells) + 1)
    outer = 2.5 + 3.5 * np.linspace(0, 1, cells + 1)[1:] ** 1.5
    r = np.concatenate([inner, outer * EXTENT / outer[-1]])
    mesh = fem.mesh.Rectangle(a=(0.0, 0.0), b=(1.0, 1.0), n=(cells + 1, len(r)))
    order = np.round(mesh.points[:, 1] * (len(r) - 1)).astype(int)
    points = np.column_stack([mesh.points[:, 0], r[order]])
    mesh.update(points=np.vstack([points, [1.0 + RADIUS + 1e-9, 0.0]]))
    ball = mesh.npoints - 1
    field = fem.FieldContainer([fem.FieldAxisymmetric(fem.RegionQuad(mesh), dim=2)])
    mu, lame = E / 2 / (1 + nu), E * nu / (1 + nu) / (1 - 2 * nu)
    layer = fem.SolidBody(fem.NeoHookeCompressible(mu=mu, lmbda=lame), field)
    top = np.flatnonzero((points[:, 0] == 1.0) & (points[:, 1] < 4.0))
    contact = Ball(field, points=top, centerpoint=ball, items=[layer], multiplier=100.0)
    base, axis = np.zeros(mesh.npoints, bool), np.zeros(mesh.npoints, bool)
    base[:ball], axis[:ball] = points[:, 0] == 0.0, points[:, 1] == 0.0
    last = np.arange(mesh.npoints) == ball
    held = {
        "base": fem.Boundary(field[0], mask=base),
        "axis": fem.Boundary(field[0], mask=axis & ~base, skip=(1, 0)),
        "ball": fem.Boundary(field[0], mask=last, skip=(1, 0)),
        "pressed": fem.Boundary(field[0], mask=last, skip=(0, 1)),
    }
    way = -np.linspace(0, DEPTHS[-1], STEPS * len(DEPTHS) + 1)
    step = fem.Step(items=[layer, contact], ramp={held["pressed"]: way}, boundaries=held)
    job = fem.CharacteristicCurve(steps=[step], boundary=held["pressed"])
    job.evaluate(verbose=0, tol=1e-6, solver=spsolve)
    forces = np.abs(np.array(job.y)[STEPS::STEPS, 0])
    gaps = contact._kinematics(contact._gap_vectors())[0]
    return {
        "dofs": 2 * ball,
        "seconds": time.process_time() - began,
        "mesh_seconds": 0.0,
        "depths": DEPTHS,
        "forces": forces.tolist(),
        "penetration": float(-gaps.min()),
        "errors": {},
    }


if __name__ == "__main__":
    adapter({"method": "felupe, penalty", "kind": "solid", "version": fem.__version__}, SETTINGS, solved, "cartilage")
