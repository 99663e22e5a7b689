"""Repair of real surfaces, as scans and segmentations give them: facets, holes, noise and size; never silently.

A note tells how far the surface has moved and how its volume has changed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fecontact.common.arguments import file_path
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import positive, whole
from fecontact.common.errors import InputError
from fecontact.mesh.facets import facet_integrals
from fecontact.mesh.gmsh import Sizes, facets_of_size
from fecontact.mesh.mending import smoothed, without_holes, without_slivers
from fecontact.mesh.orient import rims
from fecontact.mesh.read import POLYGON_READERS, cut_facets, read_polygons
from fecontact.mesh.surface_mesh import SurfaceMesh, joined, welded
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.smooth import fitted_facets


def triangulated(surface: SurfaceMesh) -> tuple[Array, IntArray]:
    """Points (n_points, 3) in use, and triangles (n, 3) between the nodes of a surface, mid-side nodes included.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> triangulated(SurfaceMesh(corners, np.array([[0, 1, 2, 3]])))[1].tolist()
    [[0, 1, 2], [0, 2, 3]]
    """
    used, number = np.unique(fans(surface.facets)[0], return_inverse=True)
    return surface.points[used], number.reshape(-1, 3)


def fans(facets: IntArray) -> tuple[IntArray, IntArray]:
    """Triangles (n, 3) between the nodes of facets (n_facets, 4 | 8), and the facet (n,) that each is of."""
    fan = [[0, 1, 2], [0, 2, 3]]
    if facets.shape[1] == 8:
        fan = [[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7], [4, 5, 7], [5, 6, 7]]
    triangles = facets[:, fan].reshape(-1, 3)
    # a triangle repeats its last corner
    distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return triangles[distinct], np.repeat(np.arange(len(facets)), len(fan))[distinct]


def enclosed_volume(points: Array, facets: IntArray) -> float:
    """Volume within a closed surface of facets (n, 4 | 8 | 9): a third of the flux of x through it (Gauss)."""
    middle = points[facets[:, :4]].mean(axis=(0, 1))
    _, x, dA = facet_integrals(points - middle, facets)
    return float(np.einsum("fqi,fqi->", x, dA) / 3)


def distance(points: Array, facets: IntArray, new_points: Array, new_facets: IntArray) -> float:
    """Largest distance of the corners of facets from new ones."""
    used = np.unique(facets[:, :4])
    return float(np.abs(FacetSurface(new_points, new_facets).project(points[used]).gap).max())


def changed(points: Array, facets: IntArray, new_points: Array, new_facets: IntArray) -> str:
    """Change of volume (of area, where open) of facets (n, 4), and distance of their corners from new ones, in words.

    Examples
    --------
    >>> import fecontact as fc
    >>> cube = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    >>> changed(cube.points, cube.skin, 1.1 * cube.points, cube.skin)
    'its volume changed by 33 %, its corners are up to 0.1 from the new facets'
    """
    if len(rims(facets[:, :4])[0]):
        what, before, after = (
            "area",
            *(
                float(np.linalg.norm(facet_integrals(x, f)[2], axis=2).sum())
                for x, f in ((points, facets), (new_points, new_facets))
            ),
        )
    else:
        what, before, after = "volume", enclosed_volume(points, facets), enclosed_volume(new_points, new_facets)
    away = distance(points, facets, new_points, new_facets)
    share = 100 * (after / before - 1) if before else np.inf
    return f"its {what} changed by {share:.2g} %, its corners are up to {away:.2g} from the new facets"


def repair_surface(
    source: str | Path | SurfaceMesh,
    *,
    holes: int = 0,
    smoothing: int = 0,
    size: float | None = None,
    scale: float = 1.0,
) -> SurfaceMesh:
    """Surface with its faults mended, holes filled, noise smoothed, and facets of a wanted size.

    Always, points in one place are joined, repeated facets and slivers are taken out, and facets are turned to face as
    their neighbours do. The rest is done where it is asked for, in this order.

    Parameters
    ----------
    source : str, Path or SurfaceMesh
        ``.stl``, ``.ply``, ``.obj``, ``.off``, ``.vtp``, which `read_surface` may refuse, or a surface.
    holes : int
        Holes of up to so many sides are filled with flat facets.
    smoothing : int
        Steps of Taubin's filter, which does not shrink (`mesh.mending`): 10 take out the noise of single facets, 100
        what is a few facets wide. Edges are rounded off; rims stay.
    size : float, optional
        Side length of facets that replace the old ones (by gmsh), on the smooth surface through the old corners; edges
        sharper than 40 degrees and rims stay.
    scale : float
        Factor applied to the coordinates; `size` is in the scaled unit.

    Returns
    -------
    SurfaceMesh
        Of triangles. Its notes tell what was done, the change of volume and the largest distance; results repeat them.

    Raises
    ------
    InputError, MeshError
        As `read_surface`; if sides still belong to more than two facets; if gmsh fails.
    MissingPackageError
        For `size`, without gmsh.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0, 1e-9]])
    >>> facets = np.array([[0, 1, 4, 4], [4, 1, 2, 2], [0, 4, 3, 3], [4, 2, 3, 3]])
    >>> repaired = repair_surface(SurfaceMesh(x, facets))
    >>> len(repaired.facets), repaired.notes[1][:38]
    (3, 'the surface: 1 sliver facet was mended')
    """
    most, steps = whole("holes", holes, least=0), whole("smoothing", smoothing, least=0, most=10_000)
    sizes = None if size is None else Sizes.of(size, "tet4", None, None, 0.5)
    positive("the scale", scale)
    if isinstance(source, SurfaceMesh):
        name, read = "the surface", source.notes
        points, triangles = triangulated(source)
        points, facets = scale * points, triangles[:, [0, 1, 2, 2]]
    else:
        path = file_path("the path of a surface", source)
        if path.suffix.lower() not in POLYGON_READERS:
            raise InputError(
                f"{path.name} is none of {', '.join(POLYGON_READERS)}; fc.read_surface reads surfaces of meshes and "
                "decks, and what it gives is repaired.",
                code="file-type",
            )
        if not path.is_file():
            raise InputError(f"There is no file {path}.", code="no-file")
        name, read = path.name, ()
        points, facets = cut_facets(*read_polygons(path), name, scale)
    points, facets, told = welded(points, facets)
    triangles = np.concatenate([facets[:, [0, 1, 2]], facets[:, [0, 2, 3]]])
    triangles = triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]
    points, triangles, done = _done(points, triangles, most, steps, sizes, name)
    surface = joined(points, triangles[:, [0, 1, 2, 2]])
    # what is said of facets that were turned is said of the first ones
    return SurfaceMesh(surface.points, surface.facets, (*read, *(f"{name}: {note}" for note in (*told, *done))))


def _done(
    points: Array, triangles: IntArray, holes: int, steps: int, sizes: Sizes | None, name: str
) -> tuple[Array, IntArray, list[str]]:
    """Points and triangles (n, 3) after what was asked for, and what was done."""
    told = []
    x, new, n = without_slivers(points, triangles)
    if n:
        told.append(f"{n} sliver facet{'s were' if n > 1 else ' was'} mended.")
    closed, n = without_holes(x, new, holes)
    if n:
        told.append(f"{n} hole{'s were' if n > 1 else ' was'} filled, facets more: {len(closed) - len(new)}.")
    new = closed
    if steps:
        before, x = x, smoothed(x, new, steps)
        f = new[:, [0, 1, 2, 2]]
        away = np.linalg.norm(x - before, axis=1).max()
        told.append(f"it was smoothed by {steps} steps, nodes by up to {away:.2g}; {changed(before, f, x, f)}.")
    if sizes is not None:
        f = new[:, [0, 1, 2, 2]]
        y, finer, notes = _of_size(x, new, sizes, name)
        told += [*notes, f"{len(f)} facets were replaced by {len(finer)}; {changed(x, f, y, finer[:, [0, 1, 2, 2]])}."]
        x, new = y, finer
    return x, new, told


def _of_size(points: Array, triangles: IntArray, sizes: Sizes, name: str) -> tuple[Array, IntArray, tuple[str, ...]]:
    """Triangles of a wanted size with corners on the smooth surface through the old ones, facing as these do."""
    x, new, of, part, notes = facets_of_size(points, triangles, sizes, name)
    facets = triangles[:, [0, 1, 2, 2]]
    middles = x[new].mean(axis=1)
    normals = np.cross(x[new[:, 1]] - x[new[:, 0]], x[new[:, 2]] - x[new[:, 0]])
    if np.einsum("ni,ni->", normals, FacetSurface(points, facets).project(middles).normals) < 0:
        new = new[:, ::-1]
    fits = fitted_facets(points, facets, {str(k): part == k for k in np.unique(part).tolist()})
    for key, fit in fits.items():
        nodes = np.unique(new[of == int(key)])
        x[nodes] = fit.placed(x[nodes])
    return x, new, notes
