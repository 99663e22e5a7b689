"""Thermal strains: what a body would do freely when heated, the forces by which it does, and the stresses left.

A change of temperature T strains an isotropic material by a T in all directions without stress, a the coefficient of
linear expansion. With the rest of the strain, stress is D (strain - a T m); the work of D a T m in the strains of the
functions is a load, f = int B^T D m a T (Hughes, The Finite Element Method, 1987, section 2.8, exercise 2.8.1; Boley
and Weiner, Theory of Thermal Stresses, 1960, section 1.12). Temperatures at nodes are interpolated by the functions of
the cells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.material import SYMMETRIC
from fecontact.fem.stiffness import Batch, Cells, batches, nodal_forces


@dataclass(frozen=True, eq=False)
class Heated:
    """Forces of a change of temperature, and the strains that it gives without stress.

    Attributes
    ----------
    forces : (n_dofs,) array
    strain : (n_cells, n_q, 6) array
        At the Gauss points; NaN beyond those of a cell, as in `fem.stress.gauss_strain`.
    across : (n_cells, n_q, 6) array, optional
        Of sections in plane stress that are not isotropic: strains across the plane beside those that nodal
        displacements tell.
    """

    forces: Array
    strain: Array
    across: Array | None = None


def free_strain(elements: Cells, expansion: Array, change: Array, across: Array | None = None) -> Array:
    """Strains (n_cells, n_q, 6) without stress by a change of temperature.

    Parameters
    ----------
    elements : Cells
    expansion : (n_cells, n_q or 1, 6) array
        Strains per change of temperature, shears not doubled.
    change : (n_points,) array
        Of the temperature.
    across : (n_cells,) array, optional
        In plane stress, see `fem.stress.gauss_strain`: the strain yy then is the one that it reads off the others.
    """
    n_q = max(len(group.element.rule()[2]) for group in elements.groups)
    out = np.full((elements.count, n_q, 6), np.nan)
    for group in elements.groups:
        N = group.element.rule()[0]
        out[group.cells, : len(N)] = expansion[group.cells, : len(N)] * (change[group.nodes] @ N.T)[..., None]
    if across is not None:
        out[..., 1] = 2 * across[:, None] * out[..., 0]
    return out


def stress_forces(elements: Cells, stress: Array) -> Array:
    """Nodal forces (n_dofs,) of stresses (n_cells, n_q, 6)."""
    out = np.zeros((len(elements.points), 3))
    for batch in batches(elements):
        own = stress[batch.cells, : len(batch.N)]
        np.add.at(out, batch.nodes, nodal_forces(batch, own[..., SYMMETRIC]))
    return out.ravel()


def expansion_forces(
    elements: Cells, expansion: Array, change: Array, lame: Array, shear: Array, selective: bool = False
) -> Array:
    """Nodal forces (n_dofs,) of a change of temperature (n_points,), integrated as the stiffness is.

    `lame` (n_cells,) is the sum of the stresses of lambda by a unit strain: 3 lambda, in plane stress twice its own.

    Examples
    --------
    A block that is heated pulls on its ends by E a T / (1 - 2 nu) times its section:

    >>> import fecontact as fc
    >>> mesh, one = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), np.ones(1)
    >>> f = expansion_forces(Cells.of(mesh), 1e-3 * one, np.ones(len(mesh.points)), 0 * one, one)
    >>> round(float(f.reshape(-1, 3)[mesh.boundary_nodes("x_max"), 0].sum()), 12)
    0.002
    """
    out = np.zeros((len(elements.points), 3))

    def add(batch: Batch, modulus: Array) -> None:
        pull = (modulus * expansion)[batch.cells, None] * (change[batch.nodes] @ batch.N.T) * batch.dV
        nodal = np.einsum("cq,cqai->cai", pull, batch.gradients)
        if batch.hoop is not None:
            nodal[..., 0] += np.einsum("cq,cqa->ca", pull, batch.hoop)
        np.add.at(out, batch.nodes, nodal)

    for batch in batches(elements):
        add(batch, 2 * shear + (0.0 if selective else 1.0) * lame)
    for batch in batches(elements, reduced=True) if selective else ():
        add(batch, lame)
    return out.ravel()
