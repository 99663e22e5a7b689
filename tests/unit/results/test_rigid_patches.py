"""Patches of rigid surfaces in pictures."""

import numpy as np

import fecontact as fc
from fecontact.results.pictures.bodies import plot_bodies
from fecontact.results.pictures.solids import rigid_patches

SOFT = fc.Material(E=1.0, nu=0.3)


def pressed(shape, turn=None):
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (2, 2, 1)).translated((-0.5, -0.5, 0.0))
    block = fc.ElasticBody(mesh, SOFT, "bottom", {"top": "xyz"}, name="block")
    rigid = fc.RigidBody(shape).placed((0, 0, 0), turn)
    return fc.Scene([block, rigid], [fc.Contact(block, rigid)]).solve(motions={block: {"z": -0.02}})


def test_patches_lie_on_the_surface_and_reach_as_far_as_the_contact():
    # a ball that rests below the origin, and the plane z = 0
    ball = pressed(fc.Sphere(2.0), fc.rotation_about((1, 0, 0), np.pi))
    points, quads = rigid_patches(ball, 1.0)
    assert np.abs(np.linalg.norm(points - [0, 0, -2.0], axis=1) - 2).max() < 1e-12  # coordinates of order one
    plane, _ = rigid_patches(pressed(fc.Plane()), 1.0)
    assert np.abs(plane[:, 2]).max() < 1e-12
    assert np.abs(plane[:, :2]).max() > 0.5
    assert len(quads) > 0


def test_quadrilaterals_beyond_the_surface_are_left_out():
    # heights known on 1.2 x 1.2 only, where the whole patch would be 1.3 x 1.3 or more
    heights = fc.RigidBody.from_heights(np.zeros((12, 12)), (1.2, 1.2)).shape
    result = pressed(heights, fc.rotation_about((1, 0, 0), np.pi))
    points, quads = rigid_patches(result, 1.0)
    assert len(quads) > 0
    assert np.abs(points[quads][..., :2]).max() < 0.6 + 1e-12


def test_the_picture_shows_the_rigid_surface():
    result = pressed(fc.Plane())
    with_floor = plot_bodies(result, view="y", pixels=(200, 200)).axes[0].images[0].get_extent()
    block = plot_bodies(result, view="y", pixels=(200, 200), bodies=["block"]).axes[0].images[0].get_extent()
    assert with_floor[1] - with_floor[0] > 1.1 * (block[1] - block[0])
