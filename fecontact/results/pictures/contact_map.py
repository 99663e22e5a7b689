"""Maps of one contact: a field or sensels in colours, outlines of its regions, arrows of friction.

Pictures of friction: tangential tractions with their directions, and what sticks and what slides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.tri import Triangulation

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.units import Units
from fecontact.mesh.facets import shapes_on_square
from fecontact.results.contact_fields import ContactFields
from fecontact.results.field_map import FINENESS, ROUNDING, FieldMap, Ground, field_map, local_points, together
from fecontact.results.friction_fields import FrictionFields
from fecontact.results.pictures.map_projection import MapProjection, facet_planes, map_of
from fecontact.results.pictures.section_curve import along_axis, axis_name, curve_window

#: Colours of points that stick and slide.
STICK, SLIDE = "tab:blue", "tab:red"
#: Label of circumferential tractions.
ROUND = "round the axis"
#: Arrows drawn at most.
MAX_ARROWS = 300


def draw_friction_curve(axes: Any, contact: ContactFields, friction: FrictionFields, units: Units) -> None:
    """Draw tractions along a contact of sections, between the limits of friction."""
    kept = field_map(contact, "friction")
    k = along_axis(kept)
    order = np.argsort(contact.points[:, k])
    place = contact.points[order, k]
    if np.isfinite(friction.mu_along_slip).all():
        limit = (friction.mu_along_slip * contact.pressure)[order]
        axes.fill_between(place, -limit, limit, color="0.9", label="up to mu times the pressure")
    for along, style, part in _components(friction, k):
        axes.plot(place, along[order], style, color="0.4", linewidth=1.0, label=part)
        for chosen, colour, name in _states(friction):
            label = "_" + name if part == ROUND else name
            axes.plot(contact.points[chosen, k], along[chosen], "o", color=colour, markersize=4, label=label)
    axes.set_xlim(*curve_window(kept, k))
    axes.set_xlabel(units.axis_label(axis_name(kept, k), "length"))
    axes.set_ylabel(units.axis_label("traction of friction", "stress"))
    axes.grid(color="0.9")
    axes.legend(loc="best", fontsize="small")


def draw_arrows(axes: Any, contact: ContactFields, friction: FrictionFields, projection: MapProjection) -> None:
    """Draw directions of tractions on the slave, on a map, coloured by what sticks and slides, and the edge."""
    flat = projection.flat(contact.points)
    traction = projection.directions(contact.points, friction.traction)
    largest = float(np.linalg.norm(traction, axis=1).max(initial=0.0))
    every = max(1, -(-int(friction.touching.sum()) // MAX_ARROWS))
    for chosen, colour, name in _states(friction):
        axes.plot(*flat[chosen].T, ".", color=colour, markersize=3.0, label=name)
        some = np.flatnonzero(chosen)[::every]
        if largest > 0 and len(some):
            spread = float(np.ptp(flat[friction.touching], axis=0).max())
            axes.quiver(
                *flat[some].T, *traction[some].T, color=colour, angles="xy", scale_units="xy",
                scale=10 * largest / spread, width=0.003,
            )  # fmt: skip
    edges = () if contact.stick_outline is None else contact.stick_outline.curves
    for edge in edges:
        axes.plot(*projection.flat(edge.points).T, color=STICK, linewidth=1.2)
    axes.legend(loc="upper right", fontsize="small")


def _components(friction: FrictionFields, k: int) -> Iterator[tuple[Array, str, str]]:
    """Tractions (n,) in the plane of a section, with the sign of component k, and those round the axis, if any."""
    t = friction.traction
    across = t[:, 1].any()
    yield np.linalg.norm(t[:, [0, 2]], axis=1) * np.sign(t[:, k]), "-", "in the plane" if across else "_along"
    if across:
        yield t[:, 1], "--", ROUND


def _states(friction: FrictionFields) -> tuple[tuple[Mask, str, str], ...]:
    return ((friction.sticking, STICK, "sticks"), (friction.sliding, SLIDE, "slides"))


COLOURS = {"pressure": "magma_r", "gap": "viridis", "friction": "Greys", "worn": "YlOrBr"}
#: Share of the largest pressure above which a sensel shows its pressure.
FELT = 0.02
#: Sensels across a contact by default, and colour steps, as for pressure-sensitive films.
SENSELS, STEPS = 24, 13
#: What a map is drawn of.
Drawn = ContactFields | Ground
#: Room about a contact, relative to its extent; height of a label of a region, relative to the map.
MARGIN, LABEL = 1.3, 0.1


def draw_friction(axes: Any, contact: ContactFields, units: Units) -> None:
    """Draw sizes and directions of tractions of friction."""
    friction = contact.friction
    assert friction is not None
    if contact._is_curve:
        draw_friction_curve(axes, contact, friction, units)
        return
    draw_field(axes, field_map(contact, "friction"), units)
    draw_arrows(axes, contact, friction, map_of(contact))


@dataclass(frozen=True, eq=False)
class Sheet:
    """What all maps of a field in one picture share: place, window, scale and units."""

    projection: MapProjection
    window: tuple[Array, Array]
    limits: tuple[float, float]
    cut_off: bool
    units: Units
    what: str

    @classmethod
    def of(cls, maps: Sequence[FieldMap], units: Units, top: float | None = None) -> Sheet:
        """That of some maps; its scale ends at `top` unless it is one of gaps."""
        ground: Ground = maps[0] if len(maps) == 1 else together(maps)
        what, projection = maps[0].what, map_of(ground)
        window = map_window(ground, projection)
        limits = (0.0, top or max(m.top for m in maps) or 1.0)
        if what == "gap":
            seen = [seen_range(m, projection, window) for m in maps]
            limits = (min(low for low, _ in seen), max(high for _, high in seen))
        cut_off = what != "gap" and max(m.peak for m in maps) > limits[1] * (1 + ROUNDING)
        return cls(projection, window, limits, cut_off, units, what)

    @property
    def ratio(self) -> float:
        """Height of a map over its width."""
        wide, high = self.window[1] - self.window[0]
        return float(high / wide) if wide > 0 else 1.0

    def draw(self, axes: Any, kept: FieldMap, outlined: bool = True) -> None:
        """Draw one map, with its outlines."""
        draw_shades(axes, kept, self.limits, self.projection, self.window, self.units)
        if outlined:
            draw_outlines(axes, self.projection, kept, self.units)

    def add_scale(self, figure: Any, axes: Any, **look: float) -> None:
        """Draw the one scale of all maps."""
        labels = {"pressure": "contact pressure", "friction": "traction of friction", "worn": "worn depth"}
        kind = "length" if self.what in ("gap", "worn") else "stress"
        label = self.units.axis_label(labels.get(self.what, self.what), kind)
        shades = ScalarMappable(Normalize(*self.limits), COLOURS[self.what])
        figure.colorbar(shades, ax=axes, label=label, extend="max" if self.cut_off else "neither", **look)


def draw_field(
    axes: Any, kept: FieldMap, units: Units | None = None, top: float | None = None, outlined: bool = False
) -> None:
    """Draw a field with smooth shading, the facets' edges and a scale up to `top`."""
    sheet = Sheet.of([kept], units or Units(), top)
    sheet.draw(axes, kept, outlined)
    sheet.add_scale(axes.figure, axes)


def seen_range(contact: FieldMap, projection: MapProjection, window: tuple[Array, Array]) -> tuple[float, float]:
    """Least and largest of the shades within a window; 0 and 1 where there are none."""
    shown = _shown(contact, projection)
    xy = _sample_places(contact, projection, shown)
    seen = contact.shades[shown].reshape(-1)[((xy >= window[0]) & (xy <= window[1])).all(axis=1)]
    # by its shortest text a number of single precision is the round one that it stands for
    return (float(str(seen.min())), float(str(seen.max()))) if len(seen) else (0.0, 1.0)


def draw_shades(
    axes: Any,
    contact: FieldMap,
    limits: tuple[float, float],
    projection: MapProjection,
    window: tuple[Array, Array],
    units: Units,
) -> None:
    """Draw the shades of a map and the facets' edges."""
    shown = _shown(contact, projection)
    xy = _sample_places(contact, projection, shown)
    axes.tripcolor(
        Triangulation(xy[:, 0], xy[:, 1], _sample_triangles(len(shown))),
        contact.shades[shown].reshape(-1),
        shading="gouraud",
        cmap=COLOURS[contact.what],
        vmin=limits[0],
        vmax=limits[1],
    )
    sides = list(_facet_sides(contact, projection, shown))
    axes.add_collection(LineCollection(sides, colors="0.4", linewidths=0.3, alpha=0.6), autolim=False)
    _frame(axes, projection, window, units)


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
    label = names.axis_label("pressure on sensels", "stress")
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


def draw_outlines(axes: Any, projection: MapProjection, kept: FieldMap, units: Units) -> None:
    """Outline the connected regions of a contact, mark their centres of pressure, and write the forces of several.

    A force is written above the outline about the centre, or below it where the map ends.
    """
    curves, regions = (kept.curves, kept.regions) if kept.active.any() else ((), ())
    drawn = [projection.of_facets(np.append(curve, curve[:1], axis=0)[None])[0] for curve in curves]
    for outline in drawn:
        axes.plot(*outline.T, color="tab:blue", linewidth=1.2)
    box = {"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
    for k, (centre, force) in enumerate(regions, start=1):
        x, y = projection.flat(centre)
        axes.plot(x, y, "+", color="tab:cyan", markersize=9, markeredgewidth=1.6)
        if len(regions) > 1:
            outlines = [o for o in drawn if (o.min(axis=0) <= (x, y)).all() and ((x, y) <= o.max(axis=0)).all()]
            end = min((o[:, 1].max() for o in outlines), default=y)
            room = end + LABEL * np.ptp(axes.get_ylim()) < axes.get_ylim()[1]
            if not room:
                end = max((o[:, 1].min() for o in outlines), default=y)
            place = {"ha": "center", "va": "bottom" if room else "top", "fontsize": "small", "bbox": box}
            text, off = f"{k}: {units.number(force, 'force')}", (0, 6 if room else -6)
            axes.annotate(text, (x, end), off, textcoords="offset points", **place)


def draw_division(axes: Any, contact: ContactFields, sides: tuple[str, str], point: Array, normal: Array) -> None:
    """Draw where a plane meets a map, and write the names of the sides: that to which it points, and the other."""
    projection = map_of(contact)
    shown = _shown(contact, projection)
    N, _ = shapes_on_square(contact.facets, local_points(contact.facets))
    beyond = ((N @ contact.nodes[contact.facets])[shown] - point) @ normal
    xy = _sample_places(contact, projection, shown)
    cells = Triangulation(xy[:, 0], xy[:, 1], _sample_triangles(len(shown)))
    look = {"linestyles": "--", "linewidths": 1.0, "colors": "0.3"}
    if ((beyond.min(axis=1) < 0) & (beyond.max(axis=1) > 0)).any():
        axes.tricontour(cells, beyond.ravel(), levels=[0.0], **look)
    elif beyond.min() < 0 < beyond.max():  # between surfaces: the line of a plane of the map
        c, *slope = np.linalg.lstsq(np.insert(xy, 0, 1.0, axis=1), beyond.ravel(), rcond=None)[0]
        start = -c * np.array(slope) / np.dot(slope, slope)
        axes.axline(start, start + np.array([-slope[1], slope[0]]), linestyle="--", linewidth=1.0, color="0.3")
    low, high = (np.array(limits) for limits in zip(axes.get_xlim(), axes.get_ylim(), strict=True))
    inside = ((xy >= low) & (xy <= high)).all(axis=1)
    for name, side in zip(sides, (beyond.ravel() > 0, beyond.ravel() < 0), strict=True):
        if (side & inside).any():
            x = (xy[side & inside, 0].min() + xy[side & inside, 0].max()) / 2
            axes.annotate(name, (x, 0.02), xycoords=("data", "axes fraction"), ha="center", color="0.3")


def map_window(contact: Drawn, projection: MapProjection, margin: float = MARGIN) -> tuple[Array, Array]:
    """Lower and upper corner (2,) of the picture: the facets in contact and a margin, or all facets."""
    shown = _shown(contact, projection)
    flat = projection.of_facets(contact.nodes[contact.facets[shown]])
    every = flat.reshape(-1, 2)
    low, high = every.min(axis=0), every.max(axis=0)
    loaded = contact.loaded_facets[shown]
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
    axes.set_xlabel(units.axis_label(projection.names[0], "length"))
    axes.set_ylabel(units.axis_label(projection.names[1], "length"))
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


def _shown(contact: Drawn, projection: MapProjection) -> IntArray:
    """Numbers of the facets that have a place on the map; all, if none has."""
    middles, normals, _ = facet_planes(contact)
    shown = np.flatnonzero(projection.shows(middles, normals))
    return shown if len(shown) else np.arange(len(middles))


def _sample_places(contact: Drawn, projection: MapProjection, shown: IntArray) -> Array:
    """Places (n, 2) of the samples in some facets, one facet after the other."""
    N, _ = shapes_on_square(contact.facets, local_points(contact.facets))
    return projection.of_facets((N @ contact.nodes[contact.facets])[shown]).reshape(-1, 2)


def _sample_triangles(n_facets: int) -> IntArray:
    """Triangles (n, 3) between the samples of each of so many facets."""
    index = np.arange((FINENESS + 1) ** 2).reshape(FINENESS + 1, FINENESS + 1)
    a, b, c, d = (index[i : i + FINENESS, j : j + FINENESS].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    cell = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.asarray((index.size * np.arange(n_facets)[:, None, None] + cell).reshape(-1, 3))


def _facet_sides(contact: Drawn, projection: MapProjection, shown: IntArray) -> Array:
    """The four curved sides of each facet as polylines (4 n_facets, n, 2)."""
    t = np.linspace(0.0, 1.0, FINENESS + 1)
    zero, one = np.zeros_like(t), np.ones_like(t)
    sides = [np.stack(s, 1) for s in ((t, zero), (one, t), (t, one), (zero, t))]
    N, _ = shapes_on_square(contact.facets, np.concatenate(sides))
    return projection.of_facets((N @ contact.nodes[contact.facets])[shown]).reshape(-1, FINENESS + 1, 2)
