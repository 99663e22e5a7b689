"""Products of cell values with the compliance of a grid: convolutions by fast transforms, and what is added to them.

Convolution with a matrix of kernels, even or odd. Free surface: zero padding to twice the size makes the cyclic
convolution the linear one. The padding rows are never transformed forward and the padded results never backward
(pruning), and the second direction is done in strips that fit in cache. Each field is transformed once for all results
and each result once for all fields. Values symmetric about the middle of an axis are given by the half with positive
coordinate, nearest the middle first; cosine transforms replace complex ones, with half the work and memory per axis.

Products for corrections need less accuracy: `rough` works in single precision, with half the memory and time.

With d(k) the type-1 cosine transform of an even kernel, both the complex (n padded to 2 m) and the cosine transform
(type 2, n/2 padded to m) of a convolution are products with d(k).

Array operations release Python's lock, so that threads, as many as there are cores or as ``OMP_NUM_THREADS`` says, work
at the same time where each has arrays of its own.

Added to convolutions: a smooth term of low rank, what slopes of a curved surface add, and compliances of cells by
themselves.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import Any, TypeVar

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fecontact.analytic import curved_kernel
from fecontact.common.arrays import Array, IntArray
from fecontact.common.material import Material
from fecontact.halfspace.grid import Even, at_offsets, block_means

Item = TypeVar("Item")
Result = TypeVar("Result")


def default_threads() -> int:
    """Number of threads: ``OMP_NUM_THREADS`` if it is a positive number, else the cores that this process may use.

    Examples
    --------
    >>> default_threads() >= 1
    True
    """
    asked = os.environ.get("OMP_NUM_THREADS", "").partition(",")[0].strip()
    if asked.isdecimal() and int(asked) > 0:
        return int(asked)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def each(function: Callable[[Item], Result], items: Sequence[Item], threads: int | None = None) -> list[Result]:
    """Results of a function of each item, in order; items are taken by several threads.

    Parameters
    ----------
    function : callable
        Safe to be called from several threads at once; it must not call `each` itself.
    items : sequence
    threads : int, optional
        `default_threads` unless given. With one, or a single item, the function is called here.

    Examples
    --------
    >>> each(lambda n: n * n, [1, 2, 3], threads=2)
    [1, 4, 9]
    """
    if len(items) > 1:
        threads = min(default_threads() if threads is None else threads, len(items))
        if threads > 1:
            return list(_pool(threads).map(function, items))
    return list(map(function, items))


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """Threads kept for the next call."""
    return ThreadPoolExecutor(threads, "fecontact")


Shape = tuple[int, int]
Transform = Callable[[NDArray], NDArray]

#: Numbers per strip of rows or columns: 1 to 2 MB.
STRIP = 1 << 17

#: Lengths up to which transforms in double precision are products with their matrices: calls of others take longer than
#: their work. In single precision pressures would differ by 1e-8 with the order in which processors add.
SHORT = 40

#: Numbers side by side to whose multiples strips of columns are rounded.
CACHE_LINE = 8

#: Error of a product in single precision relative to its largest value: some ten roundings of 6e-8, with a margin.
ROUGHNESS = 2e-6


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
    threads = default_threads() if full.size > STRIP else 1
    return np.asarray(scipy.fft.dctn(full, type=1, overwrite_x=True, workers=threads))


Kernels = tuple[tuple[NDArray | None, ...], ...]


@dataclass(frozen=True, eq=False)
class Convolution:
    """Products of fields of cell values with a matrix of kernels, even or odd.

    Parameters
    ----------
    kernels : j tuples of k arrays, or None for zero
        Spectra of the kernels with periods mx and my in rows of my // 2 + 1: real transforms, real for kernels of one
        parity in both directions, else complex. All mx rows, or of a kernel that is even along x the first mx // 2 + 1.
    shape : (int, int)
        Shape of the fields; of the half along a symmetric axis.
    lengths : (int, int)
        Lengths of the transforms: mx and my, half of them along a symmetric axis.
    symmetric : (bool, bool)
        Axes along which the values are symmetric, for one even kernel.
    tally : Tally, optional
    product : bool
        Whether to count its use as a product with a compliance.
    workers : int, optional
        Threads, see `each`.
    factor : float
        Factor of the results.

    Examples
    --------
    >>> import numpy as np
    >>> even, odd = np.array([[2.0, 1.0, 0.0, 1.0]]), np.array([[0.0, 1.0, 0.0, -1.0]])
    >>> kernels = ((np.fft.rfft2(even).real, np.fft.rfft2(odd)), (None, np.fft.rfft2(even).real))
    >>> Convolution(kernels, (1, 2), (1, 4)).apply(np.array([[[1.0, 0.0]], [[0.0, 1.0]]])).round(12).tolist()
    [[[1.0, 1.0]], [[1.0, 2.0]]]
    """

    kernels: Kernels
    shape: Shape
    lengths: Shape
    symmetric: tuple[bool, bool] = (False, False)
    tally: Tally | None = None
    product: bool = True
    workers: int | None = None
    factor: float = 1.0

    @classmethod
    def even(
        cls,
        spectrum: Array,
        shape: Shape,
        symmetric: tuple[bool, bool] = (False, False),
        tally: Tally | None = None,
        **options: Any,
    ) -> Convolution:
        """Product with one even kernel, of a spectrum (mx // 2 + 1, my // 2 + 1), see `kernel_spectrum`.

        Examples
        --------
        >>> import numpy as np
        >>> free = Convolution.even(kernel_spectrum(np.array([[2.0, 1.0, 0.5]]), (1, 3)), (1, 3))
        >>> free.apply(np.array([[1.0, 0.0, 1.0]])).round(12).tolist()
        [[2.5, 2.0, 2.5]]
        >>> half = Convolution.even(kernel_spectrum(np.array([[2.0, 1.0, 0.5, 0.25]]), (1, 4)), (1, 2), (False, True))
        >>> half.apply(np.array([[1.0, 0.0]])).round(12).tolist()
        [[3.0, 1.5]]
        """
        x, y = ((m - 1) * (1 if mirrored else 2) for m, mirrored in zip(spectrum.shape, symmetric, strict=True))
        return cls(((spectrum,),), shape, (x, y), symmetric, tally, **options)

    @classmethod
    def of_grid(
        cls, kernel: Array, periodic: bool, shape: Shape, symmetric: Even = (False, False), tally: Tally | None = None,
        workers: int | None = None,
    ) -> Convolution:  # fmt: skip
        """Product among cells (nx, ny): of a periodic grid by its spectrum, else by a table of offsets, padded."""
        if not periodic:
            x, y = (n * (1 + mirrored) for n, mirrored in zip(shape, symmetric, strict=True))
            kernel = kernel_spectrum(kernel[:x, :y], (padded(x), padded(y)))
        return cls.even(kernel, shape, symmetric, tally, workers=workers)

    @cached_property
    def rough(self) -> Convolution:
        """The same in single precision, with relative errors of `ROUGHNESS` in any units."""
        if max(self.lengths) <= SHORT:  # a product with matrices takes no longer in double precision
            return self
        given = [kernel for row in self.kernels for kernel in row if kernel is not None]
        factor = max((float(np.abs(kernel).max()) for kernel in given), default=1.0) or 1.0
        kernels = tuple(tuple(_single(k, factor) for k in row) for row in self.kernels)
        return replace(self, kernels=kernels, factor=self.factor * factor)

    @cached_property
    def _is_single(self) -> bool:
        return any(k is not None and k.dtype in (np.float32, np.complex64) for row in self.kernels for k in row)

    def among(self, x: IntArray, y: IntArray) -> list[list[Array | None]]:
        """Each kernel at the offsets (n, n) between cells (n,) of places x and y; None for zero."""
        at = tuple((k[:, None] - k) % n for k, n in zip((x, y), self.lengths, strict=True))
        tables = ([None if k is None else scipy.fft.irfft2(k, s=self.lengths) for k in row] for row in self.kernels)
        return [[None if table is None else table[at] for table in row] for row in tables]

    def apply(self, values: Array, out: Array | None = None) -> Array:
        """Results (j, nx, ny) of fields (k, nx, ny), in `out` if given; by one kernel also (nx, ny) of (nx, ny)."""
        lone = values.ndim == 2
        out = np.empty(values.shape if lone else (len(self.kernels), *self.shape)) if out is None else out
        fields, results = (values[None], out[None]) if lone else (values, out)
        if self.tally is not None:
            self.tally.add(self.lengths[0] * self.lengths[1], self.product)
        scale = 1.0
        if self._is_single:  # it has a narrow range: scale values to order one
            scale = max(float(values.max()), -float(values.min())) or 1.0
        given = [0] if lone else [k for k, field in enumerate(fields) if field.any()]
        made = [j for j, row in enumerate(self.kernels) if any(row[k] is not None for k in given)]
        if len(made) < len(results):
            out.fill(0.0)
        if made:
            self._transformed(fields, results, given, made, scale)
        return out

    def _transformed(self, fields: Array, results: Array, given: list[int], made: list[int], scale: float) -> None:
        """Results `made` of fields `given`, strip by strip."""
        (nx, ny), single = self.shape, self._is_single
        rows = self._kept_rows if len(fields) == len(results) == 1 else self._rows(max(len(fields), len(results)))
        (down, up), (forward, backward) = self._transforms

        def into_rows(strip: slice) -> None:
            for k in given:
                field = fields[k, strip]
                if single:
                    field = np.divide(field, scale, out=np.empty(field.shape, np.float32), casting="same_kind")
                rows[k, strip] = forward(field)

        def convolve(strip: slice) -> None:
            columns = {k: down(rows[k, :, strip]) for k in given}
            for j in made:
                pairs = [(kernel[:, strip], columns[k]) for k in given if (kernel := self.kernels[j][k]) is not None]
                total = _times(*pairs[0], in_place=len(made) == 1)
                for kernel, column in pairs[1:]:
                    total += _times(kernel, column)
                rows[j, :, strip] = up(total)[:nx]

        def out_of_rows(strip: slice) -> None:
            for j in made:
                np.multiply(backward(rows[j, strip])[:, :ny], scale * self.factor, out=results[j, strip], dtype=float)

        of_rows, of_columns = self._strips
        each(into_rows, of_rows, self.workers)
        each(convolve, of_columns, self.workers)
        each(out_of_rows, of_rows, self.workers)

    @cached_property
    def _strips(self) -> tuple[list[slice], list[slice]]:
        """Of rows, and of transformed columns."""
        (x, y), columns = self.lengths, self._rows(0).shape[2]
        return strips(self.shape[0], y), strips(columns, x, CACHE_LINE)

    def _rows(self, n: int) -> NDArray:
        """Transformed rows of n fields, to be filled."""
        real, wide = (np.float32, np.complex64) if self._is_single else (np.float64, np.complex128)
        nx, length = self.shape[0], self.lengths[1]
        return np.empty((n, nx, length), real) if self.symmetric[1] else np.empty((n, nx, length // 2 + 1), wide)

    @cached_property
    def _kept_rows(self) -> NDArray:
        """Those of one field, kept for the next product: new pages of memory take a tenth of its time."""
        return self._rows(1)

    @cached_property
    def _transforms(self) -> list[tuple[Transform, Transform]]:
        """Transforms along x and y, forwards and backwards, the latter in place."""
        out: list[tuple[Transform, Transform]] = []
        for axis, real in ((0, self.symmetric[1]), (1, True)):
            name, length = "dct" if self.symmetric[axis] else "rfft" if real else "fft", self.lengths[axis]
            if length <= SHORT and not self._is_single:
                out.append(_short(name, self.shape[axis], length, axis))
                continue
            forward, backward = getattr(scipy.fft, name), getattr(scipy.fft, f"i{name}")
            options = {"n": length, "axis": axis - 2}
            out.append((partial(forward, **options), partial(backward, overwrite_x=True, **options)))
        return out


@cache
def _short(name: str, n: int, length: int, axis: int) -> tuple[Transform, Transform]:
    """A short transform of n values along an axis, forwards and backwards, as products with its matrices."""
    back = getattr(scipy.fft, f"i{name}")
    there = getattr(scipy.fft, name)(np.eye(n), n=length)
    units = np.eye(there.shape[1])
    here = back(units, n=length)[:, :n]
    if name == "rfft":  # it is the real part of a product
        here = here - 1j * back(1j * units, n=length)[:, :n]
    forward: Transform = (lambda x: x @ there) if axis else (lambda x: there.T @ x)
    backward: Transform = (lambda x: x @ here) if axis else (lambda x: here.T @ x)
    return forward, (lambda x: backward(x).real) if name == "rfft" else backward


def _times(kernel: NDArray, spectrum: NDArray, in_place: bool = False) -> NDArray:
    """A spectrum times the rows of a kernel; where these are the first half, the others are their mirror images."""
    if kernel.shape == spectrum.shape:
        return np.asarray(np.multiply(spectrum, kernel, out=spectrum if in_place else None))
    out = spectrum if in_place else np.empty_like(spectrum)
    half = min(len(kernel), len(spectrum))
    np.multiply(spectrum[:half], kernel[:half, : spectrum.shape[1]], out=out[:half])
    if half < len(spectrum):
        np.multiply(spectrum[half:], kernel[half - 2 : 0 : -1], out=out[half:])
    return out


def _single(kernel: NDArray | None, factor: float) -> NDArray | None:
    """A kernel over a factor in single precision."""
    if kernel is None:
        return None
    return (kernel / factor).astype(np.complex64 if np.iscomplexobj(kernel) else np.float32)


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
        made = Convolution.of_grid(self._table, False, self.depth.shape, self.mirrored)
        return made.rough if self.single else made

    def apply(self, p: Array) -> Array:
        """Displacements (nx, ny) by pressures (nx, ny)."""
        f, T = self._centred, self._convolution.apply
        return f * (f * T(p) - 2 * T(f * p)) + T(f**2 * p) + self._own * p

    def among(self, cells: IntArray) -> Array:
        """Displacements (n, n) of cells (n,), numbered row by row, by unit forces on them and their mirror images."""
        f = self.depth.ravel()[cells]
        table = at_offsets(self._table, cells, self.depth.shape, self.mirrored)
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


@dataclass(frozen=True, eq=False)
class DiagonalTerm:
    """Displacements c p of cells under their own pressure p alone: springs on a surface, or what wears off in a step.

    Attributes
    ----------
    own : (nx, ny) array
        Compliances c, not negative.
    area : float
        Area of a cell.

    Examples
    --------
    >>> import numpy as np
    >>> DiagonalTerm(np.array([[2.0, 3.0]]), 1.0).apply(np.array([[1.0, 2.0]])).tolist()
    [[2.0, 6.0]]
    """

    own: Array
    area: float

    def apply(self, p: Array) -> Array:
        """Displacements (nx, ny) by pressures (nx, ny)."""
        return self.own * p

    def among(self, cells: IntArray) -> Array:
        """Displacements (n, n) of cells (n,), numbered row by row, by unit forces on them."""
        return np.diag(self.own.ravel()[cells]) / self.area

    def part(self, part: tuple[slice, slice]) -> DiagonalTerm:
        """The same among the cells of a part."""
        return replace(self, own=self.own[part])

    def coarser(self) -> DiagonalTerm:
        """The same on cells twice as large."""
        return replace(self, own=block_means(self.own), area=4 * self.area)

    @property
    def rough(self) -> DiagonalTerm:
        """Itself: its products take little time."""
        return self


#: What is added to a convolution.
Term = SmoothTerm | InclinedTerm | DiagonalTerm


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


#: What gives the displacements of cells by pressures on them.
Product = Convolution | Corrected


@dataclass(frozen=True, eq=False)
class DampedInverse:
    """Approximate inverse of a convolution and compliances c of cells by themselves, symmetric and positive definite.

    w K^-1 w + (1 - w^2)/(k + c) with w^2 = k/(k + c) and the compliance k of a cell: K^-1 where c is small, 1/c where
    it is large.

    Attributes
    ----------
    inverse : Convolution
        K^-1.
    share, rest : (nx, ny) arrays
        w, and (1 - w^2)/(k + c).
    """

    inverse: Convolution
    share: Array
    rest: Array

    @property
    def rough(self) -> DampedInverse:
        """The same with a convolution in single precision."""
        return replace(self, inverse=self.inverse.rough)

    def apply(self, values: Array, out: Array | None = None) -> Array:
        """Pressures (nx, ny) of displacements (nx, ny), in `out` if it is given."""
        out = self.inverse.apply(self.share * values, out)
        out *= self.share
        out += self.rest * values
        return out
