"""Contacts with a known answer on meshes that do not know it: where estimates of the error are held against the truth.

A case is a result, the true pressure as a function of the contact's points, and the size of the mesh it was solved on.
Meshes are as people bring them: grids whose faces do not meet the edge of the contact, gmsh's tetrahedra, its
subdivided hexahedra with straight maps, ring meshes with the ring in the wrong place.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

import fecontact as fc
from fecontact import Mesh
from fecontact.analytic import axisymmetric, hertz, layer
from fecontact.bodies import AxisymmetricBody, PlaneBody
from fecontact.mesh import pick, section_shapes
from fecontact.surfaces import Cylinder, Paraboloid

sys.path.insert(0, str(Path(__file__).parents[1] / "verification"))
from references import layer_on_rigid_plane, pin_in_hole

RADIUS, CONTACT, SIZE = 10.0, 0.5, 10.0
SOFT = fc.Material(E=1.0, nu=0.3)
MODULUS = SOFT.plane_strain_modulus
FORCE = 4 * MODULUS * CONTACT**3 / (3 * RADIUS)
HELD = {"base": "xyz", "sx": "x", "sy": "y"}
HALF_TURN = fc.rotation_about((1, 0, 0), math.pi)
Case = tuple[fc.ContactResult, Callable[[np.ndarray], np.ndarray]]


def positions(first: float, core: float = 0.65, size: float = SIZE) -> np.ndarray:
    """From 0 to `size`: cells of one size up to `core`, then growing."""
    x, step = [0.0], first
    while x[-1] < size:
        x.append(x[-1] + step)
        step *= 1.6 if x[-1] >= core else 1.0
    return np.array([*(v for v in x[:-1] if v < size - 0.4 * step), size])


def named(mesh: Mesh, **names: str) -> Mesh:
    """The mesh with boundaries by other names."""
    return Mesh(mesh.points, mesh.cells, {name: mesh.faces(old) for name, old in names.items()})


def grid(first: float, element: str = "hex20") -> Mesh:
    """A quarter of a block above z = 0."""
    x, z = positions(first), positions(first, 0.3)
    mesh = fc.shapes.block((SIZE,) * 3, (x, x, z), element=element)
    return named(mesh, cap="bottom", base="top", sx="x_min", sy="y_min")


def raised(mesh: Mesh, height: Callable[[np.ndarray], np.ndarray]) -> Mesh:
    """The mesh with its lower side raised to a height by the distance from the axis, fading upwards."""

    def shape(x: np.ndarray) -> np.ndarray:
        rise = height(np.hypot(x[:, 0], x[:, 1])) * (1 - x[:, 2] / SIZE)
        return x + np.outer(rise, [0.0, 0.0, 1.0])

    return mesh.mapped(shape)


def parabola(r: np.ndarray) -> np.ndarray:
    """Height of a ball, straight on from r = 2."""
    return np.where(r < 2, r * r, 4 + 4 * (r - 2)) / (2 * RADIUS)


def ring(level: int, shift: float = 1.1) -> Mesh:
    """A quarter of a ball whose ring is a tenth too wide."""
    mesh = fc.shapes.quarter_sphere(RADIUS, contact_radius=shift * CONTACT, level=level)
    return named(mesh, cap="cap", base="base", sx="sym_x", sy="sym_y")


@lru_cache
def cut_by_gmsh(element: str, shape: str, first: float) -> Mesh:
    """A quarter of a ball or of a block, cut by gmsh."""
    if shape == "ball":
        text = f"Sphere(1) = {{0, 0, {RADIUS}, {RADIUS}}}; Box(2) = {{0, 0, 0, {RADIUS}, {RADIUS}, {RADIUS}}};"
        text += "BooleanIntersection{ Volume{1}; Delete; }{ Volume{2}; Delete; }"
    else:
        text = f"Box(1) = {{0, 0, 0, {SIZE}, {SIZE}, {SIZE}}};"
    x, y = (c.ravel() for c in np.meshgrid(*[np.linspace(0, 1.3 * CONTACT, 8)] * 2))
    inside = np.hypot(x, y) <= 1.31 * CONTACT
    height = (x**2 + y**2) / (2 * RADIUS) if shape == "ball" else 0 * x
    near = np.stack([x, y, height], axis=1)[inside]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "part.geo"
        path.write_text(f'SetFactory("OpenCASCADE");\n{text}\n')
        mesh = fc.mesh_solid(path, size=2.5, element=element, near=near, near_size=first, growth=0.45, run_script=True)
    end = pick.flood((0.15, 0.15, 0.0)) & pick.box((-1e-6,) * 3, (RADIUS / 2, RADIUS / 2, RADIUS / 5))
    mesh = mesh.with_boundary("cap", end if shape == "ball" else pick.plane((0, 0, 0), (0, 0, 1)))
    for name, axis in (("sx", (1, 0, 0)), ("sy", (0, 1, 0))):
        mesh = mesh.with_boundary(name, pick.plane((0, 0, 0), axis))
    return mesh.with_boundary("base", pick.plane((0, 0, RADIUS), (0, 0, 1)))


def pressed(mesh: Mesh, shape: object, force: float, kind: type = fc.ElasticBody) -> fc.ContactResult:
    """A rigid shape from below."""
    body = kind(mesh, SOFT, "cap", HELD, name="body")
    rigid = fc.RigidBody(shape, name="rigid")
    if not isinstance(shape, fc.Plane):
        rigid = rigid.placed(rotation=HALF_TURN)
    return fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(forces={body: (0, 0, -force / 4)})


def round_pressure(modulus: float, radius: float = RADIUS, force: float = FORCE) -> Callable[[np.ndarray], np.ndarray]:
    """Hertz's pressure between surfaces of revolution."""
    exact = hertz.spheres((radius, math.inf), (fc.Material(E=modulus, nu=0.0), None), force=force)
    return lambda x: exact.pressure(np.hypot(x[:, 0], x[:, 1]))


def on_rigid(mesh: Mesh, shape: object, kind: type = fc.ElasticBody) -> Case:
    """Hertz, one side rigid."""
    return pressed(mesh, shape, FORCE, kind), round_pressure(MODULUS)


def two_bodies(upper: Mesh, lower: Mesh) -> Case:
    """Hertz, two elastic blocks, the lower one raised; mortar coupling."""
    modulus = MODULUS / 2
    force = 4 * modulus * CONTACT**3 / (3 * RADIUS)
    one = fc.ElasticBody(upper, SOFT, "cap", HELD, name="upper")
    other = fc.ElasticBody(raised(lower, parabola), SOFT, "cap", HELD, name="lower")
    other = other.placed(rotation=fc.rotation_about((1, 1, 0), math.pi))
    result = fc.Scene([one, other], [fc.Contact(one, other)]).solve(forces={one: (0, 0, -force / 4)})
    return result, round_pressure(modulus, force=force)


def ellipse(first: float) -> Case:
    exact = hertz.ellipse(((40.0, RADIUS), (math.inf, math.inf)), (None, SOFT), force=FORCE)
    return pressed(grid(first), Paraboloid(40.0, RADIUS), FORCE), lambda x: exact.pressure(x[:, 0], x[:, 1])


def rounded_punch(first: float, flat: float = 0.3) -> Case:
    """A flat end with a rounded edge."""
    exact = axisymmetric.indent(
        modulus=MODULUS, slope=lambda r: np.maximum(r - flat, 0) / RADIUS, breaks=(flat,), a=CONTACT
    )
    r = np.concatenate([np.linspace(0, flat, 80), np.linspace(flat, CONTACT * (1 - 1e-9), 200)[1:]])
    over_root = exact.pressure(r) / np.sqrt(1 - (r / CONTACT) ** 2)

    def pressure(x: np.ndarray) -> np.ndarray:
        at = np.hypot(x[:, 0], x[:, 1])
        return np.sqrt(np.maximum(1 - (at / CONTACT) ** 2, 0)) * np.interp(at, r, over_root)

    mesh = raised(grid(first), lambda at: parabola(np.maximum(at - flat, 0)))
    return pressed(mesh, fc.Plane(), exact.force), pressure


def cylinder(first: float, element: str = "quad8") -> Case:
    """A rigid cylinder on a half-plane by its section."""
    far = 160 * CONTACT
    exact = hertz.line((RADIUS, math.inf), (None, SOFT), force=math.pi * MODULUS * CONTACT**2 / (4 * RADIUS))
    x, z = positions(first, size=far), positions(first, 0.3, far)
    mesh = section_shapes.rectangle((far, far), (x, z), names=("sx", "side", "cap", "base"), element=element)
    body = PlaneBody(mesh, SOFT, "cap", {"base": "z", "sx": "x"}, name="body")
    rigid = fc.RigidBody(Cylinder(RADIUS), name="rigid").placed(rotation=HALF_TURN)
    result = fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(forces={rigid: (0, 0, exact.force / 2)})
    return result, lambda x: exact.pressure(np.abs(x[:, 0]))


def revolved(level: int) -> Case:
    """A ball by its half-section, its ring a tenth too wide."""
    mesh = section_shapes.half_disc(RADIUS, contact_radius=1.1 * CONTACT, level=level)
    body, plane = AxisymmetricBody(mesh, SOFT, "cap", {"base": "xz"}), fc.RigidBody(fc.Plane())
    result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(forces={body: (0, 0, -FORCE)})
    return result, round_pressure(MODULUS)


def bonded_layer(first: float, thickness: float = 0.5) -> Case:
    """A thin layer on a rigid base, axisymmetric."""
    x, n = positions(first, 1.3 * CONTACT, 4.0), max(3, math.ceil(thickness / first))
    mesh = section_shapes.rectangle(
        (4.0, thickness), (x, np.linspace(0, thickness, n + 1)), names=("sx", "side", "cap", "base")
    )
    body = AxisymmetricBody(mesh, SOFT, "cap", {"base": "xz"})
    rigid = fc.RigidBody(Paraboloid(RADIUS)).placed(rotation=HALF_TURN)
    exact = layer.paraboloid(radius=RADIUS, thickness=thickness, material=SOFT, a=CONTACT)
    result = fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(forces={rigid: (0, 0, exact.force)})
    return result, lambda x: exact.pressure(np.hypot(x[:, 0], x[:, 1]))


def receding(n: int, strip: float = 0.25, load: float = 1.0) -> Case:
    """A layer on a rigid plane, pressed on a strip; n faces from the middle to 1.25 of its thickness."""
    mat = fc.Material(E=1 - 0.3**2, nu=0.3)
    x = [*np.linspace(0, 1.25, n + 1), 1.4, 1.7, 2.1, 2.7, 3.5, 5.0]
    mesh = fc.shapes.block((5.0, 0.2, 1.0), (x, 1, max(2, n // 3)))
    mesh = mesh.with_boundary("strip", lambda p: (p[:, 2] > 1 - 1e-9) & (p[:, 0] < strip + 1e-9))
    body = fc.ElasticBody(mesh, mat, "bottom", {"x_min": "x", "y_min": "y", "y_max": "y"}, name="layer")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(pressures={(body, "strip"): load / strip / 2})
    at, exact = layer_on_rigid_plane(1.0, 1.0, strip, load, n=200)
    return result, lambda p: np.interp(p[:, 0], at, exact, right=0.0)


def pin(n: int, clearance: float = 0.01, approach: float = 0.02) -> Case:
    """A pin in a hole of nearly its size, n faces round a half."""
    steel = fc.Material(E=210e3, nu=0.3)

    def fewer(values: list[float]) -> np.ndarray:
        k = max(2, round((len(values) - 1) * n / 24)) + 1
        return np.interp(np.linspace(0, len(values) - 1, k), np.arange(len(values)), values)

    inner = fewer([0, 2.0, 3.5, 4.5, 5.2, 5.7, 6 - clearance])
    outer = fewer([0, 0.3, 0.8, 1.5, 2.5, 4, 6.5, 10, 14, 20])
    hub = fc.shapes.thick_ring(4.0, 10.0 - clearance, 1.0, (n, inner, 1), sector="half")
    tyre = fc.shapes.thick_ring(10.0, 30.0, 1.0, (n, outer, 1), sector="half")
    plane = {"bottom": "z", "top": "z", "sym_y": "y"}
    body = fc.ElasticBody(hub, steel, "outer", {**plane, "inner": "xyz"}, name="pin")
    plate = fc.ElasticBody(tyre, steel, "inner", {**plane, "outer": "xyz"}, name="plate")
    scene = fc.Scene([body, plate], [fc.Contact(body, plate)])
    result = scene.solve(motions={body: {"x": approach}}, finite_motion=False)
    angle, exact = pin_in_hole(10.0, clearance, approach, (4.0, steel), (30.0, steel), n=200)
    return result, lambda x: np.interp(np.arctan2(np.abs(x[:, 1]), x[:, 0]), angle, exact)


#: Family: sizes of the mesh, and what solves one.
FAMILIES: dict[str, tuple[tuple, Callable[..., Case]]] = {
    "rigid ball, hex20 grid": ((0.29, 0.17, 0.1), lambda h: on_rigid(grid(h), Paraboloid(RADIUS))),
    "rigid ball, hex8 grid": ((0.29, 0.17, 0.1), lambda h: on_rigid(grid(h, "hex8"), Paraboloid(RADIUS))),
    "rigid ball, hex27 grid": ((0.29, 0.17, 0.1), lambda h: on_rigid(grid(h, "hex27"), Paraboloid(RADIUS))),
    "rigid plane, raised hex20 grid": (
        (0.29, 0.17, 0.1),
        lambda h: on_rigid(raised(grid(h), parabola), fc.Plane()),
    ),
    "rigid ball, gmsh tet10": (
        (0.3, 0.2, 0.12),
        lambda h: on_rigid(cut_by_gmsh("tet10", "block", h), Paraboloid(RADIUS)),
    ),
    "rigid ball, gmsh hex20": (
        (0.3, 0.2, 0.12),
        lambda h: on_rigid(cut_by_gmsh("hex20", "block", h), Paraboloid(RADIUS)),
    ),
    "gmsh tet10 ball on a plane": (
        (0.3, 0.2, 0.12),
        lambda h: on_rigid(cut_by_gmsh("tet10", "ball", h), fc.Plane()),
    ),
    "gmsh hex20 ball on a plane": (
        (0.3, 0.2, 0.12),
        lambda h: on_rigid(cut_by_gmsh("hex20", "ball", h), fc.Plane()),
    ),
    "ring mesh, ring 10 % too wide": ((1, 2, 3), lambda level: on_rigid(ring(level), fc.Plane())),
    "two bodies, grids, mortar": ((0.29, 0.17, 0.12), lambda h: two_bodies(grid(h), grid(0.84 * h))),
    "two bodies, tet10 on a grid, mortar": (
        (0.29, 0.17),
        lambda h: two_bodies(cut_by_gmsh("tet10", "block", h), grid(0.84 * h)),
    ),
    "ellipse": ((0.29, 0.17, 0.1), ellipse),
    "punch with a rounded edge": ((0.2, 0.12, 0.08), rounded_punch),
    "cylinder, section": ((0.29, 0.17, 0.1, 0.05), cylinder),
    "ball, half-section": ((1, 2, 3), revolved),
    "bonded layer, half-section": ((0.2, 0.1, 0.05), bonded_layer),
    "receding layer": ((5, 10, 15), receding),
    "pin in a hole": ((12, 18, 24), pin),
    "bricks with gradients, grid": ((0.29, 0.17), lambda h: on_rigid(grid(h), Paraboloid(RADIUS), fc.AncfBody)),
}


class Judged(NamedTuple):
    """Size of a problem, and the true and the estimated error of each of its figures."""

    n_dofs: int
    figures: dict[str, tuple[float, float]]


def judged(case: Case) -> Judged:
    """Errors of the pressure on the contact's faces (L2), of its peak and area, with their estimates."""
    result, exact = case
    return Judged(result.n_dofs, of_pressure(result.contacts[0], exact))


def of_pressure(
    contact: fc.results.ContactFields, exact: Callable[[np.ndarray], np.ndarray]
) -> dict[str, tuple[float, float]]:
    """True and estimated errors of a contact; the true peak and area from 40 x 40 samples of each face."""
    x, p, areas = contact.sampled(contact.pressure, 12)
    known, told = exact(x), contact.error_estimate
    found = {"mean": (float(np.sqrt((areas * (p - known) ** 2).sum() / (areas * known**2).sum())), told.pressure)}
    x, _, areas = contact.sampled(contact.pressure, 40)
    known = exact(x)
    scalars = {
        "peak": (contact.max_pressure / known.max(), told.peak),
        "area": (contact._whole.area / areas[known > 0].sum(), told.area),
    }
    return found | {n: (abs(r - 1), e) for n, (r, e) in scalars.items() if np.isfinite(e)}
