"""Linear conditions C u = c between displacements of nodes: equations, rigid parts, couplings to a node.

Conditions are solved for as many coordinates, their dependents: v_d = W v + M c. In place of these the violations
w = v_d - W v are coordinates, so that conditions are coordinates held at M c, and supports are no different (R. D. Cook
et al., Concepts and Applications of Finite Element Analysis, 4th ed. 2002, section 13.2, transformation of equations).
The stiffness stays positive definite; nothing is added to it, as a penalty or a multiplier would.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError

#: Share of a condition's largest coefficient that one alone in its column must have to be solved for.
STRONG = 0.1
#: Share of the largest pivot, of conditions scaled to one, below which a condition follows from the others.
RANK = 1e-10
#: Weight that is rounding, as those of motions that cancel.
ROUNDING = 1e-15
#: Most entries of the conditions that are not solved row by row, as an array.
LARGEST = 20_000_000
#: Share of the prescribed values up to which conditions that follow from others agree with them.
AGREE = 1e-9


@dataclass(frozen=True, eq=False)
class Links:
    """Conditions between n coordinates v, solved for their dependents.

    Attributes
    ----------
    dependents : (k,) int array
    weights : (k, n) csr_matrix
        W, zero at dependents.
    given : (k, m) csr_matrix
        M, over the values c (m,) of the conditions.
    rest : (r, n) csr_matrix and (r, m) csr_matrix
        Conditions that held coordinates and others decide already: rest[0] v = rest[1] c must be true.

    Examples
    --------
    v_0 + v_1 = 2 v_2, of which v_2 is held:

    >>> links = Links.of(sp.csr_matrix([[1.0, 1.0, -2.0]]), np.array([False, False, True]))
    >>> links.dependents.tolist(), links.weights.toarray().tolist()
    ([0], [[0.0, -1.0, 2.0]])
    """

    dependents: IntArray
    weights: sp.csr_matrix
    given: sp.csr_matrix
    rest: tuple[sp.csr_matrix, sp.csr_matrix]

    @classmethod
    def of(cls, conditions: sp.csr_matrix, held: Mask) -> Links:
        """Solve conditions (m, n), of which coordinates `held` (n,) are known.

        Raises
        ------
        InputError
            If too many are coupled with each other.
        """
        m, n = conditions.shape
        size = np.maximum(abs(conditions).max(axis=1).toarray().ravel(), np.finfo(float).tiny)
        G = sp.csr_matrix(sp.diags(1 / size) @ conditions)
        loose = sp.csc_matrix(G @ sp.diags((~held).astype(float)))
        loose.eliminate_zeros()
        alone, at, strength = _alone(loose)
        others = np.setdiff1d(np.arange(m), alone)
        columns = np.unique(loose[others].tocoo().col) if len(others) else at[:0]
        if len(others) * len(columns) > LARGEST:
            raise InputError(
                f"{len(others)} linear conditions are coupled with each other over {len(columns)} displacements, too "
                "many to be solved for; write each with a displacement of its own.",
                code="conditions-coupled",
            )
        first, pivots, rest = _coupled(G, loose, others, columns)
        own = sp.csr_matrix(_unit(alone, m).multiply(1 / strength[:, None]))
        # what is alone in its condition may depend on pivots
        own = own - (own @ G)[:, pivots] @ first
        every = sp.vstack([own, first], format="csr")
        dependents = np.concatenate([at, pivots])
        others = sp.diags((~np.isin(np.arange(n), dependents)).astype(float))
        weights = sp.csr_matrix(-(every @ G) @ others)
        weights.data[np.abs(weights.data) < ROUNDING] = 0.0
        weights.eliminate_zeros()
        scaled = sp.diags(1 / size)
        return cls(dependents, weights, every @ scaled, (rest @ G, rest @ scaled))

    @cached_property
    def change(self) -> sp.csr_matrix:
        """E (n, n): coordinates by the others and the violations."""
        return sp.csr_matrix(sp.eye_array(self.weights.shape[1]) + self._spread)

    @cached_property
    def back(self) -> sp.csr_matrix:
        """Its inverse, as W does not lead to dependents."""
        return sp.csr_matrix(sp.eye_array(self.weights.shape[1]) - self._spread)

    @property
    def _spread(self) -> sp.csr_matrix:
        return sp.csr_matrix(_unit(self.dependents, self.weights.shape[1]).T @ self.weights)

    def values(self, c: Array, held: Array) -> Array:
        """Violations M c (k,), with what is prescribed for held coordinates (n,).

        Raises
        ------
        InputError
            If conditions contradict each other or the supports.
        """
        by_held, by_given = self.rest
        off = by_given @ c - by_held @ held
        most = abs(by_given) @ np.abs(c) + abs(by_held) @ np.abs(held)
        if (np.abs(off) > AGREE * most.max(initial=0.0)).any():
            raise InputError(
                f"{(np.abs(off) > AGREE * most.max()).sum()} linear conditions contradict others or the supports: they "
                f"are off by up to {np.abs(off).max():.3g}.",
                code="conditions-contradict",
            )
        return np.asarray(self.given @ c)


def _unit(places: IntArray, n: int) -> sp.csr_matrix:
    """Rows (k, n) of the identity."""
    return sp.csr_matrix((np.ones(len(places)), (np.arange(len(places)), places)), shape=(len(places), n))


def _alone(loose: sp.csc_matrix) -> tuple[IntArray, IntArray, Array]:
    """Rows with a large coefficient that is alone in its column, each once, these columns and coefficients."""
    column = np.flatnonzero(np.diff(loose.indptr) == 1)
    row, value = loose.indices[loose.indptr[column]], loose.data[loose.indptr[column]]
    most = abs(loose).max(axis=1).toarray().ravel() if loose.nnz else np.zeros(loose.shape[0])
    strong = np.abs(value) >= STRONG * most[row]
    row, column, value = row[strong], column[strong], value[strong]
    order = np.lexsort((column, -np.abs(value), row))
    rows, first = np.unique(row[order], return_index=True)
    return rows.astype(np.int64), column[order][first].astype(np.int64), value[order][first]


def _coupled(
    G: sp.csr_matrix, loose: sp.csc_matrix, rows: IntArray, columns: IntArray
) -> tuple[sp.csr_matrix, IntArray, sp.csr_matrix]:
    """Combinations (k, m) of rows that are solved for pivots (k,), and those (r, m) that have none."""
    m = G.shape[0]
    if not len(rows):
        return sp.csr_matrix((0, m)), np.zeros(0, np.int64), sp.csr_matrix((0, m))
    dense = loose[rows][:, columns].toarray()
    Q, R, order = scipy.linalg.qr(dense, pivoting=True) if len(columns) else (np.eye(len(rows)), dense, columns)
    diagonal = np.abs(np.diagonal(R))
    k = int((diagonal > RANK * diagonal.max(initial=1.0)).sum())
    place = _unit(rows, m)
    first = scipy.linalg.solve_triangular(R[:k, :k], Q[:, :k].T) if k else np.zeros((0, len(rows)))
    return sp.csr_matrix(first @ place), columns[order[:k]], sp.csr_matrix(Q[:, k:].T @ place)
