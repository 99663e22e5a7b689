"""Fields of one contact: pressures, gaps and forces at its points, and their resultants."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array, IntArray
from fecontact.contact.coupling.mortar_basis import multiplier_shapes, multipliers_on_square
from fecontact.contact.interface import Interface
from fecontact.mesh.facets import shapes_on_square
from fecontact.mesh.section_mesh import line_shapes
from fecontact.results.resultants import Region, part_of, region_numbers, sides_of_plane
from fecontact.surfaces.facet_surface import FacetSurface, facets_of, with_nodes


@dataclass(frozen=True, eq=False)
class ContactFields:
    """Pressures, gaps and resultants of one contact. Points and vectors are in world axes.

    Attributes
    ----------
    slave, master : Body
        As used; the sides may have been swapped (see `note`).
    surfaces : (str, str)
    points : (n, 3) array
        Slave nodes that face the master, undeformed.
    normals : (n, 3) array
        Force vectors on the slave per unit of contact force; unit vectors out of the master, or means of such over a
        pressure shape (mortar coupling).
    centres : (n, 3) array
        Where the forces act: the points, or their means over a pressure shape.
    couples : (n, 3) array
        Moments about the reference point per unit of contact force.
    weights : (n,) array
        Area of each point.
    forces : (n,) array
        Contact forces along the normals, zero where there is no contact.
    gap : (n,) array
        After deformation.
    candidates : (n_candidates,) int array
        Points that took part in the solution.
    nodes : (m, 3) array
        All nodes of the facets that face the master, be it with a part.
    at_nodes : (m, n) csr_matrix
        Values at the nodes by those of the points; the rows of nodes that face nothing are empty.
    facets : (n_facets, 3 | 4 | 8 | 9) int array
        Facets that face the master, if only with a part, in terms of the nodes (3: sides of a section).
    sharing : (n, n_surface_facets) csr_matrix
        Which point is on which facet of the whole surface; points are neighbours if they share one.
    reference_point : (3,) array
        About which `moment` counts: the slave's.
    coupling : str
        'nodal' or 'mortar'.
    note : str
        What was found about the two meshes.
    """

    slave: Body
    master: Body
    surfaces: tuple[str, str]
    points: Array
    normals: Array
    centres: Array
    couples: Array
    weights: Array
    forces: Array
    gap: Array
    candidates: IntArray
    nodes: Array
    at_nodes: sp.csr_matrix
    facets: IntArray
    sharing: sp.csr_matrix
    reference_point: Array
    coupling: str
    note: str

    @property
    def pressure(self) -> Array:
        """Pressure (n,): force over area."""
        return self.forces / self.weights

    @property
    def active(self) -> NDArray[np.bool_]:
        """Points (n,) that carry force."""
        return self.forces > 0

    @property
    def area(self) -> float:
        """Sum of the areas of the points that carry force."""
        return float(self.weights[self.active].sum())

    @property
    def force(self) -> Array:
        """Resultant (3,) on the slave."""
        return self.forces @ self.normals

    @property
    def moment(self) -> Array:
        """Moment (3,) on the slave about its reference point."""
        return self.forces @ self.couples

    @property
    def total_force(self) -> float:
        """Sum of the forces along their normals."""
        return float(self.forces.sum())

    @property
    def centre_of_pressure(self) -> Array:
        """Mean position (3,) weighted by force; NaN without contact."""
        total = self.total_force
        return self.forces @ self.centres / total if total > 0 else np.full(3, np.nan)

    @property
    def max_pressure(self) -> float:
        """Largest nodal pressure."""
        return float(self.pressure.max(initial=0.0))

    @property
    def mean_pressure(self) -> float:
        """Total force over area; zero without contact."""
        return self.total_force / self.area if self.area > 0 else 0.0

    @cached_property
    def region(self) -> IntArray:
        """Connected region (n,) of each point: 1, 2, ... by load, 0 where no force is carried."""
        return region_numbers(self)

    @cached_property
    def regions(self) -> tuple[Region, ...]:
        """Connected parts of the contact area, the most loaded first; points are connected by facets they share."""
        return tuple(part_of(self, self.region == k) for k in range(1, self.region.max(initial=0) + 1))

    def split_by_plane(self, point: ArrayLike, normal: ArrayLike) -> tuple[Region, Region]:
        """Resultants on both sides of a plane, for instance medial and lateral.

        Every contact point goes to the side its force acts on, or half to each if it lies on the plane; the sum of
        both is the whole contact.

        Parameters
        ----------
        point, normal : (3,)
            Of the plane, in world axes; the normal need not have unit length.

        Returns
        -------
        Region, Region
            The side that the normal points to, and the other. Moments are about `reference_point`.

        Raises
        ------
        InputError
            If the normal is zero or a number is not finite.

        Examples
        --------
        >>> import fecontact as fc
        >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
        >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
        >>> floor = fc.RigidBody(fc.Plane())
        >>> result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
        >>> right, left = result.contacts[0].split_by_plane(point=(0.5, 0, 0), normal=(1, 0, 0))
        >>> round(float(right.force[2]), 12), round(float(left.force[2]), 12)
        (0.005, 0.005)
        """
        return sides_of_plane(self, point, normal)

    def sampled(self, values: Array, n: int = 4) -> tuple[Array, Array, Array]:
        """A nodal field interpolated inside the facets; zero beyond the rim of an elastic master.

        Parameters
        ----------
        values : (n_points,) array
            For instance `pressure`.
        n : int
            Samples per side of a facet, at the middles of n x n equal cells of its coordinates.

        Returns
        -------
        points : (n_samples, 3) array
        values : (n_samples,) array
        areas : (n_samples,) array
            Area that each sample stands for.
        """
        t = (np.arange(n) + 0.5) / n
        if self.is_curve:
            return self._sampled_sides(values, t)
        local = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
        N, dN = shapes_on_square(self.facets, local)
        nodes = self.nodes[self.facets]
        tangents = np.einsum("fqaj,fai->fqij", dN, nodes, optimize=True)
        areas = np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=-1) / n**2
        x = (N @ nodes).reshape(-1, 3)
        return x, self._facing(x, self.interpolated(values, local).ravel()), areas.ravel()

    def _facing(self, points: Array, values: Array) -> Array:
        """Values (n,) at points (n, 3) of the slave that face the master, zero at those beyond its rim."""
        surface = self.master.surface(self.surfaces[1])
        shown = np.flatnonzero(values)
        if facets_of(surface) is not None and len(shown):
            beyond = surface.project(self.master.pose.to_body(points[shown])).outside
            values[shown[beyond]] = 0.0
        return values

    @property
    def is_curve(self) -> bool:
        """Whether the contact is that of sections: its facets are sides of three nodes."""
        return self.facets.shape[1] == 3

    def _sampled_sides(self, values: Array, t: Array) -> tuple[Array, Array, Array]:
        """`sampled` of sides; an area is that of a strip or a ring."""
        x = self.line_points(t).reshape(-1, 3)
        length = np.linalg.norm(line_shapes(t)[1] @ self.nodes[self.facets], axis=2).ravel() / len(t)
        shown = self._facing(x, self.interpolated(values, t[:, None]).ravel())
        return x, shown, length * self._surface.extent(self.slave.pose.to_body(x))

    @property
    def _surface(self) -> FacetSurface:
        return with_nodes(self.slave.surface(self.surfaces[0]))

    @property
    def is_ring(self) -> bool:
        """Whether the contact is that of bodies of revolution."""
        return self._surface.revolved

    def line_points(self, s: Array) -> Array:
        """Places (n_facets, n_q, 3) of a section's sides at the same coordinates s (n_q,) in [0, 1]."""
        return np.asarray(line_shapes(s)[0] @ self.nodes[self.facets])

    def interpolated(self, values: Array, local: Array, beyond: float = 0.0) -> Array:
        """A nodal field (n_points,) inside all facets at the same coordinates: (n_facets, n_q).

        The coordinates are those of the square, (n_q, 2), or of a section's side, (n_q, 1).

        By the facets' shape functions, or by hats if these carry the pressure (mortar coupling). Nodes that face
        nothing, of faces that hang over the master's rim, have the value `beyond`.
        """
        nodal = self.at_nodes @ values
        nodal[np.diff(self.at_nodes.indptr) == 0] = beyond
        if self.coupling == "mortar":
            if self.is_curve:
                return nodal[self.facets] @ multiplier_shapes(3, np.zeros(len(local), bool), local).T
            return np.einsum("fqa,fa->fq", multipliers_on_square(self.facets, local), nodal[self.facets])
        if self.is_curve:
            return nodal[self.facets] @ line_shapes(local[:, 0])[0].T
        return np.einsum("fqa,fa->fq", shapes_on_square(self.facets, local)[0], nodal[self.facets])


def _sharing(facets: IntArray, n_points: int) -> sp.csr_matrix:
    """Which of n points is on which facet; facets name points, -1 a node that is none."""
    facet, place = np.nonzero(facets >= 0)
    return sp.csr_matrix((np.ones(len(facet)), (facets[facet, place], facet)), shape=(n_points, len(facets)))


def contact_fields(interface: Interface, candidates: IntArray, forces: Array, gap: Array) -> ContactFields:
    """Fields of a paired contact from the forces (n,) and gaps (n,) of its points."""
    slave, pairing = interface.slave, interface.pairing
    surface = interface.slave_surface
    number = np.full(len(surface.points), -1, dtype=np.int64)
    number[pairing.nodes] = np.arange(len(pairing.nodes))
    facets = number[surface.facets]
    shown, local = np.unique(surface.facets[pairing.covered], return_inverse=True)
    normals, centres, couples = _lines_of_action(interface, surface)
    return ContactFields(
        slave=slave,
        master=interface.master,
        surfaces=interface.surfaces,
        points=slave.pose.to_world(pairing.slave_points),
        normals=normals,
        centres=centres,
        couples=couples,
        weights=pairing.weights,
        forces=forces,
        gap=gap,
        candidates=candidates,
        nodes=slave.pose.to_world(surface.points[shown]),
        at_nodes=pairing.at_nodes[shown],
        facets=local.reshape(-1, facets.shape[1]),
        sharing=_sharing(facets, len(pairing.nodes)),
        reference_point=slave.pose.to_world(slave.reference_point),
        coupling=pairing.coupling,
        note=interface.note,
    )


def _lines_of_action(interface: Interface, surface: FacetSurface) -> tuple[Array, Array, Array]:
    """`normals`, `centres` and `couples` of `ContactFields`."""
    slave, pairing, turn = interface.slave, interface.pairing, interface.slave.pose.rotation
    if pairing.sums is not None:
        s = pairing.sums
        couples = s.moments + np.cross(s.origin - slave.reference_point, s.normals)
        return s.normals @ turn.T, slave.pose.to_world(s.centres), couples @ turn.T
    samples = slave.pose.to_world(pairing.slave_weights @ surface.points)
    vectors = pairing.slave_normals @ turn.T
    if surface.out_of_plane is not None:
        # a force on a ring is the sum of what acts all round it
        samples, vectors = surface.out_of_plane.mean(samples), surface.out_of_plane.mean(vectors)
    moments = np.cross(samples - slave.pose.to_world(slave.reference_point), vectors)
    return pairing.average @ vectors, pairing.average @ samples, pairing.average @ moments
