"""Meshes that must be refused, each with a message that names the place."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import Mesh, MeshError
from fecontact.mesh.check import check_mesh


def block(element="hex20"):
    return fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element=element)


def with_cells(mesh, cells):
    return Mesh(mesh.points, cells)


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_good_meshes_pass(curved, element):
    check_mesh(curved(element))


@pytest.mark.parametrize("kind", ["one edge", "wedge", "pyramid", "tetrahedron"])
def test_degenerate_cells_pass(degenerate, kind):
    check_mesh(degenerate(kind))


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_left_handed_cell_is_named(element):
    mesh = block(element)
    mirror = [4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19, 20, 21, 22, 23, 25, 24, 26]
    cells = mesh.cells.copy()
    cells[5] = cells[5][mirror[: cells.shape[1]]]
    with refused(MeshError, "folded-cell", "Cell 5", "left-handed"):
        check_mesh(with_cells(mesh, cells))


def test_folded_cell_is_named():
    mesh = block("hex8")
    points = mesh.points.copy()
    # one corner of the block pushed through the opposite side of its cell
    corner = np.flatnonzero((points == 1).all(axis=1))[0]
    points[corner] = (0.3, 0.3, 0.3)
    cell = np.flatnonzero((mesh.cells == corner).any(axis=1))[0]
    with refused(MeshError, "folded-cell", f"Cell {cell} "):
        check_mesh(Mesh(points, mesh.cells))


def test_flat_cell_is_refused():
    mesh = block("hex8")
    with pytest.raises(MeshError):
        check_mesh(mesh.mapped(lambda x: x * [1.0, 1.0, 0.0]))


def test_unused_points():
    mesh = block()
    with refused(MeshError, "unused-points", f"point {len(mesh.points)}."):
        check_mesh(Mesh(np.concatenate([mesh.points, [[5.0, 5.0, 5.0]]]), mesh.cells))


def test_doubled_points():
    mesh = block("hex8")
    twice = Mesh(
        np.concatenate([mesh.points, mesh.translated((1.0, 0.0, 0.0)).points]),
        np.concatenate([mesh.cells, mesh.cells + len(mesh.points)]),
    )
    with refused(MeshError, "double-points", "9 pairs"):
        check_mesh(twice)


def moved_mid_edge(along):
    """A block with the mid-edge node between nodes 0 and 1 of its first cell moved along its edge."""
    mesh = block()
    points = mesh.points.copy()
    a, b, middle = mesh.cells[0, [0, 1, 8]]
    points[middle] = points[a] + along * (points[b] - points[a])
    return Mesh(points, mesh.cells)


@pytest.mark.parametrize("along", [0.2, 0.25, 0.76])
def test_mid_edge_node_beyond_the_quarter_points(along):
    with refused(MeshError, "mid-edge-node", "Cell 0", "node 8"):
        check_mesh(moved_mid_edge(along))


def test_mid_edge_node_within_the_quarter_points_passes():
    check_mesh(moved_mid_edge(0.35))


def test_bulging_mid_edge_node_far_off_its_edge_is_found():
    # the check along the chord does not see it, the Jacobian does
    mesh = block()
    points = mesh.points.copy()
    middle = mesh.cells[0, 8]
    points[middle, 1:] += 1.2
    with refused(MeshError, "folded-cell", "folded or inverted"):
        check_mesh(Mesh(points, mesh.cells))
