"""Mesh of a body: points, cells, named boundaries and element sets. Frozen; its methods return a copy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from skfem import Mesh as SkfemMesh

from fecontact.common.arguments import known_options, texts
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import whole
from fecontact.common.errors import InputError
from fecontact.common.html import cell
from fecontact.common.units import UnitNames
from fecontact.mesh.base_mesh import BaseMesh, joined
from fecontact.mesh.element import EDGES, FACES, Pattern
from fecontact.mesh.facets import (
    cells_at_faces,
    face_keys,
    facet_centres,
    facet_shapes,
    numbered_between,
    triangular,
)
from fecontact.mesh.hanging_nodes import refuse_hanging
from fecontact.mesh.kinds import KINDS, kind_of
from fecontact.mesh.pick import Pick
from fecontact.mesh.skfem_mesh import from_skfem_mesh, skfem_mesh

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
        The kind of element, as in `element_basis`.
    """

    cells: IntArray
    nodes: IntArray
    pattern: Pattern
    midfaces: tuple[int, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Mesh(BaseMesh):
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
        Named sets of points; supports may refer to them as to boundaries.
    midface : (n_cells, 6) int array, optional
        Point number of the mid-face node of each face, -1 where there is none; see `with_midface_nodes`.
    notes : tuple of str
        Corrections made when the mesh was read; results repeat them.
    hanging : HangingNodes, optional
        Ties of the nodes at which divided cells meet undivided ones; see `fecontact.mesh.hanging_nodes`.
    file_nodes : (n_points,) int array, optional
        Numbers of the points in the file that the mesh was read from; -1 for others.
    file_elements : (n_cells,) int array, optional
        Numbers of the cells there.
    warnings : tuple of str
        Warnings that results repeat.

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

    midface: IntArray | None = None
    notes: tuple[str, ...] = ()

    _noun = "mesh"
    _face = "face"
    _made_of = "hexahedra of 8, 20 or 27 nodes, shape (n, 8|20|27)"
    cell_types = MappingProxyType({8: "hex8", 20: "hex20", 27: "hex27"})
    n_corners = 8
    n_faces = 6

    @classmethod
    def from_skfem(cls, theirs: SkfemMesh) -> Mesh:
        """Mesh from a scikit-fem mesh, with its boundaries; its subdomains become groups.

        Hexahedra of 8, 20 or 27 nodes, tetrahedra of 4 or 10, wedges of 6. Cells keep their order, and so do points if
        all are in use. Left-handed cells, which scikit-fem accepts (as in its default mesh), are reordered.

        Raises
        ------
        MeshError
            If the mesh has other cells.

        Examples
        --------
        >>> from skfem import MeshHex
        >>> Mesh.from_skfem(MeshHex())
        Mesh(hex8, 1 cells, 8 points, boundaries: none)
        """
        return cls(*from_skfem_mesh(theirs))

    def to_skfem(self) -> SkfemMesh:
        """scikit-fem mesh with the same boundaries; groups become subdomains.

        Cells keep their order, points do not. Mid-face nodes, which carry no geometry, and node sets are left out.

        Raises
        ------
        InputError
            If cells are of several kinds, or of one without a scikit-fem mesh, such as wedges of 15 nodes, or if there
            are hanging nodes.

        Examples
        --------
        >>> from fecontact import shapes
        >>> shapes.block((1.0, 1.0, 1.0), (2, 2, 2)).to_skfem().t.shape
        (8, 8)
        """
        refuse_hanging(self.hanging, "turned into one of scikit-fem")
        return skfem_mesh(tuple(self.kinds), (self.points, self.cells, self.boundaries, self.groups))

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
        """Cells grouped by kind of element: coalesced nodes and faces with a mid-face node."""
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
        """Faces (n, 2) that belong to one cell only, as (cell, local face); collapsed faces are left out.

        Those at which divided cells meet undivided ones are not outer.
        """
        single = cells_at_faces(self.cells) == 1
        if self.hanging is not None:
            single &= ~np.isin(face_keys(self.cells[:, FACES[:, :4]]), face_keys(self.hanging.faces))
        return np.argwhere(single)

    @property
    def outer(self) -> IntArray:
        """The same as `outer_faces`, by the name shared with `SectionMesh`."""
        return self.outer_faces

    @property
    def skin(self) -> IntArray:
        """Corners and mid-sides (n, 4 | 8 | 9) of the faces that are seen, turned outwards if the cells are."""
        return replace(self, midface=None).face_nodes(self.outer_faces)

    def _repr_html_(self) -> str:
        return cell(repr(self), self.plot)

    def plot(self, path: str | Path | None = None, *, units: UnitNames = (), **options: Any) -> Figure:
        """Picture of the outer faces, boundaries in colours and numbered: a matplotlib figure.

        Parameters
        ----------
        path : str or Path, optional
            File to write; the suffix decides the format.
        units : (length, ...) or str
            Names of units, of which the ruler shows that of length; or it alone.
        **options
            ``view`` (its direction), ``edges``, see `mesh.picture.plot_faces`.

        Raises
        ------
        InputError
            For an unknown option or view, or a file that cannot be written.

        Examples
        --------
        >>> from fecontact import shapes
        >>> figure = shapes.block((1.0, 1.0, 1.0), (2, 2, 2)).plot(units="mm")
        >>> [text.get_text() for text in figure.legends[0].get_texts()][:2]
        ['1  x_min, 4 faces', '2  x_max, 4 faces']
        """
        from fecontact.mesh.picture import plot_faces

        known_options(plot_faces, options)
        seen = self.outer_faces
        keys = seen @ (6, 1)
        found = {name: np.flatnonzero(np.isin(keys, faces @ (6, 1))) for name, faces in self.boundaries.items()}
        return plot_faces(self.points, self.skin, found, path, self.size_line, units=units, **options)

    def native_cells(self) -> list[tuple[str, IntArray, IntArray]]:
        """Cells by kind: name in meshio, connectivity in VTK's node order, and their (increasing) numbers.

        Wedges, pyramids and tetrahedra instead of degenerate hexahedra; those that are neither stay hexahedra. Mid-face
        nodes are left out. The first triangle of a wedge has its normal towards the second one, as in gmsh; meshio
        turns wedges of six nodes on the way into a VTK file, where VTK has it the other way round.

        Examples
        --------
        >>> from fecontact import shapes
        >>> [(name, cells.shape) for name, cells, _ in shapes.block((1.0, 1.0, 1.0), (2, 1, 1)).native_cells()]
        [('hexahedron20', (2, 20))]
        """
        parts: dict[str, list[tuple[IntArray, IntArray]]] = {}
        for group in self.cell_groups:
            kind = kind_of(group.pattern)
            if kind is None:
                part = (self.cells[group.cells], group.cells)
                kind = KINDS[self.cell_type]
            else:
                part = (group.nodes[:, : kind.n_nodes], group.cells)
            parts.setdefault(kind.meshio, []).append(part)
        out = []
        for name, found in parts.items():
            cells, numbers = (np.concatenate(arrays) for arrays in zip(*found, strict=True))
            order = np.argsort(numbers)
            out.append((name, cells[order], numbers[order]))
        return out

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

    def drawn_at(self, points: Array) -> Self:
        """The same mesh at other points (n_points, 3)."""
        return replace(self, points=points)

    # further methods: each returns a copy

    def _chosen(self, where: Pick | Callable[[Array], Mask]) -> Mask:
        return where.chosen(self, self.outer) if isinstance(where, Pick) else super()._chosen(where)

    def with_midface_nodes(self, names: tuple[str, ...]) -> Mesh:
        """Give every face of the named boundaries of a 20-node mesh a node at its mapped centre.

        Quadrilaterals get a ninth, triangles a seventh node. The geometry stays that of the 20 nodes. See
        `fecontact.mesh.element` for the shape functions.

        Raises
        ------
        InputError
            If the mesh is not of 20-node hexahedra or a face has shrunk to a line.
        """
        if self.cells.shape[1] != 20:
            raise InputError(f"Mid-face nodes belong to 20-node hexahedra; this mesh has {self.cell_type} cells.")
        given = texts("the boundaries that get mid-face nodes", names)
        faces = np.unique(np.concatenate([np.zeros((0, 2), np.int64), *map(self.faces, given)]), axis=0)
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
        """Centres (n_faces, 3) of faces by the 20-node mapping."""
        nodes = replace(self, midface=None).face_nodes(faces)
        triangle = triangular(nodes)
        N, _ = facet_shapes(nodes.shape[1], triangle, facet_centres(triangle))
        return np.einsum("na,nai->ni", N, self.points[nodes])

    def upgraded(self, n_nodes: int) -> Mesh:
        """Turn 8-node cells into 20- or 27-node cells with straight edges, adding shared nodes once.

        Coalesced edges stay one node: tetrahedra of 4 nodes become those of 10, wedges of 6 those of 15. Not for
        meshes with hanging nodes.
        """
        if self.cells.shape[1] != 8 or whole("the number of nodes", n_nodes) not in (20, 27):
            raise InputError(f"Only hex8 can be upgraded, to 20 or 27 nodes; found {self.cell_type} and {n_nodes}.")
        refuse_hanging(self.hanging, "given more nodes")
        if self.has_coalesced and n_nodes == 27:
            raise InputError("Degenerate hex8 cells can be upgraded to 20 nodes only, not to 27.", code="degenerate")
        points, columns = [self.points], [self.cells]
        sets = dict(self.node_sets)
        start = len(self.points)
        for local in (EDGES, FACES[:, :4])[: 1 if n_nodes == 20 else 2]:
            corners = self.cells[:, local].reshape(-1, local.shape[1])
            node, ends = numbered_between(corners, start)
            points.append(self.points[ends].mean(axis=1))
            for name, members in self.node_sets.items():
                between = start + np.flatnonzero(np.isin(ends, members).all(axis=1))
                sets[name] = np.concatenate([sets[name], between])
            columns.append(node.reshape(len(self.cells), -1))
            start += len(ends)
        if n_nodes == 27:
            points.append(self.points[self.cells].mean(axis=1))
            columns.append(start + np.arange(len(self.cells))[:, None])
        return replace(self, points=np.concatenate(points), cells=np.concatenate(columns, axis=1), node_sets=sets)


def merge(meshes: list[Mesh], tolerance: float) -> Mesh:
    """Join meshes of one cell type into one; points closer than `tolerance` (a length) become one point.

    Sets of the same name are joined; faces that have become interior leave their boundaries.

    Raises
    ------
    MeshError
        If the cell types differ, or a hanging node would become one with a point of another mesh.
    InputError
        If the tolerance would join points of one cell.
    """
    whole = joined(meshes, tolerance)
    notes = tuple(dict.fromkeys(text for m in meshes for text in m.notes))
    warnings = tuple(dict.fromkeys(text for m in meshes for text in m.warnings))
    return replace(whole, notes=notes, warnings=warnings)
