"""Convolution of several fields of cell values with a matrix of kernels, even or odd, by fast transforms.

Each field is transformed once for all results and each result once for all fields. As in `fft`, the padding rows are
never transformed, columns are done in strips that fit in cache, and corrections are done in single precision.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fecontact.bodies.halfspace.array_module import array_module, convolved
from fecontact.bodies.halfspace.fft import CACHE_LINE, Shape, strips
from fecontact.common.arrays import Array
from fecontact.common.threads import each

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
