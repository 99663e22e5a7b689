"""Remainder on a finer mesh, where the body's own is too coarse for what lies beside its window, such as an edge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.local.factored import Factored
from fecontact.bodies.local.remainder import LARGEST_DEFECT, Remainder, facet_groups, in_planes, remainder
from fecontact.bodies.local.window import Window
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.surfaces.facet_surface import FacetSurface

SIZES = (2.0, 1.0, 0.5, 0.25)
"""Sizes of cells that are tried, over their distance from the images of the window's points."""

LEAST_GAP = 0.05
"""Least distance of a point from the other faces that counts, over the half-diagonal of the window."""

MOST_CELLS, GROWTH = 4000, 3
"""Cells up to which a mesh is divided by itself, and up to how many times its own; some ten seconds."""

HOPELESS = 10.0
"""Asymmetry after two divisions, over the largest allowed, from which more cells are of no use: the window is too near.
"""


def on_divided_mesh(body: ElasticBody, window: Window, material: Material, found: Remainder, name: str) -> Remainder:
    """The remainder of a body with its mesh divided round the window until it is symmetric, at the body's own nodes.

    Raises
    ------
    InputError
        If that takes too many cells.
    """
    finer, tried, most = body, len(body.mesh.cells), max(MOST_CELLS, GROWTH * len(body.mesh.cells))
    for times, size in enumerate(SIZES):
        if times >= 2 and found.defect > HOPELESS * LARGEST_DEFECT:
            break
        finer = _divided(finer, window, found.order, size, most)
        if len(finer.mesh.cells) > most:
            break
        if len(finer.mesh.cells) == tried:
            continue
        tried = len(finer.mesh.cells)
        found = remainder(Factored.of(finer.model, window.origin[None]), window, material)
        if found.defect <= LARGEST_DEFECT:
            _, same = cKDTree(finer.mesh.points).query(body.mesh.points)
            fields = found.fields.reshape(len(finer.mesh.points), 3, -1)[same]
            return replace(found, fields=fields.reshape(3 * len(same), -1))
    needs = "more cells are of no use so near"
    if len(finer.mesh.cells) > tried:
        needs = f"it would take more than {len(finer.mesh.cells)} cells"
    raise InputError(
        f"The compliance of {name!r} in its window contradicts Betti's theorem by {100 * found.defect:.2g} %, more "
        f"than {100 * LARGEST_DEFECT:g} %, also with its mesh divided round the window, to {tried} cells: {needs} to "
        "what lies beside or below the window (edges, holes, supports, layers). Take a smaller window, or a finer mesh "
        f"there; its sides are {window.grid.size}."
    )


def _divided(body: ElasticBody, window: Window, order: int, size: float, most: int) -> ElasticBody:
    """The body with cells no larger than a share of their distance from the images of the window's points.

    An image lies beyond the face nearest to a point, as far from it as the point; it is where the smooth field that the
    mesh carries would be singular.
    """
    points = window.on_surface(*window.node_places(order))
    nearest, gap = np.zeros(points.shape), np.full(len(points), np.inf)
    for facets in facet_groups(body.mesh, in_planes(body.mesh, window)[1]):
        there = FacetSurface(body.mesh.points, facets).project(points).points
        away = np.linalg.norm(there - points, axis=1)
        nearest, gap = np.where((away < gap)[:, None], there, nearest), np.minimum(away, gap)
    gap = np.maximum(gap, LEAST_GAP * float(np.linalg.norm(window.half)))
    while len(body.mesh.cells) <= most:
        corners = body.mesh.points[body.mesh.cells[:, : body.mesh.n_corners]]
        away = np.full(len(corners), np.inf)
        for place, beyond in zip(nearest, gap, strict=True):
            away = np.minimum(away, np.linalg.norm(corners - place, axis=2).min(axis=1) + beyond)
        large = np.ptp(corners, axis=1).max(axis=1) > size * away
        if not large.any():
            break
        body = body.divided({}, np.flatnonzero(large))
    return body
