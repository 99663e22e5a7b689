"""Planar corotational beam, a baseline: small deformation in a frame that moves with the chord of each element.

A node has two coordinates of position and the angle of its section, (x, y, a). With the chord's present length l and
angle b, an element of initial length L deforms by u = l - L and the turns t1 = a1 - b, t2 = a2 - b; its energy is one
of these three alone, so that rigid motions are exact.

'1986'   linear beam in u and the pseudo-vectors w = 2 sin(t/2) in place of the turns, 1 % off at 30 degrees
         (C. C. Rankin & F. A. Brogan, J. Press. Vessel Technol. 108, 1986, as in Campanelli, Berzeri & Shabana 1999,
         eq. 10 and 11)
'modern' turns as they are, and the stretch of a shallow arch, u/L + (2 t1^2 - t1 t2 + 2 t2^2)/30
         (T.-N. Le, J.-M. Battini & M. Hjiaj, Comput. Struct. 89, 2011, section 2; frame and tangent: M. A. Crisfield,
         Non-linear Finite Element Analysis of Solids and Structures 1, 1991, section 7.3)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.ancf.slender.structure import BETWEEN, Nodal, axes_of
from fecontact.ancf.system.member import Drawing
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, lengths
from fecontact.common.errors import InputError

#: Bending of a linear beam by its end turns, over EI / L.
BENDING = np.array([[4.0, 2.0], [2.0, 4.0]])
#: Second derivative of 30 times the stretch of a shallow arch by its end turns.
ARCH = np.array([[4.0, -1.0], [-1.0, 4.0]])


@dataclass(frozen=True, eq=False)
class CorotationalBeam(Nodal):
    """A straight beam along nodes in order, in the plane x, y.

    Supports and joints take (x, y, angle) as the one vector of a node: a pin holds the directions x and y of it.

    Parameters
    ----------
    points : (n, 3) array, or a sequence of them
        With z = 0, of one axis or of several: bars that joints may tie.
    EA, EI : float
        Rigidities of stretch and bending.
    mass_per_length, rotary : float
        Mass, and moment of inertia of the section, per length. Positions between nodes count as linear in the mass,
        which so is constant; it is exact for rigid motions.
    procedure : {'modern', '1986'}

    Raises
    ------
    InputError
        For an axis that is not straight or not in the plane, or numbers that do not fit.

    Examples
    --------
    >>> beam = CorotationalBeam([(0, 0, 0), (1, 0, 0), (2, 0, 0)], EA=100.0, EI=1.0)
    >>> turned = [0, 0, 2.0, np.cos(2), np.sin(2), 2.0, 2 * np.cos(2), 2 * np.sin(2), 2.0]
    >>> bool(abs(beam.forces(np.array(turned))).max() < 1e-12)
    True
    """

    points: ArrayLike | Sequence[ArrayLike]
    EA: float
    EI: float
    mass_per_length: float = 0.0
    rotary: float = 0.0
    procedure: str = "modern"

    def __post_init__(self) -> None:
        lengths(EA=self.EA, EI=self.EI)
        if not (self.mass_per_length >= 0 and self.rotary >= 0):
            raise InputError(
                f"Masses cannot be negative; found mass_per_length {self.mass_per_length!r}, rotary {self.rotary!r}.",
                code="negative-mass",
            )
        among("procedure", self.procedure, ("modern", "1986"))
        if np.abs(self._nodes[:, 2]).max() > 0:
            raise InputError("A corotational beam lies in the plane x, y: give points with z = 0.", code="not-in-plane")

    @cached_property
    def _axis(self) -> tuple[Array, Array, IntArray, Array]:
        return axes_of(self.points, None)

    @property
    def _nodes(self) -> Array:
        return self._axis[0]

    @property
    def cells(self) -> IntArray:
        """Nodes (n_elements, 2) of each element."""
        return self._axis[2]

    @property
    def lengths(self) -> Array:
        """Initial lengths (n_elements,)."""
        return self._axis[3]

    @cached_property
    def vectors(self) -> Array:
        """Initial (x, y, angle) of each node (n_nodes, 1, 3)."""
        t = self._axis[1]
        out = self._nodes.copy()
        out[:, 2] = np.arctan2(t[:, 1], t[:, 0])
        return out[:, None]

    @property
    def name(self) -> str:
        """Of its elements."""
        return "corotational beam"

    @property
    def extent(self) -> float:
        """Largest extent of its nodes."""
        return float(np.ptp(self._nodes, axis=0).max())

    @cached_property
    def scales(self) -> Array:
        """Factors (n_dofs,) that turn changes of coordinates into lengths: an element's length for angles."""
        return np.tile([1.0, 1.0, float(self.lengths.mean())], len(self._nodes))

    def positions(self, q: Array) -> Array:
        """Nodes (n_nodes, 3)."""
        return q.reshape(-1, 3) * [1.0, 1.0, 0.0]

    def angles(self, q: Array) -> Array:
        """Angles (n_nodes,) of the sections, beyond a full turn too."""
        return q.reshape(-1, 3)[:, 2]

    def translation(self, direction: Array) -> Array:
        """Change (n_dofs,) of the coordinates by a translation (3,); what leaves the plane is none."""
        return np.tile([direction[0], direction[1], 0.0], len(self._nodes))

    @property
    def rigid_modes(self) -> Array:
        """Changes (n_dofs, 6) by rigid motions about the middle; those out of the plane are none."""
        arm = self._nodes - self._nodes.mean(axis=0)
        modes = np.zeros((len(arm), 3, 6))
        modes[:, 0, 0] = modes[:, 1, 1] = modes[:, 2, 5] = 1.0
        modes[:, :2, 5] = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        return modes.reshape(self.n_dofs, 6)

    @cached_property
    def _dofs(self) -> IntArray:
        """Coordinates (n_elements, 6) of each element."""
        return (3 * self.cells[:, :, None] + np.arange(3)).reshape(-1, 6)

    def _frames(self, q: Array) -> tuple[Array, Array, Array, Array]:
        """Deformations (n, 3), lengths (n,), and the changes (n, 6) of length and of angle times length."""
        nodes = q.reshape(-1, 3)
        start, end = nodes[self.cells.T]
        chord = (end - start)[:, :2]
        size = np.hypot(*chord.T)
        (c, s), zero = chord.T / size, np.zeros(len(size))
        angle = np.arctan2(s, c)
        turns = np.stack([start[:, 2] - angle, end[:, 2] - angle], axis=1)
        turns -= 2 * np.pi * np.round(turns / (2 * np.pi))
        along = np.stack([-c, -s, zero, c, s, zero], axis=1)
        across = np.stack([s, -c, zero, -s, c, zero], axis=1)
        return np.column_stack([size - self.lengths, turns]), size, along, across

    def local_turns(self, q: Array) -> Array:
        """Turns (n_elements, 2) of the end sections against the chord; the procedure of 1986 wants them below 30°."""
        return self._frames(q)[0][:, 1:]

    def _local(self, e: Array) -> tuple[Array, Array, Array]:
        """Energies (n,), forces (n, 3) and tangents (n, 3, 3) by the deformations (n, 3)."""
        L, u, t = self.lengths, e[:, 0], e[:, 1:]
        C = np.zeros((len(e), 3, 3))
        stiff = self.EI / L
        if self.procedure == "1986":
            w, slope = 2 * np.sin(t / 2), np.cos(t / 2)
            moments = stiff[:, None] * (w @ BENDING)
            energy = (moments * w).sum(axis=1) / 2 + self.EA / L * u**2 / 2
            forces = np.column_stack([self.EA / L * u, moments * slope])
            C[:, 0, 0] = self.EA / L
            C[:, 1:, 1:] = stiff[:, None, None] * slope[:, :, None] * BENDING * slope[:, None, :]
            C[:, [1, 2], [1, 2]] -= moments * w / 4
            return energy, forces, C
        by_turns = t @ ARCH / 30
        stretch = u / L + (t * by_turns).sum(axis=1) / 2
        moments = stiff[:, None] * (t @ BENDING)
        normal = self.EA * stretch
        energy = (moments * t).sum(axis=1) / 2 + normal * stretch * L / 2
        change = np.column_stack([1 / L, by_turns])
        C[:, 1:, 1:] = stiff[:, None, None] * BENDING + (normal * L / 30)[:, None, None] * ARCH
        C += (self.EA * L)[:, None, None] * change[:, :, None] * change[:, None, :]
        return energy, (normal * L)[:, None] * change + np.column_stack([0 * L, moments]), C

    @staticmethod
    def _changes(size: Array, along: Array, across: Array) -> Array:
        """First derivatives (n, 3, 6) of the deformations by an element's coordinates."""
        turned = across / size[:, None]
        ends = np.eye(6)[[2, 5]]
        return np.concatenate([along[:, None], ends - turned[:, None]], axis=1)

    def energy(self, q: Array) -> float:
        """Strain energy."""
        return float(self._local(self._frames(q)[0])[0].sum())

    def forces(self, q: Array) -> Array:
        """Its gradient (n_dofs,)."""
        e, *frame = self._frames(q)
        each = np.einsum("ni,nij->nj", self._local(e)[1], self._changes(*frame))
        return np.asarray(np.bincount(self._dofs.ravel(), each.ravel(), self.n_dofs), dtype=float)

    def tangent(self, q: Array) -> sp.csr_matrix:
        """Its second derivative (n_dofs, n_dofs)."""
        e, size, along, across = self._frames(q)
        _, f, C = self._local(e)
        B = self._changes(size, along, across)
        twist = (f[:, 1] + f[:, 2]) / size**2
        mixed = along[:, :, None] * across[:, None, :]
        K = np.swapaxes(B, 1, 2) @ C @ B + (f[:, 0] / size)[:, None, None] * across[:, :, None] * across[:, None, :]
        return self._summed(K + twist[:, None, None] * (mixed + np.swapaxes(mixed, 1, 2)))

    @cached_property
    def mass(self) -> sp.csr_matrix:
        """Constant mass (n_dofs, n_dofs)."""
        per = np.diag([self.mass_per_length, self.mass_per_length, self.rotary])
        one = np.kron(np.array([[2.0, 1.0], [1.0, 2.0]]) / 6, per)
        return self._summed(self.lengths[:, None, None] * one)

    def _summed(self, blocks: Array) -> sp.csr_matrix:
        rows, columns = np.broadcast_arrays(self._dofs[:, :, None], self._dofs[:, None, :])
        return sp.csr_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(self.n_dofs, self.n_dofs))

    def forces_between(self, q0: Array, q1: Array) -> Array:
        """Elastic forces (n_dofs,) whose work from q0 to q1 is the change of energy, see `BETWEEN`."""
        return np.sum([w * self.forces(q0 + x * (q1 - q0)) for x, w in BETWEEN], axis=0, dtype=float)

    def drawn(self, q: Array) -> Drawing:
        """Its chords."""
        return Drawing("line", self._nodes, self.positions(q), self.cells, np.zeros((len(self._nodes), 6)))
