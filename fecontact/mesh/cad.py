"""Meshes of CAD files by gmsh: all hexahedra or tetrahedra, refined where contact is expected.

gmsh runs in a process of its own for each call (`mesh.apart`): an abort ends that process alone, and an open gmsh
session of the caller stays as it is.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fecontact.common.arguments import flag
from fecontact.common.checks import lengths
from fecontact.common.errors import InputError, MeshError
from fecontact.mesh.apart import run_apart
from fecontact.mesh.build import build
from fecontact.mesh.cad_faces import on_model
from fecontact.mesh.gmsh_session import Sizes, generate, load_gmsh, raw_mesh, set_sizes
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.tet_to_hex import divided

SUFFIXES = (".step", ".stp", ".brep", ".geo", ".iges", ".igs")


def mesh_cad(path: Path, sizes: Sizes, scale: float = 1.0, run_script: bool = False) -> Mesh:
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
        raise InputError(f"There is no file {path}.")
    if path.suffix.lower() == ".geo" and not run_script:
        raise InputError(
            f"{path.name} is a gmsh script, which can run any program on this machine. If it is yours, run it by "
            "fc.mesh_solid(path, run_script=True), or mesh it with gmsh and read the .msh file."
        )
    mesh = run_apart(f"gmsh, which was to mesh {path.name},", _meshed, path.absolute(), sizes)
    return mesh if scale == 1 else mesh.scaled(scale)


def _meshed(path: Path, sizes: Sizes) -> Mesh:
    """The mesh in the file's unit, in a process that ends with it."""
    gmsh = load_gmsh()
    gmsh.initialize(["fecontact"], readConfigFiles=False)
    gmsh.model.add("fecontact")
    try:
        _load(gmsh, path)
        set_sizes(gmsh, sizes)
        generate(gmsh, sizes.is_quadratic)
    except MeshError:
        raise
    except Exception as error:  # gmsh raises plain Exception with its message
        raise MeshError(f"gmsh could not mesh {path.name}: {error}") from error
    mesh = build(raw_mesh(gmsh, path.name), path.name)
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
