"""Refinements of a user's scene; the run with the smallest estimated error is the reference."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree
from tqdm import tqdm

from fecontact.app.compare.machine import code, machine, threads_as_set
from fecontact.app.compare.table import Row
from fecontact.app.scene_file.contents import SceneFile
from fecontact.app.scene_file.scene_file import read_scene
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.files import append_row, read_rows
from fecontact.common.fingerprint import fingerprint
from fecontact.common.stopwatch import peak_memory
from fecontact.mesh.shapes import LEVELS

#: Samples per side of a facet; the reference is evaluated at its nearest sample.
SAMPLES = 12
#: Accuracy of the first run of those that divide meshes where the error is.
COARSEST = 0.2


def refined(values: Mapping[str, Any], k: int) -> None:
    """Refine the shapes of a scene's bodies in place: k times the divisions, k - 1 levels more.

    Parameters
    ----------
    values : mapping
        Of the scene file.
    k : int
        1: unchanged.

    Raises
    ------
    InputError
        If no body can be refined, or one not to this level.

    Examples
    --------
    >>> scene = {"bodies": {"a": {"shape": {"kind": "block", "divisions": [2, [0.0, 1.0, 3.0], 1]}}}}
    >>> refined(scene, 2)
    >>> scene["bodies"]["a"]["shape"]["divisions"]
    [4, [0.0, 0.5, 1.0, 2.0, 3.0], 2]
    """
    count = 0
    for body in values.get("bodies", {}).values():
        shape = body.get("shape") if isinstance(body, dict) else None
        if not isinstance(shape, dict) or body.get("type", "elastic") != "elastic":
            continue
        if "divisions" in shape:
            shape["divisions"] = [_divided(d, k) for d in shape["divisions"]]
        elif shape.get("kind") in ("cap", "cylinder", "half_sphere", "quarter_sphere", "sphere"):
            shape["level"] = shape.get("level", 2) + k - 1
            if shape["level"] > max(LEVELS):
                raise InputError(
                    f"Refinement {k} needs level {shape['level']}, but {max(LEVELS)} is the finest: begin with a lower "
                    "level in the scene, or ask for fewer refinements."
                )
        else:
            continue
        count += 1
    if not count:
        raise InputError("No body of the scene has a shape with divisions or a level, so nothing can be refined.")


def _divided(division: Any, k: int) -> Any:
    """A count times k; positions with every interval divided into k."""
    if not isinstance(division, list):
        return division * k
    x = np.asarray(division, dtype=float)
    return np.interp(np.arange(k * (len(x) - 1) + 1) / k, np.arange(len(x)), x).tolist()


def adaptive(values: dict[str, Any], k: int) -> None:
    """Ask for an accuracy in place: 20 %, and half of it for every further run.

    Examples
    --------
    >>> scene = {}
    >>> adaptive(scene, 3)
    >>> scene
    {'solve': {'accuracy': 0.05}}
    """
    values.setdefault("solve", {})["accuracy"] = COARSEST / 2 ** (k - 1)


#: Kinds of refinement, one curve each: changes of the scene file's values for run k = 1, 2, ...
WAYS: Mapping[str, Callable[..., None]] = {"uniform refinement": refined, "divided where the error is": adaptive}


def compare_scene(path: str | Path, refinements: int = 3, rows_path: str | Path | None = None) -> list[Row]:
    """Solve a scene at 1, 2, ... refinements and compare with the one of the smallest estimated error.

    Parameters
    ----------
    path : str or Path
        Scene file; bodies of named shapes are refined, meshes from files stay as they are.
    refinements : int
        At least two.
    rows_path : str or Path, optional
        File of JSON lines with finished runs, which are not repeated; sampled pressures are stored next to it. The
        scene, its mesh files, the package's code, machine and number of threads have to be the same.

    Returns
    -------
    list of dict
        Rows as in `table`; errors are 'pressure_l2', 'max_pressure' and 'area', and those of the run with the most
        degrees of freedom, the reference, are missing.

    Raises
    ------
    InputError
        If nothing in the scene can be refined, it has several cases or no contact, or there are fewer than two
        refinements.
    """
    if refinements < 2:
        raise InputError(f"A scene needs at least 2 refinements, the finest being the reference; found {refinements}.")
    path = Path(path)
    runs = [(way, k, partial(change, k=k)) for way, change in WAYS.items() for k in range(1, refinements + 1)]
    # all are read before the first is solved, to report errors of the finest at once
    keys = [_key(read_scene(path, change=change), way, k) for way, k, change in runs]
    done = {} if rows_path is None else read_rows(rows_path, "key", "a row of a comparison")
    rows: list[Row] = []
    samples: list[list[Array]] = []
    for n, (way, k, change) in enumerate(tqdm(runs, desc=f"compare {path.name}", unit="run", disable=None)):
        beside = None if rows_path is None else Path(rows_path).with_suffix(f".{n + 1}.npz")
        found = _stored(beside, keys[n]) if keys[n] in done else None
        if found is not None:
            row = done[keys[n]]
        else:
            row, found = _solved(path, change)
            row |= {"key": keys[n], "method": way, "setting": k}
            if rows_path is not None and beside is not None:
                np.savez(beside, *found, key=np.array(keys[n]))
                append_row(rows_path, row)
        rows.append(row)
        samples.append(found)
    finest = int(np.argmin([row["estimate"] for row in rows]))
    return [
        row if n == finest else _with_errors(row, samples[n], rows[finest], samples[finest])
        for n, row in enumerate(rows)
    ]


def _key(scene: SceneFile, way: str, k: int) -> str:
    """Key that identifies a run; scenes that cannot be compared are refused."""
    if scene.cases:
        raise InputError(
            f"{scene.path} has {len(scene.cases)} cases, and one is compared: leave [[cases]] out and give its loads "
            "under [loads].",
            code="several-cases",
        )
    if not scene.scene.contacts:
        raise InputError(f"{scene.path} has no contact, so there is no pressure to compare.", code="no-contact")
    return fingerprint(scene.scene, scene.loads, scene.options, way, k, machine(), threads_as_set(), code())


def _stored(beside: Path | None, key: str) -> list[Array] | None:
    """Stored pressures of this run; None if the file now has those of another."""
    if beside is None or not beside.is_file():
        return None
    with np.load(beside) as stored:
        if "key" not in stored or str(stored["key"]) != key:
            return None
        return [stored[name] for name in stored.files if name != "key"]


def _solved(path: Path, change: Callable[[dict[str, Any]], None]) -> tuple[Row, list[Array]]:
    """Figures of one run, and points, pressures and areas (n, 5) sampled on each contact."""
    began, cpu = time.perf_counter(), time.process_time()
    scene = read_scene(path, change=change)
    result = scene.solve()
    seconds, wall = time.process_time() - cpu, time.perf_counter() - began
    row = {
        "problem": path.stem,
        "title": scene.title or path.stem,
        "spec": path.name,
        "kind": "scene",
        "peer": False,
        "dofs": result.n_dofs,
        "candidates": result.n_candidates,
        "residual": result.residuals().worst,
        "seconds": seconds,
        "wall": wall,
        "repeats": 1,
        "peak_mb": peak_memory(),
        "threads": "as set",
        "machine": machine(),
        "failed": None,
        "errors": {},
        "estimate": max((c.error_estimate.pressure for c in result.contacts if c.active.any()), default=0.0),
        "found": {
            "max_pressure": max(c.max_pressure for c in result.contacts),
            "area": sum(c.whole.area for c in result.contacts),
        },
    }
    sampled = [contact.sampled(contact.pressure, SAMPLES) for contact in result.contacts]
    return row, [np.column_stack(fields) for fields in sampled]


def _with_errors(row: Row, samples: Sequence[Array], finest: Row, reference: Sequence[Array]) -> Row:
    """Rows with errors relative to the finest run."""
    miss = norm = 0.0
    for ours, theirs in zip(samples, reference, strict=True):
        _, nearest = cKDTree(theirs[:, :3]).query(ours[:, :3])
        exact = theirs[nearest, 3]
        miss += float(ours[:, 4] @ (ours[:, 3] - exact) ** 2)
        norm += float(ours[:, 4] @ exact**2)
    errors = {"pressure_l2": (miss / norm) ** 0.5 if norm > 0 else 0.0}
    for name, value in row["found"].items():
        if finest["found"][name] > 0:
            errors[name] = value / finest["found"][name] - 1
    return {**row, "errors": errors}
