"""Files: paths checked before long work, atomic writes, one writer at a time."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from fecontact.common.arguments import file_path
from fecontact.common.errors import InputError


def check_writable(path: str | Path) -> Path:
    """Refuse a path that cannot be written, before long work.

    Raises
    ------
    InputError
        If the folder does not exist, is no folder, or the file cannot be written.
    """
    path = file_path("the path of a file to write", path)
    folder = path.parent
    if not folder.is_dir():
        raise InputError(
            f"Cannot write {path}: the folder {folder} does not exist. Make it first or choose another path."
        )
    if path.is_dir():
        raise InputError(f"Cannot write {path}: it is a folder.")
    target = path if path.exists() else folder
    if not os.access(target, os.W_OK):
        raise InputError(f"Cannot write {path}: no permission for {target}.")
    return path


def make_folder(path: str | Path) -> Path:
    """A folder, made if it is missing.

    Raises
    ------
    InputError
        If it cannot be made.
    """
    path = file_path("the path of a folder", path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"Cannot make the folder {path}: {error.strerror}.") from error
    return path


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Path of a temporary file, with the same suffix, that replaces `path` at the end.

    An interruption, an error or a full disk leaves an old file as it was. A pipe or a device is written to directly.

    Raises
    ------
    InputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with replacing(Path(folder) / "figures.txt") as file:
    ...         _ = file.write_text("1 2 3")
    ...     (Path(folder) / "figures.txt").read_text()
    '1 2 3'
    """
    path = check_writable(path)
    special = path.exists() and not path.is_file()
    partial = path if special else path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        yield partial
        if not special:
            partial.replace(path)
    except OSError as error:
        kept = " The file that was there is unchanged." if path.is_file() else ""
        raise InputError(f"Cannot write {path}: {error.strerror or error}.{kept}") from error
    finally:
        if not special:
            partial.unlink(missing_ok=True)


def write_atomically(path: str | Path, text: str) -> Path:
    """Write a text file that replaces an old one at the end, see `replacing`."""
    with replacing(path) as file:
        file.write_text(text, encoding="utf-8")
    return Path(path)


def save_rows(path: str | Path, columns: Sequence[str], rows: Iterable[Iterable[float]]) -> Path:
    """Write rows of numbers below the names of their columns as CSV; numbers read back are the same."""
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows)]
    return write_atomically(path, "\n".join([*lines, ""]))


def csv_name(name: str) -> str:
    """A name given by a user as a cell of CSV: behind an apostrophe where a spreadsheet would take it for a formula.

    Examples
    --------
    >>> csv_name("=1+1"), csv_name("gait 3")
    ("'=1+1", 'gait 3')
    """
    return f"'{name}" if name.startswith(("=", "+", "-", "@", "\t", "\r")) else name


@contextmanager
def sole_writer(path: str | Path) -> Iterator[None]:
    """Keep other processes from adding rows to the same file; a file beside it, with this process's number, says so.

    Raises
    ------
    InputError
        If another process that still runs is writing to it.
    """
    lock = Path(path).with_name(f".{Path(path).name}.lock")
    for _ in range(2):
        try:
            with lock.open("x", encoding="utf-8") as file:
                file.write(str(os.getpid()))
            break
        except FileExistsError:
            owner = _number_in(lock)
            if owner is not None and _runs(owner):
                raise InputError(
                    f"Process {owner} is writing to {path}. Wait for it, or choose another file; if it is no run of "
                    f"fecontact, remove {lock}."
                ) from None
            lock.unlink(missing_ok=True)  # left by a process that was stopped
    try:
        yield
    finally:
        lock.unlink(missing_ok=True)


def _number_in(lock: Path) -> int | None:
    try:
        return int(lock.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def _runs(process: int) -> bool:
    """Whether a process of this machine runs."""
    if process == os.getpid():
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True  # of another user
    return True


def save_json(path: str | Path, data: dict[str, Any]) -> Path:
    """Write a JSON file; numpy scalars and arrays become plain numbers and lists."""
    return write_atomically(path, json.dumps(data, indent=2, default=_plain) + "\n")


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} has no place in a JSON file")


def write_collection(path: Path, files: Sequence[Path], times: Sequence[float]) -> Path:
    """Write the PVD file that lists files, by their paths from it, with their times."""
    found = [Path(os.path.relpath(file, path.parent)).as_posix() for file in files]
    pairs = zip(found, times, strict=True)
    lines = [f'    <DataSet timestep="{time!r}" file={quoteattr(file)}/>' for file, time in pairs]
    head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
    return write_atomically(path, head + "\n".join(lines) + "\n  </Collection>\n</VTKFile>\n")
