"""Rigid surfaces given by facets, against the shape that they stand for."""

import meshio
import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import SurfaceMesh
from fecontact.surfaces import Facets

RADIUS = 2.0


def bowl(n):
    """The lower cap of a sphere that rests on z = 0, as triangles that face down."""
    t = np.linspace(-1.2, 1.2, n)
    X, Y = np.meshgrid(t, t, indexing="ij")
    Z = RADIUS - np.sqrt(RADIUS**2 - X**2 - Y**2)
    number = np.arange(n * n).reshape(n, n)
    a, b, c, d = (m.ravel() for m in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, d, c], 1), np.stack([a, c, b], 1)])
    return np.stack([X.ravel(), Y.ravel(), Z.ravel()], axis=1), triangles


@pytest.fixture
def stl(tmp_path):
    points, triangles = bowl(81)
    meshio.Mesh(points, [("triangle", triangles)]).write(tmp_path / "bowl.stl", binary=True)
    return tmp_path / "bowl.stl"


def test_heights_and_feet_are_those_of_the_sphere(stl):
    shape = fc.RigidBody.from_stl(stl).shape
    sphere = fc.Sphere(RADIUS)
    x = np.linspace(-0.5, 0.5, 37)
    sagitta = (2.4 / 80) ** 2 / RADIUS / 4  # of a facet's diagonal, and up to 1.2 times for the slope
    assert np.abs(shape.heights(x[:, None], x[None, :]) - sphere.heights(x[:, None], x[None, :])).max() < 1.3 * sagitta
    assert np.isinf(shape.heights(np.array([1.3]), np.array([0.0]))).all()
    points = np.column_stack([np.random.default_rng(0).uniform(-0.5, 0.5, (30, 2)), np.full(30, -0.05)])
    projection, exact = shape.project(points), sphere.project(points)
    assert np.abs(projection.gap - exact.gap).max() < 1.3 * sagitta
    assert not projection.outside.any()


def test_heights_in_batches_are_the_same(stl, monkeypatch):
    shape = fc.RigidBody.from_stl(stl).shape
    x = np.linspace(-1.3, 1.3, 23)
    whole = shape.heights(x[:, None], x[None, :])
    monkeypatch.setattr("fecontact.surfaces.rigid.triangulated.PAIRS", 50)
    assert np.array_equal(whole, shape.heights(x[:, None], x[None, :]))


def test_the_lowest_of_two_sheets_counts():
    square = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1.0]])
    both = SurfaceMesh(np.concatenate([square, square + np.array([0.0, 0, 1])]), np.array([[0, 3, 2, 1], [4, 5, 6, 7]]))
    assert Facets(both).heights(np.array([0.5]), np.array([0.25])).tolist() == [1.0]


def test_a_half_space_under_an_stl_ball(stl):
    steel = fc.Material(E=1.0, nu=0.0)
    half = fc.HalfSpace(steel, size=(1.2, 1.2), cells=(40, 40))
    facets = half.press(fc.RigidBody.from_stl(stl).shape, approach=0.1)
    ball = half.press(fc.Sphere(RADIUS), approach=0.1)
    # facets of a fifteenth of the contact's diameter
    assert abs(facets.force / ball.force - 1) < 0.01


def test_an_elastic_block_under_an_stl_ball(stl):
    block = fc.shapes.block((1.6, 1.6, 0.8), (8, 8, 4)).mapped(lambda p: p - [0.8, 0.8, 0.8])
    body = fc.ElasticBody(block, fc.Material(E=1.0, nu=0.3), "top", {"bottom": "xyz"})
    forces = []
    for rigid in (fc.RigidBody.from_stl(stl), fc.RigidBody(fc.Sphere(RADIUS))):
        found = fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(motions={rigid: {"z": -0.05}})
        forces.append(found.contacts[0].force[2])
    assert abs(forces[0] / forces[1] - 1) < 0.02  # facets of a thirtieth of the contact


def test_refusals(tmp_path):
    with refused(fc.InputError, "input", "SurfaceMesh"):
        Facets("ball.stl")
    with refused(fc.InputError, "input", "from_surface"):
        fc.RigidBody.from_stl(tmp_path / "ball.obj")
    with refused(fc.InputError, "no-file"):
        fc.RigidBody.from_stl(tmp_path / "ball.stl")
