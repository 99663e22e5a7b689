"""Error of a finite element solution in the energy norm, from recovered strains.

Strains of elements jump from cell to cell; averaged at the nodes and interpolated they are smoother and nearer to the
true ones, so that the difference estimates the error (Zienkiewicz & Zhu 1987, *A simple error estimator and adaptive
procedure for practical engineering analysis*). Its square, relative to the energy, is the relative error of the
compliance: a body of finite elements is too stiff by that much (Strang & Fix 1973, *An Analysis of the Finite Element
Method*, section 1.7).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.one_line import one_line
from fecontact.fem.element_stiffness import determinant_3x3, jacobians
from fecontact.fem.stress import gauss_strain, to_nodes
from fecontact.mesh.element.quadrature import element_quadrature, quadrature_basis
from fecontact.mesh.mesh import Mesh

#: Materials that are averaged apart from each other, since strains jump between them; more are taken for one.
MOST_MATERIALS = 12


@one_line
@dataclass(frozen=True, eq=False)
class EnergyError:
    """Squared energy norms in some cells.

    Attributes
    ----------
    cells : (n,) int array
    error : (n,) array
        Of the difference between recovered and found strains.
    energy : (n,) array
        Of the found strains.
    """

    cells: IntArray
    error: Array
    energy: Array


#: Of a body without elements.
NO_CELLS = EnergyError(np.zeros(0, np.int64), np.zeros(0), np.zeros(0))


def energy_error(
    mesh: Mesh, u: Array, lame: Array, shear: Array, cells: IntArray, selective: bool = False
) -> EnergyError:
    """Error of displacements by their recovered strains.

    Parameters
    ----------
    mesh : Mesh
    u : (n_points, 3) array
    lame, shear : (n_cells,) arrays
        Lame constants.
    cells : (n,) int array
        Those that are looked at.
    selective : bool
        See `fem.stress.gauss_strain`.

    Examples
    --------
    A uniform strain is recovered as it is:

    >>> from fecontact import shapes
    >>> mesh = shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> one = np.ones(8)
    >>> found = energy_error(mesh, mesh.points * [0.1, 0.0, 0.0], 0 * one, one, np.arange(8))
    >>> bool(found.error.max() < 1e-12), round(float(found.energy.sum()), 12)
    (True, 0.02)
    """
    error, energy = np.zeros(len(mesh.cells)), np.zeros(len(mesh.cells))
    for part in by_material(lame, shear, cells):
        midface = None if mesh.midface is None else mesh.midface[part]
        some = replace(
            mesh,
            cells=mesh.cells[part],
            boundaries={},
            groups={},
            node_sets={},
            midface=midface,
            hanging=None,
            file_elements=None,
        )
        strain, _ = gauss_strain(some, u, selective)
        smooth = to_nodes(some, strain)
        for group in some.cell_groups:
            _, W = element_quadrature(some.cells.shape[1], group.pattern, group.midfaces)
            N, dN = quadrature_basis(some.cells.shape[1], group.pattern, group.midfaces)
            dV = determinant_3x3(jacobians(some.points[group.nodes], dN)) * W
            own = strain[group.cells, : len(W)]
            at = part[group.cells]
            moduli = lame[at, None], shear[at, None]
            error[at] = (dV * energy_density(N @ smooth[group.nodes] - own, *moduli)).sum(axis=1)
            energy[at] = (dV * energy_density(own, *moduli)).sum(axis=1)
    return EnergyError(cells, error[cells], energy[cells])


def by_material(lame: Array, shear: Array, cells: IntArray) -> list[IntArray]:
    """Cells (n,) parted by their Lame constants (n_cells,)."""
    kinds, kind = np.unique(np.stack([lame, shear], axis=1)[cells], axis=0, return_inverse=True)
    if len(kinds) > MOST_MATERIALS:
        return [cells]
    return [cells[kind.ravel() == k] for k in range(len(kinds))]


def energy_density(strain: Array, lame: Array, shear: Array) -> Array:
    """Twice the energy (...) of strains (..., 6) in the order of `fem.stress.VOIGT`, shears not doubled."""
    square = (strain[..., :3] ** 2).sum(axis=-1) + 2 * (strain[..., 3:] ** 2).sum(axis=-1)
    return np.asarray(lame * strain[..., :3].sum(axis=-1) ** 2 + 2 * shear * square)
