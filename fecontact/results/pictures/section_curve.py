"""Pictures of contacts of sections: a field along the curve. Needs matplotlib only."""

from __future__ import annotations

from typing import Any

import numpy as np

from fecontact.common.units import Units
from fecontact.results.field_map import FieldMap, line_points

#: Margin beyond the contact.
MARGIN = 1.35


def along_axis(contact: FieldMap) -> int:
    """The coordinate (0: x, 2: z) of the horizontal axis: that of the curve's largest extent."""
    extent = np.ptp(contact.points[contact.active] if contact.active.any() else contact.points, axis=0)
    return 2 if extent[2] > extent[0] else 0


def draw_curve(axes: Any, contact: FieldMap, units: Units, top: float | None = None) -> None:
    """Draw a field of a contact of sections, interpolated along its sides, and at its nodes.

    Parameters
    ----------
    axes : matplotlib Axes
    contact : FieldMap
        Of pressures or gaps.
    units : Units
    top : float, optional
        Largest pressure of the scale.
    """
    what, values, field = contact.what, contact.values, contact.shades
    k = along_axis(contact)
    place = line_points(contact)[..., k]
    broken = np.full((len(place), 1), np.nan)
    axes.plot(
        np.concatenate([place, broken], axis=1).ravel(),
        np.concatenate([field, broken], axis=1).ravel(),
        color="tab:orange",
        linewidth=1.4,
        label="interpolated in the sides",
    )
    axes.plot(contact.points[:, k], values, "o", color="tab:blue", markersize=3.5, label="contact nodes")
    low, high = curve_window(contact, k)
    axes.set_xlim(low, high)
    if what == "pressure":
        axes.set_ylim(0.0, 1.05 * (top or float(values.max(initial=0.0)) or 1.0))
    else:
        shown = values[(contact.points[:, k] >= low) & (contact.points[:, k] <= high)]
        room = 0.05 * (float(np.ptp(shown)) or 1.0)
        axes.set_ylim(float(shown.min()) - room, float(shown.max()) + room)
    axes.set_xlabel(units.axis_label(axis_name(contact, k), "length"))
    axes.set_ylabel(
        units.axis_label("contact pressure", "stress") if what == "pressure" else units.axis_label("gap", "length")
    )
    axes.grid(color="0.9")
    axes.legend(loc="best", fontsize="small")


def curve_window(contact: FieldMap, k: int) -> tuple[float, float]:
    """Limits of a picture: the contact and a margin, within the curve; the whole curve without contact."""
    place = contact.points[:, k]
    low, high = float(place.min()), float(place.max())
    if not contact.active.any():
        return low, high
    touched = place[contact.active]
    search_radius = (MARGIN - 1) * float(np.ptp(touched))
    return max(low, float(touched.min()) - search_radius), min(high, float(touched.max()) + search_radius)


def axis_name(contact: FieldMap, k: int) -> str:
    """Name of the horizontal axis."""
    if contact.is_ring and k == 0:
        return "radius"
    return contact.directions.name(np.eye(3)[k])
