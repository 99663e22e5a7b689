"""Surfaces in .stl and .obj files: points and polygons."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError

#: A triangle of a binary .stl file: normal, corners, and two unused bytes.
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(path: Path) -> tuple[Array, list[IntArray]]:
    """Points, three for each triangle, and the triangles of an .stl file, binary or text.

    A binary file is recognised by its length, 84 bytes and 50 for each triangle.
    """
    data = path.read_bytes()
    if len(data) >= 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        corners = np.frombuffer(data, _RECORD, offset=84)["corners"].astype(float)
    else:
        if b"\0" in data:
            raise MeshError(
                f"{path.name} is binary, but its {len(data)} bytes are not those of the triangles that it announces. "
                "The file is incomplete."
            )
        lines = [line.split() for line in data.decode("latin-1").splitlines()]
        rows = [words[1:] for words in lines if words and words[0].lower() == "vertex"]
        if any(len(row) != 3 for row in rows) or len(rows) % 3:
            raise MeshError(f"{path.name} has {len(rows)} vertices, which are no triangles of three coordinates each.")
        corners = np.array(rows, dtype=float).reshape(-1, 3, 3)
    return corners.reshape(-1, 3), [np.arange(3 * len(corners)).reshape(-1, 3)]


def read_obj(path: Path) -> tuple[Array, list[IntArray]]:
    """Points of an .obj file and its polygons, grouped by number of corners.

    Negative numbers count back from the vertex read last (Wavefront, Advanced Visualizer manual, appendix B).
    """
    points: list[list[str]] = []
    polygons: dict[int, list[list[int]]] = {}
    text = path.read_text(encoding="latin-1").replace("\\\n", " ")
    for words in (line.split("#")[0].split() for line in text.splitlines()):
        if not words:
            continue
        if words[0] == "v":
            if len(words) < 4:
                raise MeshError(f"{path.name}: the vertex {' '.join(words)!r} needs three coordinates.")
            points.append(words[1:4])
        elif words[0] == "f":
            given = [int(word.split("/")[0]) for word in words[1:]]
            if len(given) < 3 or 0 in given:
                raise MeshError(f"{path.name}: the face {' '.join(words)!r} needs three corners or more, from 1.")
            polygons.setdefault(len(given), []).append([k - 1 if k > 0 else len(points) + k for k in given])
    return np.array(points, dtype=float).reshape(-1, 3), [np.array(p, dtype=np.int64) for p in polygons.values()]
