"""Layers extruded from a surface: quadrilaterals become 20-node hexahedra, triangles 15-node wedges.

For instance cartilage on the surface of a bone. Every node moves along the normal averaged over the facets round it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import flag, instance, texts
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import array_of, number_array, reckonable, whole
from fecontact.common.errors import InputError, shown
from fecontact.mesh.check import check_cells
from fecontact.mesh.layer import Layer
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.mesh.thinning import thinned

#: Elements through the thickness of a layer.
MOST_LAYERS = 1000
Thickness = float | ArrayLike | Callable[[Array], ArrayLike]


def extrude(
    surface: SurfaceMesh,
    thickness: Thickness,
    layers: int | Sequence[float] = 1,
    *,
    names: tuple[str, str, str] = ("base", "top", "side"),
    strict: bool = False,
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
    strict : bool
        Whether a layer that folds is refused. Otherwise its thickness yields near concave edges (`mesh.thinning`),
        and a note tells where and by how much.

    Returns
    -------
    Mesh
        20-node hexahedra and 15-node wedges. The element set of its cells is called 'layer'.

    Raises
    ------
    InputError
        Thickness not positive, or fractions that do not run from 0 to 1.
    MeshError
        If the layer would fold (thicker than a concave radius) or intersect itself, and is strict or would have to
        yield in more than a few places.

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
    flag("strict", strict)
    fractions = _fractions(layers)
    used, facets = np.unique(surface.facets, return_inverse=True)
    layer = Layer(surface.points[used], surface.normals[used], facets.reshape(surface.facets.shape), fractions)
    t = _thickness(thickness, surface.points, used)
    told: tuple[str, ...] = ()
    if strict:
        layer.refuse_folds(t)
    else:
        t, told = thinned(layer, t)
    mesh = layer.mesh(t)
    check_cells(mesh)
    return replace(_named(mesh, len(facets), names), notes=(*surface.notes, *told))


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
