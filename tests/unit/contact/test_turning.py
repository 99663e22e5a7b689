"""The stiffness of contact forces that turn: against second differences along motions that keep the gap closed."""

from __future__ import annotations

from functools import partial

import numpy as np

import fecontact as fc
from fecontact.contact.turning import turning_stiffness
from fecontact.surfaces import Cone
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.normals import normal_derivative

STEP = 1e-3


def strip(n: int, reverse: bool) -> tuple[np.ndarray, np.ndarray]:
    """Parameters (n_nodes, 2) of n nine-node facets in a row, and the facets; the second surface faces the first."""
    along, across = np.linspace(0.2, 1.4, 2 * n + 1), np.linspace(0.0, 1.0, 3)
    parameters = np.stack(np.meshgrid(along, across, indexing="ij"), -1).reshape(-1, 2)
    first = 6 * np.arange(n)[:, None]
    around = [0, 6, 8, 2, 3, 7, 5, 1, 4]
    turned = [0, 2, 8, 6, 1, 5, 7, 3, 4]
    return parameters, first + (turned if reverse else around)


def place(parameters: np.ndarray, slide: float, t: float, s: float) -> np.ndarray:
    """A cylinder that is bent and stretched, on which the points slide."""
    angle, z = parameters.T
    angle = angle + slide * (t * np.sin(angle) + s * np.cos(2 * angle) + s * t * angle)
    x = np.stack([2 * np.cos(angle), 2 * np.sin(angle), z], axis=1)
    bent = np.stack([0.3 * x[:, 1] ** 2, -0.2 * x[:, 0] * x[:, 2], 0.1 * x[:, 0] ** 2], axis=1)
    turned = np.stack([-x[:, 1] + 0.2 * x[:, 2] ** 2, x[:, 0], 0.3 * x[:, 1]], axis=1)
    return x + t * bent + s * turned + s * t * x[:, [1, 2, 0]]


def derivatives(at: partial[np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """By t, by s, and by both, at zero."""
    d = STEP
    by_t, by_s = (at(d, 0) - at(-d, 0)) / (2 * d), (at(0, d) - at(0, -d)) / (2 * d)
    return by_t, by_s, (at(d, d) - at(d, -d) - at(-d, d) + at(-d, -d)) / (4 * d * d)


def work(n: int, reverse: bool, slide: float) -> tuple[float, float]:
    """v K U of one body under a smooth pressure, and the work of its forces on the second derivative of the motion."""
    parameters, facets = strip(n, reverse)
    at = partial(place, parameters, slide)
    surface = FacetSurface(at(0, 0), facets)
    U, v, bend = derivatives(at)
    t, w = np.polynomial.legendre.leggauss(4)
    t, w = (t + 1) / 2, w / 2
    local = np.stack(np.meshgrid(t, t, indexing="ij"), -1).reshape(-1, 2)
    facet, local = np.repeat(np.arange(n), 16), np.tile(local, (n, 1))
    x, tangents, N = surface.evaluate(facet, local)
    normals = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    area = np.linalg.norm(normals, axis=1)
    angle = np.arctan2(x[:, 1], x[:, 0])
    forces = np.sin(np.pi * (angle - 0.2) / 1.2) ** 2 * np.tile(np.outer(w, w).ravel(), n) * area
    K = turning_stiffness(surface, facet, local, forces)
    assert abs(K - K.T).max() < 1e-12 * abs(K).max()
    moved = np.einsum("na,nai->ni", N, bend[surface.facets[facet]])
    return float(v.ravel() @ K @ U.ravel()), float(-forces @ np.einsum("ni,ni->n", normals / area[:, None], moved))


def test_along_motions_that_keep_the_gap_closed() -> None:
    """d2 g / dt ds = 0 there: F g'' (U, v) of both bodies is minus the work of F on the second derivative."""
    errors = []
    for n in (4, 8, 16):
        found, exact = np.sum([work(n, False, 0.3), work(n, True, -0.5)], axis=0)
        alone = work(n, False, 0.3)
        errors.append(abs(found - exact) / abs(alone[1]))
    assert errors[2] < 2e-3
    assert errors[1] / errors[2] > 3
    # one of the bodies alone has no such rule
    assert abs(alone[0] - alone[1]) > 0.1 * abs(alone[1])


def test_normals_of_a_rigid_sphere_turn_with_the_point() -> None:
    """By one over the distance of the point from the centre, across the normal; none on an edge."""
    ball, x = fc.Sphere(2.0), np.array([[0.3, 0.2, -0.1]])
    H = normal_derivative(ball, x, 1.0)[0]
    found = ball.project(x)
    n = found.normals[0]
    assert np.abs(H - (np.eye(3) - np.outer(n, n)) / (2.0 + found.gap[0])).max() < 1e-8
    edge = normal_derivative(Cone(0.5), np.zeros((1, 3)), 1.0)
    assert not edge.any()
