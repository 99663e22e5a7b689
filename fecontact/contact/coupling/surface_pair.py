"""Two surfaces that may touch, and the projections of the slave's nodes, which are found once.

The coupling is chosen by these projections, and nodal pairing goes on from them.

Selection of pairs that face each other: their outward normals are opposed.

A pair acts along one line. If the slave's normal is not opposed to the master's, the two do not face each other and are
not a contact. Every contact that can carry load passes: at an edge or corner of the slave any of its faces may face the
master, and on smooth bodies in contact the normals are opposed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.contact.coupling.covered_area import CoveredRim, rim_of
from fecontact.contact.search.region import SearchRegion
from fecontact.mesh.facets import distinct_columns, facet_centres, facet_nodes
from fecontact.surfaces.facet_surface import FacetSurface, Projection, Surface, with_nodes
from fecontact.surfaces.normals import normals_of, opposing, project_along

#: Cosine between one normal and the reversed other below which two points do not face each other: 84 degrees. Faces at
#: right angles are excluded for any rounding and curvature; on bodies in contact normals differ by the slopes within
#: the contact, which is far less.
STEEPEST = 0.1
#: Difference of gaps, relative to the slave's size, that counts as rounding.
TIE = 1e-9
#: Coordinates of the three nodes along a section's side.
_ALONG_SIDE = np.array([0.0, 1.0, 0.5])


class Averted(NamedTuple):
    """The excluded pair, not facing each other, that is nearest to contact.

    Attributes
    ----------
    gap : float
        Its gap; infinite where there is none.
    angle : float
        Angle between the normals in degrees; 180: facing.
    facing : float
        Smallest gap of pairs that face each other; infinite where there is none.
    """

    gap: float = np.inf
    angle: float = np.nan
    facing: float = np.inf


#: Value if all pairs face each other.
NONE_AVERTED = Averted()


class _Corners(NamedTuple):
    """Unit normals (n, 3) of facets at their nodes, sorted by node; first index of each node, and the nodes."""

    normals: Array
    first: IntArray
    nodes: IntArray


def _corners(surface: FacetSurface) -> _Corners:
    if surface.out_of_plane is not None:
        facet, column = np.divmod(np.arange(surface.facets.size), 3)
        local = np.stack([_ALONG_SIDE[column], np.full(len(column), 0.5)], axis=1)
    else:
        k = surface.facets.shape[1]
        facet, column = np.nonzero(distinct_columns(surface.facets))
        reference = np.stack([facet_nodes(k, False), facet_nodes(k, True)])
        local = reference[surface.triangle[facet].astype(int), column]
    _, tangents, _ = surface.evaluate(facet, local)
    normals = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    node = surface.facets[facet, column]
    order = np.argsort(node, kind="stable")
    nodes, first = np.unique(node[order], return_index=True)
    return _Corners(normals[order], first, nodes)


def opposition(slave: FacetSurface, nodes: IntArray, directions: Array) -> Array:
    """Cosine (n,) between directions (n, 3) and the reversed normal of the best-fitting facet round each node."""
    corners = slave.once(_corners)
    count = np.diff(np.append(corners.first, len(corners.normals)))
    towards = np.zeros((len(slave.points), 3))
    towards[nodes] = directions
    cosines = -np.einsum("ni,ni->n", corners.normals, np.repeat(towards[corners.nodes], count, axis=0))
    best = np.zeros(len(slave.points))
    best[corners.nodes] = np.maximum.reduceat(cosines, corners.first)
    return np.asarray(best[nodes])


def unopposed(slave: FacetSurface, nodes: IntArray, projection: Projection, rotation: Array) -> tuple[Mask, Averted]:
    """Mask of slave nodes (n,) that do not face their closest points, and the nearest of them.

    Parameters
    ----------
    rotation : (3, 3) array
        From the slave's axes to those of the closest points.
    """
    cosines = opposition(slave, nodes, projection.normals @ rotation)
    facing = cosines >= STEEPEST
    out = ~facing & ~projection.outside
    least = float(projection.gap[facing & ~projection.outside].min(initial=np.inf))
    if not out.any():
        return out, Averted(facing=least)
    gap = projection.gap[out]
    # of those equally near, the one that faces best
    near = gap - gap.min() <= TIE * slave.size
    angle = float(np.degrees(np.arccos(-np.clip(cosines[out][near].max(), -1.0, 1.0))))
    return out, Averted(float(gap.min()), angle, least)


#: Overhang of a slave face over its master face, relative to the latter's size, up to which it counts as nested.
NESTED_TOLERANCE = 0.02
#: Slave faces tested first for nesting.
FEW = 8


@dataclass(frozen=True, eq=False)
class SurfacePair:
    """A slave placed in its master's axes, with the projections of its nodes, each computed when it is first needed.

    Parameters
    ----------
    slave : FacetSurface
    master : Surface
    rotation, translation
        Pose of the slave's axes in the master's.
    region : SearchRegion, optional
        Parts of the surfaces that may touch; nodes elsewhere are left out.
    share : float, optional
        Weight of the slave's normal in the lines of action; the master's has the rest.
    keep_samples : bool, optional
        Whether the samples of a mortar coupling are kept, for rows along tangents, instead of their sums.
    """

    slave: FacetSurface
    master: Surface
    rotation: Array
    translation: Array
    region: SearchRegion | None = None
    share: float = 0.0
    keep_samples: bool = False

    @cached_property
    def nodes(self) -> IntArray:
        """Slave nodes (n,) that are looked at."""
        return self.slave.nodes if self.region is None else np.flatnonzero(self.region.nodes)

    @cached_property
    def points(self) -> Array:
        """The nodes (n, 3) in the master's axes."""
        return self.in_master(self.slave.points[self.nodes])

    def in_master(self, points: Array) -> Array:
        """Points (k, 3) of the slave in the master's axes."""
        return points @ self.rotation.T + self.translation

    @cached_property
    def closest(self) -> Projection:
        """Closest points of the master."""
        return self.master.project(self.points)

    @cached_property
    def _opposed(self) -> tuple[Mask, Averted]:
        return unopposed(self.slave, self.nodes, self.closest, self.rotation)

    @property
    def averted(self) -> Averted:
        """The nearest of the nodes that do not face their closest points."""
        return self._opposed[1]

    @cached_property
    def facing(self) -> Mask:
        """Which nodes (n,) face the master."""
        return ~self.closest.outside & ~self._opposed[0]

    @cached_property
    def along_lines(self) -> Projection:
        """Projection of all nodes along their lines of action."""
        return self._along_lines(self.nodes, self.points, self.closest)

    def some_along_lines(self, rows: IntArray) -> Projection:
        """Projection of some of the nodes along their lines of action."""
        return self._along_lines(self.nodes[rows], self.points[rows], self.closest.chosen(rows))

    def _along_lines(self, nodes: IntArray, points: Array, closest: Projection) -> Projection:
        normals = opposing(self.slave, nodes) @ self.rotation.T
        return project_along(self.master, points, normals, self.share, closest)

    @cached_property
    def rim(self) -> CoveredRim:
        """Slave facets at the master's rim."""
        inside, outside = np.zeros(len(self.slave.points), bool), np.zeros(len(self.slave.points), bool)
        inside[self.nodes], outside[self.nodes] = ~self.along_lines.outside, self.along_lines.outside
        return rim_of(self.slave, self.master, self.rotation, self.translation, inside, outside, self.share)


def nested(surfaces: SurfacePair, near: IntArray) -> bool:
    """Whether every slave face near the contact lies inside one master face, so that nodal forces are exact.

    On curved surfaces projections shift tangentially by a share of the facet that vanishes with (r/R)^2;
    `NESTED_TOLERANCE` of a facet's size is tolerated. A triangle's weights are exact to degree three, so it does not
    count as nested in a quadrilateral, whose functions are of degree four. Nor does a face with fewer nodes than the
    master's, whose weights are exact for linear functions only where those are quadratic, nor one that overhangs the
    master's rim.

    Parameters
    ----------
    surfaces : SurfacePair
        On a surface of facets.
    near : int array
        Rows of its nodes near the contact.
    """
    slave = surfaces.slave
    if slave.facets.shape[1] < with_nodes(surfaces.master).facets.shape[1]:
        return False
    near_node, facing = np.zeros((2, len(slave.points)), bool)
    near_node[surfaces.nodes[near]] = True
    faces = np.flatnonzero(near_node[slave.facets].all(axis=1))
    if len(faces) == 0:
        facing[surfaces.nodes[surfaces.facing]] = True
        faces = np.flatnonzero(near_node[slave.facets].any(axis=1) & facing[slave.facets].all(axis=1))
    # one face that is not nested suffices; lines of action of all nodes are worth finding if nodal pairing needs them
    if len(faces) == 0 or not _nested(surfaces, faces[:FEW]):
        return False
    if near_node[slave.facets[surfaces.rim.partly]].any():
        return False
    return len(faces) <= FEW or _nested(surfaces, faces[FEW:], surfaces.along_lines)


def _nested(surfaces: SurfacePair, faces: IntArray, known: Projection | None = None) -> bool:
    """The same of some faces; `known` are the projections of all nodes along their lines of action."""
    slave, master = surfaces.slave, with_nodes(surfaces.master)
    middle = facet_centres(slave.triangle[faces])
    normals = -normals_of(slave).at(faces, middle) @ surfaces.rotation.T
    centres = surfaces.in_master(slave.evaluate(faces, middle)[0])
    holder = project_along(master, centres, normals, surfaces.share).facet
    assert holder is not None
    if (slave.triangle[faces] & ~master.triangle[holder]).any():
        return False
    rows, which = np.unique(np.searchsorted(surfaces.nodes, slave.facets[faces].ravel()), return_inverse=True)
    places = (surfaces.some_along_lines(rows) if known is None else known.chosen(rows)).points[which.ravel()]
    facet = np.repeat(holder, slave.facets.shape[1])
    off = master.distance_to_facet(places, facet)
    return bool((off <= NESTED_TOLERANCE * master.mean_facet_size[facet]).all())
