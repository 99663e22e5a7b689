"""Orientation of a surface: facets are reversed so that neighbours agree and closed surfaces face outwards.

Triangles that cross each other: surfaces that run through themselves.

Closed shells of a surface and what they enclose: solids, with voids.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import MeshError, place
from fecontact.mesh.facets import components, edge_keys, facets_at_sides, sides_of, triangular

#: Largest share of an open sheet's area whose opposite orientation counts as a mistake and is reversed.
MISTAKE = 0.25
#: Volume of a closed surface, relative to the cube of its size, that counts as zero.
NO_VOLUME = 1e-9


def neighbours(facets: IntArray) -> tuple[IntArray, Mask]:
    """Pairs (n, 2) of facets (n_facets, 4) with a common side, and whether (n,) both run along it the same way.

    Consistently oriented neighbours run along it in opposite directions.
    """
    ends = sides_of(facets).reshape(-1, 2)
    owner = np.arange(len(ends)) // 4
    real = ends[:, 0] != ends[:, 1]
    ends, owner = ends[real], owner[real]
    key = edge_keys(ends)
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(key[order][1:] == key[order][:-1])
    one, other = order[first], order[first + 1]
    return np.stack([owner[one], owner[other]], axis=1), ends[one, 0] == ends[other, 0]


def turned(facets: IntArray) -> IntArray:
    """Facets (n, 4 | 8) with their corners in the opposite order."""
    wide = facets.shape[1] == 8
    four = [1, 0, 3, 2, 4, 7, 6, 5] if wide else [1, 0, 3, 2]
    three = [0, 2, 1, 1, 7, 5, 1, 4] if wide else [0, 2, 1, 1]
    return np.where(triangular(facets)[:, None], facets[:, three], facets[:, four])


def oriented(points: Array, facets: IntArray) -> tuple[IntArray, tuple[str, ...]]:
    """Facets (n, 4) with consistent orientation, closed surfaces facing outwards, and notes of the changes.

    Closed sheets are oriented by the sign of their volume, unless they lie inside another one: as the wall of a cavity
    they are left unchanged. Open sheets take the orientation of most of their area.

    Raises
    ------
    MeshError
        If a sheet is one-sided, or too much of an open one disagrees to decide its outside.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> oriented(corners, np.array([[0, 2, 1, 1], [0, 1, 3, 3], [0, 3, 2, 2], [1, 3, 2, 2]]))[1]
    ('1 of 4 facets were turned to face as their neighbours do.',)
    """
    n = len(facets)
    pairs, against = neighbours(facets)
    sheet, against_first = _sides_of_sheets(facets, pairs, against)
    count = sheet.max() + 1
    area = corner_areas(points, facets)
    total, turn_area = (np.bincount(sheet, w, count) for w in (area, area * against_first))
    # first the orientation of most of the area
    turn = against_first ^ (turn_area > total / 2)[sheet]
    minority = np.minimum(turn_area, total - turn_area) / total
    sides = np.where(triangular(facets), 3.0, 4.0)
    closed = 2 * np.bincount(sheet[pairs[:, 0]], minlength=count) == np.bincount(sheet, sides, count)
    unclear = ~closed & (minority > MISTAKE)
    if unclear.any():
        k = int(np.argmax(unclear))
        raise MeshError(
            f"{100 * minority[k]:.0f} % of the area of the open surface that begins with facet {np.argmax(sheet == k)} "
            "faces the other way than the rest, so its outside cannot be told. Make its facets run the same way round.",
            code="unclear-outside",
        )
    notes = [f"{turn.sum()} of {n} facets were turned to face as their neighbours do."] if turn.any() else []
    facets = np.where(turn[:, None], turned(facets), facets)
    inside_out = _inside_out(points, facets, sheet, closed)
    if inside_out.any():
        part = "" if count == 1 else f" part of it ({np.isin(sheet, np.flatnonzero(inside_out)).sum()} facets)"
        notes.append(f"the closed surface{part} faced inwards and was turned; flipped() makes it a cavity.")
        facets = np.where(inside_out[sheet][:, None], turned(facets), facets)
    if not closed.all():
        notes.append("the surface is open: its outside is where the corners of most facets run counter-clockwise.")
    return facets, tuple(notes)


def _sides_of_sheets(facets: IntArray, pairs: IntArray, against: Mask) -> tuple[IntArray, Mask]:
    """Sheet (n,) of each facet, and whether it is opposite to the sheet's first facet.

    The double cover has every facet twice, as given and reversed, joined to its neighbours. An orientable sheet gives
    two components of the cover, a one-sided sheet gives one.
    """
    n = len(facets)
    i, j = pairs.T
    start, end = np.concatenate([i, i + n]), np.concatenate([np.where(against, j + n, j), np.where(against, j, j + n)])
    part = components(2 * n, np.stack([start, end], axis=1))
    if (part[:n] == part[n:]).any():
        _refuse_branching(facets)
        raise MeshError(
            f"The surface with facet {np.argmax(part[:n] == part[n:])} has one side only (a Moebius strip), so it has "
            "no outside.",
            code="one-sided",
        )
    own, other = part[:n], part[n:]
    _, first, sheet = np.unique(np.minimum(own, other), return_index=True, return_inverse=True)
    return sheet.ravel(), own != own[first][sheet.ravel()]


def _refuse_branching(facets: IntArray) -> None:
    """Refuse sides at which more than two facets meet.

    Raises
    ------
    MeshError
        Names one.
    """
    count = facets_at_sides(facets)
    if (count > 2).any():
        ends = np.sort(sides_of(facets), axis=2)
        low, high = ends[np.unravel_index(np.argmax(count), count.shape)]
        facet, _ = np.nonzero((ends == [low, high]).all(axis=2))
        raise MeshError(
            f"The surface branches: {count.max()} facets meet at the side between points {low} and {high} (facets "
            f"{', '.join(map(str, facet))}), so it has no outside. Leave out those that lie within."
        )


def _triangles(points: Array, facets: IntArray) -> Array:
    """Corners (2 n, 3, 3) of the triangles of facets; the second one of a triangle has no area."""
    return points[np.concatenate([facets[:, [0, 1, 2]], facets[:, [0, 2, 3]]])]


def corner_areas(points: Array, facets: IntArray) -> Array:
    """Areas (n,) of facets (n, 4 | 8), triangulated by corners."""
    x = _triangles(points, facets)
    area = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1) / 2
    return area.reshape(2, -1).sum(axis=0)


def signed_volume(points: Array, facets: IntArray) -> float:
    """Volume inside a closed surface of facets (n, 4 | 8), triangulated by corners; negative if it faces inwards."""
    x = _triangles(points - points[facets[:, :4]].mean(axis=(0, 1)), facets)
    return float(np.einsum("ni,ni->n", x[:, 0], np.cross(x[:, 1], x[:, 2])).sum() / 6)


def _inside_out(points: Array, facets: IntArray, sheet: IntArray, closed: Mask) -> Mask:
    """Closed sheets of negative volume that lie in no other sheet."""
    middle = points[np.unique(facets)].mean(axis=0)
    x = _triangles(points - middle, facets)
    volume = np.bincount(np.tile(sheet, 2), np.einsum("ni,ni->n", x[:, 0], np.cross(x[:, 1], x[:, 2])) / 6)
    low, high = np.full((len(closed), 3), np.inf), np.full((len(closed), 3), -np.inf)
    np.minimum.at(low, sheet, points[facets].min(axis=1))
    np.maximum.at(high, sheet, points[facets].max(axis=1))
    wrong = closed & (volume < -NO_VOLUME * np.linalg.norm(high - low, axis=1) ** 3)
    for k in np.flatnonzero(wrong):
        others = np.flatnonzero(closed & (low < low[k]).all(axis=1) & (high > high[k]).all(axis=1))
        inside = x[np.isin(np.tile(sheet, 2), others)] - (points[facets[np.argmax(sheet == k), 0]] - middle)
        wrong[k] = abs(solid_angle(inside)) < 2 * np.pi
    return wrong


def solid_angle(x: Array) -> float:
    """Solid angle of triangles (n, 3, 3) seen from the origin (van Oosterom & Strackee 1983)."""
    a, b, c = x.swapaxes(0, 1)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    triple = np.einsum("ni,ni->n", a, np.cross(b, c))
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(2 * np.arctan2(triple, below).sum())


#: Pairs of boxes that are compared together.
PAIRS = 4_000_000
#: Angle (sine) between a side and a triangle, relative, below which they are parallel.
PARALLEL = 1e-9


def crossing_triangles(points: Array, triangles: IntArray) -> IntArray:
    """Pairs (n, 2) of triangles without a common corner such that a side of the first crosses the second.

    Moeller & Trumbore (1997), Fast, minimum storage ray-triangle intersection. Memory is bounded whatever the sizes.

    Examples
    --------
    >>> x = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [0.5, 0.5, -1], [0.5, 0.5, 1], [3, 3, 0]])
    >>> crossing_triangles(x, np.array([[0, 1, 2], [3, 4, 5]])).tolist()
    [[0, 1], [1, 0]]
    """
    x = points[triangles]
    found = [np.zeros((0, 2), np.int64)]
    for one, other in _overlapping_boxes(x.min(axis=1), x.max(axis=1)):
        apart = ~(triangles[one][:, :, None] == triangles[other][:, None, :]).any(axis=(1, 2))
        pairs = np.stack([one[apart], other[apart]], axis=1)
        pairs = np.concatenate([pairs, pairs[:, ::-1]])
        found.append(pairs[_cross(x[pairs[:, 0]], x[pairs[:, 1]])])
    return np.concatenate(found)


def _overlapping_boxes(low: Array, high: Array) -> Iterator[tuple[IntArray, IntArray]]:
    """Pairs of boxes with corners (n, 3) that meet: sorted along the axis along which the fewest do."""
    orders = np.argsort(low, axis=0, kind="stable")
    last = np.stack([np.searchsorted(low[orders[:, k], k], high[orders[:, k], k], side="right") for k in range(3)])
    axis = int(np.argmin(last.sum(axis=1)))
    order, rank = orders[:, axis], np.arange(len(low))
    # of the box of each rank, those of later ranks up to the last one that begins within it
    ends = np.cumsum(last[axis] - rank - 1)
    start = 0
    while start < len(low):
        before = ends[start - 1] if start else 0
        stop = max(start + 1, int(np.searchsorted(ends, before + PAIRS, side="right")))
        count = np.diff(ends[start:stop], prepend=before)
        one = np.repeat(rank[start:stop], count)
        other = one + 1 + np.arange(len(one)) - np.repeat(np.cumsum(count) - count, count)
        one, other = order[one], order[other]
        meet = np.ones(len(one), bool)
        for k in range(3):
            meet &= (low[one, k] <= high[other, k]) & (low[other, k] <= high[one, k])
        yield one[meet], other[meet]
        start = stop


def _cross(x: Array, y: Array) -> Array:
    """Whether (n,) a side of triangles (n, 3, 3) crosses the others (n, 3, 3)."""
    hit = np.zeros(len(x), bool)
    a, b, c = np.moveaxis(y, 1, 0)
    for k in range(3):
        start = x[:, k]
        direction = x[:, (k + 1) % 3] - start
        p = np.cross(direction, c - a)
        det = np.einsum("ni,ni->n", b - a, p)
        scale = np.linalg.norm(direction, axis=1) * np.linalg.norm(b - a, axis=1) * np.linalg.norm(c - a, axis=1)
        crosses = np.abs(det) > PARALLEL * scale
        inverse = np.divide(1.0, det, out=np.zeros_like(det), where=crosses)
        s = start - a
        u = np.einsum("ni,ni->n", s, p) * inverse
        q = np.cross(s, b - a)
        v = np.einsum("ni,ni->n", direction, q) * inverse
        t = np.einsum("ni,ni->n", c - a, q) * inverse
        hit |= crosses & (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= 1)
    return hit


@dataclass(frozen=True, eq=False)
class ClosedComponents:
    """Connected parts of a closed surface.

    Attributes
    ----------
    shell : (n_triangles,) int array
        Number of each triangle's shell.
    solids : tuple of tuples of int
        Closed parts of each solid: the outer one, then those of its voids.
    """

    shell: IntArray
    solids: tuple[tuple[int, ...], ...]


def closed_components(points: Array, triangles: IntArray, source: str) -> ClosedComponents:
    """Closed parts of a surface of triangles that encloses solids.

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
    >>> closed_components(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]), "a tetrahedron").solids
    ((0,),)
    """
    facets = triangles[:, [0, 1, 2, 2]]
    _refuse_open(points, facets, source)
    _refuse_crossing(points, triangles, source)
    pairs = neighbours(facets)[0]
    shell = components(len(triangles), pairs)
    return ClosedComponents(shell, _solids(points, triangles, shell, source))


def rims(facets: IntArray) -> tuple[IntArray, IntArray]:
    """Sides (n, 2) of facets (n_facets, 4) that belong to one facet only, and the number (n,) of each side's rim."""
    alone = sides_of(facets)[facets_at_sides(facets) == 1]
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
        f"holes={count[k]}), or extrude it to a layer with fc.extrude.",
        code="open-surface",
    )


def _refuse_crossing(points: Array, triangles: IntArray, source: str) -> None:
    crossing = crossing_triangles(points, triangles)
    if len(crossing):
        a, b = crossing[0]
        raise MeshError(
            f"{source} runs through itself: {len(np.unique(crossing))} of its {len(triangles)} facets cross others, "
            f"facets {a} and {b} near {place(points[triangles[a]].mean(axis=0))}. Take out what lies inside: join "
            "parts that overlap to one, and smooth folds (fc.repair_surface).",
            code="crosses-itself",
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
                "facets if it is the wall of a void; otherwise mesh the two apart.",
                code="solid-in-solid",
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
