"""Many load cases and poses on the same bodies: one condensation, one row per case, nothing lost on the way."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from fecontact.bodies.elastic import ElasticBody
from fecontact.errors import InputError
from fecontact.fem.model import Model
from fecontact.io import check_writable
from fecontact.loading import make_loading
from fecontact.moved import KEYED, Moved, moved
from fecontact.stopwatch import Stopwatch

if TYPE_CHECKING:
    from fecontact.scene import Scene


def run_sweep(scene: Scene, cases: Sequence[Mapping[str, Any]], path: str | Path | None = None) -> list[dict[str, Any]]:
    """Solve all cases.

    All of them are paired first, and every model is condensed once onto the candidates of all cases together.

    Parameters
    ----------
    scene : Scene
    cases : sequence of mappings
        Arguments of `Scene.solve`, and optionally ``name`` (a number otherwise) and ``poses``, a mapping of Body to
        Pose.
    path : str or Path, optional
        File of JSON lines, one per case, written as cases are done. Cases whose name it already holds are not solved
        again, so an interrupted sweep goes on where it stopped.

    Returns
    -------
    list of dict
        `ContactResult.summary` of each case with its ``name``, in the order of the cases.

    Raises
    ------
    InputError
        If two cases have one name or the file is not of this kind.
    """
    named = {str(case.get("name", k)): case for k, case in enumerate(cases)}
    if len(named) != len(cases):
        raise InputError("Two cases of the sweep have the same name; names tell the rows apart.")
    done = _read(path)
    left = {name: _posed(scene, case) for name, case in named.items() if name not in done}
    _condense_all(left)
    for name, (now, arguments) in tqdm(left.items(), desc="sweep", unit="case", disable=None):
        row = {"name": name, **now.scene.solve(**arguments).summary()}
        done[name] = row
        if path is not None:
            with Path(path).open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
    return [done[name] for name in named]


def _read(path: str | Path | None) -> dict[str, dict[str, Any]]:
    """Rows of an earlier, perhaps interrupted run; a last line that was cut off is dropped."""
    if path is None:
        return {}
    path = check_writable(path)
    if not path.exists():
        return {}
    rows: dict[str, dict[str, Any]] = {}
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    for k, line in enumerate(lines):
        try:
            row = json.loads(line)
            rows[row["name"]] = row
        except (json.JSONDecodeError, KeyError, TypeError) as error:
            if k == len(lines) - 1 and not line.endswith("\n"):
                path.write_text("".join(lines[:-1]), encoding="utf-8")
                break
            raise InputError(f"Line {k + 1} of {path} is not a row of a sweep; choose another file.") from error
    return rows


def _posed(scene: Scene, case: Mapping[str, Any]) -> tuple[Moved, dict[str, Any]]:
    arguments = {k: v for k, v in case.items() if k not in ("name", "poses")}
    now = moved(scene, case.get("poses") or {})
    return now, now.loads(arguments)


def _condense_all(left: Mapping[str, tuple[Moved, dict[str, Any]]]) -> None:
    """Condense every model once onto what all cases may need."""
    nodes: dict[int, list[NDArray[np.int64]]] = {}
    models: dict[int, Model] = {}
    for now, arguments in left.values():
        keyed = {name: arguments.get(name) for name in (*KEYED, "gravity")}
        loading = make_loading(now.scene.bodies, **keyed)
        conditions, _, chosen = now.scene.prepared(loading)
        for body in now.scene.bodies:
            if not isinstance(body, ElasticBody) or body.model is None:
                continue
            models[id(body.model)] = body.model
            for condition, c in zip(conditions, chosen, strict=True):
                rows = condition.rows(body)
                if rows is not None:
                    nodes.setdefault(id(body.model), []).append(body.model.touched(rows[c]))
    for key, found in nodes.items():
        models[key].condensed(np.unique(np.concatenate(found)), Stopwatch())
