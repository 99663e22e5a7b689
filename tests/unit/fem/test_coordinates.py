"""Coordinates that a stiffness is solved in: turned axes, hanging nodes, and both."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from hanging_meshes import SPATIAL, joined, part, section_step, stairs, step
from refusals import refused

import fecontact as fc
from fecontact import InputError, MeshError
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.coordinates import restricted
from fecontact.fem.model import Model

# sums of a few hundred products
ROUNDING = 1e-12
TILTED = {"x_min": (1, 0, 1), "y_max": "n", "bottom": "z"}


def dense(coordinates, n_dofs):
    """T, column by column."""
    return coordinates.displacements(np.eye(coordinates.count(n_dofs)))


@pytest.fixture(params=["none", "hanging", "turned", "both"])
def model(request, steel):
    hanging, turned = request.param in ("hanging", "both"), request.param in ("turned", "both")
    mesh = stairs("hex20") if hanging else fc.shapes.block((1.0, 1.2, 0.9), (2, 2, 1))
    return Model(mesh.mapped(lambda x: x @ np.diag([1.0, 0.8, 1.3])), steel, TILTED if turned else {"bottom": "xyz"})


def test_everything_is_one_transform(model):
    c, rng = model.coordinates, np.random.default_rng(3)
    T = dense(c, model.n_dofs)
    assert T.shape == (model.n_dofs, model.n_coordinates)
    v, f = rng.normal(size=model.n_coordinates), rng.normal(size=model.n_dofs)
    u = T @ v
    assert np.abs(c.of_displacements(u) - v).max() < ROUNDING
    assert np.abs(c.of_displacements(np.stack([u, 2 * u], axis=1)) - np.stack([v, 2 * v], axis=1)).max() < ROUNDING
    assert np.abs(c.forces(f) - T.T @ f).max() < ROUNDING
    assert np.abs(c.rows(sp.csr_matrix(f)) - T.T @ f).max() < ROUNDING
    assert abs(c.row_on_displacements(v) @ u - v @ v) < ROUNDING * (v @ v)
    # forces gathered on the nodes that do not hang do the same work in any motion
    assert np.abs(T.T @ c.gathered(f) - T.T @ f).max() < ROUNDING
    if c.ties is not None:
        assert not c.gathered(f).reshape(-1, 3)[c.ties.nodes].any()
    K = model.stiffness
    whole = (K + sp.triu(K, 1).T).toarray()
    expected = np.triu(T.T @ whole @ T)
    found = c.stiffness(K)
    assert found.has_sorted_indices
    assert np.abs(found.toarray() - expected).max() < ROUNDING * np.abs(expected).max()


def test_the_solution_is_that_of_the_dense_equations(model):
    T = dense(model.coordinates, model.n_dofs)[:, model.solved_dofs]
    K = model.stiffness
    whole = (K + sp.triu(K, 1).T).toarray()
    f = model.body_force(lambda x: np.cos(x)) - model.traction("top", lambda x, n: n)
    expected = T @ np.linalg.solve(T.T @ whole @ T, T.T @ f)
    found = model.displacements(model.condensed(np.arange(3), Stopwatch()).solve(model.solved_forces(f)))
    assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max()  # the condition of K
    row = sp.csr_matrix(np.eye(1, model.n_dofs, model.n_dofs - 1))
    assert np.abs(model.solved_rows(row).toarray()[0] - T[-1]).max() < ROUNDING
    touched = np.flatnonzero(np.abs(dense(model.coordinates, model.n_dofs)[-1]) > 0)
    assert set(model.touched(row)) == set(touched // 3)


@pytest.mark.parametrize("kind", [*SPATIAL])
def test_rigid_motions_cost_nothing(kind, steel):
    model = Model(stairs(kind).translated((3.0, -1.0, 2.0)), steel, {})
    K = model.coordinates.stiffness(model.stiffness)
    R = model.nodal_modes
    assert np.abs(model.coordinates.displacements(R) - model.rigid_modes).max() < ROUNDING * np.abs(R).max()
    # rounding of the stiffness's own entries
    assert np.abs(K @ R + sp.triu(K, 1).T @ R).max() < 1e-11 * np.abs(K).max() * np.abs(R).max()
    assert model.free_motions.shape == (6, 6)
    assert len(model.pinned_dofs) == 6
    assert model.n_unknowns == model.n_coordinates == 3 * len(model.mesh.hanging.free)


def test_a_section_has_two_unknowns_for_each_node_that_does_not_hang():
    mesh = section_step("quad8")
    body = fc.PlaneBody(mesh, fc.Material(E=1.0, nu=0.3), supports={"bottom": "xz"})
    assert body.model.n_unknowns == 2 * len(mesh.hanging.free)
    ring = fc.AxisymmetricBody(mesh, fc.Material(E=1.0, nu=0.3), supports={"bottom": "z"})
    on_axis = (mesh.points[mesh.hanging.free, 0] == 0).sum()
    n = len(mesh.hanging.free)
    assert len(ring.model.held) == n + on_axis + len(np.intersect1d(mesh.boundary_nodes("bottom"), mesh.hanging.free))
    assert ring.free_motions.shape[1] == 0


def test_a_support_holds_what_hanging_nodes_follow(steel):
    mesh = step("hex20")
    Model(mesh, steel, {"bottom": "xyz", "x_max": "n"})
    # of the bottom only the small faces between the coarse ones' middle and end
    small = mesh.faces("bottom")
    corners = mesh.points[mesh.cells[small[:, 0], :8]]
    inside = (corners[:, :, 1].min(axis=1) >= 1.5) & (corners[:, :, 0].min(axis=1) >= 1)
    assert inside.any()
    part_of_it = replace(mesh, boundaries={**mesh.boundaries, "patch": small[inside]})
    with refused(InputError, "hanging-support", "'patch'"):
        Model(part_of_it, steel, {"patch": "z"})
    nodes = replace(mesh, node_sets={"one": mesh.hanging.nodes[:1], "free": mesh.hanging.free[:1]})
    Model(nodes, steel, {"free": "xyz"})
    with refused(InputError, "hanging-support", "'one'", "holds 1"):
        Model(nodes, steel, {"one": "xyz"})
    section = section_step("quad8")
    sets = replace(section, node_sets={"one": section.hanging.nodes[:1]})
    with refused(InputError, "hanging-support", "'one'", "holds 1"):
        fc.PlaneBody(sets, steel, supports={"one": "xz"})


def test_hanging_nodes_lie_where_they_follow(steel):
    mesh = step("hex8")
    moved = mesh.points.copy()
    moved[mesh.hanging.nodes[0]] += [0.0, 0.0, 1e-6]
    with refused(MeshError, "hanging-off-place"):
        replace(mesh, points=moved)


def test_parts_of_a_mesh_without_connection_are_told_of_hanging_nodes_or_not(steel):
    one = step("hex20")
    other = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)).translated((5.0, 0.0, 0.0))
    both = fc.mesh.mesh.merge([one, replace(other, boundaries={"far": other.faces("bottom")})], 1e-9)
    with refused(MeshError, "several-parts", "has 2"):
        Model(both, steel, {"bottom": "xyz"})
    Model(both, steel, {"bottom": "xyz", "far": "xyz"})


@pytest.mark.parametrize("backend", ["pardiso", "superlu", "amg"])
def test_backends_agree(backend, steel):
    pytest.importorskip({"pardiso": "pypardiso", "superlu": "scipy", "amg": "pyamg"}[backend])
    body = fc.ElasticBody(stairs("hex20"), steel, supports={"x_min": "xyz"}, backend=backend)
    f = body._boundary_force("x_max", np.array([1.0, 2.0, -1.0]))
    u = body.displacement(sp.csr_matrix((0, body.n_dofs)), np.zeros(0), f)
    reference = fc.ElasticBody(stairs("hex20"), steel, supports={"x_min": "xyz"}, condensation="columns")
    expected = reference.displacement(sp.csr_matrix((0, body.n_dofs)), np.zeros(0), f)
    assert np.abs(u - expected).max() < 1e-9 * np.abs(expected).max()
    again = pickle.loads(pickle.dumps(body))
    assert np.array_equal(again.displacement(sp.csr_matrix((0, body.n_dofs)), np.zeros(0), f), u) or backend == "amg"


def test_rows_of_a_triangle_that_are_empty_stay_so():
    K = sp.csr_matrix(np.triu([[2.0, 0, 1], [0, 0, 0], [0, 0, 3]]))
    assert restricted(K, np.array([1, 2])).toarray().tolist() == [[0, 0], [0, 3]]
    assert restricted(K, np.array([0, 1])).toarray().tolist() == [[2, 0], [0, 0]]


def test_cells_of_two_kinds_in_a_block_with_hanging_nodes(steel):
    # small wedges beside large hexahedra: the ties are those of the large faces
    mesh = joined(part("hex20", (0, 0, 0), (1, 1, 1), (1, 1, 1)), part("wedge15", (1, 0, 0), (2, 1, 1), (2, 2, 2)))
    model = Model(mesh, steel, {})
    assert model.free_motions.shape == (6, 6)
    assert set(mesh.kinds) == {"hex20", "wedge15"}
