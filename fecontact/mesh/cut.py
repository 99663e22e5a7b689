"""Replace cells of a mesh by their children: numbering of the new nodes, mapping of all sets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.cell_division import CellDivision
from fecontact.mesh.cell_sets import CellSets
from fecontact.mesh.facets import edge_keys, face_keys, found
from fecontact.mesh.hanging_nodes import HangingNodes

C = TypeVar("C", bound=CellSets)
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


def _numbered(mesh: CellSets, parts: Sequence[Part]) -> tuple[list[IntArray], int]:
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


def _new_points(mesh: CellSets, parts: Sequence[Part], lattices: list[IntArray], n_points: int) -> Array:
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
        place = np.full(len(divided), -1)
        place[parents] = np.arange(len(parents))
        mine = faces[place[faces[:, 0]] >= 0]
        child, face = np.moveaxis(division.facets[mine[:, 1]], 2, 0)
        number = first + len(division.children) * place[mine[:, :1]] + child
        out.append(np.stack([number, face], axis=2)[child >= 0])
    return np.concatenate(out)


def _number(divided: Mask) -> IntArray:
    """New numbers (n_cells,) of the undivided cells."""
    return np.cumsum(~divided) - 1


def _with_new_nodes(nodes: IntArray, mesh: CellSets, parts: Sequence[Part], lattices: list[IntArray]) -> IntArray:
    """Node set with the new points on edges, faces and cells that have all their nodes in it."""
    member = np.zeros(len(mesh.points), bool)
    member[nodes] = True
    out = [nodes]
    for (cells, division), lattice in zip(parts, lattices, strict=True):
        outside = ~member[mesh.cells[cells[:, None], division.columns]]
        within = outside.astype(float) @ division.entity.T == 0
        out.append(lattice[within & (lattice >= len(mesh.points))])
    return np.unique(np.concatenate(out))
