"""A function in a process of its own, so that a library that aborts ends that process alone.

What meshing by gmsh shares, be it of CAD files or of surfaces: the module, sizes, and the mesh that it holds.

Nodes of a mesh on the faces and edges of the CAD model that it was made from.

The middles of parabolic sides, and nodes within triangles that are divided into hexahedra, lie beside the part's
surface. As long as gmsh holds the model they are placed on it, be it a sphere, a cylinder or a free form: on the
closest point of their face, or of the edge at which faces meet (`gmsh.model.getClosestPoint`, OpenCASCADE).

Meshes of CAD files by gmsh: all hexahedra or tetrahedra, refined where contact is expected.

gmsh runs in a process of its own for each call: an abort ends that process alone, and an open gmsh
session of the caller stays as it is.

Surfaces of triangles whose facets gmsh replaces by others of a wanted size, and tetrahedra within closed ones.

gmsh divides the surface along its sharp edges, maps each piece to a plane and meshes it there (Remacle, Geuzaine,
Compere and Marchandise (2010), *High-quality surface remeshing using harmonic maps*, Int. J. Numer. Meth. Engng 83,
403-425), so that the new facets have their corners on the old ones.
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import flag
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, lengths, point_array
from fecontact.common.errors import FecontactError, InputError, MeshError, MissingPackageError
from fecontact.mesh.build import build
from fecontact.mesh.check import check_cells
from fecontact.mesh.facets import components
from fecontact.mesh.formats.raw import RawMesh, numbers_of
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.orient import ClosedComponents, corner_areas
from fecontact.mesh.pick import shared_sides
from fecontact.mesh.placement import unfolded
from fecontact.mesh.refine import divided
from fecontact.mesh.smooth_parts import SMOOTH

T = TypeVar("T")

#: Program of the process: the same modules as here, whatever the main script is.
_START = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from fecontact.mesh.gmsh import serve; serve(sys.argv[2])"
)
#: Last lines of what the process printed that a message repeats.
LAST_LINES = 4


def run_in_subprocess(what: str, function: Callable[..., T], *arguments: Any) -> T:
    """Result of a function of this package, called in a fresh interpreter.

    Arguments and result go through files of a temporary folder. An interruption ends the process too.

    Parameters
    ----------
    what : str
        What is done, for the message of a crash.
    function : callable
        A function of a module of the package.
    *arguments

    Raises
    ------
    FecontactError
        What the function raises.
    MeshError
        If it raises another error, or its process ends without a result; with the last lines that it printed.

    Examples
    --------
    >>> from fecontact import shapes
    >>> run_in_subprocess("A block", shapes.block, (1.0, 1.0, 1.0), (1, 1, 1))
    Mesh(hex20, 1 cells, 20 points, boundaries: x_min, x_max, y_min, y_max, bottom, top)
    """
    with tempfile.TemporaryDirectory(prefix="fecontact-") as name:
        folder = Path(name)
        (folder / "task").write_bytes(pickle.dumps((function, arguments)))
        path = json.dumps([entry for entry in sys.path if isinstance(entry, str)])
        with (folder / "said").open("wb") as said:
            code = subprocess.run(
                [sys.executable, "-c", _START, path, name], stdin=subprocess.DEVNULL, stdout=said, stderr=said
            ).returncode
        if not (folder / "reply").exists():
            raise MeshError(f"{what} ended its process ({_ending(code)}). {_last_output(folder / 'said')}")
        good, value = pickle.loads((folder / "reply").read_bytes())
    if not good:
        raise value
    return value


def serve(folder: str) -> None:
    """Run the task in a folder and write the reply beside it; called in the fresh interpreter."""
    place = Path(folder)
    function, arguments = pickle.loads((place / "task").read_bytes())
    try:
        reply = (True, function(*arguments))
    except FecontactError as error:
        reply = (False, error)
    (place / "part").write_bytes(pickle.dumps(reply))
    os.replace(place / "part", place / "reply")


def _ending(code: int) -> str:
    """How a process ended, by its exit code."""
    try:
        return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit {code}"
    except ValueError:
        return f"signal {-code}"


def _last_output(said: Path) -> str:
    lines = [line.strip() for line in said.read_text(encoding="utf-8", errors="replace").splitlines() if line.strip()]
    return "Last output: " + " / ".join(lines[-LAST_LINES:]) if lines else "No output."


#: Default number of elements along the diagonal of the bounding box.
DEFAULT_DIVISIONS = 15
#: Edge of a tetrahedron over the edge of the hexahedra it is divided into.
_DIVIDED = 2.0
#: By gmsh's number of a solid or surface element: kind of cell or number of corners, and number of nodes.
_SOLIDS = {4: ("tet4", 4), 11: ("tet10", 10), 5: ("hex8", 8), 17: ("hex20", 20), 6: ("wedge6", 6), 18: ("wedge15", 15)}
_FACETS = {2: (3, 3), 9: (3, 6), 3: (4, 4), 16: (4, 8)}


@dataclass(frozen=True, eq=False)
class Sizes:
    """Elements that are wanted, and their sizes; see `surfaces.solid.mesh_solid`.

    Attributes
    ----------
    size : float, optional
    element : str
    near : (n, 3) array, optional
    near_size : float, optional
    growth : float
    """

    size: float | None
    element: str
    near: Array | None
    near_size: float | None
    growth: float

    @classmethod
    def of(
        cls, size: float | None, element: str, near: ArrayLike | None, near_size: float | None, growth: float
    ) -> Sizes:
        """The same, checked.

        Raises
        ------
        InputError
        """
        among("element of gmsh", element, ("tet4", "tet10", "hex8", "hex20"))
        given = {"size": size, "near_size": near_size, "growth": growth}
        lengths(**{name: value for name, value in given.items() if value is not None})
        centres = None if near is None else np.atleast_2d(point_array("near", near, 3))
        if centres is not None and (centres.ndim != 2 or not len(centres)):
            raise InputError(f"near must be points of shape (3,) or (n, 3); found shape {centres.shape}.")
        return cls(size, element, centres, near_size, growth)

    def measured(self, middle: Array, unit: float) -> Sizes:
        """The same in another unit, from another origin (3,)."""
        size, near_size = (None if s is None else s / unit for s in (self.size, self.near_size))
        near = None if self.near is None else (self.near - middle) / unit
        return replace(self, size=size, near=near, near_size=near_size)

    def finer(self, share: float, diagonal: float) -> Sizes:
        """Sizes times a factor, in a box of a diagonal."""
        size = diagonal / DEFAULT_DIVISIONS if self.size is None else self.size
        return replace(self, size=share * size, near_size=None if self.near_size is None else share * self.near_size)

    @property
    def is_quadratic(self) -> bool:
        """Whether elements have nodes in the middle of their edges."""
        return self.element in ("tet10", "hex20")

    @property
    def is_hexahedral(self) -> bool:
        """Whether tetrahedra are divided into hexahedra."""
        return self.element.startswith("hex")


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


def set_sizes(gmsh: Any, sizes: Sizes) -> None:
    """Element size: constant, or growing with the distance from the contact zone."""
    near = sizes.near
    low, high = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
    far = float(np.linalg.norm(high - low)) / DEFAULT_DIVISIONS if sizes.size is None else sizes.size
    fine = far / 4 if sizes.near_size is None else sizes.near_size
    factor = _DIVIDED if sizes.is_hexahedral else 1.0
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
    field.setString(2, "F", f"{factor!r} * Min({far!r}, {fine!r} + {sizes.growth!r} * F1)")
    field.setAsBackgroundMesh(2)


def generate(gmsh: Any, quadratic: bool, dimension: int = 3) -> None:
    """Tetrahedra or triangles, with straight edges unless they are quadratic."""
    option = gmsh.option.setNumber
    option("Mesh.ElementOrder", 2 if quadratic else 1)
    option("Mesh.SecondOrderIncomplete", 1)
    option("Mesh.HighOrderOptimize", 2)
    option("Mesh.Algorithm3D", 1)
    option("Mesh.Optimize", 1)
    option("General.NumThreads", 1)
    gmsh.model.mesh.generate(dimension)


def raw_mesh(gmsh: Any, source: str) -> RawMesh:
    """The mesh in gmsh, with physical groups by name and all entities by number."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    ids = np.asarray(tags, dtype=np.int64)
    blocks: list[tuple[str, IntArray]] = []
    groups: dict[str, list[IntArray]] = {}
    facets: dict[str, list[IntArray]] = {}
    start = 0
    own = solid_names(gmsh)
    for _, entity in gmsh.model.getEntities(3):
        names = [f"volume_{entity}", *own.get(entity, ()), *_physical(gmsh, 3, entity)]
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


#: How names begin that OpenCASCADE gives where there are none.
UNNAMED = "Open CASCADE STEP translator"


def solid_names(gmsh: Any) -> dict[int, list[str]]:
    """Name of each named solid by its number; of several of one name the later ones get numbers: nut, nut_2, ...

    gmsh's label is the path through the assembly, with the layer after the name.
    """
    count: dict[str, int] = {}
    out = {}
    for _, tag in gmsh.model.getEntities(3):
        label = gmsh.model.getEntityName(3, tag).split("/")[-1].split(" & ")[0].strip()
        if label and not label.startswith(UNNAMED):
            count[label] = count.get(label, 0) + 1
            out[tag] = [label if count[label] == 1 else f"{label}_{count[label]}"]
    return out


def _physical(gmsh: Any, dim: int, entity: int) -> list[str]:
    tags = gmsh.model.getPhysicalGroupsForEntity(dim, entity)
    names = [gmsh.model.getPhysicalName(dim, tag) for tag in tags]
    return [name for name in names if name]


#: Distance, relative to the size of the mesh, within which a node lies on the model.
ON_MODEL = 1e-10


def on_model(gmsh: Any, mesh: Mesh) -> Mesh:
    """Place the nodes of boundaries 'surface_1', ... on the faces and edges of the model that gmsh holds.

    Where a cell would fold, its nodes are drawn back.

    Parameters
    ----------
    gmsh : module
    mesh : Mesh
        In the model's unit. Flat faces and straight edges have their nodes already.

    Returns
    -------
    Mesh
        With the same cells; the same object if nothing moves.
    """
    known = {tag for _, tag in gmsh.model.occ.getEntities(2)}
    nodes = {tag: mesh.boundary_nodes(f"surface_{tag}") for tag in known if f"surface_{tag}" in mesh.boundaries}
    points = mesh.points.copy()
    for tag, own in nodes.items():
        if gmsh.model.getType(2, tag) != "Plane":
            points[own] = _closest(gmsh, 2, tag, mesh.points[own])
    faces_of = {
        tag: [f for f in gmsh.model.getAdjacencies(1, tag)[0] if f in nodes] for _, tag in gmsh.model.occ.getEntities(1)
    }
    apart = np.full(len(points), np.inf)
    for tag, faces in faces_of.items():
        if len(faces) != 2:
            continue  # the seam of a face that closes in itself
        both = np.intersect1d(nodes[faces[0]], nodes[faces[1]])
        found = _closest(gmsh, 1, tag, mesh.points[both])
        distance = np.linalg.norm(found - mesh.points[both], axis=1)
        nearer = distance < apart[both]
        points[both[nearer]], apart[both[nearer]] = found[nearer], distance[nearer]
    moved = np.linalg.norm(points - mesh.points, axis=1) > ON_MODEL * np.linalg.norm(np.ptp(points, axis=0))
    return unfolded(mesh, np.where(moved[:, None], points, mesh.points), moved)[0] if moved.any() else mesh


def _closest(gmsh: Any, dim: int, tag: int, points: Array) -> Array:
    """Closest points (n, 3) of a face or an edge."""
    return np.reshape(gmsh.model.getClosestPoint(dim, tag, points.ravel())[0], (-1, 3)) if len(points) else points


#: Rounding of the corners of a box, over its diagonal.
BOX = 1e-5

SUFFIXES = (".step", ".stp", ".brep", ".geo", ".iges", ".igs")


def mesh_cad(path: Path, sizes: Sizes, scale: float = 1.0, run_script: bool = False, part: str | None = None) -> Mesh:
    """Mesh the solids of a CAD file; parameters as in `surfaces.solid.mesh_solid`.

    Raises
    ------
    MissingPackageError, InputError
    MeshError
        If gmsh cannot read or mesh the file, or its process crashes; its message is passed on.
    """
    flag("run_script", run_script)
    lengths(scale=scale)
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"Unknown CAD file type {path.suffix!r}; expected one of {', '.join(SUFFIXES)}.")
    if not path.is_file():
        raise InputError(f"There is no file {path}.", code="no-file")
    if path.suffix.lower() == ".geo" and not run_script:
        raise InputError(
            f"{path.name} is a gmsh script, which can run any program on this machine. If it is yours, run it by "
            "fc.mesh_solid(path, run_script=True), or mesh it with gmsh and read the .msh file.",
            code="script-not-allowed",
        )
    mesh = run_in_subprocess(f"gmsh, which was to mesh {path.name},", _meshed, path.absolute(), sizes, part)
    return mesh if scale == 1 else mesh.scaled(scale)


@dataclass(frozen=True)
class CadSolid:
    """A solid of a CAD file.

    Attributes
    ----------
    name : str
    volume : float
    low, high : (3,) tuples
        Corners of its box.
    faces : int
    """

    name: str
    volume: float
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    faces: int


def cad_solids(path: Path) -> list[CadSolid]:
    """The solids of a CAD file, in its order; errors as `mesh_cad`."""
    if not path.is_file():
        raise InputError(f"There is no file {path}.", code="no-file")
    return run_in_subprocess(f"gmsh, which was to read {path.name},", _listed, path.absolute())


def _listed(path: Path) -> list[CadSolid]:
    gmsh = _opened(path)
    names = solid_names(gmsh)
    out = []
    for _, tag in gmsh.model.getEntities(3):
        box = np.array(gmsh.model.occ.getBoundingBox(3, tag))
        # OpenCASCADE adds a tolerance
        grain = BOX * np.linalg.norm(box[3:] - box[:3])
        box = (np.round(box / grain) * grain + 0.0).tolist()
        faces = len(gmsh.model.getBoundary([(3, tag)]))
        name = names.get(tag, [f"volume_{tag}"])[0]
        out.append(CadSolid(name, gmsh.model.occ.getMass(3, tag), tuple(box[:3]), tuple(box[3:]), faces))
    return out


def _opened(path: Path) -> Any:
    """The module gmsh with a CAD file."""
    gmsh = load_gmsh()
    gmsh.initialize(["fecontact"], readConfigFiles=False)
    gmsh.model.add("fecontact")
    try:
        _load(gmsh, path)
    except MeshError:
        raise
    except Exception as error:  # gmsh raises plain Exception with its message
        raise MeshError(f"gmsh could not read {path.name}: {error}") from error
    return gmsh


def _keep(gmsh: Any, part: str, source: str) -> None:
    """Leave the solid of a name alone in the model."""
    tags = [tag for _, tag in gmsh.model.getEntities(3)]
    named = {name: tag for tag, (name,) in solid_names(gmsh).items()}
    known = {f"volume_{tag}": tag for tag in tags} | named
    if part not in known:
        listed = ", ".join(map(repr, named or known))
        raise InputError(f"{source} has no solid {part!r}; its solids are: {listed}.", code="unknown")
    gmsh.model.occ.remove([(3, tag) for tag in tags if tag != known[part]], recursive=True)
    gmsh.model.occ.synchronize()
    # alone it is no longer the second of its name
    gmsh.model.setEntityName(3, known[part], next((name for name, tag in named.items() if tag == known[part]), ""))


def _meshed(path: Path, sizes: Sizes, part: str | None) -> Mesh:
    """The mesh in the file's unit, in a process that ends with it."""
    gmsh = _opened(path)
    if part is not None:
        _keep(gmsh, part, path.name)
    try:
        set_sizes(gmsh, sizes)
        generate(gmsh, sizes.is_quadratic)
    except Exception as error:  # gmsh raises plain Exception with its message
        raise MeshError(f"gmsh could not mesh {path.name}: {error}") from error
    try:
        mesh = build(raw_mesh(gmsh, path.name), path.name)
        check_cells(mesh)
    except MeshError:
        if not sizes.is_quadratic:
            raise
        # its curved cells fold: straight ones, whose nodes are placed as far as none does
        gmsh.model.mesh.clear()
        generate(gmsh, quadratic=False)
        mesh = build(raw_mesh(gmsh, path.name), path.name).upgraded(20)
    return on_model(gmsh, divided(mesh) if sizes.is_hexahedral else mesh)


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


#: Angles (radians) between facets above which their side stays an edge of the mesh: the second one, at which none
#: does, where gmsh cannot map the pieces of the first, as on rough surfaces.
SHARP = (float(np.arccos(SMOOTH)), float(np.pi))
#: Note on a mesh of the second angle.
ROUNDED = "gmsh could not divide the surface along its sharp edges, so they are rounded off by an element"


def tetrahedra_within(
    points: Array, triangles: IntArray, shells: ClosedComponents, sizes: Sizes, source: str
) -> tuple[Mesh, IntArray]:
    """Linear tetrahedra within a closed surface, made by gmsh in a process of its own.

    Parameters
    ----------
    points : (n_points, 3) array
    triangles : (n, 3) int array
    shells : ClosedComponents
    sizes : Sizes
    source : str
        Name of the surface, for messages.

    Returns
    -------
    Mesh
        Boundaries 'surface_1', 'surface_2', ... from the largest: the parts of the surface between sharp edges, its
        whole where it has none. Element sets 'volume_1', ...: its solids.
    (n,) int array
        The part that each of the triangles belongs to, from 0.

    Raises
    ------
    MissingPackageError
    MeshError
        If gmsh fails; its message is passed on.
    """
    middle, unit = _unit(points)
    what, given = f"gmsh, which was to mesh {source},", ((points - middle) / unit, triangles, shells)
    mesh, part = run_in_subprocess(what, _meshed_surface, *given, sizes.measured(middle, unit), source)
    return replace(mesh, points=unit * mesh.points + middle), part


def _unit(points: Array) -> tuple[Array, float]:
    """Middle (3,) of points and diagonal of their box: gmsh has tolerances in units of length."""
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, float(np.linalg.norm(high - low))


def facets_of_size(
    points: Array, triangles: IntArray, sizes: Sizes, source: str
) -> tuple[Array, IntArray, IntArray, IntArray, tuple[str, ...]]:
    """Other triangles on a surface, open or closed, with corners on the old ones; by gmsh in a process of its own.

    Parameters and errors as in `tetrahedra_within`.

    Returns
    -------
    points : (n_new_points, 3) array
    triangles : (n_new, 3) int array
    part_of_new, part : (n_new,) and (n,) int arrays
        The part between sharp edges that each new and each old triangle belongs to.
    notes : tuple of str
    """
    middle, unit = _unit(points)
    what, given = f"gmsh, which was to mesh {source},", ((points - middle) / unit, triangles)
    x, new, part_of_new, part, notes = run_in_subprocess(what, _remeshed, *given, sizes.measured(middle, unit), source)
    return unit * x + middle, new, part_of_new, part, notes


def _meshed_surface(
    points: Array, triangles: IntArray, shells: ClosedComponents, sizes: Sizes, source: str
) -> tuple[Mesh, IntArray]:
    """`tetrahedra_within` in the process that ends with it."""
    gmsh, entity, part, notes = _generated(points, triangles, shells, sizes, source)
    mesh = _named(build(raw_mesh(gmsh, source), source), entity, part)
    return replace(mesh, notes=(*mesh.notes, *notes)), part


def _remeshed(
    points: Array, triangles: IntArray, sizes: Sizes, source: str
) -> tuple[Array, IntArray, IntArray, IntArray, tuple[str, ...]]:
    """`facets_of_size` in the process that ends with it."""
    gmsh, entity, part, notes = _generated(points, triangles, None, sizes, source)
    tags, first = np.unique(entity, return_index=True)
    new = [np.reshape(gmsh.model.mesh.getElements(2, tag)[2][0], (-1, 3)) for tag in tags]
    ids, coordinates, _ = gmsh.model.mesh.getNodes()
    of = np.repeat(part[first], [len(t) for t in new])
    used, number = np.unique(np.concatenate(new), return_inverse=True)
    order = np.argsort(ids)
    x = np.reshape(coordinates, (-1, 3))[order[np.searchsorted(ids[order], used)]]
    return x, number.reshape(-1, 3), of, part, notes


def _generated(
    points: Array, triangles: IntArray, shells: ClosedComponents | None, sizes: Sizes, source: str
) -> tuple[Any, IntArray, IntArray, tuple[str, ...]]:
    """The module gmsh with the new mesh, the entity and part (n,) of each old triangle, and notes."""
    gmsh = load_gmsh()
    gmsh.initialize(["fecontact"], readConfigFiles=False)
    said = ""
    for angle in SHARP:
        try:
            entity = _classified(gmsh, points, triangles, angle)
            set_sizes(gmsh, sizes)
            if shells is not None:
                _add_solids(gmsh, entity, shells)
            generate(gmsh, quadratic=False, dimension=2 if shells is None else 3)
            _refuse_empty(gmsh)
        except Exception as error:  # gmsh raises plain Exception with its message
            said = said or str(error)
            continue
        notes = (f"{source}: {ROUNDED}.",) if angle != SHARP[0] else ()
        return gmsh, entity, smooth_pieces(points, triangles, angle, entity), notes
    raise MeshError(
        f"gmsh could not mesh {source}: {said} Smaller elements follow the surface better, and a smoother surface has "
        "fewer sharp edges (fc.repair_surface)."
    )


def _classified(gmsh: Any, points: Array, triangles: IntArray, angle: float) -> IntArray:
    """Give gmsh the surface, divided along its sharp edges; the entity (n,) of each triangle."""
    gmsh.clear()
    gmsh.model.add("fecontact")
    gmsh.model.addDiscreteEntity(2, 1)
    gmsh.model.mesh.addNodes(2, 1, np.arange(1, len(points) + 1), points.ravel())
    gmsh.model.mesh.addElementsByType(1, 2, np.arange(1, len(triangles) + 1), (triangles + 1).ravel())
    gmsh.model.mesh.classifySurfaces(angle, True, True, np.pi)
    entity = np.zeros(len(triangles), np.int64)
    for _, tag in gmsh.model.getEntities(2):
        entity[np.asarray(gmsh.model.mesh.getElements(2, tag)[1][0], dtype=np.int64) - 1] = tag
    gmsh.model.mesh.createGeometry()
    return entity


def _add_solids(gmsh: Any, entity: IntArray, shells: ClosedComponents) -> None:
    loop = [gmsh.model.geo.addSurfaceLoop(np.unique(entity[shells.shell == k])) for k in range(shells.shell.max() + 1)]
    for solid in shells.solids:
        gmsh.model.geo.addVolume([loop[k] for k in solid])
    gmsh.model.geo.synchronize()


def _refuse_empty(gmsh: Any) -> None:
    """Refuse a solid without cells: gmsh goes on where its new facets cross."""
    if not all(gmsh.model.mesh.getElementTypes(3, tag).size for _, tag in gmsh.model.getEntities(3)):
        raise MeshError(gmsh.logger.getLastError() or "its new facets enclose no solid.")


def smooth_pieces(
    points: Array, triangles: IntArray, angle: float = SHARP[0], entity: IntArray | None = None
) -> IntArray:
    """Part (n,) of each triangle: those that meet at a side that is not sharp are one; numbered from the largest.

    Triangles of one entity are together anyway.
    """
    facets = triangles[:, [0, 1, 2, 2]]
    first, second, cosine = shared_sides(points, facets, None)
    pairs = np.stack([first // 4, second // 4], axis=1)[cosine > np.cos(angle)]
    tags, number = np.unique(np.arange(len(triangles)) if entity is None else entity, return_inverse=True)
    part = components(len(tags), number[pairs])[number]
    rank = np.argsort(np.argsort(-np.bincount(part, corner_areas(points, facets)), kind="stable"))
    return np.asarray(rank[part], dtype=np.int64)


def _named(mesh: Mesh, entity: IntArray, part: IntArray) -> Mesh:
    """The mesh with a boundary for each part instead of each entity."""
    tags, first = np.unique(entity, return_index=True)
    faces = [mesh.boundaries[f"surface_{tag}"] for tag in tags]
    of = part[first]
    names = {
        f"surface_{k + 1}": np.concatenate([f for f, p in zip(faces, of, strict=True) if p == k]) for k in np.unique(of)
    }
    groups = {f"volume_{k + 1}": members for k, members in enumerate(mesh.groups.values())}
    return replace(mesh, boundaries=names, groups=groups)
