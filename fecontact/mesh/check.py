"""Checks of a mesh for errors that would give wrong results or a singular matrix later."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fecontact.common.arrays import Array, IntArray, cross
from fecontact.common.checks import check_magnitude
from fecontact.common.errors import MeshError
from fecontact.mesh.base_mesh import first_alike
from fecontact.mesh.element import EDGES, element_basis, element_quadrature
from fecontact.mesh.facets import cells_at_faces
from fecontact.mesh.mesh import CellGroup, Mesh

#: Distance of a mid-edge node from the middle of its chord, relative to the chord, from which the mapping folds.
QUARTER = 0.25


def check_mesh(mesh: Mesh, joined: IntArray | None = None) -> None:
    """Refuse an invalid mesh; linear conditions join some points, which may lie in the same place.

    Checked are: a size that would overflow or underflow, unused points, distinct points in the same place, repeated
    cells, Jacobians that change sign or are not positive at a quadrature point (scikit-fem silently takes the absolute
    value), mid-edge nodes outside the middle half of a straight edge (beyond the quarter points the mapping folds).

    Raises
    ------
    MeshError
        Names the point or cell and says what to do.
    """
    check_size(mesh.points)
    used = np.zeros(len(mesh.points), bool)
    used[mesh.cells] = True
    if mesh.midface is not None:
        used[mesh.midface[mesh.midface >= 0]] = True
    mesh._refuse_unused(used)
    mesh._refuse_double("fc.merge([mesh], tolerance)", joined)
    check_cells(mesh)


def check_size(points: Array) -> None:
    """Refuse points (n, 3) in units so small or large that squares of volumes underflow or overflow.

    Raises
    ------
    InputError
    """
    check_magnitude("the size of the mesh", np.ptp(points, axis=0), power=30)


def check_cells(mesh: Mesh) -> None:
    """Refuse repeated, inverted and folded cells and misplaced mid-edge nodes.

    Raises
    ------
    MeshError
    """
    _check_repeated(mesh)
    for group in mesh.cell_groups:
        _check_jacobians(mesh, group)
        if mesh.cells.shape[1] >= 20:
            _check_mid_edge(mesh, group)


def _check_repeated(mesh: Mesh) -> None:
    """Refuse overlapping cells: with the same corners, or more than two at one face."""
    first = first_alike(mesh.cells[:, :8])
    again = np.flatnonzero(first != np.arange(len(first)))
    if len(again):
        raise MeshError(
            f"Cells {first[again[0]]} and {again[0]} have the same corners; {len(again)} cells repeat another one, "
            "which would count their stiffness twice. Leave the copies out.",
            code="double-cells",
        )
    sharing = cells_at_faces(mesh.cells)
    if (sharing > 2).any():
        cell, face = np.unravel_index(np.argmax(sharing > 2), sharing.shape)
        raise MeshError(
            f"Face {face} of cell {cell} belongs to {sharing[cell, face]} cells, so that some of them lie in one "
            "another. Leave out those that are modelled twice.",
            code="crowded-face",
        )


def check_skin(mesh: Mesh, names: Sequence[str]) -> None:
    """Refuse contact boundaries with faces inside the solid.

    Raises
    ------
    MeshError
    """
    if not names:
        return
    sharing = cells_at_faces(mesh.cells)
    for name in names:
        faces = mesh.faces(name)
        inside = sharing[faces[:, 0], faces[:, 1]] > 1
        if inside.any():
            cell, face = faces[np.argmax(inside)]
            raise MeshError(
                f"{inside.sum()} of the {len(faces)} faces of the boundary {name!r} lie between two cells, the first "
                f"is face {face} of cell {cell}; only outer faces can be in contact. Part the bodies there (Mesh.part) "
                "or leave these faces out.",
                code="face-between-cells",
            )


def _determinants(mesh: Mesh, group: CellGroup) -> Iterator[tuple[IntArray, Array]]:
    """Cells (n,) of a group, block by block, and their Jacobians (n, n_q) at the quadrature points."""
    X, _ = element_quadrature(mesh.cells.shape[1], group.pattern, group.midfaces)
    _, dN = element_basis(mesh.cells.shape[1], group.pattern, group.midfaces, X)
    for start in range(0, len(group.cells), 4096):
        part = slice(start, start + 4096)
        J = np.einsum("cai,qaj->cqji", mesh.points[group.nodes[part]], dN, optimize=True)
        yield group.cells[part], np.einsum("cqi,cqi->cq", cross(J[..., 0, :], J[..., 1, :]), J[..., 2, :])


def least_jacobians(mesh: Mesh) -> Array:
    """Smallest Jacobian of each cell (n_cells,) at its quadrature points, over its largest; negative where it folds."""
    out = np.empty(len(mesh.cells))
    for group in mesh.cell_groups:
        for cells, det in _determinants(mesh, group):
            out[cells] = det.min(axis=1) / np.abs(det).max(axis=1)
    return out


def _check_jacobians(mesh: Mesh, group: CellGroup) -> None:
    for cells, det in _determinants(mesh, group):
        bad = ~(det > 0).all(axis=1)
        if bad.any():
            row = det[np.argmax(bad)]
            kind = "left-handed: its nodes are in mirrored order" if (row < 0).all() else "folded or inverted"
            raise MeshError(
                f"Cell {cells[np.argmax(bad)]} is {kind} (smallest Jacobian {row.min():.3g}, largest {row.max():.3g}); "
                f"{bad.sum()} cells in all. Nodes must run in VTK order, counter-clockwise below, then above.",
                code="folded-cell",
            )


def mid_edge_places(points: Array, cells: IntArray) -> Array:
    """Places (n, 12) of mid-edge nodes along the chords of edges of cells (n, 20 | 27); a half where coalesced."""
    start, end = points[cells[:, EDGES[:, 0]]], points[cells[:, EDGES[:, 1]]]
    chord = end - start
    length2 = np.einsum("nei,nei->ne", chord, chord)
    along = np.einsum("nei,nei->ne", points[cells[:, 8:20]] - start, chord)
    return np.where(length2 > 0, along / np.where(length2 > 0, length2, 1.0), 0.5)


def _check_mid_edge(mesh: Mesh, group: CellGroup) -> None:
    along = mid_edge_places(mesh.points, mesh.cells[group.cells])
    bad = np.abs(along - 0.5) >= QUARTER
    if bad.any():
        k, edge = np.unravel_index(np.argmax(bad), bad.shape)
        a, b = EDGES[edge]
        raise MeshError(
            f"Cell {group.cells[k]} has its mid-edge node {8 + edge} at {along[k, edge]:.3f} of the edge between its "
            f"nodes {a} and {b}; it must lie between the quarter points (0.25 ... 0.75), or the mapping folds.",
            code="mid-edge-node",
        )
