"""Read meshes of solids, surfaces and plane sections."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from fecontact.common.arguments import file_path, function, spelled, text
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, positive
from fecontact.common.errors import InputError, MeshError, shown
from fecontact.mesh.base_mesh import first_alike, representatives
from fecontact.mesh.build import ELEMENTS, build
from fecontact.mesh.cell_division import section_division, section_triangle_division
from fecontact.mesh.check import check_size
from fecontact.mesh.facets import edge_keys, facets_at_sides, found, numbered_between, places_among, sides_of
from fecontact.mesh.formats.abaqus import read_abaqus
from fecontact.mesh.formats.febio import read_febio
from fecontact.mesh.formats.generic import read_vtk
from fecontact.mesh.formats.gmsh import read_gmsh
from fecontact.mesh.formats.raw import RawMesh, part_of
from fecontact.mesh.formats.triangulated import read_obj, read_off, read_ply, read_stl
from fecontact.mesh.formats.vtp import read_vtp
from fecontact.mesh.gmsh import SUFFIXES as CAD
from fecontact.mesh.gmsh import Sizes, mesh_cad
from fecontact.mesh.mending import cut
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.refine import cut as divide
from fecontact.mesh.section_mesh import REVERSED, PlaneCells, SectionMesh
from fecontact.mesh.surface_mesh import SAME_POINT, SurfaceMesh, joined

READERS: dict[str, Callable[[Path], RawMesh]] = {
    ".msh": read_gmsh,
    ".inp": read_abaqus,
    ".feb": read_febio,
    ".vtk": read_vtk,
    ".vtu": read_vtk,
    ".xdmf": read_vtk,
}
SURFACES = (".stl", ".ply", ".obj", ".off", ".vtp")


@spelled
def read_mesh(
    path: str | Path,
    scale: float = 1.0,
    element: str | None = None,
    part: str | None = None,
    reader: Callable[[Path], RawMesh] | None = None,
) -> Mesh:
    """Read the mesh of a solid.

    Parameters
    ----------
    path : str or Path
        ``.msh`` (gmsh: physical surfaces become boundaries, physical volumes element sets), ``.inp`` (Abaqus,
        CalculiX), ``.feb`` (FEBio), ``.vtk``, ``.vtu``, ``.xdmf``; geometry ``.step``, ``.stp``, ``.brep``, ``.iges``
        is meshed by gmsh with default sizes (`fc.mesh_solid` has the options).
    scale : float
        Factor for all coordinates.
    element : {'hex20', 'hex27', 'wedge15', 'tet10'}, optional
        Convert linear cells to this family, with straight edges ('hex20', 'wedge15' and 'tet10' mean the same: every
        cell gets mid-edge nodes). 'hex20' reduces 27-node cells to 20 nodes. No conversion unless given.
    part : str, optional
        Read only the cells of this element set: a part of an FEBio file, a physical volume of gmsh, an ``ELSET``, an
        instance of an assembly in an ``.inp`` file, in its place. Otherwise all are read into one mesh, without merging
        nodes; each instance is an element set of its name (`Mesh.part` extracts it), and names that occur in several
        of them are called ``instance.name``.
    reader : callable, optional
        A user-defined reader for a file of any type: a function from its path to a `mesh.formats.raw.RawMesh`, which is
        then checked and converted like all others; see docs/extending.md.

    Returns
    -------
    Mesh
        Node sets whose points cover whole outer faces serve as boundaries too. What is not solid (shells, beams, loose
        facets) is left out and listed in `notes`; `read_surface` reads shells. `file_nodes` and `file_elements` are the
        file's numbers. Cells of different order become quadratic, with a note.

    Raises
    ------
    InputError
        For an unknown file type, element or part, or a surface file (see `read_surface`).
    MeshError
        For a damaged file, one without solid cells, or inverted or folded cells.

    Examples
    --------
    >>> import tempfile, meshio, numpy as np
    >>> points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    >>> file = Path(tempfile.mkdtemp()) / "one.vtu"
    >>> meshio.Mesh(points, [("tetra", [[0, 1, 2, 3]])]).write(file)
    >>> read_mesh(file, scale=1e-3, element="tet10")
    Mesh(tet10, 1 cells, 10 points, boundaries: none)
    """
    path = file_path("the path of a mesh", path)
    suffix = path.suffix.lower()
    _check_request(path, suffix, scale, element, part, reader is not None)
    if reader is not None:
        raw = function("the reader", reader)(path)
        if not isinstance(raw, RawMesh):
            raise InputError(f"The reader must return a RawMesh of {path.name}; found {type(raw).__name__}.")
        return build(raw if part is None else part_of(raw, part, path.name), path.name, scale, element)
    if suffix in CAD:
        return mesh_cad(path, Sizes.of(None, element or "tet10", None, None, 0.5), scale)
    if suffix == ".inp":
        raw = read_abaqus(path, part)
    else:
        raw = READERS[suffix](path)
        raw = raw if part is None else part_of(raw, part, path.name)
    return build(raw, path.name, scale, element)


def _check_request(path: Path, suffix: str, scale: float, element: str | None, part: str | None, own: bool) -> None:
    if suffix in SURFACES and not own:
        raise InputError(
            f"{path.name} is a surface, not a solid. fc.mesh_solid meshes what it encloses; fc.extrude grows a layer "
            "on what fc.read_surface reads.",
            code="is-a-surface",
        )
    if suffix not in READERS and suffix not in CAD and not own:
        raise InputError(
            f"Unknown mesh file type {suffix!r}; expected one of {', '.join((*READERS, *CAD))}, or a function reader=.",
            code="unknown-file-type",
        )
    positive("the scale", scale)
    if element is not None:
        among("element", element, ELEMENTS)
    if part is not None:
        text("the name of a part", part)
    if part is not None and suffix in CAD and not own:
        raise InputError(
            f"Geometry has no parts to be read alone; found part={part!r} and {path.name}. Use fc.mesh_solid.",
            code="no-parts",
        )
    if not path.is_file():
        raise InputError(f"There is no file {path}.", code="no-file")


POLYGON_READERS: dict[str, Callable[[Path], tuple[Array, list[IntArray]]]] = {
    ".stl": read_stl,
    ".ply": read_ply,
    ".obj": read_obj,
    ".off": read_off,
    ".vtp": read_vtp,
}


@spelled
def read_surface(path: str | Path, name: str | None = None, scale: float = 1.0) -> SurfaceMesh:
    r"""Read a surface from an .stl, .ply, .obj, .off or .vtp file, or out of a mesh or deck.

    Parameters
    ----------
    path : str or Path
        The other types are those of `read_mesh` but geometry.
    name : str, optional
        Of a mesh or deck: a part of shells or of rigid facets, or a surface, on solids or not; may be left out if there
        is only one.
    scale : float
        Factor for all coordinates.

    Returns
    -------
    SurfaceMesh
        Points in the same place are joined (.stl lists each corner once per triangle); triangles that collapse to a
        line by it are left out, and so are repeated facets. Polygons are divided into triangles. Facets oriented
        against their neighbours, and closed surfaces that face inwards, are reversed (`mesh.orient.oriented`); `notes`
        reports it. Of shells the corners of facets are read, of boundaries of solids their curved faces.

    Raises
    ------
    InputError, MeshError
        For an unknown file type or name, a damaged file, a branching or one-sided surface, or no surface cells.

    Examples
    --------
    >>> import tempfile
    >>> deck = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n*ELEMENT, TYPE=S3, ELSET=Skin\n1,1,2,3\n"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "shell.inp"
    ...     _ = file.write_text(deck)
    ...     read_surface(file, "Skin")
    SurfaceMesh(1 facets, 1 of them triangles, 3 points, area 0.5)
    """
    path = file_path("the path of a surface", path)
    suffix = path.suffix.lower()
    if suffix not in POLYGON_READERS and suffix not in READERS:
        known = ", ".join((*POLYGON_READERS, *READERS))
        raise InputError(f"Unknown surface file type {path.suffix!r}; expected one of {known}.", code="file-type")
    if name is not None and not isinstance(name, str):
        raise InputError(f"The name of a surface must be a text; found {shown(name)}. A scale is given as scale=.")
    if name is not None and suffix in POLYGON_READERS:
        raise InputError(f"{path.name} holds one surface, so there is none called {name!r}.", code="one-surface")
    positive("the scale", scale)
    if not path.is_file():
        raise InputError(f"There is no file {path}.", code="no-file")
    if suffix in READERS:
        return _named(READERS[suffix](path), path.name, name, scale)
    return _surface(*read_polygons(path), path.name, scale)


def read_polygons(path: Path) -> tuple[Array, list[IntArray]]:
    """Points (n, 3) and polygons of an existing file of `POLYGON_READERS`, an array for each number of corners.

    Raises
    ------
    MeshError
        For a damaged file.
    """
    try:
        return POLYGON_READERS[path.suffix.lower()](path)
    except (ValueError, OverflowError, IndexError, KeyError) as error:
        if isinstance(error, MeshError):
            raise
        raise MeshError(f"{path.name} holds a line that cannot be read: {error}.", code="bad-line") from error


def _named(raw: RawMesh, source: str, name: str | None, scale: float) -> SurfaceMesh:
    """A shell or surface of a mesh."""
    own = {**raw.facets, **raw.shells}
    known = list(dict.fromkeys([*raw.shells, *raw.facets, *raw.faces]))
    listed = ", ".join(map(repr, known)) or "none"
    if name is None and len(known) != 1:
        raise InputError(f"{source} has {len(known)} surfaces; say which by name: {listed}.", code="several-surfaces")
    wanted = known[0] if name is None else name
    exact = [k for k in known if k == wanted] or [k for k in known if k.upper() == wanted.upper()]
    if not exact:
        raise InputError(f"{source} has no surface {wanted!r}; its shells and surfaces are: {listed}.", code="unknown")
    if exact[0] in own:
        # triangles among quadrilaterals repeat their last corner
        facets = np.concatenate([f[:, [0, 1, 2, -1]] for f in own[exact[0]]])
        three = facets[:, 2] == facets[:, 3]
        polygons = [p for p in (facets[three, :3], facets[~three]) if len(p)]
        return _surface(raw.points, polygons, source, scale)
    return SurfaceMesh.of(build(raw, source, scale), exact[0])


def _surface(points: Array, polygons: list[IntArray], source: str, scale: float) -> SurfaceMesh:
    """A checked surface of polygons, each array of one number of corners."""
    surface = joined(*cut_facets(points, polygons, source, scale))
    return replace(surface, notes=tuple(f"{source}: {note}" for note in surface.notes))


def cut_facets(points: Array, polygons: list[IntArray], source: str, scale: float) -> tuple[Array, IntArray]:
    """Points (n, 3) in use and facets (n_facets, 4) of polygons, each array of one number of corners.

    Raises
    ------
    MeshError
        If there are none, or they refer to points that do not exist or are not finite.
    """
    if not sum(map(np.size, polygons)):
        raise MeshError(f"{source} holds no triangles or polygons.")
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError(f"{source} has points of shape {points.shape}; a surface needs three coordinates.")
    numbers = np.concatenate([p.ravel() for p in polygons])
    if numbers.min() < 0 or numbers.max() >= len(points):
        raise MeshError(f"{source}: a polygon refers to a point that is not among its {len(points)} points.")
    used, number = np.unique(numbers, return_inverse=True)
    if not np.isfinite(points[used]).all():
        raise MeshError(f"{source}: point {used[np.argmin(np.isfinite(points[used]).all(axis=1))]} is not finite.")
    with np.errstate(over="ignore"):
        check_size(scale * points[used])
    ends = np.cumsum([p.size for p in polygons])[:-1]
    own = [n.reshape(p.shape) for n, p in zip(np.split(number, ends), polygons, strict=True)]
    x = scale * np.asarray(points[used], dtype=float)
    return x, np.concatenate([cut(x, p) for p in own])


def loose_triangles(points: Array, polygons: list[IntArray], source: str) -> tuple[Array, IntArray]:
    """Points (n, 3) and triangles (n_triangles, 3) of polygons that need not be a surface; errors as `cut_facets`.

    Polygons are divided from their first corner, points in one place are joined, and each triangle is taken once.
    """
    fans = [p[:, [0, k, k + 1]] for p in polygons for k in range(1, p.shape[1] - 1)]
    x, facets = cut_facets(points, fans, source, 1.0)
    facets = representatives(x, SAME_POINT * float(np.linalg.norm(np.ptp(x, axis=0))))[facets]
    facets = facets[(facets[:, :3] != np.roll(facets[:, :3], 1, axis=1)).all(axis=1)]
    used, number = np.unique(facets[np.unique(first_alike(facets))], return_inverse=True)
    return x[used], number.reshape(-1, 4)[:, :3]


#: Extent across the plane of a section, relative to its size, that is rounding of a file.
FLAT = 1e-9


@spelled
def read_section(path: str | Path, part: str | None = None, scale: float = 1.0) -> SectionMesh:
    """Read a plane mesh as a section.

    Parameters
    ----------
    path : str or Path
        ``.msh`` (physical curves become boundaries), ``.inp`` (CPS, CPE, CAX), ``.vtk``, ``.vtu``, ``.xdmf``. The mesh
        may lie in any coordinate plane: of x, y and z the two that vary become x and z of the section.
    part : str, optional
        Read only this set of cells, as one body of several.
    scale : float

    Returns
    -------
    SectionMesh
        Of 8-node quadrilaterals; sides of linear cells stay straight. Node sets that hold whole outer sides serve as
        boundaries too.

    Raises
    ------
    InputError, MeshError
        For an unknown file type or part, no plane cells, or cells that lie in no coordinate plane.

    Examples
    --------
    >>> import meshio, tempfile
    >>> points = [[0, 0], [1, 0], [1, 1], [0, 1.0]]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     triangles = [("triangle", [[0, 1, 2], [0, 2, 3]])]
    ...     meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), triangles).write(f"{folder}/a.vtu")
    ...     read_section(f"{folder}/a.vtu")
    SectionMesh(quad8, 6 cells, 27 points, boundaries: none)
    """
    path = file_path("the path of a section", path)
    if path.suffix.lower() not in READERS:
        raise InputError(f"Unknown mesh file type {path.suffix!r}; expected one of {', '.join(READERS)}.")
    positive("the scale", scale)
    if not path.is_file():
        raise InputError(f"There is no file {path}.", code="no-file")
    raw = READERS[path.suffix.lower()](path)
    names = list(dict.fromkeys(name for name, _, _ in raw.sheets))
    if part is not None and part not in names:
        raise InputError(f"{path.name} has no plane part {part!r}; there are: {', '.join(map(repr, names)) or 'none'}.")
    sheets = [s for s in raw.sheets if part is None or s[0] == part]
    if not sheets:
        raise MeshError(f"{path.name} holds no plane cells; solids are read with fc.read_mesh.", code="no-plane-cells")
    points, cells, owner = _quadratic(raw.points, [(kind, c) for _, kind, c in sheets])
    points = _in_plane(scale * points, np.unique(cells[cells >= 0]), path.name)
    # a cell of several sets is there once for each
    first = first_alike(cells[:, :4])
    own = first == np.arange(len(cells))
    number = (np.cumsum(own) - 1)[first]
    named = [(name, np.isin(owner, [k for k, s in enumerate(sheets) if s[0] == name])) for name in names]
    groups = {name: np.unique(number[members]) for name, members in named}
    lines = {k: np.concatenate(v) for k, v in raw.lines.items()}
    plane, _ = _plane(points, cells[own], groups, lines, raw.node_sets)
    return SectionMesh(plane.points, plane.cells, plane.boundaries, plane.groups, plane.node_sets)


def plane_parts(raw: RawMesh, source: str) -> tuple[PlaneCells, IntArray]:
    """The plane cells of all parts of a file in the plane z = 0, as sections that may touch, with the file's numbers.

    Also the points (n, 3) that lie between two others: their numbers and those of the others; points on which others
    depend come first.

    Raises
    ------
    MeshError
        If the cells lie in another plane.
    """
    points, cells, _ = _quadratic(raw.points, list(raw.blocks))
    used = np.unique(cells)
    if np.ptp(points[used, 2]) > FLAT * np.linalg.norm(np.ptp(points[used], axis=0)):
        raise MeshError(
            f"{source}: plane and axisymmetric elements lie in the plane of x and y; their z varies.",
            code="out-of-plane",
        )
    lines = {name: sides_of(cells)[tuple(faces.T)] for name, faces in raw.faces.items()}
    x = np.stack([points[:, 0], np.zeros(len(points)), points[:, 1]], axis=1)
    plane, number = _plane(x, cells, raw.groups, lines, raw.node_sets)
    n, ends = len(raw.points), sides_of(cells).reshape(-1, 2)
    middles = np.column_stack([cells[:, 4:].ravel(), ends])
    middles = number[np.unique(middles[(middles[:, 0] >= n) & (ends[:, 0] != ends[:, 1])], axis=0)]
    ids = np.full(len(plane.points), -1)
    old = np.flatnonzero(number[:n] >= 0)
    assert raw.node_ids is not None
    ids[number[old]] = raw.node_ids[old]
    later = np.column_stack([plane.cells[:, 4:8].ravel(), sides_of(plane.cells[:, :8]).reshape(-1, 2)])
    later = later[(ids[later[:, 0]] < 0) & ~np.isin(later[:, 0], middles[:, 0])]
    return replace(plane, file_nodes=ids), np.concatenate([middles, later])


def _plane(
    points: Array,
    cells: IntArray,
    groups: Mapping[str, IntArray],
    lines: Mapping[str, IntArray],
    node_sets: Mapping[str, IntArray],
) -> tuple[PlaneCells, IntArray]:
    """Quadrilaterals of 8 nodes, of triangles too, with sides of node sets and of named pieces of curves.

    Also the numbers of the points, -1 of those that are not in use.
    """
    cells = _turned(points, cells)
    triangle = cells[:, 2] == cells[:, 3]
    sides = _sides_of_sets(cells, node_sets)
    sides |= _named_sides(cells, lines)
    used, number = np.unique(cells, return_inverse=True)
    back = places_among(used, len(points))
    sets = {name: back[nodes] for name, nodes in node_sets.items()}
    sets = {name: nodes[nodes >= 0] for name, nodes in sets.items() if (nodes >= 0).any()}
    plane = PlaneCells(points[used], number.reshape(cells.shape), sides, groups, sets)
    if triangle.any():
        parts = [(triangle, section_triangle_division()), (~triangle, section_division(8))]
        plane = divide(plane, [(np.flatnonzero(rows), division) for rows, division in parts if rows.any()])[0]
    kept = ({k: v for k, v in named.items() if len(v)} for named in (plane.boundaries, plane.groups, plane.node_sets))
    return PlaneCells(plane.points, plane.cells, *kept), back


def _quadratic(points: Array, blocks: list[tuple[str, IntArray]]) -> tuple[Array, IntArray, IntArray]:
    """Points, cells (n, 8) and the block of each; triangles repeat their third corner and the middle beside it."""
    rows, owner = [], []
    for k, (kind, c) in enumerate(blocks):
        full = np.full((len(c), 8), -1, dtype=np.int64)
        if kind.startswith("tri"):
            full[:, :4] = c[:, [0, 1, 2, 2]]
            full[:, 4:] = c[:, [3, 4, 2, 5]] if kind == "tri6" else full[:, 4:]
        else:
            full[:, : min(c.shape[1], 8)] = c[:, :8]
        rows.append(full)
        owner.append(np.full(len(c), k))
    cells = np.concatenate(rows)
    middle, ends = numbered_between(sides_of(cells).reshape(-1, 2), len(points), cells[:, 4:].ravel())
    cells[:, 4:] = middle.reshape(-1, 4)
    return np.concatenate([points, points[ends].mean(axis=1)]), cells, np.concatenate(owner)


def _in_plane(points: Array, used: IntArray, source: str) -> Array:
    """Points (n, 3) with y = 0, from those of a coordinate plane."""
    extent = np.ptp(points[used], axis=0)
    flat = extent <= FLAT * np.linalg.norm(extent)
    if flat.sum() != 1:
        raise MeshError(f"{source} has plane cells that lie in no coordinate plane; their extents are {extent}.")
    x, z = np.flatnonzero(~flat)
    return np.stack([points[:, x], np.zeros(len(points)), points[:, z]], axis=1)


def _turned(points: Array, cells: IntArray) -> IntArray:
    """Cells counter-clockwise, seen with x to the right and z upwards."""
    x, z = points[cells[:, :4], 0], points[cells[:, :4], 2]
    area = (x * np.roll(z, -1, axis=1) - np.roll(x, -1, axis=1) * z).sum(axis=1)
    out = cells.copy()
    out[area < 0] = cells[area < 0][:, list(REVERSED[:8])]
    # triangles have their double corner last
    wrong = (out[:, 2] != out[:, 3]) & (out[:, 1] == out[:, 2])
    out[wrong] = out[wrong][:, [3, 0, 1, 2, 7, 4, 5, 6]]
    return out


def _named_sides(cells: IntArray, lines: Mapping[str, IntArray]) -> dict[str, IntArray]:
    """Sides (n, 2) of cells at named pieces (n, 2) of curves."""
    ends = sides_of(cells).reshape(-1, 2)
    keys = edge_keys(ends)
    out = {}
    for name, pieces in lines.items():
        at = found(edge_keys(pieces), keys)
        out[name] = np.stack(np.divmod(at[at >= 0], 4), axis=1)
    return out


def _sides_of_sets(cells: IntArray, node_sets: Mapping[str, IntArray]) -> dict[str, IntArray]:
    """Outer sides (n, 2) of cells with both ends in a node set."""
    ends, outer = sides_of(cells), facets_at_sides(cells) == 1
    return {name: np.argwhere(outer & np.isin(ends, nodes).all(axis=2)) for name, nodes in node_sets.items()}
