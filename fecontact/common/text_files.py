"""Text files: path checked before long work, atomic writes."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from fecontact.common.errors import InputError


def check_writable(path: str | Path) -> Path:
    """Refuse a path that cannot be written, before long work.

    Raises
    ------
    InputError
        If the folder does not exist, is no folder, or the file cannot be written.
    """
    path = Path(path)
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
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"Cannot make the folder {path}: {error.strerror}.") from error
    return Path(path)


def write_atomically(path: str | Path, text: str) -> Path:
    """Write a text file under a temporary name and move it into place; an interruption leaves the old file intact."""
    path = check_writable(path)
    if path.exists() and not path.is_file():
        path.write_text(text, encoding="utf-8")  # a pipe or a device is written to, never replaced
        return path
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
    return path


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
    """Write the PVD file that lists files beside it with their times."""
    pairs = zip(files, times, strict=True)
    lines = [f'    <DataSet timestep="{time!r}" file={quoteattr(file.name)}/>' for file, time in pairs]
    head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
    return write_atomically(path, head + "\n".join(lines) + "\n  </Collection>\n</VTKFile>\n")
