"""Solids of CAD files and of closed surfaces, meshed by gmsh.

What a surface's facets stand for is kept: the nodes of the new mesh are placed on the smooth surface through the old
corners (`surfaces.smooth`).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from numpy.typing import ArrayLike

from fecontact.common.arguments import file_path
from fecontact.common.checks import lengths
from fecontact.mesh.cad import mesh_cad
from fecontact.mesh.gmsh_session import Sizes
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.placement import placed
from fecontact.mesh.read_surface import READERS, read_surface
from fecontact.mesh.remeshing import tetrahedra_within
from fecontact.mesh.shells import shells_of
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.mesh.tet_to_hex import divided
from fecontact.surfaces.changes import changed, triangulated
from fecontact.surfaces.smooth_fit import fitted_facets


def mesh_solid(
    source: str | Path | SurfaceMesh,
    size: float | None = None,
    element: str = "tet10",
    *,
    near: ArrayLike | None = None,
    near_size: float | None = None,
    growth: float = 0.5,
    scale: float = 1.0,
    run_script: bool = False,
) -> Mesh:
    """Mesh the solids of a CAD file, or within a closed surface.

    Parameters
    ----------
    source : str, Path or SurfaceMesh
        CAD: ``.step``, ``.stp``, ``.brep``, ``.iges``, or with `run_script` a gmsh script ``.geo``. A closed surface:
        ``.stl``, ``.ply``, ``.obj``, ``.off``, ``.vtp``, or one that was read or made. Its facets are replaced by
        others of the wanted size; several shells make several solids, and shells within others that face inwards are
        voids.
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
        Factor applied to the coordinates at the end; `size`, `near` and `near_size` are in the unit of the file.
    run_script : bool
        Whether a ``.geo`` file may be run. It is a program, which can start any other (gmsh's ``SystemCall``): run your
        own only.

    Returns
    -------
    Mesh
        Boundaries 'surface_1', 'surface_2', ... : those of CAD files as gmsh numbers them; parts of a surface between
        edges sharper than 40 degrees, from the largest. Element sets 'volume_1', ...; physical groups of a ``.geo``
        file by their names. Name others with `fecontact.pick`. A note tells how far a surface was changed.

    Raises
    ------
    MissingPackageError, InputError
    MeshError
        If a surface is open, runs through itself or faces inwards, with the place and what to do. If gmsh cannot read
        or mesh the file, or its process crashes; its message is passed on.

    Examples
    --------
    >>> import fecontact as fc
    >>> block = fc.shapes.block((2.0, 1.0, 1.0), (4, 2, 2), element="hex8")
    >>> skin = fc.SurfaceMesh(block.points, block.skin)
    >>> sorted(mesh_solid(skin, size=0.5).boundaries)
    ['surface_1', 'surface_2', 'surface_3', 'surface_4', 'surface_5', 'surface_6']
    """
    sizes = Sizes.of(size, element, near, near_size, growth)
    if isinstance(source, SurfaceMesh):
        return _within(source, sizes, "the surface", scale)
    path = file_path("the path of a solid", source)
    if path.suffix.lower() not in READERS:
        return mesh_cad(path, sizes, scale, run_script)
    return _within(read_surface(path), sizes, path.name, scale)


def _within(surface: SurfaceMesh, sizes: Sizes, source: str, scale: float) -> Mesh:
    """Mesh of what a surface encloses, its nodes on the smooth surface."""
    lengths(scale=scale)
    points, triangles = triangulated(surface)
    shells = shells_of(points, triangles, source)
    mesh, part = tetrahedra_within(points, triangles, shells, sizes, source)
    facets = triangles[:, [0, 1, 2, 2]]
    fits = fitted_facets(points, facets, {f"surface_{k + 1}": part == k for k in range(part.max() + 1)})
    mesh, drawn = placed(mesh.upgraded(20) if sizes.is_quadratic else mesh, fits)
    if sizes.is_hexahedral:
        mesh, drawn = placed(divided(mesh), fits)
    held = f", {drawn} nodes less far on it, lest cells fold" if drawn else ""
    far = changed(points, facets, mesh.points, mesh.skin)
    told = f"{len(facets)} facets were replaced by {len(mesh.outer)}; {far}{held}"
    mesh = replace(mesh, notes=(*surface.notes, *mesh.notes, f"{source}: {told}."))
    return mesh if scale == 1 else mesh.scaled(scale)
