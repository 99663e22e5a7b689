"""Array types: of numbers, of indices, of flags; numbers without their rounding."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: A number, relative to what it is a part of, that is rounding.
ROUNDING = 1e-9


def without_rounding(values: Array, size: float = 0.0) -> Array:
    """Values with those that are rounding beside the largest of them, or beside a size, as zero; for texts.

    Examples
    --------
    >>> without_rounding(np.array([3e-14, -2e-19]), 1.0).tolist(), without_rounding(np.array([1e-14, 1.0])).tolist()
    ([0.0, 0.0], [0.0, 1.0])
    """
    largest = max(size, float(np.abs(values).max(initial=0.0)))
    return np.where(np.abs(values) > ROUNDING * largest, values, 0.0)
