"""Mirror symmetry of a problem about the middle of its grid: detection, reduction and expansion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import Array, Mask

Even = tuple[bool, bool]

ROUNDING = 1e-14
"""Difference of mirrored values, relative to the largest, that counts as rounding."""


def even_axes(values: Array, allowed: Mask, rows: Array) -> Even:
    """Axes about whose middle values (nx, ny), mask (nx, ny) and rows (m, nx, ny) are mirror images.

    Examples
    --------
    >>> import numpy as np
    >>> z = np.array([[1.0, 2.0], [1.0, 2.0]])
    >>> even_axes(z, z > 0, np.ones((1, 2, 2)))
    (True, False)
    """
    scale = float(np.abs(values).max())
    out = []
    for axis in (0, 1):
        even = values.shape[axis] % 2 == 0 and bool((allowed == np.flip(allowed, axis)).all())
        even = even and float(np.abs(values - np.flip(values, axis)).max()) <= ROUNDING * scale
        out.append(even and all(float(np.abs(r - np.flip(r, axis)).max()) <= ROUNDING * np.abs(r).max() for r in rows))
    return out[0], out[1]


def part_of(shape: tuple[int, int], symmetric: Even) -> tuple[slice, slice]:
    """The half or quarter with positive coordinates."""
    x, y = (slice(n // 2 if even else 0, n) for n, even in zip(shape, symmetric, strict=True))
    return x, y


def unfold(values: NDArray, symmetric: Even) -> NDArray:
    """Values of a half or quarter mirrored to the whole grid.

    Examples
    --------
    >>> import numpy as np
    >>> unfold(np.array([[1.0, 2.0]]), (False, True)).tolist()
    [[2.0, 1.0, 1.0, 2.0]]
    """
    for axis in (0, 1):
        if symmetric[axis]:
            values = np.concatenate([np.flip(values, axis), values], axis=axis)
    return values
