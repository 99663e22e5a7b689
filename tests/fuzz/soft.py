"""Bodies with a law of finite strain: pressed by a quarter of their height by rigid, linear and soft bodies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from frame import Frame
from judging import Answer
from scenes import answer, block, random_shape

import fecontact as fc


def _law(rng: np.random.Generator, frame: Frame) -> Any:
    E, nu = frame.modulus * float(10 ** rng.uniform(-0.3, 0.3)), float(rng.choice([0.0, 0.3, 0.45, 0.499]))
    mu, bulk = E / 2 / (1 + nu), E / 3 / (1 - 2 * nu)
    laws = (
        lambda: fc.NeoHookean(E, nu, 1.0),
        lambda: fc.MooneyRivlin(0.4 * mu, 0.1 * mu, bulk, 1.0),
        lambda: fc.Ogden((0.7 * mu, 0.3 * mu), (2.0, -2.0), bulk, 1.0),
        lambda: fc.HolmesMow(E, min(nu, 0.3), 1.0, beta=0.3),
    )
    return laws[rng.choice(4, p=(0.4, 0.2, 0.2, 0.2))]()


def _soft(rng: np.random.Generator, frame: Frame, side: str, held: str, name: str) -> tuple[Any, np.ndarray]:
    """A block of few cells, some with a bulge on the side that touches."""
    size, divisions = 10 ** rng.uniform(-0.2, 0.2, 3), [int(n) for n in rng.integers(1, 4, 3)]
    mesh = block(size, divisions, str(rng.choice(["hex8", "hex20", "hex27", "tet"], p=(0.5, 0.2, 0.15, 0.15))))
    bulge = float(rng.choice([0.0, 0.3])) * (1 if side == "bottom" else -1)
    mesh = mesh.mapped(
        lambda x: x + bulge * ((x[:, :2] / size[:2] - 0.5) ** 2).sum(axis=1)[:, None] * size[2] * [0, 0, 1.0]
    )
    return fc.ElasticBody(frame.mesh(mesh), _law(rng, frame), side, {held: "xyz"}, name=name, geometry="plain"), size


def soft_pressed(number: int, frame: Frame) -> Callable[[], Answer]:
    """A soft block below a rigid shape, a plate, a stiffer or a soft block, with friction or without."""
    rng = np.random.default_rng([19, number + 1])
    body, size = _soft(rng, frame, "top", "bottom", "soft")
    body = frame.placed(body)
    kind, mu = str(rng.choice(["shape", "plate", "linear", "soft"])), float(rng.choice([0.0, 0.0, 0.3]))
    middle = (*(size[:2] * rng.uniform(0.3, 0.7, 2)), size[2])
    if kind == "shape":
        other = frame.rigid(random_shape(rng, frame.length), middle, name="shape")
    elif kind == "plate":
        other = frame.rigid(fc.Plane(), middle, np.diag([1.0, -1.0, -1.0]), "plate")
    elif kind == "linear":
        wide = rng.uniform(0.6, 1.5, 2) * size[:2]
        mesh = block((*wide, 0.5), [int(n) for n in rng.integers(1, 4, 3)], "hex8")
        steel = fc.Material(frame.modulus * float(10 ** rng.uniform(0.5, 2)), 0.3, 1.0)
        other = fc.ElasticBody(frame.mesh(mesh), steel, "bottom", {"top": "xyz"}, name="linear")
        other = frame.placed(other, (*((size[:2] - wide) / 2 + 0.05 * rng.normal(size=2)), size[2]))
    else:
        other, wide = _soft(rng, frame, "bottom", "top", "upper")
        other = frame.placed(other, (*((size - wide)[:2] / 2 + 0.05 * rng.normal(size=2)), size[2]))
    scene = fc.Scene(
        [body, other],
        [
            frame.contact(body, other, friction=mu)
            if kind in ("shape", "plate")
            else fc.Contact(body, other, friction=mu)
        ],
    )
    depth = float(rng.uniform(0.01, 0.25)) * size[2] * frame.deeper
    down = dict(zip("xyz", frame.vector((0, 0, -depth), frame.length), strict=True))
    weight = frame.vector((0, 0, -0.01), frame.force / frame.length**3) if rng.random() < 0.2 else None
    return lambda: answer(scene.solve(motions={other: down}, gravity=weight), frame, 1e-6)
