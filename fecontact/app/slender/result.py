"""Result of a problem of slender beams: figures beside known ones, and the shapes on the way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from fecontact.common.arrays import Array
from fecontact.common.files import save_figure


@dataclass(frozen=True, eq=False)
class SlenderProblem:
    """Figures of a problem beside known ones, and the shapes on the way.

    Attributes
    ----------
    name, unit : str
    n : int
        Elements.
    rows : tuple of (str, float, float)
        Case, figure found, known figure.
    remarks : dict of str to float
    shapes : tuple of (str, (m, 3) array)
        Points of the axis, to draw.
    seconds : float
        Of the solution, without what stands beside it.
    beside : dict of str to tuple of float
        The same figures by other procedures; NaN where they have none.
    """

    name: str
    unit: str
    n: int
    rows: tuple[tuple[str, float, float], ...]
    remarks: dict[str, float]
    shapes: tuple[tuple[str, Array], ...]
    seconds: float
    beside: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def error(self) -> float:
        """Largest difference from a known figure."""
        return max(abs(found - known) for _, found, known in self.rows)

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts."""
        cases = [
            {"case": case, "found": found, "known": known} | {name: _number(v[k]) for name, v in self.beside.items()}
            for k, (case, found, known) in enumerate(self.rows)
        ]
        head = {"problem": self.name, "elements": self.n, "unit": self.unit, "seconds": self.seconds}
        return {**head, "cases": cases, "error": self.error, **self.remarks}

    def __str__(self) -> str:
        # names of the procedures beside stand above their columns, in two lines at a comma
        names = [name.partition(", ")[::2] for name in self.beside]
        upper = "".join(f"{first:>15}" for first, _ in names)
        lower = "".join(f"{second:>15}" for _, second in names)
        lines = [f"{self.name}, {self.n} elements [{self.unit}]"]
        lines += [f"  {'':49}{upper}"] if names else []
        lines += [f"  {'':14}{'found':>12}{'known':>12}{'error':>11}{lower}"]
        for k, (case, found, known) in enumerate(self.rows):
            others = "".join(f"{'-' if math.isnan(v[k]) else f'{v[k]:.6g}':>15}" for v in self.beside.values())
            lines.append(f"  {case:14}{found:>12.6g}{known:>12.6g}{found - known:>+11.1e}{others}")
        lines += [f"  {name}: {value:.3g}" for name, value in self.remarks.items()]
        return "\n".join([*lines, f"  {self.seconds:.2f} s"])

    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw the shapes in the plane x, y, coloured in their order, written to `path` if given."""
        figure = Figure(figsize=(7.0, 5.4), layout="constrained")
        axes = figure.subplots()
        colours = colormaps["viridis"](np.linspace(0, 0.9, len(self.shapes)))
        for (name, points), colour in zip(self.shapes, colours, strict=True):
            axes.plot(points[:, 0], points[:, 1], color=colour, label=name)
        axes.set_aspect("equal")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.set_title(f"{self.name}, {self.n} elements, largest error {self.error:.2g} {self.unit}")
        axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
        return save_figure(figure, path)


def _number(value: float) -> float | None:
    """NaN is no number in JSON."""
    return None if math.isnan(value) else value
