"""Runs of a comparison: planned, done one after the other, each kept in a file as soon as it is finished."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tqdm import tqdm

import fecontact
from compare.machine import code, machine
from compare.methods import default_variants, variant
from compare.peers import Peer, ask, environment
from compare.problems import PROBLEMS
from compare.table import Row
from fecontact import InputError
from fecontact.common.files import append_row, read_rows
from fecontact.common.fingerprint import fingerprint

HERE = Path(__file__).parent
#: Modules here that have a part in what is measured; the others show it.
MEASURING = ("bodies.py", "methods.py", "problems.py", "worker.py")


@dataclass(frozen=True)
class Plan:
    """How methods are compared.

    Attributes
    ----------
    problem : str
        One of `PROBLEMS`.
    methods : tuple of str
        Variants as ``name:key=value``, see `methods.variant`; all that solve the problem if empty.
    refinements : int or None
        How many of each method's settings are run, the coarsest first; all unless given.
    repeats : int
        Of each run; the median counts.
    threads : int
    enough : float
        CPU seconds: a run that has taken longer is not repeated, and its method not refined further.
    patience : float
        Wall seconds after which a run is given up.
    """

    problem: str
    methods: tuple[str, ...] = ()
    refinements: int | None = None
    repeats: int = 3
    threads: int = 1
    enough: float = 20.0
    patience: float = 600.0

    def __post_init__(self) -> None:
        if self.problem not in PROBLEMS:
            raise InputError(f"There is no problem {self.problem!r}; expected one of {', '.join(PROBLEMS)}.")
        for what, least in (("repeats", 1), ("threads", 1), ("refinements", 1)):
            value = getattr(self, what)
            if value is not None and (not isinstance(value, int) or value < least):
                raise InputError(f"The number of {what} must be at least {least}; found {value!r}.")
        for what in ("enough", "patience"):
            if not getattr(self, what) > 0:
                raise InputError(f"'{what}' must be a positive number of seconds; found {getattr(self, what)!r}.")
        object.__setattr__(self, "methods", tuple(self.methods) or tuple(default_variants(self.problem)))
        for spec in self.methods:
            variant(spec, self.problem)

    def settings(self, all_settings: Sequence[Any]) -> Sequence[Any]:
        """Those that are to be run."""
        return all_settings[: self.refinements]


def compare(plan: Plan, path: str | Path | None = None, peers: Sequence[Peer] = ()) -> list[Row]:
    """Run what is not yet in the file.

    Parameters
    ----------
    plan : Plan
    path : str or Path, optional
        File of JSON lines, one per run, written as runs are done. Runs that it already holds are not done again, if
        they were made on the same machine with as many threads and repeats, by the same code (this package's, or the
        adapter's and the version of its program), of the same problem.
    peers : sequence of Peer

    Returns
    -------
    list of dict
        One row per run: 'key', 'problem', 'method' (label), 'spec', 'kind', 'peer', 'setting', 'dofs', 'candidates',
        'errors', 'residual', 'seconds', 'wall', 'repeats', 'peak_mb', 'threads', 'machine', 'failed' (None, or why
        there are no figures).

    Raises
    ------
    InputError
        If the file is not of this kind.

    Examples
    --------
    >>> rows = compare(Plan("hertz", ("half-space",), refinements=1, repeats=1))
    >>> rows[0]["dofs"], rows[0]["failed"]
    (1024, None)
    """
    done = {} if path is None else read_rows(path, "key", "a row of a comparison")
    rows: list[Row] = []
    curves = [*_ours(plan), *_theirs(plan, peers)]
    total = sum(len(jobs) for jobs in curves)
    with tqdm(total=total, desc=f"compare {plan.problem}", unit="run", disable=None) as bar:
        for jobs in curves:
            left = len(jobs)
            for job in jobs:
                bar.set_postfix_str(f"{job.row['spec']} {job.row['setting']}")
                row = done.get(job.row["key"])
                if row is None or row["failed"]:
                    row = {**job.row, **job.done()}
                    if path is not None:
                        append_row(path, row)
                rows.append(row)
                bar.update()
                left -= 1
                if row["failed"] or row["seconds"] > plan.enough:
                    break
            bar.update(left)  # finer ones are left out
    return rows


@dataclass(frozen=True)
class _Job:
    """What is known of a run beforehand, and the command that does it."""

    row: Row
    command: list[str]
    env: dict[str, str]
    patience: float

    def done(self) -> Row:
        """Figures of the run, or why there are none."""
        answer = ask(self.command, self.env, self.patience)
        if isinstance(answer, str):
            return {"failed": answer}
        return {"candidates": None, "residual": None, "wall": None, "repeats": 1, **answer, "failed": None}


def _row(plan: Plan, made_by: str, **known: Any) -> Row:
    where = machine()
    key = json.dumps([plan.problem, known["spec"], known["setting"], plan.threads, plan.repeats, where, made_by])
    return {"key": key, "problem": plan.problem, **known, "threads": plan.threads, "machine": where}


def _ours(plan: Plan) -> list[list[_Job]]:
    # the package that runs now, wherever it was imported from
    roots = [str(Path(fecontact.__file__).parents[1]), str(HERE.parent)]
    env = environment(plan.threads)
    env["PYTHONPATH"] = os.pathsep.join([*roots, *filter(None, [env.get("PYTHONPATH")])])
    made_by = fingerprint(code(), [(HERE / name).read_bytes() for name in MEASURING])
    curves = []
    for spec in plan.methods:
        chosen = variant(spec, plan.problem)
        jobs = []
        for setting in plan.settings(chosen.method.settings):
            row = _row(
                plan, made_by, method=chosen.label, spec=spec, kind=chosen.method.kind, peer=False, setting=setting
            )
            job = {
                "problem": plan.problem,
                "spec": spec,
                "setting": setting,
                "repeats": plan.repeats,
                "enough": plan.enough,
            }
            command = [sys.executable, "-m", "compare.worker", json.dumps(job)]
            jobs.append(_Job(row, command, env, plan.patience))
        curves.append(jobs)
    return curves


def _theirs(plan: Plan, peers: Sequence[Peer]) -> list[list[_Job]]:
    env = environment(plan.threads)
    curves = []
    for peer in peers:
        if plan.problem not in peer.problems:
            continue
        jobs = []
        # the sources beside an adapter are what it may import
        beside = [path.read_bytes() for path in sorted(peer.script.parent.glob("_*.py"))]
        made_by = fingerprint(peer.script.read_bytes(), beside, peer.version)
        for setting in plan.settings(peer.settings):
            label = f"{peer.method} {peer.version}"
            row = _row(plan, made_by, method=label, spec=peer.script.stem, kind=peer.kind, peer=True, setting=setting)
            command = [peer.python, str(peer.script), plan.problem, str(setting)]
            jobs.append(_Job(row, command, env, plan.patience))
        curves.append(jobs)
    return curves
