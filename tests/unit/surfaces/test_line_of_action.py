"""Lines of action between both normals: where they meet the master, continuous normals, edges, rims."""

import numpy as np
import pytest

import fecontact as fc
from fecontact import Pose
from fecontact.contact.coupling.mortar import pair_mortar
from fecontact.contact.coupling.nodal import SurfacePair, pair
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.normals import FACING, normals_of, opposing, project_along
from fecontact.surfaces.section_curve import CurveSurface

pytestmark = pytest.mark.rounding(0)

SOLID = fc.Material(E=1000.0, nu=0.3)
FLIP = fc.rotation_about((1, 1, 0), np.pi)
#: Coordinates of about one: lines and points are found to rounding.
ROUNDING = 1e-13


def dome(element="hex20", radius=5.0, **options):
    mesh = fc.shapes.quarter_sphere(radius, contact_radius=1.0, level=1, element=element)
    return fc.ElasticBody(mesh, SOLID, "cap", {"base": "xyz", "sym_x": "x", "sym_y": "y"}, **options)


def collinear(points, projection):
    """Largest distance of points from the lines of their feet."""
    return np.linalg.norm(np.cross(points - projection.points, projection.normals), axis=1).max()


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_mirror_images_press_along_the_normal_of_the_plane_between_them(element):
    surface = dome(element).surface("cap")
    p = pair(SurfacePair(surface, surface, FLIP, np.array([0.0, 0.0, -0.01]), share=0.5))
    # every node meets its image, up to where the surfaces no longer face each other
    near = np.hypot(*p.slave_points[:, :2].T) < 2.5
    assert near.mean() > 0.8
    assert np.abs(p.slave_normals - [0, 0, 1])[near].max() < ROUNDING
    assert np.abs(p.gap - (2 * p.slave_points[:, 2] + 0.01))[near].max() < ROUNDING
    assert np.abs(p.couple_residual(surface.points)).max() < ROUNDING
    # the master's normal alone leans
    q = pair(SurfacePair(surface, surface, FLIP, np.array([0.0, 0.0, -0.01])))
    assert np.abs(q.slave_normals - [0, 0, 1])[near].max() > 0.1


@pytest.mark.parametrize("share", [1e-6, 0.3, 1 - 1e-6])
@pytest.mark.parametrize("element", ["hex8", "hex20"])
def test_points_and_feet_lie_on_lines_between_both_normals(element, share):
    slave = dome(element, radius=7.0).surface("cap")
    master = dome(element).surface("cap")
    turn = FLIP @ fc.rotation_about((0, 0, 1), 0.02)
    p = pair(SurfacePair(slave, master, turn, np.array([0.3, 0.2, -0.02]), share=share))
    x = p.slave_points @ turn.T + p.translation
    near = np.linalg.norm(x[:, :2] - 0.6, axis=1) < 0.5
    assert near.sum() > 10
    assert collinear(x, p.projection) < ROUNDING
    own = opposing(slave, p.nodes) @ turn.T
    opposite = normals_of(master).at(p.projection.facet, p.projection.local)
    lines = share * own + (1 - share) * opposite
    lines /= np.linalg.norm(lines, axis=1)[:, None]
    assert np.abs(lines - p.projection.normals)[near].max() < ROUNDING
    assert np.abs(p.projection.points + p.gap[:, None] * p.projection.normals - x)[near].max() < ROUNDING


def test_without_a_share_the_nearest_points_remain():
    surface = dome().surface("cap")
    points = surface.points[surface.nodes] @ FLIP.T - [0.0, 0.0, 0.02]
    normals = opposing(surface, surface.nodes) @ FLIP.T
    assert np.array_equal(project_along(surface, points, normals, 0.0).points, surface.project(points).points)
    plane = fc.Plane()
    assert np.array_equal(project_along(plane, points, normals, 0.5).normals, plane.project(points).normals)


def grid(n, height):
    """A surface of n x n four-node facets over the unit square."""
    x, y = np.meshgrid(*[np.linspace(0, 1, n + 1)] * 2, indexing="ij")
    points = np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3)
    index = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    facets = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    return FacetSurface(points, np.stack([f.ravel() for f in facets], axis=1))


def test_lines_that_miss_the_master_leave_the_nearest_point():
    flat = grid(4, lambda x, y: 0 * x)
    leaning = np.array([[-0.6, 0.0, 0.8]])
    points = np.array([[0.9, 0.5, 0.5], [0.3, 0.5, 0.5]])
    projection = project_along(flat, points, np.repeat(leaning, 2, axis=0), 0.5)
    # the first leaves over the rim at x = 1, so it has its foot straight below; the second meets the surface aside
    assert np.abs(projection.points[0] - [0.9, 0.5, 0.0]).max() < ROUNDING
    assert np.abs(projection.normals[0] - [0, 0, 1]).max() < ROUNDING
    assert np.abs(projection.points[1] - [0.3 + 0.5 / 3, 0.5, 0.0]).max() < ROUNDING
    assert collinear(points, projection) < ROUNDING
    # beyond the rim it stays
    out = project_along(flat, np.array([[1.5, 0.5, 0.1]]), np.array([[0.0, 0.0, 1.0]]), 0.5)
    assert out.outside.all()


def test_where_surfaces_do_not_face_each_other_the_masters_normal_rules():
    flat, points = grid(4, lambda x, y: 0 * x), np.tile([0.5, 0.5, 0.01], (2, 1))
    for cosine, rules in ((FACING - 0.01, True), (FACING + 0.01, False), (-1.0, True)):
        normals = np.tile([np.sqrt(1 - cosine**2), 0.0, cosine], (2, 1))
        found = project_along(flat, points, normals, 0.5).normals
        assert (np.abs(found - [0, 0, 1]).max() < ROUNDING) == rules


def test_edges_have_no_normal_of_their_own_and_facets_beside_them_keep_theirs():
    ridge = grid(4, lambda x, y: -np.abs(x - 0.5))
    normals = normals_of(ridge)
    on_edge = ridge.points[:, 0] == 0.5
    assert np.array_equal(normals.sharp, on_edge)
    assert np.abs(opposing(ridge, np.flatnonzero(on_edge))).max() == 0
    everyone = np.arange(len(ridge.facets))
    local = np.tile([0.9, 0.4], (len(everyone), 1))
    assert np.abs(normals.at(everyone, local) - ridge.normals(everyone, local)).max() < ROUNDING
    # a slight bend is round
    bent = normals_of(grid(4, lambda x, y: -0.3 * np.abs(x - 0.5)))
    assert not bent.sharp.any()
    assert np.abs(bent.nodal[on_edge] - [0, 0, 1]).max() < ROUNDING
    # the corner of a block on a plate: with no normal of its own the plate's rules
    plate = grid(3, lambda x, y: 0 * x)
    projection = project_along(plate, np.array([[0.5, 0.5, 0.01]]), np.zeros((1, 3)), 0.5)
    assert np.abs(projection.normals - [0, 0, 1]).max() < ROUNDING


def on_the_planes(surface):
    """Components across two planes of symmetry of the normals at their nodes."""
    nodal, x = normals_of(surface).nodal[surface.nodes], surface.points[surface.nodes]
    return np.concatenate([nodal[x[:, k] < 1e-9, k] for k in range(2)])


@pytest.mark.parametrize("element", ["hex8", "hex20"])
def test_normals_lie_in_planes_of_symmetry(element):
    body = dome(element)
    assert np.abs(on_the_planes(body.surface("cap"))).max() < 1e-15
    # without them averages lean, by half of a turn between neighbours over flat facets
    bare = on_the_planes(FacetSurface(body.surface("cap").points, body.surface("cap").facets))
    assert np.abs(bare).max() > (0.02 if element == "hex8" else 1e-6)


@pytest.mark.parametrize("element", ["hex8", "hex20"])
def test_a_surface_that_meets_a_held_plane_askew_keeps_its_normal(element):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 2), element=element)
    mesh = mesh.mapped(lambda x: x + np.stack([0 * x[:, 0], 0 * x[:, 0], 0.2 * x[:, 0] * x[:, 2]], axis=1))
    body = fc.ElasticBody(mesh, SOLID, "top", {"x_min": "x", "bottom": "xyz"})
    normals = normals_of(body.surface("top")).nodal[body.surface("top").nodes]
    assert np.abs(normals - np.array([-0.2, 0, 1]) / np.hypot(0.2, 1)).max() < ROUNDING


def test_sections_have_normals_along_their_axis_on_it():
    mesh = fc.sections.half_disc(5.0, contact_radius=1.0, level=1)
    body = fc.AxisymmetricBody(mesh, SOLID, "cap", {"base": "xz"})
    surface = body.surface("cap")
    assert isinstance(surface, CurveSurface)
    nodal = normals_of(surface).nodal[: len(surface.points)]
    pole = surface.nodes[np.argmin(surface.points[surface.nodes, 0])]
    assert np.abs(nodal[pole] - [0, 0, -1]).max() < 1e-15
    exact = (surface.points - [0, 0, 5.0])[surface.nodes] / 5.0
    # quadratic sides: the cube of their share of the radius, 0.1 within the contact
    near = np.hypot(*exact[:, :2].T) < 0.2
    assert np.abs(nodal[surface.nodes] - exact)[near].max() < 1e-3
    turned = fc.rotation_about((1, 0, 0), np.pi)
    p = pair_mortar(SurfacePair(surface, surface, turned, np.array([0.0, 0.0, -0.01]), share=0.5))
    near = (p.slave_weights @ surface.points)[:, 0] < 2.5
    assert np.abs(p.slave_normals - [0, 0, 1])[near].max() < ROUNDING


@pytest.mark.parametrize("couple", [pair, pair_mortar])
@pytest.mark.parametrize("share", [0.5, 0.9])
def test_moments_balance_whatever_the_weights(couple, share):
    slave, master = dome(radius=7.0).surface("cap"), dome("hex8").surface("cap")
    p = couple(SurfacePair(slave, master, FLIP, np.array([0.1, 0.05, -0.02]), share=share))
    assert np.abs(p.couple_residual(slave.points)).max() < ROUNDING


def test_lines_turn_and_move_with_the_scene():
    slave, master = dome(radius=7.0).surface("cap"), dome("hex8").surface("cap")
    Q, t = fc.rotation_about((3, -1, 2), 1.1), np.array([1.0, -2.0, 0.5])
    here = Pose().then(FLIP, np.array([0.1, 0.05, -0.02]))
    there = FacetSurface(master.points @ Q.T + t, master.facets, planes=(master.planes[0], master.planes[1] @ Q.T))
    p = pair(SurfacePair(slave, master, here.rotation, here.translation, share=0.4))
    q = pair(SurfacePair(slave, there, Q @ here.rotation, Q @ here.translation + t, share=0.4))
    assert np.array_equal(p.nodes, q.nodes)
    assert np.abs(p.gap - q.gap).max() < 1e-12
    assert np.abs(p.slave_normals - q.slave_normals).max() < 1e-12
