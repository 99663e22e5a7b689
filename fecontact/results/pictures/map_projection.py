"""Maps of a contact on paper: flat along its mean normal, or a cylinder or a sphere unrolled.

A contact is shown flat where the cosines of its faces' turn from their mean normal are above `FLAT`. Otherwise a
cylinder is unrolled from the centre of pressure (lengths and areas are true), and a sphere is laid out by distance and
direction from there (azimuthal equidistant projection, Snyder 1987, Map Projections, chapter 25: lengths from the
middle are true).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.common.directions import WORLD, Directions
from fecontact.results.contact_fields import ContactFields
from fecontact.results.field_map import Ground

#: Cosine of the turn of a face from the mean normal up to which a contact is shown flat: lengths are 30 % short there.
FLAT = 0.7
#: Cosine of the turn of a mean normal from an axis of the world up to which that axis is taken: lengths are 2 % short.
BESIDE = 0.98
#: Largest misfit of a fitted cylinder or sphere, relative to its radius, and of normals to a cylinder's axis.
ROUND = 0.1
#: Angle from the middle, relative to a half turn, beyond which the facets of a sphere are left out: they enclose the
#: point opposite, which has no place on the map.
FAR_SIDE = 0.9
#: Step of a direction on the map, relative to the radius.
STEP = 1e-6


class MapProjection(ABC):
    """Where points of a contact lie on its map."""

    #: Length that a difference is small against.
    radius: float

    @property
    @abstractmethod
    def names(self) -> tuple[str, str]:
        """What the two axes of the map are."""

    @abstractmethod
    def flat(self, points: Array) -> Array:
        """Places (..., 2) of points (..., 3)."""

    def of_facets(self, points: Array) -> Array:
        """Places (n_facets, k, 2) of points (n_facets, k, 3) on facets, which stay in one piece."""
        return self.flat(points)

    def directions(self, points: Array, vectors: Array) -> Array:
        """Vectors (n, 2) on the map of vectors (n, 3) along the surface, by differences.

        Those across the border turn with it.
        """
        longest = float(np.linalg.norm(vectors, axis=1).max(initial=0.0)) or 1.0
        step = STEP * self.radius / longest
        ends = np.stack([points, points + step * vectors], axis=1)
        return np.asarray(np.diff(self.of_facets(ends), axis=1)[:, 0] / step)

    def shows(self, middles: Array, normals: Array) -> Mask:
        """Facets (n,) by middles and normals (n, 3) that have a place on the map."""
        return np.ones(len(middles), bool)


@dataclass(frozen=True, eq=False)
class FlatMap(MapProjection):
    """Surface seen along `normal` (3,), with two axes (2, 3) across it; faces turned away are left out.

    Examples
    --------
    >>> FlatMap(np.eye(3)[:2], np.eye(3)[2]).flat(np.array([1.0, 2.0, 3.0])).tolist()
    [1.0, 2.0]
    """

    axes: Array
    normal: Array
    named: Directions = WORLD

    @property
    def names(self) -> tuple[str, str]:
        """Directions of the two axes."""
        # an arrow beside a given name: it is a direction, in which coordinates grow
        arrow = " →" if self.named.given else ""
        return self.named.name(self.axes[0]) + arrow, self.named.name(self.axes[1]) + arrow

    def flat(self, points: Array) -> Array:
        """See `MapProjection`."""
        return np.asarray(points @ self.axes.T)

    def directions(self, points: Array, vectors: Array) -> Array:
        """See `MapProjection`."""
        return self.flat(vectors)

    def shows(self, middles: Array, normals: Array) -> Mask:
        """Faces that are not turned away."""
        return np.asarray(normals @ self.normal > 0)


@dataclass(frozen=True, eq=False)
class CylinderMap(MapProjection):
    """Cylinder unrolled: arc length from `middle`, and position along the axis.

    Attributes
    ----------
    frame : (3, 3) array
        Rows: direction to the middle, direction of the arc there, axis.
    centre : (3,) array
        On the axis.
    radius : float

    Examples
    --------
    >>> turned = CylinderMap(np.eye(3), np.zeros(3), 2.0).flat(np.array([0.0, 2.0, 5.0]))
    >>> np.allclose(turned, [np.pi, 5.0])
    True
    """

    frame: Array
    centre: Array
    radius: float
    named: Directions = WORLD

    @property
    def names(self) -> tuple[str, str]:
        """Arc and axis."""
        return f"arc about {self.named.name(self.frame[2])}", self.named.name(self.frame[2])

    def flat(self, points: Array) -> Array:
        """See `MapProjection`."""
        x, y, _ = np.moveaxis((points - self.centre) @ self.frame.T, -1, 0)
        return np.stack([self.radius * np.arctan2(y, x), points @ self.frame[2]], axis=-1)

    def of_facets(self, points: Array) -> Array:
        """See `MapProjection`; the facets opposite the middle hang over the border of the map."""
        out = self.flat(points)
        turn = 2 * np.pi * self.radius
        out[..., 0] -= turn * np.round((out[..., 0] - out[:, :1, 0]) / turn)
        return out


@dataclass(frozen=True, eq=False)
class SphereMap(MapProjection):
    """Sphere laid out by the arc length from its `middle` and the direction there.

    Attributes
    ----------
    frame : (3, 3) array
        Rows: the two axes of the map, and the direction from the centre to the middle.
    centre : (3,) array
    radius : float

    Examples
    --------
    >>> turned = SphereMap(np.eye(3), np.zeros(3), 2.0).flat(np.array([0.0, 2.0, 0.0]))
    >>> np.allclose(turned, [0.0, np.pi])
    True
    """

    frame: Array
    centre: Array
    radius: float
    named: Directions = WORLD

    @property
    def names(self) -> tuple[str, str]:
        """Arcs towards the two axes."""
        return f"arc towards {self.named.name(self.frame[0])}", f"arc towards {self.named.name(self.frame[1])}"

    def flat(self, points: Array) -> Array:
        """See `MapProjection`."""
        local = (points - self.centre) @ self.frame.T
        across = np.linalg.norm(local[..., :2], axis=-1)
        arc = self.radius * np.arctan2(across, local[..., 2])
        # at the middle, where the direction is none, arc over distance is radius over height
        return np.asarray(local[..., :2] * (arc / np.where(across > 0, across, 1.0))[..., None])

    def shows(self, middles: Array, normals: Array) -> Mask:
        """Facets that do not enclose the point opposite the middle."""
        towards = (middles - self.centre) @ self.frame[2]
        return np.asarray(towards > np.cos(FAR_SIDE * np.pi) * np.linalg.norm(middles - self.centre, axis=1))


def map_of(contact: ContactFields | Ground) -> MapProjection:
    """Map of a contact: flat if its loaded faces are nearly flat, else of the cylinder or sphere that fits them."""
    middles, normals, areas = facet_planes(contact)
    loaded = contact.loaded_facets
    near = loaded if loaded.any() else np.ones(len(loaded), bool)
    named = contact.directions
    mean = named.beside(_unit(areas[near] @ normals[near]), BESIDE)
    flat = FlatMap(named.across(mean), mean, named)
    if (normals[near] @ mean).min() >= FLAT:
        return flat
    middle = contact.centre_of_pressure if contact.active.any() else areas @ middles / areas.sum()
    points = contact.nodes[np.unique(contact.facets[near])]
    for fitted in (_cylinder, _sphere):
        if (found := fitted(points, normals[near], areas[near], middle, named)) is not None:
            return found
    return flat


def facet_planes(contact: ContactFields | Ground) -> tuple[Array, Array, Array]:
    """Middles (n, 3), unit normals (n, 3) out of the slave and areas (n,) of the facets, by their diagonals."""
    corners = contact.nodes[contact.facets[:, :4]]
    area = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2
    size = np.linalg.norm(area, axis=1)
    return corners.mean(axis=1), area / size[:, None], size


def _cylinder(points: Array, normals: Array, areas: Array, middle: Array, named: Directions) -> CylinderMap | None:
    """Cylinder through points; None if normals are not normal to one axis, or points not on a circle about it."""
    values, vectors = np.linalg.eigh((normals * areas[:, None]).T @ normals / areas.sum())
    if values[0] > ROUND**2:
        return None
    along = named.vectors @ vectors[:, 0]
    axis = vectors[:, 0] * np.sign(along[np.abs(along).argmax()])
    across = named.across(axis)
    flat = points @ across.T
    (fitted, radius) = _round_fit(flat)
    if np.abs(np.linalg.norm(flat - fitted, axis=1) - radius).max() > ROUND * radius:
        return None
    centre = fitted @ across
    outward = middle - centre - (middle - centre) @ axis * axis
    first = _unit(outward)
    return CylinderMap(np.stack([first, np.cross(axis, first), axis]), centre, radius, named)


def _sphere(points: Array, normals: Array, areas: Array, middle: Array, named: Directions) -> SphereMap | None:
    """Sphere through points; None if they are not on one."""
    centre, radius = _round_fit(points)
    if np.abs(np.linalg.norm(points - centre, axis=1) - radius).max() > ROUND * radius:
        return None
    outward = _unit(middle - centre)
    return SphereMap(np.vstack([named.across(outward), outward]), centre, radius, named)


def _round_fit(points: Array) -> tuple[Array, float]:
    """Centre and radius of the circle or sphere by points (n, d): least squares of |x|^2 - 2 c x = r^2 - c^2."""
    start = points.mean(axis=0)
    size = float(np.abs(points - start).max())
    offset = (points - start) / size
    system = np.column_stack([2 * offset, np.ones(len(points))])
    found = np.linalg.lstsq(system, (offset**2).sum(axis=1), rcond=None)[0]
    return start + size * found[:-1], size * float(np.sqrt(found[-1] + found[:-1] @ found[:-1]))


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
