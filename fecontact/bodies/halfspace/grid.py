"""Rectangular grids of equal cells on the surface of a half-space."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError


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
        try:
            sides = tuple(float(s) for s in self.size)
            counts = tuple(int(n) for n in self.shape)
            whole = all(int(n) == n for n in self.shape)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"A grid needs size=(width, length) and shape=(cells along x, cells along y); "
                f"found size={self.size!r}, shape={self.shape!r}."
            ) from error
        if len(sides) != 2 or not all(math.isfinite(s) and s > 0 for s in sides):
            raise InputError(f"A grid's size must be two positive lengths; found {self.size!r}.")
        if len(counts) != 2 or not whole or min(counts) < 2:
            raise InputError(f"A grid's shape must be two whole numbers of cells, at least 2; found {self.shape!r}.")
        object.__setattr__(self, "size", sides)
        object.__setattr__(self, "shape", counts)

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
