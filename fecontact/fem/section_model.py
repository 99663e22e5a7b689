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
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from skfem.quadrature import get_quadrature
from skfem.refdom import RefQuad

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError, MeshError
from fecontact.common.material import Material
from fecontact.fem.coordinates import Coordinates
from fecontact.fem.energy_error import EnergyError, by_material, energy_density, free_points, without_traction
from fecontact.fem.model import NEARLY_INCOMPRESSIBLE, Model, materials_of_cells
from fecontact.fem.rigid import null_space
from fecontact.fem.stiffness import with_means
from fecontact.fem.stress import hooke
from fecontact.fem.support import check_followed
from fecontact.mesh.check import check_size
from fecontact.mesh.element import quad_nodes, quad_quadrature, quad_shapes
from fecontact.mesh.section_mesh import Extent, SectionMesh, jacobian_2d, line_integrals

#: Components of the strain rows, as numbers of `fem.stress.VOIGT`.
_VOIGT = (0, 2, 1, 5, 3, 4)


@dataclass(frozen=True, eq=False)
class Points:
    """Shape functions of all cells of a section at their quadrature points.

    Attributes
    ----------
    N : (n_q, n_nodes) array
    x : (n_cells, n_q, 3) array
    dV : (n_cells, n_q) array
        Volume, over the thickness or the circumference.
    B : (n_cells, n_q, 4, 2 n_nodes) array
        Strain rows xx, zz, yy, 2 xz over the displacements x, z of each node in turn; in torsion also 2 xy, 2 yz,
        over x, z, y.
    """

    N: Array
    x: Array
    dV: Array
    B: Array

    @property
    def volume_change(self) -> Array:
        """Rows d (n_cells, n_q, k n_nodes)."""
        return self.B[:, :, :3].sum(axis=2)


@dataclass(frozen=True, eq=False)
class SectionElement:
    """Elements of a section with its out-of-plane extent.

    Parameters
    ----------
    mesh : SectionMesh
    out_of_plane : Extent
    """

    mesh: SectionMesh
    out_of_plane: Extent

    @cached_property
    def dofs(self) -> IntArray:
        """Degrees of freedom (n_cells, k n_nodes): x, z and in torsion y of each node in turn."""
        cells = self.mesh.cells
        return (3 * cells[:, :, None] + np.array([0, 2, 1])[: self.per_node]).reshape(len(cells), -1)

    @property
    def per_node(self) -> int:
        """Displacements k of a node: two, in torsion three."""
        return 3 if self.out_of_plane.torsion else 2

    def points(self, reduced: bool = False, cells: IntArray | None = None) -> Points:
        """Gauss points of all cells, or some: 3 x 3, or 2 x 2 for the volume of nearly incompressible elements."""
        X, W = gauss(reduced)
        N, dN = quad_shapes(self.mesh.cells.shape[1], X)
        nodes = self.mesh.points[self.mesh.cells if cells is None else self.mesh.cells[cells]]
        inverse, det = jacobian_2d(nodes, dN)
        gradient = np.einsum("qaj,cqji->cqai", dN, inverse, optimize=True)
        x = N @ nodes
        k = self.per_node
        B = np.zeros((*x.shape[:2], 2 * k, k * N.shape[1]))
        B[:, :, 0, 0::k] = B[:, :, 3, 1::k] = gradient[..., 0]
        B[:, :, 1, 1::k] = B[:, :, 3, 0::k] = gradient[..., 1]
        if self.out_of_plane.revolved:
            B[:, :, 2, 0::k] = N / x[..., :1]
        if self.out_of_plane.torsion:
            B[:, :, 4, 2::k] = gradient[..., 0] - N / x[..., :1]
            B[:, :, 5, 2::k] = gradient[..., 1]
        return Points(N, x, det * W * self.out_of_plane(x), B)

    def stiffness(self, lame: Array, shear: Array, selective: bool) -> sp.csr_matrix:
        """Upper triangle (3 n_points, 3 n_points) of the stiffness; without torsion the rows of y are empty.

        Parameters
        ----------
        lame, shear : (n_cells,) arrays
            Lame constants of each cell; in plane stress the first is 2 lambda mu / (lambda + 2 mu).
        selective : bool
            Whether the volumetric part is integrated at reduced points.
        """
        full = self.points()
        n_cells, n_q, n_strains, width = full.B.shape
        factors = np.array([2.0, 2.0, 2.0, 1.0, 1.0, 1.0])[:n_strains, None]
        weighted = full.B * (full.dV * shear[:, None])[:, :, None, None] * factors
        flat = (n_cells, n_strains * n_q, width)
        K = full.B.reshape(flat).swapaxes(1, 2) @ weighted.reshape(flat)
        d, dV = self._reduced(full) if selective else (full.volume_change, full.dV)
        K += (d * (dV * lame[:, None])[:, :, None]).swapaxes(1, 2) @ d
        rows = np.repeat(self.dofs, width, axis=1).ravel()
        columns = np.tile(self.dofs, (1, width)).ravel()
        upper = rows <= columns
        shape = (3 * len(self.mesh.points),) * 2
        matrix = sp.coo_matrix((K.ravel()[upper], (rows[upper], columns[upper])), shape=shape).tocsr()
        matrix.sort_indices()
        return matrix

    def _reduced(self, full: Points, cells: IntArray | None = None) -> tuple[Array, Array]:
        """Rows of the volume change and volumes at the reduced points of all cells, or some; see `with_means`."""
        reduced = self.points(True, cells)
        return with_means(full.volume_change, full.dV, reduced.volume_change, reduced.dV)

    def strain(
        self, u: Array, selective: bool, across: Array | None, cells: IntArray | None = None
    ) -> tuple[Array, Array]:
        """Strains at the Gauss points of all cells, or some.

        Parameters
        ----------
        u : (3 n_points,) array
        selective : bool
            Whether the volume change is extrapolated from the reduced points by bilinear functions.
        across : (n_cells,) array or None
            In plane stress: -lambda / (lambda + 2 mu), the ratio of the strain yy to xx + zz.
        cells : (n,) int array, optional

        Returns
        -------
        strain : (n_cells, n_q, 6) array
            In the order of `fem.stress.VOIGT`, shears not doubled.
        points : (n_cells, n_q, 3) array
        """
        full, local = self.points(cells=cells), u[self.dofs if cells is None else self.dofs[cells]]
        rows = np.einsum("cqsj,cj->cqs", full.B, local, optimize=True)
        if selective:
            change = np.einsum("cqj,cj->cq", self._reduced(full, cells)[0], local)
            carry = quad_shapes(4, gauss()[0])[0] @ np.linalg.inv(quad_shapes(4, gauss(reduced=True)[0])[0])
            rows[..., :3] += ((change @ carry.T - rows[..., :3].sum(axis=2)) / 3)[..., None]
        if across is not None:
            rows[..., 2] = (across if cells is None else across[cells])[:, None] * (rows[..., 0] + rows[..., 1])
        strain = np.zeros((*rows.shape[:2], 6))
        count = rows.shape[2]
        strain[..., _VOIGT[:count]] = rows * np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.5])[:count]
        return strain, full.x

    def to_nodes(self, values: Array, among: IntArray | None = None) -> Array:
        """Gauss-point values (n_cells, n_q, k), fitted bilinearly, averaged at the nodes: (n_points, k).

        Over all cells or some; nodes without such a cell get NaN.
        """
        cells, values = (self.mesh.cells, values) if among is None else (self.mesh.cells[among], values[among])
        fit = quad_shapes(4, quad_nodes(cells.shape[1]))[0] @ np.linalg.pinv(quad_shapes(4, gauss()[0])[0])
        total = np.zeros((len(self.mesh.points), values.shape[2]))
        np.add.at(total, cells, np.einsum("nq,cqk->cnk", fit, values))
        count = np.bincount(cells.ravel(), minlength=len(total))[:, None]
        return np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0)

    def body_force(self, field: Callable[[Array], Array], density: Array) -> Array:
        """Nodal forces (3 n_points,) of a force per mass ``field(points (n, 3)) -> (n, 3)``."""
        p = self.points()
        b = field(p.x.reshape(-1, 3)).reshape(p.x.shape)
        f = np.zeros((len(self.mesh.points), 3))
        np.add.at(f, self.mesh.cells, np.einsum("qa,cqi,cq->cai", p.N, b, p.dV * density[:, None], optimize=True))
        return (f * self._moving).ravel()

    @property
    def _moving(self) -> Array:
        """One for the components in which nodes move, else zero (3,)."""
        return np.array([1.0, float(self.out_of_plane.torsion), 1.0])

    def mass_and_centre(self, density: Array) -> tuple[float, Array]:
        """Mass and its centre (3,), on the axis of a body of revolution."""
        p = self.points()
        dm = p.dV * density[:, None]
        return float(dm.sum()), self.out_of_plane.mean(np.einsum("cq,cqi->i", dm, p.x) / dm.sum())

    def traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Nodal forces (3 n_points,) of ``field(points (n, 3), outward normals (n, 3)) -> (n, 3)`` on a boundary."""
        sides = self.mesh.face_nodes(self.mesh.faces(name))
        N, x, ds = line_integrals(self.mesh.points, sides)
        length = np.linalg.norm(ds, axis=2)
        t = field(x.reshape(-1, 3), (ds / length[..., None]).reshape(-1, 3)).reshape(x.shape)
        f = np.zeros((len(self.mesh.points), 3))
        np.add.at(f, sides, np.einsum("qa,fqi,fq->fai", N, t, length * self.out_of_plane(x)))
        return (f * self._moving).ravel()


def gauss(reduced: bool = False) -> tuple[Array, Array]:
    """Gauss points (n_q, 2) and weights (n_q,): 3 x 3, or 2 x 2."""
    if not reduced:
        return quad_quadrature()
    X, W = get_quadrature(RefQuad, 3)
    return np.ascontiguousarray(X.T), W


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
                f"x = {mesh.points[:, 0].min():g}.",
                code="negative-radius",
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
                f"found {components!r}.",
                code="support-components",
            )
