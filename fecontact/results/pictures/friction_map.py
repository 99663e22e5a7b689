"""Pictures of friction: tangential tractions with their directions, and what sticks and what slides."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.common.units import Units
from fecontact.results.contact_fields import ContactFields
from fecontact.results.friction_fields import FrictionFields
from fecontact.results.pictures.map_projection import MapProjection
from fecontact.results.pictures.section_curve import along_axis, axis_name, curve_window

#: Colours of points that stick and slide.
STICK, SLIDE = "tab:blue", "tab:red"
#: Label of circumferential tractions.
ROUND = "round the axis"
#: Arrows drawn at most.
MOST_ARROWS = 300


def draw_friction_curve(axes: Any, contact: ContactFields, friction: FrictionFields, units: Units) -> None:
    """Draw tractions along a contact of sections, between the limits of friction."""
    k = along_axis(contact)
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
    axes.set_xlim(*curve_window(contact, k))
    axes.set_xlabel(units.after(axis_name(contact, k), "length"))
    axes.set_ylabel(units.after("traction of friction", "stress"))
    axes.grid(color="0.9")
    axes.legend(loc="best", fontsize="small")


def draw_arrows(axes: Any, contact: ContactFields, friction: FrictionFields, projection: MapProjection) -> None:
    """Draw directions of tractions on the slave, on a map, coloured by what sticks and slides, and the edge."""
    flat = projection.flat(contact.points)
    traction = projection.directions(contact.points, friction.traction)
    largest = float(np.linalg.norm(traction, axis=1).max(initial=0.0))
    every = max(1, -(-int(friction.touching.sum()) // MOST_ARROWS))
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
