"""Where two surfaces touch first, and the size of their contact by Hertz's formulas."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fecontact.analytic.hertz import ellipse
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.surfaces.facet_surface import FacetSurface, Surface
from fecontact.surfaces.section_curve import STEEPEST, along_line

SAMPLES = 9
"""Places along a side of the patch in which gaps are fitted by a parabola."""

MIN_POINTS = 20
"""Places of a patch that must lie on both surfaces: a quarter of them, at a corner of two planes of symmetry."""

MAX_ROUNDS, STEP_TOLERANCE = 12, 0.01
"""Fits at most, and the change of the contact's size that ends them."""

PATCH = 1.5
"""Half the side of the patch relative to the longer semi-axis of the contact."""

LONGEST = 20.0
"""Largest ratio of the axes of a contact that is estimated."""


@dataclass(frozen=True, eq=False)
class Touch:
    """First touch of two surfaces, in the axes of the first.

    Attributes
    ----------
    point : (3,) array
        On the first surface.
    gap : float
        Distance of the surfaces there, negative if they overlap.
    axes : (2, 3) array
        Directions of the shorter and the longer semi-axis.
    semi_axes : (float, float)
        Shorter and longer.
    """

    point: Array
    gap: float
    axes: Array
    semi_axes: tuple[float, float]

    def extents(self, directions: Array) -> Array:
        """Half the extents (n,) of the contact along directions (n, 3)."""
        return np.asarray(np.linalg.norm((directions @ self.axes.T) * self.semi_axes, axis=1))


def first_touch(
    own: FacetSurface,
    other: Surface,
    pose: Pose,
    modulus: float,
    force: float,
    names: tuple[str, str],
    start: Array | None = None,
) -> Touch:
    """First touch of a surface with another one.

    Parameters
    ----------
    own : FacetSurface
    other : Surface
    pose : Pose
        Of the own axes in those of the other.
    modulus : float
        Contact modulus of both.
    force : float
        Size of the load; 0: the surfaces overlap by the approach.
    names : (str, str)
        Of the bodies, for messages.
    start : (3,) array, optional
        Point of the own surface near which to look; else the whole of it is looked at.

    Raises
    ------
    InputError
        If the surfaces do not face each other, or conform, so that the contact has no size by Hertz's formulas.
    """
    point, size = _nearest_node(own, other, pose, names, start)
    semi_axes, least, vectors, tangents = (size, size), math.inf, np.eye(2), np.eye(3)[:2]
    for _ in range(MAX_ROUNDS):
        before, half = semi_axes, PATCH * semi_axes[1]
        found = own.project(point[None])
        point, normal = found.points[0], own.smooth_normals(found)[0]
        x, gap, tangents = _gaps(own, other, pose, point, normal, half)
        if len(gap) < MIN_POINTS:  # the patch reaches over an edge
            semi_axes = (semi_axes[0] / 2, semi_axes[1] / 2)
            continue
        least, slope, bend = _parabola(x, gap)
        values, vectors = np.linalg.eigh(bend)
        if values[1] <= 0:
            raise _conforming(names, values)
        values = np.maximum(values, values[1] / LONGEST**2)
        step = -vectors @ ((vectors.T @ slope) / values)
        step *= min(1.0, half / max(float(np.linalg.norm(step)), 1e-300))
        least += float(slope @ step + step @ bend @ step / 2)
        if force == 0 and least >= 0:
            raise InputError(
                f"{names[0]!r} and {names[1]!r} do not touch: {least:.4g} lies between them, and no force presses them "
                "together. Give a force, or motions that close the gap.",
                code="do-not-touch",
            )
        semi_axes = _semi_axes(values, modulus, force, -least)
        if semi_axes[0] > own.size:
            raise _conforming(names, values)
        point = point + step @ tangents
        if abs(semi_axes[1] / before[1] - 1) < STEP_TOLERANCE and np.linalg.norm(step) < STEP_TOLERANCE * semi_axes[0]:
            break
    if math.isinf(least):
        raise InputError(
            f"{names[0]!r} and {names[1]!r} touch at an edge, near {np.array2string(point, precision=4)}: a window "
            "needs a smooth surface round it. Use the ElasticBody itself with accuracy= when the scene is solved."
        )
    point = own.project(point[None]).points[0]
    return Touch(point, least, vectors.T[::-1] @ tangents, semi_axes)


def _nearest_node(
    own: FacetSurface, other: Surface, pose: Pose, names: tuple[str, str], start: Array | None
) -> tuple[Array, float]:
    """The node nearest to the other surface, of those that face it, or a given point, and the size of faces there."""
    nodes = own.nodes
    if start is not None:
        k = int(np.argmin(np.linalg.norm(own.points[nodes] - start, axis=1)))
        return start, float(own.mean_facet_size[own.facets_of_node[k]].mean()) / PATCH
    with np.errstate(invalid="ignore"):  # far from some shapes there is no closest point: no number, and not seen
        found = other.project(pose.to_world(own.points[nodes]))
    cosine = -((own.mean_normals[nodes] @ pose.rotation.T) * found.normals).sum(axis=1)
    seen = (cosine > STEEPEST) & ~found.outside
    if not seen.any():
        raise InputError(f"No face of {names[0]!r} faces {names[1]!r}; check their poses.")
    gap = np.where(seen, found.gap, np.inf)
    k = int(np.argmin(gap))
    return own.points[nodes[k]], float(own.mean_facet_size[own.facets_of_node[k]].mean()) / PATCH


def _gaps(
    own: FacetSurface, other: Surface, pose: Pose, point: Array, normal: Array, half: float
) -> tuple[Array, Array, Array]:
    """Places (n, 2) in a tangent plane where both surfaces are met, the gaps (n,) there and the tangents (2, 3)."""
    first = np.eye(3)[np.argmin(np.abs(normal))]
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    tangents = np.stack([first, np.cross(normal, first)])
    along = np.linspace(-half, half, SAMPLES)
    x = np.stack([c.ravel() for c in np.meshgrid(along, along, indexing="ij")], axis=1)
    start = point + x @ tangents
    depth, below, lost = along_line(own, start, -normal)
    start = start - depth[:, None] * normal
    gap, found, astray = along_line(other, pose.to_world(start), pose.rotation @ normal)
    there = ~(lost | below.outside | astray | found.outside)
    return x[there], gap[there], tangents


def _parabola(x: Array, gap: Array) -> tuple[float, Array, Array]:
    """Value, slope (2,) and second derivatives (2, 2) at the origin of the parabola that fits gaps best."""
    u, v = x.T
    basis = np.stack([np.ones(len(x)), u, v, u**2 / 2, u * v, v**2 / 2], axis=1)
    scale = np.abs(basis).max(axis=0)
    c = np.linalg.lstsq(basis / scale, gap, rcond=None)[0] / scale
    return float(c[0]), c[1:3], np.array([[c[3], c[4]], [c[4], c[5]]])


def _semi_axes(curvatures: Array, modulus: float, force: float, approach: float) -> tuple[float, float]:
    """Shorter and longer semi-axis of the contact of surfaces with these curvatures of their gap, ascending."""
    radii = ((1 / float(curvatures[0]), 1 / float(curvatures[1])), (math.inf, math.inf))
    load = {"force": force} if force > 0 else {"approach": approach}
    found = ellipse(radii, (Material(E=modulus, nu=0.0), None), **load)
    return found.b, found.a


def _conforming(names: tuple[str, str], curvatures: Array) -> InputError:
    return InputError(
        f"{names[0]!r} and {names[1]!r} conform where they touch: the curvatures of their gap are {curvatures[0]:.3g} "
        f"and {curvatures[1]:.3g}, so the load does not tell the size of the contact. Give at= and window= of the "
        "local body, or use the ElasticBody itself with accuracy= when the scene is solved.",
        code="conforming",
    )
