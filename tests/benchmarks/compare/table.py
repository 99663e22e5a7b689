"""Tables of runs with their errors: aligned text, markdown and CSV, with the orders of convergence.

A row is one run: 'method', 'setting', 'dofs', 'candidates', 'errors' (a mapping), 'residual', 'seconds' (of the
processor), 'wall', 'repeats', 'peak_mb', 'threads', 'machine', and 'failed' (None, or why there are no figures).
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.common.files import write_atomically

Row = dict[str, Any]

#: Errors that a row may have, with their names in tables.
ERRORS = {
    "pressure_l2": "pressure L2",
    "centre_pressure": "centre",
    "edge_radius": "edge",
    "approach": "approach",
    "max_pressure": "largest",
    "area": "area",
}
#: Further columns of a CSV file.
PLAIN = (
    *("problem", "spec", "method", "kind", "peer", "setting", "dofs", "candidates", "residual", "seconds"),
    *("wall", "repeats", "peak_mb", "threads", "machine", "failed"),
)


def curves(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Rows with figures by method, in order."""
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
    return -_slope([(row[against], error_of(row, what)) for row in rows])


def growth(rows: Sequence[Row], what: str) -> float:
    """Exponent p of 'seconds' or 'peak_mb' ~ dofs^p, as `order`.

    Examples
    --------
    >>> rows = [{"seconds": 2.0 * n**3, "dofs": n**2} for n in (2, 4, 8)]
    >>> round(growth(rows, "seconds"), 12)
    1.5
    """
    return _slope([(row["dofs"], row[what]) for row in rows])


def _slope(pairs: Sequence[tuple[float, float]]) -> float:
    """Slope of the line through logarithms of pairs of positive numbers."""
    x, y = (np.log(v) for v in np.reshape([p for p in pairs if p[0] > 0 and p[1] > 0], (-1, 2)).T)
    return math.nan if len(x) < 2 or np.ptp(x) == 0 else float(np.polyfit(x, y, 1)[0])


def orders(rows: Sequence[Row]) -> list[str]:
    """Orders of the error of one method in dofs and in seconds, as text."""
    return as_text([order(rows, against) for against in ("dofs", "seconds")])


def as_text(rates: Sequence[float]) -> list[str]:
    """Exponents as text."""
    return ["-" if math.isnan(rate) else f"{rate:.2f}" for rate in rates]


def table(rows: Sequence[Row]) -> str:
    """Aligned columns, one row per run; the orders of each method's error at its last."""
    head, *cells = _cells(rows)
    full = [head, *(line for line in cells if len(line) == len(head))]
    widths = [max(len(line[k]) for line in full) for k in range(len(head))]
    widths[:2] = [max(len(line[k]) for line in [head, *cells]) for k in (0, 1)]

    def aligned(line: Sequence[str]) -> str:
        return "  ".join([f"{line[0]:{widths[0]}}", *(f"{v:>{w}}" for v, w in zip(line[1:], widths[1:], strict=False))])

    lines = [aligned(head) + "  order in dofs, seconds"]
    lines.append("-" * len(lines[0]))
    lasts = {id(found[-1]): found for found in curves(rows).values()}
    for row, line in zip(rows, cells, strict=True):
        end = "  " + ", ".join(orders(lasts[id(row)])) if id(row) in lasts else ""
        lines.append(aligned(line) + end)
    return "\n".join(lines)


def save_shown(rows: Sequence[Row], path: str | Path) -> Path:
    """The table as it is shown, without the orders."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(_cells(rows))
    return write_atomically(path, out.getvalue())


def _cells(rows: Sequence[Row]) -> list[list[str]]:
    """Cells of the head and of one line per run; a line without figures ends with the reason."""
    known = {key for row in rows for key, value in (row.get("errors") or {}).items() if value is not None}
    shown = {key: name for key, name in ERRORS.items() if key in known}
    cells = [["method", "setting", "dofs", "points", *shown.values(), "CPU s", "wall s", "MB"]]
    for row in rows:
        line = [row["method"], str(row["setting"])]
        if row["failed"]:
            cells.append([*line, f"no figures: {row['failed']}"])
            continue
        line += ["" if row[key] is None else str(row[key]) for key in ("dofs", "candidates")]
        line += [_percent(row["errors"].get(key), key) for key in shown]
        line += ["" if row[key] is None else f"{row[key]:.3g}" for key in ("seconds", "wall")]
        cells.append([*line, f"{row['peak_mb']:.0f}"])
    return cells


def _percent(value: float | None, key: str) -> str:
    if value is None:
        return ""
    return f"{100 * value:.3g} %" if key == "pressure_l2" else f"{100 * value:+.{1 if abs(value) >= 0.1 else 3}f} %"


def conditions(rows: Sequence[Row]) -> str:
    """Machine, threads and repeats."""
    where = "; ".join(dict.fromkeys(row["machine"] for row in rows))
    threads = ", ".join(dict.fromkeys(str(row["threads"]) for row in rows))
    repeats = {row["repeats"] for row in rows if not row["failed"] and not row["peer"]}
    most = max(repeats, default=0)
    times = {0: "", 1: ", one run each"}.get(most, f", medians of up to {most} runs")
    return f"Processor seconds on {where}; threads: {threads}{times}."


def save_csv(rows: Sequence[Row], path: str | Path) -> Path:
    """One line per run."""
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow([*PLAIN, *ERRORS])
    for row in rows:
        writer.writerow([*(row.get(k) for k in PLAIN), *((row.get("errors") or {}).get(k) for k in ERRORS)])
    return write_atomically(path, out.getvalue())
