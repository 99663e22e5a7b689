"""What came of a scene: solved or refused, and whether what it says holds."""

from __future__ import annotations

import json
import re
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from frame import FRAMES, HOME, Frame

import fecontact as fc

PACKAGE = str(Path(fc.__file__).resolve().parent)
#: One scene in so many is solved with every cell divided.
DIVIDED = 20
_NO_NUMBER = re.compile(r"(?<![\w.])(?<!mu )-?(nan|inf)(?![\w])")


@dataclass(frozen=True)
class Answer:
    """Figures of a solved scene, free of units, what it prints, and how well it is posed.

    Attributes
    ----------
    figures : mapping of str to float
        Equal in every frame, relative to the largest of one kind (the word before the first space).
    said : tuple
        Everything that is printed, and mappings for JSON.
    residual : float
        The worst of the certificate.
    same : float
        How well figures of two frames agree; less where the answer is not unique.
    grows : str
        Name of a figure that may not fall with a larger depth; empty: none.
    against : mapping of str to float, optional
        The same figures by another way, such as in Python beside a file.
    errors : mapping of str to float
        Relative errors of some figures as they are estimated, where the mesh is a frame's.
    warned : bool
        Whether a warning says that the mesh is too coarse.
    """

    figures: dict[str, float]
    said: tuple[Any, ...]
    residual: float = 0.0
    same: float = 1e-8
    grows: str = ""
    against: dict[str, float] | None = None
    errors: dict[str, float] = field(default_factory=dict)
    warned: bool = False


@dataclass(frozen=True)
class Door:
    """A way into the package: scenes by number, and the frames in which they may be written."""

    name: str
    build: Callable[[int, Frame], Callable[[], Answer]]
    frames: tuple[str, ...] = ("in other units", "turned about z", "mirrored", "renumbered", "swapped")
    #: residuals above it are no certificate
    certificate: float = 1e-8
    #: one scene in so many is written otherwise
    every: int = 1
    #: scenes that one test takes
    at_once: int = 5


@dataclass
class Outcome:
    """Classes of one scene, in words without numbers; figures beside them."""

    found: dict[str, str] = field(default_factory=dict)

    def add(self, name: str, detail: str = "") -> None:
        self.found.setdefault(name, detail)

    @property
    def faults(self) -> dict[str, str]:
        """What may not be; a refusal or a solution alone is none."""
        return {k: v for k, v in self.found.items() if not k.startswith(("solved", "refused"))}


def solve(door: Door, number: int, frame: Frame, outcome: Outcome) -> Answer | str:
    """The answer, or the refusal; what else happens is noted."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        answer: Answer | str
        try:
            answer = door.build(number, frame)()
        except fc.FecontactError as error:
            answer = f"{type(error).__name__}: {error}"
            if _NO_NUMBER.search(str(error)):
                outcome.add("not a number in a refusal", str(error)[:200])
        except Exception as error:
            frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename.startswith(PACKAGE)]
            where = f"{Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else "in the generator"
            outcome.add(f"FOREIGN {type(error).__name__} at {where}", str(error)[:200])
            answer = f"foreign {type(error).__name__}"
    for warning in caught:
        if issubclass(warning.category, RuntimeWarning):
            outcome.add(f"NumPy warns at {Path(warning.filename).name}:{warning.lineno}", str(warning.message)[:80])
    return answer


def judge(door: Door, number: int, frames: int = 1) -> Outcome:
    """Solve a scene at home and in some of the door's frames, chosen by its number, and compare."""
    outcome = Outcome()
    home = solve(door, number, HOME, outcome)
    if isinstance(home, str):
        outcome.add("refused " + _code(home), home)
    else:
        outcome.add("solved")
        for name, detail in _own_faults(home, door.certificate):
            outcome.add(name, detail)
    for k in range(0 if number % door.every else frames):
        name = door.frames[(number // door.every + k) % len(door.frames)]
        other = solve(door, number, FRAMES[name], outcome)
        if isinstance(home, str) or isinstance(other, str):
            if isinstance(home, str) != isinstance(other, str):
                outcome.add(f"one refused {name}", home if isinstance(home, str) else str(other))
        elif difference := differing(home, other):
            outcome.add(f"differs {name}", difference)
    if isinstance(home, Answer) and home.grows and number % 3 == 0:
        deeper = solve(door, number, replace(HOME, deeper=1.2), outcome)
        if isinstance(deeper, Answer) and deeper.figures[home.grows] < home.figures[home.grows] * (1 - 1e-9):
            outcome.add(
                f"{home.grows} falls with depth", f"{home.figures[home.grows]:.6g} {deeper.figures[home.grows]:.6g}"
            )
    if isinstance(home, Answer) and home.errors and number % DIVIDED == DIVIDED - 1:
        for name, detail in _beside_divided(home, solve(door, number, replace(HOME, divided=1), outcome)):
            outcome.add(name, detail)
    return outcome


def _beside_divided(home: Answer, finer: Answer | str) -> Iterator[tuple[str, str]]:
    """Whether the errors cover half of what every cell divided into eight, or four, changes, or else a warning does."""
    if isinstance(finer, str):
        return
    for name, error in home.errors.items():
        change = abs(finer.figures[name] / home.figures[name] - 1)
        detail = f"{name} {home.figures[name]:.4g} {finer.figures[name]:.4g}: {change:.1%}, told {error:.1%}"
        if error >= change / 2 - 1e-6:
            yield f"solved: error of the {name.split()[0]} covers the change by divided cells", detail
        elif home.warned:
            yield f"solved: change of the {name.split()[0]} by divided cells is covered by a warning", detail
        else:
            yield f"error of the {name.split()[0]} below half of the change by divided cells", detail


def _own_faults(answer: Answer, certificate: float) -> Iterator[tuple[str, str]]:
    if not all(np.isfinite(v) for v in answer.figures.values()):
        yield "a figure is no number", str({k: v for k, v in answer.figures.items() if not np.isfinite(v)})
    if not answer.residual <= certificate:
        yield "certificate", f"{answer.residual:.2g}"
    if answer.against is not None and (other := differing(answer, replace(answer, figures=answer.against))):
        yield "differs from the same in Python", other
    for said in answer.said:
        if isinstance(said, str):
            if word := _NO_NUMBER.search(said):
                yield "prints what is no number", said[max(0, word.start() - 60) : word.end() + 20]
        else:
            try:
                json.dumps(said, allow_nan=False)
            except (ValueError, TypeError) as error:
                yield "a summary is no JSON", str(error)


def differing(one: Answer, other: Answer) -> str:
    """The figure that differs most between two frames, beyond what both allow; or nothing."""
    scale: dict[str, float] = {}
    for name, value in [*one.figures.items(), *other.figures.items()]:
        kind = name.split()[0]
        scale[kind] = max(scale.get(kind, 0.0), abs(value))
    worst, text = 0.0, ""
    for name, value in one.figures.items():
        size = scale[name.split()[0]]
        change = abs(value - other.figures[name]) / size if size > 1e-14 else 0.0
        if not change <= worst:
            worst, text = change, f"{name} {value:.9g} {other.figures[name]:.9g} ({change:.1e})"
    return text if not worst <= max(one.same, other.same) else ""


def _code(refusal: str) -> str:
    """The refusal without names and numbers, short enough to be a class."""
    return re.sub(r"'[^']*'|[-+]?\d[\d.e+-]*|\([^)]*\)", "#", refusal)[:70]
