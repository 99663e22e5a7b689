"""Pre-tension sections of bolts: a body is cut, and both sides of the cut stay parallel, a length apart.

The cut is a surface of faces of elements on its one side, A, which get nodes of their own there. With n the direction
of the section, outward from A unless the deck gives another, and d the first component of its reference node,

    u_A - u_B = d n

at every node of the cut: both sides overlap by d, which shortens the bolt. A force on the reference node does the work
of d, so that it is the tension of the bolt; a displacement there shortens it (Dhondt, CalculiX CrunchiX User's Manual,
*PRE-TENSION SECTION; Abaqus Analysis User's Guide, "Prescribed assembly loads").
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from fecontact.app.decks.conditions import Nodes, Rows
from fecontact.app.decks.content import DeckCut, look_up
from fecontact.app.decks.sections import AXES
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError, not_done
from fecontact.mesh.base_mesh import BaseMesh
from fecontact.mesh.facets import components, unit_vectors
from fecontact.mesh.formats.abaqus_deck import KeywordSection, values_of
from fecontact.mesh.formats.raw import RawMesh

M = TypeVar("M", bound=BaseMesh)
#: First number of the nodes that side A gets, beyond those of decks.
FIRST = 1_000_000_000


def cut_sections(mesh: M, model: Sequence[KeywordSection], raw: RawMesh) -> tuple[M, list[DeckCut]]:
    """The mesh cut at the pre-tension sections of a deck.

    Raises
    ------
    InputError
        For a section of a beam, or a surface that does not part its body.
    """
    cuts: list[DeckCut] = []
    for s in model:
        if s.keyword != "PRE-TENSION SECTION":
            continue
        if not {"SURFACE", "NODE"} <= set(s.parameters):
            raise not_done(f"{s.place}: *PRE-TENSION SECTION without SURFACE and NODE is not done here.")
        name = look_up(s.parameters["SURFACE"], mesh.boundaries, "surface of solids", s.place)
        mesh, cut = _cut(mesh, name, s, _outward(mesh, name, raw))
        cuts.append(cut)
    return mesh, cuts


def _outward(mesh: BaseMesh, name: str, raw: RawMesh) -> Array:
    """Sum (3,) of the ways from the middles of elements of a surface to its faces, in the axes of the mesh.

    A section's side within it is that of either element beside it, so that those of the deck are asked.
    """
    faces = mesh.faces(name)
    middles = mesh.points[mesh.face_nodes(faces)].mean(axis=1)
    if not mesh.is_flat:
        return np.asarray((middles - mesh.points[mesh.cells[faces[:, 0]]].mean(axis=1)).sum(axis=0))
    centres = np.concatenate([raw.points[cells].mean(axis=1) for _, cells in raw.blocks])
    given = next(own for other, own in raw.faces.items() if other.upper() == name.upper())
    return np.asarray(middles.mean(axis=0) - centres[given[:, 0]].mean(axis=0)[AXES])


def _cut(mesh: M, name: str, s: KeywordSection, outward: Array) -> tuple[M, DeckCut]:
    facets = mesh.face_nodes(mesh.faces(name))
    nodes = np.unique(facets)
    if mesh.file_nodes is None or (not mesh.is_flat and (mesh.file_nodes[nodes] < 0).any()):
        raise not_done(
            f"{s.place}: {name!r} cuts linear elements of a deck with quadratic ones, which is not done here."
        )
    near = np.flatnonzero(np.isin(mesh.cells, nodes).any(axis=1))
    own = near[_side(mesh, near, facets, outward)]
    if not len(own) or not np.isin(nodes, mesh.cells[np.setdiff1d(near, own)]).all():
        raise InputError(
            f"{s.place}: the surface {name!r} does not part its body: *PRE-TENSION SECTION needs a cut all through, of "
            "faces on one side of it, with elements on the other.",
            code="pre-tension",
        )
    new = np.arange(len(mesh.points), len(mesh.points) + len(nodes))
    place = np.arange(len(mesh.points))
    place[nodes] = new
    cells = mesh.cells.copy()
    cells[own] = place[cells[own]]
    numbers = np.maximum(FIRST, mesh.file_nodes.max() + 1) + np.arange(len(nodes))
    numbers[mesh.file_nodes[nodes] < 0] = -1
    points = np.concatenate([mesh.points, mesh.points[nodes]])
    cut = replace(mesh, points=points, cells=cells, file_nodes=np.concatenate([mesh.file_nodes, numbers]))
    if s.lines and s.lines[0].strip(", "):
        direction = np.array(values_of(s.lines[0]))
    else:
        direction = _normal(mesh, facets, outward)
    return cut, DeckCut(s.parameters["NODE"], s.place, np.stack([new, nodes], axis=1), unit_vectors(direction[None])[0])


def _side(mesh: BaseMesh, near: IntArray, cut: IntArray, outward: Array) -> Mask:
    """Which cells (n,) beside a cut of facets (k, ...) lie on its side A, from which a vector (3,) leads.

    Cells that share other faces are on one side.
    """
    n_corners = 2 if mesh.is_flat else 4
    every = np.stack(np.meshgrid(near, np.arange(mesh.n_faces), indexing="ij"), axis=-1).reshape(-1, 2)
    facets, owner = mesh.face_nodes(every), np.repeat(np.arange(len(near)), mesh.n_faces)
    keys = np.sort(np.concatenate([cut, facets])[:, :n_corners], axis=1)
    # collapsed sides of wedges are lines, round which cells of both sides may lie
    whole = (np.diff(keys[len(cut) :], axis=1) > 0).sum(axis=1) >= n_corners // 2
    which = np.unique(keys, axis=0, return_inverse=True)[1].ravel()
    known, which = which[: len(cut)], which[len(cut) :]
    at_cut = np.isin(which, known)
    free = whole & ~at_cut
    size = len(near) + int(which.max()) + 1
    part = components(size, np.stack([owner[free], len(near) + which[free]], axis=1))[: len(near)]
    way = mesh.points[facets[at_cut]].mean(axis=1) - mesh.points[mesh.cells[near[owner[at_cut]]]].mean(axis=1)
    along = np.bincount(part[owner[at_cut]], np.sign(way @ outward), int(part.max()) + 1)
    beside = np.bincount(part[owner[at_cut]], minlength=int(part.max()) + 1)
    return np.asarray((along == beside)[part] & (beside > 0)[part])


def _normal(mesh: BaseMesh, facets: IntArray, outward: Array) -> Array:
    """Mean normal (3,) of facets, outward, in the axes of the deck."""
    x = mesh.points[facets]
    if mesh.is_flat:
        normals = np.cross(x[:, 1] - x[:, 0], [0.0, 1.0, 0.0])
    else:
        normals = np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
    total = (normals * np.sign(normals @ outward)[:, None]).sum(axis=0)
    return np.asarray(total[AXES] if mesh.is_flat else total)


def with_twins_between(between: IntArray | None, cuts: Sequence[DeckCut]) -> IntArray | None:
    """Points of sections between others, see `DeckContent.between`, with those of sides A of cuts."""
    if between is None:
        return None
    for cut in cuts:
        twin = dict(cut.twins[:, ::-1].tolist())
        rows = [[twin[p] for p in row] for row in between.tolist() if all(p in twin for p in row)]
        between = np.concatenate([between, np.array(rows, np.int64).reshape(-1, 3)])
    return between


def cut_conditions(cuts: Sequence[DeckCut], nodes: Nodes) -> sp.csr_matrix:
    """Conditions (m, 3 n) of pre-tension sections."""
    rows = Rows()
    for cut in cuts:
        reference = cut.node
        for one, other in cut.twins.tolist():
            for c in range(3):
                rows.add(([3 * one + c, 3 * other + c, 3 * reference], [1.0, -1.0, -cut.direction[c]]))
    return rows.matrix(3 * nodes.count)


def on_both_sides(values: Array, cuts: Sequence[DeckCut]) -> Array:
    """Values (n_all, ...) at nodes, those of sides B for sides A too."""
    out = values.copy()
    for cut in cuts:
        out[cut.twins[:, 0]] = out[cut.twins[:, 1]]
    return out
