"""Transforms in the arrays of another library, of the Python array API standard: on a graphics processor, for one.

What is needed of its module: `asarray`, `stack` and the extension `fft`, and arrays that give their memory by DLPack.
https://data-apis.org/array-api/latest/
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fecontact.common.errors import InputError, MissingPackageError

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
                "API standard, such as 'cupy' or 'array_api_compat.torch'."
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
