"""Other programs on the same problem, by small adapter scripts that are no part of the package.

An adapter is a script with two ways to be called. ``script --about`` prints one line of JSON, {"method", "kind",
"problems", "settings", "version"}, and fails with an ImportError if its program is not installed.
``script PROBLEM SETTING`` solves and prints a last line of JSON, {"dofs", "errors", "seconds", "mesh_seconds",
"peak_mb"}, with the errors of `problems.Problem.errors` and processor seconds without the loading of packages.
"""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compare.machine import THREADS
from compare.table import Row
from fecontact import InputError

#: Seconds in which an adapter has to introduce itself.
PATIENCE = 60


def environment(threads: int) -> dict[str, str]:
    """This process's environment with the number of threads set."""
    return {**os.environ, **dict.fromkeys(THREADS, str(threads))}


@dataclass(frozen=True)
class Peer:
    """An adapter whose program is installed.

    Attributes
    ----------
    python : str
        Interpreter that runs it.
    script : Path
    method, kind, version : str
        Name for the legend, kind as in `methods.Method`, version of the program.
    problems : tuple of str
    settings : tuple
        From coarse to fine.
    """

    python: str
    script: Path
    method: str
    kind: str
    version: str
    problems: tuple[str, ...]
    settings: tuple[Any, ...]


def find_peers(folder: str | Path, python: str) -> tuple[list[Peer], list[str]]:
    """Adapters of a folder.

    Parameters
    ----------
    folder : str or Path
    python : str
        Interpreter in which the programs are installed.

    Returns
    -------
    peers : list of Peer
    absent : list of str
        One line for each that cannot be run, with the reason.

    Raises
    ------
    InputError
        If there is no such folder or interpreter.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"There is no folder {folder} with adapters of other programs.")
    peers, absent = [], []
    for script in sorted(p for p in folder.glob("*.py") if not p.stem.startswith("_")):
        answer = ask([python, str(script), "--about"], environment(1), PATIENCE)
        if isinstance(answer, str):
            absent.append(f"{script.stem}: {answer}")
            continue
        peers.append(
            Peer(
                python,
                script,
                answer["method"],
                answer["kind"],
                answer["version"],
                tuple(answer["problems"]),
                tuple(answer["settings"]),
            )
        )
    return peers, absent


def ask(command: Sequence[str], env: Mapping[str, str], patience: float) -> dict[str, Any] | str:
    """The last line of JSON that a command prints, or why there is none."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=patience, env=dict(env), check=False)
    except FileNotFoundError as error:
        raise InputError(f"There is no Python interpreter {command[0]!r}.") from error
    except subprocess.TimeoutExpired:
        return f"took longer than {patience:g} s"
    lines = (done.stderr if done.returncode else done.stdout).strip().splitlines()
    if done.returncode:
        return lines[-1] if lines else f"ended with status {done.returncode}"
    try:
        answer = json.loads(lines[-1]) if lines else None
    except json.JSONDecodeError:
        answer = None
    return answer if isinstance(answer, dict) else "printed no line of JSON"


def published(folder: Path, name: str, rows: Sequence[Row]) -> list[Row]:
    """Figures from elsewhere of programs that were not measured here, out of the adapters' `published.json`.

    Returns
    -------
    list of dict
        'program', 'method', 'source', 'dofs', 'seconds', 'errors', and a 'style' for the picture: grey points.
    """
    file = folder / "published.json"
    if not file.is_file():
        return []
    measured = [row["method"].lower() for row in rows if row["peer"] and not row["failed"]]
    try:
        known = [row for row in json.loads(file.read_text(encoding="utf-8")) if row["problem"] == name]
        left = [row for row in known if not any(m.startswith(row["program"].lower()) for m in measured)]
        markers = dict(zip(dict.fromkeys(row["method"] for row in left), "+x1234|_", strict=False))
        for row in left:
            label = f"{row['method']}, published elsewhere"
            row["style"] = {"ls": "none", "color": "0.5", "marker": markers.get(row["method"], "_"), "label": label}
        return [{**row, "failed": None} for row in left]
    except (json.JSONDecodeError, KeyError, TypeError) as error:
        raise InputError(f"{file} is not a list of published figures: {error}.") from error


def styled(rows: Sequence[Row]) -> Iterator[Row]:
    """Rows with a style for the picture: other programs are dashed, in greys, with hollow markers."""
    greys = ("black", "0.35", "0.55", "0.2", "0.45")
    theirs = {name: greys[k % 5] for k, name in enumerate(dict.fromkeys(r["method"] for r in rows if r["peer"]))}
    for row in rows:
        look = {"ls": "--", "mfc": "white", "color": theirs[row["method"]]} if row["peer"] else {}
        yield {**row, "style": look}
