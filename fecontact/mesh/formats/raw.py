"""Contents of a mesh file, before they are checked and become a `Mesh`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError


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
    """

    points: Array
    blocks: Sequence[tuple[str, IntArray]]
    groups: Mapping[str, IntArray] = field(default_factory=dict)
    facets: Mapping[str, list[IntArray]] = field(default_factory=dict)
    faces: Mapping[str, IntArray] = field(default_factory=dict)
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


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
            "references are missing. The file is incomplete."
        )
    return found
