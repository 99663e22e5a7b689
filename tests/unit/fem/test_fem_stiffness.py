"""Stiffness: symmetric, positive, six zero modes, and the rigid modes they are."""

import numpy as np
import pytest

import fecontact as fc
from fecontact import Mesh
from fecontact.fem.element_stiffness import determinant_3x3, inverse_3x3
from fecontact.fem.rigid import COMPONENTS, describe_motion, gram_schmidt, null_space, rigid_modes
from fecontact.fem.stiffness import assemble_stiffness, batches

ALL_FACES = ("x_min", "x_max", "y_min", "y_max", "bottom", "top")


@pytest.fixture(params=["hex8", "hex20", "hex20 + 1", "hex20 + 6", "hex27"])
def one_cell(request, curved):
    """A single cell with curved edges, with 0, 1 or 6 mid-face nodes."""
    element, _, extra = request.param.partition(" + ")
    mesh = curved(element, (1, 1, 1), amount=0.12)
    return mesh.with_midface_nodes(ALL_FACES[-int(extra) :]) if extra else mesh


def test_six_zero_modes_and_no_more(one_cell, dense_stiffness):
    K = dense_stiffness(one_cell, fc.Material(E=1.0, nu=0.3))
    assert np.array_equal(K, K.T)
    values = np.linalg.eigvalsh(K)
    assert np.abs(values[:6]).max() < 1e-14 * values[-1] * len(K)
    # the softest true mode of a cell of size one is a few thousandths of E
    assert values[6] > 1e-3
    modes = rigid_modes(one_cell.points, (0.3, -0.2, 0.1))
    assert np.abs(K @ modes).max() < 1e-13 * np.abs(K).max()


def test_distorted_block_is_positive(curved, dense_stiffness):
    for element in ("hex8", "hex20", "hex27"):
        values = np.linalg.eigvalsh(dense_stiffness(curved(element), fc.Material(E=1.0, nu=0.49)))
        # rounding of the largest eigenvalue, which grows by 1/(1 - 2 nu)
        assert values[0] > -1e-14 * values[-1] * len(values)
        assert (values < 1e-10 * values[-1]).sum() == 6


def test_stiffness_does_not_depend_on_the_batch(curved, monkeypatch):
    mesh = curved()
    lame = np.linspace(1.0, 2.0, len(mesh.cells))
    whole = assemble_stiffness(mesh, lame, lame / 2)
    sizes = [len(b.cells) for b in batches(mesh, size=3)]
    assert sizes == [3, 3, 2]
    monkeypatch.setattr("fecontact.fem.stiffness.batches.__defaults__", (3, False))
    assert np.abs((assemble_stiffness(mesh, lame, lame / 2) - whole).data).max(initial=0) < 1e-14


def test_upper_triangle_with_sorted_indices(curved, steel):
    mesh = curved("hex8")
    n = len(mesh.cells)
    K = assemble_stiffness(mesh, np.full(n, steel.lame), np.full(n, steel.shear_modulus))
    rows = np.repeat(np.arange(K.shape[0]), np.diff(K.indptr))
    assert (K.indices >= rows).all()
    assert K.has_sorted_indices


def test_mixed_kinds_of_cells_are_summed(degenerate, dense_stiffness, steel):
    # a wedge and a hexahedron side by side: the sum of the two alone
    block = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
    wedge = degenerate("wedge")
    n = len(block.points)
    both = Mesh(np.concatenate([block.points, wedge.points]), np.concatenate([block.cells, wedge.cells + n]))
    K = dense_stiffness(both, steel)
    assert np.array_equal(K[: 3 * n, : 3 * n], dense_stiffness(block, steel))
    assert np.array_equal(K[3 * n :, 3 * n :], dense_stiffness(wedge, steel))
    assert not K[: 3 * n, 3 * n :].any()


def test_small_inverses():
    J = np.random.default_rng(3).normal(size=(50, 3, 3)) + 2 * np.eye(3)
    inverse, det = inverse_3x3(J)
    assert np.abs(det / np.linalg.det(J) - 1).max() < 1e-12
    assert np.abs(determinant_3x3(J) / np.linalg.det(J) - 1).max() < 1e-12
    # condition numbers up to some hundred
    assert np.abs(inverse @ J - np.eye(3)).max() < 1e-11


def test_rigid_modes_are_rigid():
    x = np.random.default_rng(4).normal(size=(20, 3))
    origin, q, w = np.array([0.3, 0.2, -1.0]), np.array([1.0, 2.0, 3.0]), np.array([-0.5, 0.1, 0.7])
    u = rigid_modes(x, origin) @ np.concatenate([q, w])
    assert np.abs(u.reshape(-1, 3) - (q + np.cross(w, x - origin))).max() < 1e-14


@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_gram_schmidt_is_orthonormal_even_far_away(offset):
    # twice is enough: far from the origin the rotations are nearly translations
    R = rigid_modes(np.random.default_rng(5).normal(size=(30, 3)) + offset, (0.0, 0.0, 0.0))
    Q = gram_schmidt(R)
    assert Q.shape == R.shape
    assert np.abs(Q.T @ Q - np.eye(6)).max() < 1e-14
    # and spans the same space, to the rounding that the offset leaves
    assert np.abs(R - Q @ (Q.T @ R)).max() < 1e-15 * max(1.0, offset) * 10


def test_gram_schmidt_drops_dependent_columns():
    R = np.random.default_rng(6).normal(size=(10, 3))
    dependent = np.column_stack([R, R[:, 0] - 2 * R[:, 2], np.zeros(10)])
    assert gram_schmidt(dependent).shape == (10, 3)
    assert gram_schmidt(np.zeros((5, 2))).shape == (5, 0)


@pytest.mark.parametrize(
    ("rows", "free"),
    [
        ([], "x y z rx ry rz"),
        ([[0, 0, 1, 0, 0, 0]], "x y rx ry rz"),
        ([[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 0, 1]], "z rx ry"),
        (np.eye(6), ""),
    ],
)
def test_unresisted_pure_components(rows, free):
    modes = null_space(np.array(rows, dtype=float).reshape(-1, 6), 3.0)
    names = [COMPONENTS[k] for k in np.argmax(np.abs(modes), axis=0)]
    assert sorted(names) == sorted(free.split())
    assert ((np.abs(modes) > 1e-12).sum(axis=0) == 1).all()


def test_unresisted_hinge_through_another_point():
    # nodes of a line along x held: the turn about that line is free, however far the reference point is
    line = np.column_stack([np.linspace(0, 1, 5), np.full(5, 7.0), np.full(5, -2.0)])
    modes = null_space(rigid_modes(line, (0.0, 0.0, 0.0)), 1.0)
    assert modes.shape == (6, 1)
    assert np.abs(rigid_modes(line, (0.0, 0.0, 0.0)) @ modes).max() < 1e-12


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        ([0, 0, -2, 0, 0, 0], "translation along z"),
        ([1, 1, 0, 0, 0, 0], "translation along (0.707, 0.707, 0)"),
        ([0, 0, 0, 3, 0, 0], "rotation about x through (1, 2, 3)"),
        # turning about z through (2, 2, .) moves the reference point (1, 2, 3) along -y
        ([0, -1, 0, 0, 0, 1], "rotation about z through (2, 2, 3)"),
        ([0, 0, 5, 0, 0, 1], "rotation about z through (1, 2, 3), with 5 of translation along it per radian"),
        ([0, 0, 1, 0, 0, 1e-12], "translation along z"),
    ],
)
def test_describe_motion(motion, words):
    assert describe_motion(motion, (1.0, 2.0, 3.0), 1.0) == words
