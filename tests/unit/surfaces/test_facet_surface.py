"""Closest-point projection on curved facets."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import MeshError
from fecontact.mesh.element import quad_nodes
from fecontact.surfaces.closest_point import FacetPolynomials
from fecontact.surfaces.facet_surface import FacetSurface

pytestmark = pytest.mark.rounding

RADIUS = 2.0


def patch(n, k, height):
    """Facets of k nodes, n x n over [-1, 1]^2, with all nodes at z = height(x, y) and normals upwards."""
    facets, points = [], []
    for i in range(n):
        for j in range(n):
            facets.append(np.arange(k) + k * len(facets))
            points.append(-1 + 2 * (np.array([i, j]) + quad_nodes(k)) / n)
    xy, number = np.unique(np.concatenate(points).round(12), axis=0, return_inverse=True)
    x = np.column_stack([xy, height(xy)])
    return FacetSurface(x, number.reshape(len(facets), k))


def ball(xy):
    return np.sqrt(RADIUS**2 - (xy**2).sum(axis=1))


def above_ball(n=200, seed=1, most=0.7):
    """Points near the ball's surface with their exact gap."""
    rng = np.random.default_rng(seed)
    xy = rng.uniform(-most, most, (n, 2))
    gap = rng.uniform(-0.2, 0.3, n)
    on = np.column_stack([xy, ball(xy)])
    return on * (1 + gap / RADIUS)[:, None], gap


@pytest.mark.parametrize("k", [4, 8, 9])
def test_a_plane_is_exact(k):
    surface = patch(3, k, lambda xy: np.zeros(len(xy)))
    rng = np.random.default_rng(2)
    points = np.column_stack([rng.uniform(-0.99, 0.99, (100, 2)), rng.uniform(-1, 1, 100)])
    projection = surface.project(points)
    assert np.abs(projection.gap - points[:, 2]).max() < 1e-14
    assert np.abs(projection.points - points * [1, 1, 0]).max() < 1e-14
    assert np.abs(projection.normals - [0, 0, 1]).max() < 1e-14
    assert not projection.outside.any()


@pytest.mark.parametrize("k", [4, 8, 9])
def test_an_inclined_plane_far_away(k):
    Q = fc.rotation_about((1, 2, 3), 0.8)
    flat = patch(3, k, lambda xy: np.zeros(len(xy)))
    surface = FacetSurface(flat.points @ Q.T + 100.0, flat.facets)
    rng = np.random.default_rng(3)
    local = np.column_stack([rng.uniform(-0.99, 0.99, (50, 2)), rng.uniform(-1, 1, 50)])
    projection = surface.project(local @ Q.T + 100.0)
    # coordinates of size 100 leave 1e-14
    assert np.abs(projection.gap - local[:, 2]).max() < 1e-12
    assert np.abs(projection.normals - Q[:, 2]).max() < 1e-12


@pytest.mark.parametrize(("k", "order"), [(4, 2), (8, 3), (9, 3)])
def test_gaps_to_a_ball_converge_with_the_degree_of_the_facets(k, order):
    points, gap = above_ball()
    errors = [np.abs(patch(n, k, ball).project(points).gap - gap).max() for n in (4, 8, 16)]
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    # between two refinements the largest error wanders by a few tenths of an order
    assert (rates > order - 0.4).all(), (errors, rates)


@pytest.mark.parametrize(("k", "order"), [(4, 1), (8, 2), (9, 2)])
def test_normals_of_a_ball_converge(k, order):
    points, _ = above_ball()
    exact = points / np.linalg.norm(points, axis=1)[:, None]
    errors = [np.abs(patch(n, k, ball).project(points).normals - exact).max() for n in (4, 8, 16)]
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (rates > order - 0.4).all(), (errors, rates)


@pytest.mark.parametrize("k", [4, 8, 9])
def test_the_foot_lies_on_the_normal_through_the_point(k):
    surface = patch(5, k, ball)
    points, _ = above_ball()
    projection = surface.project(points)
    offset = points - projection.points
    assert np.abs(np.cross(offset, projection.normals)).max() < 1e-12
    assert np.abs(offset - projection.gap[:, None] * projection.normals).max() < 1e-12
    assert np.abs(np.linalg.norm(projection.normals, axis=1) - 1).max() < 1e-14
    # inside a facet the line of action is the facet's own normal
    inside = ((projection.local > 0) & (projection.local < 1)).all(axis=1)
    assert inside.sum() > 100
    assert np.abs(surface.normals(projection.facet, projection.local) - projection.normals)[inside].max() < 1e-12


@pytest.mark.parametrize("k", [4, 8, 9])
def test_the_foot_is_the_nearest_point(k):
    surface = patch(3, k, ball)
    points, _ = above_ball(40)
    projection = surface.project(points)
    t = np.linspace(0, 1, 41)
    local = np.stack(np.meshgrid(t, t), axis=-1).reshape(-1, 2)
    n = len(surface.facets)
    cloud = surface.evaluate(np.repeat(np.arange(n), len(local)), np.tile(local, (n, 1)))[0]
    nearest = np.linalg.norm(points[:, None, :] - cloud[None], axis=2).min(axis=1)
    assert (np.abs(projection.gap) <= nearest + 1e-12).all()


def test_weights_interpolate_the_foot():
    surface = patch(4, 8, ball)
    points, _ = above_ball(30)
    projection = surface.project(points)
    assert np.abs(projection.weights @ surface.points - projection.points).max() < 1e-14
    assert np.abs(projection.weights.sum(axis=1) - 1).max() < 1e-14


@pytest.mark.parametrize("k", [4, 8, 9])
def test_nodes_of_the_surface_project_on_themselves(k):
    surface = patch(4, k, ball)
    projection = surface.project(surface.points)
    assert np.abs(projection.points - surface.points).max() < 1e-14
    assert np.abs(projection.gap).max() < 1e-14
    assert not projection.outside.any()
    # nodes on shared edges get the mean normal, so neither neighbour is preferred
    exact = surface.points / RADIUS
    inner = (np.abs(surface.points[:, :2]) < 0.99).all(axis=1)
    assert np.abs(projection.normals - exact)[inner].max() < (0.06 if k == 4 else 0.02)


def test_points_beyond_the_rim_are_flagged():
    surface = patch(3, 8, lambda xy: np.zeros(len(xy)))
    inside, on_rim, just_off, off = (0.5, 0.5, 0.1), (1.0, 0.5, 0.1), (1.0 + 1e-9, 0.5, 0.1), (1.2, 0.5, 0.1)
    corner, touching = (1.2, 1.2, 0.1), (1.1, 0.0, 0.0)
    projection = surface.project(np.array([inside, on_rim, just_off, off, corner, touching]))
    assert projection.outside.tolist() == [False, False, False, True, True, True]
    # their foot is on the rim all the same
    assert np.abs(projection.points[3:] - [(1, 0.5, 0), (1, 1, 0), (1, 0, 0)]).max() < 1e-14


def test_the_number_of_newton_runs_does_not_grow_with_the_points(monkeypatch):
    surface = patch(4, 8, ball)
    calls = []
    newton = FacetPolynomials.closest
    monkeypatch.setattr(FacetPolynomials, "closest", lambda self, *a, **k: calls.append(1) or newton(self, *a, **k))
    counts = []
    for n in (10, 1000):
        calls.clear()
        surface.project(above_ball(n)[0])
        counts.append(len(calls))
    assert counts == [1, 1]


def test_distance_to_a_given_facet():
    surface = patch(2, 4, lambda xy: np.zeros(len(xy)))
    points = np.array([[0.5, 0.5, 0.3], [-0.5, 0.5, 0.0]])
    facet = np.full(2, np.argmax((surface.points[surface.facets] >= 0)[..., :2].all(axis=(1, 2))))
    assert np.abs(surface.distance_to_facet(points, facet) - [0.3, 0.5]).max() < 1e-14


def test_on_a_very_slender_facet():
    flat = patch(2, 8, lambda xy: 0.01 * xy[:, 0] ** 2)
    surface = FacetSurface(flat.points * [1, 1e-4, 1], flat.facets)
    rng = np.random.default_rng(4)
    xy = rng.uniform(-0.9, 0.9, (30, 2)) * [1, 1e-4]
    slope = 0.02 * xy[:, 0]
    normal = np.column_stack([-slope, np.zeros(30), np.ones(30)]) / np.sqrt(1 + slope**2)[:, None]
    on = np.column_stack([xy, 0.01 * xy[:, 0] ** 2])
    projection = surface.project(on + 0.05 * normal)
    assert np.abs(projection.gap - 0.05).max() < 1e-13
    assert np.abs(projection.points - on).max() < 1e-10


@pytest.mark.parametrize("triangles", [False, True])
@pytest.mark.parametrize(("long", "shear"), [(1.0, 3.0), (30.0, 0.3), (100.0, 0.0)])
def test_points_of_slender_facets_are_their_own_feet(triangles, long, shear):
    """The nodes nearest to a point are often those of other facets."""
    slope = np.array([[1.0, 0.0, 0.0], [shear, 1.0, 0.0], [0.0, 0.0, 1.0]])
    flat = fc.SurfaceMesh.of(fc.shapes.block((1.0, long, 1.0), (4, 4, 1)), "top").mapped(lambda x: x @ slope)
    quads = flat.facets[:, :4]
    facets = np.concatenate([quads[:, [0, 1, 2, 2]], quads[:, [0, 2, 3, 3]]]) if triangles else quads
    points = np.random.default_rng(0).uniform((0, 0, 1), (1, long, 1), (2000, 3)) @ slope
    found = FacetSurface(flat.points, facets).project(points)
    assert np.abs(found.points - points).max() < 1e-13 * long
    assert not found.outside.any()


def test_a_facet_without_normal_is_named():
    surface = FacetSurface(np.outer(np.arange(4.0), [1, 0, 0]), np.arange(4)[None], "lid")
    with refused(MeshError, "no-normal", "Facet 0", "'lid'"):
        surface.normals(np.array([0]), np.array([[0.5, 0.5]]))


def test_short_offsets_on_an_edge_do_not_tilt_the_line_of_action():
    # the foot on an edge between coplanar facets: an offset of 1e-7 has a direction good to 1e-9 only
    Q = fc.rotation_about((1, 2, 3), 0.8)
    flat = patch(4, 8, lambda xy: np.zeros(len(xy)))
    surface = FacetSurface(flat.points @ Q.T, flat.facets)
    on = flat.points[(np.abs(flat.points) < 0.9)[:, :2].all(axis=1)]
    for gap in (1e-3, 1e-7, 1e-11, 0.0, -1e-7):
        projection = surface.project((on + np.array([0, 0, gap])) @ Q.T)
        assert np.abs(projection.normals - Q[:, 2]).max() < 1e-14


def test_a_ridge_gives_the_line_through_its_edge():
    # over a convex edge the nearest point is the edge itself and the line to it lies in the normal cone
    ridge = patch(2, 4, lambda xy: -np.abs(xy[:, 0]))
    projection = ridge.project(np.array([[0.05, 0.3, 0.2], [0.0, 0.3, 0.2], [0.3, 0.3, 0.2]]))
    assert np.abs(projection.normals[0] - np.array([0.05, 0, 0.2]) / np.hypot(0.05, 0.2)).max() < 1e-14
    assert np.abs(projection.normals[1] - [0, 0, 1]).max() < 1e-14
    assert np.abs(projection.normals[2] - np.array([1, 0, 1]) / np.sqrt(2)).max() < 1e-14


@pytest.mark.parametrize("depth", [0.0, 1e-9, -1e-3])
def test_normals_between_flat_facets_do_not_lean_to_a_sharp_edge_beyond(depth):
    """At a side of two facets in one plane, of a box: averages at the box's edges are inclined."""
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (4, 4, 2), element="hex8")
    surface = FacetSurface(mesh.points, mesh.face_nodes(mesh.outer_faces), "box")
    found = surface.project(np.array([[1.0, 0.47, 1.0 - depth], [0.5, 1.9, 1.0 - depth]]))
    assert np.abs(found.normals - [0, 0, 1]).max() < 1e-12
    edge = surface.project(np.array([[1.0, 2.0, 1.0]]))
    assert np.abs(edge.normals - np.array([0, 1, 1]) / np.sqrt(2)).max() < 1e-12
