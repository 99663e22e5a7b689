"""Progress of long work: one line with the stage and the time, and a count where the number of parts is known.

It is shown in terminals and notebooks, not in files. The time goes on while a stage lasts, by a thread of its own.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

from tqdm import tqdm

from fecontact.common.errors import InputError, shown

#: Seconds after which a wait is shown of work that is mostly shorter.
LONG = 1.5


@dataclass
class Line:
    """A line of progress.

    Attributes
    ----------
    bar : tqdm
    shown_from : float
        Time (`time.monotonic`) before which it is not shown.
    part : str
        What the stages belong to, such as a round.
    """

    bar: Any
    shown_from: float
    part: str = ""

    def refresh(self) -> None:
        """Draw it again, once it is shown at all."""
        if time.monotonic() >= self.shown_from:
            self.bar.refresh()

    def update(self) -> None:
        """Count a part."""
        self.bar.update()


_LINE: ContextVar[Line | None] = ContextVar("line of progress", default=None)


@contextmanager
def progress_line(
    what: str, progress: bool | None, total: int | None = None, unit: str = "it", delay: float = 0.0
) -> Iterator[Line]:
    """Show a line while the block runs; inside another one there is none of its own.

    Parameters
    ----------
    what : str
    progress : bool or None
        None: where standard error is a terminal, and in a notebook.
    total : int, optional
        Number of parts, counted by ``update()`` of the line. A line without parts is removed at the end.
    unit : str
        Name of a part.
    delay : float
        Seconds before which nothing is shown, for what is mostly short.

    Raises
    ------
    InputError
        For another value of `progress`.

    Examples
    --------
    >>> with progress_line("solve", False):
    ...     set_stage("assemble")
    """
    if not (progress is None or isinstance(progress, bool)):
        raise InputError(f"progress must be True, False or None (where there is a terminal); found {shown(progress)}.")
    around = _LINE.get()
    if around is not None:
        yield around
        return
    form = None if total is not None else "{desc} [{elapsed}{postfix}]"
    hidden = not (_is_watched() if progress is None else progress)
    with tqdm(
        total=total,
        desc=what,
        unit=unit,
        disable=hidden,
        leave=total is not None,
        bar_format=form,
        mininterval=0.2,
        delay=delay,
    ) as bar:
        line = Line(bar, time.monotonic() + delay)
        token = _LINE.set(line)
        done = threading.Event()
        if not hidden:
            threading.Thread(target=_tick, args=(line, done), daemon=True).start()
        try:
            yield line
        finally:
            done.set()
            _LINE.reset(token)


def _is_watched() -> bool:
    """Whether somebody sees standard error: a terminal, or the kernel of a notebook."""
    return sys.stderr.isatty() or "ipykernel.zmqshell" in sys.modules


def _tick(line: Line, done: threading.Event) -> None:
    """Let the time of a line go on until its block is done."""
    while not done.wait(1.0):
        line.refresh()


def say_done(text: str) -> None:
    """Print a line that stays, above the one of progress; nothing where there is none."""
    line = _LINE.get()
    if line is not None and not line.bar.disable:
        line.bar.write(text, file=sys.stderr)


def set_stage(stage: str) -> None:
    """Show what is being done in the line, if there is one."""
    line = _LINE.get()
    if line is not None and not line.bar.disable:
        line.bar.set_postfix_str(f"{line.part}{stage}", refresh=False)
        line.refresh()


def set_part(part: str) -> None:
    """Show what the following stages belong to."""
    line = _LINE.get()
    if line is not None:
        line.part = f"{part}, "
