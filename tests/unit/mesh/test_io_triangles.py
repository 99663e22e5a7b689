"""Triangular facets: shape functions, weights, projection, and elements with centroid nodes."""

import numpy as np
import pytest

from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.element import (
    FACES,
    PYRAMID,
    TETRAHEDRON,
    TRIANGLE_NODES,
    WEDGE,
    element_basis,
    element_quadrature,
    node_positions,
    triangle_shapes,
)
from fecontact.mesh.facets import facet_integrals, nodal_areas, shapes_on_square
from fecontact.mesh.refine import divided
from fecontact.surfaces.facet_surface import FacetSurface

# a few operations on numbers of order one
ROUNDING = 1e-13
COLUMNS = {4: [0, 1, 2, 2], 8: [0, 1, 2, 2, 3, 4, 2, 5], 9: [0, 1, 2, 2, 3, 4, 2, 5, 6]}


def curved_triangle(seed, amount=0.05):
    """Seven points of a triangle in space, the centroid where six nodes put it."""
    rng = np.random.default_rng(seed)
    points = np.column_stack([TRIANGLE_NODES @ [[1, 0.2], [0.1, 0.9]], amount * rng.standard_normal(7)])
    points[6] = triangle_shapes(6, TRIANGLE_NODES[6:])[0] @ points[:6]
    return points


@pytest.mark.parametrize("n", [3, 6, 7])
def test_functions_of_the_triangle(n):
    X = np.random.default_rng(0).uniform(0, 0.5, (20, 2))
    N, dN = triangle_shapes(n, X)
    assert np.abs(triangle_shapes(n, TRIANGLE_NODES[:n])[0] - np.eye(n)).max() < ROUNDING
    assert np.abs(N.sum(axis=1) - 1).max() < ROUNDING
    h = 1e-6
    for j, e in enumerate(np.eye(2)):
        difference = (triangle_shapes(n, X + h * e)[0] - triangle_shapes(n, X - h * e)[0]) / (2 * h)
        # rounding over the step, 1e-16 / 1e-6, times functions with slopes up to 10
        assert np.abs(difference - dN[..., j]).max() < 1e-8


def test_weights_of_a_flat_triangle():
    points = curved_triangle(0, amount=0.0)
    area = (1 * 0.9 - 0.2 * 0.1) / 2
    weights = nodal_areas(points, np.array([COLUMNS[9]])) / area
    assert np.abs(weights - ([1 / 20] * 3 + [2 / 15] * 3 + [9 / 20])).max() < ROUNDING
    six = nodal_areas(points[:6], np.array([COLUMNS[8]])) / area
    assert np.abs(six - ([0.0] * 3 + [1 / 3] * 3)).max() < ROUNDING


def test_quadrilaterals_and_triangles_side_by_side():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]], dtype=float)
    facets = np.array([[0, 1, 2, 3], [1, 4, 2, 2]])
    _, x, dA = facet_integrals(points, facets)
    assert np.abs(dA.sum(axis=1) - [[0, 0, 1], [0, 0, 0.5]]).max() < ROUNDING
    centre = np.einsum("fqi,fq->fi", x, dA[..., 2]) / dA[..., 2].sum(axis=1)[:, None]
    assert np.abs(centre[1] - [4 / 3, 1 / 3, 0]).max() < ROUNDING
    N, _ = shapes_on_square(facets, np.array([[0.3, 0.6]]))
    assert np.abs(N.sum(axis=2) - 1).max() < ROUNDING


@pytest.mark.parametrize("k", [4, 8, 9])
def test_feet_on_a_curved_triangle_are_the_nearest_points(k):
    for seed in range(5):
        surface = FacetSurface(curved_triangle(seed), np.array([COLUMNS[k]]))
        points = np.random.default_rng(seed).uniform(-0.3, 1.3, (50, 3)) * [1, 1, 0.3]
        projection = surface.project(points)
        assert (projection.local >= 0).all()
        assert (projection.local.sum(axis=1) <= 1 + ROUNDING).all()
        t = np.linspace(0, 1, 121)
        s, t = (a.ravel() for a in np.meshgrid(t, t))
        grid, _, _ = surface.evaluate(np.zeros(len(s), int), np.stack([s * (1 - t), t], axis=1))
        nearest = np.linalg.norm(points[:, None] - grid, axis=2).min(axis=1)
        assert (np.linalg.norm(points - projection.points, axis=1) - nearest).max() < ROUNDING
        assert np.abs(projection.weights @ surface.points - projection.points).max() < ROUNDING
        # the foot lies on the line of action through the point
        assert (
            np.abs(projection.points + projection.gap[:, None] * projection.normals - points)[~projection.outside].max()
            < 1e-9
        )


def test_projection_across_a_mixed_surface(block):
    mesh = block("mixed", (4, 3, 2))
    surface = FacetSurface(mesh.points, mesh.face_nodes(mesh.faces("top")))
    assert 0 < surface.triangle.sum() < len(surface.facets)
    points = np.random.default_rng(0).uniform(0.01, 0.99, (200, 3)) * [1, 1, 0] + [0, 0, 1.25]
    projection = surface.project(points)
    assert np.abs(projection.gap - 0.25).max() < ROUNDING
    assert np.abs(projection.points - (points - [0, 0, 0.25])).max() < ROUNDING
    assert np.abs(projection.normals - [0, 0, 1]).max() < ROUNDING
    assert not projection.outside.any()
    assert surface.project(np.array([[1.3, 0.5, 1.1]])).outside.all()


@pytest.mark.parametrize("pattern", [WEDGE, TETRAHEDRON, PYRAMID], ids=["wedge", "tetrahedron", "pyramid"])
def test_middle_nodes_of_faces_are_independent(pattern):
    faces = tuple(f for f in range(6) if len(set(np.asarray(pattern)[FACES[f, :4]])) >= 3)
    N, _ = element_basis(20, pattern, faces, node_positions(20, pattern, faces))
    assert np.abs(N - np.eye(len(N))).max() < ROUNDING
    Y = np.random.default_rng(2).uniform(0, 1, (40, 3))
    assert np.abs(element_basis(20, pattern, faces, Y)[0].sum(axis=1) - 1).max() < ROUNDING
    n = len(set(pattern))
    for k, face in enumerate(faces):
        for other in set(range(6)) - {face}:
            on_other = Y.copy()
            on_other[:, other // 2] = other % 2
            assert np.abs(element_basis(20, pattern, faces, on_other)[0][:, n + k]).max() < ROUNDING


def test_own_rules_are_exact_for_their_degree():
    # int of b^i c^j d^k over the tetrahedron is i! j! k! / (i + j + k + 3)!
    X, W = element_quadrature(20, TETRAHEDRON)
    x, y, z = X.T
    b, c, volume = x * (1 - y) * (1 - z), y * (1 - z), (1 - y) * (1 - z) ** 2 * W
    assert abs((b**2 * c**2 * z * volume).sum() - 4 / 40320) < ROUNDING
    assert abs((z**5 * volume).sum() - 120 / 40320) < ROUNDING
    for midfaces, power in (((), 4), ((4,), 5)):
        X, W = element_quadrature(20, WEDGE, midfaces)
        x, y, z = X.T
        exact = {4: 24 / 720, 5: 120 / 5040}[power] / 6
        assert abs((y**power * z**5 * (1 - y) * W).sum() - exact) < ROUNDING


@pytest.mark.parametrize("kind", ["tet4", "tet10"])
def test_division_into_hexahedra_keeps_volume_boundaries_and_sets(kind, block):
    mesh = block(kind)
    hexes = divided(mesh)
    assert list(hexes.kinds) == [{"tet4": "hex8", "tet10": "hex20"}[kind]]
    assert len(hexes.cells) == 4 * len(mesh.cells)
    assert len(hexes.outer_faces) == 3 * len(mesh.outer_faces)
    tolerance = ROUNDING if kind == "tet4" else 1e-6  # curved edges are interpolated anew by the smaller cells
    assert abs(moments_of_volume(hexes)[0] - moments_of_volume(mesh)[0]) < tolerance
    for name in mesh.boundaries:
        area = nodal_areas(hexes.points, hexes.face_nodes(hexes.faces(name))).sum()
        assert abs(area - 1) < ROUNDING
        outer = {tuple(f) for f in hexes.outer_faces.tolist()}
        assert {tuple(f) for f in hexes.faces(name).tolist()} <= outer
