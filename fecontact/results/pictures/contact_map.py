"""Maps of one contact: a field or sensels in colours, outlines of its regions, arrows of friction."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.tri import Triangulation

from fecontact.common.arrays import Array, IntArray
from fecontact.common.units import Units
from fecontact.mesh.facets import shapes_on_square
from fecontact.results.contact_fields import ContactFields
from fecontact.results.friction_fields import FrictionFields
from fecontact.results.pictures.friction_map import draw_arrows, draw_friction_curve
from fecontact.results.pictures.map_projection import MapProjection, facet_planes, map_of

COLOURS = {"pressure": "magma_r", "gap": "viridis", "friction": "Greys"}
#: Cells per side into which a facet is divided for a smooth picture.
FINENESS = 6
#: Share of the largest pressure above which a sensel shows its pressure.
FELT = 0.02
#: Sensels across a contact by default, and colour steps, as for pressure-sensitive films.
SENSELS, STEPS = 24, 13
#: Share of the area whose pressures a scale shows where the peak is unbounded; peaks this close to a scale are on it.
MOST, ROUNDING = 0.95, 1e-9
#: Room about a contact, relative to its extent.
MARGIN = 1.3


def draw_friction(axes: Any, contact: ContactFields, friction: FrictionFields, units: Units) -> None:
    """Draw sizes and directions of tractions of friction."""
    if contact.is_curve:
        draw_friction_curve(axes, contact, friction, units)
        return
    draw_field(axes, contact, np.linalg.norm(friction.traction, axis=1), "friction", units)
    draw_arrows(axes, contact, friction, map_of(contact))


def draw_field(
    axes: Any,
    contact: ContactFields,
    values: Array,
    what: str,
    units: Units | None = None,
    margin: float = MARGIN,
    top: float | None = None,
) -> None:
    """Draw a nodal field of a contact with smooth shading, the facets' edges and a scale up to `top`."""
    names = units or Units()
    projection = map_of(contact)
    beyond = values.max(initial=0.0) if what == "gap" else 0.0
    shown = _shown(contact, projection)
    triangles, xy, shades = _shaded(contact, projection, shown, None if what == "pressure" else values, beyond)
    low, high = map_window(contact, projection, margin)
    if what == "gap":
        seen = shades[((xy >= low) & (xy <= high)).all(axis=1)]
        limits = {"vmin": float(seen.min()), "vmax": float(seen.max())} if len(seen) else {}
    else:
        limits = {"vmin": 0.0, "vmax": top or values.max(initial=0.0) or 1.0}
    cut_off = what != "gap" and values.max(initial=0.0) > limits["vmax"] * (1 + ROUNDING)
    drawn = axes.tripcolor(
        Triangulation(xy[:, 0], xy[:, 1], triangles), shades, shading="gouraud", cmap=COLOURS[what], **limits
    )
    sides = list(_facet_sides(contact, projection, shown))
    axes.add_collection(LineCollection(sides, colors="0.4", linewidths=0.3, alpha=0.6), autolim=False)
    labels = {"pressure": "contact pressure", "friction": "traction of friction", "gap": "gap"}
    label = names.after(labels[what], "length" if what == "gap" else "stress")
    axes.figure.colorbar(drawn, ax=axes, label=label, extend="max" if cut_off else "neither")
    _frame(axes, projection, (low, high), names)


def scale_top(contact: ContactFields) -> float:
    """Upper end of a scale of pressures: the peak, or where that is a matter of the mesh, what most of the area keeps.

    A curve shows all of its values. Towards a sharp edge the pressure has no bound (`results.singular`), and its nodal
    peak would leave all else of a map pale.
    """
    peak = contact.max_pressure
    if contact.is_curve or contact.singular_edge is None or not contact.active.any():
        return peak
    pressure, area = contact.pressure[contact.active], contact.weights[contact.active]
    order = np.argsort(pressure)
    share = np.cumsum(area[order]) / area.sum()
    return float(pressure[order[int(np.argmax(share >= MOST * (1 - ROUNDING)))]])


def draw_sensels(
    axes: Any, contact: ContactFields, pitch: float | None = None, units: Units | None = None, top: float | None = None
) -> None:
    """Draw the pressure on square sensors: the force on each over its area, in colour steps."""
    names = units or Units()
    projection = map_of(contact)
    flat = projection.flat(contact.points)
    active = flat[contact.active] if contact.active.any() else flat
    side = pitch or _round_length(float(np.ptp(active, axis=0).max()) / SENSELS)
    low, felt = _felt(contact, projection, side)
    table = ListedColormap(colormaps["turbo"](np.linspace(0.1, 0.95, STEPS)))
    highest = top or felt.max() or 1.0
    seen = np.ma.masked_less_equal(felt, FELT * highest)
    x, y = (low[k] + side * np.arange(felt.shape[k] + 1) for k in range(2))
    drawn = axes.pcolormesh(x, y, seen.T, cmap=table, vmin=0.0, vmax=highest, edgecolors="white", linewidth=0.3)
    label = names.after("pressure on sensels", "stress")
    more = "max" if felt.max() > highest * (1 + ROUNDING) else "neither"
    axes.figure.colorbar(drawn, ax=axes, label=f"{label}, pitch {names.number(side, 'length')}", extend=more)
    axes.set_facecolor("0.93")
    _frame(axes, projection, map_window(contact, projection), names)


def _felt(contact: ContactFields, projection: MapProjection, side: float) -> tuple[Array, Array]:
    """Lower corner (2,) of a field of sensels and the pressures (n, m) on them; their force is that of the contact."""
    sizes = np.ptp(projection.of_facets(contact.nodes[contact.facets]), axis=1)
    points, pressure, area = contact.sampled(contact.pressure, max(FINENESS, int(np.ceil(2 * sizes.max() / side))))
    loaded = pressure > 0
    xy = projection.flat(points) / side
    low = np.floor(xy.min(axis=0)) - 1
    shape = np.ceil(xy.max(axis=0) - low).astype(int) + 2
    xy, pressure, area = xy[loaded], pressure[loaded], area[loaded]
    # each sample is a square of its own area, shared by the sensels on which it lies
    half = np.minimum(np.sqrt(area) / side, 1.0)[:, None] / 2
    first = np.floor(xy - half - low).astype(int)
    beyond = np.clip((xy + half - low - first - 1) / (2 * half), 0.0, 1.0)
    force = np.zeros(shape)
    for i, j in np.ndindex(2, 2):
        share = np.abs(1 - i - beyond[:, 0]) * np.abs(1 - j - beyond[:, 1])
        np.add.at(force, (first[:, 0] + i, first[:, 1] + j), share * pressure * area)
    return low * side, force / side**2


def draw_regions(axes: Any, contact: ContactFields, units: Units | None = None) -> None:
    """Outline the connected regions of a contact, mark their centres of pressure, and number them if there are more."""
    if not contact.active.any():
        return
    projection = map_of(contact)
    for curve in contact.outline.curves:
        x, y = projection.of_facets(np.append(curve.points, curve.points[:1], axis=0)[None])[0].T
        axes.plot(x, y, color="tab:blue", linewidth=1.2)
    for k, region in enumerate(contact.regions, start=1):
        x, y = projection.flat(region.centre_of_pressure)
        axes.plot(x, y, "+", color="tab:cyan", markersize=9, markeredgewidth=1.6)
        if len(contact.regions) > 1:
            size = (units or Units()).number(float(np.linalg.norm(region.force)), "force")
            box = {"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
            axes.annotate(f"{k}: {size}", (x, y), (7, 7), textcoords="offset points", fontsize="small", bbox=box)


def map_window(contact: ContactFields, projection: MapProjection, margin: float = MARGIN) -> tuple[Array, Array]:
    """Lower and upper corner (2,) of the picture: the facets in contact and a margin, or all facets."""
    shown = _shown(contact, projection)
    flat = projection.of_facets(contact.nodes[contact.facets[shown]])
    every = flat.reshape(-1, 2)
    low, high = every.min(axis=0), every.max(axis=0)
    loaded = (contact.at_nodes @ contact.forces > 0)[contact.facets[shown]].any(axis=1)
    here = flat[loaded].reshape(-1, 2)
    if len(here) < 2:
        return low, high
    middle = (here.max(axis=0) + here.min(axis=0)) / 2
    half = margin * np.ptp(projection.flat(contact.points[contact.active]), axis=0).max() / 2
    half = np.maximum(half, 1.05 * np.ptp(here, axis=0) / 2)
    return np.maximum(low, middle - half), np.minimum(high, middle + half)


def _frame(axes: Any, projection: MapProjection, window: tuple[Array, Array], units: Units) -> None:
    """Equal axes round the contact, named by what they are."""
    low, high = window
    axes.set_aspect("equal")
    axes.set_xlabel(units.after(projection.names[0], "length"))
    axes.set_ylabel(units.after(projection.names[1], "length"))
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])


def _round_length(value: float) -> float:
    """The nearest of 1, 2, 5 times a power of ten.

    Examples
    --------
    >>> [_round_length(v) for v in (0.9, 0.04, 17.0)]
    [1.0, 0.05, 20.0]
    """
    if value <= 0:
        return 1.0
    decade = 10.0 ** np.floor(np.log10(value))
    choices = decade * np.array([1.0, 2.0, 5.0, 10.0])
    return float(f"{choices[np.argmin(np.abs(np.log(choices / value)))]:.3g}")


def _shown(contact: ContactFields, projection: MapProjection) -> IntArray:
    """Numbers of the facets that have a place on the map; all, if none has."""
    middles, normals, _ = facet_planes(contact)
    shown = np.flatnonzero(projection.shows(middles, normals))
    return shown if len(shown) else np.arange(len(middles))


def _shaded(
    contact: ContactFields, projection: MapProjection, shown: IntArray, values: Array | None, beyond: float
) -> tuple[Array, Array, Array]:
    """Facets divided into triangles with interpolated values; without values the recovered pressure."""
    t = np.linspace(0.0, 1.0, FINENESS + 1)
    local = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    N, _ = shapes_on_square(contact.facets, local)
    points = projection.of_facets((N @ contact.nodes[contact.facets])[shown]).reshape(-1, 2)
    shades = contact.recovered.at(local) if values is None else contact.interpolated(values, local, beyond)
    index = np.arange(len(local)).reshape(FINENESS + 1, FINENESS + 1)
    a, b, c, d = (index[i : i + FINENESS, j : j + FINENESS].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    cell = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    starts = len(local) * np.arange(len(shown))
    return (starts[:, None, None] + cell).reshape(-1, 3), points, shades.reshape(len(contact.facets), -1)[shown].ravel()


def _facet_sides(contact: ContactFields, projection: MapProjection, shown: IntArray) -> Array:
    """The four curved sides of each facet as polylines (4 n_facets, n, 2)."""
    t = np.linspace(0.0, 1.0, FINENESS + 1)
    zero, one = np.zeros_like(t), np.ones_like(t)
    sides = [np.stack(s, 1) for s in ((t, zero), (one, t), (t, one), (zero, t))]
    N, _ = shapes_on_square(contact.facets, np.concatenate(sides))
    return projection.of_facets((N @ contact.nodes[contact.facets])[shown]).reshape(-1, FINENESS + 1, 2)
