"""Picture of a mesh: outer faces or a section, named boundaries in colours and numbered. Needs matplotlib only."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from fecontact.common.arguments import label
from fecontact.common.arrays import Array, IntArray
from fecontact.common.figure import save_figure
from fecontact.mesh.renderer import Camera, Image, draw_facets

#: Colour of faces in no boundary, colour map of the boundaries, and their longest list in a legend.
PLAIN, COLOURS, LISTED = (0.87, 0.87, 0.87), "tab20", 20
PIXELS = (1100, 820)
#: Cosine between a boundary's mean normal and the eye from which on its number is written on it.
FACING = 0.15


def plot_faces(
    points: Array,
    facets: IntArray,
    boundaries: Mapping[str, IntArray],
    path: str | Path | None,
    title: str,
    *,
    view: str | tuple[float, float] = "iso",
    edges: bool = True,
    length: str = "",
    closed: bool = True,
) -> Figure:
    """Draw facets, those of each named boundary in its colour.

    Parameters
    ----------
    points : (n_points, 3) array
    facets : (n_facets, 4 | 8 | 9) int array
    boundaries : mapping of name to (k,) int array
        Facets of each boundary; of several, a facet shows the smallest.
    path : str or Path or None
        File to write.
    title : str
    view : str or (azimuth, elevation) in degrees
        Direction of view, see `renderer.VIEWS`.
    edges : bool
        Whether to draw the elements.
    length : str
        Unit of length, for the ruler.
    closed : bool
        Whether the facets enclose a body, so that those turned away need no drawing.

    Raises
    ------
    InputError
        For an unknown direction, or a file that cannot be written.
    """
    camera = Camera.looking(view)
    number = np.zeros(len(facets))
    ranked = sorted(boundaries, key=lambda name: -len(boundaries[name]))
    order = {name: k for k, name in enumerate(boundaries, start=1)}
    for name in ranked:
        number[boundaries[name]] = order[name]
    # every facet has nodes of its own, so that colours do not run into each other
    own = np.arange(facets.size).reshape(facets.shape)
    coloured = np.array([PLAIN, *(_colour(k) for k in range(len(boundaries)))])
    image = draw_facets(
        points[facets].reshape(-1, 3),
        _alike(own, facets),
        np.repeat(number, facets.shape[1]),
        lambda v: coloured[np.rint(v).astype(int)],
        camera,
        PIXELS,
        edges,
        closed,
    )
    figure, axes = framed(image, camera, title, length)
    _number_boundaries(axes, camera, points, facets, boundaries)
    _list_boundaries(figure, boundaries, "faces")
    return save_figure(figure, path)


def plot_sides(
    points: Array,
    cells: IntArray,
    boundaries: Mapping[str, Array],
    path: str | Path | None,
    title: str,
    *,
    view: str | tuple[float, float] = "-y",
    edges: bool = True,
    length: str = "",
) -> Figure:
    """Draw cells of a section, the sides of each named boundary as a line of its colour.

    Parameters
    ----------
    points : (n_points, 3) array
    cells : (n_cells, 8 | 9) int array
    boundaries : mapping of name to (k, n, 3) array
        Points along each side, an odd number.
    path, title, view, edges, length
        As for `plot_faces`.

    Raises
    ------
    InputError
        As for `plot_faces`.
    """
    camera = Camera.looking(view)
    image = draw_facets(
        points, cells, np.zeros(len(points)), lambda v: np.tile(PLAIN, (len(v), 1)), camera, PIXELS, edges, False
    )
    figure, axes = framed(image, camera, title, length)
    for k, sides in enumerate(boundaries.values()):
        curves = sides @ camera.axes[:2].T
        axes.add_collection(LineCollection(list(curves), colors=[_colour(k)], linewidths=3.0, capstyle="round"))
        middles = curves[:, curves.shape[1] // 2]
        if len(middles):
            nearest = np.argmin(((middles - middles.mean(axis=0)) ** 2).sum(axis=1))
            _write_number(axes, k + 1, middles[nearest])
    _list_boundaries(figure, boundaries, "sides")
    return save_figure(figure, path)


def _list_boundaries(figure: Figure, boundaries: Mapping[str, Array] | Mapping[str, IntArray], members: str) -> None:
    """Legend of boundaries beside the picture; of the figure, so that the layout keeps room for any names."""
    if not boundaries:
        return
    listed = list(boundaries)[:LISTED]
    handles = [
        Patch(color=_colour(k), label=f"{k + 1}  {name}, {len(boundaries[name])} {members}")
        for k, name in enumerate(listed)
    ]
    rest = len(boundaries) - len(listed)
    more = f"and {rest} more" if rest else None
    figure.legend(handles=handles, loc="outside right center", frameon=False, title=more)


def framed(
    image: Image, camera: Camera, title: str, length: str, scale: tuple[ScalarMappable, str] | None = None
) -> tuple[Figure, Any]:
    """Figure and axes of a drawing, with a title, a ruler, the world's axes, and a scale of colours with its label."""
    left, right, bottom, top = image.extent
    width = float(np.clip(5.6 * (right - left) / (top - bottom) + 2.8, 5.6, 9.6))
    figure = Figure(figsize=(width, 6.6), layout="constrained")
    axes = figure.subplots()
    axes.imshow(image.rgba, extent=image.extent, origin="lower", interpolation="antialiased")
    axes.set_axis_off()
    axes.set_title(title, pad=12)  # above the number of a boundary on top
    if scale is not None:
        figure.colorbar(scale[0], ax=axes, shrink=0.75, pad=0.02, label=scale[1])
    _draw_ruler(axes, image, label("the unit of length", length))
    _draw_triad(figure, camera)
    return figure, axes


def _alike(own: IntArray, facets: IntArray) -> IntArray:
    """Facets of own nodes in which those are the same that are the same in others: corners of triangles."""
    first = np.argmax(facets[:, :, None] == facets[:, None, :], axis=2)
    return np.take_along_axis(own, first, axis=1)


def _colour(k: int) -> tuple[float, float, float]:
    red, green, blue, _ = colormaps[COLOURS]((k % 20 + 0.5) / 20)
    return red, green, blue


def _number_boundaries(
    axes: Any, camera: Camera, points: Array, facets: IntArray, boundaries: Mapping[str, IntArray]
) -> None:
    """Write the number of each boundary on that of its facets that is nearest to its middle, if it faces the eye."""
    corners = points[facets[:, :4]]
    middles = corners.mean(axis=1)
    areas = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    towards = areas @ camera.axes[2] / np.maximum(np.linalg.norm(areas, axis=1), np.finfo(float).tiny)
    for k, chosen in enumerate(boundaries.values(), start=1):
        facing = chosen[towards[chosen] > FACING]
        if len(facing):
            middle = middles[facing].mean(axis=0)
            at = facing[np.argmin(((middles[facing] - middle) ** 2).sum(axis=1))]
            _write_number(axes, k, camera.axes[:2] @ middles[at])


def _write_number(axes: Any, number: int, place: Array) -> None:
    box = {"boxstyle": "circle,pad=0.25", "facecolor": "white", "edgecolor": "0.3", "alpha": 0.85}
    axes.annotate(str(number), tuple(place), ha="center", va="center", fontsize="small", bbox=box)


def _draw_ruler(axes: Any, image: Image, length: str) -> None:
    """A ruler of a round length below the picture; the projection is parallel, so it holds everywhere."""
    left, right, bottom, top = image.extent
    target = 0.2 * (right - left)
    decade = 10 ** np.floor(np.log10(target))
    size = max(f * decade for f in (1.0, 2.0, 5.0) if f * decade <= target)
    y = bottom - 0.05 * (top - bottom)
    axes.plot([right - size, right], [y, y], color="black", linewidth=2.5, solid_capstyle="butt", clip_on=False)
    text = f"{size:g} {length}".strip()
    axes.text(right - size / 2, y - 0.02 * (top - bottom), text, ha="center", va="top")
    axes.set_ylim(bottom - 0.12 * (top - bottom), top)
    axes.set_xlim(left, right)


def _draw_triad(figure: Figure, camera: Camera) -> None:
    """The world's axes in the lower left corner."""
    axes = figure.add_axes((0.01, 0.01, 0.11, 0.16))
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.set_xlim(-1.4, 1.4)
    axes.set_ylim(-1.4, 1.4)
    for k in np.argsort(camera.axes[2]).tolist():
        x, y = camera.axes[:2, k]
        name, colour = "xyz"[k], ("tab:red", "tab:green", "tab:blue")[k]
        axes.annotate("", (x, y), (0, 0), arrowprops={"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0})
        if np.hypot(x, y) > 0.05:
            axes.text(1.25 * x, 1.25 * y, name, color=colour, ha="center", va="center")
