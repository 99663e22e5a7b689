"""Pressure with its square root at the edge: outline, quadrature, functions, checks."""

from dataclasses import replace

import numpy as np
import pytest

import fecontact as fc
from fecontact.results.contact_outline import Mirror, Outline, ellipse_of_moments
from fecontact.results.edge_functions import edge_points
from fecontact.surfaces import Paraboloid

SOFT = fc.Material(E=1.0, nu=0.3)
HELD = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
CUT = fc.shapes.Level(core=2, rings=3, edge=0.08, layer=0.08)


def pressed(radius=100.0, a=1.0, level=CUT, sector="quarter", held=HELD, shift=(0.0, 0.0), turn=None, scale=1.0):
    """A ball on a cylinder with rings for a = 1; the load gives the contact radius `a` of Hertz."""
    mesh = fc.shapes.cylinder(10.0, 10.0, contact_radius=1.0, level=level, sector=sector).scaled(scale)
    body = fc.ElasticBody(mesh, SOFT, "cap", held)
    force = 4 * SOFT.plane_strain_modulus * a**3 / (3 * radius) * scale**2
    ball = fc.RigidBody(Paraboloid(radius * scale)).placed(
        translation=(scale * shift[0], scale * shift[1], 0.0), rotation=fc.rotation_about((1, 0, 0), np.pi)
    )
    if turn is not None:
        body, ball = body.placed(rotation=turn), ball.placed(rotation=turn)
    share = {"quarter": 4, "half": 2, "full": 1}[sector]
    down = np.array([0, 0, force / share]) if turn is None else turn @ [0, 0, force / share]
    return fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(forces={ball: down})


def hertz_error(edge, shift=(0.0, 0.0), a=1.0, radius=100.0):
    x, p, area = edge.sampled(10)
    peak = 2 * SOFT.plane_strain_modulus * a / (np.pi * radius)
    exact = peak * np.sqrt(np.maximum(1 - (np.hypot(x[:, 0] - shift[0], x[:, 1] - shift[1]) / a) ** 2, 0))
    return float(np.sqrt(area @ (p - exact) ** 2 / (area @ exact**2)))


@pytest.fixture(scope="module")
def result():
    return pressed()


def test_hertz_to_three_tenths_of_a_percent_where_the_nodal_pressure_has_one_and_a_half(result):
    """Source: Hertz. 0.2 % with exact radius by the same functions, 1.5 % between the nodes."""
    (edge,) = result.edge_pressures
    nodal = replace(edge, note="to have the nodal pressure")
    assert edge.accepted
    assert hertz_error(edge) < 0.003
    assert hertz_error(nodal) > 0.012
    assert abs(edge.outlines[0].semi_axes[0] - 1) < 1e-3
    assert abs(edge.outlines[0].area / np.pi - 1) < 2e-3


def test_its_own_residuals(result):
    """Source: equilibrium and virtual work; the forces of the sampled pressure are those of the points."""
    (edge,) = result.edge_pressures
    r = edge.residuals
    assert r.equilibrium < 1e-12
    assert r.weak_gap < 1e-12
    assert r.tension == r.overlap == 0
    x, p, area = edge.sampled(24)
    contact = result.contacts[0]
    assert abs(p @ area / edge.forces.sum() - 1) < 2e-4  # midpoints across the edge
    assert abs(edge.forces.sum() / contact.forces.sum() - 1) < 1e-3  # normals of a shallow bowl
    along = (edge.forces @ contact.normals)[2]
    assert abs(along / contact.force[2] - 1) < 1e-12
    assert abs((p * area) @ x[:, 0] / (edge.forces @ contact.points[:, 0]) - 1) < 3e-4


@pytest.mark.by_day("half-held0")
@pytest.mark.parametrize(("sector", "held"), [("half", {"base": "xyz", "sym_y": "y"}), ("full", {"base": "xyz"})])
def test_an_outline_that_cuts_facets_off_the_centre_is_found(sector, held):
    """A ball beside the middle of the rings. Source: Hertz, moved."""
    shift = (0.03, 0.0)
    (edge,) = pressed(sector=sector, held=held, shift=shift).edge_pressures
    assert edge.accepted
    assert hertz_error(edge, shift) < 0.004
    assert np.abs(edge.outlines[0].centre[:2] - shift).max() < 1e-3


def test_scale_and_place_do_not_matter(result):
    (base,) = result.edge_pressures
    turn = fc.rotation_about((1.0, 2.0, -0.5), 0.7)
    for other in (pressed(turn=turn), pressed(scale=1e-3)):
        (edge,) = other.edge_pressures
        assert edge.accepted
        p, q = base.sampled(4)[1], edge.sampled(4)[1]
        assert np.abs(p - q).max() < 1e-7 * p.max()


def test_hanging_nodes():
    """A block divided where the contact needs it. Source: Hertz on a half-space, a block of six radii: one percent."""
    mesh = fc.shapes.block((6.0, 6.0, 6.0), (6, 6, 6))
    body = fc.ElasticBody(mesh, SOFT, "top", {"bottom": "xyz", "x_min": "x", "y_min": "y"})
    ball = fc.RigidBody(fc.Sphere(100.0)).placed((0, 0, 106.0))
    force = SOFT.plane_strain_modulus / 300
    scene = fc.Scene([body, ball], [fc.Contact(body, ball)])
    found = scene.solve(forces={ball: (0, 0, -force)}, accuracy=0.05)
    assert found.solved(body).mesh.hanging is not None
    (edge,) = found.edge_pressures
    assert edge.accepted
    assert hertz_error(edge) < 0.01 < hertz_error(replace(edge, note="nodal"))


def test_what_has_no_such_edge_keeps_its_nodal_pressure():
    """A flat punch: the pressure grows towards the edge, whatever the outline."""
    mesh = fc.shapes.cylinder(10.0, 10.0, contact_radius=1.0, level=CUT, sector="quarter")
    mesh = mesh.with_boundary("tip", lambda x: (x[:, 2] < 1e-9) & (np.hypot(x[:, 0], x[:, 1]) < 1.0001))
    body = fc.ElasticBody(mesh, SOFT, "tip", HELD)
    plane = fc.RigidBody(fc.Plane())
    found = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(forces={plane: (0, 0, 0.01)})
    (edge,) = found.edge_pressures
    assert not edge.accepted
    assert edge.note.startswith("nodal pressure: ")
    contact = found.contacts[0]
    assert (edge.sampled(4)[1] == contact.sampled(contact.pressure, 4)[1]).all()


@pytest.mark.parametrize(("coupling", "words"), [("mortar", "mortar")])
def test_other_couplings_are_told(coupling, words):
    mesh = fc.shapes.quarter_sphere(10.0, contact_radius=1.0, level=CUT)
    body = fc.ElasticBody(mesh, SOFT, "cap", HELD)
    lower = body.placed(rotation=fc.rotation_about((1, 1, 0), np.pi))
    found = fc.Scene([body, lower], [fc.Contact(body, lower, coupling=coupling)]).solve(forces={body: (0, 0, -0.05)})
    assert words in found.edge_pressures[0].note


def test_no_contact_and_few_points_are_told():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    body = fc.ElasticBody(mesh, SOFT, "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    for height, words in ((0.1, "nothing touches"), (-0.01, "nodal pressure")):
        found = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": height}})
        assert words in found.edge_pressures[0].note


# outline


def circle(modes=((0, 0),), coefficients=(1.0,), axes=(2.0, 1.0)):
    return Outline(np.zeros(3), np.eye(3)[:2] / np.array(axes)[:, None], np.array(modes), np.array(coefficients))


def test_area_and_axes_of_an_ellipse_changed_by_its_terms():
    """Source: the ellipse x^2 (1 + e) + y^2 (1 - e) = 1 in scaled coordinates."""
    found = circle(((0, 0), (2, 0)), (1.0, 0.1))
    assert abs(found.area / (np.pi * 2 / np.sqrt(0.99)) - 1) < 1e-10
    assert np.allclose(found.semi_axes, (2 / np.sqrt(1.1), 1 / np.sqrt(0.9)), rtol=1e-12)


def test_planes_of_symmetry_leave_even_terms():
    x, y = Mirror(np.zeros(3), np.eye(3)[0]), Mirror(np.zeros(3), np.eye(3)[1])
    assert circle().to_degree(4, [x, y]).modes.tolist() == [[0, 0], [2, 0], [4, 0]]
    assert len(circle().to_degree(4, []).modes) == 9
    assert circle().to_degree(2, [y]).modes.tolist() == [[0, 0], [1, 0], [2, 0]]


@pytest.mark.parametrize("mirrored", [True, False])
def test_ellipse_of_the_moments_of_half_an_ellipsoid(mirrored):
    """Source: the half-ellipsoid itself, sampled; only a quarter of it where planes of symmetry give the rest."""
    t = np.linspace(-1, 1, 401)
    x, y = (v.ravel() for v in np.meshgrid(2.0 * t, t))
    force = np.sqrt(np.maximum(1 - (x / 2) ** 2 - y**2, 0))
    points, mirrors = np.stack([x + 5.0, y, 0 * x], 1), []
    if mirrored:
        mirrors = [Mirror(np.array([5.0, 0, 0]), np.eye(3)[k]) for k in (0, 1)]
        force = force * np.where(x > 0, 1.0, np.where(x < 0, 0, 0.5)) * np.where(y > 0, 1.0, np.where(y < 0, 0, 0.5))
    found = ellipse_of_moments(points, force, np.array([0, 0, 1.0]), mirrors)
    assert np.allclose(found.semi_axes, (2.0, 1.0), rtol=1e-4)
    assert np.allclose(found.centre, (5.0, 0, 0), atol=1e-12)


# quadrature

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])


@pytest.mark.parametrize(
    ("facet", "edge", "area", "root"),
    [
        ([0, 1, 2, 3], 2.0, 1.0, 2 / 3 * (2**1.5 - 1)),  # beyond the square
        ([0, 1, 2, 3], 0.4, 0.4, 2 / 3 * 0.4**1.5),
        ([0, 1, 2, 3], -0.1, 0.0, 0.0),
        ([0, 1, 2, 2], 1.0, 0.5, 4 / 15),  # triangle x > y: x sqrt(1 - x) dx
    ],
)
def test_square_root_across_a_facet(facet, edge, area, root):
    """Source: integrals of sqrt(e - x) by hand."""
    level = lambda x: edge - x[..., 0]  # noqa: E731
    found = edge_points(SQUARE, np.array([facet]), level)
    inside = np.sqrt(np.maximum(level(found.points), 0))
    assert abs(found.areas.sum() - area) < 1e-4
    assert abs((found.areas * inside).sum() - root) < 2e-5
    assert np.abs(found.shapes.sum(axis=2) - 1).max() < 1e-12


def test_inverse_square_root_on_both_sides():
    """Source: the integral of 1 / sqrt((x - 0.2) (0.9 - x)) between its ends is pi."""
    level = lambda x: (x[..., 0] - 0.2) * (0.9 - x[..., 0])  # noqa: E731
    found = edge_points(SQUARE, np.array([[0, 1, 2, 3]]), level)
    assert abs((found.areas / np.sqrt(level(found.points))).sum() / np.pi - 1) < 1e-4
