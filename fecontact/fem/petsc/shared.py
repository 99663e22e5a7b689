"""What the program and the processes of a job share: messages, and rows of a stiffness. NumPy only.

Messages are arrays by name, through a socket, as NumPy's archive, without objects: both sides may have different
versions of Python and NumPy.

Block rows of a stiffness that one process owns are those of the cells that touch its nodes. Cells at the border of two
parts are integrated in both, so that no rows are exchanged.
"""

from __future__ import annotations

import io
import socket
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray
from fecontact.fem.element_stiffness import element_stiffness, physical_gradients, with_means

Message = dict[str, NDArray[Any]]

#: Length of a message in front of it.
LENGTH = struct.Struct("<q")


def send(to: socket.socket, **arrays: Any) -> None:
    """Send arrays, numbers or texts.

    Examples
    --------
    >>> here, there = socket.socketpair()
    >>> send(here, what="half", of=np.array([1.0, 3.0]))
    >>> message = receive(there)
    >>> str(message["what"]), (message["of"] / 2).tolist()
    ('half', [0.5, 1.5])
    """
    archive = io.BytesIO()
    np.savez(archive, allow_pickle=False, **arrays)
    data = archive.getbuffer()
    to.sendall(LENGTH.pack(len(data)))
    to.sendall(data)


def receive(other: socket.socket) -> Message:
    """The next message.

    Raises
    ------
    ConnectionError
        If the other side has ended.
    """
    (size,) = LENGTH.unpack(_exactly(other, LENGTH.size))
    with np.load(io.BytesIO(_exactly(other, size)), allow_pickle=False) as archive:
        return dict(archive)


def _exactly(other: socket.socket, size: int) -> bytearray:
    data = bytearray(size)
    view, got = memoryview(data), 0
    while got < size:
        count = other.recv_into(view[got:])
        if count == 0:
            raise ConnectionError("the other side has ended")
        got += count
    return data


#: Cells integrated at once.
BATCH = 1024


@dataclass(frozen=True, eq=False)
class ElasticCells:
    """Cells of one kind, with their moduli and rules.

    Attributes
    ----------
    nodes : (n_cells, n_functions) array
    lame, shear : (n_cells,) arrays
        Lame constants.
    rules : sequence of (dN, W)
        Gradients (n_q, n_functions, 3) of the functions on the reference cell and weights (n_q,); then those of the
        volumetric part, where it is integrated by another rule.
    """

    nodes: IntArray
    lame: Array
    shear: Array
    rules: Sequence[tuple[Array, Array]]

    def touching(self, first: int, last: int) -> ElasticCells:
        """Cells with a node in first..last - 1."""
        mine = ((self.nodes >= first) & (self.nodes < last)).any(axis=1)
        return ElasticCells(self.nodes[mine], self.lame[mine], self.shear[mine], self.rules)

    def parts(self) -> Iterator[ElasticCells]:
        """The cells in batches."""
        for start in range(0, len(self.nodes), BATCH):
            part = slice(start, start + BATCH)
            yield ElasticCells(self.nodes[part], self.lame[part], self.shear[part], self.rules)

    def stiffness(self, points: Array) -> Array:
        """Stiffness matrices (n_cells, n_functions, n_functions, 3, 3) of the cells of a mesh with points (n, 3)."""
        full, *reduced = (physical_gradients(points[self.nodes], dN, W) for dN, W in self.rules)
        volumetric = [_Gradients(*with_means(*full, *each)) for each in reduced]
        return element_stiffness(_Gradients(*full), self.lame, self.shear, *volumetric)


@dataclass(frozen=True, eq=False)
class _Gradients:
    gradients: Array
    dV: Array


def block_rows(points: Array, cells: Sequence[ElasticCells], first: int, last: int) -> tuple[IntArray, IntArray, Array]:
    """Rows first..last - 1 of the stiffness, in blocks of 3 x 3 for pairs of nodes.

    Parameters
    ----------
    points : (n, 3) array
    cells : sequence of ElasticCells
    first, last : int
        Nodes whose rows are asked for.

    Returns
    -------
    indptr, indices, blocks : (last - first + 1,), (k,) and (k, 3, 3) arrays
        As in compressed rows; columns are sorted.

    Examples
    --------
    Two cubes of one hexahedral mesh; the rows of a part are those of the whole:

    >>> import fecontact as fc
    >>> from fecontact.fem.petsc.parts import cells_of
    >>> mesh = fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8")
    >>> body = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), contact="top", supports={"bottom": "xyz"})
    >>> cells = cells_of(body.model, np.arange(12))
    >>> _, _, every = block_rows(mesh.points, cells, 0, 12)
    >>> _, _, some = block_rows(mesh.points, cells, 0, 5)
    >>> bool(np.allclose(every[: len(some)], some))
    True
    """
    n = len(points)
    own = [part for group in cells for part in group.touching(first, last).parts()]
    found = [np.unique(_keys(part.nodes, first, last, n)) for part in own]
    keys = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *found]))
    blocks = np.zeros((len(keys), 3, 3))
    for part in own:
        mine = (part.nodes >= first) & (part.nodes < last)
        values = part.stiffness(points)[mine].reshape(-1, 3, 3)
        number = np.searchsorted(keys, _keys(part.nodes, first, last, n))
        order = np.argsort(number, kind="stable")
        number = number[order]
        start = np.flatnonzero(np.concatenate([[True], number[1:] != number[:-1]]))
        blocks[number[start]] += np.add.reduceat(values[order], start, axis=0)
    rows, columns = np.divmod(keys, n)
    return np.searchsorted(rows, np.arange(last - first + 1)), columns, blocks


def _keys(nodes: IntArray, first: int, last: int, n: int) -> IntArray:
    """Numbers of all pairs (a node in first..last - 1, a node) in cells."""
    mine = (nodes >= first) & (nodes < last)
    pairs = (nodes[:, :, None] - first) * n + nodes[:, None, :]
    return np.asarray(pairs[mine].ravel(), dtype=np.int64)
