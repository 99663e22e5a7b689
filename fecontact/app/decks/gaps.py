"""Gaps that a deck sets before anything moves: ADJUST of *CONTACT PAIR and *TIE, and *CLEARANCE.

Nodes of the slave are moved, without strain: with ADJUST those that lie in the master or at most so far from it come
onto it, or those of a set of nodes, with *CLEARANCE all to the given distance, negative in the master (Abaqus Keywords
Reference). Where all of these move alike and nothing else is joined to their part, the whole part moves, so that its
cells keep their shape: *CLEARANCE sets a gap and no new shape. With *TIE, ADJUST=NO tied nodes stay where they are and
have the displacements of their closest points on the master, not its turns. (Dhondt, CalculiX CrunchiX User's Manual,
*CLEARANCE, *TIE.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from fecontact.app.decks.content import DeckPair, Remarks
from fecontact.common.errors import InputError
from fecontact.mesh.base_mesh import BaseMesh
from fecontact.mesh.facets import parts_of_points
from fecontact.mesh.formats.abaqus_deck import KeywordSection
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.section_curve import CurveSurface
from fecontact.surfaces.tied import followers

M = TypeVar("M", bound=BaseMesh)
#: Distance of tied nodes, relative to the size of the mesh, that is rounding of a deck.
ROUNDING = 1e-6


def with_gaps(mesh: M, pairs: Sequence[DeckPair], alone: bool = True) -> M:
    """The mesh with the gaps that pairs ask for; whether its parts are `alone`, without ties and springs to others.

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
        way, size = wanted[moves] - points[nodes[moves]], float(np.linalg.norm(np.ptp(points, axis=0)))
        of_points = parts_of_points(mesh.cells, len(points))
        part = np.flatnonzero(np.isin(of_points, of_points[nodes]))
        others = [name for other in pairs for name in (other.slave, other.master) if name != pair.slave]
        joined = any(np.isin(mesh.boundary_nodes(name), part).any() for name in others)
        even = moves.all() and (np.ptp(way, axis=0) <= ROUNDING * size).all()
        if pair.adjust is None and alone and even and not joined:
            points[part] += way.mean(axis=0)
        else:
            points[nodes[moves]] = wanted[moves]
            if pair.adjust is None and (far := np.linalg.norm(way, axis=1).max(initial=0.0)) > ROUNDING * size:
                told = (
                    f"{pair.place}: *CLEARANCE moves {moves.sum()} nodes of {pair.slave!r} by up to {far:.3g}, without "
                    "strain: cells there change their shape, as their part is joined to others or its gap is uneven."
                )
                mesh = replace(mesh, warnings=(*mesh.warnings, told))
        mesh = replace(mesh, points=points)
    return mesh


def keeps_apart(s: KeywordSection) -> bool:
    """Whether it is a *TIE whose nodes keep their distances."""
    return s.keyword == "TIE" and s.parameters.get("ADJUST", "YES").upper() == "NO"


def apart(mesh: BaseMesh, tie: DeckPair, n: int, remarks: Remarks) -> sp.csr_matrix:
    """Conditions (m, n), the first 3 n_points of displacements: those of tied nodes less those of their closest points.

    Raises
    ------
    InputError
        If no node lies within the tie's reach.

    Examples
    --------
    >>> import fecontact as fc
    >>> lower = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    >>> upper = lower.translated((0, 0, 1.1))
    >>> rename = lambda mesh, old, new: replace(mesh, boundaries={new: mesh.faces(old)})
    >>> both = fc.merge([rename(upper, "bottom", "slave"), rename(lower, "top", "master")], 0.0)
    >>> remarks = Remarks()
    >>> apart(both, DeckPair("slave", "master", 0.0, "line 1", reach=0.2), 3 * len(both.points), remarks).shape
    (12, 48)
    >>> remarks.warnings
    ['line 1: tied nodes stay up to 0.1 from their master and follow its displacements, not its turns.']
    """
    try:
        found = followers(mesh, tie.slave, tie.master, tie.reach)
    except InputError as error:
        raise InputError(f"{tie.place}: {error}", code=error.code) from None
    if found.loose:
        remarks.warn(f"{tie.place}: {found.loose}")
    away = np.linalg.norm(mesh.points[found.nodes] - found.weights @ mesh.points, axis=1).max(initial=0.0)
    if away > ROUNDING * np.linalg.norm(np.ptp(mesh.points, axis=0)):
        told = f"tied nodes stay up to {away:.3g} from their master and follow its displacements, not its turns."
        remarks.warn(f"{tie.place}: {told}")
    own = sp.csr_matrix((np.ones(len(found.nodes)), (range(len(found.nodes)), found.nodes)), shape=found.weights.shape)
    rows = sp.kron(own - found.weights, np.eye(3), format="csr")
    rows.resize(rows.shape[0], n)
    return rows
