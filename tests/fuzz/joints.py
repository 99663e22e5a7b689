"""Joints: cartilage extruded from bones, in poses of a path, between three bodies, and held by ligaments."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from frame import Frame
from judging import Answer
from scenes import answer
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact import SurfaceMesh


def _bone(size: Any, n: int, radii: Any, upwards: bool) -> SurfaceMesh:
    """A patch of n by n facets round the origin, as a paraboloid of two radii bulging to where it looks."""
    grid = fc.shapes.block((*size, 1.0), (n, n, 1), element="hex8").translated((-size[0] / 2, -size[1] / 2, 0.0))
    flat = SurfaceMesh.of(grid, "bottom").flipped() if upwards else SurfaceMesh.of(grid, "bottom")
    sign = -0.5 if upwards else 0.5
    return flat.mapped(lambda x: x + sign * np.outer(x[:, 0] ** 2 / radii[0] + x[:, 1] ** 2 / radii[1], (0, 0, 1)))


def _bones(rng: np.random.Generator) -> tuple[SurfaceMesh, SurfaceMesh, float, list[tuple[float, float]]]:
    """The moving and the fixed bone, the thickness of their layers, and both materials."""
    n = [int(k) for k in rng.choice([2, 2, 3], 2)]
    femoral = _bone((1.0, 1.0), n[0], 10 ** rng.uniform(0.2, 1.0, 2), upwards=False)
    tibial = _bone((1.4, 1.4), n[1], 10 ** rng.uniform(0.8, 1.5, 2) * rng.choice([-1, 1]), upwards=True)
    soft = [(float(10 ** rng.uniform(-0.3, 0.3)), float(rng.choice([0.0, 0.3, 0.45]))) for _ in range(2)]
    return femoral, tibial, float(rng.uniform(0.1, 0.3)), soft


def joint_beside_scene(number: int, frame: Frame) -> Callable[[], Answer]:
    """A path of one or two poses, beside each of them as a scene; pressed in by its pose, or by a force."""
    rng = np.random.default_rng([13, number])
    femoral, tibial, thick, soft = _bones(rng)
    n, loaded = int(rng.integers(1, 3)), bool(rng.random() < 0.3)
    tilt, shift = 0.05 * rng.normal(size=(n, 3)), 0.1 * rng.normal(size=(n, 2))
    depth, load = 0.1 * thick * rng.uniform(0.2, 1.0, n), 10 ** rng.uniform(-4, -2.5)
    high = 2 * thick - (0 if loaded else 1) * depth * frame.deeper
    poses = [
        fc.Pose(Rotation.from_rotvec(turn).as_matrix(), np.array([*side, up]) * frame.length)
        for turn, side, up in zip(tilt, shift, high, strict=True)
    ]
    materials = tuple(frame.material(*m) for m in soft)
    # a number here, a function of places there
    layers = (thick * frame.length, lambda x: np.full(len(x), thick * frame.length))
    force = (0.0, 0.0, -load * frame.force) if loaded else None
    bones = [bone.mapped(lambda x: frame.length * x) for bone in (femoral, tibial)]
    joint = fc.Joint(bones[0], bones[1], layers, materials)

    def run() -> Answer:
        table = joint.follow(poses, forces=force)
        out: dict[str, float] = {}
        beside: dict[str, float] = {}
        moving, fixed = (
            fc.ElasticBody(fc.extrude(bone, thick * frame.length), soft, "top", {"base": "xyz"}, name=name)
            for bone, soft, name in zip(bones, materials, ("moving", "fixed"), strict=True)
        )
        worst, same = 0.0, 1e-6
        for k, pose in enumerate(poses):
            body = moving.placed(pose.translation, pose.rotation)
            scene = fc.Scene([body, fixed], [fc.Contact(body, fixed)])
            result = scene.solve(forces={body: force}) if loaded else scene.solve()
            worst = max(worst, result.residuals().worst)
            if any("find no rest" in text for text in result.warnings):  # where its motions stop is up to the path
                same = np.inf
            contact = result.contacts[0]
            for name, unit, value in (
                ("force", frame.force, float(np.linalg.norm(contact.force))),
                ("max_pressure", frame.modulus, contact.max_pressure),
            ):
                column = table.column(name)[k]
                out[f"{name} {k}"] = float(np.linalg.norm(column)) / unit
                beside[f"{name} {k}"] = value / unit
        return Answer(out, (str(table), repr(table), [dict(row) for row in table]), worst, same, against=beside)

    return run


def bodies_and_ligaments(number: int, frame: Frame) -> Callable[[], Answer]:
    """Two layers, or three with a disc between them, pressed together by a force; ligaments hold what may move."""
    rng = np.random.default_rng([14, number])
    femoral, tibial, thick, soft = _bones(rng)
    three = bool(rng.random() < 0.3)
    fixed = fc.ElasticBody(
        frame.mesh(fc.extrude(tibial, thick)), frame.material(*soft[0]), "top", {"base": "xyz"}, name="fixed"
    )
    moving = fc.ElasticBody(
        frame.mesh(fc.extrude(femoral, thick)), frame.material(*soft[1]), "top", {"base": "xyz"}, name="moving"
    )
    at = np.array([*(0.05 * rng.normal(size=2)), 2 * thick])
    bodies, contacts, disc = [frame.placed(fixed)], [], None
    if three:
        plate = fc.shapes.block((1.1, 1.1, 0.15), (2, 2, 1), element="hex20").translated((-0.55, -0.55, 0.0))
        # its rim is held by the capsule
        disc = fc.ElasticBody(
            frame.mesh(plate), frame.material(2.0, 0.3), ("bottom", "top"), dict.fromkeys(["x_min", "x_max"], "xyz")
        )
        disc = frame.placed(disc, (0.0, 0.0, thick))
        at[2] += 0.15
    above = frame.placed(moving, at)
    bodies += [above] if disc is None else [disc, above]
    if disc is None:
        contacts.append(fc.Contact(above, bodies[0]))
    else:
        contacts += [fc.Contact(above, disc, ("top", "top")), fc.Contact(disc, bodies[0], ("bottom", "top"))]
    springs = []
    for k in range(4):
        angle = np.pi / 4 + k * np.pi / 2 + 0.2 * rng.normal()
        own = np.array([0.6 * np.cos(angle), 0.6 * np.sin(angle), 0.3])
        ground = own + at + [0.3 * np.cos(angle), 0.3 * np.sin(angle), -1.0 - 0.2 * rng.random()]
        stiff = float(10 ** rng.uniform(-1.5, -0.5)) * frame.modulus * frame.length
        ends = (above, frame.own(own)), (None, frame.vector(ground, frame.length))
        springs.append(fc.Spring(stiff, *ends, kind="linear" if k % 2 else "tension", name=f"ligament {k}"))
    load = float(10 ** rng.uniform(-4.5, -3))
    free = {above: str(rng.choice(["", "", "x y z", "x y z rx ry rz"]))}
    scene = fc.Scene(bodies, contacts, springs=springs)
    push = frame.vector((0.1 * load * rng.normal(), 0.0, -load), frame.force)
    return lambda: answer(scene.solve(forces={above: push}, free=free if free[above] else None), frame, 1e-6)
