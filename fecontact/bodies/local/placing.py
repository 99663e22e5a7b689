"""Where the window of a local body lies: its middle on the surface, its directions, its planes of symmetry."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.halfspace.grid import Grid
from fecontact.bodies.halfspace.symmetry import Even
from fecontact.bodies.local.window import Window
from fecontact.common.arrays import Array
from fecontact.common.checks import vector
from fecontact.common.errors import InputError
from fecontact.fem.support import symmetry_planes
from fecontact.surfaces.facet_surface import FacetSurface

ON_SURFACE = 1e-6
"""Distance from the surface, relative to the body's size, within which the middle of a window lies on it."""

SAMPLES = 9
"""Points along a side of a window at which its distance from the surface is checked."""

THROUGH = 1e-9
"""Distance from a plane of symmetry, relative to the body's size, within which the middle lies on it."""

ALONG = 1e-9
"""Sine of an angle that is rounding."""


def place_window(body: ElasticBody, at: ArrayLike, size: tuple[float, float], shape: tuple[int, int]) -> Window:
    """The window of a body at a point (3,) of its surface, of given sides and numbers of cells.

    Its first direction is normal to a plane of symmetry through the point, if there is one, else the axis of the mesh
    that is the nearest to the surface.

    Raises
    ------
    InputError
        If the point is not on the surface.
    """
    where = np.asarray(vector("the middle of the window", at, 3), dtype=float)
    planes = _planes_through(body, where)
    skin = _skin(body, where, planes)
    found = skin.project(where[None])
    away = float(np.linalg.norm(found.points[0] - where))
    if away > ON_SURFACE * body.size:
        raise InputError(
            f"The middle of the window, at={np.array2string(where, precision=6)}, must lie on the surface of "
            f"{body.name!r}; it is {away:.4g} from it. The nearest point of the surface is "
            f"{np.array2string(found.points[0], precision=6)}."
        )
    assert found.facet is not None
    assert found.local is not None
    normal = _cleaned(skin.normals(found.facet, found.local)[0])
    axes, mirrored = _directions(body, planes, normal)
    counts = tuple(n + n % 2 if even else n for n, even in zip(shape, mirrored, strict=True))
    window = Window(where, axes, Grid(size, (counts[0], counts[1])), mirrored)
    _check_flat(body, window, skin)
    return window


def _check_flat(body: ElasticBody, window: Window, skin: FacetSurface) -> None:
    """Refuse a window that is not within one flat face."""
    x, y = (
        np.linspace(0.0 if even else -half, half, SAMPLES)
        for half, even in zip(window.half, window.mirrored, strict=True)
    )
    points = window.at(*(c.ravel() for c in np.meshgrid(x, y, indexing="ij")))
    away = np.linalg.norm(points - skin.project(points).points, axis=1)
    worst = int(np.argmax(away))
    if away[worst] > ON_SURFACE * body.size:
        middle, place = (np.array2string(p, precision=4) for p in (window.origin, points[worst]))
        raise InputError(
            f"The window of {body.name!r} must lie within one flat face. With its sides {window.grid.size} about "
            f"{middle}, its point {place} is {away[worst]:.3g} from the surface. Take a smaller window, or use the "
            "ElasticBody itself with accuracy= when the scene is solved."
        )


def _skin(body: ElasticBody, point: Array, planes: list[Array]) -> FacetSurface:
    """The body's outer surface without its faces on planes of symmetry (unit normals) through a point."""
    mesh = body.model.mesh
    facets = mesh.skin
    corners = mesh.points[facets[:, :4]] - point
    for normal in planes:
        facets, corners = (a[np.abs(corners @ normal).max(axis=1) > THROUGH * body.size] for a in (facets, corners))
    return FacetSurface(mesh.points, facets)


def _cleaned(normal: Array) -> Array:
    """A unit vector along an axis to the last digit where it is along it: heights are then read without tilt."""
    rounded = np.where(np.abs(normal) < ALONG, 0.0, normal)
    return np.asarray(rounded / np.linalg.norm(rounded))


def _directions(body: ElasticBody, planes: list[Array], normal: Array) -> tuple[Array, Even]:
    """Axes (3, 3) of a window, and which of the first two are normal to a plane of symmetry through its middle."""
    inside = [d for d in planes if abs(d @ normal) <= ALONG]
    if len(inside) < len(planes) or (len(inside) == 2 and abs(inside[0] @ inside[1]) > ALONG) or len(inside) > 2:
        raise InputError(
            f"The planes of symmetry of {body.name!r} through the middle of its window must be normal to its surface "
            "and to each other; they are not. Model the body without them."
        )
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


def _planes_through(body: ElasticBody, point: Array) -> list[Array]:
    """Unit normals, into the body, of its distinct planes of symmetry through a point."""
    mesh = body.model.mesh
    nodes, normals = symmetry_planes(mesh, body.supports)
    if len(nodes) == 0:
        return []
    off = np.abs(((mesh.points[nodes] - point) * normals).sum(axis=1))
    found: list[Array] = []
    centre = mesh.points.mean(axis=0)
    # nodes come plane by plane: few distinct normals
    for d in np.unique(np.round(normals[off <= THROUGH * body.size], 12), axis=0):
        side = d if (centre - point) @ d > 0 else -d
        if not any(abs(side @ other) > 1 - ALONG for other in found):
            found.append(side / np.linalg.norm(side))
    return found
