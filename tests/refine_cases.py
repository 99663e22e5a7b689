"""Meshes that the tests of division share: every kind of cell, and all of them side by side."""

from dataclasses import replace

import numpy as np

import fecontact as fc
from fecontact import Mesh, merge
from fecontact.mesh.kinds import KINDS
from fecontact.mesh.refine import refined

#: A cube's corners in VTK's order, and its faces counter-clockwise seen from inside.
CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1.0]])
INWARD = {
    "x0": (0, 3, 7, 4),
    "x1": (1, 5, 6, 2),
    "y0": (0, 4, 5, 1),
    "y1": (3, 2, 6, 7),
    "z0": (0, 1, 2, 3),
    "z1": (4, 7, 6, 5),
}
#: Diagonals along which faces are cut, from their corner nearest the origin, so that neighbours agree.
FROM = {"x0": 0, "x1": 1, "y0": 0, "y1": 3, "z0": 0, "z1": 4}


def check_levels(x):
    """Boxes with corners x (n, k, d) have four sizes, and those that share more than a point differ by two at most."""
    low, high = x.min(axis=1), x.max(axis=1)
    size = (high - low)[:, 0]
    assert len(np.unique(size.round(9))) == 4
    overlap = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    # share more than a point: at least one axis overlaps, none is apart
    meet = (overlap > -1e-9).all(axis=2) & (overlap > 1e-9).any(axis=2)
    assert (size[:, None] / size)[meet].max() < 2.01


def lattice_mesh(n, cut):
    """n x n x len(cut) unit cubes, each layer cut into cells of linear kinds as `cut` says."""
    parts = []
    for k, kind in enumerate(cut):
        points, cells = cut_cube(kind)
        for i in range(n):
            for j in range(n):
                parts.append(Mesh(points + np.array([i, j, k]), cells))
    return merge(parts, 1e-9)


def cut_cube(kind):
    """Points and cells of a cube that is one hexahedron, two wedges, or a star whose faces in `kind` are triangles."""
    if kind == "hexahedron":
        return CUBE, np.array([range(8)])
    if kind == "wedges":
        wedges = np.array([[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]])
        return CUBE, KINDS["wedge6"].to_hexahedra(wedges)
    cells = []
    for face, ring in INWARD.items():
        if face in kind:
            start = ring.index(FROM[face])
            a, b, c, d = np.roll(ring, -start).tolist()
            cells += [KINDS["tet4"].to_hexahedra(np.array([t]))[0] for t in ((a, b, c, 8), (a, c, d, 8))]
        else:
            cells.append(KINDS["pyramid5"].to_hexahedra(np.array([(*ring, 8)]))[0])
    return np.concatenate([CUBE, [[0.5, 0.5, 0.5]]]), np.array(cells)


ALL = ("x0", "x1", "y0", "y1", "z0", "z1")
#: Layers of the meshes, from below.
LAYERS = {
    "hexahedra": ["hexahedron"] * 3,
    "wedges": ["wedges"] * 3,
    "pyramids": [()] * 3,
    "tetrahedra": [ALL] * 3,
    "all kinds": ["hexahedron", ("z1",), "wedges", ALL],
}
WIDTHS = {"hexahedra": (8, 20, 27)}
CASES = [(kind, width) for kind in LAYERS for width in WIDTHS.get(kind, (8, 20))]
#: An affine map without symmetry, so that nothing is right by accident.
AFFINE = np.array([[1.0, 0.2, 0.1], [-0.1, 0.8, 0.15], [0.05, -0.2, 1.2]])


def mesh_of(kind, width, n=3):
    """A mesh of n x n columns of cubes cut in layers; `all kinds` has hexahedra, pyramids, wedges and tetrahedra."""
    mesh = lattice_mesh(n, LAYERS[kind])
    return mesh if width == 8 else mesh.upgraded(width)


def bent(x, amount=0.06):
    """Points moved smoothly, so that edges and faces are curved."""
    wave = [np.sin(1.3 * x[:, 1] + 0.4 * x[:, 2]), np.cos(x[:, 0] - 0.6 * x[:, 2]), np.sin(0.9 * (x[:, 0] + x[:, 1]))]
    return x + amount * np.stack(wave, axis=1)


def near(mesh, place, radius):
    """Cells (n_cells,) with the mean of their corners within a radius of a place."""
    corners = mesh.points[mesh.cells[:, : mesh.n_corners]]
    return np.linalg.norm(corners.mean(axis=1) - place, axis=1) < radius


def refined_near(mesh, place, radii):
    """Divided once for each radius, within that radius of a place."""
    for radius in radii:
        mesh = refined(mesh, near(mesh, place, radius))
    return mesh


def locally_refined(kind, width, levels=2):
    """Divided in a shrinking neighbourhood of a place on the top, levels times, with all four kinds reached."""
    mesh = mesh_of(kind, width)
    place = [1.2, 1.4, mesh.points[:, 2].max() - 1.1]
    return refined_near(mesh, place, [1.2, 0.7, 0.35][:levels])


def one_edge_pair(width):
    """Two hexahedra side by side, each with one collapsed edge: seven corners, no division of their own."""
    points = CUBE.copy()
    cell = np.array([[0, 1, 1, 3, 4, 5, 6, 7]])
    points[2] = points[1]
    used, cells = np.unique(cell, return_inverse=True)
    left = Mesh(points[used], cells.reshape(1, -1))
    right = left.mapped(lambda x: x * [-1, 1, 1])
    order = [1, 0, 3, 2, 5, 4, 7, 6]
    pair = merge([left, replace(right, cells=right.cells[:, order])], 1e-9)
    return pair if width == 8 else pair.upgraded(width)


def section(width, n=4):
    """A rectangle of quadrilaterals of 8 or 9 nodes."""
    return fc.sections.rectangle((1.0, 0.8), (n, n), element=f"quad{width}")
