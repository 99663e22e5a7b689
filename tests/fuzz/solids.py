"""Solids meshed by gmsh within closed surfaces, tetrahedra and hexahedra, pressed by shapes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from frame import Frame
from judging import Answer
from scenes import answer, random_shape

import fecontact as fc

#: Solids, elements and their sizes; each is meshed once in a process, which takes a second.
MADE = (("block", "tet4", 0.7), ("cylinder", "tet10", 1.0), ("block", "tet10", 1.0))


@cache
def _meshed(k: int) -> fc.Mesh:
    """A solid of height 1 with its top and bottom named."""
    kind, element, size = MADE[k]
    if kind == "block":
        plain = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8").translated((-0.5, -0.5, 0.0))
    else:
        plain = fc.shapes.cylinder(1.0, 1.0, contact_radius=0.4, level=1, element="hex8")
        plain = plain.translated((0.0, 0.0, -float(plain.points[:, 2].min())))
    mesh = fc.mesh_solid(fc.SurfaceMesh(plain.points, plain.skin), size=size, element=element)
    for name, height in (("bottom", 0.0), ("top", 1.0)):
        mesh = mesh.with_boundary(name, lambda x, height=height: np.abs(x[:, 2] - height) < 1e-9)
    return mesh


def meshed_solid(number: int, frame: Frame) -> Callable[[], Answer]:
    """One of them, stretched along its axes, held at its bottom, a shape moved down on its top."""
    rng = np.random.default_rng([18, number])
    stretch = rng.uniform(0.6, 1.6, 3)
    mesh = frame.mesh(_meshed(number % len(MADE)).mapped(lambda x: x * stretch))
    body = fc.ElasticBody(mesh, frame.material(1.0, float(rng.choice([0.0, 0.3, 0.45]))), "top", {"bottom": "xyz"})
    body = frame.placed(body)
    shape = random_shape(rng, frame.length)
    other = frame.rigid(shape, (*(0.3 * rng.uniform(-1, 1, 2)), stretch[2]))
    mu, depth = float(rng.choice([0.0, 0.0, 0.3])), float(10 ** rng.uniform(-3, -1.5)) * frame.deeper
    scene = fc.Scene([body, other], [frame.contact(body, other, friction=mu)])
    down = dict(zip("xyz", frame.vector((0, 0, -depth), frame.length), strict=True))
    return lambda: answer(scene.solve(motions={other: down}), frame, 1e-8, "" if mu else "force 0")
