"""Convolution of cell values with an even kernel by fast transforms, with pruning and symmetry.

Free surface: zero padding to twice the size makes the cyclic convolution the linear one. The padding rows are never
transformed forward and the padded results never backward (pruning), and the second direction is done in strips that fit
in cache. Values symmetric about the middle of an axis are given by the half with positive coordinate, nearest the
middle first; cosine transforms replace complex ones, with half the work and memory per axis.

Products for corrections need less accuracy: `Convolution.rough` works in single precision, with half the memory and
time.

With d(k) the type-1 cosine transform of the even kernel, both the complex (n padded to 2 m) and the cosine transform
(type 2, n/2 padded to m) of a convolution are products with d(k).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fecontact.bodies.halfspace.array_module import array_module, convolved
from fecontact.common.arrays import Array
from fecontact.common.threads import each

Shape = tuple[int, int]
Transform = Callable[[NDArray], NDArray]

STRIP = 1 << 17
"""Numbers per strip of rows or columns: 1 to 2 MB."""

CACHE_LINE = 8
"""Numbers side by side to whose multiples strips of columns are rounded."""

ROUGHNESS = 2e-6
"""Error of a product in single precision relative to its largest value: some ten roundings of 6e-8, with a margin."""


@dataclass(eq=False)
class Tally:
    """Counts transforms, in units of one real transform of the padded whole grid.

    Attributes
    ----------
    unit : int
        Cells of the padded whole grid.
    transforms : float
        Forward and backward transforms, weighted by their size.
    products : int
        Products with a compliance, of any size.
    """

    unit: int
    transforms: float = 0.0
    products: int = 0

    def add(self, cells: int, product: bool) -> None:
        """Count one forward and one backward transform of real arrays with that many cells."""
        self.transforms += 2 * cells / self.unit
        self.products += product


def strips(n: int, length: int, multiple: int = 1) -> list[slice]:
    """Slices of n lines of a length, each of about `STRIP` numbers, in multiples of lines.

    Examples
    --------
    >>> strips(5, STRIP // 2)
    [slice(0, 2, None), slice(2, 4, None), slice(4, 5, None)]
    """
    width = max(1, STRIP // length // multiple) * multiple
    return [slice(first, min(first + width, n)) for first in range(0, n, width)]


def padded(n: int) -> int:
    """Half the length of a fast transform in which n cells do not interact with their periodic images."""
    return int(scipy.fft.next_fast_len(n, real=True))


def kernel_spectrum(table: Array, lengths: Shape) -> Array:
    """Spectrum (lengths + 1) of the even, periodic kernel of period 2 lengths with values `table` at offsets 0, 1, ...

    Examples
    --------
    >>> import numpy as np
    >>> kernel_spectrum(np.array([[2.0, 1.0]]), (1, 2)).tolist()
    [[4.0, 2.0, 0.0], [4.0, 2.0, 0.0]]
    """
    full = np.zeros((lengths[0] + 1, lengths[1] + 1))
    rows, columns = min(table.shape[0], len(full)), min(table.shape[1], full.shape[1])
    full[:rows, :columns] = table[:rows, :columns]
    return np.asarray(scipy.fft.dctn(full, type=1, overwrite_x=True))


@dataclass(frozen=True, eq=False)
class Convolution:
    """Product of cell values with an even kernel.

    Parameters
    ----------
    spectrum : (mx + 1, my + 1) array
        Spectrum of the kernel with periods 2 mx and 2 my, see `kernel_spectrum`.
    shape : (int, int)
        Shape of the arrays that `apply` takes; of the half along a symmetric axis.
    symmetric : (bool, bool)
        Axes along which the values are symmetric.
    tally : Tally
    product : bool
        Whether to count its use as a product with a compliance.
    workers : int, optional
        Threads, see `common.threads`.
    factor : float
        Factor of the products.
    arrays : str, optional
        Module whose arrays are transformed, see `array_module`; numpy's along axes of symmetry, for the standard of
        arrays has no cosine transforms.

    Examples
    --------
    >>> import numpy as np
    >>> table = np.array([[2.0, 1.0, 0.5]])
    >>> free = Convolution(kernel_spectrum(table, (1, 3)), (1, 3), (False, False), Tally(12))
    >>> free.apply(np.array([[1.0, 0.0, 1.0]])).round(12).tolist()
    [[2.5, 2.0, 2.5]]
    >>> half = Convolution(kernel_spectrum(np.array([[2.0, 1.0, 0.5, 0.25]]), (1, 4)), (1, 2), (False, True), Tally(16))
    >>> half.apply(np.array([[1.0, 0.0]])).round(12).tolist()
    [[3.0, 1.5]]
    """

    spectrum: Array
    shape: Shape
    symmetric: tuple[bool, bool]
    tally: Tally
    product: bool = True
    workers: int | None = None
    factor: float = 1.0
    arrays: str | None = None
    _lengths: Shape = field(init=False, repr=False)

    def __post_init__(self) -> None:
        half = (self.spectrum.shape[0] - 1, self.spectrum.shape[1] - 1)
        lengths = tuple(m if even else 2 * m for m, even in zip(half, self.symmetric, strict=True))
        object.__setattr__(self, "_lengths", lengths)

    def rough(self) -> Convolution:
        """The same in single precision, with relative errors of `ROUGHNESS` in any units."""
        largest = float(np.abs(self.spectrum).max())
        factor = largest if largest > 0 else 1.0
        return replace(self, spectrum=(self.spectrum / factor).astype(np.float32), factor=self.factor * factor)

    def apply(self, values: Array, out: Array | None = None) -> Array:
        """Convolution (nx, ny) of values (nx, ny), in `out` if it is given."""
        out = np.empty(values.shape) if out is None else out
        self.tally.add(self._lengths[0] * self._lengths[1], self.product)
        scale, single = 1.0, self.spectrum.dtype == np.float32
        if single:  # it has a narrow range: scale values to order one
            scale = max(float(values.max()), -float(values.min()))
            if scale == 0:
                out.fill(0.0)
                return out
        (nx, ny), length, rows = self.shape, self._lengths[1], self._rows
        forward, backward = self._transforms(self.symmetric[1], True, 1)

        if self.arrays is not None and not any(self.symmetric):
            scaled = (values / scale).astype(self.spectrum.dtype)[None]
            found = convolved(array_module(self.arrays), [[self._kernel]], scaled, self._lengths)[0]
            return np.multiply(found, scale * self.factor, out=out, dtype=float)

        def into_rows(strip: slice) -> None:
            given = values[strip]
            if single:
                given = np.divide(given, scale, out=np.empty(given.shape, np.float32), casting="same_kind")
            rows[strip] = forward(given)

        def out_of_rows(strip: slice) -> None:
            np.multiply(backward(rows[strip])[:, :ny], scale * self.factor, out=out[strip], dtype=float)

        each(into_rows, strips(nx, length), self.workers)
        self._columns(rows)
        each(out_of_rows, strips(nx, length), self.workers)
        return out

    @cached_property
    def _rows(self) -> NDArray:
        """Transformed rows, kept for the next product: new pages of memory take a tenth of its time."""
        single = self.spectrum.dtype == np.float32
        n, length = self.shape[0], self._lengths[1]
        if self.symmetric[1]:
            return np.empty((n, length), np.float32 if single else float)
        return np.empty((n, length // 2 + 1), np.complex64 if single else complex)

    @cached_property
    def _kernel(self) -> Any:
        """The spectrum of all waves along x, as an array of the module."""
        assert self.arrays is not None
        return array_module(self.arrays).asarray(np.concatenate([self.spectrum, self.spectrum[-2:0:-1]]))

    def _columns(self, rows: NDArray) -> None:
        """Transform the columns, multiply by the spectrum, transform back, strip by strip and in place."""
        n, length = self.shape[0], self._lengths[0]
        forward, backward = self._transforms(self.symmetric[0], np.isrealobj(rows), 0)
        half = self.spectrum.shape[0] - 1

        def convolve(strip: slice) -> None:
            columns = forward(rows[:, strip])
            factors = self.spectrum[:, strip]
            if len(columns) <= half + 1:
                columns *= factors[: len(columns), : columns.shape[1]]
            else:
                columns[: half + 1] *= factors
                columns[half + 1 :] *= factors[half - 1 : 0 : -1]
            rows[:, strip] = backward(columns)[:n]

        each(convolve, strips(rows.shape[1], length, CACHE_LINE), self.workers)

    def _transforms(self, even: bool, real: bool, axis: int) -> tuple[Transform, Transform]:
        """Transforms along an axis, forwards and backwards, the latter in place."""
        length = self._lengths[axis]
        names = ("dct", "idct") if even else ("rfft", "irfft") if real else ("fft", "ifft")
        forward, backward = (getattr(scipy.fft, name) for name in names)
        return partial(forward, n=length, axis=axis), partial(backward, n=length, axis=axis, overwrite_x=True)
