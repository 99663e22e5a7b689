"""Plane and axisymmetric sections, pressed by rigid shapes or by each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from frame import Frame
from judging import Answer
from scenes import answer

import fecontact as fc


def section_pressed(number: int, frame: Frame) -> Callable[[], Answer]:
    """A rectangle held at its bottom and a shape or a rectangle moved down on its top, or loaded."""
    rng = np.random.default_rng([4, number])
    axisymmetric = bool(rng.random() < 0.5)
    size, divisions = 10 ** rng.uniform(-0.4, 0.4, 2), [int(n) for n in rng.integers(1, 8, 2)]
    element = str(rng.choice(["quad8", "quad9"]))
    start = 0.0 if axisymmetric else -size[0] / 2
    nu = float(rng.choice([0.0, 0.3, 0.45, 0.499]))

    def body(mesh: Any, E: float, contact: str, held: str, name: str) -> Any:
        made = replace(frame, mirrored=frame.mirrored and not axisymmetric).mesh(mesh)
        if axisymmetric:
            return fc.AxisymmetricBody(made, frame.material(E, nu), contact, {held: "xz"}, name=name)
        return fc.PlaneBody(
            made, frame.material(E, nu), contact, {held: "xz"}, name=name, thickness=frame.length,
            plane="stress" if number % 2 else "strain",
        )  # fmt: skip

    lower = body(fc.sections.rectangle(size, divisions, element=element, start=start), 1.0, "top", "bottom", "lower")
    kind = rng.random()
    if kind < 0.3:
        wide, cells = 10 ** rng.uniform(-0.4, 0.4, 2), [int(n) for n in rng.integers(1, 6, 2)]
        first = 0.0 if axisymmetric else -wide[0] * float(rng.uniform(0.2, 0.8))
        mesh = fc.sections.rectangle(wide, cells, start=first)
        other = body(mesh, float(10 ** rng.uniform(-1, 1)), "bottom", "top", "upper")
        other = other.placed((0.0, 0.0, size[1] * frame.length))
    else:
        radius = float(10 ** rng.uniform(-0.5, 1.5)) * frame.length
        x = 0.0 if axisymmetric else float(rng.uniform(-0.5, 0.5)) * size[0]
        shape: Any = fc.Sphere(radius) if axisymmetric else fc.surfaces.Cylinder(radius)
        if axisymmetric and kind < 0.5:
            shape = fc.surfaces.Cone(float(rng.uniform(0.03, 1.0)))
        other = fc.RigidBody(shape, name="rigid")
        other = other.placed((frame.vector((x, 0, 0), frame.length)[0], 0.0, size[1] * frame.length))
    scene = fc.Scene([lower, other], [fc.Contact(lower, other)])
    depth = float(10 ** rng.uniform(-4, -1.5) * size[1]) * frame.deeper
    load = float(10 ** rng.uniform(-4, -1.5)) * size[0]
    if rng.random() < 0.6:
        return lambda: answer(scene.solve(motions={other: {"z": -depth * frame.length}}), frame, 1e-8, "force 0")
    return lambda: answer(scene.solve(forces={other: (0, 0, -load * frame.force)}), frame, 1e-8)
