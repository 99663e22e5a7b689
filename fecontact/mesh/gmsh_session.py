"""What meshing by gmsh shares, be it of CAD files or of surfaces: the module, sizes, and the mesh that it holds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, lengths, point_array
from fecontact.common.errors import InputError, MeshError, MissingPackageError
from fecontact.mesh.formats.raw import RawMesh, numbers_of

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
