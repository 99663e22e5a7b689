"""Files that meshio reads: .vtk, .vtu, .xdmf."""

from __future__ import annotations

import contextlib
import io
import tempfile
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError, MissingPackageError
from fecontact.mesh.formats.raw import RawMesh
from fecontact.mesh.kinds import BY_MESHIO

#: Corners of the surface cells of meshio.
FACET_CORNERS = {"triangle": 3, "triangle6": 3, "triangle7": 3, "quad": 4, "quad8": 4, "quad9": 4}
#: Cells of sections by meshio's names.
SHEETS = {"triangle": "tri3", "triangle6": "tri6", "quad": "quad4", "quad8": "quad8", "quad9": "quad9"}
#: Cells of lower dimension, which are ignored.
_LINES_AND_POINTS = ("vertex", "line", "line3", "line4")
#: Integer cell data with more distinct values than this are cell numbers, not regions.
MAX_REGIONS = 64
#: Permutation of a wedge's nodes (6 and 15) that exchanges its two triangles.
_TURNED_WEDGE = (3, 4, 5, 0, 1, 2, 9, 10, 11, 6, 7, 8, 12, 13, 14)


def teach_meshio() -> None:
    """Register quadratic wedges and pyramids as solids with meshio, which reads them but has no dimension for them."""
    from meshio._mesh import topological_dimension

    for kind in BY_MESHIO:
        topological_dimension.setdefault(kind, 3)


def load(path: Path, reader: Callable[[str], Any]) -> tuple[Any, tuple[str, ...]]:
    """Read a file with meshio; its failures become one error, its warnings become notes.

    Raises
    ------
    MeshError, MissingPackageError
    """
    teach_meshio()
    printed = io.StringIO()
    try:
        with warnings.catch_warnings(record=True) as caught, contextlib.redirect_stderr(printed):
            warnings.simplefilter("always")
            mesh = reader(str(path))
    except ImportError as error:
        raise MissingPackageError(f"{path.name} needs the package {error.name!r} to be read; install it.") from error
    except (Exception, SystemExit) as error:
        reason = str(error).strip() or type(error).__name__
        raise MeshError(f"{path.name} could not be read: {reason}. The file is damaged or of another type.") from error
    said = [" ".join(printed.getvalue().split()), *(str(w.message) for w in caught)]
    return mesh, tuple(f"{path.name}, says meshio: {text}" for text in said if text)


def points_in_space(points: Array, source: str) -> Array:
    """Points (n, 3); of a plane mesh the third coordinate is zero."""
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise MeshError(f"{source} has points of shape {points.shape}; expected two or three coordinates.")
    points = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    return np.asarray(points, dtype=float)


def read_vtk(path: Path) -> RawMesh:
    """VTK, VTU, XDMF: integer cell data with few values become element sets and boundaries, as 'region_3'."""
    import meshio

    reader = {".vtk": meshio.vtk.read, ".vtu": meshio.vtu.read}.get(path.suffix.lower(), meshio.xdmf.read)
    try:
        mesh, notes = load(path, reader)
    except MeshError:
        # cell data of binary .vtk files by gmsh have no line end, which meshio expects
        before = path.read_bytes().rpartition(b"CELL_DATA")[0] if path.suffix.lower() == ".vtk" else b""
        if not before:
            raise
        with tempfile.TemporaryFile() as file:
            file.write(before)
            file.seek(0)
            mesh, notes = load(path, lambda _: meshio.vtk._main.read_buffer(file))
        notes = (*notes, f"{path.name}: the cell data could not be read and are left out.")
    data = {
        name: blocks
        for name, blocks in mesh.cell_data.items()
        if all(np.asarray(b).ndim == 1 and np.issubdtype(np.asarray(b).dtype, np.integer) for b in blocks)
        and len(np.unique(np.concatenate(blocks))) <= MAX_REGIONS
    }

    def regions(block: int, dim: int) -> list[tuple[str, IntArray]]:
        return [
            (f"{name}_{value}", np.flatnonzero(np.asarray(blocks[block]) == value))
            for name, blocks in data.items()
            for value in np.unique(blocks[block])
        ]

    raw = _collect(mesh, path.name, regions)
    return replace(raw, blocks=[_right_handed(raw.points, *b) for b in raw.blocks], notes=notes)


def _collect(mesh: Any, source: str, regions: Callable[[int, int], list[tuple[str, IntArray]]]) -> RawMesh:
    """Solids and surfaces of meshio's blocks."""
    blocks, start = [], 0
    groups: dict[str, list[IntArray]] = {}
    facets: dict[str, list[IntArray]] = {}
    sheets: list[tuple[str, str, IntArray]] = []
    for k, block in enumerate(mesh.cells):
        cells = np.asarray(block.data, dtype=np.int64)
        if block.type in BY_MESHIO:
            blocks.append((BY_MESHIO[block.type].name, cells))
            for name, members in regions(k, 3):
                groups.setdefault(name, []).append(start + members)
            start += len(cells)
        elif block.type in FACET_CORNERS:
            for name, members in regions(k, 2):
                facets.setdefault(name, []).append(cells[members, : FACET_CORNERS[block.type]])
            if block.type in SHEETS:
                found = [(name, SHEETS[block.type], cells[members]) for name, members in regions(k, 2)]
                sheets += found or [("section", SHEETS[block.type], cells)]
        elif block.type == "wedge18":
            # the three mid-nodes of the quadrilaterals are left out
            blocks.append(("wedge15", cells[:, :15]))
            for name, members in regions(k, 3):
                groups.setdefault(name, []).append(start + members)
            start += len(cells)
        elif block.type not in _LINES_AND_POINTS:
            raise MeshError(
                f"{source} holds cells of the type {block.type!r}; expected hexahedra, wedges, pyramids or tetrahedra, "
                f"linear or quadratic ({', '.join(BY_MESHIO)})."
            )
    points = points_in_space(np.asarray(mesh.points), source)
    return RawMesh(points, blocks, {k: np.concatenate(v) for k, v in groups.items()}, facets, sheets=sheets)


def _right_handed(points: Array, kind: str, cells: IntArray) -> tuple[str, IntArray]:
    """Reorder wedges written as in VTK's book, first triangle outwards; most programs write them the other way."""
    if kind not in ("wedge6", "wedge15") or cells.min() < 0 or cells.max() >= len(points):
        return kind, cells
    x = points[cells[:, :6]]
    up = x[:, 3:].mean(axis=1) - x[:, :3].mean(axis=1)
    left = np.einsum("ni,ni->n", np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), up) < 0
    return kind, np.where(left[:, None], cells[:, list(_TURNED_WEDGE[: cells.shape[1]])], cells)
