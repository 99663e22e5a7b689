"""A user's scene solved to several accuracies, each run beside that of the smallest estimated error."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Picture
from matplotlib.ticker import NullFormatter, PercentFormatter
from scipy.spatial import cKDTree

from fecontact.app.scene_file.contents import SceneFile
from fecontact.app.scene_file.scene_file import read_scene
from fecontact.app.studies.study import Study
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.table import Column, Table
from fecontact.results.result import ContactResult

#: Samples per side of a facet; the reference is evaluated at its nearest sample.
SAMPLES = 12
#: Accuracy of the first run; every further one is asked for half of it.
COARSEST = 0.2
#: Columns of the table: names of figures, and their formats.
FIGURES = {
    "accuracy": ".3g", "dofs": "d", "points": "d", "estimate": ".2%", "pressure L2": ".2%", "largest": "+.2%",
    "area": "+.2%", "CPU s": ".3g", "wall s": ".3g",
}  # fmt: skip


def compare_scene(path: str | Path, runs: int = 3) -> Study:
    """Solve a scene to accuracies of 20 %, 10 %, ... and compare with the run of the smallest estimated error.

    Grids of half-spaces, which no accuracy divides, get 1, 2, ... times their cells.

    Parameters
    ----------
    path : str or Path
        Scene file.
    runs : int
        At least two.

    Raises
    ------
    InputError
        If the scene has several cases or no contact, or fewer than two runs are asked for.
    """
    if runs < 2:
        raise InputError(f"A comparison needs at least 2 runs, one being the reference; found {runs}.", code="one-run")
    path = Path(path)
    # all are read before the first is solved
    scenes = [_checked(read_scene(path, change=partial(finer, k=k))) for k in range(1, runs + 1)]
    rows, samples = zip(*map(_solved, scenes), strict=True)
    best = int(np.argmin([row["estimate"] for row in rows]))
    errors = (None if k == best else _errors(samples[k], samples[best]) for k in range(runs))
    figures = [_figures(row, rows[best], error) for row, error in zip(rows, errors, strict=True)]
    title = scenes[0].title or path.stem
    columns = [Column(name, form, blank="-") for name, form in FIGURES.items()]
    note = "Errors are those beside the run without one, whose estimate is the smallest."
    table = Table(columns, [tuple(row.values()) for row in figures], [note])
    return Study(title, {}, table, lambda _: _picture(title, figures), {"title": title, "rows": figures})


def _picture(title: str, rows: Sequence[Mapping[str, Any]]) -> Picture:
    """Estimate and error of the pressure over contact points and over processor seconds."""
    picture = Picture(figsize=(9.0, 3.8), layout="constrained")
    panels = picture.subplots(1, 2, sharey=True)
    for axes, name in zip(panels, ("points", "CPU s"), strict=True):
        for error, style in (("estimate", "o-"), ("pressure L2", "s--")):
            known = [(row[name], row[error]) for row in rows if row[error]]
            axes.loglog(*zip(*known, strict=True), style, label=error)
        axes.set_xlabel(name)
        axes.xaxis.set_minor_formatter(NullFormatter())
        for ticks in (axes.yaxis.set_major_formatter, axes.yaxis.set_minor_formatter):
            ticks(PercentFormatter(1.0, decimals=1))
        axes.grid(True, which="both", alpha=0.25)
    panels[0].set_ylabel("error of the pressure")
    panels[0].legend()
    picture.suptitle(title)
    return picture


def finer(values: dict[str, Any], k: int) -> None:
    """Ask in place for the accuracy of run k, and for k times the cells of half-spaces.

    Parameters
    ----------
    values : dict
        Of the scene file.
    k : int

    Examples
    --------
    >>> scene = {"bodies": {"half": {"type": "half-space", "cells": [32, 64]}}}
    >>> finer(scene, 3)
    >>> scene["bodies"]["half"]["cells"], scene["solve"]
    ([96, 192], {'accuracy': 0.05})
    """
    values.setdefault("solve", {})["accuracy"] = COARSEST / 2 ** (k - 1)
    for body in values.get("bodies", {}).values():
        if isinstance(body, dict) and body.get("type") == "half-space" and "cells" in body:
            body["cells"] = [k * n for n in body["cells"]]


def _checked(file: SceneFile) -> SceneFile:
    """A scene that can be compared."""
    if file.cases or file.steps:
        what = f"{len(file.cases)} cases" if file.cases else f"{len(file.steps)} steps of a load path"
        raise InputError(
            f"{file.path} has {what}, and one solution is compared: leave them out and give loads under [loads].",
            code="several-cases",
        )
    if not file.scene.contacts:
        raise InputError(f"{file.path} has no contact, so there is no pressure to compare.", code="no-contact")
    return file


def _solved(file: SceneFile) -> tuple[dict[str, Any], list[Array]]:
    """Figures of one run, and points, pressures and areas (n, 5) sampled on each contact."""
    began, cpu = time.perf_counter(), time.process_time()
    result = file.solve()
    times = time.process_time() - cpu, time.perf_counter() - began
    sampled = [np.column_stack(contact.sampled(contact.pressure, SAMPLES)) for contact in result.contacts]
    return _row(result, file.options["accuracy"], *times), sampled


def _row(result: ContactResult, accuracy: float, cpu: float, wall: float) -> dict[str, Any]:
    contacts = result.contacts
    return {
        "accuracy": accuracy,
        "dofs": result.n_dofs,
        "points": result.n_candidates,
        "estimate": max((c.error_estimate.pressure for c in contacts if c.active.any()), default=0.0),
        "pressure L2": None,
        "largest": max(c.max_pressure for c in contacts),
        "area": float(sum(c._whole.area for c in contacts)),
        "CPU s": cpu,
        "wall s": wall,
    }


def _figures(row: dict[str, Any], best: Mapping[str, Any], error: float | None) -> dict[str, Any]:
    """A row with relative errors in place of figures."""
    known = {name: row[name] / best[name] - 1 for name in ("largest", "area") if error is not None and best[name] > 0}
    return {**row, "largest": None, "area": None, "pressure L2": error, **known}


def _errors(samples: list[Array], reference: list[Array]) -> float:
    """Relative L2 difference of pressures."""
    miss = norm = 0.0
    for ours, theirs in zip(samples, reference, strict=True):
        _, nearest = cKDTree(theirs[:, :3]).query(ours[:, :3])
        exact = theirs[nearest, 3]
        miss += float(ours[:, 4] @ (ours[:, 3] - exact) ** 2)
        norm += float(ours[:, 4] @ exact**2)
    return (miss / norm) ** 0.5 if norm > 0 else 0.0
