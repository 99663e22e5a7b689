"""Smooth addition to the compliance of a grid, of low rank: interpolated between a few nodes along each axis."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.halfspace.fft import Convolution
from fecontact.halfspace.inclined import InclinedTerm


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
        along = (_pairs(self.along_x), _pairs(self.along_y))
        return replace(self, along_x=along[0], along_y=along[1], area=4 * self.area)

    def rough(self) -> SmoothTerm:
        """Itself: its products take little time."""
        return self


def _pairs(rows: Array) -> Array:
    """Means of rows 0 and 1, 2 and 3, ...; the last one alone if their number is odd."""
    starts = np.arange(0, len(rows), 2)
    count = np.minimum(2, len(rows) - starts)
    return np.asarray(np.add.reduceat(rows, starts, axis=0) / count[:, None])


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

    def rough(self) -> Corrected:
        """The same with convolutions in single precision."""
        return replace(self, convolution=self.convolution.rough(), terms=tuple(term.rough() for term in self.terms))

    def apply(self, values: Array, out: Array | None = None) -> Array:
        """Displacements (nx, ny) by pressures (nx, ny), in `out` if it is given."""
        out = self.convolution.apply(values, out)
        for term in self.terms:
            out += term.apply(values)
        return out


Product = Convolution | Corrected
"""What gives the displacements of cells by pressures on them."""
