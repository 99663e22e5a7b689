"""Surfaces of sections: curves that represent a strip of given width or a surface of revolution.

Projection on a curve uses a ribbon: three rows of the same nodes make nine-node facets along y, so closest points,
lines of action and rims are found as in space (`surfaces.facet_surface`); the weights of the three rows are summed
afterwards.

Nodal pressures: the functions of a three-node side have the weights 1/6, 4/6 and 1/6 of a strip. On a side of a ring
that ends on the axis, the node there has the weight 2 pi int N r ds = 0 (r linear): its force does not determine a
pressure. The multiplier basis of the mortar coupling, linear on either half of a side, has a positive weight there
(1/24 of 2 pi L^2), so rings are always coupled by mortar.

Where straight lines through points meet a surface, by Newton's method on closest points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import MeshError
from fecontact.mesh.section_mesh import Extent, line_integrals, line_shapes
from fecontact.surfaces.facet_surface import FacetSurface, Projection, Surface
from fecontact.surfaces.normals import opposing, project_along

#: Extent of unit thickness.
UNIT = Extent(1.0)
#: Gauss points per segment: multiplier times quadratic times radius, degree five on a straight side.
POINTS = 4
#: Segments shorter than this share of a side are rounding.
SHORTEST = 1e-12


@dataclass(frozen=True, eq=False)
class CurveSurface(FacetSurface):
    """Curved sides of a section as a surface.

    Parameters
    ----------
    points : (n_nodes, 3) array
        All nodes of the section, y = 0.
    facets : (n_facets, 3) int array
        Sides: beginning, end, middle, counter-clockwise round the body.
    name : str
    out_of_plane : Extent
    """

    out_of_plane: Extent = UNIT

    @cached_property
    def triangle(self) -> Mask:
        """No side is a triangle."""
        return np.zeros(len(self.facets), bool)

    @cached_property
    def rim_nodes(self) -> Mask:
        """Mask of section nodes (n_nodes,) at the ends of the surface."""
        return np.bincount(self.facets[:, :2].ravel(), minlength=len(self.points)) == 1

    @cached_property
    def mean_facet_size(self) -> Array:
        """Length (n_facets,) of the chord of each side."""
        ends = self.points[self.facets[:, :2]]
        return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)

    @property
    def spatial(self) -> FacetSurface:
        """The ribbon of the curve."""
        return self._ribbon

    @cached_property
    def _ribbon(self) -> FacetSurface:
        """Nine-node facets between the planes y = size and y = -size."""
        n = len(self.points)
        a, b, m = self.facets.T
        shift = np.array([0.0, self.size, 0.0])
        facets = np.stack([a, b, b + 2 * n, a + 2 * n, m, b + n, m + 2 * n, a + n, m + n], axis=1)
        points = np.concatenate([self.points + shift, self.points, self.points - shift])
        planes = None
        if self.planes is not None:
            nodes, across = self.planes
            planes = np.concatenate([nodes, nodes + n, nodes + 2 * n]), np.tile(across, (3, 1))
        return _Ribbon(points, facets, self.name, planes=planes)

    def evaluate(self, facet: IntArray, local: Array) -> tuple[Array, Array, Array]:
        """Positions (n, 3), tangents (n, 3, 2), the second of them -y, and shape functions (n, 3)."""
        N, dN = line_shapes(local[:, 0])
        x = self.points[self.facets[facet]]
        tangent = np.einsum("na,nai->ni", dN, x)
        across = np.broadcast_to([0.0, -1.0, 0.0], tangent.shape)
        return np.einsum("na,nai->ni", N, x), np.stack([tangent, across], axis=2), N

    def slopes(self, facet: IntArray, local: Array) -> Array:
        """Derivatives (n, 3, 2) of the shape functions: none across the section."""
        return line_shapes(local[:, 0])[1][..., None] * np.array([1.0, 0.0])

    def project(self, points: Array, n_near: int = 3) -> Projection:
        """Projection of points (n, 3) of the plane y = 0."""
        projection = self._ribbon.project(points, n_near)
        assert projection.weights is not None
        n = len(self.points)
        fold = sp.csr_matrix((np.ones(3 * n), (np.arange(3 * n), np.tile(np.arange(n), 3))))
        weights = (projection.weights @ fold).tocsr()
        weights.eliminate_zeros()
        in_plane = np.array([1.0, 0.0, 1.0])
        return replace(
            projection, points=projection.points * in_plane, normals=projection.normals * in_plane, weights=weights
        )

    def smooth_normals(self, projection: Projection) -> Array:
        """Unit normals (n, 3) at closest points on it; sides are quadratic, with small kinks."""
        assert projection.facet is not None
        assert projection.local is not None
        return self.normals(projection.facet, projection.local)

    def distance_to_facet(self, points: Array, facet: IntArray) -> Array:
        """Distance (n,) of each point from its given side."""
        return self._ribbon.distance_to_facet(points, facet)

    @property
    def is_divisible(self) -> bool:
        """False: a curve has few sides and is paired as a whole."""
        return False

    def cut(
        self, master: Surface | None, rotation: Array, translation: Array, share: float
    ) -> tuple[IntArray, Array, Array]:
        """Samples on segments of its sides."""
        return curve_samples(self, master, rotation, translation, share)

    def extent(self, points: Array) -> Array:
        """Width of the strip, or circumference of the ring, (n,) at points (n, 3)."""
        return self.out_of_plane(points)

    @cached_property
    def nodal_areas(self) -> Array:
        """Consistent nodal weights (n_points,): integrals of the shape functions.

        Raises
        ------
        MeshError
            If one is not positive, as on the axis of a body of revolution.
        """
        N, x, ds = line_integrals(self.points, self.facets)
        weights = np.zeros(len(self.points))
        area = np.linalg.norm(ds, axis=2) * self.out_of_plane(x)
        np.add.at(weights, self.facets, area @ N)
        bad = weights[self.nodes] <= 1e-12 * weights.max()
        if bad.any():
            where = np.array2string(self.points[self.nodes[np.argmax(bad)]], precision=4)
            raise MeshError(
                f"The node of {self.name!r} at {where} has no area of its own, as every node on the axis of a body of "
                "revolution: a force on it is no pressure. Leave coupling='auto' or take 'mortar'.",
                code="no-area",
            )
        return weights


def curve_samples(
    slave: CurveSurface, master: Surface | None, rotation: Array, translation: Array, share: float
) -> tuple[IntArray, Array, Array]:
    """Gauss points on segments of the slave's sides, on which multipliers and the master's functions are smooth.

    Parameters
    ----------
    slave : CurveSurface
    master : Surface, optional
    rotation, translation
        Pose of the slave's axes in the master's.
    share : float
        Weight of the slave's normal in the lines of action.

    Returns
    -------
    facet : (n,) int array
    local : (n, 2) array
    weight : (n,) array
        In the side's coordinate.
    """
    n = len(slave.facets)
    facet, s = np.repeat(np.arange(n), 3), np.tile([0.0, 0.5, 1.0], n)
    if isinstance(master, CurveSurface):
        ends = np.unique(master.facets[:, :2])
        # along the lines of action too, with the roles exchanged
        projection = project_along(
            slave, (master.points[ends] - translation) @ rotation, opposing(master, ends) @ rotation, 1 - share
        )
        assert projection.facet is not None
        assert projection.local is not None
        facet, s = np.concatenate([facet, projection.facet]), np.concatenate([s, projection.local[:, 0]])
    order = np.lexsort((s, facet))
    facet, s = facet[order], s[order]
    kept = np.flatnonzero((facet[1:] == facet[:-1]) & (np.diff(s) > SHORTEST))
    t, w = np.polynomial.legendre.leggauss(POINTS)
    length = s[kept + 1] - s[kept]
    local = s[kept][:, None] + length[:, None] * (t + 1) / 2
    two = np.stack([local.ravel(), np.full(local.size, 0.5)], axis=1)
    return np.repeat(facet[kept], POINTS), two, (length[:, None] * w / 2).ravel()


class _Ribbon(FacetSurface):
    """The facets of a section's curve; all points are searched in the plane of its middle row of nodes."""

    @property
    def along_slender(self) -> None:
        """None, as facets are slender across that plane only."""
        return None


CLOSE = 1e-14
"""Step, relative to the extent of the points, at which the search has converged."""

MAX_ITERATIONS = 60

STEEPEST = 0.1
"""Cosine between a line and the surface's inward normal below which the line does not meet it: 84 degrees."""


def along_line(
    surface: Surface, start: Array, direction: Array, first: Projection | None = None, facing: bool = True
) -> tuple[Array, Projection, Mask]:
    """Distances along one direction from points to a surface.

    Parameters
    ----------
    surface : Surface
    start : (n, 3) array
    direction : (3,) array
        Unit vector, into the surface.
    first : Projection, optional
        Closest points of `start`, if they are known.
    facing : bool
        Whether lines that meet the other side of the surface are lost; without it they count too.

    Returns
    -------
    travel : (n,) array
    found : Projection
        Closest points of the points where the lines end.
    lost : (n,) bool array
        Lines that graze the surface, or meet its other side.

    Examples
    --------
    >>> from fecontact.surfaces import Paraboloid
    >>> travel, _, _ = along_line(Paraboloid(1.0), np.array([[0.6, 0.0, -1.0]]), np.array([0.0, 0.0, 1.0]))
    >>> travel.round(12).tolist()
    [1.18]
    """
    travel = np.zeros(len(start))
    lost = np.zeros(len(start), bool)
    size = float(np.ptp(start, axis=0).max())
    for step in range(MAX_ITERATIONS):
        found = first if step == 0 and first is not None else surface.project(start + travel[:, None] * direction)
        cosine = -(found.normals @ direction)
        lost |= (cosine if facing else np.abs(cosine)) < STEEPEST
        further = np.where(lost, 0.0, found.gap / np.where(lost, 1.0, cosine))
        travel = travel + further
        if np.abs(further).max(initial=0.0) <= CLOSE * size:
            break
    return travel, found, lost
