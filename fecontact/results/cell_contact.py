"""Area and errors of a contact whose slave is a half-space: those of its cells, as of the half-space alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.error_estimate import ErrorEstimate
from fecontact.halfspace.grid_error import LEAST_SHARE, EdgeCells, edge_cells, grid_error_estimate, pressed_ends
from fecontact.halfspace.surface import GridSurface
from fecontact.results.error_estimate import AT_KINKS
from fecontact.surfaces.facet_surface import Surface, has_cells

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields

#: All cells of a grid: in a scene no symmetry halves it.
WHOLE = (slice(None), slice(None))


@dataclass(frozen=True, eq=False)
class CellContact:
    """Pressure of a contact on the cells of a half-space.

    Attributes
    ----------
    surface : GridSurface
    place : (2, n) int array
        Cell of each contact point.
    pressure : (nx, ny) array
    gap : (nx, ny) array
        Infinite where there is no counter-surface.
    edge : EdgeCells
    """

    surface: GridSurface
    place: IntArray
    pressure: Array
    gap: Array
    edge: EdgeCells

    @property
    def areas(self) -> Array:
        """Area (n,) of each point, with the edge located within the cells."""
        found = (self.pressure > 0).astype(float)
        np.add.at(found, tuple(self.edge.place), self.edge.excess[0])
        return np.asarray(found[tuple(self.place)] * self.surface.cell_area)

    def estimate(self, found: ErrorEstimate) -> ErrorEstimate:
        """An estimate with the errors of the cells in place of those of facets between their centres."""
        ends = pressed_ends(self.pressure, np.isfinite(self.gap))
        cells = grid_error_estimate(self.pressure, None, WHOLE, self.edge, self.surface.point_forces, ends)
        if cells.reason or found.reason:
            return found
        pressure = float(np.sqrt(cells.pressure**2 + found.geometry**2 + found.interior**2))
        least = LEAST_SHARE * pressure
        return replace(
            found,
            pressure=pressure,
            peak=found.peak if found.unbounded else max(cells.peak, least, AT_KINKS * found.geometry),
            area=max(cells.area, least),
            faces_across=cells.faces_across,
        )


def cell_contact(contact: ContactFields) -> CellContact | None:
    """The pressure on the cells of a half-space that is the slave of a contact; None for other slaves."""
    if not is_half_space(contact.surface):
        return None
    surface = cast(GridSurface, contact.surface)
    own, grid = contact.slave.pose.to_body(contact.points)[:, :2], surface.cells
    place = np.rint((own - [grid.x[0], grid.y[0]]) / grid.cell).astype(np.int64).T
    pressure, gap = np.zeros(grid.shape), np.full(grid.shape, np.inf)
    pressure[tuple(place)], gap[tuple(place)] = contact.pressure, contact.gap
    return CellContact(surface, place, pressure, gap, edge_cells(pressure, gap, surface.periodic))


def is_half_space(surface: Surface) -> bool:
    """Whether a surface is the grid of a half-space, not the window of a local body."""
    return has_cells(surface) and not cast(GridSurface, surface).is_window
