"""Edges and faces as numbers."""

import numpy as np

import fecontact as fc
from fecontact.mesh.element import FACES
from fecontact.mesh.facets import cells_at_faces, edge_keys, face_keys, found


def test_edges_are_told_by_their_ends_in_either_order():
    ends = np.array([[[0, 1], [1, 0]], [[7, 2**31], [2**31, 7]]])
    keys = edge_keys(ends)
    assert keys.shape == (2, 2)
    assert (keys[:, 0] == keys[:, 1]).all()
    assert len(np.unique(edge_keys(np.stack(np.triu_indices(60), axis=1)))) == 60 * 61 // 2


def test_faces_are_told_by_their_corners_in_any_order_and_triangles_however_they_repeat():
    assert len(set(face_keys(np.array([[4, 9, 2, 7], [9, 2, 7, 4], [7, 2, 9, 4]])).tolist())) == 1
    assert len(set(face_keys(np.array([[4, 9, 2, 2], [2, 4, 4, 9], [9, 9, 2, 4]])).tolist())) == 1
    assert face_keys(np.array([[4, 9, 9, 4], [3, 3, 3, 3]])).tolist() == [0, 0]
    assert len(set(face_keys(np.array([[4, 9, 2, 2], [4, 9, 2, 7], [4, 9, 9, 9]])).tolist())) == 3


def test_faces_of_a_block_are_outer_or_between_two():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 4, 5), element="hex8")
    count = cells_at_faces(mesh.cells)
    assert (count == 1).sum() == 2 * (12 + 15 + 20)
    assert (count == 2).sum() == 6 * 60 - 94
    _, alike = np.unique(np.sort(mesh.cells[:, FACES[:, :4]].reshape(-1, 4), axis=1), axis=0, return_inverse=True)
    assert (np.bincount(alike.ravel())[alike.ravel()] == count.ravel()).all()


def test_keys_are_found_or_not():
    keys = edge_keys(np.array([[1, 2], [5, 6], [3, 4]]))
    assert found(keys[[[2, 0], [1, 1]]], keys).tolist() == [[2, 0], [1, 1]]
    assert found(keys, keys[:1]).tolist() == [0, -1, -1]
    assert found(keys, keys[:0]).tolist() == [-1, -1, -1]
