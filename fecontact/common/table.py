"""A table: named columns with units and formats, as aligned text, Markdown, HTML and CSV."""

from __future__ import annotations

import csv
import io
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.files import csv_name, write_atomically
from fecontact.common.renamed import present_name

#: Between columns of text.
GAP = "  "


@dataclass(frozen=True)
class Column:
    """A column's name, and how its numbers are shown.

    Attributes
    ----------
    name : str
    form : str
        Format of numbers; texts are shown as they are.
    unit : str
        Shown in brackets behind the name; not in CSV.
    blank : str
        Shown for None.
    """

    name: str
    form: str = ".6g"
    unit: str = ""
    blank: str = ""

    @property
    def head(self) -> str:
        """Name and unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    def cell(self, value: Any) -> str:
        """A value as it is shown."""
        if value is None:
            return self.blank
        return value if isinstance(value, str) else format(value, self.form)


@dataclass(frozen=True)
class Table:
    """Rows of numbers and texts below named columns.

    A row may end early: its last cell then takes the rest of the line.

    Attributes
    ----------
    columns : sequence of Column or str
    rows : sequence of sequences
        Of numbers, texts and None.
    notes : sequence of str
        Lines below the table; not in CSV.

    Examples
    --------
    >>> table = Table(["case", Column("depth", ".3f", "mm")], [("ball", 0.25), ("a block", 12)], ["Small strains."])
    >>> print(table)
    case     depth [mm]
    ball          0.250
    a block      12.000
    Small strains.
    >>> print(table.markdown())
    | case | depth [mm] |
    |---|---:|
    | ball | 0.250 |
    | a block | 12.000 |
    >>> print(table.csv(), end="")
    case,depth
    ball,0.25
    a block,12
    """

    columns: Sequence[Column | str]
    rows: Sequence[Sequence[Any]]
    notes: Sequence[str] = ()

    def __post_init__(self) -> None:
        if long := [row for row in self.rows if len(row) > len(self.columns)]:
            raise ValueError(f"a row of {len(long[0])} cells below {len(self.columns)} columns")

    @cached_property
    def _columns(self) -> list[Column]:
        return [Column(c) if isinstance(c, str) else c for c in self.columns]

    @property
    def heads(self) -> list[str]:
        """Names of the columns with their units."""
        return [column.head for column in self._columns]

    @property
    def cells(self) -> list[list[str]]:
        """All cells as they are shown."""
        return [[c.cell(v) for c, v in zip(self._columns, row, strict=False)] for row in self.rows]

    @property
    def _right(self) -> list[bool]:
        """Whether a column is of numbers, whose ends are below each other."""
        full = [row for row in self.rows if len(row) == len(self.columns)]
        return [any(not isinstance(row[k], str | None) for row in full) for k in range(len(self.columns))]

    def __str__(self) -> str:
        lines, right, n = [self.heads, *self.cells], self._right, len(self.columns)
        # the last cell of a row that ends early takes no part in the width of its column
        widths = [max(len(line[k]) for line in lines if len(line) > k + (len(line) < n)) for k in range(n)]

        def aligned(line: Sequence[str]) -> str:
            ends = [r and k < len(line) - (len(line) < n) for k, r in enumerate(right)]
            padded = [c.rjust(w) if e else c.ljust(w) for c, w, e in zip(line, widths, ends, strict=False)]
            return GAP.join(padded).rstrip()

        return "\n".join([*map(aligned, lines), *self.notes])

    def markdown(self) -> str:
        """Table in Markdown, without the notes."""
        n, rule = len(self.columns), "".join("|---:" if right else "|---" for right in self._right)
        lines = [[*line, *[""] * (n - len(line))] for line in [self.heads, *self.cells]]
        text = [f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines]
        return "\n".join([text[0], f"{rule}|", *text[1:]])

    def html(self) -> str:
        """Element <table>, without the notes."""
        n, head = len(self.columns), "".join(f"<th>{escape(head)}</th>" for head in self.heads)
        lines = []
        for line in self.cells:
            *first, last = [escape(cell) for cell in line]
            span = f' colspan="{n - len(first)}"' if len(line) < n else ""
            lines.append(f"<tr>{''.join(f'<td>{cell}</td>' for cell in first)}<td{span}>{last}</td></tr>")
        return f"<table><tr>{head}</tr>{''.join(lines)}</table>"

    def csv(self) -> str:
        """Comma-separated values with a head; numbers read back are the same, and None is empty."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([csv_name(column.name) for column in self._columns])
        writer.writerows([_exact(value) for value in row] for row in self.rows)
        return text.getvalue()

    def save(self, path: str | Path) -> Path:
        """Write `csv` to a file.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        return write_atomically(path, self.csv())


class Figures:
    """Columns of numbers by name, with a row for each case, load or step."""

    @property
    @abstractmethod
    def figures(self) -> Mapping[str, Array]:
        """Columns (n,) by name."""

    def column(self, name: str) -> Array:
        """Figures (n,) of one name, see `figures`.

        Raises
        ------
        InputError
            If there are none of that name.
        """
        name = present_name(name, self.figures)
        among("column", name, self.figures)
        return self.figures[name]


def _exact(value: Any) -> Any:
    """A cell of CSV; the writer gives the shortest text of a number that reads back as it."""
    if isinstance(value, str):
        return csv_name(value)
    return value.item() if isinstance(value, np.generic) else value
