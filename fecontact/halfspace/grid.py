"""Rectangular grids of equal cells on the surface of a half-space.

Mirror symmetry of a problem about the middle of its grid: detection, reduction and expansion.

Sums over blocks of cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import Array, Mask
from fecontact.common.checks import array_of, positives
from fecontact.common.errors import InputError, shown

#: Cells of a grid, beyond which one field fills 8 GB.
MAX_CELLS = 10**9


@dataclass(frozen=True)
class Grid:
    """Cells of equal size on a rectangle centred on the origin.

    Parameters
    ----------
    size : (float, float)
        Sides of the rectangle along x and y.
    shape : (int, int)
        Number of cells along x and y, at least 2 each.

    Raises
    ------
    InputError
        If sides are not positive, or numbers of cells are not integers of at least 2.

    Examples
    --------
    >>> grid = Grid((4.0, 2.0), (4, 2))
    >>> grid.cell, grid.x.tolist()
    ((1.0, 1.0), [-1.5, -0.5, 0.5, 1.5])
    """

    size: tuple[float, float]
    shape: tuple[int, int]

    def __post_init__(self) -> None:
        counts = array_of(self.shape)
        if counts is None or counts.shape != (2,) or not (counts >= 2).all() or (counts % 1).any():
            raise InputError(
                f"A grid's shape must be two whole numbers of cells, at least 2; found {shown(self.shape)}.",
                code="grid-shape",
            )
        if counts.prod() > MAX_CELLS:
            raise InputError(f"A grid of {counts[0]:g} x {counts[1]:g} cells does not fit into memory; take fewer.")
        object.__setattr__(self, "size", positives("a grid's size", self.size, 2))
        object.__setattr__(self, "shape", (int(counts[0]), int(counts[1])))

    @property
    def cell(self) -> tuple[float, float]:
        """Sides of a cell."""
        return self.size[0] / self.shape[0], self.size[1] / self.shape[1]

    @property
    def area(self) -> float:
        """Area of a cell."""
        return self.cell[0] * self.cell[1]

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]

    @cached_property
    def x(self) -> Array:
        """Centres (nx,) of the cells along x; exactly antisymmetric."""
        return _centres(self.size[0], self.shape[0])

    @cached_property
    def y(self) -> Array:
        """Centres (ny,) of the cells along y; exactly antisymmetric."""
        return _centres(self.size[1], self.shape[1])

    @property
    def coarser(self) -> Grid:
        """The grid of cells twice as large that covers this one; it may extend beyond by one row of cells."""
        counts = ((self.shape[0] + 1) // 2, (self.shape[1] + 1) // 2)
        dx, dy = self.cell
        return Grid((2 * dx * counts[0], 2 * dy * counts[1]), counts)


def _centres(side: float, n: int) -> Array:
    return np.asarray((np.arange(n) - (n - 1) / 2) * (side / n), dtype=float)


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


def block_sums(values: NDArray, axes: Sequence[int] = (-2, -1)) -> NDArray:
    """Sums over blocks of 2 x 2 cells (..., mx, my), or of 2 along one axis; those at an odd end have fewer.

    Examples
    --------
    >>> import numpy as np
    >>> block_sums(np.ones((3, 2))).tolist()
    [[4.0], [2.0]]
    """
    for axis in axes:
        along = np.moveaxis(values, axis, -1)
        sums = along[..., ::2].copy()
        sums[..., : along.shape[-1] // 2] += along[..., 1::2]
        values = np.moveaxis(sums, -1, axis)
    return values


def block_means(values: NDArray, axes: Sequence[int] = (0, 1)) -> Array:
    """Means over blocks of 2 x 2 cells (mx, my, ...), or of 2 along one axis; at an odd end of the cells there are."""
    count = np.ones(values.shape[: len(axes)]).reshape(*values.shape[: len(axes)], *(1,) * (values.ndim - len(axes)))
    return np.asarray(block_sums(values, axes) / block_sums(count, axes))
