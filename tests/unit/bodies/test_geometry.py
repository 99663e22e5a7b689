"""Geometry of contact faces: nodes placed on a given surface or on one fitted to the mesh; flat faces stay."""

import numpy as np
import pytest

import fecontact as fc

SOFT = fc.Material(E=1.0, nu=0.3)
RADIUS, CONTACT = 10.0, 0.5
FORCE = 4 * SOFT.plane_strain_modulus * CONTACT**3 / (3 * RADIUS) / 4
PEAK = 2 * SOFT.plane_strain_modulus * CONTACT / (np.pi * RADIUS)
#: Faces of 0.08 contact radii and wider.
LEVEL = fc.shapes.Level(core=2, rings=3, edge=0.08, layer=0.2)
HELD = {"base": "xyz", "sym_x": "x", "sym_y": "y"}


def ball(geometry, element="hex8"):
    """A quarter of a ball, its lowest point at the origin."""
    mesh = fc.shapes.quarter_sphere(RADIUS, contact_radius=CONTACT, level=LEVEL, element=element)
    return fc.ElasticBody(mesh, SOFT, "cap", HELD, geometry=geometry)


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
    assert body.mesh.cell_type == "hex20"
    assert off_the_sphere(body).max() < 1e-12 * RADIUS
    assert "hex8 cells became hex20 cells" in " ".join(body.notes)


def test_nodes_lie_near_the_sphere_that_is_fitted():
    """Corners lie on it; the middles of straight sides are off by their sagitta, which the fit takes away."""
    straight = fc.ElasticBody(ball("plain").mesh.upgraded(20), SOFT, "cap", HELD)
    assert off_the_sphere(straight).max() > 0.05
    assert off_the_sphere(ball("auto")).max() < 0.02 * off_the_sphere(straight).max()


def test_pressures_of_linear_cells_become_those_of_curved_ones():
    plain, fitted = (pressure_error(ball(g)) for g in ("plain", "auto"))
    assert plain > 0.05
    assert fitted < 0.03


def test_flat_faces_stay_to_the_last_bit():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    plain, fitted = (fc.ElasticBody(mesh, SOFT, "top", {"bottom": "xyz"}, geometry=g) for g in ("plain", "auto"))
    assert (plain.mesh.points == fitted.mesh.points).all()
    assert not fitted.notes


def test_division_goes_on_with_the_same_surface():
    body = ball({"cap": fc.Sphere(RADIUS)})
    finer = body.divided({"cap": np.arange(3)})
    assert len(finer.mesh.cells) > len(body.mesh.cells)
    free = np.setdiff1d(finer.surface("cap").nodes, finer.mesh.hanging.nodes)
    off = np.abs(np.linalg.norm(finer.mesh.points[free] - [0, 0, RADIUS], axis=1) - RADIUS)
    assert off.max() < 1e-12 * RADIUS


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (100.0, -50.0, 30.0)])
@pytest.mark.parametrize("scale", [1.0, 1e3])
def test_place_and_size_do_not_matter(place, scale):
    mesh = fc.shapes.quarter_sphere(RADIUS, contact_radius=CONTACT, level=LEVEL, element="hex8")
    moved = fc.ElasticBody(mesh.scaled(scale).translated(place), SOFT, "cap", HELD, geometry="auto")
    back = (moved.mesh.points - place) / scale
    assert np.abs(back - ball("auto").mesh.points).max() < 1e-9 * RADIUS


@pytest.mark.parametrize(
    ("geometry", "found"),
    [("smooth", "geometry"), ({"top": "auto"}, "'top'"), ({"cap": 3.0}, "float"), ({"cap": fc.Sphere(3.0)}, "given")],
)
def test_wrong_geometry_is_refused(geometry, found):
    with pytest.raises(fc.InputError, match=found):
        ball(geometry)
