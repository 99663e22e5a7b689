"""File of a load path: a row of JSON for each step, from which an interrupted path goes on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fecontact.common.errors import InputError
from fecontact.common.fingerprint import fingerprint
from fecontact.common.json_lines import append_row
from fecontact.contact.model import SceneModel
from fecontact.contact.step_end import StepEnd
from fecontact.results.result import ContactResult
from fecontact.scene.sweep_case import fingerprints, finished


def step_prints(
    model: SceneModel, steps: Sequence[Mapping[str, Any]], settings: Mapping[str, Any]
) -> list[dict[str, str]]:
    """Fingerprints of each step: of the model, the settings, its loads, and those of all steps before it."""
    named = {str(k): {**step, **settings} for k, step in enumerate(steps, start=1)}
    out: list[dict[str, str]] = []
    for found in fingerprints(model, named).values():
        out.append({**found, "the steps before": fingerprint(out[-1] if out else None)})
    return out


def rows_before(path: str | Path, prints: Sequence[Mapping[str, str]]) -> list[dict[str, Any]]:
    """Rows of an earlier run, from the first step to the last one without a gap.

    Raises
    ------
    InputError
        If a row is of another model, step or settings.
    """
    named = {str(k): each for k, each in enumerate(prints, start=1)}
    found = finished(path, named, "a step of a load path")
    rows: list[dict[str, Any]] = []
    for name in named:
        if name not in found:
            break
        if not {"end", "since", "parts", "cuts"} <= set(found[name]):
            raise InputError(f"The row {name!r} in {path} is not a step of a load path; choose another file.")
        rows.append(found[name])
    return rows


def append_step(
    path: str | Path,
    name: str,
    prints: Mapping[str, str],
    result: ContactResult,
    cuts: int,
    since: StepEnd | None,
) -> None:
    """Add the row of a step: its summary, what the next one goes on from, and what its last part followed."""
    assert result.step_end is not None
    row = {
        "name": name,
        **result.summary(),
        "parts": [parts and parts.as_dict() for parts in (c.friction and c.friction.earlier for c in result.contacts)],
        "cuts": cuts,
        "end": result.step_end.as_dict(),
        "since": None if since is None else since.as_dict(),
        "fingerprint": prints,
    }
    append_row(path, row)
