"""Elastic body of 8-, 20- or 27-node hexahedra."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from scipy.spatial import cKDTree

from fecontact.bodies.body import Body, Outside, Reduced
from fecontact.bodies.geometry import Geometry, recovered
from fecontact.bodies.inner_fields import InnerFields
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import instance, mapping, spelled, text, texts
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, array_of, index_array
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, shown
from fecontact.common.material import Material
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.condensation import ROUTES
from fecontact.fem.energy_error import EnergyError
from fecontact.fem.expansion import Heated
from fecontact.fem.factor import DIRECT
from fecontact.fem.finite_strain import AtState, FiniteStrain, State, at_state
from fecontact.fem.laws import Law, at_rest, laws_of
from fecontact.fem.model import AnyMaterial, Model
from fecontact.fem.modes import Modes, modes_of
from fecontact.fem.rigid import rigid_modes
from fecontact.fem.support import Support, is_plane, symmetry_planes
from fecontact.mesh.check import check_skin
from fecontact.mesh.facets import facet_centres, facet_shapes, triangular
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.refine import refined, touching
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.nodal_weights import components_along

INTEGRATIONS = ("auto", "full", "selective")
#: Distance from a plane, relative to the body's size, within which a boundary counts as flat.
FLAT = 1e-9
#: Distance from a node, relative to the body's size, within which a point is that node.
ON_NODE = 1e-6


@spelled
@compact_repr
@dataclass(frozen=True, eq=False)
class ElasticBody(Body):
    """An elastic body of hexahedra.

    Parameters
    ----------
    mesh : Mesh
    material : Material, or mapping of element set to Material
        Or `OrthotropicMaterial`, `AnisotropicMaterial`; or a law of finite strain, such as `NeoHookean`, or a mapping
        to laws, see docs/how-to/soft-bodies.md.
    contact : str or sequence of str
        Boundaries that may come into contact, or sets of outer nodes: slaves with a force on each node, whose pressure
        is over its share of the faces round it.
    supports : mapping of boundary name to components or directions, optional
        Supports, which fix boundaries to the body's frame: components (``"xyz"``, ``"z"``, ...) along the body's axes;
        ``"n"``, the normal of its faces at each node (a roller, a plane of symmetry, a cylinder's journal; on a curved
        face the normal of the mesh, not of the exact shape); a direction ``(1, 1, 0)`` or several. The frame is held
        unless a load or a motion is prescribed for it (see `Scene.solve`). Motions that no support resists stay free.
    pressure : {'midface', 'nodal'}
        With 20-node hexahedra: 'midface' gives every contact face a ninth node, so that nodal forces are pressures;
        'nodal' is the element of the report, whose corner nodes cannot carry load (kept for comparison).
    name : str, optional
    backend : {'auto', 'pardiso', 'rslab', 'superlu', 'amg'}
        Factorisation back-end; or 'amg', algebraic multigrid (needs pyamg), for bodies whose factor does not fit into
        memory, see docs/scale.md.
    integration : {'auto', 'full', 'selective'}
        Selective reduced integration against locking; 'auto' chooses it for Poisson's ratios above 0.48.
    condensation : {'auto', 'schur', 'columns', 'operator', 'gram-schmidt'}
        Route to the compliance of the candidates: from the Schur complement on their nodes, their columns alone, or
        as an operator with one solve per product. 'auto' decides by the number of candidates and the free memory, see
        `fem.condensation`. 'gram-schmidt' is the source report's route with dense matrices, see `fem.rigid`.
    geometry : 'auto', 'plain', a shape, or a mapping of contact boundary to one of these, optional
        What the nodes of contact faces are placed on, now and when cells are divided: a smooth surface fitted to the
        mesh where its faces are curved ('auto'), a rigid shape such as ``fc.Sphere(10.0)``, as it stands or posed as a
        `RigidBody`, in the axes of the mesh, or nothing ('plain', or None). Flat faces stay as they are, and so do
        faces that no smooth surface represents; a note tells what was moved. Cells of 8 nodes have flat faces;
        ``mesh.upgraded(20)`` makes them curved. See docs/design.md. In a body that is made, the surfaces that were
        found.
    conditions : (m, 3 n_points) sparse matrix or array, optional
        Linear conditions C u = c between displacements u of the points of the mesh (x, y, z of each in turn), in the
        body's axes: equations between nodes, a rigid part of it. c is zero unless `Scene.solve` gives
        ``displacements={body: c}``. Of gaps and loads they are as exact as supports.

    Raises
    ------
    InputError, MeshError
        For an unknown boundary or component, inverted or folded cells, unused or repeated points.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="top", supports={"bottom": "xyz"})
    >>> body.n_dofs
    255
    """

    pressures: ClassVar[tuple[str, ...]] = ("midface", "nodal")
    meshes: ClassVar[type] = Mesh

    mesh: Mesh
    material: AnyMaterial | Law | Mapping[str, AnyMaterial] | Mapping[str, Law]
    contact: str | Sequence[str] = ()
    supports: Mapping[str, Support] = field(default_factory=dict)
    pressure: str = "midface"
    name: str = "body"
    backend: str = "auto"
    integration: str = "auto"
    condensation: str = "auto"
    pose: Pose = field(default_factory=Pose)
    geometry: Geometry | Mapping[str, Geometry] = "auto"
    conditions: sp.csr_matrix | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        text("the name of a body", self.name)
        instance(f"the mesh of {self.name!r}", self.mesh, self.meshes)
        instance(f"the pose of {self.name!r}", self.pose, Pose)
        among("pressure", self.pressure, self.pressures)
        among("integration", self.integration, INTEGRATIONS)
        among("condensation", self.condensation, ROUTES)
        among("factorisation back-end", self.backend, ("auto", *DIRECT, "amg"))
        object.__setattr__(self, "supports", mapping(f"the supports of {self.name!r}", self.supports))
        names = texts(f"the contact boundaries of {self.name!r}", self.contact)
        object.__setattr__(self, "contact", names)
        conditions, before = self._checked_conditions(), self.mesh
        object.__setattr__(self, "mesh", self._checked_mesh(names))
        if conditions is not None:
            object.__setattr__(self, "conditions", _in_middles(conditions, self.mesh, len(before.points)))
        self.model  # noqa: B018 - refuses bad input now; copies in other poses share it
        self._finite_strain  # noqa: B018 - as well

    def _checked_mesh(self, names: tuple[str, ...]) -> Mesh:
        """The mesh of the elements, with checked contact boundaries of these names on their geometry."""
        names = tuple(name for name in names if name in self.mesh.boundaries or name not in self.mesh.node_sets)
        check_skin(self.mesh, names)
        mesh, geometry = recovered(self.mesh, names, self.geometry, self.pressure == "midface")
        object.__setattr__(self, "geometry", geometry)
        return mesh

    def _checked_conditions(self) -> sp.csr_matrix | None:
        given: Any = self.conditions
        if given is None:
            return None
        found, n = given if sp.issparse(given) else array_of(given), 3 * len(self.mesh.points)
        if found is None or found.ndim != 2 or found.shape[1] != n:
            raise InputError(
                f"The linear conditions of {self.name!r} must be an array (m, {n}), three columns for each point of "
                f"its mesh; found {shown(given)}.",
                code="conditions-shape",
            )
        rows = sp.csr_matrix(found, dtype=float, copy=True)
        if not np.isfinite(rows.data).all() or not abs(rows).max(axis=1).toarray().all():
            raise InputError(
                f"The linear conditions of {self.name!r} must be finite, and each of them have a coefficient.",
                code="conditions-values",
            )
        return rows

    @property
    def _n_conditions(self) -> int:
        """Number of linear conditions that were given, without those of middles of faces, which come last."""
        assert self.conditions is not None
        middles = getattr(self.mesh, "midface", None)
        if middles is None:
            return int(self.conditions.shape[0])
        nodes = np.unique(middles[middles >= 0])
        own = self.conditions[:, (3 * nodes[:, None] + np.arange(3)).ravel()]
        return int(self.conditions.shape[0] - np.count_nonzero(np.diff(own.tocsr().indptr)))

    @cached_property
    def model(self) -> Model:
        """The finite element model, in the body's own axes; the same object in every pose of the body."""
        options = (self.backend, self.integration, self.condensation, self.conditions)
        return Model(self.mesh, at_rest(self.material), self.supports, *options)

    @cached_property
    def _finite_strain(self) -> FiniteStrain | None:
        """Its cells at finite strain; None where it has no law, and of a body at a state."""
        laws = laws_of(self.material)
        return FiniteStrain(self.model, laws) if laws and not isinstance(self.model, AtState) else None

    @property
    def _inner_forces(self) -> Array | None:
        """Internal forces (n_dofs,) of a body at a state of finite strain; None for others."""
        return self.model.inner.forces if isinstance(self.model, AtState) else None

    def _stiffen(self, rows: sp.csr_matrix) -> float:
        """Give a body at a state springs along rows, see `contact.hold`, in place of others; return their stiffness."""
        assert isinstance(self.model, AtState)
        return self.model.stiffen(rows)

    def _bend(self, stiffness: sp.csr_matrix) -> None:
        """Add a stiffness (n_dofs, n_dofs) of loads that turn with a surface to that of a body at a state."""
        assert isinstance(self.model, AtState)
        self.model.add(stiffness)

    @property
    def _deformation(self) -> Array | None:
        """Displacements (n_points, 3) of its mesh by a state of finite strain, in its axes; None where it has none."""
        if not isinstance(self.model, AtState) or not self.model.state.u.any():
            return None
        return self.model.at_points(self.model.state.u)

    @property
    def _law_words(self) -> str:
        """Its laws of finite strain, in the words of `describe`; empty of a linear body."""
        names = sorted({type(law).__name__ for law in laws_of(self.material)})
        return f", finite strain by {' and '.join(names)}" if names else ""

    def _linearised(self, state: State, pose: Pose) -> Self:
        """The body at a state of finite strain, in a pose: a linear body, whose displacements change the state.

        Its mesh has the deformed points, its stiffness is the tangent; the internal forces of the state are loads on
        it, see `scene.finite_strain`.

        Raises
        ------
        InvertedError
            If the state turns material inside out.
        """
        assert self._finite_strain is not None
        model = at_state(self._finite_strain, state)
        return self._copied(mesh=model.mesh, pose=pose, model=model)

    def _copied(self, **changes: Any) -> Self:
        """A copy with changes that need no check."""
        other = object.__new__(type(self))
        vars(other).update({f.name: getattr(self, f.name) for f in fields(self)} | changes)
        return other

    def with_modes(self, count: int, kept: Iterable[int] | None = None) -> Modes:
        """Its vibrations with some nodes held, and displacements of these nodes: for a body that moves and turns.

        Parameters
        ----------
        count : int
            Vibrations.
        kept : sequence of int, optional
            Nodes of the mesh; those of the contact boundaries unless given. Each costs 27 coordinates.

        Raises
        ------
        InputError
            For a body with supports, conditions, a law of finite strain or without density; unknown nodes.

        Examples
        --------
        >>> import fecontact as fc
        >>> bar = fc.shapes.block((4.0, 1.0, 1.0), (4, 1, 1))
        >>> modes = ElasticBody(bar, fc.Material(E=1.0, nu=0.3, density=1.0)).with_modes(3)
        >>> modes.frequencies(2).round(3).tolist()  # it bends alike both ways
        [0.055, 0.055]
        """
        if self._finite_strain is not None or any(m.density is None for m in self.model.materials):
            has = "none" if self._finite_strain is None else "a law of finite strain"
            raise InputError(f"Modes are of linear bodies with a density; {self.name!r} has {has}.", code="modes")
        boundaries = [self.mesh.boundary_nodes(name) for name in self.contact]
        nodes = np.concatenate([np.zeros(0, np.int64), *boundaries]) if kept is None else index_array("kept", [*kept])
        if len(nodes) and not 0 <= nodes.min() <= nodes.max() < len(self.mesh.points):
            raise InputError(f"The body has {len(self.mesh.points)} nodes, counted from 0.", code="unknown-node")
        return modes_of(self.model, count, np.unique(nodes))

    @property
    def n_dofs(self) -> int:
        """Number of degrees of freedom, three per node, including held ones."""
        return self.model.n_dofs

    @property
    def n_unknowns(self) -> int:
        """Number of displacement unknowns of its elements, including held ones."""
        return self.model.n_unknowns

    @property
    def notes(self) -> tuple[str, ...]:
        """Corrections made when its mesh was read, and what takes a material for isotropic."""
        return (*self.mesh.notes, *self._notes_of_materials)

    @property
    def _notes_of_materials(self) -> tuple[str, ...]:
        directed = [m.average for m in self.model.given if m.directed]
        means = ", ".join(f"E = {m.E:.4g}, nu = {m.nu:.4g}" for m in directed)
        note = f"growth of pressures at edges, and scales, are those of its mean over all directions: {means}."
        return (note,) if directed else ()

    @property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        return self.model.size

    @property
    def reference_point(self) -> Array:
        """Centre of mass (of volume where no density is given), in the body's axes."""
        return self.model.mass_and_centre[1]

    @property
    def _modulus(self) -> float | None:
        """That of a body of one linear material."""
        materials = set(self.model.materials)
        found = materials.pop() if len(materials) == 1 else None
        return found.E if isinstance(found, Material) and not self.model.is_directed else None

    @property
    def contact_modulus(self) -> float:
        """E / (1 - nu^2) of the softest material."""
        return min(m.plane_strain_modulus for m in self.model.materials)

    @property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions about the reference point."""
        return self.model.rigid_modes

    @property
    def free_motions(self) -> Array:
        """Rigid motions (6, k) that the supports do not resist."""
        return self.model.free_motions

    @cached_property
    def _surfaces(self) -> dict[str, FacetSurface]:
        return {}

    def surface(self, name: str) -> FacetSurface:
        """Facets of a contact boundary.

        Raises
        ------
        InputError
            If the boundary was not declared as a contact surface.
        """
        if name not in self.contact:
            declared = ", ".join(map(repr, self.contact)) or "none"
            self.mesh.faces(name)
            raise InputError(
                f"Boundary {name!r} of {self.name!r} is not a contact surface; declared were: {declared}. "
                f"Pass contact={name!r} when the body is made.",
                code="no-contact-surface",
            )
        if name not in self._surfaces:
            self._surfaces[name] = self._boundary_surface(name)
        return self._surfaces[name]

    def _made_surface(self, facets: IntArray, name: str) -> FacetSurface:
        mesh, planes = self.mesh, symmetry_planes(self.mesh, self.supports)
        return FacetSurface(mesh.points, facets, name, planes=planes, hanging=mesh.hanging)

    def attachment(self, point: Array, direction: Array) -> sp.csr_matrix:
        """One row (1, n_dofs) for the displacement at a point along a direction.

        A point on a node moves with that node. Any other point moves with the body's frame (the supporting bone, for
        instance), to which supports must then fix the body.

        Raises
        ------
        InputError
            If the point is on no node and the body floats.
        """
        model = self.model
        nearest, distance = self._nearest(point)
        if distance <= ON_NODE * model.size:
            return components_along(model.point_row(nearest), np.asarray(direction, dtype=float)[None, :])
        if model.free_motions.shape[1] == 0:
            # six held degrees of freedom that determine the frame's motion, and their weights in that of the point
            frame = model.nodal_modes[model.held]
            six = model.held[scipy.linalg.qr(frame.T, mode="r", pivoting=True)[1][:6]]
            target = direction @ rigid_modes(point[None, :], self.reference_point)
            row = np.zeros(model.n_coordinates)
            row[six] = np.linalg.solve(model.nodal_modes[six].T, target)
            row = model.coordinates.row_on_displacements(row)
        else:
            raise InputError(
                f"The point {np.array2string(point, precision=4)} lies on no node of {self.name!r}, which floats; the "
                f"nearest node is {distance:.4g} away at "
                f"{np.array2string(self._initial_points[nearest], precision=4)}.",
                code="no-node-there",
            )
        return sp.csr_matrix(row)

    @property
    def _initial_points(self) -> Array:
        """Points (n_points, 3) of its mesh without load."""
        model = self.model
        return (model.finite.model if isinstance(model, AtState) else model).mesh.points

    def _nearest(self, point: Array) -> tuple[int, float]:
        """Point of its mesh that is the nearest to one (3,) of its initial shape, and how far it is from that."""
        distance = np.linalg.norm(self._initial_points - point, axis=1)
        return int(np.argmin(distance)), float(distance.min())

    def _present(self, point: Array) -> Array:
        """Place (3,) of a point of its initial shape: a node moves with the state, others with the frame."""
        nearest, distance = self._nearest(point)
        moved = self._deformation
        return point if moved is None or distance > ON_NODE * self.size else point + moved[nearest]

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """Compliance and response along rows, by a route of `fem.condensation`."""
        if self._finite_strain is not None:
            raise InputError(
                f"{self.name!r} has a law of finite strain, which only Scene.solve takes. For small strains give a "
                "Material.",
                code="finite-strain",
            )
        model = self.model
        if model.all_held:
            return Reduced(None, np.zeros(rows.shape[0]))
        C = model.solved_rows(rows)
        condensation = model.condensed(model.touched(rows), timer, rows=C)
        with timer("condense"):
            response = np.zeros(rows.shape[0])
            if loads is not None and loads.any():
                response = condensation.response(C, model.solved_forces(loads))
            return Reduced(condensation.compliance(C), response)

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Elastic displacements (n_dofs,) under forces along rows and external loads."""
        model = self.model
        if model.all_held:
            return np.zeros(self.n_dofs)
        f = np.asarray(rows.T @ forces) if loads is None else rows.T @ forces + loads
        condensation = model.condensed(model.touched(rows), Stopwatch())
        return model.displacements(condensation.solve(model.solved_forces(f)))

    def _inner_fields(self, displacement: Array, rows: sp.csr_matrix, forces: Array) -> InnerFields:
        """Fields inside by displacements (n_dofs,)."""
        return InnerFields(self.model, displacement)

    @property
    def functions_per_cell(self) -> int:
        """Number of scalar functions per cell."""
        return int(self.mesh.cells.shape[1])

    @property
    def _farthest(self) -> float:
        """Largest coordinate of its mesh."""
        return float(np.abs(self.mesh.points).max())

    def _boundary_force(self, name: str, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a resultant (3,) in its axes, as a uniform traction on a boundary."""
        spread = self.model.traction(name, lambda x, n: np.broadcast_to(force, x.shape))
        return spread / self.model.traction(name, lambda x, n: np.broadcast_to([0.0, 0.0, 1.0], x.shape)).sum()

    def _boundary_traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of ``field(points (n, 3), outward normals (n, 3)) -> (n, 3)``, all in its axes."""
        return self.model.traction(name, field)

    def _boundary_surface(self, name: str) -> FacetSurface:
        """Facets of a boundary, or those round a set of nodes."""
        mesh = self.mesh
        if name in mesh.boundaries or name not in mesh.node_sets:
            return self._made_surface(mesh.face_nodes(mesh.faces(name)), name)
        alone, facets = mesh.boundary_nodes(name), mesh.face_nodes(mesh.outer)
        if (inside := ~np.isin(alone, facets)).any():
            raise InputError(
                f"{inside.sum()} of {len(alone)} nodes of {name!r} lie within {self.name!r}; contact needs nodes of "
                "its outer faces.",
                code="nodes-inside",
            )
        facets = facets[np.isin(facets, alone).any(axis=1)]
        return replace(self._made_surface(facets, name), alone=alone)

    def _over_boundary(self, name: str, values: Array) -> Callable[[Array], Array]:
        """Function of points (n, 3) on a boundary that interpolates values at its nodes (n_nodes, ...)."""
        surface = self._boundary_surface(name)

        def field(points: Array) -> Array:
            weights = surface.project(points).weights
            assert weights is not None
            return np.asarray(weights[:, surface.nodes] @ values)

        return field

    def _count_nodes(self, name: str) -> int:
        """Number of nodes of a boundary."""
        return len(self.mesh.boundary_nodes(name))

    def _point_force(self, point: Array, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a force (3,) at a point (3,), both in its axes; see `attachment`."""
        size = float(np.linalg.norm(force))
        return np.asarray(self.attachment(point, force / size).T @ [size]) if size > 0 else np.zeros(self.n_dofs)

    def _prescribed(self, supports: Mapping[str, Array], values: Array | None) -> Array:
        """Displacements (n_dofs,) that supports (n_nodes, 3) and conditions (m,) prescribe, less those of its state."""
        model = self.model
        u = model.prescribed(supports, values)
        return u - model.held_part(model.state.u) if isinstance(model, AtState) else u

    def _heated(self, change: Callable[[Array], Array]) -> Heated:
        """Forces and free strains of a change of temperature.

        Raises
        ------
        InputError
            Without a coefficient of expansion for every material, or with a law of finite strain.
        """
        if laws_of(self.material):
            raise InputError(
                f"{self.name!r} has a law of finite strain; temperatures are offered for small strains. Give it a "
                "Material.",
                code="finite-strain",
            )
        if any(m.expansion is None for m in self.model.materials):
            raise InputError(
                f"A change of temperature needs an expansion for every material of {self.name!r}: "
                "Material(E, nu, expansion=...), 0 where there is none.",
                code="no-expansion",
            )
        return self.model.heated(change(self.mesh.points))

    def _body_force(self, field: Callable[[Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of forces per mass (n, 3) at points (n, 3), both in its axes.

        Raises
        ------
        InputError
            Without a density for every material.
        """
        if any(m.density is None for m in self.model.materials):
            raise InputError(
                f"Gravity needs a density for every material of {self.name!r}: Material(E, nu, density=...).",
                code="no-density",
            )
        return self.model.body_force(field)

    @property
    def _weighted_modes(self) -> Array:
        """Nodal forces (n_dofs, 6) of unit accelerations in the rigid motions about the reference point: M R."""
        return self.model.weighted_modes

    def _shared_faces(self, one: str, other: str) -> int:
        """Number of common faces of two boundaries."""
        keys = [self.mesh.faces(name) @ np.array([6, 1]) for name in (one, other)]
        return int(np.isin(*keys).sum())

    def _at_points(self, displacement: Array) -> Array:
        """Displacements (n_points, 3) of its mesh's points by generalised ones (n_dofs,)."""
        return self.model.at_points(displacement)

    def _energy_error(
        self, displacement: Array, points: Array, reach: float, heated: Heated | None = None
    ) -> EnergyError:
        """Error of displacements (n_dofs,) in the cells whose middles are within `reach` of points (n, 3)."""
        centres = self.mesh.points[self.mesh.cells[:, : self.mesh.n_corners]].mean(axis=1)
        distance, _ = cKDTree(points).query(centres, distance_upper_bound=reach)
        near = np.flatnonzero(np.isfinite(distance))
        return self.model.energy_error(self.model.stressing(displacement, heated), near)

    def _outside(self, displacement: Array) -> Outside:
        """Its outer surface, displaced by (n_dofs,)."""
        points = self.mesh.points + self._at_points(displacement)
        skin = self._skin(points)
        return Outside(points[skin.nodes], skin, self.size, is_bounded=True)

    def _skin(self, points: Array) -> FacetSurface:
        facets = self.mesh.face_nodes(self.mesh.outer_faces)
        return FacetSurface(points, facets, self.name, hanging=self.mesh.hanging)

    def _divided(self, marked: Mapping[str, IntArray], cells: IntArray | None = None) -> Self:
        """The body on a finer mesh, whose cells are checked when its model is made.

        Parameters
        ----------
        marked : mapping of str to (n,) int array
            Facets of its contact surfaces, numbered as in `surface`; every cell that touches one is divided, so that
            none of their nodes is hanging (see `mesh.refine`).
        cells : (n,) int array, optional
            Other cells to divide.

        Examples
        --------
        >>> import fecontact as fc
        >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
        >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="top", supports={"bottom": "xyz"})
        >>> len(body._divided({"top": np.array([0])}).mesh.cells)
        36
        """
        if self.conditions is not None:
            raise InputError(
                f"{self.name!r} has linear conditions between the nodes of its mesh, which accuracy= would divide: "
                "leave accuracy out, and take a finer mesh.",
                code="conditions-on-nodes",
            )
        chosen = [touching(self.mesh, self.mesh.faces(name)[facets]) for name, facets in marked.items()]
        if cells is not None:
            chosen.append(cells)
        finer = self._copied(mesh=refined(self.mesh, np.unique(np.concatenate(chosen))))
        object.__setattr__(finer, "mesh", finer._checked_mesh(tuple(self.contact)))
        return finer

    def _planes_through(self, nodes: IntArray) -> int:
        """Number of boundaries held in one component only (planes of symmetry) with any of these nodes."""
        planes = [name for name, support in self.supports.items() if is_plane(support)]
        return sum(bool(np.isin(nodes, self.mesh.boundary_nodes(name)).any()) for name in planes)

    def _size_lines(self, twin: str = "") -> list[str]:
        """Report lines: the model that it shares with its twin, or its planes of symmetry."""
        if twin:
            return [f"{self.name}: the model of {twin!r} in another pose, factorised once for both"]
        planes = [name for name, support in self.supports.items() if self._mirrors(name, support)]
        if not planes:
            return []
        return [
            f"{self.name}: held along the normal only on {', '.join(planes)}; as planes of symmetry these make "
            f"it 1/{2 ** len(planes)} of the whole"
        ]

    def _mirrors(self, name: str, support: Support) -> bool:
        """Whether a boundary is plane, normal to an axis and held along that axis alone."""
        if not (isinstance(support, str) and is_plane(support) and support in "xyz"):
            return False
        place = self.mesh.points[self.mesh.boundary_nodes(name), "xyz".index(support)]
        return bool(np.ptp(place) <= FLAT * self.size)

    def describe(self) -> str:
        """One-line description of the model."""
        m = self.mesh
        mid = "" if m.midface is None else f" + {(m.midface >= 0).sum()} mid-face nodes"
        return self._described(f"{m.size_line}{mid}{self._ties}, {self.n_unknowns} dofs{self._law_words}")

    @property
    def _is_tied(self) -> bool:  # type: ignore[override]
        """Whether nodes of its mesh follow others."""
        return self.mesh.hanging is not None or self.conditions is not None

    @property
    def _ties(self) -> str:
        """Number of hanging nodes, in words."""
        return "" if self.mesh.hanging is None else f" with {len(self.mesh.hanging.nodes)} hanging nodes"


def _in_middles(conditions: sp.csr_matrix, mesh: Mesh, before: int) -> sp.csr_matrix:
    """Conditions on a mesh of which faces have got nodes in their middles, beyond `before`.

    Where conditions tie a component of all other nodes of a face, that of its middle follows from these.
    """
    rows = conditions.copy()
    rows.resize(rows.shape[0], 3 * len(mesh.points))
    if len(mesh.points) == before:
        return rows
    assert mesh.midface is not None
    faces = np.argwhere(mesh.midface >= before)
    middle, nodes = mesh.midface[tuple(faces.T)], replace(mesh, midface=None).face_nodes(faces)
    N, _ = facet_shapes(nodes.shape[1], triangular(nodes), facet_centres(triangular(nodes)))
    tied = np.zeros(rows.shape[1], bool)
    tied[rows.indices] = True
    face, c = np.nonzero(tied[3 * nodes[:, None, :] + np.arange(3)[:, None]].all(axis=2))
    columns = np.column_stack([3 * middle[face] + c, 3 * nodes[face] + c[:, None]])
    weights = np.column_stack([np.ones(len(face)), -N[face]])
    place = np.repeat(np.arange(len(face)), columns.shape[1])
    own = sp.csr_matrix((weights.ravel(), (place, columns.ravel())), shape=(len(face), rows.shape[1]))
    return sp.vstack([rows, own], format="csr")


def elastic_among(bodies: Iterable[object]) -> tuple[ElasticBody, ...]:
    """Bodies with a mesh and a finite element model."""
    return tuple(b for b in bodies if isinstance(b, ElasticBody))


def of_one_model(bodies: Iterable[Body], before: Iterable[Body]) -> None:
    """Let bodies on finer meshes share a model where they did `before`, if their meshes are equal; in place.

    Two equal balls that press on each other are divided alike: one factor serves both.
    """
    made: dict[int, list[ElasticBody]] = {}
    for body, old in zip(bodies, before, strict=True):
        if not isinstance(body, ElasticBody) or not isinstance(old, ElasticBody):
            continue
        first = made.setdefault(id(old.model), [])
        for twin in first:
            if np.array_equal(twin.mesh.points, body.mesh.points) and np.array_equal(twin.mesh.cells, body.mesh.cells):
                vars(body).update(mesh=twin.mesh, model=twin.model)  # frozen; set before the body escapes
                break
        else:
            first.append(body)
