"""Members of bodies with windows that their meshes answer: loads, rigid motions, size, report."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.inner_fields import InnerFields
from fecontact.bodies.local.pressed import BelowWindows
from fecontact.bodies.local.remainder import Remainder
from fecontact.bodies.outside import Outside
from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array
from fecontact.fem.energy_error import NO_CELLS, EnergyError
from fecontact.mesh.mesh import Mesh


class OnMesh(Body, ABC):
    """A body whose displacements are those of the cells of its windows, then those of the nodes of its mesh."""

    body: ElasticBody
    name: str

    @property
    @abstractmethod
    def n_cells(self) -> int:
        """Number of modelled cells."""

    @abstractmethod
    def loaded_windows(self, rows: sp.csr_matrix, forces: Array) -> Sequence[tuple[Remainder, Array]]:
        """Its windows, and the pressures (nx, ny) on them by forces along rows."""

    @property
    def mesh(self) -> Mesh:
        """The mesh of its elastic body."""
        return self.body.mesh

    @property
    def n_dofs(self) -> int:
        """Three for each cell, then three for each node of the mesh."""
        return 3 * self.n_cells + self.body.n_dofs

    @property
    def notes(self) -> tuple[str, ...]:
        """Corrections made when its mesh was read."""
        return self.body.notes

    @property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        return self.body.size

    @property
    def reference_point(self) -> Array:
        """Centre of mass (of volume where no density is given), in the body's axes."""
        return self.body.reference_point

    @property
    def contact_modulus(self) -> float:
        """E / (1 - nu^2) of the softest material."""
        return self.body.contact_modulus

    @property
    def matrix_free(self) -> bool:
        """Its compliance is applied by Fourier transforms."""
        return True

    @property
    def farthest(self) -> float:
        """Largest coordinate of its mesh."""
        return self.body.farthest

    @property
    def free_motions(self) -> Array:
        """Rigid motions (6, k) that the supports do not resist."""
        return self.body.free_motions

    @cached_property
    def weighted_modes(self) -> Array:
        """Nodal forces (n_dofs, 6) of unit accelerations in the rigid motions about the reference point: M R."""
        return self.of_mesh(self.body.weighted_modes)

    def of_mesh(self, values: Array) -> Array:
        """Values (n_dofs, ...) of the mesh's (body.n_dofs, ...), zero at the cells."""
        return np.concatenate([np.zeros((3 * self.n_cells, *values.shape[1:])), values])

    def attachment(self, point: Array, direction: Array) -> sp.csr_matrix:
        """One row (1, n_dofs) for the displacement at a point along a direction, see `ElasticBody.attachment`."""
        row = self.body.attachment(point, direction)
        return sp.csr_matrix(sp.hstack([sp.csr_matrix((1, 3 * self.n_cells)), row]))

    def boundary_force(self, name: str, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a resultant (3,) in its axes, as a uniform traction on a boundary."""
        return self.of_mesh(self.body.boundary_force(name, force))

    def boundary_traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of ``field(points, outward normals) -> (n, 3)``, all in its axes."""
        return self.of_mesh(self.body.boundary_traction(name, field))

    def over_boundary(self, name: str, values: Array) -> Callable[[Array], Array]:
        """Function of points (n, 3) on a boundary that interpolates values at its nodes."""
        return self.body.over_boundary(name, values)

    def count_nodes(self, name: str) -> int:
        """Number of nodes of a boundary."""
        return self.body.count_nodes(name)

    def point_force(self, point: Array, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a force (3,) at a point (3,), both in its axes."""
        return self.of_mesh(self.body.point_force(point, force))

    def body_force(self, gravity: Array) -> Array:
        """Nodal forces (n_dofs,) of gravity (3,) in its axes."""
        return self.of_mesh(self.body.body_force(gravity))

    def on_mesh(self, loads: Array) -> Array:
        """Loads (body.n_dofs,) on the mesh; the cells carry contact forces only."""
        return loads[3 * self.n_cells :]

    def inner_fields(self, displacement: Array, rows: sp.csr_matrix, forces: Array) -> InnerFields:
        """Fields inside: those of half-spaces under the pressures on the windows, and of the elements beside them."""
        beside = BelowWindows(self.loaded_windows(rows, forces))
        u = self.on_mesh(displacement) - beside.displacement(self.mesh.points).ravel()
        return InnerFields(self.body.model, u, beside)

    def energy_error(self, displacement: Array, points: Array, reach: float) -> EnergyError:
        """None: its mesh carries a smooth field only."""
        return NO_CELLS

    def outside(self, displacement: Array) -> Outside:
        """Its outer surface, displaced by (n_dofs,)."""
        return self.body.outside(self.on_mesh(displacement))

    def at_points(self, displacement: Array) -> Array:
        """Displacements (n_points, 3) of its mesh's points by generalised ones (n_dofs,)."""
        return self.body.at_points(self.on_mesh(displacement))

    def size_lines(self, twin: str = "") -> list[str]:
        """Report lines on the size that the model represents."""
        return self.body.size_lines(twin)
