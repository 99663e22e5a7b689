"""Surface meshes: triangles and quadrilaterals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import function, instance, known_options
from fecontact.common.arrays import Array, IntArray, Mask, cross
from fecontact.common.checks import index_array, number_array
from fecontact.common.errors import MeshError
from fecontact.common.html import cell
from fecontact.common.units import UnitNames
from fecontact.mesh.base_mesh import first_alike, representatives
from fecontact.mesh.facets import (
    distinct_columns,
    facet_integrals,
    facet_nodes,
    facet_shapes,
    facets_at_sides,
    sides_of,
    triangular,
    unit_vectors,
)
from fecontact.mesh.hanging_nodes import refuse_hanging
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.orient import neighbours, oriented, turned

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
        Corrections made when the surface was read; results repeat them.

    Raises
    ------
    MeshError
        If a facet refers to a point that does not exist or has no area, a side belongs to more than two facets, or
        neighbours have opposite orientation.

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
        # copies: the caller's arrays stay theirs
        points = number_array("the points of a surface", self.points).copy(order="C")
        facets = index_array("the facets of a surface", self.facets).copy(order="C")
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
        pairs, against = neighbours(facets[:, :4])
        if against.any():
            one, other = pairs[np.argmax(against)]
            raise MeshError(
                f"Facets {one} and {other} run along their common side the same way, so they face opposite ways; "
                f"{against.sum()} sides in all. fecontact.mesh.orient.oriented(points, facets) turns facets one way.",
                code="opposite-facets",
            )

    def __repr__(self) -> str:
        return (
            f"SurfaceMesh({len(self.facets)} facets, {triangular(self.facets).sum()} of them triangles, "
            f"{len(self.nodes)} points, area {self.areas.sum():.6g})"
        )

    def _repr_html_(self) -> str:
        return cell(repr(self), self.plot)

    def plot(self, path: str | Path | None = None, *, units: UnitNames = (), **options: Any) -> Figure:
        """Picture of the facets, a matplotlib figure; arguments and errors as in `Mesh.plot`."""
        from fecontact.mesh.picture import plot_faces

        known_options(plot_faces, options)
        title = f"{len(self.facets)} facets"
        return plot_faces(self.points, self.facets, {}, path, title, **{"closed": False, "units": units, **options})

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
        """Directed corner pairs (n_facets, 4, 2); the third of a triangle repeats one node."""
        return sides_of(self.facets)

    @cached_property
    def _side_count(self) -> IntArray:
        """Number of facets at each side (n_facets, 4); 0 for the missing side of a triangle."""
        return facets_at_sides(self.facets)

    @cached_property
    def is_closed(self) -> bool:
        """Whether every side belongs to two facets."""
        return not (self._side_count == 1).any()

    @cached_property
    def normals(self) -> Array:
        """Unit normals (n_points, 3) averaged over the facets round each node; zero at points without facets.

        Each facet is weighted by its angle at the node, so that the triangulation does not matter.
        """
        return averaged_normals(self.points, self.facets)[0]

    @classmethod
    def of(cls, mesh: Mesh, name: str) -> SurfaceMesh:
        """Surface mesh of a boundary of a solid, with the solid's points.

        A layer extruded from it fits the solid node by node; `fc.merge` joins them.

        Raises
        ------
        InputError
            If there is no such boundary, or the mesh has hanging nodes, along which a layer would be open.

        Examples
        --------
        >>> import fecontact as fc
        >>> bone = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 1))
        >>> cartilage = fc.extrude(SurfaceMesh.of(bone, "top"), thickness=0.1)
        >>> fc.merge([bone, cartilage], tolerance=1e-9)
        Mesh(hex20, 8 cells, 81 points, boundaries: x_min, x_max, y_min, y_max, bottom, top, side)
        """
        instance("the mesh", mesh, Mesh)
        refuse_hanging(mesh.hanging, "turned into a surface mesh")
        facets = replace(mesh, midface=None).face_nodes(mesh.faces(name))[:, :8]
        return cls(mesh.points, facets, mesh.notes)

    def flipped(self) -> SurfaceMesh:
        """The same surface with reversed orientation."""
        return replace(self, facets=turned(self.facets))

    def mapped(self, mapping: Callable[[Array], ArrayLike]) -> SurfaceMesh:
        """Move every point by ``mapping(points) -> points``."""
        moved = number_array("the mapped points", function("the mapping of points", mapping)(self.points))
        return replace(self, points=moved)


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
        Cosine of the largest angle between the average and the normal of a facet; 1 at points without facets.
    """
    k = facets.shape[1]
    facet, column = np.nonzero(distinct_columns(facets))
    node, triangle = facets[facet, column], triangular(facets)[facet]
    local = np.stack([facet_nodes(k, False), facet_nodes(k, True)])[triangle.astype(int), column]
    _, dN = facet_shapes(k, triangle, local)
    tangents = np.einsum("naj,nai->nij", dN, points[facets[facet]])
    t1, t2 = tangents[:, :, 0], tangents[:, :, 1]
    normal = cross(t1, t2)
    length = np.linalg.norm(normal, axis=1)
    # the angle between the sides at a corner; pi at a mid-side node
    angle = np.arctan2(length, np.einsum("ni,ni->n", *_sides_at(t1, t2, column, triangle)))
    weight = np.where(column < 4, angle, np.pi)
    full = length > 0  # facets drawn out to a line, as tools may leave them, have no normal
    node, normal, weight = node[full], normal[full] / length[full, None], weight[full]
    total = np.zeros_like(points)
    np.add.at(total, node, normal * weight[:, None])
    normals = unit_vectors(total)
    cosine = np.ones(len(points))
    np.minimum.at(cosine, node, np.einsum("ni,ni->n", normal, normals[node]))
    return normals, cosine


def _sides_at(t1: Array, t2: Array, column: IntArray, triangle: Mask) -> tuple[Array, Array]:
    """Directions from a corner along its two sides, from the tangents there."""
    sign1 = np.where((column == 0) | (column == 3), 1.0, -1.0)[:, None]
    sign2 = np.where(column < 2, 1.0, -1.0)[:, None]
    a, b = sign1 * t1, sign2 * t2
    second, third = triangle & (column == 1), triangle & (column == 2)
    a, b = np.where(second[:, None], -t1, a), np.where(second[:, None], t2 - t1, b)
    return np.where(third[:, None], -t2, a), np.where(third[:, None], t1 - t2, b)


def joined(points: Array, facets: IntArray) -> SurfaceMesh:
    """Surface of facets (n, 4) with coincident points merged, repeated facets dropped and consistent orientation.

    Raises
    ------
    MeshError
        If a facet refers to a point that does not exist, or the outside cannot be decided (`mesh.orient.oriented`).
    """
    return SurfaceMesh(*welded(points, facets))


def welded(points: Array, facets: IntArray) -> tuple[Array, IntArray, tuple[str, ...]]:
    """The same as points, facets and notes, whatever the shape of the facets; errors as there."""
    if facets.min() < 0 or facets.max() >= len(points):
        raise MeshError(f"A facet refers to point {facets.max()}, but there are only {len(points)} points.")
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    target = representatives(points, SAME_POINT * size)
    facets = target[facets]
    distinct = 1 + (np.diff(np.sort(facets, axis=1), axis=1) > 0).sum(axis=1)
    if not (distinct >= 3).any():
        raise MeshError("The surface has no facet with three different points.")
    used, number = np.unique(facets[distinct >= 3], return_inverse=True)
    # a quadrilateral of which two corners have met is a triangle
    facets = _as_triangles(number.reshape(-1, 4))
    first = first_alike(facets)
    own = first == np.arange(len(first))
    notes = () if own.all() else (f"{(~own).sum()} of {len(own)} facets are there again: each is taken once.",)
    facets, said = oriented(points[used], facets[own])
    return points[used], facets, (*notes, *said)


def _as_triangles(facets: IntArray) -> IntArray:
    """Facets (n, 4), rotated so that two coincident corners come last."""
    out = facets.copy()
    for k in range(3):
        rows = facets[:, k] == facets[:, (k + 1) % 4]
        out[rows] = np.roll(facets[rows], 2 - k, axis=1)
    rows = facets[:, 3] == facets[:, 0]
    out[rows] = np.roll(facets[rows], -1, axis=1)
    return out
