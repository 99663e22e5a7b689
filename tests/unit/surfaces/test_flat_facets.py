"""Flat triangles through the corners of facets: distances, and which facets can hold a closest point."""

import numpy as np
import pytest

from fecontact.surfaces.closest_point import FlatFacets
from fecontact.surfaces.facet_surface import FacetSurface

pytestmark = pytest.mark.rounding


@pytest.fixture
def rng():
    # of each test, so that the points do not depend on which tests ran before
    return np.random.default_rng(7)


def triangles(n, height, columns=9):
    """A surface of 2 n^2 triangles of 3, 6 or 7 nodes over a square, as high as height(x, y)."""
    m = 2 * n
    x, y = np.meshgrid(*[np.linspace(-1, 1, m + 1)] * 2, indexing="ij")
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    index = np.arange(len(points)).reshape(m + 1, m + 1)
    a, b, c = slice(0, -2, 2), slice(2, None, 2), slice(1, None, 2)
    low = [index[s].ravel() for s in ((a, a), (b, a), (b, b), (c, a), (b, c), (c, c))]
    high = [index[s].ravel() for s in ((a, a), (b, b), (a, b), (c, c), (c, b), (a, c))]
    p, q, r, pq, qr, rp = (np.concatenate(pair) for pair in zip(low, high, strict=True))
    middle = len(points) + np.arange(len(p))
    points = np.concatenate([points, (points[p] + points[q] + points[r]) / 3])
    facets = np.stack([p, q, r, r, pq, qr, r, rp, middle], axis=1)[:, :columns]
    return FacetSurface(np.column_stack([points, height(*points.T)]), facets)


def wave(x, y):
    """A wavy height."""
    return 0.1 * np.sin(2 * x) * np.cos(3 * y)


def quads(n):
    """Warped quadrilaterals over the same square, and one among them that is a triangle."""
    x, y = np.meshgrid(*[np.linspace(-1, 1, n + 1)] * 2, indexing="ij")
    i = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    facets = np.stack([c.ravel() for c in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:])], axis=1)
    facets[0, 3] = facets[0, 2]
    return FacetSurface(np.stack([x, y, wave(x, y)], axis=-1).reshape(-1, 3), facets)


SURFACES = {"3": triangles(4, wave, 4), "6": triangles(4, wave, 8), "7": triangles(4, wave), "4": quads(6)}


def grid(triangle, k=60):
    """Many coordinates on a facet."""
    t = np.linspace(0, 1, k + 1)
    X = np.stack(np.meshgrid(t, t, indexing="ij"), -1).reshape(-1, 2)
    return X[X.sum(axis=1) <= 1 + 1e-12] if triangle else X


def test_distances_from_triangles_are_those_of_the_nearest_of_many_of_their_points(rng):
    corners = rng.normal(size=(40, 3, 3))
    corners[0, 2] = corners[0, 1]  # no area
    corners[1] = corners[1, 0] + np.array([[0.0], [1.0], [0.4]]) * np.array([1.0, 2.0, 3.0])  # on a line
    flat = FlatFacets.of(corners.reshape(-1, 3), np.arange(120).reshape(-1, 3)[:, [0, 1, 2, 2]])
    points = rng.normal(size=(40, 3))
    local, distance = flat.closest(points, np.arange(40))
    X = grid(True)
    a, b, c = corners.transpose(1, 0, 2)
    many = a[:, None] + X[:, :1] * (b - a)[:, None] + X[:, 1:] * (c - a)[:, None]
    sampled = np.linalg.norm(many - points[:, None], axis=2).min(axis=1)
    widest = np.linalg.norm(np.diff(corners[:, [0, 1, 2, 0]], axis=1), axis=2).max(axis=1) / 60
    assert (distance <= sampled + 1e-12).all()
    assert (sampled - distance <= widest).all()
    # the coordinates are of a point at that distance
    s, t = local.T[:, :, None]
    assert np.allclose(np.linalg.norm(a + s * (b - a) + t * (c - a) - points, axis=1), distance, atol=1e-12)
    assert (local >= 0).all()
    assert (local.sum(axis=1) <= 1 + 1e-12).all()


@pytest.mark.parametrize("kind", SURFACES)
def test_no_facet_that_holds_a_closest_point_is_left_out(kind, rng):
    surface = SURFACES[kind]
    n = len(surface.facets)
    points = np.column_stack([rng.uniform(-1.2, 1.2, (60, 2)), rng.uniform(-0.6, 0.6, 60)])
    point, facet = np.repeat(np.arange(60), n), np.tile(np.arange(n), 60)
    flat = FlatFacets.of(surface.points, surface.facets)
    kept, local = flat.nearest(points, point, facet)
    # against the distances of many points of every facet
    sampled = np.empty((60, n))
    for k in range(n):
        X = grid(surface.triangle[k], 24)
        x = surface.evaluate(np.full(len(X), k), X)[0]
        sampled[:, k] = np.linalg.norm(points[:, None] - x, axis=2).min(axis=1)
        assert np.abs(sampled[:, k] - flat.closest(points, np.full(60, k))[1]).max() <= flat.depart[k] + 0.5 / 24
    # most facets are left out, none of them with a point nearer than what was kept, which begins near its closest point
    exact = surface.polynomials.closest(points[point[kept]], facet[kept])[1]
    nearest = np.full(60, np.inf)
    np.minimum.at(nearest, point[kept], np.sqrt(exact))
    assert (sampled.min(axis=1) >= nearest - 1e-12).all()
    assert len(kept) < 0.15 * len(point)
    begun = np.linalg.norm(surface.evaluate(facet[kept], local)[0] - points[point[kept]], axis=1)
    assert (begun - np.sqrt(exact) <= 2 * flat.depart[facet[kept]] + 1e-12).all()


@pytest.mark.parametrize("kind", SURFACES)
def test_a_search_begins_as_near_as_the_triangles_depart(kind):
    """At many draws; a triangle among quadrilaterals too, where the nearest place is on its side from first to last."""
    surface = SURFACES[kind]
    flat = FlatFacets.of(surface.points, surface.facets)
    for seed in range(40):
        rng = np.random.default_rng(seed)
        facet = np.append(rng.integers(len(surface.facets), size=400), np.zeros(100, int))
        points = np.column_stack([rng.uniform(-1.2, 1.2, (500, 2)), rng.uniform(-0.6, 0.6, 500)])
        local, distance = flat.closest(points, facet)
        begun = np.linalg.norm(surface.evaluate(facet, local)[0] - points, axis=1)
        assert (np.abs(begun - distance) <= flat.depart[facet] + 1e-12).all()
        assert (local.sum(axis=1) <= 1 + 1e-12)[surface.triangle[facet]].all()
