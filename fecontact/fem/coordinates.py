"""Coordinates v in which a stiffness is solved: u = T v, T^T K T.

They differ from the displacements u of all nodes in three ways. Where a support is oblique to the mesh's axes, the axes
of its nodes are rotated: u = A v, A orthogonal, so that supports hold single components (R. D. Cook et al., Concepts
and Applications of Finite Element Analysis, 4th ed. 2002, section 8.3, skew supports). Hanging nodes have no
coordinates and follow from the others (`mesh.hanging_nodes`): u = H v. With both, T = H A. Forces are mapped by the
adjoint T^T, which preserves their work; rows C become C T. The stiffness stays symmetric and positive definite, and the
mapping is exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray
from fecontact.fem.links import Links
from fecontact.fem.stiffness import whole_blocks
from fecontact.mesh.hanging_nodes import HangingNodes


@dataclass(frozen=True, eq=False)
class Coordinates:
    """How displacements u (n_dofs,) of all nodes follow from coordinates v (n,).

    Attributes
    ----------
    axes : (n, n) csr_matrix or None
        A, orthogonal; None where the axes are the mesh's everywhere.
    ties : HangingNodes or None
        None where no node hangs.
    links : Links or None
        Linear conditions between coordinates; their dependents are held.

    Examples
    --------
    The middle of three nodes hangs between the others; a force on it acts on them by halves:

    >>> between = HangingNodes(np.array([1]), sp.csr_matrix([[0.5, 0.0, 0.5]]))
    >>> Coordinates(ties=between).forces(np.array([0, 0, 0, 0, 0, 1.0, 0, 0, 0])).tolist()
    [0.0, 0.0, 0.5, 0.0, 0.0, 0.5]
    """

    axes: sp.csr_matrix | None = None
    ties: HangingNodes | None = None
    links: Links | None = None

    @property
    def are_displacements(self) -> bool:
        """Whether T is one."""
        return self.axes is None and self.ties is None and self.links is None

    def count(self, n_dofs: int) -> int:
        """Number of coordinates of n_dofs displacements."""
        return n_dofs if self.ties is None else 3 * len(self.ties.free)

    def of_functions(self, values: NDArray[Any]) -> NDArray[Any]:
        """Rows of nodal values (n_functions, ...) that belong to the coordinates."""
        return values if self.ties is None else values[self.ties.free]

    @cached_property
    def _tie(self) -> sp.csr_matrix | None:
        """H."""
        return None if self.ties is None else sp.kron(self.ties.transform, sp.eye_array(3), format="csr")

    @cached_property
    def _change(self) -> sp.csr_matrix | None:
        """A E; None where it is one."""
        if self.links is None or self.axes is None:
            return self.axes if self.links is None else self.links.change
        return sp.csr_matrix(self.axes @ self.links.change)

    @cached_property
    def _back(self) -> sp.csr_matrix | None:
        """Its inverse."""
        turned = None if self.axes is None else self.axes.T
        if self.links is None:
            return turned
        return self.links.back if turned is None else sp.csr_matrix(self.links.back @ turned)

    def displacements(self, v: Array) -> Array:
        """T v, (n_dofs, ...)."""
        v = v if self._change is None else np.asarray(self._change @ v)
        return v if self._tie is None else np.asarray(self._tie @ v)

    def of_displacements(self, u: Array) -> Array:
        """The coordinates (n, ...) of displacements that are some T v, also of those that violate the conditions."""
        if self.ties is not None:
            u = u.reshape(-1, 3, *u.shape[1:])[self.ties.free].reshape(-1, *u.shape[1:])
        return u if self._back is None else np.asarray(self._back @ u)

    def forces(self, f: Array) -> Array:
        """T^T f, (n, ...)."""
        f = f if self._tie is None else np.asarray(self._tie.T @ f)
        return f if self._change is None else np.asarray(self._change.T @ f)

    def rows(self, C: sp.csr_matrix) -> sp.csr_matrix:
        """C T, (m, n): the same of coordinates; with no node hanging they touch the same nodes."""
        C = C if self._tie is None else C @ self._tie
        return C if self._change is None else C @ self._change

    def row_on_displacements(self, row: Array) -> Array:
        """A row (n_dofs,) that takes of T v what `row` (n,) takes of v."""
        row = row if self._back is None else np.asarray(self._back.T @ row)
        return self._spread(row)

    def gathered(self, f: Array) -> Array:
        """Nodal forces (n_dofs,) that do the same work, none of them on hanging nodes or dependents of conditions."""
        if self.links is not None:
            own = self.forces(f)
            own[self.links.dependents] = 0.0
            return self.row_on_displacements(own)
        return f if self._tie is None else self._spread(np.asarray(self._tie.T @ f))

    def _spread(self, values: Array) -> Array:
        """Values (n,) at the components of the nodes that do not hang, zero at the others'."""
        if self.ties is None:
            return values
        out = np.zeros((self.ties.n_points, 3))
        out[self.ties.free] = values.reshape(-1, 3)
        return out.ravel()

    def stiffness(self, K: sp.csr_matrix) -> sp.csr_matrix:
        """Upper triangle of T^T K T by that of K."""
        if self.ties is not None:
            K = _tied(K, self.ties)
        if self._change is None:
            return K
        return sp.csr_matrix(sp.triu(self._change.T @ (K + sp.triu(K, 1).T) @ self._change))


def _tied(K: sp.csr_matrix, ties: HangingNodes) -> sp.csr_matrix:
    """Upper triangle of H^T K H by that of K.

    With F the free and h the hanging nodes, u_h = W u_F: K_FF + N + N^T, N = W^T (K_hF + K_hh W / 2). Only the rows of
    hanging nodes are multiplied, so that it costs little compared with the assembly.
    """
    free, hanging = _dofs(ties.free), _dofs(ties.nodes)
    W = sp.kron(ties.weights[:, ties.free], sp.eye_array(3), format="csr")
    above = K[hanging]
    below = K[:, hanging].T.tocsr()
    K_hh = above[:, hanging]
    whole = K_hh + below[:, hanging]
    whole.setdiag(K_hh.diagonal())
    N = (W.T @ (above[:, free] + below[:, free] + whole @ W / 2)).tocsr()
    return whole_blocks(restricted(K, free) + sp.triu(N, format="csr") + sp.tril(N, format="csr").T)


def _dofs(nodes: IntArray) -> IntArray:
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def restricted(K: sp.csr_matrix, dofs: IntArray) -> sp.csr_matrix:
    """Rows and columns `dofs` (sorted) of an upper triangle."""
    number = np.full(K.shape[0], -1, dtype=K.indices.dtype)
    number[dofs] = np.arange(len(dofs))
    columns = number[K.indices]
    kept_rows = np.repeat(number >= 0, np.diff(K.indptr))
    kept = kept_rows & (columns >= 0)
    count, full = np.zeros(K.shape[0], dtype=np.int64), np.flatnonzero(np.diff(K.indptr))
    count[full] = np.add.reduceat(kept.view(np.int8), K.indptr[full], dtype=np.int64)
    pointer = np.concatenate([[0], np.cumsum(count[number >= 0])]).astype(K.indptr.dtype)
    return sp.csr_matrix((K.data[kept], columns[kept], pointer), shape=(len(dofs), len(dofs)))
