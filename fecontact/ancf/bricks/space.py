"""Coordinates of a mesh of bricks: numbering, initial values, and shape functions in material coordinates.

The coordinates of a node are its position and the three gradients dr/dX_m with respect to the *global* material axes,
which all elements round the node share. An element needs derivatives along its own reference axes t_j:

    dr/dt_j = sum_m dr/dX_m J_mj,    J_mj = dX_m/dt_j at that node, of the initial geometry,

so its functions for the gradients are S_km = sum_j J_mj N_kj with the reference functions N of `hexahedron.shapes`. Two
elements that share a face share its edges and so the in-face columns of J: the space conforms on every mesh. The
geometry is interpolated by the same functions, X = S e0 with e0 the nodal positions and unit gradients; that is exact
for straight and 20-node hexahedra, and gives dr/dX = (dr/dt)(dX/dt)^-1 (Shabana, table 5.1: J = J_current J_0^-1), so
that the initial, possibly curved, shape is free of stress. Every r = A X + b is represented exactly.

Gradients shared between neighbouring elements, and where they are released.

Shared gradients make the strain continuous at nodes. That is wrong where the material changes: there the stress vector
is continuous and the normal strain jumps. At such a node each *side* (all cells of one label) gets its own gradients
F_a, tied only by continuity: where cells of the sides a and b share a face with tangents t_1, t_2 at the node, F_a
t_j = F_b t_j. These conditions are the same for each component; their null space is the set of remaining functions, one
more than usual (the normal gradient of the second side) at a smooth interface of two materials.

The same applies at sharp edges where the strain is singular or multi-valued, with every cell a side of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.ancf.bricks.hexahedron import N_FUNCTIONS, face_points, gauss, shapes
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError, MeshError
from fecontact.fem.element_stiffness import determinant_3x3, inverse_3x3, jacobians
from fecontact.mesh.check import check_cells
from fecontact.mesh.element import CORNERS, FACES, hex_shapes, quad_quadrature
from fecontact.mesh.facets import corner_keys, sides_of
from fecontact.mesh.hanging_nodes import refuse_hanging
from fecontact.mesh.mesh import Mesh

#: Quadrature degree on faces: four points per direction.
ORDER = 7
#: Functions (n_faces, n) of faces, their values (n_faces, n_q, n) and derivatives (n_faces, n_q, n, 2), weights (n_q,).
SurfaceRule = tuple[IntArray, Array, Array, Array]


@dataclass(frozen=True, eq=False)
class Numbering:
    """Numbers of functions; see `AncfSpace` for the attributes."""

    functions: IntArray
    joining: sp.csr_matrix | None
    start: IntArray
    n_functions: int


def sides_by_label(mesh: Mesh, labels: IntArray) -> IntArray:
    """Sides (n_cells, 8) from a label of each cell, such as its material: gradients are released where labels meet.

    Examples
    --------
    >>> from fecontact import shapes
    >>> sides_by_label(shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), np.array([3])).tolist()
    [[3, 3, 3, 3, 3, 3, 3, 3]]
    """
    labels = np.asarray(labels, dtype=np.int64)
    if labels.shape != (len(mesh.cells),):
        raise InputError(f"One label is needed for each of the {len(mesh.cells)} cells; found shape {labels.shape}.")
    return np.repeat(labels[:, None], 8, axis=1)


def released_at(mesh: Mesh, points: IntArray, sides: IntArray | None = None) -> IntArray:
    """Sides (n_cells, 8) with every cell a side of its own at the given points of the mesh, as at a sharp edge."""
    out = np.zeros((len(mesh.cells), 8), dtype=np.int64) if sides is None else np.array(sides, dtype=np.int64)
    chosen = np.isin(mesh.cells[:, :8], points)
    cell = np.broadcast_to(np.arange(len(mesh.cells))[:, None], out.shape)
    out[chosen] = out.max(initial=0) + 1 + cell[chosen]
    return out


def reentrant_points(mesh: Mesh, degrees: float = 30.0) -> IntArray:
    """Points on re-entrant edges of the surface sharper than `degrees`, where the stress is singular.

    Examples
    --------
    >>> from fecontact import shapes
    >>> reentrant_points(shapes.block((1.0, 1.0, 1.0), (2, 2, 2))).size  # a block has none
    0
    """
    faces = mesh.outer_faces
    corners = np.take_along_axis(mesh.cells[faces[:, 0]], FACES[faces[:, 1], :4], axis=1)
    x = mesh.points[corners]
    normal = np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    middle = x.mean(axis=1)
    ends = np.sort(sides_of(corners).reshape(-1, 2), axis=1)
    order = np.lexsort(ends.T)
    twin = np.flatnonzero((ends[order[1:]] == ends[order[:-1]]).all(axis=1))
    a, b = order[twin] // 4, order[twin + 1] // 4
    inwards = np.einsum("ni,ni->n", middle[b] - middle[a], normal[a]) > 0
    sharp = np.einsum("ni,ni->n", normal[a], normal[b]) < np.cos(np.radians(degrees))
    return np.unique(ends[order[twin[inwards & sharp]]])


def number(corners: IntArray, sides: IntArray | None, jacobians: Array) -> Numbering:
    """Number the functions of all cells.

    Parameters
    ----------
    corners : (n_cells, 8) int array
        Nodes 0 ... n_nodes - 1.
    sides : (n_cells, 8) int array or None
    jacobians : (n_cells, 8, 3, 3) array
        dX_m/dt_j at the corners: column j is the tangent along reference axis j.
    """
    n_nodes = int(corners.max()) + 1
    shape = (len(corners), 32)
    if sides is None:
        functions = (4 * corners[:, :, None] + np.arange(4)).reshape(shape)
        return Numbering(functions, None, 4 * np.arange(n_nodes), 4 * n_nodes)
    pairs, side = np.unique(np.stack([corners, sides], axis=-1).reshape(-1, 2), axis=0, return_inverse=True)
    side = side.reshape(corners.shape)
    count = np.bincount(pairs[:, 0], minlength=n_nodes)
    first_side = np.concatenate([[0], np.cumsum(count)[:-1]])
    if (count == 1).all():
        return number(corners, None, jacobians)
    position = np.arange(n_nodes) + 3 * first_side
    gradient = pairs[:, 0] + 1 + 3 * np.arange(len(pairs))
    own = np.concatenate([position[corners][..., None], gradient[side][..., None] + np.arange(3)], axis=2)
    blocks = _free_gradients(corners, side, first_side, count, jacobians)
    n_free = np.full(n_nodes, 3)
    for nodes, bases in blocks:
        n_free[nodes] = bases.shape[2]
    start = np.concatenate([[0], np.cumsum(1 + n_free)[:-1]])
    joining = _joining(start, n_free, position, count, blocks)
    return Numbering(own.reshape(shape), joining, start, int((1 + n_free).sum()))


def _free_gradients(
    corners: IntArray, side: IntArray, first_side: IntArray, count: IntArray, jacobians: Array
) -> list[tuple[IntArray, Array]]:
    """Nodes with several sides, and orthonormal bases (n, 3 n_sides, n_free) of their gradients, in blocks."""
    node, a, b, tangent = _ties(corners, side, jacobians)
    out = []
    for m in np.unique(count[count > 1]):
        nodes = np.flatnonzero(count == m)
        chosen = np.flatnonzero(count[node] == m)
        local = np.searchsorted(nodes, node[chosen])
        # the normal matrix of the ties has the same null space and a fixed size for any number of ties
        row = np.zeros((len(chosen), m, 3))
        t = tangent[chosen] / np.linalg.norm(tangent[chosen], axis=1, keepdims=True)
        row[np.arange(len(chosen)), a[chosen] - first_side[node[chosen]]] = t
        row[np.arange(len(chosen)), b[chosen] - first_side[node[chosen]]] = -t
        row = row.reshape(-1, 3 * m)
        normal = np.zeros((len(nodes), 3 * m, 3 * m))
        np.add.at(normal, local, row[:, :, None] * row[:, None, :])
        values, vectors = np.linalg.eigh(normal)
        free = (values <= 1e-9).sum(axis=1)
        out += [(nodes[free == d], vectors[free == d][:, :, :d]) for d in np.unique(free)]
    return out


def _ties(corners: IntArray, side: IntArray, jacobians: Array) -> tuple[IntArray, IntArray, IntArray, Array]:
    """Conditions F_a t = F_b t at corners of faces between different sides: node, a, b and tangent t."""
    keys = corner_keys(corners[:, FACES[:, :4]].reshape(-1, 4))
    order = np.lexsort(keys.T[::-1])
    twin = np.flatnonzero((keys[order[1:]] == keys[order[:-1]]).all(axis=1))
    one, other = order[twin], order[twin + 1]
    cell, face = np.divmod(one, 6)
    local = FACES[face, :4]
    node = corners[cell[:, None], local]
    there = (other // 6)[:, None]
    match = np.argmax(corners[there[:, :, None], np.arange(8)] == node[:, :, None], axis=2)
    a, b = side[cell[:, None], local], side[there, match]
    f, k = np.nonzero(a != b)
    found: list[tuple[IntArray, ...]] = []
    tangents = []
    for step in (1, 2):
        axis = (face[f] // 2 + step) % 3
        found.append((node[f, k], a[f, k], b[f, k]))
        tangents.append(jacobians[cell[f], local[f, k], :, axis])
    node, a, b = (np.concatenate(column) for column in zip(*found, strict=True))
    return node, a, b, np.concatenate(tangents)


def _joining(
    start: IntArray, n_free: IntArray, position: IntArray, count: IntArray, blocks: list[tuple[IntArray, Array]]
) -> sp.csr_matrix:
    """Matrix from the remaining functions to those of the sides; its columns are orthonormal."""
    plain = np.flatnonzero(count == 1)
    rows = [position, (position[plain][:, None] + np.arange(1, 4)).ravel()]
    columns = [start, (start[plain][:, None] + np.arange(1, 4)).ravel()]
    values = [np.ones(len(position)), np.ones(3 * len(plain))]
    for nodes, basis in blocks:
        n, m, d = basis.shape
        rows.append(np.broadcast_to((position[nodes][:, None] + 1 + np.arange(m))[:, :, None], (n, m, d)).ravel())
        columns.append(np.broadcast_to((start[nodes][:, None] + 1 + np.arange(d))[:, None, :], (n, m, d)).ravel())
        values.append(basis.ravel())
    shape = (int((1 + 3 * count).sum()), int((1 + n_free).sum()))
    return sp.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)


#: Cells per batch; with 64 points its shape functions take some 12 MB.
BATCH = 64
#: Newton iterations that locate a point in a cell, and the distance, relative to the cell, up to which it is inside.
LOCATING, INSIDE = 12, 1e-8


@dataclass(frozen=True, eq=False)
class GradientBatch:
    """Shape functions of some cells at the same reference points.

    Attributes
    ----------
    cells : (n_cells,) array
    functions : (n_cells, 32) array
        Numbers of the functions before releases are joined, see `AncfSpace.functions`.
    S : (n_cells, n_q, 32) array
    gradients : (n_cells, n_q, 32, 3) array
        With respect to material coordinates.
    dV : (n_cells, n_q) array
        Volume times quadrature weight.
    """

    cells: IntArray
    functions: IntArray
    S: Array
    gradients: Array
    dV: Array

    def some(self, cells: Mask) -> GradientBatch:
        """Some cells (n_cells,) of the batch."""
        return GradientBatch(*(getattr(self, f.name)[cells] for f in fields(self)))

    def add_forces(self, total: Array, P: Array) -> None:
        """Add int P grad S_a dV of stresses P (n_cells, n_q, 3, 3) to forces (n_cell_functions, 3)."""
        n, n_q = self.dV.shape
        G = self.gradients.swapaxes(2, 3).reshape(n, 3 * n_q, -1)
        weighted = (P * self.dV[..., None, None]).swapaxes(2, 3).reshape(n, 3 * n_q, 3)
        np.add.at(total, self.functions, np.swapaxes(G, 1, 2) @ weighted)


def check_bricks(mesh: Mesh) -> None:
    """Refuse meshes that bricks with gradient coordinates cannot be made of.

    Raises
    ------
    MeshError, InputError
        For degenerate cells; for hanging nodes.
    """
    if mesh.has_coalesced:
        raise MeshError(
            "The brick with gradient coordinates needs hexahedra with eight distinct corners; the mesh has "
            f"degenerate cells ({', '.join(mesh.kinds)}). Use ElasticBody, or a mesh of hexahedra only.",
            code="degenerate-cells",
        )
    refuse_hanging(mesh.hanging, "used with gradient coordinates")


@dataclass(frozen=True, eq=False)
class AncfSpace:
    """Coordinates of a mesh of eight-node bricks: twelve per node.

    A vector q (n_dofs,) of coordinates is ``q.reshape(-1, 3)[f]``: the three components that belong to scalar function
    f. Node k (in the order of `nodes`) has f = 4 k for its position and 4 k + 1, 2, 3 for dr/dX, dr/dY, dr/dZ. Nodes
    with released gradients have more functions, see `start` and `joining`.

    Parameters
    ----------
    mesh : Mesh
        Hexahedra of 8, 20 or 27 nodes, none degenerate; curved ones are represented by the corners and the slopes
        there.
    sides : (n_cells, 8) int array, optional
        Label of the side on which each corner of each cell lies; at a node, cells of different labels share only the
        gradients required by continuity along their common faces. See `release`.

    Raises
    ------
    MeshError, InputError
        For degenerate, inverted or folded cells; for hanging nodes.

    Examples
    --------
    >>> from fecontact import shapes
    >>> space = AncfSpace(shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8"))
    >>> space.n_dofs, space.q0.reshape(-1, 3)[:4].tolist()
    (144, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    """

    mesh: Mesh
    sides: IntArray | None = None

    def __post_init__(self) -> None:
        check_bricks(self.mesh)
        check_cells(self.mesh)

    @cached_property
    def nodes(self) -> IntArray:
        """Points of the mesh (n_nodes,) that are nodes, the corners of its cells, increasing."""
        return np.unique(self.mesh.cells[:, :8])

    @cached_property
    def corners(self) -> IntArray:
        """Nodes (n_cells, 8) of the cells, counted in `nodes`."""
        return np.searchsorted(self.nodes, self.mesh.cells[:, :8])

    def node_of(self, point: int) -> int:
        """Number in `nodes` of a point of the mesh.

        Raises
        ------
        InputError
            If the point is not a corner of a cell.
        """
        node = int(np.searchsorted(self.nodes, point))
        if node == len(self.nodes) or self.nodes[node] != point:
            raise InputError(f"Point {point} is no corner of a cell; the nodes of this element are corners only.")
        return node

    @cached_property
    def kept(self) -> dict[Any, Any]:
        """Functions on boundaries by name, filled by `surface_rule`, and what loads need in every iteration."""
        return {}

    @cached_property
    def nodal_jacobians(self) -> Array:
        """dX_m/dt_j (n_cells, 8, 3, 3) of the initial geometry at the corners."""
        _, dN = hex_shapes(self.mesh.cells.shape[1], CORNERS)
        return jacobians(self.mesh.points[self.mesh.cells], dN)

    @cached_property
    def _numbering(self) -> Numbering:
        return number(self.corners, self.sides, self.nodal_jacobians)

    @property
    def functions(self) -> IntArray:
        """Numbers (n_cells, 32) of the cells' functions, before those of released nodes are joined."""
        return self._numbering.functions

    @property
    def joining(self) -> sp.csr_matrix | None:
        """Matrix (n_cell_functions, n_functions) that joins released gradients; None without releases."""
        return self._numbering.joining

    @property
    def start(self) -> IntArray:
        """First function (n_nodes,) of each node, its position."""
        return self._numbering.start

    @property
    def n_functions(self) -> int:
        """Scalar functions."""
        return self._numbering.n_functions

    @property
    def n_dofs(self) -> int:
        """Coordinates, three per function."""
        return 3 * self.n_functions

    def spread(self, q: Array) -> Array:
        """Coordinates (n_cell_functions, 3) of the cells' functions, from q (n_dofs,)."""
        e = np.asarray(q, dtype=float).reshape(-1, 3)
        return e if self.joining is None else self.joining @ e

    def gather(self, f: Array) -> Array:
        """Generalised forces (n_dofs,) from those on the cells' functions (n_cell_functions, 3)."""
        return np.asarray(f if self.joining is None else self.joining.T @ f).ravel()

    @cached_property
    def _cell_q0(self) -> Array:
        """Initial coordinates (n_cells, 32, 3)."""
        e = np.zeros((len(self.corners), 8, 4, 3))
        e[:, :, 0] = self.mesh.points[self.mesh.cells[:, :8]]
        e[:, :, 1:] = np.eye(3)
        return e.reshape(-1, N_FUNCTIONS, 3)

    @cached_property
    def q0(self) -> Array:
        """Initial coordinates (n_dofs,): positions and unit gradients."""
        return self.affine(np.eye(3), np.zeros(3))

    def affine(self, A: ArrayLike, b: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Coordinates (n_dofs,) of r = A X + b, for A (3, 3)."""
        A = np.asarray(A, dtype=float)
        e = np.zeros((self._numbering.functions.max() + 1, 3))
        cell = self._cell_q0 @ A.T
        cell[:, ::4] += np.asarray(b, dtype=float)
        e[self.functions] = cell
        # the columns of the joining matrix are orthonormal
        return self.gather(e)

    def rigid_modes(self, origin: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Changes (n_dofs, 6) of the coordinates under the six small rigid motions about `origin`.

        Columns as in `fem.rigid.COMPONENTS`. A rotation by w moves r by w x (X - origin) and dr/dX_m by w x e_m.
        """
        o = np.asarray(origin, dtype=float)
        columns = [self.affine(np.zeros((3, 3)), unit) for unit in np.eye(3)]
        for w in np.eye(3):
            spin = np.cross(w, np.eye(3)).T
            columns.append(self.affine(spin, -spin @ o))
        return np.stack(columns, axis=1)

    def values(self, cells: IntArray, N: Array) -> Array:
        """Functions S (n_cells, n_q, 32) of cells from reference functions N (n_q, 32) or (n_cells, n_q, 32)."""
        J = self.nodal_jacobians[cells]
        S = np.array(np.broadcast_to(N, (len(cells), *N.shape[-2:])))
        by_corner = S.reshape(*S.shape[:2], 8, 4)
        by_corner[..., 1:] = np.einsum("ckmj,cqkj->cqkm", J, by_corner[..., 1:], optimize=True)
        return S

    def reference_gradients(self, cells: IntArray, dN: Array) -> Array:
        """Derivatives of S along the reference axes, (n_cells, n_q, 32, 3), from dN (n_q, 32, 3) or per cell."""
        shape = (len(cells), *dN.shape[-3:])
        flat = np.broadcast_to(dN, shape).transpose(0, 1, 3, 2).reshape(len(cells), -1, N_FUNCTIONS)
        return self.values(cells, flat).reshape(*shape[:2], 3, N_FUNCTIONS).swapaxes(2, 3)

    def batches(self, X: Array, W: Array, size: int = BATCH) -> Iterator[GradientBatch]:
        """Batches of all cells: functions, material gradients and volumes at reference points X with weights W."""
        N, dN = shapes(X)
        n_q = len(X)
        # the reference functions by corner, so that the nodal Jacobians act by one matrix product per corner
        rates = np.ascontiguousarray(dN.reshape(n_q, 8, 4, 3).transpose(1, 2, 0, 3)).reshape(8, 4, n_q * 3)
        for start in range(0, len(self.corners), size):
            cells = np.arange(start, min(start + size, len(self.corners)))
            slopes = self.nodal_jacobians[cells] @ rates[None, :, 1:]
            first = np.broadcast_to(rates[None, :, :1], (len(cells), 8, 1, 3 * n_q))
            dS = np.concatenate([first, slopes], axis=2).reshape(len(cells), N_FUNCTIONS, n_q, 3).swapaxes(1, 2)
            J = np.einsum("cai,cqaj->cqij", self._cell_q0[cells], dS, optimize=True)
            inverse, det = inverse_3x3(J)
            # functions last in memory, as all products with the gradients want them
            gradients = np.ascontiguousarray((dS @ inverse).swapaxes(2, 3)).swapaxes(2, 3)
            yield GradientBatch(cells, self.functions[cells], self.values(cells, N), gradients, det * W)

    def points_at(self, q: Array, cells: IntArray, X: Array) -> Array:
        """Positions (n, 3) of material points, given by cell (n,) and reference coordinates (n, 3)."""
        S = self.rows_at(cells, X)
        return np.asarray(S @ np.asarray(q, dtype=float).reshape(-1, 3))

    def surface_rule(self, boundary: str) -> SurfaceRule:
        """Quadrature on a boundary, kept: pressure needs it in every iteration."""
        if boundary not in self.kept:
            faces = self.mesh.faces(boundary)
            X, W = quad_quadrature(ORDER)
            n = len(X)
            S, dS = self.face_functions(np.repeat(faces, n, axis=0), np.tile(X, (len(faces), 1)))
            each = self.functions[faces[:, 0]]
            self.kept[boundary] = each, S.reshape(len(faces), n, -1), dS.reshape(len(faces), n, -1, 2), W
        return self.kept[boundary]

    def gradient_weights(self, at: str | int) -> Array:
        """B (n_functions, 3) of what turns, sum_f q_f (x) B_f: a boundary, or the gradients at a point of the mesh.

        Of a boundary B is int S_f (X - X_mean) dA over its polar moment of area.

        Raises
        ------
        InputError
            For a point that is no node, or whose gradients are released.
        """
        if not isinstance(at, str):
            node = self.node_of(at)
            first, count = self.start[node], np.diff(np.append(self.start, self.n_functions))[node]
            if count != 4:
                raise InputError(
                    f"Point {at} has released gradients, so that it has no single rotation; take a boundary."
                )
            B = np.zeros((self.n_functions, 3))
            B[first + 1 : first + 4] = np.eye(3)
            return B
        functions, S, dS, W = self.surface_rule(at)
        e = self.spread(self.q0)[functions]
        area = np.linalg.norm(vector_areas(e, dS), axis=2) * W
        X = S @ e
        X = X - (area[..., None] * X).sum(axis=(0, 1)) / area.sum()
        total = np.zeros((int(self.functions.max()) + 1, 3))
        np.add.at(total, functions, np.swapaxes(S, 1, 2) @ (area[..., None] * X))
        return self.gather(total).reshape(-1, 3) / (area[..., None] * X * X).sum()

    def place_rows(self, where: ArrayLike) -> list[sp.csr_matrix]:
        """Rows (n, n_functions) of the position and the three gradients at points (3,) or (n, 3) of the initial shape.

        Raises
        ------
        InputError
            If they are no points, or lie outside.
        """
        points = np.atleast_2d(np.asarray(where, dtype=float))
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise InputError(f"A place of bricks is a point of three finite numbers, or several; found {where!r}.")
        cells, X = self.located(points)
        return [self.rows_at(cells, X), *self.gradient_rows_at(cells, X)]

    def located(self, points: ArrayLike) -> tuple[IntArray, Array]:
        """Cells (n,) and reference coordinates (n, 3) of points (n, 3) of the initial shape, by Newton's method.

        Raises
        ------
        InputError
            If a point lies outside the mesh.

        Examples
        --------
        >>> from fecontact import shapes
        >>> space = AncfSpace(shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8"))
        >>> cells, X = space.located([(1.5, 0.25, 1.0)])
        >>> cells.tolist(), X.round(12).tolist()
        ([1], [[0.5, 0.25, 1.0]])
        """
        x = np.atleast_2d(np.asarray(points, dtype=float))
        corners = self.mesh.points[self.mesh.cells]
        low, high = corners.min(axis=1), corners.max(axis=1)
        wider = (high - low).max(axis=1, keepdims=True) / 4  # a curved side bulges beyond its nodes
        low, high = low - wider, high + wider
        point, cells = np.nonzero(((x[:, None] >= low) & (x[:, None] <= high)).all(axis=2))
        _refuse_outside(x, point)
        X = np.full((len(point), 3), 0.5)
        for _ in range(LOCATING):
            _, dN = shapes(X)
            J = np.einsum("cai,caj->cij", self._cell_q0[cells], self.reference_gradients(cells, dN[:, None])[:, 0])
            off = x[point] - self.points_at(self.q0, cells, X)
            X = np.clip(X + (inverse_3x3(J)[0] @ off[:, :, None])[:, :, 0], 0.0, 1.0)
        distance = np.linalg.norm(x[point] - self.points_at(self.q0, cells, X), axis=1) / (high - low)[cells].max(
            axis=1
        )
        inside = distance < INSIDE
        found, first = np.unique(point[inside], return_index=True)
        _refuse_outside(x, found)
        return cells[inside][first], X[inside][first]

    def rows_at(self, cells: IntArray, X: Array) -> sp.csr_matrix:
        """Values (n, n_functions) of all functions at material points, cell (n,) and reference coordinates (n, 3)."""
        N, _ = shapes(X)
        return self._sparse(cells, self.values(cells, N[:, None, :])[:, 0])

    def gradient_rows_at(self, cells: IntArray, X: Array) -> list[sp.csr_matrix]:
        """Rows (n, n_functions) of the derivative along each material axis at material points."""
        _, dN = shapes(X)
        dS = self.reference_gradients(cells, dN[:, None])[:, 0]
        inverse, _ = inverse_3x3(np.einsum("cai,caj->cij", self._cell_q0[cells], dS))
        return [self._sparse(cells, column) for column in np.moveaxis(dS @ inverse, 2, 0)]

    def gradient_at(self, q: Array, cells: IntArray, X: Array) -> Array:
        """Deformation gradients dr_i/dX_j (n, 3, 3) at material points."""
        _, dN = shapes(X)
        dS = self.reference_gradients(cells, dN[:, None])[:, 0]
        inverse, _ = inverse_3x3(np.einsum("cai,caj->cij", self._cell_q0[cells], dS))
        return np.einsum("cai,caj->cij", self.spread(q)[self.functions[cells]], dS @ inverse)

    def _sparse(self, cells: IntArray, S: Array) -> sp.csr_matrix:
        columns = self.functions[cells]
        pointer = np.arange(0, columns.size + 1, N_FUNCTIONS)
        n = self.n_functions if self.joining is None else self.joining.shape[0]
        rows = sp.csr_matrix((S.ravel(), columns.ravel(), pointer), shape=(len(cells), n))
        rows.eliminate_zeros()
        return rows if self.joining is None else (rows @ self.joining).tocsr()

    def face_functions(self, faces: IntArray, local: Array) -> tuple[Array, Array]:
        """Functions of faces at their coordinates.

        Parameters
        ----------
        faces : (n, 2) int array
            Cell and local face of each point.
        local : (n, 2) array
            Coordinates on the face, counter-clockwise seen from outside.

        Returns
        -------
        S : (n, 32) array
            Twelve combinations of sixteen functions, Adini's; the others vanish.
        dS : (n, 32, 2) array
            Derivatives along the face's coordinates.
        """
        cell, face = faces.T
        X, axes = np.empty((len(cell), 3)), np.empty((len(cell), 3, 2))
        for f in range(6):
            rows = np.flatnonzero(face == f)
            X[rows] = face_points(f, local[rows])
            axes[rows] = (face_points(f, np.eye(2)) - face_points(f, np.zeros((1, 2)))).T
        N, dN = shapes(X)
        S = self.values(cell, N[:, None, :])[:, 0]
        return S, self.reference_gradients(cell, dN[:, None])[:, 0] @ axes

    def face_rows(self, faces: IntArray, local: Array) -> sp.csr_matrix:
        """Values (n, n_functions) of all functions at points of faces, see `face_functions`."""
        return self._sparse(faces[:, 0], self.face_functions(faces, local)[0])

    @cached_property
    def volumes(self) -> Array:
        """Volumes (n_cells,) of the interpolated initial geometry."""
        X, W = gauss(4)
        _, dN = shapes(X)
        out = np.empty(len(self.corners))
        for start in range(0, len(out), BATCH):
            cells = np.arange(start, min(start + BATCH, len(out)))
            J = np.einsum("cai,cqaj->cqij", self._cell_q0[cells], self.reference_gradients(cells, dN), optimize=True)
            out[cells] = determinant_3x3(J) @ W
        return out


def _refuse_outside(points: Array, found: IntArray) -> None:
    """Refuse points (n, 3) that are not among those found in a cell, by number."""
    lost = np.setdiff1d(np.arange(len(points)), found)
    if len(lost):
        raise InputError(
            f"{len(lost)} of {len(points)} points lie outside the initial shape, the first at "
            f"{points[lost[0]].tolist()}; choose points inside it or on its surface.",
            code="points-outside-body",
        )


def deformation_gradients(e: Array, batch: GradientBatch) -> Array:
    """F = dr/dX (n_cells, n_q, 3, 3) of coordinates e (n_cell_functions, 3)."""
    n, n_q, n_functions, _ = batch.gradients.shape
    G = batch.gradients.swapaxes(2, 3).reshape(n, 3 * n_q, n_functions)
    F = np.swapaxes(e[batch.functions], 1, 2) @ np.swapaxes(G, 1, 2)
    return np.ascontiguousarray(F.reshape(n, 3, n_q, 3).swapaxes(1, 2))


def vector_areas(e: Array, dS: Array) -> Array:
    """Outward vector areas (n_faces, n_q, 3) per area of the face's coordinates; of an axis its tangents."""
    along = np.einsum("fqaj,fai->fqij", dS, e, optimize=True)
    return np.cross(along[..., 0], along[..., 1]) if along.shape[-1] == 2 else along[..., 0]
