"""Progress of long work: one line of the terminal with the stage, and a count where the number of parts is known."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

from tqdm import tqdm

from fecontact.common.errors import InputError, shown


@dataclass
class Line:
    """A line of progress.

    Attributes
    ----------
    bar : tqdm
    part : str
        What the stages belong to, such as a round.
    """

    bar: Any
    part: str = ""

    def update(self) -> None:
        """Count a part."""
        self.bar.update()


_LINE: ContextVar[Line | None] = ContextVar("line of progress", default=None)


@contextmanager
def progress_line(what: str, progress: bool | None, total: int | None = None, unit: str = "it") -> Iterator[Line]:
    """Show a line while the block runs; inside another one there is none of its own.

    Parameters
    ----------
    what : str
    progress : bool or None
        None: where standard error is a terminal.
    total : int, optional
        Number of parts, counted by ``update()`` of the line. A line without parts is removed at the end.
    unit : str
        Name of a part.

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
    hidden = None if progress is None else not progress
    with tqdm(
        total=total, desc=what, unit=unit, disable=hidden, leave=total is not None, bar_format=form, mininterval=0.2
    ) as bar:
        line = Line(bar)
        token = _LINE.set(line)
        try:
            yield line
        finally:
            _LINE.reset(token)


def set_stage(stage: str) -> None:
    """Show what is being done in the line, if there is one."""
    line = _LINE.get()
    if line is not None and not line.bar.disable:
        line.bar.set_postfix_str(f"{line.part}{stage}")


def set_part(part: str) -> None:
    """Show what the following stages belong to."""
    line = _LINE.get()
    if line is not None:
        line.part = f"{part}, "
