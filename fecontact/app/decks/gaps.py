"""Gaps that a deck sets before anything moves: ADJUST of *CONTACT PAIR, and *CLEARANCE.

Nodes of the slave are moved, without strain: with ADJUST those that lie in the master or at most so far from it come
onto it, or those of a set of nodes, with *CLEARANCE all to the given distance, negative in the master (Abaqus Keywords
Reference).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from fecontact.app.decks.content import DeckPair
from fecontact.mesh.base_mesh import BaseMesh
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.section_curve import CurveSurface

M = TypeVar("M", bound=BaseMesh)


def with_gaps(mesh: M, pairs: Sequence[DeckPair]) -> M:
    """The mesh with the gaps that pairs ask for.

    Examples
    --------
    >>> import fecontact as fc
    >>> lower = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    >>> upper = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 1), element="hex8").translated((0, 0, 1.1))
    >>> rename = lambda mesh, old, new: replace(mesh, boundaries={new: mesh.faces(old)})
    >>> both = fc.merge([rename(upper, "bottom", "slave"), rename(lower, "top", "master")], 0.0)
    >>> near = with_gaps(both, [DeckPair("slave", "master", 0.0, "line 1", adjust=0.2)])
    >>> near.points[near.boundary_nodes("slave"), 2].max().round(12)
    np.float64(1.0)
    """
    for pair in pairs:
        if pair.adjust is None and pair.clearance is None:
            continue
        facets = mesh.face_nodes(mesh.faces(pair.master))
        kind = CurveSurface if mesh.is_flat else FacetSurface
        master = kind(mesh.points, facets)
        nodes = np.setdiff1d(mesh.boundary_nodes(pair.slave), master.nodes)
        if pair.adjusted:
            nodes = np.intersect1d(nodes, mesh.boundary_nodes(pair.adjusted))
        if not len(nodes):
            continue
        found = master.project(mesh.points[nodes])
        faces = ~found.outside
        moves = faces if pair.adjust is None else faces & (found.gap <= pair.adjust)
        wanted = found.points if pair.clearance is None else found.points + pair.clearance * found.normals
        points = mesh.points.copy()
        points[nodes[moves]] = wanted[moves]
        mesh = replace(mesh, points=points)
    return mesh
