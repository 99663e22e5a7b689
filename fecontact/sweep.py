"""Many load cases and poses on the same bodies: one condensation, one row per case, nothing lost on the way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from fecontact.bodies.elastic import ElasticBody
from fecontact.errors import InputError
from fecontact.fem.model import Model
from fecontact.jsonlines import append_row, read_rows
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
    done = {} if path is None else read_rows(path, "name", "a row of a sweep")
    left = {name: _posed(scene, case) for name, case in named.items() if name not in done}
    _condense_all(left)
    for name, (now, arguments) in tqdm(left.items(), desc="sweep", unit="case", disable=None):
        row = {"name": name, **now.scene.solve(**arguments).summary()}
        done[name] = row
        if path is not None:
            append_row(path, row)
    return [done[name] for name in named]


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
