"""Studies of slender beams: angles or deflections beside known ones, and the shapes on the way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure as Picture

from fecontact.app.studies.study import Study, finite
from fecontact.common.arrays import Array
from fecontact.common.table import Column, Table
from fecontact.common.units import Units


def slender_study(
    name: str,
    unit: str,
    n: int,
    cases: Mapping[str, tuple[float, float]],
    shapes: Mapping[str, Array],
    seconds: float,
    remarks: Mapping[str, float] | None = None,
    beside: Mapping[str, Sequence[float]] | None = None,
) -> Study:
    """A study of beams.

    Parameters
    ----------
    name, unit : str
    n : int
        Elements.
    cases : mapping of str to (float, float)
        Figure found and known figure, whose errors are differences.
    shapes : mapping of str to (m, 3) array
        Points of the axis, to draw.
    seconds : float
        Of the solution, without the other procedures.
    remarks : mapping of str to float, optional
    beside : mapping of str to sequence of float, optional
        The same figures by other procedures; NaN where they have none.
    """
    remarks, beside = remarks or {}, beside or {}
    others = [{name: values[k] for name, values in beside.items()} for k in range(len(cases))]
    error = max(abs(found - known) for found, known in cases.values())
    both = list(zip(cases.items(), map(finite, others), strict=True))
    data = [{"case": case, "found": found, "known": known, **other} for (case, (found, known)), other in both]
    head = {"problem": name, "elements": n, "unit": unit, "seconds": seconds}
    columns: list[Column | str] = ["case", "found", "known", Column("error", "+.1e")]
    columns += [Column(other, blank="-") for other in beside]
    rows = [(case, found, known, found - known, *other.values()) for (case, (found, known)), other in both]
    title = f"{name}, {n} elements"

    def draw(_: Units) -> Picture:
        picture = Picture(figsize=(7.0, 5.4), layout="constrained")
        axes = picture.subplots()
        colours = colormaps["viridis"](np.linspace(0, 0.9, len(shapes)))
        for (label, points), colour in zip(shapes.items(), colours, strict=True):
            axes.plot(points[:, 0], points[:, 1], color=colour, label=label)
        axes.set_aspect("equal")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.set_title(f"{title}, largest error {error:.2g} {unit}")
        axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
        return picture

    notes = [*(f"{remark}: {value:.3g}" for remark, value in remarks.items()), f"{seconds:.2f} s"]
    everything = {**head, "cases": data, "error": error, **remarks}
    return Study(f"{title} [{unit}]", {}, Table(columns, rows), draw, everything, notes=notes)
