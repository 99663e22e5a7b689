"""A layer on a surface as a function of its thickness: its cells, and where they fold or run into each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import MeshError, place
from fecontact.mesh.check import least_jacobians
from fecontact.mesh.crossing import crossing_triangles
from fecontact.mesh.element.hexahedron import FACES
from fecontact.mesh.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Layer:
    """Cells between a surface and the surface above it.

    Attributes
    ----------
    points, normals : (n_points, 3) arrays
        Nodes of the surface, all of them in use, and the unit directions in which they move.
    facets : (n_facets, 4 | 8) int array
    fractions : (n_levels,) array
        Levels of the cells' ends, from 0 to 1.
    """

    points: Array
    normals: Array
    facets: IntArray
    fractions: Array

    def mesh(self, thickness: Array, chosen: IntArray | None = None) -> Mesh:
        """Cells of 20 nodes on all facets, or on some: those of the lowest level first.

        Mid-edge nodes are midpoints across the layer; along it those of quadratic facets, moved with their level.
        """
        chosen = np.arange(len(self.facets)) if chosen is None else chosen
        used, facets = np.unique(self.facets[chosen], return_inverse=True)
        facets = facets.reshape(len(chosen), -1)
        growth, n = thickness[used, None] * self.normals[used], len(used)
        levels = np.concatenate([self.points[used] + f * growth for f in self.fractions])
        steps = range(len(self.fractions) - 1)
        corners = facets[:, :4]
        cells = np.concatenate([np.concatenate([corners + k * n, corners + (k + 1) * n], axis=1) for k in steps])
        straight = Mesh(levels, cells).upgraded(20)
        if facets.shape[1] == 4:
            return straight
        points, target = straight.points.copy(), straight.cells.copy()
        for k in steps:
            rows = slice(k * len(facets), (k + 1) * len(facets))
            for columns, level in ((slice(8, 12), k), (slice(12, 16), k + 1)):
                points[target[rows, columns]] = levels[facets[:, 4:8] + level * n]
        used, number = np.unique(target, return_inverse=True)
        return Mesh(points[used], number.reshape(target.shape))

    def folded(self, thickness: Array, chosen: IntArray) -> Mask:
        """Which of some facets (n,) have a cell with a Jacobian that is not positive, or are reversed on the far side.

        Beyond the centre of a concave surface the Jacobian is positive again: a triangle turned by pi in its plane
        keeps its orientation, so its sides are looked at too.
        """
        least = least_jacobians(self.mesh(thickness, chosen)).reshape(-1, len(chosen)).min(axis=0)
        corners = self.facets[chosen, :4]
        far = self.points + thickness[:, None] * self.normals
        below, above = (np.roll(x[corners], -1, axis=1) - x[corners] for x in (self.points, far))
        turned = (np.einsum("fki,fki->fk", below, above) <= 0) & (corners != np.roll(corners, -1, axis=1))
        return np.asarray((least <= 0) | turned.any(axis=1))

    def crossing(self, thickness: Array) -> IntArray:
        """Pairs (n, 2) of facets whose cells run through each other: their triangulated outer faces do."""
        mesh = self.mesh(thickness)
        faces = mesh.outer_faces
        corners = np.take_along_axis(mesh.cells[faces[:, 0]], FACES[faces[:, 1], :4], axis=1)
        triangles = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
        distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
        owner = np.tile(faces[:, 0], 2)[distinct]
        return owner[crossing_triangles(mesh.points, triangles[distinct])] % len(self.facets)

    def centre(self, facet: int) -> Array:
        """Middle (3,) of the corners of a facet."""
        return np.asarray(self.points[self.facets[facet, :4]].mean(axis=0))

    def refuse_folds(self, thickness: Array) -> None:
        """Refuse a layer that folds or runs into itself.

        Raises
        ------
        MeshError
            With the place.
        """
        folded = np.flatnonzero(self.folded(thickness, np.arange(len(self.facets))))
        if len(folded):
            raise MeshError(
                f"The layer folds on {len(folded)} of {len(self.facets)} facets, the first of them facet {folded[0]} "
                f"near {place(self.centre(folded[0]))}: it is too thick for a concave part or a sharp edge of the "
                "surface. Make it thinner or smooth the surface (fc.repair_surface)."
            )
        crossing = self.crossing(thickness)
        if len(crossing):
            a, b = crossing[0]
            raise MeshError(
                f"The layer runs into itself: its cells on facets {a} and {b} cross near {place(self.centre(a))}. Make "
                "it thinner there or extrude the two sides separately."
            )
