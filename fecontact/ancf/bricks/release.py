"""Gradients shared between neighbouring elements, and where they are released.

Shared gradients make the strain continuous at nodes. That is wrong where the material changes: there the stress vector
is continuous and the normal strain jumps. At such a node each *side* (all cells of one label) gets its own gradients
F_a, tied only by continuity: where cells of the sides a and b share a face with tangents t_1, t_2 at the node, F_a
t_j = F_b t_j. These conditions are the same for each component; their null space is the set of remaining functions, one
more than usual (the normal gradient of the second side) at a smooth interface of two materials.

The same applies at sharp edges where the strain is singular or multi-valued, with every cell a side of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.mesh.element import FACES
from fecontact.mesh.facets import corner_keys, sides_of
from fecontact.mesh.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Numbering:
    """Numbers of functions; see `AncfSpace` for the attributes."""

    functions: IntArray
    joining: sp.csr_matrix | None
    start: IntArray
    n_functions: int


def sides_by_label(mesh: Mesh, labels: IntArray) -> IntArray:
    """Sides (n_cells, 8) from a label of each cell, such as its material: gradients are released where labels meet.

    Examples
    --------
    >>> from fecontact import shapes
    >>> sides_by_label(shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), np.array([3])).tolist()
    [[3, 3, 3, 3, 3, 3, 3, 3]]
    """
    labels = np.asarray(labels, dtype=np.int64)
    if labels.shape != (len(mesh.cells),):
        raise InputError(f"One label is needed for each of the {len(mesh.cells)} cells; found shape {labels.shape}.")
    return np.repeat(labels[:, None], 8, axis=1)


def released_at(mesh: Mesh, points: IntArray, sides: IntArray | None = None) -> IntArray:
    """Sides (n_cells, 8) with every cell a side of its own at the given points of the mesh, as at a sharp edge."""
    out = np.zeros((len(mesh.cells), 8), dtype=np.int64) if sides is None else np.array(sides, dtype=np.int64)
    chosen = np.isin(mesh.cells[:, :8], points)
    cell = np.broadcast_to(np.arange(len(mesh.cells))[:, None], out.shape)
    out[chosen] = out.max(initial=0) + 1 + cell[chosen]
    return out


def reentrant_points(mesh: Mesh, degrees: float = 30.0) -> IntArray:
    """Points on re-entrant edges of the surface sharper than `degrees`, where the stress is singular.

    Examples
    --------
    >>> from fecontact import shapes
    >>> reentrant_points(shapes.block((1.0, 1.0, 1.0), (2, 2, 2))).size  # a block has none
    0
    """
    faces = mesh.outer_faces
    corners = np.take_along_axis(mesh.cells[faces[:, 0]], FACES[faces[:, 1], :4], axis=1)
    x = mesh.points[corners]
    normal = np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    middle = x.mean(axis=1)
    ends = np.sort(sides_of(corners).reshape(-1, 2), axis=1)
    order = np.lexsort(ends.T)
    twin = np.flatnonzero((ends[order[1:]] == ends[order[:-1]]).all(axis=1))
    a, b = order[twin] // 4, order[twin + 1] // 4
    inwards = np.einsum("ni,ni->n", middle[b] - middle[a], normal[a]) > 0
    sharp = np.einsum("ni,ni->n", normal[a], normal[b]) < np.cos(np.radians(degrees))
    return np.unique(ends[order[twin[inwards & sharp]]])


def number(corners: IntArray, sides: IntArray | None, jacobians: Array) -> Numbering:
    """Number the functions of all cells.

    Parameters
    ----------
    corners : (n_cells, 8) int array
        Nodes 0 ... n_nodes - 1.
    sides : (n_cells, 8) int array or None
    jacobians : (n_cells, 8, 3, 3) array
        dX_m/dt_j at the corners: column j is the tangent along reference axis j.
    """
    n_nodes = int(corners.max()) + 1
    shape = (len(corners), 32)
    if sides is None:
        functions = (4 * corners[:, :, None] + np.arange(4)).reshape(shape)
        return Numbering(functions, None, 4 * np.arange(n_nodes), 4 * n_nodes)
    pairs, side = np.unique(np.stack([corners, sides], axis=-1).reshape(-1, 2), axis=0, return_inverse=True)
    side = side.reshape(corners.shape)
    count = np.bincount(pairs[:, 0], minlength=n_nodes)
    first_side = np.concatenate([[0], np.cumsum(count)[:-1]])
    if (count == 1).all():
        return number(corners, None, jacobians)
    position = np.arange(n_nodes) + 3 * first_side
    gradient = pairs[:, 0] + 1 + 3 * np.arange(len(pairs))
    own = np.concatenate([position[corners][..., None], gradient[side][..., None] + np.arange(3)], axis=2)
    blocks = _free_gradients(corners, side, first_side, count, jacobians)
    n_free = np.full(n_nodes, 3)
    for nodes, bases in blocks:
        n_free[nodes] = bases.shape[2]
    start = np.concatenate([[0], np.cumsum(1 + n_free)[:-1]])
    joining = _joining(start, n_free, position, count, blocks)
    return Numbering(own.reshape(shape), joining, start, int((1 + n_free).sum()))


def _free_gradients(
    corners: IntArray, side: IntArray, first_side: IntArray, count: IntArray, jacobians: Array
) -> list[tuple[IntArray, Array]]:
    """Nodes with several sides, and orthonormal bases (n, 3 n_sides, n_free) of their gradients, in blocks."""
    node, a, b, tangent = _ties(corners, side, jacobians)
    out = []
    for m in np.unique(count[count > 1]):
        nodes = np.flatnonzero(count == m)
        chosen = np.flatnonzero(count[node] == m)
        local = np.searchsorted(nodes, node[chosen])
        # the normal matrix of the ties has the same null space and a fixed size for any number of ties
        row = np.zeros((len(chosen), m, 3))
        t = tangent[chosen] / np.linalg.norm(tangent[chosen], axis=1, keepdims=True)
        row[np.arange(len(chosen)), a[chosen] - first_side[node[chosen]]] = t
        row[np.arange(len(chosen)), b[chosen] - first_side[node[chosen]]] = -t
        row = row.reshape(-1, 3 * m)
        normal = np.zeros((len(nodes), 3 * m, 3 * m))
        np.add.at(normal, local, row[:, :, None] * row[:, None, :])
        values, vectors = np.linalg.eigh(normal)
        free = (values <= 1e-9).sum(axis=1)
        out += [(nodes[free == d], vectors[free == d][:, :, :d]) for d in np.unique(free)]
    return out


def _ties(corners: IntArray, side: IntArray, jacobians: Array) -> tuple[IntArray, IntArray, IntArray, Array]:
    """Conditions F_a t = F_b t at corners of faces between different sides: node, a, b and tangent t."""
    keys = corner_keys(corners[:, FACES[:, :4]].reshape(-1, 4))
    order = np.lexsort(keys.T[::-1])
    twin = np.flatnonzero((keys[order[1:]] == keys[order[:-1]]).all(axis=1))
    one, other = order[twin], order[twin + 1]
    cell, face = np.divmod(one, 6)
    local = FACES[face, :4]
    node = corners[cell[:, None], local]
    there = (other // 6)[:, None]
    match = np.argmax(corners[there[:, :, None], np.arange(8)] == node[:, :, None], axis=2)
    a, b = side[cell[:, None], local], side[there, match]
    f, k = np.nonzero(a != b)
    found: list[tuple[IntArray, ...]] = []
    tangents = []
    for step in (1, 2):
        axis = (face[f] // 2 + step) % 3
        found.append((node[f, k], a[f, k], b[f, k]))
        tangents.append(jacobians[cell[f], local[f, k], :, axis])
    node, a, b = (np.concatenate(column) for column in zip(*found, strict=True))
    return node, a, b, np.concatenate(tangents)


def _joining(
    start: IntArray, n_free: IntArray, position: IntArray, count: IntArray, blocks: list[tuple[IntArray, Array]]
) -> sp.csr_matrix:
    """Matrix from the remaining functions to those of the sides; its columns are orthonormal."""
    plain = np.flatnonzero(count == 1)
    rows = [position, (position[plain][:, None] + np.arange(1, 4)).ravel()]
    columns = [start, (start[plain][:, None] + np.arange(1, 4)).ravel()]
    values = [np.ones(len(position)), np.ones(3 * len(plain))]
    for nodes, basis in blocks:
        n, m, d = basis.shape
        rows.append(np.broadcast_to((position[nodes][:, None] + 1 + np.arange(m))[:, :, None], (n, m, d)).ravel())
        columns.append(np.broadcast_to((start[nodes][:, None] + 1 + np.arange(d))[:, None, :], (n, m, d)).ravel())
        values.append(basis.ravel())
    shape = (int((1 + 3 * count).sum()), int((1 + n_free).sum()))
    return sp.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)
