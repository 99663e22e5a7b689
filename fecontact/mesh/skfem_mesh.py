"""Conversion between scikit-fem meshes and bases and the points and cells of `Mesh`, in both directions.

This module works on arrays; call `Mesh.from_skfem`, `Mesh.to_skfem` and `AssembledBody.from_skfem`. The order of nodes
and faces is found from reference positions, without a table that must agree with scikit-fem's. scikit-fem has straight
(8-node) and 27-node hexahedra but no 20-node geometry: `MeshHex20` is that class.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from skfem import CellBasis, ElementVector, MeshHex1, MeshHex2, MeshTet1, MeshTet2, MeshWedge1
from skfem import Mesh as SkfemMesh
from skfem.element import BOUNDARY_ELEMENT_MAP, Element, ElementHexS2, ElementQuadS2
from skfem.generic_utils import OrientedBoundary

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError, MeshError
from fecontact.mesh.element import FACES, hex_nodes
from fecontact.mesh.facets import places_among
from fecontact.mesh.kinds import KINDS, Kind

#: Points (n, 3), cells (n, 8 | 20 | 27), boundaries and groups of a `Mesh`.
MeshArrays = tuple[Array, IntArray, Mapping[str, IntArray], Mapping[str, IntArray]]

# scikit-fem needs it for the faces of a 20-node hexahedron
BOUNDARY_ELEMENT_MAP[ElementHexS2] = ElementQuadS2


@dataclass(repr=False)
class MeshHex20(MeshHex1):
    """scikit-fem mesh of 20-node (serendipity) hexahedra.

    Its verbs `refined`, `restrict`, `+` and `remove_unused_nodes` are those of straight meshes and flatten or break
    curved ones: build a mesh with `fecontact.shapes` and convert it with `Mesh.to_skfem` instead.
    """

    doflocs: Array = field(default_factory=lambda: MeshHex2().doflocs[:, :20])
    elem: type[Element] = ElementHexS2


_CLASSES: dict[str, type[SkfemMesh]] = {
    "hex8": MeshHex1,
    "hex20": MeshHex20,
    "hex27": MeshHex2,
    "tet4": MeshTet1,
    "tet10": MeshTet2,
    "wedge6": MeshWedge1,
}
_KIND_OF_ELEMENT = {theirs.elem: KINDS[name] for name, theirs in _CLASSES.items()}
EXPECTED = "8-, 20- or 27-node hexahedra, 4- or 10-node tetrahedra or 6-node wedges"


@dataclass(frozen=True, eq=False)
class _Order:
    """Numbering of a kind of cell here and in scikit-fem.

    Attributes
    ----------
    nodes : (n_nodes,) array
        Number here of each of scikit-fem's nodes.
    faces : (n_facets,) array
        Local face here of each of scikit-fem's facets.
    mirrored_nodes, mirrored_faces : (n_nodes,), (6,) arrays
        Permutation of nodes and faces that turns a left-handed cell right-handed.
    """

    nodes: IntArray
    faces: IntArray
    mirrored_nodes: IntArray
    mirrored_faces: IntArray


def _nearest(wanted: Array, among: Array) -> IntArray:
    return np.argmin(np.linalg.norm(wanted[:, None, :] - among[None, :, :], axis=2), axis=1)


@cache
def _order(name: str) -> _Order:
    """Numbering of a kind of cell, matched by positions in scikit-fem's reference cell."""
    kind, element = KINDS[name], _CLASSES[name].elem
    if kind.n_corners == 8:
        ours = hex_nodes(kind.n_nodes)
        mirrored = ours * [1, 1, -1] + [0, 0, 1]
    else:
        corners = element.refdom.p.T
        ours = np.array([*corners, *(corners[list(ends)].mean(axis=0) for _, ends in sorted(kind.mid_edges.items()))])
        mirrored = ours[:, [1, 0, 2]]
    sides = [sorted({kind.embedding[k] for k in face}) for face in FACES[:, :4].tolist()]
    # a collapsed face is never the nearest
    centres = np.array([ours[s].mean(axis=0) if len(s) > 2 else np.full(3, 9.0) for s in sides])
    mirrored_centres = np.array([mirrored[s].mean(axis=0) if len(s) > 2 else np.full(3, 9.0) for s in sides])
    theirs = np.array([element.refdom.p.T[sorted(set(facet))].mean(axis=0) for facet in element.refdom.facets])
    return _Order(
        _nearest(np.asarray(element.doflocs), ours),
        _nearest(theirs, centres),
        _nearest(mirrored, ours),
        _nearest(mirrored_centres, centres),
    )


def skfem_mesh(kinds: tuple[str, ...], mesh: MeshArrays) -> SkfemMesh:
    """scikit-fem mesh of points, cells, boundaries and groups of the given kinds of cells.

    Raises
    ------
    InputError
        If there are several kinds of cells, or one without a scikit-fem element.
    """
    if len(kinds) != 1 or kinds[0] not in _CLASSES:
        raise InputError(
            f"The mesh has cells of the kinds {', '.join(kinds)} (degenerate hexahedra have coalesced nodes), which "
            f"scikit-fem has no mesh for. It has one for {EXPECTED}, all cells alike.",
            code="no-skfem-mesh",
        )
    points, cells, boundaries, groups = mesh
    kind, order = KINDS[kinds[0]], _order(kinds[0])
    own = cells[:, np.unique(kind.embedding, return_index=True)[1]]
    used, number = np.unique(own, return_inverse=True)
    theirs = _CLASSES[kind.name](points[used].T, number.reshape(own.shape)[:, order.nodes].T)
    facet = places_among(order.faces, 6)
    named = {name: _facets(theirs, f[:, 0], facet[f[:, 1]]) for name, f in boundaries.items()}
    return theirs.with_boundaries(named).with_subdomains(dict(groups))


def _facets(theirs: SkfemMesh, cell: IntArray, local: IntArray) -> IntArray:
    """Numbers (n,) of scikit-fem's facets, with their orientation where it is not that of their first cell."""
    facets = theirs.t2f[local, cell]
    second = theirs.f2t[0, facets] != cell
    return OrientedBoundary(facets, second.astype(int)) if second.any() else facets


def from_skfem_mesh(theirs: SkfemMesh) -> MeshArrays:
    """Points, cells, boundaries and groups of a mesh of scikit-fem's.

    Raises
    ------
    MeshError
        If its cells are not supported solid cells.
    """
    kind = _KIND_OF_ELEMENT.get(getattr(theirs, "elem", None))
    if kind is None:
        raise MeshError(f"Expected a scikit-fem mesh of {EXPECTED}; found {type(theirs).__name__}.", code="no-skfem")
    return _arrays(theirs, kind, theirs.dofs.element_dofs, theirs.doflocs.T)[0]


def from_skfem_basis(basis: CellBasis) -> tuple[MeshArrays, IntArray]:
    """Points, cells, boundaries and groups of the nodes of a basis of displacements, and their numbers in it.

    The element may be of a higher order than the mesh: the nodes are those of the element, on the geometry of the mesh.

    Returns
    -------
    mesh : MeshArrays
    dofs : (n_points, 3) array
        Number in the basis of each point's displacement x, y, z.

    Raises
    ------
    InputError
        If the basis does not have three displacements per node over all cells of a supported mesh.
    """
    scalar = basis.elem.elem if isinstance(basis.elem, ElementVector) else None
    kind, geometry = _KIND_OF_ELEMENT.get(type(scalar)), _KIND_OF_ELEMENT.get(basis.mesh.elem)
    if kind is None or geometry is None:
        raise InputError(
            f"Expected a basis of ElementVector of {EXPECTED}; found {type(scalar or basis.elem).__name__} on "
            f"{type(basis.mesh).__name__}.",
            code="no-skfem-basis",
        )
    if geometry.n_nodes > kind.n_nodes:
        raise InputError(
            f"The mesh has {geometry.n_nodes} nodes per cell and the element {kind.n_nodes}: the surface would not be "
            "that of the mesh. Take an element of the mesh's own order or above.",
            code="basis-too-low",
        )
    if basis.element_dofs.shape[1] != basis.mesh.nelements:
        raise InputError(f"The basis spans {basis.element_dofs.shape[1]} of {basis.mesh.nelements} cells; give all.")
    first, nodes = np.unique(basis.element_dofs[0::3], return_inverse=True)
    dofs = np.empty((len(first), 3), dtype=np.int64)
    for k in range(3):
        dofs[nodes.reshape(-1), k] = basis.element_dofs[k::3].ravel()
    local = nodes.reshape(basis.element_dofs[0::3].shape)
    mesh, used = _arrays(basis.mesh, kind, local, basis.doflocs.T[first])
    return mesh, dofs[used]


def _arrays(theirs: SkfemMesh, kind: Kind, nodes: IntArray, points: Array) -> tuple[MeshArrays, IntArray]:
    """Points in use, cells and sets from `nodes` (n_nodes, n_cells) in scikit-fem's order; the points' old numbers."""
    order = _order(kind.name)
    used, number = np.unique(nodes, return_inverse=True)
    own = number.reshape(nodes.shape).T[:, np.argsort(order.nodes)]
    points = np.ascontiguousarray(points[used])
    x = points[own[:, list(kind.embedding[:8])]]
    across = np.cross(x[:, 1] - x[:, 0], x[:, 3] - x[:, 0])
    left = np.einsum("ni,ni->n", across, x[:, 4:].mean(axis=1) - x[:, :4].mean(axis=1)) < 0
    own[left] = own[left][:, order.mirrored_nodes]
    boundaries = {k: _cell_faces(theirs, v, left, order) for k, v in (theirs.boundaries or {}).items()}
    groups = {k: np.asarray(v, dtype=np.int64) for k, v in (theirs.subdomains or {}).items()}
    return (points, kind.to_hexahedra(own), boundaries, groups), used


def _cell_faces(theirs: SkfemMesh, facets: IntArray, left: Mask, order: _Order) -> IntArray:
    """Facets as (cell, local face) of their first cell, or of the cell that an oriented boundary names."""
    side, facets = np.asarray(getattr(facets, "ori", 0)), np.asarray(facets)
    cell = theirs.f2t[side, facets]
    local = order.faces[np.argmax(theirs.t2f[:, cell] == facets, axis=0)]
    return np.stack([cell, np.where(left[cell], order.mirrored_faces[local], local)], axis=1).astype(np.int64)
