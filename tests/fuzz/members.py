"""Slender members that touch: cables and beams across each other, bars on plates, plates on balls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from frame import Frame
from judging import Answer

import fecontact as fc
from fecontact.ancf import Assembly, Joints, Stage, equilibrium
from fecontact.ancf.slender import beam, line, plate, straight


def members_touching(number: int, frame: Frame) -> Callable[[], Answer]:
    """One is let down on the other, which is held by its ends, its edge, or is a ball."""
    rng = np.random.default_rng([15, number])
    makers = (_crossed, _bar_on_plate, _plate_on_ball)
    structures, held, contacts, motion = makers[number % 3](rng, frame)
    joints = Joints(structures)
    rows = [getattr(joints, kind)(*given) for kind, *given in held]
    a = Assembly(structures, rows, contacts)
    given = joints.motion(rows, [frame.vector(m, frame.length) if m is not None else None for m in motion])

    def run() -> Answer:
        path = equilibrium(lambda level: Stage(a, motion=level * given), steps=2)
        if not path.success:
            raise fc.SolverError(f"stopped: {path.message}")
        last = path.last
        forces = [float(np.linalg.norm(f.sum(axis=0))) / frame.force for f in last.forces]
        if not any(forces) and "overlap" not in str(path):
            raise AssertionError("nothing touches, and nobody says so")
        out = {f"force {k}": value for k, value in enumerate(forces)}
        out["energy"] = last.energy / frame.force / frame.length
        return Answer(out, (str(path), repr(last)), last.residuals.penetration, 1e-6, "force 0")

    return run


Scene = tuple[list[Any], list[Any], list[Any], list[Any]]


def _points(points: np.ndarray, frame: Frame) -> np.ndarray:
    return np.array([frame.vector(p, frame.length) for p in points])


def _crossed(rng: np.random.Generator, frame: Frame) -> Scene:
    """Cables or beams across each other at any angle, the upper one's ends moved down."""
    r, angle, n = 0.02, float(rng.uniform(0.6, 2.5)), [int(k) for k in rng.integers(2, 7, 2)]
    way, at = np.array([np.cos(angle), np.sin(angle), 0.0]), rng.uniform(-0.15, 0.15, 2)
    axes = [
        straight((-0.5 + at[0], 0, 2 * r), (0.5 + at[0], 0, 2 * r), n[0]),
        straight(way * (at[1] - 0.6), way * (at[1] + 0.6), n[1]),
    ]
    square, up = float(rng.uniform(0.01, 0.03)) * frame.length, frame.vector((0, 0, 1))
    soft = frame.material(1e3, 0.0)
    made = [
        beam(_points(p, frame), soft, width=square, height=square, up=up)
        if rng.random() < 0.5
        else line(_points(p, frame), EA=100 * frame.force, EI=2.5e-3 * frame.force * frame.length**2)
        for p in axes
    ]
    ends: list[Any] = [("pinned", (k, end)) for k in (0, 1) for end in (0, -1)]
    # a beam does not twist at its first end
    twists: list[Any] = [("guided", (k, 0), 2, [up]) for k in (0, 1) if len(made[k].vectors[0]) == 4]
    down = (0.0, 0.0, -float(10 ** rng.uniform(-3.5, -1.3)) * frame.deeper)
    mu = float(rng.choice([0.0, 0.0, 0.3]))
    contact = fc.Contact(made[0].side(r * frame.length), made[1].side(r * frame.length), friction=mu)
    return made, ends + twists, [contact], [down, down, None, None] + [None] * len(twists)


def _bar_on_plate(rng: np.random.Generator, frame: Frame) -> Scene:
    """A bar across a cantilever plate, its ends moved down."""
    thick, width, a = 0.04, float(rng.uniform(0.3, 0.8)), float(rng.uniform(0.5, 0.95))
    corners = _points(np.array([(0, 0, 0), (1, 0, 0), (0, width, 0)]), frame)
    n = [int(rng.integers(2, 5)), int(rng.integers(1, 3))]
    sheet = plate(list(corners), (n[0], n[1]), frame.material(1e3, float(rng.choice([0.0, 0.3]))), thick * frame.length)
    high = thick / 2 + 0.02
    ends = np.array(straight((a, -0.1, high), (a, width + 0.1, high), int(rng.integers(3, 6))))
    bar = line(_points(ends, frame), EA=1e3 * frame.force, EI=frame.force * frame.length**2)
    x = (sheet.vectors[:, 0] / frame.length @ frame.turn)[:, 0]
    edge = np.flatnonzero(np.abs(x) < 1e-9)
    down = (0.0, 0.0, -float(10 ** rng.uniform(-3.5, -1.5)) * frame.deeper)
    offsets = (0.02 * frame.length, thick / 2 * frame.length)
    contact = fc.Contact(bar.side(offsets[0]), sheet.side(offsets[1]), friction=float(rng.choice([0.0, 0.3])))
    held: list[Any] = [("clamped", (1, k)) for k in edge] + [("pinned", (0, 0)), ("pinned", (0, -1))]
    return [bar, sheet], held, [contact], [None] * len(edge) + [down, down]


def _plate_on_ball(rng: np.random.Generator, frame: Frame) -> Scene:
    """A plate whose edges are moved down on a ball below it."""
    thick, n = 0.05, [int(k) for k in rng.integers(3, 6, 2)]
    corners = _points(np.array([(-1, -1, 0), (1, -1, 0), (-1, 1, 0)]), frame)
    sheet = plate(list(corners), (n[0], n[1]), frame.material(1e3, float(rng.choice([0.0, 0.3]))), thick * frame.length)
    x, y, _ = (sheet.vectors[:, 0] / frame.length @ frame.turn).T
    rim = np.flatnonzero((np.abs(np.abs(x) - 1) < 1e-9) | (np.abs(np.abs(y) - 1) < 1e-9))
    radius = float(10 ** rng.uniform(-0.3, 1.0))
    turned = fc.rotation_about((1, 0, 0), np.pi)
    at = (*(0.2 * rng.normal(size=2)), -thick / 2)
    ball = frame.rigid(fc.Sphere(radius * frame.length), at, turned, "ball")
    down = (0.0, 0.0, -float(10 ** rng.uniform(-3, -1.3)) * frame.deeper)
    contact = fc.Contact(sheet.side(thick / 2 * frame.length), ball, friction=float(rng.choice([0.0, 0.0, 0.3])))
    return [sheet], [("pinned", (0, k)) for k in rim], [contact], [down] * len(rim)
