"""Finite elements of sections: plane strain, plane stress and axisymmetric quadrilaterals of 8 or 9 nodes.

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

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from skfem.quadrature import get_quadrature
from skfem.refdom import RefQuad

from fecontact.common.arrays import Array, IntArray
from fecontact.fem.element_stiffness import with_means
from fecontact.mesh.element.hexahedron import quad_nodes, quad_quadrature, quad_shapes
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
