"""``fecontact compare``: from a plan to a table, files, a picture and a page."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fecontact.app.compare import page
from fecontact.app.compare.peers import Peer, find_peers
from fecontact.app.compare.picture import draw
from fecontact.app.compare.precision import against_peers, sentence
from fecontact.app.compare.problems import problem
from fecontact.app.compare.run import Plan, compare
from fecontact.app.compare.scenes import compare_scene
from fecontact.common.errors import InputError
from fecontact.common.text_files import check_writable, save_json, write_atomically

Row = dict[str, Any]


@dataclass(frozen=True)
class Files:
    """Where a comparison is written; None: not at all.

    Attributes
    ----------
    rows : Path or None
        JSON lines, added to as runs are finished; what a repeated command does not run again.
    json, csv, picture, page : Path or None
    """

    rows: Path | None = None
    json: Path | None = None
    csv: Path | None = None
    picture: Path | None = None
    page: Path | None = None

    @classmethod
    def of_folder(cls, folder: str | Path, name: str) -> Files:
        """All of them in one folder, which is made if it is missing."""
        folder = Path(folder)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"Cannot make the folder {folder}: {error.strerror}.") from error
        suffixes = (".jsonl", ".json", ".csv", ".png", ".md")
        return cls(*(folder / f"compare_{name}{suffix}" for suffix in suffixes))

    def check(self) -> None:
        """Refuse paths that cannot be written, before any run."""
        for path in vars(self).values():
            if path is not None:
                check_writable(path)


def run(
    plan: Plan,
    files: Files,
    *,
    adapters: str | Path | None = None,
    python: str = "python3",
    command: str = "fecontact compare",
) -> str:
    """Compare, write what is wanted, and give back the text for the screen.

    Parameters
    ----------
    plan : Plan
    files : Files
    adapters : str or Path, optional
        Folder with adapters of other programs, see `peers`.
    python : str
        Interpreter in which these are installed.
    command : str
        Named on the page as what made it.
    """
    files.check()
    peers: list[Peer] = []
    absent: list[str] = []
    if adapters is not None:
        peers, absent = find_peers(adapters, python)
    rows = compare(plan, files.rows, peers)
    chosen = problem(plan.problem)
    published = [] if adapters is None else _published(Path(adapters), plan.problem, rows)
    written = _write(plan, files, rows, published, absent, command)
    parts = [
        chosen.title[0].upper() + chosen.title[1:],
        page.table(rows),
        *(f"not run: {line}" for line in absent),
        page.conditions(rows),
        sentence(rows),
        against_peers(rows),
        *(f"wrote {path}" for path in written),
    ]
    return "\n".join(part for part in parts if part)


def run_scene(path: str | Path, refinements: int, files: Files) -> str:
    """Compare a user's scene with itself, refined; the text for the screen."""
    files.check()
    rows = compare_scene(path, refinements, files.rows)
    title = f"{rows[0]['method']}: the finest run is the reference"
    if files.json is not None:
        save_json(files.json, {"problem": rows[0]["problem"], "title": title, "rows": rows})
    if files.csv is not None:
        page.save_csv(rows, files.csv)
    if files.picture is not None:
        draw(rows[:-1], title, files.picture, note=page.conditions(rows))
    if files.page is not None:
        write_atomically(files.page, f"# {title}\n\n{page.markdown(rows)}\n")
    written = [f"wrote {p}" for p in vars(files).values() if p is not None]
    return "\n".join([title, page.table(rows), page.conditions(rows), *written])


def _write(
    plan: Plan, files: Files, rows: Sequence[Row], published: Sequence[Row], absent: Sequence[str], command: str
) -> list[Path]:
    title = problem(plan.problem).title
    if files.json is not None:
        save_json(files.json, {"problem": plan.problem, "title": title, "rows": list(rows)})
    if files.csv is not None:
        page.save_csv(rows, files.csv)
    if files.picture is not None:
        draw(rows, title, files.picture, published, page.conditions(rows))
    if files.page is not None:
        text = page.page(
            rows, title, command, picture=files.picture, path=files.page, absent=absent, published=published
        )
        write_atomically(files.page, text)
    return [path for path in vars(files).values() if path is not None]


def _published(folder: Path, name: str, rows: Sequence[Row]) -> list[Row]:
    """Figures from elsewhere of programs that were not measured here, out of the adapters' `published.json`."""
    file = folder / "published.json"
    if not file.is_file():
        return []
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
        known = [row for row in found if row["problem"] == name]
        measured = [row["method"].lower() for row in rows if row["peer"] and not row["failed"]]
        return [row for row in known if not any(m.startswith(row["program"].lower()) for m in measured)]
    except (json.JSONDecodeError, KeyError, TypeError) as error:
        raise InputError(f"{file} is not a list of published figures: {error}.") from error
