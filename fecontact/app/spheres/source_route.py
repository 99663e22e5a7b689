"""Cases of the report by its own route, timed beside the package's.

The route: plain 20-node faces with forces at their nodes; a body that floats, with its rigid motion separated by
Gram-Schmidt; the dense compliance of the candidates; Wolfe's simplex (Elangovan 1978, equations 6 to 18 and A-2 to
A-13). It is dense, hence the coarse mesh. Forces of both routes differ by rounding: up to 1e-9 on a mesh with faces of
1e-3 of the body's size and a free motion, as do the package's own routes among themselves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fecontact.app.spheres.case import CASES, Spheres
from fecontact.app.spheres.figures import moment_radius
from fecontact.app.spheres.spheres import radius_by_sections
from fecontact.bodies import ElasticBody, rotation_about
from fecontact.common.arrays import Array
from fecontact.contact.contact import Contact
from fecontact.mesh import shapes
from fecontact.mesh.shapes import Level
from fecontact.scene.scene import Scene

#: Some 2,000 degrees of freedom a sphere.
COARSE = Level(core=1, rings=2, edge=0.25, layer=0.25, growth=4.0)


@dataclass(frozen=True, eq=False)
class Run:
    """One case by one route.

    Attributes
    ----------
    n_dofs : int
        Of both spheres.
    forces : (n,) array
        Of all candidates.
    radius, approach : float
        Contact radius by the second moment of the forces; motion of the upper sphere's base.
    seconds : float
    """

    n_dofs: int
    forces: Array
    radius: float
    approach: float
    seconds: float


def press(case: Spheres, at: float, condensation: str, solver: str) -> Run:
    """Press the upper sphere, which floats, on the lower one by a traction on its base."""
    downwards = rotation_about((1.0, 1.0, 0.0), math.pi)

    def body(radius: float, name: str, base: dict[str, str]) -> ElasticBody:
        mesh = shapes.quarter_sphere(radius, contact_radius=at, level=COARSE)
        planes = {"sym_x": "x", "sym_y": "y", **base}
        return ElasticBody(
            mesh, case.material, "cap", planes, pressure="nodal", name=name, condensation=condensation, geometry="plain"
        )

    upper = body(case.radii[1], "upper", {})
    lower = body(case.radii[0], "lower", {"base": "xyz"}).placed(rotation=downwards)
    scene = Scene([upper, lower], [Contact(upper, lower, coupling="nodal")])
    result = scene.solve(forces={(upper, "base"): (0.0, 0.0, -case.force / 4)}, solver=solver)
    (found,) = result.contacts
    radius = moment_radius(found, np.hypot(found.points[:, 0], found.points[:, 1]))
    approach = abs(float(result.boundary_motion(upper, "base")[2]))
    return Run(result.n_dofs, found.forces, radius, approach, result.seconds["total"])


def route_table() -> str:
    """Table of the report's cases by both routes on the same meshes, with Hertz."""
    head = (
        f"{'case':10}{'dofs':>8}{'contacts':>10}{'a [mm]':>9}{'Hertz':>9}{'approach':>11}{'Hertz':>10}"
        f"{'forces differ':>15}{'1978, s':>10}{'ours, s':>10}"
    )
    lines = [head, "-" * len(head)]
    for name, case in CASES.items():
        at = radius_by_sections(case, case.scale_radius)
        source, ours = press(case, at, "gram-schmidt", "wolfe"), press(case, at, "auto", "auto")
        apart = np.abs(source.forces - ours.forces).max() / ours.forces.max()
        lines.append(
            f"{name:10}{source.n_dofs:>8}{(source.forces > 0).sum():>10}{10 * source.radius:>9.4f}"
            f"{10 * case.hertz.a:>9.4f}{10 * source.approach:>11.5f}{10 * case.hertz.approach:>10.5f}{apart:>15.1e}"
            f"{source.seconds:>10.2f}{ours.seconds:>10.2f}"
        )
    return "\n".join(lines)
