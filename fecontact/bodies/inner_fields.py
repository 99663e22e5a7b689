"""Displacements and stresses inside a body: of its elements and, below the window of a local body, beside them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.fem.expansion import Heated
from fecontact.fem.model import Model
from fecontact.fem.stress import hooke, to_nodes
from fecontact.mesh.locate import interpolation

#: Quadrature points of a cell, at most.
MAX_POINTS = 64


class Beside(Protocol):
    """Fields that are added to those of the elements."""

    def displacement(self, points: Array) -> Array:
        """Displacements (n, 3) at points (n, 3)."""

    def strain(self, points: Array) -> Array:
        """Strains (n, 6) at points (n, 3)."""


@dataclass(frozen=True, eq=False)
class InnerFields:
    """Fields inside a body, in its own axes.

    Attributes
    ----------
    model : Model
        Finite element model of the body.
    u : (model.n_dofs,) array
        Displacements that its elements carry.
    beside : Beside, optional
    heated : Heated, optional
        Of a change of temperature.

    Examples
    --------
    >>> import fecontact as fc
    >>> body = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), fc.Material(E=1.0, nu=0.0))
    >>> stretched = 0.01 * body.mesh.points * np.array([1.0, 0.0, 0.0])
    >>> InnerFields(body.model, stretched.ravel()).at(np.array([[0.3, 0.2, 0.6]]))[1][:, 0].round(12).tolist()
    [0.01]
    """

    model: Model
    u: Array
    beside: Beside | None = None
    heated: Heated | None = None

    def stress(self, cells: IntArray | None = None) -> Array:
        """Stress (n_points, 6) at the nodes; of the elements averaged over given cells only, NaN at other nodes."""
        stress = self._of_elements(cells)
        if self.beside is None:
            return stress
        return stress + hooke(self.beside.strain(self.model.mesh.points), *self._moduli(cells))

    def strain(self) -> Array:
        """Strain (n_points, 6) at the nodes."""
        strain = self.model.nodal_strain(self.u)
        if self.heated is not None:
            # across plane stress the elements give the strain of their stress alone
            free = self.heated.strain
            strain[:, 1] += to_nodes(self.model.elements, free[..., :1] - free[..., 1:2])[:, 0]
        return strain if self.beside is None else strain + self.beside.strain(self.model.mesh.points)

    def _of_elements(self, cells: IntArray | None = None) -> Array:
        """Stress (n_points, 6) of the elements at the nodes, without what strains by temperatures would have."""
        stress, model = self.model.nodal_stress(self.u, cells), self.model
        if self.heated is None:
            return stress
        return stress - to_nodes(model.elements, model.stress(self.heated.strain), cells)

    def _moduli(self, cells: IntArray | None = None) -> tuple[Array, Array]:
        """Lame constants (n_points,) at the nodes, averaged as the stresses of the elements are."""
        each = np.stack([self.model.lame, self.model.shear], axis=1)[:, None]
        mean = to_nodes(self.model.mesh, np.broadcast_to(each, (len(each), MAX_POINTS, 2)), cells)
        return mean[:, 0], mean[:, 1]

    def at(self, points: Array) -> tuple[Array, Array, Mask]:
        """Displacement (n, 3) and stress (n, 6) at points (n, 3), and which of these are in the body; NaN at others.

        Nodal fields of the elements are interpolated in the cells. Points are those before a deformation at finite
        strain, which the displacement includes.
        """
        weights, found = interpolation(self.model.mesh_at_rest, points)
        u, stress = np.full((len(points), 3), np.nan), np.full((len(points), 6), np.nan)
        deformation = self.model.mesh.points - self.model.mesh_at_rest.points
        u[found] = weights[found] @ (self.model.at_points(self.u) + deformation)
        stress[found] = weights[found] @ self._of_elements()
        if self.beside is not None:
            lame, shear = self._moduli()
            u[found] += self.beside.displacement(points[found])
            stress[found] += hooke(self.beside.strain(points[found]), weights[found] @ lame, weights[found] @ shear)
        return u, stress, found
