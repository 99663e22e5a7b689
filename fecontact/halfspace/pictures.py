"""Pictures of contacts on half-spaces: pressure, gap, displacement, stress inside, and what sticks and slips.

Files of contacts on half-spaces.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import scipy

from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.errors import InputError
from fecontact.common.files import check_writable, new_figure, replacing, save_figure, save_json
from fecontact.common.html import cell
from fecontact.common.material import von_mises
from fecontact.common.panels import panel, scale_by_decades
from fecontact.common.renamed import warn
from fecontact.common.units import UnitNames, Units
from fecontact.halfspace import inside
from fecontact.halfspace.grid import Grid
from fecontact.halfspace.layered import STRESSED, thin_layers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Cells per side of a free half-space, beyond which they are joined for the section.
SECTION_CELLS = 512
#: Least depth of a section over a cell, growth of its depths, and depth over the side of the blocks that count there.
SHALLOWEST, GROWTH, BLOCK = 0.02, 1.15, 8.0
#: Depth of the lower side of an interface, over that of the interface.
BELOW_INTERFACE = 1 + 1e-9
#: Colours of cells by their state, and arrows along a side of the grid.
COLOURS = {"open": "#f2f2f2", "sticks": "#9ecae1", "slips": "#fdae6b"}
ARROWS = 16
#: Longer side of a map, in inches; sides of a grid from whose ratio on the shorter one is stretched, and says so.
MAP, LONG = 3.5, 4.0
#: Share of the values above zero that a scale shows if the largest is so many times as large.
SHOWN_SHARE, PALE = 0.99, 1.5


#: A `HalfSpaceContact`; one with friction, a `FrictionContact`. They draw themselves with this module.
Pressed = Any
Dragged = Any


class Drawn:
    """Something with a picture, whose labels have names of units."""

    def plot(
        self,
        path: str | Path | None = None,
        *,
        units: UnitNames = (),
        length: str = "",
        force: str = "",
        stress: str = "",
        ax: Axes | None = None,
    ) -> Figure:
        """Draw it, a matplotlib figure.

        Parameters
        ----------
        path : str or Path, optional
            File to write; the suffix decides the format.
        units : (length, force) or (length, force, stress), or str
            Names of the units for labels, as of a scene: ``("mm", "N", "MPa")``; a text is that of the pressure.
        length, force : str
            Names of the other units beside a text.
        stress : str
            Former name of `units`; it warns.
        ax : matplotlib Axes, optional
            Where to draw a picture of one panel or, of a contact, its pressure alone.

        Raises
        ------
        InputError
            If the file cannot be written, a name is no text, or axes are given and the picture has several panels.
        """
        if stress:
            warn("plot(stress=) is now plot(units=); the old name will be removed.", stacklevel=3)
        names = Units.labels(stress or units, length=length, force=force)
        if ax is None:
            return self._drawn(path, names)
        self._draw_in(ax, names)
        return save_figure(cast("Figure", ax.figure), path)

    def _repr_html_(self) -> str:
        return cell(self, self.plot)

    def _drawn(self, path: str | Path | None, units: Units) -> Figure:
        """The picture; one of several panels overrides this, one of a single panel the next."""
        ax = panel(None, (6.4, 4.6))
        self._draw_in(ax, units)
        return save_figure(cast("Figure", ax.figure), path)

    def _draw_in(self, ax: Axes, units: Units) -> None:
        raise InputError("This picture has several panels: leave ax= out.", code="several-panels")


def plot_pressed(
    contact: Pressed, path: str | Path | None = None, units: Units | None = None, name: str = ""
) -> Figure:
    """Pressure, gap, displacement of the surface, and the von Mises stress in the plane y = constant below the peak.

    If the surface has yielded, its dent in place of the displacement.

    Parameters
    ----------
    contact : HalfSpaceContact
    path : str or Path, optional
        File to write; the suffix decides the format.
    units : Units, optional
        Units for labels.
    name : str
        Name of the counter-surface, for the title.
    """
    names = units or Units()
    wide, high = MAP * np.array(contact.grid.size) / max(contact.grid.size)
    figure = new_figure((2 * max(wide, 2.6) + 3.6, 2 * max(high, 1.8) + 1.9), "compressed")
    (first, second), (third, fourth) = figure.subplots(2, 2)
    gap = np.where(np.isfinite(contact.gap), contact.gap, np.nan)
    # limit the scale: the gap of a round shape is large far from the contact
    limit = float(np.nanquantile(gap, 0.9)) if not contact.periodic else None
    draw_pressure(first, contact, names)
    draw_map(second, contact.grid, gap, "viridis", names.axis_label("gap", "length"), names, limit)
    dented = contact.dent is not None and contact.dent.any()
    sunk, what = (contact.dent, "dent") if dented else (contact.displacement, "displacement")
    draw_map(third, contact.grid, sunk, "YlGnBu", names.axis_label(what, "length"), names)
    draw_section(fourth, contact, names)
    figures = (
        f"{name + ': ' if name else ''}force {names.number(contact.force, 'force')}, "
        f"area {names.number(contact.figures['area'], 'length', '²')}, "
        f"approach {names.number(contact.approach, 'length')}"
    )
    figure.suptitle("\n".join(filter(None, (figures, contact.error_estimate.caution))))
    return save_figure(figure, path)


def plot_over_force(
    force: Array,
    panels: Mapping[str, Mapping[str, Array]],
    title: str,
    units: Units,
    path: str | Path | None = None,
    in_order: bool = False,
) -> Figure:
    """Draw curves over the force, a panel for each quantity.

    Parameters
    ----------
    force : (n,) array
    panels : mapping of label to curves
        Curves (n,) by their names; one called "exact" is drawn dashed and only where it is finite.
    title : str
    units : Units
    path : str or Path, optional
        File to write; the suffix decides the format.
    in_order : bool
        Whether the order of the loads counts, as where a surface yields: lines follow it, not the force.
    """
    rows = (len(panels) + 1) // 2
    figure = new_figure((10.0, 3.8 * rows))
    order = np.arange(len(force)) if in_order else np.argsort(force, kind="stable")
    places = figure.subplots(rows, 2).ravel()
    for axes in places[len(panels) :]:
        axes.set_visible(False)
    for axes, (label, curves) in zip(places[: len(panels)], panels.items(), strict=True):
        shown = {name: v for name, v in curves.items() if name != "exact" or np.isfinite(v).any()}
        for name, values in shown.items():
            style = {"color": "black", "linestyle": "--", "linewidth": 1.0} if name == "exact" else {"marker": "o"}
            drawn = np.where(np.isfinite(values), values, np.nan)[order]
            axes.plot(force[order], drawn, markersize=4, label=name, **style)
        scale_by_decades(axes, force, shown.values())
        if len(shown) > 1:
            axes.legend()
        axes.set_xlabel(units.axis_label("force", "force"))
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    figure.suptitle(title)
    return save_figure(figure, path)


def plot_creep(creepage: Array, spin: Array, panels: Mapping[str, Array], path: str | Path | None = None) -> Figure:
    """Draw values (n,) over creepages (n,), a panel for each quantity and a curve for each spin (n,)."""
    figure = new_figure((4.8 * len(panels), 4.4))
    for axes, (label, values) in zip(figure.subplots(1, len(panels)), panels.items(), strict=True):
        for value in np.unique(spin):
            at = np.flatnonzero(spin == value)
            at = at[np.argsort(creepage[at], kind="stable")]
            axes.plot(creepage[at], values[at], marker="o", markersize=4, label=f"spin {value:g}")
        axes.legend()
        axes.set_xlabel("creepage")
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    return save_figure(figure, path)


def draw_pressure(axes: Any, contact: Pressed, names: Units) -> None:
    """Draw the pressure where there is a counter-surface, its largest in the title where the scale ends below it."""
    pressure = np.where(np.isfinite(contact.gap), contact.pressure, np.nan)
    draw_map(axes, contact.grid, pressure, "magma_r", names.axis_label("pressure", "stress"), names, top(pressure))
    if top(pressure) is not None:
        axes.set_title(f"largest {names.number(contact.max_pressure, 'stress')}", fontsize="medium")


def top(values: Array) -> float | None:
    """Upper end of a scale of values of which a few are far above all others; None where it is the largest.

    Examples
    --------
    >>> top(np.arange(1.0, 101.0)), round(top(np.append(np.arange(1.0, 1001.0), 9000.0)) or 0.0)
    (None, 991)
    """
    shown = values[np.nan_to_num(values) > 0]
    most = float(np.quantile(shown, SHOWN_SHARE)) if len(shown) else 0.0
    return most if most and shown.max() > PALE * most else None


def draw_map(
    axes: Any, grid: Grid, values: Array, colours: str, label: str, names: Units, limit: float | None = None
) -> None:
    """Draw values (nx, ny) on the cells."""
    drawn = _draw_cells(axes, grid, values, names, cmap=colours, vmax=limit)
    axes.figure.colorbar(drawn, ax=axes, label=label, extend="max" if limit is not None else "neither")


def _draw_cells(axes: Any, grid: Grid, values: Array, names: Units, **colours: Any) -> Any:
    """Values (nx, ny) as an image on axes along the grid."""
    half = (grid.size[0] / 2, grid.size[1] / 2)
    narrow = max(half) >= LONG * min(half)
    axes.set_xlabel(names.axis_label("x, stretched" if narrow and half[0] < half[1] else "x", "length"))
    axes.set_ylabel(names.axis_label("y, stretched" if narrow and half[1] < half[0] else "y", "length"))
    return axes.imshow(
        values.T,
        origin="lower",
        extent=(-half[0], half[0], -half[1], half[1]),
        aspect="auto" if narrow else "equal",
        interpolation="nearest",
        **colours,
    )


def section(contact: Pressed) -> tuple[float, Array, Array, Array]:
    """Stress in the plane y = constant through the largest pressure, below the middles of the cells along x.

    Depths are half a cell apart at the surface and grow by `GROWTH`; both sides of interfaces are among them. Cells
    count by blocks whose side is a small share of the depth; by larger ones only beyond `SECTION_CELLS` cells.

    It is as deep as half the grid's side (a fifth if periodic) or, on a rigid base, the layers.

    Returns
    -------
    y : float
        Place of the plane.
    x : (n,) array
    z : (m,) array
        Not positive.
    stress : (n, m, 6) array
        xx, yy, zz, xy, yz, xz, tension positive.
    """
    grid, y = contact.grid, float(contact.grid.y[np.unravel_index(contact.pressure.argmax(), contact.grid.shape)[1]])
    deepest = grid.size[0] / (5 if contact.periodic else 2)
    interfaces = np.cumsum([layer.thickness for layer in contact.layers])
    if contact.material is None:
        deepest, interfaces = min(deepest, interfaces[-1]), interfaces[:-1]
    coarsest = 0 if contact.periodic else section_blocks(contact)
    depths = _depths(min(grid.cell) * 2**coarsest, deepest, interfaces)
    if not contact.active.any():
        return y, grid.x, -depths, np.zeros((grid.shape[0], len(depths), 6))
    if contact.periodic:
        points = np.stack([a.ravel() for a in np.meshgrid(grid.x, y, -depths, indexing="ij")], axis=1)
        return y, grid.x, -depths, contact.stress(points).reshape(grid.shape[0], len(depths), 6)
    largest = max(coarsest, int(np.log2(min(grid.shape))) - 2)
    halvings = np.clip(np.log2(depths / (BLOCK * min(grid.cell))).astype(int), coarsest, largest)
    missing = [-n % 2 ** int(halvings.max()) for n in grid.shape]
    pressure = np.pad(contact.pressure, [(0, m) for m in missing])
    shift = [m * side / 2 for m, side in zip(missing, grid.cell, strict=True)]
    lines = []
    for n in np.unique(halvings):
        means = pressure.reshape(len(pressure) // 2**n, 2**n, -1, 2**n).mean(axis=(1, 3))
        sides = [side * count for side, count in zip(grid.cell, pressure.shape, strict=True)]
        loaded = inside.Loaded(Grid((sides[0], sides[1]), means.shape), means, contact.material, contact.layers)
        stress = loaded.below(y - shift[1], depths[halvings == n]) * inside.OUTWARDS
        lines.append(scipy.interpolate.make_interp_spline(loaded.grid.x + shift[0], stress, 1)(grid.x))
    return y, grid.x, -depths, np.concatenate(lines, axis=1)


def section_blocks(contact: Pressed) -> int:
    """How often the cells of a free surface are joined by two for its section, to be no more than `SECTION_CELLS`."""
    return max(0, int(np.ceil(np.log2(max(contact.grid.shape) / SECTION_CELLS))))


def _depths(cell: float, deepest: float, interfaces: Array) -> Array:
    """Depths of a section, graded to the cell, with both sides of interfaces."""
    step = cell / 2
    steady = step * np.arange(1, 1 / (GROWTH - 1))
    count = max(2, 1 + int(np.log(max(deepest / steady[-1], 1)) / np.log(GROWTH)))
    inner = np.concatenate([[SHALLOWEST * cell], steady, np.geomspace(steady[-1], max(deepest, steady[-1]), count)])
    sides = interfaces[:, None] * [1.0, BELOW_INTERFACE]
    depths = np.unique(np.concatenate([inner, [deepest], sides.ravel()]))
    return np.asarray(depths[depths <= deepest])


def draw_section(axes: Any, contact: Pressed, names: Units) -> None:
    """Draw the von Mises stress in the plane through the largest pressure."""
    thin = 0 if contact.periodic else thin_layers(contact.layers, STRESSED * max(contact.grid.cell))
    contact = replace(contact, layers=contact.layers[thin:])
    if contact.material is None and not contact.layers:
        axes.set_title("no section: the layers are thinner than half a cell", fontsize="medium")
        return axes.set_axis_off()
    y, x, z, stress = section(contact)
    from matplotlib.ticker import MaxNLocator

    values = von_mises(stress.reshape(-1, 6)).reshape(stress.shape[:2])
    most = top(values) or values.max() or 1.0
    levels = MaxNLocator(24).tick_values(0.0, most)
    drawn = axes.contourf(x, z, values.T, levels=levels, cmap="YlOrRd", extend="max" if top(values) else "neither")
    axes.figure.colorbar(drawn, ax=axes, label=names.axis_label("von Mises stress", "stress"))
    depth = 0.0
    for layer in contact.layers:
        depth -= layer.thickness
        if depth > z.min():
            axes.axhline(depth, color="black", linewidth=0.8)
    i, k = np.unravel_index(values.argmax(), values.shape)
    axes.plot(x[i], z[k], "k+")
    title = (
        f"y = {names.number(y, 'length')}, below the largest pressure\n"
        f"largest (+): {names.number(values[i, k], 'stress')}, {names.number(-z[k], 'length')} deep"
    )
    if not contact.periodic and (blocks := section_blocks(contact)):
        title += f", of blocks of {2**blocks} x {2**blocks} cells"
    if thin:
        title += f"\nbelow {thin} layer(s) thinner than half a cell"
    axes.set_title(title, fontsize="medium")
    axes.set_xlabel(names.axis_label("x", "length"))
    axes.set_ylabel(names.axis_label("z", "length"))
    axes.set_aspect("equal" if -z.min() > 0.25 * (x[-1] - x[0]) else "auto")


def draw_stick_slip(axes: Any, contact: Dragged, names: Units) -> None:
    """Draw what sticks, slips and is open, with arrows along the tractions."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    grid = contact.grid
    state = np.where(contact.slipping, 2, np.where(contact.active, 1, 0))
    shades = ListedColormap(list(COLOURS.values()))
    _draw_cells(axes, grid, state, names, cmap=shades, vmin=-0.5, vmax=2.5)
    every = tuple(max(1, n // ARROWS) for n in grid.shape)
    some = (slice(every[0] // 2, None, every[0]), slice(every[1] // 2, None, every[1]))
    x, y = np.meshgrid(grid.x[some[0]], grid.y[some[1]], indexing="ij")
    tx, ty = contact.traction[0][some], contact.traction[1][some]
    drawn = np.hypot(tx, ty) > 0
    if drawn.any():
        axes.quiver(x[drawn], y[drawn], tx[drawn], ty[drawn], color="black", width=0.004)
    handles = [Patch(color=c, label=n) for n, c in COLOURS.items()]
    above = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncols": len(handles), "frameon": False}
    axes.legend(handles=handles, fontsize="small", **above)


def plot_dragged(contact: Dragged, path: str | Path | None = None, units: Units | None = None) -> Figure:
    """Stick, slip and open cells with the tractions as arrows, the size of the tractions, and the worn depth if any.

    Without tractions, the pressure.

    Parameters
    ----------
    contact : FrictionContact
    path : str or Path, optional
        File to write; the suffix decides the format.
    units : Units, optional
        Units for labels.
    """
    names = units or Units()
    size, worn = np.hypot(contact.traction[0], contact.traction[1]), contact.columns().get("worn")
    shown, what = (size, "tangential traction") if size.any() else (contact.pressure, "pressure")
    maps = [(shown, "magma_r", names.axis_label(what, "stress"))]
    maps += [] if worn is None else [(worn, "YlOrBr", names.axis_label("worn depth", "length"))]
    figure = new_figure((5.5 * (1 + len(maps)), 5.0))
    left, *others = figure.subplots(1, 1 + len(maps))
    draw_stick_slip(left, contact, names)
    for axes, (values, colours, label) in zip(others, maps, strict=True):
        draw_map(axes, contact.grid, values, colours, label, names)
    return save_figure(figure, path)


def plot_moving(contact: Pressed, path: str | Path | None, units: Units) -> Figure:
    """Pressure of a `MovingContact` with its centre and the way it goes, and a section along that, ahead to the right.

    In the section the surface moves from the right to the left; behind the contact it comes back.
    """
    figure = new_figure((12.0, 5.0))
    left, right = figure.subplots(1, 2)
    draw_map(left, contact.grid, contact.pressure, "magma_r", units.axis_label("pressure", "stress"), units)
    ahead = np.divide(contact.velocity, np.hypot(*contact.velocity))
    centre, reach = np.array(contact.centre_of_pressure), 0.5 * min(contact.grid.size)
    left.plot(*centre, "+", color="tab:cyan", markersize=10, label="centre of pressure")
    left.legend(loc="upper right", fontsize="small")
    left.annotate("", 0.95 * reach * ahead, 0.6 * reach * ahead, arrowprops={"arrowstyle": "-|>", "color": "tab:blue"})
    s = reach * np.linspace(-1, 1, 2 * max(contact.grid.shape))
    i, k = np.unravel_index(contact.pressure.argmax(), contact.grid.shape)
    peak = np.array([contact.grid.x[i], contact.grid.y[k]])
    line = peak + (s[:, None] - peak @ ahead) * ahead
    gap = np.where(np.isfinite(contact.gap), contact.gap, np.nan)
    p, u, h = (
        scipy.interpolate.RegularGridInterpolator((contact.grid.x, contact.grid.y), v, bounds_error=False)(line)
        for v in (contact.pressure, contact.displacement, gap)
    )
    right.plot(s, -u, color="tab:blue", label="half-space")
    right.plot(s, h - u, color="black", label="counter-surface")
    if (depth := np.nanmax(u) - np.nanmin(u)) > 0:
        right.set_ylim(-np.nanmax(u) - 0.1 * depth, -np.nanmin(u) + 0.5 * depth)
    right.set_xlabel(units.axis_label("place along the motion", "length"))
    right.set_ylabel(units.axis_label("height", "length"))
    pressure = right.twinx()
    pressure.fill_between(s, p, color="tab:red", alpha=0.25, label="pressure")
    pressure.set_ylabel(units.axis_label("pressure", "stress"))
    handles = [*right.lines, pressure.collections[0]]
    right.legend(handles=handles, loc="lower left", bbox_to_anchor=(0, 0.06), fontsize="small")  # off the curves
    figure.suptitle(f"force {units.number(contact.force, 'force')}, drag {units.number(contact.drag, 'force')}")
    return save_figure(figure, path)


def save_fields(
    path: str | Path, grid: Grid, fields: Mapping[str, Array], summary: Mapping[str, Any], units: UnitNames = ()
) -> Path:
    """Write fields (nx, ny) on the cells of a grid, or a summary; the suffix decides.

    Parameters
    ----------
    path : str or Path
        .json (the summary), .csv (one row per cell) or .npz (arrays, with x and y of the cells).
    grid : Grid
    fields : mapping of name to (nx, ny) array
    summary : mapping
    units : (length, force) or (length, force, stress), optional
        Names for heads of columns, and a last entry of the others.

    Raises
    ------
    InputError
        For another suffix, or a file that cannot be written.
    """
    path, names = check_writable(path), Units.of(units)
    told = {"units": asdict(names)} if units else {}
    among("suffix of a file of a half-space", suffix := path.suffix.lower(), (".json", ".csv", ".npz"))
    if suffix == ".json":
        return save_json(path, {**summary, **told})
    with replacing(path) as file:
        if suffix == ".npz":
            texts = {name: np.array(list(names.values())) for name, names in told.items()}
            np.savez_compressed(file, allow_pickle=False, x=grid.x, y=grid.y, **fields, **texts)
        else:
            x, y = np.meshgrid(grid.x, grid.y, indexing="ij")
            table = np.column_stack([x.ravel(), y.ravel(), *(values.ravel() for values in fields.values())])
            heads = ",".join(names.heads(["x", "y", *fields]))
            np.savetxt(file, table, "%.17g", ",", header=heads, comments="", encoding="utf-8")
    return path


def draw_adhesion(axes: Any, curve: Any, units: Units) -> None:
    """Force over approach of an `AdhesionCurve`: coming on, off, jumps between, and the pull-off."""
    jumps = [(jump.approach, jump.before) for jump in curve.jumps]
    x, f = curve.approach, curve.force
    for colour, label, sign, width in (("tab:blue", "coming on", 1, 3.5), ("tab:red", "coming off", -1, 1.2)):
        shown = np.flatnonzero(np.diff(x) * sign > 0)
        for k in shown:
            jumped = (x[k + 1], f[k]) in jumps
            axes.plot(x[k : k + 2], f[k : k + 2], color=colour, linewidth=width, linestyle=":" if jumped else "-")
        ends = np.union1d(shown, shown + 1)
        axes.plot(x[ends], f[ends], ".", color=colour, label=label)
    if curve.pull_off:
        label = f"pull-off {units.number(curve.pull_off, 'force')}"
        axes.plot(curve.pull_off_approach, -curve.pull_off, "kv", fillstyle="none", markersize=9, label=label)
    axes.axhline(0.0, color="black", linewidth=0.6)
    axes.set_xlabel(units.axis_label("approach", "length"))
    axes.set_ylabel(units.axis_label("force", "force"))
    axes.legend()
    axes.grid(alpha=0.3)
