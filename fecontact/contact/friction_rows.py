"""Tangential rows of a contact: relative displacements of its points across their lines of action.

A point's rows are those of its normal, taken along tangents: the same interpolation on both bodies and the same mean
over samples, so that friction is equal and opposite on both. Slip is counted from the end of the last load step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array, IntArray
from fecontact.contact.interface import Interface, UnilateralConstraints
from fecontact.contact.rigid_motion import RigidMotionConstraints
from fecontact.contact.springs import SpringState
from fecontact.solvers import ComplementarityProblem
from fecontact.solvers.friction_problem import FrictionProblem

#: Sine of the angle between a normal and the common axis of reference below which another axis is taken.
NEARLY_PARALLEL = 0.1


@dataclass(frozen=True, eq=False)
class TangentialRows:
    """Tangential displacements of the slave against the master at n contact points, in k directions.

    Rows are those of the first direction at all points, then those of the second.

    Attributes
    ----------
    interface : Interface
    mu : float
        Coefficient of friction; may be infinite.
    past : (k n,) array
        Relative displacement at the end of the last load step.
    """

    interface: Interface
    mu: float
    past: Array = field(default_factory=lambda: np.zeros(0))

    @cached_property
    def tangents(self) -> Array:
        """Unit vectors (k, n, 3) in world axes, orthogonal to the points' mean normals; one in a section."""
        interface = self.interface
        normals = interface.pairing.average @ interface.pairing.slave_normals
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        turn = interface.slave.pose.rotation
        if interface.slave_surface.out_of_plane is not None:
            return np.asarray(np.cross([0.0, 1.0, 0.0], normals) @ turn.T)[None]
        normals = normals @ turn.T
        first = _across(normals)
        return np.stack([first, np.cross(normals, first)])

    @property
    def n_points(self) -> int:
        """Number of contact points n."""
        return len(self.interface.gap)

    @property
    def gap(self) -> Array:
        """Slip (k n,) of undeformed bodies: the last relative displacement, reversed."""
        return -self.past if self.past.size else np.zeros(len(self.tangents) * self.n_points)

    @property
    def own_compliance(self) -> Array:
        """Zero (k n,)."""
        return np.zeros(len(self.gap))

    @property
    def infeasibility_hint(self) -> str:
        """Empty."""
        return ""

    @property
    def as_contact(self) -> None:
        """None: the contact is the interface."""
        return

    @property
    def two_sided(self) -> bool:
        """Yes: friction acts either way."""
        return True

    def spring_states(self, forces: Array, gaps: Array) -> tuple[SpringState, ...]:
        """None: it is no spring."""
        return ()

    @cached_property
    def _along(self) -> tuple[tuple[Array, Interface], ...]:
        """Share (k, n) of each of some directions in the tangents, and the interface with these as its normals."""
        tangents, pairing = self.tangents, self.interface.pairing
        if pairing.coupling == "nodal":
            # a point is one sample: its tangent is the direction
            chosen = list(tangents)
            shares = [np.eye(len(tangents))[j][:, None] * np.ones(self.n_points) for j in range(len(tangents))]
        else:
            chosen = [np.broadcast_to(e, (len(pairing.slave_normals), 3)) for e in np.eye(3)]
            shares = [tangents[:, :, j] for j in range(3)]
        return tuple((share, self._turned(world)) for share, world in zip(shares, chosen, strict=True))

    def _turned(self, directions: Array) -> Interface:
        """The interface with directions (n_samples, 3), in world axes, in place of its normals."""
        given = self.interface
        projection = replace(given.pairing.projection, normals=directions @ given.master.pose.rotation)
        pairing = replace(given.pairing, slave_normals=directions @ given.slave.pose.rotation, projection=projection)
        return replace(given, pairing=pairing)

    def numbers(self, points: IntArray) -> IntArray:
        """Rows (k, c) of some points (c,)."""
        return np.arange(len(self.tangents))[:, None] * self.n_points + points

    def rows(self, body: Body) -> sp.csr_matrix | None:
        """Relative displacement (k n, n_dofs) by the displacements of a body; None if it is not in this contact."""
        if body is not self.interface.slave and body is not self.interface.master:
            return None
        return self._slave_rows if body is self.interface.slave else self._master_rows

    @cached_property
    def _slave_rows(self) -> sp.csr_matrix:
        return self._summed([(share, turned.slave_rows) for share, turned in self._along])

    @cached_property
    def _master_rows(self) -> sp.csr_matrix:
        return self._summed([(share, turned.master_rows) for share, turned in self._along])

    def _summed(self, parts: Sequence[tuple[Array, sp.csr_matrix]]) -> sp.csr_matrix:
        blocks = [sum(sp.diags(share[j]) @ rows for share, rows in parts) for j in range(len(self.tangents))]
        return sp.vstack(blocks, format="csr")

    def opening_by(self, frames: Sequence[RigidMotionConstraints]) -> Array:
        """Slip (k n,) by the prescribed rigid motions."""
        slip = self.gap.copy()
        for frame in frames:
            rows = self.rows(frame.body) if frame.prescribed.any() else None
            if rows is not None:
                slip += rows @ (frame.modes(frame.prescribed[:, None])[:, 0])
        return slip


def friction_problem(
    condensed: ComplementarityProblem,
    interfaces: Sequence[UnilateralConstraints],
    chosen: Sequence[IntArray],
    friction: Sequence[TangentialRows],
) -> FrictionProblem:
    """Friction problem of a condensed problem.

    Parameters
    ----------
    condensed : ComplementarityProblem
        Rows of the chosen pairs of all interfaces, one after the other, then of their tangents.
    interfaces : sequence of UnilateralConstraints
    chosen : sequence of int arrays
        Chosen pairs of each.
    friction : sequence of TangentialRows
    """
    first = dict(zip(map(id, interfaces), np.cumsum([0] + [len(c) for c in chosen])[:-1], strict=True))
    start = sum(map(len, chosen))
    points, tangents, mu = [], [], []
    for each in friction:
        count, k = len(chosen[_place(interfaces, each)]), len(each.tangents)
        points.append(first[id(each.interface)] + np.arange(count))
        tangents.append((start + np.arange(k * count)).reshape(k, count).T)
        mu.append(np.full(count, each.mu))
        start += k * count
    rows = np.concatenate(tangents)
    S = np.array(condensed.S)
    # a direction held on both sides, as on a plane of symmetry, has no compliance: its force is zero by symmetry
    diagonal = S.diagonal()
    held = np.zeros(len(S), bool)
    held[rows.ravel()] = True
    held &= (diagonal == 0) & ~condensed.B.any(axis=0)
    S[held, held] = diagonal.mean()
    given = ComplementarityProblem(S, condensed.g, condensed.B, condensed.F)
    return FrictionProblem(given, np.concatenate(points), rows, np.concatenate(mu))


def _place(interfaces: Sequence[UnilateralConstraints], friction: TangentialRows) -> int:
    return next(k for k, each in enumerate(interfaces) if each is friction.interface)


def _across(normals: Array) -> Array:
    """Unit vectors (n, 3) across unit normals, along one world axis where that is possible."""
    mean = np.abs(normals).mean(axis=0)
    first, second, _ = np.eye(3)[np.argsort(mean, kind="stable")]
    out = first - (normals @ first)[:, None] * normals
    steep = np.linalg.norm(out, axis=1) < NEARLY_PARALLEL
    out[steep] = second - (normals[steep] @ second)[:, None] * normals[steep]
    return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))
