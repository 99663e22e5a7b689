"""Tables of the division of single cells."""

import numpy as np
import pytest
from refusals import refused

from fecontact import MeshError
from fecontact.mesh.cell_division import HEXAHEDRON, cell_division, divisible, section_division, star
from fecontact.mesh.element import PYRAMID, TETRAHEDRON, WEDGE

ONE_EDGE = tuple(np.where(np.isin(np.arange(20), [2, 9]), 1, np.arange(20)).tolist())
# shape functions of size one
ROUNDING = 1e-14


@pytest.mark.parametrize(
    ("pattern", "lattice", "children", "edges", "quads", "triangles"),
    [
        # points of a lattice: all multiples of a half (8 nodes) or of a quarter that are corners or lie between two
        (HEXAHEDRON[:8], 27, 8, 12, 6, 0),
        (HEXAHEDRON[:20], 27 + 54, 8, 12, 6, 0),
        (HEXAHEDRON, 125, 8, 12, 6, 0),
        (WEDGE[:8], 18, 8, 9, 3, 2),
        # 6 x 3 corners; 9 edges below, half way and above... of each triangle mesh, and 6 x 2 upright ones
        (WEDGE, 18 + 3 * 9 + 6 * 2, 8, 9, 3, 2),
        (TETRAHEDRON[:8], 10, 8, 6, 0, 4),
        # the uniform mesh of half the size has 4 + 6 + 6 * 2 + 4 * 3 nodes on edges and faces, and one on the diagonal
        (TETRAHEDRON, 4 + 6 + 12 + 12 + 1, 8, 6, 0, 4),
        (PYRAMID[:8], 14, 10, 8, 1, 4),
    ],
)
def test_counts(pattern, lattice, children, edges, quads, triangles):
    table = cell_division(pattern)
    assert len(table.own) == lattice
    assert table.children.shape == (children, len(pattern))
    assert (len(table.edges), len(table.quads), len(table.triangles)) == (edges, quads, triangles)
    assert np.abs(table.shapes.sum(axis=1) - 1).max() < ROUNDING
    assert (table.facets >= 0).all(axis=2).sum() == 4 * (quads + triangles)
    # whatever is new is numbered once
    new = np.concatenate([table.inner, *(s[:, 0] for s in table.shared)])
    assert sorted(new) == np.flatnonzero(table.own < 0).tolist()


def test_a_point_lies_on_what_its_parents_functions_do_not_vanish_on():
    # functions of nodes off an edge or face vanish on it
    for pattern in (HEXAHEDRON[:8], HEXAHEDRON[:20], HEXAHEDRON, WEDGE, TETRAHEDRON, PYRAMID):
        table = cell_division(pattern)
        assert np.abs(table.shapes[~table.entity]).max() < ROUNDING


def test_tetrahedra_have_three_diagonals():
    tables = [cell_division(TETRAHEDRON, k) for k in range(3)]
    sets = [{tuple(sorted(c)) for c in (np.round(t.shapes @ np.arange(10), 9)[t.children]).tolist()} for t in tables]
    assert len(set.union(*sets)) == 4 + 3 * 4


@pytest.mark.parametrize("width", [8, 9])
def test_sections(width):
    table = section_division(width)
    assert table.children.shape == (4, width)
    assert table.facets.shape == (4, 2, 2)
    assert len(table.own) == {8: 21, 9: 25}[width]
    assert np.abs(table.shapes.sum(axis=1) - 1).max() < ROUNDING


def test_stars():
    assert not divisible(ONE_EDGE)
    assert all(divisible(p) for p in (HEXAHEDRON, WEDGE, PYRAMID, TETRAHEDRON))
    with refused(MeshError, "mesh", "to a star first"):
        cell_division(ONE_EDGE)
    table = star(ONE_EDGE)
    assert len(table.children) == 6
    assert table.facets.shape == (6, 1, 2)
    assert (len(table.edges), len(table.quads), len(table.triangles)) == (0, 0, 0)
    # the centre and what lies between it and the seven corners
    assert (table.own < 0).sum() == 8
