"""Surfaces in VTK's XML files .vtp: text, base64, and appended data, compressed by zlib or not.

VTK File Formats, "XML File Formats": a block of binary data begins with its length; a compressed one with the number of
blocks, their length, that of the last one, and their compressed lengths.
"""

from __future__ import annotations

import base64
import zlib
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError

TYPES = {"Float32": "f4", "Float64": "f8", "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2"}
TYPES |= {"Int32": "i4", "UInt32": "u4", "Int64": "i8", "UInt64": "u8"}


@dataclass(frozen=True)
class Encoding:
    """How a file encodes its arrays."""

    order: str
    header: str
    compressed: bool
    appended: bytes
    appended_raw: bool

    def array(self, node: ElementTree.Element) -> NDArray:
        """Numbers of a <DataArray>."""
        dtype = np.dtype(self.order + TYPES[node.get("type", "")])
        form = node.get("format", "ascii")
        if form == "ascii":
            return np.array((node.text or "").split(), dtype=dtype)
        if form == "appended" and self.appended_raw:
            return np.frombuffer(self._raw(self.appended[int(node.get("offset", 0)) :]), dtype)
        text = self.appended[int(node.get("offset", 0)) :] if form == "appended" else (node.text or "").strip().encode()
        return np.frombuffer(self._base64(text), dtype)

    def _numbers(self, data: bytes, count: int) -> list[int]:
        found: list[int] = np.frombuffer(data, self.order + self.header, count).tolist()
        return found

    def _sizes(self, data: bytes) -> tuple[int, list[int]]:
        """Length of the header, and lengths of the blocks."""
        width = np.dtype(self.header).itemsize
        if not self.compressed:
            return width, self._numbers(data, 1)
        (blocks,) = self._numbers(data, 1)
        return (3 + blocks) * width, self._numbers(data, 3 + blocks)[3:]

    def _raw(self, data: bytes) -> bytes:
        start, sizes = self._sizes(data)
        return self._joined(data[start : start + sum(sizes)], sizes)

    def _base64(self, text: bytes) -> bytes:
        width = np.dtype(self.header).itemsize
        if not self.compressed:
            start, sizes = self._sizes(_decoded(text, width))
            return _decoded(text, start + sizes[0])[start:]
        # the header is encoded by itself before the data
        (blocks,) = self._numbers(_decoded(text, width), 1)
        start, sizes = self._sizes(_decoded(text, (3 + blocks) * width))
        return self._joined(_decoded(text[_encoded(start) :], sum(sizes)), sizes)

    def _joined(self, data: bytes, sizes: list[int]) -> bytes:
        if not self.compressed:
            return data
        ends = np.cumsum(sizes).tolist()
        return b"".join(zlib.decompress(data[end - size : end]) for end, size in zip(ends, sizes, strict=True))


def _encoded(size: int) -> int:
    """Letters that encode a number of bytes in base64."""
    return 4 * -(-size // 3)


def _decoded(text: bytes, size: int) -> bytes:
    """The first bytes of what a text encodes in base64."""
    return base64.b64decode(text[: _encoded(size)])[:size]


def read_vtp(path: Path) -> tuple[Array, list[IntArray]]:
    """Points and polygons, grouped by number of corners."""
    data = path.read_bytes()
    head, mark, rest = data.partition(b"<AppendedData")
    appended, raw = b"", False
    if mark:
        attributes, _, content = rest.partition(b">")
        raw = b'"raw"' in attributes
        appended = content.partition(b"_")[2]
        head += b"</VTKFile>"
    try:
        root = ElementTree.fromstring(head)
    except ElementTree.ParseError as error:
        raise MeshError(f"{path.name} is no complete XML file: {error}.", code="incomplete-xml") from error
    if root.get("type") != "PolyData":
        raise MeshError(f"{path.name} holds {root.get('type')!r}; expected the PolyData of a surface.", code="no-poly")
    order = "<" if root.get("byte_order", "LittleEndian") == "LittleEndian" else ">"
    compressor = root.get("compressor")
    if compressor not in (None, "vtkZLibDataCompressor"):
        raise MeshError(f"{path.name} is compressed by {compressor}; save it with zlib or uncompressed.")
    encoding = Encoding(order, TYPES[root.get("header_type", "UInt32")], compressor is not None, appended, raw)
    points, start = [np.zeros((0, 3))], 0
    polygons: dict[int, list[IntArray]] = {}
    try:
        for piece in root.iter("Piece"):
            node = piece.find("Points/DataArray")
            own = np.zeros((0, 3)) if node is None else encoding.array(node).astype(float).reshape(-1, 3)
            arrays = {a.get("Name"): encoding.array(a).astype(np.int64) for a in piece.iterfind("Polys/DataArray")}
            if len(arrays.get("offsets", ())):
                _add(polygons, arrays["connectivity"] + start, arrays["offsets"])
            points.append(own)
            start += len(own)
    except (KeyError, IndexError, zlib.error) as error:
        raise MeshError(f"{path.name} could not be read: {error}. The file is damaged.", code="damaged") from error
    return np.concatenate(points), [np.concatenate(parts) for parts in polygons.values()]


def _add(polygons: dict[int, list[IntArray]], nodes: IntArray, ends: IntArray) -> None:
    """Sort polygons, given by their nodes and where each ends, by their numbers of corners."""
    starts = np.concatenate([[0], ends[:-1]])
    counts = ends - starts
    if (counts < 0).any() or ends[-1] > len(nodes):
        raise MeshError("The offsets of a .vtp file do not rise up to the number of its corners. The file is damaged.")
    for n in np.unique(counts).tolist():
        polygons.setdefault(n, []).append(nodes[starts[counts == n][:, None] + np.arange(n)])
