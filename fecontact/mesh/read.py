"""Read meshes from files of all formats, with checks; names are kept.

Wedges, pyramids and tetrahedra become degenerate 20-node hexahedra, with exact quadratic functions (see
`mesh.element`) and pass the patch tests; a 4-node tetrahedron or 6-node wedge becomes a degenerate 8-node
hexahedron. The order of mid-edge and face nodes differs between programs, so it is found from their positions.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from fecontact.common.arguments import file_path, function, text
from fecontact.common.checks import among, positive
from fecontact.common.errors import InputError
from fecontact.mesh.build import ELEMENTS, build
from fecontact.mesh.formats.abaqus import read_abaqus
from fecontact.mesh.formats.febio import read_febio
from fecontact.mesh.formats.generic import read_vtk
from fecontact.mesh.formats.gmsh import read_gmsh
from fecontact.mesh.formats.raw import RawMesh, part_of
from fecontact.mesh.gmsh import SUFFIXES as CAD
from fecontact.mesh.gmsh import Sizes, mesh_cad
from fecontact.mesh.mesh import Mesh

READERS: dict[str, Callable[[Path], RawMesh]] = {
    ".msh": read_gmsh,
    ".inp": read_abaqus,
    ".feb": read_febio,
    ".vtk": read_vtk,
    ".vtu": read_vtk,
    ".xdmf": read_vtk,
}
SURFACES = (".stl", ".ply", ".obj", ".off", ".vtp")


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
