"""Blocks of coarse cells beside cells half as large, their ties written down from the coarse faces' own functions.

Nothing here divides a cell: coarse and fine blocks are made apart and joined, so what the package makes of divided
meshes is tested against meshes that it did not divide.
"""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

import fecontact as fc
from fecontact import Mesh, SectionMesh, merge
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.mesh.kinds import KINDS
from fecontact.mesh.section_mesh import line_shapes, merge_sections
from fecontact.surfaces.facet_surface import FacetSurface

# six tetrahedra round the diagonal of a hexahedron; those of its halves lie inside those of the whole
_KUHN = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 5, 1, 6), (0, 4, 5, 6), (0, 3, 7, 6), (0, 7, 4, 6))
_WEDGES = ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7))
SPATIAL = ("hex8", "hex20", "hex27", "tet4", "tet10", "wedge6", "wedge15")
SIDES = {"x_min": (0, 0), "x_max": (0, 1), "y_min": (1, 0), "y_max": (1, 1), "bottom": (2, 0), "top": (2, 1)}


def part(kind, low, high, n):
    """A block between two corners, cut n times along each side into cells of one kind."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    hexahedra = kind if kind.startswith("hex") else "hex8"
    mesh = fc.shapes.block(tuple(high - low), n, element=hexahedra)
    mesh = replace(mesh, boundaries={})
    if not kind.startswith("hex"):
        split = _KUHN if kind.startswith("tet") else _WEDGES
        cells = np.concatenate([mesh.cells[:, list(s)] for s in split])
        four = KINDS["tet4" if kind.startswith("tet") else "wedge6"]
        mesh = Mesh(mesh.points, four.to_hexahedra(cells))
        if kind in ("tet10", "wedge15"):
            mesh = mesh.upgraded(20)
    return mesh.translated(low)


def joined(*parts):
    """Parts that touch, the coarser before the finer, as one mesh; the finer ones' extra nodes hang."""
    size = max(np.ptp(m.points, axis=0).max() for m in parts)
    whole = merge(list(parts), 1e-9 * size)
    tree = cKDTree(whole.points)
    nodes, rows, edges = [], [], []
    for k, coarse in enumerate(parts[:-1]):
        own = tree.query(coarse.points)[1]
        finer = np.setdiff1d(np.concatenate([tree.query(m.points)[1] for m in parts[k + 1 :]]), own)
        faces = own[coarse.face_nodes(coarse.outer_faces)]
        feet = FacetSurface(whole.points, faces, "coarse").project(whole.points[finer])
        on = np.flatnonzero(np.linalg.norm(feet.points - whole.points[finer], axis=1) < 1e-9 * size)
        on = on[~np.isin(finer[on], np.concatenate(nodes) if nodes else [])]
        nodes.append(finer[on])
        rows.append(feet.weights[on])
        edges.append(_edges(whole.points, tree, faces, finer[on], size))
    weights = sp.vstack(rows, format="csr")
    weights.data[np.abs(weights.data) < 1e-14] = 0.0
    weights.eliminate_zeros()
    found = np.concatenate(edges)
    # the points of an edge may lie far into the chain; only the rows are closed
    hanging = HangingNodes.closed(np.concatenate(nodes), weights, found)
    return boxed(replace(whole, points=hanging.followed(whole.points), hanging=hanging))


def _edges(points, tree, faces, hanging, size):
    """Rows end, middle, end, quarter points of the coarse faces' sides on which some of the given nodes hang."""
    out = {}
    for a, b in np.stack([faces[:, :4], np.roll(faces[:, :4], -1, axis=1)], axis=2).reshape(-1, 2):
        x, y = points[min(a, b)], points[max(a, b)]
        key = (min(a, b), max(a, b))
        if a == b or key in out:
            continue
        places = np.stack([(x + y) / 2, (3 * x + y) / 4, (x + 3 * y) / 4])
        distance, found = tree.query(places)
        found = np.where(distance < 1e-9 * size, found, -1)
        if np.isin(found, hanging).any():
            out[key] = (key[0], found[0], key[1], found[1], found[2])
    return np.array(list(out.values()), dtype=np.int64).reshape(-1, 5)


def boxed(mesh):
    """With the six sides of its box as boundaries."""
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    for name, (axis, end) in SIDES.items():
        at = (low, high)[end][axis]
        mesh = mesh.with_boundary(name, lambda x, axis=axis, at=at: np.abs(x[:, axis] - at) < 1e-9 * np.ptp(x))
    return mesh


def step(kind, scale=1.0):
    """Two coarse cells beside eight (or as many pieces) half as large, in a block 2 x 2 x 1."""
    return joined(
        part(kind, (0, 0, 0), (1, 2, 1), (1, 2, 1)),
        part(kind, (1, 0, 0), (2, 1, 1), (1, 1, 1)),
        part(kind, (1, 1, 0), (2, 2, 1), (2, 2, 2)),
    ).scaled(scale)


def stairs(kind):
    """Cells of three sizes in a block 4 x 2 x 2, so that hanging nodes follow from hanging ones at the edges."""
    return joined(
        part(kind, (0, 0, 0), (2, 2, 2), (1, 1, 1)),
        part(kind, (2, 0, 0), (4, 2, 1), (2, 2, 1)),
        part(kind, (2, 0, 1), (3, 2, 2), (1, 2, 1)),
        part(kind, (3, 0, 1), (4, 2, 2), (2, 4, 2)),
    )


def section_step(kind):
    """Two coarse quadrilaterals beside four half as large, in a rectangle 2 x 2, named like `fc.sections.rectangle`."""
    boxes = (((0, 0), (1, 2), (1, 2)), ((1, 0), (2, 1), (1, 1)), ((1, 1), (2, 2), (2, 2)))
    parts = []
    for (x, z), (x1, z1), n in boxes:
        m = fc.sections.rectangle((x1 - x, z1 - z), n, element=kind)
        parts.append(SectionMesh(m.points - m.points.min(axis=0) + [x, 0, z], m.cells))
    whole = merge_sections(parts, 1e-9)
    tree = cKDTree(whole.points)
    nodes, rows, columns, values, edges = [], [], [], [], []
    for k, coarse in enumerate(parts[:-1]):
        own = tree.query(coarse.points)[1]
        finer = np.setdiff1d(np.concatenate([tree.query(m.points)[1] for m in parts[k + 1 :]]), own)
        for a, b, m in own[coarse.face_nodes(coarse.outer_sides)]:
            x, d = whole.points[a], whole.points[b] - whole.points[a]
            s = (whole.points[finer] - x) @ d / (d @ d)
            off = np.linalg.norm(whole.points[finer] - x - s[:, None] * d, axis=1)
            on = np.flatnonzero((off < 1e-9) & (s > 0) & (s < 1))
            if len(on):
                quarter = {round(4 * t): finer[i] for i, t in zip(on, s[on], strict=True)}
                edges.append((a, m, b, quarter.get(1, -1), quarter.get(3, -1)))
            for i in on:
                rows += [len(nodes)] * 3
                columns += [a, b, m]
                values += line_shapes(s[i : i + 1])[0][0].tolist()
                nodes.append(finer[i])
    weights = sp.csr_matrix((values, (rows, columns)), shape=(len(nodes), len(whole.points)))
    hanging = HangingNodes.closed(np.array(nodes), weights, np.array(edges))
    mesh = replace(whole, hanging=hanging)
    for name, (axis, at) in {"left": (0, 0), "right": (0, 2), "bottom": (2, 0), "top": (2, 2)}.items():
        mesh = mesh.with_boundary(name, lambda x, axis=axis, at=at: np.abs(x[:, axis] - at) < 1e-9)
    return mesh
