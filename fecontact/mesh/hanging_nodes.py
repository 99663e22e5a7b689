"""Hanging nodes: points of a locally divided mesh whose displacement follows from other points.

Where a divided cell meets an undivided one, the additional nodes of the finer side take the value of the edge and face
functions of the coarser side, so that displacements stay continuous (Demkowicz, Oden, Rachowicz and Hardy 1989, *Toward
a universal h-p adaptive finite element strategy*, part 1). All values are u = T u_free, the stiffness is T^T K T, and
points lie at x = T x_free.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError, MeshError
from fecontact.mesh.element import TRIANGLE_NODES, quad_nodes, quad_shapes, triangle_shapes

#: Weights of a row sum to one up to rounding: products of a few rows of at most a dozen weights of size one.
SUM = 1e-12
#: Distance of a hanging node from where it follows, relative to the largest coordinate, that is rounding.
PLACE = 1e-12
#: Tables of edges and faces divided on one side only, and their numbers of columns.
TABLES = {"edges": 5, "quads": 17, "triangles": 9}


@dataclass(frozen=True, eq=False, repr=False)
class HangingNodes:
    """Ties of the hanging nodes of a mesh.

    Parameters
    ----------
    nodes : (n,) int array
        Points of the mesh that follow from others, each once.
    weights : (n, n_points) sparse matrix
        u[nodes] = weights @ u. Chains are closed: only free points have a weight (see `closed`). Rows sum to one.
    edges : (m, 5) int array
        Divided edges that have an undivided neighbour: end, middle, end, and the points halfway between each end and
        the middle, -1 for cells without mid-edge nodes.
    quads : (k, 17) int array
        Divided quadrilaterals that have an undivided neighbour: four corners, the middles of the sides that follow
        them, the centre, the points halfway between middles and centre, the centres of the quarters; -1 for none.
    triangles : (k, 9) int array
        Divided triangles that have an undivided neighbour: three corners, the middles of the sides that follow them,
        the points halfway between the two middles next to each corner; -1 for none.

    The three tables hold the points that a later division of the coarser side will share.

    Raises
    ------
    MeshError
        If a node is there twice, a hanging node has a weight, or a row does not sum to one.

    Examples
    --------
    The middle of an edge between points 0 and 2:

    >>> import numpy as np
    >>> tie = sp.csr_matrix(np.array([[0.5, 0.0, 0.5]]))
    >>> HangingNodes(np.array([1]), tie, np.array([[0, 1, 2, -1, -1]])).transform.toarray().tolist()
    [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]]
    """

    nodes: IntArray
    weights: sp.csr_matrix
    edges: IntArray = field(default_factory=lambda: np.empty((0, 5), dtype=np.int64))
    quads: IntArray = field(default_factory=lambda: np.empty((0, 17), dtype=np.int64))
    triangles: IntArray = field(default_factory=lambda: np.empty((0, 9), dtype=np.int64))

    def __post_init__(self) -> None:
        nodes = np.asarray(self.nodes, dtype=np.int64)
        tables = {k: np.asarray(getattr(self, k), dtype=np.int64).reshape(-1, n) for k, n in TABLES.items()}
        weights = sp.csr_matrix(self.weights, copy=True)
        # what scipy would do in place later, when the arrays cannot be written any more
        weights.sum_duplicates()
        if len(nodes) != weights.shape[0] or len(np.unique(nodes)) != len(nodes):
            raise MeshError(
                f"Hanging nodes need one row of weights each; found {len(np.unique(nodes))} distinct nodes, "
                f"{len(nodes)} in all, and {weights.shape[0]} rows.",
                code="hanging-shape",
            )
        n_points = weights.shape[1]
        largest = max(t.max(initial=-1) for t in (nodes, *tables.values()))
        if largest >= n_points or nodes.min(initial=0) < 0 or min(t.min(initial=0) for t in tables.values()) < -1:
            raise MeshError(
                f"Hanging nodes are points 0 ... {n_points - 1}; found numbers up to {largest}.", code="hanging-points"
            )
        if np.isin(weights.indices[weights.data != 0], nodes).any():
            raise MeshError("A hanging node follows from another one; close such chains (HangingNodes.closed).")
        off = np.abs(np.asarray(weights.sum(axis=1)).ravel() - 1)
        if (off > SUM).any():
            raise MeshError(
                f"The weights of hanging node {nodes[off.argmax()]} sum to one but for {off.max():.3g}; rigid motions "
                "would strain.",
                code="hanging-weights",
            )
        for array in (nodes, *tables.values(), weights.data, weights.indices, weights.indptr):
            array.setflags(write=False)
        for name, value in {"nodes": nodes, "weights": weights, **tables}.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return f"HangingNodes({len(self.nodes)} of {self.n_points} points)"

    @classmethod
    def closed(cls, nodes: IntArray, weights: sp.csr_matrix, *tables: IntArray) -> Self:
        """Ties with weights (n, n_points) at any points; chains of hanging nodes are resolved to free points.

        Raises
        ------
        MeshError
            If nodes follow from one another in a circle.
        """
        tied = sp.csr_matrix(weights, dtype=float)
        free = np.ones(tied.shape[1], bool)
        free[nodes] = False
        keep = sp.diags(free.astype(float)).tocsr()
        insert = sp.csr_matrix((np.ones(len(nodes)), (nodes, np.arange(len(nodes)))), shape=tied.shape[::-1])
        onward = (tied @ insert).tocsr()
        onward.eliminate_zeros()
        tied = (tied @ keep).tocsr()
        # with A the weights at free points and B at hanging ones: A + B A + B^2 A + ..., by doubling
        for _ in range(2 + int(np.ceil(np.log2(len(nodes) + 1)))):
            if onward.nnz == 0:
                tied.eliminate_zeros()
                return cls(nodes, tied, *tables)
            tied = tied + onward @ tied
            onward = (onward @ onward).tocsr()
            onward.eliminate_zeros()
        raise MeshError("Hanging nodes follow from one another in a circle.", code="hanging-circle")

    @property
    def n_points(self) -> int:
        """Points of the mesh."""
        return int(self.weights.shape[1])

    @cached_property
    def halves(self) -> IntArray:
        """Edges of the finer side (n, 4): two ends, the middle (-1 for none), the divided edge or face.

        Divided edges and faces are numbered through `edges`, `quads` and `triangles`.
        """
        e, q, t = self.edges, self.quads, self.triangles
        owner = np.split(np.arange(len(e) + len(q) + len(t)), [len(e), len(e) + len(q)])
        parts = [(e[:, [0, 1, 3]], owner[0]), (e[:, [2, 1, 4]], owner[0])]
        parts += [(q[:, [4 + k, 8, 9 + k]], owner[1]) for k in range(4)]
        parts += [(t[:, [3 + k, 3 + (k - 1) % 3, 6 + k]], owner[2]) for k in range(3)]
        return np.concatenate([np.column_stack([edges, of]) for edges, of in parts])

    @cached_property
    def quarters(self) -> IntArray:
        """Quadrilaterals of the finer side (n, 5): four corners and the centre, -1 for none."""
        q = self.quads
        return np.concatenate([q[:, [k, 4 + k, 8, 4 + (k - 1) % 4, 13 + k]] for k in range(4)])

    @cached_property
    def fine_faces(self) -> IntArray:
        """Corners (n, 4) of faces of the finer side; triangles repeat the last."""
        t = self.triangles
        three = [t[:, [k, 3 + k, 3 + (k - 1) % 3]] for k in range(3)] + [t[:, 3:6]]
        return np.concatenate([self.quarters[:, :4], np.concatenate(three)[:, [0, 1, 2, 2]]])

    @property
    def faces(self) -> IntArray:
        """Corners (n, 4) of the faces of both sides; triangles repeat the last."""
        return np.concatenate([self.quads[:, :4], self.triangles[:, [0, 1, 2, 2]], self.fine_faces])

    @cached_property
    def free(self) -> IntArray:
        """Points (n_free,) that are not hanging nodes."""
        return np.setdiff1d(np.arange(self.n_points), self.nodes)

    @cached_property
    def transform(self) -> sp.csr_matrix:
        """T (n_points, n_free): u = T u[free]."""
        n = len(self.free)
        identity = sp.csr_matrix((np.ones(n), (self.free, np.arange(n))), shape=(self.n_points, n))
        insert = sp.csr_matrix(
            (np.ones(len(self.nodes)), (self.nodes, np.arange(len(self.nodes)))), shape=(self.n_points, len(self.nodes))
        )
        return (identity + insert @ self.weights[:, self.free]).tocsr()

    def followed(self, points: Array) -> Array:
        """Points or vectors (n_points, k) with the rows of hanging nodes interpolated from the free ones."""
        out = np.array(points, dtype=float)
        out[self.nodes] = self.weights @ out
        return out

    def renumbered(self, number: IntArray, n_points: int) -> Self:
        """The same ties after point k becomes number[k] of n_points; points with weights must be kept."""
        entries = self.weights.tocoo()
        weights = sp.csr_matrix((entries.data, (entries.row, number[entries.col])), shape=(len(self.nodes), n_points))
        tables = {k: np.where(getattr(self, k) < 0, -1, number[getattr(self, k)]) for k in TABLES}
        return replace(self, nodes=number[self.nodes], weights=weights, **tables)


def check_hanging(hanging: HangingNodes | None, points: Array) -> None:
    """Refuse ties of another mesh, and points (n_points, 3) that do not follow as displacements do."""
    if hanging is None:
        return
    if hanging.n_points != len(points):
        raise MeshError(
            f"The hanging nodes are those of a mesh of {hanging.n_points} points; this one has {len(points)}.",
            code="hanging-points",
        )
    off = np.linalg.norm(points[hanging.nodes] - hanging.weights @ points, axis=1)
    if off.max(initial=0.0) > PLACE * np.abs(points).max():
        raise MeshError(
            f"The hanging node {hanging.nodes[off.argmax()]} lies {off.max():.3g} off the place where it follows from "
            "others, so that rigid motions would strain; move points by Mesh.mapped, or HangingNodes.followed.",
            code="hanging-off-place",
        )


def refuse_hanging(hanging: HangingNodes | None, what: str) -> None:
    """Refuse an operation on a mesh with hanging nodes."""
    if hanging is not None:
        raise InputError(
            f"A mesh with {len(hanging.nodes)} hanging nodes cannot be {what}; do that before cells are divided.",
            code="hanging-not-possible",
        )


def joined_hanging(
    parts: Sequence[HangingNodes | None], numbers: Sequence[IntArray], n_points: int
) -> HangingNodes | None:
    """Ties of joined meshes, where the points of part k become numbers[k].

    Raises
    ------
    MeshError
        If a hanging node would be joined with a point of another mesh.
    """
    pairs = enumerate(zip(parts, numbers, strict=True))
    given = [(h.renumbered(n, n_points), k) for k, (h, n) in pairs if h is not None]
    uses = np.bincount(np.concatenate([np.unique(n) for n in numbers]), minlength=n_points)
    for hanging, k in given:
        if (uses[hanging.nodes] > 1).any():
            raise MeshError(
                f"{(uses[hanging.nodes] > 1).sum()} hanging nodes of mesh {k} lie on points of another one; join the "
                "meshes first and divide their cells then.",
                code="hanging-at-joint",
            )
    if not given:
        return None
    return HangingNodes(
        np.concatenate([h.nodes for h, _ in given]),
        sp.vstack([h.weights for h, _ in given]),
        *(np.concatenate([getattr(h, name) for h, _ in given]) for name in TABLES),
    )


def tied(edges: IntArray, quads: IntArray, triangles: IntArray, face_nodes: int, n_points: int) -> HangingNodes | None:
    """Hanging nodes on edges and faces divided on one side only.

    The additional nodes of the finer side take the value of the shape functions of the coarser side.

    Parameters
    ----------
    edges, quads, triangles
        As in `HangingNodes`.
    face_nodes : int
        Nodes of a quadrilateral: 4, 8 or 9.
    n_points : int
        Of the mesh.

    Returns
    -------
    HangingNodes, or None if the tables are empty
    """
    if len(edges) + len(quads) + len(triangles) == 0:
        return None
    parts = _linear_ties(edges, quads) if face_nodes == 4 else _quadratic_ties(edges, quads, triangles, face_nodes)
    nodes = np.concatenate([of for of, _, _ in parts])
    row = np.repeat(np.arange(len(nodes)), np.concatenate([np.full(len(of), m.shape[1]) for of, m, _ in parts]))
    column = np.concatenate([masters.ravel() for _, masters, _ in parts])
    value = np.concatenate([np.tile(weights, len(of)) for of, _, weights in parts])
    weights = sp.csr_matrix((value, (row, column)), shape=(len(nodes), n_points))
    return HangingNodes.closed(nodes, weights, edges, quads, triangles)


#: Hanging nodes (n,), the points (n, k) that they follow from, and the weights (k,) of these.
Tie = tuple[IntArray, IntArray, Array]


def _linear_ties(edges: IntArray, quads: IntArray) -> list[Tie]:
    """Middles of edges and centres of faces: means of the corners."""
    return [(edges[:, 1], edges[:, [0, 2]], np.full(2, 1 / 2)), (quads[:, 8], quads[:, :4], np.full(4, 1 / 4))]


def _quadratic_ties(edges: IntArray, quads: IntArray, triangles: IntArray, face_nodes: int) -> list[Tie]:
    """Additional points by the functions of the edge, of the 8- or 9-node face and of the 6-node triangle."""
    # (1 - s)(1 - 2 s), 4 s (1 - s), s (2 s - 1) at a quarter of the edge
    quarter = np.array([3 / 8, 3 / 4, -1 / 8])
    ties = [(edges[:, 3], edges[:, :3], quarter), (edges[:, 4], edges[:, 2::-1], quarter)]
    corners, middles, centre = np.split(quad_nodes(9), [4, 8])
    places = [((middles + centre) / 2, 9)] + ([((corners + centre) / 2, 13)] if face_nodes == 9 else [(centre, 8)])
    for X, start in places:
        ties += [(quads[:, start + k], quads[:, :face_nodes], N) for k, N in enumerate(quad_shapes(face_nodes, X)[0])]
    middles = TRIANGLE_NODES[3:6]
    N, _ = triangle_shapes(6, (middles + np.roll(middles, 1, axis=0)) / 2)
    return ties + [(triangles[:, 6 + k], triangles[:, :6], N[k]) for k in range(3)]
