"""Pictures of contacts: pressure and gap maps seen along the contact's normal. Needs matplotlib only."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from fecontact.common.arguments import flag, items, known_options, text
from fecontact.common.arrays import Array
from fecontact.common.checks import among, positive, whole
from fecontact.common.errors import InputError
from fecontact.common.units import Units
from fecontact.mesh.facets import shapes_on_square
from fecontact.results.contact_fields import ContactFields
from fecontact.results.friction_fields import FrictionFields
from fecontact.results.pictures.convergence import draw_convergence
from fecontact.results.pictures.figure import save_figure
from fecontact.results.pictures.friction_map import draw_arrows, draw_friction_curve
from fecontact.results.pictures.section_curve import draw_curve
from fecontact.results.solved_scene import SolvedScene

FIELDS = ("pressure", "gap", "friction")
STYLES = ("smooth", "sensels")
COLOURS = {"pressure": "magma_r", "gap": "viridis", "friction": "Greys"}
#: Cells per side into which a facet is divided for a smooth picture.
FINENESS = 6
#: Share of the largest pressure above which a sensel shows its pressure.
FELT = 0.02
#: Sensels across a contact by default, and colour steps, as for pressure-sensitive films.
SENSELS, STEPS = 24, 13


def plot_result(result: SolvedScene, what: str = "pressure", path: str | Path | None = None, **options: Any) -> Figure:
    """Draw a field: of the contacts (`plot_contacts`), or of the bodies (`view.view_result`).

    Parameters
    ----------
    result : SolvedScene
    what : str
        'pressure', 'gap' or 'friction' of the contacts; 'convergence' of a result solved to an accuracy; 'von_mises',
        'displacement', 'contact_pressure', 'stress_xx', ... on the bodies.
    path : str or Path, optional
        File to write; the suffix decides the format.
    **options
        Options of the function that draws it.

    Raises
    ------
    InputError
        If there is no such field.
    """
    text("the field", what)
    if what == "convergence":
        known_options(plot_contacts, options)
        return save_figure(draw_convergence(result.convergence), path)
    if what in FIELDS:
        known_options(plot_contacts, options)
        return plot_contacts(result, what, path, **options)
    from fecontact.results.pictures import bodies as view

    among("field", what, (*FIELDS, "convergence", *view.FIELDS))
    known_options(view.view, options)
    return view.view_result(result, what, path, **options)


def plot_contacts(
    result: SolvedScene,
    what: str = "pressure",
    path: str | Path | None = None,
    *,
    units: str = "",
    length: str = "",
    force: str = "",
    style: str = "smooth",
    pitch: float | None = None,
    contacts: Sequence[int] | None = None,
    same_colours: bool = True,
) -> Figure:
    """Map a field of every contact, seen along its mean normal, with its regions outlined.

    Parameters
    ----------
    result : SolvedScene
    what : {'pressure', 'gap', 'friction'}
        'friction': sizes and directions of tractions, and what sticks and slides.
    path : str or Path, optional
        File to write; the suffix decides the format.
    units, length, force : str
        Units of the field, of lengths and of forces, for labels.
    style : {'smooth', 'sensels'}
        'sensels' shows the pressure on a film of square sensors: the force on each over its area.
    pitch : float, optional
        Side of a sensel; a round length that puts about 24 across the contact unless given.
    contacts : sequence of int, optional
        Contacts of the result to draw, by number; all unless given.
    same_colours : bool
        Whether all maps share one scale.

    Raises
    ------
    InputError
        For an unknown field, style or contact, gaps with sensels, or a pitch that is not positive.
    """
    _check_map(result, what, style, pitch, contacts, same_colours)
    if style == "sensels" and any(c.is_curve for c in result.contacts):
        raise InputError("A contact of sections is a curve, on which no film of sensels fits; leave style='smooth'.")
    shown = [result.contacts[k] for k in (range(len(result.contacts)) if contacts is None else contacts)]
    names = Units(length, force, units)
    columns = min(3, len(shown))
    rows = -(-len(shown) // columns)
    figure = Figure(figsize=_figure_size(shown, columns, rows), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    top = max(c.max_pressure for c in shown) if same_colours else None
    for axes, contact in zip(grid, shown, strict=False):
        friction = contact.friction
        if what == "friction" and friction is not None:
            draw_friction(axes, contact, friction, names)
        elif contact.is_curve:
            draw_curve(axes, contact, what, names, top)
        elif style == "sensels":
            draw_sensels(axes, contact, pitch, names, top)
        else:
            draw_field(axes, contact, getattr(contact, what), what, names, top=top)
        if not contact.is_curve and what != "friction":
            draw_regions(axes, contact, names)
        axes.set_title(_title(contact, names), fontsize="medium")
    for axes in grid[len(shown) :]:
        axes.set_axis_off()
    return save_figure(figure, path)


def draw_friction(axes: Any, contact: ContactFields, friction: FrictionFields, units: Units) -> None:
    """Draw sizes and directions of tractions of friction."""
    if contact.is_curve:
        draw_friction_curve(axes, contact, friction, units)
        return
    draw_field(axes, contact, np.linalg.norm(friction.traction, axis=1), "friction", units)
    draw_arrows(axes, contact, friction, view_axes(contact.normals, contact.forces))


def _check_map(
    result: SolvedScene,
    what: str,
    style: str,
    pitch: float | None,
    contacts: Sequence[int] | None,
    same_colours: bool,
) -> None:
    among("field of a contact", what, FIELDS)
    among("style", style, STYLES)
    if style == "sensels" and what != "pressure":
        raise InputError(f"Sensels feel pressure; found the field {what!r}. Draw it with style='smooth'.")
    if pitch is not None:
        positive("the pitch of the sensels", pitch)
    if what == "friction" and any(c.friction is None for c in result.contacts):
        raise InputError("A contact without friction has no tractions to draw; give Contact(..., friction=...).")
    given = (0,) if contacts is None else items("contacts", contacts, "numbers")
    if wrong := [k for k in given if not whole("the number of a contact", k, 0) < len(result.contacts)]:
        raise InputError(f"There is no contact {wrong[0]}; the result has {len(result.contacts)} (0, 1, ...).")
    if not given:
        raise InputError("No contact is to be drawn: give contacts=[0], or leave it out for all.")
    flag("same_colours", same_colours)


def _title(contact: ContactFields, units: Units) -> str:
    head = f"{contact.slave.name}.{contact.surfaces[0]} on {contact.master.name}.{contact.surfaces[1]}"
    if not contact.active.any():
        return f"{head}\nno contact"
    area = contact.edge_area
    mean = contact.total_force / area if area > 0 else 0.0
    return (
        f"{head}\nforce {units.number(float(np.linalg.norm(contact.force)), 'force')}, "
        f"area {units.number(area, 'length', '²')}, "
        f"peak {units.number(contact.max_pressure, 'stress')}, mean {units.number(mean, 'stress')}"
    )


def view_axes(normals: Array, forces: Array) -> Array:
    """Two directions (2, 3) spanning the plane normal to the mean normal; world axes where possible."""
    weights = forces if forces.any() else np.ones(len(forces))
    n = weights @ normals
    n /= np.linalg.norm(n)
    # the two world axes closest to the plane, in order, so that a contact along z is shown as x against y
    first, second = sorted(np.argsort(np.abs(n))[:2])
    u = np.eye(3)[first] - n[first] * n
    u /= np.linalg.norm(u)
    v = np.eye(3)[second] - n[second] * n - (np.eye(3)[second] @ u) * u
    v /= np.linalg.norm(v)
    return np.stack([u, v])


def draw_field(
    axes: Any,
    contact: ContactFields,
    values: Array,
    what: str,
    units: Units | None = None,
    margin: float = 1.3,
    top: float | None = None,
) -> None:
    """Draw a nodal field of a contact with smooth shading, the facets' edges and a scale up to `top`."""
    names = units or Units()
    plane = view_axes(contact.normals, contact.forces)
    beyond = values.max(initial=0.0) if what == "gap" else 0.0
    triangles, xy, shades = _shaded(contact, contact.nodes @ plane.T, None if what == "pressure" else values, beyond)
    limits = {"vmin": 0.0, "vmax": top or values.max(initial=0.0) or 1.0} if what != "gap" else {}
    drawn = axes.tripcolor(
        Triangulation(xy[:, 0], xy[:, 1], triangles), shades, shading="gouraud", cmap=COLOURS[what], **limits
    )
    for side in _facet_sides(contact, contact.nodes @ plane.T):
        axes.plot(*side.T, color="0.4", linewidth=0.3, alpha=0.6)
    labels = {"pressure": "contact pressure", "friction": "traction of friction", "gap": "gap"}
    label = names.after(labels[what], "length" if what == "gap" else "stress")
    axes.figure.colorbar(drawn, ax=axes, label=label)
    _frame(axes, contact, plane, names, margin)


def draw_sensels(
    axes: Any, contact: ContactFields, pitch: float | None = None, units: Units | None = None, top: float | None = None
) -> None:
    """Draw the pressure on square sensors: the force on each over its area, in colour steps."""
    names = units or Units()
    plane = view_axes(contact.normals, contact.forces)
    flat = contact.points @ plane.T
    active = flat[contact.active] if contact.active.any() else flat
    side = pitch or _round_length(float(np.ptp(active, axis=0).max()) / SENSELS)
    low, felt = _felt(contact, plane, side)
    table = ListedColormap(colormaps["turbo"](np.linspace(0.1, 0.95, STEPS)))
    highest = top or felt.max() or 1.0
    seen = np.ma.masked_less_equal(felt, FELT * highest)
    x, y = (low[k] + side * np.arange(felt.shape[k] + 1) for k in range(2))
    drawn = axes.pcolormesh(x, y, seen.T, cmap=table, vmin=0.0, vmax=highest, edgecolors="white", linewidth=0.3)
    label = names.after("pressure on sensels", "stress")
    axes.figure.colorbar(drawn, ax=axes, label=f"{label}, pitch {names.number(side, 'length')}")
    axes.set_facecolor("0.93")
    _frame(axes, contact, plane, names, 1.3)


def _felt(contact: ContactFields, plane: Array, side: float) -> tuple[Array, Array]:
    """Lower corner (2,) of a field of sensels and the pressures (n, m) on them; their force is that of the contact."""
    sizes = np.ptp((contact.nodes @ plane.T)[contact.facets], axis=1)
    points, pressure, area = contact.sampled(contact.pressure, max(FINENESS, int(np.ceil(2 * sizes.max() / side))))
    xy = points @ plane.T / side
    low = np.floor(xy.min(axis=0)) - 1
    shape = np.ceil(xy.max(axis=0) - low).astype(int) + 2
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
    plane = view_axes(contact.normals, contact.forces)
    for curve in contact.outline.curves:
        x, y = plane @ np.append(curve.points, curve.points[:1], axis=0).T
        axes.plot(x, y, color="tab:blue", linewidth=1.2)
    for k, region in enumerate(contact.regions, start=1):
        x, y = plane @ region.centre_of_pressure
        axes.plot(x, y, "+", color="tab:cyan", markersize=9, markeredgewidth=1.6)
        if len(contact.regions) > 1:
            size = (units or Units()).number(float(np.linalg.norm(region.force)), "force")
            box = {"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
            axes.annotate(f"{k}: {size}", (x, y), (7, 7), textcoords="offset points", fontsize="small", bbox=box)


def _frame(axes: Any, contact: ContactFields, plane: Array, units: Units, margin: float) -> None:
    """Equal axes round the contact, named by their directions."""
    low, high = _window(contact, plane, margin)
    axes.set_aspect("equal")
    axes.set_xlabel(units.after(_axis_name(plane[0]), "length"))
    axes.set_ylabel(units.after(_axis_name(plane[1]), "length"))
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])


def _window(contact: ContactFields, plane: Array, margin: float = 1.3) -> tuple[Array, Array]:
    """Lower and upper corner (2,) of the picture: the facets in contact and a margin, or all facets."""
    flat = contact.points @ plane.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    loaded = contact.at_nodes @ contact.forces > 0
    touched = contact.facets[loaded[contact.facets].any(axis=1)]
    here = (contact.nodes @ plane.T)[touched].reshape(-1, 2) if len(touched) else flat[contact.active]
    if len(here) < 2:
        return low, high
    middle = (here.max(axis=0) + here.min(axis=0)) / 2
    half = margin * np.ptp(flat[contact.active], axis=0).max() / 2
    half = np.maximum(half, 1.05 * np.ptp(here, axis=0) / 2)
    return np.maximum(low, middle - half), np.minimum(high, middle + half)


def _figure_size(contacts: Sequence[ContactFields], columns: int, rows: int) -> tuple[float, float]:
    """Size in inches for maps with colour bar and title, in the contacts' proportions, or for curves."""
    if any(c.is_curve for c in contacts):
        return 6.4 * columns, 4.6 * rows
    sides = [np.subtract(*reversed(_window(c, view_axes(c.normals, c.forces)))) for c in contacts]
    tallest = max(float(height / width) if width > 0 else 1.0 for width, height in sides)
    return 6.4 * columns, rows * (min(max(4.6 * tallest, 1.6), 6.5) + 1.2)


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


def _axis_name(direction: Array) -> str:
    k = int(np.argmax(np.abs(direction)))
    return "xyz"[k] if abs(direction[k]) > 0.999 else "({:.2f}, {:.2f}, {:.2f})".format(*direction)


def _shaded(contact: ContactFields, xy: Array, values: Array | None, beyond: float) -> tuple[Array, Array, Array]:
    """Facets divided into triangles with interpolated values; without values the recovered pressure."""
    t = np.linspace(0.0, 1.0, FINENESS + 1)
    local = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    N, _ = shapes_on_square(contact.facets, local)
    points = (N @ xy[contact.facets]).reshape(-1, 2)
    shades = contact.recovered.at(local) if values is None else contact.interpolated(values, local, beyond)
    index = np.arange(len(local)).reshape(FINENESS + 1, FINENESS + 1)
    a, b, c, d = (index[i : i + FINENESS, j : j + FINENESS].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    cell = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    starts = len(local) * np.arange(len(contact.facets))
    return (starts[:, None, None] + cell).reshape(-1, 3), points, shades.ravel()


def _facet_sides(contact: ContactFields, xy: Array) -> Array:
    """The four curved sides of each facet as polylines (4 n_facets, n, 2)."""
    t = np.linspace(0.0, 1.0, FINENESS + 1)
    zero, one = np.zeros_like(t), np.ones_like(t)
    sides = [np.stack(s, 1) for s in ((t, zero), (one, t), (t, one), (zero, t))]
    N, _ = shapes_on_square(contact.facets, np.concatenate(sides))
    return (N @ xy[contact.facets]).reshape(-1, FINENESS + 1, 2)
