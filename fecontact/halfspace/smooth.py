"""Additions to the compliance of a grid: a smooth one of low rank, and what slopes of a curved surface add."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fecontact.analytic import curved_kernel
from fecontact.common.arrays import Array, IntArray
from fecontact.common.material import Material
from fecontact.halfspace.fft import Convolution, kernel_spectrum, padded
from fecontact.halfspace.grid import Even, block_means


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
        made = Convolution.even(spectrum, self.depth.shape, self.mirrored)
        return made.rough if self.single else made

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
        return replace(self, depth=block_means(self.depth), slopes=block_means(self.slopes), cell=cell)

    @property
    def rough(self) -> InclinedTerm:
        """The same in single precision."""
        return replace(self, single=True)


@dataclass(frozen=True, eq=False)
class SmoothTerm:
    """Displacements L R L^T f of cells by forces f on them, L = Lx (x) Ly.

    Attributes
    ----------
    along_x, along_y : (nx, kx) and (ny, ky) arrays
        Lx and Ly: interpolation from the nodes of either axis to the cells.
    core : (kx ky, kx ky) array
        R, symmetric: displacements of the nodes by unit forces at them.
    area : float
        Area of a cell.

    Examples
    --------
    >>> import numpy as np
    >>> term = SmoothTerm(np.ones((4, 1)), np.ones((2, 1)), np.array([[3.0]]), 0.5)
    >>> term.apply(np.full((4, 2), 0.25))[0].tolist()
    [3.0, 3.0]
    """

    along_x: Array
    along_y: Array
    core: Array
    area: float

    def apply(self, p: Array) -> Array:
        """Displacements (nx, ny) by pressures (nx, ny)."""
        return self.spread(self.core @ self.gathered(p))

    def gathered(self, p: Array) -> Array:
        """Forces (kx ky,) at the nodes that stand for pressures (nx, ny) on the cells."""
        return np.asarray((self.along_x.T @ p @ self.along_y).ravel() * self.area)

    def spread(self, values: Array) -> Array:
        """Values (kx ky,) at the nodes, interpolated to the cells (nx, ny)."""
        at_nodes = values.reshape(self.along_x.shape[1], self.along_y.shape[1])
        return np.asarray(self.along_x @ at_nodes @ self.along_y.T)

    @property
    def matrix(self) -> Array:
        """L (nx ny, kx ky)."""
        return np.asarray(np.kron(self.along_x, self.along_y))

    def among(self, cells: IntArray) -> Array:
        """Displacements (n, n) of cells (n,), numbered row by row, by unit forces on them."""
        x, y = np.divmod(cells, len(self.along_y))
        nodes = (self.along_x[x][:, :, None] * self.along_y[y][:, None, :]).reshape(len(cells), -1)
        return np.asarray(nodes @ self.core @ nodes.T)

    def part(self, part: tuple[slice, slice]) -> SmoothTerm:
        """The same among the cells of a part."""
        return replace(self, along_x=self.along_x[part[0]], along_y=self.along_y[part[1]])

    def coarser(self) -> SmoothTerm:
        """The same on cells twice as large."""
        along = (block_means(self.along_x, (0,)), block_means(self.along_y, (0,)))
        return replace(self, along_x=along[0], along_y=along[1], area=4 * self.area)

    @property
    def rough(self) -> SmoothTerm:
        """Itself: its products take little time."""
        return self


Term = SmoothTerm | InclinedTerm
"""What is added to a convolution."""


@dataclass(frozen=True, eq=False)
class Corrected:
    """A convolution and other terms.

    Attributes
    ----------
    convolution : Convolution
    terms : tuple of Term
    """

    convolution: Convolution
    terms: tuple[Term, ...]

    @property
    def rough(self) -> Corrected:
        """The same with convolutions in single precision."""
        return replace(self, convolution=self.convolution.rough, terms=tuple(term.rough for term in self.terms))

    def apply(self, values: Array, out: Array | None = None) -> Array:
        """Displacements (nx, ny) by pressures (nx, ny), in `out` if it is given."""
        out = self.convolution.apply(values, out)
        for term in self.terms:
            out += term.apply(values)
        return out


Product = Convolution | Corrected
"""What gives the displacements of cells by pressures on them."""
