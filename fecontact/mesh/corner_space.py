"""Linear functions on the corners of a mesh, as functions of all its nodes."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import IntArray
from fecontact.mesh.element import FACES, hex_nodes, hex_shapes
from fecontact.mesh.mesh import Mesh


def corner_space(mesh: Mesh) -> tuple[IntArray, sp.csr_matrix]:
    """The corner nodes (k,) and the weights (n_points, k) of trilinear functions on them at all nodes.

    A node on an edge, a face or in a cell gets the value of its cell's trilinear function there: the mean of the
    corners of that edge, face or cell. In degenerate cells repeated corners count as often as they occur; a mid-face
    node on three corners has a third of each.

    Examples
    --------
    >>> from fecontact.mesh.shapes import block
    >>> corners, weights = corner_space(block((1.0, 1.0, 1.0), (1, 1, 1), element="hex20"))
    >>> len(corners), weights.shape, weights.sum(axis=1).min() == weights.sum(axis=1).max() == 1.0
    (8, (20, 8), np.True_)
    """
    n_points, cells = len(mesh.points), mesh.cells
    corners = np.unique(cells[:, :8])
    local = hex_nodes(cells.shape[1])[8:]
    at = hex_shapes(8, local)[0] if len(local) else np.zeros((0, 8))
    others, first = np.unique(cells[:, 8:], return_index=True)
    kept = ~np.isin(others, corners)
    others, first = others[kept], first[kept]
    owner, place = np.divmod(first, max(cells.shape[1] - 8, 1))
    rows = [corners, np.repeat(others, 8)]
    columns = [corners, cells[owner, :8].ravel()]
    values = [np.ones(len(corners)), at[place].ravel()]
    if mesh.midface is not None:
        cell, face = np.nonzero(mesh.midface >= 0)
        ends = np.sort(cells[cell[:, None], FACES[face, :4]], axis=1)
        distinct = np.concatenate([np.ones((len(ends), 1), bool), ends[:, 1:] != ends[:, :-1]], axis=1)
        rows.append(np.repeat(mesh.midface[cell, face], distinct.sum(axis=1)))
        columns.append(ends[distinct])
        values.append(np.repeat(1.0 / distinct.sum(axis=1), distinct.sum(axis=1)))
    number = np.full(n_points, -1, dtype=np.int64)
    number[corners] = np.arange(len(corners))
    entries = (np.concatenate(rows), number[np.concatenate(columns)])
    return corners, sp.csr_matrix((np.concatenate(values), entries), shape=(n_points, len(corners)))
