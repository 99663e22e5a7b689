"""Sweeps: many load cases and poses of the same bodies, with one condensation, one row per case; resumable."""

from __future__ import annotations

import os
import uuid
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, ProcessPoolExecutor, wait
from contextlib import AbstractContextManager
from dataclasses import fields as fields_of
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.bodies.elastic import ElasticBody, elastic_among
from fecontact.common.arguments import file_path, instance, items, spelled
from fecontact.common.arrays import IntArray
from fecontact.common.checks import among, whole
from fecontact.common.errors import InputError, named, shown
from fecontact.common.files import Resumed
from fecontact.common.progress import progress_line
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.loads import Loading
from fecontact.contact.model import SceneModel
from fecontact.contact.search_region import plain_facets
from fecontact.contact.springs import spring_rows
from fecontact.fem.model import Model
from fecontact.results.case_table import CaseTable, Kept, fields_to_keep, plane_of
from fecontact.results.resultants import DividingPlane
from fecontact.scene.engine import for_cases, of_cases, own_engine
from fecontact.scene.finite_strain import is_nonlinear
from fecontact.scene.linear import SEARCHES, prepared
from fecontact.scene.local_search import SearchHistory, near_nodes
from fecontact.scene.sweep_case import (
    Case,
    Posed,
    Solved,
    check_finished,
    collection_of,
    files_of,
    fingerprints,
    loads_of,
    parameters_of,
    solved_case,
    with_files,
)
from fecontact.scene.workers import FreshInterpreters, packed_case, packed_scene, solved_there


@spelled
def run_sweep(
    scene: SceneModel,
    cases: Sequence[Case],
    path: str | Path | None = None,
    processes: int = 1,
    executor: Executor | None = None,
    progress: bool | None = None,
    *,
    keep: str | Sequence[str] = (),
    split: DividingPlane | tuple[ArrayLike, ArrayLike] | None = None,
    save: str | Path | Sequence[str | Path] | None = None,
) -> CaseTable:
    """Solve all cases; with friction, each is one load step from the unloaded state.

    The case with the largest load is solved first. From its contact the nodes that all cases may touch are estimated,
    and every model is condensed onto them once; a case with more candidates condenses again.

    Parameters
    ----------
    scene : SceneModel
    cases : sequence of mappings
        Arguments of `Scene.solve`, and optionally ``name`` (default: a number), ``poses``, a mapping of Body to Pose,
        ``parameters``, a mapping of names to numbers that belong to the case, such as an angle or a time, for columns
        of the table, and ``save``, a list of files for the result: those of `ContactResult.save`, or a picture of the
        pressure (.png, .pdf, .svg). They are written where and when the case is solved.
    path : str or Path, optional
        File of JSON lines, one per case, written as cases are done. Cases already in it are not solved again, so that
        an interrupted sweep is resumed. Every row has a fingerprint of its model, case and settings; a row of the same
        name with another fingerprint is refused.
    processes : int
        Number of concurrent cases. More than one are solved by worker processes on this machine, which are sent the
        scene with its condensed compliance (`scene.workers`). Objects defined in the main script, such
        as a lambda for a rigid surface, are therefore refused. No ``__main__`` guard is needed.
    executor : concurrent.futures.Executor, optional
        Executor that solves the cases: a pool of the standard library (without fork), of loky, of
        ``dask.distributed.Client.get_executor()``, or of mpi4py. The number of concurrent cases is then `processes`, or
        its number of workers if that is 1. It is not shut down.
    progress : bool, optional
        Whether to show cases and stages on standard error; by default where that is a terminal.
    keep : str or sequence of str
        Fields of the contacts that stay in memory for maps, 'pressure', 'gap' or 'friction': about 0.4 kB for every
        facet and field of a case (`results.field_map`). Without them a case takes about 10 kB.
    split : DividingPlane, or (point, normal) in world axes, optional
        Plane by which force, area and peak of every contact are divided, for further columns.
    save : str, Path or a sequence of them, optional
        Files of every case, with ``{name}`` in place of its name, such as "pose_{name}.vtu", besides those of its own.
        A file run.pvd is a collection for ParaView of files run_{name}.vtu, at the cases' parameter ``time`` if they
        have one.

    Returns
    -------
    CaseTable
        As a sequence, `ContactResult.summary` of each case with its ``name``, ``parameters``, ``loads`` and
        ``fingerprint``, in the order of the cases. Results do not depend on the process; figures of the solve
        (candidates, rounds, iterations, seconds, memory) depend on the previous case. Rows of the file are in order of
        completion.

    Raises
    ------
    InputError
        If two cases have the same name, a case has bodies that are not in the scene, cases have different engines, or
        another than 'own' beside processes or an executor, the file is of another kind or of other cases, the number of
        processes is invalid, the scene cannot be sent to other processes, a field or a plane is none, or files of cases
        would be the same.
    """
    cases = [instance("each of the cases", case, Mapping) for case in items("the cases of a sweep", cases, "cases")]
    path = None if path is None else file_path("the path of a sweep", path)
    by_name = {str(case.get("name", k)): case for k, case in enumerate(cases)}
    if len(by_name) != len(cases):
        raise InputError("Two cases of the sweep have the same name; names tell the rows apart.", code="same-name")
    for name, case in by_name.items():
        with _named(name):
            among("search", case.get("search", "local"), SEARCHES)
    by_name = with_files(_with_wishes(scene, by_name, keep, split), save)
    whole("the number of processes", processes)
    if executor is not None and not callable(getattr(executor, "submit", None)):
        raise InputError(f"The executor must have submit, as those of concurrent.futures do; found {shown(executor)}.")
    ranks = of_cases(scene, by_name)
    if ranks and (processes > 1 or executor is not None):
        raise InputError(
            "The engine 'petsc' shares every case between its processes: leave processes and executor out.",
            code="engine-and-processes",
        )
    prints = fingerprints(scene, by_name)
    parameters = {}
    for name, case in by_name.items():
        with _named(name):
            parameters[name] = parameters_of(case)

    def given(name: str) -> dict[str, Any]:
        return {"parameters": parameters[name], "loads": loads_of(by_name[name])}

    file = Resumed(path, prints, "a row of a sweep")
    if (collection := collection_of(save)) is not None:
        check_finished(file.rows, by_name, path)
    maps: dict[str, Kept] = {}
    left = {name: case for name, case in by_name.items() if name not in file.rows}
    rows = _solved(scene, {k: own_engine(c) for k, c in left.items()}, processes, executor) if left else ()
    with (
        file,
        for_cases(scene, ranks if left else None),
        progress_line("sweep", progress, total=len(left), unit="case") as line,
    ):
        for name, (row, maps[name]) in rows:
            line.update()
            file.add(name, {**row, **given(name)})
    contacts = tuple((contact.slave.name, contact.master.name) for contact in scene.contacts)
    table = CaseTable(
        tuple({**file.rows[name], **given(name)} for name in by_name),
        contacts,
        scene.unit_names,
        tuple(maps.get(name, {}) for name in by_name),
    )
    if collection is not None:
        table.save(collection)
    return table


Rows = Iterator[tuple[str, Solved]]


def _with_wishes(scene: SceneModel, cases: Mapping[str, Case], keep: Any, split: Any) -> dict[str, Case]:
    """The cases with the fields that are to be kept of them, and the plane that divides them."""
    fields, plane = fields_to_keep(keep, scene), plane_of(split, scene.bodies)
    more: dict[str, Any] = {"keep": fields} if fields else {}
    if plane is not None:
        more["split"] = {f.name: getattr(plane, f.name) for f in fields_of(plane)}
    for name, case in cases.items():
        if wrong := sorted({"keep", "split"} & set(case)):
            raise InputError(f"Case {name!r} has {', '.join(wrong)}: give it to the sweep, for all cases.")
    return {name: {**case, **more} for name, case in cases.items()}


def _solved(scene: SceneModel, left: Mapping[str, Case], processes: int, executor: Executor | None) -> Rows:
    """Rows in order of completion; the case of the largest load first, to find the nodes that the others may touch.

    The search history of one pose is used as a prediction for the next only: results do not depend on the process.
    """
    posed, loadings = {}, {}
    for name, case in left.items():
        with _named(name):
            files_of(case)
            posed[name] = Posed.of(scene, case)
            loadings[name] = posed[name].loading()
    lead = max(left, key=lambda name: loadings[name].magnitude)
    rest = {name: case for name, case in left.items() if name != lead}
    history = SearchHistory()
    away = bool(rest) and (executor is not None or processes > 1)
    if away:
        # unserialisable objects are refused before any work
        packed_scene(scene, history)
        packed = {name: packed_case(name, case, scene.bodies) for name, case in rest.items()}
    yield lead, _row(scene, lead, left[lead], history)
    as_given = [name for name, case in rest.items() if case.get("accuracy") is None]
    if as_given and not is_nonlinear(scene) and elastic_among(scene.bodies):
        _condense_all({name: (posed[name].scene, loadings[name]) for name in as_given}, history)
    if not away:
        for name, case in rest.items():
            yield name, _row(scene, name, case, history)
    elif executor is None:
        with FreshInterpreters(min(processes, len(rest))) as pool:
            yield from _carried(packed_scene(scene, history), packed, pool, processes)
    else:
        _check_executor(executor)
        yield from _carried(packed_scene(scene, history), packed, executor, _lanes(executor, processes))


def _named(case: str) -> AbstractContextManager[None]:
    return named(f"Case {case!r}")


def _row(scene: SceneModel, name: str, case: Case, history: SearchHistory) -> Solved:
    with _named(name):
        return solved_case(scene, case, history)


def _check_executor(executor: Executor) -> None:
    """Refuse a pool that forks: locks of the numerical libraries' threads would never be released in the children."""
    context = getattr(executor, "_mp_context", None)
    if isinstance(executor, ProcessPoolExecutor) and context is not None and context.get_start_method() == "fork":
        raise InputError(
            "This executor forks its workers, which then wait for ever for threads that were not forked with them; "
            'give it mp_context=multiprocessing.get_context("spawn"), or use processes= instead.',
            code="forking-executor",
        )


def _lanes(executor: Executor, processes: int) -> int:
    """Number of concurrent cases."""
    told = (getattr(executor, name, None) for name in ("_max_workers", "num_workers"))
    return processes if processes > 1 else next((n for n in told if isinstance(n, int) and n > 0), os.cpu_count() or 1)


def _carried(scene: bytes, packed: Mapping[str, bytes], executor: Executor, lanes: int) -> Rows:
    """Rows from an executor. The scene is sent with the first cases and to processes without it."""
    token = uuid.uuid4().hex
    waiting = iter(packed)
    under_way = {executor.submit(solved_there, token, packed[k], scene): k for k in islice(waiting, lanes)}
    try:
        while under_way:
            for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                name = under_way.pop(future)
                with _named(name):
                    row = future.result()
                if row is None:
                    under_way[executor.submit(solved_there, token, packed[name], scene)] = name
                    continue
                for later in islice(waiting, 1):
                    under_way[executor.submit(solved_there, token, packed[later], None)] = later
                yield name, row
    finally:
        for future in under_way:
            future.cancel()


def _condense_all(left: Mapping[str, tuple[SceneModel, Loading]], history: SearchHistory) -> None:
    """Condense every model once onto the nodes of all cases, and form its compliance."""
    nodes: dict[int, list[IntArray]] = {}
    models: dict[int, Model] = {}
    for scene, loading in left.values():
        for body, touched in _touched(scene, loading, history):
            models[id(body.model)] = body.model
            nodes.setdefault(id(body.model), []).append(touched)
    for key, found in nodes.items():
        models[key].condensed(np.unique(np.concatenate(found)), Stopwatch(), poses=len(left)).invert()


def _touched(scene: SceneModel, loading: Loading, history: SearchHistory) -> list[tuple[ElasticBody, IntArray]]:
    """Nodes of elastic bodies that the contacts and springs of a case may touch."""
    found: list[tuple[ElasticBody, IntArray]] = []
    known = history.search_radii or [None] * len(scene.contacts)
    for contact, search_radius in zip(scene.contacts, known, strict=True):
        assert contact.surfaces is not None
        bodies = contact.bodies
        surfaces = plain_facets(bodies, contact.surfaces)
        if surfaces is None:
            return _touched_when_paired(scene, loading)
        found += [
            (body, _triples(body, nodes))
            for body, nodes in zip(
                elastic_among(bodies), near_nodes(bodies, surfaces, loading, search_radius), strict=True
            )
        ]
    return found + _touched_by_springs(scene)


def _triples(body: ElasticBody, nodes: IntArray) -> IntArray:
    """Triples of coordinates that the displacements of nodes (n,) depend on: others than the nodes where some hang."""
    ends = (np.arange(len(nodes)), 3 * nodes)
    return body.model.touched(sp.csr_matrix((np.ones(len(nodes)), ends), shape=(len(nodes), body.n_dofs)))


def _touched_by_springs(scene: SceneModel) -> list[tuple[ElasticBody, IntArray]]:
    if not scene.springs:
        return []
    ligaments = spring_rows(scene.springs)
    rows = [(body, ligaments.rows(body)) for body in elastic_among(scene.bodies)]
    return [(body, body.model.touched(r)) for body, r in rows if r is not None]


def _touched_when_paired(scene: SceneModel, loading: Loading) -> list[tuple[ElasticBody, IntArray]]:
    """The same from the pairs, where a surface has no facets or no nodal displacements."""
    conditions, _, chosen = prepared(scene, loading)
    return [
        (body, body.model.touched(rows[c]))
        for body in elastic_among(scene.bodies)
        for condition, c in zip(conditions, chosen, strict=True)
        if (rows := condition.rows(body)) is not None
    ]
