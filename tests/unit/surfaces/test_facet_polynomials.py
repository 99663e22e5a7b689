"""Polynomials of facets and their derivatives against sums of monomials."""

import numpy as np
import pytest

from fecontact.mesh.facets import facet_shapes
from fecontact.surfaces.closest_point import _coefficients, first_derivatives


@pytest.mark.parametrize("only_triangles", [False, True])
@pytest.mark.parametrize("m", [2, 3, 4])
def test_values_and_first_derivatives(m, only_triangles):
    """Sums of at most 16 terms of size one; every term is differentiated by hand."""
    rng = np.random.default_rng(m)
    c, (s, t) = rng.normal(size=(m, m, 3, 50)), rng.uniform(-0.2, 1.2, (2, 50))
    expected = np.zeros((3, 3, 50))
    for i in range(m):
        for j in range(m):
            if not only_triangles or i + j < m:
                expected[0] += c[i, j] * s**i * t**j
                expected[1] += c[i, j] * i * s ** max(i - 1, 0) * t**j
                expected[2] += c[i, j] * j * s**i * t ** max(j - 1, 0)
    before = c.copy()
    for found, sums in zip(first_derivatives(c, s, t, only_triangles), expected, strict=True):
        assert np.abs(found - sums).max() < 1e-13
    assert np.array_equal(c, before)


@pytest.mark.parametrize(("columns", "degree"), [(4, 1), (8, 3), (9, 3)])
def test_powers_on_triangles_sum_to_the_degree(columns, degree):
    """The other coefficients are zero, and the rest are the shape functions still: cubic with the centroid's bubble."""
    rank = np.arange(degree + 1)
    coefficients = _coefficients(columns, True, degree).reshape(degree + 1, degree + 1, -1)
    i, j = np.nonzero(np.add.outer(rank, rank) > degree)
    assert np.abs(coefficients[i, j]).max() == 0.0
    local = np.random.default_rng(0).uniform(0.0, 0.5, (20, 2))
    N = sum(coefficients[i, j] * (local[:, :1] ** i * local[:, 1:] ** j) for i in rank for j in rank)
    assert np.abs(N - facet_shapes(columns, np.ones(20, bool), local)[0]).max() < 1e-12
