"""Geometry of contact faces: nodes placed on a given surface or on one fitted to the mesh; flat faces stay."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.mesh.check import least_jacobians

SOFT = fc.Material(E=1.0, nu=0.3)
RADIUS, CONTACT = 10.0, 0.5
FORCE = 4 * SOFT.plane_strain_modulus * CONTACT**3 / (3 * RADIUS) / 4
PEAK = 2 * SOFT.plane_strain_modulus * CONTACT / (np.pi * RADIUS)
#: Faces of 0.08 contact radii and wider.
LEVEL = fc.shapes.Level(core=2, rings=3, edge=0.08, layer=0.2)
HELD = {"base": "xyz", "sym_x": "x", "sym_y": "y"}


def straight():
    """A quarter of a ball of 20-node cells with straight edges, its lowest point at the origin."""
    return fc.shapes.quarter_sphere(RADIUS, contact_radius=CONTACT, level=LEVEL, element="hex8").upgraded(20)


def ball(geometry="auto", mesh=None):
    return fc.ElasticBody(straight() if mesh is None else mesh, SOFT, "cap", HELD, geometry=geometry)


def off_the_sphere(body):
    """Distance of the nodes of the contact faces from the sphere."""
    nodes = body.mesh.points[body.surface("cap").nodes]
    return np.abs(np.linalg.norm(nodes - [0, 0, RADIUS], axis=1) - RADIUS)


def pressure_error(body):
    """Relative L2 error of the pressure under a rigid plane, and that of its peak."""
    plane = fc.RigidBody(fc.Plane())
    contact = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(forces={body: (0, 0, -FORCE)}).contacts[0]
    x, p, area = contact.sampled(contact.pressure, 8)
    exact = PEAK * np.sqrt(np.maximum(1 - (np.hypot(x[:, 0], x[:, 1]) / CONTACT) ** 2, 0))
    return np.sqrt((area * (p - exact) ** 2).sum() / (area * exact**2).sum())


def test_nodes_lie_on_a_given_sphere():
    body = ball({"cap": fc.Sphere(RADIUS)})
    assert off_the_sphere(body).max() < 1e-12 * RADIUS
    assert "nodes of 'cap' moved by up to 0.28 onto the given surface" in " ".join(body.notes)


def test_nodes_lie_near_the_sphere_that_is_fitted():
    """Corners lie on it; the middles of straight sides are off by their sagitta, which the fit takes away."""
    plain = off_the_sphere(ball("plain")).max()
    assert plain > 0.05
    assert off_the_sphere(ball()).max() < 0.02 * plain
    assert "nodes of 'cap' moved by up to 0.28 onto a smooth surface" in " ".join(ball().notes)


@pytest.mark.full
def test_pressures_of_straight_cells_become_those_of_curved_ones():
    """Cells with nodes on the exact sphere are off by 1.9 %, the discretisation's own error; straight ones by 6 %."""
    plain, fitted = (pressure_error(ball(g)) for g in ("plain", "auto"))
    exact = pressure_error(ball("plain", fc.shapes.quarter_sphere(RADIUS, contact_radius=CONTACT, level=LEVEL)))
    assert plain > 3 * exact
    assert abs(fitted - exact) < 0.15 * exact


def test_linear_cells_stay_and_their_divisions_are_placed():
    """Corners lie on the sphere already; new ones, on chords as they are made, are placed and told of, once."""
    mesh = fc.shapes.quarter_sphere(RADIUS, contact_radius=CONTACT, level=LEVEL, element="hex8")
    body, plain = ball("auto", mesh), ball("plain", mesh)
    assert body.mesh.cell_type == "hex8"
    assert np.abs(body.mesh.points - plain.mesh.points).max() < 1e-12 * RADIUS
    assert not body.notes
    near = {"cap": np.arange(len(body.surface("cap").facets))}
    assert off_the_sphere(plain._divided(near)).max() > 0.01
    finer = body._divided(near)
    off = off_the_sphere(finer)
    assert off.max() < 0.02 * off_the_sphere(plain._divided(near)).max()
    assert len(finer.notes) == len(finer._divided(near).notes) == 1
    assert "moved by up to" in finer.notes[0]


def test_nodes_of_curved_cells_on_the_sphere_stay_there():
    """27-node cells: the middles of their faces lie on the sphere as well, so all nodes do, also after the fit."""
    mesh = fc.shapes.quarter_sphere(RADIUS, contact_radius=CONTACT, level=LEVEL, element="hex27")
    body = ball("auto", mesh)
    assert off_the_sphere(body).max() < 1e-12 * RADIUS
    assert not body.notes


def cylinder(n, rows):
    """A quarter of a thick cylinder of n straight-sided cells round and some rows along it."""
    ring = fc.shapes.thick_ring(1.0, 2.0, 1.0, (n, 2, rows), element="hex8").upgraded(20)
    return fc.ElasticBody(ring, SOFT, "inner", {"outer": "xyz"})


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_strips_at_a_cut_belong_to_the_cylinder(rows):
    """Flat facets along a straight sharp edge, one strip wide: a side of the polygon, no plane."""
    body = cylinder(8, rows)
    x = body.mesh.points[body.surface("inner").nodes]
    assert np.abs(np.hypot(x[:, 0], x[:, 1]) - 1).max() < 1e-12


@pytest.mark.parametrize("cone", [0.0, 0.3])
@pytest.mark.parametrize("length", [0.2, 10.0])
def test_a_single_row_of_cells_is_ruled(cone, length):
    """Two rows of nodes do not say that sides from rim to rim are straight, as those of cylinders and cones are."""
    ring = fc.shapes.thick_ring(1.0, 2.0, 1.0, (8, 2, 1), element="hex8")

    def shape(x):
        return np.column_stack([x[:, :2] * (1 + cone * x[:, 2:]), length * x[:, 2]])

    body = fc.ElasticBody(ring.mapped(shape).upgraded(20), SOFT, "inner", {"outer": "xyz"})
    x = body.mesh.points[body.surface("inner").nodes]
    assert np.abs(np.hypot(x[:, 0], x[:, 1]) - 1 - cone * x[:, 2] / length).max() < 1e-12


def wavy(n, noise):
    """A block with a wavy top whose corners are off by noise."""
    flat = fc.shapes.block((4.0, 4.0, 1.0), (n, n, 2), element="hex8")
    off = noise * np.random.default_rng(1).normal(size=len(flat.points))

    def shape(x):
        height = 0.3 * np.sin(1.3 * x[:, 0]) * np.cos(1.1 * x[:, 1] + 0.3) + off
        return x + np.outer(x[:, 2] * height, [0, 0, 1])

    return fc.ElasticBody(flat.mapped(shape).upgraded(20), SOFT, "top", {"bottom": "xyz"})


def test_faces_without_a_smooth_surface_stay_and_it_is_said():
    rough = wavy(8, 0.05)
    assert rough.geometry["top"] == "plain"
    assert "faces of 'top' are left as they were" in " ".join(rough.notes)
    assert "moved by up to" in " ".join(wavy(8, 0.0).notes)


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_a_body_of_the_mesh_of_a_body_has_the_same_nodes_and_notes(noise):
    body = wavy(8, noise)
    again = fc.ElasticBody(body.mesh, SOFT, "top", {"bottom": "xyz"})
    assert (again.mesh.points == body.mesh.points).all()
    assert again.notes == body.notes


@pytest.mark.parametrize("rounding", [0.0, 1e-13])
def test_nodes_in_the_middle_of_faces_that_no_body_placed_are_placed(rounding):
    """They lie in the middle by the others, but for rounding, and go where those go that a body makes."""
    flat = fc.shapes.block((4.0, 4.0, 1.0), (8, 8, 2), element="hex8")
    mesh = flat.mapped(lambda x: x + np.outer(x[:, 2] * np.sin(1.3 * x[:, 0]), [0, 0, 0.3])).upgraded(20)
    given = mesh.with_midface_nodes(("top",))
    given = given.mapped(lambda x: x + rounding * np.random.default_rng(2).normal(size=x.shape))
    one, other = (fc.ElasticBody(m, SOFT, "top", {"bottom": "xyz"}) for m in (mesh, given))
    assert np.abs(one.mesh.points - given.points).max() > 1e-3
    assert np.abs(one.mesh.points - other.mesh.points).max() < 1e-9


def test_cells_do_not_fold():
    """A layer far thinner than its sides are deep: their middles cannot go where the corners say, the body is sound."""
    thin = fc.shapes.thick_ring(1.0, 1.01, 1.0, (4, 1, 2), element="hex8").upgraded(20)
    body = fc.ElasticBody(thin, SOFT, "inner", {"outer": "xyz"})
    assert least_jacobians(body.mesh).min() >= 0.2
    assert "less far, lest cells fold" in " ".join(body.notes)


def test_flat_faces_stay_to_the_last_bit():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    plain, fitted = (fc.ElasticBody(mesh, SOFT, "top", {"bottom": "xyz"}, geometry=g) for g in ("plain", "auto"))
    assert (plain.mesh.points == fitted.mesh.points).all()
    assert not fitted.notes


def test_division_goes_on_with_the_same_surface():
    body = ball({"cap": fc.Sphere(RADIUS)})
    finer = body._divided({"cap": np.arange(3)})
    assert len(finer.mesh.cells) > len(body.mesh.cells)
    free = np.setdiff1d(finer.surface("cap").nodes, finer.mesh.hanging.nodes)
    off = np.abs(np.linalg.norm(finer.mesh.points[free] - [0, 0, RADIUS], axis=1) - RADIUS)
    assert off.max() < 1e-12 * RADIUS


@pytest.mark.by_day("1000.0-place1")
@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (100.0, -50.0, 30.0)])
@pytest.mark.parametrize("scale", [1.0, 1e3])
def test_place_and_size_do_not_matter(place, scale):
    moved = fc.ElasticBody(straight().scaled(scale).translated(place), SOFT, "cap", HELD, geometry="auto")
    back = (moved.mesh.points - place) / scale
    assert np.abs(back - ball().mesh.points).max() < 1e-9 * RADIUS


@pytest.mark.parametrize(
    ("geometry", "found"),
    [
        ("smooth", ("unknown-name", "geometry")),
        ({"top": "auto"}, ("no-contact-surface", "'top'")),
        ({"cap": 3.0}, ("geometry", "float")),
        ({"cap": fc.Sphere(3.0)}, ("geometry-too-far",)),
    ],
)
def test_wrong_geometry_is_refused(geometry, found):
    with refused(fc.InputError, *found):
        ball(geometry)
