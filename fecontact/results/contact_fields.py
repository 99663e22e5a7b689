"""Fields of one contact: pressures, gaps and forces at its points, and their resultants."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.bodies.body import Body
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.directions import WORLD, Directions
from fecontact.common.error_estimate import ErrorEstimate
from fecontact.common.region import Region
from fecontact.common.renamed import FormerNames, RenamedKeys, redefined, renamed
from fecontact.contact.interface import Interface
from fecontact.fem.energy_error import EnergyError
from fecontact.fem.expansion import Heated
from fecontact.results.between_nodes import GapsBetweenNodes
from fecontact.results.cell_contact import CellContact, cell_contact
from fecontact.results.contact_outline import ContactOutline, contact_outline
from fecontact.results.error_estimate import PressureReadings, energy_errors, error_estimate, readings_of
from fecontact.results.facet_samples import beside_plane, facet_samples, pressure_shapes
from fecontact.results.friction_fields import FrictionFields, has_reserve, reserve, traction_misfit
from fecontact.results.recovery import RecoveredField, edge_level, recovered_field
from fecontact.results.resultants import part_of, region_numbers, resultant, sides_of_plane
from fecontact.results.singular import SingularEdge, singular_edge
from fecontact.solvers import ContactProblem
from fecontact.surfaces.facet_surface import FacetSurface, facets_of

#: Difference of both areas, relative, up to which they are the same.
SAME = 1e-9
#: Samples per side of a facet, by which one that a plane cuts is divided.
SAMPLES = 8
#: Faces across a contact from which on its edge is located within them.
FACES_ACROSS = 2.0
#: Mean pressure within an outline over the largest, above which the outline leaves out what carries the force.
ABOVE_PEAK = 1.01


@compact_repr
@dataclass(frozen=True, eq=False)
class ContactFields(FormerNames):
    """Pressures, gaps and resultants of one contact. Points and vectors are in world axes.

    Fields at points are those of the slave; `force`, `moment` and all resultants are on the body that is named first in
    the `Contact`, whichever side is the slave.

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
    weights : (n,) array
        Area of each point.
    forces : (n,) array
        Contact forces along the normals, zero where there is no contact.
    gap : (n,) array
        Gaps after deformation; negative where the surfaces of a soft contact overlap.
    reference_point : (3,) array
        Reference point of `moment`: that of the first body.
    coupling : str
        'nodal' or 'mortar'.
    note : str
        Note on the two meshes and the coupling.
    friction : FrictionFields, optional
        Tractions and slip, of a contact with friction.
    worn : (n,) array, optional
        Worn depth since the path of loads began; None without wear.
    wear_error : float
        Estimated error of the worn depth by the size of the steps, over the largest depth.
    overclosure : (n,) array, optional
        Overlap of a soft contact by its pressure, zero where there is none; None for hard contact.
    """

    slave: Body
    master: Body
    surfaces: tuple[str, str]
    points: Array
    normals: Array
    weights: Array
    forces: Array
    gap: Array
    reference_point: Array
    coupling: str
    note: str
    #: Points of action (n, 3): the points, or their means over a multiplier function.
    _centres: Array
    #: Moments (n, 3) about the reference point per unit of contact force.
    _couples: Array
    #: Candidate points (n_candidates,) of the solution.
    _candidates: IntArray
    #: All nodes (m, 3) of the facets that face the master at least partly, and their numbers (m,) in the slave's mesh.
    nodes: Array
    _node_numbers: IntArray
    #: Matrix (m, n) from values at the points to the nodes; rows of nodes that face nothing are empty.
    _at_nodes: sp.csr_matrix
    #: These facets (n_facets, 3 | 4 | 8 | 9) in terms of the nodes (3 columns: sides of a section), and their numbers
    #: (n_facets,) among the facets of the whole surface.
    facets: IntArray
    _facet_numbers: IntArray
    #: Which point has a value on which facet of the whole surface (n, n_surface_facets); points are neighbours if they
    #: share one.
    _sharing: sp.csr_matrix
    #: The slave's surface, in its own axes.
    _surface: FacetSurface
    #: Of slave and master (n_dofs,), in their own axes.
    _displacements: tuple[Array, Array]
    #: Whether the slave is the body named second.
    _swapped: bool = False
    friction: FrictionFields | None = None
    #: Names of directions, for axes of maps.
    directions: Directions = WORLD
    #: Problem of the candidates where these are all its rows: cells of a half-space below a rigid body.
    _cell_problem: ContactProblem | None = field(default=None, repr=False)
    worn: Array | None = None
    wear_error: float = 0.0
    overclosure: Array | None = None
    #: Overclosure by a unit pressure; zero for hard contact.
    _softness: float = 0.0
    #: Temperatures of slave and master.
    _heated: tuple[Heated | None, Heated | None] = (None, None)

    @property
    def bodies(self) -> tuple[Body, Body]:
        """The bodies in the order of the `Contact`; forces are on the first."""
        return (self.master, self.slave) if self._swapped else (self.slave, self.master)

    @property
    def label(self) -> str:
        """Its bodies and surfaces in the order of the `Contact`."""
        names = [f"{body.name}.{name}" for body, name in zip((self.slave, self.master), self.surfaces, strict=True)]
        return " on ".join(names[::-1] if self._swapped else names)

    @property
    def _sign(self) -> float:
        """-1 where the first body is the master: factor from forces on the slave to resultants."""
        return -1.0 if self._swapped else 1.0

    @property
    def pressure(self) -> Array:
        """Pressure (n,): force over area."""
        return self.forces / self.weights

    @property
    def active(self) -> Mask:
        """Points (n,) that carry force."""
        return self.forces > 0

    @cached_property
    def _whole(self) -> Region:
        """Resultants and area: what prints, summaries, files, tables, maps and pages show."""
        return part_of(self, np.ones(len(self.forces)), np.ones(len(self.facets)))

    @property
    def area(self) -> float:
        """Area with the edge located within the faces, that of `outline`.

        More accurate than `point_area`; that it is where fewer than `FACES_ACROSS` faces lie across the contact, on
        which no edge is located, and of regions whose force no outline surrounds.
        """
        return self._redefined("area", "the area within the outline, as it is printed", "point_area")

    @property
    def point_area(self) -> float:
        """Sum of the areas of the points that carry force."""
        return float(self.weights[self.active].sum())

    @property
    def worn_volume(self) -> float:
        """Volume worn off since the path of loads began; zero without wear."""
        return 0.0 if self.worn is None else float(self.weights @ self.worn)

    @property
    def stick_area(self) -> float:
        """Area that sticks, by its outline or, where there is none, by the share of points; zero without friction."""
        if self.friction is None or self.point_area == 0:
            return 0.0
        if self._on_cells is not None:
            return self._on_cells.stick_area
        if (outline := self.stick_outline) is not None:
            return min(outline.area, self._whole.area)
        return self.friction.point_stick_area / self.point_area * self._whole.area

    @property
    def slip_area(self) -> float:
        """The rest of `area`; zero without friction."""
        return 0.0 if self.friction is None else self._whole.area - self.stick_area

    edge_area = renamed("edge_area", "area", lambda contact: contact._whole.area)
    edge_mean_pressure = renamed("edge_mean_pressure", "mean_pressure", lambda contact: contact._whole.mean_pressure)

    @property
    def mean_pressure(self) -> float:
        """Total force over area; zero without contact."""
        return self._redefined("mean_pressure", "over the area within the outline", "total_force / point_area")

    def _redefined(self, name: str, meaning: str, former: str) -> float:
        """A figure that had another value before, with a warning where it has."""
        if abs(self._whole.area - self.point_area) > SAME * self.point_area:
            redefined(name, meaning, former)
        return float(getattr(self._whole, name))

    @property
    def force(self) -> Array:
        """Resultant (3,) on the first body, friction included."""
        return self._on_first("force", resultant(self)[0])

    @property
    def moment(self) -> Array:
        """Moment (3,) on the first body about its reference point, friction included."""
        return self._on_first("moment", resultant(self)[1])

    def _on_first(self, name: str, value: Array) -> Array:
        """A resultant, with a warning where it was on the other body before."""
        if self._swapped:
            redefined(name, f"that on {self.bodies[0].name!r}, which the contact names first", "that on the other body")
        return value

    @property
    def total_force(self) -> float:
        """Sum of the forces along their normals."""
        return float(self.forces.sum())

    @property
    def centre_of_pressure(self) -> Array:
        """Mean position (3,) weighted by force; NaN without contact."""
        total = self.total_force
        return self.forces @ self._centres / total if total > 0 else np.full(3, np.nan)

    @property
    def max_pressure(self) -> float:
        """Largest nodal pressure."""
        return float(self.pressure.max(initial=0.0))

    @cached_property
    def region(self) -> IntArray:
        """Connected region (n,) of each point: 1, 2, ... by load, 0 without force."""
        return region_numbers(self)

    @cached_property
    def regions(self) -> tuple[Region, ...]:
        """Connected parts of the contact area, the most loaded first; points are connected by facets they share."""
        numbers = range(1, self.region.max(initial=0) + 1)
        return tuple(part_of(self, self.region == k, self._facet_region == k) for k in numbers)

    @cached_property
    def _node_region(self) -> IntArray:
        """Connected region (n_nodes,) of each node of the facets, 0 without force."""
        at_nodes = self._at_nodes.copy()
        at_nodes.data = self.region[at_nodes.indices].astype(float)
        return np.asarray(at_nodes.max(axis=1).toarray().ravel(), dtype=np.int64)

    @property
    def _facet_region(self) -> IntArray:
        """Connected region (n_facets,) of each facet, 0 without force."""
        return np.asarray(self._node_region[self.facets].max(axis=1))

    @cached_property
    def _on_cells(self) -> CellContact | None:
        """The pressure on the cells of a half-space; None for other slaves."""
        return cell_contact(self)

    @cached_property
    def _areas(self) -> tuple[Array, Array]:
        """Parts of `area`: of each facet (n_facets,) within the outline, and of points (n,) that none surrounds.

        Cells of a half-space are points, with the edge located within them.
        """
        of_facets, of_points = np.zeros(len(self.facets)), np.where(self.active, self.weights, 0.0)
        if self._on_cells is not None:
            return of_facets, self._on_cells.areas
        if self._readings is None or not self._readings.spanned >= FACES_ACROSS:
            return of_facets, of_points
        n = self.region.max() + 1
        found = np.bincount(self._facet_region, self.outline.areas, n)
        peaks = np.zeros(n)
        np.maximum.at(peaks, self.region, self.pressure)
        located = ABOVE_PEAK * found * peaks >= np.bincount(self.region, self.forces, n)
        return np.where(located[self._facet_region], self.outline.areas, 0.0), of_points * ~located[self.region]

    @cached_property
    def _singular_edge(self) -> SingularEdge | None:
        """Edge towards which the pressure grows without bound, see `results.singular`; None where there is none."""
        return None if self._softness else singular_edge(self)

    @cached_property
    def _readings(self) -> PressureReadings | None:
        """Reconstructions of the pressure, from which errors are estimated; None without pressure."""
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
        pressure: about 18 % (peak 5 %, area 6 %), resolved by 3.5 faces across
        """
        found = error_estimate(self, self._readings)
        if self._on_cells is not None:
            return self._on_cells.estimate(found)
        if self._unseen > 0:
            peak = float(self._between_nodes.unseen.max()) / self.max_pressure
            found = replace(found, pressure=float(np.hypot(found.pressure, self._unseen)), peak=max(found.peak, peak))
        if self._traction_misfit is None:
            return found
        others = found.geometry**2 + found.interior**2 + self._unseen**2
        return replace(found, traction=float(np.sqrt(self._traction_misfit[1] ** 2 + others)))

    @cached_property
    def stick(self) -> ContactFields | None:
        """What sticks as a contact of its own, whose `outline` is the edge of stick; see `results.friction_fields`.

        Its pressure is the reserve of friction, mu p - |t|, its gap the slip. None without friction, or where it has
        no or more than one coefficient, or none that is finite.
        """
        if self.friction is None or not has_reserve(self.friction):
            return None
        forces, gap = reserve(self.friction, self.pressure)
        return replace(self, forces=forces, gap=gap, friction=None, _cell_problem=None)

    @property
    def stick_outline(self) -> ContactOutline | None:
        """Smooth curves round what sticks; None where their place is not known better than the faces."""
        # where nothing slid in this step the distance of the edge is unknown
        if self.friction is None or self.stick is None or not self.friction.slip[self.friction.sliding].any():
            return None
        held = self._stick_readings
        return self.stick.outline if held is not None and held.spanned >= FACES_ACROSS else None

    @cached_property
    def _traction_misfit(self) -> tuple[Array, float] | None:
        """Error of the tractions on the facets of `readings`, and over all tractions; None without friction."""
        if self.stick is None or self.friction is None or self._readings is None:
            return None
        return traction_misfit(self._readings, self._stick_readings, self.friction)

    @cached_property
    def _stick_readings(self) -> PressureReadings | None:
        """Readings of what sticks, at the samples of `readings`; None where nothing does."""
        return None if self.stick is None or self._readings is None else readings_of(self.stick, self._readings.samples)

    @cached_property
    def _between_nodes(self) -> GapsBetweenNodes:
        """Gaps over the faces between contact points, see `results.between_nodes`."""
        return GapsBetweenNodes(self)

    @cached_property
    def _unseen(self) -> float:
        """Relative error (L2) of the pressure due to a rigid shape that varies between the nodes; 0 without contact."""
        if self._readings is None:
            return 0.0
        found = self._readings
        squares = self._between_nodes.unseen[self._facet_numbers[found.facets]] ** 2
        return min(1.0, float(np.sqrt(squares @ found.areas.sum(axis=1) / found.norm))) if found.norm > 0 else 0.0

    @cached_property
    def _energy_errors(self) -> tuple[EnergyError, EnergyError]:
        """Errors in the cells of slave and master below the contact, see `fem.energy_error`."""
        return energy_errors(self, self._readings)

    @cached_property
    def error_indicators(self) -> Array:
        """Mean error (n_surface_facets,) of the pressure on every facet of the slave's whole surface, a pressure.

        Refine where they are large. Their squares, integrated over the facets, are those of `error_estimate.pressure`
        less its parts `geometry` and `interior`, times the integral of the squared pressure.
        """
        out = np.zeros(self._sharing.shape[1])
        if self._readings is not None:
            found = self._readings
            out[self._facet_numbers[found.facets]] = np.sqrt(found.misfit / found.whole)
        return out

    @cached_property
    def _edge_level(self) -> Array:
        """Distances (m,) of the nodes from the edge of the contact, see `results.recovery.edge_level`."""
        return edge_level(self)

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

    @cached_property
    def recovered(self) -> RecoveredField:
        """Continuous pressure that is smooth inside and a square root at the edge; see `results.recovery`.

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

    def split_by_plane(self, point: ArrayLike, normal: ArrayLike) -> tuple[Region, Region]:
        """Resultants on both sides of a plane, for instance medial and lateral.

        The pressure is integrated within the facets: a contact point that a facet shares with the plane counts on both
        sides, and the sum of both is the whole contact. Peaks are of the points on a side.

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

    def _shares(self, point: Array, normal: Array) -> tuple[Array, Array]:
        """Shares (n,) and (n_facets,) of points and facets on the side of a plane to which its unit normal points.

        That of a point is the part of the integral of the function by which its pressure is interpolated.
        """
        every = facet_samples(self.nodes, self.facets, self.coupling == "mortar", self._extent, SAMPLES)
        parts = np.stack([every.areas * beside_plane(every, point, normal), every.areas])
        nodal = np.einsum("sfq,fqa->sfa", parts, every.shapes).reshape(2, -1)
        part, whole = (self._at_nodes.T @ np.bincount(self.facets.ravel(), v, len(self.nodes)) for v in nodal)
        here = np.heaviside((self._centres - point) @ normal, 0.5)
        share = np.divide(part, whole, out=here, where=whole > 0)
        return np.clip(share, 0.0, 1.0), np.divide(*parts.sum(axis=2))

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON; an infinite coefficient of friction as "rough"."""
        out = RenamedKeys(
            slave=self.slave.name,
            master=self.master.name,
            surfaces=list(self.surfaces),
            force_on=self.bodies[0].name,
            **self._whole.summary(),
            error_estimate=self.error_estimate.summary(),
            regions=len(self.regions),
            region_resultants=[region.summary() for region in self.regions],
            note=self.note,
        )
        if self.overclosure is not None:
            out["max_overclosure"] = float(self.overclosure.max(initial=0.0))
        if (friction := self.friction) is not None:
            out["friction"] = RenamedKeys(
                mu=friction.mu if np.isfinite(friction.mu).all() else "rough",
                force=friction.force.tolist(),
                stick_area=self.stick_area,
                slip_area=self.slip_area,
                friction_work=friction.friction_work,
            )
        return out

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
        every = facet_samples(self.nodes, self.facets, self.coupling == "mortar", self._extent, n)
        points = every.points.reshape(-1, 3)
        found = np.einsum("fqa,fa->fq", every.shapes, (self._at_nodes @ values)[self.facets])
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
        return np.asarray((self._at_nodes @ self.forces > 0)[self.facets].any(axis=1))

    @property
    def _is_curve(self) -> bool:
        """Whether the contact is between sections: facets are sides of three nodes."""
        return self.facets.shape[1] == 3

    def _extent(self, points: Array) -> Array:
        """Out-of-plane extent (n,) of a section's side at points (n, 3): thickness or circumference; one in space."""
        return self._surface.extent(self.slave.pose.to_body(points))

    def _interpolated(self, values: Array, local: Array, beyond: float = 0.0) -> Array:
        """A nodal field (n_points,) interpolated in all facets at common coordinates: (n_facets, n_q).

        The coordinates are those of the square, (n_q, 2), or of a section's side, (n_q, 1).

        By the facets' shape functions, or by the multiplier basis (mortar coupling). Nodes that face nothing, of faces
        that overhang the master's rim, have the value `beyond`.
        """
        nodal = self._at_nodes @ values
        nodal[np.diff(self._at_nodes.indptr) == 0] = beyond
        shapes = pressure_shapes(self.facets, local, self.coupling == "mortar")
        return np.einsum("fqa,fa->fq", shapes, nodal[self.facets])


def facets_of_points(at_nodes: sp.csr_matrix, facets: IntArray) -> sp.csr_matrix:
    """Which contact points (n,) have a value at a node of which facet (n_facets,)."""
    facet = np.repeat(np.arange(len(facets)), facets.shape[1])
    around = sp.csr_matrix((np.ones(facets.size), (facets.ravel(), facet)), shape=(at_nodes.shape[0], len(facets)))
    values = abs(at_nodes)
    values.eliminate_zeros()
    return sp.csr_matrix(values.T @ around)


def contact_fields(
    interface: Interface,
    candidates: IntArray,
    forces: Array,
    gap: Array,
    displacements: tuple[Array, Array],
    swapped: bool = False,
) -> ContactFields:
    """Fields of a paired contact from the forces (n,) and gaps (n,) of its points.

    Parameters
    ----------
    swapped : bool
        Whether the slave is the body named second in the `Contact`.
    """
    slave, pairing = interface.slave, interface.pairing
    surface = interface.slave_surface
    shown, local = np.unique(surface.facets[pairing.covered], return_inverse=True)
    first = interface.master if swapped else slave
    reference = first.pose.to_world(first.reference_point)
    normals, centres, couples = _lines_of_action(interface, surface, reference)
    return ContactFields(
        slave=slave,
        master=interface.master,
        surfaces=interface.surfaces,
        points=slave.pose.to_world(pairing.slave_points),
        normals=normals,
        weights=pairing.weights,
        forces=pairing.of_points(forces),
        gap=gap,
        reference_point=reference,
        coupling=pairing.coupling,
        note=interface.note,
        _centres=centres,
        _couples=couples,
        _candidates=candidates,
        nodes=slave.pose.to_world(surface.points[shown]),
        _node_numbers=shown,
        _at_nodes=pairing.at_nodes[shown],
        facets=local.reshape(-1, surface.facets.shape[1]),
        _facet_numbers=pairing.covered,
        _sharing=facets_of_points(pairing.at_nodes, surface.facets),
        _surface=surface,
        _displacements=displacements,
        _swapped=swapped,
    )


def _lines_of_action(interface: Interface, surface: FacetSurface, reference: Array) -> tuple[Array, Array, Array]:
    """`normals`, `centres` and `couples` of `ContactFields`, the latter about a reference point (3,)."""
    slave, pairing, turn = interface.slave, interface.pairing, interface.slave.pose.rotation
    if pairing.sums is not None:
        s = pairing.sums
        couples = s.moments + np.cross(s.origin - slave.pose.to_body(reference), s.normals)
        return s.normals @ turn.T, slave.pose.to_world(s.centres), couples @ turn.T
    samples = slave.pose.to_world(pairing.slave_weights @ surface.points)
    vectors = pairing.slave_normals @ turn.T
    if surface.out_of_plane is not None:
        # the force on a ring is the sum over its circumference
        samples, vectors = surface.out_of_plane.mean(samples), surface.out_of_plane.mean(vectors)
    moments = np.cross(samples - reference, vectors)
    return pairing.average @ vectors, pairing.average @ samples, pairing.average @ moments
