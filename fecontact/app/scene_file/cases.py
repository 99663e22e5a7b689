"""Files of the cases of a sweep: a CSV row or a JSON line per case."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fecontact.common.files import write_atomically

CASE_FILES = (".csv", ".jsonl")


def save_cases(path: Path, rows: Sequence[Mapping[str, Any]]) -> Path:
    """Write summaries of cases; the suffix decides."""
    if path.suffix.lower() == ".jsonl":
        return write_atomically(path, "".join(json.dumps(row) + "\n" for row in rows))
    text = io.StringIO()
    flat = [flat_row(row) for row in rows]
    writer = csv.DictWriter(text, list(flat[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(flat)
    return write_atomically(path, text.getvalue())


def flat_row(row: Mapping[str, Any]) -> dict[str, Any]:
    """Figures of a case by column, with the name of the contact, body or spring.

    Examples
    --------
    >>> contact = {"slave": "a", "master": "b", "force": [0, 0, 1], "area": 2.0, "max_pressure": 1.0,
    ...            "mean_pressure": 0.5, "regions": 1}
    >>> body = {"name": "a", "motion": [0.0] * 6}
    >>> springs = [{"name": "s", "tension": 3.0}]
    >>> row = {"name": "0", "status": "solved", "contacts": [contact], "springs": springs, "residuals": {"x": 1e-9}}
    >>> list(flat_row(row))[:4]
    ['name', 'status', 'a on b: force x', 'a on b: force y']
    """
    out: dict[str, Any] = {"name": row["name"], "status": row["status"]}
    for contact in row["contacts"]:
        head = f"{contact['slave']} on {contact['master']}"
        out.update({f"{head}: force {axis}": v for axis, v in zip("xyz", contact["force"], strict=True)})
        out.update(
            {f"{head}: {key.replace('_', ' ')}": contact[key] for key in ("area", "max_pressure", "mean_pressure")}
        )
        out[f"{head}: regions"] = contact["regions"]
    out.update({f"{spring['name']}: tension": spring["tension"] for spring in row["springs"]})
    out["largest residual"] = max(row["residuals"].values())
    return out


def table_of(rows: Sequence[Mapping[str, Any]]) -> str:
    """A short table for the screen."""
    lines = [f"{'case':<16}{'contact':<24}{'force':>14}{'area':>14}{'max pressure':>14}{'regions':>9}"]
    for row in rows:
        for contact in row["contacts"]:
            force = sum(v**2 for v in contact["force"]) ** 0.5
            lines.append(
                f"{row['name']:<16}{contact['slave'] + ' on ' + contact['master']:<24}{force:>14.6g}"
                f"{contact['area']:>14.6g}{contact['max_pressure']:>14.6g}{contact['regions']:>9d}"
            )
    return "\n".join(lines)
