"""Contents of a mesh file, before they are checked and become a `Mesh`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError, MeshError
from fecontact.mesh.facets import places_among


@dataclass(frozen=True, eq=False)
class RawMesh:
    """Contents of a mesh file.

    Attributes
    ----------
    points : (n_points, 3) array
    blocks : sequence of (str, (n, k) int array)
        Solid cells: name of a kind in `mesh.kinds.KINDS` and connectivity.
    groups : mapping of str to int array
        Sets of solid cells, numbered through the blocks.
    facets : mapping of str to list of (n, 3 | 4) int arrays
        Surfaces given by the corner nodes of their facets.
    faces : mapping of str to (n, 2) int array
        Surfaces given by cell and local face of the hexahedron.
    node_sets : mapping of str to int array
    notes : tuple of str
        Notes of the reader.
    shells : mapping of str to list of (n, 3 | 4) int arrays
        Parts of shells, membranes and rigid facets, by the corner nodes of their facets; `read_surface` reads them.
    left : mapping of str to int
        What the file holds besides, by kind, with its number: a note lists it.
    sheets : sequence of (str, str, (n, k) int array)
        Plane cells of sections: name of their set, kind ('tri3', 'tri6', 'quad4', 'quad8', 'quad9') and nodes.
    lines : mapping of str to list of (n, 2) int arrays
        Named curves by the ends of their pieces.
    node_ids, element_ids : (n_points,) and (n_cells,) int arrays, optional
        The file's numbers of points and solid cells.
    """

    points: Array
    blocks: Sequence[tuple[str, IntArray]]
    groups: Mapping[str, IntArray] = field(default_factory=dict)
    facets: Mapping[str, list[IntArray]] = field(default_factory=dict)
    faces: Mapping[str, IntArray] = field(default_factory=dict)
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    shells: Mapping[str, list[IntArray]] = field(default_factory=dict)
    left: dict[str, int] = field(default_factory=dict)
    sheets: Sequence[tuple[str, str, IntArray]] = ()
    lines: Mapping[str, list[IntArray]] = field(default_factory=dict)
    node_ids: IntArray | None = None
    element_ids: IntArray | None = None

    @property
    def n_cells(self) -> int:
        """Solid cells."""
        return sum(len(cells) for _, cells in self.blocks)

    @classmethod
    def joined(cls, meshes: Sequence[RawMesh], called: Callable[[int, str], str] = lambda _, name: name) -> RawMesh:
        """One mesh of several, side by side; ``called(k, name)`` names what mesh k calls `name`."""
        points = np.cumsum([0, *(len(m.points) for m in meshes)]).tolist()
        cells = np.cumsum([0, *(m.n_cells for m in meshes)]).tolist()

        def sets(kind: str, moved: Callable[[int, Any], Any]) -> dict[str, Any]:
            return {called(k, n): moved(k, v) for k, m in enumerate(meshes) for n, v in getattr(m, kind).items()}

        def on_points(k: int, parts: list[IntArray]) -> list[IntArray]:
            return [part + points[k] for part in parts]

        return cls(
            np.concatenate([m.points for m in meshes]),
            [(kind, c + points[k]) for k, m in enumerate(meshes) for kind, c in m.blocks],
            groups=sets("groups", lambda k, members: members + cells[k]),
            facets=sets("facets", on_points),
            faces=sets("faces", lambda k, faces: faces + np.array([cells[k], 0])),
            node_sets=sets("node_sets", lambda k, nodes: nodes + points[k]),
            shells=sets("shells", on_points),
            left=sum((Counter(m.left) for m in meshes), Counter()),
            sheets=[(called(k, n), kind, c + points[k]) for k, m in enumerate(meshes) for n, kind, c in m.sheets],
            lines=sets("lines", on_points),
            node_ids=joined_numbers([m.node_ids for m in meshes]),
            element_ids=joined_numbers([m.element_ids for m in meshes]),
        )


def joined_numbers(parts: Iterable[IntArray | None]) -> IntArray:
    """Concatenation of int arrays, possibly none."""
    return np.concatenate([np.zeros(0, np.int64), *(part for part in parts if part is not None)])


def numbers_of(ids: IntArray, wanted: IntArray, what: str, source: str) -> IntArray:
    """Positions of `wanted` (any shape) in `ids`, the numbers that a file gives to its nodes or elements.

    Raises
    ------
    MeshError
        If one is missing.
    """
    if len(ids) == 0:
        raise MeshError(f"{source} refers to {what}s but defines none.")
    order = np.argsort(ids, kind="stable")
    place = np.minimum(np.searchsorted(ids, wanted, sorter=order), len(ids) - 1)
    found = order[place]
    missing = ids[found] != wanted
    if missing.any():
        raise MeshError(
            f"{source} refers to {what} {wanted[missing].flat[0]}, which it does not define; {missing.sum()} "
            "references are missing. The file is incomplete.",
            code="unknown-node",
        )
    return found


def known_members(
    ids: IntArray, wanted: IntArray, others: IntArray, left: dict[str, int], name: str, what: str
) -> IntArray:
    """Positions in `ids` of those members `wanted` (n,) of a set that are there.

    Parameters
    ----------
    ids : (n_ids,) int array
    wanted : (n,) int array
    others : int array
        Numbers that the file defines, but that are not read.
    left : dict
        Gets the number of those that are nowhere.
    name, what : str
        Of the set and of its members, for `left`.
    """
    there = np.isin(wanted, ids)
    lost = int((~there & ~np.isin(wanted, others)).sum())
    if lost:
        left[f"{what}s of the set {name!r} that the file does not define"] = lost
    return numbers_of(ids, wanted[there], what, name) if there.any() else np.zeros(0, np.int64)


def part_of(raw: RawMesh, name: str, source: str) -> RawMesh:
    """The cells of an element set, with what refers to them.

    Raises
    ------
    InputError
        If there is no such set.
    """
    names = {k.upper(): k for k in reversed(list(raw.groups))}
    if name not in raw.groups and name.upper() not in names:
        known = ", ".join(map(repr, raw.groups)) or "none"
        raise InputError(f"{source} has no part {name!r}; its element sets are: {known}.", code="unknown-part")
    members = raw.groups[name if name in raw.groups else names[name.upper()]]
    number = places_among(np.unique(members), raw.n_cells)
    starts = np.cumsum([0] + [len(cells) for _, cells in raw.blocks])
    kept = [number[a:b] >= 0 for a, b in pairwise(starts.tolist())]
    faces = {k: np.stack([number[f[:, 0]], f[:, 1]], axis=1) for k, f in raw.faces.items()}
    groups = {k: number[g] for k, g in raw.groups.items()}
    return replace(
        raw,
        blocks=[(kind, cells[k]) for (kind, cells), k in zip(raw.blocks, kept, strict=True) if k.any()],
        groups={k: g[g >= 0] for k, g in groups.items() if (g >= 0).any()},
        faces={k: f[f[:, 0] >= 0] for k, f in faces.items() if (f[:, 0] >= 0).any()},
        element_ids=None if raw.element_ids is None else raw.element_ids[number >= 0],
    )
