"""Tables: the same cells in text, Markdown, HTML and CSV."""

from __future__ import annotations

import csv
import io
from html.parser import HTMLParser

import numpy as np
import pytest

from fecontact.common.table import Column, Table

COLUMNS = ["case", Column("p|0", ".3g", "MPa", "none"), Column("n", "d")]
ROWS = [("a<b", 1 / 3, 7), ("=1+1", None, np.int64(12)), ("failed", "no figures, as the mesh is too coarse for this")]
TABLE = Table(COLUMNS, ROWS, ["A note."])


def test_text_is_aligned_and_a_row_that_ends_early_widens_no_column() -> None:
    assert str(TABLE).splitlines() == [
        "case    p|0 [MPa]   n",
        "a<b         0.333   7",
        "=1+1         none  12",
        "failed  no figures, as the mesh is too coarse for this",
        "A note.",
    ]


def test_csv_is_read_back_exactly_and_names_are_no_formulas() -> None:
    head, *rows = csv.reader(io.StringIO(TABLE.csv()))
    assert head == ["case", "p|0", "n"]
    assert float(rows[0][1]) == 1 / 3
    assert rows[1] == ["'=1+1", "", "12"]
    assert len(rows[2]) == 2
    values = np.random.default_rng(0).normal(size=(50, 2)) * 10.0 ** np.arange(-25, 25)[:, None]
    found = list(csv.reader(io.StringIO(Table(["x", "y"], list(values)).csv())))[1:]
    assert (np.array(found, float) == values).all()


def test_markdown_has_as_many_cells_in_each_line() -> None:
    lines = TABLE.markdown().splitlines()
    assert [line.replace(r"\|", "").count("|") for line in lines] == [4] * 5
    assert lines[1] == "|---|---:|---:|"


def test_html_has_all_cells_escaped() -> None:
    page, found = HTMLParser(), []
    page.handle_data = found.append  # type: ignore[method-assign]
    page.feed(TABLE.html())
    assert found == [*TABLE.heads, *(cell for row in TABLE.cells for cell in row)]
    assert 'colspan="2"' in TABLE.html()


def test_a_row_with_too_many_cells_is_refused() -> None:
    with pytest.raises(ValueError, match="2 cells below 1"):
        Table(["x"], [(1, 2)])


def test_a_table_without_rows_is_its_head() -> None:
    assert str(Table(["x", "y"], [])) == "x  y"
    assert Table(["x", "y"], []).csv() == "x,y\n"
