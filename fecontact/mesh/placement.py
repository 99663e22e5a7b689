"""Nodes of a boundary placed on the surface that it stands for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.check import QUARTER, least_jacobians, mid_edge_places
from fecontact.mesh.facets import facet_centres, facet_shapes, triangular
from fecontact.mesh.mesh import Mesh

#: Distance from a plane, relative to the size of a boundary, within which a node lies in it.
IN_PLANE = 1e-9
#: Steps to a surface within planes, and the distance from it, relative to the size, at which they end.
MAX_ITERATIONS, DISTANCE_TOLERANCE = 30, 1e-14
#: Sine of the angle between a surface and a plane below which nodes in the plane stay where they are.
MIN_ANGLE = 0.05
#: Least Jacobian of a cell, relative to its largest, that moved nodes may leave, and the part of what it was that they
#: may leave of a lower one; how often they are drawn back.
MIN_JACOBIAN, MIN_REMAINING, HALVINGS = 0.2, 0.5, 5


class Foot(Protocol):
    """Closest points of n points on a surface."""

    @property
    def normals(self) -> Array:
        """Unit normals (n, 3) there."""

    @property
    def gap(self) -> Array:
        """Signed distances (n,) along them."""


class Projects(Protocol):
    """A surface that points (n, 3) can be projected on, such as a rigid shape or a fitted surface."""

    def project(self, points: Array) -> Foot:
        """Unit normals (n, 3) at the closest points and signed distances (n,) along them."""


@dataclass(frozen=True, eq=False)
class Placement:
    """Where nodes of a boundary belong: on a surface, and in the planes through them.

    Attributes
    ----------
    surface : surface with ``project``
        In the axes of the mesh.
    planes : (n_planes, 4) array
        Flat faces at the border of the boundary (cuts, planes of symmetry, its own flat parts) as n and n . x. Nodes
        that lie in one of them stay in it.

    Examples
    --------
    >>> import fecontact as fc
    >>> x = Placement(fc.Sphere(1.0), np.array([[1.0, 0, 0, 0]])).placed(np.array([[0.0, 0.1, 0.1], [0.6, 0, 0.1]]))
    >>> x.round(4).tolist()
    [[0.0, 0.1104, 0.0061], [0.5547, 0.0, 0.1679]]
    """

    surface: Projects
    planes: Array

    def placed(self, points: Array) -> Array:
        """Points (n, 3) on the surface; those in a plane move within it."""
        size = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
        on = self.within(points, size)
        free = self._free_directions(on)
        out, left = points.copy(), np.arange(len(points))
        for _ in range(MAX_ITERATIONS):
            foot = self.surface.project(out[left])
            direction = np.einsum("nij,nj->ni", free[left], foot.normals)
            slope = np.einsum("ni,ni->n", direction, foot.normals)
            moving = (np.abs(foot.gap) > DISTANCE_TOLERANCE * size) & (slope > MIN_ANGLE**2)
            step = np.where(moving, -foot.gap / np.where(moving, slope, 1.0), 0.0)
            out[left] += step[:, None] * direction
            left = left[moving]
            if len(left) == 0:
                break
        return out

    def within(self, points: Array, size: float) -> Mask:
        """In which planes points lie (n, n_planes)."""
        return np.abs(points @ self.planes[:, :3].T - self.planes[:, 3]) <= IN_PLANE * size

    def _free_directions(self, on: Mask) -> Array:
        """Projections (n, 3, 3) of vectors into the planes that points lie in (n, n_planes)."""
        held, free = on.any(axis=1), np.tile(np.eye(3), (len(on), 1, 1))
        normals = self.planes[:, :3]
        values, vectors = np.linalg.eigh(np.einsum("nk,ki,kj->nij", on[held].astype(float), normals, normals))
        inside = np.where((values < MIN_ANGLE**2)[:, None], vectors, 0.0)
        free[held] = inside @ inside.transpose(0, 2, 1)
        return free


def placed(mesh: Mesh, placements: Mapping[str, Placement], kept: IntArray | Sequence[int] = ()) -> tuple[Mesh, int]:
    """Move nodes of boundaries to where they belong.

    Corners, nodes on sides and nodes in the middle of faces are moved, except in flat faces; hanging nodes follow.
    Where a cell would fold, its nodes are drawn back.

    Parameters
    ----------
    mesh : Mesh
    placements : mapping of boundary name to Placement
    kept : (n,) int array, optional
        Nodes in the middle of faces that are where they belong already.

    Returns
    -------
    Mesh
        With the same cells; the same object if nothing moves.
    int
        Number of nodes that were drawn back.
    """
    points = mesh.points.copy()
    fixed = np.zeros(len(points), bool)
    if mesh.hanging is not None:
        fixed[mesh.hanging.nodes] = True
    curved = {name: f for name, placement in placements.items() if len(f := curved_facets(mesh, name, placement))}
    if not curved:
        return mesh, 0
    for name, facets in curved.items():
        nodes = np.unique(facets[:, :8])
        nodes = nodes[~fixed[nodes]]
        points[nodes] = placements[name].placed(points[nodes])
    if mesh.hanging is not None:
        points = mesh.hanging.followed(points)
    for name, facets in curved.items():
        if facets.shape[1] == 9 and len(facets := facets[~np.isin(facets[:, 8], kept)]):
            shift = _centres(points, facets) - _centres(mesh.points, facets)
            points[facets[:, 8]] = placements[name].placed(mesh.points[facets[:, 8]] + shift)
    moved = np.any(points != mesh.points, axis=1)
    return unfolded(mesh, points, moved) if moved.any() else (mesh, 0)


def curved_facets(mesh: Mesh, name: str, placement: Placement) -> IntArray:
    """Facets (n, 4 | 8 | 9) of a boundary that do not lie in one of the planes of its placement."""
    facets = mesh.face_nodes(mesh.faces(name))
    x = mesh.points[facets]
    size = float(np.linalg.norm(np.ptp(x.reshape(-1, 3), axis=0)))
    on = placement.within(x.reshape(-1, 3), size).reshape(*facets.shape, -1)
    inside = np.all(on, axis=1)
    return facets[~np.any(inside, axis=1)]


def nodes_off_centre(mesh: Mesh, name: str, least: float) -> IntArray:
    """Nodes (n,) in the middle of faces of a boundary that are farther than `least` from the middle by the others."""
    facets = mesh.face_nodes(mesh.faces(name))
    if facets.shape[1] < 9:
        return np.zeros(0, np.int64)
    off = np.linalg.norm(mesh.points[facets[:, 8]] - _centres(mesh.points, facets), axis=1)
    return facets[off > least, 8]


def _centres(points: Array, facets: IntArray) -> Array:
    """Middles (n, 3) of facets (n, 9) by the map of their other nodes."""
    triangle = triangular(facets)
    N, _ = facet_shapes(8, triangle, facet_centres(triangle))
    return np.einsum("na,nai->ni", N, points[facets[:, :8]])


def unfolded(mesh: Mesh, points: Array, moved: Mask) -> tuple[Mesh, int]:
    """A mesh with moved points; those of cells that would fold are drawn back half-way, again and again.

    Parameters
    ----------
    mesh : Mesh
    points : (n_points, 3) array
    moved : (n_points,) bool array
        Which of them differ from the mesh's.

    Returns
    -------
    Mesh
    int
        Number of nodes that were drawn back.
    """
    touched = np.flatnonzero(moved[_all_nodes(mesh)].any(axis=1))
    step, share = points - mesh.points, np.ones(len(points))
    before = least_jacobians(_part(mesh, mesh.points, touched))
    for k in range(HALVINGS + 1):
        now = mesh.points + share[:, None] * step
        if mesh.hanging is not None:
            now = mesh.hanging.followed(now)
        least = least_jacobians(_part(mesh, now, touched))
        folds = least < np.minimum(MIN_JACOBIAN, MIN_REMAINING * before)
        if mesh.cells.shape[1] >= 20:
            folds |= (np.abs(mid_edge_places(now, mesh.cells[touched]) - 0.5) >= QUARTER).any(axis=1)
        folded = touched[folds]
        if len(folded) == 0:
            break
        nodes = np.unique(_all_nodes(mesh)[folded])
        share[nodes[moved[nodes]]] *= 0.0 if k == HALVINGS - 1 else 0.5
    return replace(mesh, points=now), int((share < 1).sum())


def _all_nodes(mesh: Mesh) -> IntArray:
    """Nodes (n_cells, n) of cells with those in the middle of faces; the first node stands for none."""
    if mesh.midface is None:
        return mesh.cells
    return np.concatenate([mesh.cells, np.where(mesh.midface < 0, mesh.cells[:, :1], mesh.midface)], axis=1)


def _part(mesh: Mesh, points: Array, cells: IntArray) -> Mesh:
    """Some cells as a mesh on all points."""
    return Mesh(points, mesh.cells[cells], midface=None if mesh.midface is None else mesh.midface[cells])
