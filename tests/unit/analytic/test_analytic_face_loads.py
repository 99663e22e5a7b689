import numpy as np
import pytest
from refusals import refused

from fecontact import InputError, Material
from fecontact.analytic import boussinesq
from fecontact.analytic.face_loads import FaceLoads, fields, tangent_axes

STEEL = Material(E=2.0, nu=0.3)
RANDOM = np.random.default_rng(7)


def _three_loads():
    normals = np.array([[0.0, 0.0, -1.0], [0.9, -0.3, 0.4], [0.0, 1.0, 0.0]])
    return FaceLoads(np.array([[0.0, 0.1, 0.0], [1.0, 2.0, 3.0], [0.5, 0.5, 0.5]]), normals, RANDOM.normal(size=(3, 3)))


def _only(loads, j):
    return FaceLoads(loads.places[j : j + 1], loads.normals[j : j + 1], loads.forces[j : j + 1])


def _below(loads, count):
    """Points below all tangent planes of `loads`."""
    cloud = RANDOM.normal(size=(4000, 3)) * 4
    heights = np.einsum("mni,mi->mn", cloud - loads.places[:, None], loads.axes[:, 2])
    return cloud[(heights > 0.2).all(axis=0)][:count]


def test_axes_are_right_handed_and_orthonormal():
    normals = np.concatenate([RANDOM.normal(size=(50, 3)), np.eye(3), -np.eye(3)])
    axes = tangent_axes(normals)
    identity = np.broadcast_to(np.eye(3), axes.shape)
    np.testing.assert_allclose(axes @ np.swapaxes(axes, -1, -2), identity, rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(axes), 1.0, rtol=0, atol=1e-14)
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(axes[:, 2], unit, rtol=0, atol=1e-15)


def test_fields_are_those_of_one_half_space_after_another():
    loads = _three_loads()
    points = _below(loads, 20)
    displacement, stress = fields(points, loads, STEEL)
    assert displacement.shape == (3, len(points), 3)
    assert stress.shape == (3, len(points), 3, 3)
    for j, axes in enumerate(loads.axes):
        local = (points - loads.places[j]) @ axes.T
        force = axes @ loads.forces[j]
        u = boussinesq.displacement(local, force=force, material=STEEL) @ axes
        s = axes.T @ boussinesq.stress(local, force=force, material=STEEL) @ axes
        np.testing.assert_allclose(displacement[j], u, rtol=0, atol=1e-14)
        np.testing.assert_allclose(stress[j], s, rtol=0, atol=1e-14)


def test_stress_follows_from_displacement_and_is_in_equilibrium(hooke, divergence):
    loads = _three_loads()
    for point in _below(loads, 3):
        for j in range(3):
            found = fields([point], loads, STEEL)[1][j, 0]
            expected = hooke(lambda p, j=j: fields([p], loads, STEEL)[0][j, 0], point, STEEL, 1e-3)
            # Fourth-order differences, step 1e-3, of fields that vary over 0.2 or more.
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7)
            pull = divergence(lambda p, j=j: fields([p], loads, STEEL)[1][j, 0], point, 1e-3)
            np.testing.assert_allclose(pull, 0.0, rtol=0, atol=1e-7)


def test_a_hemisphere_carries_the_load():
    loads = _three_loads()
    nodes, weights = np.polynomial.legendre.leggauss(12)
    height, w = (nodes + 1) / 2, weights / 2
    angle = 2 * np.pi * np.arange(16) / 16
    radius = np.sqrt(1 - height**2)
    ball = np.stack([np.outer(radius, np.cos(angle)), np.outer(radius, np.sin(angle)), np.outer(height, 0 * angle + 1)])
    for j, axes in enumerate(loads.axes):
        outward = ball.reshape(3, -1).T @ axes
        stress = fields(loads.places[j] + outward, _only(loads, j), STEEL)[1].reshape(12, 16, 3, 3)
        traction = np.einsum("haij,haj->hai", stress, outward.reshape(12, 16, 3)).mean(axis=1)
        # 1e-8: Gauss's error in a root and 1/(1 + height)^2; the angle is exact.
        np.testing.assert_allclose(-2 * np.pi * w @ traction, loads.forces[j], rtol=0, atol=1e-8)


def test_work_of_two_loads_on_a_tilted_plane_is_reciprocal():
    normal = np.array([0.2, -0.5, 1.0])
    places = np.array([np.zeros(3), np.cross(normal, [1.0, 0.3, 0.0])])
    forces = RANDOM.normal(size=(2, 3))
    loads = FaceLoads(places, np.array([normal, normal]), forces)
    there = fields(places[1:], _only(loads, 0), STEEL)[0][0, 0] @ forces[1]
    back = fields(places[:1], _only(loads, 1), STEEL)[0][0, 0] @ forces[0]
    assert there == pytest.approx(back, rel=1e-13)


def test_bad_input_is_named():
    one = np.array([[0.0, 0.0, 1.0]])
    with refused(InputError, "input", "one shape"):
        FaceLoads(one, one, np.ones((2, 3)))
    with refused(InputError, "normal-zero"):
        FaceLoads(one, 0 * one, one)
    loads = FaceLoads(0 * one, one, one)
    with refused(InputError, "points-outside-body", "times the distance"):
        fields([[0.1, 0.0, -1.0]], loads, STEEL)
    with refused(InputError, "input", "origin"):
        fields([[0.0, 0.0, 0.0]], loads, STEEL)
