"""Surfaces in .stl, .obj, .off and .ply files: points and polygons."""

from __future__ import annotations

from pathlib import Path
from typing import Any

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
                "The file is incomplete.",
                code="incomplete",
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
                raise MeshError(f"{path.name}: the vertex {' '.join(words)!r} needs three coordinates.", code="no-xyz")
            points.append(words[1:4])
        elif words[0] == "f":
            given = [int(word.split("/")[0]) for word in words[1:]]
            if len(given) < 3 or 0 in given:
                raise MeshError(f"{path.name}: the face {' '.join(words)!r} needs three corners or more, from 1.")
            polygons.setdefault(len(given), []).append([k - 1 if k > 0 else len(points) + k for k in given])
    return np.array(points, dtype=float).reshape(-1, 3), [np.array(p, dtype=np.int64) for p in polygons.values()]


def read_off(path: Path) -> tuple[Array, list[IntArray]]:
    """Points and polygons of an .off file; colours and normals are left out (Geomview manual, "OFF Files")."""
    lines = [line.split(b"#")[0].split() for line in path.read_bytes().splitlines()]
    rows = [words for words in lines if words]
    if not rows or not rows[0][0].upper().endswith(b"OFF"):
        raise MeshError(f"{path.name} could not be read: it does not begin with OFF. The file is of another type.")
    first = rows[0][1:] or (rows[1] if len(rows) > 1 else [])
    body = rows[1:] if len(rows[0]) > 1 else rows[2:]
    if len(first) < 2 or len(body) < int(first[0]) + int(first[1]):
        raise MeshError(f"{path.name} announces more points and faces than it holds. The file is incomplete.")
    n_points, n_faces = int(first[0]), int(first[1])
    points = np.array([words[:3] for words in body[:n_points]], dtype=float).reshape(-1, 3)
    faces = _grouped([words[1 : int(words[0]) + 1] for words in body[n_points : n_points + n_faces]])
    return points, [f for f in faces if f.shape[1] > 2]


def _grouped(lists: list[list[bytes]], dtype: type = np.int64) -> list[Any]:
    """Lists by their lengths, as arrays (n, length)."""
    found: dict[int, list[list[bytes]]] = {}
    for words in lists:
        found.setdefault(len(words), []).append(words)
    return [np.array(rows, dtype=dtype) for rows in found.values()]


#: Types of numbers in .ply files.
_PLY = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4"}
_PLY |= {"double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"}
_PLY |= {"float32": "f4", "float64": "f8"}
#: Properties of an element of a .ply file: name, type, and the type of its length if it is a list.
_Property = tuple[str, str, str | None]


def read_ply(path: Path) -> tuple[Array, list[IntArray]]:
    """Points and polygons of a .ply file, text or binary, among any other elements and lists (G. Turk, 1994)."""
    data = path.read_bytes()
    head, mark, body = data.partition(b"end_header")
    lines = [line.decode("latin-1").split() for line in head.splitlines()]
    if not mark or not lines or lines[0] != ["ply"]:
        raise MeshError(f"{path.name} could not be read: it has no header of a .ply file.", code="no-ply-header")
    form = ""
    elements: list[tuple[str, int, list[_Property]]] = []
    for words in lines[1:]:
        if words[:1] == ["format"] and len(words) > 1:
            form = words[1]
        elif words[:1] == ["element"] and len(words) > 2:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"] and elements:
            listed = words[1] == "list"
            elements[-1][2].append((words[-1], _PLY[words[-2]], _PLY[words[2]] if listed else None))
    body = body.partition(b"\n")[2]
    if form == "ascii":
        found = _ply_text(body, elements, path.name)
    elif form in ("binary_little_endian", "binary_big_endian"):
        found = _ply_binary(body, elements, "<" if "little" in form else ">", path.name)
    else:
        raise MeshError(f"{path.name} is of the format {form!r}; expected ascii or binary.", code="ply-format")
    points, polygons = np.zeros((0, 3)), []
    if {"x", "y", "z"} <= set(found.get("vertex", {})):
        points = np.stack([np.asarray(found["vertex"][c], dtype=float) for c in "xyz"], axis=1)
    for name in ("vertex_indices", "vertex_index"):
        polygons += found.get("face", {}).get(name, [])
    return points, [p for p in polygons if p.shape[1] > 2]


def _ply_text(body: bytes, elements: list[tuple[str, int, list[_Property]]], source: str) -> dict[str, dict[str, Any]]:
    """Properties of elements, one line each: arrays, and of lists arrays (n, k) for each length k."""
    rows = [row for row in (line.split() for line in body.splitlines()) if row]
    out: dict[str, dict[str, Any]] = {}
    for name, count, properties in elements:
        own, rows = rows[:count], rows[count:]
        if len(own) < count:
            raise MeshError(f"{source} announces {count} of {name!r} and holds {len(own)}. The file is incomplete.")
        starts = np.zeros(count, dtype=np.int64)
        out[name] = {}
        for prop, kind, length in properties:
            if length is None:
                out[name][prop] = np.array([row[k] for row, k in zip(own, starts.tolist(), strict=True)], dtype=float)
                starts += 1
                continue
            sizes = np.array([row[k] for row, k in zip(own, starts.tolist(), strict=True)], dtype=np.int64)
            ends = zip(own, (starts + 1).tolist(), (starts + 1 + sizes).tolist(), strict=True)
            number = float if kind.startswith("f") else np.int64
            out[name][prop] = _grouped([row[a:b] for row, a, b in ends], number)
            starts += 1 + sizes
    return out


def _ply_binary(
    body: bytes, elements: list[tuple[str, int, list[_Property]]], order: str, source: str
) -> dict[str, dict[str, Any]]:
    """The same of binary files; elements with lists in runs of equal lengths."""
    out: dict[str, dict[str, Any]] = {}
    at = 0
    for name, count, properties in elements:
        parts: dict[str, list[Any]] = {prop: [] for prop, _, _ in properties}
        while count > 0:
            dtype = _ply_record(body, at, properties, order, source)
            run = np.frombuffer(body, dtype, min(count, (len(body) - at) // dtype.itemsize), at)
            alike = np.ones(len(run), bool)
            for prop, _, length in properties:
                if length is not None:
                    alike &= run[f"n {prop}"] == run[f"n {prop}"][0]
            n = len(run) if alike.all() else int(np.argmin(alike))
            for prop, _, _ in properties:
                parts[prop].append(run[prop][:n])
            at, count = at + n * dtype.itemsize, count - n
        out[name] = {}
        for prop, kind, length in properties:
            found = parts[prop]
            whole = not kind.startswith("f")
            out[name][prop] = (
                [a.astype(np.int64) if whole else a for a in found]
                if length is not None
                else np.concatenate(found or [[]])
            )
    return out


def _ply_record(body: bytes, at: int, properties: list[_Property], order: str, source: str) -> np.dtype:
    """Layout of the element at a place."""
    fields: list[Any] = []
    for prop, kind, length in properties:
        if length is None:
            fields.append((prop, order + kind))
        else:
            here = at + np.dtype(fields).itemsize
            if here + np.dtype(length).itemsize > len(body):
                raise MeshError(f"{source} ends too early. The file is incomplete.")
            n = int(np.frombuffer(body, order + length, 1, here)[0])
            fields += [(f"n {prop}", order + length), (prop, order + kind, (n,))]
    dtype = np.dtype(fields)
    if at + dtype.itemsize > len(body) or dtype.itemsize == 0:
        raise MeshError(f"{source} ends too early. The file is incomplete.")
    return dtype
