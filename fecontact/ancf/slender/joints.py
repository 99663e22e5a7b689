"""Supports and joints of slender structures: linear conditions on coordinates, eliminated beforehand.

A joint ties coordinates of two nodes, which keep their initial difference; a support fixes them. The directions that
are left free, an orthonormal basis, are all that statics and dynamics move, so that joints are exact and cost nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError

#: A structure's number and a node of it.
Place = tuple[int, int]


class Jointed(Protocol):
    """What joints ask of a structure."""

    @property
    def name(self) -> str:
        """Of its elements, for messages."""

    @property
    def n_dofs(self) -> int:
        """Number of coordinates."""

    @property
    def vectors(self) -> Array:
        """Initial vectors (n_nodes, per_node, 3) of each node."""


@dataclass(frozen=True, eq=False)
class Joints:
    """Conditions on the coordinates of several structures, one after the other.

    Parameters
    ----------
    structures : sequence of Structure or CorotationalBeam

    Examples
    --------
    >>> from fecontact.ancf.slender import line, straight
    >>> cable = line(straight((0, 0, 0), (1, 0, 0), 2), EA=1.0, EI=1.0)
    >>> joints = Joints([cable])
    >>> joints.free([joints.flat(), joints.clamped((0, 0))]).shape
    (18, 8)
    """

    structures: Sequence[Jointed]

    def _rows(self, place: Place, given: Sequence[int] | None, directions: ArrayLike | None = None) -> sp.csr_matrix:
        """Components along directions (k, 3) of some vectors of a node, or of all."""
        k, node = place
        if not 0 <= k < len(self.structures):
            raise InputError(f"There are {len(self.structures)} structures, counted from 0; found {k}.")
        s = self.structures[k]
        n_nodes = len(s.vectors)
        if not -n_nodes <= node < n_nodes:
            raise InputError(f"Structure {k} has {n_nodes} nodes, counted from 0; found {node}.")
        per_node = s.vectors.shape[1]
        vectors = range(per_node) if given is None else given
        if max(vectors) >= per_node:
            raise InputError(
                f"A node of a {s.name} has a position and {per_node - 1} gradients; this joint needs {max(vectors)}."
            )
        start = sum(other.n_dofs for other in self.structures[:k])
        along = np.eye(3) if directions is None else np.atleast_2d(np.asarray(directions, dtype=float))
        first = start + 3 * (per_node * (node % n_nodes) + np.asarray(vectors))
        columns = (first[:, None, None] + np.arange(3)).repeat(len(along), axis=1).ravel()
        data = np.broadcast_to(along, (len(vectors), *along.shape)).ravel()
        rows = np.arange(len(vectors) * len(along)).repeat(3)
        n_dofs = sum(other.n_dofs for other in self.structures)
        return sp.csr_matrix((data, (rows, columns)), shape=(len(vectors) * len(along), n_dofs))

    def clamped(self, place: Place) -> sp.csr_matrix:
        """Position and all gradients fixed."""
        return self._rows(place, None)

    def pinned(self, place: Place, directions: ArrayLike | None = None) -> sp.csr_matrix:
        """Position fixed, or along some directions (k, 3) only: a slot or roller."""
        return self._rows(place, [0], directions)

    def guided(self, place: Place, gradient: int, directions: ArrayLike | None = None) -> sp.csr_matrix:
        """A gradient (1, 2 or 3) fixed, or along some directions only, as by symmetry."""
        return self._rows(place, [gradient], directions)

    def flat(self) -> sp.csr_matrix:
        """All vectors of all nodes kept in the plane x, y."""
        n_dofs = sum(s.n_dofs for s in self.structures)
        columns = np.arange(2, n_dofs, 3)
        return sp.csr_matrix((np.ones(len(columns)), (np.arange(len(columns)), columns)), shape=(len(columns), n_dofs))

    def spherical(self, one: Place, other: Place) -> sp.csr_matrix:
        """Positions tied; in a plane a pin joint."""
        return sp.csr_matrix(self._rows(one, [0]) - self._rows(other, [0]))

    def slot(self, one: Place, other: Place, along: ArrayLike) -> sp.csr_matrix:
        """Positions tied across a fixed direction (3,)."""
        across = scipy.linalg.null_space(np.atleast_2d(np.asarray(along, dtype=float))).T
        return sp.csr_matrix(self._rows(one, [0], across) - self._rows(other, [0], across))

    def revolute(self, one: Place, other: Place, gradient: int) -> sp.csr_matrix:
        """Positions tied, and the gradient (1, 2 or 3) along the axis of the hinge."""
        return sp.csr_matrix(self._rows(one, [0, gradient]) - self._rows(other, [0, gradient]))

    def rigid(self, one: Place, other: Place) -> sp.csr_matrix:
        """Positions and all gradients tied; nodes may differ in place and direction only by a constant."""
        vectors = range(min(self.structures[p[0]].vectors.shape[1] for p in (one, other)))
        return sp.csr_matrix(self._rows(one, vectors) - self._rows(other, vectors))

    def free(self, conditions: Sequence[sp.csr_matrix]) -> sp.csr_matrix:
        """Orthonormal directions (n_dofs, n_free) that fulfil all conditions.

        Conditions on single coordinates are eliminated as they are, others by the null space of their rows, which are
        few.
        """
        rows = sp.vstack(conditions, format="csr")
        rows.eliminate_zeros()
        n = rows.shape[1]
        single = np.diff(rows.indptr) == 1
        held = np.unique(rows[np.flatnonzero(single)].indices)
        loose = np.setdiff1d(np.arange(n), held)
        rest = rows[np.flatnonzero(~single)][:, loose]
        touched = np.unique(rest.indices)
        others = np.setdiff1d(np.arange(len(loose)), touched)
        basis = null_space(rest[:, touched].toarray())
        ends = sp.csc_matrix((np.ones(len(others)), (loose[others], np.arange(len(others)))), shape=(n, len(others)))
        tied = sp.lil_matrix((n, basis.shape[1]))
        if len(touched):
            tied[loose[touched]] = basis
        return sp.csr_matrix(sp.hstack([ends, tied.tocsc()]))


def null_space(rows: Array) -> Array:
    """Orthonormal null space (n, k) of rows (m, n), dependent ones among them."""
    if rows.shape[1] == 0 or rows.shape[0] == 0:
        return np.eye(rows.shape[1])
    return np.asarray(scipy.linalg.null_space(rows, rcond=1e-10))
