"""Files: results to VTU (ParaView), JSON (scripts) and CSV (spreadsheets)."""

from __future__ import annotations

import csv
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import meshio
import numpy as np
from numpy.typing import NDArray

from fecontact.bodies.elastic import ElasticBody
from fecontact.errors import InputError
from fecontact.fem.stress import von_mises
from fecontact.mesh.mesh import CELL_TYPES

if TYPE_CHECKING:
    from fecontact.result import ContactResult

Array = NDArray[np.float64]

#: meshio's names of our cells; our node order is VTK's, so nothing is permuted.
VTK_NAMES = {"hex8": "hexahedron", "hex20": "hexahedron20", "hex27": "hexahedron27"}


def check_writable(path: str | Path) -> Path:
    """Refuse a path that cannot be written, before long work.

    Raises
    ------
    InputError
        If the folder does not exist, is no folder, or the file cannot be written.
    """
    path = Path(path)
    folder = path.parent
    if not folder.is_dir():
        raise InputError(
            f"Cannot write {path}: the folder {folder} does not exist. Make it first or choose another path."
        )
    if path.is_dir():
        raise InputError(f"Cannot write {path}: it is a folder.")
    target = path if path.exists() else folder
    if not os.access(target, os.W_OK):
        raise InputError(f"Cannot write {path}: no permission for {target}.")
    return path


def write_atomically(path: str | Path, text: str) -> Path:
    """Write a text file under a temporary name and move it into place, so that an interruption loses nothing."""
    path = check_writable(path)
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
    return path


def save_json(path: str | Path, data: dict[str, Any]) -> Path:
    """Write numbers for scripts; numpy scalars and arrays become plain ones."""
    return write_atomically(path, json.dumps(data, indent=2, default=_plain) + "\n")


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} has no place in a JSON file")


def save_result(result: ContactResult, path: str | Path) -> Path:
    """Write a result; the suffix decides.

    Raises
    ------
    InputError
        If the suffix is unknown or the path cannot be written.
    """
    writers = {".vtu": save_vtu, ".json": lambda r, p: save_json(p, r.summary()), ".csv": save_csv}
    suffix = Path(path).suffix.lower()
    if suffix not in writers:
        raise InputError(f"Unknown file type {suffix!r} for a result; expected one of {', '.join(writers)}.")
    check_writable(path)
    return writers[suffix](result, path)


def save_csv(result: ContactResult, path: str | Path) -> Path:
    """One row per contact point: contact, position, normal, area, force, pressure, gap."""
    path = check_writable(path)
    head = ["contact", "x", "y", "z", "nx", "ny", "nz", "area", "force", "pressure", "gap"]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        for k, c in enumerate(result.contacts):
            table = np.column_stack([c.points, c.normals, c.weights, c.forces, c.pressure, c.gap])
            writer.writerows([k, *map(repr, map(float, row))] for row in table)
    return path


def save_vtu(result: ContactResult, path: str | Path) -> Path:
    """All elastic bodies with displacement, stress, equivalent stress and contact pressure as point data.

    Stresses are in each body's own axes. Mid-face nodes have no place in the file's elements and are left out.
    """
    path = check_writable(path)
    points, number = [], []
    cells: dict[int, list[NDArray[np.int64]]] = {}
    data: dict[str, list[Array]] = {"displacement": [], "stress": [], "von_mises": [], "contact_pressure": []}
    start = 0
    for k, body in enumerate(result.elastic_bodies):
        mesh = body.mesh
        used = np.unique(mesh.cells)
        index = np.full(len(mesh.points), -1, dtype=np.int64)
        index[used] = start + np.arange(len(used))
        stress = result.stress(body)[used]
        points.append(body.pose.to_world(mesh.points[used]))
        cells.setdefault(mesh.cells.shape[1], []).append(index[mesh.cells])
        number.append((mesh.cells.shape[1], np.full(len(mesh.cells), k)))
        data["displacement"].append(result.displacement(body)[used])
        data["stress"].append(stress)
        data["von_mises"].append(von_mises(stress))
        data["contact_pressure"].append(_nodal_pressure(result, body)[used])
        start += len(used)
    if not points:
        raise InputError("The scene has no elastic body, so there is nothing to write to a VTU file.")
    blocks = [(VTK_NAMES[CELL_TYPES[n]], np.concatenate(c)) for n, c in cells.items()]
    bodies = [np.concatenate([values for m, values in number if m == n]) for n in cells]
    meshio.Mesh(
        np.concatenate(points),
        blocks,
        point_data={k: np.concatenate(v) for k, v in data.items()},
        cell_data={"body": bodies},
    ).write(path, file_format="vtu")
    return path


def _nodal_pressure(result: ContactResult, body: ElasticBody) -> Array:
    """Contact pressure (n_points,) on a body's nodes, as slave; zero elsewhere."""
    pressure = np.zeros(len(body.mesh.points))
    for interface, contact in zip(result.interfaces, result.contacts, strict=True):
        if contact.slave is body:
            pressure[interface.pairing.nodes] += contact.pressure
    return pressure
