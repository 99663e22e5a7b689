"""Files of a comparison: paths, checked before any run, and contents."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from compare.picture import draw
from compare.table import Row, conditions, save_csv, save_shown
from fecontact.common.files import check_writable, make_folder, save_json, write_atomically

#: Kinds of files; 'rows' are JSON lines of finished runs, which a repeated command does not run again. 'shown', the
#: table of a page, lies beside it.
SUFFIXES = {"rows": ".jsonl", "json": ".json", "csv": ".csv", "picture": ".png", "page": ".md"}


def places(name: str, folder: str | Path | None = None, **own: str | Path | None) -> dict[str, Path]:
    """Paths by kind of file: in a folder, which is made if missing, except those given explicitly.

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
    if "page" in chosen:
        chosen["shown"] = chosen["page"].with_name(f"{chosen['page'].stem}_runs.csv")
    for path in chosen.values():
        check_writable(path)
    return chosen


def write(
    paths: Mapping[str, Path], rows: Sequence[Row], title: str, page: str, drawn: Sequence[Row] | None = None
) -> list[str]:
    """Write the files and list them.

    Parameters
    ----------
    paths : mapping of str to Path
        As from `places`.
    rows : sequence of dict
        As in `table`.
    title, page : str
        Title of the picture, and text of the page.
    drawn : sequence of dict, optional
        Rows of the picture, if different.

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
        save_shown(rows, paths["shown"])
    return [f"wrote {path}" for path in paths.values()]
