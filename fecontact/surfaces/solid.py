"""Solids of CAD files and of closed surfaces, meshed by gmsh, and by fTetWild where gmsh does not follow a surface.

What a surface's facets stand for is kept: the nodes of the new mesh are placed on the smooth surface through the old
corners (`surfaces.smooth`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import file_path, spelled
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import lengths
from fecontact.common.errors import MeshError, place
from fecontact.common.progress import progress_line, set_stage
from fecontact.mesh.check import check_cells
from fecontact.mesh.envelope import INSTALL, available, tetrahedra_in_envelope
from fecontact.mesh.gmsh import DEFAULT_DIVISIONS, Sizes, mesh_cad, tetrahedra_within
from fecontact.mesh.mending import bisected, without_holes
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.orient import ClosedComponents, closed_components, corner_areas
from fecontact.mesh.placement import Placement, placed
from fecontact.mesh.read import POLYGON_READERS, loose_triangles, read_polygons, read_surface
from fecontact.mesh.refine import divided
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.repair import changed, distance, enclosed_volume, triangulated
from fecontact.surfaces.smooth import fitted_facets

#: Error of the volume, and distance from the surface over its size, up to which a mesh is not made finer.
CLOSE = 0.01
#: Area of holes over that of the surface up to which they are filled, and the most sides of one.
HOLES, MOST_SIDES = 0.1, 500
#: Half widths of the envelopes that are tried, over the diagonal of the surface's box.
ENVELOPES = (2e-3, 5e-4)
#: Facets above which gmsh's smaller elements are tried before an envelope, whose time grows with them (40 s of
#: processor time for 30,000 facets, gmsh's 3 s). The smooth surface through so many has their own volume: on a ball of
#: n triangles of side a the difference is 3 a^2 / (8 R^2) = 2 sqrt(3) pi / n of it, 1.1e-3.
MANY = 10_000
#: Parts of an element's edge into which facets are divided.
NEAR_NODES = 6
#: What notes say of an envelope.
ENVELOPED = (
    "It was meshed in an envelope of its facets (fTetWild), nodes on them; another run gives other cells, so save what "
    "is to be kept."
)
WOUND = f"What its facets wind round by more than one half is meshed. {ENVELOPED}"
#: How often it is made finer, the least and largest share of the size then, and the most cells that come of it.
MAX_TRIALS, SHARES, MAX_CELLS = 2, (0.4, 0.8), 20_000


@spelled
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
    part: str | None = None,
    progress: bool | None = None,
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
    part : str, optional
        Mesh this solid alone: by its name in an assembly of STEP (of several of one name the later are ``nut_2``,
        ``nut_3``, ...; `fecontact explain part.step` lists them), or 'volume_1', ...
    progress : bool, optional
        Whether a line shows what is being done; where standard error is a terminal unless given.

    Returns
    -------
    Mesh
        Boundaries 'surface_1', 'surface_2', ... : those of CAD files as gmsh numbers them; parts of a surface between
        edges sharper than 40 degrees, from the largest. Element sets 'volume_1', ..., and solids of STEP and physical
        groups of a ``.geo`` file by their names. Name others with `fecontact.pick`. A note says how far a surface was
        changed. A mesh within a surface that is more than 1 % off in volume, or in distance over its size, is made anew
        unless `size` is given, and one whose cells fold always: in an envelope of the facets (`mesh.envelope`) where
        pytetwild is installed, with smaller elements otherwise, and first if there are over 10,000 facets. So is a
        surface that crosses itself or branches. A warning, which results repeat, says what is left. Small holes are
        filled, with a note.

    Raises
    ------
    MissingPackageError, InputError
    MeshError
        If a surface is open, faces inwards or, without pytetwild, runs through itself, with the place and what to do.
        If gmsh cannot read or mesh the file, or its process crashes; its message is passed on. If its cells fold.

    Examples
    --------
    >>> import fecontact as fc
    >>> block = fc.shapes.block((2.0, 1.0, 1.0), (4, 2, 2), element="hex8")
    >>> skin = fc.SurfaceMesh(block.points, block.skin)
    >>> sorted(mesh_solid(skin, size=0.5).boundaries)
    ['surface_1', 'surface_2', 'surface_3', 'surface_4', 'surface_5', 'surface_6']
    """
    sizes = Sizes.of(size, element, near, near_size, growth)
    lengths(scale=scale)
    with progress_line("mesh_solid", progress):
        if isinstance(source, SurfaceMesh):
            mesh = _within(source, sizes, "the surface")
        else:
            path = file_path("the path of a solid", source)
            if path.suffix.lower() not in POLYGON_READERS:
                return mesh_cad(path, sizes, scale, run_script, part)
            mesh = _within_file(path, sizes)
    mesh = mesh if part is None else mesh.part(part)
    return mesh if scale == 1 else mesh.scaled(scale)


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


def _within_file(path: Path, sizes: Sizes) -> Mesh:
    """Mesh of what the facets of a file enclose, be they a surface or not."""
    try:
        surface = read_surface(path)
    except MeshError as error:
        if not available():
            raise MeshError(f"{error} {INSTALL}", code=error.code) from error
        points, triangles = loose_triangles(*read_polygons(path), path.name)
        best = _enveloped(points, triangles, sizes, path.name, closed=False)
        return _told(best, path.name, (f"{path.name} is no surface with an outside: {error} {WOUND}",))
    return _within(surface, sizes, path.name)


def _within(surface: SurfaceMesh, sizes: Sizes, source: str) -> Mesh:
    """Mesh of what a surface encloses: by gmsh, and where this does not follow the surface, in an envelope of it."""
    points, triangles = triangulated(surface)
    triangles, notes = _closed(points, triangles, source)
    notes = (*surface.notes, *notes)
    try:
        shells = closed_components(points, triangles, source)
    except MeshError as error:
        if error.code != "crosses-itself":
            raise
        if not available():
            raise MeshError(f"{error} {INSTALL}", code=error.code) from error
        return _told(_enveloped(points, triangles, sizes, source, closed=False), source, (*notes, f"{error} {WOUND}"))
    best: _Trial | None = None
    told: tuple[str, ...] = ()
    said = f"{source}: gmsh's elements of this size do not follow the surface."
    try:
        tries = MAX_TRIALS if len(triangles) > MANY or not available() else 0
        best, told = _best_of_gmsh(points, triangles, shells, sizes, source, tries)
    except MeshError as error:
        if not available():
            raise
        said = str(error)
    wanting = best is None or best.fault is not None or (best.off > CLOSE and sizes.size is None)
    if wanting and available():
        now = _enveloped(points, triangles, sizes, source, closed=True)
        if best is None or now.off < best.off:
            best, told = now, (f"{said} {ENVELOPED}",)
    assert best is not None
    return _told(best, source, (*notes, *told))


def _closed(points: Array, triangles: IntArray, source: str) -> tuple[IntArray, tuple[str, ...]]:
    """Triangles (n, 3) with holes filled, and a note, where these are a small part of the surface."""
    n = len(triangles)
    filled, count = without_holes(points, triangles, MOST_SIDES)
    area = corner_areas(points, filled[:, [0, 1, 2, 2]])
    if count == 0 or area[n:].sum() > HOLES * area[:n].sum():
        return triangles, ()
    where = place(points[filled[n:][np.argmax(area[n:])]].mean(axis=0))
    share = 100 * area[n:].sum() / area[:n].sum()
    holes = f"{count} holes were" if count > 1 else "a hole was"
    return filled, (f"{source}: {holes} filled with flat facets, {share:.2g} % of its area, the largest at {where}.",)


def _told(best: _Trial, source: str, notes: tuple[str, ...]) -> Mesh:
    """The best mesh with all notes and warnings."""
    if best.fault is not None:
        raise MeshError(
            f"{source} is too thin or too curved for elements of this size: {best.fault} Take a smaller size."
        )
    warnings = best.mesh.warnings
    if best.off > CLOSE:
        warnings += (
            f"{source}: the volume of the mesh is {100 * best.volume:.2g} % off and its surface up to "
            f"{100 * best.away:.2g} % of its size from the facets. Smaller elements (size=) follow it better.",
        )
    return replace(best.mesh, notes=(*notes, *best.mesh.notes), warnings=warnings)


def _best_of_gmsh(
    points: Array, triangles: IntArray, shells: ClosedComponents, sizes: Sizes, source: str, tries: int
) -> tuple[_Trial, tuple[str, ...]]:
    """The best of 1 + tries meshes, and a note where its size was made smaller."""
    set_stage("gmsh")
    best = _trial(points, triangles, shells, sizes, source)
    told: tuple[str, ...] = ()
    wanted = sizes.size is not None
    for _ in range(tries):
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
    return best, told


def _enveloped(points: Array, triangles: IntArray, sizes: Sizes, source: str, closed: bool) -> _Trial:
    """The best mesh in envelopes of triangles, the second where thin parts are lost in the first."""
    tried: list[_Trial] = []
    for width in ENVELOPES:
        set_stage(f"fTetWild, envelope of {width:g}")
        tried.append(_in_envelope(points, triangles, sizes, width, source, closed))
        if tried[-1].off <= CLOSE:
            break
    return min(tried, key=lambda trial: trial.off)


def _in_envelope(points: Array, triangles: IntArray, sizes: Sizes, width: float, source: str, closed: bool) -> _Trial:
    """One mesh in an envelope of triangles, its nodes on them; `closed` where they enclose a volume once."""
    edge = sizes.size if sizes.size is None or not sizes.is_hexahedral else 2 * sizes.size
    mesh = tetrahedra_in_envelope(points, triangles, edge, width, source)
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    facets = triangles[:, [0, 1, 2, 2]]
    # facets are found by nodes near them: in thin and crossing parts those of large ones are farther than others'
    small = (diagonal / DEFAULT_DIVISIONS if edge is None else edge) / NEAR_NODES
    base = FacetSurface(*bisected(points, triangles, small)[:2], source)
    mesh, drawn = _placed(mesh, dict.fromkeys(mesh.boundaries, Placement(base, np.zeros((0, 4)))), sizes)
    off = np.abs(base.project(mesh.points[np.unique(mesh.skin)]).gap)
    # corners of facets within the mesh are those of sheets within it; those outside were lost
    lost = FacetSurface(mesh.points, mesh.skin).project(points[np.unique(triangles)]).gap
    found = enclosed_volume(mesh.points, mesh.skin)
    if closed:
        volume = abs(found / enclosed_volume(points, facets) - 1)
    else:
        volume = float(off.mean() * corner_areas(mesh.points, mesh.skin).sum() / found)
    away = max(off.max(), lost.max()) / diagonal
    note = (
        f"{source}: {len(facets)} facets were replaced by {len(mesh.outer)} within {100 * away:.2g} % of its size"
        + (f", {drawn} nodes less far on them, lest cells fold." if drawn else ".")
    )
    ignored: tuple[str, ...] = ()
    if sizes.near is not None:
        ignored = (f"{source}: near= is not kept in an envelope; solve(accuracy=) makes elements near contact finer.",)
    return _Trial(replace(mesh, notes=(*mesh.notes, note), warnings=ignored), volume, float(away), _fault(mesh))


def _placed(mesh: Mesh, fits: Mapping[str, Placement], sizes: Sizes) -> tuple[Mesh, int]:
    """Elements of the wanted kind with nodes where they belong, and how many were drawn back."""
    mesh, drawn = placed(mesh.upgraded(20) if sizes.is_quadratic else mesh, fits)
    return placed(divided(mesh), fits) if sizes.is_hexahedral else (mesh, drawn)


def _fault(mesh: Mesh) -> MeshError | None:
    """Why no body can be made of a mesh."""
    try:
        check_cells(mesh)
    except MeshError as error:
        return error
    return None


def _trial(points: Array, triangles: IntArray, shells: ClosedComponents, sizes: Sizes, source: str) -> _Trial:
    """One mesh by gmsh."""
    mesh, part = tetrahedra_within(points, triangles, shells, sizes, source)
    facets = triangles[:, [0, 1, 2, 2]]
    fits = fitted_facets(points, facets, {f"surface_{k + 1}": part == k for k in range(part.max() + 1)})
    mesh, drawn = _placed(mesh, fits, sizes)
    held = f", {drawn} nodes less far on it, lest cells fold" if drawn else ""
    far = changed(points, facets, mesh.points, mesh.skin)
    told = f"{len(facets)} facets were replaced by {len(mesh.outer)}; {far}{held}"
    flat = enclosed_volume(points, facets)
    smooth = _smooth_volume(points, triangles, part, fits) if len(triangles) <= MANY else flat
    found = enclosed_volume(mesh.points, mesh.skin)
    low, high = sorted((flat, smooth))
    volume = max(low - found, found - high, 0.0) / abs(smooth)
    away = distance(points, facets, mesh.points, mesh.skin) / float(np.linalg.norm(np.ptp(points, axis=0)))
    return _Trial(replace(mesh, notes=(*mesh.notes, f"{source}: {told}.")), volume, away, _fault(mesh))


def _smooth_volume(points: Array, triangles: IntArray, part: IntArray, fits: Mapping[str, Placement]) -> float:
    """Volume within quadratic facets through the corners of triangles, the middles of their sides on the fits."""
    x, facets = [points], []
    start = len(points)
    for k in range(part.max() + 1):
        own = triangles[part == k]
        ends = np.sort(np.stack([own, np.roll(own, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        sides, which = np.unique(ends, axis=0, return_inverse=True)
        middles = points[sides].mean(axis=1)
        if (fit := fits.get(f"surface_{k + 1}")) is not None:
            middles = fit.placed(middles)
        ab, bc, ca = (start + which).reshape(-1, 3).T
        a, b, c = own.T
        facets.append(np.stack([a, b, c, c, ab, bc, c, ca], axis=1))
        x.append(middles)
        start += len(middles)
    return enclosed_volume(np.concatenate(x), np.concatenate(facets))
