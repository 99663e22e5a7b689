"""Effect of the slopes of a curved surface on the compliance of its cells.

Pressures and displacements are along one direction. Where the surface inclines, loads on cells have a part along the
surface and are farther apart than on the plane; both together add (3 nu - 1)/(4 pi mu) z^2/d^3, with the difference z
of their heights and their distance d on the plane. As z^2 = f(x)^2 - 2 f(x) f(s) + f(s)^2 these are three convolutions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fecontact.analytic import curved_kernel
from fecontact.common.arrays import Array, IntArray
from fecontact.common.material import Material
from fecontact.halfspace.fft import Convolution, Tally, kernel_spectrum, padded
from fecontact.halfspace.grid import Even


@dataclass(frozen=True, eq=False)
class InclinedTerm:
    """Displacements that slopes add, of cells by pressures on them.

    Attributes
    ----------
    depth : (nx, ny) array
        Depth of the surface at the modelled cells below a plane.
    slopes : (nx, ny, 2) array
        Its derivatives along x and y.
    cell : (float, float)
        Sides of a cell.
    material : Material
    mirrored : (bool, bool)
        Axes along which only the cells with positive coordinates are modelled.
    single : bool
        Whether products are in single precision.

    References
    ----------
    docs/theory/local-bodies.md

    Examples
    --------
    >>> import numpy as np
    >>> tilted = np.broadcast_to(0.1 * np.arange(4.0)[:, None], (4, 3))
    >>> slopes = np.broadcast_to([0.1, 0.0], (4, 3, 2))
    >>> term = InclinedTerm(tilted, slopes, (1.0, 1.0), Material(1.0, 0.0), (False, False))
    >>> bool((term.apply(np.ones((4, 3))) < 0).all())
    True
    """

    depth: Array
    slopes: Array
    cell: tuple[float, float]
    material: Material
    mirrored: Even
    single: bool = False

    @cached_property
    def _whole(self) -> tuple[int, int]:
        """Numbers of cells, those beyond planes of symmetry too."""
        nx, ny = self.depth.shape
        return nx * (1 + self.mirrored[0]), ny * (1 + self.mirrored[1])

    @cached_property
    def _table(self) -> Array:
        return curved_kernel.inclined_table(self._whole, self.cell, self.material)

    @cached_property
    def _own(self) -> Array:
        return curved_kernel.inclined_own(self.slopes, self.cell, self.material)

    @cached_property
    def _centred(self) -> Array:
        """Depths from the middle one: the three convolutions cancel the least."""
        return self.depth - (self.depth.max() + self.depth.min()) / 2

    @cached_property
    def _convolution(self) -> Convolution:
        spectrum = kernel_spectrum(self._table, (padded(self._whole[0]), padded(self._whole[1])))
        tally = Tally(self._whole[0] * self._whole[1])
        made = Convolution(spectrum, self.depth.shape, self.mirrored, tally, product=False)
        return made.rough() if self.single else made

    def apply(self, p: Array) -> Array:
        """Displacements (nx, ny) by pressures (nx, ny)."""
        f, T = self._centred, self._convolution.apply
        return f * (f * T(p) - 2 * T(f * p)) + T(f**2 * p) + self._own * p

    def among(self, cells: IntArray) -> Array:
        """Displacements (n, n) of cells (n,), numbered row by row, by unit forces on them and their mirror images."""
        f = self.depth.ravel()[cells]
        along = []
        for index, even in zip(np.divmod(cells, self.depth.shape[1]), self.mirrored, strict=True):
            # where it is mirrored, a cell's image is as far on the other side of the middle
            images = (index, -1 - index) if even else (index,)
            along.append([np.abs(index[:, None] - at) for at in images])
        table = sum(self._table[ix, iy] for ix in along[0] for iy in along[1])
        out = table * (f[:, None] - f) ** 2 + np.diag(self._own.ravel()[cells])
        return np.asarray(out / (self.cell[0] * self.cell[1]))

    def part(self, part: tuple[slice, slice]) -> InclinedTerm:
        """The same among the cells of a part."""
        return replace(self, depth=self.depth[part], slopes=self.slopes[part])

    def coarser(self) -> InclinedTerm:
        """The same on cells twice as large."""
        cell = (2 * self.cell[0], 2 * self.cell[1])
        return replace(self, depth=_means(self.depth), slopes=_means(self.slopes), cell=cell)

    def rough(self) -> InclinedTerm:
        """The same in single precision."""
        return replace(self, single=True)


def _means(values: NDArray) -> Array:
    """Means (mx, my, ...) of blocks of 2 x 2 cells (nx, ny, ...); at an odd end of the cells that there are."""
    for axis in (0, 1):
        starts = np.arange(0, values.shape[axis], 2)
        count = np.minimum(2, values.shape[axis] - starts)
        sums = np.add.reduceat(values, starts, axis=axis)
        values = sums / np.moveaxis(count.reshape(-1, *(1,) * (values.ndim - 1)), 0, axis)
    return np.asarray(values)
