"""Files: paths checked before long work, atomic writes, one writer at a time, and a list of what was written.

Figures written to files.

JSON-lines files: one finished row per line, so that an interrupted run can be resumed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal
from xml.sax.saxutils import quoteattr

import numpy as np

from fecontact.common.arguments import file_path
from fecontact.common.checks import among
from fecontact.common.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WRITTEN: ContextVar[dict[Path, int] | None] = ContextVar("files written", default=None)


@contextmanager
def written_files() -> Iterator[dict[Path, int]]:
    """Context: the files that its block has completed, and how many rows it has added to each; 0: a whole file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder, written_files() as files:
    ...     path = write_atomically(Path(folder) / "figures.txt", "1 2 3")
    ...     list(files) == [path]
    True
    """
    files: dict[Path, int] = {}
    token = _WRITTEN.set(files)
    try:
        yield files
    finally:
        _WRITTEN.reset(token)


def _note_written(path: Path, rows: int = 0) -> None:
    files = _WRITTEN.get()
    if files is not None:
        files[path] = files.get(path, 0) + rows


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
            f"Cannot write {path}: the folder {folder} does not exist. Make it first or choose another path.",
            code="no-folder",
        )
    if path.is_dir():
        raise InputError(f"Cannot write {path}: it is a folder.", code="is-a-folder")
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
            _note_written(path)
    except OSError as error:
        kept = " The file that was there is unchanged." if path.is_file() else ""
        raise InputError(f"Cannot write {path}: {error.strerror or error}.{kept}", code="cannot-write") from error
    finally:
        if not special:
            partial.unlink(missing_ok=True)


def write_atomically(path: str | Path, text: str) -> Path:
    """Write a text file that replaces an old one at the end, see `replacing`."""
    with replacing(path) as file:
        file.write_text(text, encoding="utf-8")
    return Path(path)


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
                    f"fecontact, remove {lock}.",
                    code="file-in-use",
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


def new_figure(size: tuple[float, float], layout: Literal["constrained", "compressed"] = "constrained") -> Figure:
    """An empty figure, its size in inches; matplotlib is imported here, as half a second is much for a solve alone."""
    from matplotlib.figure import Figure

    return Figure(figsize=size, layout=layout)


def save_figure(figure: Figure, path: str | Path | None) -> Figure:
    """Write a figure if a path is given.

    Raises
    ------
    InputError
        If the suffix is no format of pictures, or the file cannot be written.
    """
    if path is not None:
        with replacing(path) as file:
            known = figure.canvas.get_supported_filetypes()
            among("format of a picture", Path(path).suffix.removeprefix("."), known)
            # the last sixth of the size takes a third of the time
            small: Any = {"pil_kwargs": {"compress_level": 3}} if Path(path).suffix == ".png" else {}
            figure.savefig(file, dpi=150, bbox_inches="tight", **small)
    return figure


def read_rows(path: str | Path, key: str, what: str) -> dict[str, dict[str, Any]]:
    """Rows of an earlier run; an incomplete last line is removed from the file.

    Parameters
    ----------
    path : str or Path
        Need not exist yet.
    key : str
        Field that identifies a row; of two rows with the same value the later counts.
    what : str
        What a row is, for the message.

    Returns
    -------
    dict
        Rows by the value of `key`.

    Raises
    ------
    InputError
        If the file cannot be written, is no regular file, or a line is not a row with `key`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "rows.jsonl"
    ...     append_row(path, {"name": "a", "x": 1})
    ...     with path.open("a") as file:
    ...         _ = file.write('{"name": "b"')
    ...     read_rows(path, "name", "a row")
    {'a': {'name': 'a', 'x': 1}}
    """
    path = check_writable(path)
    if not path.exists():
        return {}
    if not path.is_file():
        raise InputError(f"{path} is a pipe or a device: rows are read from the file before others are added to it.")
    rows: dict[str, dict[str, Any]] = {}
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    for k, line in enumerate(lines):
        try:
            row = json.loads(line)
            rows[row[key]] = row
        except (json.JSONDecodeError, KeyError, TypeError) as error:
            if k == len(lines) - 1 and not line.endswith("\n"):
                write_atomically(path, "".join(lines[:-1]))
                return rows
            raise InputError(f"Line {k + 1} of {path} is not {what}; choose another file.", code="bad-line") from error
    if lines and not lines[-1].endswith("\n"):
        write_atomically(path, "".join(lines) + "\n")
    return rows


class Resumed:
    """Rows of a file of finished work: those of an earlier run, and new ones; a context in which others cannot write.

    Parameters
    ----------
    path : str, Path or None
        File of JSON lines, which need not exist yet; None: nothing is read or written.
    prints : mapping of str to mapping of str to str
        Fingerprints of each row by its name, by part.
    what : str
        What a row is, for messages.

    Attributes
    ----------
    rows : dict
        Finished rows by name.

    Raises
    ------
    InputError
        If a row of one of these names has other fingerprints, or none.
    """

    def __init__(self, path: str | Path | None, prints: Mapping[str, Mapping[str, str]], what: str) -> None:
        self.path, self.prints, self._lock = path, prints, ExitStack()
        found = {} if path is None else read_rows(path, "name", what)
        self.rows = {name: found[name] for name in prints if name in found}
        remedy = "Give another path, or delete that line of the file to have the case solved again."
        for name, row in self.rows.items():
            then, now = row.get("fingerprint"), prints[name]
            if not isinstance(then, dict):
                raise InputError(
                    f"The row {name!r} in {path} has no fingerprint (it was written by an earlier version or by hand), "
                    f"so that it cannot be told whether it is of this model and case. {remedy}",
                    code="no-fingerprint",
                )
            if other := sorted(k for k in {*then, *now} if then.get(k) != now.get(k)):
                raise InputError(
                    f"The row {name!r} in {path} is of another model or case ({', '.join(other)}). {remedy}",
                    code="row-of-another",
                )

    def add(self, name: str, row: Mapping[str, Any]) -> dict[str, Any]:
        """Keep the row of finished work, and write it."""
        self.rows[name] = {"name": name, **row, "fingerprint": self.prints[name]}
        if self.path is not None:
            append_row(self.path, self.rows[name])
        return self.rows[name]

    def __enter__(self) -> Resumed:
        if self.path is not None:
            self._lock.enter_context(sole_writer(self.path))
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.close()


def append_row(path: str | Path, row: Mapping[str, Any]) -> None:
    """Add a row at the end of the file.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    try:
        with Path(path).open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
        _note_written(Path(path), 1)
    except OSError as error:
        raise InputError(
            f"Cannot add a row to {path}: {error.strerror or error}. Rows before it are complete.", code="cannot-write"
        ) from error
