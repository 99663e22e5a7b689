"""Pictures of contacts of sections: a field along the curve. Needs matplotlib only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fecontact.common.units import Units
from fecontact.results.field_map import FieldMap, line_points

#: Margin beyond the contact.
MARGIN = 1.35
#: Height of a picture of many, over its width.
RATIO = 2.2 / 2.9


def along_axis(contact: FieldMap) -> int:
    """The coordinate (0: x, 2: z) of the horizontal axis: that of the curve's largest extent."""
    extent = np.ptp(contact.points[contact.active] if contact.active.any() else contact.points, axis=0)
    return 2 if extent[2] > extent[0] else 0


@dataclass(frozen=True, eq=False)
class Curves:
    """What the curves of a field of pressures or gaps share in one picture: limits of both axes, and units."""

    along: tuple[float, float]
    limits: tuple[float, float]
    units: Units

    @classmethod
    def of(cls, maps: Sequence[FieldMap], units: Units, top: float | None = None) -> Curves:
        """That of some fields; its scale of pressures ends at `top`."""
        windows = [curve_window(m, along_axis(m)) for m in maps]
        along = (min(low for low, _ in windows), max(high for _, high in windows))
        if maps[0].what == "pressure":
            return cls(along, (0.0, 1.05 * (top or max(m.peak for m in maps) or 1.0)), units)
        places = [m.points[:, along_axis(m)] for m in maps]
        seen = [m.values[(p >= along[0]) & (p <= along[1])] for m, p in zip(maps, places, strict=True)]
        low, high = (float(end(np.concatenate(seen))) for end in (np.min, np.max))
        room = 0.05 * (high - low or 1.0)
        return cls(along, (low - room, high + room), units)

    @property
    def ratio(self) -> float:
        """Height of a picture over its width."""
        return RATIO

    def draw(self, axes: Any, kept: FieldMap) -> None:
        """Draw a field, interpolated along its sides, and at its nodes."""
        k = along_axis(kept)
        place = line_points(kept)[..., k]
        broken = np.full((len(place), 1), np.nan)
        axes.plot(
            np.concatenate([place, broken], axis=1).ravel(),
            np.concatenate([kept.shades, broken], axis=1).ravel(),
            color="tab:orange",
            linewidth=1.4,
            label="interpolated in the sides",
        )
        axes.plot(kept.points[:, k], kept.values, "o", color="tab:blue", markersize=3.5, label="contact nodes")
        axes.set_xlim(*self.along)
        axes.set_ylim(*self.limits)
        axes.set_xlabel(self.units.axis_label(axis_name(kept, k), "length"))
        label = ("contact pressure", "stress") if kept.what == "pressure" else ("gap", "length")
        axes.set_ylabel(self.units.axis_label(*label))
        axes.grid(color="0.9")

    def add_scale(self, figure: Any, axes: Any, **look: float) -> None:
        """None: the axes have it."""


def draw_curve(axes: Any, kept: FieldMap, units: Units, top: float | None = None) -> None:
    """Draw a field of pressures or gaps of a contact of sections, with its legend and a scale up to `top`."""
    Curves.of([kept], units, top).draw(axes, kept)
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
