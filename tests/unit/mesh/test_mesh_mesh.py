"""Mesh: its arrays, faces, boundaries and verbs."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError, Mesh, MeshError, merge
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.check import check_mesh
from fecontact.mesh.element import FACES, hex_nodes

# sums of a few hundred volumes of size one
ROUNDING = 1e-13


def block(element="hex20", divisions=(2, 2, 2)):
    return fc.shapes.block((1.0, 1.0, 1.0), divisions, element=element)


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_upgraded_counts_and_shared_nodes(element):
    # nodes of an n x n x n lattice: corners, edges, faces, cells counted once each
    n = 3
    corners, edges, faces, cells = (n + 1) ** 3, 3 * n * (n + 1) ** 2, 3 * n * n * (n + 1), n**3
    expected = {"hex8": corners, "hex20": corners + edges, "hex27": corners + edges + faces + cells}[element]
    mesh = block(element, (n, n, n))
    assert len(mesh.points) == expected
    check_mesh(mesh)
    assert abs(moments_of_volume(mesh)[0] - 1) < ROUNDING
    assert (
        np.abs(mesh.points[mesh.cells] - mesh.points[mesh.cells[:, :8]].mean(axis=1)[:, None]).max() <= 0.5 / n + 1e-15
    )


def test_upgraded_refuses_what_it_cannot_do(degenerate):
    with refused(InputError, "input", "hex20"):
        block("hex20").upgraded(27)
    with refused(InputError, "degenerate"):
        degenerate("wedge", 8).upgraded(27)


def test_outer_faces_of_a_block_and_their_names():
    mesh = block()
    assert len(mesh.outer_faces) == 6 * 4
    named = np.concatenate([mesh.faces(n) for n in mesh.boundaries])
    assert sorted(map(tuple, named)) == sorted(map(tuple, mesh.outer_faces))
    for name, axis, value in (("x_min", 0, 0), ("x_max", 0, 1), ("y_min", 1, 0), ("y_max", 1, 1), ("bottom", 2, 0)):
        assert (mesh.points[mesh.boundary_nodes(name)][:, axis] == value).all()


@pytest.mark.parametrize(("kind", "count"), [("one edge", 6), ("wedge", 5), ("pyramid", 5), ("tetrahedron", 4)])
def test_outer_faces_of_degenerate_cells(degenerate, kind, count):
    assert len(degenerate(kind).outer_faces) == count


def test_two_wedges_share_their_inner_face():
    # a cube cut along a diagonal plane into two wedges: 2 triangles and 2 squares of each are outer
    x = hex_nodes(8)
    mesh = Mesh(x, np.array([[0, 1, 3, 3, 4, 5, 7, 7], [1, 2, 3, 3, 5, 6, 7, 7]]))
    check_mesh(mesh)
    assert len(mesh.outer_faces) == 8
    assert abs(moments_of_volume(mesh)[0] - 1) < ROUNDING


def test_two_tetrahedra_share_their_triangle_however_it_is_listed():
    x = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1.0]])
    mesh = Mesh(x, np.array([[0, 1, 2, 2, 3, 3, 3, 3], [1, 0, 2, 2, 4, 4, 4, 4]]))
    check_mesh(mesh)
    assert len(mesh.outer_faces) == 6


def test_merge_joins_points_boundaries_and_groups():
    left = block().with_group("half", lambda x: x[:, 0] < 0.5)
    right = left.translated((1.0, 0.0, 0.0))
    whole = merge([left, right], 1e-9)
    check_mesh(whole)
    reference = fc.shapes.block((2.0, 1.0, 1.0), (4, 2, 2))
    assert len(whole.points) == len(reference.points)
    assert len(whole.outer_faces) == len(reference.outer_faces)
    assert {n: len(f) for n, f in whole.boundaries.items()} == {n: len(f) for n, f in reference.boundaries.items()}
    assert len(whole.groups["half"]) == 8
    assert abs(moments_of_volume(whole)[0] - 2) < ROUNDING


def test_merge_follows_chains_of_close_points():
    x = hex_nodes(8)
    meshes = [Mesh(x, np.arange(8)[None, :]).translated((k * 1e-7, 0, 0)) for k in range(3)]
    # ends 2e-7 apart, neighbours 1e-7: a chain is one point
    assert len(merge(meshes, 1.5e-7).points) == 8


def test_merge_refuses_to_join_points_of_one_cell():
    # cells of 0.5, nodes in the middles of their edges
    with refused(InputError, "tolerance-too-large", "0.25", "cell 0"):
        merge([block(), block().translated((1.0, 0.0, 0.0))], 0.25)
    assert len(merge([block("hex8"), block("hex8").translated((1.1, 0.0, 0.0))], 0.2).points) == 45


def test_merge_refuses_different_cells():
    with refused(MeshError, "mesh", "hex20", "hex8"):
        merge([block("hex8"), block("hex20")], 1e-9)


def test_with_boundary_and_with_group():
    mesh = block().with_boundary("foot", lambda x: (x[:, 2] == 0) & (x[:, 0] <= 0.5))
    assert len(mesh.faces("foot")) == 2
    assert len(block().with_group("low", lambda x: x[:, 2] < 0.5).groups["low"]) == 4
    with refused(InputError, "empty-boundary", "'nowhere'"):
        block().with_boundary("nowhere", lambda x: x[:, 2] > 5)


def test_unknown_boundary_lists_the_names():
    with refused(InputError, "unknown-boundary", "'lid'", "'x_min'", "'top'"):
        block().faces("lid")


def test_scaled_and_mapped_leave_the_original_alone():
    mesh = block()
    assert np.abs(mesh.scaled(1e-3).points * 1e3 - mesh.points).max() < ROUNDING
    assert mesh.points.max() == 1
    for factor in (0.0, -1.0, np.nan, np.inf):
        with refused(InputError, "not-positive", "A scale"):
            mesh.scaled(factor)


def test_frozen_arrays():
    mesh = block()
    with pytest.raises(ValueError, match=r"read-only"):
        mesh.points[0, 0] = 1.0


def test_bad_arrays():
    x, cell = hex_nodes(8), np.arange(8)[None, :]
    with refused(MeshError, "mesh", "point 3"):
        Mesh(np.where(np.arange(8)[:, None] == 3, np.nan, x), cell)
    with refused(MeshError, "mesh", "point 8", "only 8"):
        Mesh(x, cell + 1)
    with refused(MeshError, "wrong-shape", "(1, 7)"):
        Mesh(x, cell[:, :7])
    with refused(MeshError, "mesh", "(8, 2)"):
        Mesh(x[:, :2], cell)
    with refused(MeshError, "wrong-shape"):
        Mesh(x, np.zeros((0, 8), int))


@pytest.mark.parametrize("bad", [np.array([[0, 6]]), np.array([[1, 0]]), np.array([[-1, 0]]), np.array([0, 1, 2])])
def test_boundaries_that_do_not_exist(bad):
    with refused(MeshError, "boundary-shape", "'lid'"):
        Mesh(hex_nodes(8), np.arange(8)[None, :], {"lid": bad})


def test_groups_that_do_not_exist():
    with refused(MeshError, "mesh", "'core'"):
        Mesh(hex_nodes(8), np.arange(8)[None, :], {}, {"core": np.array([1])})


def test_midface_nodes_only_where_they_belong(degenerate):
    with refused(InputError, "input", "hex27"):
        block("hex27").with_midface_nodes(("top",))
    wedge = degenerate("wedge")
    line = next(f for f in range(6) if len(np.unique(wedge.cells[0][FACES[f, :4]])) == 2)
    named = Mesh(wedge.points, wedge.cells, {"end": np.array([[0, line]])})
    with refused(InputError, "input", "shrunk to a line"):
        named.with_midface_nodes(("end",))


def test_midface_nodes_are_not_doubled():
    mesh = block().with_midface_nodes(("top",))
    again = mesh.with_midface_nodes(("top", "x_min"))
    assert len(mesh.points) == 81 + 4
    assert len(again.points) == 81 + 8
    check_mesh(again)
