"""Pressures with their square root at the edge against closed forms: circle, ellipse, rounded punch."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import axisymmetric
from fecontact.app.studies.spheres import CASES, solve_spheres
from fecontact.common.arrays import Array
from fecontact.surfaces import Paraboloid
from fecontact.surfaces.facet_surface import Projection
from fecontact.surfaces.rigid.shapes import Indenter

SOLID = fc.Material(E=1.0, nu=0.3)
MODULUS = SOLID.plane_strain_modulus
HELD = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
#: Of a body that stands for a half-space, over the contact.
FAR = 40.0


def error(sampled, exact):
    x, p, area = sampled
    return float(np.sqrt(area @ (p - exact(x)) ** 2 / (area @ exact(x) ** 2)))


def compared(row, case, result, exact, within):
    """Rows of the nodal pressure and of the one with its root at the edge."""
    (edge,), (contact,) = result.edge_pressures, result.contacts
    assert edge.accepted, edge.note
    row(case, "nodal pressure, L2", 0.0, error(contact.sampled(contact.pressure, 12), exact), dofs=result.n_dofs)
    row(case, "pressure with root, L2", 0.0, error(edge.sampled(12), exact), within, result.n_dofs)
    return edge


@pytest.mark.by_day("1-0.0015")
@pytest.mark.parametrize(("level", "within"), [(1, 0.0015), (2, 0.0007)])
def test_two_spheres(level, within, row):
    """Two equal spheres. Source: Hertz. Half as much again as found."""
    out = solve_spheres("equal", level=level)
    hertz = CASES["equal"].hertz
    case = f"1 equal spheres, level {level}"
    edge = compared(row, case, out.solved, lambda x: hertz.pressure(np.hypot(x[:, 0], x[:, 1])), within)
    row(case, "semi-axis of the outline", hertz.a, edge.outlines[0].semi_axes[0], 3e-4)


def pressed(shape, mesh, force):
    body = fc.ElasticBody(mesh, SOLID, "cap", HELD)
    rigid = fc.RigidBody(shape).placed(rotation=fc.rotation_about((1, 0, 0), math.pi))
    return fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(forces={rigid: (0, 0, force / 4)})


def test_elliptical_contact(row):
    """A rigid paraboloid of radii 5:1, contact 2.9:1. Source: Hertz, Johnson 1985, section 4.2. Half as much again."""
    hertz = fc.hertz.ellipse(((500.0, 100.0), (math.inf, math.inf)), (None, SOLID), force=0.03)
    mesh = fc.shapes.cylinder(FAR, FAR, contact_radius=1.0, level=1, sector="quarter")
    stretched = mesh.mapped(lambda x: x * [hertz.a, hertz.b, math.sqrt(hertz.a * hertz.b)])
    result = pressed(Paraboloid(500.0, 100.0), stretched, hertz.force)
    case = "paraboloid of radii 5:1, level 1"
    edge = compared(row, case, result, lambda x: hertz.pressure(x[:, 0], x[:, 1]), 0.0045)
    for name, found, exact in zip(("long", "short"), edge.outlines[0].semi_axes, (hertz.a, hertz.b), strict=True):
        row(case, f"{name} semi-axis", exact, found, 2.5e-3)


@dataclass(frozen=True)
class Round(Indenter):
    """A rigid surface of revolution of small slope."""

    height: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    size: float = 10.0

    def heights(self, x: Array, y: Array) -> Array:
        return self.height(np.hypot(x, y))

    def project(self, points: Array) -> Projection:
        r = np.hypot(points[:, 0], points[:, 1])
        outwards = points[:, :2] / np.maximum(r, 1e-300)[:, None]
        normals = np.concatenate([self.slope(r)[:, None] * outwards, -np.ones((len(r), 1))], axis=1)
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        foot = np.concatenate([points[:, :2], self.height(r)[:, None]], axis=1)
        return Projection(foot, normals, foot[:, 2] - points[:, 2], np.zeros(len(r), bool))


@pytest.mark.by_day("fourth power-0.0-4-level0-0.0045")
@pytest.mark.parametrize(
    ("name", "flat", "power", "level", "within"),
    [
        ("fourth power", 0.0, 4, fc.shapes.LEVELS[1], 0.0045),
        ("fourth power", 0.0, 4, fc.shapes.LEVELS[2], 0.0025),
        ("flat to 0.6 a, then round", 0.6, 2, fc.shapes.LEVELS[2], 0.011),
        ("flat to 0.6 a, then round", 0.6, 2, fc.shapes.Level(6, 6, 0.03, 0.04), 0.0055),
    ],
)
def test_round_indenters_whose_pressure_is_not_that_of_hertz(name, flat, power, level, within, row):
    """Power-law and rounded flat indenters. Source: Galin-Sneddon integrals. Half as much again as found.

    The slope of the pressure of the rounded punch is logarithmic where it begins to be round.
    """
    height = lambda r: 1e-3 * np.maximum(r - flat, 0.0) ** power  # noqa: E731
    slope = lambda r: power * 1e-3 * np.maximum(r - flat, 0.0) ** (power - 1)  # noqa: E731
    exact = axisymmetric.indent(modulus=MODULUS, slope=slope, breaks=(flat,) if flat else (), a=1.0)
    mesh = fc.shapes.cylinder(FAR, FAR, contact_radius=1.0, level=level, sector="quarter")
    result = pressed(Round(height, slope), mesh, exact.force)
    r = np.linspace(0.0, 1.2, 2001)
    p = exact.pressure(r)
    case = f"indenter, {name}, {level.core} cells in the core"
    edge = compared(row, case, result, lambda x: np.interp(np.hypot(x[:, 0], x[:, 1]), r, p), within)
    row(case, "semi-axis of the outline", 1.0, edge.outlines[0].semi_axes[0], 1e-3)
