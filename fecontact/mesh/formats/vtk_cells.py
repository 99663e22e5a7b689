"""Cells of a mesh for other programs: wedges, pyramids and tetrahedra instead of degenerate hexahedra."""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import IntArray
from fecontact.mesh.kinds import KINDS, kind_of
from fecontact.mesh.mesh import Mesh


def native_cells(mesh: Mesh) -> list[tuple[str, IntArray, IntArray]]:
    """Cells by kind: name in meshio, connectivity in VTK's node order, and their (increasing) numbers in the mesh.

    Mid-face nodes are left out. Degenerate hexahedra that are neither wedge, pyramid nor tetrahedron stay hexahedra.
    The first triangle of a wedge has its normal towards the second one, as in gmsh; meshio reorders wedges of six nodes
    in VTK files, where VTK has the opposite convention.

    Examples
    --------
    >>> from fecontact import shapes
    >>> [(name, cells.shape) for name, cells, _ in native_cells(shapes.block((1.0, 1.0, 1.0), (2, 1, 1)))]
    [('hexahedron20', (2, 20))]
    """
    parts: dict[str, list[tuple[IntArray, IntArray]]] = {}
    for group in mesh.cell_groups:
        kind = kind_of(group.pattern)
        if kind is None:
            part = (mesh.cells[group.cells], group.cells)
            kind = KINDS[mesh.cell_type]
        else:
            part = (group.nodes[:, : kind.n_nodes], group.cells)
        parts.setdefault(kind.meshio, []).append(part)
    out = []
    for name, found in parts.items():
        cells, numbers = (np.concatenate(arrays) for arrays in zip(*found, strict=True))
        order = np.argsort(numbers)
        out.append((name, cells[order], numbers[order]))
    return out
