"""Contact of slender members: multipliers along the axis of a line or on the middle surface of a plate.

The skin lies at a constant distance from the axis or middle surface, a radius or half a thickness; the gap is that of
the axis less this distance. Friction acts at the skin, see `lever`.

Every element has one multiplier, its mean gap. A member that wraps a body is held in all its forms by more: with two
for each element of a cable laid on a drum (ends and middles, as the corners and sides of a brick's faces) pressures
alternate between nothing and twice their value; with one they are right to 1e-3.

Points of the skin of slender members: where friction acts, at a lever from axis or middle surface.

A point of the skin is one of the axis and a fibre f to it, which moves with the section,

    f = c_x r_x + c_y r_y + c_z r_z         elements with three gradients; c is constant
    f = c_x r_x + c_y r_y + c_n n           two; n is the unit normal, dn = -a^k (n . dr_k) with the dual base a^k
    f = c_x r_x + g,  g . r_x = 0           one; g turns with the axis, dg = -r_x (g . dr_x) / |r_x|^2

and is none of their own coordinates. A line has no twist: a turn about its axis leaves its fibres where they are, and
friction across the axis has no moment about it. Over a finite turn from the tangent t to t' a fibre g becomes

    g - (g . t') / (1 + t . t') (t + t').
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.slender.closest import Middle
from fecontact.ancf.slender.structure import Structure
from fecontact.ancf.system.moving_contact import ContactConstraints, ContactGaps, RigidMaster
from fecontact.bodies.pose import Pose
from fecontact.bodies.rigid import RigidBody
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import number
from fecontact.common.errors import InputError


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


#: Gauss points of an element along each of its axes.
POINTS = 6


@dataclass(frozen=True, eq=False)
class Trace:
    """Axis or middle surface of some elements of a structure, with the distance of its skin.

    Parameters
    ----------
    structure : Structure
    elements : (n,) int array
    offset : float
    """

    structure: Structure
    elements: IntArray
    offset: float

    @property
    def named(self) -> tuple[IntArray, float]:
        """Elements and distance."""
        return self.elements, self.offset

    @property
    def thickness(self) -> float:
        """Infinite: what it touches has the other side."""
        return np.inf

    @cached_property
    def _rule(self) -> tuple[Array, Array]:
        """Gauss points (n, n_axes) of an element, and their weights (n,)."""
        x, w = np.polynomial.legendre.leggauss(POINTS)
        one, weights = (1 + x) / 2, w / 2
        if len(self.structure.shape.nodes) == 2:
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
        return Middle(self.structure, 0).matrix(each, local)

    @cached_property
    def quadrature(self) -> tuple[sp.csr_matrix, sp.csr_matrix, Array]:
        """Rows N (n_points, n_functions), A (n, n_points), and areas or lengths (n,) of the elements."""
        s, each, (grid, weights) = self.structure, self.elements, self._rule
        N = self.rows(*self.points)
        A = sp.kron(sp.eye_array(len(each)), weights[None], format="csr")
        return N, sp.csr_matrix(A), np.prod(s.lengths[each, : grid.shape[1]], axis=1)

    def present_areas(self, q: Array) -> Array:
        """Areas or lengths (n,) of the elements at coordinates q of the structure."""
        first = Middle(self.structure, 0).at(q, *self.points)[1]
        size = np.linalg.norm(first[:, 0] if first.shape[1] == 1 else np.cross(first[:, 0], first[:, 1]), axis=1)
        return np.asarray(size.reshape(len(self.elements), -1) @ self._rule[1])

    def present(self, q: Array, name: str) -> None:
        """None: it has no faces."""

    @cached_property
    def widths(self) -> Array:
        """Lengths (n_multipliers,) on which multipliers act."""
        areas = self.quadrature[2]
        return areas ** (1 / self._rule[0].shape[1])


@dataclass(frozen=True, eq=False)
class SlenderContact(ContactConstraints):
    """Contact of a slender member with a rigid body; friction acts at its skin."""

    slave: Trace
    master: RigidMaster

    def relative_displacement(
        self, part: ContactGaps, then: Array, now: Array, pose: Pose
    ) -> tuple[sp.csr_matrix, Array]:
        """Displacement of points of the skin against the rigid body, see `ContactConstraints.relative_displacement`."""
        fibre = -self.slave.offset * part.projection.normals
        middle = Middle(self.slave.structure, self.slave_start)
        rows, before, after = skin(middle, (then, now), *self.slave.points, fibre)
        return rows, after - before - self.master.rigid_displacement(before, pose)


def touching(
    structures: Sequence[Structure],
    number_of: int,
    body: RigidBody,
    *,
    offset: float = 0.0,
    friction: float = 0.0,
    elements: Sequence[int] | None = None,
) -> SlenderContact:
    """Contact of one of several structures with a rigid body.

    Parameters
    ----------
    structures : sequence of Structure
        All members of the assembly, in order.
    number_of : int
        The one that touches, counted from 0.
    body : RigidBody
    offset : float
        Distance of its skin from the axis or middle surface: a radius, or half a thickness.
    friction : float
        Coulomb's coefficient; `inf` for a rough surface.
    elements : sequence of int, optional
        Elements that may touch; all unless given.

    Raises
    ------
    InputError
        For unknown structures or elements, or an offset that is negative or not a number.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.ancf.slender import line, straight
    >>> cable = line(straight((0, 0, 0.1), (1, 0, 0.1), 4), EA=1.0, EI=1.0)
    >>> contact = touching([cable], 0, fc.RigidBody(fc.Plane()), offset=0.1)
    >>> contact.n_multipliers, float(abs(contact.at(cable.q0).gap).max().round(12))
    (4, 0.0)
    """
    if not 0 <= number_of < len(structures):
        raise InputError(f"There are {len(structures)} structures, counted from 0; found {number_of}.", code="unknown")
    if not 0 <= number(offset) < np.inf:
        raise InputError(f"offset must be a radius or half a thickness, zero or positive; found {offset!r}.")
    s = structures[number_of]
    chosen = chosen_elements(s, number_of, elements)
    start = sum(each.n_dofs for each in structures[:number_of])
    n_dofs = sum(each.n_dofs for each in structures)
    return SlenderContact(Trace(s, chosen, float(offset)), start, RigidMaster(body), n_dofs, friction)


def chosen_elements(s: Structure, number_of: int, elements: Sequence[int] | None) -> IntArray:
    """Sorted numbers (n,) of the elements given, or of all; a structure is named by its number in errors."""
    chosen = np.arange(len(s.cells)) if elements is None else np.unique(np.asarray(elements, dtype=np.int64))
    if not len(chosen) or chosen[0] < 0 or chosen[-1] >= len(s.cells):
        raise InputError(f"Structure {number_of} has {len(s.cells)} elements, counted from 0; found {elements!r}.")
    return chosen
