"""Connected regions of a contact with a first outline each."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.results.contact_fields import ContactFields
from fecontact.results.contact_outline import Mirror, Outline, ellipse_of_moments, planes_of_symmetry

#: Fewest points of a region with an outline of its own.
MIN_POINTS = 12
#: Width of points over their length that counts as a line.
ON_A_LINE = 1e-6


@dataclass(frozen=True, eq=False)
class EdgeRegion:
    """A connected contact area with its outline.

    Attributes
    ----------
    number : int
        As in `ContactFields.region`.
    outline : Outline
    mirrors : tuple of Mirror
        Planes of symmetry at which it ends.
    near : (k,) int array
        Facets of the contact on which it may lie.
    """

    number: int
    outline: Outline
    mirrors: tuple[Mirror, ...]
    near: IntArray


def regions_with_edge(contact: ContactFields) -> list[EdgeRegion]:
    """Regions with enough points, with the ellipses of their moments scaled to the area of the recovered edge.

    Moments give the place and the axes of an outline, whatever the mesh; its size only if the pressure is that of
    Hertz. The outline (`results.contact_outline`) gives the size.
    """
    at_nodes = contact.at_nodes.copy()
    at_nodes.data = contact.region[at_nodes.indices].astype(float)
    of_node = at_nodes.max(axis=1).toarray().ravel().astype(np.int64)
    of_facet = of_node[contact.facets]
    beside = _facets_by_nodes(contact.facets, len(contact.nodes))
    areas = contact.outline.areas
    out = []
    for k in range(1, int(contact.region.max(initial=0)) + 1):
        points = np.flatnonzero(contact.region == k)
        if len(points) < MIN_POINTS or _flat(contact.points[points]):
            continue
        own, alien = (of_facet == k).any(axis=1), ((of_facet != k) & (of_facet > 0)).any(axis=1)
        near = (beside @ (beside.T @ own.astype(float)) > 0) & ~alien
        mirrors = planes_of_symmetry(contact.surface, contact.slave.pose, contact.node_numbers[of_node == k])
        forces = contact.forces[points]
        outline = ellipse_of_moments(contact.points[points], forces, forces @ contact.normals[points], mirrors)
        if areas[near].sum() == 0:
            continue
        scale = np.sqrt(areas[near].sum() * 2 ** len(mirrors) / outline.area)
        outline = replace(outline, axes=outline.axes / scale)
        out.append(EdgeRegion(k, outline, mirrors, np.flatnonzero(near)))
    return out


def _flat(points: Array) -> bool:
    """Whether points (n, 3) lie on a line."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[1] <= ON_A_LINE * spread[0])


def _facets_by_nodes(facets: IntArray, n: int) -> sp.csr_matrix:
    """Incidence (n_facets, n_nodes)."""
    pointer = np.arange(0, facets.size + 1, facets.shape[1])
    return sp.csr_matrix((np.ones(facets.size), facets.ravel(), pointer), shape=(len(facets), n))
