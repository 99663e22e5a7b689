"""Local refinement of meshes: division of marked cells, with hanging nodes towards undivided neighbours.

Neighbours over faces and edges differ by at most one level (2 : 1): cells that would be two levels coarser are divided
too. New points lie on the isoparametric map of their parent; existing points stay. The mesh keeps no levels and no
parents, only the edges and faces divided on one side (`HangingNodes`), which is all that a later division needs. `cut`
numbers the new nodes and maps all sets.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.common.arguments import instance
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError
from fecontact.mesh.base_mesh import BaseMesh
from fecontact.mesh.cell_division import (
    DIAGONALS,
    CellDivision,
    cell_division,
    divisible,
    hexahedra_of_tetrahedron,
    section_division,
    star,
)
from fecontact.mesh.element import EDGES, FACES, QUAD_EDGES, TETRAHEDRON, Pattern
from fecontact.mesh.facets import Keys, edge_keys, face_keys, found, places_among
from fecontact.mesh.hanging_nodes import TABLES, HangingNodes, refuse_hanging, tied
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import SIDES, SectionMesh

C = TypeVar("C", bound=BaseMesh)
#: Cells (n,) of a mesh with the same division.
Part = tuple[IntArray, CellDivision]


def cut(mesh: C, parts: Sequence[Part]) -> tuple[C, list[IntArray]]:
    """Replace cells by their children.

    Returns
    -------
    mesh : Mesh or SectionMesh
        Without hanging nodes. Undivided cells first, then the children part by part and parent by parent.
    lattices : list of (n_cells, n_lattice) int arrays
        Point numbers of the lattices (`CellDivision`) of each part.
    """
    lattices, n_points = _numbered(mesh, parts)
    divided = np.zeros(len(mesh.cells), bool)
    divided[np.concatenate([cells for cells, _ in parts])] = True
    children = [n[:, d.children].reshape(-1, mesh.cells.shape[1]) for n, (_, d) in zip(lattices, parts, strict=True)]
    start = (~divided).sum() + np.cumsum([0, *map(len, children)])
    out = replace(
        mesh,
        points=np.concatenate([mesh.points, _new_points(mesh, parts, lattices, n_points)]),
        cells=np.concatenate([mesh.cells[~divided], *children]),
        boundaries={k: _children_of_faces(faces, divided, parts, start) for k, faces in mesh.boundaries.items()},
        groups={k: _children_of_cells(cells, divided, parts, start) for k, cells in mesh.groups.items()},
        node_sets={k: _with_new_nodes(nodes, mesh, parts, lattices) for k, nodes in mesh.node_sets.items()},
        hanging=None,
        file_nodes=None,
        file_elements=None,
    )
    return out, lattices


def _numbered(mesh: BaseMesh, parts: Sequence[Part]) -> tuple[list[IntArray], int]:
    """Point numbers of the lattices, and the number of points; existing points of neighbours are reused."""
    n = len(mesh.points)
    lattices = []
    for cells, division in parts:
        lattice = np.full((len(cells), len(division.own)), -1)
        own = division.own >= 0
        lattice[:, own] = mesh.cells[cells[:, None], division.columns[division.own[own]]]
        lattice[:, division.inner] = n + np.arange(len(cells) * len(division.inner)).reshape(len(cells), -1)
        n += len(cells) * len(division.inner)
        lattices.append(lattice)
    for level, known in enumerate(_known(mesh.hanging)):
        keys_of = edge_keys if level in (0, 2) else face_keys
        tables = [division.shared[level] for _, division in parts]
        keys = [keys_of(lattice[:, t[:, 1:]]) for lattice, t in zip(lattices, tables, strict=True)]
        distinct, inverse = np.unique(np.concatenate([k.ravel() for k in keys]), return_inverse=True)
        place = found(distinct, keys_of(known[:, :-1]))
        number = np.where(place < 0, n + np.cumsum(place < 0) - 1, known[place, -1] if len(known) else -1)
        n += int((place < 0).sum())
        numbers = np.split(number[inverse], np.cumsum([k.size for k in keys])[:-1])
        for lattice, t, its in zip(lattices, tables, numbers, strict=True):
            lattice[:, t[:, 0]] = its.reshape(len(lattice), -1)
    return lattices, n


def _known(hanging: HangingNodes | None) -> list[IntArray]:
    """Points of the finer side after the two or four points between which they lie (n, 3 | 5), as in `shared`."""
    if hanging is None:
        return [np.empty((0, width), dtype=np.int64) for width in (3, 5, 3, 5)]
    e, q = hanging.edges, hanging.quads
    return [e[:, [0, 2, 1]], q[:, [0, 1, 2, 3, 8]], hanging.halves[:, :3], hanging.quarters]


def _new_points(mesh: BaseMesh, parts: Sequence[Part], lattices: list[IntArray], n_points: int) -> Array:
    """New points (n_new, 3) by the isoparametric maps of the parents."""
    n = len(mesh.points)
    new = np.empty((n_points - n, 3))
    for (cells, division), lattice in zip(parts, lattices, strict=True):
        columns = np.flatnonzero(division.own < 0)
        x = division.shapes[columns] @ mesh.points[mesh.cells[cells[:, None], division.columns]]
        number = lattice[:, columns]
        new[number[number >= n] - n] = x[number >= n]
    return new


def _children_of_cells(cells: IntArray, divided: Mask, parts: Sequence[Part], start: IntArray) -> IntArray:
    """New numbers of undivided cells and of the children of divided ones."""
    out = [_number(divided)[cells[~divided[cells]]]]
    for (parents, division), first in zip(parts, start[:-1], strict=True):
        n = len(division.children)
        place = np.flatnonzero(np.isin(parents, cells))
        out.append((first + n * place[:, None] + np.arange(n)).ravel())
    return np.concatenate(out)


def _children_of_faces(faces: IntArray, divided: Mask, parts: Sequence[Part], start: IntArray) -> IntArray:
    """Faces (n, 2) of undivided cells and of the children on faces of divided ones."""
    whole = faces[~divided[faces[:, 0]]]
    out = [np.column_stack([_number(divided)[whole[:, 0]], whole[:, 1]])]
    for (parents, division), first in zip(parts, start[:-1], strict=True):
        place = places_among(parents, len(divided))
        mine = faces[place[faces[:, 0]] >= 0]
        child, face = np.moveaxis(division.facets[mine[:, 1]], 2, 0)
        number = first + len(division.children) * place[mine[:, :1]] + child
        out.append(np.stack([number, face], axis=2)[child >= 0])
    return np.concatenate(out)


def _number(divided: Mask) -> IntArray:
    """New numbers (n_cells,) of the undivided cells."""
    return np.cumsum(~divided) - 1


def _with_new_nodes(nodes: IntArray, mesh: BaseMesh, parts: Sequence[Part], lattices: list[IntArray]) -> IntArray:
    """Node set with the new points on edges, faces and cells that have all their nodes in it."""
    member = np.zeros(len(mesh.points), bool)
    member[nodes] = True
    out = [nodes]
    for (cells, division), lattice in zip(parts, lattices, strict=True):
        outside = ~member[mesh.cells[cells[:, None], division.columns]]
        within = outside.astype(float) @ division.entity.T == 0
        out.append(lattice[within & (lattice >= len(mesh.points))])
    return np.unique(np.concatenate(out))


#: Columns of the tables of `HangingNodes` with the corners of the undivided edge or face, and the function of its key.
_WHOLE: dict[str, tuple[list[int], Callable[[IntArray], Keys]]] = {
    "edges": ([0, 2], edge_keys),
    "quads": ([0, 1, 2, 3], face_keys),
    "triangles": ([0, 1, 2, 2], face_keys),
}
M = TypeVar("M", Mesh, SectionMesh)
#: Relative difference of diagonals of a tetrahedron below which they count as equal, so that rounding does not decide.
EQUAL = 1e-9
#: Temporary boundary of the faces with mid-face nodes; no name that a user gives.
_MIDFACE = "\0mid-face nodes"


def refined(mesh: M, cells: ArrayLike) -> M:
    """Divide cells of a mesh, and neighbours that would become two levels coarser.

    Hexahedra, wedges and tetrahedra are divided into eight, quadrilaterals of sections into four, pyramids into six
    pyramids and four tetrahedra. Hexahedra collapsed in other ways are first converted to pyramids and tetrahedra
    around their centre, with a note. Nodes between divided and undivided cells are hanging (`mesh.hanging`).
    Boundaries, element sets, node sets, mid-face nodes and notes are carried over. Without cells to divide the mesh
    itself is returned.

    Parameters
    ----------
    mesh : Mesh or SectionMesh
    cells : (n,) int array, or (n_cells,) bool array
        Which cells to divide.

    Returns
    -------
    Mesh or SectionMesh
        Existing points come first, in their order, except mid-face nodes, which are made anew. Undivided cells come
        first, in their order.

    Raises
    ------
    InputError
        If there is no such cell, a collapsed cell of 27 nodes would be divided, or hanging nodes are not on the edges
        and faces that `mesh.hanging` lists as divided.

    Examples
    --------
    >>> from fecontact import shapes
    >>> mesh = refined(shapes.block((2.0, 1.0, 1.0), (2, 1, 1)), [0])
    >>> len(mesh.cells), len(mesh.hanging.nodes)
    (9, 13)
    """
    chosen = _chosen(mesh, cells)
    if not chosen.any():
        return mesh
    _refuse_other_ties(mesh)
    if isinstance(mesh, SectionMesh):
        chosen = _balanced(mesh, chosen)
        return _divided(mesh, [(np.flatnonzero(chosen), section_division(mesh.cells.shape[1]))])
    bare = _without_midface_nodes(mesh)
    whole, chosen = _without_odd_cells(bare, _balanced(bare, chosen))
    out = _divided(whole, _parts(whole, chosen))
    if _MIDFACE in out.boundaries:
        out = out.with_midface_nodes((_MIDFACE,))
    return replace(out, boundaries={k: v for k, v in out.boundaries.items() if k != _MIDFACE})


def divided(mesh: Mesh) -> Mesh:
    """All-hexahedral mesh of 20 nodes per cell (8 from linear tetrahedra), four cells for each tetrahedron.

    New nodes lie on the tetrahedron's own (quadratic) mapping, so that curved surfaces stay curved and neighbours
    conform. Boundaries, element sets and node sets keep their names.

    Raises
    ------
    InputError
        If a cell is not a tetrahedron, or the mesh has hanging nodes.

    Examples
    --------
    >>> points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    >>> divided(Mesh(points, np.array([[0, 1, 2, 2, 3, 3, 3, 3]])))
    Mesh(hex8, 4 cells, 15 points, boundaries: none)
    """
    instance("the mesh", mesh, Mesh)
    refuse_hanging(mesh.hanging, "divided into hexahedra")
    width, groups = mesh.cells.shape[1], mesh.cell_groups
    if width == 27 or len(groups) > 1 or groups[0].pattern != TETRAHEDRON[:width] or mesh.midface is not None:
        kinds = ", ".join(mesh.kinds)
        raise InputError(f"Only tetrahedra without mid-face nodes can be divided into hexahedra; found {kinds}.")
    return cut(mesh, [(np.arange(len(mesh.cells)), hexahedra_of_tetrahedron(width))])[0]


def touching(mesh: Mesh | SectionMesh, faces: ArrayLike) -> IntArray:
    """Cells (n,) that share a face, an edge or a corner with faces of a mesh, including the cells of the faces.

    If all of them are divided, no node of these faces is hanging.

    Parameters
    ----------
    mesh : Mesh or SectionMesh
    faces : (n_faces, 2) int array
        Faces (sides of a section) as (cell, local face), such as some of ``mesh.faces(name)``.

    Raises
    ------
    InputError
        If there is no such face.

    Examples
    --------
    >>> from fecontact import shapes
    >>> block = shapes.block((3.0, 3.0, 2.0), (3, 3, 2))
    >>> len(touching(block, block.faces("top")[:1]))
    4
    """
    given = np.asarray(faces, dtype=np.int64).reshape(-1, 2)
    if ((given < 0) | (given >= [len(mesh.cells), mesh.n_faces])).any():
        raise InputError(f"Faces are pairs (cell, local face) of a mesh of {len(mesh.cells)} cells.", code="face-pair")
    nodes = _with_middles(mesh)
    met = np.zeros(len(mesh.points) + 1, bool)
    met[nodes[given[:, :1], (FACES[:, :8] if isinstance(mesh, Mesh) else SIDES)[given[:, 1]]]] = True
    # the last entry means no node
    met[-1] = False
    return np.flatnonzero(met[nodes].any(axis=1))


def _with_middles(mesh: Mesh | SectionMesh) -> IntArray:
    """Nodes of the cells; for linear cells with the middles of edges divided by neighbours, -1 for none."""
    if mesh.cells.shape[1] != 8 or isinstance(mesh, SectionMesh):
        return mesh.cells
    edges = np.empty((0, 5), np.int64) if mesh.hanging is None else mesh.hanging.edges
    row = found(edge_keys(mesh.cells[:, EDGES]), edge_keys(edges[:, [0, 2]]))
    return np.concatenate([mesh.cells, np.append(edges[:, 1], -1)[row]], axis=1)


def _chosen(mesh: Mesh | SectionMesh, cells: ArrayLike) -> Mask:
    """Mask (n_cells,) of the cells to divide."""
    given, n = np.asarray(cells), len(mesh.cells)
    if given.dtype == bool:
        if given.shape != (n,):
            raise InputError(f"A mask of the cells to divide must be of shape ({n},); found {given.shape}.")
        return given
    out = np.zeros(n, bool)
    if given.size:
        if given.ndim != 1 or given.dtype.kind not in "iu" or given.min() < 0 or given.max() >= n:
            raise InputError(f"Cells to divide are a list of cell numbers 0 ... {n - 1}; found {cells!r:.200}.")
        out[given] = True
    return out


def _refuse_other_ties(mesh: Mesh | SectionMesh) -> None:
    """Refuse hanging nodes that are not those of the divided edges and faces; a division would forget them."""
    if mesh.hanging is None:
        return
    tables = {name: getattr(mesh.hanging, name) for name in TABLES}
    own = tied(**tables, face_nodes=_face_nodes(mesh), n_points=len(mesh.points))
    other = np.setxor1d(mesh.hanging.nodes, [] if own is None else own.nodes)
    if len(other):
        raise InputError(
            f"{len(other)} hanging nodes, the first of them point {other[0]:.0f}, are not those of the divided edges "
            "and faces that the mesh lists; only meshes whose hanging nodes come from `refined` can be divided.",
            code="hanging-of-others",
        )


def _balanced(mesh: Mesh | SectionMesh, chosen: Mask) -> Mask:
    """Add neighbours that would be two levels coarser: an edge of a chosen cell is a part of their edge or face."""
    if mesh.hanging is None:
        return chosen
    ties = mesh.hanging
    keys = _keys(mesh, mesh.cells)
    fine = _incidence(found(keys["edges"], edge_keys(ties.halves[:, :2])), len(ties.halves))
    fine = fine @ sp.csr_matrix((np.ones(len(ties.halves)), (np.arange(len(ties.halves)), ties.halves[:, 3])))
    wholes = {name: keys_of(getattr(ties, name)[:, columns]) for name, (columns, keys_of) in _WHOLE.items()}
    whole = sp.hstack([_incidence(found(keys[name], those), len(those)) for name, those in wholes.items()]).tocsr()
    out, last = chosen.copy(), chosen
    while last.any():
        last = (whole @ (fine.T @ last.astype(float)) > 0) & ~out
        out |= last
    return out


def _keys(mesh: Mesh | SectionMesh, cells: IntArray) -> dict[str, Keys]:
    """Edges (n_cells, n_edges) and faces (n_cells, 6 | 0) of cells of a mesh."""
    if isinstance(mesh, SectionMesh):
        edges, faces = edge_keys(cells[:, QUAD_EDGES]), np.empty((len(cells), 0), np.uint64)
    else:
        edges, faces = edge_keys(cells[:, EDGES]), face_keys(cells[:, FACES[:, :4]])
    return {"edges": edges, "quads": faces, "triangles": faces}


def _incidence(row: IntArray, n: int) -> sp.csr_matrix:
    """Incidence (n_cells, n) of cells and n entities from their numbers (n_cells, k), -1 for none."""
    cell, place = np.nonzero(row >= 0)
    return sp.csr_matrix((np.ones(len(cell)), (cell, row[cell, place])), shape=(len(row), n))


def _without_midface_nodes(mesh: Mesh) -> Mesh:
    """Mesh without mid-face nodes; their faces become a temporary boundary."""
    if mesh.midface is None:
        return mesh
    kept = np.ones(len(mesh.points), bool)
    kept[mesh.midface[mesh.midface >= 0]] = False
    number = np.where(kept, np.cumsum(kept) - 1, -1)
    sets = {name: number[nodes] for name, nodes in mesh.node_sets.items()}
    return replace(
        mesh,
        points=mesh.points[kept],
        cells=number[mesh.cells],
        boundaries={**mesh.boundaries, _MIDFACE: np.argwhere(mesh.midface >= 0)},
        node_sets={name: nodes[nodes >= 0] for name, nodes in sets.items()},
        midface=None,
        hanging=None if mesh.hanging is None else mesh.hanging.renumbered(number, int(kept.sum())),
        file_nodes=None,
    )


def _by_pattern(mesh: Mesh, chosen: Mask) -> list[tuple[IntArray, Pattern]]:
    """Chosen cells by their pattern of coalesced nodes."""
    own = np.flatnonzero(chosen)
    groups = Mesh(mesh.points, mesh.cells[own]).cell_groups if len(own) else ()
    return [(own[g.cells], g.pattern) for g in groups]


def _without_odd_cells(mesh: Mesh, chosen: Mask) -> tuple[Mesh, Mask]:
    """Convert chosen cells that have no division of their own to stars, and choose the cells of these."""
    odd = [(cells, pattern) for cells, pattern in _by_pattern(mesh, chosen) if not divisible(pattern)]
    if not odd:
        return mesh, chosen
    if mesh.cells.shape[1] == 27:
        raise InputError(f"Cell {odd[0][0][0]} is a collapsed cell of 27 nodes; such cells cannot be divided.")
    out, _ = cut(mesh, [(cells, star(pattern)) for cells, pattern in odd])
    turned = np.concatenate([cells for cells, _ in odd])
    rest = np.delete(chosen, turned)
    note = f"{len(turned)} collapsed hexahedra were converted to pyramids and tetrahedra for their division."
    ties = None if mesh.hanging is None else mesh.hanging.renumbered(np.arange(len(mesh.points)), len(out.points))
    chosen = np.concatenate([rest, np.ones(len(out.cells) - len(rest), bool)])
    return replace(out, hanging=ties, notes=(*out.notes, note)), chosen


def _parts(mesh: Mesh, chosen: Mask) -> list[Part]:
    """Chosen cells with their divisions; tetrahedra by the shortest of their three inner diagonals."""
    out: list[Part] = []
    for cells, pattern in _by_pattern(mesh, chosen):
        division = cell_division(pattern)
        if len(set(pattern[:8])) > 4:
            out.append((cells, division))
            continue
        x = mesh.points[mesh.cells[cells[:, None], division.columns[:4]]]
        length = [np.linalg.norm(x[:, a].sum(axis=1) - x[:, b].sum(axis=1), axis=1) for a, b in np.array(DIAGONALS)]
        shortest = np.argmax(np.stack(length) <= (1 + EQUAL) * np.min(length, axis=0), axis=0)
        out += [(cells[shortest == k], cell_division(pattern, k)) for k in np.unique(shortest).tolist()]
    return out


def _divided(mesh: M, parts: list[Part]) -> M:
    """Replace cells by their children and tie the hanging nodes."""
    out, lattices = cut(mesh, parts)
    n_whole = len(mesh.cells) - sum(len(cells) for cells, _ in parts)
    if n_whole == 0:
        return out
    there = _keys(mesh, out.cells[:n_whole])
    tables = {}
    for name in _WHOLE:
        rows = [_rows(lattice, getattr(division, name)) for lattice, (_, division) in zip(lattices, parts, strict=True)]
        tables[name] = _one_sided(name, np.concatenate(rows), there[name], mesh.hanging)
    return replace(out, hanging=tied(**tables, face_nodes=_face_nodes(mesh), n_points=len(out.points)))


def _face_nodes(mesh: Mesh | SectionMesh) -> int:
    """Nodes of a quadrilateral, as in `tied`; of sections only the edges count, which are quadratic."""
    return {8: 4, 20: 8, 27: 9}[mesh.cells.shape[1]] if isinstance(mesh, Mesh) else 8


def _rows(lattice: IntArray, table: IntArray) -> IntArray:
    """Point numbers (n_cells * k, width) for a table (k, width) of a division, -1 for none."""
    return np.where(table < 0, -1, lattice[:, table]).reshape(-1, table.shape[1])


def _one_sided(name: str, new: IntArray, there: Keys, ties: HangingNodes | None) -> IntArray:
    """Rows of a table of `HangingNodes`: edges, quads or triangles divided on one side only.

    Parameters
    ----------
    name : str
        Of the table.
    new : (n, width) int array
        Edges or faces of the divided cells.
    there : (...) keys
        Edges or faces of the undivided cells.
    ties : HangingNodes or None
        Hanging nodes before the division.
    """
    columns, keys_of = _WHOLE[name]
    keys = keys_of(new[:, columns])
    stays = found(keys, there.ravel()) >= 0
    if ties is None:
        rows = new[stays]
    else:
        # parts of an edge or face that was undivided on the other side: by the balance it has been divided too, and
        # its children are undivided
        stays |= found(keys, keys_of(ties.halves[:, :2] if name == "edges" else ties.fine_faces)) >= 0
        old = getattr(ties, name)
        rows = np.concatenate([old[found(keys_of(old[:, columns]), there.ravel()) >= 0], new[stays]])
    return rows[np.unique(keys_of(rows[:, columns]), return_index=True)[1]]
