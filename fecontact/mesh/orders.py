"""Cells of different order in one mesh: linear ones get mid-edge nodes, those of their quadratic neighbours first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.mesh.element.hexahedron import EDGES


def same_order(points: Array, parts: Sequence[IntArray]) -> tuple[Array, list[IntArray], IntArray]:
    """Points and cells of 20 nodes, from cells of 8, 20 and 27, and the ends of the edges of the new points.

    The edges of 8-node cells get nodes in their middle, so their geometry stays; where an edge has one already, in a
    cell of 20 nodes, it is taken, so that neighbours fit together. Nodes of faces and centres of 27-node cells are
    dropped.

    Parameters
    ----------
    points : (n_points, 3) array
    parts : sequence of (n, 8 | 20 | 27) int arrays

    Returns
    -------
    points : (n_points + n_new, 3) array
    parts : list of (n, 20) int arrays
    ends : (n_new, 2) int array

    Examples
    --------
    >>> from fecontact import shapes
    >>> linear, curved = (shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element=e) for e in ("hex8", "hex20"))
    >>> points, cells, ends = same_order(curved.points, [curved.cells, curved.cells[:, :8]])
    >>> len(points), bool((cells[0] == cells[1]).all()), len(ends)
    (20, True, 0)
    """
    wide = [p[:, :20] for p in parts]
    edges = np.concatenate([p[:, EDGES].reshape(-1, 2) for p in wide])
    given = np.concatenate([p[:, 8:].ravel() if p.shape[1] == 20 else np.full(12 * len(p), -1) for p in wide])
    ends, inverse = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    inverse = inverse.ravel()
    middle = np.full(len(ends), -1, dtype=np.int64)
    shrunk = ends[:, 0] == ends[:, 1]
    middle[shrunk] = ends[shrunk, 0]
    middle[inverse[given >= 0]] = given[given >= 0]
    new = np.flatnonzero(middle < 0)
    middle[new] = len(points) + np.arange(len(new))
    nodes = np.where(given >= 0, given, middle[inverse])
    columns = np.split(nodes, np.cumsum([12 * len(p) for p in wide])[:-1])
    cells = [np.concatenate([p[:, :8], c.reshape(len(p), 12)], axis=1) for p, c in zip(wide, columns, strict=True)]
    return np.concatenate([points, points[ends[new]].mean(axis=1)]), cells, ends[new]
