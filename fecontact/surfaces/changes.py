"""What a surface is when its facets are replaced: its triangles, its volume, and how far it has moved."""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.mesh.facets import facet_integrals
from fecontact.mesh.orient import rims
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.surfaces.facet_surface import FacetSurface


def triangulated(surface: SurfaceMesh) -> tuple[Array, IntArray]:
    """Points (n_points, 3) in use, and triangles (n, 3) between the nodes of a surface, mid-side nodes included.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> triangulated(SurfaceMesh(corners, np.array([[0, 1, 2, 3]])))[1].tolist()
    [[0, 1, 2], [0, 2, 3]]
    """
    f = surface.facets
    fan = [[0, 1, 2], [0, 2, 3]]
    if f.shape[1] == 8:
        fan = [[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7], [4, 5, 7], [5, 6, 7]]
    triangles = f[:, fan].reshape(-1, 3)
    # a triangle repeats its last corner
    distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    used, number = np.unique(triangles[distinct], return_inverse=True)
    return surface.points[used], number.reshape(-1, 3)


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
