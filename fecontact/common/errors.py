"""Errors, all derived from one class, and words of their messages: what was found, what was expected, what to do.

The sentence of an error may change in any release; its class and its `code` do not. A program that has to tell errors
apart asks for these.

Examples
--------
>>> from fecontact.common.errors import FecontactError, InputError
>>> issubclass(InputError, FecontactError)
True
"""

import difflib
import importlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

#: Characters of a value that a message repeats.
SHOWN = 120


class FecontactError(Exception):
    """Root of all errors that fecontact raises on purpose.

    Parameters
    ----------
    *args : object
        The message first.
    code : str, optional
        Stable name of the reason, such as ``not-positive``; the class's own where it is not given.

    Examples
    --------
    >>> FecontactError("No.").code, InputError("E must be positive; found 0.", code="not-positive").code
    ('error', 'not-positive')
    """

    code = "error"

    def __init__(self, *args: object, code: str | None = None) -> None:
        super().__init__(*args)
        self.code = code or self.code

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class InputError(FecontactError, ValueError):
    """A number, a name or an option that cannot be used; nothing has been computed yet."""

    code = "input"


class MeshError(FecontactError, ValueError):
    """A mesh that is not a valid discretisation: inverted, degenerate or inconsistent elements."""

    code = "mesh"


class SupportError(FecontactError):
    """A body can move freely under the loads; the message names the motion."""

    code = "free-motion"


class SolverError(FecontactError):
    """No certified solution of a complementarity problem was found; the message gives the status."""

    code = "not-solved"


class SolverNotFoundError(FecontactError, ValueError):
    """A solver or a back-end that is unknown or not installed; the message lists those that are."""

    code = "unknown-solver"


class MissingPackageError(FecontactError, ImportError):
    """An optional package that a feature needs is not installed; the message says how to install it."""

    code = "missing-package"


def optional(package: str, use: str, extra: str = "") -> Any:
    """An optional package, imported when it is first used.

    Raises
    ------
    MissingPackageError
        If it is not installed.

    Examples
    --------
    >>> optional("math", "counting").pi > 3
    True
    """
    try:
        return importlib.import_module(package)
    except ImportError as error:
        raise MissingPackageError(f"{use} needs {package}: pip install {extra or package}.") from error


@contextmanager
def named(what: str) -> Iterator[None]:
    """Context: messages of errors begin with what they are about, such as a case or a step; class and code stay.

    Examples
    --------
    >>> with named("Step 2 of 3"):
    ...     raise InputError("No loads.", code="no-loads")
    Traceback (most recent call last):
    ...
    fecontact.common.errors.InputError: Step 2 of 3: No loads.
    """
    try:
        yield
    except FecontactError as error:
        if what:
            error.args = (f"{what}: {error}", *error.args[1:])
        raise


def shown(value: object) -> str:
    """The value as a message repeats it: cut where it is long, by its type where it cannot be printed.

    Examples
    --------
    >>> shown("steel"), len(shown("x" * 1000))
    ("'steel'", 120)
    """
    try:
        text = repr(value)
    except Exception:  # whatever an object of the user raises
        text = f"a {type(value).__name__} that cannot be printed"
    return text if len(text) <= SHOWN else text[: SHOWN - 4] + " ..."


def not_done(what: str) -> InputError:
    """What a file asks for and the package does not do, in a sentence.

    Examples
    --------
    >>> not_done("*SYSTEM turns coordinates, which is not done here.").code
    'not-supported'
    """
    return InputError(what, code="not-supported")


def place(point: Iterable[float]) -> str:
    """A point as a message tells it.

    Examples
    --------
    >>> place([0.0, 1.23456, -2e9])
    '(0, 1.235, -2e+09)'
    """
    return f"({', '.join(f'{v:.4g}' for v in point)})"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """A hint such as ``", did you mean 'rubber'"``, or nothing.

    Examples
    --------
    >>> did_you_mean("ruber", ["steel", "rubber"])
    ", did you mean 'rubber'"
    """
    near = difflib.get_close_matches(name, list(known), 1, 0.6)
    return f", did you mean {near[0]!r}" if near else ""


def sentence(name: str) -> str:
    """The name with a capital first letter, symbols unchanged."""
    return name[0].upper() + name[1:] if len(name) > 1 else name
