"""Result of a problem of slender beams."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from fecontact.app.slender.figures import SlenderFigures
from fecontact.app.slender.picture import plot_shapes


class SlenderProblem(SlenderFigures):
    """Figures, with a method to draw them."""

    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw the shapes, written to `path` if given."""
        return plot_shapes(self, path)
