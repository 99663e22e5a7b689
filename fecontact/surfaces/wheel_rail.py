"""Places where a wheel meets a rail: planes, gaps and rigid creepages of their contact patches.

The wheel is on the left: x along the track, y to the left, away from its middle, z upwards. A right one is its mirror
image: lateral shift, yaw and roll change their signs, and so do what is lateral and spin in the results.

The rail is a cylinder along x and the wheel one of revolution. Seen along x, the wheel is bounded by the points whose
normals are across it; where that outline is below the rail's, placed without contact forces, they overlap, and each
such place has a plane at the mean place and angle of the rail there, weighted by the overlap's square, as in CONTACT.

References
----------
E. A. H. Vollebregt, User guide for CONTACT, 2023, chapter 3; E. A. H. Vollebregt, Comput. Methods Appl. Mech. Engrg.
424 (2024) 116915; A. A. Shabana, K. E. Zaazaa, H. Sugiyama, Railroad Vehicle Dynamics, 2008, section 3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from fecontact.common.arrays import Array, IntArray
from fecontact.surfaces.profile import Profile

#: Power of the overlap seen along the track, in which its square counts over the plane: its length is as its root.
BY_SQUARE = 2.5
#: Newton's steps on the wheel's surface, and the last one over the radius.
STEPS, SETTLED = 30, 1e-14


@dataclass(frozen=True, eq=False)
class WheelOnRail:
    """A wheel above a rail, both rigid.

    Parameters
    ----------
    wheel, rail : Profile
    radius : float
        Of the wheel at its profile's origin.
    wheel_position, rail_position : float
        Distances of the profiles' origins from the middle of the axle and of the track.
    shift, yaw, roll : float
        Position of the axle: to the left, and counter-clockwise about z and then about x.
    lift : float
        Height of its middle over `radius`.
    """

    wheel: Profile
    rail: Profile
    radius: float
    wheel_position: float
    rail_position: float
    shift: float = 0.0
    yaw: float = 0.0
    roll: float = 0.0
    lift: float = 0.0

    @cached_property
    def axes(self) -> Array:
        """Axes of the axle in columns: forward, along it to the left, upwards."""
        return np.asarray(Rotation.from_euler("ZX", [self.yaw, self.roll]).as_matrix())

    @property
    def middle(self) -> Array:
        """Middle of the axle (3,)."""
        return np.array([0.0, self.shift, self.radius + self.lift])

    @cached_property
    def outline(self) -> tuple[Array, Array]:
        """Points (n, 3) that bound the wheel as seen along the track, not a number where none do, and rail heights."""
        (y, z), (dy, dz) = (a.T for a in self.wheel.samples)
        along, across, upwards = self.axes[0]
        with np.errstate(invalid="ignore", divide="ignore"):
            turn = math.atan2(upwards, along) + np.arcsin(-dz * across / (dy * math.hypot(along, upwards)))
        turn[dy <= 0] = np.nan
        r = self.radius - z
        points = self.middle + np.stack([r * np.sin(turn), self.wheel_position + y, -r * np.cos(turn)], 1) @ self.axes.T
        return points, self.rail.height(points[:, 1] - self.rail_position)

    @property
    def touching_lift(self) -> float:
        """Lift at which the wheel and the rail would just touch; not a number where they are not above each other."""
        points, rail = self.outline
        over = (rail - points[:, 2])[np.isfinite(rail - points[:, 2])]
        return self.lift + float(over.max()) if len(over) else math.nan

    def places(self, join: float = 0.0) -> list[Place]:
        """Places where they overlap, from the inner to the outer one; those nearer than `join` share a plane."""
        points, rail = self.outline
        overlap = np.nan_to_num(rail - points[:, 2], nan=-1.0)
        inside = np.concatenate([[False], overlap > 0, [False]])
        ends = np.flatnonzero(inside[1:] != inside[:-1]).reshape(-1, 2)
        runs = [np.arange(*pair) for pair in ends if pair[1] - pair[0] > 1]
        apart = [math.dist(points[a[-1], 1:], points[b[0], 1:]) >= join for a, b in pairwise(runs)]
        groups = np.split(np.arange(len(runs)), np.flatnonzero(apart) + 1)
        return [self._place(np.concatenate([runs[k] for k in group]), overlap) for group in groups if len(group)]

    def _place(self, run: IntArray, overlap: Array) -> Place:
        x, y, _ = self.outline[0][run].T
        angles = self.rail.angle(y - self.rail_position)
        weight = overlap[run] ** BY_SQUARE * np.gradient(y)
        weight /= weight.sum()
        at, angle = float(weight @ y), float(weight @ angles)
        origin = np.array([weight @ x, at, self.rail.height(at - self.rail_position)])
        ends = (y[[0, -1]] - at) / math.cos(angle)
        return Place(self, origin, angle, (float(ends[0]), float(ends[1])), float(overlap[run].max()) * math.cos(angle))


@dataclass(frozen=True, eq=False)
class Place:
    """A plane of contact of a wheel and a rail.

    Attributes
    ----------
    origin : (3,) array
        On the rail.
    angle : float
        From the track's plane, counter-clockwise seen along x: positive towards the flange.
    ends : (float, float)
        Of the overlap, across the track within the plane, from the origin.
    overlap : float
        The largest one along the plane's normal, nearly.
    """

    pair: WheelOnRail
    origin: Array
    angle: float
    ends: tuple[float, float]
    overlap: float

    @property
    def axes(self) -> Array:
        """Along the track, across it to the left, and normal of the plane, upwards: rows (3, 3)."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])

    def points(self, x: Array, y: Array) -> Array:
        """Points (nx, ny, 3) of the plane at distances along and across from the origin."""
        along, across, _ = self.axes
        return np.asarray(self.origin + np.multiply.outer(x, along)[:, None] + np.multiply.outer(y, across))

    def gap(self, x: Array, y: Array) -> Array:
        """Gap (nx, ny) along the normal, below zero in the overlap, at distances along and across from the origin.

        Infinite beyond the wheel or the rail.
        """
        curve = self.pair.rail.graph(float(self._on_rail[0]), self.angle)
        u, v = self.axes[1:, 1:] @ self._on_rail
        gap = self._wheel_above(x, y) - (curve(u + y) - v)
        return np.where(np.isnan(gap), np.inf, gap)

    def rigid_motion(self, turning: float = 1.0) -> tuple[float, float, float]:
        """Creepages along and across the track, and spin, of the wheel against the rail at the origin.

        They are over the mean of the speeds at which wheel and rail go past the contact.

        Parameters
        ----------
        turning : float
            Speed of the wheel's tread at its nominal radius over that along the track.
        """
        rotation = turning / self.pair.radius * self.pair.axes[:, 1]
        velocity = np.array([1.0, 0.0, 0.0]) + np.cross(rotation, self._touching - self.pair.middle)
        mean = 1 - velocity[0] / 2
        along, across = (self.axes[:2] @ velocity / mean).tolist()
        return along, across, float(self.axes[2] @ rotation / mean)

    @property
    def rolling_radius(self) -> float:
        """Distance of the wheel's surface at the origin from its axle."""
        return float(np.linalg.norm(((self._touching - self.pair.middle) @ self.pair.axes)[[0, 2]]))

    @cached_property
    def _touching(self) -> Array:
        return np.asarray(self.origin + self._wheel_above(np.zeros(1), np.zeros(1))[0, 0] * self.axes[2])

    @property
    def _on_rail(self) -> Array:
        return self.origin[1:] - [self.pair.rail_position, 0.0]

    def _wheel_above(self, x: Array, y: Array) -> Array:
        """Heights (nx, ny) of the wheel over the plane, by Newton's method on its meridian; not a number beyond it."""
        pair, normal = self.pair, self.axes[2]
        n, base = np.zeros((len(x), len(y))), self.points(x, y)
        turned = normal @ pair.axes
        angle = self.angle - pair.roll
        c, s = math.cos(angle), math.sin(angle)
        curve = pair.wheel.graph(float((self.origin - pair.middle) @ pair.axes[:, 1]) - pair.wheel_position, angle)
        slope = curve.derivative()
        for _ in range(STEPS):
            local = (base + n[..., None] * normal - pair.middle) @ pair.axes
            r = np.hypot(local[..., 0], local[..., 2])
            at, z = local[..., 1] - pair.wheel_position, pair.radius - r
            dz = -(local[..., 0] * turned[0] + local[..., 2] * turned[2]) / r
            u, v, du, dv = c * at + s * z, c * z - s * at, c * turned[1] + s * dz, c * dz - s * turned[1]
            step = (curve(u) - v) / (dv - slope(u) * du)
            n = n + step
            if not np.nanmax(np.abs(step), initial=0.0) > SETTLED * pair.radius:
                break
        return n
