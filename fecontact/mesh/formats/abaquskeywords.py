"""Keywords of Abaqus and CalculiX input files with their parameters and data lines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fecontact.errors import MeshError


@dataclass(frozen=True)
class Section:
    """A keyword with its parameters (names in capitals) and data lines."""

    keyword: str
    parameters: dict[str, str]
    lines: list[str]


def read_sections(path: Path) -> Iterator[Section]:
    """Keywords of a file in their order, included files in place."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise MeshError(f"{path} could not be read: {error.strerror}.") from error
    keyword, lines = "", []
    parameters: dict[str, str] = {}
    for line in text.splitlines():
        if line.startswith("**") or not line.strip():
            continue
        if not line.startswith("*"):
            lines.append(line.strip())
            continue
        if keyword:
            yield Section(keyword, parameters, lines)
        head, *rest = line[1:].split(",")
        keyword, lines = " ".join(head.upper().split()), []
        pairs = [item.partition("=") for item in rest if item.strip()]
        parameters = {name.strip().upper(): value.strip().strip('"') for name, _, value in pairs}
        if keyword == "INCLUDE":
            yield from read_sections(path.parent / parameters.get("INPUT", ""))
            keyword = ""
    if keyword:
        yield Section(keyword, parameters, lines)


def table(lines: list[str], columns: int, dtype: type) -> NDArray:
    """Rows of numbers; a row may run over several lines."""
    text = ",".join(line.rstrip(",") for line in lines)
    values: NDArray = np.array([v for v in text.replace(" ", "").split(",") if v], dtype=dtype)
    if len(values) % columns:
        raise MeshError(
            f"A block that begins with {lines[0]!r} has {len(values)} numbers, no multiple of the {columns} that a row "
            "needs. The file is damaged or of another element type than it says."
        )
    return values.reshape(-1, columns)
