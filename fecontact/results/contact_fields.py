"""Fields of one contact: pressures, gaps and forces at its points, and their resultants."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.error_estimate import ErrorEstimate
from fecontact.common.one_line import one_line
from fecontact.contact.interface import Interface
from fecontact.fem.energy_error import EnergyError
from fecontact.results.contact_outline import ContactOutline, contact_outline
from fecontact.results.error_estimate import PressureReadings, energy_errors, error_estimate, readings_of
from fecontact.results.facet_samples import facet_samples, pressure_shapes
from fecontact.results.friction_fields import FrictionFields
from fecontact.results.recovered_field import RecoveredField, recovered_field
from fecontact.results.resultants import Region, part_of, region_numbers, sides_of_plane
from fecontact.results.singular import SingularEdge, singular_edge
from fecontact.surfaces.facet_surface import FacetSurface, facets_of, with_nodes

#: Faces across a contact from which on its edge is located within them.
FACES_ACROSS = 2.0


@one_line
@dataclass(frozen=True, eq=False)
class ContactFields:
    """Pressures, gaps and resultants of one contact. Points and vectors are in world axes.

    Attributes
    ----------
    slave, master : Body
        Bodies after a possible swap (see `note`).
    surfaces : (str, str)
    points : (n, 3) array
        Slave nodes that face the master, undeformed.
    normals : (n, 3) array
        Force vectors on the slave per unit of contact force; unit vectors out of the master, or their means over a
        multiplier function (mortar coupling).
    centres : (n, 3) array
        Points of action: the points, or their means over a multiplier function.
    couples : (n, 3) array
        Moments about the reference point per unit of contact force.
    weights : (n,) array
        Area of each point.
    forces : (n,) array
        Contact forces along the normals, zero where there is no contact.
    gap : (n,) array
        Gaps after deformation.
    candidates : (n_candidates,) int array
        Candidate points of the solution.
    nodes : (m, 3) array
        All nodes of the facets that face the master at least partly.
    node_numbers : (m,) int array
        Their numbers in the slave's mesh.
    at_nodes : (m, n) csr_matrix
        Matrix from values at the points to the nodes; rows of nodes that face nothing are empty.
    facets : (n_facets, 3 | 4 | 8 | 9) int array
        Facets that face the master at least partly, in terms of the nodes (3 columns: sides of a section).
    facet_numbers : (n_facets,) int array
        Their numbers among the facets of the whole surface.
    sharing : (n, n_surface_facets) csr_matrix
        Which point has a value on which facet of the whole surface; points are neighbours if they share one.
    reference_point : (3,) array
        Reference point of `moment`: the slave's.
    displacements : ((n_dofs,) array, (n_dofs,) array)
        Of slave and master, in their own axes.
    coupling : str
        'nodal' or 'mortar'.
    note : str
        Note on the two meshes and the coupling.
    friction : FrictionFields, optional
        Tractions and slip, of a contact with friction.
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
    node_numbers: IntArray
    at_nodes: sp.csr_matrix
    facets: IntArray
    facet_numbers: IntArray
    sharing: sp.csr_matrix
    reference_point: Array
    displacements: tuple[Array, Array]
    coupling: str
    note: str
    friction: FrictionFields | None = None

    @property
    def pressure(self) -> Array:
        """Pressure (n,): force over area."""
        return self.forces / self.weights

    @property
    def active(self) -> Mask:
        """Points (n,) that carry force."""
        return self.forces > 0

    @property
    def area(self) -> float:
        """Sum of the areas of the points that carry force."""
        return float(self.weights[self.active].sum())

    @property
    def force(self) -> Array:
        """Resultant (3,) on the slave, friction included."""
        pressed = self.forces @ self.normals
        return pressed if self.friction is None else pressed + self.friction.force

    @property
    def moment(self) -> Array:
        """Moment (3,) on the slave about its reference point, friction included."""
        pressed = self.forces @ self.couples
        if self.friction is None:
            return pressed
        rubbed = np.cross(self.centres - self.reference_point, self.friction.resultants) + self.friction.couples
        return pressed + rubbed.sum(axis=0)

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
        """Connected region (n,) of each point: 1, 2, ... by load, 0 without force."""
        return region_numbers(self)

    @cached_property
    def regions(self) -> tuple[Region, ...]:
        """Connected parts of the contact area, the most loaded first; points are connected by facets they share."""
        return tuple(part_of(self, self.region == k) for k in range(1, self.region.max(initial=0) + 1))

    @cached_property
    def singular_edge(self) -> SingularEdge | None:
        """Edge towards which the pressure grows without bound, see `results.singular`; None where there is none."""
        return singular_edge(self)

    @cached_property
    def _readings(self) -> PressureReadings | None:
        return readings_of(self)

    @cached_property
    def error_estimate(self) -> ErrorEstimate:
        """Estimated discretisation errors of this contact; see `results.error_estimate`.

        Examples
        --------
        >>> import fecontact as fc
        >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (8, 8, 4)).translated((-0.5, -0.5, 0.0))
        >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="top", supports={"bottom": "xyz"})
        >>> ball = fc.RigidBody(fc.Sphere(1.0)).placed((0, 0, 1.0))
        >>> result = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -0.05}})
        >>> print(result.contacts[0].error_estimate)
        pressure: about 18 % (peak 5 %, area 4 %), resolved by 3.5 faces across
        """
        return error_estimate(self, self._readings)

    @cached_property
    def energy_errors(self) -> tuple[EnergyError, EnergyError]:
        """Errors in the cells of slave and master below the contact, see `fem.energy_error`."""
        return energy_errors(self, self._readings)

    @cached_property
    def error_indicators(self) -> Array:
        """Mean error (n_surface_facets,) of the pressure on every facet of the slave's whole surface, a pressure.

        Refine where they are large. Their squares, integrated over the facets, are those of `error_estimate.pressure`
        less its parts `geometry` and `interior`, times the integral of the squared pressure.
        """
        out = np.zeros(self.sharing.shape[1])
        if self._readings is not None:
            found = self._readings
            out[self.facet_numbers[found.facets]] = np.sqrt(found.misfit / found.areas.sum(axis=1))
        return out

    @cached_property
    def outline(self) -> ContactOutline:
        """Smooth closed curves round the contact area, and the area within; see `results.contact_outline`.

        Examples
        --------
        >>> import fecontact as fc
        >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (8, 8, 4)).translated((-0.5, -0.5, 0.0))
        >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="top", supports={"bottom": "xyz"})
        >>> ball = fc.RigidBody(fc.Sphere(1.0)).placed((0, 0, 1.0))
        >>> result = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -0.05}})
        >>> (circle,) = result.contacts[0].outline.curves
        >>> radius = np.linalg.norm(circle.points[:, :2], axis=1)
        >>> bool(np.ptp(radius) < 0.03 * radius.mean()), bool(circle.is_edge.all())
        (True, True)
        """
        return contact_outline(self)

    @property
    def edge_area(self) -> float:
        """Area with the edge located within the faces, that of `outline`.

        More accurate than `area`, the sum of whole points; that it is where fewer than `FACES_ACROSS` faces lie across
        the contact, on which no edge is located.
        """
        if not self.error_estimate.faces_across >= FACES_ACROSS:
            return self.area
        return self.outline.area

    @property
    def edge_mean_pressure(self) -> float:
        """Total force over `edge_area`, as tables and pictures show it; zero without contact."""
        return self.total_force / self.edge_area if self.edge_area > 0 else 0.0

    @cached_property
    def recovered(self) -> RecoveredField:
        """Continuous pressure that is smooth inside and a square root at the edge; see `results.recovered_field`.

        Examples
        --------
        >>> import fecontact as fc
        >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (8, 8, 4)).translated((-0.5, -0.5, 0.0))
        >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="top", supports={"bottom": "xyz"})
        >>> ball = fc.RigidBody(fc.Sphere(1.0)).placed((0, 0, 1.0))
        >>> contact = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -0.05}}).contacts[0]
        >>> points, pressure, areas = contact.recovered.sampled()
        >>> bool(abs(pressure @ areas / contact.total_force - 1) < 0.02)
        True
        """
        return recovered_field(self, self.error_estimate.faces_across)

    @property
    def misfit(self) -> float:
        """Relative L2 misfit of the pressure's reconstructions, the part of `error_estimate` due to faces and edge."""
        return np.nan if self._readings is None else self._readings.error

    def split_by_plane(self, point: ArrayLike, normal: ArrayLike) -> tuple[Region, Region]:
        """Resultants on both sides of a plane, for instance medial and lateral.

        Every contact point is assigned to the side on which its force acts, or half to each if on the plane; the sum of
        both is the whole contact.

        Parameters
        ----------
        point, normal : (3,)
            Plane in world axes; the normal need not have unit length.

        Returns
        -------
        Region, Region
            The side to which the normal points, and the other. Moments are about `reference_point`.

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
        """A nodal field sampled inside the facets; zero beyond the rim of an elastic master.

        Parameters
        ----------
        values : (n_points,) array
            Field, for instance `pressure`.
        n : int
            Samples per side of a facet, at the centres of n x n equal cells of its coordinates.

        Returns
        -------
        points : (n_samples, 3) array
        values : (n_samples,) array
        areas : (n_samples,) array
            Area of each sample.
        """
        every = facet_samples(self.nodes, self.facets, self.coupling == "mortar", self.extent, n)
        points = every.points.reshape(-1, 3)
        found = np.einsum("fqa,fa->fq", every.shapes, (self.at_nodes @ values)[self.facets])
        return points, self._facing(points, found.ravel()), every.areas.ravel()

    def _facing(self, points: Array, values: Array) -> Array:
        """Values (n,) at points (n, 3) of the slave that face the master, zero at those beyond its rim."""
        surface = self.master.surface(self.surfaces[1])
        shown = np.flatnonzero(values)
        if facets_of(surface) is not None and len(shown):
            beyond = surface.project(self.master.pose.to_body(points[shown])).outside
            values[shown[beyond]] = 0.0
        return values

    @property
    def loaded_facets(self) -> Mask:
        """Facets (n_facets,) with a loaded node."""
        return np.asarray((self.at_nodes @ self.forces > 0)[self.facets].any(axis=1))

    @property
    def is_curve(self) -> bool:
        """Whether the contact is between sections: facets are sides of three nodes."""
        return self.facets.shape[1] == 3

    def extent(self, points: Array) -> Array:
        """Out-of-plane extent (n,) of a section's side at points (n, 3): thickness or circumference; one in space."""
        return self.surface.extent(self.slave.pose.to_body(points))

    @property
    def surface(self) -> FacetSurface:
        """The slave's surface, in its own axes."""
        return with_nodes(self.slave.surface(self.surfaces[0]))

    @property
    def is_ring(self) -> bool:
        """Whether the contact is between bodies of revolution."""
        return self.surface.revolved

    def interpolated(self, values: Array, local: Array, beyond: float = 0.0) -> Array:
        """A nodal field (n_points,) interpolated in all facets at common coordinates: (n_facets, n_q).

        The coordinates are those of the square, (n_q, 2), or of a section's side, (n_q, 1).

        By the facets' shape functions, or by the multiplier basis (mortar coupling). Nodes that face nothing, of faces
        that overhang the master's rim, have the value `beyond`.
        """
        nodal = self.at_nodes @ values
        nodal[np.diff(self.at_nodes.indptr) == 0] = beyond
        shapes = pressure_shapes(self.facets, local, self.coupling == "mortar")
        return np.einsum("fqa,fa->fq", shapes, nodal[self.facets])


def _sharing(at_nodes: sp.csr_matrix, facets: IntArray) -> sp.csr_matrix:
    """Which contact points (n,) have a value at a node of which facet (n_facets,)."""
    facet = np.repeat(np.arange(len(facets)), facets.shape[1])
    around = sp.csr_matrix((np.ones(facets.size), (facets.ravel(), facet)), shape=(at_nodes.shape[0], len(facets)))
    values = abs(at_nodes)
    values.eliminate_zeros()
    return sp.csr_matrix(values.T @ around)


def contact_fields(
    interface: Interface, candidates: IntArray, forces: Array, gap: Array, displacements: tuple[Array, Array]
) -> ContactFields:
    """Fields of a paired contact from the forces (n,) and gaps (n,) of its points."""
    slave, pairing = interface.slave, interface.pairing
    surface = interface.slave_surface
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
        node_numbers=shown,
        at_nodes=pairing.at_nodes[shown],
        facets=local.reshape(-1, surface.facets.shape[1]),
        facet_numbers=pairing.covered,
        sharing=_sharing(pairing.at_nodes, surface.facets),
        reference_point=slave.pose.to_world(slave.reference_point),
        displacements=displacements,
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
        # the force on a ring is the sum over its circumference
        samples, vectors = surface.out_of_plane.mean(samples), surface.out_of_plane.mean(vectors)
    moments = np.cross(samples - slave.pose.to_world(slave.reference_point), vectors)
    return pairing.average @ vectors, pairing.average @ samples, pairing.average @ moments
