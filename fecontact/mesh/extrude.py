"""Layers extruded from a surface: quadrilaterals become 20-node hexahedra, triangles 15-node wedges.

For instance cartilage on the surface of a bone. Every node moves along the normal averaged over the facets round it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import instance, texts
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import array_of, number_array, reckonable, whole
from fecontact.common.errors import InputError, MeshError, place, shown
from fecontact.mesh.check import check_cells
from fecontact.mesh.crossing import crossing_triangles
from fecontact.mesh.element.hexahedron import FACES
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.surface_mesh import SurfaceMesh

#: Elements through the thickness of a layer.
MOST_LAYERS = 1000
Thickness = float | ArrayLike | Callable[[Array], ArrayLike]


def extrude(
    surface: SurfaceMesh,
    thickness: Thickness,
    layers: int | Sequence[float] = 1,
    *,
    names: tuple[str, str, str] = ("base", "top", "side"),
) -> Mesh:
    """Solid layer on the outside of a surface.

    Parameters
    ----------
    surface : SurfaceMesh
        Quadratic facets keep their curved sides, linear ones get straight sides.
    thickness : float, (n_points,) array, or callable ``(points (n, 3)) -> (n,)``
        Length along the averaged normal, positive everywhere.
    layers : int or increasing fractions from 0 to 1
    names : three names
        Boundaries on the surface, opposite to it and along its rim (none where the surface is closed).

    Returns
    -------
    Mesh
        20-node hexahedra and 15-node wedges. The element set of its cells is called 'layer'.

    Raises
    ------
    InputError
        Thickness not positive, or fractions that do not run from 0 to 1.
    MeshError
        If the layer would fold (thicker than a concave radius) or intersect itself.

    Examples
    --------
    >>> import numpy as np
    >>> square = SurfaceMesh(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]), np.array([[0, 1, 2, 3]]))
    >>> extrude(square, 0.2, layers=2)
    Mesh(hex20, 2 cells, 32 points, boundaries: base, top, side)
    """
    instance("the surface", surface, SurfaceMesh)
    if len(set(texts("names", names))) != 3:
        raise InputError(f"A layer takes three different names; found {shown(names)}.")
    fractions = _fractions(layers)
    used, facets = np.unique(surface.facets, return_inverse=True)
    facets = facets.reshape(surface.facets.shape)
    points = surface.points[used]
    growth = _thickness(thickness, surface.points, used)[:, None] * surface.normals[used]
    n = len(points)
    levels = np.concatenate([points + f * growth for f in fractions])
    corners = facets[:, :4]
    cells = np.concatenate(
        [np.concatenate([corners + k * n, corners + (k + 1) * n], axis=1) for k in range(len(fractions) - 1)]
    )
    mesh = _quadratic(levels, cells, facets, n, len(fractions))
    _refuse_turned(points, growth, corners)
    try:
        check_cells(mesh)
    except MeshError as error:
        raise MeshError(
            f"The layer folds: it is too thick for a concave part or a sharp edge of the surface. {error} Make it "
            "thinner or smooth the surface."
        ) from error
    _refuse_crossing(mesh)
    return replace(_named(mesh, len(facets), names), notes=surface.notes)


def _fractions(layers: int | Sequence[float]) -> Array:
    if isinstance(layers, int | np.integer):
        if layers < 1:
            raise InputError(f"A layer needs at least one element through its thickness; found layers={layers}.")
        return np.linspace(0.0, 1.0, whole("layers", layers, most=MOST_LAYERS) + 1)
    found = array_of(layers)
    fractions = np.zeros(0) if found is None else found
    if fractions.ndim != 1 or len(fractions) < 2 or fractions[0] != 0 or fractions[-1] != 1:
        raise InputError(f"The layers must be a count or fractions from 0 to 1; found {shown(layers)}.")
    if not (np.diff(fractions) > 0).all():
        raise InputError(f"The fractions of the layers must increase; found {layers!r}.")
    return fractions


def _thickness(thickness: Thickness, points: Array, used: IntArray) -> Array:
    """Thickness (n_used,) at the nodes of the surface."""
    given = thickness(points[used]) if callable(thickness) else thickness
    t = number_array("the thickness", given)
    if t.shape == (len(points),) and not callable(thickness):
        t = t[used]
    if t.shape not in ((), (len(used),)):
        raise InputError(f"The thickness must be one number or one per point ({len(points)}); found shape {t.shape}.")
    reckonable("the thickness", t[np.isfinite(t)])
    t = np.broadcast_to(t, len(used))
    if not (np.isfinite(t) & (t > 0)).all():
        raise InputError(
            f"The thickness must be positive everywhere; its smallest value is {t.min():g}. To grow a layer to the "
            "other side use surface.flipped()."
        )
    return t


def _quadratic(levels: Array, cells: IntArray, facets: IntArray, n: int, n_levels: int) -> Mesh:
    """Mid-edge nodes: midpoints across the layers; along them those of quadratic facets, moved with their level."""
    straight = Mesh(levels, cells).upgraded(20)
    if facets.shape[1] == 4:
        return straight
    n_facets = len(facets)
    points, target = straight.points.copy(), straight.cells.copy()
    for k in range(n_levels - 1):
        rows = slice(k * n_facets, (k + 1) * n_facets)
        for columns, level in ((slice(8, 12), k), (slice(12, 16), k + 1)):
            points[target[rows, columns]] = levels[facets[:, 4:8] + level * n]
    used, number = np.unique(target, return_inverse=True)
    return Mesh(points[used], number.reshape(target.shape))


def _named(mesh: Mesh, n_facets: int, names: tuple[str, str, str]) -> Mesh:
    """Boundaries on the surface, opposite and along the rim; face -z of every cell is its facet."""
    first, last = np.arange(n_facets), len(mesh.cells) - n_facets + np.arange(n_facets)
    outer = mesh.outer_faces
    rim = outer[outer[:, 1] < 4]
    base, top, side = names
    boundaries = {
        base: np.stack([first, np.full(n_facets, 4)], axis=1),
        top: np.stack([last, np.full(n_facets, 5)], axis=1),
    }
    if len(rim):
        boundaries[side] = rim
    return Mesh(mesh.points, mesh.cells, boundaries, {"layer": np.arange(len(mesh.cells))})


def _refuse_turned(points: Array, growth: Array, corners: IntArray) -> None:
    """Refuse a layer in which a side of a facet has reversed, as beyond the centre of a concave surface.

    The Jacobian does not show it: a triangle turned by pi in its plane keeps its orientation.
    """
    below = np.roll(points[corners], -1, axis=1) - points[corners]
    above = below + np.roll(growth[corners], -1, axis=1) - growth[corners]
    length2 = np.einsum("fki,fki->fk", below, below)
    turned = ((np.einsum("fki,fki->fk", below, above) <= 0) & (length2 > 0)).any(axis=1)
    if turned.any():
        raise MeshError(
            f"The layer folds: {turned.sum()} facets, the first of them facet {np.argmax(turned)}, are reversed at "
            "its far side. It is thicker than a concave radius; make it thinner or smooth the surface."
        )


def _refuse_crossing(mesh: Mesh) -> None:
    """Refuse a layer whose triangulated outer surface intersects itself."""
    faces = mesh.outer_faces
    corners = np.take_along_axis(mesh.cells[faces[:, 0]], FACES[faces[:, 1], :4], axis=1)
    triangles = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    triangles = triangles[distinct]
    owner = np.tile(faces[:, 0], 2)[distinct]
    crossing = crossing_triangles(mesh.points, triangles)
    if len(crossing):
        a, b = crossing[0]
        where = place(mesh.points[triangles[a]].mean(axis=0))
        raise MeshError(
            f"The layer runs into itself: cells {owner[a]} and {owner[b]} cross near {where}. Make it thinner there or "
            "extrude the two sides separately."
        )
