"""Kinds of cells in files and their conversion to hexahedra of 8, 20 or 27 nodes, degenerate where needed.

Node orders are those of VTK (also of Abaqus, FEBio and gmsh up to the order of mid-edge nodes, which `read` finds from
their positions).
"""

from __future__ import annotations

from dataclasses import dataclass

from fecontact.common.arrays import IntArray
from fecontact.mesh.element import EDGES


@dataclass(frozen=True)
class Kind:
    """A kind of cell.

    Attributes
    ----------
    name : str
    meshio : str
        Name in meshio.
    embedding : tuple of int
        The cell's node at each node of the hexahedron.
    """

    name: str
    meshio: str
    embedding: tuple[int, ...]

    @property
    def n_nodes(self) -> int:
        """Distinct nodes of the cell."""
        return len(set(self.embedding))

    @property
    def n_corners(self) -> int:
        """Distinct corners."""
        return len(set(self.embedding[:8]))

    @property
    def mid_edges(self) -> dict[int, tuple[int, int]]:
        """Mid-edge nodes with the two corners of their edge."""
        e = self.embedding
        ends = {node: (e[a], e[b]) for node, (a, b) in zip(e[8:20], EDGES.tolist(), strict=False)}
        return {node: pair for node, pair in ends.items() if node >= self.n_corners}

    def to_hexahedra(self, cells: IntArray) -> IntArray:
        """Connectivity (n, 8 | 20 | 27) of cells (n, n_nodes)."""
        return cells[:, list(self.embedding)]


_PRISM_15 = (0, 1, 2, 2, 3, 4, 5, 5, 6, 7, 2, 8, 9, 10, 5, 11, 12, 13, 14, 14)
_TETRA_10 = (0, 1, 2, 2, 3, 3, 3, 3, 4, 5, 2, 6, 3, 3, 3, 3, 7, 8, 9, 9)
_PYRAMID_13 = (0, 1, 2, 3, 4, 4, 4, 4, 5, 6, 7, 8, 4, 4, 4, 4, 9, 10, 11, 12)

KINDS = {
    kind.name: kind
    for kind in (
        Kind("hex8", "hexahedron", tuple(range(8))),
        Kind("hex20", "hexahedron20", tuple(range(20))),
        Kind("hex27", "hexahedron27", tuple(range(27))),
        Kind("wedge6", "wedge", _PRISM_15[:8]),
        Kind("wedge15", "wedge15", _PRISM_15),
        Kind("pyramid5", "pyramid", _PYRAMID_13[:8]),
        Kind("pyramid13", "pyramid13", _PYRAMID_13),
        Kind("tet4", "tetra", _TETRA_10[:8]),
        Kind("tet10", "tetra10", _TETRA_10),
    )
}
BY_MESHIO = {kind.meshio: kind for kind in KINDS.values()}
#: Kinds by the first node of the hexahedron with which each of its nodes coalesces.
_BY_PATTERN = {tuple(map(kind.embedding.index, kind.embedding)): kind for kind in KINDS.values()}


def kind_of(pattern: tuple[int, ...]) -> Kind | None:
    """Look up the kind of cell of a pattern; None for other degenerate hexahedra."""
    return _BY_PATTERN.get(pattern)
