"""Files: results to VTU and PVD (ParaView), JSON (scripts) and CSV (spreadsheets).

Grids of cells on the surfaces of local bodies, with their fields, for files and pictures.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np
import scipy

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import ElasticBody
from fecontact.common.arguments import file_path
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.common.files import check_writable, replacing, save_json, write_collection
from fecontact.common.material import von_mises
from fecontact.common.units import UnitNames, Units, refuse_units
from fecontact.contact.interface import Interface
from fecontact.halfspace.grid import GridSurface
from fecontact.mesh.formats.generic import teach_meshio
from fecontact.results.contact_fields import ContactFields
from fecontact.surfaces.facet_surface import has_cells, with_nodes

if TYPE_CHECKING:
    from fecontact.results.result import ContactResult

#: Lines of cells along a side at which displacement and stress are evaluated; between them they are interpolated.
LINES = 32


@dataclass(frozen=True, eq=False)
class WindowPatch:
    """The cells of a contact on a body with a mesh.

    Attributes
    ----------
    body : Body
    points : (n, 3) array
        Centres of the cells, in the body's own axes.
    quads : (m, 4) int array
        Quadrilaterals between them.
    fields : mapping of str to (n,) or (n, k) arrays
        Those of `files.body_fields`, and the gap.
    """

    body: Body
    points: Array
    quads: IntArray
    fields: Mapping[str, Array]


def on_window(result: ContactResult, interface: Interface) -> bool:
    """Whether the contact of an interface is on cells of a body with a mesh."""
    k = result.scene.bodies.index(interface.slave)
    meshed = interface.slave._at_points(result._state.displacements[k]) is not None
    return meshed and has_cells(interface.slave_surface)


def window_patches(result: ContactResult) -> Iterator[WindowPatch]:
    """The patches of all contacts on windows of local bodies."""
    for interface, contact in zip(result._interfaces, result.contacts, strict=True):
        if on_window(result, interface):
            yield _patch(result, interface, contact)


def _patch(result: ContactResult, interface: Interface, contact: ContactFields) -> WindowPatch:
    body, surface, shown = interface.slave, interface.slave_surface, contact._node_numbers
    u, stress = _inside(result, interface, shown)
    pressure, gap = (contact._at_nodes @ values for values in (contact.pressure, contact.gap))
    fields = {
        "displacement": u,
        "stress": stress,
        "von_mises": von_mises(stress),
        "contact_pressure": pressure,
        "contact_pressure_error": np.zeros(len(shown)),
        "gap": gap,
    }
    return WindowPatch(body, surface.points[shown], contact.facets, fields)


def _inside(result: ContactResult, interface: Interface, shown: IntArray) -> tuple[Array, Array]:
    """Displacement in world axes (n, 3) and stress (n, 6) at cells (n,) of a window."""
    surface = cast(GridSurface, interface.slave_surface)
    first = int(surface.facets.min())
    shape = tuple(len(x) for x in surface.axes)
    lines = [np.unique(np.linspace(0, n - 1, min(n, LINES)).round().astype(int)) for n in shape]
    number = first + np.add.outer(lines[0] * shape[1], lines[1])
    found = result.fields_at(interface.slave, surface.points[number.ravel()])
    values = np.concatenate(found, axis=1).reshape(*number.shape, -1)
    cells = np.stack(np.divmod(shown - first, shape[1]), axis=1)
    between = scipy.interpolate.RegularGridInterpolator(tuple(map(np.asarray, lines)), values)(cells)
    return between[:, :3], between[:, 3:]


#: Suffixes of a result's files.
WRITERS = (".vtu", ".json", ".csv", ".npz")


def save_result(result: ContactResult, path: str | Path, units: UnitNames = ()) -> Path:
    """Write a result; the suffix decides. Names of `units` are those of the scene unless given.

    Raises
    ------
    InputError
        If the suffix is unknown or the path cannot be written.
    """
    path = file_path("the path of a result", path)
    suffix = path.suffix.lower()
    if suffix not in WRITERS:
        raise InputError(f"Unknown file type {suffix!r} for a result; expected one of {', '.join(WRITERS)}.")
    if suffix == ".vtu":
        refuse_units(suffix, units)
    check_writable(path)
    names = Units.of(units).with_defaults(result.unit_names)
    writers = {
        ".vtu": save_vtu,
        ".json": lambda r, p: save_json(p, {**r.summary(), "units": asdict(names)}),
        ".csv": lambda r, p: save_csv(r.contacts, p, Units.of(units)),
        ".npz": lambda r, p: save_arrays(r, p, names),
    }
    return writers[suffix](result, path)


def save_arrays(result: ContactResult, path: Path, units: Units) -> Path:
    """The condensed problem, its solution and the points of the contacts as arrays of numpy."""
    solution = result.friction or result.solution
    names = (*(("S",) if solution.problem.is_dense else ()), "g", "B", "F", "points", "tangents", "mu")
    found = {name: np.asarray(getattr(solution.problem, name)) for name in names}
    found |= {"forces": solution.forces, "q": solution.q, "units": np.array(list(asdict(units).values()))}
    for k, contact in enumerate(result.contacts):
        found |= {f"{name}_{k}": getattr(contact, name) for name in ("points", "normals", "pressure", "gap")}
    with replacing(path) as file:
        np.savez_compressed(file, allow_pickle=False, **found)
    return path


def save_csv(contacts: Sequence[ContactFields], path: str | Path, units: Units | None = None) -> Path:
    """One row per contact point: contact, position, normal, area, force, pressure, gap, region (0: no contact).

    With friction also traction (tx, ty, tz), slip of the step (sx, sy, sz) and state (open, stick, slip).
    """
    path = check_writable(path)
    head = ["contact", "x", "y", "z", "nx", "ny", "nz", "area", "force", "pressure", "gap", "region"]
    if any(c.friction is not None for c in contacts):
        head += ["tx", "ty", "tz", "sx", "sy", "sz", "state"]
    with replacing(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow((units or Units()).heads(head))
        for k, c in enumerate(contacts):
            table = np.column_stack([c.points, c.normals, c.weights, c.forces, c.pressure, c.gap])
            rows = zip(table.tolist(), c.region.tolist(), strict=True)
            lines = [[k, *map(repr, row), region] for row, region in rows]
            if c.friction is not None:
                f = c.friction
                tangential = np.column_stack([f.traction, f.slip]).tolist()
                lines = [[*a, *map(repr, b), s] for a, b, s in zip(lines, tangential, f.state, strict=True)]
            writer.writerows(lines)
    return path


def save_vtu(result: ContactResult, path: str | Path) -> Path:
    """All bodies with a mesh: displacement, stress, equivalent stress and contact pressure as point data.

    Points are as given, so that displacements warp them; of a scene at finite strain they are those of the deformed
    bodies. Stresses are in each body's own axes, Cauchy's at finite strain. Wedges, pyramids and tetrahedra are
    written as such. Mid-face nodes, which the file's elements do not have, are left out. The cells of the windows
    of local bodies follow as quadrilaterals, with the gap; elsewhere it is NaN.
    """
    import meshio

    path = check_writable(path)
    teach_meshio()
    points: list[Array] = []
    cells: dict[str, list[IntArray]] = {}
    owner: dict[str, list[IntArray]] = {}
    data: dict[str, list[Array]] = {}
    start = 0
    for k, body in enumerate(bodies := result._meshed_bodies):
        mesh = body.mesh
        used = np.unique(mesh.cells)
        index = np.full(len(mesh.points), -1, dtype=np.int64)
        index[used] = start + np.arange(len(used))
        deformed = result.displacement(body) if result.finite_strain else 0.0
        points.append((result._given_points(body) + deformed)[used])
        for name, block, _ in mesh.native_cells():
            cells.setdefault(name, []).append(index[block])
            owner.setdefault(name, []).append(np.full(len(block), k))
        for name, values in body_fields(result, body).items():
            data.setdefault(name, []).append(values[used])
        start += len(used)
    if not points:
        raise InputError("The scene has no body with a mesh, so there is nothing to write to a VTU file.")
    for patch in window_patches(result):
        data.setdefault("gap", [np.full(start, np.nan)])
        points.append(result._given(patch.body).pose.to_world(patch.points))
        cells.setdefault("quad", []).append(start + patch.quads)
        owner.setdefault("quad", []).append(np.full(len(patch.quads), bodies.index(cast(ElasticBody, patch.body))))
        for name, values in patch.fields.items():
            data[name].append(values)
        start += len(patch.points)
    mesh = meshio.Mesh(
        np.concatenate(points),
        [(name, np.concatenate(c)) for name, c in cells.items()],
        point_data={k: np.concatenate(v) for k, v in data.items()},
        cell_data={"body": [np.concatenate(owner[name]) for name in cells]},
    )
    with replacing(path) as partial:
        mesh.write(partial, file_format="vtu")
    return path


def save_series(results: Sequence[ContactResult], path: str | Path, times: Sequence[float] | None = None) -> Path:
    """Write results as a series for ParaView: a PVD file and one VTU file for each result.

    Parameters
    ----------
    results : sequence of ContactResult
    path : str or Path
        Ends in ``.pvd``; the others are named after it, with a number.
    times : sequence of float, optional
        Time (or load, or angle) of each result; 0, 1, 2, ... unless given.

    Raises
    ------
    InputError
        If there is no result, the number of times differs, the suffix is another, or the path cannot be written.
    """
    path = check_writable(path)
    if path.suffix.lower() != ".pvd":
        raise InputError(f"A series is written to a .pvd file; found {path.name!r}.", code="not-pvd")
    instants = [float(k) for k in range(len(results))] if times is None else [float(t) for t in times]
    if not results or len(instants) != len(results):
        raise InputError(f"A series needs results and one time for each; found {len(results)} and {len(instants)}.")
    files = [save_vtu(result, path.with_name(f"{path.stem}_{k:04d}.vtu")) for k, result in enumerate(results)]
    return write_collection(path, files, instants)


def body_fields(result: ContactResult, body: ElasticBody) -> dict[str, Array]:
    """Nodal fields of a body by name.

    displacement (n, 3), stress (n, 6), von_mises (n,), contact_pressure (n,), contact_pressure_error (n,). The latter
    two are zero at the nodes of a local body: its cells have them, see `window_patches`.
    """
    stress = result.stress(body)
    return {
        "displacement": result.displacement(body),
        "stress": stress,
        "von_mises": von_mises(stress),
        "contact_pressure": nodal_pressure(result, body),
        "contact_pressure_error": nodal_error(result, body),
    }


def nodal_error(result: ContactResult, body: ElasticBody) -> Array:
    """Estimated error (n_points,) of the contact pressure where the body is the slave: the mean over adjacent faces."""
    error = np.zeros(len(body.mesh.points))
    for interface, contact in zip(result._interfaces, result.contacts, strict=True):
        if interface.slave is body and not on_window(result, interface):
            facets = interface.slave_surface.facets
            total, count = (
                np.bincount(facets.ravel(), np.repeat(values, facets.shape[1]), len(error))
                for values in (contact.error_indicators, np.ones(len(facets)))
            )
            error += total / np.maximum(count, 1)
    return error


def nodal_pressure(result: ContactResult, body: ElasticBody) -> Array:
    """Contact pressure (n_points,) on a body's nodes; zero where there is none.

    As slave: that of the contact. As master: the slave's pressure at the point opposite each node.
    """
    pressure = np.zeros(len(body.mesh.points))
    for interface, contact in zip(result._interfaces, result.contacts, strict=True):
        if on_window(result, interface):
            continue
        if interface.slave is body:
            pressure += interface.pairing.at_nodes @ contact.pressure
        elif interface.master is body and contact.active.any():
            nodes, values = _opposite_pressure(interface, contact)
            pressure[nodes] += values
    return pressure


def _opposite_pressure(interface: Interface, contact: ContactFields) -> tuple[IntArray, Array]:
    """Nodes of the master's surface and the slave's pressure opposite them."""
    slave, master = interface.slave_surface, with_nodes(interface.master.surface(interface.surfaces[1]))
    p = interface.pairing
    nodal = p.at_nodes @ contact.pressure
    projection = slave.project((master.points[master.nodes] - p.translation) @ p.rotation)
    assert projection.weights is not None
    # a node further away than any point in contact is on another part of the surface
    off = np.abs(projection.gap) > 2 * np.abs(p.gap[contact.active]).max() + 1e-6 * slave.size
    values = np.clip(projection.weights @ nodal, 0.0, contact.max_pressure)
    return master.nodes, np.where(off | projection.outside, 0.0, values)
