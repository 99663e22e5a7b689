"""Files of contacts on half-spaces."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.bodies.halfspace.grid import Grid
from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.files import check_writable, replacing, save_json


def save_fields(path: str | Path, grid: Grid, fields: Mapping[str, Array], summary: Mapping[str, Any]) -> Path:
    """Write fields (nx, ny) on the cells of a grid, or a summary; the suffix decides.

    Parameters
    ----------
    path : str or Path
        .json (the summary), .csv (one row per cell) or .npz (arrays, with x and y of the cells).
    grid : Grid
    fields : mapping of name to (nx, ny) array
    summary : mapping

    Raises
    ------
    InputError
        For another suffix, or a file that cannot be written.
    """
    path = check_writable(path)
    among("suffix of a file of a half-space", suffix := path.suffix.lower(), (".json", ".csv", ".npz"))
    if suffix == ".json":
        return save_json(path, dict(summary))
    with replacing(path) as file:
        if suffix == ".npz":
            np.savez_compressed(file, allow_pickle=False, x=grid.x, y=grid.y, **fields)
        else:
            x, y = np.meshgrid(grid.x, grid.y, indexing="ij")
            table = np.column_stack([x.ravel(), y.ravel(), *(values.ravel() for values in fields.values())])
            np.savetxt(file, table, "%.17g", ",", header=",".join(["x", "y", *fields]), comments="")
    return path
