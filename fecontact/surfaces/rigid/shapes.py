"""Rigid shapes above the plane z = 0, which touches their lowest point.

Each gives `heights` over the plane (infinite where a vertical line misses it), without cancellation near the lowest
point, and `project`, the closest points on it.

The sharpest place of a surface of heights near a point, and the power of the distance with which it rises there.

Ends of rigid shapes that indent a half-space.

Closest points on a surface z = f(x, y) by Newton's method.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.common.checks import number, positive, positives
from fecontact.common.errors import InputError, shown
from fecontact.surfaces.facet_surface import Projection

Heights = Callable[[Array, Array], Array]
Derivatives = Callable[[Array, Array], tuple[Array, Array, Array, Array, Array]]

MAX_ITERATIONS = 60
STEP_TOLERANCE = 1e-14
"""Step, relative to the size of the surface, at convergence."""


def nearest(points: Array, heights: Heights, derivatives: Derivatives, size: float) -> Projection:
    """Projection of points (n, 3) on the surface of a rigid body that fills z >= f(x, y).

    Newton's method on half the squared distance, started vertically above or below, with Gauss-Newton's matrix where
    the Hessian is not positive definite. It finds the closest point for points near the surface, which are those that
    matter.

    Parameters
    ----------
    points : (n, 3) array
    heights : function of x, y
        Infinite where there is no surface.
    derivatives : function of x, y
        f_x, f_y, f_xx, f_xy, f_yy.
    size : float
        A length of the surface.

    Returns
    -------
    Feet
        Points outside the surface are marked.
    """
    X, Y, Z = points.T
    x, y = X.copy(), Y.copy()
    for _ in range(MAX_ITERATIONS):
        f = heights(x, y)
        known = np.isfinite(f)
        f = np.where(known, f, 0.0)
        fx, fy, fxx, fxy, fyy = _finite(derivatives(x, y), known)
        lift = f - Z
        gx, gy = x - X + lift * fx, y - Y + lift * fy
        gauss = (1 + fx**2, fx * fy, 1 + fy**2)
        full = (gauss[0] + lift * fxx, gauss[1] + lift * fxy, gauss[2] + lift * fyy)
        good = (full[0] > 0.1) & (full[0] * full[2] - full[1] ** 2 > 0.1)
        a, b, c = (np.where(good, h, g) for h, g in zip(full, gauss, strict=True))
        det = a * c - b**2
        dx, dy = -(c * gx - b * gy) / det, -(a * gy - b * gx) / det
        x, y = x + dx, y + dy
        if max(float(np.abs(dx).max(initial=0.0)), float(np.abs(dy).max(initial=0.0))) <= STEP_TOLERANCE * size:
            break
    f = heights(x, y)
    outside = ~np.isfinite(f)
    f = np.where(outside, 0.0, f)
    fx, fy = _finite(derivatives(x, y)[:2], ~outside)
    normals = np.stack([fx, fy, -np.ones_like(fx)], axis=1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    projection = np.stack([x, y, f], axis=1)
    gap = np.einsum("ni,ni->n", points - projection, normals)
    return Projection(points - gap[:, None] * normals, normals, gap, outside)


def _finite(derivatives: Sequence[Array], known: Mask) -> list[Array]:
    """Derivatives with zeros off the surface, and at its rim, across which there are none."""
    return [np.where(known & np.isfinite(d), d, 0.0) for d in derivatives]


def differences(heights: Heights, step: float) -> Derivatives:
    """Derivatives of a function by central differences.

    Examples
    --------
    >>> import numpy as np
    >>> by = differences(lambda x, y: x**2 * y, 1e-3)
    >>> [round(float(d[0]), 6) for d in by(np.array([2.0]), np.array([3.0]))]
    [12.0, 4.0, 6.0, 4.0, 0.0]
    """

    def derivatives(x: Array, y: Array) -> tuple[Array, Array, Array, Array, Array]:
        h = step
        f = heights(x, y)
        e, w, n, s = heights(x + h, y), heights(x - h, y), heights(x, y + h), heights(x, y - h)
        ne, se, nw, sw = heights(x + h, y + h), heights(x + h, y - h), heights(x - h, y + h), heights(x - h, y - h)
        with np.errstate(invalid="ignore"):  # beyond the rim heights are infinite
            return (
                (e - w) / (2 * h),
                (n - s) / (2 * h),
                (e - 2 * f + w) / h**2,
                (ne - se - nw + sw) / (4 * h**2),
                (n - 2 * f + s) / h**2,
            )

    return derivatives


#: Samples along each side of a square, halves of whose sides the search divides, how often, and by how much.
SAMPLES, TIMES, CLOSER = 33, 6, 4
#: Distances, as parts of the first square's half, between which the power is read.
FAR, NEAR = 1 / 8, 1 / 512
#: Rounding of heights, relative to the largest, below which a rise is none.
ROUNDING = 1e-12


class Tip(NamedTuple):
    """Place (2,) of the largest second difference, power of the distance there, and mean slope beside it."""

    place: Array
    power: float
    slope: float


def sharpest(heights: Callable[[Array, Array], Array], centre: Array, reach: float) -> Tip:
    """The sharpest convex place of a surface within a square round a point.

    The power is 1 at the tip of a cone and the ridge of a wedge, 2 where the surface is smooth or has no rise.

    Parameters
    ----------
    heights : function of x, y
    centre : (2,) array
    reach : float
        Half of the square's side.

    Examples
    --------
    >>> cone = lambda x, y: 0.1 * np.hypot(x - 0.1, y)
    >>> tip = sharpest(cone, np.zeros(2), 0.3)
    >>> tip.place.round(4).tolist(), round(tip.power, 2), round(tip.slope, 2)
    ([0.1, 0.0], 1.0, 0.1)
    >>> round(sharpest(lambda x, y: x**2 + y**2, np.zeros(2), 0.3).power, 6)
    2.0
    """
    offsets, half = np.linspace(-1, 1, SAMPLES), reach
    for _ in range(TIMES):
        x, y = centre[:, None] + half * offsets
        z = np.asarray(heights(x[:, None], y[None, :]), dtype=float)
        z = np.where(np.isfinite(z), z, np.nan)
        middle = 2 * z[1:-1, 1:-1]
        bend = np.fmax(z[2:, 1:-1] + z[:-2, 1:-1] - middle, z[1:-1, 2:] + z[1:-1, :-2] - middle)
        if not (bend > ROUNDING * np.nanmax(np.abs(z), initial=0.0)).any():
            break
        i, j = np.unravel_index(int(np.nanargmax(bend)), bend.shape)
        centre, half = np.array([x[i + 1], y[j + 1]]), half / CLOSER
    far, near = (_rise(heights, centre, part * reach) for part in (FAR, NEAR))
    level = ROUNDING * max(abs(float(heights(centre[:1], centre[1:])[0])), reach)
    if not (far > near > level):
        return Tip(centre, 2.0, 0.0)
    return Tip(centre, float(np.log(far / near) / np.log(FAR / NEAR)), far / (FAR * reach))


def _rise(heights: Callable[[Array, Array], Array], centre: Array, distance: float) -> float:
    """Mean height at four points around a point over that at it."""
    around = centre + distance * np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [0, 0]])
    z = heights(around[:, 0], around[:, 1])
    return float(np.mean(z[:4]) - z[4])


def heights_of(shape: object) -> Callable[[Array, Array], Array] | None:
    """Function for the heights of a shape over the plane z = 0 at x and y; None where it has none."""
    return getattr(shape, "heights", None)


class Indenter:
    """Defaults for a finite shape."""

    #: Its kind, by which tables have what belongs to it, as closed forms.
    kind: ClassVar[str] = ""
    #: Whether contact may reach its ends along x and along y.
    open_ends: ClassVar[tuple[bool, bool]] = (False, False)

    @property
    def is_endless(self) -> bool:
        """Whether it touches a plane up to the border of any grid."""
        return False


#: Part of a radius or half a side up to which a point is within it, rounding included.
AT_RIM = 1 + 1e-9
#: Distance from an axis, relative to the coordinates, that is rounding.
ON_AXIS = 1e-12


def _round(distance2: Array, radius: float) -> Array:
    """Height of a circle's underside, d^2/(R + sqrt(R^2 - d^2)); infinite beyond the radius."""
    under = radius**2 - distance2
    safe = radius + np.sqrt(np.maximum(under, 0.0))
    return np.where(under >= 0, distance2 / safe, np.inf)


def _circle(planar: Array, z: Array, radius: float) -> tuple[Array, Array, Array]:
    """Gap to a circle of given radius about (0, radius), and the unit normal (in the plane, along z) there."""
    height = z - radius
    distance = np.hypot(planar, height)
    gap = (planar**2 + z**2 - 2 * z * radius) / (distance + radius)
    safe = np.where(distance > 0, distance, 1.0)
    return gap, planar / safe, np.where(distance > 0, height / safe, -1.0)


def _projection(points: Array, normals: Array, gap: Array, outside: Mask | None = None) -> Projection:
    none = np.zeros(len(points), bool) if outside is None else outside
    return Projection(points - gap[:, None] * normals, normals, gap, none)


@dataclass(frozen=True)
class Paraboloid(Indenter):
    """Hertz's surface z = x^2/(2 Rx) + y^2/(2 Ry).

    Parameters
    ----------
    radius_x : float
    radius_y : float, optional
        Equal to the first by default.

    Examples
    --------
    >>> import numpy as np
    >>> Paraboloid(2.0).heights(np.array([2.0]), np.array([2.0])).tolist()
    [2.0]
    """

    kind = "paraboloid"
    radius_x: float
    radius_y: float | None = None

    def __post_init__(self) -> None:
        positive("a paraboloid's radius of curvature", self.radius_x)
        object.__setattr__(self, "radius_y", self.radius_x if self.radius_y is None else self.radius_y)
        positive("a paraboloid's radius of curvature", self.curvature_radii[1])

    @property
    def curvature_radii(self) -> tuple[float, float]:
        """Radii of curvature along x and y."""
        assert self.radius_y is not None
        return self.radius_x, self.radius_y

    @property
    def size(self) -> float:
        """The smaller radius of curvature."""
        return min(self.curvature_radii)

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at coordinates that broadcast together."""
        rx, ry = self.curvature_radii
        return x**2 / (2 * rx) + y**2 / (2 * ry)

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3)."""
        rx, ry = self.curvature_radii

        def derivatives(x: Array, y: Array) -> tuple[Array, Array, Array, Array, Array]:
            one = np.ones_like(x)
            return x / rx, y / ry, one / rx, 0 * one, one / ry

        return nearest(points, self.heights, derivatives, self.size)


@dataclass(frozen=True)
class Cylinder(Indenter):
    """A cylinder along y that touches z = 0 on the line x = 0.

    Parameters
    ----------
    radius : float
    length : float, optional
        It ends at y = -length/2 and length/2; infinite by default.

    Examples
    --------
    >>> import numpy as np
    >>> Cylinder(1.0, length=2.0).heights(np.array([0.6, 0.0]), np.array([0.0, 1.5])).round(12).tolist()
    [0.2, inf]
    """

    kind = "cylinder"
    open_ends: ClassVar = (False, True)

    radius: float
    length: float = math.inf

    def __post_init__(self) -> None:
        positive("a cylinder's radius", self.radius)
        if number(self.length) != math.inf:
            positive("a cylinder's length", self.length)

    @property
    def is_endless(self) -> bool:
        """Whether it would touch a plane to the border of any grid."""
        return math.isinf(self.length)

    @property
    def size(self) -> float:
        """Diameter."""
        return 2 * self.radius

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at coordinates that broadcast together."""
        return np.where(np.abs(y) <= AT_RIM * self.length / 2, _round(np.asarray(x) ** 2, self.radius), np.inf)

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3) on the curved face."""
        gap, along, up = _circle(points[:, 0], points[:, 2], self.radius)
        normals = np.stack([along, np.zeros_like(along), up], axis=1)
        return _projection(points, normals, gap, np.abs(points[:, 1]) > AT_RIM * self.length / 2)


@dataclass(frozen=True)
class Cone(Indenter):
    """A cone with its tip at the origin, axis z.

    Parameters
    ----------
    angle : float
        Between its flank and the plane z = 0 (radians), between 0 and pi/2.

    Examples
    --------
    >>> import numpy as np
    >>> Cone(np.pi / 4).heights(np.array([3.0]), np.array([4.0])).round(12).tolist()
    [5.0]
    """

    kind = "cone"
    angle: float

    def __post_init__(self) -> None:
        if not 0 < number(self.angle) < math.pi / 2:
            raise InputError(
                f"A cone's angle to the plane must lie between 0 and pi/2 (radians); found {shown(self.angle)}."
            )
        positive("a cone's angle", self.angle)

    @property
    def size(self) -> float:
        """A cone has no intrinsic length."""
        return 1.0

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at coordinates that broadcast together."""
        return np.hypot(x, y) * math.tan(self.angle)

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3) on the flank or the tip."""
        r, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
        c, s = math.cos(self.angle), math.sin(self.angle)
        # on the axis all directions of the flank are as near: the tip is taken, along the axis
        centred = r <= ON_AXIS * np.abs(points).max(initial=0.0)
        outwards = np.divide(points[:, :2], r[:, None], out=np.zeros((len(r), 2)), where=~centred[:, None])
        normals = np.concatenate([s * outwards, np.full((len(r), 1), -c)], axis=1)
        normals[centred, 2] = -1.0
        gap = np.where(centred, -z, s * r - c * z)
        distance = np.linalg.norm(points, axis=1)
        off = ~centred & (c * r + s * z <= 0)
        normals[off] = points[off] / distance[off, None]
        return _projection(points, normals, np.where(off, distance, gap))


@dataclass(frozen=True)
class FlatPunch(Indenter):
    """The flat end of a cylinder (radius) or of a prism (sides), in the plane z = 0.

    Parameters
    ----------
    radius : float, optional
    sides : (float, float), optional
        Along x and y. Exactly one of the two.

    Examples
    --------
    >>> import numpy as np
    >>> FlatPunch(radius=1.0).heights(np.array([0.5, 1.5]), np.zeros(2)).tolist()
    [0.0, inf]
    """

    kind = "flat_punch"
    open_ends: ClassVar = (True, True)

    radius: float | None = None
    sides: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if (self.radius is None) == (self.sides is None):
            raise InputError("A flat punch needs either a radius or two sides.")
        if self.radius is not None:
            positive("a flat punch's radius", self.radius)
        else:
            object.__setattr__(self, "sides", positives("a flat punch's sides", self.sides, 2))

    @property
    def size(self) -> float:
        """Diameter, or the longer side."""
        return 2 * self.radius if self.radius is not None else max(self.sides or (0.0,))

    def _inside(self, x: Array, y: Array) -> Mask:
        if self.radius is not None:
            return np.hypot(x, y) <= AT_RIM * self.radius
        assert self.sides is not None
        return (np.abs(x) <= AT_RIM * self.sides[0] / 2) & (np.abs(y) <= AT_RIM * self.sides[1] / 2)

    def heights(self, x: Array, y: Array) -> Array:
        """Zero under the punch, infinite elsewhere."""
        return np.where(self._inside(x, y), 0.0, np.inf)

    def project(self, points: Array) -> Projection:
        """Projection along z; points next to the punch are outside it."""
        normals = np.tile([0.0, 0.0, -1.0], (len(points), 1))
        return _projection(points, normals, -points[:, 2], ~self._inside(points[:, 0], points[:, 1]))


@dataclass(frozen=True)
class Ellipsoid(Indenter):
    """An ellipsoid with semi-axes along x, y and z.

    Parameters
    ----------
    semi_axes : (float, float, float)

    Examples
    --------
    >>> import numpy as np
    >>> Ellipsoid((2.0, 1.0, 1.0)).heights(np.array([1.2]), np.zeros(1)).round(12).tolist()
    [0.2]
    """

    kind = "ellipsoid"
    semi_axes: tuple[float, float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "semi_axes", positives("an ellipsoid's semi-axes", self.semi_axes, 3))

    @property
    def size(self) -> float:
        """Longest axis."""
        return 2 * max(self.semi_axes)

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at coordinates that broadcast together; infinite beyond the outline."""
        a, b, c = self.semi_axes
        return c * _round((x / a) ** 2 + (y / b) ** 2, 1.0)

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3) on the lower half."""
        return nearest(points, self.heights, differences(self.heights, 1e-4 * min(self.semi_axes)), self.size)

    def may_hold(self, points: Array, radius: float) -> Mask:
        """Whether balls round points (n, 3) may reach into it; `project` covers the lower half only."""
        reach = np.array(self.semi_axes) + radius
        return np.asarray((((points - [0.0, 0.0, self.semi_axes[2]]) / reach) ** 2).sum(axis=1) <= 1)


@dataclass(frozen=True)
class Torus(Indenter):
    """A torus that touches z = 0 on the circle x^2 + y^2 = ring^2.

    Parameters
    ----------
    ring : float
        Radius of the circle.
    tube : float
        Radius of the tube, less than that of the ring.

    Examples
    --------
    >>> import numpy as np
    >>> Torus(ring=5.0, tube=1.0).heights(np.array([5.0, 5.6, 0.0]), np.zeros(3)).round(12).tolist()
    [0.0, 0.2, inf]
    """

    kind = "torus"
    ring: float
    tube: float

    def __post_init__(self) -> None:
        positive("a torus's ring radius", self.ring)
        if positive("a torus's tube radius", self.tube) >= self.ring:
            raise InputError(f"A torus's tube ({self.tube:g}) must be thinner than its ring ({self.ring:g}).")

    @property
    def size(self) -> float:
        """Outer diameter."""
        return 2 * (self.ring + self.tube)

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at coordinates that broadcast together."""
        return _round((np.hypot(x, y) - self.ring) ** 2, self.tube)

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3)."""
        r = np.hypot(points[:, 0], points[:, 1])
        gap, along, up = _circle(r - self.ring, points[:, 2], self.tube)
        outwards = np.divide(points[:, :2], r[:, None], out=np.zeros((len(r), 2)), where=r[:, None] > 0)
        outwards[r == 0, 0] = 1.0
        return _projection(points, np.concatenate([along[:, None] * outwards, up[:, None]], axis=1), gap)
