"""Checks of arguments that are no numbers: names, flags, objects, functions, mappings, sequences, paths."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from fecontact.common.errors import InputError, did_you_mean, sentence, shown

#: Characters of a path and of a name in it that file systems accept.
MAX_PATH, MAX_NAME = 4000, 255

T = TypeVar("T")


def text(name: str, value: object) -> str:
    """Return a name or another text, or refuse what is none.

    Raises
    ------
    InputError
        If it is no text, or empty.

    Examples
    --------
    >>> text("the name of a body", "femur")
    'femur'
    """
    if not (isinstance(value, str) and value):
        raise InputError(f"{sentence(name)} must be a text that is not empty; found {shown(value)}.", code="not-a-text")
    if any("\ud800" <= letter <= "\udfff" for letter in value):
        raise InputError(
            f"{sentence(name)} has letters that the locale does not know; found {shown(value)}. Set PYTHONUTF8=1.",
            code="not-a-text",
        )
    return value


def texts(name: str, value: object) -> tuple[str, ...]:
    """Return one text or several as a tuple, or refuse them.

    Raises
    ------
    InputError
        If one is no text, or empty.

    Examples
    --------
    >>> texts("the contact boundaries", "top"), texts("the contact boundaries", ["top", "bottom"])
    (('top',), ('top', 'bottom'))
    """
    several = (value,) if isinstance(value, str) else value
    return tuple(text(f"each of {name}", one) for one in items(name, several, "names"))


def flag(name: str, value: object) -> bool:
    """Return True or False, or refuse what is neither.

    Raises
    ------
    InputError
        If it is neither.

    Examples
    --------
    >>> flag("periodic", True)
    True
    """
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{sentence(name)} must be True or False; found {shown(value)}.", code="not-true-or-false")
    return bool(value)


def instance(name: str, value: T, kind: type | tuple[type, ...]) -> T:
    """Return `value`, or refuse it if it is of another class.

    Raises
    ------
    InputError
        If it is.

    Examples
    --------
    >>> instance("the number", 2, int)
    2
    """
    if not isinstance(value, kind):
        kinds = kind if isinstance(kind, tuple) else (kind,)
        expected = " or ".join("None" if k is type(None) else f"a {k.__name__}" for k in kinds)
        raise InputError(f"{sentence(name)} must be {expected}; found {shown(value)}.", code="wrong-class")
    return value


def function(name: str, value: T) -> T:
    """Return `value`, or refuse it if it cannot be called.

    Raises
    ------
    InputError
        If it cannot.

    Examples
    --------
    >>> function("the mapping", abs)(-1)
    1
    """
    if not callable(value):
        raise InputError(f"{sentence(name)} must be a function; found {shown(value)}.", code="not-a-function")
    return value


def mapping(name: str, value: Mapping[Any, T] | None) -> Mapping[Any, T]:
    """Return a mapping, empty for None, or refuse what is none.

    Raises
    ------
    InputError
        If it is no mapping.

    Examples
    --------
    >>> mapping("forces", None)
    {}
    """
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise InputError(
            f"{sentence(name)} must be a mapping such as {{key: value}}; found {shown(value)}.", code="not-a-mapping"
        )
    return value


def items(name: str, value: Any, what: str) -> tuple[Any, ...]:
    """Return the items of a sequence, or refuse what is none; a text or a mapping is none.

    Raises
    ------
    InputError
        If it is no sequence.

    Examples
    --------
    >>> items("sizes", [1, 2], "numbers")
    (1, 2)
    """
    if not isinstance(value, str | bytes | Mapping | type):
        try:
            return tuple(value)
        except TypeError:
            pass
    raise InputError(f"{sentence(name)} must be a sequence of {what}; found {shown(value)}.", code="not-a-sequence")


def known_names(owner: str, given: Iterable[str], known: Iterable[str]) -> None:
    """Refuse names of arguments that are not known; the message says which was meant, and lists all.

    Raises
    ------
    InputError
        With the first of them.

    Examples
    --------
    >>> known_names("solve()", ["acuracy"], ["accuracy", "solver"])
    Traceback (most recent call last):
    fecontact.common.errors.InputError: solve() has no 'acuracy', did you mean 'accuracy'? It takes: accuracy, solver.
    """
    allowed = sorted(known)
    for name in sorted(set(given) - set(allowed)):
        hint = did_you_mean(name, allowed)
        takes = f"It takes: {', '.join(allowed)}." if allowed else "It takes none."
        raise InputError(f"{owner} has no {name!r}{hint}{'?' if hint else '.'} {takes}", code="unknown-option")


def spelled(what: T) -> T:
    """A function, or a class, that answers an argument which it does not have with the one that was meant.

    Names that a function hands on, as its `**load`, are left to what takes them.

    Examples
    --------
    >>> @spelled
    ... def press(*, force=0.0):
    ...     return force
    >>> press(forse=1.0)
    Traceback (most recent call last):
    fecontact.common.errors.InputError: press() has no 'forse', did you mean 'force'? It takes: force.
    """
    if isinstance(what, type):
        what.__init__ = spelled(what.__init__)  # type: ignore[misc]
        what.__init__.__spelled__ = what.__name__  # type: ignore[misc]
        return what
    function: Any = what
    parameters = [p for p in inspect.signature(function).parameters.values() if p.name != "self"]
    known = {p.name for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)}
    if any(p.kind is p.VAR_KEYWORD for p in parameters):
        return what

    @wraps(function)
    def called(*args: Any, **given: Any) -> Any:
        if not given.keys() <= known:
            known_names(f"{getattr(called, '__spelled__', function.__name__)}()", given, known)
        return function(*args, **given)

    return called  # type: ignore[return-value]


def known_options(function: Callable[..., Any], options: Mapping[str, Any]) -> None:
    """Refuse options that a function does not have; the message lists those that it has.

    Raises
    ------
    InputError
        If an option is not a keyword-only parameter of the function.

    Examples
    --------
    >>> known_options(sorted, {"reverse": True})
    """
    parameters = inspect.signature(function).parameters.values()
    allowed = {each.name for each in parameters if each.kind is each.KEYWORD_ONLY}
    known_names(f"{function.__name__}()", options, allowed)


def label(name: str, value: object) -> str:
    """Return a text that may be empty, or refuse what is none.

    Raises
    ------
    InputError
        If it is no text.

    Examples
    --------
    >>> label("the unit of length", "")
    ''
    """
    return "" if isinstance(value, str) and not value else text(name, value)


def file_path(name: str, value: object) -> Path:
    """Return `value` as a path, or refuse what no file can be called.

    Raises
    ------
    InputError
        If it is neither text nor a path, is empty or too long, or holds a NUL character.

    Examples
    --------
    >>> file_path("the file", "knee.inp").suffix
    '.inp'
    """
    if not isinstance(value, str | Path) or not str(value):
        raise InputError(
            f"{sentence(name)} must be a path, a text or a pathlib.Path; found {shown(value)}.", code="not-a-path"
        )
    path = Path(value)
    if "\0" in str(value) or len(str(value)) > MAX_PATH or any(len(os.fsencode(p)) > MAX_NAME for p in path.parts):
        raise InputError(f"{sentence(name)} is no path that a file can have; found {shown(value)}.", code="not-a-path")
    return path
