"""Array types: of numbers, of indices, of flags; numbers without their rounding."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: A number, relative to what it is a part of, that is rounding.
ROUNDING = 1e-9
#: Rows of a large matrix that are changed at once, without a second copy of it.
STRIP = 512


def without_rounding(values: Array, size: float = 0.0) -> Array:
    """Values with those that are rounding beside the largest of them, or beside a size, as zero; for texts.

    Examples
    --------
    >>> without_rounding(np.array([3e-14, -2e-19]), 1.0).tolist(), without_rounding(np.array([1e-14, 1.0])).tolist()
    ([0.0, 0.0], [0.0, 1.0])
    """
    largest = max(size, float(np.abs(values).max(initial=0.0)))
    return np.where(np.abs(values) > ROUNDING * largest, values, 0.0)


def cross(a: Array, b: Array) -> Array:
    """Products a x b (..., 3) of vectors (..., 3): the numbers of `np.cross` in a half of its time, of many in a tenth.

    Examples
    --------
    >>> cross(np.array([1.0, 0.0, 0.0]), np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])).tolist()
    [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    """
    (a1, a2, a3), (b1, b2, b3) = (tuple(v[..., k] for k in range(3)) for v in (a, b))
    out = np.empty((*np.broadcast_shapes(a1.shape, b1.shape), 3))
    for k, (p, q, r, s) in enumerate(((a2, b3, a3, b2), (a3, b1, a1, b3), (a1, b2, a2, b1))):
        np.subtract(p * q, r * s, out=out[..., k])
    return out


def mirrored(S: Array) -> Array:
    """A symmetric matrix of whose entries those above the diagonal are arbitrary, in place.

    Examples
    --------
    >>> mirrored(np.array([[1.0, 0.0], [2.0, 3.0]])).tolist()
    [[1.0, 2.0], [2.0, 3.0]]
    """
    for start in range(0, len(S), STRIP):
        end = start + STRIP
        strip = slice(start, end)
        S[strip, strip] = np.tril(S[strip, strip]) + np.tril(S[strip, strip], -1).T
        S[strip, end:] = S[end:, strip].T
    return S
