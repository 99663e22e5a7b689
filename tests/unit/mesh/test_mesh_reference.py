"""Shape functions, faces and quadrature of the reference hexahedron."""

import numpy as np
import pytest

from fecontact.mesh.element import (
    FACES,
    element_basis,
    hex_nodes,
    hex_quadrature,
    hex_shapes,
    midface_shape,
    quad_nodes,
    quad_quadrature,
    quad_shapes,
)

# a few products and sums of numbers of size one
ROUNDING = 1e-13
# central differences of step 1e-5 of polynomials of size one: h^2 and eps/h
DIFFERENCES = 1e-9


def inside(n, dim, seed=1):
    return np.random.default_rng(seed).random((n, dim))


def differences(shapes, X, step=1e-5):
    """Gradients of shape functions by central differences."""
    return np.stack(
        [(shapes(X + step * e)[0] - shapes(X - step * e)[0]) / (2 * step) for e in np.eye(X.shape[1])], axis=-1
    )


@pytest.mark.parametrize(
    ("shapes", "nodes", "n"),
    [*((hex_shapes, hex_nodes, n) for n in (8, 20, 27)), *((quad_shapes, quad_nodes, n) for n in (4, 8, 9))],
)
def test_functions_of_hexahedra_and_quadrilaterals(shapes, nodes, n):
    X = inside(20, nodes(n).shape[1])
    N, dN = shapes(n, X)
    assert np.abs(N.sum(axis=1) - 1).max() < ROUNDING
    assert np.abs(dN.sum(axis=1)).max() < 10 * ROUNDING
    assert np.abs(shapes(n, nodes(n))[0] - np.eye(n)).max() < ROUNDING
    assert np.abs(differences(lambda x: shapes(n, x), X) - dN).max() < DIFFERENCES
    # one point many times, alone and beside another
    many = np.repeat(X[:1], 200, axis=0)
    for there in (many, np.concatenate([many, X[1:2]])):
        for found, one in zip(shapes(n, there), (N, dN), strict=True):
            assert found.shape == (len(there), *one.shape[1:])
            assert np.abs(found[:200] - one[0]).max() < ROUNDING


@pytest.mark.parametrize("face", range(6))
def test_face_corners_run_counter_clockwise_seen_from_outside(face):
    nodes = hex_nodes(27)[FACES[face]]
    outward = np.zeros(3)
    outward[face // 2] = 1 if face % 2 else -1
    normal = np.cross(nodes[1] - nodes[0], nodes[3] - nodes[0])
    assert np.array_equal(normal, outward)
    assert (nodes[:, face // 2] == face % 2).all()


@pytest.mark.parametrize("face", range(6))
def test_face_nodes_carry_the_quadrilaterals_functions(face):
    st = inside(10, 2)
    corners = hex_nodes(27)[FACES[face, :4]]
    X = quad_shapes(4, st)[0] @ corners
    for n_hex, n_quad in ((8, 4), (20, 8), (27, 9)):
        N = hex_shapes(n_hex, X)[0]
        on_face = FACES[face, :n_quad]
        assert np.abs(N[:, on_face] - quad_shapes(n_quad, st)[0]).max() < ROUNDING
        assert np.abs(np.delete(N, on_face, axis=1)).max() < ROUNDING


@pytest.mark.parametrize("face", range(6))
def test_midface_function(face):
    X = inside(20, 3)
    _, gradient = midface_shape(face, X)
    assert np.abs(differences(lambda x: (midface_shape(face, x)[0],), X) - gradient).max() < DIFFERENCES
    centres = hex_nodes(27)[20:26]
    assert np.abs(midface_shape(face, centres)[0] - np.eye(6)[face]).max() < ROUNDING
    assert np.abs(midface_shape(face, hex_nodes(20))[0]).max() < ROUNDING


@pytest.mark.parametrize("faces", [(5,), (0, 3), tuple(range(6))])
def test_midface_element_keeps_the_kronecker_property(faces):
    N, dN = element_basis(20, tuple(range(20)), faces, X := np.concatenate([inside(20, 3), hex_nodes(20)]))
    assert np.abs(N.sum(axis=1) - 1).max() < ROUNDING
    nodes = np.concatenate([hex_nodes(20), hex_nodes(27)[[20 + f for f in faces]]])
    assert np.abs(element_basis(20, tuple(range(20)), faces, nodes)[0] - np.eye(len(nodes))).max() < ROUNDING
    assert np.abs(differences(lambda x: element_basis(20, tuple(range(20)), faces, x), X) - dN).max() < DIFFERENCES


def test_midface_element_is_the_nine_node_quadrilateral_on_its_face():
    st = inside(10, 2)
    X = quad_shapes(4, st)[0] @ hex_nodes(27)[FACES[5, :4]]
    N = element_basis(20, tuple(range(20)), (5,), X)[0]
    assert np.abs(N[:, [*FACES[5, :8], 20]] - quad_shapes(9, st)[0]).max() < ROUNDING


def test_midface_element_conforms_with_plain_neighbours():
    plain, rich = tuple(range(20)), (5,)
    for face in range(5):
        X = quad_shapes(4, inside(10, 2))[0] @ hex_nodes(27)[FACES[face, :4]]
        N = element_basis(20, plain, rich, X)[0]
        assert np.abs(N[:, :20] - hex_shapes(20, X)[0]).max() < ROUNDING
        assert np.abs(N[:, 20]).max() < ROUNDING


@pytest.mark.parametrize(("n", "count"), [(8, 8), (20, 27), (27, 27)])
def test_quadrature_is_exact_to_its_degree(n, count):
    X, W = hex_quadrature(n)
    assert len(W) == count
    degree = 2 * round(count ** (1 / 3)) - 1
    for powers in np.ndindex(degree + 1, degree + 1, degree + 1):
        exact = 1 / np.prod(np.array(powers) + 1.0)
        assert abs(W @ np.prod(X ** np.array(powers), axis=1) - exact) < ROUNDING


def test_face_quadrature_is_exact_to_order_five():
    X, W = quad_quadrature()
    for i in range(6):
        for j in range(6):
            assert abs(W @ (X[:, 0] ** i * X[:, 1] ** j) - 1 / ((i + 1) * (j + 1))) < ROUNDING
