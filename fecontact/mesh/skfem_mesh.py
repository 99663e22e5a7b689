"""20-node geometry on scikit-fem, and the way to its meshes and back.

scikit-fem has straight (8-node) and 27-node hexahedra but no 20-node geometry. `MeshHex20` is that class; with it a
curved 20-node mesh can be used with scikit-fem's own assembly, which serves as a check of ours and is open to users.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from skfem import Mesh as SkfemMesh
from skfem import MeshHex1, MeshHex2
from skfem.element import BOUNDARY_ELEMENT_MAP, Element, ElementHexS2, ElementQuadS2
from skfem.refdom import RefHex

from fecontact.common.arrays import IntArray
from fecontact.common.errors import InputError, MeshError
from fecontact.mesh.element.hexahedron import FACES, hex_nodes
from fecontact.mesh.mesh import Mesh

# without it scikit-fem does not know what the faces of a 20-node hexahedron are
BOUNDARY_ELEMENT_MAP[ElementHexS2] = ElementQuadS2


@dataclass(repr=False)
class MeshHex20(MeshHex1):
    """scikit-fem mesh of 20-node (serendipity) hexahedra.

    Its verbs `refined`, `restrict`, `+` and `remove_unused_nodes` are those of straight meshes and flatten or break
    curved ones: build a mesh with `fecontact.shapes` and convert it with `to_skfem` instead.
    """

    doflocs: NDArray[np.float64] = field(default_factory=lambda: MeshHex2().doflocs[:, :20])
    elem: type[Element] = ElementHexS2


_CLASSES = {8: MeshHex1, 20: MeshHex20, 27: MeshHex2}
#: A cell turned inside out put right: the lower and the upper faces swap places.
MIRRORED = (4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19, 20, 21, 22, 23, 25, 24, 26)


def _node_order(n_nodes: int) -> IntArray:
    """Our number of each node of scikit-fem's element."""
    theirs = np.asarray(_CLASSES[n_nodes].elem.doflocs)
    return np.argmin(np.linalg.norm(theirs[:, None, :] - hex_nodes(n_nodes)[None, :, :], axis=2), axis=1)


def _face_order() -> IntArray:
    """Our number of each face of scikit-fem's reference hexahedron."""
    ours = hex_nodes(8)[FACES[:, :4]].mean(axis=1)
    theirs = RefHex.p.T[np.asarray(RefHex.facets)].mean(axis=1)
    return np.argmin(np.linalg.norm(theirs[:, None, :] - ours[None, :, :], axis=2), axis=1)


def to_skfem(mesh: Mesh) -> SkfemMesh:
    """Convert a mesh to scikit-fem's `MeshHex1`, `MeshHex20` or `MeshHex2`, with its boundaries and element sets.

    Cells keep their order, points do not. Mid-face nodes carry no geometry and are left behind.

    Raises
    ------
    InputError
        If a cell has coalesced nodes, which scikit-fem cannot represent.

    Examples
    --------
    >>> from fecontact import shapes
    >>> to_skfem(shapes.block((1.0, 1.0, 1.0), (2, 2, 2))).t.shape
    (8, 8)
    """
    if mesh.has_coalesced:
        raise InputError("The mesh has degenerate cells (coalesced nodes), which scikit-fem has no element for.")
    n_nodes = mesh.cells.shape[1]
    used, cells = np.unique(mesh.cells, return_inverse=True)
    t = cells.reshape(mesh.cells.shape)[:, _node_order(n_nodes)].T
    theirs = _CLASSES[n_nodes](mesh.points[used].T, t)
    number = np.empty(6, dtype=np.int64)
    number[_face_order()] = np.arange(6)
    facets = {name: theirs.t2f[number[f[:, 1]], f[:, 0]] for name, f in mesh.boundaries.items()}
    return theirs.with_boundaries(facets).with_subdomains(dict(mesh.groups))


def from_skfem(theirs: SkfemMesh) -> Mesh:
    """Convert a scikit-fem mesh of hexahedra, with its boundaries and subdomains, to ours.

    Cells keep their order. Left-handed cells, which scikit-fem accepts (its default mesh is one), are put right.

    Raises
    ------
    MeshError
        If the mesh is not of hexahedra.

    Examples
    --------
    >>> from skfem import MeshHex
    >>> from_skfem(MeshHex())
    Mesh(hex8, 1 cells, 8 points, boundaries: none)
    """
    n_nodes = next((n for n, c in _CLASSES.items() if c.elem is theirs.elem), 0)
    if not n_nodes:
        raise MeshError(f"Expected a scikit-fem mesh of 8, 20 or 27-node hexahedra; found {type(theirs).__name__}.")
    inverse = np.argsort(_node_order(n_nodes))
    cells = np.asarray(theirs.dofs.element_dofs, dtype=np.int64).T[:, inverse]
    points = np.asarray(theirs.doflocs).T
    x = points[cells[:, :8]]
    across = np.cross(x[:, [1]] - x[:, [0]], x[:, [3]] - x[:, [0]])[:, 0]
    left = np.einsum("ni,ni->n", across, x[:, 4:].mean(axis=1) - x[:, :4].mean(axis=1)) < 0
    cells[left] = cells[left][:, list(MIRRORED[:n_nodes])]
    boundaries = {k: _cell_faces(theirs, np.asarray(v), left) for k, v in (theirs.boundaries or {}).items()}
    return Mesh(points, cells, boundaries, dict(theirs.subdomains or {}))


def _cell_faces(theirs: SkfemMesh, facets: IntArray, left: NDArray[np.bool_]) -> IntArray:
    """Facets as (cell, local face) of their first cell."""
    cell = theirs.f2t[0, facets]
    local = _face_order()[np.argmax(theirs.t2f[:, cell] == facets, axis=0)]
    swapped = np.array([0, 1, 2, 3, 5, 4])
    return np.stack([cell, np.where(left[cell], swapped[local], local)], axis=1).astype(np.int64)
