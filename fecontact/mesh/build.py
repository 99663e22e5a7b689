"""Mesh from the contents of a file: cells become hexahedra, sets become boundaries; all are checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError
from fecontact.mesh.cell_sets import first_alike
from fecontact.mesh.check import check_cells
from fecontact.mesh.element.hexahedron import FACES
from fecontact.mesh.entities import corner_keys
from fecontact.mesh.formats.raw import RawMesh
from fecontact.mesh.kinds import KINDS, Kind
from fecontact.mesh.mesh import Mesh

#: Columns of the cells of each requested element.
ELEMENTS = {"hex20": 20, "wedge15": 20, "tet10": 20, "hex27": 27}


def build(raw: RawMesh, source: str, scale: float = 1.0, element: str | None = None) -> Mesh:
    """Mesh from the checked contents of a file; parameters as in `read_mesh`."""
    blocks = [(KINDS[name], cells) for name, cells in raw.blocks if len(cells)]
    if not blocks:
        raise MeshError(
            f"{source} holds no solid cells. Expected hexahedra, wedges, pyramids or tetrahedra; surfaces are "
            "read with fc.read_surface."
        )
    _check_numbers(raw, blocks, source)
    points = scale * raw.points
    cells = _as_hexahedra(points, blocks, source, element)
    cells, raw, notes = _each_once(cells, raw, source)
    used, number = np.unique(cells), np.full(len(points), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    node_sets = {name: number[nodes] for name, nodes in raw.node_sets.items()}
    mesh = Mesh(
        points[used],
        number[cells],
        groups=raw.groups,
        node_sets={name: np.unique(n[n >= 0]) for name, n in node_sets.items() if (n >= 0).any()},
        notes=(*raw.notes, *notes),
    )
    facets = {name: [number[f] for f in parts] for name, parts in raw.facets.items()}
    boundaries = _boundaries(mesh, raw.faces, facets, source)
    mesh = replace(mesh, boundaries=boundaries)
    if element is not None and mesh.cells.shape[1] == 8:
        mesh = mesh.upgraded(ELEMENTS[element])
    check_cells(mesh)
    return mesh


def _check_numbers(raw: RawMesh, blocks: list[tuple[Kind, IntArray]], source: str) -> None:
    for kind, cells in blocks:
        if cells.shape[1] != kind.n_nodes:
            raise MeshError(f"{source}: {kind.name} cells need {kind.n_nodes} nodes; found {cells.shape[1]}.")
    largest, smallest = max(int(c.max()) for _, c in blocks), min(int(c.min()) for _, c in blocks)
    if smallest < 0 or largest >= len(raw.points):
        raise MeshError(
            f"{source}: cells refer to point {largest if smallest >= 0 else smallest}, but there are "
            f"{len(raw.points)} points. The file is incomplete."
        )
    if not np.isfinite(raw.points).all():
        bad = int(np.argmin(np.isfinite(raw.points).all(axis=1)))
        raise MeshError(f"{source}: point {bad} has coordinates that are not finite: {raw.points[bad]}.")


def _as_hexahedra(points: Array, blocks: list[tuple[Kind, IntArray]], source: str, element: str | None) -> IntArray:
    """Connectivity of all blocks in one array of 8, 20 or 27 columns."""
    parts = [kind.to_hexahedra(in_order(points, kind, cells)) for kind, cells in blocks]
    if element in ("hex20", "wedge15", "tet10"):
        parts = [p[:, :20] for p in parts]
    widths = {p.shape[1] for p in parts}
    if len(widths) > 1:
        names = ", ".join(sorted({kind.name for kind, _ in blocks}))
        raise MeshError(
            f"{source} mixes cells of different order: {names}. Neighbours would not fit together; write all cells "
            "linear or all quadratic (27-node cells beside others: read with element='hex20')."
        )
    return np.concatenate(parts)


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
    return cells[own], replace(raw, groups=groups, faces=faces), (note,)


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


def _boundaries(
    mesh: Mesh, faces: Mapping[str, IntArray], facets: dict[str, list[IntArray]], source: str
) -> dict[str, IntArray]:
    """Boundaries by faces, by the corner nodes of their facets, and by node sets that cover whole outer faces."""
    out = {name: f for name, f in faces.items() if len(f)}
    if facets:
        out.update(_matched(mesh, facets, source))
    outer = mesh.outer_faces
    corners = np.take_along_axis(mesh.cells[outer[:, 0]], FACES[outer[:, 1], :4], axis=1)
    for name, nodes in mesh.node_sets.items():
        member = np.zeros(len(mesh.points), bool)
        member[nodes] = True
        inside = member[corners].all(axis=1)
        if name not in out and inside.any():
            out[name] = outer[inside]
    return out


def _matched(mesh: Mesh, facets: dict[str, list[IntArray]], source: str) -> dict[str, IntArray]:
    """Faces of the cells with the same corners as the given facets; an inner face is taken from its first cell."""
    keys = corner_keys(mesh.cells[:, FACES[:, :4]].reshape(-1, 4))
    corners = {name: np.concatenate([f[:, [0, 1, 2, -1]] for f in parts]) for name, parts in facets.items()}
    owner = np.repeat(np.arange(len(facets)), [len(c) for c in corners.values()])
    all_keys = np.concatenate([keys, corner_keys(np.concatenate(list(corners.values())))])
    _, first, inverse = np.unique(all_keys, axis=0, return_index=True, return_inverse=True)
    match = first[inverse.ravel()[len(keys) :]]
    match[all_keys[len(keys) :, 0] < 0] = len(keys)
    out = {}
    for k, name in enumerate(facets):
        mine = match[owner == k]
        if (mine >= len(keys)).any():
            raise MeshError(
                f"{source}: {(mine >= len(keys)).sum()} of the {len(mine)} facets of the surface {name!r} are faces of "
                "no solid cell. Remove that part (a shell or a loose surface) or mesh surface and solid together."
            )
        out[name] = np.unique(np.stack(np.divmod(mine, 6), axis=1), axis=0)
    return out
