"""Smoothed aggregation for a stiffness, in place of a factor: memory and work proportional to its size.

The near-nullspace are the six rigid modes (P. Vanek, J. Mandel, M. Brezina, Computing 56 (1996) 179); all entries count
as strong, so that the displacements of a node are aggregated together. The smoother is symmetric Gauss-Seidel. Elements
of higher order get one level more: aggregates are made of the trilinear functions on their corners (p-multigrid; Y.
Maday, R. Munoz, J. Sci. Comput. 3 (1988) 323), as those of the stiff nodes between corners are poor.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import FecontactError, MissingPackageError
from fecontact.mesh.element import FACES, hex_nodes, hex_shapes
from fecontact.mesh.facets import places_among
from fecontact.mesh.mesh import Mesh

#: Relative residual of a solve: a hundredth of the certificate's tolerance.
TIGHT = 1e-12
#: Largest number of steps of one solve.
MAX_ITERATIONS = 2000
#: Nodes of the coarsest level, which is factorised; a dense inverse takes longer than all other levels.
COARSEST = 100
#: Solutions kept to start from: those of two poses of one model.
KEPT = 2


class AmgFactor:
    """Conjugate gradients with smoothed aggregation, in place of a factor.

    Parameters
    ----------
    K : (n, n) csr_matrix
        Upper triangle of a symmetric positive definite matrix.
    modes : (n, 6) array
        Rigid modes.
    corners : (index, P), optional
        Rows (k,) of the corners' displacements and the interpolation (n, k) from them, where elements have other nodes.

    Raises
    ------
    MissingPackageError
        Without pyamg.

    Attributes
    ----------
    K : (n, n) csr_matrix
        The whole matrix.
    """

    def __init__(self, K: sp.csr_matrix, modes: Array, corners: tuple[IntArray, sp.csr_matrix] | None = None) -> None:
        if importlib.util.find_spec("pyamg") is None:
            raise MissingPackageError("The back-end 'amg' needs the package pyamg: pip install 'fecontact[amg]'.")
        self.K = (K + sp.triu(K, 1).T).tocsr()
        #: Approximation of the inverse.
        self.cycle = Cycle.of(self.K, modes) if corners is None else Cycle.of_corners(self.K, modes, *corners)
        #: Steps of conjugate gradients so far.
        self.steps = 0
        self._last: list[Array] = []

    @property
    def memory(self) -> int:
        """Bytes of the stiffness and of its coarser levels."""
        return _bytes(self.K) + self.cycle.memory

    def solve(self, b: Array) -> Array:
        """Solutions (k, n) for right-hand sides in the rows of b (k, n)."""
        return np.stack([self.solve_one(row) for row in b])

    def solve_one(self, b: Array, rtol: float = TIGHT) -> Array:
        """Solution (n,) of one right-hand side, started from a known one if that has a smaller residual than zero."""
        size = np.linalg.norm(b)
        V = spla.LinearOperator(self.K.shape, matvec=lambda r: self.cycle(np.ravel(r)), dtype=float)
        x, left = np.zeros_like(b), size
        for known in self._last:
            if (norm := np.linalg.norm(b - self.K @ known)) < left:
                x, left = known, norm
        # a second pass on the true residual removes the error of the recurrence
        for _ in range(2):
            if left <= rtol * size:
                break
            step, info = spla.cg(
                self.K, b - self.K @ x, rtol=rtol * size / left, maxiter=MAX_ITERATIONS, M=V, callback=self._count
            )
            if info > 0:
                raise FecontactError(
                    f"Conjugate gradients with multigrid did not converge in {MAX_ITERATIONS} steps; "
                    "badly shaped elements slow it down: use a direct back-end."
                )
            x = x + step
            left = np.linalg.norm(b - self.K @ x)
        self.remember(x)
        return x

    def remember(self, x: Array) -> None:
        """Start later solutions from x (n,), too."""
        self._last = [x, *(known for known in self._last if known is not x)][:KEPT]

    def _count(self, _: Array) -> None:
        self.steps += 1


@dataclass(frozen=True, eq=False)
class Level:
    """One level of a cycle: its matrix A = L + D + U by halves, and the interpolation from the next level.

    From zero, a symmetric sweep of Gauss-Seidel is (D + L) y = b, (D + U) x = D y, and leaves the residual L (y - x);
    from other x the two steps share U x. Each needs one half of A (S. C. Eisenstat, SIAM J. Sci. Stat. Comput. 2
    (1981) 1): with the residual and two sweeps, three products' work instead of five.

    Attributes
    ----------
    lower, upper : csr_matrix
        D + L and D + U.
    P, R : csr_matrix
        The interpolation and its transpose.
    """

    lower: sp.csr_matrix
    upper: sp.csr_matrix
    P: sp.csr_matrix
    R: sp.csr_matrix

    @classmethod
    def of(cls, A: sp.csr_matrix, P: sp.csr_matrix, R: sp.csr_matrix) -> Level:
        """The level of a whole matrix."""
        return cls(_single(sp.tril(A, format="csr")), _single(sp.triu(A, format="csr")), _single(P), _single(R))

    @cached_property
    def D(self) -> NDArray[np.float32]:
        """The diagonal."""
        return np.asarray(self.lower.diagonal())

    @property
    def A(self) -> sp.csr_matrix:
        """The whole matrix."""
        return sp.csr_matrix(self.lower + self.upper - sp.diags_array(self.D, format="csr"))

    @property
    def matrices(self) -> tuple[sp.csr_matrix, ...]:
        """All that it keeps."""
        return self.lower, self.upper, self.P, self.R

    def product(self, X: sp.csr_matrix) -> sp.csr_matrix:
        """A X of a sparse matrix."""
        return sp.csr_matrix(self.lower @ X + self.upper @ X - sp.diags_array(self.D, format="csr") @ X)

    def correct(self, b: NDArray[np.float32], below: Smoother) -> NDArray[np.float32]:
        """Sweep, correct from the level below, sweep."""
        y = _substituted(self.lower, b, "forward")
        x = _substituted(self.upper, self.D * y, "backward")
        y -= x
        x += self.P @ below(self.R @ (self.lower @ y - self.D * y))
        w = self.upper @ x - self.D * x
        y = _substituted(self.lower, b - w, "forward")
        return _substituted(self.upper, w + self.D * y, "backward")


Smoother = Callable[[NDArray[np.float32]], NDArray[np.float32]]


def _substituted(T: sp.csr_matrix, b: NDArray[np.float32], sweep: str) -> NDArray[np.float32]:
    """T^-1 b for a triangle; zero where its diagonal is."""
    from pyamg.relaxation.relaxation import gauss_seidel

    x = np.zeros_like(b)
    gauss_seidel(T, x, b, sweep=sweep)
    return x


@dataclass(frozen=True, eq=False)
class Cycle:
    """One V-cycle of smoothed aggregation, in single precision: it need only be near the inverse.

    Attributes
    ----------
    levels : tuple of Level
    coarsest : csr_matrix
    """

    levels: tuple[Level, ...]
    coarsest: sp.csr_matrix

    @classmethod
    def of(cls, K: sp.csr_matrix, modes: Array) -> Cycle:
        """The cycle of K (n, n), symmetric and positive definite, with near-nullspace modes (n, k)."""
        import pyamg

        sizes = np.linalg.norm(modes, axis=0)
        every = pyamg.smoothed_aggregation_solver(
            K, B=modes / np.where(sizes > 0, sizes, 1.0), strength=("symmetric", {"theta": 0.0}), max_coarse=COARSEST,
            presmoother=None, postsmoother=None, coarse_solver="splu", improve_candidates=None,
        ).levels  # fmt: skip
        levels = tuple(Level.of(sp.csr_matrix(each.A), each.P, each.R) for each in every[:-1])
        return cls(levels, _single(every[-1].A))

    @classmethod
    def of_corners(cls, K: sp.csr_matrix, modes: Array, corners: IntArray, P: sp.csr_matrix) -> Cycle:
        """The same with the displacements (k,) of corners as next level, from which P (n, k) interpolates."""
        R = P.T.tocsr()
        below = cls.of(sp.csr_matrix(R @ (K @ P)), modes[corners])
        return cls((Level.of(K, P, R), *below.levels), below.coarsest)

    @cached_property
    def _solve(self) -> Callable[[Array], Array]:
        """Solution on the coarsest level; aggregates of one node leave zero rows."""
        A = sp.csc_matrix(self.coarsest, dtype=float)
        return spla.splu(A + sp.diags_array(np.full(A.shape[0], 1e-9 * A.diagonal().max()), format="csc")).solve

    @property
    def memory(self) -> int:
        """Bytes of the matrices of all levels."""
        return sum(_bytes(A) for level in self.levels for A in level.matrices) + _bytes(self.coarsest)

    @classmethod
    def side_by_side(cls, cycles: Sequence[Cycle]) -> Cycle:
        """The cycle of several bodies that do not touch; the shallower ones end in levels of one size."""
        if len(cycles) == 1:
            return cycles[0]
        depth = max(len(each.levels) for each in cycles)
        padded = []
        for each in cycles:
            one = sp.eye_array(each.coarsest.shape[0], dtype=np.float32, format="csr")
            padded.append([*each.levels, *[Level.of(each.coarsest, one, one)] * (depth - len(each.levels))])
        levels = tuple(
            Level(*(_beside(blocks) for blocks in zip(*(each.matrices for each in level), strict=True)))
            for level in zip(*padded, strict=True)
        )
        return cls(levels, _beside([each.coarsest for each in cycles]))

    def restricted(self, S: sp.csr_matrix, stiffness: sp.csr_matrix) -> Cycle:
        """The cycle of (I - S)^T K (I - S) + stiffness, with S (n, n) a projection that has few entries.

        Interpolation is restricted with it, so that the next levels change in a few entries: it costs a fifth of a new
        one and is as good.
        """
        if not self.levels:
            return Cycle((), self.coarsest - _change(self.coarsest @ S, S) + stiffness)
        first = self.levels[0]
        change = stiffness - _change(first.product(S), S)
        lower = _single(first.lower + sp.tril(change, format="csr"))
        upper = _single(first.upper + sp.triu(change, format="csr"))
        below = [level.A for level in self.levels[1:]] + [self.coarsest]
        E = S @ first.P
        AE, P = first.product(E), _single(first.P - E)
        X = first.R @ AE
        coarse = _single(below[0] - X - X.T + E.T @ AE)
        levels = [Level(lower, upper, P, P.T.tocsr())]
        for level in self.levels[1:]:
            levels.append(Level.of(coarse, level.P, level.R))
            coarse = _single(level.R @ coarse @ level.P)
        return Cycle(tuple(levels), coarse)

    def __call__(self, r: Array) -> Array:
        """Approximation (n,) of K^-1 r; linear and symmetric."""
        size = float(np.abs(r).max(initial=0.0))
        return size * self._down(0, (r / size).astype(np.float32)).astype(float) if size > 0 else np.zeros_like(r)

    def _down(self, k: int, b: NDArray[np.float32]) -> NDArray[np.float32]:
        if k == len(self.levels):
            return self._solve(b.astype(float)).astype(np.float32)
        return self.levels[k].correct(b, lambda r: self._down(k + 1, r))


def _single(A: sp.csr_matrix) -> sp.csr_matrix:
    """A matrix in single precision, with the same indices where it has rows."""
    A = sp.csr_matrix(A)
    return sp.csr_matrix((A.data.astype(np.float32), A.indices, A.indptr), shape=A.shape)


def _beside(blocks: Sequence[sp.csr_matrix]) -> sp.csr_matrix:
    return sp.csr_matrix(sp.block_diag(blocks, format="csr"))


def _change(AS: sp.csr_matrix, S: sp.csr_matrix) -> sp.csr_matrix:
    """A - (I - S)^T A (I - S) by A S, which has few entries."""
    return AS + AS.T - S.T @ AS


def _bytes(A: sp.csr_matrix) -> int:
    """Bytes of a sparse matrix."""
    return int(A.data.nbytes + A.indices.nbytes + A.indptr.nbytes)


def corner_space(mesh: Mesh) -> tuple[IntArray, sp.csr_matrix]:
    """The corner nodes (k,) and the weights (n_points, k) of trilinear functions on them at all nodes.

    A node on an edge, a face or in a cell gets the value of its cell's trilinear function there: the mean of the
    corners of that edge, face or cell. In degenerate cells repeated corners count as often as they occur; a mid-face
    node on three corners has a third of each.

    Examples
    --------
    >>> from fecontact.mesh.shapes import block
    >>> corners, weights = corner_space(block((1.0, 1.0, 1.0), (1, 1, 1), element="hex20"))
    >>> len(corners), weights.shape, weights.sum(axis=1).min() == weights.sum(axis=1).max() == 1.0
    (8, (20, 8), np.True_)
    """
    n_points, cells = len(mesh.points), mesh.cells
    corners = np.unique(cells[:, :8])
    local = hex_nodes(cells.shape[1])[8:]
    at = hex_shapes(8, local)[0] if len(local) else np.zeros((0, 8))
    others, first = np.unique(cells[:, 8:], return_index=True)
    kept = ~np.isin(others, corners)
    others, first = others[kept], first[kept]
    owner, place = np.divmod(first, max(cells.shape[1] - 8, 1))
    rows = [corners, np.repeat(others, 8)]
    columns = [corners, cells[owner, :8].ravel()]
    values = [np.ones(len(corners)), at[place].ravel()]
    if mesh.midface is not None:
        cell, face = np.nonzero(mesh.midface >= 0)
        ends = np.sort(cells[cell[:, None], FACES[face, :4]], axis=1)
        distinct = np.concatenate([np.ones((len(ends), 1), bool), ends[:, 1:] != ends[:, :-1]], axis=1)
        rows.append(np.repeat(mesh.midface[cell, face], distinct.sum(axis=1)))
        columns.append(ends[distinct])
        values.append(np.repeat(1.0 / distinct.sum(axis=1), distinct.sum(axis=1)))
    number = places_among(corners, n_points)
    entries = (np.concatenate(rows), number[np.concatenate(columns)])
    return corners, sp.csr_matrix((np.concatenate(values), entries), shape=(n_points, len(corners)))
