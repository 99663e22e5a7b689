"""Area and errors of a contact whose slave is a half-space: those of its cells, as of the half-space alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import numpy as np

from fecontact.bodies.halfspace import HalfSpace
from fecontact.common.arrays import Array, IntArray
from fecontact.common.error_estimate import ErrorEstimate
from fecontact.halfspace.grid import GridSurface
from fecontact.halfspace.grid_error import MIN_SHARE, EdgeCells, cells_error_estimate, edge_area, edge_cells
from fecontact.results.error_estimate import AT_KINKS
from fecontact.surfaces.facet_surface import Surface, has_cells

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields

#: All cells of a grid.
WHOLE = (slice(None), slice(None))


@dataclass(frozen=True, eq=False)
class CellContact:
    """Pressure of a contact on the cells of a half-space.

    Attributes
    ----------
    contact : ContactFields
    surface : GridSurface
    place : (2, n) int array
        Cell of each contact point.
    pressure : (nx, ny) array
    gap : (nx, ny) array
        Infinite where there is no counter-surface.
    edge : EdgeCells
    """

    contact: ContactFields
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

    @property
    def stick_area(self) -> float:
        """Area that sticks, its edge located within the cells, as `FrictionContact.stick_area`."""
        contact, friction = self.contact, self.contact.friction
        if friction is None or contact.stick is None:
            return 0.0 if friction is None else friction.point_stick_area
        count = int(friction.sticking.sum())
        if count == 0 or not friction.sliding.any():
            return contact._whole.area if count else 0.0
        reserve, slip = np.zeros(self.pressure.shape), np.where(np.isfinite(self.gap), 0.0, np.inf)
        reserve[tuple(self.place)] = contact.stick.pressure
        slip[tuple(self.place)] = np.where(friction.sliding, np.linalg.norm(friction.slip, axis=1), 0.0)
        found = edge_area(edge_cells(reserve, slip, self.surface.periodic), count)[0] * self.surface.cell_area
        return min(found, contact._whole.area)

    def estimate(self, found: ErrorEstimate) -> ErrorEstimate:
        """An estimate with the errors of the cells in place of those of facets between their centres."""
        contact, surface = self.contact, self.surface
        coarse, part = None, WHOLE
        if contact._cell_problem is not None and not found.reason:
            cells = np.ravel_multi_index(tuple(self.place[:, contact._candidates]), self.pressure.shape)
            coarse, part = cast(HalfSpace, contact.slave).coarse_pressure(cells, contact._cell_problem)
        arrays = (surface.cells, self.pressure, self.gap, coarse, part, self.edge)
        of_cells = cells_error_estimate(*arrays, surface.point_forces)
        if of_cells.reason or found.reason:
            return found
        pressure = float(np.sqrt(of_cells.pressure**2 + found.geometry**2 + found.interior**2))
        unbounded = found.unbounded
        if unbounded is None and of_cells.unbounded is not None:
            x, y, z = contact.slave.pose.to_world(np.array([of_cells.unbounded.point]))[0]
            unbounded = of_cells.unbounded._replace(body=contact.master.name, point=(float(x), float(y), float(z)))
        return replace(
            of_cells,
            pressure=pressure,
            geometry=found.geometry,
            interior=float(np.hypot(of_cells.interior, found.interior)),
            peak=np.inf if unbounded else max(of_cells.peak, MIN_SHARE * pressure, AT_KINKS * found.geometry),
            area=max(of_cells.area, MIN_SHARE * pressure),
            unbounded=unbounded,
        )


def cell_contact(contact: ContactFields) -> CellContact | None:
    """The pressure on the cells of a half-space that is the slave of a contact; None for other slaves."""
    if not is_half_space(contact._surface):
        return None
    surface = cast(GridSurface, contact._surface)
    own, grid = contact.slave.pose.to_body(contact.points)[:, :2], surface.cells
    place = np.rint((own - [grid.x[0], grid.y[0]]) / grid.cell).astype(np.int64).T
    pressure, gap = np.zeros(grid.shape), np.full(grid.shape, np.inf)
    pressure[tuple(place)], gap[tuple(place)] = contact.pressure, contact.gap
    return CellContact(contact, surface, place, pressure, gap, edge_cells(pressure, gap, surface.periodic))


def is_half_space(surface: Surface) -> bool:
    """Whether a surface is the grid of a half-space, not the window of a local body."""
    return has_cells(surface) and not cast(GridSurface, surface).is_window
