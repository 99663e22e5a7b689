"""Half-space under a uniform shear traction on a rectangle."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import boussinesq, rectangle

SOLID, SIDES = fc.Material(E=2.0, nu=0.3), (0.7, 0.4)


def summed(points: np.ndarray, traction: tuple[float, float], n: int = 80) -> np.ndarray:
    """The same by Cerruti's point loads at n x n Gauss points."""
    x, w = np.polynomial.legendre.leggauss(n)
    places = np.stack(
        [*(c.ravel() for c in np.meshgrid(SIDES[0] * x, SIDES[1] * x, indexing="ij")), np.zeros(n * n)], 1
    )
    weights = np.outer(w, w).ravel() * SIDES[0] * SIDES[1]
    fields = boussinesq.stress(points[:, None] - places, force=(*traction, 0.0), material=SOLID)
    return np.einsum("nqij,q->nij", fields, weights)


@pytest.mark.parametrize("traction", [(1.0, 0.0), (0.0, 1.0), (0.6, -0.3)])
def test_stress_is_the_integral_of_point_loads(traction: tuple[float, float]) -> None:
    """Below and beside the rectangle, near it and beyond six half-sides; 80 Gauss points are exact to 1e-9 there."""
    points = np.array([[0.1, 0.2, 0.2], [0.7, -0.1, 0.3], [1.2, 0.9, 0.1], [-0.3, 0.0, 1.0], [5.0, 3.0, 0.5]])
    found = rectangle.stress(points, half_sides=SIDES, traction=traction, material=SOLID)
    assert np.abs(found - summed(points, traction)).max() < 1e-8
    assert np.allclose(found, np.swapaxes(found, 1, 2), atol=1e-14)


def test_surface_bears_the_traction_and_nothing_else() -> None:
    points = np.array([[0.2, 0.1, 0.0], [0.8, 0.1, 0.0], [0.7, 0.1, 0.0]])
    found = rectangle.stress(points, half_sides=SIDES, traction=(2.0, -1.0), material=SOLID)
    # inside, outside, and on an edge the mean of both
    assert np.allclose(found[:, :, 2], [[-2.0, 1.0, 0.0], [0.0, 0.0, 0.0], [-1.0, 0.5, 0.0]], atol=1e-12)
    assert np.isfinite(rectangle.stress([0.7, 0.4, 0.0], half_sides=SIDES, traction=(1, 0), material=SOLID)).all()


@pytest.mark.full
def test_sections_below_carry_the_force() -> None:
    """Over a plane z = const the shear stresses balance the traction; the part beyond 40 half-sides is left out."""
    x, w = np.polynomial.legendre.leggauss(200)
    t = np.sinh(5.0 * x) / np.sinh(5.0) * 40  # dense in the middle
    dt = w * 5.0 * np.cosh(5.0 * x) / np.sinh(5.0) * 40
    X, Y = np.meshgrid(t, t, indexing="ij")
    points = np.stack([X.ravel(), Y.ravel(), np.full(X.size, 0.5)], axis=1)
    stress = rectangle.stress(points, half_sides=SIDES, traction=(1.0, 0.0), material=SOLID)
    force = np.einsum("n,ni->i", np.outer(dt, dt).ravel(), stress[:, :, 2])
    assert np.allclose(force, [-4 * SIDES[0] * SIDES[1], 0, 0], atol=0.02 * 4 * SIDES[0] * SIDES[1])


def test_the_former_module_warns() -> None:
    with pytest.warns(DeprecationWarning, match="rectangle"):
        found = fc.analytic.sheared_rectangle.stress([0, 0, 0.1], half_sides=SIDES, traction=(1, 0), material=SOLID)
    assert np.array_equal(found, rectangle.stress([0, 0, 0.1], half_sides=SIDES, traction=(1, 0), material=SOLID))
