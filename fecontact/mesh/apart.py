"""A function in a process of its own, so that a library that aborts ends that process alone."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from fecontact.common.errors import FecontactError, MeshError

T = TypeVar("T")

#: Program of the process: the same modules as here, whatever the main script is.
_START = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from fecontact.mesh.apart import serve; serve(sys.argv[2])"
)
#: Last lines of what the process printed that a message repeats.
LAST_WORDS = 4


def run_apart(what: str, function: Callable[..., T], *arguments: Any) -> T:
    """Result of a function of this package, called in a fresh interpreter.

    Arguments and result go through files of a temporary folder. An interruption ends the process too.

    Parameters
    ----------
    what : str
        What is done, for the message of a crash.
    function : callable
        A function of a module of the package.
    *arguments

    Raises
    ------
    FecontactError
        What the function raises.
    MeshError
        If it raises another error, or its process ends without a result; with the last lines that it printed.

    Examples
    --------
    >>> from fecontact import shapes
    >>> run_apart("A block", shapes.block, (1.0, 1.0, 1.0), (1, 1, 1))
    Mesh(hex20, 1 cells, 20 points, boundaries: x_min, x_max, y_min, y_max, bottom, top)
    """
    with tempfile.TemporaryDirectory(prefix="fecontact-") as name:
        folder = Path(name)
        (folder / "task").write_bytes(pickle.dumps((function, arguments)))
        path = json.dumps([entry for entry in sys.path if isinstance(entry, str)])
        with (folder / "said").open("wb") as said:
            code = subprocess.run(
                [sys.executable, "-c", _START, path, name], stdin=subprocess.DEVNULL, stdout=said, stderr=said
            ).returncode
        if not (folder / "reply").exists():
            raise MeshError(f"{what} ended its process ({_ending(code)}). {_last_words(folder / 'said')}")
        good, value = pickle.loads((folder / "reply").read_bytes())
    if not good:
        raise value
    return value


def serve(folder: str) -> None:
    """Run the task in a folder and write the reply beside it; called in the fresh interpreter."""
    place = Path(folder)
    function, arguments = pickle.loads((place / "task").read_bytes())
    try:
        reply = (True, function(*arguments))
    except FecontactError as error:
        reply = (False, error)
    (place / "part").write_bytes(pickle.dumps(reply))
    os.replace(place / "part", place / "reply")


def _ending(code: int) -> str:
    """How a process ended, by its exit code."""
    try:
        return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit {code}"
    except ValueError:
        return f"signal {-code}"


def _last_words(said: Path) -> str:
    lines = [line.strip() for line in said.read_text(encoding="utf-8", errors="replace").splitlines() if line.strip()]
    return "Its last words: " + " / ".join(lines[-LAST_WORDS:]) if lines else "It said nothing."
