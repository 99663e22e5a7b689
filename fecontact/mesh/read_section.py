"""Read plane meshes of quadrilaterals and triangles as sections.

Triangles become three quadrilaterals each, and the quadrilaterals beside them four, so that they fit together; their
curved sides are halved, which keeps them.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from fecontact.common.arguments import file_path
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import positive
from fecontact.common.errors import InputError, MeshError
from fecontact.mesh.cell_sets import first_alike
from fecontact.mesh.element import TRIANGLE_NODES, quad_nodes, quad_shapes, triangle_shapes
from fecontact.mesh.facets import edge_keys, facets_at_sides, found, sides_of
from fecontact.mesh.read import READERS
from fecontact.mesh.section_mesh import REVERSED, SectionMesh

#: Extent across the plane of a section, relative to its size, that is rounding of a file.
FLAT = 1e-9


def read_section(path: str | Path, part: str | None = None, scale: float = 1.0) -> SectionMesh:
    """Read a plane mesh as a section.

    Parameters
    ----------
    path : str or Path
        ``.msh`` (physical curves become boundaries), ``.inp`` (CPS, CPE, CAX), ``.vtk``, ``.vtu``, ``.xdmf``. The mesh
        may lie in any coordinate plane: of x, y and z the two that vary become x and z of the section.
    part : str, optional
        Read only this set of cells, as one body of several.
    scale : float

    Returns
    -------
    SectionMesh
        Of 8-node quadrilaterals; sides of linear cells stay straight. Node sets that hold whole outer sides serve as
        boundaries too.

    Raises
    ------
    InputError, MeshError
        For an unknown file type or part, no plane cells, or cells that lie in no coordinate plane.

    Examples
    --------
    >>> import meshio, tempfile
    >>> points = [[0, 0], [1, 0], [1, 1], [0, 1.0]]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     triangles = [("triangle", [[0, 1, 2], [0, 2, 3]])]
    ...     meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), triangles).write(f"{folder}/a.vtu")
    ...     read_section(f"{folder}/a.vtu")
    SectionMesh(quad8, 6 cells, 27 points, boundaries: none)
    """
    path = file_path("the path of a section", path)
    if path.suffix.lower() not in READERS:
        raise InputError(f"Unknown mesh file type {path.suffix!r}; expected one of {', '.join(READERS)}.")
    positive("the scale", scale)
    if not path.is_file():
        raise InputError(f"There is no file {path}.", code="no-file")
    raw = READERS[path.suffix.lower()](path)
    names = list(dict.fromkeys(name for name, _, _ in raw.sheets))
    if part is not None and part not in names:
        raise InputError(f"{path.name} has no plane part {part!r}; there are: {', '.join(map(repr, names)) or 'none'}.")
    sheets = [s for s in raw.sheets if part is None or s[0] == part]
    if not sheets:
        raise MeshError(f"{path.name} holds no plane cells; solids are read with fc.read_mesh.", code="no-plane-cells")
    points, cells, owner = _quadratic(raw.points, [(kind, c) for _, kind, c in sheets])
    points = _in_plane(scale * points, np.unique(cells[cells >= 0]), path.name)
    # a cell of several sets is there once for each
    first = first_alike(cells[:, :4])
    own = first == np.arange(len(cells))
    number = (np.cumsum(own) - 1)[first]
    named = [(name, np.isin(owner, [k for k, s in enumerate(sheets) if s[0] == name])) for name in names]
    groups = {name: np.unique(number[members]) for name, members in named}
    cells = _turned(points, cells[own])
    triangle = cells[:, 2] == cells[:, 3]
    sides = _sides_of_sets(cells, raw.node_sets)
    sides |= _named_sides(cells, {k: np.concatenate(v) for k, v in raw.lines.items()})
    if triangle.any():
        points, cells, sides, groups = _divided(points, cells, triangle, sides, groups)
    used, number = np.unique(cells, return_inverse=True)
    back = np.full(len(points), -1, dtype=np.int64)
    back[used] = np.arange(len(used))
    sets = {name: back[nodes] for name, nodes in raw.node_sets.items()}
    sets = {name: np.unique(nodes[nodes >= 0]) for name, nodes in sets.items() if (nodes >= 0).any()}
    return SectionMesh(
        points[used],
        number.reshape(cells.shape),
        {name: s for name, s in sides.items() if len(s)},
        {name: g for name, g in groups.items() if len(g)},
        sets,
    )


def _quadratic(points: Array, blocks: list[tuple[str, IntArray]]) -> tuple[Array, IntArray, IntArray]:
    """Points, cells (n, 8) and the block of each; triangles repeat their third corner and the middle beside it."""
    rows, owner = [], []
    for k, (kind, c) in enumerate(blocks):
        full = np.full((len(c), 8), -1, dtype=np.int64)
        if kind.startswith("tri"):
            full[:, :4] = c[:, [0, 1, 2, 2]]
            full[:, 4:] = c[:, [3, 4, 2, 5]] if kind == "tri6" else full[:, 4:]
            full[:, 6] = c[:, 2]
        else:
            full[:, : min(c.shape[1], 8)] = c[:, :8]
        rows.append(full)
        owner.append(np.full(len(c), k))
    cells = np.concatenate(rows)
    edges = sides_of(cells).reshape(-1, 2)
    middle = cells[:, 4:].ravel()
    keys, inverse = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    known = np.full(len(keys), -1, dtype=np.int64)
    known[inverse.ravel()[middle >= 0]] = middle[middle >= 0]
    new = np.flatnonzero(known < 0)
    known[new] = len(points) + np.arange(len(new))
    cells[:, 4:] = np.where(middle >= 0, middle, known[inverse.ravel()]).reshape(-1, 4)
    return np.concatenate([points, points[keys[new]].mean(axis=1)]), cells, np.concatenate(owner)


def _in_plane(points: Array, used: IntArray, source: str) -> Array:
    """Points (n, 3) with y = 0, from those of a coordinate plane."""
    extent = np.ptp(points[used], axis=0)
    flat = extent <= FLAT * np.linalg.norm(extent)
    if flat.sum() != 1:
        raise MeshError(f"{source} has plane cells that lie in no coordinate plane; their extents are {extent}.")
    x, z = np.flatnonzero(~flat)
    return np.stack([points[:, x], np.zeros(len(points)), points[:, z]], axis=1)


def _turned(points: Array, cells: IntArray) -> IntArray:
    """Cells counter-clockwise, seen with x to the right and z upwards."""
    x, z = points[cells[:, :4], 0], points[cells[:, :4], 2]
    area = (x * np.roll(z, -1, axis=1) - np.roll(x, -1, axis=1) * z).sum(axis=1)
    out = cells.copy()
    out[area < 0] = cells[area < 0][:, list(REVERSED[:8])]
    # triangles have their double corner last
    wrong = (out[:, 2] != out[:, 3]) & (out[:, 1] == out[:, 2])
    out[wrong] = out[wrong][:, [3, 0, 1, 2, 7, 4, 5, 6]]
    return out


def _named_sides(cells: IntArray, lines: dict[str, IntArray]) -> dict[str, IntArray]:
    """Sides (n, 2) of cells at named pieces (n, 2) of curves."""
    ends = sides_of(cells).reshape(-1, 2)
    keys = edge_keys(ends)
    out = {}
    for name, pieces in lines.items():
        at = found(edge_keys(pieces), keys)
        out[name] = np.stack(np.divmod(at[at >= 0], 4), axis=1)
    return out


def _sides_of_sets(cells: IntArray, node_sets: Mapping[str, IntArray]) -> dict[str, IntArray]:
    """Outer sides (n, 2) of cells with both ends in a node set."""
    ends, outer = sides_of(cells), facets_at_sides(cells) == 1
    return {name: np.argwhere(outer & np.isin(ends, nodes).all(axis=2)) for name, nodes in node_sets.items()}


def _divided(
    points: Array, cells: IntArray, triangle: Mask, sides: dict[str, IntArray], groups: dict[str, IntArray]
) -> tuple[Array, IntArray, dict[str, IntArray], dict[str, IntArray]]:
    """Every cell divided into as many quadrilaterals as it has corners: corner, middle, centre, middle."""
    n = len(points)
    count = np.where(triangle, 3, 4)
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    extra, children = [points], np.zeros((count.sum(), 8), dtype=np.int64)
    ends = sides_of(cells)
    # a quarter of a side belongs to the side and to the end that it is next to
    halves = np.stack([ends, ends[:, :, ::-1]], axis=2).reshape(-1, 2)
    quarter, which = np.unique(halves, axis=0, return_inverse=True)
    which = which.reshape(-1, 4, 2)
    middles = np.broadcast_to(cells[:, 4:, None], (*cells[:, 4:].shape, 2))
    middle_of = np.zeros(len(quarter), dtype=np.int64)
    middle_of[which] = middles
    extra.append(
        np.einsum(
            "k,nki->ni", [3 / 8, 3 / 4, -1 / 8], points[np.stack([quarter[:, 0], middle_of, quarter[:, 1]], axis=1)]
        )
    )
    start = n + len(quarter)
    for k, own in ((3, np.flatnonzero(triangle)), (4, np.flatnonzero(~triangle))):
        if not len(own):
            continue
        corners, mids = (
            (cells[own][:, [0, 1, 2]], cells[own][:, [4, 5, 7]]) if k == 3 else (cells[own, :4], cells[own, 4:])
        )
        at = [0, 1, 3] if k == 3 else [0, 1, 2, 3]
        near, far = which[own][:, at, 0], which[own][:, at, 1]
        reference = TRIANGLE_NODES if k == 3 else quad_nodes(8)
        centre = reference[:k].mean(axis=0)
        inner = np.concatenate([centre[None], (reference[k : 2 * k] + centre) / 2])
        N = (triangle_shapes(6, inner) if k == 3 else quad_shapes(8, inner))[0]
        extra.append(np.einsum("qa,nai->nqi", N, points[np.concatenate([corners, mids], axis=1)]).reshape(-1, 3))
        inside = start + np.arange(len(own) * (k + 1)).reshape(-1, k + 1)
        start += inside.size
        for i in range(k):
            j = (i - 1) % k
            children[first[own] + i] = np.stack(
                [
                    corners[:, i],
                    mids[:, i],
                    inside[:, 0],
                    mids[:, j],
                    n + near[:, i],
                    inside[:, 1 + i],
                    inside[:, 1 + j],
                    n + far[:, j],
                ],
                axis=1,
            )
    side = {name: _halved(s, triangle, count, first) for name, s in sides.items()}
    cell = {
        name: np.concatenate([first[g] + i for i in range(4)])[np.concatenate([count[g] > i for i in range(4)])]
        for name, g in groups.items()
    }
    return np.concatenate(extra), children, side, cell


def _halved(sides: IntArray, triangle: Mask, count: IntArray, first: IntArray) -> IntArray:
    """The halves of sides (n, 2): side 0 of the child at its beginning, side 3 of the one at its end."""
    cell, side = sides.T
    side = np.where(triangle[cell] & (side == 3), 2, side)
    one = np.stack([first[cell] + side, np.zeros(len(cell), np.int64)], axis=1)
    other = np.stack([first[cell] + (side + 1) % count[cell], np.full(len(cell), 3)], axis=1)
    return np.concatenate([one, other])
