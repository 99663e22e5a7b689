"""ANCF motions for ParaView: one VTU file per frame and a PVD file that lists them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import meshio
import numpy as np

from fecontact.ancf.assembly import Assembly
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.files import check_writable, replacing, write_collection
from fecontact.fem.stress import von_mises


def save_motion(assembly: Assembly, frames: Sequence[Array], path: str | Path, times: Sequence[float]) -> Path:
    """Write coordinates at several times as a series.

    Every cell is written separately with twenty nodes, to show its curved edges.

    Parameters
    ----------
    assembly : Assembly
    frames : sequence of (n_dofs,) arrays
        Such as `Motion.frames`, or the q of the states of a `Path`.
    path : str or Path
        Ends in ``.pvd``.
    times : sequence of float
        One for each frame.

    Raises
    ------
    InputError
        For another suffix, no frame, or a number of times other than that of the frames.
    """
    path = check_writable(path)
    if path.suffix.lower() != ".pvd":
        raise InputError(f"A series is written to a .pvd file; found {path.name!r}.")
    if not len(frames) or len(frames) != len(times):
        raise InputError(f"A series needs frames and one time for each; found {len(frames)} and {len(times)}.")
    files = []
    for k, q in enumerate(frames):
        files.append(path.with_name(f"{path.stem}_{k:04d}.vtu"))
        with replacing(files[-1]) as partial:
            _mesh(assembly, q).write(partial, file_format="vtu")
    return write_collection(path, files, [float(t) for t in times])


def _mesh(a: Assembly, q: Array) -> meshio.Mesh:
    """Deformed cells of all solids with displacement and equivalent Cauchy stress."""
    drawn = [s.drawn(a.part(q, k)) for k, s in enumerate(a.solids)]
    first = np.cumsum([0] + [len(d.points) for d in drawn])
    data = {
        "displacement": np.concatenate([d.points - d.start for d in drawn]),
        "von_mises": von_mises(np.concatenate([d.stress for d in drawn])),
    }
    return meshio.Mesh(
        np.concatenate([d.points for d in drawn]),
        [(d.kind, d.cells + start) for d, start in zip(drawn, first, strict=False)],
        point_data=data,
        cell_data={"body": [np.full(len(d.cells), k) for k, d in enumerate(drawn)]},
    )
