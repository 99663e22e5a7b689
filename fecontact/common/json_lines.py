"""JSON-lines files: one finished row per line, so that an interrupted run can be resumed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fecontact.common.errors import InputError
from fecontact.common.files import check_writable, write_atomically


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
            raise InputError(f"Line {k + 1} of {path} is not {what}; choose another file.") from error
    if lines and not lines[-1].endswith("\n"):
        write_atomically(path, "".join(lines) + "\n")
    return rows


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
    except OSError as error:
        raise InputError(
            f"Cannot add a row to {path}: {error.strerror or error}. Rows before it are complete."
        ) from error
