"""Mesh: what a body is cut into. Points, cells, named boundaries and element sets; frozen, its verbs return a copy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree
from skfem import Mesh as SkfemMesh

from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import positive
from fecontact.common.errors import InputError, MeshError
from fecontact.mesh.element.degenerate import Pattern
from fecontact.mesh.element.hexahedron import EDGES, FACES
from fecontact.mesh.facets import facet_centres, facet_shapes, triangular
from fecontact.mesh.hanging_nodes import HangingNodes, check_hanging, joined_hanging, refuse_hanging
from fecontact.mesh.kinds import kind_of
from fecontact.mesh.pick import Pick
from fecontact.mesh.skfem_mesh import from_skfem_mesh, skfem_mesh

CELL_TYPES = {8: "hex8", 20: "hex20", 27: "hex27"}


@dataclass(frozen=True, eq=False)
class CellGroup:
    """Cells that share one set of shape functions.

    Attributes
    ----------
    cells : (n_cells,) array
        Their numbers in the mesh.
    nodes : (n_cells, n_functions) array
        Distinct nodes in order of first appearance, then mid-face nodes.
    pattern, midfaces
        The kind of element, as `basis.element_basis` takes it.
    """

    cells: IntArray
    nodes: IntArray
    pattern: Pattern
    midfaces: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Hexahedra of 8, 20 or 27 nodes, possibly degenerate, possibly with mid-face nodes on contact faces.

    Parameters
    ----------
    points : (n_points, 3) array
    cells : (n_cells, 8 | 20 | 27) int array
        In VTK's node order. A repeated number is a coalesced node (degenerate element).
    boundaries : mapping of str to (n, 2) int array
        Named sets of faces, each as (cell, local face 0 ... 5).
    groups : mapping of str to (n,) int array
        Named sets of cells.
    node_sets : mapping of str to (n,) int array
        Named sets of points, which supports may name as they do boundaries.
    midface : (n_cells, 6) int array, optional
        Point number of the mid-face node of each face, -1 where there is none; see `with_midface_nodes`.
    notes : tuple of str
        What was mended when the mesh was read; results repeat it.
    hanging : HangingNodes, optional
        Ties of the nodes at which divided cells meet undivided ones; see `fecontact.mesh.hanging_nodes`.

    A member that a set lists more than once counts once.

    Raises
    ------
    MeshError
        If arrays have the wrong shape, refer to points that do not exist, or contain NaN.

    Examples
    --------
    >>> from fecontact import shapes
    >>> mesh = shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> mesh
    Mesh(hex20, 8 cells, 81 points, boundaries: x_min, x_max, y_min, y_max, bottom, top)
    """

    points: Array
    cells: IntArray
    boundaries: Mapping[str, IntArray] = field(default_factory=dict)
    groups: Mapping[str, IntArray] = field(default_factory=dict)
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    midface: IntArray | None = None
    notes: tuple[str, ...] = ()
    hanging: HangingNodes | None = None

    def __post_init__(self) -> None:
        points = np.ascontiguousarray(self.points, dtype=float)
        cells = np.ascontiguousarray(self.cells, dtype=np.int64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise MeshError(f"Points must have the shape (n, 3); found {points.shape}.")
        if cells.ndim != 2 or cells.shape[1] not in CELL_TYPES or len(cells) == 0:
            raise MeshError(f"Cells must be hexahedra of 8, 20 or 27 nodes, shape (n, 8|20|27); found {cells.shape}.")
        if cells.min() < 0 or cells.max() >= len(points):
            wrong = cells.min() if cells.min() < 0 else cells.max()
            raise MeshError(f"A cell refers to point {wrong}, but there are only {len(points)} points (0, 1, ...).")
        if not np.isfinite(points).all():
            bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
            raise MeshError(f"{len(bad)} points have coordinates that are not finite, the first is point {bad[0]}.")
        check_hanging(self.hanging, len(points))
        frozen = {"points": points, "cells": cells}
        for name, value in frozen.items():
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        for name in ("boundaries", "groups", "node_sets"):
            sets = {k: np.asarray(v, dtype=np.int64) for k, v in getattr(self, name).items()}
            object.__setattr__(self, name, MappingProxyType(sets))
        self._check_sets()
        for name in ("boundaries", "groups", "node_sets"):
            object.__setattr__(self, name, sets_of_members(getattr(self, name)))

    def _check_sets(self) -> None:
        n_cells = len(self.cells)
        for name, faces in self.boundaries.items():
            if faces.ndim != 2 or faces.shape[1] != 2 or (faces < 0).any() or (faces >= [n_cells, 6]).any():
                raise MeshError(
                    f"The boundary {name!r} must be (n, 2) pairs (cell, local face), cells below {n_cells} and "
                    f"faces 0 ... 5; found the shape {faces.shape}."
                )
        for name, members in self.groups.items():
            if members.ndim != 1 or (members < 0).any() or (members >= n_cells).any():
                raise MeshError(f"The element set {name!r} must be a list of cell numbers 0 ... {n_cells - 1}.")
        for name, nodes in self.node_sets.items():
            if nodes.ndim != 1 or (nodes < 0).any() or (nodes >= len(self.points)).any():
                raise MeshError(f"The node set {name!r} must be a list of point numbers 0 ... {len(self.points) - 1}.")

    def __reduce__(self) -> tuple[Any, ...]:
        """What goes to another process, or into a copy: what it was made from."""
        given = (getattr(self, f.name) for f in fields(self))
        return type(self), tuple(dict(v) if isinstance(v, Mapping) else v for v in given)

    def __repr__(self) -> str:
        names = ", ".join(self.boundaries) or "none"
        return (
            f"Mesh({' + '.join(self.kinds)}, {len(self.cells)} cells, {len(self.points)} points, boundaries: {names})"
        )

    @classmethod
    def from_skfem(cls, theirs: SkfemMesh) -> Mesh:
        """Take a scikit-fem mesh, with its boundaries, and its subdomains as groups.

        Hexahedra of 8, 20 or 27 nodes, tetrahedra of 4 or 10, wedges of 6. Cells keep their order, and points theirs
        where every one is in use. Left-handed cells, which scikit-fem accepts (its default mesh is one), are put right.

        Raises
        ------
        MeshError
            If the mesh is of other cells.

        Examples
        --------
        >>> from skfem import MeshHex
        >>> Mesh.from_skfem(MeshHex())
        Mesh(hex8, 1 cells, 8 points, boundaries: none)
        """
        return cls(*from_skfem_mesh(theirs))

    def to_skfem(self) -> SkfemMesh:
        """Make it a scikit-fem mesh, with its boundaries, and its groups as subdomains.

        Cells keep their order, points do not. Mid-face nodes carry no geometry and are left behind, as are node sets.

        Raises
        ------
        InputError
            If cells are of several kinds, or of one that scikit-fem has no mesh for, such as wedges of 15 nodes, or if
            nodes hang.

        Examples
        --------
        >>> from fecontact import shapes
        >>> shapes.block((1.0, 1.0, 1.0), (2, 2, 2)).to_skfem().t.shape
        (8, 8)
        """
        refuse_hanging(self.hanging, "turned into one of scikit-fem")
        return skfem_mesh(tuple(self.kinds), (self.points, self.cells, self.boundaries, self.groups))

    @property
    def cell_type(self) -> str:
        """'hex8', 'hex20' or 'hex27': what its cells are before nodes coalesce."""
        return CELL_TYPES[self.cells.shape[1]]

    @property
    def kinds(self) -> dict[str, int]:
        """Number of cells of each kind, such as {'hex20': 12, 'wedge15': 4}; unusual degenerate ones as 'hex20*'."""
        count: dict[str, int] = {}
        for group in self.cell_groups:
            kind = kind_of(group.pattern)
            name = kind.name if kind else f"{self.cell_type}*"
            count[name] = count.get(name, 0) + len(group.cells)
        return count

    @cached_property
    def cell_groups(self) -> tuple[CellGroup, ...]:
        """Cells by kind of element: which nodes have coalesced and which faces carry a mid-face node."""
        cells = self.cells
        first = np.argmax(cells[:, :, None] == cells[:, None, :], axis=2) if self.has_coalesced else None
        has_mid = np.zeros((len(cells), 6), bool) if self.midface is None else self.midface >= 0
        pattern = np.broadcast_to(np.arange(cells.shape[1]), cells.shape) if first is None else first
        kinds, kind_of = np.unique(np.concatenate([pattern, has_mid], axis=1), axis=0, return_inverse=True)
        kind_of = kind_of.ravel()
        out = []
        for k, kind in enumerate(kinds):
            chosen = np.flatnonzero(kind_of == k)
            faces = tuple(np.flatnonzero(kind[-6:]).tolist())
            distinct = np.unique(kind[:-6])
            nodes = cells[np.ix_(chosen, distinct)]
            if faces and self.midface is not None:
                nodes = np.concatenate([nodes, self.midface[np.ix_(chosen, np.asarray(faces))]], axis=1)
            out.append(CellGroup(chosen, nodes, tuple(kind[:-6].tolist()), faces))
        return tuple(out)

    @cached_property
    def has_coalesced(self) -> bool:
        """Whether any cell repeats a node."""
        ordered = np.sort(self.cells, axis=1)
        return bool((ordered[:, 1:] == ordered[:, :-1]).any())

    @cached_property
    def outer_faces(self) -> IntArray:
        """Faces (n, 2) that belong to one cell only, as (cell, local face); collapsed faces are left out."""
        keys = corner_keys(self.cells[:, FACES[:, :4]].reshape(-1, 4))
        _, inverse, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
        outer = np.flatnonzero((count[inverse.ravel()] == 1) & (keys[:, 0] >= 0))
        return np.stack(np.divmod(outer, 6), axis=1)

    def faces(self, name: str) -> IntArray:
        """Faces (n, 2) of a named boundary.

        Raises
        ------
        InputError
            If there is no such boundary; the message lists those there are.
        """
        if name not in self.boundaries:
            known = ", ".join(repr(k) for k in self.boundaries) or "none"
            also = f" Its node sets are: {', '.join(map(repr, self.node_sets))}." if self.node_sets else ""
            raise InputError(f"The mesh has no boundary {name!r}. Its boundaries are: {known}.{also}")
        return self.boundaries[name]

    def face_nodes(self, faces: IntArray) -> IntArray:
        """Node numbers (n_faces, 4 | 8 | 9) of faces; nine where they have a centre or a mid-face node.

        Triangles, faces with one coalesced edge, are turned so that their last two corners are the same node, as
        `mesh.facets` expects.
        """
        n = {8: 4, 20: 8, 27: 9}[self.cells.shape[1]]
        nodes = np.take_along_axis(self.cells[faces[:, 0]], FACES[faces[:, 1], :n], axis=1)
        gone = nodes[:, :4] == np.roll(nodes[:, :4], -1, axis=1)
        triangle = np.flatnonzero(gone.sum(axis=1) == 1)
        turn = (np.arange(4) + np.argmax(gone[triangle], axis=1)[:, None] + 2) % 4
        columns = np.concatenate([turn, 4 + turn], axis=1)[:, : min(n, 8)]
        nodes[triangle[:, None], np.arange(columns.shape[1])] = nodes[triangle[:, None], columns]
        if self.midface is not None:
            mid = self.midface[faces[:, 0], faces[:, 1]]
            if (mid >= 0).all():
                nodes = np.concatenate([nodes, mid[:, None]], axis=1)
        return nodes

    def boundary_nodes(self, name: str) -> IntArray:
        """Distinct node numbers of a named boundary, or of a node set where no boundary has that name."""
        if name in self.node_sets and name not in self.boundaries:
            return np.unique(self.node_sets[name])
        return np.unique(self.face_nodes(self.faces(name)))

    # verbs: each returns a copy

    def mapped(self, mapping: Callable[[Array], ArrayLike]) -> Mesh:
        """Move every point by ``mapping(points) -> points``; hanging nodes follow the others."""
        points = np.asarray(mapping(self.points), dtype=float)
        return replace(self, points=points if self.hanging is None else self.hanging.followed(points))

    def translated(self, offset: ArrayLike) -> Mesh:
        """Move the mesh; to pose a body without touching its coordinates use `ElasticBody.placed`."""
        shift = np.asarray(offset, dtype=float)
        return self.mapped(lambda x: x + shift)

    def scaled(self, factor: float) -> Mesh:
        """Multiply all coordinates, for instance by 1e-3 to come from millimetres to metres."""
        scale = positive("a scale", factor)
        return self.mapped(lambda x: scale * x)

    def with_boundary(self, name: str, where: Pick | Callable[[Array], NDArray[np.bool_]]) -> Mesh:
        """Name outer faces.

        Parameters
        ----------
        name : str
        where : Pick or callable
            A pick (`fecontact.pick`), or ``where(points (n, 3)) -> (n,) bool`` that all corners of a face satisfy.

        Raises
        ------
        InputError
            If no outer face is chosen.
        """
        faces = self.outer_faces
        if isinstance(where, Pick):
            chosen = faces[where.chosen(self, faces)]
        else:
            inside = np.asarray(where(self.points), dtype=bool)
            corners = np.take_along_axis(self.cells[faces[:, 0]], FACES[faces[:, 1], :4], axis=1)
            chosen = faces[inside[corners].all(axis=1)]
        if len(chosen) == 0:
            raise InputError(f"No outer face lies wholly in the region given for the boundary {name!r}.")
        return replace(self, boundaries={**self.boundaries, name: chosen})

    def with_group(self, name: str, where: Callable[[Array], NDArray[np.bool_]]) -> Mesh:
        """Name the cells whose mean corner satisfies ``where(centres (n, 3)) -> (n,) bool``."""
        centres = self.points[self.cells[:, :8]].mean(axis=1)
        return replace(self, groups={**self.groups, name: np.flatnonzero(where(centres))})

    def with_midface_nodes(self, names: tuple[str, ...]) -> Mesh:
        """Give every face of the named boundaries of a 20-node mesh a node at its mapped centre.

        Quadrilaterals get a ninth, triangles a seventh node. The geometry stays that of the 20 nodes. See
        `fecontact.mesh.element.degenerate` for the shape functions.

        Raises
        ------
        InputError
            If the mesh is not of 20-node hexahedra or a face has shrunk to a line.
        """
        if self.cells.shape[1] != 20:
            raise InputError(f"Mid-face nodes belong to 20-node hexahedra; this mesh has {self.cell_type} cells.")
        faces = np.unique(np.concatenate([self.faces(name) for name in names]), axis=0)
        midface = np.full((len(self.cells), 6), -1, dtype=np.int64) if self.midface is None else self.midface.copy()
        new = faces[midface[faces[:, 0], faces[:, 1]] < 0]
        nodes = np.take_along_axis(self.cells[new[:, 0]], FACES[new[:, 1], :4], axis=1)
        ordered = np.sort(nodes, axis=1)
        n_distinct = 1 + (ordered[:, 1:] != ordered[:, :-1]).sum(axis=1)
        if (n_distinct < 3).any():
            cell, face = new[np.argmax(n_distinct < 3)]
            raise InputError(f"Face {face} of cell {cell} has shrunk to a line or a point, so it cannot be in contact.")
        midface[new[:, 0], new[:, 1]] = len(self.points) + np.arange(len(new))
        points = np.concatenate([self.points, self._face_centres(new)])
        n = len(self.points)
        hanging = None if self.hanging is None else self.hanging.renumbered(np.arange(n), len(points))
        return replace(self, points=points, midface=midface, hanging=hanging)

    def _face_centres(self, faces: IntArray) -> Array:
        """Where the 20-node mapping puts the middles (n_faces, 3) of faces."""
        nodes = replace(self, midface=None).face_nodes(faces)
        triangle = triangular(nodes)
        N, _ = facet_shapes(nodes.shape[1], triangle, facet_centres(triangle))
        return np.einsum("na,nai->ni", N, self.points[nodes])

    def upgraded(self, n_nodes: int) -> Mesh:
        """Turn 8-node cells into 20- or 27-node cells with straight edges, adding shared nodes once.

        Coalesced edges stay one node: tetrahedra of 4 nodes become those of 10, wedges of 6 those of 15. Not for
        meshes with hanging nodes.
        """
        if self.cells.shape[1] != 8 or n_nodes not in (20, 27):
            raise InputError(f"Only hex8 can be upgraded, to 20 or 27 nodes; found {self.cell_type} and {n_nodes}.")
        refuse_hanging(self.hanging, "given more nodes")
        if self.has_coalesced and n_nodes == 27:
            raise InputError("Degenerate hex8 cells can be upgraded to 20 nodes only, not to 27.")
        points, columns = [self.points], [self.cells]
        sets = dict(self.node_sets)
        start = len(self.points)
        for local in (EDGES, FACES[:, :4])[: 1 if n_nodes == 20 else 2]:
            corners = self.cells[:, local].reshape(-1, local.shape[1])
            node = corners[:, 0].copy()
            apart = np.flatnonzero((corners != corners[:, :1]).any(axis=1))
            ordered = np.sort(corners[apart], axis=1)
            ends, inverse = np.unique(ordered, axis=0, return_inverse=True)
            points.append(self.points[ends].mean(axis=1))
            node[apart] = start + inverse.ravel()
            for name, members in self.node_sets.items():
                between = start + np.flatnonzero(np.isin(ends, members).all(axis=1))
                sets[name] = np.concatenate([sets[name], between])
            columns.append(node.reshape(len(self.cells), -1))
            start += len(ends)
        if n_nodes == 27:
            points.append(self.points[self.cells].mean(axis=1))
            columns.append(start + np.arange(len(self.cells))[:, None])
        return replace(self, points=np.concatenate(points), cells=np.concatenate(columns, axis=1), node_sets=sets)

    def part(self, name: str) -> Mesh:
        """Take the cells of an element set as a mesh of its own, for instance one body out of a file with several.

        Raises
        ------
        InputError
            If there is no such set, mid-face nodes have been added already, or nodes hang.
        """
        if name not in self.groups:
            known = ", ".join(map(repr, self.groups)) or "none"
            raise InputError(f"The mesh has no element set {name!r}. Its element sets are: {known}.")
        if self.midface is not None:
            raise InputError("Take the part before mid-face nodes are added.")
        refuse_hanging(self.hanging, "cut into parts")
        kept = np.unique(self.groups[name])
        cell = np.full(len(self.cells), -1, dtype=np.int64)
        cell[kept] = np.arange(len(kept))
        used, cells = np.unique(self.cells[kept], return_inverse=True)
        point = np.full(len(self.points), -1, dtype=np.int64)
        point[used] = np.arange(len(used))
        moved = {k: np.stack([cell[f[:, 0]], f[:, 1]], axis=1) for k, f in self.boundaries.items()}
        return Mesh(
            self.points[used],
            cells.reshape(len(kept), -1),
            {k: f[f[:, 0] >= 0] for k, f in moved.items() if (f[:, 0] >= 0).any()},
            {k: _kept(cell[g]) for k, g in self.groups.items() if len(_kept(cell[g]))},
            {k: _kept(point[n]) for k, n in self.node_sets.items() if len(_kept(point[n]))},
            notes=self.notes,
        )


def sets_of_members(lists: Mapping[str, IntArray]) -> Mapping[str, IntArray]:
    """Named lists of numbers (n,) or of faces (n, 2) as sets: each member once, where it was first."""
    out = {}
    for name, members in lists.items():
        keys = members if members.ndim == 1 else members @ np.array([6, 1])
        first = np.unique(keys, return_index=True)[1]
        out[name] = members if len(first) == len(members) else members[np.sort(first)]
    return MappingProxyType(out)


def first_alike(corners: IntArray) -> IntArray:
    """For each cell (n, 8 | 4 corners) the number (n,) of the first with the same corners, whatever their order."""
    ordered = np.sort(corners, axis=1)
    again = ordered[:, 1:] == ordered[:, :-1]
    ordered[:, 1:][again] = -1
    ordered.sort(axis=1)
    _, first, inverse = np.unique(ordered, axis=0, return_index=True, return_inverse=True)
    return np.asarray(first[inverse.ravel()], dtype=np.int64)


def corner_keys(corners: IntArray) -> IntArray:
    """Sorted corners (n, 4) of faces, equal for equal faces.

    A triangle may list a different one of its corners twice in each of its two cells, so the largest is repeated. Faces
    that have become a line or a point get -1.
    """
    ordered = np.sort(corners, axis=1)
    first = np.concatenate([np.ones((len(ordered), 1), bool), ordered[:, 1:] != ordered[:, :-1]], axis=1)
    count = first.sum(axis=1)
    triangle = count == 3
    three = ordered[triangle][first[triangle]].reshape(-1, 3)
    ordered[triangle] = np.concatenate([three, three[:, -1:]], axis=1)
    ordered[count < 3] = -1
    return ordered


def _kept(numbers: IntArray) -> IntArray:
    return numbers[numbers >= 0]


def representatives(points: Array, tolerance: float) -> IntArray:
    """For each point the smallest number (n_points,) of the cluster of points closer than `tolerance`."""
    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    target = np.arange(len(points))
    # repeated until chains of pairs have settled
    while True:
        before = target.copy()
        np.minimum.at(target, pairs[:, 1], target[pairs[:, 0]])
        np.minimum.at(target, pairs[:, 0], target[pairs[:, 1]])
        if np.array_equal(before, target):
            return target


def merge(meshes: list[Mesh], tolerance: float) -> Mesh:
    """Join meshes of one cell type into one; points closer than `tolerance` (a length) become one point.

    Boundaries and groups of the same name are joined; faces that have become interior leave their boundaries.

    Raises
    ------
    MeshError
        If the cell types differ, or a hanging node would become one with a point of another mesh.
    """
    if len({m.cells.shape[1] for m in meshes}) != 1:
        raise MeshError(f"Meshes of different cells cannot be merged: {sorted({m.cell_type for m in meshes})}.")
    point_start = np.cumsum([0] + [len(m.points) for m in meshes])
    cell_start = np.cumsum([0] + [len(m.cells) for m in meshes])
    points = np.concatenate([m.points for m in meshes])
    target = representatives(points, tolerance)
    kept, number = np.unique(target, return_inverse=True)
    cells = number[np.concatenate([m.cells + p for m, p in zip(meshes, point_start[:-1], strict=True)])]
    parts = np.split(number, point_start[1:-1])
    whole = Mesh(points[kept], cells, hanging=joined_hanging([m.hanging for m in meshes], parts, len(kept)))
    outer = {tuple(face) for face in whole.outer_faces.tolist()}
    boundaries: dict[str, list[list[int]]] = {}
    groups: dict[str, list[int]] = {}
    node_sets: dict[str, list[int]] = {}
    for m, c, p in zip(meshes, cell_start[:-1].tolist(), point_start[:-1].tolist(), strict=True):
        for name, faces in m.boundaries.items():
            moved = (faces + np.array([c, 0])).tolist()
            boundaries.setdefault(name, []).extend(f for f in moved if tuple(f) in outer)
        for name, members in m.groups.items():
            groups.setdefault(name, []).extend((members + c).tolist())
        for name, nodes in m.node_sets.items():
            node_sets.setdefault(name, []).extend(number[nodes + p].tolist())
    return replace(
        whole,
        boundaries={k: np.array(v, dtype=np.int64) for k, v in boundaries.items() if v},
        groups={k: np.array(v, dtype=np.int64) for k, v in groups.items()},
        node_sets={k: np.unique(v) for k, v in node_sets.items()},
        notes=tuple(dict.fromkeys(note for m in meshes for note in m.notes)),
    )
