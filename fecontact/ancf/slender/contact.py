"""Contact of slender members, with rigid bodies and with each other: their skins, pairs of points, and friction.

The skin lies at a constant distance from the axis or middle surface, a radius or half a thickness; the gap of two
points is their distance less those of the skins. Every element of the slave has one multiplier, its mean gap over Gauss
points. A member that wraps a body is held in all its forms by more: with two for each element of a cable laid on a drum
(ends and middles, as the corners and sides of a brick's faces) pressures alternate between nothing and twice their
value; with one they are right to 1e-3.

Where another member crosses, the gap is that of the two points closest to each other (P. Wriggers & G. Zavarise,
Commun. Numer. Methods Eng. 13, 1997). Lines of contact are for small angles, points for large ones (C. Meier, W. A.
Wall & A. Popp, Comput. Methods Appl. Mech. Engrg. 315, 2017); which it is follows from the angle and from how much a
mean gap would leave open, see `crossings`. Ends of axes have a multiplier each, and touch as balls do.

With the coordinates u of points that move along members, the distance D(u, q) and its direction n = (x - y) / |x - y|,

    dg/dq = n . (dx - dy),    d2g/dq2 = D_qq - D_qu D_uu^-1 D_uq,

both exact, since D_u = 0.

Friction acts at the skin. A point of the skin is one of the axis and a fibre f to it, which moves with the section,

    f = c_x r_x + c_y r_y + c_z r_z         elements with three gradients; c is constant
    f = c_x r_x + c_y r_y + c_n n           two; n is the unit normal, dn = -a^k (n . dr_k) with the dual base a^k
    f = c_x r_x + g,  g . r_x = 0           one; g turns with the axis, dg = -r_x (g . dr_x) / |r_x|^2

and is none of their own coordinates. A line has no twist: a turn about its axis leaves its fibres where they are, and
friction across the axis has no moment about it. Over a finite turn from the tangent t to t' a fibre g becomes

    g - (g . t') / (1 + t . t') (t + t').
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, cast

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.slender.closest import Middle, closest_pairs
from fecontact.ancf.system.moving_contact import ContactConstraints, ContactGaps, Master, MovingSide
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import number
from fecontact.common.errors import InputError, SolverError
from fecontact.surfaces.facet_surface import Projection

if TYPE_CHECKING:
    from fecontact.ancf.slender.structure import Structure

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

#: Gauss points of an element along each of its axes.
POINTS = 6


def skin(
    middle: Middle, states: tuple[Array, Array], each: IntArray, local: Array, fibre: Array
) -> tuple[sp.csr_matrix, Array, Array]:
    """Points of the skin, their displacements by the coordinates, and where they were in an earlier state.

    Parameters
    ----------
    middle : Middle
    states : (then, now)
        Coordinates (n_dofs,) of all members.
    each, local : (n,) int array and (n, n_axes) array
        Elements, and coordinates on them.
    fibre : (n, 3) array
        From axis or middle surface to the skin, now.

    Returns
    -------
    rows : (3 n, n_dofs) csr_matrix
    then, now : (n, 3) arrays
    """
    first = len(middle.structure.shape.gradients)
    units = np.eye(3, dtype=int)[:first]
    N, D = middle.rows(each, local), np.stack([middle.rows(each, local, tuple(e)) for e in units], axis=1)
    vectors = [middle.part(q)[middle.structure.functions[each]] for q in states]
    (x0, g0), (x, g) = ((np.einsum("nf,nfi->ni", N, v), np.einsum("nkf,nfi->nki", D, v)) for v in vectors)
    turned, C = (_with_three, _with_two, _with_one)[3 - first](g0, g, fibre)
    values = N[:, :, None, None] * np.eye(3) + np.einsum("nkij,nkf->nfij", C, D)
    rows = _assembled(middle, each, values, len(states[0]))
    return rows, x0 + turned, x + fibre


def _with_three(g0: Array, g: Array, f: Array) -> tuple[Array, Array]:
    """Earlier fibres (n, 3) and their changes (n, k, 3, 3) by the gradients (n, k, 3)."""
    c = np.linalg.solve(g.swapaxes(1, 2), f[:, :, None])[:, :, 0]
    return np.einsum("nk,nki->ni", c, g0), c[:, :, None, None] * np.eye(3)


def _with_two(g0: Array, g: Array, f: Array) -> tuple[Array, Array]:
    (base, dual), (base0, _) = _frame(g), _frame(g0)
    c = np.einsum("nki,ni->nk", dual, f)
    C = c[:, :2, None, None] * np.eye(3)
    C -= c[:, 2, None, None, None] * dual[:, :2, :, None] * base[:, 2, None, None, :]
    return np.einsum("nk,nki->ni", c, base0), C


def _frame(g: Array) -> tuple[Array, Array]:
    """Two gradients (n, 2, 3) and the unit normal, and their dual base, (n, 3, 3) each."""
    across = np.cross(g[:, 0], g[:, 1])
    base = np.concatenate([g, (across / np.linalg.norm(across, axis=1, keepdims=True))[:, None]], axis=1)
    return base, np.linalg.inv(base).swapaxes(1, 2)


def _with_one(g0: Array, g: Array, f: Array) -> tuple[Array, Array]:
    a, a0 = g[:, 0], g0[:, 0]
    size = (a * a).sum(axis=1, keepdims=True)
    c = (f * a).sum(axis=1, keepdims=True) / size
    across = f - c * a
    t, t0 = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (a, a0))
    share = (across * t0).sum(axis=1, keepdims=True) / (1 + (t * t0).sum(axis=1, keepdims=True))
    C = c[:, :, None] * np.eye(3) - (a / size)[:, :, None] * across[:, None, :]
    return c * a0 + across - share * (t + t0), C[:, None]


def _assembled(middle: Middle, each: IntArray, values: Array, n_dofs: int) -> sp.csr_matrix:
    """Rows (3 n, n_dofs) of values (n, f, 3, 3): a component by the components of the vectors."""
    columns = middle.start + 3 * middle.structure.functions[each][:, :, None] + np.arange(3)
    across = values.transpose(0, 2, 1, 3)
    column = np.broadcast_to(columns[:, None], across.shape)
    row = np.arange(3 * len(values)).repeat(across[0, 0].size) if len(values) else np.zeros(0, np.int64)
    return sp.csr_matrix((across.ravel(), (row, column.ravel())), shape=(3 * len(values), n_dofs))


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
            "force. Take elements shorter than the distance of crossings.",
            code="crossed-twice",
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


@dataclass(frozen=True, eq=False)
class Skin(MovingSide):
    """Skin of some elements of a slender member, at a distance from axis or middle surface.

    Parameters
    ----------
    member : Structure
    offset : float
        A radius, or half a thickness.
    chosen : sequence of int, optional
        Elements that may touch; all unless given.

    Raises
    ------
    InputError
        For unknown elements, or an offset that is negative or not a number.
    """

    member: Structure
    offset: float
    chosen: Sequence[int] | None = None
    name: str = "skin"

    def __post_init__(self) -> None:
        if not 0 <= number(self.offset) < np.inf:
            raise InputError(f"offset must be a radius or half a thickness, zero or positive; found {self.offset!r}.")
        n, each = len(self.member.cells), self.elements
        if not len(each) or each[0] < 0 or each[-1] >= n:
            raise InputError(f"The {self.member.name} has {n} elements, counted from 0; found {self.chosen!r}.")

    @property
    def n_dofs(self) -> int:
        """Coordinates of the member."""
        return self.member.n_dofs

    @cached_property
    def elements(self) -> IntArray:
        """Sorted numbers (n,) of the elements that may touch."""
        given = np.arange(len(self.member.cells)) if self.chosen is None else np.asarray(self.chosen, dtype=np.int64)
        return np.unique(given)

    @property
    def middle(self) -> Middle:
        """Axis or middle surface, by coordinates of the member alone."""
        return Middle(self.member, 0)

    @property
    def named(self) -> tuple[IntArray, float]:
        """Elements and distance."""
        return self.elements, self.offset

    @property
    def thickness(self) -> float:
        """Infinite: what it touches has the other side."""
        return np.inf

    def constraints(self, master: Master, starts: tuple[int, int | None], q0: Array, mu: float) -> ContactConstraints:
        """Contact constraints with it as the slave, see `MovingSide.constraints`.

        Raises
        ------
        InputError
            For two offsets of zero, a plate as the slave of a line, and members that overlap by more than half the sum
            of their offsets.
        """
        first, other = starts
        if other is None:
            return SkinContact(self, master, first, None, len(q0), mu)
        skin = cast(Skin, master)
        if self.offset + skin.offset == 0:
            raise InputError("The offsets of two members are radii or half thicknesses, not both zero.")
        if self.middle.n_axes > skin.middle.n_axes:
            raise InputError(
                f"A {self.member.name} cannot be the slave of a {skin.member.name}: exchange slave and master."
            )
        contact = MemberContact(self, skin, first, other, len(q0), mu)
        overlap = -contact.at(q0).gap.min()
        if overlap > contact.reach / 2:
            raise InputError(
                f"Two members overlap by {overlap:.4g} at the start, more than half the sum of their offsets, "
                f"{contact.reach:.4g}: it is open on which side of each other they are. Move them apart.",
                code="initial-overlap",
            )
        return contact

    @cached_property
    def _rule(self) -> tuple[Array, Array]:
        """Gauss points (n, n_axes) of an element, and their weights (n,)."""
        x, w = np.polynomial.legendre.leggauss(POINTS)
        one, weights = (1 + x) / 2, w / 2
        if self.middle.n_axes == 1:
            return one[:, None], weights
        grid = np.stack(np.meshgrid(one, one, indexing="ij"), axis=-1).reshape(-1, 2)
        return grid, np.outer(weights, weights).ravel()

    @cached_property
    def points(self) -> tuple[IntArray, Array]:
        """Elements (n,) of the Gauss points and their coordinates (n, n_axes)."""
        local = self._rule[0]
        return self.elements.repeat(len(local)), np.tile(local, (len(self.elements), 1))

    def rows(self, each: IntArray, local: Array) -> sp.csr_matrix:
        """Values (n, n_functions) of all functions at coordinates (n, n_axes) on elements (n,)."""
        return self.middle.matrix(each, local)

    @cached_property
    def quadrature(self) -> tuple[sp.csr_matrix, sp.csr_matrix, Array]:
        """Rows N (n_points, n_functions), A (n, n_points), and areas or lengths (n,) of the elements."""
        N = self.rows(*self.points)
        A = sp.kron(sp.eye_array(len(self.elements)), self._rule[1][None], format="csr")
        return N, sp.csr_matrix(A), self.present_areas(self.member.q0)

    def present_areas(self, q: Array) -> Array:
        """Areas or lengths (n,) of the elements at coordinates q of the structure."""
        first = self.middle.at(q, *self.points)[1]
        size = np.linalg.norm(first[:, 0] if first.shape[1] == 1 else np.cross(first[:, 0], first[:, 1]), axis=1)
        return np.asarray(size.reshape(len(self.elements), -1) @ self._rule[1])

    def present(self, q: Array, name: str) -> None:
        """None: it has no faces."""

    def project(self, q: Array, points: Array) -> Projection:
        """Feet of points (n, 3) on the skin."""
        y = self.middle.at(q, *self.middle.project(q, points))[0]
        return self.seen(points, y, np.zeros(len(y), bool))

    def seen(self, x: Array, y: Array, hidden: Mask) -> Projection:
        """Projection of points (n, 3) whose closest points (n, 3) on the axis or middle surface are known."""
        w = x - y
        distance = np.linalg.norm(w, axis=1)
        normals = np.divide(w, distance[:, None], out=np.zeros_like(w), where=distance[:, None] > 0)
        return Projection(y + self.offset * normals, normals, distance - self.offset, hidden)

    @cached_property
    def widths(self) -> Array:
        """Lengths (n_multipliers,) on which multipliers act."""
        areas = self.quadrature[2]
        return areas ** (1 / self._rule[0].shape[1])


@dataclass(frozen=True, eq=False)
class SkinContact(ContactConstraints):
    """Contact of a slender member with a rigid body; friction acts at its skin."""

    slave: Skin

    def relative_displacement(
        self, part: ContactGaps, then: Array, now: Array, pose: Pose
    ) -> tuple[sp.csr_matrix, Array]:
        """Displacement of points of the skin against the rigid body, see `ContactConstraints.relative_displacement`."""
        fibre = -self.slave.offset * part.projection.normals
        middle = Middle(self.slave.member, self.slave_start)
        rows, before, after = skin(middle, (then, now), *self.slave.points, fibre)
        return rows, after - before - self.master.rigid_displacement(before, pose)


@dataclass(frozen=True, eq=False)
class MemberGaps(ContactGaps):
    """Contact conditions of two members at some coordinates.

    Attributes
    ----------
    pairs : Pairs
    q : (n_dofs,) array
    """

    pairs: Pairs
    q: Array


@dataclass(frozen=True, eq=False)
class MemberContact(ContactConstraints):
    """Contact of a member with another; multipliers of the slave's elements, then of ends of slave and master."""

    slave: Skin
    master: Skin
    master_start: int

    @cached_property
    def sides(self) -> Sides:
        """Slave and master."""
        return Middle(self.slave.member, self.slave_start), Middle(self.master.member, self.master_start)

    @cached_property
    def reach(self) -> float:
        """Distance of the axes or middle surfaces where the skins touch."""
        return self.slave.offset + self.master.offset

    @property
    def thickness(self) -> float:
        """Twice the distance at which the skins touch: nearer, axes pass each other."""
        return 2 * self.reach

    @cached_property
    def _ends(self) -> list[tuple[IntArray, Array]]:
        """Elements and coordinates (n, n_axes) of the ends of both axes; plates have none."""
        own, other = self.sides
        return [self._ends_of(own, self.slave.elements), self._ends_of(other, np.arange(len(other.structure.cells)))]

    @staticmethod
    def _ends_of(middle: Middle, elements: IntArray) -> tuple[IntArray, Array]:
        if middle.n_axes > 1:
            return np.zeros(0, np.int64), np.zeros((0, middle.n_axes))
        k, side = np.nonzero(middle.ends[elements])
        return elements[k], side[:, None].astype(float)

    @property
    def n_multipliers(self) -> int:
        """Elements of the slave, and ends."""
        return len(self.slave.elements) + sum(len(each) for each, _ in self._ends)

    @cached_property
    def areas(self) -> Array:
        """Lengths or areas (n_multipliers,) of elements; the element's length at an end."""
        ends = [m.structure.lengths[each, 0] for m, (each, _) in zip(self.sides, self._ends, strict=True)]
        return np.concatenate([self.slave.quadrature[2], *ends])

    def present_areas(self, q: Array) -> Array:
        """Lengths or areas (n_multipliers,) at coordinates q of all members; an element's initial length at an end."""
        own = super().present_areas(q)
        return np.concatenate([own, self.areas[len(own) :]])

    @cached_property
    def widths(self) -> Array:
        """Lengths (n_multipliers,) of elements, at least the distance of the axes."""
        own = self.slave.widths
        return np.maximum(np.concatenate([own, self.areas[len(own) :]]), self.reach)

    def at(self, q: Array) -> MemberGaps:
        """Gaps and gradients at coordinates q (n_dofs,) of all members."""
        along = facing(self.sides, q, *self.slave.points)
        crossed = along.chosen(np.zeros(0, np.int64))
        if all(m.n_axes == 1 for m in self.sides):
            crossed = crossings(self.sides, q, along, self.reach)
        pairs = joined([along, crossed, *self._at_ends(q)])
        projection = self.master.seen(*positions(self.sides, pairs, q), pairs.hidden)
        means = self._means(crossed.each[0], pairs.hidden)
        gap = means @ np.where(pairs.hidden, 0.0, projection.gap - self.slave.offset)
        gap[np.diff(means.indptr) == 0] = np.inf
        G = sp.csr_matrix(means @ self._rows(pairs, projection.normals))
        return MemberGaps(gap, G, projection, means, pairs, q)

    def _facing(self, q: Array, each: IntArray, local: Array) -> Projection:
        """Projection of points at coordinates (n, n_axes) on elements (n,) of the slave on the skin of the master."""
        pairs = facing(self.sides, q, each, local)
        return self.master.seen(*positions(self.sides, pairs, q), pairs.hidden)

    def _at_ends(self, q: Array) -> tuple[Pairs, Pairs]:
        """Ends of both axes, as balls; an end of the master that faces one of the slave is seen from there already."""
        own = facing(self.sides, q, *self._ends[0])
        other = facing(self.sides, q, *self._ends[1], of_master=True)
        twice = self.sides[0].at_end(other.each[0], other.local[0], AT_NODE)
        return replace(own, hidden=np.zeros(len(own.hidden), bool)), replace(other, hidden=twice)

    def _means(self, crossed: IntArray, hidden: Mask) -> sp.csr_matrix:
        """A (n_multipliers, n_pairs) without hidden pairs: means of elements, crossings in their place, and ends."""
        A = self.slave.quadrature[1]
        n, m = A.shape
        rows = np.searchsorted(self.slave.elements, crossed)
        whole = np.ones(n)
        whole[rows] = 0.0
        single = sp.csr_matrix((np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(n, len(rows)))
        ends = sp.eye_array(len(hidden) - m - len(rows))
        A = sp.block_diag([sp.hstack([sp.diags_array(whole) @ A, single]), ends], format="csr")
        A = sp.csr_matrix(A @ sp.diags_array((~hidden).astype(float)))
        A.eliminate_zeros()
        share = np.asarray(A.sum(axis=1)).ravel()
        return sp.csr_matrix(sp.diags_array(np.divide(1.0, share, where=share > 0, out=share * 0)) @ A)

    def _rows(self, pairs: Pairs, normals: Array) -> sp.csr_matrix:
        """Gradients (n_pairs, n_dofs) of the distances."""
        B, dofs = functions(self.sides, pairs)
        values = B[:, :, None] * normals[:, None, :]
        row = np.arange(len(B)).repeat(values[0].size)
        return sp.csr_matrix((values.ravel(), (row, dofs.ravel())), shape=(len(B), self.n_dofs))

    def relative_displacement(
        self, part: ContactGaps, then: Array, now: Array, pose: Pose
    ) -> tuple[sp.csr_matrix, Array]:
        """Displacement of points of the two skins against each other, and its gradient."""
        pairs, n = cast(MemberGaps, part).pairs, part.projection.normals
        reach = -self.slave.offset, self.master.offset
        (own, x0, x), (other, y0, y) = (
            skin(m, (then, now), e, u, r * n)
            for m, e, u, r in zip(self.sides, pairs.each, pairs.local, reach, strict=True)
        )
        return sp.csr_matrix(own - other), (x - x0) - (y - y0)

    def curvature(self, touching: ContactGaps, forces: Array) -> sp.csr_matrix | None:
        """Second derivative (n_dofs, n_dofs) of forces . gap; None where nothing presses."""
        pressing = touching.means.T @ forces
        used = np.flatnonzero(pressing)
        if not len(used):
            return None
        here = cast(MemberGaps, touching)
        H, dofs = second_derivatives(self.sides, here.pairs.chosen(used), here.q, here.projection.normals[used])
        H *= pressing[used, None, None]
        rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
        return sp.csr_matrix((H.ravel(), (rows.ravel(), columns.ravel())), shape=(self.n_dofs,) * 2)
