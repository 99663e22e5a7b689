"""Mesh from the contents of a file: cells become hexahedra, sets become boundaries; all are checked.

Cells of different order in one mesh: linear ones get mid-edge nodes, those of their quadratic neighbours first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError
from fecontact.mesh.base_mesh import first_alike
from fecontact.mesh.check import check_cells, check_size
from fecontact.mesh.element import EDGES, FACES
from fecontact.mesh.facets import corner_keys, numbered_between, places_among
from fecontact.mesh.formats.raw import RawMesh
from fecontact.mesh.kinds import KINDS, Kind
from fecontact.mesh.mesh import Mesh


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
    nodes, ends = numbered_between(edges, len(points), given)
    columns = np.split(nodes, np.cumsum([12 * len(p) for p in wide])[:-1])
    cells = [np.concatenate([p[:, :8], c.reshape(len(p), 12)], axis=1) for p, c in zip(wide, columns, strict=True)]
    return np.concatenate([points, points[ends].mean(axis=1)]), cells, ends


#: Columns of the cells of each requested element.
ELEMENTS = {"hex20": 20, "wedge15": 20, "tet10": 20, "hex27": 27}
#: Words of the note on cells of different order.
MIXED = "mixes cells of different order"


def build(raw: RawMesh, source: str, scale: float = 1.0, element: str | None = None) -> Mesh:
    """Mesh from the checked contents of a file; parameters as in `read_mesh`."""
    blocks = [(KINDS[name], cells) for name, cells in raw.blocks if len(cells)]
    if not blocks:
        raise MeshError(
            f"{source} holds no solid cells{_listed(_all_left(raw), '. It holds ')}. Expected hexahedra, wedges, "
            "pyramids or tetrahedra of up to 27 nodes; surfaces are read with fc.read_surface.",
            code="no-solid-cells",
        )
    _check_numbers(raw, blocks, source)
    points, cells, ends, notes = _as_hexahedra(scale * raw.points, blocks, source, element)
    cells, raw, repeats = _each_once(cells, raw, source)
    used = np.unique(cells)
    number = places_among(used, len(points))
    # a set with both ends of an edge has the node added in its middle, as linear displacements between them say
    new = len(raw.points) + np.arange(len(ends))
    sets = {k: np.append(nodes, new[np.isin(ends, nodes).all(axis=1)]) for k, nodes in raw.node_sets.items()}
    node_sets = {name: number[nodes] for name, nodes in sets.items()}
    ids = raw.node_ids
    mesh = Mesh(
        points[used],
        number[cells],
        groups={name: members for name, members in raw.groups.items() if len(members)},
        node_sets={name: np.unique(n[n >= 0]) for name, n in node_sets.items() if (n >= 0).any()},
        file_nodes=None if ids is None else np.pad(ids, (0, len(points) - len(ids)), constant_values=-1)[used],
        file_elements=raw.element_ids,
    )
    boundaries, left = _boundaries(mesh, raw, number)
    told = _listed({**_all_left(raw, shells=False), **left}, f"{source}: left out, as no solid cells: ")
    mesh = replace(mesh, boundaries=boundaries, notes=(*raw.notes, *notes, *repeats, *([f"{told}."] if told else [])))
    if element is not None and mesh.cells.shape[1] == 8:
        mesh = mesh.upgraded(ELEMENTS[element])
    check_cells(mesh)
    return mesh


def _all_left(raw: RawMesh, shells: bool = True) -> dict[str, int]:
    """What a file holds besides solids, by kind, with its number."""
    facets = {f"facets of the shell {k!r}": sum(map(len, v)) for k, v in raw.shells.items()} if shells else {}
    return {**raw.left, **facets}


def _listed(left: Mapping[str, int], before: str) -> str:
    """What was left, as a list after `before`; empty if there is nothing."""
    return before + "; ".join(f"{n} {what}" for what, n in left.items()) if left else ""


def _check_numbers(raw: RawMesh, blocks: list[tuple[Kind, IntArray]], source: str) -> None:
    for kind, cells in blocks:
        if cells.shape[1] != kind.n_nodes:
            raise MeshError(f"{source}: {kind.name} cells need {kind.n_nodes} nodes; found {cells.shape[1]}.")
    largest, smallest = max(int(c.max()) for _, c in blocks), min(int(c.min()) for _, c in blocks)
    if smallest < 0 or largest >= len(raw.points):
        raise MeshError(
            f"{source}: cells refer to point {largest if smallest >= 0 else smallest}, but there are "
            f"{len(raw.points)} points. The file is incomplete.",
            code="unknown-point",
        )
    if not np.isfinite(raw.points).all():
        bad = int(np.argmin(np.isfinite(raw.points).all(axis=1)))
        raise MeshError(
            f"{source}: point {bad} has coordinates that are not finite: {raw.points[bad]}.", code="not-finite"
        )
    with np.errstate(over="ignore"):
        check_size(raw.points[np.unique(np.concatenate([c.ravel() for _, c in blocks]))])


def _as_hexahedra(
    points: Array, blocks: list[tuple[Kind, IntArray]], source: str, element: str | None
) -> tuple[Array, IntArray, IntArray, tuple[str, ...]]:
    """Points and connectivity of all blocks in one array of 8, 20 or 27 columns, ends of added points, and notes.

    Cells of different order become all of 20 nodes.
    """
    parts = [kind.to_hexahedra(in_order(points, kind, cells)) for kind, cells in blocks]
    if element in ("hex20", "wedge15", "tet10"):
        parts = [p[:, :20] for p in parts]
    if len({p.shape[1] for p in parts}) == 1:
        return points, np.concatenate(parts), np.zeros((0, 2), np.int64), ()
    points, cells, ends = same_order(points, parts)
    linear = sum(len(p) for p in parts if p.shape[1] == 8)
    dropped = sum(len(p) for p in parts if p.shape[1] == 27)
    notes = [f"{linear} linear cells got nodes in the middles of their edges"] if linear else []
    notes += [f"{dropped} cells of 27 nodes were reduced to 20"] if dropped else []
    return points, np.concatenate(cells), ends, (f"{source} {MIXED}: {', '.join(notes)}.",)


def _each_once(cells: IntArray, raw: RawMesh, source: str) -> tuple[IntArray, RawMesh, tuple[str, ...]]:
    """Drop repeated cells: gmsh's format 2 writes a cell once for each of its groups.

    Element sets and surfaces keep their members.
    """
    first = first_alike(cells[:, :8])
    own = first == np.arange(len(cells))
    if own.all():
        return cells, raw, ()
    number = (np.cumsum(own) - 1)[first]
    faces = {}
    for name, given in raw.faces.items():
        keys = corner_keys(cells[given[:, 0, None], FACES[given[:, 1], :4]])
        others = corner_keys(cells[first[given[:, 0]]][:, FACES[:, :4]].reshape(-1, 4)).reshape(-1, 6, 4)
        local = (others == keys[:, None]).all(axis=2).argmax(axis=1)
        faces[name] = np.stack([number[given[:, 0]], local], axis=1)
    note = f"{source} lists {(~own).sum()} of its {len(own)} cells again: each is taken once."
    groups = {name: np.unique(number[members]) for name, members in raw.groups.items()}
    ids = None if raw.element_ids is None else raw.element_ids[own]
    return cells[own], replace(raw, groups=groups, faces=faces, element_ids=ids), (note,)


def in_order(points: Array, kind: Kind, cells: IntArray) -> IntArray:
    """Sort mid-edge and face nodes into the order of `Mesh`, from any order of the file.

    Each node is assigned to the edge (face, centre) with the nearest middle, on average over all cells and relative to
    the cell's size. Corners keep their order.
    """
    if len(kind.mid_edges) == 0:
        return cells
    x = points[cells]
    corners = x[:, : kind.n_corners]
    middles = [corners[:, list(ends)].mean(axis=1) for _, ends in sorted(kind.mid_edges.items())]
    if kind.n_nodes == 27:
        middles += [corners[:, FACES[f, :4]].mean(axis=1) for f in range(6)] + [corners.mean(axis=1)]
    target = np.stack(middles, axis=1)
    size = np.linalg.norm(np.ptp(corners, axis=1), axis=1)
    found = x[:, kind.n_corners :]
    distance = np.zeros((found.shape[1], target.shape[1]))
    for k in range(target.shape[1]):
        distance[:, k] = (np.linalg.norm(found - target[:, k : k + 1], axis=2) / size[:, None]).mean(axis=0)
    node, place = linear_sum_assignment(distance**2)
    ordered = cells.copy()
    ordered[:, kind.n_corners + place] = cells[:, kind.n_corners + node]
    return ordered


def _boundaries(mesh: Mesh, raw: RawMesh, number: IntArray) -> tuple[dict[str, IntArray], dict[str, int]]:
    """Boundaries by faces, by the corner nodes of their facets, and by node sets that cover whole outer faces.

    Also returns the numbers of facets that are faces of no solid cell, by what they belong to. A surface keeps the
    others; a shell becomes a boundary only as a whole.
    """
    out, left = {name: f for name, f in raw.faces.items() if len(f)}, {}
    facets = {k: np.concatenate([number[f[:, [0, 1, 2, -1]]] for f in v]) for k, v in raw.facets.items() if v}
    shells = {k: np.concatenate([number[f[:, [0, 1, 2, -1]]] for f in v]) for k, v in raw.shells.items() if v}
    for name, faces in _matched(mesh, facets | {k: v for k, v in shells.items() if k not in facets}).items():
        given = facets[name] if name in facets else shells[name]
        lost = len(given) - len(faces)
        if name in facets and lost:
            left[f"facets of the surface {name!r} on no solid cell"] = lost
        elif lost:
            left[f"facets of the shell {name!r}"] = len(given)
        if len(faces) and not (lost and name not in facets):
            out[name] = np.unique(faces, axis=0)
    outer = mesh.outer_faces
    corners = np.take_along_axis(mesh.cells[outer[:, 0]], FACES[outer[:, 1], :4], axis=1)
    for name, nodes in mesh.node_sets.items():
        member = np.zeros(len(mesh.points), bool)
        member[nodes] = True
        inside = member[corners].all(axis=1)
        if name not in out and inside.any():
            out[name] = outer[inside]
    return out, left


def _matched(mesh: Mesh, facets: Mapping[str, IntArray]) -> dict[str, IntArray]:
    """Faces (n, 2) of the cells with the same corners as given facets (n, 4); an inner face from its first cell."""
    if not facets:
        return {}
    keys = corner_keys(mesh.cells[:, FACES[:, :4]].reshape(-1, 4))
    owner = np.repeat(np.arange(len(facets)), [len(c) for c in facets.values()])
    all_keys = np.concatenate([keys, corner_keys(np.concatenate(list(facets.values())))])
    _, first, inverse = np.unique(all_keys, axis=0, return_index=True, return_inverse=True)
    match = first[inverse.ravel()[len(keys) :]]
    match[all_keys[len(keys) :, 0] < 0] = len(keys)
    out = {}
    for k, name in enumerate(facets):
        mine = match[owner == k]
        out[name] = np.stack(np.divmod(mine[mine < len(keys)], 6), axis=1)
    return out
