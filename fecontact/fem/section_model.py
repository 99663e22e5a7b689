"""Finite element model of a plane or axisymmetric body: `Model` with section elements, and y held without torsion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError, MeshError
from fecontact.common.material import Material
from fecontact.fem.coordinates import Coordinates
from fecontact.fem.energy_error import EnergyError, by_material, energy_density, free_points, without_traction
from fecontact.fem.model import NEARLY_INCOMPRESSIBLE, Model, materials_of_cells
from fecontact.fem.rigid import null_space
from fecontact.fem.section_element import SectionElement
from fecontact.fem.stress import hooke
from fecontact.fem.support import check_followed
from fecontact.mesh.check import check_size
from fecontact.mesh.section_mesh import Extent, SectionMesh

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
        As for `Model`.
    """

    def __init__(
        self,
        mesh: SectionMesh,
        materials: Material | Mapping[str, Material],
        supports: Mapping[str, str],
        out_of_plane: Extent,
        plane_stress: bool,
        backend: str,
        integration: str,
    ) -> None:
        check_size(mesh.points)
        _check_supports(mesh, supports, "xyz" if out_of_plane.torsion else "xz")
        self.section, self.plane_stress = SectionElement(mesh, out_of_plane), plane_stress
        self.dofs_per_node = self.section.per_node
        self.mesh = mesh  # type: ignore[assignment]
        if out_of_plane.revolved and mesh.points[:, 0].min() < -ON_AXIS * self.size:
            raise MeshError(
                f"A body of revolution lies at x >= 0 (x is the radius); point {np.argmin(mesh.points[:, 0])} has "
                f"x = {mesh.points[:, 0].min():g}."
            )
        self.material_of_cell, self.materials = materials_of_cells(mesh, materials)
        self.supports, self.backend = dict(supports), backend
        self.selective = integration == "selective" or (
            integration == "auto" and not plane_stress and max(m.nu for m in self.materials) > NEARLY_INCOMPRESSIBLE
        )
        check_followed(mesh, supports)
        self.coordinates = Coordinates(ties=mesh.hanging)
        self.held = np.flatnonzero(self.coordinates.of_functions(self._held()))
        self._check_connected()

    @cached_property
    def mass_and_centre(self) -> tuple[float, Array]:
        """Mass and its centre."""
        return self.section.mass_and_centre(self.density)

    @cached_property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions; zero for those that a body of revolution has not."""
        modes = super().rigid_modes
        return modes * np.isin(np.arange(6), self._motions) if self.section.out_of_plane.revolved else modes

    @property
    def _motions(self) -> tuple[int, ...]:
        """Rigid motions: x, z, ry; of a body of revolution z, in torsion also rz."""
        out_of_plane = self.section.out_of_plane
        return (2, 5) if out_of_plane.torsion else (2,) if out_of_plane.revolved else (0, 2, 4)

    def _held(self) -> Mask:
        """Components (n_points, 3) held by supports, those along y without torsion, and on the axis those across it."""
        held = np.zeros((len(self.mesh.points), 3), bool)
        held[:, 1] = not self.section.out_of_plane.torsion
        for name, components in self.supports.items():
            for c in components:
                held[self.mesh.boundary_nodes(name), "xyz".index(str(c))] = True
        if self.section.out_of_plane.revolved:
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

    @cached_property
    def stiffness(self) -> sp.csr_matrix:
        """Upper triangle of the stiffness (n_dofs, n_dofs)."""
        return self.section.stiffness(self.effective_lame, self.shear, self.selective)

    def body_force(self, field: Callable[[Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of a force per mass ``field(points (n, 3)) -> (n, 3)``."""
        return self.section.body_force(field, self.density)

    def traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of ``field(points (n, 3), normals (n, 3)) -> (n, 3)`` on a boundary."""
        return self.section.traction(name, field)

    def gauss_strain(self, u: Array) -> Array:
        """Strains (n_cells, n_q, 6) at the Gauss points."""
        return self.section.strain(u, self.selective, self._across)[0]

    @property
    def _across(self) -> Array | None:
        """Ratio (n_cells,) of the strain yy to xx + zz in plane stress."""
        return -self.lame / (self.lame + 2 * self.shear) if self.plane_stress else None

    def energy_error(
        self, u: Array, cells: IntArray, other: Array | None = None, free: Mask | None = None
    ) -> EnergyError:
        """Error of displacements (n_dofs,) in cells (n,), or its product with that of others; see `Model`."""
        skin, along = (np.zeros(0, np.int64), np.zeros((0, 3, 3))) if free is None else self._free_skin(free)
        points = self.section.points(cells=cells)
        volume = np.zeros((len(self.mesh.cells), points.dV.shape[1]))
        volume[cells] = points.dV
        strains = []
        for each in (u, other):
            if each is not None:
                strains.append(np.zeros((*volume.shape, 6)))
                strains[-1][cells] = self.section.strain(each, self.selective, self._across, cells)[0]
        error, energy = np.zeros(len(self.mesh.cells)), np.zeros(len(self.mesh.cells))
        for part in by_material(self.lame, self.shear, cells):
            nodes, moduli = self.mesh.cells[part], (self.lame[part, None], self.shear[part, None])
            smooth = [self.section.to_nodes(e, part) for e in strains]
            for each in smooth:
                constants = self.lame[part[0]], self.shear[part[0]], not self.plane_stress
                each[skin] = without_traction(each[skin], along, *constants)
            missed = [points.N @ s[nodes] - e[part] for s, e in zip(smooth, strains, strict=True)]
            error[part] = (volume[part] * energy_density(missed[0], *moduli, missed[-1])).sum(axis=1)
            energy[part] = (volume[part] * energy_density(strains[0][part], *moduli)).sum(axis=1)
        return EnergyError(cells, error[cells], energy[cells], float(np.abs(strains[0]).max(initial=0.0)))

    def _free_skin(self, free: Mask) -> tuple[IntArray, Array]:
        """Points of the outer sides without traction, and projections along these sides; see `free_points`."""
        sides, x = self.mesh.face_nodes(self.mesh.outer), self.mesh.points
        along = x[sides[:, 1]] - x[sides[:, 0]]
        open_points = self.without_supports(free)
        if self.section.out_of_plane.revolved:
            open_points[on_axis(x, self.size)] = False
        return free_points(sides, np.cross(along, [0.0, 1.0, 0.0]), open_points)

    def nodal_strain(self, u: Array) -> Array:
        """Strains (n_points, 6) at the nodes."""
        return self.section.to_nodes(self.gauss_strain(u))

    def nodal_stress(self, u: Array, cells: IntArray | None = None) -> Array:
        """Stresses (n_points, 6) at the nodes, averaged over all cells, or some (NaN at nodes without such a cell)."""
        return self.section.to_nodes(hooke(self.gauss_strain(u), self.lame[:, None], self.shear[:, None]), cells)


def _check_supports(mesh: SectionMesh, supports: Mapping[str, str], known: str) -> None:
    for name, components in supports.items():
        mesh.boundary_nodes(name)
        if not isinstance(components, str) or not components or set(components) - set(known):
            raise InputError(
                f"The support of {name!r} of a section must name components out of {' and '.join(map(repr, known))}; "
                f"found {components!r}."
            )
