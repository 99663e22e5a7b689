"""Errors, all derived from one class, and words of their messages: what was found, what was expected, what to do.

Examples
--------
>>> from fecontact.common.errors import FecontactError, InputError
>>> issubclass(InputError, FecontactError)
True
"""

from collections.abc import Iterable

#: Characters of a value that a message repeats.
SHOWN = 120


class FecontactError(Exception):
    """Root of all errors that fecontact raises on purpose."""


class InputError(FecontactError, ValueError):
    """A number, a name or an option that cannot be used; nothing has been computed yet."""


class MeshError(FecontactError, ValueError):
    """A mesh that is not a valid discretisation: inverted, degenerate or inconsistent elements."""


class SupportError(FecontactError):
    """A body can move freely under the loads; the message names the motion."""


class SolverError(FecontactError):
    """No certified solution of a complementarity problem was found; the message gives the status."""


class SolverNotFoundError(FecontactError, ValueError):
    """A solver or a back-end that is unknown or not installed; the message lists those that are."""


class MissingPackageError(FecontactError, ImportError):
    """An optional package that a feature needs is not installed; the message says how to install it."""


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


def place(point: Iterable[float]) -> str:
    """A point as a message tells it.

    Examples
    --------
    >>> place([0.0, 1.23456, -2e9])
    '(0, 1.235, -2e+09)'
    """
    return f"({', '.join(f'{v:.4g}' for v in point)})"


def sentence(name: str) -> str:
    """The name with a capital first letter, symbols unchanged."""
    return name[0].upper() + name[1:] if len(name) > 1 else name
