"""One line for an object with large contents, as a notebook or a debugger shows it."""

from __future__ import annotations

from collections.abc import Mapping, Sized
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
import scipy.sparse as sp

#: Longest line and longest text of one field, in characters; numbers of an array that are still shown.
LINE, WORD, NUMBERS = 150, 60, 6

T = TypeVar("T")


def compact_repr(cls: type[T]) -> type[T]:
    """Class decorator: `repr` of a dataclass in one line, its arrays by their shapes, its parts by their names.

    Fields that have their defaults are left out, and so is what does not fit in the line.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @compact_repr
    ... @dataclass
    ... class Field:
    ...     name: str
    ...     origin: tuple[float, float]
    ...     values: np.ndarray
    >>> Field("pressure", (0.0, 0.5), np.zeros((300, 3)))
    Field('pressure', origin=(0, 0.5), values=array(300, 3))
    """
    cls.__repr__ = _line  # type: ignore[method-assign]
    return cls


def _line(self: Any) -> str:
    shown = [f for f in fields(self) if f.repr and not _is_default(self, f)]
    words = [_word(f, getattr(self, f.name, None)) for f in sorted(shown, key=lambda f: f.name != "name")]
    fits = 1 + int(np.searchsorted(np.cumsum([len(word) + 2 for word in words]), LINE))
    return f"{type(self).__name__}({', '.join([*words[:fits], *(['...'] if fits < len(words) else [])])})"


def _word(field: Field[Any], value: Any) -> str:
    return repr(value) if field.name == "name" and isinstance(value, str) else f"{field.name}={shortly(value)}"


def _is_default(self: Any, field: Field[Any]) -> bool:
    default = field.default if field.default_factory is MISSING else field.default_factory()
    value = getattr(self, field.name, None)
    return value is default or (not isinstance(value, np.ndarray) and type(value) is type(default) and value == default)


def shortly(value: Any) -> str:
    """A value in at most some sixty characters.

    Examples
    --------
    >>> shortly(np.zeros((4, 3))), shortly([1.0, 2.5]), shortly({"top": "z"}), shortly([np.ones(2)] * 3)
    ('array(4, 3)', '[1, 2.5]', "{'top': 'z'}", '3 x ndarray')
    """
    if sp.issparse(value):
        return f"{type(value).__name__}{value.shape}"
    if isinstance(value, np.ndarray):
        return _numbers(value.tolist()) if value.ndim == 1 and value.size <= NUMBERS else f"array{value.shape}"
    if isinstance(value, np.generic | float):
        return f"{value:.6g}" if isinstance(value, np.floating | float) else repr(value.item())
    if isinstance(value, tuple | list | set | frozenset) and len(value) <= NUMBERS and _plain(value):
        return _numbers(value)
    if isinstance(value, Mapping) and _plain(value) and _plain(value.values()) and len(str(value)) <= WORD:
        return repr(dict(value))
    if isinstance(value, tuple | list | set | frozenset | Mapping):
        kinds = sorted({type(v).__name__ for v in (value.values() if isinstance(value, Mapping) else value)})
        return f"{len(value)} x {' | '.join(kinds)}" if kinds else "none"
    if (is_dataclass(value) or isinstance(value, Sized)) and not isinstance(value, str | bytes | type):
        name = getattr(value, "name", None)
        return f"{type(value).__name__} {name!r}" if isinstance(name, str) else _whole_or_kind(value)
    return _whole_or_kind(value)


def _whole_or_kind(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= WORD and "\n" not in text else type(value).__name__


def _plain(values: Any) -> bool:
    return all(isinstance(v, str | int | float | np.generic | None) for v in values)


def _numbers(values: Any) -> str:
    words = ", ".join(shortly(v) if not isinstance(v, str) else repr(v) for v in values)
    if isinstance(values, tuple):
        return f"({words}{',' if len(values) == 1 else ''})"
    return f"[{words}]" if isinstance(values, list) else f"{{{words}}}"
