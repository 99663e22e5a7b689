"""Smooth outline of a contact: the zero set of a polynomial in two coordinates along its faces.

    phi(x, y) = 1 - sum_k a_k h_k(x, y),   h_0 = x^2 + y^2,   h_m = Re (x + i y)^m and Im (x + i y)^m

x and y are relative to the semi-axes of an ellipse with the same centre and second moments. The first term changes the
size of the outline, degree 1 its place, degree 2 its axes, higher ones its shape: circles and ellipses are exact with
degree 2. Near the outline phi is twice the distance to it, relative to its size.

Smooth curves through scattered points in order: waves shorter than a length are removed, longer ones are kept.

Points at equal steps along the curve are replaced by those that minimise the sum of squared offsets and of squared
third differences (Whittaker 1923, *On a new method of graduation*; Eilers 2003, *A perfect smoother*). Of a wave of
length L the share 1 / (1 + (L0 / L)^6) is left, nearly all or nothing: with L0 half the circumference a circle keeps
98.5 % of its radius, with a fifth 99.994 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.surfaces.facet_surface import FacetSurface

#: Distance from the centre, relative to the outline's size, beyond which nothing is inside; terms of high
#: degree return there.
FARTHEST = 1.6
#: Largest change of a term by a reflection, relative to its size, that counts as rounding.
EVEN = 1e-9
#: Directions in which an outline is looked at, and steps of Newton's method to it.
RING, NEWTON = 96, 8
#: Distance from the centre, relative to the size, within which directions fade out.
NEAR_CENTRE = 1e-3


@dataclass(frozen=True, eq=False)
class Mirror:
    """A plane of symmetry: a point (3,) on it and its unit normal (3,)."""

    point: Array
    normal: Array

    def image(self, points: Array) -> Array:
        """Mirror images (..., 3) of points."""
        return np.asarray(points - 2 * ((points - self.point) @ self.normal)[..., None] * self.normal)


@dataclass(frozen=True, eq=False)
class Outline:
    """Outline of one connected contact area.

    Attributes
    ----------
    centre : (3,) array
    axes : (2, 3) array
        Unit vectors along the faces, divided by the semi-axes of the first ellipse.
    modes : (k, 2) int array
        Degree of each term, and 0 for its real or 1 for its imaginary part; degree 0 is x^2 + y^2.
    coefficients : (k,) array

    Examples
    --------
    >>> circle = Outline(np.zeros(3), np.eye(3)[:2] / 2.0, np.array([[0, 0]]), np.ones(1))
    >>> circle.level(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0]])).tolist()
    [1.0, 0.0, 0.75]
    """

    centre: Array
    axes: Array
    modes: IntArray
    coefficients: Array

    @property
    def semi_axes(self) -> tuple[float, float]:
        """Semi-axes of the ellipse by the terms of degree 0 and 2, the longer first; those of other degrees apart."""
        quadratic = {(0, 0): np.eye(2), (2, 0): np.diag([1.0, -1.0]), (2, 1): np.array([[0.0, 1.0], [1.0, 0.0]])}
        form = np.zeros((2, 2))
        for mode, a in zip(self.modes.tolist(), self.coefficients, strict=True):
            form += a * quadratic.get(tuple(mode), np.zeros((2, 2)))
        over = np.linalg.norm(self.axes, axis=1)
        long, short = np.linalg.eigvalsh(form * np.outer(over, over)) ** -0.5
        return float(long), float(short)

    def terms(self, points: Array) -> Array:
        """Values (..., k) of the terms h at points (..., 3)."""
        x, y = np.moveaxis((points - self.centre) @ self.axes.T, -1, 0)
        z, square = x + 1j * y, x**2 + y**2
        found = [square if m == 0 else (z**m).imag if part else (z**m).real for m, part in self.modes]
        return np.stack(found, axis=-1)

    def level(self, points: Array) -> Array:
        """Level phi (...,) at points (..., 3): positive inside, zero on the outline."""
        square = (((points - self.centre) @ self.axes.T) ** 2).sum(axis=-1)
        inside = 1 - self.terms(points) @ self.coefficients
        return np.where(square < FARTHEST**2, inside, np.minimum(inside, 1 - square))

    def ring(self) -> Array:
        """Points (n, 3) round the centre, on the first ellipse."""
        angle = np.linspace(0.0, 2 * np.pi, RING, endpoint=False)
        return self.centre + np.stack([np.cos(angle), np.sin(angle)], 1) @ np.linalg.pinv(self.axes).T

    def angular_terms(self, points: Array) -> Array:
        """Terms (..., k) at points (..., 3) over powers of the distance from the centre."""
        radius = np.linalg.norm((points - self.centre) @ self.axes.T, axis=-1)
        power = np.where(self.modes[:, 0] == 0, 2, self.modes[:, 0])
        return np.asarray(self.terms(points) / np.maximum(radius, NEAR_CENTRE)[..., None] ** power)

    @property
    def area(self) -> float:
        """Area inside, along the faces: half the mean square of the radius over all directions, times 2 pi."""
        shapes, radius = self.angular_terms(self.ring()), np.ones(RING)
        power = np.where(self.modes[:, 0] == 0, 2, self.modes[:, 0])
        for _ in range(NEWTON):
            terms = shapes * self.coefficients * radius[:, None] ** power
            radius = radius + (1 - terms.sum(axis=1)) * radius / (terms * power).sum(axis=1)
        over = np.linalg.norm(self.axes, axis=1)
        return float(np.pi * (radius**2).mean() / over.prod())

    def moved(self, change: Array) -> Outline:
        """The outline with its coefficients changed (k,)."""
        return replace(self, coefficients=self.coefficients + change)

    def to_degree(self, degree: int, mirrors: Sequence[Mirror]) -> Outline:
        """The same outline with all terms up to a degree that planes of symmetry leave unchanged."""
        every = [(0, 0), *((m, part) for m in range(1, degree + 1) for part in (0, 1))]
        full = replace(self, modes=np.array(every))
        ring = self.ring()
        kept = np.ones(len(every), bool)
        for mirror in mirrors:
            kept &= np.abs(full.terms(mirror.image(ring)) - full.terms(ring)).max(axis=0) < EVEN
        own = {tuple(mode): a for mode, a in zip(self.modes.tolist(), self.coefficients, strict=True)}
        modes = full.modes[kept]
        return replace(self, modes=modes, coefficients=np.array([own.get(tuple(m), 0.0) for m in modes.tolist()]))


def ellipse_of_moments(points: Array, forces: Array, normal: Array, mirrors: Sequence[Mirror]) -> Outline:
    """Ellipse with the centre and second moments of forces, taken for those of half an ellipsoid of pressure.

    For p = p0 sqrt(1 - x^2/a^2 - y^2/b^2) the mean of x^2, weighted by force, is a^2/5 (Johnson 1985, section 4.2, by
    integration).

    Parameters
    ----------
    points : (n, 3) array
    forces : (n,) array
    normal : (3,) array
        Mean normal of the faces; its part across planes of symmetry does not count.
    mirrors : sequence of Mirror
        Planes of symmetry at which the points end.
    """
    points, forces = with_images(points, forces, mirrors)
    for mirror in mirrors:
        normal = normal - (normal @ mirror.normal) * mirror.normal
    normal = normal / np.linalg.norm(normal)
    centre = forces @ points / forces.sum()
    offset = points - centre
    moments = (offset * forces[:, None]).T @ offset / forces.sum()
    along = np.linalg.svd(normal[None])[2][1:] if not mirrors else _across(normal, mirrors[0].normal)
    if not mirrors:
        along = np.linalg.eigh(along @ moments @ along.T)[1].T @ along
    spread = np.einsum("di,ij,dj->d", along, moments, along)
    return Outline(centre, along / np.sqrt(5 * spread)[:, None], np.array([[0, 0]]), np.ones(1))


def planes_of_symmetry(surface: FacetSurface, pose: Pose, numbers: IntArray) -> tuple[Mirror, ...]:
    """Planes of symmetry, in world axes, of a body's surface on which some of the numbered nodes lie."""
    if surface.planes is None:
        return ()
    nodes, normals = surface.planes
    on = np.isin(nodes, numbers)
    nodes, normals = nodes[on], normals[on]
    first = np.sort(np.unique(normals.round(6), axis=0, return_index=True)[1])
    points = pose.to_world(surface.points[nodes[first]])
    return tuple(Mirror(x, n) for x, n in zip(points, normals[first] @ pose.rotation.T, strict=True))


def with_images(points: Array, values: Array, mirrors: Sequence[Mirror]) -> tuple[Array, Array]:
    """Points (n, 3) and values (n,) with their mirror images."""
    for mirror in mirrors:
        points = np.concatenate([points, mirror.image(points)])
        values = np.concatenate([values, values])
    return points, values


def _across(normal: Array, plane: Array) -> Array:
    """Two unit vectors (2, 3) normal to a normal: the first along that of a plane of symmetry."""
    first = plane - (plane @ normal) * normal
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


#: Length of a wave of which half is left, in steps of scatter, and at most as a share of a closed curve.
WAVE, LARGEST_SHARE = 3.0, 0.25
#: Points for each step of scatter, and on a curve at least.
DENSITY, FEWEST = 6, 24
#: Length beyond the ends of a stretch, in waves, by which it is continued.
CONTINUED = 3
#: Distance from a plane of symmetry, in steps, that is on it.
ON_PLANE = 1e-3
#: Order of the differences.
ORDER = 3


def smoothed(points: Array, smooth: Mask, step: Array, mirrors: Sequence[Mirror] = ()) -> tuple[Array, Mask]:
    """A closed curve with some stretches smoothed, and which of its segments these are.

    Parameters
    ----------
    points : (n, d) array
        In order; the first follows the last.
    smooth : (n,) bool array
        Whether the segment from a point to the next is to be smoothed. Ends of a stretch stay where they are.
    step : (n,) array
        Length of the scatter at each point, such as the size of a facet.
    mirrors : sequence of Mirror
        Planes of symmetry: a stretch that ends on one is smooth with its mirror image.

    Examples
    --------
    A circle of 24 facets, its points off by a tenth of a facet to either side in turn:

    >>> angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    >>> radius = 1 + 0.026 * (-1.0) ** np.arange(48)
    >>> circle = np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)
    >>> found, _ = smoothed(circle, np.ones(48, bool), np.full(48, 0.26))
    >>> bool(np.ptp(np.linalg.norm(found, axis=1)) < 2e-3)
    True
    """
    if smooth.all():
        found = _graduated(np.concatenate([points, points[:1]]), np.append(step, step[0]), closed=True)
        return found, np.ones(len(found), bool)
    if not smooth.any():
        return points, smooth
    start = int(np.flatnonzero(~smooth)[0])
    points, smooth, step = np.roll(points, -start, axis=0), np.roll(smooth, -start), np.roll(step, -start)
    breaks = np.flatnonzero(np.diff(smooth.astype(int))) + 1
    parts, kinds = [], []
    for chosen in np.split(np.arange(len(points)), breaks):
        piece = points[chosen]
        if smooth[chosen[0]]:
            ends = np.append(chosen, (chosen[-1] + 1) % len(points))
            piece = _graduated(points[ends], step[ends], mirrors=mirrors)[:-1]
        parts.append(piece)
        kinds.append(np.full(len(piece), smooth[chosen[0]]))
    return np.concatenate(parts), np.concatenate(kinds)


def _graduated(points: Array, step: Array, *, closed: bool = False, mirrors: Sequence[Mirror] = ()) -> Array:
    """Smoothed points (k, d) at equal steps along a polyline (n, d); of a closed one without the last."""
    place = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1) * 2 / (step[1:] + step[:-1])))
    n = max(FEWEST, int(np.ceil(DENSITY * place[-1])))
    even = np.linspace(0.0, place[-1], n + 1)
    x = np.stack([np.interp(even, place, column) for column in points.T], axis=1)
    # a stretch is half of a curve or less
    wave = n / place[-1] * min(WAVE, (1 if closed else 2) * LARGEST_SHARE * place[-1])
    beyond = min(n, int(np.ceil(CONTINUED * wave)))
    if closed:
        x = x[:-1]
        long = np.concatenate([x[-beyond:], x, x[:beyond]])
    else:
        first = _reflected(x[1 : beyond + 1], x[0], ON_PLANE * step[0], mirrors)[::-1]
        last = _reflected(x[-beyond - 1 : -1][::-1], x[-1], ON_PLANE * step[-1], mirrors)
        long = np.concatenate([first, x, last])
    rough = sp.eye_array(len(long), format="csc")
    for k in range(ORDER):
        rough = sp.diags_array([-1.0, 1.0], offsets=[0, 1], shape=(len(long) - k - 1, len(long) - k)) @ rough
    penalty = (2 * np.sin(np.pi / wave)) ** (-2 * ORDER)
    found = spsolve(sp.csc_array(sp.eye_array(len(long)) + penalty * rough.T @ rough), long)
    return np.asarray(found[beyond : beyond + len(x)])


def _reflected(points: Array, end: Array, near: float, mirrors: Sequence[Mirror]) -> Array:
    """Points (n, d) beyond an end: mirror images if it lies on a plane of symmetry, else images in the end itself."""
    for mirror in mirrors:
        if abs((end - mirror.point) @ mirror.normal) < near:
            return mirror.image(points)
    return np.asarray(2 * end - points)
