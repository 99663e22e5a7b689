"""Displacements and stresses inside a body: of its elements and, below the window of a local body, beside them.

Cells in which points lie, and fields there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.fem.expansion import Heated
from fecontact.fem.model import Model
from fecontact.fem.stress import hooke, to_nodes
from fecontact.mesh.element import element_basis
from fecontact.mesh.mesh import CellGroup, Mesh

CANDIDATES = 40
"""Cells with the nearest centres, relative to their size, in which a point is looked for."""

MAX_ITERATIONS, STEP_TOLERANCE = 30, 1e-12
"""Steps of Newton's method in a cell, and the step in reference coordinates that ends them."""

OUTSIDE = 0.05
"""Distance from the nearest cell, relative to its size, within which a point belongs to it: faces are not exact."""


def interpolation(mesh: Mesh, points: Array) -> tuple[sp.csr_matrix, Mask]:
    """Weights of a mesh's nodes at points, by the shape functions of the cells in which they lie.

    Parameters
    ----------
    mesh : Mesh
    points : (n, 3) array

    Returns
    -------
    weights : (n, n_points) csr_matrix
        Of a point beside all cells those of the nearest place of a cell.
    found : (n,) mask
        Points in a cell, or nearer to one than `OUTSIDE` of its size.

    Examples
    --------
    >>> from fecontact.mesh.shapes import block
    >>> mesh = block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> weights, found = interpolation(mesh, np.array([[0.1, 0.2, 0.9], [0.1, 0.2, 2.0]]))
    >>> (weights @ mesh.points)[0].round(12).tolist(), found.tolist()
    ([0.1, 0.2, 0.9], [True, False])
    """
    n = len(points)
    best = np.full(n, np.inf)
    out = sp.csr_matrix((n, len(mesh.points)))
    for group in mesh.cell_groups:
        nodes = mesh.points[group.nodes]
        low, high = nodes.min(axis=1), nodes.max(axis=1)
        centres, sizes = nodes.mean(axis=1), np.linalg.norm(high - low, axis=1)
        count = min(CANDIDATES, len(centres))
        near = cKDTree(centres).query(points, count)[1].reshape(n, count)
        # the likeliest first
        order = np.argsort(np.linalg.norm(points[:, None] - centres[near], axis=2) / sizes[near], axis=1)
        near = np.take_along_axis(near, order, axis=1)
        for column in near.T:
            beside = np.maximum(low[column] - points, points - high[column]).max(axis=1)
            todo = np.flatnonzero((best > STEP_TOLERANCE) & (beside <= OUTSIDE * sizes[column]))
            cells = column[todo]
            N, away = _nearest(mesh, group, cells, points[todo])
            better = away / sizes[cells] < best[todo]
            best[todo[better]] = (away / sizes[cells])[better]
            own = group.nodes[cells[better]]
            rows = np.repeat(todo[better], own.shape[1])
            part = sp.csr_matrix((N[better].ravel(), (rows, own.ravel())), shape=out.shape)
            kept = np.ones(n)
            kept[todo[better]] = 0.0
            out = sp.diags_array(kept) @ out + part
    return sp.csr_matrix(out), best <= OUTSIDE


def _nearest(mesh: Mesh, group: CellGroup, cells: IntArray, points: Array) -> tuple[Array, Array]:
    """Shape functions (n, k) of one cell of a group for each point, and its distance (n,) from the point.

    Newton's method for the reference coordinates, held within the cell.
    """
    nodes = mesh.points[group.nodes[cells]]
    X = np.full(points.shape, 0.5)
    for _ in range(MAX_ITERATIONS):
        N, dN = element_basis(mesh.cells.shape[1], group.pattern, group.midfaces, X)
        off = points - (N[:, None] @ nodes)[:, 0]
        # a collapsed edge has no coordinate along itself
        step = (np.linalg.pinv(np.swapaxes(nodes, 1, 2) @ dN) @ off[..., None])[..., 0]
        after = np.clip(X + step, 0.0, 1.0)
        moved = np.abs(after - X).max(initial=0.0)
        X = after
        if moved < STEP_TOLERANCE:
            break
    N = element_basis(mesh.cells.shape[1], group.pattern, group.midfaces, X)[0]
    return N, np.linalg.norm(points - (N[:, None] @ nodes)[:, 0], axis=1)


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
        if self.heated is not None and self.heated.across is not None:
            strain += to_nodes(self.model.elements, self.heated.across)
        elif self.heated is not None and self.model.across is not None:
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
