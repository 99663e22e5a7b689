"""Meshes of CAD files by gmsh: all hexahedra or tetrahedra, refined where contact is expected.

gmsh runs in a process of its own for each call (`mesh.apart`): an abort ends that process alone, and an open gmsh
session of the caller stays as it is.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import file_path, flag
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, lengths, point_array
from fecontact.common.errors import InputError, MeshError, MissingPackageError
from fecontact.mesh.apart import run_apart
from fecontact.mesh.build import build
from fecontact.mesh.cad_faces import on_model
from fecontact.mesh.formats.raw import RawMesh, numbers_of
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.tet_to_hex import divided

SUFFIXES = (".step", ".stp", ".brep", ".geo", ".iges", ".igs")
#: Default number of elements along the diagonal of the bounding box.
DEFAULT_DIVISIONS = 15
#: Edge of a tetrahedron over the edge of the hexahedra it is divided into.
_DIVIDED = 2.0
#: By gmsh's number of a solid or surface element: kind of cell or number of corners, and number of nodes.
_SOLIDS = {4: ("tet4", 4), 11: ("tet10", 10), 5: ("hex8", 8), 17: ("hex20", 20), 6: ("wedge6", 6), 18: ("wedge15", 15)}
_FACETS = {2: (3, 3), 9: (3, 6), 3: (4, 4), 16: (4, 8)}


def load_gmsh() -> Any:
    """The module gmsh.

    Raises
    ------
    MissingPackageError
        If gmsh is not installed or one of its system libraries is missing.
    """
    elsewhere = "Or make the mesh on another machine and read its file with fc.read_mesh."
    try:
        import gmsh
    except ImportError as error:
        raise MissingPackageError(
            f"CAD files need the package gmsh, which could not be imported ({error}): pip install gmsh. {elsewhere}"
        ) from error
    except OSError as error:
        raise MissingPackageError(
            f"gmsh is installed but cannot be loaded, as a library of the system is missing ({error}). It needs those "
            "of OpenGL and X11 even where no window is opened: libGL, libGLU, libXrender, libXcursor, libXfixes, "
            "libXft, libXinerama, libfontconfig (Debian and Ubuntu: apt-get install libgl1 libglu1-mesa libxrender1 "
            f"libxcursor1 libxfixes3 libxft2 libxinerama1 libfontconfig1). {elsewhere}"
        ) from error
    return gmsh


def mesh_solid(
    path: str | Path,
    size: float | None = None,
    element: str = "tet10",
    *,
    near: ArrayLike | None = None,
    near_size: float | None = None,
    growth: float = 0.5,
    scale: float = 1.0,
    run_script: bool = False,
) -> Mesh:
    """Mesh the solids of a CAD file.

    Parameters
    ----------
    path : str or Path
        ``.step``, ``.stp``, ``.brep``, ``.iges``, or with `run_script` a gmsh script ``.geo``.
    size : float, optional
        Edge length of the elements; a fifteenth of the bounding box's diagonal unless given.
    element : {'tet10', 'hex20', 'tet4', 'hex8'}
        Hexahedra come from the division of tetrahedra twice as large into four each (`mesh.tet_to_hex`), so they fit
        any shape but are less regular than those of a swept mesh.
    near : (3,) or (n, 3) array, optional
        Points of the expected contact zone, round which the elements are smaller.
    near_size : float, optional
        Edge length there; a quarter of `size` unless given.
    growth : float
        Increase of the edge length per unit of distance from the nearest of these points.
    scale : float
        Factor applied to the coordinates at the end; `size`, `near` and `near_size` are in the file's unit.

    run_script : bool
        Whether a ``.geo`` file may be run. It is a program, which can start any other (gmsh's ``SystemCall``): run your
        own only.

    Returns
    -------
    Mesh
        Boundaries 'surface_1', 'surface_2', ... as gmsh numbers the surfaces, and element sets 'volume_1', ...;
        physical groups of a ``.geo`` file by their names. Name others with `fecontact.pick`.

    Raises
    ------
    MissingPackageError, InputError
    MeshError
        If gmsh cannot read or mesh the file, or its process crashes; its message is passed on.
    """
    path = file_path("the path of a CAD file", path)
    _check(path, size, element, near_size, growth, scale, run_script)
    if path.suffix.lower() == ".geo" and not run_script:
        raise InputError(
            f"{path.name} is a gmsh script, which can run any program on this machine. If it is yours, run it by "
            "fc.mesh_solid(path, run_script=True), or mesh it with gmsh and read the .msh file."
        )
    centres = None if near is None else np.atleast_2d(point_array("near", near, 3))
    if centres is not None and (centres.ndim != 2 or not len(centres)):
        raise InputError(f"near must be points of shape (3,) or (n, 3); found shape {centres.shape}.")
    given = (path.absolute(), size, element, centres, near_size, growth)
    mesh = run_apart(f"gmsh, which was to mesh {path.name},", _meshed, *given)
    return mesh if scale == 1 else mesh.scaled(scale)


def _meshed(
    path: Path, size: float | None, element: str, near: Array | None, near_size: float | None, growth: float
) -> Mesh:
    """The mesh in the file's unit, in a process that ends with it."""
    gmsh = load_gmsh()
    gmsh.initialize(["fecontact"], readConfigFiles=False)
    gmsh.model.add("fecontact")
    try:
        _load(gmsh, path)
        _set_sizes(gmsh, size, element, near, near_size, growth)
        _generate(gmsh, element)
    except MeshError:
        raise
    except Exception as error:  # gmsh raises plain Exception with its message
        raise MeshError(f"gmsh could not mesh {path.name}: {error}") from error
    mesh = build(_raw(gmsh, path.name), path.name)
    return on_model(gmsh, divided(mesh) if element.startswith("hex") else mesh)


def _check(
    path: Path, size: float | None, element: str, near_size: float | None, growth: float, scale: float, run_script: bool
) -> None:
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"Unknown CAD file type {path.suffix!r}; expected one of {', '.join(SUFFIXES)}.")
    if not path.is_file():
        raise InputError(f"There is no file {path}.")
    among("element of gmsh", element, ("tet4", "tet10", "hex8", "hex20"))
    flag("run_script", run_script)
    sizes = {"size": size, "near_size": near_size, "growth": growth, "scale": scale}
    lengths(**{name: value for name, value in sizes.items() if value is not None})


def _load(gmsh: Any, path: Path) -> None:
    if path.suffix.lower() == ".geo":
        gmsh.merge(str(path))
        gmsh.model.geo.synchronize()
    else:
        options = ("Geometry.OCCSewFaces", "Geometry.OCCMakeSolids")
        before = [gmsh.option.getNumber(name) for name in options]
        if path.suffix.lower() in (".iges", ".igs"):
            # most IGES files hold surfaces side by side, which close a solid
            for name in options:
                gmsh.option.setNumber(name, 1)
        gmsh.model.occ.importShapes(str(path))
        gmsh.model.occ.synchronize()
        for name, value in zip(options, before, strict=True):
            gmsh.option.setNumber(name, value)
    if not gmsh.model.getEntities(3):
        raise MeshError(
            f"{path.name} holds no solid, only {len(gmsh.model.getEntities(2))} surfaces; close them first."
        )


def _set_sizes(
    gmsh: Any, size: float | None, element: str, near: Array | None, near_size: float | None, growth: float
) -> None:
    """Element size: constant, or growing with the distance from the contact zone."""
    low, high = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
    far = float(np.linalg.norm(high - low)) / DEFAULT_DIVISIONS if size is None else size
    fine = far / 4 if near_size is None else near_size
    factor = _DIVIDED if element.startswith("hex") else 1.0
    for name in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
        gmsh.option.setNumber(f"Mesh.MeshSize{name}", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", factor * far)
    gmsh.option.setNumber("Mesh.MeshSizeMin", factor * (far if near is None else min(fine, far)) / 10)
    field = gmsh.model.mesh.field
    if near is None:
        gmsh.option.setNumber("Mesh.MeshSizeMin", factor * far)
        return
    last = max((tag for _, tag in gmsh.model.getEntities(0)), default=0)
    zone = [gmsh.model.geo.addPoint(*p, tag=last + 1 + k) for k, p in enumerate(near.tolist())]
    gmsh.model.geo.synchronize()
    field.add("Distance", 1)
    field.setNumbers(1, "PointsList", zone)
    field.add("MathEval", 2)
    field.setString(2, "F", f"{factor!r} * Min({far!r}, {fine!r} + {growth!r} * F1)")
    field.setAsBackgroundMesh(2)


def _generate(gmsh: Any, element: str) -> None:
    option = gmsh.option.setNumber
    option("Mesh.ElementOrder", 2 if element in ("tet10", "hex20") else 1)
    option("Mesh.SecondOrderIncomplete", 1)
    option("Mesh.HighOrderOptimize", 2)
    option("Mesh.Algorithm3D", 1)
    option("Mesh.Optimize", 1)
    option("General.NumThreads", 1)
    gmsh.model.mesh.generate(3)


def _raw(gmsh: Any, source: str) -> RawMesh:
    """The mesh in gmsh, with physical groups by name and all entities by number."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    ids = np.asarray(tags, dtype=np.int64)
    blocks: list[tuple[str, IntArray]] = []
    groups: dict[str, list[IntArray]] = {}
    facets: dict[str, list[IntArray]] = {}
    start = 0
    for _, entity in gmsh.model.getEntities(3):
        names = [f"volume_{entity}", *_physical(gmsh, 3, entity)]
        for kind, _, nodes in zip(*gmsh.model.mesh.getElements(3, entity), strict=True):
            if kind not in _SOLIDS:
                raise MeshError(f"{source}: gmsh made elements of its type {kind}, which are not supported.")
            name, n = _SOLIDS[kind]
            cells = numbers_of(ids, np.asarray(nodes, dtype=np.int64).reshape(-1, n), "node", source)
            blocks.append((name, cells))
            for group in names:
                groups.setdefault(group, []).append(start + np.arange(len(cells)))
            start += len(cells)
    for _, entity in gmsh.model.getEntities(2):
        for kind, _, nodes in zip(*gmsh.model.mesh.getElements(2, entity), strict=True):
            corners, n = _FACETS[kind]
            cells = numbers_of(ids, np.asarray(nodes, dtype=np.int64).reshape(-1, n), "node", source)
            for name in [f"surface_{entity}", *_physical(gmsh, 2, entity)]:
                facets.setdefault(name, []).append(cells[:, :corners])
    return RawMesh(np.reshape(coordinates, (-1, 3)), blocks, {k: np.concatenate(v) for k, v in groups.items()}, facets)


def _physical(gmsh: Any, dim: int, entity: int) -> list[str]:
    tags = gmsh.model.getPhysicalGroupsForEntity(dim, entity)
    names = [gmsh.model.getPhysicalName(dim, tag) for tag in tags]
    return [name for name in names if name]
