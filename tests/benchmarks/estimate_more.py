"""More contacts with a known answer, added after the estimate was made; it was left as it was.

Other moduli and Poisson's ratios, meshes that are skewed, stretched or wedges, contacts off the planes of symmetry,
layers and foundations, refined meshes with hanging nodes, facetted balls, other bodies on half-spaces.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from estimate_cases import (
    CONTACT,
    HALF_TURN,
    HELD,
    MODULUS,
    RADIUS,
    SIZE,
    SOFT,
    Case,
    cut_by_gmsh,
    grid,
    named,
    on_rigid,
    parabola,
    pin,
    positions,
    raised,
    receding,
    ring,
    round_pressure,
)

import fecontact as fc
from fecontact import Mesh, SurfaceMesh, extrude
from fecontact.analytic import hertz, layer
from fecontact.mesh import pick
from fecontact.mesh.kinds import KINDS
from fecontact.mesh.refine import refined, touching
from fecontact.surfaces import Cylinder, Paraboloid


def ball(mesh: Mesh, nu: float = 0.3, radius: float = RADIUS, contact: float = CONTACT) -> Case:
    """A rigid ball under a quarter block of any Poisson's ratio."""
    material = fc.Material(E=1.0, nu=nu)
    force = 4 * material.plane_strain_modulus * contact**3 / (3 * radius)
    body = fc.ElasticBody(mesh, material, "cap", HELD)
    rigid = fc.RigidBody(Paraboloid(radius)).placed(rotation=HALF_TURN)
    result = fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(forces={body: (0, 0, -force / 4)})
    return result, round_pressure(material.plane_strain_modulus, radius, force)


def off_centre(first: float, skew: float = 0.0, at: tuple[float, float] = (0.07, 0.11)) -> Case:
    """A ball under a whole block, off the nodes, whose faces are parallelograms."""
    half = positions(first, 0.75)
    x, z = np.concatenate([-half[:0:-1], half]) + SIZE, positions(first, 0.3)
    mesh = fc.shapes.block((2 * SIZE, 2 * SIZE, SIZE), (x, x, z)).translated((-SIZE, -SIZE, 0))
    mesh = named(mesh, cap="bottom", base="top").mapped(lambda p: p + skew * p[:, [1]] * [1.0, 0.0, 0.0])
    body = fc.ElasticBody(mesh, SOFT, "cap", {"base": "xyz"})
    rigid = fc.RigidBody(Paraboloid(RADIUS)).placed((*at, 0.0), rotation=HALF_TURN)
    force = 4 * MODULUS * CONTACT**3 / (3 * RADIUS)
    scene = fc.Scene([body, rigid], [fc.Contact(body, rigid)])
    result = scene.solve(forces={rigid: (0, 0, force)})
    known = round_pressure(MODULUS, force=force)
    return result, lambda p: known(p - [*at, 0.0])


def stretched(first: float, ratio: float = 3.0) -> Mesh:
    """A quarter block with faces three times as long as wide."""
    x, y, z = positions(first), positions(first / ratio), positions(first, 0.3)
    return named(fc.shapes.block((SIZE,) * 3, (x, y, z)), cap="bottom", base="top", sx="x_min", sy="y_min")


def wedges(first: float) -> Mesh:
    """A quarter block of wedges, every square of its face cut in two."""
    x = positions(first)
    n = len(x)
    points = np.stack([*(c.ravel() for c in np.meshgrid(x, x, indexing="ij")), np.zeros(n * n)], axis=1)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    a, b, c, d = corner, corner + n, corner + n + 1, corner + 1
    halves = np.concatenate([np.stack([a, b, c, c], axis=1), np.stack([a, c, d, d], axis=1)])
    z = positions(first, 0.3) / SIZE
    mesh = extrude(SurfaceMesh(points, halves), SIZE, z, names=("cap", "base", "side"))
    mesh = mesh.with_boundary("sx", pick.plane((0, 0, 0), (1, 0, 0)))
    mesh = mesh.with_boundary("sy", pick.plane((0, 0, 0), (0, 1, 0)))
    if mesh.points[mesh.boundary_nodes("base"), 2].mean() < 0:
        mesh = mesh.mapped(lambda p: p * [1.0, 1.0, -1.0])
    return mesh


def once_divided(mesh: Mesh, within: float = 0.75 * CONTACT) -> Mesh:
    """The mesh with cells at the cap divided near the axis; the contact's edge is beyond hanging nodes."""
    faces = mesh.faces("cap")
    centres = mesh.points[mesh.face_nodes(faces)[:, :4]].mean(axis=1)
    return refined(mesh, touching(mesh, faces[np.hypot(centres[:, 0], centres[:, 1]) < within]))


def two(upper: Mesh, lower: Mesh, ratio: float, coupling: str = "auto") -> Case:
    """Two elastic blocks with moduli 1 and `ratio`, the lower one raised."""
    hard = fc.Material(E=ratio, nu=0.2)
    modulus = 1 / (1 / MODULUS + 1 / hard.plane_strain_modulus)
    force = 4 * modulus * CONTACT**3 / (3 * RADIUS)
    one = fc.ElasticBody(upper, SOFT, "cap", HELD, name="upper")
    other = fc.ElasticBody(raised(lower, parabola), hard, "cap", HELD, name="lower")
    other = other.placed(rotation=fc.rotation_about((1, 1, 0), math.pi))
    scene = fc.Scene([one, other], [fc.Contact(one, other, coupling=coupling)])
    return scene.solve(forces={one: (0, 0, -force / 4)}), round_pressure(modulus, force=force)


def pyramids(first: float) -> Mesh:
    """A quarter block of pyramids of 13 nodes, six of them from the faces of every cell of a grid to its middle."""
    blocks = grid(first, "hex8")
    n, cells = len(blocks.points), blocks.cells
    faces = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
    middle = n + np.arange(len(cells))
    corners = np.concatenate([np.column_stack([cells[:, list(face)], middle]) for face in faces])
    points = np.concatenate([blocks.points, blocks.points[cells].mean(axis=1)])
    ends = np.sort(corners[:, [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)]], axis=2)
    edges, which = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    nodes = np.concatenate([corners, len(points) + which.reshape(len(corners), 8)], axis=1)
    mesh = Mesh(np.concatenate([points, points[edges].mean(axis=1)]), nodes[:, list(KINDS["pyramid13"].embedding)])
    planes = {"cap": (0, 0, 1), "sx": (1, 0, 0), "sy": (0, 1, 0)}
    for name, normal in planes.items():
        mesh = mesh.with_boundary(name, pick.plane((0, 0, 0), normal))
    return mesh.with_boundary("base", pick.plane((0, 0, SIZE), (0, 0, 1)))


def crowned_roller(first: float, crown: float = 300.0) -> Case:
    """A rigid roller with a round profile along its axis: a contact nine times as long as wide."""
    a = 0.3
    unit = hertz.ellipse(((crown, RADIUS), (math.inf, math.inf)), (None, SOFT), force=1.0)
    exact = hertz.ellipse(((crown, RADIUS), (math.inf, math.inf)), (None, SOFT), force=(a / unit.b) ** 3)
    x, y = positions(2.5 * first, 1.3 * exact.a, 6 * exact.a), positions(first * a / CONTACT, 1.3 * a, 6 * exact.a)
    mesh = fc.shapes.block((6 * exact.a,) * 3, (x, y, positions(first * a / CONTACT, a, 6 * exact.a)))
    body = fc.ElasticBody(named(mesh, cap="bottom", base="top", sx="x_min", sy="y_min"), SOFT, "cap", HELD)
    rigid = fc.RigidBody(Paraboloid(crown, RADIUS)).placed(rotation=HALF_TURN)
    scene = fc.Scene([body, rigid], [fc.Contact(body, rigid)])
    return scene.solve(forces={body: (0, 0, -exact.force / 4)}), lambda p: exact.pressure(p[:, 0], p[:, 1])


def roller(first: float, width: float = 0.4) -> Case:
    """A rigid cylinder under a slice of a block in plane strain, in space."""
    far = 60 * CONTACT
    exact = hertz.line((RADIUS, math.inf), (None, SOFT), force=math.pi * MODULUS * CONTACT**2 / (4 * RADIUS))
    x, z = positions(first, size=far), positions(first, 0.3, far)
    mesh = fc.shapes.block((far, width, far), (x, 1, z))
    mesh = named(mesh, cap="bottom", base="top", sx="x_min", front="y_min", back="y_max")
    body = fc.ElasticBody(mesh, SOFT, "cap", {"base": "z", "sx": "x", "front": "y", "back": "y"})
    rigid = fc.RigidBody(Cylinder(RADIUS)).placed(rotation=HALF_TURN)
    result = fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(forces={rigid: (0, 0, exact.force * width / 2)})
    return result, lambda p: exact.pressure(np.abs(p[:, 0]))


def bonded(first: float, thickness: float, nu: float, element: str = "hex20") -> Case:
    """A thin layer on a rigid base, in space."""
    material, far = fc.Material(E=1.0, nu=nu), 4.0
    x, n = positions(first, 1.3 * CONTACT, far), max(2, math.ceil(thickness / first))
    mesh = fc.shapes.block((far, far, thickness), (x, x, np.linspace(0, thickness, n + 1)), element=element)
    mesh = named(mesh, cap="bottom", base="top", sx="x_min", sy="y_min")
    exact = layer.paraboloid(radius=RADIUS, thickness=thickness, material=material, a=CONTACT)
    body = fc.ElasticBody(mesh, material, "cap", HELD)
    rigid = fc.RigidBody(Paraboloid(RADIUS)).placed(rotation=HALF_TURN)
    result = fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(forces={rigid: (0, 0, exact.force / 4)})
    return result, lambda p: exact.pressure(np.hypot(p[:, 0], p[:, 1]))


def foundation(mesh: Mesh) -> Case:
    """Winkler's foundation on the faces of a mesh: p = k (a^2 - r^2) / (2 R)."""
    springs = fc.ElasticLayer(SOFT, 1.0, surface=(mesh, "cap"))
    k = springs.contact_modulus
    rigid = fc.RigidBody(Paraboloid(RADIUS)).placed(rotation=HALF_TURN)
    force = k * math.pi * CONTACT**4 / (4 * RADIUS)
    result = fc.Scene([springs, rigid], [fc.Contact(springs, rigid)]).solve(forces={rigid: (0, 0, force / 4)})
    return result, lambda p: k * np.maximum(0, CONTACT**2 - p[:, 0] ** 2 - p[:, 1] ** 2) / (2 * RADIUS)


def facetted(n: int, element: str = "hex8") -> Case:
    """A ring mesh of linear cells, its ring in the right place: chords of the ball."""
    mesh = fc.shapes.quarter_sphere(RADIUS, contact_radius=1.05 * CONTACT, level=n, element=element)
    return on_rigid(named(mesh, cap="cap", base="base", sx="sym_x", sy="sym_y"), fc.Plane())


#: Family: sizes, and what solves one.
FAMILIES: dict[str, tuple[tuple, Callable[..., Case]]] = {
    "nu = 0": ((0.29, 0.17), lambda h: ball(grid(h), 0.0)),
    "nu = 0.45": ((0.29, 0.17), lambda h: ball(grid(h), 0.45)),
    "nu = 0.499": ((0.29, 0.17), lambda h: ball(grid(h), 0.499)),
    "nu = 0.45, hex8": ((0.17, 0.1), lambda h: ball(grid(h, "hex8"), 0.45)),
    "larger ball, smaller contact": ((0.13, 0.08), lambda h: ball(grid(h), 0.2, 40.0, 0.31)),
    "off centre in a whole block": ((0.29, 0.19), off_centre),
    "skewed whole block": ((0.29, 0.19), lambda h: off_centre(h, 0.5, (0.03, -0.08))),
    "faces stretched 3:1": ((0.36, 0.24), lambda h: ball(stretched(h))),
    "wedges": ((0.29, 0.17), lambda h: ball(wedges(h))),
    "pyramids": ((0.29, 0.17), lambda h: ball(pyramids(h))),
    "crowned roller": ((0.29, 0.17, 0.1), crowned_roller),
    "divided inside, hex20": ((0.36, 0.21), lambda h: ball(once_divided(grid(h)))),
    "divided inside, tet10": ((0.3, 0.2), lambda h: ball(once_divided(cut_by_gmsh("tet10", "block", h)))),
    "divided inside, hex8": ((0.21,), lambda h: ball(once_divided(grid(h, "hex8")))),
    "two bodies, modulus 1:10": ((0.29, 0.17), lambda h: two(grid(h), grid(1.7 * h), 10.0)),
    "two bodies, modulus 1:0.2": ((0.29, 0.17), lambda h: two(grid(h), grid(0.6 * h), 0.2)),
    "two bodies, hex8 on hex20": ((0.19,), lambda h: two(grid(h, "hex8"), grid(h), 1.0)),
    "roller, in space": ((0.29, 0.17, 0.1), roller),
    "bonded layer, t = a": ((0.2, 0.13), lambda h: bonded(h, 0.5, 0.3)),
    "bonded layer, t = a / 2, nu = 0.45": ((0.2, 0.13), lambda h: bonded(h, 0.25, 0.45)),
    "bonded layer, hex8": ((0.1,), lambda h: bonded(h, 0.5, 0.3, "hex8")),
    "foundation, hex20": ((0.29, 0.17, 0.1), lambda h: foundation(grid(h))),
    "foundation, hex8": ((0.17, 0.1), lambda h: foundation(grid(h, "hex8"))),
    "foundation, tet10": ((0.3, 0.2), lambda h: foundation(cut_by_gmsh("tet10", "block", h))),
    "pin, clearance 0.001": ((12, 18), lambda n: pin(n, 0.001, 0.012)),
    "pin, clearance 0.05": ((18, 24), lambda n: pin(n, 0.05, 0.06)),
    "receding layer, strip 0.5": ((5, 10), lambda n: receding(n, 0.5)),
    "facetted ring, hex8": ((1, 2), facetted),
    "ring 30 % too wide": ((1, 2), lambda level: on_rigid(ring(level, 1.3), fc.Plane())),
}
