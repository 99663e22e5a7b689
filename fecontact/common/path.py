"""Paths: load steps solved one after the other, with one loop, one halving, one table and one file that resumes.

A kind of bodies says by a `Steps` how it solves a part of a step; `follow` does the rest. Scenes and half-spaces use
it.
"""

from __future__ import annotations

import base64
import zlib
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property, partial
from pathlib import Path as FilePath
from typing import Any, ClassVar, Generic, TypeVar, overload

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError, SolverError, SupportError, named
from fecontact.common.files import Resumed
from fecontact.common.fingerprint import fingerprint
from fecontact.common.progress import progress_line
from fecontact.common.table import Figures, Table

Result = TypeVar("Result")

#: Halvings of a step.
HALVINGS = 5
#: Format of the rows of a file; those of another one are refused.
ROW_FORMAT = 5


def in_parts(
    solve: Callable[[float, float, Result | None], Result],
    last: Result | None,
    halvings: int = HALVINGS,
) -> Iterator[tuple[float, Result]]:
    """Solve a load step in one part, or in halves where a part has no certified solution.

    Parameters
    ----------
    solve : callable
        Function ``solve(start, end, last)`` of the loads at both ends of a part, as shares of a step, and the result
        at its start.
    last : result, optional
        At the start.
    halvings : int
        Largest number of halvings of the step.

    Yields
    ------
    (float, result)
        The end of each part and the result there.

    Raises
    ------
    SolverError
        That of the smallest part. Loads that nothing holds are refused at once.

    Examples
    --------
    >>> def solve(start, end, last):
    ...     if end - start > 0.25 and start < 0.5:
    ...         raise SolverError("too far")
    ...     return f"from {last} to {end}"
    >>> for end, found in in_parts(solve, 0.0):
    ...     print(end, found)
    0.25 from 0.0 to 0.25
    0.5 from from 0.0 to 0.25 to 0.5
    1.0 from from from 0.0 to 0.25 to 0.5 to 1.0
    """
    whole = 2**halvings
    place, length = 0, whole  # in smallest parts
    while place < whole:
        try:
            last = solve(place / whole, (place + length) / whole, last)
        except SolverError as error:
            if isinstance(error, SupportError) or length == 1:
                raise
            length //= 2
            continue
        place += length
        yield place / whole, last
        while length < whole and place % (2 * length) == 0:
            length *= 2


class Steps(Generic[Result]):
    """Load steps of bodies of one kind, for `follow`."""

    #: Largest number of halvings of a step; none where steps do not depend on those before.
    most_halvings: ClassVar = HALVINGS

    def halvings(self, k: int, before: Result | None) -> int:
        """Largest number of halvings of step k, after the result of the step before."""
        return self.most_halvings

    @abstractmethod
    def part(
        self, k: int, before: Result | None, start: float, end: float, last: Result | None, known: Any = None
    ) -> Result:
        """Result of a part of step k, after the result of the step before.

        Its loads are those at two shares of the step, see `in_parts`; the last result is that at the first. A known
        `end` of an earlier run is certified, not solved.
        """

    def end(self, part: Result) -> Any:
        """What `part` needs to know of a result again: a dataclass or mapping of arrays and plain values."""
        return part

    def joined(self, parts: Sequence[Result]) -> Result:
        """Result of a step from those of its parts."""
        return parts[-1]

    def judged(self, k: int, result: Result, last: Result | None, cuts: int) -> Result:
        """Result of step k, solved in some parts, with estimates that need other solutions; it is kept with them."""
        return result

    def row(self, result: Result) -> Mapping[str, Any]:
        """Figures of a result, for people who read the file."""
        return {}

    @abstractmethod
    def prints(self) -> Mapping[str, Mapping[str, str]]:
        """Fingerprints by part of each step by its number, ``"1"`` and so on, of that step alone."""


def follow(
    steps: Steps[Result],
    n: int,
    path: str | FilePath | None = None,
    progress: bool | None = None,
    what: str = "path",
    unit: str = "step",
) -> tuple[tuple[Result, ...], tuple[int, ...]]:
    """Solve n load steps one after the other.

    Parameters
    ----------
    steps : Steps
    n : int
    path : str or Path, optional
        File of JSON lines, a row per step, written as steps are done. Steps already in it are certified, not solved. A
        row of another model, step or history is refused.
    progress : bool, optional
        Whether to show the steps on standard error; by default where that is a terminal.
    what, unit : str
        Names of the path and of a step, for the line of progress and messages.

    Returns
    -------
    results, cuts : tuples
        Results at the ends of the steps, and numbers of parts.

    Raises
    ------
    FecontactError
        With the number of the step, where there are several.
    """
    file = Resumed(path, {} if path is None else _chained(steps.prints()), f"a step of a load {what}")
    known = _first_rows(file)
    done: list[Result] = []
    cuts: list[int] = []
    with file, progress_line(what, progress, total=n, unit=unit) as line:
        for k in range(n):
            last = done[-1] if done else None
            with named(f"{unit.capitalize()} {k + 1} of {n}" if n > 1 else ""):
                solve = partial(steps.part, k, last)
                found = _known(solve, known[k]["parts"], last) if k < len(known) else []
                parts = found or list(in_parts(solve, last, steps.halvings(k, last)))
                result = steps.joined([part for _, part in parts])
                done.append(result if found else steps.judged(k, result, last, len(parts)))
            cuts.append(len(parts))
            if path is not None and not found:
                ends = [*parts[:-1], (1.0, done[-1])]
                kept = [{"end": end, "state": packed(steps.end(part))} for end, part in ends]
                file.add(str(k + 1), {**steps.row(done[-1]), "parts": kept})
            line.update()
    return tuple(done), tuple(cuts)


def _known(
    solve: Callable[..., Result], rows: Sequence[Mapping[str, Any]], last: Result | None
) -> list[tuple[float, Result]]:
    """Parts of a step from their rows of an earlier run."""
    parts: list[tuple[float, Result]] = []
    start = 0.0
    for row in rows:
        last = solve(start, row["end"], last, unpacked(row["state"]))
        start = row["end"]
        parts.append((start, last))
    return parts


def _chained(prints: Mapping[str, Mapping[str, str]]) -> dict[str, dict[str, str]]:
    """Fingerprints of each step with those of all steps before."""
    out: dict[str, dict[str, str]] = {}
    last = None
    for name, found in prints.items():
        out[name] = last = {**found, "format": str(ROW_FORMAT), "the steps before": fingerprint(last)}
    return out


def _first_rows(file: Resumed) -> list[dict[str, Any]]:
    """Rows of an earlier run, from the first step to the last one without a gap.

    Raises
    ------
    InputError
        If a row is none of a step.
    """
    rows: list[dict[str, Any]] = []
    for name in file.prints:
        if name not in file.rows:
            break
        if "parts" not in file.rows[name]:
            raise InputError(
                f"The row {name!r} in {file.path} is not a step of a load path; choose another file.", code="not-a-step"
            )
        rows.append(file.rows[name])
    return rows


def packed(thing: Any) -> Any:
    """Arrays, dataclasses, mappings and sequences of plain values as values of JSON; numbers stay exact.

    Examples
    --------
    >>> found = unpacked(packed({"forces": np.array([[0.1, 0.2]]), "cuts": (1, 2), "none": None}))
    >>> found["forces"], found["cuts"]
    (array([[0.1, 0.2]]), (1, 2))
    """
    if isinstance(thing, np.ndarray):
        values = base64.b64encode(zlib.compress(np.ascontiguousarray(thing).tobytes())).decode()
        return {"dtype": thing.dtype.str, "shape": thing.shape, "values": values}
    if is_dataclass(thing):
        return {f.name: packed(getattr(thing, f.name)) for f in fields(thing)}
    if isinstance(thing, Mapping):
        return {name: packed(value) for name, value in thing.items()}
    if isinstance(thing, tuple | list):
        return [packed(value) for value in thing]
    return thing.item() if isinstance(thing, np.generic) else thing


def unpacked(row: Any) -> Any:
    """What `packed` has written: dataclasses and mappings as dictionaries, sequences as tuples."""
    if isinstance(row, list):
        return tuple(unpacked(value) for value in row)
    if not isinstance(row, dict):
        return row
    if set(row) == {"dtype", "shape", "values"}:
        values = zlib.decompress(base64.b64decode(row["values"]))
        return np.frombuffer(values, row["dtype"]).reshape(row["shape"]).copy()
    return {name: unpacked(value) for name, value in row.items()}


@dataclass(frozen=True, eq=False, repr=False)
class Path(Figures, Sequence[Result]):
    """Results at the ends of load steps; as a sequence it is that of the results.

    Attributes
    ----------
    steps : tuple
    cuts : tuple of int
        Parts in which every step was solved.
    """

    steps: tuple[Result, ...]
    cuts: tuple[int, ...]

    def __len__(self) -> int:
        """Number of steps."""
        return len(self.steps)

    @overload
    def __getitem__(self, k: int) -> Result: ...

    @overload
    def __getitem__(self, k: slice) -> tuple[Result, ...]: ...

    def __getitem__(self, k: int | slice) -> Result | tuple[Result, ...]:
        """Result of a step, or some of the results."""
        return self.steps[k]

    @property
    def last(self) -> Result:
        """Result at the end of the path."""
        return self.steps[-1]

    @abstractmethod
    def rows(self) -> Sequence[Mapping[str, Any]]:
        """Figures of each step by name."""

    @cached_property
    def figures(self) -> Mapping[str, Array]:
        """Columns (n_steps,) of the figures by name."""
        rows = self.rows()
        return {name: np.array([row[name] for row in rows]) for name in rows[0]}

    @staticmethod
    def _first_warnings(places: Iterable[str], texts: Iterable[Sequence[str]]) -> tuple[str, ...]:
        """Warnings of the steps, each with the first place that it concerns."""
        first: dict[str, str] = {}
        for place, told in zip(places, texts, strict=True):
            for text in told:
                first.setdefault(text, place)
        return tuple(f"{place}: {text}" for text, place in first.items())

    def save(self, path: str | FilePath) -> FilePath:
        """Write a CSV file, a row per step.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        return Table(list(self.figures), np.stack(list(self.figures.values()), axis=1).tolist()).save(path)


def each_step(name: str, doc: str) -> Any:
    """A property of a `Path`: an attribute of its results, as an array (n_steps, ...)."""
    return property(lambda path: np.array([getattr(step, name) for step in path.steps]), doc=doc)
