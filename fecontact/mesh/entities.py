"""Edges and faces of cells as integer keys, equal for the same edge or face, for fast sorting and searching."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import IntArray
from fecontact.mesh.element.hexahedron import FACES

#: Odd constants (fractional parts of square roots) to hash the corners of a face into one number.
MIX = np.array([0x6A09E667F3BCC909, 0xBB67AE8584CAA73B, 0x3C6EF372FE94F82B, 0xA54FF53A5F1D36F1], dtype=np.uint64)

Keys = NDArray[np.uint64]


def edge_keys(ends: IntArray) -> Keys:
    """Keys (...) of edges with ends (..., 2), in either order.

    Examples
    --------
    >>> bool(edge_keys(np.array([3, 5])) == edge_keys(np.array([5, 3])))
    True
    """
    low, high = ends.min(axis=-1).astype(np.uint64), ends.max(axis=-1).astype(np.uint64)
    return np.asarray((low << np.uint64(32)) | high)


def corner_keys(corners: IntArray) -> IntArray:
    """Sorted corners (n, 4) of faces, equal for equal faces.

    A triangle may list a different one of its corners twice in each of its two cells, so the largest is repeated. Faces
    collapsed to a line or a point get -1.
    """
    ordered = np.sort(corners, axis=1)
    first = np.concatenate([np.ones((len(ordered), 1), bool), ordered[:, 1:] != ordered[:, :-1]], axis=1)
    count = first.sum(axis=1)
    triangle = count == 3
    three = ordered[triangle][first[triangle]].reshape(-1, 3)
    ordered[triangle] = np.concatenate([three, three[:, -1:]], axis=1)
    ordered[count < 3] = -1
    return ordered


def face_keys(corners: IntArray) -> Keys:
    """Keys (...) of faces with corners (..., 4), in any order; 0 for faces collapsed to a line or a point.

    Hashes (sums of sorted corners times odd constants modulo 2^64) sort ten times faster than rows of corners.
    """
    keys = corner_keys(corners.reshape(-1, 4))
    mixed = (keys.astype(np.uint64) * MIX).sum(axis=1, dtype=np.uint64)
    return np.where(keys[:, 0] < 0, np.uint64(0), mixed).reshape(corners.shape[:-1])


def cells_at_faces(cells: IntArray) -> IntArray:
    """Number of cells at each face (n_cells, 6); 0 where the face has collapsed to a line or a point."""
    keys = face_keys(cells[:, FACES[:, :4]])
    _, inverse, count = np.unique(keys, return_inverse=True, return_counts=True)
    return np.where(keys == 0, 0, count[inverse].reshape(keys.shape))


def found(keys: Keys, among: Keys) -> IntArray:
    """Index of each of the keys (...) in `among` (n,); -1 if it is not there.

    Examples
    --------
    >>> found(np.array([4, 9], dtype=np.uint64), np.array([7, 4, 2], dtype=np.uint64)).tolist()
    [1, -1]
    """
    if len(among) == 0:
        return np.full(keys.shape, -1)
    order = np.argsort(among)
    place = order[np.minimum(np.searchsorted(among, keys, sorter=order), len(among) - 1)]
    return np.where(among[place] == keys, place, -1)
