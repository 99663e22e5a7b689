"""Figures written to files."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from fecontact.common.checks import among
from fecontact.common.files import replacing


def save_figure(figure: Figure, path: str | Path | None) -> Figure:
    """Write a figure if a path is given.

    Raises
    ------
    InputError
        If the suffix is no format of pictures, or the file cannot be written.
    """
    if path is not None:
        with replacing(path) as file:
            known = figure.canvas.get_supported_filetypes()
            among("format of a picture", Path(path).suffix.removeprefix("."), known)
            figure.savefig(file, dpi=150)
    return figure
