"""Closed shells of a surface and what they enclose: solids, with voids."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError, place
from fecontact.mesh.crossing import crossing_triangles
from fecontact.mesh.orient import components, shared_sides, solid_angle


@dataclass(frozen=True, eq=False)
class Shells:
    """Connected parts of a closed surface.

    Attributes
    ----------
    shell : (n_triangles,) int array
        Number of each triangle's shell.
    solids : tuple of tuples of int
        Shells of each solid: the outer one, then those of its voids.
    """

    shell: IntArray
    solids: tuple[tuple[int, ...], ...]


def shells_of(points: Array, triangles: IntArray, source: str) -> Shells:
    """Shells of a surface of triangles that encloses solids.

    A shell within another one that faces inwards is the wall of a void; one within a void is another solid.

    Parameters
    ----------
    points : (n_points, 3) array
    triangles : (n, 3) int array
        Neighbours are oriented alike.
    source : str
        Name of the surface, for messages.

    Raises
    ------
    MeshError
        If the surface is open, runs through itself, or a shell faces the wrong way; with the place and what to do.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> shells_of(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]), "a tetrahedron").solids
    ((0,),)
    """
    facets = triangles[:, [0, 1, 2, 2]]
    _refuse_open(points, facets, source)
    _refuse_crossing(points, triangles, source)
    pairs = shared_sides(facets)[0]
    shell = components(len(triangles), pairs)
    return Shells(shell, _solids(points, triangles, shell, source))


def rims(facets: IntArray) -> tuple[IntArray, IntArray]:
    """Sides (n, 2) of facets (n_facets, 4) that belong to one facet only, and the number (n,) of each side's rim."""
    ends = np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2)
    ends = ends[ends[:, 0] != ends[:, 1]]
    _, inverse, count = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
    alone = ends[count[inverse.ravel()] == 1]
    used, number = np.unique(alone, return_inverse=True)
    rim = components(len(used), number.reshape(-1, 2))[number.reshape(-1, 2)[:, 0]]
    return alone, np.unique(rim, return_inverse=True)[1].ravel()


def _refuse_open(points: Array, facets: IntArray, source: str) -> None:
    sides, rim = rims(facets)
    if len(sides) == 0:
        return
    count = np.bincount(rim)
    k = int(np.argmax(count))
    middle = points[np.unique(sides[rim == k])].mean(axis=0)
    raise MeshError(
        f"{source} is open, so it encloses no solid: {len(sides)} sides belong to one facet only, in {len(count)} "
        f"holes; the longest, of {count[k]} sides, is round {place(middle)}. Close it by fc.repair_surface(..., "
        f"holes={count[k]}), or extrude it to a layer with fc.extrude."
    )


def _refuse_crossing(points: Array, triangles: IntArray, source: str) -> None:
    crossing = crossing_triangles(points, triangles)
    if len(crossing):
        a, b = crossing[0]
        raise MeshError(
            f"{source} runs through itself: {len(np.unique(crossing))} of its {len(triangles)} facets cross others, "
            f"facets {a} and {b} near {place(points[triangles[a]].mean(axis=0))}. Take out what lies inside: join "
            "parts that overlap to one, and smooth folds (fc.repair_surface)."
        )


def _solids(points: Array, triangles: IntArray, shell: IntArray, source: str) -> tuple[tuple[int, ...], ...]:
    n = int(shell.max()) + 1
    first = np.unique(shell, return_index=True)[1]
    x = points[triangles] - points.mean(axis=0)
    volume = np.bincount(shell, np.einsum("ni,ni->n", x[:, 0], np.cross(x[:, 1], x[:, 2])) / 6)
    inside = _inside(x, shell, first)
    depth = inside.sum(axis=1)
    wrong = (volume > 0) != (depth % 2 == 0)
    if wrong.any():
        k = int(np.argmax(wrong))
        where = (
            f"The shell of {source} that begins with facet {first[k]}, near {place(points[triangles[first[k], 0]])},"
        )
        if depth[k] % 2:
            raise MeshError(
                f"{where} lies in another one and faces outwards, as a second solid in the same place would. Turn its "
                "facets if it is the wall of a void; otherwise mesh the two apart."
            )
        raise MeshError(f"{where} faces inwards, so it encloses no solid. surface.flipped() turns a surface round.")
    # the shell just round a void is the one of its depth less one
    around = [int(np.flatnonzero(inside[k] & (depth == depth[k] - 1))[0]) if depth[k] % 2 else k for k in range(n)]
    outer = np.flatnonzero(depth % 2 == 0)
    return tuple((int(k), *(j for j in range(n) if depth[j] % 2 and around[j] == k)) for k in outer)


def _inside(x: Array, shell: IntArray, first: IntArray) -> Array:
    """Which shell lies in which (n, n), by the solid angle in which a corner of the one sees the other."""
    n = len(first)
    low, high = np.full((n, 3), np.inf), np.full((n, 3), -np.inf)
    np.minimum.at(low, shell, x.min(axis=1))
    np.maximum.at(high, shell, x.max(axis=1))
    out = np.zeros((n, n), bool)
    within = (low[:, None] > low[None]).all(axis=2) & (high[:, None] < high[None]).all(axis=2)
    for k, j in np.argwhere(within):
        out[k, j] = abs(solid_angle(x[shell == j] - x[first[k], 0])) > 2 * np.pi
    return out
