"""Solids of CAD files and of closed surfaces, meshed by gmsh.

What a surface's facets stand for is kept: the nodes of the new mesh are placed on the smooth surface through the old
corners (`surfaces.smooth`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import file_path
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import lengths
from fecontact.common.errors import MeshError
from fecontact.mesh.check import check_cells
from fecontact.mesh.gmsh import Sizes, mesh_cad, tetrahedra_within
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.orient import ClosedComponents, closed_components
from fecontact.mesh.placement import Placement, placed
from fecontact.mesh.read import POLYGON_READERS, read_surface
from fecontact.mesh.refine import divided
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.surfaces.repair import changed, distance, enclosed_volume, triangulated
from fecontact.surfaces.smooth import fitted_facets

#: Error of the volume, and distance from the surface over its size, up to which a mesh is not made finer.
CLOSE = 0.01
#: How often it is made finer, the least and largest share of the size then, and the most cells that come of it.
MAX_TRIALS, SHARES, MAX_CELLS = 2, (0.4, 0.8), 20_000


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
        Hexahedra come from the division of tetrahedra twice as large into four each (`mesh.refine.divided`): they fit
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
        file by their names. Name others with `fecontact.pick`. A note says how far a surface was changed. A mesh
        within a surface that is more than 1 % off in volume, or in distance over its size, is made finer unless `size`
        is given, and one whose cells fold always; a warning, which results repeat, says what is left.

    Raises
    ------
    MissingPackageError, InputError
    MeshError
        If a surface is open, runs through itself or faces inwards, with the place and what to do. If gmsh
        cannot read or mesh the file, or its process crashes; its message is passed on. If its cells fold.

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
    if path.suffix.lower() not in POLYGON_READERS:
        return mesh_cad(path, sizes, scale, run_script)
    return _within(read_surface(path), sizes, path.name, scale)


@dataclass(frozen=True, eq=False)
class _Trial:
    """A mesh of what a surface encloses, with what is wrong with it.

    `volume` is its distance from what lies between the volume of the facets and that of the smooth surface through
    them, relative to it; `away` the largest distance of the facets' corners from it, relative to their size; `fault` is
    why no body could be made of it.
    """

    mesh: Mesh
    volume: float
    away: float
    fault: MeshError | None

    @property
    def off(self) -> float:
        """The larger of both; infinite for a mesh that cannot be used."""
        return np.inf if self.fault is not None else max(self.volume, self.away)


def _within(surface: SurfaceMesh, sizes: Sizes, source: str, scale: float) -> Mesh:
    """Mesh of what a surface encloses, its nodes on the smooth surface; finer where it is too far from it."""
    lengths(scale=scale)
    points, triangles = triangulated(surface)
    shells = closed_components(points, triangles, source)
    best = _trial(points, triangles, shells, sizes, source)
    told: tuple[str, ...] = ()
    wanted = sizes.size is not None
    for _ in range(MAX_TRIALS):
        # a size that was asked for is kept, with a warning, where a body can be made of the mesh
        if best.off <= CLOSE or (wanted and best.fault is None):
            break
        # errors go down with the square of the size
        share = float(np.clip(0.9 * np.sqrt(CLOSE / best.off), *SHARES))
        sizes = sizes.finer(share, float(np.linalg.norm(np.ptp(points, axis=0))))
        if len(best.mesh.cells) > MAX_CELLS * share**3:
            break
        try:
            now = _trial(points, triangles, shells, sizes, source)
        except MeshError:
            break
        if now.off < best.off:
            best = now
            told = (f"{source}: elements of size {sizes.size:.3g}, as larger ones do not follow the surface.",)
    if best.fault is not None:
        raise MeshError(
            f"{source} is too thin or too curved for elements of this size: {best.fault} Take a smaller size."
        )
    mesh = best.mesh
    warnings: tuple[str, ...] = ()
    if best.off > CLOSE:
        warnings = (
            f"{source}: the volume of the mesh is {100 * best.volume:.2g} % off and its surface up to "
            f"{100 * best.away:.2g} % of its size from the facets. Smaller elements (size=) follow it better.",
        )
    mesh = replace(mesh, notes=(*surface.notes, *told, *mesh.notes), warnings=warnings)
    return mesh if scale == 1 else mesh.scaled(scale)


def _trial(points: Array, triangles: IntArray, shells: ClosedComponents, sizes: Sizes, source: str) -> _Trial:
    """One mesh."""
    mesh, part = tetrahedra_within(points, triangles, shells, sizes, source)
    facets = triangles[:, [0, 1, 2, 2]]
    fits = fitted_facets(points, facets, {f"surface_{k + 1}": part == k for k in range(part.max() + 1)})
    mesh, drawn = placed(mesh.upgraded(20) if sizes.is_quadratic else mesh, fits)
    if sizes.is_hexahedral:
        mesh, drawn = placed(divided(mesh), fits)
    held = f", {drawn} nodes less far on it, lest cells fold" if drawn else ""
    far = changed(points, facets, mesh.points, mesh.skin)
    told = f"{len(facets)} facets were replaced by {len(mesh.outer)}; {far}{held}"
    fault = None
    try:
        check_cells(mesh)
    except MeshError as error:
        fault = error
    flat, smooth = enclosed_volume(points, facets), _smooth_volume(points, triangles, part, fits)
    found = enclosed_volume(mesh.points, mesh.skin)
    low, high = sorted((flat, smooth))
    volume = max(low - found, found - high, 0.0) / abs(smooth)
    away = distance(points, facets, mesh.points, mesh.skin) / float(np.linalg.norm(np.ptp(points, axis=0)))
    return _Trial(replace(mesh, notes=(*mesh.notes, f"{source}: {told}.")), volume, away, fault)


def _smooth_volume(points: Array, triangles: IntArray, part: IntArray, fits: Mapping[str, Placement]) -> float:
    """Volume within quadratic facets through the corners of triangles, the middles of their sides on the fits."""
    x, facets = [points], []
    start = len(points)
    for k in range(part.max() + 1):
        own = triangles[part == k]
        middles = ((points[own] + points[np.roll(own, -1, axis=1)]) / 2).reshape(-1, 3)
        if (fit := fits.get(f"surface_{k + 1}")) is not None:
            middles = fit.placed(middles)
        ab, bc, ca = (start + np.arange(3 * len(own))).reshape(-1, 3).T
        a, b, c = own.T
        facets.append(np.stack([a, b, c, c, ab, bc, c, ca], axis=1))
        x.append(middles)
        start += len(middles)
    return enclosed_volume(np.concatenate(x), np.concatenate(facets))
