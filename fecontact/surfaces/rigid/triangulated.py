"""Rigid surfaces given by facets: an STL file, or the boundary of a mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.mesh.facets import triangular
from fecontact.mesh.orient import signed_volume
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.surfaces.facet_surface import FacetSurface, Projection

PAIRS = 4_000_000
"""Pairs of triangle and point per batch."""

ON_SIDE = 1e-9
"""Barycentric distance outside a triangle within which a point counts as on its side."""


@dataclass(frozen=True, eq=False)
class Facets:
    """A surface of triangles and quadrilaterals, corners counter-clockwise seen from outside.

    `heights` are those of the lowest facet on a vertical line.

    Parameters
    ----------
    mesh : SurfaceMesh

    Examples
    --------
    >>> import numpy as np
    >>> points = np.array([[0.0, 0, 1], [2, 0, 1], [0, 2, 3]])
    >>> roof = Facets(SurfaceMesh(points, np.array([[0, 2, 1, 1]])))
    >>> roof.heights(np.array([0.5, 0.5, 2.0]), np.array([0.0, 1.0, 2.0])).tolist()
    [1.0, 2.0, inf]
    """

    mesh: SurfaceMesh

    def __post_init__(self) -> None:
        if not isinstance(self.mesh, SurfaceMesh):
            raise InputError(f"Expected a SurfaceMesh (see fc.read_surface); found {type(self.mesh).__name__}.")

    @cached_property
    def facet_surface(self) -> FacetSurface:
        """The facets as a surface that points are projected on."""
        return FacetSurface(self.mesh.points, self.mesh.facets, "rigid surface")

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Corrections made when the surface was read, and whether it is a cavity."""
        cavity = self.mesh.is_closed and signed_volume(self.mesh.points, self.mesh.facets) < 0
        return (
            (*self.mesh.notes, "the rigid surface is closed and faces inwards: a cavity.")
            if cavity
            else self.mesh.notes
        )

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        return self.facet_surface.size

    @property
    def is_open(self) -> bool:
        """Whether some sides belong to one facet only, so that the facets enclose no volume."""
        return len(self.facet_surface.rim_sides[0]) > 0

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3) on the facets."""
        found = self.facet_surface.project(points, n_near=6)
        return Projection(found.points, found.normals, found.gap, found.outside)

    @cached_property
    def _triangles(self) -> Array:
        """Corners (n, 3, 3) of triangles; curved facets are triangulated by their corners."""
        corners = self.mesh.facets[:, :4]
        quad = ~triangular(self.mesh.facets)
        return self.mesh.points[np.concatenate([corners[:, [0, 1, 2]], corners[quad][:, [0, 2, 3]]])]

    def heights(self, x: Array, y: Array) -> Array:
        """Heights of the lowest facet at coordinates that broadcast together; infinite where there is none."""
        xs, ys = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        points = np.stack([xs.ravel(), ys.ravel()], axis=1)
        out = np.full(len(points), np.inf)
        order = np.argsort(points[:, 0], kind="stable")
        sorted_x = points[order, 0]
        corners = self._triangles
        slack = ON_SIDE * self.size
        first = np.searchsorted(sorted_x, corners[:, :, 0].min(axis=1) - slack)
        count = np.searchsorted(sorted_x, corners[:, :, 0].max(axis=1) + slack, side="right") - first
        ends = np.cumsum(count)
        start = 0
        while start < len(corners):
            reach = ends[start - 1] + PAIRS if start else PAIRS
            stop = max(start + 1, int(np.searchsorted(ends, reach, side="right")))
            number = np.repeat(np.arange(start, stop), count[start:stop])
            within = np.arange(len(number)) - np.repeat(ends[start:stop] - count[start:stop], count[start:stop])
            within += ends[start - 1] if start else 0
            point = order[first[number] + within]
            self._lower(out, points, point, corners[number])
            start = stop
        return out.reshape(xs.shape)

    @staticmethod
    def _lower(out: Array, points: Array, point: IntArray, corners: Array) -> None:
        """Lower the heights at points to those of the triangles (n, 3, 3) that lie above them."""
        near = (points[point, 1] >= corners[:, :, 1].min(axis=1)) & (points[point, 1] <= corners[:, :, 1].max(axis=1))
        point, corners = point[near], corners[near]
        a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
        upright = np.abs(area) <= 1e-12 * (ab**2).sum(axis=1)
        ap = points[point] - a[:, :2]
        safe = np.where(upright, 1.0, area)
        s = (ap[:, 0] * ac[:, 1] - ap[:, 1] * ac[:, 0]) / safe
        t = (ab[:, 0] * ap[:, 1] - ab[:, 1] * ap[:, 0]) / safe
        inside = ~upright & (s >= -ON_SIDE) & (t >= -ON_SIDE) & (s + t <= 1 + ON_SIDE)
        z = a[:, 2] + s * ab[:, 2] + t * ac[:, 2]
        np.minimum.at(out, point[inside], z[inside])
