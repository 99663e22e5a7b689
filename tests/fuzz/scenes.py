"""Scenes of blocks of every kind of cell: pressed by a shape or a block, in stacks and rows, along paths of loads."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from frame import Frame
from judging import Answer
from scipy.spatial.transform import Rotation

import fecontact as fc

HEXAHEDRA = ("hex8", "hex20", "hex27")
KINDS = (*HEXAHEDRA, "wedge", "tet")
_OF_THE_MESH = re.compile("[Rr]efine|[Dd]ivide|resolved|accuracy=")
#: Corners of the wedges and the tetrahedra of a cell, which meet those of its neighbours.
CUTS = {
    "wedge": [[0, 1, 2, 2, 4, 5, 6, 6], [0, 2, 3, 3, 4, 6, 7, 7]],
    "tet": [[0, a, b, b, 6, 6, 6, 6] for a, b in ((1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1))],
}


def block(size: Any, divisions: Any, kind: str) -> fc.Mesh:
    """A block of one kind of cell, with its six sides named."""
    if kind in HEXAHEDRA:
        return fc.shapes.block(tuple(map(float, size)), divisions, element=kind)
    cubes = fc.shapes.block(tuple(map(float, size)), divisions, element="hex8")
    cells = cubes.cells[:, np.array(CUTS[kind])].reshape(-1, 8)
    mesh = fc.Mesh(cubes.points, cells).upgraded(20)
    for axis, names in enumerate((("x_min", "x_max"), ("y_min", "y_max"), ("bottom", "top"))):
        for name, value in zip(names, (0.0, size[axis]), strict=True):
            mesh = mesh.with_boundary(name, lambda x, axis=axis, value=value: np.abs(x[:, axis] - value) < 1e-9)
    return mesh


def random_block(rng: np.random.Generator, most: int = 5) -> tuple[fc.Mesh, np.ndarray]:
    """A block of 1 to `most` cells a side, two in five bent."""
    kind = str(rng.choice(KINDS, p=(0.25, 0.3, 0.15, 0.15, 0.15)))
    divisions = [int(n) for n in rng.integers(1, most + 1, 3)]
    size = 10 ** rng.uniform(-0.5, 0.5, 3)
    mesh = block(size, divisions, kind)
    if rng.random() < 0.4:
        bend = float(rng.uniform(0, 0.1) * size.min() / max(divisions))
        mesh = mesh.mapped(lambda x: x + bend * np.sin(3 * x[:, [1, 2, 0]] / size[[1, 2, 0]]))
    return mesh, size


def random_shape(rng: np.random.Generator, unit: float) -> Any:
    """Sphere, cylinder, cone or paraboloid, all symmetric about their own planes."""
    radius, slope = float(10 ** rng.uniform(-0.5, 1.5)) * unit, float(rng.uniform(0.03, 1.2))
    across = radius * float(rng.uniform(0.1, 10))
    makers = (
        lambda: fc.Sphere(radius),
        lambda: fc.surfaces.Cylinder(radius),
        lambda: fc.surfaces.Cone(slope),
        lambda: fc.surfaces.Paraboloid(radius, across),
    )
    return makers[rng.integers(len(makers))]()


def figures(result: Any, frame: Frame) -> dict[str, float]:
    """Force, peak and area of every contact."""
    out = {}
    for k, c in enumerate(result.contacts):
        force = np.array(c.force) / frame.force
        out[f"force {k}"] = float(np.linalg.norm(force))
        out[f"peak {k}"] = c.max_pressure / frame.modulus
        out[f"points {k}"] = c.area / frame.length**2
    return out


def answer(result: Any, frame: Frame, same: float, grows: str = "") -> Answer:
    """Everything that a result says."""
    said = (str(result), result.summary(), *(repr(c) for c in result.contacts))
    errors: dict[str, float] = {}
    for k, c in enumerate(result.contacts):
        if c.max_pressure > 0 and np.isfinite(c.error_estimate.peak):
            # a contact's own estimate is that at the force found
            errors[f"peak {k}"] = float(np.hypot(c.error_estimate.peak, result.response_error.force or 0.0))
        if c.max_pressure > 0 and result.response_error.force is not None:
            errors[f"force {k}"] = result.response_error.force
    warned = any(_OF_THE_MESH.search(text) for text in result.warnings)
    worst = result.residuals().worst
    return Answer(figures(result, frame), said, worst, same, grows, errors=errors, warned=warned)


def _solver(frame: Frame, mu: float) -> dict[str, Any]:
    return {} if mu else {"solver": frame.solver}


def block_pressed(number: int, frame: Frame) -> Callable[[], Answer]:
    """A block and a shape or a block on its top; half of them held and moved by a depth, half loaded or loose."""
    rng = np.random.default_rng([1, number])
    posed = number % 2 == 0
    mesh, size = random_block(rng)
    nu, mu = float(rng.choice([0.0, 0.3, 0.45, 0.499])), float(rng.choice([0.0, 0.0, 0.3, 0.8]))
    held = "xyz" if posed else str(rng.choice(["xyz", "z"]))
    body = fc.ElasticBody(frame.mesh(mesh), frame.material(1.0, nu), "top", {"bottom": held}, name="body")
    body = frame.placed(body)
    if rng.random() < 0.3:
        upper, width = random_block(rng)
        at = (*((size - width)[:2] / 2 + 0.1 * rng.normal(size=2) * width[:2]), size[2])
        steel = frame.material(float(10 ** rng.uniform(-1, 1)), 0.3)
        other = fc.ElasticBody(frame.mesh(upper), steel, "bottom", {"top": "xyz"}, name="other")
        other = frame.placed(other, at)
    else:
        shape, tilt = random_shape(rng, frame.length), rng.normal(size=3) * rng.choice([0, 0, 0.1, 0.3])
        at = size * [rng.uniform(0, 1), rng.uniform(0, 1), 1 + rng.choice([0, 0, 0.02])]
        other = frame.rigid(shape, at, Rotation.from_rotvec(tilt).as_matrix())
    contact = fc.Contact(body, other, friction=mu)
    if isinstance(other, fc.RigidBody):  # between two elastic bodies the sides decide where multipliers are
        contact = frame.contact(body, other, friction=mu)
    scene = fc.Scene([body, other], [contact])
    load = float(10 ** rng.uniform(-5, -1.5) * size[0] * size[1])
    depth, side = float(10 ** rng.uniform(-4, -1.5) * size[2]) * frame.deeper, float(rng.choice([0, 0, 0.1]))
    if posed or rng.random() < 0.5:
        down = frame.vector((0, 0, -depth), frame.length)
        given: dict[str, Any] = {"motions": {other: dict(zip("xyz", down, strict=True))}}
    else:
        given = {"forces": {other: frame.vector((side * load, 0, -load), frame.force)}}
    # frictionless motion along an inclined surface may end anywhere: forces alone are then compared
    return lambda: answer(
        scene.solve(**given, **_solver(frame, mu)),
        frame,
        1e-8 if posed else 1e-6,
        "force 0" if posed and not mu else "",
    )


def rows_and_stacks(number: int, frame: Frame) -> Callable[[], Answer]:
    """Two or three blocks on top of each other, pressed down from above."""
    rng = np.random.default_rng([2, number])
    mu = float(rng.choice([0.0, 0.0, 0.3]))
    level, below, bodies, contacts = 0.0, None, [], []
    n = int(rng.integers(2, 4))
    width = rng.uniform(0.6, 1.4, 2)
    for k in range(n):
        mesh, size = random_block(rng, 3)
        scale = np.array([*(width / size[:2] * rng.uniform(0.7, 1.0)), 1.0])
        mesh = mesh.mapped(lambda x, scale=scale: x * scale)
        size = size * scale
        at = (*(-size[:2] / 2 + 0.05 * rng.normal(size=2)), level)
        supports = {"bottom": "xyz"} if k == 0 else {"top": "xyz"} if k == n - 1 else {}
        material = frame.material(float(10 ** rng.uniform(-0.5, 0.5)), 0.3)
        # the middle body is held by a soft foundation of its own corners: x and y at the bottom, so that it may sink
        if not supports:
            supports = {"x_min": "x", "y_min": "y"}
        sides = ("top",) if k == 0 else ("bottom",) if k == n - 1 else ("bottom", "top")
        body = frame.placed(fc.ElasticBody(frame.mesh(mesh), material, sides, supports, name=f"block {k}"), at)
        if below is not None:
            contacts.append(fc.Contact(body, below, ("bottom", "top"), friction=mu))
        bodies.append(body)
        below, level = body, level + size[2]
    depth = float(10 ** rng.uniform(-3.5, -2) * level) * frame.deeper
    down = frame.vector((0, 0, -depth), frame.length)
    scene = fc.Scene(bodies, contacts)
    motion = {bodies[-1]: dict(zip("xyz", down, strict=True))}
    return lambda: answer(scene.solve(motions=motion), frame, 1e-6, "" if mu else "force 0")


def row_of_bodies(number: int, frame: Frame) -> Callable[[], Answer]:
    """Two to four bodies alike side by side, as copies of one, pressed down by a plate on all or a ball on each."""
    rng = np.random.default_rng([17, number])
    n, covered = int(rng.integers(2, 5)), bool(rng.random() < 0.5)
    mesh, size = random_block(rng, 2)
    mesh = mesh.mapped(lambda x: x / size)
    soft = float(10 ** rng.uniform(-0.5, 0.5)), float(rng.choice([0.0, 0.3]))
    places = 1.3 * np.arange(n)[:, None] * [1, 0, 0] + 0.1 * rng.uniform(-1, 1, (n, 3)) * [1, 1, 0]
    bodies = [
        fc.ElasticBody(frame.mesh(mesh), frame.material(*soft), "top", {"bottom": "xyz"}, name="column")
        for _ in range(n if frame.separate else 1)
    ]
    columns = [frame.placed(bodies[k % len(bodies)], at) for k, at in enumerate(places)]
    depth = float(10 ** rng.uniform(-3.5, -2)) * frame.deeper
    if covered:
        wide = block((1.3 * n, 1.4, 0.3), (int(rng.integers(n, 2 * n + 1)), 2, 1), "hex20")
        upper = fc.ElasticBody(frame.mesh(wide), frame.material(2.0, 0.3), "bottom", {"top": "xyz"}, name="plate")
        pressing = [frame.placed(upper, (-0.15, -0.2, 1.0))] * n
    else:
        radii, inside = 10 ** rng.uniform(-0.3, 1, n) * frame.length, rng.uniform(0.3, 0.7, (n, 2))
        pressing = [
            frame.rigid(fc.Sphere(float(radius)), (*(at[:2] + where), 1.0), name=f"ball {k}")
            for k, (radius, at, where) in enumerate(zip(radii, places, inside, strict=True))
        ]
    contacts = [fc.Contact(one, other) for one, other in zip(columns, pressing, strict=True)]
    scene = fc.Scene([*columns, *dict.fromkeys(pressing)], contacts)
    down = dict(zip("xyz", frame.vector((0, 0, -depth), frame.length), strict=True))
    return lambda: answer(scene.solve(motions=dict.fromkeys(pressing, down)), frame, 1e-8, "force 0")


def path_of_steps(number: int, frame: Frame) -> Callable[[], Answer]:
    """A block pressed on a rigid shape or plane with friction, then dragged to and fro in two to four steps."""
    rng = np.random.default_rng([3, number])
    mesh, size = random_block(rng, 3)
    mu, nu = float(rng.choice([0.1, 0.3, 0.8, np.inf])), float(rng.choice([0.0, 0.3, 0.45]))
    body = fc.ElasticBody(frame.mesh(mesh), frame.material(1.0, nu), "bottom", {"top": "xyz"}, name="body")
    body = frame.placed(body)
    if rng.random() < 0.5:
        other = frame.rigid(fc.Plane(), (0, 0, 0))
    else:
        at = (*(size[:2] * rng.uniform(0.2, 0.8, 2)), 0.0)
        radius = float(10 ** rng.uniform(0, 1.5)) * frame.length
        other = frame.rigid(fc.Sphere(radius), at, Rotation.from_rotvec((np.pi, 0, 0)).as_matrix())
    scene = fc.Scene([body, other], [frame.contact(body, other, friction=mu)])
    depth = float(10 ** rng.uniform(-3, -1.7) * size[2])
    steps = []
    for k in range(int(rng.integers(2, 5))):
        side = depth * rng.uniform(-1.5, 1.5, 2) * (k > 0)
        at = frame.vector((*side, -depth * rng.uniform(0.7, 1.0)), frame.length)
        steps.append({"motions": {body: dict(zip("xyz", at, strict=True))}})

    def run() -> Answer:
        if frame.resumed:
            with tempfile.TemporaryDirectory() as folder:
                rows = Path(folder) / "path.jsonl"
                scene.solve_path(steps[: frame.resumed], rows)
                path = scene.solve_path(steps, rows)
        else:
            path = scene.solve_path(steps)
        out = {}
        for k, step in enumerate(path):
            out |= {f"{name} step {k}": value for name, value in figures(step, frame).items()}
        last = path[len(path) - 1]
        said = (str(path), str(last), last.summary(), str(path.table()))
        return Answer(out, said, max(step.residuals().worst for step in path), 1e-7)

    return run
