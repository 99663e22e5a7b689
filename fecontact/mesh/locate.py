"""Cells in which points lie, and fields there."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.element import element_basis
from fecontact.mesh.mesh import CellGroup, Mesh

CANDIDATES = 40
"""Cells with the nearest centres, relative to their size, in which a point is looked for."""

MAX_ITERATIONS, STEP_TOLERANCE = 30, 1e-12
"""Steps of Newton's method in a cell, and the step in reference coordinates that ends them."""

OUTSIDE = 0.05
"""Distance from the nearest cell, relative to its size, within which a point belongs to it: faces are not exact."""


def interpolation(mesh: Mesh, points: Array) -> tuple[sp.csr_matrix, Mask]:
    """Weights of a mesh's nodes at points, by the shape functions of the cells in which they lie.

    Parameters
    ----------
    mesh : Mesh
    points : (n, 3) array

    Returns
    -------
    weights : (n, n_points) csr_matrix
        Of a point beside all cells those of the nearest place of a cell.
    found : (n,) mask
        Points in a cell, or nearer to one than `OUTSIDE` of its size.

    Examples
    --------
    >>> from fecontact.mesh.shapes import block
    >>> mesh = block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> weights, found = interpolation(mesh, np.array([[0.1, 0.2, 0.9], [0.1, 0.2, 2.0]]))
    >>> (weights @ mesh.points)[0].round(12).tolist(), found.tolist()
    ([0.1, 0.2, 0.9], [True, False])
    """
    n = len(points)
    best = np.full(n, np.inf)
    out = sp.csr_matrix((n, len(mesh.points)))
    for group in mesh.cell_groups:
        nodes = mesh.points[group.nodes]
        low, high = nodes.min(axis=1), nodes.max(axis=1)
        centres, sizes = nodes.mean(axis=1), np.linalg.norm(high - low, axis=1)
        count = min(CANDIDATES, len(centres))
        near = cKDTree(centres).query(points, count)[1].reshape(n, count)
        # the likeliest first
        order = np.argsort(np.linalg.norm(points[:, None] - centres[near], axis=2) / sizes[near], axis=1)
        near = np.take_along_axis(near, order, axis=1)
        for column in near.T:
            beside = np.maximum(low[column] - points, points - high[column]).max(axis=1)
            todo = np.flatnonzero((best > STEP_TOLERANCE) & (beside <= OUTSIDE * sizes[column]))
            cells = column[todo]
            N, away = _nearest(mesh, group, cells, points[todo])
            better = away / sizes[cells] < best[todo]
            best[todo[better]] = (away / sizes[cells])[better]
            own = group.nodes[cells[better]]
            rows = np.repeat(todo[better], own.shape[1])
            part = sp.csr_matrix((N[better].ravel(), (rows, own.ravel())), shape=out.shape)
            kept = np.ones(n)
            kept[todo[better]] = 0.0
            out = sp.diags_array(kept) @ out + part
    return sp.csr_matrix(out), best <= OUTSIDE


def _nearest(mesh: Mesh, group: CellGroup, cells: IntArray, points: Array) -> tuple[Array, Array]:
    """Shape functions (n, k) of one cell of a group for each point, and its distance (n,) from the point.

    Newton's method for the reference coordinates, held within the cell.
    """
    nodes = mesh.points[group.nodes[cells]]
    X = np.full(points.shape, 0.5)
    for _ in range(MAX_ITERATIONS):
        N, dN = element_basis(mesh.cells.shape[1], group.pattern, group.midfaces, X)
        off = points - (N[:, None] @ nodes)[:, 0]
        # a collapsed edge has no coordinate along itself
        step = (np.linalg.pinv(np.swapaxes(nodes, 1, 2) @ dN) @ off[..., None])[..., 0]
        after = np.clip(X + step, 0.0, 1.0)
        moved = np.abs(after - X).max(initial=0.0)
        X = after
        if moved < STEP_TOLERANCE:
            break
    N = element_basis(mesh.cells.shape[1], group.pattern, group.midfaces, X)[0]
    return N, np.linalg.norm(points - (N[:, None] @ nodes)[:, 0], axis=1)
