"""Bodies of all kinds with a known answer to another method: errors of pressures, peaks, areas, forces and approaches.

Cylinders below a rigid paraboloid, by solids of every kind of cell, by sections, bricks and a window, are compared with
a section of 96 graded cells: bodies of other dimensions, cells and couplings. Half-spaces and foundations have closed
forms. In half of the runs the motion is given and the force compared, in the others the force and the approach.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from estimate_cases import HALF_TURN, SOFT, Judged, grid, of_pressure

import fecontact as fc
from fecontact import Mesh, merge
from fecontact.analytic import axisymmetric, hertz, layer
from fecontact.bodies import AxisymmetricBody, PlaneBody
from fecontact.mesh import pick, section_shapes
from fecontact.mesh.grading import RingGrading, geometric
from fecontact.mesh.kinds import KINDS
from fecontact.mesh.shapes import disc, right_handed
from fecontact.surfaces import Cylinder, Paraboloid

UNIT = fc.Material(E=1.0, nu=0.0)
MU = 0.3


class Round(NamedTuple):
    """A cylinder, fixed at its base or its side, and a paraboloid moved into its flat end."""

    radius: float
    height: float
    paraboloid: float
    motion: float
    core: float
    fixed: str = "base"


SCENES = {
    "block": Round(1.0, 1.0, 4.0, 0.03, 0.5),
    "light load": Round(1.0, 1.0, 4.0, 0.012, 0.35),
    "plate": Round(5.0, 0.7, 20.0, 0.1, 2.0, "side"),
}


class Truth(NamedTuple):
    """Force at the given motion, largest pressure, radius of the contact, pressure and traction by the radius."""

    force: float
    peak: float
    edge: float
    pressure: Callable[[np.ndarray], np.ndarray]
    traction: Callable[[np.ndarray], np.ndarray]


def solved(scene: fc.Scene, moved: fc.RigidBody, load: tuple[str, float], upwards: bool) -> fc.ContactResult:
    """A body moved by so much ('force': that is compared) or pushed by so much ('approach')."""
    compared, size = load
    z = size if upwards else -size
    loads: dict[str, Any] = {"motions": {moved: {"z": z}}} if compared == "force" else {"forces": {moved: (0, 0, z)}}
    return scene.solve(finite_motion=False, **loads)


def touched(body: object, rigid: object, friction: float | None) -> fc.Scene:
    return fc.Scene([body, rigid], [fc.Contact(body, rigid, **({} if friction is None else {"friction": friction}))])


def section(
    name: str, kind: type, n: int, load: tuple[str, float], friction: float | None = None, element: str = "quad8"
) -> fc.ContactResult:
    """A section of n cells across, finer towards the middle of the contact."""
    of = SCENES[name]
    x, z = (
        size * np.linspace(0, 1, cells + 1) ** 1.5
        for size, cells in ((of.radius, n), (of.height, max(2, round(n * min(1, of.height / of.radius)))))
    )
    mesh = section_shapes.rectangle(
        (of.radius, of.height), (x, z), names=("sx", "side", "cap", "base"), element=element
    )
    held = {of.fixed: "xz"} | ({"sx": "x"} if kind is PlaneBody else {})
    shape = Cylinder(of.paraboloid) if kind is PlaneBody else Paraboloid(of.paraboloid)
    rigid = fc.RigidBody(shape).placed(rotation=HALF_TURN)
    return solved(touched(kind(mesh, SOFT, "cap", held), rigid, friction), rigid, load, True)


@lru_cache
def truth(name: str, kind: type = AxisymmetricBody, friction: float | None = None) -> Truth:
    """The answer of a section of 96 cells across; at its edge the squared pressure, a parabola in r^2, is zero."""
    (contact,) = section(name, kind, 96, ("force", SCENES[name].motion), friction).contacts
    r = contact.points[:, 0]
    order = np.argsort(r)
    r, p = r[order], contact.pressure[order]
    last = r[p > 0].max()
    near = (r > 0.7 * last) & (r < 0.99 * last)
    roots = np.roots(np.polyfit(r[near] ** 2, p[near] ** 2, 2)).real
    edge = math.sqrt(roots[np.argmin(np.abs(roots - last**2))])
    inside = r < 0.99 * last
    at, squares = np.append(r[inside], edge), np.append(p[inside] ** 2, 0.0)
    sideways = np.zeros(len(r))
    if contact.friction is not None:
        sideways = (np.linalg.norm(contact.friction.forces, axis=1) / contact.weights)[order]
    return Truth(
        abs(float(contact._whole.force[2])),
        float(p.max()),
        float(edge),
        lambda x: np.sqrt(np.interp(x, at, squares, right=0.0)),
        lambda x: np.interp(x, r, sideways, right=0.0),
    )


def judged(
    result: fc.ContactResult, name: str, known: Truth, load: tuple[str, float], moved: float, share: float = 1.0
) -> Judged:
    """Errors of all figures; `share` of the whole is modelled."""
    (contact,) = result.contacts
    plane = result.scene.bodies[0]._dimension == "plane"
    found = of_pressure(contact, lambda x: known.pressure(np.abs(x[:, 0]) if plane else np.hypot(x[:, 0], x[:, 1])))
    told = contact.error_estimate
    area = known.edge if plane else share * np.pi * known.edge**2
    scalars = {
        "peak": (abs(contact.max_pressure / known.peak - 1), told.peak),
        "area": (abs(contact._whole.area / area - 1), told.area),
    }
    found |= {figure: both for figure, both in scalars.items() if np.isfinite(both[1])}
    if told.traction is not None:
        x, q, areas = contact.sampled(np.linalg.norm(contact.friction.forces, axis=1) / contact.weights, 12)
        true = known.traction(np.abs(x[:, 0]) if plane else np.hypot(x[:, 0], x[:, 1]))
        found["traction"] = float(np.sqrt((areas * (q - true) ** 2).sum() / (areas * true**2).sum())), told.traction
    compared = load[0]
    estimate = getattr(result.response_error, compared)
    if estimate is not None:
        # a contact's own estimate is that at the force found
        found = {figure: (error, math.hypot(own, estimate)) for figure, (error, own) in found.items()}
        force = abs(float(contact._whole.force[2])) / share
        error = force / known.force - 1 if compared == "force" else SCENES[name].motion / moved - 1
        found[compared] = abs(error), estimate
    return Judged(result.n_dofs, found)


def of_section(
    name: str, kind: type, n: int, compared: str, friction: float | None = None, element: str = "quad8"
) -> Judged:
    known = truth(name, kind, friction)
    load = compared, SCENES[name].motion if compared == "force" else known.force
    result = section(name, kind, n, load, friction, element)
    moved = abs(result.rigid_motion(result.scene.bodies[1]).translation[2])
    return judged(result, name, known, load, moved)


@lru_cache
def cylinder(name: str, element: str, n: int) -> Mesh:
    """A quarter of a cylinder with its flat end up, n cells across the square core that holds the contact."""
    of = SCENES[name]
    first = of.core / n
    if element.startswith("tet"):
        mesh = cut(of, element, first)
    else:
        radii = of.core + geometric(first, 1.7, of.radius - of.core)[1:]
        depths = geometric(first, 1.5, of.height)
        given = element if element.startswith("hex") else "hex8"
        rings, names = RingGrading(n, of.core, radii, depths), dict.fromkeys(("top", "bottom", "side"))
        parts = disc(len(depths) - 1, rings, names, given)

        def lowered(p: np.ndarray) -> np.ndarray:
            return np.column_stack([p[:, :2], of.height - np.interp(p[:, 2], np.arange(len(depths)), depths)])

        mesh = right_handed(merge([right_handed(part.mapped(lowered)) for part in parts], 1e-9 * of.radius))
        if element.startswith("wedge"):
            halves = [mesh.cells[:, list(half)] for half in ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7))]
            mesh = Mesh(mesh.points, KINDS["wedge6"].to_hexahedra(np.concatenate(halves)))
            mesh = mesh.upgraded(20) if element == "wedge15" else mesh
    for boundary, normal in (("sx", (1, 0, 0)), ("sy", (0, 1, 0)), ("base", (0, 0, 1))):
        mesh = mesh.with_boundary(boundary, pick.plane((0, 0, 0), normal))
    mesh = mesh.with_boundary("side", lambda p: np.hypot(p[:, 0], p[:, 1]) > 0.98 * of.radius)
    return mesh.with_boundary("cap", pick.plane((0, 0, of.height), (0, 0, 1)))


def cut(of: Round, element: str, first: float) -> Mesh:
    """The quarter cut by gmsh."""
    whole = f"Cylinder(1) = {{0, 0, 0, 0, 0, {of.height}, {of.radius}}};"
    quarter = f"Box(2) = {{0, 0, 0, {of.radius}, {of.radius}, {of.height}}};"
    x, y = (c.ravel() for c in np.meshgrid(*[np.arange(0, of.core + first / 2, first)] * 2))
    inside = np.hypot(x, y) < of.core
    near = np.stack([x, y, np.full(len(x), of.height)], axis=1)[inside]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "part.geo"
        both = "BooleanIntersection{ Volume{1}; Delete; }{ Volume{2}; Delete; }"
        path.write_text(f'SetFactory("OpenCASCADE");\n{whole} {quarter} {both}\n')
        size = max(0.35 * min(of.radius, 2 * of.height), first)
        return fc.mesh_solid(path, size=size, element=element, near=near, near_size=first, growth=0.5, run_script=True)


def of_solid(
    name: str, element: str, n: int, compared: str, friction: float | None = None, kind: type = fc.ElasticBody
) -> Judged:
    """A quarter of a cylinder."""
    of, known = SCENES[name], truth(name, AxisymmetricBody, friction)
    body = kind(cylinder(name, element, n), SOFT, "cap", {of.fixed: "xyz", "sx": "x", "sy": "y"}, name="body")
    return below_paraboloid(body, name, known, compared, friction, 0.25)


def below_paraboloid(
    body: object, name: str, known: Truth, compared: str, friction: float | None, share: float
) -> Judged:
    of = SCENES[name]
    rigid = fc.RigidBody(Paraboloid(of.paraboloid)).placed((0, 0, of.height))
    load = compared, of.motion if compared == "force" else share * known.force
    result = solved(touched(body, rigid, friction), rigid, load, False)
    return judged(result, name, known, load, abs(result.rigid_motion(rigid).translation[2]), share)


def of_window(name: str, n: int, compared: str) -> Judged:
    """A local body: a window of n x n cells on a whole cylinder of coarse cells."""
    of = SCENES[name]
    quarter = cylinder(name, "hex20", 2)
    turns = [fc.rotation_about((0, 0, 1), k * math.pi / 2) for k in range(4)]
    turned = [quarter.mapped(lambda p, turn=turn: p @ turn.T) for turn in turns]
    mesh = merge(turned, 1e-9 * of.radius)
    body = fc.ElasticBody(mesh, SOFT, supports={of.fixed: "xyz"}, name="body")
    known = truth(name)
    local = fc.LocalBody(body, at=(0.0, 0.0, of.height), window=2.4 * known.edge, cells=(n, n))
    return below_paraboloid(local, name, known, compared, None, 1.0)


def on_half_space(n: int, compared: str, radii: tuple[float, float] = (10.0, 10.0), size: float = 3.1) -> Judged:
    """Hertz's contacts."""
    half = fc.HalfSpace(UNIT, size=(size, size), cells=(n, n))
    exact = hertz.ellipse((radii, (math.inf, math.inf)), (None, UNIT), force=4 / 30)
    load = {"approach": exact.approach} if compared == "force" else {"force": exact.force}
    x, y = np.meshgrid(half.grid.x, half.grid.y, indexing="ij")
    known = exact.pressure(x, y), exact.p0, math.pi * exact.a * exact.b, exact.force, exact.approach
    return of_cells(half.press(Paraboloid(*radii), **load), *known)


def of_cells(
    contact: fc.HalfSpaceContact, known: np.ndarray, peak: float, area: float, force: float, approach: float
) -> Judged:
    """Errors of a half-space's figures, the pressure in the centres of its cells."""
    told = contact.error_estimate
    found = {
        "mean": (float(np.linalg.norm(contact.pressure - known) / np.linalg.norm(known)), told.pressure),
        "peak": (abs(contact.max_pressure / peak - 1), told.peak),
        "area": (abs(contact.figures["area"] / area - 1), told.area),
        "force": (abs(contact.force / force - 1), contact.response_error.force),
        "approach": (abs(approach / contact.approach - 1), contact.response_error.approach),
    }
    return Judged(contact.grid.n_cells, {k: (e, t) for k, (e, t) in found.items() if t is not None and np.isfinite(t)})


def power(n: int, exponent: float, compared: str) -> Judged:
    """A rigid surface r^k / 100 pressed until the contact has a radius of one (Sneddon's integrals)."""
    exact = axisymmetric.indent(modulus=1.0, slope=lambda r: 0.01 * exponent * r ** (exponent - 1), a=1.0)
    half = fc.HalfSpace(UNIT, size=(3.0, 3.0), cells=(n, n))
    r = np.hypot(half.grid.x[:, None], half.grid.y[None, :])
    load = {"approach": exact.approach} if compared == "force" else {"force": exact.force}
    known = np.where(r < 1, exact.pressure(np.minimum(r, 1 - 1e-9)), 0.0)
    peak = float(exact.pressure(np.array([1e-12, *np.linspace(0.5, 0.995, 100)])).max())
    return of_cells(half.press(0.01 * r**exponent, **load), known, peak, math.pi, exact.force, exact.approach)


def on_layer(n: int, thickness: float, compared: str) -> Judged:
    """A bonded layer on a rigid base, by its integral equation."""
    exact = layer.paraboloid(radius=10.0, thickness=thickness, material=SOFT, a=1.0)
    half = fc.HalfSpace(None, size=(3.0, 3.0), cells=(n, n), layers=[fc.Layer(SOFT, thickness)])
    r = np.hypot(half.grid.x[:, None], half.grid.y[None, :])
    load = {"approach": exact.approach} if compared == "force" else {"force": exact.force}
    at = np.linspace(0, 1, 400)[:-1]
    over_root = np.interp(r, at, exact.pressure(at) / np.sqrt(1 - at**2))
    known = over_root * np.sqrt(np.maximum(0, 1 - r**2))
    peak = float(exact.pressure(np.array([1e-9]))[0])
    return of_cells(half.press(Paraboloid(10.0), **load), known, peak, math.pi, exact.force, exact.approach)


def dragged(n: int, share: float) -> Judged:
    """Two alike bodies with friction, the upper dragged by a share of what friction holds: pressures are Hertz's."""
    half = fc.HalfSpace(UNIT, size=(3.1, 3.1), cells=(n, n), against=UNIT)
    exact = hertz.spheres((10.0, math.inf), (UNIT, UNIT), force=2 / 30)
    pulled = (share * MU * exact.force, 0.0)
    contact = half.press(Paraboloid(10.0), force=exact.force, friction=MU, tangential=pulled)
    r = np.hypot(half.grid.x[:, None], half.grid.y[None, :])
    return of_cells(contact, exact.pressure(r), exact.p0, math.pi * exact.a**2, exact.force, exact.approach)


def in_a_scene(n: int, compared: str) -> Judged:
    """A half-space as a body of a scene."""
    half = fc.HalfSpace(UNIT, size=(3.1, 3.1), cells=(n, n))
    ball = fc.RigidBody(Paraboloid(10.0))
    exact = hertz.spheres((10.0, math.inf), (UNIT, None), force=4 / 30)
    load = compared, exact.approach if compared == "force" else exact.force
    result = solved(fc.Scene([half, ball], [fc.Contact(half, ball)]), ball, load, False)
    (contact,) = result.contacts
    known = exact.pressure(np.hypot(*contact.points.T[:2]))
    told, moved = contact.error_estimate, abs(result.rigid_motion(ball).translation[2])
    found = {
        "mean": (float(np.linalg.norm(contact.pressure - known) / np.linalg.norm(known)), told.pressure),
        "peak": (abs(contact.max_pressure / exact.p0 - 1), told.peak),
        "area": (abs(contact._whole.area / math.pi - 1), told.area),
        "force": (abs(contact.total_force / exact.force - 1), result.response_error.force),
        "approach": (abs(exact.approach / moved - 1), result.response_error.approach),
    }
    return Judged(half.grid.n_cells, {k: (e, t) for k, (e, t) in found.items() if t is not None})


def on_foundation(first: float, element: str, compared: str) -> Judged:
    """Winkler's foundation on the faces of a mesh: p = k (a^2 - r^2) / (2 R), P = k pi R d^2."""
    radius, depth, mesh = 10.0, 0.0125, grid(first, element)
    springs = fc.ElasticLayer(SOFT, 1.0, surface=(mesh, "cap"))
    k = springs.contact_modulus
    force, edge = k * math.pi * radius * depth**2, math.sqrt(2 * radius * depth)
    rigid = fc.RigidBody(Paraboloid(radius)).placed(rotation=HALF_TURN)
    load = compared, depth if compared == "force" else force / 4
    result = solved(fc.Scene([springs, rigid], [fc.Contact(springs, rigid)]), rigid, load, True)
    (contact,) = result.contacts
    found = of_pressure(contact, lambda p: k * np.maximum(0, edge**2 - p[:, 0] ** 2 - p[:, 1] ** 2) / (2 * radius))
    estimate = getattr(result.response_error, compared)
    if estimate is not None:
        moved = abs(result.rigid_motion(rigid).translation[2])
        error = 4 * abs(contact._whole.force[2]) / force - 1 if compared == "force" else depth / moved - 1
        found[compared] = abs(error), estimate
    return Judged(0, found)


def _solids() -> dict[str, tuple[tuple, Callable[..., Judged]]]:
    """Cylinders of every kind of cell, moved and pushed."""
    out = {}
    for name, element, moved, pushed in (
        ("block", "hex8", (4, 6), (4, 6)),
        ("block", "hex20", (3, 4, 6), (3, 4)),
        ("block", "hex27", (4,), (4,)),
        ("block", "tet4", (6,), (6,)),
        ("block", "tet10", (3, 4, 6), (3, 4)),
        ("block", "wedge6", (6,), (4,)),
        ("block", "wedge15", (3, 4), (4,)),
        ("light load", "hex20", (4, 6), (4,)),
        ("light load", "tet10", (4, 6), (4,)),
        ("plate", "hex8", (8,), (8,)),
        ("plate", "hex20", (6, 8), (6,)),
        ("plate", "tet10", (6,), (6,)),
        ("plate", "wedge15", (6,), (4,)),
    ):
        for compared, sizes in (("force", moved), ("approach", pushed)):
            out[f"{name}, {element}, {compared}"] = sizes, partial(_solid, name, element, compared)
    return out


def _solid(name: str, element: str, compared: str, n: int) -> Judged:
    return of_solid(name, element, n, compared)


#: Family: sizes, and what solves one.
FAMILIES: dict[str, tuple[tuple, Callable[..., Judged]]] = {
    **_solids(),
    "block, hex20, friction": ((4, 6), lambda n: of_solid("block", "hex20", n, "force", MU)),
    "block, hex8, friction": ((6,), lambda n: of_solid("block", "hex8", n, "approach", MU)),
    "block, tet10, friction": ((4,), lambda n: of_solid("block", "tet10", n, "force", MU)),
    "block, wedge15, friction": ((4,), lambda n: of_solid("block", "wedge15", n, "approach", MU)),
    "block, bricks with gradients": ((4, 6), lambda n: of_solid("block", "hex20", n, "force", None, fc.AncfBody)),
    "block, window of a local body": ((24, 48), lambda n: of_window("block", n, "approach")),
    "half-section, force": ((6, 8, 12), lambda n: of_section("block", AxisymmetricBody, n, "force")),
    "half-section, approach": ((6, 8, 12), lambda n: of_section("block", AxisymmetricBody, n, "approach")),
    "half-section, quad9": ((8,), lambda n: of_section("block", AxisymmetricBody, n, "force", None, "quad9")),
    "half-section, friction": ((8, 12), lambda n: of_section("block", AxisymmetricBody, n, "force", MU)),
    "half-section, plate": ((9, 12), lambda n: of_section("plate", AxisymmetricBody, n, "force")),
    "plane section, force": ((6, 8, 12), lambda n: of_section("block", PlaneBody, n, "force")),
    "plane section, approach": ((6, 8, 12), lambda n: of_section("block", PlaneBody, n, "approach")),
    "plane section, friction": ((8, 12), lambda n: of_section("block", PlaneBody, n, "force", MU)),
    "plane section, plate": ((9, 12), lambda n: of_section("plate", PlaneBody, n, "approach")),
    "half-space, ball, force": ((16, 24, 64), lambda n: on_half_space(n, "force")),
    "half-space, ball, approach": ((12, 33, 48), lambda n: on_half_space(n, "approach")),
    "half-space, ellipse, force": ((32, 64), lambda n: on_half_space(n, "force", (30.0, 6.0), 4.4)),
    "half-space, ellipse, approach": ((48,), lambda n: on_half_space(n, "approach", (30.0, 6.0), 4.4)),
    "half-space, layer, force": ((32, 64), lambda n: on_layer(n, 0.5, "force")),
    "half-space, layer, approach": ((48,), lambda n: on_layer(n, 0.5, "approach")),
    "half-space, r^1.5": ((24, 33), lambda n: power(n, 1.5, "approach")),
    "half-space, r^4": ((24, 33), lambda n: power(n, 4.0, "force")),
    "half-space, r^10": ((24, 33, 48), lambda n: power(n, 10.0, "approach")),
    "half-space, dragged with friction": ((24, 48), lambda n: dragged(n, 0.5)),
    "half-space in a scene, force": ((16, 32), lambda n: in_a_scene(n, "force")),
    "half-space in a scene, approach": ((24,), lambda n: in_a_scene(n, "approach")),
    "foundation, hex20, force": ((0.17, 0.1), lambda h: on_foundation(h, "hex20", "force")),
    "foundation, hex8, approach": ((0.17, 0.1), lambda h: on_foundation(h, "hex8", "approach")),
}
