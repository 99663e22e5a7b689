"""Motion files of OpenSim (.mot, .sto): a head up to ``endheader``, names of columns, rows of numbers.

Files of results of OpenSim-JAM (.h5) have a data set for each figure over the time.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.common.arguments import file_path, text
from fecontact.common.arrays import Array
from fecontact.common.checks import number_array
from fecontact.common.errors import InputError, optional

#: Names of the counts in the head, with and without an equals sign.
_COUNTS = {"nrows": "rows", "datarows": "rows", "ncolumns": "columns", "datacolumns": "columns"}
#: Largest size of a file, bytes; a motion of an hour at 100 Hz with 100 columns takes half of it.
LARGEST = 500_000_000


@dataclass(frozen=True, eq=False)
class Motion:
    """Columns of a motion file over time.

    Attributes
    ----------
    times : (n,) array
        Increasing.
    names : tuple of str
        Of the columns, without the time.
    values : (n, n_names) array
    in_degrees : bool
        Whether angles are in degrees; otherwise in radians. Columns of lengths or forces are neither.
    """

    times: Array
    names: tuple[str, ...]
    values: Array
    in_degrees: bool

    def column(self, name: str) -> Array:
        """Values (n,) of a column; a minus before its name turns their sign.

        Raises
        ------
        InputError
            If there is no such column.
        """
        bare = text("the name of a column", name).removeprefix("-")
        if bare not in self.names:
            raise InputError(f"The motion has no column {bare!r}. Its columns are: {', '.join(self.names)}.")
        values = self.values[:, self.names.index(bare)]
        return -values if name.startswith("-") else values

    def vector(self, name: str) -> Array:
        """Values (n, 3) of the columns name.x, name.y and name.z.

        Raises
        ------
        InputError
            If one is missing.
        """
        return np.stack([self.column(f"{name}.{axis}") for axis in "xyz"], axis=1)

    def angle(self, name: str) -> Array:
        """Values (n,) of a column of angles in degrees, see `column`."""
        return self.column(name) if self.in_degrees else np.degrees(self.column(name))

    def at(self, times: Array) -> Motion:
        """The motion at other times (k,), by linear interpolation.

        Raises
        ------
        InputError
            For times outside those of the motion.
        """
        wanted = number_array("the times of a motion", times).ravel()
        first, last = self.times[[0, -1]]
        if not ((wanted >= first) & (wanted <= last)).all():
            raise InputError(f"The motion lasts from {first:g} to {last:g}; found times outside, or that are no times.")
        values = np.stack([np.interp(wanted, self.times, column) for column in self.values.T], axis=1)
        return replace(self, times=wanted, values=values)

    def __repr__(self) -> str:
        shown = ", ".join(self.names[:6]) + (", ..." if len(self.names) > 6 else "")
        return f"Motion({len(self.times)} times from {self.times[0]:g} to {self.times[-1]:g}: {shown})"


def read_motion(path: str | Path) -> Motion:
    r"""Read a motion file of OpenSim, or a file of results of OpenSim-JAM.

    Parameters
    ----------
    path : str or Path
        A ``.mot`` or ``.sto`` file; its first column is ``time``. Or an ``.h5`` file of JAM, whose coordinates are in
        degrees: a column for each row of numbers over time, by its path in the file, three for each of vectors.

    Raises
    ------
    InputError
        If the file cannot be read, or is no such file; the message names the line.
    MissingPackageError
        For an ``.h5`` file, if h5py is not installed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> lines = "walk", "nRows=2", "nColumns=2", "inDegrees=yes", "endheader", "time knee_angle_r", "0 5", "0.1 12"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "walk.mot"
    ...     _ = path.write_text("\n".join(lines))
    ...     read_motion(path).at([0.05]).angle("knee_angle_r")
    array([8.5])
    """
    path = file_path("the file of a motion", path)
    if path.suffix.lower() == ".h5":
        return _of_jam(path)
    try:
        if path.is_file() and path.stat().st_size > LARGEST:
            raise InputError(f"{path} has more than {LARGEST // 10**6} MB: cut the motion to what is needed.")
        lines = path.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    except OSError as error:
        raise InputError(f"The motion {path} cannot be read: {error.strerror or error}.", code="unreadable") from error
    end = next((k for k, line in enumerate(lines) if line.strip().lower() == "endheader"), None)
    if end is None:
        raise InputError(f"{path} is no motion file of OpenSim: it has no line 'endheader'.", code="no-endheader")
    counts, in_degrees = _head(path, lines[:end])
    body = [(k, line.split()) for k, line in enumerate(lines[end + 1 :], start=end + 2) if line.strip()]
    if len(body) < 2:
        raise InputError(f"{path} has no rows after its head and the names of its columns.", code="no-rows")
    names = body[0][1]
    if names[0].lower() != "time":
        raise InputError(f"{path}, line {body[0][0]}: the first column must be 'time'; found {names[0]!r}.")
    if twice := sorted({n for n in names if names.count(n) > 1}):
        raise InputError(f"{path}, line {body[0][0]}: columns occur twice: {', '.join(twice)}.", code="columns-twice")
    table = np.array([_row(path, k, words, len(names)) for k, words in body[1:]])
    for what, found in (("rows", len(table)), ("columns", len(names))):
        if counts.get(what, found) != found:
            raise InputError(f"{path} has {found} {what}, and its head tells of {counts[what]}: it may be cut off.")
    late = np.flatnonzero(np.diff(table[:, 0]) <= 0)
    if len(late):
        raise InputError(f"{path}, line {body[late[0] + 2][0]}: the time {table[late[0] + 1, 0]:g} does not increase.")
    return Motion(table[:, 0], tuple(names[1:]), table[:, 1:], in_degrees)


def _of_jam(path: Path) -> Motion:
    """The motion of a file of results of OpenSim-JAM."""
    h5py = optional("h5py", "A file of results of OpenSim-JAM", "'fecontact[xdmf]'")
    found: dict[str, Array] = {}

    def add(name: str, item: Any) -> None:
        if getattr(item, "ndim", 0) in (1, 2):  # a group has none
            found[name] = np.asarray(item)

    try:
        with h5py.File(path) as file:
            file.visititems(add)
    except OSError as error:
        raise InputError(f"The results {path} cannot be read: {error}.", code="unreadable") from error
    times = found.pop("time", np.zeros(0))
    if times.ndim != 1 or not len(times) or not (np.diff(times) > 0).all():
        raise InputError(
            f"{path} is no file of results of OpenSim-JAM: it has no increasing 'time'.", code="no-results"
        )
    columns: dict[str, Array] = {}
    for name, values in found.items():
        if values.dtype.kind == "f" and len(values) == len(times) and np.isfinite(values).all():
            if values.ndim == 1:
                columns[name] = values
            elif values.shape[1] == 3:
                columns |= {f"{name}.{axis}": part for axis, part in zip("xyz", values.T, strict=True)}
    return Motion(times.astype(float), tuple(columns), np.stack([*columns.values()], axis=1).astype(float), True)


def _head(path: Path, lines: list[str]) -> tuple[dict[str, int], bool]:
    """Numbers of rows and columns as far as the head tells them, and whether angles are in degrees."""
    counts: dict[str, int] = {}
    in_degrees = False
    for k, line in enumerate(lines, start=1):
        key, _, value = line.replace("=", " ").strip().partition(" ")
        value = value.strip().lower()
        if key.lower() == "indegrees":
            if value not in ("yes", "no"):
                raise InputError(f"{path}, line {k}: inDegrees must be yes or no; found {value!r}.", code="in-degrees")
            in_degrees = value == "yes"
        elif key.lower() in _COUNTS:
            if not value.isdecimal():
                raise InputError(f"{path}, line {k}: {key} must be a number; found {value!r}.", code="not-a-number")
            counts[_COUNTS[key.lower()]] = int(value[:18])
    return counts, in_degrees


def _row(path: Path, line: int, words: list[str], count: int) -> list[float]:
    """Numbers of one line."""
    if len(words) != count:
        raise InputError(f"{path}, line {line}: {len(words)} values for {count} columns.", code="row-length")
    try:
        row = [float(word) for word in words]
    except ValueError:
        raise InputError(f"{path}, line {line}: a value is no number.", code="not-a-number") from None
    if not np.isfinite(row).all():
        raise InputError(f"{path}, line {line}: a value is not finite.", code="not-finite")
    return row
