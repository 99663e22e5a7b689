"""Tangential rows of a contact: relative displacements of its points across their lines of action.

A point's rows are those of its normal, taken along tangents: the same interpolation on both bodies and the same mean
over samples, so that friction is equal and opposite on both.

Slip is counted from the end of the last load step, in the master's axes: with X a point of the slave there, by the
poses, and d its displacement against the master's, the slip is the tangential part of X + d - (X + d)_last. A common
motion of both bodies thus is no slip, however large (Laursen & Simo, Int. J. Numer. Methods Eng. 36 (1993) 3451). A
point that was open then slips from where it touches by the motion of the poses; what bodies deflect before that counts
as slip, an error of the size of the step. The slip of a step is the chord of its path: between its two ends a step's
relative motion is a screw, the same from every frame of reference, so a body that rolls by many widths of its contact
in one step has slid by none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from fecontact.bodies.body import Body
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import ROUNDING, Array, IntArray, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.contact.contact import Lay
from fecontact.contact.interface import Interface, UnilateralConstraints
from fecontact.fem.section_model import on_axis
from fecontact.solvers import ContactProblem
from fecontact.solvers.coulomb import with_held_directions

#: Sine of the angle between a normal and the common axis of reference below which another axis is taken.
NEARLY_PARALLEL = 0.1
#: Compliance of a point in one direction, relative to that in others, that is rounding.
HELD = 1e-10


@compact_repr
@dataclass(frozen=True, eq=False)
class TangentialRows(UnilateralConstraints):
    """Tangential displacements of the slave against the master at n contact points, in k directions.

    Rows are those of the first direction at all points, then those of the second.

    Attributes
    ----------
    interface : Interface
    place : int
        Its number among the interfaces of the problem.
    mu : float
        Coefficient of friction; may be infinite. With a lay the larger one.
    lay : Lay, optional
        Direction of two coefficients: slip along each is scaled by its share of the larger one, forces inversely.
    since : Pose, optional
        Pose of the slave's axes in the master's at the end of the last load step; by default the present one.
    moved : (n, 3) array, optional
        Displacements d then, in the master's axes; zero by default.
    pressed : (n,) bool array, optional
        Points that were pressed then; none by default.
    """

    interface: Interface
    place: int
    mu: float
    lay: Lay | None = None
    since: Pose | None = None
    moved: Array | None = None
    pressed: Mask | None = None

    @cached_property
    def normals(self) -> Array:
        """Mean normals (n, 3) of the points in world axes, out of the master."""
        pairing = self.interface.pairing
        normals = pairing.mixed(pairing.average @ pairing.slave_normals)
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        return np.asarray(normals @ self.interface.slave.pose.rotation.T)

    @cached_property
    def tangents(self) -> Array:
        """Vectors (k, n, 3) in world axes, orthogonal to each other and to the points' mean normals.

        Of a section one in its plane, and in torsion the circumferential one; zero on the axis of revolution, where
        tractions vanish by symmetry, and with them displacements. Of unit length, with a lay of those of its scaled
        slips. Forces are sums of these vectors.
        """
        normals, surface = self.normals, self.interface.slave_surface
        extent = surface.out_of_plane
        if self.lay is not None:
            both = self.lay.tangents(normals)
        else:
            first = _across(normals)
            if extent is not None:
                first = np.cross(self.interface.slave.pose.rotation[:, 1], normals)
            both = np.stack([first, np.cross(normals, first)])
        if surface.revolved:
            both[:, on_axis(self.interface.pairing.slave_points, surface.size)] = 0.0
        return both if extent is None or extent.torsion else both[:1]

    @property
    def points(self) -> Array:
        """The points (n, 3) in world axes."""
        return self.interface.slave.pose.to_world(self._centres)

    def check_lay(self, touching: Mask) -> None:
        """Refuse points that touch (n,) where a lay has no direction in the surface."""
        if self.lay is not None:
            self.lay.check(self.normals, self.points, touching)

    def slip_vectors(self, slip: Array) -> Array:
        """Vectors (n, 3) in world axes of slips (k, n) along the tangents."""
        square = (self.tangents**2).sum(axis=2)
        along = np.divide(slip, square, out=np.zeros(slip.shape), where=square > 0)
        return np.asarray(np.einsum("kn,kni->ni", along, self.tangents))

    def mu_along(self, slip: Array) -> Array:
        """Coefficient of friction (n,) in the direction of slips (k, n) along the tangents; `mu` without slip."""
        length = np.linalg.norm(self.slip_vectors(slip), axis=1)
        ratio = np.divide(np.linalg.norm(slip, axis=0), length, out=np.ones(len(length)), where=length > 0)
        return np.asarray(self.mu * ratio)

    @property
    def n_points(self) -> int:
        """Number of contact points n."""
        return len(self.interface.gap)

    @cached_property
    def gap(self) -> Array:
        """Slip (k n,) of undeformed bodies: their motion since the last step, less the last displacement."""
        by = np.zeros((self.n_points, 3)) if self.moved is None else -self.moved
        if self.since is not None:
            by = by + self._moved_by_poses(self.since)
        return np.einsum("kni,ni->kn", self.tangents, by @ self.interface.master.pose.rotation.T).ravel()

    @cached_property
    def _paths(self) -> Array | None:
        """Positions (k, n, 3) of the points during the step, in the master's axes; None where no pose has changed."""
        pairing = self.interface.pairing
        now = Pose(pairing.rotation, pairing.translation)
        if self.since is None or not self._shifts(self.since).any():
            return None
        return screw_paths(self._centres, self.since, now)

    @cached_property
    def _centres(self) -> Array:
        """The points (n, 3) in the slave's axes."""
        pairing = self.interface.pairing
        return np.asarray(pairing.mixed(pairing.average @ (pairing.slave_weights @ self.interface.slave_nodes)))

    def _shifts(self, since: Pose) -> Array:
        """Motion (n, 3) of the points by the poses since the last step, in the master's axes."""
        pairing = self.interface.pairing
        turned, shifted = pairing.rotation - since.rotation, pairing.translation - since.translation
        return np.asarray(self._centres @ turned.T + shifted)

    def _moved_by_poses(self, since: Pose) -> Array:
        """The same, of points that were open since they touch."""
        shifts = self._shifts(since)
        if self._paths is None:
            return shifts
        normals = self.normals @ self.interface.master.pose.rotation
        before = 0.0 if self.moved is None else np.einsum("ni,ni->n", self.moved, normals)
        touching = touching_points(self._paths, self.interface.gap + before, normals, self._pressed)
        return np.asarray(shifts - (touching - self._paths[0]))

    @property
    def _pressed(self) -> Mask:
        return np.zeros(self.n_points, bool) if self.pressed is None else self.pressed

    def detour(self, touching: Mask, least: float) -> float:
        """Largest excess of the path of a point over its slip, the chord in its tangent plane; relative to the longest.

        Parameters
        ----------
        touching : (n,) bool array
            Points that touch now; those that did at the last step, too, are judged.
        least : float
            Length such as the largest displacement. Paths out of the tangent plane, as round a bore, count by what they
            exceed it: rolling points come and go by as much.
        """
        kept = self._pressed & touching
        if self._paths is None or not kept.any():
            return 0.0
        normals = (self.normals @ self.interface.master.pose.rotation)[kept]
        steps = np.diff(self._paths[:, kept], axis=0)
        along = steps - np.einsum("kni,ni->kn", steps, normals)[..., None] * normals
        chord = np.linalg.norm(along.sum(axis=0), axis=1)
        lengths, planar = (np.linalg.norm(each, axis=2).sum(axis=0) for each in (steps, along))
        excess = max(float((planar - chord).max()), float((lengths - chord).max()) - least)
        return excess / max(float(lengths.max()), least)

    def displaced(self, slip: Array, opening: Array) -> Array:
        """Displacement (n, 3) of the slave against the master in the master's axes, without that of the poses.

        Parameters
        ----------
        slip : (k, n) array
        opening : (n,) array
            Change of the gap.
        """
        along = self.slip_vectors(slip - self.gap.reshape(slip.shape))
        return np.asarray((along + opening[:, None] * self.normals) @ self.interface.master.pose.rotation)

    @property
    def two_sided(self) -> bool:
        """Yes: friction acts either way."""
        return True

    @cached_property
    def _along(self) -> tuple[Interface, ...]:
        """The interface with each of the world's axes in place of its normals."""
        n = len(self.interface.pairing.slave_normals)
        return tuple(self._turned(np.broadcast_to(axis, (n, 3))) for axis in np.eye(3))

    def _turned(self, directions: Array) -> Interface:
        """The interface with directions (n_samples, 3), in world axes, in place of its normals."""
        given = self.interface
        projection = replace(given.pairing.projection, normals=directions @ given.master.pose.rotation)
        pairing = replace(given.pairing, slave_normals=directions @ given.slave.pose.rotation, projection=projection)
        return replace(given, pairing=pairing)

    def held(self, rows: IntArray, closed: IntArray, stuck: Sequence[IntArray]) -> Mask:
        """Which of its rows are those of slave nodes that stick."""
        return np.isin(self.interface.pairing.nodes[rows % self.n_points], stuck[self.place])

    def relative_motion(self, displacements: Mapping[int, Array]) -> Array:
        """World displacements (n, 3) of the slave's points against the master's, by those of bodies by their ids."""
        out = np.zeros((self.n_points, 3))
        for along, column in zip(self._along, out.T, strict=True):
            for body, rows in ((along.slave, along.slave_rows), (along.master, along.master_rows)):
                if id(body) in displacements:
                    column += rows @ displacements[id(body)]
        return out

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
        return self._along_tangents([each.slave_rows for each in self._along])

    @cached_property
    def _master_rows(self) -> sp.csr_matrix:
        return self._along_tangents([each.master_rows for each in self._along])

    def _along_tangents(self, components: Sequence[sp.csr_matrix]) -> sp.csr_matrix:
        """Rows along the tangents from those along the world's axes."""
        blocks = [
            sum(sp.diags(t) @ rows for t, rows in zip(tangent.T, components, strict=True)) for tangent in self.tangents
        ]
        return sp.vstack(blocks, format="csr")


def friction_problem(
    condensed: ContactProblem,
    chosen: Sequence[IntArray],
    friction: Sequence[TangentialRows],
) -> ContactProblem:
    """A condensed problem with the friction of its tangential rows.

    Parameters
    ----------
    condensed : ContactProblem
        Rows of the chosen pairs of all interfaces, one after the other, then of their tangents.
    chosen : sequence of int arrays
        Chosen pairs of each interface.
    friction : sequence of TangentialRows

    Raises
    ------
    InputError
        If a lay is oblique to a plane of symmetry.
    """
    first = np.cumsum([0] + [len(c) for c in chosen])
    start, points, tangents, mu = int(first[-1]), [], [], []
    for each in friction:
        count, k = len(chosen[each.place]), len(each.tangents)
        points.append(first[each.place] + np.arange(count))
        tangents.append((start + np.arange(k * count)).reshape(k, count).T)
        mu.append(np.full(count, each.mu))
        start += k * count
    rows = np.concatenate(tangents)
    if not condensed.is_dense:  # an operator that solves problems of friction itself
        return replace(condensed, points=np.concatenate(points), tangents=rows, mu=np.concatenate(mu))
    known = None if any(each.lay for each in friction) else np.concatenate(points)
    S = with_held_directions(condensed.matrix, rows, condensed.B, known)
    for each, pairs in zip(friction, tangents, strict=True):
        if each.lay is not None:
            _check_mirrored(each.lay, S[pairs[:, :, None], pairs[:, None]])
    return replace(condensed, S=S, points=np.concatenate(points), tangents=rows, mu=np.concatenate(mu))


def _check_mirrored(lay: Lay, compliance: Array) -> None:
    """Refuse a lay oblique to a plane of symmetry: of compliances (n, 2, 2) of points, one on it is singular."""
    scale = np.diagonal(compliance, axis1=1, axis2=2).min(axis=1)
    if (np.linalg.eigvalsh(compliance)[:, 0] < HELD * scale).any():
        raise InputError(
            f"A point is held in a direction oblique to the lay of {lay.body!r}, as on a plane of symmetry, whose "
            "mirror image would have another lay. Give an axis along the plane or across, or model both halves."
        )


def _across(normals: Array) -> Array:
    """Unit vectors (n, 3) across unit normals, along one world axis where that is possible."""
    mean = np.abs(normals).mean(axis=0)
    first, second, _ = np.eye(3)[np.argsort(mean, kind="stable")]
    out = first - (normals @ first)[:, None] * normals
    steep = np.linalg.norm(out, axis=1) < NEARLY_PARALLEL
    out[steep] = second - (normals[steep] @ second)[:, None] * normals[steep]
    return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))


#: Times of a step at which points are placed, its ends included.
TIMES = 33


def screw_paths(points: Array, start: Pose, end: Pose) -> Array:
    """Positions (k, n, 3) of body points (n, 3) at equal times of the screw from one pose to another.

    With a rotation vector r and the translation V v of the twist (r, v), V = I + (1 - cos a) / a^2 [r] + (a - sin a) /
    a^3 [r]^2 and a = |r| (Rodrigues).

    Examples
    --------
    A quarter turn about the point (1, 0, 0):

    >>> import numpy as np
    >>> from fecontact.bodies.pose import rotation_about
    >>> end = Pose(rotation_about((0, 0, 1), np.pi / 2), np.array([1.0, -1.0, 0.0]))
    >>> path = screw_paths(np.array([[2.0, 0.0, 0.0]]), Pose(), end)
    >>> bool(np.allclose(np.linalg.norm(path - [1.0, 0.0, 0.0], axis=2), 1.0))
    True
    """
    turn = end.rotation @ start.rotation.T
    shift = end.translation - turn @ start.translation
    r = Rotation.from_matrix(turn).as_rotvec()
    times = np.linspace(0.0, 1.0, TIMES)
    v = np.linalg.solve(_spread(r), shift)
    turns = Rotation.from_rotvec(times[:, None] * r).as_matrix()
    shifts = np.stack([t * (_spread(t * r) @ v) for t in times])
    at_start = points @ start.rotation.T + start.translation
    return np.asarray(np.einsum("kij,nj->kni", turns, at_start) + shifts[:, None])


def _spread(r: Array) -> Array:
    """The matrix V (3, 3) of a rotation vector."""
    angle = float(np.linalg.norm(r))
    x, y, z = r
    W = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    # sin(x)/x is exact for small angles
    half = np.sinc(angle / 2 / np.pi) ** 2 / 2
    third = (1 - np.sinc(angle / np.pi)) / angle**2 if angle > 1e-4 else 1 / 6
    return np.asarray(np.eye(3) + half * W + third * W @ W)


def touching_points(paths: Array, gaps: Array, normals: Array, pressed: Mask) -> Array:
    """Where points are from which their slip counts: those pressed before at the start, others where they touch.

    Parameters
    ----------
    paths : (k, n, 3) array
        Positions of the points.
    gaps : (n,) array
        Gaps at the end, with the displacements of the start.
    normals : (n, 3) array
        Unit normals out of the other surface at the end, in whose tangent plane it is taken to continue.
    pressed : (n,) bool array
        Points that were pressed at the start.

    Returns
    -------
    (n, 3) array
        Where a point does not come to touch: where it first is nearest.
    """
    w = gaps + np.einsum("kni,ni->kn", paths - paths[-1], normals)
    least = w.min(axis=0)
    rounding = ROUNDING * (w.max(axis=0) - least + np.abs(paths[-1] - paths[0]).max(initial=0.0))
    level = np.maximum(least, 0.0) + rounding
    first = np.argmax(w <= level, axis=0)
    first[pressed] = 0
    before, n = np.maximum(first - 1, 0), np.arange(len(first))
    fall = w[before, n] - w[first, n]
    share = np.divide(w[before, n] - level, fall, out=np.ones(len(n)), where=fall > 0)
    return np.asarray(paths[before, n] + share[:, None] * (paths[first, n] - paths[before, n]))
