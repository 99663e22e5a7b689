"""What measured rows tell: the cheapest run for an error, other programs beside it, and sentences about both."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

from compare.picture import TARGETS
from compare.table import Row, curves, error_of

#: Error at which the package is compared with other programs.
PEER_TARGET = 0.015


def cheapest(rows: Iterable[Row], target: float) -> Row | None:
    """The measured run with the fewest CPU seconds among those whose pressure error is at most the target."""
    good = [row for row in rows if not row["failed"] and error_of(row) <= target]
    return min(good, key=lambda row: row["seconds"], default=None)


def quickest(rows: Iterable[Row], target: float) -> tuple[str, float] | None:
    """The method that reaches an error soonest and its CPU seconds, in logarithms between two runs of it."""
    found = {method: _seconds_at(runs, target) for method, runs in curves(rows).items()}
    reached = {method: seconds for method, seconds in found.items() if seconds is not None}
    return min(reached.items(), key=lambda item: item[1], default=None)


def _seconds_at(rows: Sequence[Row], target: float) -> float | None:
    runs = [(error_of(row), float(row["seconds"])) for row in rows]
    seconds = [t for e, t in runs if e <= target]
    for (e, t), (finer, longer) in pairwise(runs):
        if e > target > finer > 0:
            seconds.append(t * (longer / t) ** (math.log(e / target) / math.log(e / finer)))
    return min(seconds, default=None)


def sentence(rows: Sequence[Row]) -> str:
    """Which method is the cheapest for each error: of all of ours, and of those for bodies of any shape in space."""
    ours = [row for row in rows if not row["peer"]]
    parts = []
    for target in TARGETS:
        best = cheapest(ours, target)
        solid = cheapest([row for row in ours if row["kind"] == "solid"], target)
        text = f"For {_percent(target)}, "
        if best is None:
            least = min((row for row in ours if not row["failed"]), key=error_of, default=None)
            text += "none" + ("" if least is None else f" (the least is {_run(least)})")
        else:
            text += _run(best)
            if best["kind"] != "solid":
                reached = "none reaches it" if solid is None else _run(solid)
                text += f"; of bodies of any shape, {reached}"
        parts.append(text)
    return "The cheapest by pressure error. " + ". ".join(parts) + "."


def against_peers(rows: Sequence[Row], target: float = PEER_TARGET) -> str:
    """How much faster we are than the best other program at an error, bodies of any shape and half-spaces apart."""
    told = []
    for kind, noun in (("solid", "bodies of any shape"), ("half-space", "half-spaces")):
        theirs = [row for row in rows if row["peer"] and row["kind"] == kind and not row["failed"]]
        if not theirs:
            continue
        us = quickest([row for row in rows if not row["peer"] and row["kind"] == kind], target)
        them = quickest(theirs, target)
        if us is None:
            told.append(f"Of {noun}, none of ours reaches {_percent(target)}.")
        elif them is None:
            near = min(theirs, key=error_of)
            told.append(
                f"Of {noun}, no other program reached {_percent(target)} here: the nearest is {_run(near)}, "
                f"{near['seconds'] / us[1]:.1f} times as long as {_percent(target)} here, {us[0]} ({us[1]:.3g} s)."
            )
        else:
            told.append(
                f"Of {noun}, {_percent(target)} takes the fastest other program {them[1] / us[1]:.2g} times as long as "
                f"it takes here: {them[1]:.3g} s, {them[0]}, against {us[1]:.3g} s, {us[0]} (between runs, where none "
                "has just this error)."
            )
    return " ".join(told)


def _run(row: Row) -> str:
    return f"{row['method']} ({row['seconds']:.3g} s, {_percent(error_of(row))})"


def _percent(value: float) -> str:
    return f"{100 * value:.2g} %"
