"""Local bodies: a fine window on a coarse mesh, anywhere on its top."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from frame import Frame
from judging import Answer
from scenes import answer, block

import fecontact as fc


def local_body(number: int, frame: Frame) -> Callable[[], Answer]:
    """A ball on a window of a block."""
    rng = np.random.default_rng([7, number])
    size, divisions = rng.uniform(0.7, 1.5, 3) * [4, 4, 2], [int(n) for n in rng.integers(3, 6, 3)]
    mesh = frame.mesh(block(size, divisions, str(rng.choice(["hex8", "hex20"]))))
    elastic = fc.ElasticBody(mesh, frame.material(1.0, float(rng.choice([0.0, 0.3, 0.45]))), supports={"bottom": "xyz"})
    window = float(rng.uniform(0.5, 1.0))
    at = (*(size[:2] * rng.uniform(0.25, 0.75, 2)), size[2])
    # the place is one of the body's own axes, and its pose follows
    local = fc.LocalBody(
        elastic, at=tuple(frame.length * np.array(at)), window=window * frame.length, cells=(32, 32), name="local"
    )
    local = frame.placed(local)
    radius = float(10 ** rng.uniform(0.5, 1.5))
    ball = frame.rigid(fc.Sphere(radius * frame.length), at, name="ball")
    depth = (window / 2 * float(rng.uniform(0.3, 0.7))) ** 2 / radius
    load = 4 / 3 * np.sqrt(radius) * depth**1.5
    scene = fc.Scene([local, ball], [fc.Contact(local, ball)])
    return lambda: answer(scene.solve(forces={ball: frame.vector((0, 0, -load), frame.force)}), frame, 1e-6)
