"""Many load cases and poses on the same bodies: one condensation, one row per case, nothing lost on the way."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from fecontact.bodies.elastic import ElasticBody
from fecontact.errors import InputError
from fecontact.fem.condensation import Schur
from fecontact.fem.model import Model
from fecontact.interface.reach import near_nodes
from fecontact.interface.surface import FacetSurface
from fecontact.jsonlines import append_row, read_rows
from fecontact.loading import Loading, make_loading
from fecontact.moved import KEYED, Moved, moved
from fecontact.springs import spring_rows
from fecontact.stopwatch import Stopwatch

if TYPE_CHECKING:
    from fecontact.scene import Scene

IntArray = NDArray[np.int64]


def run_sweep(
    scene: Scene, cases: Sequence[Mapping[str, Any]], path: str | Path | None = None, processes: int = 1
) -> list[dict[str, Any]]:
    """Solve all cases.

    Every model is condensed once onto what all cases may touch, judged from rough gaps before anything is paired; a
    case that touches more condenses again.

    Parameters
    ----------
    scene : Scene
    cases : sequence of mappings
        Arguments of `Scene.solve`, and optionally ``name`` (a number otherwise) and ``poses``, a mapping of Body to
        Pose.
    path : str or Path, optional
        File of JSON lines, one per case, written as cases are done. Cases whose name it already holds are not solved
        again, so an interrupted sweep goes on where it stopped.
    processes : int
        Worker processes, forked after the condensation so that they share it. Rows are the same whatever the number;
        in the file they stand in the order in which they were done.

    Returns
    -------
    list of dict
        `ContactResult.summary` of each case with its ``name``, in the order of the cases.

    Raises
    ------
    InputError
        If two cases have one name, the file is not of this kind or the number of processes makes no sense.
    """
    named = {str(case.get("name", k)): case for k, case in enumerate(cases)}
    if len(named) != len(cases):
        raise InputError("Two cases of the sweep have the same name; names tell the rows apart.")
    if isinstance(processes, bool) or not isinstance(processes, int) or processes < 1:
        raise InputError(f"processes must be a whole number of at least 1; found {processes!r}.")
    done = {} if path is None else read_rows(path, "name", "a row of a sweep")
    left = {name: _posed(scene, case) for name, case in named.items() if name not in done}
    if left:
        _condense_all(left)
    for name, row in tqdm(_solved(left, processes), total=len(left), desc="sweep", unit="case", disable=None):
        done[name] = row
        if path is not None:
            append_row(path, row)
    return [done[name] for name in named]


Case = tuple[Moved, dict[str, Any]]

#: Cases that the worker processes find in their copy of the memory; models and factors are shared that way.
_CASES: dict[str, Case] = {}


def _row(name: str, case: Case) -> dict[str, Any]:
    now, arguments = case
    return {"name": name, **now.scene.solve(**{"whole": False, **arguments}).summary()}


def _row_of(name: str) -> tuple[str, dict[str, Any]]:
    return name, _row(name, _CASES[name])


def _solved(left: Mapping[str, Case], processes: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Rows as they are done: in order, or from worker processes in the order in which these finish.

    Workers are forks, so that they share the condensed models without copying; every case is solved by itself, so rows
    do not depend on who solves it.
    """
    if processes == 1 or len(left) < 2:
        for name, case in left.items():
            yield name, _row(name, case)
        return
    if "fork" not in multiprocessing.get_all_start_methods():
        raise InputError("Several processes need a system that can fork (Linux, macOS); leave out processes= here.")
    _CASES.update(left)
    try:
        with multiprocessing.get_context("fork").Pool(min(processes, len(left))) as pool:
            yield from pool.imap_unordered(_row_of, left)
    finally:
        for name in left:
            _CASES.pop(name, None)


def _posed(scene: Scene, case: Mapping[str, Any]) -> tuple[Moved, dict[str, Any]]:
    arguments = {k: v for k, v in case.items() if k not in ("name", "poses")}
    now = moved(scene, case.get("poses") or {})
    return now, now.loads(arguments)


def _condense_all(left: Mapping[str, Case]) -> None:
    """Condense every model once onto what all cases may need, and take its compliance, which all of them use."""
    nodes: dict[int, list[IntArray]] = {}
    models: dict[int, Model] = {}
    for now, arguments in left.values():
        keyed = {name: arguments.get(name) for name in (*KEYED, "gravity")}
        loading = make_loading(now.scene.bodies, **keyed)
        for body, touched in _touched(now.scene, loading):
            assert body.model is not None
            models[id(body.model)] = body.model
            nodes.setdefault(id(body.model), []).append(touched)
    for key, found in nodes.items():
        condensation = models[key].condensed(np.unique(np.concatenate(found)), Stopwatch())
        if len(left) > 1 and isinstance(condensation, Schur):
            condensation.invert()


def _touched(scene: Scene, loading: Loading) -> list[tuple[ElasticBody, IntArray]]:
    """Nodes of elastic bodies that the contacts and springs of a case may touch."""
    found: list[tuple[ElasticBody, IntArray]] = []
    for contact in scene.contacts:
        assert contact.surfaces is not None
        bodies = (contact.slave, contact.master)
        surfaces = [b.surface(name) for b, name in zip(bodies, contact.surfaces, strict=True)]
        if not all(type(s) is FacetSurface and not s.eight_hats for s in surfaces):
            return _touched_when_paired(scene, loading)
        found += [
            (body, nodes)
            for body, nodes in zip(bodies, near_nodes(bodies, surfaces, loading), strict=True)  # type: ignore[arg-type]
            if isinstance(body, ElasticBody)
        ]
    return found + _touched_by_springs(scene)


def _touched_by_springs(scene: Scene) -> list[tuple[ElasticBody, IntArray]]:
    if not scene.springs:
        return []
    ligaments = spring_rows(scene.springs)
    rows = [(body, ligaments.rows(body)) for body in scene.bodies if isinstance(body, ElasticBody)]
    return [(body, body.model.touched(r)) for body, r in rows if r is not None and body.model is not None]


def _touched_when_paired(scene: Scene, loading: Loading) -> list[tuple[ElasticBody, IntArray]]:
    """The same from the pairs themselves, where a surface has no facets or no nodes of the usual kind."""
    conditions, _, chosen = scene.prepared(loading)
    return [
        (body, body.model.touched(rows[c]))
        for body in scene.bodies
        if isinstance(body, ElasticBody) and body.model is not None
        for condition, c in zip(conditions, chosen, strict=True)
        if (rows := condition.rows(body)) is not None
    ]
