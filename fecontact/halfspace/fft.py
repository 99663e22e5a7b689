"""Convolution of cell values with an even kernel by fast transforms, with pruning and symmetry.

Free surface: zero padding to twice the size makes the cyclic convolution the linear one. The padding rows are never
transformed forward and the padded results never backward (pruning), and the second direction is done in strips that fit
in cache. Values symmetric about the middle of an axis are given by the half with positive coordinate, nearest the
middle first; cosine transforms replace complex ones, with half the work and memory per axis.

Products for corrections need less accuracy: `Convolution.rough` works in single precision, with half the memory and
time.

With d(k) the type-1 cosine transform of the even kernel, both the complex (n padded to 2 m) and the cosine transform
(type 2, n/2 padded to m) of a convolution are products with d(k).

Convolution of several fields of cell values with a matrix of kernels, even or odd, by fast transforms.

Each field is transformed once for all results and each result once for all fields. As in `fft`, the padding rows are
never transformed, columns are done in strips that fit in cache, and corrections are done in single precision.

Transforms in the arrays of another library, of the Python array API standard: on a graphics processor, for one.

What is needed of its module: `asarray`, `stack` and the extension `fft`, and arrays that give their memory by DLPack.
https://data-apis.org/array-api/latest/
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from types import ModuleType
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError, MissingPackageError
from fecontact.common.threads import each

#: Functions that a module must have.
NEEDED = ("asarray", "stack", "fft.rfft", "fft.irfft", "fft.fft", "fft.ifft")


def array_module(name: str) -> ModuleType:
    """Import a module of arrays.

    Raises
    ------
    MissingPackageError
        If it is not installed.
    InputError
        If it has not what is needed.

    Examples
    --------
    >>> array_module("numpy").__name__
    'numpy'
    """
    try:
        module = importlib.import_module(name)
    except ImportError as error:
        raise MissingPackageError(
            f"Arrays of {name!r} need a package of that name, which cannot be imported ({error}). Install it, or leave "
            "arrays=None for numpy's."
        ) from error
    for needed in NEEDED:
        found: Any = module
        for part in needed.split("."):
            found = getattr(found, part, None)
        if found is None:
            raise InputError(
                f"The arrays of {name!r} cannot be used: the module has no {needed}. Give one that follows the array "
                "API standard, such as 'cupy' or 'array_api_compat.torch'.",
                code="incomplete-arrays",
            )
    return module


def convolved(
    module: ModuleType, kernels: Sequence[Sequence[Any]], values: NDArray, lengths: tuple[int, int]
) -> NDArray:
    """Results (j, nx, ny) of fields (k, nx, ny) by kernels, which are arrays of the module.

    Parameters
    ----------
    module : module
    kernels : j sequences of k arrays (mx, my // 2 + 1) of the module, or None for zero
    values : (k, nx, ny) array
        Of numpy.
    lengths : (int, int)
        mx and my.

    Examples
    --------
    >>> even = np.fft.rfft2([[2.0, 1.0, 0.0, 1.0]]).real
    >>> convolved(np, [[even]], np.array([[[1.0, 0.0]]]), (1, 4)).round(12).tolist()
    [[[2.0, 1.0]]]
    """
    _, nx, ny = values.shape
    fft = module.fft
    spectra = fft.fft(fft.rfft(module.asarray(values), n=lengths[1], axis=2), n=lengths[0], axis=1)
    results = []
    for row in kernels:
        terms = [kernel * spectra[k, :, :] for k, kernel in enumerate(row) if kernel is not None]
        total = terms[0]
        for term in terms[1:]:
            total = total + term
        rows = fft.ifft(total, axis=0)[:nx, :]
        results.append(fft.irfft(rows, n=lengths[1], axis=1)[:, :ny])
    return np.asarray(np.from_dlpack(module.stack(results), device="cpu"))


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


Kernels = tuple[tuple[NDArray | None, ...], ...]


@dataclass(frozen=True, eq=False)
class VectorConvolution:
    """Results (j, nx, ny) of fields (k, nx, ny).

    Parameters
    ----------
    kernels : j tuples of k arrays (mx, my // 2 + 1), or None for zero
        Real transforms of the kernels, of period mx, my: real if even, complex if odd.
    shape : (int, int)
        Numbers of cells.
    lengths : (int, int)
        mx and my.
    workers : int, optional
        Threads, see `common.threads`.
    factor : float
        Factor of the results.
    arrays : str, optional
        Module whose arrays are transformed, see `array_module`.

    Examples
    --------
    >>> import numpy as np
    >>> even, odd = np.array([[2.0, 1.0, 0.0, 1.0]]), np.array([[0.0, 1.0, 0.0, -1.0]])
    >>> kernels = ((np.fft.rfft2(even).real, np.fft.rfft2(odd)), (None, np.fft.rfft2(even).real))
    >>> VectorConvolution(kernels, (1, 2), (1, 4)).apply(np.array([[[1.0, 0.0]], [[0.0, 1.0]]])).round(12).tolist()
    [[[1.0, 1.0]], [[1.0, 2.0]]]
    """

    kernels: Kernels
    shape: Shape
    lengths: Shape
    workers: int | None = None
    factor: float = 1.0
    arrays: str | None = None

    @cached_property
    def rough(self) -> VectorConvolution:
        """The same in single precision, with relative errors of `fft.ROUGHNESS` in any units."""
        given = [kernel for row in self.kernels for kernel in row if kernel is not None]
        factor = max((float(np.abs(kernel).max()) for kernel in given), default=1.0) or 1.0
        return replace(
            self, kernels=tuple(tuple(_single(k, factor) for k in row) for row in self.kernels), factor=factor
        )

    def among(self, x: IntArray, y: IntArray) -> list[list[Array | None]]:
        """Each kernel at the offsets (n, n) between cells (n,) of places x and y; None for zero."""
        at = tuple((k[:, None] - k) % n for k, n in zip((x, y), self.lengths, strict=True))
        tables = ([None if k is None else scipy.fft.irfft2(k, s=self.lengths) for k in row] for row in self.kernels)
        return [[None if table is None else table[at] for table in row] for row in tables]

    @property
    def _single(self) -> bool:
        return any(k is not None and k.dtype in (np.float32, np.complex64) for row in self.kernels for k in row)

    @cached_property
    def _there(self) -> list[list[Any]]:
        """The kernels as arrays of the module."""
        assert self.arrays is not None
        asarray = array_module(self.arrays).asarray
        return [[None if kernel is None else asarray(kernel) for kernel in row] for row in self.kernels]

    def apply(self, values: Array) -> Array:
        """Results (j, nx, ny) of values (k, nx, ny)."""
        scale = max(float(values.max(initial=0.0)), -float(values.min(initial=0.0)))
        out = np.zeros((len(self.kernels), *self.shape))
        if scale == 0:
            return out
        given = [k for k, field in enumerate(values) if field.any()]
        made = [j for j, row in enumerate(self.kernels) if any(row[k] is not None for k in given)]
        (nx, ny), length = self.shape, self.lengths[1]
        real, kind = (np.float32, np.complex64) if self._single else (float, complex)
        if self.arrays is not None:
            scaled_all = (values / scale).astype(real)
            found = convolved(array_module(self.arrays), [self._there[j] for j in made], scaled_all, self.lengths)
            out[made] = scale * self.factor * found
            return out
        rows = np.empty((max(len(self.kernels), len(values)), nx, length // 2 + 1), kind)

        def into_rows(strip: slice) -> None:
            for k in given:
                scaled = np.divide(
                    values[k, strip], scale, out=np.empty(values[k, strip].shape, real), casting="same_kind"
                )
                rows[k, strip] = scipy.fft.rfft(scaled, n=length, axis=1)

        def convolve(strip: slice) -> None:
            columns = {k: scipy.fft.fft(rows[k, :, strip], n=self.lengths[0], axis=0) for k in given}
            for j in made:
                pairs = ((kernel, columns[k]) for k, kernel in enumerate(self.kernels[j]) if k in given)
                total = sum(kernel[:, strip] * column for kernel, column in pairs if kernel is not None)
                rows[j, :, strip] = scipy.fft.ifft(total, axis=0, overwrite_x=True)[:nx]

        def out_of_rows(strip: slice) -> None:
            for j in made:
                back = scipy.fft.irfft(rows[j, strip], n=length, axis=1, overwrite_x=True)
                np.multiply(back[:, :ny], scale * self.factor, out=out[j, strip], dtype=float)

        each(into_rows, strips(nx, length), self.workers)
        each(convolve, strips(rows.shape[2], self.lengths[0], CACHE_LINE), self.workers)
        each(out_of_rows, strips(nx, length), self.workers)
        return out


def _single(kernel: NDArray | None, factor: float) -> NDArray | None:
    """A kernel over a factor in single precision."""
    if kernel is None:
        return None
    return (kernel / factor).astype(np.complex64 if np.iscomplexobj(kernel) else np.float32)
