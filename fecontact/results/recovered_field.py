"""A continuous pressure recovered from the nodal one: smooth inside the contact, with its square root at the edge.

Inside, the squared pressures of `results.recovery` are averaged at the nodes, as are stresses (Zienkiewicz & Zhu 1992),
and interpolated by the functions of the coupling. On facets that the outline cuts p^2 = phi c, with phi the level of
`results.edge_level` and c linear on the patch of each facet and averaged at the nodes: it is zero on the outline and
its square falls linearly there.

tests/benchmarks/bench_outlines.py compares it with the nodal pressure. Where that is the better one it is kept: on
facets cut in a mortar coupling, whose pressures are means; at sharp edges and rims, where the pressure is not a square
root; and in contacts of fewer than `RESOLVED` faces across.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.common.one_line import one_line
from fecontact.results.edge_level import edge_level
from fecontact.results.error_estimate import NodalPressure, nodal_pressure, recovered_on
from fecontact.results.facet_samples import facet_samples, hats, pressure_shapes
from fecontact.results.recovery import facet_frames, fitted, monomials, node_weights, patches

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields

#: Faces across a contact from which its pressure is recovered.
RESOLVED = 4.0
#: Least distance from the edge, in facets, by which the weight of a node's squared pressure is divided.
NEAREST = 0.1
#: Columns of the polynomials for c: constant and linear.
LINEAR = 3


@one_line
@dataclass(frozen=True, eq=False)
class RecoveredField:
    """Recovered pressure of a contact.

    Attributes
    ----------
    contact : ContactFields
    pressure : (m,) array
        At the nodes of the facets; that of the contact where it is not recovered.
    level, factor : (m,) arrays
        phi and c at the nodes.
    cut : (n_facets,) bool array
        Facets on which p^2 = phi c (or p = phi c on a foundation).
    """

    contact: ContactFields
    pressure: Array
    level: Array
    factor: Array
    cut: Mask

    def at(self, local: Array) -> Array:
        """Pressure (n_facets, n_q) at common coordinates (n_q, 2 | 1) of all facets."""
        facets, mortar = self.contact.facets, self.contact.coupling == "mortar"
        value = np.einsum("fqa,fa->fq", pressure_shapes(facets, local, mortar), self.pressure[facets])
        if self.cut.any():
            own = facets[self.cut]
            shapes = hats(own, local, False)
            square = [np.maximum(np.einsum("fqa,fa->fq", shapes, v[own]), 0.0) for v in (self.level, self.factor)]
            value[self.cut] = (square[0] * square[1]) ** (1 / _power(self.contact))
        return np.asarray(value)

    def sampled(self, n: int = 4) -> tuple[Array, Array, Array]:
        """Points (n_samples, 3), pressures and areas (n_samples,), n x n on each facet, as `ContactFields.sampled`."""
        contact = self.contact
        every = facet_samples(contact.nodes, contact.facets, contact.coupling == "mortar", contact.extent, n)
        return every.points.reshape(-1, 3), self.at(every.local).ravel(), every.areas.ravel()


def recovered_field(contact: ContactFields, across: float) -> RecoveredField:
    """Recovered pressure of a contact so many faces across."""
    field, n = nodal_pressure(contact), len(contact.nodes)
    none = np.zeros(len(contact.facets), bool)
    if field is None or contact.facets.shape[1] == 3 or not across >= RESOLVED:
        nodal = np.asarray(contact.at_nodes @ contact.pressure)
        return RecoveredField(contact, nodal, np.zeros(n), np.zeros(n), none)
    facets, level = contact.facets, edge_level(contact)
    facing = (np.diff(contact.at_nodes.indptr) > 0)[facets].all(axis=1)
    smooth = facing & (field.bounded | ~field.loaded)
    crossed = (level > 0)[facets].any(axis=1) & (level <= 0)[facets].any(axis=1)
    cut = none if contact.coupling == "mortar" else crossed & smooth
    kept = np.zeros(n, bool)
    kept[facets[field.loaded & (~smooth | (crossed & ~cut))]] = True
    pressure = np.where(kept, field.pressure, np.where(level > 0, _averaged(contact, field), 0.0))
    return RecoveredField(contact, pressure, level, _factor(contact, field, level, cut), cut)


def _averaged(contact: ContactFields, field: NodalPressure) -> Array:
    """Recovered pressure (m,) averaged at nodes over facets on which it is bounded, else that of the contact."""
    chosen = np.flatnonzero(field.bounded)
    if not len(chosen):
        return field.pressure
    own, power = contact.facets[chosen], _power(contact)
    there = recovered_on(contact, field, chosen).at(contact.nodes[own]) ** power
    count = np.bincount(own.ravel(), minlength=len(contact.nodes))
    mean = np.bincount(own.ravel(), there.ravel(), len(contact.nodes)) / np.maximum(count, 1)
    return np.where(count > 0, mean ** (1 / power), field.pressure)


def _factor(contact: ContactFields, field: NodalPressure, level: Array, cut: Mask) -> Array:
    """Factor c (m,) at the nodes of cut facets, from the pressures at nodes within the outline."""
    chosen = np.flatnonzero(cut)
    if not len(chosen):
        return np.zeros(len(level))
    own = contact.facets[chosen]
    centres, axes = facet_frames(contact.nodes, own)
    facet, node = patches(contact.facets, chosen, np.isfinite(field.known) & (level > 0))
    local = np.einsum("pdi,pi->pd", axes[facet], contact.nodes[node] - centres[facet])
    size = 1 / np.linalg.norm(axes[:, 0], axis=1)
    depth = level[node] / size[facet]
    weights = node_weights((contact.at_nodes @ contact.weights)[node], local) / np.maximum(depth, NEAREST)
    terms = monomials(local)[:, :LINEAR] * depth[:, None]
    values = field.pressure[node] ** _power(contact)
    coefficients = fitted(facet, terms, values, weights, np.ones(len(facet), bool), len(chosen)) / size[:, None]
    at_nodes = np.einsum("fdi,fai->fad", axes, contact.nodes[own] - centres[:, None])
    each = np.einsum("fak,fk->fa", monomials(at_nodes)[..., :LINEAR], coefficients)
    count = np.bincount(own.ravel(), minlength=len(level))
    return np.asarray(np.bincount(own.ravel(), each.ravel(), len(level)) / np.maximum(count, 1))


def _power(contact: ContactFields) -> int:
    """Power of the pressure that falls linearly to zero at the edge."""
    return 1 if contact.slave.is_foundation else 2
