"""Thickness of a layer that yields where the layer would fold: near concave edges and in narrow gaps.

Nodes of cells that fold or cross are drawn back until none does; round them the layer becomes thicker again by no more
than a given slope, so that the far side stays smooth.
"""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import place
from fecontact.mesh.layer import Layer
from fecontact.mesh.orient import corner_areas

#: What is left of the thickness at nodes of a cell that folds, in each step.
STEP = 0.8
#: Least thickness that is left, relative to the given one, and largest share of the area that yields: a layer that
#: needs more is too thick altogether.
LEAST, MOST_AREA = 0.15, 0.25
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
        If it would have to yield by more than `LEAST` or on more than `MOST_AREA` of the surface.
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
        if (t < LEAST * given).any() or _share(layer, t < given) > MOST_AREA:
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
