"""Finite element scenes of the problems with a rigid indenter: a body from z >= 0 downwards, fitted to the edge.

As in `fecontact.app.studies.spheres`, a first, coarse pass finds the edge; the mesh of the main pass has a ring there.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from compare.problems import Problem
from fecontact import AncfBody, Contact, ContactResult, Mesh, Scene
from fecontact.bodies import ElasticBody, ElasticLayer, Plane, PlaneBody, RigidBody, rotation_about
from fecontact.mesh import section_shapes as sections
from fecontact.mesh import shapes
from fecontact.mesh.shapes import Level
from fecontact.results.contact_fields import ContactFields
from fecontact.surfaces import Cylinder, Paraboloid

#: Size of a body that stands for a half-space, over the longer semi-axis: its base and side change the curvature of the
#: surface under the load, and with it the pressure, by the cube of the inverse.
FAR = 40.0
#: The same in plane strain, where it is the square.
FAR_PLANE = 150.0
#: Of the first pass, which finds the edge to some tenths of a percent.
FIRST_PASS = Level(core=2, rings=3, edge=0.1, layer=0.3, growth=2.0)
#: Radius of a layer that stands for an unbounded one, over that of the contact.
WIDE = 6.0

Meshes = Callable[[tuple[float, float], "int | Level", str], Mesh]


def start(problem: Problem) -> tuple[float, float]:
    """Semi-axes by dimensional analysis: p ~ E' a / R, a/b ~ (Rx/Ry)^(2/3)."""
    rx, ry = problem.data["radii"]
    modulus = problem.data["material"].plane_strain_modulus
    if math.isinf(ry):
        return math.sqrt(2 * problem.force * rx / (math.pi * modulus)), math.inf
    mean = (problem.force * math.sqrt(rx * ry) / (math.pi * modulus)) ** (1 / 3)
    skew = (rx / ry) ** (1 / 3)
    return mean * skew, mean / skew


def block_of(problem: Problem) -> Meshes:
    """How the elastic body of a problem is meshed, from the semi-axes to which it is fitted, a level and an element."""
    if problem.name == "line":
        return _slab
    if problem.name == "layer":
        thickness = problem.data["thickness"]

        def sheet(axes: tuple[float, float], level: int | Level, element: str) -> Mesh:
            a = math.sqrt(axes[0] * axes[1])
            return shapes.cylinder(
                WIDE * a, thickness, contact_radius=a, level=level, sector="quarter", element=element
            )

        return sheet
    return _half_space


def _half_space(axes: tuple[float, float], level: int | Level, element: str) -> Mesh:
    """A quarter of a cylinder with a ring at r = 1, stretched so that the ring lies on the ellipse."""
    round_mesh = shapes.cylinder(FAR, FAR, contact_radius=1.0, level=level, sector="quarter", element=element)
    scale = np.array([axes[0], axes[1], math.sqrt(axes[0] * axes[1])])
    return round_mesh.mapped(lambda x: x * scale)


def _slab(axes: tuple[float, float], level: int | Level, element: str) -> Mesh:
    """Half of a slab one element thick, with an element edge at x = a; boundaries named as those of a cylinder."""
    a, far = axes[0], FAR_PLANE * axes[0]
    cut = shapes.grading(a, far, far, level)
    across = np.concatenate([np.linspace(0.0, cut.core_radius, cut.core + 1), cut.radii])
    mesh = shapes.block((far, a, far), (across, 1, cut.depths), element=element)
    old = {"cap": "bottom", "base": "top", "sym_x": "x_min", "sym_y": "y_min", "sym_far": "y_max"}
    return Mesh(mesh.points, mesh.cells, {new: mesh.faces(name) for new, name in old.items()})


def indented(
    problem: Problem, element: str, pressure: str, level: int | Level, solver: str, backend: str
) -> tuple[ContactResult, RigidBody]:
    """Press the problem's indenter on a body of finite elements.

    Returns
    -------
    result : ContactResult
    indenter : RigidBody
    """
    make = block_of(problem)

    def press(axes: tuple[float, float], fineness: int | Level, kind: str, faces: str, by: str) -> ContactResult:
        mesh = make(axes, fineness, "hex20" if kind == "ancf" else kind)
        supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
        if problem.name == "line":
            supports |= {"base": "z", "sym_far": "y"}
        contact = "cap"
        if problem.name == "punch":
            contact = "tip"
            rim = 1.0001 * axes[0]  # a ring of the mesh lies on the punch's edge
            mesh = mesh.with_boundary("tip", lambda x: (x[:, 2] < 1e-9) & (np.hypot(x[:, 0], x[:, 1]) < rim))
        material = problem.data["material"]
        body: ElasticBody
        if kind == "ancf":
            body = AncfBody(mesh, material, contact, supports, name="body", backend=backend)
        else:
            body = ElasticBody(mesh, material, contact, supports, pressure=faces, name="body", backend=backend)
        share = problem.force / 4
        if problem.name == "line":
            share = problem.force / 2 * axes[0]
        scene = Scene([body, ball], [Contact(body, ball)])
        return scene.solve(forces={ball: (0.0, 0.0, share)}, solver=by)

    ball = _indenter(problem)
    if problem.name == "punch":
        return press(problem.semi_axes, level, element, pressure, solver), ball
    first = press(start(problem), FIRST_PASS, "hex20", "midface", "auto")
    fitted = semi_axes(problem, first.contacts[0])
    return press(fitted, level, element, pressure, solver), ball


def _indenter(problem: Problem) -> RigidBody:
    """The rigid body, which comes from z < 0."""
    if problem.name == "punch":
        return RigidBody(Plane(), name="indenter")
    rx, ry = problem.data["radii"]
    shape = Cylinder(rx) if math.isinf(ry) else Paraboloid(rx, ry)
    return RigidBody(shape, name="indenter").placed(rotation=rotation_about((1, 0, 0), math.pi))


def semi_axes(problem: Problem, contact: ContactFields) -> tuple[float, float]:
    """Edge from the second moments of the forces, taken for those of half an ellipsoid (of half an ellipse)."""
    x, y = contact.points[:, 0], contact.points[:, 1]
    f = contact.forces / contact.forces.sum()
    if problem.name == "line":
        return math.sqrt(4 * f @ x**2), math.inf
    return math.sqrt(5 * f @ x**2), math.sqrt(5 * f @ y**2)


def foundation(problem: Problem, level: int | Level) -> tuple[ContactResult, RigidBody]:
    """Press the indenter on an elastic foundation in place of the layer; the surface as the finite elements have it."""
    mesh = block_of(problem)(start(problem), level, "hex20")
    sheet = ElasticLayer(problem.data["material"], problem.data["thickness"], surface=(mesh, "cap"))
    ball = _indenter(problem)
    scene = Scene([sheet, ball], [Contact(sheet, ball)])
    return scene.solve(forces={ball: (0.0, 0.0, problem.force / 4)}), ball


def section_of_cylinder(problem: Problem, level: int | Level, solver: str, backend: str) -> ContactResult:
    """Half of an elastic cylinder on a rigid plane, in plane strain: the same relative radius and modulus."""

    def press(a: float, fineness: int | Level, by: str) -> ContactResult:
        mesh = sections.half_disc(problem.data["radii"][0], contact_radius=a, level=fineness)
        supports = {"base": "xz", "sym_x": "x"}
        half = PlaneBody(mesh, problem.data["material"], "cap", supports, name="cylinder", backend=backend)
        plane = RigidBody(Plane(), name="plane")
        return Scene([half, plane], [Contact(half, plane)]).solve(
            forces={half: (0.0, 0.0, -problem.force / 2)}, solver=by
        )

    first = press(start(problem)[0], FIRST_PASS, "auto")
    return press(semi_axes(problem, first.contacts[0])[0], level, solver)
