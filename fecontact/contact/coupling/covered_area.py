"""Covered share of slave facets that overhang the master's rim.

The area of a node at the rim is the covered part of the facets round it; a facet that meets the master along a line is
not covered. Facets with all nodes facing the master are fully covered; only those at the rim are examined.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.contact.coupling.mortar_basis import own_samples
from fecontact.contact.coupling.segments import segment_samples
from fecontact.contact.search.bounding import bounds_of
from fecontact.contact.search.region import flattened
from fecontact.surfaces.facet_surface import FacetSurface, Surface, facets_of

#: Samples along each side of a facet under a rigid shape, whose rim is known only by projection.
ACROSS = 24
#: Radius of search for overlapping facets round the projection of a facet's centre, over the facet's radius; above one,
#: as on curved surfaces projections are further apart than points.
REACH = 1.5
#: Covered shares within this of 0 or 1 count as 0 or 1: rounding, and chords of curved sides.
WHOLE = 0.02


class CoveredRim(NamedTuple):
    """Facets at the master's rim.

    Attributes
    ----------
    facets : (k,) int array
        Slave facets with some nodes facing the master and others beyond its rim.
    share : (k,) array
        Covered share of their area.
    """

    facets: IntArray
    share: Array

    @property
    def partly(self) -> IntArray:
        """Partly covered facets."""
        return self.facets[(self.share > WHOLE) & (self.share < 1 - WHOLE)]


def rim_of(
    slave: FacetSurface,
    master: Surface,
    rotation: Array,
    translation: Array,
    facing: Mask,
    outside: Mask,
    share: float = 0.0,
) -> CoveredRim:
    """Facets at the rim and their covered shares.

    Parameters
    ----------
    slave, master
    rotation, translation
        Pose of the slave's axes in the master's.
    facing, beyond : (n_nodes,) bool arrays
        Slave nodes with a projection on the master, and those beyond its rim.
    share : float
        Weight of the slave's normal in the lines of action.
    """
    facets = np.flatnonzero(facing[slave.facets].any(axis=1) & outside[slave.facets].any(axis=1))
    if len(facets) == 0:
        return CoveredRim(facets, np.zeros(0))
    return CoveredRim(facets, covered_shares(slave, master, rotation, translation, facets, share))


def covered_shares(
    slave: FacetSurface, master: Surface, rotation: Array, translation: Array, facets: IntArray, share: float = 0.0
) -> Array:
    """Covered shares (k,) of the areas of facets (k,), ascending; the rest as in `rim_of`."""
    own, moved = replace(slave, facets=slave.facets[facets]), slave.moved(rotation, translation)
    cut, other = slave.cut(master, rotation, translation, share), facets_of(master)
    if cut is not None:
        facet, local, weight = cut
        at_rim = np.isin(facet, facets)
        facet, local, weight = facet[at_rim], local[at_rim], weight[at_rim]
    elif other is not None:
        f, m = _opposite(replace(moved, facets=own.facets), other)
        facet, local, weight, _ = segment_samples(moved, other, facets[f], m, share)
    else:
        facet, local, weight = _even(own)
        facet = facets[facet]
    if cut is not None or other is None:
        weight = np.where(master.project(moved.evaluate(facet, local)[0]).outside, 0.0, weight)
    whole = own.cut(None, rotation, translation, share) or own_samples(own.facets)
    covered = _areas(own, np.searchsorted(facets, facet), local, weight)
    return np.clip(covered / _areas(own, *whole), 0.0, 1.0)


def _areas(surface: FacetSurface, facet: IntArray, local: Array, weight: Array) -> Array:
    """Areas (n_facets,) from weights (n,) of samples at coordinates (n, 2) of facets (n,)."""
    x, tangents, _ = surface.evaluate(facet, local)
    area = weight * np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=1) * surface.extent(x)
    return np.asarray(np.bincount(facet, area, len(surface.facets)), dtype=float)


def _even(surface: FacetSurface) -> tuple[IntArray, Array, Array]:
    """Centres of equal cells of all facets, collapsed at a triangle's last corner: facets, coordinates, weights."""
    middles = (np.arange(ACROSS) + 0.5) / ACROSS
    s, t = (c.ravel() for c in np.meshgrid(middles, middles, indexing="ij"))
    n, on = len(surface.facets), np.repeat(surface.triangle, len(s))
    s, t = np.tile(s, n), np.tile(t, n)
    narrow = np.where(on, 1 - t, 1.0)
    return np.repeat(np.arange(n), ACROSS**2), np.stack([s * narrow, t], axis=1), narrow / ACROSS**2


def _opposite(slave: FacetSurface, master: FacetSurface) -> tuple[IntArray, IntArray]:
    """Pairs of facets that face each other and are near enough to overlap; both surfaces in the same axes."""
    own, other = bounds_of(slave), bounds_of(master)
    projection = master.project(own.centre).points
    pairs = []
    for members, largest, tree in other.trees:
        which, hit = flattened(tree.query_ball_point(projection, REACH * own.radius + largest))
        pairs.append(np.stack([which, members[hit]]))
    f, m = np.concatenate(pairs, axis=1)
    opposed = np.einsum("ni,ni->n", own.normal[f], other.normal[m]) < 0
    return f[opposed], m[opposed]
