"""Stiffness of isotropic elements in batches, and its assembly into a sparse matrix.

scikit-fem provides shape functions and quadrature; the sums over elements are batched matrix products instead of its
vector-valued `BilinearForm`. That gives the same matrix to rounding and takes 25 to 40 times the processor time for
20-node hexahedra: 216 cells 0.84 s against 0.033 s, 1331 cells 6.3 s against 0.165 s, its `Basis` not counted.

The blocks of pairs of nodes stay whole: the degrees of freedom of a node have the same pattern then, and orderings take
them together. Where zeros were dropped, as sums of sparse matrices do, PARDISO's analysis took twice the time.

Consistent nodal forces of body forces, tractions and pressures are here too.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array, IntArray
from fecontact.common.material import FIRST, SECOND
from fecontact.fem.element_stiffness import (
    determinant_3x3,
    jacobians,
    pair_stiffness,
    physical_gradients,
    upper_pairs,
    with_means,
)
from fecontact.mesh.element import (
    Pattern,
    element_basis,
    element_quadrature,
    hex_shapes,
    linear_shapes,
    node_positions,
    quad_nodes,
    quad_quadrature,
    quad_shapes,
    quadrature_basis,
    reduced_quadrature,
)
from fecontact.mesh.facets import facet_integrals, places_among
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import Extent, SectionMesh, jacobian_2d


def sum_of_blocks(first: IntArray, second: IntArray, blocks: Array, n: int) -> sp.csr_matrix:
    """Add up blocks of pairs of nodes into the upper triangle of a symmetric matrix.

    Parameters
    ----------
    first, second : (n_pairs,) int arrays
        Nodes in any order; the block of a pair the other way round is the transpose.
    blocks : (n_pairs, 9) array
        Rows of the blocks one after the other; diagonal ones are whole.
    n : int
        Number of nodes.

    Returns
    -------
    (3 n, 3 n) csr_matrix
        Sorted indices.

    Examples
    --------
    >>> found = sum_of_blocks(np.array([1, 0]), np.array([0, 0]), np.arange(18.0).reshape(2, 9), 2)
    >>> found.toarray()[:3].astype(int).tolist()
    [[9, 10, 11, 0, 3, 6], [0, 13, 14, 1, 4, 7], [0, 0, 17, 2, 5, 8]]
    """
    keys = np.minimum(first, second) * n + np.maximum(first, second)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    begins = np.ones(len(keys), bool)
    np.not_equal(keys[1:], keys[:-1], out=begins[1:])
    place = np.cumsum(begins) - 1
    # the sums as products with a matrix of ones: those of the blocks as they are, and below them those to transpose
    turned = (first > second)[order]
    count = int(begins.sum())
    pointer = np.concatenate([[0], np.cumsum(np.bincount(place + count * turned, minlength=2 * count))])
    taken = np.concatenate([order[~turned], order[turned]])
    sums = sp.csr_matrix((np.ones(len(keys)), taken, pointer), shape=(2 * count, len(keys))) @ blocks
    straight, other = sums.reshape(2, count, 3, 3)
    straight += other.swapaxes(1, 2)
    rows, columns = np.divmod(keys[begins], n)
    pointer = np.searchsorted(rows, np.arange(n + 1))
    return _upper(sp.bsr_matrix((straight, columns, pointer), shape=(3 * n, 3 * n)).tocsr())


def whole_blocks(K: sp.sparray | sp.spmatrix) -> sp.csr_matrix:
    """An upper triangle (3 n, 3 n) with all entries of its blocks stored, zeros too; sorted indices."""
    K = sp.bsr_matrix(K, blocksize=(3, 3)).tocsr()
    K.sort_indices()
    return _upper(K)


def symmetric_product(K: sp.csr_matrix, u: Array) -> Array:
    """K u (n,) of a symmetric matrix of which the upper triangle is stored.

    Examples
    --------
    >>> symmetric_product(sp.csr_matrix([[2.0, 1.0], [0.0, 3.0]]), np.array([1.0, 10.0])).tolist()
    [12.0, 31.0]
    """
    return np.asarray(K @ u + K.T @ u - K.diagonal() * u)


def _upper(K: sp.csr_matrix) -> sp.csr_matrix:
    """Upper triangle of a matrix with entries below the diagonal in the first block of each row of blocks only."""
    # scipy's triu would sort all again
    kept = np.ones(K.nnz, bool)
    begin = K.indptr[:-1].reshape(-1, 3)
    node = np.flatnonzero(np.diff(K.indptr[::3]))
    for row, k in ((1, 0), (2, 0), (2, 1)):
        place = begin[node, row] + k
        kept[place] = K.indices[place] >= 3 * node + row
    pointer = np.concatenate([[0], np.cumsum(np.add.reduceat(kept, begin[node].ravel(), dtype=np.int64))])
    rows = np.zeros(K.shape[0] + 1, np.int64)
    rows[1:].reshape(-1, 3)[node] = np.diff(pointer).reshape(-1, 3)
    return sp.csr_matrix((K.data[kept], K.indices[kept], np.cumsum(rows)), shape=K.shape)


#: Cells per batch; keeps its working set within a few tens of megabytes.
BATCH = 256
#: Numbers in the element matrices of a batch, which fit in a core's cache with what they are made of.
ENTRIES = 1 << 17


@dataclass(frozen=True, eq=False)
class Batch:
    """Shape functions of some cells at their quadrature points.

    Attributes
    ----------
    cells : (n_cells,) array
    nodes : (n_cells, n_functions) array
    N : (n_q, n_functions) array
    gradients : (n_cells, n_q, n_functions, 3) array
        With respect to physical coordinates.
    dV : (n_cells, n_q) array
        Quadrature weights times volume.
    hoop : (n_cells, n_q, n_functions) array or None
        Of a body of revolution about z, on its section y = 0: N over the radius x.
    """

    cells: IntArray
    nodes: IntArray
    N: Array
    gradients: Array
    dV: Array
    hoop: Array | None = None

    def displacement_gradients(self, u: Array) -> Array:
        """Gradients du_j/dx_i (n_cells, n_q, 3, 3) of displacements (n_points, 3).

        Of a body of revolution y is the circumference: u_x / x at yy and -u_y / x at yx (Timoshenko and Goodier, Theory
        of Elasticity, sections 4 and 119).
        """
        x = u[self.nodes]
        out = np.swapaxes(self.gradients, 2, 3) @ x[:, None]
        if self.hoop is not None:
            around = self.hoop @ x
            out[..., 1, 1] += around[..., 0]
            out[..., 1, 0] -= around[..., 1]
        return out

    def volume_change(self, u: Array) -> Array:
        """Divergence (n_cells, n_q) of displacements (n_points, 3)."""
        x = u[self.nodes]
        change = np.einsum("cqai,cai->cq", self.gradients, x)
        return change if self.hoop is None else change + (self.hoop @ x[..., :1])[..., 0]


@dataclass(frozen=True)
class SolidElement:
    """A hexahedron of 8, 20 or 27 nodes, coalesced by a pattern; arguments as in `mesh.element.element_basis`.

    Its functions at the points of its rules, and fields fitted to values at the points.
    """

    n_nodes: int
    pattern: Pattern
    midfaces: tuple[int, ...]

    @property
    def points(self) -> Array:
        """Quadrature points (n_q, 3)."""
        return element_quadrature(self.n_nodes, self.pattern, self.midfaces)[0]

    def rule(self, reduced: bool = False) -> tuple[Array, Array, Array]:
        """Functions (n_q, n_functions), their gradients (n_q, n_functions, 3) in reference coordinates, weights (n_q,).

        With `reduced` those of the rule one order lower.
        """
        kind = self.n_nodes, self.pattern, self.midfaces
        if not reduced:
            return *quadrature_basis(*kind), element_quadrature(*kind)[1]
        X, W = reduced_quadrature(self.n_nodes)
        return *element_basis(*kind, X), W

    def physical(self, x: Array, rule: tuple[Array, Array, Array]) -> tuple[Array, Array, None]:
        """`gradients`, `dV` and `hoop` of a `Batch` of cells with nodes x (n_cells, n_functions, 3)."""
        return *physical_gradients(x, *rule[1:]), None

    def volumes(self, x: Array) -> Array:
        """Volumes (n_cells, n_q) at the points, without the gradients."""
        _, dN, W = self.rule()
        return determinant_3x3(jacobians(x, dN)) * W

    def fit(self, complete: bool = False) -> Array:
        """Values (n_functions, n_q) at the nodes of a field fitted to values at the points, see `fem.stress.to_nodes`.

        By the functions of the corners; for linear cells constant, unless `complete` in regular hexahedra.
        """
        N, _, W = self.rule()
        if self.n_nodes == 8 and not (complete and self.pattern == tuple(range(8))):
            return np.full((N.shape[1], len(W)), 1 / len(W))
        where = node_positions(self.n_nodes, self.pattern, self.midfaces)
        return linear_shapes(self.pattern, where)[0] @ np.linalg.pinv(linear_shapes(self.pattern, self.points)[0])

    def carry(self) -> Array:
        """Values (n_q, n_reduced) at the points of a trilinear field through values at those of the reduced rule."""
        X = reduced_quadrature(self.n_nodes)[0]
        if len(X) == 1:
            return np.ones((len(self.points), 1))
        return hex_shapes(8, self.points)[0] @ np.linalg.inv(hex_shapes(8, X)[0])


@dataclass(frozen=True)
class Quadrilateral:
    """A quadrilateral of 8 or 9 nodes with its out-of-plane extent, as `SolidElement`."""

    n_nodes: int
    out_of_plane: Extent

    def rule(self, reduced: bool = False) -> tuple[Array, Array, Array]:
        """Functions, gradients, weights: 3 x 3 points, or 2 x 2 for the volume of nearly incompressible elements."""
        X, W = quad_quadrature(3 if reduced else 5)
        return *quad_shapes(self.n_nodes, X), W

    def physical(self, x: Array, rule: tuple[Array, Array, Array]) -> tuple[Array, Array, Array | None]:
        """Gradients, volumes over the thickness or the circumference, and N over the radius."""
        N, dN, W = rule
        inverse, det = jacobian_2d(x, dN)
        gradients = np.zeros((*det.shape, self.n_nodes, 3))
        gradients[..., ::2] = np.einsum("qaj,cqji->cqai", dN, inverse, optimize=True)
        at = N @ x
        hoop = N / at[..., :1] if self.out_of_plane.revolved else None
        return gradients, det * W * self.out_of_plane(at), hoop

    def volumes(self, x: Array) -> Array:
        """Volumes at the points."""
        N, dN, W = self.rule()
        return jacobian_2d(x, dN)[1] * W * self.out_of_plane(N @ x)

    def fit(self, complete: bool = False) -> Array:
        """By bilinear functions."""
        return quad_shapes(4, quad_nodes(self.n_nodes))[0] @ np.linalg.pinv(quad_shapes(4, quad_quadrature()[0])[0])

    def carry(self) -> Array:
        """By bilinear functions."""
        return quad_shapes(4, quad_quadrature()[0])[0] @ np.linalg.inv(quad_shapes(4, quad_quadrature(3)[0])[0])


@dataclass(frozen=True, eq=False)
class Group:
    """Cells (n,) of one kind of element and their nodes (n, n_functions)."""

    cells: IntArray
    nodes: IntArray
    element: SolidElement | Quadrilateral


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of a mesh by kind of element, all of them or some.

    Attributes
    ----------
    points : (n_points, 3) array
    groups : tuple of Group
        Their cells are numbered 0 ... count - 1.
    count : int
    """

    points: Array
    groups: tuple[Group, ...]
    count: int

    @classmethod
    def of(cls, mesh: Mesh | SectionMesh | Cells, out_of_plane: Extent | None = None) -> Cells:
        """All cells of a mesh, of a section with its extent or of thickness one; cells as they are."""
        if isinstance(mesh, Cells):
            return mesh
        count, width = mesh.cells.shape
        if isinstance(mesh, SectionMesh):
            element = Quadrilateral(width, out_of_plane or Extent(1.0))
            return cls(mesh.points, (Group(np.arange(count), mesh.cells, element),), count)
        groups = (Group(g.cells, g.nodes, SolidElement(width, g.pattern, g.midfaces)) for g in mesh.cell_groups)
        return cls(mesh.points, tuple(groups), count)

    def some(self, cells: IntArray) -> Cells:
        """Some of the cells (n,), numbered anew in this order."""
        number = places_among(cells, self.count)
        places = [number[group.cells] for group in self.groups]
        parts = [
            Group(place[place >= 0], group.nodes[place >= 0], group.element)
            for group, place in zip(self.groups, places, strict=True)
        ]
        return Cells(self.points, tuple(part for part in parts if len(part.cells)), len(cells))


def batches(mesh: Mesh | SectionMesh | Cells, size: int = BATCH, reduced: bool = False) -> Iterator[Batch]:
    """Iterate over the cells of a checked mesh, or others, in batches of one kind of element.

    With `reduced` the points are those of the reduced rule, see `mesh.element.reduced_quadrature`, and the
    gradients have the means of the full one.
    """
    cells = Cells.of(mesh)
    for group in cells.groups:
        full = group.element.rule()
        rule = group.element.rule(reduced) if reduced else full
        for start in range(0, len(group.cells), size):
            part = slice(start, start + size)
            nodes = group.nodes[part]
            x = cells.points[nodes]
            gradients, dV, hoop = group.element.physical(x, rule)
            if reduced:
                whole, volume, around = group.element.physical(x, full)
                if hoop is not None and around is not None:
                    hoop = with_means(around, volume, hoop, dV)[0]
                gradients, dV = with_means(whole, volume, gradients, dV)
            yield Batch(group.cells[part], nodes, rule[0], gradients, dV, hoop)


def nodal_forces(batch: Batch, stress: Array) -> Array:
    """Nodal forces (n_cells, n_functions, 3) of stresses (n_cells, n_q, 3, 3) per volume."""
    weighted = stress * batch.dV[..., None, None]
    f = (batch.gradients @ weighted).sum(axis=1)
    if batch.hoop is not None:
        f[..., 0] += np.einsum("cqa,cq->ca", batch.hoop, weighted[..., 1, 1])
        f[..., 1] -= np.einsum("cqa,cq->ca", batch.hoop, weighted[..., 0, 1])
    return f


def moduli_stiffness(batch: Batch, c: Array) -> Array:
    """Blocks (n_cells, n_pairs, 9) of the integrals of B^T c B, for the pairs of `upper_pairs`.

    Parameters
    ----------
    batch : Batch
    c : (n_cells, n_q or 1, 6, 6) array
        Moduli, components in the order of `common.material.VOIGT`, shears doubled in the strain.
    """
    n, q, m, _ = batch.gradients.shape
    rows = np.zeros((n, q, 6, m, 3))
    for k, (i, j) in enumerate(zip(FIRST, SECOND, strict=True)):
        rows[:, :, k, :, i] += batch.gradients[..., j]
        if i != j:
            rows[:, :, k, :, j] += batch.gradients[..., i]
    if batch.hoop is not None:
        rows[:, :, 1, :, 0] += batch.hoop
    B = rows.reshape(n, q, 6, 3 * m)
    weighted = (c * batch.dV[..., None, None]) @ B
    K = np.swapaxes(B.reshape(n, -1, 3 * m), 1, 2) @ weighted.reshape(n, -1, 3 * m)
    first, second = upper_pairs(m)
    return K.reshape(n, m, 3, m, 3).transpose(0, 1, 3, 2, 4)[:, first, second].reshape(n, -1, 9)


def volume_elements(mesh: Mesh | SectionMesh | Cells) -> Iterator[tuple[IntArray, Array, Array]]:
    """Cells (n_cells,), quadrature points (n_cells, n_q, 3) and volumes (n_cells, n_q), without the gradients."""
    cells = Cells.of(mesh)
    for group in cells.groups:
        x = cells.points[group.nodes]
        yield group.cells, group.element.rule()[0] @ x, group.element.volumes(x)


def assemble_stiffness(
    mesh: Mesh, lame: Array, shear: Array, selective: bool = False, moduli: Array | None = None
) -> sp.csr_matrix:
    """Global stiffness, upper triangle only (its diagonal included), degrees of freedom 3 * node + component.

    The sparsity pattern is found for pairs of nodes, with nine values each.

    Parameters
    ----------
    mesh : Mesh
    lame, shear : (n_cells,) arrays
        Lame constants of each cell.
    selective : bool
        Whether the volumetric part is integrated at reduced points.
    moduli : (n_cells, n_q or 1, 6, 6) array, optional
        In place of Lame constants, see `moduli_stiffness`.

    Returns
    -------
    (3 n_points, 3 n_points) csr_matrix
        Sorted indices.
    """
    n = len(mesh.points)
    groups = [(group.nodes, *upper_pairs(group.nodes.shape[1])) for group in mesh.cell_groups]
    blocks = np.empty((sum(len(nodes) * len(a) for nodes, a, _ in groups), 9))
    size = max(1, ENTRIES // max(9 * nodes.shape[1] ** 2 for nodes, _, _ in groups))
    reduced = batches(mesh, size, reduced=True) if selective else itertools.repeat(None)
    start = 0
    for batch, volumetric in zip(batches(mesh, size), reduced, strict=False):
        if moduli is None:
            K = pair_stiffness(batch, lame[batch.cells], shear[batch.cells], volumetric).reshape(-1, 9)
        else:
            K = moduli_stiffness(batch, moduli[batch.cells, : len(batch.N)]).reshape(-1, 9)
        blocks[start : start + len(K)] = K
        start += len(K)
    first, second = (np.concatenate([nodes[:, pair[k]].ravel() for nodes, *pair in groups]) for k in (0, 1))
    return sum_of_blocks(first, second, blocks, n)


def body_force(mesh: Mesh | SectionMesh | Cells, field: Callable[[Array], Array], density: ArrayLike = 1.0) -> Array:
    """Nodal forces of a force per mass ``field(points (n, 3)) -> (n, 3)``.

    Parameters
    ----------
    mesh : Mesh
    field : callable
    density : float or (n_cells,) array

    Returns
    -------
    (3 n_points,) array
    """
    cells = Cells.of(mesh)
    rho = np.broadcast_to(np.asarray(density, dtype=float), cells.count)
    f = np.zeros((len(cells.points), 3))
    for batch in batches(cells):
        x = np.einsum("qa,cai->cqi", batch.N, cells.points[batch.nodes])
        b = field(x.reshape(-1, 3)).reshape(x.shape)
        nodal = np.einsum("qa,cqi,cq->cai", batch.N, b, batch.dV * rho[batch.cells, None])
        np.add.at(f, batch.nodes, nodal)
    return f.ravel()


def moments_of_volume(mesh: Mesh | SectionMesh | Cells, density: ArrayLike = 1.0) -> tuple[float, Array]:
    """Mass (volume for unit density) and its centre (3,)."""
    every = Cells.of(mesh)
    rho = np.broadcast_to(np.asarray(density, dtype=float), every.count)
    mass, first = 0.0, np.zeros(3)
    for cells, x, dV in volume_elements(every):
        dm = dV * rho[cells, None]
        mass += dm.sum()
        first += np.einsum("cq,cqi->i", dm, x)
    return float(mass), first / mass


def surface_traction(mesh: Mesh, faces: IntArray, traction: Callable[[Array, Array], Array]) -> Array:
    """Nodal forces (3 n_points,) of ``traction(points (n, 3), unit outward normals (n, 3)) -> (n, 3)`` on faces."""
    facets = mesh.face_nodes(faces)
    return facet_forces(len(mesh.points), facets, *facet_integrals(mesh.points, facets), traction)


def facet_forces(
    n_points: int, facets: IntArray, N: Array, x: Array, dA: Array, traction: Callable[[Array, Array], Array]
) -> Array:
    """Nodal forces (3 n_points,) of tractions by functions N (n_facets or 1, n_q, k), positions and vector areas."""
    area = np.linalg.norm(dA, axis=2)
    t = traction(x.reshape(-1, 3), (dA / area[..., None]).reshape(-1, 3)).reshape(x.shape)
    f = np.zeros((n_points, 3))
    np.add.at(f, facets, np.swapaxes(N, 1, 2) @ (t * area[..., None]))
    return f.ravel()
