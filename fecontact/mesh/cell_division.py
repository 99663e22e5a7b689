"""Division of one cell: its children, their nodes, and those of them on its edges and faces.

Red refinement (Bey 1995, *Tetrahedral grid refinement*, for tetrahedra): hexahedra, wedges and tetrahedra are divided
into eight of their kind, quadrilaterals of sections into four. A pyramid is divided into six pyramids and four
tetrahedra, so that its triangles match those of its neighbours. Hexahedra collapsed in other ways are first converted
to a star: pyramids and tetrahedra between their faces and their centre.

Corners of children are middles of corners of the parent and are named by them: {0} is a corner, {0, 1} the middle of an
edge, {0, 1, 2, 3} the centre of a face. Other nodes of children are named by the set of the corners between which they
lie. All tables are built from these names.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import permutations, product
from typing import Any

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import MeshError
from fecontact.mesh.element import (
    CORNERS,
    EDGES,
    FACES,
    PYRAMID,
    QUAD_CORNERS,
    QUAD_EDGES,
    TETRAHEDRON,
    TRIANGLE_NODES,
    WEDGE,
    Pattern,
    element_basis,
    quad_shapes,
    triangle_shapes,
)
from fecontact.mesh.hanging_nodes import TABLES

#: A set of the parent's corners, or a set of such sets.
Name = frozenset[Any]
#: Names of the corners of a child.
Corners = tuple[Name, ...]

HEXAHEDRON: Pattern = tuple(range(27))
#: Pairs of opposite edges of a tetrahedron, whose middles the inner diagonal may join.
DIAGONALS = (((0, 1), (2, 3)), ((0, 2), (1, 3)), ((0, 3), (1, 2)))
#: Corners of straight cells: wedge a b c below d e f, tetrahedron, pyramid with its apex last, hexahedron.
_PLACES = {
    WEDGE: np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1.0]]),
    TETRAHEDRON: np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]),
    PYRAMID: np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]]),
    HEXAHEDRON: CORNERS,
}


@dataclass(frozen=True, eq=False)
class CellDivision:
    """Tables of the division of one kind of cell. The nodes of its children form a **lattice**.

    Attributes
    ----------
    columns : (n_own,) int array
        Columns of the cells of the mesh with the distinct nodes of the parent.
    own : (n_lattice,) int array
        Index of each point of the lattice among these nodes, -1 for new points.
    shapes : (n_lattice, n_own) array
        Shape functions of the parent at the points of the lattice.
    entity : (n_lattice, n_own) bool array
        Nodes of the corner, edge, face or cell on which each point of the lattice lies.
    shared : tuple of (k, 3 | 5) int arrays
        New points that neighbours may share, each with the two or four points of the lattice between which it lies
        (of a triangle's centre, the largest corner twice): middles of edges, centres of faces, then the same for the
        children.
    inner : (k,) int array
        New points inside the cell.
    children : (n_children, width) int array
    facets : (n_local, k, 2) int array
        Children and their local faces (sides of a section) on each local face of the parent; -1 on collapsed faces.
    edges : (k, 5) int array
        Points of the lattice as in the tables of `HangingNodes`; -1 for none.
    quads : (k, 17) int array
    triangles : (k, 9) int array
    """

    columns: IntArray
    own: IntArray
    shapes: Array
    entity: Mask
    shared: tuple[IntArray, ...]
    inner: IntArray
    children: IntArray
    facets: IntArray
    edges: IntArray
    quads: IntArray
    triangles: IntArray


@dataclass(frozen=True)
class _Parent:
    """A kind of cell.

    Attributes
    ----------
    nodes : dict of Name to int
        Columns of the distinct nodes by name.
    edges : list of pairs of corners
    facets : dict of int to tuple of corners
        Corners of the local faces (sides of a section) in order; collapsed faces are left out.
    at : callable
        Shape functions (n_own,) at the point of a name.
    """

    nodes: dict[Name, int]
    edges: list[tuple[int, ...]]
    facets: dict[int, tuple[int, ...]]
    at: Callable[[Name], Array]

    @property
    def whole(self) -> Name:
        return frozenset().union(*self.nodes)


def _set(*corners: int) -> Name:
    return frozenset(corners)


def _flat(name: Name) -> Name:
    """All corners of the parent in a name."""
    return frozenset().union(*name) if isinstance(next(iter(name)), frozenset) else name


def _mean(name: Name, places: Array) -> Array:
    """Position of a name in the straight parent with corners at `places`."""
    parts = [_mean(n, places) if isinstance(n, frozenset) else places[n] for n in name]
    return np.asarray(np.mean(parts, axis=0))


# children


def _box_children(corners: Array) -> list[Corners]:
    """Squares or cubes: corners of children are centres of the boxes between two corners of the parent."""
    low, high = np.minimum(corners[:, None], corners), np.maximum(corners[:, None], corners)
    inside = ((corners >= low[:, :, None]) & (corners <= high[:, :, None])).all(axis=3)
    return [tuple(frozenset(np.flatnonzero(row).tolist()) for row in child) for child in np.asarray(inside)]


def _wedge_children() -> list[Corners]:
    triangles = [((0,), (0, 1), (0, 2)), ((0, 1), (1,), (1, 2)), ((0, 2), (1, 2), (2,)), ((0, 1), (1, 2), (0, 2))]
    layers = [((0,), (0, 3)), ((0, 3), (3,))]
    return [
        tuple(frozenset(i + j for i in corner for j in level) for level in layer for corner in triangle)
        for triangle, layer in product(triangles, layers)
    ]


def _tetrahedron_children(diagonal: int) -> list[Corners]:
    """Four tetrahedra at the corners, four around an inner diagonal between the middles of two opposite edges."""
    cut = [tuple(_set(k, i) for i in range(4)) for k in range(4)]
    (a, b), (c, d) = DIAGONALS[diagonal]
    ring = [_set(a, c), _set(a, d), _set(b, d), _set(b, c)]
    inner = [(_set(a, b), _set(c, d), ring[k], ring[(k + 1) % 4]) for k in range(4)]
    return [_right_handed(corners, _PLACES[TETRAHEDRON]) for corners in cut + inner]


def _pyramid_children() -> list[Corners]:
    """Pyramids at the corners of the base, below the apex and inverted below that; a tetrahedron at each side."""
    base = _set(0, 1, 2, 3)
    rise = [_set(k, 4) for k in range(4)]
    side = [_set(k, (k + 1) % 4) for k in range(4)]
    pyramids: list[Corners] = [(_set(k), side[k], base, side[k - 1], rise[k]) for k in range(4)]
    pyramids += [(*rise, _set(4)), (*rise[::-1], base)]
    tetrahedra = [(side[k], base, rise[k], rise[(k + 1) % 4]) for k in range(4)]
    return pyramids + [_right_handed(corners, _PLACES[PYRAMID]) for corners in tetrahedra]


def _right_handed(corners: Corners, places: Array) -> Corners:
    """Corners of a tetrahedron, two of them exchanged if its volume is negative."""
    x = np.array([_mean(c, places) for c in corners])
    a, b, c, d = corners
    return corners if np.linalg.det(x[1:] - x[0]) > 0 else (a, c, b, d)


# the kinds of parents


def _solid(pattern: Pattern, at: Callable[[Name], Array]) -> _Parent:
    """Parent for a pattern of coalesced nodes of the hexahedron."""
    corner = {column: k for k, column in enumerate(sorted(set(pattern[:8])))}
    of = [corner[c] for c in pattern[:8]]
    ends = [tuple(of[k] for k in edge) for edge in EDGES.tolist()]
    rings = [tuple(dict.fromkeys(of[k] for k in face)) for face in FACES[:, :4].tolist()]
    places = [_set(k) for k in of] + [_set(*e) for e in ends] + [_set(*r) for r in rings] + [frozenset(of)]
    nodes: dict[Name, int] = {}
    for column, place in enumerate(places[: len(pattern)]):
        nodes.setdefault(place, column)
    edges = list({_set(*e): e for e in ends if len(set(e)) == 2}.values())
    return _Parent(nodes, edges, {f: ring for f, ring in enumerate(rings) if len(ring) > 2}, at)


def _collapsed(pattern: Pattern, place: Array) -> Array:
    """Coordinates (3,) in the collapsed hexahedron of a point of a straight wedge, pyramid or tetrahedron (`_PLACES`).

    On collapsed edges, where a coordinate is arbitrary, it is zero.
    """
    x, y, z = place.tolist()

    def share(part: float, whole: float) -> float:
        return part / whole if whole > 0 else 0.0

    if pattern[:8] == TETRAHEDRON[:8]:
        return np.array([share(x, 1 - y - z), share(y, 1 - z), z])
    if pattern[:8] == WEDGE[:8]:
        return np.array([share(x, 1 - y), y, z])
    if pattern[:8] == PYRAMID[:8]:
        return np.array([share(x - z / 2, 1 - z), share(y - z / 2, 1 - z), z])
    return place


def _child_names(pattern: Pattern, corners: Corners, width: int) -> list[Name]:
    """Names of the nodes of a child in the columns of the mesh."""
    place = {column: k for k, column in enumerate(sorted(set(pattern[:8])))}
    names = [corners[place[c]] for c in pattern[:8]]
    if width > 8:
        names += [frozenset({names[a], names[b]}) if names[a] != names[b] else names[a] for a, b in EDGES.tolist()]
    if width > 20:
        names += [frozenset(names[k] for k in face) for face in FACES[:, :4].tolist()] + [frozenset(names[:8])]
    return names


# tables


def _tables(parent: _Parent, children: list[list[Name]], sides: IntArray) -> CellDivision:
    """Tables from the names of the nodes of the children (n_children, width) and the corners of local faces."""
    names = list(dict.fromkeys(n for row in children for n in row))
    index = {name: k for k, name in enumerate(names)}
    nodes = sorted(parent.nodes, key=parent.nodes.__getitem__)
    # in a star, mid-edge nodes of the parent lie between two of its corners
    between = {frozenset({_set(a), _set(b)}): _set(a, b) for a, b in parent.edges}
    places = between | {n: n for n in nodes}
    own = {name: nodes.index(place) for name, place in places.items() if place in parent.nodes}
    faces = {frozenset(ring) for ring in parent.facets.values() if len(ring) > 2}
    entities = [_set(k) for k in parent.whole] + [_set(*e) for e in parent.edges] + list(faces) + [parent.whole]
    smallest = [min((e for e in entities if _flat(n) <= e), key=len) for n in names]
    shared: tuple[list[list[int]], ...] = ([], [], [], [])
    inner = []
    for name in (n for n in names if n not in own):
        plain = name == _flat(name)
        level = (0 if len(name) == 2 else 1 if name in faces else None) if plain else {2: 2, 4: 3}.get(len(name))
        if level is None:
            inner.append(index[name])
        else:
            between_points = [_set(k) for k in sorted(name)] if plain else list(name)
            # a triangle's largest corner is repeated
            between_points += between_points[-1:] * (len(between_points) == 3)
            shared[level].append([index[n] for n in (name, *between_points)])
    return CellDivision(
        columns=np.array([parent.nodes[n] for n in nodes]),
        own=np.array([own.get(n, -1) for n in names]),
        shapes=np.array([np.arange(len(nodes)) == own[n] if n in own else parent.at(n) for n in names]),
        entity=np.array([[n <= e for n in nodes] for e in smallest]),
        shared=tuple(np.array(s, dtype=np.int64).reshape(-1, w) for s, w in zip(shared, (3, 5, 3, 5), strict=True)),
        inner=np.array(inner, dtype=np.int64),
        children=np.array([[index[n] for n in row] for row in children]),
        facets=_facets(parent, children, sides),
        **_hanging(parent, index),
    )


def _facets(parent: _Parent, children: list[list[Name]], sides: IntArray) -> IntArray:
    """Table `facets`: children and their local faces on each local face of the parent."""
    on: list[list[tuple[int, int]]] = [[] for _ in sides]
    for (f, ring), (k, row), (g, side) in product(parent.facets.items(), enumerate(children), enumerate(sides)):
        corners = {row[c] for c in side}
        if len(corners) >= min(len(side), 3) and all(_flat(c) <= frozenset(ring) for c in corners):
            on[f].append((k, g))
    table = np.full((len(sides), max(map(len, on)), 2), -1, dtype=np.int64)
    for f, found in enumerate(on):
        table[f, : len(found)] = np.array(found).reshape(-1, 2)
    return table


def _hanging(parent: _Parent, index: dict[Name, int]) -> dict[str, IntArray]:
    """Tables of edges, quads and triangles; empty for a star, which divides no edges and faces."""
    found: dict[str, list[list[Name]]] = {kind: [] for kind in TABLES}
    for a, b in (e for e in parent.edges if _set(*e) in index):
        m = _set(a, b)
        found["edges"].append([_set(a), m, _set(b), frozenset({_set(a), m}), frozenset({m, _set(b)})])
    for ring in parent.facets.values() if found["edges"] else ():
        corners = [_set(k) for k in ring]
        middles = [_set(k, ring[(i + 1) % len(ring)]) for i, k in enumerate(ring)]
        if len(ring) == 3:
            found["triangles"].append(corners + middles + [frozenset({middles[k], middles[k - 1]}) for k in range(3)])
        if len(ring) == 4:
            centre = frozenset(ring)
            quarters = [frozenset({corners[k], middles[k], centre, middles[k - 1]}) for k in range(4)]
            found["quads"].append([*corners, *middles, centre, *(frozenset({m, centre}) for m in middles), *quarters])
    return {
        kind: np.array([[index.get(n, -1) for n in row] for row in rows], dtype=np.int64).reshape(-1, TABLES[kind])
        for kind, rows in found.items()
    }


@cache
def _regular(pattern: Pattern, diagonal: int) -> CellDivision:
    """Division of a hexahedron, wedge, pyramid or tetrahedron in the form that mesh readers give."""
    width = len(pattern)
    whole = next(p for p in _PLACES if p[:8] == pattern[:8])
    corners = {
        HEXAHEDRON: lambda: _box_children(CORNERS),
        WEDGE: _wedge_children,
        PYRAMID: _pyramid_children,
        TETRAHEDRON: lambda: _tetrahedron_children(diagonal),
    }[whole]()
    kinds = [TETRAHEDRON if len(c) == 4 else whole for c in corners]
    children = [_child_names(kind, c, width) for kind, c in zip(kinds, corners, strict=True)]
    return _tables(_straight(pattern, _PLACES[whole]), children, FACES[:, :4])


def _straight(pattern: Pattern, places: Array) -> _Parent:
    """Parent of a pattern of mesh readers, the straight form of which has its corners at `places`."""

    def at(name: Name) -> Array:
        return element_basis(len(pattern), pattern, (), _collapsed(pattern, _mean(name, places))[None])[0][0]

    return _solid(pattern, at)


@cache
def hexahedra_of_tetrahedron(width: int) -> CellDivision:
    """Tables of the division of a tetrahedron of 8 or 20 columns into four hexahedra, one at each corner.

    They have the middles of edges, the centres of faces and the centre as further corners.

    Examples
    --------
    >>> hexahedra_of_tetrahedron(8).children.shape
    (4, 8)
    """
    # a corner of the tetrahedron and its others along the three axes, in even permutations
    axes = ((0, 1, 2, 3), (1, 2, 0, 3), (2, 0, 1, 3), (3, 1, 0, 2))
    corners = [[(v,), (v, p), (v, p, q), (v, q), (v, r), (v, p, r), (v, p, q, r), (v, q, r)] for v, p, q, r in axes]
    children = [_child_names(HEXAHEDRON, tuple(frozenset(c) for c in row), width) for row in corners]
    return _tables(_straight(TETRAHEDRON[:width], _PLACES[TETRAHEDRON]), children, FACES[:, :4])


@cache
def _rotations() -> list[tuple[IntArray, IntArray]]:
    """The 24 rotations of the hexahedron as permutations of its nodes (27,) and faces (6,)."""
    out = []
    places = np.concatenate([CORNERS, CORNERS[EDGES].mean(axis=1), CORNERS[FACES[:, :4]].mean(axis=1), [[0.5] * 3]])
    for axes, signs in product(permutations(range(3)), product((1, -1), repeat=3)):
        turn = np.eye(3)[list(axes)] * np.array(signs)
        if np.linalg.det(turn) > 0:
            turned = (places - 0.5) @ turn.T + 0.5
            nodes = np.argmin(np.abs(places[:, None] - turned).sum(axis=2), axis=0)
            out.append((nodes, nodes[20:26] - 20))
    return out


def _canonical(pattern: Pattern) -> tuple[Pattern, IntArray, IntArray] | None:
    """Rotate a pattern to that of a hexahedron, wedge, pyramid or tetrahedron of mesh readers; None if impossible."""
    width = len(pattern)
    for nodes, faces in _rotations():
        turned = np.array(pattern)[nodes[:width]]
        first = tuple(np.argmax(turned[:, None] == turned, axis=1).tolist())
        if first in {whole[:width] for whole in _PLACES if width < 27 or whole == HEXAHEDRON}:
            return first, nodes, faces
    return None


def divisible(pattern: Pattern) -> bool:
    """Whether cells of a pattern have a division of their own; others are converted to a star first."""
    return _canonical(pattern) is not None


@cache
def cell_division(pattern: Pattern, diagonal: int = 0) -> CellDivision:
    """Tables of the division of the cells of a pattern.

    Parameters
    ----------
    pattern : tuple of int
        As in `mesh.element`, of 8, 20 or 27 places.
    diagonal : int
        For a tetrahedron, which of `DIAGONALS` is the inner diagonal.

    Raises
    ------
    MeshError
        If the cells have no division of their own (`divisible`).

    Examples
    --------
    >>> len(cell_division(TETRAHEDRON).children), len(cell_division(PYRAMID).children)
    (8, 10)
    """
    found = _canonical(pattern)
    if found is None:
        raise MeshError("A hexahedron collapsed to no standard cell has no division; convert it to a star first.")
    canonical, nodes, faces = found
    table = _regular(canonical, diagonal if len(set(canonical[:8])) == 4 else 0)
    facets = np.empty_like(table.facets)
    facets[faces] = table.facets
    return replace(table, columns=nodes[table.columns], facets=facets)


@cache
def star(pattern: Pattern) -> CellDivision:
    """Tables of the division of a collapsed hexahedron into pyramids and tetrahedra between faces and centre."""
    width = len(pattern)

    def at(name: Name) -> Array:
        if name == parent.whole:
            return element_basis(width, pattern, (), np.full((1, 3), 0.5))[0][0]
        if name in parent.nodes:
            return np.array([float(column == parent.nodes[name]) for column in sorted(parent.nodes.values())])
        return np.asarray(np.mean([at(n) for n in name], axis=0))

    parent = _solid(pattern, at)
    children = []
    for ring in parent.facets.values():
        # faces run counter-clockwise seen from outside, a base seen from the apex
        corners = (*(_set(k) for k in ring[::-1]), parent.whole)
        children.append(_child_names(PYRAMID if len(ring) == 4 else TETRAHEDRON, corners, width))
    return _tables(parent, children, FACES[:, :4])


@cache
def section_division(width: int) -> CellDivision:
    """Tables of the division of an 8- or 9-node quadrilateral of a section into four."""
    sides = [tuple(e) for e in QUAD_EDGES.tolist()]
    places = [_set(k) for k in range(4)] + [_set(*e) for e in sides] + [_set(0, 1, 2, 3)]
    parent = _Parent(
        {p: k for k, p in enumerate(places[:width])},
        sides,
        dict(enumerate(sides)),
        lambda name: quad_shapes(width, _mean(name, QUAD_CORNERS)[None])[0][0],
    )
    return _tables(parent, _section_children(_box_children(QUAD_CORNERS), width), QUAD_EDGES)


@cache
def section_triangle_division() -> CellDivision:
    """Tables of the division of a triangle of 8 columns, ``a b c c  ab bc c ca``, into three quadrilaterals.

    Examples
    --------
    >>> section_triangle_division().children.shape
    (3, 8)
    """
    sides: dict[int, tuple[int, ...]] = {0: (0, 1), 1: (1, 2), 3: (2, 0)}
    nodes = {_set(0): 0, _set(1): 1, _set(2): 2, **{_set(*ends): 4 + side for side, ends in sides.items()}}
    parent = _Parent(
        nodes,
        list(sides.values()),
        sides,
        lambda name: triangle_shapes(6, _mean(name, TRIANGLE_NODES)[None])[0][0],
    )
    children: list[Corners] = [(_set(k), _set(k, (k + 1) % 3), _set(0, 1, 2), _set(k, (k + 2) % 3)) for k in range(3)]
    return _tables(parent, _section_children(children, 8), QUAD_EDGES)


def _section_children(children: Sequence[Corners], width: int) -> list[list[Name]]:
    """Names of the nodes of quadrilaterals in the columns of a section."""
    sides = QUAD_EDGES.tolist()
    return [[*c, *(frozenset({c[a], c[b]}) for a, b in sides), frozenset(c)][:width] for c in children]
