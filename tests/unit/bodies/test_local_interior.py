"""Fields inside local bodies: equilibrium, symmetry, poses, several windows, and points at which they are asked for."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.bodies.local.pressed import Pressed
from fecontact.bodies.local.window import Window
from fecontact.fem.stress import components
from fecontact.halfspace import Grid

SOLID = fc.Material(E=2.0, nu=0.3)
FORCE = 0.006


def pressed(local, balls, **options):
    """The local body under balls of radius 10, each above a window; forces on the modelled part."""
    bodies = [fc.RigidBody(fc.Sphere(10.0), pose=fc.Pose(translation=at)) for at in balls]
    contacts = [
        fc.Contact(local, ball, surfaces=(window, "surface"))
        for ball, window in zip(bodies, local.contact, strict=True)
    ]
    scene = fc.Scene([local, *bodies], contacts)
    return scene.solve(forces={b: (0, 0, -f) for b, f in zip(bodies, balls.values(), strict=True)}, **options)


@pytest.fixture(scope="module")
def block():
    """A clamped block under a ball in the middle of its top."""
    body = fc.ElasticBody(fc.shapes.block((4.0, 4.0, 2.0), (8, 8, 6)), SOLID, supports={"bottom": "xyz"})
    local = fc.LocalBody(body, (2.0, 2.0, 2.0), 0.8, (48, 48))
    return local, pressed(local, {(2.0, 2.0, 2.0): FORCE}, finite_motion=False)


def section(local, result, z: float) -> np.ndarray:
    """Force (3,) across a horizontal plane, by Gauss points dense in the middle."""
    x, w = np.polynomial.legendre.leggauss(28)
    t, dt = 2 + 2 * np.sinh(2.5 * x) / np.sinh(2.5), 5 * w * np.cosh(2.5 * x) / np.sinh(2.5)
    X, Y = np.meshgrid(t, t, indexing="ij")
    stress = result.fields_at(local, np.stack([X.ravel(), Y.ravel(), np.full(X.size, z)], axis=1))[1]
    return np.outer(dt, dt).ravel() @ stress[:, [5, 4, 2]]


@pytest.mark.full
def test_horizontal_sections_carry_the_load(block) -> None:
    """To the error of the coarse mesh's stresses, which is the largest at the clamped base."""
    for z, most in ((1.9, 3e-3), (1.5, 2e-3), (1.0, 6e-3), (0.0, 0.015)):
        assert np.abs(section(*block, z) / FORCE - [0, 0, -1]).max() < most, z


def test_faces_are_free_and_supports_hold(block) -> None:
    local, result = block
    points, stress, u = local.mesh.points, result.stress(local), result.displacement(local)
    largest = result.contacts[0].max_pressure
    away = np.hypot(*(points[:, :2] - 2).T) > 0.4
    assert np.abs(stress[(points[:, 2] == 2) & away][:, [2, 4, 5]]).max() < 1e-3 * largest
    # the clamped edge is singular
    assert np.abs(stress[(points[:, 0] == 4) & (points[:, 2] > 0.5)][:, [0, 3, 5]]).max() < 1e-3 * largest
    assert np.abs(u[points[:, 2] == 0]).max() < 1e-14 * np.abs(u).max()
    # the surface bears the pressure of the contact
    middle = np.flatnonzero((points == [2.0, 2.0, 2.0]).all(axis=1))
    assert abs(stress[middle, 2] / -largest - 1) < 2e-3
    strain = result.strain(local)
    swell = (1 - 2 * SOLID.nu) / SOLID.E * stress[:, :3].sum(axis=1)
    assert np.allclose(strain[:, :3].sum(axis=1), swell, atol=1e-12)


def test_fields_at_nodes_are_the_nodal_ones(block) -> None:
    local, result = block
    some = np.arange(0, len(local.mesh.points), 37)
    u, stress = result.fields_at(local, local.mesh.points[some])
    assert np.allclose(u, result.displacement(local)[some], atol=1e-12)
    assert np.allclose(stress, result.stress(local)[some], atol=1e-12)


def test_points_outside_are_refused(block) -> None:
    local, result = block
    with refused(fc.InputError, "points-outside-body", "1 of", "of 2", "'body'"):
        result.fields_at(local, [[2.0, 2.0, 1.0], [2.0, 2.0, 3.0]])
    with refused(fc.InputError, "rigid"):
        result.fields_at(result.scene.bodies[1], [[0.0, 0.0, 0.0]])


def test_planes_of_symmetry_and_poses_do_not_matter(block) -> None:
    """A quarter of the same mesh, rotated: the fields of the whole in its own axes, displacements in the world's."""
    whole, result = block
    mesh = fc.shapes.block((2.0, 2.0, 2.0), (4, 4, 6))
    supports = {"bottom": "xyz", "x_min": "x", "y_min": "y"}
    turn = fc.rotation_about((1, 2, 3), 0.7)
    quarter = fc.LocalBody(fc.ElasticBody(mesh, SOLID, supports=supports), (0, 0, 2.0), 0.8, (48, 48))
    local = quarter.placed([5.0, 0.0, 0.0], turn)
    ball = fc.RigidBody(fc.Sphere(10.0), pose=fc.Pose(turn, local.pose.to_world(np.array([[0, 0, 2.0]]))[0]))
    part = fc.Scene([local, ball], [fc.Contact(local, ball)]).solve(
        forces={ball: -FORCE / 4 * turn[:, 2]}, finite_motion=False
    )
    at = np.array([[0.05, 0.02, 1.99], [0.1, 0.3, 1.8], [0.7, 0.4, 1.2], [1.9, 1.8, 0.4]])
    one, other = result.fields_at(whole, at + np.array([2.0, 2.0, 0.0])), part.fields_at(local, at)
    # rounding may decide which blocks are far
    assert np.abs(other[1] - one[1]).max() < 3e-5 * np.abs(one[1]).max()
    assert np.abs(other[0] - one[0] @ turn.T).max() < 1e-6 * np.abs(one[0]).max()


@pytest.mark.full
def test_two_windows_are_two_local_bodies_together() -> None:
    """Under given loads the fields of a body with two windows are the sum of those of either alone."""
    body = fc.ElasticBody(fc.shapes.block((4.0, 2.0, 1.0), (8, 4, 2)), SOLID, supports={"bottom": "xyz"})
    parts = [fc.LocalBody(body, (x, 1.0, 1.0), 0.5, (16, 16)) for x in (1.0, 3.0)]
    both = fc.WindowedBody(*parts)
    balls = {(1.0, 1.0, 1.0): 2e-4, (3.0, 1.0, 1.0): 1e-4}
    alone = [pressed(part, {at: f}, finite_motion=False) for part, (at, f) in zip(parts, balls.items(), strict=True)]
    together = pressed(both, balls, finite_motion=False)
    expected = sum(result.stress(part) for result, part in zip(alone, parts, strict=True))
    # the windows' pressures change a little by their coupling
    assert np.abs(together.stress(both) - expected).max() < 0.01 * np.abs(expected).max()
    far = np.abs(body.mesh.points[:, 0] - 2) < 0.6
    assert np.abs(together.stress(both) - expected)[far].max() < 0.01 * np.abs(expected[far]).max()


def test_an_element_set_and_loads_of_the_body() -> None:
    """Uniaxial tension by the mesh's own loads, exact; nodes away from the set have no value."""
    mesh = fc.shapes.block((2.0, 2.0, 2.0), (2, 2, 2))
    mesh = fc.Mesh(mesh.points, mesh.cells, mesh.boundaries, groups={"some": np.arange(2)})
    body = fc.ElasticBody(mesh, SOLID, supports={"bottom": "z", "x_min": "x", "y_min": "y"})
    local = fc.LocalBody(body, (1.0, 1.0, 2.0), 0.4, (8, 8))
    ball = fc.RigidBody(fc.Sphere(1.0), pose=fc.Pose(translation=(1.0, 1.0, 2.1)))
    scene = fc.Scene([local, ball], [fc.Contact(local, ball)])
    result = scene.solve(pressures={(local, "x_max"): -0.01}, motions={ball: {"z": 0.0}})
    assert np.allclose(result.stress(local), [0.01, 0, 0, 0, 0, 0], atol=1e-12)
    some = result.stress(local, "some")
    assert np.isnan(some).any()
    assert np.allclose(some[~np.isnan(some[:, 0])], [0.01, 0, 0, 0, 0, 0], atol=1e-12)


def test_blocks_of_cells_are_the_cells() -> None:
    """Against Love's rectangles and Gauss points of every cell; blocks are allowed 3e-4 of the peak."""
    half = fc.HalfSpace(SOLID, (2.4, 2.0), (60, 36))
    contact = half.press(fc.surfaces.Paraboloid(10.0), force=4 / 3 * SOLID.plane_strain_modulus / 10 * 0.5)
    below = Pressed.of(
        Window(np.zeros(3), np.eye(3), Grid((2.4, 2.0), (60, 36)), (False, False)), contact.pressure, SOLID
    )
    at = np.array(
        [[0.0, 0.0, 0.0], [0.04, 0.0, 0.0], [0.3, -0.2, -0.02], [0.1, 0.2, -0.4], [1.1, 0.9, -0.1], [0, 3, -1]]
    )
    stress = below.stress(at)
    assert np.abs(components(stress) - contact.stress(at)).max() < 3e-4 * contact.max_pressure
    # where the surfaces touch, the surface lies on the paraboloid
    middle = np.array([[half.grid.x[32], half.grid.y[17], 0.0]])
    expected = contact.approach - (middle**2).sum() / 20
    assert abs(-below.displacement(middle)[0, 2] / expected - 1) < 1e-4
