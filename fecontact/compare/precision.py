"""What measured rows tell: fitted orders, the cheapest run for an error, and sentences about both."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

Row = dict[str, Any]

#: Pressure errors for which the cheapest method is named.
TARGETS = (0.05, 0.01, 0.001)
#: Error at which the package is compared with other programs.
PEER_TARGET = 0.015


def curves(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Rows with figures by method, in their order."""
    out: dict[str, list[Row]] = {}
    for row in rows:
        if not row["failed"]:
            out.setdefault(row["method"], []).append(row)
    return out


def error_of(row: Row, what: str = "pressure_l2") -> float:
    """Size of an error; NaN if it was not measured."""
    value = row["errors"].get(what)
    return math.nan if value is None else abs(value)


def order(rows: Sequence[Row], against: str, what: str = "pressure_l2") -> float:
    """Exponent p of error ~ against^-p by least squares of the logarithms; NaN from fewer than two different points.

    Examples
    --------
    >>> rows = [{"errors": {"pressure_l2": 1 / n}, "dofs": n**3} for n in (2, 4, 8)]
    >>> round(order(rows, "dofs"), 12)
    0.333333333333
    """
    found = [(row[against], error_of(row, what)) for row in rows]
    x, y = (np.log(v) for v in np.reshape([p for p in found if p[0] > 0 and p[1] > 0], (-1, 2)).T)
    if len(x) < 2 or np.ptp(x) == 0:
        return math.nan
    return -float(np.polyfit(x, y, 1)[0])


def cheapest(rows: Iterable[Row], target: float) -> Row | None:
    """The measured run with the fewest CPU seconds among those whose pressure error is at most the target."""
    good = [row for row in rows if not row["failed"] and error_of(row) <= target]
    return min(good, key=lambda row: row["seconds"], default=None)


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
        us = cheapest([row for row in rows if not row["peer"] and row["kind"] == kind], target)
        them = cheapest(theirs, target)
        if us is None:
            told.append(f"Of {noun}, none of ours reaches {_percent(target)}.")
        elif them is None:
            near = min(theirs, key=error_of)
            told.append(
                f"Of {noun}, no other program reached {_percent(target)} here: the nearest is {_run(near)}, "
                f"{near['seconds'] / us['seconds']:.1f} times as long as {_run(us)}."
            )
        else:
            told.append(
                f"Of {noun}, at {_percent(target)} the fastest other program takes "
                f"{them['seconds'] / us['seconds']:.1f} times as long: {_run(them)}, against {_run(us)}."
            )
    return " ".join(told)


def _run(row: Row) -> str:
    return f"{row['method']} ({row['seconds']:.3g} s, {_percent(error_of(row))})"


def _percent(value: float) -> str:
    return f"{100 * value:.2g} %"
