"""Error of a finite element solution in the energy norm, from recovered strains.

Strains of elements jump from cell to cell; averaged at the nodes and interpolated they are smoother and nearer to the
true ones, so that the difference estimates the error (Zienkiewicz & Zhu 1987, *A simple error estimator and adaptive
procedure for practical engineering analysis*). Its square, relative to the energy, is the relative error of the
compliance: a body of finite elements is too stiff by that much (Strang & Fix 1973, *An Analysis of the Finite Element
Method*, section 1.7).

Hexahedra of 8 nodes bend too stiffly by shears that vary along them, and several rows of them show no jump of these.
Before their strains are averaged, each cell therefore gets the displacements 1 - X_k^2 inside that lower its energy
most (Wilson, Taylor, Doherty & Ghaboussi 1973, *Incompatible displacement models*; scaled as in Taylor, Beresford &
Wilson 1976, so that a uniform stress calls for none). With them its strains are complete linear functions.

Cells alone through a plate or beside a clamped edge have no neighbour that would show what they miss. Where a surface
is free, its traction is known to be zero: recovered stresses there are made so (Wiberg & Abdulwahab 1993, *Patch
recovery based on superconvergent derivatives and equilibrium*).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.material import SYMMETRIC
from fecontact.fem.element_stiffness import determinant_3x3, inverse_3x3, jacobians
from fecontact.fem.stiffness import Cells, SolidElement
from fecontact.fem.stress import DOUBLED, components, gauss_strain, hooke, hooke_inverse, stress_of, to_nodes
from fecontact.mesh.element import hex_shapes
from fecontact.mesh.facets import places_among
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import SectionMesh

#: Materials that are averaged apart from each other, since strains jump between them; more are taken for one.
MAX_MATERIALS = 12
#: Share of the squared normals of faces at a point below which they lie in a plane, or are one.
FLAT = 0.15
#: A regular hexahedron of 8 nodes.
HEXAHEDRON = SolidElement(8, tuple(range(8)), ())


@compact_repr
@dataclass(frozen=True, eq=False)
class EnergyError:
    """Squared energy norms in some cells.

    Attributes
    ----------
    cells : (n,) int array
    error : (n,) array
        Of the difference between recovered and found strains; of two fields, the product of their differences.
    energy : (n,) array
        Of the found strains.
    largest : float
        Largest component of the found strains.
    """

    cells: IntArray
    error: Array
    energy: Array
    largest: float = 0.0


#: Of a body without elements.
NO_CELLS = EnergyError(np.zeros(0, np.int64), np.zeros(0), np.zeros(0))


def energy_error(
    mesh: Mesh | SectionMesh | Cells,
    u: Array,
    lame: Array,
    shear: Array,
    cells: IntArray,
    selective: bool = False,
    other: Array | None = None,
    free: tuple[IntArray, Array] | None = None,
    across: Array | None = None,
    held: bool = False,
    moduli: Array | None = None,
) -> EnergyError:
    """Error of displacements by their recovered strains.

    Parameters
    ----------
    mesh : Mesh, SectionMesh or Cells
    u : (n_points, 3) array
        Or strains (n_cells, n_q, 6) at the Gauss points.
    lame, shear : (n_cells,) arrays
        Lame constants.
    cells : (n,) int array
        Those that are looked at.
    selective : bool
        See `fem.stress.gauss_strain`.
    other : (n_points, 3) array, optional
        Second field, whose error is multiplied with that of the first.
    free : (points (n,), projections (n, 3, 3)), optional
        Points of the skin without traction, see `free_points`.
    across : (n_cells,) array, optional
        See `fem.stress.gauss_strain`.
    held : bool
        See `without_traction`.
    moduli : (n_cells, n_q or 1, 6, 6) array, optional
        In place of Lame constants, see `fem.stiffness.moduli_stiffness`.

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
    every = Cells.of(mesh)
    error, energy = np.zeros(every.count), np.zeros(every.count)
    largest = 0.0
    for part in by_material(lame, shear, cells, moduli):
        some, yy = every.some(part), None if across is None else across[part]
        own_moduli = lame[part], shear[part], None if moduli is None else moduli[part]
        fields = [each for each in (u, other) if each is not None]
        strains = [f[part] if f.ndim == 3 else gauss_strain(some, f, selective, yy)[0] for f in fields]
        largest = max(largest, float(np.nanmax(np.abs(strains[0]))))
        smooth = [to_nodes(some, _completed(some, e, *own_moduli), complete=True) for e in strains]
        for each, (skin, along) in product(smooth, [] if free is None else [free]):
            there = None if moduli is None else _at_nodes(some, moduli[part], strains[0].shape[1])[skin]
            each[skin] = without_traction(each[skin], along, lame[part[0]], shear[part[0]], held, there)
        for group in some.groups:
            N, dV = group.element.rule()[0], group.element.volumes(some.points[group.nodes])
            own = [e[group.cells, : len(N)] for e in strains]
            missed = [N @ s[group.nodes] - e for s, e in zip(smooth, own, strict=True)]
            at = part[group.cells]
            by = lame[at, None], shear[at, None]
            C = None if moduli is None else moduli[at, : len(N)]
            error[at] = (dV * energy_density(missed[0], *by, missed[-1], C)).sum(axis=1)
            energy[at] = (dV * energy_density(own[0], *by, moduli=C)).sum(axis=1)
    return EnergyError(cells, error[cells], energy[cells], largest)


def free_points(faces: IntArray, normals: Array, free: Mask) -> tuple[IntArray, Array]:
    """Free points (n,) of faces, and projections (n, 3, 3) onto what is tangential to all faces at a point.

    Parameters
    ----------
    faces : (n_faces, k) int array
        Their points.
    normals : (n_faces, 3) array
        Of any length.
    free : (n_points,) bool array
    """
    unit = normals / np.linalg.norm(normals, axis=1)[:, None]
    skin = np.unique(faces)
    skin = skin[free[skin]]
    place = places_among(skin, len(free))
    at, normal = place[faces].ravel(), np.repeat(unit, faces.shape[1], axis=0)
    products = np.zeros((len(skin), 3, 3))
    np.add.at(products, at[at >= 0], (normal[:, :, None] * normal[:, None, :])[at >= 0])
    size, axes = np.linalg.eigh(products)
    tangential = (size < FLAT * size[:, -1:]).astype(float)
    return skin, np.einsum("nik,nk,njk->nij", axes, tangential, axes)


def _at_nodes(some: Cells, moduli: Array, n_q: int) -> Array:
    """Mean moduli (n_points, 6, 6) at the nodes."""
    flat = np.broadcast_to(moduli, (len(moduli), n_q, 6, 6)).reshape(len(moduli), n_q, 36)
    return to_nodes(some, flat).reshape(-1, 6, 6)


def without_traction(
    strain: Array, along: Array, lame: float, shear: float, held: bool = False, moduli: Array | None = None
) -> Array:
    """Strains (n, 6) whose stresses are those given but for the tractions across projections (n, 3, 3).

    With `held` the strain yy, out of a section, stays as it is. `moduli` (n, 6, 6) take the place of Lame constants; at
    points of no cell they are zero, and strains stay as they are.
    """
    if moduli is not None:
        there = moduli.any(axis=(1, 2))
        out, C, own = strain.copy(), moduli[there], np.delete(np.arange(6), [1] if held else [])
        before = (C @ (DOUBLED * strain[there])[..., None])[..., 0]
        change = components(along[there] @ before[:, SYMMETRIC] @ along[there]) - before
        solved = np.linalg.solve(C[:, own[:, None], own], change[:, own, None])[..., 0]
        out[np.ix_(there, own)] += solved / DOUBLED[own]
        return out
    stress = components(along @ hooke(strain, np.array(lame), np.array(shear))[:, SYMMETRIC] @ along)
    nu = lame / (2 * (lame + shear))
    if held:
        stress[:, 1] = 2 * shear * (1 + nu) * strain[:, 1] + nu * (stress[:, 0] + stress[:, 2])
    return hooke_inverse(stress, np.array(lame), np.array(shear))


def _completed(every: Cells, strain: Array, lame: Array, shear: Array, moduli: Array | None = None) -> Array:
    """Strains (n_cells, n_q, 6), those of 8-node hexahedra with the displacements inside that lower the energy most.

    These are a_k (1 - X_k^2) / 2 for each direction k, X from -1 to 1, with gradients c_k g_k: g_k is that of X_k in
    the middle of the cell, and c_k = -X_k det J(0) / det J. Coupling of different k, by the skewness of a cell, is left
    out, so that a_k solves (lambda + mu) g (g . a) + mu |g|^2 a = -sum_q dV c_k sigma g / sum_q dV c_k^2, or with other
    moduli C_ipjq g_p g_q in place of the matrix on the left (at the first point).
    """
    out = strain
    for group in every.groups:
        if group.element != HEXAHEDRON:
            continue
        out = out.copy() if out is strain else out
        _, dN, W = HEXAHEDRON.rule()
        x, cells = every.points[group.nodes], group.cells
        det = determinant_3x3(jacobians(x, dN))
        inverse, middle = inverse_3x3(jacobians(x, hex_shapes(8, np.full((1, 3), 0.5))[1])[:, 0])
        g, c = inverse / 2, (1 - 2 * HEXAHEDRON.points) * (middle[:, None] / det)[..., None]
        C = None if moduli is None else moduli[cells, : len(W)]
        stress = stress_of(strain[cells, : len(W)], lame[cells], shear[cells], C)
        moments = (np.swapaxes(c * (det * W)[..., None], 1, 2) @ stress)[..., SYMMETRIC]
        pull = (moments @ g[..., None])[..., 0] / (c**2 * (det * W)[..., None]).sum(axis=1)[..., None]
        square = (g**2).sum(axis=2, keepdims=True)
        ratio = ((lame + shear) / (lame + 2 * shear))[cells, None, None]
        a = (ratio * g * (g * pull).sum(axis=2, keepdims=True) / square - pull) / (shear[cells, None, None] * square)
        if C is not None:
            whole = C[:, 0][:, SYMMETRIC][..., SYMMETRIC]
            a = -np.linalg.solve(np.einsum("cipjq,ckp,ckq->ckij", whole, g, g), pull[..., None])[..., 0]
        slopes = components((a[..., :, None] * g[..., None, :] + a[..., None, :] * g[..., :, None]) / 2)
        out[cells, : len(W)] += c @ slopes
    return out


def by_material(lame: Array, shear: Array, cells: IntArray, moduli: Array | None = None) -> list[IntArray]:
    """Cells (n,) parted by their Lame constants (n_cells,), or moduli; nothing of none."""
    if not len(cells):
        return []
    constants = np.stack([lame, shear], axis=1) if moduli is None else moduli[:, 0].reshape(-1, 36)
    if (constants == constants[0]).all():
        return [cells]
    kinds, kind = np.unique(constants[cells], axis=0, return_inverse=True)
    if len(kinds) > MAX_MATERIALS:
        return [cells]
    return [cells[kind.ravel() == k] for k in range(len(kinds))]


def energy_density(
    strain: Array, lame: Array, shear: Array, other: Array | None = None, moduli: Array | None = None
) -> Array:
    """Twice the energy (...) of strains (..., 6), or their product with others.

    Components are in the order of `common.material.VOIGT`, shears not doubled.
    """
    second = strain if other is None else other
    if moduli is not None:
        return np.asarray(((moduli @ (DOUBLED * strain)[..., None])[..., 0] * DOUBLED * second).sum(axis=-1))
    both = strain * second
    product = both[..., :3].sum(axis=-1) + 2 * both[..., 3:].sum(axis=-1)
    return np.asarray(lame * strain[..., :3].sum(axis=-1) * second[..., :3].sum(axis=-1) + 2 * shear * product)
