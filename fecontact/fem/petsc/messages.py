"""Messages between the program and the processes of a job: arrays by name, through a socket, as NumPy's archive.

NumPy only, and no objects: both sides may have different versions of Python and NumPy.
"""

from __future__ import annotations

import io
import socket
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

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
