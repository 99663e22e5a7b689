"""Finite element model of a plane or axisymmetric body: `Model` with section elements, and y held without torsion.

Finite elements of sections: plane strain, plane stress and axisymmetric quadrilaterals of 8 or 9 nodes.

Displacements have three components per node, of which y is held unless there is torsion, so that surfaces, poses and
condensation are those of bodies in space. The strains are xx, zz, the out-of-plane strain yy (u_x / x in a body of
revolution, zero in plane strain, from zero stress in plane stress) and xz. The stiffness is the sum of a volumetric and
a shearing part, K = int lambda d d^T + mu B^T diag(2, 2, 2, 1) B with d the rows of the volume change, so that the
former can be integrated at reduced points (Hughes, The Finite Element Method, 1987, sections 2.7, 2.12 and 4.4).

In torsion the circumferential displacement u_y adds the shears xy, u_y,x - u_y / x, and yz, u_y,z (Timoshenko and
Goodier, Theory of Elasticity, section 119), which do not depend on the other displacements.

Shape functions and quadrature are scikit-fem's, its `BilinearForm` is not used: for 1600 quadrilaterals of 8 nodes it
takes 0.068 s of processor time against 0.014 s here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.common.anisotropic import DirectedMaterial
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError, MeshError
from fecontact.common.material import Material
from fecontact.fem.coordinates import Coordinates
from fecontact.fem.expansion import Heated
from fecontact.fem.model import AnyMaterial, Model, materials_of_cells
from fecontact.fem.rigid import null_space
from fecontact.fem.stiffness import Batch, Cells, batches, facet_forces, moments_of_volume
from fecontact.fem.stress import DOUBLED, to_nodes
from fecontact.fem.support import check_followed, linked
from fecontact.mesh.check import check_size
from fecontact.mesh.section_mesh import Extent, SectionMesh, line_integrals

#: Components of strains in the order of `_strain_rows`; those in the plane of plane stress, and across it.
STRAINS = np.array([0, 2, 1, 5, 3, 4])
IN_PLANE, ACROSS = np.array([0, 2, 5]), np.array([1, 3, 4])


def section_stiffness(
    cells: Cells, lame: Array, shear: Array, selective: bool, torsion: bool = False, moduli: Array | None = None
) -> sp.csr_matrix:
    """Upper triangle (3 n_points, 3 n_points) of the stiffness; without torsion the rows of y are empty.

    Parameters
    ----------
    cells : Cells
        Of a section, see `fem.stiffness.Cells.of`.
    lame, shear : (n_cells,) arrays
        Lame constants of each cell; in plane stress the first is 2 lambda mu / (lambda + 2 mu).
    selective : bool
        Whether the volumetric part is integrated at reduced points.
    torsion : bool
        Whether nodes move along y, too.
    moduli : (n_cells, n_q or 1, 6, 6) array, optional
        In place of Lame constants.
    """
    (group,) = cells.groups
    per_node = 3 if torsion else 2
    full = next(batches(cells, cells.count))
    B = _strain_rows(full, per_node)
    n_cells, n_q, n_strains, width = B.shape
    flat = (n_cells, n_strains * n_q, width)
    if moduli is None:
        factors = np.array([2.0, 2.0, 2.0, 1.0, 1.0, 1.0])[:n_strains, None]
        weighted = B * (full.dV * shear[:, None])[:, :, None, None] * factors
        K = B.reshape(flat).swapaxes(1, 2) @ weighted.reshape(flat)
        volumetric = next(batches(cells, cells.count, reduced=True)) if selective else full
        d = (_strain_rows(volumetric, per_node) if selective else B)[:, :, :3].sum(axis=2)
        K += (d * (volumetric.dV * lame[:, None])[:, :, None]).swapaxes(1, 2) @ d
    else:
        which = STRAINS[:n_strains]
        weighted = (moduli[..., which[:, None], which] @ B) * full.dV[:, :, None, None]
        K = B.reshape(flat).swapaxes(1, 2) @ weighted.reshape(flat)
    dofs = (3 * group.nodes[:, :, None] + np.array([0, 2, 1])[:per_node]).reshape(n_cells, -1)
    rows = np.repeat(dofs, width, axis=1).ravel()
    columns = np.tile(dofs, (1, width)).ravel()
    upper = rows <= columns
    shape = (3 * len(cells.points),) * 2
    matrix = sp.coo_matrix((K.ravel()[upper], (rows[upper], columns[upper])), shape=shape).tocsr()
    matrix.sort_indices()
    return matrix


def _strain_rows(batch: Batch, per_node: int) -> Array:
    """Strain rows xx, zz, yy, 2 xz (n_cells, n_q, 4, 2 n_nodes) over the displacements x, z of each node in turn.

    In torsion also 2 xy, 2 yz, over x, z, y.
    """
    (n_cells, n_q), k = batch.dV.shape, per_node
    B = np.zeros((n_cells, n_q, 2 * k, k * batch.nodes.shape[1]))
    B[:, :, 0, 0::k] = B[:, :, 3, 1::k] = batch.gradients[..., 0]
    B[:, :, 1, 1::k] = B[:, :, 3, 0::k] = batch.gradients[..., 2]
    if batch.hoop is not None:
        B[:, :, 2, 0::k] = batch.hoop
        if k == 3:
            B[:, :, 4, 2::k] = batch.gradients[..., 0] - batch.hoop
            B[:, :, 5, 2::k] = batch.gradients[..., 2]
    return B


#: Distance from the axis, relative to the size, that counts as on it.
ON_AXIS = 1e-12


def on_axis(points: Array, size: float) -> IntArray:
    """Mask of points (n, 3) of a body of revolution of this size on its axis."""
    return np.flatnonzero(points[:, 0] <= ON_AXIS * size)


class SectionModel(Model):
    """Section, materials and supports; derived quantities are computed on first use.

    Parameters
    ----------
    mesh : SectionMesh
    materials : Material or mapping of element set to Material
    supports : mapping of boundary name to 'x', 'z' or 'xz', in torsion with 'y'
    out_of_plane : Extent
    plane_stress : bool
    backend, integration : str
    conditions : (m, n_dofs) sparse matrix, optional
        As for `Model`.
    """

    def __init__(
        self,
        mesh: SectionMesh,
        materials: AnyMaterial | Mapping[str, AnyMaterial],
        supports: Mapping[str, str],
        out_of_plane: Extent,
        plane_stress: bool,
        backend: str,
        integration: str,
        conditions: sp.csr_matrix | None = None,
    ) -> None:
        check_size(mesh.points)
        mesh._refuse_double("merge_sections", None if conditions is None else np.unique(conditions.indices // 3))
        _check_supports(mesh, supports, "xyz" if out_of_plane.torsion else "xz")
        self.out_of_plane, self.plane_stress, self.across_held = out_of_plane, plane_stress, not plane_stress
        self.dofs_per_node = 3 if out_of_plane.torsion else 2
        self.mesh = mesh  # type: ignore[assignment]
        if out_of_plane.revolved and mesh.points[:, 0].min() < -ON_AXIS * self.size:
            raise MeshError(
                f"A body of revolution lies at x >= 0 (x is the radius); point {np.argmin(mesh.points[:, 0])} has "
                f"x = {mesh.points[:, 0].min():g}.",
                code="negative-radius",
            )
        self.elements = Cells.of(mesh, out_of_plane)
        self.material_of_cell, self.given = materials_of_cells(mesh, materials, (Material, DirectedMaterial))
        self.materials = [m.average for m in self.given]
        if plane_stress and self.is_directed:
            self.across_held = True  # as zero, of moduli that leave no stress across
        elif plane_stress:
            self.across = -self.lame / (self.lame + 2 * self.shear)
        self.supports, self.backend = dict(supports), backend
        self.selective = self._selective(integration, not plane_stress)
        check_followed(mesh, supports)
        coordinates = Coordinates(ties=mesh.hanging)
        held = np.flatnonzero(coordinates.of_functions(self._held()))
        self.coordinates, self.held = linked(coordinates, held, conditions, self.n_dofs)
        self._check_connected(conditions)

    @cached_property
    def mass_and_centre(self) -> tuple[float, Array]:
        """Mass and its centre, on the axis of a body of revolution."""
        mass, centre = moments_of_volume(self.elements, self.density)
        return mass, self.out_of_plane.mean(centre)

    @cached_property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions; zero for those that a body of revolution has not."""
        modes = super().rigid_modes
        return modes * np.isin(np.arange(6), self._motions) if self.out_of_plane.revolved else modes

    @property
    def _motions(self) -> tuple[int, ...]:
        """Rigid motions: x, z, ry; of a body of revolution z, in torsion also rz."""
        return (2, 5) if self.out_of_plane.torsion else (2,) if self.out_of_plane.revolved else (0, 2, 4)

    def _held(self) -> Mask:
        """Components (n_points, 3) held by supports, those along y without torsion, and on the axis those across it."""
        held = np.zeros((len(self.mesh.points), 3), bool)
        held[:, 1] = not self.out_of_plane.torsion
        for name, components in self.supports.items():
            for c in components:
                held[self.mesh.boundary_nodes(name), "xyz".index(str(c))] = True
        if self.out_of_plane.revolved:
            held[on_axis(self.mesh.points, self.size), :2] = True
        return held

    def null_space_of(self, held: IntArray) -> Array:
        """Rigid motions (6, k) that held coordinates do not resist, out of those of the section."""
        others = np.delete(np.eye(6), self._motions, axis=0)
        return null_space(np.concatenate([self.nodal_modes[held], others]), self.size)

    @cached_property
    def effective_lame(self) -> Array:
        """First Lame constant (n_cells,) of the stiffness: that of plane stress, or the material's."""
        return 2 * self.lame * self.shear / (self.lame + 2 * self.shear) if self.plane_stress else self.lame

    @property
    def _lame_sum(self) -> Array:
        return (2 if self.plane_stress else 3) * self.effective_lame

    @cached_property
    def stiffness(self) -> sp.csr_matrix:
        """Upper triangle of the stiffness (n_dofs, n_dofs)."""
        constants = self.effective_lame, self.shear, self.selective, self.out_of_plane.torsion
        return section_stiffness(self.elements, *constants, self.moduli)

    @cached_property
    def moduli(self) -> Array | None:
        """Moduli (n_cells, n_q or 1, 6, 6), see `Model.moduli`; in plane stress those of the stresses in the plane.

        There the strains across are those of zero stress, C_JJ e_J = -C_JI e_I, so that the others have the moduli
        C_II - C_IJ C_JJ^-1 C_JI; they themselves count as zero, with the moduli C_JJ.
        """
        C = self._moduli
        if C is None or not self.plane_stress:
            return C
        out = np.zeros_like(C)
        out[..., ACROSS[:, None], ACROSS] = C[..., ACROSS[:, None], ACROSS]
        out[..., IN_PLANE[:, None], IN_PLANE] = C[..., IN_PLANE[:, None], IN_PLANE] + (
            C[..., IN_PLANE[:, None], ACROSS] @ self._strains_across
        )
        return out

    @property
    def _strains_across(self) -> Array:
        """Strains across the plane of plane stress (n_cells, n_q or 1, 3, 3) by those in it, shears doubled."""
        C = self._moduli
        assert C is not None
        return np.asarray(-np.linalg.solve(C[..., ACROSS[:, None], ACROSS], C[..., ACROSS[:, None], IN_PLANE]))

    def nodal_strain(self, u: Array) -> Array:
        """Strains (n_points, 6) at the nodes."""
        if not (self.plane_stress and self.is_directed):
            return super().nodal_strain(u)
        strain = self.gauss_strain(u)
        strain[..., ACROSS] = self._across_by(strain)
        return to_nodes(self.elements, strain)

    def _across_by(self, strain: Array) -> Array:
        """Strains (n_cells, n_q, 3) across the plane by all (n_cells, n_q, 6), of which those in it count."""
        by = DOUBLED[IN_PLANE] / DOUBLED[ACROSS][:, None] * self._strains_across
        return np.asarray((by @ strain[..., IN_PLANE, None])[..., 0])

    def heated(self, change: Array) -> Heated:
        """Forces and free strains of a change of temperature (n_points,).

        With e - a the strain that has stress, strains across plane stress are e_J = a_J - C_JJ^-1 C_JI (e_I - a_I).
        """
        found = super().heated(change)
        found = replace(found, forces=self._moving(found.forces))
        if not (self.plane_stress and self.is_directed):
            return found
        strain, across = found.strain.copy(), np.zeros(found.strain.shape)
        across[..., ACROSS] = strain[..., ACROSS] - self._across_by(strain)
        strain[..., ACROSS] = 0.0
        return replace(found, strain=strain, across=across)

    def _moving(self, forces: Array) -> Array:
        """Forces (n_dofs,) without those in which nodes do not move."""
        return (forces.reshape(-1, 3) * [1.0, float(self.out_of_plane.torsion), 1.0]).ravel()

    def body_force(self, field: Callable[[Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of a force per mass ``field(points (n, 3)) -> (n, 3)``."""
        return self._moving(super().body_force(field))

    def traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of ``field(points (n, 3), normals (n, 3)) -> (n, 3)`` on a boundary."""
        sides = self.mesh.face_nodes(self.mesh.faces(name))
        N, x, ds = line_integrals(self.mesh.points, sides)
        area = ds * self.out_of_plane(x)[..., None]
        return self._moving(facet_forces(len(self.mesh.points), sides, N[None], x, area, field))

    def _skin(self) -> tuple[IntArray, Array]:
        """Outer sides (n, 3) and their normals."""
        sides, x = self.mesh.face_nodes(self.mesh.outer), self.mesh.points
        return sides, np.cross(x[sides[:, 1]] - x[sides[:, 0]], [0.0, 1.0, 0.0])

    def without_supports(self, points: Mask) -> Mask:
        """Those points (n_points,) that no support holds, nor the axis of a body of revolution."""
        out = super().without_supports(points)
        if self.out_of_plane.revolved:
            out[on_axis(self.mesh.points, self.size)] = False
        return out


def _check_supports(mesh: SectionMesh, supports: Mapping[str, str], known: str) -> None:
    for name, components in supports.items():
        mesh.boundary_nodes(name)
        if not isinstance(components, str) or not components or set(components) - set(known):
            raise InputError(
                f"The support of {name!r} of a section must name components out of {' and '.join(map(repr, known))}; "
                f"found {components!r}.",
                code="support-components",
            )
