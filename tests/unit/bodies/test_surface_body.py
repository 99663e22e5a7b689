"""Bodies of a surface and its flexibility alone: a bed of springs, a measured matrix, and what they are refused for."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused
from scipy.sparse.linalg import aslinearoperator

import fecontact as fc
from fecontact.bodies import Body, SurfaceBody, boundary_surface
from fecontact.surfaces.nodal_weights import contact_weights

STIFFNESS, RADIUS = 100.0, 50.0


class Surface(SurfaceBody):
    def __init__(self, mesh, flexibility, name="own"):
        self.facets, self.flexibility, self.name = boundary_surface(mesh, "top"), flexibility, name


def bed_matrix(mesh):
    area = contact_weights(boundary_surface(mesh, "top"))
    gives = np.divide(1.0, STIFFNESS * area, out=np.zeros(len(area)), where=area > 0)
    return sp.diags(np.repeat(gives, 3), format="csr")


@pytest.fixture
def mesh():
    return fc.shapes.block((2.0, 2.0, 0.1), (24, 24, 1), element="hex8")


def pressed(bed, depth=0.005):
    ball = fc.RigidBody(fc.Sphere(RADIUS), name="ball").placed((1.0, 1.0, 0.1))
    return fc.Scene([bed, ball], [fc.Contact(bed, ball)]).solve(motions={ball: {"z": -depth}})


@pytest.mark.parametrize("form", [lambda A: A, lambda A: A.toarray(), lambda A: aslinearoperator(A)])
def test_a_bed_of_springs_under_a_ball(mesh, form) -> None:
    result = pressed(Surface(mesh, form(bed_matrix(mesh))))
    # force = pi k R d^2; nodal areas sample the circle to the square of h/a = 0.083 / 0.71, some tenths of a percent
    assert abs(result.contacts[0].force[2]) == pytest.approx(np.pi * STIFFNESS * RADIUS * 0.005**2, rel=5e-3)
    assert result.warnings == ()


def test_the_same_as_an_elastic_layer(mesh) -> None:
    material = fc.Material(E=50.0, nu=0.0)
    layer = fc.ElasticLayer(material, thickness=0.5, surface=(mesh, "top"))
    own, usual = pressed(Surface(mesh, bed_matrix(mesh))), pressed(layer)
    np.testing.assert_allclose(own.contacts[0].forces, usual.contacts[0].forces, rtol=0, atol=1e-12)


def test_a_surface_moves_with_its_pose(mesh) -> None:
    turn = fc.rotation_about((1.0, 0.0, 0.0), 0.7)
    bed = Surface(mesh, bed_matrix(mesh))
    ball = fc.RigidBody(fc.Sphere(RADIUS), name="ball").placed((1.0, 1.0, 0.095))
    usual = fc.Scene([bed, ball], [fc.Contact(bed, ball)]).solve()
    bed, ball = (b.placed((3.0, -2.0, 1.0), turn) for b in (bed, ball))
    turned = fc.Scene([bed, ball], [fc.Contact(bed, ball)]).solve()
    # positions of 3 are known to 1e-16, gaps are 5e-3: thirteen digits of the forces, of which ten are asked
    np.testing.assert_allclose(turned.contacts[0].force, turn @ usual.contacts[0].force, rtol=0, atol=1e-10)


def test_the_condensed_problem_gives_the_solution(mesh) -> None:
    bed = Surface(mesh, bed_matrix(mesh))
    ball = fc.RigidBody(fc.Sphere(RADIUS), name="ball").placed((1.0, 1.0, 0.1))
    result = fc.Scene([bed, ball], [fc.Contact(bed, ball)]).solve({ball: (0.0, 0.0, -0.3)})
    S, B, g, F = result.problem.S, result.problem.B, result.problem.g, result.problem.F
    on = result.solution.forces > 0
    n, m = int(on.sum()), len(F)
    matrix = np.block([[S[np.ix_(on, on)], B[:, on].T], [B[:, on], np.zeros((m, m))]])
    found = np.linalg.solve(matrix, np.concatenate([-g[on], F]))
    # the certificate is 1e-10 of the load
    np.testing.assert_allclose(found[:n], result.solution.forces[on], rtol=0, atol=1e-10)
    np.testing.assert_allclose(found[n:], result.solution.q, rtol=1e-9)
    np.testing.assert_allclose(abs(B @ result.solution.forces), 0.3, rtol=1e-9)


def test_an_asymmetric_flexibility_is_refused_with_its_size(mesh) -> None:
    A = bed_matrix(mesh).tolil()
    # two nodes near the middle; one moves the other by a hundredth of what it gives, and not the other way round
    i, j = 3 * np.argsort(np.linalg.norm(mesh.points - [1.0, 1.0, 0.1], axis=1))[:2] + 2
    A[i, j] = 0.01 * A[i, i]
    with refused(fc.InputError, "flexibility-not-symmetric", "'own'", "0.01"):
        pressed(Surface(mesh, A.tocsr()))


def test_a_flexibility_of_another_shape_is_refused(mesh) -> None:
    with refused(fc.InputError, "flexibility-shape", "(3750, 3750)", "(625, 625)"):
        pressed(Surface(mesh, np.eye(625)))


def test_missing_members_are_named(mesh) -> None:
    class Half(SurfaceBody):
        facets = boundary_surface(mesh, "top")

    floor = fc.RigidBody(fc.Plane())
    with refused(fc.InputError, "no-body", "flexibility"):
        fc.Contact(Half(), floor)
    with refused(fc.InputError, "no-body", "name, pose, contact, n_dofs", "describe"):
        fc.Contact(floor, Body())  # type: ignore[abstract]
    with refused(fc.InputError, "no-body", "object"):
        fc.Contact(floor, object())  # type: ignore[arg-type]
    with refused(fc.InputError, "no-body", "'a body'"):
        fc.Scene([floor, "a body"], [fc.Contact(floor, fc.RigidBody(fc.Plane()))])  # type: ignore[list-item]
