"""Degenerate hexahedra and mid-face nodes: what they can represent."""

import itertools

import numpy as np
import pytest

from fecontact import Mesh
from fecontact.fem.rigid import rigid_modes
from fecontact.fem.stiffness import batches
from fecontact.mesh import element as basis
from fecontact.mesh.element import element_basis, hex_nodes, hex_shapes, triangular_faces
from fecontact.mesh.facets import nodal_areas

# sums of some twenty products of size one
ROUNDING = 1e-13
KINDS = ["one edge", "wedge", "pyramid", "tetrahedron"]


def inside(n, seed=2):
    return np.random.default_rng(seed).random((n, 3))


def functions(mesh, X):
    (group,) = mesh.cell_groups
    N, dN = element_basis(mesh.cells.shape[1], group.pattern, group.midfaces, X)
    return N, dN, mesh.points[group.nodes[0]]


def incompleteness(N, nodes, degree):
    """Largest error in reproducing the monomials of a degree in physical coordinates."""
    x = N @ nodes
    errors = []
    for powers in itertools.product(range(degree + 1), repeat=3):
        if sum(powers) == degree:
            errors.append(np.abs(N @ np.prod(nodes**powers, axis=1) - np.prod(x**powers, axis=1)).max())
    return max(errors)


@pytest.mark.parametrize("kind", KINDS)
def test_degenerate_functions_sum_to_one_and_have_their_gradients(degenerate, kind):
    X = inside(20)
    N, dN, _ = functions(degenerate(kind), X)
    assert np.abs(N.sum(axis=1) - 1).max() < ROUNDING
    step = 1e-5
    for k, e in enumerate(np.eye(3)):
        slope = (functions(degenerate(kind), X + step * e)[0] - functions(degenerate(kind), X - step * e)[0]) / step / 2
        assert np.abs(slope - dN[..., k]).max() < 1e-9  # central differences: h^2 and eps/h


@pytest.mark.parametrize("kind", KINDS)
def test_degenerate_functions_are_one_at_their_node_and_zero_at_the_others(degenerate, kind):
    mesh = degenerate(kind)
    (group,) = mesh.cell_groups
    X = hex_nodes(20)[np.unique(group.pattern)]
    N, _, _ = functions(mesh, X)
    assert np.abs(N - np.eye(len(X))).max() < ROUNDING


@pytest.mark.parametrize("kind", ["wedge", "pyramid", "tetrahedron"])
def test_degenerate_elements_hold_every_quadratic_polynomial(degenerate, kind):
    N, _, nodes = functions(degenerate(kind), inside(30))
    assert incompleteness(N, nodes, 2) < ROUNDING


def test_one_coalesced_edge_holds_linear_fields_only(degenerate):
    N, _, nodes = functions(degenerate("one edge"), inside(30))
    assert incompleteness(N, nodes, 1) < ROUNDING
    # stated, not wished for: between a hexahedron and a wedge there is no polynomial space of degree two
    assert incompleteness(N, nodes, 2) > 1e-3


@pytest.mark.parametrize(("kind", "least"), [("wedge", 0.01), ("pyramid", 0.01)])
def test_without_the_correction_quadratic_completeness_fails(degenerate, monkeypatch, kind, least):
    monkeypatch.setattr(basis, "triangular_faces", lambda pattern: [])
    N, _, nodes = functions(degenerate(kind), inside(30))
    assert np.abs(N.sum(axis=1) - 1).max() < ROUNDING
    assert incompleteness(N, nodes, 2) > least


def test_triangular_faces_of_each_kind(degenerate):
    expected = {"one edge": [1, 4], "wedge": [4, 5], "pyramid": [0, 1, 2, 3]}
    for kind, faces in expected.items():
        (group,) = degenerate(kind).cell_groups
        assert [face for face, _ in triangular_faces(group.pattern)] == faces


@pytest.mark.parametrize("kind", KINDS)
def test_faces_between_wedge_pyramid_tetrahedron_hold_quadratics(degenerate, kind):
    # a triangular face must depend on its own six nodes only, or neighbours would not conform
    mesh = degenerate(kind)
    (group,) = mesh.cell_groups
    X = inside(20)
    X[:, 2] = 0.0
    N, _, _ = functions(mesh, X)
    distinct = np.unique(group.pattern)
    lower = np.isin(distinct, [0, 1, 2, 3, 8, 9, 10, 11])
    assert np.abs(N[:, ~lower]).max() < ROUNDING


@pytest.mark.parametrize("kind", KINDS)
def test_degenerate_elements_have_six_zero_modes_and_no_more(degenerate, dense_stiffness, steel, kind):
    mesh = degenerate(kind)
    K = dense_stiffness(mesh, steel)
    values = np.linalg.eigvalsh(K) / np.abs(K).max()
    assert np.abs(values[:6]).max() < 1e-13
    # the softest true deformation of these cells is about 1e-3 of the largest entry
    assert values[6] > 1e-4
    assert np.abs(K @ rigid_modes(mesh.points, mesh.points[0])).max() < 1e-12 * np.abs(K).max()


@pytest.mark.parametrize("width", [8, 20])
@pytest.mark.parametrize("kind", KINDS)
def test_linear_fields_have_constant_gradients(degenerate, kind, width):
    mesh = degenerate(kind, width)
    gradient = np.array([[0.1, -0.2, 0.3], [0.0, 0.4, -0.1], [0.2, 0.1, -0.3]])
    u = mesh.points @ gradient.T
    for batch in batches(mesh):
        found = np.einsum("cqaj,cai->cqij", batch.gradients, u[batch.nodes])
        assert np.abs(found - gradient).max() < 1e-12


def test_midface_node_makes_all_weights_positive():
    mesh = Mesh(hex_nodes(20), np.arange(20)[None, :], {"top": np.array([[0, 5]])})
    plain = nodal_areas(mesh.points, mesh.face_nodes(mesh.faces("top")))
    assert np.abs(plain[4:8] + 1 / 12).max() < ROUNDING
    rich = mesh.with_midface_nodes(("top",))
    weights = nodal_areas(rich.points, rich.face_nodes(rich.faces("top")))
    assert np.abs(weights[4:8] - 1 / 36).max() < ROUNDING
    assert np.abs(weights[12:16] - 4 / 36).max() < ROUNDING
    assert abs(weights[20] - 16 / 36) < ROUNDING


def test_midface_node_lies_on_the_mapped_face(curved):
    mesh = curved().with_midface_nodes(("top", "x_min"))
    for cell, face in np.argwhere(mesh.midface >= 0):
        centre = hex_nodes(27)[20 + face][None, :]
        mapped = hex_shapes(20, centre)[0] @ mesh.points[mesh.cells[cell]]
        assert np.abs(mapped[0] - mesh.points[mesh.midface[cell, face]]).max() < ROUNDING


def test_midface_geometry_is_that_of_twenty_nodes(curved):
    plain, rich = curved(), curved().with_midface_nodes(("top", "bottom"))
    volume = [sum(b.dV.sum() for b in batches(m)) for m in (plain, rich)]
    assert abs(volume[1] / volume[0] - 1) < ROUNDING
