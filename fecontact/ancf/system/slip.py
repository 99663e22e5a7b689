"""Slip of moving faces: tangential rows of contacts with friction, counted from the end of the last step.

The slip of a multiplier is the mean, weighted as its gap, of the displacement of the points against what they touch,

    s_k = sum_i A_ki t_i . (d_i - D_i),    T_k = sum_i A_ki t_i . (N_i - M_i)

along two tangents t_i at right angles to the normal n_i of each point. d_i - D_i is the displacement of a point against
the master since the last step: against the rigid body where it stands now, or against the material point of the other
faces that is opposite now (T. A. Laursen, Computational Contact and Impact Mechanics, 2002, section 5.3). A common
motion of both is no slip. The slip of a step is the chord of its path; the turn of the tangents within the step is left
out of T, at the cost of iterations but not of accuracy.

A multiplier that sticks is left with a slip of the size of rounding. It is left to the next step, which takes it back:
after any number of steps what sticks is where it was.

The jump of velocities where points stop sliding.

Over a step a point sticks if its slip vanishes, which by itself turns its velocity round: the mean of both ends is
zero. So velocities jump at the end of a step, as in T. A. Laursen & G. R. Love, Int. J. Numer. Methods Eng. 53 (2002)
for normal contact: impulses p of friction over the whole step, h t of them given, minimise the kinetic energy under
Coulomb's law for the velocities u at its end,

    u = T (v + M^-1 T^T (p - h t)) - w,    |p| <= mu h l,    u = 0 where |p| < mu h l,    |u| p = - mu h l u

with the velocity w of what they touch. Kinetic energy is lost, never won: with |h t| <= mu h l its change is the sum of
(p - h t) . u, at most zero, less the kinetic energy of the jump. Points that slide on keep their velocity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.system.assembly import Assembly
from fecontact.ancf.system.moving_contact import ContactConstraints, ContactGaps
from fecontact.ancf.system.newton import ContactRows
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray
from fecontact.common.renamed import renamed
from fecontact.solvers import ContactProblem
from fecontact.solvers.coulomb import (
    Residuals,
    ResidualScales,
    friction_limit,
    ratio,
    sizes,
    sticks,
    with_held_directions,
)
from fecontact.solvers.friction import solve_friction


@dataclass(frozen=True, eq=False)
class SlipStart:
    """End of the last step, from which slip is counted.

    Attributes
    ----------
    q : (n_dofs,) array
        Coordinates of all bodies.
    poses : tuple of Pose
        Of the master of each contact.
    residual_slip : (n_multipliers, 3) array
        Slip left over at the multipliers of all contacts.
    """

    q: Array
    poses: tuple[Pose, ...]
    residual_slip: Array


@dataclass(frozen=True, eq=False)
class FrictionEnd:
    """Friction at the end of a step.

    Attributes
    ----------
    forces, slip : tuple of (n_multipliers, 3) arrays
        Tangential forces on the slave, and slip during the step, of each contact, in world axes; zero without friction.
    residuals : Residuals
        Of contact, friction and equilibrium, see `Slips.residuals`.
    friction_work : float
        Work of friction during the step.
    start : SlipStart
        State from which the slip of the next step is measured.
    """

    forces: tuple[Array, ...]
    slip: tuple[Array, ...]
    residuals: Residuals
    friction_work: float
    start: SlipStart

    dissipated = renamed("dissipated", "friction_work")
    defect = renamed("defect", "residuals.slip", lambda end: end.residuals.slip or 0.0)

    def of(self, slips: Slips) -> Array:
        """Components (2 f,) of the tangential forces along the tangents of some slips."""
        return slips.of(np.concatenate([np.zeros((0, 3)), *self.forces]))


def initial_friction(contacts: Sequence[ContactConstraints], q: Array) -> FrictionEnd:
    """No forces and no slip, at coordinates q (n_dofs,)."""
    none = tuple(np.zeros((t.n_multipliers, 3)) for t in contacts)
    left = np.concatenate([np.zeros((0, 3)), *none])
    return FrictionEnd(
        none,
        none,
        Residuals(0.0, 0.0, 0.0, 0.0),
        0.0,
        SlipStart(q, tuple(t.master.pose for t in contacts), left),
    )


@dataclass(frozen=True, eq=False)
class Slips:
    """Slip of all contacts with friction at some coordinates; 2 f rows, the first tangents of all, then the second.

    Attributes
    ----------
    points : (f,) int array
        Number of each multiplier with friction among all contact conditions.
    mu : (f,) array
    frames : (2, f, 3) array
        Tangents of the mean normals.
    slip : (2 f,) array
    T : (2 f, n_dofs) csr_matrix
        Its gradient.
    """

    points: IntArray
    mu: Array
    frames: Array
    slip: Array
    T: sp.csr_matrix

    def vectors(self, components: Array) -> Array:
        """Vectors (f, 3) of components (2 f,)."""
        return np.einsum("af,afi->fi", components.reshape(2, -1), self.frames)

    def components(self, vectors: Array) -> Array:
        """Components (2 f,) of vectors (f, 3)."""
        return np.einsum("fi,afi->af", vectors, self.frames).ravel()

    def of(self, vectors: Array) -> Array:
        """Components (2 f,) of vectors (n_multipliers, 3) at all conditions."""
        return self.components(vectors[self.points])

    def everywhere(self, components: Array, n: int) -> Array:
        """Vectors (n, 3) at all n conditions of components (2 f,)."""
        out = np.zeros((n, 3))
        out[self.points] = self.vectors(components)
        return out

    def moved(self, change: Array) -> Slips:
        """After a change (n_dofs,) of the coordinates, to the first order."""
        return replace(self, slip=self.slip + self.T @ change)

    def _kept(self, near: IntArray) -> IntArray:
        return np.flatnonzero(np.isin(self.points, near))

    def rows(
        self, G: sp.csr_matrix, gap: Array, near: IntArray, Z: sp.csr_matrix, jump: Array, guess: tuple[Array, Array]
    ) -> ContactRows:
        """Chosen conditions, sorted, of all, in the free directions Z, after a given change of the coordinates.

        The guess has the forces of all conditions and along all rows of slip from which the solver begins.
        """
        kept, G = self._kept(near), G[near]
        rows = (np.arange(2)[:, None] * len(self.points) + kept).ravel()
        T = self.T[rows]
        return ContactRows(
            gap[near] + G @ jump, sp.csr_matrix(G @ Z), np.searchsorted(near, self.points[kept]), self.mu[kept],
            self.slip[rows] + T @ jump, sp.csr_matrix(T @ Z), np.concatenate([guess[0][near], guess[1][rows]]),
        )  # fmt: skip

    def spread(self, near: IntArray, forces: Array, n: int) -> tuple[Array, Array]:
        """Forces of all n conditions and components (2 f,) of the tangential ones, zero but for the chosen ones."""
        every, out = np.zeros(n), np.zeros((2, len(self.points)))
        every[near], out[:, self._kept(near)] = forces[: len(near)], forces[len(near) :].reshape(2, -1)
        return every, out.ravel()

    def limit(self, normal: Array) -> Array:
        """Largest tangential forces (f,) under the normal forces of all conditions."""
        return friction_limit(self.mu, normal[self.points])

    def residuals(self, gap: Array, normal: Array, tangential: Array, size: float, unbalanced: float) -> Residuals:
        """Residuals of the gaps and forces of all conditions and of these rows, and of a relative force out of balance.

        Lengths are relative to a size and forces to the largest normal one; what is pressed is to be closed, however
        small its force.
        """
        total, most = float(normal.sum()), float(normal.max(initial=0.0))
        pressed = np.abs(gap[normal > 0]).max(initial=0.0)
        tension = abs(float(ratio(np.minimum(normal.min(initial=0.0), 0.0), most)))
        found = Residuals(float(max(0.0, -gap.min(initial=0.0)) / size), tension, float(pressed / size), unbalanced)
        if not len(self.points):
            return found
        t, s = (x.reshape(2, -1) for x in (tangential, self.slip))
        return found.with_friction(t, s, self.limit(normal), ResidualScales(total, size, most))

    def end(
        self, contacts: Sequence[ContactConstraints], q: Array, normal: Array, tangential: Array, residuals: Residuals
    ) -> FrictionEnd:
        """End of a step at coordinates q (n_dofs,) under forces of all conditions and of these rows."""
        split = np.cumsum([t.n_multipliers for t in contacts])[:-1]
        forces, slip = (self.everywhere(x, len(normal)) for x in (tangential, self.slip))
        slip[normal <= 0] = 0.0
        start = SlipStart(q, tuple(t.master.pose for t in contacts), self.residual_slip(normal, tangential, self.slip))
        return FrictionEnd(
            tuple(np.split(forces, split)), tuple(np.split(slip, split)), residuals,
            -float(tangential @ self.slip), start,
        )  # fmt: skip

    def residual_slip(self, normal: Array, tangential: Array, slip: Array) -> Array:
        """Slip (n_multipliers, 3) of what sticks under these forces, out of slips (2 f,)."""
        held = sticks(tangential.reshape(2, -1), self.limit(normal))
        return self.everywhere(slip * np.tile(held, 2), len(normal))


def slips(contacts: Sequence[ContactConstraints], parts: Sequence[ContactGaps], q: Array, start: SlipStart) -> Slips:
    """Slip at coordinates q (n_dofs,) since the end of the last step.

    Parameters
    ----------
    contacts : sequence of ContactConstraints
    parts : sequence of ContactGaps
        Their conditions, which have the tangents and the points opposite.
    q : (n_dofs,) array
    start : SlipStart
    """
    first = np.cumsum([0] + [t.n_multipliers for t in contacts])
    points, mu, frames, slip, T = [], [], [], [], []
    for touch, part, pose, begin in zip(contacts, parts, start.poses, first, strict=False):
        if touch.friction == 0:
            continue
        n = touch.n_multipliers
        P, frame = _tangents(part)
        against, moved = touch.relative_displacement(part, start.q, q, pose)
        turned = start.residual_slip[begin : begin + n] @ (touch.master.pose.rotation @ pose.rotation.T).T
        points.append(begin + np.arange(n))
        mu.append(np.full(n, touch.friction))
        frames.append(frame)
        slip.append((P @ moved.ravel()).reshape(2, n) + np.einsum("fi,afi->af", turned, frame))
        T.append([P[:n] @ against, P[n:] @ against])
    if not points:
        empty = sp.csr_matrix((0, len(q)))
        return Slips(np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((2, 0, 3)), np.zeros(0), empty)
    rows = sp.vstack([each[a] for a in range(2) for each in T], format="csr")
    return Slips(
        np.concatenate(points), np.concatenate(mu), np.concatenate(frames, axis=1),
        np.concatenate(slip, axis=1).ravel(), rows,
    )  # fmt: skip


def _tangents(part: ContactGaps) -> tuple[sp.csr_matrix, Array]:
    """Means along both tangents (2 m, 3 n_points) of displacements of the points, and the multipliers' own (2, m, 3).

    The first tangent of a multiplier and of its points is the same world axis, less its share along their normals.
    """
    means = part.means.tocoo()
    mean = part.means @ part.projection.normals
    size = np.linalg.norm(mean, axis=1, keepdims=True)
    # a multiplier that faces nothing has no normal and no force
    mean = np.where(size > 0, mean, [0.0, 0.0, 1.0]) / np.where(size > 0, size, 1.0)
    axes = np.eye(3)[np.abs(mean).argmin(axis=1)]
    along = _across(axes[means.row], part.projection.normals[means.col])
    row = np.concatenate([means.row, means.row + len(mean)])
    data = np.tile(means.data, 2)[:, None] * along.reshape(-1, 3)
    column = 3 * np.tile(means.col, 2)[:, None] + np.arange(3)
    shape = (2 * len(mean), 3 * means.shape[1])
    P = sp.csr_matrix((data.ravel(), (row.repeat(3), column.ravel())), shape=shape)
    return P, _across(axes, mean)


def _across(axes: Array, normals: Array) -> Array:
    """Tangents (2, n, 3) at right angles to unit normals (n, 3), the first along an axis (n, 3) as far as it can."""
    first = axes - (axes * normals).sum(axis=1, keepdims=True) * normals
    size = np.linalg.norm(first, axis=1, keepdims=True)
    # a point whose normal lies along the axis, more than a right angle's half off the mean, has no part in friction
    first = np.divide(first, size, out=np.zeros_like(first), where=size > 0)
    return np.stack([first, np.cross(normals, first)])


#: Motion in a step by a velocity, relative to the size of the bodies, that is rounding.
ROUNDING = 1e-14


def stopped(
    a: Assembly, v: Array, slip: Slips, normal: Array, tangential: Array, driven: Array, h: float
) -> tuple[Array, float]:
    """Velocities after the jump, and the kinetic energy it takes.

    Parameters
    ----------
    a : Assembly
    v : (n_dofs,) array
    slip : Slips
    normal : (n_multipliers,) array
        Normal forces of all conditions over the step.
    tangential : (2 f,) array
        Forces of the rows of `slip` over the step.
    driven : (2 f,) array
        Velocities w of what they touch.
    h : float

    Returns
    -------
    v : (n_dofs,) array
    lost : float
    """
    n, limit = len(slip.points), slip.limit(normal)
    held = np.flatnonzero(sticks(tangential.reshape(2, -1), limit))
    rows = (np.arange(2)[:, None] * n + held).ravel()
    T = sp.csr_matrix(slip.T[rows])
    u = T @ v - driven[rows]
    if not len(rows) or h * np.abs(u).max() <= ROUNDING * a.size:
        return v, 0.0
    spread = a.accelerated(T.T.toarray())
    S = T @ spread
    t = h * tangential[rows]
    # the limits are given: rows of their own have them as forces, with friction of one; a rough point has any
    f, unit = len(held), float(S.diagonal().mean())
    every = np.zeros((3 * f, 3 * f))
    every[:f, :f], every[f:, f:] = unit * np.eye(f), (S + S.T) / 2
    rough = np.isinf(limit[held])
    bound = h * np.where(rough, sizes(t.reshape(2, -1)).max(), limit[held])
    g, tangents = np.concatenate([-unit * bound, u - S @ t]), f + np.arange(2 * f).reshape(2, -1).T
    problem = ContactProblem(
        with_held_directions(every, tangents),
        g,
        points=np.arange(f),
        tangents=tangents,
        mu=np.where(rough, np.inf, 1.0),
    )
    jump = spread @ (solve_friction(problem).forces[f:] - t)
    return v + jump, -float(jump @ (a.mass @ (v + jump / 2)))
