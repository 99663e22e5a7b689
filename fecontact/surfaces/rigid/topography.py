"""Reading measured topographies: npy, columns x y z, matrices of heights, and Esri/SPIP style asc grids."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from tokenize import TokenError

import numpy as np

from fecontact.common.arguments import file_path
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import number_array, positive, positives
from fecontact.common.errors import InputError

READABLE = (".npy", ".txt", ".csv", ".xyz", ".asc")

STEEPEST = 3.0
"""Rms slope above which heights are taken to be in another unit than the sides, unless their unit is given."""


@dataclass(frozen=True, eq=False)
class Topography:
    """Heights on a grid.

    Attributes
    ----------
    z : (nx, ny) array
        Along x first; holes are NaN.
    size : (float, float) or None
        Sides of the grid, if the file gives them.
    """

    z: Array
    size: tuple[float, float] | None


def read_topography(path: str | Path, unit: float | None = None, size: tuple[float, float] | None = None) -> Topography:
    r"""Read a topography; the suffix decides.

    The formats do not say the unit of heights, which is often another one than that of lengths. No unit is guessed.

    ========================  ==================================================================================
    ``.npy``                  array (nx, ny)
    ``.xyz``                  columns x, y, z of a full rectangular grid, any order
    ``.txt``, ``.csv``        a matrix, one line for each y (upwards)
    ``.asc``                  ``ncols``, ``nrows``, ``cellsize`` ... and the lines from the largest y down
    ========================  ==================================================================================

    Parameters
    ----------
    path : str or Path
    unit : float, optional
        Unit of the file's heights in that of lengths, such as 1e-6 for nanometres beside millimetres. Without it they
        are taken to be the same, and steep surfaces of a known size are refused.
    size : (float, float), optional
        Sides of the grid; those of the file unless given.

    Returns
    -------
    Topography

    Raises
    ------
    InputError
        For an unknown suffix, a missing file, contents that do not fit the suffix, or heights that seem to be in
        another unit.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder) / "step.txt"
    ...     _ = file.write_text("0 1 2\n3 4 5\n")
    ...     read_topography(file).z.tolist()
    [[0.0, 3.0], [1.0, 4.0], [2.0, 5.0]]
    """
    file = file_path("the path of a topography", path)
    suffix = file.suffix.lower()
    if suffix not in READABLE:
        raise InputError(f"Cannot read a topography from {file.name!r}; known are {', '.join(READABLE)}.")
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}.", code="no-file")
    try:
        if suffix == ".npy":
            out = Topography(number_array("the heights", np.load(file, allow_pickle=False, mmap_mode="r")), None)
        elif suffix == ".asc":
            out = _asc(file.read_text())
        else:
            table = np.loadtxt(file, delimiter="," if suffix == ".csv" else None, ndmin=2)
            out = _columns(table) if suffix == ".xyz" else Topography(np.ascontiguousarray(table.T), None)
    except (ValueError, KeyError, OSError, OverflowError, MemoryError, EOFError, SyntaxError, TokenError) as error:
        raise InputError(f"{file.name!r} is not a readable {suffix} topography: {error}", code="unreadable") from error
    if out.z.ndim != 2 or min(out.z.shape) < 2:
        raise InputError(f"{file.name!r} holds no grid of at least 2 x 2 heights; found shape {out.z.shape}.")
    if size is not None:
        x, y = positives("a topography's size", size, 2)
        out = replace(out, size=(x, y))
    if unit is not None:
        return replace(out, z=positive("the unit of the heights", unit) * out.z)
    if out.size is not None:
        _check_unit(out.z, out.size, file.name)
    return out


def _check_unit(z: Array, size: tuple[float, float], name: str) -> None:
    """Refuse heights (nx, ny) whose slopes say that they are in another unit than the sides of their grid."""
    squares = 0.0
    with np.errstate(invalid="ignore", over="ignore"):  # heights may be infinite, beside each other too
        for axis, (n, side) in enumerate(zip(z.shape, size, strict=True)):
            slopes = np.diff(z, axis=axis) * (n / side)
            kept = slopes[np.isfinite(slopes)]
            squares += float((kept**2).mean()) if len(kept) else 0.0
    if (slope := math.sqrt(squares)) > STEEPEST:
        raise InputError(
            f"The heights in {name!r} rise by {slope:.3g} per length (rms): they seem to be in another unit than the "
            f"sides {size[0]:g} x {size[1]:g}. Give their unit in that of lengths (unit=, --height-unit), such as "
            "1e-6 for nanometres beside millimetres, or 1 if they are as steep.",
            code="heights-unit",
        )


def _columns(table: Array) -> Topography:
    """Points x, y, z in any order on a full rectangular grid of equal steps."""
    if table.shape[1] != 3:
        raise ValueError(f"expected three columns, found {table.shape[1]}")
    axes, numbers = [], []
    for column in table[:, :2].T:
        order = np.sort(column)
        tolerance = 1e-6 * max(np.ptp(order), 1e-300)
        starts = np.concatenate([[True], np.diff(order) > tolerance])
        values = order[starts]
        steps = np.diff(values)
        if len(values) < 2 or np.ptp(steps) > 1e-3 * steps.mean():
            raise ValueError("the points do not lie on a grid of equal steps")
        axes.append(values)
        numbers.append(_nearest(column, values))
    shape = (len(axes[0]), len(axes[1]))
    if len(table) != shape[0] * shape[1] or len(np.unique(numbers[0] * shape[1] + numbers[1])) != len(table):
        raise ValueError(f"{len(table)} points are no full grid of {shape[0]} x {shape[1]}")
    z = np.empty(shape)
    z[numbers[0], numbers[1]] = table[:, 2]
    size = tuple(float(np.ptp(a)) * len(a) / (len(a) - 1) for a in axes)
    return Topography(z, (size[0], size[1]))


def _nearest(column: Array, values: Array) -> IntArray:
    return np.rint((column - values[0]) / (values[-1] - values[0]) * (len(values) - 1)).astype(np.int64)


def _asc(text: str) -> Topography:
    """Esri ASCII grid: header of names and numbers, then rows from the top; NODATA_value marks holes."""
    header: dict[str, float] = {}
    lines = text.splitlines()
    for line in lines:
        words = line.split()
        if len(words) != 2 or not words[0][0].isalpha():
            break
        header[words[0].lower()] = float(words[1])
    if missing := {"ncols", "nrows", "cellsize"} - header.keys():
        raise ValueError(f"the header lacks {', '.join(sorted(missing))}")
    columns, rows, cell = int(header["ncols"]), int(header["nrows"]), header["cellsize"]
    values = np.array(" ".join(lines[len(header) :]).split(), dtype=float)
    if values.size != columns * rows:
        raise ValueError(f"expected {rows} x {columns} heights, found {values.size}")
    values[values == header.get("nodata_value", np.nan)] = np.nan
    return Topography(np.ascontiguousarray(values.reshape(rows, columns)[::-1].T), (columns * cell, rows * cell))
