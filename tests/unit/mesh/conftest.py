"""Blocks of every kind of cell, curved inside, and their way into files."""

import meshio
import numpy as np
import pytest

import fecontact as fc
from fecontact import Mesh
from fecontact.mesh.formats.generic import teach_meshio
from fecontact.mesh.kinds import KINDS

# a cube into six tetrahedra round its diagonal, or two wedges
SIX = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
TWO = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]
SIDES = ("x_min", "x_max", "y_min", "y_max", "bottom", "top")


def _cut(cells, pieces, kind):
    return KINDS[kind].to_hexahedra(np.concatenate([cells[:, piece] for piece in pieces]))


def _block(kind, divisions=(2, 2, 2), amount=0.03):
    """Unit cube of one kind of cell (or hexahedra and wedges side by side), its inside curved smoothly."""
    base = fc.shapes.block((1.0, 1.0, 1.0), divisions, element="hex8")
    if kind.startswith("hex"):
        mesh = fc.shapes.block((1.0, 1.0, 1.0), divisions, element=kind)
    else:
        left = base.points[base.cells].mean(axis=1)[:, 0] < 0.5
        cells = {
            "tet": lambda: _cut(base.cells, SIX, "tet4"),
            "wed": lambda: _cut(base.cells, TWO, "wedge6"),
            "mix": lambda: np.concatenate([base.cells[left], _cut(base.cells[~left], TWO, "wedge6")]),
        }[kind[:3]]()
        mesh = Mesh(base.points, cells)
        mesh = mesh if kind in ("tet4", "wedge6") else mesh.upgraded(20)
        for name in SIDES:
            axis, at = "xyz".index(name[0]) if name[1] == "_" else 2, float(name in ("x_max", "y_max", "top"))
            mesh = mesh.with_boundary(name, lambda x, axis=axis, at=at: np.abs(x[:, axis] - at) < 1e-12)

    def bend(x):
        inside = 64 * np.prod(x * (1 - x), axis=1, keepdims=True)
        return x + amount * inside * np.stack([np.sin(3 * x[:, 1]), np.cos(2 * x[:, 0]), np.sin(4 * x[:, 0])], axis=1)

    return mesh.mapped(bend)


def _write(mesh, path):
    teach_meshio()
    out = meshio.Mesh(mesh.points, [(name, cells) for name, cells, _ in mesh.native_cells()])
    if path.suffix == ".msh":
        meshio.gmsh.write(path, out, fmt_version="2.2")
    else:
        meshio.write(path, out)
    return path


@pytest.fixture
def block():
    return _block


@pytest.fixture
def write():
    return _write
