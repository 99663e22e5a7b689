"""Pictures: pressure maps seen along the contact's normal, and Hertz beside them. Needs matplotlib only."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from fecontact.errors import InputError
from fecontact.io import check_writable
from fecontact.mesh.facets import shapes_on_square

if TYPE_CHECKING:
    from fecontact.result import ContactFields, ContactResult
    from fecontact.spheres import SpheresResult

Array = NDArray[np.float64]

FIELDS = ("pressure", "gap")
COLOURS = {"pressure": "inferno_r", "gap": "viridis"}
#: Cells per side into which a facet is divided for a smooth picture.
FINENESS = 6


def save_figure(figure: Figure, path: str | Path | None) -> Figure:
    """Write a figure if a path is given."""
    if path is not None:
        figure.savefig(check_writable(path), dpi=150)
    return figure


def plot_result(
    result: ContactResult, what: str = "pressure", path: str | Path | None = None, units: str = ""
) -> Figure:
    """Map a field of every contact, seen along its mean normal.

    Parameters
    ----------
    result : ContactResult
    what : {'pressure', 'gap'}
    path : str or Path, optional
        File to write; the suffix decides the format.
    units : str
        For the colour bar.
    """
    if what not in FIELDS:
        raise InputError(f"Unknown field {what!r} to plot; expected one of {', '.join(map(repr, FIELDS))}.")
    n = len(result.contacts)
    figure = Figure(figsize=(6.4 * n, 5.2), layout="constrained")
    for axes, contact in zip(np.atleast_1d(figure.subplots(1, n)), result.contacts, strict=True):
        draw_field(axes, contact, getattr(contact, what), what, units)
        axes.set_title(f"{contact.slave.name}.{contact.surfaces[0]} on {contact.master.name}.{contact.surfaces[1]}")
    return save_figure(figure, path)


def view_axes(normals: Array, forces: Array) -> Array:
    """Two directions (2, 3) spanning the plane seen along the mean normal; world axes where they fit."""
    weights = forces if forces.any() else np.ones(len(forces))
    n = weights @ normals
    n /= np.linalg.norm(n)
    # the two world axes most nearly in the plane, in their order, so that a contact along z is seen as x against y
    first, second = sorted(np.argsort(np.abs(n))[:2])
    u = np.eye(3)[first] - n[first] * n
    u /= np.linalg.norm(u)
    v = np.eye(3)[second] - n[second] * n - (np.eye(3)[second] @ u) * u
    v /= np.linalg.norm(v)
    return np.stack([u, v])


def draw_field(
    axes: Any, contact: ContactFields, values: Array, what: str, units: str = "", margin: float = 1.3
) -> None:
    """Draw a nodal field of a contact with smooth shading, the facets' edges and the scale."""
    plane = view_axes(contact.normals, contact.forces)
    triangles, xy, shades = _shaded(contact, contact.points @ plane.T, values)
    limits = {"vmin": 0.0, "vmax": values.max() or 1.0} if what == "pressure" else {}
    drawn = axes.tripcolor(
        Triangulation(xy[:, 0], xy[:, 1], triangles), shades, shading="gouraud", cmap=COLOURS[what], **limits
    )
    for side in _facet_sides(contact, contact.points @ plane.T):
        axes.plot(*side.T, color="0.4", linewidth=0.3, alpha=0.6)
    name = {"pressure": "contact pressure", "gap": "gap"}[what]
    axes.figure.colorbar(drawn, ax=axes, label=f"{name} [{units}]" if units else name)
    axes.set_aspect("equal")
    axes.set_xlabel(_axis_name(plane[0]))
    axes.set_ylabel(_axis_name(plane[1]))
    active = contact.active
    if active.any():
        here = contact.points[active] @ plane.T
        middle, half = (here.max(0) + here.min(0)) / 2, margin * np.ptp(here, axis=0).max() / 2
        if half > 0:
            flat = contact.points @ plane.T
            low, high = flat.min(0), flat.max(0)
            axes.set_xlim(max(low[0], middle[0] - half), min(high[0], middle[0] + half))
            axes.set_ylim(max(low[1], middle[1] - half), min(high[1], middle[1] + half))


def _axis_name(direction: Array) -> str:
    k = int(np.argmax(np.abs(direction)))
    return "xyz"[k] if abs(direction[k]) > 0.999 else "({:.2f}, {:.2f}, {:.2f})".format(*direction)


def _shaded(contact: ContactFields, xy: Array, values: Array) -> tuple[Array, Array, Array]:
    """Facets divided into small triangles with interpolated values."""
    t = np.linspace(0.0, 1.0, FINENESS + 1)
    local = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    N, _ = shapes_on_square(contact.facets, local)
    points = (N @ xy[contact.facets]).reshape(-1, 2)
    shades = contact.interpolated(values, local).ravel()
    index = np.arange(len(local)).reshape(FINENESS + 1, FINENESS + 1)
    a, b, c, d = (index[i : i + FINENESS, j : j + FINENESS].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    cell = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    starts = len(local) * np.arange(len(contact.facets))
    return (starts[:, None, None] + cell).reshape(-1, 3), points, shades


def _facet_sides(contact: ContactFields, xy: Array) -> Array:
    """The four curved sides of each facet as polylines (4 n_facets, n, 2)."""
    t = np.linspace(0.0, 1.0, FINENESS + 1)
    zero, one = np.zeros_like(t), np.ones_like(t)
    sides = [np.stack(s, 1) for s in ((t, zero), (one, t), (t, one), (zero, t))]
    N, _ = shapes_on_square(contact.facets, np.concatenate(sides))
    return (N @ xy[contact.facets]).reshape(-1, FINENESS + 1, 2)


def plot_spheres(out: SpheresResult, path: str | Path | None = None) -> Figure:
    """Pressure over the radius beside Hertz, and the pressure map of the quarter that was modelled."""
    case, exact, contact = out.case, out.case.hertz, out.contact
    figure = Figure(figsize=(12.0, 5.0), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
    near = out.radius <= 1.35 * exact.a
    points, pressure, _ = contact.sampled(contact.pressure, FINENESS)
    r = np.hypot(points[:, 0], points[:, 1])
    inside = r <= 1.35 * exact.a
    left.plot(
        r[inside], pressure[inside], ".", color="tab:orange", markersize=2, alpha=0.5, label="interpolated in the faces"
    )
    left.plot(out.radius[near], contact.pressure[near], "o", color="tab:blue", markersize=3.5, label="contact nodes")
    line = np.linspace(0.0, 1.35 * exact.a, 600)
    left.plot(line, exact.pressure(line), color="black", linewidth=1.2, label="Hertz")
    left.set_xlabel(f"radius [{case.length}]")
    left.set_ylabel(f"pressure [{case.unit_force}/{case.length}²]")
    left.set_title(
        f"R = {case.radii[0]:g} and {case.radii[1]:g} {case.length}, P = {case.force:g} {case.unit_force}: "
        f"L2 error {100 * out.pressure_l2_error:.2f} %"
    )
    left.set_ylim(bottom=0.0)
    left.legend()
    draw_field(right, contact, contact.pressure, "pressure", f"{case.unit_force}/{case.length}²")
    angle = np.linspace(0.0, np.pi / 2, 100)
    right.plot(
        exact.a * np.cos(angle), exact.a * np.sin(angle), "--", color="tab:cyan", linewidth=1.5, label="Hertz radius"
    )
    right.legend(loc="upper right")
    right.set_title(
        f"{out.options['element']}, {out.options['pressure']} pressures, {out.result.n_dofs} dofs, "
        f"{out.seconds['total']:.1f} s"
    )
    return save_figure(figure, path)
