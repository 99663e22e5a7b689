"""Contact conditions of moving faces: weighted gaps, their gradients and second derivatives.

The gap of a multiplier is the mean of the gap weighted by its function in the initial geometry,

    g_k = sum_i A_ki n_i . (x_i - y_i),    G_k = sum_i A_ki n_i . (N_i - M_i),

with quadrature points x_i = N_i q, their closest points y_i on the other side and the unit normals n_i there. A force
l_k is distributed as a pressure in the shape of its function; its generalised forces G^T l act on positions and
gradients. A closest point moves in the tangent plane, so that the gradient needs no derivative of n; the second
derivative does (T. A. Laursen, Computational Contact and Impact Mechanics, 2002, chapter 5). It is included against
rigid bodies and neglected against deformable ones, at the cost of iterations but not of accuracy.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.system.member import Member
from fecontact.bodies.body import Body
from fecontact.bodies.pose import Pose
from fecontact.bodies.rigid import RigidBody
from fecontact.bodies.surface_body import SurfaceBody
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.contact.contact import Side
from fecontact.surfaces.facet_surface import Projection
from fecontact.surfaces.normals import normal_derivative

#: Approach of two bodies in a step of motion, over the smaller thickness, up to which they cannot pass each other.
NEAR = 0.25
#: First step along each axis of an element in the search of its deepest point, and how often it is halved; the depth is
#: wrong by about the square of the last one.
FIRST_STEP, HALVED = 0.25, 20
#: Distance of the points of an element from one of its quadrature points, over the extent of these.
WHOLE = 1.25


@dataclass(frozen=True, eq=False)
class ContactGaps:
    """Contact conditions at some coordinates.

    Attributes
    ----------
    gap : (n_multipliers,) array
        Mean gap of each multiplier; infinite where it faces nothing.
    G : (n_multipliers, n_dofs) csr_matrix
        Its gradient with respect to the coordinates of all bodies.
    projection : Projection
        Projection of the quadrature points, in world axes.
    means : (n_multipliers, n_points) csr_matrix
        A.
    """

    gap: Array
    G: sp.csr_matrix
    projection: Projection
    means: sp.csr_matrix


class Master(ABC):
    """A contact partner. Coordinates q are its own; a rigid body has none."""

    @property
    @abstractmethod
    def named(self) -> object:
        """What tells it from others, of the same member too."""

    @property
    @abstractmethod
    def thickness(self) -> float:
        """Smallest extent of the body behind it; infinite where it has no other side."""

    @property
    def n_dofs(self) -> int:
        """Number of its coordinates."""
        return 0

    @abstractmethod
    def project(self, q: Array, points: Array) -> Projection:
        """Feet of points (n, 3), in world axes."""

    @abstractmethod
    def present(self, q: Array, name: str) -> Body | None:
        """It as a body of results; None of a slender member, which has no faces."""

    def rows_at(self, projection: Projection) -> sp.csr_matrix | None:
        """Values (n, n_functions) of its functions at closest points; None without coordinates."""
        return None

    def normal_derivative(self, projection: Projection) -> Array | None:
        """Derivative (n, 3, 3) of the normals by the positions of the points; None where it is neglected."""
        return None

    @property
    def pose(self) -> Pose:
        """Where it stands; its coordinates have the rest."""
        return Pose()

    def rigid_displacement(self, points: Array, then: Pose) -> Array:
        """Displacement (n, 3) of points (n, 3) that moved with it since it stood at another pose."""
        now, own = self.pose, then.to_body(points)
        return np.asarray(own @ (now.rotation - then.rotation).T + (now.translation - then.translation))


class MovingSide(Side, Master):
    """Faces of bricks, or the skin of a slender member: as the slave it carries the multipliers.

    Attributes
    ----------
    member : Member
    offset : float
        Distance of the skin that touches from the points.
    """

    member: Member
    offset: float = 0.0

    @property
    @abstractmethod
    def n_dofs(self) -> int:
        """Coordinates of its member."""

    @property
    @abstractmethod
    def quadrature(self) -> tuple[sp.csr_matrix, sp.csr_matrix, Array]:
        """Rows N (n_points, n_functions), A (n_multipliers, n_points), areas (n_multipliers,); lengths of a line."""

    @property
    @abstractmethod
    def points(self) -> tuple[IntArray, Array]:
        """Elements (n_points,) of the quadrature points, in order, and coordinates (n_points, n_axes) from 0 to 1."""

    @abstractmethod
    def rows(self, each: IntArray, local: Array) -> sp.csr_matrix:
        """Rows N (n, n_functions) at coordinates (n, n_axes) on elements (n,)."""

    @property
    @abstractmethod
    def widths(self) -> Array:
        """Lengths (n_multipliers,) on which multipliers act."""

    @abstractmethod
    def present_areas(self, q: Array) -> Array:
        """Areas (n_multipliers,) at coordinates q; lengths of a line."""

    @abstractmethod
    def present(self, q: Array, name: str) -> SurfaceBody | None:
        """Its faces; None of a slender member."""

    def constraints(self, master: Master, starts: tuple[int, int | None], q0: Array, mu: float) -> ContactConstraints:
        """Contact constraints with it as the slave.

        Parameters
        ----------
        master : Master
        starts : (int, int or None)
            First coordinates of both sides among those of all members; None of a rigid body.
        q0 : (n_dofs,) array
            Initial coordinates of all members.
        mu : float
        """
        return ContactConstraints(self, master, *starts, len(q0), mu)


@dataclass(frozen=True, eq=False)
class RigidMaster(Master):
    """A rigid body that members may touch."""

    body: RigidBody

    @property
    def named(self) -> RigidBody:
        """The body."""
        return self.body

    @property
    def pose(self) -> Pose:
        """The body's."""
        return self.body.pose

    @property
    def thickness(self) -> float:
        """Of its box, or the length of its shape if that is less."""
        outer = self.body._outside(np.zeros(0))
        extent = np.ptp(outer.points, axis=0).min() + 2 * outer.radius if outer.is_bounded else np.inf
        return min(outer.length, float(extent))

    def project(self, q: Array, points: Array) -> Projection:
        """Feet of points (n, 3), in world axes."""
        return _on(self.body, points)

    def present(self, q: Array, name: str) -> RigidBody:
        """The body."""
        return self.body

    def normal_derivative(self, projection: Projection) -> Array:
        """By central differences on the surface."""
        turn, x = self.body.pose.rotation, projection.points + projection.gap[:, None] * projection.normals
        surface = self.body.surface("surface")
        return np.asarray(turn @ normal_derivative(surface, self.body.pose.to_body(x), self.body.size) @ turn.T)


@dataclass(frozen=True, eq=False)
class ContactConstraints:
    """Contact constraints of faces or slender members against a rigid body or faces of another solid.

    Parameters
    ----------
    slave : MovingSide
        What has the multipliers.
    master : Master
    slave_start, master_start : int
        Their first coordinates among those of all bodies; None of a rigid master.
    n_dofs : int
        Coordinates of all bodies.
    friction : float
        Coulomb's coefficient; may be infinite.

    """

    slave: MovingSide
    master: Master
    slave_start: int
    master_start: int | None
    n_dofs: int
    friction: float = 0.0

    @property
    def pair(self) -> tuple[object, ...]:
        """The two sides of the contact, faces or the rigid body, and the friction between them."""
        master = self.master.named if self.master_start is None else (self.master.named, self.master_start)
        sides = self.slave.named, self.slave_start, master
        return (*sides, self.friction) if self.friction else sides

    @property
    def n_multipliers(self) -> int:
        """Number of contact conditions."""
        return int(self.slave.quadrature[1].shape[0])

    def _own(self, q: Array) -> Array:
        """Coordinates of the slave out of those of all bodies."""
        return q[self.slave_start : self.slave_start + self.slave.n_dofs]

    def _theirs(self, q: Array) -> Array:
        """Coordinates of the master; none of a rigid body."""
        return q[self.master_start or 0 :][: self.master.n_dofs]

    def positions(self, q: Array) -> Array:
        """World positions (n_points, 3) of the slave's quadrature points at coordinates q of all bodies."""
        return np.asarray(self.slave.quadrature[0] @ self._own(q).reshape(-1, 3))

    def present_areas(self, q: Array) -> Array:
        """Areas (n_multipliers,) at coordinates q of all bodies: force over area is the pressure of a multiplier."""
        return self.slave.present_areas(self._own(q))

    def present(self, q: Array, number: int) -> tuple[SurfaceBody, Body] | None:
        """Slave and master at coordinates q of all bodies, named by a number; None of a slender member."""
        slave, master = self.slave.present(self._own(q), f"slave {number}"), self.master
        found = master.present(self._theirs(q), f"master {number}")
        return None if slave is None or found is None else (slave, found)

    @cached_property
    def components(self) -> sp.csr_matrix:
        """Rows (3 n_points, n_dofs): displacements of the quadrature points along the world's axes."""
        return _components(self.slave.quadrature[0], self.slave_start, self.n_dofs)

    def relative_displacement(
        self, part: ContactGaps, then: Array, now: Array, pose: Pose
    ) -> tuple[sp.csr_matrix, Array]:
        """Displacement of the points against what they touch, and its gradient.

        Parameters
        ----------
        part : ContactGaps
            Conditions that have the points opposite.
        then, now : (n_dofs,) arrays
            Coordinates of all bodies, between which they slide.
        pose : Pose
            Of the master then.

        Returns
        -------
        rows : (3 n_points, n_dofs) csr_matrix
        moved : (n_points, 3) array
        """
        start = self.positions(then)
        moved = self.positions(now) - start - self.master.rigid_displacement(start, pose)
        rows = self.master.rows_at(part.projection)
        if rows is None or self.master_start is None:
            return self.components, moved
        opposite = _components(rows, self.master_start, self.n_dofs)
        return sp.csr_matrix(self.components - opposite), moved - (opposite @ (now - then)).reshape(-1, 3)

    @cached_property
    def thickness(self) -> float:
        """Smallest extent of the two bodies."""
        return min(self.slave.thickness, self.master.thickness)

    def approach(self, then: Array, now: Array, before: ContactConstraints) -> float:
        """Largest approach of points in a step that may bring them into contact, over the thickness; zero below `NEAR`.

        Parameters
        ----------
        then, now : (n_dofs,) arrays
            Coordinates of all bodies.
        before : ContactConstraints
            These constraints with the master where it stood then.
        """
        if not np.isfinite(self.thickness):
            return 0.0
        start = self.positions(then)
        own = np.linalg.norm(
            self.positions(now) - start - self.master.rigid_displacement(start, before.master.pose), axis=1
        )
        fastest = own.max() + (0.0 if self.master_start is None else np.abs(now - then).max())
        if fastest <= NEAR * self.thickness:
            return 0.0
        part = before.at(then)
        n, gap = part.projection.normals, part.projection.gap - self.slave.offset
        nearer = -np.einsum("ni,ni->n", n, self.relative_displacement(part, then, now, before.master.pose)[1])
        return float(np.max(nearer, initial=0.0, where=nearer > gap)) / self.thickness

    def overlap(self, q: Array, part: ContactGaps, forces: Array) -> float:
        """Depth to which the two overlap although nothing presses, as all mean gaps are open; zero otherwise.

        Of the deepest points of elements, which are searched for from their deepest quadrature points.
        """
        if forces.any():
            return 0.0
        each, local = self.slave.points
        x, n = self.positions(q), len(each)
        gap = np.where(part.projection.outside[:n], np.inf, part.projection.gap[:n] - self.slave.offset)
        first = np.flatnonzero(np.diff(each, prepend=-1))
        box = np.maximum.reduceat(x, first) - np.minimum.reduceat(x, first)
        deepest, extent = np.lexsort([gap, each])[first], WHOLE * np.linalg.norm(box, axis=1)
        at, step, k = local[deepest], FIRST_STEP, local.shape[1]
        ways = np.stack(np.meshgrid(*[[0.0, -1.0, 1.0]] * k, indexing="ij"), axis=-1).reshape(-1, k)
        depth = -gap[deepest]
        for _ in range(HALVED):
            # a gap falls by no more than the distance to another point, of which the steps that are left are a part
            near = depth > -2 * step * extent
            at, depth, deepest, extent = at[near], depth[near], deepest[near], extent[near]
            if not len(at):
                return 0.0
            tried = np.clip(at[:, None] + step * ways, 0.0, 1.0)
            seen = self._facing(q, each[deepest].repeat(len(ways)), tried.reshape(-1, k))
            gaps = np.where(seen.outside, np.inf, seen.gap - self.slave.offset).reshape(len(at), -1)
            best = gaps.argmin(axis=1)
            at, depth, step = tried[np.arange(len(at)), best], -gaps.min(axis=1), step / 2
        return float(depth.max(initial=0.0))

    def _facing(self, q: Array, each: IntArray, local: Array) -> Projection:
        """Projection of points at coordinates (n, n_axes) on elements (n,) of the slave, in world axes."""
        points = np.asarray(self.slave.rows(each, local) @ self._own(q).reshape(-1, 3))
        return self.master.project(self._theirs(q), points)

    def projection(self, q: Array) -> Projection:
        """Projection of the quadrature points on the master, in world axes."""
        return self.master.project(self._theirs(q), self.positions(q))

    def at(self, q: Array) -> ContactGaps:
        """Gaps and gradients at coordinates q (n_dofs,) of all bodies."""
        projection = self.projection(q)
        rows, means, _ = self.slave.quadrature
        hidden = projection.outside
        if hidden.any():
            means = sp.csr_matrix(means @ sp.diags_array((~hidden).astype(float)))
            share = np.asarray(means.sum(axis=1)).ravel()
            means = sp.csr_matrix(sp.diags_array(np.divide(1.0, share, where=share > 0, out=share * 0)) @ means)
        points = _along_normals(rows, projection.normals, self.slave_start, self.n_dofs)
        opposite = self.master.rows_at(projection)
        if opposite is not None and self.master_start is not None:
            points = points - _along_normals(opposite, projection.normals, self.master_start, self.n_dofs)
        gap = means @ np.where(hidden, 0.0, projection.gap - self.slave.offset)
        gap[np.diff(means.indptr) == 0] = np.inf
        if hidden.any():
            gap[np.asarray(means.sum(axis=1)).ravel() == 0] = np.inf
        return ContactGaps(gap, sp.csr_matrix(means @ points), projection, means)

    def curvature(self, touching: ContactGaps, forces: Array) -> sp.csr_matrix | None:
        """Second derivative (n_dofs, n_dofs) of forces . gap, where the master is rigid; None where it vanishes."""
        pressing = touching.means.T @ forces
        used = np.flatnonzero(pressing)
        turns = self.master.normal_derivative(touching.projection.chosen(used)) if len(used) else None
        if turns is None or not turns.any():
            return None
        each = np.arange(len(used))
        H = sp.bsr_matrix((turns * pressing[used, None, None], each, np.arange(len(used) + 1)))
        wide = _components(self.slave.quadrature[0][used], self.slave_start, self.n_dofs)
        return sp.csr_matrix(wide.T @ H @ wide)

    @cached_property
    def areas(self) -> Array:
        """Areas (n_multipliers,) in the initial geometry."""
        return self.slave.quadrature[2]

    @cached_property
    def widths(self) -> Array:
        """Lengths (n_multipliers,) on which multipliers act."""
        return self.slave.widths


def _on(body: RigidBody, points: Array) -> Projection:
    """Projection on a rigid body, in world axes."""
    projection = body.surface("surface").project(body.pose.to_body(points))
    if not np.isfinite(projection.gap[~projection.outside]).all():
        raise InputError(f"The surface of {body.name!r} gives gaps that are not finite numbers; check its shape.")
    turn = body.pose.rotation
    return Projection(
        body.pose.to_world(projection.points), projection.normals @ turn.T, projection.gap, projection.outside
    )


def _along_normals(rows: sp.csr_matrix, normals: Array, start: int, n_dofs: int) -> sp.csr_matrix:
    """N . N as rows (n_points, n_dofs) of the coordinates that begin at `start`."""
    coo = rows.tocoo()
    i = np.arange(3)
    data = coo.data[:, None] * normals[coo.row]
    column = start + 3 * coo.col[:, None] + i
    row = np.broadcast_to(coo.row[:, None], data.shape)
    return sp.csr_matrix((data.ravel(), (row.ravel(), column.ravel())), shape=(rows.shape[0], n_dofs))


def _components(rows: sp.csr_matrix, start: int, n_dofs: int) -> sp.csr_matrix:
    """Values N of functions as rows (3 n_points, n_dofs) of the coordinates that begin at `start`."""
    wide = sp.kron(rows, sp.eye_array(3), format="csr")
    return sp.csr_matrix((wide.data, wide.indices + start, wide.indptr), shape=(wide.shape[0], n_dofs))
