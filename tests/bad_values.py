"""Bad values of arguments, and what comes of a call with one: accepted, refused, or somebody else's error."""

from __future__ import annotations

import contextlib
import io
import signal
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fecontact import FecontactError

PACKAGE = str(Path(__file__).resolve().parents[1] / "fecontact")
#: Seconds of processor time after which a call counts as hanging, and of the clock for one that only waits.
PATIENCE, WAITING = 5.0, 60.0


def _self_holding() -> list[Any]:
    holder: list[Any] = []
    holder.append(holder)
    return holder


#: By name, what is tried for every argument.
BAD: dict[str, Any] = {
    "None": None,
    "text": "x",
    "empty text": "",
    "number as text": "1.0",
    "numbers as text": ["1", "2", "3"],
    "bytes": b"1",
    "nan": np.nan,
    "inf": np.inf,
    "-inf": -np.inf,
    "10**400": 10**400,
    "-10**400": -(10**400),
    "-1": -1,
    "0": 0,
    "0.5": 0.5,
    "1e-320": 1e-320,
    "1e-200": 1e-200,
    "1e308": 1e308,
    "2**62": 2**62,
    "complex": 1 + 1j,
    "True": True,
    "empty list": [],
    "[[]]": [[]],
    "empty dict": {},
    "dict": {"x": "y"},
    "object": object(),
    "lambda": lambda *a, **k: None,
    "(2,)": (1.0, 2.0),
    "(3,)": np.array([1.0, -2.0, 3.0]),
    "(3,) nan": (0.0, np.nan, 1.0),
    "(3,) huge": (0.0, 1e308, 1e308),
    "(3,) int": (0, 0, 10**400),
    "(3, 3)": np.ones((3, 3)),
    "(3, 3) nan": np.full((3, 3), np.nan),
    "(2, 2, 2)": np.zeros((2, 2, 2)),
    "ragged": [[1.0, 2.0], [3.0]],
    "self-holding": _self_holding(),
    "array of objects": np.array([object(), None, "x"], dtype=object),
    "complex array": np.array([1j, 0, 0]),
    "array of text": np.array(["a", "b", "c"]),
    "array of one": np.array([1.0]),
    "date": np.datetime64("2020-01-01"),
    "no file": "/nowhere/at/all.vtu",
    "full": "/dev/full",
    "folder": "/",
    "nul": "a\0b.stl",
    "long name": "n" * 300 + ".stl",
    "set": {1, 2, 3},
    "generator": range(0),
    "exception": ValueError("x"),
}


class TooLong(BaseException):
    """A call that did not come back in time."""


@contextlib.contextmanager
def within(seconds: float) -> Iterator[None]:
    """Context: raise `TooLong` after some seconds of processor time, so that a busy machine is not taken for a hang."""

    def stop(signum: int, frame: object) -> None:
        raise TooLong

    timers = ((signal.SIGPROF, signal.ITIMER_PROF, seconds), (signal.SIGALRM, signal.ITIMER_REAL, WAITING))
    before = [signal.signal(number, stop) for number, _, _ in timers]
    for _, timer, after in timers:
        signal.setitimer(timer, after)
    try:
        yield
    finally:
        for (number, timer, _), former in zip(timers, before, strict=True):
            signal.setitimer(timer, 0)
            signal.signal(number, former)


@dataclass(frozen=True)
class Outcome:
    """What came of a call: 'accepted', 'refused', 'python', 'foreign' or 'hang', and the words."""

    kind: str
    words: str = ""

    @property
    def is_good(self) -> bool:
        return self.kind in ("accepted", "refused", "python")


def outcome(call: Callable[[], object], patience: float = PATIENCE) -> Outcome:
    """Outcome of a call; warnings of arithmetic count as errors, printed lines are dropped.

    A TypeError of the call itself, with no line of the package below it, is Python's own word on a name or number of
    arguments that does not exist: 'python'.
    """
    try:
        with (
            within(patience),
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.redirect_stderr(io.StringIO()),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", RuntimeWarning)
            call()
    except FecontactError as error:
        words = str(error)
        return Outcome("refused" if len(words.split()) >= 4 else "foreign", f"{type(error).__name__}: {words}")
    except TooLong:
        return Outcome("hang", f"more than {patience} s")
    except SystemExit as error:
        return Outcome("foreign", f"SystemExit: {error}")
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename.startswith(PACKAGE)]
        if isinstance(error, TypeError) and not frames:
            return Outcome("python", str(error))
        where = f"{frames[-1].filename.removeprefix(PACKAGE)}:{frames[-1].lineno}" if frames else "outside"
        first = f"{frames[0].filename.removeprefix(PACKAGE)}:{frames[0].lineno}" if frames else ""
        try:
            words = str(error)
        except Exception:
            words = "?"
        return Outcome("foreign", f"{type(error).__name__} at {where} from {first}: {words[:150]}")
    return Outcome("accepted")
