"""Gaps of a contact between the nodes of its faces, where its conditions are not met.

The points of a contact are nodes, or means over the functions of nodes. A shape that is finer than the faces reaches
between them: a ball beside all nodes overlaps a face and nothing touches; a wavy surface that is met at its crests
alone looks flat. Here the gap is taken over the faces: along the slave's facets to the closest point of the master, as
linear in the displacements as that of the contact points.

What the nodes do not see of a rigid shape is the gap less its interpolation from values g and normals n at the nodes,

    sum_a N_a (g_a + n_a . (x - x_a) / 2),

exact for a quadratic shape. Where a contact fills so few faces that its readings tell nothing of such a shape either,
it is the gap less the interpolation of its values. To a deviation w with a period of a face's width L belongs, by
Westergaard's solution of a wavy half-plane (Johnson 1985, section 13.2), a pressure of pi E* w / L, in the root mean
square too.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fecontact.bodies.body import Body
from fecontact.common.arrays import ROUNDING, Array, IntArray, Mask, cross
from fecontact.contact.coupling.nodal import STEEPEST
from fecontact.contact.search_region import with_rings
from fecontact.mesh.facets import facet_centres
from fecontact.results.error_estimate import unseen_profile
from fecontact.results.facet_samples import facet_samples
from fecontact.surfaces.between_nodes import overlap_outline, samples_of, smallest_gaps, star_area
from fecontact.surfaces.facet_surface import FacetSurface, has_cells, own_facets, with_nodes

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields

#: Samples along each side of a face in the mean of its gap.
SAMPLES = 4


@dataclass(frozen=True, eq=False)
class Overlap:
    """Overlap of two bodies between the nodes of faces that carry no force, whether or not others do.

    Attributes
    ----------
    facets : (n,) int array
        Facets of the slave, by their numbers in its surface.
    points : (n, 3) array
        Deepest point of each, undeformed, in the slave's axes.
    depth : float
        The largest depth, at the first of these points.
    width : float
        Root of the overlapping area there; of a section, the width.
    force : float
        Force that this overlap would carry, E* depth width / 2 as in `search.candidates.approach_for_load`: 0.94 of
        Hertz's for a paraboloid, an order of magnitude for other shapes.
    """

    facets: IntArray
    points: Array
    depth: float
    width: float
    force: float


class GapsBetweenNodes:
    """Gaps over the faces of a contact."""

    def __init__(self, contact: ContactFields) -> None:
        self.contact = contact
        self.surface: FacetSurface = with_nodes(contact.slave.surface(contact.surfaces[0]))
        self.other = contact.master.surface(contact.surfaces[1])
        self._relative = contact.slave.pose.relative_to(contact.master.pose)
        self._own = _at_nodes(contact.slave, self.surface, contact._displacements[0])

    def _gap(self, x: Array, moved: Array) -> tuple[Array, Array, Mask]:
        """Gaps (n,) at points (n, 3) of the slave that move by (n, 3), normals (n, 3), and what lies beyond a rim."""
        turn, u = self._relative.rotation, self.contact._displacements[1]
        foot = self.other.project(x @ turn.T + self._relative.translation)
        if foot.weights is None:
            theirs = u[:3] + cross(u[3:], foot.points)
        else:
            theirs = foot.weights @ _at_nodes(self.contact.master, with_nodes(self.other), u)
        gap = foot.gap + np.einsum("ni,ni->n", foot.normals, moved @ turn.T - theirs)
        return gap, foot.normals @ turn, foot.outside

    def _on(self, facet: IntArray, local: Array) -> tuple[Array, Array, Mask, Array, Array]:
        """The same at coordinates (n, 2) of facets (n,), with positions (n, 3) and shape functions (n, k)."""
        x, tangents, shapes = self.surface.evaluate(facet, local)
        gap, normals, outside = self._gap(x, np.einsum("na,nai->ni", shapes, self._own[self.surface.facets[facet]]))
        own = cross(tangents[:, :, 0], tangents[:, :, 1])
        averted = np.einsum("ni,ni->n", own, normals) > -STEEPEST * np.linalg.norm(own, axis=1)
        return gap, normals, outside | averted, x, shapes

    def at(self, facet: IntArray, local: Array) -> Array:
        """Gaps (n,) at coordinates (n, 2) of facets (n,); infinite where nothing faces them."""
        gap, _, hidden, _, shapes = self._on(facet, local)
        for given in (self.contact.worn, self.contact.overclosure):
            if given is not None:
                depth = np.zeros(len(self.surface.points))
                depth[self.contact._node_numbers] = self.contact._at_nodes @ given
                gap = gap + np.einsum("na,na->n", shapes, depth[self.surface.facets[facet]])
        return np.where(hidden, np.inf, gap)

    @cached_property
    def overlap(self) -> Overlap | None:
        """Overlap on faces that carry no force; None where there is none."""
        facets = self._idle
        if len(facets) == 0 or self.surface.of_nodes:
            return None
        sizes = self.surface.mean_facet_size[facets]
        found, local = smallest_gaps(self.at, facets, self.surface.triangle[facets], sizes)
        deep = np.flatnonzero(found < 0)
        if len(deep) == 0:
            return None
        facets, local = facets[deep], local[deep]
        depth = -found[deep] - self._depth_at_nodes(facets)
        order = np.argsort(-depth, kind="stable")
        order = order[depth[order] > ROUNDING * self.surface.mean_facet_size[facets[order]]]
        if len(order) == 0:
            return None
        points = self.surface.evaluate(facets[order], local[order])[0]
        width, length = self._extent(facets[order[0]], local[order[0]])
        deepest = float(depth[order[0]])
        return Overlap(facets[order], points, deepest, width, self._modulus * deepest * length / 2)

    @property
    def _modulus(self) -> float:
        return 1 / sum(1 / body.contact_modulus for body in (self.contact.slave, self.contact.master))

    @cached_property
    def _loaded(self) -> Mask:
        """Facets (n_facets,) of the slave with a node that carries force."""
        c, out = self.contact, np.zeros(len(self.surface.facets), bool)
        out[c._facet_numbers[(c._at_nodes @ c.pressure > 0)[c.facets].any(axis=1)]] = True
        return out

    @cached_property
    def _paired(self) -> Mask:
        """Facets (n_facets,) of the slave with contact points."""
        out = np.zeros(len(self.surface.facets), bool)
        out[self.contact._facet_numbers] = True
        return out

    @property
    def _idle(self) -> IntArray:
        """Facets that carry no force, and may be reached between their nodes only: no deeper than they are wide."""
        surface, pressed = self.surface, self._loaded.any()
        # beside those that are loaded the edge of the contact is known to a face only, which its error includes
        facets = np.flatnonzero(~with_rings(surface, self._loaded, 1) if pressed else ~self._loaded)
        if len(facets) == 0:
            return facets
        gap, _, hidden, middle, _ = self._on(facets, facet_centres(surface.triangle[facets]))
        nodes = surface.points[surface.facets[facets]]
        reach = np.linalg.norm(nodes - middle[:, None], axis=2).max(axis=1, initial=0.0)
        # from beyond a rim of the other body, as far as the corners of the face, and no deeper than that
        return facets[np.abs(gap) <= np.where(hidden, np.sqrt(2) * reach if pressed else np.inf, reach)]

    def _depth_at_nodes(self, facets: IntArray) -> Array:
        """Depth (n,) of the deepest node of each facet; zero where contact points are means over functions."""
        nodes = self.surface.facets[facets]
        gap = self._gap(self.surface.points[nodes].reshape(-1, 3), self._own[nodes].reshape(-1, 3))[0]
        depth = np.maximum(-gap.reshape(nodes.shape).min(axis=1, initial=0.0), 0.0)
        return np.where(self._paired[facets] & (self.contact.coupling == "mortar"), 0.0, depth)

    def _extent(self, facet: int, local: Array) -> tuple[float, float]:
        """Width of an overlap round a point of a facet, and the length on which its force depends."""
        edge = overlap_outline(self.at, facet, local, bool(self.surface.triangle[facet]))
        x = self.surface.evaluate(np.full(len(edge) + 1, facet), np.vstack([local, edge]))[0]
        if self.surface.out_of_plane is None:
            width = star_area(x[0], x[1:]) ** 0.5
            return width, width
        width = float(np.linalg.norm(x[1] - x[1 + len(edge) // 2]))
        length = float(self.surface.extent(x[:1])[0])
        return width, max(length, np.sqrt(np.pi) * width) if self.surface.revolved else length

    @cached_property
    def means(self) -> Array:
        """Mean gap (n,) on the faces round each contact point, weighted by its function; zero where positive.

        A ball that is met at the nodes reaches into faces of 4 nodes. Positive means are those of points at the edge,
        whose faces are open in part. A mortar coupling makes these means zero where there is pressure; on half-spaces
        the gap is that of the cells.
        """
        c = self.contact
        chosen = np.flatnonzero(self._loaded[c._facet_numbers])
        if c.coupling == "mortar" or has_cells(self.surface) or not len(chosen):
            return np.zeros(len(c.weights))
        samples = facet_samples(c.nodes, c.facets[chosen], False, c._extent, SAMPLES)
        n = len(samples.local)
        gap = self.at(np.repeat(c._facet_numbers[chosen], n), np.tile(samples.local, (len(chosen), 1)))
        gap[np.isinf(gap)] = 0.0
        integrals = np.einsum("fq,fqa->fa", samples.areas * gap.reshape(-1, n), samples.shapes)
        nodal = np.bincount(c.facets[chosen].ravel(), integrals.ravel(), len(c.nodes))
        return np.minimum(c._at_nodes.T @ nodal / c.weights, 0.0)

    @cached_property
    def unseen(self) -> Array:
        """Root mean square (n_facets,) on loaded facets of the pressure by a rigid shape between their nodes."""
        facets, out = np.flatnonzero(self._loaded), np.zeros(len(self._loaded))
        meshed = own_facets(self.other) is not None or not self.contact.master.is_rigid
        if meshed or has_cells(self.surface) or len(facets) == 0:
            return out
        nodes, place = np.unique(self.surface.facets[facets], return_inverse=True)
        x_a = self.surface.points[nodes]
        g_a, n_a, beyond = self._gap(x_a, self._own[nodes])
        which, local = samples_of(np.arange(len(facets)), self.surface.triangle[facets])
        gap, _, hidden, x, shapes = self._on(facets[which], local)
        columns = place.reshape(len(facets), -1)[which]
        interpolated, readings = g_a[columns], self.contact._readings
        if readings is not None and unseen_profile(self.contact, readings) < 1:
            interpolated = interpolated + np.einsum("nai,nai->na", n_a[columns], x[:, None] - x_a[columns]) / 2
        short = np.where(hidden | beyond[columns].any(axis=1), 0.0, gap - np.einsum("na,na->n", shapes, interpolated))
        # nodes are half as far apart on faces with nodes amid their sides
        spacing = self.surface.mean_facet_size[facets] / (1 if self.surface.facets.shape[1] == 4 else 2)
        out[facets] = short.reshape(len(facets), -1).std(axis=1) / (
            spacing / np.pi / self._modulus + self.contact._softness
        )
        return out


def _at_nodes(body: Body, surface: FacetSurface, displacement: Array) -> Array:
    """Displacements (n_points, 3) of a surface's points by those (n_dofs,) of its body, in its axes."""
    found = body._at_points(displacement)
    # surfaces with cells of their own have displacements of them first
    return displacement.reshape(-1, 3) if found is None or len(found) != len(surface.points) else found
