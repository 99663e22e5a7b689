"""Closest points between axes and middle surfaces of slender members.

The square of a distance is minimised over coordinates of elements, each from 0 to 1, by Newton's method with the
moduli of the eigenvalues of its Hessian, at once for all pairs. A pair may move on both members, or on one of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from fecontact.ancf.bricks.faces import SAME, TRIED, first_of_each
from fecontact.common.arrays import Array, IntArray, Mask

if TYPE_CHECKING:
    from fecontact.ancf.slender.structure import Structure

#: Places along each axis of an element from which the search begins.
SAMPLES = 5
MAX_ITERATIONS = 40
MAX_HALVINGS = 12
#: Change of a coordinate that ends the search: Newton's next one would be about its square.
STILL = 1e-9
#: Relative rise of a squared distance that is rounding.
RISE = 1e-12
#: Difference of a coordinate from its end that is rounding.
ROUNDING = 1e-14
#: Smallest eigenvalue of the Hessian that counts, relative to the squared length of an element.
FLAT = 1e-10
#: Corners of a plate's element at both ends of its sides y = 0, x = 1, y = 1, x = 0.
SIDES = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])


@dataclass(frozen=True, eq=False)
class Middle:
    """Axis of a line, strip or beam, or middle surface of a plate.

    Attributes
    ----------
    structure : Structure
    start : int
        Its first coordinate among those of all members.
    """

    structure: Structure
    start: int

    @property
    def n_axes(self) -> int:
        """One of a line, two of a plate."""
        return self.structure.n_along

    def part(self, q: Array) -> Array:
        """Vectors (n, 3) of its coordinates out of those of all members."""
        return q[self.start : self.start + self.structure.n_dofs].reshape(-1, 3)

    def rows(self, each: IntArray, local: Array, order: tuple[int, ...] = ()) -> Array:
        """Functions (n, n_functions) of elements (n,) at their coordinates (n, n_axes), or derivatives by these."""
        points, s = np.zeros((len(each), 3)), self.structure
        points[:, : self.n_axes] = local
        orders = (*order, 0, 0, 0)[:3]
        return s.rows_each(each, points, orders)  # type: ignore[arg-type]

    def at(self, q: Array, each: IntArray, local: Array) -> tuple[Array, Array, Array]:
        """Positions (n, 3), first (n, n_axes, 3) and second derivatives (n, n_axes, n_axes, 3) at coordinates q."""
        vectors = self.part(q)[self.structure.functions[each]]
        k = self.n_axes
        unit = np.eye(k, dtype=int)

        def value(order: tuple[int, ...]) -> Array:
            return np.asarray(np.einsum("nf,nfi->ni", self.rows(each, local, order), vectors))

        first = np.stack([value(tuple(e)) for e in unit], axis=1)
        second = np.stack([np.stack([value(tuple(e + f)) for e in unit], axis=1) for f in unit], axis=1)
        return value(()), first, second

    @cached_property
    def _samples(self) -> tuple[sp.csr_matrix, IntArray, Array]:
        t = (np.arange(SAMPLES) + 0.5) / SAMPLES
        grid = np.stack(np.meshgrid(*[t] * self.n_axes, indexing="ij"), axis=-1).reshape(-1, self.n_axes)
        n = len(self.structure.cells)
        each, local = np.arange(n).repeat(len(grid)), np.tile(grid, (n, 1))
        return self.matrix(each, local), each, local

    def matrix(self, each: IntArray, local: Array) -> sp.csr_matrix:
        """Values (n, n_vectors) of all functions."""
        values, columns = self.rows(each, local), self.structure.functions[each]
        row = np.arange(len(each)).repeat(values.shape[1])
        shape = (len(each), self.structure.n_dofs // 3)
        return sp.csr_matrix((values.ravel(), (row, columns.ravel())), shape=shape)

    @cached_property
    def ends(self) -> Mask:
        """Whether an element (n, 2) of a line ends its axis; whether a side (n, 4) of a plate's is at the rim."""
        cells = self.structure.cells
        if self.n_axes == 1:
            return np.asarray(np.bincount(cells.ravel())[cells] == 1)
        sides = np.sort(cells[:, SIDES].reshape(-1, 2), axis=1)
        number = np.unique(sides, axis=0, return_inverse=True)[1].reshape(-1, 4)
        return np.asarray(np.bincount(number.ravel())[number] == 1)

    def at_end(self, each: IntArray, local: Array, within: float = 0.0) -> Mask:
        """Whether coordinates (n, n_axes) lie at the end of an axis, or at the rim, but for a difference."""
        low, high = (local <= within).T, (local >= 1 - within).T
        at = np.stack([low[0], high[0]] if self.n_axes == 1 else [low[1], high[0], high[1], low[0]], axis=1)
        return np.asarray((at & self.ends[each]).any(axis=1))

    def project(self, q: Array, points: Array) -> tuple[IntArray, Array]:
        """Elements (n,) and coordinates (n, n_axes) of the closest points of points (n, 3)."""
        rows, each, where = self._samples
        k = min(4 * TRIED, len(each))
        near = cKDTree(rows @ self.part(q)).query(points, k=k)[1].reshape(len(points), k)
        start = np.take_along_axis(near, first_of_each(each[near]), axis=1)
        n = start.shape[1]
        found = closest(self, q, each[start.ravel()], where[start.ravel()], np.repeat(points, n, axis=0))
        foot = self.at(q, each[start.ravel()], found)[0].reshape(len(points), n, 3)
        distance = np.linalg.norm(foot - points[:, None], axis=2)
        # an element must be nearer by more than rounding: a closest point on a common node belongs to the first
        best = np.argmax(distance <= distance.min(axis=1, keepdims=True) * (1 + SAME), axis=1)
        kept = np.arange(len(points)) * n + best
        return each[start.ravel()[kept]], found[kept]


def closest(one: Middle, q: Array, each: IntArray, local: Array, points: Array) -> Array:
    """Coordinates (n, n_axes) on elements (n,) of a member that are closest to points (n, 3).

    Parameters
    ----------
    one : Middle
    q : (n_dofs,) array
        Coordinates of all members.
    each : (n,) int array
    local : (n, n_axes) array
        Where the search begins.
    points : (n, 3) array

    Examples
    --------
    >>> from fecontact.ancf.slender import line, straight
    >>> bar = line(straight((0, 0, 0), (2, 0, 0), 2), EA=1.0, EI=1.0)
    >>> middle = Middle(bar, 0)
    >>> closest(middle, bar.q0, np.array([1, 1]), np.full((2, 1), 0.5), np.array([[1.3, 1, 0], [9, 0, 0]])).round(9)
    array([[0.3],
           [1. ]])
    """

    def distance(p: Array, kept: IntArray) -> tuple[Array, Array, Array]:
        y, t, c = one.at(q, each[kept], p)
        w = y - points[kept]
        H = t @ t.swapaxes(1, 2) + np.einsum("nabi,ni->nab", c, w)
        return (w * w).sum(axis=1) / 2, np.einsum("nai,ni->na", t, w), H

    return _minimised(distance, local)


def closest_pairs(sides: tuple[Middle, Middle], q: Array, each: tuple[IntArray, IntArray], local: Array) -> Array:
    """Coordinates (n, 2) on elements of two lines that are closest to each other, from a start (n, 2)."""
    one, other = sides

    def distance(p: Array, kept: IntArray) -> tuple[Array, Array, Array]:
        x, t, c = one.at(q, each[0][kept], p[:, :1])
        y, u, d = other.at(q, each[1][kept], p[:, 1:])
        w, both = x - y, np.stack([t[:, 0], -u[:, 0]], axis=1)
        H = both @ both.swapaxes(1, 2)
        H[:, 0, 0] += (c[:, 0, 0] * w).sum(axis=1)
        H[:, 1, 1] -= (d[:, 0, 0] * w).sum(axis=1)
        return (w * w).sum(axis=1) / 2, np.einsum("nai,ni->na", both, w), H

    return _minimised(distance, local)


def _minimised(distance: Callable[[Array, IntArray], tuple[Array, Array, Array]], start: Array) -> Array:
    """Coordinates (n, k) from 0 to 1 at a local minimum of functions with their gradients and Hessians."""
    p, left = np.array(start, dtype=float), np.arange(len(start))
    value, slope, H = distance(p, left)
    for _ in range(MAX_ITERATIONS):
        step = _descent(p[left], slope, H)
        share, trial = np.ones(len(left)), distance(p[left] + step, left)
        for _ in range(MAX_HALVINGS):
            worse = trial[0] > value * (1 + RISE)
            if not worse.any():
                break
            share[worse] /= 2
            trial = distance(p[left] + share[:, None] * step, left)
        before, step = p[left], share[:, None] * step
        p[left] = _rounded(before + step)
        # what has just come to an end goes on along the other coordinate
        moving = (np.abs(step).max(axis=1) > STILL) | (_at_bound(p[left]) & ~_at_bound(before)).any(axis=1)
        left, (value, slope, H) = left[moving], (part[moving] for part in trial)
        if not len(left):
            break
    return p


def _descent(p: Array, slope: Array, H: Array) -> Array:
    """Newton's steps (n, k) from coordinates (n, k), up to where the first of them would leave the element."""
    held = ((p <= 0) & (slope > 0)) | ((p >= 1) & (slope < 0))
    size = np.trace(np.abs(H), axis1=1, axis2=2)[:, None, None]
    for _ in range(p.shape[1]):
        free = ~held[:, :, None] & ~held[:, None, :]
        values, vectors = np.linalg.eigh(np.where(free, H, size * np.eye(p.shape[1])))
        bounded = np.maximum(np.abs(values), FLAT * size[:, 0])
        step = -np.einsum("nij,nj,nkj,nk->ni", vectors, 1 / bounded, vectors, np.where(held, 0.0, slope))
        held |= ((p <= 0) & (step < 0)) | ((p >= 1) & (step > 0))
    step[held] = 0.0
    room = np.divide(np.where(step > 0, 1 - p, p), np.abs(step), out=np.ones_like(p), where=step != 0)
    return np.asarray(step * np.minimum(room.min(axis=1, keepdims=True), 1.0))


def _rounded(p: Array) -> Array:
    """Coordinates that are at an end of their element but for rounding, at it."""
    return np.where(p < ROUNDING, 0.0, np.where(p > 1 - ROUNDING, 1.0, p))


def _at_bound(p: Array) -> Mask:
    return np.asarray((p == 0) | (p == 1))
