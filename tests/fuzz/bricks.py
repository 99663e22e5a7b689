"""Gradient coordinates: brick bodies in scenes, bricks that are deformed largely, cables on rigid bodies."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from frame import Frame
from judging import Answer
from scenes import answer, random_shape

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, Joints, Stage, equilibrium
from fecontact.ancf.slender import line, straight


def brick_body(number: int, frame: Frame) -> Callable[[], Answer]:
    """A block of bricks held at its bottom, and a shape moved down on it."""
    rng = np.random.default_rng([8, number])
    size, divisions = 10 ** rng.uniform(-0.3, 0.3, 3), [int(n) for n in rng.integers(1, 4, 3)]
    mesh = frame.mesh(fc.shapes.block(tuple(map(float, size)), divisions, element="hex8"))
    body = fc.AncfBody(mesh, frame.material(1.0, float(rng.choice([0.0, 0.3, 0.45]))), "top", {"bottom": "xyz"})
    body = frame.placed(body)
    at = size * [rng.uniform(0, 1), rng.uniform(0, 1), 1.0]
    other = frame.rigid(random_shape(rng, frame.length), at)
    scene = fc.Scene([body, other], [fc.Contact(body, other)])
    depth = float(10 ** rng.uniform(-3, -1.5) * size[2]) * frame.deeper
    down = frame.vector((0, 0, -depth), frame.length)
    motion = {other: dict(zip("xyz", down, strict=True))}
    return lambda: answer(scene.solve(motions=motion), frame, 1e-8, "force 0")


def brick_indented(number: int, frame: Frame) -> Callable[[], Answer]:
    """A neo-Hookean block of one to three bricks a side under a ball moved in by up to a third of its height."""
    rng = np.random.default_rng([9, number])
    size, divisions = rng.uniform(0.7, 1.4, 3), [int(n) for n in rng.integers(1, 4, 3)]
    mesh = frame.mesh(fc.shapes.block(tuple(map(float, size)), divisions, element="hex8"))
    rest = frame.material(1.0, float(rng.choice([0.0, 0.3, 0.45])))
    solid = AncfSolid(AncfSpace(mesh), fc.NeoHookean(rest.E, rest.nu), points=3)
    at = size * [rng.uniform(0.3, 0.7), rng.uniform(0.3, 0.7), 1.0]
    ball = frame.rigid(fc.Sphere(float(rng.uniform(0.6, 4.0)) * frame.length), at, name="ball")
    depth = float(rng.uniform(0.05, 0.3)) * size[2] * frame.length * frame.deeper
    mu = float(rng.choice([0.0, 0.0, 0.3]))
    a = Assembly.of([solid], [{"bottom": "xyz"}], [fc.Contact(solid.side("top"), ball, friction=mu)])

    def run() -> Answer:
        path = equilibrium(lambda s: Stage(a.with_rigid(ball.placed((0, 0, -depth * s)))), steps=4)
        if not path.success:
            raise fc.SolverError(f"stopped: {path.message}")
        force = float(path.last.reactions @ a.translation(np.array([0.0, 0.0, 1.0]))) / frame.force
        energy = path.last.energy / frame.force / frame.length
        said = (str(path), repr(path.last))
        return Answer(
            {"force": force, "energy": energy}, said, path.last.residuals.penetration, 1e-6, "" if mu else "force"
        )

    return run


def cable_on_posts(number: int, frame: Frame) -> Callable[[], Answer]:
    """A cable over one or two cylinders below it, in a plane, with its ends moved down."""
    rng = np.random.default_rng([10, number])
    n, span, unit = int(rng.integers(8, 20)), float(rng.uniform(1.5, 3.0)), frame.length
    cable = line(
        straight((-span / 2 * unit, 0, 0), (span / 2 * unit, 0, 0), n),
        EA=100.0 * frame.force,
        EI=float(10 ** rng.uniform(-2, 0)) * frame.force * unit**2,
    )
    radius, places = float(rng.uniform(0.2, 0.5)), [0.0] if rng.random() < 0.5 else [-span / 5, span / 5]
    below = fc.rotation_about((1, 0, 0), math.pi / 2)  # along z, under y = 0
    posts = [
        fc.RigidBody(fc.surfaces.Cylinder(radius * unit), name=f"post {k}").placed((at * unit, 0, 0), below)
        for k, at in enumerate(places)
    ]
    mu, sink = float(rng.choice([0.0, 0.2])), float(rng.uniform(0.02, 0.2)) * span * unit * frame.deeper
    joints = Joints([cable])
    held = [joints.flat(), joints.pinned((0, 0), np.eye(3)[:2]), joints.pinned((0, -1), [0.0, 1.0, 0.0])]
    a = Assembly([cable], held, [fc.Contact(cable.side(), post, friction=mu) for post in posts])
    motion = joints.motion(held, [None, (0.0, -sink), (-sink,)])

    def run() -> Answer:
        path = equilibrium(lambda level: Stage(a, motion=level * motion), steps=3)
        if not path.success:
            raise fc.SolverError(f"stopped: {path.message}")
        last = path.last
        out = {f"force {k}": float(f.sum()) / frame.force for k, f in enumerate(last.forces)}
        out["energy"] = last.energy / frame.force / unit
        # one end slides: what sinks farther may wrap and pull in, and press less
        return Answer(out, (str(path), repr(last)), last.residuals.penetration, 1e-6)

    return run
