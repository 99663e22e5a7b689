"""Array types: of numbers, of indices, of flags; places among members, unit vectors."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]


def places_among(members: IntArray, n: int) -> IntArray:
    """Place of each of 0 ... n - 1 among distinct members; -1 for those that are none.

    Examples
    --------
    >>> places_among(np.array([2, 0]), 4).tolist()
    [1, -1, 0, -1]
    """
    place = np.full(n, -1, dtype=np.int64)
    place[members] = np.arange(len(members))
    return place


def unit_vectors(vectors: Array) -> Array:
    """Vectors (..., k) over their lengths; zero where these are.

    Examples
    --------
    >>> unit_vectors(np.array([[3.0, 4.0], [0.0, 0.0]])).tolist()
    [[0.6, 0.8], [0.0, 0.0]]
    """
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))
