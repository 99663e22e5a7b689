"""Where the window of a local body lies: its middle on the surface, its directions, its planes of symmetry.

Where two surfaces touch first, and the size of their contact by Hertz's formulas.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.analytic.hertz import ellipse
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.local.window import MAX_SLOPE, Relief, Window, fit
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import vector
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.support import symmetry_planes
from fecontact.halfspace.grid import Even, Grid
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.placement import Placement
from fecontact.surfaces.facet_surface import FacetSurface, Surface
from fecontact.surfaces.section_curve import STEEPEST, along_line

#: Distance from the surface, relative to the window, within which the middle of a window is put on it.
ON_SURFACE = 0.05

#: Depth below the tangent plane, relative to the body's size, up to which a surface is flat.
FLAT = 1e-7

#: Distance from a smooth surface, relative to the window, above which a surface has kinks.
KINKS = 3e-3

#: Places along a side of a window at which its surface is checked.
SAMPLES = 10

#: Adjustments of a window to its surface, their size when it has settled, and the difference of two principal
#: curvatures, relative to the larger, up to which every direction is principal.
MAX_ITERATIONS, STEP_TOLERANCE, ROUND = 8, 1e-12, 1e-3

REMEDY = "Take a smaller window, or use the ElasticBody itself with accuracy= when the scene is solved."

#: Distance from a plane of symmetry, relative to the body's size, within which the middle lies on it.
THROUGH = 1e-9

#: Sine of an angle that is rounding.
ALONG = 1e-9


def place_window(body: ElasticBody, at: Array, size: tuple[float, float], shape: tuple[int, int]) -> Window:
    """The window of a body at a point (3,) of its surface, of given sides and numbers of cells.

    Its first direction is normal to a plane of symmetry through the point, if there is one, else the axis of the mesh
    that is the nearest to the surface.

    Raises
    ------
    InputError
        If the point is not on the surface.
    """
    if max(size) > body.size:
        raise InputError(
            f"A window of {size[0]:g} x {size[1]:g} is larger than {body.name!r}, {body.size:.4g}. {REMEDY}"
        )
    planes = planes_through(body, at)
    skin = _skin(body, at, planes)
    found = skin.project(at[None])
    away = float(np.linalg.norm(found.points[0] - at))
    if away > ON_SURFACE * min(size):
        raise InputError(
            f"The middle of the window, at={np.array2string(at, precision=6)}, must lie on the surface of "
            f"{body.name!r}; it is {away:.4g} from it. The nearest point of the surface is "
            f"{np.array2string(found.points[0], precision=6)}.",
            code="window-off-surface",
        )
    assert found.facet is not None
    assert found.local is not None
    axes, mirrored = _directions(body, planes, skin.normals(found.facet, found.local)[0])
    counts = tuple(n + n % 2 if even else n for n, even in zip(shape, mirrored, strict=True))
    window = Window(found.points[0], axes, Grid(size, (counts[0], counts[1])), mirrored)
    return _on_relief(body, window, skin, _geometry(body, skin.facets[found.facet[0]]), turning=not any(mirrored))


def facing_window(body: ElasticBody, other: Window, pose: Pose, names: tuple[str, str]) -> Window:
    """The window of a body whose cells lie opposite those of another body's.

    Parameters
    ----------
    body : ElasticBody
    other : Window
    pose : Pose
        Of the other's axes in the body's.
    names : (str, str)
        Of the body and the other one, for messages.

    Raises
    ------
    InputError
        If the body is not opposite, or has other planes of symmetry.
    """
    axes = pose.rotation @ other.axes * np.array([1.0, 1.0, -1.0])
    plane = pose.to_world(other.origin[None])
    skin = FacetSurface(body.model.mesh.points, body.model.mesh.skin)
    travel, _, lost = along_line(skin, plane, -axes[:, 2])
    at = plane[0] - travel[0] * axes[:, 2]
    planes = planes_through(body, at)
    mirrored = tuple(any(d @ axes[:, k] > 1 - ALONG for d in planes) for k in (0, 1))
    if lost[0] or mirrored != other.mirrored or len(planes) != sum(mirrored):
        raise InputError(
            f"{names[0]!r} has no window opposite that of {names[1]!r}: "
            + ("its surface is not there." if lost[0] else "their planes of symmetry are not the same."),
            code="no-opposite-window",
        )
    skin = _skin(body, at, planes)
    found = skin.project(at[None])
    assert found.facet is not None
    window = Window(at, axes, other.grid, other.mirrored)
    return _on_relief(body, window, skin, _geometry(body, skin.facets[found.facet[0]]), turning=None)


def _geometry(body: ElasticBody, facet: IntArray) -> Surface | None:
    """The surface that the contact boundary with a facet was placed on; None for one that is as its mesh."""
    mesh = body.model.mesh
    assert isinstance(body.geometry, Mapping)
    for name, made in body.geometry.items():
        if isinstance(made, Placement):
            corners = np.sort(mesh.face_nodes(mesh.faces(name))[:, :4], axis=1)
            if (corners == np.sort(facet[:4])).all(axis=1).any():
                return cast(Surface, made.surface)
    return None


def _on_relief(
    body: ElasticBody, window: Window, skin: FacetSurface, geometry: Surface | None, turning: bool | None
) -> Window:
    """The window with the relief of its surface, tangent to it, along the directions of principal curvature.

    With `turning` False its directions stay in their planes, with None they stay as they are.

    Raises
    ------
    InputError
        If the surface ends within the window, has kinks, or is too steep.
    """
    for _ in range(MAX_ITERATIONS):
        depths = _Depths(window, skin, geometry)
        relief = fit(depths, window.half, window.mirrored)
        x, y = window.node_places(SAMPLES)
        if not np.isfinite(depths(x, y)).all():
            raise _ends(body, window, depths(x, y))
        if np.abs(relief.depth(x, y)).max() <= FLAT * body.size:
            return window
        if turning is None:
            break
        turn = _turn(relief, turning)
        if np.abs(turn - np.eye(3)).max() < STEP_TOLERANCE:
            break
        window = replace(window, axes=window.axes @ turn)
    if relief.misfit > KINKS * float(window.half.min()):
        raise InputError(
            f"The surface of {body.name!r} in its window, sides {window.grid.size}, has kinks: it departs by "
            f"{relief.misfit:.3g} from a smooth one. {REMEDY}",
            code="surface-has-kinks",
        )
    steepest = float(np.linalg.norm(relief.slopes(x, y), axis=1).max())
    if steepest > MAX_SLOPE:
        raise InputError(
            f"The surface of {body.name!r} inclines by {steepest:.2g} to the tangent plane within its window, sides "
            f"{window.grid.size}; up to {MAX_SLOPE:g} is possible. {REMEDY}",
            code="surface-too-steep",
        )
    window = replace(window, relief=relief)
    start = window.on_surface(*window.places)
    further, _, _ = along_line(geometry or skin, start, -window.normal, facing=geometry is None)
    return replace(window, depths=relief.depth(*window.places) + further)


def _ends(body: ElasticBody, window: Window, depths: Array) -> InputError:
    x, y = window.node_places(SAMPLES)
    place = window.at(x, y)[np.argmin(np.isfinite(depths))]
    return InputError(
        f"The window of {body.name!r}, sides {window.grid.size} about {np.array2string(window.origin, precision=4)}, "
        f"reaches across an edge: below its point {np.array2string(place, precision=4)} there is no surface that goes "
        f"on smoothly from the middle. {REMEDY}",
        code="window-across-edge",
    )


def _turn(relief: Relief, turning: bool) -> Array:
    """Rotation of a window's axes (3, 3) that makes it tangent in its middle and, if it may turn there, principal."""
    middle = np.zeros(1)
    slopes = relief.slopes(middle, middle)[0]
    normal = np.array([*slopes, 1.0]) / np.sqrt(1 + slopes @ slopes)
    values, vectors = np.linalg.eigh(relief.hessian(middle, middle)[0])
    first = np.array([1.0, 0.0, 0.0])
    if turning and values[1] - values[0] > ROUND * np.abs(values).max():
        # the direction nearer to the first of the axes
        one = vectors[:, np.argmax(np.abs(vectors[0]))]
        first[:2] = one * np.sign(one[0])
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first), normal], axis=1)


@dataclass(frozen=True, eq=False)
class _Depths:
    """Depths of a surface below the plane of a window; NaN where it does not go on."""

    window: Window
    skin: FacetSurface
    geometry: Surface | None

    def __call__(self, x: Array, y: Array) -> Array:
        start = self.window.at(x, y)
        travel, found, lost = along_line(self.skin, start, -self.window.normal)
        # a line beside the body ends nowhere: the closest point is then not on the line
        ended = start - travel[:, None] * self.window.normal
        lost |= np.linalg.norm(found.points - ended, axis=1) > ON_SURFACE * self.window.half.min()
        if self.geometry is not None:
            travel, _, astray = along_line(self.geometry, start, -self.window.normal, facing=False)
            lost |= astray
        lost |= np.abs(travel) > MAX_SLOPE * np.hypot(x, y)
        return np.where(lost, np.nan, travel)


def _skin(body: ElasticBody, point: Array, planes: list[Array]) -> FacetSurface:
    """The body's outer surface without its faces on planes of symmetry (unit normals) through a point."""
    mesh = body.model.mesh
    facets = mesh.skin
    corners = mesh.points[facets[:, :4]] - point
    for normal in planes:
        facets, corners = (a[np.abs(corners @ normal).max(axis=1) > THROUGH * body.size] for a in (facets, corners))
    return FacetSurface(mesh.points, facets)


def free_facets(mesh: Mesh, planes: tuple[IntArray, Array]) -> IntArray:
    """The facets of a mesh's skin but those on planes of symmetry, given by nodes (n,) and their normals (n, 3)."""
    nodes, normals = planes
    facets = mesh.skin
    for d in _distinct(normals):
        facets = facets[~np.isin(facets[:, :4], nodes[np.abs(normals @ d) > 1 - ALONG]).all(axis=1)]
    return facets


def _cleaned(normal: Array) -> Array:
    """A unit vector along an axis to the last digit where it is along it: heights are then read without tilt."""
    rounded = np.where(np.abs(normal) < ALONG, 0.0, normal)
    return np.asarray(rounded / np.linalg.norm(rounded))


def _directions(body: ElasticBody, planes: list[Array], normal: Array) -> tuple[Array, Even]:
    """Axes (3, 3) of a window, and which of the first two are normal to a plane of symmetry through its middle."""
    inside = [d for d in planes if abs(d @ normal) <= MAX_SLOPE]
    if len(inside) < len(planes) or (len(inside) == 2 and abs(inside[0] @ inside[1]) > ALONG) or len(inside) > 2:
        raise InputError(
            f"The planes of symmetry of {body.name!r} through the middle of its window must be normal to its surface "
            "and to each other; they are not. Model the body without them."
        )
    for d in inside:  # the facet there may incline a little
        normal = normal - (normal @ d) * d
    normal = _cleaned(normal / np.linalg.norm(normal))
    if inside:
        first = inside[0]
    else:
        tangential = np.eye(3) - np.outer(normal, normal)
        # the first of equal ones
        first = tangential[np.argmax(np.round(np.linalg.norm(tangential, axis=1), 9))]
    first = _cleaned(first / np.linalg.norm(first))
    second = np.cross(normal, first)
    mirrored = (bool(inside), False)
    if len(inside) == 2:
        mirrored = (True, True)
        if inside[1] @ second < 0:  # right-handed with both directions into the body
            first, second = inside[1], first
    return np.stack([first, second, normal], axis=1), mirrored


def onto_planes(body: ElasticBody, point: Array, within: float) -> Array:
    """A point (3,) moved onto the planes of symmetry of a body that are within a distance of it."""
    mesh = body.model.mesh
    nodes, normals = symmetry_planes(mesh, body.supports)
    for d in _distinct(normals):
        height = (mesh.points[nodes] @ d)[np.abs(normals @ d) > 1 - ALONG]
        if len(height) and abs(height[0] - point @ d) <= within:
            point = point + (height[0] - point @ d) * d
    return point


def _distinct(normals: Array) -> Array:
    """Distinct unit vectors (k, 3) among normals (n, 3) of few planes, of which there is one for each node."""
    return np.unique(np.round(normals, 12), axis=0)


def planes_through(body: ElasticBody, point: Array) -> list[Array]:
    """Unit normals, into the body, of its distinct planes of symmetry through a point."""
    mesh = body.model.mesh
    nodes, normals = symmetry_planes(mesh, body.supports)
    if len(nodes) == 0:
        return []
    off = np.abs(((mesh.points[nodes] - point) * normals).sum(axis=1))
    found: list[Array] = []
    centre = mesh.points.mean(axis=0)
    for d in _distinct(normals[off <= THROUGH * body.size]):
        side = d if (centre - point) @ d > 0 else -d
        if not any(abs(side @ other) > 1 - ALONG for other in found):
            found.append(side / np.linalg.norm(side))
    return found


@dataclass(frozen=True, eq=False)
class WindowRequest:
    """A window as it is asked for.

    Attributes
    ----------
    at : (3,) array or None
    sides : (float, float) or None
    shape : (int, int)

    Examples
    --------
    >>> WindowRequest.of(None, 2.0, (64, 32)).sides
    (2.0, 2.0)
    """

    at: Array | None
    sides: tuple[float, float] | None
    shape: tuple[int, int]

    @classmethod
    def of(
        cls, at: ArrayLike | None, window: float | tuple[float, float] | None, shape: tuple[int, int]
    ) -> WindowRequest:
        """From the arguments of a local body.

        Raises
        ------
        InputError
            If they are no point, no lengths or no numbers of cells.
        """
        sides = None if window is None else window if isinstance(window, tuple | list) else (window, window)
        grid = Grid((1.0, 1.0) if sides is None else sides, shape)
        where = None if at is None else np.asarray(vector("the middle of the window", at, 3), dtype=float)
        return cls(where, None if sides is None else grid.size, grid.shape)


#: Places along a side of the patch in which gaps are fitted by a parabola.
TOUCH_SAMPLES = 9

#: Places of a patch that must lie on both surfaces: a quarter of them, at a corner of two planes of symmetry.
MIN_POINTS = 20

#: Fits at most, and the change of the contact's size that ends them.
MAX_TOUCH_ROUNDS, TOUCH_TOLERANCE = 12, 0.01

#: Half the side of the patch relative to the longer semi-axis of the contact.
PATCH = 1.5

#: Largest ratio of the axes of a contact that is estimated.
LONGEST = 20.0


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
    for _ in range(MAX_TOUCH_ROUNDS):
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
        growth, shift = abs(semi_axes[1] / before[1] - 1), float(np.linalg.norm(step)) / semi_axes[0]
        if max(growth, shift) < TOUCH_TOLERANCE:
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
    along = np.linspace(-half, half, TOUCH_SAMPLES)
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
