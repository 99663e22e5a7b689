"""Elastic body of eight-node bricks with gradient coordinates (`fecontact.ancf`), for small strains.

Linear model of an elastic ANCF body: small strains about the initial shape.

Scalar functions take the place of the nodes of `fem.model.Model`: positions and gradients have three components each,
so condensation, fix_null_space and rigid modes use the same code.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.bricks.hexahedron import gauss
from fecontact.ancf.bricks.loads import body_force
from fecontact.ancf.bricks.loads import traction as surface_traction
from fecontact.ancf.bricks.solid import AncfSolid, linear_functions
from fecontact.ancf.bricks.space import AncfSpace, check_bricks, sides_by_label
from fecontact.ancf.system.joints import hold
from fecontact.bodies.elastic import ElasticBody
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.material import Material
from fecontact.fem.coordinates import Coordinates
from fecontact.fem.energy_error import NO_CELLS, EnergyError
from fecontact.fem.laws import without_law
from fecontact.fem.model import Model, materials_of_cells
from fecontact.fem.stress import hooke
from fecontact.fem.support import Support, symmetry_planes
from fecontact.mesh.check import check_mesh, check_skin
from fecontact.mesh.element import hex_nodes, hex_quadrature
from fecontact.mesh.mesh import Mesh
from fecontact.surfaces.facet_surface import FacetSurface, Projection
from fecontact.surfaces.nodal_weights import components_along

#: Poisson's ratio above which the divergence is projected on linear functions in each cell; below it contact pressures
#: are more accurate without projection (docs/ancf.md).
NEARLY_INCOMPRESSIBLE = 0.49
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


class AncfModel(Model):
    """Mesh of 20-node geometry, materials and supports, with the bricks' functions.

    Parameters
    ----------
    mesh : Mesh
        hex20; the corners are the element's nodes, the others define the edges.
    materials, supports, backend, integration
        As in `fem.model.Model`.
    """

    def __init__(
        self,
        mesh: Mesh,
        materials: Material | Mapping[str, Material],
        supports: Mapping[str, Support],
        backend: str = "auto",
        integration: str = "auto",
    ) -> None:
        self.material_of_cell, self.materials = materials_of_cells(mesh, materials)
        check_mesh(mesh)
        self.mesh, self.supports, self.backend = mesh, dict(supports), backend
        self.selective = integration == "selective" or (
            integration == "auto" and max(m.nu for m in self.materials) > NEARLY_INCOMPRESSIBLE
        )
        several = len(self.materials) > 1
        self.space = AncfSpace(mesh, sides_by_label(mesh, self.material_of_cell) if several else None)
        self.solid = AncfSolid(self.space, materials)
        held = hold(self.space, supports)
        plain = (held.basis - sp.eye_array(self.n_dofs)).nnz == 0
        self.coordinates, self.held = Coordinates(None if plain else held.basis), held.held
        self._check_connected()

    @property
    def n_dofs(self) -> int:
        """Number of coordinates, including held ones."""
        return self.space.n_dofs

    @property
    def n_unknowns(self) -> int:
        """Number of coordinates of the elements."""
        return self.n_dofs

    @property
    def functions(self) -> IntArray:
        """Scalar functions (n_cells, 8) that connect cells: the positions of their nodes."""
        return self.space.start[self.space.corners]

    @cached_property
    def rigid_modes(self) -> Array:
        """Changes (n_dofs, 6) of positions and gradients under the rigid motions about the centre of mass."""
        return self.space.rigid_modes(self.mass_and_centre[1])

    @cached_property
    def stiffness(self) -> sp.csr_matrix:
        """Upper triangle of the stiffness (n_dofs, n_dofs)."""
        solid = self.solid
        return sp.triu(solid.stiffness_of_linear_dilatation if self.selective else solid.stiffness, format="csr")

    @cached_property
    def _interpolation(self) -> sp.csr_matrix:
        """Displacements (n_points, n_functions) of all points of the mesh."""
        cells = self.mesh.cells
        _, first = np.unique(cells, return_index=True)
        cell, local = np.divmod(first, cells.shape[1])
        return self.space.rows_at(cell, hex_nodes(cells.shape[1])[local])

    def at_points(self, u: Array) -> Array:
        """Displacements (n_points, 3) of the mesh's points."""
        return np.asarray(self._interpolation @ u.reshape(-1, 3))

    def point_row(self, point: int) -> sp.csr_matrix:
        """Weights (1, n_functions) of the displacement of a point of the mesh."""
        return self._interpolation[[point]]

    def traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Forces (n_dofs,) of a traction on a boundary."""
        return surface_traction(self.space, name, field)

    def body_force(self, field: Callable[[Array], Array]) -> Array:
        """Forces (n_dofs,) of a force per mass."""
        return body_force(self.space, field, self.density)

    def support_forces(self, name: str, rest: Array) -> Array:
        """Contribution (n_dofs,) of one support to the support forces.

        With P_s the projector on the space held by support s: P_s (sum of P)^+ rest, as in
        `fem.support.share_of_support`.
        """
        own = hold(self.space, {name: self.supports[name]})
        total = sp.csr_matrix((self.n_dofs, self.n_dofs))
        for other, support in self.supports.items():
            rows = hold(self.space, {other: support}).rows
            total = total + rows.T @ rows
        touched = np.unique(own.rows.indices)
        share = np.zeros(self.n_dofs)
        # the blocks of the nodes are small; the pseudo-inverse acts on the range of all supports
        axes = self.coordinates.axes
        basis = sp.eye_array(self.n_dofs, format="csr") if axes is None else axes
        Z = basis[:, self.held].tocsr()
        inside = sp.linalg.spsolve((Z.T @ total @ Z).tocsc(), Z.T @ rest)
        share[touched] = (own.rows.T @ (own.rows @ (Z @ inside)))[touched]
        return share

    def gauss_strain(self, u: Array) -> Array:
        """Strains (n_cells, 27, 6) inside the cells."""
        return self._strain_at(u, hex_quadrature(20)[0])

    def energy_error(
        self, u: Array, cells: IntArray, other: Array | None = None, free: Mask | None = None
    ) -> EnergyError:
        """None: gradients are shared at nodes, so strains do not jump and none is smoother."""
        return NO_CELLS

    def nodal_strain(self, u: Array) -> Array:
        """Strains (n_points, 6) at the mesh's points, evaluated there and averaged over the cells round a point."""
        return self._averaged(self._strain_at(u, hex_nodes(20)))

    def nodal_stress(self, u: Array, cells: IntArray | None = None) -> Array:
        """Stresses (n_points, 6) as `nodal_strain`; averaged over given cells only, other points get NaN."""
        stress = hooke(self._strain_at(u, hex_nodes(20)), self.lame[:, None], self.shear[:, None])
        return self._averaged(stress, cells)

    def _averaged(self, values: Array, among: IntArray | None = None) -> Array:
        cells, values = (self.mesh.cells, values) if among is None else (self.mesh.cells[among], values[among])
        total = np.zeros((len(self.mesh.points), values.shape[2]))
        count = np.bincount(cells.ravel(), minlength=len(total))[:, None]
        np.add.at(total, cells, values)
        return np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0)

    def _strain_at(self, u: Array, X: Array) -> Array:
        """Strains (n_cells, n_q, 6) at reference points.

        With selective integration the volume change is the cell's linear projection, as in the stiffness.
        """
        strain = self._plain_strain(u, X)
        if self.selective:
            points, weights = gauss(self.solid.points)
            change = self._plain_strain(u, points)[:, :, :3].sum(axis=2)
            dV = np.concatenate([batch.dV for batch in self.space.batches(points, weights)])
            coefficients = self.solid.linear_fit(dV) @ change[:, :, None]
            wanted = (linear_functions(X) @ coefficients)[:, :, 0]
            strain[:, :, :3] += ((wanted - strain[:, :, :3].sum(axis=2)) / 3)[:, :, None]
        return strain

    def _plain_strain(self, u: Array, X: Array) -> Array:
        e = self.space.spread(u)
        out = np.empty((len(self.mesh.cells), len(X), 6))
        for batch in self.space.batches(X, np.ones(len(X))):
            gradient = np.einsum("cqaj,cai->cqij", batch.gradients, e[batch.functions], optimize=True)
            for k, (i, j) in enumerate(_PAIRS):
                out[batch.cells, :, k] = (gradient[..., i, j] + gradient[..., j, i]) / 2
        return out


def twenty_nodes(mesh: Mesh) -> Mesh:
    """The mesh with 20-node cells: straight edges added, or mid-face and centre nodes removed."""
    if mesh.cells.shape[1] == 8:
        return mesh.upgraded(20)
    if mesh.cells.shape[1] == 20 and mesh.midface is None:
        return mesh
    used, cells = np.unique(mesh.cells[:, :20], return_inverse=True)
    number = np.full(len(mesh.points), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    sets = {name: number[nodes][number[nodes] >= 0] for name, nodes in mesh.node_sets.items()}
    return Mesh(mesh.points[used], cells.reshape(-1, 20), mesh.boundaries, mesh.groups, sets)


@compact_repr
@dataclass(frozen=True, eq=False)
class AncfBody(ElasticBody):
    """A linear elastic body of bricks whose nodes carry position and position gradients.

    It can replace an `ElasticBody` in a `Scene`. Contact acts on the trace of a face, twelve functions of its corners'
    positions and gradients: gaps and pressures are integrated over it, with one non-negative multiplier function for
    each corner and each edge, as many as the trace has coordinates along the normal.

    Parameters
    ----------
    mesh : Mesh
        Hexahedra of 8, 20 or 27 nodes, none degenerate. The corners are the element's nodes; the others define the
        edges, from which the initial gradients follow.
    material : Material, or mapping of element set to Material
        Between materials the gradient across the interface is released.
    contact : str or sequence of str
    supports : mapping of boundary name to components or directions, optional
        As for `ElasticBody`; positions and in-face gradients are held, the gradient across the face is not.
    pressure : {'eight'}
        Multiplier basis of a face: functions at corners and edges.
    name : str, optional
    backend : {'auto', 'pardiso', 'rslab', 'superlu'}
    integration : {'auto', 'full', 'selective'}
        Four Gauss points per direction; with 'selective' the divergence in the part with lambda is projected on linear
        functions in each cell. 'auto' is 'selective' for Poisson's ratios above 0.49 (docs/ancf.md).
    condensation : {'auto', 'schur', 'columns', 'operator'}
        As for `ElasticBody`.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    >>> body = fc.AncfBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
    >>> round(float(result.contacts[0].force[2]), 12)
    0.01
    """

    pressures: ClassVar = ("eight",)

    pressure: str = "eight"
    geometry: str = field(default="plain", init=False, repr=False)

    def _checked_mesh(self, names: tuple[str, ...]) -> Mesh:
        check_skin(self.mesh, names)
        check_bricks(self.mesh)
        return twenty_nodes(self.mesh)

    @cached_property
    def model(self) -> AncfModel:
        """The model of bricks, in the body's own axes; the same object in every pose of the body."""
        material = without_law("an AncfBody", self.material)
        model = AncfModel(self.mesh, material, self.supports, self.backend, self.integration)
        model.way = self.condensation
        return model

    def _made_surface(self, facets: IntArray, name: str) -> FacetSurface:
        planes = symmetry_planes(self.mesh, self.supports)
        return FacetSurface(self.model.mesh.points, facets, name, mortar_on_quad8=True, planes=planes)

    @property
    def functions_per_cell(self) -> int:
        """Positions and gradients of eight nodes."""
        return 32

    def _trace(self, projection: Projection, directions: Array) -> sp.csr_matrix:
        """Rows (n, n_dofs) for the displacement at closest points along directions (n, 3), including gradients."""
        assert projection.facet is not None
        assert projection.local is not None
        faces = self.mesh.faces(projection.surface)[projection.facet]
        return components_along(self.model.space.face_rows(faces, projection.local), directions)

    def _divided(self, marked: Mapping[str, IntArray], cells: IntArray | None = None) -> Self:
        """The body as it is: bricks with hanging nodes would need ties of gradients."""
        return self

    def describe(self) -> str:
        """One-line description of the model."""
        return self._described(f"{len(self.mesh.cells)} bricks with gradient coordinates, {self.n_dofs} dofs")
