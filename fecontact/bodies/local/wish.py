"""What is asked of a window: its middle, its sides, its cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.halfspace.grid import Grid
from fecontact.common.arrays import Array
from fecontact.common.checks import vector


@dataclass(frozen=True, eq=False)
class Wish:
    """A window as it is asked for.

    Attributes
    ----------
    at : (3,) array or None
    sides : (float, float) or None
    shape : (int, int)

    Examples
    --------
    >>> Wish.of(None, 2.0, (64, 32)).sides
    (2.0, 2.0)
    """

    at: Array | None
    sides: tuple[float, float] | None
    shape: tuple[int, int]

    @classmethod
    def of(cls, at: ArrayLike | None, window: float | tuple[float, float] | None, shape: tuple[int, int]) -> Wish:
        """From the arguments of a local body.

        Raises
        ------
        InputError
            If they are no point, no lengths or no numbers of cells.
        """
        sides = None if window is None else window if isinstance(window, tuple | list) else (window, window)
        grid = Grid((1.0, 1.0) if sides is None else sides, shape)
        where = None if at is None else np.asarray(vector("the middle of the window", at, 3), dtype=float)
        return cls(where, None if sides is None else grid.size, grid.shape)
