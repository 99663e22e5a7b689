"""Hanging nodes: ties with closed chains, and what the verbs of meshes make of them."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact import InputError, MeshError, merge
from fecontact.ancf import AncfSpace
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.mesh.refine import divided
from fecontact.mesh.section_mesh import merge_sections

# products of a few weights of size one
ROUNDING = 1e-14


def rows(n_points, *ties):
    """Rows of weights from mappings of point to weight."""
    dense = np.zeros((len(ties), n_points))
    for k, tie in enumerate(ties):
        dense[k, list(tie)] = list(tie.values())
    return sp.csr_matrix(dense)


def hanging_block():
    """A block whose point 1 is declared to hang in the middle of points 0 and 2; only the ties count here."""
    block = fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8")
    ends = np.flatnonzero((block.points[:, 1:] == 0).all(axis=1))
    a, m, b = ends[np.argsort(block.points[ends, 0])]
    return replace(
        block,
        hanging=HangingNodes(np.array([m]), rows(len(block.points), {a: 0.5, b: 0.5}), np.array([[a, m, b, -1, -1]])),
    )


def test_transform_gives_all_points_from_the_free_ones():
    hanging = HangingNodes(np.array([3, 1]), rows(5, {0: 0.25, 4: 0.75}, {0: 0.5, 2: 0.5}))
    assert hanging.free.tolist() == [0, 2, 4]
    u = np.array([3.0, 5.0, -1.0])
    full = hanging.transform @ u
    assert full[hanging.free].tolist() == u.tolist()
    assert np.abs(full[[3, 1]] - [0.25 * 3 - 0.75, 4.0]).max() < ROUNDING
    assert np.abs(hanging.followed(np.array([3.0, 99.0, 5.0, 99.0, -1.0])[:, None])[:, 0] - full).max() < ROUNDING


@pytest.mark.parametrize("length", [1, 2, 3, 7, 8, 30])
def test_chains_are_closed(length):
    # point k halfway between point k - 1 and the last: 1 - 2^-k of the way
    n = length + 2
    raw = rows(n, *({k - 1: 0.5, n - 1: 0.5} for k in range(1, n - 1)))
    hanging = HangingNodes.closed(np.arange(1, n - 1), raw)
    expected = 1 - 0.5 ** np.arange(1, n - 1)
    assert hanging.free.tolist() == [0, n - 1]
    assert np.abs(hanging.weights[:, [n - 1]].toarray()[:, 0] - expected).max() < ROUNDING
    assert np.abs(hanging.transform @ np.ones(2) - 1).max() < ROUNDING


def test_circles_chains_and_wrong_sums_are_refused():
    with refused(MeshError, "hanging-circle"):
        HangingNodes.closed(np.array([0, 1]), rows(3, {1: 0.5, 2: 0.5}, {0: 0.5, 2: 0.5}))
    with refused(MeshError, "mesh", "follows from another"):
        HangingNodes(np.array([0, 1]), rows(3, {2: 1.0}, {0: 0.5, 2: 0.5}))
    with refused(MeshError, "hanging-weights", "node 1", "0.1"):
        HangingNodes(np.array([1]), rows(3, {0: 0.5, 2: 0.6}))
    with refused(MeshError, "hanging-shape", "1"):
        HangingNodes(np.array([1, 1]), rows(3, {0: 1.0}, {2: 1.0}))
    with refused(MeshError, "hanging-points", "... 2"):
        HangingNodes(np.array([1]), rows(3, {0: 1.0}), np.array([[0, 1, 7, -1, -1]]))
    with refused(MeshError, "hanging-points", "... 2"):
        HangingNodes(np.array([-1]), rows(3, {0: 1.0}))
    with refused(MeshError, "hanging-points", "... 2"):
        HangingNodes(np.array([1]), rows(3, {0: 1.0}), np.array([[0, 1, 2, -1, -2]]))


def test_a_hanging_node_lies_where_it_follows_but_for_rounding():
    mesh = hanging_block().translated((1000.0, 0.0, 0.0))
    m = mesh.hanging.nodes[0]

    def moved(by):
        points = mesh.points.copy()
        points[m, 1] += by
        return replace(mesh, points=points)

    assert moved(1e-10).points[m, 1] == mesh.points[m, 1] + 1e-10  # a few units of the last digit of 1000
    with refused(MeshError, "hanging-off-place", "1e-07"):
        moved(1e-7)


def test_a_mesh_refuses_ties_of_another():
    ties = HangingNodes(np.array([1]), rows(3, {0: 0.5, 2: 0.5}))
    with refused(MeshError, "hanging-points", "of 3", "has 8"):
        replace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"), hanging=ties)
    with refused(MeshError, "hanging-points", "of 3", "has 8"):
        replace(fc.sections.rectangle((1.0, 1.0), (1, 1)), hanging=ties)


def test_verbs_that_keep_points_keep_the_ties():
    mesh = hanging_block()
    ties = mesh.hanging
    for other in (
        mesh.translated((1.0, 0.0, 0.0)),
        mesh.scaled(2.0),
        mesh.with_boundary("low", lambda x: x[:, 2] == 0),
        mesh.with_group("half", lambda x: x[:, 0] < 1),
        pickle.loads(pickle.dumps(mesh)),
        copy.deepcopy(mesh),
    ):
        assert (other.hanging.nodes == ties.nodes).all()
        assert (other.hanging.weights != ties.weights).nnz == 0
        assert (other.hanging.edges == ties.edges).all()


def test_a_hanging_node_follows_when_the_others_are_moved():
    mesh = hanging_block().mapped(lambda x: x * [1, 1, 1] + [0, 0, 1] * x[:, :1] ** 2)
    a, m, b = mesh.hanging.edges[0, :3]
    assert np.abs(mesh.points[m] - (mesh.points[a] + mesh.points[b]) / 2).max() < ROUNDING


def test_midface_nodes_are_free_points():
    quadratic = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
    a, m, b = quadratic.cells[0, [0, 8, 1]]
    mesh = replace(quadratic, hanging=HangingNodes(np.array([m]), rows(len(quadratic.points), {a: 0.5, b: 0.5})))
    more = mesh.with_midface_nodes(("top",))
    assert more.hanging.n_points == len(mesh.points) + 1
    assert more.hanging.nodes.tolist() == [m]
    assert more.hanging.free[-1] == len(mesh.points)


def test_merging_renumbers_the_ties_and_refuses_joints_at_hanging_nodes():
    mesh = hanging_block()
    far = mesh.translated((9.0, 0.0, 0.0))
    whole = merge([far, mesh], 1e-9)
    assert len(whole.hanging.nodes) == 2
    for a, m, b in whole.hanging.edges[:, :3]:
        assert np.abs(whole.points[m] - (whole.points[a] + whole.points[b]) / 2).max() < ROUNDING
    assert np.abs(whole.hanging.followed(whole.points) - whole.points).max() < ROUNDING
    assert merge([fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")], 1e-9).hanging is None
    with refused(MeshError, "hanging-at-joint", "1 hanging", "mesh 0"):
        merge([mesh, replace(mesh, hanging=None).mapped(lambda x: x * [1, -1, 1])], 1e-9)


def test_merged_sections_keep_their_ties():
    section = fc.sections.rectangle((1.0, 1.0), (1, 1))
    a, b, m = section.cells[0, [0, 1, 4]]
    tied = replace(section, hanging=HangingNodes(np.array([m]), rows(8, {a: 0.5, b: 0.5})))
    whole = merge_sections([section, tied.translated((3.0, 0.0, 0.0))], 1e-9)
    assert np.abs(whole.points[whole.hanging.nodes] - [[3.5, 0, 0]]).max() < ROUNDING
    assert np.abs(whole.hanging.followed(whole.points) - whole.points).max() < ROUNDING
    assert pickle.loads(pickle.dumps(whole)).hanging.n_points == len(whole.points)
    bent = tied.mapped(lambda x: x + [0, 0, 0.1] * (x[:, :1] - 0.5))
    assert np.abs(bent.points[m] - (bent.points[a] + bent.points[b]) / 2).max() < ROUNDING


def test_what_makes_no_sense_with_hanging_nodes_is_refused():
    mesh = hanging_block().with_group("all", lambda x: x[:, 0] > -1)
    with refused(InputError, "hanging-not-possible", "with 1", "given more nodes"):
        mesh.upgraded(20)
    with refused(InputError, "hanging-not-possible", "cut into parts"):
        mesh.part("all")
    with refused(InputError, "hanging-not-possible", "turned into one of scikit-fem"):
        mesh.to_skfem()
    with refused(InputError, "hanging-not-possible", "turned into a surface mesh"):
        fc.SurfaceMesh.of(mesh, "top")
    with refused(InputError, "hanging-not-possible", "divided into hexahedra"):
        divided(mesh)
    with refused(InputError, "hanging-not-possible", "used with gradient coordinates"):
        AncfSpace(mesh)
