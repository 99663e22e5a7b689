"""Division of tetrahedra into hexahedra: an all-hexahedral mesh of any solid that has a tetrahedral one.

Each tetrahedron is divided into four hexahedra, one at each corner, by its mid-edge points, face centres and centre.
Nodes are placed by the tetrahedron's own (quadratic) mapping, so that curved surfaces stay curved and neighbours
conform.
"""

from __future__ import annotations

import numpy as np

from fecontact.common.arguments import instance
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.mesh.element import EDGES, TETRAHEDRON, element_basis
from fecontact.mesh.hanging_nodes import refuse_hanging
from fecontact.mesh.mesh import Mesh

#: Tetrahedron corners at each hexahedron's first corner and along its three axes; all even permutations.
_AXES = ((0, 1, 2, 3), (1, 2, 0, 3), (2, 0, 1, 3), (3, 1, 0, 2))
#: Corners of the tetrahedron on the local faces -x, +x, -y, -z of its collapsed hexahedron.
_TRIANGLES = {0: (0, 2, 3), 1: (1, 2, 3), 2: (0, 1, 3), 4: (0, 1, 2)}
#: Local face of a hexahedron that contains its first corner and two of its axes (1, 2, 3).
_FACE_OF_AXES = {(1, 2): 4, (1, 3): 2, (2, 3): 0}


def _corner_sets() -> list[tuple[int, ...]]:
    """Tetrahedron corners whose mean is each of the 4 x 8 corners of the hexahedra."""
    sets = []
    for v, p, q, r in _AXES:
        sets += [(v,), (v, p), (v, p, q), (v, q), (v, r), (v, p, r), (v, p, q, r), (v, q, r)]
    return sets


def _barycentric() -> Array:
    """Barycentric coordinates (4, 20, 4) of the nodes of the four hexahedra."""
    flat = np.zeros((32, 4))
    for k, members in enumerate(_corner_sets()):
        flat[k, list(members)] = 1 / len(members)
    corners = flat.reshape(4, 8, 4)
    return np.concatenate([corners, corners[:, EDGES].mean(axis=2)], axis=1)


def divided(mesh: Mesh) -> Mesh:
    """All-hexahedral mesh of 20 nodes per cell (8 from linear tetrahedra), four cells for each tetrahedron.

    Boundaries, element sets and node sets keep their names.

    Raises
    ------
    InputError
        If a cell is not a tetrahedron, or the mesh has hanging nodes.

    Examples
    --------
    >>> import numpy as np
    >>> points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    >>> divided(Mesh(points, np.array([[0, 1, 2, 2, 3, 3, 3, 3]])))
    Mesh(hex8, 4 cells, 15 points, boundaries: none)
    """
    instance("the mesh", mesh, Mesh)
    refuse_hanging(mesh.hanging, "divided into hexahedra")
    width = mesh.cells.shape[1]
    groups = mesh.cell_groups
    if width == 27 or len(groups) > 1 or groups[0].pattern != TETRAHEDRON[:width] or mesh.midface is not None:
        found = ", ".join(mesh.kinds)
        raise InputError(f"Only tetrahedra without mid-face nodes can be divided into hexahedra; found {found}.")
    tetrahedra = mesh.cells[:, [0, 1, 2, 4]]
    corners, sets = _numbered(tetrahedra, mesh)
    cells = Mesh(np.zeros((corners.max() + 1, 3)), corners, node_sets=sets)
    out = cells.upgraded(20) if width == 20 else cells
    X = _on_collapsed(_barycentric()[:, :width].reshape(-1, 4))
    N, _ = element_basis(width, TETRAHEDRON[:width], (), X)
    points = np.empty_like(out.points)
    points[out.cells.reshape(len(tetrahedra), -1)] = N @ mesh.points[groups[0].nodes]
    return Mesh(
        points,
        out.cells,
        {name: _divided_faces(faces) for name, faces in mesh.boundaries.items()},
        {name: (4 * g[:, None] + np.arange(4)).ravel() for name, g in mesh.groups.items()},
        out.node_sets,
    )


def _on_collapsed(L: Array) -> Array:
    """Points of the collapsed reference hexahedron (n, 3) with given barycentric coordinates (n, 4)."""
    a, b, c, d = L.T
    plane, base = 1 - d, a + b
    y = np.divide(c, plane, out=np.zeros_like(c), where=plane > 0)
    x = np.divide(b, base, out=np.zeros_like(b), where=base > 0)
    return np.stack([x, y, d], axis=1)


def _numbered(tetrahedra: IntArray, mesh: Mesh) -> tuple[IntArray, dict[str, IntArray]]:
    """Corner numbers (4 n, 8) of the hexahedra, shared between neighbours, and the node sets in these numbers."""
    n = len(tetrahedra)
    columns = np.empty((n, 32), dtype=np.int64)
    members = _corner_sets()
    sets: dict[str, list[IntArray]] = {name: [] for name in mesh.node_sets}
    start = 0
    for size in range(1, 5):
        places = [k for k, m in enumerate(members) if len(m) == size]
        keys = np.sort(tetrahedra[:, [members[k] for k in places]].reshape(-1, size), axis=1)
        distinct, inverse = np.unique(keys, axis=0, return_inverse=True)
        columns[:, places] = start + inverse.reshape(n, -1)
        for name, nodes in mesh.node_sets.items():
            sets[name].append(start + np.flatnonzero(np.isin(distinct, nodes).all(axis=1)))
        start += len(distinct)
    return columns.reshape(4 * n, 8), {name: np.concatenate(parts) for name, parts in sets.items()}


def _divided_faces(faces: IntArray) -> IntArray:
    """Three faces of hexahedra for each face of a tetrahedron."""
    table = np.zeros((6, 3, 2), dtype=np.int64)
    for face, triangle in _TRIANGLES.items():
        for k, corner in enumerate(triangle):
            axes = tuple(sorted(_AXES[corner].index(other) for other in triangle if other != corner))
            table[face, k] = corner, _FACE_OF_AXES[axes]  # type: ignore[index]
    chosen = table[faces[:, 1]]
    return np.stack([4 * faces[:, :1] + chosen[:, :, 0], chosen[:, :, 1]], axis=2).reshape(-1, 2)
