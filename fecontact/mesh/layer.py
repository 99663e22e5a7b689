"""A layer on a surface as a function of its thickness: its cells, and where they fold or run into each other.

Thickness of a layer that yields where the layer would fold: near concave edges and in narrow gaps.

Nodes of cells that fold or cross are drawn back until none does; round them the layer becomes thicker again by no more
than a given slope, so that the far side stays smooth.

Layers extruded from a surface: quadrilaterals become 20-node hexahedra, triangles 15-node wedges.

For instance cartilage on the surface of a bone. Every node moves along the normal averaged over the facets round it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import flag, instance, texts
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import array_of, check_magnitude, number_array, whole
from fecontact.common.errors import InputError, MeshError, place, shown
from fecontact.mesh.check import check_cells, least_jacobians
from fecontact.mesh.element import FACES
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.orient import corner_areas, crossing_triangles
from fecontact.mesh.surface_mesh import SurfaceMesh


@dataclass(frozen=True, eq=False)
class Layer:
    """Cells between a surface and the surface above it.

    Attributes
    ----------
    points, normals : (n_points, 3) arrays
        Nodes of the surface, all of them in use, and the unit directions in which they move.
    facets : (n_facets, 4 | 8) int array
    fractions : (n_levels,) array
        Levels of the cells' ends, from 0 to 1.
    """

    points: Array
    normals: Array
    facets: IntArray
    fractions: Array

    def mesh(self, thickness: Array, chosen: IntArray | None = None) -> Mesh:
        """Cells of 20 nodes on all facets, or on some: those of the lowest level first.

        Mid-edge nodes are midpoints across the layer; along it those of quadratic facets, moved with their level.
        """
        chosen = np.arange(len(self.facets)) if chosen is None else chosen
        used, facets = np.unique(self.facets[chosen], return_inverse=True)
        facets = facets.reshape(len(chosen), -1)
        growth, n = thickness[used, None] * self.normals[used], len(used)
        levels = np.concatenate([self.points[used] + f * growth for f in self.fractions])
        steps = range(len(self.fractions) - 1)
        corners = facets[:, :4]
        cells = np.concatenate([np.concatenate([corners + k * n, corners + (k + 1) * n], axis=1) for k in steps])
        straight = Mesh(levels, cells).upgraded(20)
        if facets.shape[1] == 4:
            return straight
        points, target = straight.points.copy(), straight.cells.copy()
        for k in steps:
            rows = slice(k * len(facets), (k + 1) * len(facets))
            for columns, level in ((slice(8, 12), k), (slice(12, 16), k + 1)):
                points[target[rows, columns]] = levels[facets[:, 4:8] + level * n]
        used, number = np.unique(target, return_inverse=True)
        return Mesh(points[used], number.reshape(target.shape))

    def folded(self, thickness: Array, chosen: IntArray) -> Mask:
        """Which of some facets (n,) have a cell with a Jacobian that is not positive, or are reversed on the far side.

        Beyond the centre of a concave surface the Jacobian is positive again: a triangle turned by pi in its plane
        keeps its orientation, so its sides are looked at too.
        """
        least = least_jacobians(self.mesh(thickness, chosen)).reshape(-1, len(chosen)).min(axis=0)
        corners = self.facets[chosen, :4]
        far = self.points + thickness[:, None] * self.normals
        below, above = (np.roll(x[corners], -1, axis=1) - x[corners] for x in (self.points, far))
        turned = (np.einsum("fki,fki->fk", below, above) <= 0) & (corners != np.roll(corners, -1, axis=1))
        return np.asarray((least <= 0) | turned.any(axis=1))

    def crossing(self, thickness: Array) -> IntArray:
        """Pairs (n, 2) of facets whose cells run through each other: their triangulated outer faces do."""
        mesh = self.mesh(thickness)
        faces = mesh.outer_faces
        corners = np.take_along_axis(mesh.cells[faces[:, 0]], FACES[faces[:, 1], :4], axis=1)
        triangles = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
        distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
        owner = np.tile(faces[:, 0], 2)[distinct]
        return owner[crossing_triangles(mesh.points, triangles[distinct])] % len(self.facets)

    def centre(self, facet: int) -> Array:
        """Middle (3,) of the corners of a facet."""
        return np.asarray(self.points[self.facets[facet, :4]].mean(axis=0))

    def refuse_folds(self, thickness: Array) -> None:
        """Refuse a layer that folds or runs into itself.

        Raises
        ------
        MeshError
            With the place.
        """
        folded = np.flatnonzero(self.folded(thickness, np.arange(len(self.facets))))
        if len(folded):
            raise MeshError(
                f"The layer folds on {len(folded)} of {len(self.facets)} facets, the first of them facet {folded[0]} "
                f"near {place(self.centre(folded[0]))}: it is too thick for a concave part or a sharp edge of the "
                "surface. Make it thinner or smooth the surface (fc.repair_surface).",
                code="layer-folds",
            )
        crossing = self.crossing(thickness)
        if len(crossing):
            a, b = crossing[0]
            raise MeshError(
                f"The layer runs into itself: its cells on facets {a} and {b} cross near {place(self.centre(a))}. Make "
                "it thinner there or extrude the two sides separately.",
                code="layer-crosses-itself",
            )


#: What is left of the thickness at nodes of a cell that folds, in each step.
STEP = 0.8
#: Least thickness that is left, relative to the given one, and largest share of the area that yields: a layer that
#: needs more is too thick altogether.
MIN_THICKNESS, MAX_AREA = 0.15, 0.25
#: Slope at which the thickness returns to the given one.
SLOPE = 0.5


def thinned(layer: Layer, given: Array) -> tuple[Array, tuple[str, ...]]:
    """Largest thickness found at which no cell folds, and a note of where it was reduced.

    Parameters
    ----------
    layer : Layer
    given : (n_points,) array

    Returns
    -------
    thickness : (n_points,) array
    notes : tuple of str

    Raises
    ------
    MeshError
        If it would have to yield by more than `MIN_THICKNESS` or on more than `MAX_AREA` of the surface.
    """
    t, checked = given.copy(), np.arange(len(layer.facets))
    sides = _sides(layer)
    while True:
        bad = checked[layer.folded(t, checked)]
        if len(bad) == 0:
            bad = np.unique(layer.crossing(t))
        if len(bad) == 0:
            return t, _told(layer, given, t)
        before, t = t, t.copy()
        t[layer.facets[bad]] *= STEP
        t = given - _spread(given - t, *sides)
        if (t < MIN_THICKNESS * given).any() or _share(layer, t < given) > MAX_AREA:
            layer.refuse_folds(given)
        checked = np.flatnonzero((t != before)[layer.facets].any(axis=1))


def _sides(layer: Layer) -> tuple[IntArray, Array]:
    """Pairs (n, 2) of neighbouring nodes along the sides of facets, in both orders, and their distances (n,)."""
    f = layer.facets
    ring = f[:, :4] if f.shape[1] == 4 else f[:, [0, 4, 1, 5, 2, 6, 3, 7]]
    ends = np.stack([ring, np.roll(ring, -1, axis=1)], axis=2).reshape(-1, 2)
    ends = np.unique(np.concatenate([ends, ends[:, ::-1]])[np.tile(ends[:, 0] != ends[:, 1], 2)], axis=0)
    return ends, np.linalg.norm(layer.points[ends[:, 1]] - layer.points[ends[:, 0]], axis=1)


def _spread(reduction: Array, ends: IntArray, length: Array) -> Array:
    """Reductions (n,) that fall along sides by no more than the slope."""
    out = reduction.copy()
    while True:
        before = out.copy()
        np.maximum.at(out, ends[:, 1], before[ends[:, 0]] - SLOPE * length)
        if (out == before).all():
            return out


def _share(layer: Layer, reduced: Mask) -> float:
    """Share of the area whose facets have a node with less thickness."""
    area = corner_areas(layer.points, layer.facets)
    return float(area[reduced[layer.facets].any(axis=1)].sum() / area.sum())


def _told(layer: Layer, given: Array, t: Array) -> tuple[str, ...]:
    """Note on a layer that yielded."""
    reduced = t < given
    if not reduced.any():
        return ()
    k = int(np.argmin(t / given))
    return (
        f"the layer would fold in concave parts, so its thickness is less at {reduced.sum()} of {len(t)} nodes, on "
        f"{100 * _share(layer, reduced):.2g} % of the area: least {t[k]:.3g} instead of {given[k]:.3g} at "
        f"{place(layer.points[k])} (strict=True refuses it).",
    )


#: Elements through the thickness of a layer.
MAX_LAYERS = 1000
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
        Whether a layer that folds is refused. Otherwise its thickness yields near concave edges,
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
        return np.linspace(0.0, 1.0, whole("layers", layers, most=MAX_LAYERS) + 1)
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
    check_magnitude("the thickness", t[np.isfinite(t)])
    t = np.broadcast_to(t, len(used))
    if not (np.isfinite(t) & (t > 0)).all():
        raise InputError(
            f"The thickness must be positive everywhere; its smallest value is {t.min():g}. To grow a layer to the "
            "other side use surface.flipped().",
            code="thickness-not-positive",
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
