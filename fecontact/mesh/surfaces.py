"""Surface meshes: triangles and quadrilaterals from .stl, .ply and .obj files or from the boundary of a solid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fecontact.checks import positive
from fecontact.errors import InputError, MeshError
from fecontact.mesh.facets import distinct_columns, facet_integrals, facet_nodes, facet_shapes, triangular
from fecontact.mesh.formats.generic import FACET_CORNERS, load, points_in_space
from fecontact.mesh.mesh import Mesh, representatives

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Points of an .stl file closer than this, relative to the size of the surface, are one point.
SAME_POINT = 1e-7


@dataclass(frozen=True, eq=False)
class SurfaceMesh:
    """Quadrilaterals and triangles, linear or quadratic.

    Parameters
    ----------
    points : (n_points, 3) array
    facets : (n_facets, 4 | 8) int array
        Corners counter-clockwise seen from outside, then mid-side nodes; triangles as in `mesh.facets`: the last two
        corners are one node.
    notes : tuple of str
        What was mended when the surface was read; results repeat it.

    Raises
    ------
    MeshError
        If a facet refers to a point that does not exist, has no area, or a side belongs to more than two facets.

    Examples
    --------
    >>> import numpy as np
    >>> SurfaceMesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2, 2]]))
    SurfaceMesh(1 facets, 1 of them triangles, 3 points, area 0.5)
    """

    points: Array
    facets: IntArray
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        points = np.ascontiguousarray(self.points, dtype=float)
        facets = np.ascontiguousarray(self.facets, dtype=np.int64)
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise MeshError(f"Points must be finite and have the shape (n, 3); found {points.shape}.")
        if facets.ndim != 2 or facets.shape[1] not in (4, 8) or len(facets) == 0:
            raise MeshError(f"Facets must have the shape (n, 4) or (n, 8); found {facets.shape}.")
        if facets.min() < 0 or facets.max() >= len(points):
            raise MeshError(f"A facet refers to point {facets.max()}, but there are only {len(points)} points.")
        for name, value in {"points": points, "facets": facets}.items():
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        if (self.areas <= 0).any():
            raise MeshError(f"Facet {np.argmin(self.areas)} has no area; {(self.areas <= 0).sum()} facets in all.")
        if (self._side_count > 2).any():
            raise MeshError("A side belongs to more than two facets: the surface branches there, so it has no outside.")

    def __repr__(self) -> str:
        return (
            f"SurfaceMesh({len(self.facets)} facets, {triangular(self.facets).sum()} of them triangles, "
            f"{len(self.nodes)} points, area {self.areas.sum():.6g})"
        )

    @cached_property
    def nodes(self) -> IntArray:
        """Distinct node numbers."""
        return np.unique(self.facets)

    @cached_property
    def areas(self) -> Array:
        """Area (n_facets,) of each facet."""
        _, _, dA = facet_integrals(self.points, self.facets)
        return np.linalg.norm(dA, axis=2).sum(axis=1)

    @cached_property
    def sides(self) -> IntArray:
        """Directed corner pairs (n_facets, 4, 2); the third of a triangle is one node twice."""
        corners = self.facets[:, :4]
        return np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)

    @cached_property
    def _side_count(self) -> IntArray:
        """How many facets share each side (n_facets, 4); 2 for the missing side of a triangle."""
        ends = np.sort(self.sides.reshape(-1, 2), axis=1)
        _, inverse, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
        return np.where(ends[:, 0] == ends[:, 1], 2, count[inverse.ravel()]).reshape(-1, 4)

    @cached_property
    def is_closed(self) -> bool:
        """Whether every side belongs to two facets."""
        return bool((self._side_count == 2).all())

    @cached_property
    def normals(self) -> Array:
        """Unit normals (n_points, 3) averaged over the facets round each node; zero at points without facets.

        Each facet counts by the angle it has at a corner, so that the cutting into triangles does not matter.
        """
        return averaged_normals(self.points, self.facets)[0]

    @classmethod
    def of(cls, mesh: Mesh, name: str) -> SurfaceMesh:
        """Boundary of a solid as a surface of its own, with the solid's points.

        A layer extruded from it fits the solid node by node; `mesh.merge` joins them.
        """
        facets = replace(mesh, midface=None).face_nodes(mesh.faces(name))[:, :8]
        return cls(mesh.points, facets, mesh.notes)

    def flipped(self) -> SurfaceMesh:
        """The same surface with its outside inside."""
        order = [1, 0, 3, 2] if self.facets.shape[1] == 4 else [1, 0, 3, 2, 4, 7, 6, 5]
        turned = self.facets[:, order]
        triangle = triangular(self.facets)
        three = [0, 2, 1, 1] if self.facets.shape[1] == 4 else [0, 2, 1, 1, 7, 5, 1, 4]
        return replace(self, facets=np.where(triangle[:, None], self.facets[:, three], turned))

    def mapped(self, mapping: Callable[[Array], ArrayLike]) -> SurfaceMesh:
        """Move every point by ``mapping(points) -> points``."""
        return replace(self, points=np.asarray(mapping(self.points), dtype=float))


def averaged_normals(points: Array, facets: IntArray) -> tuple[Array, Array]:
    """Unit normals averaged over the facets round each node, by the angle each facet has there.

    Parameters
    ----------
    points : (n_points, 3) array
    facets : (n_facets, 4 | 8 | 9) int array

    Returns
    -------
    normals : (n_points, 3) array
        Zero at points without facets.
    cosine : (n_points,) array
        Of the largest angle between the average and the normal of a facet; 1 at points without facets.
    """
    k = facets.shape[1]
    facet, column = np.nonzero(distinct_columns(facets))
    node, triangle = facets[facet, column], triangular(facets)[facet]
    local = np.stack([facet_nodes(k, False), facet_nodes(k, True)])[triangle.astype(int), column]
    _, dN = facet_shapes(k, triangle, local)
    tangents = np.einsum("naj,nai->nij", dN, points[facets[facet]])
    t1, t2 = tangents[:, :, 0], tangents[:, :, 1]
    normal = np.cross(t1, t2)
    length = np.linalg.norm(normal, axis=1)
    # the angle between the sides at a corner; at a mid-side node it is straight
    angle = np.arctan2(length, np.einsum("ni,ni->n", *_sides_at(t1, t2, column, triangle)))
    weight = np.where(column < 4, angle, np.pi)
    normal /= length[:, None]
    total = np.zeros_like(points)
    np.add.at(total, node, normal * weight[:, None])
    size = np.linalg.norm(total, axis=1, keepdims=True)
    normals = np.divide(total, size, out=np.zeros_like(total), where=size > 0)
    cosine = np.ones(len(points))
    np.minimum.at(cosine, node, np.einsum("ni,ni->n", normal, normals[node]))
    return normals, cosine


def _sides_at(t1: Array, t2: Array, column: IntArray, triangle: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Directions from a corner along its two sides, from the tangents there."""
    sign1 = np.where((column == 0) | (column == 3), 1.0, -1.0)[:, None]
    sign2 = np.where(column < 2, 1.0, -1.0)[:, None]
    a, b = sign1 * t1, sign2 * t2
    second, third = triangle & (column == 1), triangle & (column == 2)
    a, b = np.where(second[:, None], -t1, a), np.where(second[:, None], t2 - t1, b)
    return np.where(third[:, None], -t2, a), np.where(third[:, None], t1 - t2, b)


def read_surface(path: str | Path, scale: float = 1.0) -> SurfaceMesh:
    """Read a surface from an .stl, .ply or .obj file.

    Parameters
    ----------
    path : str or Path
    scale : float
        By which all coordinates are multiplied.

    Returns
    -------
    SurfaceMesh
        Points in the same place are joined (.stl lists each corner once per triangle); triangles that shrink to a line
        by that are left out.

    Raises
    ------
    InputError, MeshError
        Unknown file type, damaged file, branching surface, no surface cells.
    """
    import meshio

    path = Path(path)
    readers: dict[str, Callable[[str], Any]] = {
        ".stl": meshio.stl.read,
        ".ply": meshio.ply.read,
        ".obj": meshio.obj.read,
    }
    if path.suffix.lower() not in readers:
        raise InputError(f"Unknown surface file type {path.suffix!r}; expected one of {', '.join(readers)}.")
    positive("the scale", scale)
    if not path.is_file():
        raise InputError(f"There is no file {path}.")
    mesh = load(path, readers[path.suffix.lower()])
    points = scale * points_in_space(np.asarray(mesh.points, dtype=float), path.name)
    corners = [np.asarray(b.data, dtype=np.int64) for b in mesh.cells if b.type in FACET_CORNERS]
    if not corners or not sum(map(np.size, corners)):
        raise MeshError(f"{path.name} holds no triangles or quadrilaterals.")
    return joined(points, np.concatenate([c[:, [0, 1, 2, -1]] for c in corners]))


def joined(points: Array, facets: IntArray) -> SurfaceMesh:
    """Surface of facets (n, 4) whose points in the same place have become one."""
    if facets.min() < 0 or facets.max() >= len(points):
        raise MeshError(f"A facet refers to point {facets.max()}, but there are only {len(points)} points.")
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    target = representatives(points, SAME_POINT * size)
    facets = target[facets]
    distinct = 1 + (np.diff(np.sort(facets, axis=1), axis=1) > 0).sum(axis=1)
    used, number = np.unique(facets[distinct >= 3], return_inverse=True)
    return SurfaceMesh(points[used], number.reshape(-1, 4))
