"""Tables of a TOML file, read key by key; faults are recorded with their place and reported together."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from fecontact.common.errors import FecontactError, InputError, did_you_mean

Place = tuple[str | int, ...]
Made = TypeVar("Made")

_KEY = r"(?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*')"
_KEYS = rf"{_KEY}(?:\s*\.\s*{_KEY})*"
_HEADER = re.compile(rf"\s*(\[\[?)\s*({_KEYS})\s*\]\]?")
_ENTRY = re.compile(rf"\s*({_KEYS})\s*=")


def listed(names: Iterable[str]) -> str:
    """Names as a list in one line, or 'none'."""
    return ", ".join(names) or "none"


@dataclass(frozen=True, eq=False)
class Faults:
    """Faults of a file, in order of discovery."""

    path: Path
    lines: Mapping[Place, int]
    found: list[tuple[Place, str]] = field(default_factory=list)

    def add(self, place: Place, text: str) -> None:
        """Record a fault."""
        self.found.append((place, text))

    def touched(self, place: Place) -> bool:
        """Whether there is a fault at a place or below it."""
        return any(p[: len(place)] == place for p, _ in self.found)

    def line(self, place: Place) -> int | None:
        """Line of a key, or of the nearest table around it."""
        for n in range(len(place), 0, -1):
            if place[:n] in self.lines:
                return self.lines[place[:n]]
        return None

    def check(self) -> None:
        """Raise an error with all faults.

        Raises
        ------
        InputError
            If there is any.
        """
        if not self.found:
            return
        ordered = sorted(self.found, key=lambda fault: self.line(fault[0]) or 0)
        lines = [f"  {self._where(place)}: {text}" for place, text in ordered]
        count = "one fault" if len(lines) == 1 else f"{len(lines)} faults"
        raise InputError(f"{self.path} has {count}:\n" + "\n".join(lines), code="scene-file")

    def _where(self, place: Place) -> str:
        line = self.line(place)
        name = ""
        for key in place:
            name += f" #{key + 1}" if isinstance(key, int) else f".{key}" if name else key
        return f"line {line}, {name}" if line else name or "the file"


def read_toml(path: str | Path) -> Table:
    """The file as a table.

    Raises
    ------
    InputError
        If it does not exist, cannot be read, or is not TOML; the message gives the line.
    """
    path = Path(path)
    if path.exists() and not path.is_file():
        raise InputError(f"Cannot read {path}: it is a folder or a device.")
    try:
        text = path.read_text(encoding="utf-8-sig")  # with a byte order mark or without
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise InputError(f"Cannot read {path}: {reason}.") from error
    try:
        values = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also numbers of too many digits, and tables too deep
        raise InputError(f"{path} is not valid TOML: {error}.") from error
    return Table(values, (), Faults(path, _lines(text)))


def _lines(text: str) -> dict[Place, int]:
    """Lines of tables and keys, except keys inside inline tables."""
    lines: dict[Place, int] = {}
    count: dict[tuple[str, ...], int] = {}
    inside: Place = ()
    for number, line in enumerate(text.splitlines(), start=1):
        if header := _HEADER.match(line):
            names = _split(header[2])
            inside = names
            if header[1] == "[[":
                lines.setdefault(inside, number)
                inside = (*names, count.get(names, 0))
                count[names] = count.get(names, 0) + 1
            _note(lines, inside, 0, number)
        elif entry := _ENTRY.match(line):
            _note(lines, (*inside, *_split(entry[1])), len(inside), number)
    return lines


def _note(lines: dict[Place, int], place: Place, known: int, number: int) -> None:
    for n in range(known + 1, len(place) + 1):
        lines.setdefault(place[:n], number)


def _split(dotted: str) -> tuple[str, ...]:
    return tuple(key.strip("\"'") for key in re.findall(_KEY, dotted))


class Table:
    """Keys of a table, read one by one; `finish` reports unused ones.

    A method that reads a key returns None if it is missing or wrong, and records the fault.
    """

    def __init__(self, values: Mapping[str, Any], place: Place, faults: Faults) -> None:
        self.values, self.place, self.faults = values, place, faults
        self._asked: dict[str, None] = {}

    def __contains__(self, key: str) -> bool:
        return key in self.values

    def fault(self, key: str | None, text: str) -> None:
        """Record a fault at a key, or at the table itself."""
        self.faults.add(self.place if key is None else (*self.place, key), text)

    @property
    def faulty(self) -> bool:
        """Whether there is a fault in this table or below it."""
        return self.faults.touched(self.place)

    def attempt(self, make: Callable[[], Made], key: str | None = None) -> Made | None:
        """Result of `make`; its refusal is recorded as a fault at the key, or at the table itself."""
        try:
            return make()
        except FecontactError as error:
            self.fault(key, str(error))
            return None

    def finish(self) -> None:
        """Record unknown keys as faults."""
        for key in self.values:
            if key not in self._asked:
                hint = did_you_mean(key, self._asked)
                self.fault(key, f"unknown key{hint}; the keys here are: {listed(self._asked)}.")

    def _take(self, key: str, required: bool) -> Any:
        self._asked[key] = None
        if key not in self.values and required:
            self.fault(key, "is missing.")
        return self.values.get(key)

    def _checked(self, key: str, required: bool, good: Callable[[Any], bool], expected: str) -> Any:
        """A value that is good; another one is a fault."""
        value = self._take(key, required)
        if value is None or good(value):
            return value
        self.fault(key, f"must be {expected}; found {value!r}.")
        return None

    def text(self, key: str, choices: Sequence[str] = (), required: bool = False) -> str | None:
        """A text, one of the choices if there are any."""
        value: str | None = self._checked(key, required, _is_text, "a text in quotation marks")
        if value is None or not choices or value in choices:
            return value
        self.fault(key, f"unknown value {value!r}{did_you_mean(value, choices)}; expected {listed(choices)}.")
        return None

    def number(self, key: str, required: bool = False) -> float | None:
        """A finite number."""
        value = self._checked(key, required, _is_number, "a finite number")
        return None if value is None else float(value)

    def number_or_named(self, key: str, required: bool = False) -> float | dict[str, float] | None:
        """A finite number, or a table of such numbers by name."""
        if not isinstance(self.values.get(key), dict):
            return self.number(key, required)
        named = self.table(key)
        return {name: value for name in named.values if (value := named.number(name)) is not None}

    def integer(self, key: str, required: bool = False) -> int | None:
        """A whole number."""
        found: int | None = self._checked(key, required, _is_integer, "a whole number")
        return found

    def flag(self, key: str, required: bool = False, word: str | None = None) -> bool | str | None:
        """True or false, or a given third word."""
        expected = "true or false" if word is None else f'true, false or "{word}"'
        found: bool | str | None = self._checked(
            key, required, lambda v: isinstance(v, bool) or (word is not None and v == word), expected
        )
        return found

    def numbers(self, key: str, count: int = 3, required: bool = False) -> tuple[float, ...] | None:
        """A list of `count` finite numbers."""
        value = self._checked(
            key, required, lambda v: _is_list(v, _is_number) and len(v) == count, f"a list of {count} numbers"
        )
        return None if value is None else tuple(map(float, value))

    def texts(self, key: str, required: bool = False) -> tuple[str, ...] | None:
        """A text or a list of texts."""
        value = self._checked(
            key, required, lambda v: _is_text(v) or _is_list(v, _is_text), "a text or a list of texts"
        )
        return (value,) if _is_text(value) else None if value is None else tuple(value)

    def raw(self, key: str, required: bool = False) -> Any:
        """The value without a check."""
        return self._take(key, required)

    def table(self, key: str, required: bool = False) -> Table:
        """A nested table; empty if it is missing or wrong."""
        value = self._checked(key, required, _is_table, "a table")
        return Table(value or {}, (*self.place, key), self.faults)

    def tables(self, key: str) -> list[Table]:
        """The tables of ``[[key]]``."""
        value = self._checked(key, False, lambda v: _is_list(v, _is_table), f"tables under [[{key}]]")
        return [Table(v, (*self.place, key, k), self.faults) for k, v in enumerate(value or ())]

    def subtables(self) -> Iterator[tuple[str, Table]]:
        """All keys of this table, each of which must be a table of its own."""
        for key in self.values:
            yield key, self.table(key)

    def read(self, arguments: Arguments) -> dict[str, Any]:
        """The arguments that are given, by name; a name that ends in ! is required."""
        found = {
            name.removesuffix("!"): read(self, name.removesuffix("!"), name.endswith("!"))
            for name, read in arguments.items()
        }
        return {name: value for name, value in found.items() if value is not None}

    def make(self, build: Callable[..., Made], arguments: Arguments, key: str | None = None) -> Made | None:
        """What `build` makes of the arguments, which are all keys of this table; None if there is a fault."""
        given = self.read(arguments)
        self.finish()
        complete = all(name.removesuffix("!") in given for name in arguments if name.endswith("!"))
        return self.attempt(lambda: build(**given), key) if complete and not self.faulty else None


#: Reads a key of a table, which may be required; None if it is missing or wrong.
Reader = Callable[[Table, str, bool], Any]
#: Readers of arguments by name; a name that ends in ! is required.
Arguments = Mapping[str, Reader]


#: Readers of one number, of a whole one, and of true or false.
number, integer, flag = Table.number, Table.integer, Table.flag


def numbers(count: int) -> Reader:
    """A list of given length of finite numbers."""
    return lambda table, key, required: table.numbers(key, count, required)


def choice(choices: Sequence[str] = ()) -> Reader:
    """A text, one of the choices if there are any."""
    return lambda table, key, required: table.text(key, choices, required)


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_table(value: Any) -> bool:
    return isinstance(value, dict)


def _is_integer(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_list(value: Any, good: Callable[[Any], bool]) -> bool:
    return isinstance(value, list) and all(map(good, value))


def _is_number(value: Any) -> bool:
    if not isinstance(value, int | float) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer beyond floating point
        return False
