"""Read surfaces: files of triangles and polygons, and shells and surfaces of meshes and decks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from fecontact.common.arguments import file_path
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import positive
from fecontact.common.errors import InputError, MeshError, shown
from fecontact.mesh.build import build
from fecontact.mesh.check import check_size
from fecontact.mesh.formats.raw import RawMesh
from fecontact.mesh.formats.triangulated import read_obj, read_off, read_ply, read_stl
from fecontact.mesh.formats.vtp import read_vtp
from fecontact.mesh.mending import cut
from fecontact.mesh.read import READERS as MESH_READERS
from fecontact.mesh.surface_mesh import SurfaceMesh, joined

READERS: dict[str, Callable[[Path], tuple[Array, list[IntArray]]]] = {
    ".stl": read_stl,
    ".ply": read_ply,
    ".obj": read_obj,
    ".off": read_off,
    ".vtp": read_vtp,
}


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
    if suffix not in READERS and suffix not in MESH_READERS:
        known = ", ".join((*READERS, *MESH_READERS))
        raise InputError(f"Unknown surface file type {path.suffix!r}; expected one of {known}.", code="file-type")
    if name is not None and not isinstance(name, str):
        raise InputError(f"The name of a surface must be a text; found {shown(name)}. A scale is given as scale=.")
    if name is not None and suffix in READERS:
        raise InputError(f"{path.name} holds one surface, so there is none called {name!r}.", code="one-surface")
    positive("the scale", scale)
    if not path.is_file():
        raise InputError(f"There is no file {path}.", code="no-file")
    if suffix in MESH_READERS:
        return _named(MESH_READERS[suffix](path), path.name, name, scale)
    return _surface(*read_polygons(path), path.name, scale)


def read_polygons(path: Path) -> tuple[Array, list[IntArray]]:
    """Points (n, 3) and polygons of an existing file of `READERS`, an array for each number of corners.

    Raises
    ------
    MeshError
        For a damaged file.
    """
    try:
        return READERS[path.suffix.lower()](path)
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
