"""Finite element model of an elastic body: assembled once, condensed whenever the candidates change.

A model is in the body's own axes. Bodies that differ by their pose only share it, so two equal spheres need one
factorisation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from fecontact.common.anisotropic import DirectedMaterial
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError, MeshError, shown
from fecontact.common.material import Material
from fecontact.common.stopwatch import Stopwatch
from fecontact.common.viscoelastic import Viscoelastic
from fecontact.fem.amg import AmgFactor, corner_space
from fecontact.fem.condensation import (
    FEW_COLUMNS,
    SEPARATED,
    Bordered,
    Condensation,
    Plain,
    Retained,
    Schur,
    Separated,
    choose_route,
    memory_budget,
)
from fecontact.fem.coordinates import Coordinates, restricted
from fecontact.fem.energy_error import EnergyError, energy_error, free_points
from fecontact.fem.expansion import Heated, expansion_forces, free_strain, stress_forces
from fecontact.fem.factor import Factor, bordered, condense, factorise, has_bordered
from fecontact.fem.multigrid import Multigrid
from fecontact.fem.rigid import null_space, rigid_modes
from fecontact.fem.stiffness import (
    Cells,
    assemble_stiffness,
    body_force,
    moments_of_volume,
    surface_traction,
    symmetric_product,
)
from fecontact.fem.stress import gauss_strain, stress_of, to_nodes
from fecontact.fem.support import (
    Support,
    fix_null_space,
    linked,
    mirrors,
    nodal_coordinates,
    prescribed_displacements,
    share_of_support,
)
from fecontact.mesh.check import check_mesh
from fecontact.mesh.facets import places_among
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import SectionMesh

#: Poisson's ratio above which full integration begins to lock: at 0.49 it is off by a percent or so (docs/accuracy.py).
NEARLY_INCOMPRESSIBLE = 0.48


#: Materials of solids.
AnyMaterial: TypeAlias = Material | DirectedMaterial


class Model:
    """Mesh, materials and supports; derived quantities are computed on first use.

    Parameters
    ----------
    mesh : Mesh
        With hanging nodes, vectors and rows are over all nodes (n_dofs) and the stiffness is solved in fewer
        coordinates, see `fem.coordinates`.
    materials : Material or mapping of element set to Material
        Or `OrthotropicMaterial` and the like, of which `materials` has the isotropic averages.
    supports : mapping of boundary name to components or directions, see `fem.support.nodal_coordinates`
    backend : str
        Factorisation back-end, see `fem.factor.condense`; or 'amg', see `fem.multigrid`.
    integration : {'auto', 'full', 'selective'}
        'selective' integrates the volumetric part at reduced points; 'auto' does so if a Poisson's ratio exceeds
        `NEARLY_INCOMPRESSIBLE`.
    condensation : {'auto', 'schur', 'columns', 'operator', 'gram-schmidt'}
        Route to the compliance, see `fem.condensation`.
    conditions : (m, n_dofs) sparse matrix, optional
        Linear conditions between displacements, see `fem.links`.
    """

    dofs_per_node = 3
    way = "auto"
    condensation: Condensation | None = None
    #: Of a section: whether the strain across it is the elements' own; and where it is that of zero stress, (n_cells,),
    #: its ratio to the sum of those in the plane.
    across_held = False
    across: Array | None = None
    #: Materials as they were given, of which `materials` has the averages; () where they are these.
    given: Sequence[AnyMaterial] = ()
    #: Coordinates of the solve, and those (n_held,) that supports hold.
    coordinates: Coordinates
    held: IntArray

    def __init__(
        self,
        mesh: Mesh,
        materials: AnyMaterial | Mapping[str, AnyMaterial],
        supports: Mapping[str, Support],
        backend: str = "auto",
        integration: str = "auto",
        condensation: str = "auto",
        conditions: sp.csr_matrix | None = None,
    ) -> None:
        self.coordinates, self.held = linked(*nodal_coordinates(mesh, supports), conditions, 3 * len(mesh.points))
        self.material_of_cell, self.given = materials_of_cells(mesh, materials, (Material, DirectedMaterial))
        self.materials = [m.average for m in self.given]
        check_mesh(mesh, None if conditions is None else np.unique(conditions.indices // 3))
        self.mesh, self.supports, self.backend, self.way = mesh, dict(supports), backend, condensation
        self.selective = self._selective(integration)
        self._check_connected(conditions)

    def _selective(self, integration: str, locks: bool = True) -> bool:
        """Whether the volumetric part is integrated at reduced points, of what locks if it is incompressible.

        Raises
        ------
        InputError
            Of a material that is not isotropic.
        """
        nu = max(m.nu for m in self.materials)
        selective = integration == "selective" or (integration == "auto" and locks and nu > NEARLY_INCOMPRESSIBLE)
        if selective and self.is_directed:
            raise InputError(
                "Selective integration is offered for isotropic materials only, and the mean Poisson's ratio of this "
                f"body is {nu:.4g}: integration='full' solves it, too stiff by some percent.",
                code="selective-anisotropic",
            )
        return selective

    @property
    def is_directed(self) -> bool:
        """Whether a material is not isotropic."""
        return any(m.directed for m in self.given)

    @property
    def n_dofs(self) -> int:
        """Number of displacements of all nodes, including held and hanging ones."""
        return 3 * len(self.mesh.points)

    @property
    def n_coordinates(self) -> int:
        """Number of coordinates, including held ones."""
        return self.coordinates.count(self.n_dofs)

    @property
    def n_unknowns(self) -> int:
        """Number of displacement unknowns of the elements, including held ones, without hanging nodes."""
        return self.dofs_per_node * self.n_coordinates // 3

    @property
    def functions(self) -> IntArray:
        """Scalar functions (n_cells, n) on each cell: here its nodes."""
        return self.mesh.cells

    @property
    def n_retained(self) -> int:
        """Degrees of freedom retained by the present condensation; 0 before the first."""
        return 0 if self.condensation is None else self.condensation.n_retained

    def __getstate__(self) -> dict[str, Any]:
        """State for pickling and copies: without the factor, which is a library's memory, but with its inverse."""
        state = {k: v for k, v in vars(self).items() if k != "stiffness"}
        last = self.condensation
        state["condensation"] = last.carried(self.factorised) if isinstance(last, Retained) else None
        return state

    def factorised(self) -> Factor:
        """A plain factor of the stiffness over the solved degrees of freedom."""
        return factorise(self._assembled(Stopwatch()), self.backend)

    def _check_connected(self, conditions: sp.csr_matrix | None = None) -> None:
        """Refuse a part without connection to the rest that its own supports do not hold."""
        cells = self.functions
        ends = (np.arange(len(cells)).repeat(cells.shape[1]), cells.ravel())
        touched = sp.csr_matrix((np.ones(cells.size), ends), shape=(len(cells), self.n_dofs // 3))
        if (ties := self.coordinates.ties) is not None:
            # a cell at a hanging node is connected to those at the nodes that it follows from
            touched += touched[:, ties.nodes] @ abs(ties.weights)
        if conditions is not None:
            entries = abs(conditions).tocoo()
            shape = (conditions.shape[0], self.n_dofs // 3)
            nodes_of = sp.csr_matrix((entries.data, (entries.row, entries.col // 3)), shape=shape)
            touched = sp.hstack([touched, touched @ nodes_of.T])
        count, part = connected_components(touched @ touched.T, directed=False)
        if count == 1:
            return
        nodes = self.held // 3
        owner = np.zeros(self.n_dofs // 3, dtype=np.int64)
        owner[cells] = part[:, None]
        owner = self.coordinates.of_functions(owner)
        for k in range(count):
            if self.null_space_of(self.held[owner[nodes] == k]).shape[1]:
                raise MeshError(
                    f"The mesh has {count} parts without connection, and the one with cell {np.argmax(part == k)} can "
                    "move by itself. Make each part a body of its own, or join them with fecontact.mesh.mesh.merge.",
                    code="several-parts",
                )

    def _per_cell(self, name: str) -> Array:
        return np.array([getattr(m, name) for m in self.materials], dtype=float)[self.material_of_cell]

    @cached_property
    def elements(self) -> Cells:
        """The cells by kind of element."""
        return Cells.of(self.mesh)

    @cached_property
    def lame(self) -> Array:
        """First Lame constant of each cell."""
        return self._per_cell("lame")

    @cached_property
    def shear(self) -> Array:
        """Shear modulus of each cell."""
        return self._per_cell("shear_modulus")

    @property
    def moduli(self) -> Array | None:
        """Moduli (n_cells, n_q or 1, 6, 6) in the body's axes, see `fem.stiffness`; None where all are isotropic."""
        return self._moduli

    @cached_property
    def _moduli(self) -> Array | None:
        return self._at_places(lambda material, x: material.at(x), (6, 6)) if self.is_directed else None

    @cached_property
    def _expansions(self) -> Array:
        """Strains (n_cells, n_q or 1, 6) per change of temperature, in the body's axes."""
        if self.is_directed:
            return self._at_places(lambda material, x: material.expansion_at(x), (6,))
        return self._per_cell("expansion")[:, None, None] * (np.arange(6) < 3)

    def _at_places(self, of: Callable[[Any, Array], Array], shape: tuple[int, ...]) -> Array:
        """What materials have (n_cells, n_q or 1, ...) at the Gauss points, or once where none varies."""
        places = gauss_strain(self.elements, np.zeros_like(self.mesh.points))[1]
        places = np.where(np.isnan(places), places[:, :1], places)
        if not any(m.varies for m in self.given):
            places = places[:, :1]
        out = np.empty((*places.shape[:2], *shape))
        for k, material in enumerate(self.given):
            own = self.material_of_cell == k
            found = of(material, places[own].reshape(-1, 3))
            out[own] = found if len(found) == 1 else found.reshape(out[own].shape)
        return out

    def stress(self, strain: Array) -> Array:
        """Stresses (n_cells, n_q, 6) of strains at the Gauss points."""
        return stress_of(strain, self.lame, self.shear, self.moduli)

    @cached_property
    def density(self) -> Array:
        """Density of each cell; one everywhere if no material has any, so that mass is volume."""
        given = [m.density for m in self.materials]
        if all(d is None for d in given):
            return np.ones(len(self.mesh.cells))
        if any(d is None for d in given):
            raise InputError("Give a density to every material of the body or to none.", code="some-densities")
        return self._per_cell("density")

    @cached_property
    def mass_and_centre(self) -> tuple[float, Array]:
        """Mass and its centre."""
        return moments_of_volume(self.elements, self.density)

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.mesh.points, axis=0)))

    @cached_property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions about the centre of mass."""
        return rigid_modes(self.mesh.points, self.mass_and_centre[1])

    @cached_property
    def weighted_modes(self) -> Array:
        """Nodal forces (n_dofs, 6) of unit accelerations in the rigid motions about the centre of mass: M R."""
        centre = self.mass_and_centre[1]

        def column(motion: Array) -> Array:
            return self.body_force(lambda x: motion[:3] + np.cross(motion[3:], x - centre))

        return np.stack([column(motion) for motion in np.eye(6)], axis=1)

    @cached_property
    def nodal_modes(self) -> Array:
        """Coordinates (n_coordinates, 6) of the rigid modes."""
        return self.coordinates.of_displacements(self.rigid_modes)

    def null_space_of(self, held: IntArray) -> Array:
        """Rigid motions (6, k) that held coordinates do not resist."""
        return null_space(self.nodal_modes[held], self.size)

    @cached_property
    def free_motions(self) -> Array:
        """Rigid motions (6, k) that the supports do not resist."""
        return self.null_space_of(self.held)

    @cached_property
    def pinned_dofs(self) -> IntArray:
        """Artificially held coordinates, one for each free motion; results do not depend on the choice.

        None where the free motions are separated instead.
        """
        if self.way == SEPARATED:
            return np.zeros(0, dtype=np.int64)
        return fix_null_space(self.nodal_modes @ self.free_motions, self.held, self.size)

    @cached_property
    def solved_dofs(self) -> IntArray:
        """Coordinates that are held neither by supports nor artificially."""
        every = np.arange(self.n_coordinates)
        return np.setdiff1d(every, np.concatenate([self.held, self.pinned_dofs]), assume_unique=True)

    @property
    def all_held(self) -> bool:
        """Whether supports and conditions leave nothing to deform, so that the body is rigid."""
        return len(self.solved_dofs) == 0

    @property
    def by_cells(self) -> bool:
        """Whether the stiffness is the sum of isotropic solid cells over the nodes of the mesh."""
        whole = type(self).stiffness is Model.stiffness and self.n_dofs == 3 * len(self.mesh.points)
        return whole and not self.is_directed

    def unstressed(self) -> Model:
        """The model without strain: itself, unless it is at a state of finite strain."""
        return self

    @cached_property
    def stiffness(self) -> sp.csr_matrix:
        """Upper triangle of the stiffness (n_dofs, n_dofs) of the elements, before hanging nodes are eliminated."""
        return assemble_stiffness(self.mesh, self.lame, self.shear, self.selective, self.moduli)

    def body_force(self, field: Callable[[Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of a force per mass ``field(points (n, 3)) -> (n, 3)``."""
        return body_force(self.elements, field, self.density)

    def heated(self, change: Array) -> Heated:
        """Forces and free strains of a change of temperature (n_points,)."""
        strain = free_strain(self.elements, self._expansions, change, self.across)
        if self.moduli is not None:
            return Heated(stress_forces(self.elements, self.stress(strain)), strain)
        expansion = self._per_cell("expansion")
        return Heated(
            expansion_forces(self.elements, expansion, change, self._lame_sum, self.shear, self.selective), strain
        )

    def stressing(self, u: Array, heated: Heated | None) -> Array:
        """Displacements (n_dofs,), or of a heated body the strains (n_cells, n_q, 6) that have stress."""
        return u if heated is None else self.gauss_strain(u) - heated.strain

    @property
    def _lame_sum(self) -> Array:
        """Sum (n_cells,) of the stresses that the first Lame constant gives by a unit strain in all directions."""
        return 3 * self.lame

    def traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of ``field(points (n, 3), unit outward normals (n, 3)) -> (n, 3)`` on a boundary."""
        return surface_traction(self.mesh, self.mesh.faces(name), field)

    def gauss_strain(self, u: Array) -> Array:
        """Strains (n_cells, n_q, 6) at the Gauss points under displacements (n_dofs,)."""
        return gauss_strain(self.elements, u.reshape(-1, 3), self.selective, self.across)[0]

    def nodal_strain(self, u: Array) -> Array:
        """Strains (n_points, 6) at the nodes."""
        return to_nodes(self.elements, self.gauss_strain(u))

    def nodal_stress(self, u: Array, cells: IntArray | None = None) -> Array:
        """Stresses (n_points, 6) at the nodes, averaged over all cells, or some (NaN at nodes without such a cell)."""
        return to_nodes(self.elements, self.stress(self.gauss_strain(u)), cells)

    def strain_energy(self, u: Array) -> float:
        """Energy of displacements (n_dofs,)."""
        return float(u @ self.internal_forces(u)) / 2

    def internal_forces(self, u: Array) -> Array:
        """Forces (n_dofs,) inside under displacements (n_dofs,)."""
        return symmetric_product(self.stiffness, u)

    def energy_error(
        self, u: Array, cells: IntArray, other: Array | None = None, free: Mask | None = None
    ) -> EnergyError:
        """Error of displacements (n_dofs,), or strains (n_cells, n_q, 6), in cells (n,), or its product with others.

        Nothing acts on points that are `free` (n_points,), apart from supports.
        """
        second = None if other is None else other.reshape(-1, 3)
        skin = None if free is None else free_points(*self._skin(), self.without_supports(free))
        constants = self.lame, self.shear, cells, self.selective
        first = u if u.ndim == 3 else u.reshape(-1, 3)
        return energy_error(self.elements, first, *constants, second, skin, self.across, self.across_held, self.moduli)

    def _skin(self) -> tuple[IntArray, Array]:
        """Outer faces (n, k) and their normals (n, 3), of any length."""
        faces = self.mesh.face_nodes(self.mesh.outer)
        corners = self.mesh.points[faces[:, :4]]
        return faces, np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])

    def without_supports(self, points: Mask) -> Mask:
        """Those points (n_points,) of the mesh that no support holds."""
        out = points.copy()
        for name in self.supports:
            out[self.mesh.boundary_nodes(name)] = False
        return out

    def touched(self, rows: sp.csr_matrix) -> IntArray:
        """Triples of coordinates, each of one node, that rows (n, n_dofs) act on."""
        return np.unique(self.coordinates.rows(rows).indices // 3)

    @property
    def mesh_at_rest(self) -> Mesh:
        """The mesh before a deformation at finite strain."""
        return self.mesh

    def at_points(self, u: Array) -> Array:
        """Displacements (n_points, 3) of the mesh's points."""
        return u.reshape(-1, 3)

    def point_row(self, point: int) -> sp.csr_matrix:
        """Weights (1, n_functions) of the displacement of a point of the mesh."""
        return sp.csr_matrix(([1.0], ([0], [point])), shape=(1, self.n_dofs // 3))

    def prescribed(self, supports: Mapping[str, Array], values: Array | None) -> Array:
        """Displacements (n_dofs,) that supports (n_nodes, 3) and conditions (m,) prescribe, zero where nothing does.

        Raises
        ------
        InputError
            If they contradict each other, or a support does not hold them.
        """
        T = self.coordinates
        given = prescribed_displacements(self.mesh_at_rest, self.supports, supports)
        held = self._only_held(T.of_displacements(given.ravel()))
        if T.links is not None:
            held[T.links.dependents] = 0.0
            c = np.zeros(T.links.given.shape[1]) if values is None else values
            held[T.links.dependents] = T.links.values(c, held)
        return T.displacements(held)

    def held_part(self, u: Array) -> Array:
        """The displacements (n_dofs,) of which held coordinates are as under u, and all others zero."""
        return self.coordinates.displacements(self._only_held(self.coordinates.of_displacements(u)))

    def _only_held(self, v: Array) -> Array:
        out = np.zeros(self.n_coordinates)
        out[self.held] = v[self.held]
        return out

    def support_forces(self, name: str, rest: Array) -> Array:
        """Contribution (n_dofs,) of one support to the support forces, see `fem.support`."""
        return share_of_support(self.mesh, self.supports, name, self.coordinates.gathered(rest))

    def condensed(
        self, nodes: IntArray, timer: Stopwatch, poses: int = 1, rows: sp.csr_matrix | None = None
    ) -> Condensation:
        """Condensation onto at least the given triples; the last one is cached and reused if it covers them.

        For several poses it is dense where that is quicker in all and the memory allows. With the rows (n, n_solved)
        themselves, over the solved coordinates, their compliance alone may be computed.
        """
        mask = np.zeros(self.n_coordinates, bool)
        mask[(3 * nodes[:, None] + np.arange(3)).ravel()] = True
        dofs = np.flatnonzero(mask[self.solved_dofs])
        if len(dofs) == 0:  # a body out of contact; a factorisation keeps at least one degree of freedom
            dofs = np.zeros(1, dtype=np.int64)
        last = self.condensation
        if self.backend == "amg":
            return self._multigrid(timer)
        if self.way == SEPARATED:
            return self._separated(timer)
        route, why = self.way, "as asked"
        border = (rows is not None or poses > 1) and has_bordered(self.backend)
        if route == "auto":
            known = last.n_rows if rows is None and isinstance(last, Plain) else None
            n_rows, size = known if rows is None else rows.shape[0], 0 if last is None else last.memory
            route, why = choose_route(
                len(self.solved_dofs), len(dofs), memory_budget(), poses, not border, n_rows, float(size)
            )
        other_rows = isinstance(last, Bordered) and rows is not None and not last.covers_rows(rows)
        if poses > 1 and last is not None and (route != "schur" or isinstance(last, (Plain, Bordered))):
            # columns are made for each case; a plain factor covers all rows, and is no Schur complement
            covered = route != "schur"
        else:
            covered = last is not None and last.covers(dofs) and (not other_rows or route == "operator")
        if last is not None and covered:
            if isinstance(last, (Plain, Bordered)) and rows is not None and route not in ("schur", last.route):
                last = self.condensation = Plain(last.factor, route, why, rows.shape[0])
            return last
        # K is kept where the rows change again, as from pose to pose
        K = self._assembled(timer, kept=isinstance(last, Bordered))
        few = self.way == "auto" and rows is not None and rows.shape[0] <= FEW_COLUMNS
        if route == "columns" and rows is not None and border and not few:
            with timer("factorise"):
                self.condensation = last = None  # two factors at once would take twice the memory
                factor = bordered(K, rows)
            if factor is not None:
                self.condensation = Bordered(factor, rows, why)
                return self.condensation
        if route != "schur":
            with timer("factorise"):
                self.condensation = Plain(
                    factorise(K, self.backend), route, why, None if rows is None else rows.shape[0]
                )
            return self.condensation
        if isinstance(last, Retained):
            # earlier candidates are likely to return in a sweep
            dofs = np.union1d(dofs, np.flatnonzero(last.position >= 0))
        with timer("factorise"):
            condensed = condense(K, dofs, self.backend)
        with timer("condense"):
            self.condensation = Schur.of(condensed, len(self.solved_dofs), dofs, why)
            if isinstance(last, Retained) and last.inverted:
                self.condensation.invert()
        return self.condensation

    def has_condensed(self, rows: sp.csr_matrix) -> Mask:
        """Mask of rows (n, n_dofs) that the present dense condensation covers; all False before the first."""
        own = self.solved_rows(rows)
        if not isinstance(self.condensation, Retained):
            return np.zeros(own.shape[0], bool)
        missing = sp.csr_matrix((self.condensation.position[own.indices] < 0, own.indices, own.indptr), shape=own.shape)
        return np.asarray(missing.sum(axis=1)).ravel() == 0

    def _assembled(self, timer: Stopwatch, kept: bool = False) -> sp.csr_matrix:
        """Stiffness over the solved coordinates, a copy; that of the elements is forgotten unless it is to be kept."""
        with timer("assemble"):
            K = self.solved_stiffness()
            if not kept:
                vars(self).pop("stiffness", None)
        return K

    def _separated(self, timer: Stopwatch) -> Condensation:
        """Stiffness with the free rigid motions separated; cached."""
        if self.condensation is None:
            K = self._assembled(timer)
            with timer("factorise"):
                rigid = (self.nodal_modes @ self.free_motions)[self.solved_dofs]
                self.condensation = Separated.of(K, rigid, memory_budget())
        return self.condensation

    def _multigrid(self, timer: Stopwatch) -> Condensation:
        """Algebraic multigrid in place of a factor; cached."""
        if self.condensation is None:
            if self.n_dofs != 3 * len(self.mesh.points):
                raise InputError("The back-end 'amg' is for nodal displacements; use 'auto' here.")
            if self.way not in ("auto", "operator"):
                raise InputError(f"The back-end 'amg' has products only: condensation={self.way!r} needs a factor.")
            K = self._assembled(timer)
            with timer("factorise"):
                factor = AmgFactor(K, self.nodal_modes[self.solved_dofs], self._corners())
                self.condensation = Multigrid(factor, self.solved_positions, mirrors(self.mesh, self.supports))
        return self.condensation

    @property
    def solved_positions(self) -> Array:
        """Positions (n_solved, 3) of the solved coordinates."""
        return np.repeat(self.coordinates.of_functions(self.mesh.points), 3, axis=0)[self.solved_dofs]

    def _corners(self) -> tuple[IntArray, sp.csr_matrix] | None:
        """Solved coordinates of corners and the interpolation from them; None if there are no other nodes.

        Also None with hanging nodes and linear conditions, which follow from nodes that are no corners.
        """
        corners, weights = corner_space(self.mesh)
        T = self.coordinates
        if len(corners) == len(self.mesh.points) or T.ties is not None or T.links is not None:
            return None
        P = sp.kron(weights, sp.eye_array(3), format="csr")
        dofs = (3 * corners[:, None] + np.arange(3)).ravel()
        axes = T.axes
        if axes is not None:
            P = axes.T @ P @ axes[dofs][:, dofs]
        kept = np.isin(dofs, self.solved_dofs)
        return np.searchsorted(self.solved_dofs, dofs[kept]), sp.csr_matrix(P[self.solved_dofs][:, kept])

    def solved_stiffness(self) -> sp.csr_matrix:
        """Upper triangle of the stiffness over the solved coordinates."""
        K = self.coordinates.stiffness(self.stiffness)
        return K if len(self.solved_dofs) == self.n_coordinates else restricted(K, self.solved_dofs)

    def solved_forces(self, f: Array) -> Array:
        """Forces (n_dofs,) on the solved coordinates."""
        return self.coordinates.forces(f)[self.solved_dofs]

    def displacements(self, v: Array) -> Array:
        """Displacements (n_dofs,) of all nodes by the solved coordinates; held ones are zero."""
        whole = np.zeros(self.n_coordinates)
        whole[self.solved_dofs] = v
        return self.coordinates.displacements(whole)

    def solved_rows(self, rows: sp.csr_matrix) -> sp.csr_matrix:
        """Rows (n, n_dofs) over the solved coordinates, without held ones."""
        coo = self.coordinates.rows(rows).tocoo()
        number = places_among(self.solved_dofs, self.n_coordinates)
        column = number[coo.col]
        kept = column >= 0
        shape = (rows.shape[0], len(self.solved_dofs))
        return sp.csr_matrix((coo.data[kept], (coo.row[kept], column[kept])), shape=shape)


def materials_of_cells(
    mesh: Mesh | SectionMesh, given: Any, kinds: tuple[type, ...] = (Material,)
) -> tuple[IntArray, list[Any]]:
    """Index of each cell's material and the list of materials, which are of these kinds.

    Raises
    ------
    InputError
        If they are of another kind, or leave cells without, or give some two.
    """
    if isinstance(given, kinds):
        return np.zeros(len(mesh.cells), dtype=np.int64), [given]
    if any(isinstance(m, Viscoelastic) for m in (given.values() if isinstance(given, Mapping) else [given])):
        raise InputError(
            "Visco-elastic materials are for half-spaces (HalfSpace) and solids of bricks (AncfSolid); this body is "
            "elastic: take its Material at once (`.material`) or after a long time (`.relaxed`).",
            code="viscoelastic",
        )
    if any(isinstance(m, DirectedMaterial) for m in (given.values() if isinstance(given, Mapping) else [given])) and (
        DirectedMaterial not in kinds
    ):
        raise InputError(
            "Orthotropic and anisotropic materials are for solids and sections; this body is isotropic: give it a "
            "Material, such as their `.average`.",
            code="anisotropic",
        )
    if not isinstance(given, Mapping) or not all(isinstance(m, kinds) for m in given.values()):
        raise InputError(f"A body takes one Material or a mapping of element sets to Materials; found {shown(given)}.")
    index = np.full(len(mesh.cells), -1, dtype=np.int64)
    for k, name in enumerate(given):
        if name not in mesh.groups:
            raise InputError(f"The mesh has no element set {name!r}. Its sets are: {', '.join(mesh.groups) or 'none'}.")
        members = mesh.groups[name]
        if (index[members] >= 0).any():
            raise InputError(
                f"Cell {members[index[members] >= 0][0]} is in {name!r} and in another set with a material.",
                code="two-materials",
            )
        index[members] = k
    if (index < 0).any():
        raise InputError(f"{(index < 0).sum()} cells have no material; the first is cell {np.argmax(index < 0)}.")
    return index, list(given.values())
