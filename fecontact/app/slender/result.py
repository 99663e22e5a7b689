"""Result of a problem of slender beams.

Picture of slender beams: their shapes on the way.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from fecontact.app.slender.figures import SlenderFigures
from fecontact.common.files import save_figure


def plot_shapes(found: SlenderFigures, path: str | Path | None = None) -> Figure:
    """Shapes in the plane x, y, coloured in their order."""
    figure = Figure(figsize=(7.0, 5.4), layout="constrained")
    axes = figure.subplots()
    colours = colormaps["viridis"](np.linspace(0, 0.9, len(found.shapes)))
    for (name, points), colour in zip(found.shapes, colours, strict=True):
        axes.plot(points[:, 0], points[:, 1], color=colour, label=name)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_title(f"{found.name}, {found.n} elements, largest error {found.error:.2g} {found.unit}")
    axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    return save_figure(figure, path)


class SlenderProblem(SlenderFigures):
    """Figures, with a method to draw them."""

    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw the shapes, written to `path` if given."""
        return plot_shapes(self, path)
