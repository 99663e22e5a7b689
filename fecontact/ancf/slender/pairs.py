"""Pairs of points of two slender members that face each other, and the derivatives of their distance.

A point of one member faces the closest one of the other; at a crossing both are closest to each other. With the
positions u of the points that move, the distance D(u, q) and its direction n = (x - y) / |x - y|,

    dg/dq = n . (dx - dy),    d2g/dq2 = D_qq - D_qu D_uu^-1 D_uq,

both exact, since D_u = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fecontact.ancf.slender.closest import Middle, closest_pairs
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import SolverError

#: Sine of the angle above which two axes cross.
STEEP = 0.2
#: Mean over an element beyond the least distance, relative to it, above which they cross at smaller angles, too.
GROWTH = 0.01
#: Cosine between the line of closest points and an axis that is rounding.
UPRIGHT = 1e-6
#: Difference of an element's coordinate from its end that is rounding.
AT_NODE = 1e-7
#: Distance beyond an end, relative to an element, that is rounding.
BEYOND = 1e-6
#: Searches for a crossing, each on the element of the master that is closest to where the last one ended.
ROUNDS = 3
#: Difference of an element's coordinate between two crossings.
APART = 1e-3

#: Slave and master.
Sides = tuple[Middle, Middle]


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of points of a slave and a master.

    Attributes
    ----------
    each : (2, n) int array
        Elements of the slave and of the master.
    local : pair of (n, n_axes) arrays
        Coordinates on them.
    moves : (2, n) bool array
        Whether the points of slave and master move on them.
    hidden : (n,) bool array
        Whether a point faces nothing, as it is beyond an end or a rim.
    """

    each: IntArray
    local: tuple[Array, Array]
    moves: Mask
    hidden: Mask

    def chosen(self, kept: IntArray) -> Pairs:
        """Some of the pairs."""
        one, other = self.local
        return Pairs(self.each[:, kept], (one[kept], other[kept]), self.moves[:, kept], self.hidden[kept])


def joined(parts: Sequence[Pairs]) -> Pairs:
    """All pairs of several."""
    one, other = (np.concatenate([p.local[k] for p in parts]) for k in (0, 1))
    each, moves = (np.concatenate([getattr(p, name) for p in parts], axis=1) for name in ("each", "moves"))
    return Pairs(each, (one, other), moves, np.concatenate([p.hidden for p in parts]))


def positions(sides: Sides, pairs: Pairs, q: Array) -> tuple[Array, Array]:
    """Positions (n, 3) of the points of slave and master at coordinates q of all members."""
    one, other = (m.at(q, e, u)[0] for m, e, u in zip(sides, pairs.each, pairs.local, strict=True))
    return one, other


def facing(sides: Sides, q: Array, each: IntArray, local: Array, of_master: bool = False) -> Pairs:
    """Points on elements (n,) of the slave, or of the master, and the closest ones of the other member."""
    here, there = sides[::-1] if of_master else sides
    x = here.at(q, each, local)[0]
    other, foot = there.project(q, x)
    y, t, _ = there.at(q, other, foot)
    size = (t * t).sum(axis=2)
    beyond = np.abs(np.einsum("nai,ni->na", t, x - y)) > BEYOND * size
    hidden = there.at_end(other, foot) & beyond.any(axis=1)
    numbers, places = np.stack([each, other]), (local, foot)
    moves = np.stack([np.zeros(len(each), bool), np.ones(len(each), bool)])
    if of_master:
        return Pairs(numbers[::-1], places[::-1], moves[::-1], hidden)
    return Pairs(numbers, places, moves, hidden)


def crossings(sides: Sides, q: Array, along: Pairs, reach: float) -> Pairs:
    """Crossings of two lines, one at most in every element of the slave.

    Parameters
    ----------
    sides : (Middle, Middle)
    q : (n_dofs,) array
    along : Pairs
        Points along the slave's elements, element by element, and what they face.
    reach : float
        Distance of the axes where their skins touch.

    Raises
    ------
    SolverError
        If an element touches at two crossings.
    """
    start = _starts(sides, q, along, reach)
    one, other = along.each[:, start].copy()
    local = np.column_stack([u[start] for u in along.local])
    for _ in range(ROUNDS):
        local = closest_pairs(sides, q, (one, other), local)
        ended = np.flatnonzero((local[:, 1] <= 0) | (local[:, 1] >= 1))
        if not len(ended):
            break
        x = sides[0].at(q, one[ended], local[ended, :1])[0]
        other[ended], local[ended, 1:] = sides[1].project(q, x)
    moves = np.ones((2, len(start)), bool)
    every = Pairs(np.stack([one, other]), (local[:, :1], local[:, 1:]), moves, np.zeros(len(start), bool))
    return every.chosen(_kept(sides, q, every, reach))


def _starts(sides: Sides, q: Array, along: Pairs, reach: float) -> IntArray:
    """Points that are nearer than their neighbours in the element, where it may touch."""
    x, y = positions(sides, along, q)
    numbers = along.each[0]
    d, n = np.linalg.norm(x - y, axis=1), int(np.count_nonzero(numbers == numbers[0]))
    d = d.reshape(-1, n)
    least = np.ones(d.shape, bool)
    least[:, 1:] &= d[:, 1:] <= d[:, :-1]
    least[:, :-1] &= d[:, :-1] <= d[:, 1:]
    near = d.min(axis=1) < reach + 2 * sides[0].structure.lengths[numbers[::n], 0]
    return np.flatnonzero(least & near[:, None])


def _kept(sides: Sides, q: Array, pairs: Pairs, reach: float) -> IntArray:
    """Numbers of the pairs that are crossings: upright on both axes, not at their ends, the closest of an element."""
    (x, t, _), (y, u, _) = (m.at(q, e, v) for m, e, v in zip(sides, pairs.each, pairs.local, strict=True))
    w, t, u = x - y, t[:, 0], u[:, 0]
    distance, size, other_size = (np.linalg.norm(v, axis=1) for v in (w, t, u))
    sine = np.linalg.norm(np.cross(t, u), axis=1) / (size * other_size)
    good = (sine > STEEP) | ((size * sine) ** 2 / 24 > GROWTH * reach**2)
    for m, e, v, along, length in zip(sides, pairs.each, pairs.local, (t, u), (size, other_size), strict=True):
        good &= ~m.at_end(e, v, AT_NODE) & (np.abs((w * along).sum(axis=1)) <= UPRIGHT * length * distance)
    # at a node it belongs to the element that begins there
    one, at = pairs.each[0], pairs.local[0][:, 0]
    good &= at < 1 - AT_NODE
    order = np.lexsort([distance, one])
    order = order[good[order]]
    kept = order[np.unique(one[order], return_index=True)[1]]
    others = np.setdiff1d(order, kept)
    nearest = kept[np.searchsorted(one[kept], one[others])]
    second = others[(np.abs(at[others] - at[nearest]) > APART) & (distance[others] < reach)]
    if len(second):
        raise SolverError(
            f"Element {one[second[0]]} of a member is crossed in two places and touches at both, and has one contact "
            "force. Take elements shorter than the distance of crossings."
        )
    return np.asarray(kept)


def functions(sides: Sides, pairs: Pairs, by: int | None = None) -> tuple[Array, IntArray]:
    """Functions (n, f) of x - y by the vectors of both members, and the coordinates (n, f, 3) these are.

    With `by`, their derivatives by that coordinate of the elements, the slave's first.
    """
    values, dofs, count = [], [], 0
    for m, e, u, sign in zip(sides, pairs.each, pairs.local, (1.0, -1.0), strict=True):
        order = tuple(int(count + k == by) for k in range(m.n_axes))
        rows = m.rows(e, u, order)
        values.append(sign * rows if by is None or any(order) else np.zeros_like(rows))
        dofs.append(m.start + 3 * m.structure.functions[e][:, :, None] + np.arange(3))
        count += m.n_axes
    return np.concatenate(values, axis=1), np.concatenate(dofs, axis=1)


def second_derivatives(sides: Sides, pairs: Pairs, q: Array, n: Array) -> tuple[Array, IntArray]:
    """Second derivatives (n, d, d) of the distances with directions (n, 3), and the coordinates (n, d) they are by."""
    (x, t, c), (y, u, e) = (m.at(q, k, v) for m, k, v in zip(sides, pairs.each, pairs.local, strict=True))
    B, dofs = functions(sides, pairs)
    a, k, d = t.shape[1], t.shape[1] + u.shape[1], 3 * B.shape[1]
    across = (np.eye(3) - n[:, :, None] * n[:, None, :]) / np.linalg.norm(x - y, axis=1)[:, None, None]
    by = np.concatenate([t, -u], axis=1)
    H = np.einsum("na,nb,nij->naibj", B, B, across).reshape(len(n), d, d)
    mixed = np.einsum("nuj,nij,nb->nubi", by, across, B)
    mixed += np.stack([functions(sides, pairs, j)[0][:, :, None] * n[:, None, :] for j in range(k)], axis=1)
    D = by @ across @ by.swapaxes(1, 2)
    D[:, :a, :a] += np.einsum("nabi,ni->nab", c, n)
    D[:, a:, a:] -= np.einsum("nabi,ni->nab", e, n)
    # what is at an end of its element stays there
    moves = np.concatenate(
        [m[:, None] & (v > 0) & (v < 1) for m, v in zip(pairs.moves, pairs.local, strict=True)], axis=1
    )
    D = np.where(moves[:, :, None] & moves[:, None, :], D, np.eye(k))
    mixed = (mixed * moves[:, :, None, None]).reshape(len(n), k, d)
    return H - mixed.swapaxes(1, 2) @ np.linalg.solve(D, mixed), dofs.reshape(len(n), d)
