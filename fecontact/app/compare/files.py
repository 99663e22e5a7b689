"""Files of a comparison: where they go, checked before any run, and what is in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from fecontact.app.compare.picture import draw
from fecontact.app.compare.table import Row, conditions, save_csv
from fecontact.common.text_files import check_writable, make_folder, save_json, write_atomically

#: Kinds of files; 'rows' are JSON lines, added to as runs are finished, and what a repeated command does not run again.
SUFFIXES = {"rows": ".jsonl", "json": ".json", "csv": ".csv", "picture": ".png", "page": ".md"}


def places(name: str, folder: str | Path | None = None, **own: str | Path | None) -> dict[str, Path]:
    """Paths by kind of file: all in a folder, which is made if it is missing, but for those given by themselves.

    Raises
    ------
    InputError
        If the folder cannot be made, or a file cannot be written.

    Examples
    --------
    >>> [str(path) for path in places("punch", picture="punch.png", page=None).values()]
    ['punch.png']
    """
    chosen = {}
    if folder is not None:
        root = make_folder(folder)
        chosen = {kind: root / f"compare_{name}{suffix}" for kind, suffix in SUFFIXES.items()}
    chosen |= {kind: Path(path) for kind, path in own.items() if path is not None}
    for path in chosen.values():
        check_writable(path)
    return chosen


def write(
    paths: Mapping[str, Path], rows: Sequence[Row], title: str, page: str, drawn: Sequence[Row] | None = None
) -> list[str]:
    """Write files and name them.

    Parameters
    ----------
    paths : mapping of str to Path
        As from `places`.
    rows : sequence of dict
        As in `table`.
    title, page : str
        Of the picture; and the whole text of the page.
    drawn : sequence of dict, optional
        Rows of the picture, if they are others.

    Returns
    -------
    list of str
        A line for each file.
    """
    if "json" in paths:
        save_json(paths["json"], {"problem": rows[0]["problem"], "title": title, "rows": list(rows)})
    if "csv" in paths:
        save_csv(rows, paths["csv"])
    if "picture" in paths:
        draw(rows if drawn is None else drawn, title, paths["picture"], note=conditions(rows))
    if "page" in paths:
        write_atomically(paths["page"], page)
    return [f"wrote {path}" for path in paths.values()]
