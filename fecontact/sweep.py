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
from fecontact.finite import follow
from fecontact.interface.reach import near_nodes, plain_facets
from fecontact.jsonlines import append_row, read_rows
from fecontact.loading import Loading, make_loading
from fecontact.moved import KEYED, Moved, moved
from fecontact.partly import Guide, solve_guided
from fecontact.springs import spring_rows
from fecontact.stopwatch import Stopwatch

if TYPE_CHECKING:
    from fecontact.scene import Scene

IntArray = NDArray[np.int64]


def run_sweep(
    scene: Scene, cases: Sequence[Mapping[str, Any]], path: str | Path | None = None, processes: int = 1
) -> list[dict[str, Any]]:
    """Solve all cases.

    The case with the largest load is solved first. What it touches tells what all cases may touch, onto which every
    model is then condensed once; a case that touches more condenses again.

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
        Worker processes, forked after the condensation so that they share it. Answers are the same whatever the
        number; what a row says of the way there (candidates, rounds, seconds) depends on the case solved before. In
        the file rows stand in the order in which they were done.

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
    for name, row in tqdm(
        _solved(left, processes) if left else (), total=len(left), desc="sweep", unit="case", disable=None
    ):
        done[name] = row
        if path is not None:
            append_row(path, row)
    return [done[name] for name in named]


Case = tuple[Moved, dict[str, Any]]

#: Cases that the worker processes find in their copy of the memory; models and factors are shared that way.
_CASES: dict[str, Case] = {}
#: What a process knows from the case it has solved last; it starts with what the parent knows.
_GUIDE = Guide()


def _row(name: str, case: Case, guide: Guide) -> dict[str, Any]:
    now, arguments = case
    arguments = {"whole": False, **arguments}
    finite = arguments.get("finite_motion", "auto")
    if arguments["whole"] or finite is True:
        return {"name": name, **now.scene.solve(**arguments).summary()}
    small = {key: given for key, given in arguments.items() if key not in ("whole", "finite_motion")}
    result = solve_guided(now.scene, small, guide)
    if finite == "auto":
        result = follow(result, {**small, "whole": False})
    return {"name": name, **result.summary()}


def _row_of(name: str) -> tuple[str, dict[str, Any]]:
    return name, _row(name, _CASES[name], _GUIDE)


def _solved(left: Mapping[str, Case], processes: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Rows as they are done: the case of the largest load first, as it tells what the others may touch.

    Workers are forks, so that they share the condensed models without copying. What a process has found for one pose
    tells it where to look in the next, and no more: answers do not depend on who finds them.
    """
    if processes > 1 and "fork" not in multiprocessing.get_all_start_methods():
        raise InputError("Several processes need a system that can fork (Linux, macOS); leave out processes= here.")
    loadings = {name: _loading(case) for name, case in left.items()}
    lead = max(left, key=lambda name: loadings[name].magnitude)
    guide = Guide()
    yield lead, _row(lead, left[lead], guide)
    rest = {name: case for name, case in left.items() if name != lead}
    if not rest:
        return
    _condense_all(rest, loadings, guide)
    if processes == 1 or len(rest) < 2:
        for name, case in rest.items():
            yield name, _row(name, case, guide)
        return
    _CASES.update(rest)
    _GUIDE.reaches = guide.reaches
    try:
        with multiprocessing.get_context("fork").Pool(min(processes, len(rest))) as pool:
            yield from pool.imap_unordered(_row_of, rest)
    finally:
        for name in rest:
            _CASES.pop(name, None)


def _loading(case: Case) -> Loading:
    now, arguments = case
    return make_loading(now.scene.bodies, **{name: arguments.get(name) for name in (*KEYED, "gravity")})


def _posed(scene: Scene, case: Mapping[str, Any]) -> tuple[Moved, dict[str, Any]]:
    arguments = {k: v for k, v in case.items() if k not in ("name", "poses")}
    now = moved(scene, case.get("poses") or {})
    return now, now.loads(arguments)


def _condense_all(left: Mapping[str, Case], loadings: Mapping[str, Loading], guide: Guide) -> None:
    """Condense every model once onto what all cases may need, and take its compliance, which all of them use."""
    nodes: dict[int, list[IntArray]] = {}
    models: dict[int, Model] = {}
    for name, (now, _) in left.items():
        for body, touched in _touched(now.scene, loadings[name], guide):
            assert body.model is not None
            models[id(body.model)] = body.model
            nodes.setdefault(id(body.model), []).append(touched)
    for key, found in nodes.items():
        condensation = models[key].condensed(np.unique(np.concatenate(found)), Stopwatch(), often=True)
        if isinstance(condensation, Schur):
            condensation.invert()


def _touched(scene: Scene, loading: Loading, guide: Guide) -> list[tuple[ElasticBody, IntArray]]:
    """Nodes of elastic bodies that the contacts and springs of a case may touch."""
    found: list[tuple[ElasticBody, IntArray]] = []
    known = guide.reaches or [None] * len(scene.contacts)
    for contact, reach in zip(scene.contacts, known, strict=True):
        assert contact.surfaces is not None
        bodies = (contact.slave, contact.master)
        surfaces = plain_facets(bodies, contact.surfaces)
        if surfaces is None:
            return _touched_when_paired(scene, loading)
        found += [
            (body, nodes)
            for body, nodes in zip(bodies, near_nodes(bodies, surfaces, loading, reach), strict=True)
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
